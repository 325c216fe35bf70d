//! Mathematics only: no word of cams, no word of FMI.

pub mod angle;
pub mod collocation;
pub mod double_double;
pub mod gauss;
pub mod lu;
pub mod taylor;
