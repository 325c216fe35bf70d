//! The balance of energy of the drive at constant speed: d/dt [½ m ẏ² + ½ c q²] = tau ω − b q̇².
//!
//! The motion is known at any instant of the present course, so that the balance is struck when somebody asks for it, and costs
//! nothing else. On inputs a communication step is one quadrature from state to state: there is no motion in between
//! whose power could be integrated.

use super::{ElasticOutput, Position};
use crate::drives::cam_drive::HasCamDrive;
use crate::drives::energy::{self, Balanced};

impl ElasticOutput {
    /// |ΔE − ∫(tau ω − b q̇²) dt| over the last waves of the motion, relative to the largest E among them.
    pub(super) fn energy_residual(&self) -> f64 {
        let law = &self.cam().law;
        let (_, vibration) = self.oscillator().rates();
        let rate = vibration.max(law.resolution() * self.now.w.abs());
        energy::residual_at_last([self.response.known_from(), self.now.time], rate, |time| {
            self.balanced(Position::of(law, self.response.motion(), time), self.response.again(time))
        })
    }

    /// E, the power of drive and damper and its rate where the cam is at `position` and the mass at `q`.
    fn balanced(&self, position: Position, [q, v]: [f64; 2]) -> Balanced {
        let &ElasticOutput { m, c, b, .. } = self;
        let [_, lift_speed, lift_acceleration, ..] = position.lift().0;
        let force = -(c * q + b * v);
        let acceleration = force / m - lift_acceleration;
        let force_rate = -(c * v + b * acceleration);
        Balanced {
            energy: 0.5 * (m * (lift_speed + v).powi(2) + c * q * q),
            power: force * lift_speed - b * v * v,
            power_rate: force_rate * lift_speed + force * lift_acceleration - 2.0 * b * v * acceleration,
        }
    }
}
