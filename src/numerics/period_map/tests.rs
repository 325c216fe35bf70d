//! Equations with known solutions.

use super::*;
use crate::numerics::collocation::{Collocation, System};

/// q̈ + d q̇ + (k₀ + k₁ cos ωτ) q = g₀ + g₁ cos ωτ.
#[derive(Clone, Copy)]
struct Hill {
    frequency: f64,
    damping: f64,
    stiffness: [f64; 2],
    forcing: [f64; 2],
}

const MATHIEU: Hill = Hill { frequency: 3.0, damping: 0.2, stiffness: [40.0, 15.0], forcing: [1.0, 2.0] };

impl Periodic for Hill {
    fn period(&self) -> Double {
        Double { hi: std::f64::consts::TAU, lo: 2.449_293_598_294_706_4e-16 }.divide(Double::from(self.frequency))
    }
    fn joints(&self) -> Vec<Double> {
        vec![self.period() * Double::from(0.3), self.period()]
    }
    fn at(&self, tau: Double, _: usize) -> Coefficients {
        let cos = (self.frequency * tau.hi).cos();
        Coefficients {
            damping: self.damping,
            stiffness: self.stiffness[0] + self.stiffness[1] * cos,
            forcing: self.forcing[0] + self.forcing[1] * cos,
        }
    }
    fn longest_cell(&self, _: Double, _: usize) -> f64 {
        2.0 / self.frequency
    }
}

impl System<2> for Hill {
    fn rhs(&self, t: Double, y: &[f64; 2]) -> [f64; 2] {
        let c = self.at(t, 0);
        [y[1], c.forcing - c.damping * y[1] - c.stiffness * y[0]]
    }
    fn jacobian(&self, t: Double, _: &[f64; 2]) -> [[f64; 2]; 2] {
        let c = self.at(t, 0);
        [[0.0, 1.0], [-c.stiffness, -c.damping]]
    }
}

/// (q, q̇) after the communication steps.
fn run(map: &PeriodMap, y: [f64; 2], ends: impl Iterator<Item = f64>) -> Vec<[f64; 2]> {
    let mut trajectory = Trajectory::new(map, 0.0, y);
    ends.map(|t| {
        trajectory.reach(map, t).unwrap();
        trajectory.at(map, t)
    })
    .collect()
}

#[test]
fn a_count_of_periods_that_cannot_grow_ends() {
    // As in a damaged state: the period starts before t, and the next one at t.
    let map = PeriodMap::new(&MATHIEU, 1e-10).unwrap();
    let count = u64::MAX;
    let origin = (-(count as f64) * map.period.hi).next_down();
    let mut trajectory = Trajectory { periods: count, ..Trajectory::new(&map, origin, [1.0, 0.0]) };
    trajectory.begin_period(&map, 0);
    trajectory.enter(&map, 0);
    assert!(trajectory.since_start(&map, 0.0) > 2.0);
    assert!(trajectory.reach(&map, 0.0).is_err());
}

#[test]
fn constant_coefficients_give_the_closed_form() {
    // Over ten periods: vibration, overdamped decay and growth, each about the equilibrium g/k.
    for (damping, stiffness) in [(0.2, 40.0), (30.0, 40.0), (0.1, -4.0), (0.0, 900.0)] {
        let hill = Hill { damping, stiffness: [stiffness, 0.0], forcing: [3.0, 0.0], ..MATHIEU };
        let map = PeriodMap::new(&hill, 1e-13).unwrap();
        let middle = 3.0 / stiffness;
        let t = 10.0 * map.period.hi;
        let (half, discriminant) = (0.5 * damping, 0.25 * damping * damping - stiffness);
        let rate = discriminant.abs().sqrt();
        let (c, s) = if discriminant < 0.0 {
            ((rate * t).cos(), (rate * t).sin())
        } else {
            ((rate * t).cosh(), (rate * t).sinh())
        };
        let q = middle + (-half * t).exp() * (1.0 - middle) * (c + half / rate * s);
        for steps in [1, 7, 1000] {
            let got = run(&map, [1.0, 0.0], (1..=steps).map(|n| t * f64::from(n) / f64::from(steps)));
            let error = (got.last().unwrap()[0] - q) / q.abs().max(middle.abs());
            assert!(error.abs() < 2e-13, "d = {damping}, k = {stiffness}, {steps} steps: {error:e}");
        }
    }
}

