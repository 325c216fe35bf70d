//! Physics of the elastic shaft.

pub(in crate::drives) mod extremes;
mod fixed_cost;
mod light_cams;
mod loads;
mod passages;

use super::*;
use crate::drives::settings::Method;
use crate::drives::shaft::cam_drive::StartMode;
use crate::drives::{AnyDrive, Model, Seed};
use crate::motion::{Cycle, CyclePlan, Fourier, StandardLaw};
use crate::numerics::angle::WHOLE_TURN;
use crate::numerics::collocation::Collocation;
use crate::numerics::double_double::Double;
use crate::numerics::gauss::Gauss;

/// The transfer manipulator of the sources: 60 kg, stroke 0.4 m, J = 1.5 kg·m², c = 2.4e4 N·m/rad, damping ratio 0.03.
fn manipulator(law: MotionLaw, linear: bool, drive: DriveMode) -> Scene {
    Scene {
        load: Load::default(),
        parameters: Parameters { m: 60.0, inertia: 1.5, c: 2.4e4, b: 17.85 },
        linear,
        cam: law,
        drive,
        start: Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 },
        solver: Settings::default(),
    }
}

/// A harmonic profile with a₁ = 0.57 · 0.4 m, a₃ = −0.07 · 0.4 m.
fn profile() -> MotionLaw {
    MotionLaw::Fourier(Fourier::new(vec![0.0, 0.4 * 0.57, 0.0, 0.4 * -0.07], vec![]))
}

const CONSTANT: DriveMode = DriveMode::Constant { w: 4.84, phi_start: 0.3 };

fn started(scene: Scene) -> ElasticShaft {
    let mut drive = ElasticShaft::new(scene).unwrap();
    drive.start(0.0).unwrap();
    drive
}

fn boxed(scene: &Scene) -> AnyDrive {
    (Model::of::<ElasticShaft>().build)(&postcard::to_stdvec(&(scene, [0_u8; 0].as_slice())).unwrap()).unwrap()
}

/// Runs to `end` in `steps` equal communication steps.
fn run(drive: &mut ElasticShaft, end: f64, steps: i32) {
    for n in 0..steps {
        let time = end * f64::from(n) / f64::from(steps);
        drive.advance(time, end * f64::from(n + 1) / f64::from(steps) - time).unwrap();
    }
}

/// (q, q̇) from rest, by Gragg–Bulirsch–Stoer extrapolation of order 20 in 80-bit arithmetic, two step lengths of
/// which agree to 1e-16.
const AFTER_1: [[f64; 2]; 2] =
    [[4.58042000296982723e-3, -3.00642839744775589e-2], [4.59449657198562399e-3, -2.97580207514891044e-2]];
const AFTER_20: [[f64; 2]; 2] =
    [[-1.32583313153900912e-4, -1.61887062446981103e-2], [-1.22342897288143362e-4, -1.64869121104192598e-2]];

#[test]
fn the_twist_at_constant_speed_meets_an_independent_integration() {
    for linear in [false, true] {
        // Relative to the largest q, 6e-3, and q̇, 0.3, after 1 s and after 20 s, fifteen turns.
        for steps in [1, 7, 1000, 100_000] {
            let mut drive = started(manipulator(profile(), linear, CONSTANT));
            run(&mut drive, 1.0, steps);
            let error = drive.state[0] - AFTER_1[usize::from(linear)][0];
            assert!(error.abs() < 1e-13, "linear {linear}, {steps} steps, q: {error:e}");
            let error = drive.state[1] - AFTER_1[usize::from(linear)][1];
            assert!(error.abs() < 1e-11, "linear {linear}, {steps} steps, q̇: {error:e}");
        }
        let mut drive = started(manipulator(profile(), linear, CONSTANT));
        run(&mut drive, 20.0, 333);
        let error = drive.state[0] - AFTER_20[usize::from(linear)][0];
        assert!(error.abs() < 1e-13, "linear {linear}, 20 s, q: {error:e}");
    }
}

