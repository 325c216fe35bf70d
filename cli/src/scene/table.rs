//! Tables of angles and lifts: a text file with one point per line.
//!
//! Columns are separated by `;`, `,`, tabs or blanks, whichever of them the line has first in this order; between
//! `;` a decimal comma is read as a point. Empty lines and lines that start with `#` are skipped, and so is one
//! line of headings before the first point.

use super::diagnostics::{Diagnostic, Diagnostics};
use super::limits::largest;
use super::section::{Section, Span};
use super::units;
use camdrive::drives::unit::{self, Quantity};
use camdrive::motion::table::{Bend, LEAST_DISTANCE, MOST_POINTS, Points, TableError};
use camdrive::motion::{MotionLaw, Polyline, Table};
use camdrive_design::harmonic_analysis;
use camdrive_design::smoothing::{SmoothingError, smooth};
use camdrive_design::table_error::told;
use camdrive_design::text::{self, counted};
use std::f64::consts::TAU;
use std::path::Path;

/// The most faults of one table that are told one by one.
const MOST_FAULTS: usize = 8;

/// How U is made of the points.
#[derive(Clone, Copy, PartialEq)]
pub enum Interpolation {
    Spline,
    /// Pieces of degree 5 with U′ and U″ that the three columns behind the lift give.
    Derivatives,
    Fourier,
    /// Straight lines, and steps where two points have one angle.
    Linear,
}

/// The kinds of interpolation with their names.
pub const INTERPOLATIONS: &[(&str, Interpolation)] = &[
    ("spline", Interpolation::Spline),
    ("derivatives", Interpolation::Derivatives),
    ("fourier", Interpolation::Fourier),
    ("linear", Interpolation::Linear),
];

/// What the points are of, and the keys of its unit and its column.
pub type Axis = (&'static Quantity, &'static str, &'static str);

/// The value of `noise` that asks for an estimate.
const ESTIMATE: &str = "estimate";

/// What is wrong in a line: where, what, and a remedy.
type Wrong<'a> = (Span, String, Option<&'a str>);

/// Which column of the file.
enum Column<'a> {
    /// Counts from 0.
    Number(usize),
    Heading(&'a str),
}

/// The file of a table.
struct File {
    name: String,
    text: String,
}

/// The points with the bytes of the file that each was read from.
struct Reading {
    points: Points,
    /// Empty where the file does not give them.
    bends: Vec<Bend>,
    places: Vec<Span>,
}

/// A table without its noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// Its section, `cam`.
    pub section: String,
    /// Lobes of U″ up to this height (per rad²) are noise that is left or swings of the smoothing.
    pub left: f64,
    /// Noise and largest change, for the users of the FMU, without a full stop.
    pub sentence: String,
}

/// A table that ends before its turn does.
pub struct Part {
    /// Its points.
    pub points: Points,
    /// Why it is no motion law.
    pub fault: Diagnostic,
}

/// The law of a section with `law = "table"`, or the part of one that it gives.
pub fn read(section: &Section<'_>, quantity: &'static Quantity, folder: &Path) -> Option<Result<MotionLaw, Part>> {
    let scale = section.optional("scale");
    let lift = if section.has("scale") { &unit::NUMBER } else { quantity };
    let lines = is_load(quantity) || section.text("law") == Some(Some("linear"));
    let usual = if lines { Interpolation::Linear } else { Interpolation::Spline };
    let interpolation = section.choice_or("interpolation", INTERPOLATIONS, usual);
    let harmonics = match interpolation {
        Some(Interpolation::Fourier) => section.count("harmonics").map(Some),
        _ => {
            section.forbid(&["harmonics"], "a spline has none", "interpolation = \"fourier\"");
            Some(None)
        }
    };
    let noise = noise(section);
    let kind = interpolation.unwrap_or(usual);
    if kind == Interpolation::Linear && !is_load(quantity) {
        let key = if section.has("interpolation") { "interpolation" } else { "law" };
        let fault = section.fault_of(key, ": lines have corners, at which the acceleration would be infinite");
        section.faults.report(fault.hint("choose law = \"table\" without `interpolation`, a spline"));
    }
    if matches!(kind, Interpolation::Derivatives | Interpolation::Linear) {
        section.forbid(&["noise"], "it is removed for the derivatives of a spline", "interpolation = \"spline\"");
    }
    let axes = [(&unit::ANGLE, "angle_unit", "angle_column"), (lift, "lift_unit", "lift_column")];
    let (file, mut reading) = points(section, axes, kind, folder)?;
    interpolation?;
    let scale = scale?.unwrap_or(1.0);
    reading.points.lifts.iter_mut().for_each(|lift| *lift *= scale);
    reading.bends.iter_mut().for_each(|bend| {
        let Bend { slope, before, behind } = *bend;
        *bend = Bend { slope: scale * slope, before: scale * before, behind: scale * behind };
    });
    let reading = match noise? {
        None => reading,
        Some(sigma) => smoothed(section, &file, reading, sigma, quantity)?,
    };
    law(section, &file, reading, (kind, harmonics?), quantity)
}