#[test]
fn periodic_coefficients_meet_the_integrator_at_every_step() {
    let map = PeriodMap::new(&MATHIEU, 1e-13).unwrap();
    let mut integrator = Collocation::new(Double::default(), [1.0, -2.0]);
    let times: Vec<f64> = (1..=700).map(|n| 0.01 * f64::from(n)).collect();
    for (t, y) in times.iter().zip(run(&map, [1.0, -2.0], times.iter().copied())) {
        integrator.advance(&MATHIEU, Double::from(*t), 1e-14).unwrap();
        let expected = integrator.state();
        let error = [(y[0] - expected[0]).abs(), (y[1] - expected[1]).abs()];
        assert!(error[0] < 2e-13 && error[1] < 2e-12, "{t}: {error:?}");
    }
}

#[test]
fn the_tolerance_buys_cells() {
    let exact = PeriodMap::new(&MATHIEU, 1e-14).unwrap();
    let mut last = 0;
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
        let map = PeriodMap::new(&MATHIEU, tolerance).unwrap();
        let times = || (1..=300).map(|n| 0.02 * f64::from(n));
        let error = run(&map, [1.0, 0.0], times())
            .iter()
            .zip(run(&exact, [1.0, 0.0], times()))
            .map(|(a, b)| (a[0] - b[0]).abs())
            .fold(0.0, f64::max);
        assert!(error <= map.error() && map.error() <= tolerance, "{tolerance:e}: {error:e}, {:e}", map.error());
        assert!(map.cells() >= last && map.evaluations() >= STAGES * map.cells());
        last = map.cells();
    }
    assert!(last < 60, "{last}");
}

#[test]
fn a_million_periods_in_one_step_or_in_many() {
    let hill = Hill { damping: 1e-7, ..MATHIEU };
    let map = PeriodMap::new(&hill, 1e-13).unwrap();
    let end = 1e6 * map.period.hi + 0.7;
    let at_once = run(&map, [1.0, 0.0], [end].into_iter())[0];
    let stepwise = *run(&map, [1.0, 0.0], (1..=2000).map(|n| end * f64::from(n) / 2000.0)).last().unwrap();
    // A million products, each with a rounding.
    assert!((at_once[0] - stepwise[0]).abs() < 1e-9 * (1.0 + at_once[0].abs()), "{at_once:?} {stepwise:?}");
    let mut trajectory = Trajectory::new(&map, 0.0, [1.0, 0.0]);
    trajectory.reach(&map, end).unwrap();
    assert!(trajectory.steps < 200, "{}", trajectory.steps);
}

#[test]
fn growth_ends_where_it_is_unbounded_whatever_the_step() {
    let hill = Hill { damping: 0.0, stiffness: [2.25, 1.0], ..MATHIEU };
    let map = PeriodMap::new(&hill, 1e-10).unwrap();
    let mut stepwise = Trajectory::new(&map, 0.0, [1.0, 0.0]);
    let time = (1..).find_map(|n| stepwise.reach(&map, 0.5 * f64::from(n)).err()).unwrap().time;
    for step in [100.0, 1e4, 1e9] {
        let mut trajectory = Trajectory::new(&map, 0.0, [1.0, 0.0]);
        let fault = (1..).find_map(|n| trajectory.reach(&map, step * f64::from(n)).err()).unwrap();
        assert!((fault.time - time).abs() < 2.0 * map.period.hi, "{step}: {} {time}", fault.time);
    }
}

