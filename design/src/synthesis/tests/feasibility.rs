//! Tasks that cannot be fulfilled, and such as hardly can.

use super::super::study::{Assignment, Elasticity, Method, Names};
use super::super::together::Together;
use super::*;
use crate::report::terminal::shown;
use crate::report::unit::MM;
use camdrive::numerics::double_double::Double;

/// The number of coefficients that the exact points leave free.
fn free(task: &Task) -> Result<usize, Infeasible> {
    Ok(Conditions { task, scale: 1.0 }.equalities()?.free.len())
}

fn degrees(from: f64, to: f64, u: f64) -> Range {
    let zero = || Some(Curve::polynomial(vec![0.0]));
    let prescribed = [Some(Curve::polynomial(vec![u])), zero(), zero()];
    Range { law: 0, from: from.to_radians(), to: to.to_radians(), prescribed, weight: 1.0 }
}

fn bound(from: f64, to: f64, order: usize, min: f64, max: f64) -> Bound {
    Bound {
        of: vec![(0, 1.0)],
        from: from.to_radians(),
        to: to.to_radians(),
        order,
        around: Curve::default(),
        min,
        max,
    }
}

fn task(order: usize, ranges: Vec<Range>, bounds: Vec<Bound>) -> Task {
    let basis = Basis::new(order, Symmetry::default());
    Task { basis, ranges, bounds, weights: [0.0; 2], ..symmetric_task(order, 0.5, Objective::Chebyshev) }
}

#[test]
fn a_point_beyond_a_bound_is_named() {
    // U ≤ 4 everywhere and U(180°) = 5; U′ ≥ −4.5 from −180° to −27° and U′(293°) = −5, which is at −67°.
    let dwell = || vec![degrees(-30.0, 30.0, 5.0)];
    for (order, bound, phi, value, expected) in [
        (0, bound(0.0, 360.0, 0, f64::NEG_INFINITY, 4.0), 180.0_f64, 5.0, 1.0),
        (1, bound(-180.0, -27.0, 1, -4.5, f64::INFINITY), 293.0, -5.0, 0.5),
    ] {
        let mut task = task(5, dwell(), vec![bound]);
        task.points = vec![ExactPoint { law: 0, phi: phi.to_radians(), order, value }];
        let fault = task.solve().unwrap_err();
        match fault {
            Infeasible::Outside { point: 0, bound: 0, by } => assert!((by - expected).abs() < 1e-12, "{by}"),
            ref other => panic!("{other:?}"),
        }
        let names =
            Names { points: vec!["point[1]".to_owned()], bounds: vec!["bound[1]".to_owned()], ..Names::default() };
        let text = fault.fault(&task, &names).to_string();
        assert!(text.contains("`point[1]`") && text.contains("of `bound[1]` by"), "{text}");
        // Beyond the bound the point is free.
        task.bounds[0].to = -1.5;
        task.bounds[0].from = -2.0;
        assert!(task.solve().is_ok());
    }
}

