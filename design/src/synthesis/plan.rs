//! Which solver finds the profiles of a task.

use super::shaft::ShaftGoal;
use super::{Objective, Task};

/// A solver and its data besides the task.
pub enum Plan {
    /// [`super::convex`]: one linear or quadratic program, whose optimum is the only one; at the speeds of an elastic output
    /// member as often as speeds join.
    Convex,
    /// [`super::levels`]: such programs until the integral of the squared errors has this value (m²).
    WithinIntegral(f64),
    /// [`super::convex_concave`]: such programs near the last profiles, on both sides of where tools would be nearest.
    Clear,
    /// [`super::levels`]: Chebyshev's programs until the widths of these dwells reach the tolerance (m).
    LongestDwell { tolerance: f64, dwells: [usize; 2] },
    /// [`super::levels`]: Chebyshev's programs with more and more harmonics until the tolerance (m) is kept.
    FewestHarmonics { tolerance: f64 },
    /// [`super::least_torque`]: linear programs within a trust region, from several starts; of the kinetostatic torque, or of
    /// that in this shaft.
    LeastTorque(Option<ShaftGoal>),
}

impl Plan {
    /// The plan of a task.
    pub fn of(task: &Task) -> Self {
        match task.objective {
            Objective::PeakTorque => Plan::LeastTorque(None),
            Objective::ShaftTorque(goal) => Plan::LeastTorque(Some(goal)),
            Objective::LongestDwell { tolerance, dwells } => Plan::LongestDwell { tolerance, dwells },
            Objective::FewestHarmonics { tolerance } => Plan::FewestHarmonics { tolerance },
            Objective::LeastSquares
            | Objective::Chebyshev
            | Objective::ChebyshevSum
            | Objective::PeakAcceleration
            | Objective::MeanSquareAcceleration => match (task.integral, task.clearances.is_empty()) {
                (None, true) => Plan::Convex,
                (None, false) => Plan::Clear,
                (Some(limit), _) => Plan::WithinIntegral(limit),
            },
        }
    }
}
