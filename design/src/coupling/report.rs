//! The errors of a coupled system as a report: which step suits which master.

use super::study::{ACCURACIES, Findings, Output, Row, SURE, Way};
use crate::plot::{Axis, Diagram, Rule, Series};
use crate::report::rounding::Rounding;
use crate::report::terminal::shown;
use crate::report::unit::{MS, ONE};
use crate::report::{Advice, Claim, Level, Report, Setting, Table, Value, Verdict};
use crate::text::{number, share, time, time_within};

/// Significant digits of steps, which are multiples of the file's.
const FINE: usize = 6;

/// An exchange, and its number of repetitions.
pub fn name(exchange: &str, repeats: u32) -> String {
    match repeats {
        0 => exchange.to_owned(),
        1 => format!("{exchange}, repeated once"),
        _ => format!("{exchange}, repeated {repeats} times"),
    }
}

impl Findings {
    /// The steps that suit each master.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        let accuracy = share(ACCURACIES[0]);
        let ways = || self.ways.iter().filter(|way| !way.master.is_empty());
        let known = number(self.known_to);
        if self.known_to > SURE * ACCURACIES[0] {
            let known = format!("the reference is accurate to {known} only");
            verdict.result(Level::Mind, format!("No step can be named for errors of {accuracy}: {known}."));
        } else {
            let least = self.rows.iter().map(|row| row.step).fold(f64::INFINITY, f64::min);
            for way in ways() {
                let found = match (way.steps[0], &way.fault) {
                    (Some(step), _) => format!("errors stay within {accuracy} at steps up to {}", time_within(step)),
                    (None, None) => format!("no step from {} on keeps errors within {accuracy}", time(least)),
                    (None, Some(_)) => "coupling fails, see below".to_owned(),
                };
                let fits = way.steps[0].is_some_and(|step| self.step <= step);
                let level = if fits { Level::Good } else { Level::Mind };
                verdict.result(level, format!("With {} {found}.", way.master));
                if let Some(step) = way.steps[0].filter(|_| !fits) {
                    let (own, step) = (shown(self.step, &MS), Setting::at_most("step", step, &MS, FINE));
                    let text = format!(
                        "The file's step of {own} is too long with {}. Take at most {}.",
                        way.master, step.value
                    );
                    let exchange = Setting::new("exchange", &*way.exchange);
                    // Without this setting `camdrive run` may repeat interpolated steps.
                    let repeated = way.repeats > 0 || way.exchange == "interpolated";
                    let repeat = repeated.then(|| Setting::new("repeat", way.repeats as usize));
                    let claim = Claim::Error { at_most: ACCURACIES[0], step: None };
                    verdict.advice(Advice::new(text).set([step, exchange].into_iter().chain(repeat), claim));
                }
            }
        }
        if let Some(fmu) = &self.fmu {
            verdict.advice(format!("The one FMU {fmu} of `camdrive system --study` needs no coupling."));
        }
        verdict.certainty(format!("Errors are relative to {}, which is accurate to {known}.", self.reference));
        verdict
    }

    /// The report.
    pub fn report(&self) -> Report {
        let mut report = Report::new(&self.system, "communication steps");
        report.verdict = self.verdict();
        let mut faults: Vec<String> = self.ways.iter().filter_map(|way| way.fault.clone()).collect();
        faults.dedup();
        report.table(self.of_ways()).lines("Not coupled", faults).table(self.of_outputs());
        let (spacing, stop) = (time(self.spacing), time(self.stop));
        let measured = format!(
            "An error is the largest of an output at the multiples of {spacing} up to {stop}, relative to its largest value. The \
             order compares a step with its half."
        );
        report.explain("Measurement", [measured]).explain_table(self.of_errors()).diagram("", self.diagram());
        report
    }

    /// The ways with their admissible steps.
    fn of_ways(&self) -> Table {
        let [first, second] = ACCURACIES.map(|accuracy| format!("{} up to", share(accuracy)));
        let stable = |way: &Way| match (&way.fault, way.stable) {
            (Some(_), _) => Value::Empty,
            (None, stable) => stable.map_or("any".into(), Value::Number),
        };
        Table::of("Ways to couple", &self.ways)
            .column("exchange", "exchange", ONE, |way| name(&way.exchange, way.repeats))
            .column("master", "master", ONE, |way| &way.master)
            .column("stable", "stable up to", MS, stable)
            .rounded(Rounding::Inward)
            .column("first", first, MS, |way| way.steps[0])
            .rounded(Rounding::Inward)
            .column("second", second, MS, |way| way.steps[1])
            .rounded(Rounding::Inward)
            .into()
    }

    /// The errors over the steps.
    fn of_errors(&self) -> Table {
        let error = |row: &Row| row.error.map_or("unstable".into(), Value::Number);
        Table::of("Errors", &self.rows)
            .column("exchange", "exchange", ONE, |row| name(&row.exchange, row.repeats))
            .column("step", "step", MS, |row| row.step)
            .column("order", "order", ONE, |row| row.order)
            .digits(2)
            .column("residual", "work mismatch", ONE, |row| row.residual)
            .column("error", "error", ONE, error)
            .column("worst", "of", ONE, |row| row.worst.as_ref().or(row.unstable.as_ref()))
            .into()
    }

    /// The error of each output, for the file.
    fn of_outputs(&self) -> Table {
        let of = |row| self.outputs.iter().enumerate().map(move |(o, output)| (row, o, output));
        let all: Vec<(&Row, usize, &Output)> = self.rows.iter().flat_map(of).collect();
        Table::file("", &all)
            .hidden("exchange", ONE, |(row, ..)| &row.exchange)
            .hidden("repeats", ONE, |(row, ..)| row.repeats as usize)
            .hidden("step", MS, |(row, ..)| row.step)
            .hidden("output", ONE, |(.., output)| &output.name)
            .hidden("error", ONE, |(row, o, _)| row.errors[*o])
            .into()
    }

    /// Error over step.
    fn diagram(&self) -> Diagram {
        let series = self.ways.iter().enumerate().filter(|(_, way)| way.fault.is_none()).map(|(i, way)| {
            let rows = self.rows.iter().filter(|row| row.way == i);
            let points = rows.filter_map(|row| Some([row.step * MS.factor, row.error?]));
            Series::line(name(&way.exchange, way.repeats), points)
        });
        let mut rules: Vec<Rule> = ACCURACIES.map(|accuracy| Rule::Horizontal(accuracy, share(accuracy))).into();
        rules.push(Rule::Horizontal(self.known_to, "reference".to_owned()));
        let labels = ["Communication step [ms]", "Largest error of an output, relative to its largest value [1]"];
        let title = format!("Error of {} over the communication step", self.system);
        Diagram::new(title, labels.map(Axis::logarithmic), series.collect(), rules)
    }
}
