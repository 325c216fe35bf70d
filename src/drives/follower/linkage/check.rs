//! Whether a linkage can be assembled all around the turn, and its nearest approach to a position in which its output may go either
//! way.

use super::{FourBar, Kind, Linkage, Mechanism, decimals};
use crate::drives::Fault;
use crate::numerics::taylor::Series;
use std::f64::consts::TAU;

/// Smaller angles (rad) between coupler and output link, or between rod and the normal of the slider's line, count as singular:
/// derivatives of order n grow with its power 2n − 1, and those of order 4 would have no digit left.
const SINGULAR: f64 = 1e-3;

/// The nearest approach of a mechanism to a singular position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// φ (rad).
    pub phi: f64,
    /// The input angle θ (rad).
    pub input: f64,
    /// cos μ of the transmission angle μ; beyond ±1 the mechanism cannot be assembled.
    pub cosine: f64,
}

impl Extreme {
    /// μ (rad), at most π/2.
    pub fn transmission_angle(&self) -> f64 {
        self.cosine.abs().min(1.0).acos()
    }
}

impl Mechanism {
    /// Whether its output could go either way in some position.
    pub fn has_transmission_angle(&self) -> bool {
        !matches!(self.kind, Kind::Gear(_))
    }

    /// cos μ at θ; zero for a mechanism without such an angle.
    fn transmission_cosine(&self, theta: f64) -> f64 {
        match &self.kind {
            Kind::FourBar(linkage) => linkage.transmission_cosine(theta),
            Kind::SliderCrank(linkage) => linkage.rod_sine(theta),
            Kind::Gear(_) => 0.0,
        }
    }

    /// Refuses inadmissible dimensions.
    fn check_dimensions(&self, prefix: &str) -> Result<(), Fault> {
        let mut copy = *self;
        for (i, parameter) in self.parameters().into_iter().enumerate() {
            let value = copy.parameter_mut(i).map_or(0.0, |value| *value);
            if !parameter.kind.admits(value) {
                let name = format!("{prefix}.{}", parameter.name());
                let message = format!(" = {value}: it must be {}", parameter.kind.admissible());
                return Err(Fault::named(name, message));
            }
        }
        Ok(())
    }
}

impl Linkage {
    /// The number of turns of its output per turn of its input; None if it differs from turn to turn.
    pub fn turns(&self) -> Option<f64> {
        self.0.iter().try_fold(1.0, |turns: f64, mechanism| match &mechanism.kind {
            Kind::Gear(gear) => Some(turns * gear.ratio),
            _ if turns.fract() != 0.0 => None,
            Kind::FourBar(FourBar { ground, input, .. }) if input.length >= *ground => Some(turns),
            _ => Some(0.0),
        })
    }

    /// The highest ratio of the speeds of its gears to its input.
    pub fn step_up(&self) -> f64 {
        let ratio = |mechanism: &Mechanism| if let Kind::Gear(gear) = mechanism.kind { gear.ratio.abs() } else { 1.0 };
        self.0.iter().map(ratio).fold(1.0, |most, ratio| most * ratio.max(1.0))
    }

    /// For each mechanism the position in which cos μ is largest in size over a turn of the lever's angle `lever`, a function of φ
    /// sampled at so many `points`. The list ends with the first mechanism that cannot be assembled all around.
    pub fn extremes(&self, points: usize, lever: impl Fn(f64) -> f64) -> Vec<Extreme> {
        let step = TAU / points as f64;
        let mut extremes = Vec::with_capacity(self.0.len());
        for (i, mechanism) in self.0.iter().enumerate() {
            let at = |phi: f64| {
                let before = self.0[..i].iter();
                let input = before.fold(Series([lever(phi)]), |input, mechanism| mechanism.moved(input).0).value();
                let input = input + mechanism.input_offset;
                Extreme { phi, input, cosine: mechanism.transmission_cosine(input) }
            };
            let size = |phi: f64| at(phi).cosine.abs();
            let sampled: Vec<f64> = (0..points).map(|i| size(i as f64 * step)).collect();
            let peak = |i: &usize| {
                let neighbours = [(i + points - 1) % points, (i + 1) % points];
                neighbours.iter().all(|j| sampled[*i] >= sampled[*j])
            };
            let refined = (0..points).filter(peak).map(|i| summit(&size, (i as f64 - 1.0) * step, 2.0 * step));
            let worst = refined.map(at).max_by(|a, b| a.cosine.abs().total_cmp(&b.cosine.abs()));
            let Some(worst) = worst else { break };
            extremes.push(worst);
            if !(worst.cosine.abs() < 1.0) {
                break;
            }
        }
        extremes
    }

    /// Refuses dimensions that make no mechanism, and turns through positions in which a mechanism cannot be assembled or its
    /// output may go either way; `prefix` is the name of the linkage.
    pub fn check(&self, prefix: &str, points: usize, lever: impl Fn(f64) -> f64) -> Result<(), Fault> {
        for (i, mechanism) in self.0.iter().enumerate() {
            mechanism.check_dimensions(&format!("{prefix}[{}]", i + 1))?;
        }
        for (i, worst) in self.extremes(points, lever).into_iter().enumerate() {
            let Extreme { phi, input, cosine } = worst;
            if cosine.abs() < SINGULAR.cos() {
                continue;
            }
            let name = format!("{prefix}[{}]", i + 1);
            let place = format!(
                ": at phi = {} deg its input angle is {} deg, where",
                in_turn(phi, 4),
                decimals(input.to_degrees(), 4)
            );
            let reason = match (&self.0[i].kind, cosine.abs() <= 1.0) {
                (Kind::FourBar(_), true) => "coupler and output link lie in one line: the output may go either way",
                (Kind::FourBar(_), false) => "coupler and output link do not reach each other",
                (_, true) => "the rod is at right angles to the slider's line: the slider may go either way",
                (_, false) => "the rod does not reach the slider's line",
            };
            let message = format!("{place} {reason}; change its lengths or offsets, or the motion of the lever");
            return Err(Fault::named(name, message));
        }
        Ok(())
    }
}

/// φ of a turn in degrees; a full turn shows as 0 to these digits.
pub fn in_turn(phi: f64, digits: usize) -> String {
    let finest = 10f64.powi(digits as i32);
    decimals((phi.to_degrees() * finest).round().rem_euclid(360.0 * finest) / finest, digits)
}

/// The place of the maximum of f within the `width` from `low` on, by golden sections.
fn summit(f: &impl Fn(f64) -> f64, low: f64, width: f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut low, mut high) = (low, low + width);
    // 40 sections leave 4e-9 of the width; the error of the maximum of f is the square of that.
    for _ in 0..40 {
        let (left, right) = (high - RATIO * (high - low), low + RATIO * (high - low));
        if f(left) >= f(right) {
            high = right;
        } else {
            low = left;
        }
    }
    0.5 * (low + high)
}
