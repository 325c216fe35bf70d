//! The drive on inputs: the effects of setting them, and the steps that follow them.

use super::ElasticOutput;
use crate::drives::Fault;
use crate::drives::shaft::cam_drive::{ShaftState, goes_on};
use crate::drives::shaft::instant::Instant;
use crate::motion::{MotionLaw, TransferFunctions};
use crate::numerics::pair::Pair;

impl ElasticOutput {
    /// A step on inputs.
    pub(super) fn advance_on_inputs(&mut self, [time, end]: [f64; 2]) -> Result<(), Fault> {
        let goes_on = self.taken_up.take().unwrap_or_else(|| self.take_up_inputs(time));
        if !goes_on {
            let [phi, w, _] = self.end.shaft;
            self.cam.jumps([phi, w], time, &mut self.log);
        }
        self.cam.step_done(&self.response.motion, end);
        self.response.step(&self.cam.law, end, goes_on, &mut self.now)?;
        self.end = self.now;
        if self.loaded.is_some() {
            self.advance_loads([time, end], goes_on)?;
        }
        self.arrived()
    }

    /// Takes up the motion of the inputs at `time` (s); returns whether it goes on from the end of the last step. If not, the mass
    /// keeps position and velocity: q⁺ = q⁻ − Δx, q̇⁺ = q̇⁻ − Δẋ.
    pub(super) fn take_up_inputs(&mut self, time: f64) -> bool {
        let motion = self.cam.motion(time);
        let ([phi, w, a, ..], law) = (motion.coefficients, &self.cam.law);
        let goes_on = goes_on(self.end.shaft, [phi, w], time);
        self.now = if goes_on {
            Instant { time, shaft: [phi, w, a], ..self.end }
        } else {
            let shafts = [self.end.shaft, [phi, w, a]];
            let cams = shafts.map(|shaft| ShaftState::at_angle(shaft).on(law));
            Instant::new(time, shafts[1], &cams[1], self.end.q - jump(law, shafts, &cams))
        };
        self.response.motion = motion;
        if self.loaded.is_some() {
            self.take_up_process(&motion, time, goes_on);
        }
        goes_on
    }
}

/// The jumps of x and ẋ when the shaft, and the cam with it, goes from one position to another.
fn jump(law: &MotionLaw, [from, to]: [[f64; 3]; 2], [before, after]: &[TransferFunctions; 2]) -> Pair {
    let (d, [u, u1, u2, u3, u4]) = (to[0] - from[0], before.0);
    // Within this angle the series of U up to U⁗ is accurate to (1e-3)⁵/5! = 1e-17 of the finest harmonic.
    let (du, du1) = if d.abs() * law.resolution() < 1e-3 && law.breakpoints().is_empty() {
        (d * (u1 + d / 2.0 * (u2 + d / 3.0 * (u3 + d / 4.0 * u4))), d * (u2 + d / 2.0 * (u3 + d / 3.0 * u4)))
    } else {
        (after.0[0] - u, after.0[1] - u1)
    };
    Pair::new(du, after.0[1] * (to[1] - from[1]) + from[1] * du1)
}
