//! `camdrive system SYSTEM --study`

use super::{Args, libraries, packed};
use crate::command::deliver::ReportFiles;
use crate::command::output::Bar;
use crate::command::{Failure, failure, print_message};
use crate::export::Date;
use crate::system::single::Single;
use crate::system::{self, INERTIA, System};
use camdrive::drives::variable::{Causality, Kind, Variability};
use camdrive_design::coupling::exchange::Coupling;
use camdrive_design::coupling::stability::Exchange;
use camdrive_design::coupling::study::{self, Candidate, Findings, Make, Output, Port, Reference, Way};
use camdrive_design::host::{Fmu, Variable};
use camdrive_design::text::{self, time};
use std::path::Path;

/// The compared exchanges, and the masters that use them.
const MASTERS: [(Exchange, &str); 5] = [
    (Exchange::Held, "a master that holds inputs"),
    (Exchange::Extrapolated, ""),
    (Exchange::GaussSeidel, ""),
    (Exchange::Interpolated, "run.py"),
    (Exchange::EffectiveInertia, "run.py and effective_inertia"),
];

/// The steps of a reference that is no train, as fractions of the system's step, and its repetitions.
const FINE: [f64; 2] = [64.0, 32.0];
const REPEATS: u32 = 2;

/// The units of positions and speeds.
const MOTIONS: [&str; 4] = ["m", "rad", "m/s", "rad/s"];

/// The tolerances of the train as the reference and as a check of it.
const TOLERANCES: [f64; 2] = [1e-12, 1e-10];

pub fn run(args: &Args, system: &System, folder: &Path) -> Result<(), Failure> {
    let (findings, single) = findings(&args.system, system)?;
    let mut place = ReportFiles { folder: Some(folder), inputs: system.files.clone(), ..ReportFiles::default() };
    if let Some(single) = &single {
        let date = Date::from_environment().map_err(failure)?;
        let fmu = packed(&single.scene, &libraries()?, date).map_err(failure)?;
        place.more.push((folder.join(fmu_of(single)), fmu));
    }
    args.format.deliver(findings.report(), &findings, place)
}

/// The errors over the communication step, and the system as a train.
pub fn findings(path: &Path, system: &System) -> Result<(Findings, Option<Single>), Failure> {
    let single = system.train();
    if let Err(reason) = &single {
        print_message(&format!("note: {}: it cannot be one DriveTrain: {reason}\n", text::in_one_line(path.display())));
    }
    let single = single.ok();
    let systems = coupled(path);
    let mut candidates = Vec::new();
    for (exchange, master, read) in &systems {
        let way = Way {
            exchange: system::name_of(*exchange).to_owned(),
            repeats: 0,
            master: (*master).to_owned(),
            stable: None,
            fault: None,
            steps: [None; 2],
        };
        let system = match read {
            Ok(system) => system,
            Err(fault) => {
                candidates.push(Candidate { way: Way { fault: Some(fault.clone()), ..way }, make: None });
                continue;
            }
        };
        let repeated = (system.repeats > 0).then(|| (system.repeats, master.replace("run.py", "camdrive run")));
        for (repeats, master) in std::iter::once((0, way.master.clone())).chain(repeated) {
            let shafts = system.limits(repeats);
            let stable = shafts.iter().filter_map(|shaft| shaft.limit.stable).min_by(f64::total_cmp);
            let make: Make<'_> = Box::new(move || system.coupled(*exchange, repeats));
            candidates.push(Candidate { way: Way { repeats, master, stable, ..way.clone() }, make: Some(make) });
        }
    }
    let (reference, outputs) = match &single {
        Some(single) => (as_train(single), compared(system, Some(single))?),
        None => {
            // The most accurate available exchange.
            let best = systems.iter().rev().find_map(|(.., read)| read.as_ref().ok()).unwrap_or(system);
            (finer(best, system.step), compared(system, None)?)
        }
    };
    let findings = Bar::during(&system.name, |progress| {
        let system = study::System { name: &system.name, step: system.step, stop: system.stop };
        study::study(system, candidates, outputs, reference, progress)
    });
    let findings = findings.map_err(|fault| failure(fault.within(path.display())))?;
    Ok((findings, single))
}

