//! What every FMU owes whatever its model: over the scenes of the golden files, of the tests of FMUs and of the examples, and over
//! cam drives in each mode of their drive with an input force as well.

use super::limits::{CLEAR, root};
use camdrive::drives::variable::{Causality, Kind, Variability};
use camdrive::drives::{AnyDrive, Description, Fault};
use camdrive::numerics::work::{BUDGET, drawn};
use camdrive_cli::scene;
use camdrive_design::resource::Resource;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// The scenes of a folder and its folders, with their names.
fn scenes_below(folder: &Path, scenes: &mut Vec<(String, Resource)>) {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            scenes_below(&path, scenes);
        } else if path.extension().is_some_and(|end| end == "toml") {
            let text = std::fs::read_to_string(&path).unwrap();
            let table: Table = text.parse().unwrap();
            // Systems, studies and tasks have none.
            if table.contains_key("model") {
                let name = path.strip_prefix(root()).unwrap().display().to_string();
                scenes.extend(variants(&name, &text, table, folder));
            }
        }
    }
}

/// The scene; a cam drive on its speed, on inputs and at constant speed with an input force, too, where it takes one.
fn variants(name: &str, text: &str, table: Table, folder: &Path) -> Vec<(String, Resource)> {
    let own = scene::resolve(name, text, folder).unwrap_or_else(|faults| panic!("{faults}"));
    let mut all = vec![(name.to_owned(), own.resource())];
    if ["RigidMachine", "DriveTrain"].contains(&table["model"].as_str().unwrap()) {
        return all;
    }
    for mode in ["constant", "speed", "input"] {
        let mut table = table.clone();
        table.remove("start");
        let mut drive = Table::from_iter([("mode".to_owned(), Value::from(mode))]);
        if mode == "constant" {
            drive.insert("speed".to_owned(), Value::from(20.0));
        }
        table.insert("drive".to_owned(), Value::Table(drive));
        let load = table.entry("load").or_insert_with(|| Value::Table(Table::new()));
        load.as_table_mut().unwrap().insert("input".to_owned(), Value::from(true));
        let name = format!("{name}, {mode}");
        let scene = scene::resolve(&name, &toml::to_string(&table).unwrap(), folder);
        all.push((name, scene.unwrap_or_else(|faults| panic!("{faults}")).resource()));
    }
    all
}

/// Those of all files, and variants of them.
fn scenes() -> Vec<(String, Resource)> {
    let mut scenes = Vec::new();
    ["modelDescription", "tests/fmpy/scenes", "examples"]
        .iter()
        .for_each(|folder| scenes_below(&root().join(folder), &mut scenes));
    assert!(scenes.len() > 150, "{}", scenes.len());
    scenes
}

/// Numbers in [−1, 1), the same in every run (the generator of Knuth's MMIX).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// The Reals among the variables that the condition picks.
fn reals(list: &[Description], condition: impl Fn(&Description) -> bool) -> Vec<usize> {
    (0..list.len()).filter(|i| matches!(list[*i].kind, Kind::Real { .. }) && condition(&list[*i])).collect()
}

/// At its start, with random inputs; no inertia follows the shaft, which would change on the way.
fn started(drive: &mut AnyDrive, list: &[Description], random: &mut Random) -> Result<(), Fault> {
    drive.reset();
    drive.set_up(0.0, None);
    for input in reals(list, |d| d.causality == Causality::Input && !d.name.ends_with("J_load")) {
        drive.set(input, 3.0 * random.next())?;
    }
    drive.start()
}

#[test]
fn default_experiments_are_whole_numbers_of_whole_nanoseconds() {
    for (name, resource) in scenes() {
        let e = resource.build().unwrap().experiment();
        let (count, nanoseconds) = (e.stop / e.step, 1e9 * e.step);
        assert!(count.fract() == 0.0 && (1.0..=1000.0).contains(&count), "{name}: {count} steps");
        assert!((nanoseconds - nanoseconds.round()).abs() < 1e-6 * nanoseconds.min(1.0), "{name}: {nanoseconds} ns");
    }
}

