//! Closed formulas as the literature prints them, with their misprints corrected: approximations that a study shows beside its own
//! values. None of them decides anything.

pub mod dwells;
pub mod instability;
pub mod passage;
