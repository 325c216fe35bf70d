//! Loads of other units on a machine, and what drives tell of the inertia that follows their shaft: a load in two halves, in any
//! order, or as one is the same load; saved and mirrored machines go on alike; tau is what inertia and rest make of it.

use super::run::Run;
use super::scenes::{CamScene, MachineScene, Start, backlash, machine, output};
use super::{MACHINE_STATE, admitted, agree, config, even, machine_states, restoring_on_inputs, trace};
use camdrive::drives::Fault;
use camdrive::drives::follower::load::Load;
use camdrive_cli::scene;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::path::Path;

/// Communication steps of a run.
const STEPS: u32 = 60;

/// A load with the inertia k (1 + ½ cos 2(φ − `at`)) (kg·m²) and the rest r₀ + r₁ sin φ (N·m), which turns with its machine.
#[derive(Clone, Debug)]
struct Rigid {
    k: f64,
    at: f64,
    rest: [f64; 2],
    sense: f64,
}

/// The parts of it that a machine has under these names.
type Parts<'a> = [(&'a str, f64)];

impl Rigid {
    /// Tells the machine where it is.
    fn tell(&self, run: &mut Run, parts: &Parts<'_>) -> Result<(), Fault> {
        let [phi, w] = run.all(MACHINE_STATE).map(|value| self.sense * value);
        let ((sin, cos), (sin1, cos1)) = ((2.0 * (phi - self.at)).sin_cos(), phi.sin_cos());
        for (name, share) in parts {
            let name = |input: &str| if name.is_empty() { input.to_owned() } else { format!("{name}.{input}") };
            let (k, rest) = (share * self.k, self.rest.map(|torque| share * torque));
            run.set(&[
                (&name("J_load"), k * (1.0 + 0.5 * cos)),
                (&name("dJ_load"), -self.sense * k * sin),
                (&name("tau_rest"), self.sense * (rest[0] + rest[1] * sin1)),
            ])?;
            // The sense turns about with the speed and with the derivative.
            run.set_derivative(&name("dJ_load"), -2.0 * self.sense * k * cos * w)?;
            run.set_derivative(&name("tau_rest"), self.sense * rest[1] * cos1 * w)?;
        }
        Ok(())
    }

    fn mirrored(&self) -> Self {
        Rigid { sense: -self.sense, ..self.clone() }
    }
}

fn with_loads(scene: &MachineScene, names: &[&str], inertia: bool) -> (&'static str, Value) {
    let (model, mut resolved) = scene.resolved();
    let named = names.iter().map(|name| json!({"name": name, "inertia": inertia}));
    resolved["loads"] = named.collect();
    (model, resolved)
}

/// The machine at its start with these parts of a load.
fn begun(scene: &MachineScene, parts: &Parts<'_>) -> Result<Run, Fault> {
    let names: Vec<&str> = parts.iter().map(|(name, _)| *name).collect();
    let others: Vec<_> = scene.inputs().into_iter().filter(|(name, _)| *name != "tau").collect();
    Run::new(with_loads(scene, &names, true), &others)
}

/// φ and φ̇ after the span, and the largest of each on the way.
fn states(scene: &MachineScene, load: &Rigid, parts: &Parts<'_>) -> Result<(Vec<f64>, Vec<f64>), Fault> {
    let mut run = begun(scene, parts)?;
    let mut largest = vec![0.0; MACHINE_STATE.len()];
    for i in 1..=STEPS {
        load.tell(&mut run, parts)?;
        run.to(scene.span * f64::from(i) / f64::from(STEPS))?;
        largest.iter_mut().zip(run.all(MACHINE_STATE)).for_each(|(l, value): (&mut f64, f64)| *l = l.max(value.abs()));
    }
    Ok((run.all(MACHINE_STATE).to_vec(), largest))
}

