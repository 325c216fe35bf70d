//! The linear oscillation of a drive whose coefficients repeat every turn.

use crate::resource::Scene;
use crate::search;
use camdrive::drives::Fault;
use camdrive::drives::elastic_shaft;
use camdrive::drives::parametric;
use camdrive::drives::parametric::coefficients::Coefficients;
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::unit::{self, Quantity};
use camdrive::motion::{MotionLaw, turn};
use std::f64::consts::TAU;

/// Breakpoints that lie closer together (rad) count as one: the piece between them would be lost in rounding.
const SAME: f64 = 1e-12;

/// The note on an input.
const INPUT: &str = "The input F is set to 0.";

/// The note on a shaft that is not linear.
pub const LINEARISED: &str =
    "The drive is not linear. Orders, starts from rest, resonances and maps hold for its linearisation about q = 0.";

/// m(φ) q̈ + [b(φ) + Ω b₁(φ)] q̇ + [c(φ) + Ω c₁(φ) + Ω² c₂(φ)] q = f(φ) + Ω f₁(φ) + Ω² f₂(φ) at φ = Ω t, one degree of freedom q.
///
/// Either b₁ = c₂ = 0, or the inertia turns with the drive: b₁ = m′ and c₂ = m″/2, from the kinetic energy ½ m ψ̇² with m at ψ
/// = φ + q. c₁ and f₁ belong to dampers and grow with b.
pub struct PeriodicOscillator {
    /// The coefficients at an angle (rad) in [−2π, 2π], continued smoothly from a segment.
    pub terms: Box<dyn Fn(usize, f64) -> Terms + Send + Sync>,
    /// The angles in [0, 2π), ascending, at which a derivative of a coefficient jumps. Segment i reaches from
    /// breakpoint i to the next one, the last one around the turn; without breakpoints there is one segment.
    pub breakpoints: Vec<f64>,
    /// An angle (rad) over which the coefficients of a segment follow a polynomial of degree 8.
    pub reach: Box<dyn Fn(usize) -> f64 + Send + Sync>,
    /// Cost of the coefficients at an angle (nominal µs), see [`camdrive::numerics::work`].
    pub cost: f64,
    /// True if b₁ = m′ and c₂ = m″/2.
    pub inertia_turns: bool,
    /// b and c of the drive's own spring and damper at an angle (rad), if others act as well.
    pub own: Option<Angular>,
    /// The speed Ω of the scene (rad/s); None if the drive follows its inputs.
    pub speed: Option<f64>,
    /// The angle at which the scene starts (rad).
    pub start: f64,
    /// Quantity of q.
    pub coordinate: &'static Quantity,
    /// Quantity of c q.
    pub load: &'static Quantity,
    /// The simplification of the scene's equation, if any: "linearised about q = 0".
    pub note: Option<String>,
}

/// Two values over the angle (rad).
type Angular = Box<dyn Fn(f64) -> [f64; 2] + Send + Sync>;

/// The coefficients of [`PeriodicOscillator`] at an angle, coherent SI.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Terms {
    /// m (kg or kg·m²).
    pub m: f64,
    /// b (N·s/m or N·m·s/rad).
    pub b: f64,
    /// b₁ (kg/rad or kg·m²/rad).
    pub b1: f64,
    /// c (N/m or N·m/rad).
    pub c: f64,
    /// c₁ (N·s/m/rad or N·m·s/rad²).
    pub c1: f64,
    /// c₂ (kg/rad² or kg·m²/rad²).
    pub c2: f64,
    /// f (N or N·m).
    pub f: f64,
    /// f₁ (N·s or N·m·s).
    pub f1: f64,
    /// f₂ (kg·m or kg·m²).
    pub f2: f64,
}

/// The drive of a scene as an oscillator with periodic coefficients, linearised if necessary.
///
/// # Errors
/// Other models.
pub fn of(scene: &Scene) -> Result<PeriodicOscillator, Fault> {
    match scene {
        Scene::ElasticShaft(scene) => Ok(of_shaft(scene)),
        Scene::ParametricDrive(scene) => Ok(of_coefficients(scene)),
        other => {
            let hint = match other {
                Scene::RigidMachine(_) | Scene::DriveTrain(_) => {
                    "write a follower of a machine or a train as a scene of its own"
                }
                _ => "its coefficients do not vary over the turn; `camdrive steady` finds its resonances",
            };
            Err(Fault::new(format!(
                "{} is not an oscillator with periodic coefficients; ElasticCamDrive with an elastic input shaft and \
                 ParametricDrive are",
                other.model()
            ))
            .hint(hint))
        }
    }
}

