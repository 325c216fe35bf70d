//! Step control of the motion in the angle.

use super::Inertia;
use super::angle_step::{AngleStep, Position, Tabulated};
use super::mesh::{Cell, Mesh, tabulate};
use super::torques::Torques;
use crate::numerics::collocation::fit;
use crate::numerics::double_double::Double;

/// Steps below this part of a cell are left to the integration in time.
const SHORTEST: f64 = 1e-10;

/// Error that may remain in the collocation equations, as part of the tolerance: thousands of steps add up.
const REMAINDER: f64 = 1e-3;

/// Attempts per step.
const ATTEMPTS: usize = 60;

/// Steps in the angle under torques that stay as they are.
pub struct AngleSteps<'a> {
    /// J(φ).
    pub inertia: &'a Inertia,
    /// The cells of the turn.
    pub mesh: &'a Mesh,
    /// N(|φ̇|).
    pub torques: Torques,
    /// Relative tolerance.
    pub tolerance: f64,
    /// The length that the next step may have (rad).
    pub next_length: f64,
    /// Evaluations of N so far.
    pub evaluations: f64,
    /// Tables of 2/J that were made so far for parts of cells.
    pub tables: usize,
}

impl AngleSteps<'_> {
    /// The step from `position` on, not beyond the end of its cell and not longer than `most` (rad); None where no step
    /// meets the tolerance.
    pub fn pass(&mut self, position: Position, before: Option<&AngleStep>, most: f64) -> Option<AngleStep> {
        let cell = &self.mesh.cells()[position.cell];
        let forward = self.torques.sense > 0.0;
        let at_entry = self.mesh.is_entry(&position, self.torques.sense);
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
            let table = self.table(cell, &position, length, whole);
            let step = AngleStep::new(
                position,
                (length, to_edge),
                &table,
                &self.torques,
                before,
                remainder,
                &mut self.evaluations,
            );
            let error = step.as_ref().map_or(f64::INFINITY, |step| step.estimate.error);
            if error <= self.tolerance {
                // A step that was cut short says nothing against the length it was to have.
                self.next_length = match (whole, length == remaining) {
                    (true, _) => f64::INFINITY,
                    (_, true) => self.next_length.max(length * growth(error, self.tolerance)),
                    _ => length * growth(error, self.tolerance),
                };
                return step;
            }
            self.next_length = length * growth(error, self.tolerance);
            length = fit(self.next_length, remaining);
            if length < SHORTEST * cell.width {
                return None;
            }
        }
        None
    }

    /// 2/J over the step of `length`, in the order in which the machine passes it.
    fn table(&mut self, cell: &Cell, position: &Position, length: f64, whole: bool) -> Tabulated {
        let forward = self.torques.sense > 0.0;
        let mut table = if whole {
            cell.reciprocal
        } else {
            self.tables += 1;
            let low = if forward { position.angle.hi } else { position.angle.hi - length };
            tabulate(self.inertia, &self.mesh.profile, cell.interval, low, length)
        };
        if !forward {
            table.reverse();
        }
        table
    }
}

/// The factor by which to change a step that had this error.
fn growth(error: f64, tolerance: f64) -> f64 {
    if error.is_infinite() {
        return 0.25;
    }
    (0.85 * (tolerance / error.max(1e-300)).powf(0.1)).clamp(0.2, 4.0)
}
