//! Loads on the mass: against the drive whose coefficients were changed by hand, closed forms, and relations that hold for every
//! load.

use super::estimate::random_scene;
use super::*;
use crate::drives::elastic_shaft::tests::extremes::Random;
use crate::drives::follower::load::Spring;
use crate::motion::table::Points;
use crate::motion::{MotionLaw, Polyline};

fn sum(one: &Fourier, other: &Fourier) -> Fourier {
    let order = one.order().max(other.order());
    let add = |of: fn(&Fourier) -> &Vec<f64>| {
        let at = |series: &Fourier, k: usize| of(series).get(k).copied().unwrap_or(0.0);
        (0..=order).map(|k| at(one, k) + at(other, k)).collect()
    };
    Fourier::new(add(|series| &series.a), add(|series| &series.b))
}

/// The scene without loads, with the loads in its coefficients, at constant speed.
fn by_hand(scene: &Scene) -> Scene {
    let DriveMode::Constant { w, .. } = scene.drive else { unreachable!("a constant speed") };
    let Load { gravity, constant: force, spring, damping, process, .. } = scene.load.clone();
    let (Spring { preload, c: c_r, at }, b_r) = (spring.unwrap_or_default(), damping.unwrap_or(0.0));
    let process = process.map_or(constant(0.0), |process| process.series().unwrap().clone());
    let force = sum(&process, &constant(force.unwrap_or(0.0) - preload + c_r * at));
    let added =
        |f: &Option<Fourier>, more: f64| Some(sum(f.as_ref().unwrap_or(&constant(0.0)), &sum(&force, &constant(more))));
    let mut law = scene.law.clone();
    match &mut law {
        Law::Series(SeriesLaw { m, b, c, f, .. }) => {
            (*b, *c) = (sum(b, &constant(b_r)), sum(c, &constant(c_r)));
            *f = added(f, m.a[0] * gravity.unwrap_or(0.0));
        }
        Law::Crank(CrankLaw { damping, load, .. }) => {
            *damping += b_r;
            *load = added(load, -b_r * w);
        }
    }
    Scene { law, load: Load::default(), ..scene.clone() }
}

/// Any load that may act on this drive.
fn random_load(r: &mut Random, law: &Law) -> Load {
    let coefficients = law.coefficients();
    let (m, c) = (coefficients.m.a[0], coefficients.c.mean());
    let mut some = |value: f64| (r.next() < 0.7).then_some(value);
    let spring = some(0.4 * c).filter(|_| !law.is_relative()).map(|c| Spring { preload: 0.1 * c, c, at: 0.02 });
    Load {
        gravity: some(-9.81).filter(|_| !law.is_relative() && coefficients.m.order() == 0),
        constant: some(0.05 * c),
        damping: some(0.1 * (m * c).sqrt()),
        process: some(0.1 * c)
            .map(|f| MotionLaw::Fourier(Fourier::new(vec![0.0, f, 0.0, -0.3 * f], vec![0.0, 0.5 * f]))),
        spring,
        ..Load::default()
    }
}

#[test]
fn loads_change_the_coefficients() {
    let r = &mut Random(7);
    let mut worst_of_all = 0.0_f64;
    for i in 0..120 {
        let (mut scene, span) = random_scene(r);
        (scene.load, scene.solver) = (random_load(r, &scene.law), Settings { tolerance: 1e-12, ..Settings::default() });
        let same = by_hand(&scene);
        let [mut loaded, mut changed] = [&scene, &same].map(|scene| started(scene.clone()));
        // If the multipliers are of the size of roundings the growth is known to no digit.
        let close = (loaded.growth - changed.growth).abs() < 1e-7 * (1.0 + changed.growth.abs());
        assert!(close || changed.growth < -30.0, "{i}: {} {}", loaded.growth, changed.growth);
        let [got, expected] = [&mut loaded, &mut changed].map(|drive| run(drive, span, 7));
        let (Ok(got), Ok(expected)) = (got, expected) else { continue };
        let error = worst(&scene, &got, &expected);
        worst_of_all = worst_of_all.max(error);
        assert!(error < 1e-9, "{i}: {error:e} {scene:?}");
        // The drive does not transmit the forces that go to the ground.
        let ([q, v], load) = (loaded.state, &scene.load);
        let name = if scene.law.is_relative() { "tau" } else { "force" };
        let to_ground = load.stiffness() * q + load.damping.unwrap_or(0.0) * v;
        let (got, expected) = (output(&loaded, name), output(&changed, name) + to_ground);
        let size = expected.abs() + to_ground.abs() + output(&loaded, "stiffness").abs() * q.abs();
        assert!((got - expected).abs() < 1e-8 * size, "{i}: {got} {expected}");
    }
    assert!(worst_of_all > 0.0);
}

