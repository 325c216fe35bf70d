//! Followers on the shaft: their equations of motion, apart from every way to solve them and from the shaft's motion.

pub(super) mod contact;
pub(super) mod elastic_output;
pub(super) mod elastic_shaft;
pub(super) mod equation;
pub(super) mod flank;
pub(super) mod flow;
pub mod joint;
pub mod linkage;
pub mod load;
pub(super) mod parametric;
pub mod place;
pub mod rigid;
