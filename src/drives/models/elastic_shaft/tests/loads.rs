//! Loads on the follower, against Lagrange's equation integrated by extrapolation, and against relations that hold for every load.

use super::extremes::{Random, assert_honest, random_scene, relative_error};
use super::*;
use crate::drives::follower::equation::Equation;
use crate::drives::follower::flow::Flow;
use crate::drives::follower::load::Spring;
use crate::motion::Polyline;
use crate::motion::table::Points;
use std::f64::consts::TAU;

fn fourier(a: &[f64], b: &[f64]) -> MotionLaw {
    MotionLaw::Fourier(Fourier::new(a.to_vec(), [&[0.0], b].concat()))
}

/// A valve spring, gravity, a guide and a process.
fn load() -> Load {
    Load {
        gravity: Some(-9.81),
        spring: Some(Spring { preload: 40.0, c: 3e3, at: 0.01 }),
        damping: Some(15.0),
        process: Some(fourier(&[0.0, 20.0, -12.0], &[7.0, 0.0, 3.0])),
        ..Load::default()
    }
}

fn press(linear: bool, w: f64, phi_start: f64) -> Scene {
    Scene {
        parameters: Parameters { m: 25.0, inertia: 0.1, c: 1200.0, b: 1.0 },
        load: load(),
        cam: fourier(&[0.0, 0.5867 * 0.06, 0.0, -0.0984 * 0.06, 0.0, 0.0115 * 0.06], &[]),
        ..manipulator(profile(), linear, DriveMode::Constant { w, phi_start })
    }
}

/// Another process, which shares its breakpoints with the cam or has others.
fn cycle_of(stroke: f64, rise_start: f64, law: StandardLaw) -> MotionLaw {
    MotionLaw::Cycle(Cycle::new(CyclePlan {
        stroke,
        lower: -0.2 * stroke,
        rise_start,
        rise_angle: 1.3,
        upper_dwell: 0.4,
        return_angle: 1.6,
        rise_law: law,
        return_law: StandardLaw::SimpleSine,
        inflections: [None; 2],
    }))
}

/// Straight lines with two steps, one of them at `at` (rad).
fn steps(at: f64, size: f64) -> MotionLaw {
    let mut points =
        [(at, 0.3), (at, 1.0), (at + 1.2, 1.4), (at + 2.5, -0.6), (at + 2.5, 0.2), (at + 4.0, -0.1), (at + 5.4, 0.5)];
    points.iter_mut().for_each(|(phi, _)| *phi -= TAU * (at / TAU).floor());
    let (angles, lifts) = points.iter().map(|(phi, value)| (*phi, size * value)).unzip();
    MotionLaw::Polyline(Polyline::new(Points { angles, lifts }).unwrap())
}

fn variable(drive: &ElasticShaft, name: &str) -> usize {
    drive.variables().reference(name).unwrap_or_else(|| panic!("no variable {name}"))
}

fn set(drive: &mut ElasticShaft, name: &str, value: f64) {
    let index = variable(drive, name);
    drive.variables().0[index].set(drive, value);
}

/// Lagrange's equation d/dt[(J + m U′²) ψ̇] = m U′U″ ψ̇² − b q̇ − c q + U′ F_L, with the momentum as state; linearised in q by
/// differences of the torque. At constant speed, F(t) in the time of the FMU.
struct Lagrange<'a> {
    scene: &'a Scene,
    input: &'a dyn Fn(f64) -> f64,
}

