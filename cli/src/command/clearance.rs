//! `camdrive clearance SCENE`

use super::deliver::{ReportFiles, ReportFormat};
use super::measured::Measured;
use super::output::Bar;
use super::{Failure, failure, files, limited, of_option, optional, read, speed_option, wrong_argument};
use crate::document::keys::LAW;
use crate::document::limits::POSITIVE;
use crate::scene::Resolved;
use crate::scene::plan::STANDARD_LAWS;
use camdrive::drives::unit;
use camdrive::motion::fourier::HIGHEST_HARMONIC;
use camdrive::motion::table::Points;
use camdrive::motion::{Cycle, CyclePlan, MotionLaw, StandardLaw};
use camdrive_design::clearance::{self, Options};
use camdrive_design::harmonic_analysis::analyse;
use std::f64::consts::TAU;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Show where and how hard a drive passes through its clearance.
///
/// Reports where in the turn the contact opens, where and how hard it closes, the contact force after the impact, whether m1 lifts
/// off the flank again, and the settled motion; and which natural frequency, speed, clearance, mass m1 or damping ratio avoids
/// further impacts in the event-driven model. --explain adds Kaltofen's closed formulas.
///
/// Takes a BacklashDrive, or an ElasticCamDrive with an elastic output together with --clearance and --m1. Each passage starts from
/// the periodic motion with permanent contact.
///
/// Prints the report and writes NAME.json, NAME.passages.csv, NAME.after_impact.csv, NAME.passage_time.csv, NAME.map.csv
/// and, as SVG, NAME.passage_time, NAME.multiple_impacts, NAME.deformation, NAME.force, NAME.acceleration into a folder.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive clearance examples/backlash_drive/scene.toml
  camdrive clearance scene.toml \\
      --compare bestehorn,modified_sine,hs7,other_scene.toml
  camdrive clearance examples/guide_bar/scene.toml --clearance \"0.05 mm\" \\
      --m1 \"2 kg\"")]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Folder for tables and diagrams [default: clearance-NAME]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Clearance instead of the scene's, "0.05 mm" or in m
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    clearance: Option<String>,
    /// Mass between the flanks instead of the scene's, "2 kg" or in kg
    #[arg(long, value_name = "MASS", allow_hyphen_values = true)]
    m1: Option<String>,
    /// Speed instead of the scene's, "300 rpm" or in rad/s
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    speed: Option<String>,
    /// Natural frequency √(c/m2) instead of the scene's, "80 Hz" or in rad/s; changes the stiffness at the same damping ratio
    #[arg(long, value_name = "FREQUENCY", allow_hyphen_values = true)]
    natural_frequency: Option<String>,
    /// Damping ratio b/(2 m2 ω) instead of the scene's
    #[arg(long, value_name = "RATIO", allow_negative_numbers = true)]
    damping: Option<f64>,
    /// Laws instead of the scene's: VDI laws with the same stroke and angles (bestehorn, modified_sine … or all), hsN for the first
    /// N harmonics of the scene's law, or scene files for their cams
    #[arg(long, value_name = "LAW,…", value_delimiter = ',')]
    compare: Vec<String>,
    /// Turns of the settled motion; only the second half counts [default: 40, or 640 where these do not repeat]
    #[arg(long, value_name = "NUMBER")]
    turns: Option<usize>,
    /// Lobes of U″ and of the contact force below this fraction of the largest one count as no passages [default: 1e-9; for a
    /// smoothed table its noise and the smoothing decide]
    #[arg(long, value_name = "PART", allow_negative_numbers = true)]
    ignore: Option<f64>,
    /// Leave out the admissible natural frequencies, speeds, clearances, masses m1 and damping ratios
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

/// Short names of laws, in addition to the names in scenes.
const SHORT_NAMES: [(&str, StandardLaw); 3] =
    [("sine", StandardLaw::SimpleSine), ("345", StandardLaw::Polynomial345), ("4567", StandardLaw::Polynomial4567)];

/// Turns of the settled motion: the first half is left out and two turns are compared; a million turns take seconds to minutes.
const TURNS: RangeInclusive<usize> = 4..=1_000_000;

/// Points of a turn for the harmonics of a law; higher harmonics alias with less than 1e-12 of the stroke.
const ANALYSED: usize = 4096;

pub fn run(args: &Args) -> Result<(), Failure> {
    let scene = read(&args.scene)?;
    let folder = files::folder(args.output.as_deref(), "clearance", &scene.name)?;
    let options = args.options(&scene)?;
    let findings = Bar::during(&scene.name, |progress| clearance::study(&scene.resource(), &options, progress));
    let findings =
        findings.map_err(|fault| of_option(&fault).unwrap_or_else(|| failure(fault.within(args.scene.display()))))?;
    let (inputs, scene, measured) = (scene.files, Some(&scene.document), Some(&args.measured));
    let place =
        ReportFiles { folder: Some(&folder), inputs, scene, measured, force: args.force, ..ReportFiles::default() };
    args.format.deliver(findings.report(), &findings, place)
}

