//! Tables of angles and lifts: a text file with one point per line, in one of the dialects of [`dialect`].

pub mod contour;
mod courses;
mod dialect;
mod turn;

pub use self::courses::{Courses, courses};
use self::dialect::{Column, RowFault, Sheet};
use self::turn::TurnScale;
use crate::document::{
    Diagnostic, Diagnostics, Section, Span, TableNote, Value, input, limits::largest, source, units,
};
use camdrive::drives::Fault;
use camdrive::drives::unit::{self, Quantity};
use camdrive::motion::table::{Bend, CLOSING, LEAST_DISTANCE, MOST_POINTS, Points, TableError};
use camdrive::motion::{MotionLaw, Polyline, Table};
use camdrive_design::harmonic_analysis;
use camdrive_design::overview::Warning;
use camdrive_design::report::{terminal, unit::Unit};
use camdrive_design::smoothing::{
    self, Corners, Jump, Outliers, SmoothedTable, SmoothingError, TableFaults, WrongRow, certain, found, smooth,
};
use camdrive_design::table_error::told;
use camdrive_design::text::{self, counted};
use std::cell::RefCell;
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// The most faults of one table that are listed.
const MOST_FAULTS: usize = 8;

/// The interpolation of U between the points.
#[derive(Clone, Copy, PartialEq)]
pub enum Interpolation {
    Spline,
    /// Pieces of degree 5 with U′ and U″ from the three columns after the lift.
    Derivatives,
    Fourier,
    /// Straight lines, with a step at two points of one angle.
    Linear,
    /// Cubics that stay in the range of their points, with steps likewise.
    Monotone,
}

impl Interpolation {
    /// True if two points at one angle form a step.
    fn steps(self) -> bool {
        matches!(self, Interpolation::Linear | Interpolation::Monotone)
    }
}

/// The treatment of two points at one angle.
#[derive(Clone, Copy, PartialEq)]
enum Twice {
    Never,
    /// At a step.
    Step,
    /// Tables with noise may have several values at one angle.
    Measured,
}

/// Two values differ by less than this many times the standard deviation of their noise, except once in 40,000.
const NOISE: f64 = 6.0;

/// A lobe with fewer rows does not show its noise: with its image it has the thirty rows of a short table.
const LEAST_OF_LOBE: usize = 16;

/// A spline gets a warning if it leaves the range of its neighbours by more than this fraction of the range of all points.
const OVERSHOOT: f64 = 0.01;

/// Slopes that differ by less than this fraction are equal: differences over a degree have this accuracy.
const SLOPES: f64 = 1e-3;

/// With few points true slopes are at most this many times the slopes from the lifts: both miss a wave between two points.
const LARGEST_SLOPES: f64 = 4.0;

/// Rounded values at both ends differ by at most this fraction of the range.
const ROUNDED: f64 = 2e-3;

/// The kinds of interpolation with their names.
const INTERPOLATIONS: &[(&str, Interpolation)] = &[
    ("spline", Interpolation::Spline),
    ("derivatives", Interpolation::Derivatives),
    ("fourier", Interpolation::Fourier),
    ("linear", Interpolation::Linear),
    ("monotone", Interpolation::Monotone),
];