impl Lagrange<'_> {
    fn shaft(&self) -> [f64; 2] {
        let DriveMode::Constant { w, phi_start } = self.scene.drive else { unreachable!("a constant speed") };
        [w, phi_start]
    }

    fn law(law: &MotionLaw, phi: f64, inside: f64) -> [f64; 4] {
        let [u, u1, u2, u3, _] = law.at_in(law.segment(inside.rem_euclid(TAU), true), phi.rem_euclid(TAU)).0;
        [u, u1, u2, u3]
    }

    fn force(&self, t: f64, phi: f64, inside: f64, [y, v]: [f64; 2]) -> f64 {
        let Load { gravity, constant, spring, damping, process, .. } = &self.scene.load;
        let Spring { preload, c, at } = spring.unwrap_or_default();
        let process = process.as_ref().map_or(0.0, |process| Self::law(process, phi, inside)[0]);
        self.scene.parameters.m * gravity.unwrap_or(0.0) + constant.unwrap_or(0.0)
            - preload
            - c * (y - at)
            - damping.unwrap_or(0.0) * v
            + process
            + (self.input)(t)
    }

    /// −(J + m U′²) ψ̈ at constant speed, nonlinear.
    fn torque(&self, t: f64, inside: [f64; 2], [q, v]: [f64; 2]) -> f64 {
        let ([w, phi_start], Parameters { m, c, b, .. }) = (self.shaft(), self.scene.parameters);
        let phi = phi_start + w * t;
        let [u, u1, u2, _] = Self::law(&self.scene.cam, phi + q, inside[0]);
        let speed = w + v;
        m * u1 * u2 * speed * speed + b * v + c * q - u1 * self.force(t, phi, inside[1], [u, u1 * speed])
    }

    /// The rates of q and q̇.
    fn rates(&self, t: f64, inside: [f64; 2], [q, v]: [f64; 2]) -> [f64; 2] {
        let ([w, phi_start], Parameters { m, inertia, .. }) = (self.shaft(), self.scene.parameters);
        let phi = phi_start + w * t;
        if !self.scene.linear {
            let [_, u1, ..] = Self::law(&self.scene.cam, phi + q, inside[0]);
            return [v, -self.torque(t, inside, [q, v]) / (inertia + m * u1 * u1)];
        }
        let [_, u1, ..] = Self::law(&self.scene.cam, phi, inside[0]);
        // Differences of the sixth order over steps of 2e-3 rad; in q̇ the torque is a square.
        let h = 2e-3;
        let d = |k: f64| self.torque(t, inside, [k * h, 0.0]) - self.torque(t, inside, [-k * h, 0.0]);
        let by_q = (45.0 * d(1.0) - 9.0 * d(2.0) + d(3.0)) / (60.0 * h);
        let by_v = (self.torque(t, inside, [0.0, w]) - self.torque(t, inside, [0.0, -w])) / (2.0 * w);
        let torque = self.torque(t, inside, [0.0; 2]) + by_q * q + by_v * v;
        [v, -torque / (inertia + m * u1 * u1)]
    }

    /// The state at `end`, from one breakpoint over φ to the next by extrapolated midpoint steps; for the nonlinear equation ψ must
    /// meet no breakpoint.
    fn run(&self, mut y: [f64; 2], end: f64) -> [f64; 2] {
        let [w, phi_start] = self.shaft();
        let mut borders: Vec<f64> = self.scene.load.process.iter().flat_map(|law| law.breakpoints().to_vec()).collect();
        borders.extend(self.scene.cam.breakpoints());
        let turn = TAU / w.abs();
        let passed = |border: f64| {
            let first = ((border - phi_start) / w).rem_euclid(turn);
            (0..1000).map(move |n| first + f64::from(n) * turn)
        };
        let mut stops: Vec<f64> = borders.into_iter().flat_map(passed).filter(|t| *t < end).chain([end]).collect();
        stops.sort_by(f64::total_cmp);
        let mut t = 0.0;
        for stop in stops {
            let inside = phi_start + w * 0.5 * (t + stop);
            let frequency = (self.scene.parameters.c / self.scene.parameters.inertia).sqrt().max(20.0 * w.abs());
            let count = ((stop - t) * frequency).ceil();
            let h = (stop - t) / count;
            for i in 0..count as usize {
                y = self.step(t + i as f64 * h, h, [inside; 2], y);
            }
            t = stop;
        }
        y
    }

    /// Gragg's midpoint rule with 2, 4 … 16 parts, extrapolated to order 16.
    fn step(&self, t: f64, h: f64, inside: [f64; 2], y: [f64; 2]) -> [f64; 2] {
        let mut row: Vec<[f64; 2]> = Vec::new();
        for k in 1..=8 {
            let (n, mut before, part) = (2 * k, y, h / f64::from(2 * k));
            let at = |i: i32, y: [f64; 2]| self.rates(t + part * f64::from(i), inside, y);
            let first = at(0, y);
            let mut now = [0, 1].map(|c| y[c] + part * first[c]);
            for i in 1..n {
                let rate = at(i, now);
                (before, now) = (now, [0, 1].map(|c| before[c] + 2.0 * part * rate[c]));
            }
            let last = at(n, now);
            let mut next = vec![[0, 1].map(|c| 0.5 * (now[c] + before[c] + part * last[c]))];
            for (j, old) in row.iter().enumerate() {
                let ratio = (f64::from(k) / (f64::from(k) - j as f64 - 1.0)).powi(2);
                next.push([0, 1].map(|c| next[j][c] + (next[j][c] - old[c]) / (ratio - 1.0)));
            }
            row = next;
        }
        row[7]
    }
}

