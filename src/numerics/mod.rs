//! Mathematics only: no word of cams, no word of FMI.

pub mod angle;
pub mod double_double;
pub mod taylor;
