//! The command line of camdrive: [`scene`] files are read, [`export`] packs FMUs, each [`command`] has its file.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

pub mod command;
pub mod export;
pub mod scene;