fn none(_: f64) -> f64 {
    0.0
}

fn get(drive: &ElasticShaft, name: &str) -> f64 {
    drive.variables().0[variable(drive, name)].value(drive)
}

/// The largest error of q and q̇ relative to a motion of this size.
fn error(drive: &ElasticShaft, expected: [f64; 2], [q, v]: [f64; 2]) -> f64 {
    ((drive.state[0] - expected[0]) / q).abs().max(((drive.state[1] - expected[1]) / v).abs())
}

/// Two independent methods agree on these numbers to the last but one digit.
#[test]
fn the_loaded_press_meets_its_reference() {
    for steps in [1, 9, 900] {
        let mut scene = press(false, 14.0, 0.0);
        scene.solver.tolerance = 1e-13;
        let mut drive = started(scene);
        run(&mut drive, 0.9, steps);
        for (name, expected) in [
            ("psi", 12.5975089226534),
            ("der(psi)", 12.1665048428283),
            ("tau", 4.82278797313989),
            ("contact_force", 339.200246064352),
        ] {
            let value = get(&drive, name);
            assert!((value / expected - 1.0).abs() < 1e-11, "{steps} steps, {name}: {value}");
        }
    }
}

/// Nonlinear and linear; smooth and with breakpoints of process and, linear, of the cam, some of them shared.
#[test]
fn random_loads_meet_lagranges_equation() {
    let mut r = Random(41);
    for case in 0..24 {
        let linear = case % 2 == 0;
        let w = r.between(6.0, 20.0) * if case % 3 == 0 { -1.0 } else { 1.0 };
        let mut scene = press(linear, w, r.between(-9.0, 9.0));
        let spring = Spring { preload: r.between(0.0, 60.0), c: r.scale(300.0, 6e3), at: r.between(-0.05, 0.05) };
        scene.load = Load {
            gravity: (r.next() < 0.5).then(|| r.between(-10.0, 10.0)),
            constant: (r.next() < 0.5).then(|| r.between(-90.0, 90.0)),
            spring: (r.next() < 0.7).then_some(spring),
            damping: (r.next() < 0.7).then(|| r.between(0.0, 60.0)),
            process: None,
            input: false,
            ..Load::default()
        };
        let at = r.between(0.0, TAU);
        if case % 5 == 0 {
            scene.load.process = Some(steps(at, r.between(-60.0, 60.0)));
        } else if case % 4 > 1 {
            scene.load.process = Some(cycle_of(r.between(-90.0, 90.0), at, StandardLaw::Polynomial345));
        } else {
            scene.load.process = Some(fourier(&[r.between(-20.0, 20.0), 9.0, -20.0], &[r.between(-30.0, 30.0)]));
        }
        if linear && case % 8 > 3 {
            // Some of the breakpoints are those of the process.
            scene.cam = cycle_of(0.06, at, StandardLaw::ModifiedSine);
        }
        scene.start = Start { mode: StartMode::Given, q: 0.01, q_dot: -0.1 };
        scene.solver.tolerance = 1e-12;
        let expected = Lagrange { scene: &scene, input: &none }.run([0.01, -0.1], 1.7);
        for steps in [1, 30] {
            let mut drive = started(scene.clone());
            run(&mut drive, 1.7, steps);
            assert_eq!(linear, drive.trajectory.is_some());
            let error = error(&drive, expected, [0.05, 1.0]);
            assert!(error < 2e-11, "case {case}, {steps} steps: {error:e}, {scene:?}");
            if linear {
                // The same equation by steps.
                let mut drive = started(scene.clone());
                drive.loaded_anew = true;
                drive.take_up(0.0);
                run(&mut drive, 1.7, steps);
                assert!(drive.trajectory.is_none());
                let error = self::error(&drive, expected, [0.05, 1.0]);
                assert!(error < 2e-11, "case {case}, {steps} steps of the integrator: {error:e}, {scene:?}");
            }
        }
    }
}

