//! Parts of all reports: numbers for people, tables for a terminal, CSV, JSON.

use camdrive::drives::Fault;
use serde::Serialize;
use std::f64::consts::TAU;
use std::fmt::Display;

/// A table of texts.
#[derive(Clone, Debug, PartialEq)]
pub struct TextTable {
    /// One heading per column.
    pub head: Vec<String>,
    /// The cells.
    pub rows: Vec<Vec<String>>,
}

/// "–", for an empty cell.
pub const NONE: &str = "–";

/// Three significant digits, in powers of ten outside of 0.01 … 1e6.
pub fn number(value: f64) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    let plain = rounded(value, 3);
    if plain == 0.0 || (1e-2..1e6).contains(&plain.abs()) {
        return plain.to_string();
    }
    // An error of 3.214e-9 is shown as 3.2e-9.
    format!("{:e}", rounded(value, 2))
}

/// The nearest number of this many significant digits. Numbers that differ by roundings of their computation look the same,
/// also on both sides of a tie.
pub fn rounded(value: f64, count: usize) -> f64 {
    let as_number = |value: f64, digits: usize| format!("{value:.0$e}", digits - 1).parse().unwrap_or(value);
    // The sum makes 0 of a negative zero, which has no sign for a reader.
    as_number(as_number(value, count.max(12)), count) + 0.0
}

/// The value, or 0 if it is only rounding next to values of this size.
pub fn clean(value: f64, size: f64) -> f64 {
    if value.abs() <= 1e-9 * size { 0.0 } else { value }
}

/// "1 point", "3 points".
pub fn counted(count: impl Display, noun: &str) -> String {
    let count = count.to_string();
    let end = if count == "1" { "" } else { "s" };
    format!("{count} {noun}{end}")
}

/// This many significant digits, in powers of ten outside of 10^`low` … 1e6.
pub fn digits(value: f64, count: usize, low: i32) -> String {
    let rounded = rounded(value, count);
    let plain = rounded == 0.0 || (10f64.powi(low)..1e6).contains(&rounded.abs());
    if plain { rounded.to_string() } else { format!("{rounded:e}") }
}

/// Three significant digits of a size, or as many more, up to seven, as show on which side of 1 it is.
pub fn digits_beside_one(sizes: &[f64]) -> usize {
    let is_apart = |count: &usize| sizes.iter().all(|size| rounded(*size, *count) != 1.0 || rounded(*size, 7) == 1.0);
    (3..7).find(is_apart).unwrap_or(7)
}

/// An angle (rad) of the turn; the end of a turn is no beginning.
pub fn in_a_turn(phi: f64) -> f64 {
    if phi > TAU * (1.0 + 1e-9) { phi.rem_euclid(TAU) } else { phi }
}

/// Three significant digits, or as many more, up to `most`, as distinguish these numbers.
pub fn distinguishing(numbers: &[f64], most: usize) -> usize {
    let different = |count: usize| {
        let mut all: Vec<f64> = numbers.iter().map(|value| rounded(*value, count)).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all.len()
    };
    (3..most).find(|count| different(*count) == different(most)).unwrap_or(most)
}

/// The next number above or below with this many significant digits, powers of ten as in [`number`].
pub fn digits_beyond(value: f64, count: usize, up: bool) -> String {
    let (size, nearest) = (rounded(value.abs(), count.max(12)), rounded(value.abs(), count));
    if nearest == 0.0 || !nearest.is_finite() {
        return digits(value, count, -4);
    }
    // The last digit of the nearest one.
    let last = 10f64.powi(nearest.log10().floor() as i32 + 1 - count as i32);
    let moved = match up {
        true if nearest < size => nearest + last,
        false if nearest > size => nearest - last,
        _ => nearest,
    };
    digits(moved.copysign(value), count, -4)
}

/// A speed (rad/s) in revolutions per minute, in the digits of a setting.
pub fn rpm(speed: f64) -> String {
    digits(speed * 60.0 / TAU, 5, -4)
}

/// Why a file cannot be read, without the number of the system's error.
pub fn reason(error: &std::io::Error) -> String {
    error.to_string().split(" (os error ").next().unwrap_or_default().to_owned()
}

/// A unit that suits a duration, and the number of these units in a second.
fn unit_of_time(seconds: f64) -> (&'static str, f64) {
    let fits = |(_, scale): &(&str, f64)| (seconds * scale).abs() >= 0.9995;
    [("s", 1.0), ("ms", 1e3), ("µs", 1e6), ("ns", 1e9)].into_iter().find(fits).unwrap_or(("ns", 1e9))
}

/// A duration with a unit that suits it.
pub fn time(seconds: f64) -> String {
    let (unit, scale) = unit_of_time(seconds);
    format!("{} {unit}", number(seconds * scale))
}

