//! The law of a measured contour: `law = "contour"` of `[cam]` with the follower of `[geometry]`.

use super::super::geometry;
use super::dialect::{Column, Rows, Sheet};
use super::turn::TurnScale;
use super::{
    File, Interpolation, Reading, checked, column, fault, faults, law, named, noise, noted, open, smoothed, unit_of,
};
use crate::document::{Section, TableNote};
use camdrive::drives::unit::{ANGLE, LENGTH, Quantity};
use camdrive::motion::MotionLaw;
use camdrive::motion::table::Points;
use camdrive_design::cam_geometry::inverse::{Refusal, trace};
use camdrive_design::cam_geometry::{Point, Side};
use camdrive_design::overview::Warning;
use camdrive_design::text::{counted, number};
use std::path::Path;

/// The keys of a pair of columns, with the quantities and headings of both.
type Pair = [(&'static str, &'static Quantity, &'static [&'static str]); 2];

const CARTESIAN: Pair = [("x_column", &LENGTH, &["x"]), ("y_column", &LENGTH, &["y"])];
const POLAR: Pair =
    [("r_column", &LENGTH, &["r", "radius"]), ("angle_column", &ANGLE, &["angle", "phi", "beta", "theta"])];

/// The law of the contour in this section; `parent` contains its follower.
pub fn read(
    section: &Section<'_>,
    parent: &Section<'_>,
    quantity: &'static Quantity,
    folder: &Path,
) -> Option<MotionLaw> {
    section.of(&LENGTH, 0);
    // Marked as known, even if a fault ends the reading before them.
    for key in ["file", "length_unit", "angle_unit", "x_column", "y_column", "r_column", "angle_column"] {
        section.has(key);
    }
    let noise = noise(section);
    let plan = match parent.section(geometry::KEY)? {
        Some(geometry) => geometry::read(&geometry, *quantity == ANGLE),
        None => {
            let message = ": a contour gives a law only together with the follower that runs on it";
            let place = if parent.path.is_empty() { "" } else { "follower." };
            let hint = format!("add a section [{place}{}]", geometry::KEY);
            section.refuse(section.fault_of("law", message).hint(hint))
        }
    };
    let file = open(section, "a file with one point per line", folder)?;
    let side = plan.as_ref().and_then(|plan| plan.cut.sides().first().copied()).unwrap_or(Side::Inner);
    let (contour, rows, digit) = points(section, &file, side)?;
    let places = rows.rows.into_iter().map(|(_, span)| span).collect();
    let none = Points { angles: Vec::new(), lifts: Vec::new() };
    let (file, Reading { places, .. }) = checked(section, file, "file", Reading::new(none, places), Vec::new())?;
    let (plan, noise) = (plan?, noise?);
    let traced = match trace(&plan, &contour, noise) {
        Ok(traced) => traced,
        Err(Refusal { index, message, hint }) => {
            let fault = match index {
                Some(index) => fault(&file, places[index].clone(), message),
                None => section.fault_of("file", format!(": {}: {message}", file.name)),
            };
            return section.refuse(fault.hint(hint));
        }
    };
    let own = traced.rows.iter().map(|row| places[*row].clone()).collect();
    let reading = Reading { bends: traced.bends.clone(), digit, ..Reading::new(traced.points.clone(), own) };
    let turn = TurnScale::plain();
    let reading = match noise {
        None => reading,
        Some(sigma) => {
            let sigma = sigma.map(|sigma| sigma * traced.noise);
            smoothed(section, &file, reading, (sigma, false), (Interpolation::Spline, &turn, quantity))?
        }
    };
    let law = match law(section, &file, reading, None, (Interpolation::Spline, &turn, quantity))? {
        Ok(law) => law,
        Err(part) => return section.refuse(part.fault),
    };
    let misfit = traced.misfit(&plan, &law, &contour);
    let line = |row: usize| file.text[..places[row].start].matches('\n').count() + 1;
    let lifts = &traced.points.lifts;
    let stroke = lifts.iter().fold(0.0_f64, |most, lift| most.max(lift - lifts[0]))
        - lifts.iter().fold(0.0_f64, |least, lift| least.min(lift - lifts[0]));
    let open = traced.open.map(|(open, row)| (open, line(row), open > LARGEST_GAP * stroke));
    note(section, &file, misfit, contour.len(), (open, traced.bend_open));
    Some(law)
}

/// The fraction of the stroke by which the law between the points may be uncertain without a warning.
const LARGEST_GAP: f64 = 1e-3;

/// The fraction of its largest value by which U″ may be uncertain without a warning; at a jump of U‴, 360 points leave up to half
/// of it.
const LARGEST_OF_BEND: f64 = 0.1;

