//! `camdrive forces SCENE`

use super::measured::Measured;
use super::{Failure, Format, failure, files, optional, read};
use crate::scene::Resolved;
use camdrive::drives::Fault;
use camdrive::drives::cam_drive::DriveMode;
use camdrive::drives::rigid_machine::{self, Follower, Inertia};
use camdrive::drives::unit;
use camdrive_design::forces::report::csv;
use camdrive_design::forces::{Drive, Machine, Report, figures};
use camdrive_design::overview::running;
use camdrive_design::text;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::PathBuf;

/// Computes the loads on rollers, joints and shaft at constant speed.
///
/// Goes from the tool back to the cam: masses, moments of inertia and lengths of the scene, with gravity, return spring and
/// process force of [forces] or [follower.forces]. For cams with a [geometry] roller force, pressure angle, Hertzian
/// pressure, and what keeps the roller on the cam: changes of sign of its force, least preload, speed of lift-off; for
/// mechanisms the forces in their joints; for all the torque on the shaft. Rigid bodies without friction and clearance.
///
/// Prints the largest values with their angles, and writes NAME.json, NAME.torque.svg, and for each cam NAME.csv,
/// NAME.roller_force.svg, NAME.hertzian_pressure.svg and NAME.linkage1.svg …; cams of a machine are called NAME.follower1 ….
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive forces examples/sealing_machine/scene.toml
  camdrive forces examples/sealing_machine/scene.toml --speed \"300 rpm\" -o forces/")]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Folder for tables and diagrams [default: forces-NAME]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Speed, "400 rpm" or in rad/s [default: that of the scene; of a machine its mean speed]
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    speed: Option<String>,
    #[command(flatten)]
    measured: Measured,
    #[command(flatten)]
    format: Format,
}

/// A part of the resolved scene.
fn part<T: DeserializeOwned>(value: &Value) -> Result<T, Failure> {
    serde_json::from_value(value.clone()).map_err(failure)
}

/// The machine of this scene at this speed, or at that which follows from the scene, if one does.
fn machine(scene: &Resolved, speed: Option<f64>) -> Result<(Option<f64>, Machine), Failure> {
    let (followers, inertia, speed) = if scene.model == "RigidMachine" {
        let whole: rigid_machine::Scene = part(&scene.scene)?;
        let (inertia, followers) = (whole.inertia.clone(), whole.followers.clone());
        let mean = || running(&whole, &Inertia::new(inertia.clone(), followers.clone())).map(|(mean, _)| mean);
        (followers.clone(), inertia.varying.clone(), speed.or_else(mean))
    } else {
        let parameters = &scene.scene["parameters"];
        let mass = ["m", "m1", "m2"].iter().filter_map(|key| parameters.get(key)?.as_f64()).sum();
        let own = match part(&scene.scene["drive"])? {
            DriveMode::Constant { w, .. } => Some(w),
            DriveMode::Input => None,
        };
        (vec![Follower::new(mass, part(&scene.scene["cam"])?)], None, speed.or(own))
    };
    let mut drives = Vec::new();
    for (j, (follower, loads)) in followers.into_iter().zip(&scene.loads).enumerate() {
        let number = (scene.model == "RigidMachine").then_some(j + 1);
        let name = number.map_or(scene.name.clone(), |j| format!("{}.follower{j}", scene.name));
        let plan = scene.cams.iter().find(|cam| cam.follower == number).map(|cam| cam.plan);
        drives.push(Drive::new(name, follower, plan, loads.clone()).map_err(failure)?);
    }
    Ok((speed, Machine { name: scene.name.clone(), speed: speed.unwrap_or(0.0), inertia, drives }))
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let speed = optional("speed", &args.speed, &unit::ANGULAR_VELOCITY)?;
    let scene = read(&args.scene)?;
    let folder = files::folder(args.output.as_deref(), "forces", &scene.name)?;
    let place = args.scene.display();
    if scene.model == "ParametricDrive" {
        return Err(failure(format!("{place}: a ParametricDrive has no cam")));
    }
    let (speed, machine) = machine(&scene, speed)?;
    if machine.drives.iter().all(|drive| drive.plan.is_none() && drive.follower.linkage.is_empty()) {
        let hint = match scene.model {
            "RigidMachine" => "add [follower.geometry] as for camdrive cam, or mechanisms [[follower.linkage]]",
            _ => "add [geometry] beside [cam], as for camdrive cam",
        };
        return Err(failure(format!(
            "{place}: the scene tells neither a roller nor a joint that could bear\n  = hint: {hint}"
        )));
    }
    if speed.is_none() {
        return Err(failure(format!(
            "{place}: no speed follows from the scene\n  = hint: give it, for example --speed \"300 rpm\""
        )));
    }
    let fault = |fault: Fault| failure(format!("{place}: {fault}"));
    let machine = machine.with_springs_placed().map_err(fault)?;
    let turn = machine.turn().map_err(fault)?;
    let report = Report::new(&machine, &turn);
    let mut diagrams = vec![("torque".to_owned(), figures::torque(&turn, &machine))];
    let mut parts = files::report(&folder, &scene.name, [("json", text::json(&report))])?;
    for (j, drive) in machine.drives.iter().enumerate() {
        // Cams of a machine are called NAME.follower1 ….
        let of = drive.name.strip_prefix(&format!("{}.", scene.name)).map_or(String::new(), |name| format!("{name}."));
        let own = figures::of_drive(&turn, j, drive).into_iter();
        diagrams.extend(own.map(|(name, diagram)| (of.clone() + &name, diagram)));
        parts.extend(files::report(&folder, &drive.name, [("csv", csv(&turn, j, drive))])?);
    }
    let courses = args.measured.lay_over(diagrams.iter_mut().map(|(name, diagram)| (name.as_str(), diagram)))?;
    let drawn = diagrams.iter().map(|(name, diagram)| (format!("{name}.svg"), Ok(diagram.svg())));
    parts.extend(files::report(&folder, &scene.name, drawn)?);
    let written = files::write(&parts, &[scene.files, courses].concat())?;
    args.format.print(|width| report.text(width) + "\n" + &written, || text::json(&report))
}
