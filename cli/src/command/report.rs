//! `camdrive report SCENE`, `camdrive report SYSTEM` and `camdrive report STUDY`

use super::clearance::noise;
use super::output::Bar;
use super::{Failure, cam, check, failure, files, forces, read, show, steady, study, system, wrong_argument};
use crate::document::input::{is_study, is_system};
use crate::export::{model_description::unit, picture};
use crate::live::page::Module;
use crate::scene::Resolved;
use crate::study::Subject;
use camdrive::drives::variable::{Causality, Kind};
use camdrive::drives::{Description, Fault};
use camdrive_design::cam_geometry::Tolerances;
use camdrive_design::cam_geometry::report::CamSet;
use camdrive_design::clearance;
use camdrive_design::plot::Diagram;
use camdrive_design::report::terminal::shown;
use camdrive_design::report::unit::ONE;
use camdrive_design::report::{Block, Level, Report, Table, Unit, Verdict, html};
use camdrive_design::resource::{Described, Scene};
use camdrive_design::stability::{self, Options};
use camdrive_design::text::counted;
use std::path::{Path, PathBuf};

/// Write one page about a scene, a system or a study.
///
/// For a scene: one verdict from all studies, its motion, its cams, values, forces and stability; `camdrive tradeoff` compares
/// speed with accuracy. For a system: its parts, and the errors of its outputs over the communication step of each exchange. For a
/// study: the results in its store, with all runs so far. The page needs no network: tables sort, diagrams show their values under
/// the pointer and with the arrow keys, and it prints on A4. A study that fails shows the reason in its part.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive report examples/guide_bar/scene.toml
  camdrive report examples/sealing_machine/scene.toml -o machine.html
  camdrive report examples/guide_bar/scene.toml --live
  camdrive report examples/two_cams/system.toml
  camdrive report study-backlash_map/")]
pub struct Args {
    /// Scene, system or study file (TOML), an FMU with its scene inside, a system by SSP 1.0, or the store of a study
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The page [default: NAME.html, for a study study-NAME.html]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Diagrams, figures and verdict follow sliders for the values of the scene. The points of a study open this page of their
    /// scene. Needs the module of the wheel or of `packaging/build wasm`
    #[arg(long)]
    live: bool,
    /// Replace files that no command wrote
    #[arg(long)]
    force: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let path = &args.file;
    if args.live {
        return live(args);
    }
    let (name, reports, inputs) = if is_system(path) {
        let system = system::read(path)?;
        let coupling = system::study::findings(path, &system).map(|(findings, _)| findings.report());
        let mut glance = system::glance(&system.name, &system);
        // The page has room for the connections.
        glance.body.append(&mut glance.explained);
        let reports = vec![glance, part_of(path, "communication steps", coupling)];
        (system.name, reports, system.files)
    } else if path.is_dir() || is_study(path) {
        let findings = study::findings(path)?;
        (format!("study-{}", findings.name), vec![findings.report()], vec![path.clone()])
    } else {
        let scene = read(path)?;
        let reports = of_scene(path, &scene)?;
        (scene.name, reports, scene.files)
    };
    let page = args.output.clone().unwrap_or_else(|| format!("{name}.html").into());
    let title = reports.first().map_or("", |report| &report.name);
    write(args, page, html::page(title, &reports), &inputs)
}

fn write(args: &Args, page: PathBuf, text: String, inputs: &[PathBuf]) -> Result<(), Failure> {
    files::no_stream(&page, "-o", "a file")?;
    let results = [(page, text)];
    files::keep(&results, inputs, args.force)?;
    show(&files::write(&results, inputs)?)
}