#[test]
fn breakpoints_of_the_law_are_met() {
    // The 3-4-5 polynomial, from rest at φ = 0.3 for 5 s, almost four turns; the same reference method between the breakpoints, at
    // which ψ arrives by Newton's method.
    let after_5 =
        [[1.04961576766690985e-3, -1.19630783057927757e-2], [1.01217181841035232e-3, -3.37018828241425343e-3]];
    for linear in [false, true] {
        for steps in [1, 4000] {
            let mut drive = started(manipulator(cycle(StandardLaw::Polynomial345), linear, CONSTANT));
            run(&mut drive, 5.0, steps);
            let expected = after_5[usize::from(linear)];
            let error = [drive.state[0] - expected[0], drive.state[1] - expected[1]];
            assert!(error[0].abs() < 1e-13 && error[1].abs() < 1e-11, "linear {linear}, {steps} steps: {error:?}");
        }
    }
}

#[test]
fn the_tolerance_buys_accuracy_in_proportion() {
    let mut last = 1.0;
    for tolerance in [1e-5, 1e-7, 1e-9, 1e-11] {
        let mut scene = manipulator(profile(), false, CONSTANT);
        scene.solver.tolerance = tolerance;
        let mut drive = started(scene);
        run(&mut drive, 1.0, 1);
        let error = (drive.state[0] - AFTER_1[0][0]).abs() / 6e-3;
        assert!(error < tolerance && error < last, "{tolerance:e}: {error:e}");
        last = error;
    }
}

fn ramp(linear: bool) -> ElasticShaft {
    let mut drive = ElasticShaft::new(manipulator(profile(), linear, DriveMode::Input)).unwrap();
    set_inputs(&mut drive, 0.0);
    drive.start(0.0).unwrap();
    drive
}

/// φ = 0.3 + t + 2 t².
fn set_inputs(drive: &mut ElasticShaft, t: f64) {
    let variables = drive.variables().0;
    for (variable, value) in variables.iter().zip([0.3 + t + 2.0 * t * t, 1.0 + 4.0 * t, 4.0]) {
        variable.set(drive, value);
    }
}

#[test]
fn the_twist_on_a_ramp_meets_an_independent_integration() {
    // From rest along φ = 0.3 + t + 2 t²; the same reference method.
    let after_1 =
        [[-2.54586940460138527e-4, 1.24957691610632392e-3], [-2.54841904663006278e-4, 1.21449168780404736e-3]];
    for linear in [false, true] {
        for steps in [1, 10, 1000] {
            let mut drive = ramp(linear);
            for n in 0..steps {
                let t = f64::from(n) / f64::from(steps);
                set_inputs(&mut drive, t);
                drive.advance(t, f64::from(n + 1) / f64::from(steps) - t).unwrap();
            }
            let expected = after_1[usize::from(linear)];
            let error = [drive.state[0] - expected[0], drive.state[1] - expected[1]];
            assert!(error[0].abs() < 1e-13 && error[1].abs() < 1e-11, "linear {linear}, {steps} steps: {error:?}");
        }
    }
}

#[test]
fn the_rounding_of_large_angles_is_no_jump() {
    let (phi, w) = (1e5, 4.84);
    for linear in [false, true] {
        let mut expected = started(manipulator(profile(), linear, DriveMode::Constant { w, phi_start: phi }));
        run(&mut expected, 2.0, 1);
        let mut drive = ElasticShaft::new(manipulator(profile(), linear, DriveMode::Input)).unwrap();
        drive.cam.set_inputs([phi, w, 0.0]);
        drive.start(0.0).unwrap();
        for n in 0..2000 {
            let time = 1e-3 * f64::from(n);
            // The last place of φ is 1.5e-11 rad, of a twist of 6e-3 rad.
            drive.cam.set_inputs([phi + w * time, w, 0.0]);
            drive.apply(time).unwrap();
            drive.advance(time, 1e-3 * f64::from(n + 1) - time).unwrap();
        }
        for (i, size) in [6e-3, 0.3].into_iter().enumerate() {
            let error = (drive.state[i] - expected.state[i]).abs();
            assert!(error < 1e-10 * size, "linear {linear}, {i}: {error:e}");
        }
    }
}

