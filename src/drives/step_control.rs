//! Internal steps along a motion: what decides their lengths, what they err by, what is said where they fail.

use super::cam_drive::AngleMotion;
use super::limits::step_too_much;
use super::settings::{Method, Solver};
use super::{Fault, Rounded};
use crate::numerics::collocation::{Collocation, Failure, Statistics, System};
use crate::numerics::double_double::{Double, two_product};
use crate::numerics::work::Work;

/// A time that no step reaches.
pub const FAR: Double = Double { hi: 1e300, lo: 0.0 };

/// A step of fixed cost that misses the motion by more than this part of it is refused: the estimate is one no more,
/// and what follows would be no value of this drive.
pub const WORST: f64 = 1e-2;

/// By how much a step of fixed cost may differ from its length, so that no sliver is left before a point of the grid.
pub const SLIVER: f64 = 1e-3;

/// Factors by which the error estimate exceeds what the coefficients of the polynomials tell, so that of 100 random drives
/// 99 err by less. This one is for the polynomials between the ends of steps where the tolerance decides.
const RESERVE_BETWEEN_ENDS: f64 = 16.0;
/// Beside them count the errors that add up from end to end.
const RESERVE_AT_ENDS: f64 = 6.0;
/// Among equal steps the worst polynomial counts, which overestimates the error by itself.
const RESERVE_OF_EQUAL_STEPS: f64 = 1.0;
/// On inputs steps end at the communication points, so that only the errors at the ends count.
const RESERVE_ON_INPUTS: f64 = 5.0;
/// The same for equal steps on inputs.
const RESERVE_OF_EQUAL_STEPS_ON_INPUTS: f64 = 3.5;

/// Factor of the estimate for the polynomials of a tabulated period.
pub const RESERVE_OF_TABLE: f64 = 2.0;

/// Rule for the lengths of the internal steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepControl {
    /// The relative tolerance.
    Tolerance(f64),
    /// A grid of equal steps.
    Grid {
        /// Where it starts (s).
        origin: f64,
        /// The length of a step (s).
        step: f64,
    },
}

/// Names of the drive's own quantities in messages.
#[derive(Clone, Copy, Debug)]
pub struct Words {
    /// The integrated quantity: "the twist q".
    pub quantity: &'static str,
    /// The turning part: "the cam".
    pub turning: &'static str,
    /// Parameters that may be wrong where no step keeps the tolerance: "J, m, c, b".
    pub parameters: &'static str,
    /// Parameters that may be wrong where the work is too much: "c and J".
    pub frequency: &'static str,
}

/// The point (s) of the grid of equal steps from `origin` (s) on that a step from `from` goes to.
pub fn point_of_grid(origin: f64, step: f64, from: Double) -> Double {
    let origin = Double::from(origin);
    let next = ((from - origin).hi / step + SLIVER).floor() + 1.0;
    origin + two_product(next, step)
}

/// Why the steps end before their target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// A step failed.
    Failed(Failure),
    /// The work of the call is used up.
    Exhausted {
        /// When (s).
        time: f64,
    },
    /// More attempts than the steps of a grid may take.
    TooManyAttempts {
        /// When (s).
        time: f64,
    },
}

impl StepControl {
    /// The control that the settings ask for on a motion known from `from` to `target` only (s), as on inputs: equal steps
    /// divide it, the longest ones that do not exceed what is asked for, `usual` (s) where nothing is.
    pub fn within(solver: &Solver, from: f64, target: f64, usual: impl FnOnce() -> f64) -> Self {
        match solver.settings.method {
            Method::Adaptive => StepControl::Tolerance(solver.effective_tolerance()),
            Method::FixedCost => {
                let asked = solver.settings.step_size;
                let (step, length) = (if asked > 0.0 { asked } else { usual() }, target - from);
                StepControl::Grid { origin: from, step: length / (length / step).ceil().max(1.0) }
            }
        }
    }

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

