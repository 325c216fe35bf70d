//! The command line of camdrive: a [`document`] is what a file holds, a [`scene`] a drive, a [`system`] drives with their
//! connections, a [`study`] their variants, a [`task`] a motion to be found; [`export`] packs FMUs, each [`command`] has its file.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod command;
pub mod document;
pub mod export;
pub mod scene;
pub mod study;
pub mod system;
pub mod task;
