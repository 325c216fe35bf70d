//! The dialects of text tables: from the bytes of a file to its headings and its rows of cells.
//!
//! One separator applies to the whole file: the one in a line `sep=`, else the first of `;`, tab, blanks, `,` that occurs in the
//! rows of numbers. With the first three a comma is a decimal mark, and within quotes as well. Lines of words before the first row
//! of numbers are headings, after the last one they end the table of a controller; lines that begin with `#`, `//` or `%` are
//! comments, and so is text after `//`, `#` or `(*` in a row.

use crate::document::Span;
use crate::document::input::{BYTE_ORDER_MARK, utf16};
use camdrive_design::text::counted;
use std::collections::BTreeMap;

/// A fault in a table.
#[derive(Clone, Debug, PartialEq)]
pub struct RowFault {
    /// The place; None for the table itself.
    pub span: Option<Span>,
    /// The message.
    pub message: String,
    /// The admissible values.
    pub admissible: Option<String>,
    /// A remedy.
    pub hint: Option<&'static str>,
}

impl RowFault {
    /// A fault at these bytes, with a remedy if there is one.
    pub fn at(span: &Span, message: impl Into<String>, hint: impl Into<Option<&'static str>>) -> Self {
        RowFault { span: Some(span.clone()), ..RowFault::new(message, hint) }
    }

    /// A fault of the table itself.
    fn new(message: impl Into<String>, hint: impl Into<Option<&'static str>>) -> Self {
        RowFault { span: None, message: message.into(), admissible: None, hint: hint.into() }
    }
}

/// The marks at the start of a comment.
const COMMENTS: [&str; 3] = ["#", "//", "%"];

/// The text of a file, and how its bytes were read if they are not Unicode; None if they are no text.
pub fn decode(bytes: &[u8]) -> Option<(String, Option<&'static str>)> {
    // Lines from old computers end with a carriage return alone.
    let ended = |text: String| if text.contains('\n') { text } else { text.replace('\r', "\n") };
    match utf16(bytes) {
        Some(text) => text.map(|text| (ended(text), None)),
        None if bytes.contains(&0) => None,
        None => Some(match std::str::from_utf8(bytes) {
            Ok(text) => (ended(text.trim_start_matches(BYTE_ORDER_MARK).to_owned()), None),
            Err(_) => {
                let text = bytes.iter().map(|byte| char::from(*byte)).collect();
                (ended(text), Some("is not UTF-8; it is read as Latin-1"))
            }
        }),
    }
}

/// A line with content.
struct Line {
    cells: Vec<Span>,
    /// The number of cells, including empty ones at the end.
    width: usize,
    span: Span,
    comment: bool,
}

/// A column of the file.
pub enum Column<'a> {
    /// Counts from 0.
    Number(usize),
    /// Its heading.
    Heading(&'a str),
    /// No column: the rows count, from 0.
    Rows,
}

/// A table as text.
pub struct Sheet<'a> {
    text: &'a str,
    separator: char,
    lines: Vec<Line>,
}

/// The rows of numbers, and further findings about them.
#[derive(Debug)]
pub struct Rows {
    /// The requested columns, from 0.
    pub columns: Vec<usize>,
    /// The values in these columns, and the place of the row.
    pub rows: Vec<(Vec<f64>, Span)>,
    /// Lines before the first row that could be rows.
    pub doubtful: Vec<Span>,
    /// Lines of words after the last row, with a cell for each of these columns.
    pub trailer: Vec<Span>,
    /// The last digit of each of these columns.
    pub digits: Vec<f64>,
}

