//! Drive of a machine in its periodic motion, from the options of `steady` and `compensate`: load and period.

use super::{Failure, failure, quantity, read, wrong_argument};
use crate::scene::Resolved;
use camdrive::drives::rigid_machine::{Kloss, Motor, Scene};
use camdrive::drives::unit;
use camdrive_design::resource;
use camdrive_design::text::rpm;
use std::f64::consts::TAU;
use std::path::Path;

/// The slowest and the fastest mean speed (rad/s) of a period; a scene admits no higher speed.
const SPEEDS: [f64; 2] = [1e-6, 1e6];

/// The largest factor between the motor's speed for a period and its speed in the scene: an inverter, other poles or a gear reach
/// it. A larger factor means another machine or a wrong unit.
const OF_THE_MOTOR: f64 = 100.0;

/// The scene of a machine with fluctuating speed, for this purpose.
pub fn machine(path: &Path, purpose: &str) -> Result<(Resolved, Scene), Failure> {
    let resolved = read(path)?;
    let resource::Scene::RigidMachine(scene) = &resolved.scene else {
        let (place, model) = (path.display(), resolved.scene.model().split('.').next().unwrap_or_default());
        return Err(failure(format!(
            "{place}: `model` = \"{model}\" has a prescribed motion of the drive; {purpose} is for the models RigidMachine and DriveTrain"
        )).hint("write a RigidMachine with the rigid followers, with a motor of kind \"kloss\" or \"none\""));
    };
    let scene = scene.clone();
    Ok((resolved, scene))
}

/// The constant load (N·m) and the period (s), if there is one, for this motor of the scene at `place`.
pub fn load(place: &str, motor: &Motor, load: &str, period: Option<&String>) -> Result<(f64, Option<f64>), Failure> {
    let load = quantity("load", load, &unit::TORQUE)?;
    let period = period.map(|text| quantity("period", text, &unit::TIME).map(|time| (text, time))).transpose()?;
    match motor {
        Motor::Input => {
            Err(failure(format!("{place}: the torque of the motor is an input: no periodic motion follows from it"))
                .hint("choose `motor.kind` = \"kloss\" or \"none\""))
        }
        Motor::None if load != 0.0 => {
            Err(wrong_argument(format!("{place}: without a motor nothing balances the load of {load} N.m"))
                .hint("omit --load, or add a motor"))
        }
        Motor::None if period.is_none() => {
            Err(failure(format!("{place}: a machine without a motor turns at any speed"))
                .hint("give the period with --period"))
        }
        _ => Ok(()),
    }?;
    if let Some((text, period)) = period {
        admissible(motor, text, period)?;
    }
    Ok((load, period.map(|(_, period)| period)))
}

/// Refuses periods that no machine has, or no machine with this motor.
fn admissible(motor: &Motor, text: &str, period: f64) -> Result<(), Failure> {
    if !(period > 0.0 && period.is_finite()) {
        return Err(wrong_argument(format!("--period: {period} s is not a period: it must be positive"))
            .hint("write for example \"120 ms\""));
    }
    let (speeds, whose) = match *motor {
        Motor::Kloss(Kloss { synchronous_speed, .. }) => {
            let own = synchronous_speed.abs();
            let speeds = [(own / OF_THE_MOTOR).max(SPEEDS[0]), (own * OF_THE_MOTOR).min(SPEEDS[1])];
            (speeds, format!(", with a motor whose synchronous speed is {} rpm in the scene", rpm(own)))
        }
        _ => (SPEEDS, String::new()),
    };
    let [slow, fast] = speeds;
    let speed = TAU / period;
    if (slow..=fast).contains(&speed) {
        return Ok(());
    }
    Err(wrong_argument(format!(
        "--period: \"{text}\" would be a mean speed of {} rpm{whose}\n  = admissible: {:.3e} to {:.3e} s",
        rpm(speed),
        TAU / fast,
        TAU / slow
    ))
    .hint("a time with its unit, such as \"120 ms\"; a plain number is in s"))
}
