//! The solver settings and statistics that every drive declares.

use super::{List, unit, variable};
use serde::{Deserialize, Serialize};

/// Relative tolerance of a drive whose user asks for nothing: the documented accuracy.
pub const DEFAULT_TOLERANCE: f64 = 1e-10;

/// The finest tolerance that double precision can honour.
pub const FINEST_TOLERANCE: f64 = 1e-14;

/// Settings and statistics of a drive's solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Solver {
    /// `solver.tolerance`: relative, 0 for the default.
    pub tolerance: f64,
    /// What the importer asked for at set-up; 0 if nothing.
    pub requested: f64,
    /// Internal steps since the start.
    pub steps: f64,
    /// Evaluations of the right-hand side (or of the closed form) since the start.
    pub evaluations: f64,
    /// Estimated relative error of the state so far.
    pub error_estimate: f64,
}

impl Solver {
    /// A solver with this `solver.tolerance`.
    pub fn new(tolerance: f64) -> Self {
        Solver { tolerance, ..Solver::default() }
    }

    /// The tolerance to work with: the user's, else the default; a finer one of the importer is honoured, a
    /// coarser one is not.
    pub fn effective_tolerance(&self) -> f64 {
        let own = if self.tolerance > 0.0 { self.tolerance } else { DEFAULT_TOLERANCE };
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

    /// Declares `solver.tolerance` and the statistics.
    fn declare_solver(&self, list: &mut List<Self>) {
        list.parameter(
            "solver.tolerance",
            "Relative tolerance; 0 for the documented default",
            variable::real_within(&unit::NUMBER, 0.0, 1.0),
            |d, _| d.solver().tolerance,
            |d, _, value| d.solver_mut().tolerance = value,
        );
        let number = || variable::real(&unit::NUMBER);
        list.local("solver.steps", "Internal steps since the start", number(), |d, _| d.solver().steps);
        list.local("solver.evaluations", "Evaluations of the equations since the start", number(), |d, _| {
            d.solver().evaluations
        });
        list.local("solver.error_estimate", "Estimated relative error of the state", number(), |d, _| {
            d.solver().error_estimate
        });
    }
}