#[test]
fn the_bounds_that_contradict_each_other_are_named() {
    // 0.99 at least from 73° to 175°, 0.3 at most from 154° to 218°; another tolerance and another bound can be kept.
    let mut task = task(11, vec![degrees(73.0, 175.0, 1.0)], Vec::new());
    let tolerance = Bound { around: Curve::polynomial(vec![1.0]), ..bound(73.0, 175.0, 0, -0.01, 0.01) };
    let easy = bound(-39.0, -11.0, 0, -0.5, 0.5);
    task.bounds = vec![easy, tolerance, bound(154.0, 218.0, 0, f64::NEG_INFINITY, 0.3)];
    for objective in [Objective::Chebyshev, Objective::LeastSquares, Objective::ChebyshevSum] {
        task.objective = objective;
        match task.solve().unwrap_err() {
            Infeasible::Bound { index, by, others, points: false, .. } => {
                assert!((by / 0.345 - 1.0).abs() < 1e-9, "{by}");
                let mut all: Vec<usize> = others.into_iter().map(|(i, _)| i).chain([index]).collect();
                all.sort_unstable();
                assert_eq!(all, [1, 2]);
            }
            other => panic!("{other:?}"),
        }
    }
    // An exact point against a bound of another derivative: by Bernstein's inequality |U′| is at most K max |U|.
    task.objective = Objective::Chebyshev;
    task.ranges.clear();
    task.bounds = vec![bound(0.0, 360.0, 0, -1.0, 1.0)];
    task.points = vec![ExactPoint { law: 0, phi: 2.0, order: 1, value: 22.0 }];
    match task.solve().unwrap_err() {
        Infeasible::Bound { index: 0, by, points: true, .. } => assert!((by - 1.0).abs() < 1e-8, "{by}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_bound_in_a_short_range_does_not_let_the_profile_grow() {
    let mut task = task(11, vec![degrees(116.0, 219.0, 1.0), degrees(-3.0, 28.0, 0.0)], Vec::new());
    task.ranges[0].weight = 5.0;
    task.weights = [0.05, 0.2];
    let free = task.solve().unwrap();
    task.bounds = vec![bound(-76.0, -52.0, 0, f64::NEG_INFINITY, 3.0)];
    let kept = task.solve().unwrap();
    let highest = Window { from: -76_f64.to_radians(), to: -52_f64.to_radians(), order: 0, target: &Curve::default() };
    assert!(highest.largest(&kept.series).value < 3.0 + 1e-14);
    assert!(kept.objective >= free.objective * (1.0 - 1e-9) && kept.excess < 1e-11 * kept.objective, "{kept:?}");
    // By another linear program over 1501 angles of each range.
    assert!((kept.objective / 1.831607e-03 - 1.0).abs() < 1e-3, "{:e}", kept.objective);
}

#[test]
fn least_squares_under_bounds_that_touch() {
    let mut task = task(8, vec![degrees(100.0, 170.0, 1.0), degrees(-20.0, 40.0, 0.0)], Vec::new());
    task.objective = Objective::LeastSquares;
    task.weights = [0.5, 0.0];
    task.bounds = vec![bound(0.0, 360.0, 0, 0.0, 1.0), bound(40.0, 100.0, 2, -3.0, 3.0)];
    let profile = task.solve().unwrap();
    assert!(profile.excess < 1e-15, "{:e}", profile.excess);
    // No profile on the way to another one that keeps the bounds has a smaller sum.
    let squares = Conditions { task: &task, scale: 1.0 }.samples();
    let cost = |x: &[Double]| convex::square(&squares, x);
    let here = task.basis.coefficients(&profile.series, 1.0);
    for objective in [Objective::Chebyshev, Objective::PeakAcceleration, Objective::ChebyshevSum] {
        let other = Task { objective, ..task.clone() }.solve().unwrap();
        let there = task.basis.coefficients(&other.series, 1.0);
        for part in [1.0, 0.1, 1e-3] {
            let between: Vec<Double> =
                here.iter().zip(&there).map(|(x, y)| *x + Double::from(part) * (*y - *x)).collect();
            assert!(cost(&between) >= cost(&here) * (1.0 - 1e-12), "{objective:?} {part}");
        }
    }
}

/// A task whose ranges have these names.
fn assignment(task: Task, ranges: &[&str]) -> Assignment {
    let ranges = ranges.iter().map(|name| (*name).to_owned()).collect();
    Assignment {
        name: "task".to_owned(),
        description: String::new(),
        unit: 1.0,
        task,
        names: Names { ranges, ..Names::default() },
        elasticity: None,
        shaft: None,
        scene: None,
        files: Vec::new(),
    }
}

#[test]
fn the_report_tells_the_deviations_of_what_is_delivered() {
    let elasticity = Elasticity {
        w0: 100.0,
        damping: 0.03,
        slowest: 0.0,
        fastest: Some(13.0),
        tolerance: None,
        method: Method::Robust,
        amplitude: None,
    };
    let task = symmetric_task(5, PI / 6.0, Objective::Chebyshev);
    let assignment = Assignment { elasticity: Some(elasticity), ..assignment(task, &[]) };
    let together = Together::new(&assignment, &|_| {}).unwrap();
    let study = &together.studies[0];
    let behind = study.elastic.as_ref().unwrap();
    let largest = |list: &[[f64; 3]]| list.iter().map(|e| e[0]).fold(0.0, f64::max);
    // The worst speed is what the robust problem made small, and more than at rest.
    let objective = behind.objective.unwrap();
    assert!((largest(&behind.over_speeds) / objective - 1.0).abs() < 1e-4, "{behind:?}");
    assert!((behind.worst.unwrap() / objective - 1.0).abs() < 1e-4);
    assert!((largest(&behind.at_rest) - assignment.task.largest_error(&study.cam)).abs() < 1e-15);
    assert!(largest(&behind.at_rest) <= largest(&behind.over_speeds));
    assert!(objective > study.motion.objective);
    let text = together.report().text(400, true);
    for words in ["`) from 0 to 124 rpm.", "Largest errors of the output, 0 to 124 rpm", "η = Ω/ω₀ = 0.1300 (124 rpm)"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
    // At the lower dwell's centre the band encloses the cam at rest.
    let [low, high] = behind.envelope(PI);
    let u = study.cam.at(PI).0[0];
    assert!(low <= u && u <= high && high - low > 1e-5);
}

#[test]
fn without_damping_a_standard_law_resonates_at_every_speed() {
    let elasticity = Elasticity {
        w0: 100.0,
        damping: 0.0,
        slowest: 0.0,
        fastest: None,
        tolerance: Some(1e-3),
        method: Method::None,
        amplitude: None,
    };
    let task = symmetric_task(5, PI / 6.0, Objective::Chebyshev);
    let assignment = Assignment { elasticity: Some(elasticity), ..assignment(task.clone(), &[]) };
    let together = Together::new(&assignment, &|_| {}).unwrap();
    let behind = together.studies[0].elastic.clone().unwrap();
    let (reaches, curves) = (&behind.reaches[1..], &behind.curves[1..]);
    assert!(!reaches.is_empty() && reaches.iter().all(|eta| *eta == Some(0.0)), "{reaches:?}");
    assert!(curves.iter().all(Vec::is_empty));
    // Damping lets the same law reach a speed.
    let range = SpeedRange { damping: 0.05, slowest: 0.0, fastest: 1.0 };
    let damped = elastic::reachable(&task, &laws::rivals(&task)[0].series, range, 1e-3);
    assert!(damped.is_some_and(|eta| eta > 0.01), "{damped:?}");
}

#[test]
fn more_harmonics_are_told_with_their_error_at_the_width_of_the_task() {
    let half = 30.5 * PI / 180.0;
    for objective in [Objective::LeastSquares, Objective::Chebyshev] {
        let verdict = |order: usize| {
            let task = assignment(symmetric_task(order, half, objective), &["lower", "upper"]);
            Together::new(&task, &|_| {}).unwrap().verdict()
        };
        let reached = symmetric_task(5, half, objective).solve().unwrap();
        let error = symmetric_task(5, half, objective).largest_error(&reached.series);
        let text = format!("5 harmonics meet these dwells within {}", shown(error, &MM));
        let advice = verdict(3).advice;
        assert!(advice.iter().any(|advice| advice.text.contains(&text)), "{text}: {advice:?}");
    }
}

/// U⁽ⁿ⁾ = value at an angle in degrees, converted as a task file is.
fn point(phi: f64, order: usize, value: f64) -> ExactPoint {
    ExactPoint { law: 0, phi: phi * PI / 180.0, order, value }
}

#[test]
fn a_point_that_the_symmetry_fulfils_is_no_condition() {
    let even = Symmetry { even: true, half_wave: false };
    let quarter = Symmetry { even: true, half_wave: true };
    for order in [6, 64] {
        for (symmetry, phi, n) in [
            (even, 0.0, 1),
            (even, 180.0, 1),
            (even, -180.0, 3),
            (even, 540.0, 1),
            (even, 720.0, 3),
            (quarter, 90.0, 2),
            (quarter, 270.0, 2),
            (quarter, 180.0, 1),
        ] {
            let basis = Basis::new(order, symmetry);
            let (all, case) = (basis.size(), format!("K = {order}: {symmetry:?}, {n}, {phi}"));
            let mut task = Task { basis, ..task(order, Vec::new(), Vec::new()) };
            task.points = vec![point(phi, n, 0.0), point(10.0, 0, 0.5)];
            assert_eq!(free(&task), Ok(all - 1), "{case}");
            task.points.pop();
            assert_eq!(free(&task), Ok(all), "{case}, alone");
            // Another value than zero nothing can fulfil.
            task.points.push(point(20.0, 0, 0.5));
            task.points[0].value = 0.1;
            let Err(Infeasible::Point { index: 0, by }) = free(&task) else { panic!("{case}") };
            // The rounding of the angle, times waves of the size Kⁿ.
            assert!((by - 0.1).abs() < 1e-12 * (order as f64).powi(n as i32), "{case}: {by}");
        }
    }
}

#[test]
fn a_point_that_follows_from_others_changes_nothing() {
    let even = Symmetry { even: true, half_wave: false };
    let half_wave = Symmetry { even: false, half_wave: true };
    for (symmetry, given, following) in [
        (even, vec![point(40.0, 0, 0.3)], point(320.0, 0, 0.3)),
        (even, vec![point(40.0, 1, 0.3)], point(-40.0, 1, -0.3)),
        (even, vec![point(40.0, 2, 0.3)], point(40.0, 2, 0.3)),
        (half_wave, vec![point(25.0, 1, 0.3)], point(205.0, 1, -0.3)),
        (half_wave, vec![point(0.0, 0, 0.4), point(180.0, 0, 0.2), point(70.0, 0, 0.1)], point(250.0, 0, 0.5)),
    ] {
        let basis = Basis::new(7, symmetry);
        let mut task = Task { basis, ..task(7, Vec::new(), Vec::new()) };
        task.points = given;
        let before = free(&task).unwrap();
        task.points.push(following);
        assert_eq!(free(&task), Ok(before), "{following:?}");
        task.points.last_mut().unwrap().value += 0.01;
        assert!(matches!(free(&task), Err(Infeasible::Point { .. })), "{following:?}");
    }
}

#[test]
fn rest_at_the_turning_point_of_an_even_profile_costs_nothing() {
    // Near 0 within ±42° to 2 mm, 800 mm at 180°, |U′| ≤ 500 mm/rad: U′(180°) = 0 holds for every sum of cosines.
    let dwell = Bound { around: Curve::polynomial(vec![0.0]), ..bound(-42.0, 42.0, 0, -0.002, 0.002) };
    let mut task = task(6, vec![degrees(-42.0, 42.0, 0.0)], vec![dwell, bound(0.0, 360.0, 1, -0.5, 0.5)]);
    task.basis = Basis::new(6, Symmetry { even: true, half_wave: false });
    task.objective = Objective::PeakAcceleration;
    task.points = vec![point(180.0, 0, 0.8)];
    let free = task.solve().unwrap();
    // By another linear program.
    assert!((free.objective - 0.635).abs() < 1e-3, "{}", free.objective);
    task.points.push(point(180.0, 1, 0.0));
    let rests = task.solve().unwrap();
    assert!((rests.objective / free.objective - 1.0).abs() < 1e-9, "{} {}", rests.objective, free.objective);
    // A little off the axis it means U″(180°) = 0.
    let beside = |phi: f64, mut task: Task| {
        task.points[1].phi = phi;
        let mut assignment = assignment(task, &[]);
        assignment.names.points = vec!["point[1]".to_owned(), "point[2]".to_owned()];
        Together::new(&assignment, &|_| {}).unwrap().report().text(400, false)
    };
    let warning = "decides U′ at 180°; `point[2]`, close to it";
    assert!(beside(PI - 2.65e-6, task.clone()).contains(warning) && !beside(PI, task).contains(warning));
}

#[test]
fn half_wave_symmetry_is_about_the_mean() {
    // Dwells at 0 and 1, half a turn apart, are those at ∓½ about a mean of ½.
    let about_zero = symmetric_task(5, PI / 6.0, Objective::Chebyshev).solve().unwrap();
    let mut task = symmetric_task(5, PI / 6.0, Objective::Chebyshev);
    for range in &mut task.ranges {
        range.prescribed[0].as_mut().unwrap().add(0.5, &Curve::polynomial(vec![1.0]));
    }
    let lifted = task.solve().unwrap();
    assert!((lifted.series.a[0] - 0.5).abs() < 1e-15 && (lifted.objective - about_zero.objective).abs() < 1e-15);
    assert!((0..=5).step_by(2).skip(1).all(|k| lifted.series.a[k] == 0.0));
}

#[test]
fn a_task_that_no_motion_fulfils_best_is_refused() {
    // Equal dwells half a turn apart are the mean of a half-wave; those at φ and −φ are one where U is even.
    let half_wave = Symmetry { even: false, half_wave: true };
    let even = Symmetry { even: true, half_wave: false };
    let two = |first: f64, second: f64, u: [f64; 2]| {
        vec![degrees(first - 40.0, first + 40.0, u[0]), degrees(second - 40.0, second + 40.0, u[1])]
    };
    for (symmetry, ranges, rest) in [
        (half_wave, two(0.0, 180.0, [0.003; 2]), 0.003),
        (half_wave, two(0.0, 180.0, [0.0; 2]), 0.0),
        (even, two(60.0, 300.0, [0.004, 0.002]), 0.003),
    ] {
        for objective in [Objective::Chebyshev, Objective::LeastSquares, Objective::PeakAcceleration] {
            let mut task = Task { basis: Basis::new(7, symmetry), objective, ..task(7, ranges.clone(), Vec::new()) };
            for range in &mut task.ranges {
                range.prescribed[1..].fill(None);
            }
            if objective == Objective::PeakAcceleration {
                for range in &task.ranges {
                    let around = range.prescribed[0].clone().unwrap();
                    let Range { from, to, .. } = *range;
                    task.bounds.push(Bound {
                        of: vec![(0, 1.0)],
                        from,
                        to,
                        order: 0,
                        around,
                        min: -0.0011,
                        max: 0.0011,
                    });
                }
            }
            let assignment = assignment(task, &["dwell[1]", "dwell[2]"]);
            let fault = Together::new(&assignment, &|_| {}).unwrap_err();
            let Infeasible::Still { at } = fault else { panic!("{symmetry:?} {objective:?}: {fault:?}") };
            // The least peak of acceleration leaves the place free within the tolerances.
            let free = if objective == Objective::PeakAcceleration { 0.0011 } else { 1e-12 };
            assert!((at - rest).abs() <= free, "{symmetry:?} {objective:?}: {at}");
            let text = fault.fault(&assignment.task, &assignment.names).to_string();
            assert!(text.contains("`dwell[1]`, `dwell[2]` rests at U = ") && text.contains("hint"), "{text}");
        }
    }
}
