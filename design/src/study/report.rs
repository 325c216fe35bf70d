//! The results of the runs of a study.

use super::figures::{self, Space};
use crate::report::terminal::{among, range, shown};
use crate::report::unit::{ONE, Unit};
use crate::report::{Level, Report, Table, Value, Verdict};
use crate::text::counted;
use serde::Serialize;
use std::collections::BTreeMap;

pub use super::figures::Column;

/// More quantities than a table can be read with; they are in the store.
const MOST_QUANTITIES: usize = 8;

/// A run whose FMU ended the simulation before its window did.
const ENDED: &str = "ended early";

/// A study and its runs that are there.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Findings {
    /// Name of the scene or the system.
    #[serde(skip)]
    pub name: String,
    /// Whether one drive is measured by its motion, not by the outputs of coupled FMUs at communication points.
    #[serde(skip)]
    is_drive: bool,
    #[serde(skip)]
    space: Space,
    rows: u64,
    ok: u64,
    refused: u64,
    failed: u64,
    /// Parts that are not there.
    pub missing_parts: u64,
    measures: Vec<Measured>,
    columns: Vec<Column>,
    /// The runs that diagrams show: their cells in the order of the columns.
    #[serde(skip)]
    shown: Vec<Vec<Value>>,
    /// The first run that was refused, that failed, that ended before its window did, and why.
    #[serde(skip)]
    first: BTreeMap<String, (usize, String)>,
}

/// A measure over the runs that are ok.
#[derive(Clone, Debug, Default, Serialize)]
struct Measured {
    measure: String,
    least: Option<f64>,
    mean: Option<f64>,
    largest: Option<f64>,
    /// The runs with the least and the largest value.
    runs: Option<[usize; 2]>,
    #[serde(skip)]
    unit: String,
    /// The numbers of runs below and above 0.
    #[serde(skip)]
    signs: [u64; 2],
    /// How these runs differ from others.
    #[serde(skip)]
    varied: [Vec<Value>; 2],
}

impl Measured {
    /// In how many runs a contact opens: gaps and impacts are then above 0, the least force of a cam below 0.
    fn opened(&self) -> String {
        match (self.least, self.largest, self.signs) {
            (Some(0.0), _, [_, above]) => format!("; above 0 in {}", counted(above, "run")),
            (_, Some(0.0..), [below, _]) if self.measure.starts_with("min ") => {
                format!("; below 0 in {}", counted(below, "run"))
            }
            _ => String::new(),
        }
    }
}

impl Findings {
    /// Of a study, without runs.
    pub fn new(name: &str, is_drive: bool, space: Space, rows: u64, columns: Vec<Column>) -> Self {
        let measured = |Column { name, unit, .. }: &Column| Measured {
            measure: name.clone(),
            unit: unit.clone(),
            ..Measured::default()
        };
        let measures = columns.iter().filter(|column| column.role == "measured").map(measured).collect();
        Findings { name: name.to_owned(), is_drive, space, rows, measures, columns, ..Findings::default() }
    }

    /// Adds a run behind those that were added: its cells in the order of the columns.
    pub fn add(&mut self, cells: &[Value]) {
        let [Value::Number(run), values @ .., Value::Text(status), message] = cells else { return };
        let run = *run as usize;
        if (run as u64).is_multiple_of(self.space.every(self.rows)) {
            self.shown.push(cells.to_vec());
        }
        match &**status {
            "ok" => self.ok += 1,
            "refused" => self.refused += 1,
            _ => self.failed += 1,
        }
        if let Value::Text(message) = message {
            let kind = if status == "ok" { ENDED } else { status };
            self.first.entry(kind.to_owned()).or_insert_with(|| (run, message.clone()));
        }
        let (varied, measured) = values.split_at(values.len() - self.measures.len().min(values.len()));
        for (of, value) in self.measures.iter_mut().zip(measured) {
            let Value::Number(value) = *value else { continue };
            let is_new = match (of.least, of.largest) {
                (Some(least), Some(largest)) => [value < least, value > largest],
                _ => [true; 2],
            };
            let runs = of.runs.get_or_insert([run; 2]);
            let ends = [&mut of.least, &mut of.largest].into_iter().enumerate();
            for (end, extreme) in ends.filter(|(end, _)| is_new[*end]) {
                (*extreme, runs[end], of.varied[end]) = (Some(value), run, varied.to_vec());
            }
            of.signs[0] += u64::from(value < 0.0);
            of.signs[1] += u64::from(value > 0.0);
            let mean = of.mean.unwrap_or(0.0);
            of.mean = Some(mean + (value - mean) / self.ok as f64);
        }
    }