/// The page of a scene that computes.
fn live(args: &Args) -> Result<(), Failure> {
    let path = &args.file;
    if is_system(path) || path.is_dir() {
        let message = format!("{}: --live is for a scene, or for the file of a study of one", path.display());
        return Err(wrong_argument(message).hint("name the file"));
    }
    if is_study(path) {
        return live_study(args);
    }
    let scene = read(path)?;
    let module = Module::at_hand().map_err(failure)?.ok_or_else(|| failure(Module::MISSING.to_owned()))?;
    let page = args.output.clone().unwrap_or_else(|| format!("{}.live.html", scene.name).into());
    let others = others(path, &scene)?;
    write(args, page, module.page(&scene, others), &scene.files)
}

/// The page of a study and that of its scene, which its points open.
fn live_study(args: &Args) -> Result<(), Failure> {
    let (study, _) = study::read(&args.file)?;
    let Subject::Scene(scene) = &study.subject else {
        return Err(wrong_argument(format!("{}: --live is for the study of a scene", args.file.display())));
    };
    let findings = study::findings(&args.file)?;
    let module = Module::at_hand().map_err(failure)?.ok_or_else(|| failure(Module::MISSING.to_owned()))?;
    let page = args.output.clone().unwrap_or_else(|| format!("study-{}.html", findings.name).into());
    files::no_stream(&page, "-o", "a file")?;
    let (report, link) = (findings.report(), format!("{}.live.html", scene.name));
    let linked = match findings.is_map() {
        true => html::linked(&report.name, std::slice::from_ref(&report), &link),
        false => html::page(&report.name, std::slice::from_ref(&report)),
    };
    let results = [(page.with_file_name(link), module.page(scene, Vec::new())), (page, linked)];
    let inputs = [vec![args.file.clone()], scene.files.clone()].concat();
    files::keep(&results, &inputs, args.force)?;
    show(&files::write(&results, &inputs)?)
}

/// The report of a study, or the reason why it failed.
fn part_of(path: &Path, study: &str, found: Result<Report, Failure>) -> Report {
    found.unwrap_or_else(|Failure { fault, .. }| {
        let mut report = Report::new("", study);
        let place = format!("{}: ", path.display());
        let why = fault.message.trim_start_matches("error: ").trim_start_matches(&place);
        let hint = fault.hint.iter().map(|hint| format!(" – {hint}")).collect::<String>();
        report.verdict.result(Level::Mind, format!("Not studied: {why}{hint}."));
        report
    })
}

/// The reports of all studies of a scene: one verdict on all of them, the motion, the cams, loads and the rest.
fn of_scene(path: &Path, scene: &Resolved) -> Result<Vec<Report>, Failure> {
    let mut drive = scene.resource().build().map_err(failure)?;
    drive.set_up(0.0, None);
    let mut reports = Vec::new();
    // With inputs for the speed, the scene has no speed to study.
    let turns = forces::speed_of(&scene.scene).is_some();
    if turns || scene.scene.drive().is_none() {
        let motion = steady::study(path, scene, None, [None; 2]).map(|findings| findings.report());
        reports.push(part_of(path, "periodic motion", motion));
    }
    let overview = check::overview_of(scene);
    let mut values = overview.report(&scene.name, "characteristic values");
    reports.iter().for_each(|motion| values.verdict.leave_out(&motion.verdict));
    reports.push(values);
    reports.extend(studies(path, scene)?);
    let mut glance = glance(scene, &drive);
    glance.verdict = Verdict::over_all(&reports);
    overview.note(&mut glance.verdict);
    reports.insert(0, glance);
    reports.push(model(scene, &mut drive).map_err(failure)?);
    Ok(reports)
}

/// The reports that a page that computes shows as the file has the scene.
fn others(path: &Path, scene: &Resolved) -> Result<Vec<Report>, Failure> {
    let mut drive = scene.resource().build().map_err(failure)?;
    drive.set_up(0.0, None);
    let mut reports = studies(path, scene)?;
    reports.push(model(scene, &mut drive).map_err(failure)?);
    Ok(reports)
}

