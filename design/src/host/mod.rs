//! A host of FMUs: it drives an instance as an importer does and is safe to use.
//!
//! An [`Fmu`] comes from a file, whose library is loaded into this process, or from a [`crate::resource::Resource`], whose
//! library is the one in this tool. Both give instances of one kind, [`Host`]. The studies of [`crate`] measure through it what
//! an importer will get.

#[allow(unsafe_code)]
mod callbacks;
mod description;
mod fmu;
#[allow(unsafe_code)]
mod functions;
#[allow(unsafe_code)]
mod instance;

pub use description::{Capabilities, Experiment, ModelDescription, Unit, Variable};
pub use fmu::{Fmu, MODEL, REFERENCES, platforms, unpacked};
pub use instance::Host;
