//! Values over two axes as coloured cells, with the scale of the colours next to the plot.

use super::{Axis, Rule, Scale, Shade, TEXT, TICK, framed, upright};
use crate::drawing::{Anchor, BLACK, Frame, Ink, Shape};
use crate::text;

/// Values on a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Quantity and unit of the values, and how the colours divide them.
    pub scale: Axis,
    /// The places of columns and rows on their axes, at least two of each, in ascending order.
    pub at: [Vec<f64>; 2],
    /// The values row by row; NaN of a run without one, None where there is no run yet.
    pub cells: Vec<Option<f64>>,
}

/// The meanings of a cell without a value and of a cell without a run.
pub const REFUSED: &str = "refused or failed";
const MISSING: &str = "missing";

/// Steps of colour, which rise in darkness, so that a grey print keeps their order.
const LEVELS: usize = 24;
const COLOURS: [[f64; 3]; 3] = [[245.0, 240.0, 200.0], [70.0, 155.0, 160.0], [30.0, 45.0, 110.0]];

/// The width of the scale with its numbers and its name, and of the colours in it.
pub const BAR: f64 = 88.0;
const STRIPE: f64 = 14.0;

fn ink(level: usize) -> Ink {
    let place = 2.0 * level as f64 / (LEVELS - 1) as f64;
    let from = (place as usize).min(1);
    Ink([0, 1, 2].map(|i| {
        let [low, high] = [COLOURS[from][i], COLOURS[from + 1][i]];
        (low + (high - low) * (place - from as f64)).round() as u8
    }))
}

impl Map {
    /// The ends of the scale.
    pub fn range(&self) -> [f64; 2] {
        let places = self.cells.iter().flatten().filter_map(|value| self.scale.place(*value));
        let [low, high] =
            places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
        if low < high { [low, high] } else { [low - 0.5, low + 0.5] }
    }

    /// The borders of the columns or the rows on their axis, half-way between their places.
    fn borders(&self, i: usize, axis: &Axis) -> Vec<f64> {
        let at: Vec<f64> = self.at[i].iter().filter_map(|value| axis.place(*value)).collect();
        let middle = |pair: &[f64]| 0.5 * (pair[0] + pair[1]);
        let [first, last] = [[0, 1], [at.len() - 1, at.len() - 2]].map(|[end, next]| 1.5 * at[end] - 0.5 * at[next]);
        [first].into_iter().chain(at.windows(2).map(middle)).chain([last]).collect()
    }

    /// The axes from the first to the last border.
    pub fn axes(&self, axes: [Axis; 2]) -> [Axis; 2] {
        let mut number = 0..2;
        axes.map(|axis| {
            let borders = self.borders(number.next().unwrap_or(0), &axis);
            let [low, high] = [borders[0], borders[borders.len() - 1]];
            let value = |place: f64| if axis.scale == Scale::Logarithmic { 10f64.powf(place) } else { place };
            let [low, high] = [low, high].map(value);
            axis.between(low, high)
        })
    }

    /// The legend of cells without colour.
    pub fn keys(&self) -> Vec<Rule> {
        let refused = self.cells.iter().flatten().any(|value| !value.is_finite());
        let kinds = [(refused, Shade::Dark, REFUSED), (self.cells.contains(&None), Shade::Pale, MISSING)];
        let there = kinds.into_iter().filter(|(there, ..)| *there);
        there.map(|(_, shade, name)| Rule::Key(Some(shade), name.to_owned())).collect()
    }

    /// The cells, equal neighbours of a row in one.
    pub fn shapes(&self, axes: [&Axis; 2], frame: &Frame) -> Vec<Shape> {
        let [columns, rows] = [0, 1].map(|i| self.borders(i, axes[i]));
        let [low, high] = self.range();
        let colour = |cell: &Option<f64>| match cell.map(|value| self.scale.place(value)) {
            None => Shade::Pale.ink(),
            Some(None) => Shade::Dark.ink(),
            Some(Some(place)) => ink(((place - low) / (high - low) * LEVELS as f64).min(LEVELS as f64 - 1.0) as usize),
        };
        let mut shapes = Vec::new();
        for (j, row) in self.cells.chunks(self.at[0].len()).enumerate() {
            let mut from = 0;
            for run in row.iter().map(colour).collect::<Vec<_>>().chunk_by(|one, next| one == next) {
                let [[left, bottom], [right, top]] =
                    [[columns[from], rows[j]], [columns[from + run.len()], rows[j + 1]]].map(|at| frame.at(at));
                from += run.len();
                // The next ones cover the edge, lest the ground shines through between them.
                let [right, top] = [(right + 0.5).min(frame.ends[0][1]), (top - 0.5).max(frame.ends[1][1])];
                let points = vec![[left, bottom], [right, bottom], [right, top], [left, top]];
                shapes.push(Shape::Area { points, ink: run[0] });
            }
        }
        shapes
    }

