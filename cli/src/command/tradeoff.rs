//! `camdrive tradeoff SCENE`

use super::deliver::{ReportFiles, ReportFormat};
use super::output::Bar;
use super::{Failure, failure, files, of_option, optional, read, speed_option};
use camdrive::drives::{Fault, unit};
use camdrive_design::tradeoff::{self, Options};
use std::path::PathBuf;

/// Measure speed against accuracy of every solver setting.
///
/// Drives the FMU through its C interface with each of its methods, tolerances and internal steps, over communication steps, and
/// again without each feature of the scene. Errors are relative to the largest value of an output, against a reference with a
/// stated uncertainty; costs are CPU times on this computer.
///
/// Prints a recommendation and the tables, and writes NAME.settings.csv, NAME.features.csv, NAME.json, NAME.html,
/// NAME.work_precision.svg and NAME.communication_step.svg into a folder.
///
/// A drive with inputs follows a run-up: from standstill to --speed within --ramp (a Bestehorn sinoid without jumps of the
/// acceleration), then constant speed; the load torque `tau` of a machine stays 0.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive tradeoff examples/guide_bar/scene.toml
  camdrive tradeoff examples/backlash_drive/scene.toml --turns 10 -o study/
  camdrive tradeoff examples/guide_bar/run_up.toml --speed \"1800 rpm\" \\
      --ramp \"0.2 s\"")]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Folder for tables and diagrams [default: tradeoff-NAME]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Turns of the cam in a run [default: from the default experiment; 9 with a run-up]
    #[arg(long, value_name = "NUMBER", allow_hyphen_values = true)]
    turns: Option<f64>,
    /// Speed at the end of the run-up, for a drive with inputs, "1800 rpm" or in rad/s [default: 600 rpm]
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    speed: Option<String>,
    /// Duration of the run-up, "0.5 s" or in s [default: half of the run]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    ramp: Option<String>,
    /// Fewer settings and repetitions
    #[arg(long)]
    quick: bool,
    /// Replace files that no command wrote
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    format: ReportFormat,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let scene = read(&args.scene)?;
    let folder = files::folder(args.output.as_deref(), "tradeoff", &scene.name)?;
    let options = Options {
        turns: args.turns,
        speed: speed_option(&args.speed)?,
        ramp: optional("ramp", &args.ramp, &unit::TIME)?,
        quick: args.quick,
    };
    let failed = |fault: Fault| of_option(&fault).unwrap_or_else(|| failure(fault.within(args.scene.display())));
    let findings =
        Bar::during(&scene.name, |progress| tradeoff::study(&scene.resource(), &options, progress)).map_err(failed)?;
    let place = ReportFiles {
        folder: Some(&folder),
        inputs: scene.files,
        scene: Some(&scene.document),
        force: args.force,
        ..ReportFiles::default()
    };
    args.format.deliver(findings.report(), &findings, place)
}
