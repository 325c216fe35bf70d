//! Physics of the parametric drive.

mod estimate;
mod interface;
mod loads;
mod tongues;

use super::*;
use crate::drives::follower::parametric::crank::{ParallelCrank, SecondCrank};
use crate::drives::follower::parametric::law::{Coordinate, CrankLaw, SeriesLaw};
use crate::drives::shaft::cam_drive::{AngleMotion, StartMode};
use crate::drives::solver::oscillation::Moving;
use crate::drives::variable::Variable;
use crate::motion::Fourier;
use crate::numerics::collocation::{Collocation, System};
use crate::numerics::double_double::Double;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn constant(value: f64) -> Fourier {
    Fourier::new(vec![value], Vec::new())
}

/// From q = 1 or 0.01, at constant speed.
fn scene(law: Law, w: f64) -> Scene {
    let q = if law.is_relative() { 0.01 } else { 1.0 };
    Scene {
        law,
        load: Load::default(),
        drive: DriveMode::Constant { w, phi_start: 0.3 },
        start: Start { mode: StartMode::Given, q, q_dot: 0.0 },
        solver: Settings::default(),
    }
}

/// m q̈ + 2 θ ω₀ q̇ + ω₀² (1 − ε cos φ) q = 0, m = 1 and ω₀ = 1.
fn mathieu(epsilon: f64, theta: f64) -> Law {
    Law::Series(SeriesLaw {
        coordinate: Coordinate::Translation,
        m: constant(1.0),
        b: constant(2.0 * theta),
        c: Fourier::new(vec![1.0, -epsilon], Vec::new()),
        f: None,
    })
}

/// Everything varies.
fn general() -> SeriesLaw {
    SeriesLaw {
        coordinate: Coordinate::Rotation,
        m: Fourier::new(vec![2.0, 0.3, -0.4], vec![0.0, 0.2]),
        b: Fourier::new(vec![0.3, 0.05], vec![0.0, 0.0, -0.1]),
        c: Fourier::new(vec![40.0, 5.0, 0.0, 8.0], vec![0.0, -6.0]),
        f: Some(Fourier::new(vec![1.0, 0.0, 3.0], vec![0.0, 2.0])),
    }
}

/// The crank with σ = `sigma`, J = 1 and a mean stiffness of 1, so that ω₀ = 1.
fn crank(sigma: f64, theta: f64, second: SecondCrank) -> CrankLaw {
    let unscaled = ParallelCrank { c_t1: 2.0, c_t2: 2.0, c_ab: 1.0 / sigma, r: 1.0, second };
    let mean = coefficients::Stiffness::of_crank(&unscaled).mean();
    let crank = ParallelCrank { c_t1: 2.0 / mean, c_t2: 2.0 / mean, c_ab: 1.0 / (sigma * mean), ..unscaled };
    CrankLaw { crank, inertia: 1.0, damping: 2.0 * theta, load: None, harmonics: None }
}

/// Shafts of 3 and 6 MN·m/rad, cranks of 0.3 m, a load with a second harmonic.
fn locomotive() -> CrankLaw {
    CrankLaw {
        crank: ParallelCrank { c_t1: 3.0e6, c_t2: 6.0e6, c_ab: 5e7, r: 0.3, second: SecondCrank::None },
        inertia: 300.0,
        damping: 2000.0,
        load: Some(Fourier::new(vec![-5e3, 0.0, 1e3], Vec::new())),
        harmonics: None,
    }
}

fn started(scene: Scene) -> ParametricDrive {
    let mut drive = ParametricDrive::new(scene).unwrap();
    drive.start(0.0).unwrap();
    drive
}

/// Runs to `end` in `steps` equal communication steps; the states.
fn run(drive: &mut ParametricDrive, end: f64, steps: usize) -> Result<Vec<[f64; 2]>, Fault> {
    (0..steps)
        .map(|n| {
            let time = end * n as f64 / steps as f64;
            drive.advance(time, end * (n + 1) as f64 / steps as f64 - time)?;
            Ok(drive.state)
        })
        .collect()
}

/// The same from an integrator at the finest tolerance without a table.
fn truth(scene: &Scene, end: f64, steps: usize) -> Option<Vec<[f64; 2]>> {
    let DriveMode::Constant { w, phi_start } = scene.drive else { unreachable!("a constant speed") };
    let (vibration, motion, mut segment) =
        (Vibration::of(&scene.law, None), AngleMotion::uniform(0.0, phi_start, w), [0; 2]);
    let moving = Moving::new(&vibration, &scene.law, &motion, &mut segment);
    let mut integrator = Collocation::new(Double::default(), [scene.start.q, scene.start.q_dot]);
    let mut states = Vec::new();
    for n in 1..=steps {
        integrator.advance(&moving, Double::from(end * n as f64 / steps as f64), 1e-14).ok()?;
        states.push(integrator.state());
    }
    Some(states)
}

