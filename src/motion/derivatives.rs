//! Derivatives with respect to the angle and to time, and the chain rule between them.

use crate::numerics::taylor::Scalar;
use serde::{Deserialize, Serialize};

/// The transfer functions of order 0 to 4 (VDI 2143) at one angle: U⁽ⁿ⁾ = dⁿU/dφⁿ (m/radⁿ).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TransferFunctions(pub [f64; 5]);

/// A quantity and its time derivatives of order 1 to 4: x (·), ẋ (·/s), ẍ (·/s²), x⃛ (·/s³), x⁗ (·/s⁴).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Kinematics(pub [f64; 5]);

impl TransferFunctions {
    /// x(t) = U(φ(t)) and its time derivatives by Faà di Bruno's rule.
    pub fn along(&self, phi: &Kinematics) -> Kinematics {
        let [u, u1, u2, u3, u4] = self.0;
        let [_, w, a, j, s] = phi.0;
        let w2 = w * w;
        Kinematics([
            u,
            u1 * w,
            u2 * w2 + u1 * a,
            u3 * w2 * w + 3.0 * u2 * w * a + u1 * j,
            u4 * w2 * w2 + 6.0 * u3 * w2 * a + u2 * (3.0 * a * a + 4.0 * w * j) + u1 * s,
        ])
    }
}

/// x = U(φ), ẋ and ẍ of numbers or of series; `u` holds U, U′, U″, and `w`, `a` the speed and the acceleration.
#[inline(always)]
pub fn lift<S: Scalar>([u, slope, curvature]: [S; 3], [w, a]: [S; 2]) -> [S; 3] {
    [u, slope * w, curvature * w * w + slope * a]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chain_rule_for_a_sine_of_a_cubic() {
        // x = sin φ, φ = t³/6 at t = 1.3; the derivatives of sin(t³/6) by hand.
        let t: f64 = 1.3;
        let phi = Kinematics([t.powi(3) / 6.0, t * t / 2.0, t, 1.0, 0.0]);
        let (s, c) = phi.0[0].sin_cos();
        let x = TransferFunctions([s, c, -s, -c, s]).along(&phi);
        let (w, a) = (t * t / 2.0, t);
        let expected = [
            s,
            c * w,
            -s * w * w + c * a,
            -c * w.powi(3) - 3.0 * s * w * a + c,
            s * w.powi(4) - 6.0 * c * w * w * a - s * (3.0 * a * a + 4.0 * w),
        ];
        for n in 0..5 {
            assert!((x.0[n] - expected[n]).abs() < 1e-15, "order {n}");
        }
    }
}
