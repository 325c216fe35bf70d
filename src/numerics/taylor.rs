//! Truncated Taylor series: an output equation written once yields its value, its time derivatives and its directional derivatives.
//! A formula with roots and circular functions yields those of a mechanism.
//!
//! Source: A. Griewank, A. Walther, *Evaluating Derivatives*, 2nd ed., SIAM 2008, chapter 13.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers that can be added, multiplied and divided.
pub trait Arithmetic:
    Copy
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
{
    /// The second derivative with respect to time of a function of an angle, which has this rate and this rate of the rate: `of` are
    /// the function and its first two derivatives.
    fn bend(of: [Self; 3], w: Self, a: Self) -> Self {
        of[2] * (w * w) + of[1] * a
    }
}

/// Numbers of an output equation: a plain number, or a [`Series`].
pub trait Scalar: Arithmetic {
    /// The highest order that the type holds.
    const ORDER: usize;
    /// f(self), where `derivatives` are f, f′, f″ at the value of self.
    fn compose(self, derivatives: [f64; 3]) -> Self;
    /// The coefficient of order 0.
    fn value(self) -> f64;
}

impl Arithmetic for f64 {}

impl Scalar for f64 {
    const ORDER: usize = 0;
    fn compose(self, derivatives: [f64; 3]) -> Self {
        derivatives[0]
    }
    fn value(self) -> f64 {
        self
    }
}

/// c₀ + c₁ ε + … + c_{N−1} ε^{N−1} + O(ε^N).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series<const N: usize = 3>(pub [f64; N]);

impl Series {
    /// The series of a function of time with this value, first and second derivative.
    pub fn from_derivatives(d0: f64, d1: f64, d2: f64) -> Self {
        Series([d0, d1, d2 / 2.0])
    }

    /// The derivative of order 0, 1 or 2.
    pub fn derivative(self, order: usize) -> f64 {
        [1.0, 1.0, 2.0][order] * self.0[order]
    }
}

impl<const N: usize> Series<N> {
    /// The series of a function with these derivatives of order 0, 1 …
    pub fn of_derivatives(derivatives: [f64; N]) -> Self {
        let mut series = derivatives;
        let mut factorial = 1.0;
        for (n, c) in series.iter_mut().enumerate().skip(2) {
            factorial *= n as f64;
            *c /= factorial;
        }
        Series(series)
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
        Series(std::array::from_fn(|n| self.0.get(n + 1).map_or(0.0, |c| (n + 1) as f64 * c)))
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
        (Series(s), Series(c))
    }

    /// The square root of a series with a positive value.
    pub fn sqrt(self) -> Self {
        let mut root = [0.0; N];
        root[0] = self.0[0].sqrt();
        for n in 1..N {
            let known: f64 = (1..n).map(|k| root[k] * root[n - k]).sum();
            root[n] = (self.0[n] - known) / (2.0 * root[0]);
        }
        Series(root)
    }
}

impl<const N: usize> From<f64> for Series<N> {
    fn from(value: f64) -> Self {
        Series(std::array::from_fn(|n| if n == 0 { value } else { 0.0 }))
    }
}

impl Arithmetic for Series {}

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

impl<const N: usize> Add for Series<N> {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Series(std::array::from_fn(|n| self.0[n] + o.0[n]))
    }
}

impl<const N: usize> Sub for Series<N> {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Series(std::array::from_fn(|n| self.0[n] - o.0[n]))
    }
}

impl<const N: usize> Neg for Series<N> {
    type Output = Self;
    fn neg(self) -> Self {
        Series(self.0.map(|c| -c))
    }
}

impl<const N: usize> Add<f64> for Series<N> {
    type Output = Self;
    fn add(mut self, constant: f64) -> Self {
        self.0[0] += constant;
        self
    }
}

impl<const N: usize> Mul<f64> for Series<N> {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Series(self.0.map(|c| factor * c))
    }
}

impl<const N: usize> Mul for Series<N> {
    type Output = Self;
    fn mul(self, o: Self) -> Self {
        Series(std::array::from_fn(|n| (0..=n).map(|k| self.0[k] * o.0[n - k]).sum()))
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

    /// (x y − x/y) 3 − x + 5.
    fn formula<S: Scalar>(x: S, y: S) -> S {
        (x * y - x / y) * 3.0 + -x + S::from(5.0)
    }

    #[test]
    fn a_formula_of_numbers_is_the_value_of_that_of_series() {
        // x = e^t and y = 2 (1 + t) at 0: x y has the derivatives 2, 4, 6, x/y has 1/2, 0, 1/2.
        let x = Series::from_derivatives(0.0, 1.0, 0.0).compose([1.0; 3]);
        let y = Series::from_derivatives(2.0, 2.0, 0.0);
        assert_eq!((formula(x, y).derivatives(), formula(1.0, 2.0)), ([8.5, 11.0, 15.5], 8.5));
        fn composed<S: Scalar>(x: S) -> f64 {
            let value = x.value();
            x.compose([value * value, 2.0 * value, 2.0]).value()
        }
        assert_eq!((composed(3.0), composed(Series([3.0, 1.0, 7.0])), Series([3.0, 1.0]).value()), (9.0, 9.0, 3.0));
        // (2 + 3 t + 5 t²)² = 4 + 12 t + 29 t² …
        assert_eq!(Series([2.0, 3.0, 5.0]).compose([4.0, 4.0, 2.0]), Series([4.0, 12.0, 29.0]));
    }

    #[test]
    fn derivatives_of_a_formula_with_root_and_sine() {
        // f = √(1 + x²) sin x: f″ = −f + (2x cos x)/r + sin x/r³, r = √(1 + x²), at x = 0.7.
        let x = 0.7_f64;
        let series = Series::<5>::of_derivatives([x, 1.0, 0.0, 0.0, 0.0]);
        let (sin, cos) = series.sin_cos();
        let f = ((series * series + 1.0).sqrt() * sin).derivatives();
        let (s, c) = x.sin_cos();
        let r = (1.0 + x * x).sqrt();
        assert!((f[0] - r * s).abs() < 1e-15);
        assert!((f[1] - (r * c + x * s / r)).abs() < 1e-15);
        assert!((f[2] - (-r * s + 2.0 * x * c / r + s / r.powi(3))).abs() < 1e-14);
        assert!((sin.derivatives()[4] - s).abs() < 1e-15 && (cos.derivatives()[3] - s).abs() < 1e-15);
        let slope = sin.slope().derivatives();
        assert!((slope[3] - s).abs() < 1e-15 && slope[4] == 0.0);
        assert_eq!(Series::of_derivatives([1.0, 2.0, 3.0, 4.0, 5.0]).derivatives(), [1.0, 2.0, 3.0, 4.0, 5.0]);
    }
}