/// The quantity of the points, and the keys for its unit and its column.
pub type Axis = (&'static Quantity, &'static str, &'static str);

/// The value of `noise` for an estimate.
const ESTIMATE: &str = "estimate";

/// The fraction of the stroke by which smoothing may change a lift without a warning; the noise of a probe is a tenth of it.
const LARGEST_CHANGE: f64 = 5e-3;

/// The file of a table.
struct File {
    name: String,
    text: String,
}

/// The points with their bytes in the file.
struct Reading {
    points: Points,
    /// Empty if the file does not contain them.
    bends: Vec<Bend>,
    places: Vec<Span>,
    /// The last digits of the lifts and of the slopes.
    digit: f64,
    slope_digit: f64,
    /// The points between which the cam is at rest.
    at_rest: Vec<usize>,
}

impl Reading {
    fn new(points: Points, places: Vec<Span>) -> Self {
        Reading { points, places, bends: Vec::new(), digit: 0.0, slope_digit: 0.0, at_rest: Vec::new() }
    }

    /// Joins two rows at one angle; the second one has U″ after it.
    fn joined(mut self) -> Self {
        let (mut kept, Points { angles, lifts }): (Vec<usize>, Points) = (Vec::new(), self.points);
        for i in 0..angles.len() {
            let same = |j: &&mut usize| {
                let slopes = [i, **j].map(|i| self.bends[i].slope);
                angles[i] == angles[**j] && lifts[i] == lifts[**j] && slopes[0] == slopes[1]
            };
            // A third row at this angle is a fault.
            let before = kept.last_mut().filter(|j| **j + 1 == i && same(j));
            match before {
                Some(j) => self.bends[*j].behind = self.bends[i].behind,
                None => kept.push(i),
            }
        }
        let of = |values: &[f64]| kept.iter().map(|i| values[*i]).collect();
        let (bends, places) = kept.iter().map(|i| (self.bends[*i], self.places[*i].clone())).unzip();
        Reading { points: Points { angles: of(&angles), lifts: of(&lifts) }, bends, places, ..self }
    }

    /// Removes wrong rows; the first row replaces a removed row that closes the turn.
    fn without(mut self, wrong: &[WrongRow]) -> Self {
        let (first, count) = (self.points.angles.first(), self.places.len());
        let closes = first.zip(self.points.angles.last()).is_some_and(|(first, last)| last - first >= TAU - CLOSING);
        let left_out = |i: usize| wrong.iter().any(|row| row.index == i || closes && row.index + count == i + 1);
        let kept: Vec<usize> = (0..count).filter(|i| !left_out(*i)).collect();
        self.points.angles = kept.iter().map(|i| self.points.angles[*i]).collect();
        self.points.lifts = kept.iter().map(|i| self.points.lifts[*i]).collect();
        self.places = kept.iter().map(|i| self.places[*i].clone()).collect();
        self.at_rest = self.at_rest.iter().filter_map(|i| kept.binary_search(i).ok()).collect();
        self
    }

    /// Adds points at jumps of U″; the periods are stretched to a turn.
    fn with(mut self, jumps: &[Jump], lobes: f64) -> Self {
        let corners: Vec<(f64, f64)> = jumps.iter().map(|jump| (jump.angle, jump.by)).collect();
        let Some(Corners { points, bends, rows }) = Corners::new(&self.points, &corners).filter(|_| !jumps.is_empty())
        else {
            return self;
        };
        self.places = rows.iter().map(|row| self.places[*row].clone()).collect();
        let by = |Bend { slope, before, behind }| {
            let [slope, before, behind] = [slope, lobes * before, lobes * behind].map(|value| lobes * value);
            Bend { slope, before, behind }
        };
        Reading { points, bends: bends.into_iter().map(by).collect(), ..self }
    }

    /// Repeats a period to a turn; the first `count` points are one period, stretched to a turn.
    fn repeat(&mut self, turn: &TurnScale<'_>, count: usize) {
        let angles = std::mem::take(&mut self.points.angles);
        let place = |k: usize, angle: f64| (angle + k as f64 * TAU) / turn.lobes as f64;
        self.points.angles =
            (0..turn.lobes).flat_map(|k| angles[..count].iter().map(move |angle| place(k, *angle))).collect();
        self.points.lifts = self.points.lifts[..count].repeat(turn.lobes);
        self.bends = self.bends[..count.min(self.bends.len())].repeat(turn.lobes);
        self.places = (0..turn.lobes).flat_map(|_| self.places[..count].to_vec()).collect();
        self.at_rest = (0..turn.lobes).flat_map(|k| self.at_rest.iter().map(move |i| k * count + i)).collect();
    }
}

/// A table that ends before its turn does.
pub struct Part {
    /// Its points.
    pub points: Points,
    /// Why it is no motion law.
    pub fault: Diagnostic,
}

/// The law of a section with `law = "table"`, or the part of a law in a table that ends early.
pub fn read(section: &Section<'_>, quantity: &'static Quantity, folder: &Path) -> Option<Result<MotionLaw, Part>> {
    let scale = section.optional("scale");
    let lift = if section.has("scale") { &unit::NUMBER } else { quantity };
    let usual = match () {
        // In a load without `law`, the points are corners.
        () if is_load(quantity) && !section.has("law") => Interpolation::Linear,
        () if section.text("law") == Some(Some("linear")) => Interpolation::Linear,
        () if is_motion(quantity) => Interpolation::Spline,
        () => Interpolation::Monotone,
    };
    let interpolation = section.choice_or("interpolation", INTERPOLATIONS, usual);
    let harmonics = match interpolation {
        Some(Interpolation::Fourier) => section.count("harmonics").map(Some),
        _ => {
            section.forbid(&["harmonics"], "a spline has none", "interpolation = \"fourier\"");
            Some(None)
        }
    };
    let (noise, drop) = (noise(section), section.choice_or("outliers", &[("drop", true)], false));
    let kind = interpolation.unwrap_or(usual);
    if kind == Interpolation::Linear && is_motion(quantity) {
        let key = if section.has("interpolation") { "interpolation" } else { "law" };
        let fault = section.fault_of(key, ": lines have corners, at which the acceleration would be infinite");
        section.faults.report(fault.hint("choose law = \"table\" without `interpolation`, a spline"));
    }
    if kind.steps() || kind == Interpolation::Derivatives {
        section.forbid(&["noise"], "it is removed only from a spline", "interpolation = \"spline\"");
        section.forbid(&["outliers"], "a spline is needed to find them", "interpolation = \"spline\"");
    }
    if kind == Interpolation::Derivatives {
        section.forbid(&["outside"], "the derivatives show where the cam is at rest", "interpolation = \"spline\"");
    }
    let turn = TurnScale::read(section);
    let angle = turn.as_ref().map_or(&unit::ANGLE, |turn| turn.quantity);
    let axes = [(angle, "angle_unit", "angle_column"), (lift, "lift_unit", "lift_column")];
    let twice = match () {
        () if kind.steps() => Twice::Step,
        () if section.has("noise") => Twice::Measured,
        () => Twice::Never,
    };
    let (file, mut reading) = points(section, axes, (kind, twice), turn.as_ref(), folder)?;
    let (scale, turn, noise, drop) = (scale?.unwrap_or(1.0), turn?, noise?, drop?);
    interpolation?;
    if scale == 0.0 {
        let fault = section.fault_of("scale", ": nothing would be left");
        return section.refuse(fault.admissible("a value other than 0"));
    }
    reading.points.lifts.iter_mut().for_each(|lift| *lift *= scale);
    reading.digit *= scale.abs();
    reading.bends.iter_mut().for_each(|bend| {
        let Bend { slope, before, behind } = *bend;
        *bend = Bend { slope: scale * slope, before: scale * before, behind: scale * behind };
    });
    if reading.places.len().saturating_mul(turn.lobes) > MOST_POINTS {
        let fault = section.fault_of("period", format!(": {} times {} points", turn.lobes, reading.places.len()));
        return section.refuse(fault.admissible(format!("at most {MOST_POINTS} points over the turn")));
    }
    // One period is handled as a turn, and repeated at the end.
    reading.points.angles.iter_mut().for_each(|angle| *angle *= turn.lobes as f64);
    let mut reading = closed(section, &file, reading, noise.flatten(), (kind, &turn, quantity))?;
    if kind == Interpolation::Derivatives
        && let Some(wrong) = seam(&mut reading).or_else(|| slopes(&reading, turn.lobes as f64))
    {
        faults(&file, vec![wrong]).into_iter().for_each(|fault| section.faults.report(fault));
        return None;
    }
    let interpretation = (kind, &turn, quantity);
    let mut reading = match noise {
        Some(sigma) => smoothed(section, &file, reading, (sigma, drop), interpretation)?,
        None if matches!(kind, Interpolation::Spline | Interpolation::Fourier) && !is_load(quantity) => {
            right(section, &file, reading, drop, interpretation)?
        }
        None => reading,
    };
    if turn.lobes > 1 {
        // A repeated part must be one whole period, without a step between two of them.
        let lifts = &reading.points.lifts;
        let error = match (reading.points.check(kind.steps()), &lifts[..]) {
            (Ok(true), &[first, .., last]) if kind.steps() && last != first => {
                Err(TableError::NotPeriodic { index: lifts.len() - 1, first, last })
            }
            (Ok(_), [] | [_]) => Err(TableError::TooFew { points: lifts.len() }),
            (checked, _) => checked,
        };
        match error {
            Ok(closes) => reading.repeat(&turn, lifts.len() - usize::from(closes)),
            Err(error) => return section.refuse(faulty(section, &file, &reading.places, &error, interpretation)),
        }
    }
    law(section, &file, reading, harmonics?, interpretation)
}

/// Values over ascending values: the list `points` of a section, or the columns of its file.
pub fn pairs(section: &Section<'_>, axes: [Axis; 2], folder: &Path) -> Option<Vec<[f64; 2]>> {
    let (_, Reading { points, .. }) = points(section, axes, (Interpolation::Spline, Twice::Never), None, folder)?;
    Some(points.angles.into_iter().zip(points.lifts).map(|(x, y)| [x, y]).collect())
}

/// The points of a section and their file; the angles of a `turn` are in rad.
fn points<'a>(
    section: &Section<'a>,
    axes: [Axis; 2],
    (kind, twice): (Interpolation, Twice),
    turn: Option<&TurnScale<'a>>,
    folder: &Path,
) -> Option<(File, Reading)> {
    section.either("points", "file");
    let columns = axes.iter().enumerate().map(|(i, axis)| column(section, axis.2, i)).collect::<Vec<_>>();
    let per_rad = turn.map_or(1.0, |turn| turn.per_rad);
    let told = |first: f64| match turn {
        Some(turn) => turn.shown(first),
        None => format!("{} {}", units::short(first), axes[0].0.unit),
    };
    let name = if turn.is_some() || *axes[0].0 == unit::ANGLE { "angle" } else { "value" };
    if section.has("points") {
        let keys = axes.map(|(_, unit, column)| [unit, column]);
        section.forbid(&keys.concat(), "every point has its own unit", "a file");
        let list = section.pairs("points", axes.map(|axis| axis.0))?;
        let file = File { name: section.faults.file.to_owned(), text: section.faults.document.text.clone() };
        let (values, places): (Vec<_>, Vec<_>) = list.into_iter().unzip();
        let (angles, lifts) = values.into_iter().map(|[angle, lift]| (angle / per_rad, lift)).unzip();
        let reading = Reading::new(Points { angles, lifts }, places);
        let wrong = descents(&reading, twice, name, &told);
        return checked(section, file, "points", reading, wrong);
    }
    let of_turn = turn.and_then(|turn| turn.unit);
    let file = open(section, "a file with one point per line, or a list `points`", folder);
    // Wrong units are reported even if the file is missing.
    let [angle_unit, lift_unit] = [(0, of_turn), (1, None)].map(|(i, own)| unit(section, axes[i].1, axes[i].0, own));
    let file = file?;
    angle_unit.and(lift_unit)?;
    let mut columns = columns.into_iter();
    let mut columns = [columns.next()??, columns.next()??];
    let step = turn.and_then(|turn| turn.step);
    if step.is_some() {
        section.forbid(&["angle_column"], "the angles follow from `angle_step`", "a column of the angles");
        columns = match (section.has("lift_column"), columns) {
            (true, [_, lifts]) => [Column::Rows, lifts],
            (false, _) => [Column::Rows, Column::Number(0)],
        };
    }
    let hint = "write plain numbers, without units and thousands separators; the scene sets their unit";
    let more = if kind == Interpolation::Derivatives { 3 } else { 0 };
    let sheet = Sheet::new(&file.text).map_err(|wrong| vec![wrong]);
    let (reading, wrong) = match sheet.and_then(|sheet| Ok((sheet.rows(&columns, more, hint)?, sheet))) {
        Err(wrong) => (Reading::new(Points { angles: Vec::new(), lifts: Vec::new() }, Vec::new()), wrong),
        Ok((rows, sheet)) => {
            noted(section, &file, rows.doubtful, "a heading");
            noted(section, &file, rows.trailer, "the end of the table");
            let [first, second] = [(0, of_turn), (1, None)].map(|(i, own)| match step {
                Some(_) if i == 0 => Some((1.0, 1.0)),
                _ => unit_of(section, axes[i].1, axes[i].0, &sheet, rows.columns[i], own),
            });
            let (first, second) = (first?, second?);
            // Derivatives are with respect to the angle in rad, or to the column's angle if the unit in their heading says so.
            let per = [1, 2, 2].into_iter().zip(1..).map(|(order, column)| {
                let unit = sheet.unit(rows.columns[1] + column).filter(|_| column < rows.columns.len() - 1);
                let Some((span, unit)) = unit else { return Ok(second.0 / second.1 * per_rad.powi(order.into())) };
                let (numerator, denominator) = units::per(&unit, axes[1].0, axes[0].0, order).ok_or_else(|| {
                    let message = format!("\"{unit}\" is no unit of a derivative of U by the angle");
                    RowFault::at(
                        &span,
                        message,
                        "write for example \"V [mm/deg]\" and \"A [mm/deg2]\", or leave the unit out",
                    )
                })?;
                Ok(numerator / denominator * per_rad.powi(order.into()))
            });
            let per: Vec<f64> = match per.collect() {
                Ok(per) => per,
                Err(wrong) => {
                    faults(&file, vec![wrong]).into_iter().for_each(|fault| section.faults.report(fault));
                    return None;
                }
            };
            let angle = |row: &[f64]| step.map_or(row[0] * first.0 / first.1, |step| row[0] * step) / per_rad;
            let lift = |row: &[f64]| row[1] * second.0 / second.1;
            let bend = |row: &[f64]| {
                let [_, _, slope, before, ref behind @ ..] = *row else { return None };
                let behind = behind.first().map_or(per[1] * before, |behind| per[2] * behind);
                Some(Bend { slope: per[0] * slope, before: per[1] * before, behind })
            };
            let (angles, lifts) = rows.rows.iter().map(|(row, _)| (angle(row), lift(row))).unzip();
            let bends = rows.rows.iter().filter_map(|(row, _)| bend(row)).collect();
            let places = rows.rows.into_iter().map(|(_, span)| span).collect();
            let digit = rows.digits[1] * second.0 / second.1;
            let slope_digit = per[0] * rows.digits.get(2).copied().unwrap_or(0.0);
            let reading = Reading { bends, digit, slope_digit, ..Reading::new(Points { angles, lifts }, places) };
            let reading = if more > 0 { reading.joined() } else { reading };
            let wrong = descents(&reading, twice, name, &told);
            (reading, wrong)
        }
    };
    checked(section, file, "file", reading, wrong)
}

