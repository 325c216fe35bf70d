//! All periodic motions of a machine: what a design needs to know beside the one that `steady` starts with.
//!
//! E(0) → E(2π) is a monotone scalar map whose fixed points are the periodic motions. Its gain g(E) = E(2π) − E(0) is
//! scanned over the speeds; where |g| has a minimum between two samples without a change of sign, golden sections decide
//! whether two motions lie there. With a lagging torque each is continued to the map of two dimensions.
//!
//! A disturbance grows by dδE/dψ = (∂N/∂E) δE, N = σ(M_an − τ), ∂N/∂E = M_an′(ω)/(Jω), so that the multiplier of a motion,
//! the slope of the map, is exp ∮ M_an′(ω)/(Jω) dψ: positive, however steep the characteristic. Motions that disturbances
//! leave are followed backwards, where disturbances come back to them.

use super::inertia::Inertia;
use super::place::Place;
use super::steady::{PERIODIC_TOLERANCE, ROUNDING, SCAN_TOLERANCE, Shooting};
use super::steady_lag::Turn;
use super::torques::Torques;
use super::{Kloss, MachineStart, Motor, RigidMachine, Scene};
use crate::drives::{Drive as _, Fault};
use crate::numerics::gauss::Gauss;
use std::f64::consts::TAU;

/// A periodic motion in which the shaft turns all around.
#[derive(Clone, Debug, PartialEq)]
pub struct PeriodicMotion {
    /// T (s).
    pub period: f64,
    /// E = ½Jω² (J) at φ = 0.
    pub energy: f64,
    /// ln of the factor by which a small disturbance grows in a turn, of the largest Floquet multiplier's modulus.
    pub growth: f64,
    /// M_an (N·m) at φ = 0.
    pub torque: f64,
    /// φ (rad) and ω (rad/s) over the turn.
    pub course: Vec<[f64; 2]>,
}

impl PeriodicMotion {
    /// By which factor a small disturbance grows in a turn; beyond all numbers where the motor is steep.
    pub fn multiplier(&self) -> f64 {
        self.growth.exp()
    }

    /// Whether small disturbances decay.
    pub fn is_stable(&self) -> bool {
        self.growth < 0.0
    }
}

/// The least and the largest ω (rad/s) of a course: the vertices of the parabolas through its extreme points and their
/// neighbours.
pub fn range(course: &[[f64; 2]]) -> [f64; 2] {
    let vertex = |three: &[[f64; 2]]| -> Option<f64> {
        let [[x0, y0], [x1, y1], [x2, y2]] = three else { return None };
        let extreme = (y1 - y0) * (y1 - y2) >= 0.0 && y0 != y2;
        let (left, right) = ((y1 - y0) / (x1 - x0), (y2 - y1) / (x2 - x1));
        let bend = (right - left) / (x2 - x0);
        // The slope at the middle point.
        let slope = left + bend * (x1 - x0);
        (extreme && bend != 0.0).then(|| y1 - slope * slope / (4.0 * bend))
    };
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    let points = course.iter().map(|at| at[1]);
    points.chain(course.windows(3).filter_map(vertex)).fold(ends, |[low, high], w| [low.min(w), high.max(w)])
}

/// Speeds of the scan, from a little above the fastest possible motion down to two thousandths of it, equally spaced in the
/// logarithm: two per cent apart.
const SCAN: usize = 320;
const SLOWEST: f64 = 2e-3;

/// Points of the course of a motion.
const POINTS: usize = 720;

/// Two periods are those of one motion when they agree to this part, far above the tolerance of the periodic motions; different
/// motions differ by the slip of the motor.
const SAME: f64 = 1e-9;

/// All periodic motions of the machine against a constant load, the fastest first.
///
/// # Errors
/// Where the motor has no characteristic, or the machine cannot be built.
pub fn periodic_motions(scene: &Scene, load: f64) -> Result<Vec<PeriodicMotion>, Fault> {
    all_motions(scene, load).map(|motions| motions.found)
}

/// The periodic motions, and what is known of those that could not be found.
#[derive(Clone, Debug, PartialEq)]
pub struct Motions {
    /// The fastest first.
    pub found: Vec<PeriodicMotion>,
    /// T (s) of those motions of the machine whose motor follows at once that could not be continued to the lagging torque:
    /// it has none there, or one that disturbances leave so fast that a turn forgets where it began.
    pub lost: Vec<f64>,
}

