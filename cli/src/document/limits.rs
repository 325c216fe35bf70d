//! The admissible ranges of numbers.

use super::units;
use camdrive::drives::unit::{self, Quantity};
use camdrive::motion::plan::{LARGEST, MAX_LENGTH};
use std::f64::consts::PI;

/// The admissible range of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    min: f64,
    max: f64,
    /// True if `min` itself is excluded.
    open: bool,
}

/// Any finite number.
pub const ANY: Limits = Limits { min: f64::NEG_INFINITY, max: f64::INFINITY, open: true };
/// Greater than zero.
pub const POSITIVE: Limits = Limits { min: 0.0, max: f64::INFINITY, open: true };
/// Zero or greater.
pub const NOT_NEGATIVE: Limits = Limits { min: 0.0, max: f64::INFINITY, open: false };

/// The range of a lift, which depends on its quantity.
pub const LIFT: Limits = within(f64::NAN, f64::NAN);

/// The largest value of a law of this quantity; lengths and angles have the limits of cams.
pub fn largest(quantity: &Quantity) -> f64 {
    if [&unit::LENGTH, &unit::ANGLE].contains(&quantity) { MAX_LENGTH } else { LARGEST }
}

/// Between the two, ends included.
pub const fn within(min: f64, max: f64) -> Limits {
    Limits { min, max, open: false }
}

impl Limits {
    /// True if both are the same, bit by bit.
    pub fn is(self, other: Limits) -> bool {
        (self.min.to_bits(), self.max.to_bits()) == (other.min.to_bits(), other.max.to_bits())
    }

    /// True if the value is in the range.
    pub fn hold(&self, value: f64) -> bool {
        value.is_finite() && value <= self.max && if self.open { value > self.min } else { value >= self.min }
    }

    /// The range in a unit of this many coherent units.
    pub fn over(self, unit: f64) -> Self {
        Limits { min: self.min / unit, max: self.max / unit, ..self }
    }

    /// The least and the greatest value.
    pub fn ends(self) -> [f64; 2] {
        [self.min, self.max]
    }

    /// True if the least value itself is excluded.
    pub fn is_open(self) -> bool {
        self.open
    }

    /// "> 0", "0 to 2π"; empty where every number is admitted.
    pub fn range(self) -> String {
        let shown = |value: f64| match value / PI {
            0.5 => "π/2".to_owned(),
            1.0 => "π".to_owned(),
            turns if turns != 0.0 && turns % 1.0 == 0.0 && turns.abs() < 10.0 => format!("{turns}π"),
            _ => units::short(value),
        };
        match (self.min.is_finite(), self.max.is_finite()) {
            (true, false) => format!("{} {}", if self.open { '>' } else { '≥' }, shown(self.min)),
            (true, true) => format!("{} to {}", shown(self.min), shown(self.max)),
            _ => String::new(),
        }
    }

    /// "greater than 0 kg"
    pub fn words(&self, unit: &str) -> String {
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
        let low = if self.open { "greater than" } else { "at least" };
        let (min, max) = (units::short(self.min), units::short(self.max));
        match (self.min.is_finite(), self.max.is_finite()) {
            (false, false) => {
                format!("any finite number{}", if unit.is_empty() { "".into() } else { format!(" [{}]", unit.trim()) })
            }
            (true, false) => format!("{low} {min}{unit}"),
            (false, true) => format!("at most {max}{unit}"),
            (true, true) if self.open => format!("{low} {min}{unit}, at most {max}{unit}"),
            (true, true) => format!("{min} to {max}{unit}"),
        }
    }
}
