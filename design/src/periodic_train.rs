//! The periodic motion of a train: what shaft and followers do in a turn from φ = 0 on, and whether disturbances decay.

use crate::periodic_motions::{PeriodicMotion, range};
use crate::search::summit;
use camdrive::drives::drive_train::{DriveTrain, Scene, Shaft};
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::variable::{Causality, Kind};
use camdrive::drives::{Drive as _, Fault};
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
    let list = train.variables();
    let named = |name: &str| list.reference(name).map(|reference| list.0[reference].index);
    let time = |k: usize| k as f64 * found.period / POINTS as f64;
    let mut places = list.places();
    let (mut walk, mut rows) = (train.clone(), Vec::new());
    for k in 0..=POINTS {
        if k > 0 {
            walk.advance(time(k - 1), time(k) - time(k - 1))?;
        }
        walk.evaluate(&mut places);
        rows.push(places.clone());
    }
    let mean = |place: usize| rows[..POINTS].iter().map(|row| row[place]).sum::<f64>() / POINTS as f64;
    let is_told = |name: &str| TOLD.contains(&name.rsplit('.').next().unwrap_or_default()) || name == "w";
    let told = list.0.iter().filter(|v| v.description.causality == Causality::Output && is_told(&v.description.name));
    let mut outputs: Vec<(usize, Range)> = Vec::new();
    for variable in told {
        let Kind::Real { quantity, .. } = variable.description.kind else { continue };
        let (output, mean) = (variable.description.name.clone(), mean(variable.index));
        outputs.push((variable.index, Range { output, unit: quantity.unit, least: mean, largest: mean, mean }));
    }
    // From which point on a highest value lies.
    let mut peaks: BTreeMap<usize, Vec<(usize, f64, usize)>> = BTreeMap::new();
    for (i, (place, _)) in outputs.iter().enumerate() {
        for sign in [-1.0, 1.0] {
            let highest = (0..=POINTS).max_by(|a, b| (sign * rows[*a][*place]).total_cmp(&(sign * rows[*b][*place])));
            let highest = highest.unwrap_or(0);
            peaks.entry(highest.clamp(1, POINTS - 1) - 1).or_default().push((i, sign, highest));
        }
    }
    let phi = named("phi").unwrap_or(0);
    let mut course: Vec<[f64; 2]> = Vec::new();
    for k in 0..POINTS {
        for (i, sign, highest) in peaks.remove(&k).unwrap_or_default() {
            let (place, range) = &mut outputs[i];
            let mut at = |t: f64| {
                let mut there = train.clone();
                let reached = if t > time(k) { there.advance(time(k), t - time(k)) } else { Ok(()) };
                there.evaluate(&mut places);
                reached.map_or(f64::NAN, |()| sign * places[*place])
            };
            let top = (time(highest), sign * rows[highest][*place]);
            let (t, value) = summit(&mut at, [time(k), time(k + 2)], top, 1e-9 * found.period);
            if sign > 0.0 {
                range.largest = value
            } else {
                range.least = -value
            }
            if range.output == "w" {
                at(t);
                course.push([places[phi], sign * value]);
            }
        }
        train.advance(time(k), time(k + 1) - time(k))?;
    }
    let w = named("w").unwrap_or(phi);
    course.extend(rows.iter().map(|row| [row[phi], row[w]]));
    let sense = rows[0][w].signum();
    course.sort_by(|a, b| (sense * a[0]).total_cmp(&(sense * b[0])));
    let torques: Vec<f64> = match named("M_an") {
        Some(place) => rows[..POINTS].iter().map(|row| row[place]).collect(),
        // With impacts it is the mean over the step that ends there.
        None => (1..=POINTS)
            .map(|k| {
                (1..=followers)
                    .filter_map(|j| {
                        let of = |what: &str| named(&format!("follower[{j}].{what}"));
                        of("tau_mean").or(of("tau")).map(|place| rows[k][place])
                    })
                    .sum()
            })
            .collect(),
    };
    let powers = torques.iter().zip(&rows).map(|(torque, row)| torque * row[w]);
    let mut multipliers: Vec<[f64; 2]> = Vec::new();
    let n = found.map.len();
    // A stiff mass that is on its flank at φ = 0 has none.
    if n > 0 {
        let values = DMatrix::from_fn(n, n, |i, k| found.map[k][i]).complex_eigenvalues();
        multipliers.extend(values.iter().map(|value| [value.re, value.im]));
    }
    multipliers.sort_by(|a, b| b[0].hypot(b[1]).total_cmp(&a[0].hypot(a[1])));
    let [low, high] = range(&course);
    Ok(Turn {
        fluctuation: (high - low) * found.period / TAU,
        mean_torque: torques.iter().sum::<f64>() / POINTS as f64,
        mean_power: powers.sum::<f64>() / POINTS as f64,
        multipliers,
        impacts: (1..=followers)
            .map(|j| named(&format!("follower[{j}].impacts")).map(|place| rows[POINTS][place] - rows[0][place]))
            .collect(),
        motion: PeriodicMotion {
            period: found.period,
            energy: named("E").map_or(0.0, |place| rows[0][place]),
            growth: found.multiplier.ln(),
            torque: torques[0],
            course,
        },
        outputs: outputs.into_iter().map(|(_, range)| range).collect(),
    })
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
