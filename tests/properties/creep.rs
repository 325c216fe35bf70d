//! A drive whose speed is so small that a turn takes longer than numbers can tell is a drive at rest.

use super::run::Run;
use super::scenes::{CamScene, MachineScene, Model, Start, Torque};
use camdrive::drives::Fault;
use camdrive::drives::rigid_machine::Follower;
use camdrive::motion::{Cycle, CyclePlan, Fourier, MotionLaw, StandardLaw};
use serde_json::{Value, json};
use std::sync::mpsc;
use std::time::Duration;

/// Around 2π/w, w and w² being numbers or not (rad/s).
const SPEEDS: [f64; 4] = [5e-324, 1e-308, -1e-200, 1e-150];

/// None of these drives needs more than some milliseconds.
const LONG: Duration = Duration::from_secs(20);

fn laws() -> [MotionLaw; 2] {
    let cycle = CyclePlan {
        stroke: 0.01,
        lower: 0.0,
        rise_start: 0.2,
        rise_angle: 2.0,
        upper_dwell: 1.1,
        return_angle: 2.0,
        rise_law: StandardLaw::InclinedSine,
        return_law: StandardLaw::ModifiedTrapezoid,
        inflections: [None; 2],
    };
    [MotionLaw::Fourier(Fourier::new(vec![0.0, 0.01, 0.002], vec![0.0, 0.003])), MotionLaw::Cycle(Cycle::new(cycle))]
}

/// Every cam drive with every kind of coefficients, at the speed `w`.
fn cam_drives(w: f64) -> Vec<(&'static str, Value)> {
    let models = [(Model::Output, 0.0), (Model::LinearShaft, 1.5), (Model::Shaft, 1.5), (Model::Backlash, 8.0)];
    let mut list = Vec::new();
    for law in laws() {
        for (model, second) in models {
            let (m, c, b, s, e, span) = (2.0, 24e3, 17.0, 5e-5, 0.0, 1.0);
            let (start, law, phi_start, q, q_dot) = (Start::Given, law.clone(), 0.7, 1e-3, 0.01);
            list.push(CamScene { model, start, m, second, c, b, s, e, law, w, phi_start, q, q_dot, span }.resolved());
        }
    }
    let series = |a: &[f64]| Fourier::new(a.to_vec(), Vec::new());
    for b in [0.0, 0.1] {
        let (m, b, c, f) = (series(&[1.0]), series(&[b]), series(&[1.0, -0.3]), series(&[0.1, 0.2]));
        let scene = json!({
            "law": {"series": {"coordinate": "translation", "m": m, "b": b, "c": c, "f": f}},
            "drive": {"constant": {"w": w, "phi_start": 0.7}},
            "start": {"mode": "given", "q": 1e-3, "q_dot": 0.01},
            "solver": super::scenes::solver(),
        });
        list.push(("ParametricDrive", scene));
    }
    list
}

/// What `work` yields, unless it takes longer than it may.
fn in_time<R: Send + 'static>(what: &str, work: impl FnOnce() -> R + Send + 'static) -> R {
    let (send, receive) = mpsc::channel();
    std::thread::spawn(move || send.send(work()));
    receive.recv_timeout(LONG).unwrap_or_else(|error| panic!("{what}: {error}"))
}

/// q, q̇ after a step that is as short as the speed is small, and one of a second.
fn end(scene: (&str, Value), inputs: &[(&str, f64)], short: f64) -> Result<[f64; 2], Fault> {
    let mut run = Run::new(scene, inputs)?;
    let experiment = run.drive.experiment();
    assert!(experiment.stop.is_finite() && experiment.step.is_finite());
    run.to(short)?;
    run.set(inputs)?;
    run.to(1.0)?;
    Ok(run.all(["q", "der(q)"]))
}

fn agree(what: &str, [q, v]: [f64; 2], [rest, speed]: [f64; 2]) {
    let near = |x: f64, y: f64| (x - y).abs() <= 1e-9 * y.abs() + 1e-20;
    assert!(near(q, rest) && near(v, speed), "{what}: {q:e}, {v:e} instead of {rest:e}, {speed:e}");
}

#[test]
fn a_cam_that_creeps_is_at_rest() {
    for w in SPEEDS {
        for (creeping, resting) in cam_drives(w).into_iter().zip(cam_drives(0.0)) {
            let what = format!("{} at {w:e} rad/s", creeping.0);
            let [creeping, resting] = [creeping, resting].map(|scene| {
                in_time(&what, move || end(scene, &[], w.abs())).unwrap_or_else(|fault| panic!("{what}: {fault}"))
            });
            agree(&what, creeping, resting);
        }
    }
}

#[test]
fn a_cam_that_inputs_let_creep_is_at_rest() {
    for w in SPEEDS {
        for (creeping, resting) in cam_drives(w).into_iter().zip(cam_drives(0.0)) {
            let what = format!("{} on inputs of {w:e} rad/s", creeping.0);
            let on_inputs = |(model, mut scene): (&'static str, Value), w: f64| {
                scene["drive"] = json!("input");
                in_time(&what, move || end((model, scene), &[("phi", 0.7), ("w", w), ("a", w)], w.abs()))
                    .unwrap_or_else(|fault| panic!("{what}: {fault}"))
            };
            agree(&what, on_inputs(creeping, w), on_inputs(resting, 0.0));
        }
    }
}

#[test]
fn the_periodic_motion_of_a_cam_that_creeps_is_that_at_rest_or_refused() {
    for w in SPEEDS {
        for (creeping, resting) in cam_drives(w).into_iter().zip(cam_drives(0.0)) {
            let what = format!("{} at {w:e} rad/s", creeping.0);
            let [creeping, resting] = [creeping, resting].map(|(model, mut scene)| {
                scene["start"]["mode"] = json!("steady_state");
                in_time(&what, move || end((model, scene), &[], w.abs()))
            });
            match (creeping, resting) {
                (Ok(creeping), Ok(resting)) => agree(&what, creeping, resting),
                (Err(creeping), Err(resting)) => {
                    assert_eq!(creeping.to_string().replace(&format!("{w:e} rad/s"), "0 rad/s"), resting.to_string());
                }
                other => panic!("{what}: {other:?}"),
            }
        }
    }
}

#[test]
fn a_machine_may_creep_but_not_its_synchronous_field() {
    let machine = |torque, w_start| {
        let (start, varying, followers) = (Start::Given, None, vec![Follower::new(1.6, laws()[0].clone())]);
        let (load, torque_start, phi_start, span) = (0.0, 0.0, 0.7, 1.0);
        MachineScene { start, j0: 2.8, varying, followers, torque, torque_start, load, phi_start, w_start, span }
    };
    let end = |scene: MachineScene| {
        in_time("a machine", move || {
            let mut run = Run::new(scene.resolved(), &scene.inputs())?;
            run.to(1.0)?;
            Ok::<_, Fault>(run.all(["phi", "w"]))
        })
    };
    for w in SPEEDS {
        for torque in [Torque::None, Torque::Input(3.0), Torque::Kloss([220.0, 0.16, 50.0, 0.0])] {
            let [creeping, resting] = [w, 0.0].map(|w| end(machine(torque, w)).expect("a motion"));
            agree(&format!("a machine from {w:e} rad/s"), creeping, resting);
        }
        for lag in [0.0, 0.01] {
            let text = end(machine(Torque::Kloss([220.0, 0.16, w, lag]), 0.0)).expect_err("refused").to_string();
            assert!(text.contains("`motor.w_s`") && text.contains("1e-100 rad/s"), "{text}");
        }
    }
}
