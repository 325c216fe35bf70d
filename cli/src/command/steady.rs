//! `camdrive steady SCENE`

use super::deliver::{ReportFiles, ReportFormat};
use super::measured::Measured;
use super::output::Bar;
use super::{Failure, NO_MOTION, driving, failure, files, read, speed_option, wrong_argument};
use crate::scene::Resolved;
use camdrive::drives::Fault;
use camdrive_design::resource;
use camdrive_design::steady::{self, SteadyMotions};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Find the periodic motion: forces, vibration, resonances, impacts.
///
/// The periodic motion is the motion that a drive repeats every turn once its start has decayed.
///
/// Prints the largest and least values of positions, deformations, forces and torques with their angles, the vibration in each
/// dwell, the harmonics of the deformation, impacts, and the decay of a disturbance. A drive that follows inputs needs --speed. The
/// exit code is 3 if the shaft turns and no motion repeats.
///
/// A RigidMachine with a motor may have several motions, stable and unstable ones, or none: then it stalls. For comparison it
/// prints the motion without torques with the same period. A machine without a motor has only this motion, and needs --period. With
/// a motor, --period finds the synchronous speed at which the fastest stable motion has that period.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive steady examples/guide_bar/scene.toml
  camdrive steady examples/valve_train/scene.toml --report study/
  camdrive steady examples/rapier_loom/scene.toml --period \"120 ms\"
  camdrive steady examples/rapier_loom/scene.toml --load \"40 N.m\" \\
      --report study/")]
pub struct Args {
    /// Scene file (TOML), or an FMU with its scene inside
    scene: PathBuf,
    /// Constant speed of the shaft, "1800 rpm"; for a drive with a prescribed speed or on inputs
    #[arg(long, allow_hyphen_values = true)]
    speed: Option<String>,
    /// Prescribed period, "120 ms" or in s
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    period: Option<String>,
    /// Constant load torque, "30 N.m"; positive brakes
    #[arg(long, value_name = "TORQUE", allow_hyphen_values = true)]
    load: Option<String>,
    /// Folder for the outputs over the turn, NAME.turn.csv, their diagrams, NAME.motion.svg and others, and NAME.json
    #[arg(long, value_name = "FOLDER")]
    report: Option<PathBuf>,
    /// Replace files that no command wrote
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    measured: Measured,
    #[command(flatten)]
    format: ReportFormat,
}

/// The study of a machine under this load, with this period, or of another drive at this speed (rad/s) or its own speed.
pub fn study(
    path: &Path,
    scene: &Resolved,
    speed: Option<f64>,
    [load, period]: [Option<&String>; 2],
) -> Result<SteadyMotions, Failure> {
    let place = path.display();
    let findings = if matches!(scene.scene, resource::Scene::RigidMachine(_)) {
        if speed.is_some() {
            return Err(wrong_argument(format!("{place}: --speed is for drives without a motor"))
                .hint("the motor decides the speed; --period prescribes it"));
        }
        let (_, machine) = driving::machine(path, "steady")?;
        let load = load.map_or("0", |load| load);
        let (load, period) = driving::load(&place.to_string(), &machine.motor, load, period)?;
        Bar::during(&scene.name, |_| steady::of_machine(&scene.name, &machine, load, period))
    } else {
        if period.is_some() || load.is_some() {
            return Err(wrong_argument(format!(
                "{place}: --load and --period are for a RigidMachine without elastic followers and loads"
            ))
            .hint("write loads into the scene; --speed or the motor decides the speed"));
        }
        if speed.is_some() && scene.scene.drive().is_none() {
            return Err(wrong_argument(format!("{place}: --speed is for drives without a motor"))
                .hint("choose the speed by the motor of the scene"));
        }
        Bar::during(&scene.name, |_| steady::of_drive(&scene.resource(), speed))
    };
    findings.map_err(|fault: Fault| failure(fault.within(place)))
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    args.measured.need(args.report.as_ref())?;
    if let Some(folder) = &args.report {
        files::no_file(folder, "--report")?;
    }
    let scene = read(&args.scene)?;
    let speed = speed_option(&args.speed)?;
    let findings = study(&args.scene, &scene, speed, [args.load.as_ref(), args.period.as_ref()])?;
    let none = findings.lack();
    let folder = args.report.as_deref();
    let (inputs, scene, measured) = (scene.files, Some(&scene.document), Some(&args.measured));
    let place = ReportFiles { folder, inputs, scene, measured, force: args.force, ..ReportFiles::default() };
    args.format.deliver(findings.report(), &findings, place)?;
    Ok(if none { ExitCode::from(NO_MOTION) } else { ExitCode::SUCCESS })
}
