//! `camdrive verify FMU…`

use super::run::signals;
use super::{Failure, Foreign, Format, open, print_message};
use crate::document::{Diagnostics, input::NAMED, source::is_fmu};
use crate::export::results::{self, Results};
use crate::export::{self, references, sbom};
use camdrive::drives::resource::{BUILD, Content, FILE_NAME};
use camdrive::drives::variable::Causality;
use camdrive::drives::{Description, Fault};
use camdrive_design::coupling::exchange::Coupling;
use camdrive_design::host::{self, Fmu, ModelDescription};
use camdrive_design::recording::{Recording, Signals};
use camdrive_design::report::unit::{ONE, Unit};
use camdrive_design::report::{Level, Report, Table, Verdict};
use camdrive_design::resource::Scene;
use camdrive_design::text::{self, number};
use camdrive_design::xml::Element;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Rerun the default experiment of FMUs and compare with the results inside.
///
/// The FMU's own library computes the results on this computer. An output agrees if it differs nowhere by more than the relative
/// tolerance of the experiment, times its largest value, plus the last digit of the results. The exit code is 1 if an output does
/// not agree, if rows of the results are missing, or if the scene inside no longer matches the drive or modelDescription.xml.
/// Inputs move as in the table inside: phi, w, a turn the shaft twice in a smooth run-up. The other inputs rise smoothly: the last
/// one by 1 in its unit (by 0.1, 0.01 … if 1 moves a free shaft too far from its speed), each earlier one by half of the next.
/// Chaotic motions are reproducible only on the same kind of machine.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  camdrive verify guide_bar.fmu")]
pub struct Args {
    /// FMUs that camdrive exported
    #[arg(required = true, value_name = "FMU")]
    fmus: Vec<PathBuf>,
    #[command(flatten)]
    foreign: Foreign,
    #[command(flatten)]
    format: Format,
}

/// The comparison of an FMU with its results.
#[derive(Serialize)]
struct Comparison {
    file: String,
    agrees: bool,
    /// Differences from what the export wrote.
    changes: Vec<String>,
    /// The last time of the results (s).
    end: f64,
    outputs: Vec<Output>,
}

/// The result for an FMU.
#[derive(Serialize)]
#[serde(untagged)]
enum Answer {
    Compared {
        verdict: Verdict,
        #[serde(flatten)]
        comparison: Comparison,
    },
    /// An FMU that cannot be compared.
    Broken { file: String, agrees: bool, error: String },
}

/// The comparison of an output.
#[derive(Serialize)]
struct Output {
    name: String,
    unit: String,
    /// The largest magnitude in the results.
    largest: f64,
    /// The largest difference, and its time (s).
    difference: f64,
    time: f64,
    /// The admissible difference.
    admissible: f64,
    agrees: bool,
}