impl<'a> Sheet<'a> {
    /// The lines of the text with their cells.
    ///
    /// # Errors
    /// Commas that could separate cells or decimals.
    pub fn new(text: &'a str) -> Result<Self, RowFault> {
        let mut spans = lines(text).peekable();
        let prefix = |span: &Span| text[span.clone()].trim_matches('"').to_ascii_lowercase().starts_with("sep=");
        // A blank or a tab at the end of the line is not part of its content.
        let told = spans.next_if(prefix).map(|span| {
            let rest = text[span.start..].lines().next().and_then(|line| line.split_once('='));
            rest.and_then(|(_, rest)| rest.chars().next()).filter(|mark| *mark != '"').unwrap_or('\t')
        });
        let spans: Vec<Span> = spans.collect();
        let content = |span: &Span| &text[without_comment(text, span)];
        // Rows with only numbers show the separator; if columns of words stand next to them, the cells that begin like a number do.
        let plain = |line: &&str| line.chars().all(|c| c.is_ascii_digit() || " \t+-\u{2212}.,;eE\"".contains(c));
        let begins = |line: &&str| line.starts_with(|c: char| c.is_ascii_digit() || "+-\u{2212}.,\"".contains(c));
        let mut sample: Vec<&str> = spans.iter().map(content).collect();
        for kind in [&begins as &dyn Fn(&&str) -> bool, &plain] {
            if sample.iter().any(kind) {
                sample.retain(kind);
            }
        }
        let any = |c: char| sample.iter().any(|line| line.contains(c));
        let separator = told.unwrap_or_else(|| match () {
            // A semicolon at the end of every row separates nothing.
            () if sample.iter().any(|line| line.trim_end_matches(';').contains(';')) => ';',
            () if any('\t') => '\t',
            () if sample.iter().any(|line| blank_between_numbers(line)) => ' ',
            () if any(',') => ',',
            () => ';',
        });
        let mut all = Vec::new();
        for span in &spans {
            let mark = COMMENTS.iter().find(|mark| text[span.clone()].starts_with(**mark));
            let (comment, start) = (mark.is_some(), span.start + mark.map_or(0, |mark| mark.len()));
            let end = if comment { span.end } else { without_comment(text, span).end };
            let row = text[start..end].trim_end_matches(if [' ', ','].contains(&separator) { ';' } else { ' ' });
            let mut cells = cells(text, start..start + row.len(), separator);
            let width = cells.len();
            while cells.last().is_some_and(|cell| cell.is_empty()) {
                cells.pop();
            }
            // Spreadsheets leave lines of separators.
            if !cells.is_empty() {
                all.push(Line { cells, width, span: span.clone(), comment });
            }
        }
        let sheet = Sheet { text, separator, lines: all };
        match (separator, told) {
            (',', None) if !any('"') => sheet.one_reading().map(|()| sheet),
            _ => Ok(sheet),
        }
    }

    /// Refuses numbers between commas that could also be decimals, or the ends of thousands if decimals have points. That is: three
    /// or more in a row, and some column after the first has only digits, or three before the point. An equal number of headings,
    /// or a blank after every comma, shows that they are cells. A cell such as 05 is no number of its own.
    fn one_reading(&self) -> Result<(), RowFault> {
        let numbers = |line: &&Line| !line.comment && line.cells.iter().all(|cell| self.number(cell).is_some());
        let rows: Vec<&Line> = self.lines.iter().filter(numbers).collect();
        let Some(longest) = rows.iter().rev().max_by_key(|line| line.cells.len()).filter(|line| line.cells.len() > 2)
        else {
            return Ok(());
        };
        let digits = |cell: &Span| self.text[cell.clone()].bytes().all(|b| b.is_ascii_digit());
        let count = longest.cells.len();
        let points = rows.iter().any(|line| self.text[line.span.clone()].contains('.'));
        let of_thousand = |j: usize| {
            rows.iter().any(|line| line.cells.len() > j)
                && rows.iter().filter(|line| line.cells.len() > j).all(|line| {
                    let [before, own] = [j - 1, j].map(|j| &self.text[line.cells[j].clone()]);
                    let whole = own.split('.').next().unwrap_or_default();
                    let begins = before.trim_start_matches(['+', '-', '\u{2212}']);
                    let three = whole.len() == 3 && whole.bytes().all(|b| b.is_ascii_digit());
                    three
                        && (1..=3).contains(&begins.len())
                        && begins.bytes().all(|b| b.is_ascii_digit())
                        && !begins.starts_with('0')
                })
        };
        let fraction = |j: usize| {
            if points { of_thousand(j) } else { rows.iter().all(|line| line.cells.get(j).is_none_or(digits)) }
        };
        let leading = |cell: &Span| digits(cell) && cell.len() > 1 && self.text[cell.clone()].starts_with('0');
        let broken = rows.iter().any(|line| line.cells[1..].iter().any(leading));
        let headed = |line: &Line| {
            let names = line.cells.iter().filter(|cell| self.number(cell).is_none() && !cell.is_empty()).count();
            names == line.cells.len() && names >= count
        };
        let spaced = rows.iter().all(|line| {
            let line = &self.text[line.span.clone()];
            line.matches(", ").count() == line.matches(',').count()
        });
        let headed = !broken && self.lines.iter().any(headed);
        if spaced || headed || !(1..count).any(fraction) {
            return Ok(());
        }
        let words: Vec<&str> = longest.cells.iter().map(|cell| &self.text[cell.clone()]).collect();
        let (mut merged, mut end) = (Vec::new(), count);
        while end > 0 {
            let joins = end > 1 && if points { of_thousand(end - 1) } else { digits(&longest.cells[end - 1]) };
            let start = if joins { end - 2 } else { end - 1 };
            merged.push(words[start..end].join(if points { "" } else { "." }));
            end = start;
        }
        merged.reverse();
        let (cells, others) = (words.join(" | "), merged.join(" | "));
        let marks = if points { "commas of thousands" } else { "decimal commas" };
        let message = format!("this line can be read two ways: as {cells}, or with {marks} as {others}");
        let hint = "separate the columns by `;`, or begin the file with the line `sep=,` if no comma is a decimal one";
        Err(RowFault::at(&longest.span, message, hint))
    }

