//! Stability against closed forms, against the printed numbers of the sources, and against an independent eigenproblem.

mod active;
mod approximations;
mod backwards;
mod extremes;
mod loads;
mod tables;

use super::hill;
use super::response;
use super::system::System;
use super::tongue::{Apex, Tongue, multipliers};
use super::{Options, figures, study};
use crate::oscillator::{PeriodicOscillator, Terms};
use crate::plot::Rule;
use camdrive::drives::unit;
use camdrive::motion::{Cycle, CyclePlan, Fourier, MotionLaw, StandardLaw};
use nalgebra::DMatrix;
use num_complex::Complex;
use std::f64::consts::PI;

type Coefficients = Box<dyn Fn(usize, f64) -> Terms + Send + Sync>;

fn oscillator(terms: Coefficients, reach: f64, inertia_turns: bool) -> PeriodicOscillator {
    PeriodicOscillator {
        terms,
        breakpoints: Vec::new(),
        reach: Box::new(move |_| reach),
        cost: 0.0,
        inertia_turns,
        own: None,
        speed: None,
        start: 0.0,
        coordinate: &unit::ANGLE,
        load: &unit::TORQUE,
        note: None,
    }
}

/// m(φ) q̈ + b q̇ + c(φ) q = 0 with the means m₀ = c₀ = 1.
fn parametric(m: Fourier, c: Fourier) -> PeriodicOscillator {
    let reach = 2.0 / m.order().max(c.order()).max(1) as f64;
    let terms = move |_: usize, phi: f64| Terms { m: m.at(phi).0[0], c: c.at(phi).0[0], ..Terms::default() };
    oscillator(Box::new(terms), reach, false)
}

/// 1 + Σ aₖ cos kφ + bₖ sin kφ.
fn series(a: &[f64], b: &[f64]) -> Fourier {
    Fourier::new([&[1.0], a].concat(), [&[0.0], b].concat())
}

fn mathieu(epsilon: f64) -> PeriodicOscillator {
    parametric(series(&[], &[]), series(&[-epsilon], &[]))
}

/// A shaft whose cam has the inertia J₃ = `ratio` · the mean of m U′², U = Σ aₖ cos kφ.
fn shaft(a: &[f64], ratio: f64) -> PeriodicOscillator {
    let law = Fourier::new([&[0.0], a].concat(), vec![]);
    let mean: f64 = a.iter().zip(1..).map(|(a, k)| 0.5 * (f64::from(k) * a).powi(2)).sum();
    let reach = 2.0 / a.len() as f64;
    let terms = move |_: usize, phi: f64| {
        let [_, u1, u2, u3, _] = law.at(phi).0;
        let (g, g1) = (u1 * u2, u2 * u2 + u1 * u3);
        Terms { m: ratio * mean + u1 * u1, b: 0.0, b1: 2.0 * g, c: 1.0, c2: g1, f2: -g, ..Terms::default() }
    };
    oscillator(Box::new(terms), reach, true)
}

/// One or two parallel cranks: c = sin²φ/(σ + sin²φ), the second one a quarter of a turn later on shafts of its own.
fn crank(sigma: f64, double: bool) -> PeriodicOscillator {
    let one = move |sine: f64| sine * sine / (sigma + sine * sine);
    let terms = move |_: usize, phi: f64| {
        let c = one(phi.sin()) + if double { one(phi.cos()) } else { 0.0 };
        Terms { m: 1.0, c, ..Terms::default() }
    };
    oscillator(Box::new(terms), sigma.sqrt().min(1.0), false)
}

/// The tongues of the orders n = 1 … `orders` with their apices.
fn tongues(system: &System, orders: usize) -> Vec<(Tongue, Option<Apex>)> {
    let start = hill::boundaries(system, orders);
    (1..=orders)
        .map(|n| {
            let tongue = Tongue::new(system, n, start.pairs[n - 1]);
            assert!(tongue.residual < 1e-14, "order {n}: {tongue:?}");
            (tongue, tongue.apex(system))
        })
        .collect()
}

/// θ* of the orders n = 1 … of an oscillator.
fn critical(oscillator: &PeriodicOscillator, orders: usize) -> Vec<f64> {
    let system = System::new(oscillator).unwrap();
    tongues(&system, orders).iter().map(|(_, apex)| apex.map_or(f64::INFINITY, |apex| apex.theta)).collect()
}

