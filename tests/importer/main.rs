//! `importer CAMDRIVE FMU…`: drives FMUs by fmi-rs. The model description of each has to be valid, and the outputs over its default
//! experiment have to be those of `CAMDRIVE run`, to the bit.

use fmi_rs::fmi2::builder::FMU2Builder;
use fmi_rs::model_description::fmi2::Causality;
use fmi_rs::sim::fmi2::recorder::Recorder;
use fmi_rs::sim::fmi2::{SimulationSettings, Trajectories, cs};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::Arc;

/// A table: names, and rows of values.
type Table = (Vec<String>, Vec<Vec<f64>>);

/// The run of fmi-rs over the default experiment.
fn imported(fmu: &Path) -> Result<Table, String> {
    let FMU2Builder { unzipdir, model_description, .. } = FMU2Builder::new(&fmu).map_err(|e| e.to_string())?;
    let problems: Vec<String> = model_description.validate().into_iter().map(|problem| problem.message).collect();
    if !problems.is_empty() {
        return Err(problems.join("; "));
    }
    let about = Arc::new(model_description);
    let number = |name: &str, value: &Option<String>| {
        let number = value.as_ref().and_then(|text| text.parse::<f64>().ok());
        number.ok_or_else(|| format!("the default experiment has no {name}"))
    };
    let experiment = about.defaultExperiment.as_ref().ok_or("there is no default experiment")?;
    let is_output = |i: &usize| about.modelVariables[*i].causality == Causality::Output;
    let outputs: Vec<usize> = (0..about.modelVariables.len()).filter(is_output).collect();
    let settings = SimulationSettings {
        unzipdir: unzipdir.path().to_owned(),
        model_description: Arc::clone(&about),
        start_time: number("startTime", &experiment.startTime)?,
        stop_time: number("stopTime", &experiment.stopTime)?,
        logging_on: true,
        set_stop_time: true,
        output_interval: number("stepSize", &experiment.stepSize)?,
        log_time_scale: false,
        tolerance: number("tolerance", &experiment.tolerance)?,
        set_tolerance: true,
        start_values: Vec::new(),
        log_fmi_calls: false,
        input_file: None,
        early_return_allowed: false,
        event_mode_used: false,
        log_file: Some(unzipdir.path().join("log.txt")),
        initial_fmu_state_file: None,
        final_fmu_state_file: None,
    };
    let recorder = Arc::new(Recorder::new(Trajectories::new(Arc::clone(&about), outputs.clone())));
    cs::simulate(&settings, None, Arc::clone(&recorder)).map_err(|e| {
        let log = std::fs::read_to_string(unzipdir.path().join("log.txt")).unwrap_or_default();
        format!("{e} {log}")
    })?;
    let name = |i: &usize| about.modelVariables[*i].name.clone();
    let names = std::iter::once("time".to_owned()).chain(outputs.iter().map(name)).collect();
    let found = recorder.trajectories.borrow();
    let rows = found.time.iter().zip(&found.rows).map(|(time, row)| {
        std::iter::once(*time).chain(row.iter().map(|value| value.to_f64().unwrap_or(f64::NAN))).collect()
    });
    Ok((names, rows.collect()))
}

/// The run of the tool.
fn own(camdrive: &Path, fmu: &Path) -> Result<Table, String> {
    let run = Command::new(camdrive).arg("run").arg(fmu).output().map_err(|e| e.to_string())?;
    let text = String::from_utf8_lossy(&run.stdout);
    if !run.status.success() {
        return Err(format!("camdrive run: {}", String::from_utf8_lossy(&run.stderr)));
    }
    let mut lines = text.lines();
    // A name with a comma is in quotes.
    let mut is_quoted = false;
    let ends = |letter: char| {
        is_quoted ^= letter == '"';
        letter == ',' && !is_quoted
    };
    let names = lines.next().unwrap_or_default().split(ends).map(|name| name.trim_matches('"').to_owned()).collect();
    let row = |line: &str| line.split(',').map(|cell| cell.parse().map_err(|_| format!("no number: {cell}"))).collect();
    Ok((names, lines.map(row).collect::<Result<_, String>>()?))
}

fn compare(camdrive: &Path, fmu: &Path) -> Result<usize, String> {
    let ((names, found), (expected, right)) = (imported(fmu)?, own(camdrive, fmu)?);
    if names != expected || found.len() != right.len() {
        return Err(format!("{names:?} in {} rows, not {expected:?} in {}", found.len(), right.len()));
    }
    for (row, other) in found.iter().zip(&right) {
        // The clock of fmi-rs may stop within the tolerance of the end.
        if let Some(i) = (1..row.len()).find(|i| row[*i] != other[*i]) {
            return Err(format!("`{}` at {} s is {}, not {}", names[i], row[0], row[i], other[i]));
        }
    }
    Ok(found.len())
}

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let camdrive = arguments.next().unwrap_or_default();
    let fmus: Vec<PathBuf> = arguments.collect();
    let compared = fmus.iter().map(|fmu| (fmu, compare(&camdrive, fmu)));
    let failed = compared.filter_map(|(fmu, result)| Some((fmu, result.err()?)));
    let failed: Vec<String> = failed.map(|(fmu, why)| format!("{}: {why}", fmu.display())).collect();
    println!("fmi-rs: {} of {} FMUs as the tool", fmus.len() - failed.len(), fmus.len());
    failed.iter().for_each(|why| eprintln!("{why}"));
    if failed.is_empty() && !fmus.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
