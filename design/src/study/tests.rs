//! Measures of whole runs against closed forms.

use super::measure::Measure;
use super::run::{Span, Window};
use super::single::Runner;
use crate::resource::Scene;
use camdrive::drives::follower::load::Load;
use camdrive::drives::rigid_machine::{self, InertiaFunction, MachineStart, Motor};
use camdrive::drives::settings::Settings;
use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use camdrive::drives::{backlash, elastic_output};
use camdrive::motion::{Cycle, CyclePlan, Fourier, MotionLaw, StandardLaw};
use std::f64::consts::{PI, TAU};

/// The measures of a scene, after these variables were set.
fn measured(scene: impl Into<Scene>, window: &Window, texts: &[&str], set: &[(&str, f64)]) -> Result<Vec<f64>, String> {
    let measures: Vec<Measure> = texts.iter().map(|text| Measure::parse(text).unwrap()).collect();
    let mut drive = scene.into().build().unwrap().plan().instance();
    drive.set_up(0.0, None);
    for (name, value) in set {
        let reference = drive.descriptions().iter().position(|d| d.name == *name).unwrap();
        drive.set(reference, *value).unwrap();
    }
    drive.start().unwrap();
    let runner = Runner::new(&drive, window, &measures).map_err(|fault| fault.to_string())?;
    runner.run(&mut drive).map_err(|fault| fault.to_string())
}

fn turns(settle: f64, over: f64, accuracy: f64) -> Window {
    Window { settle: Span::Turns(settle), over: Span::Turns(over), accuracy }
}

const A: f64 = 2e-3;
const W: f64 = 40.0;
const W0: f64 = 130.0;
const D: f64 = 0.07;

/// U = A cos φ before a spring.
fn elastic(mode: StartMode, w: f64) -> elastic_output::Scene {
    let m = 3.0;
    elastic_output::Scene {
        coupling: false,
        parameters: elastic_output::Parameters { m, c: m * W0 * W0, b: 2.0 * D * m * W0 },
        load: Load::default(),
        roller: (0.0, Load::default()),
        cam: MotionLaw::Fourier(Fourier::new(vec![0.0, A], vec![])),
        drive: DriveMode::Constant { w, phi_start: 0.0 },
        start: Start { mode, q: 0.0, q_dot: 0.0 },
        solver: Settings::default(),
    }
}

/// q = Q cos(w t − ψ) of the steady vibration.
fn steady() -> [f64; 2] {
    let eta = W / W0;
    let (x, y) = (1.0 - eta * eta, 2.0 * D * eta);
    let psi = y.atan2(x);
    [A * eta * eta / (x * x + y * y).sqrt(), psi]
}

#[test]
fn a_steady_vibration_has_its_closed_form_at_every_accuracy() {
    let [amplitude, psi] = steady();
    let texts = [
        "max |q|",
        "max q",
        "min q",
        "range q",
        "mean q",
        "rms q",
        "last q",
        "q at 90 deg",
        "q at 0 deg",
        "harmonic 1 of q",
        "harmonic 2 of q",
        "max force",
        "mean phi",
    ];
    for accuracy in [1e-3, 1e-6, 1e-9] {
        for sense in [1.0, -1.0] {
            let found =
                measured(elastic(StartMode::SteadyState, sense * W), &turns(2.0, 3.0, accuracy), &texts, &[]).unwrap();
            let at = |phi: f64| amplitude * (sense * phi - psi).cos();
            let force = 3.0 * W0 * W0 * amplitude * (1.0 + (2.0 * D * W / W0).powi(2)).sqrt();
            let expected = [
                amplitude,
                amplitude,
                -amplitude,
                2.0 * amplitude,
                0.0,
                amplitude / 2.0_f64.sqrt(),
                at(0.0),
                at(0.5 * PI),
                at(0.0),
                amplitude,
                0.0,
                force,
                sense * 3.5 * TAU,
            ];
            for ((text, found), (i, expected)) in texts.iter().zip(&found).zip(expected.iter().enumerate()) {
                let scale = [amplitude, force, 5.0 * TAU][i.saturating_sub(10)];
                assert!(
                    (found - expected).abs() < 2.0 * accuracy.max(1e-12) * scale,
                    "{text} {accuracy} {sense}: {found} {expected}"
                );
            }
        }
    }
}

