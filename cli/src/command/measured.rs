//! Measured curves over diagrams of the turn: the option `--measured` of all commands with such diagrams.

use super::{Failure, failure, wrong_argument};
use crate::document::{nearest, units};
use crate::scene;
use camdrive::drives::unit::{self, Quantity};
use camdrive_design::plot::{Diagram, Scale, Series};
use camdrive_design::report::Unit;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// The requested curves.
#[derive(Debug, clap::Args)]
pub struct Measured {
    /// Draw a measured curve over a diagram; docs/scene.md explains it under "Measured curves"
    #[arg(long, value_name = "[DIAGRAM=]TABLE.csv")]
    measured: Vec<String>,
}

/// Quantities of ordinates.
const QUANTITIES: [&Quantity; 11] = [
    &unit::TORQUE,
    &unit::FORCE,
    &unit::LENGTH,
    &unit::LENGTH_PER_ANGLE,
    &unit::LENGTH_PER_ANGLE2,
    &unit::LENGTH_PER_ANGLE3,
    &unit::ACCELERATION,
    &unit::ANGULAR_VELOCITY,
    &unit::ANGULAR_ACCELERATION,
    &unit::ANGLE,
    &units::CURVATURE,
];

impl Measured {
    /// Refuses curves without a folder for diagrams.
    pub fn need(&self, report: Option<&PathBuf>) -> Result<(), Failure> {
        match (self.measured.first(), report) {
            (Some(text), None) => {
                Err(wrong_argument(format!("--measured {text}: no diagram is drawn without --report"))
                    .hint("add --report FOLDER"))
            }
            _ => Ok(()),
        }
    }

    /// Adds the curves to these named diagrams; returns the files of the curves.
    pub fn lay_over<'a>(
        &self,
        diagrams: impl IntoIterator<Item = (&'a str, &'a mut Diagram)>,
    ) -> Result<Vec<PathBuf>, Failure> {
        let over_turn = |(_, diagram): &(&str, &mut Diagram)| {
            diagram.x.scale == Scale::Angular && diagram.x.label.starts_with("Angle")
        };
        let mut known: Vec<(&str, &mut Diagram)> = diagrams.into_iter().filter(over_turn).collect();
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        let mut files = Vec::new();
        for text in &self.measured {
            let (name, file) = match text.split_once('=') {
                Some((name, file)) if !Path::new(text).is_file() => (Some(name), file),
                _ => (None, text.as_str()),
            };
            let found = match name {
                Some(name) => names.iter().position(|known| *known == name),
                None => (names.len() == 1).then_some(0),
            };
            let Some(found) = found else { return Err(unknown(text, name, &names)) };
            let diagram = &mut *known[found].1;
            let label = diagram.y.label.rsplit_once('[').map_or("1", |(_, unit)| unit.trim_end_matches(']'));
            let plain = label.replace('·', ".").replace('²', "2").replace('³', "3");
            let shown = |quantity: &Quantity| Unit::of(quantity.unit);
            let quantity = QUANTITIES.into_iter().find(|of| of.unit == plain || shown(of).name == label);
            let factor = quantity.map(shown).filter(|unit| unit.name == label).map_or(1.0, |unit| unit.factor);
            let course = scene::course(Path::new(file), label, quantity).map_err(failure)?;
            // Shifted to the angles of the diagram, which may begin before 0; a curve that goes back is interrupted.
            let angles = diagram.series.iter().flat_map(|series| &series.points).map(|point| point[0]);
            let low = angles.filter(|angle| angle.is_finite()).fold(f64::INFINITY, f64::min).to_radians();
            let mut points: Vec<[f64; 2]> = Vec::new();
            for (angle, value) in course.angles.iter().zip(&course.lifts) {
                let angle = folded(*angle, if low.is_finite() { low } else { 0.0 }).to_degrees();
                if points.last().is_some_and(|last| angle < last[0]) {
                    points.push([f64::NAN; 2]);
                }
                points.push([angle, factor * value]);
            }
            let name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
            diagram.series.push(Series::line(format!("measured, {name}"), points));
            files.push(PathBuf::from(file));
        }
        Ok(files)
    }
}

/// The angle shifted into the turn that begins at `low`; the end of the turn stays.
fn folded(angle: f64, low: f64) -> f64 {
    if angle > low && angle <= low + TAU { angle } else { low + (angle - low).rem_euclid(TAU) }
}

fn unknown(text: &str, name: Option<&str>, names: &[&str]) -> Failure {
    let Some(first) = names.first() else {
        return wrong_argument(format!("--measured {text}: no diagram over the turn is drawn")).hint("leave it out");
    };
    let (what, file) = match name {
        Some(name) => (format!("there is no diagram `{name}` over the turn"), "TABLE.csv"),
        None => ("there are several diagrams over the turn".to_owned(), text),
    };
    let hint = name.and_then(|name| nearest(name, names)).unwrap_or(first);
    wrong_argument(format!("--measured {text}: {what}\n  = admissible: {}", names.join(", ")))
        .hint(format!("write for example {hint}={file}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_folded_into_the_turn_and_its_end_is_kept() {
        assert_eq!([0.0, TAU, 1.0].map(|angle| folded(angle, 0.0)), [0.0, TAU, 1.0]);
        // −90° is 270°, and 270° is −90° where a diagram begins at −100°; the sums round.
        for (angle, low, place) in [(-0.25, 0.0, 0.75), (1.25, 0.0, 0.25), (0.75, -0.3, -0.25)] {
            assert!((folded(angle * TAU, low * TAU) - place * TAU).abs() < 1e-15);
        }
    }
}
