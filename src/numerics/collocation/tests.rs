//! Problems with exact solutions.

use super::*;

/// q̈ + ω² q = 0: q = cos ωt.
struct Oscillator {
    omega: f64,
}

impl System<2> for Oscillator {
    fn rhs(&self, _: Double, y: &[f64; 2]) -> [f64; 2] {
        [y[1], -self.omega * self.omega * y[0]]
    }
    fn jacobian(&self, _: Double, _: &[f64; 2]) -> [[f64; 2]; 2] {
        [[0.0, 1.0], [-self.omega * self.omega, 0.0]]
    }
}

/// The radial motion of a Kepler orbit with semi-major axis 1: r̈ = (1 − e²)/r³ − 1/r², r = 1 − e cos E with
/// t = E − e sin E.
struct Kepler {
    eccentricity: f64,
}

impl System<2> for Kepler {
    fn rhs(&self, _: Double, y: &[f64; 2]) -> [f64; 2] {
        let momentum = 1.0 - self.eccentricity * self.eccentricity;
        [y[1], momentum / y[0].powi(3) - 1.0 / (y[0] * y[0])]
    }
    fn jacobian(&self, _: Double, y: &[f64; 2]) -> [[f64; 2]; 2] {
        let momentum = 1.0 - self.eccentricity * self.eccentricity;
        [[0.0, 1.0], [-3.0 * momentum / y[0].powi(4) + 2.0 / y[0].powi(3), 0.0]]
    }
}

/// Prothero and Robinson: ẏ = λ (y − sin t) + cos t with y = sin t.
struct Stiff {
    lambda: f64,
}

impl System<1> for Stiff {
    fn rhs(&self, t: Double, y: &[f64; 1]) -> [f64; 1] {
        let (s, c) = (t.hi + t.lo).sin_cos();
        [self.lambda * (y[0] - s) + c]
    }
    fn jacobian(&self, _: Double, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[self.lambda]]
    }
}

/// ẏ = y², y = 1/(1 − t): no solution beyond t = 1.
struct Explosion;

impl System<1> for Explosion {
    fn rhs(&self, _: Double, y: &[f64; 1]) -> [f64; 1] {
        [y[0] * y[0]]
    }
    fn jacobian(&self, _: Double, y: &[f64; 1]) -> [[f64; 1]; 1] {
        [[2.0 * y[0]]]
    }
}

fn double(t: f64) -> Double {
    Double::from(t)
}

/// The error at the end of one step of length `h` that does not depend on the tolerance.
fn error_of_a_step(h: f64) -> f64 {
    let mut c = Collocation::new(double(0.0), [1.0, 0.0]);
    c.next = h;
    c.step(&Oscillator { omega: 1.0 }, double(h), 1.0).unwrap();
    assert_eq!(c.end(), double(h));
    (c.state()[0] - h.cos()).hypot(c.state()[1] + h.sin())
}

#[test]
fn the_end_of_a_step_is_of_order_16() {
    // Local error ~ h¹⁷; the measured slope rises towards 17 as h falls and rounding does not yet matter.
    let order = (error_of_a_step(4.0) / error_of_a_step(2.5)).ln() / (4.0f64 / 2.5).ln();
    assert!((16.2..17.2).contains(&order), "{order}");
}

#[test]
fn the_polynomial_is_of_order_8_and_its_error_is_estimated_from_above() {
    let mut errors = [0.0; 2];
    for (error, h) in errors.iter_mut().zip([2.0, 1.0]) {
        let mut c = Collocation::new(double(0.0), [1.0, 0.0]);
        c.next = h;
        c.step(&Oscillator { omega: 1.0 }, double(h), 1.0).unwrap();
        for n in 0..=200 {
            let t = h * f64::from(n) / 200.0;
            let y = c.at(double(t));
            *error = f64::max(*error, (y[0] - t.cos()).abs().max((y[1] + t.sin()).abs()));
        }
        let estimate = c.statistics.error_estimate;
        assert!(*error < estimate && estimate < 20.0 * *error, "error {error:e}, estimate {estimate:e}");
    }
    let order = (errors[0] / errors[1]).log2();
    assert!((8.7..9.3).contains(&order), "{order}");
}

#[test]
fn an_oscillator_keeps_energy_and_phase_over_ten_thousand_periods() {
    let omega = 7.0;
    let system = Oscillator { omega };
    let mut c = Collocation::new(double(0.0), [1.0, 0.0]);
    let periods = 10_000.0;
    // 10⁴ periods of 2π/7; the rounding of the end time costs 1e-12 of phase, so the exact phase is computed from it.
    let end = periods * std::f64::consts::TAU / omega;
    c.advance(&system, double(end), 1e-10).unwrap();
    let phase = omega * end;
    let [q, v] = c.state();
    let energy = q * q + (v / omega).powi(2);
    assert!((energy - 1.0).abs() < 1e-11, "energy {:e}", energy - 1.0);
    assert!((q - phase.cos()).abs() < 3e-11 && (v / omega + phase.sin()).abs() < 3e-11, "{q} {v}");
}

#[test]
fn a_kepler_orbit_meets_the_tolerance_everywhere() {
    let e: f64 = 0.6;
    let system = Kepler { eccentricity: e };
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let mut c = Collocation::new(double(0.0), [1.0 - e, 0.0]);
        let mut worst: f64 = 0.0;
        for n in 1..2000 {
            let anomaly = f64::from(n) * 0.05;
            let t = double(anomaly - e * anomaly.sin());
            while (t - c.end()).hi > 0.0 {
                c.step(&system, double(1000.0), tolerance).unwrap();
            }
            let r = c.at(t)[0];
            worst = worst.max((r - (1.0 - e * anomaly.cos())).abs());
        }
        // The error is relative to max r = 1.6 and has grown over 16 turns.
        assert!(worst < 10.0 * tolerance, "tolerance {tolerance:e}: {worst:e}");
        assert!(c.statistics.error_estimate <= tolerance);
    }
}