const HS5: [f64; 5] = [0.59404, 0.0, -0.11066, 0.0, 0.01667];

#[test]
fn tongues_of_a_ten_millionth_are_found() {
    // ε = 0.05: the tongues of the orders 2 and 5/2 are 7e-7 and 5e-8 of the speed wide.
    let scene = mathieu(0.05);
    let system = System::new(&scene).unwrap();
    for (n, (tongue, apex)) in (1..=5).zip(tongues(&system, 5)) {
        let theta = apex.unwrap().theta;
        // The leading order, ½ (ε/2)ⁿ/Π (1 − (1 − 2 k/n)²), whose relative error is of the order ε².
        let product: f64 = (1..n).map(|k| 1.0 - (1.0 - 2.0 * f64::from(k) / f64::from(n)).powi(2)).product();
        let leading = 0.5 * 0.025_f64.powi(n) / product;
        assert!((theta / leading - 1.0).abs() < 2.0 * 0.05_f64.powi(2), "{n}: {theta:e} instead of {leading:e}");
        // A narrow tongue is half an ellipse.
        let [low, high] = tongue.interval(&system, 0.5 * theta).unwrap();
        let [from, to] = tongue.interval(&system, 0.0).unwrap();
        let part = (high - low) / (to - from);
        assert!((part - 0.75_f64.sqrt()).abs() < 1e-3 * 0.1_f64.powi(n.min(3)) + 1e-15 / (to - from), "{n}: {part}");
    }
}

/// θ at the speed ratio η as an eigenvalue of Hill's truncated matrix, 2 i θ η k on its diagonal: without any
/// integration. The largest real eigenvalue of the orders of one kind.
fn hill_theta(eta: f64, half: bool, c: &Fourier, m: &Fourier, turning: bool) -> f64 {
    const N: i64 = 24;
    let orders: Vec<f64> = if half {
        (-N..N).map(|k| k as f64 + 0.5).collect()
    } else {
        (-N..=N).filter(|k| *k != 0).map(|k| k as f64).collect()
    };
    let coefficient = |list: &Fourier, k: i64| {
        let n = k.unsigned_abs() as usize;
        if n > list.order() {
            return Complex::new(0.0, 0.0);
        }
        let (a, b) = (list.a[n], list.b[n]);
        if n == 0 { Complex::new(a, 0.0) } else { Complex::new(0.5 * a, -0.5 * b * k.signum() as f64) }
    };
    let element = |n: f64, l: f64| {
        let k = (n - l).round() as i64;
        let waves = if turning { 0.5 * (n * n + l * l) } else { l * l };
        coefficient(c, k) - coefficient(m, k) * (eta * eta * waves)
    };
    let size = orders.len();
    let matrix = DMatrix::from_fn(size, size, |i, j| {
        // The constant, on which damping does not act, is eliminated.
        let through = if half {
            Complex::new(0.0, 0.0)
        } else {
            element(orders[i], 0.0) * element(0.0, orders[j]) / element(0.0, 0.0)
        };
        (element(orders[i], orders[j]) - through) * Complex::new(0.0, 1.0) / (2.0 * eta * orders[i])
    });
    let values = matrix.schur().eigenvalues().expect("an upper triangular matrix");
    values.iter().filter(|v| v.im.abs() < 1e-9).map(|v| v.re).fold(0.0, f64::max)
}

#[test]
fn critical_damping_is_an_eigenvalue_of_hills_matrix() {
    let one = series(&[], &[]);
    // J = J₃ + U′² of U = cos φ with J₃ = ½: 1 − ½ cos 2φ.
    let inertia = Fourier::new(vec![1.0, 0.0, -0.5], vec![]);
    let cases = [
        (mathieu(0.8), series(&[-0.8], &[]), one.clone(), false),
        (
            parametric(series(&[0.3], &[0.1]), series(&[0.2, 0.1], &[])),
            series(&[0.2, 0.1], &[]),
            series(&[0.3], &[0.1]),
            false,
        ),
        (shaft(&[1.0], 1.0), one.clone(), inertia, true),
    ];
    for (scene, c, m, turning) in cases {
        let system = System::new(&scene).unwrap();
        for (tongue, apex) in tongues(&system, 3) {
            let apex = apex.unwrap();
            for shift in [-1e-3, 0.0, 1e-3] {
                let eta = apex.eta * (1.0 + shift * apex.theta);
                let theta = tongue.critical_at(&system, 1.0 / eta);
                let expected = hill_theta(eta, tongue.j.fract() != 0.0, &c, &m, turning);
                assert!((theta - expected).abs() < 1e-11, "j = {}: {theta} instead of {expected}", tongue.j);
                assert!(theta <= apex.theta * (1.0 + 1e-13), "the apex is the highest point");
            }
        }
    }
}

