//! `camdrive run SCENE`, `camdrive run FMU` and `camdrive run SYSTEM`

mod driven;
mod fmu;
mod native;
pub(super) mod signals;

use super::output::{counter, print, print_message};
use super::{Failure, Foreign, Format, failure, files, optional, system, wrong_argument};
use crate::document::{input::is_system, source::is_fmu};
use crate::export::picture;
use crate::export::results::{self, Course};
use camdrive::drives::{Experiment, Number, unit};
use camdrive_design::recording::{Recording, Signals};
use camdrive_design::text;
use driven::Subject;
use indicatif::ProgressDrawTarget;
use serde::Serialize;
use std::fmt::Write as _;
use std::io::{IsTerminal as _, Write as _};
use std::path::PathBuf;

/// Simulate a scene, an FMU or a system; results as CSV or JSON.
///
/// A scene runs in this tool, with the same drive as in its FMU. An FMU, also one from another tool, runs with its own library.
/// Prints one line per communication point, including the start; the last step is shorter if the step does not divide the time.
/// Inputs keep their start values, or follow the table of --input. The parts of a system exchange values as its file says; at the
/// end a note compares the work on both sides of each shaft.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive run guide_bar.toml -o result.csv
  camdrive run guide_bar.toml --stop 0.5 --step \"1 ms\" --output y,q
  camdrive run guide_bar.toml --start \"drive.w=2000 rpm\" \\
      --start start.mode=steady_state
  camdrive run run_up.toml --input speed.csv --json
  camdrive run guide_bar.fmu --start \"drive.w=2000 rpm\" -o result.csv
  camdrive run two_cams/system.toml --step \"0.5 ms\" --output machine.w,pusher.q

The table of --input has the headings time and names of inputs, with units if they are not SI: \
\"time [ms],w [rpm]\". Inputs are linear between its rows and held outside them; steps end at its \
times, too. Only the highest derivative of phi, w, a in the table is linear; the others are \
integrated from it.
Discrete inputs of an FMU are held from row to row.
The results of an FMU have its own units. If these are not SI, headings name them, and numbers in \
--start and --input need a unit.")]
pub struct Args {
    /// The scene or the system (TOML), an FMU 2.0 for Co-Simulation (.fmu), or a system of FMUs as SSP 1.0 (.ssp)
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Stop time in s, or with a unit [default: from the default experiment]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    stop: Option<String>,
    /// Communication step in s, or with a unit [default: from the default experiment, or a thousandth of the time]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    step: Option<String>,
    /// Variables to write, separated by commas outside of parentheses and brackets [default: all outputs]
    #[arg(long, value_name = "NAMES")]
    output: Option<String>,
    /// Start value of a parameter or an input: a number in SI, a value with a unit, true, false or an item of an
    /// enumeration; repeatable
    #[arg(long, value_name = "NAME=VALUE", allow_hyphen_values = true)]
    start: Vec<String>,
    /// Table of the inputs over time
    #[arg(long, value_name = "FILE.csv")]
    input: Option<PathBuf>,
    /// File to write [default: the standard output]
    #[arg(short = 'o', long = "file", value_name = "FILE")]
    result: Option<PathBuf>,
    /// Draw the columns over the time: at most six, only columns that change
    #[arg(long, value_name = "FILE.svg")]
    diagram: Option<PathBuf>,
    #[command(flatten)]
    foreign: Foreign,
    #[command(flatten)]
    format: Format,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    args.foreign.limit()?;
    if let Some(file) = &args.result {
        files::no_stream(file, "-o", "a file; without it the result goes to the standard output")?;
    }
    if let Some(file) = &args.diagram {
        files::no_stream(file, "--diagram", "a file")?;
        if file.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("svg")) {
            return Err(wrong_argument(format!("--diagram {}: expected a file NAME.svg", file.display())));
        }
        if args.result.as_ref() == Some(file) {
            return Err(wrong_argument(format!("--diagram {}: -o is the same file", file.display())));
        }
    }
    if is_fmu(&args.file) {
        fmu::run(args)
    } else if is_system(&args.file) {
        fmu::run_system(args, system::read(&args.file)?)
    } else {
        native::run(args)
    }
}

/// The most numbers of a result that stays in memory until it is complete: some hundred megabytes.
const MOST_NUMBERS: f64 = 1e7;

/// The most communication points: beyond, two of them could be equal.
const MOST_POINTS: f64 = 1e15;

/// The work between a shaft and a drive.
#[derive(Serialize)]
struct Shared<'a> {
    shaft: &'a str,
    drive: &'a str,
    /// The exchanged work and the part of it by which the two sides differ (J), summed over the steps.
    exchanged: f64,
    difference: f64,
    /// The largest difference of a step (J), and the start of this step (s).
    largest: f64,
    largest_at: f64,
    /// The step (s) at which a thousandth would differ; None if less differs already.
    needed_step: Option<f64>,
}

