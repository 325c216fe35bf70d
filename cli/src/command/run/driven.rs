//! One drive or FMU with its start values, its inputs over time and its recorded variables.

use super::{Args, Column, Run, Shared, name_and_value, names_of, signals};
use crate::command::{Failure, failure, wrong_argument};
use crate::scene::variable::finder;
use camdrive::drives::variable::Causality;
use camdrive::drives::{Description, Fault, Number};
use camdrive_design::recording::Source;

/// A drive of a scene, an FMU or coupled FMUs, to run.
pub trait Subject: Source {
    /// The value of a variable from a text.
    fn value(&mut self, variable: usize, text: &str) -> Result<f64, Fault>;
    /// Begins the initialisation.
    fn begin(&mut self, _run: &Run) -> Result<(), Fault> {
        Ok(())
    }
    /// Refuses an impossible step from `time` on (s) if the other steps of the run have another length, `own` (s).
    fn admit(&mut self, _time: f64, _step: f64, _own: f64) -> Result<(), Fault> {
        Ok(())
    }
    /// True if it has ended the simulation itself.
    fn has_ended(&self) -> bool {
        false
    }
    /// Prints warnings.
    fn warn(&mut self);
    /// Quantities in which shafts and drives of a system differ at steps of this length (s).
    fn shared(&self, _step: f64) -> Vec<Shared<'_>> {
        Vec::new()
    }
}

/// Runs a subject with these variables; `column` is the column of a variable.
pub fn run(
    args: &Args,
    mut run: Run,
    all: &[Description],
    column: impl Fn(usize) -> Column,
    subject: &mut dyn Subject,
) -> Result<(), Failure> {
    let find = finder(all);
    run.outputs = match &args.output {
        None => (0..all.len()).filter(|i| all[*i].causality == Causality::Output).collect(),
        Some(names) => {
            let found = names_of(names).into_iter().map(&find);
            found.collect::<Result<_, _>>().map_err(|fault: Fault| wrong_argument(fault.within("--output")))?
        }
    };
    run.columns.extend(run.outputs.iter().map(|i| column(*i)));
    run.files.extend(args.input.clone());
    let own = |variable| Some(column(variable)).filter(|column| !column.is_si).and_then(|column| column.unit);
    run.signals = args.input.as_ref().map(|path| signals::read(path, all, own)).transpose()?.unwrap_or_default();
    let mut given = Vec::new();
    for text in &args.start {
        let wrong = |fault: Fault| wrong_argument(fault.within(format_args!("--start {text}")));
        let (name, word) = name_and_value(text)?;
        let variable = find(name).map_err(wrong)?;
        if given.contains(&variable) {
            return Err(wrong(Fault::new(format!("`{name}` is set twice"))));
        }
        if run.signals.have(variable) {
            return Err(wrong(Fault::new(format!("the table of --input sets `{name}`"))));
        }
        given.push(variable);
        let value = subject.value(variable, word).map_err(wrong)?;
        let set = subject.give(variable, value, None);
        set.map_err(|fault| if fault.is_loss { failure(fault) } else { wrong(fault) })?;
    }
    run.record(args, subject)?;
    if let Some((variable, value, time)) = run.undefined {
        let (name, time) = (&all[variable].name, Number(time));
        return Err(failure(format!("`{name}` is {value} at t = {time} s, which is no result")));
    }
    Ok(())
}
