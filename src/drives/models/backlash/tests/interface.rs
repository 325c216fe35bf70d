//! Communication steps, inputs, derivatives, saved states and refusals.

use super::*;
use crate::drives::Seed;
use crate::drives::variable::Causality;
use crate::motion::{Cycle, CyclePlan, StandardLaw};
use std::f64::consts::TAU;

/// Runs to `end` in steps of `h`; events, and the sum of force_mean h.
pub fn march(
    drive: &mut BacklashDrive,
    end: f64,
    h: f64,
    mut inputs: impl FnMut(&mut BacklashDrive, f64),
) -> (Vec<Event>, f64) {
    let (mut events, mut impulse) = (Vec::new(), 0.0);
    let steps = (end / h).round() as usize;
    for step in 0..steps {
        let t = end * step as f64 / steps as f64;
        let next = end * (step + 1) as f64 / steps as f64;
        inputs(drive, t);
        drive.advance(t, next - t).unwrap();
        impulse += drive.mean()[0] * (next - t);
        events.extend(drive.log.iter().copied());
        assert_eq!(drive.log.dropped(), 0);
        drive.log.clear();
    }
    (events, impulse)
}

#[test]
fn the_communication_step_does_not_show() {
    for e in [0.0, 0.5] {
        let run = |end: f64, h: f64| {
            let mut drive = started(scene(50.0, 3e-4, 60.0, e));
            let (events, impulse) = march(&mut drive, end, h, |_, _| ());
            (drive, events, impulse)
        };
        let (fine, expected, impulse) = run(0.05, 1e-6);
        for h in [1e-4, 0.01, 0.05] {
            let (drive, events, other) = run(0.05, h);
            assert!(events.iter().zip(&expected).all(|(a, b)| a == b) && events.len() == expected.len());
            assert!((drive.now.point.state.q[0] - fine.now.point.state.q[0]).abs() <= 1e-18);
            assert!((other - impulse).abs() < 1e-12, "{other} {impulse}");
        }
        let ten = 10.0 * TAU / 50.0;
        let (fine, ..) = run(ten, 1e-3);
        let mut coarse = started(scene(50.0, 3e-4, 60.0, e));
        coarse.advance(0.0, ten).unwrap();
        assert_eq!(coarse.now.tally.impacts, fine.now.tally.impacts);
        assert!((coarse.now.point.state.q[0] - fine.now.point.state.q[0]).abs() < 1e-16);
        assert!((coarse.now.tally.impulse - fine.now.tally.impulse).abs() < 1e-12);
    }
}

/// The drive with inputs φ = 50 t + ½ a t².
pub fn with_inputs(e: f64) -> BacklashDrive {
    let mut scene = scene(50.0, 3e-4, 60.0, e);
    scene.drive = DriveMode::Input;
    let mut drive = BacklashDrive::new(scene).unwrap();
    ramp(0.0)(&mut drive, 0.0);
    drive.start(0.0).unwrap();
    drive
}

pub fn set(drive: &mut BacklashDrive, phi: f64, w: f64, a: f64) {
    let variables = drive.variables().0;
    for (reference, value) in [phi, w, a].into_iter().enumerate() {
        variables[reference].set(drive, value);
    }
}

pub fn ramp(a: f64) -> impl FnMut(&mut BacklashDrive, f64) {
    move |drive, t| set(drive, 50.0 * t + 0.5 * a * t * t, 50.0 + a * t, a)
}

#[test]
fn inputs_that_run_uniformly_are_the_constant_speed() {
    let mut constant = started(scene(50.0, 3e-4, 60.0, 0.0));
    let (expected, _) = march(&mut constant, 0.1, 0.1, |_, _| ());
    for h in [1e-4, 1e-2, 0.1] {
        let mut drive = with_inputs(0.0);
        let (events, _) = march(&mut drive, 0.1, h, ramp(0.0));
        assert_eq!(events.len(), expected.len(), "{events:?} {expected:?}");
        let [lost, other] = [&drive, &constant].map(|d| d.damping_loss());
        assert!((lost - other).abs() < 1e-10 * other && other > 0.0, "{lost} {other}");
        for (one, other) in events.iter().zip(&expected) {
            assert_eq!(one.kind, other.kind);
            assert!((one.time - other.time).abs() < 1e-12, "{one:?} {other:?}");
        }
    }
}

