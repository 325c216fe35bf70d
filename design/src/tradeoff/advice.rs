//! The recommended settings, their costs, and the features that may be left out.

use super::{Feature, Findings, Row, bounded};
use crate::report::{Advice as Advised, Claim, Level, Setting, Verdict};
use crate::text::{number, time};
use serde::Serialize;

/// The usual accuracies.
const TARGETS: [f64; 4] = [1e-3, 1e-6, 1e-9, 1e-12];

/// Costs closer than this are the same: then the smaller error decides, and no advice is given. Medians of CPU times repeat to
/// some per cent.
const SAME_COST: f64 = 1.05;

/// The choice for a target accuracy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// The largest admissible error of an output, relative to its largest value.
    pub target: f64,
    /// The row of the setting; None if none reaches the target.
    pub setting: Option<usize>,
    /// The features that may be left out: their change is below the target, and it saves 5 % or more.
    pub may_be_left_out: Vec<String>,
}

/// The choices for all targets.
pub fn of(findings: &Findings) -> Vec<Advice> {
    let spare = |target: f64| spare(findings, target).map(|f| format!("{}: {}", f.feature, f.instead)).collect();
    let of = |target| Advice { target, setting: choose(findings, target), may_be_left_out: spare(target) };
    TARGETS.into_iter().map(of).collect()
}

/// CPU time of a setting (ns per ms).
fn cost_of(findings: &Findings, i: usize) -> f64 {
    findings.settings[i].cost.map_or(f64::INFINITY, |cost| cost.ns_per_ms)
}

/// The settings that reach the target; errors below the reference's uncertainty do not count.
fn reaching(findings: &Findings, target: f64) -> Vec<usize> {
    let reached = |i: &usize| findings.settings[*i].error.is_some_and(|error| error <= target);
    (0..findings.settings.len()).filter(|i| reached(i) && cost_of(findings, *i).is_finite()).collect()
}

/// Another communication step at which a setting reaches the target for less than the cost of the chosen one.
fn saving(findings: &Findings, target: f64, chosen: usize) -> Option<usize> {
    let step = |i: usize| findings.settings[i].communication_step;
    reaching(findings, target)
        .into_iter()
        .filter(|i| step(*i) != step(chosen) && SAME_COST * cost_of(findings, *i) <= cost_of(findings, chosen))
        .min_by(|i, j| cost_of(findings, *i).total_cmp(&cost_of(findings, *j)))
}

/// The cheapest setting that reaches the target, at the default communication step if one does there and no inputs move.
fn choose(findings: &Findings, target: f64) -> Option<usize> {
    let cost = |i: usize| cost_of(findings, i);
    let good = reaching(findings, target);
    let usual = |i: &usize| (findings.settings[*i].communication_step / findings.experiment.step - 1.0).abs() < 1e-9;
    let mut candidates: Vec<usize> = good.iter().copied().filter(usual).collect();
    // If inputs move, the communication step is a dial as well.
    if candidates.is_empty() || findings.experiment.run_up.is_some() {
        candidates = good;
    }
    let cheapest = candidates.iter().map(|i| cost(*i)).fold(f64::INFINITY, f64::min);
    candidates.retain(|i| cost(*i) <= SAME_COST * cheapest);
    let error = |i: &usize| findings.settings[*i].error.unwrap_or(f64::INFINITY);
    // Among equal ones the default, which stands first.
    candidates.into_iter().min_by(|i, j| error(i).total_cmp(&error(j)))
}

/// The features that may be left out for the target and then save time compared with the default and the chosen setting.
fn spare(findings: &Findings, target: f64) -> impl Iterator<Item = &Feature> {
    let chosen = choose(findings, target).map_or(f64::INFINITY, |i| cost_of(findings, i));
    let may = move |f: &&Feature| {
        let saves = f.cost.as_ref().is_some_and(|cost| cost.ns_per_ms * SAME_COST <= chosen);
        saves && f.change.is_some_and(|change| change <= target) && f.cost_ratio.is_some_and(|r| r * SAME_COST <= 1.0)
    };
    findings.features.iter().filter(may)
}

