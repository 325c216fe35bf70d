//! The periodic motion of a train: what shaft and followers do in a turn from φ = 0 on, and whether disturbances decay.

use crate::periodic_motions::{PeriodicMotion, range};
use crate::search::summit;
use camdrive::drives::drive_train::{DriveTrain, Scene, Shaft};
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::variable::{Causality, Kind, Variable};
use camdrive::drives::{Description, Drive as _, Fault, List};
use nalgebra::DMatrix;
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Points of a turn; least and largest values are refined between them.
const POINTS: usize = 1440;

/// `solver.tolerance` of the turn.
const TOLERANCE: f64 = 1e-13;

/// What is told of each follower where it has it, and of the motor.
const TOLD: [&str; 7] = ["y", "q", "gap", "force", "contact_force", "tau", "M_an"];

/// An output over the turn.
#[derive(Clone, Debug, Serialize)]
pub struct Range {
    /// Its name.
    pub output: String,
    /// Its unit.
    pub unit: &'static str,
    /// The least value.
    pub least: f64,
    /// The largest value.
    pub largest: f64,
    /// The mean over time.
    pub mean: f64,
}

/// A turn of the periodic motion.
#[derive(Clone, Debug, Serialize)]
pub struct Turn {
    /// The speed over the turn.
    #[serde(skip)]
    pub motion: PeriodicMotion,
    /// Largest less least speed as part of the mean.
    pub fluctuation: f64,
    /// The mean torque (N·m) that the motor has on the shaft, or that a driven shaft needs, impacts included.
    pub mean_torque: f64,
    /// The mean power (W) of that.
    pub mean_power: f64,
    /// The factors [re, im] by which disturbances grow in a turn, the largest one first.
    pub multipliers: Vec<[f64; 2]>,
    /// Outputs.
    pub outputs: Vec<Range>,
    /// Impacts of each follower in the turn; null of one without clearance.
    pub impacts: Vec<Option<f64>>,
}

/// The periodic motion of a train, stable or not.
///
/// # Errors
/// Where there is none.
pub fn of(scene: &Scene) -> Result<Turn, Fault> {
    let mut scene = scene.clone();
    match &mut scene.shaft {
        Shaft::Free(machine) => machine.phi_start = 0.0,
        Shaft::Driven(DriveMode::Constant { phi_start, .. }) => *phi_start = 0.0,
        Shaft::Driven(DriveMode::Input | DriveMode::Speed { .. }) => {}
    }
    // Finer than any digit that is shown.
    scene.solver.tolerance = TOLERANCE;
    let followers = scene.followers.len();
    let mut train = DriveTrain::new(scene)?;
    let found = train.periodic_motion()?;
    let sampled = Sampled::of(train, found.period)?;
    let (outputs, mut course) = sampled.ranges()?;
    let [phi, w] = sampled.shaft();
    course.extend(sampled.rows.iter().map(|row| [row[phi], row[w]]));
    let sense = sampled.rows[0][w].signum();
    course.sort_by(|a, b| (sense * a[0]).total_cmp(&(sense * b[0])));
    let torques = sampled.torques(followers);
    let powers = torques.iter().zip(&sampled.rows).map(|(torque, row)| torque * row[w]);
    let mut multipliers: Vec<[f64; 2]> = Vec::new();
    let n = found.map.len();
    // A stiff mass that is on its flank at φ = 0 has none.
    if n > 0 {
        let values = DMatrix::from_fn(n, n, |i, k| found.map[k][i]).complex_eigenvalues();
        multipliers.extend(values.iter().map(|value| [value.re, value.im]));
    }
    multipliers.sort_by(|a, b| b[0].hypot(b[1]).total_cmp(&a[0].hypot(a[1])));
    let [low, high] = range(&course);
    let rises = |place: usize| sampled.rows[POINTS][place] - sampled.rows[0][place];
    Ok(Turn {
        fluctuation: (high - low) * found.period / TAU,
        mean_torque: torques.iter().sum::<f64>() / POINTS as f64,
        mean_power: powers.sum::<f64>() / POINTS as f64,
        multipliers,
        impacts: (1..=followers).map(|j| sampled.place(&format!("follower[{j}].impacts")).map(rises)).collect(),
        motion: PeriodicMotion {
            period: found.period,
            energy: sampled.place("E").map_or(0.0, |place| sampled.rows[0][place]),
            growth: found.multiplier.ln(),
            torque: torques[0],
            course,
        },
        outputs,
    })
}

/// A turn of a train in [`POINTS`] equal times, with its end.
struct Sampled {
    /// At its begin.
    train: DriveTrain,
    list: List<DriveTrain>,
    /// (s).
    period: f64,
    /// All variables at each instant, in the order of their places.
    rows: Vec<Box<[f64]>>,
}