#[test]
fn a_start_from_rest_is_measured_over_time_as_over_turns() {
    let texts = ["max |q|", "rms q", "mean q", "last y"];
    let by_turns = measured(elastic(StartMode::AtRest, W), &turns(0.0, 4.0, 1e-9), &texts, &[]).unwrap();
    let time = Span::Time(4.0 * TAU / W);
    let by_time = measured(
        elastic(StartMode::AtRest, W),
        &Window { settle: Span::Time(0.0), over: time, accuracy: 1e-9 },
        &texts,
        &[],
    );
    for (a, b) in by_turns.iter().zip(by_time.unwrap()) {
        assert!((a - b).abs() < 1e-11 * A, "{a} {b}");
    }
    // At rest relative to the cam: q(0) = 0, q̇(0) = 0. The free part decays with δ.
    let [amplitude, psi] = steady();
    let (delta, wd) = (D * W0, W0 * (1.0 - D * D).sqrt());
    let (q0, v0) = (-amplitude * psi.cos(), -amplitude * W * psi.sin());
    let q = |t: f64| {
        let free = q0 * (wd * t).cos() + (v0 + delta * q0) / wd * (wd * t).sin();
        amplitude * (W * t - psi).cos() + (-delta * t).exp() * free
    };
    let (n, span) = (200_000, 4.0 * TAU / W);
    let sampled = (0..=n).fold(0.0, |most: f64, i| most.max(q(span * f64::from(i) / f64::from(n)).abs()));
    assert!((by_turns[0] - sampled).abs() < 1e-8 * sampled, "{} {sampled}", by_turns[0]);
    let square = (0..n).map(|i| q(span * (f64::from(i) + 0.5) / f64::from(n)).powi(2)).sum::<f64>() / f64::from(n);
    assert!((by_turns[1] - square.sqrt()).abs() < 1e-8 * sampled, "{} {}", by_turns[1], square.sqrt());
}

#[test]
fn of_whole_turns_the_angle_at_the_end_counts_and_not_that_at_the_beginning() {
    for i in 0..300 {
        for sense in [1.0, -1.0] {
            let w = sense * W * (1.0 + f64::from(i) / 100.0);
            let set = [("drive.phi_start", f64::from(i % 7))];
            let text = format!("phi at {} rad", i % 7);
            let found = measured(elastic(StartMode::AtRest, w), &turns(1.0, 3.0, 1e-6), &[&text], &set).unwrap()[0];
            assert!((found - f64::from(i % 7) - sense * 4.0 * TAU).abs() < 1e-6, "{w}: {found}");
        }
    }
}

#[test]
fn harmonics_of_the_angle_itself_are_those_of_a_saw() {
    let texts = ["harmonic 1 of phi", "harmonic 9 of phi"];
    let found = measured(elastic(StartMode::AtRest, W), &turns(0.0, 100.0, 1e-6), &texts, &[]).unwrap();
    assert!((found[0] - 2.0).abs() < 1e-6 && (found[1] - 2.0 / 9.0).abs() < 1e-6, "{found:?}");
}

#[test]
fn only_ends_take_few_steps_and_parameters_count() {
    let window = Window { settle: Span::Time(0.3), over: Span::Time(0.4), accuracy: 1e-6 };
    let found = measured(elastic(StartMode::SteadyState, W), &window, &["last q"], &[("drive.w", 2.0 * W)]).unwrap();
    let (eta, phi) = (2.0 * W / W0, 2.0 * W * 0.7);
    let (x, y) = (1.0 - eta * eta, 2.0 * D * eta);
    let q = A * eta * eta / (x * x + y * y).sqrt() * (phi - y.atan2(x)).cos();
    assert!((found[0] - q).abs() < 1e-12 * A, "{} {q}", found[0]);
}

