//! Error estimate of q from the steps so far: the errors of the quadratures and the roundings; each step's errors decay with the
//! free motion.
//!
//! The errors of the quadratures turn with cam and oscillator, so that those of different waves add up like independent ones: the
//! squares of their bounds are summed, and so are those of the roundings of ẍ. (They do not turn at a resonance, but there q itself
//! grows with them.) The roundings of equal steps are equal, since the same propagator is applied again and again: they are summed
//! linearly.

use crate::drives::solver::step_control::ROUNDINGS;
use crate::numerics::chebyshev::Chebyshev;
use crate::numerics::oscillator::Oscillator;
use serde::{Deserialize, Serialize};

/// One rounding.
const ROUNDING: f64 = 0.5 * f64::EPSILON;

/// Roundings of a closed form besides two for each order of the law, since one harmonic after the other is rotated from the
/// previous one: the roundings of amplitude, phase, decay and sum.
const CLOSED: f64 = 24.0;

/// Rounding error of the harmonic k of a closed form, relative to its amplitude.
pub fn of_harmonics(k: f64) -> f64 {
    (CLOSED + 2.0 * k) * ROUNDING
}

/// Relative rounding error of the free motion of a closed form.
pub fn of_free_motion() -> f64 {
    CLOSED * ROUNDING
}

/// Roundings of 1 rad in the angle at which a breakpoint is passed: near 2π half a unit in the last place is four of them, and both
/// the breakpoint and the angle of the cam are rounded.
const PASSED: f64 = 8.0;

/// The quadratures of successive steps have equal errors as long as the highest harmonic turns by about this (rad).
const ALIKE: f64 = 2.0;

/// At most so many steps, for a cam that hardly moves.
const MOST_ALIKE: f64 = 1e4;

/// An estimate of the errors of q and q̇ that is rarely too small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorBound {
    /// Sum of the squares of the effects of neglected quadrature terms and of roundings of ẍ on q (m²) and on q̇ (m²/s²), decayed.
    neglected: [f64; 2],
    /// Sum of the roundings of q (m) and q̇ (m/s), decayed.
    rounded: [f64; 2],
    /// The time over which errors of q̇ add up to errors of q (s).
    elapsed: f64,
    /// The largest |q| and the largest estimated error of q so far (m).
    pub largest: f64,
    worst: f64,
    /// The largest relative error of a closed form so far.
    closed: f64,
}

/// A step.
#[derive(Clone, Copy, Debug)]
pub struct StepErrors {
    /// Its length (s).
    pub length: f64,
    /// Bounds of the errors of its quadrature, of q (m) and q̇ (m/s), at its end.
    pub error: [f64; 2],
    /// A bound of |ẍ| (m/s²).
    pub forcing: f64,
    /// The order of the law.
    pub order: f64,
    /// The angle by which its highest harmonic turns in the step (rad).
    pub turned: f64,
    /// The angle as it was rounded (rad), 0 if it is known to more digits; larger if the law has breakpoints.
    pub angle: f64,
    /// q, q̇ at its end.
    pub state: [f64; 2],
}

impl ErrorBound {
    /// Adds a step; `decay` is the slow mode's over it; `within` are the errors between its ends if it is read there, which are not
    /// passed on.
    pub fn add(&mut self, oscillator: &Oscillator, decay: f64, step: &StepErrors, within: [f64; 2]) {
        let rate = oscillator.stiffness().sqrt();
        let [q, v] = step.state.map(f64::abs);
        // The propagator, which is the same in every step.
        let quarter = 1.0 / rate;
        let reach = step.length.min(quarter);
        let roundings = [2.0 * q + reach * v, 2.0 * v + reach * rate * rate * q];
        // The forcing, whose angle is rounded, too.
        let forced = ROUNDING * (8.0 + step.order * (2.0 + step.angle.abs())) * step.length * step.forcing;
        // Successive steps that are short against a wave have equal errors.
        let alike = 1.0 + ALIKE / step.turned.max(ALIKE / MOST_ALIKE);
        let squares = step.error.map(|error| alike * error * error);
        let squares = [squares[0], squares[1] + forced * forced];
        for i in 0..2 {
            self.neglected[i] = decay * decay * self.neglected[i] + squares[i];
            self.rounded[i] = decay * self.rounded[i] + ROUNDING * roundings[i];
        }
        self.elapsed += step.length;
        self.reach(step.state[0]);
        self.take_worst(rate, within);
    }

