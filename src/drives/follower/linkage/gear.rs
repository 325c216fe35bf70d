//! Gear pairs and other mechanisms of constant ratio.

use super::Links;
use crate::numerics::taylor::Series;
use serde::{Deserialize, Serialize};

/// A gear pair or a belt, ψ = i θ, or rack and pinion, s = i θ with i the radius of the pinion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Gear {
    /// i (1 or m/rad), not zero; negative where output and input run against each other.
    pub ratio: f64,
    /// The moment of inertia of all parts that turn with the input (kg·m²); parts that move with the output belong to the tool or
    /// the next mechanism.
    pub inertia: f64,
    /// Whether the output is an angle.
    pub output_turns: bool,
}

impl Gear {
    pub(super) fn moved<const N: usize>(&self, theta: Series<N>) -> (Series<N>, Links<N>) {
        let slope = theta.slope();
        (theta * self.ratio, Links { inertia: slope * slope * self.inertia, ..Links::none() })
    }
}
