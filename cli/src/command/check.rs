//! `camdrive check SCENE…`

use super::deliver::ReportFormat;
use super::output::Bar;
use super::{Failure, failure, open, print, print_notes, read_all, show, system, width};
use crate::document::{Diagnostic, Diagnostics, Document, Value as Scalar, input::is_system, units, values};
use crate::scene::Resolved;
use crate::system::System;
use camdrive::drives::shaft::train::MOST_FOLLOWERS;
use camdrive::drives::unit;
use camdrive_design::overview::{self, Overview};
use camdrive_design::report::Unit;
use camdrive_design::text;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Check scenes: every error with its line, key figures, warnings.
///
/// Checks every value, builds the drive and starts it. Reports all errors of all scenes. For a valid scene it prints speeds,
/// natural frequencies, largest velocity, acceleration and force, and the nearest resonances, and warns about implausible values,
/// such as a forgotten unit, and about rough tables. For a system it prints algebraic loops and the largest stable communication
/// step.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  camdrive check examples/*/scene.toml\n  camdrive check examples/two_cams/system.toml"
)]
pub struct Args {
    /// Scene and system files (TOML), FMUs with their scenes inside, or systems as SSP 1.0
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    #[command(flatten)]
    format: ReportFormat,
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    if args.format.json {
        return as_data(&args.scenes);
    }
    let (systems, paths): (Vec<PathBuf>, Vec<PathBuf>) = args.scenes.iter().cloned().partition(|path| is_system(path));
    let scenes = read_all(&paths)?;
    print_notes(&paths, &scenes);
    let mut out = String::new();
    for path in &systems {
        let system = system::read(path)?;
        system.try_out().map_err(|fault| Diagnostics::of_file(path, fault))?;
        out += if out.is_empty() { "" } else { "\n" };
        let mut report = system::glance(text::in_one_line(path.display()), &system);
        report.study += " ok";
        out += &report.text(width(), args.format.explain);
    }
    for (path, scene) in paths.iter().zip(&scenes) {
        let found = overview_of(scene);
        let report = found.report(text::in_one_line(path.display()), format!("{} ok", scene.scene.model_name()));
        out += if out.is_empty() { "" } else { "\n" };
        out += &report.text(width(), args.format.explain);
    }
    show(&out).map(|()| ExitCode::SUCCESS)
}

/// Keys whose unit, forgotten, makes figures implausible.
const DIMENSIONED: [&str; 12] =
    ["speed", "w_s", "scale", "stroke", "natural_frequency", "m", "c", "c_T1", "c_T2", "c_AB", "s", "R"];

/// The overview of a scene with the warnings of its tables, frequencies in the unit of the scene.
pub fn overview_of(scene: &Resolved) -> Overview {
    let mut overview = Bar::during(&scene.name, |_| overview::of(&scene.resource()));
    if let Some(unit) = unit_of_frequencies(&scene.document) {
        overview.show_frequencies(&unit);
    }
    let is_plain = |path: &str, value: &Scalar| {
        DIMENSIONED.contains(&path.rsplit('.').next().unwrap_or_default()) && !matches!(value, Scalar::Text(_))
    };
    if !values(&scene.document.table).iter().any(|(path, value)| is_plain(path, value.get_ref())) {
        overview.with_units();
    }
    overview.warnings.extend(scene.smoothed.iter().filter_map(|table| table.warning.clone()));
    overview
}

/// The unit of the first natural frequency in the scene.
fn unit_of_frequencies(document: &Document) -> Option<Unit> {
    let parts = std::iter::once(String::new()).chain((1..=MOST_FOLLOWERS).map(|j| format!("follower[{j}].")));
    let keys = parts.flat_map(|part| ["elasticity", "backlash"].map(|of| format!("{part}{of}.natural_frequency")));
    keys.into_iter().find_map(|key| match document.place(&key)??.get_ref() {
        Scalar::Text(text) => {
            let (name, factor) = units::written(text, &unit::ANGULAR_VELOCITY)?;
            Some(Unit { name: name.to_owned().into(), factor: 1.0 / factor })
        }
        _ => None,
    })
}

/// The result as a list with an entry for each scene, including faults.
fn as_data(paths: &[PathBuf]) -> Result<ExitCode, Failure> {
    let (mut entries, mut ending) = (Vec::new(), ExitCode::SUCCESS);
    for path in paths {
        let found = if is_system(path) {
            let tried = |system: System| system.try_out().map(|()| system::data(path, &system));
            crate::system::read(path)
                .and_then(|system| tried(system).map_err(|fault| Diagnostics::of_file(path, fault)))
        } else {
            open(path).map(|scene| data(path, &scene))
        };
        entries.push(found.unwrap_or_else(|Diagnostics(faults)| {
            ending = ExitCode::FAILURE;
            let faults: Vec<Value> = faults.iter().map(fault).collect();
            json!({ "file": path.display().to_string(), "ok": false, "faults": faults })
        }));
    }
    print(&text::json(&entries).map_err(failure)?).map(|()| ending)
}

/// The entry of a scene.
fn data(path: &Path, scene: &Resolved) -> Value {
    let found = overview_of(scene);
    let mut entry = json!(found);
    let own = json!({
        "file": path.display().to_string(), "ok": true, "name": scene.name, "model": scene.scene.model_name(),
        "notes": scene.notes, "verdict": found.verdict()
    });
    if let (Some(entry), Value::Object(own)) = (entry.as_object_mut(), own) {
        entry.extend(own);
    }
    entry
}

fn fault(fault: &Diagnostic) -> Value {
    let Diagnostic { key, message, admissible, hint, file, position } = fault;
    let (line, column) = position.as_ref().map(|at| (at.line, at.column)).unzip();
    json!({ "file": file, "line": line, "column": column, "key": key, "message": message, "admissible": admissible, "hint": hint })
}