#[test]
fn where_inputs_jump_the_cam_keeps_angle_and_speed() {
    for linear in [false, true] {
        let mut drive = ramp(linear);
        drive.advance(0.0, 0.25).unwrap();
        let psi = drive.before[0] + drive.state[0];
        let speed = drive.before[1] + drive.state[1];
        let variables = drive.variables().0;
        variables[0].set(&mut drive, 0.1);
        variables[1].set(&mut drive, -2.0);
        for _ in 0..3 {
            drive.apply(0.25).unwrap();
            assert!((0.1 + drive.state[0] - psi).abs() < 1e-15 && (-2.0 + drive.state[1] - speed).abs() < 1e-14);
        }
        // Inputs held over a further step restart from the held values.
        drive.advance(0.25, 0.01).unwrap();
        let end = drive.before[0] + drive.state[0];
        drive.advance(0.26, 1e-9).unwrap();
        assert!((drive.before[0] + drive.state[0] - end).abs() < 1e-6);
    }
}

/// (J + m U′²) ψ̇²/2 + c q²/2.
fn stored_energy(drive: &ElasticShaft) -> f64 {
    let shaft = drive.motion.at(drive.time);
    let [q, v] = drive.state;
    let u1 = drive.cam.law.at(shaft.reduced + q).0[1];
    let speed = shaft.kinematics.0[1] + v;
    0.5 * (drive.equation.parameters.inertia + drive.equation.parameters.m * u1 * u1) * speed * speed
        + 0.5 * drive.equation.parameters.c * q * q
}

#[test]
fn the_energy_balance_closes() {
    // ∫ (tau ω − b q̇²) dt over 20 s, in panels of some 4 rad of the vibration.
    let missed = |solver: Settings| {
        let mut drive = started(Scene { solver, ..manipulator(profile(), false, CONSTANT) });
        let before = stored_energy(&drive);
        let (mut work, mut exchanged) = (0.0, before);
        for panel in 0..640 {
            let (start, length) = (f64::from(panel) / 32.0, 1.0 / 32.0);
            let [part, size] = Gauss::with(16).integrate(length, |s| {
                let mut there = drive.clone();
                there.advance(start, s).unwrap();
                let [q, v] = there.state;
                let power = -(there.equation.parameters.c * q + there.equation.parameters.b * v) * 4.84
                    - there.equation.parameters.b * v * v;
                [power, power.abs()]
            });
            drive.advance(start, length).unwrap();
            (work, exchanged) = (work + part, exchanged + size);
        }
        (stored_energy(&drive) - before - work).abs() / exchanged
    };
    let fine = missed(Settings::default());
    assert!(fine < 1e-13, "{fine:e}");
    let coarse = missed(Settings { method: Method::FixedCost, step_size: 0.03, ..Settings::default() });
    assert!(100.0 * fine < coarse && coarse < 1e-4, "{coarse:e} against {fine:e}");
}

/// M of the turn map of the linear equation, (q, q̇) ↦ M (q, q̇) + shift, by the integrator.
fn monodromy_of(scene: Scene, w: f64) -> [[f64; 2]; 2] {
    let mut drive = started(scene);
    let (moving, _) = drive.moving();
    let [first, second, shift] = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]].map(|y| {
        let mut integrator = Collocation::new(Double::default(), y);
        integrator.advance(&moving, WHOLE_TURN.divide(Double::from(w.abs())), 1e-12).unwrap();
        integrator.state()
    });
    [0, 1].map(|i| [first[i] - shift[i], second[i] - shift[i]])
}

