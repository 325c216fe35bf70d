//! The cam as a function of its angle: the position function U(φ), 2π-periodic, and its derivatives.
//!
//! Knows no time, mass or stiffness. U is in m, U⁽ⁿ⁾ in m/radⁿ; φ in rad. Names after VDI 2143.

pub mod cycle;
pub mod derivatives;
pub mod fourier;
pub mod parameters;
pub mod standard_laws;
pub mod table;
mod turn;

pub use cycle::{Cycle, CyclePlan};
pub use derivatives::{Kinematics, TransferFunctions};
pub use fourier::Fourier;
pub use standard_laws::StandardLaw;
pub use table::Table;

use serde::{Deserialize, Serialize};

/// A motion law.
///
/// Between neighbouring breakpoints U is analytic; on a breakpoint a derivative jumps, and the segment decides which
/// one-sided value is meant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionLaw {
    /// A finite Fourier series (HS profile).
    Fourier(Fourier),
    /// A dwell–rise–dwell–return cycle.
    Cycle(Cycle),
    /// A table of angles and lifts.
    Table(Table),
}

/// The bounds are enlarged by this part, more than the roundings of the bounds and of the values that they bound.
const BOUND_ROUNDING: f64 = 1e-12;

impl MotionLaw {
    /// U … U⁗ at the angle `phi` [rad], which lies in [−2π, 2π]; on a breakpoint the right-hand values.
    pub fn at(&self, phi: f64) -> TransferFunctions {
        self.at_in(self.segment(phi, true), phi)
    }

    /// The same, continued smoothly from segment `segment`, also a little outside of it.
    pub fn at_in(&self, segment: usize, phi: f64) -> TransferFunctions {
        match self {
            MotionLaw::Fourier(series) => series.at(phi),
            MotionLaw::Cycle(cycle) => cycle.at_in(segment, phi),
            MotionLaw::Table(table) => table.at_in(segment, phi),
        }
    }

    /// The segment that holds `phi`; on a breakpoint (within some roundings of the angle) the one that follows
    /// (`forward`) or precedes it.
    pub fn segment(&self, phi: f64, forward: bool) -> usize {
        match self {
            MotionLaw::Fourier(_) => 0,
            MotionLaw::Cycle(cycle) => cycle.segment(phi, forward),
            MotionLaw::Table(table) => table.segment(phi, forward),
        }
    }

    /// The angles in [0, 2π), ascending, at which a derivative jumps: in a cycle one of order ≤ 4, in a table that of
    /// order 5. Segment i reaches from breakpoint i to breakpoint i + 1, the last one around the turn. Empty where U
    /// is smooth all around.
    pub fn breakpoints(&self) -> &[f64] {
        match self {
            MotionLaw::Fourier(_) => &[],
            MotionLaw::Cycle(cycle) => cycle.breakpoints(),
            MotionLaw::Table(table) => table.breakpoints(),
        }
    }

    /// An upper bound of |U⁽ᵒʳᵈᵉʳ⁾| over the turn [m/radᵒʳᵈᵉʳ], order ≤ 4, for certified event location.
    pub fn bound(&self, order: usize) -> f64 {
        let bound = match self {
            MotionLaw::Fourier(series) => series.bound(order),
            MotionLaw::Cycle(cycle) => {
                (0..cycle.segments()).map(|segment| cycle.bound_in(segment, order)).fold(0.0, f64::max)
            }
            MotionLaw::Table(table) => table.bound(order),
        };
        bound * (1.0 + BOUND_ROUNDING)
    }

    /// The same within one segment; in a dwell the derivatives vanish.
    pub fn bound_in(&self, segment: usize, order: usize) -> f64 {
        let bound = match self {
            MotionLaw::Fourier(series) => series.bound(order),
            MotionLaw::Cycle(cycle) => cycle.bound_in(segment, order),
            MotionLaw::Table(table) => table.bound_in(segment, order),
        };
        bound * (1.0 + BOUND_ROUNDING)
    }

    /// The harmonic order that resolves the law: a polynomial of degree 16 over an angle of 2/K rad meets U to
    /// about 1e-16 of its amplitude within a segment.
    pub fn resolution(&self) -> f64 {
        match self {
            MotionLaw::Fourier(series) => series.order() as f64,
            MotionLaw::Cycle(cycle) => {
                (0..cycle.segments()).map(|segment| cycle.resolution_in(segment)).fold(1.0, f64::max)
            }
            // Each segment is a polynomial of degree 5 itself.
            MotionLaw::Table(_) => 1.0,
        }
    }

    /// The harmonic order that resolves one segment.
    pub fn resolution_in(&self, segment: usize) -> f64 {
        match self {
            MotionLaw::Cycle(cycle) => cycle.resolution_in(segment),
            _ => self.resolution(),
        }
    }

    /// The Fourier series where the law is one.
    pub fn series(&self) -> Option<&Fourier> {
        match self {
            MotionLaw::Fourier(series) => Some(series),
            _ => None,
        }
    }

    /// Whether the parameters, as a user may have set them, make a law; the message names quantity, value and range.
    pub fn validate(&self) -> Result<(), String> {
        let finite = (0..5).all(|order| self.bound(order).is_finite());
        match self {
            MotionLaw::Cycle(cycle) => cycle.plan().validate().map_err(|e| format!("the cam's plan: {e}"))?,
            MotionLaw::Fourier(_) if !finite => {
                return Err("the cam's Fourier coefficients must be finite and of at most 1e4 m".to_owned());
            }
            MotionLaw::Table(table) if !finite => {
                return Err(format!("cam.scale = {} makes the lifts of the table infinite", table.scale));
            }
            _ => {}
        }
        Ok(())
    }
}
