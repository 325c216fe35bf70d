//! The periodic motion of a machine or a train as a study: whether there is one, how it fluctuates, how fast disturbances decay.
//!
//! For comparison the motion of the machine without torques with the same period; without a motor it is all there is.

mod report;
mod tables;

pub use tables::spectra;

use crate::forces::report::LiftOff;
use crate::overview::{self, Overview, Resonance};
use crate::periodic_motions::{Motions, PeriodicMotion, all_motions, free_motion, periodic_motions, range};
use crate::periodic_turn::{self, Dwell, Harmonic, STANDS, Turn};
use crate::plot::Diagram;
use crate::report::Verdict;
use crate::resource::{Resource, Scene as AnyScene};
use crate::text;
use crate::transmission::{self, Transmission};
use camdrive::drives::Fault;
use camdrive::drives::rigid_machine::{Inertia, Kloss, Motor, Scene};
use serde::Serialize;
use std::f64::consts::TAU;

/// The periodic motions of a scene.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SteadyMotions {
    /// The scene.
    pub name: String,
    /// The load torque (N·m).
    pub load: f64,
    /// The motor; None without it and of a train.
    #[serde(skip)]
    pub motor: Option<Kloss>,
    /// The synchronous speed (rad/s) that yields a prescribed period.
    pub synchronous_speed: Option<f64>,
    /// The motions, the fastest first.
    pub motions: Vec<Motion>,
    /// See [`Motions::lost`].
    pub lost_periods: Vec<f64>,
    /// The motion of the machine without torques.
    pub without_torques: Option<Speeds>,
    /// Between cam and tool.
    pub mechanisms: Vec<Transmission>,
    /// The turn of the fastest stable motion, or of the only one.
    pub turn: Option<Turn>,
    /// The tools in the dwells of their laws.
    pub dwells: Vec<Dwell>,
    /// The strongest harmonics of the deformations.
    pub harmonics: Vec<Harmonic>,
    /// The nearest resonances.
    pub resonances: Vec<Resonance>,
    /// The speeds at which followers leave their cams.
    pub lift_offs: Option<Vec<LiftOff>>,
    /// The judgement of [`Overview::judgement`].
    #[serde(skip)]
    pub judged: Verdict,
    /// Why there is no motion, and what cures it.
    #[serde(skip)]
    pub none: Option<Fault>,
}

impl SteadyMotions {
    /// True if a drive that turns has no periodic motion.
    pub fn lack(&self) -> bool {
        let stands = self.none.as_ref().is_some_and(|fault| fault.motionless.as_deref() == Some(STANDS));
        self.motions.is_empty() && self.without_torques.is_none() && !stands
    }
}

/// The speed over a turn.
#[derive(Clone, Debug, Serialize)]
pub struct Speeds {
    /// T (s).
    pub period: f64,
    /// 2π/T (rad/s), negative of a shaft that turns backwards.
    pub mean_speed: f64,
    /// (rad/s).
    pub least_speed: f64,
    /// (rad/s).
    pub largest_speed: f64,
    /// φ (rad) and ω (rad/s).
    #[serde(skip)]
    pub course: Vec<[f64; 2]>,
}

/// A periodic motion under torques.
#[derive(Clone, Debug, Serialize)]
pub struct Motion {
    /// Its speed.
    #[serde(flatten)]
    pub speeds: Speeds,
    /// True if small disturbances decay.
    pub stable: bool,
    /// ln of the factor by which a small disturbance grows in a turn.
    pub growth: f64,
    /// E (J) at φ = 0.
    pub energy: f64,
    /// M_an (N·m) at φ = 0.
    pub torque: f64,
}

impl Speeds {
    fn of((period, course): (f64, Vec<[f64; 2]>)) -> Self {
        let [least_speed, largest_speed] = range(&course);
        let mean_speed = (TAU / period).copysign(largest_speed + least_speed);
        Speeds { period, mean_speed, least_speed, largest_speed, course }
    }

    /// Largest less least speed as part of the mean.
    pub fn fluctuation(&self) -> f64 {
        (self.largest_speed - self.least_speed) / self.mean_speed.abs()
    }
}