/// An admissible duration, rounded down.
pub fn time_within(seconds: f64) -> String {
    let (unit, scale) = unit_of_time(seconds);
    format!("{} {unit}", digits_beyond(seconds * scale, 3, false))
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

/// A last column with cells of more characters than this is prose, and a narrower one reads badly.
const PROSE: usize = 40;

/// The most columns that are repeated to identify rows.
const MOST_REPEATED: usize = 3;

/// Indent of prose below its row.
const BELOW: usize = 6;

impl TextTable {
    /// A table of these rows; its headings are separated by two blanks.
    pub fn new(head: &str, rows: impl IntoIterator<Item = Vec<String>>) -> Self {
        TextTable { head: head.split("  ").map(str::to_owned).collect(), rows: rows.into_iter().collect() }
    }

    /// The table in columns for lines of `width` characters. If it is wider, prose in the last column is wrapped or stands
    /// below its row; then the widest columns are wrapped. Columns that still do not fit follow below, each time next to the
    /// columns that identify the rows.
    pub fn text(&self, width: usize) -> String {
        let of = |i: usize, measure: fn(&str) -> usize| {
            let cells = self.rows.iter().map(|row| &row[i]).chain([&self.head[i]]);
            cells.map(|cell| measure(cell)).max().unwrap_or(0)
        };
        let natural: Vec<usize> = (0..self.head.len()).map(|i| of(i, characters)).collect();
        let least: Vec<usize> = (0..self.head.len()).map(|i| of(i, longest_word)).collect();
        let total = |widths: &[usize]| widths.iter().map(|width| width + 2).sum::<usize>();
        let last = natural.len().saturating_sub(1);
        let below = total(&natural) > width
            && self.rows.iter().any(|row| PROSE < characters(&row[last]))
            && total(&natural[..last]) + 2 + PROSE > width;
        let distinct = |count: &usize| {
            let mut keys: Vec<&[String]> = self.rows.iter().map(|row| &row[..(*count).min(row.len())]).collect();
            keys.sort_unstable();
            keys.windows(2).all(|pair| pair[0] != pair[1])
        };
        let repeated = (1..=MOST_REPEATED).find(distinct).unwrap_or(1);
        let mut blocks = vec![Vec::new()];
        for i in 0..natural.len() - usize::from(below) {
            let block = &blocks[blocks.len() - 1];
            let used: usize = block.iter().map(|i: &usize| least[*i] + 2).sum();
            if repeated < block.len() && width < used + least[i] + 2 {
                blocks.push((0..repeated).collect());
            }
            if let Some(block) = blocks.last_mut() {
                block.push(i);
            }
        }
        let mut out = String::new();
        for (number, block) in blocks.iter().enumerate() {
            let mut widths: Vec<usize> = block.iter().map(|i| natural[*i]).collect();
            while width < total(&widths) {
                let can_yield = (0..block.len()).filter(|k| least[block[*k]] < widths[*k]);
                let Some(widest) = can_yield.max_by_key(|k| widths[*k]) else { break };
                widths[widest] -= 1;
            }
            if 0 < number {
                out.push('\n');
            }
            for row in std::iter::once(&self.head).chain(&self.rows) {
                out += &lines(block.iter().map(|i| row[*i].as_str()).zip(widths.iter().copied()).collect());
                if below && number + 1 == blocks.len() && !row[last].is_empty() {
                    out += &wrapped(&format!("{:BELOW$}{}", "", row[last]), width);
                    out.push('\n');
                }
            }
        }
        out
    }
}

/// A report for a terminal, section by section.
pub struct Page {
    text: String,
    width: usize,
}

impl Page {
    /// A page that begins with this line, its tables for lines of `width` characters.
    pub fn new(title: impl Display, width: usize) -> Self {
        Page { text: format!("{title}\n"), width }
    }

    /// Lines without a change.
    pub fn lines(&mut self, lines: impl IntoIterator<Item = impl Display>) -> &mut Self {
        self.text.extend(lines.into_iter().map(|line| format!("{line}\n")));
        self
    }

    /// Indented lines under a title, or below the present ones; nothing without lines.
    pub fn section(&mut self, title: &str, lines: impl IntoIterator<Item = impl Display>) -> &mut Self {
        let mut lines = lines.into_iter().peekable();
        if lines.peek().is_some() && !title.is_empty() {
            self.text += &format!("\n{title}\n");
        }
        self.lines(lines.map(|line| format!("  {line}")))
    }

    /// A table under a title; nothing without rows.
    pub fn table(&mut self, title: &str, table: &TextTable) -> &mut Self {
        if !table.rows.is_empty() {
            self.text += &format!("\n{title}\n{}", table.text(self.width));
        }
        self
    }

    /// Its content.
    pub fn text(&mut self) -> String {
        std::mem::take(&mut self.text)
    }
}

/// A row of cells with their widths, in as many lines as the longest cell needs.
fn lines(cells: Vec<(&str, usize)>) -> String {
    let cells: Vec<(Vec<&str>, usize)> =
        cells.into_iter().map(|(cell, width)| (pieces(cell, width, width), width)).collect();
    let height = cells.iter().map(|(pieces, _)| pieces.len()).max().unwrap_or(0);
    let line = |i: usize| {
        let cells = cells.iter().map(|(pieces, width)| format!("  {:<width$}", pieces.get(i).unwrap_or(&"")));
        cells.collect::<String>().trim_end().to_owned() + "\n"
    };
    (0..height).map(line).collect()
}

fn characters(text: &str) -> usize {
    text.chars().count()
}

fn longest_word(text: &str) -> usize {
    pieces(text, 0, 0).into_iter().map(characters).max().unwrap_or(0)
}

/// A line in pieces of at most `first` characters, then `rest`, between words if possible; a number that begins a piece keeps
/// its unit, any number its % and its <.
fn pieces(line: &str, first: usize, rest: usize) -> Vec<&str> {
    let (mut pieces, mut left, mut most) = (Vec::new(), line, first);
    while left.chars().nth(most).is_some() {
        let is_break = |at: &usize| {
            let (before, after) = (left[..*at].trim(), left[*at..].trim_start());
            let is_number = before.replace('−', "-").parse::<f64>().is_ok();
            !before.is_empty() && !is_number && !before.ends_with('<') && !after.starts_with('%')
        };
        let blanks = || left.match_indices(' ').map(|(at, _)| at).filter(is_break);
        let fitting = blanks().take_while(|at| characters(&left[..*at]) <= most).last();
        let Some(at) = fitting.or_else(|| blanks().next()) else { break };
        pieces.push(left[..at].trim_end());
        (left, most) = (left[at..].trim_start(), rest);
    }
    pieces.push(left);
    pieces
}

/// True if a character controls the terminal or the direction of writing, instead of being seen.
pub fn is_unseen(c: char) -> bool {
    c.is_control() || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// The text with a sign in place of each invisible character; tabs and ends of lines stay.
pub fn visible(text: &str) -> String {
    let sign = |c: char| match c {
        '\n' | '\t' => c,
        // Unicode has pictures of them.
        ..' ' => char::from_u32(0x2400 + u32::from(c)).unwrap_or(c),
        c if is_unseen(c) => char::REPLACEMENT_CHARACTER,
        c => c,
    };
    text.replace("\r\n", "\n").chars().map(sign).collect()
}

/// The text with a capital letter, unless it begins with a key.
pub fn capital(text: &str) -> String {
    let word = text.split([' ', ',', ':']).next().unwrap_or_default();
    let mut letters = text.chars();
    let first = letters.next().filter(|_| word.chars().all(char::is_alphabetic));
    first.map_or(text.to_owned(), |first| first.to_uppercase().chain(letters).collect())
}

/// A message as a sentence: with a full stop and a capital letter.
pub fn sentence(text: &str) -> String {
    capital(text.trim_end_matches('.')) + "."
}

/// The text as in [`visible`], in one line.
pub fn in_one_line(text: impl Display) -> String {
    visible(&text.to_string()).replace(['\n', '\t'], " ")
}

/// The text in lines of at most `width` characters, broken between words if possible; continued lines are indented by two more.
pub fn wrapped(text: &str, width: usize) -> String {
    let line = |line: &str| {
        let content = line.trim_start();
        let indent = if content.is_empty() { 0 } else { line.len() - content.len() };
        let pieces = pieces(content, width.saturating_sub(indent), width.saturating_sub(indent + 2));
        " ".repeat(indent) + &pieces.join(&format!("\n{:1$}", "", indent + 2))
    };
    text.split('\n').map(line).collect::<Vec<_>>().join("\n")
}

/// First characters that turn a cell of a spreadsheet into a formula.
const FORMULA: [char; 6] = ['=', '+', '-', '@', '\t', '\r'];

/// The heading with an apostrophe in front if a spreadsheet would compute it; [`heading`] removes it.
fn harmless(name: String) -> String {
    if name.starts_with(FORMULA) { format!("'{name}") } else { name }
}

/// The name in a heading of a CSV table.
pub fn heading(cell: &str) -> &str {
    cell.strip_prefix('\'').filter(|name| name.starts_with(FORMULA)).unwrap_or(cell)
}

/// CSV of these lines, the first of which has the headings, after RFC 4180: cells with commas, quotes or ends of lines are in
/// quotes, a quote in them is doubled.
///
/// # Errors
/// None in practice: the writer fills memory.
pub fn csv(lines: impl IntoIterator<Item = Vec<String>>) -> Result<String, Fault> {
    let fault = |e: &dyn Display| Fault::new(format!("the table cannot be written as CSV: {e}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (i, line) in lines.into_iter().enumerate() {
        let line = if i == 0 { line.into_iter().map(harmless).collect() } else { line };
        writer.write_record(line).map_err(|e| fault(&e))?;
    }
    let bytes = writer.into_inner().map_err(|e| fault(&e))?;
    String::from_utf8(bytes).map_err(|e| fault(&e))
}

/// A whole report; infinite values become null.
///
/// # Errors
/// None in practice: every value of a report has a form in JSON.
pub fn json(report: &impl Serialize) -> Result<String, Fault> {
    let mut text = serde_json::to_string_pretty(report)
        .map_err(|e| Fault::new(format!("the report cannot be written as JSON: {e}")))?;
    // JSON leaves some of them unescaped.
    while let Some(unseen) = text.chars().find(|c| is_unseen(*c) && *c != '\n') {
        text = text.replace(unseen, &format!("\\u{:04x}", u32::from(unseen)));
    }
    Ok(text + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(rows: &[&[&str]]) -> TextTable {
        let mut rows = rows.iter().map(|row| row.iter().map(|cell| (*cell).to_owned()).collect());
        TextTable { head: rows.next().unwrap(), rows: rows.collect() }
    }

    #[test]
    fn tables_keep_to_the_width() {
        let short = table(&[&["name", "value"], &["m", "12 kg"], &["speed", "3"]]);
        assert_eq!(short.text(80), "  name   value\n  m      12 kg\n  speed  3\n");
        // The widest column is wrapped, between words.
        let wide =
            table(&[&["without", "cost"], &["the elasticity of the output member", "15 %"], &["damping", "100 %"]]);
        assert_eq!(
            wide.text(30),
            "  without                cost\n  the elasticity of the  15 %\n  output member\n  damping                100 %\n"
        );
        // Columns that do not fit side by side follow below.
        let many = table(&[&["tool", "overshoot", "deviation", "harmonics"], &["1", "2", "3", "4"]]);
        assert_eq!(
            many.text(30),
            "  tool  overshoot  deviation\n  1     2          3\n\n  tool  harmonics\n  1     4\n"
        );
        // Numbers keep their units, and as many columns are repeated as identify the rows.
        let twice = table(&[&["kind", "step", "error", "cost"], &["a", "1", "−18.3 %", "3"], &["a", "2", "5 %", "4"]]);
        assert_eq!(
            twice.text(22),
            "  kind  step  error\n  a     1     −18.3 %\n  a     2     5 %\n\n  kind  step  cost\n  a     1     3\n  a     2     4\n"
        );
        let bounds = table(&[&["error", "off by"], &["< 1.3e-13", "0.0163 ! −66 %"]]);
        assert_eq!(bounds.text(22), "  error      off by\n  < 1.3e-13  0.0163 !\n             −66 %\n");
        // Prose is wrapped in its column while that is wide enough, and otherwise stands below its row.
        let prose = "one two three four five six seven eight nine ten eleven";
        let described = table(&[&["name", "description"], &["a_name_of_some_length", prose], &["b", ""]]);
        let text = described.text(70);
        assert!(text.contains("a_name_of_some_length  one two three four five six seven eight nine\n"), "{text}");
        assert!(text.contains("\n                         ten eleven\n"), "{text}");
        let text = described.text(50);
        assert!(text.contains("\n  a_name_of_some_length\n      one two three"), "{text}");
        for (table, width) in [(&wide, 30), (&many, 30), (&described, 70), (&described, 50)] {
            assert!(table.text(width).lines().all(|line| characters(line) <= width), "{}", table.text(width));
        }
    }

    #[test]
    fn lines_are_wrapped_between_words() {
        let text = "  one two three\nfour_which_is_too_long\n\n";
        assert_eq!(wrapped(text, 10), "  one two\n    three\nfour_which_is_too_long\n\n");
        assert_eq!(wrapped(text, 80), text);
    }

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
        // 35/16 with the roundings of two computations.
        let of_two = [2.1875f64.next_down(), 2.1875f64.next_up()];
        assert_eq!(of_two.map(|value| digits(value, 4, -3)), ["2.188", "2.188"]);
        assert_eq!(digits(0.1 + 0.2, 17, -3), "0.30000000000000004");
        assert_eq!(rpm(-20.0 * TAU), "-1200");
        assert_eq!([distinguishing(&[499.6, 499.8], 7), distinguishing(&[500.0, 500.0], 7)], [4, 3]);
        assert_eq!([clean(1e-10, 1.0), clean(-1e-8, 1.0)], [0.0, -1e-8]);
    }
}