#[test]
fn the_determinant_of_the_turn_map_is_that_of_the_damping() {
    // J W exp(∫ b/J dt) is constant (W the Wronskian), so det M = exp(−∮ b/J dt) over a turn.
    for (w, b) in [(4.84, 17.85), (-4.84, 17.85), (30.0, 5.0), (80.0, 0.0)] {
        let mut scene = manipulator(profile(), true, DriveMode::Constant { w, phi_start: 0.3 });
        scene.parameters.b = b;
        let n = 4096;
        let sum: f64 = (0..n)
            .map(|i| {
                let u1 = profile().at(std::f64::consts::TAU * f64::from(i) / f64::from(n)).0[1];
                b / (1.5 + 60.0 * u1 * u1)
            })
            .sum();
        let expected = (-sum / f64::from(n) * std::f64::consts::TAU / w.abs()).exp();
        let [[a, b], [c, d]] = monodromy_of(scene, w);
        // M's entries differ by the natural frequency, so the products carry the rounding.
        let error = (a * d - b * c - expected).abs();
        assert!(error < 1e-11, "w = {w}: {error:e}");
    }
}

#[test]
fn steady_state_is_periodic_and_half_a_turn_symmetric() {
    for linear in [false, true] {
        let mut scene = manipulator(profile(), linear, CONSTANT);
        scene.start.mode = StartMode::SteadyState;
        let mut drive = started(scene);
        let first = drive.state;
        let turn = std::f64::consts::TAU / 4.84;
        // The law has only odd harmonics, so U′U″ has half the period.
        for n in 0..20 {
            drive.advance(0.5 * turn * f64::from(n), 0.5 * turn).unwrap();
            let error = [drive.state[0] - first[0], drive.state[1] - first[1]];
            assert!(error[0].abs() < 1e-12 && error[1].abs() < 1e-10, "linear {linear}, {n}: {error:?}");
        }
    }
}

#[test]
fn a_small_load_makes_the_nonlinear_equation_linear() {
    // q ~ ω². The linear equation neglects terms of the order m ω² q² ~ ω⁶; relative to c q ~ ω² that is ω⁴.
    let difference = |w: f64| {
        let steady = |linear| {
            let mut scene = manipulator(profile(), linear, DriveMode::Constant { w, phi_start: 0.9 });
            scene.start.mode = StartMode::SteadyState;
            started(scene).state[0]
        };
        (steady(false) - steady(true)).abs() / steady(true).abs()
    };
    let (fast, slow) = (difference(1.0), difference(0.1));
    let order = (fast / slow).log10();
    assert!((3.9..4.2).contains(&order), "{fast:e} {slow:e}");
}

#[test]
fn a_stiff_shaft_carries_the_kinetostatic_torque() {
    // c → ∞: tau = m ω² U′U″ against the drive, up to (ω/ω₀)².
    let mut scene = manipulator(profile(), false, DriveMode::Constant { w: 1.0, phi_start: 0.7 });
    (scene.parameters.c, scene.parameters.b) = (2.4e10, 1.785e4);
    scene.start.mode = StartMode::SteadyState;
    let drive = started(scene);
    let u = profile().at(0.7).0;
    let tau = -(drive.equation.parameters.c * drive.state[0] + drive.equation.parameters.b * drive.state[1]);
    let expected = 60.0 * u[1] * u[2];
    assert!((tau / expected - 1.0).abs() < 1e-6, "{tau} {expected}");
}

/// max |c q + b q̇| over max |m ω² U′U″| in the steady state; η counts from the sources' ω₀ = 80.66 rad/s.
fn amplification(law: MotionLaw, eta: f64, linear: bool) -> f64 {
    let w = eta * 80.66;
    let turn: Vec<[f64; 5]> = (0..7200).map(|i| law.at(std::f64::consts::TAU * f64::from(i) / 7200.0).0).collect();
    let static_torque = turn.iter().map(|u| (60.0 * w * w * u[1] * u[2]).abs()).fold(0.0, f64::max);
    let mut scene = manipulator(law, linear, DriveMode::Constant { w, phi_start: 0.0 });
    scene.start.mode = StartMode::SteadyState;
    let mut drive = started(scene);
    let period = std::f64::consts::TAU / w;
    let mut peak: f64 = 0.0;
    for i in 0..4000 {
        drive.advance(period * f64::from(i) / 4000.0, period / 4000.0).unwrap();
        peak = peak
            .max((drive.equation.parameters.c * drive.state[0] + drive.equation.parameters.b * drive.state[1]).abs());
    }
    peak / static_torque
}

