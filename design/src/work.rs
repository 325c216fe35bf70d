//! The work of a study, counted: loops whose count depends on values draw upon one budget, so that every study ends.
//!
//! It is counted, not timed: whether a study ends well must not depend on the machine.

use crate::Progress;
use camdrive::drives::Fault;
use std::cell::Cell;
use std::sync::{Mutex, PoisonError};

/// Plain operations that a study may take: some two minutes at a thousand million a second.
pub const BUDGET: f64 = 1.2e11;

/// Plain operations that one in numbers of thirty digits takes.
pub const PRECISE: f64 = 20.0;

thread_local! {
    /// The rest of the budget in this thread.
    static LEFT: Cell<f64> = const { Cell::new(f64::INFINITY) };
}

/// Draws upon what is left; false where it is used up.
pub fn draw(cost: f64) -> bool {
    LEFT.set(LEFT.get() - cost);
    !is_exhausted()
}

/// True if the work is used up, so that what is found from now on may lack something.
pub fn is_exhausted() -> bool {
    LEFT.get() < 0.0
}

/// The rest of the budget in this thread.
pub fn left() -> f64 {
    LEFT.get()
}

/// Does `work` in a thread of its own that may take what is `left` in another one; what it took.
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
/// Where the budget is used up: what was reached, with this hint.
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
        "this study needs more than the {budget:.1e} operations that are admissible, about {:.0} s; reached: {}",
        budget / 1e9,
        reached.into_inner().unwrap_or_else(PoisonError::into_inner)
    ))
    .hint(hint))
}