#[test]
fn a_tongue_may_reach_to_infinite_speed() {
    // HS5 with J₃ = the mean of m U′²: a single boundary at 1.6106.
    let scene = shaft(&HS5, 1.0);
    let system = System::new(&scene).unwrap();
    let (tongue, apex) = tongues(&system, 1)[0];
    assert!(tongue.is_open() && apex.is_none());
    let [low, high] = tongue.interval(&system, 0.0).unwrap();
    assert!((low - 1.6106).abs() < 5e-5 && high.is_infinite(), "{low}");
    let [damped, high] = tongue.interval(&system, 0.2).unwrap();
    assert!(damped > low && high.is_infinite());
    // Beyond the boundary, at any speed, and not before it.
    for (eta, unstable) in [(0.999 * damped, false), (1.001 * damped, true), (50.0, true), (5e3, true)] {
        let m = system.monodromy(1.0 / (eta * eta), 2.0 * 0.2 / eta);
        assert_eq!(super::spectral_radius(&m) > 1.0, unstable, "η = {eta}");
    }
}

#[test]
fn the_order_is_that_of_the_oscillation_not_of_the_speed() {
    // HS3 with J₃ = the mean of m U′²: the first tongue lies at 1.48 … 1.54.
    let scene = shaft(&[0.57474, 0.0, -0.07637], 1.0);
    let system = System::new(&scene).unwrap();
    let (tongue, _) = tongues(&system, 2)[0];
    let [low, high] = tongue.interval(&system, 0.0).unwrap();
    assert!(tongue.j == 1.0 && (low - 1.48).abs() < 0.01 && (high - 1.54).abs() < 0.01, "{low} {high}");
}

#[test]
fn constant_coefficients_excite_nothing() {
    let scene = parametric(series(&[], &[]), series(&[], &[]));
    let report =
        study(["constant", "test"], &scene, &Options { speeds: vec![0.7], ..Options::default() }, &|_| ()).unwrap();
    assert_eq!((report.oscillator.periods_per_turn, report.orders.len()), (0, 0));
    assert!(report.verdict().result.iter().any(|line| line.contains("are constant over the turn")));
    // Undamped: on the border.
    assert!((report.speeds[0].radius - 1.0).abs() < 1e-14 && report.speeds[0].critical_damping == 0.0);
}

#[test]
fn classical_bounds_as_printed() {
    let one = || series(&[], &[]);
    let bounds = |scene: &PeriodicOscillator, twice: usize| System::new(scene).unwrap().printed().bounds(twice);
    let near = |value: f64, printed: f64| (value - printed).abs() < 0.51e-4;
    let half = 0.3 / 2_f64.sqrt();
    // Oscillator, 2 j, three terms, second order.
    let cases: Vec<(PeriodicOscillator, usize, f64, f64)> = vec![
        (mathieu(0.3), 1, 0.075, 0.075),
        (mathieu(0.3), 2, 0.01125, 0.01125),
        (mathieu(0.8), 2, 0.08, 0.08),
        (parametric(series(&[0.3], &[]), one()), 1, 0.075, 0.075),
        (parametric(series(&[0.3], &[]), one()), 2, 0.0, 0.0),
        (parametric(one(), series(&[0.3, 0.1], &[])), 2, 0.01375, 0.01375),
        (parametric(one(), series(&[0.4, 0.08], &[])), 2, 0.0, 0.0),
        (parametric(one(), series(&[half], &[half])), 2, 0.01125, 0.01125),
        (parametric(one(), series(&[0.3, 0.05], &[0.2, 0.1])), 2, 0.01179, 0.01179),
        (parametric(one(), series(&[0.2, 0.0, 0.2], &[])), 4, 0.0, 0.01333),
        (shaft(&[1.0], 1.0), 2, 0.125, 0.125),
        (shaft(&[1.0], 1.0), 4, 0.0078, 0.0078),
        (shaft(&HS5, 10.0), 2, 0.0388, 0.0190),
        (shaft(&HS5, 10.0), 4, 0.0246, 0.0205),
        (shaft(&HS5, 10.0), 6, 0.0101, 0.0105),
        (shaft(&HS5, 3.0), 2, 0.1067, 0.0435),
        (shaft(&HS5, 3.0), 4, 0.0713, 0.0400),
        (shaft(&HS5, 3.0), 6, 0.0278, 0.0307),
    ];
    for (i, (scene, twice, three_term, second_order)) in cases.iter().enumerate() {
        let found = bounds(scene, *twice);
        assert!(near(found.three_term, *three_term), "case {i}: {found:?} instead of {three_term}");
        assert!(near(found.second_order, *second_order), "case {i}: {found:?} instead of {second_order}");
    }
    // Wherever the angle is counted from.
    let turned =
        parametric(series(&[0.2 * 0.6], &[0.2 * 0.8]), series(&[0.3 * 0.6, 0.1 * -0.28], &[0.3 * 0.8, 0.1 * 0.96]));
    let straight = parametric(series(&[0.2], &[]), series(&[0.3, 0.1], &[]));
    for twice in 1..5 {
        let (a, b) = (bounds(&turned, twice), bounds(&straight, twice));
        assert!((a.three_term - b.three_term).abs() < 1e-15 && (a.second_order - b.second_order).abs() < 1e-15);
    }
}

