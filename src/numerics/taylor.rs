//! Truncated Taylor series: an output equation written once yields its value, its time derivatives and its
//! directional derivatives.
//!
//! Source: A. Griewank, A. Walther, *Evaluating Derivatives*, 2nd ed., SIAM 2008, chapter 13.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers of an output equation: a plain number, or a [`Series`].
pub trait Scalar:
    Copy
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
{
    /// The highest order that it knows.
    const ORDER: usize;
    /// f(self), where `derivatives` are f, f′, f″ at the value of self.
    fn compose(self, derivatives: [f64; 3]) -> Self;
    /// The coefficient of order 0.
    fn value(self) -> f64;
}

impl Scalar for f64 {
    const ORDER: usize = 0;
    fn compose(self, derivatives: [f64; 3]) -> Self {
        derivatives[0]
    }
    fn value(self) -> f64 {
        self
    }
}

/// c₀ + c₁ ε + c₂ ε² + O(ε³).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Series(pub [f64; 3]);

impl Series {
    /// The series of a function of time with these value, first and second derivative.
    pub fn from_derivatives(d0: f64, d1: f64, d2: f64) -> Self {
        Series([d0, d1, d2 / 2.0])
    }

    /// The derivative of order 0, 1 or 2.
    pub fn derivative(self, order: usize) -> f64 {
        [1.0, 1.0, 2.0][order] * self.0[order]
    }
}

impl From<f64> for Series {
    fn from(value: f64) -> Self {
        Series([value, 0.0, 0.0])
    }
}

impl Scalar for Series {
    const ORDER: usize = 2;
    fn compose(self, [f, f1, f2]: [f64; 3]) -> Self {
        let [_, c1, c2] = self.0;
        Series([f, f1 * c1, f1 * c2 + 0.5 * f2 * c1 * c1])
    }
    fn value(self) -> f64 {
        self.0[0]
    }
}

impl Add for Series {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Series(std::array::from_fn(|i| self.0[i] + o.0[i]))
    }
}

impl Sub for Series {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Series(std::array::from_fn(|i| self.0[i] - o.0[i]))
    }
}

impl Neg for Series {
    type Output = Self;
    fn neg(self) -> Self {
        Series(self.0.map(|c| -c))
    }
}

impl Mul<f64> for Series {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Series(self.0.map(|c| factor * c))
    }
}

impl Mul for Series {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        let ([a0, a1, a2], [b0, b1, b2]) = (self.0, o.0);
        Series([a0 * b0, a0 * b1 + a1 * b0, a0 * b2 + a1 * b1 + a2 * b0])
    }
}

impl Div for Series {
    type Output = Self;
    fn div(self, o: Self) -> Self {
        let ([a0, a1, a2], [b0, b1, b2]) = (self.0, o.0);
        let c0 = a0 / b0;
        let c1 = (a1 - c0 * b1) / b0;
        Series([c0, c1, (a2 - c0 * b2 - c1 * b1) / b0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quotient_times_its_divisor_is_the_dividend() {
        let (a, b) = (Series([2.0, -1.0, 0.5]), Series([4.0, 3.0, -2.0]));
        let back = (a / b) * b;
        for i in 0..3 {
            assert!((back.0[i] - a.0[i]).abs() < 1e-15);
        }
    }

    #[test]
    fn the_composed_series_of_the_sine() {
        // sin(t²) at t = 2: f = sin 4, f′ = 4 cos 4, f″ = 2 cos 4 − 16 sin 4.
        let t2 = Series::from_derivatives(4.0, 4.0, 2.0);
        let (s, c) = f64::sin_cos(4.0);
        let f = t2.compose([s, c, -s]);
        assert!((f.derivative(1) - 4.0 * c).abs() < 1e-14);
        assert!((f.derivative(2) - (2.0 * c - 16.0 * s)).abs() < 1e-14);
    }
}