/// A wheel of 2 kg·m² under the input M_an.
fn wheel(w_start: f64) -> rigid_machine::Scene {
    rigid_machine::Scene {
        loads: vec![Default::default()],
        inertia: InertiaFunction { constant: 2.0, varying: None },
        followers: Vec::new(),
        motor: Motor::Input,
        phi_start: 0.3,
        w_start,
        start: MachineStart::Given,
        solver: Settings::default(),
    }
}

#[test]
fn turns_end_where_the_shaft_has_made_them() {
    for torque in [5.0, -5.0] {
        let texts = ["last w", "mean w", "max |w|", "w at 0 deg"];
        let found = measured(wheel(0.0), &turns(2.0, 6.0, 1e-9), &texts, &[("M_an", torque)]).unwrap();
        // w² = 2 φ M/J, and the mean speed is the way over the time. Zero degrees are passed last before the end.
        let after = |turns: f64| (TAU * turns * 5.0_f64).sqrt();
        let beyond = if torque > 0.0 { 8.0 - 0.3 / TAU } else { 7.0 + 0.3 / TAU };
        let expected =
            [after(8.0), 0.5 * (after(2.0) + after(8.0)), after(8.0), after(beyond)].map(|w| w * torque.signum());
        for (text, (found, expected)) in texts.iter().zip(found.iter().zip(expected)) {
            let expected = if text.contains('|') { expected.abs() } else { expected };
            assert!((found - expected).abs() < 1e-8 * expected.abs(), "{text} {torque}: {found} {expected}");
        }
    }
    // Until it is settled the angle alone is followed, in long steps.
    let stands = measured(wheel(0.0), &turns(1.0, 1.0, 1e-6), &["max w"], &[]).unwrap_err();
    assert!(stands.contains("has not made its turns (1)"), "{stands}");
}

/// A cycle with rests, whose acceleration jumps where the rise is a simple sine.
fn cycle(rise: StandardLaw) -> MotionLaw {
    MotionLaw::Cycle(Cycle::new(CyclePlan {
        lower: 0.0,
        stroke: 0.02,
        rise_start: 0.4,
        rise_angle: 1.2,
        upper_dwell: 1.0,
        return_angle: 1.4,
        rise_law: rise,
        return_law: rise,
        inflections: [None, None],
    }))
}

fn clearance(rise: StandardLaw, s: f64) -> backlash::Scene {
    backlash::Scene {
        coupling: false,
        parameters: backlash::Parameters { m1: 0.03, m2: 0.2, c: 4000.0, b: 3.0, s, e: 0.2 },
        cam: cycle(rise),
        drive: DriveMode::Constant { w: 60.0, phi_start: 0.0 },
        start: Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 },
        solver: Settings::default(),
    }
}

#[test]
fn impacts_are_points_and_momentum_is_kept() {
    for rise in [StandardLaw::InclinedSine, StandardLaw::SimpleSine] {
        let texts = [
            "mean force_mean",
            "count impacts",
            "last impacts",
            "min gap",
            "max gap",
            "count impulse",
            "mean force",
            "last der(x1)",
            "last der(y)",
            "mean contact",
            "max contact",
            "min contact",
        ];
        let window = Window { settle: Span::Time(0.0), over: Span::Time(0.777), accuracy: 1e-8 };
        let found = measured(clearance(rise, 4e-4), &window, &texts, &[]).unwrap();
        // All impulses of the drive are the momentum of both masses.
        let momentum = 0.03 * found[7] + 0.2 * found[8];
        let scale = 0.2 * 60.0 * 0.02;
        assert!((found[0] * 0.777 - momentum).abs() < 1e-8 * scale, "{found:?}");
        assert!((found[5] + found[6] * 0.777 - momentum).abs() < 1e-6 * scale, "{found:?} {momentum}");
        assert!(found[1] > 10.0 && found[1] == found[2], "{found:?}");
        // Between the flanks, to rounding.
        assert!(found[3].abs() < 1e-9 && (found[4] - 4e-4).abs() < 1e-9, "{found:?}");
        assert_eq!((found[10], found[11]), (1.0, -1.0));
        assert!(found[9].abs() < 1.0);
    }
}

