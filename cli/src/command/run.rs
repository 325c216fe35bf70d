//! `camdrive run FMU` (feature `import`)

use super::{Failure, failure, files, print, tell};
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::fmi2::schema::{Causality, ScalarVariable, ScalarVariableElement as Element};
use fmi::traits::FmiImport;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;

/// Simulates an FMU 2.0 over its default experiment and writes its outputs as CSV.
///
/// One line per communication point, the start included; the last step is shortened where the step does not divide
/// the time. Inputs keep their start values.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive run guide_bar.fmu -o result.csv
  camdrive run guide_bar.fmu --stop 0.5 --step 1e-3 --output y,q
  camdrive run guide_bar.fmu --start drive.w=200 --start start.mode=3

Enumerations are numbers from 1, Booleans true or false.")]
pub struct Args {
    /// The FMU (2.0, Co-Simulation)
    fmu: PathBuf,
    /// Stop time in s [default: that of the FMU]
    #[arg(long, value_name = "TIME")]
    stop: Option<f64>,
    /// Communication step in s [default: that of the FMU]
    #[arg(long, value_name = "TIME")]
    step: Option<f64>,
    /// Variables to write, separated by commas outside of parentheses and brackets [default: all outputs]
    #[arg(long, value_name = "NAMES")]
    output: Option<String>,
    /// Start value of a parameter or an input, in the unit of the variable; repeatable
    #[arg(long, value_name = "NAME=VALUE", allow_hyphen_values = true)]
    start: Vec<String>,
    /// File to write [default: the standard output]
    #[arg(short = 'o', long = "file", value_name = "FILE")]
    file: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    // A second call finds the messages shown already.
    if log::set_logger(&Messages).is_ok() {
        log::set_max_level(log::LevelFilter::Warn);
    }
    if let Some(file) = &args.file {
        files::no_stream(file, "-o", "a file; without it the table goes to the standard output")?;
    }
    let fmu: Fmi2Import = fmi::import::from_path(&args.fmu).map_err(|e| {
        let hint = "run takes an FMU 2.0; `camdrive export` makes one of a scene";
        failure(format!("{} cannot be imported: {e}\n  = hint: {hint}", args.fmu.display()))
    })?;
    let run = Run::new(&fmu, args)?;
    match &args.file {
        None => {
            let mut out = std::io::BufWriter::new(std::io::stdout().lock());
            let mut open = true;
            // A closed pipe ends the writing, which `print` treats as success too.
            let lines = run.drive(&fmu, |line| {
                match out.write_all(line.as_bytes()) {
                    Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => open = false,
                    other => other?,
                }
                Ok(open)
            });
            lines?;
            drop(out);
            print("")
        }
        Some(path) => {
            let unwritten = |e: std::io::Error| failure(format!("{} cannot be written: {e}", path.display()));
            let mut out = std::io::BufWriter::new(std::fs::File::create(path).map_err(unwritten)?);
            run.drive(&fmu, |line| out.write_all(line.as_bytes()).map(|()| true))?;
            out.flush().map_err(unwritten)
        }
    }
}

/// What is to be done with an FMU.
struct Run<'a> {
    start: f64,
    stop: f64,
    step: f64,
    tolerance: Option<f64>,
    outputs: Vec<&'a ScalarVariable>,
    starts: Vec<(&'a ScalarVariable, f64)>,
}

impl<'a> Run<'a> {
    fn new(fmu: &'a Fmi2Import, args: &Args) -> Result<Self, Failure> {
        let description = fmu.model_description();
        let variables = &description.model_variables.variables;
        let experiment = description.default_experiment.as_ref();
        let start = experiment.map_or(0.0, |e| e.start_time());
        let stop = args.stop.or(experiment.and_then(|e| e.stop_time)).unwrap_or(start + 1.0);
        let step = args.step.or(experiment.and_then(|e| e.step_size)).unwrap_or((stop - start) / 1000.0);
        if !(stop.is_finite() && stop > start) {
            return Err(Failure(format!("error: --stop {stop} does not exceed the start time {start} s")));
        }
        if !(step.is_finite() && step > 0.0) {
            return Err(Failure(format!("error: --step {step} is not greater than 0 s")));
        }
        let outputs = match &args.output {
            None => variables.iter().filter(|v| v.causality == Causality::Output).collect(),
            Some(names) => names_of(names).iter().map(|name| find(variables, name)).collect::<Result<_, _>>()?,
        };
        let starts = args.start.iter().map(|text| start_value(variables, text)).collect::<Result<_, _>>()?;
        Ok(Run { start, stop, step, tolerance: experiment.and_then(|e| e.tolerance), outputs, starts })
    }