/// The speed (rad/s), if it is constant, and the angle (rad) of the start.
fn turning(drive: &DriveMode) -> (Option<f64>, f64) {
    match *drive {
        DriveMode::Constant { w, phi_start } => (Some(w), phi_start),
        DriveMode::Input | DriveMode::Speed { .. } => (None, 0.0),
    }
}

/// The breakpoints of a law and of a process force together, and the segments of both in each piece.
pub(crate) fn joined(own: &[f64], process: Option<&MotionLaw>) -> (Vec<f64>, Vec<[usize; 2]>) {
    let process = process.map_or(&[][..], MotionLaw::breakpoints);
    let mut breakpoints = [own, process].concat();
    breakpoints.sort_by(f64::total_cmp);
    breakpoints.dedup_by(|b, a| *b - *a <= SAME);
    let pieces = search::segments(&breakpoints).into_iter();
    let middles = pieces.map(|[low, high]| (0.5 * (low + high)).rem_euclid(TAU));
    let segments = middles.map(|middle| [own, process].map(|list| turn::segment(list, middle, true))).collect();
    (breakpoints, segments)
}

/// J(φ) q̈ + (b + Ω J′) q̇ + (c + Ω² J″/2) q = −Ω² J′/2, J(φ) = J + m U′².
///
/// Under a load, F = F_L(U, 0, φ) without an input: b += b_r U′², c += c_r U′² − U″F, c₁ = b_r (U′²)′, f = U′F, f₁ = −b_r U′².
///
/// Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.3 (1); J(φ) gathers its terms.
pub fn of_shaft(scene: &elastic_shaft::Scene) -> PeriodicOscillator {
    let elastic_shaft::Parameters { m, inertia, c, b } = scene.parameters;
    let (law, load, process) = (scene.cam.clone(), scene.load.clone(), scene.load.process.clone());
    let (breakpoints, segments) = joined(law.breakpoints(), process.as_ref());
    let resolution = |[own, of_process]: &[usize; 2]| {
        let process = process.as_ref().map_or(1.0, |process| process.resolution_in(*of_process));
        elastic_shaft::REACH / law.resolution_in(*own).max(process)
    };
    let reaches: Vec<f64> = segments.iter().map(resolution).collect();
    let cost = law.cost() + process.as_ref().map_or(0.0, MotionLaw::cost);
    let terms = move |segment: usize, phi: f64| {
        let [own, of_process] = segments[segment];
        let [u, u1, u2, u3, _] = law.at_in(own, phi).0;
        let (g, g1) = (m * u1 * u2, m * (u2 * u2 + u1 * u3));
        let terms = Terms { m: inertia + m * u1 * u1, b, b1: 2.0 * g, c, c2: g1, f2: -g, ..Terms::default() };
        if load.is_none() {
            return terms;
        }
        let process = load.process.as_ref().map(|process| process.at_in(of_process, phi).0[0]);
        let (force, damping) = (load.force(m, [u, 0.0], process, None), load.damping.unwrap_or(0.0));
        let stiffness = load.stiffness() * u1 * u1 - u2 * force;
        let [by_speed, slope] = [u1 * u1, 2.0 * u1 * u2].map(|x| damping * x);
        Terms { b: b + by_speed, c: c + stiffness, c1: slope, f: u1 * force, f1: -by_speed, ..terms }
    };
    let (speed, start) = turning(&scene.drive);
    PeriodicOscillator {
        terms: Box::new(terms),
        breakpoints,
        reach: Box::new(move |segment| reaches[segment]),
        cost,
        inertia_turns: true,
        own: (!scene.load.is_none()).then(|| Box::new(move |_| [b, c]) as Angular),
        speed,
        start,
        coordinate: &unit::ANGLE,
        load: &unit::TORQUE,
        note: {
            let linearised = (!scene.linear).then_some(LINEARISED);
            let notes: Vec<&str> = linearised.into_iter().chain(scene.load.input.then_some(INPUT)).collect();
            (!notes.is_empty()).then(|| notes.join(" "))
        },
    }
}