/// Relative difference of numbers that differ only in their last digits.
const NEAR: f64 = 1e-9;

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    args.foreign.limit()?;
    let answer = |path: &PathBuf| {
        let file = text::in_one_line(path.display());
        let fault = match compare(path, &file) {
            Ok(comparison) => return Answer::Compared { verdict: comparison.verdict(), comparison },
            Err(fault) => fault.to_string(),
        };
        let error = if fault.starts_with(&file) { fault } else { format!("{file}: {fault}") };
        print_message(&format!("error: {error}\n"));
        Answer::Broken { file, agrees: false, error }
    };
    let all: Vec<Answer> = args.fmus.iter().map(answer).collect();
    let compared = || {
        all.iter().filter_map(|of| if let Answer::Compared { comparison, .. } = of { Some(comparison) } else { None })
    };
    let agree = compared().filter(|of| of.agrees).count();
    args.format.print(|width| compared().map(|of| of.report().text(width, false)).collect(), || text::json(&all))?;
    Ok(if agree == all.len() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The fault of a file of another kind, with the command for it.
fn other(path: &Path) -> Option<Fault> {
    if is_fmu(path) {
        return None;
    }
    let (what, hint) = match open(path) {
        Ok(_) => ("this is a scene".to_owned(), format!("`camdrive export {}` makes an FMU of it", path.display())),
        Err(Diagnostics(faults)) => {
            let fault = faults.into_iter().find(|fault| fault.message.ends_with(", not a scene"))?;
            if fault.hint.as_deref() == Some(NAMED) {
                return Some(Fault::new("it cannot be read").hint(NAMED)).filter(|_| !path.is_file());
            }
            (fault.message.trim_end_matches(", not a scene").to_owned(), fault.hint?)
        }
    };
    Some(Fault::new(format!("{what}, not an FMU")).hint(hint))
}

fn compare(path: &Path, place: &str) -> Result<Comparison, Fault> {
    let fmu = Fmu::open(path).map_err(|fault| other(path).unwrap_or(fault))?;
    let parts = [&*format!("{}/", references::FOLDER), "resources/", sbom::PATH, host::DESCRIPTION];
    let folder = host::unpacked(path, &parts)?;
    let (names, rows) = results_of(folder.path())?;
    let description = fmu.description();
    let is_output = |about: &Description| about.causality == Causality::Output;
    let mut outputs = description.variables.iter().map(|v| &v.about).filter(|about| is_output(about));
    if let Some(output) = outputs.find(|output| !names.contains(&output.name)) {
        return Err(wrong(&format!("the output `{}` has no column", output.name)));
    }
    let mut columns = Vec::new();
    for name in &names {
        let column = description.find(name).filter(|column| is_output(&description.variables[*column].about));
        let column = column.ok_or_else(|| wrong(&format!("the FMU has no output `{name}`")))?;
        if columns.contains(&column) {
            return Err(wrong(&format!("`{name}` has two columns")));
        }
        columns.push(column);
    }
    let (tolerance, end) = (description.experiment.tolerance, rows[rows.len() - 1][0]);
    let mut changes = changes(path, folder.path(), description, &rows)?;
    if rows.iter().all(|row| row[1..] == rows[0][1..]) {
        print_message(&format!("note: {place}: no output changes in the experiment, so the agreement proves little\n"));
    }
    let (signals, missing) = inputs(folder.path(), description)?;
    changes.extend(missing);
    let mut coupling = Coupling::alone("", fmu.instantiate(&description.name)?)?;
    coupling.begin(rows[0][0], None)?;
    let mut recording = Recording::start(&mut coupling, &signals, &columns, rows[0][0])?;
    // Largest magnitude; largest difference and its time.
    let mut found = vec![(0.0f64, 0.0f64, rows[0][0]); columns.len()];
    let mut values = Vec::new();
    for row in &rows {
        recording.at(row[0], &mut values)?;
        for ((value, told), (largest, difference, time)) in values[1..].iter().zip(&row[1..]).zip(&mut found) {
            let off = (value - told).abs();
            *largest = largest.max(told.abs());
            // A value that is not a number stays the worst.
            if !(off <= *difference) && !difference.is_nan() {
                (*difference, *time) = (off, row[0]);
            }
        }
    }
    // An error after the results does not change them.
    coupling.end()?;
    let relative = tolerance.unwrap_or(0.0);
    let output = |((name, column), (largest, difference, time)): ((String, usize), (f64, f64, f64))| {
        let admissible = relative * largest + results::last_digit(largest);
        let unit = description.variables[column].unit.name.clone();
        Output { name, unit, largest, difference, time, admissible, agrees: difference <= admissible }
    };
    let outputs: Vec<Output> = names.into_iter().zip(columns).zip(found).map(output).collect();
    let agrees = changes.is_empty() && outputs.iter().all(|output| output.agrees);
    Ok(Comparison { file: place.to_owned(), agrees, changes, end, outputs })
}

/// The inputs of the experiment, and the reason if some are missing.
fn inputs(folder: &Path, about: &ModelDescription) -> Result<(Signals, Option<String>), Fault> {
    let table = folder.join(references::FOLDER).join(references::INPUT);
    let all: Vec<Description> = about.variables.iter().map(|variable| variable.about.clone()).collect();
    if !table.is_file() {
        let has_inputs = all.iter().any(|about| about.causality == Causality::Input);
        let missing = format!("{} is missing: the inputs keep their start values", references::INPUT);
        return Ok((Signals::default(), has_inputs.then_some(missing)));
    }
    let signals = signals::read(&table, &all, |_| None).map_err(|Failure { fault, .. }| {
        let message = fault.message.replace(&table.display().to_string(), references::INPUT);
        fault.with_message(message)
    })?;
    Ok((signals, None))
}

/// Differences from the exported content: the scene inside against the drive's scene, and the rows of the results.
fn changes(path: &Path, folder: &Path, about: &ModelDescription, rows: &[Vec<f64>]) -> Result<Vec<String>, Fault> {
    let mut changes = Vec::new();
    let (end, step) = (rows[rows.len() - 1][0], about.experiment.step.unwrap_or(f64::INFINITY));
    let points = (end / step).round() as usize + 1;
    if rows.len() != points {
        changes.push(format!(
            "{} has {} rows up to t = {} s, not {points}",
            references::RESULT,
            rows.len(),
            number(end)
        ));
    }
    let scene = match open(path) {
        Ok(scene) => scene,
        Err(faults) => {
            return Ok([changes, vec![format!("the scene inside is not the drive's: {faults}")]].concat());
        }
    };
    let resource = scene.resource();
    let read = |name: &str| std::fs::read(folder.join(name)).map_err(|e| Fault::new(format!("{name}: {e}")));
    // Other sources may encode the same scene differently.
    if String::from_utf8_lossy(&read(sbom::PATH)?).contains(BUILD) {
        let bytes = read(&format!("resources/{FILE_NAME}"))?;
        let Content { model, scene: encoded, .. } = Content::from_bytes(&bytes)?;
        if about.name != resource.name
            || !are_near(&format!("{:?}", Scene::decoded(model, encoded)?), &format!("{:?}", resource.scene))
        {
            changes.push(format!("the scene inside is not the drive's, resources/{FILE_NAME}"));
        } else {
            let wanted = Element::read(&export::describe(&resource, &scene.description)?)?;
            let found = Element::read(&String::from_utf8_lossy(&read(host::DESCRIPTION)?))?;
            changes.extend(difference(&found, &wanted).map(|what| format!("{}: {what}", host::DESCRIPTION)));
        }
    } else {
        print_message(&format!(
            "note: {}: another version of camdrive wrote it; its scene is not compared with the drive\n",
            path.display()
        ));
    }
    // An experiment that failed at the export ends early rightly.
    let is_early = about.experiment.stop.is_some_and(|stop| end < stop);
    if is_early && end < Results::of(&mut *resource.build()?)?.end() {
        changes.push(format!("{} ends too early, at t = {} s", references::RESULT, number(end)));
    }
    Ok(changes)
}

/// Attributes of the root that do not follow from the scene.
const OF_THE_EXPORT: [&str; 2] = ["guid", "generationDateAndTime"];

/// The first difference of an element from the wanted one, apart from the last digits of numbers.
fn difference(found: &Element, wanted: &Element) -> Option<String> {
    let name = found.get("name").map_or(String::new(), |name| format!(" name=\"{name}\""));
    let here = format!("<{}{name}>", found.name);
    let own = |element: &Element| -> BTreeMap<String, String> {
        element.attributes.iter().filter(|(key, _)| !OF_THE_EXPORT.contains(&key.as_str())).cloned().collect()
    };
    let (mut rest, wants) = (own(found), own(wanted));
    for (key, value) in wants {
        let is = rest.remove(&key);
        if !is.as_ref().is_some_and(|is| are_near(is, &value)) {
            let is = is.map_or("is missing".to_owned(), |is| format!("is \"{is}\""));
            return Some(format!("{here}: {key} {is}, the scene gives \"{value}\""));
        }
    }
    if let Some(key) = rest.keys().next() {
        return Some(format!("{here}: the scene gives no {key}"));
    }
    if found.children.len() != wanted.children.len() {
        let [is, gives] = [found, wanted].map(|element| element.children.len());
        return Some(format!("{here} has {is} elements, the scene gives {gives}"));
    }
    let named = |(found, wanted): (&Element, &Element)| match found.name == wanted.name {
        true => difference(found, wanted),
        false => Some(format!("{here} has <{}>, the scene gives <{}>", found.name, wanted.name)),
    };
    found.children.iter().zip(&wanted.children).find_map(named)
}

/// True if two texts differ at most in the last digits of numbers; sin and cos of another machine may cause that.
fn are_near(one: &str, other: &str) -> bool {
    let [one, other] = [one, other].map(|text| text.split([' ', ',', '(', ')', '[', ']']).collect::<Vec<&str>>());
    let number = |text: &str| text.parse::<f64>().unwrap_or(f64::NAN);
    let near = |a: f64, b: f64| (a - b).abs() <= NEAR * a.abs();
    one.len() == other.len() && one.iter().zip(other).all(|(a, b)| *a == b || near(number(a), number(b)))
}

/// The outputs of the results in an unpacked FMU, and their rows, with the time first (s).
fn results_of(folder: &Path) -> Result<(Vec<String>, Vec<Vec<f64>>), Fault> {
    let place = folder.join(references::FOLDER).join(references::RESULT);
    if !place.is_file() {
        let hint = "older FMUs and FMUs of other tools have no results; `camdrive export` writes FMUs with results";
        return Err(Fault::new("the FMU holds no results").hint(hint));
    }
    let mut table = csv::Reader::from_path(place).map_err(|e| wrong(&e.to_string()))?;
    let names = table.headers().map_err(|e| wrong(&e.to_string()))?.iter().skip(1).map(str::to_owned).collect();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for (i, record) in table.records().enumerate() {
        let record = record.map_err(|e| wrong(&e.to_string()))?;
        let value = |text: &str| {
            let number = text.parse().ok().filter(|number: &f64| number.is_finite());
            number.ok_or_else(|| wrong(&format!("line {}: `{text}` is no number", i + 2)))
        };
        let row = record.iter().map(value).collect::<Result<Vec<f64>, Fault>>()?;
        if rows.last().is_some_and(|last| !(last[0] < row[0])) {
            return Err(wrong(&format!("line {}: the time {} s does not grow", i + 2, row[0])));
        }
        rows.push(row);
    }
    if rows.is_empty() { Err(wrong("it has no rows")) } else { Ok((names, rows)) }
}

fn wrong(message: &str) -> Fault {
    Fault::new(format!("{}: {message}", references::RESULT))
}

impl Comparison {
    /// The verdict on the FMU: whether it reproduces its results.
    fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        let (end, count) = (number(self.end), self.outputs.len());
        match self.outputs.iter().filter(|output| !output.agrees).count() {
            0 => verdict.result(Level::Good, format!("All {count} outputs agree up to t = {end} s.")),
            1 => verdict.result(Level::Bad, format!("1 of {count} outputs does not agree up to t = {end} s.")),
            wrong => verdict.result(Level::Bad, format!("{wrong} of {count} outputs do not agree up to t = {end} s.")),
        };
        for change in &self.changes {
            verdict.result(Level::Bad, format!("changed: {change}"));
        }
        verdict
    }

    fn report(&self) -> Report {
        let mut report = Report::new(&self.file, "results inside");
        report.verdict = self.verdict();
        let in_unit = |output: &Output, value: f64| value * Unit::of(&output.unit).factor;
        let outputs = Table::of("Outputs", &self.outputs)
            .column("output", "output", ONE, |output| &output.name)
            .column("unit", "unit", ONE, |output| Unit::of(&output.unit).name.into_owned())
            .column("largest", "largest value", ONE, |output| in_unit(output, output.largest))
            .column("difference", "difference", ONE, |output| in_unit(output, output.difference))
            .column("admissible", "admissible", ONE, |output| in_unit(output, output.admissible))
            .column("time", "at t [s]", ONE, |output| output.time)
            .column("agrees", "agrees", ONE, |output| output.agrees);
        report.table(outputs);
        report
    }
}
