//! The report as tables: cells for terminal and page, CSV, JSON.

use super::{Feature, Report, Row};
use crate::drives::Fault;

/// A table of texts.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// One heading per column.
    pub head: Vec<String>,
    /// The cells.
    pub rows: Vec<Vec<String>>,
}

/// "–", where there is nothing to say.
const NONE: &str = "–";

/// Three significant digits, in powers of ten outside of 0.01 … 1e6.
pub fn number(value: f64) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-2..1e6).contains(&rounded.abs()) {
        return rounded.to_string();
    }
    // An error of 3.214e-9 is one of 3.2e-9.
    let short: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    format!("{short:e}")
}

/// A duration with a unit that suits it.
pub fn time(seconds: f64) -> String {
    let (unit, scale) = [("s", 1.0), ("ms", 1e3), ("µs", 1e6), ("ns", 1e9)]
        .into_iter()
        .find(|(_, scale)| (seconds * scale).abs() >= 0.9995)
        .unwrap_or(("ns", 1e9));
    format!("{} {unit}", number(seconds * scale))
}

/// A change relative to the largest value, as people say it.
pub fn share(change: f64) -> String {
    if change >= 10.0 {
        format!("{} times its largest value", number(change))
    } else if change >= 1e-4 {
        format!("{} %", number(100.0 * change))
    } else {
        format!("{} of its largest value", number(change))
    }
}

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
    ("error", |row| row.error.map_or(NONE.into(), number), false),
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
    ("largest change", |f| f.change.map_or(NONE.into(), number), false),
    ("of", |f| f.worst.clone().unwrap_or(NONE.into()), false),
    ("ns per ms", |f| f.cost.map_or(NONE.into(), |cost| number(cost.ns_per_ms)), false),
    ("of the whole", |f| f.cost_ratio.map_or(NONE.into(), |ratio| format!("{} %", (100.0 * ratio).round())), false),
];

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
        row.extend(report.features.iter().map(|f| f.changes.get(&output.name).map_or(NONE.into(), |c| number(*c))));
        row
    });
    Table { rows: rows.collect(), head }
}

/// What went wrong, each with the setting or the feature it belongs to.
pub fn faults(report: &Report) -> Vec<String> {
    let settings = report.settings.iter().filter_map(|row| Some((super::advice::words(row), row.fault.as_ref()?)));
    let features = report.features.iter().filter_map(|f| {
        let name = format!("without {} ({})", f.feature, f.instead);
        Some((name, f.fault.as_ref()?))
    });
    settings.chain(features).map(|(what, fault)| format!("{what}: {fault}")).collect()
}

/// What the errors refer to, in sentences.
pub fn about(report: &Report) -> Vec<String> {
    let (e, r) = (&report.experiment, &report.reference);
    let turns = e.turn.map_or(String::new(), |turn| format!(", {} turns", number(e.stop / turn)));
    let mut lines = vec![format!("Runs of {}{turns}; default communication step {}.", time(e.stop), time(e.step))];
    if let Some([speed, ramp]) = e.run_up {
        lines.push(format!(
            "The inputs follow a run-up from standstill to {} rad/s within {} and that speed after it.",
            number(speed),
            time(ramp)
        ));
    }
    let checks: Vec<String> = r.checks.iter().map(|c| format!("{} {}", c.change, number(c.difference))).collect();
    lines.push(format!(
        "Errors are the largest of an output over the run, relative to its largest value, against a reference ({}). \
         The reference is known to {}: it changes by {}.",
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
         millisecond of machine time; start is instantiation and initialisation."
            .to_owned(),
    );
    lines
}

impl Table {
    /// The table in columns for a terminal.
    pub fn text(&self) -> String {
        let width = |i: usize| {
            let cells = self.rows.iter().map(|row| &row[i]).chain([&self.head[i]]);
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.head.len()).map(width).collect();
        let line = |row: &Vec<String>| {
            let cells = row.iter().zip(&widths).map(|(cell, width)| format!("  {cell:<width$}"));
            cells.collect::<String>().trim_end().to_owned() + "\n"
        };
        std::iter::once(&self.head).chain(&self.rows).map(line).collect()
    }
}

/// All settings and features with all numbers, one line each.
///
/// # Errors
/// None in practice: the writer fills memory.
pub fn csv(report: &Report) -> Result<String, Fault> {
    let fault = |e: &dyn std::fmt::Display| Fault(format!("the table cannot be written as CSV: {e}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names: Vec<&str> = report.outputs.iter().map(|output| output.name.as_str()).collect();
    let fixed = [
        "kind",
        "method",
        "tolerance",
        "step_size_s",
        "inputs",
        "without",
        "instead",
        "communication_step_s",
        "error_or_change",
        "output",
        "error_estimate",
        "cost_ns_per_ms",
        "start_us",
        "steps",
        "evaluations",
        "fault",
    ];
    writer.write_record(fixed.iter().chain(&names)).map_err(|e| fault(&e))?;
    let full = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:e}"));
    let text = |value: &Option<String>| value.clone().unwrap_or_default();
    let cost = |cost: Option<super::Cost>| {
        [
            full(cost.map(|c| c.ns_per_ms)),
            full(cost.map(|c| c.start_us)),
            count(cost.and_then(|c| c.steps)).replace(NONE, ""),
            count(cost.and_then(|c| c.evaluations)).replace(NONE, ""),
        ]
    };
    for row in &report.settings {
        let mut record = vec!["setting".to_owned(), text(&row.method), full(row.tolerance), full(row.step_size)];
        record.extend([row.inputs.unwrap_or_default().to_owned(), String::new(), String::new()]);
        record.extend([
            full(Some(row.communication_step)),
            full(row.error),
            text(&row.worst),
            full(row.error_estimate),
        ]);
        record.extend(cost(row.cost));
        record.push(text(&row.fault));
        record.extend(names.iter().map(|name| full(row.errors.get(*name).copied())));
        writer.write_record(&record).map_err(|e| fault(&e))?;
    }
    for feature in &report.features {
        let mut record = vec!["feature".to_owned(), String::new(), String::new(), String::new(), String::new()];
        record.extend([feature.feature.clone(), feature.instead.clone(), full(Some(report.experiment.step))]);
        record.extend([full(feature.change), text(&feature.worst), String::new()]);
        record.extend(cost(feature.cost));
        record.push(text(&feature.fault));
        record.extend(names.iter().map(|name| full(feature.changes.get(*name).copied())));
        writer.write_record(&record).map_err(|e| fault(&e))?;
    }
    let bytes = writer.into_inner().map_err(|e| fault(&e))?;
    String::from_utf8(bytes).map_err(|e| fault(&e))
}

/// The whole report.
///
/// # Errors
/// None in practice: the report holds nothing that JSON has no form for.
pub fn json(report: &Report) -> Result<String, Fault> {
    let text = serde_json::to_string_pretty(report);
    text.map(|text| text + "\n").map_err(|e| Fault(format!("the report cannot be written as JSON: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        let pairs =
            [(0.0, "0"), (1e-6, "1e-6"), (3.214e-9, "3.2e-9"), (512.34, "512"), (0.33333, "0.333"), (2e7, "2e7")];
        for (value, text) in pairs {
            assert_eq!(number(value), text);
        }
        assert_eq!((time(3.3334e-4), time(2.0), time(1e-5)), ("333 µs".into(), "2 s".into(), "10 µs".into()));
        assert_eq!((share(0.123), share(35.0)), ("12.3 %".into(), "35 times its largest value".into()));
        assert_eq!(share(2e-9), "2e-9 of its largest value");
    }
}
