//! A recording: the values of variables at communication points, while inputs follow their signals.
//!
//! At a communication point t an instance gets its inputs from t on, then its variables are read, then it advances to the next point.
//! Steps end at the rows of the signals, too: a drive with input derivatives meets an input that is linear between its rows.

use crate::coupling::exchange::Coupling;
use crate::host::Variable;
use camdrive::drives::unit::{ANGLE, ANGULAR_ACCELERATION, ANGULAR_VELOCITY, Quantity};
use camdrive::drives::variable::{Causality, Kind, Variability};
use camdrive::drives::{AnyDrive, Description, Fault};

/// A recorded instance: a drive or coupled FMUs. Variables are known by their indices in the list of all. Values to set are SI,
/// values read have the unit of their variable.
///
/// # Errors
/// Of each function: the instance's fault.
pub trait Source {
    /// Ends the initialisation.
    fn start(&mut self) -> Result<(), Fault>;
    /// Sets a parameter or an input, and the time derivative of an input that takes one.
    fn give(&mut self, variable: usize, value: f64, slope: Option<f64>) -> Result<(), Fault>;
    /// The value of a variable.
    fn get(&mut self, variable: usize) -> Result<f64, Fault>;
    /// Advances from the communication point `time` by `step` (s).
    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault>;
}

impl Source for AnyDrive {
    fn start(&mut self) -> Result<(), Fault> {
        AnyDrive::start(self)
    }

    fn give(&mut self, variable: usize, value: f64, slope: Option<f64>) -> Result<(), Fault> {
        self.set(variable, value)?;
        let slope = slope.filter(|_| self.input_derivative_order() > 0);
        slope.map_or(Ok(()), |slope| self.set_input_derivative(variable, 1, slope))
    }

    fn get(&mut self, variable: usize) -> Result<f64, Fault> {
        AnyDrive::get(self, variable)
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        AnyDrive::advance(self, time, step)
    }
}

impl Source for Coupling {
    fn start(&mut self) -> Result<(), Fault> {
        Coupling::start(self)
    }

    fn give(&mut self, variable: usize, value: f64, slope: Option<f64>) -> Result<(), Fault> {
        let (part, place) = self.place(variable);
        let host = &mut self.parts()[part];
        let Variable { about, reference, unit, .. } = &host.description().variables[place];
        let is_smooth = about.variability == Variability::Continuous;
        let slope = slope.filter(|_| is_smooth && host.description().capabilities.interpolates_inputs);
        let (reference, value, slope) = (*reference, unit.of_si(value), slope.map(|slope| slope / unit.factor));
        host.set(place, value)?;
        slope.map_or(Ok(()), |slope| host.set_input_derivatives(&[reference], &[1], &[slope]))
    }

    fn get(&mut self, variable: usize) -> Result<f64, Fault> {
        let (part, place) = self.place(variable);
        self.parts()[part].get(place)
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        Coupling::advance(self, time, step)
    }
}

/// A running instance with its inputs.
pub struct Recording<'a, S: ?Sized> {
    /// The instance.
    pub source: &'a mut S,
    /// Its communication point (s).
    pub time: f64,
    signals: &'a Signals,
    variables: &'a [usize],
}

impl<'a, S: Source + ?Sized> Recording<'a, S> {
    /// Starts a recording of these variables; the initialisation of the instance at `time` (s) has begun and ends here.
    ///
    /// # Errors
    /// The fault of the instance.
    pub fn start(source: &'a mut S, signals: &'a Signals, variables: &'a [usize], time: f64) -> Result<Self, Fault> {
        signals.give(source, time, false)?;
        source.start()?;
        signals.give(source, time, true)?;
        Ok(Recording { source, time, signals, variables })
    }

