//! The drive train: a shaft with its motor, or a prescribed motion, and all that hangs on it, as one system.

pub use crate::drives::follower::member::{Follower, Joint};
pub use crate::drives::shaft::train::{Machine, Shaft};

use crate::drives::settings::Settings;
use serde::{Deserialize, Serialize};

/// The most followers.
pub const MOST_FOLLOWERS: usize = 16;

/// The train as a scene describes it; coherent SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// What moves the shaft.
    pub shaft: Shaft,
    /// j counts from 1 in the variable names.
    pub followers: Vec<Follower>,
    /// How they begin.
    pub start: Start,
    /// `solver.tolerance`; the method is the adaptive one.
    pub solver: Settings,
}

/// How the followers begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// q = q̇ = 0, contact.
    #[default]
    AtRest,
    /// Where the loads balance the springs.
    Equilibrium,
    /// On the periodic motion.
    SteadyState,
}
