//! The outputs of a drive over its default experiment: as a table to compare other runs with, and as a diagram. The inputs move,
//! since a drive with a shaft at rest would agree with any library.

use super::model_description::unit;
use super::picture;
use camdrive::drives::variable::{Causality, Kind};
use camdrive::drives::{AnyDrive, Curve, Description, Fault};
use camdrive::numerics::work::{BUDGET, Since};
use camdrive_design::drawing::Drawing;
use camdrive_design::plot::Axis;
use camdrive_design::recording::{Recording, Signals};
use camdrive_design::text;
use std::f64::consts::TAU;

/// Significant digits of an output's largest value. Platforms differ in the last bits of sin and cos, which seldom affects these
/// digits: the same scene has the same table on each platform.
const DIGITS: i32 = 7;

/// A value below 10 to this power (SI) is rounding.
const LEAST: i32 = -12;

/// The most work of a run (nominal µs), so that an export does not become noticeably longer.
const MOST_WORK: f64 = 5.0 * BUDGET;

/// Most outputs in the diagram.
const MOST_CURVES: usize = 6;

/// Most points of a curve in it: some per pixel.
const MOST_POINTS: usize = 3000;

/// Outputs that the diagram shows first.
const MAIN: [&str; 7] = ["w", "y", "x", "psi", "q", "force", "tau"];

/// The inputs that turn a shaft.
const MOTION: [&str; 3] = ["phi", "w", "a"];

/// The angle of the run-up over the experiment (rad).
const WAY: f64 = 2.0 * TAU;

/// The fraction of a free shaft's speed by which the inputs may change it, as little as the torque of the machine itself.
const CHANGE: f64 = 0.5;

/// Number of tried rises of inputs, each a tenth of the previous one. If no rise leaves the shaft near its speed, the inputs are
/// constant.
const SIZES: i32 = 12;

/// Inputs and outputs over the default experiment.
pub struct Results {
    inputs: Vec<Description>,
    outputs: Vec<Description>,
    /// The rise of the last input that turns no shaft, in its unit.
    size: f64,
    /// The time (s) and the values of the inputs at each communication point of the experiment.
    courses: Vec<Vec<f64>>,
    /// The time (s) and the values of the outputs at each communication point.
    rows: Vec<Vec<f64>>,
    /// True if the last row is the end of the experiment.
    pub whole: bool,
}

/// The unit of the last rounded digit of an output with this largest value.
pub fn last_digit(largest: f64) -> f64 {
    10.0f64.powi(last_place(largest))
}

fn last_place(largest: f64) -> i32 {
    (exponent(largest) + 1 - DIGITS).max(LEAST)
}

/// The power of ten of the first digit; without a logarithm, whose last bits differ between platforms.
fn exponent(value: f64) -> i32 {
    format!("{value:e}").rsplit('e').next().and_then(|power| power.parse().ok()).unwrap_or(0)
}

impl Results {
    /// Runs the drive over its default experiment, with the tolerance for importers. A run that fails or takes too long ends
    /// earlier.
    ///
    /// # Errors
    /// A drive that cannot be started.
    pub fn of(drive: &mut AnyDrive) -> Result<Self, Fault> {
        let stop = drive.experiment().stop;
        let all = drive.descriptions().to_vec();
        let of = |wanted: Causality| (0..all.len()).filter(|i| all[*i].causality == wanted).collect::<Vec<usize>>();
        let [inputs, outputs] = [Causality::Input, Causality::Output].map(of);
        drive.reset();
        let starts = inputs.iter().map(|input| drive.get(*input)).collect::<Result<Vec<f64>, Fault>>()?;
        let mut run = |size: f64, keeps: &dyn Fn(usize, &[f64]) -> bool| -> Result<Option<Results>, Fault> {
            let moved: Vec<&Description> = inputs.iter().map(|input| &all[*input]).collect();
            let courses: Vec<_> = times(drive).map(|time| course(&moved, &starts, [time, stop], size)).collect();
            let run = rows(drive, [&inputs, &outputs], &courses, keeps)?;
            Ok(run.map(|(rows, whole)| Results { inputs: vec![], outputs: vec![], size, courses, rows, whole }))
        };
        let place = |name: &str| outputs.iter().position(|i| all[*i].name == name).map(|place| 1 + place);
        let mut results = match (place("w"), place("E")) {
            // A free shaft: torques may bring it to any speed.
            (Some(w), Some(_)) if !inputs.is_empty() => {
                let still = run(0.0, &|_, _| true)?;
                let speeds: Vec<f64> = still.iter().flat_map(|run| &run.rows).map(|row| row[w]).collect();
                let most = speeds.iter().fold(WAY / stop, |most, speed| most.max(CHANGE * speed.abs()));
                let keeps = |i: usize, row: &[f64]| speeds.get(i).is_none_or(|speed| (row[w] - speed).abs() <= most);
                let mut sizes = (0..SIZES).map(|n| 1.0 / 10f64.powi(n));
                sizes.find_map(|size| run(size, &keeps).transpose()).transpose()?.or(still)
            }
            _ => run(1.0, &|_, _| true)?,
        }
        .ok_or_else(|| Fault::new("the drive has no communication point"))?;
        drive.reset();
        let described = |of: Vec<usize>| of.into_iter().map(|i| all[i].clone()).collect::<Vec<_>>();
        (results.inputs, results.outputs) = (described(inputs), described(outputs));
        results.round();
        Ok(results)
    }

