//! `camdrive verify FMU…`

use super::{Failure, Format, failure, tell};
use crate::export::{references, results};
use camdrive::drives::Fault;
use camdrive::drives::variable::Causality;
use camdrive_design::host::{self, Fmu};
use camdrive_design::text::{self, Page, Table, number};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Runs the default experiment of FMUs again and compares the outputs with the results inside.
///
/// The FMU's own library computes them on this machine. An output agrees where it differs nowhere by more than the relative
/// tolerance of the experiment, of its largest value, and the last digit of the results. Exit code 1 where one does not. A chaotic
/// motion agrees on machines of one kind only. A note tells where the results end early, and where no output changes.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  camdrive verify guide_bar.fmu")]
pub struct Args {
    /// FMUs that camdrive exported
    #[arg(required = true, value_name = "FMU")]
    fmus: Vec<PathBuf>,
    #[command(flatten)]
    format: Format,
}

/// How an FMU compares.
#[derive(Serialize)]
struct Comparison {
    file: String,
    agrees: bool,
    /// The last time of the results (s).
    end: f64,
    outputs: Vec<Output>,
}

/// How an output compares.
#[derive(Serialize)]
struct Output {
    name: String,
    unit: String,
    /// The largest magnitude in the results.
    largest: f64,
    /// The largest difference, and when it occurs (s).
    difference: f64,
    time: f64,
    /// What it may be.
    admissible: f64,
    agrees: bool,
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut all = Vec::new();
    for path in &args.fmus {
        let place = text::in_one_line(path.display());
        all.push(compare(path, &place).map_err(|fault| failure(format!("{place}: {fault}")))?);
    }
    let ending = if all.iter().all(|of| of.agrees) { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    args.format.print(|width| all.iter().map(|of| of.text(width)).collect(), || text::json(&all))?;
    Ok(ending)
}

fn compare(path: &Path, place: &str) -> Result<Comparison, Fault> {
    let (names, rows) = results_of(path)?;
    let fmu = Fmu::open(path)?;
    let description = fmu.description();
    let find =
        |name: &String| description.find(name).ok_or_else(|| wrong(&format!("the FMU has no variable `{name}`")));
    let mut outputs =
        description.variables.iter().map(|v| &v.about).filter(|about| about.causality == Causality::Output);
    if let Some(output) = outputs.find(|output| !names.contains(&output.name)) {
        return Err(wrong(&format!("the output `{}` has no column", output.name)));
    }
    let columns = names.iter().map(find).collect::<Result<Vec<usize>, Fault>>()?;
    let (tolerance, end) = (description.experiment.tolerance, rows[rows.len() - 1][0]);
    let note = |text: String| tell(&format!("note: {place}: {text}\n"));
    if let Some(stop) = description.experiment.stop.filter(|stop| end < *stop) {
        note(format!("the results end at t = {} s, the experiment at {} s", number(end), number(stop)));
    }
    if rows.iter().all(|row| row[1..] == rows[0][1..]) {
        note("no output changes in the experiment, whose inputs rest: that they agree proves little".to_owned());
    }
    let mut host = fmu.instantiate(&description.name)?;
    host.set_up(rows[0][0], None, tolerance)?;
    host.enter_initialization()?;
    host.exit_initialization()?;
    // Largest magnitude; largest difference and its time.
    let mut found = vec![(0.0f64, 0.0f64, rows[0][0]); columns.len()];
    for (i, row) in rows.iter().enumerate() {
        for ((column, told), (largest, difference, time)) in columns.iter().zip(&row[1..]).zip(&mut found) {
            let off = (host.get(*column)? - told).abs();
            *largest = largest.max(told.abs());
            // What is no number is off for good.
            if !(off <= *difference) && !difference.is_nan() {
                (*difference, *time) = (off, row[0]);
            }
        }
        if let Some(next) = rows.get(i + 1) {
            host.do_step(row[0], next[0] - row[0])?;
        }
    }
    let relative = tolerance.unwrap_or(0.0);
    let output = |((name, column), (largest, difference, time)): ((String, usize), (f64, f64, f64))| {
        let admissible = relative * largest + results::last_digit(largest);
        let unit = description.variables[column].unit.name.clone();
        Output { name, unit, largest, difference, time, admissible, agrees: difference <= admissible }
    };
    let outputs: Vec<Output> = names.into_iter().zip(columns).zip(found).map(output).collect();
    let agrees = outputs.iter().all(|output| output.agrees);
    Ok(Comparison { file: place.to_owned(), agrees, end, outputs })
}

/// The outputs of the results in an FMU, and their rows: first the time (s).
fn results_of(path: &Path) -> Result<(Vec<String>, Vec<Vec<f64>>), Fault> {
    let folder = host::unpacked(path, &[&format!("{}/", references::FOLDER)])?;
    let place = folder.path().join(references::FOLDER).join(references::RESULT);
    if !place.is_file() {
        let hint = "older FMUs, and those of other tools, have none inside; `camdrive export` makes one with them";
        return Err(Fault::new(format!("the FMU holds no results\n  = hint: {hint}")));
    }
    let mut table = csv::Reader::from_path(place).map_err(|e| wrong(&e.to_string()))?;
    let names = table.headers().map_err(|e| wrong(&e.to_string()))?.iter().skip(1).map(str::to_owned).collect();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for (i, record) in table.records().enumerate() {
        let record = record.map_err(|e| wrong(&e.to_string()))?;
        let value = |text: &str| text.parse().map_err(|_| wrong(&format!("line {}: `{text}` is no number", i + 2)));
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
    fn text(&self, width: usize) -> String {
        let (count, wrong) = (self.outputs.len(), self.outputs.iter().filter(|output| !output.agrees).count());
        let verdict = match wrong {
            0 => format!("all {count} outputs agree"),
            1 => format!("1 of {count} outputs does not agree"),
            _ => format!("{wrong} of {count} outputs do not agree"),
        };
        let row = |output: &Output| {
            let [largest, difference, admissible, time] =
                [output.largest, output.difference, output.admissible, output.time].map(number);
            let agrees = if output.agrees { "yes" } else { "no" }.to_owned();
            vec![output.name.clone(), output.unit.clone(), largest, difference, admissible, time, agrees]
        };
        let head = "output  unit  largest value  difference  admissible  at t [s]  agrees";
        let table = Table::new(head, self.outputs.iter().map(row));
        Page::new(format!("{}: {verdict} up to t = {} s", self.file, number(self.end)), width)
            .table("Outputs", &table)
            .text()
    }
}