/// Values over values that ascend: the list `points` of a section, or the columns of its file.
pub fn pairs(section: &Section<'_>, axes: [Axis; 2], folder: &Path) -> Option<Vec<[f64; 2]>> {
    let (_, Reading { points, .. }) = points(section, axes, Interpolation::Spline, folder)?;
    Some(points.angles.into_iter().zip(points.lifts).map(|(x, y)| [x, y]).collect())
}

/// The points of a section with the file in which they stand.
fn points(section: &Section<'_>, axes: [Axis; 2], kind: Interpolation, folder: &Path) -> Option<(File, Reading)> {
    section.either("points", "file");
    let columns = axes.iter().enumerate().map(|(i, axis)| column(section, axis.2, i)).collect::<Vec<_>>();
    if section.has("points") {
        let keys = axes.map(|(_, unit, column)| [unit, column]);
        section.forbid(&keys.concat(), "every point has its own unit", "a file");
        let list = section.pairs("points", axes.map(|axis| axis.0))?;
        let file = File { name: section.faults.file.to_owned(), text: section.faults.text.to_owned() };
        let (values, places): (Vec<_>, Vec<_>) = list.into_iter().unzip();
        let (angles, lifts) = values.into_iter().map(|[angle, lift]| (angle, lift)).unzip();
        let reading = Reading { points: Points { angles, lifts }, bends: Vec::new(), places };
        let faults = descents(&reading, kind, axes[0].0).into_iter().map(|(span, message, hint)| {
            let fault = fault(&file, span, message);
            if let Some(hint) = hint { fault.hint(hint) } else { fault }
        });
        let faults: Vec<_> = faults.take(MOST_FAULTS).collect();
        return checked(section, file, "points", reading, faults);
    }
    let units = axes.map(|(quantity, key, _)| unit(section, key, quantity));
    let name = section.required_text("file", "a file with one point per line, or a list `points`", "lift.csv")?;
    let path = folder.join(name);
    section.faults.files.borrow_mut().push(path.clone());
    let text = match contents(&path) {
        Ok(text) => text,
        Err(reason) => {
            let fault = section.fault_of("file", format!(": {} {reason}", shown(&path)));
            let hint = if reason == NO_TEXT { SAVE_AS_TEXT } else { "the path is relative to the folder of the scene" };
            return section.refuse(fault.hint(hint));
        }
    };
    let file = File { name: shown(&path), text };
    let [first, second] = units;
    let (first, second) = (first?, second?);
    let convert = |a: f64, l: f64| (a * first.0 / first.1, l * second.0 / second.1);
    let mut columns = columns.into_iter();
    let columns = (columns.next()??, columns.next()??);
    let hint = "write plain numbers; their unit is that of the scene";
    let (reading, faults) = rows(&file, &columns, (kind, axes[0].0), hint, convert);
    checked(section, file, "file", reading, faults)
}

/// The points if they have no faults and are not too many.
fn checked(
    section: &Section<'_>,
    file: File,
    key: &'static str,
    reading: Reading,
    mut faults: Vec<Diagnostic>,
) -> Option<(File, Reading)> {
    if reading.places.len() > MOST_POINTS {
        let message = format!(" has {} points", reading.places.len());
        faults.push(section.fault_of(key, message).admissible(format!("at most {MOST_POINTS}")));
    }
    let right = faults.is_empty();
    faults.into_iter().for_each(|fault| section.faults.report(fault));
    right.then_some((file, reading))
}

/// The value of `noise`: the standard deviation that the lifts are to lose, which is None where they tell it themselves.
fn noise(section: &Section<'_>) -> Option<Option<Option<f64>>> {
    match section.word("noise") {
        Some(ESTIMATE) => Some(Some(None)),
        Some(other) => {
            section.unknown_word("noise", other, ESTIMATE);
            None
        }
        None => section.optional("noise").map(|sigma| sigma.map(Some)),
    }
}

