//! The drive models: each a constructor of shaft, followers and solver, with its variables and its text.
//!
//! A model is one folder and two lines here, `pub mod` and its entry in `all_drives!`; everything that an importer sees of
//! it (variables, units, dependencies, equations, documentation) comes from there.

pub mod backlash;
pub mod drive_train;
pub mod elastic_output;
pub mod elastic_shaft;
pub mod parametric;
pub mod rigid_machine;

use super::Model;

/// The one list of the drive models: an array of `$entry::of::<D>()` for every model D.
#[macro_export]
macro_rules! all_drives {
    ($entry:ty) => {
        &[
            <$entry>::of::<$crate::drives::models::elastic_output::ElasticOutput>(),
            <$entry>::of::<$crate::drives::models::elastic_shaft::ElasticShaft>(),
            <$entry>::of::<$crate::drives::models::backlash::BacklashDrive>(),
            <$entry>::of::<$crate::drives::models::rigid_machine::RigidMachine>(),
            <$entry>::of::<$crate::drives::models::parametric::ParametricDrive>(),
            <$entry>::of::<$crate::drives::models::drive_train::DriveTrain>(),
        ]
    };
}

/// All drive models.
pub const MODELS: &[Model] = all_drives!(Model);