/// The transfer manipulator: 60 kg, stroke 0.4 m, two dwells of 60°, J₃ = 1.5 kg·m², c = 2.4e4 N·m/rad, b = 17.85 N·m·s/rad.
fn manipulator(law: MotionLaw) -> PeriodicOscillator {
    let breakpoints = law.breakpoints().to_vec();
    let (m, inertia) = (60.0, 1.5);
    let reach = (0..breakpoints.len().max(1)).map(|i| 2.0 / law.resolution_in(i).max(1.0)).collect::<Vec<f64>>();
    let terms = move |segment: usize, phi: f64| {
        let [_, u1, u2, u3, _] = law.at_in(segment, phi).0;
        let (g, g1) = (m * u1 * u2, m * (u2 * u2 + u1 * u3));
        Terms { m: inertia + m * u1 * u1, b: 17.85, b1: 2.0 * g, c: 2.4e4, c2: g1, f2: -g, ..Terms::default() }
    };
    let mut scene = oscillator(Box::new(terms), 1.0, true);
    scene.breakpoints = breakpoints;
    scene.reach = Box::new(move |segment| reach[segment.min(reach.len() - 1)]);
    scene
}

fn cycle(law: StandardLaw) -> MotionLaw {
    MotionLaw::Cycle(Cycle::new(CyclePlan {
        stroke: 0.4,
        lower: 0.0,
        rise_start: PI / 6.0,
        rise_angle: PI / 1.5,
        upper_dwell: PI / 3.0,
        return_angle: PI / 1.5,
        rise_law: law,
        return_law: law,
        inflections: [None; 2],
    }))
}

#[test]
fn load_of_the_transfer_manipulator() {
    use StandardLaw::*;
    let hs3 = MotionLaw::Fourier(Fourier::new(vec![0.0, 0.4 * 0.57511499, 0.0, 0.4 * -0.0770508], vec![]));
    // R at 0.06 and 0.08 of √(2.4e4/3.69) rad/s.
    let printed = [
        (cycle(ModifiedTrapezoid), 2.45, 2.71),
        (cycle(InclinedSine), 1.52, 2.13),
        (cycle(Polynomial345), 1.21, 1.68),
        (cycle(ModifiedSine), 1.08, 1.38),
        (hs3, 1.12, 1.47),
    ];
    for (law, slow, fast) in printed {
        let scene = manipulator(law.clone());
        let system = System::new(&scene).unwrap();
        for (ratio, printed) in [(0.06, slow), (0.08, fast)] {
            let speed = ratio * (2.4e4_f64 / 3.69).sqrt();
            let eta = speed / system.natural_frequency();
            let motion = response::periodic_motion(&system, eta, system.damping_ratio()).unwrap();
            let found = motion.amplification.unwrap();
            assert!(
                motion.stable && (found - printed).abs() < 0.006,
                "{law:?} at {ratio}: {found} instead of {printed}"
            );
        }
    }
}