/// q = s + exp(−d t/2) cos(Θ − Θ₀)/√(Θ′/ω), with the forcing chosen for it: Θ′ = ω (1 + ε cos t), s = 1 + cos 2t.
#[derive(Clone, Copy)]
struct Measured {
    rate: f64,
    modulation: f64,
    damping: f64,
}

impl Measured {
    /// Θ′/ω and its logarithmic derivatives p′, p″.
    fn phase(&self, t: f64) -> [f64; 3] {
        let (s, c) = t.sin_cos();
        let e = self.modulation;
        let velocity = 1.0 + e * c;
        [velocity, -e * s / velocity, -e * (c + e) / (velocity * velocity)]
    }

    /// s, s′, s″.
    fn slow(t: f64) -> [f64; 3] {
        let (s, c) = (2.0 * t).sin_cos();
        [1.0 + c, -2.0 * s, -4.0 * c]
    }

    /// (q, q̇).
    fn exact(&self, t: f64) -> [f64; 2] {
        let [velocity, slope, _] = self.phase(t);
        let [s, ds, _] = Self::slow(t);
        let amplitude = (-0.5 * self.damping * t).exp() / velocity.sqrt();
        let (sine, cosine) = (self.rate * (t + self.modulation * t.sin())).sin_cos();
        let growth = -0.5 * (self.damping + slope);
        [s + amplitude * cosine, ds + amplitude * (growth * cosine - self.rate * velocity * sine)]
    }
}

impl Periodic for Measured {
    fn period(&self) -> Double {
        Double { hi: std::f64::consts::TAU, lo: 2.449_293_598_294_706_4e-16 }
    }
    fn joints(&self) -> Vec<Double> {
        vec![Double::from(1.0), self.period()]
    }
    fn at(&self, tau: Double, _: usize) -> Coefficients {
        let ([velocity, p, pp], [s, ds, dds]) = (self.phase(tau.hi), Self::slow(tau.hi));
        let free = (self.rate * velocity).powi(2) + 0.5 * pp - 0.25 * p * p;
        let stiffness = free + 0.25 * self.damping * self.damping;
        Coefficients { damping: self.damping, stiffness, forcing: dds + self.damping * ds + stiffness * s }
    }
    fn longest_cell(&self, _: Double, _: usize) -> f64 {
        2.0
    }
}

/// An oscillator of constant coefficients whose forcing has other last digits.
struct Rounded {
    hill: Hill,
    seed: u64,
}

