//! Torques of other units on a shaft, `torques` and `[coupling]` of a machine, and outputs of a drive for the inertia that follows
//! its shaft, `[coupling]` of a drive.

use crate::document::{Faults, Section, Value};
use camdrive::drives::Description;
use camdrive::drives::drive_train::{self, Shaft};
use camdrive::drives::rigid_machine::NamedLoad;
use camdrive::drives::variable::Causality;
use camdrive_design::resource::Scene;

/// The key of the table.
pub const KEY: &str = "coupling";
/// Its only key.
const INERTIA: &str = "inertia";
/// The names of the loads.
pub const TORQUES: &str = "torques";

/// The most loads.
const MOST: usize = 16;
/// The longest name: the name of its input then has at most 40 characters.
const LONGEST: usize = 31;

/// The loads of a machine; `plain` is true if it has an input `tau` when the scene names no loads.
pub fn of_machine(root: &Section<'_>, plain: bool) -> Option<Vec<NamedLoad>> {
    let names = names(root);
    let inertia = root.read(KEY, |section| {
        let all = match section.node(INERTIA).map(|node| node.value) {
            Some(Value::Array(_)) => section.texts(INERTIA).map(Err),
            _ => section.flag(INERTIA).map(Ok),
        };
        section.finish();
        all
    });
    let (mut loads, inertia) = (names?, inertia?.unwrap_or(Ok(false)));
    if loads.is_empty() && plain {
        loads.push(NamedLoad::default());
    }
    let known = loads.iter().map(|load| load.name.clone()).collect::<Vec<_>>().join(", ");
    let section = root.section(KEY)?;
    match (inertia, section) {
        (Ok(true), Some(section)) if loads.len() != 1 => {
            let (said, hint) = match loads.len() {
                0 => (": the shaft has no load of another unit", "remove it".to_owned()),
                _ => (": which of the loads is meant?", format!("write a list of their names: {known}")),
            };
            let fault = section.fault_of(INERTIA, said);
            return section.refuse(fault.hint(hint));
        }
        (Ok(inertia), _) => loads.iter_mut().for_each(|load| load.inertia = inertia),
        (Err(wanted), Some(section)) => {
            for (name, node) in wanted {
                match loads.iter_mut().find(|load| load.name == name && !name.is_empty()) {
                    Some(load) if !load.inertia => load.inertia = true,
                    found => {
                        let said = if found.is_some() { "stands there twice" } else { "is no load of this machine" };
                        let fault = section.faults.at(node.span, format!(": \"{name}\" {said}")).of(node.path);
                        let hint = if known.is_empty() { "name the loads in `torques`, or write true" } else { "" };
                        section.faults.report(if hint.is_empty() {
                            fault.admissible(&*known)
                        } else {
                            fault.hint(hint)
                        });
                    }
                }
            }
        }
        (Err(_), None) => {}
    }
    Some(loads)
}

/// Refuses loads with an inertia on a shaft that is solved as a train.
pub fn refuse_inertia(root: &Section<'_>, loads: &[NamedLoad]) -> Option<()> {
    if !loads.iter().any(|load| load.inertia) {
        return Some(());
    }
    let said = ": only a RigidMachine takes the inertia of loads, with the motor none, kloss or input, without transmission and without \
                loads of its own";
    let section = root.section(KEY)??;
    section.refuse(section.fault_of(INERTIA, said).hint("remove it and connect tau, or write one DriveTrain"))
}

/// `torques`; empty without the key.
fn names(root: &Section<'_>) -> Option<Vec<NamedLoad>> {
    if !root.has(TORQUES) {
        return Some(Vec::new());
    }
    let list = root.texts(TORQUES)?;
    if !(1..=MOST).contains(&list.len()) {
        let fault = root.fault_of(TORQUES, format!(" has {} names", list.len()));
        return root.refuse(fault.admissible(format!("1 to {MOST}")).hint("leave it out for the plain input tau"));
    }
    let mut loads: Vec<NamedLoad> = Vec::new();
    for (name, node) in list {
        let letters = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(letters);
        let twice = loads.iter().any(|load| load.name == name);
        if twice || !is_name || name.len() > LONGEST {
            let said = if twice { "stands there twice" } else { "cannot name a load" };
            let fault = root.faults.at(node.span, format!(": \"{name}\" {said}")).of(node.path);
            root.faults.report(fault.admissible(format!(
                "different names of letters, digits and _, a letter first, at most {LONGEST} characters"
            )));
        }
        loads.push(NamedLoad { name: name.to_owned(), inertia: false });
    }
    Some(loads)
}

/// True if a drive has outputs of its inertia; `has` is Ok if a part follows the shaft without slip, else it names what is missing.
pub fn of_drive(root: &Section<'_>, has: Result<(), &str>) -> Option<bool> {
    let wanted = root.read(KEY, |section| {
        let wanted = section.flag(INERTIA)?;
        if let (true, Err(hint)) = (wanted, has) {
            let fault = section.fault_of(INERTIA, ": no part of this drive follows its shaft without slip");
            return section.refuse(fault.hint(hint));
        }
        section.finish();
        Some(wanted)
    });
    Some(wanted?.unwrap_or(false))
}

/// Refuses names of loads that equal another variable of the FMU or start its name.
pub fn check_names(scene: &Scene, variables: &[Description], faults: &Faults<'_>) {
    let loads = match scene {
        Scene::RigidMachine(scene) => &scene.loads,
        Scene::DriveTrain(drive_train::Scene { shaft: Shaft::Free(machine), .. }) => &machine.loads,
        _ => return,
    };
    for name in loads.iter().map(|load| &load.name).filter(|name| !name.is_empty()) {
        let own = |v: &Description| v.causality == Causality::Input && v.name.starts_with(&format!("{name}."));
        let first = |v: &Description| v.name.split(['.', '[', '(']).next() == Some(name);
        let other = variables.iter().find(|variable| first(variable) && !own(variable));
        if let (Some(other), Some(place)) = (other, faults.place(TORQUES)) {
            let fault = faults.at(place, format!(": \"{name}\" is taken: the FMU has a variable `{}`", other.name));
            faults.report(fault.of(TORQUES).hint("choose another name for the load"));
        }
    }
}
