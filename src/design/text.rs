//! What the reports share: numbers for people, tables for a terminal, CSV, JSON.

use crate::drives::Fault;
use serde::Serialize;

/// A table of texts.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// One heading per column.
    pub head: Vec<String>,
    /// The cells.
    pub rows: Vec<Vec<String>>,
}

/// "–", where there is nothing to say.
pub const NONE: &str = "–";

/// Three significant digits, in powers of ten outside of 0.01 … 1e6.
pub fn number(value: f64) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    // The sum makes 0 of a negative zero.
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value) + 0.0;
    if rounded == 0.0 || (1e-2..1e6).contains(&rounded.abs()) {
        // Zero has no sign for a reader.
        return (rounded + 0.0).to_string();
    }
    // An error of 3.214e-9 is one of 3.2e-9.
    let short: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    format!("{short:e}")
}

/// A duration with a unit that suits it.
pub fn time(seconds: f64) -> String {
    let (unit, scale) = [("s", 1.0), ("ms", 1e3), ("µs", 1e6), ("ns", 1e9)]
        .into_iter()
        .find(|(_, scale)| (seconds * scale).abs() >= 0.9995)
        .unwrap_or(("ns", 1e9));
    format!("{} {unit}", number(seconds * scale))
}

/// A change relative to the largest value, as people say it.
pub fn share(change: f64) -> String {
    if change >= 10.0 {
        format!("{} times its largest value", number(change))
    } else if change >= 1e-4 {
        format!("{} %", number(100.0 * change))
    } else {
        format!("{} of its largest value", number(change))
    }
}

impl Table {
    /// The table in columns for a terminal.
    pub fn text(&self) -> String {
        let width = |i: usize| {
            let cells = self.rows.iter().map(|row| &row[i]).chain([&self.head[i]]);
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.head.len()).map(width).collect();
        let line = |row: &Vec<String>| {
            let cells = row.iter().zip(&widths).map(|(cell, width)| format!("  {cell:<width$}"));
            cells.collect::<String>().trim_end().to_owned() + "\n"
        };
        std::iter::once(&self.head).chain(&self.rows).map(line).collect()
    }
}

/// A table of numbers as CSV.
///
/// # Errors
/// None in practice: the writer fills memory.
pub fn csv<S: AsRef<[u8]>>(head: &[&str], rows: impl IntoIterator<Item = Vec<S>>) -> Result<String, Fault> {
    let fault = |e: &dyn std::fmt::Display| Fault(format!("the table cannot be written as CSV: {e}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(head).map_err(|e| fault(&e))?;
    for row in rows {
        writer.write_record(&row).map_err(|e| fault(&e))?;
    }
    let bytes = writer.into_inner().map_err(|e| fault(&e))?;
    String::from_utf8(bytes).map_err(|e| fault(&e))
}

/// A whole report; what is infinite becomes null.
///
/// # Errors
/// None in practice: no report holds anything that JSON has no form for.
pub fn json(report: &impl Serialize) -> Result<String, Fault> {
    let text = serde_json::to_string_pretty(report);
    text.map(|text| text + "\n").map_err(|e| Fault(format!("the report cannot be written as JSON: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        let pairs = [
            (0.0, "0"),
            (-0.0, "0"),
            (1e-6, "1e-6"),
            (3.214e-9, "3.2e-9"),
            (512.34, "512"),
            (0.33333, "0.333"),
            (2e7, "2e7"),
        ];
        for (value, text) in pairs {
            assert_eq!(number(value), text);
        }
        assert_eq!((time(3.3334e-4), time(2.0), time(1e-5)), ("333 µs".into(), "2 s".into(), "10 µs".into()));
        assert_eq!((share(0.123), share(35.0)), ("12.3 %".into(), "35 times its largest value".into()));
        assert_eq!(share(2e-9), "2e-9 of its largest value");
    }
}