    /// Goes on to the communication point `time` (s), and makes its row: the time and the values.
    ///
    /// # Errors
    /// The fault of the instance.
    pub fn at(&mut self, time: f64, row: &mut Vec<f64>) -> Result<(), Fault> {
        while self.time < time {
            self.step(self.next(time))?;
        }
        row.clear();
        row.push(time);
        for variable in self.variables {
            row.push(self.source.get(*variable)?);
        }
        Ok(())
    }

    /// The end of the next step on the way to `time` (s).
    pub fn next(&self, time: f64) -> f64 {
        self.signals.next(self.time, time)
    }

    /// Takes this step.
    ///
    /// # Errors
    /// The fault of the instance.
    pub fn step(&mut self, end: f64) -> Result<(), Fault> {
        self.source.advance(self.time, end - self.time)?;
        self.time = end;
        self.signals.give(self.source, end, true)
    }
}

/// The inputs of a motion with their quantities, each the time derivative of the one before.
const MOTION: [(&str, &Quantity); 3] = [("phi", &ANGLE), ("w", &ANGULAR_VELOCITY), ("a", &ANGULAR_ACCELERATION)];

/// Two times closer than this part of them are equal.
const SAME: f64 = 1e-12;

/// Inputs over time; none by default.
#[derive(Default)]
pub struct Signals {
    /// The times of the rows (s).
    times: Vec<f64>,
    courses: Vec<Signal>,
}

/// An input that is linear between the rows, or held if it is discrete; or the inputs of a motion, each the derivative of the
/// one before: the last one with a column is linear, the ones before it are its integrals from row to row, the ones after it
/// its derivatives.
struct Signal {
    variables: Vec<usize>,
    /// The columns of the first of them, at least one.
    rows: Vec<Vec<f64>>,
    held: bool,
}

impl Signals {
    /// The signals of inputs among these variables, with their values at each of the times (s).
    ///
    /// # Errors
    /// A derivative of a motion without the input that it is the derivative of.
    pub fn new(all: &[Description], times: Vec<f64>, mut columns: Vec<(usize, Vec<f64>)>) -> Result<Self, Fault> {
        let is_it = |d: &Description, (name, of): (&str, &Quantity)| {
            let is_input = d.name == name && d.causality == Causality::Input;
            is_input && matches!(d.kind, Kind::Real { quantity, .. } if quantity.base == of.base)
        };
        let named = |part| all.iter().position(|d| is_it(d, part));
        let motion: Option<Vec<usize>> = MOTION.into_iter().map(named).collect();
        let mut motion = Signal { variables: motion.unwrap_or_default(), rows: Vec::new(), held: false };
        let mut courses = Vec::new();
        columns.sort_by_key(|(variable, _)| *variable);
        for (variable, values) in columns {
            match motion.variables.iter().position(|other| *other == variable) {
                None => {
                    let is_real = matches!(all[variable].kind, Kind::Real { .. });
                    let held = !is_real || all[variable].variability != Variability::Continuous;
                    courses.push(Signal { variables: vec![variable], rows: vec![values], held });
                }
                Some(order) if order == motion.rows.len() => motion.rows.push(values),
                Some(order) => {
                    let (missing, here) = (MOTION[motion.rows.len()].0, MOTION[order].0);
                    let message = format!("`{here}` has a column, but not `{missing}`, whose derivative it is");
                    let hint = format!("add `{missing}`, or let the drive integrate w alone, [drive] mode = \"speed\"");
                    return Err(Fault::new(message).hint(hint));
                }
            }
        }
        if !motion.rows.is_empty() {
            courses.push(motion);
        }
        Ok(Signals { times, courses })
    }

    /// True if this variable is among them.
    pub fn have(&self, variable: usize) -> bool {
        self.courses.iter().any(|course| course.variables.contains(&variable))
    }

    /// The end of a step from `time` towards `end` (s): the next row, if that comes first.
    pub fn next(&self, time: f64, end: f64) -> f64 {
        let row = self.times.get(self.passed(time)).copied().unwrap_or(end);
        if is_before(row, end) { row } else { end }
    }

