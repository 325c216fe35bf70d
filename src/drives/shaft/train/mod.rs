//! Shaft and followers as one system.

use super::cam_drive::DriveMode;
use super::free::inertia::InertiaFunction;
use super::motor::Motor;
use crate::motion::MotionLaw;
use serde::{Deserialize, Serialize};

/// The shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shaft {
    /// Its motion is prescribed.
    Driven(DriveMode),
    /// It is free under its torques.
    Free(Machine),
}

/// A free shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// J0 and J_v.
    pub inertia: InertiaFunction,
    /// M_L(φ) (N·m) against the sense of φ.
    pub load: Option<MotionLaw>,
    /// b_L (N·m·s/rad).
    pub friction: Option<f64>,
    /// Whether there is an input `tau`.
    pub input: bool,
    /// The motor.
    pub motor: Motor,
    /// φ at the start (rad).
    pub phi_start: f64,
    /// φ̇ at the start (rad/s), except on a periodic motion.
    pub w_start: f64,
}
