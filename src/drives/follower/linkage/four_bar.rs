//! The four-bar linkage.

use super::{Branch, Link, Links, arccos};
use crate::numerics::taylor::Series;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A four-bar linkage: input link a at the angle θ about (0, 0), output link c at ψ about (g, 0), coupler b between their
/// ends.
///
/// |g + c e^{iψ} − a e^{iθ}| = b, that is F = c g cos ψ − a g cos θ − a c cos(θ − ψ) + (g² + a² + c² − b²)/2 = 0,
/// ψ = arg d ± arccos((b² − c² − |d|²)/(2 c |d|)), d = g − a e^{iθ}.
///
/// Lengths in m, angles in rad. ψ is continuous in θ; for a ≥ g it turns with it, and arg d is the principal value for
/// 0 < θ < 2π. The derivatives follow from F = 0, one order after the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FourBar {
    /// g, the distance of the pivots.
    pub ground: f64,
    /// a; its first joint is the pivot (0, 0).
    pub input: Link,
    /// b; its first joint is the joint with the input link.
    pub coupler: Link,
    /// c; its first joint is the pivot (g, 0).
    pub output: Link,
    /// The sign in ψ.
    pub branch: Branch,
}

impl FourBar {
    /// arg d and |d|.
    pub fn diagonal(&self, theta: f64) -> (f64, f64) {
        let (g, a) = (self.ground, self.input.length);
        let (sin, cos) = theta.sin_cos();
        let (x, y) = (g - a * cos, -a * sin);
        // d = −a e^{iθ} (1 − (g/a) e^{−iθ}); the argument of the second factor stays within ±π/2.
        let angle = if a < g { y.atan2(x) } else { theta - PI + (g * sin).atan2(a - g * cos) };
        (angle, (x * x + y * y).sqrt())
    }

    /// ψ (rad); None where the links cannot be assembled.
    pub fn position(&self, theta: f64) -> Option<f64> {
        let (b, c) = (self.coupler.length, self.output.length);
        let (angle, d) = self.diagonal(theta);
        Some(angle + self.branch.sign() * arccos((b * b - c * c - d * d) / (2.0 * c * d))?)
    }

    /// cos μ, μ the transmission angle between coupler and output link; beyond ±1 they do not reach each other.
    pub(super) fn transmission_cosine(&self, theta: f64) -> f64 {
        let (b, c) = (self.coupler.length, self.output.length);
        let (_, d) = self.diagonal(theta);
        (b * b + c * c - d * d) / (2.0 * b * c)
    }

    /// ψ, and the links.
    pub(super) fn moved<const N: usize>(&self, theta: Series<N>) -> (Series<N>, Links<N>) {
        let (g, a, b, c) = (self.ground, self.input.length, self.coupler.length, self.output.length);
        let mut psi = Series::from(self.position(theta.value()).unwrap_or(f64::NAN));
        let (st, ct) = theta.sin_cos();
        let (mut sp, mut cp) = psi.sin_cos();
        let slope = -c * (g * sp.value() + a * (theta.value() - psi.value()).sin());
        for _ in 1..N {
            // The error of F is right in the first order of the error of ψ.
            let miss = (cp * g - (ct * cp + st * sp) * a) * c - ct * (a * g);
            for n in 1..N {
                psi.0[n] -= miss.0[n] / slope;
            }
            (sp, cp) = psi.sin_cos();
        }
        let zero = Series::from(0.0);
        let pin = [ct * a, st * a];
        let coupler = [((cp * c + g) - pin[0]) * (1.0 / b), (sp * c - pin[1]) * (1.0 / b)];
        let links = Links::none().with(&self.input, [zero, zero], [ct, st]).with(&self.coupler, pin, coupler).with(
            &self.output,
            [Series::from(g), zero],
            [cp, sp],
        );
        (psi, links)
    }
}
