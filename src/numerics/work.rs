//! The work of a call, counted: loops whose count depends on values draw upon one budget, so that every call ends.
//!
//! What operations take is stated in nominal microseconds, measured on a processor core of 3 GHz. They are counted, not timed:
//! whether a call ends well must not depend on the machine.

use std::cell::Cell;

/// The work that a call may take (nominal µs): a second where a nominal microsecond takes two and a half, as on a shared server
/// at 2.5 GHz. A simulator that waits longer seems to hang, and no sensible communication step needs more: ten thousand turns of
/// a drive of few harmonics fit in.
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

/// A moment in this thread, from which what makes several starts of a drive counts the work of all of them.
#[derive(Clone, Copy, Debug)]
pub struct Since(f64);

impl Since {
    /// This moment.
    pub fn now() -> Self {
        Since(DRAWN.get())
    }

    /// What was drawn or noted since (nominal µs).
    pub fn drawn(self) -> f64 {
        DRAWN.get() - self.0
    }

    /// Whether more was drawn or noted since than a call of several starts may take: a fifth more than another call, with which a
    /// machine of several tools behind mechanisms still does.
    pub fn is_exhausted(self) -> bool {
        self.drawn() > 1.2 * budget()
    }
}

/// Counts work that needs no budget, since the scene alone tells how much it is (nominal µs).
pub fn note(cost: f64) {
    DRAWN.set(DRAWN.get() + cost);
}

impl Default for Work {
    /// That of a call which has not begun yet.
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
        // A comparison with NaN is false.
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

/// Draws upon work that several share, where it is bounded; None where it is used up.
pub fn draw(shared: Option<&Cell<Work>>, cost: f64) -> Option<()> {
    let Some(shared) = shared else { return Some(()) };
    let mut left = shared.get();
    let drawn = left.draw(cost);
    shared.set(left);
    drawn.ok()
}

/// Tests ask what was drawn, and make do with less. It is always here, so that one build serves tools and tests.
pub mod drawn {
    use std::cell::Cell;

    thread_local! {
        static LIMIT: Cell<f64> = const { Cell::new(super::BUDGET) };
    }

    /// The budget of a call in this thread.
    pub fn limited() -> f64 {
        LIMIT.get()
    }

    /// Makes do with this budget until it is dropped, so that what takes all of it takes no time.
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

    /// All that was drawn since this was last asked (nominal µs).
    pub fn since_last() -> f64 {
        super::DRAWN.replace(0.0)
    }
}
