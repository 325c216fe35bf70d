//! Answers to questions of design that take runs of a drive: for now [`tradeoff`], speed against accuracy.

pub mod plot;
pub mod tradeoff;
