//! A tunable changed between two steps gives the motion of a train that had it from the start.

use super::super::*;
use super::reference::{backlash, kloss, machine, output, press_scene, scene, series, shaft};
use crate::drives::AnyDrive;
use crate::drives::follower::load::{Load, Spring};
use crate::drives::variable::{Causality, Kind, Variability};
use crate::motion::{Cycle, CyclePlan, MotionLaw, StandardLaw};
use crate::numerics::work::drawn;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Length of the steps (s), of which a turn takes 40, and how many make a run.
const STEP: f64 = 0.0125;
const STEPS: usize = 50;

/// Uniform numbers in [0, 1) (Steele, Lea, Flood: SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / 2f64.powi(64)
    }
}

/// A process force of pieces, with a weight, a spring and a damper.
fn load(law: usize) -> Load {
    let plan = CyclePlan {
        stroke: -30.0,
        lower: 0.0,
        rise_start: 1.0,
        rise_angle: 0.9,
        upper_dwell: 0.7,
        return_angle: 1.2,
        rise_law: StandardLaw::ALL[law % StandardLaw::ALL.len()],
        return_law: StandardLaw::SimpleSine,
        inflections: [None; 2],
    };
    Load {
        gravity: Some(-9.81),
        spring: Some(Spring { preload: 60.0, c: 300.0, at: 0.002 }),
        damping: Some(3.0),
        process: Some(MotionLaw::Cycle(Cycle::new(plan))),
        ..Load::default()
    }
}

/// A train with followers of every kind at the angle `phi` (rad), on a shaft of this kind.
fn train(kind: usize, phi: f64, law: usize) -> Scene {
    let cam = || series(&[0.0, -0.008, 0.0009], &[0.0004]);
    let mut followers = vec![
        output(cam(), [3.0, 9e3, 20.0], 0.4),
        shaft(cam(), [3.0, 0.02, 90.0, 0.1]),
        backlash(cam(), [1.0, 2.0, 2e4, 20.0, f64::INFINITY, 0.0]),
    ];
    followers.iter_mut().enumerate().for_each(|(j, follower)| follower.load = load(law + j));
    let shaft = match kind {
        0 => Shaft::Driven(DriveMode::Constant { w: 12.0, phi_start: phi }),
        1 => Shaft::Driven(DriveMode::Input),
        2 => Shaft::Free(machine(0.4, [phi, -10.0], kloss(20.0, 0.2, -12.0, None))),
        _ => Shaft::Free(machine(0.4, [phi, 9.0], kloss(20.0, 0.2, 12.0, Some(0.01)))),
    };
    scene(shaft, followers)
}

/// A train by its variables, and the angle from which inputs turn it (rad).
struct Tuned {
    drive: AnyDrive,
    time: f64,
    phi: f64,
}

impl Tuned {
    fn new(scene: Scene, phi: f64, settings: &[(usize, f64)]) -> Result<Self, Fault> {
        let mut tuned = Tuned { drive: AnyDrive::new(DriveTrain::new(scene)?), time: 0.0, phi };
        tuned.drive.set_up(0.0, None);
        tuned.turn();
        tuned.set(settings);
        tuned.drive.start()?;
        Ok(tuned)
    }

    fn set(&mut self, settings: &[(usize, f64)]) {
        settings.iter().for_each(|(place, value)| self.drive.set(*place, *value).unwrap());
    }

    fn turn(&mut self) {
        for (name, value) in [("phi", self.phi + 12.0 * self.time), ("w", 12.0)] {
            let is_input = |d: &crate::drives::Description| d.name == name && d.causality == Causality::Input;
            if let Some(place) = self.drive.descriptions().iter().position(is_input) {
                self.drive.set(place, value).unwrap();
            }
        }
    }

    /// The values of all outputs except the solver's, now and after each step.
    fn run(&mut self, steps: usize) -> Result<Vec<Vec<f64>>, Fault> {
        let is_output =
            |d: &crate::drives::Description| d.causality == Causality::Output && matches!(d.kind, Kind::Real { .. });
        let places: Vec<usize> =
            (0..self.drive.descriptions().len()).filter(|i| is_output(&self.drive.descriptions()[*i])).collect();
        let mut all = Vec::new();
        for i in 0..=steps {
            if i > 0 {
                self.drive.advance(self.time, STEP)?;
                self.time += STEP;
                self.turn();
            }
            all.push(places.iter().map(|place| self.drive.get(*place)).collect::<Result<_, _>>()?);
        }
        Ok(all)
    }
}

