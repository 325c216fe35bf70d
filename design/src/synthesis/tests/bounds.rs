//! Largest errors under bounds, against another program for linear optimisation, and the limits of numbers.

use super::super::study::{Assignment, Elasticity, Method, Names};
use super::super::together::Together;
use super::interior_point::interior_point;
use super::*;
use crate::report::Level;
use nalgebra::DMatrix;

fn whole_turn(order: usize, min: f64, max: f64) -> Bound {
    Bound { of: vec![(0, 1.0)], from: 0.0, to: TAU, order, around: Curve::default(), min, max }
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn one_of<T: Copy>(&mut self, list: &[T]) -> T {
        list[(self.between(0.0, list.len() as f64) as usize).min(list.len() - 1)]
    }
}

/// A dwell at 1, a point elsewhere, U within bounds that touch the dwell or do not.
fn random_task(random: &mut Random) -> Task {
    let from = random.between(1.7, 2.8);
    let to = from + random.between(0.35, 1.9);
    let order = random.one_of(&[5, 6, 8, 10, 12]);
    let objective = random.one_of(&[Objective::Chebyshev, Objective::ChebyshevSum]);
    let mut task = Task { basis: Basis::new(order, Symmetry::default()), ..symmetric_task(order, 0.5, objective) };
    task.ranges =
        vec![Range { law: 0, from, to, prescribed: [Some(Curve::polynomial(vec![1.0])), None, None], weight: 1.0 }];
    task.points = vec![ExactPoint { law: 0, phi: 5.2, order: 0, value: random.between(0.0, 0.75) }];
    task.bounds = vec![whole_turn(0, -0.05, random.one_of(&[1.0005, 1.005, 1.05, 1.1]))];
    task
}

/// The least level over a grid of angles, from an interior point in other coordinates.
fn over_a_grid(task: &Task) -> f64 {
    let n = task.basis.size();
    let (mut rows, mut limits) = (Vec::new(), Vec::new());
    let mut add = |phi: f64, level: f64, limit: f64, sign: f64| {
        let row = task.basis.row(0, phi, 0, None).into_iter().map(|v| sign * v.hi).chain([-level]);
        rows.push(row.collect::<Vec<f64>>());
        limits.push(limit);
    };
    let range = &task.ranges[0];
    for phi in grid(range.from, range.to, 1601) {
        add(phi, 1.0, 1.0, 1.0);
        add(phi, 1.0, -1.0, -1.0);
    }
    for phi in grid(0.0, TAU, 1441) {
        add(phi, 0.0, task.bounds[0].max, 1.0);
        add(phi, 0.0, -task.bounds[0].min, -1.0);
    }
    for sign in [1.0, -1.0] {
        add(task.points[0].phi, 0.0, sign * task.points[0].value, sign);
    }
    let mut q = vec![0.0; n + 1];
    q[n] = 1.0;
    let a = DMatrix::from_fn(rows.len(), n + 1, |i, j| rows[i][j]);
    interior_point(&q, &a, &limits)[n]
}

#[test]
fn an_inactive_bound_changes_nothing() {
    let mut task = symmetric_task(7, PI / 18.0, Objective::Chebyshev);
    let free = task.solve().unwrap();
    assert_odd(&free, &[0.598793859], 1e-9);
    assert!((free.objective / 9.386e-10 - 1.0).abs() < 1e-4, "{:e}", free.objective);
    for symmetry in [Symmetry { even: true, half_wave: true }, Symmetry { even: false, half_wave: true }] {
        task.basis = Basis::new(7, symmetry);
        task.bounds = vec![whole_turn(2, -3.0, 3.0), whole_turn(0, -0.51, 0.51)];
        let bounded = task.solve().unwrap();
        assert!((bounded.objective / free.objective - 1.0).abs() < 1e-9, "{:e}", bounded.objective);
        for k in 0..=7 {
            let sine = bounded.series.b[k];
            let away = (bounded.series.a[k] - free.series.a[k]).abs().max(sine.abs());
            assert!(away < 1e-10, "{symmetry:?}, k = {k}: {away:e}");
        }
    }
}

#[test]
fn derivatives_without_weight_do_not_count() {
    // S5 then is S3.
    let degrees = |from: f64, to: f64, u: f64| {
        let zero = || Some(Curve::polynomial(vec![0.0]));
        let prescribed = [Some(Curve::polynomial(vec![u])), zero(), zero()];
        Range { law: 0, from: from.to_radians(), to: to.to_radians(), prescribed, weight: 1.0 }
    };
    let level = |objective: Objective| {
        let mut task = symmetric_task(11, 0.5, objective);
        task.basis = Basis::new(11, Symmetry::default());
        task.ranges = vec![degrees(72.0, 188.0, 1.0), degrees(-8.0, 46.0, 0.0)];
        task.weights = [0.0; 2];
        task.bounds = vec![whole_turn(3, f64::NEG_INFINITY, 30.0)];
        task.solve().unwrap().objective
    };
    let [sum, plain] = [Objective::ChebyshevSum, Objective::Chebyshev].map(level);
    assert!((sum / plain - 1.0).abs() < 1e-9 && (plain / 0.0497 - 1.0).abs() < 0.01, "{sum:e} {plain:e}");
}