/// A shaft on inputs with a constant speed meets the breakpoints of its process between the communication points.
#[test]
fn a_load_on_inputs_is_that_at_constant_speed() {
    for linear in [false, true] {
        for process in [steps(0.5, 40.0), cycle_of(60.0, 0.9, StandardLaw::InclinedSine)] {
            let mut scene = press(linear, -14.0, 0.2);
            scene.load.process = Some(process);
            let mut constant = started(scene.clone());
            run(&mut constant, 1.3, 1);
            let mut drive = ElasticShaft::new(Scene { drive: DriveMode::Input, ..scene }).unwrap();
            for n in 0..60 {
                let t = 1.3 * f64::from(n) / 60.0;
                for (name, value) in [("phi", 0.2 - 14.0 * t), ("w", -14.0), ("a", 0.0)] {
                    set(&mut drive, name, value);
                }
                if n == 0 {
                    drive.start(0.0).unwrap();
                }
                drive.apply(t).unwrap();
                drive.advance(t, 1.3 / 60.0).unwrap();
            }
            let error = error(&drive, constant.state, [0.05, 1.0]);
            assert!(error < 1e-8, "linear {linear}: {error:e}");
        }
    }
}

/// F is a polynomial of time in each communication step.
#[test]
fn an_input_force_acts_between_communication_points() {
    for linear in [false, true] {
        let mut scene = press(linear, 14.0, 0.2);
        scene.load.input = true;
        let force = |t: f64| 30.0 - 200.0 * t + 300.0 * t * t;
        let expected = Lagrange { scene: &scene, input: &force }.run([0.0; 2], 0.9);
        for steps in [1, 9, 300] {
            let mut drive = ElasticShaft::new(scene.clone()).unwrap();
            let h = 0.9 / f64::from(steps);
            set(&mut drive, "F", force(0.0));
            drive.start(0.0).unwrap();
            for n in 0..steps {
                let t = h * f64::from(n);
                set(&mut drive, "F", force(t));
                let list = drive.variables();
                for (order, value) in [(1, -200.0 + 600.0 * t), (2, 600.0)] {
                    list.0[variable(&drive, "F")].set_derivative(&mut drive, order, value);
                }
                drive.apply(t).unwrap();
                if n % 50 == 8 {
                    check_series(&drive, t);
                }
                drive.advance(t, h).unwrap();
            }
            let error = error(&drive, expected, [0.05, 1.0]);
            assert!(error < 1e-9, "linear {linear}, {steps} steps: {error:e}");
            let expected = drive.equation.acceleration(&drive.now(Twist::at).0, &drive.now(Twist::at).1);
            assert_eq!(get(&drive, "der(psi,2)"), expected);
        }
        let mut steady = ElasticShaft::new(Scene { start: start(StartMode::SteadyState), ..scene.clone() }).unwrap();
        steady.force.as_mut().unwrap().set_derivative(1, 2.0);
        assert!(steady.start(0.0).unwrap_err().message.contains("the input F changes with time"));
    }
}

/// The derivatives of the outputs in time and by F, ψ and ψ̇ match differences; F goes on as set at `t`.
fn check_series(drive: &ElasticShaft, t: f64) {
    let variables = drive.variables();
    for name in ["der(psi,2)", "contact_force", "tau", "der(y)"] {
        let by = |seed| {
            let v = &variables.0[variable(drive, name)];
            (v.series().unwrap())(drive, seed, v.index).derivative(1)
        };
        let h = 2e-4;
        let after = |k: i32| {
            let mut drive = drive.clone();
            if k > 0 {
                drive.advance(t, h * f64::from(k)).unwrap();
            }
            get(&drive, name)
        };
        let weights = [-25.0, 48.0, -36.0, 16.0, -3.0];
        let slope: f64 = (0..5).map(|k| weights[k as usize] * after(k)).sum::<f64>() / (12.0 * h);
        let size = get(drive, name).abs() * 200.0;
        let own = by(Seed::Time);
        assert!((own - slope).abs() < 1e-6 * size, "{name} in time: {own} {slope}");
        for known in ["F", "psi", "der(psi)"] {
            let moved = |by: f64| {
                let mut drive = drive.clone();
                match known {
                    "F" => {
                        let value = get(&drive, "F") + by;
                        set(&mut drive, "F", value);
                    }
                    "psi" => drive.state[0] += by,
                    _ => drive.state[1] += by,
                }
                get(&drive, name)
            };
            let d = |k: f64| moved(k * 1e-3) - moved(-k * 1e-3);
            let slope = (8.0 * d(1.0) - d(2.0)) / 12e-3;
            let own = by(Seed::Known(known));
            assert!((own - slope).abs() < 1e-6 * (1.0 + slope.abs()), "{name} by {known}: {own} {slope}");
        }
    }
}