    /// True if a line contains words: it begins with a letter or with a mark that no number has, or has nothing like a number; and
    /// no cell is an unknown value.
    fn is_of_words(&self, line: &Line) -> bool {
        /// Words that programs write for an unknown value.
        const UNKNOWN: [&str; 11] = ["nan", "-nan", "inf", "-inf", "infinity", "n/a", "na", "null", "none", "-", "?"];
        let unknown = |cell: &Span| UNKNOWN.contains(&&*self.text[cell.clone()].to_ascii_lowercase());
        let begins = |c: char| !c.is_ascii_digit() && !"+-\u{2212}.,;\"".contains(c);
        let digits = |cell: &Span| self.text[cell.clone()].contains(|c: char| c.is_ascii_digit());
        let words = self.text[line.span.clone()].starts_with(begins) || !line.cells.iter().any(digits);
        words && !line.cells.iter().any(unknown)
    }

    fn number(&self, cell: &Span) -> Option<f64> {
        let plain = self.text[cell.clone()].replacen(',', ".", 1).replace('\u{2212}', "-");
        plain.parse().ok().filter(|value: &f64| value.is_finite())
    }

    /// The unit of a column in a line of headings, in brackets or, for derivatives, as in `dU_m_per_rad`.
    pub fn unit(&self, column: usize) -> Option<(Span, String)> {
        let unit = |cell: &Span| match self.text[cell.clone()].rsplit_once(['[', '(']) {
            Some((_, unit)) => Some(unit.trim_end_matches([']', ')', ' ']).to_owned()),
            None => Some(self.text[cell.clone()].split_once('_')?.1)
                .filter(|unit| unit.contains("_per_"))
                .map(|unit| unit.replace("_per_", "/")),
        };
        let of = |comment: bool| self.lines.iter().rev().filter(move |line| line.comment == comment);
        let cells = of(false).chain(of(true)).filter_map(|line| line.cells.get(column));
        cells.filter_map(|cell| Some((cell.clone(), unit(cell)?))).next()
    }

    /// The number of columns.
    pub fn width(&self) -> usize {
        self.lines.iter().filter(|line| !line.comment).map(|line| line.cells.len()).max().unwrap_or(0)
    }

    /// The first column with a heading of this kind.
    pub fn headed(&self, is: impl Fn(&str) -> bool) -> Option<usize> {
        self.lines.iter().find_map(|line| line.cells.iter().position(|cell| is(&self.text[cell.clone()])))
    }

