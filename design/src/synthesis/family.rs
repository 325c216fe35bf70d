//! Conditions that hold at every angle of a range.

use super::basis::{Basis, Response};
use super::deviation::Window;
use super::elastic::output;
use super::exact::dot;
use super::sampling::{COARSE, Density, FINE, angles, within};
use super::{ORDERS, Polynomial, grid};
use crate::search::flat;
use camdrive::motion::Fourier;
use camdrive::numerics::double_double::Double;

/// An excess of this part of its terms has seven digits left in plain numbers.
const PLAIN: f64 = 1e-9;

/// Σ fₙ (Y⁽ⁿ⁾ − Ũ⁽ⁿ⁾) ≤ level · t + limit at all angles of a range (or at some points of it); Y is U or what an elastic
/// output member makes of it.
#[derive(Clone, Debug)]
pub struct Family {
    from: f64,
    to: f64,
    factors: [f64; ORDERS],
    targets: [Polynomial; ORDERS],
    /// The elastic output member, if the condition looks behind it.
    pub response: Option<Response>,
    /// The factor of the unknown level t that is made small.
    pub level: f64,
    /// The right-hand side.
    pub limit: f64,
    /// Equally spaced points instead of the whole range.
    pub points: Option<usize>,
    /// The bound of the task that this is.
    pub bound: Option<usize>,
}

impl Family {
    /// Without any term.
    pub fn new(from: f64, to: f64) -> Self {
        Family {
            from,
            to,
            factors: [0.0; ORDERS],
            targets: Default::default(),
            response: None,
            level: 0.0,
            limit: 0.0,
            points: None,
            bound: None,
        }
    }

    /// The same condition behind an elastic output member.
    pub fn behind(self, response: Option<Response>) -> Self {
        Family { response, ..self }
    }

    /// The term of order `n`; the target is in SI and goes over to units of `scale`.
    pub fn set(&mut self, n: usize, factor: f64, target: &Polynomial, scale: f64) {
        self.factors[n] = factor;
        self.targets[n] = Polynomial(target.0.iter().map(|c| c / scale).collect());
    }

    /// The coefficients of the unknowns at `phi`, for the n-th derivative of the condition.
    pub fn row(&self, basis: &Basis, phi: f64, n: usize) -> Vec<Double> {
        let mut row = vec![Double::default(); basis.size()];
        for (order, &factor) in self.factors.iter().enumerate().filter(|(_, f)| **f != 0.0) {
            for (sum, part) in row.iter_mut().zip(basis.row(phi, order + n, self.response)) {
                *sum = *sum + Double::from(factor) * part;
            }
        }
        row
    }

    /// What the target contributes to the right-hand side.
    fn target(&self, phi: f64, n: usize) -> Double {
        let mut right = Double::default();
        for (order, &factor) in self.factors.iter().enumerate().filter(|(_, f)| **f != 0.0) {
            let target = (0..n).fold(self.targets[order].clone(), |p, _| p.derivative());
            right = right + Double::from(factor) * target.exactly_at(Double::from(phi) - Double::from(self.from));
        }
        right
    }

    /// By how much `x` exceeds the target at `phi`, without limit and level, or the n-th derivative of that.
    pub fn excess(&self, basis: &Basis, x: &[Double], phi: f64, n: usize) -> f64 {
        self.excess_exactly(basis, x, phi, n).hi
    }

    /// The same to thirty digits of its terms.
    pub fn excess_exactly(&self, basis: &Basis, x: &[Double], phi: f64, n: usize) -> Double {
        dot(&self.row(basis, phi, n), x) - self.target(phi, n)
    }

    /// The size of the terms that the excess is the sum of.
    pub fn terms(&self, basis: &Basis, x: &[Double], phi: f64) -> f64 {
        let row = self.row(basis, phi, 0);
        row.iter().zip(x).map(|(row, x)| (row.hi * x.hi).abs()).sum::<f64>() + self.target(phi, 0).hi.abs()
    }

    /// The angles that the first program looks at.
    pub fn first_angles(&self, basis: &Basis) -> Vec<f64> {
        self.angles(basis, COARSE)
    }

