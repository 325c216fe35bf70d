//! The train against its reference numbers: two independent programs, Taylor series of 170 bits and Lagrange multipliers in
//! redundant coordinates by extrapolation in 80 bits, agree on them.

mod jumps;
mod reference;
mod tuning;