    /// Rounds the outputs to the significant digits.
    fn round(&mut self) {
        for (i, output) in self.outputs.iter().enumerate() {
            if matches!(output.kind, Kind::Real { .. }) {
                let last = last_place(self.rows.iter().map(|row| row[i + 1].abs()).fold(0.0, f64::max));
                self.rows.iter_mut().for_each(|row| row[i + 1] = rounded(row[i + 1], last));
            }
        }
    }

    /// The last time (s).
    pub fn end(&self) -> f64 {
        self.rows.last().map_or(0.0, |row| row[0])
    }

    /// The table of the outputs, as from `camdrive run`.
    ///
    /// # Errors
    /// Errors of [`text::csv`].
    pub fn csv(&self) -> Result<String, Fault> {
        table(&self.outputs, &self.rows)
    }

    /// The motion of the inputs, in words.
    pub fn motion(&self) -> String {
        let names = self.inputs.iter().map(|input| input.name.as_str());
        let (shaft, others): (Vec<&str>, Vec<&str>) = names.partition(|name| MOTION.contains(name));
        let turn = match shaft.len() {
            0 => String::new(),
            1 => format!("{} turns the shaft twice in a smooth run-up", shaft[0]),
            _ => format!("{} turn the shaft twice in a smooth run-up", shaft.join(", ")),
        };
        let rise = match others.len() {
            0 => String::new(),
            1 => format!("{} rises smoothly by {} in its unit", others[0], self.size),
            _ => format!(
                "{} rise smoothly, the last one by {} in its unit, each one before it by half of the next one's rise",
                others.join(", "),
                self.size
            ),
        };
        [turn, rise].into_iter().filter(|said| !said.is_empty()).collect::<Vec<_>>().join("; ")
    }

    /// The table of the inputs, for `camdrive run --input`; None for a drive without inputs.
    ///
    /// # Errors
    /// Errors of [`text::csv`].
    pub fn inputs(&self) -> Result<Option<String>, Fault> {
        (!self.inputs.is_empty()).then(|| table(&self.inputs, &self.courses)).transpose()
    }

    /// The main outputs over time, and a description; None if no output changes.
    pub fn diagram(&self) -> Option<(Drawing, String)> {
        let column =
            |d: &Description| Course { name: d.name.clone(), unit: unit(&d.kind).to_owned(), text: d.text.clone() };
        let columns: Vec<Course> = self.outputs.iter().map(column).collect();
        diagram("Default experiment", &columns, &self.rows)
    }
}

/// The communication points of the default experiment (s).
fn times(drive: &AnyDrive) -> impl Iterator<Item = f64> + use<> {
    let e = drive.experiment();
    let count = (e.stop / e.step).round() as usize;
    (0..=count).map(move |i| if i == count { e.stop } else { i as f64 * e.step })
}