/// See [`periodic_motions`], which yields those that are found.
///
/// # Errors
/// Those of [`periodic_motions`].
pub fn all_motions(scene: &Scene, load: f64) -> Result<Motions, Fault> {
    let Motor::Kloss(Kloss { breakdown_slip, breakdown_torque, synchronous_speed, .. }) = scene.motor else {
        return Err(Fault::new("a torque that does not depend on the speed selects no periodic motion"));
    };
    let mut machine = RigidMachine::new(Scene {
        start: MachineStart::Given,
        phi_start: 0.0,
        w_start: synchronous_speed,
        ..scene.clone()
    })?;
    machine.place_at_start(synchronous_speed);
    let sense = synchronous_speed.signum();
    let torques = Torques::against(&machine.motor, load, sense);
    let samples = scan(&machine, torques, breakdown_slip, synchronous_speed)?;
    let search = Search {
        ahead: Shooting::new(&machine, torques, PERIODIC_TOLERANCE, None)?,
        back: Shooting::new(&machine, torques.backwards(), PERIODIC_TOLERANCE, None)?,
        machine: &machine,
        load,
        breakdown_torque,
    };
    let (mut motions, mut lost, mut continued) = (Vec::new(), Vec::new(), Vec::new());
    for pair in samples.windows(2) {
        let [(above, gain_above), (below, gain_below)] = pair else { continue };
        let stable = *gain_above < 0.0 && *gain_below >= 0.0;
        let unstable = *gain_above >= 0.0 && *gain_below < 0.0;
        if !(stable || unstable) {
            continue;
        }
        // A machine that comes to rest ahead tells nothing of what lies between; the way back to it does.
        let shooting = if stable { &search.ahead } else { &search.back };
        let Some((start, period)) = shooting.refine((*below, *above), ROUNDING) else { continue };
        let Some(at_zero) = shooting.energy_at_start(start) else { continue };
        if machine.motor.lag().is_none() {
            motions.extend(search.without_lag(stable, start, at_zero.hi));
            continue;
        }
        match search.with_lag(at_zero.hi) {
            Some(motion) => continued.push((period, motion)),
            None => lost.push(period),
        }
    }
    // Newton's method may slide from a motion that disturbances leave fast to another one, which is then found twice.
    for (period, motion) in &continued {
        let nearer = |(other, same): &(f64, PeriodicMotion)| {
            (same.period / motion.period - 1.0).abs() < SAME
                && (other - motion.period).abs() < (period - motion.period).abs()
        };
        if continued.iter().any(nearer) {
            lost.push(*period);
        } else {
            motions.push(motion.clone());
        }
    }
    Ok(Motions { found: motions, lost })
}

/// Energies at the beginning of a turn, falling, with the part of each by which the turn raises it.
fn scan(machine: &RigidMachine, torques: Torques, slip: f64, synchronous: f64) -> Result<Vec<(f64, f64)>, Fault> {
    let (low, high) = machine.inertia.range();
    if !(low > 0.0) {
        return Err(Fault(format!(
            "the moment of inertia must be positive over the whole turn; its least value is {low} kg.m2"
        )));
    }
    // A load that drives the motor is held with at most the breakdown slip above the synchronous speed, or never.
    let fastest = synchronous.abs() * (1.0 + 4.0 * slip.max(0.25)) * (high / low).sqrt();
    let energy = |i: usize| 0.5 * high * (fastest * SLOWEST.powf(i as f64 / SCAN as f64)).powi(2);
    let scanning = Shooting::new(machine, torques, SCAN_TOLERANCE, None)?;
    let gain = |energy: f64| scanning.shoot(energy).map_or(f64::NEG_INFINITY, |shot| shot.gain / energy);
    let mut samples: Vec<(f64, f64)> = (0..=SCAN).map(energy).map(|e| (e, gain(e))).collect();
    let mut extra = Vec::new();
    for three in samples.windows(3) {
        let [(e0, g0), (_, g1), (e2, g2)] = three else { continue };
        let same = g0.signum() == g1.signum() && g1.signum() == g2.signum();
        if same && g1.is_finite() && g1.abs() <= g0.abs() && g1.abs() <= g2.abs() {
            extra.push(least(&gain, *e2, *e0));
        }
    }
    samples.extend(extra.into_iter().map(|e| (e, gain(e))));
    samples.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(samples)
}

