//! The runtime library inside every FMU: the functions of FMI 2.0 that [`camdrive::fmi2`] defines, as a shared library.
//!
//! It is a package of its own, so that Cargo compiles the packages above the runtime while it still optimises the runtime.
#![deny(unsafe_code)]
#![warn(missing_docs)]

pub use camdrive::fmi2;
