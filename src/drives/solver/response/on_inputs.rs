//! A step on inputs: in closed form as long as they keep their speed, else by one quadrature, else in pieces.

use super::error_bound::StepErrors;
use super::hermite::{Hermite, left};
use super::{Method, Response, SHARE};
use crate::drives::Fault;
use crate::drives::shaft::cam_drive::AngleMotion;
use crate::drives::shaft::instant::Instant;
use crate::motion::MotionLaw;

impl Response {
    /// Brings cam and mass from `now` to `end` (s); `goes_on` if the previous step ended with this motion.
    #[inline]
    pub fn step(&mut self, law: &MotionLaw, end: f64, goes_on: bool, now: &mut Instant) -> Result<(), Fault> {
        self.round_inputs();
        if goes_on && self.motion.is_uniform() && law.series().is_some() {
            self.bound.take_worst(self.equation.oscillator.stiffness().sqrt(), [0.0; 2]);
            if !(matches!(self.method, Method::Closed(_)) && self.closed_form.holds_for.is_some()) {
                let motion = self.motion;
                self.restart(law, &motion, now.time, f64::INFINITY, now.q.array())?;
            }
        } else if self.by_quadrature(law, end, now).is_some() {
            return Ok(());
        } else {
            let motion = self.motion;
            self.restart(law, &motion, now.time, end, now.q.array())?;
        }
        self.reach(law, end, now)
    }

    /// The inputs of a step are rounded by half a last place: if that is no jump, the mass should have kept place and speed.
    fn round_inputs(&mut self) {
        if self.equation.of_acceleration() == 0.0 {
            return;
        }
        let [phi, w, ..] = self.motion.coefficients.map(f64::abs);
        let [_, slope, curvature] = self.bounds.map(|bound| 0.5 * f64::EPSILON * bound);
        self.bound.disturb([slope * phi, (slope + curvature * phi) * w]);
    }

    /// The same by one quadrature, for a Fourier law, if the quadrature is accurate enough.
    #[inline]
    pub(super) fn by_quadrature(&mut self, law: &MotionLaw, end: f64, now: &mut Instant) -> Option<()> {
        let series = law.series()?;
        let AngleMotion { origin, coefficients: [phi, w, a, ..], degree } = self.motion;
        if degree > 2 || origin != now.time {
            return None;
        }
        let (length, order) = (end - origin, series.order() as f64);
        let fastest = [w.abs().max((w + a * length).abs()), a.abs()];
        let part = left(&self.equation.oscillator, order, fastest, length);
        if !(part <= SHARE * self.tolerance) {
            return None;
        }
        if !matches!(self.method, Method::Hermite(_)) {
            self.method = Method::Hermite(Hermite::new());
        }
        let Method::Hermite(step) = &mut self.method else { return None };
        step.over(&self.equation, series, &self.motion, end, now);
        self.steps += 1.0;
        self.evaluations += 1;
        let [speed, _] = fastest;
        let forcing = self.equation.bound(self.bounds, fastest);
        // |g| ≤ min(h, 1/|λ|) and |ġ| ≤ 1.
        let error = part * length * forcing;
        let error = [error * length.min(1.0 / self.equation.oscillator.rates().1), error];
        let turned = order * speed * length;
        let step_errors = StepErrors { length, error, forcing, order, turned, angle: phi.abs(), state: now.q.array() };
        self.bound.add(&self.equation.oscillator, step.decay, &step_errors, [0.0; 2]);
        Some(())
    }
}
