//! What the design tools owe for any scene: a machine whose angle counts from another origin, one that turns the other way,
//! one in other units and one with its followers in another order have the same results, each in its place.
//!
//! The tools run as a user runs them, and what they print as JSON is compared.

mod advice;
mod cam;
mod clearance;
mod compensate;
mod figures;
mod forces;
mod stability;
mod steady;
mod study;
mod synthesize;

use super::scenes::{backwards, times};
use super::{chosen, config};
use camdrive::motion::{Cycle, CyclePlan, MotionLaw, MotionPlan, PlanPoint, Table, table::Points};
use camdrive_cli::scene::{self, Resolved};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use serde_json::{Map, Value, json};
use std::f64::consts::TAU;
use std::fmt::{Debug, Write as _};
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// Powers of kg, m and s.
type Units = [i32; 3];

const NUMBER: Units = [0, 0, 0];
const MASS: Units = [1, 0, 0];
const LENGTH: Units = [0, 1, 0];
const TIME: Units = [0, 0, 1];
const RATE: Units = [0, 0, -1];
const INERTIA: Units = [1, 2, 0];
const FORCE: Units = [1, 1, -2];
/// Also an energy.
const TORQUE: Units = [1, 2, -2];

/// The same machine seen otherwise.
#[derive(Clone, Copy, Debug)]
pub struct Image {
    /// Its angle is `sense` φ + `turn`.
    sense: f64,
    turn: f64,
    /// How many of the new units make a kg, a m and a s.
    units: [f64; 3],
    /// Whether the followers come in the opposite order.
    permuted: bool,
    /// Whether drawings are seen from behind.
    behind: bool,
}

const SAME: Image = Image { sense: 1.0, turn: 0.0, units: [1.0; 3], permuted: false, behind: false };

/// Another origin of the angle.
fn rotation() -> impl Strategy<Value = Image> {
    (0.05..6.2_f64).prop_map(|turn| Image { turn, ..SAME })
}

/// The other sense of rotation.
const MIRROR: Image = Image { sense: -1.0, ..SAME };

/// Other units.
fn scaling() -> impl Strategy<Value = Image> {
    let factor = || (-2.0..2.0_f64).prop_map(f64::exp);
    [factor(), factor(), factor()].prop_map(|units| Image { units, ..SAME })
}

/// Another order.
const PERMUTATION: Image = Image { permuted: true, ..SAME };

impl Image {
    fn factor(&self, units: Units) -> f64 {
        self.units.iter().zip(units).map(|(factor, power)| factor.powi(power)).product()
    }

    /// A quantity that does not know the sense of rotation.
    fn even(&self, value: f64, units: Units) -> f64 {
        value * self.factor(units)
    }

    /// A quantity that changes its sign with it.
    fn odd(&self, value: f64, units: Units) -> f64 {
        self.sense * value * self.factor(units)
    }

    fn angle(&self, phi: f64) -> f64 {
        self.sense * phi + self.turn
    }

    /// The law of something in these units.
    fn law(&self, law: &MotionLaw, units: Units) -> MotionLaw {
        let law = if self.sense < 0.0 { backwards(law) } else { law.clone() };
        let law = if self.turn != 0.0 { delayed(&law, self.turn) } else { law };
        times(&law, self.factor(units))
    }

    fn order<T>(&self, mut list: Vec<T>) -> Vec<T> {
        if self.permuted {
            list.reverse();
        }
        list
    }
}

/// U(φ − angle).
fn delayed(law: &MotionLaw, angle: f64) -> MotionLaw {
    match law {
        MotionLaw::Fourier(series) => MotionLaw::Fourier(series.delayed(angle)),
        MotionLaw::Cycle(cycle) => {
            let plan = *cycle.plan();
            let rise_start = (plan.rise_start + angle).rem_euclid(TAU);
            MotionLaw::Cycle(Cycle::new(CyclePlan { rise_start, ..plan }))
        }
        MotionLaw::Table(table) => {
            let points = table.points();
            let later = points.angles.iter().map(|phi| (phi + angle).rem_euclid(TAU));
            let mut pairs: Vec<(f64, f64)> = later.zip(points.lifts.iter().copied()).collect();
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
            let (angles, lifts) = pairs.into_iter().unzip();
            let mut later = Table::new(Points { angles, lifts }).expect("the same points");
            later.scale = table.scale;
            MotionLaw::Table(later)
        }
        MotionLaw::Plan(plan) => {
            let later = plan.points().iter().map(|point| PlanPoint { phi: point.phi + angle, ..*point });
            MotionLaw::Plan(MotionPlan::new(later.collect()))
        }
        MotionLaw::Polyline(_) | MotionLaw::Crank(_) => {
            unreachable!("no cam is drawn with lines or turns with the shaft")
        }
    }
}