/// c = 60 N/m of its own and 40 of the return spring on 4 kg, the process force with steps.
fn stepped() -> Scene {
    let law = Law::Series(SeriesLaw {
        coordinate: Coordinate::Translation,
        m: constant(4.0),
        b: constant(1.0),
        c: constant(60.0),
        f: None,
    });
    let (angles, lifts) = [(0.0, 3.0), (2.0, 3.0), (2.0, -20.0), (2.5, -20.0), (2.5, 3.0)].into_iter().unzip();
    let load = Load {
        gravity: Some(-9.81),
        spring: Some(Spring { preload: 5.0, c: 40.0, at: 0.1 }),
        damping: Some(0.6),
        process: Some(MotionLaw::Polyline(Polyline::new(Points { angles, lifts }).unwrap())),
        ..Load::default()
    };
    Scene { load, ..scene(law, 2.0) }
}

/// m q̈ + (b + b_r) q̇ + (c + c_r) q = F in closed form from step to step of F.
fn closed_form(scene: &Scene, mut state: [f64; 2], end: f64) -> [f64; 2] {
    let (decay, frequency) = (0.5 * 1.6 / 4.0, f64::sqrt(100.0 / 4.0 - 0.04));
    let DriveMode::Constant { w, phi_start } = scene.drive else { unreachable!("a constant speed") };
    let steps = (0..100).flat_map(|turn| [2.0, 2.5].map(|phi| (phi + TAU * f64::from(turn) - phi_start) / w));
    let mut time = 0.0;
    for next in steps.map(|next| next.min(end)) {
        let phi = (phi_start + w * 0.5 * (time + next)).rem_euclid(TAU);
        let process = if (2.0..2.5).contains(&phi) { -20.0 } else { 3.0 };
        let rest = (process - 4.0 * 9.81 - 5.0 + 40.0 * 0.1) / 100.0;
        let ([q, v], h) = ([state[0] - rest, state[1]], next - time);
        let ((sin, cos), fade) = ((frequency * h).sin_cos(), (-decay * h).exp());
        let other = (v + decay * q) / frequency;
        let slope = |cosine: f64, sine: f64| {
            fade * ((-decay * cosine + frequency * sine) * cos - (decay * sine + frequency * cosine) * sin)
        };
        state = [rest + fade * (q * cos + other * sin), slope(q, other)];
        time = next;
    }
    state
}

#[test]
fn a_process_force_with_steps() {
    let scene = stepped();
    for steps in [1, 37, 800] {
        let mut drive = started(scene.clone());
        let states = run(&mut drive, 30.0, steps).unwrap();
        for (n, state) in states.iter().enumerate() {
            let expected = closed_form(&scene, [1.0, 0.0], 30.0 * (n + 1) as f64 / steps as f64);
            let error = (0..2).map(|i| (state[i] - expected[i]).abs()).fold(0.0, f64::max);
            assert!(error < 1e-9, "{steps} {n}: {error:e}");
        }
    }
    // On inputs, which go on as at constant speed.
    let mut drive = ParametricDrive::new(Scene { drive: DriveMode::Input, ..scene.clone() }).unwrap();
    drive.cam.set_inputs([0.3, 2.0, 0.0]);
    drive.start(0.0).unwrap();
    for n in 0..300 {
        drive.cam.set_inputs([0.3 + 0.2 * f64::from(n), 2.0, 0.0]);
        drive.advance(0.1 * f64::from(n), 0.1).unwrap();
    }
    let expected = closed_form(&scene, [1.0, 0.0], 30.0);
    assert!((drive.state[0] - expected[0]).abs() < 1e-8 && (drive.state[1] - expected[1]).abs() < 1e-7);
}

