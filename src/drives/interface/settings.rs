//! The solver settings and statistics that every drive declares.

use super::{List, unit, variable};
use serde::{Deserialize, Serialize};

/// Relative tolerance of a drive by default: the documented accuracy.
pub const DEFAULT_TOLERANCE: f64 = 1e-10;

/// The finest tolerance that double precision can honour.
pub const FINEST_TOLERANCE: f64 = 1e-14;

/// The coarsest tolerance that may be requested.
pub const COARSEST_TOLERANCE: f64 = 1.0;

/// The longest internal step that may be requested (s): longer than any communication step.
pub const LONGEST_STEP_SIZE: f64 = 1e6;

/// Method that decides the internal steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The tolerance: steps as long as it allows.
    #[default]
    Adaptive,
    /// A grid of equal steps from the start on, each of the same cost, for hosts with a deadline.
    FixedCost,
}

/// The items of `solver.method`, in the order of [`Method`].
pub static METHOD: variable::Enumeration = variable::Enumeration {
    name: "SolverMethod",
    items: &[
        ("adaptive", "Internal steps as long as solver.tolerance allows"),
        ("fixed_cost", "Equal internal steps of solver.step_size, each of the same cost"),
    ],
};

impl Method {
    /// The number of the item in [`METHOD`].
    pub fn number(self) -> f64 {
        match self {
            Method::Adaptive => 1.0,
            Method::FixedCost => 2.0,
        }
    }

    /// The method with this number.
    pub fn from_number(number: f64) -> Self {
        if number == 2.0 { Method::FixedCost } else { Method::Adaptive }
    }
}

/// User's settings of the solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// `solver.tolerance`: relative, 0 for the default.
    pub tolerance: f64,
    /// `solver.method`.
    pub method: Method,
    /// `solver.step_size` (s) of the method `fixed_cost`, 0 for the drive's own choice.
    pub step_size: f64,
}

/// Settings and statistics of a drive's solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Solver {
    /// The user's settings.
    pub settings: Settings,
    /// Tolerance that the importer requested at set-up; 0 if none.
    pub requested: f64,
    /// Internal steps since the start.
    pub steps: f64,
    /// Evaluations of the right-hand side (or of the closed form) since the start.
    pub evaluations: f64,
    /// Estimated relative error of the state so far.
    pub error_estimate: f64,
}

impl Solver {
    /// A solver with these settings.
    pub fn new(settings: Settings) -> Self {
        Solver { settings, ..Solver::default() }
    }

    /// The tolerance in use: the user's, else the default; the importer's counts only if it is finer.
    pub fn effective_tolerance(&self) -> f64 {
        let Settings { tolerance, .. } = self.settings;
        let own = if tolerance > 0.0 { tolerance } else { DEFAULT_TOLERANCE };
        let finest = if self.requested > 0.0 { own.min(self.requested) } else { own };
        finest.max(FINEST_TOLERANCE)
    }

    /// Clears the statistics.
    pub fn start(&mut self) {
        (self.steps, self.evaluations, self.error_estimate) = (0.0, 0.0, 0.0);
    }
}

/// A drive with solver settings.
pub trait HasSolver: Sized {
    /// The solver.
    fn solver(&self) -> &Solver;
    /// The solver, to change it.
    fn solver_mut(&mut self) -> &mut Solver;

    /// Whether `solver.method` changes anything: a drive whose steps all cost the same has no such choice.
    fn has_method(&self) -> bool {
        false
    }

    /// Whether `solver.tolerance` changes anything: a closed form is at rounding level anyway.
    fn has_tolerance(&self) -> bool {
        true
    }

    /// Declares `solver.tolerance`, `solver.method` and `solver.step_size`, each if it has an effect, and the statistics, which are
    /// computed values from this place on.
    fn declare_solver(&self, list: &mut List<Self>, place: usize) {
        if self.has_tolerance() {
            list.parameter(
                "solver.tolerance",
                "Relative tolerance; 0 for the documented default",
                variable::real_within(&unit::NUMBER, 0.0, COARSEST_TOLERANCE),
                |d, _| d.solver().settings.tolerance,
                |d, _, value| d.solver_mut().settings.tolerance = value,
            );
        }
        if self.has_method() {
            list.parameter(
                "solver.method",
                "Control of the internal steps",
                variable::Kind::Enumeration(&METHOD),
                |d, _| d.solver().settings.method.number(),
                |d, _, value| d.solver_mut().settings.method = Method::from_number(value),
            );
            list.parameter(
                "solver.step_size",
                "Internal step of the method fixed_cost; 0 for the documented default",
                variable::real_within(&unit::TIME, 0.0, LONGEST_STEP_SIZE),
                |d, _| d.solver().settings.step_size,
                |d, _, value| d.solver_mut().settings.step_size = value,
            );
        }
        let texts = [
            ("steps", "Internal steps since the start"),
            ("evaluations", "Evaluations of the equations since the start"),
            ("error_estimate", "Estimated relative error of the state"),
        ];
        for (i, (name, text)) in texts.into_iter().enumerate() {
            list.local(&format!("solver.{name}"), text, variable::real(&unit::NUMBER)).at(place + i);
        }
    }

    /// Values of the variables that [`HasSolver::declare_solver`] declares, in the order of their places.
    fn statistics(&self) -> [f64; 3] {
        // `min` turns NaN into 1: all digits are lost.
        let &Solver { steps, evaluations, error_estimate, .. } = self.solver();
        [steps, evaluations, error_estimate.min(1.0)]
    }
}