impl Periodic for Rounded {
    fn period(&self) -> Double {
        self.hill.period()
    }
    fn joints(&self) -> Vec<Double> {
        self.hill.joints()
    }
    fn at(&self, tau: Double, interval: usize) -> Coefficients {
        let mut coefficients = self.hill.at(tau, interval);
        let hash = (tau.hi.to_bits() ^ self.seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 62;
        coefficients.forcing *= 1.0 + f64::EPSILON * (hash as f64 - 1.0);
        coefficients
    }
    fn longest_cell(&self, tau: Double, interval: usize) -> f64 {
        self.hill.longest_cell(tau, interval)
    }
    fn by_phase(&self) -> bool {
        false
    }
}

#[test]
fn the_last_digit_of_the_forcing_does_not_choose_the_cells() {
    for rate in [2.0f64, 5.0, 10.0, 27.0, 81.0] {
        let hill = Hill { stiffness: [(3.0 * rate).powi(2), 0.0], forcing: [0.0, 2.0], ..MATHIEU };
        let cells = |seed| PeriodMap::new(&Rounded { hill, seed }, 1e-14).unwrap().cells();
        let one = cells(0);
        assert!((1..40).all(|seed| cells(seed) == one), "{rate}: {one}, {:?}", (1..40).map(cells).collect::<Vec<_>>());
    }
}

#[test]
fn a_faster_vibration_costs_no_more_cells() {
    for (rate, modulation, damping) in [
        (3e3, 0.1, 0.1),
        (1e4, 0.5, 0.01),
        (1e4, 0.8, 1.0),
        (1e6, 0.5, 0.0),
        (1e9, 0.5, 0.0),
        (1e9, 0.0, 1e3),
        (1e12, 0.5, 0.0),
    ] {
        let equation = Measured { rate, modulation, damping };
        let map = PeriodMap::new(&equation, 1e-12).unwrap();
        let fast = map.cells.iter().filter(|cell| matches!(cell.motions, Motions::Vibration(_))).count();
        assert!(
            fast == map.cells() && fast < 60,
            "{rate:e}, {modulation}: {fast} of {} cells go by the phase",
            map.cells()
        );
        let times: Vec<f64> = (1..=200).map(|n| 0.1 * f64::from(n)).collect();
        let estimate = map.whole().error_after(4.0, 2.0, 1.0);
        for (t, y) in times.iter().zip(run(&map, equation.exact(0.0), times.iter().copied())) {
            let exact = equation.exact(*t);
            let error = (y[0] - exact[0]).abs().max((y[1] - exact[1]).abs() / rate);
            // The exact phase has roundings as well.
            let own = 2.0 * f64::EPSILON * rate * t;
            assert!(error < estimate + own, "{rate:e}, {modulation}, t = {t}: {error:e} {estimate:e}");
        }
        let settled = run(&map, Measured::slow(0.0)[..2].try_into().unwrap(), times.iter().copied());
        // Without vibrations the phase does not count.
        for (t, y) in times.iter().zip(settled) {
            let error = (y[0] - Measured::slow(*t)[0]).abs();
            assert!(error < 1e-12 + 4.0 / (rate * rate), "{rate:e}, {modulation}, t = {t}: {error:e}");
        }
        // The first vibrations are as exact as if there were no others.
        let first: Vec<f64> = (1..=50).map(|n| 0.7 * f64::from(n) / rate).collect();
        for (t, y) in first.iter().zip(run(&map, equation.exact(0.0), first.iter().copied())) {
            let exact = equation.exact(*t);
            let error = (y[0] - exact[0]).abs().max((y[1] - exact[1]).abs() / rate);
            assert!(error < 4e-13, "{rate:e}, {modulation}, t = {t}: {error:e}");
        }
        // The phase over three periods and its roundings.
        assert!(estimate < 1e-10 + 20.0 * rate * f64::EPSILON * 8.0, "{rate:e}, {modulation}: {estimate:e}");
    }
}

#[test]
fn vibrations_that_are_now_fast_and_now_slow() {
    // A stiffness that nearly vanishes and one that changes its sign: cells of both kinds, one after the other.
    for (least, end) in [(100.0, 4.0), (-400.0, 2.0)] {
        let hill = Hill { damping: 0.3, stiffness: [least + 2e6, 2e6], forcing: [1e6, 0.0], ..MATHIEU };
        let map = PeriodMap::new(&hill, 1e-12).unwrap();
        let fast = map.cells.iter().filter(|cell| matches!(cell.motions, Motions::Vibration(_))).count();
        assert!(0 < fast && fast < map.cells(), "{fast} of {}", map.cells());
        let mut integrator = Collocation::new(Double::default(), [0.5, -200.0]);
        let times: Vec<f64> = (1..=20).map(|n| end * f64::from(n) / 20.0).collect();
        let mut largest: f64 = 0.0;
        for (t, y) in times.iter().zip(run(&map, [0.5, -200.0], times.iter().copied())) {
            integrator.advance(&hill, Double::from(*t), 1e-14).unwrap();
            let expected = integrator.state();
            largest = largest.max(expected[0].abs());
            let error = (y[0] - expected[0]).abs() / largest;
            assert!(error < 2e-10, "{least}, {t}: {error:?}");
        }
    }
}

/// q̈ + q = τ'⁹ + 1e-7 cos 14τ', τ' = τ − 1: a small wave on a polynomial as long as a cell.
struct SmallWave;

impl Periodic for SmallWave {
    fn period(&self) -> Double {
        Double::from(2.0)
    }
    fn joints(&self) -> Vec<Double> {
        vec![self.period()]
    }
    fn at(&self, tau: Double, _: usize) -> Coefficients {
        let x = tau.hi - 1.0;
        Coefficients { damping: 0.0, stiffness: 1.0, forcing: x.powi(9) + 1e-7 * (14.0 * x).cos() }
    }
    fn longest_cell(&self, _: Double, _: usize) -> f64 {
        2.0
    }
}

#[test]
fn a_small_wave_beside_a_polynomial_is_not_overlooked() {
    let coarse = PeriodMap::new(&SmallWave, 1e-4).unwrap();
    let fine = PeriodMap::new(&SmallWave, 1e-13).unwrap();
    assert_eq!(coarse.cells(), 1);
    let times: Vec<f64> = (1..100).map(|n| 0.02 * f64::from(n)).collect();
    let [coarse_run, fine_run] = [&coarse, &fine].map(|map| run(map, [0.0; 2], times.iter().copied()));
    let largest = fine_run.iter().fold(0.0f64, |largest, y| largest.max(y[1].abs()));
    let error = coarse_run.iter().zip(&fine_run).fold(0.0f64, |worst, (a, b)| worst.max((a[1] - b[1]).abs())) / largest;
    assert!(error > 1e-9 && error < 4.0 * coarse.error(), "{error:e} {:e}", coarse.error());
}

/// q̈ + k q = 0 with the phase velocity Θ̇ = 1000 (1 + 0.1 x⁹ + 1e-8 cos 14x), x = τ − 1.
struct SmallWaveOfThePhase;

impl SmallWaveOfThePhase {
    fn velocity(x: f64) -> [f64; 3] {
        let (sine, cosine) = (14.0 * x).sin_cos();
        [1.0 + 0.1 * x.powi(9) + 1e-8 * cosine, 0.9 * x.powi(8) - 14e-8 * sine, 7.2 * x.powi(7) - 196e-8 * cosine]
            .map(|v| 1000.0 * v)
    }