    /// Adds that a breakpoint of the law, at which U″ω `jumps` (m/s per rad), was passed some roundings and one rounding of `angle`
    /// (rad) too late.
    pub fn pass(&mut self, oscillator: &Oscillator, jumps: f64, angle: f64) {
        let v = jumps * ROUNDING * (PASSED + angle.abs());
        self.neglected[1] += v * v;
        self.take_worst(oscillator.stiffness().sqrt(), [0.0; 2]);
    }

    /// Adds errors of q (m) and q̇ (m/s) from outside the steps; the next step takes them up.
    pub fn disturb(&mut self, errors: [f64; 2]) {
        for (sum, error) in self.neglected.iter_mut().zip(errors) {
            *sum += (ROUNDINGS * error).powi(2);
        }
    }

    /// Takes up the largest error of q that the errors so far and those `within` a step can cause.
    pub fn take_worst(&mut self, rate: f64, within: [f64; 2]) {
        // An error of q̇ turns into one of q within a quarter of a period or, for a softer spring, within the elapsed time.
        let span = self.elapsed.min(1.0 / rate);
        let [of_q, of_v] = [0, 1].map(|i| self.neglected[i] + within[i] * within[i]);
        let neglected = (of_q + span * span * of_v).sqrt();
        self.worst = self.worst.max(neglected + self.rounded[0] + span * self.rounded[1]);
    }

    /// Records that q has reached this value (m).
    pub fn reach(&mut self, q: f64) {
        self.largest = self.largest.max(q.abs());
    }

    /// Adds a closed form of a law of this order.
    pub fn add_closed_form(&mut self, order: f64) {
        self.closed = self.closed.max(of_harmonics(order) + of_free_motion());
    }

    /// Adds a table whose polynomials err by this part, and roundings of the states that it leads through: independent within a
    /// turn, equal from turn to turn. The law's roundings make `of_law` (m) of q.
    pub fn add_table(&mut self, part: f64, roundings: f64, of_law: f64) {
        self.worst = self.worst.max(of_law);
        self.closed = self.closed.max(part + CLOSED * roundings * ROUNDING);
    }

    /// The largest error relative to the largest |q|; 0 if nothing has moved.
    pub fn relative(&self) -> f64 {
        let of_steps = if self.largest > 0.0 { (self.worst / self.largest).min(1.0) } else { 0.0 };
        of_steps.max(self.closed)
    }
}

/// Errors of q (m) and q̇ (m/s) by the coefficients N₁ and N₂ that an interpolant of −ẍ over `length` (s) lacks: at the end of the
/// piece and between its ends.
///
/// At the points of interpolation Tₙ₊ₘ is Tₙ₋ₘ, so that −ẍ errs by N₁ (Tₙ₊₁ − Tₙ₋₁) + N₂ (Tₙ₊₂ − Tₙ₋₂), n even. Over the whole
/// piece the first term integrates to nothing, and x times it to 20/n³ at most, the second to 40/n³; over a part of it to 2/n. So
/// N₁ acts on a slow oscillator only by the change of its impulse response. A fast one follows −ẍ, which is right at the ends; the
/// rates 4n N₁ and 8n N₂ act on it there.
pub fn neglected(oscillator: &Oscillator, polynomial: &Chebyshev, length: f64) -> [[f64; 2]; 2] {
    let n = polynomial.degree as f64;
    let next = polynomial.neglected();
    let (_, fast) = oscillator.rates();
    let (half, turned) = (0.5 * length, (fast * length).min(1.0));
    let g = length.min(1.0 / fast);
    let between = 2.0 / n * half * (next[0] + next[1]);
    let whole = 20.0 / n.powi(3) * half;
    let follows = if fast * length > 1.0 { 8.0 * n * (next[0] + 2.0 * next[1]) / (fast * fast * half) } else { 0.0 };
    let end = whole * (turned * next[0] + 2.0 * next[1]);
    [[whole * g * (next[0] + 2.0 * next[1]), end.max(follows.min(between))], [g * between, between]]
}
