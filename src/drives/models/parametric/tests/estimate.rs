//! The error estimate against the true error over random drives: at constant speed and on inputs, by tolerance and in
//! equal steps.

use super::*;
use crate::drives::elastic_shaft::tests::extremes::{Random, assert_honest};
use crate::drives::settings::Method;

/// A series whose harmonics have together at most the part `most` of its mean.
fn random_series(r: &mut Random, mean: f64, most: f64) -> Fourier {
    let order = (r.next() * 6.0) as usize;
    let mut coefficient = |k: usize| {
        let value = mean * most * r.between(-1.0, 1.0) / (k * k * 2) as f64;
        if r.next() < 0.3 { 0.0 } else { value }
    };
    let a = (0..=order).map(|k| if k == 0 { mean } else { coefficient(k) }).collect();
    let b = (0..=order).map(|k| if k == 0 { 0.0 } else { coefficient(k) }).collect();
    Fourier::new(a, b)
}

fn random_law(r: &mut Random) -> Law {
    let damping_ratio = if r.next() < 0.2 { 0.0 } else { r.scale(1e-3, 2.0) };
    let mean = r.scale(1e2, 1e6);
    let m = r.scale(0.1, 100.0);
    let load = if r.next() < 0.5 { Some(random_series(r, 0.1 * mean, 2.0)) } else { None };
    if r.next() < 0.5 {
        let second = match (r.next() * 4.0) as u32 {
            0 | 1 => SecondCrank::None,
            2 => SecondCrank::OwnShafts(r.between(-3.0, 3.0)),
            _ => SecondCrank::SharedShafts(r.between(-3.0, 3.0)),
        };
        let (sigma, radius) = (r.scale(1e-4, 1e2), r.scale(0.05, 1.0));
        let crank = ParallelCrank {
            c_t1: mean * r.scale(1.1, 10.0),
            c_t2: mean * r.scale(1.1, 10.0),
            c_ab: mean / (sigma * radius * radius),
            r: radius,
            second,
        };
        let mean = coefficients::Stiffness::of_crank(&crank).mean();
        let damping = 2.0 * damping_ratio * (m * mean).sqrt();
        return Law::Crank(CrankLaw { crank, inertia: m, damping, load, harmonics: None });
    }
    // The mass falls to a tenth of its mean at most, the stiffness may change its sign.
    Law::Series(SeriesLaw {
        coordinate: Coordinate::Translation,
        m: random_series(r, m, 0.4),
        b: random_series(r, 2.0 * damping_ratio * (m * mean).sqrt(), 1.0),
        c: random_series(r, mean, 1.0),
        f: load,
    })
}

/// A drive with between a third and 30 vibrations a turn, and the angle of its run, one to twenty turns.
pub(super) fn random_scene(r: &mut Random) -> (Scene, f64) {
    let law = random_law(r);
    let coefficients = law.coefficients();
    let frequency = (coefficients.c.mean() / coefficients.m.a[0]).sqrt();
    let w = frequency / r.scale(1.0 / 3.0, 30.0) * if r.next() < 0.3 { -1.0 } else { 1.0 };
    let scene = Scene {
        load: Load::default(),
        law,
        drive: DriveMode::Constant { w, phi_start: r.between(-10.0, 10.0) },
        start: Start { mode: StartMode::Given, q: r.between(-0.1, 0.1), q_dot: frequency * r.between(-0.1, 0.1) },
        solver: Settings { tolerance: r.scale(1e-12, 1e-5), ..Settings::default() },
    };
    (scene, r.scale(1.0, 20.0) * TAU / w.abs())
}

