//! The drive on inputs: what they move when they are set, and the steps that follow them.

use super::ElasticOutput;
use crate::drives::Fault;
use crate::drives::cam_drive::{ShaftState, goes_on};
use crate::drives::instant::Instant;
use crate::motion::{MotionLaw, TransferFunctions};
use crate::numerics::pair::Pair;

impl ElasticOutput {
    /// A step on inputs.
    pub(super) fn advance_on_inputs(&mut self, [time, end]: [f64; 2]) -> Result<(), Fault> {
        let goes_on = self.take_up_inputs(time);
        self.cam.step_done();
        self.end = self.response.step(&self.cam.law, [time, end], self.now.q.array(), goes_on)?;
        self.arrive(self.end)
    }

    /// Takes up the motion that the inputs give at `time` (s); whether it goes on where the last step ended. Else the mass
    /// keeps position and velocity: q⁺ = q⁻ − Δx, q̇⁺ = q̇⁻ − Δẋ.
    pub(super) fn take_up_inputs(&mut self, time: f64) -> bool {
        let (motion, [before, speed, a, ..]) = (self.cam.motion(time), self.end.phi);
        let phi = std::array::from_fn(|order| motion.coefficients[order]);
        let goes_on = goes_on([before, speed, a], [phi[0], phi[1]], time);
        self.now = if goes_on {
            Instant { time, phi, ..self.end }
        } else {
            let (law, [before, after]) = (&self.cam.law, [self.end.phi, phi].map(ShaftState::at_angle));
            let [left, right] = [before, after].map(|shaft| shaft.on(law));
            let jump = jump(law, [(&before, &left), (&after, &right)]);
            Instant::new(time, &after, &right, (self.end.q - jump).array())
        };
        self.response.follow(motion);
        goes_on
    }
}

/// How far x and ẋ jump from one position of the cam to another.
fn jump(law: &MotionLaw, [(from, before), (to, after)]: [(&ShaftState, &TransferFunctions); 2]) -> Pair {
    let [d_phi, d_w] = [0, 1].map(|order| to.kinematics.0[order] - from.kinematics.0[order]);
    let [u, u1, u2, u3, u4] = before.0;
    // Within this angle the series of U up to U⁗ is right to (1e-3)⁵/5! = 1e-17 of the finest harmonic.
    let (du, du1) = if d_phi.abs() * law.resolution() < 1e-3 && law.breakpoints().is_empty() {
        let d = d_phi;
        (d * (u1 + d / 2.0 * (u2 + d / 3.0 * (u3 + d / 4.0 * u4))), d * (u2 + d / 2.0 * (u3 + d / 3.0 * u4)))
    } else {
        (after.0[0] - u, after.0[1] - u1)
    };
    Pair::new(du, after.0[1] * d_w + from.kinematics.0[1] * du1)
}
