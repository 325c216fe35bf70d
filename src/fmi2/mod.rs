//! The FMI 2.0 Co-Simulation interface of the runtime library.
//!
//! An importer's call passes [`functions`] (C types, pointers, the only unsafe code of the library); [`call_sequence`] checks it
//! and [`instance`] carries it out.
//!
//! A refused call changes nothing, so the instance stays as usable as it was. Only a step that fails half-way puts it into the
//! error state, which [`call_sequence`] lets importers leave by `fmi2Reset` or `fmi2SetFMUstate`. Instances are independent, in any
//! threads; those of one FMU share what never changes ([`plans`]).

pub mod abi;
pub mod call_sequence;
#[allow(unsafe_code)]
pub mod functions;
pub mod instance;
pub mod log;
pub mod plans;
pub mod resource_location;
pub mod saved_state;
#[cfg(test)]
mod tests;
