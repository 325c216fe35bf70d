//! Axes in the units in which engineers read them, those of the tables: 0.002 m as 2 mm, 52.4 rad/s as 500 rpm.

use super::{Axis, Diagram, Rule, Scale, Series};
use std::f64::consts::TAU;

/// A coherent SI unit and the units that take its place, from large to small, with how many of them make it.
type Suited = (&'static str, &'static [(&'static str, f64)]);

const SUITED: [Suited; 10] = [
    ("m", &[("mm", 1e3)]),
    ("Pa", &[("N/mm²", 1e-6)]),
    ("m/rad", &[("mm/rad", 1e3)]),
    ("m/rad²", &[("mm/rad²", 1e3)]),
    ("m²", &[("m²", 1.0), ("cm²", 1e4), ("mm²", 1e6)]),
    ("m²/rad³", &[("m²/rad³", 1.0), ("cm²/rad³", 1e4), ("mm²/rad³", 1e6)]),
    ("s", &[("s", 1.0), ("ms", 1e3), ("µs", 1e6), ("ns", 1e9)]),
    ("rad", &[("°", 360.0 / TAU)]),
    ("rad/s", &[("rpm", 60.0 / TAU)]),
    ("1/m", &[("1/mm", 1e-3), ("1/m", 1.0)]),
];

/// Drawings are in millimetres, up to ten metres.
const LONGEST: f64 = 10.0;

impl Axis {
    /// The axis in the unit that suits the values, and how many of it make the unit of the label.
    pub fn suited(&self, values: impl Iterator<Item = f64>) -> (Axis, f64) {
        let as_it_is = || (self.clone(), 1.0);
        let Some((quantity, unit)) = self.label.strip_suffix(']').and_then(|label| label.rsplit_once('[')) else {
            return as_it_is();
        };
        let Some((_, units)) = SUITED.iter().find(|(own, _)| *own == unit) else { return as_it_is() };
        let sizes = values.chain(self.ends.into_iter().flatten()).map(f64::abs).filter(|x| x.is_finite() && *x > 0.0);
        // The values around the middle of a logarithmic axis are those that are read.
        let (low, high) = sizes.fold((f64::INFINITY, 0.0), |(low, high), x| (x.min(low), x.max(high)));
        let (size, least): (f64, f64) = match self.scale {
            Scale::Logarithmic => ((low * high).sqrt(), 0.1),
            Scale::Linear | Scale::Angular => (high, 1.0),
        };
        if unit.starts_with('m') && size >= LONGEST {
            return as_it_is();
        }
        let fits = |(_, factor): &&(&str, f64)| size * factor >= least;
        let Some((unit, factor)) = units.iter().find(fits).or(units.last()) else { return as_it_is() };
        let ends = self.ends.map(|ends| ends.map(|end| factor * end));
        (Axis { label: format!("{quantity}[{unit}]"), ends, ..self.clone() }, *factor)
    }
}

impl Diagram {
    /// The diagram with both axes in units that suit the data.
    pub(super) fn suited(&self) -> Diagram {
        let data =
            |i: usize| self.series.iter().flat_map(move |series| series.points.iter().map(move |point| point[i]));
        let ((x, across), (y, up)) = (self.x.suited(data(0)), self.y.suited(data(1)));
        let at = |[x, y]: &[f64; 2]| [across * x, up * y];
        let all = |points: &[[f64; 2]]| points.iter().map(at).collect::<Vec<_>>();
        let series = |series: &Series| Series { points: all(&series.points), ..series.clone() };
        let rule = |rule: &Rule| match rule {
            Rule::Vertical(x, name) => Rule::Vertical(across * x, name.clone()),
            Rule::Horizontal(y, name) => Rule::Horizontal(up * y, name.clone()),
            Rule::Area(outline, shade) => Rule::Area(all(outline), *shade),
            Rule::Border(points, width) => Rule::Border(all(points), *width),
            Rule::Dashed(points, name) => Rule::Dashed(all(points), name.clone()),
            Rule::Word(place, word) => Rule::Word(at(place), word.clone()),
            Rule::Key(shade, name) => Rule::Key(*shade, name.clone()),
        };
        let (series, rules) = (self.series.iter().map(series).collect(), self.rules.iter().map(rule).collect());
        let mut map = self.map.clone();
        for (at, factor) in map.iter_mut().flat_map(|map| map.at.iter_mut().zip([across, up])) {
            at.iter_mut().for_each(|value| *value *= factor);
        }
        Diagram { title: self.title.clone(), x, y, series, rules, map }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_in_millimetres_and_revolutions_per_minute() {
        let suited = |axis: Axis, values: &[f64]| {
            let (axis, factor) = axis.suited(values.iter().copied());
            (axis.label, factor)
        };
        let is = |label: &str, factor: f64| (label.to_owned(), factor);
        assert_eq!(suited(Axis::linear("U″ [m]"), &[-0.02, 0.0, 0.01]), is("U″ [mm]", 1e3));
        assert_eq!(suited(Axis::linear("Deviation [m]"), &[2e-6]), is("Deviation [mm]", 1e3));
        assert_eq!(suited(Axis::linear("Torque [N·m]"), &[0.5, -2500.0]), is("Torque [N·m]", 1.0));
        // From 0.02 to 5 ms, with a turn of 30 ms beside them, rather than from 20 to 5000 µs.
        for steps in [[1e-5, 1e-1], [2e-5, 5e-3]] {
            assert_eq!(suited(Axis::logarithmic("Step [s]"), &steps), is("Step [ms]", 1e3));
        }
        assert_eq!(suited(Axis::linear("Speed [rad/s]"), &[]), is("Speed [rpm]", 60.0 / TAU));
        for label in ["Error [1]", "x", "Way [m]", "U over stroke [1/rad]"] {
            assert_eq!(suited(Axis::linear(label), &[20.0]), is(label, 1.0));
        }
        let diagram = Diagram {
            title: String::new(),
            x: Axis::linear("φ [°]"),
            y: Axis::linear("U [m]").between(0.0, 0.01),
            series: vec![Series::dots("", [[90.0, 0.005]])],
            rules: vec![Rule::Horizontal(0.002, "limit".to_owned())],
            map: None,
        };
        let suited = diagram.suited();
        assert_eq!(suited.series[0].points, [[90.0, 5.0]]);
        assert_eq!((suited.y.ends, &suited.rules[0]), (Some([0.0, 10.0]), &Rule::Horizontal(2.0, "limit".to_owned())));
    }
}
