//! The runtime library inside every FMU: the functions of FMI 2.0 that [`camdrive::fmi2`] defines, as a shared library.
//!
//! A package of its own, so that what is above the runtime is compiled while the runtime itself is still being optimised.
#![deny(unsafe_code)]
#![warn(missing_docs)]

pub use camdrive::fmi2;
