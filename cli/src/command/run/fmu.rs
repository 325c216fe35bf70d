//! FMUs, driven by their libraries: one, or those of a system.

use super::driven::{self, Source};
use super::{Args, Column, Run, Shared};
use crate::command::{Failure, failure, optional, tell, wrong_argument};
use crate::scene::variable::{self, connected};
use crate::system::System;
use camdrive::drives::unit::TIME;
use camdrive::drives::variable::{Kind, Variability};
use camdrive::drives::{Description, Experiment, Fault, Number};
use camdrive_design::coupling::exchange::{Balance, Coupling, Residual};
use camdrive_design::coupling::stability::Exchange;
use camdrive_design::coupling::variables::variables;
use camdrive_design::host::{Fmu, Host, ModelDescription, Variable};
use camdrive_design::text::{number, time};

/// Communication steps where the FMU tells none.
const STEPS: f64 = 1000.0;

/// The part of the work between shaft and drive that may differ before a shorter step is told.
const ADMISSIBLE: f64 = 1e-3;

pub fn run(args: &Args) -> Result<(), Failure> {
    let fmu = Fmu::open(&args.file).map_err(failure)?;
    let ModelDescription { name, experiment, .. } = fmu.description();
    let start = experiment.start.unwrap_or(0.0);
    let stop = optional("stop", &args.stop, &TIME)?
        .or(experiment.stop)
        .ok_or_else(|| wrong_argument("--stop: the FMU tells no stop time").hint("give one, such as --stop \"1 s\""))?;
    let step = experiment.step.unwrap_or((stop - start) / STEPS);
    let run = Run::new(args, name, start, &Experiment { stop, step, tolerance: 0.0 })?;
    let host = fmu.instantiate(name).map_err(|fault| fault.within(args.file.display()))?;
    let coupling = Coupling::new(vec![(String::new(), host)], &[], Exchange::Held, 0).map_err(failure)?;
    coupled(args, run, coupling).map(|_| ())
}

pub fn run_system(args: &Args, system: System) -> Result<(), Failure> {
    let mut run =
        Run::new(args, &system.name, 0.0, &Experiment { stop: system.stop, step: system.step, tolerance: 0.0 })?;
    run.files.extend(system.files.iter().cloned());
    let plain = system.repeats(&[], run.step).map_err(|message| wrong_argument(format!("--step: {message}")));
    let starts: Vec<(usize, &str, f64)> = args.start.iter().filter_map(|text| system.started(text)).collect();
    let repeats = match (system.repeats(&starts, run.step), starts.is_empty()) {
        (Ok(repeats), _) => repeats,
        (Err(message), false) if plain.is_ok() => return Err(wrong_argument(format!("--start: {message}"))),
        (Err(_), _) => plain?,
    };
    let coupling = system.coupled(system.exchange, repeats).map_err(failure)?;
    let run = coupled(args, run, coupling)?;
    run.unbalanced().iter().for_each(|said| tell(&format!("note: {said}\n")));
    for Shared { shaft, drive, exchanged, difference, largest, largest_at, needed_step } in run.residuals() {
        let part = number(100.0 * difference / exchanged);
        let [difference, largest, at] = [difference, largest, largest_at].map(number);
        let needed = needed_step.map_or_else(String::new, |step| format!("; 0.1 % at steps of {}", time(step)));
        tell(&format!(
            "note: {shaft} and {drive}: {difference} J of the work between them differ, {part} %; {largest} J in the \
             step from {at} s{needed}\n"
        ));
    }
    Ok(())
}

/// Runs coupled FMUs; the variables are those of the parts, each behind the name of its part where it has one.
fn coupled(args: &Args, run: Run, coupling: Coupling) -> Result<Imported, Failure> {
    let parts = |part: usize| (coupling.name(part), coupling.description(part));
    let (places, all) = variables((0..coupling.count()).map(parts), |part, place| coupling.is_connected(part, place));
    let column = |(about, (part, place)): (&Description, &(usize, usize))| {
        let unit = &coupling.description(*part).variables[*place].unit;
        let is_known = !unit.name.is_empty() || !matches!(about.kind, Kind::Real { .. });
        Column {
            name: about.name.clone(),
            unit: is_known.then(|| unit.name.clone()),
            description: about.text.clone(),
            is_si: unit.is_si(),
        }
    };
    let columns: Vec<Column> = all.iter().zip(&places).map(column).collect();
    let (step, stop) = (run.step, run.stop);
    let imported = Imported { coupling, places, step, stop };
    let mut imported = driven::run(args, run, &all, |variable| columns[variable].clone(), imported)?;
    let refusals = imported.coupling.end().map_err(failure)?;
    refusals.iter().for_each(|fault| tell(&format!("warning: {fault}\n")));
    Ok(imported)
}

