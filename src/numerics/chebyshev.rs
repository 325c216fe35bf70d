//! Chebyshev interpolation on nested points.
//!
//! Source: L. N. Trefethen, *Approximation Theory and Approximation Practice*, SIAM 2013, chapters 3, 4, 8.

use super::count::at_most;
use super::interpolant::decay;
use serde::{Deserialize, Serialize};

/// The highest degree of an interpolant.
pub const MAX_DEGREE: usize = 16;

/// cos(π k / 16), k = 0 … 16.
const COSINES: [f64; MAX_DEGREE + 1] = [
    1.0,
    0.9807852804032304,
    0.9238795325112867,
    0.8314696123025452,
    std::f64::consts::FRAC_1_SQRT_2,
    0.5555702330196022,
    0.3826834323650898,
    0.19509032201612828,
    0.0,
    -0.19509032201612828,
    -0.3826834323650898,
    -0.5555702330196022,
    -std::f64::consts::FRAC_1_SQRT_2,
    -0.8314696123025452,
    -0.9238795325112867,
    -0.9807852804032304,
    -1.0,
];

/// p(x) = Σ cⱼ Tⱼ(x) on [−1, 1].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Chebyshev {
    /// cⱼ; zero beyond the degree.
    pub coefficients: [f64; MAX_DEGREE + 1],
    /// The degree.
    #[serde(deserialize_with = "at_most::<_, MAX_DEGREE>")]
    pub degree: usize,
}

/// An interpolant and an estimate of its error.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// The interpolant.
    pub polynomial: Chebyshev,
    /// The larger of the last two coefficients, the size of the first neglected ones or more.
    pub tail: f64,
    /// Whether the tail is below the requested tolerance.
    pub converged: bool,
    /// How often the function was evaluated.
    pub evaluations: usize,
}

/// Interpolates `f` at 5, 9 or 17 points, whichever first brings the last two coefficients below `relative`
/// times the largest one or below `absolute`.
pub fn fit(mut f: impl FnMut(f64) -> f64, relative: f64, absolute: f64) -> Fit {
    let mut values = [0.0; MAX_DEGREE + 1];
    let mut degree = 4;
    for j in (0..=MAX_DEGREE).step_by(MAX_DEGREE / degree) {
        values[j] = f(COSINES[j]);
    }
    loop {
        let polynomial = through(&values, degree);
        let c = &polynomial.coefficients;
        let largest = c.iter().fold(0.0, |largest: f64, c| largest.max(c.abs()));
        let tail = c[degree].abs().max(c[degree - 1].abs());
        let converged = tail <= (relative * largest).max(absolute);
        if converged || degree == MAX_DEGREE {
            return Fit { polynomial, tail, converged, evaluations: degree + 1 };
        }
        // The points of the next degree lie between the known ones.
        degree *= 2;
        for j in (MAX_DEGREE / degree..MAX_DEGREE).step_by(2 * MAX_DEGREE / degree) {
            values[j] = f(COSINES[j]);
        }
    }
}

/// The interpolant through the values at cos(π j / degree): a discrete cosine transform.
fn through(values: &[f64; MAX_DEGREE + 1], degree: usize) -> Chebyshev {
    let stride = MAX_DEGREE / degree;
    let mut coefficients = [0.0; MAX_DEGREE + 1];
    for (k, c) in coefficients.iter_mut().enumerate().take(degree + 1) {
        let mut sum = 0.0;
        for j in 0..=degree {
            // cos(π j k / degree), the argument folded into [0, π].
            let index = (j * k * stride) % (2 * MAX_DEGREE);
            let term = values[j * stride] * COSINES[index.min(2 * MAX_DEGREE - index)];
            sum += if j == 0 || j == degree { 0.5 * term } else { term };
        }
        *c = sum * if k == 0 || k == degree { 1.0 } else { 2.0 } / degree as f64;
    }
    Chebyshev { coefficients, degree }
}

impl Chebyshev {
    /// p(x) by Clenshaw's recurrence.
    pub fn at(&self, x: f64) -> f64 {
        let (mut b1, mut b2) = (0.0, 0.0);
        for c in self.coefficients[1..=self.degree].iter().rev() {
            (b1, b2) = (c + 2.0 * x * b1 - b2, b1);
        }
        self.coefficients[0] + x * b1 - b2
    }

    /// p(x) and p′(x).
    pub fn with_slope(&self, x: f64) -> [f64; 2] {
        let (mut b1, mut b2) = (0.0, 0.0);
        let (mut d1, mut d2) = (0.0, 0.0);
        for c in self.coefficients[1..=self.degree].iter().rev() {
            // The derivative of the recurrence with respect to x.
            (d1, d2) = (2.0 * b1 + 2.0 * x * d1 - d2, d1);
            (b1, b2) = (c + 2.0 * x * b1 - b2, b1);
        }
        [self.coefficients[0] + x * b1 - b2, b1 + x * d1 - d2]
    }

