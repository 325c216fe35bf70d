//! Effect of an elastic input shaft on a profile and on the standard laws.

use super::deviation;
use super::laws::{Rival, truncated};
use super::shaft::{Shaft, ShaftGoal};
use crate::resource::Scene;
use crate::search;
use crate::study::measure::{Kind, Measure};
use crate::study::run::{Span, Window};
use crate::study::single::Runner;
use camdrive::drives::elastic_shaft;
use camdrive::drives::settings::Settings;
use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use camdrive::drives::{AnyDrive, Fault};
use camdrive::motion::{Fourier, MotionLaw};

/// Speeds of a curve, at which resonances look round.
const SPEEDS: usize = 161;

/// Every so many of them the drive itself, linear, is asked whether its motion is stable, and the nonlinear one for its
/// torque, which takes some ten times as long.
const STABLE_EVERY: usize = 4;
const NONLINEAR_EVERY: usize = 16;

/// How well the largest torque of the drive is found, relative to it.
const ACCURACY: f64 = 1e-6;

/// Harmonics of a standard law here: harmonics of the torque fall as k⁻³, and the shaft does not follow the high ones.
const HARMONICS: usize = 32;

/// Magnifications whose first speed is reported.
const LIMITS: [f64; 2] = [1.5, 2.0];

/// The figures of one law.
#[derive(Clone, Debug, PartialEq)]
pub struct Magnified {
    /// Ω (rad/s), max |M| (N·m), and that over its kinetostatic value m Ω² max |U′U″|.
    pub points: Vec<[f64; 3]>,
    /// The first speed at which the magnification exceeds 1.5, and 2 (rad/s); None within the range.
    pub exceeded: [Option<f64>; 2],
}

/// An elastic shaft with a profile and the standard laws.
#[derive(Clone, Debug, PartialEq)]
pub struct Shafted {
    /// The goal, in SI.
    pub goal: ShaftGoal,
    /// One for each rival.
    pub laws: Vec<Magnified>,
    /// M(φ) of each rival at the fastest speed; None where it has no periodic motion.
    pub torques: Vec<Option<Fourier>>,
    /// Speeds at which the periodic motion of the cam is unstable or missing, and why.
    pub faults: Vec<(f64, String)>,
    /// The profile on the nonlinear drive.
    pub nonlinear: Vec<Nonlinear>,
}

/// The profile on the nonlinear drive at one speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Nonlinear {
    /// Ω (rad/s).
    pub w: f64,
    /// max |M| of the linear drive (N·m).
    pub linear: f64,
    /// max |M| of the nonlinear one (N·m), or why it has no periodic motion that attracts.
    pub torque: Result<f64, String>,
}

impl Nonlinear {
    /// Relative difference of the torque of the nonlinear drive from the linear one's.
    pub fn difference(&self) -> Option<f64> {
        self.torque.as_ref().ok().map(|torque| torque / self.linear - 1.0)
    }
}

/// The study of the profile, which is the first rival, and of the others.
pub fn study(goal: ShaftGoal, rivals: &[Rival]) -> Shafted {
    let speeds = goal.speeds(SPEEDS);
    let laws: Vec<Fourier> = rivals.iter().map(|rival| truncated(&rival.series, HARMONICS)).collect();
    let checked = |every: usize| speeds.iter().copied().step_by(every);
    let unstable =
        |w: f64| on_periodic_motion(&goal.shaft, &laws[0], w, true).err().map(|fault| (w, fault.to_string()));
    let nonlinear = |w: f64| Nonlinear {
        w,
        linear: peak(&goal.shaft, &laws[0], w),
        torque: on_periodic_motion(&goal.shaft, &laws[0], w, false)
            .and_then(|mut drive| largest_torque(&mut drive))
            .map_err(|fault| fault.to_string()),
    };
    let fastest = |law: &Fourier| goal.shaft.periodic_torque(law, goal.fastest, None).map(|motion| motion.torque);
    Shafted {
        laws: laws.iter().zip(rivals).map(|(law, rival)| magnified(&goal.shaft, law, rival.torque, &speeds)).collect(),
        torques: laws.iter().map(fastest).collect(),
        faults: checked(STABLE_EVERY).filter_map(unstable).collect(),
        nonlinear: checked(NONLINEAR_EVERY).map(nonlinear).collect(),
        goal,
    }
}