#[test]
fn a_ramp_of_the_speed_is_the_same_in_any_communication_step() {
    let (expected, impulse) = march(&mut with_inputs(0.0), 0.1, 0.1, ramp(300.0));
    assert!(expected.len() > 6);
    for h in [1e-4, 1e-3, 1e-2] {
        let (events, other) = march(&mut with_inputs(0.0), 0.1, h, ramp(300.0));
        assert_eq!(events.len(), expected.len());
        for (one, other) in events.iter().zip(&expected) {
            assert!(one.kind == other.kind && (one.time - other.time).abs() < 1e-12, "{one:?} {other:?}");
        }
        assert!((impulse - other).abs() < 1e-11, "{impulse} {other}");
    }
}

#[test]
fn a_jump_of_the_inputs_moves_no_free_mass_and_pushes_one_on_a_flank() {
    let place = |d: &BacklashDrive| {
        let [x, v] = d.now.point.place();
        [x, v, x + d.now.point.state.q[0], v + d.now.point.state.q[1]]
    };
    for (time, contact) in [(0.02, true), (0.04, false)] {
        let mut drive = with_inputs(0.0);
        march(&mut drive, time, 1e-3, ramp(0.0));
        assert_eq!(drive.now.mode != Mode::Free, contact);
        let before = place(&drive);
        let tally = drive.now.tally;
        // 2 µm at most, so that the free mass stays between the flanks.
        for jump in [2e-4, 1e-4] {
            set(&mut drive, 50.0 * time + jump, 50.02, 0.0);
            drive.apply(time).unwrap();
        }
        let after = place(&drive);
        let moved = if contact { 2 } else { 0 };
        for n in moved..4 {
            assert!((after[n] - before[n]).abs() < 1e-16 + 1e-15 * before[n].abs(), "{n}: {} {}", after[n], before[n]);
        }
        let push = drive.now.tally.impulse - tally.impulse;
        let expected = if contact { drive.parameters.m1 * (after[1] - before[1]) } else { 0.0 };
        assert!((push - expected).abs() < 1e-16 && (contact == (push != 0.0)));
        // The jump that apply shows is taken up by advance once.
        let shown = drive.now.tally.impulse;
        drive.advance(time, 1e-9).unwrap();
        assert_eq!(drive.now.tally.impulse, shown);
    }
}

#[test]
fn a_drive_at_rest_stays_at_rest() {
    let mut drive = with_inputs(0.0);
    set(&mut drive, 0.3, 0.0, 0.0);
    drive.start(0.0).unwrap();
    let begin = drive.now.point;
    for step in 0..10 {
        drive.advance(f64::from(step) * 1e-2, 1e-2).unwrap();
    }
    assert_eq!((drive.now.point, drive.now.tally.impacts), (begin, 0.0));
}

#[test]
fn a_mass_that_a_jump_puts_beyond_a_flank_is_set_on_it() {
    let mut drive = with_inputs(0.0);
    march(&mut drive, 0.04, 1e-3, ramp(0.0));
    let m2 =
        drive.now.point.u[0] + drive.now.point.state.home + drive.now.point.state.zeta[0] + drive.now.point.state.q[0];
    set(&mut drive, 2.3, 50.0, 0.0);
    drive.apply(0.04).unwrap();
    let z = drive.now.point.state.home + drive.now.point.state.zeta[0];
    assert!(z == 0.0 || z == drive.parameters.s);
    assert!((drive.now.point.u[0] + z + drive.now.point.state.q[0] - m2).abs() < 1e-16);
    drive.advance(0.04, 1e-3).unwrap();
}

#[test]
fn time_derivatives_are_those_of_the_values() {
    // In contact and in flight.
    for time in [0.02, 0.04] {
        let mut drive = started(scene(50.0, 3e-4, 60.0, 0.0));
        drive.advance(0.0, time).unwrap();
        let h = 1e-6;
        let mut later = drive.clone();
        later.advance(time, h).unwrap();
        for v in drive.variables().0 {
            let Some(series) = v.series() else { continue };
            let series = series(&drive, Seed::Time, v.index);
            let (now, next) = (v.value(&drive), v.value(&later));
            let predicted = now + h * series.derivative(1) + 0.5 * h * h * series.derivative(2);
            // What remains is h³/6 of the third derivative: rates are about 1000 rad/s.
            let [d1, d2] = [1, 2].map(|order| series.derivative(order).abs());
            let allowed = h * h * h * (1e3 * d2 + 1e6 * d1) + 1e-15 * now.abs();
            assert!((predicted - next).abs() <= allowed, "{} at {time}: {predicted} {next}", v.description.name);
            assert_eq!(series.0[0], now, "{}", v.description.name);
        }
    }
}