/// The verdict: the default's error and cost, and the savings for each error.
pub fn verdict(findings: &Findings) -> Verdict {
    let mut verdict = Verdict::default();
    let floor = findings.reference.floor;
    let usual = |row: &&Row| (row.communication_step / findings.experiment.step - 1.0).abs() < 1e-9;
    let default = findings.settings.iter().position(|row| row.is_default() && row.error.is_some() && usual(&row));
    if let Some(row) = default.map(|i| &findings.settings[i]) {
        let of = row.worst.as_ref().map_or(String::new(), |output| format!(" ({output})"));
        verdict.result(
            Level::Good,
            format!(
                "With {} at communication steps of {} the error is {}{of}. A ms of machine time costs {} ns.",
                words(row),
                time(row.communication_step),
                bounded(row.error.unwrap_or(f64::NAN), row.known_to).replace('<', "below"),
                number(row.cost.map_or(f64::NAN, |cost| cost.ns_per_ms)),
            ),
        );
    }
    // Targets with the same choice are merged into the strictest.
    let mut told: Vec<(f64, Saving)> = Vec::new();
    for target in TARGETS.into_iter().filter(|target| *target >= floor) {
        for saving in saved(findings, target, default) {
            told.retain(|(_, other)| *other != saving);
            told.push((target, saving));
        }
    }
    for (target, Saving { text, set, step }) in &told {
        let claim = Claim::Error { at_most: *target, step: *step };
        let text = format!("For errors up to {}: {text}.", number(*target));
        verdict.advice(Advised::new(text).set(set.iter().cloned(), claim));
    }
    let all = TARGETS.iter().filter(|target| **target >= floor && choose(findings, **target).is_none());
    if let Some(missed) = all.copied().reduce(f64::max) {
        let best = findings.settings.iter().filter_map(|row| row.error).fold(f64::INFINITY, f64::min);
        verdict.advice(format!(
            "No setting reaches {}; the smallest error is {}.",
            number(missed),
            bounded(best, floor)
        ));
    }
    if told.is_empty() {
        verdict.advice("Keep the default settings: no others save 5 % of the time.");
    }
    verdict
        .certainty(format!("Errors below {} cannot be resolved. Costs are CPU times on this computer.", number(floor)));
    if findings.reference.compared_until < findings.experiment.stop * (1.0 - 1e-9) {
        verdict.certainty(format!(
            "The motion is sensitive. Errors cover the first {}, changes without a feature the whole run.",
            time(findings.reference.compared_until)
        ));
    }
    verdict
}

/// A saving: in words, by the dials that are set, at a communication step (s) if it is not the default one.
#[derive(PartialEq)]
struct Saving {
    text: String,
    set: Vec<Setting>,
    step: Option<f64>,
}

/// The savings for a target compared with the default settings, each at least 5 %.
fn saved(findings: &Findings, target: f64, default: Option<usize>) -> Vec<Saving> {
    let cost = |i: usize| number(cost_of(findings, i));
    let mut parts = Vec::new();
    let chosen = choose(findings, target);
    let usual = default.filter(|i| findings.settings[*i].error.is_some_and(|error| error <= target));
    // Times scatter, evaluations do not: at the same points a setting with more of them saves nothing.
    let works_less = |i: usize, usual: usize| {
        let [own, other] = [i, usual].map(|i| &findings.settings[i]);
        let evaluations = |row: &Row| row.cost.and_then(|cost| cost.evaluations);
        own.communication_step != other.communication_step
            || evaluations(own).zip(evaluations(other)).is_none_or(|(own, other)| own < other)
    };
    let saves =
        |i: usize, usual: usize| cost_of(findings, i) * SAME_COST <= cost_of(findings, usual) && works_less(i, usual);
    if let Some(i) = chosen.filter(|i| usual.is_none_or(|usual| saves(*i, usual))) {
        let row = &findings.settings[i];
        let step =
            default.map(|i| findings.settings[i].communication_step).filter(|step| *step != row.communication_step);
        let at = step.map_or(String::new(), |_| format!(" at communication steps of {}", time(row.communication_step)));
        let text = format!("{}{at}, {} ns per ms", words(row), cost(i));
        parts.push(Saving { text, set: settings(row), step: step.map(|_| row.communication_step) });
    }
    if let Some(other) = chosen.and_then(|i| saving(findings, target, i)) {
        let row = &findings.settings[other];
        let step = time(row.communication_step);
        let setting = if row.is_default() { String::new() } else { format!(" with {}", words(row)) };
        let text = format!("at communication steps of {step}{setting}, {} ns per ms are enough", cost(other));
        parts.push(Saving { text, set: settings(row), step: Some(row.communication_step) });
    }
    let spare: Vec<String> = spare(findings, target)
        .map(|f| {
            format!("{} ({}, {} ns per ms)", f.feature, f.instead, number(f.cost.map_or(f64::NAN, |c| c.ns_per_ms)))
        })
        .collect();
    if !spare.is_empty() {
        let text = format!("{} may be left out", spare.join(", "));
        parts.push(Saving { text, set: Vec::new(), step: None });
    }
    parts
}

/// The dials of a row as a scene sets them.
fn settings(row: &Row) -> Vec<Setting> {
    let number = |key: &str, value: Option<f64>| Some(Setting::new(key, value?));
    let method = row.method.as_ref().map(|method| Setting::new("solver.method", method.as_str()));
    let numbers = [("solver.tolerance", row.tolerance), ("solver.step_size", row.step_size)];
    let numbers = numbers.into_iter().filter_map(|(key, value)| number(key, value));
    method.into_iter().chain(numbers).collect()
}

/// The values of the dials that are not at their default.
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
        (true, false) => Some(format!("{dials} and its default settings")),
        (false, _) => Some(dials),
    };
    let inputs = row.inputs.map(|inputs| match inputs {
        "values" => "values of the inputs alone".to_owned(),
        _ => "input derivatives".to_owned(),
    });
    settings.into_iter().chain(inputs).collect::<Vec<_>>().join(" with ")
}