/// `torque` is max |U′U″| of the law itself: a series of a law whose U″ jumps overshoots.
pub(super) fn magnified(shaft: &Shaft, law: &Fourier, torque: f64, speeds: &[f64]) -> Magnified {
    let rigid = shaft.m * torque;
    let peak = |w: f64| peak(shaft, law, w);
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
        let mut excess = |w: f64| (peak(w) / (limit * rigid * w * w)).min(f64::MAX) - 1.0;
        let values = [&points[i - 1], &points[i]].map(|p| (p[2] / limit).min(f64::MAX) - 1.0);
        Some(search::zero(&mut excess, [points[i - 1][0], points[i][0]], values, 1e-6 * points[i][0]))
    };
    Magnified { exceeded: LIMITS.map(first), points }
}

/// max |M| of the linear drive (N·m); infinite where it has no periodic motion.
fn peak(shaft: &Shaft, law: &Fourier, w: f64) -> f64 {
    shaft.periodic_torque(law, w, None).map_or(f64::INFINITY, |motion| deviation::peak(&motion.torque, 0).value.abs())
}

/// max |M| over the next turn of the drive itself (N·m).
pub fn largest_torque(drive: &mut AnyDrive) -> Result<f64, Fault> {
    let window = Window { settle: Span::Turns(0.0), over: Span::Turns(1.0), accuracy: ACCURACY };
    let measures = [Measure { kind: Kind::Magnitude, output: "tau".to_owned() }];
    Ok(Runner::new(drive, &window, &measures)?.run(drive)?[0])
}

/// The drive on its periodic motion: it refuses one that does not attract.
pub fn on_periodic_motion(shaft: &Shaft, law: &Fourier, w: f64, linear: bool) -> Result<AnyDrive, Fault> {
    let scene = elastic_shaft::Scene {
        load: Default::default(),
        parameters: elastic_shaft::Parameters { m: shaft.m, inertia: shaft.inertia, c: shaft.c, b: shaft.b },
        linear,
        cam: MotionLaw::Fourier(law.clone()),
        drive: DriveMode::Constant { w, phi_start: 0.0 },
        start: Start { mode: StartMode::SteadyState, q: 0.0, q_dot: 0.0 },
        solver: Settings::default(),
    };
    let mut drive = Scene::from(scene).build()?.plan().instance();
    drive.set_up(0.0, None);
    drive.start()?;
    Ok(drive)
}

#[cfg(test)]
mod tests {
    use super::super::study::symmetric_task;
    use super::super::{Objective, laws};
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_limit_speeds_of_known_laws() {
        // The transfer manipulator in strokes. The printed speeds lie on a grid of 0.0025 ω₀ with a magnification
        // above 1.5 and above 2.
        const W0: f64 = 80.66;
        const GRID: f64 = 0.0025;
        let shaft = Shaft { m: 9.6, inertia: 1.5, c: 2.4e4, b: 17.85 };
        let speeds: Vec<f64> = (11..=60).map(|i| f64::from(i) * GRID * W0).collect();
        let task = |order| symmetric_task(order, PI / 6.0, Objective::Chebyshev);
        let hs = |order| laws::as_rival("hs", &task(order).solve().unwrap().series);
        let rivals = laws::rivals(&task(3));
        let named = |name: &str| rivals.iter().find(|r| r.name == name).unwrap().clone();
        for (law, printed) in [
            (hs(3), [0.0825, 0.100]),
            (hs(5), [0.050, 0.0625]),
            (named("inclined_sine"), [0.060, 0.075]),
            (named("polynomial_345"), [0.075, 0.0875]),
            (named("modified_sine"), [0.085, 0.1025]),
            (named("modified_trapezoid"), [0.040, 0.0475]),
            (named("simple_sine"), [0.100, 0.145]),
        ] {
            let series = truncated(&law.series, HARMONICS);
            let exceeded = magnified(&shaft, &series, law.torque, &speeds).exceeded;
            for (found, printed) in exceeded.into_iter().zip(printed) {
                let found = found.unwrap() / W0;
                assert!(
                    (printed - GRID - 1e-6..=printed + 1e-6).contains(&found),
                    "{}: {found} instead of {printed}",
                    law.name
                );
            }
        }
    }
}
