//! A tunable parameter that is changed between two steps gives the motion of a drive that had it from the start: for every
//! tunable that the list of variables names, in every model with loads whose laws have breakpoints.

use super::run::Run;
use super::{admitted, config};
use camdrive::drives::Fault;
use camdrive::drives::unit;
use camdrive::drives::variable::{Causality, Kind, Variability};
use camdrive_cli::scene;
use camdrive_design::resource::Described;
use proptest::prelude::*;
use std::f64::consts::TAU;

/// The process force of a scene.
const CYCLE: &str = "{ law = 'cycle', stroke = '-30 N', rise_start = '60 deg', rise = '50 deg', upper_dwell = '40 deg', \
    return = '70 deg', rise_law = 'modified_sine', return_law = 'simple_sine' }";
const PLAN: &str = "{ law = 'plan', point = [{ phi = 0, U = '0 N' }, { phi = '50 deg', U = '10 N' }, \
    { phi = '120 deg', U = '34 N', law = 'modified_trapezoid' }, { phi = '200 deg', U = '34 N' }, { phi = '320 deg', U = '-5 N' }, \
    { phi = '360 deg', U = '0 N' }] }";
const POINTS: &str =
    "{ points = [['0 deg', 0], ['90 deg', 0], ['90 deg', '-20 N'], ['200 deg', '-30 N'], ['360 deg', 0]] }";
const SERIES: &str = "{ law = 'fourier', a = ['3 N', '20 N', '-12 N'], b = ['7 N'] }";
const PROCESSES: [&str; 4] = [CYCLE, PLAN, POINTS, SERIES];

/// The loads beside the process force; turns of the shaft take half a second.
const LOAD: &str =
    "gravity = '9.81 m/s2'\nspring = { preload = '60 N', c = '300 N/m', at = '2 mm' }\ndamping = '3 N.s/m'\n";
const CAM: &str = "{ law = 'fourier', a = [0, '-8 mm', '0.9 mm'], b = [0, '0.4 mm'] }";
const CAM_OF_PIECES: &str = "{ law = 'cycle', stroke = '12 mm', rise_law = 'modified_sine', rise = '110 deg', upper_dwell = '40 deg', \
     return_law = 'polynomial_345', return = '90 deg' }";

/// Scenes of all models with loads, at the angle `phi` (rad) of the start, with its process force and one of two cams.
fn scenes(phi: f64, process: &str, cam: &str) -> Vec<String> {
    let load = format!("{LOAD}process = {process}\n");
    let (turning, inputs) =
        (format!("[drive]\nspeed = '12 rad/s'\nphi_start = {phi}\n"), "[drive]\nmode = 'input'\n".to_owned());
    let speed = format!("[drive]\nmode = 'speed'\nphi_start = {phi}\n");
    let output = "[elasticity]\nplace = 'output'\nm = 3\nm_roller = 0.4\nc = 9e3\nb = 20\n";
    let shaft = "[elasticity]\nplace = 'shaft'\nm = 3\nJ = 0.02\nc = 90\nb = 0.1\n";
    let coefficients =
        "[coefficients]\ncoordinate = 'translation'\nm = 2\nc = { a = [9e3, 0, -2e3] }\ndamping_ratio = 0.03\n";
    let machine = |motor: &str, w: f64| {
        format!(
            "[machine]\nJ0 = 0.4\nload.friction = 0.05\n[motor]\n{motor}\n[start]\nw_start = {w}\nphi_start = {phi}\n"
        )
    };
    let kloss = "kind = 'kloss'\nM_k = 20\ns_k = 0.2\nw_s = 12";
    let servo = "kind = 'servo'\nK_p = 3\nK_i = 12\nM_max = 2\nw_ref = 12\nK_v = 4";
    let constant = "kind = 'constant'\ntorque = 0.5";
    let coupled = format!("{constant}\nJ = 0.02\ncoupling = {{ c = 900, b = 1 }}");
    let follower = |joint: &str| format!("[[follower]]\n{joint}\ncam = {cam}\n[follower.load]\n{load}");
    let joints = [
        "m = 2",
        "elasticity = { place = 'output', m = 3, c = 9e3, b = 20 }",
        "elasticity = { place = 'shaft', m = 3, J = 0.02, c = 90, b = 0.1 }",
        "backlash = { m1 = 1, m2 = 2, c = 2e4, b = 20, s = 'inf', e = 0 }",
    ];
    let train = joints.map(follower).concat();
    let mut scenes = Vec::new();
    for drive in [&turning, &inputs, &speed] {
        for part in [output, shaft] {
            scenes.push(format!("model = 'ElasticCamDrive'\ncam = {cam}\n{drive}{part}[load]\n{load}"));
        }
        scenes.push(format!("model = 'ParametricDrive'\n{drive}{coefficients}[load]\n{load}"));
        scenes.push(format!(
            "model = 'BacklashDrive'\ncam = {cam}\n{drive}[backlash]\nm1 = 2\ns = 'inf'\n[load]\n{load}"
        ));
        scenes.push(format!("model = 'DriveTrain'\n{drive}{train}"));
    }
    let linear = shaft.replace("J =", "linear = true\nJ =");
    scenes.push(format!("model = 'ElasticCamDrive'\ncam = {cam}\n{turning}{linear}[load]\n{load}"));
    for motor in [kloss, constant] {
        let machine = machine(motor, 11.0);
        scenes.push(format!("model = 'RigidMachine'\n{machine}{}", follower("m = 2")));
    }
    for (motor, w) in [(kloss, -10.0), (servo, 9.0), (&coupled, 8.0)] {
        scenes.push(format!("model = 'DriveTrain'\n{}{train}", machine(motor, w)));
    }
    scenes
}