impl Args {
    fn options(&self, scene: &Resolved) -> Result<Options, Failure> {
        if let Some(turns) = self.turns.filter(|turns| !TURNS.contains(turns)) {
            let text = format!("--turns: {turns} is not from {} to {}", TURNS.start(), TURNS.end());
            return Err(wrong_argument(text).hint("only the second half counts; the default is 40"));
        }
        let mut laws = Vec::new();
        for name in &self.compare {
            laws.extend(compared(name.trim(), scene)?);
        }
        Ok(Options {
            clearance: limited("clearance", &self.clearance, &unit::LENGTH, POSITIVE)?,
            m1: limited("m1", &self.m1, &unit::MASS, POSITIVE)?,
            speed: speed_option(&self.speed)?,
            natural_frequency: optional("natural-frequency", &self.natural_frequency, &unit::ANGULAR_VELOCITY)?,
            damping: self.damping,
            turns: self.turns,
            ignore: self.ignore,
            noise: noise(scene),
            quick: self.quick,
            laws,
        })
    }
}

/// The cam of a scene.
fn cam(scene: &Resolved) -> Result<MotionLaw, Failure> {
    scene.scene.cam().cloned().ok_or_else(|| {
        let text = format!("--compare: the scene {} ({}) has no cam", scene.name, scene.scene.model());
        wrong_argument(text).hint("name a scene with [cam]")
    })
}

/// The height (m) up to which lobes of U″ of a scene's cam are noise.
pub fn noise(scene: &Resolved) -> f64 {
    scene.smoothed.iter().find(|table| table.section == "cam").map_or(0.0, |table| table.left)
}

/// The laws of a name, which replace the scene's, each with the height (m) up to which lobes of U″ are noise.
fn compared(name: &str, scene: &Resolved) -> Result<Vec<(String, MotionLaw, f64)>, Failure> {
    if name.ends_with(".toml") {
        let other = read(Path::new(name))?;
        return Ok(vec![(other.name.clone(), cam(&other)?, noise(&other))]);
    }
    let own = cam(scene)?;
    let harmonics = name.strip_prefix("hs").and_then(|count| count.parse::<usize>().ok());
    if let Some(harmonics) = harmonics {
        let angles: Vec<f64> = (0..ANALYSED).map(|i| TAU * i as f64 / ANALYSED as f64).collect();
        let lifts = angles.iter().map(|phi| own.at(*phi).0[0]).collect();
        if !(1..=HIGHEST_HARMONIC).contains(&harmonics) {
            return Err(wrong_argument(format!(
                "--compare {name}: no such number of harmonics\n  = admissible: hs1 to hs{HIGHEST_HARMONIC}"
            ))
            .hint("write for example hs7"));
        }
        let analysis = analyse(Points { angles, lifts }, harmonics)
            .map_err(|e| wrong_argument(format!("--compare {name}: {e}")))?;
        return Ok(vec![(name.to_owned(), MotionLaw::Fourier(analysis.series), noise(scene))]);
    }
    let short = SHORT_NAMES.iter().find(|(short, _)| *short == name).map(|(_, law)| *law);
    let usual = LAW.key("rise_law").choices().iter().find(|names| names.contains(&name)).map(|names| names[0]);
    let named = || STANDARD_LAWS.iter().find(|(name, _)| Some(*name) == usual).map(|(_, law)| *law);
    let laws = match short.or_else(named) {
        Some(law) => vec![law],
        None if name == "all" => StandardLaw::ALL.to_vec(),
        None => {
            let known: Vec<&str> = StandardLaw::ALL.iter().map(|law| law.name()).collect();
            let known = known.join(", ");
            return Err(wrong_argument(format!("--compare: the law `{name}` is not known"))
                .hint(format!("one of {known}, bestehorn, harmonic, all; hsN; or a scene file NAME.toml")));
        }
    };
    let MotionLaw::Cycle(cycle) = &own else {
        return Err(wrong_argument(format!(
            "--compare {name}: the scene {} has no cycle, so stroke and angles are unknown",
            scene.name
        ))
        .hint("write the task as `law = \"cycle\"` and compare this scene's file with it, or name scene files"));
    };
    let same_task = |law: StandardLaw| CyclePlan { rise_law: law, return_law: law, ..*cycle.plan() };
    Ok(laws.into_iter().map(|law| (law.name().to_owned(), MotionLaw::Cycle(Cycle::new(same_task(law))), 0.0)).collect())
}
