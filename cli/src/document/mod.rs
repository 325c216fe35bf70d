//! A TOML file, parsed once: its values with their places, which change by paths of keys, and its text with comments.
//!
//! A path names a key of a scene, `follower[2].cam.stroke`, and counts from 1. `toml` reads the file, since it goes on after a
//! syntax error; `toml_edit` writes it, since it keeps comments.

pub mod diagnostics;
pub mod input;
pub mod keys;
pub(crate) mod limits;
pub mod reference;
pub mod schema;
pub mod section;
pub mod source;
pub mod units;

pub use diagnostics::{Diagnostic, Diagnostics, meant, nearest};
pub use input::Kind;
pub use section::{Faults, Node, Section, TableNote, all};
use std::collections::BTreeMap;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Error};
use toml_edit::{DocumentMut, Item};

/// The bytes of a piece of the file.
pub type Span = Range<usize>;

/// The values of a table by their keys.
pub type TomlTable = BTreeMap<Spanned<String>, Spanned<Value>>;

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A string.
    Text(String),
    /// A whole number; None for more than 64 bits.
    Integer(Option<i64>),
    /// A number with a point or an exponent.
    Float(f64),
    /// true or false.
    Boolean(bool),
    /// A date or a time, which no key admits.
    Datetime,
    /// A list, also of tables.
    Array(Vec<Spanned<Value>>),
    /// A table, in any notation.
    Table(TomlTable),
}

impl Value {
    /// A value of a text that starts at this byte.
    fn read(value: &Spanned<DeValue<'_>>, from: usize) -> Spanned<Self> {
        let own = match value.get_ref() {
            DeValue::String(text) => Value::Text(text.to_string()),
            DeValue::Integer(number) => Value::Integer(i64::from_str_radix(number.as_str(), number.radix()).ok()),
            DeValue::Float(number) => Value::Float(number.as_str().parse().unwrap_or(f64::NAN)),
            DeValue::Boolean(value) => Value::Boolean(*value),
            DeValue::Datetime(_) => Value::Datetime,
            DeValue::Array(list) => Value::Array(list.iter().map(|item| Value::read(item, from)).collect()),
            DeValue::Table(inner) => Value::Table(table(inner, from)),
        };
        Spanned::new(moved(value.span(), from), own)
    }

    /// The word of TOML for its type.
    pub fn type_str(&self) -> &'static str {
        match self {
            Value::Text(_) => "string",
            Value::Integer(_) => "integer",
            Value::Float(_) => "float",
            Value::Boolean(_) => "boolean",
            Value::Datetime => "datetime",
            Value::Array(_) => "array",
            Value::Table(_) => "table",
        }
    }

    fn as_table(&self) -> Option<&TomlTable> {
        if let Value::Table(table) = self { Some(table) } else { None }
    }

    fn as_table_mut(&mut self) -> Option<&mut TomlTable> {
        if let Value::Table(table) = self { Some(table) } else { None }
    }

    /// The tables in this value, with their numbers if it is a list.
    pub fn tables(&self) -> Vec<(String, &TomlTable)> {
        match self {
            Value::Table(table) => vec![(String::new(), table)],
            Value::Array(list) => {
                let tables = list.iter().map(|item| item.get_ref().as_table()).collect::<Option<Vec<_>>>();
                (1..).zip(tables.unwrap_or_default()).map(|(i, table)| (format!("[{i}]"), table)).collect()
            }
            _ => Vec::new(),
        }
    }
}

fn table(read: &DeTable<'_>, from: usize) -> TomlTable {
    let entry = |(key, value): (&Spanned<_>, &_)| {
        let name: &toml::de::DeString<'_> = key.get_ref();
        (Spanned::new(moved(key.span(), from), name.to_string()), Value::read(value, from))
    };
    read.iter().map(entry).collect()
}

fn moved(span: Span, by: usize) -> Span {
    span.start + by..span.end + by
}

/// The path of the table around a key, and the key.
fn divided(path: &str) -> (&str, &str) {
    path.rsplit_once('.').unwrap_or(("", path))
}

/// The keys on the way to a table, each with its index from 0 if the path names one.
fn steps(path: &str) -> impl Iterator<Item = (&str, Option<usize>)> {
    path.split('.').filter(|_| !path.is_empty()).map(|step| {
        let (key, number) = step.strip_suffix(']').and_then(|rest| rest.split_once('[')).unwrap_or((step, ""));
        (key, number.parse().ok().map(|number: usize| number.wrapping_sub(1)))
    })
}

/// A TOML file with its changes.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// The file, followed by the new values.
    pub text: String,
    /// The length of the file.
    length: usize,
    /// Its values.
    pub table: TomlTable,
    /// Syntax errors; the values around them are valid.
    pub errors: Vec<Error>,
    /// Changed or removed values, by path.
    changes: Vec<(String, Option<Item>)>,
}

impl PartialEq for Document {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text && self.table == other.table
    }
}

impl Document {
    /// The document of this text.
    pub fn new(text: String) -> Self {
        let (read, mut errors) = DeTable::parse_recoverable(&text);
        errors.sort_by_key(|error| error.span().map_or(text.len(), |span| span.start));
        let table = table(read.get_ref(), 0);
        Document { length: text.len(), text, table, errors, changes: Vec::new() }
    }