#[test]
fn a_start_from_rest_ends_in_the_periodic_motion() {
    // A constant oscillator under cos φ at η = 2, θ = 0.1: the closed form of both.
    let terms = |_: usize, phi: f64| Terms { m: 1.0, b: 0.2, c: 1.0, f: phi.cos(), ..Terms::default() };
    let scene = oscillator(Box::new(terms), 1.0, false);
    let system = System::new(&scene).unwrap();
    let t = response::transient(&system, 2.0, 0.1).unwrap();
    let amplitude = 1.0 / ((1.0 - 4.0_f64).powi(2) + (0.4_f64).powi(2)).sqrt();
    assert!((t.steady.amplitude / amplitude - 1.0).abs() < 1e-5, "{}", t.steady.amplitude);
    assert!((t.steady.load / (amplitude * (1.0 + 0.16_f64).sqrt()) - 1.0).abs() < 1e-5);
    assert!((t.steady.kinetostatic - 1.0).abs() < 1e-5);
    // 1000 = e^(θ 2π n/η).
    assert!((t.settled_after.unwrap() - 1000_f64.ln() / (0.1 * PI)).abs() < 1e-9);
    // q = A cos(φ − δ) + e^(−θτ)(…): the peak by brute force.
    let (theta, eta) = (0.1, 2.0);
    let delta = f64::atan2(2.0 * theta * eta, 1.0 - eta * eta);
    let nu = (1.0_f64 - theta * theta).sqrt();
    let (q0, v0) = (-amplitude * delta.cos(), -amplitude * eta * delta.sin());
    let motion = |time: f64| {
        let (s, c) = (nu * time).sin_cos();
        amplitude * (eta * time - delta).cos() + (-theta * time).exp() * (q0 * c + (v0 + theta * q0) / nu * s)
    };
    let peak = (0..2_000_000).map(|i| motion(f64::from(i) * 2e-5).abs()).fold(0.0, f64::max);
    assert!((t.peak / peak - 1.0).abs() < 1e-5, "{} instead of {peak}", t.peak);
}

#[test]
fn damping_and_modulation_agree_at_the_border() {
    // Of Mathieu's equation with ε = 0.3 and the damping at which the first tongue of ε = 0.15 vanishes.
    let theta = critical(&mathieu(0.15), 1)[0];
    let scene = mathieu(0.3);
    let options = Options { damping: Some(theta), orders: Some(3), ..Options::default() };
    let report = study(["mathieu", "test"], &scene, &options, &|_| ()).unwrap();
    assert!((report.orders[0].modulation_ratio.unwrap() - 2.0).abs() < 1e-8, "{:?}", report.orders[0]);
    assert!(report.orders[0].safety.unwrap() < 1.0 && report.orders[1].modulation_ratio.is_none());
    // Each line of both maps is a boundary: a multiplier of modulus 1.
    let system = System::new(&scene).unwrap();
    let residual = |modulation: f64, theta: f64, eta: f64| {
        let m = system.modulated(modulation).monodromy(1.0 / (eta * eta), 2.0 * theta / eta);
        (super::spectral_radius(&m) - 1.0).abs()
    };
    assert!(!report.over_damping.is_empty() && !report.over_modulation.is_empty());
    for region in &report.over_damping {
        for [theta, low, high] in &region.lines {
            assert!(residual(1.0, *theta, *low) < 1e-6 && residual(1.0, *theta, *high) < 1e-6, "{region:?}");
        }
    }
    for region in &report.over_modulation {
        for [modulation, low, high] in &region.lines {
            let theta = region.theta.unwrap();
            assert!(residual(*modulation, theta, *low) < 1e-6 && residual(*modulation, theta, *high) < 1e-6);
        }
    }
    for diagram in [figures::over_damping(&report), figures::over_modulation(&report)] {
        assert!(diagram.svg().contains("j = 0.5"));
    }
    // Orders of the second map are written where no border of a tongue passes: a letter is 2 % of the width at most, a line 4 %
    // of the height.
    let rules = figures::over_modulation(&report).rules;
    let ([low, high], top) = (report.ranges[0], report.ranges[2][1]);
    for (at, word) in
        rules.iter().filter_map(|rule| if let Rule::Word(at, word) = rule { Some((at, word)) } else { None })
    {
        for rule in &rules {
            let Rule::Border(points, _) = rule else { continue };
            for point in points.iter().filter(|point| (0.0..0.04 * top).contains(&(point[1] - at[1]))) {
                let distance = (point[0] / at[0]).ln().abs() / (high / low).ln();
                assert!(distance > 0.01 * word.chars().count() as f64, "{word} at {at:?}: {point:?}");
            }
        }
    }
    let files: std::collections::BTreeMap<_, _> = report.report().files().into_iter().collect();
    assert!(files["map.csv"].as_ref().unwrap().lines().count() > 40);
    assert!(files["csv"].as_ref().unwrap().starts_with("order,damped_low_rpm,damped_high_rpm,undamped_low_rpm"));
}

