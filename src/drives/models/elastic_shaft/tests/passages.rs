//! The nonlinear drive at the breakpoints of its law, against fixed steps of the classical Runge–Kutta method, which ignore them.

use super::*;

/// q̈ of (J + m U′²) ψ̈ + m U′U″ ψ̇² + b q̇ + c q = 0 at constant speed.
fn acceleration(scene: &Scene, t: f64, [q, v]: [f64; 2]) -> f64 {
    let DriveMode::Constant { w, phi_start } = scene.drive else { unreachable!() };
    let [_, u1, u2, ..] = scene.cam.at((phi_start + w * t + q).rem_euclid(std::f64::consts::TAU)).0;
    let load = scene.parameters.m * u1 * u2 * (w + v).powi(2) + scene.parameters.b * v + scene.parameters.c * q;
    -load / (scene.parameters.inertia + scene.parameters.m * u1 * u1)
}

/// (q, q̇) after each of `count` equal parts of `span`, with `fine` steps in each.
fn runge_kutta(scene: &Scene, span: f64, count: i32, fine: i32) -> Vec<[f64; 2]> {
    let mut y = [scene.start.q, scene.start.q_dot];
    let h = span / f64::from(count * fine);
    let mut states = Vec::new();
    for n in 0..count * fine {
        let t = h * f64::from(n);
        let rate = |t: f64, y: [f64; 2]| [y[1], acceleration(scene, t, y)];
        let along = |k: [f64; 2], part: f64| [y[0] + part * h * k[0], y[1] + part * h * k[1]];
        let k1 = rate(t, y);
        let k2 = rate(t + 0.5 * h, along(k1, 0.5));
        let k3 = rate(t + 0.5 * h, along(k2, 0.5));
        let k4 = rate(t + h, along(k3, 1.0));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        if (n + 1) % fine == 0 {
            states.push(y);
        }
    }
    states
}

/// The largest error of (q, q̇), each relative to the largest value so far, the error estimate, and the internal steps.
fn outcome(scene: &Scene, tolerance: f64, span: f64, truth: &[[f64; 2]]) -> (f64, f64, f64) {
    let mut drive = started(Scene { solver: Settings { tolerance, ..Settings::default() }, ..scene.clone() });
    let mut scale = [scene.start.q.abs(), scene.start.q_dot.abs()];
    let mut error = 0.0f64;
    let count = truth.len() as f64;
    for (n, truth) in truth.iter().enumerate() {
        let time = span * n as f64 / count;
        drive.advance(time, span * (n + 1) as f64 / count - time).unwrap();
        for i in 0..2 {
            scale[i] = scale[i].max(truth[i].abs());
            error = error.max((drive.state[i] - truth[i]).abs() / scale[i]);
        }
    }
    (error, drive.solver.error_estimate, drive.solver.steps)
}

/// A cycle whose shaft vibrates 29 times per turn, from a large twist that the damping removes.
fn decaying(law: StandardLaw) -> Scene {
    let plan = CyclePlan {
        stroke: 0.065,
        lower: 0.0,
        rise_start: 0.58,
        rise_angle: 1.85,
        upper_dwell: 0.6,
        return_angle: 1.92,
        rise_law: law,
        return_law: law,
        inflections: [None; 2],
    };
    Scene {
        load: Load::default(),
        parameters: Parameters { m: 5.147, inertia: 0.03137, c: 104.7, b: 0.6524 },
        linear: false,
        cam: MotionLaw::Cycle(Cycle::new(plan)),
        drive: DriveMode::Constant { w: 1.996, phi_start: 2.2413 },
        start: Start { mode: StartMode::Given, q: -0.0285, q_dot: -4.388 },
        solver: Settings::default(),
    }
}

#[test]
fn within_the_steps_before_a_breakpoint_the_tolerance_holds() {
    for law in StandardLaw::ALL {
        let (scene, span) = (decaying(law), 5.668);
        let truth = runge_kutta(&scene, span, 1500, 200);
        let mut most = 0.0;
        for n in 0..40 {
            let tolerance = 10f64.powf(-3.0 - 0.125 * f64::from(n));
            let (error, estimate, steps) = outcome(&scene, tolerance, span, &truth);
            // The tolerance is per step; the errors of a few of them add up.
            assert!(error <= estimate.min(3.0 * tolerance), "{law:?}, {tolerance:e}: {error:e}, estimate {estimate:e}");
            // A looser tolerance never costs more, except for the few steps that a breakpoint cuts short.
            most = f64::max(most, steps);
            assert!(most <= 1.1 * steps, "{law:?}, {tolerance:e}: {steps} steps, {most} for a looser one");
        }
    }
}