impl From<PeriodicMotion> for Motion {
    fn from(motion: PeriodicMotion) -> Self {
        let (stable, PeriodicMotion { period, energy, growth, torque, course }) = (motion.is_stable(), motion);
        Motion { speeds: Speeds::of((period, course)), stable, growth, energy, torque }
    }
}

/// The motions of a machine against a constant load (N·m). With a motor a period (s) finds its synchronous speed; without one the
/// motion has it.
///
/// # Errors
/// If no speed yields the period, or the machine cannot be built.
pub fn of_machine(name: &str, scene: &Scene, load: f64, period: Option<f64>) -> Result<SteadyMotions, Fault> {
    let mut scene = scene.clone();
    let (mut synchronous_speed, mut motor) = (None, None);
    let mut motions = Motions { found: Vec::new(), lost: Vec::new() };
    let mut free = period.map(|period| (period, 1.0));
    if let Motor::Kloss(kloss) = scene.motor {
        motor = Some(kloss);
        synchronous_speed = period.map(|period| synchronous(&mut scene, load, period)).transpose()?;
        motions = all_motions(&scene, load)?;
        let stable = motions.found.iter().find(|motion| motion.is_stable());
        free = stable.map(|motion| (motion.period, motion.course.first().map_or(1.0, |[_, w]| w.signum())));
    }
    let inertia = Inertia::new(scene.inertia.clone(), scene.followers.clone());
    let free = free.map(|(period, sense)| Speeds::of((period, free_motion(&inertia, period, sense))));
    let followers = inertia.followers.iter().enumerate();
    let any = AnyScene::from(scene);
    let turn = periodic_turn::of(&any, None, load).ok();
    let mut findings = SteadyMotions {
        name: name.to_owned(),
        load,
        motor,
        synchronous_speed,
        motions: motions.found.into_iter().map(Motion::from).collect(),
        lost_periods: motions.lost,
        without_torques: free,
        mechanisms: followers.flat_map(|(j, follower)| transmission::of(j + 1, follower)).collect(),
        ..SteadyMotions::default()
    };
    turn.into_iter().for_each(|turn| findings.take(&any, turn));
    Ok(findings)
}

/// The motion of a drive or a train at this speed (rad/s) or its own.
///
/// # Errors
/// If its speed is unknown, or a free shaft has no such motion.
pub fn of_drive(resource: &Resource, speed: Option<f64>) -> Result<SteadyMotions, Fault> {
    let mut resource = resource.clone();
    let moved = periodic_turn::from_zero(&resource.scene, speed)?;
    if speed.is_some() {
        resource.scene = moved;
    }
    let mut overview = overview::of(&resource);
    match (overview.motionless.take(), resource.scene.drive()) {
        // A fault that is no judgement on the motion.
        (Some(fault), None) if fault.motionless.is_none() => Err(fault),
        (none, _) => Ok(SteadyMotions { none, ..of_turning(&resource, &overview) }),
    }
}

/// The motion of which the overview of a scene has a turn; None without one.
pub fn of_overview(resource: &Resource, overview: &Overview) -> Option<SteadyMotions> {
    if let AnyScene::RigidMachine(scene) = &resource.scene {
        return of_machine(&resource.name, scene, 0.0, None).ok();
    }
    overview.turn.as_ref().map(|_| of_turning(resource, overview))
}

/// The motion that is in the overview of a drive or a train, and the judgement on it.
fn of_turning(resource: &Resource, overview: &Overview) -> SteadyMotions {
    let mut findings = SteadyMotions {
        name: resource.name.clone(),
        lift_offs: Some(overview.lift_offs.clone()),
        judged: overview.judgement(),
        ..SteadyMotions::default()
    };
    if matches!(&resource.scene, AnyScene::ElasticShaft(shaft) if !shaft.linear) {
        findings.judged.certainty(
            "The motion is of the nonlinear equation; `camdrive stability` shows the linear one next to it.",
        );
    }
    if let Some(turn) = overview.turn.clone() {
        findings.resonances = overview.resonances.clone();
        findings.take(&resource.scene, turn);
        findings.harmonics = findings.turn.as_ref().map_or(Vec::new(), |turn| turn.harmonics(&overview.named));
        // Coefficients that vary over the turn shift resonances.
        for of in findings.harmonics.iter_mut().filter(|_| !overview.varies) {
            of.resonance =
                overview.natural(periodic_turn::part(&of.output).1).map(|natural| natural / of.harmonic as f64);
        }
    }
    findings
}