/// The uncertainty of lift and U″ between the points: the lift with its line and whether that is much, U″ relative to its largest
/// value.
type Open = (Option<(f64, usize, bool)>, Option<f64>);

/// Notes the origin of the law, the distance of the points from its contour, and, if large, the uncertainty between them and the
/// line before it.
fn note(section: &Section<'_>, file: &File, misfit: [f64; 2], count: usize, (open, bend): Open) {
    let path = section.path.clone();
    let micrometres = |length: f64| format!("{} µm", number(1e6 * length));
    let [mean, largest] = misfit.map(micrometres);
    let count = counted(count, "point");
    let mut off = format!("its {count} deviate from the contour of this law by {mean} rms, at most {largest}");
    if let Some((open, ..)) = open {
        off += &format!("; between them it is uncertain by up to {}", micrometres(open));
    }
    if let Some(bend) = bend {
        off += &format!(", its U″ by {} % of the largest", number(100.0 * bend));
    }
    let warning = open.filter(|(.., much)| *much).map(|(open, line, _)| Warning {
        message: format!(
            "{path}: after line {line} the points of {} leave the contour uncertain by {}",
            file.name,
            micrometres(open)
        ),
        hint: "measure more points where the contour bends sharply".to_owned(),
    });
    let rough = bend.filter(|bend| *bend > LARGEST_OF_BEND).map(|bend| Warning {
        message: format!(
            "{path}: the points of {} leave U″, and with it the acceleration, uncertain by about {:.0} % of its largest value",
            file.name,
            100.0 * bend
        ),
        hint: "write the coordinates with more digits; with few points measure more of them".to_owned(),
    });
    let warning = warning.or(rough);
    section.faults.note(format!("`{path}`: the law comes from the contour {}: {off}", file.name));
    let sentence = format!("The law of {path} comes from a contour: {off}");
    section.faults.smoothed.borrow_mut().push(TableNote { section: path, left: 0.0, sentence, warning });
}

/// The points of the file, its rows and the last digit of a length.
fn points(section: &Section<'_>, file: &File, side: Side) -> Option<(Vec<Point>, Rows, f64)> {
    let refuse = |wrong| {
        faults(file, wrong).into_iter().for_each(|fault| section.faults.report(fault));
        None
    };
    let sheet = match Sheet::new(&file.text) {
        Ok(sheet) => sheet,
        Err(wrong) => return refuse(vec![wrong]),
    };
    // `camdrive cam` writes both contours of a groove.
    let prefix = if side == Side::Outer { "outer_" } else { "inner_" };
    let headed = |names: &[&str]| {
        let is = |heading: &str| {
            let (name, _) = named(heading);
            names.contains(&name.strip_prefix(prefix).unwrap_or(&name))
        };
        sheet.headed(is)
    };
    let all = |pair: Pair| pair.iter().all(|(_, _, names)| headed(names).is_some());
    let asked = |pair: Pair| pair.map(|(key, ..)| section.has(key)).contains(&true);
    let (cartesian, polar, angles) = (asked(CARTESIAN), asked(POLAR), section.has("angle_unit"));
    let polar = !cartesian && (polar || if all(CARTESIAN) { angles && all(POLAR) } else { angles || all(POLAR) });
    if !polar {
        section.forbid(&["r_column", "angle_column", "angle_unit"], "the points are x and y", "`r_column`");
    }
    let pair = if polar { POLAR } else { CARTESIAN };
    let mut columns = Vec::new();
    for (i, (key, _, names)) in pair.into_iter().enumerate() {
        columns.push(match section.has(key) {
            true => column(section, key, i)?,
            false => Column::Number(headed(names).unwrap_or(i)),
        });
    }
    let columns = [columns.remove(0), columns.remove(0)];
    let mut rows = match sheet.rows(&columns, 0, "write plain numbers; the heading or the scene sets their unit") {
        Ok(rows) => rows,
        Err(wrong) => return refuse(wrong),
    };
    noted(section, file, std::mem::take(&mut rows.doubtful), "a heading");
    noted(section, file, std::mem::take(&mut rows.trailer), "the end of the table");
    let mut scales = [1.0; 2];
    for (i, (_, of, _)) in pair.into_iter().enumerate() {
        let key = if *of == ANGLE { "angle_unit" } else { "length_unit" };
        let (above, below) = unit_of(section, key, of, &sheet, rows.columns[i], None)?;
        scales[i] = above / below;
    }
    let point = |row: &[f64]| {
        let [a, b] = [row[0] * scales[0], row[1] * scales[1]];
        if polar { Point::from_polar(a, b) } else { Point::new(a, b) }
    };
    let contour = rows.rows.iter().map(|(row, _)| point(row)).collect();
    let digit = if polar { 0.0 } else { rows.digits[1] * scales[1] };
    Some((contour, rows, digit))
}

#[cfg(test)]
mod tests;
