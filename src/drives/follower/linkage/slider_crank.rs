//! The slider-crank.

use super::{Branch, Link, Links};
use crate::numerics::taylor::Series;
use serde::{Deserialize, Serialize};

/// A slider-crank: crank r at the angle θ about (0, 0), connecting rod l to a slider on the line y = e.
///
/// s = r cos θ ± √(l² − h²), h = r sin θ − e; lengths in m, θ in rad, s in m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SliderCrank {
    /// r; its first joint is the pivot.
    pub crank: Link,
    /// l; its first joint is the joint with the crank.
    pub rod: Link,
    /// e, the offset of the slider's line.
    pub offset: f64,
    /// The slider without the tool (kg).
    pub slider_mass: f64,
    /// The sign in s.
    pub branch: Branch,
}

impl SliderCrank {
    /// h/l, the sine of the rod's angle to the slider's line; beyond ±1 the rod does not reach it.
    pub(super) fn rod_sine(&self, theta: f64) -> f64 {
        (self.crank.length * theta.sin() - self.offset) / self.rod.length
    }

    /// s, and the links.
    pub(super) fn moved<const N: usize>(&self, theta: Series<N>) -> (Series<N>, Links<N>) {
        let (r, l) = (self.crank.length, self.rod.length);
        let (sin, cos) = theta.sin_cos();
        let h = sin * r + -self.offset;
        let along = ((h + l) * (h * -1.0 + l)).sqrt() * self.branch.sign();
        let s = cos * r + along;
        let slope = s.slope();
        let zero = Series::from(0.0);
        let mut links = Links::none().with(&self.crank, [zero, zero], [cos, sin]).with(
            &self.rod,
            [cos * r, sin * r],
            [along * (1.0 / l), h * (-1.0 / l)],
        );
        links.inertia = links.inertia + slope * slope * self.slider_mass;
        links.moment[0] = links.moment[0] + s * self.slider_mass;
        (s, links)
    }
}
