//! Inputs over time from a table.

use crate::command::{Failure, failure};
use crate::scene;
use camdrive::drives::Description;
use camdrive::drives::variable::Causality;
use camdrive_design::recording::Signals;
use std::path::Path;

/// The table of the inputs among these variables; `own` is the unit of a variable if it is not SI.
pub fn read(path: &Path, all: &[Description], own: impl Fn(usize) -> Option<String>) -> Result<Signals, Failure> {
    let inputs: Vec<usize> = (0..all.len()).filter(|i| all[*i].causality == Causality::Input).collect();
    let of: Vec<&Description> = inputs.iter().map(|i| &all[*i]).collect();
    let table = scene::courses(path, &of, |input| own(inputs[input])).map_err(failure)?;
    let columns = table.columns.into_iter().map(|(column, values)| (inputs[column], values)).collect();
    Signals::new(all, table.times, columns).map_err(|fault| failure(fault.within(path.display())))
}
