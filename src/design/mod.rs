//! Tools of design around the drives: [`clearance`], what backlash does to a motion law; [`compensation`], cams for a
//! machine that fluctuates; [`stability`], at which speeds varying parameters make a drive vibrate; [`tradeoff`], speed
//! against accuracy.

pub mod clearance;
pub mod compensation;
pub mod plot;
pub mod stability;
pub mod tradeoff;