fn start(mode: StartMode) -> Start {
    Start { mode, q: 0.0, q_dot: 0.0 }
}

/// The torque −(J + m U′²)(q̈ + α) of the linear equation matches the nonlinear one to first order in q and q̇.
#[test]
fn the_linear_equation_is_the_other_at_small_amplitude() {
    let law = press(false, 14.0, 0.0).cam;
    let drive =
        |linear| ElasticShaft::new(Scene { linear, load: Load { input: true, ..load() }, ..press(linear, 14.0, 0.0) });
    let [exact, linear] = [false, true].map(|linear| drive(linear).unwrap().equation);
    for i in 0..40 {
        let f = Flow { phi: 0.15 * f64::from(i) - 3.0, w: -11.0, a: 0.0, q: 0.0, v: 0.0, force: 25.0 };
        let torque = |equation: &Twist, f: Flow<f64>| {
            let cam = equation.at(&law, [0; 2], &f);
            (0.1 + 25.0 * cam.0[1].powi(2)) * equation.acceleration(&cam, &f)
        };
        for (q, v) in [(1.0, 0.0), (0.0, 1.0)] {
            let moved = |k: f64| Flow { q: k * q, v: k * v, ..f };
            let h = 1e-3;
            let d = |k: f64| torque(&exact, moved(k * h)) - torque(&exact, moved(-k * h));
            let by = (8.0 * d(1.0) - d(2.0)) / (12.0 * h);
            let own = torque(&linear, moved(1.0)) - torque(&linear, f);
            assert!((by - own).abs() < 1e-8 * (1.0 + own.abs()), "at {}: {by} {own}", f.phi);
        }
        assert!((torque(&exact, f) - torque(&linear, f)).abs() < 1e-12);
        // And the Jacobian of each is its derivative.
        for equation in [&exact, &linear] {
            let f = Flow { q: 0.02, v: 0.3, ..f };
            let cam = |f: &Flow<f64>| equation.at(&law, [0; 2], f);
            let by = |q: f64, v: f64| {
                let d = |k: f64| [k, -k].map(|k| Flow { q: f.q + k * q, v: f.v + k * v, ..f });
                let d = |k: f64| {
                    let [plus, minus] = d(k).map(|f| equation.acceleration(&cam(&f), &f));
                    plus - minus
                };
                (8.0 * d(1e-3) - d(2e-3)) / 12e-3
            };
            let jacobian = equation.jacobian(&cam(&f), &f);
            for (got, expected) in jacobian.into_iter().zip([by(1.0, 0.0), by(0.0, 1.0)]) {
                assert!((got - expected).abs() < 1e-7 * (1.0 + expected.abs()), "at {}: {got} {expected}", f.phi);
            }
        }
    }
}

/// U and P of −φ turn the other way round.
#[test]
fn a_mirrored_drive_twists_the_other_way() {
    let mirrored = |law: &MotionLaw| match law {
        MotionLaw::Fourier(series) => {
            MotionLaw::Fourier(Fourier::new(series.a.clone(), series.b.iter().map(|b| -b).collect()))
        }
        MotionLaw::Cycle(cycle) => {
            let plan = *cycle.plan();
            let rise_start = -(plan.rise_start + plan.rise_angle + plan.upper_dwell + plan.return_angle);
            MotionLaw::Cycle(Cycle::new(CyclePlan {
                rise_start: rise_start.rem_euclid(TAU),
                rise_angle: plan.return_angle,
                return_angle: plan.rise_angle,
                rise_law: plan.return_law,
                return_law: plan.rise_law,
                ..plan
            }))
        }
        _ => unreachable!(),
    };
    let processes = [load().process.unwrap(), cycle_of(80.0, 1.0, StandardLaw::InclinedSine)];
    for (linear, process) in [false, true].into_iter().flat_map(|linear| processes.clone().map(|p| (linear, p))) {
        let mut scene = press(linear, 14.0, 0.4);
        scene.cam = fourier(&[0.0, 0.03, 0.0, -0.006], &[0.01, 0.002]);
        scene.load.process = Some(process.clone());
        let mut other = scene.clone();
        (other.cam, other.load.process) = (mirrored(&scene.cam), Some(mirrored(&process)));
        other.drive = DriveMode::Constant { w: -14.0, phi_start: -0.4 };
        let [mut scene, mut other] = [scene, other].map(started);
        for drive in [&mut scene, &mut other] {
            run(drive, 2.0, 20);
        }
        let error = error(&scene, other.state.map(|y| -y), [0.05, 1.0]);
        assert!(error < 1e-10, "linear {linear}, {process:?}: {error:e}");
    }
}

