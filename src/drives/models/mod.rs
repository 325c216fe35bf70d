//! The drive models: each a constructor of shaft, followers and solver, with its variables and its text.
//!
//! A model is one folder and two lines here, `pub mod` and its entry in [`MODELS`]; everything that an importer sees of
//! it (variables, units, dependencies, equations, documentation) comes from there.

pub mod backlash;
pub mod drive_train;
pub mod elastic_output;
pub mod elastic_shaft;
pub mod parametric;
pub mod rigid_machine;

use super::Model;

/// All drive models.
pub const MODELS: &[Model] = &[
    Model::of::<elastic_output::ElasticOutput>(),
    Model::of::<elastic_shaft::ElasticShaft>(),
    Model::of::<backlash::BacklashDrive>(),
    Model::of::<rigid_machine::RigidMachine>(),
    Model::of::<parametric::ParametricDrive>(),
    Model::of::<drive_train::DriveTrain>(),
];
