//! How the corrections of Newton's method become smaller.

use super::solved::remainder;

/// The contraction of Newton's method beyond which the matrix of its first iteration is too far from the Jacobians along
/// the step to carry errors: over the thousands of steps of an undamped motion a thousandth in each can make them grow
/// without end. A smaller bound changes the estimate little and has more steps factorise twice.
const STALE: f64 = 3e-4;

/// A contraction below this that the first two corrections tell is chance: with the matrix of a state that stands still some
/// 1e-4 is what they reach. A larger bound finds more of them, and makes more steps take a third correction.
const LUCKY: f64 = 5e-6;

/// How the corrections of Newton's method become smaller.
pub struct Contraction {
    /// What the corrections to come may be together.
    enough: f64,
    iteration: usize,
    size: f64,
    /// The size of a correction over that of the one before; unknown, a comparison with which is false, before the second.
    rate: f64,
}

impl Contraction {
    /// Before the first correction in a step under the relative tolerance.
    pub fn new(tolerance: f64) -> Self {
        // Newton's error is not controlled by the step, so it is kept far below the tolerance.
        Contraction { enough: (1e-4 * tolerance).max(1e-16), iteration: 0, size: f64::NAN, rate: f64::NAN }
    }

    /// Whether a correction of this size, measured like the one before or not, is the last: either the corrections that are still to
    /// come are small, or rounding stops the contraction.
    pub fn ends_with(&mut self, size: f64, alike: bool, rounding: impl FnOnce() -> f64) -> bool {
        let rate = if alike { size / self.size } else { f64::NAN };
        // The first one leads from a state that stands still: the second may be small by chance, and the third is not.
        let likely = if self.iteration == 1 { rate.max(LUCKY) } else { rate };
        let converged = rate < 1.0 && size * likely / (1.0 - likely) <= self.enough;
        (self.iteration, self.size, self.rate) = (self.iteration + 1, size, rate);
        size <= self.enough || converged || (rate > 0.3 && size <= rounding())
    }

    /// Whether the matrix is too far from the Jacobians to carry errors.
    pub fn is_stale(&self) -> bool {
        self.rate > STALE && !(self.size > self.enough && self.rate > 0.3)
    }

    /// Whether the next correction needs a matrix of its own.
    pub fn is_slow(&self) -> bool {
        self.rate > 0.05
    }

    /// The sum of the corrections still to come.
    pub fn remainder(&self, rounding: impl FnOnce() -> f64) -> f64 {
        remainder(self.size, self.rate, rounding)
    }
}