    /// Steps until the last one ends at or beyond `target`; a step of a grid may take this number of attempts. Draws upon the
    /// `work`, of which an evaluation of the equation takes `cost` (nominal µs).
    pub fn integrate<const N: usize>(
        self,
        integrator: &mut Collocation<N>,
        target: Double,
        attempts: u64,
        (work, cost): (&mut Work, f64),
        mut step: impl FnMut(&mut Collocation<N>) -> Result<(), Failure>,
    ) -> Result<(), Stop> {
        let first = integrator.statistics.steps;
        let most = match self {
            StepControl::Tolerance(_) => f64::INFINITY,
            StepControl::Grid { step, .. } => attempts as f64 * (((target - integrator.end()).hi / step).ceil() + 1.0),
        };
        // Steps that nobody can wait for are refused before the first.
        if most.is_finite() && !work.allows(cost * most / attempts as f64) {
            return Err(Stop::Exhausted { time: integrator.end().hi });
        }
        while (target - integrator.end()).hi > 0.0 {
            let (time, before) = (integrator.end().hi, integrator.statistics.evaluations);
            step(integrator).map_err(Stop::Failed)?;
            // A step that evaluated nothing would be taken for ever.
            let evaluations = (integrator.statistics.evaluations - before).max(1);
            work.draw(cost * evaluations as f64).map_err(|_| Stop::Exhausted { time })?;
            if (integrator.statistics.steps - first) as f64 > most {
                return Err(Stop::TooManyAttempts { time });
            }
        }
        Ok(())
    }

    /// Estimated relative error of the state so far, 1 where all digits are lost; on inputs every communication point is the
    /// end of a step.
    pub fn error_estimate(self, statistics: &Statistics, on_inputs: bool) -> f64 {
        let error = match (self, on_inputs) {
            (StepControl::Tolerance(_), false) => {
                RESERVE_BETWEEN_ENDS * statistics.error_estimate + RESERVE_AT_ENDS * statistics.error_at_ends
            }
            (StepControl::Grid { .. }, false) => RESERVE_OF_EQUAL_STEPS * statistics.state_error,
            (StepControl::Tolerance(_), true) => RESERVE_ON_INPUTS * statistics.error_at_ends,
            (StepControl::Grid { .. }, true) => RESERVE_OF_EQUAL_STEPS_ON_INPUTS * statistics.error_at_ends,
        };
        // `min` takes what is no number for 1.
        error.min(1.0)
    }

    /// The fault of a stop on the way from one time to another (s) along this `motion`, but for growth without bound.
    pub fn fault(self, stop: Stop, words: &Words, way: [f64; 2], motion: &AngleMotion) -> Fault {
        let Words { quantity, turning, parameters, frequency } = words;
        Fault::new(match (stop, self) {
            (Stop::Failed(Failure::Stalled { time } | Failure::Unbounded { time }), StepControl::Grid { step, .. }) => {
                format!(
                    "{quantity} cannot be computed beyond t = {} s with internal steps of {} s: they turn {turning} \
                 too far, or miss more than {WORST} of the motion; shorten solver.step_size, or set \
                 solver.method = adaptive",
                    Rounded(time),
                    Rounded(step)
                )
            }
            (Stop::Failed(Failure::Stalled { time } | Failure::Unbounded { time }), StepControl::Tolerance(_)) => {
                format!(
                    "{quantity} cannot be computed beyond t = {} s: no internal step keeps the tolerance; check {parameters} \
                 and the speed, or relax solver.tolerance",
                    Rounded(time)
                )
            }
            (Stop::Exhausted { time } | Stop::TooManyAttempts { time }, control) => {
                let setting = if matches!(control, StepControl::Grid { .. }) {
                    "lengthen solver.step_size"
                } else {
                    "relax solver.tolerance"
                };
                let hint = format!("{setting}, or check the speed, {frequency}");
                return step_too_much(way, time, &motion.told(turning, way), &hint);
            }
        })
    }
}
