//! The values of a scene that a reader of its page may move.

use crate::document::keys::{Dimension, Key, KeyTable, SCENE, Value as Taken};
use crate::document::units;
use crate::document::{Document, Value, values};
use camdrive_design::text;
use toml::Spanned;

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

/// A longer list is a table of points: its numbers have no sliders.
const MOST: usize = 16;

/// A slider goes from this part of a value to its inverse.
const SPAN: f64 = 1.0 / 3.0;

/// Significant digits of the ends of a slider: as many as people read.
const DIGITS: usize = 3;

/// The numbers of a scene, speed first, the others in the order of the file.
pub fn dials(document: &Document) -> Vec<Dial> {
    let all = values(&document.table).into_iter();
    let moving = all.filter(|(key, _)| !key.split(['.', '[']).any(|part| STILL.contains(&part)));
    let single = moving.flat_map(|(key, value)| match value.get_ref() {
        Value::Array(list) if list.len() <= MOST => {
            // A zero in a list may become as large as the others.
            let size = list.iter().filter_map(|item| number(item.get_ref())).map(|(_, x)| x.abs()).fold(0.0, f64::max);
            let from = first(&key);
            (from..).zip(list).map(|(i, item)| (format!("{key}[{i}]"), item, size)).collect()
        }
        _ => vec![(key, value, 0.0)],
    });
    let read = single.filter_map(|(key, value, size)| {
        let ((text, number), declared) = (number(value.get_ref())?, declared(&SCENE, &key)?);
        let dial = Dial { key, meaning: declared.meaning.trim(), text, value: number, ends: None };
        Some((declared, value.span().start, size, dial))
    });
    let read: Vec<(&Key, usize, f64, Dial)> = read.collect();
    let unit = |text: &str| units::split(text.trim()).1.to_owned();
    let mut found: Vec<(bool, usize, Dial)> = (read.iter())
        .filter_map(|(declared, place, size, dial)| {
            let mut dial = dial.clone();
            // A plain zero has the unit of its neighbours.
            let near = read.iter().filter(|(of, .., other)| {
                let is_like =
                    element(&dial.key).is_some() || unit_of(declared).is_some_and(|own| unit_of(of) == Some(own));
                is_like && section(&other.key) == section(&dial.key)
            });
            let units = near.map(|(.., other)| unit(&other.text)).find(|unit| !unit.is_empty());
            if let Some(unit) = units.filter(|_| dial.value == 0.0 && unit(&dial.text).is_empty()) {
                dial.text = format!("0 {unit}");
            }
            dial.ends = span(dial.value, *size, limits(declared, &dial.text)?);
            let is_speed = ["drive.speed", "motor.w_s"].contains(&dial.key.as_str());
            Some((!is_speed, *place, dial))
        })
        .collect();
    found.sort_by_key(|(later, place, _)| (*later, *place));
    found.into_iter().map(|(.., dial)| dial).collect()
}

/// The text of a number with or without a unit, and the number.
fn number(value: &Value) -> Option<(String, f64)> {
    let text = match value {
        Value::Text(text) => text.clone(),
        Value::Float(number) => number.to_string(),
        Value::Integer(Some(number)) => number.to_string(),
        _ => return None,
    };
    let number = units::split(text.trim()).0.parse().ok()?;
    Some((text, number))
}

/// The number of the first item of a list: a series begins with its mean, a₀.
fn first(list: &str) -> usize {
    usize::from(list != "a" && !list.ends_with(".a"))
}

/// The list and the place from 0 of a key like "cam.a[3]".
pub fn element(key: &str) -> Option<(&str, usize)> {
    let (list, number) = key.strip_suffix(']')?.rsplit_once('[')?;
    Some((list, number.parse::<usize>().ok()?.checked_sub(first(list))?))
}

/// The unit of FMI of a key whose quantity is always the same.
fn unit_of(key: &Key) -> Option<&'static str> {
    let of =
        |value: &Taken| if let Taken::Real(Dimension::Fixed(quantity), _) = value { Some(quantity.unit) } else { None };
    key.values.iter().find_map(of)
}

/// The list of an element, the section of another key.
pub fn section(key: &str) -> &str {
    element(key).map_or_else(|| key.rsplit_once('.').map_or("", |(section, _)| section), |(list, _)| list)
}

/// A value as a scene has it: a number, or a text.
pub fn written(text: &str) -> toml_edit::Value {
    let number = text.parse::<i64>().map(toml_edit::Value::from);
    number.or_else(|_| text.parse::<f64>().map(toml_edit::Value::from)).unwrap_or_else(|_| text.into())
}

/// This list of a document with another text at a place.
pub fn list_with(document: &Document, list: &str, at: usize, text: &str) -> toml_edit::Value {
    let all = values(&document.table);
    let items = all.iter().find(|(key, _)| key == list).map_or(&[][..], |(_, value)| match value.get_ref() {
        Value::Array(items) => items,
        _ => &[],
    });
    let own = |(i, item): (usize, &Spanned<Value>)| match number(item.get_ref()) {
        _ if i == at => written(text),
        own => written(&own.map_or(String::new(), |(text, _)| text)),
    };
    toml_edit::Array::from_iter(items.iter().enumerate().map(own)).into()
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
        Taken::Reals(_) => Some([f64::NEG_INFINITY, f64::INFINITY]),
        Taken::Real(_, limits) => Some([if limits.ends()[0] >= 0.0 { 0.0 } else { f64::NEG_INFINITY }, f64::INFINITY]),
        _ => None,
    })
}

/// The ends of a slider around a value, in a list with numbers of this size.
fn span(value: f64, size: f64, [least, greatest]: [f64; 2]) -> Option<[f64; 2]> {
    let [low, high] = match value == 0.0 {
        true if size > 0.0 => [-size, size],
        true => [least, greatest],
        false => [value * SPAN, value / SPAN].map(|end| text::rounded(end, DIGITS)),
    };
    let ends = [low.min(high).max(least), low.max(high).min(greatest)];
    // A zero says nothing about how large a value may sensibly be.
    (ends[0] < ends[1] && ends.iter().all(|end| end.is_finite() && end.abs() < 1e4 || value != 0.0)).then_some(ends)
}
