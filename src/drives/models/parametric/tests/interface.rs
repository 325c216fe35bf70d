//! The interface for users and importers: parameters, inputs, saved states, messages.

use super::*;
use crate::drives::follower::load::Spring;
use crate::drives::follower::parametric::coefficients::Values;
use crate::drives::{AnyDrive, Model, Seed};
use crate::motion::table::Points;
use crate::motion::{MotionLaw, Polyline};
use crate::numerics::gauss::Gauss;

pub(super) fn set(drive: &mut ParametricDrive, name: &str, value: f64) {
    let list = drive.variables();
    let v = &list.0[list.reference(name).unwrap_or_else(|| panic!("no `{name}`"))];
    v.set(drive, value);
    assert_eq!(v.value(drive), value, "{name}");
}

fn boxed(scene: &Scene) -> AnyDrive {
    (Model::of::<ParametricDrive>().build)(&postcard::to_stdvec(&(scene, [0_u8; 0].as_slice())).unwrap()).unwrap()
}

#[test]
fn every_parameter_acts_as_if_the_scene_had_it() {
    let mut drive = started(scene(Law::Series(general()), 5.0));
    for (name, value) in [("m.a[2]", -0.1), ("b.b[2]", 0.2), ("c.a[3]", -7.0), ("f.b[1]", 9.0), ("drive.w", -4.0)] {
        set(&mut drive, name, value);
    }
    drive.start(0.0).unwrap();
    let mut law = general();
    (law.m.a[2], law.b.b[2], law.c.a[3]) = (-0.1, 0.2, -7.0);
    law.f.as_mut().unwrap().b[1] = 9.0;
    let mut other = started(scene(Law::Series(law), -4.0));
    assert_eq!(run(&mut drive, 3.0, 10).unwrap(), run(&mut other, 3.0, 10).unwrap());
    let second = SecondCrank::OwnShafts(FRAC_PI_2);
    let mut drive = started(scene(Law::Crank(crank(0.1, 0.01, second)), 0.4));
    let mut law = crank(0.1, 0.01, SecondCrank::OwnShafts(1.0));
    law.crank = ParallelCrank { c_t1: 3.0, c_t2: 4.0, c_ab: 50.0, r: 0.7, ..law.crank };
    (law.inertia, law.damping) = (2.0, 0.1);
    for (name, value) in
        [("J", 2.0), ("b_T", 0.1), ("c_T1", 3.0), ("c_T2", 4.0), ("c_AB", 50.0), ("R", 0.7), ("second.angle", 1.0)]
    {
        set(&mut drive, name, value);
    }
    drive.start(0.0).unwrap();
    let mut other = started(scene(Law::Crank(law), 0.4));
    assert_eq!(run(&mut drive, 30.0, 10).unwrap(), run(&mut other, 30.0, 10).unwrap());
    assert_eq!(drive.growth, other.growth);
}

/// A drive on inputs at its start.
fn on_inputs(law: Law, inputs: [f64; 3]) -> ParametricDrive {
    let mut scene = scene(law, 0.0);
    scene.drive = DriveMode::Input;
    let mut drive = ParametricDrive::new(scene).unwrap();
    for (name, value) in ["phi", "w", "a"].into_iter().zip(inputs) {
        set(&mut drive, name, value);
    }
    drive.start(0.0).unwrap();
    drive
}

#[test]
fn where_inputs_jump_the_mass_stays() {
    let mut drive = on_inputs(Law::Crank(locomotive()), [0.3, 1.0, 4.0]);
    drive.advance(0.0, 0.25).unwrap();
    let (psi, speed) = (drive.before[0] + drive.state[0], drive.before[1] + drive.state[1]);
    set(&mut drive, "phi", 0.1);
    set(&mut drive, "w", -2.0);
    for _ in 0..3 {
        drive.apply(0.25).unwrap();
        assert!((output(&drive, "psi") - psi).abs() < 1e-15 && (output(&drive, "der(psi)") - speed).abs() < 1e-14);
    }
    let mut drive = on_inputs(Law::Series(general()), [0.3, 1.0, 4.0]);
    drive.advance(0.0, 0.25).unwrap();
    let state = drive.state;
    set(&mut drive, "phi", 7.0);
    drive.apply(0.25).unwrap();
    assert_eq!(drive.state, state);
    assert!((output(&drive, "stiffness") - general().c.at(7.0).0[0]).abs() < 1e-13);
}

