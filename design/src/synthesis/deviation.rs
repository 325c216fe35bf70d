//! The deviation of a series from a target, and its largest derivatives.

use super::Curve;
use super::sampling::{MEDIUM, angles};
pub use crate::search::Extreme;
use crate::search::crests;
use crate::work;
use camdrive::motion::Fourier;
use std::f64::consts::TAU;

/// U⁽ⁿ⁾ − Ũ⁽ⁿ⁾ over a range of angles.
#[derive(Clone, Copy, Debug)]
pub struct Window<'a> {
    /// First angle (rad).
    pub from: f64,
    /// Last angle (rad).
    pub to: f64,
    /// n ≤ 3.
    pub order: usize,
    /// Ũ⁽ⁿ⁾, from the first angle on.
    pub target: &'a Curve,
}

impl Window<'_> {
    /// Value, slope and bend of the deviation.
    fn at(&self, series: &Fourier, phi: f64) -> [f64; 3] {
        let derivatives = series.derivatives::<3>(phi).map(|pair| pair.array());
        let mut target = self.target.clone();
        std::array::from_fn(|n| {
            let wanted = target.at(phi - self.from);
            target = target.derivative();
            derivatives.as_flattened()[self.order + n] - wanted
        })
    }

    /// Angles close enough to each other for the extremes of a series, and the deviations there.
    fn sampled(&self, series: &Fourier) -> (Vec<f64>, Vec<f64>) {
        let angles = angles(self.from, self.to, series.order().max(self.target.order()), MEDIUM);
        let value = |phi: &f64| {
            let derivatives = series.derivatives::<2>(*phi).map(|pair| pair.array());
            derivatives.as_flattened()[self.order] - self.target.at(phi - self.from)
        };
        // An order of a series takes some ten operations, and the extremes as much as the samples.
        work::draw(20.0 * (angles.len() * (1 + series.order())) as f64);
        let values = angles.iter().map(value).collect();
        (angles, values)
    }

    /// The deviation of largest magnitude; its angle to rounding.
    pub fn largest(&self, series: &Fourier) -> Extreme {
        // More than samples miss of a maximum.
        let none = Extreme { value: 0.0, phi: self.from };
        let higher = |best: Extreme, next: Extreme| if next.value.abs() > best.value.abs() { next } else { best };
        self.extremes(series, 0.85).into_iter().fold(none, higher)
    }

    /// The local extremes of at least the `part` of the largest magnitude.
    pub fn extremes(&self, series: &Fourier, part: f64) -> Vec<Extreme> {
        let (angles, values) = self.sampled(series);
        let least = part * values.iter().fold(0.0, |highest, v| v.abs().max(highest));
        let mut extremes = self.summits(series, &angles, &values, 1.0);
        extremes.extend(self.summits(series, &angles, &values, -1.0));
        extremes.retain(|extreme| extreme.value.abs() >= least);
        extremes
    }

    /// The local maxima of the deviation, with its sign.
    pub fn maxima(&self, series: &Fourier) -> Vec<Extreme> {
        let (angles, values) = self.sampled(series);
        self.summits(series, &angles, &values, 1.0)
    }

    /// The local maxima of `sign` times the deviation, found from samples.
    fn summits(&self, series: &Fourier, angles: &[f64], values: &[f64], sign: f64) -> Vec<Extreme> {
        let signed: Vec<f64> = values.iter().map(|value| sign * value).collect();
        let slopes = |phi: f64| [1, 2].map(|n| sign * self.at(series, phi)[n]);
        let summit = |(i, phi): (usize, f64)| {
            let summit = Extreme { value: self.at(series, phi)[0], phi };
            // A summit that rounding has missed is not above the sample.
            if sign * summit.value > signed[i] { summit } else { Extreme { value: values[i], phi: angles[i] } }
        };
        crests(angles, &signed, &slopes).into_iter().map(summit).collect()
    }
}

/// The largest |U⁽ⁿ⁾| over the turn.
pub fn peak(series: &Fourier, order: usize) -> Extreme {
    Window { from: 0.0, to: TAU, order, target: &Curve::default() }.largest(series)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_values_of_a_wave() {
        let series = Fourier::new(vec![0.0], vec![0.0, 1.0, 0.0, 1.0 / 3.0]);
        let dense =
            |order: usize| (0..200_000).map(|i| series.at(f64::from(i) * TAU / 2e5).0[order].abs()).fold(0.0, f64::max);
        for order in 0..4 {
            assert!((peak(&series, order).value.abs() - dense(order)).abs() < 1e-8, "order {order}");
        }
        let target = Curve::polynomial(vec![0.5, 1.0]);
        let window = Window { from: 1.0, to: 1.5, order: 0, target: &target };
        let away = |phi: f64| (series.at(phi).0[0] - 0.5 - (phi - 1.0)).abs();
        let dense = (0..=10_000).map(|i| away(1.0 + 5e-5 * f64::from(i))).fold(0.0, f64::max);
        assert!((window.largest(&series).value.abs() - dense).abs() < 1e-8);
    }
}
