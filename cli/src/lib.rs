//! The command line of camdrive: a [`document`] holds a file, a [`scene`] a drive, a [`system`] connected drives, a [`study`] their
//! variants, a [`task`] a wanted motion; [`export`] packs FMUs, and each [`command`] has its own file.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

#[cfg(not(target_arch = "wasm32"))]
pub mod command;
pub mod document;
#[cfg(not(target_arch = "wasm32"))]
pub mod export;
pub mod live;
pub mod scene;
#[cfg(not(target_arch = "wasm32"))]
pub mod study;
#[cfg(not(target_arch = "wasm32"))]
pub mod system;
#[cfg(not(target_arch = "wasm32"))]
pub mod task;
