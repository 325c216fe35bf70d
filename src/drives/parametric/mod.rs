//! A drive with one degree of freedom and periodic coefficients, m(φ) q̈ + b(φ) q̇ + c(φ) q = f(φ).

pub mod coefficients;
pub mod crank;
