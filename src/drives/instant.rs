//! Shaft, cam and mass at an instant.

use super::cam_drive::ShaftState;
use crate::motion::TransferFunctions;
use crate::motion::derivatives::lift;
use crate::numerics::pair::Pair;
use serde::{Deserialize, Serialize};

/// Shaft, cam and mass at an instant; where something jumps there, on one side of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Instant {
    /// t (s).
    pub time: f64,
    /// φ (rad) and its time derivatives.
    pub phi: [f64; 5],
    /// U (m) and U′ (m/rad).
    pub u: Pair,
    /// U″ (m/rad²).
    pub curvature: f64,
    /// q (m) and q̇ (m/s).
    pub q: Pair,
}

impl Instant {
    /// The mass at q, q̇ where the shaft and the transfer functions of the cam are these.
    pub fn new(time: f64, shaft: &ShaftState, u: &TransferFunctions, q: [f64; 2]) -> Self {
        let [u, slope, curvature, ..] = u.0;
        Instant { time, phi: shaft.kinematics.0, u: Pair::new(u, slope), curvature, q: q.into() }
    }

    /// Whether cam and mass move within the range of numbers.
    #[inline(always)]
    pub fn is_finite(&self) -> bool {
        let ([u, slope], [_, w, a, ..], [q, v]) = (self.u.array(), self.phi, self.q.array());
        let [x, x1, x2] = lift([u, slope, self.curvature], [w, a]);
        // A sum that is finite has finite terms.
        (x + x1 + x2 + q + v).is_finite()
    }
}