/// The largest error relative to the largest motion so far.
fn worst(scene: &Scene, got: &[[f64; 2]], truth: &[[f64; 2]]) -> f64 {
    let mut scale = [scene.start.q.abs(), scene.start.q_dot.abs()];
    let mut error = 0.0f64;
    for (got, truth) in got.iter().zip(truth) {
        for i in 0..2 {
            scale[i] = scale[i].max(truth[i].abs());
            if scale[i] > 0.0 {
                error = error.max((got[i] - truth[i]).abs() / scale[i]);
            }
        }
    }
    error
}

#[test]
fn a_hundred_turns_inside_and_outside_of_the_tongues() {
    let crank = |sigma, second| Law::Crank(crank(sigma, 0.0, second));
    for (law, w) in [
        (mathieu(0.3, 0.0), 2.0),
        (mathieu(0.3, 0.0), 1.84756),
        (mathieu(0.3, 0.0), 1.7),
        (mathieu(0.3, 0.02), -2.0),
        (mathieu(1.5, 0.0), 0.9),
        (Law::Series(general()), 5.0),
        (Law::Series(general()), 8.9),
        (crank(0.1, SecondCrank::None), 1.0),
        (crank(0.1, SecondCrank::None), 0.7),
        (crank(1e-4, SecondCrank::None), 1.02),
        (crank(0.1, SecondCrank::OwnShafts(FRAC_PI_2)), 0.5),
        (crank(0.1, SecondCrank::OwnShafts(1.0)), 0.9),
        (crank(0.1, SecondCrank::SharedShafts(1.0)), 1.0),
        (Law::Crank(locomotive()), 40.0),
    ] {
        let scene = scene(law, w);
        let end = 100.0 * TAU / w.abs();
        for steps in [3, 1700] {
            let mut drive = started(scene.clone());
            assert!(drive.trajectory.is_some());
            let got = run(&mut drive, end, steps).unwrap();
            let error = worst(&scene, &got, &truth(&scene, end, steps).unwrap());
            assert!(error < 1e-9, "{:?} at {w}, {steps} steps: {error:e}", scene.law);
            assert!(error < drive.solver.error_estimate, "{error:e} {:e}", drive.solver.error_estimate);
        }
    }
}

#[test]
fn narrow_dips_and_a_mass_that_nearly_vanishes() {
    // The dips are 1e-3 and 1e-6 rad wide; m falls to 1e-3 and 1e-6 of its mean.
    let light =
        |part: f64| Law::Series(SeriesLaw { m: Fourier::new(vec![2.0, 2.0 * (1.0 - part)], Vec::new()), ..general() });
    for (law, w) in [
        (Law::Crank(crank(1e-6, 0.0, SecondCrank::None)), 0.9),
        (Law::Crank(crank(1e-12, 0.01, SecondCrank::None)), 0.3),
        (light(1e-3), 5.0),
        (light(1e-6), 5.0),
    ] {
        let scene = scene(law, w);
        let end = 10.0 * TAU / w;
        let mut drive = started(scene.clone());
        let got = run(&mut drive, end, 700).unwrap();
        let error = worst(&scene, &got, &truth(&scene, end, 700).unwrap());
        assert!(error < 1e-9, "{:?}: {error:e}", scene.law);
    }
}