    /// Gives each line of the table to `write`, until that says false.
    fn drive(&self, fmu: &Fmi2Import, mut write: impl FnMut(&str) -> std::io::Result<bool>) -> Result<(), Failure> {
        let mut write =
            |line: String| write(&line).map_err(|e| Failure(format!("error: the result cannot be written: {e}")));
        let mut instance =
            fmu.instantiate_cs("camdrive run", false, true).map_err(|e| Failure(format!("error: {e}")))?;
        for (variable, value) in &self.starts {
            set(&mut instance, variable, *value)?;
        }
        instance
            .setup_experiment(self.tolerance, self.start, Some(self.stop))
            .map_err(failed("fmi2SetupExperiment"))?;
        instance.enter_initialization_mode().map_err(failed("fmi2EnterInitializationMode"))?;
        instance.exit_initialization_mode().map_err(failed("fmi2ExitInitializationMode"))?;
        let names = self.outputs.iter().map(|v| quoted(&v.name));
        let mut open = write(std::iter::once("time".to_owned()).chain(names).collect::<Vec<_>>().join(",") + "\n")?;
        let mut time = self.start;
        let mut count = 0.0;
        open &= write(self.line(&mut instance, time)?)?;
        while open && time < self.stop {
            count += 1.0;
            // Within a millionth of a step of the end, the end is meant.
            let next = self.start + count * self.step;
            let next = if next > self.stop - 1e-6 * self.step { self.stop } else { next };
            instance.do_step(time, next - time, true).map_err(failed(&format!("fmi2DoStep from {time} s")))?;
            time = next;
            open = write(self.line(&mut instance, time)?)?;
        }
        instance.terminate().map_err(failed("fmi2Terminate")).map(|_| ())
    }

    fn line(&self, instance: &mut InstanceCS, time: f64) -> Result<String, Failure> {
        let mut line = format!("{time:?}");
        for variable in &self.outputs {
            // Writing to a String cannot fail. `{:?}` has all digits, and an exponent where that is shorter.
            let _ = write!(line, ",{:?}", get(instance, variable)?);
        }
        line.push('\n');
        Ok(line)
    }
}

fn failed(what: &str) -> impl Fn(fmi::fmi2::Fmi2Error) -> Failure {
    move |e| Failure(format!("error: {what}: the FMU returns {e}"))
}

/// Splits "y,der(y,2),q" at the commas that belong to no name.
fn names_of(text: &str) -> Vec<&str> {
    let mut depth = 0;
    text.split(|c: char| {
        depth += i32::from(c == '(' || c == '[') - i32::from(c == ')' || c == ']');
        c == ',' && depth == 0
    })
    .map(str::trim)
    .collect()
}

/// A name with a comma in it is quoted, as CSV has it.
fn quoted(name: &str) -> String {
    if name.contains(',') { format!("\"{name}\"") } else { name.to_owned() }
}

fn find<'a>(variables: &'a [ScalarVariable], name: &str) -> Result<&'a ScalarVariable, Failure> {
    variables.iter().find(|v| v.name == name).ok_or_else(|| {
        let names: Vec<&str> = variables.iter().map(|v| v.name.as_str()).collect();
        let guess = crate::scene::diagnostics::nearest(name, &names);
        let hint = guess.map_or(String::new(), |guess| format!("; did you mean `{guess}`?"));
        Failure(format!("error: the FMU has no variable `{name}`{hint}"))
    })
}

fn start_value<'a>(variables: &'a [ScalarVariable], text: &str) -> Result<(&'a ScalarVariable, f64), Failure> {
    let expected = || Failure(format!("error: --start `{text}`: expected NAME=VALUE with a number, true or false"));
    let (name, value) = text.split_once('=').ok_or_else(expected)?;
    let variable = find(variables, name.trim())?;
    let value = match value.trim() {
        "true" => 1.0,
        "false" => 0.0,
        number => number.parse().map_err(|_| expected())?,
    };
    Ok((variable, value))
}

fn set(instance: &mut InstanceCS, variable: &ScalarVariable, value: f64) -> Result<(), Failure> {
    let (r, whole) = ([variable.value_reference], value as i32);
    if !matches!(variable.elem, Element::Real(_)) && f64::from(whole) != value {
        return Err(Failure(format!("error: --start {}={value}: a whole number is expected", variable.name)));
    }
    let result = match variable.elem {
        Element::Real(_) => instance.set_real(&r, &[value]),
        Element::Integer(_) | Element::Enumeration => instance.set_integer(&r, &[whole]),
        Element::Boolean(_) => instance.set_boolean(&r, &[whole]),
        Element::String => return Err(Failure(format!("error: `{}` is a string", variable.name))),
    };
    result.map_err(failed(&format!("--start {}={value}", variable.name))).map(|_| ())
}

fn get(instance: &mut InstanceCS, variable: &ScalarVariable) -> Result<f64, Failure> {
    let r = [variable.value_reference];
    let (mut real, mut whole) = ([0.0], [0]);
    match variable.elem {
        Element::Real(_) => instance.get_real(&r, &mut real),
        Element::Integer(_) | Element::Enumeration => instance.get_integer(&r, &mut whole),
        Element::Boolean(_) => instance.get_boolean(&r, &mut whole),
        Element::String => return Err(Failure(format!("error: `{}` is a string", variable.name))),
    }
    .map_err(failed(&variable.name))?;
    Ok(if matches!(variable.elem, Element::Real(_)) { real[0] } else { f64::from(whole[0]) })
}

/// Warnings and errors of the FMU on the standard error.
struct Messages;

impl log::Log for Messages {
    fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
        metadata.level() <= log::Level::Warn
    }

    fn log(&self, record: &log::Record<'_>) {
        if self.enabled(record.metadata()) {
            tell(&format!("{}: {}\n", record.level().as_str().to_lowercase(), record.args()));
        }
    }

    fn flush(&self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_may_hold_commas() {
        assert_eq!(names_of("y, der(y,2),follower[1].m"), ["y", "der(y,2)", "follower[1].m"]);
        assert_eq!((quoted("der(y,2)").as_str(), quoted("y").as_str()), ("\"der(y,2)\"", "y"));
    }
}
