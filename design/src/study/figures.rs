//! A diagram for each measure: a line over one axis, a map over two, points where quantities vary together or more of them.

use crate::plot::map::{Map, REFUSED};
use crate::plot::{Axis, Diagram, Series};
use crate::report::{Unit, Value};
use serde::{Deserialize, Serialize};

/// A column of the store.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// `varied`, `measured`, or `run`: number, status and message of the run.
    pub role: String,
    /// Empty without one.
    pub unit: String,
    /// What it is.
    pub meaning: String,
}

/// Runs in a diagram of points, and cells of a map; of more runs a diagram has every n-th.
const POINTS: u64 = 500;
const CELLS: u64 = 20_000;

/// An axis is logarithmic from this ratio of its ends on, the colours of a map from that.
const RATIO: f64 = 5.0;
const RATIO_OF_COLOURS: f64 = 1000.0;

/// The space of the variants.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct Space {
    /// The quantities of each axis.
    pub axes: Vec<Vec<String>>,
    /// Whether the last of them has samples.
    pub sampled: bool,
}

impl Space {
    /// The number of axes, where each has one quantity and none has samples.
    pub(super) fn grid(&self) -> Option<usize> {
        (!self.sampled && self.axes.iter().all(|axis| axis.len() == 1)).then_some(self.axes.len())
    }

    /// A diagram shows one of so many runs.
    pub fn every(&self, rows: u64) -> u64 {
        let most = if matches!(self.grid(), Some(1 | 2)) { CELLS } else { POINTS };
        rows.div_ceil(most).max(1)
    }
}

impl Column {
    /// A cell for people: enumerations say what their numbers mean at the end of the meaning, ": 1 at_rest, 2 given".
    pub fn worded(&self, cell: &Value) -> Value {
        let Value::Number(number) = cell else { return cell.clone() };
        let start = format!("{number} ");
        let items = self.meaning.rsplit_once(": 1 ").map(|(_, rest)| format!("1 {rest}"));
        let item = |items: String| items.split(", ").find_map(|item| item.strip_prefix(&start)).map(Value::from);
        items.and_then(item).unwrap_or(Value::Number(*number))
    }
}

/// A quantity that varies or is measured, over the runs that a diagram shows; NaN where a run has no value.
struct Quantity {
    axis: Axis,
    values: Vec<f64>,
}

impl Quantity {
    /// Words count in the order in which they come first.
    fn of(column: &Column, cells: impl Iterator<Item = Value>) -> Quantity {
        let (unit, mut words) = (Unit::of(&column.unit), Vec::new());
        let values = cells.map(|cell| match column.worded(&cell) {
            Value::Number(value) => unit.factor * value,
            Value::Text(word) => {
                let place = words.iter().position(|other| *other == word);
                place.unwrap_or_else(|| {
                    words.push(word);
                    words.len() - 1
                }) as f64
                    + 1.0
            }
            _ => f64::NAN,
        });
        let values: Vec<f64> = values.collect();
        let named: Vec<String> = words.iter().enumerate().map(|(i, word)| format!("{} {word}", i + 1)).collect();
        let label = match (&named[..], &*unit.name) {
            ([], "") => column.name.clone(),
            ([], unit) => format!("{} [{unit}]", column.name),
            (named, _) => format!("{}: {}", column.name, named.join(", ")),
        };
        let is_logarithmic = is_logarithmic(&rising(&values));
        let axis = if is_logarithmic { Axis::logarithmic(&label) } else { Axis::linear(&label) };
        Quantity { axis, values }
    }

    /// The correlation with another one over the runs in which both have values.
    fn correlation(&self, other: &Quantity) -> f64 {
        let pairs = || self.values.iter().zip(&other.values).filter(|(x, y)| x.is_finite() && y.is_finite());
        let count = pairs().count() as f64;
        let [x0, y0] = pairs().fold([0.0; 2], |[a, b], (x, y)| [a + x / count, b + y / count]);
        let mean = |of: &dyn Fn(f64, f64) -> f64| pairs().map(|(x, y)| of(x - x0, y - y0)).sum::<f64>();
        let of = mean(&|x, y| x * y) / (mean(&|x, _| x * x) * mean(&|_, y| y * y)).sqrt();
        if of.is_finite() { of } else { 0.0 }
    }
}