/// The file of a section.
fn open(section: &Section<'_>, admissible: &str, folder: &Path) -> Option<File> {
    let name = section.required_text("file", admissible, "lift.csv")?;
    let path = folder.join(name);
    let text = match contents(&path) {
        Ok((text, note, content)) => {
            let key = section.path_of("file");
            let table = source::TableFile { path: path.clone(), content, name: name.to_owned(), key };
            section.faults.tables.borrow_mut().push(table);
            let note = note.map(|note| format!("`{}`: {} {note}", section.path, shown(&path)));
            note.into_iter().for_each(|note| section.faults.note(note));
            text
        }
        Err((reason, hint)) => {
            let fault = section.fault_of("file", format!(": {} {reason}", shown(&path)));
            return section.refuse(fault.hint(hint.unwrap_or("the path is relative to the folder of the scene")));
        }
    };
    Some(File { name: shown(&path), text })
}

/// Notes on lines that are `taken` as something else but could be points.
fn noted(section: &Section<'_>, file: &File, lines: Vec<Span>, taken: &str) {
    for span in lines.into_iter().take(MOST_FAULTS) {
        let line = file.text[..span.start].matches('\n').count() + 1;
        // The start of the line identifies it.
        let text = text::in_one_line(file.text[span].chars().take(40).collect::<String>());
        let message = format!("line {line} of {}, \"{text}\", is taken as {taken}", file.name);
        section.faults.note(format!("`{}`: {message}", section.path));
    }
}

/// The points if they have no faults and are not too many.
fn checked(
    section: &Section<'_>,
    file: File,
    key: &'static str,
    reading: Reading,
    wrong: Vec<RowFault>,
) -> Option<(File, Reading)> {
    let mut faults = faults(&file, wrong);
    if reading.places.len() > MOST_POINTS {
        let message = format!(" has {} points", reading.places.len());
        faults.push(section.fault_of(key, message).admissible(format!("at most {MOST_POINTS}")));
    }
    let right = faults.is_empty();
    faults.into_iter().for_each(|fault| section.faults.report(fault));
    right.then_some((file, reading))
}

/// The value of `noise`: the standard deviation of the lifts' noise; the inner None asks for an estimate.
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

type Rough = (Points, Option<f64>, Outliers, Vec<usize>);
type Smooth = Result<SmoothedTable, SmoothingError>;

thread_local! {
    static LAST: RefCell<Option<(Rough, Smooth)>> = const { RefCell::new(None) };
}

/// See [`smooth`]. The last table is kept: variants of a scene, as a page draws them, have the same one, and half a second is long.
fn smoothed_once(rough: Rough) -> Smooth {
    LAST.with_borrow_mut(|last| {
        let is_new = last.as_ref().is_none_or(|(of, _)| *of != rough);
        if is_new {
            let (points, sigma, outliers, at_rest) = &rough;
            let smooth = smooth(points.clone(), *sigma, *outliers, at_rest);
            *last = Some((rough, smooth));
        }
        last.as_ref().expect("the last one").1.clone()
    })
}

