//! One quadrature for each communication step of a Fourier law on a moving input.

use super::error_bound::Made;
use super::leap::ends::{self, Limits};
use super::leap::{self, Leap};
use super::local::Local;
use super::{Course, Instant, Response, SHARE};
use crate::drives::cam_drive::AngleMotion;
use crate::motion::{Fourier, MotionLaw};
use crate::numerics::double_double::Double;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::pair::Pair;

/// So many steps share a bound of their error and the choice of the rule: the work for these, some ten steps, is then hardly
/// felt, and what was chosen does not outlive the speed for which it was.
const STRETCH: f64 = 256.0;

/// The end of a step.
pub enum Landing {
    /// Of cam and mass.
    Both(Both),
    /// Of the mass alone: q, q̇.
    Mass([f64; 2]),
}

/// Cam and mass at the end of a step.
pub struct Both {
    /// U, U′ and q, q̇.
    pub instant: Instant,
    /// φ, ω, α.
    pub phi: [f64; 3],
}

/// How one step is integrated.
enum Quadrature {
    /// From its ends, by this rule within these limits, from this angle, speed and acceleration at the start.
    Ends([f64; 3], ends::Rule, Limits),
    /// By so many nodes, with what they leave.
    Nodes(Local, (usize, f64)),
}

impl Response {
    /// The end of the step from `time` to `end` [s] from `state`, where one quadrature reaches so far or inputs `go_on` at the
    /// same speed.
    pub fn leap(&mut self, law: &MotionLaw, [time, end]: [f64; 2], state: [f64; 2], go_on: bool) -> Option<Landing> {
        let uniform = go_on && self.motion.is_uniform();
        match &self.course {
            Course::Closed(_) if uniform && self.closed_form.holds() => return self.closed_step(law, end),
            // Whoever has kept the speed for so long will keep it on.
            Course::Leaps(_) if uniform && self.goal <= self.steps => {
                let motion = self.motion;
                self.restart(law, &motion, time, f64::INFINITY, state).ok()?;
                return self.closed_step(law, end);
            }
            _ => {}
        }
        let series = law.series()?;
        let (length, share) = (end - time, SHARE * self.tolerance);
        let quadrature = self.quadrature(series, time, length, share)?;
        self.bound.end(self.steps);
        if !matches!(self.course, Course::Leaps(_)) {
            self.course = Course::Leaps(Leap::new(series));
        }
        let Course::Leaps(leap) = &mut self.course else { return None };
        let order = series.order() as f64;
        let angle = self.motion.coefficients[0];
        let made = Made { length, order, angle: angle.abs(), ..Made::default() };
        match quadrature {
            Quadrature::Ends(start, rule, limits) => {
                leap.start(&self.oscillator, &self.closed_form, length, (rule, limits), start[0]);
                let Limits { speed, acceleration } = limits;
                let made = Made {
                    turned: order * (speed + acceleration * length) * length,
                    ..made.neglecting(&self.oscillator, self.bounds, [speed, acceleration], rule.left())
                };
                self.bound.begin(&self.oscillator, leap.decay(), made, self.steps);
                self.goal = self.steps + STRETCH;
                self.begin_stretch(start, [time, end], state)
            }
            Quadrature::Nodes(local, (nodes, part)) => {
                let state = leap.over(&self.oscillator, series, &local, length, state, nodes);
                self.evaluations += leap.evaluations;
                let fastest = [local.speed(length), local.acceleration(length)];
                let [_, w, a, ..] = self.motion.coefficients;
                let made = Made {
                    turned: order * (w.abs() + a.abs() * length) * length,
                    state: state.into(),
                    ..made.neglecting(&self.oscillator, self.bounds, fastest, part)
                };
                self.bound.add(&self.oscillator, leap.decay(), &made, [0.0; 2]);
                self.steps += 1.0;
                Some(Landing::Mass(state))
            }
        }
    }

    /// The same for a step that is like the one before it and goes on from the angle, speed and acceleration `motion` where
    /// that one ended.
    #[inline(always)]
    pub fn glide_on(&mut self, motion: [f64; 3], [time, end]: [f64; 2], state: Pair) -> Option<Both> {
        let [_, w, a] = motion;
        match &mut self.course {
            Course::Leaps(leap) => {
                let length = end - time;
                if !(leap.goes_on([w, a], length) && self.steps < self.goal) {
                    return None;
                }
                let landing = leap.cross(&self.oscillator, &self.closed_form, motion, length, state);
                self.bound.pass(landing.state);
                self.steps += 1.0;
                self.evaluations += leap.evaluations;
                let instant = Instant { u: leap.u(), q: landing.state };
                Some(Both { instant, phi: [landing.angle, landing.speed, a] })
            }
            Course::Closed(run) if a == 0.0 && self.closed_form.holds() => {
                let instant = self.closed_form.at(run, &self.oscillator, &self.motion, end);
                self.evaluations += 1;
                Some(Both { instant, phi: self.closed_form.cam(run, end) })
            }
            _ => None,
        }
    }

    /// The first of them.
    #[inline(never)]
    fn begin_stretch(&mut self, motion: [f64; 3], step: [f64; 2], state: [f64; 2]) -> Option<Landing> {
        self.glide_on(motion, step, state.into()).map(Landing::Both)
    }

    /// On in closed form.
    fn closed_step(&mut self, law: &MotionLaw, end: f64) -> Option<Landing> {
        let instant = self.closed(law, end)?;
        let Course::Closed(run) = &self.course else { return None };
        Some(Landing::Both(Both { instant, phi: self.closed_form.cam(run, end) }))
    }

    /// How the step from `time` over `length` [s] is integrated: from its ends, else by nodes, if either meets the share.
    fn quadrature(&self, series: &Fourier, time: f64, length: f64, share: f64) -> Option<Quadrature> {
        let AngleMotion { origin, coefficients: [phi, w, a, ..], degree } = self.motion;
        let oscillator = &self.oscillator;
        if degree <= 2 && origin == time {
            // What is in use stays in use on the border, so that it is not prepared again and again.
            let in_use = match &self.course {
                Course::Leaps(leap) => Some(leap.pairs()),
                _ => None,
            };
            let limits = Limits::of(w, a, length);
            let wider = limits.widened(series.order() as f64, length);
            for limits in [wider, limits] {
                if let Some(rule) = ends::rule(oscillator, series, &limits, length, share, in_use) {
                    return Some(Quadrature::Ends([phi, w, a], rule, limits));
                }
            }
        }
        let local = Local::of(&self.motion, Double::from(time));
        leap::rule(oscillator, series, &local, length, share).map(|rule| Quadrature::Nodes(local, rule))
    }
}

impl Made {
    /// With what a quadrature leaves that neglects `part` of the largest |ẍ|; the law is bounded by `bounds` of |U′| and |U″|,
    /// and the cam by this speed and acceleration.
    fn neglecting(self, oscillator: &Oscillator, bounds: [f64; 2], [speed, acceleration]: [f64; 2], part: f64) -> Self {
        let forcing = bounds[1] * speed * speed + bounds[0] * acceleration;
        let (_, fast) = oscillator.rates();
        // |g| ≤ min(h, 1/|λ|) and |ġ| ≤ 1.
        let error = part * self.length * forcing;
        Made { forcing, error: [error * self.length.min(1.0 / fast), error], ..self }
    }
}