    /// The words in a column, without comments, the nearest to the rows first.
    pub fn headings(&self, column: usize) -> impl Iterator<Item = &'a str> {
        let lines = self.lines.iter().rev().filter(|line| !line.comment);
        let cells = lines.filter_map(move |line| line.cells.get(column));
        cells.filter(|cell| self.number(cell).is_none()).map(|cell| &self.text[cell.clone()])
    }

    /// The index of a column, from 0, and the index of the line with its heading.
    fn index(&self, column: &Column<'_>) -> Result<(usize, Option<usize>), RowFault> {
        let heading = match *column {
            Column::Number(number) => return Ok((number, None)),
            Column::Rows => return Ok((usize::MAX, None)),
            Column::Heading(heading) => heading,
        };
        let is_it = |cell: &Span| &self.text[cell.clone()] == heading;
        if let Some((i, line)) = self.lines.iter().enumerate().find(|(_, line)| line.cells.iter().any(is_it)) {
            let mut found = (0..line.cells.len()).filter(|&j| is_it(&line.cells[j]));
            return match (found.next(), found.next()) {
                (Some(first), None) => Ok((first, Some(i))),
                _ => {
                    let message = format!("two columns have the heading \"{heading}\"");
                    Err(RowFault::at(&line.span, message, "give the number of the column, from 1"))
                }
            };
        }
        let is_head = |line: &&Line| line.cells.iter().all(|cell| self.number(cell).is_none());
        let heads = || self.lines.iter().filter(is_head);
        Err(match heads().find(|line| !line.comment).or_else(|| heads().next()) {
            Some(line) => {
                let names: Vec<&str> = line.cells.iter().map(|cell| &self.text[cell.clone()]).collect();
                let wrong = RowFault::at(&line.span, format!("there is no column \"{heading}\""), None);
                RowFault { admissible: Some(names.join(", ")), ..wrong }
            }
            None => {
                let message = format!("the table has no headings for the column \"{heading}\"");
                RowFault::new(message, "give the number of the column, from 1")
            }
        })
    }

    /// The numbers in two columns and, if `more` columns are wanted, in as many after the second one; without the last of three if
    /// its unit is not the previous one's, or if it is missing. `hint` shows what a number looks like.
    ///
    /// # Errors
    /// Any other content there.
    pub fn rows(&self, of: &[Column<'_>; 2], more: usize, hint: &'static str) -> Result<Rows, Vec<RowFault>> {
        let (mut first, named) = match [self.index(&of[0]), self.index(&of[1])] {
            [Ok((first, line)), Ok((second, other))] => ([first, second], line.max(other)),
            all => return Err(all.into_iter().filter_map(Result::err).collect()),
        };
        // A single column serves as both.
        let alone = matches!(of[0], Column::Rows);
        if alone {
            first[0] = first[1];
        } else if first[0] == first[1] {
            let message = format!("column {} is used twice", first[0] + 1);
            return Err(vec![RowFault::new(message, "give each column its own number or heading")]);
        }
        let text = |cell: &Span| &self.text[cell.clone()];
        let widest = self.lines.iter().map(|line| line.cells.len()).max().unwrap_or(0);
        // Two of three derivatives, unless the heading of the last one makes it another of their kind, or the previous one's
        // heading does: U″ before each point needs U″ after it.
        let two = |last: usize| {
            let [own, before] = [last, last - 1].map(|column| self.unit(column).map(|unit| unit.1));
            let before_point = |line: &Line| line.cells.get(last - 1).is_some_and(|cell| text(cell).contains("before"));
            if widest > last { own != before } else { !self.lines.iter().any(before_point) }
        };
        let more = more - usize::from(more == 3 && two(first[1] + 3));
        let columns: Vec<usize> = first.into_iter().chain((1..=more).map(|n| first[1] + n)).collect();
        let value = |line: &Line, column: usize| self.number(line.cells.get(column)?);
        let lines: Vec<&Line> =
            self.lines.iter().skip(named.map_or(0, |i| i + 1)).filter(|line| !line.comment).collect();
        // A row with a first number but no second one is wrong; a row without a first number is a heading.
        let like = |line: &&Line| (alone || line.cells.len() > 1) && value(line, first[0]).is_some();
        let any = |line: &&Line| line.cells.iter().any(|cell| self.number(cell).is_some());
        // Words alone are headings; a line that begins like a number is a row.
        let begins = |line: &Line| line.cells.iter().any(|cell| text(cell).starts_with(|c: char| c.is_ascii_digit()));
        let none = if lines.iter().any(|line| begins(line)) { 0 } else { lines.len() };
        let start = lines.iter().position(like).or_else(|| lines.iter().position(any)).unwrap_or(none);
        let (headings, lines) = lines.split_at(start);
        let words = |line: &Line| value(line, first[0]).is_none() && self.is_of_words(line);
        let end = lines.iter().rposition(|line| !words(line)).map_or(lines.len(), |last| last + 1);
        let (lines, trailer) = lines.split_at(end);
        let (mut rows, mut doubtful, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
        // With blanks or commas as separators, a missing cell shifts the cells after it.
        let mut counts = BTreeMap::new();
        lines.iter().for_each(|line| *counts.entry(line.width).or_insert(0) += 1);
        let usual = counts.iter().rev().max_by_key(|(_, lines)| **lines).map_or(0, |(cells, _)| *cells);
        for line in lines {
            let cells = line.cells.len();
            if matches!(self.separator, ' ' | ',') && (cells > usual || line.width < usual) {
                let message = format!("this line has {}, most have {usual}", counted(cells, "cell"));
                let hint = "write a cell for each column in every row, and numbers without thousands separators";
                wrong.push(RowFault::at(&line.span, message, hint));
                continue;
            }
            let cell = |&column: &usize| {
                let cell = line.cells.get(column).ok_or_else(|| {
                    let message = format!("column {} is missing: this line has {}", column + 1, line.cells.len());
                    RowFault::at(&line.span, message, None)
                })?;
                let message = || format!("\"{}\" is not a finite number", text(cell));
                self.number(cell).ok_or_else(|| RowFault::at(cell, message(), hint))
            };
            let values: Vec<Result<f64, RowFault>> = columns.iter().map(cell).collect();
            if values.iter().all(Result::is_ok) {
                rows.push((values.into_iter().flatten().collect(), line.span.clone()));
            } else {
                wrong.extend(values.into_iter().filter_map(Result::err));
            }
        }
        let counts = |rows: &[(Vec<f64>, Span)]| rows.first().is_some_and(|(row, _)| row[0] == (rows.len() - 1) as f64);
        if alone && headings.is_empty() && counts(&rows) {
            let message = "this number is the count of the other rows, or a value";
            wrong.push(RowFault::at(
                &rows[0].1,
                message,
                "begin the line with # if it is the count; before a value write a line of headings",
            ));
        }
        if alone {
            rows.iter_mut().enumerate().for_each(|(i, (row, _))| row[0] = i as f64);
        }
        if lines.is_empty() {
            let message = "there is no row with numbers";
            wrong.push(RowFault::new(message, "a row has two numbers or more, between them `;`, a tab, blanks or `,`"));
        }
        let used = || lines.iter().flat_map(|line| columns.iter().filter_map(|column| line.cells.get(*column)));
        let with = |mark: char| used().any(|cell| text(cell).contains(mark) && self.number(cell).is_some());
        // Three digits after a mark may be decimals or the end of thousands; the other mark does not decide it.
        let thousands = |cell: &&Span| {
            text(cell).trim_start_matches(['+', '-', '\u{2212}']).split_once([',', '.']).is_some_and(|(whole, part)| {
                let digits = [whole, part].iter().all(|part| part.bytes().all(|b| b.is_ascii_digit()));
                digits && part.len() == 3 && (1..=3).contains(&whole.len()) && !whole.starts_with('0')
            })
        };
        // A number of another form shows the meaning of a mark; a number without the mark shows that it is not for decimals.
        let marked = |mark: char| used().filter(move |cell| text(cell).contains(mark));
        let shown = |mark: char| marked(mark).any(|cell| self.number(cell).is_some() && !thousands(&cell));
        let plain = |cell: &Span| text(cell).trim_start_matches(['-', '0']).bytes().all(|b| b.is_ascii_digit());
        let mixed = |column: usize| {
            let column = || lines.iter().filter_map(|line| line.cells.get(column));
            column().any(|cell| plain(cell) && !text(cell).trim_start_matches(['-', '0']).is_empty())
                && column().any(|cell| text(cell).contains('.'))
        };
        let both = with(',') && with('.');
        let open = both || with(',') && !shown(',') || with('.') && !shown('.') && columns.iter().any(|i| mixed(*i));
        if let Some(cell) = used().find(thousands).filter(|_| open) {
            let [decimal, whole] = [".", ""].map(|mark| text(cell).replace([',', '.'], mark));
            let why = if both { "with both `,` and `.` in the numbers of a table " } else { "" };
            let message = format!("{why}{} may be {decimal} or {whole}", text(cell));
            wrong.push(RowFault::at(
                cell,
                message,
                "write all numbers with one decimal mark and without thousands separators",
            ));
        }
        doubtful.extend(trailer.iter().filter(|line| value(line, first[1]).is_some()).map(|line| line.span.clone()));
        let filled =
            |line: &&&Line| !alone && value(line, first[1]).is_none() && columns.iter().all(|i| line.cells.len() > *i);
        let trailer = trailer.iter().filter(filled).map(|line| line.span.clone()).collect();
        for line in headings {
            let count = if let [only] = &line.cells[..] { self.number(only) } else { None };
            if count.is_some() && self.text[line.span.clone()].ends_with([';', ',']) {
                let message = format!("column {} is missing: this line has 1", first[1] + 1);
                wrong.push(RowFault::at(&line.span, message, hint));
            } else if count.is_some_and(|count| count != lines.len() as f64) {
                let rows = lines.len();
                let message = format!("a number alone in its line is the number of the rows, {rows}");
                wrong.push(RowFault::at(&line.span, message, "correct it, or begin the line with # if it is no count"));
            } else if count.is_none() && value(line, first[1]).is_some() {
                doubtful.push(line.span.clone());
            }
        }
        let decimals = |line: &&Line, column: usize| {
            let (number, exponent) = line
                .cells
                .get(column)
                .map(text)?
                .split_once(['e', 'E'])
                .unwrap_or_else(|| (line.cells.get(column).map_or("", text), "0"));
            let count = number.split_once(['.', ',']).map_or(0, |(_, digits)| digits.len() as i32);
            Some(count - exponent.parse::<i32>().ok()?)
        };
        let last = |column: &usize| lines.iter().filter_map(|line| decimals(line, *column)).max().unwrap_or(0);
        let digits = columns.iter().map(|column| 0.1_f64.powi(last(column))).collect();
        if wrong.is_empty() { Ok(Rows { columns, rows, doubtful, trailer, digits }) } else { Err(wrong) }
    }
}

/// The lines with content, without the blanks around it.
fn lines(text: &str) -> impl Iterator<Item = Span> + '_ {
    let mut start = 0;
    text.split_inclusive('\n').filter_map(move |line| {
        let begin = start;
        start += line.len();
        let content = line.trim();
        let offset = begin + (line.len() - line.trim_start().len());
        (!content.is_empty()).then(|| offset..offset + content.len())
    })
}

