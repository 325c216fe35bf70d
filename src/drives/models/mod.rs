//! The drive models: each a constructor of shaft, followers and solver, with its variables and its text.
//!
//! A model is one folder and two lines here, `pub mod` and its name in `models!`; it provides everything that an importer sees
//! (variables, units, dependencies, equations, documentation).

pub mod backlash;
pub mod drive_train;
pub mod elastic_output;
pub mod elastic_shaft;
pub mod parametric;
pub mod rigid_machine;

use super::{AnyDrive, Model};

macro_rules! models {
    ($($drive:ty),* $(,)?) => {
        /// All drive models.
        pub const MODELS: &[Model] = &[$(Model::of::<$drive>()),*];

        // Compiled here, so that dependent crates need not compile every drive again.
        $(impl From<$drive> for AnyDrive {
            fn from(drive: $drive) -> Self {
                AnyDrive::new(drive)
            }
        })*
    };
}

models!(
    elastic_output::ElasticOutput,
    elastic_shaft::ElasticShaft,
    backlash::BacklashDrive,
    rigid_machine::RigidMachine,
    parametric::ParametricDrive,
    drive_train::DriveTrain,
);
