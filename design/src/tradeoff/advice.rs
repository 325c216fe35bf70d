//! One sentence per target accuracy: what to use, what it costs, what may be left out.

use super::{Feature, Report, Row, bounded};
use crate::text::{number, share, time};
use serde::Serialize;

/// The accuracies that people ask for.
const TARGETS: [f64; 4] = [1e-3, 1e-6, 1e-9, 1e-12];

/// Costs closer than this are the same: then the smaller error decides.
const SAME_COST: f64 = 1.1;

/// A sentence names this many features that must stay, those with the smallest changes.
const MOST_TOLD: usize = 3;

/// The advice for a target accuracy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// The largest admissible error of an output, relative to its largest value.
    pub target: f64,
    /// The row of the setting; None where none reaches the target.
    pub setting: Option<usize>,
    /// The features that may be left out: their change is below the target, and it saves time.
    pub may_be_left_out: Vec<String>,
    /// The advice.
    pub sentence: String,
}

/// The advice that a report gives.
pub fn of(report: &Report) -> Vec<Advice> {
    TARGETS.into_iter().map(|target| for_target(report, target)).collect()
}

/// CPU time of a setting (ns per ms).
fn cost_of(report: &Report, i: usize) -> f64 {
    report.settings[i].cost.map_or(f64::INFINITY, |cost| cost.ns_per_ms)
}

/// The settings that reach the target; what the reference does not tell is not reached.
fn reaching(report: &Report, target: f64) -> Vec<usize> {
    let reached = |i: &usize| report.settings[*i].error.is_some_and(|error| error <= target);
    (0..report.settings.len()).filter(|i| reached(i) && cost_of(report, *i).is_finite()).collect()
}

/// Another communication step at which a setting reaches the target for less than half of the cost of the chosen one.
fn saving(report: &Report, target: f64, chosen: usize) -> Option<usize> {
    let step = |i: usize| report.settings[i].communication_step;
    reaching(report, target)
        .into_iter()
        .filter(|i| step(*i) != step(chosen) && cost_of(report, *i) < 0.5 * cost_of(report, chosen))
        .min_by(|i, j| cost_of(report, *i).total_cmp(&cost_of(report, *j)))
}

/// The saving of the other of two settings, in words.
fn cheaper(report: &Report, [chosen, other]: [usize; 2]) -> String {
    let row = &report.settings[other];
    let [this, that] = [words(&report.settings[chosen]), words(row)];
    let setting = if this == that { String::new() } else { format!(" with {that}") };
    let (step, cost) = (time(row.communication_step), number(cost_of(report, other)));
    format!("; at communication steps of {step}{setting}, {cost} ns per ms are enough")
}

/// The cheapest setting that reaches the target, at the default communication step if one does there and no inputs move.
fn choose(report: &Report, target: f64) -> Option<usize> {
    let cost = |i: usize| cost_of(report, i);
    let good = reaching(report, target);
    let usual = |i: &usize| (report.settings[*i].communication_step / report.experiment.step - 1.0).abs() < 1e-9;
    let mut candidates: Vec<usize> = good.iter().copied().filter(usual).collect();
    // Where inputs move, the communication step is a dial as well.
    if candidates.is_empty() || report.experiment.run_up.is_some() {
        candidates = good;
    }
    let cheapest = candidates.iter().map(|i| cost(*i)).fold(f64::INFINITY, f64::min);
    candidates.retain(|i| cost(*i) <= SAME_COST * cheapest);
    candidates.into_iter().min_by(|i, j| {
        let error = |i: &usize| report.settings[*i].error.unwrap_or(f64::INFINITY);
        error(i).total_cmp(&error(j))
    })
}

fn for_target(report: &Report, target: f64) -> Advice {
    let changing = |f: &&Feature| f.change.is_some_and(|change| change > target && change > f.known_to);
    let spare: Vec<&Feature> = report
        .features
        .iter()
        .filter(|f| f.change.is_some_and(|change| change <= target) && f.cost_ratio.is_some_and(|ratio| ratio < 1.0))
        .collect();
    let chosen = choose(report, target);
    let goal = number(target);
    let mut sentence = match chosen {
        None if target < report.reference.floor => format!(
            "For {goal} no advice is possible: the reference itself is known to {} only",
            number(report.reference.floor)
        ),
        None => {
            let best = report.settings.iter().filter_map(|row| row.error).fold(f64::INFINITY, f64::min);
            format!("For {goal} there is no setting; the smallest error is {}", bounded(best, report.reference.floor))
        }
        Some(i) => {
            let row = &report.settings[i];
            let cost = row.cost.map_or(f64::NAN, |cost| cost.ns_per_ms);
            format!(
                "For {goal} use {}: {} ns per ms of machine time at communication steps of {}, with an error of {}",
                words(row),
                number(cost),
                time(row.communication_step),
                match (row.error, &row.worst) {
                    (Some(error), Some(output)) => format!("{} ({output})", number(error)),
                    _ => format!("less than {}, the uncertainty of the reference", number(row.known_to)),
                },
            ) + &saving(report, target, i).map_or(String::new(), |other| cheaper(report, [i, other]))
        }
    };
    if !spare.is_empty() {
        let list: Vec<String> = spare
            .iter()
            .map(|f| {
                format!(
                    "{} ({}, {} ns per ms)",
                    f.feature,
                    f.instead,
                    f.cost.map_or("–".into(), |c| number(c.ns_per_ms))
                )
            })
            .collect();
        sentence += &format!("; {} may be left out", list.join(", "));
    }
    let mut kept: Vec<&Feature> = report.features.iter().filter(changing).collect();
    kept.sort_by(|f, g| f.change.unwrap_or(0.0).total_cmp(&g.change.unwrap_or(0.0)));
    if !kept.is_empty() {
        let told: Vec<String> = kept.iter().take(MOST_TOLD).map(|f| loss(f)).collect();
        sentence += &format!("; leaving out {}", told.join(", "));
        if kept.len() > MOST_TOLD {
            sentence += ", other features more";
        }
    }
    sentence.push('.');
    Advice {
        target,
        setting: chosen,
        may_be_left_out: spare.iter().map(|f| format!("{}: {}", f.feature, f.instead)).collect(),
        sentence,
    }
}

/// "damping would change q by 12 %"
fn loss(feature: &Feature) -> String {
    let output = feature.worst.as_deref().unwrap_or("nothing");
    format!("{} would change {output} by {}", feature.feature, share(feature.change.unwrap_or(0.0)))
}

/// The values of the dials that are not left to the default.
pub fn dials(row: &Row) -> String {
    let tolerance = row.tolerance.filter(|value| *value > 0.0);
    let size = row.step_size.filter(|value| *value > 0.0);
    let parts = [
        row.method.as_ref().map(|method| format!("solver.method = {method}")),
        tolerance.map(|value| format!("solver.tolerance = {}", number(value))),
        size.map(|value| format!("solver.step_size = {} s", number(value))),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// The values to set, in words.
pub fn words(row: &Row) -> String {
    let dials = dials(row);
    let settings = match (row.is_default(), dials.is_empty()) {
        (true, true) => Some("the default settings".to_owned()),
        (true, false) => Some(format!("{dials}, its default settings")),
        (false, _) => Some(dials),
    };
    let inputs = row.inputs.map(|inputs| match inputs {
        "values" => "values of the inputs alone".to_owned(),
        _ => "input derivatives".to_owned(),
    });
    settings.into_iter().chain(inputs).collect::<Vec<_>>().join(" with ")
}