/// Cam and process may be counted from another angle.
#[test]
fn the_origin_of_the_angle_does_not_matter() {
    let shift = 1.1;
    for linear in [false, true] {
        for shifted in [true, false] {
            let mut drives = [0.0, shift].map(|by| {
                let mut scene = press(linear, 14.0, 0.4 + by);
                let delayed = |law: &MotionLaw, by: f64| MotionLaw::Fourier(law.series().unwrap().delayed(by));
                scene.cam = delayed(&scene.cam, by);
                let process = scene.load.process.take().unwrap();
                scene.load.process = Some(delayed(&process, if shifted { by } else { 0.0 }));
                started(scene)
            });
            drives.iter_mut().for_each(|drive| run(drive, 2.0, 20));
            let error = error(&drives[0], drives[1].state, [0.05, 1.0]);
            assert_eq!(error < 1e-10, shifted, "linear {linear}: {error:e}");
        }
    }
}

/// c q = U′ F_L, reached as the load grows, and kept at rest; beyond the snap-through there is no equilibrium.
#[test]
fn a_loaded_shaft_rests_in_its_equilibrium() {
    let mut r = Random(7);
    let (mut rested, mut refused) = (0, 0);
    for case in 0..120 {
        let linear = case % 2 == 0;
        let mut scene = press(linear, 0.0, r.between(-20.0, 20.0));
        scene.start = start(StartMode::Equilibrium);
        scene.parameters.c = r.scale(1.0, 1e3);
        scene.parameters.b = 0.3;
        scene.load.constant = Some(r.between(-900.0, 900.0));
        if case % 3 == 0 {
            scene.load.process = Some(cycle_of(r.between(-900.0, 900.0), r.between(0.0, 6.0), StandardLaw::SimpleSine));
        }
        let mut drive = ElasticShaft::new(scene.clone()).unwrap();
        let Err(fault) = drive.start(0.0) else {
            let start = drive.state;
            let lagrange = Lagrange { scene: &scene, input: &none };
            let inside = [lagrange.shaft()[1]; 2];
            let torque = |q: f64| {
                if linear {
                    let d = |k: f64| {
                        lagrange.torque(0.0, inside, [1e-3 * k, 0.0]) - lagrange.torque(0.0, inside, [-1e-3 * k, 0.0])
                    };
                    lagrange.torque(0.0, inside, [0.0; 2]) + q * (45.0 * d(1.0) - 9.0 * d(2.0) + d(3.0)) / 60e-3
                } else {
                    lagrange.torque(0.0, inside, [q, 0.0])
                }
            };
            assert!(torque(start[0]).abs() < 1e-9 * (1.0 + scene.parameters.c * start[0].abs()), "case {case}");
            // The way there: no other balance lies between.
            if !linear {
                let between = (1..500).map(|i| torque(start[0] * f64::from(i) / 500.0));
                assert!(between.into_iter().all(|torque| torque * start[0] < 0.0), "case {case}");
            }
            run(&mut drive, 3.0, 7);
            let moved = [drive.state[0] - start[0], drive.state[1]];
            assert!(moved.iter().all(|moved| moved.abs() < 1e-9), "case {case}: {moved:?} from {start:?}");
            rested += 1;
            continue;
        };
        assert!(fault.message.contains("snaps through"), "{}", fault.message);
        refused += 1;
    }
    assert!(rested > 60 && refused > 10, "{rested} rest, {refused} are refused");
    // Without a load the spring is relaxed.
    let scene = Scene { load: Load::default(), start: start(StartMode::Equilibrium), ..press(false, 14.0, 1.0) };
    assert_eq!(started(scene).state, [0.0; 2]);
}