/// Rise and return over 120° by `law`, dwells of 60°.
fn cycle(law: StandardLaw) -> MotionLaw {
    MotionLaw::Cycle(Cycle::new(CyclePlan {
        stroke: 0.4,
        lower: 0.0,
        rise_start: 30f64.to_radians(),
        rise_angle: 120f64.to_radians(),
        upper_dwell: 60f64.to_radians(),
        return_angle: 120f64.to_radians(),
        rise_law: law,
        return_law: law,
        inflections: [None; 2],
    }))
}

#[test]
fn the_transfer_manipulator_amplifies_as_in_the_sources() {
    // The minimax profile with two harmonics for dwells of 60°: cos φ and cos 3φ with Chebyshev's alternation.
    let dwell = MotionLaw::Fourier(Fourier::new(hs3(0.4, 30f64.to_radians()), vec![]));
    let trapezoid = || cycle(StandardLaw::ModifiedTrapezoid);
    let bestehorn = || cycle(StandardLaw::InclinedSine);
    let cases = [
        (dwell.clone(), 0.06, true, 1.12),
        (dwell.clone(), 0.06, false, 1.12),
        (dwell.clone(), 0.08, true, 1.47),
        (dwell, 0.08, false, 1.48),
        (trapezoid(), 0.06, true, 2.45),
        (trapezoid(), 0.06, false, 2.43),
        (trapezoid(), 0.08, true, 2.71),
        (trapezoid(), 0.08, false, 2.74),
        (bestehorn(), 0.06, true, 1.52),
        (bestehorn(), 0.06, false, 1.52),
        (bestehorn(), 0.08, true, 2.13),
        (bestehorn(), 0.08, false, 2.15),
        (cycle(StandardLaw::Polynomial345), 0.08, true, 1.68),
        (cycle(StandardLaw::ModifiedSine), 0.08, true, 1.38),
    ];
    for (law, eta, linear, printed) in cases {
        let r = amplification(law, eta, linear);
        assert!((r - printed).abs() < 0.006, "η = {eta}, linear {linear}: {r}, printed {printed}");
    }
}

/// a₁, a₃ such that U/stroke deviates from 1/2 by +e at φ = 0 and φ = half, and −e between.
fn hs3(stroke: f64, half: f64) -> Vec<f64> {
    // In x = cos φ the profile is p = (a₁ − 3 a₃) x + 4 a₃ x³; its extreme inside the dwell alternates with the ends.
    let ends = half.cos();
    let mut inner = 0.5 * (1.0 + ends);
    let mut a = [0.0; 2];
    for _ in 0..50 {
        // p(1) = p(ends) = 1/2 + e, p(inner) = 1/2 − e: three linear equations for α, β, e.
        let cubic = |x: f64| 4.0 * x.powi(3) - 3.0 * x;
        let rows = [[1.0, cubic(1.0), -1.0], [inner, cubic(inner), 1.0], [ends, cubic(ends), -1.0]];
        let lu = crate::numerics::lu::Lu::new(rows, 3).unwrap();
        let mut x = [0.5; 3];
        lu.solve(&mut x);
        a = [x[0], x[1]];
        // p′ = a₁ − 3 a₃ + 12 a₃ x² = 0.
        inner = ((3.0 * a[1] - a[0]) / (12.0 * a[1])).sqrt();
    }
    vec![0.0, stroke * a[0], 0.0, stroke * a[1]]
}

#[test]
fn the_first_tongue_of_a_cosine_cam_closes_at_the_critical_damping() {
    // U = r cos φ, J = m ⟨U′²⟩ = m r²/2: the tongue j = 1 closes at a damping ratio of 0.130634 (on J̄ = 2 J).
    let (r, m): (f64, f64) = (0.1, 60.0);
    let mean = m * r * r;
    let w0 = (2.4e4 / mean).sqrt();
    let growth = |eta: f64, theta: f64| {
        let law = MotionLaw::Fourier(Fourier::new(vec![0.0, r], vec![]));
        let mut scene = manipulator(law, true, DriveMode::Constant { w: eta * w0, phi_start: 0.0 });
        (scene.parameters.m, scene.parameters.inertia, scene.parameters.b) = (m, 0.5 * mean, 2.0 * theta * w0 * mean);
        started(scene).growth
    };
    let worst =
        |theta: f64| (0..40).map(|i| growth(0.8 + 0.01 * f64::from(i), theta)).fold(f64::NEG_INFINITY, f64::max);
    let (below, above) = (worst(0.1300), worst(0.1312));
    assert!(below > 0.0 && above < 0.0, "{below} {above}");
}