#[test]
fn growth_until_overflow_ends_in_a_clear_fault() {
    // ln 1e100 = 230 at π ε/2 = 0.47 a turn.
    let mut drive = started(scene(mathieu(0.3, 0.0), 2.0));
    let turn = PI;
    let growth = drive.growth;
    assert!((growth / (PI * 0.3 / 4.0) - 1.0).abs() < 0.05, "{growth}");
    for steps in [1, 100_000] {
        drive.start(0.0).unwrap();
        let text = run(&mut drive, 1e5 * turn, steps).unwrap_err().to_string();
        assert!(text.contains("q grows without bound") && text.contains("parametrically unstable"), "{text}");
        let time: f64 = text.split("t = ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!((time / turn - 230.3 / growth).abs() < 20.0, "{text}");
    }
}

/// q̈ + q = cos φ without damping: q = cos φ/(1 − ω²), which neither attracts nor repels; none where ω = 1.
#[test]
fn an_undamped_drive_has_a_periodic_motion_away_from_resonance() {
    for w in [0.3, 1.5, -2.0, 1.0] {
        let mut law = mathieu(0.0, 0.0);
        if let Law::Series(law) = &mut law {
            law.f = Some(Fourier::new(vec![0.0, 1.0], Vec::new()));
        }
        let mut drive = ParametricDrive::new(scene(law, w)).unwrap();
        if w == 1.0 {
            let message = drive.periodic_motion().map(drop).unwrap_err().to_string();
            assert!(message.contains("a Floquet multiplier is 1"), "{message}");
            continue;
        }
        let found = drive.periodic_motion().unwrap();
        let expected = [0.3_f64.cos() / (1.0 - w * w), -w * 0.3_f64.sin() / (1.0 - w * w)];
        assert!(found.growth.abs() < 1e-12);
        for i in 0..2 {
            assert!((found.state[i] - expected[i]).abs() < 1e-10, "{w}: {:?} {expected:?}", found.state);
        }
    }
}

#[test]
fn the_steady_state_is_periodic_and_refused_where_there_is_none() {
    for law in [Law::Series(general()), Law::Crank(locomotive())] {
        for w in [5.0, -3.5] {
            let mut scene = scene(law.clone(), w);
            scene.start.mode = StartMode::SteadyState;
            let mut drive = started(scene);
            let first = drive.state;
            let turn = TAU / w.abs();
            for n in 1..=10 {
                drive.advance(turn * f64::from(n - 1), turn).unwrap();
                for i in 0..2 {
                    let scale = first[0].abs().max(first[1].abs());
                    assert!((drive.state[i] - first[i]).abs() < 1e-11 * scale, "{w} {n}: {:?} {first:?}", drive.state);
                }
            }
        }
    }
    let refusal = |law: Law, w: f64| {
        let mut scene = scene(law, w);
        scene.start.mode = StartMode::SteadyState;
        ParametricDrive::new(scene).unwrap().start(0.0).unwrap_err().to_string()
    };
    assert!(refusal(mathieu(0.3, 0.02), 2.0).contains("is unstable, free vibrations grow by exp(0."));
    assert!(refusal(mathieu(0.3, 0.0), 0.0).contains("drive.w = 0 rad/s: with a stiffness of 0.71"));
    // At rest the load is in equilibrium with the spring.
    let mut at_rest = scene(Law::Series(general()), 0.0);
    at_rest.start.mode = StartMode::SteadyState;
    let mut drive = started(at_rest);
    let [_, _, c, f] = {
        let v = drive.equation.coefficients.at(0.3);
        [v.m[0], v.b[0], v.c[0], v.f[0]]
    };
    assert_eq!(drive.state, [f / c, 0.0]);
    drive.advance(0.0, 10.0).unwrap();
    assert!((drive.state[0] - f / c).abs() < 1e-12 && drive.growth == 0.0);
}

/// ∫ of `power` over [0, end] by Simpson's rule.
fn work(drive: &mut ParametricDrive, end: f64, steps: usize, power: impl Fn(&ParametricDrive) -> f64) -> f64 {
    let h = end / steps as f64;
    let mut sum = power(drive);
    for n in 1..=steps {
        drive.advance(h * (n - 1) as f64, h).unwrap();
        let weight = if n == steps {
            1.0
        } else if n % 2 == 1 {
            4.0
        } else {
            2.0
        };
        sum += weight * power(drive);
    }
    sum * h / 3.0
}

/// The value of an output.
fn output(drive: &ParametricDrive, name: &str) -> f64 {
    named(&drive.variables(), name).value(drive)
}

fn named<'a>(list: &'a List<ParametricDrive>, name: &str) -> &'a Variable<ParametricDrive> {
    &list.0[list.reference(name).unwrap_or_else(|| panic!("no `{name}`"))]
}