/// How many there are.
const SCENES: usize = 21;

/// The speed on inputs (rad/s), the step and the length of a run (s).
const SPEED: f64 = 12.0;
const STEP: f64 = 0.013;
const STEPS: usize = 60;

/// Steps end elsewhere; each keeps this tolerance, and errors grow.
const TOLERANCE: f64 = 1e-11;
const AGREEMENT: f64 = 1e-7;

fn described(text: &str) -> Described {
    let text = format!("name = 'tuned'\n{text}");
    let resolved = scene::resolve("tuned.toml", &text, "".as_ref()).unwrap_or_else(|faults| panic!("{text}\n{faults}"));
    resolved.resource().build().unwrap()
}

/// What may be tuned, by name, with its value and its kind.
fn tunables(drive: &mut Described) -> Vec<(String, f64, Kind)> {
    let all: Vec<_> = drive.descriptions().iter().map(|d| (d.name.clone(), d.variability, d.kind.clone())).collect();
    let tunable = all.into_iter().enumerate().filter(|(_, (_, variability, _))| *variability == Variability::Tunable);
    tunable.map(|(i, (name, _, kind))| (name, drive.get(i).unwrap(), kind)).collect()
}

/// Another value, by two numbers in [0, 1).
fn another(value: f64, kind: &Kind, [pick, way]: [f64; 2]) -> f64 {
    match kind {
        Kind::Enumeration(enumeration) => 1.0 + (pick * enumeration.items.len() as f64).floor(),
        Kind::Real { quantity, min, max, .. } if **quantity == unit::ANGLE => {
            let [low, high] = [min.max(0.0), max.min(TAU)];
            if way < 0.4 { low + pick * (high - low) } else { (value * (0.5 + pick)).clamp(*min, *max) }
        }
        Kind::Real { min, max, .. } => {
            let sign = if way < 0.2 { -1.0 } else { 1.0 };
            (sign * value * (0.3 + 1.5 * pick)).clamp(*min, *max)
        }
        _ => value,
    }
}

/// A drive of the scene, and the angle from which inputs turn it (rad).
struct Tuned {
    run: Run,
    phi: f64,
}

impl Tuned {
    /// At its start with these parameters.
    fn begun(text: &str, phi: f64, settings: &[(&str, f64)]) -> Result<Self, Fault> {
        let mut tuned = Tuned { run: Run::before_start(described(text)), phi };
        if tuned.run.drive.descriptions().iter().any(|d| d.name == "solver.tolerance") {
            tuned.run.set(&[("solver.tolerance", TOLERANCE)])?;
        }
        tuned.turn()?;
        tuned.run.set(settings)?;
        tuned.run.drive.start()?;
        Ok(tuned)
    }

    /// Sets the inputs that turn it.
    fn turn(&mut self) -> Result<(), Fault> {
        let inputs = [("phi", self.phi + SPEED * self.run.time), ("w", SPEED)];
        let is_input = |name: &str| {
            self.run.drive.descriptions().iter().any(|d| d.name == name && d.causality == Causality::Input)
        };
        let inputs: Vec<_> = inputs.into_iter().filter(|(name, _)| is_input(name)).collect();
        self.run.set(&inputs)
    }

    /// So many steps; after each the outputs.
    fn steps(&mut self, count: usize) -> Result<Vec<Vec<f64>>, Fault> {
        (0..count)
            .map(|_| {
                self.run.to(self.run.time + STEP)?;
                self.turn()?;
                Ok(self.run.values())
            })
            .collect()
    }

