//! The drive models: equation, parameters, variables, solver.
//!
//! A model is one folder and two lines here, `pub mod` and its entry in `all_drives!`; everything that an importer sees of
//! it (variables, units, dependencies, equations, documentation) comes from there.

pub mod backlash;
pub mod cam_drive;
pub mod cam_turn;
mod course;
pub mod elastic_output;
pub mod elastic_shaft;
pub mod flow;
pub mod follower;
pub mod instant;
pub mod interface;
pub mod oscillation;
pub mod parametric;
mod passage;
pub mod response;
pub mod rigid_machine;
mod step_control;

pub use interface::*;

/// The one list of the drive models: an array of `$entry::of::<D>()` for every model D.
#[macro_export]
macro_rules! all_drives {
    ($entry:ty) => {
        &[
            <$entry>::of::<$crate::drives::elastic_output::ElasticOutput>(),
            <$entry>::of::<$crate::drives::elastic_shaft::ElasticShaft>(),
            <$entry>::of::<$crate::drives::backlash::BacklashDrive>(),
            <$entry>::of::<$crate::drives::rigid_machine::RigidMachine>(),
            <$entry>::of::<$crate::drives::parametric::ParametricDrive>(),
        ]
    };
}

/// All drive models.
pub const MODELS: &[Model] = all_drives!(Model);