#[test]
fn inputs_at_constant_speed_give_the_numbers_of_the_table() {
    for (law, w) in [(Law::Series(general()), 5.0), (Law::Crank(locomotive()), 40.0)] {
        let end = 3.0 * TAU / w;
        let mut tabulated = started(scene(law.clone(), w));
        let expected = run(&mut tabulated, end, 20).unwrap();
        let mut drive = on_inputs(law, [0.3, w, 0.0]);
        let scene = scene(drive.cam.law.as_ref().clone(), w);
        let mut got = Vec::new();
        for n in 0..20 {
            let time = end * f64::from(n) / 20.0;
            set(&mut drive, "phi", 0.3 + w * time);
            drive.advance(time, end * f64::from(n + 1) / 20.0 - time).unwrap();
            got.push(drive.state);
        }
        let error = worst(&scene, &got, &expected);
        assert!(error < 1e-11, "{error:e}");
    }
}

#[test]
fn an_accelerated_crank_leaves_its_inertia_behind() {
    // A rigid crank has tau = J α; a stiff damped one after its transient nearly so.
    let mut law = locomotive();
    (law.crank.c_t1, law.crank.c_t2, law.crank.c_ab) = (3e9, 6e9, 5e14);
    (law.damping, law.load) = (1.549e6, None);
    let mut drive = on_inputs(Law::Crank(law), [FRAC_PI_2, 0.0, 0.5]);
    // Critical damping: the initial q = 0.01 has decayed by e⁻⁵⁰ after 0.02 s.
    drive.advance(0.0, 0.02).unwrap();
    let tau = output(&drive, "tau");
    assert!((tau / (300.0 * 0.5) - 1.0).abs() < 1e-3, "{tau}");
}

#[test]
fn a_restored_drive_goes_on_bit_by_bit() {
    for (law, w) in [(Law::Series(general()), 5.0), (Law::Crank(locomotive()), 40.0), (mathieu(0.3, 0.0), 1e-5)] {
        let scene = scene(law, w);
        let mut drive = boxed(&scene);
        drive.set_up(0.0, None);
        drive.start().unwrap();
        let h = 0.137 * TAU / w.clamp(1.0, 50.0);
        for n in 0..5 {
            drive.advance(h * f64::from(n), h).unwrap();
        }
        let state = drive.save();
        let bytes = state.serialize().unwrap();
        let go_on = |drive: &mut AnyDrive| -> Vec<u64> {
            let count = drive.descriptions().len();
            (5..8)
                .flat_map(|n| {
                    drive.advance(h * f64::from(n), h).unwrap();
                    (0..count).map(|i| drive.get(i).unwrap().to_bits()).collect::<Vec<_>>()
                })
                .collect()
        };
        let expected = go_on(&mut drive);
        drive.restore(&state);
        assert_eq!(go_on(&mut drive), expected);
        let mut other = boxed(&scene);
        let copy = other.deserialize(&bytes).unwrap();
        other.restore(&copy);
        assert_eq!(go_on(&mut other), expected);
    }
}

/// The drive on inputs under a load.
fn loaded_on_inputs(law: Law, load: Load) -> ParametricDrive {
    let mut drive = on_inputs(law, [0.7, 20.0, 30.0]);
    if !load.is_none() {
        drive =
            ParametricDrive::new(Scene { load, drive: DriveMode::Input, ..scene(drive.cam.law.as_ref().clone(), 0.0) })
                .unwrap();
        for (name, value) in [("phi", 0.7), ("w", 20.0), ("a", 30.0), ("F", -11.0)] {
            set(&mut drive, name, value);
        }
        drive.start(0.0).unwrap();
    }
    drive
}

