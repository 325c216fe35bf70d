//! Cam drives, drives with backlash and rigid machines as FMI 2.0 Co-Simulation FMUs.
//!
//! Read in this order:
//!
//! 1. [`motion`]: the cam as a function of its angle, U(φ) and its derivatives;
//! 2. [`numerics`]: mathematics only;
//! 3. [`drives`]: the equations of motion, one folder per model;
//! 4. [`fmi2`]: the C interface of the FMU's runtime library;
//! 5. [`design`]: studies that drive FMUs, such as speed against accuracy;
//! 6. [`scene`], [`export`], [`cli`]: from a scene file to an FMU.
#![deny(unsafe_code)]
#![warn(missing_docs)]

#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "cli")]
pub mod design;
pub mod drives;
#[cfg(feature = "cli")]
pub mod export;
pub mod fmi2;
pub mod motion;
pub mod numerics;
#[cfg(feature = "cli")]
pub mod scene;
