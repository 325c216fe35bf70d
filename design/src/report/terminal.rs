//! Reports as text for a terminal.

use super::table::{Column, Table, Value};
use super::{Block, Report, Unit};
use crate::documentation::Equation;
use crate::text::{self, NONE, Page, digits};
use camdrive::drives::rigid_machine::linkage::in_turn;

/// A number for people in a unit: three significant digits.
pub fn shown(value: f64, unit: &Unit) -> String {
    let unit = unit.sized(value);
    unit.after(with_minus(text::number(value * unit.factor)))
}

/// A number with a minus sign for its hyphen; that of a power of ten stays.
fn with_minus(number: String) -> String {
    match number.strip_prefix('-') {
        Some(size) => format!("−{size}"),
        None => number,
    }
}

/// An interval for people: "12.1 to 13.4 rpm", "above 12.1 rpm", in as many digits as distinguish its ends.
pub fn range(ends: [f64; 2], unit: &Unit) -> String {
    interval(ends.map(|end| end * unit.factor), &|text| unit.after(text))
}

/// A number between two others, in as many digits as these have in [`range`].
pub fn among(value: f64, ends: [f64; 2], unit: &Unit) -> String {
    let value = value * unit.factor;
    let text = decimals(ends.map(|end| end * unit.factor)).map(|decimals| format!("{value:.decimals$}"));
    unit.after(text.unwrap_or_else(|| text::number(value)))
}

/// The decimals that distinguish two ends; None if any do.
fn decimals([low, high]: [f64; 2]) -> Option<usize> {
    let size = low.abs().max(high.abs());
    let needed = if high > low { (size / (high - low)).log10().ceil().max(0.0) as usize + 1 } else { 4 };
    let near = size > 0.0 && 2.0 * low.abs().min(high.abs()) >= size && (1e-2..1e6).contains(&size);
    near.then(|| (needed.clamp(3, 15) as i32 - 1 - size.log10().floor() as i32).max(0) as usize)
}

fn interval([low, high]: [f64; 2], named: &dyn Fn(String) -> String) -> String {
    let number = |value: f64| with_minus(text::number(value));
    if high.is_infinite() {
        return format!("above {}", named(number(low)));
    }
    let Some(decimals) = decimals([low, high]) else {
        return format!("{} to {}", number(low), named(number(high)));
    };
    if high > low {
        let [low, high] = [low, high].map(|end| with_minus(format!("{end:.decimals$}")));
        format!("{low} to {}", named(high))
    } else {
        named(number(low))
    }
}

/// A number below this part of the largest one of its column is only rounding.
const ROUNDING: f64 = 1e-12;

/// A cell in the unit of its column, which stands in the heading; numbers below `least` (SI) read 0, bounds do not.
fn cell(value: &Value, column: &Column, least: f64) -> String {
    let told = |value: f64| if value.abs() < least { 0.0 } else { value };
    let number = |value: f64| match (value * column.unit.factor, column.digits, column.rounding) {
        (value, ..) if value.is_infinite() => "∞".to_owned(),
        (value, count, Some(rounding)) => rounding.number(value, count),
        (value, 3, None) => text::number(value),
        (value, count, None) => digits(value, count, -4),
    };
    let number = |value: f64| with_minus(number(value));
    let interval = |ends: [f64; 2]| match column.rounding {
        Some(rounding) => rounding.text(ends, rounding.digits(ends), &|text| text),
        None => interval(ends, &|text| text),
    };
    match value {
        Value::Empty => NONE.to_owned(),
        Value::Text(text) => text.clone(),
        Value::Number(value) => number(told(*value)),
        Value::AtMost(value) => format!("< {}", number(*value)),
        Value::Range(ends) => interval(ends.map(|end| end * column.unit.factor)),
        Value::At(value, phi) => format!("{} at {}°", number(told(*value)), in_turn(*phi, 1)),
    }
}

/// The heading of a column with its unit.
pub fn heading(column: &Column) -> String {
    if column.unit.name.is_empty() {
        column.heading.clone()
    } else {
        format!("{} [{}]", column.heading, column.unit.name)
    }
}

/// The columns that people see: those that are not for files alone and say something.
pub fn seen(table: &Table) -> Vec<usize> {
    let says = |i: &usize| !table.columns[*i].file_only && table.rows.iter().any(|row| row[*i] != Value::Empty);
    (0..table.columns.len()).filter(says).collect()
}

/// The cells that people see, with their headings.
pub fn cells(table: &Table) -> text::TextTable {
    let seen = seen(table);
    let head = seen.iter().map(|i| heading(&table.columns[*i])).collect();
    let size = |value: &Value| match value {
        Value::Number(value) | Value::At(value, _) if value.is_finite() => value.abs(),
        _ => 0.0,
    };
    let least = |i: &usize| ROUNDING * table.rows.iter().map(|row| size(&row[*i])).fold(0.0, f64::max);
    let least: Vec<f64> = seen.iter().map(least).collect();
    let row = |row: &Vec<Value>| {
        seen.iter().zip(&least).map(|(i, least)| cell(&row[*i], &table.columns[*i], *least)).collect()
    };
    text::TextTable { head, rows: table.rows.iter().map(row).collect() }
}

impl Report {
    /// The report in lines of this width: verdict, tables, sentences; what explains where that is asked for.
    pub fn text(&self, width: usize, explain: bool) -> String {
        let mut page = Page::new(format!("{}: {}", self.name, self.study), width);
        for (heading, sentences) in self.verdict.parts() {
            page.section(heading, sentences);
        }
        let explained = self.explained.iter().filter(|_| explain);
        for block in self.body.iter().chain(explained) {
            match block {
                Block::Table(table) if table.title.is_empty() || table.rows.is_empty() => continue,
                Block::Table(table) => page.table(&table.title, &cells(table)).section("", &table.below),
                Block::Lines(title, lines) => page.section(title, lines),
                Block::Equations(title, equations) => page.section(title, equations.iter().map(Equation::line)),
                Block::Code(title, sentence, code) => page.section(title, [sentence]).lines(code.lines()),
                Block::File(title, name, place) => page.section(title, [format!("{name}: {place}")]),
            };
        }
        page.text()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::rounding::Rounding;
    use crate::report::unit::RPM;

    #[test]
    fn columns_of_limits_are_rounded_to_the_safe_side() {
        let rows = [[157.4 / RPM.factor, 207.292 / RPM.factor]];
        let table: Table = Table::of("Limits", &rows)
            .column("range", "range", RPM, |row| *row)
            .rounded(Rounding::Outward)
            .column("least", "least", RPM, |row| row[1])
            .rounded(Rounding::Outward)
            .column("largest", "largest", RPM, |row| row[1])
            .rounded(Rounding::Inward)
            .into();
        assert_eq!(cells(&table).rows, [["157 to 208", "208", "207"]]);
    }
}