/// Numbers between 0 and 1 that fill the interval evenly, another sequence for each `which`.
fn number(which: usize, i: usize) -> f64 {
    const ROOTS: [f64; 6] =
        [0.618_033_988_75, 0.414_213_562_37, 0.732_050_807_57, 0.236_067_977_5, 0.645_751_311_06, 0.316_624_790_36];
    (0.37 + (i + 1) as f64 * ROOTS[which % 6] + 0.071 * (which / 6) as f64).fract()
}

#[test]
fn speeds_are_unstable_just_where_an_order_says_so() {
    let signed = |which: usize, i: usize, size: f64| size * (2.0 * number(which, i) - 1.0);
    let mut unstable = 0;
    for i in 0..9 {
        let scene = if i % 3 == 0 {
            let a = [0.6, signed(0, i, 0.1), signed(1, i, 0.15), signed(2, i, 0.03)];
            shaft(&a, 0.4 * 30_f64.powf(number(3, i)))
        } else {
            // Modulations up to 0.6 of mass, damping and stiffness.
            let vary = |which: usize| {
                series(&[signed(which, i, 0.3), signed(which + 1, i, 0.2)], &[0.0, signed(which + 2, i, 0.1)])
            };
            let (m, b, c) = (vary(0), vary(3), vary(6));
            let terms = move |_: usize, phi: f64| Terms {
                m: m.at(phi).0[0],
                b: 0.1 * b.at(phi).0[0],
                c: c.at(phi).0[0],
                ..Terms::default()
            };
            oscillator(Box::new(terms), 1.0, false)
        };
        let system = System::new(&scene).unwrap();
        let all = tongues(&system, 6);
        let slowest = 1.0 / all[5].0.lambda.low.sqrt();
        let highest = all.iter().filter_map(|(_, apex)| Some(apex.as_ref()?.theta)).fold(0.05, f64::max);
        for k in 0..24 {
            let (x, y) = (number(4, 25 * i + k), number(5, 25 * i + k));
            let (tongue, apex) = &all[k % 6];
            let (eta, theta) = match (tongue.interval(&system, 0.0), apex) {
                // About a tongue, or anywhere.
                (Some([low, high]), Some(apex)) if k % 12 < 6 => {
                    (low + (high - low) * (1.6 * x - 0.3), 1.2 * apex.theta * y)
                }
                _ => (slowest * (4.0 / slowest).powf(x), 1.2 * highest * y * y),
            };
            let radius = super::spectral_radius(&system.monodromy(1.0 / (eta * eta), 2.0 * theta / eta));
            let inside = all
                .iter()
                .any(|(tongue, _)| tongue.interval(&system, theta).is_some_and(|[low, high]| low < eta && eta < high));
            assert!((radius - 1.0).abs() < 1e-9 || (radius > 1.0) == inside, "{i}: η = {eta}, θ = {theta}: {radius}");
            unstable += usize::from(inside);
        }
    }
    assert!((20..120).contains(&unstable), "{unstable} of 216 points are unstable");
}

#[test]
fn what_makes_no_oscillator_is_refused() {
    let with =
        |m: f64, b: f64, c: f64| oscillator(Box::new(move |_, _| Terms { m, b, c, ..Terms::default() }), 1.0, false);
    for scene in [with(0.0, 0.0, 1.0), with(1.0, 0.0, 0.0), with(f64::NAN, 0.0, 1.0)] {
        assert!(System::new(&scene).is_err_and(|fault| fault.to_string().contains("natural frequency")));
    }
    for scene in [with(1.0, -0.1, 1.0), with(1.0, f64::NAN, 1.0)] {
        assert!(System::new(&scene).is_err_and(|fault| fault.to_string().contains("free motions grow at every speed")));
    }
    let varying =
        oscillator(Box::new(|_, phi| Terms { m: 1.0 + 1.5 * phi.cos(), c: 1.0, ..Terms::default() }), 1.0, false);
    assert!(System::new(&varying).is_err_and(|fault| fault.to_string().contains("inertia")));
}

