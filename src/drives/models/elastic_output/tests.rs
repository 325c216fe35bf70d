//! Against numbers computed with 50 digits: the closed form on the Fourier law, the convolution of −ẍ with the impulse
//! response elsewhere.

mod damping_law;
mod energy;
mod loads;
mod on_inputs;
mod table;

use super::*;
use crate::drives::variable::{List, Variable};
use crate::drives::{AnyDrive, MODELS, Seed};
use crate::motion::{Cycle, CyclePlan, Fourier, StandardLaw, StandardLaw::*};
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use crate::numerics::work::drawn;
use std::f64::consts::TAU;

fn series() -> Fourier {
    Fourier::new(vec![0.01, -0.01, 0.0012, 0.0005, -0.0002], vec![0.0, 0.0, 8e-4, -3e-4, 0.0, 1e-4])
}

fn given() -> Start {
    Start { mode: StartMode::Given, q: 1e-4, q_dot: -0.02 }
}

fn at_rest() -> Start {
    Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 }
}

/// With m, c and b.
fn scene(mcb: [f64; 3], cam: MotionLaw, drive: DriveMode, start: Start) -> Scene {
    let [m, c, b] = mcb;
    let (load, roller) = (Load::default(), (0.0, Load::default()));
    Scene {
        coupling: false,
        parameters: Parameters { m, c, b },
        load,
        roller,
        cam,
        drive,
        start,
        solver: Settings::default(),
    }
}

fn drive(scene: Scene) -> ElasticOutput {
    let mut drive = ElasticOutput::new(scene).unwrap();
    drive.start(0.0).unwrap();
    drive
}

/// A variable by its name. Building the list costs more than a step, so runs of many steps keep it.
fn named<'a>(list: &'a List<ElasticOutput>, name: &str) -> &'a Variable<ElasticOutput> {
    &list.0[list.reference(name).unwrap_or_else(|| panic!("no {name}"))]
}

fn harmonic_drive(mcb: [f64; 3], w: f64, start: Start) -> ElasticOutput {
    drive(scene(mcb, MotionLaw::Fourier(series()), DriveMode::Constant { w, phi_start: 0.3 }, start))
}

/// Advances to `stop` in equal steps and a last one that ends there exactly.
fn run(drive: &mut ElasticOutput, stop: f64, step: f64) -> [f64; 2] {
    let start = drive.now.time;
    let mut time = start;
    for n in 1.. {
        let next = start + f64::from(n) * step;
        if next >= stop * (1.0 - 1e-12) {
            break;
        }
        drive.advance(time, next - time).unwrap();
        time = next;
    }
    drive.advance(time, stop - time).unwrap();
    assert_eq!(drive.now.time, stop);
    drive.now.q.array()
}