/// A column of the result.
#[derive(Clone, Serialize)]
struct Column {
    name: String,
    /// None if it is unknown.
    unit: Option<String>,
    description: String,
    /// Headings contain the unit if this is false.
    #[serde(skip)]
    is_si: bool,
}

/// The result as one document.
#[derive(Serialize)]
struct Document<'a> {
    name: &'a str,
    model: Option<&'static str>,
    columns: Vec<Recorded<'a>>,
    /// The reason for an end before the stop time; None without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    ended: Option<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    shared: Vec<Shared<'a>>,
}

/// A column with its values.
#[derive(Serialize)]
struct Recorded<'a> {
    #[serde(flatten)]
    column: &'a Column,
    values: Vec<f64>,
}

/// A run over `start` … `stop`, and its record.
#[derive(Default)]
struct Run {
    name: String,
    model: Option<&'static str>,
    columns: Vec<Column>,
    start: f64,
    stop: f64,
    step: f64,
    /// Its input files.
    files: Vec<PathBuf>,
    /// The variables of the columns after the time.
    outputs: Vec<usize>,
    signals: Signals,
    /// The first value that is not finite: the variable, the value and the time (s).
    undefined: Option<(usize, f64, f64)>,
}

impl Run {
    /// A run of a machine with this name over the times of the options, or of the experiment.
    fn new(args: &Args, name: &str, start: f64, experiment: &Experiment) -> Result<Self, Failure> {
        let stop = optional("stop", &args.stop, &unit::TIME)?.unwrap_or(experiment.stop);
        let step = optional("step", &args.step, &unit::TIME)?.unwrap_or(experiment.step);
        let refused = |name: &str, given: &Option<String>, message: String| match given {
            Some(_) => wrong_argument(format!("--{name}: {message}")),
            None => failure(format!("--{name}, by default: {message}")),
        };
        if !(stop > start && (stop - start).is_finite()) {
            let (stop, start) = (Number(stop), Number(start));
            let message = format!("{stop} s does not exceed the start time {start} s by a finite time");
            return Err(refused("stop", &args.stop, message));
        }
        let least = (stop - start) / MOST_POINTS;
        if !(step >= least && step.is_finite()) {
            let (step, least) = (Number(step), Number(least));
            let message = format!("{step} s is not admissible; expected at least {least} s");
            return Err(refused("step", &args.step, message).hint("give one, such as --step \"1 ms\""));
        }
        let column =
            Column { name: "time".to_owned(), unit: Some("s".to_owned()), description: "Time".to_owned(), is_si: true };
        let (name, files) = (name.to_owned(), vec![args.file.clone()]);
        Ok(Run { name, columns: vec![column], start, stop, step, files, ..Run::default() })
    }

    /// Runs it, and writes the result as the options say; a run that fails writes its rows so far, and the reason.
    fn record(&mut self, args: &Args, subject: &mut dyn Subject) -> Result<(), Failure> {
        if !args.format.json && args.result.is_none() && args.diagram.is_none() {
            return self.stream(subject);
        }
        self.may_be_kept()?;
        let mut rows: Vec<Vec<f64>> = Vec::new();
        let ending = self.drive(subject, |line| {
            rows.push(line.to_vec());
            Ok(true)
        });
        let (ended, failed) = match ending {
            Err(failure) if !rows.is_empty() => {
                (Some(failure.fault.to_string().trim_start_matches("error: ").to_owned()), Err(failure))
            }
            ending => (ending?, Ok(())),
        };
        let text = if args.format.json {
            self.document(&rows, ended, subject)?
        } else {
            rows.iter().fold(self.headings()?, |mut table, line| {
                append(&mut table, line);
                table
            })
        };
        let mut files: Vec<(PathBuf, String)> = Vec::new();
        if let Some(path) = &args.diagram {
            match self.diagram(&rows) {
                Err(_) if failed.is_err() => (),
                diagram => files.push((path.clone(), diagram?)),
            }
        }
        match &args.result {
            None => {
                files::write(&files, &self.files)?;
                print(&text)?;
            }
            Some(path) => {
                files.push((path.clone(), text));
                files::write(&files, &self.files)?;
            }
        }
        failed
    }

    /// Writes the lines to the standard output as they come.
    fn stream(&mut self, subject: &mut dyn Subject) -> Result<(), Failure> {
        let mut out = std::io::BufWriter::new(std::io::stdout().lock());
        // A reader that closes the pipe ends the run.
        let open = |result: std::io::Result<()>| match result {
            Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(false),
            Err(e) => Err(failure(format!("the result cannot be written: {e}"))),
            Ok(()) => Ok(true),
        };
        let mut text = self.headings()?;
        self.drive(subject, |line| {
            append(&mut text, line);
            let written = open(out.write_all(text.as_bytes()));
            text.clear();
            written
        })?;
        open(out.flush()).map(|_| ())
    }

    fn headings(&self) -> Result<String, Failure> {
        let heading = |column: &Column| match &column.unit {
            Some(unit) if !column.is_si => format!("{} [{unit}]", column.name),
            _ => column.name.clone(),
        };
        text::csv([self.columns.iter().map(heading).collect()]).map_err(failure)
    }

