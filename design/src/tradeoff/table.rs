//! The report as tables: cells for terminal and page, CSV, JSON.

use super::{Cost, Feature, Report, Row, bounded};
use crate::text::{self, NONE, Table, counted, number, time};
use camdrive::drives::Fault;
use std::collections::BTreeMap;

fn default_or(value: f64, text: impl Fn(f64) -> String) -> String {
    if value == 0.0 { "default".to_owned() } else { text(value) }
}

/// A column of the settings: its heading, its cell, and whether it is left out where all cells are the same.
type Column<R> = (&'static str, fn(&R) -> String, bool);

const SETTINGS: [Column<Row>; 12] = [
    ("method", |row| row.method.clone().unwrap_or(NONE.into()), true),
    ("tolerance", |row| row.tolerance.map_or(NONE.into(), |value| default_or(value, number)), true),
    ("internal step", |row| row.step_size.map_or(NONE.into(), |value| default_or(value, time)), true),
    ("inputs", |row| row.inputs.unwrap_or(NONE).to_owned(), true),
    ("communication step", |row| time(row.communication_step), false),
    ("error", |row| row.error.map_or(NONE.into(), |error| bounded(error, row.known_to)), false),
    ("of", |row| row.worst.clone().unwrap_or(NONE.into()), false),
    ("estimate", |row| row.error_estimate.map_or(NONE.into(), number), true),
    ("ns per ms", |row| row.cost.map_or(NONE.into(), |cost| number(cost.ns_per_ms)), false),
    ("start [µs]", |row| row.cost.map_or(NONE.into(), |cost| number(cost.start_us)), false),
    ("steps", |row| count(row.cost.and_then(|cost| cost.steps)), false),
    ("evaluations", |row| count(row.cost.and_then(|cost| cost.evaluations)), false),
];

const FEATURES: [Column<Feature>; 6] = [
    ("without", |f| f.feature.clone(), false),
    ("instead", |f| f.instead.clone(), false),
    ("largest change", |f| f.change.map_or(NONE.into(), |change| bounded(change, f.known_to)), false),
    ("of", |f| f.worst.clone().unwrap_or(NONE.into()), false),
    ("ns per ms", |f| f.cost.map_or(NONE.into(), |cost| number(cost.ns_per_ms)), false),
    ("of the whole", |f| f.cost_ratio.map_or(NONE.into(), part), false),
];

/// A part of the cost of the whole drive.
fn part(ratio: f64) -> String {
    if ratio < 0.1 { format!("{:.1} %", 100.0 * ratio) } else { format!("{:.0} %", 100.0 * ratio) }
}

/// A count in full digits.
fn count(value: Option<f64>) -> String {
    value.map_or(NONE.to_owned(), |value| format!("{value:.0}"))
}

fn table<R>(columns: &[Column<R>], rows: &[R]) -> Table {
    let told = |column: &&Column<R>| {
        let (_, cell, may_go) = column;
        !may_go || rows.iter().any(|row| cell(row) != NONE)
    };
    let columns: Vec<&Column<R>> = columns.iter().filter(told).collect();
    Table {
        head: columns.iter().map(|(head, ..)| (*head).to_owned()).collect(),
        rows: rows.iter().map(|row| columns.iter().map(|(_, cell, _)| cell(row)).collect()).collect(),
    }
}

/// The settings; in the place of a result the fault.
pub fn of_settings(report: &Report) -> Table {
    table(&SETTINGS, &report.settings)
}

/// The features.
pub fn of_features(report: &Report) -> Table {
    table(&FEATURES, &report.features)
}

/// The change of each output without each feature: outputs in rows.
pub fn of_changes(report: &Report) -> Table {
    let mut head = vec!["output".to_owned(), "largest value".to_owned()];
    head.extend(report.features.iter().map(|f| format!("without {} ({})", f.feature, f.instead)));
    let rows = report.outputs.iter().map(|output| {
        let mut row = vec![output.name.clone(), format!("{} {}", number(output.largest), output.unit)];
        row.extend(
            report
                .features
                .iter()
                .map(|f| f.changes.get(&output.name).map_or(NONE.into(), |c| bounded(*c, f.known_to))),
        );
        row
    });
    Table { rows: rows.collect(), head }
}

/// Faults, each with its setting or feature.
pub fn faults(report: &Report) -> Vec<String> {
    let settings = report.settings.iter().filter_map(|row| Some((super::advice::words(row), row.fault.as_ref()?)));
    let features = report.features.iter().filter_map(|f| {
        let name = format!("without {} ({})", f.feature, f.instead);
        Some((name, f.fault.as_ref()?))
    });
    settings.chain(features).map(|(what, fault)| format!("{what}: {fault}")).collect()
}

/// The reference of the errors, in sentences.
pub fn about(report: &Report) -> Vec<String> {
    let (e, r) = (&report.experiment, &report.reference);
    // The mean speed of a run-up is half of its last.
    let at_speed = e.stop - e.run_up.map_or(0.0, |[_, ramp]| 0.5 * ramp);
    let turns = e.turn.map_or(String::new(), |turn| format!(", {}", counted(number(at_speed / turn), "turn")));
    let mut lines = vec![format!("Runs of {}{turns}; default communication step {}.", time(e.stop), time(e.step))];
    if let Some([speed, ramp]) = e.run_up {
        lines.push(format!(
            "The inputs follow a run-up from standstill to {} rpm within {} and that speed after it.",
            text::rpm(speed),
            time(ramp)
        ));
    }
    let checks: Vec<String> = r.checks.iter().map(|c| format!("{} {}", c.change, number(c.difference))).collect();
    lines.push(format!(
        "Errors are the largest of an output over the run, relative to its largest value, against a reference ({}). \
         The reference is known to {}, so that smaller errors are not known: it changes by {}.",
        r.settings,
        number(r.floor),
        checks.join(", ")
    ));
    if r.compared_until < e.stop * (1.0 - 1e-9) {
        let separation =
            r.separation.map_or(String::new(), |t| format!("; they differ by more than 0.1 % from {} on", time(t)));
        lines.push(format!(
            "The motion is sensitive: trajectories whose parameters differ in the last digit part{separation}. Errors \
             are those of the first {}; changes without a feature are those of the whole run.",
            time(r.compared_until)
        ));
    }
    if !report.without_effect.is_empty() {
        lines.push(format!(
            "Not listed, since errors and steps are those of the default: {}.",
            report.without_effect.join("; ")
        ));
    }
    lines.push(
        "Costs are medians of CPU time of doStep and of reading all continuous outputs through the C interface, per \
         millisecond of machine time; start is instantiation and initialisation. The advice treats costs within 10 % as equal \
         and takes the most accurate of such settings."
            .to_owned(),
    );
    if report.settings.iter().any(|row| row.error_estimate.is_some()) {
        lines.push(
            "The estimate is solver.error_estimate, which is that of the states: outputs that are differences of large numbers \
             or derivatives may have larger errors."
                .to_owned(),
        );
    }
    if report.settings.iter().any(|row| row.inputs.is_some()) {
        lines.push(
            "With values of the inputs alone the drive follows the polynomial that they begin over each communication step, and \
             with derivatives a better one: what these polynomials miss of the run-up is in the errors, but unknown to the \
             estimate."
                .to_owned(),
        );
    }
    lines
}

/// All settings and features with all numbers, one line each; errors and changes equal to `known_to` are that or less.
///
/// # Errors
/// None in practice: the writer fills memory.
pub fn csv(report: &Report) -> Result<String, Fault> {
    let names = || report.outputs.iter().map(|output| &output.name);
    let quoted = |name: &String| if name.contains(',') { format!(",\"{name}\"") } else { format!(",{name}") };
    let head = "kind,method,tolerance,step_size_s,inputs,without,instead,communication_step_s,error_or_change,output,\
                known_to,error_estimate,cost_ns_per_ms,start_us,steps,evaluations,fault";
    let cost = |cost: Option<Cost>| {
        let c = cost.as_ref();
        [c.map(|c| c.ns_per_ms), c.map(|c| c.start_us), c.and_then(|c| c.steps), c.and_then(|c| c.evaluations)]
    };
    let each = |values: &BTreeMap<String, f64>| names().map(|name| values.get(name).copied()).collect::<Vec<_>>();
    let settings = report.settings.iter().map(|row| {
        let dials = (row.method.as_ref(), row.tolerance, row.step_size, row.inputs);
        let error = (row.communication_step, row.error, &row.worst, row.known_to, row.error_estimate);
        ("setting", dials, [None; 2], error, cost(row.cost), &row.fault, each(&row.errors))
    });
    let features = report.features.iter().map(|f| {
        let change = (report.experiment.step, f.change, &f.worst, f.known_to, None);
        (
            "feature",
            (None, None, None, None),
            [Some(&f.feature), Some(&f.instead)],
            change,
            cost(f.cost),
            &f.fault,
            each(&f.changes),
        )
    });
    text::csv(&(head.to_owned() + &names().map(quoted).collect::<String>()), settings.chain(features))
}