    /// True if a point of a diagram has the values of all that varies.
    pub fn is_map(&self) -> bool {
        self.space.grid().is_some_and(|axes| axes < 3)
    }

    /// The results of the variants.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        let Findings { rows, ok, refused, failed, missing_parts, .. } = self;
        let there = ok + refused + failed;
        let level = match (*ok, refused + failed) {
            (0, 1..) => Level::Bad,
            (_, 0) if !self.first.contains_key(ENDED) => Level::Good,
            _ => Level::Mind,
        };
        let of = if there < *rows { format!(" of {rows}") } else { String::new() };
        verdict.result(level, format!("{}{of}: {ok} ok, {refused} refused, {failed} failed.", counted(there, "run")));
        for (status, (run, message)) in &self.first {
            verdict.result(level, format!("First {status}: run {run}: {}.", message.trim_end_matches('.')));
        }
        for of in &self.measures {
            let (Some(least), Some(mean), Some(largest), Some([low, high])) = (of.least, of.mean, of.largest, of.runs)
            else {
                continue;
            };
            let unit = Unit::of(&of.unit);
            let said = match low == high {
                true => format!("{}: {} in each run.", of.measure, shown(least, &unit)),
                false => {
                    let (range, mean) = (range([least, largest], &unit), among(mean, [least, largest], &unit));
                    format!("{}: {range} (runs {low} and {high}), {mean} on average{}.", of.measure, of.opened())
                }
            };
            verdict.result(level, said);
        }
        if *missing_parts > 0 {
            verdict.result(Level::Mind, format!("{} not there yet.", counted(*missing_parts, "part")));
            verdict.advice("`camdrive study` with --resume computes what is missing.");
        }
        let sure = match self.is_drive {
            true => {
                "Runs are also measured between communication points, so that peaks and passages between them count."
            }
            false => {
                "Between communication points outputs are polynomials of what the FMUs tell there: an impact within a \
                 step is seen at its end."
            }
        };
        verdict.certainty(sure);
        verdict
    }

    /// The report.
    pub fn report(&self) -> Report {
        let mut report = Report::new(&self.name, format!("study of {}", counted(self.rows, "variant")));
        report.verdict = self.verdict();
        for (key, diagram) in figures::of(&self.columns, &self.space, self.rows, &self.shown) {
            report.diagram(&key, diagram);
        }
        let varied: Vec<&Column> = self.columns.iter().filter(|column| column.role == "varied").collect();
        if varied.len() > MOST_QUANTITIES {
            report.lines("Variants", [format!("The store has all {} varied quantities.", varied.len())]);
            return report;
        }
        let of_measure = |of: &'_ Measured| -> Vec<_> {
            let runs = of.runs.filter(|[low, high]| low != high).into_iter().flatten();
            let ends = ["least", "largest"].map(|end| format!("{end} {}", of.measure));
            ends.into_iter().zip(runs).zip(of.varied.clone()).collect()
        };
        let rows: Vec<((String, usize), Vec<Value>)> = self.measures.iter().flat_map(of_measure).collect();
        let mut table = Table::of("Variants", &rows)
            .column("extreme", "with the", ONE, |((end, _), _)| end)
            .column("run", "run", ONE, |((_, run), _)| *run)
            .digits(15);
        for (i, of) in varied.iter().enumerate() {
            table = table
                .column("", &of.name, Unit::of(&of.unit), move |(_, varied)| varied.get(i).map(|cell| of.worded(cell)));
        }
        report.table(table);
        report
    }
}