#[test]
fn an_unstable_steady_state_is_refused_with_its_growth() {
    let (r, m): (f64, f64) = (0.1, 60.0);
    let law = MotionLaw::Fourier(Fourier::new(vec![0.0, r], vec![]));
    let w0 = (2.4e4 / (m * r * r)).sqrt();
    let mut scene = manipulator(law, true, DriveMode::Constant { w: w0, phi_start: 0.0 });
    (scene.parameters.m, scene.parameters.inertia, scene.parameters.b) = (m, 0.5 * m * r * r, 1.0);
    scene.start.mode = StartMode::SteadyState;
    let message = ElasticShaft::new(scene.clone()).unwrap().start(0.0).unwrap_err().to_string();
    assert!(message.contains("is unstable, free vibrations grow by exp(0."), "{message}");
    // The tools start on it.
    let mut drive = ElasticShaft::new(scene).unwrap();
    let growth = drive.periodic_motion().unwrap().growth;
    let first = drive.state;
    drive.advance(0.0, std::f64::consts::TAU / w0).unwrap();
    assert!(growth > 0.0 && growth == drive.growth);
    assert!((drive.state[0] - first[0]).abs() < 1e-9 * first[0].hypot(first[1] / w0));
}

#[test]
fn unstable_growth_ends_in_a_fault() {
    let (r, m): (f64, f64) = (0.1, 60.0);
    let law = MotionLaw::Fourier(Fourier::new(vec![0.0, r], vec![]));
    let w0 = (2.4e4 / (m * r * r)).sqrt();
    let mut scene = manipulator(law, true, DriveMode::Constant { w: w0, phi_start: 0.1 });
    (scene.parameters.m, scene.parameters.inertia, scene.parameters.b) = (m, 0.5 * m * r * r, 0.0);
    let mut drive = boxed(&scene);
    drive.set_up(0.0, None);
    drive.start().unwrap();
    let names: Vec<String> = drive.descriptions().iter().map(|d| d.name.clone()).collect();
    let mut time = 0.0;
    let fault = loop {
        match drive.advance(time, 0.1) {
            Ok(_) => time += 0.1,
            Err(fault) => break fault,
        }
        for (reference, name) in names.iter().enumerate() {
            assert!(drive.get(reference).is_ok_and(f64::is_finite), "{name} at {time}");
        }
        assert!(time < 1000.0);
    };
    assert!(fault.to_string().contains("without bound"), "{fault}");
}

#[test]
fn directional_derivatives_are_difference_quotients_and_dependencies_exact() {
    for linear in [false, true] {
        let mut drive = ramp(linear);
        run(&mut drive, 0.7, 1);
        drive.apply(0.7).unwrap();
        let list = drive.variables();
        let psi = list.reference("psi").unwrap();
        for known in [0, 1, 2, psi, psi + 1] {
            for v in list.0.iter().filter(|v| v.series().is_some()) {
                let moved = |by: f64| {
                    let mut d = drive.clone();
                    match known {
                        0..=2 => {
                            d.motion.coefficients[known] += by;
                            d.motion.degree = d.motion.degree.max(known);
                            // ψ and ψ̇ are held.
                            if known < 2 {
                                d.state[known] -= by;
                            }
                        }
                        _ => d.state[known - psi] += by,
                    }
                    v.value(&d)
                };
                let h = 1e-6;
                let quotient = (moved(h) - moved(-h)) / (2.0 * h);
                let derivative =
                    v.series().unwrap()(&drive, Seed::Known(&list.0[known].description.name), v.index).derivative(1);
                let scale = 1.0 + derivative.abs();
                let name = &v.description.name;
                assert!((quotient - derivative).abs() < 1e-5 * scale, "{name} by {known}: {derivative} {quotient}");
                let depends = v.description.dependencies.contains(&list.0[known].description.name);
                // The structure is the linear equation's, since `shaft.linear` is a parameter.
                assert!(depends || derivative == 0.0, "{name} by {known}, linear {linear}: {derivative}");
                assert!(!linear || !depends || derivative != 0.0, "{name} by {known}");
            }
        }
    }
}