#[test]
fn stiffness_does_not_shorten_the_steps() {
    for lambda in [-1.0, -1e3, -1e6, -1e9] {
        let mut c = Collocation::new(double(0.0), [0.0]);
        c.advance(&Stiff { lambda }, double(10.0), 1e-10).unwrap();
        assert!((c.state()[0] - 10f64.sin()).abs() < 1e-10, "λ = {lambda:e}: {:e}", c.state()[0] - 10f64.sin());
        assert!(c.statistics.steps < 30, "λ = {lambda:e}: {:?}", c.statistics);
    }
}

#[test]
fn a_step_may_end_at_any_given_time() {
    // Communication steps from 1e-6 to 1 of the unit of time lead to the same state.
    let system = Kepler { eccentricity: 0.3 };
    let reach = |n: i32, span: f64| {
        let mut c = Collocation::new(double(0.0), [0.7, 0.0]);
        for k in 1..=n {
            c.advance(&system, double(span * f64::from(k) / f64::from(n)), 1e-10).unwrap();
        }
        c.state()
    };
    let whole = reach(1, 1.0);
    for n in [3, 1000, 100_000] {
        let parts = reach(n, 1.0);
        for c in 0..2 {
            assert!((whole[c] - parts[c]).abs() < 1e-13, "{n} steps: {:e}", whole[c] - parts[c]);
        }
    }
}

#[test]
fn a_solution_that_ends_is_a_failure_and_not_a_nan() {
    let mut c = Collocation::new(double(0.0), [1.0]);
    let failure = c.advance(&Explosion, double(2.0), 1e-10).unwrap_err();
    let (Failure::Stalled { time } | Failure::Unbounded { time }) = failure;
    assert!((time - 1.0).abs() < 1e-6, "{failure:?}");
    assert!(c.state()[0].is_finite());
}

#[test]
fn exponential_growth_ends_in_a_failure() {
    let mut c = Collocation::new(double(0.0), [1.0, 1.0]);
    // ω² = −1: growth like eᵗ reaches 1e100 at t = 230.
    struct Growth;
    impl System<2> for Growth {
        fn rhs(&self, _: Double, y: &[f64; 2]) -> [f64; 2] {
            [y[1], y[0]]
        }
        fn jacobian(&self, _: Double, _: &[f64; 2]) -> [[f64; 2]; 2] {
            [[0.0, 1.0], [1.0, 0.0]]
        }
    }
    let failure = c.advance(&Growth, double(1e4), 1e-10).unwrap_err();
    assert!(matches!(failure, Failure::Unbounded { time } if (time - 230.0).abs() < 10.0), "{failure:?}");
}

#[test]
fn a_restored_integrator_goes_on_bit_by_bit() {
    let system = Kepler { eccentricity: 0.3 };
    let mut c = Collocation::new(double(0.0), [0.7, 0.0]);
    c.step(&system, double(100.0), 1e-10).unwrap();
    let bytes = postcard::to_allocvec(&c).unwrap();
    let mut copy: Collocation<2> = postcard::from_bytes(&bytes).unwrap();
    assert_eq!(c, copy);
    for _ in 0..50 {
        c.step(&system, double(100.0), 1e-10).unwrap();
        copy.step(&system, double(100.0), 1e-10).unwrap();
    }
    assert_eq!(c, copy);
}

/// q̈ + q + κ q³ = g(t), with g chosen for q = 1 − cos νt: at rest at the start.
struct FromRest {
    cubic: f64,
    rate: f64,
}

impl FromRest {
    fn exact(&self, t: f64) -> [f64; 2] {
        let half = (0.5 * self.rate * t).sin();
        [2.0 * half * half, self.rate * (self.rate * t).sin()]
    }
}

impl System<2> for FromRest {
    fn rhs(&self, t: Double, y: &[f64; 2]) -> [f64; 2] {
        let [q, _] = self.exact(t.hi + t.lo);
        let force = self.rate * self.rate * (1.0 - q) + q + self.cubic * q.powi(3);
        [y[1], force - y[0] - self.cubic * y[0].powi(3)]
    }
    fn jacobian(&self, _: Double, y: &[f64; 2]) -> [[f64; 2]; 2] {
        [[0.0, 1.0], [-1.0 - 3.0 * self.cubic * y[0] * y[0], 0.0]]
    }
}

#[test]
fn a_start_at_rest_keeps_the_tolerance() {
    for (cubic, rate) in [(50.0, 1.0), (3.0, 7.0), (400.0, 0.5), (-0.3, 3.0)] {
        for tolerance in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
            let system = FromRest { cubic, rate };
            for start in [0.0, 1e-12] {
                let mut c = Collocation::new(Double::default(), [start, 0.0]);
                c.advance(&system, Double::from(2.0 / rate), tolerance).unwrap();
                let (found, exact) = (c.state(), system.exact(2.0 / rate));
                // The error of the start grows a few times at most.
                let error = ((found[0] - exact[0]) / exact[0]).abs() - 20.0 * start;
                let estimate = 16.0 * c.statistics.state_error;
                assert!(error <= estimate.min(16.0 * tolerance), "κ {cubic}, {tolerance:e}: {error:e} {estimate:e}");
            }
        }
    }
}
