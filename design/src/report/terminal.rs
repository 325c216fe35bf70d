//! Reports as text for a terminal.

use super::table::{Column, Table, Value};
use super::{Block, Report, Unit};
use crate::text::{self, NONE, Page, digits};
use camdrive::drives::rigid_machine::linkage::in_turn;

/// A number for people in a unit: three significant digits.
pub fn shown(value: f64, unit: &Unit) -> String {
    with_unit(text::number(value * unit.factor), unit)
}

/// An interval for people: "12.1 to 13.4 rpm", "from 12.1 rpm on", in as many digits as tell its ends apart.
pub fn range(ends: [f64; 2], unit: &Unit) -> String {
    interval(ends.map(|end| end * unit.factor), &|text| with_unit(text, unit))
}

/// Intervals that a sentence lists.
const LISTED: usize = 4;
/// Significant digits of limits, more where they lie close together.
const DIGITS: usize = 3;
/// Those that rounding of the computation leaves.
const EXACT: usize = 12;
/// Rounding changes the length of an interval by no more than this part.
const CHANGED: f64 = 0.1;

/// To which side limits are rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rounding {
    /// What is to be avoided, or a least value: ends lie outside of their interval, numbers above.
    Outward,
    /// What is admissible, or a largest value: ends lie within their interval, numbers below.
    Inward,
}

/// An interval (SI) whose ends are those of so many digits in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounded {
    /// Its ends.
    pub ends: [f64; 2],
    /// The significant digits of both.
    pub digits: usize,
}

impl Rounding {
    /// A number, whose size is rounded.
    fn number(self, value: f64, digits: usize) -> String {
        text::digits_beyond(value, digits, self == Rounding::Outward)
    }

    /// The ends of an interval.
    fn ends(self, [low, high]: [f64; 2], digits: usize) -> [String; 2] {
        let end = |value: f64, up: bool| text::digits_beyond(value, digits, up == (value > 0.0));
        [end(low, self == Rounding::Inward), end(high, self == Rounding::Outward)]
    }

    /// The digits that keep the length of an interval.
    fn digits(self, [low, high]: [f64; 2]) -> usize {
        let parsed = |text: &String| text.parse().unwrap_or(f64::NAN);
        let fits = |digits: &usize| {
            let [from, to] = self.ends([low, high], *digits).each_ref().map(parsed);
            ((to - from) - (high - low)).abs() <= CHANGED * (high - low)
        };
        if high.is_finite() { (DIGITS..EXACT).find(fits).unwrap_or(EXACT) } else { DIGITS }
    }

    /// "157 to 208", "from 720 on".
    fn text(self, ends: [f64; 2], digits: usize, named: &dyn Fn(String) -> String) -> String {
        match (self.ends(ends, digits), ends[1].is_finite()) {
            ([low, _], false) => format!("from {} on", named(low)),
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

    /// "157 to 208 rpm, from 720 rpm on", the first of them where there are many.
    pub fn list(self, intervals: &[Rounded], unit: &Unit) -> String {
        let one =
            |of: &Rounded| self.text(of.ends.map(|end| end * unit.factor), of.digits, &|text| with_unit(text, unit));
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

/// A number, written out, with its unit.
pub fn with_unit(text: String, unit: &Unit) -> String {
    match &*unit.name {
        "" => text,
        "°" => text + "°",
        name => format!("{text} {name}"),
    }
}

/// A number between two others, in as many digits as these have in [`range`].
pub fn among(value: f64, ends: [f64; 2], unit: &Unit) -> String {
    let value = value * unit.factor;
    let text = decimals(ends.map(|end| end * unit.factor)).map(|decimals| format!("{value:.decimals$}"));
    with_unit(text.unwrap_or_else(|| text::number(value)), unit)
}

/// The decimals that tell two ends apart; None of ends so far apart that any do.
fn decimals([low, high]: [f64; 2]) -> Option<usize> {
    let size = low.abs().max(high.abs());
    let needed = if high > low { (size / (high - low)).log10().ceil().max(0.0) as usize + 2 } else { 4 };
    let near = size > 0.0 && 2.0 * low.abs().min(high.abs()) >= size && (1e-2..1e6).contains(&size);
    near.then(|| (needed.clamp(3, 15) as i32 - 1 - size.log10().floor() as i32).max(0) as usize)
}

fn interval([low, high]: [f64; 2], named: &dyn Fn(String) -> String) -> String {
    if high.is_infinite() {
        return format!("from {} on", named(text::number(low)));
    }
    let Some(decimals) = decimals([low, high]) else {
        return format!("{} to {}", text::number(low), named(text::number(high)));
    };
    if high > low {
        format!("{low:.decimals$} to {}", named(format!("{high:.decimals$}")))
    } else {
        named(text::number(low))
    }
}

/// What is smaller than this part of the largest number of its column is only rounding.
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
pub fn cells(table: &Table) -> text::Table {
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
    text::Table { head, rows: table.rows.iter().map(row).collect() }
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
            };
        }
        page.text()
    }
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
            ([1623.34, f64::INFINITY], "from 1620 rpm on", "from 1630 rpm on"),
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