/// Whatever its drive, a step of thirty years ends in numbers, or in a fault that says why, within the work of a call.
#[test]
fn a_step_of_thirty_years_takes_the_work_of_a_call_and_no_more() {
    let mut wrong = String::new();
    for (name, resource) in scenes() {
        let mut drive = resource.build().unwrap();
        drive.set_up(0.0, None);
        drive.start().unwrap_or_else(|fault| panic!("{name}: {fault}"));
        // What is far too much is so for a part of the work, too, which takes less time.
        let budget = 0.02 * BUDGET;
        let _limited = drawn::limit(budget);
        drawn::since_last();
        let outcome = drive.advance(0.0, 1e9);
        let drawn = drawn::since_last();
        let said = outcome.as_ref().err().map_or(String::new(), |fault| fault.to_string());
        let is_clear = said.is_empty() || CLEAR.iter().any(|part| said.contains(part));
        // The last draw may go beyond it by an internal step.
        if drawn > 1.2 * budget || !is_clear {
            wrong += &format!("{name}: {drawn:e} of {budget:e}, {said}\n");
        }
        let mut values = (0..drive.descriptions().len()).map(|reference| drive.get(reference));
        if outcome.is_ok() && !values.all(|value| value.is_ok_and(f64::is_finite)) {
            wrong += &format!("{name}: a value is no number\n");
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// The polynomial of an input after `time` (s): its value and its derivatives up to the order of the last one.
fn shifted(course: &[f64], time: f64) -> Vec<f64> {
    let of =
        |order: usize| (order..course.len()).rev().fold(0.0, |sum, j| course[j] + sum * time / (j + 1 - order) as f64);
    (0..course.len()).map(of).collect()
}

/// Which motion of the shaft or which signal an input is, as far as its derivatives go on from it: the inputs that it drives, each
/// with the order of its derivative.
fn driven(list: &[Description], input: usize) -> Vec<(usize, usize)> {
    let place = |name: &str| list.iter().position(|d| d.name == name && d.causality == Causality::Input);
    match (list[input].name.as_str(), place("a")) {
        ("phi" | "w" | "a", Some(a)) => [("phi", 0), ("w", 1)]
            .map(|(name, order)| (place(name).unwrap(), order))
            .into_iter()
            .chain([(a, 2)])
            .collect(),
        _ => vec![(input, 0)],
    }
}

/// Sets the inputs of a course to what it is, the last one with its derivatives.
fn give(drive: &mut AnyDrive, inputs: &[(usize, usize)], course: &[f64]) -> Result<(), Fault> {
    inputs.iter().try_for_each(|(input, order)| drive.set(*input, course.get(*order).copied().unwrap_or(0.0)))?;
    let Some(&(last, from)) = inputs.last() else { return Ok(()) };
    (from + 1..course.len()).try_for_each(|order| drive.set_input_derivative(last, order - from, course[order]))
}

/// The largest difference of two lists, each value by its size.
fn distance(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(x, y)| (x - y).abs() / (x.abs() + y.abs()).max(1e-9)).fold(0.0, f64::max)
}

/// Steps from a time over a length under a derivative of one input, by its place and order: what a whole step and its halves differ by, and what it and one without the derivative do.
fn under_derivative(
    drive: &mut AnyDrive,
    list: &[Description],
    derivative: (usize, usize),
    step: [f64; 2],
) -> Result<[f64; 2], Fault> {
    let ((input, order), [time, h]) = (derivative, step);
    let outputs = reals(list, |d| d.causality == Causality::Output && d.variability == Variability::Continuous);
    let inputs = driven(list, input);
    // The shaft goes on, too.
    let shaft = list.iter().position(|d| d.name == "a" && d.causality == Causality::Input);
    let shaft = shaft.map_or(Vec::new(), |a| driven(list, a));
    let turning = shaft.iter().map(|(of, _)| drive.get(*of)).collect::<Result<Vec<f64>, Fault>>()?;
    let own = inputs.iter().find(|(of, _)| *of == input).map_or(0, |(_, order)| *order);
    let mut course = inputs.iter().map(|(of, _)| drive.get(*of)).collect::<Result<Vec<f64>, Fault>>()?;
    let size = if own == 0 { course[0].abs().max(1.0) } else { course[1].abs().max(1.0) / h.powi(own as i32 - 1) };
    course.resize(course.len().max(own + order + 1), 0.0);
    course[own + order] = size * (1..=order).fold(0.3, |product, n| product * n as f64 / h);
    let begin = drive.save();
    let mut ends = Vec::new();
    for way in [&[1.0][..], &[0.5, 0.5], &[]] {
        drive.restore(&begin);
        let mut done = 0.0;
        for share in way {
            give(drive, &shaft, &shifted(&turning, done))?;
            give(drive, &inputs, &shifted(&course, done))?;
            // The derivative of the input itself acts as the course does.
            if done == 0.0 && own + 1 < inputs.len() {
                give(drive, &inputs, &course[..inputs.len()])?;
                drive.set_input_derivative(input, order, course[own + order])?;
            }
            drive.advance(time + done, share * h)?;
            done += share * h;
        }
        if way.is_empty() {
            drive.advance(time, h)?;
        }
        ends.push(outputs.iter().map(|output| drive.get(*output)).collect::<Result<Vec<f64>, Fault>>()?);
    }
    drive.restore(&begin);
    Ok([distance(&ends[0], &ends[1]), distance(&ends[0], &ends[2])])
}

/// An input with derivatives is their polynomial over the step: in two halves the motion is the same, and without them another.
///
/// Seen to find: derivatives that were dropped with fmi2OK, of an input force where no input came before it.
#[test]
fn derivatives_of_every_input_act_over_the_step() {
    let mut wrong = String::new();
    for (name, resource) in scenes() {
        let mut drive = resource.build().unwrap();
        let list = drive.descriptions().to_vec();
        let h = 3.7 * drive.experiment().step;
        for input in reals(&list, |d| d.causality == Causality::Input) {
            // Of φ and ω the lowest derivatives are inputs themselves; those of an inertia follow from its slope.
            let orders = match (list[input].name.rsplit('.').next().unwrap(), driven(&list, input).len()) {
                ("phi", 3) => 3..4,
                ("w", 3) => 2..4,
                ("J_load" | "dJ_load", _) => continue,
                _ => 1..3,
            };
            for order in orders {
                let (mut random, mut most) = (Random(5), 0.0_f64);
                for _ in 0..6 {
                    let outcome = started(&mut drive, &list, &mut random).and_then(|()| {
                        drive.advance(0.0, h)?;
                        under_derivative(&mut drive, &list, (input, order), [h, h])
                    });
                    let Ok([halves, without]) = outcome else { continue };
                    most = most.max(without);
                    if halves > 1e-3 * without.max(1e-5) {
                        wrong += &format!("{name}: {} of order {order}: halves {halves:e}\n", list[input].name);
                    }
                }
                if most < 1e-6 {
                    wrong += &format!("{name}: {} of order {order} moves nothing: {most:e}\n", list[input].name);
                }
            }
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// The columns of `unknowns` by these knowns, and whatever sums of them are asked for.
fn check_columns(
    drive: &mut AnyDrive,
    unknowns: &[usize],
    knowns: &[usize],
    random: &mut Random,
) -> Result<(), String> {
    let columns: Vec<Result<Vec<f64>, Fault>> =
        knowns.iter().map(|known| drive.directional_derivatives(unknowns, &[(*known, 1.0)])).collect();
    for round in 0..4 {
        // All of them once, then pairs, in any order.
        let picked: Vec<usize> = if round == 0 {
            (0..knowns.len()).rev().collect()
        } else {
            [0; 2].map(|_| (0.5 * (1.0 + random.next()) * knowns.len() as f64) as usize).to_vec()
        };
        let direction: Vec<(usize, f64)> = picked.iter().map(|i| (knowns[*i], random.next())).collect();
        let backwards: Vec<usize> = unknowns.iter().rev().copied().collect();
        let sum = drive.directional_derivatives(&backwards, &direction);
        let known = picked.iter().all(|i| columns[*i].is_ok());
        let Ok(sum) = sum else {
            let said = sum.unwrap_err().to_string();
            // Many columns that each take much work are too much together.
            if known && !said.contains("needs more work than one call may take") {
                return Err(said);
            }
            continue;
        };
        for (row, got) in sum.iter().rev().enumerate() {
            let terms =
                || picked.iter().zip(&direction).map(|(i, (_, by))| columns[*i].as_ref().map_or(0.0, |c| c[row] * by));
            let (expected, size) = terms().fold((0.0, 0.0), |(sum, size), term| (sum + term, size + term.abs()));
            if !known || (got - expected).abs() > 1e-13 * size {
                let (unknown, direction) = (unknowns[row], &direction);
                return Err(format!("row {unknown} along {direction:?}: {got:e} instead of {expected:e}"));
            }
        }
    }
    Ok(())
}

/// A column of the Jacobian does not depend on which others are asked for, nor on their order: in Initialization Mode by inputs and
/// parameters, in Step Mode by inputs and states.
///
/// Seen to find: steps along the known with the largest component, over which others hardly moved.
#[test]
fn directional_derivatives_are_sums_of_columns() {
    let mut wrong = String::new();
    for (name, resource) in scenes().into_iter().filter(|(name, _)| !name.starts_with("examples")) {
        let mut drive = resource.build().unwrap();
        let list = drive.descriptions().to_vec();
        let (mut random, h) = (Random(6), 3.7 * drive.experiment().step);
        let outputs = reals(&list, |d| d.causality == Causality::Output);
        // All inputs, and of the parameters those that were seen to lead astray, and some.
        let count = list.len();
        let mut some = |d: &Description| d.name.starts_with("solver.") || random.next() < 12.0 / count as f64 - 1.0;
        let initial = (0..count).filter(|i| match list[*i].causality {
            Causality::Input => true,
            Causality::Parameter => matches!(list[*i].kind, Kind::Real { .. }) && some(&list[*i]),
            _ => false,
        });
        let initial: Vec<usize> = initial.collect();
        let states = reals(&list, |d| d.causality == Causality::Input || d.state);
        for input in reals(&list, |d| d.causality == Causality::Input) {
            drive.set(input, 3.0 * random.next()).unwrap();
        }
        let mut check = |drive: &mut AnyDrive, knowns: &[usize], mode: &str| {
            if let (false, Err(fault)) = (knowns.is_empty(), check_columns(drive, &outputs, knowns, &mut random)) {
                wrong += &format!("{name}, {mode}: {fault}\n");
            }
        };
        check(&mut drive, &initial, "Initialization Mode");
        if drive.start().is_err() || drive.advance(0.0, h).is_err() {
            continue;
        }
        check(&mut drive, &states, "Step Mode");
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}