/// A machine whose motions are looked for, ahead and backwards.
struct Search<'a> {
    machine: &'a RigidMachine,
    ahead: Shooting<'a>,
    back: Shooting<'a>,
    /// τ (N·m).
    load: f64,
    /// M_K (N·m).
    breakdown_torque: f64,
}

impl Search<'_> {
    /// The motion that begins the turn with the energy `start` and has `at_zero` at φ = 0 (J), of a motor that follows at once.
    fn without_lag(&self, stable: bool, start: f64, at_zero: f64) -> Option<PeriodicMotion> {
        let (shooting, way) = if stable { (&self.ahead, 1.0) } else { (&self.back, -1.0) };
        let (mut growth, sense) = (0.0, self.ahead.torques().sense);
        let shot = shooting.follow(start, |step| growth += way * step.log_growth(&shooting.torques()))?;
        let speed = sense * (2.0 * at_zero / self.machine.inertia_now()[0]).sqrt();
        let torque = self.machine.motor.characteristic(speed)[0];
        Some(PeriodicMotion {
            period: shot.period,
            energy: at_zero,
            growth,
            torque,
            course: shooting.course(start, POINTS),
        })
    }

    /// The motion with a lagging torque, continued from the energy `at_zero` (J).
    fn with_lag(&self, at_zero: f64) -> Option<PeriodicMotion> {
        let turn = Turn {
            inertia: &self.machine.inertia,
            motor: &self.machine.motor,
            tau: self.load,
            sense: self.ahead.torques().sense,
            phi_start: 0.0,
            interval: self.machine.state.interval,
            work: None,
        };
        let (motion, period) = turn.refine((2.0 * at_zero).sqrt(), self.breakdown_torque)?;
        let (growth, course) = turn.growth_and_course(motion, POINTS)?;
        Some(PeriodicMotion { period, energy: 0.5 * motion[0] * motion[0], torque: motion[1], growth, course })
    }
}

/// Where |gain| is least between two energies.
fn least(gain: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    // Sixty sections leave 3e-13 of the interval, less than a double root can be told from two.
    for _ in 0..60 {
        let (left, right) = (high - RATIO * (high - low), low + RATIO * (high - low));
        let (a, b) = (gain(left), gain(right));
        // A change of sign is what is looked for.
        if a.signum() != b.signum() {
            return if a.signum() == gain(low).signum() { right } else { left };
        }
        if a.abs() <= b.abs() {
            high = right;
        } else {
            low = left;
        }
    }
    0.5 * (low + high)
}

/// The motion of the machine without torques (Eigenbewegung) with the period T (s): J ω² = 2E = const,
/// √(2E) = ∮√J dφ / T; φ and ω over the turn.
pub fn free_motion(inertia: &Inertia, period: f64, sense: f64) -> Vec<[f64; 2]> {
    let rule = Gauss::with(16);
    let pieces: Vec<(Place, f64, f64)> = match inertia.borders().len() {
        0 => vec![(inertia.place(0), 0.0, TAU)],
        n => (0..n).map(|i| (inertia.place(i), inertia.ends(i).0, inertia.ends(i).1)).collect(),
    };
    let sum: f64 = pieces
        .iter()
        .map(|(place, from, to)| {
            // Sixteen nodes resolve half a wave of the finest harmonic to rounding.
            let n = ((to - from) * inertia.resolution() / 3.0).ceil().max(1.0) as usize;
            let width = (to - from) / n as f64;
            let part = |i: usize| {
                let [sum] = rule.integrate(width, |s| [inertia.at(*place, from + i as f64 * width + s)[0].sqrt()]);
                sum
            };
            (0..n).map(part).sum::<f64>()
        })
        .sum();
    let momentum = sense * sum / period;
    (0..=POINTS)
        .map(|i| {
            let phi = TAU * i as f64 / POINTS as f64;
            [phi, momentum / inertia.value(Place::at(phi), phi).sqrt()]
        })
        .collect()
}