#[test]
fn the_energy_balances_close() {
    // ½ m q̇² + ½ c q² gains the work of f and of the varying coefficients and loses the work of b.
    let mut drive = started(scene(Law::Series(general()), 5.0));
    let values = |d: &ParametricDrive| d.equation.coefficients.at(d.motion.at(d.time).reduced);
    let energy = |d: &ParametricDrive| {
        let (v, [q, v_q]) = (values(d), d.state);
        0.5 * (v.m[0] * v_q * v_q + v.c[0] * q * q)
    };
    let before = energy(&drive);
    let list = drive.variables();
    let parametric = named(&list, "tau_parametric");
    let given = work(&mut drive, 3.0, 6000, |d| {
        let (v, rate) = (values(d), d.state[1]);
        v.f[0] * rate - v.b[0] * rate * rate + 5.0 * parametric.value(d)
    });
    assert!((energy(&drive) - before - given).abs() < 1e-9 * before, "{:e}", energy(&drive) - before - given);
    // For the crank the whole energy ½ J ψ̇² + ½ c q² comes from the drive and the load.
    let w = 40.0;
    let mut drive = started(scene(Law::Crank(locomotive()), w));
    let energy = |d: &ParametricDrive| {
        let (v, [q, rate]) = (values(d), d.state);
        0.5 * (v.m[0] * (w + rate).powi(2) + v.c[0] * q * q)
    };
    let before = energy(&drive);
    let list = drive.variables();
    let [tau, parametric] = ["tau", "tau_parametric"].map(|name| named(&list, name));
    let given = work(&mut drive, 1.0, 40_000, |d| {
        let (v, rate) = (values(d), d.state[1]);
        (tau.value(d) + parametric.value(d)) * w - v.b[0] * rate * rate + v.f[0] * (w + rate)
    });
    assert!((energy(&drive) - before - given).abs() < 1e-9 * before, "{:e}", energy(&drive) - before - given);
}

#[test]
fn a_harmonic_oscillation_in_disguise() {
    // From q = p z with z̈ + ω₀² z = 0: p q̈ − 2 ṗ q̇ + (ω₀² p − p̈ + 2 ṗ²/p) q = 0; times p it has finite series.
    let (w0, w, e) = (3.0, 1.7, 0.5);
    // p = 1 + e cos φ: p², −2 p ṗ = 2 w e sin φ p, ω₀² p² − p p̈ + 2 ṗ².
    let square = vec![1.0 + 0.5 * e * e, 2.0 * e, 0.5 * e * e];
    let m = Fourier::new(square.clone(), Vec::new());
    let b = Fourier::new(vec![0.0], vec![0.0, 2.0 * w * e, w * e * e]);
    // −p p̈ = w² (e cos φ + e² cos²φ), 2 ṗ² = 2 w² e² sin²φ.
    let c = Fourier::new(
        vec![
            w0 * w0 * square[0] + w * w * e * e * 1.5,
            w0 * w0 * square[1] + w * w * e,
            w0 * w0 * square[2] - 0.5 * w * w * e * e,
        ],
        Vec::new(),
    );
    let law = Law::Series(SeriesLaw { coordinate: Coordinate::Rotation, m, b, c, f: None });
    let mut scene = scene(law, w);
    scene.drive = DriveMode::Constant { w, phi_start: 0.0 };
    let mut drive = started(scene);
    // z(0) = 1/p(0), ż(0) = 0 since ṗ(0) = 0.
    for n in 1..=400 {
        let t = 0.37 * f64::from(n);
        drive.advance(t - 0.37, 0.37).unwrap();
        let p = 1.0 + e * (w * t).cos();
        let exact = p / (1.0 + e) * (w0 * t).cos();
        assert!((drive.state[0] - exact).abs() < 1e-11, "{t}: {} {exact}", drive.state[0]);
    }
    assert!(drive.growth.abs() < 1e-12, "{}", drive.growth);
}

#[test]
fn the_truth_satisfies_the_equation() {
    // The reference of these tests is the equation itself: its right-hand side by the coefficients as the source prints them.
    let law = Law::Crank(locomotive());
    let (vibration, motion, mut segment) = (Vibration::of(&law, None), AngleMotion::uniform(0.0, 0.3, 40.0), [0; 2]);
    let moving = Moving::new(&vibration, &law, &motion, &mut segment);
    let (q, v, t) = (0.01, -0.3, 0.02);
    let phi: f64 = 0.3 + 40.0 * t;
    let spring = 1.0 / (1.0 / 3.0e6 + 1.0 / 6.0e6 + 1.0 / (5e7 * (0.3 * phi.sin()).powi(2)));
    let load = -5e3 + 1e3 * (2.0 * phi).cos();
    let expected = (load - 2000.0 * v - spring * q) / 300.0;
    let [_, got] = moving.rhs(Double::from(t), &[q, v]);
    assert!((got / expected - 1.0).abs() < 1e-13, "{got} {expected}");
    let [[_, one], [by_q, by_v]] = moving.jacobian(Double::from(t), &[q, v]);
    assert!(one == 1.0 && (by_q * 300.0 / spring + 1.0).abs() < 1e-13 && (by_v * 300.0 + 2000.0).abs() < 1e-9);
}