/// Whether extremes of what this law moves lie at one place each: rests make them flat.
fn has_no_rest(law: &MotionLaw) -> bool {
    law.series().is_some()
}

/// A scene or a task with the tables that it names.
#[derive(Clone, Debug, Default)]
pub struct Files {
    scene: Value,
    tables: Vec<String>,
    /// The text of the study, where the tool takes one instead of the scene.
    study: String,
    /// The folder of an example, whose files come along.
    folder: String,
}

impl Files {
    /// The law as scenes name it.
    fn law(&mut self, law: &MotionLaw) -> Value {
        match law {
            MotionLaw::Fourier(series) => json!({"law": "fourier", "a": series.a, "b": series.b[1..]}),
            MotionLaw::Cycle(cycle) => {
                let plan = cycle.plan();
                let mut law = json!({
                    "law": "cycle", "stroke": plan.stroke, "lower": plan.lower, "rise_start": plan.rise_start,
                    "rise": plan.rise_angle, "upper_dwell": plan.upper_dwell, "return": plan.return_angle,
                    "rise_law": plan.rise_law.name(), "return_law": plan.return_law.name(),
                });
                for (key, part) in ["rise_inflection", "return_inflection"].into_iter().zip(plan.inflections) {
                    if let Some(part) = part {
                        law[key] = part.into();
                    }
                }
                law
            }
            MotionLaw::Table(table) => {
                let points = table.points();
                let lifts = points.lifts.iter().map(|lift| table.scale * lift);
                let lines = points.angles.iter().zip(lifts).map(|(phi, lift)| format!("{phi:e};{lift:e}\n"));
                self.tables.push(lines.collect());
                json!({"law": "table", "file": format!("{}.csv", self.tables.len())})
            }
            MotionLaw::Plan(plan) => {
                let point = |point: &PlanPoint| match point.velocity {
                    Some(velocity) => json!({"phi": point.phi, "U": point.u, "dU": velocity}),
                    None => json!({"phi": point.phi, "U": point.u}),
                };
                json!({"law": "plan", "point": plan.points().iter().map(point).collect::<Vec<_>>()})
            }
            MotionLaw::Polyline(_) | MotionLaw::Crank(_) => {
                unreachable!("no cam is drawn with lines or turns with the shaft")
            }
        }
    }

    /// What `camdrive` with these arguments prints, and the folder `out` that it may write to.
    fn run(&self, tool: &str, arguments: &[String]) -> Result<(String, TempDir), String> {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("a file");
        for entry in std::fs::read_dir(&self.folder).into_iter().flatten() {
            let path = entry.expect("an entry").path();
            if path.is_file() {
                std::fs::copy(&path, folder.path().join(path.file_name().expect("a name"))).expect("a copy");
            }
        }
        for (text, number) in self.tables.iter().zip(1..) {
            write(&format!("{number}.csv"), text);
        }
        if !self.scene.is_null() {
            write("scene.toml", &toml::to_string(&self.scene).expect("a scene"));
        }
        write("study.toml", &self.study);
        let file = if self.study.is_empty() { "scene.toml" } else { "study.toml" };
        let mut command = Command::new(env!("CARGO_BIN_EXE_camdrive"));
        let output = command.current_dir(&folder).args([tool, file]).args(arguments).output().expect("a run");
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("UTF-8");
        // Without a periodic motion `steady` ends with 3.
        match output.status.code() {
            Some(0 | 3) => Ok((text(&output.stdout), folder)),
            // `forces` of a follower that leaves its cam prints them, too.
            Some(1) if !output.stdout.is_empty() => Ok((text(&output.stdout), folder)),
            _ => Err(text(&output.stderr)),
        }
    }