    /// The angle `phi` as one of the range, wherever whole turns lead into it; a rounding outside is its end.
    pub fn within(&self, phi: f64) -> Option<f64> {
        within(self.from, self.to, phi).filter(|_| self.points.is_none())
    }

    /// The points of the condition, or samples.
    fn angles(&self, basis: &Basis, density: Density) -> Vec<f64> {
        match self.points {
            Some(points) => grid(self.from, self.to, points).collect(),
            None => angles(self.from, self.to, basis.order(), density),
        }
    }

    /// The angles at which the excess is at a local maximum.
    pub fn maxima(&self, basis: &Basis, x: &[Double]) -> Vec<f64> {
        let angles = self.angles(basis, FINE);
        if self.points.is_some() {
            return angles;
        }
        // Where plain numbers tell the excess to many digits, they find the angles.
        if let Some(motion) = self.motion(&basis.series(x, 1.0)) {
            let (sum, target) = self.combined(&motion);
            let window = Window { from: self.from, to: self.to, order: 0, target: &target };
            let size = (0..sum.a.len()).map(|k| sum.a[k].abs() + sum.b[k].abs()).fold(target.at(0.0).abs(), f64::max);
            let maxima = window.maxima(&sum);
            let highest = maxima.iter().map(|e| e.value.abs()).fold(0.0, f64::max);
            if highest > PLAIN * size {
                return maxima.into_iter().map(|extreme| extreme.phi).collect();
            }
        }
        let values: Vec<f64> = angles.iter().map(|phi| self.excess(basis, x, *phi, 0)).collect();
        let last = angles.len() - 1;
        let higher = |i: usize, j: usize| values[i] >= values[j.min(last)];
        let mut maxima: Vec<f64> = (0..=last)
            .filter(|&i| higher(i, i.saturating_sub(1)) && higher(i, i + 1))
            .map(|i| {
                let slopes = |phi: f64| [1, 2].map(|n| self.excess(basis, x, phi, n));
                flat(angles[i], [angles[i.saturating_sub(1)], angles[(i + 1).min(last)]], slopes)
            })
            .collect();
        // Two samples of equal height lead to one maximum.
        maxima.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        maxima
    }

    /// What moves where U is this series; None at an undamped resonance.
    fn motion(&self, series: &Fourier) -> Option<Fourier> {
        match self.response {
            Some(response) => output(series, response),
            None => Some(series.clone()),
        }
    }

    /// Σ fₙ U⁽ⁿ⁾ of a series and Σ fₙ Ũ⁽ⁿ⁾.
    fn combined(&self, series: &Fourier) -> (Fourier, Polynomial) {
        let mut sum = Fourier::new(vec![0.0; series.a.len()], Vec::new());
        let mut target = Polynomial::default();
        let (mut a, mut b) = (series.a.clone(), series.b.clone());
        for (factor, part) in self.factors.iter().zip(&self.targets) {
            let longest = target.0.len().max(part.0.len());
            target.0.resize(longest, 0.0);
            target.0.iter_mut().zip(&part.0).for_each(|(t, p)| *t += factor * p);
            for k in 0..a.len() {
                sum.a[k] += factor * a[k];
                sum.b[k] += factor * b[k];
                // The derivative of a cos kφ + b sin kφ is k b cos kφ − k a sin kφ.
                (a[k], b[k]) = (k as f64 * b[k], -(k as f64) * a[k]);
            }
        }
        (sum, target)
    }

    /// The largest |Σ fₙ (U⁽ⁿ⁾ − Ũ⁽ⁿ⁾)| of a series, in plain numbers and without the response.
    pub fn magnitude(&self, series: &Fourier) -> f64 {
        let (sum, target) = self.combined(series);
        match self.points {
            Some(points) => {
                let error = |phi: f64| (sum.at(phi).0[0] - target.at(phi - self.from)).abs();
                grid(self.from, self.to, points).map(error).fold(0.0, f64::max)
            }
            None => {
                let window = Window { from: self.from, to: self.to, order: 0, target: &target };
                window.largest(&sum).value.abs()
            }
        }
    }
}