#[test]
fn output_derivatives_are_those_of_the_motion() {
    for linear in [false, true] {
        let mut drive = ramp(linear);
        drive.advance(0.0, 0.7).unwrap();
        let at = |h: f64| {
            let mut d = ramp(linear);
            d.advance(0.0, 0.7 + h).unwrap();
            d
        };
        // Fourth-order differences over 1 ms: errors of 1e-12 times the fifth derivative, rounding 1e-10.
        let h = 1e-3;
        let around = [at(-2.0 * h), at(-h), at(h), at(2.0 * h)];
        for v in drive.variables().0.iter().filter(|v| v.series().is_some()) {
            let series = v.series().unwrap()(&drive, Seed::Time, v.index);
            let x: Vec<f64> = around.iter().map(|d| v.value(d)).collect();
            let centre = v.value(&drive);
            let first = (x[0] - 8.0 * x[1] + 8.0 * x[2] - x[3]) / (12.0 * h);
            let second = (-x[0] + 16.0 * x[1] - 30.0 * centre + 16.0 * x[2] - x[3]) / (12.0 * h * h);
            let name = &v.description.name;
            let (d1, d2) = (series.derivative(1), series.derivative(2));
            // der(psi,2) varies with √(c/J) = 126/s.
            assert!((first - d1).abs() < 1e-5 * (1.0 + d1.abs()), "{name}′: {d1} {first}");
            assert!((second - d2).abs() < 1e-3 * (1.0 + d2.abs()), "{name}″: {d2} {second}");
        }
    }
}

#[test]
fn a_state_read_from_bytes_goes_on_with_the_same_bits() {
    let scene = manipulator(cycle(StandardLaw::Polynomial345), true, CONSTANT);
    let mut drive = boxed(&scene);
    drive.set_up(0.0, None);
    drive.start().unwrap();
    drive.advance(0.0, 0.9).unwrap();
    let bytes = drive.save().serialize().unwrap();
    let mut other = boxed(&scene);
    let state = other.deserialize(&bytes).unwrap();
    other.restore(&state);
    for drive in [&mut drive, &mut other] {
        drive.advance(0.9, 0.1).unwrap();
        drive.advance(1.0, 7.0).unwrap();
    }
    assert_eq!(drive.save().serialize(), other.save().serialize());
}

#[test]
fn a_tuned_linear_shaft_goes_on_with_its_new_parameters() {
    // The integrator takes over from the tables: with the same numbers as from a fresh start there.
    let mut drive = started(manipulator(profile(), true, CONSTANT));
    run(&mut drive, 1.0, 10);
    assert!(drive.trajectory.is_some());
    (drive.equation.parameters.c, drive.equation.parameters.b) = (3e4, 5.0);
    drive.apply(1.0).unwrap();
    let mut fresh = manipulator(profile(), true, DriveMode::Constant { w: 4.84, phi_start: 0.3 + 4.84 });
    (fresh.parameters.c, fresh.parameters.b) = (3e4, 5.0);
    fresh.start = Start { mode: StartMode::Given, q: drive.state[0], q_dot: drive.state[1] };
    let mut fresh = started(fresh);
    for n in 0..50 {
        drive.advance(1.0 + 0.1 * f64::from(n), 0.1).unwrap();
        fresh.advance(0.1 * f64::from(n), 0.1).unwrap();
        let error = [drive.state[0] - fresh.state[0], drive.state[1] - fresh.state[1]];
        assert!(error[0].abs() < 1e-12 && error[1].abs() < 1e-10, "{n}: {error:?}");
    }
}
