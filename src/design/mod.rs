//! Tools of design around the drives: [`compensation`], cams for a machine that fluctuates; [`stability`], at which speeds
//! varying parameters make a drive vibrate; [`tradeoff`], speed against accuracy.

pub mod compensation;
pub mod plot;
pub mod stability;
pub mod tradeoff;
