//! The command line of camdrive: a [`document`] holds a file, a [`scene`] a drive, a [`system`] connected drives, a [`study`] their
//! variants, a [`task`] a wanted motion; [`export`] packs FMUs, and each [`command`] has its own file.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod command;
pub mod document;
pub mod export;
pub mod scene;
pub mod study;
pub mod system;
pub mod task;