    /// The result as JSON.
    fn document(&self, rows: &[Vec<f64>], ended: Option<String>, subject: &dyn Subject) -> Result<String, Failure> {
        let of = |(i, column)| Recorded { column, values: rows.iter().map(|row| row[i]).collect() };
        let columns = self.columns.iter().enumerate().map(of).collect();
        let document =
            Document { name: &self.name, model: self.model, columns, ended, shared: subject.shared(self.step) };
        text::json(&document).map_err(failure)
    }

    /// The columns over the time as SVG.
    fn diagram(&self, rows: &[Vec<f64>]) -> Result<String, Failure> {
        let course = |column: &Column| Course {
            name: column.name.clone(),
            unit: column.unit.clone().unwrap_or_else(|| "?".to_owned()),
            text: column.description.clone(),
        };
        let columns: Vec<Course> = self.columns[1..].iter().map(course).collect();
        let drawn = results::diagram(&self.name, &columns, rows);
        let (drawing, label) = drawn.ok_or_else(|| {
            wrong_argument("--diagram: no column changes except angles that keep growing")
                .hint("choose others with --output")
        })?;
        Ok(drawing.svg(&label, picture::SCALE))
    }

    /// Refuses a result that would fill the memory.
    fn may_be_kept(&self) -> Result<(), Failure> {
        let numbers = (self.stop - self.start) / self.step * self.columns.len() as f64;
        if numbers <= MOST_NUMBERS {
            return Ok(());
        }
        let hint =
            "use a longer --step, fewer columns with --output, or CSV on the standard output, which has no limit";
        let step = Number(self.step);
        Err(wrong_argument(format!(
            "--step: {step} s yields {numbers:.1e} numbers; expected at most {MOST_NUMBERS:.0e}"
        ))
        .hint(hint))
    }

    /// Gives each line, the time and the values, to `write`, until it returns false. Returns the reason if an FMU ended the
    /// simulation.
    fn drive(
        &mut self,
        subject: &mut dyn Subject,
        mut write: impl FnMut(&[f64]) -> Result<bool, Failure>,
    ) -> Result<Option<String>, Failure> {
        // Lines on a terminal show the progress already.
        let bar = counter("run", ((self.stop - self.start) / self.step).ceil() as u64);
        if std::io::stdout().is_terminal() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        subject.begin(self)?;
        let mut recording = Recording::start(subject, &self.signals, &self.outputs, self.start)?;
        let (mut count, mut time, mut line) = (0.0, self.start, Vec::new());
        loop {
            recording.at(time, &mut line)?;
            recording.source.warn();
            let undefined = || (1..line.len()).find(|i| !line[*i].is_finite());
            self.undefined = self.undefined.or_else(|| undefined().map(|i| (self.outputs[i - 1], line[i], time)));
            if !write(&line)? || time >= self.stop {
                return Ok(None);
            }
            count += 1.0;
            // A time within a millionth of a step of the end is the end.
            let next = self.start + count * self.step;
            let next = if next > self.stop - 1e-6 * self.step { self.stop } else { next };
            while recording.time < next {
                let (from, to) = (recording.time, recording.next(next));
                let admitted = recording.source.admit(from, to - from, self.step);
                if let Err(fault) = admitted.and_then(|()| recording.step(to)) {
                    let span = format!("from t = {} s to {} s", Number(from), Number(to));
                    if !recording.source.has_ended() {
                        return Err(fault.within(span).into());
                    }
                    let why = format!("{span}: {fault}");
                    print_message(&format!("warning: {why}; the result ends at t = {} s\n", Number(time)));
                    return Ok(Some(why));
                }
                recording.source.warn();
            }
            bar.inc(1);
            time = next;
        }
    }
}

/// Appends a line of CSV; `{:?}` prints all digits, with an exponent if that is shorter.
fn append(table: &mut String, line: &[f64]) {
    for (i, value) in line.iter().enumerate() {
        // Writing to a String cannot fail.
        let _ = write!(table, "{}{value:?}", if i == 0 { "" } else { "," });
    }
    table.push('\n');
}

/// Splits "y,der(y,2),q" at the commas between names.
fn names_of(text: &str) -> Vec<&str> {
    let mut depth = 0;
    text.split(|c: char| {
        depth += i32::from(c == '(' || c == '[') - i32::from(c == ')' || c == ']');
        c == ',' && depth == 0
    })
    .map(str::trim)
    .collect()
}

/// Name and text of the value of `--start`.
fn name_and_value(text: &str) -> Result<(&str, &str), Failure> {
    let (name, value) =
        text.split_once('=').ok_or_else(|| wrong_argument(format!("--start {text}: expected NAME=VALUE")))?;
    Ok((name.trim(), value.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_may_hold_commas() {
        assert_eq!(names_of("y, der(y,2),follower[1].m"), ["y", "der(y,2)", "follower[1].m"]);
    }
}
