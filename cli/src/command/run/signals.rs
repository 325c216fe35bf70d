//! Inputs over time, as a table gives them.

use crate::command::{Failure, failure};
use crate::scene;
use camdrive::drives::unit::{ANGLE, ANGULAR_ACCELERATION, ANGULAR_VELOCITY, Quantity};
use camdrive::drives::variable::{Causality, Kind, Variability};
use camdrive::drives::{Description, Fault};
use std::path::Path;

/// The inputs of a motion with their quantities, each the time derivative of the one before.
const MOTION: [(&str, &Quantity); 3] = [("phi", &ANGLE), ("w", &ANGULAR_VELOCITY), ("a", &ANGULAR_ACCELERATION)];

/// Two times nearer to each other than this part of them are one.
const SAME: f64 = 1e-12;

/// Courses of inputs; by default of none.
#[derive(Default)]
pub struct Signals {
    /// The times of the rows (s).
    times: Vec<f64>,
    courses: Vec<Course>,
}

/// An input that is linear between the rows, or held where it is discrete; or several, each the derivative of the one before: the last one in the table
/// is linear, those before it are its integrals from row to row, those behind it its derivatives.
struct Course {
    references: Vec<usize>,
    /// The columns of the first of them, at least one.
    rows: Vec<Vec<f64>>,
    held: bool,
}

impl Signals {
    /// The table of the inputs among these variables; `own` is the unit of a variable where it is another than SI.
    pub fn read(path: &Path, all: &[Description], own: impl Fn(usize) -> Option<String>) -> Result<Self, Failure> {
        let inputs: Vec<usize> = (0..all.len()).filter(|i| all[*i].causality == Causality::Input).collect();
        let of: Vec<&Description> = inputs.iter().map(|i| &all[*i]).collect();
        let table = scene::courses(path, &of, |input| own(inputs[input])).map_err(failure)?;
        let is_it = |d: &Description, (name, of): (&str, &Quantity)| {
            d.name == name && matches!(d.kind, Kind::Real { quantity, .. } if quantity.base == of.base)
        };
        let named = |part| inputs.iter().copied().find(|i| is_it(&all[*i], part));
        let motion: Option<Vec<usize>> = MOTION.into_iter().map(named).collect();
        let (mut first, mut courses) =
            (Course { references: motion.unwrap_or_default(), rows: Vec::new(), held: false }, Vec::new());
        let mut columns: Vec<(usize, Vec<f64>)> =
            table.columns.into_iter().map(|(column, values)| (inputs[column], values)).collect();
        columns.sort_by_key(|(reference, _)| *reference);
        for (reference, values) in columns {
            match first.references.iter().position(|other| *other == reference) {
                None => {
                    let is_real = matches!(all[reference].kind, Kind::Real { .. });
                    let held = !is_real || all[reference].variability != Variability::Continuous;
                    courses.push(Course { references: vec![reference], rows: vec![values], held });
                }
                Some(order) if order == first.rows.len() => first.rows.push(values),
                Some(order) => {
                    let (missing, here) = (MOTION[first.rows.len()].0, MOTION[order].0);
                    return Err(failure(format!(
                        "{}: `{here}` has a column, but not `{missing}`, whose derivative it is",
                        path.display()
                    ))
                    .hint(format!("add `{missing}`, or let the drive integrate w alone, [drive] mode = \"speed\"")));
                }
            }
        }
        if !first.rows.is_empty() {
            courses.push(first);
        }
        Ok(Signals { times: table.times, courses })
    }

    /// Whether the table gives this variable.
    pub fn give(&self, reference: usize) -> bool {
        self.courses.iter().any(|course| course.references.contains(&reference))
    }

    /// The end of a step from `time` on that is to lead to `end` at most (s): the next row, if that comes first.
    pub fn next(&self, time: f64, end: f64) -> f64 {
        let row = self.times.get(self.behind(time)).copied().unwrap_or(end);
        if is_before(row, end) { row } else { end }
    }