/// The points without their noise; a note states the change.
fn smoothed(
    section: &Section<'_>,
    file: &File,
    reading: Reading,
    (sigma, drop): (Option<f64>, bool),
    interpretation: Interpretation<'_>,
) -> Option<Reading> {
    let (_, turn, quantity) = interpretation;
    let lobes = turn.lobes as f64;
    let said = |value: f64| terminal::shown(value, &Unit::of(quantity.unit));
    let fault = match smoothed_once((reading.points.clone(), sigma, outliers(drop), reading.at_rest.clone())) {
        Ok(smooth) => {
            report_wrong(section, file, &reading, (&smooth.found.wrong, drop), interpretation)?;
            let [mean, largest] = smooth.changes.map(said);
            let (path, noise) = (section.path.clone(), said(smooth.noise));
            let percent = format!("{} % of the stroke", text::number(100.0 * smooth.part));
            section.faults.note(format!(
                "`{path}`: {}: smoothing with a noise of {noise} changes the lifts by {mean} rms, at most {largest} ({percent}); \
                 its cut-off (half amplitude) is harmonic {:.0}",
                file.name,
                lobes * smooth.half
            ));
            let origin = if sigma.is_some() { "given" } else { "estimated" };
            let mut sentence =
                format!("The table of {path} is smoothed: noise {noise} ({origin}), largest change {largest}");
            if !smooth.found.wrong.is_empty() {
                sentence += &format!(", {} left out", counted(smooth.found.wrong.len(), "wrong row"));
            }
            let warning = (smooth.part > LARGEST_CHANGE).then(|| Warning {
                message: format!("{path}: smoothing changes a lift of {} by {largest}, {percent}", file.name),
                hint: "give a smaller `noise`, or measure more points where the motion is fast".to_owned(),
            });
            let left = lobes * lobes * smooth.left;
            section.faults.smoothed.borrow_mut().push(TableNote { section: path, left, sentence, warning });
            warn_of_jumps(section, file, &reading, (&smooth.found, &[]), interpretation);
            let (points, mut places) = (smooth.points, Vec::new());
            for (point, place) in smooth.point.iter().zip(&reading.places) {
                if *point == places.len() {
                    places.push(place.clone());
                }
            }
            places.extend(reading.places.last().cloned());
            return Some(Reading { points, places, at_rest: smooth.at_rest, ..reading });
        }
        Err(SmoothingError::Wrong(wrong)) => {
            report_wrong(section, file, &reading, (&wrong, false), interpretation)?;
            return None;
        }
        Err(SmoothingError::Table(error)) => faulty(section, file, &reading.places, &error, interpretation),
        Err(SmoothingError::NoNoise) => {
            section.faults.note(format!("`{}`: {} has no noise; its lifts are unchanged", section.path, file.name));
            let mut reading = reading;
            if let [first, ..] = reading.at_rest[..] {
                let level = reading.points.lifts[first];
                [0, first - 1].into_iter().for_each(|end| reading.points.lifts[end] = level);
            }
            return right(section, file, reading, drop, interpretation);
        }
        Err(SmoothingError::NothingLeft(motion)) => section
            .fault_of("noise", ": no motion would be left")
            .admissible(format!("less than {}, its root mean square", said(motion))),
    };
    section.refuse(fault)
}

fn outliers(drop: bool) -> Outliers {
    if drop { Outliers::Drop } else { Outliers::Refuse }
}

/// The rows without the wrong ones, if wrong rows may be left out.
fn right(
    section: &Section<'_>,
    file: &File,
    reading: Reading,
    drop: bool,
    interpretation: Interpretation<'_>,
) -> Option<Reading> {
    let found = found(reading.points.clone(), outliers(drop));
    report_wrong(section, file, &reading, (&found.wrong, drop), interpretation)?;
    if !found.wrong.is_empty() {
        let (section_of, rows) = (section.path.clone(), counted(found.wrong.len(), "wrong row"));
        let verb = if found.wrong.len() == 1 { "is" } else { "are" };
        let sentence = format!("{rows} of the table of {section_of} {verb} left out");
        let smoothed = TableNote { section: section_of, left: 0.0, sentence, warning: None };
        section.faults.smoothed.borrow_mut().push(smoothed);
    }
    let reading = reading.without(&found.wrong);
    // The spline is at rest outside the ends of a lobe.
    let splits = interpretation.0 == Interpolation::Spline && reading.at_rest.is_empty();
    let jumps = if splits { certain(&reading.points, &found.jumps) } else { Vec::new() };
    warn_of_jumps(section, file, &reading, (&found, &jumps), interpretation);
    Some(reading.with(&jumps, interpretation.1.lobes as f64))
}

/// The most angles that a warning lists.
const MOST_ANGLES: usize = 8;

/// Warns of outliers and jumps, separately for jumps that the spline has, with their angles and the largest size.
fn warn_of_jumps(
    section: &Section<'_>,
    file: &File,
    reading: &Reading,
    (found, kept): (&TableFaults, &[Jump]),
    (_, turn, quantity): Interpretation<'_>,
) {
    let of = if is_motion(quantity) { "lift" } else { "value" };
    let (shown, lobes) = (shown_in(section, quantity), turn.lobes as f64);
    let size = |value: f64, order: i32| shown(&text::number, value * (lobes * 1_f64.to_radians()).powi(order));
    let warn = |at: Vec<(String, f64)>, order: i32, what: &dyn Fn(&str, String) -> String, hint: &str| {
        let largest = at.iter().fold(0.0_f64, |most, (_, by)| most.max(by.abs()));
        let mut angles = at.iter().take(MOST_ANGLES).map(|(at, _)| at.as_str()).collect::<Vec<_>>().join(", ");
        if at.len() > MOST_ANGLES {
            angles += &format!(" and at {} other angles", at.len() - MOST_ANGLES);
        }
        if !at.is_empty() {
            let message = format!("{}: {} {}", section.path, what(&angles, size(largest, order)), file.name);
            let (sentence, section_of) = (message.clone(), section.path.clone());
            let warning = Some(Warning { message, hint: hint.to_owned() });
            section.faults.smoothed.borrow_mut().push(TableNote { section: section_of, left: 0.0, sentence, warning });
        }
    };
    let angle = |row: &WrongRow| turn.shown(reading.points.angles[row.index] / lobes);
    let speck = |rows: &Vec<WrongRow>| {
        let by = rows.iter().fold(0.0_f64, |most, row| if row.by.abs() > most.abs() { row.by } else { most });
        let [first, .., last] = &rows[..] else { return (rows.iter().map(&angle).collect(), by) };
        (format!("{} to {}", angle(first), angle(last)), by)
    };
    // Their places between the rows have no higher accuracy.
    let hundredths = |angle: f64| ((100.0 * angle.to_degrees()).round() / 100.0).to_radians();
    let listed = |jump: &Jump| (turn.shown(hundredths(jump.angle / lobes)), jump.by);
    let is_kept = |jump: &&Jump| kept.iter().any(|other| other.is_at(jump));
    let jumps = |order: usize| {
        let jumps = found.jumps.iter().filter(|jump| jump.order == order && !is_kept(jump));
        jumps.map(listed).collect()
    };
    let rows = |at: &str, by| format!("neighbouring rows at {at} are off together by up to {by} in");
    let hint = "measure again there, or leave them out with `outliers = \"drop\"`";
    warn(found.specks.iter().map(speck).collect(), 0, &rows, hint);
    let hint = "correct the rows before or after these angles";
    warn(jumps(0), 0, &|at, by| format!("the {of} itself jumps at {at}, by up to {by}, in"), hint);
    let hint = "give the law a ramp there; for lifts minus a clearance, give the whole lift";
    let kink =
        |at: &str, by| format!("kinks, where the acceleration is infinite: U′ jumps at {at}, by up to {by}/°, in");
    warn(jumps(1), 1, &kink, hint);
    let hint = "give the law itself, or U′ and U″ in columns with interpolation = \"derivatives\"";
    let jump = |at: &str, by| {
        format!("U″ jumps at {at}, by up to {by}/°², and the spline overshoots there by up to a fifth, in")
    };
    warn(jumps(2), 2, &jump, hint);
    let hint = "it excites vibration at every passage: if the law has no such jumps, give U′ and U″ with interpolation = \"derivatives\"";
    let jump = |at: &str, by| format!("U″ jumps at {at}, by up to {by}/°², and the spline has these jumps, in");
    warn(kept.iter().map(listed).collect(), 2, &jump, hint);
}

