//! Systems of coupled FMUs.

pub mod exchange;
mod report;
pub mod stability;
pub mod study;
pub mod variables;
