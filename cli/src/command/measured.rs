//! Measured courses over diagrams over the turn: the option `--measured` of all commands that draw such.

use super::{Failure, failure};
use crate::scene;
use crate::scene::diagnostics::nearest;
use camdrive::drives::unit::{self, Quantity};
use camdrive_design::plot::{Diagram, Scale, Series};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// The courses that are asked for.
#[derive(Debug, clap::Args)]
pub struct Measured {
    /// Measured course to be laid over a diagram over the turn: a table of angle and value, in deg and SI units or in those of
    /// its headings, "phi [deg], M [kN.m]"; DIAGRAM as in the name of the diagram's file, needed where there are several
    #[arg(long, value_name = "[DIAGRAM=]TABLE.csv")]
    measured: Vec<String>,
}

/// What ordinates show.
const QUANTITIES: [&Quantity; 8] = [
    &unit::TORQUE,
    &unit::FORCE,
    &unit::LENGTH,
    &unit::LENGTH_PER_ANGLE,
    &unit::LENGTH_PER_ANGLE2,
    &unit::LENGTH_PER_ANGLE3,
    &unit::ANGULAR_VELOCITY,
    &unit::ANGLE,
];

impl Measured {
    /// Refuses courses where no folder for diagrams is given.
    pub fn need(&self, report: Option<&PathBuf>) -> Result<(), Failure> {
        match (self.measured.first(), report) {
            (Some(text), None) => Err(failure(format!(
                "--measured {text}: no diagram is drawn without --report\n  = hint: add --report FOLDER"
            ))),
            _ => Ok(()),
        }
    }

    /// Lays the courses over these diagrams, given by name; the files of the courses.
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
            let quantity = QUANTITIES.into_iter().find(|quantity| quantity.unit == plain);
            let course =
                scene::course(Path::new(file), label, quantity).map_err(|faults| Failure(faults.to_string()))?;
            let mut points: Vec<[f64; 2]> =
                course.angles.iter().zip(&course.lifts).map(|(a, v)| [folded(*a).to_degrees(), *v]).collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
            diagram.series.push(Series::line(format!("measured, {name}"), points));
            files.push(PathBuf::from(file));
        }
        Ok(files)
    }
}

/// The angle in [0, 2π]; the end of a turn stays there.
fn folded(angle: f64) -> f64 {
    if angle > 0.0 && angle <= TAU { angle } else { angle.rem_euclid(TAU) }
}

fn unknown(text: &str, name: Option<&str>, names: &[&str]) -> Failure {
    let Some(first) = names.first() else {
        return failure(format!("--measured {text}: no diagram over the turn is drawn\n  = hint: leave it out"));
    };
    let (what, file) = match name {
        Some(name) => (format!("there is no diagram `{name}` over the turn"), "TABLE.csv"),
        None => ("there are several diagrams over the turn".to_owned(), text),
    };
    let hint = name.and_then(|name| nearest(name, names)).unwrap_or(first);
    failure(format!(
        "--measured {text}: {what}\n  = admissible: {}\n  = hint: write for example {hint}={file}",
        names.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_folded_into_the_turn_and_its_end_is_kept() {
        assert_eq!([0.0, TAU, 1.0].map(folded), [0.0, TAU, 1.0]);
        // −90° is 270°; the sum rounds.
        assert!((folded(-0.25 * TAU) - 0.75 * TAU).abs() < 1e-15 && (folded(1.25 * TAU) - 0.25 * TAU).abs() < 1e-15);
    }
}