/// A value in the units of the file.
fn shown_in<'a>(
    section: &Section<'a>,
    quantity: &'static Quantity,
) -> impl Fn(&dyn Fn(f64) -> String, f64) -> String + use<'a> {
    let unit = section.text("lift_unit").flatten().filter(|_| !section.has("scale"));
    let factor = unit.and_then(|unit| Some((unit, units::factor(unit, quantity).ok()?)));
    let (unit, (numerator, denominator)) = factor.unwrap_or((quantity.unit, (1.0, 1.0)));
    move |digits, value| format!("{} {unit}", digits(value * denominator / numerator))
}

/// Refuses wrong rows, or notes that they are left out.
fn report_wrong(
    section: &Section<'_>,
    file: &File,
    reading: &Reading,
    (wrong, drop): (&[WrongRow], bool),
    (_, turn, quantity): Interpretation<'_>,
) -> Option<()> {
    let shown = shown_in(section, quantity);
    for WrongRow { index, by, times } in wrong {
        let message = format!(
            "the {} at {} is {} off a smooth law through the other rows, {times:.0} times the noise",
            if is_motion(quantity) { "lift" } else { "value" },
            turn.shown(reading.points.angles[*index] / turn.lobes as f64),
            shown(&text::number, *by)
        );
        let fault = fault(file, reading.places[*index].clone(), message);
        if drop {
            let line = fault.position.as_ref().map_or(0, |at| at.line);
            let message = format!("line {line} of {} is left out: {}", file.name, fault.message);
            section.faults.note(format!("`{}`: {message}", section.path));
        } else {
            section.faults.report(fault.hint("correct the row, or leave it out with `outliers = \"drop\"`"));
        }
    }
    (drop || wrong.is_empty()).then_some(())
}

const SAVE_AS_TEXT: Option<&str> = Some("save the table as CSV in UTF-8");