    /// The scale to the right of the plot between these ends.
    pub fn bar(&self, [[_, right], [bottom, top]]: [[f64; 2]; 2]) -> Vec<Shape> {
        let ([left, right], range) = ([right + STRIPE, right + 2.0 * STRIPE], self.range());
        let height = |part: f64| bottom + (top - bottom) * part;
        let stripe = |level: usize| {
            // Up to the end, lest the ground shines through between them.
            let low = height(level as f64 / LEVELS as f64);
            Shape::Area { points: vec![[left, low], [right, low], [right, top], [left, top]], ink: ink(level) }
        };
        let mut shapes: Vec<Shape> = (0..LEVELS).map(stripe).collect();
        for (place, number) in self.scale.ticks(range) {
            let y = height((place - range[0]) / (range[1] - range[0]));
            shapes.push(Shape::line(vec![[right, y], [right + TICK, y]], 1.0, BLACK));
            shapes.push(Shape::text([right + TICK + 3.0, y + 0.36 * TEXT], TEXT, Anchor::Start, number));
        }
        shapes.push(framed([[left, right], [bottom, top]]));
        shapes.extend(upright(&self.scale.label, right + BAR - STRIPE, [bottom, top]));
        shapes
    }

    /// For the script of a page row by row: the cells with a value as "x,y,value", those without as "x,y".
    pub fn read(&self) -> [(&'static str, String); 2] {
        let number = |value: f64| text::digits(value, 5, -4);
        let cells = |has_value: bool| {
            let row = |(y, row): (&f64, &[Option<f64>])| {
                let cell = |(x, cell): (&f64, &Option<f64>)| {
                    let value = cell.filter(|value| value.is_finite() == has_value)?;
                    let of_value = if has_value { format!(",{}", number(value)) } else { String::new() };
                    Some(format!("{},{}{of_value}", number(*x), number(*y)))
                };
                self.at[0].iter().zip(row).filter_map(cell).collect::<Vec<_>>().join(" ")
            };
            let rows = self.at[1].iter().zip(self.cells.chunks(self.at[0].len())).map(row);
            rows.filter(|row| !row.is_empty()).collect::<Vec<_>>().join(";")
        };
        [("", cells(true)), (REFUSED, cells(false))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Diagram;

    #[test]
    fn each_cell_has_the_colour_of_its_value() {
        let cells = vec![Some(1.0), Some(1.0), Some(100.0), Some(10.0), Some(f64::NAN), None];
        let map = Map { scale: Axis::logarithmic("Force [N]"), at: [vec![1.0, 10.0, 100.0], vec![0.0, 2.0]], cells };
        let axes = map.axes([Axis::logarithmic("K [1]"), Axis::linear("μ [1]")]);
        let ends = axes.each_ref().map(|axis| axis.ends.unwrap());
        assert!((ends[0][0] - 10f64.powf(-0.5)).abs() < 1e-12 && ends[1] == [-1.0, 3.0]);
        assert_eq!(map.range(), [0.0, 2.0]);
        assert_eq!(map.read()[0].1, "1,0,1 10,0,1 100,0,100;1,2,10");
        assert_eq!(map.read()[1].1, "10,2");
        let frame = Frame { ends: [[0.0, 300.0], [200.0, 0.0]], ranges: [[-0.5, 2.5], [-1.0, 3.0]] };
        let drawn = map.shapes(axes.each_ref(), &frame);
        let inks: Vec<Ink> =
            drawn.iter().map(|shape| if let Shape::Area { ink, .. } = shape { *ink } else { BLACK }).collect();
        let expected = [ink(0), ink(LEVELS - 1), ink(LEVELS / 2), Shade::Dark.ink(), Shade::Pale.ink()];
        assert_eq!(inks, expected);
        // The two equal cells are one, from the left end to two thirds.
        let Shape::Area { points, .. } = &drawn[0] else { panic!("no area") };
        assert!(points[0] == [0.0, 200.0] && (points[2][0] - 200.5).abs() < 1e-9, "{points:?}");
        // Colours get darker all the way.
        let light = |level: usize| ink(level).0.iter().map(|part| u32::from(*part)).sum::<u32>();
        assert!((1..LEVELS).all(|level| light(level) < light(level - 1)));
        let rules = map.keys();
        let svg = Diagram { map: Some(map), ..Diagram::new("Forces", axes, Vec::new(), rules) }.svg();
        for part in ["Force [N]", REFUSED, MISSING, ">100<"] {
            assert!(svg.contains(part), "{part}");
        }
    }
}
