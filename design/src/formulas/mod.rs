//! Closed formulas as the literature prints them, with their misprints corrected: approximations that a study compares with its
//! own values. No result depends on them.

pub mod dwells;
pub mod instability;
pub mod passage;