#[test]
fn jumps_of_an_acceleration_are_seen_from_both_sides() {
    // The roller's acceleration of a simple sine begins with ½ S (π/β)² ω².
    let found = measured(
        clearance(StandardLaw::SimpleSine, 0.0),
        &turns(1.0, 2.0, 1e-6),
        &["max der(x1,2)", "min der(x1,2)"],
        &[],
    );
    let largest = 0.5 * 0.02 * (PI / 1.2 * 60.0).powi(2);
    let found = found.unwrap();
    assert!((found[0] / largest - 1.0).abs() < 1e-4 && (found[1] / largest + 1.0).abs() < 1e-4, "{found:?} {largest}");
}

#[test]
fn what_cannot_be_measured_is_told() {
    let window = turns(0.0, 1.0, 1e-6);
    for (text, said) in [
        ("max qq", "no output `qq`"),
        ("max m", "is set, not computed"),
        ("max solver.steps", "has no course"),
        ("last solver.steps", ""),
    ] {
        let found = measured(elastic(StartMode::AtRest, W), &window, &[text], &[]);
        assert!(found.as_ref().err().map_or(said.is_empty(), |message| message.contains(said)), "{text}: {found:?}");
    }
    let mean = measured(clearance(StandardLaw::InclinedSine, 1e-4), &window, &["max tau_mean"], &[]).unwrap_err();
    assert!(mean.contains("use `mean tau_mean`"), "{mean}");
    let short = Window { settle: Span::Time(0.0), over: Span::Time(0.01), accuracy: 1e-6 };
    let never = measured(elastic(StartMode::AtRest, W), &short, &["q at 180 deg"], &[]).unwrap_err();
    assert!(never.contains("does not pass this angle"), "{never}");
}

#[test]
fn what_a_drive_holds_is_read_in_any_order() {
    let machine = rigid_machine::Scene { w_start: 20.0, motor: Motor::None, ..wheel(20.0) };
    let scenes: [Scene; 3] =
        [elastic(StartMode::AtRest, W).into(), clearance(StandardLaw::SimpleSine, 4e-4).into(), machine.into()];
    for scene in scenes {
        let mut drive = scene.build().unwrap().plan().instance();
        drive.set_up(0.0, None);
        drive.start().unwrap();
        let states: Vec<usize> = (0..drive.descriptions().len()).filter(|i| drive.descriptions()[*i].state).collect();
        let mut time = 0.0;
        for _ in 0..100 {
            drive.advance(time, 1.3e-3).unwrap();
            time += 1.3e-3;
            let (held, _) = drive.held().unwrap();
            let whole = (held - time).min(1e-3);
            if whole <= 0.0 {
                continue;
            }
            let mut at = |from: f64, to: f64| {
                drive.advance(time + from * whole, (to - from) * whole).unwrap();
                states.iter().map(|state| drive.get(*state).unwrap()).collect::<Vec<f64>>()
            };
            // Instants are sums, which are rounded.
            let near = |a: Vec<f64>, b: Vec<f64>| {
                let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-12 * b.abs().max(1.0);
                assert!(a.iter().zip(&b).all(near), "{a:?} {b:?}");
            };
            let (middle, end) = (at(0.0, 0.25), at(0.25, 0.875));
            near(at(0.875, 0.25), middle);
            near(at(0.25, 0.875), end);
            time += 0.875 * whole;
        }
    }
}
