//! Solvers that move shaft and followers from one event to the next. They know equations and no drive.

pub(super) mod contact;
pub mod free_shaft;
pub(super) mod oscillation;
pub(super) mod response;
pub(super) mod step_control;
pub(super) mod train;
