//! Each drive, asked for far too much: every call ends, within its work, with a result or with a fault that names the matter.

use camdrive::drives::AnyDrive;
use camdrive::drives::variable::Causality;
use camdrive::numerics::work::{BUDGET, drawn};
use camdrive_cli::scene;
use camdrive_design::host::Host;
use camdrive_design::resource::Described;
use camdrive_design::resource::Resource;
use std::path::{Path, PathBuf};

/// The folder of the workspace.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// A step that is asked for, what was set before it, and what the fault says; empty where the step is to go well.
struct Case {
    scene: &'static str,
    settings: &'static [(&'static str, f64)],
    step: f64,
    fault: &'static str,
}

const fn case(scene: &'static str, settings: &'static [(&'static str, f64)], step: f64, fault: &'static str) -> Case {
    Case { scene, settings, step, fault }
}

const TOO_MUCH: &str = "need more work than one call may take: ";
const RUNS_AWAY: &str = "its speed exceeds 1e7 rad/s";
const SEARCH: &str = "the search for the periodic motion needs more work than one call may take";
const ANGLE: &str = "beyond 1e15 rad numbers do not resolve the position";
/// What a fault says of a call that ends.
pub const CLEAR: [&str; 6] = [
    "is not admissible; expected ",
    TOO_MUCH,
    ANGLE,
    "the machine runs away",
    "no internal step keeps",
    "grows without bound",
];

/// A thousandth of a radian for the return, and the periodic motion.
const STEEP: &[(&str, f64)] = &[("cam.return", 1e-3), ("start.mode", 3.0)];

/// A follower of a million tonnes with a lift of kilometres.
const HUGE: [(&str, f64); 2] = [("follower[1].cam.a[1]", 1e4), ("follower[1].m", 1e9)];

const CASES: &[Case] = &[
    // Motions that are steep.
    case("output_cycle", STEEP, 1.0, ""),
    case("shaft_cycle", STEEP, 1e-3, SEARCH),
    case("backlash_cycle", STEEP, 1e-3, "does not repeat from turn to turn within 2000 turns"),
    case("machine_cycle", &[("follower[1].cam.return", 1e-3)], 1.0, ""),
    // Speeds.
    case("output", &[("drive.w", 1e6)], 1.0, ""),
    case("output_cycle", &[("drive.w", 1e6)], 1.0, ""),
    case("shaft", &[("drive.w", 1e6)], 1.0, TOO_MUCH),
    case("shaft", &[("drive.w", 1e6), ("shaft.linear", 1.0)], 1.0, ""),
    case("shaft_cycle", &[("drive.w", 1e6)], 1.0, TOO_MUCH),
    case("shaft", &[("drive.w", 1e5)], 1.0, TOO_MUCH),
    case("backlash", &[("drive.w", 1e6)], 1.0, TOO_MUCH),
    case("backlash_wide", &[("drive.w", 1e6)], 1.0, TOO_MUCH),
    case("parametric", &[("drive.w", 1e6)], 1.0, ""),
    case("crank", &[("drive.w", 1e6)], 1.0, ""),
    case("parametric_wide", &[("m.b[6]", -0.01)], 1e-3, ""),
    case("parametric_wide", &[("c.b[64]", -1e15)], 1e-3, ""),
    case("machine", &[("w_start", 1e6)], 0.1, ""),
    case("machine", &[("w_start", 1e6)], 10.0, TOO_MUCH),
    case("machine", &[("w_start", 1e6), ("solver.method", 2.0)], 1.0, TOO_MUCH),
    // Inputs.
    case("output_input", &[("w", 1e8)], 1e-3, "`w`: 1e8 rad/s is not admissible; expected -1000000 to 1000000 rad/s"),
    case("output_input", &[("phi", 1e16)], 1e-3, "`phi`: 1e16 rad is not admissible"),
    case("output_input", &[("w", 1e6)], 1e-3, ""),
    case("output_input", &[("w", 1e6), ("a", 1e3)], 1.0, TOO_MUCH),
    case("output_input", &[("a", 1e9)], 1.0, TOO_MUCH),
    case("output_wide_input", &[("a", 1e12)], 1e-3, TOO_MUCH),
    case("output_input", &[("a", 1e12)], 100.0, ANGLE),
    case("shaft_input", &[("w", 1e6)], 1e-3, ""),
    case("shaft_input", &[("w", 1e5)], 1.0, "the cam makes 15915.5 turns with w = 100000 rad/s, and only"),
    case("shaft_input", &[("a", 1e9)], 1.0, "turns with w = 0 rad/s and a = 1e9 rad/s², and only"),
    case("shaft_wide_input", &[("a", 1e12)], 1e-3, TOO_MUCH),
    case("shaft_input", &[("a", 1e12)], 100.0, ANGLE),
    case("backlash_input", &[("w", 1e6)], 1e-3, ""),
    case("backlash_input", &[("w", 1e5)], 0.1, ""),
    case("backlash_input", &[("w", 1e6)], 1.0, TOO_MUCH),
    case("backlash_input", &[("w", 1e5), ("a", 1e3)], 1.0, TOO_MUCH),
    case("backlash_wide_input", &[("a", 1e12)], 1e-3, TOO_MUCH),
    case("backlash_input", &[("a", 1e12)], 100.0, ANGLE),
    case("parametric_input", &[("w", 1e6)], 1e-3, ""),
    case("parametric_input", &[("w", 1e6)], 1.0, TOO_MUCH),
    case("crank_input", &[("a", 1e9)], 1.0, TOO_MUCH),
    case("parametric_input", &[("a", 1e12)], 100.0, ANGLE),
    // Communication steps.
    case("output", &[], 1e12, ""),
    case("output_cycle", &[], 1e12, ""),
    case("shaft", &[], 1e12, TOO_MUCH),
    case("shaft", &[("shaft.linear", 1.0)], 1e12, ""),
    case("shaft", &[("shaft.linear", 1.0)], 1e30, ANGLE),
    case("shaft", &[("solver.method", 2.0), ("solver.step_size", 1e-12)], 1e3, TOO_MUCH),
    case("backlash", &[], 1e12, TOO_MUCH),
    case("backlash", &[("drive.w", 0.0)], 1e30, TOO_MUCH),
    case("parametric", &[], 1e12, ""),
    case("machine", &[], 1e13, TOO_MUCH),
    case("machine_torque", &[("w_start", 0.0), ("tau", 1e-3)], 1e30, TOO_MUCH),
    case("machine_motor", &[], 1e13, TOO_MUCH),
    case("machine_lag", &[], 1e13, TOO_MUCH),
    case("machine_motor", &[("solver.method", 2.0)], 1e13, TOO_MUCH),
    // Trains.
    case("train", &[], 1e12, TOO_MUCH),
    case("train", &[], 1e30, ANGLE),
    case("train_lift", &[], 1e12, TOO_MUCH),
    case("train_sixteen", &[], 1e4, TOO_MUCH),
    case("train", &[("w_start", 1e6)], 1.0, TOO_MUCH),
    case("train", &[("follower[1].c", 1e24)], 1.0, TOO_MUCH),
    case("train_lift", &[("w_start", 1e6)], 1e-3, ""),
    case("train_lift", &[("follower[1].e", 1.0), ("follower[2].e", 1.0), ("follower[2].s", 1e-9)], 1.0, TOO_MUCH),
    case("train_sixteen", &[("J0", 1e-20)], 1e-3, ""),
    // Inertias that change by any amount.
    case("machine", &[("J0", 1e-20)], 1.0, ""),
    case("machine", &[("J0", 1e-20), ("phi_start", 1.0)], 1.0, RUNS_AWAY),
    case("machine_motor", &[("J0", 1e-20)], 1.0, TOO_MUCH),
    case("machine_motor", &[("J0", 1e-20), ("start.mode", 2.0)], 1.0, SEARCH),
    case("machine_lag", &[("J0", 1e-20)], 1.0, TOO_MUCH),
    case("machine_cycle", &[("J0", 1e-20), ("phi_start", 1.0)], 1.0, RUNS_AWAY),
    case("machine", &[HUGE[0], HUGE[1]], 1.0, ""),
    case("machine", &[HUGE[0], HUGE[1], ("phi_start", 1.0)], 1.0, RUNS_AWAY),
    case("machine_motor", &[HUGE[0], HUGE[1]], 1.0, ""),
    case("machine_motor", &[HUGE[0], HUGE[1], ("start.mode", 2.0)], 1.0, SEARCH),
    case("machine_lag", &[HUGE[0], HUGE[1], ("start.mode", 2.0)], 1.0, SEARCH),
    case("machine_motor", &[("motor.s_k", 1e-9), ("start.mode", 2.0)], 1.0, ""),
    case("machine_lag", &[("motor.T_el", 1e-9), ("start.mode", 2.0)], 1.0, ""),
];

fn folder() -> PathBuf {
    root().join("tests/fmpy/extremes/scenes")
}

/// The scenes of the extremes.
fn scenes() -> impl Iterator<Item = String> {
    let files = std::fs::read_dir(folder()).unwrap();
    files.map(|file| file.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned())
}

fn resource(name: &str) -> Resource {
    let path = folder().join(name).with_extension("toml");
    scene::read(&path).unwrap_or_else(|faults| panic!("{faults}")).resource()
}

/// The drive of a scene of the extremes.
pub fn drive(name: &str) -> Described {
    resource(name).build().unwrap()
}

/// The references of the inputs, with their names.
fn inputs(drive: &AnyDrive) -> Vec<(u32, String)> {
    let descriptions = (0..).zip(drive.descriptions());
    let inputs = descriptions.filter(|(_, d)| d.causality == Causality::Input);
    inputs.map(|(reference, d)| (reference, d.name.clone())).collect()
}

impl Case {
    /// Calls one after the other, up to the first that is refused; each within its work.
    fn run(&self, budget: f64) -> Result<(), String> {
        drawn::since_last();
        let mut drive = drive(self.scene);
        let names: Vec<String> = drive.descriptions().iter().map(|d| d.name.clone()).collect();
        let within = |what: &str| {
            let drawn = drawn::since_last();
            // The last draw may go beyond it by an internal step.
            assert!(drawn <= 1.1 * budget, "{what}: {drawn:e}");
        };
        drawn::since_last();
        for (name, value) in self.settings {
            let reference = names.iter().position(|own| own == name).unwrap_or_else(|| panic!("{name}"));
            drive.set(reference, *value).map_err(|fault| fault.to_string())?;
        }
        let started = drive.start();
        within("the start");
        started.map_err(|fault| fault.to_string())?;
        let advanced = drive.advance(0.0, self.step);
        within("the step");
        advanced.map_err(|fault| fault.to_string())?;
        for (reference, name) in names.iter().enumerate() {
            let read = drive.get(reference);
            within(name);
            read.map_err(|fault| fault.to_string())?;
        }
        Ok(())
    }
}

#[test]
fn whatever_is_asked_a_call_ends_within_its_work_in_a_result_or_a_clear_fault() {
    let mut wrong = String::new();
    for case in CASES {
        let Case { scene, settings, step, fault } = case;
        // What is far too much is so for a tenth of the budget, too, which takes a tenth of the time.
        let budget = if [TOO_MUCH, SEARCH].contains(fault) { 0.1 * BUDGET } else { BUDGET };
        let _limited = drawn::limit(budget);
        let outcome = case.run(budget);
        let good = match &outcome {
            Ok(()) => fault.is_empty(),
            Err(said) => !fault.is_empty() && said.contains(fault),
        };
        if !good {
            wrong += &format!("{scene} {settings:?}, {step:e} s: {outcome:?}\n");
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// Through the C interface, since a step that goes on like the one before it takes a short cut there.
#[test]
fn no_step_leads_to_where_the_angle_of_a_drive_says_nothing() {
    for name in scenes() {
        let inputs = inputs(&drive(&name));
        let mut host = Host::instantiate(&resource(&name)).unwrap();
        host.set_up(0.0, None, None).unwrap();
        host.enter_initialization().unwrap();
        host.exit_initialization().unwrap();
        let mut time = 0.0;
        for step in [1e-4, 1e-4, 1e30] {
            if let [(0, _), (1, _), (2, _)] = inputs[..] {
                host.set_reals(&[0, 1, 2], &[100.0 * time, 100.0, 0.0]).unwrap();
            }
            let outcome = host.do_step(time, step);
            let said = outcome.err().map_or(String::new(), |fault| fault.to_string());
            assert!(if step < 1.0 { said.is_empty() } else { said.contains(ANGLE) }, "{name}, {step} s: {said}");
            time += step;
        }
    }
}

#[test]
fn the_largest_numbers_as_inputs_end_in_numbers_or_in_a_clear_fault() {
    let budget = 0.1 * BUDGET;
    let _limited = drawn::limit(budget);
    for name in scenes() {
        for (input, what) in inputs(&drive(&name)) {
            for value in [1e12, 1e300, f64::MAX].into_iter().flat_map(|size| [size, -size]) {
                for step in [1e-9, 1.0] {
                    drawn::since_last();
                    let mut drive = drive(&name);
                    let mut run = || {
                        drive.set(input as usize, value)?;
                        drive.start()?;
                        drive.advance(0.0, step)?;
                        (0..drive.descriptions().len()).try_for_each(|reference| drive.get(reference).map(|_| ()))
                    };
                    let said = run().err().map_or(String::new(), |fault| fault.to_string());
                    let case = format!("{name}, {what} = {value:e}, {step} s: {said}");
                    assert!(said.is_empty() || CLEAR.iter().any(|part| said.contains(part)), "{case}");
                    let references = 0..drive.descriptions().len();
                    let mut values = references.map(|reference| drive.get(reference).unwrap_or(0.0));
                    assert!(!said.is_empty() || values.all(f64::is_finite), "{case}");
                    assert!(drawn::since_last() <= 3.0 * budget, "{case}");
                }
            }
        }
    }
}

#[test]
fn a_derivative_before_the_start_bounds_all_of_its_trial_starts_together() {
    let budget = 0.02 * BUDGET;
    let _limited = drawn::limit(budget);
    for (scene, unknown, known) in [("parametric_wide", "growth", "c.a[3]"), ("machine_wide", "a", "follower[1].m")] {
        let mut drive = drive(scene);
        let names: Vec<String> = drive.descriptions().iter().map(|d| d.name.clone()).collect();
        let [unknown, known] = [unknown, known].map(|name| names.iter().position(|own| own == name).unwrap());
        drawn::since_last();
        let said = drive.directional_derivatives(&[unknown], &[(known, 1.0)]).unwrap_err().to_string();
        assert!(said.contains("before the start needs more work than one call may take"), "{scene}: {said}");
        assert!(drawn::since_last() <= 3.0 * budget, "{scene}");
    }
}