    /// The scene as a drive has it.
    fn resolved(&self) -> Result<Resolved, String> {
        let folder = tempfile::tempdir().expect("a folder");
        for (text, number) in self.tables.iter().zip(1..) {
            std::fs::write(folder.path().join(format!("{number}.csv")), text).expect("a file");
        }
        let text = toml::to_string(&self.scene).expect("a scene");
        scene::resolve("scene.toml", &text, folder.path()).map_err(|faults| faults.to_string())
    }

    fn printed(&self, tool: &str, arguments: &[String]) -> Result<Value, String> {
        self.run(tool, arguments).map(|(text, _)| parsed(&text))
    }
}

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

fn read(folder: &TempDir, name: impl AsRef<Path>) -> String {
    std::fs::read_to_string(folder.path().join(name)).expect("a file that was written")
}

/// An argument as the tools take it.
fn option(name: &str, value: f64) -> String {
    format!("--{name}={value:e}")
}

/// How a number changes with the sense of rotation.
#[derive(Clone, Copy, PartialEq)]
enum Sign {
    Even,
    Odd,
    /// It may be told with the sense or without.
    Size,
}

/// What a value of a result is.
enum Of {
    /// Nothing that the image has to repeat.
    Nothing,
    /// A word or a count, which is the same.
    Same,
    /// φ (rad), right to this.
    Angle(f64),
    /// Right to this part of itself, or of the size where it is smaller.
    Number(Units, Sign, [f64; 2]),
}

/// What the values of a result are, by their keys, those above, and the object around them with a `quantity`, or else next to
/// them.
struct Reading<'a> {
    of: &'a dyn Fn(&str, &str, &Map<String, Value>) -> Of,
    /// Lists along the turn.
    around: &'a [&'a str],
    /// Lists along the followers.
    followers: &'a [&'a str],
}

