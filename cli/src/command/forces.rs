//! `camdrive forces SCENE`

use super::measured::Measured;
use super::output::Bar;
use super::{Failure, Format, failure, files, optional, read};
use crate::scene::forces::machine;
use camdrive::drives::rigid_machine::Inertia;
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::{Fault, unit};
use camdrive_design::forces::report::{csv, shaft_csv};
use camdrive_design::forces::{Machine, Report, figures};
use camdrive_design::overview::running;
use camdrive_design::periodic_train;
use camdrive_design::resource::Scene;
use camdrive_design::text;
use std::path::PathBuf;

/// Computes the loads on rollers, joints and shaft at constant speed.
///
/// Goes from the tool back to the cam: masses, moments of inertia and lengths of the scene, with gravity, return spring and
/// process force of [load] or [follower.load]. For cams with a [geometry] roller force, pressure angle, Hertzian
/// pressure, and what keeps the roller on the cam: changes of sign of its force, least preload, speed of lift-off; for
/// mechanisms the forces in their joints; for all torque and power of the shaft. Rigid bodies without friction and clearance.
///
/// Prints the largest values with their angles, and writes NAME.json, NAME.torque.csv, NAME.torque.svg, and for each cam NAME.csv,
/// NAME.roller_force.svg, NAME.hertzian_pressure.svg and NAME.linkage1.svg …; cams of a machine are called NAME.follower1 ….
/// The exit code is 1 where a follower leaves its cam at this speed.
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

/// The speed that follows from the scene, if one does.
fn speed_of(scene: &Scene) -> Option<f64> {
    match (scene, scene.drive()) {
        (_, Some(DriveMode::Constant { w, .. })) => Some(*w),
        (Scene::RigidMachine(machine), _) => {
            let inertia = Inertia::new(machine.inertia.clone(), machine.followers.clone());
            running(machine, &inertia).map(|(mean, _)| mean)
        }
        (Scene::DriveTrain(train), _) => periodic_train::of(train).ok().map(|turn| turn.mean_speed()),
        _ => None,
    }
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let speed = optional("speed", &args.speed, &unit::ANGULAR_VELOCITY)?;
    let scene = read(&args.scene)?;
    let folder = files::folder(args.output.as_deref(), "forces", &scene.name)?;
    let place = args.scene.display();
    let fault = |fault: Fault| failure(format!("{place}: {fault}"));
    let machine = machine(&scene).map_err(fault)?;
    let Some(speed) = speed.or_else(|| speed_of(&scene.scene)) else {
        return Err(failure(format!(
            "{place}: the scene gives no speed\n  = hint: give it, for example --speed \"300 rpm\""
        )));
    };
    let machine = Machine { speed, ..machine };
    let (turn, report) = Bar::beside(&scene.name, |_| {
        let turn = machine.turn()?;
        let report = Report::new(&machine, &turn);
        Ok((turn, report))
    })
    .map_err(fault)?;
    let mut diagrams = vec![("torque".to_owned(), figures::torque(&turn, &machine))];
    let own = [("json", text::json(&report)), ("torque.csv", shaft_csv(&turn, speed))];
    let mut parts = files::report(&folder, &scene.name, own)?;
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
    args.format.print(|width| report.text(width) + "\n" + &written, || text::json(&report))?;
    match report.lost()[..] {
        [] => Ok(()),
        ref lost => Err(failure(format!("{place}: {}", lost.join("; ")))),
    }
}
