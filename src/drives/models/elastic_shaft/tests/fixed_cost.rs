//! The method `fixed_cost`: bounded work, an honest error estimate, the same numbers for any communication step.

use super::extremes::{AT_REST, Random, assert_honest, random_scene, relative_error};
use super::*;

/// A nonlinear drive at constant speed or any drive on inputs, the angle of its run, φ and ω at the start, and α of its inputs.
struct Case {
    scene: Scene,
    span: f64,
    steps: i32,
    ramp: [f64; 3],
}

fn random_case(r: &mut Random, on_inputs: bool) -> Case {
    let (mut scene, span) = random_scene(r);
    let DriveMode::Constant { w, phi_start } = scene.drive else { unreachable!() };
    let steps = r.scale(20.0, 300.0) as i32;
    let ramp = [phi_start, w, 0.5 * w / span * r.between(-1.0, 1.0)];
    if on_inputs {
        scene.drive = DriveMode::Input;
    } else {
        scene.linear = false;
    }
    Case { scene, span, steps, ramp }
}

impl Case {
    fn with(&self, solver: Settings) -> Scene {
        Scene { solver, ..self.scene.clone() }
    }

    /// φ = φ₀ + ω t + α t²/2 as inputs.
    fn set_inputs(&self, drive: &mut ElasticShaft, t: f64) {
        let [phi, w, a] = self.ramp;
        drive.cam.set_inputs([phi + (w + 0.5 * a * t) * t, w + a * t, a]);
    }

    /// The drive after each communication step; None if it ends in a fault.
    fn run(&self, scene: Scene, mut after: impl FnMut(&ElasticShaft)) -> Option<()> {
        let inputs = scene.drive == DriveMode::Input;
        let mut drive = ElasticShaft::new(scene).unwrap();
        if inputs {
            self.set_inputs(&mut drive, 0.0);
        }
        drive.start(0.0).unwrap();
        for n in 0..self.steps {
            let time = self.span * f64::from(n) / f64::from(self.steps);
            if inputs {
                self.set_inputs(&mut drive, time);
            }
            drive.advance(time, self.span * f64::from(n + 1) / f64::from(self.steps) - time).ok()?;
            after(&drive);
        }
        Some(())
    }
}

fn fixed_cost(step_size: f64) -> Settings {
    Settings { method: Method::FixedCost, step_size, ..Settings::default() }
}

/// Estimate over error for random cases; returns how many runs end in a fault.
fn honesty(seed: u64, on_inputs: bool, settings: impl Fn(&mut Random, &Case) -> Settings) -> (Vec<f64>, usize) {
    let r = &mut Random(seed);
    let (mut ratios, mut faults) = (Vec::new(), 0);
    for n in 0..120 {
        let mut case = random_case(r, on_inputs);
        if n % 2 == 0 {
            case.scene.start = AT_REST;
        }
        let solver = settings(r, &case);
        let (mut got, mut truth, mut estimates) = (Vec::new(), Vec::new(), [0.0; 2]);
        // Between the ends of steps the tolerance decides, at the ends its square: shorter steps would only add roundings.
        let finest = Settings { tolerance: if on_inputs { 1e-12 } else { 1e-14 }, ..Settings::default() };
        let known = case.run(case.with(finest), |drive| {
            truth.push(drive.state);
            estimates[0] = drive.solver.error_estimate;
        });
        let ends = case.run(case.with(solver), |drive| {
            got.push(drive.state);
            estimates[1] = drive.solver.error_estimate;
        });
        if known.is_none() || ends.is_none() {
            faults += 1;
            continue;
        }
        // The inputs are rounded, and so is the truth.
        let angle = if on_inputs { case.ramp[1].abs() * case.span } else { 0.0 };
        let error = relative_error(&case.scene.start, &got, &truth).max(0.3 * f64::EPSILON * angle);
        let ratio = estimates[1] / error.max(1e-15);
        // A difference that the truth's own error may cause does not count.
        ratios.push(if error <= estimates[1] + estimates[0] { ratio.max(1.0) } else { ratio });
    }
    (ratios, faults)
}

/// Half of the cases with the usual step, half with one of a tenth to one radian of vibration or highest harmonic.
fn random_step(r: &mut Random, case: &Case) -> Settings {
    let vibration = (case.scene.parameters.inertia / case.scene.parameters.c).sqrt();
    let harmonic = (case.scene.cam.resolution() * case.ramp[1].abs()).recip();
    let step = vibration.min(harmonic) * r.scale(0.1, 1.0);
    fixed_cost(if r.next() < 0.5 { 0.0 } else { step })
}

#[test]
fn the_error_estimate_is_honest_at_constant_speed() {
    let (ratios, faults) = honesty(7, false, random_step);
    assert!(faults <= 12, "{faults} faults");
    assert_honest("constant speed", ratios, 100.0);
}

#[test]
fn the_error_estimate_is_honest_on_inputs() {
    let (ratios, faults) = honesty(8, true, random_step);
    assert!(faults <= 12, "{faults} faults");
    assert_honest("inputs", ratios, 100.0);
}

#[test]
fn the_error_estimate_by_tolerance_is_honest_on_inputs() {
    let tolerance = |r: &mut Random, _: &Case| Settings { tolerance: r.scale(1e-12, 1e-5), ..Settings::default() };
    let (ratios, faults) = honesty(9, true, tolerance);
    assert!(faults <= 6, "{faults} faults");
    assert_honest("tolerance on inputs", ratios, 100.0);
}

