//! Tables as CSV: a line of headings NAME_UNIT, then a line for each row, numbers with all digits in the unit of the heading.

use super::table::{Column, Table, Value};
use super::unit::DEG;
use crate::text;
use camdrive::drives::Fault;

/// The kind of a column in a file.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Plain,
    /// Two columns: low and high end.
    Range,
    /// Two columns: the number and its angle.
    At,
}

fn kind(table: &Table, i: usize) -> Kind {
    let of = |value: &Value| match value {
        Value::Range(_) => Some(Kind::Range),
        Value::At(..) => Some(Kind::At),
        _ => None,
    };
    table.rows.iter().find_map(|row| of(&row[i])).unwrap_or(Kind::Plain)
}

fn headings(column: &Column, kind: Kind) -> Vec<String> {
    let unit = column.unit.key();
    let with = |name: &str| if unit.is_empty() { name.to_owned() } else { format!("{name}_{unit}") };
    let key = &column.key;
    match kind {
        Kind::Plain => vec![with(key)],
        Kind::Range => vec![with(&format!("{key}_low")), with(&format!("{key}_high"))],
        Kind::At => vec![with(key), format!("{key}_at_deg")],
    }
}

fn cells(value: &Value, column: &Column, kind: Kind) -> Vec<String> {
    // A zero has no sign, an integer no fraction.
    let shortest = |value: f64| format!("{:?}", value + 0.0).trim_end_matches(".0").to_owned();
    let number = |value: f64| if value.is_finite() { shortest(value) } else { String::new() };
    let scaled = |value: f64| number(value * column.unit.factor);
    let mut cells = match value {
        Value::Empty => Vec::new(),
        Value::Text(text) => vec![text.clone()],
        Value::Number(value) | Value::AtMost(value) => vec![scaled(*value)],
        Value::Range(ends) => ends.map(scaled).to_vec(),
        Value::At(value, phi) => vec![scaled(*value), number(phi * DEG.factor)],
    };
    cells.resize(if kind == Kind::Plain { 1 } else { 2 }, String::new());
    cells
}

/// The table; what is not known or infinite is empty.
///
/// # Errors
/// None in practice: the writer fills memory.
pub fn write(table: &Table) -> Result<String, Fault> {
    let kinds: Vec<Kind> = (0..table.columns.len()).map(|i| kind(table, i)).collect();
    let line = |cells: &dyn Fn(usize) -> Vec<String>| (0..kinds.len()).flat_map(cells).collect::<Vec<_>>();
    let head = line(&|i| headings(&table.columns[i], kinds[i]));
    let rows = table.rows.iter().map(|row| line(&|i| cells(&row[i], &table.columns[i], kinds[i])));
    text::csv(std::iter::once(head).chain(rows))
}
