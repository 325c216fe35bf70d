//! Typed tables: one definition of a column serves terminal, CSV and page.

use super::rounding::Rounding;
use super::unit::Unit;
use std::ops::{Deref, DerefMut};

/// A cell; numbers in coherent SI.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Nothing to say.
    Empty,
    /// A word.
    Text(String),
    /// A number.
    Number(f64),
    /// A number that is this or less: more is not known of it.
    AtMost(f64),
    /// All numbers between two, of which the latter may be infinite.
    Range([f64; 2]),
    /// A number, and the angle of the shaft (rad) where it is.
    At(f64, f64),
}

impl From<f64> for Value {
    fn from(value: f64) -> Self {
        if value.is_nan() { Value::Empty } else { Value::Number(value) }
    }
}

impl From<usize> for Value {
    fn from(value: usize) -> Self {
        Value::Number(value as f64)
    }
}

impl From<[f64; 2]> for Value {
    fn from(ends: [f64; 2]) -> Self {
        Value::Range(ends)
    }
}

impl From<String> for Value {
    fn from(text: String) -> Self {
        if text.is_empty() { Value::Empty } else { Value::Text(text) }
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl From<&String> for Value {
    fn from(text: &String) -> Self {
        text.clone().into()
    }
}

impl From<bool> for Value {
    fn from(value: bool) -> Self {
        Value::Text(if value { "yes" } else { "no" }.to_owned())
    }
}

impl<V: Into<Value>> From<Option<V>> for Value {
    fn from(value: Option<V>) -> Self {
        value.map_or(Value::Empty, Into::into)
    }
}

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name in files, "speed" of speed_rpm.
    pub key: String,
    /// Its heading for people, without the unit.
    pub heading: String,
    /// The unit that people and CSV have.
    pub unit: Unit,
    /// Significant digits for people.
    pub digits: usize,
    /// To which side limits are rounded for people; None of what is rounded to the nearest number.
    pub rounding: Option<Rounding>,
    /// True if it stands in the file alone.
    pub file_only: bool,
}

/// A table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The ending of its file, "orders" of NAME.orders.csv; None of a table without file.
    pub key: Option<String>,
    /// Its title; a table without title stands in its file alone.
    pub title: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// The cells, row by row.
    pub rows: Vec<Vec<Value>>,
    /// Sentences below it.
    pub below: Vec<String>,
}

/// A table that grows column by column over its rows.
pub struct Rows<'a, R> {
    rows: Vec<&'a R>,
    table: Table,
}

impl Table {
    /// A table over these rows, under a title.
    pub fn of<'a, R>(title: impl Into<String>, rows: impl IntoIterator<Item = &'a R>) -> Rows<'a, R> {
        let rows: Vec<&R> = rows.into_iter().collect();
        let cells = vec![Vec::new(); rows.len()];
        Rows {
            rows,
            table: Table { key: None, title: title.into(), columns: Vec::new(), rows: cells, below: Vec::new() },
        }
    }

    /// A table that stands in the file NAME.key.csv alone.
    pub fn file<'a, R>(key: &str, rows: impl IntoIterator<Item = &'a R>) -> Rows<'a, R> {
        Table::of("", rows).key(key)
    }
}

impl<'a, R> Rows<'a, R> {
    /// Writes the table into the file NAME.key.csv as well; NAME.csv where the key is empty.
    pub fn key(mut self, key: &str) -> Self {
        self.table.key = Some(key.to_owned());
        self
    }

    /// Adds a column: its name in files, its heading for people, its unit, its cells in SI.
    pub fn column<V: Into<Value>>(
        self,
        key: impl Into<String>,
        heading: impl Into<String>,
        unit: Unit,
        cell: impl Fn(&'a R) -> V,
    ) -> Self {
        let column =
            Column { key: key.into(), heading: heading.into(), unit, digits: 3, rounding: None, file_only: false };
        self.with(column, &|row| cell(row).into())
    }

    // Compiled once for each kind of rows, not for each column.
    fn with(mut self, column: Column, cell: &dyn Fn(&'a R) -> Value) -> Self {
        self.table.columns.push(column);
        for (cells, row) in self.table.rows.iter_mut().zip(&self.rows) {
            cells.push(cell(row));
        }
        self
    }

    /// Adds a column of the file alone.
    pub fn hidden<V: Into<Value>>(mut self, key: impl Into<String>, unit: Unit, cell: impl Fn(&'a R) -> V) -> Self {
        self = self.column(key, "", unit, cell);
        self.table.columns.iter_mut().for_each(|column| column.file_only |= column.heading.is_empty());
        self
    }

    /// Significant digits of the column that was added last.
    pub fn digits(mut self, digits: usize) -> Self {
        self.table.columns.iter_mut().rev().take(1).for_each(|column| column.digits = digits);
        self
    }

    /// Rounds the limits in the column that was added last to their safe side.
    pub fn rounded(mut self, rounding: Rounding) -> Self {
        self.table.columns.iter_mut().rev().take(1).for_each(|column| column.rounding = Some(rounding));
        self
    }

    /// Sentences below the table.
    pub fn below(mut self, lines: impl IntoIterator<Item = String>) -> Self {
        self.table.below.extend(lines);
        self
    }
}

impl<R> From<Rows<'_, R>> for Table {
    fn from(rows: Rows<'_, R>) -> Self {
        rows.table
    }
}

impl<R> Deref for Rows<'_, R> {
    type Target = Table;

    fn deref(&self) -> &Table {
        &self.table
    }
}

impl<R> DerefMut for Rows<'_, R> {
    fn deref_mut(&mut self) -> &mut Table {
        &mut self.table
    }
}