/// Equal steps and steps by tolerance on inputs of constant speed, against the drive at constant speed, which knows the angle to
/// all digits: the angles of the inputs are rounded.
#[test]
fn the_error_estimate_is_honest_where_angles_are_rounded() {
    let r = &mut Random(10);
    let mut ratios = Vec::new();
    for n in 0..150 {
        let mut case = random_case(r, true);
        let [phi_start, w, _] = case.ramp;
        case.ramp[2] = 0.0;
        case.scene.drive = DriveMode::Constant { w, phi_start };
        let finest = case.with(Settings { tolerance: 1e-14, ..Settings::default() });
        case.scene.drive = DriveMode::Input;
        let solver = if n % 2 == 0 { random_step(r, &case) } else { Settings::default() };
        let (mut got, mut truth, mut estimates) = (Vec::new(), Vec::new(), [0.0; 2]);
        let known = case.run(finest, |drive| {
            truth.push(drive.state);
            estimates[0] = drive.solver.error_estimate;
        });
        let ends = case.run(case.with(solver), |drive| {
            got.push(drive.state);
            estimates[1] = drive.solver.error_estimate;
        });
        // The truth of a growing vibration is known to fewer digits.
        if known.is_none() || ends.is_none() || estimates[0] > 1e-11 {
            continue;
        }
        let error = relative_error(&case.scene.start, &got, &truth);
        let ratio = estimates[1] / error.max(1e-15);
        // A difference that the truth's own error may cause does not count.
        ratios.push(if error <= estimates[1] + estimates[0] { ratio.max(1.0) } else { ratio });
    }
    assert_honest("rounded angles", ratios, 100.0);
}

#[test]
fn the_work_of_a_communication_step_is_bounded() {
    // A smooth law takes one solution per internal step; each takes 8 evaluations to begin with and 8 per iteration.
    let solution = 8.0 * (1.0 + 4.0);
    let passages = crate::drives::solver::oscillation::steps::ATTEMPTS as f64;
    for (law, per_step) in [(profile(), 1.0), (cycle(StandardLaw::ModifiedTrapezoid), passages)] {
        for step_size in [1e-4, 3e-3] {
            let mut scene = manipulator(law.clone(), false, CONSTANT);
            scene.solver = fixed_cost(step_size);
            let mut drive = started(scene);
            let (mut time, r) = (0.0, &mut Random(3));
            for _ in 0..300 {
                let h = r.scale(1e-6, 0.1);
                let before = drive.solver.evaluations;
                drive.advance(time, h).unwrap();
                time += h;
                let work = drive.solver.evaluations - before;
                let bound = ((h / step_size).ceil() + 1.0) * per_step * solution;
                assert!(work <= bound, "{work} evaluations over {h} s, bound {bound}");
            }
        }
    }
}

#[test]
fn the_answer_does_not_depend_on_the_communication_step() {
    for law in [profile(), cycle(StandardLaw::Polynomial345)] {
        let mut scene = manipulator(law, false, CONSTANT);
        scene.solver = fixed_cost(0.0);
        let ends = [1, 7, 1234].map(|steps| {
            let mut drive = started(scene.clone());
            run(&mut drive, 3.0, steps);
            (drive.state, drive.solver.error_estimate)
        });
        assert!(ends[0] == ends[1] && ends[0] == ends[2], "{ends:?}");
        assert!(ends[0].1 < 1e-6, "{ends:?}");
    }
}

#[test]
fn equal_steps_that_are_too_long_are_refused() {
    for (step_size, law) in [(0.5, profile()), (1e-9, profile()), (0.2, cycle(StandardLaw::ModifiedTrapezoid))] {
        let mut scene = manipulator(law, false, CONSTANT);
        scene.solver = fixed_cost(step_size);
        let mut drive = started(scene);
        let fault = (0..100).find_map(|n| drive.advance(f64::from(n), 1.0).err()).unwrap();
        assert!(fault.to_string().contains("solver.step_size"), "{fault}");
        assert!(drive.is_finite());
    }
}

#[test]
fn the_table_of_the_linear_equation_leaves_no_method_to_choose() {
    let list = ElasticShaft::new(manipulator(profile(), true, CONSTANT)).unwrap().variables().0;
    assert!(list.iter().all(|v| v.description.name != "solver.method"));
}

#[test]
fn growth_without_bound_ends_in_a_fault() {
    // The speed at which the stiffness swings twice per vibration, without damping: by the table, by the tolerance and by equal
    // steps.
    let order = MotionLaw::Fourier(Fourier::new(vec![0.0, 0.2], vec![]));
    let mut unstable = manipulator(order, true, DriveMode::Constant { w: 95.0, phi_start: 0.3 });
    (unstable.parameters.b, unstable.parameters.m) = (0.0, 60.0);
    for way in 0..3 {
        let mut scene = unstable.clone();
        if way == 2 {
            scene.solver = fixed_cost(0.0);
        }
        let mut drive = started(scene);
        if way > 0 {
            (drive.table, drive.trajectory) = (None, None);
        }
        let mut n = 0;
        let fault = loop {
            match drive.advance(f64::from(n), 1.0) {
                Ok(()) => assert!(drive.is_finite() && n < 10_000, "{way}: {:?}", drive.state),
                Err(fault) => break fault,
            }
            n += 1;
        };
        assert!(fault.to_string().contains("without bound"), "{way}: {fault}");
        assert!(drive.is_finite());
    }
}
