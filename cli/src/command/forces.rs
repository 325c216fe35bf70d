//! `camdrive forces SCENE`

use super::deliver::{ReportFiles, ReportFormat};
use super::measured::Measured;
use super::output::Bar;
use super::{Failure, failure, files, read, speed_option};
use crate::scene::Resolved;
use camdrive::drives::Fault;
use camdrive::drives::rigid_machine::Inertia;
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive_design::forces::{ForceAnalysis, Machine};
use camdrive_design::overview::running;
use camdrive_design::periodic_turn::{self, Turn};
use camdrive_design::report::Report;
use camdrive_design::resource::Scene;
use std::path::{Path, PathBuf};

/// Compute the loads on rollers, joints and shaft at constant speed.
///
/// Goes from the tool back to the cam, with masses, moments of inertia and lengths of the scene, and gravity, return spring and
/// process force of [load] or [follower.load]. For cams with a [geometry]: roller force, pressure angle, Hertzian pressure, and the
/// contact of the roller (changes of sign of its force, least preload, lift-off speed). For mechanisms: the forces in their joints.
/// For all: torque and power of the shaft. The bodies are rigid, without friction and clearance.
///
/// Prints the largest values with their angles, and writes NAME.json, NAME.torque.csv, NAME.torque.svg, and for each cam NAME.csv,
/// NAME.roller_force.svg, NAME.hertzian_pressure.svg and NAME.linkage1.svg …; cams of a machine are called NAME.follower1 …. The
/// exit code is 1 if a follower lifts off its cam at this speed.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive forces examples/sealing_machine/scene.toml
  camdrive forces examples/sealing_machine/scene.toml --speed \"300 rpm\" \\
      -o forces/")]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Folder for tables and diagrams [default: forces-NAME]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Speed, "400 rpm" or in rad/s [default: the scene's; for a machine its mean speed]
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    speed: Option<String>,
    /// Replace files that no command wrote
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    measured: Measured,
    #[command(flatten)]
    format: ReportFormat,
}

/// The speed of the scene, if it determines one.
pub fn speed_of(scene: &Scene) -> Option<f64> {
    turning(scene).map(|(speed, _)| speed)
}

/// The speed of the scene, and the motion of a train that a motor turns.
fn turning(scene: &Scene) -> Option<(f64, Option<Turn>)> {
    match (scene, scene.drive()) {
        (_, Some(DriveMode::Constant { w, .. })) => Some((*w, None)),
        (Scene::RigidMachine(machine), _) => {
            let inertia = Inertia::new(machine.inertia.clone(), machine.followers.clone());
            running(machine, &inertia).map(|(mean, _)| (mean, None))
        }
        (Scene::DriveTrain(_), _) => {
            let turn = periodic_turn::of(scene, None, 0.0).ok()?;
            Some((turn.mean_speed, Some(turn)))
        }
        _ => None,
    }
}

/// The report on a scene at this speed, or at its own, and the findings.
pub fn study(path: &Path, scene: &Resolved, speed: Option<f64>) -> Result<(Report, ForceAnalysis), Failure> {
    let place = path.display();
    let fault = |fault: Fault| failure(fault.within(&place));
    let mut machine = Machine::of(&scene.resource()).map_err(fault)?;
    let Some((speed, motion)) = speed.map(|speed| (speed, None)).or_else(|| turning(&scene.scene)) else {
        return Err(failure(format!("{place}: the scene has no speed")).hint("set it, for example --speed \"300 rpm\""));
    };
    machine.speed = speed;
    motion.iter().for_each(|turn| machine.mark(&scene.scene, turn));
    Bar::during(&scene.name, |_| {
        let turn = machine.turn()?;
        let findings = ForceAnalysis::new(&turn);
        Ok((findings.report(&turn), findings))
    })
    .map_err(fault)
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let speed = speed_option(&args.speed)?;
    let scene = read(&args.scene)?;
    let folder = files::folder(args.output.as_deref(), "forces", &scene.name)?;
    let place = args.scene.display();
    let (report, findings) = study(&args.scene, &scene, speed)?;
    let measured = Some(&args.measured);
    args.format.deliver(
        report,
        &findings,
        ReportFiles {
            folder: Some(&folder),
            inputs: scene.files,
            scene: Some(&scene.document),
            measured,
            force: args.force,
            ..ReportFiles::default()
        },
    )?;
    match findings.lost()[..] {
        [] => Ok(()),
        ref lost => Err(failure(format!("{place}: {}", lost.join("; ")))),
    }
}
