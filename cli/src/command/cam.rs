//! `camdrive cam SCENE`

use super::deliver::{ReportFiles, ReportFormat};
use super::measured::Measured;
use super::output::Bar;
use super::{Failure, failure, files, print_message, read, wrong_argument};
use crate::document::units;
use crate::scene::Resolved;
use crate::scene::geometry::CamPlan;
use camdrive::drives::{Fault, unit};
use camdrive_design::cam_geometry::report::CamSet;
use camdrive_design::cam_geometry::{Finding, Shape, Tolerances};
use camdrive_design::report::Level;
use camdrive_design::resource::Scene;
use camdrive_design::text;
use std::path::{Path, PathBuf};

/// Generate cam contours (DXF, SVG, CSV) and tables for motion controllers.
///
/// Takes the motion law and the geometry of each cam ([geometry], [follower.geometry]). Reports the pressure angle, radii of
/// curvature, undercut, crossings and sizes with their angles; with mechanisms after the cam, the least transmission angle. Names
/// what runs badly and what to change, and refuses a cam that cannot be machined or does not move the follower as prescribed.
///
/// Writes NAME.csv (path and contours; a curvature is positive where the curve bulges away from the axis), NAME.dxf and NAME.svg
/// (true size, mm), NAME.pressure_angle.svg (for a flat face NAME.contact.svg), NAME.curvature.svg, cam tables for motion
/// controllers NAME.plcopen.csv and NAME.plc.txt, and the findings as NAME.json. Cams of a machine are called NAME.follower1 …, the
/// cams of a conjugate pair F and P.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive cam examples/rapier_loom/scene.toml
  camdrive cam compensated.toml -o cams/ --chord-error \"0.5 um\"")]
pub struct Args {
    /// Scene file (TOML) with the geometry of its cams
    scene: PathBuf,
    /// Folder for the files [default: cam-NAME]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Largest distance between a contour and its chords, "1 um" or in m
    #[arg(long, value_name = "LENGTH", default_value = "1 um", allow_hyphen_values = true)]
    chord_error: String,
    /// Largest error if a motion controller joins the points of the cam table with straight lines
    #[arg(long, value_name = "LENGTH", default_value = "1 um", allow_hyphen_values = true)]
    table_error: String,
    /// Cut only this follower, counted from 1; repeatable
    #[arg(long, value_name = "NUMBER", value_delimiter = ',')]
    follower: Vec<usize>,
    /// Write the files even if a cam is refused, and replace files that no command wrote
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    measured: Measured,
    #[command(flatten)]
    format: ReportFormat,
}

/// The finest chord (m): files give a tenth of a nanometre.
const FINEST: f64 = 1e-9;

/// The coarsest chord (m); a coarser polygon is no contour.
const COARSEST: f64 = 1e-2;

/// A length of an option.
fn length(name: &str, text: &str) -> Result<f64, Failure> {
    let value = units::parse(text, &unit::LENGTH)
        .map_err(|e| wrong_argument(format!("--{name}: {}", e.message)).hint("write for example \"1 um\""))?;
    if (FINEST..=COARSEST).contains(&value) {
        return Ok(value);
    }
    Err(wrong_argument(format!("--{name}: {text} is out of range\n  = admissible: {FINEST:e} to {COARSEST} m"))
        .hint("write for example \"1 um\""))
}

/// The selected cams.
fn chosen(args: &Args, cams: &[CamPlan], followers: usize) -> Result<Vec<CamPlan>, Failure> {
    let place = args.scene.display();
    if let Some(wrong) = args.follower.iter().find(|j| !(1..=followers).contains(j)) {
        return Err(match followers {
            0 => wrong_argument(format!("--follower: {place} is not a machine with followers"))
                .hint("leave --follower out"),
            _ => wrong_argument(format!(
                "--follower: there is no follower {wrong}; the scene has {followers}, counted from 1"
            )),
        });
    }
    if let Some(plain) = args.follower.iter().find(|j| !cams.iter().any(|cam| cam.follower == Some(**j))) {
        return Err(wrong_argument(format!("--follower: {place} has no [follower.geometry] for follower {plain}")));
    }
    let wanted = |cam: &&CamPlan| args.follower.is_empty() || cam.follower.is_some_and(|j| args.follower.contains(&j));
    Ok(cams.iter().filter(wanted).cloned().collect())
}

/// The shapes of cams of a scene.
pub fn shapes(path: &Path, scene: &Resolved, cams: &[CamPlan], tolerances: Tolerances) -> Result<Vec<Shape>, Failure> {
    let shape = |cam: &CamPlan| {
        let name = cam.follower.map_or(scene.name.clone(), |j| format!("{}.follower{j}", scene.name));
        let fault = |fault: Fault| failure(fault.within(format_args!("{}: {name}", path.display())));
        let shape = Bar::during(&name, |_| Shape::new(&name, &cam.law, cam.plan, tolerances)).map_err(fault)?;
        Ok(shape.with(cam.mechanisms.iter().map(Finding::of_transmission)))
    };
    cams.iter().map(shape).collect()
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let tolerances = Tolerances {
        chord: length("chord-error", &args.chord_error)?,
        table: length("table-error", &args.table_error)?,
    };
    let scene = read(&args.scene)?;
    // A changed table must be known before its cam is cut.
    for table in &scene.smoothed {
        print_message(&format!("note: {}: {}\n", text::in_one_line(args.scene.display()), table.sentence));
    }
    let folder = files::folder(args.output.as_deref(), "cam", &scene.name)?;
    let followers = scene.scene.followers();
    let cams = chosen(args, &scene.cams, followers)?;
    if cams.is_empty() {
        let table = if followers > 0 { "[follower.geometry]" } else { "[geometry]" };
        let place = args.scene.display();
        return Err(match scene.scene {
            Scene::ParametricDrive(_) => failure(format!("{place}: a ParametricDrive has no cam")),
            _ => failure(format!("{place}: the scene has no geometry of a cam"))
                .hint(format!("add {table} next to the law, with follower, roller_radius and base_radius")),
        });
    }
    let shapes = shapes(&args.scene, &scene, &cams, tolerances)?;
    let refused = shapes.iter().any(|shape| shape.verdict() == Level::Bad) && !args.force;
    let findings = CamSet::new(&scene.name, &shapes);
    let report = findings.report();
    let mut place = ReportFiles {
        measured: Some(&args.measured),
        inputs: scene.files,
        scene: Some(&scene.document),
        force: args.force,
        ..ReportFiles::default()
    };
    if !refused {
        place.folder = Some(&folder);
        for shape in &shapes {
            place.more.extend(files::report(&folder, &shape.name, shape.files())?);
        }
        files::keep(&place.more, &place.inputs, args.force)?;
    }
    args.format.deliver(report, &findings, place)?;
    if !refused {
        return Ok(());
    }
    let faults = shapes.iter().flat_map(|shape| shape.complaints(Level::Bad));
    let faults: Vec<String> = faults.map(|line| format!("error: {line}")).collect();
    Err(Failure::new(faults.join("\n")).hint("no file is written; --force writes them nevertheless"))
}