/// The points without their noise; a note says what that changes.
fn smoothed(
    section: &Section<'_>,
    file: &File,
    reading: Reading,
    sigma: Option<f64>,
    quantity: &'static Quantity,
) -> Option<Reading> {
    let said = |value: f64| format!("{} {}", text::number(value), quantity.unit);
    let fault = match smooth(reading.points.clone(), sigma) {
        Ok(smooth) => {
            let [mean, largest] = smooth.changes.map(said);
            let (path, noise) = (section.path.clone(), said(smooth.noise));
            let origin = if sigma.is_some() { "given" } else { "estimated" };
            let sentence =
                format!("The table of {path} is smoothed: noise {noise} ({origin}), largest change {largest}");
            section.faults.smoothed.borrow_mut().push(Smoothed { section: path, left: smooth.left, sentence });
            let [half, other] = smooth.half.map(|order| format!("{order:.0}"));
            section.faults.note(format!(
                "`{}`: {} without its noise of {}: the lifts change by {mean} (root mean square), {largest} at most; harmonic \
                 {half} is halved (harmonic {other}, if all of the noise were taken out)",
                section.path, file.name, noise
            ));
            return Some(Reading { points: smooth.points, ..reading });
        }
        // The law tells what is wrong with the points themselves.
        Err(SmoothingError::Table(_)) => return Some(reading),
        Err(SmoothingError::NoNoise) => {
            section.faults.note(format!("`{}`: {} has no noise; its lifts are unchanged", section.path, file.name));
            return Some(reading);
        }
        Err(SmoothingError::NothingLeft(motion)) => section
            .fault_of("noise", ": nothing of the motion would be left")
            .admissible(format!("less than {}, its root mean square", said(motion))),
    };
    section.refuse(fault)
}

const NO_TEXT: &str = "is not a text file";
const SAVE_AS_TEXT: &str = "save the table as CSV in UTF-8";

/// The text of a table, or why there is none.
fn contents(path: &Path) -> Result<String, String> {
    match super::input::bytes(path) {
        Ok(bytes) if bytes.contains(&0) => Err(NO_TEXT.to_owned()),
        Ok(bytes) => Ok(String::from_utf8_lossy(&bytes).trim_start_matches(super::input::BYTE_ORDER_MARK).to_owned()),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Err("does not exist".to_owned()),
        Err(e) => Err(format!("cannot be read: {e}")),
    }
}

/// A measured course over a turn: angles (rad) and values, one point per line. Headings may tell their units, "M [kN.m]"; without
/// them angles are in degrees and other values in the unit `own`, a coherent one of `quantity` where that is known.
///
/// # Errors
/// A file that cannot be read, lines that hold no point, angles that do not rise or span more than a turn.
pub fn course(path: &Path, own: &str, quantity: Option<&'static Quantity>) -> Result<Points, Diagnostics> {
    let name = shown(path);
    let unreadable = |reason: String| Diagnostic::new(&name, reason).hint("name a table of angles and measured values");
    let text = contents(path).map_err(|reason| Diagnostics(vec![unreadable(format!("the curve {reason}"))]))?;
    let file = File { name: name.clone(), text: text.clone() };
    let headings = lines(&text).next().map(|line| cells(&text, line)).unwrap_or_default();
    let scale = |column: usize, quantity: Option<&'static Quantity>, usual: (f64, f64)| {
        let Some(cell) = headings.get(column) else { return Ok(usual) };
        let Some((_, told)) = text[cell.clone()].rsplit_once('[') else { return Ok(usual) };
        let told = told.trim_matches(['"', ' ', ']']);
        let wrong = |message: String, hint: String| Diagnostics(vec![fault(&file, cell.clone(), message).hint(hint)]);
        match quantity {
            Some(quantity) => units::factor(told, quantity).map_err(|fault| wrong(fault.message, fault.hint)),
            None if told == own => Ok(usual),
            None => {
                Err(wrong(format!("the unit {told} is not that of the diagram"), format!("give the values in {own}")))
            }
        }
    };
    let degree = std::f64::consts::PI / 180.0;
    let usual = if quantity == Some(&unit::ANGLE) { (degree, 1.0) } else { (1.0, 1.0) };
    let (angle, value) = (scale(0, Some(&unit::ANGLE), (degree, 1.0))?, scale(1, quantity, usual)?);
    let columns = (Column::Number(0), Column::Number(1));
    let convert = |a: f64, v: f64| (a * angle.0 / angle.1, v * value.0 / value.1);
    let (reading, mut faults) = rows(
        &file,
        &columns,
        (Interpolation::Spline, &unit::ANGLE),
        "write plain numbers; headings give their units",
        convert,
    );
    let angles = &reading.points.angles;
    if faults.is_empty() && angles.len() < 2 {
        let few = Diagnostic::new(&name, format!("a curve of {}", counted(angles.len(), "point")));
        faults.push(few.admissible("at least 2").hint("one angle and one value per line"));
    }
    // A course that is closed repeats its first angle one turn later.
    let beyond = angles.iter().position(|a| a - angles[0] > TAU + LEAST_DISTANCE);
    faults.extend(beyond.map(|i| {
        let message = format!("{} deg is more than a turn after the first angle", units::short(angles[i].to_degrees()));
        let first = units::short(angles[0].to_degrees());
        let end = units::short(angles[0].to_degrees() + 360.0);
        fault(&file, reading.places[i].clone(), message)
            .admissible(format!("{first} to {end} deg"))
            .hint("leave out further turns")
    }));
    if faults.is_empty() { Ok(reading.points) } else { Err(Diagnostics(faults)) }
}