#[test]
fn the_periodic_motion_under_load_repeats_itself() {
    for (linear, w) in [(false, 14.0), (true, 14.0), (false, -9.0), (true, -9.0)] {
        for process in [load().process, Some(cycle_of(60.0, 0.5, StandardLaw::ModifiedSine))] {
            let mut scene = press(linear, w, 0.7);
            (scene.load.process, scene.start) = (process, start(StartMode::SteadyState));
            // Only the load that moves with the follower damps the shaft.
            scene.parameters.b = 0.0;
            scene.load.damping = Some(300.0);
            let mut drive = started(scene);
            let begun = drive.state;
            run(&mut drive, 3.0 * TAU / w.abs(), 17);
            let error = error(&drive, begun, [0.05, 1.0]);
            assert!(begun[0] != 0.0 && error < 1e-9, "linear {linear}, {w}: {error:e} from {begun:?}");
        }
    }
}

/// ∫ tau ω dt is the energy that shaft, follower and the load's springs store and the dampers dissipate, less the work of the
/// process.
#[test]
fn the_energy_is_balanced() {
    let mut scene = press(false, 14.0, 0.0);
    scene.solver.tolerance = 1e-13;
    let energy = |drive: &ElasticShaft| {
        let Parameters { m, inertia, c, .. } = drive.equation.parameters;
        let [speed, y, rate] = ["der(psi)", "y", "der(y)"].map(|name| get(drive, name));
        let kinetic = 0.5 * inertia * speed * speed + 0.5 * m * rate * rate;
        kinetic + 0.5 * c * drive.state[0].powi(2) + scene.load.potential(m, y)
    };
    let process = scene.load.process.clone().unwrap();
    let mut drive = started(scene.clone());
    let (before, steps) = (energy(&drive), 90);
    let (mut work, mut supplied) = (0.0, 0.0);
    for n in 0..steps {
        let (t, h) = (0.01 * f64::from(n), 0.01);
        let begun = drive.clone();
        let [power, tau] = Gauss::with(8).integrate(h, |s| {
            let mut drive = begun.clone();
            drive.advance(t, s).unwrap();
            let rate = get(&drive, "der(y)");
            let dissipated = drive.state[1].powi(2) + 15.0 * rate * rate;
            let [phi, tau] = ["phi", "tau"].map(|name| get(&drive, name));
            [process.at(phi % TAU).0[0] * rate - dissipated, 14.0 * tau]
        });
        (work, supplied) = (work + power, supplied + tau);
        drive.advance(t, h).unwrap();
    }
    let miss = energy(&drive) - before - work - supplied;
    assert!(miss.abs() < 1e-10, "{miss:e}");
    assert!((supplied / 2.13484845683081 - 1.0).abs() < 1e-10, "{supplied}");
}

#[test]
fn a_loaded_drive_restored_goes_on_bit_by_bit() {
    let step = |drive: &mut ElasticShaft, n: i32| {
        let t = 0.05 * f64::from(n);
        if drive.force.is_some() {
            set(drive, "F", 20.0 * (7.0 * t).sin());
            let list = drive.variables();
            list.0[variable(drive, "F")].set_derivative(drive, 1, 140.0 * (7.0 * t).cos());
        }
        if n == 12 {
            set(drive, "load.F0", 11.0);
            set(drive, "load.process.a[1]", 25.0);
        }
        drive.apply(t).unwrap();
        drive.advance(t, 0.05).unwrap();
    };
    for (linear, input) in [(false, false), (true, false), (false, true), (true, true)] {
        let mut scene = press(linear, 14.0, 0.4);
        (scene.load.input, scene.load.constant) = (input, Some(5.0));
        let mut drive = started(scene.clone());
        for n in 0..30 {
            if [5, 12, 13, 20].contains(&n) {
                let plain = n == 12;
                if plain {
                    // Changed, but no step taken yet.
                    set(&mut drive, "load.F0", 7.0);
                }
                let mut made = ElasticShaft::new(scene.clone()).unwrap();
                for name in ["load.F0", "load.process.a[1]"] {
                    let value = get(&drive, name);
                    set(&mut made, name, value);
                }
                let bytes = postcard::to_stdvec(&drive).unwrap();
                let mut restored: ElasticShaft = postcard::from_bytes(&bytes).unwrap();
                restored.restored(&made).unwrap();
                let mut on = drive.clone();
                for k in n..n + 4 {
                    step(&mut on, k);
                    step(&mut restored, k);
                    assert_eq!(on.state, restored.state, "linear {linear}, input {input}, from step {n}");
                }
            }
            step(&mut drive, n);
        }
    }
}