#[test]
fn at_constant_speed() {
    let r = &mut Random(41);
    let (mut ratios, mut of_default) = (Vec::new(), Vec::new());
    for i in 0..230 {
        let (mut scene, span) = random_scene(r);
        if i % 2 == 0 {
            scene.solver = Settings::default();
        }
        let mut drive = started(scene.clone());
        assert!(drive.trajectory.is_some());
        let (Ok(got), Some(truth)) = (run(&mut drive, span, 97), truth(&scene, span, 97)) else { continue };
        let error = worst(&scene, &got, &truth);
        // Below this the truth is not known either.
        let ratio = drive.solver.error_estimate / error.max(2e-15);
        if i % 2 == 0 { of_default.push(ratio) } else { ratios.push(ratio) }
    }
    assert_honest("constant speed, any tolerance", ratios, 100.0);
    assert_honest("constant speed, the default tolerance", of_default, 100.0);
}

/// Runs over `span` in communication steps on the inputs φ₀ + ω t + α t²/2; the states, and the drive.
fn on_inputs(scene: &Scene, ramp: [f64; 3], span: f64, steps: usize) -> Option<(Vec<[f64; 2]>, ParametricDrive)> {
    let mut drive = ParametricDrive::new(scene.clone()).unwrap();
    let variables = drive.variables().0;
    let set = |drive: &mut ParametricDrive, t: f64| {
        let [phi, w, a] = ramp;
        for (variable, value) in variables.iter().zip([phi + (w + 0.5 * a * t) * t, w + a * t, a]) {
            variable.set(drive, value);
        }
    };
    set(&mut drive, 0.0);
    drive.start(0.0).unwrap();
    let mut states = Vec::new();
    for n in 0..steps {
        let time = span * n as f64 / steps as f64;
        set(&mut drive, time);
        drive.advance(time, span * (n + 1) as f64 / steps as f64 - time).ok()?;
        states.push(drive.state);
    }
    Some((states, drive))
}

#[test]
fn on_ramped_inputs() {
    let r = &mut Random(42);
    let mut ratios = [Vec::new(), Vec::new()];
    for i in 0..240 {
        let (mut scene, _) = random_scene(r);
        let DriveMode::Constant { w, phi_start } = scene.drive else { unreachable!("a constant speed") };
        let span = r.scale(1.0, 6.0) * TAU / w.abs();
        let ramp = [phi_start, w, 0.5 * w / span * r.between(-1.0, 1.0)];
        let steps = r.scale(20.0, 100.0) as usize;
        scene.drive = DriveMode::Input;
        let finest = Scene { solver: Settings { tolerance: 1e-14, ..Settings::default() }, ..scene.clone() };
        if i % 2 == 1 {
            scene.solver = Settings { method: Method::FixedCost, ..Settings::default() };
        }
        let (Some((got, drive)), Some((truth, _))) =
            (on_inputs(&scene, ramp, span, steps), on_inputs(&finest, ramp, span, steps))
        else {
            continue;
        };
        // The inputs are rounded, and so is the truth.
        let error = worst(&scene, &got, &truth).max(5e-15);
        ratios[i % 2].push(drive.solver.error_estimate / error);
    }
    let [by_tolerance, equal_steps] = ratios;
    assert_honest("inputs, by tolerance", by_tolerance, 100.0);
    assert_honest("inputs, equal steps", equal_steps, 100.0);
}

#[test]
fn equal_steps_of_the_usual_length_are_good_to_a_millionth() {
    let r = &mut Random(43);
    let mut errors = Vec::new();
    for _ in 0..100 {
        let (mut scene, _) = random_scene(r);
        let DriveMode::Constant { w, phi_start } = scene.drive else { unreachable!("a constant speed") };
        scene.drive = DriveMode::Input;
        scene.solver = Settings { method: Method::FixedCost, ..Settings::default() };
        let (ramp, span) = ([phi_start, w, 0.0], 3.0 * TAU / w.abs());
        if let Some((_, drive)) = on_inputs(&scene, ramp, span, 50) {
            errors.push(drive.solver.error_estimate);
        }
    }
    errors.sort_by(f64::total_cmp);
    assert!(
        errors.len() >= 95 && errors[errors.len() * 9 / 10] < 1e-6,
        "{} {:e}",
        errors.len(),
        errors[errors.len() * 9 / 10]
    );
}