#[test]
fn directional_derivatives_are_those_of_the_inputs() {
    for time in [0.02, 0.04] {
        let mut drive = with_inputs(0.0);
        march(&mut drive, time, 1e-3, ramp(0.0));
        let base = [50.0 * time, 50.0, 0.0];
        for input in 0..3 {
            let delta = [1e-6, 1e-4, 1.0][input];
            let at = |sign: f64| {
                let mut d = drive.clone();
                let mut values = base;
                values[input] += sign * delta;
                set(&mut d, values[0], values[1], values[2]);
                d.apply(time).unwrap();
                d
            };
            let (plus, minus, middle) = (at(1.0), at(-1.0), at(0.0));
            for v in drive.variables().0 {
                let Some(series) = v.series() else { continue };
                let exact = series(&middle, Seed::Known(["phi", "w", "a"][input]), v.index).0[1];
                let (high, low) = (v.value(&plus), v.value(&minus));
                let slope = (high - low) / (2.0 * delta);
                let name = &v.description.name;
                let rounding = 1e-15 * high.abs() / delta;
                assert!((exact - slope).abs() <= 1e-6 * slope.abs() + rounding, "∂{name}/∂{input}: {exact} {slope}");
                let known = ["phi", "w", "a"][input].to_owned();
                assert!(exact == 0.0 || v.description.dependencies.contains(&known), "{name} depends on {known}");
            }
        }
    }
}

#[test]
fn what_a_jump_of_the_inputs_strikes_has_its_derivatives() {
    for e in [0.0, 0.5] {
        let mut drive = with_inputs(e);
        march(&mut drive, 0.04, 1e-3, ramp(0.0));
        assert_eq!(drive.now.mode, Mode::Free);
        // Flank B, 0.3 mm above flank A, jumps down past m1.
        let phi = 2.0 - 1e-3 / drive.cam.law.at(2.0).0[1];
        for (input, delta) in [1e-6, 1e-4, 1.0].into_iter().enumerate() {
            let [minus, middle, plus] = [-delta, 0.0, delta].map(|change| {
                let mut values = [phi, 50.0, 0.0];
                values[input] += change;
                let mut drive = drive.clone();
                set(&mut drive, values[0], values[1], values[2]);
                drive.apply(0.04).unwrap();
                drive
            });
            assert_eq!(middle.now.tally.impacts, drive.now.tally.impacts + 1.0);
            for v in drive.variables().0.iter().filter(|v| ["impulse", "energy_loss"].contains(&&*v.description.name)) {
                let exact = v.series().unwrap()(&middle, Seed::Known(["phi", "w", "a"][input]), v.index).0[1];
                let slope = (v.value(&plus) - v.value(&minus)) / (2.0 * delta);
                let rounding = 1e-15 * v.value(&middle).abs() / delta;
                let name = &v.description.name;
                assert!((exact - slope).abs() <= 1e-6 * slope.abs() + rounding, "∂{name}/∂{input}: {exact} {slope}");
                assert_eq!(exact != 0.0, input < 2, "∂{name}/∂{input}: {exact}");
            }
        }
    }
}

#[test]
fn the_steady_state_repeats_every_turn() {
    let mut scene = scene(50.0, 2e-4, 240.0, 0.0);
    scene.start.mode = StartMode::SteadyState;
    let mut drive = started(scene);
    let begin = drive.now;
    let period = TAU / 50.0;
    for turn in 0..5 {
        drive.advance(f64::from(turn) * period, period).unwrap();
        assert_eq!(drive.now.mode, begin.mode);
        assert!((drive.now.point.state.q[0] - begin.point.state.q[0]).abs() < 1e-14);
        // ∮ F_K dt + ΣP = 0.
        assert!(drive.mean()[0].abs() < 1e-9, "{}", drive.mean()[0]);
    }
    assert!(drive.now.tally.impacts >= 10.0);
}

#[test]
fn the_balance_of_energy_closes_in_every_step() {
    for (w, s, b, e) in
        [(50.0, 2e-4, 0.0, 0.0), (47.0, 3e-4, 60.0, 0.5), (-50.0, 2e-4, 240.0, 0.0), (31.0, 0.0, 10.0, 0.0)]
    {
        let mut drive = started(scene(w, s, b, e));
        let (mut before, mut lost) = (energy(&drive), 0.0);
        for step in 0..200 {
            let h = 1.7e-3;
            drive.advance(f64::from(step) * h, h).unwrap();
            let (after, loss) = (energy(&drive), drive.now.tally.energy_loss + drive.damping_loss());
            let work = drive.mean()[1] * h * w;
            let missing = (after - before + loss - lost - work).abs();
            assert!(missing < 1e-9 * after.max(before).max(work.abs()), "{w} {s} {b} {e} at step {step}: {missing:e}");
            (before, lost) = (after, loss);
        }
    }
}