/// The system, wired for each exchange, or the reason why it cannot be.
fn coupled(path: &Path) -> Vec<(Exchange, &'static str, Result<System, String>)> {
    let mut systems = Vec::new();
    for (exchange, master) in MASTERS {
        let read = system::read_as(path, exchange);
        let read =
            read.map_err(|faults| faults.0.into_iter().map(|fault| fault.message).collect::<Vec<_>>().join("; "));
        // Without a rigid load this is the same as interpolated.
        let by_inertia = |system: &System| system.connections.iter().any(|c| c.from.1 == INERTIA[0]);
        if exchange != Exchange::EffectiveInertia || !read.as_ref().is_ok_and(|system| !by_inertia(system)) {
            systems.push((exchange, master, read));
        }
    }
    systems
}

fn fmu_of(single: &Single) -> String {
    format!("{}.fmu", single.scene.name)
}

/// The train as a system of one part.
fn as_train(single: &Single) -> Reference<'_> {
    let of = |tolerance: f64| -> (Make<'_>, f64) {
        let make = move || {
            let mut host = Fmu::linked(&single.scene.resource())?.instantiate(&single.scene.name)?;
            if let Some(place) = host.description().find("solver.tolerance") {
                host.set(place, tolerance)?;
            }
            Coupling::alone(&single.scene.name, host)
        };
        (Box::new(make), f64::INFINITY)
    };
    Reference {
        about: "the same system as one DriveTrain".to_owned(),
        fmu: Some(fmu_of(single)),
        runs: TOLERANCES.map(of),
    }
}

/// The system itself at fractions of its step (s).
fn finer(system: &System, step: f64) -> Reference<'_> {
    let repeats = if system.repeats > 0 { REPEATS } else { 0 };
    let of =
        |part: f64| -> (Make<'_>, f64) { (Box::new(move || system.coupled(system.exchange, repeats)), step / part) };
    let about = format!("the same system in steps of {}, each repeated {repeats} times", time(step / FINE[0]));
    Reference { about, fmu: None, runs: FINE.map(of) }
}

/// The continuous outputs of both system and reference. After an impact, whose mean torque acts over a step, accelerations, forces
/// and torques grow with 1/step; only positions and speeds are compared then.
fn compared(system: &System, single: Option<&Single>) -> Result<Vec<Output>, Failure> {
    let train = single.map(|single| Fmu::linked(&single.scene.resource())).transpose().map_err(failure)?;
    let has_impacts = system.connections.iter().any(|c| c.from.1.ends_with("_mean"));
    let mut outputs = Vec::new();
    for (p, part) in system.parts.iter().enumerate() {
        for Variable { about, unit, .. } in &part.description.variables {
            let is_mean = about.name.ends_with("_mean") || INERTIA.contains(&&*about.name);
            let is_real = matches!(about.kind, Kind::Real { .. }) && about.variability != Variability::Discrete;
            let jumps = has_impacts && !MOTIONS.contains(&&*unit.name);
            if about.causality != Causality::Output || is_mean || !is_real || jumps {
                continue;
            }
            let here = Port { part: p, name: about.name.clone(), factor: 1.0, offset: 0.0 };
            let there = match single.zip(train.as_ref()) {
                None => Some(here.clone()),
                Some((single, train)) => single.counterpart(system, p, &about.name).and_then(|found| {
                    train.description().find(&found.name)?;
                    Some(found)
                }),
            };
            let name = format!("{}.{}", part.name, about.name);
            let output = |there| Output {
                name,
                unit: unit.name.clone(),
                largest: 0.0,
                known_to: 0.0,
                ports: [here.clone(), there],
            };
            outputs.extend(there.map(output));
        }
    }
    Ok(outputs)
}
