//! Tables of inputs over time: a column `time`, and one column per input with its name.

use super::dialect::{Column, RowFault, Sheet};
use super::{File, contents, fault, faults, shown};
use crate::document::{Diagnostic, Diagnostics, meant, units};
use camdrive::drives::Description;
use camdrive::drives::unit::{self, Quantity};
use camdrive::drives::variable::Kind;
use camdrive_design::text;
use std::path::Path;

/// Values over time.
pub struct Courses {
    /// The times of the rows (s), rising.
    pub times: Vec<f64>,
    /// The index of each input in the list of all, and its values (SI).
    pub columns: Vec<(usize, Vec<f64>)>,
}

/// The content of a column.
#[derive(Clone, Copy, PartialEq)]
enum Content {
    Time,
    Input(usize),
}

/// The hint on the form of such a table.
const EXAMPLE: &str = "a table has the headings time and names of inputs, and below them numbers";

/// The values of some of these inputs over time, in SI units or in the units of the headings, `w [rpm]`; `own` is the FMU's unit of
/// an input if it is not SI.
///
/// # Errors
/// A file that cannot be read, headings that name no input, lines without numbers, times that do not rise, values out of range.
pub fn courses(
    path: &Path,
    inputs: &[&Description],
    own: impl Fn(usize) -> Option<String>,
) -> Result<Courses, Diagnostics> {
    let name = shown(path);
    let single = |fault: Diagnostic| Diagnostics(vec![fault]);
    if inputs.is_empty() {
        let hint = "`camdrive describe SCENE` lists its variables";
        return Err(single(Diagnostic::new(&name, "there are no inputs").hint(hint)));
    }
    let (text, ..) = contents(path).map_err(|(reason, hint)| {
        let fault = Diagnostic::new(&name, format!("the table {reason}"));
        single(fault.hint(hint.unwrap_or(EXAMPLE)))
    })?;
    let file = File { name: name.clone(), text };
    let told = |wrong: Vec<RowFault>| Diagnostics(faults(&file, wrong));
    let sheet = Sheet::new(&file.text).map_err(|wrong| told(vec![wrong]))?;
    let known = headings(&name, &sheet, inputs, own).map_err(single)?;
    let Some(time) = known.iter().position(|(content, _)| *content == Content::Time) else {
        return Err(single(Diagnostic::new(&name, "there is no column `time`").hint(EXAMPLE)));
    };
    if known.len() == 1 {
        let fault = Diagnostic::new(&name, "there is no column of an input");
        return Err(single(fault.admissible(names(inputs).join(", "))));
    }
    let (mut times, mut columns) = (Vec::new(), Vec::new());
    for (column, (content, factor)) in known.iter().enumerate() {
        let Content::Input(input) = *content else { continue };
        let of = [Column::Number(time), Column::Number(column)];
        let rows = sheet.rows(&of, 0, "write plain numbers; headings give their units").map_err(told)?;
        if let Some(span) = rows.doubtful.first() {
            return Err(single(fault(&file, span.clone(), "this line has no time")));
        }
        let si = |value: f64, (above, below): (f64, f64)| value * above / below;
        let values: Vec<f64> = rows.rows.iter().map(|(row, _)| si(row[1], *factor)).collect();
        for (value, (_, span)) in values.iter().zip(&rows.rows) {
            inputs[input].check(*value).map_err(|e| single(fault(&file, span.clone(), e.to_string())))?;
        }
        if columns.is_empty() {
            times = rows.rows.iter().map(|(row, _)| si(row[0], known[time].1)).collect();
            if let Some(i) = (1..times.len()).find(|i| !follows(&times, *i)) {
                let [before, here] = [times[i - 1], times[i]].map(units::short);
                let message = format!("the time {here} s does not follow {before} s");
                let fault = fault(&file, rows.rows[i].1.clone(), message);
                return Err(single(fault.hint("times rise; two rows at one time are a jump")));
            }
        }
        columns.push((input, values));
    }
    Ok(Courses { times, columns })
}

/// The admissible headings.
fn names<'a>(inputs: &[&'a Description]) -> Vec<&'a str> {
    std::iter::once("time").chain(inputs.iter().map(|input| input.name.as_str())).collect()
}

/// The content of each column, from its heading, and the factor from its unit to SI.
fn headings(
    name: &str,
    sheet: &Sheet<'_>,
    inputs: &[&Description],
    own: impl Fn(usize) -> Option<String>,
) -> Result<Vec<(Content, (f64, f64))>, Diagnostic> {
    let names = names(inputs);
    let mut contents = Vec::new();
    for column in 0..sheet.width() {
        let known = sheet.headings(column).find_map(|heading| content(heading, inputs));
        let Some((content, unit)) = known else {
            let (heading, guess) = match sheet.headings(column).last() {
                Some(heading) => (format!("\"{heading}\" is"), meant(heading, &names)),
                None => ("without heading is".to_owned(), None),
            };
            let fault = Diagnostic::new(name, format!("column {}, {heading} neither time nor an input", column + 1));
            let hint = guess.unwrap_or(EXAMPLE.to_owned());
            return Err(fault.admissible(names.join(", ")).hint(hint));
        };
        if contents.iter().any(|(other, _)| *other == content) {
            return Err(Diagnostic::new(name, format!("`{}` has two columns", names[place(content)])).hint(EXAMPLE));
        }
        if let (Content::Input(input), None) = (content, unit)
            && let Some(own) = own(input)
        {
            let (heading, place) = (&inputs[input].name, column + 1);
            let said =
                format!("column {place}, `{heading}`: its numbers may be in SI or in {own}, the unit of the FMU");
            let hint = format!("write the unit into the heading, \"{heading} [{own}]\"");
            return Err(Diagnostic::new(name, said).hint(hint));
        }
        let quantity = quantity(content, inputs);
        let factor = unit.map_or(Ok((1.0, 1.0)), |unit| units::factor(unit, quantity)).map_err(|fault| {
            let message = format!("column {}: {}", column + 1, fault.message);
            Diagnostic::new(name, message).remedy(fault.0.hint)
        })?;
        contents.push((content, factor));
    }
    Ok(contents)
}

/// True if a time comes after the previous one, or equals it exactly: a jump. Times that are closer than that would be equal.
fn follows(times: &[f64], i: usize) -> bool {
    let [before, here] = [times[i - 1], times[i]];
    here - before > 1e-9 * here.abs() || here == before && (i < 2 || times[i - 2] < before)
}

/// The index among the names: the time, then the inputs.
fn place(content: Content) -> usize {
    match content {
        Content::Time => 0,
        Content::Input(input) => input + 1,
    }
}

fn quantity(content: Content, inputs: &[&Description]) -> &'static Quantity {
    match content {
        Content::Time => &unit::TIME,
        Content::Input(input) => match inputs[input].kind {
            Kind::Real { quantity, .. } => quantity,
            _ => &unit::NUMBER,
        },
    }
}

/// The content and the unit of a heading such as "time", "w [rpm]" or "follower[1].load".
fn content<'a>(heading: &'a str, inputs: &[&Description]) -> Option<(Content, Option<&'a str>)> {
    let named = |name: &str| match name {
        "time" => Some(Content::Time),
        _ => inputs.iter().position(|input| input.name == name).map(Content::Input),
    };
    let with_unit = || {
        let (name, unit) = text::heading(heading).rsplit_once(['[', '('])?;
        Some((named(name.trim())?, Some(unit.trim_end_matches([']', ')', ' ']))))
    };
    named(text::heading(heading)).map(|content| (content, None)).or_else(with_unit)
}
