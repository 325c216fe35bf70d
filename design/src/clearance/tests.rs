//! The formulas against printed and multiple-precision numbers, the model against the formulas where both hold and against
//! the known differences where they do not.

mod borders;
mod formulas;
mod laws;
mod model;
mod tuning;