/// The diagrams of the motion of a scene, in the lines of a sketch; none without a motion.
pub fn sketch(resource: &Resource) -> Vec<(String, Diagram)> {
    let turn = periodic_turn::sketch(&resource.scene);
    turn.map_or(Vec::new(), |turn| [tables::diagrams(&resource.name, &turn), spectra(&resource.name, &turn)].concat())
}

impl SteadyMotions {
    /// Takes up a turn.
    fn take(&mut self, scene: &AnyScene, turn: Turn) {
        if !matches!(scene, AnyScene::RigidMachine(_)) {
            let growth = turn.growth.unwrap_or(f64::NAN);
            let w = turn.output("w");
            let course =
                turn.angles.iter().enumerate().map(|(k, phi)| [*phi, w.map_or(turn.mean_speed, |w| w.values[k])]);
            let mut course: Vec<[f64; 2]> = course.collect();
            if let Some(w) = w.filter(|w| w.least < w.largest) {
                course.extend([[w.least_at, w.least], [w.largest_at, w.largest]]);
                course.sort_by(|a, b| (turn.mean_speed * a[0]).total_cmp(&(turn.mean_speed * b[0])));
            }
            let [least_speed, largest_speed] = turn.speeds();
            let speeds =
                Speeds { period: turn.period, mean_speed: turn.mean_speed, least_speed, largest_speed, course };
            let [torque, energy] = turn.at_zero;
            self.motions = vec![Motion {
                speeds,
                stable: growth < periodic_turn::NEUTRAL || growth.is_nan(),
                growth,
                energy,
                torque,
            }];
        }
        self.dwells = turn.dwells(scene);
        self.turn = Some(turn);
    }
}

/// The synchronous speed is found when it yields the period to this part.
const FOUND: f64 = 1e-13;

/// Steps of the secant method; the period is nearly inversely proportional to the speed, so that a handful suffices.
const STEPS: usize = 40;

/// The motor's synchronous speed with which the fastest stable motion has this period; the scene gets it.
fn synchronous(scene: &mut Scene, load: f64, period: f64) -> Result<f64, Fault> {
    let Motor::Kloss(Kloss { synchronous_speed: given, .. }) = scene.motor else { return Err(Fault::new("")) };
    let mut measure = |speed: f64| -> Result<f64, Fault> {
        if let Motor::Kloss(Kloss { synchronous_speed, .. }) = &mut scene.motor {
            *synchronous_speed = speed;
        }
        let motions = periodic_motions(scene, load)?;
        let fastest = motions.iter().find(|motion| motion.is_stable());
        let motion = fastest.ok_or_else(|| {
            Fault::new(format!(
                "with a synchronous speed of {} rpm there is no stable periodic motion against the load of {load} N.m: the motor stalls",
                text::rpm(speed)
            ))
        })?;
        Ok(motion.period)
    };
    // ln T over ln w_s is nearly straight.
    let mut speeds = [given, given * measure(given)? / period];
    let mut misses = [(measure(given)? / period).ln(), (measure(speeds[1])? / period).ln()];
    for _ in 0..STEPS {
        if misses[1].abs() <= FOUND || misses[0] == misses[1] {
            break;
        }
        let rise = (misses[1] - misses[0]) / (speeds[1] / speeds[0]).ln();
        let next = speeds[1] * (-misses[1] / rise).clamp(-1.0, 1.0).exp();
        if next == speeds[1] {
            break;
        }
        (speeds, misses) = ([speeds[1], next], [misses[1], (measure(next)? / period).ln()]);
    }
    if misses[1].abs() > 1e3 * FOUND {
        return Err(Fault::new(format!(
            "no synchronous speed yields the period of {period} s; the nearest period found is {} s",
            period * misses[1].exp()
        )));
    }
    Ok(speeds[1])
}