/// Name, m, c, b, w, and t, q, q̇, largest |q| in the turn before t; start.q = 1e-4 m, start.q_dot = −0.02 m/s.
type Harmonic = (&'static str, [f64; 4], [(f64, f64, f64, f64); 3]);

#[rustfmt::skip]
const HARMONIC: &[Harmonic] = &[
    ("underdamped", [1.0, 100000.0, 40.0, 20.0], [(0.1, 3.6717853340880543e-05, -0.00241423590349581, 1.08e-04), (0.3141592653589793, -5.8629854093106954e-06, 0.00012965866958537727, 1.10e-04), (314159.2653589793, -6.0041615282956546e-06, 7.732378203886249e-05, 8.41e-05)]),
    ("critical", [1.0, 10000.0, 200.0, 20.0], [(0.1, 5.7982179505863524e-05, 0.009292687358505558, 3.18e-04), (0.3141592653589793, -0.00017344062398689259, 0.005488895061252835, 6.82e-04), (314159.2653589793, -0.0001734406241733184, 0.005488895063657454, 6.82e-04)]),
    ("overdamped", [1.0, 10000.0, 2000.0, 20.0], [(0.1, 1.0194601253343323e-05, 0.0011270778149580485, 8.84e-05), (0.3141592653589793, -1.0417931187776895e-05, -0.00030365997954678745, 1.97e-04), (314159.2653589793, -3.673945188010406e-05, -0.00017172170171538714, 1.52e-04)]),
    ("undamped", [1.0, 100000.0, 0.0, 20.0], [(0.1, 0.00011469069641771415, -0.025582975089581465, 1.56e-04), (0.3141592653589793, 9.258872010953976e-05, 0.02353903028072569, 1.84e-04), (314159.2653589793, -9.936744596717355e-05, -0.025493084522814097, 1.89e-04)]),
    ("very stiff", [1.0, 1e14, 0.0, 20.0], [(0.1, 9.367591277282579e-05, 349.97476710150033, 9.99e-05), (0.3141592653589793, 0.00010000000000000025, -0.019999877535320076, 1.00e-04), (314159.2653589793, 9.999999491258303e-05, 0.31960653461242, 1.00e-04)]),
    ("very soft", [1.0, 0.0001, 0.0, 20.0], [(0.1, -0.012048825404567136, -0.1502691741030592, 1.20e-02), (0.3141592653589793, 0.0061768641542667875, -0.01999984701268319, 1.57e-02), (314159.2653589793, 0.00010000000082481933, -0.019999999975976998, 2.18e-02)]),
    ("enormous damper", [1.0, 10000.0, 1e10, 20.0], [(0.1, 9.999997497307988e-05, 1.3937848858122877e-10, 1.00e-04), (0.3141592653589793, 9.999996658407781e-05, -1.7073769344244635e-10, 1.00e-04), (314159.2653589793, 7.304026658337817e-05, -1.4377799344232115e-10, 7.30e-05)]),
    ("resonance k = 3", [1.0, 3600.0, 0.0, 20.0], [(0.1, 0.001549510439706056, 0.08998532391015136, 1.72e-03), (0.3141592653589793, 0.00554890187571292, 0.022867798383733158, 6.61e-03), (314159.2653589793, 5448.901974257102, 42867.77904990672, 5.49e+03)]),
    ("1e-9 above resonance", [1.0, 3600.0, 0.0, 20.00000002], [(0.1, 0.0015495104475330879, 0.08998532410451501, 1.72e-03), (0.3141592653589793, 0.005548901881711334, 0.02286779513636194, 6.61e-03), (314159.2653589793, 5455.312767445477, 39784.04996204098, 5.49e+03)]),
    ("1e-9 below resonance", [1.0, 3600.0, 0.0, 19.999999980000002], [(0.1, 0.0015495104318790256, 0.08998532371578775, 1.72e-03), (0.3141592653589793, 0.0055489018697145055, 0.022867801631103798, 6.61e-03), (314159.2653589793, 5441.84585160051, 45946.430629123875, 5.49e+03)]),
    ("1e-15 beside resonance", [1.0, 3600.0, 0.0, 20.000000000000007], [(0.1, 0.001549510439706059, 0.08998532391015143, 1.72e-03), (0.3141592653589793, 0.005548901875712922, 0.022867798383732003, 6.61e-03), (314159.2653589793, 5448.9019766493775, 42867.77795521559, 5.49e+03)]),
    ("resonance, D = 1e-9", [1.0, 3600.0, 1.2e-07, 20.0], [(0.1, 0.0015495104329231698, 0.08998532367103039, 1.72e-03), (0.3141592653589793, 0.005548901822252077, 0.02286779765872195, 6.61e-03), (314159.2653589793, 5397.868438070925, 42466.28585745838, 5.44e+03)]),
    ("backwards, resonance", [1.0, 3600.0, 0.0, -20.0], [(0.1, -0.0015403193875337658, -0.028973828879840204, 1.54e-03), (0.3141592653589793, -0.00534890187571292, 0.022867798383732676, 5.35e-03), (314159.2653589793, -5448.901777168738, 42867.77771755916, 5.49e+03)]),
];

/// m, c, b, the derivatives of φ at t = 0, t, and q, q̇ there from rest.
type Ramp = ([f64; 3], &'static [f64], f64, [f64; 2]);

#[rustfmt::skip]
const RAMP: &[Ramp] = &[
    ([1.0, 10000.0, 20.0], &[0.3, 10.0, 30.0], 1.0, [-0.00034366744351479084, 0.3525128326153559]),
    ([1.0, 10000.0, 0.0], &[0.3, 10.0, -30.0], 1.0, [-1.797884427798731e-05, 0.009443402852050366]),
    ([1.0, 10000.0, 0.0], &[0.3, -5.0, 40.0, -60.0, 200.0], 1.0, [-0.0035807576623329697, -0.5836198577755455]),
    ([2.0, 9000000.0, 0.0], &[0.3, 10.0, 30.0], 1.0, [-8.567891250457703e-07, 0.00017801777140932012]),
    ([1.0, 10000.0, 1000000.0], &[0.3, 10.0, 30.0], 1.0, [-4.888042897381286e-08, -3.7056724968761456e-06]),
];

/// m, c, b, law of rise and return, w, and q, q̇ at t = 1 s from rest.
type CycleCase = ([f64; 3], StandardLaw, StandardLaw, f64, [f64; 2]);

#[rustfmt::skip]
const CYCLE: &[CycleCase] = &[
    ([1.0, 20000.0, 12.0], Polynomial345, InclinedSine, 30.0, [-0.00408388768302053, -2.1037546928082445]),
    ([1.0, 20000.0, 0.0], InclinedSine, Polynomial345, 30.0, [-0.004488654497447428, -4.9443250572353294]),
    ([1.0, 20000.0, 0.0], SimpleSine, SimpleSine, -30.0, [-0.006056179973189837, 2.471217119860334]),
    ([1.0, 2000000.0, 5.0], SimpleSine, Polynomial345, 30.0, [-2.527798582811937e-07, -0.05821322622868708]),
];

/// The errors of q as a part of its scale, of q̇ as one of scale · rate.
fn off(found: [f64; 2], expected: [f64; 2], scale: f64, rate: f64) -> [f64; 2] {
    [(found[0] - expected[0]).abs() / scale, (found[1] - expected[1]).abs() / (scale * rate)]
}

fn assert_near(errors: [f64; 2], tolerance: f64, case: &str) {
    assert!(
        errors[0] <= tolerance && errors[1] <= tolerance,
        "{case}: relative errors {:e} {:e}",
        errors[0],
        errors[1]
    );
}

#[test]
fn harmonic_law_at_constant_speed_after_a_part_of_a_turn_and_after_a_million() {
    for (name, [m, c, b, w], points) in HARMONIC {
        // q̇ follows the fastest of ω₀ and the highest harmonic.
        let rate = (c / m).sqrt().max(5.0 * w.abs());
        let mut drive = harmonic_drive([*m, *c, *b], *w, given());
        for (t, q, v, largest) in points {
            let found = run(&mut drive, *t, *t);
            assert_near(
                off(found, [*q, *v], *largest, rate),
                1e-14,
                &format!("{name}, t = {t} s, steps as long as the run"),
            );
        }
    }
}

#[test]
fn the_communication_step_does_not_matter() {
    for (name, [m, c, b, w], points) in HARMONIC {
        let rate = (c / m).sqrt().max(5.0 * w.abs());
        // A third of a turn in microseconds, a turn in longer steps.
        for (step, (t, q, v, largest)) in [(1e-6, points[0]), (1e-4, points[1]), (7.7e-3, points[1])] {
            let found = run(&mut harmonic_drive([*m, *c, *b], *w, given()), t, step);
            assert_near(off(found, [q, v], largest, rate), 1e-14, &format!("{name}, step {step} s"));
        }
        // Ten turns per step.
        let (t, q, v, largest) = points[2];
        let found = run(&mut harmonic_drive([*m, *c, *b], *w, given()), t, 3.1);
        assert_near(off(found, [q, v], largest, rate), 1e-14, &format!("{name}, ten turns per step"));
    }
}

/// Sets φ, w, a and the derivatives of a from the polynomial with these derivatives at t = 0.
fn set_inputs(drive: &mut ElasticOutput, derivatives: &[f64], time: f64) {
    set_inputs_of(&drive.variables(), drive, derivatives, time);
}

fn set_inputs_of(list: &List<ElasticOutput>, drive: &mut ElasticOutput, derivatives: &[f64], time: f64) {
    let mut values = [0.0; 11];
    for (order, value) in values.iter_mut().enumerate() {
        for j in (order..derivatives.len()).rev() {
            *value = derivatives[j] + *value * time / (j + 1 - order) as f64;
        }
    }
    for (k, value) in values[..3].iter().enumerate() {
        list.0[k].set(drive, *value);
    }
    for order in 1..=8 {
        list.0[2].set_derivative(drive, order, values[2 + order]);
    }
}

fn run_inputs(mcb: [f64; 3], cam: MotionLaw, derivatives: &[f64], stop: f64, steps: u32) -> ElasticOutput {
    let mut drive = ElasticOutput::new(scene(mcb, cam, DriveMode::Input, at_rest())).unwrap();
    let list = drive.variables();
    set_inputs_of(&list, &mut drive, derivatives, 0.0);
    drive.start(0.0).unwrap();
    for n in 0..steps {
        let time = stop * f64::from(n) / f64::from(steps);
        let next = stop * f64::from(n + 1) / f64::from(steps);
        set_inputs_of(&list, &mut drive, derivatives, time);
        drive.apply(time).unwrap();
        drive.advance(time, next - time).unwrap();
    }
    drive
}

#[test]
fn ramps_of_the_speed_also_through_reversal() {
    for (mcb, derivatives, t, expected) in RAMP {
        let rate = (mcb[1] / mcb[0]).sqrt().max(100.0);
        let scale = expected[0].abs() + expected[1].abs() / rate;
        for (steps, tolerance) in [(1, 1e-12), (10, 1e-12), (1000, 1e-11), (100_000, 1e-10)] {
            let drive = run_inputs(*mcb, MotionLaw::Fourier(series()), derivatives, *t, steps);
            assert_near(
                off(drive.now.q.array(), *expected, scale, rate),
                tolerance,
                &format!("{mcb:?} {derivatives:?} {steps} steps"),
            );
        }
    }
}

fn cycle(rise_law: StandardLaw, return_law: StandardLaw) -> MotionLaw {
    MotionLaw::Cycle(Cycle::new(CyclePlan {
        stroke: 0.03,
        lower: 0.0,
        rise_start: 0.4,
        rise_angle: 1.5,
        upper_dwell: 0.7,
        return_angle: 1.2,
        rise_law,
        return_law,
        inflections: [None; 2],
    }))
}

#[test]
fn cycles_at_constant_speed_and_with_inputs() {
    for &(mcb, rise, back, w, expected) in CYCLE {
        let rate = (mcb[1] / mcb[0]).sqrt();
        let scale = expected[0].abs() + expected[1].abs() / rate;
        for step in [1.0, 0.1, 1e-3, 1e-5] {
            let mode = DriveMode::Constant { w, phi_start: 0.1 };
            let found = run(&mut drive(scene(mcb, cycle(rise, back), mode, at_rest())), 1.0, step);
            assert_near(off(found, expected, scale, rate), 1e-11, &format!("{mcb:?} {rise:?} {back:?}, step {step} s"));
        }
        for steps in [1, 10, 1000] {
            let found = run_inputs(mcb, cycle(rise, back), &[0.1, w], 1.0, steps).now.q.array();
            assert_near(
                off(found, expected, scale, rate),
                1e-10,
                &format!("{mcb:?} {rise:?} {back:?}, {steps} inputs"),
            );
        }
    }
}

#[test]
fn the_work_of_the_drive_is_the_energy_of_the_mass_and_the_loss() {
    // (1.2) over a ramp: d(m ẏ²/2 + c q²/2) = tau ω dt − b q̇² dt, integrated by Simpson's rule.
    let ([m, c, b], derivatives) = ([2.0, 5e3, 15.0], [0.3, 10.0, 30.0, -20.0]);
    let steps = 20_000u32;
    let mut drive =
        ElasticOutput::new(scene([m, c, b], MotionLaw::Fourier(series()), DriveMode::Input, at_rest())).unwrap();
    set_inputs(&mut drive, &derivatives, 0.0);
    drive.start(0.0).unwrap();
    let list = drive.variables();
    let value = |drive: &ElasticOutput, name: &str| named(&list, name).value(drive);
    let energy = |d: &ElasticOutput| 0.5 * m * value(d, "der(y)").powi(2) + 0.5 * c * value(d, "q").powi(2);
    let power = |d: &ElasticOutput| value(d, "tau") * d.now.shaft[1] - b * value(d, "der(q)").powi(2);
    let (start, mut work, mut turnover) = (energy(&drive), 0.0, 0.0);
    let h = 1.0 / f64::from(steps);
    for n in 0..=steps {
        let weight = if n == 0 || n == steps { 1.0 } else { f64::from(2 + 2 * (n % 2)) } * h / 3.0;
        work += weight * power(&drive);
        turnover += weight * power(&drive).abs();
        if n < steps {
            let time = f64::from(n) * h;
            set_inputs_of(&list, &mut drive, &derivatives, time);
            drive.apply(time).unwrap();
            drive.advance(time, h).unwrap();
        }
    }
    let error = (energy(&drive) - start - work).abs();
    assert!(error < 1e-11 * turnover, "{error:e} of {turnover:e}");
}

#[test]
fn a_jump_of_the_inputs_leaves_the_mass_where_it_is() {
    let mcb = [1.0, 1e4, 5.0];
    for law in [MotionLaw::Fourier(series()), cycle(InclinedSine, SimpleSine)] {
        let mut drive = run_inputs(mcb, law, &[0.5, 20.0, 3.0], 0.1, 4);
        let list = drive.variables();
        let value = |drive: &ElasticOutput, name: &str| {
            let v = &list.0[list.reference(name).unwrap()];
            v.value(drive)
        };
        let (y, y_dot, x) = (value(&drive, "y"), value(&drive, "der(y)"), value(&drive, "x"));
        // Set and read several times at one communication point.
        for phi in [1.1, 7.0, 3.0] {
            set_inputs(&mut drive, &[phi, -4.0, 100.0], 0.0);
            drive.apply(0.1).unwrap();
            assert!((value(&drive, "y") - y).abs() < 1e-17 && (value(&drive, "der(y)") - y_dot).abs() < 1e-16);
            assert_eq!(value(&drive, "x"), drive.cam.law.at(angle::reduce(Double::from(phi))).0[0]);
        }
        assert!((value(&drive, "x") - x).abs() > 1e-4);
        // Without new values the motion starts again from the held inputs.
        drive.advance(0.1, 0.05).unwrap();
        let phi = drive.shaft().kinematics.0[0];
        assert!((phi - (3.0 - 0.2 + 50.0 * 0.05 * 0.05)).abs() < 1e-15);
        drive.advance(0.15000000000000002, 1e-12).unwrap();
        assert!((drive.shaft().kinematics.0[0] - 3.0).abs() < 1e-9);
        assert!(value(&drive, "y").is_finite());
    }
}

#[test]
fn a_coarser_tolerance_saves_evaluations_and_is_kept() {
    for law in [MotionLaw::Fourier(series()), cycle(InclinedSine, Polynomial345)] {
        let runs = [1e-13, 1e-8, 1e-5, 1e-3].map(|tolerance| {
            let mut scene = scene([1.0, 1e4, 5.0], law.clone(), DriveMode::Input, at_rest());
            scene.solver.tolerance = tolerance;
            let mut drive = drive(scene);
            let (mut motion, mut time) = (Vec::new(), 0.0f64);
            for _ in 0..100 {
                let t = time;
                set_inputs(&mut drive, &[0.5 + 20.0 * t + 15.0 * t * t, 20.0 + 30.0 * t, 30.0], t);
                drive.advance(t, 0.01).unwrap();
                time += 0.01;
                motion.push(drive.now.q.array()[0]);
            }
            (tolerance, motion, [drive.statistics()[1], drive.statistics()[2]])
        });
        let [(_, finest, _), coarser @ ..] = &runs;
        let largest = finest.iter().fold(0.0, |largest: f64, q| largest.max(q.abs()));
        for (tolerance, motion, [_, estimate]) in coarser {
            let error = motion.iter().zip(finest).fold(0.0, |error: f64, (a, b)| error.max((a - b).abs())) / largest;
            assert!(error <= *tolerance && error <= *estimate, "{tolerance}: {error}, {estimate}");
        }
        let evaluations = runs.each_ref().map(|(.., [evaluations, _])| *evaluations);
        assert!(evaluations.is_sorted_by(|finer, coarser| finer >= coarser), "{evaluations:?}");
        assert!(evaluations[0] > 1.25 * evaluations[3], "{evaluations:?}");
    }
}

#[test]
fn stiff_springs_leave_the_kinetostatic_deformation() {
    // c → ∞: q = −ẍ/ω₀² up to (kη)².
    let mut drive = harmonic_drive([1.0, 1e12, 0.0], 20.0, Start { mode: StartMode::SteadyState, ..at_rest() });
    run(&mut drive, 1.0, 0.013);
    let shaft = drive.shaft();
    let x2 = shaft.on(&drive.cam.law).along(&shaft.kinematics).0[2];
    assert!((drive.now.q.array()[0] * 1e12 / -x2 - 1.0).abs() < 1e-7);
}

#[test]
fn the_damped_resonance_has_the_amplitude_of_the_source() {
    // (1.5): kη = 1, q_k = (a_k sin kφ − b_k cos kφ)/(2D), here k = 3 alone and D = 0.02.
    let (w, damping) = (20.0, 0.02);
    let cam = MotionLaw::Fourier(Fourier::new(vec![0.0, 0.0, 0.0, 5e-4], vec![0.0, 0.0, 0.0, -3e-4]));
    let mode = DriveMode::Constant { w, phi_start: 0.3 };
    let steady = Start { mode: StartMode::SteadyState, ..at_rest() };
    let mut drive = drive(scene([1.0, 3600.0, 2.0 * damping * 60.0], cam, mode, steady));
    let q = run(&mut drive, 2.0, 0.1)[0];
    let (s, c) = (3.0f64 * 40.3).sin_cos();
    assert!((q - (5e-4 * s + 3e-4 * c) / (2.0 * damping)).abs() < 1e-14);
}

#[test]
fn the_steady_state_repeats_itself_every_turn() {
    let w = 30.0;
    for cam in [MotionLaw::Fourier(series()), cycle(Polynomial345, ModifiedSine)] {
        for (c, b) in [(2e4, 12.0), (2e4, 0.0), (2e4, 2000.0), (1e12, 1.0), (900.0 * 9.0, 1e-3)] {
            let mode = DriveMode::Constant { w, phi_start: 0.1 };
            let steady = Start { mode: StartMode::SteadyState, ..at_rest() };
            let mut drive = drive(scene([1.0, c, b], cam.clone(), mode, steady));
            let first = drive.now.q.array();
            let mut largest = 0.0f64;
            for n in 1..=10 {
                let time = drive.now.time;
                drive.advance(time, TAU / w * f64::from(n) / 10.0 - time).unwrap();
                largest = largest.max(drive.now.q.array()[0].abs());
            }
            // (c, b) = (8100, 1e-3) amplifies the rounding by 1/(2πD·3) ~ 1e4.
            let tolerance = if b == 1e-3 { 1e-9 } else { 1e-12 };
            assert_near(
                off(drive.now.q.array(), first, largest, c.sqrt().max(150.0)),
                tolerance,
                &format!("c = {c}, b = {b}"),
            );
        }
    }
}

#[test]
fn no_steady_state_at_an_undamped_resonance_without_spring_or_with_inputs() {
    let steady = Start { mode: StartMode::SteadyState, ..at_rest() };
    let start = |mcb, cam, mode| ElasticOutput::new(scene(mcb, cam, mode, steady)).unwrap().start(0.0);
    let constant = |w| DriveMode::Constant { w, phi_start: 0.0 };
    let harmonic = MotionLaw::Fourier(series());
    for (mcb, cam, mode, word) in [
        ([1.0, 3600.0, 0.0], harmonic.clone(), constant(20.0), "harmonic 3"),
        ([1.0, 0.0, 10.0], harmonic.clone(), constant(20.0), "c = 0"),
        ([1.0, 8100.0, 0.0], cycle(InclinedSine, InclinedSine), constant(30.0), "resonance"),
        ([1.0, 8100.0, 1.0], harmonic.clone(), DriveMode::Input, "inputs"),
    ] {
        let message = start(mcb, cam, mode).unwrap_err().to_string();
        assert!(message.contains(word) && message.contains("start.mode"), "{message}");
    }
    // A cam at rest does not move the mass.
    assert!(start([1.0, 3600.0, 0.0], harmonic, constant(0.0)).is_ok());
}

#[test]
fn a_tunable_parameter_changes_the_motion_from_now_on() {
    // Undamped, then critically damped: it continues like a drive that starts there with these parameters.
    let mut changed = harmonic_drive([1.0, 1e4, 0.0], 20.0, given());
    run(&mut changed, 0.1, 0.01);
    let (time, [q, q_dot]) = (changed.now.time, changed.now.q.array());
    changed.parameters.b = 200.0;
    changed.apply(time).unwrap();
    changed.apply(time).unwrap();
    run(&mut changed, 0.2, 0.01);
    let start = Start { mode: StartMode::Given, q, q_dot };
    let mode = DriveMode::Constant { w: 20.0, phi_start: 2.3 };
    let mut fresh = drive(scene([1.0, 1e4, 200.0], MotionLaw::Fourier(series()), mode, start));
    run(&mut fresh, 0.1, 0.01);
    assert_near(off(changed.now.q.array(), fresh.now.q.array(), 1e-4, 100.0), 1e-13, "after the change");
}

#[test]
fn a_serialised_drive_goes_on_bit_by_bit() {
    for cam in [MotionLaw::Fourier(series()), cycle(InclinedSine, SimpleSine)] {
        let mode = DriveMode::Constant { w: 20.0, phi_start: 0.3 };
        let mut original = drive(scene([1.0, 1e4, 3.0], cam, mode, given()));
        run(&mut original, 0.37, 0.01);
        let bytes = postcard::to_stdvec(&original).unwrap();
        let mut copy: ElasticOutput = postcard::from_bytes(&bytes).unwrap();
        copy.restored(&original).unwrap();
        assert_eq!(run(&mut original, 1.0, 0.01), run(&mut copy, 1.0, 0.01));
    }
}

#[test]
fn derivatives_of_the_outputs_are_those_of_the_outputs() {
    let mut drive = run_inputs([1.5, 8e3, 7.0], MotionLaw::Fourier(series()), &[0.5, 20.0, 3.0, -40.0], 0.1, 4);
    set_inputs(&mut drive, &[0.5, 20.0, 3.0, -40.0], 0.1);
    drive.apply(0.1).unwrap();
    let list = drive.variables();
    // Central differences over ±1e-4 s, of drives that run from here.
    let h = 1e-4;
    let ahead: Vec<ElasticOutput> = [h, 2.0 * h]
        .iter()
        .map(|dt| {
            let mut d = drive.clone();
            d.advance(0.1, *dt).unwrap();
            d
        })
        .collect();
    for v in list.0.iter().filter(|v| v.series().is_some()) {
        let series = (v.series().unwrap())(&drive, Seed::Time, v.index);
        let [y0, y1, y2] = [&drive, &ahead[0], &ahead[1]].map(|d| v.value(d));
        assert!((series.0[0] - y0).abs() <= 1e-15 * y0.abs(), "{}", v.description.name);
        // y(h) and y(2h) from the series; the remainder is of third order.
        let scale = y0.abs() + series.derivative(1).abs() / 100.0 + series.derivative(2).abs() / 1e4;
        for (t, y) in [(h, y1), (2.0 * h, y2)] {
            let taylor = series.0[0] + t * (series.0[1] + t * series.0[2]);
            assert!((taylor - y).abs() < 20.0 * (100.0 * t).powi(3) * scale, "{}: {taylor} {y}", v.description.name);
        }
    }
}

/// The drive behind the interface that the FMU uses, with inputs set.
fn erased(drive: &str) -> AnyDrive {
    let mode: DriveMode = serde_json::from_str(drive).unwrap();
    let scene = scene([1.5, 8e3, 7.0], MotionLaw::Fourier(series()), mode, given());
    let model = MODELS.iter().find(|m| m.name == ElasticOutput::MODEL).unwrap();
    (model.build)(&postcard::to_stdvec(&(scene, [0_u8; 0].as_slice())).unwrap()).unwrap()
}

fn reference(drive: &AnyDrive, name: &str) -> usize {
    drive.descriptions().iter().position(|d| d.name == name).unwrap_or_else(|| panic!("no `{name}`"))
}

#[test]
fn dependencies_are_those_that_the_directional_derivatives_show() {
    let mut drive = erased("\"input\"");
    drive.set_up(0.0, None);
    for (name, value) in [("phi", 0.7), ("w", 20.0), ("a", 5.0)] {
        drive.set(reference(&drive, name), value).unwrap();
    }
    drive.start().unwrap();
    drive.advance(0.0, 0.01).unwrap();
    let descriptions = drive.descriptions().to_vec();
    let knowns: Vec<usize> = (0..descriptions.len())
        .filter(|&i| descriptions[i].state || descriptions[i].causality == crate::drives::variable::Causality::Input)
        .collect();
    assert_eq!(knowns.len(), 5);
    for (i, unknown) in descriptions.iter().enumerate() {
        if unknown.causality != crate::drives::variable::Causality::Output {
            continue;
        }
        for &known in &knowns {
            let derivative = drive.directional_derivatives(&[i], &[(known, 1.0)]).unwrap()[0];
            let declared = unknown.dependencies.contains(&descriptions[known].name);
            assert_eq!(derivative != 0.0, declared, "∂{}/∂{}", unknown.name, descriptions[known].name);
        }
    }
}

#[test]
fn absurd_inputs_end_in_a_fault() {
    let _limited = drawn::limit(1e4);
    for derivatives in [[0.0, 1e300, 1.0], [0.0, 0.0, 1e300], [1e300, 1e-300, -1e200], [0.0, 1e12, 1e12]] {
        let mut drive =
            ElasticOutput::new(scene([1.0, 1e4, 0.0], MotionLaw::Fourier(series()), DriveMode::Input, at_rest()))
                .unwrap();
        set_inputs(&mut drive, &derivatives, 0.0);
        let result = drive.start(0.0).and_then(|()| drive.advance(0.0, 1.0));
        let [q, v] = drive.now.q.array();
        assert!(result.is_err() || (q.is_finite() && v.is_finite()), "{derivatives:?}");
    }
}
