//! `camdrive steady SCENE`

use super::deliver::{ReportFiles, ReportFormat};
use super::measured::Measured;
use super::output::Bar;
use super::{Failure, NO_MOTION, driving, failure, files, read, wrong_argument};
use crate::scene::Resolved;
use crate::scene::forces::machine;
use camdrive::drives::Fault;
use camdrive_design::forces::Machine;
use camdrive_design::resource;
use camdrive_design::steady::{self, SteadyMotions};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Finds all periodic solutions of a machine.
///
/// With a motor there may be several, stable and unstable ones, or none: then it stalls. The multiplier is the factor by which a
/// small disturbance grows in a turn. For comparison the motion of the machine without torques with
/// the same period; without a motor it is all there is, and --period is needed. With a motor --period finds the
/// synchronous speed with which the fastest stable motion has that period. The exit code is 3 where there is no periodic
/// motion.
///
/// Of a DriveTrain the motion near the speed of its motor or its start: all multipliers, torque and power of the motor, what forces,
/// deformations and impacts its followers have, and from which speed on they leave their cams.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive steady examples/rapier_loom/scene.toml
  camdrive steady examples/rapier_loom/scene.toml --period \"120 ms\"
  camdrive steady examples/rapier_loom/scene.toml --load \"40 N.m\" \\
      --report study/")]
pub struct Args {
    /// Scene file (TOML) of a RigidMachine or a DriveTrain
    scene: PathBuf,
    /// Prescribed period, "120 ms" or in s
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    period: Option<String>,
    /// Constant load torque, "30 N.m"; positive brakes
    #[arg(long, value_name = "TORQUE", default_value = "0", allow_hyphen_values = true)]
    load: String,
    /// Folder for the speed over the turn, NAME.steady.csv and NAME.steady.svg, and NAME.json
    #[arg(long, value_name = "FOLDER")]
    report: Option<PathBuf>,
    /// Replace files that no command wrote
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    measured: Measured,
    #[command(flatten)]
    telling: ReportFormat,
}

/// The study of a machine under this load, with this period, or of a train, which has neither.
pub fn study(path: &Path, scene: &Resolved, load: &str, period: Option<&String>) -> Result<SteadyMotions, Failure> {
    let place = path.display();
    let findings = if let resource::Scene::DriveTrain(train) = &scene.scene {
        if period.is_some() || load != "0" {
            return Err(wrong_argument(format!(
                "{place}: --load and --period are for a machine without elastic followers and loads"
            ))
            .hint("write the load as `machine.load.torque` into the scene, and choose the speed by its motor"));
        }
        let lift_offs = machine(scene).and_then(Machine::lift_offs).unwrap_or_default();
        Bar::beside(&scene.name, |_| steady::of_train(&scene.name, train, lift_offs))
    } else {
        let (_, machine) = driving::machine(path, "steady")?;
        let (load, period) = driving::load(&place.to_string(), &machine.motor, load, period)?;
        Bar::beside(&scene.name, |_| steady::of_machine(&scene.name, &machine, load, period))
    };
    findings.map_err(|fault: Fault| failure(fault.within(place)))
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    args.measured.need(args.report.as_ref())?;
    if let Some(folder) = &args.report {
        files::no_file(folder, "--report")?;
    }
    let scene = read(&args.scene)?;
    let findings = study(&args.scene, &scene, &args.load, args.period.as_ref())?;
    let none = findings.motions.is_empty() && findings.without_torques.is_none();
    let folder = args.report.as_deref();
    let (inputs, scene, measured) = (scene.files, Some(&scene.document), Some(&args.measured));
    let place = ReportFiles { folder, inputs, scene, measured, force: args.force, ..ReportFiles::default() };
    args.telling.deliver(findings.report(), &findings, place)?;
    Ok(if none { ExitCode::from(NO_MOTION) } else { ExitCode::SUCCESS })
}
