//! `camdrive synthesize TASK`

use super::output::Bar;
use super::{Failure, Format, files, read};
use crate::scene;
use camdrive_design::synthesis::Infeasible;
use camdrive_design::synthesis::study::{Assignment, Study};
use std::path::{Path, PathBuf};
use toml_edit::{DocumentMut, Item, value};

/// Synthesises a cam profile of few harmonics (HS profile) from a motion task.
///
/// A task prescribes U, U′, U″ in ranges of the drive angle, dwells, exact points and bounds; the objective is a sum of
/// squared errors, a largest error, the peak of the acceleration or of the torque. With an elastic output member the cam
/// is the one that keeps the task at all speeds. Prints a report, writes the profile as a scene fragment [cam] (or the
/// scene that the task or --scene names, with this cam), and with --report tables and diagrams.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive synthesize examples/dwell_synthesis/task.toml
  camdrive synthesize examples/dwell_synthesis/task.toml -o profile.toml --report report/
  camdrive synthesize examples/loom/tasks/gripper.toml --scene examples/loom/scene.toml --follower 1 -o loom.toml")]
pub struct Args {
    /// Task file (TOML)
    task: PathBuf,
    /// File for the profile [default: NAME_profile.toml]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Scene that gets the cam, instead of the one that the task names
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// Follower of the machine that gets the cam, counted from 1
    #[arg(long, value_name = "NUMBER")]
    follower: Option<usize>,
    /// Folder for tables (CSV, JSON) and diagrams (SVG)
    #[arg(long, value_name = "FOLDER")]
    report: Option<PathBuf>,
    /// Replace the file of -o even if no command wrote it
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    format: Format,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let mut assignment = scene::synthesis::read(&args.task).map_err(|faults| Failure(faults.to_string()))?;
    assignment.scene = args.scene.clone().or(assignment.scene);
    let target = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}_profile.toml", assignment.name)));
    if let Some(folder) = &args.report {
        files::no_file(folder, "--report")?;
    }
    // A scene that is wrong is told before the work begins.
    let machine = assignment.scene.as_deref().map(|scene| machine(scene, args.follower)).transpose()?;
    let (machine, mut inputs) = machine.unzip();
    inputs.get_or_insert_default().push(args.task.clone());
    let inputs = inputs.unwrap_or_default();
    files::no_foreign(&target, &inputs, args.force)?;
    if machine.is_none() && args.follower.is_some() {
        return Err(Failure(
            "error: --follower: there is no scene\n  = hint: name the machine with --scene".to_owned(),
        ));
    }
    let study = Bar::beside(&assignment.name, |tell| assignment.study(&tell));
    let words = |fault: Infeasible| fault.words(&assignment.task, &assignment.names);
    let study = study.map_err(|fault| Failure(format!("error: {}: {}", args.task.display(), words(fault))))?;
    let profile = profile(&study, args, machine);
    if let Some(scene) = &assignment.scene {
        let folder = scene.parent().unwrap_or(Path::new(""));
        scene::resolve(&target.display().to_string(), &profile, folder)
            .map_err(|faults| Failure(faults.to_string()))?;
    }
    let mut results = vec![(target, profile)];
    if let Some(folder) = &args.report {
        results.extend(report(folder, &assignment, &study)?);
    }
    let written = files::write(&results, &inputs)?;
    args.format.print(|width| study.text(width) + "\n" + &written, || study.json())
}

/// The scene that gets the cam, its own one or that of a follower, and the files that it was read from.
fn machine(path: &Path, follower: Option<usize>) -> Result<(DocumentMut, Vec<PathBuf>), Failure> {
    let resolved = read(path)?;
    let document = files::document(path)?;
    let failure = |message: &str| Failure(format!("error: {}: {message}", path.display()));
    let followers = document.get("follower").and_then(|item| item.as_array_of_tables());
    match (followers, follower) {
        (Some(list), Some(j)) if (1..=list.len()).contains(&j) => Ok((document, resolved.files)),
        (Some(list), Some(j)) => {
            let message = format!("there is no follower {j}; the scene has {}, counted from 1", list.len());
            Err(failure(&message))
        }
        (Some(_), None) => {
            Err(failure("a machine has several cams\n  = hint: say with --follower which of them the profile replaces"))
        }
        (None, Some(_)) => Err(failure(match resolved.model {
            "RigidMachine" => "the machine has no tables [[follower]]",
            _ => "this is no machine with followers\n  = hint: leave --follower out",
        })),
        (None, None) if !document.contains_key("cam") => {
            Err(failure("this scene has no [cam] that a profile could replace"))
        }
        (None, None) => Ok((document, resolved.files)),
    }
}

/// The profile as a scene, or as the part [cam] of one.
fn profile(study: &Study, args: &Args, machine: Option<DocumentMut>) -> String {
    let cam = Item::Table(files::cam(&study.cam, study.assignment.unit));
    let mut document = machine.unwrap_or_default();
    let followers = document.get_mut("follower").and_then(|item| item.as_array_of_tables_mut());
    match (followers, args.follower) {
        // The machine keeps its name, and a follower whose tool's motion is prescribed that key.
        (Some(list), Some(j)) => {
            if let Some(follower) = list.get_mut(j - 1) {
                let key = if follower.contains_key("tool") { "tool" } else { "cam" };
                follower[key] = cam;
            }
        }
        _ => {
            if !document.is_empty() {
                document["name"] = value(study.assignment.name.clone());
            }
            document["cam"] = cam;
        }
    }
    files::signed(&document, "HS profile", &args.task, "synthesize")
}

/// Tables and diagrams.
fn report(folder: &Path, assignment: &Assignment, study: &Study) -> Result<Vec<(PathBuf, String)>, Failure> {
    let tables = study.csv().map_err(|fault| Failure(format!("error: {fault}")))?;
    let tables = tables.into_iter().map(|(ending, text)| (ending, Ok(text)));
    let data = std::iter::once(("json".to_owned(), study.json()));
    let diagrams = study.figures().into_iter().map(|(name, diagram)| (format!("{name}.svg"), Ok(diagram.svg())));
    files::report(folder, &assignment.name, tables.chain(data).chain(diagrams))
}