#[test]
fn no_visit_to_another_segment_is_too_short() {
    // A drive at rest in the dwell: each vibration briefly takes the cam into the rise by `depth`.
    for depth in [1e-2, 3e-3, 1e-3, 3e-4] {
        let mut scene = decaying(StandardLaw::SimpleSine);
        let amplitude = 0.1;
        scene.drive = DriveMode::Constant { w: 0.0, phi_start: 0.58 - amplitude + depth };
        scene.start = Start { mode: StartMode::Given, q: -amplitude, q_dot: 0.0 };
        (scene.parameters.m, scene.parameters.b) = (300.0, 0.0);
        let span = 20.0 * std::f64::consts::TAU * (scene.parameters.inertia / scene.parameters.c).sqrt();
        let truth = runge_kutta(&scene, span, 1000, 200);
        for tolerance in [1e-4, 1e-5, 1e-6, 1e-7] {
            let (error, estimate, _) = outcome(&scene, tolerance, span, &truth);
            assert!(error <= tolerance.min(estimate), "{depth}, {tolerance:e}: {error:e}, estimate {estimate:e}");
        }
    }
}

/// A cam that starts to accelerate in a dwell, where the twist is at rest: q̈ = −α = −k t, k the derivative of the input α. The
/// time of the nodes needs all digits there.
#[test]
fn acceleration_that_begins_in_a_dwell() {
    let (start, h) = (0.000_35, 1.6e-10);
    let law = cycle(StandardLaw::InclinedSine);
    for jerk in [5.8e3, 5.8e9] {
        for tolerance in [1e-10, 1e-12, 1e-14] {
            let solver = Settings { tolerance, ..Settings::default() };
            let scene = Scene {
                parameters: Parameters { m: 0.022, inertia: 2.1e-7, c: 2.5, b: 2.8e-6 },
                linear: false,
                solver,
                ..manipulator(law.clone(), false, DriveMode::Input)
            };
            let mut drive = ElasticShaft::new(scene).unwrap();
            drive.cam.set_inputs([3.2, -126.0, 0.0]);
            drive.start(0.0).unwrap();
            drive.advance(0.0, start).unwrap();
            drive.cam.set_inputs([3.2 - 126.0 * start, -126.0, 0.0]);
            drive.cam.set_input_derivative(2, 1, jerk);
            drive.advance(start, h).unwrap();
            let expected = [-jerk * h.powi(3) / 6.0, -jerk * h.powi(2) / 2.0];
            for (got, expected) in drive.state.into_iter().zip(expected) {
                assert!((got / expected - 1.0).abs() < 1e-7, "{jerk:e} {tolerance:e}: {got:e} {expected:e}");
            }
            assert!(drive.solver.steps < 5.0, "{jerk:e} {tolerance:e}: {} steps", drive.solver.steps);
        }
    }
}