/// Refuses runs that differ by more than 1e-7 of the largest values.
fn agree(found: &[Vec<f64>], expected: &[Vec<f64>], case: &str) {
    for (i, _) in expected[0].iter().enumerate() {
        let size = expected.iter().map(|values| values[i].abs()).fold(1e-6, f64::max);
        for (step, (found, expected)) in found.iter().zip(expected).enumerate() {
            let error = (found[i] - expected[i]).abs();
            assert!(
                error <= 1e-7 * size,
                "{case}: output {i} after step {step}: {} instead of {}",
                found[i],
                expected[i]
            );
        }
    }
}

/// Other values of some tunables, by their places; `of` are those that may be chosen.
fn changes(r: &mut Random, scene: &Scene, of: impl Fn(&str) -> bool) -> Vec<(usize, f64)> {
    let mut drive = AnyDrive::new(DriveTrain::new(scene.clone()).unwrap());
    let all = drive.descriptions().to_vec();
    let tunable = |i: &usize| all[*i].variability == Variability::Tunable && of(&all[*i].name);
    let tunables: Vec<usize> = (0..all.len()).filter(tunable).collect();
    let mut changes: Vec<(usize, f64)> = Vec::new();
    for _ in 0..1 + (5.0 * r.next()) as usize {
        let place = tunables[(r.next() * tunables.len() as f64) as usize];
        let value = drive.get(place).unwrap();
        let other = match &all[place].kind {
            Kind::Enumeration(laws) => 1.0 + (r.next() * laws.items.len() as f64).floor(),
            Kind::Real { min, max, .. } => (value * (0.3 + 1.4 * r.next())).clamp(*min, *max),
            _ => value,
        };
        if !changes.iter().any(|(own, _)| *own == place) {
            changes.push((place, other));
        }
    }
    changes
}

/// After reading a saved state between the change and the step, the motion is the same.
fn saved(tuned: &mut Tuned, scene: &Scene) -> Tuned {
    let bytes = tuned.drive.save().serialize().unwrap();
    let mut other =
        Tuned { drive: AnyDrive::new(DriveTrain::new(scene.clone()).unwrap()), time: tuned.time, phi: tuned.phi };
    let state = other.drive.deserialize(&bytes).unwrap();
    other.drive.restore(&state);
    other
}

#[test]
fn tunables_changed_at_any_angle_of_the_start_act_as_from_the_start() {
    let r = &mut Random(1);
    let mut compared = 0;
    for case in 0..60 {
        let (phi, law) = (TAU * r.next(), case / 4);
        let scene = train(case % 4, phi, law);
        let changes = changes(r, &scene, |_| true);
        let Ok(mut expected) = Tuned::new(scene.clone(), phi, &changes) else { continue };
        let mut tuned = Tuned::new(scene.clone(), phi, &[]).unwrap();
        tuned.set(&changes);
        let mut restored = saved(&mut tuned, &scene);
        let found = tuned.run(STEPS).unwrap();
        assert_eq!(restored.run(STEPS / 10).unwrap(), found[..=STEPS / 10], "case {case}");
        agree(&found, &expected.run(STEPS).unwrap(), &format!("case {case}, {changes:?}"));
        compared += 1;
    }
    assert!(compared > 30, "{compared}");
}

#[test]
fn pieces_of_a_process_that_has_not_acted_may_be_others_at_any_instant() {
    let r = &mut Random(2);
    let mut compared = 0;
    for case in 0..60 {
        let (phi, instant) = (TAU * r.next(), (45.0 * r.next()) as usize);
        let scene = train(case % 4, phi, case / 4);
        let all = AnyDrive::new(DriveTrain::new(scene.clone()).unwrap()).descriptions().to_vec();
        let strokes = (0..all.len()).filter(|i| all[*i].name.ends_with("process.stroke"));
        let [none, full]: [Vec<(usize, f64)>; 2] =
            [0.0, -30.0].map(|force| strokes.clone().map(|i| (i, force)).collect());
        let shapes = |name: &str| name.contains("process.") && !name.ends_with("stroke") && !name.ends_with("lower");
        let changes = changes(r, &scene, shapes);
        let Ok(mut expected) = Tuned::new(scene.clone(), phi, &[&none[..], &changes].concat()) else { continue };
        expected.run(instant).unwrap();
        expected.set(&full);
        let mut tuned = Tuned::new(scene, phi, &none).unwrap();
        tuned.run(instant).unwrap();
        tuned.set(&[&full[..], &changes].concat());
        let expected = expected.run(STEPS).unwrap();
        agree(&tuned.run(STEPS).unwrap(), &expected, &format!("case {case}, {changes:?} after step {instant}"));
        compared += 1;
    }
    assert!(compared > 30, "{compared}");
}

