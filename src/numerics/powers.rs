//! The polynomial of degree 15 through the values of a function at sixteen Chebyshev points, as powers of x.
//!
//! f(x) ≈ Σ cₖ Tₖ(x),  cₖ = (2 − δₖ₀)/16 Σ f(xᵢ) Tₖ(xᵢ),  xᵢ = cos((2 i + 1) π/32)
//!
//! For tables of smooth functions on pieces so narrow that the coefficients fall to rounding. The coefficients of the powers then
//! are about the Taylor coefficients at the middle, and the sum of powers loses no digit.
//!
//! Source: L. N. Trefethen, *Approximation Theory and Approximation Practice*, SIAM 2013, chapters 3, 4, 8.

use super::interpolant::power_sum;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// The number of points and of coefficients.
const POINTS: usize = 16;

/// Half of them: the even or the odd powers.
const HALF: usize = POINTS / 2;

/// How often [`Fitting::over`] evaluates a function.
pub const EVALUATIONS: usize = 2 * POINTS + 1;

/// Rounding error of an angle within the turn (rad), at the points and at the checks.
const ROUNDING_OF_ANGLE: f64 = 1e-15;

/// The coefficients of xʲ in T₀ … T₁₅.
static CHEBYSHEV: [[f64; POINTS]; POINTS] = chebyshev_coefficients();

const fn chebyshev_coefficients() -> [[f64; POINTS]; POINTS] {
    let mut t = [[0.0; POINTS]; POINTS];
    (t[0][0], t[1][1]) = (1.0, 1.0);
    let mut k = 2;
    while k < POINTS {
        let mut j = 0;
        while j <= k {
            let raised = if j > 0 { 2.0 * t[k - 1][j - 1] } else { 0.0 };
            t[k][j] = raised - t[k - 2][j];
            j += 1;
        }
        k += 1;
    }
    t
}

/// Tₖ(xᵢ), common to all fits.
pub struct Fitting {
    /// xᵢ ∈ (−1, 1), descending.
    points: [f64; POINTS],
    /// cos(i π/16) between them and at the ends, where T₁₆ is ±1 and the polynomial misses the function most. This shows its error;
    /// coefficients do not show a small wave on a polynomial that they represent completely.
    checks: [f64; POINTS + 1],
    /// (2 − δₖ₀)/16 Tₖ(xᵢ), row by row.
    matrix: [[f64; POINTS]; POINTS],
}

impl Default for Fitting {
    fn default() -> Self {
        let angle = |k: usize, i: usize| (k * (2 * i + 1)) as f64 * PI / (2 * POINTS) as f64;
        let weight = |k: usize| if k == 0 { 1.0 } else { 2.0 } / POINTS as f64;
        Fitting {
            points: std::array::from_fn(|i| angle(1, i).cos()),
            checks: std::array::from_fn(|i| (i as f64 * PI / POINTS as f64).cos()),
            matrix: std::array::from_fn(|k| std::array::from_fn(|i| weight(k) * angle(k, i).cos())),
        }
    }
}

impl Fitting {
    /// The polynomial for `f` over the angles from `low` on, `width` wide (rad); and at each check f and the polynomial's error
    /// beyond the rounding of the angles.
    pub fn over(&self, low: f64, width: f64, f: impl Fn(f64) -> f64) -> (Powers, impl Iterator<Item = [f64; 2]>) {
        let at = move |x: f64| f(low + 0.5 * (1.0 + x) * width);
        let powers = self.fit(&self.points.map(&at));
        let misses = self.checks.iter().map(move |x| {
            let ([value, slope], exact) = (powers.with_slope(*x), at(*x));
            [exact, (value - exact).abs() - ROUNDING_OF_ANGLE * (2.0 * slope / width).abs()]
        });
        (powers, misses)
    }

    /// The polynomial through the values at the points.
    fn fit(&self, values: &[f64; POINTS]) -> Powers {
        // Only the variation is fitted, so that a constant stays exact.
        let base = values[0];
        let c: [f64; POINTS] =
            std::array::from_fn(|k| self.matrix[k].iter().zip(values).map(|(m, value)| m * (value - base)).sum());
        let mut p = Powers { even: [0.0; HALF], odd: [0.0; HALF] };
        for k in 0..HALF {
            for j in 0..=k {
                p.even[j] += CHEBYSHEV[2 * k][2 * j] * c[2 * k];
                p.odd[j] += CHEBYSHEV[2 * k + 1][2 * j + 1] * c[2 * k + 1];
            }
        }
        p.even[0] += base;
        p
    }
}