    /// The solution from (q, q̇) = A (1, A′/A) at τ = 0.
    fn exact(tau: f64) -> f64 {
        let phase = |x: f64| 1000.0 * (x + 0.01 * x.powi(10) + 1e-8 / 14.0 * (14.0 * x).sin());
        let [v, ..] = Self::velocity(tau - 1.0);
        let [v0, ..] = Self::velocity(-1.0);
        (phase(tau - 1.0) - phase(-1.0)).cos() * (v0 / v).sqrt()
    }
}

impl Periodic for SmallWaveOfThePhase {
    fn period(&self) -> Double {
        Double::from(2.0)
    }
    fn joints(&self) -> Vec<Double> {
        vec![self.period()]
    }
    fn at(&self, tau: Double, _: usize) -> Coefficients {
        let [v, v1, v2] = Self::velocity(tau.hi - 1.0);
        let stiffness = v * v + 0.5 * v2 / v - 0.75 * (v1 / v).powi(2);
        Coefficients { damping: 0.0, stiffness, forcing: 0.0 }
    }
    fn longest_cell(&self, _: Double, _: usize) -> f64 {
        2.0
    }
}

#[test]
fn a_small_wave_of_the_phase_is_not_overlooked() {
    let map = PeriodMap::new(&SmallWaveOfThePhase, 1e-12).unwrap();
    assert!(map.cells.iter().all(|cell| matches!(cell.motions, Motions::Vibration(_))));
    let [v, v1, _] = SmallWaveOfThePhase::velocity(-1.0);
    let times: Vec<f64> = (1..200).map(|n| 0.01 * f64::from(n)).collect();
    let motion = run(&map, [1.0, -0.5 * v1 / v], times.iter().copied());
    let error =
        times.iter().zip(&motion).map(|(t, y)| (y[0] - SmallWaveOfThePhase::exact(*t)).abs()).fold(0.0, f64::max);
    // The exact phase has roundings as well.
    let (estimate, own) = (map.whole().error_after(1.0, 1.0, 1.0), 2.0 * f64::EPSILON * 2000.0);
    assert!(error < 4e-12 && error < 4.0 * estimate + own, "{error:e} {estimate:e}, {} cells", map.cells());
}

#[test]
fn what_needs_too_many_cells_has_no_table() {
    assert!(PeriodMap::new(&Hill { stiffness: [0.0, 1e12], ..MATHIEU }, 1e-10).is_none());
    assert!(PeriodMap::new(&Hill { stiffness: [f64::NAN, 0.0], ..MATHIEU }, 1e-10).is_none());
    assert!(PeriodMap::new(&Hill { forcing: [f64::INFINITY, 0.0], ..MATHIEU }, 1e-10).is_none());
}

#[test]
fn the_growth_over_a_period_of_constant_coefficients() {
    // The roots of λ² + d λ + k: the larger real part times T.
    for (damping, stiffness) in [(0.2, 40.0), (30.0, 40.0), (0.1, -4.0), (0.0, 900.0), (-0.3, 5.0), (0.0, -1e6)] {
        let hill = Hill { damping, stiffness: [stiffness, 0.0], forcing: [0.0, 0.0], ..MATHIEU };
        let whole = Period::of(&hill, 1e-13).unwrap();
        let period = hill.period().hi;
        let discriminant: f64 = 0.25 * damping * damping - stiffness;
        let exact = period * (-0.5 * damping + discriminant.max(0.0).sqrt());
        let got = whole.monodromy.growth();
        // The last case overflows as a number: 2094 e-folds.
        assert!((got - exact).abs() < 1e-12 * (1.0 + exact.abs()), "d {damping}, k {stiffness}: {got} {exact}");
    }
}

#[test]
fn the_growth_within_and_beside_a_tongue() {
    // q̈ + ω² (1 − ε cos Ωt) q = 0: unstable for Ω/ω in [1.84756, 2.14700] at ε = 0.3.
    let growth = |eta: f64| {
        let hill = Hill { frequency: eta, damping: 0.0, stiffness: [1.0, -0.3], forcing: [0.0, 0.0] };
        Period::of(&hill, 1e-12).unwrap().monodromy.growth()
    };
    for stable in [1.84750, 2.14706, 1.5] {
        assert_eq!(growth(stable), 0.0);
    }
    for unstable in [1.84760, 2.14695] {
        assert!(growth(unstable) > 1e-3, "{}", growth(unstable));
    }
    // In the middle about π ε/4 ω a period of the parameters, 2π/Ω.
    assert!((growth(2.0) - std::f64::consts::PI * 0.3 / 4.0).abs() < 0.01, "{}", growth(2.0));
}

#[test]
fn a_period_without_tables_is_the_same() {
    let map = PeriodMap::new(&MATHIEU, 1e-10).unwrap();
    assert_eq!(Period::of(&MATHIEU, 1e-10).unwrap(), *map.whole());
    let point = fixed_point(&map.period_map().matrix, [0.0; 2], map.period_map().shift).unwrap();
    let image = map.period_map().at(point);
    assert!((image[0] - point[0]).abs() < 1e-15 && (image[1] - point[1]).abs() < 1e-15);
    // More cells than a table has, and too many.
    assert!(Period::of(&Hill { stiffness: [0.0, 1e9], ..MATHIEU }, 1e-10).is_some());
    assert!(PeriodMap::new(&Hill { stiffness: [0.0, 1e9], ..MATHIEU }, 1e-10).is_none());
    assert!(Period::of(&Hill { stiffness: [0.0, 1e14], ..MATHIEU }, 1e-10).is_none());
}
