//! Shaft, cam and mass at an instant.

use super::cam_drive::AngleMotion;
use crate::motion::{MotionLaw, TransferFunctions};
use crate::numerics::pair::Pair;
use serde::{Deserialize, Serialize};

/// Shaft, cam and mass at an instant; at a jump on one side of it.
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
    /// The mass at q, q̇ with these φ, ω, α of the shaft and these transfer functions of the cam.
    pub fn new(time: f64, shaft: [f64; 3], u: &TransferFunctions, q: Pair) -> Self {
        let [u, slope, curvature, ..] = u.0;
        Instant { time, shaft, u: Pair::new(u, slope), curvature, q }
    }

    /// The mass at q, q̇ on a cam of this law with this motion.
    pub fn on(motion: &AngleMotion, law: &MotionLaw, time: f64, q: [f64; 2]) -> Self {
        let shaft = motion.at(time);
        let [phi, w, a, ..] = shaft.kinematics.0;
        Instant::new(time, [phi, w, a], &shaft.on(law), q.into())
    }

    /// Whether cam and mass are finite, given a shaft that is.
    #[inline(always)]
    pub fn is_finite(&self) -> bool {
        // A finite sum has finite terms.
        let [places, rates] = (self.u + self.q).array();
        (places + rates).is_finite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Fourier;

    #[test]
    fn shaft_and_cam_are_those_of_the_motion_and_the_law() {
        // U = 2 mm sin φ at φ = 0.25 + 20 · 0.1.
        let law = MotionLaw::Fourier(Fourier::new(vec![], vec![0.0, 2e-3]));
        let now = Instant::on(&AngleMotion::uniform(0.0, 0.25, 20.0), &law, 0.1, [3.0, -4.0]);
        assert_eq!((now.time, now.shaft[1..].to_vec(), now.q.array()), (0.1, vec![20.0, 0.0], [3.0, -4.0]));
        let ([u, slope], (s, c)) = (now.u.array(), 2.25_f64.sin_cos());
        assert!((now.shaft[0] - 2.25).abs() < 1e-15);
        assert!((u - 2e-3 * s).abs() + (slope - 2e-3 * c).abs() + (now.curvature + 2e-3 * s).abs() < 1e-17);
    }

    #[test]
    fn one_number_that_is_lost_is_noticed() {
        let at = |[u, slope, q, v]: [f64; 4]| Instant { u: [u, slope].into(), q: [q, v].into(), ..Instant::default() };
        assert!(at([1e200; 4]).is_finite() && at([0.0; 4]).is_finite());
        for i in 0..4 {
            for lost in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let mut numbers = [1.0; 4];
                numbers[i] = lost;
                assert!(!at(numbers).is_finite(), "{numbers:?}");
            }
        }
        // The place of the mass, x + q, overflows.
        assert!(!at([f64::MAX, 0.0, f64::MAX, 0.0]).is_finite());
    }
}