/// p(x) = Σ cⱼ xʲ.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Powers {
    even: [f64; HALF],
    odd: [f64; HALF],
}

impl Powers {
    /// p(x).
    #[inline]
    pub fn value(&self, x: f64) -> f64 {
        power_sum(&self.even, &self.odd, x)
    }

    /// p(x) and p′(x).
    #[inline]
    pub fn with_slope(&self, x: f64) -> [f64; 2] {
        let square = x * x;
        let (mut even, mut odd, mut even_slope, mut odd_slope) = (0.0, 0.0, 0.0, 0.0);
        for j in (0..HALF).rev() {
            even_slope = even_slope * square + even;
            odd_slope = odd_slope * square + odd;
            even = even * square + self.even[j];
            odd = odd * square + self.odd[j];
        }
        [even + x * odd, odd + 2.0 * x * (even_slope + x * odd_slope)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_met_to_degree_15() {
        let fitting = Fitting::default();
        for n in 0..POINTS as i32 {
            let p = fitting.fit(&fitting.points.map(|x| x.powi(n)));
            for x in [-1.0, -0.6, 0.0, 0.3, 1.0f64] {
                let [value, slope] = p.with_slope(x);
                let exact = if n == 0 { 0.0 } else { f64::from(n) * x.powi(n - 1) };
                // The powers of T₁₅ have coefficients of 10⁵.
                assert!((value - x.powi(n)).abs() < 1e-10 && (slope - exact).abs() < 1e-9, "x^{n} at {x}");
                assert_eq!(value, p.value(x));
            }
        }
    }

    #[test]
    fn a_wave_that_the_points_resolve_is_met_to_rounding() {
        // 1.3 rad of a wave on either side of the middle: its coefficients fall to 10⁻¹⁶.
        let fitting = Fitting::default();
        let p = fitting.fit(&fitting.points.map(|x| 2.0 + (1.3 * x + 0.4).cos()));
        for i in 0..=40 {
            let x = f64::from(i) / 20.0 - 1.0;
            let [value, slope] = p.with_slope(x);
            assert!((value - 2.0 - (1.3 * x + 0.4).cos()).abs() < 5e-15, "{x}");
            // Rounding enters every coefficient, and Σ k² = 1240 the slope at the ends.
            assert!((slope + 1.3 * (1.3 * x + 0.4).sin()).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn over_an_interval_the_rounding_of_the_angles_is_no_miss() {
        // 1000 φ² on [0.25, 0.27]: x = −1 … 1 there.
        let (low, width) = (0.25, 0.02);
        let evaluations = std::cell::Cell::new(0);
        let f = |phi: f64| {
            evaluations.set(evaluations.get() + 1);
            1e3 * phi * phi
        };
        let fitting = Fitting::default();
        let (p, misses) = fitting.over(low, width, f);
        let misses: Vec<[f64; 2]> = misses.collect();
        assert_eq!(evaluations.get(), EVALUATIONS);
        for ([exact, miss], x) in misses.into_iter().zip(fitting.checks) {
            let phi = low + 0.5 * (1.0 + x) * width;
            assert!((exact - 1e3 * phi * phi).abs() < 1e-13 && (p.value(x) - exact).abs() < 2e-13, "{x}");
            // 10⁻¹⁵ rad times f′ = 2000 φ, except for the roundings of f.
            assert!((miss + 1e-15 * 2e3 * phi).abs() < 2e-13, "{x}: {miss:e}");
        }
        // A larger miss counts.
        let short = |phi: f64| 1e-3 * (2500.0 * phi).sin();
        let (p, misses) = fitting.over(low, width, short);
        for ([exact, miss], x) in misses.zip(fitting.checks) {
            assert!((miss - (p.value(x) - exact).abs()).abs() < 1e-13);
        }
    }

    #[test]
    fn the_checks_see_what_the_polynomial_misses() {
        // A polynomial of degree 12 is met, a wave of 10⁻⁹ that is too short for the points is not.
        let fitting = Fitting::default();
        for phase in [0.0, 0.7, 1.6] {
            let f = |x: f64| x.powi(12) + 1e-9 * (14.0 * x + phase).cos();
            let p = fitting.fit(&fitting.points.map(f));
            let worst = |x: &[f64]| x.iter().map(|x| (p.value(*x) - f(*x)).abs()).fold(0.0, f64::max);
            let everywhere: Vec<f64> = (0..=1000).map(|i| 0.002 * f64::from(i) - 1.0).collect();
            let (seen, true_error) = (worst(&fitting.checks), worst(&everywhere));
            assert!(true_error > 1e-10 && seen > 0.9 * true_error, "{seen:e} of {true_error:e}");
        }
    }
}
