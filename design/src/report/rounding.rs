//! Limits in the digits that people read, rounded to their safe side.

use super::Unit;
use crate::text;

/// Intervals that a sentence lists.
const LISTED: usize = 4;
/// Significant digits of limits, more where they lie close together.
const DIGITS: usize = 3;
/// Those that rounding of the computation leaves.
const EXACT: usize = 12;
/// Rounding changes the length of an interval by no more than this part.
const CHANGED: f64 = 0.25;

/// To which side limits are rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rounding {
    /// For a range to avoid, or a least value: ends lie outside of their interval, numbers above.
    Outward,
    /// For an admissible range, or a largest value: ends lie within their interval, numbers below.
    Inward,
}

/// An interval (SI) whose ends have so many digits in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounded {
    /// Its ends.
    pub ends: [f64; 2],
    /// The significant digits of both.
    pub digits: usize,
}

impl Rounding {
    /// A number, whose size is rounded.
    pub(super) fn number(self, value: f64, digits: usize) -> String {
        text::digits_beyond(value, digits, self == Rounding::Outward)
    }

    /// The ends of an interval.
    fn ends(self, [low, high]: [f64; 2], digits: usize) -> [String; 2] {
        let end = |value: f64, up: bool| text::digits_beyond(value, digits, up == (value > 0.0));
        [end(low, self == Rounding::Inward), end(high, self == Rounding::Outward)]
    }

    /// The digits that keep the length of an interval.
    pub(super) fn digits(self, [low, high]: [f64; 2]) -> usize {
        let parsed = |text: &String| text.parse().unwrap_or(f64::NAN);
        let fits = |digits: &usize| {
            let [from, to] = self.ends([low, high], *digits).each_ref().map(parsed);
            ((to - from) - (high - low)).abs() <= CHANGED * (high - low)
        };
        if high.is_finite() { (DIGITS..EXACT).find(fits).unwrap_or(EXACT) } else { DIGITS }
    }

    /// "157 to 208", "above 720".
    pub(super) fn text(self, ends: [f64; 2], digits: usize, named: &dyn Fn(String) -> String) -> String {
        match (self.ends(ends, digits), ends[1].is_finite()) {
            ([low, _], false) => format!("above {}", named(low)),
            ([low, high], true) if low == high => named(low),
            ([low, high], true) => format!("{low} to {}", named(high)),
        }
    }

    /// Intervals (SI), rounded in a unit, ascending; those that then overlap are one.
    pub fn of(self, intervals: &[[f64; 2]], unit: &Unit) -> Vec<Rounded> {
        let mut sorted = intervals.to_vec();
        sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut list: Vec<Rounded> = Vec::new();
        for ends in sorted {
            let shown = ends.map(|end| end * unit.factor);
            let digits = self.digits(shown);
            let si = |text: String, end: f64| text.parse().map_or(end, |value: f64| value / unit.factor);
            let [low, high] = self.ends(shown, digits);
            let next = [si(low, ends[0]), if ends[1].is_finite() { si(high, ends[1]) } else { ends[1] }];
            match list.last_mut() {
                Some(last) if next[0] <= last.ends[1] => {
                    (last.ends[1], last.digits) = (last.ends[1].max(next[1]), last.digits.max(digits));
                }
                _ => list.push(Rounded { ends: next, digits }),
            }
        }
        list
    }

    /// "157 to 208 rpm, above 720 rpm", the first of them where there are many.
    pub fn list(self, intervals: &[Rounded], unit: &Unit) -> String {
        let one = |of: &Rounded| self.text(of.ends.map(|end| end * unit.factor), of.digits, &|text| unit.after(text));
        let mut texts: Vec<String> = intervals.iter().take(LISTED).map(one).collect();
        if let Some(last) = intervals.last().filter(|_| intervals.len() > LISTED) {
            texts.push(format!("{} more, the last {}", intervals.len() - LISTED, one(last)));
        }
        if texts.is_empty() { "none".to_owned() } else { texts.join(", ") }
    }
}

/// Admissible intervals (SI).
pub fn admissible(intervals: &[[f64; 2]], unit: &Unit) -> String {
    Rounding::Inward.list(&Rounding::Inward.of(intervals, unit), unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::unit::RPM;

    #[test]
    fn limits_are_rounded_to_the_safe_side() {
        let rpm = |ends: &[[f64; 2]], rounding: Rounding| {
            let ends: Vec<_> = ends.iter().map(|ends| ends.map(|end| end / RPM.factor)).collect();
            rounding.list(&rounding.of(&ends, &RPM), &RPM)
        };
        for (ends, outward, inward) in [
            ([157.4, 207.292], "157 to 208 rpm", "158 to 207 rpm"),
            ([157.0, 207.0], "157 to 207 rpm", "157 to 207 rpm"),
            ([-207.292, -157.4], "-208 to -157 rpm", "-207 to -158 rpm"),
            ([12.34, 207.29], "12.3 to 208 rpm", "12.4 to 207 rpm"),
            ([0.0, 207.29], "0 to 208 rpm", "0 to 207 rpm"),
            ([-12.34, 207.29], "-12.4 to 208 rpm", "-12.3 to 207 rpm"),
            ([1623.34, f64::INFINITY], "above 1620 rpm", "above 1630 rpm"),
            // Digits that keep the length.
            ([207.19, 207.34], "207.19 to 207.34 rpm", "207.19 to 207.34 rpm"),
            ([207.191, 207.342], "207.19 to 207.35 rpm", "207.2 to 207.34 rpm"),
        ] {
            assert_eq!([rpm(&[ends], Rounding::Outward), rpm(&[ends], Rounding::Inward)], [outward, inward]);
        }
        // What lies between two admissible intervals is not admissible, though no digit that is shown tells so.
        let two = [[100.2, 207.291], [207.299, 300.1]];
        assert_eq!(rpm(&two, Rounding::Inward), "101 to 207 rpm, 208 to 300 rpm");
        assert_eq!(rpm(&two, Rounding::Outward), "100 to 301 rpm");
    }
}
