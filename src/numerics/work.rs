//! The work of a call, counted: loops whose count depends on values draw upon one budget, so that every call ends.
//!
//! The cost of operations is stated in nominal microseconds, measured on a processor core of 3 GHz. They are counted, not timed:
//! whether a call ends well must not depend on the machine.

use std::cell::Cell;

/// The work that a call may take (nominal µs). It lasts a second if a nominal microsecond takes 2.5 µs, as on a shared server at
/// 2.5 GHz. A simulator that waits longer seems to hang, and no sensible communication step needs more: ten thousand turns of a
/// drive of few harmonics fit in.
pub const BUDGET: f64 = 0.4e6;

/// An evaluation of the equation in a step of the collocation, with its part of the linear equations (nominal µs).
pub const EVALUATION: f64 = 0.25;

/// Cost of a harmonic of a law in an evaluation (nominal µs).
pub const HARMONIC: f64 = 0.005;

/// Work left of the budget.
#[derive(Clone, Copy, Debug)]
pub struct Work(f64);

/// The budget is used up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exhausted;

pub(crate) use drawn::limited as budget;

thread_local! {
    static DRAWN: Cell<f64> = const { Cell::new(0.0) };
}

/// A moment in this thread. It serves to count the work of several starts of a drive together.
#[derive(Clone, Copy, Debug)]
pub struct Since(f64);

impl Since {
    /// This moment.
    pub fn now() -> Self {
        Since(DRAWN.get())
    }

    /// The work drawn or noted since (nominal µs).
    pub fn drawn(self) -> f64 {
        DRAWN.get() - self.0
    }

    /// Whether more was drawn or noted since than a call of several starts may take: a fifth more than another call, which is
    /// enough for a machine of several tools with mechanisms.
    pub fn is_exhausted(self) -> bool {
        self.drawn() > 1.2 * budget()
    }
}

/// Counts work that needs no budget, since the scene alone determines it (nominal µs).
pub fn note(cost: f64) {
    DRAWN.set(DRAWN.get() + cost);
}

impl Default for Work {
    /// The work of a call that has not begun yet.
    fn default() -> Self {
        Work(budget())
    }
}

impl Work {
    /// Draws upon it (nominal µs).
    #[inline]
    pub fn draw(&mut self, cost: f64) -> Result<(), Exhausted> {
        DRAWN.set(DRAWN.get() + cost);
        self.0 -= cost;
        // Comparisons with NaN are false.
        if self.0 >= 0.0 { Ok(()) } else { Err(Exhausted) }
    }

    /// Whether as much as this is left (nominal µs).
    pub fn allows(&self, cost: f64) -> bool {
        cost <= self.0
    }

    /// Whether it is used up.
    pub fn is_exhausted(&self) -> bool {
        !(self.0 >= 0.0)
    }
}

/// Draws upon work that several share, if it is bounded; None if it is used up.
pub fn draw(shared: Option<&Cell<Work>>, cost: f64) -> Option<()> {
    let Some(shared) = shared else { return Some(()) };
    let mut left = shared.get();
    let drawn = left.draw(cost);
    shared.set(left);
    drawn.ok()
}

/// For tests: the work drawn, and smaller budgets. It is always compiled, so that one build serves tools and tests.
pub mod drawn {
    use std::cell::Cell;

    thread_local! {
        static LIMIT: Cell<f64> = const { Cell::new(super::BUDGET) };
    }

    /// The budget of a call in this thread.
    pub fn limited() -> f64 {
        LIMIT.get()
    }

    /// Limits the budget until the guard is dropped, so that exhausting it takes no time.
    pub fn limit(budget: f64) -> impl Drop {
        struct Limited;
        impl Drop for Limited {
            fn drop(&mut self) {
                LIMIT.set(super::BUDGET);
            }
        }
        LIMIT.set(budget);
        Limited
    }

    /// The work drawn since the last call (nominal µs).
    pub fn since_last() -> f64 {
        super::DRAWN.replace(0.0)
    }
}
