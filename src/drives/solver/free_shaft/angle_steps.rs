//! Successive steps in the angle and the control of their lengths.

use super::angle_step::{AngleStep, Part, Position};
use super::mesh::{Mesh, tabulate};
use crate::drives::shaft::free::torques::Torques;
use crate::numerics::collocation::fit;
use crate::numerics::double_double::Double;
use serde::{Deserialize, Serialize};

/// Steps below this part of a cell are left to the integration in time.
const SHORTEST: f64 = 1e-10;

/// Error that may remain in the collocation equations, as part of the tolerance: thousands of steps add up.
const REMAINDER: f64 = 1e-3;

/// Attempts per step.
const ATTEMPTS: usize = 60;

/// Steps in the angle under torques that do not change.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct AngleSteps {
    /// N(|φ̇|).
    pub torques: Torques,
    /// Relative tolerance.
    pub tolerance: f64,
    /// The admissible length of the next step (rad).
    pub next_length: f64,
    /// Evaluations of N, and tables of 2/J for parts of cells, in the last step.
    pub evaluations: f64,
    pub tables: usize,
}

impl AngleSteps {
    /// Steps of which the first may have any length.
    pub fn new(torques: Torques, tolerance: f64) -> Self {
        AngleSteps { torques, tolerance, next_length: f64::INFINITY, ..AngleSteps::default() }
    }

    /// The step from `position` on, not beyond the end of its cell and not longer than `most` (rad); None if no step meets the
    /// tolerance.
    pub fn pass(
        &mut self,
        mesh: &Mesh,
        position: Position,
        before: Option<&AngleStep>,
        most: f64,
    ) -> Option<AngleStep> {
        (self.evaluations, self.tables) = (0.0, 0);
        let cell = &mesh.cells()[position.cell];
        let forward = self.torques.sense > 0.0;
        let at_entry = position.angle == cell.entry(forward);
        let to_end = match (at_entry, forward) {
            (true, _) => cell.width,
            (false, true) => (Double::from(cell.high) - position.angle).hi,
            (false, false) => (position.angle - Double::from(cell.low)).hi,
        };
        let remaining = to_end.min(most);
        let remainder = (REMAINDER * self.tolerance).max(1e-16);
        let mut length = fit(self.next_length, remaining);
        for _ in 0..ATTEMPTS {
            let to_edge = length == to_end;
            let whole = at_entry && to_edge;
            let mut table = if whole {
                cell.reciprocal
            } else {
                self.tables += 1;
                let low = if forward { position.angle.hi } else { position.angle.hi - length };
                tabulate(&mesh.profile, cell.interval, low, length)
            };
            if !forward {
                table.reverse();
            }
            let part = Part { from: position, length, to_edge, reciprocal: &table };
            let step = AngleStep::new(&part, &self.torques, before, remainder, &mut self.evaluations);
            let error = step.as_ref().map_or(f64::INFINITY, |step| step.estimate.error);
            let next_length = || length * growth(error, self.tolerance);
            if error <= self.tolerance {
                // A step that was cut short says nothing against its proposed length.
                self.next_length = match (whole, length == remaining) {
                    (true, _) => f64::INFINITY,
                    (_, true) => self.next_length.max(next_length()),
                    _ => next_length(),
                };
                return step;
            }
            self.next_length = next_length();
            length = fit(self.next_length, remaining);
            if length < SHORTEST * cell.width {
                return None;
            }
        }
        None
    }
}

/// The factor for the length of a step after this error.
fn growth(error: f64, tolerance: f64) -> f64 {
    if error.is_infinite() {
        return 0.25;
    }
    (0.85 * (tolerance / error.max(1e-300)).powf(0.1)).clamp(0.2, 4.0)
}
