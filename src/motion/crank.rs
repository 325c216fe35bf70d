//! A mechanism on the shaft itself: its input link turns with the shaft.

use super::TransferFunctions;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// U = φ + φ₀ (rad), the one law that is not periodic: only mechanisms with a periodic output may follow it
/// ([`crate::drives::follower::linkage`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Crank {
    /// φ₀ (rad): the angle of the input link at the shaft angle 0.
    pub offset: f64,
}

impl Crank {
    /// U … U⁗ at `phi`.
    pub fn at(&self, phi: f64) -> TransferFunctions {
        TransferFunctions([phi + self.offset, 1.0, 0.0, 0.0, 0.0])
    }

    /// The Taylor coefficients about `phi`; see [`super::MotionLaw::expand`].
    pub fn expand(&self, phi: f64, step: f64, coefficients: &mut [f64]) {
        coefficients.fill(0.0);
        (coefficients[0], coefficients[1]) = (phi + self.offset, step);
    }

    /// An upper bound of |U⁽ᵒʳᵈᵉʳ⁾| over the angles of [`super::MotionLaw::at`].
    pub fn bound(&self, order: usize) -> f64 {
        match order {
            0 => TAU + self.offset.abs(),
            1 => 1.0,
            _ => 0.0,
        }
    }
}
