//! The drive without each of its features: the changes and the costs.

use super::reference::Reference;
use super::rigid::{Formula, Shaft};
use super::run::{self, Inputs, Plan, Trace};
use super::simplification::{Simplification, Simplified};
use super::{Bench, Feature, sweep, worst_of};
use camdrive::drives::Fault;
use cpu_time::ThreadTime;
use std::collections::BTreeMap;

/// The shaft at the instants: from the run-up, else at its mean speed.
pub fn shaft(bench: &Bench, reference: &Reference) -> Vec<Shaft> {
    let grid = bench.grid;
    let times = (0..=grid.count).map(|k| k as f64 * grid.step);
    let names = bench.interface.names();
    let Some(column) = names.iter().position(|(name, _)| name == "phi") else {
        let run_up = &bench.run_up;
        let at = |t| Shaft { phi: run_up.angle(t), w: run_up.speed(t), a: run_up.acceleration(t, 0) };
        return times.map(at).collect();
    };
    let angle = |k: usize| reference.trace.row(k, names.len()).map_or(0.0, |row| row[column]);
    let (begin, end) = (angle(0), angle(grid.count));
    let w = (end - begin) / bench.stop();
    let share = |k: usize| k as f64 / grid.count as f64;
    (0..=grid.count).map(|k| Shaft { phi: begin + (end - begin) * share(k), w, a: 0.0 }).collect()
}

/// One run with this motion of the shaft.
pub fn run(simpler: &Simplification, bench: &Bench, shaft: &[Shaft]) -> Result<Trace, Fault> {
    match &simpler.model {
        Simplified::Scene(scene) => {
            let (fmu, interface) = scene.as_ref().map_err(Fault::clone)?;
            let inputs = if interface.derivatives > 0 { Inputs::Derivatives } else { Inputs::Values };
            let (starts, grid, run_up) = (&sweep::defaults(interface), bench.grid, &bench.run_up);
            run::run(&Plan { fmu, interface, starts, grid, run_up, inputs })
        }
        Simplified::Formula(formula) => Ok(evaluate(formula, shaft)),
    }
}

/// The names of its outputs.
fn outputs(simpler: &Simplification) -> Vec<String> {
    match &simpler.model {
        Simplified::Scene(Ok((_, interface))) => interface.names().into_iter().map(|(name, _)| name).collect(),
        Simplified::Scene(Err(_)) => Vec::new(),
        Simplified::Formula(formula) => formula.outputs.clone(),
    }
}

/// Runs it and compares with the run of the whole drive; with its own run if the whole drive's ends.
pub(super) fn first_run(
    simpler: &Simplification,
    bench: &Bench,
    shaft: &[Shaft],
    full: &Trace,
    reference: &Reference,
) -> (Feature, Option<Trace>) {
    let mut feature = Feature {
        feature: simpler.feature.clone(),
        instead: simpler.instead.clone(),
        change: None,
        worst: None,
        known_to: reference.summary.floor,
        cost: None,
        cost_ratio: None,
        changes: BTreeMap::new(),
        fault: None,
    };
    match run(simpler, bench, shaft) {
        Err(fault) => {
            feature.fault = Some(fault.to_string());
            (feature, None)
        }
        Ok(trace) => {
            let outputs = outputs(simpler);
            feature.changes = changes(bench, full, reference, &trace, &outputs);
            // Outputs that vanish with the feature, such as the twist of a rigid shaft, say nothing about the rest.
            let vanishes = |name: &String| {
                let column = outputs.iter().position(|other| other == name).unwrap_or(0);
                trace.values.iter().skip(column).step_by(outputs.len()).all(|value| *value == 0.0)
            };
            let mut remaining = feature.changes.iter().filter(|(name, _)| !vanishes(name)).peekable();
            (feature.worst, feature.change) = match remaining.peek() {
                Some(_) => worst_of(remaining, feature.known_to),
                None => worst_of(feature.changes.iter(), feature.known_to),
            };
            (feature, Some(trace))
        }
    }
}

/// The formulas at the instants.
fn evaluate(formula: &Formula, shaft: &[Shaft]) -> Trace {
    let mut values = Vec::with_capacity(formula.outputs.len() * shaft.len());
    let clock = ThreadTime::now();
    shaft.iter().for_each(|shaft| (formula.evaluate)(shaft, &mut values));
    let run_ns = clock.elapsed().as_secs_f64() * 1e9;
    Trace { values, stride: 1, start_ns: 0.0, run_ns, statistics: [f64::NAN; 3] }
}

/// The largest change of each output that both drives have, over the whole run, relative to its largest value and within the
/// reference's uncertainty.
fn changes(
    bench: &Bench,
    full: &Trace,
    reference: &Reference,
    trace: &Trace,
    outputs: &[String],
) -> BTreeMap<String, f64> {
    let names = bench.interface.names();
    let mut changes = BTreeMap::new();
    for (j, (name, _)) in names.iter().enumerate() {
        let Some(column) = outputs.iter().position(|other| other == name) else { continue };
        if reference.largest[j] == 0.0 {
            continue;
        }
        let at = |k: usize| Some(full.row(k, names.len())?[j] - trace.row(k, outputs.len())?[column]);
        let change = (0..=bench.grid.count).filter_map(at).fold(0.0, |max: f64, change| max.max(change.abs()));
        changes.insert(name.clone(), (change / reference.largest[j]).max(reference.summary.floor));
    }
    changes
}
