//! What a cam drive owes on inputs that turn it with constant acceleration: one step or many are the same motion, so are
//! those of a slower and of a mirrored drive and that after a restored state, and without acceleration it is that of
//! constant speed. On its speed alone it is the same motion again, however the shaft is split into steps, saved, mirrored or
//! its angle counted.

use super::run::Run;
use super::scenes::{CamScene, Model, backlash, output, shaft, turned};
use super::{admitted, agree, config, even, mirror_of, names, restoring_on_inputs, splits, time_scaling_of};
use camdrive::drives::Fault;
use proptest::prelude::*;
use serde_json::{Value, json};

/// The inputs at `t`.
fn turning(scene: &CamScene, acceleration: f64, t: f64) -> [(&'static str, f64); 3] {
    let phi = scene.phi_start + (scene.w + acceleration * t / 2.0) * t;
    [("phi", phi), ("w", scene.w + acceleration * t), ("a", acceleration)]
}

fn resolved(scene: &CamScene) -> (&'static str, Value) {
    let (model, mut resolved) = scene.resolved();
    resolved["drive"] = json!("input");
    (model, resolved)
}

/// The states after the span, reached over `shares` of it, and the largest of each on the way. The inputs are wrong by
/// `roundings` of the angle, to this side and that.
fn moved(scene: &CamScene, acceleration: f64, shares: &[f64], roundings: f64) -> Result<(Vec<f64>, Vec<f64>), Fault> {
    let mut side = roundings * f64::EPSILON;
    let mut inputs = |t: f64| {
        side = -side;
        let [(name, phi), w, a] = turning(scene, acceleration, t);
        [(name, phi * (1.0 + side)), w, a]
    };
    let mut run = Run::new(resolved(scene), &inputs(0.0))?;
    let names = names(scene);
    let mut now: Vec<f64> = names.iter().map(|name| run.get(name)).collect();
    let mut largest: Vec<f64> = now.iter().map(|value| value.abs()).collect();
    for share in shares.iter().chain(&[1.0]) {
        run.set(&inputs(run.time))?;
        run.to(scene.span * share)?;
        now = names.iter().map(|name| run.get(name)).collect();
        for (l, value) in largest.iter_mut().zip(&now) {
            *l = l.max(value.abs());
        }
    }
    Ok((now, largest))
}

fn states(scene: &CamScene, acceleration: f64, shares: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Fault> {
    moved(scene, acceleration, shares, 0.0)
}

/// The motion of a drive that is a little stiffer and whose inputs are rounded otherwise.
fn perturbed(scene: &CamScene, acceleration: f64) -> Result<Vec<f64>, TestCaseError> {
    admitted(moved(&scene.perturbed(), acceleration, &even(), 1.0)).map(|(end, _)| end)
}

/// The drive at its start on the input w alone; the flank on which a mass starts depends on the acceleration.
fn on_speed(scene: &CamScene, acceleration: f64) -> Result<Run, Fault> {
    let (model, mut resolved) = scene.resolved();
    resolved["drive"] = json!({"speed": {"phi_start": scene.phi_start}});
    Run::moving((model, resolved), &[("w", scene.w)], &[("w", acceleration)])
}

/// Sets w and its derivative for the step ahead.
fn set_speed(run: &mut Run, scene: &CamScene, acceleration: f64) -> Result<(), Fault> {
    run.set(&[("w", scene.w + acceleration * run.time)])?;
    run.set_derivative("w", acceleration)
}

/// [`states`] on the input w alone.
fn states_on_speed(scene: &CamScene, acceleration: f64, shares: &[f64]) -> Result<(Vec<f64>, Vec<f64>), Fault> {
    let mut run = on_speed(scene, acceleration)?;
    let of = |run: &mut Run| -> Vec<f64> { names(scene).iter().map(|name| run.get(name)).collect() };
    let mut largest: Vec<f64> = of(&mut run).iter().map(|value| value.abs()).collect();
    for share in shares.iter().chain(&[1.0]) {
        set_speed(&mut run, scene, acceleration)?;
        run.to(scene.span * share)?;
        largest.iter_mut().zip(of(&mut run)).for_each(|(l, value)| *l = l.max(value.abs()));
    }
    let [(_, phi), (_, w), _] = turning(scene, acceleration, run.time);
    // The shares are rounded, and with each step its way.
    let rounding = 1e-15 * (scene.phi_start.abs() + (scene.w.abs() + (acceleration * run.time).abs()) * run.time);
    let [angle, speed] = run.all(["phi", "der(phi)"]);
    assert!((angle - phi).abs() <= rounding * (shares.len() + 2) as f64, "phi = {angle}, right is {phi}");
    assert!((speed - w).abs() <= 1e-15 * (scene.w.abs() + 4.0 * (acceleration * run.time).abs()), "{speed} {w}");
    Ok((of(&mut run), largest))
}

fn on_speed_alone(scene: &CamScene, change: f64, shares: &[f64], angle: f64) -> Result<(), TestCaseError> {
    let acceleration = acceleration(scene, change);
    let (expected, largest) = admitted(states(scene, acceleration, &even()))?;
    let perturbed = perturbed(scene, acceleration)?;
    agree(&admitted(states_on_speed(scene, acceleration, shares))?.0, &expected, &largest, &perturbed)?;
    let moved = CamScene { law: turned(&scene.law, angle), phi_start: scene.phi_start + angle, ..scene.clone() };
    agree(&admitted(states_on_speed(&moved, acceleration, shares))?.0, &expected, &largest, &perturbed)?;
    mirror_of(scene, &|s, shares| states_on_speed(s, self::acceleration(s, change), shares), &perturbed)?;
    let run = || admitted(on_speed(scene, acceleration));
    restoring_on_inputs(run()?, run()?, scene.span, shares, |run| set_speed(run, scene, acceleration))
}

fn acceleration(scene: &CamScene, change: f64) -> f64 {
    change * scene.w / scene.span
}

/// The changed scenes turn by the same `change` of their own speed.
fn symmetries(scene: &CamScene, change: f64, factor: f64) -> Result<(), TestCaseError> {
    let perturbed = perturbed(scene, acceleration(scene, change))?;
    let states = |scene: &CamScene, shares: &[f64]| states(scene, acceleration(scene, change), shares);
    time_scaling_of(scene, factor, &states, &perturbed)?;
    mirror_of(scene, &states, &perturbed)
}

fn restored(scene: &CamScene, change: f64, shares: &[f64]) -> Result<(), TestCaseError> {
    let acceleration = acceleration(scene, change);
    let run = || admitted(Run::new(resolved(scene), &turning(scene, acceleration, 0.0)));
    let set = |run: &mut Run| run.set(&turning(scene, acceleration, run.time));
    restoring_on_inputs(run()?, run()?, scene.span, shares, set)
}

/// `change`: that of the speed over the span, relative to the speed; below −1 the drive turns back.
fn refinement(scene: &CamScene, change: f64, shares: &[f64]) -> Result<(), TestCaseError> {
    let acceleration = acceleration(scene, change);
    let (even, largest) = admitted(states(scene, acceleration, &even()))?;
    let perturbed = perturbed(scene, acceleration)?;
    agree(&admitted(states(scene, acceleration, &[]))?.0, &even, &largest, &perturbed)?;
    agree(&admitted(states(scene, acceleration, shares))?.0, &even, &largest, &perturbed)
}

fn constant_speed(scene: &CamScene, shares: &[f64]) -> Result<(), TestCaseError> {
    let (expected, largest) = admitted(super::states(scene, &even()))?;
    let perturbed = perturbed(scene, 0.0)?;
    agree(&admitted(states(scene, 0.0, shares))?.0, &expected, &largest, &perturbed)
}

macro_rules! of_cam_drives {
    ($($name:ident: $scene:expr, $cases:expr, $seed:expr;)*) => {$(
        mod $name {
            use super::*;

            proptest! {
                #![proptest_config(config($cases, $cases / 3, $seed))]

                #[test]
                fn one_step_or_many(scene in $scene, change in -3.0..3.0_f64, shares in splits()) {
                    refinement(&scene, change, &shares)?;
                }

                #[test]
                fn slower_and_mirrored(
                    scene in $scene, change in -3.0..3.0_f64, factor in (-3.0..3.0_f64).prop_map(f64::exp)
                ) {
                    symmetries(&scene, change, factor)?;
                }

                #[test]
                fn restored_at_any_instant(scene in $scene, change in -3.0..3.0_f64, shares in splits()) {
                    restored(&scene, change, &shares)?;
                }

                #[test]
                fn on_its_speed_alone(
                    scene in $scene, change in -3.0..3.0_f64, shares in splits(), angle in -7.0..7.0_f64
                ) {
                    on_speed_alone(&scene, change, &shares, angle)?;
                }

                #[test]
                fn without_acceleration(scene in $scene, shares in splits()) { constant_speed(&scene, &shares)?; }
            }
        }
    )*};
}

of_cam_drives! {
    elastic_output: output(), 60, 21;
    linear_shaft: shaft(Model::LinearShaft, 10.0), 30, 22;
    nonlinear_shaft: shaft(Model::Shaft, 10.0), 30, 23;
    backlash_drive: backlash(), 60, 24;
}
