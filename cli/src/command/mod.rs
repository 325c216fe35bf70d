//! The command line: one file per command.
//!
//! Results go to the standard output, everything else to the standard error. Exit code 0: done; 1: a fault in a scene or in the
//! export, a follower that lifts off in `forces`, or an output that does not agree in `verify`; 2: a wrong command line; 3:
//! `steady` found no periodic motion; 130: ended by Ctrl-C.
//!
#![doc = include_str!("../../../docs/json.md")]

mod cam;
mod check;
mod clearance;
mod compensate;
mod completions;
mod deliver;
mod describe;
mod driving;
mod ending;
mod export;
mod files;
mod forces;
mod help;
mod measured;
mod new;
mod output;
mod report;
mod run;
mod schema;
mod stability;
mod steady;
mod study;
mod synthesize;
mod system;
mod tradeoff;
mod verify;

use crate::document::limits::{Limits, within};
use crate::document::{Diagnostics, units};
use crate::export::{RuntimeLibrary, TOOL};
use crate::scene::{Resolved, open};
use camdrive::drives::limits::FASTEST;
use camdrive::drives::unit::{self, Quantity, TIME};
use camdrive::drives::{Fault, Number};
use camdrive_design::{host, text};
use clap::error::ErrorKind;
use clap::{FromArgMatches, Parser, Subcommand};
use output::{print, print_message, show, width};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Designs high-speed cam drives and machines, and exports them as FMUs (FMI 2.0 for Co-Simulation).
#[derive(Debug, Parser)]
#[command(name = "camdrive", version, after_help = AFTER_HELP, disable_help_subcommand = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

const AFTER_HELP: &str = "\
Example: from a scene file to an FMU
  camdrive export examples/guide_bar/scene.toml