#[test]
fn an_equilibrium_balances_the_loads_and_lasts_where_the_drive_rests() {
    for w in [0.0, 2.0] {
        let mut scene = Scene { start: Start { mode: StartMode::Equilibrium, q: 0.0, q_dot: 0.0 }, ..stepped() };
        scene.drive = DriveMode::Constant { w, phi_start: 2.2 };
        let mut drive = started(scene.clone());
        let expected = (-20.0 - 4.0 * 9.81 - 5.0 + 40.0 * 0.1) / 100.0;
        assert!((drive.state[0] - expected).abs() < 1e-15 && drive.state[1] == 0.0, "{w}: {:?}", drive.state);
        drive.advance(0.0, 10.0).unwrap();
        assert_eq!((drive.state[0] - expected).abs() < 1e-14, w == 0.0);
        // The damper of the load counts as one, and is the only one.
        let Law::Series(law) = &mut scene.law else { unreachable!() };
        law.b = constant(0.0);
        assert!(
            started(Scene { start: Start { mode: StartMode::SteadyState, ..scene.start }, ..scene }).state[0] < 0.0
        );
    }
    // On the crank a damper brakes the turning mass, but not the mass at rest.
    let load = Load { constant: Some(-200.0), damping: Some(5.0), ..Load::default() };
    let mut drive = ParametricDrive::new(Scene {
        drive: DriveMode::Constant { w: 3.0, phi_start: FRAC_PI_2 },
        start: Start { mode: StartMode::Equilibrium, q: 0.0, q_dot: 0.0 },
        load,
        ..scene(Law::Crank(locomotive()), 3.0)
    })
    .unwrap();
    drive.start(0.0).unwrap();
    let expected = (-5e3 - 1e3 - 200.0) / drive.equation.coefficients.c.at(FRAC_PI_2)[0];
    assert!((drive.state[0] / expected - 1.0).abs() < 1e-14);
}

#[test]
fn loads_are_tuned_between_steps_and_read_back() {
    let scene = stepped();
    let mut drive = started(scene.clone());
    drive.advance(0.0, 3.0).unwrap();
    let mut other = scene.clone();
    for (name, value) in [("load.c", 90.0), ("load.b", 2.0), ("load.g", -1.6), ("load.preload", 3.0), ("load.at", 0.3)]
    {
        interface::set(&mut drive, name, value);
    }
    drive.apply(3.0).unwrap();
    (other.load.gravity, other.load.damping) = (Some(-1.6), Some(2.0));
    other.load.spring = Some(Spring { preload: 3.0, c: 90.0, at: 0.3 });
    other.drive = DriveMode::Constant { w: 2.0, phi_start: 0.3 + 6.0 };
    let [q, q_dot] = drive.state;
    other.start = Start { mode: StartMode::Given, q, q_dot };
    let mut other = started(other);
    for n in 0..40 {
        let time = 0.5 * f64::from(n);
        drive.advance(3.0 + time, 0.5).unwrap();
        other.advance(time, 0.5).unwrap();
        let error = (0..2).map(|i| (drive.state[i] - other.state[i]).abs()).fold(0.0, f64::max);
        assert!(error < 1e-8, "{n}: {error:e}");
    }
}

#[test]
fn a_force_by_input_is_a_load() {
    for law in [Law::Series(general()), Law::Crank(locomotive())] {
        let always = Scene { load: Load { constant: Some(3.0), ..Load::default() }, ..scene(law.clone(), 5.0) };
        let by_input = Scene { load: Load { input: true, ..Load::default() }, ..scene(law, 5.0) };
        let mut always = started(always);
        let mut drive = ParametricDrive::new(by_input).unwrap();
        interface::set(&mut drive, "F", 3.0);
        drive.start(0.0).unwrap();
        let [expected, got] = [&mut always, &mut drive].map(|drive| run(drive, 4.0, 40).unwrap());
        let largest = expected.iter().map(|state| state[0].abs()).fold(0.0, f64::max);
        for (got, expected) in got.iter().zip(&expected) {
            assert!((got[0] - expected[0]).abs() < 1e-9 * largest, "{got:?} {expected:?}");
        }
    }
}
