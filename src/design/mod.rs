//! Tools of design around the drives: [`compensation`], cams for a machine that fluctuates; [`tradeoff`], speed against
//! accuracy.

pub mod compensation;
pub mod plot;
pub mod tradeoff;
