//! FMUs, driven by their libraries: one, or those of a system.

use super::driven::{self, Subject};
use super::{Args, Column, Run, Shared};
use crate::command::{Failure, failure, optional, print_message, wrong_argument};
use crate::scene::variable::{self, connected};
use crate::system::System;
use camdrive::drives::unit::TIME;
use camdrive::drives::variable::Kind;
use camdrive::drives::{Description, Experiment, Fault, Number};
use camdrive_design::coupling::exchange::{Balance, Coupling, Residual};
use camdrive_design::coupling::variables::variables;
use camdrive_design::host::{Fmu, Host, ModelDescription};
use camdrive_design::text::{number, time};

/// Communication steps for an FMU without a default.
const STEPS: f64 = 1000.0;

/// The admissible difference of work between shaft and drive, as a fraction; a larger one suggests a shorter step.
const ADMISSIBLE: f64 = 1e-3;

pub fn run(args: &Args) -> Result<(), Failure> {
    let fmu = Fmu::open(&args.file).map_err(failure)?;
    let ModelDescription { name, experiment, .. } = fmu.description();
    let start = experiment.start.unwrap_or(0.0);
    let stop = optional("stop", &args.stop, &TIME)?
        .or(experiment.stop)
        .ok_or_else(|| wrong_argument("--stop: the FMU has no stop time").hint("set one, such as --stop \"1 s\""))?;
    let step = experiment.step.unwrap_or((stop - start) / STEPS);
    let run = Run::new(args, name, start, &Experiment { stop, step, tolerance: 0.0 })?;
    let host = fmu.instantiate(name).map_err(|fault| fault.within(args.file.display()))?;
    coupled(args, run, Coupling::alone("", host)?).map(|_| ())
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
    let step = run.step;
    let coupling = coupled(args, run, coupling)?;
    unbalanced(&coupling).iter().for_each(|said| print_message(&format!("note: {said}\n")));
    for Shared { shaft, drive, exchanged, difference, largest, largest_at, needed_step } in coupling.shared(step) {
        let part = number(100.0 * difference / exchanged);
        let [difference, largest, at] = [difference, largest, largest_at].map(number);
        let needed = needed_step.map_or_else(String::new, |step| format!("; 0.1 % at steps of {}", time(step)));
        print_message(&format!(
            "note: {shaft} and {drive}: the work on both sides differs by {difference} J, {part} %, and by {largest} J in the \
             step from {at} s{needed}\n"
        ));
    }
    Ok(())
}

/// Runs coupled FMUs; the name of a variable follows the name of its part, if the part has one.
fn coupled(args: &Args, run: Run, mut coupling: Coupling) -> Result<Coupling, Failure> {
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
    driven::run(args, run, &all, |variable| columns[variable].clone(), &mut coupling)?;
    let refusals = coupling.end().map_err(failure)?;
    refusals.iter().for_each(|fault| print_message(&format!("warning: {fault}\n")));
    Ok(coupling)
}

/// The fraction of the drives' work that a shaft may fail to give without a warning: usual steps have a smaller error.
const BALANCED: f64 = 0.02;

/// The shafts whose work differs from the work of their drives.
fn unbalanced(coupling: &Coupling) -> Vec<String> {
    let name = |part: &usize| coupling.name(*part);
    let names = |parts: &[usize]| parts.iter().map(name).collect::<Vec<_>>().join(", ");
    let differs = |of: &&Balance| of.part().is_some_and(|part| (part - 1.0).abs() > BALANCED);
    let said = |of: &Balance| {
        let ([taken, given], part) = (of.work.map(number), number(100.0 * of.part().unwrap_or_default()));
        let by = if of.by.is_empty() { String::new() } else { format!(" through {}", names(&of.by)) };
        let (drives, shaft) = (names(&of.drives), name(&of.shaft));
        format!("{drives}: {taken} J of work are exchanged; the shaft of {shaft} gives {given} J{by}, {part} % of it")
    };
    coupling.balances().iter().filter(differs).map(said).collect()
}

impl Subject for Coupling {
    fn value(&mut self, variable: usize, text: &str) -> Result<f64, Fault> {
        let (part, place) = self.place(variable);
        if self.is_connected(part, place) {
            return Err(connected());
        }
        let description = self.description(part);
        let value = variable::imported(description, place, text)?;
        description.variables[place].about.check(value).map(|()| value)
    }

    fn begin(&mut self, run: &Run) -> Result<(), Fault> {
        Coupling::begin(self, run.start, Some(run.stop))
    }

    fn admit(&mut self, time: f64, step: f64, own: f64) -> Result<(), Fault> {
        // The communication points are rounded, the length is not.
        let is_other = (step - own).abs() > 1e-9 * time.abs().max(own);
        let one_length = |host: &Host| !host.description().capabilities.variable_steps;
        if is_other && self.parts().iter().any(one_length) {
            let [step, own] = [step, own].map(Number);
            let hint = "a --step that divides the time, and rows of --input at communication points";
            return Err(Fault::new(format!(
                "the FMU takes steps of one length only (canHandleVariableCommunicationStepSize), {own} s, not {step} s"
            ))
            .hint(format!("take {hint}")));
        }
        Ok(())
    }

    fn has_ended(&self) -> bool {
        Coupling::has_ended(self)
    }

    fn warn(&mut self) {
        for part in self.parts() {
            part.warnings().iter().for_each(|warning| print_message(&format!("warning: {warning}\n")));
        }
    }

    fn shared(&self, step: f64) -> Vec<Shared<'_>> {
        let shared = |residual: &Residual| {
            let Residual { parts, gross, exchanged, largest: [largest, largest_at], order, .. } = *residual;
            let [shaft, drive] = parts.map(|part| self.name(part));
            // The difference has this order in the step.
            let shorter = (exchanged * ADMISSIBLE / gross).powf(1.0 / f64::from(order));
            let needed_step = (order > 0 && gross > exchanged * ADMISSIBLE).then_some(step * shorter);
            Shared { shaft, drive, exchanged, difference: gross, largest, largest_at, needed_step }
        };
        self.residuals().iter().map(shared).collect()
    }
}