/// The difference of two angles, at most π.
fn apart(a: f64, b: f64) -> f64 {
    (a - b + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0
}

/// Where an element of a list along the turn is.
fn place(element: &Value) -> Option<f64> {
    let of = |path: &str| element.pointer(path)?.as_f64();
    element.as_f64().or_else(|| of("/phi")).or_else(|| of("/crossing/phi")).or_else(|| of("/model/release"))
}

impl Reading<'_> {
    /// Whether `got` is the image of `expected`.
    fn compare(&self, image: &Image, expected: &Value, got: &Value) -> Result<(), String> {
        self.value(image, ["", ""], &Map::new(), [expected, got])
    }

    fn value(
        &self,
        image: &Image,
        path: [&str; 2],
        around: &Map<String, Value>,
        values: [&Value; 2],
    ) -> Result<(), String> {
        let ([above, key], [expected, got]) = (path, values);
        let wrong = |why: String| Err(format!("{above}.{key}: {why}"));
        let of = (self.of)(key, above, around);
        // What was the least is the largest with the other sign.
        let swaps = |of: &Of| image.sense < 0.0 && matches!(of, Of::Number(_, Sign::Odd, _));
        let number = |value: &Value| value.as_f64().expect("a number");
        match (expected, got) {
            _ if matches!(of, Of::Nothing) => Ok(()),
            (Value::Object(fields), Value::Object(other)) => {
                let around = if around.contains_key("quantity") { around } else { fields };
                for (field, expected) in fields {
                    let partner = match (field.strip_prefix("least"), field.strip_prefix("largest")) {
                        (Some(rest), _) => format!("largest{rest}"),
                        (_, Some(rest)) => format!("least{rest}"),
                        _ => field.clone(),
                    };
                    let swapped = swaps(&(self.of)(field, key, around));
                    let got = other.get(if swapped { &partner } else { field }).unwrap_or(&Value::Null);
                    self.value(image, [key, field], around, [expected, got])?;
                }
                Ok(())
            }
            (Value::Array(list), Value::Array(other)) if list.len() != other.len() => {
                wrong(format!("{} instead of {}: {got} instead of {expected}", other.len(), list.len()))
            }
            (Value::Array(list), Value::Array(other)) if self.around.contains(&key) => {
                let mut left: Vec<&Value> = other.iter().collect();
                for expected in list {
                    let distance = |got: &Value| match (place(expected), place(got)) {
                        (Some(phi), Some(got)) => apart(got, image.angle(phi)).abs(),
                        (None, None) => 0.0,
                        _ => f64::INFINITY,
                    };
                    let nearest = (0..left.len()).min_by(|i, j| distance(left[*i]).total_cmp(&distance(left[*j])));
                    let got = left.swap_remove(nearest.expect("as many"));
                    self.value(image, [above, key], around, [expected, got])?;
                }
                Ok(())
            }
            (Value::Array(list), Value::Array(other)) => {
                let back = swaps(&of) || (image.permuted && self.followers.contains(&key));
                for (i, expected) in list.iter().enumerate() {
                    let got = &other[if back { list.len() - 1 - i } else { i }];
                    self.value(image, [above, key], around, [expected, got])?;
                }
                Ok(())
            }
            (Value::Number(_), Value::Number(_)) => {
                let [value, got] = [expected, got].map(number);
                let (value, got, miss, most) = match of {
                    Of::Angle(error) => {
                        let phi = image.angle(value);
                        (phi.rem_euclid(TAU), got, apart(phi, got).abs(), error)
                    }
                    Of::Number(units, sign, [part, size]) => {
                        let got = got / image.factor(units);
                        let (value, got) = match sign {
                            Sign::Even => (value, got),
                            Sign::Odd => (value, image.sense * got),
                            Sign::Size => (value.abs(), got.abs()),
                        };
                        let miss = if got == value { 0.0 } else { (got - value).abs() / value.abs().max(size) };
                        (value, got, miss, part)
                    }
                    _ => (value, got, (got - value).abs(), 0.0),
                };
                if miss <= most { Ok(()) } else { wrong(format!("{got} instead of {value}: {miss:.1e} > {most:e}")) }
            }
            _ if expected == got => Ok(()),
            _ => wrong(format!("{got} instead of {expected}")),
        }
    }

    /// Whether the result of the image is the image of the result; a scene that is refused shows that its image is refused, too.
    fn holds(
        &self,
        image: &Image,
        expected: Result<Value, String>,
        got: Result<Value, String>,
    ) -> Result<(), TestCaseError> {
        match (expected, got) {
            (Ok(expected), Ok(got)) => self.compare(image, &expected, &got).map_err(TestCaseError::fail),
            (Err(reason), Err(_)) => Err(TestCaseError::reject(reason)),
            (Ok(_), Err(reason)) => Err(TestCaseError::fail(format!("the image is refused: {reason}"))),
            (Err(reason), Ok(_)) => Err(TestCaseError::fail(format!("the image is not refused: {reason}"))),
        }
    }
}

/// Holds the relation for so many scenes from the `first` on. All that fail are named, the first one with what it is.
fn for_all<S: Strategy>(
    first: u64,
    scenes: u64,
    strategy: S,
    relation: impl Fn(&S::Value) -> Result<(), TestCaseError>,
) {
    let scenes = scenes * u64::from(chosen()[1]);
    let (mut failures, mut refused) = (String::new(), Vec::new());
    for seed in first..first + scenes {
        let mut runner = TestRunner::new(config(1, 0, seed));
        let value = strategy.new_tree(&mut runner).expect("a scene").current();
        match relation(&value) {
            Ok(()) => {}
            Err(TestCaseError::Reject(reason)) => refused.push(reason),
            Err(TestCaseError::Fail(reason)) => {
                let what = if failures.is_empty() { format!("\n{value:#?}") } else { String::new() };
                let _ = writeln!(failures, "scene {seed}: {reason}{what}");
            }
        }
    }
    assert!(failures.is_empty(), "{failures}");
    // What is refused shows little.
    assert!(2 * refused.len() as u64 <= scenes, "{} of {scenes} are refused: {}", refused.len(), refused[0]);
}
