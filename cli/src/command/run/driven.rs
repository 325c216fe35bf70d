//! One drive or FMU with its start values, its inputs over time and what is read of it.

use super::signals::Signals;
use super::{Args, Column, Machine, Run, Shared, name_and_value, names_of};
use crate::command::{Failure, failure, wrong_argument};
use crate::scene::variable::finder;
use camdrive::drives::variable::Causality;
use camdrive::drives::{Description, Fault, Number};

/// What is driven alone: the drive of a scene, or an FMU. Variables are known by their places in a list; values are SI.
pub trait Source {
    /// Initialises it at this time (s); `inputs` sets inputs.
    fn start(&mut self, time: f64, inputs: impl FnOnce(&mut Self) -> Result<(), Fault>) -> Result<(), Fault>;
    /// The value that a text gives a variable.
    fn value(&mut self, variable: usize, text: &str) -> Result<f64, Fault>;
    /// Sets a parameter or an input.
    fn set(&mut self, variable: usize, value: f64) -> Result<(), Fault>;
    /// Sets the time derivative of an input, where that is used.
    fn set_slope(&mut self, variable: usize, value: f64) -> Result<(), Fault>;
    /// The value of a variable, as its column shows it.
    fn get(&mut self, variable: usize) -> Result<f64, Fault>;
    /// From a communication point on by a step (s).
    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault>;
    /// Whether it ended the simulation itself.
    fn has_ended(&self) -> bool {
        false
    }
    /// Tells warnings.
    fn warn(&mut self);
    /// What shafts and drives of a system disagree about.
    fn residuals(&self) -> Vec<Shared<'_>> {
        Vec::new()
    }
}

/// A source with its inputs.
struct Driven<S> {
    source: S,
    outputs: Vec<usize>,
    signals: Signals,
    start: f64,
    /// The first value that is none: the variable, the value and the time (s).
    undefined: Option<(usize, f64, f64)>,
}

/// Runs a source with these variables; `column` is that of a variable.
pub fn run<S: Source>(
    args: &Args,
    mut run: Run,
    all: &[Description],
    column: impl Fn(usize) -> Column,
    source: S,
) -> Result<S, Failure> {
    let find = finder(all);
    let outputs: Vec<usize> = match &args.output {
        None => (0..all.len()).filter(|i| all[*i].causality == Causality::Output).collect(),
        Some(names) => {
            let found = names_of(names).into_iter().map(&find);
            found.collect::<Result<_, _>>().map_err(|fault: Fault| wrong_argument(fault.within("--output")))?
        }
    };
    run.columns.extend(outputs.iter().map(|i| column(*i)));
    run.files.extend(args.input.clone());
    let own = |variable| Some(column(variable)).filter(|column| !column.is_si).and_then(|column| column.unit);
    let signals = args.input.as_ref().map(|path| Signals::read(path, all, own)).transpose()?.unwrap_or_default();
    let mut driven = Driven { source, outputs, signals, start: run.start, undefined: None };
    let mut given = Vec::new();
    for text in &args.start {
        let wrong = |fault: Fault| wrong_argument(fault.within(format_args!("--start {text}")));
        let (name, word) = name_and_value(text)?;
        let variable = find(name).map_err(wrong)?;
        if given.contains(&variable) {
            return Err(wrong(Fault::new(format!("`{name}` is given twice"))));
        }
        if driven.signals.give(variable) {
            return Err(wrong(Fault::new(format!("the table of --input gives `{name}`"))));
        }
        given.push(variable);
        let value = driven.source.value(variable, word).map_err(wrong)?;
        let set = driven.source.set(variable, value);
        set.map_err(|fault| if fault.is_loss { failure(fault) } else { wrong(fault) })?;
    }
    run.record(args, &mut driven)?;
    if let Some((variable, value, time)) = driven.undefined {
        let (name, time) = (&all[variable].name, Number(time));
        return Err(failure(format!("`{name}` is {value} at t = {time} s, which is no result")));
    }
    Ok(driven.source)
}

/// Sets the inputs of a communication point; between the rows of their table they go on as it says.
fn give(source: &mut impl Source, signals: &Signals, time: f64, initialised: bool) -> Result<(), Fault> {
    signals.at(time, |variable, value, slope| {
        source.set(variable, value)?;
        match slope {
            Some(slope) if initialised => source.set_slope(variable, slope),
            _ => Ok(()),
        }
    })
}

impl<S: Source> Machine for Driven<S> {
    fn start(&mut self) -> Result<(), Failure> {
        let (signals, time) = (&self.signals, self.start);
        let started = self.source.start(time, |source| give(source, signals, time, false));
        started.and_then(|()| give(&mut self.source, signals, time, true)).map_err(failure)
    }

    fn read(&mut self, line: &mut Vec<f64>) -> Result<(), Failure> {
        let time = line[0];
        for variable in &self.outputs {
            let value = self.source.get(*variable).map_err(failure)?;
            if !value.is_finite() {
                self.undefined.get_or_insert((*variable, value, time));
            }
            line.push(value);
        }
        self.source.warn();
        Ok(())
    }

    fn advance(&mut self, from: f64, to: f64) -> Result<Option<String>, Failure> {
        let mut from = from;
        while from < to {
            let next = self.signals.next(from, to);
            let step = self.source.advance(from, next - from);
            let step = step.and_then(|()| give(&mut self.source, &self.signals, next, true));
            let span = || format!("from t = {} s to {} s", Number(from), Number(next));
            match step {
                Err(fault) if self.source.has_ended() => return Ok(Some(format!("{}: {fault}", span()))),
                other => other.map_err(|fault| fault.within(span()))?,
            }
            self.source.warn();
            from = next;
        }
        Ok(None)
    }

    fn residuals(&self) -> Vec<Shared<'_>> {
        self.source.residuals()
    }
}
