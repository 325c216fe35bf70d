//! Advice that can be followed: a sentence, the keys of the file with the values that it means, and the claim that then holds.

use super::Unit;
use crate::text;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};

/// An advice.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Advice {
    /// In a sentence.
    pub text: String,
    /// Its settings, all together; empty where no key of the file does it.
    pub set: Vec<Setting>,
    /// The claim that holds then.
    pub claim: Option<Claim>,
}

/// A key of the file with its value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// As studies name it: `drive.speed`, `follower[1].load.spring.preload`.
    pub key: String,
    /// Its value.
    pub value: WrittenValue,
    /// Which other values do as well.
    pub reach: Reach,
    /// Other keys for the same quantity, with their values, where the file has one of them instead.
    #[serde(skip)]
    spellings: Vec<(String, WrittenValue)>,
}

/// A value as a file writes it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum WrittenValue {
    /// A number of things.
    Count(usize),
    /// A number without unit, or in coherent SI.
    Number(f64),
    /// A number with its unit, or a name.
    Text(String),
}

/// Which values of a key follow an advice, by their size.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reach {
    /// This one.
    #[default]
    Exactly,
    /// This one and larger ones.
    AtLeast,
    /// This one and smaller ones.
    AtMost,
    /// All but those between any of these two, the second of which may be missing.
    Outside(Vec<(WrittenValue, Option<WrittenValue>)>),
}

/// A claim on the scene that follows an advice.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Claim {
    /// Free motions do not grow at these speeds (rad/s), at that of the file where there are none.
    Stable {
        /// The speeds.
        at: Vec<f64>,
    },
    /// Force keeps the follower, numbered from 1 where there are several, on its cam.
    Contact {
        /// Its number.
        follower: Option<usize>,
    },
    /// The machine turns with this mean speed on its periodic motion.
    Speed {
        /// That speed (rad/s).
        mean: f64,
    },
    /// The conditions of a task are met within this deviation (m).
    Deviation {
        /// That deviation.
        at_most: f64,
    },
    /// `check` warns of less.
    Plausible,
    /// Outputs differ from the reference by at most this part of their largest value, at the communication step of the advice
    /// or, without one, of the default experiment.
    Error {
        /// That part.
        at_most: f64,
        /// The step (s).
        step: Option<f64>,
    },
    /// The cam can be cut.
    Cut {
        /// The number of the follower.
        follower: Option<usize>,
    },
    /// The hardest impact of the settled motion has at most this impulse (N·s).
    Impulse {
        /// That impulse.
        at_most: f64,
    },
}

impl Advice {
    /// Advice that nothing is set for.
    pub fn new(text: impl Into<String>) -> Self {
        Advice { text: text.into(), ..Advice::default() }
    }

    /// Adds settings, and the claim that holds then.
    pub fn set(mut self, set: impl IntoIterator<Item = Setting>, claim: Claim) -> Self {
        self.set.extend(set);
        self.claim = (!self.set.is_empty()).then_some(claim);
        self
    }

    /// Names each key as the file does, whose `place` for a key is there (true), or free (false), or nowhere (None); what has
    /// no place cannot be set.
    pub fn spell(&mut self, place: &dyn Fn(&str) -> Option<bool>) {
        for setting in &mut self.set {
            let own = (setting.key.clone(), setting.value.clone());
            let all = || std::iter::once(&own).chain(&setting.spellings);
            let found = [true, false].iter().find_map(|there| all().find(|(key, _)| place(key) == Some(*there)));
            let Some((key, value)) = found.cloned() else {
                (self.set, self.claim) = (Vec::new(), None);
                return;
            };
            (setting.key, setting.value) = (key, value);
        }
    }
}

impl From<&str> for Advice {
    fn from(text: &str) -> Self {
        Advice::new(text)
    }
}

impl From<String> for Advice {
    fn from(text: String) -> Self {
        Advice::new(text)
    }
}

impl Setting {
    /// A key with its value, which alone does.
    pub fn new(key: impl Into<String>, value: impl Into<WrittenValue>) -> Self {
        Setting { key: key.into(), value: value.into(), reach: Reach::Exactly, spellings: Vec::new() }
    }

