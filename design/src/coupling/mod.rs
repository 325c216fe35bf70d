//! Systems of coupled FMUs.

pub mod exchange;
pub mod report;
pub mod stability;
pub mod study;
pub mod variables;