    /// The text of the file without changes.
    pub fn file(&self) -> &str {
        &self.text[..self.length]
    }

    /// The place of a key other than a table: its value, or None inside if only its table exists. None for a key without a place.
    pub fn place(&self, path: &str) -> Option<Option<&Spanned<Value>>> {
        let (tables, key) = divided(path);
        let table =
            steps(tables).try_fold(&self.table, |table, (key, number)| match (table.get(key)?.get_ref(), number) {
                (Value::Table(inner), None) => Some(inner),
                (Value::Array(list), Some(number)) => list.get(number)?.get_ref().as_table(),
                _ => None,
            })?;
        let found = table.get(key);
        let has_place = !key.is_empty() && !key.ends_with(']');
        (has_place && found.is_none_or(|value| value.get_ref().tables().is_empty())).then_some(found)
    }

    /// The table around a key; creates missing ones.
    fn around(&mut self, tables: &str) -> Option<&mut TomlTable> {
        steps(tables).try_fold(&mut self.table, |table, (key, number)| {
            let made = || Spanned::new(0..0, Value::Table(TomlTable::new()));
            match (table.entry(Spanned::new(0..0, key.to_owned())).or_insert_with(made).get_mut(), number) {
                (Value::Table(inner), None) => Some(inner),
                (Value::Array(list), Some(number)) => list.get_mut(number)?.get_mut().as_table_mut(),
                _ => None,
            }
        })
    }

    /// Sets a key; None if it has no place in the file.
    pub fn set(&mut self, path: &str, value: impl Into<Item>) -> Option<()> {
        let item: Item = value.into();
        let written = item.clone().into_value().ok()?.to_string();
        let (from, (tables, key)) = (self.text.len() + 1, divided(path));
        let read = Value::read(&DeValue::parse(written.trim()).ok()?, from);
        self.around(tables)?.insert(Spanned::new(read.span(), key.to_owned()), read);
        self.text.extend(["\n", written.trim()]);
        self.changes.push((path.to_owned(), Some(item)));
        Some(())
    }

    /// Removes a key and everything below it.
    pub fn remove(&mut self, path: &str) {
        let (tables, key) = divided(path);
        self.around(tables).and_then(|table| table.remove(key));
        self.changes.push((path.to_owned(), None));
    }

    /// Renames the files in all keys `file`.
    pub fn name_files(&mut self, named: &dyn Fn(&str) -> String) {
        for (path, value) in values(&self.table.clone()) {
            if let (Value::Text(file), "file") = (value.get_ref(), divided(&path).1) {
                self.set(&path, named(file));
            }
        }
    }

    /// The whole text with its changes.
    pub fn whole_text(&self) -> String {
        if self.changes.is_empty() {
            return self.text.clone();
        }
        let mut document: DocumentMut = self.file().parse().unwrap_or_default();
        for (path, value) in &self.changes {
            let (tables, key) = divided(path);
            let around = steps(tables).fold(document.as_item_mut(), |around, (key, number)| {
                let inner = &mut around[key];
                if let Some(number) = number { &mut inner[number] } else { inner }
            });
            match (value, around.as_table_like_mut()) {
                (None, Some(table)) => drop(table.remove(key)),
                (Some(item), Some(table)) if !item.is_value() => drop(table.insert(key, item.clone())),
                (Some(item), _) => {
                    // A comment after the old value stays.
                    let decor = around.get(key).and_then(Item::as_value).map(|old| old.decor().clone());
                    around[key] = item.clone();
                    around[key].as_value_mut().zip(decor).into_iter().for_each(|(new, old)| *new.decor_mut() = old);
                }
                (None, None) => (),
            }
        }
        document.to_string()
    }
}

/// The values in a table and in its tables, with their paths.
pub fn values(table: &TomlTable) -> Vec<(String, &Spanned<Value>)> {
    let mut all = Vec::new();
    for (key, value) in table {
        let tables = value.get_ref().tables();
        if tables.is_empty() {
            all.push((key.get_ref().clone(), value));
        }
        for (number, inner) in tables {
            let path = |path: String| format!("{}{number}.{path}", key.get_ref());
            all.extend(values(inner).into_iter().map(|(inside, value)| (path(inside), value)));
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use toml_edit::Array;

    #[test]
    fn a_value_that_is_set_keeps_the_comment_after_it() {
        let mut document = Document::new("torques = [\"a\"] # of the press\ncam = { a = 1 } # flat\n".to_owned());
        document.set("torques", Array::from_iter(["a", "b"]));
        document.set("cam.b", 2);
        assert_eq!(document.whole_text(), "torques = [\"a\", \"b\"] # of the press\ncam = { a = 1 , b = 2 } # flat\n");
    }

    #[test]
    fn texts_longer_than_any_name_are_like_none() {
        assert_eq!(nearest(&"torque".repeat(1_000_000), &["torques"]), None);
        assert_eq!(nearest("torqes", &["torques"]), Some("torques"));
    }
}
