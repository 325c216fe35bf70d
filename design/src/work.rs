//! The counted work of a study: loops whose number of passes depends on values draw upon one budget, so that every study ends.
//!
//! Work is counted, not timed, because the end of a study must not depend on the computer.

use crate::Progress;
use camdrive::drives::Fault;
use std::cell::Cell;
use std::sync::{Mutex, PoisonError};

/// Plain operations that a study may take: some two minutes at a thousand million a second.
pub const BUDGET: f64 = 1.2e11;

/// Plain operations for one in numbers of thirty digits.
pub const PRECISE: f64 = 20.0;

thread_local! {
    /// The rest of the budget in this thread.
    static LEFT: Cell<f64> = const { Cell::new(f64::INFINITY) };
}

/// Draws upon the rest; false if it is used up.
pub fn draw(cost: f64) -> bool {
    LEFT.set(LEFT.get() - cost);
    !is_exhausted()
}

/// True if the work is used up, so that later results may be incomplete.
pub fn is_exhausted() -> bool {
    LEFT.get() < 0.0
}

/// The rest of the budget in this thread.
pub fn left() -> f64 {
    LEFT.get()
}

/// Does `work` in a thread of its own that may use `left` of another one; returns the work used.
pub fn taken(left: f64, work: impl FnOnce()) -> f64 {
    // Infinities have no difference.
    let left = left.min(f64::MAX);
    LEFT.set(left);
    work();
    left - LEFT.get()
}

/// The result of `study` within this budget, and within that of a study around it.
///
/// # Errors
/// A budget that is used up: the fault names the stage reached, with this hint.
pub fn within<R>(
    budget: f64,
    hint: &str,
    progress: &(dyn Fn(Progress) + Sync),
    study: impl FnOnce(&(dyn Fn(Progress) + Sync)) -> R,
) -> Result<R, Fault> {
    let reached = Mutex::new(String::new());
    let tell = |told: Progress| {
        if !is_exhausted() {
            *reached.lock().unwrap_or_else(PoisonError::into_inner) =
                format!("{}, {} of {}", told.stage, told.done, told.total);
        }
        progress(told);
    };
    let before = LEFT.get();
    let budget = budget.min(before);
    LEFT.set(budget);
    let result = study(&tell);
    let left = LEFT.replace(before);
    draw(budget - left);
    if left >= 0.0 {
        return Ok(result);
    }
    Err(Fault::new(format!(
        "this study needs more than the admissible {budget:.1e} operations, about {:.0} s; reached: {}",
        budget / 1e9,
        reached.into_inner().unwrap_or_else(PoisonError::into_inner)
    ))
    .hint(hint))
}
