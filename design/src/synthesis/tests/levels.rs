//! Own points, integral tolerances, longest dwells, fewest harmonics and several laws, against second-order cone programs
//! (Clarabel) refined in 40 digits.

use super::*;
use camdrive::motion::MotionLaw;
use camdrive::motion::table::Points;

/// Degrees, U and weight of a motion that is known at some points.
const POINTS: [[f64; 3]; 11] = [
    [0.0, 0.0, 1.0],
    [25.0, 0.04, 1.0],
    [60.0, 0.31, 2.0],
    [95.0, 0.72, 1.0],
    [130.0, 0.97, 1.0],
    [165.0, 1.03, 1.0],
    [200.0, 0.95, 1.0],
    [230.0, 0.71, 2.0],
    [265.0, 0.38, 1.0],
    [300.0, 0.11, 1.0],
    [335.0, 0.015, 1.0],
];

const EVEN: Symmetry = Symmetry { even: true, half_wave: false };

/// Without any condition.
fn empty(basis: Basis, objective: Objective) -> Task {
    Task { basis, ranges: Vec::new(), ..symmetric_task(1, 0.5, objective) }
}

/// U = `u` within `half` degrees of `centre`.
fn around(law: usize, centre: f64, half: f64, u: f64) -> Range {
    let [from, to] = [centre - half, centre + half].map(f64::to_radians);
    Range { law, from, to, prescribed: [Some(Curve::polynomial(vec![u])), None, None], weight: 1.0 }
}

fn point(law: usize, degrees: f64, value: f64) -> ExactPoint {
    ExactPoint { law, phi: degrees.to_radians(), order: 0, value }
}

/// Bounds of Σ αⱼ Uⱼ⁽ⁿ⁾ between angles in degrees.
fn bound(of: &[(usize, f64)], angles: [f64; 2], order: usize, range: [f64; 2]) -> Bound {
    let ([from, to], [min, max]) = (angles.map(f64::to_radians), range);
    Bound { of: of.to_vec(), from, to, order, around: Curve::default(), min, max }
}

fn assert_near(name: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() <= tolerance, "{name}{k}: {found} instead of {expected}");
    }
}

fn own_points(objective: Objective) -> Task {
    let mut task = empty(Basis::new(3, Symmetry::default()), objective);
    let range = |[phi, u, weight]: [f64; 3]| Range { weight, ..around(0, phi, 0.0, u) };
    task.ranges = POINTS.map(range).to_vec();
    task
}

#[test]
fn own_points_by_least_squares() {
    let profile = own_points(Objective::LeastSquares).solve().unwrap();
    assert_near("S", &[profile.objective], &[6.065185856792658e-4], 1e-17);
    let a = [0.496253789272, -0.524599902352, 0.00640608899794, 0.0160914837703];
    assert_near("a", &profile.series.a, &a, 1e-12);
    assert_near("b", &profile.series.b[1..], &[0.143909361131, -0.0311233393132, -0.0251775991103], 1e-12);
}

#[test]
fn own_points_by_the_largest_error() {
    let profile = own_points(Objective::Chebyshev).solve().unwrap();
    assert_near("E", &[profile.objective], &[0.01013378691415692], 1e-15);
    let a = [0.497101891905, -0.526681874764, 0.00657116321654, 0.0128750327287];
    assert_near("a", &profile.series.a, &a, 1e-12);
    assert_near("b", &profile.series.b[1..], &[0.144091491430, -0.0315468098936, -0.0217188251696], 1e-12);
}

#[test]
fn fewer_points_than_coefficients() {
    // Through (0°, 0), (180°, 1): of a₀ + Σ aₖ cos kφ with a₀ + Σ aₖ = 0 and a₀ + Σ ± aₖ = 1 the least Σ k⁴ aₖ² has
    // aₖ ~ 1/k⁴ over the odd k, Σ aₖ = −1/2.
    for objective in [Objective::LeastSquares, Objective::Chebyshev] {
        let mut task = empty(Basis::new(4, Symmetry::default()), objective);
        task.ranges = vec![around(0, 0.0, 0.0, 0.0), around(0, 180.0, 0.0, 1.0)];
        let profile = task.solve().unwrap();
        let first = -0.5 / (1.0 + 1.0 / 81.0);
        assert_near("a", &profile.series.a, &[0.5, first, 0.0, first / 81.0, 0.0], 1e-12);
        assert_eq!(profile.undetermined, 7);
    }
}