/// The part of a row before a trailing comment.
fn without_comment(text: &str, span: &Span) -> Span {
    let content = &text[span.clone()];
    // A spreadsheet writes #N/A into a cell.
    let begins = |mark: &&str| {
        let mut places = content.match_indices(*mark).map(|(place, _)| place);
        places.find(|place| !content[..*place].ends_with([';', ',', '\t']))
    };
    // Words after a semicolon are a comment of a controller if the row is before it.
    let is_number = |word: &&str| word.parse::<f64>().is_ok();
    let last = content.rfind(';').filter(|place| {
        content[place + 1..].trim_start().starts_with(char::is_alphabetic)
            && content[..*place].split([' ', '\t', ',']).filter(is_number).count() > 1
    });
    let end = ["//", "#", "(*"].iter().filter_map(begins).chain(last).min().unwrap_or(content.len());
    // A heading such as "Point #" has no comment.
    let row = content.starts_with(|c: char| c.is_ascii_digit() || "+-\u{2212}.\"".contains(c));
    span.start..span.start + if row { content[..end].trim_end().len() } else { content.len() }
}

/// True if blanks alone separate two numbers.
fn blank_between_numbers(line: &str) -> bool {
    let words: Vec<&str> = line.split_whitespace().collect();
    let end = |word: &str| word.ends_with(|c: char| c.is_ascii_digit() || c == '.');
    words
        .windows(2)
        .any(|pair| end(pair[0]) && pair[1].starts_with(|c: char| c.is_ascii_digit() || "+-\u{2212}.".contains(c)))
}

