//! Shaft, cam and mass at an instant.

use super::cam_drive::AngleMotion;
use crate::motion::{MotionLaw, TransferFunctions};
use crate::numerics::pair::Pair;
use serde::{Deserialize, Serialize};

/// Shaft, cam and mass at an instant; where something jumps there, on one side of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Instant {
    /// t (s).
    pub time: f64,
    /// φ (rad), ω (rad/s), α (rad/s²).
    pub shaft: [f64; 3],
    /// U (m) and U′ (m/rad).
    pub u: Pair,
    /// U″ (m/rad²).
    pub curvature: f64,
    /// q (m) and q̇ (m/s).
    pub q: Pair,
}

impl Instant {
    /// The mass at q, q̇ where the shaft has these φ, ω, α and the cam these transfer functions.
    pub fn new(time: f64, shaft: [f64; 3], u: &TransferFunctions, q: Pair) -> Self {
        let [u, slope, curvature, ..] = u.0;
        Instant { time, shaft, u: Pair::new(u, slope), curvature, q }
    }

    /// The mass at q, q̇ where a cam of this law moves like this.
    pub fn on(motion: &AngleMotion, law: &MotionLaw, time: f64, q: [f64; 2]) -> Self {
        let shaft = motion.at(time);
        let [phi, w, a, ..] = shaft.kinematics.0;
        Instant::new(time, [phi, w, a], &shaft.on(law), q.into())
    }

    /// Whether cam and mass are within the range of numbers, on a shaft that is.
    #[inline(always)]
    pub fn is_finite(&self) -> bool {
        // A sum that is finite has finite terms.
        let [places, rates] = (self.u + self.q).array();
        (places + rates).is_finite()
    }
}