#[test]
fn derivatives_of_the_outputs_by_time_states_and_inputs() {
    // Next to a step of the process force.
    let points = Points { angles: vec![0.0, 0.8, 0.8, 3.0], lifts: vec![0.0, 3.0, -6.0, 40.0] };
    let spring = Some(Spring { preload: 2.0, c: 30.0, at: 0.3 });
    let (constant, process) = (Some(7.0), Some(MotionLaw::Polyline(Polyline::new(points).unwrap())));
    let load = Load { constant, spring, damping: Some(0.2), process, input: true, ..Load::default() };
    let on_crank = Load { spring: None, ..load.clone() };
    for (law, load) in [
        (Law::Series(general()), Load::default()),
        (Law::Crank(locomotive()), Load::default()),
        (Law::Series(general()), load),
        (Law::Crank(locomotive()), on_crank),
    ] {
        let relative = law.is_relative();
        let mut drive = loaded_on_inputs(law, load);
        let force = drive.force.is_some();
        drive.advance(0.0, 0.01).unwrap();
        set(&mut drive, "phi", 0.7 + 0.2 + 0.0015);
        set(&mut drive, "w", 20.3);
        drive.apply(0.01).unwrap();
        let list = drive.variables();
        let first = list.reference(if relative { "psi" } else { "q" }).unwrap();
        for v in list.0.iter().filter(|v| v.series().is_some()) {
            let value = |d: &ParametricDrive| v.value(d);
            let series = |seed: Seed| v.series().unwrap()(&drive, seed, v.index);
            let name = &v.description.name;
            let along = series(Seed::Time);
            let h = 1e-5;
            let after = |h: f64| {
                let mut later = drive.clone();
                if h > 0.0 {
                    later.advance(0.01, h).unwrap();
                }
                value(&later)
            };
            let (y0, y1, y2, y4) = (after(0.0), after(h), after(2.0 * h), after(4.0 * h));
            let slope = (-21.0 * y0 + 32.0 * y1 - 12.0 * y2 + y4) / (12.0 * h);
            let size = y0.abs().max(along.derivative(1).abs() * 1e-2).max(along.derivative(2).abs() * 1e-4);
            assert!((slope - along.derivative(1)).abs() < 1e-4 * size / 1e-2, "{name}: {slope} {along:?}");
            // By a state or an input, with the others constant.
            let knowns = [(first, 0), (first + 1, 1), (0, 2), (1, 3), (3, 4)];
            for (known, names) in knowns.into_iter().take(if force { 5 } else { 4 }) {
                let moved = |by: f64| {
                    let mut d = drive.clone();
                    match names {
                        4 => set(&mut d, "F", -11.0 + by),
                        0 | 1 => d.state[names] += by,
                        2 => {
                            d.motion.coefficients[0] += by;
                            if relative {
                                d.state[0] -= by;
                            }
                        }
                        _ => {
                            d.motion.coefficients[1] += by;
                            if relative {
                                d.state[1] -= by;
                            }
                        }
                    }
                    value(&d)
                };
                let h = 1e-6;
                let difference = (moved(h) - moved(-h)) / (2.0 * h);
                let got = series(Seed::Known(&list.0[known].description.name)).derivative(1);
                let size = got.abs().max(value(&drive).abs());
                assert!((difference - got).abs() <= 1e-6 * size.max(1e-3), "{name} by {known}: {got} {difference}");
            }
        }
    }
}

#[test]
fn what_is_no_drive_is_refused_by_name() {
    let refused = |law: Law| ParametricDrive::new(scene(law, 1.0)).expect_err("a refusal").to_string();
    let light = SeriesLaw { m: Fourier::new(vec![1.0, 0.0, 1.5], Vec::new()), ..general() };
    let text = refused(Law::Series(light));
    assert!(text.starts_with("`m`: m(φ) is -0.5 kg·m² at φ = 1.57079") && text.contains("(90.0000°)"), "{text}");
    let mut law = locomotive();
    law.crank.c_ab = 0.0;
    let without_rods = AnyDrive::new(ParametricDrive::new(scene(Law::Crank(law), 1.0)).unwrap()).start();
    assert!(
        without_rods.unwrap_err().to_string().starts_with("`c_AB`: 0 N/m is not admissible; expected 1e-12 to 1e15")
    );
    let endless = SeriesLaw { c: Fourier::new(vec![f64::INFINITY], Vec::new()), ..general() };
    assert!(refused(Law::Series(endless)).contains("must be finite"));
    // A parameter that makes the mass vanish is refused at the start.
    let mut drive = started(scene(Law::Series(general()), 5.0));
    set(&mut drive, "m.a[2]", -4.0);
    assert!(drive.start(0.0).unwrap_err().to_string().starts_with("`m`: m(φ) is -"));
}

