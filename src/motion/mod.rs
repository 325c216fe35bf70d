//! The cam as a function of its angle: the position function U(φ), 2π-periodic, and its derivatives.
//!
//! Knows no time, mass or stiffness. U is in m, U⁽ⁿ⁾ in m/radⁿ; φ in rad. Names after VDI 2143.

pub mod derivatives;
pub mod fourier;

pub use derivatives::{Kinematics, TransferFunctions};
pub use fourier::Fourier;

use serde::{Deserialize, Serialize};

/// A motion law.
///
/// Between neighbouring breakpoints U is smooth; on a breakpoint a derivative of order ≤ 4 may jump, and the
/// segment decides which one-sided value is meant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionLaw {
    /// A finite Fourier series (HS profile).
    Fourier(Fourier),
}

impl MotionLaw {
    /// U … U⁗ at the angle `phi` [rad], which lies in [−2π, 2π]; on a breakpoint the right-hand values.
    pub fn at(&self, phi: f64) -> TransferFunctions {
        self.at_in(self.segment(phi, true), phi)
    }

    /// The same, continued smoothly from segment `segment`, also a little outside of it.
    pub fn at_in(&self, _segment: usize, phi: f64) -> TransferFunctions {
        match self {
            MotionLaw::Fourier(series) => series.at(phi),
        }
    }

    /// The segment that holds `phi`; on a breakpoint the one that follows (`forward`) or precedes it.
    pub fn segment(&self, _phi: f64, _forward: bool) -> usize {
        0
    }

    /// The angles in [0, 2π), ascending, at which a derivative of order ≤ 4 jumps; segment i reaches from
    /// breakpoint i to breakpoint i + 1, the last one around the turn. Empty where U is smooth all around.
    pub fn breakpoints(&self) -> &[f64] {
        &[]
    }

    /// An upper bound of |U⁽ᵒʳᵈᵉʳ⁾| over the turn [m/radᵒʳᵈᵉʳ], order ≤ 4, for certified event location.
    pub fn bound(&self, order: usize) -> f64 {
        match self {
            MotionLaw::Fourier(series) => series.bound(order),
        }
    }

    /// The harmonic order that resolves the law: a polynomial of degree 16 over an angle of 2/K rad meets U to
    /// about 1e-16 of its amplitude within a segment.
    pub fn resolution(&self) -> f64 {
        match self {
            MotionLaw::Fourier(series) => series.order() as f64,
        }
    }

    /// The Fourier series where the law is one.
    pub fn series(&self) -> Option<&Fourier> {
        match self {
            MotionLaw::Fourier(series) => Some(series),
        }
    }
}