#[test]
fn the_list_of_resonances_is_that_of_the_diagram() {
    // Without range, it reaches down to the second harmonic also where no parameter varies.
    for (epsilon, range, least) in [(0.2, None, 4), (0.2, Some([0.3, 0.8]), 2), (0.0, None, 2)] {
        let load = Fourier::new(vec![1.0; 9], vec![]);
        let mut oscillator = mathieu(epsilon);
        let stiffness = mathieu(epsilon).terms;
        oscillator.terms = Box::new(move |segment, phi| Terms { f: load.at(phi).0[0], ..stiffness(segment, phi) });
        let options = Options { damping: Some(0.03), quick: true, range, ..Options::default() };
        let report = study(["loaded", "ParametricDrive"], &oscillator, &options, &|_| {}).unwrap();
        let [low, high] = report.ranges[0];
        let (first, last) = (report.amplification.first().unwrap().eta, report.amplification.last().unwrap().eta);
        assert!((first / low - 1.0).abs() < 1e-12 && (last / high - 1.0).abs() < 1e-12, "{first} {last}");
        let listed: Vec<usize> = report.resonances.iter().map(|r| r.k).collect();
        // The mean stiffness is 1: the resonance of k lies next to η = 1/k, those in the range are at no end of it.
        let inside: Vec<usize> = (1..=8).filter(|k| (low..=high).contains(&(1.0 / *k as f64))).collect();
        assert_eq!(listed, inside, "{low} {high}");
        assert!(listed.len() >= least, "{listed:?}");
    }
}

#[test]
fn the_kinetostatic_load_over_the_turn_is_minus_u1_u2_and_the_load_has_the_peak_that_is_told() {
    // A shaft of m = c = 1 under HS3.
    let a = [0.575, 0.0, -0.077];
    let law = Fourier::new([&[0.0], &a[..]].concat(), vec![]);
    let scene = shaft(&a, 0.8);
    let system = System::new(&scene).unwrap();
    let (eta, theta) = (0.08, 0.03);
    let course = response::course(&system, eta, theta).unwrap();
    let square = (eta * system.natural_frequency()).powi(2);
    let mut peak = 0.0_f64;
    for [phi, load, kinetostatic] in &course {
        let [_, u1, u2, ..] = law.at(*phi).0;
        assert!((kinetostatic + u1 * u2 * square).abs() < 1e-15, "φ = {phi}");
        peak = peak.max(load.abs());
    }
    let told = response::periodic_motion(&system, eta, theta).unwrap().load;
    // Between samples, 750 a turn, at 13 vibrations a turn, the peak may be higher by ½ (13 π/750)².
    assert!(peak <= told * (1.0 + 1e-12) && peak > told * (1.0 - 2e-3), "{peak} instead of {told}");
    assert!(course[0][0] >= 0.0 && (course[course.len() - 1][0] - course[0][0] - 2.0 * PI).abs() < 1e-12);
    // In an instability no such motion is seen.
    let (tongue, _) = tongues(&system, 1)[0];
    let [low, high] = tongue.interval(&system, 0.0).unwrap();
    let inside = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * low };
    assert!(response::course(&system, inside, 1e-4).unwrap().iter().all(|point| point[1].is_nan()));
}

#[test]
fn without_damping_roundings_do_not_decide_whether_a_motion_is_seen() {
    let terms = |_: usize, phi: f64| Terms { m: 1.0, c: 1.0 - 0.3 * phi.cos(), f: phi.sin(), ..Terms::default() };
    let options = Options { speeds: vec![0.7], quick: true, ..Options::default() };
    let report = study(["", ""], &oscillator(Box::new(terms), 1.0, false), &options, &|_| {}).unwrap();
    let grows = |eta: f64| report.orders.iter().filter_map(|order| order.damped).any(|[a, b]| a < eta && eta < b);
    assert!(report.amplification.len() > 200);
    for at in &report.amplification {
        assert_eq!(at.stable, !grows(at.eta), "{at:?}");
    }
    assert!(report.courses[0].iter().all(|at| at[1].is_finite()));
    // Nothing decays: a start is followed for some turns only.
    assert_eq!(report.transients[0].as_ref().unwrap().settled_after, None);
}