A scene is a TOML file; a plain number is SI, a string carries its unit (\"1800 rpm\", \"0.94 mm\").
A command writes all of its files or none; it replaces earlier results, never an input.
Lines are as wide as the terminal, or COLUMNS; NO_COLOR leaves out the colours.
Exit codes: 0 done, 1 a fault in a scene or in the export, a follower that lifts off (forces), or
an output that does not agree (verify), 2 a wrong command line, 3 no periodic motion (steady),
130 ended by Ctrl-C.";

#[derive(Debug, Subcommand)]
enum Command {
    New(new::Args),
    Export(export::Args),
    Check(check::Args),
    Describe(describe::Args),
    Compensate(compensate::Args),
    Cam(cam::Args),
    Forces(forces::Args),
    Steady(steady::Args),
    Synthesize(synthesize::Args),
    Tradeoff(tradeoff::Args),
    Report(report::Args),
    Stability(stability::Args),
    Clearance(clearance::Args),
    Run(run::Args),
    Study(study::Args),
    System(system::Args),
    Verify(verify::Args),
    Schema(schema::Args),
    Completions(completions::Args),
    Help(help::Args),
}

/// The exit code for a machine without periodic motion.
const NO_MOTION: u8 = 3;

/// How a command prints its result.
#[derive(Clone, Copy, Debug, clap::Args)]
struct Format {
    /// Print the result as one JSON document; docs/json.md explains its fields
    #[arg(long)]
    json: bool,
}

impl Format {
    /// Writes the result to the standard output in this format; lines of text keep to a width.
    fn print(
        self,
        text: impl FnOnce(usize) -> String,
        json: impl FnOnce() -> Result<String, Fault>,
    ) -> Result<(), Failure> {
        if self.json { print(&json().map_err(failure)?) } else { show(&text(width())) }
    }
}

/// Limits for foreign libraries.
#[derive(Clone, Debug, clap::Args)]
struct Foreign {
    /// Longest admissible time for one call of a foreign FMU's library, in s or with a unit [default: 60 s]
    #[arg(long, value_name = "TIME", allow_hyphen_values = true)]
    timeout: Option<String>,
}

impl Foreign {
    /// Sets the limit for the calls of this command.
    fn limit(&self) -> Result<(), Failure> {
        let time = optional("timeout", &self.timeout, &TIME)?.unwrap_or(host::LIMIT);
        if !(LEAST_TIMEOUT..=LONGEST_TIMEOUT).contains(&time) {
            let [time, least, most] = [time, LEAST_TIMEOUT, LONGEST_TIMEOUT].map(Number);
            return Err(wrong_argument(format!("--timeout: {time} s is not admissible; expected {least} to {most} s")));
        }
        host::limit(time);
        Ok(())
    }
}

/// Limits of a call (s): loading a library takes some milliseconds; more than a year is no limit.
const LEAST_TIMEOUT: f64 = 0.1;
const LONGEST_TIMEOUT: f64 = 3e7;

/// The exit code of a wrong command line.
const WRONG_LINE: u8 = 2;

/// A failure of a command: its message on the standard error, and its exit code.
struct Failure {
    fault: Fault,
    code: u8,
}

impl Failure {
    /// A failure in a scene, another file or a result, with this text.
    fn new(text: String) -> Self {
        Failure { fault: Fault::new(text), code: 1 }
    }

    /// The same failure with this hint.
    fn hint(self, hint: impl Into<String>) -> Self {
        Failure { fault: self.fault.hint(hint), ..self }
    }
}

impl From<Fault> for Failure {
    fn from(fault: Fault) -> Self {
        Failure { fault: fault.within("error"), code: 1 }
    }
}

impl From<String> for Failure {
    fn from(message: String) -> Self {
        Fault::new(message).into()
    }
}

impl From<&str> for Failure {
    fn from(message: &str) -> Self {
        Fault::new(message).into()
    }
}

impl From<Diagnostics> for Failure {
    fn from(faults: Diagnostics) -> Self {
        Failure::new(faults.to_string())
    }
}

fn failure(fault: impl Into<Failure>) -> Failure {
    fault.into()
}

/// A wrong value on the command line.
fn wrong_argument(fault: impl Into<Failure>) -> Failure {
    Failure { code: WRONG_LINE, ..fault.into() }
}

/// The failure of a value on the command line, if the fault is an option's; its name replaces the name of the variable.
fn of_option(fault: &Fault) -> Option<Failure> {
    fault.variable.starts_with("--").then(|| wrong_argument(fault.clone()))
}

/// Runs the command line.
pub fn main() -> ExitCode {
    // A process that was started for a foreign library does nothing else.
    if let Some(code) = host::serve() {
        return code;
    }
    // A limit on the size of files makes writing fail, as a full disk does, but must not end the program halfway. Without the
    // handler the program still writes.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
    ending::watch();
    let cli = match help::command().try_get_matches().and_then(|found| Cli::from_arg_matches(&found)) {
        Ok(cli) => cli,
        Err(error) if error.kind() == ErrorKind::DisplayVersion => {
            return if print(&version()).is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE };
        }
        Err(error) if error.use_stderr() => {
            print_message(&error.render().to_string());
            return ExitCode::from(WRONG_LINE);
        }
        Err(error) => {
            // A closed terminal is no error.
            let _ = error.print();
            return ExitCode::SUCCESS;
        }
    };
    let mut ending = ExitCode::SUCCESS;
    let outcome = match cli.command {
        None => print(&help::overview()),
        Some(Command::New(args)) => new::run(&args),
        Some(Command::Export(args)) => export::run(&args),
        Some(Command::Check(args)) => check::run(&args).map(|code| ending = code),
        Some(Command::Describe(args)) => describe::run(&args),
        Some(Command::Compensate(args)) => compensate::run(&args),
        Some(Command::Cam(args)) => cam::run(&args),
        Some(Command::Forces(args)) => forces::run(&args),
        Some(Command::Steady(args)) => steady::run(&args).map(|code| ending = code),
        Some(Command::Synthesize(args)) => synthesize::run(&args),
        Some(Command::Tradeoff(args)) => tradeoff::run(&args),
        Some(Command::Report(args)) => report::run(&args),
        Some(Command::Stability(args)) => stability::run(&args),
        Some(Command::Clearance(args)) => clearance::run(&args),
        Some(Command::Run(args)) => run::run(&args),
        Some(Command::Study(args)) => study::run(&args),
        Some(Command::System(args)) => system::run(&args),
        Some(Command::Verify(args)) => verify::run(&args).map(|code| ending = code),
        Some(Command::Completions(args)) => completions::run(&args),
        Some(Command::Schema(args)) => schema::run(&args),
        Some(Command::Help(args)) => help::run(&args),
    };
    match outcome {
        Ok(()) => ending,
        Err(Failure { fault, code }) => {
            print_message(&(fault.to_string().trim_end().to_owned() + "\n"));
            ExitCode::from(ending::code().unwrap_or(code))
        }
    }
}