    /// Refuses motions that differ from others by more than what steps of another length make.
    fn agrees(&self, found: &[Vec<f64>], expected: &[Vec<f64>]) -> Result<(), TestCaseError> {
        let outputs = self.run.outputs();
        let mut sizes: Vec<f64> = vec![0.0; outputs.len()];
        for (i, (_, quantity)) in outputs.iter().enumerate() {
            let alike = (0..outputs.len()).filter(|k| outputs[*k].1.name == quantity.name);
            sizes[i] = alike.flat_map(|k| expected.iter().map(move |values| values[k].abs())).fold(1e-9, f64::max);
        }
        for (step, (found, expected)) in found.iter().zip(expected).enumerate() {
            // The growth of free vibrations belongs to the parameters of the start.
            let is_motion = |name: &str| !name.starts_with("solver.") && name != "growth";
            for (i, (name, _)) in outputs.iter().enumerate().filter(|(_, (name, _))| is_motion(name)) {
                let error = (found[i] - expected[i]).abs();
                prop_assert!(
                    error <= AGREEMENT * sizes[i],
                    "`{name}` after step {step}: {} instead of {}",
                    found[i],
                    expected[i]
                );
            }
        }
        Ok(())
    }
}

/// Changed values of some tunables: which, and to what, by numbers in [0, 1).
fn changes(text: &str, picks: &[[f64; 3]]) -> Vec<(String, f64)> {
    let all = tunables(&mut described(text));
    let mut changes: Vec<(String, f64)> = Vec::new();
    for [which, pick, way] in picks {
        let (name, value, kind) = &all[(which * all.len() as f64) as usize];
        if !changes.iter().any(|(own, _)| own == name) {
            changes.push((name.clone(), another(*value, kind, [*pick, *way])));
        }
    }
    changes
}

fn borrowed(changes: &[(String, f64)]) -> Vec<(&str, f64)> {
    changes.iter().map(|(name, value)| (name.as_str(), *value)).collect()
}

/// Changed at the start, before anything has moved.
fn from_the_start(text: &str, phi: f64, picks: &[[f64; 3]]) -> Result<(), TestCaseError> {
    let changes = changes(text, picks);
    let mut expected = admitted(Tuned::begun(text, phi, &borrowed(&changes)))?;
    let expected = admitted(expected.steps(STEPS))?;
    let mut tuned = admitted(Tuned::begun(text, phi, &[]))?;
    admitted(tuned.run.set(&borrowed(&changes)))?;
    let found = admitted(tuned.steps(STEPS))?;
    tuned.agrees(&found, &expected).map_err(|error| said(error, text, &changes))
}

fn said(error: TestCaseError, text: &str, changes: &[(String, f64)]) -> TestCaseError {
    match error {
        TestCaseError::Fail(reason) => TestCaseError::fail(format!("{reason}\n{changes:?}\n{text}")),
        rejected => rejected,
    }
}

/// Changed at any instant where the process force has not acted before, since its values are zero: whatever its pieces were, the
/// motion is that of a drive that had them from the start.
fn at_any_instant(text: &str, phi: f64, picks: &[[f64; 3]], instant: usize) -> Result<(), TestCaseError> {
    let all = tunables(&mut described(text));
    let is_process = |name: &str| name.contains(".process.");
    let is_size =
        |kind: &Kind| matches!(kind, Kind::Real { quantity, .. } if ["Force", "Torque"].contains(&quantity.name));
    let is_amplitude = |name: &str, kind: &Kind| is_process(name) && (is_size(kind) || name.ends_with(".scale"));
    let amplitudes: Vec<_> = all.iter().filter(|(name, _, kind)| is_amplitude(name, kind)).collect();
    let none: Vec<_> = amplitudes.iter().map(|(name, ..)| (name.as_str(), 0.0)).collect();
    let full: Vec<_> = amplitudes.iter().map(|(name, value, _)| (name.as_str(), *value)).collect();
    let mut shape = changes(text, picks);
    shape.retain(|(name, _)| is_process(name) && !full.iter().any(|(own, _)| own == name));
    let begun = |settings: &[(&str, f64)]| -> Result<Tuned, Fault> {
        let mut tuned = Tuned::begun(text, phi, settings)?;
        tuned.steps(instant)?;
        Ok(tuned)
    };
    let mut expected = admitted(begun(&[&none[..], &borrowed(&shape)].concat()))?;
    admitted(expected.run.set(&full))?;
    let expected = admitted(expected.steps(STEPS))?;
    let mut tuned = admitted(begun(&none))?;
    admitted(tuned.run.set(&[&full[..], &borrowed(&shape)].concat()))?;
    let found = admitted(tuned.steps(STEPS))?;
    tuned.agrees(&found, &expected).map_err(|error| said(error, text, &shape))
}