/// The different values.
fn rising(values: &[f64]) -> Vec<f64> {
    let mut all: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// Whether the middle of rising values is nearer to the geometric mean of their ends than to their mean.
fn is_logarithmic(rising: &[f64]) -> bool {
    let (Some(low), Some(high)) = (rising.first(), rising.last()) else { return false };
    let middle = rising[rising.len() / 2];
    *low > 0.0
        && *high > RATIO * low
        && (middle / (low * high).sqrt()).ln().abs() < (2.0 * middle / (low + high)).ln().abs()
}

/// For each measure that has values its key and its diagram over these runs of so many, with their cells in the order of the columns.
pub fn of(columns: &[Column], space: &Space, rows: u64, runs: &[Vec<Value>]) -> Vec<(String, Diagram)> {
    let quantity = |i: usize| Quantity::of(&columns[i], runs.iter().map(|cells| cells[i].clone()));
    let of_role = |role: &str| -> Vec<usize> { (0..columns.len()).filter(|i| columns[*i].role == role).collect() };
    let varied: Vec<Quantity> =
        of_role("varied").into_iter().map(quantity).filter(|x| rising(&x.values).len() > 1).collect();
    let every = space.every(rows);
    let diagram = |i: usize| {
        let (name, measured) = (&columns[i].name, quantity(i));
        if rising(&measured.values).is_empty() {
            return None;
        }
        let diagram = match (space.grid(), &varied[..]) {
            (_, []) => return None,
            (Some(1), [x]) => over(name.clone(), x, measured, Some((&quantity(0), every))),
            (Some(2), [x, y]) if every == 1 => map(name, [x, y], &measured),
            (_, all) => points(name, all, measured, every),
        };
        Some((i.to_string(), diagram))
    };
    of_role("measured").into_iter().filter_map(diagram).collect()
}

/// Values over a quantity; runs without value stand at the lower edge. A line joins the runs whose numbers are so far apart.
fn over(title: String, x: &Quantity, y: Quantity, line: Option<(&Quantity, u64)>) -> Diagram {
    let least = y.values.iter().copied().fold(f64::INFINITY, f64::min);
    let mut runs: Vec<[f64; 2]> = x.values.iter().zip(&y.values).map(|(x, y)| [*x, *y]).collect();
    let without: Vec<[f64; 2]> = runs.iter().filter(|run| run[1].is_nan()).map(|[x, _]| [*x, least]).collect();
    if let Some((numbers, every)) = line {
        let mut order: Vec<usize> = (0..runs.len()).collect();
        order.sort_by(|a, b| x.values[*a].total_cmp(&x.values[*b]));
        let is_next = |pair: &[usize]| (numbers.values[pair[0]] - numbers.values[pair[1]]).abs() <= every as f64;
        let parts =
            order.chunk_by(|a, b| is_next(&[*a, *b])).map(|part| part.iter().map(|i| runs[*i]).collect::<Vec<_>>());
        runs = parts.collect::<Vec<_>>().join(&[f64::NAN; 2]);
    }
    let mut series = vec![Series { joined: line.is_some(), ..Series::dots("", runs) }];
    if !without.is_empty() {
        series.push(Series::dots(REFUSED, without));
    }
    Diagram::new(title, [x.axis.clone(), Axis::linear(&y.axis.label)], series, Vec::new())
}

/// Values over the quantity that they follow most.
fn points(name: &str, varied: &[Quantity], measured: Quantity, every: u64) -> Diagram {
    let size = |x: &&Quantity| x.correlation(&measured).abs();
    let x = varied.iter().fold(&varied[0], |most, x| if size(&x) > size(&most) { x } else { most });
    let of = x.axis.label.split([' ', ':']).next().unwrap_or_default();
    let most = match varied.len() {
        1 => String::new(),
        _ => {
            format!(", the quantity with the strongest correlation ({:.2})", x.correlation(&measured)).replace('-', "−")
        }
    };
    let part = if every > 1 { format!("; one run of {every}") } else { String::new() };
    over(format!("{name} over {of}{most}{part}"), x, measured, None)
}

fn map(name: &str, [x, y]: [&Quantity; 2], measured: &Quantity) -> Diagram {
    let at = [x, y].map(|of| rising(&of.values));
    let mut cells = vec![None; at[0].len() * at[1].len()];
    for ((a, b), value) in x.values.iter().zip(&y.values).zip(&measured.values) {
        let place = |at: &[f64], value: f64| at.partition_point(|other| *other < value);
        cells[place(&at[1], *b) * at[0].len() + place(&at[0], *a)] = Some(*value);
    }
    let values = rising(&measured.values);
    let label = &measured.axis.label;
    let spans = values[0] > 0.0 && values[values.len() - 1] > RATIO_OF_COLOURS * values[0];
    let scale = if spans { Axis::logarithmic(label) } else { Axis::linear(label) };
    let map = Map { scale, at, cells };
    let (axes, rules) = (map.axes([x.axis.clone(), y.axis.clone()]), map.keys());
    Diagram { map: Some(map), ..Diagram::new(name, axes, Vec::new(), rules) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::Picture;
    use crate::study::report::Findings;

    /// The diagram of `force` = 2 m + w over these runs (m, w); at m = 3 a run is refused.
    fn diagram(axes: &[&[&str]], sampled: bool, runs: &[[f64; 2]]) -> Diagram {
        let column = |(name, role, unit): (&str, &str, &str)| Column {
            name: name.to_owned(),
            role: role.to_owned(),
            unit: unit.to_owned(),
            meaning: String::new(),
        };
        let columns = [
            ("run", "run", ""),
            ("m", "varied", "kg"),
            ("w", "varied", "rad/s"),
            ("max force", "measured", "N"),
            ("status", "run", ""),
            ("message", "run", ""),
        ];
        let axes = axes.iter().map(|axis| axis.iter().map(|name| (*name).to_owned()).collect()).collect();
        let space = Space { axes, sampled };
        let mut found = Findings::new("drive", true, space, 6, columns.map(column).into());
        for (run, [m, w]) in runs.iter().enumerate() {
            let refused = *m == 3.0;
            let value = if refused { Value::Empty } else { Value::Number(2.0 * m + w) };
            let status = if refused { "refused" } else { "ok" };
            found.add(&[run.into(), Value::Number(*m), Value::Number(*w), value, status.into(), "".into()]);
        }
        let report = found.report();
        let [figure] = &report.figures[..] else { panic!("{} diagrams", report.figures.len()) };
        let Picture::Diagram(diagram) = &figure.picture else { panic!("no diagram") };
        diagram.clone()
    }

    #[test]
    fn one_axis_has_a_line_two_have_a_map_others_points() {
        let of_one = |m: f64| [m, 0.0];
        let line = diagram(&[&["m"]], false, &[2.0, 3.0, 4.0, 1.0].map(of_one));
        let [joined, refused] = &line.series[..] else { panic!("{:?}", line.series) };
        assert_eq!((&*line.x.label, &*line.y.label, &*line.title), ("m [kg]", "max force [N]", "max force"));
        // A run that is not next to the others interrupts the line.
        assert!(joined.joined && joined.points[0] == [1.0, 2.0] && joined.points[1][0].is_nan());
        assert!(joined.points[2] == [2.0, 4.0] && joined.points[4] == [4.0, 8.0]);
        assert_eq!(refused.points, [[3.0, 2.0]]);

        let rpm = |w: f64| w / Unit::of("rad/s").factor;
        let grid = [[1.0, rpm(10.0)], [1.0, rpm(20.0)], [2.0, rpm(10.0)], [2.0, rpm(20.0)], [3.0, rpm(10.0)]];
        let map = diagram(&[&["m"], &["w"]], false, &grid);
        let cells = map.map.unwrap();
        assert!(map.y.label == "w [rpm]" && cells.at[0] == [1.0, 2.0, 3.0] && (cells.at[1][1] - 20.0).abs() < 1e-12);
        assert_eq!(cells.cells[1], Some(4.0 + rpm(10.0)));
        assert!(cells.cells[2].is_some_and(f64::is_nan) && cells.cells[5].is_none());

        for (axes, sampled) in [(&[&["m", "w"][..]][..], false), (&[&["m", "w"]], true)] {
            let points = diagram(axes, sampled, &[[1.0, 0.1], [2.0, -0.1], [4.0, 0.0]]);
            assert!(points.map.is_none() && !points.series[0].joined && points.series[0].points[2] == [4.0, 8.0]);
            let title = "max force over m, the quantity with the strongest correlation (1.00)";
            assert_eq!((&*points.title, &*points.x.label), (title, "m [kg]"));
        }
    }

    #[test]
    fn axes_are_logarithmic_where_their_values_are() {
        let rising = |of: fn(f64) -> f64| (0..=20).map(|i| of(f64::from(i) / 20.0)).collect::<Vec<f64>>();
        assert!(is_logarithmic(&rising(|x| 0.1 * 1000f64.powf(x))) && !is_logarithmic(&rising(|x| 0.1 + 100.0 * x)));
        assert!(!is_logarithmic(&rising(|x| x - 1.0)) && !is_logarithmic(&[]) && !is_logarithmic(&[2.0]));
    }
}