/// A tuned load acts from the next step on.
#[test]
fn a_load_may_be_tuned() {
    for linear in [false, true] {
        let mut drive = started(press(linear, 14.0, 0.4));
        run(&mut drive, 0.5, 5);
        let begun = drive.state;
        set(&mut drive, "load.g", 0.0);
        set(&mut drive, "load.c", 0.0);
        set(&mut drive, "load.b", 40.0);
        set(&mut drive, "load.process.b[1]", -50.0);
        drive.apply(0.5).unwrap();
        drive.advance(0.5, 0.4).unwrap();
        let mut scene = press(linear, 14.0, 0.4 + 7.0);
        scene.load.gravity = None;
        scene.load.spring = Some(Spring { c: 0.0, ..scene.load.spring.unwrap() });
        (scene.load.damping, scene.load.process) = (Some(40.0), Some(fourier(&[0.0, 20.0, -12.0], &[-50.0, 0.0, 3.0])));
        let expected = Lagrange { scene: &scene, input: &none }.run(begun, 0.4);
        let error = error(&drive, expected, [0.05, 1.0]);
        assert!(error < 1e-9, "linear {linear}: {error:e}");
    }
}

#[test]
fn the_estimate_under_load_covers_the_error() {
    let mut r = Random(99);
    let mut ratios = Vec::new();
    while ratios.len() < 120 {
        let (mut scene, span) = random_scene(&mut r);
        let Parameters { c, m, .. } = scene.parameters;
        // A load that twists the shaft by about a twentieth of a radian, with springs of its stiffness.
        let (u, slope) = (scene.cam.bound(0), scene.cam.bound(1));
        let (force, stiffness) = (0.05 * c / slope, c / (slope * slope));
        let part = |r: &mut Random, size: f64| (r.next() < 0.6).then(|| size * r.between(-1.0, 1.0));
        let process = match (3.0 * r.next()) as usize {
            0 => None,
            1 => Some(fourier(&[0.0, force * r.next()], &[0.0, force * r.next()])),
            _ => Some(cycle_of(force * r.next(), r.between(0.0, TAU), StandardLaw::Polynomial345)),
        };
        scene.load = Load {
            gravity: part(&mut r, force / m),
            constant: part(&mut r, force),
            spring: part(&mut r, stiffness).map(|c| Spring { preload: 0.3 * force, c: c.abs(), at: u * r.next() }),
            damping: part(&mut r, 0.1 * (stiffness * m).sqrt()).map(f64::abs),
            process,
            input: false,
            ..Load::default()
        };
        let states = |scene: &Scene| {
            let mut drive = ElasticShaft::new(scene.clone()).unwrap();
            drive.start(0.0).ok()?;
            let mut states = Vec::new();
            for n in 0..20 {
                let t = span * f64::from(n) / 20.0;
                drive.advance(t, span * f64::from(n + 1) / 20.0 - t).ok()?;
                states.push(drive.state);
            }
            Some((states, drive.solver.error_estimate))
        };
        let finest = Settings { tolerance: 1e-15, ..scene.solver };
        let Some((truth, own)) = states(&Scene { solver: finest, ..scene.clone() }) else { continue };
        let Some((got, estimate)) = states(&scene) else { continue };
        let error = relative_error(&scene.start, &got, &truth);
        // Differences below the finest run's own error do not count.
        if error > 10.0 * own {
            ratios.push(estimate / error);
        }
    }
    assert_honest("loads", ratios, 1e3);
}

#[test]
fn the_log_tells_once_that_the_cam_begins_to_pull() {
    let told = |linear: bool, load: Load| {
        let mut drive = ElasticShaft::new(Scene { load, ..press(linear, 14.0, 0.0) }).unwrap();
        drive.log.keep(true);
        drive.start(0.0).unwrap();
        (0..200).for_each(|n| drive.advance(f64::from(n) * 1e-2, 1e-2).unwrap());
        drive.log.iter().map(|e| e.kind).filter(|kind| kind.contains("BacklashDrive with s = \"inf\"")).count()
    };
    for linear in [false, true] {
        let held_by = |preload: f64| Load { spring: Some(Spring { preload, c: 3e3, at: 0.0 }), ..Load::default() };
        assert_eq!([10.0, 5e3].map(|preload| told(linear, held_by(preload))), [1, 0], "{linear}");
        assert_eq!(told(linear, Load { damping: Some(3.0), ..Load::default() }), 0, "{linear}");
    }
}
