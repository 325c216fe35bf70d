//! The two diagrams of a report.

use super::{Findings, Row};
use crate::plot::{Axis, Diagram, Rule, Series};

/// Legend of the points on the line of the reference's uncertainty, along which the curves run.
const KNOWN: &str = "smaller than the reference's uncertainty";

/// Name of a series: method and way to pass inputs.
fn name(row: &Row) -> String {
    let inputs = match row.inputs {
        Some("values") => Some("values of inputs".to_owned()),
        Some(_) => Some("input derivatives".to_owned()),
        None => None,
    };
    let parts: Vec<String> = row.method.clone().into_iter().chain(inputs).collect();
    if parts.is_empty() { "whole drive".to_owned() } else { parts.join(", ") }
}

/// The rows by name, in the order of their first appearance.
fn grouped<'a>(rows: impl Iterator<Item = &'a Row>, name: impl Fn(&Row) -> String) -> Vec<(String, Vec<&'a Row>)> {
    let mut groups: Vec<(String, Vec<&Row>)> = Vec::new();
    for row in rows {
        let name = name(row);
        match groups.iter_mut().find(|(other, _)| *other == name) {
            Some((_, list)) => list.push(row),
            None => groups.push((name, vec![row])),
        }
    }
    groups
}

/// Cost over error: the settings at the default communication step, the drive without each of its features. If inputs move, the
/// communication step is a dial as well, with a line of its own.
pub fn work_precision(report: &Findings) -> Diagram {
    let at_default_step = |row: &Row| (row.communication_step / report.experiment.step - 1.0).abs() < 1e-9;
    let point = |row: &&Row| Some([row.error?, row.cost?.ns_per_ms]);
    let line = |name: String, rows: &[&Row]| Series::line(name, rows.iter().filter_map(point));
    let mut series = Vec::new();
    for (name, mut rows) in grouped(report.settings.iter(), name) {
        let is_moved = rows.iter().any(|row| row.inputs.is_some());
        if is_moved {
            let mut defaults: Vec<&Row> = rows.iter().copied().filter(|row| row.is_default()).collect();
            defaults.sort_by(|a, b| a.communication_step.total_cmp(&b.communication_step));
            series.push(line(format!("{name}, over the communication step"), &defaults));
        }
        rows.retain(|row| at_default_step(row));
        rows.sort_by(|a, b| a.error.unwrap_or(f64::INFINITY).total_cmp(&b.error.unwrap_or(f64::INFINITY)));
        if !is_moved {
            series.push(line(name, &rows));
        } else if rows.len() > 1 {
            let dial = if rows.iter().any(|row| row.step_size.is_some()) { "internal step" } else { "tolerance" };
            series.push(line(format!("{name}, over the {dial}"), &rows));
        }
    }
    series.extend(report.features.iter().filter_map(|f| {
        let point = [f.change?, f.cost?.ns_per_ms];
        Some(Series::dots(format!("without {} ({})", f.feature, f.instead), [point]))
    }));
    let labels =
        ["Largest error (change) of an output, relative to its largest value [1]", "CPU time per machine time [ns/ms]"];
    let floor = report.reference.floor;
    let mut rules = vec![Rule::Vertical(floor, String::new()), Rule::Key(None, KNOWN.to_owned())];
    // If all settings are on that line and the changes decades away, the picture would be empty: it then shows the cost alone.
    let default = report.settings.iter().find(|row| at_default_step(row)).and_then(|row| row.cost);
    let exact = report.settings.iter().all(|row| row.error.is_none_or(|error| error <= floor));
    if let Some(cost) = default.filter(|_| exact && report.features.iter().any(|f| f.change.is_some())) {
        series.retain(|series| !series.joined);
        let name = format!("whole drive, error {KNOWN}");
        rules = vec![Rule::Horizontal(cost.ns_per_ms, String::new()), Rule::Key(None, name)];
    }
    Diagram::new(format!("Work-precision diagram of {}", report.scene), labels.map(Axis::logarithmic), series, rules)
}

/// Error over communication step, for each setting that was run at several.
pub fn communication_step(report: &Findings) -> Diagram {
    let full_name = |row: &Row| {
        let tolerance = row.tolerance.map(|t| match t {
            0.0 => "default tolerance".to_owned(),
            t => format!("tolerance {}", crate::text::number(t)),
        });
        let size = row.step_size.map(|s| match s {
            0.0 => "default internal step".to_owned(),
            s => format!("internal step {}", crate::text::time(s)),
        });
        [Some(name(row)), tolerance, size].into_iter().flatten().collect::<Vec<_>>().join(", ")
    };
    let groups = grouped(report.settings.iter(), full_name).into_iter().filter(|(_, rows)| rows.len() > 1);
    let series = groups
        .map(|(name, rows)| {
            let point = |row: &&Row| Some([row.communication_step, row.error?]);
            let mut points: Vec<[f64; 2]> = rows.iter().filter_map(point).collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            Series::line(name, points)
        })
        .collect();
    let mut rules = vec![Rule::Horizontal(report.reference.floor, String::new()), Rule::Key(None, KNOWN.to_owned())];
    rules.extend(report.experiment.turn.map(|turn| Rule::Vertical(turn, "one turn".to_owned())));
    let labels = ["Communication step [s]", "Largest error of an output, relative to its largest value [1]"];
    let title = format!("Error of {} over the communication step", report.scene);
    Diagram::new(title, labels.map(Axis::logarithmic), series, rules)
}
