//! The boundaries of the unstable ranges.

use super::*;

/// The growth per turn at η = Ω/ω₀, ω₀ = 1.
fn growth(law: &Law, eta: f64) -> f64 {
    started(scene(law.clone(), eta)).growth
}

/// The largest growth for η in the range: the best of some samples, refined by golden sections.
fn largest_growth(law: &Law, [low, high]: [f64; 2]) -> f64 {
    const SAMPLES: i32 = 40;
    let step = (high - low) / f64::from(SAMPLES);
    let samples = (0..=SAMPLES).map(|i| low + step * f64::from(i));
    let best = samples.max_by(|x, y| growth(law, *x).total_cmp(&growth(law, *y))).unwrap();
    let (mut a, mut b) = (best - step, best + step);
    let section = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..40 {
        let (x, y) = (b - section * (b - a), a + section * (b - a));
        if growth(law, x) > growth(law, y) { b = y } else { a = x }
    }
    growth(law, 0.5 * (a + b))
}

/// The tongue closes at the damping ratio `theta`, which is known to six decimals.
fn assert_closes_at(what: &str, theta: f64, range: [f64; 2], law: impl Fn(f64) -> Law) {
    let (open, closed) = (largest_growth(&law(theta - 1e-5), range), largest_growth(&law(theta + 1e-5), range));
    assert!(open > 0.0 && closed < 0.0, "{what}: growth {open:e} below and {closed:e} above θ = {theta}");
}

#[test]
fn the_tongues_of_the_crank_close_at_the_known_damping() {
    for (sigma, thetas) in [
        (0.02, [0.059612, 0.049376, 0.042127]),
        (0.1, [0.111832, 0.080090, 0.062170]),
        (1.0, [0.203469, 0.114484, 0.079468]),
    ] {
        for (j, theta) in (1..).zip(thetas) {
            let law = |theta| Law::Crank(crank(sigma, theta, SecondCrank::None));
            let middle = 1.0 / f64::from(j);
            assert_closes_at(&format!("σ = {sigma}, j = {j}"), theta, [0.9 * middle, 1.15 * middle], law);
        }
    }
    // Two cranks a quarter of a turn apart, each with its own shafts: only every second tongue remains.
    for (sigma, theta) in [(0.1, 0.061601), (0.5, 0.048958)] {
        let law = |theta| Law::Crank(crank(sigma, theta, SecondCrank::OwnShafts(FRAC_PI_2)));
        assert_closes_at(&format!("double, σ = {sigma}"), theta, [0.45, 0.55], law);
        assert!(largest_growth(&law(0.0), [0.9, 1.1]) < 1e-6);
    }
}

#[test]
fn cranks_on_the_same_shafts_do_not_excite() {
    let law = Law::Crank(crank(0.1, 0.01, SecondCrank::SharedShafts(FRAC_PI_2)));
    for eta in [0.3, 0.5, 1.0, 2.0] {
        // Damping alone: −θ ω₀ per second, over 2π/η.
        let expected = -0.01 * TAU / eta;
        assert!((growth(&law, eta) / expected - 1.0).abs() < 1e-9, "{eta}: {}", growth(&law, eta));
    }
}

#[test]
fn the_tongues_of_a_cosine() {
    // Boundaries for ε = 0.3 without damping and with θ = 0.05, and the damping at which the tongues close.
    for (theta, low, high) in [(0.0, 1.84756, 2.14700), (0.0, 0.981274, 1.003710), (0.05, 1.88314, 2.10639)] {
        let law = mathieu(0.3, theta);
        let width = high - low;
        for (outside, inside) in [(low - 1e-3 * width, low + 1e-3 * width), (high + 1e-3 * width, high - 1e-3 * width)]
        {
            assert!(growth(&law, outside) <= 0.0 && growth(&law, inside) > 0.0, "θ = {theta}: {outside} {inside}");
        }
    }
    for (epsilon, j, theta) in [(0.3, 0.5, 0.075025), (0.3, 1.0, 0.011276), (0.8, 1.5, 0.042850), (0.8, 2.0, 0.025390)]
    {
        let law = |theta| mathieu(epsilon, theta);
        assert_closes_at(&format!("ε = {epsilon}, j = {j}"), theta, [0.85 / j, 1.1 / j], law);
    }
}

#[test]
fn growth_is_counted_per_turn_whatever_the_period_and_the_sense() {
    // The same equation with the harmonic k = 3 at a third of the speed grows three times as much per turn.
    let once = growth(&mathieu(0.3, 0.01), 2.0);
    let Law::Series(mut thrice) = mathieu(0.3, 0.01) else { unreachable!("a series") };
    thrice.c = Fourier::new(vec![1.0, 0.0, 0.0, -0.3], Vec::new());
    let law = Law::Series(thrice);
    assert!((growth(&law, 2.0 / 3.0) - 3.0 * once).abs() < 1e-10);
    assert!((growth(&law, -2.0 / 3.0) - 3.0 * once).abs() < 1e-10);
    // However many vibrations a period has, and with too many cells for a table, the equation does not change over a vibration.
    let heavy = mathieu(0.0, 3.0);
    let slow = -3.0 + 8.0_f64.sqrt();
    for (w, law, exact, tabulated) in [
        (1e-2, mathieu(0.3, 0.01), -0.01, true),
        (1e-5, mathieu(0.3, 0.01), -0.01, true),
        (1e-9, mathieu(0.3, 0.01), -0.01, true),
        (1e-2, heavy.clone(), slow, true),
        (1e-9, heavy, slow, false),
    ] {
        let drive = started(scene(law, w));
        assert_eq!(drive.trajectory.is_some(), tabulated, "{w}");
        assert!((drive.growth / (exact * TAU / w) - 1.0).abs() < 1e-9, "{w}: {}", drive.growth);
    }
}

#[test]
fn the_damping_of_a_varying_mass() {
    // Multipliers that are not real decay by half of the mean of b/m; the mean of 1/(1 + e cos φ) is 1/√(1 − e²).
    for e in [0.3, 0.9, 0.999] {
        let mut law = mathieu(0.0, 0.25);
        if let Law::Series(law) = &mut law {
            (law.m, law.c) = (Fourier::new(vec![2.0, 2.0 * e], Vec::new()), constant(10.0));
        }
        let exact = -0.125 * TAU / 100.0 / f64::sqrt(1.0 - e * e);
        assert!((growth(&law, 100.0) / exact - 1.0).abs() < 1e-12, "{e}");
    }
}
