//! What the steps so far can have done to q: the errors of the quadratures and the roundings, each step's decaying with
//! the free motion.
//!
//! The errors of the quadratures turn with cam and oscillator, so that they add up like independent ones: the squares of
//! their bounds are summed. (Where they do not turn, at a resonance, q itself grows with them.) The roundings of equal
//! steps are equal, for the same propagator is applied again and again: they are summed as they are.

use crate::numerics::oscillator::Oscillator;
use serde::{Deserialize, Serialize};

/// One rounding.
const ROUNDING: f64 = 0.5 * f64::EPSILON;

/// Roundings of a closed form besides two for each order of the law, for one harmonic after the other is turned on from
/// the one before: those of amplitude, phase, decay and sum.
const CLOSED: f64 = 8.0;

/// Roundings of the turns from step to step, for each order of the law: those of up to sixteen products cancel in part.
const TURNS: f64 = 8.0;

/// An estimate of the errors of q and q̇ that is rarely too small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorBound {
    /// Sum of the squares of what quadratures neglected of q [m²] and of q̇ [m²/s²], decayed.
    neglected: [f64; 2],
    /// Sum of the roundings of q [m] and q̇ [m/s], decayed.
    rounded: [f64; 2],
    /// The time over which errors of q̇ add up to errors of q [s].
    elapsed: f64,
    /// The largest |q| so far [m].
    largest: f64,
}

/// A step.
pub struct Made {
    /// Its length [s].
    pub length: f64,
    /// Bounds of the errors of its quadrature, of q [m] and q̇ [m/s].
    pub error: [f64; 2],
    /// A bound of |ẍ| [m/s²].
    pub forcing: f64,
    /// The order of the law.
    pub order: f64,
    /// q, q̇ at its end.
    pub state: [f64; 2],
}

impl ErrorBound {
    /// Adds a step; `decay` is that of the slow mode over it.
    pub fn add(&mut self, oscillator: &Oscillator, decay: f64, step: &Made) {
        let [q, v] = step.state.map(f64::abs);
        let rate = oscillator.stiffness().sqrt();
        // The propagator, which is the same in every step, and the forcing, whose angle is rounded, too.
        let forced = (4.0 + 2.0 * step.order) * step.length * step.forcing;
        let turned = (step.length * rate).min(1.0);
        let roundings = [2.0 * q + turned * v / rate.max(f64::MIN_POSITIVE), 2.0 * v + turned * rate * q + forced];
        let roundings = [roundings[0].min(2.0 * q + step.length * v), roundings[1]];
        for i in 0..2 {
            self.neglected[i] = decay * decay * self.neglected[i] + step.error[i] * step.error[i];
            self.rounded[i] = decay * self.rounded[i] + ROUNDING * roundings[i];
        }
        self.elapsed += step.length;
        self.largest = self.largest.max(q);
    }

    /// The estimate relative to the largest |q| so far; 0 where nothing has moved.
    pub fn relative(&self, oscillator: &Oscillator) -> f64 {
        // An error of q̇ turns into one of q within a quarter of a period or, softer, as long as it has had time.
        let span = self.elapsed.min(1.0 / oscillator.stiffness().sqrt());
        let neglected = (self.neglected[0] + span * span * self.neglected[1]).sqrt();
        let error = neglected + self.rounded[0] + span * self.rounded[1];
        if self.largest > 0.0 { (error / self.largest).min(1.0) } else { 0.0 }
    }

    /// The relative error of a closed form of a law of this order.
    pub fn of_closed_form(order: f64) -> f64 {
        (CLOSED + (2.0 + TURNS) * order) * ROUNDING
    }
}
