//! Mathematics only: no word of cams, no word of FMI.

pub mod angle;
pub mod chebyshev;
pub mod collocation;
pub mod count;
pub mod difference;
pub mod divisor;
pub mod double_double;
pub mod first_root;
pub mod forced;
pub mod gauss;
pub mod interpolant;
pub mod lu;
pub mod number;
pub mod oscillator;
pub mod pair;
pub mod period_map;
pub mod phase;
pub mod powers;
pub mod program;
pub mod tape;
pub mod taylor;
pub mod work;
