//! `camdrive synthesize TASK`

use super::{Failure, print};
use crate::design::synthesis::study::{Assignment, Progress, Study};
use crate::scene;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fmt::Write as _;
use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};

/// Synthesises a cam profile of few harmonics (HS profile) from a motion task.
///
/// A task prescribes U, U′, U″ in ranges of the drive angle, dwells, exact points and bounds; the objective is a sum of
/// squared errors, a largest error, the peak of the acceleration or of the torque. With an elastic output member the cam
/// is the one that keeps the task at all speeds. Prints a report, writes the profile as a scene fragment [cam] (or the
/// scene that the task names, with this cam), and with --report tables and diagrams.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive synthesize examples/dwell_synthesis/task.toml
  camdrive synthesize examples/dwell_synthesis/task.toml -o profile.toml --report report/")]
pub struct Args {
    /// Task file (TOML)
    task: PathBuf,
    /// File for the profile [default: NAME_profile.toml]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Folder for tables (CSV, JSON) and diagrams (SVG)
    #[arg(long, value_name = "FOLDER")]
    report: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let assignment = scene::synthesis::read(&args.task).map_err(|faults| Failure(faults.to_string()))?;
    let target = args.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}_profile.toml", assignment.name)));
    let inputs = std::iter::once(&args.task).chain(&assignment.scene);
    if let Some(input) = inputs.into_iter().find(|input| same_file(input, &target)) {
        let text = format!("error: {}: -o would overwrite an input", input.display());
        return Err(Failure(text));
    }
    if let Some(folder) = args.report.as_ref().filter(|folder| folder.is_file()) {
        return Err(Failure(format!("error: {}: this is a file; --report takes a folder", folder.display())));
    }
    // A scene that is wrong is told before the work begins.
    let machine = assignment.scene.as_deref().map(machine).transpose()?;
    let bar = bar(&assignment.name);
    let study = assignment.study(&|Progress { done, total, stage }| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
        bar.set_message(stage);
    });
    bar.finish_and_clear();
    let study =
        study.map_err(|fault| Failure(format!("error: {}: {}", args.task.display(), fault.words(&assignment.task))))?;
    let profile = profile(&study, &args.task, machine)?;
    if let Some(scene) = &assignment.scene {
        let folder = scene.parent().unwrap_or(Path::new(""));
        scene::resolve(&target.display().to_string(), &profile, folder)
            .map_err(|faults| Failure(faults.to_string()))?;
    }
    write(&target, &profile)?;
    let mut lines = format!("\n{}\n", target.display());
    if let Some(folder) = &args.report {
        lines += &report(folder, &assignment, &study)?;
    }
    print(&(study.text() + &lines))
}

/// Whether both paths name one existing file.
fn same_file(a: &Path, b: &Path) -> bool {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    real(a).is_some_and(|a| Some(a) == real(b))
}

/// A progress bar on the standard error, hidden where that is no terminal.
fn bar(name: &str) -> ProgressBar {
    let target =
        if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let style = ProgressStyle::with_template("{prefix} {msg:>10} {wide_bar} {pos}/{len} {elapsed}");
    ProgressBar::with_draw_target(None, target)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_prefix(name.to_owned())
}

/// The scene that the task names, without its cam.
fn machine(path: &Path) -> Result<toml::Table, Failure> {
    scene::read(path).map_err(|faults| Failure(faults.to_string()))?;
    let failure = |e: &dyn std::fmt::Display| Failure(format!("error: {}: {e}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| failure(&e))?;
    let mut table: toml::Table = text.trim_start_matches('\u{feff}').parse().map_err(|e| failure(&e))?;
    if table.remove("cam").is_none() {
        return Err(failure(&"this scene has no [cam] that a profile could replace"));
    }
    Ok(table)
}

/// The profile as a scene, or as the part [cam] of one.
fn profile(study: &Study, task: &Path, machine: Option<toml::Table>) -> Result<String, Failure> {
    let file = task.file_name().unwrap_or_default().to_string_lossy();
    let mut text = format!("# HS profile of {file} by camdrive synthesize.\n");
    if let Some(mut machine) = machine {
        machine.insert("name".to_owned(), toml::Value::String(study.assignment.name.clone()));
        let rest = toml::to_string(&machine).map_err(|e| Failure(format!("error: {}: {e}", task.display())))?;
        let _ = writeln!(text, "{rest}");
    }
    let unit = study.assignment.unit;
    let list = |values: &[f64]| values.iter().map(|v| format!("{:?}", v / unit + 0.0)).collect::<Vec<_>>().join(", ");
    let _ = writeln!(text, "[cam]\nlaw = \"fourier\"");
    if unit != 1.0 {
        let _ = writeln!(text, "scale = {unit:?} # m");
    }
    let _ = writeln!(text, "a = [{}]", list(&study.cam.a));
    let _ = writeln!(text, "b = [{}]", list(&study.cam.b[1..]));
    Ok(text)
}

fn write(path: &Path, content: &str) -> Result<(), Failure> {
    let failure = |e: std::io::Error| Failure(format!("error: {} cannot be written: {e}", path.display()));
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(failure)?;
    }
    std::fs::write(path, content).map_err(failure)
}

/// Writes tables and diagrams; the lines that say so.
fn report(folder: &Path, assignment: &Assignment, study: &Study) -> Result<String, Failure> {
    let fault = |fault: crate::drives::Fault| Failure(format!("error: {fault}"));
    let mut files = study.csv().map_err(fault)?;
    files.push(("json".to_owned(), study.json().map_err(fault)?));
    for (name, diagram) in study.figures() {
        files.push((format!("{name}.svg"), diagram.svg().map_err(fault)?));
    }
    let mut lines = String::new();
    for (ending, content) in files {
        let path = folder.join(format!("{}.{ending}", assignment.name));
        write(&path, &content)?;
        let _ = writeln!(lines, "{}", path.display());
    }
    Ok(lines)
}