/// The reason why a file is no table, and a remedy if it is not at the same place.
type NoTable = (String, Option<&'static str>);

/// The text of a table, a remark on its bytes, and the bytes.
fn contents(path: &Path) -> Result<(String, Option<&'static str>, Vec<u8>), NoTable> {
    match input::bytes(path) {
        Ok(bytes) if let Some(what) = input::foreign(&bytes) => Err((format!("is {what}"), SAVE_AS_TEXT)),
        Ok(bytes) => match dialect::decode(&bytes) {
            Some((text, note)) => Ok((text, note, bytes)),
            None => Err(("is not a text file".to_owned(), SAVE_AS_TEXT)),
        },
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Err(("does not exist".to_owned(), None)),
        Err(e) => Err((format!("cannot be read: {e}"), None)),
    }
}

/// A measured curve over a turn: angles (rad) and values, one point per line. Headings may contain the units, "M [kN.m]"; otherwise
/// angles are in degrees and values in the unit `own`, a coherent unit of `quantity` if that is known.
///
/// # Errors
/// A file that cannot be read, lines without a point, angles that do not rise or span more than a turn.
pub fn course(path: &Path, own: &str, quantity: Option<&'static Quantity>) -> Result<Points, Diagnostics> {
    let name = shown(path);
    let (text, ..) = contents(path).map_err(|(reason, hint)| {
        let fault = Diagnostic::new(&name, format!("the curve {reason}"));
        Diagnostics(vec![fault.hint(hint.unwrap_or("name a table of angles and measured values"))])
    })?;
    let file = File { name: name.clone(), text };
    let told = |wrong: Vec<RowFault>| Diagnostics(faults(&file, wrong));
    let sheet = Sheet::new(&file.text).map_err(|wrong| told(vec![wrong]))?;
    let scale = |column: usize, quantity: Option<&'static Quantity>, usual: (f64, f64)| {
        let alone = || sheet.headings(column).find_map(|heading| headed(heading, quantity?));
        let Some((cell, unit)) = sheet.unit(column) else {
            let factor = alone().and_then(|unit| units::factor(unit, quantity?).ok());
            return Ok(factor.unwrap_or(usual));
        };
        let wrong = |found: Fault| Diagnostics(vec![fault(&file, cell.clone(), &found.message).remedy(found.0.hint)]);
        match quantity {
            Some(quantity) => units::factor(&unit, quantity).map_err(wrong),
            None if unit == own => Ok(usual),
            None => {
                let found = Fault::new(format!("the unit {unit} is not the diagram's"));
                Err(wrong(found.hint(format!("give the values in {own}"))))
            }
        }
    };
    let degree = std::f64::consts::PI / 180.0;
    let usual = if quantity == Some(&unit::ANGLE) { (degree, 1.0) } else { (1.0, 1.0) };
    let (angle, value) = (scale(0, Some(&unit::ANGLE), (degree, 1.0))?, scale(1, quantity, usual)?);
    let columns = [Column::Number(0), Column::Number(1)];
    let rows = sheet.rows(&columns, 0, "write plain numbers; headings give their units").map_err(told)?.rows;
    let converted = |row: &[f64]| (row[0] * angle.0 / angle.1, row[1] * value.0 / value.1);
    let (angles, lifts) = rows.iter().map(|(row, _)| converted(row)).unzip();
    let reading = Reading::new(Points { angles, lifts }, rows.into_iter().map(|(_, span)| span).collect());
    let in_degrees = |angle: f64| format!("{} deg", units::short(angle.to_degrees()));
    let mut faults = faults(&file, descents(&reading, Twice::Never, "angle", &in_degrees));
    let angles = &reading.points.angles;
    if faults.is_empty() && angles.len() < 2 {
        let few = Diagnostic::new(&name, format!("a curve of {} points", angles.len()));
        faults.push(few.admissible("at least 2").hint("one angle and one value per line"));
    }
    // A closed curve repeats its first angle one turn later.
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

/// The path in the same form on every platform.
fn shown(path: &Path) -> String {
    text::in_one_line(path.display()).replace('\\', "/")
}

/// The factor of the unit under `key`; without the key, of `own`, or SI.
fn unit(
    section: &Section<'_>,
    key: &'static str,
    quantity: &'static Quantity,
    own: Option<&str>,
) -> Option<(f64, f64)> {
    let Some(text) = section.text(key)?.or(own) else { return Some((1.0, 1.0)) };
    // Encoder steps may have any unit.
    if own.is_none() && *quantity == unit::NUMBER && key == "angle_unit" {
        return Some((1.0, 1.0));
    }
    units::factor(text, quantity)
        .map_err(|fault| {
            section.faults.report(section.fault_of(key, format!(": {}", fault.message)).remedy(fault.0.hint));
        })
        .ok()
}

/// Units that headings contain without brackets, "s_mm" or "Hub in mm"; others such as m, N or in may also be letters or words.
const PLAIN: [&str; 12] = ["mm", "um", "µm", "μm", "deg", "°", "rad", "kN", "kN.m", "rpm", "Nm", "N.m"];

/// The name in a heading such as "x_mm" or "r [mm]", and its unit.
fn named(heading: &str) -> (String, Option<&str>) {
    let (name, unit) = match (heading.rsplit_once(['[', '(']), heading.rsplit_once(['_', ' '])) {
        (Some((name, unit)), _) => (name, Some(unit.trim_end_matches([']', ')', ' ']))),
        // After a number it is part of a value, "probe 3 mm".
        (None, Some((name, unit))) if PLAIN.contains(&unit) && !name.ends_with(|c: char| c.is_ascii_digit()) => {
            (name, Some(unit))
        }
        _ if PLAIN.contains(&heading) => ("", Some(heading)),
        _ => (heading, None),
    };
    // "grad" in a German heading means degrees, not giga-radians.
    (name.trim().to_lowercase(), unit.filter(|unit| !unit.eq_ignore_ascii_case("grad")))
}

/// The unit in the heading of a column of this quantity, or the heading itself if it is a unit of several letters.
fn headed<'a>(heading: &'a str, quantity: &'static Quantity) -> Option<&'a str> {
    let alone = || heading.chars().count() > 1 && units::factor(heading, quantity).is_ok();
    named(heading).1.or_else(|| alone().then_some(heading))
}

/// The factor of the unit under `key`; without the key, of the unit in the heading of this column, of `own`, or SI.
fn unit_of(
    section: &Section<'_>,
    key: &'static str,
    quantity: &'static Quantity,
    sheet: &Sheet<'_>,
    column: usize,
    own: Option<&str>,
) -> Option<(f64, f64)> {
    // Numbers in a scale and encoder steps may have any heading.
    let units =
        || sheet.headings(column).filter(|_| *quantity != unit::NUMBER).filter_map(|heading| headed(heading, quantity));
    let told = units().find_map(|unit| Some((unit, units::factor(unit, quantity).ok()?)));
    let other = units().find(|unit| !["", "-", "%", "1"].contains(unit)).filter(|_| told.is_none());
    let given = section.has(key);
    if let Some(other) = other {
        let holds = if given { format!("`{key}` holds") } else { format!("taken in {}", own.unwrap_or(quantity.unit)) };
        let message =
            format!("\"{other}\" in the heading of column {} is not the unit of {}", column + 1, units::name(quantity));
        section.faults.note(format!("`{}`: {message}; {holds}", section.path));
    }
    let (above, below) = match told {
        Some((_, factor)) if !given => factor,
        _ => unit(section, key, quantity, own)?,
    };
    match told {
        Some((told, (a, b))) if a * below != b * above => {
            let message = format!(": the heading of its column says {told}");
            section.refuse(section.fault_of(key, message).hint("leave it out, or correct the heading"))
        }
        _ => Some((above, below)),
    }
}

/// A column by its number from 1 or its heading.
fn column<'a>(section: &Section<'a>, key: &'static str, default: usize) -> Option<Column<'a>> {
    let Some(node) = section.node(key) else { return Some(Column::Number(default)) };
    if let Value::Text(heading) = node.value {
        return Some(Column::Heading(heading.trim()));
    }
    section.count(key).map(|number| Column::Number(number - 1))
}

/// The faults of a file: at most [`MOST_FAULTS`] in a list, and the number of further ones.
fn faults(file: &File, wrong: Vec<RowFault>) -> Vec<Diagnostic> {
    let more = wrong.len().saturating_sub(MOST_FAULTS);
    // Only for these: the number of a line needs a look at all lines before it.
    let told = wrong.into_iter().take(MOST_FAULTS).map(|RowFault { span, message, admissible, hint }| {
        let fault = match span {
            Some(span) => fault(file, span, message),
            None => Diagnostic::new(&file.name, message),
        };
        let fault = if let Some(names) = admissible { fault.admissible(names) } else { fault };
        fault.remedy(hint.map(str::to_owned))
    });
    let count = (more > 0).then(|| Diagnostic::new(&file.name, format!("the table has {more} more faults like these")));
    told.chain(count).collect()
}

fn fault(file: &File, span: Span, message: impl Into<String>) -> Diagnostic {
    Diagnostic::new(&file.name, message).at(&file.text, span)
}

/// The points whose first coordinate does not exceed the previous one's; a step may have two points at one angle.
fn descents(reading: &Reading, twice: Twice, name: &str, told: &dyn Fn(f64) -> String) -> Vec<RowFault> {
    let (angles, steps) = (&reading.points.angles, twice == Twice::Step);
    let hint = match (twice, name) {
        (Twice::Step, _) => "sort the points by ascending angle; two with one angle are a step",
        (Twice::Measured, _) => "sort the points by ascending angle",
        (_, "angle") => "sort the points by ascending angle, each once",
        _ => "sort the points, each once",
    };
    let least = if twice == Twice::Measured { 0.0 } else { LEAST_DISTANCE };
    let wrong = (1..angles.len()).filter(|&i| angles[i] - angles[i - 1] < least);
    let wrong = wrong.filter(|&i| !steps || angles[i] != angles[i - 1] || i > 1 && angles[i] == angles[i - 2]);
    wrong
        .map(|i| {
            let [before, here] = [i - 1, i].map(|i| told(angles[i]));
            RowFault::at(
                &reading.places[i],
                format!("the {name} {here} does not exceed the previous one, {before}"),
                hint,
            )
        })
        .collect()
}

/// Before the seam the closing row applies, after it the first row. Returns the fault of two different slopes there.
fn seam(reading: &mut Reading) -> Option<RowFault> {
    let Reading { points: Points { angles, .. }, bends, places, slope_digit, .. } = reading;
    let n = bends.len();
    if n < 2 || angles[0] + TAU - angles[n - 1] > CLOSING {
        return None;
    }
    let range = bends.iter().fold(0.0_f64, |range, bend| range.max(bend.slope.abs()));
    let (first, last) = (bends[0], bends[n - 1]);
    if (last.slope - first.slope).abs() > (1.5 * *slope_digit).clamp(1e-9 * range, ROUNDED * range) {
        let message = "U′ of this row, which closes the turn, differs from the first row's";
        return Some(RowFault::at(
            &places[n - 1],
            message,
            "both rows are one point: give them one U′; U″ may jump there",
        ));
    }
    bends[0].before = last.before;
    bends[n - 1] = bends[0];
    None
}

/// The fault of given derivatives that do not match the points: with respect to another angle, or of other quantities. One of
/// `lobes` lobes is a turn. Tables of dwells, and rows without U″, show no such fault.
fn slopes(reading: &Reading, lobes: f64) -> Option<RowFault> {
    let (points, bends) = (&reading.points, &reading.bends);
    let n = bends.len();
    if n < 2 {
        return None;
    }
    let widths: Vec<f64> = (1..n).map(|i| (points.angles[i] - points.angles[i - 1]) / lobes).collect();
    let rises = |of: &[f64]| of.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<f64>>();
    let slopes: Vec<f64> = bends.iter().map(|bend| bend.slope).collect();
    let even: Vec<f64> = bends.iter().map(|bend| 0.5 * (bend.before + bend.behind)).collect();
    let of_spline = |lifts: &[f64]| {
        let law = Table::new(Points { angles: points.angles.clone(), lifts: lifts.to_vec() }).ok()?;
        Some(points.angles.iter().map(|phi| lobes * MotionLaw::Table(law.clone()).at(*phi).0[1]).collect::<Vec<f64>>())
    };
    // ΔU = h (U′ + V′)/2 + h² (U″ − V″)/12 and ΔU′ = h (U″ + V″)/2, the errors of which are of the order h⁵ and h³.
    let bent = |i: usize| widths[i] * widths[i] * (bends[i].behind - bends[i + 1].before) / 12.0;
    let lifted: Vec<f64> = rises(&points.lifts).iter().enumerate().map(|(i, rise)| rise - bent(i)).collect();
    let by_slopes: Vec<f64> = (0..n - 1).map(|i| 0.5 * widths[i] * (slopes[i] + slopes[i + 1])).collect();
    let by_bends: Vec<f64> = (0..n - 1).map(|i| 0.5 * widths[i] * (bends[i].behind + bends[i + 1].before)).collect();
    let pairs = [
        ("U′", "lifts", [(&slopes, of_spline(&points.lifts)?), (&by_slopes, lifted)]),
        ("U″", "U′", [(&even, of_spline(&slopes)?), (&by_bends, rises(&slopes))]),
    ];
    let (of, what, factor) = pairs.iter().find_map(|(of, what, ways)| Some((of, what, factor(ways)?)))?;
    let message = format!("{of} of this table is {} times the value from its {what}", text::number(factor));
    let hint = "they are derivatives with respect to the angle of the first column, in rad or in the unit of their heading, \"V [mm/deg]\"";
    Some(RowFault::at(&reading.places[0], message, hint))
}

/// The factor between the given values and the values found in two ways, if it differs from 1 by more than the uncertainty of the
/// ways: twice the residual of the better one, and their difference.
fn factor(ways: &[(&Vec<f64>, Vec<f64>); 2]) -> Option<f64> {
    let fit = |(given, known): &(&Vec<f64>, Vec<f64>)| {
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let factor = product(given, known) / product(given, given);
        let rest: Vec<f64> = given.iter().zip(known).map(|(given, known)| known - factor * given).collect();
        (factor, (product(&rest, &rest) / product(known, known)).sqrt())
    };
    let [(one, rest), (other, left)] = [fit(&ways[0]), fit(&ways[1])];
    let (best, rest) = if rest < left { (one, rest) } else { (other, left) };
    // A curve of another shape is too large in any case. Values that are all zero give NaN.
    let size = |(given, known): &(&Vec<f64>, Vec<f64>)| {
        let sum = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
        (sum(given) / sum(known)).sqrt()
    };
    let least = size(&ways[0]).min(size(&ways[1]));
    if least.is_finite() && least > LARGEST_SLOPES {
        return Some(least);
    }
    ((best - 1.0).abs() > 2.0 * rest.max((one - other).abs()).max(SLOPES)).then_some(1.0 / best)
}

/// One period with matching ends: a closing row that differs from the first within the noise gets the mean of both, and so do the
/// ends of a lobe; points at rest follow them.
fn closed(
    section: &Section<'_>,
    file: &File,
    mut reading: Reading,
    noise: Option<f64>,
    (kind, turn, quantity): Interpretation<'_>,
) -> Option<Reading> {
    let Reading { points: Points { angles, lifts }, places, digit, at_rest, .. } = &mut reading;
    let [first, .., last] = angles[..] else { return Some(reading) };
    let (n, gap) = (angles.len(), first + TAU - last);
    if turn.rests && gap <= CLOSING {
        let fault = section.fault_of("outside", format!(": {} covers the whole turn", file.name));
        return section.refuse(fault.hint("leave out `outside`, or give the lobe alone"));
    }
    let (start, end) = (lifts[0], lifts[n - 1]);
    if start != end && (turn.rests || gap.abs() <= CLOSING) {
        let count = if turn.rests { n } else { n - 1 };
        let open = Points { angles: angles[..count].to_vec(), lifts: lifts[..count].to_vec() };
        let range = lifts.iter().fold(0.0_f64, |range, lift| range.max((lift - start).abs()));
        // If points may be steps, the closing one may be, too.
        let own = || match () {
            () if kind.steps() => None,
            () if turn.rests && n < LEAST_OF_LOBE => None,
            () if turn.rests => smoothing::noise(mirrored(&open)),
            () => smoothing::noise(open),
        };
        let noise = NOISE * noise.or_else(own).unwrap_or(0.0);
        let shown = shown_in(section, quantity);
        let of = |value: f64| shown(&units::short, value);
        let values = format!("{} and {}", of(start), of(end));
        if (end - start).abs() > noise.max((1.5 * *digit).min(ROUNDED * range)) {
            if turn.rests {
                let fault = fault(file, places[n - 1].clone(), format!("the ends of the lobe, {values}, differ"));
                return section.refuse(fault.hint("give the whole turn, or set `noise` to the noise of the values"));
            }
        } else if !(turn.rests && section.has("noise")) {
            (lifts[0], lifts[n - 1]) = (0.5 * (start + end), 0.5 * (start + end));
            section.faults.note(format!(
                "`{}`: the first and the last row of {}, {values}, differ within the noise: both were set to their mean, {}",
                section.path,
                file.name,
                of(lifts[0])
            ));
        }
    }
    if turn.rests {
        // A spline without noise is at rest outside its ends; removing noise and fitting a series need rows at equal distances.
        let even = section.has("noise") || kind == Interpolation::Fourier;
        let wanted = if even { gap * (n - 1) as f64 / (last - first) } else { 2.0 };
        let parts = (wanted.round() as usize).clamp(2, (MOST_POINTS / turn.lobes).saturating_sub(n).max(2));
        angles.extend((1..parts).map(|k| last + gap * k as f64 / parts as f64));
        // Removing the noise also finds the level.
        lifts.resize(n + parts - 1, 0.5 * (lifts[0] + lifts[n - 1]));
        places.resize(n + parts - 1, places[n - 1].clone());
        at_rest.extend((n..n + parts - 1).chain((!even).then_some(0)).chain((!even).then_some(n - 1)));
    }
    Some(reading)
}

/// A lobe and its image, one after the other: a turn without a dwell.
fn mirrored(lobe: &Points) -> Points {
    let Points { angles, lifts } = lobe;
    let [first, .., last] = angles[..] else { return lobe.clone() };
    let place = |angle: f64| PI * (angle - first) / (last - first);
    let back = angles.iter().rev().skip(1).map(|angle| TAU - place(*angle));
    Points {
        angles: angles.iter().map(|angle| place(*angle)).chain(back).collect(),
        lifts: lifts.iter().chain(lifts.iter().rev().skip(1)).copied().collect(),
    }
}

/// Interpolation, turn and quantity of the points, for messages.
type Interpretation<'a> = (Interpolation, &'a TurnScale<'a>, &'static Quantity);