/// The path, written alike on every platform.
fn shown(path: &Path) -> String {
    text::in_one_line(path.display()).replace('\\', "/")
}

/// The factor of the unit under `key`; SI where there is none.
fn unit(section: &Section<'_>, key: &'static str, quantity: &'static Quantity) -> Option<(f64, f64)> {
    let Some(text) = section.text(key)? else { return Some((1.0, 1.0)) };
    units::factor(text, quantity)
        .map_err(|fault| {
            section.faults.report(section.fault_of(key, format!(": {}", fault.message)).hint(fault.hint));
        })
        .ok()
}

/// A column by its number from 1 or its heading.
fn column<'a>(section: &Section<'a>, key: &'static str, default: usize) -> Option<Column<'a>> {
    let Some(node) = section.node(key) else { return Some(Column::Number(default)) };
    if let toml::de::DeValue::String(heading) = node.value {
        return Some(Column::Heading(heading.trim()));
    }
    section.count(key).map(|number| Column::Number(number - 1))
}

/// The points of the lines, and what is wrong with them: at most [`MOST_FAULTS`] one by one, and how many more there are;
/// `hint` says what a number looks like.
fn rows(
    file: &File,
    columns: &(Column<'_>, Column<'_>),
    (kind, first): (Interpolation, &'static Quantity),
    hint: &str,
    convert: impl Fn(f64, f64) -> (f64, f64),
) -> (Reading, Vec<Diagnostic>) {
    let mut wrong = Vec::new();
    let points = Points { angles: Vec::new(), lifts: Vec::new() };
    let mut reading = Reading { points, bends: Vec::new(), places: Vec::new() };
    let text = &file.text;
    let mut rows = lines(text).map(|line| (cells(text, line.clone()), line)).peekable();
    let headings = rows.next_if(|(cells, _)| cells.iter().all(|cell| number(text, cell).is_none()));
    let headings = headings.map(|(cells, _)| cells);
    let index = |column: &Column<'_>| index(file, column, headings.as_deref());
    let (angle_column, lift_column) = match (index(&columns.0), index(&columns.1)) {
        (Ok(angle), Ok(lift)) => (angle, lift),
        (angle, lift) => return (reading, [angle.err(), lift.err()].into_iter().flatten().collect()),
    };
    for (cells, line) in rows {
        let value = |index: usize| {
            let cell = cells.get(index).ok_or_else(|| {
                let message = format!("column {} is missing: this line has {}", index + 1, cells.len());
                (line.clone(), message, None)
            })?;
            number(text, cell).ok_or_else(|| {
                let message = format!("\"{}\" is not a finite number", &text[cell.clone()]);
                (cell.clone(), message, Some(hint))
            })
        };
        let derivatives: Vec<_> =
            (1..=if kind == Interpolation::Derivatives { 3 } else { 0 }).map(|n| value(lift_column + n)).collect();
        let derivatives: Result<Vec<f64>, Wrong<'_>> = derivatives.into_iter().collect();
        match (value(angle_column), value(lift_column), derivatives) {
            (Ok(angle), Ok(lift), Ok(derivatives)) => {
                // They are by the angle in rad.
                let per_rad = |derivative: &f64| convert(angle, *derivative).1;
                if let [slope, before, behind] = derivatives.iter().map(per_rad).collect::<Vec<_>>()[..] {
                    reading.bends.push(Bend { slope, before, behind });
                }
                let (angle, lift) = convert(angle, lift);
                reading.points.angles.push(angle);
                reading.points.lifts.push(lift);
                reading.places.push(line);
            }
            (angle, lift, more) => wrong.extend([angle.err(), lift.err(), more.err()].into_iter().flatten()),
        }
    }
    wrong.extend(descents(&reading, kind, first));
    let more = wrong.len().saturating_sub(MOST_FAULTS);
    // Only of these: the number of a line takes a look at all lines before it.
    let told = wrong.into_iter().take(MOST_FAULTS).map(|(span, message, hint)| {
        let fault = fault(file, span, message);
        if let Some(hint) = hint { fault.hint(hint) } else { fault }
    });
    let count = (more > 0)
        .then(|| Diagnostic::new(&file.name, format!("the table has {} like these", counted(more, "more fault"))));
    let faults = told.chain(count).collect();
    (reading, faults)
}

/// The lines with content.
fn lines(text: &str) -> impl Iterator<Item = Span> + '_ {
    let mut start = 0;
    text.split_inclusive('\n').filter_map(move |line| {
        let begin = start;
        start += line.len();
        let content = line.trim();
        let offset = begin + (line.len() - line.trim_start().len());
        (!content.is_empty() && !content.starts_with('#')).then(|| offset..offset + content.len())
    })
}