    /// The least value (SI) that does, in so many digits of a unit: rounded up.
    pub fn at_least(key: impl Into<String>, value: f64, unit: &Unit, digits: usize) -> Self {
        Setting { reach: Reach::AtLeast, ..Setting::new(key, WrittenValue::rounded(value, unit, digits, true)) }
    }

    /// The largest value (SI) that does, in so many digits of a unit: rounded down.
    pub fn at_most(key: impl Into<String>, value: f64, unit: &Unit, digits: usize) -> Self {
        Setting { reach: Reach::AtMost, ..Setting::new(key, WrittenValue::rounded(value, unit, digits, false)) }
    }

    /// A value that stands outside of intervals.
    pub fn outside(
        key: impl Into<String>,
        value: WrittenValue,
        intervals: Vec<(WrittenValue, Option<WrittenValue>)>,
    ) -> Self {
        Setting { reach: Reach::Outside(intervals), ..Setting::new(key, value) }
    }

    /// The same quantity under another key.
    pub fn or(mut self, key: impl Into<String>, value: impl Into<WrittenValue>) -> Self {
        self.spellings.push((key.into(), value.into()));
        self
    }
}

impl WrittenValue {
    /// A value (SI) in so many digits of a unit, its size rounded up or down.
    pub fn rounded(value: f64, unit: &Unit, digits: usize, up: bool) -> Self {
        WrittenValue::with_unit(text::digits_beyond(value * unit.factor, digits, up), unit)
    }

    /// A value (SI) in so many digits of a unit.
    pub fn nearest(value: f64, unit: &Unit, digits: usize) -> Self {
        WrittenValue::with_unit(text::digits(value * unit.factor, digits, -4), unit)
    }

    fn with_unit(text: String, unit: &Unit) -> Self {
        match (&*unit.name, text.parse()) {
            ("", Ok(number)) => WrittenValue::Number(number),
            (name, _) => WrittenValue::Text(format!("{text} {name}")),
        }
    }
}

impl From<usize> for WrittenValue {
    fn from(count: usize) -> Self {
        WrittenValue::Count(count)
    }
}

impl From<f64> for WrittenValue {
    fn from(value: f64) -> Self {
        WrittenValue::Number(value)
    }
}

impl From<&str> for WrittenValue {
    fn from(text: &str) -> Self {
        WrittenValue::Text(text.to_owned())
    }
}

impl From<String> for WrittenValue {
    fn from(text: String) -> Self {
        WrittenValue::Text(text)
    }
}

impl Display for WrittenValue {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            WrittenValue::Count(count) => count.fmt(f),
            WrittenValue::Number(value) => value.fmt(f),
            WrittenValue::Text(text) => text.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::unit::{MM, N, RPM};

    #[test]
    fn limits_are_rounded_to_the_safe_side() {
        let [least, most] = [Setting::at_least("F", 9.85801, &N, 4), Setting::at_most("s", 0.00123456, &MM, 4)];
        assert_eq!((least.value, most.value), ("9.859 N".into(), "1.234 mm".into()));
        // A speed of the other sense, by its size; what is round already stays.
        assert_eq!(Setting::at_most("w", -20.0 / RPM.factor, &RPM, 5).value, "-20 rpm".into());
        assert_eq!(Setting::at_most("w", -20.00019 / RPM.factor, &RPM, 5).value, "-20 rpm".into());
        assert_eq!(Setting::at_least("w", -20.00019 / RPM.factor, &RPM, 5).value, "-20.001 rpm".into());
    }

    #[test]
    fn keys_are_those_of_the_file() {
        let advice = || {
            Advice::new("Stiffen it.")
                .set([Setting::new("a.frequency", "9 Hz").or("a.c", 3.0)], Claim::Contact { follower: None })
        };
        let spelled = |place: &dyn Fn(&str) -> Option<bool>| {
            let mut advice = advice();
            advice.spell(place);
            advice.set.into_iter().map(|setting| (setting.key, setting.value)).collect::<Vec<_>>()
        };
        let frequency = vec![("a.frequency".to_owned(), WrittenValue::from("9 Hz"))];
        assert_eq!(spelled(&|_| Some(true)), frequency);
        assert_eq!(spelled(&|key| Some(key == "a.c")), [("a.c".to_owned(), 3.0.into())]);
        assert_eq!(spelled(&|_| Some(false)), frequency);
        assert_eq!(spelled(&|_| None), []);
    }
}
