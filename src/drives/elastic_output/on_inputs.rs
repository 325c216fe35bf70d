//! The drive on inputs: what they move when they are set, and the steps that follow them.

use super::{ElasticOutput, Moment, Position};
use crate::drives::Fault;
use crate::drives::cam_drive::goes_on;
use crate::motion::MotionLaw;
use crate::numerics::pair::Pair;

impl ElasticOutput {
    /// A step on inputs.
    pub(super) fn advance_on_inputs(&mut self, [time, end]: [f64; 2]) -> Result<(), Fault> {
        if !(self.taken_up && self.now.time == time) {
            self.take_up_inputs(time);
        }
        let motion = self.response.motion();
        let ([phi, w, ..], kinematics) = (motion.coefficients, motion.kinematics(end));
        let go_on = motion.is_uniform() && self.goes_on([phi, w], time);
        let q = self.now.at.q.array();
        self.cam.step_done();
        self.taken_up = false;
        let Some(at) = self.response.step(&self.cam.law, [time, end], q, go_on) else {
            self.restart(end)?;
            let q = self.response.at(&self.cam.law, end)?;
            return self.arrive(end, q);
        };
        self.phi = kinematics;
        let [phi, w, a, ..] = kinematics;
        self.now = Moment { time: end, shaft: [phi, w, a], at };
        let ([u, slope], [q, v]) = (at.u.array(), at.q.array());
        let finite = (u + slope * w + q + v).is_finite();
        if finite { Ok(()) } else { Err(self.beyond_all_numbers()) }
    }

    /// Takes up the motion that the inputs give at `time` (s). The mass keeps position and velocity where they jump:
    /// q⁺ = q⁻ − Δx, q̇⁺ = q̇⁻ − Δẋ.
    pub(super) fn take_up_inputs(&mut self, time: f64) {
        if !self.taken_up {
            (self.before, self.taken_up) = (self.now, true);
        }
        let motion = self.cam.motion(time);
        let [phi, w, a, ..] = motion.coefficients;
        self.now = if self.goes_on([phi, w], time) {
            Moment { time, shaft: [phi, w, a], ..self.before }
        } else {
            let law = &self.cam.law;
            let position = Position::of(law, &motion, time);
            let jump = jump(law, &Position::at(law, time, self.phi), &position);
            position.moment((self.before.at.q - jump).array())
        };
        self.response.follow(motion);
    }

    fn goes_on(&self, inputs: [f64; 2], time: f64) -> bool {
        let [phi, w, a, ..] = self.phi;
        goes_on([phi, w, a], inputs, time)
    }
}

/// How far x and ẋ jump from one position to another at the same time.
fn jump(law: &MotionLaw, before: &Position, now: &Position) -> Pair {
    let [phi, w, ..] = before.phi;
    let d_phi = now.phi[0] - phi;
    let d_w = now.phi[1] - w;
    let [u, u1, u2, u3, u4] = before.u;
    // Within this angle the series of U up to U⁗ is right to (1e-3)⁵/5! = 1e-17 of the finest harmonic.
    let (du, du1) = if d_phi.abs() * law.resolution() < 1e-3 && law.breakpoints().is_empty() {
        let d = d_phi;
        (d * (u1 + d / 2.0 * (u2 + d / 3.0 * (u3 + d / 4.0 * u4))), d * (u2 + d / 2.0 * (u3 + d / 3.0 * u4)))
    } else {
        (now.u[0] - u, now.u[1] - u1)
    };
    Pair::new(du, now.u[1] * d_w + w * du1)
}
