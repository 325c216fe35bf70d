//! One step of a Fourier law on a moving input without pieces.

use super::error_bound::Made;
use super::hermite::{Hermite, left};
use super::{Instant, Method, Response, SHARE};
use crate::drives::cam_drive::AngleMotion;
use crate::motion::MotionLaw;

impl Response {
    /// Cam and mass at the end of the step from `time` to `end` (s) from `state`, where one quadrature reaches so far or inputs
    /// `go_on` at a constant speed.
    #[inline]
    pub fn step(&mut self, law: &MotionLaw, [time, end]: [f64; 2], state: [f64; 2], go_on: bool) -> Option<Instant> {
        let series = law.series()?;
        if go_on {
            if !(matches!(self.method, Method::Closed(_)) && self.closed_form.holds()) {
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
        if !matches!(self.method, Method::Hermite(_)) {
            self.method = Method::Hermite(Hermite::new());
        }
        let Method::Hermite(step) = &mut self.method else { return None };
        let instant = step.over(&self.oscillator, series, [phi, w, a], length, state);
        self.steps += 1.0;
        self.evaluations += 1;
        let [speed, acceleration] = fastest;
        let forcing = self.bounds[1] * speed * speed + self.bounds[0] * acceleration;
        // |g| ≤ min(h, 1/|λ|) and |ġ| ≤ 1.
        let error = part * length * forcing;
        let error = [error * length.min(1.0 / self.oscillator.rates().1), error];
        let turned = order * speed * length;
        let made = Made { length, error, forcing, order, turned, angle: phi.abs(), state: instant.q.array() };
        self.bound.add(&self.oscillator, step.decay, &made, [0.0; 2]);
        Some(instant)
    }
}
