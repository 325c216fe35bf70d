//! The motion of the shaft: φ(t) prescribed by a constant speed or by inputs, or free under its torques. No solvers.

pub(super) mod angle_series;
pub mod cam_drive;
pub mod cam_turn;
mod consistency;
pub(super) mod flank;
pub mod free;
pub mod instant;
pub mod laws;
pub mod loads;
pub mod motor;
pub(super) mod passage;
pub mod train;