    /// The number of rows up to `time` (s).
    fn behind(&self, time: f64) -> usize {
        self.times.partition_point(|row| !is_before(time, *row))
    }

    /// Tells each input, its value and, of those that are linear or higher, its slope at `time` (s), from there on.
    pub fn at(
        &self,
        time: f64,
        mut tell: impl FnMut(usize, f64, Option<f64>) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        let row = self.behind(time);
        let (begin, end) = (row.saturating_sub(1), row);
        for course in &self.courses {
            let last = &course.rows[course.rows.len() - 1];
            let slope = if course.held || row == 0 || row == self.times.len() {
                0.0
            } else {
                (last[end] - last[begin]) / (self.times[end] - self.times[begin])
            };
            // The value and its derivatives at the row.
            let terms: Vec<f64> = course.rows.iter().map(|values| values[begin]).chain([slope]).collect();
            let tau = time - self.times[begin];
            let derivative = |order: usize| {
                let above = terms.iter().enumerate().skip(order).rev();
                above.fold(0.0, |sum, (n, term)| term + sum * tau / (n + 1 - order) as f64)
            };
            for (order, reference) in course.references.iter().enumerate() {
                let is_last = order + 1 == course.references.len();
                tell(*reference, derivative(order), is_last.then(|| derivative(order + 1)))?;
            }
        }
        Ok(())
    }
}

/// Whether one time is before another, and not the same but for rounding.
fn is_before(time: f64, other: f64) -> bool {
    other - time > SAME * time.abs().max(other.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(signals: &Signals, time: f64) -> Vec<(usize, f64, Option<f64>)> {
        let mut all = Vec::new();
        let told = signals.at(time, |reference, value, slope| {
            all.push((reference, value, slope));
            Ok(())
        });
        assert_eq!(told, Ok(()));
        all
    }

    #[test]
    fn an_input_is_linear_between_the_rows_and_held_outside() {
        let courses = vec![Course { references: vec![4], rows: vec![vec![1.0, 3.0, 3.0]], held: false }];
        let signals = Signals { times: vec![1.0, 2.0, 4.0], courses };
        for (time, value, slope, next) in [
            (0.0, 1.0, 0.0, 1.0),
            (1.0, 1.0, 2.0, 2.0),
            (1.25, 1.5, 2.0, 2.0),
            // A sum of steps that is meant to be the row.
            (2.0 - 1e-15, 3.0, 0.0, 4.0),
            (3.0, 3.0, 0.0, 4.0),
            (4.0, 3.0, 0.0, 9.0),
            (5.0, 3.0, 0.0, 9.0),
        ] {
            assert_eq!(told(&signals, time), [(4, value, Some(slope))], "{time}");
            assert_eq!(signals.next(time, 9.0), next, "{time}");
        }
        assert_eq!(signals.next(1.0, 1.5), 1.5);
        assert_eq!(Signals::default().next(1.0, 1.5), 1.5);
    }

    #[test]
    fn of_a_motion_the_last_column_is_linear_and_the_others_belong_to_it() {
        let columns = [vec![10.0, 11.0], vec![2.0, 4.0], vec![6.0, 18.0]];
        let motion = |count: usize| Signals {
            times: vec![0.0, 2.0],
            courses: vec![Course { references: vec![0, 1, 2], rows: columns[..count].to_vec(), held: false }],
        };
        // Half of a second after the first row; the slopes are 0.5, 1 and 6.
        assert_eq!(told(&motion(1), 0.5), [(0, 10.25, None), (1, 0.5, None), (2, 0.0, Some(0.0))]);
        assert_eq!(told(&motion(2), 0.5), [(0, 11.125, None), (1, 2.5, None), (2, 1.0, Some(0.0))]);
        assert_eq!(told(&motion(3), 0.5), [(0, 11.875, None), (1, 5.75, None), (2, 9.0, Some(6.0))]);
        // Behind the last row the last one is held.
        assert_eq!(told(&motion(2), 3.0), [(0, 15.0, None), (1, 4.0, None), (2, 0.0, Some(0.0))]);
    }
}