    /// The first two coefficients that an interpolant of a smooth function leaves out, if they go on to decay like the last
    /// two pairs.
    pub fn neglected(&self) -> [f64; 2] {
        let c = |below: usize| self.coefficients[self.degree - below].abs();
        let decay = decay(&self.coefficients[..=self.degree]);
        let root = decay.sqrt();
        [root * c(0).max(root * c(1)), decay * c(0).max(root * c(1))]
    }

    /// The polynomial p that solves κ p + α p′ + β p″ = self, primes with respect to x: back-substitution from the highest
    /// coefficient down. Accurate if κ outweighs the derivatives of a polynomial of this degree.
    pub fn solve(&self, kappa: f64, alpha: f64, beta: f64) -> Chebyshev {
        let mut p = [0.0; MAX_DEGREE + 1];
        // The coefficients of p′ and p″, two places longer so that the recurrence needs no border case.
        let (mut first, mut second) = ([0.0; MAX_DEGREE + 3], [0.0; MAX_DEGREE + 3]);
        for j in (0..=self.degree).rev() {
            if j < self.degree {
                let n = 2.0 * (j + 1) as f64;
                first[j] = first[j + 2] + n * p[j + 1];
                second[j] = second[j + 2] + n * first[j + 1];
            }
            let half = if j == 0 { 0.5 } else { 1.0 };
            p[j] = (self.coefficients[j] - half * (alpha * first[j] + beta * second[j])) / kappa;
        }
        Chebyshev { coefficients: p, degree: self.degree }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interpolant_of_the_exponential() {
        let fit = fit(f64::exp, 1e-15, 0.0);
        assert!(fit.converged && fit.evaluations == 17);
        for i in 0..=20 {
            let x = f64::from(i) / 10.0 - 1.0;
            let [value, slope] = fit.polynomial.with_slope(x);
            assert!((value - x.exp()).abs() < 2e-15 && (fit.polynomial.at(x) - value).abs() < 1e-15);
            assert!((slope - x.exp()).abs() < 1e-13, "slope at {x}");
        }
    }

    #[test]
    fn five_points_do_for_a_parabola_and_seventeen_fail_for_a_kink() {
        assert_eq!(fit(|x| 1.0 + x - 3.0 * x * x, 1e-14, 0.0).evaluations, 5);
        assert!(!fit(f64::abs, 1e-14, 0.0).converged);
        // T₃ and T₄ are the last but one and the last coefficient of five points.
        for order in [3.0, 4.0] {
            let mut calls = 0;
            let waves = |x: f64| {
                calls += 1;
                (order * x.acos()).cos()
            };
            let fit = fit(waves, 1e-14, 0.0);
            assert_eq!((fit.evaluations, calls, fit.converged), (9, 9, true));
        }
    }

    #[test]
    fn the_neglected_coefficients_go_on_like_those_before() {
        let of = |c: &dyn Fn(usize) -> f64| {
            let coefficients = std::array::from_fn(|j| if j <= 8 { c(j) } else { 0.0 });
            Chebyshev { coefficients, degree: 8 }.neglected()
        };
        let decaying = |j: usize| 0.1_f64.powi(j as i32);
        // All, only the even and only the odd ones; each parity is met by one of the two.
        for parity in [None, Some(0), Some(1)] {
            let [odd, even] = of(&|j| if parity.is_none_or(|parity| j % 2 == parity) { -decaying(j) } else { 0.0 });
            assert!((odd / decaying(9) - 1.0).abs() < 1e-12 && (even / decaying(10) - 1.0).abs() < 1e-12, "{parity:?}");
        }
        assert_eq!([of(&|_| 3.0), of(&|j| 10f64.powi(j as i32)), of(&|_| 0.0)], [[3.0; 2], [1e8; 2], [0.0; 2]]);
    }

    #[test]
    fn the_solution_of_a_differential_equation_in_coefficients() {
        // p = T₃ = 4x³ − 3x: 100 p + 2 p′ + 3 p″ = 400 x³ + 24 x² − 228 x − 6.
        let right = fit(|x| 400.0 * x.powi(3) + 24.0 * x * x - 228.0 * x - 6.0, 1e-14, 0.0).polynomial;
        let p = right.solve(100.0, 2.0, 3.0);
        for (j, c) in p.coefficients.iter().enumerate() {
            assert!((c - if j == 3 { 1.0 } else { 0.0 }).abs() < 1e-14, "{j}: {c}");
        }
    }

    #[test]
    fn the_solution_at_the_highest_degree() {
        // p = e^x: 100 p + 2 p′ + 3 p″ = 105 e^x, but for what is left out beyond the degree 16.
        let right = fit(|x| 105.0 * x.exp(), 0.0, 0.0).polynomial;
        let (p, expected) = (right.solve(100.0, 2.0, 3.0), fit(f64::exp, 0.0, 0.0).polynomial);
        assert_eq!(p.degree, MAX_DEGREE);
        for (c, e) in p.coefficients.iter().zip(expected.coefficients) {
            assert!((c - e).abs() < 1e-11, "{c} {e}");
        }
    }
}