/// The reports of cams, loads, stability and clearance.
fn studies(path: &Path, scene: &Resolved) -> Result<Vec<Report>, Failure> {
    let mut reports = Vec::new();
    let mut part = |study: &str, found: Result<Report, Failure>| reports.push(part_of(path, study, found));
    let turns = forces::speed_of(&scene.scene).is_some();
    if !scene.cams.is_empty() {
        let shapes = cam::shapes(path, scene, &scene.cams, Tolerances::default());
        part("cams", shapes.map(|shapes| CamSet::new(&scene.name, &shapes).report()));
    }
    if turns && !matches!(scene.scene, Scene::ParametricDrive(_)) {
        part("forces", forces::study(path, scene, None).map(|(report, _)| report));
    }
    match &scene.scene {
        Scene::ElasticShaft(_) | Scene::ParametricDrive(_) => {
            let found = Bar::during(&scene.name, |progress| {
                stability::study_scene(&scene.resource(), &Options::default(), progress)
            });
            part("stability", found.map(|findings| findings.report()).map_err(failure));
        }
        Scene::BacklashDrive(_) if turns => {
            let options = clearance::Options { noise: noise(scene), ..clearance::Options::default() };
            let found = Bar::during(&scene.name, |progress| clearance::study(&scene.resource(), &options, progress));
            part("passage of the clearance", found.map(|findings| findings.report()).map_err(failure));
        }
        _ => (),
    }
    Ok(reports)
}

/// The scene at a glance: its summary and its curves.
fn glance(scene: &Resolved, drive: &Described) -> Report {
    let mut report = Report::new(&scene.name, format!("the design at a glance ({})", scene.scene.model_name()));
    let summary = drive.documentation().map_or(String::new(), |text| text.summary);
    report.lines("", [scene.description.clone(), summary].into_iter().filter(|text| !text.is_empty()));
    for (i, curve) in drive.curves().iter().enumerate() {
        report.diagram(&i.to_string(), Diagram { title: curve.title.clone(), ..picture::diagram(curve) });
    }
    report
}

/// The values of the scene, including its loads, and the limits of the model.
fn model(scene: &Resolved, drive: &mut Described) -> Result<Report, Fault> {
    let mut report = Report::new(&scene.name, "values of the scene, and limits of the model");
    let all = drive.descriptions().to_vec();
    let (mut rows, mut zeros) = (Vec::new(), 0);
    for (reference, about) in all.iter().enumerate() {
        if about.causality == Causality::Parameter && !about.name.starts_with("solver.") {
            match drive.get(reference)? {
                // A coefficient or a point of a list.
                0.0 if about.name.ends_with(']') => zeros += 1,
                value => rows.push((about, written(about, value))),
            }
        }
    }
    let zeros = (zeros > 0).then(|| format!("{} of lists are 0 and left out.", counted(zeros, "value")));
    let text = drive.documentation()?;
    report.lines("Left out", text.left_out).lines("Limits", text.limits);
    report.lines("Notes", scene.notes.iter().cloned());
    report.table(
        Table::of("Values", &rows)
            .column("name", "name", ONE, |(about, _)| &about.name)
            .column("value", "value", ONE, |(_, value)| value)
            .column("meaning", "meaning", ONE, |(about, _)| &about.text)
            .below(zeros),
    );
    report.explained.push(Block::Equations("Equations".to_owned(), text.equations));
    report.explain("Solution and accuracy", text.accuracy.into_iter().map(|(of, text)| format!("{of}: {text}")));
    report.explain("Sources", text.sources);
    Ok(report)
}

/// A value in a form for people.
fn written(about: &Description, value: f64) -> String {
    match &about.kind {
        Kind::Boolean => if value != 0.0 { "yes" } else { "no" }.to_owned(),
        Kind::Enumeration(of) => of.items.get(value as usize - 1).map_or(String::new(), |(name, _)| (*name).to_owned()),
        kind => shown(value, &Unit::of(unit(kind))),
    }
}
