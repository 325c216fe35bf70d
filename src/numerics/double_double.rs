//! Double-double arithmetic: a number as the unevaluated sum of two `f64`, about 32 decimal digits.
//!
//! Source: T. J. Dekker, "A floating-point technique for extending the available precision",
//! Numer. Math. 18 (1971) 224–242; D. E. Knuth, TAOCP vol. 2, section 4.2.2.

use serde::{Deserialize, Serialize};
use std::ops::{Add, Mul, Neg, Sub};

/// The unevaluated sum `hi + lo` with |lo| ≤ ½ ulp(hi); relative error of an operation ≤ 2⁻¹⁰².
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Double {
    /// The nearest `f64`.
    pub hi: f64,
    /// Remainder beyond `hi`.
    pub lo: f64,
}

/// a + b without rounding error.
pub fn two_sum(a: f64, b: f64) -> Double {
    let hi = a + b;
    let c = hi - a;
    Double { hi, lo: (a - (hi - c)) + (b - c) }
}

/// a · b without rounding error (barring underflow).
pub fn two_product(a: f64, b: f64) -> Double {
    let hi = a * b;
    Double { hi, lo: a.mul_add(b, -hi) }
}

/// The sum of a and b where |a| ≥ |b|.
fn quick_sum(a: f64, b: f64) -> Double {
    let hi = a + b;
    Double { hi, lo: b - (hi - a) }
}

impl Double {
    /// √self; NaN for a negative number.
    pub fn sqrt(self) -> Double {
        if self.hi <= 0.0 {
            return Double::from(self.hi.sqrt());
        }
        let root = self.hi.sqrt();
        let rest = self - two_product(root, root);
        quick_sum(root, rest.hi / (2.0 * root))
    }

    /// self / other.
    pub fn divide(self, other: Double) -> Double {
        let first = self.hi / other.hi;
        let rest = self - other * Double::from(first);
        let second = rest.hi / other.hi;
        let rest = rest - other * Double::from(second);
        quick_sum(first, second) + Double::from(rest.hi / other.hi)
    }
}

impl From<f64> for Double {
    fn from(value: f64) -> Self {
        Double { hi: value, lo: 0.0 }
    }
}

impl Add for Double {
    type Output = Double;
    fn add(self, other: Double) -> Double {
        let s = two_sum(self.hi, other.hi);
        let t = two_sum(self.lo, other.lo);
        let s = quick_sum(s.hi, s.lo + t.hi);
        quick_sum(s.hi, s.lo + t.lo)
    }
}

impl Neg for Double {
    type Output = Double;
    fn neg(self) -> Double {
        Double { hi: -self.hi, lo: -self.lo }
    }
}

impl Sub for Double {
    type Output = Double;
    fn sub(self, other: Double) -> Double {
        self + -other
    }
}

impl Mul for Double {
    type Output = Double;
    fn mul(self, other: Double) -> Double {
        let p = two_product(self.hi, other.hi);
        quick_sum(p.hi, p.lo + (self.hi * other.lo + self.lo * other.hi))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_square_of_a_root_is_the_number() {
        for x in [2.0, 3.0e-7, 1.7e19] {
            let root = Double::from(x).sqrt();
            let error = root * root - Double::from(x);
            assert!(error.hi.abs() <= 1e-30 * x, "√{x}: {error:?}");
        }
    }

    #[test]
    fn a_quotient_times_the_divisor_is_the_dividend() {
        let (a, b) = (Double::from(1.0), two_sum(3.0, 1e-20));
        let error = a.divide(b) * b - a;
        assert!(error.hi.abs() <= 1e-31, "{error:?}");
    }

    #[test]
    fn a_quotient_is_right_to_the_last_digit() {
        for (i, beyond) in (1..2000).flat_map(|i| [(i, 0.0), (i, 1.1e-16)]) {
            let root = f64::from(i).sqrt();
            let (a, b) = (1.0 + f64::from(i) / 7.0, two_sum(root, beyond * root));
            let q = Double::from(a).divide(b);
            // The largest terms of the remainder cancel without rounding.
            let first = two_product(q.hi, b.hi);
            let [second, third] = [two_product(q.hi, b.lo), two_product(q.lo, b.hi)];
            let rest = two_sum(a - first.hi, -first.lo) - second - third - Double::from(q.lo * b.lo);
            let last_digit = q.lo.abs().next_up() - q.lo.abs();
            let bound = if b.lo == 0.0 { 0.501 * last_digit } else { q.hi * 2f64.powi(-104) };
            assert!((rest.hi / b.hi).abs() <= bound, "{a}/{b:?}: {q:?} misses {:e}", rest.hi / b.hi);
        }
    }

    #[test]
    fn a_sum_whose_large_parts_cancel_is_exact() {
        let (one, third) = (two_sum(1.0, 2f64.powi(-60)), 2f64.powi(-60) / 3.0 * 2f64.powi(-40));
        assert_eq!(one + Double { hi: -1.0, lo: third }, two_sum(2f64.powi(-60), third));
    }
}
