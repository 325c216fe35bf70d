//! Truncated power series of a fixed length: what a formula with roots and circular functions makes of a function and its
//! derivatives.
//!
//! Source: A. Griewank, A. Walther, *Evaluating Derivatives*, 2nd ed., SIAM 2008, section 13.2.

use std::ops::{Add, Mul, Sub};

/// c₀ + c₁ ε + … + c_{N−1} ε^{N−1} + O(ε^N).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<const N: usize>(pub [f64; N]);

impl<const N: usize> Jet<N> {
    /// A constant.
    pub fn constant(value: f64) -> Self {
        let mut jet = [0.0; N];
        jet[0] = value;
        Jet(jet)
    }

    /// The series of a function with these derivatives of order 0, 1 …
    pub fn from_derivatives(derivatives: [f64; N]) -> Self {
        let mut jet = derivatives;
        let mut factorial = 1.0;
        for (n, c) in jet.iter_mut().enumerate().skip(2) {
            factorial *= n as f64;
            *c /= factorial;
        }
        Jet(jet)
    }

    /// The derivatives of order 0, 1 …
    pub fn derivatives(self) -> [f64; N] {
        let mut derivatives = self.0;
        let mut factorial = 1.0;
        for (n, d) in derivatives.iter_mut().enumerate().skip(2) {
            factorial *= n as f64;
            *d *= factorial;
        }
        derivatives
    }

    /// The value.
    pub fn value(self) -> f64 {
        self.0[0]
    }

    /// The derivative. It is known to one order less: the last coefficient is zero.
    pub fn slope(self) -> Self {
        Jet(std::array::from_fn(|n| self.0.get(n + 1).map_or(0.0, |c| (n + 1) as f64 * c)))
    }

    /// Sine and cosine: s′ = x′ c, c′ = −x′ s.
    pub fn sin_cos(self) -> (Self, Self) {
        let (mut s, mut c) = ([0.0; N], [0.0; N]);
        (s[0], c[0]) = self.0[0].sin_cos();
        for n in 1..N {
            for k in 1..=n {
                let slope = k as f64 * self.0[k] / n as f64;
                s[n] += slope * c[n - k];
                c[n] -= slope * s[n - k];
            }
        }
        (Jet(s), Jet(c))
    }

    /// The square root of a series with a positive value.
    pub fn sqrt(self) -> Self {
        let mut root = [0.0; N];
        root[0] = self.0[0].sqrt();
        for n in 1..N {
            let known: f64 = (1..n).map(|k| root[k] * root[n - k]).sum();
            root[n] = (self.0[n] - known) / (2.0 * root[0]);
        }
        Jet(root)
    }
}

impl<const N: usize> Add for Jet<N> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Jet(std::array::from_fn(|n| self.0[n] + o.0[n]))
    }
}

impl<const N: usize> Sub for Jet<N> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Jet(std::array::from_fn(|n| self.0[n] - o.0[n]))
    }
}

impl<const N: usize> Add<f64> for Jet<N> {
    type Output = Self;
    fn add(mut self, constant: f64) -> Self {
        self.0[0] += constant;
        self
    }
}

impl<const N: usize> Mul<f64> for Jet<N> {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Jet(self.0.map(|c| factor * c))
    }
}

impl<const N: usize> Mul for Jet<N> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Jet(std::array::from_fn(|n| (0..=n).map(|k| self.0[k] * o.0[n - k]).sum()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_a_formula_with_root_and_sine() {
        // f = √(1 + x²) sin x: f″ = −f + (2x cos x)/r + sin x/r³, r = √(1 + x²), at x = 0.7.
        let x = 0.7_f64;
        let jet = Jet::<5>::from_derivatives([x, 1.0, 0.0, 0.0, 0.0]);
        let (sin, cos) = jet.sin_cos();
        let f = ((jet * jet + 1.0).sqrt() * sin).derivatives();
        let (s, c) = x.sin_cos();
        let r = (1.0 + x * x).sqrt();
        assert!((f[0] - r * s).abs() < 1e-15);
        assert!((f[1] - (r * c + x * s / r)).abs() < 1e-15);
        assert!((f[2] - (-r * s + 2.0 * x * c / r + s / r.powi(3))).abs() < 1e-14);
        assert!((sin.derivatives()[4] - s).abs() < 1e-15 && (cos.derivatives()[3] - s).abs() < 1e-15);
        let slope = sin.slope().derivatives();
        assert!((slope[3] - s).abs() < 1e-15 && slope[4] == 0.0);
        assert_eq!(Jet::from_derivatives([1.0, 2.0, 3.0, 4.0, 5.0]).derivatives(), [1.0, 2.0, 3.0, 4.0, 5.0]);
    }
}
