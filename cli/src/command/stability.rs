//! `camdrive stability SCENE`

use super::deliver::{ReportFiles, ReportFormat};
use super::measured::Measured;
use super::output::Bar;
use super::{Failure, failure, files, quantity, read, wrong_argument};
use camdrive::drives::Fault;
use camdrive::drives::unit;
use camdrive_design::stability::{self, MOST_ORDERS, Options};
use std::path::PathBuf;

/// Map the speeds at which a drive is kinetically unstable.
///
/// Takes every drive that is an oscillator with periodic coefficients; an elastic input shaft is linearised. Reports whether the
/// machine may run at its speeds, which speeds to avoid, the least damping at which these are stable, how far the load exceeds its
/// kinetostatic value and where it resonates; then the unstable speeds by order, the start from rest, the resonances. --explain
/// adds Floquet multipliers, Hill's matrices and the printed formulas to the exact values.
///
/// Prints the report and writes NAME.csv (orders), NAME.json, and without --quick NAME.map.csv, NAME.modulation.svg and
/// NAME.damping.svg (exact borders, and dashed the borders by the classical formulas); for a parallel crank NAME.crank.svg, θ* over
/// the stiffness σ; for drives with a load NAME.load.csv and .svg, the load over the turn and its kinetostatic value, and
/// NAME.amplification.csv and .svg.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive stability examples/transfer_manipulator/hs3.toml
  camdrive stability examples/transfer_manipulator/hs3.toml --speed \"60 rpm\" \\
      --speed \"92 rpm\"
  camdrive stability examples/transfer_manipulator/scene.toml \\
      --from \"30 rpm\" --to \"900 rpm\" --damping 0.01")]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Folder for tables and diagrams [default: stability-NAME]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Speed to examine, "46 rpm" or in rad/s, negative backwards; repeatable [default: the scene's]
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    speed: Vec<String>,
    /// Lowest speed of the diagrams
    #[arg(long, value_name = "SPEED", requires = "to", allow_hyphen_values = true)]
    from: Option<String>,
    /// Highest speed of the diagrams
    #[arg(long, value_name = "SPEED", requires = "from", allow_hyphen_values = true)]
    to: Option<String>,
    /// Damping ratio instead of the scene's
    #[arg(long, value_name = "RATIO", allow_negative_numbers = true)]
    damping: Option<f64>,
    /// Number of orders [default: enough for the examined speeds, 8 to 40]
    #[arg(long, value_name = "NUMBER")]
    orders: Option<usize>,
    /// Modulation at the upper edge of its diagram; the scene's is 1 [default: 1.5, less if inertia would vanish]
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    modulation: Option<f64>,
    /// Without the maps
    #[arg(long)]
    quick: bool,
    /// Replace files that no command wrote
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    measured: Measured,
    #[command(flatten)]
    format: ReportFormat,
}

impl Args {
    fn options(&self) -> Result<Options, Failure> {
        let refused = |name: &str, message: &str, hint: &str| wrong_argument(format!("--{name}: {message}")).hint(hint);
        let speed = |name: &str, text: &String| {
            let value = quantity(name, text, &unit::ANGULAR_VELOCITY)?;
            let hint = "at rest the coefficients do not vary; the speed of a drive that turns backwards is negative";
            if value == 0.0 { Err(refused(name, "the drive does not turn at speed 0", hint)) } else { Ok(value) }
        };
        let within = |name: &str, value: Option<f64>, [least, most]: [f64; 2], example: f64| match value {
            Some(value) if !(least..=most).contains(&value) => Err(refused(
                name,
                &format!("{value} is out of range\n  = admissible: {least} to {most}"),
                &format!("write for example {example}"),
            )),
            value => Ok(value),
        };
        let range = match (&self.from, &self.to) {
            (Some(from), Some(to)) => {
                let (low, high) = (speed("from", from)?, speed("to", to)?);
                if low.abs() >= high.abs() {
                    let message = format!("{to} is not faster than --from {from}");
                    return Err(refused("to", &message, "name two speeds, the slower one first"));
                }
                Some([low, high])
            }
            _ => None,
        };
        if let Some(orders) = self.orders.filter(|orders| !(1..=MOST_ORDERS).contains(orders)) {
            let message = format!("{orders} is out of range\n  = admissible: 1 to {MOST_ORDERS}");
            return Err(refused("orders", &message, "leave it out for the usual ones"));
        }
        Ok(Options {
            speeds: self.speed.iter().map(|text| speed("speed", text)).collect::<Result<_, _>>()?,
            range,
            orders: self.orders,
            damping: within("damping", self.damping, [0.0, 10.0], 0.03)?,
            modulation: within("modulation", self.modulation, [1e-6, 100.0], 2.0)?,
            quick: self.quick,
        })
    }
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let options = args.options()?;
    let scene = read(&args.scene)?;
    let fault = |fault: Fault| failure(fault.within(args.scene.display()));
    let folder = files::folder(args.output.as_deref(), "stability", &scene.name)?;
    let findings = Bar::during(&scene.name, |progress| stability::study_scene(&scene.resource(), &options, progress));
    let findings = findings.map_err(fault)?;
    let (inputs, scene, measured) = (scene.files, Some(&scene.document), Some(&args.measured));
    let place =
        ReportFiles { folder: Some(&folder), inputs, scene, measured, force: args.force, ..ReportFiles::default() };
    args.format.deliver(findings.report(), &findings, place)
}