/// The cells of a line, without the blanks around them.
fn cells(text: &str, line: Span) -> Vec<Span> {
    let content = &text[line.clone()];
    let separator = [';', ',', '\t', ' '].into_iter().find(|c| content.contains(*c)).unwrap_or(';');
    let mut start = line.start;
    let mut cells = Vec::new();
    for piece in content.split(separator) {
        let cell = piece.trim();
        let offset = start + (piece.len() - piece.trim_start().len());
        // Several blanks are one separator.
        if separator != ' ' || !cell.is_empty() {
            cells.push(offset..offset + cell.len());
        }
        start += piece.len() + separator.len_utf8();
    }
    cells
}

fn number(text: &str, cell: &Span) -> Option<f64> {
    let cell = &text[cell.clone()];
    // A cell can hold a comma only where `;` or blanks separate; there it is a decimal comma.
    cell.replacen(',', ".", 1).parse().ok().filter(|value: &f64| value.is_finite())
}

fn fault(file: &File, span: Span, message: impl Into<String>) -> Diagnostic {
    Diagnostic::new(&file.name, message).at(&file.text, span)
}

/// The number of a column, from 0.
fn index(file: &File, column: &Column<'_>, headings: Option<&[Span]>) -> Result<usize, Diagnostic> {
    let heading = match *column {
        Column::Number(number) => return Ok(number),
        Column::Heading(heading) => heading,
    };
    let Some(cells) = headings else {
        let message = format!("the table has no headings to find the column \"{heading}\" by");
        return Err(Diagnostic::new(&file.name, message).hint("give the number of the column, from 1"));
    };
    let names: Vec<&str> = cells.iter().map(|cell| file.text[cell.clone()].trim_matches('"')).collect();
    names.iter().position(|name| *name == heading).ok_or_else(|| {
        let line = cells.first().map_or(0, |c| c.start)..cells.last().map_or(0, |c| c.end);
        fault(file, line, format!("there is no column \"{heading}\"")).admissible(names.join(", "))
    })
}

