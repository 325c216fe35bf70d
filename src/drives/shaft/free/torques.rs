//! The torques on the shaft in the sense of rotation, as far as they do not depend on time.

use super::motor::{Kloss, Motor};
use serde::{Deserialize, Serialize};

/// N = σ(M_an − τ) as a function of |φ̇|, for torques that do not depend on time.
///
/// N = a s/(1 + s²) − d with s = (w_s − w)/(w_s s_K) for Kloss' motor, in the sense of rotation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Torques {
    /// σ.
    pub sense: f64,
    /// σ w_s (rad/s).
    synchronous: f64,
    /// 1/(σ w_s s_K) (s/rad).
    rate: f64,
    /// a = 2 M_K sgn(σ w_s) (N·m).
    amplitude: f64,
    /// d = σ(τ − M_an), with the part of M_an that does not depend on the speed (N·m).
    load: f64,
}

impl Torques {
    /// The torques of this motor against the load `tau` (N·m).
    pub fn against(motor: &Motor, tau: f64, sense: f64) -> Self {
        let still = Torques { sense, load: sense * tau, ..Torques::default() };
        match *motor {
            Motor::Kloss(Kloss { breakdown_torque, breakdown_slip, synchronous_speed, .. }) => Torques {
                synchronous: sense * synchronous_speed,
                rate: 1.0 / (sense * synchronous_speed * breakdown_slip),
                amplitude: 2.0 * breakdown_torque.copysign(sense * synchronous_speed),
                ..still
            },
            Motor::None | Motor::Input => still,
        }
    }

    /// The torques backwards in time: energies that rise ahead fall on the way back.
    pub fn backwards(&self) -> Self {
        Torques { sense: -self.sense, amplitude: -self.amplitude, load: -self.load, ..*self }
    }

    /// The load of these torques (N·m).
    pub fn against_what(&self) -> f64 {
        self.sense * self.load
    }

    /// Two energies between which the only fast periodic motion of a machine with `low` ≤ J ≤ `high` lies (see
    /// [`crate::drives::solver::free_shaft::steady`]); None if the characteristic does not fall at all speeds in question, or no
    /// speed balances the load.
    pub fn only_motion(&self, low: f64, high: f64) -> Option<(f64, f64)> {
        let balance = self.balance()?;
        let spread = (high / low).sqrt();
        let falls = |w: f64| ((self.synchronous - w) * self.rate).abs() < 1.0;
        let unique = falls(balance / spread) && falls(balance * spread);
        // Two per cent for the rounding of the bounds of J.
        unique.then_some((0.49 * low * balance * balance, 0.51 * high * balance * balance))
    }

    /// N (N·m) at the speed `w` ≥ 0.
    #[inline(always)]
    pub fn net(&self, w: f64) -> f64 {
        let s = (self.synchronous - w) * self.rate;
        self.amplitude * s / (1.0 + s * s) - self.load
    }

    /// The speed (rad/s) at which the motor and the load balance on the falling branch of the characteristic, if any.
    pub fn balance(&self) -> Option<f64> {
        // N(s) = 0 is d s² − a s + d = 0, solved in the form that keeps its digits for a small load d.
        let discriminant = self.amplitude * self.amplitude - 4.0 * self.load * self.load;
        let root = discriminant.max(0.0).sqrt();
        let slip = 2.0 * self.load / (self.amplitude + root.copysign(self.amplitude));
        let balance = self.synchronous - slip / self.rate;
        (discriminant > 0.0 && balance > 0.0).then_some(balance)
    }

    /// N and ∂N/∂E = N′(w) w/(2E).
    #[inline(always)]
    pub fn with_slope(&self, w: f64, energy: f64) -> [f64; 2] {
        let s = (self.synchronous - w) * self.rate;
        let n = 1.0 / (1.0 + s * s);
        let slope = -self.amplitude * self.rate * (1.0 - s * s) * n * n;
        [self.amplitude * s * n - self.load, slope * w / (2.0 * energy)]
    }
}
