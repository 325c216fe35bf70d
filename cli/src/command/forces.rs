//! `camdrive forces SCENE`

use super::deliver::{ReportFiles, ReportFormat};
use super::measured::Measured;
use super::output::Bar;
use super::{Failure, failure, files, optional, read};
use crate::scene::Resolved;
use camdrive::drives::rigid_machine::Inertia;
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::{Fault, unit};
use camdrive_design::forces::{ForceAnalysis, Machine};
use camdrive_design::overview::running;
use camdrive_design::periodic_turn;
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
    match (scene, scene.drive()) {
        (_, Some(DriveMode::Constant { w, .. })) => Some(*w),
        (Scene::RigidMachine(machine), _) => {
            let inertia = Inertia::new(machine.inertia.clone(), machine.followers.clone());
            running(machine, &inertia).map(|(mean, _)| mean)
        }
        (Scene::DriveTrain(_), _) => periodic_turn::of(scene, None, 0.0).ok().map(|turn| turn.mean_speed),
        _ => None,
    }
}

/// The report on a scene at this speed, or at its own, and the findings.
pub fn study(path: &Path, scene: &Resolved, speed: Option<f64>) -> Result<(Report, ForceAnalysis), Failure> {
    let place = path.display();
    let fault = |fault: Fault| failure(fault.within(&place));
    let machine = Machine::of(&scene.resource()).map_err(fault)?;
    let Some(speed) = speed.or_else(|| speed_of(&scene.scene)) else {
        return Err(failure(format!("{place}: the scene has no speed")).hint("set it, for example --speed \"300 rpm\""));
    };
    let machine = Machine { speed, ..machine };
    Bar::during(&scene.name, |_| {
        let turn = machine.turn()?;
        let findings = ForceAnalysis::new(&turn);
        Ok((findings.report(&turn), findings))
    })
    .map_err(fault)
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let speed = optional("speed", &args.speed, &unit::ANGULAR_VELOCITY)?;
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