/// The turn divided so that [`Coefficients::reach`] covers each piece: its beginning, in [0, 2π), and its length (rad). Empty
/// if no zero of m and no pole of c is near and one reach serves the whole turn.
fn pieces(coefficients: &Coefficients) -> Vec<(f64, f64)> {
    let mut pieces = Vec::new();
    let mut phi = 0.0;
    while coefficients.least_reach() < 0.5 / coefficients.order().max(1) as f64 && phi < TAU {
        let length = coefficients.reach(phi).min(TAU - phi);
        pieces.push((phi, length));
        phi += length;
    }
    pieces
}

/// m(φ) q̈ + b(φ) q̇ + c(φ) q = f(φ).
///
/// Under a load, F = F_L without an input at q = q̇ = 0: b += b_r, c += c_r, f += F; if q counts from the drive, f₁ = −b_r.
pub fn of_coefficients(scene: &parametric::Scene) -> PeriodicOscillator {
    let coefficients = scene.law.coefficients();
    let (load, process, relative) = (scene.load.clone(), scene.load.process.clone(), scene.law.is_relative());
    let least = coefficients.least_reach();
    let cost = coefficients.cost() + process.as_ref().map_or(0.0, MotionLaw::cost);
    let (starts, reaches) = pieces(&coefficients).into_iter().unzip::<f64, f64, Vec<f64>, Vec<f64>>();
    let (breakpoints, segments) = joined(&starts, process.as_ref());
    let reach = |[own, of_process]: &[usize; 2]| {
        let process =
            process.as_ref().map_or(f64::INFINITY, |law| elastic_shaft::REACH / law.resolution_in(*of_process));
        reaches.get(*own).copied().unwrap_or(least).min(process)
    };
    let reaches: Vec<f64> = segments.iter().map(reach).collect();
    let (speed, start) = turning(&scene.drive);
    let coordinate = scene.law.coordinate();
    let own = coefficients.clone();
    PeriodicOscillator {
        terms: Box::new(move |segment, phi| {
            let values = coefficients.at(phi);
            let terms = Terms { m: values.m[0], b: values.b[0], c: values.c[0], f: values.f[0], ..Terms::default() };
            if load.is_none() {
                return terms;
            }
            let process = load.process.as_ref().map(|law| law.at_in(segments[segment][1], phi).0[0]);
            let (force, damping) = (load.force(terms.m, [0.0; 2], process, None), load.damping.unwrap_or(0.0));
            let f1 = if relative { -damping } else { 0.0 };
            Terms { b: terms.b + damping, c: terms.c + load.stiffness(), f: terms.f + force, f1, ..terms }
        }),
        breakpoints,
        reach: Box::new(move |segment| reaches[segment]),
        cost,
        inertia_turns: false,
        own: (!scene.load.is_none()).then(|| {
            Box::new(move |phi| {
                let values = own.at(phi);
                [values.b[0], values.c[0]]
            }) as Angular
        }),
        speed,
        start,
        coordinate: parametric::quantities(coordinate)[0],
        load: parametric::of_coefficients(coordinate)[3],
        note: scene.load.input.then(|| INPUT.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use camdrive::drives::parametric::coefficients::Stiffness;
    use camdrive::drives::parametric::crank::{ParallelCrank, SecondCrank};
    use camdrive::motion::Fourier;

    #[test]
    fn pieces_are_as_long_as_the_coefficients_reach() {
        let constant = |value: f64| Fourier::new(vec![value], Vec::new());
        // σ = c₁₂/(c_AB R²) = 1e-8.
        let crank = ParallelCrank { c_t1: 2.0, c_t2: 2.0, c_ab: 1e8, r: 1.0, second: SecondCrank::None };
        let c = Stiffness::of_crank(&crank);
        let mut coefficients = Coefficients { m: constant(1.0), b: constant(0.0), c, f: constant(0.0) };
        let whole = pieces(&coefficients);
        let ends: f64 = whole.iter().map(|piece| piece.1).sum();
        assert!((ends - TAU).abs() < 1e-12 && whole.len() < 300 && whole[0] == (0.0, coefficients.reach(0.0)));
        coefficients.c = Stiffness::Series(constant(1.0));
        assert!(pieces(&coefficients).is_empty());
    }
}
