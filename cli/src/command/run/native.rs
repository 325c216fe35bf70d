//! A scene, run with the drive in this tool.

use super::driven::{self, Subject};
use super::{Args, Column, Run};
use crate::command::{Failure, failure, print_message, read};
use crate::export::model_description::unit;
use crate::scene::variable;
use camdrive::drives::{About, AnyDrive, Description, Fault, Number};

pub fn run(args: &Args) -> Result<(), Failure> {
    let resolved = read(&args.file)?;
    let mut drive = resolved.resource().build().map_err(failure)?;
    let experiment = drive.experiment();
    let mut run = Run::new(args, &resolved.name, 0.0, &experiment)?;
    (run.model, run.files) = (Some(resolved.scene.model_name()), resolved.files.clone());
    let all = drive.descriptions().to_vec();
    let column = |variable: usize| {
        let Description { name, text, kind, .. } = &all[variable];
        Column { name: name.clone(), unit: Some(unit(kind).to_owned()), description: text.clone(), is_si: true }
    };
    // Importers of its FMU ask for this tolerance.
    drive.set_up(0.0, Some(experiment.tolerance));
    driven::run(args, run, &all, column, &mut *drive)
}

impl Subject for AnyDrive {
    fn value(&mut self, variable: usize, text: &str) -> Result<f64, Fault> {
        variable::value(&self.descriptions()[variable], text)
    }

    /// Prints that inputs contradict each other.
    fn warn(&mut self) {
        let log = self.events();
        for event in log.iter().filter(|event| event.about == About::Inputs) {
            let [time, value] = [event.time, event.value].map(Number);
            let (kind, quantity, unit) = (event.kind, event.quantity, event.unit);
            print_message(&format!("warning: t = {time} s: {kind} ({quantity} {value} {unit})\n"));
        }
        log.clear();
    }
}
