//! Faults of a scene file: place, fault, admissible values, and a remedy.
//!
//! All faults of a file are collected in one run and printed in the file's order, each with its source line:
//!
//! ```text
//! error: `drive.speed`: "1800 mm" is a length; an angular velocity is expected
//!  --> scene.toml:12:9
//!    |
//! 12 | speed = "1800 mm"
//!    |         ^^^^^^^^^
//!    = admissible: -1e6 … 1e6 rad/s
//!    = hint: write for example "1800 rpm"
//! ```

use camdrive::drives::Fault;
use camdrive_design::text;
use std::fmt;
use std::ops::Range;
use std::path::Path;

/// One fault.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// The path of the key with which the message begins.
    pub key: Option<String>,
    /// The fault, with the path of the key (`cam.stroke`) and the value.
    pub message: String,
    /// The admissible range or the admissible names.
    pub admissible: Option<String>,
    /// A remedy.
    pub hint: Option<String>,
    /// The file, as the user named it.
    pub file: String,
    /// The place in the file; None if the fault is the file itself.
    pub position: Option<Position>,
}

/// A piece of a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Position {
    /// Counts from 1.
    pub line: usize,
    /// Counts characters from 1.
    pub column: usize,
    /// Number of characters, at least 1.
    pub width: usize,
    /// The line up to the place, and from there on; of a long line only the surroundings, as wide as a terminal.
    pub excerpt: [String; 2],
}

/// A message in one line: quoted values of files may have any length and content.
fn line(text: impl Into<String>) -> String {
    /// Characters kept at either end of a shortened message; the longest list of names has fewer.
    const KEPT: usize = 200;
    let text = text::in_one_line(text.into());
    match text.chars().count() {
        count if count <= 2 * KEPT => text,
        count => text.chars().take(KEPT).chain(['…']).chain(text.chars().skip(count - KEPT)).collect(),
    }
}

/// All faults of a scene, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl Diagnostic {
    /// A fault of the file `file` as a whole.
    pub fn new(file: &str, message: impl Into<String>) -> Self {
        let (message, file) = (line(message), file.to_owned());
        Diagnostic { key: None, message, admissible: None, hint: None, file, position: None }
    }

    /// Starts the message with this key.
    pub fn of(mut self, key: impl Into<String>) -> Self {
        let key = line(key);
        self.message = line(format!("`{key}`{}", self.message));
        self.key = Some(key);
        self
    }

    /// Sets the place: these bytes of `text`, the content of the file.
    pub fn at(mut self, text: &str, span: Range<usize>) -> Self {
        self.position = Some(Position::of(text, span));
        self
    }

    /// Adds the admissible values.
    pub fn admissible(mut self, text: impl Into<String>) -> Self {
        self.admissible = Some(line(text));
        self
    }

    /// Adds a remedy.
    pub fn hint(self, text: impl Into<String>) -> Self {
        self.remedy(Some(text.into()))
    }

    /// Adds a remedy if there is one.
    pub fn remedy(mut self, hint: Option<String>) -> Self {
        self.hint = hint.map(line);
        self
    }
}

impl Diagnostics {
    /// The fault of a file as a whole.
    pub fn of_file(path: &Path, fault: Fault) -> Self {
        let told = Diagnostic::new(&path.display().to_string(), fault.sentence());
        Diagnostics(vec![told.remedy(fault.0.hint)])
    }
}

impl Position {
    /// The position of these bytes of `text`; a span over several lines ends with its first line.
    fn of(text: &str, span: Range<usize>) -> Self {
        let floor = |i: usize| (0..=i.min(text.len())).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0);
        let start = floor(span.start);
        let line_start = text[..start].rfind('\n').map_or(0, |i| i + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |i| start + i);
        let end = floor(span.end).clamp(start, line_end);
        let before = &text[line_start..start];
        let here = text[start..line_end].trim_end_matches('\r');
        let column = before.chars().count() + 1;
        Position {
            line: text[..start].matches('\n').count() + 1,
            column,
            width: text[start..end].chars().count().max(1),
            excerpt: excerpt(before, here, column - 1),
        }
    }
}

/// The pieces of a line; of a long line only the parts near the point where they meet. `characters` is the length of the first.
fn excerpt(before: &str, here: &str, characters: usize) -> [String; 2] {
    const BEFORE: usize = 40;
    const AFTER: usize = 60;
    if characters + here.chars().count() <= BEFORE + AFTER {
        return [before, here].map(text::visible);
    }
    let near = |text: &str, count: usize| text.char_indices().nth(count).map(|(end, _)| end);
    let from = characters.checked_sub(BEFORE).filter(|cut| *cut > 0).and_then(|cut| near(before, cut));
    let to = near(here, AFTER);
    let left = text::visible(&before[from.unwrap_or(0)..]);
    let right = text::visible(&here[..to.unwrap_or(here.len())]);
    [if from.is_some() { format!("…{left}") } else { left }, if to.is_some() { format!("{right}…") } else { right }]
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let file = text::in_one_line(&self.file);
        writeln!(f, "error: {}", self.message)?;
        let margin = match &self.position {
            None => {
                writeln!(f, " --> {file}")?;
                2
            }
            Some(p) => {
                let margin = p.line.to_string().len();
                writeln!(f, "{:margin$}--> {file}:{}:{}", "", p.line, p.column)?;
                writeln!(f, "{:margin$} |", "")?;
                let [before, here] = &p.excerpt;
                writeln!(f, "{} | {before}{here}", p.line)?;
                // Tabs are repeated, so that the carets stand below their text.
                let indent: String = before.chars().map(|c| if c == '\t' { '\t' } else { ' ' }).collect();
                writeln!(f, "{:margin$} | {indent}{}", "", "^".repeat(p.width.min(here.chars().count().max(1))))?;
                margin
            }
        };
        for (label, text) in [("admissible", &self.admissible), ("hint", &self.hint)] {
            if let Some(text) = text {
                writeln!(f, "{:margin$} = {label}: {text}", "")?;
            }
        }
        Ok(())
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for diagnostic in &self.0 {
            writeln!(f, "{diagnostic}")?;
        }
        match self.0.len() {
            1 => writeln!(f, "1 fault"),
            n => writeln!(f, "{n} faults"),
        }
    }
}

impl std::error::Error for Diagnostics {}

/// The longest name (bytes): the time to compare two texts grows with the product of their lengths.
const LONGEST_NAME: usize = 200;

/// The known name most similar to `wrong`, if one is similar at all.
pub fn nearest<'a>(wrong: &str, known: &[&'a str]) -> Option<&'a str> {
    if wrong.len() > LONGEST_NAME {
        return None;
    }
    let wrong = wrong.to_lowercase();
    let likeness = |name: &str| {
        let name = name.to_lowercase();
        // One slip or two swapped letters; in a name of two letters this would be another name.
        let slip = name.len() > 2 && strsim::osa_distance(&wrong, &name) == 1;
        strsim::jaro_winkler(&wrong, &name).max(if slip { 0.9 } else { 0.0 })
    };
    // 0.75 admits one or two slips in a short name and keeps unrelated names out.
    known
        .iter()
        .map(|&name| (likeness(name), name))
        .filter(|(likeness, _)| *likeness > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// A hint with the known name most similar to `wrong`.
pub fn meant(wrong: &str, known: &[&str]) -> Option<String> {
    nearest(wrong, known).map(|name| format!("did you mean `{name}`?"))
}