/// A linear shaft without damping, whose cam passes 87 breakpoints to and fro, on inputs set at three instants: at the ends of
/// a simple sine U″² jumps, and with it q̈. The truth is Gauss collocation of order 24 in 113-bit arithmetic between the
/// passages, whose times are roots of quadratic equations.
#[test]
fn passages_where_the_acceleration_jumps_are_not_late() {
    let plan = CyclePlan {
        stroke: 0.1712992952804728,
        lower: 0.06653155214084355,
        rise_start: 0.2826950310339629,
        rise_angle: 3.2744741492732934,
        upper_dwell: 0.0,
        return_angle: 1.4278177907280616,
        rise_law: StandardLaw::SimpleSine,
        return_law: StandardLaw::Polynomial4567,
        inflections: [None; 2],
    };
    let ends = [3.2939453125, 4.7451171875, 14.189453125];
    let inputs = [
        [97.29508596658707, 6.64215087890625, 0.0],
        [119.22215086221695, 6.64215087890625, 2.9375],
        [131.95409375429153, 10.90496826171875, -5.0],
    ];
    // q and the largest |q| so far.
    let truth = [[1.6012078560362188, 2.8176], [1.6252739068216398, 4.7511], [-1108.383948656965, 2098.53]];
    for tolerance in [0.0, 1e-11, 1e-12] {
        let scene = Scene {
            load: Load::default(),
            parameters: Parameters {
                m: 0.6125795739257567,
                inertia: 0.006855831203245369,
                c: 4.312996805705326,
                b: 0.0,
            },
            linear: true,
            cam: MotionLaw::Cycle(Cycle::new(plan)),
            drive: DriveMode::Input,
            start: Start { mode: StartMode::Given, q: -0.29388928922003005, q_dot: 1.984038998454215 },
            solver: Settings { tolerance, ..Settings::default() },
        };
        let mut drive = ElasticShaft::new(scene).unwrap();
        drive.cam.set_inputs(inputs[0]);
        drive.start(0.0).unwrap();
        let mut time = 0.0;
        for ((end, inputs), [q, largest]) in ends.into_iter().zip(inputs).zip(truth) {
            drive.cam.set_inputs(inputs);
            drive.advance(time, end - time).unwrap();
            time = end;
            let (error, estimate) = ((drive.state[0] - q).abs() / largest, drive.solver.error_estimate);
            assert!(error < estimate.min(5e-13), "t = {time}, {tolerance:e}: {error:e}, estimate {estimate:e}");
        }
    }
}

/// A linear shaft on a rise so steep that 1e-14 rad beyond its breakpoints would show. The truth is Gauss collocation of order 24
/// with 34 digits between the passages.
#[test]
fn passages_of_a_steep_rise_are_not_late() {
    let plan = CyclePlan {
        stroke: 0.02,
        lower: 0.0,
        rise_start: 0.5,
        rise_angle: 0.01,
        upper_dwell: 0.2,
        return_angle: 2.0,
        rise_law: StandardLaw::SimpleSine,
        return_law: StandardLaw::SimpleSine,
        inflections: [Some(0.0625), None],
    };
    let scene = Scene {
        load: Load::default(),
        parameters: Parameters { m: 0.02, inertia: 1.0, c: 81.0, b: 0.0 },
        linear: true,
        cam: MotionLaw::Cycle(Cycle::new(plan)),
        drive: DriveMode::Input,
        start: Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 },
        solver: Settings { tolerance: 1e-14, ..Settings::default() },
    };
    for (end, q) in [(0.5, 0.00029853128009337955), (1.0, 0.00033627442518587259), (2.0, -0.00015091963044232198)] {
        let mut drive = ElasticShaft::new(scene.clone()).unwrap();
        drive.cam.set_inputs([0.25, 3.0, 0.0]);
        drive.start(0.0).unwrap();
        drive.advance(0.0, end).unwrap();
        let (error, estimate) = ((drive.state[0] / q - 1.0).abs(), drive.solver.error_estimate);
        assert!(error <= estimate.min(1e-11), "t = {end}: {error:e}, estimate {estimate:e}");
    }
}

#[test]
fn a_steep_segment_does_not_hide_the_errors_of_another() {
    // The rounding of the jerk of the 0.02 rad rise exceeds all errors of the return.
    let plan = CyclePlan {
        stroke: 8.7e-4,
        lower: 0.0,
        rise_start: 2.52,
        rise_angle: 0.02,
        upper_dwell: 0.0,
        return_angle: 3.255,
        rise_law: StandardLaw::ModifiedTrapezoid,
        return_law: StandardLaw::ModifiedTrapezoid,
        inflections: [Some(0.99), None],
    };
    let scene = Scene {
        load: Load::default(),
        parameters: Parameters { m: 37.48, inertia: 6.608e-6, c: 0.3619, b: 7.52e-5 },
        linear: false,
        cam: MotionLaw::Cycle(Cycle::new(plan)),
        // Backwards within the quarter of the return in which U″ is constant.
        drive: DriveMode::Constant { w: -1.8, phi_start: -0.9 },
        start: Start { mode: StartMode::Given, q: 6e-5, q_dot: 1.3e-4 },
        solver: Settings::default(),
    };
    let span = 0.4;
    let (error, estimate, _) = outcome(&scene, 1e-11, span, &runge_kutta(&scene, span, 40, 5000));
    assert!(error <= estimate.min(1e-9), "{error:e}, estimate {estimate:e}");
}