/// The law through the points, or the series with the best fit.
fn law(
    section: &Section<'_>,
    file: &File,
    reading: Reading,
    harmonics: Option<usize>,
    (kind, turn, quantity): Interpretation<'_>,
) -> Option<Result<MotionLaw, Part>> {
    let bends = reading.bends.len();
    let most = largest(quantity);
    let beyond = reading.points.lifts.iter().position(|lift| !(lift.abs() <= most));
    let points = reading.points.clone();
    // Masses move and turn without jumps.
    let jump = if kind.steps() && !is_load(quantity) { points.check(false).err() } else { None };
    let law = match harmonics {
        _ if let Some(index) = beyond => Err(TableError::OutOfRange { index, value: reading.points.lifts[index] }),
        _ if let Some(jump) = jump => Err(jump),
        None if kind == Interpolation::Linear => Polyline::new(points).map(MotionLaw::Polyline),
        None if kind == Interpolation::Monotone => Polyline::monotone(points).map(MotionLaw::Polyline),
        None if bends > 0 => Table::bent(points, reading.bends).map(MotionLaw::Table),
        None if reading.at_rest.is_empty() => Table::new(points).map(MotionLaw::Table),
        None => Table::resting(points, &reading.at_rest).map(MotionLaw::Table),
        Some(harmonics) => harmonic_analysis::analyse(points, harmonics).map(|analysis| {
            let residual = terminal::shown(analysis.largest_residual, &Unit::of(quantity.unit));
            let of = format!("{} of {}", counted(harmonics, "harmonic"), file.name);
            section.faults.note(format!("`{}`: {of} meet its points to {residual}", section.path));
            MotionLaw::Fourier(analysis.series)
        }),
    };
    let error = match law {
        Ok(law) => {
            if kind == Interpolation::Spline {
                overshoot(section, file, &law, turn);
            }
            return Some(Ok(law));
        }
        Err(error) => error,
    };
    let fault = faulty(section, file, &reading.places, &error, (kind, turn, quantity));
    // Series and noise removal apply to the whole turn.
    let interpolated = kind == Interpolation::Spline && bends == 0 && !section.has("noise");
    match error {
        TableError::NotClosed { .. } | TableError::NotPeriodic { .. } if interpolated => {
            Some(Err(Part { points: reading.points, fault }))
        }
        _ => section.refuse(fault),
    }
}

