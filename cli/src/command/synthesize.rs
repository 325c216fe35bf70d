//! `camdrive synthesize TASK`

use super::deliver::{ReportFiles, ReportFormat};
use super::measured::Measured;
use super::output::Bar;
use super::{Failure, failure, files, read, wrong_argument};
use crate::document::{Document, Kind, input};
use crate::{scene, task};
use camdrive_design::resource::Scene;
use camdrive_design::synthesis::Infeasible;
use camdrive_design::synthesis::study::Study;
use camdrive_design::synthesis::together::Together;
use std::path::{Path, PathBuf};
use toml_edit::{ArrayOfTables, Item, Table};

/// Design a cam law of few harmonics (HS profile) for a motion task.
///
/// A task prescribes U, U′, U″ in ranges of the drive angle, dwells, exact points and bounds; the objective is a sum of squared
/// errors, a largest error, the peak of the acceleration or of the torque. With an elastic output member the cam keeps the task at
/// all speeds. Several laws of a task are found together, with restrictions and distances between their tools, and go to the
/// followers of a machine in their order. Prints what the law reaches, what to change and how sure this is. Writes the profile as a
/// scene fragment [cam], or the scene of the task or of --scene with this cam; with --report, tables and diagrams.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive synthesize examples/dwell_synthesis/task.toml
  camdrive synthesize examples/dwell_synthesis/task.toml -o profile.toml \\
      --report report/
  camdrive synthesize examples/loom/task.toml \\
      --scene examples/loom/scene.toml -o loom.toml
  camdrive synthesize examples/loom/task.toml --law gripper \\
      --scene examples/loom/gripper.toml -o gripper.toml")]
pub struct Args {
    /// Task file (TOML)
    task: PathBuf,
    /// File for the profile [default: NAME_profile.toml]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Scene that gets the cam, instead of the task's scene
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// Follower of the machine that gets the cam, counted from 1
    #[arg(long, value_name = "NUMBER")]
    follower: Option<usize>,
    /// Law of the task to write, instead of all
    #[arg(long, value_name = "NAME")]
    law: Option<String>,
    /// Folder for tables (CSV, JSON) and diagrams (SVG)
    #[arg(long, value_name = "FOLDER")]
    report: Option<PathBuf>,
    /// Replace the file of -o even if no command wrote it
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    measured: Measured,
    #[command(flatten)]
    format: ReportFormat,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let mut assignment = task::read(&args.task).map_err(failure)?;
    assignment.scene = args.scene.clone().or(assignment.scene);
    let target = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}_profile.toml", assignment.name)));
    args.measured.need(args.report.as_ref())?;
    if let Some(folder) = &args.report {
        files::no_file(folder, "--report")?;
    }
    let laws = &assignment.names.laws;
    let chosen = args.law.as_ref().map(|name| law(laws, name)).transpose()?;
    let all = if chosen.is_some() { 1 } else { laws.len().max(1) };
    // A wrong scene is reported before the work starts.
    let machine = assignment.scene.as_deref().map(|scene| machine(scene, args.follower, all)).transpose()?;
    let (machine, mut inputs) = machine.unzip();
    inputs.get_or_insert_default().push(args.task.clone());
    inputs.get_or_insert_default().extend(assignment.files.iter().cloned());
    let inputs = inputs.unwrap_or_default();
    files::no_foreign(&target, &inputs, args.force)?;
    if machine.is_none() && args.follower.is_some() {
        return Err(wrong_argument("--follower: there is no scene").hint("name the machine with --scene"));
    }
    let study = Bar::during(&assignment.name, |progress| Together::new(&assignment, &progress));
    let refused = |fault: Infeasible| fault.fault(&assignment.task, &assignment.names).within(args.task.display());
    let study = study.map_err(|fault| failure(refused(fault)))?;
    let written = chosen.map_or(&study.studies[..], |law| std::slice::from_ref(&study.studies[law]));
    let profile = profile(written, args, machine);
    if let Some(scene) = &assignment.scene {
        let folder = scene.parent().unwrap_or(Path::new(""));
        scene::resolve(&target.display().to_string(), &profile, folder).map_err(failure)?;
    }
    let more = vec![(target, profile.into_bytes())];
    let place = ReportFiles {
        folder: args.report.as_deref(),
        more,
        inputs,
        scene: None,
        force: args.force,
        measured: Some(&args.measured),
    };
    args.format.deliver(study.report(), &study.findings(), place)
}

