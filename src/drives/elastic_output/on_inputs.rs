//! The drive on inputs: what they move when they are set, and the steps that follow them.

use super::{ElasticOutput, Moment, Position};
use crate::drives::Fault;
use crate::drives::cam_drive::{goes_on, roundings};
use crate::drives::response::{Both, Instant, Landing};
use crate::motion::MotionLaw;
use crate::numerics::pair::Pair;

impl ElasticOutput {
    /// A step on inputs that go on without a jump where the cam was last; None where it takes more than that.
    #[inline(always)]
    pub(super) fn glide_on_inputs(&mut self, time: f64, end: f64) -> Option<Instant> {
        let motion @ [phi, w, _] = self.cam.plain_inputs()?;
        if self.taken_up {
            (self.now, self.taken_up) = (self.before, false);
        }
        // Angles grow, and their roundings with them: those of some steps ago are on the safe side.
        let [before, speed, ..] = self.phi;
        if !((phi - before).abs() <= self.slack[0] && (w - speed).abs() <= self.slack[1]) {
            return None;
        }
        let Both { instant, phi: [phi, w, a] } = self.response.glide_on(motion, [time, end], self.now.q)?;
        (self.phi, self.now.w) = ([phi, w, a, 0.0, 0.0], w);
        Some(instant)
    }

    /// A step on inputs, where one quadrature or the closed form makes it; else what they give is taken up.
    pub(super) fn advance_on_inputs(&mut self, [time, end]: [f64; 2]) -> Option<Result<(), Fault>> {
        self.slack = [0.0; 2];
        if !(self.taken_up && self.now.time == time) {
            self.take_up_inputs(time);
        }
        self.cam.step_done();
        self.taken_up = false;
        let [phi, w, ..] = self.response.motion().coefficients;
        let smooth = self.goes_on([phi, w], time);
        let (law, q) = (&self.cam.law, self.now.q.array());
        Some(match self.response.leap(law, [time, end], q, smooth)? {
            Landing::Both(Both { instant: Instant { u, q }, phi: [phi, w, a] }) => {
                self.phi = [phi, w, a, 0.0, 0.0];
                self.slack = roundings([phi, w, a], end);
                self.now = Moment { time: end, w, u, q };
                let [u, u1] = u.array();
                let [q, v] = q.array();
                let finite = (u + u1 * w + q + v).is_finite();
                if finite { Ok(()) } else { Err(self.beyond_all_numbers()) }
            }
            Landing::Mass(q) => self.arrive(end, q),
        })
    }

    /// Takes up the motion that the inputs give at `time` [s]. The mass keeps position and velocity where they jump:
    /// q⁺ = q⁻ − Δx, q̇⁺ = q̇⁻ − Δẋ.
    pub(super) fn take_up_inputs(&mut self, time: f64) {
        if !self.taken_up {
            (self.before, self.taken_up) = (self.now, true);
        }
        let motion = self.cam.motion(time);
        let [phi, w, ..] = motion.coefficients;
        self.now = if self.goes_on([phi, w], time) {
            Moment { time, w, ..self.before }
        } else {
            let law = &self.cam.law;
            let position = Position::of(law, &motion, time);
            let jump = jump(law, &Position::at(law, time, self.phi), &position);
            position.moment((self.before.q - jump).array())
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
