//! One step of a Fourier law on a moving input without pieces.

use super::error_bound::Made;
use super::leap::{Leap, left};
use super::{Course, Instant, Response, SHARE};
use crate::drives::cam_drive::AngleMotion;
use crate::motion::MotionLaw;

impl Response {
    /// Cam and mass at the end of the step from `time` to `end` (s) from `state`, where one quadrature reaches so far or inputs
    /// `go_on` at the same speed.
    pub fn leap(&mut self, law: &MotionLaw, [time, end]: [f64; 2], state: [f64; 2], go_on: bool) -> Option<Instant> {
        let series = law.series()?;
        if go_on && self.motion.is_uniform() {
            if !(matches!(self.course, Course::Closed(_)) && self.closed_form.holds()) {
                let motion = self.motion;
                self.restart(law, &motion, time, f64::INFINITY, state).ok()?;
            }
            return self.closed(law, end);
        }
        let AngleMotion { origin, coefficients: [phi, w, a, ..], degree } = self.motion;
        if degree > 2 || origin != time {
            return None;
        }
        let (length, order) = (end - time, series.order() as f64);
        let fastest = [w.abs().max((w + a * length).abs()), a.abs()];
        let part = left(&self.oscillator, order, fastest, length);
        if !(part <= SHARE * self.tolerance) {
            return None;
        }
        if !matches!(self.course, Course::Leaps(_)) {
            self.course = Course::Leaps(Leap::new());
        }
        let Course::Leaps(leap) = &mut self.course else { return None };
        let instant = leap.over(&self.oscillator, series, [phi, w, a], length, state);
        self.steps += 1.0;
        self.evaluations += 1;
        let [speed, acceleration] = fastest;
        let forcing = self.bounds[1] * speed * speed + self.bounds[0] * acceleration;
        // |g| ≤ min(h, 1/|λ|) and |ġ| ≤ 1.
        let error = part * length * forcing;
        let error = [error * length.min(1.0 / self.oscillator.rates().1), error];
        let turned = order * speed * length;
        let made = Made { length, error, forcing, order, turned, angle: phi.abs(), state: instant.q.array() };
        self.bound.add(&self.oscillator, leap.decay, &made, [0.0; 2]);
        Some(instant)
    }
}