#[test]
fn the_balance_of_energy_closes_through_the_dwells_of_a_stiff_drive() {
    // In the dwells the motion dies away to a millionth within a hundredth of the turn: what is missing is a part of the
    // energy that drive and mass have exchanged.
    let w = 493.0;
    let law = StandardLaw::Polynomial345;
    let cycle = CyclePlan {
        stroke: 0.0273,
        lower: -0.0031,
        rise_start: -0.03,
        rise_angle: 1.457,
        upper_dwell: 1.944,
        return_angle: 1.096,
        rise_law: law,
        return_law: law,
        inflections: [None; 2],
    };
    let mut drive = started(Scene {
        coupling: false,
        cam: MotionLaw::Cycle(Cycle::new(cycle)),
        drive: DriveMode::Constant { w, phi_start: -3.03 },
        parameters: Parameters { m1: 0.151, m2: 2.08, c: 3.37e9, b: 2.6e5, s: 2.7e-8, e: 0.0 },
        start: Start { mode: StartMode::Given, q: -8.1e-6, q_dot: -0.158 },
        solver: Settings::default(),
    });
    let before = energy(&drive);
    let (mut work, mut exchanged) = (0.0, before);
    let h = TAU / w / 100.0;
    for step in 0..300 {
        drive.advance(f64::from(step) * h, h).unwrap();
        let part = drive.mean()[1] * h * w;
        let lost = drive.now.tally.energy_loss + drive.damping_loss();
        (work, exchanged) = (work + part, exchanged + part.abs());
        let missing = (energy(&drive) - before + lost - work).abs();
        assert!(missing < 1e-13 * exchanged, "step {step}: {missing:e} of {exchanged:e}");
    }
}

#[test]
fn what_has_no_periodic_solution_is_refused() {
    let refused = |change: fn(&mut Scene)| {
        let mut scene = scene(47.0, 3e-4, 0.0, 1.0);
        scene.start.mode = StartMode::SteadyState;
        change(&mut scene);
        BacklashDrive::new(scene).unwrap().start(0.0).unwrap_err().to_string()
    };
    assert!(refused(|_| ()).contains("does not repeat"));
    let resonant = refused(|s| (s.parameters.s, s.drive) = (0.0, DriveMode::Constant { w: 250.0, phi_start: 0.0 }));
    assert!(resonant.contains("natural frequency"));
    // A harmonic that the law lacks excites nothing: q is the response to the others, m2 q̈ = −c q − m2 ü.
    let mut scene = scene(100.0, 0.0, 0.0, 0.0);
    scene.start.mode = StartMode::SteadyState;
    scene.cam = MotionLaw::Fourier(Fourier::new(vec![0.0, -0.01], vec![0.0, 0.004]));
    let omega = (scene.parameters.c / scene.parameters.m2).sqrt();
    assert_eq!(omega / 100.0, 5.0);
    let factor = 1.0 / (omega * omega / 1e4 - 1.0);
    let [q, q_dot] = started(scene).now.point.state.q;
    assert!((q + 0.01 * factor).abs() < 1e-15 && (q_dot - 0.4 * factor).abs() < 1e-13, "{q} {q_dot}");
    assert!(refused(|s| s.drive = DriveMode::Input).contains("constant speed"));
}

#[test]
fn a_restored_state_goes_on_bit_by_bit() {
    let mut drive = started(scene(50.0, 3e-4, 60.0, 0.5));
    let made = drive.clone();
    drive.advance(0.0, 0.0437).unwrap();
    let bytes = postcard::to_stdvec(&drive).unwrap();
    let mut restored: BacklashDrive = postcard::from_bytes(&bytes).unwrap();
    restored.restored(&made).unwrap();
    drive.advance(0.0437, 0.1).unwrap();
    restored.advance(0.0437, 0.1).unwrap();
    assert_eq!(drive.now, restored.now);
}

#[test]
fn every_state_has_its_derivative_and_every_dependency_exists() {
    for drive in [with_inputs(0.0), started(scene(50.0, 3e-4, 60.0, 0.5))] {
        let variables = drive.variables().0;
        let names: Vec<&str> = variables.iter().map(|v| v.description.name.as_str()).collect();
        for v in &variables {
            let d = &v.description;
            if d.state {
                assert!(
                    variables.iter().any(|o| o.description.derivative_of.as_deref() == Some(&d.name)),
                    "{}",
                    d.name
                );
            }
            for name in &d.dependencies {
                assert!(names.contains(&name.as_str()), "{name}");
            }
            assert!(d.causality != Causality::Output || d.name.len() <= 40);
        }
        let first = if drive.cam.is_input() { 3 } else { 2 };
        assert_eq!(&names[first..first + 4], &["x1", "der(x1)", "y", "der(y)"]);
        assert!(drive.experiment().step > 0.0);
    }
}
