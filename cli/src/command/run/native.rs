//! A scene, driven by the drive that is linked into the tool.

use super::signals::Signals;
use super::{Args, Column, Machine, Run, name_and_value, names_of};
use crate::command::{Failure, failure, read, tell};
use crate::export::model_description::unit;
use crate::scene::variable::{find, value};
use camdrive::drives::variable::Causality;
use camdrive::drives::{About, Description, Fault, Number};
use camdrive_design::resource::Described;

pub fn run(args: &Args) -> Result<(), Failure> {
    let resolved = read(&args.file)?;
    let mut drive = resolved.resource().build().map_err(failure)?;
    let experiment = drive.experiment();
    let mut run = Run::new(args, &resolved.name, 0.0, &experiment)?;
    (run.model, run.files) = (Some(resolved.scene.said()), resolved.files.clone());
    run.files.extend(args.input.clone());
    let all = drive.descriptions().to_vec();
    let outputs: Vec<usize> = match &args.output {
        None => (0..all.len()).filter(|i| all[*i].causality == Causality::Output).collect(),
        Some(names) => {
            let found = names_of(names).into_iter().map(|name| find(&all, name));
            found.collect::<Result<_, _>>().map_err(|e| failure(format!("--output: {e}")))?
        }
    };
    run.columns.extend(outputs.iter().map(|i| {
        let Description { name, text, kind, .. } = &all[*i];
        Column { name: name.clone(), unit: Some(unit(kind)), description: text.clone() }
    }));
    let signals = args.input.as_ref().map(|path| Signals::read(path, &all)).transpose()?.unwrap_or_default();
    // The tolerance that importers of its FMU ask for.
    drive.set_up(0.0, Some(experiment.tolerance));
    let mut given = Vec::new();
    for text in &args.start {
        let wrong = |message: String| failure(format!("--start {text}: {message}"));
        let (name, word) = name_and_value(text)?;
        let reference = find(&all, name).map_err(wrong)?;
        if given.contains(&reference) {
            return Err(wrong(format!("`{name}` is given twice")));
        }
        if signals.give(reference) {
            return Err(wrong(format!("the table of --input gives `{name}`")));
        }
        given.push(reference);
        let value = value(&all[reference], word).map_err(wrong)?;
        drive.set(reference, value).map_err(|fault| wrong(fault.to_string()))?;
    }
    run.record(args, &mut Native { drive, outputs, signals })
}

/// The drive of a scene with its inputs.
struct Native {
    drive: Described,
    outputs: Vec<usize>,
    signals: Signals,
}

impl Native {
    /// Sets the inputs of a communication point; between the rows of their table they go on as it says.
    fn give(&mut self, time: f64, initialised: bool) -> Result<(), Fault> {
        let highest = self.drive.input_derivative_order();
        let drive = &mut self.drive;
        self.signals.at(time, |reference, value, slope| {
            drive.set(reference, value)?;
            match slope {
                Some(slope) if initialised && highest > 0 => drive.set_input_derivative(reference, 1, slope),
                _ => Ok(()),
            }
        })
    }

    /// Tells that inputs contradict each other.
    fn warn(&mut self) {
        let log = self.drive.events();
        for event in log.iter().filter(|event| event.about == About::Inputs) {
            let [time, value] = [event.time, event.value].map(Number);
            let (kind, quantity, unit) = (event.kind, event.quantity, event.unit);
            tell(&format!("warning: t = {time} s: {kind} ({quantity} {value} {unit})\n"));
        }
        log.clear();
    }
}

impl Machine for Native {
    fn start(&mut self) -> Result<(), Failure> {
        let mut start = || {
            self.give(0.0, false)?;
            self.drive.start()?;
            self.give(0.0, true)
        };
        start().map_err(failure)
    }

    fn read(&mut self, line: &mut Vec<f64>) -> Result<(), Failure> {
        for reference in &self.outputs {
            line.push(self.drive.get(*reference).map_err(failure)?);
        }
        self.warn();
        Ok(())
    }

    fn advance(&mut self, from: f64, to: f64) -> Result<(), Failure> {
        let mut from = from;
        while from < to {
            let next = self.signals.next(from, to);
            let step = self.drive.advance(from, next - from).and_then(|()| self.give(next, true));
            let span = || format!("from t = {} s to {} s", Number(from), Number(next));
            step.map_err(|fault| failure(format!("{}: {fault}", span())))?;
            self.warn();
            from = next;
        }
        Ok(())
    }
}
