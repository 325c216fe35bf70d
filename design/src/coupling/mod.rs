//! Systems of coupled FMUs.

pub mod exchange;
pub mod stability;
