//! Numbers in messages.

use std::fmt;

/// A number in a message: shortest digits that identify it, with an exponent in place of a long row of zeros.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number(pub f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size == 0.0 || (1e-4..1e7).contains(&size) || !size.is_finite() {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

/// A computed number in a message: six digits say enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounded(pub f64);

impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Number(format!("{:.5e}", self.0).parse().unwrap_or(self.0)).fmt(f)
    }
}

/// Whether all values are finite. 0 · x is 0 for finite numbers and NaN for others, so one comparison is enough.
pub fn all_finite<const N: usize>(values: [f64; N]) -> bool {
    values.into_iter().map(|x| 0.0 * x).sum::<f64>() == 0.0
}

/// An interval in a message: `0 to 1e9`, `≥ 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range(pub f64, pub f64);

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (low, high) = (Number(self.0), Number(self.1));
        match (self.0.is_finite(), self.1.is_finite()) {
            (true, true) => write!(f, "{low} to {high}"),
            (true, false) => write!(f, "≥ {low}"),
            (false, true) => write!(f, "≤ {high}"),
            (false, false) => f.write_str("any finite number"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_lost_number_is_noticed() {
        assert!(all_finite([0.0, -0.0, f64::MAX, f64::MIN_POSITIVE, -1.0]));
        for lost in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!all_finite([lost]) && !all_finite([1.0, lost]) && !all_finite([lost, -lost]));
        }
    }

    #[test]
    fn numbers_are_short() {
        let text = |value| Number(value).to_string();
        assert_eq!([text(0.0), text(-0.25), text(1e300), text(2.5e-7)], ["0", "-0.25", "1e300", "2.5e-7"]);
        assert_eq!([text(f64::NAN), text(f64::INFINITY)], ["NaN", "inf"]);
        let rounded = |value| Rounded(value).to_string();
        assert_eq!([rounded(1.0 / 3.0), rounded(-2e-7 / 3.0), rounded(60.0)], ["0.333333", "-6.66667e-8", "60"]);
        let range = |low, high| Range(low, high).to_string();
        assert_eq!(range(0.0, 1e9), "0 to 1e9");
        assert_eq!([range(0.0, f64::INFINITY), range(f64::NEG_INFINITY, 2.0)], ["≥ 0", "≤ 2"]);
    }
}
