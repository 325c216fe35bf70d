//! An FMU, driven through fmi-rs (feature `import`).

use super::{Args, Column, Machine, Run, name_and_value, names_of};
use crate::command::{Failure, failure, tell};
use crate::scene::variable::unknown;
use camdrive::drives::Experiment;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::fmi2::schema::{Causality, ScalarVariable, ScalarVariableElement as Element};
use fmi::traits::FmiImport;

pub fn run(args: &Args) -> Result<(), Failure> {
    // A second call finds the messages shown already.
    if log::set_logger(&Messages).is_ok() {
        log::set_max_level(log::LevelFilter::Warn);
    }
    let fmu: Fmi2Import = fmi::import::from_path(&args.file).map_err(|e| {
        let hint = "run takes an FMU 2.0; `camdrive export` makes one of a scene";
        failure(format!("{} cannot be imported: {e}\n  = hint: {hint}", args.file.display()))
    })?;
    let description = fmu.model_description();
    let variables = &description.model_variables.variables;
    let experiment = description.default_experiment.as_ref();
    let start = experiment.map_or(0.0, |e| e.start_time());
    let stop = experiment.and_then(|e| e.stop_time).unwrap_or(start + 1.0);
    let tolerance = experiment.and_then(|e| e.tolerance);
    let step = experiment.and_then(|e| e.step_size).unwrap_or((stop - start) / 1000.0);
    let mut run = Run::new(args, &description.model_name, start, &Experiment { stop, step, tolerance: 0.0 })?;
    let outputs: Vec<&ScalarVariable> = match &args.output {
        None => variables.iter().filter(|v| v.causality == Causality::Output).collect(),
        Some(names) => names_of(names).iter().map(|name| find(variables, name)).collect::<Result<_, _>>()?,
    };
    run.columns.extend(outputs.iter().map(|v| Column {
        name: v.name.clone(),
        // fmi-rs does not tell it.
        unit: None,
        description: v.description.clone().unwrap_or_default(),
    }));
    let mut instance = fmu.instantiate_cs("camdrive run", false, true).map_err(failure)?;
    for text in &args.start {
        let (variable, value) = start_value(variables, text)?;
        set(&mut instance, variable, value)?;
    }
    let mut machine = Imported { instance, outputs, span: [start, run.stop], tolerance };
    run.record(args, &mut machine)?;
    machine.instance.terminate().map_err(failed("fmi2Terminate")).map(|_| ())
}

/// An instance of an FMU.
struct Imported<'a> {
    instance: InstanceCS,
    outputs: Vec<&'a ScalarVariable>,
    span: [f64; 2],
    tolerance: Option<f64>,
}

impl Machine for Imported<'_> {
    fn start(&mut self) -> Result<(), Failure> {
        let ([start, stop], instance) = (self.span, &mut self.instance);
        instance.setup_experiment(self.tolerance, start, Some(stop)).map_err(failed("fmi2SetupExperiment"))?;
        instance.enter_initialization_mode().map_err(failed("fmi2EnterInitializationMode"))?;
        instance.exit_initialization_mode().map_err(failed("fmi2ExitInitializationMode")).map(|_| ())
    }

    fn read(&mut self, line: &mut Vec<f64>) -> Result<(), Failure> {
        for variable in &self.outputs {
            line.push(get(&mut self.instance, variable)?);
        }
        Ok(())
    }

    fn advance(&mut self, from: f64, to: f64) -> Result<(), Failure> {
        self.instance.do_step(from, to - from, true).map_err(failed(&format!("fmi2DoStep from {from} s"))).map(|_| ())
    }
}

fn failed(what: &str) -> impl Fn(fmi::fmi2::Fmi2Error) -> Failure {
    move |e| Failure(format!("error: {what}: the FMU returns {e}"))
}

fn find<'a>(variables: &'a [ScalarVariable], name: &str) -> Result<&'a ScalarVariable, Failure> {
    let message = || failure(unknown(name, variables.iter().map(|v| v.name.as_str())));
    variables.iter().find(|v| v.name == name).ok_or_else(message)
}

fn start_value<'a>(variables: &'a [ScalarVariable], text: &str) -> Result<(&'a ScalarVariable, f64), Failure> {
    let (name, value) = name_and_value(text)?;
    let variable = find(variables, name)?;
    let value = match value {
        "true" => 1.0,
        "false" => 0.0,
        number => number.parse().map_err(|_| {
            failure(format!(
                "--start {text}: of an FMU a number in the unit of the variable, true or false is expected"
            ))
        })?,
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
