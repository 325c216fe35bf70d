//! The oscillator under a polynomial forcing: exponential quadrature over one step of any stiffness.
//!
//! q̈ + 2δ q̇ + ω₀² q = p(t) is solved exactly (to rounding) for a polynomial p. Gauss quadrature integrates a slow mode against
//! its kernel; a fast mode is q = (polynomial solution) + (free motion). Thus the step is limited by the forcing alone, never by
//! the stiffness.
//!
//! Source: M. Hochbruck, A. Ostermann, "Exponential integrators", Acta Numerica 19 (2010) 209–286, section 2.

use super::chebyshev::Chebyshev;
use super::double_double::Double;
use super::gauss::Gauss;
use super::oscillator::Oscillator;
use serde::{Deserialize, Serialize};

/// Up to this |λ|h 16 Gauss nodes integrate the kernel times a polynomial of degree 16 to rounding: half the step
/// spans 6 rad, whose Chebyshev coefficients J₃₂₋ⱼ(6) meet coefficients of order j of the forcing that decay.
const SLOW: f64 = 12.0;

/// From this |λ|h on, back-substitution amplifies the rounding errors of a forcing of degree 16 by less than 120:
/// Tₙ⁽ᵏ⁾(1)/(|λ|h/2)ᵏ ≤ 117 for n = 16, reached at k = 4.
const FAST: f64 = 48.0;

/// How the two modes are treated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
enum Treatment {
    /// Both by quadrature.
    #[default]
    BothSlow,
    /// The fast one (real) by back-substitution, the slow one by quadrature.
    Split,
    /// Both by back-substitution.
    BothFast,
}

/// The motion of an oscillator over a step with polynomial forcing, at any instant of the step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ForcedStep {
    treatment: Treatment,
    /// h (s).
    length: f64,
    /// q (m), q̇ (m/s) at the start.
    start: [f64; 2],
    /// The forcing, or the polynomial solution for the fast modes; x ∈ [−1, 1] over the step.
    polynomial: Chebyshev,
    /// Free motion at the start, the state less the polynomial solution.
    offset: [f64; 2],
}

/// The longest step ≤ `length` whose modes are either slow or fast.
pub fn admissible_length(oscillator: &Oscillator, length: f64) -> f64 {
    let (slow, fast) = oscillator.rates();
    if fast * length <= SLOW || slow * length >= FAST {
        return length;
    }
    // A complex pair has one rate; the modes cannot be treated apart.
    let separable = oscillator.real_roots().is_some();
    let length = length.min(SLOW / slow);
    if separable && fast * length >= FAST { length } else { length.min(SLOW / fast) }
}

impl ForcedStep {
    /// The step of the given `length`, an admissible one, from q, q̇ = `start` under `forcing`.
    pub fn new(oscillator: &Oscillator, length: f64, forcing: Chebyshev, start: [f64; 2]) -> Self {
        let (slow, fast) = oscillator.rates();
        // d/dt = (2/h) d/dx.
        let scale = 2.0 / length;
        let [q, v] = start;
        let mut step =
            ForcedStep { treatment: Treatment::BothSlow, length, start, polynomial: forcing, offset: [0.0; 2] };
        if fast * length <= SLOW {
            return step;
        }
        match oscillator.real_roots() {
            Some((slow_root, fast_root)) if slow * length < FAST => {
                // w = q̇ − λ₁q obeys ẇ − λ₂w = p.
                step.treatment = Treatment::Split;
                step.polynomial = forcing.solve(-fast_root, scale, 0.0);
                step.offset = [v - slow_root * q - step.polynomial.at(-1.0), 0.0];
            }
            _ => {
                step.treatment = Treatment::BothFast;
                step.polynomial =
                    forcing.solve(oscillator.stiffness(), 2.0 * oscillator.damping() * scale, scale * scale);
                let [p, slope] = step.polynomial.with_slope(-1.0);
                step.offset = [q - p, v - scale * slope];
            }
        }
        step
    }

    /// q, q̇ at `tau` ∈ [0, h] (s) after the start of the step.
    pub fn at(&self, oscillator: &Oscillator, tau: f64) -> [f64; 2] {
        let place = |t: f64| 2.0 * t / self.length - 1.0;
        let free = oscillator.free(Double::from(tau));
        let rule = || Gauss::with(self.nodes(oscillator, tau));
        match (self.treatment, oscillator.real_roots()) {
            (Treatment::Split, Some((slow, fast))) => {
                let [slow_part, _] =
                    rule().integrate(tau, |s| [(slow * (tau - s)).exp() * self.polynomial.at(place(s)), 0.0]);
                let q = (slow * tau).exp() * self.start[0] + slow_part + self.offset[0] * free[0][1];
                let w = self.polynomial.at(place(tau)) + (fast * tau).exp() * self.offset[0];
                [q, w + slow * q]
            }
            (Treatment::BothFast, _) => {
                let [p, slope] = self.polynomial.with_slope(place(tau));
                let [q, v] = apply(&free, self.offset);
                [p + q, 2.0 / self.length * slope + v]
            }
            _ => {
                let forced = rule().integrate(tau, |s| {
                    let [g, rate] = oscillator.kernel(tau - s);
                    let p = self.polynomial.at(place(s));
                    [g * p, rate * p]
                });
                let [q, v] = apply(&free, self.start);
                [q + forced[0], v + forced[1]]
            }
        }
    }

    /// How many Gauss nodes integrate kernel times polynomial to rounding.
    fn nodes(&self, oscillator: &Oscillator, tau: f64) -> usize {
        let (slow, fast) = oscillator.rates();
        let span = tau * if self.treatment == Treatment::Split { slow } else { fast };
        // n nodes are exact up to degree 2n − 1; what the kernel adds beyond that is (span/4)ᵏ/k! with k ≥ n.
        match (self.polynomial.degree, span) {
            (0..=8, ..=1.0) => 8,
            _ => 16,
        }
    }
}

/// q, q̇ `tau` (s) after q, q̇ = `start` under a constant `forcing` (m/s²), however soft or stiff the oscillator is.
pub fn under_constant(oscillator: &Oscillator, forcing: f64, start: [f64; 2], tau: f64) -> [f64; 2] {
    let (slow, _) = oscillator.rates();
    if slow * tau > SLOW {
        let deflection = forcing / oscillator.stiffness();
        let [q, v] = apply(&oscillator.free(Double::from(tau)), [start[0] - deflection, start[1]]);
        return [deflection + q, v];
    }
    let mut constant = Chebyshev::default();
    constant.coefficients[0] = forcing;
    ForcedStep::new(oscillator, tau, constant, start).at(oscillator, tau)
}

/// M·s.
pub fn apply(m: &[[f64; 2]; 2], s: [f64; 2]) -> [f64; 2] {
    [m[0][0] * s[0] + m[0][1] * s[1], m[1][0] * s[0] + m[1][1] * s[1]]
}
