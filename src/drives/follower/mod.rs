//! What hangs on the shaft: the equations of motion, apart from every way to solve them.

pub mod elastic_output;