#[test]
fn an_unstable_drive_says_so_when_it_starts() {
    let mut drive = started(scene(mathieu(0.3, 0.0), 2.0));
    let log = drive.events();
    let kinds: Vec<&str> = log.iter().map(|e| e.kind).collect();
    assert_eq!(kinds, ["parametrically unstable"]);
    let mut drive = started(scene(mathieu(0.3, 0.0), 1.5));
    assert_eq!(drive.events().count(), 0);
}

/// Error of E = ½ (m q̇² + c q²) against ∫ [f q̇ − b q̇² + ½ (m′ q̇² + c′ q²) ω] dt over `panels` of this `length` (s) from 0 on,
/// as part of the energy that drive, damper and mass exchange.
fn missed(drive: &mut ParametricDrive, w: f64, panels: usize, length: f64) -> f64 {
    let energy_and_power = |drive: &ParametricDrive| {
        let ([q, v], Values { m, b, c, f }) = (drive.state, drive.equation.coefficients.at(0.3 + w * drive.time));
        let power = (f[0] - b[0] * v) * v + 0.5 * (m[1] * v * v + c[1] * q * q) * w;
        [0.5 * (m[0] * v * v + c[0] * q * q), power]
    };
    let [before, _] = energy_and_power(drive);
    let (mut work, mut exchanged) = (0.0, before);
    for panel in 0..panels {
        let start = panel as f64 * length;
        let [part, size] = Gauss::with(16).integrate(length, |s| {
            let mut there = drive.clone();
            there.advance(start, s).unwrap();
            let [_, power] = energy_and_power(&there);
            [power, power.abs()]
        });
        drive.advance(start, length).unwrap();
        (work, exchanged) = (work + part, exchanged + size);
    }
    (energy_and_power(drive)[0] - before - work).abs() / exchanged
}

#[test]
fn the_balance_of_energy_closes() {
    for (law, w, length) in [
        (mathieu(0.4, 0.02), 1.7, 0.05),
        (mathieu(0.4, 0.0), 0.01, 2.0),
        (Law::Series(general()), 3.0, 0.05),
        (Law::Crank(crank(0.1, 0.03, SecondCrank::None)), -0.4, 0.1),
        (Law::Crank(locomotive()), 20.0, 0.002),
    ] {
        let missing = missed(&mut started(scene(law, w)), w, 400, length);
        assert!(missing < 1e-11, "{w}: {missing:e}");
    }
}

#[test]
fn the_balance_of_energy_closes_beyond_the_end_of_a_damped_motion() {
    // After 14 s the square of q underflows.
    let law = SeriesLaw {
        coordinate: Coordinate::Translation,
        m: constant(0.0096),
        b: Fourier::new(vec![1.7, 0.25, -0.06, 0.01, 0.06], vec![0.0, 0.29, 0.12, -0.05, -0.01]),
        c: Fourier::new(vec![47.8, -1.65, -0.18, -0.42, -0.41], vec![0.0, 0.78, 0.65, 0.37, 0.33]),
        f: None,
    };
    let w = 3.94;
    let mut drive = started(Scene {
        start: Start { mode: StartMode::Given, q: -1.6e-4, q_dot: -0.023 },
        ..scene(Law::Series(law), w)
    });
    let missing = missed(&mut drive, w, 800, 0.02);
    assert!(missing < 1e-13 && drive.state[0].powi(2) == 0.0, "{missing:e}, {:e}", drive.state[0]);
}
