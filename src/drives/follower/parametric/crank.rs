//! The stiffness of a parallel-crank drive.
//!
//! Two parallel shafts of torsional stiffness c_T1 and c_T2 carry cranks of length R, which a coupling rod of longitudinal
//! stiffness c_AB joins. Turned against each other by the small angle q, the cranks stretch the rod by R q sin φ, so the rod alone
//! has the torsional stiffness c_AB R² sin²φ, which is zero at the dead centres φ = 0 and π. In series with the shafts, 1/c₁₂ =
//! 1/c_T1 + 1/c_T2:
//!
//! c_T(φ) = c₁₂ S/(σ + S),  S = sin²φ,  σ = c₁₂/(c_AB R²).
//!
//! A second crank set that runs ahead by δ adds its own c_T(φ + δ) if it has its own shafts; on the same shafts its rod acts in
//! parallel with the first one, S = sin²φ + sin²(φ + δ) = 1 − cos δ cos(2φ + δ), which is constant for δ = 90°.
//!
//! Validity: |q| small against the angle over which sin φ changes, no play, massless rods.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.5.3 (1)–(3).

use crate::motion::Fourier;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// Angles this near to a quarter of a turn count as one (rad): the change is below rounding.
pub const SAME_ANGLE: f64 = 1e-15;

/// Shafts, cranks and coupling rods.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ParallelCrank {
    /// Torsional stiffness of the driving shaft c_T1 (N·m/rad).
    pub c_t1: f64,
    /// Torsional stiffness of the driven shaft c_T2 (N·m/rad).
    pub c_t2: f64,
    /// Longitudinal stiffness of a coupling rod c_AB (N/m).
    pub c_ab: f64,
    /// Length of the cranks R (m).
    pub r: f64,
    /// The second crank set.
    pub second: SecondCrank,
}

/// The second crank set, if any, and the angle δ (rad) by which it runs ahead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SecondCrank {
    /// A single crank.
    #[default]
    None,
    /// With shafts of its own, of the same stiffness.
    OwnShafts(f64),
    /// On the shafts of the first one.
    SharedShafts(f64),
}

/// A stiffness with dips, c(φ) = c₁₂ S/(σ + S), S = s₀ + s₂ sin²(φ − φ₀), s₂ ≥ 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dip {
    /// c₁₂ (N·m/rad).
    pub stiffness: f64,
    /// σ (1).
    pub sigma: f64,
    /// s₀ (1).
    pub least: f64,
    /// s₂ (1).
    pub swing: f64,
    /// φ₀ (rad): c is smallest there and half a turn on.
    pub centre: f64,
}

impl ParallelCrank {
    /// c₁₂ of the two shafts in series (N·m/rad).
    pub fn shafts(&self) -> f64 {
        self.c_t1 / (1.0 + self.c_t1 / self.c_t2)
    }

    /// σ = c₁₂/(c_AB R²) (1).
    pub fn sigma(&self) -> f64 {
        self.shafts() / (self.c_ab * self.r * self.r)
    }

    /// The terms whose sum is c_T(φ): two if a second crank set has its own shafts, else one.
    pub fn dips(&self) -> impl Iterator<Item = Dip> + use<> {
        let single = Dip { stiffness: self.shafts(), sigma: self.sigma(), least: 0.0, swing: 1.0, centre: 0.0 };
        let (first, second) = match self.second {
            SecondCrank::None => (single, None),
            SecondCrank::OwnShafts(angle) => (single, Some(Dip { centre: -angle, ..single })),
            SecondCrank::SharedShafts(angle) => {
                // 1 − cos δ cos(2φ + δ) = 1 − |cos δ| + 2 |cos δ| sin²(φ − φ₀).
                let cos = if (angle.abs() - FRAC_PI_2).abs() <= SAME_ANGLE { 0.0 } else { angle.cos() };
                let centre = if cos < 0.0 { 0.5 * (PI - angle) } else { -0.5 * angle };
                (Dip { least: 1.0 - cos.abs(), swing: 2.0 * cos.abs(), centre, ..single }, None)
            }
        };
        std::iter::once(first).chain(second)
    }
}

impl Dip {
    /// c, c′, c″, c‴ (N·m/radⁿ⁺¹) at `phi` (rad). It divides D = σ + S and its derivatives, so that no power of a small D occurs,
    /// without cancellation near the dead centres.
    pub fn at(&self, phi: f64) -> [f64; 4] {
        let (sin, cos) = (phi - self.centre).sin_cos();
        let s = self.least + self.swing * sin * sin;
        let d = self.sigma + s;
        let (first, second) = (2.0 * self.swing * sin * cos / d, 2.0 * self.swing * (cos - sin) * (cos + sin) / d);
        // D‴ = −4 D′.
        let third = -4.0 * first;
        let part = self.stiffness * self.sigma / d;
        [
            self.stiffness * (s / d),
            part * first,
            part * (second - 2.0 * first * first),
            part * (third - 6.0 * first * second + 6.0 * first * first * first),
        ]
    }

    /// ζ ∈ [0, 1), the ratio of the amplitudes of successive even harmonics. For a single crank ζ = (√(1 + σ) − √σ)².
    pub fn decay(&self) -> f64 {
        let least = self.sigma + self.least;
        self.swing / ((least + self.swing).sqrt() + least.sqrt()).powi(2)
    }

    /// The distance of the complex zeros of σ + S from the real axis (rad); infinite if c is constant.
    pub fn width(&self) -> f64 {
        -0.5 * self.decay().ln()
    }

    /// Adds the harmonics of c to `series`, up to its order: c₀ = c₁₂ (1 − ρ), c_2n = −2 c₁₂ ρ ζⁿ cos 2n(φ − φ₀) with
    /// ρ = σ/√((σ + s₀)(σ + s₀ + s₂)), from 1/(A − B cos x) = (1 + 2 Σ ζⁿ cos nx)/√(A² − B²).
    pub fn add_harmonics(&self, series: &mut Fourier) {
        let (sigma, least, swing) = (self.sigma, self.least, self.swing);
        let root = ((sigma + least) * (sigma + least + swing)).sqrt();
        // 1 − σ/root without cancellation for a soft rod.
        let mean = (sigma * (2.0 * least + swing) + least * (least + swing)) / (root * (root + sigma));
        series.a[0] += self.stiffness * mean;
        let mut amplitude = -2.0 * self.stiffness * sigma / root;
        for k in (2..=series.order()).step_by(2) {
            amplitude *= self.decay();
            let (sin, cos) = (k as f64 * self.centre).sin_cos();
            series.a[k] += amplitude * cos;
            series.b[k] += amplitude * sin;
        }
    }
}