/// The part of the work of drives that a shaft may not give, before it is told: below it lies the error of usual steps.
const BALANCED: f64 = 0.02;

/// Coupled instances, and the times of their run (s).
struct Imported {
    coupling: Coupling,
    /// The part and the place in its description of each variable.
    places: Vec<(usize, usize)>,
    step: f64,
    stop: f64,
}

impl Imported {
    /// The shafts that give other work than their drives take.
    fn unbalanced(&self) -> Vec<String> {
        let name = |part: &usize| self.coupling.name(*part);
        let names = |parts: &[usize]| parts.iter().map(name).collect::<Vec<_>>().join(", ");
        let differs = |of: &&Balance| of.part().is_some_and(|part| (part - 1.0).abs() > BALANCED);
        let said = |of: &Balance| {
            let ([taken, given], part) = (of.work.map(number), number(100.0 * of.part().unwrap_or_default()));
            let by = if of.by.is_empty() { String::new() } else { format!(" by way of {}", names(&of.by)) };
            let (drives, shaft) = (names(&of.drives), name(&of.shaft));
            format!(
                "{drives}: the work forth and back is {taken} J; the shaft of {shaft} gives {given} J{by}, {part} % of it"
            )
        };
        self.coupling.balances().iter().filter(differs).map(said).collect()
    }

    /// The instance that a variable is of, and its place there.
    fn host(&mut self, variable: usize) -> (&mut Host, usize) {
        let (part, place) = self.places[variable];
        (&mut self.coupling.parts()[part], place)
    }
}

impl Source for Imported {
    fn start(&mut self, time: f64, inputs: impl FnOnce(&mut Self) -> Result<(), Fault>) -> Result<(), Fault> {
        self.coupling.begin(time, Some(self.stop))?;
        inputs(self)?;
        self.coupling.start()
    }

    fn value(&mut self, variable: usize, text: &str) -> Result<f64, Fault> {
        let (part, place) = self.places[variable];
        if self.coupling.is_connected(part, place) {
            return Err(connected());
        }
        let description = self.coupling.description(part);
        let value = variable::imported(description, place, text)?;
        description.variables[place].about.check(value).map(|()| value)
    }

    fn set(&mut self, variable: usize, value: f64) -> Result<(), Fault> {
        let (host, variable) = self.host(variable);
        let value = host.description().variables[variable].unit.of_si(value);
        host.set(variable, value)
    }

    fn set_slope(&mut self, variable: usize, value: f64) -> Result<(), Fault> {
        let (host, variable) = self.host(variable);
        let Variable { about, reference, unit, .. } = &host.description().variables[variable];
        let is_continuous = about.variability == Variability::Continuous;
        if !is_continuous || !host.description().capabilities.interpolates_inputs {
            return Ok(());
        }
        let (reference, slope) = (*reference, value / unit.factor);
        host.set_input_derivatives(&[reference], &[1], &[slope])
    }

    fn get(&mut self, variable: usize) -> Result<f64, Fault> {
        let (host, variable) = self.host(variable);
        host.get(variable)
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        // The rounding of the communication points is none of the length.
        let is_other = (step - self.step).abs() > 1e-9 * time.abs().max(self.step);
        let one_length = |host: &Host| !host.description().capabilities.variable_steps;
        if is_other && self.coupling.parts().iter().any(one_length) {
            let [step, own] = [step, self.step].map(Number);
            let hint = "a --step that divides the time, and rows of --input at communication points";
            return Err(Fault::new(format!(
                "the FMU takes steps of one length only (canHandleVariableCommunicationStepSize), {own} s, not {step} s"
            ))
            .hint(format!("take {hint}")));
        }
        self.coupling.advance(time, step)
    }

    fn has_ended(&self) -> bool {
        self.coupling.has_ended()
    }

    fn warn(&mut self) {
        for part in self.coupling.parts() {
            part.warnings().iter().for_each(|warning| tell(&format!("warning: {warning}\n")));
        }
    }

    fn residuals(&self) -> Vec<Shared<'_>> {
        let shared = |residual: &Residual| {
            let Residual { parts, gross, exchanged, largest: [largest, largest_at], order, .. } = *residual;
            let [shaft, drive] = parts.map(|part| self.coupling.name(part));
            // The difference is of this order in the step.
            let shorter = (exchanged * ADMISSIBLE / gross).powf(1.0 / f64::from(order));
            let needed_step = (order > 0 && gross > exchanged * ADMISSIBLE).then_some(self.step * shorter);
            Shared { shaft, drive, exchanged, difference: gross, largest, largest_at, needed_step }
        };
        self.coupling.residuals().iter().map(shared).collect()
    }
}