/// Changed and changed back before the next step, with the outputs read between; and saved and restored between change and step.
fn there_and_back(text: &str, phi: f64, picks: &[[f64; 3]], instant: usize) -> Result<(), TestCaseError> {
    let (changes, before) = (changes(text, picks), tunables(&mut described(text)));
    let back: Vec<_> = before.iter().map(|(name, value, _)| (name.as_str(), *value)).collect();
    let mut run = admitted(Tuned::begun(text, phi, &[]))?;
    admitted(run.steps(instant))?;
    let mut tuned = admitted(Tuned::begun(text, phi, &[]))?;
    admitted(tuned.steps(instant))?;
    admitted(tuned.run.set(&borrowed(&changes)))?;
    let bytes = tuned.run.drive.save().serialize().expect("a state of this model");
    let mut restored = Tuned { run: Run::before_start(described(text)), phi };
    let state = tuned.run.drive.deserialize(&bytes).expect("its own state");
    restored.run.drive.restore(&state);
    restored.run.time = tuned.run.time;
    let read = |tuned: &mut Tuned| -> Result<Vec<f64>, Fault> {
        let references = 0..tuned.run.drive.descriptions().len();
        references.map(|reference| tuned.run.drive.get(reference)).collect()
    };
    let (own, other) = (admitted(read(&mut tuned))?, admitted(read(&mut restored))?);
    prop_assert_eq!(own, other, "restored with {:?}\n{}", changes, text);
    let mut copy = Tuned { run: Run::before_start(described(text)), phi };
    copy.run.drive.restore(&tuned.run.drive.save());
    copy.run.time = tuned.run.time;
    let [one, two] = [admitted(copy.steps(STEPS))?, admitted(restored.steps(STEPS))?];
    prop_assert_eq!(one, two, "restored with {:?}\n{}", changes, text);
    admitted(tuned.run.set(&back))?;
    let [expected, found] = [admitted(run.steps(STEPS))?, admitted(tuned.steps(STEPS))?];
    tuned.agrees(&found, &expected).map_err(|error| said(error, text, &changes))
}

/// A scene, the angle of its start, and numbers that choose changes.
fn tuned() -> impl Strategy<Value = (String, f64, Vec<[f64; 3]>)> {
    let number = || 0.0..1.0_f64;
    let picks = prop::collection::vec([number(), number(), number()], 1..6);
    (0..SCENES, 0..PROCESSES.len(), any::<bool>(), 0.0..TAU, picks).prop_map(|(scene, process, pieces, phi, picks)| {
        let cam = if pieces { CAM_OF_PIECES } else { CAM };
        (scenes(phi, PROCESSES[process], cam).swap_remove(scene), phi, picks)
    })
}

proptest! {
    #![proptest_config(config(60, 120, 70))]

    #[test]
    fn a_parameter_changed_at_the_start((text, phi, picks) in tuned()) { from_the_start(&text, phi, &picks)?; }

    #[test]
    fn a_process_changed_at_any_instant((text, phi, picks) in tuned(), instant in 0..40_usize) {
        at_any_instant(&text, phi, &picks, instant)?;
    }

    #[test]
    fn a_parameter_changed_and_changed_back((text, phi, picks) in tuned(), instant in 0..40_usize) {
        there_and_back(&text, phi, &picks, instant)?;
    }
}

#[test]
fn every_scene_is_one_and_has_tunables() {
    for process in PROCESSES {
        for text in [CAM, CAM_OF_PIECES].iter().flat_map(|cam| scenes(1.0, process, cam)) {
            assert!(!tunables(&mut described(&text)).is_empty(), "{text}");
        }
    }
    assert_eq!(scenes(1.0, CYCLE, CAM).len(), SCENES);
}

#[test]
fn points_that_make_no_plan_are_refused_between_two_steps() {
    for text in scenes(1.0, PLAN, CAM) {
        let mut tuned = Tuned::begun(&text, 1.0, &[]).unwrap_or_else(|fault| panic!("{fault}\n{text}"));
        tuned.steps(3).unwrap();
        let all = tunables(&mut described(&text));
        let (name, ..) = all.iter().find(|(name, ..)| name.ends_with("process.point[4].phi")).unwrap();
        tuned.run.set(&[(name, 0.0)]).unwrap();
        let fault = tuned.steps(1).expect_err(&text);
        let load = name.split(".point").next().unwrap();
        assert!(fault.to_string().contains(load), "{fault}\n{text}");
    }
}
