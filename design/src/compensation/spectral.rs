//! Periodic functions by their values at equidistant points: series, antiderivative, derivative.
//!
//! The number of points N is odd, so that the N values and the series up to the order K = (N − 1)/2 determine each
//! other and only the constant has no derivative. For an analytic function the error falls faster than any power of 1/N.
//!
//! Source: L. N. Trefethen, *Spectral Methods in MATLAB*, SIAM 2000, chapter 3.

use crate::harmonic_analysis::discrete_series;
use crate::search::summit;
use camdrive::motion::Fourier;
use std::f64::consts::TAU;

/// The points 2πi/N, i = 0 … N − 1, and the operators on values at them.
pub struct Mesh {
    /// The antiderivative's kernel, g_d = (2/N) Σ sin(k d 2π/N)/k.
    integral: Vec<f64>,
    /// The derivative's kernel, h_d = −(2/N) Σ k sin(k d 2π/N).
    slope: Vec<f64>,
}

impl Mesh {
    /// The mesh that carries the orders up to `order`: N = 2 `order` + 1 points.
    pub fn new(order: usize) -> Self {
        let n = 2 * order + 1;
        let sines: Vec<f64> = (0..n).map(|i| (TAU * i as f64 / n as f64).sin()).collect();
        let kernel = |weight: fn(f64) -> f64| -> Vec<f64> {
            let term = |k: usize, d: usize| weight(k as f64) * sines[k * d % n];
            (0..n).map(|d| 2.0 / n as f64 * (1..=order).map(|k| term(k, d)).sum::<f64>()).collect()
        };
        let (integral, slope) = (kernel(|k| 1.0 / k), kernel(|k| -k));
        Mesh { integral, slope }
    }

    /// N.
    pub fn len(&self) -> usize {
        self.slope.len()
    }

    /// (N − 1)/2.
    pub fn order(&self) -> usize {
        self.len() / 2
    }

    /// The i-th point (rad).
    pub fn point(&self, i: usize) -> f64 {
        TAU * i as f64 / self.len() as f64
    }

    /// The weight of value `j` in the antiderivative with mean zero at point `i`; a mean of the values is left out.
    pub fn integral(&self, i: usize, j: usize) -> f64 {
        self.integral[self.distance(i, j)]
    }

    /// The weight of value `j` in the derivative at point `i`.
    pub fn slope(&self, i: usize, j: usize) -> f64 {
        self.slope[self.distance(i, j)]
    }

    fn distance(&self, i: usize, j: usize) -> usize {
        if i >= j { i - j } else { i + self.len() - j }
    }

    /// The antiderivative with mean zero of the values without their mean.
    pub fn integrate(&self, values: &[f64]) -> Vec<f64> {
        self.apply(|i, j| self.integral(i, j), values)
    }

    fn apply(&self, weight: impl Fn(usize, usize) -> f64, values: &[f64]) -> Vec<f64> {
        (0..self.len()).map(|i| values.iter().enumerate().map(|(j, v)| weight(i, j) * v).sum()).collect()
    }

    /// The trigonometric polynomial through the values.
    pub fn series(&self, values: &[f64]) -> Fourier {
        discrete_series(0.0, values, self.order())
    }
}

/// The arithmetic mean: ⟨·⟩ over the turn.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Points of a curve over the period.
pub const POINTS: usize = 720;

/// ψ (rad) of a point.
pub fn phase(i: usize) -> f64 {
    TAU * i as f64 / POINTS as f64
}

/// aₖ and bₖ together: √(aₖ² + bₖ²).
pub fn amplitude(series: &Fourier, k: usize) -> f64 {
    series.a[k].hypot(series.b[k])
}

/// The part of a series in its upper third of orders, relative to its largest amplitude; it shows whether the mesh resolves the
/// function.
pub fn tail(series: &Fourier) -> f64 {
    let amplitudes: Vec<f64> = (1..=series.order()).map(|k| amplitude(series, k)).collect();
    let largest = amplitudes.iter().fold(series.a[0].abs(), |m, a| m.max(*a));
    let last = amplitudes[2 * amplitudes.len() / 3..].iter().fold(0.0_f64, |m, a| m.max(*a));
    if largest > 0.0 { last / largest } else { 0.0 }
}

/// The angle and the value of the largest |f| over the turn, f a smooth function of orders up to about `order`.
pub fn largest(order: usize, f: impl Fn(f64) -> f64) -> [f64; 2] {
    // Twelve points per shortest wave leave the vertex of the parabola within a thousandth of the point distance of the
    // maximum; a search does the rest.
    let n = 12 * order.max(4);
    let places: Vec<f64> = (0..=n).map(|i| TAU * i as f64 / n as f64).collect();
    largest_between(&places, f)
}

/// The place and the value of the largest |f|, f smooth between the ascending `places` and no finer than they are.
pub fn largest_between(places: &[f64], f: impl Fn(f64) -> f64) -> [f64; 2] {
    let size = |x: f64| f(x).abs();
    let best = (0..places.len()).map(|i| (i, size(places[i]))).max_by(|a, b| a.1.total_cmp(&b.1));
    let Some((best, at_best)) = best else { return [0.0, 0.0] };
    // Beyond the ends, as far as the next place is on the other side.
    let next = |i: usize| places.get(i).copied().unwrap_or(2.0 * places[best] - places[best.saturating_sub(1)]);
    let high_end = next(best + 1);
    let low_end = if best > 0 { places[best - 1] } else { 2.0 * places[best] - high_end };
    let tolerance = 0.5e-9 * (high_end - low_end).max(1e-3);
    summit(&mut |x| size(x), [low_end, high_end], (places[best], at_best), tolerance).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integral_and_derivative_of_an_analytic_function() {
        let mesh = Mesh::new(30);
        let f: Vec<f64> = (0..mesh.len()).map(|i| mesh.point(i).sin().exp()).collect();
        let slope = mesh.apply(|i, j| mesh.slope(i, j), &f);
        let back = mesh.integrate(&slope);
        for i in 0..mesh.len() {
            let phi = mesh.point(i);
            assert!((slope[i] - phi.cos() * f[i]).abs() < 1e-13);
            assert!((back[i] - (f[i] - mean(&f))).abs() < 1e-13);
            assert!((mesh.series(&f).at(phi).0[0] - f[i]).abs() < 1e-14);
        }
        // I₀(1), the mean of exp(sin φ).
        assert!((mean(&f) - 1.266_065_877_752_008_4).abs() < 1e-15);
        assert!(tail(&mesh.series(&f)) < 1e-15);
        let [at, value] = largest(30, |phi| mesh.series(&f).at(phi).0[0]);
        assert!((value - 1f64.exp()).abs() < 1e-14 && (at - TAU / 4.0).abs() < 1e-6);
    }
}
