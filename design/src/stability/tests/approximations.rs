//! The classical formulas against their numbers: θ*(σ) of the parallel crank and the borders (9)–(13).

use super::super::printed;
use super::*;
use camdrive::drives::parametric::Scene;
use camdrive::drives::parametric::crank::{ParallelCrank, SecondCrank};
use camdrive::drives::parametric::law::{CrankLaw, Law};
use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};

/// The tables have six digits after the point.
const DIGITS: f64 = 6e-7;

fn rods(second: SecondCrank) -> Scene {
    let crank = ParallelCrank { c_t1: 9e6, c_t2: 12e6, c_ab: 250e6, r: 0.3, second };
    let law = CrankLaw { crank, inertia: 900.0, ..CrankLaw::default() };
    let (drive, start) =
        (DriveMode::Constant { w: 24.0, phi_start: 0.0 }, Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 });
    Scene { law: Law::Crank(law), drive, load: Default::default(), start, solver: Default::default() }
}

#[test]
fn damping_of_a_parallel_crank_over_its_stiffness() {
    // σ; j = 1 and 2 by (9) and exact; j = 3 of second order and exact.
    let table = [
        (0.03, [0.073087, 0.070592, 0.063066, 0.056666, 0.048059, 0.047279]),
        (1.0 / 24.0, [0.083626, 0.080583, 0.070611, 0.062892, 0.052129, 0.051482]),
        (0.07, [0.102377, 0.098336, 0.083133, 0.073065, 0.057715, 0.057966]),
        (0.125, [0.126004, 0.120725, 0.097317, 0.084406, 0.061499, 0.064643]),
        (0.15, [0.133871, 0.128195, 0.101655, 0.087850, 0.061889, 0.066556]),
        (0.4, [0.176958, 0.169421, 0.122122, 0.104122, 0.055453, 0.074859]),
        (0.7, [0.199442, 0.191239, 0.130658, 0.111053, 0.045912, 0.078006]),
        (1.5, [0.223933, 0.215341, 0.138338, 0.117522, 0.030525, 0.080706]),
        (3.0, [0.238975, 0.230360, 0.142237, 0.120974, 0.018549, 0.082041]),
    ];
    let scene = rods(SecondCrank::None);
    for (sigma, expected) in table {
        let row = printed::row(&scene, sigma);
        assert_eq!(row.iter().map(|(j, _)| *j).collect::<Vec<_>>(), [1.0, 2.0, 3.0]);
        let [a, b, c] = [0, 1, 2].map(|n| row[n].1);
        let exact = [a, b, c].map(|point| point.exact.unwrap());
        let found = [a.bounds.determinant, exact[0], b.bounds.determinant, exact[1], c.bounds.second_order, exact[2]];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < DIGITS, "σ = {sigma}: {found} instead of {expected}");
        }
        // (7) in ζ, a closed form; what is left is the quadrature of the harmonics.
        let zeta = ((1.0 + sigma).sqrt() - sigma.sqrt()).powi(2);
        let closed = [(1.0 - zeta) / 4.0, (1.0 - zeta * zeta) / 8.0, (1.0 - zeta) * zeta * zeta / 4.0];
        for (point, closed) in [a, b, c].iter().zip(closed) {
            assert!((point.bounds.printed - closed).abs() < 1e-12, "σ = {sigma}: {point:?} instead of {closed}");
        }
        assert!((b.bounds.without_mean - 0.25 * (1.0 - zeta) * zeta).abs() < 1e-12);
    }
}

#[test]
fn cranks_on_both_sides_leave_every_second_order_and_shared_shafts_none() {
    let quarter = 0.5 * PI;
    let orders = |second| printed::row(&rods(second), 0.3).iter().map(|(j, _)| *j).collect::<Vec<_>>();
    assert_eq!(orders(SecondCrank::OwnShafts(quarter)), [2.0, 4.0, 6.0]);
    assert!(orders(SecondCrank::SharedShafts(quarter)).is_empty());
}

/// J = 1 + Σ μₖ cos kφ that turns with the drive, c = 1 + Σ rₖ cos kφ.
fn turning(mu: &[f64], r: &[f64]) -> PeriodicOscillator {
    let (m, c) = (series(mu, &[]), series(r, &[]));
    let terms = move |_: usize, phi: f64| {
        let ([m, m1, m2, ..], c) = (m.at(phi).0, c.at(phi).0[0]);
        Terms { m, b1: m1, c, c2: 0.5 * m2, ..Terms::default() }
    };
    oscillator(Box::new(terms), 1.0, true)
}

