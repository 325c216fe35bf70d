//! Internal steps along a motion: the control of their lengths, and their errors.

use crate::numerics::collocation::{Collocation, Failure, Statistics, System};
use crate::numerics::double_double::{Double, two_product};

/// A time that no step reaches.
pub const FAR: Double = Double { hi: 1e300, lo: 0.0 };

/// A step of fixed cost with a larger relative error is refused: the estimate no longer holds, and the result would be no value of
/// this drive.
pub const WORST: f64 = 1e-2;

/// By how much a step of fixed cost may differ from its length, so that no sliver is left before a point of the grid.
pub const SLIVER: f64 = 1e-3;

/// Factor of the error estimate over the coefficients of the polynomials and the covariance of the errors: so many standard
/// deviations that fewer than one normal variable in a thousand is larger.
pub const RESERVE: f64 = 3.5;

/// The same for the polynomials between the ends of steps under the tolerance, which may be read anywhere.
const RESERVE_BETWEEN_ENDS: f64 = 16.0;
/// The same, in addition, for the errors that add up from end to end.
const RESERVE_AT_ENDS: f64 = 6.0;
/// On inputs steps end at the communication points, so only the errors at the ends count.
const RESERVE_ON_INPUTS: f64 = 4.7;

/// The same for the polynomials of a tabulated period.
pub const RESERVE_OF_TABLE: f64 = 2.0;

/// Factor of the error estimate over single roundings.
pub const ROUNDINGS: f64 = 2.0;

/// Rule for the lengths of the internal steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepControl {
    /// The relative tolerance.
    Tolerance(f64),
    /// A grid of equal steps.
    Grid {
        /// The start of the grid (s).
        origin: f64,
        /// The length of a step (s).
        step: f64,
    },
}

/// The point (s) of the grid of equal steps from `origin` (s) on that ends a step from `from`.
pub fn point_of_grid(origin: f64, step: f64, from: Double) -> Double {
    let origin = Double::from(origin);
    let next = ((from - origin).hi / step + SLIVER).floor() + 1.0;
    origin + two_product(next, step)
}

impl StepControl {
    /// One step that does not reach beyond `limit`; one of fixed cost takes this number of Newton iterations.
    pub fn step<const N: usize>(
        self,
        integrator: &mut Collocation<N>,
        system: &impl System<N>,
        limit: Double,
        iterations: usize,
    ) -> Result<(), Failure> {
        match self {
            StepControl::Tolerance(tolerance) => integrator.step(system, limit, tolerance),
            StepControl::Grid { origin, step } => {
                let start = integrator.end();
                let point = point_of_grid(origin, step, start);
                let end = if (limit - point).hi > SLIVER * step { point } else { limit };
                if (end - start).hi > (1.0 + SLIVER) * system.longest_step(start, &integrator.state()) {
                    return Err(Failure::Stalled { time: start.hi });
                }
                integrator.step_of_fixed_cost(system, end, iterations, WORST)
            }
        }
    }

    /// Estimated relative error of the state so far, 1 if all digits are lost; on inputs every communication point is the end of a
    /// step.
    pub fn error_estimate(self, statistics: &Statistics, on_inputs: bool) -> f64 {
        let error = match (self, on_inputs) {
            (StepControl::Tolerance(_), false) => {
                RESERVE_BETWEEN_ENDS * statistics.error_estimate + RESERVE_AT_ENDS * statistics.error_at_ends
            }
            // On a grid the worst polynomial counts, which already overestimates the error.
            (StepControl::Grid { .. }, false) => statistics.state_error,
            (StepControl::Tolerance(_), true) => RESERVE_ON_INPUTS * statistics.error_at_ends,
            (StepControl::Grid { .. }, true) => RESERVE * statistics.error_at_ends,
        };
        // `min` turns NaN into 1.
        error.min(1.0)
    }
}