#[test]
fn the_least_peak_under_an_integral_tolerance() {
    let basis = Basis::new(5, Symmetry { even: true, half_wave: true });
    let mut task = empty(basis, Objective::PeakAcceleration);
    task.ranges = vec![around(0, 0.0, 30.0, 0.5), around(0, 180.0, 30.0, -0.5)];
    task.integral = Some(1e-5);
    let profile = task.solve().unwrap();
    assert_near("U″", &[profile.objective], &[0.8627972643448896], 2e-15);
    let peak = deviation::peak(&profile.series, 2);
    assert!((peak.value.abs() - profile.objective).abs() < 1e-14, "{peak:?}");
    assert_near("c", &profile.series.a[1..], &[0.562865401661, 0.0, -0.057461306306, 0.0, -0.00537002271874], 3e-12);
    // The optimum of least squares is the least integral.
    let least = Task { objective: Objective::LeastSquares, integral: None, ..task.clone() }.solve().unwrap().objective;
    match (Task { integral: Some(0.9 * least), ..task }).solve() {
        Err(Infeasible::Integral { least: found }) => assert!((found / least - 1.0).abs() < 1e-12),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_least_mean_square_under_an_integral_tolerance() {
    let mut task = empty(Basis::new(5, EVEN), Objective::MeanSquareAcceleration);
    task.ranges = vec![around(0, 0.0, 40.0, 0.0), around(0, 180.0, 15.0, 1.0)];
    task.integral = Some(1e-5);
    let profile = task.solve().unwrap();
    assert_near("∫U″²", &[profile.objective], &[1.955818447584507], 5e-14);
    let c = [0.429653883084, -0.549905396529, 0.0823845413618, 0.0480639395144, -0.00960583825526, 0.00114668921498];
    assert_near("c", &profile.series.a, &c, 1e-11);
    // A tolerance that does not bind changes nothing: without any the profile would stand still.
    let loose = Task { integral: Some(10.0), ..task }.solve().unwrap();
    assert!(loose.objective < 1e-20, "{}", loose.objective);
}

#[test]
fn the_target_is_a_function() {
    // tanh(3 sin φ)/2 = Σ bₖ sin kφ; bₖ decreases as exp(−k arsinh(π/6)), the 71st is below 1e-15.
    let function = |phi: f64| 0.5 * (3.0 * phi.sin()).tanh();
    let samples = 512;
    let b = |k: usize| {
        let term = |i: usize| TAU * i as f64 / samples as f64;
        (0..samples).map(|i| function(term(i)) * (k as f64 * term(i)).sin()).sum::<f64>() * 2.0 / samples as f64
    };
    let law = MotionLaw::Fourier(Fourier::new(vec![0.0], (0..=71).map(b).collect()));
    let mut task = empty(Basis::new(5, Symmetry::default()), Objective::Chebyshev);
    let mut range = around(0, 12.5, 82.5, 0.0);
    let (from, to) = (range.from, range.to);
    range.prescribed[0] = Some(Curve::law(law.clone(), TAU, from));
    task.ranges = vec![range];
    task.points = vec![point(0, 180.0, 0.0)];
    let profile = task.solve().unwrap();
    assert_near("E", &[profile.objective], &[0.01037395219791388], 1e-14);
    let a = [0.342762120845, -0.403362555847, -0.113988261301, 0.345529662478, -0.228563854662, 0.0580428982509];
    let b = [0.620558829789, -0.217113388369, 0.563088188056, -0.375347806637, 0.202943897707];
    assert_near("a", &profile.series.a, &a, 1e-11);
    assert_near("b", &profile.series.b[1..], &b, 1e-11);

    // A table that reaches from -80 to 95 degrees, a turn later: between the points, at the ends too, its error in U⁽ⁿ⁾ falls with
    // the step at least as h⁵⁻ⁿ.
    let error = |steps: usize, order: usize| {
        let angle = |i: usize| (280.0 + 175.0 * i as f64 / steps as f64).to_radians();
        let angles: Vec<f64> = (0..=steps).map(angle).collect();
        let lifts: Vec<f64> = angles.iter().map(|phi| function(*phi)).collect();
        let curve = Curve::table(&angles, &lifts, TAU, [from, to]).unwrap();
        let curve = (0..order).fold(curve, |curve, _| curve.derivative());
        let exact = (0..order).fold(Curve::law(law.clone(), TAU, from), |curve, _| curve.derivative());
        let places = (0..=1000).map(|i| (to - from) * f64::from(i) / 1000.0);
        places.fold(0.0_f64, |worst, x| worst.max((curve.at(x) - exact.at(x)).abs()))
    };
    for order in 0..3 {
        let [coarse, fine] = [50, 100].map(|steps| error(steps, order));
        assert!(coarse / fine > 2f64.powi(5 - order as i32), "{order}: {coarse:e}, {fine:e}");
    }
    // Closer points at the ends keep 3 degrees, so that U″ of the ends errs as their polynomial of degree five does.
    assert!(error(3500, 0) < 1e-10 && error(3500, 2) < 2e-3, "{:e} {:e}", error(3500, 0), error(3500, 2));
}

#[test]
fn a_part_of_a_turn_is_a_target() {
    // A rise of 10 mm over 100 degrees, a polynomial, exact and printed to a micrometre, in few and in many points.
    let rise = |z: f64| 0.01 * (10.0 - 15.0 * z + 6.0 * z * z) * z.powi(3);
    let range = [20f64, 120.0].map(f64::to_radians);
    let table = |steps: usize, grain: f64| {
        let part = |i: usize| i as f64 / steps as f64;
        let angles: Vec<f64> = (0..=steps).map(|i| range[0] + (range[1] - range[0]) * part(i)).collect();
        let lifts: Vec<f64> = (0..=steps).map(|i| (rise(part(i)) / grain).round() * grain).collect();
        let curve = Curve::table(&angles, &lifts, TAU, range).unwrap();
        (0..=997)
            .map(|i| curve.at((range[1] - range[0]) * f64::from(i) / 997.0) - rise(f64::from(i) / 997.0))
            .fold(0.0, |worst: f64, e| worst.max(e.abs()))
    };
    for steps in [5, 10, 100, 2000] {
        assert!(table(steps, 1e-18) < 1e-13, "{steps}: {:e}", table(steps, 1e-18));
    }
    for steps in [100, 2000, 5000] {
        assert!(table(steps, 1e-6) < 1.5e-6, "{steps}: {:e}", table(steps, 1e-6));
    }
    // Points that leave out 95 … 290 degrees reach from there over the end of the turn, not into the hole.
    let angles: Vec<f64> = (0..=95).chain(290..360).map(|deg| f64::from(deg).to_radians()).collect();
    let lifts: Vec<f64> = angles.iter().map(|phi| phi.sin()).collect();
    let target = |from: f64, to: f64| Curve::table(&angles, &lifts, TAU, [from.to_radians(), to.to_radians()]);
    let curve = target(-70.0, 95.0).unwrap();
    let worst =
        (0..=165).map(|i| (curve.at((f64::from(i)).to_radians()) - (f64::from(i) - 70.0).to_radians().sin()).abs());
    assert!(worst.fold(0.0, f64::max) < 1e-12);
    assert!(target(150.0, 250.0).unwrap_err().contains("290 deg to 455 deg, not from 150 deg to 250 deg"));
    assert!(Curve::table(&angles[..4], &lifts[..4], TAU, [0.0, 0.05]).unwrap_err().contains("at least 5"));
    let closes = |angles: Vec<f64>, lifts: Vec<f64>| Curve::closes(&Points { angles, lifts });
    assert!(!closes(angles.clone(), lifts.clone()));
    let degrees = |step: usize| (0..360).step_by(step).map(|deg| (deg as f64).to_radians()).collect::<Vec<_>>();
    assert!(closes(degrees(30), degrees(30).iter().map(|phi| phi.sin()).collect()));
    // A rise that fills its period jumps back at its end.
    assert!(!closes(degrees(1), (0..360).map(|deg| rise(f64::from(deg) / 359.0)).collect()));
}

fn dwelling(order: usize) -> Task {
    let mut task = empty(Basis::new(order, EVEN), Objective::LongestDwell { tolerance: 1e-3, dwells: [0, 1] });
    task.ranges = vec![around(0, 0.0, 30.0, 0.0)];
    task.points = vec![point(0, 180.0, 1.0)];
    task
}

#[test]
fn the_longest_dwell() {
    for (start, order, limit, degrees, c) in [
        (30.0, 4, None, 169.130857503874, &[0.229632289209, -0.395190022376, 0.247046316798, -0.104309977624][..]),
        (89.0, 5, Some(1.6), 152.545867411890, &[0.272199296820, -0.447082359212, 0.235867981644, -0.0612449281291]),
    ] {
        let mut task = dwelling(order);
        task.ranges = vec![around(0, 0.0, start, 0.0)];
        task.bounds.extend(limit.map(|limit| bound(&[(0, 1.0)], [0.0, 360.0], 2, [-limit, limit])));
        let Solved { task: settled, tried, .. } = task.solve_with(&|_, _| {}).unwrap();
        let width = (settled.ranges[0].to - settled.ranges[0].from).to_degrees();
        assert!((width - degrees).abs() < 1e-10, "{width} instead of {degrees}; {tried:?}");
        assert_near("c", &settled.solve().unwrap().series.a, c, 1e-11);
    }
    // A dwell that any width keeps, since nothing moves.
    let mut still = dwelling(3);
    still.points.clear();
    assert!(matches!(still.solve(), Err(Infeasible::Numerical(fault)) if fault.message.contains("whole turn")));
}

#[test]
fn the_fewest_harmonics() {
    let mut task = empty(Basis::new(9, EVEN), Objective::FewestHarmonics { tolerance: 1e-3 });
    task.ranges = vec![around(0, 0.0, 50.0, 0.0), around(0, 180.0, 20.0, 1.0)];
    let Solved { task: settled, tried, .. } = task.solve_with(&|_, _| {}).unwrap();
    assert_eq!(settled.basis.order(), 4);
    let levels: Vec<f64> = tried.iter().map(|[_, level]| *level).collect();
    assert_near("E", &levels, &[0.0920796384142, 0.0290041004537, 0.0115563699447, 0.00099289405389], 1e-13);
    task.bounds = vec![bound(&[(0, 1.0)], [0.0, 360.0], 2, [-1.7, 1.7])];
    let c = [0.409603932662, -0.566177826651, 0.126186083365, 0.0659075101811, -0.0365125936117];
    assert_near("c", &task.solve().unwrap().series.a, &c, 1e-11);
    task.basis = Basis::new(3, EVEN);
    assert!(matches!(task.solve(), Err(Infeasible::Numerical(fault)) if fault.message.contains("with all 3")));
}

/// Two tools that pass each other.
fn two_laws() -> Task {
    let basis = Basis::joined(&[Basis::new(6, EVEN), Basis::new(8, EVEN)]);
    let mut task = empty(basis, Objective::PeakAcceleration);
    task.laws = vec![1.0, 1.0];
    task.bounds = vec![
        bound(&[(0, 1.0)], [-35.0, 35.0], 0, [-0.004, 0.004]),
        bound(&[(1, 1.0)], [95.0, 265.0], 0, [-0.005, 0.005]),
    ];
    task.points = vec![point(0, 180.0, 1.0), point(1, 0.0, 1.0)];
    task
}

#[test]
fn two_laws_with_the_least_sum_of_peaks() {
    let profiles = two_laws().solve_with(&|_, _| {}).unwrap().profiles;
    assert_near("t", &[profiles[0].objective], &[2.045125259746496], 5e-13);
    let sum: f64 = profiles.iter().map(|p| deviation::peak(&p.series, 2).value.abs()).sum();
    assert_near("sum", &[sum], &[2.045125259746496], 1e-12);
    let u = [0.423625524410, -0.530465486973, 0.0752259041335, 0.0295925337369, -0.000231025120518, 0.00155809134722];
    assert_near("U₁ c", &profiles[0].series.a, &u, 1e-11);
    // Alone each law is the same.
    let alone: f64 = (0..2).map(|law| two_laws().only(law).solve().unwrap().objective).sum();
    assert_near("alone", &[alone], &[2.045125259746496], 1e-12);
}

#[test]
fn restrictions_of_two_laws() {
    let mut task = two_laws();
    let (both, free) = ([(0, 1.0), (1, 1.0)], f64::INFINITY);
    task.bounds.push(bound(&both, [0.0, 180.0], 0, [-free, 1.02]));
    task.bounds.push(bound(&both, [30.0, 100.0], 0, [-free, 0.42]));
    task.bounds.push(bound(&both, [20.0, 160.0], 0, [0.15, free]));
    let profiles = task.solve_with(&|_, _| {}).unwrap().profiles;
    assert_near("t", &[profiles[0].objective], &[6.224292550616602], 2e-12);
    let u = [0.412811409057, -0.522449329451, 0.0881762357177, 0.0195464069286, -0.00184083484314, 0.00490292252272];
    assert_near("U₁ c", &profiles[0].series.a, &u, 1e-10);
    let sum = |degrees: f64| profiles.iter().map(|p| p.series.at(degrees.to_radians()).0[0]).sum::<f64>();
    assert_near("active", &[sum(30.0), sum(100.0), sum(49.7376496)], &[0.42, 0.42, 0.15], 1e-11);
    // Both at once cannot be.
    task.bounds.push(bound(&both, [40.0, 60.0], 0, [0.5, free]));
    assert!(matches!(task.solve(), Err(Infeasible::Bound { .. })));
}

#[test]
fn two_tools_keep_clear() {
    let mut task = two_laws();
    // (U₁ − 0.3)² + (U₂ − 0.3)² ≥ 0.26².
    let directions = [0.0, PI / 2.0];
    task.clearances = vec![Clearance { laws: [0, 1], offset: [-0.3, 0.3], directions, distance: 0.26 }];
    let profiles = task.solve_with(&|_, _| {}).unwrap().profiles;
    assert_near("t", &[profiles[0].objective], &[2.263269980416225], 1e-9);
    let u = [0.275027272298, 0.452892532586, 0.239240915571, 0.0584353205678, -0.0140291935127, -0.0122539246641];
    assert_near("U₂ c", &profiles[1].series.a, &u, 1e-8);
    let least = task.clearances[0].least(&[profiles[0].series.clone(), profiles[1].series.clone()]);
    let touching = least.phi.to_degrees();
    assert!((least.value - 0.26).abs() < 1e-11, "{least:?}");
    assert!((touching.min(360.0 - touching) - 67.5241646).abs() < 1e-4, "{touching}");
    let refused =
        |task: &Task| matches!(task.solve(), Err(Infeasible::Numerical(fault)) if fault.message.contains("clear"));
    task.clearances[0].distance = 3.0;
    assert!(refused(&task));
    // U₂(0) = 1 and |U₁(0)| ≤ 0.004 leave at most √(0.304² + 0.7²) at φ = 0.
    task.clearances[0].distance = 1.0;
    let Err(Infeasible::Numerical(fault)) = task.solve() else { panic!("the tools cannot be that far apart") };
    let found: f64 =
        fault.message.split("side; ").nth(1).and_then(|rest| rest.split(' ').next()?.parse().ok()).expect("a distance");
    assert!((0.65..0.7632).contains(&found), "{fault}");
    // On one line 0.1 + U₁ − U₂ leads from −0.9 to 1.1: through each other.
    task.clearances = vec![Clearance { laws: [0, 1], offset: [0.1, 0.0], directions: [0.0; 2], distance: 0.1 }];
    assert!(refused(&task));
}
