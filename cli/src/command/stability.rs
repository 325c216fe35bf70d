//! `camdrive stability SCENE`

use super::measured::Measured;
use super::output::Bar;
use super::{Failure, Format, failure, files, quantity, read};
use camdrive::drives::Fault;
use camdrive::drives::unit;
use camdrive_design::stability::{self, MOST_ORDERS, Options, Report, figures, table};
use camdrive_design::text::{self, Page};
use std::path::{Path, PathBuf};

/// Maps the speeds at which a drive with periodic coefficients is unstable, and the damping that prevents it.
///
/// Takes every drive that is an oscillator with periodic coefficients; the elastic input shaft is linearised. Floquet
/// multipliers at the speed of the scene; for each order j the unstable speeds, the critical damping ratio θ* and the
/// safety θ/θ*, exact, with the classical bounds beside them; the load of the elastic member over its kinetostatic
/// value R, and the resonances.
///
/// Prints the tables and writes NAME.csv (orders), NAME.json, and unless --quick NAME.map.csv, NAME.modulation.svg and
/// NAME.damping.svg, the latter with the borders of the classical formulas dashed beside the exact ones, and of a parallel
/// crank NAME.crank.svg, θ* over the stiffness σ; for drives with a load NAME.load.csv and .svg, the load over the turn
/// beside the kinetostatic one, NAME.amplification.csv and .svg as well.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive stability examples/transfer_manipulator/hs3.toml
  camdrive stability examples/transfer_manipulator/hs3.toml --speed \"60 rpm\" --speed \"92 rpm\"
  camdrive stability examples/transfer_manipulator/scene.toml --from \"30 rpm\" --to \"900 rpm\" --damping 0.01")]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Folder for tables and diagrams [default: stability-NAME]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Speed to examine, "46 rpm" or in rad/s, negative backwards; several are possible [default: that of the scene]
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    speed: Vec<String>,
    /// Lowest speed of the diagrams
    #[arg(long, value_name = "SPEED", requires = "to", allow_hyphen_values = true)]
    from: Option<String>,
    /// Highest speed of the diagrams
    #[arg(long, value_name = "SPEED", requires = "from", allow_hyphen_values = true)]
    to: Option<String>,
    /// Damping ratio instead of that of the scene
    #[arg(long, value_name = "RATIO", allow_negative_numbers = true)]
    damping: Option<f64>,
    /// Number of orders [default: those at the speeds examined, 8 to 40]
    #[arg(long, value_name = "NUMBER")]
    orders: Option<usize>,
    /// Modulation at the upper edge of its diagram, that of the scene = 1 [default: 1.5, less where inertia would vanish]
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true)]
    modulation: Option<f64>,
    /// Without the maps
    #[arg(long)]
    quick: bool,
    #[command(flatten)]
    measured: Measured,
    #[command(flatten)]
    format: Format,
}

impl Args {
    fn options(&self) -> Result<Options, Failure> {
        let refused = |name: &str, message: &str, hint: &str| failure(format!("--{name}: {message}\n  = hint: {hint}"));
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
    let fault = |fault: Fault| failure(format!("{}: {fault}", args.scene.display()));
    let folder = files::folder(args.output.as_deref(), "stability", &scene.name)?;
    let report = Bar::beside(&scene.name, |tell| stability::study_scene(&scene.resource(), &options, tell));
    let report = report.map_err(fault)?;
    let (parts, courses) = parts(&folder, &report, &args.measured)?;
    let written = files::write(&parts, &[scene.files, courses].concat())?;
    args.format.print(|width| text(&report, width) + "\n" + &written, || text::json(&report))
}

type Parts = (Vec<(PathBuf, String)>, Vec<PathBuf>);

/// Tables and diagrams, and the files of measured courses.
fn parts(folder: &Path, report: &Report, measured: &Measured) -> Result<Parts, Failure> {
    let mut parts = vec![("csv", table::orders_csv(report)), ("json", text::json(report))];
    if !report.over_damping.is_empty() || !report.over_modulation.is_empty() {
        parts.push(("map.csv", table::map_csv(report)));
        parts.push(("damping.svg", Ok(figures::over_damping(report).svg())));
        parts.push(("modulation.svg", Ok(figures::over_modulation(report).svg())));
    }
    if let Some(crank) = &report.crank {
        parts.push(("crank.svg", Ok(figures::crank(report, crank).svg())));
    }
    if !report.amplification.is_empty() {
        parts.push(("amplification.csv", table::amplification_csv(report)));
        parts.push(("amplification.svg", Ok(figures::amplification(report).svg())));
    }
    let mut load = (!report.courses.is_empty()).then(|| figures::load(report));
    let courses = measured.lay_over(load.iter_mut().map(|diagram| ("load", diagram)))?;
    if let Some(load) = load {
        parts.push(("load.csv", table::load_csv(report)));
        parts.push(("load.svg", Ok(load.svg())));
    }
    Ok((files::report(folder, &report.scene, parts)?, courses))
}

/// The report for a terminal.
fn text(report: &Report, width: usize) -> String {
    Page::new(format!("{} ({})", report.scene, report.model), width)
        .lines(table::about(report))
        .section("Stability", table::of_speeds(report))
        .table("Instabilities", &table::of_orders(report))
        .section("", table::below_orders(report))
        .table("Formulas of the source beside the exact values", &table::of_approximations(report))
        .section("", table::below_approximations(report))
        .table("Start from rest", &table::of_transients(report))
        .table("Resonances with harmonic k of the load", &table::of_resonances(report))
        .section("Notes", table::warnings(report))
        .text()
}