/// Version, commit and the platforms that an export packs.
fn version() -> String {
    let names =
        |(libraries, _): (Vec<RuntimeLibrary>, _)| libraries.iter().map(|l| l.platform).collect::<Vec<_>>().join(", ");
    let platforms = RuntimeLibrary::at_hand(&[]).map_or_else(|_| "none".to_owned(), names);
    format!("{TOOL}\ncommit:    {}\nplatforms: {platforms}\n", env!("CAMDRIVE_COMMIT"))
}

/// The value of option `--name`.
fn quantity(name: &str, text: &str, quantity: &'static Quantity) -> Result<f64, Failure> {
    units::parse(text, quantity).map_err(|fault| wrong_argument(fault.within(format_args!("--{name}"))))
}

/// The value of the optional `--name`.
fn optional(name: &str, text: &Option<String>, of: &'static Quantity) -> Result<Option<f64>, Failure> {
    text.as_ref().map(|text| quantity(name, text, of)).transpose()
}

/// The value of the optional `--name` within these limits, which a refusal says in its unit.
fn limited(name: &str, text: &Option<String>, of: &'static Quantity, limits: Limits) -> Result<Option<f64>, Failure> {
    let value = optional(name, text, of)?;
    match (value, text) {
        (Some(value), Some(text)) if !limits.hold(value) => {
            let (unit, factor) = units::written(text, of).unwrap_or((of.unit, 1.0));
            let admissible = limits.over(factor).words(unit);
            let fault = format!("--{name}: \"{text}\" is out of range\n  = admissible: {admissible}");
            Err(wrong_argument(fault).hint(format!("write for example {}", units::example(of))))
        }
        _ => Ok(value),
    }
}

/// The value of the optional `--speed` of a shaft.
fn speed_option(text: &Option<String>) -> Result<Option<f64>, Failure> {
    limited("speed", text, &unit::ANGULAR_VELOCITY, within(-FASTEST, FASTEST))
}

/// Reads a scene, or the scene in an FMU.
fn read(path: &Path) -> Result<Resolved, Failure> {
    open(path).map_err(failure)
}

/// Reads all scenes and collects the faults of all of them.
fn read_all(paths: &[PathBuf]) -> Result<Vec<Resolved>, Failure> {
    let (mut scenes, mut faults) = (Vec::new(), String::new());
    for path in paths {
        match open(path) {
            Ok(scene) => scenes.push(scene),
            Err(more) => faults += &more.to_string(),
        }
    }
    if faults.is_empty() { Ok(scenes) } else { Err(Failure::new(faults)) }
}

/// Prints the notes on the laws of the scenes to the standard error. Only commands that judge or pack scenes do so, to avoid
/// repetitions in the others.
fn print_notes(paths: &[PathBuf], scenes: &[Resolved]) {
    for (path, scene) in paths.iter().zip(scenes) {
        for note in &scene.notes {
            print_message(&format!("note: {}: {note}\n", text::in_one_line(path.display())));
        }
    }
}