#[test]
fn the_work_of_mechanisms_without_a_cam_is_counted() {
    let mut train = Tuned::new(press_scene(), 0.0, &[]).unwrap();
    let steps = train.drive.descriptions().iter().position(|d| d.name == "solver.steps").unwrap();
    let own = press_scene().followers.iter().map(|follower| follower.rigid.linkage.cost()[1]).sum::<f64>();
    drawn::since_last();
    train.drive.advance(0.0, 1.0).unwrap();
    let (drawn, steps) = (drawn::since_last(), train.drive.get(steps).unwrap());
    // A series for the motion, and one of less order for its error.
    assert!(own > 0.0 && drawn > 1.5 * own * steps, "{drawn} in {steps} steps");
    let _limited = drawn::limit(1e4);
    let told = train.drive.advance(1.0, 1e9).unwrap_err().to_string();
    assert!(told.contains("need more work than one call may take"), "{told}");
}

#[test]
fn a_forged_state_of_a_train_is_refused_or_ends_in_numbers() {
    let count = std::env::var("FORGED").map_or(2000, |count| count.parse().unwrap());
    let quiet = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let mut told = Vec::new();
    for kind in 0..4 {
        let (r, scene) = (&mut Random(kind as u64), train(kind, 0.5, kind));
        let mut train = Tuned::new(scene.clone(), 0.5, &[]).unwrap();
        train.run(20).unwrap();
        let bytes = train.drive.save().serialize().unwrap();
        let _limited = drawn::limit(3e3);
        for case in 0..count {
            let (mut forged, at) = (bytes.clone(), (r.next() * bytes.len() as f64) as usize);
            if r.next() < 0.5 {
                forged[at] = (256.0 * r.next()) as u8;
            } else {
                let number = [f64::NAN, f64::INFINITY, 1e300, -1e300, 0.0, 1e-300, -1.0][(7.0 * r.next()) as usize];
                let end = (at + 8).min(bytes.len());
                forged[at..end].copy_from_slice(&number.to_le_bytes()[..end - at]);
            }
            let outcome = catch_unwind(AssertUnwindSafe(|| {
                let Ok(state) = train.drive.deserialize(&forged) else { return };
                train.drive.restore(&state);
                train.time = 21.0 * STEP;
                let _ = train.run(2);
            }));
            if let Err(panic) = outcome {
                let text = panic.downcast_ref::<String>().cloned().unwrap_or_default();
                told.push(format!("shaft {kind}, case {case}, byte {at}: {text}"));
            }
        }
    }
    std::panic::set_hook(quiet);
    let some = &told[..told.len().min(12)];
    assert!(told.is_empty(), "{} panics of {}: {some:#?}", told.len(), 4 * count);
}

#[test]
fn an_output_that_is_a_sum_of_states_is_read_alone_to_the_same_digits() {
    for kind in [0, 2, 3] {
        let mut scene = train(kind, 0.5, kind);
        // A gap with two flanks, from which m1 bounces.
        scene.followers[2] = backlash(series(&[0.0, 0.03, 0.004], &[0.02]), [1.0, 3.0, 4000.0, 10.0, 0.003, 0.3]);
        let mut train = DriveTrain::new(scene).unwrap();
        train.start(0.0).unwrap();
        let table = train.table();
        let mut values = vec![0.0; variables::FIRST + table.len()];
        for i in 0..STEPS {
            train.advance(i as f64 * STEP, STEP).unwrap();
            train.evaluate(&mut values);
            for (place, value) in values.iter().enumerate() {
                assert!(train.value(place).is_none_or(|alone| alone == *value), "{kind}, place {place}: {value}");
            }
        }
        assert!(train.run.tallies[2].impacts > 3.0);
        let alone: Vec<bool> = (0..table.len()).map(|i| train.value(variables::FIRST + i).is_some()).collect();
        let names: Vec<String> =
            table.iter().zip(alone).filter(|(_, alone)| *alone).map(|(row, _)| train.name_of(row)).collect();
        let own =
            ["1].y", "1].q", "2].q", "2].U", "3].x1", "3].y", "3].q", "3].gap"].map(|name| format!("follower[{name}"));
        let rates = ["1].y", "1].q", "2].q", "3].x1"].map(|name| format!("der(follower[{name})"));
        let of_shaft = ["phi", "w"].into_iter().filter(|_| kind > 0).map(str::to_owned);
        assert!(of_shaft.chain(own).chain(rates).all(|name| names.contains(&name)), "{kind}: {names:?}");
    }
}