    /// The number of rows up to `time` (s).
    fn passed(&self, time: f64) -> usize {
        self.times.partition_point(|row| !is_before(time, *row))
    }

    /// Sets each input of a source at `time` (s) and, for linear or higher ones, the slope from there on, which a source takes
    /// after its initialisation.
    fn give<S: Source + ?Sized>(&self, source: &mut S, time: f64, initialised: bool) -> Result<(), Fault> {
        let row = self.passed(time);
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
            for (order, variable) in course.variables.iter().enumerate() {
                let is_last = order + 1 == course.variables.len();
                source.give(*variable, derivative(order), (is_last && initialised).then(|| derivative(order + 1)))?;
            }
        }
        Ok(())
    }
}

/// True if one time is before another by more than rounding.
fn is_before(time: f64, other: f64) -> bool {
    other - time > SAME * time.abs().max(other.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Notes what it is given: variable, value and slope.
    struct Note(Vec<(usize, f64, Option<f64>)>);

    impl Source for Note {
        fn start(&mut self) -> Result<(), Fault> {
            Ok(())
        }

        fn give(&mut self, variable: usize, value: f64, slope: Option<f64>) -> Result<(), Fault> {
            self.0.push((variable, value, slope));
            Ok(())
        }

        fn get(&mut self, variable: usize) -> Result<f64, Fault> {
            Ok(variable as f64)
        }

        fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
            self.0.push((usize::MAX, time, Some(step)));
            Ok(())
        }
    }

    fn told(signals: &Signals, time: f64) -> Vec<(usize, f64, Option<f64>)> {
        let mut note = Note(Vec::new());
        signals.give(&mut note, time, true).unwrap();
        note.0
    }

    #[test]
    fn an_input_is_linear_between_the_rows_and_held_outside() {
        let courses = vec![Signal { variables: vec![4], rows: vec![vec![1.0, 3.0, 3.0]], held: false }];
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
            courses: vec![Signal { variables: vec![0, 1, 2], rows: columns[..count].to_vec(), held: false }],
        };
        // Half of a second after the first row; the slopes are 0.5, 1 and 6.
        assert_eq!(told(&motion(1), 0.5), [(0, 10.25, None), (1, 0.5, None), (2, 0.0, Some(0.0))]);
        assert_eq!(told(&motion(2), 0.5), [(0, 11.125, None), (1, 2.5, None), (2, 1.0, Some(0.0))]);
        assert_eq!(told(&motion(3), 0.5), [(0, 11.875, None), (1, 5.75, None), (2, 9.0, Some(6.0))]);
        // After the last row the last one is held.
        assert_eq!(told(&motion(2), 3.0), [(0, 15.0, None), (1, 4.0, None), (2, 0.0, Some(0.0))]);
    }

    #[test]
    fn steps_end_at_the_rows_of_the_signals() {
        let courses = vec![Signal { variables: vec![4], rows: vec![vec![1.0, 3.0, 3.0]], held: false }];
        let signals = Signals { times: vec![1.0, 2.0, 4.0], courses };
        let (mut note, mut row) = (Note(Vec::new()), Vec::new());
        let mut recording = Recording::start(&mut note, &signals, &[7, 8], 0.5).unwrap();
        recording.at(0.5, &mut row).unwrap();
        assert_eq!(row, [0.5, 7.0, 8.0]);
        recording.at(1.5, &mut row).unwrap();
        assert_eq!(row, [1.5, 7.0, 8.0]);
        let (input, step) = (4, usize::MAX);
        let given = [
            // Before the end of the initialisation there is no slope.
            (input, 1.0, None),
            (input, 1.0, Some(0.0)),
            (step, 0.5, Some(0.5)),
            (input, 1.0, Some(2.0)),
            (step, 1.0, Some(0.5)),
            (input, 2.0, Some(2.0)),
        ];
        assert_eq!(note.0, given);
    }
}