/// The cells of a line, without blanks and quotes around them.
fn cells(text: &str, line: Span, separator: char) -> Vec<Span> {
    let (mut cells, mut start, mut quoted) = (Vec::<Span>::new(), line.start, false);
    let ends = text[line.clone()].char_indices().filter(|&(_, c)| {
        quoted ^= c == '"';
        !quoted && (c == separator || separator == ' ' && c.is_whitespace())
    });
    let ends: Vec<Span> = ends.map(|(i, c)| line.start + i..line.start + i + c.len_utf8()).collect();
    for end in ends.into_iter().chain(std::iter::once(line.end..line.end)) {
        let piece = &text[start..end.start];
        let open = |c: char| c.is_whitespace() || c == '"';
        let cell = piece.trim_matches(open);
        let offset = start + (piece.len() - piece.trim_start_matches(open).len());
        // Several blanks are one separator, and a unit in brackets belongs to the word before it.
        let belongs = separator == ' ' && cell.starts_with(['[', '(']);
        if let Some(before) = cells.last_mut().filter(|_| belongs) {
            before.end = offset + cell.len();
        } else if separator != ' ' || !cell.is_empty() {
            cells.push(if cell.is_empty() { start..start } else { offset..offset + cell.len() });
        }
        start = end.end;
    }
    cells
}

#[cfg(test)]
mod tests;
