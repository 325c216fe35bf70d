//! The values of a scene that a reader of its page may move.

use crate::document::keys::{Dimension, Key, KeyTable, SCENE, Value as Taken};
use crate::document::units;
use crate::document::{Document, Value, values};

/// A number of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Dial {
    /// Its key, "drive.speed".
    pub key: String,
    /// Its meaning, as the reference says.
    pub meaning: &'static str,
    /// As the file has it, "1800 rpm".
    pub text: String,
    /// Its number.
    pub value: f64,
    /// The ends of its slider; None of a zero without a range.
    pub ends: Option<[f64; 2]>,
}

/// Sections that change no motion.
const STILL: [&str; 4] = ["solver", "geometry", "forces", "coupling"];

/// A slider goes from this part of a value to its inverse.
const SPAN: f64 = 1.0 / 3.0;

/// The numbers of a scene, speed first, the others in the order of the file.
pub fn dials(document: &Document) -> Vec<Dial> {
    let mut found: Vec<(bool, usize, Dial)> = values(&document.table)
        .into_iter()
        .filter(|(key, _)| !key.split(['.', '[']).any(|part| STILL.contains(&part)))
        .filter_map(|(key, value)| {
            let text = match value.get_ref() {
                Value::Text(text) => text.clone(),
                Value::Float(number) => number.to_string(),
                Value::Integer(Some(number)) => number.to_string(),
                _ => return None,
            };
            let (number, _) = units::split(text.trim());
            let (declared, number) = (declared(&SCENE, &key)?, number.parse::<f64>().ok()?);
            let ends = span(number, limits(declared, &text)?);
            let is_speed = ["drive.speed", "motor.w_s"].contains(&key.as_str());
            Some((
                !is_speed,
                value.span().start,
                Dial { key, meaning: declared.meaning.trim(), text, value: number, ends },
            ))
        })
        .collect();
    found.sort_by_key(|(later, place, _)| (*later, *place));
    found.into_iter().map(|(.., dial)| dial).collect()
}

/// The declaration of the key at the end of this path.
fn declared(table: &'static KeyTable, path: &str) -> Option<&'static Key> {
    let (first, rest) = path.split_once('.').map_or((path, None), |(first, rest)| (first, Some(rest)));
    let first = first.split('[').next().unwrap_or(first);
    let key = table.all().find(|key| key.key == first)?;
    let Some(rest) = rest else { return Some(key) };
    key.values.iter().find_map(|value| match value {
        Taken::Table(inner) | Taken::Tables(inner) => declared(inner, rest),
        _ => None,
    })
}

/// The admissible range of the key, in the unit of the text; None of a key that takes no real number.
fn limits(key: &Key, text: &str) -> Option<[f64; 2]> {
    key.values.iter().find_map(|value| match value {
        Taken::Real(Dimension::Fixed(quantity), limits) => {
            let (_, unit) = units::split(text.trim());
            let size = if unit.is_empty() { 1.0 } else { units::written(text, quantity)?.1 };
            Some(limits.over(size).ends())
        }
        Taken::Real(_, limits) => Some([if limits.ends()[0] >= 0.0 { 0.0 } else { f64::NEG_INFINITY }, f64::INFINITY]),
        _ => None,
    })
}

/// The ends of a slider around a value.
fn span(value: f64, [least, greatest]: [f64; 2]) -> Option<[f64; 2]> {
    let [low, high] = if value == 0.0 { [least, greatest] } else { [value * SPAN, value / SPAN] };
    let ends = [low.min(high).max(least), low.max(high).min(greatest)];
    // A zero says nothing about how large a value may sensibly be.
    (ends[0] < ends[1] && ends.iter().all(|end| end.is_finite() && end.abs() < 1e4 || value != 0.0)).then_some(ends)
}