impl Sampled {
    fn of(train: DriveTrain, period: f64) -> Result<Self, Fault> {
        let list = train.variables();
        let mut sampled = Sampled { rows: Vec::new(), list, period, train };
        let (mut walk, mut places) = (sampled.train.clone(), sampled.list.places());
        for k in 0..=POINTS {
            if k > 0 {
                walk.advance(sampled.time(k - 1), sampled.time(k) - sampled.time(k - 1))?;
            }
            walk.evaluate(&mut places);
            sampled.rows.push(places.clone());
        }
        Ok(sampled)
    }

    /// An instant (s).
    fn time(&self, k: usize) -> f64 {
        k as f64 * self.period / POINTS as f64
    }

    /// The place of a variable.
    fn place(&self, name: &str) -> Option<usize> {
        self.list.reference(name).map(|reference| self.list.0[reference].index)
    }

    /// The places of φ and Ω.
    fn shaft(&self) -> [usize; 2] {
        let phi = self.place("phi").unwrap_or(0);
        [phi, self.place("w").unwrap_or(phi)]
    }

    /// The outputs that are told, with their places; least and largest are the mean as yet.
    fn outputs(&self) -> Vec<(usize, Range)> {
        let mean = |place: usize| self.rows[..POINTS].iter().map(|row| row[place]).sum::<f64>() / POINTS as f64;
        let is_told = |name: &str| TOLD.contains(&name.rsplit('.').next().unwrap_or_default()) || name == "w";
        let is_told = |d: &Description| d.causality == Causality::Output && is_told(&d.name);
        let range = |v: &Variable<DriveTrain>| {
            let Kind::Real { quantity, .. } = v.description.kind else { return None };
            let (output, mean) = (v.description.name.clone(), mean(v.index));
            Some((v.index, Range { output, unit: quantity.unit, least: mean, largest: mean, mean }))
        };
        self.list.0.iter().filter(|v| is_told(&v.description)).filter_map(range).collect()
    }

    /// The outputs that are told, and [φ, Ω] where Ω is least and largest.
    fn ranges(&self) -> Result<(Vec<Range>, Vec<[f64; 2]>), Fault> {
        let mut outputs = self.outputs();
        // From which point on a highest value lies.
        let mut peaks: BTreeMap<usize, Vec<(usize, f64, usize)>> = BTreeMap::new();
        for (i, (place, _)) in outputs.iter().enumerate() {
            for sign in [-1.0, 1.0] {
                let value = |k: usize| sign * self.rows[k][*place];
                let highest = (0..=POINTS).max_by(|a, b| value(*a).total_cmp(&value(*b))).unwrap_or(0);
                peaks.entry(highest.clamp(1, POINTS - 1) - 1).or_default().push((i, sign, highest));
            }
        }
        let (mut walk, mut places, [phi, _]) = (self.train.clone(), self.list.places(), self.shaft());
        let mut course: Vec<[f64; 2]> = Vec::new();
        for k in 0..POINTS {
            let from = self.time(k);
            for (i, sign, highest) in peaks.remove(&k).unwrap_or_default() {
                let (place, range) = &mut outputs[i];
                let mut at = |t: f64| {
                    let mut there = walk.clone();
                    let reached = if t > from { there.advance(from, t - from) } else { Ok(()) };
                    there.evaluate(&mut places);
                    reached.map_or(f64::NAN, |()| sign * places[*place])
                };
                let top = (self.time(highest), sign * self.rows[highest][*place]);
                let (t, value) = summit(&mut at, [from, self.time(k + 2)], top, 1e-9 * self.period);
                *(if sign > 0.0 { &mut range.largest } else { &mut range.least }) = sign * value;
                if range.output == "w" {
                    at(t);
                    course.push([places[phi], sign * value]);
                }
            }
            walk.advance(from, self.time(k + 1) - from)?;
        }
        Ok((outputs.into_iter().map(|(_, range)| range).collect(), course))
    }

    /// The torque on the shaft at each instant but the last: of the motor, or that which a driven shaft needs.
    fn torques(&self, followers: usize) -> Vec<f64> {
        if let Some(place) = self.place("M_an") {
            return self.rows[..POINTS].iter().map(|row| row[place]).collect();
        }
        let of = |j: usize, what: &str| self.place(&format!("follower[{j}].{what}"));
        let places: Vec<usize> = (1..=followers).filter_map(|j| of(j, "tau_mean").or(of(j, "tau"))).collect();
        // With impacts it is the mean over the step that ends there.
        self.rows[1..].iter().map(|row| places.iter().map(|place| row[*place]).sum()).collect()
    }
}

impl Turn {
    /// (rad/s).
    pub fn mean_speed(&self) -> f64 {
        let [low, high] = range(&self.motion.course);
        (TAU / self.motion.period).copysign(low + high)
    }
}

#[cfg(test)]
mod tests;