/// The index of the law with this name.
fn law(laws: &[String], name: &str) -> Result<usize, Failure> {
    laws.iter().position(|law| law == name).ok_or_else(|| {
        let hint = if laws.is_empty() { "leave --law out" } else { &format!("choose {}", laws.join(", ")) };
        wrong_argument(format!("--law: the task has no law `{name}`")).hint(hint)
    })
}

/// The scene that gets the cams, its own cam or its followers', and the files of the scene.
fn machine(path: &Path, follower: Option<usize>, laws: usize) -> Result<(Document, Vec<PathBuf>), Failure> {
    let resolved = read(path)?;
    let (_, document) = input::document(path, Kind::Scene)?;
    let failure = |message: &str| failure(format!("{}: {message}", path.display()));
    let followers = followers(&document, "crank");
    let first = follower.unwrap_or(1);
    let replaced = followers.iter().flatten().skip(first.saturating_sub(1)).take(laws.max(1));
    if let Some(j) = replaced.enumerate().find_map(|(j, has_crank)| has_crank.then_some(first + j)) {
        return Err(failure(&format!("follower {j} sits on the shaft without a cam")));
    }
    if laws > 1 {
        let count = followers.map_or(0, |list| list.len());
        return match follower.is_none() && count >= laws {
            true => Ok((document, resolved.files)),
            false => {
                Err(failure(&format!("the task has {laws} laws for the followers 1 to {laws}, the scene has {count}"))
                    .hint("choose one with --law, and its follower with --follower"))
            }
        };
    }
    match (followers, follower) {
        (Some(list), Some(j)) if (1..=list.len()).contains(&j) => Ok((document, resolved.files)),
        (Some(list), Some(j)) => {
            let message = format!("there is no follower {j}; the scene has {}, counted from 1", list.len());
            Err(failure(&message))
        }
        (Some(_), None) => Err(failure("a machine has several cams").hint("choose the one to replace with --follower")),
        (None, Some(_)) => Err(match resolved.scene {
            Scene::RigidMachine(_) => failure("the machine has no tables [[follower]]"),
            _ => failure("this is not a machine with followers").hint("leave --follower out"),
        }),
        (None, None) if !document.table.contains_key("cam") => Err(failure("this scene has no [cam] to replace")),
        (None, None) => Ok((document, resolved.files)),
    }
}

/// For each of the tables [[follower]], whether it has a key; None without followers.
fn followers(document: &Document, key: &str) -> Option<Vec<bool>> {
    let list = document.table.get("follower")?.get_ref().tables();
    Some(list.iter().map(|(_, follower)| follower.contains_key(key)).collect())
}

/// The profiles as a scene, or as a fragment [cam] or [[follower]].
fn profile(studies: &[Study], args: &Args, machine: Option<Document>) -> String {
    let mut document = machine.unwrap_or_default();
    let cam = |study: &Study| files::cam(&study.cam, study.assignment.unit);
    let is_scene = !document.table.is_empty();
    if studies.len() > 1 && !is_scene {
        let list = studies.iter().map(|_| Table::new()).collect::<ArrayOfTables>();
        document.set("follower", Item::ArrayOfTables(list));
    }
    match (followers(&document, "tool"), studies) {
        // The machine keeps its name, and a follower with a prescribed motion of its tool keeps that key.
        (Some(list), _) => {
            let first = args.follower.unwrap_or(1);
            for ((j, study), has_tool) in (first..).zip(studies).zip(list.into_iter().skip(first - 1)) {
                document.set(&format!("follower[{j}].{}", if has_tool { "tool" } else { "cam" }), cam(study));
            }
        }
        (None, [study, ..]) => {
            if is_scene {
                document.set("name", args.law.clone().unwrap_or_else(|| study.assignment.name.clone()));
            }
            document.set("cam", cam(study));
        }
        (None, []) => (),
    }
    files::signed(&document, "HS profile", &args.task, "synthesize")
}