#[test]
fn borders_by_formula_beside_the_exact_ones() {
    let one = || series(&[], &[]);
    let stiff = |a: &[f64], b: &[f64]| parametric(one(), series(a, b));
    // The order is twice j; θ; η by (9), (13) and exact.
    type Case = (PeriodicOscillator, usize, f64, Option<[f64; 2]>, [f64; 2]);
    let cases: Vec<Case> = vec![
        (stiff(&[-0.35], &[]), 1, 0.0, Some([1.81659021, 2.16794834]), [1.82179720, 2.17088851]),
        (stiff(&[-0.35], &[]), 1, 0.05, Some([1.84531723, 2.13419875]), [1.85055680, 2.13710019]),
        (stiff(&[0.2], &[0.25]), 1, 0.03, Some([1.84367119, 2.14160607]), [1.84791297, 2.14411092]),
        (
            parametric(series(&[0.25], &[]), series(&[-0.2], &[])),
            1,
            0.04,
            Some([1.80205853, 2.22601666]),
            [1.83535678, 2.26493450],
        ),
        (turning(&[0.3], &[]), 1, 0.02, Some([1.87008154, 2.16342112]), [1.93318654, 2.25927369]),
        (turning(&[0.3], &[0.15]), 1, 0.02, Some([1.94487760, 2.07436145]), [1.99638487, 2.15145861]),
        (stiff(&[0.35, 0.1], &[]), 2, 0.008, Some([0.97875769, 0.99021583]), [0.98500931, 0.99409496]),
        (stiff(&[0.25, 0.06], &[0.2, 0.08]), 2, 0.005, Some([0.97337579, 1.00059461]), [0.97831008, 1.00422009]),
        (turning(&[0.2, 0.1], &[0.1]), 2, 0.01, Some([0.97793416, 1.02383951]), [0.98697459, 1.03435750]),
        (crank(0.15, false), 2, 0.05, Some([0.86555400, 1.11391933]), [0.88165765, 1.11448646]),
        (crank(0.15, false), 4, 0.04, Some([0.43224699, 0.52570164]), [0.45269833, 0.52818543]),
        (crank(0.15, false), 6, 0.03, None, [0.30536959, 0.34293032]),
        (crank(0.7, false), 4, 0.04, Some([0.39293103, 0.51731524]), [0.42931355, 0.52641266]),
        (crank(0.7, false), 6, 0.03, None, [0.29248050, 0.33664838]),
    ];
    // The table has eight digits after the point.
    let near = |found: [f64; 2], expected: [f64; 2]| (0..2).all(|k| (found[k] - expected[k]).abs() < 6e-9);
    for (i, (scene, twice, theta, approximate, exact)) in cases.iter().enumerate() {
        let system = System::new(scene).unwrap();
        let found = system.printed().borders(*twice, *theta);
        assert_eq!(found.is_some(), approximate.is_some(), "case {i}: {found:?}");
        if let Some((found, expected)) = found.zip(*approximate) {
            assert!(near(found, expected), "case {i}: {found:?} instead of {expected:?}");
        }
        let (tongue, _) = tongues(&system, twice / system.parts)[twice / system.parts - 1];
        let found = tongue.interval(&system, *theta).unwrap();
        assert!(near(found, *exact), "case {i}: {found:?} instead of {exact:?}");
    }
}

#[test]
fn half_integer_borders_are_the_roots_of_the_closed_form() {
    // (11)–(13) with μ₁ = 0.25, r = −0.2 and 0.1, θ = 0.03.
    let (mu, r, s, theta) = (0.25, -0.2, 0.1, 0.03_f64);
    let scene = parametric(series(&[mu], &[]), series(&[r], &[s]));
    let d0 = 1.0 - 0.25 * (r * r + s * s);
    let d1 = 0.5 * (1.0 - 0.25 * r * mu - 2.0 * theta * theta);
    let d2 = (1.0 - 0.25 * mu * mu) / 16.0;
    let root = |sign: f64| ((d1 + sign * (d1 * d1 - 4.0 * d0 * d2).sqrt()) / (2.0 * d2)).sqrt();
    let found = System::new(&scene).unwrap().printed().borders(1, theta).unwrap();
    // The harmonics come from a quadrature.
    for (found, expected) in found.iter().zip([root(-1.0), root(1.0)]) {
        assert!((found - expected).abs() < 1e-12, "{found} instead of {expected}");
    }
}

#[test]
fn the_sum_of_moduli_that_is_printed_is_told_beside_the_modulus_of_the_sum() {
    // r₁ = 0.4, r₂ = 0.08: 0.04 is printed, 0 is right to leading order; turned by 45°, 0.00795 and 0.01125.
    let half = 0.3 / 2_f64.sqrt();
    for (a, b, printed, three_term) in [(&[0.4, 0.08][..], &[][..], 0.04, 0.0), (&[half], &[half], 0.0079550, 0.01125)]
    {
        let scene = parametric(series(&[], &[]), series(a, b));
        let options = Options { quick: true, orders: Some(2), ..Options::default() };
        let report = study(["scene", "model"], &scene, &options, &|_| ()).unwrap();
        let bounds = report.orders[1].bounds;
        // The printed numbers have three or four digits.
        assert!(
            (bounds.printed - printed).abs() < 5e-6 && (bounds.three_term - three_term).abs() < 1e-12,
            "{bounds:?}"
        );
        let text = report.report().text(1000, true);
        assert!(text.contains("add moduli where the modulus of a complex sum belongs"), "{text}");
    }
}