/// Notes the piece of a spline that leaves the range of its ends by the most.
fn overshoot(section: &Section<'_>, file: &File, law: &MotionLaw, turn: &TurnScale<'_>) {
    /// Places within a piece of degree 5; its extremes are at least some of these distances wide.
    const PLACES: usize = 16;
    let knots = law.breakpoints();
    let value = |i: usize| law.at(knots[i % knots.len()]).0[0];
    let (mut most, mut low, mut high) = ((0.0, 0.0), f64::INFINITY, f64::NEG_INFINITY);
    for (i, &from) in knots.iter().enumerate() {
        let (ends, to) = ([value(i), value(i + 1)], knots.get(i + 1).copied().unwrap_or(knots[0] + TAU));
        let [least, greatest] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        (low, high) = (least.min(low), greatest.max(high));
        for phi in (1..PLACES).map(|k| from + (to - from) * k as f64 / PLACES as f64) {
            let [u, ..] = law.at_in(i, phi).0;
            let beyond = (least - u).max(u - greatest);
            most = if beyond > most.0 { (beyond, phi) } else { most };
        }
    }
    if most.0 > OVERSHOOT * (high - low) {
        let percent = 100.0 * most.0 / (high - low);
        section.faults.note(format!(
            "`{}`: at {} the spline leaves the range of the adjacent points of {} by {percent:.1} % of the range of all; \
             interpolation = \"monotone\" stays in it",
            section.path,
            turn.shown(most.1),
            file.name
        ));
    }
}

/// Reports the fault of the points of a file.
fn faulty(
    section: &Section<'_>,
    file: &File,
    places: &[Span],
    error: &TableError,
    told: Interpretation<'_>,
) -> Diagnostic {
    let fault = match error.index() {
        Some(index) => fault(file, places[index].clone(), words(section, error, told)),
        None => {
            let key = match error {
                TableError::TooManyHarmonics { .. } => "harmonics",
                _ if section.has("points") => "points",
                _ => "file",
            };
            section.fault_of(key, format!(": {}: {}", file.name, words(section, error, told)))
        }
    };
    fault.hint(advice(error, told.1))
}

/// True if a law of this quantity moves a mass; the numbers of a task count in its scale.
fn is_motion(quantity: &Quantity) -> bool {
    [&unit::LENGTH, &unit::ANGLE, &unit::NUMBER].contains(&quantity)
}

/// True if a law of this quantity moves no mass.
pub fn is_load(quantity: &Quantity) -> bool {
    [&unit::FORCE, &unit::TORQUE].contains(&quantity)
}

/// The fault, in the units of engineers.
fn words(section: &Section<'_>, error: &TableError, (kind, turn, quantity): Interpretation<'_>) -> String {
    let value = |value: f64| shown_in(section, quantity)(&units::short, value);
    // One period represents a turn.
    let shown = |angle: f64| turn.shown(angle / turn.lobes as f64);
    let of_turn = if turn.lobes > 1 { "period" } else { "turn" };
    match *error {
        TableError::NotPeriodic { first, last, .. } => format!(
            "the table is not periodic: the {of} {} one {of_turn} after the first point is not its {of} {}",
            value(last),
            value(first),
            of = if is_motion(quantity) { "lift" } else { "value" }
        ),
        TableError::TooFew { points } if kind.steps() => {
            format!("{}; lines need at least 2", counted(points, "point"))
        }
        TableError::NotClosed { gap, distance, .. } => format!(
            "the table ends here, {} before its {of_turn} does, with points at most {} apart",
            shown(gap),
            shown(distance)
        ),
        TableError::TooLong { span, .. } => {
            format!("this point is {} after the first one; a table covers one {of_turn}, {}", shown(span), shown(TAU))
        }
        TableError::OutOfRange { value: wrong, .. } => {
            format!("{} is out of range: at most {} is admissible", value(wrong), value(largest(quantity)))
        }
        ref other => told(other),
    }
}

fn advice(error: &TableError, turn: &TurnScale<'_>) -> &'static str {
    let plain = turn.is_plain();
    match error {
        TableError::NotPeriodic { .. } => "the motion repeats after a turn: both points must have the same lift",
        TableError::NotClosed { .. } if plain => {
            "a table covers the whole turn, 360 deg; is `angle_unit` right? `outside = \"rest\"` is for a lobe, `period` for one of several, `turn` for angles other than the cam's"
        }
        TableError::NotClosed { .. } => "are the unit of the angles and `turn` right?",
        TableError::TooLong { .. } if plain => {
            "is `angle_unit` right? turn = \"720 deg\" is for angles of a crank that turns twice; else leave out the angles beyond 360 deg"
        }
        TableError::TooLong { .. } => "is `turn` right, and the unit of the angles? else leave out the angles beyond",
        TableError::TooFew { .. } => "measure more points of the turn",
        TableError::TooManyHarmonics { .. } => "ask for fewer harmonics or give more points",
        _ => "check the point and the units of the table",
    }
}

#[cfg(test)]
mod tests;
