//! An FMU, driven by its library.

use super::driven::{self, Source};
use super::{Args, Column, Run};
use crate::command::{Failure, failure, optional, tell};
use crate::scene::{units, variable};
use camdrive::drives::unit::TIME;
use camdrive::drives::variable::{Kind, Variability};
use camdrive::drives::{Description, Experiment, Fault, Number};
use camdrive_design::host::{Fmu, Host, ModelDescription, Variable};

/// Communication steps where the FMU tells none.
const STEPS: f64 = 1000.0;

/// Two values of a text that differ by less are one: model descriptions have factors with some digits only.
const SAME: f64 = 1e-6;

pub fn run(args: &Args) -> Result<(), Failure> {
    let fmu = Fmu::open(&args.file).map_err(failure)?;
    let ModelDescription { name, variables, experiment, .. } = fmu.description();
    let start = experiment.start.unwrap_or(0.0);
    let stop = optional("stop", &args.stop, &TIME)?
        .or(experiment.stop)
        .ok_or_else(|| failure("--stop: the FMU tells no stop time\n  = hint: give one, such as --stop \"1 s\""))?;
    let step = experiment.step.unwrap_or((stop - start) / STEPS);
    let run = Run::new(args, name, start, &Experiment { stop, step, tolerance: 0.0 })?;
    let column = |variable: usize| {
        let Variable { about, unit, .. } = &variables[variable];
        let told = Some(unit.name.clone()).filter(|name| !name.is_empty() || !matches!(about.kind, Kind::Real { .. }));
        Column { name: about.name.clone(), unit: told, description: about.text.clone(), is_si: unit.is_si() }
    };
    let all: Vec<Description> = variables.iter().map(|variable| variable.about.clone()).collect();
    let host = fmu.instantiate(name).map_err(|fault| failure(format!("{}: {fault}", args.file.display())))?;
    let (step, stop) = (run.step, run.stop);
    let imported = Imported { host, step, stop };
    let mut host = driven::run(args, run, &all, column, imported)?.host;
    if let Err(fault) = host.terminate() {
        tell(&format!("warning: {fault}\n"));
    }
    Ok(())
}

/// An instance, and the times of its run (s).
struct Imported {
    host: Host,
    step: f64,
    stop: f64,
}

impl Imported {
    fn variable(&self, variable: usize) -> &Variable {
        &self.host.description().variables[variable]
    }
}

impl Source for Imported {
    fn start(&mut self, time: f64, inputs: impl FnOnce(&mut Self) -> Result<(), Fault>) -> Result<(), Fault> {
        let tolerance = self.host.description().experiment.tolerance;
        self.host.set_up(time, Some(self.stop), tolerance)?;
        self.host.enter_initialization()?;
        inputs(self)?;
        self.host.exit_initialization()
    }

    fn value(&self, variable: usize, text: &str) -> Result<f64, String> {
        let Variable { about, unit, items, .. } = self.variable(variable);
        let (name, (number, word)) = (&about.name, units::split(text));
        if !items.is_empty() {
            let item = items.iter().find(|(item, value)| item == text || text.parse() == Ok(*value));
            let all = || items.iter().map(|(item, value)| format!("{value} ({item})")).collect::<Vec<_>>().join(", ");
            return item
                .map(|(_, value)| f64::from(*value))
                .ok_or_else(|| format!("`{name}`: \"{text}\" is not admissible; expected {}", all()));
        }
        let number: Option<f64> = number.parse().ok();
        let theirs = number.and_then(|number| Some(self.host.description().unit(variable, word)?.to_si(number)));
        match (number, theirs, variable::value(about, text)) {
            (Some(number), ..) if word.is_empty() && !unit.is_si() => Err(format!(
                "`{name}`: {number} may be in SI or in {unit}, the unit of the FMU\n  = hint: write the unit, \"{number} {unit}\"",
                unit = unit.name
            )),
            (_, Some(theirs), Ok(ours)) if (theirs - ours).abs() > SAME * ours.abs() => Err(format!(
                "`{name}`: {word} has another meaning in the FMU\n  = hint: give the value in another unit"
            )),
            (_, Some(theirs), Err(_)) => about.check(theirs).map(|()| theirs).map_err(|fault| fault.to_string()),
            (_, _, ours) => ours,
        }
    }

    fn set(&mut self, variable: usize, value: f64) -> Result<(), Fault> {
        let value = self.variable(variable).unit.of_si(value);
        self.host.set(variable, value)
    }

    fn set_slope(&mut self, variable: usize, value: f64) -> Result<(), Fault> {
        let Variable { about, reference, unit, .. } = self.variable(variable);
        let is_continuous = about.variability == Variability::Continuous;
        if !is_continuous || !self.host.description().capabilities.interpolates_inputs {
            return Ok(());
        }
        let (reference, slope) = (*reference, value / unit.factor);
        self.host.set_input_derivatives(&[reference], &[1], &[slope])
    }

    fn get(&mut self, variable: usize) -> Result<f64, Fault> {
        self.host.get(variable)
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        // The rounding of the communication points is none of the length.
        let is_other = (step - self.step).abs() > 1e-9 * time.abs().max(self.step);
        if is_other && !self.host.description().capabilities.variable_steps {
            let [step, own] = [step, self.step].map(Number);
            let hint = "a --step that divides the time, and rows of --input at communication points";
            return Err(Fault::new(format!(
                "the FMU takes steps of one length only (canHandleVariableCommunicationStepSize), {own} s, not {step} s\n  = hint: take {hint}"
            )));
        }
        self.host.do_step(time, step)
    }

    fn warn(&mut self) {
        for warning in self.host.warnings() {
            tell(&format!("warning: {warning}\n"));
        }
    }
}