#[test]
fn random_tasks_with_bounds_are_solved_to_their_optimum() {
    let mut random = Random(4);
    let mut compared = 0;
    for i in 0..60 {
        let task = random_task(&mut random);
        let profile = task.solve().unwrap_or_else(|fault| panic!("{i}: {fault:?}\n{task:?}"));
        let series = &profile.series;
        let turn = Window { from: 0.0, to: TAU, order: 0, target: &Curve::default() };
        let extremes = turn.extremes(series, 0.0).into_iter().map(|e| e.value);
        let [low, high] = extremes.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], u| [a.min(u), b.max(u)]);
        assert!(low > -0.05 - 1e-14 && high < task.bounds[0].max + 1e-14, "{i}: {low} {high}");
        assert!(worst(&profile) < profile.objective * (1.0 + 1e-8) + 1e-14, "{i}: {:e}", worst(&profile));
        // The other program resolves nothing smaller.
        if profile.objective > 1e-6 {
            let grid = over_a_grid(&task);
            let difference = (profile.objective - grid).abs();
            assert!(difference < 1e-3 * grid + 2e-8, "{i}: {:e} {grid:e}", profile.objective);
            compared += 1;
        }
    }
    assert!(compared > 5, "{compared}");
}

#[test]
fn bounds_that_contradict_a_tolerance_are_named() {
    let mut random = Random(9);
    for _ in 0..10 {
        let mut task = random_task(&mut random);
        let around = Curve::polynomial(vec![1.0]);
        let Range { from, to, .. } = task.ranges[0];
        // At least 0.99 here and at most 0.98 there: both give way by 0.005, and by what the profile cannot be straight.
        task.bounds = vec![
            whole_turn(0, -2.0, 0.98),
            Bound { of: vec![(0, 1.0)], from, to, order: 0, around, min: -0.01, max: 0.01 },
        ];
        match task.solve() {
            Err(Infeasible::Bound { by, .. }) => assert!((0.005..0.0051).contains(&by), "{by}"),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn nine_harmonics_in_half_a_degree() {
    // In 60 digits by the method of Remez.
    let profile = symmetric_task(9, 0.005, Objective::Chebyshev).solve().unwrap();
    let expected =
        [0.6056217584602319, -0.1345833606730923, 0.03460753441310675, -0.006180019859058821, 0.0005340876588124963];
    assert!((profile.objective / 2.346981783e-27 - 1.0).abs() < 1e-2, "{:e}", profile.objective);
    // The report's bounds on the coefficients hold, and are not much too careful.
    assert!((1e-12..1e-9).contains(&profile.uncertainty), "{:e}", profile.uncertainty);
    assert_odd(&profile, &expected, profile.uncertainty);
    // A wide dwell leaves nothing open.
    assert!(symmetric_task(9, PI / 6.0, Objective::Chebyshev).solve().unwrap().uncertainty < 1e-20);
}

#[test]
fn short_ranges_leave_no_coefficient_open() {
    for objective in [Objective::LeastSquares, Objective::Chebyshev] {
        assert_eq!(symmetric_task(7, 0.05, objective).solve().unwrap().undetermined, 0);
    }
}

#[test]
fn the_cam_leads_a_damped_output() {
    // By a linear program over a grid of speeds and angles: 0.1354 with cosines alone, 0.1395 with sines, too.
    let mut task = symmetric_task(5, PI / 6.0, Objective::Chebyshev);
    let damped = SpeedRange { damping: 0.03, ..SPEEDS };
    for (even, expected) in [(true, 0.1354), (false, 0.1395)] {
        task.basis = Basis::new(5, Symmetry { even, half_wave: true });
        let (_, fastest) = elastic::fastest_robust(&task, damped, 0.001).unwrap();
        assert!((fastest - expected).abs() < 1e-4, "{fastest}");
    }
}

#[test]
fn a_cam_that_would_stand_still_is_refused() {
    let task = symmetric_task(5, 0.35, Objective::Chebyshev);
    let elasticity = Elasticity {
        w0: 60.0,
        damping: 0.0,
        slowest: 0.0,
        fastest: Some(200.0),
        tolerance: None,
        method: Method::Robust,
        amplitude: None,
    };
    let mut assignment = Assignment {
        name: "fast".to_owned(),
        description: String::new(),
        unit: 1.0,
        task,
        names: Names::default(),
        elasticity: Some(elasticity),
        shaft: None,
        scene: None,
        files: Vec::new(),
    };
    match Together::new(&assignment, &|_| {}) {
        Err(Infeasible::Numerical(fault)) => assert!(fault.message.contains("k = 1 at 573 rpm"), "{fault}"),
        other => panic!("{other:?}"),
    }
    assignment.elasticity = Some(Elasticity { damping: 0.05, ..elasticity });
    let report = Together::new(&assignment, &|_| {}).unwrap().report();
    let text = report.text(400, false);
    assert_eq!(report.verdict.level, Level::Bad, "{text}");
    assert!(text.contains("resonances at") && text.contains("573 rpm (harmonic 1)"), "{text}");
    assert!(text.contains("this is not its motion"), "{text}");
    assert!(text.contains("`half_wave` instead of `even_half_wave`"), "{text}");
}
