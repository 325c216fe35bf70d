//! The findings as a report.

use super::advice::{self, words};
use super::{Cost, Findings, figures};
use crate::report::terminal::shown;
use crate::report::unit::{MS, ONE, PERCENT, RPM, US, Unit};
use crate::report::{Report, Table, Value};
use crate::text::{counted, number, time};

/// CPU time per time of the machine (ns/ms).
const NS_PER_MS: Unit = Unit::new("ns/ms", 1.0);

/// An error or a change, or a bound if it is below the reference's uncertainty.
fn known(value: Option<f64>, known_to: f64) -> Value {
    value.map(|value| if value > known_to { Value::Number(value) } else { Value::AtMost(known_to) }).into()
}

/// A dial, 0 for its default.
fn dial(value: Option<f64>, text: impl Fn(f64) -> String) -> Option<String> {
    value.map(|value| if value == 0.0 { "default".to_owned() } else { text(value) })
}

fn cost(cost: Option<Cost>, of: impl Fn(Cost) -> Option<f64>) -> Option<f64> {
    cost.and_then(of)
}

fn settings(findings: &Findings) -> Table {
    let mut table = Table::of("Settings", &findings.settings)
        .key("settings")
        .column("method", "method", ONE, |row| row.method.clone())
        .column("tolerance", "tolerance", ONE, |row| dial(row.tolerance, number))
        .column("step_size", "internal step", ONE, |row| dial(row.step_size, time))
        .column("inputs", "inputs", ONE, |row| row.inputs)
        .column("communication_step", "communication step", MS, |row| row.communication_step)
        .column("error", "error", ONE, |row| known(row.error, row.known_to))
        .column("output", "of", ONE, |row| row.worst.clone())
        .column("error_estimate", "estimate", ONE, |row| row.error_estimate)
        .column("cost", "cost", NS_PER_MS, |row| cost(row.cost, |c| Some(c.ns_per_ms)))
        .column("start", "start", US, |row| cost(row.cost, |c| Some(1e-6 * c.start_us)))
        .column("steps", "steps", ONE, |row| cost(row.cost, |c| c.steps))
        .column("evaluations", "evaluations", ONE, |row| cost(row.cost, |c| c.evaluations))
        .hidden("known_to", ONE, |row| row.known_to)
        .hidden("fault", ONE, |row| row.fault.clone());
    for output in &findings.outputs {
        table = table.hidden(format!("error_of_{}", output.name), ONE, |row| row.errors.get(&output.name).copied());
    }
    table.into()
}

fn features(findings: &Findings) -> Table {
    let mut table = Table::of("Features that could be left out", &findings.features)
        .key("features")
        .column("without", "without", ONE, |f| &f.feature)
        .column("instead", "instead", ONE, |f| &f.instead)
        .column("change", "largest change", ONE, |f| known(f.change, f.known_to))
        .column("output", "of", ONE, |f| f.worst.clone())
        .column("cost", "cost", NS_PER_MS, |f| cost(f.cost, |c| Some(c.ns_per_ms)))
        .column("cost_ratio", "of the whole", PERCENT, |f| f.cost_ratio)
        .hidden("known_to", ONE, |f| f.known_to)
        .hidden("fault", ONE, |f| f.fault.clone());
    for output in &findings.outputs {
        table = table.hidden(format!("change_of_{}", output.name), ONE, |f| f.changes.get(&output.name).copied());
    }
    table.into()
}

/// Settings and features without result, each with its fault.
fn faults(findings: &Findings) -> Vec<String> {
    let settings = findings.settings.iter().filter_map(|row| Some((words(row), row.fault.as_ref()?)));
    let features = findings.features.iter().filter_map(|f| {
        let name = format!("without {} ({})", f.feature, f.instead);
        Some((name, f.fault.as_ref()?))
    });
    settings.chain(features).map(|(what, fault)| format!("{what}: {fault}")).collect()
}

/// Runs, reference and costs, in sentences.
fn measured(findings: &Findings) -> Vec<String> {
    let (e, r) = (&findings.experiment, &findings.reference);
    // The mean speed of a run-up is half of its last.
    let at_speed = e.stop - e.run_up.map_or(0.0, |[_, ramp]| 0.5 * ramp);
    let turns = e.turn.map_or(String::new(), |turn| format!(", {}", counted(number(at_speed / turn), "turn")));
    let mut lines = vec![format!("Runs of {}{turns}; default communication step {}.", time(e.stop), time(e.step))];
    if let Some([speed, ramp]) = e.run_up {
        lines.push(format!(
            "The inputs follow a run-up from standstill to {} within {}, then keep this speed.",
            shown(speed, &RPM),
            time(ramp)
        ));
    }
    let checks: Vec<String> = r.checks.iter().map(|c| format!("{} {}", c.change, number(c.difference))).collect();
    lines.push(format!(
        "An error is the largest deviation of an output from a reference ({}) over the run, relative to its largest \
         value. The reference changes by: {}.",
        r.settings,
        checks.join(", ")
    ));
    if let (true, Some(t)) = (r.compared_until < e.stop * (1.0 - 1e-9), r.separation) {
        lines.push(format!(
            "Trajectories that differ in the last digit of their parameters part by 0.1 % from {} on.",
            time(t)
        ));
    }
    if !findings.without_effect.is_empty() {
        lines.push(format!(
            "Not listed, because errors and steps equal the default's: {}.",
            findings.without_effect.join("; ")
        ));
    }
    lines.push(
        "Costs are medians of CPU time of doStep and of reading all continuous outputs through the C interface, per \
         millisecond of machine time; start is instantiation and initialisation."
            .to_owned(),
    );
    lines.push("The estimate covers the states. Their differences and derivatives may have larger errors.".to_owned());
    if findings.experiment.run_up.is_some() {
        lines.push(
            "Between communication points inputs follow polynomials, better ones with derivatives. Their deviation from the \
             run-up is part of the errors, but not of the estimate."
                .to_owned(),
        );
    }
    lines
}

impl Findings {
    /// The report.
    pub fn report(&self) -> Report {
        let mut report = Report::new(&self.scene, format!("speed against accuracy ({})", self.model));
        report.verdict = advice::verdict(self);
        report.table(settings(self)).table(features(self)).lines("Without result", faults(self));
        report.explain("Measurement", measured(self));
        report.diagram("work_precision", figures::work_precision(self));
        report.diagram("communication_step", figures::communication_step(self));
        report
    }
}