/// The time (s) and the outputs at each communication point with these inputs, and whether the last row is the end of the
/// experiment; None if `keeps` refuses a row.
fn rows(
    drive: &mut AnyDrive,
    [inputs, outputs]: [&[usize]; 2],
    courses: &[Vec<f64>],
    keeps: &dyn Fn(usize, &[f64]) -> bool,
) -> Result<Option<(Vec<Vec<f64>>, bool)>, Fault> {
    let begin = Since::now();
    let column = |i: usize| courses.iter().map(|row| row[i]).collect::<Vec<f64>>();
    let columns = inputs.iter().enumerate().map(|(i, input)| (*input, column(i + 1))).collect();
    let signals = Signals::new(drive.descriptions(), column(0), columns)?;
    drive.reset();
    drive.set_up(0.0, Some(drive.experiment().tolerance));
    let mut recording = Recording::start(drive, &signals, outputs, 0.0)?;
    let (mut rows, mut row) = (Vec::new(), Vec::new());
    for (i, course) in courses.iter().enumerate() {
        match recording.at(course[0], &mut row) {
            Err(fault) if i == 0 => return Err(fault),
            Err(_) => return Ok(Some((rows, false))),
            Ok(()) if !keeps(i, &row) => return Ok(None),
            Ok(()) => rows.push(row.clone()),
        }
        if begin.drawn() > MOST_WORK {
            break;
        }
    }
    let whole = rows.len() == courses.len();
    Ok(Some((rows, whole)))
}

/// A column after the time.
pub struct Course {
    /// The name of the variable.
    pub name: String,
    /// Empty for other types than Real.
    pub unit: String,
    /// Its description.
    pub text: String,
}

/// The main columns over the time, at most `MOST_CURVES`, and a description; None if no column changes.
pub fn diagram(title: &str, columns: &[Course], rows: &[Vec<f64>]) -> Option<(Drawing, String)> {
    let column = |i: usize| rows.iter().map(move |row| row[i + 1]);
    let tells = |i: &usize| {
        let Course { name, unit, .. } = &columns[*i];
        let (low, high) = column(*i).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        // A diagram of an angle that keeps growing shows nothing, and derivatives of outputs are too many.
        let turns = unit == "rad" && high - low > TAU;
        !unit.is_empty() && !name.contains("der(") && high > low && !turns
    };
    let mut shown: Vec<usize> = (0..columns.len()).filter(tells).collect();
    let rank = |i: &usize| {
        let name = columns[*i].name.rsplit('.').next().unwrap_or_default();
        MAIN.iter().position(|main| *main == name).unwrap_or(MAIN.len())
    };
    shown.sort_by_key(rank);
    shown.truncate(MOST_CURVES);
    shown.sort_unstable();
    let curve = |i: &usize| {
        let Course { name, unit, text } = &columns[*i];
        // A panel has one line for the title.
        let title = text.split([';', '.', ',']).next().unwrap_or_default().to_owned();
        let unit = unit.replace('.', "·").replace('2', "²").replace('3', "³");
        let times = || rows.iter().map(|row| row[0]);
        let (across, x) = Axis::linear("t [s]").suited(times());
        let (up, y) = Axis::linear(&format!("{name} [{unit}]")).suited(column(*i));
        let points = times().zip(column(*i)).map(|(time, value)| [x * time, y * value]);
        Curve { title, x_label: across.label, y_label: up.label, points: thinned(points.collect()) }
    };
    let curves: Vec<Curve> = shown.iter().map(curve).collect();
    let names: Vec<&str> = shown.iter().map(|i| columns[*i].name.as_str()).collect();
    let label = format!("{} over the time", names.join(", "));
    (!curves.is_empty()).then(|| (picture::of_curves(title, "", &curves), label))
}

/// The least and the largest of each group of points, if there are more points than a picture can show.
fn thinned(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    if points.len() <= MOST_POINTS {
        return points;
    }
    let ends = |group: &[[f64; 2]]| {
        let by_value = |a: &&[f64; 2], b: &&[f64; 2]| a[1].total_cmp(&b[1]);
        let mut ends = [group.iter().min_by(by_value), group.iter().max_by(by_value)].map(|p| *p.unwrap_or(&group[0]));
        ends.sort_by(|a, b| a[0].total_cmp(&b[0]));
        ends
    };
    points.chunks(points.len().div_ceil(MOST_POINTS / 2)).flat_map(ends).collect()
}

fn table(columns: &[Description], rows: &[Vec<f64>]) -> Result<String, Fault> {
    let names = ["time"].into_iter().chain(columns.iter().map(|d| d.name.as_str()));
    let head = names.map(str::to_owned).collect();
    let rows = rows.iter().map(|row| row.iter().map(|value| format!("{value:?}")).collect());
    text::csv(std::iter::once(head).chain(rows))
}

