//! Cam drives, drives with backlash and rigid machines: the runtime library of FMI 2.0 Co-Simulation FMUs.
//!
//! Read in this order:
//!
//! 1. [`motion`]: the cam as a function of its angle, U(φ) and its derivatives;
//! 2. [`numerics`]: mathematics only;
//! 3. [`drives`]: the equations of motion, one folder per model;
//! 4. [`fmi2`]: the C interface.
//!
//! The packages around it: `camdrive-design` in design/, studies that drive such FMUs; `camdrive-cli` in cli/, from a scene
//! file to an FMU.
#![deny(unsafe_code)]
#![warn(missing_docs)]

pub mod drives;
#[cfg(not(target_arch = "wasm32"))]
pub mod fmi2;
pub mod motion;
pub mod numerics;