fn parts_of_a_load(scene: &MachineScene, load: &Rigid, share: f64) -> Result<(), TestCaseError> {
    let (expected, largest) = admitted(states(scene, load, &[("", 1.0)]))?;
    let perturbed = admitted(states(&scene.perturbed(), load, &[("", 1.0)]))?.0;
    let some: [&Parts<'_>; 3] =
        [&[("a", 0.5), ("b", 0.5)], &[("b", 1.0 - share), ("a", share)], &[("a", share), ("b", 1.0 - share)]];
    for parts in some {
        agree(&admitted(states(scene, load, parts))?.0, &expected, &largest, &perturbed)?;
    }
    let turned = admitted(states(&scene.reversed(), &load.mirrored(), &[("", 1.0)]))?.0;
    agree(&turned.iter().map(|value| -value).collect::<Vec<_>>(), &expected, &largest, &perturbed)
}

fn restored(scene: &MachineScene, load: &Rigid, shares: &[f64]) -> Result<(), TestCaseError> {
    let parts: &Parts<'_> = &[("a", 0.4), ("b", 0.6)];
    let run = || admitted(begun(scene, parts));
    restoring_on_inputs(run()?, run()?, scene.span, shares, |run| load.tell(run, parts))
}

/// Torques of several loads are their sum, at a start on the periodic motion, too.
fn sum_of_torques(scene: &MachineScene, share: f64) -> Result<(), TestCaseError> {
    let (expected, largest) = admitted(machine_states(scene, &even()))?;
    let perturbed = admitted(machine_states(&scene.perturbed(), &even()))?.0;
    let mut inputs: Vec<_> = scene.inputs().into_iter().filter(|(name, _)| *name != "tau").collect();
    inputs.extend([("a.tau", share * scene.load), ("b.tau", (1.0 - share) * scene.load)]);
    let run = admitted(Run::new(with_loads(scene, &["a", "b"], false), &inputs))?;
    agree(&admitted(trace(run, &MACHINE_STATE, scene.span, &even()))?.0, &expected, &largest, &perturbed)
}

/// A load whose inertia is some part of that of the machine.
fn rigid() -> impl Strategy<Value = [f64; 4]> {
    [0.0..2.0_f64, -3.0..3.0_f64, -0.3..0.3_f64, -0.3..0.3_f64]
}

fn load_on(scene: &MachineScene, [k, at, constant, wave]: [f64; 4]) -> Rigid {
    let torque = scene.j0 * scene.w_start * scene.w_start;
    Rigid { k: k * scene.j0, at, rest: [constant * torque, wave * torque], sense: 1.0 }
}

proptest! {
    #![proptest_config(config(60, 40, 41))]

    #[test]
    fn a_load_is_the_sum_of_its_parts(scene in machine(), rigid in rigid(), share in -0.5..1.5_f64) {
        let scene = MachineScene { start: Start::Given, ..scene };
        parts_of_a_load(&scene, &load_on(&scene, rigid), share)?;
    }

    #[test]
    fn restored_under_loads(scene in machine(), rigid in rigid(), shares in super::splits()) {
        // A quadratic of the angle is one for short steps.
        let scene = MachineScene { start: Start::Given, span: scene.span / 20.0, ..scene };
        restored(&scene, &load_on(&scene, rigid), &shares)?;
    }

    #[test]
    fn torques_add_up(scene in machine(), share in -1.0..2.0_f64) { sum_of_torques(&scene, share)?; }
}

/// At every communication point tau is what J_load, dJ_load and tau_rest make of the inputs; dJ_load is the derivative of J_load, and
/// neither depends on the acceleration.
fn told_apart(mut run: Run, taus: &[String], [w, a]: [f64; 2], h: f64) -> Result<(), TestCaseError> {
    let reference = |run: &Run, name: &str| run.drive.descriptions().iter().position(|d| d.name == name).unwrap();
    let [of_j, of_rest, of_a] = ["J_load", "tau_rest", "a"].map(|name| reference(&run, name));
    for i in 0..12 {
        let t = f64::from(i) * h;
        let [phi, w] = [(w + 0.5 * a * t) * t, w + a * t];
        admitted(run.set(&[("phi", phi), ("w", w), ("a", a)]))?;
        let [j, slope, rest] = run.all(["J_load", "dJ_load", "tau_rest"]);
        let tau: f64 = taus.iter().map(|name| run.get(name)).sum();
        let [inertia, bend] = [j * a, 0.5 * slope * w * w];
        let size = inertia.abs() + bend.abs() + rest.abs() + tau.abs();
        prop_assert!((tau - (inertia + bend + rest)).abs() <= 1e-12 * size, "{tau} is not {}", inertia + bend + rest);
        let along = admitted(run.drive.directional_derivatives(&[of_j, of_rest], &[(of_a, 1.0)]))?;
        prop_assert_eq!(along, vec![0.0, 0.0]);
        let rate = admitted(run.drive.output_derivative(of_j, 1))?;
        prop_assert!((rate - slope * w).abs() <= 1e-12 * (rate.abs() + (slope * w).abs()), "{rate} {}", slope * w);
        admitted(run.to(t + h))?;
    }
    Ok(())
}

fn coupled(scene: &CamScene, roller: Option<f64>) -> (&'static str, Value) {
    let (model, mut resolved) = scene.resolved();
    (resolved["drive"], resolved["coupling"]) = (json!("input"), json!(true));
    if let Some(share) = roller {
        let load = Load { gravity: Some(-9.81), damping: Some(0.1 * scene.b), ..Load::default() };
        resolved["roller"] = json!((share * scene.m, load));
    }
    (model, resolved)
}

proptest! {
    #![proptest_config(config(40, 20, 42))]

    #[test]
    fn an_elastic_output_tells_its_roller(scene in output(), share in 0.01..3.0_f64, change in -2.0..2.0_f64) {
        let run = admitted(Run::new(coupled(&scene, Some(share)), &[("w", scene.w)]))?;
        told_apart(run, &["tau".to_owned()], [scene.w, change * scene.w / scene.span], scene.span / 40.0)?;
    }

    #[test]
    fn a_backlash_tells_its_mass_in_contact(scene in backlash(), change in -2.0..2.0_f64) {
        let run = admitted(Run::new(coupled(&scene, None), &[("w", scene.w)]))?;
        told_apart(run, &["tau".to_owned()], [scene.w, change * scene.w / scene.span], scene.span / 40.0)?;
    }

    #[test]
    fn a_train_tells_its_rigid_parts(w in -30.0..30.0_f64, a in -100.0..100.0_f64, h in 1e-4..3e-2_f64) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fmpy/scenes/train_coupling.toml");
        let scene = scene::read(&path).expect("a scene").resource().scene;
        let json = serde_json::to_value(&scene).expect("a scene");
        let run = admitted(Run::new(("DriveTrain", json["DriveTrain"].clone()), &[("w", w)]))?;
        let taus: Vec<String> = (1..=4).map(|j| format!("follower[{j}].tau")).collect();
        told_apart(run, &taus, [w, a], h)?;
    }
}