/// The time and the inputs at it, from these start values to the end `stop` (s): phi, w and a turn the shaft twice in a smooth
/// run-up. Every other input rises smoothly, the last one by `size` in its unit, each one before it by half of the next one's rise,
/// so that no torques cancel.
fn course(inputs: &[&Description], starts: &[f64], [time, stop]: [f64; 2], size: f64) -> Vec<f64> {
    let named = |name: &str| inputs.iter().position(|input| input.name == name).map_or(0.0, |i| starts[i]);
    let [way, value, slope] = rise(time / stop);
    let speed = (2.0 * WAY / stop).copysign(named("w"));
    let mut size = 2.0 * size;
    let of = |(input, start): (&&Description, &f64)| match (input.name.as_str(), &input.kind) {
        ("phi", _) => start + named("w") * time + speed * stop * way,
        ("w", _) => start + speed * value,
        ("a", _) => speed / stop * slope,
        (_, Kind::Real { max, .. }) => {
            size *= 0.5;
            (start + size * value).min(*max)
        }
        _ => *start,
    };
    let mut row: Vec<f64> = inputs.iter().zip(starts).rev().map(of).collect();
    row.push(time);
    row.reverse();
    row
}

/// A rise from 0 to 1 over x = 0 … 1: its integral, the rise, its slope. The slope is linear up to the middle and after it, as
/// inputs are between communication points; polynomials have the same bits on each platform.
fn rise(x: f64) -> [f64; 3] {
    let y = 1.0 - x;
    if x < 0.5 {
        [2.0 * x * x * x / 3.0, 2.0 * x * x, 4.0 * x]
    } else {
        [0.5 - y + 2.0 * y * y * y / 3.0, 1.0 - 2.0 * y * y, 4.0 * y]
    }
}

/// The value, rounded to the digit with this power of ten; a zero gets no sign.
fn rounded(value: f64, last: i32) -> f64 {
    let places = usize::try_from(exponent(value) - last);
    places.map_or(0.0, |places| format!("{value:.places$e}").parse().unwrap_or(value) + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::test_drive::lag;

    #[test]
    fn values_are_told_to_a_digit_of_the_largest() {
        for (largest, value, told) in [
            (0.94e-3, 1.234_567_894_9e-4, 1.234_568e-4),
            (0.94e-3, -4.9e-11, 0.0),
            (2e6, -123.4, -123.0),
            (3e9, 1234.5, 1000.0),
            (1e-14, 1e-14, 0.0),
            (0.0, -0.0, 0.0),
            (9.999_999_96, 9.999_999_96, 10.0),
        ] {
            assert_eq!(rounded(value, last_place(largest)).to_bits(), f64::to_bits(told), "{value} of {largest}");
        }
        assert_eq!(last_digit(188.5), 1e-4);
    }

    /// A torque of 1 N·m would turn these shafts of 1e-6 kg·m² at some 10⁴ rad/s.
    #[test]
    fn inputs_leave_a_free_shaft_near_its_speed() {
        let follower = "[[follower]]\nm = 0.001\ncam = { law = \"fourier\", a = [0.0, 0.01] }\n";
        for (model, motor, w_start) in
            [("DriveTrain", "none", 10.0), ("RigidMachine", "none", 10.0), ("RigidMachine", "input", 0.0)]
        {
            let load = if model == "DriveTrain" { "load = { input = true }" } else { "" };
            let text = format!(
                "name = \"small\"\nmodel = \"{model}\"\n[machine]\nJ0 = 1e-6\n{load}\n[motor]\nkind = \"{motor}\"\n\
                 [start]\nw_start = {w_start}\n{follower}"
            );
            let scene = crate::scene::resolve("small.toml", &text, std::path::Path::new("")).unwrap();
            let mut drive = scene.resource().build().unwrap();
            let results = Results::of(&mut drive).unwrap();
            let w = results.outputs.iter().position(|output| output.name == "w").unwrap();
            let far = results.rows.iter().map(|row| (row[w + 1] - w_start).abs()).fold(0.0, f64::max);
            assert!(results.whole && results.size < 1e-2, "{model} {motor}: {}", results.size);
            assert!(0.1 < far && far <= 30.0, "{model} {motor}: {far} rad/s");
            assert!(results.motion().contains(&format!("{} in its unit", results.size)), "{}", results.motion());
        }
    }

    #[test]
    fn the_lag_comes_to_rest_over_its_experiment() {
        let mut drive = lag();
        let results = Results::of(&mut drive).unwrap();
        let e = drive.experiment();
        assert!(results.whole && results.end() == e.stop, "{}", results.end());
        let csv = results.csv().unwrap();
        let mut lines = csv.lines();
        assert!(lines.next().unwrap().starts_with("time,x"), "{csv}");
        assert_eq!(lines.count(), (e.stop / e.step).round() as usize + 1);
    }
}