/// The points whose angle, or whatever comes first, does not exceed the one before; lines may step at one angle.
fn descents(reading: &Reading, kind: Interpolation, first: &'static Quantity) -> Vec<Wrong<'static>> {
    let angles = &reading.points.angles;
    let (steps, turn) = (kind == Interpolation::Linear, *first == unit::ANGLE);
    let (name, unit, factor) = if turn { ("angle", "deg", 360.0 / TAU) } else { ("value", first.unit, 1.0) };
    let hint = match (steps, turn) {
        (true, _) => "sort the points by ascending angle; two with one angle are a step",
        (_, true) => "sort the points by ascending angle, each once",
        _ => "sort the points, each once",
    };
    let wrong = (1..angles.len()).filter(|&i| angles[i] - angles[i - 1] < LEAST_DISTANCE);
    let wrong = wrong.filter(|&i| !steps || angles[i] != angles[i - 1] || i > 1 && angles[i] == angles[i - 2]);
    wrong
        .map(|i| {
            let [before, here] = [i - 1, i].map(|i| units::short(factor * angles[i]));
            let message = format!("the {name} {here} {unit} does not exceed the one before, {before} {unit}");
            (reading.places[i].clone(), message, Some(hint))
        })
        .collect()
}

/// The law through the points, or the series that meets them best.
fn law(
    section: &Section<'_>,
    file: &File,
    reading: Reading,
    (kind, harmonics): (Interpolation, Option<usize>),
    quantity: &'static Quantity,
) -> Option<Result<MotionLaw, Part>> {
    let bends = reading.bends.len();
    let most = largest(quantity);
    let beyond = reading.points.lifts.iter().position(|lift| !(lift.abs() <= most));
    let law = match harmonics {
        _ if let Some(index) = beyond => Err(TableError::OutOfRange { index, value: reading.points.lifts[index] }),
        None if kind == Interpolation::Linear => Polyline::new(reading.points.clone()).map(MotionLaw::Polyline),
        None if reading.bends.is_empty() => Table::new(reading.points.clone()).map(MotionLaw::Table),
        None => Table::bent(reading.points.clone(), reading.bends).map(MotionLaw::Table),
        Some(harmonics) => harmonic_analysis::analyse(reading.points.clone(), harmonics).map(|analysis| {
            let residual = format!("{} {}", text::number(analysis.largest_residual), quantity.unit);
            let of = format!("{} of {}", counted(harmonics, "harmonic"), file.name);
            section.faults.note(format!("`{}`: {of} meet its points to {residual}", section.path));
            MotionLaw::Fourier(analysis.series)
        }),
    };
    let error = match law {
        Ok(law) => return Some(Ok(law)),
        Err(error) => error,
    };
    let fault = match error.index() {
        Some(index) => fault(file, reading.places[index].clone(), words(&error, kind, quantity)),
        None => {
            let key = match error {
                TableError::TooManyHarmonics { .. } => "harmonics",
                _ if section.has("points") => "points",
                _ => "file",
            };
            section.fault_of(key, format!(": {}: {}", file.name, words(&error, kind, quantity)))
        }
    };
    let fault = fault.hint(advice(&error));
    // Series and the loss of noise are of the whole turn.
    let interpolated = kind == Interpolation::Spline && bends == 0 && !section.has("noise");
    match error {
        TableError::NotClosed { .. } | TableError::NotPeriodic { .. } if interpolated => {
            Some(Err(Part { points: reading.points, fault }))
        }
        _ => section.refuse(fault),
    }
}

/// Whether a law of this quantity moves nothing.
pub fn is_load(quantity: &Quantity) -> bool {
    [&unit::FORCE, &unit::TORQUE].contains(&quantity)
}

/// The fault, in the units of engineers.
fn words(error: &TableError, kind: Interpolation, quantity: &Quantity) -> String {
    let deg = |angle: f64| units::short(angle.to_degrees());
    match *error {
        TableError::NotPeriodic { first, last, .. } => format!(
            "the table is not periodic: the {of} {} {unit} one turn after the first point is not its {of} {} {unit}",
            units::short(last),
            units::short(first),
            of = if is_load(quantity) { "value" } else { "lift" },
            unit = quantity.unit
        ),
        TableError::TooFew { points } if kind == Interpolation::Linear => {
            format!("{}; lines need at least 2", counted(points, "point"))
        }
        TableError::NotClosed { gap, distance, .. } => format!(
            "the table ends here, {} deg before its turn does, with points at most {} deg apart",
            deg(gap),
            deg(distance)
        ),
        TableError::TooLong { span, .. } => {
            format!("this point is {} deg after the first one; a table covers one turn", deg(span))
        }
        TableError::OutOfRange { value, .. } => {
            format!(
                "{} is out of range: at most {:e} {} is admissible",
                units::short(value),
                largest(quantity),
                quantity.unit
            )
        }
        ref other => told(other),
    }
}

fn advice(error: &TableError) -> &'static str {
    match error {
        TableError::NotPeriodic { .. } => "the motion repeats after a turn: both points must have the same lift",
        TableError::NotClosed { .. } => "a table covers the whole turn, 360 deg; is `angle_unit` right?",
        TableError::TooLong { .. } => "leave out what is beyond 360 deg; is `angle_unit` right?",
        TableError::TooFew { .. } => "measure more points of the turn",
        TableError::TooManyHarmonics { .. } => "ask for fewer harmonics or give more points",
        _ => "check the point and the units of the table",
    }
}
