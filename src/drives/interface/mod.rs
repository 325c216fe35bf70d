//! The interface of a drive to `fmi2` and the exporter; no physics.

mod any;
pub mod curve;
mod drive;
pub mod event;
mod experiment;
mod fault;
pub mod limits;
mod model;
pub mod parameter;
pub mod resource;
pub mod settings;
mod text;
pub mod unit;
pub mod variable;

pub use crate::numerics::number::{Number, Rounded};
pub use any::{AnyDrive, Plan, Snapshot};
pub use curve::Curve;
pub use drive::{Drive, Seed};
pub use event::{About, Event, EventLog};
pub use experiment::Experiment;
pub use fault::Fault;
pub use model::Model;
pub use text::Text;
pub use variable::{Description, List, Variable};
