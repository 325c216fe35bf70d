//! How far a series is from a target, and its largest derivatives.

use super::Curve;
use super::sampling::{MEDIUM, angles};
pub use crate::search::Extreme;
use crate::search::crests;
use camdrive::motion::Fourier;
use std::f64::consts::TAU;

/// U⁽ⁿ⁾ − Ũ⁽ⁿ⁾ over a range of angles.
#[derive(Clone, Copy, Debug)]
pub struct Window<'a> {
    /// First angle (rad).
    pub from: f64,
    /// Last angle (rad).
    pub to: f64,
    /// n.
    pub order: usize,
    /// Ũ⁽ⁿ⁾, from the first angle on.
    pub target: &'a Curve,
}

/// U⁽ⁿ⁾ as a sum of waves aₖ cos kφ + bₖ sin kφ.
struct Waves {
    a: Vec<f64>,
    b: Vec<f64>,
}

impl Waves {
    /// The n-th derivative of a series.
    fn of(series: &Fourier, n: usize) -> Self {
        let (mut a, mut b) = (series.a.clone(), series.b.clone());
        for _ in 0..n {
            for (k, (a, b)) in a.iter_mut().zip(&mut b).enumerate() {
                (*a, *b) = (k as f64 * *b, -(k as f64) * *a);
            }
        }
        Waves { a, b }
    }

    /// Value, slope and bend at `phi`.
    #[inline]
    fn at(&self, phi: f64) -> [f64; 3] {
        let (s1, c1) = phi.sin_cos();
        let (mut s, mut c) = (0.0, 1.0);
        let mut sums = [self.a[0], 0.0, 0.0];
        for (k, (a, b)) in self.a.iter().zip(&self.b).enumerate().skip(1) {
            (s, c) = (s * c1 + c * s1, c * c1 - s * s1);
            let (even, odd, k) = (a * c + b * s, b * c - a * s, k as f64);
            sums[0] += even;
            sums[1] += k * odd;
            sums[2] -= k * k * even;
        }
        sums
    }
}

impl Window<'_> {
    /// Value, slope and bend of the deviation.
    fn at(&self, waves: &Waves, phi: f64) -> [f64; 3] {
        let mut value = waves.at(phi);
        let mut target = self.target.clone();
        for value in &mut value {
            *value -= target.at(phi - self.from);
            target = target.derivative();
        }
        value
    }

    /// Angles close enough to each other for the extremes of a series, and the deviations there.
    fn sampled(&self, waves: &Waves) -> (Vec<f64>, Vec<f64>) {
        let angles = angles(self.from, self.to, (waves.a.len() - 1).max(self.target.order()), MEDIUM);
        let value = |phi: &f64| waves.at(*phi)[0] - self.target.at(phi - self.from);
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
        let waves = Waves::of(series, self.order);
        let (angles, values) = self.sampled(&waves);
        let least = part * values.iter().fold(0.0, |highest, v| v.abs().max(highest));
        let mut extremes = self.summits(&waves, &angles, &values, 1.0);
        extremes.extend(self.summits(&waves, &angles, &values, -1.0));
        extremes.retain(|extreme| extreme.value.abs() >= least);
        extremes
    }

    /// The local maxima of the deviation, with its sign.
    pub fn maxima(&self, series: &Fourier) -> Vec<Extreme> {
        let waves = Waves::of(series, self.order);
        let (angles, values) = self.sampled(&waves);
        self.summits(&waves, &angles, &values, 1.0)
    }

    /// The local maxima of `sign` times the deviation, found from samples.
    fn summits(&self, waves: &Waves, angles: &[f64], values: &[f64], sign: f64) -> Vec<Extreme> {
        let signed: Vec<f64> = values.iter().map(|value| sign * value).collect();
        let slopes = |phi: f64| [1, 2].map(|n| sign * self.at(waves, phi)[n]);
        let summit = |(i, phi): (usize, f64)| {
            let summit = Extreme { value: self.at(waves, phi)[0], phi };
            // A summit that rounding has missed is not above the sample.
            if sign * summit.value > signed[i] { summit } else { Extreme { value: values[i], phi: angles[i] } }
        };
        crests(angles, &signed, slopes).into_iter().map(summit).collect()
    }
}

/// The largest |U⁽ⁿ⁾| over the turn.
pub fn peak(series: &Fourier, order: usize) -> Extreme {
    Window { from: 0.0, to: TAU, order, target: &Curve::default() }.largest(series)
}

/// U′U″, of which the kinetostatic torque is −m Ω² times, as the series ½ (U′²)′.
pub fn torque(series: &Fourier) -> Fourier {
    let n = series.order();
    let slope = |k: usize| [k as f64 * series.b[k], -(k as f64) * series.a[k]];
    let (mut a, mut b) = (vec![0.0; 2 * n + 1], vec![0.0; 2 * n + 1]);
    for k in 1..=n {
        for l in 1..=n {
            let ([p, q], [r, s]) = (slope(k), slope(l));
            // Half of the product of two waves is in their sum, half in their difference.
            let (sum, difference) = (k + l, k.abs_diff(l));
            a[sum] += 0.5 * (p * r - q * s);
            b[sum] += 0.5 * (p * s + q * r);
            a[difference] += 0.5 * (p * r + q * s);
            if k > l {
                b[difference] += 0.5 * (q * r - p * s);
            } else if l > k {
                b[difference] += 0.5 * (p * s - q * r);
            }
        }
    }
    let half_slope =
        |list: &[f64], sign: f64| list.iter().enumerate().map(|(k, c)| sign * 0.5 * k as f64 * c).collect();
    Fourier::new(half_slope(&b, 1.0), half_slope(&a, -1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_torque_is_the_product() {
        let series = Fourier::new(vec![0.3, 0.6, 0.05, -0.1], vec![0.0, -0.02, 0.3, 0.01]);
        let torque = torque(&series);
        for phi in [0.0, 0.4, 2.0, 5.5] {
            let [_, first, second, ..] = series.at(phi).0;
            assert!((torque.at(phi).0[0] - first * second).abs() < 1e-15);
        }
    }

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
