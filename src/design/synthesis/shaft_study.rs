//! What an elastic input shaft makes of a profile and of the standard laws.

use super::deviation;
use super::laws::{Rival, truncated};
use super::shaft::{Shaft, ShaftGoal};
use crate::drives::cam_drive::{DriveMode, Start, StartMode};
use crate::drives::elastic_shaft::{ElasticShaft, Scene};
use crate::drives::solver::Settings;
use crate::drives::{Drive, Fault};
use crate::motion::{Fourier, MotionLaw};

/// Speeds of a curve.
const SPEEDS: usize = 41;

/// Harmonics of a standard law here: those of the torque fall as k⁻³, and the shaft does not follow the high ones.
const HARMONICS: usize = 32;

/// Magnifications whose first speed is told.
const LIMITS: [f64; 2] = [1.5, 2.0];

/// The figures of one law.
#[derive(Clone, Debug, PartialEq)]
pub struct Magnified {
    /// Ω [rad/s], max |M| [N·m], and that over its kinetostatic value m Ω² max |U′U″|.
    pub points: Vec<[f64; 3]>,
    /// The first speed at which the magnification exceeds 1.5, and 2 [rad/s]; None within the range.
    pub exceeded: [Option<f64>; 2],
}

/// An elastic shaft with a profile and the standard laws.
#[derive(Clone, Debug, PartialEq)]
pub struct Shafted {
    /// The goal, in SI.
    pub goal: ShaftGoal,
    /// One for each rival.
    pub laws: Vec<Magnified>,
    /// M(φ) of each rival at the fastest speed; None where it has no steady motion.
    pub torques: Vec<Option<Fourier>>,
    /// Speeds at which the steady motion of the cam is unstable or missing, and why.
    pub faults: Vec<(f64, String)>,
}

/// The study of the profile, which is the first rival, and of the others.
pub fn study(goal: ShaftGoal, rivals: &[Rival]) -> Shafted {
    let speeds = goal.speeds(SPEEDS);
    let laws: Vec<Fourier> = rivals.iter().map(|rival| truncated(&rival.series, HARMONICS)).collect();
    let unstable = |w: &f64| starts(&goal.shaft, &laws[0], *w).err().map(|fault| (*w, fault.0));
    let fastest = |law: &Fourier| goal.shaft.steady(law, goal.fastest, None).map(|steady| steady.torque);
    Shafted {
        laws: laws.iter().zip(rivals).map(|(law, rival)| magnified(&goal.shaft, law, rival.torque, &speeds)).collect(),
        torques: laws.iter().map(fastest).collect(),
        faults: speeds.iter().filter_map(unstable).collect(),
        goal,
    }
}

/// `torque` is max |U′U″| of the law itself: a series of a law whose U″ jumps overshoots.
fn magnified(shaft: &Shaft, law: &Fourier, torque: f64, speeds: &[f64]) -> Magnified {
    let rigid = shaft.m * torque;
    let peak = |w: f64| match shaft.steady(law, w, None) {
        Some(steady) => deviation::peak(&steady.torque, 0).value.abs(),
        None => f64::INFINITY,
    };
    let point = |w: &f64| {
        let peak = peak(*w);
        [*w, peak, peak / (rigid * w * w)]
    };
    let points: Vec<[f64; 3]> = speeds.iter().map(point).collect();
    let first = |limit: f64| {
        let i = points.iter().position(|p| p[2] > limit)?;
        if i == 0 {
            return Some(points[0][0]);
        }
        // Between two points of the curve by halves, to a millionth of the speed.
        let (mut low, mut high) = (points[i - 1][0], points[i][0]);
        while high - low > 1e-6 * high {
            let middle = 0.5 * (low + high);
            if peak(middle) > limit * rigid * middle * middle { high = middle } else { low = middle }
        }
        Some(high)
    };
    Magnified { exceeded: LIMITS.map(first), points }
}

/// Whether the drive itself, linear, starts on its periodic motion: it refuses one that does not attract.
fn starts(shaft: &Shaft, law: &Fourier, w: f64) -> Result<ElasticShaft, Fault> {
    steady_drive(shaft, law, w, true)
}

/// The drive on its periodic motion.
pub fn steady_drive(shaft: &Shaft, law: &Fourier, w: f64, linear: bool) -> Result<ElasticShaft, Fault> {
    let mut drive = ElasticShaft::new(Scene {
        m: shaft.m,
        inertia: shaft.inertia,
        c: shaft.c,
        b: shaft.b,
        linear,
        cam: MotionLaw::Fourier(law.clone()),
        drive: DriveMode::Constant { w, phi_start: 0.0 },
        start: Start { mode: StartMode::SteadyState, q: 0.0, q_dot: 0.0 },
        solver: Settings::default(),
    })?;
    drive.start(0.0)?;
    Ok(drive)
}
