//! The estimated error of a motion.
//!
//! A vector e of errors, one for each state and with its sign, is carried along: over a step e⁺ = ∂y⁺/∂y e + what the step leaves out,
//! the product by the difference of two series of low order, one from y, one from y + s e. Where the rates f jump or
//! velocities do, the event of the disturbed motion comes δt later, and
//!
//! e⁺ = e + f⁻ δt + (y⁺ − y⁻) v/ż⁻ − f⁺ δt,  δt = −(∇g e)/ġ,  v = e_ż + f⁻_ż δt,
//!
//! with the guard g, an angle or a gap; the jump of velocities at an impact is proportional to the closing velocity ż⁻.
//!
//! Source: P. C. Müller, Chaos, Solitons & Fractals 5 (1995) 1671–1681 (linearisation at discontinuities).

use super::{Event, ORDERS, Outside, Run};
use crate::drives::follower::contact::Mode;
use crate::drives::follower::member::Joint;
use crate::drives::shaft::train::{MOST_STATES, Train};
use crate::drives::solver::step_control::RESERVE;
use serde::{Deserialize, Serialize};

/// The series whose difference carries errors leave out terms below this part of the first ones, over which an undamped vibration loses
/// or gains as little in a step.
const CARRIED: f64 = 1e-3;
/// They have this order at least; a stiff part at rest shows only in the difference, which is not taken before it converges.
const LEAST: usize = 4;
/// A difference whose last term is a larger part of the disturbance than this does not converge; errors then stay as they are.
const CONVERGED: f64 = 0.1;
/// Of what a state is disturbed for it, as part of its size: a third of the digits.
const DISTURBED: f64 = 1e-5;

/// Errors of the states with their signs, the largest of each so far, and the largest size of each state so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    pub(super) values: Vec<f64>,
    most: Vec<f64>,
    pub sizes: Vec<f64>,
    /// The order that the last difference asks for.
    order: usize,
}

impl Errors {
    /// None so far, of so many states.
    pub fn none(count: usize) -> Self {
        Errors { values: vec![0.0; count], most: vec![0.0; count], sizes: vec![f64::MIN_POSITIVE; count], order: LEAST }
    }

    /// Whether they are those of so many states.
    pub fn fit(&self, count: usize) -> bool {
        [&self.values, &self.most, &self.sizes].iter().all(|list| list.len() == count)
    }

    /// The largest present error, as part of the size of its state.
    fn largest(&self) -> f64 {
        self.values.iter().zip(&self.sizes).fold(0.0_f64, |most, (e, size)| most.max(e.abs() / size))
    }

    /// The estimated relative error of the motion so far.
    fn estimate(&mut self) -> f64 {
        self.most.iter_mut().zip(&self.values).for_each(|(most, e)| *most = most.max(e.abs()));
        RESERVE * self.most.iter().zip(&self.sizes).fold(0.0_f64, |most, (e, size)| most.max(e / size))
    }
}

impl Run {
    /// What the step up to `theta` leaves out of each state and rounds, with the sign of the one and of the error so far; the largest
    /// sizes are taken up.
    fn left_out(&mut self, theta: f64, free: bool) -> [f64; MOST_STATES] {
        let mut left_out = [0.0; MOST_STATES];
        for k in 0..self.states.len() {
            let [left, rounded, size] = self.term(k, theta, free);
            self.errors.sizes[k] = size;
            left_out[k] = left + rounded.copysign(self.errors.values[k]);
        }
        left_out
    }

    /// What the step up to `theta` leaves out of a state, what it rounds, and the largest size of the state.
    fn term(&self, k: usize, theta: f64, free: bool) -> [f64; 3] {
        let c = self.recorded.tape.series(k);
        let change = theta * c[1..=self.order].iter().rev().fold(0.0, |sum, c| sum * theta + c);
        let size = if k == 0 && free { 1.0 } else { c[0].abs().max((c[0] + change).abs()) };
        let last = [self.order - 1, self.order].map(|n| c[n] * theta.powi(n as i32));
        // Terms fall by half at least from one to the next.
        let left = 0.5 * last[1].abs().max(0.5 * last[0].abs());
        let rounded = 0.5 * f64::EPSILON * c[0].abs().max(change.abs());
        [left.copysign(last[1]), rounded, self.errors.sizes[k].max(size)]
    }

    /// What the present step up to its end, which may be all of a run, adds to the estimate.
    pub(super) fn look_ahead(&mut self, train: &Train) {
        let part = |k: usize| {
            let [left, _, size] = self.term(k, self.length, train.machine().is_some());
            left.abs() / size
        };
        self.ahead = RESERVE * (0..self.errors.values.len()).map(part).fold(0.0, f64::max);
    }

    /// Carries the errors over the step up to `theta`. The series are those of another motion afterwards.
    pub(super) fn carry(&mut self, train: &Train, outside: &Outside, theta: f64) {
        if self.errors.values.is_empty() {
            return;
        }
        let left_out = self.left_out(theta, train.machine().is_some());
        let largest = self.errors.largest();
        if largest > 0.0 && largest.is_finite() && self.recorded.holds(&self.modes) {
            self.vary(train, outside, theta, DISTURBED / largest);
        }
        self.errors.values.iter_mut().zip(left_out).for_each(|(e, left_out)| *e += left_out);
        self.error = self.errors.estimate();
    }

    /// ∂y⁺/∂y e, by a motion that is disturbed by `scale` e.
    fn vary(&mut self, train: &Train, outside: &Outside, theta: f64, scale: f64) {
        let (count, order) = (self.states.len(), self.order);
        let partial = |c: &[f64], low: usize| theta * c[1..=low].iter().rev().fold(0.0, |sum, c| sum * theta + c);
        let (mut low, mut powers) = (self.errors.order.clamp(LEAST, order - 1), [1.0; ORDERS[1] + 1]);
        (1..=order).for_each(|n| powers[n] = theta * powers[n - 1]);
        for c in (0..count).map(|k| self.recorded.tape.series(k)) {
            // The size of a state as its first coefficients show it.
            let limit = CARRIED * c[..5].iter().fold(0.0_f64, |most, c| most.max(c.abs()));
            low = (low + 1..order).rev().find(|n| c[*n].abs() * powers[*n] > limit).unwrap_or(low);
        }
        let [mut y, mut sums, mut tops] = [[0.0; MOST_STATES]; 3];
        self.from(&mut y);
        for k in 0..count {
            let c = self.recorded.tape.series(k);
            (sums[k], tops[k]) = (partial(c, low), c[low]);
            y[k] += scale * self.errors.values[k];
            self.recorded.tape.set(k, y[k]);
        }
        let angles = train.angles(self.phi(outside, self.start, &y), &y);
        let at = (self.start, &angles[..], self.turns);
        self.recorded.fill(train, &self.modes, at, outside, (low, self.unit));
        self.recorded.tape.expand(low, self.unit);
        let (mut rest, sizes) = (0.0_f64, &self.errors.sizes);
        for k in 0..count {
            let c = self.recorded.tape.series(k);
            rest = rest.max((c[low] - tops[k]).abs() * powers[low] / sizes[k]);
            sums[k] = (partial(c, low) - sums[k]) / scale;
        }
        if rest < CONVERGED * DISTURBED {
            self.errors.values.iter_mut().zip(sums).for_each(|(e, change)| *e += change);
        }
        self.errors.order = if rest < CARRIED * DISTURBED { low - 1 } else { low + 2 };
    }

    /// The end of a step on inputs of the shaft, which themselves are rounded: by them place and velocity of the cams jump. Vibrations
    /// carry the errors of so short a step on as they are.
    pub(super) fn end_on_inputs(&mut self, train: &Train, theta: f64, [phi, w]: [f64; 2]) {
        if self.errors.values.is_empty() || theta == 0.0 {
            return;
        }
        let left_out = self.left_out(theta, false);
        for (e, left_out) in self.errors.values.iter_mut().zip(left_out) {
            *e += left_out;
        }
        for (j, follower) in train.followers.iter().enumerate() {
            let slope = if let Joint::Shaft(_) = follower.joint { 1.0 } else { follower.rigid.cam.bound(1) };
            // The mean rounding is an eighth of the last place.
            let place = 0.125 * f64::EPSILON * phi.abs() * slope;
            let held = if let Mode::Contact(_) = self.modes.contacts[j] { 2 } else { 0 };
            let own = &mut self.errors.values[train.layout.followers[j]..][..follower.joint.states()];
            for (i, e) in own.iter_mut().enumerate().skip(held) {
                *e += (place * if i % 2 == 0 { 1.0 } else { w.abs() }).copysign(*e);
            }
        }
        self.error = self.errors.estimate();
    }

    /// States and rates.
    pub(super) fn rates(&self, train: &Train, outside: &Outside) -> [[f64; MOST_STATES]; 2] {
        let mut y = [0.0; MOST_STATES];
        self.from(&mut y);
        let phi = self.phi(outside, self.start, &y);
        let given = self.given(train, outside, self.start, &y);
        [y, train.instant(&self.modes, phi, &y, &given).1.rates]
    }

    /// What an event makes of the errors, before which states and rates were these.
    pub(super) fn carry_over(
        &mut self,
        train: &Train,
        outside: &Outside,
        event: Event,
        before: [[f64; MOST_STATES]; 2],
    ) {
        let ([y0, f0], [y1, f1]) = (before, self.rates(train, outside));
        let died_away = matches!(event, Event::Impact(j, _) if self.died_away(train, j));
        let e = &mut self.errors.values;
        let (guard, mut rate, speed) = match event {
            Event::Border(which, _) => {
                let (mut guard, mut rate) =
                    if train.machine().is_some() { (e[0], y0[1]) } else { (0.0, f64::INFINITY) };
                if which > 0 {
                    let at = train.layout.followers[which - 1];
                    (guard, rate) = (guard + e[at], rate + y0[at + 1]);
                }
                (guard, rate, None)
            }
            // Bounces that have died away have pressed as much as the contact after them.
            Event::Impact(..) if died_away => (0.0, 0.0, None),
            Event::Impact(j, _) => {
                let at = train.layout.followers[j];
                (e[at], y0[at + 1], Some(at + 1))
            }
            _ => return,
        };
        if let Some(at) = speed {
            // Where the gap closes slowly, its curvature bounds the delay.
            rate = (rate * rate + (2.0 * (f1[at] - f0[at]) * guard).abs()).sqrt().copysign(rate);
        }
        let delay = if rate == 0.0 { 0.0 } else { -guard / rate };
        let struck = speed.filter(|_| rate != 0.0).map_or(0.0, |at| (e[at] + f0[at] * delay) / rate);
        for (k, e) in e.iter_mut().enumerate() {
            *e += (f0[k] - f1[k]) * delay + (y1[k] - y0[k]) * struck;
        }
        for (j, follower) in train.followers.iter().enumerate() {
            if let (Joint::Backlash(_), Mode::Contact(_)) = (follower.joint, self.modes.contacts[j]) {
                e[train.layout.followers[j]..][..2].fill(0.0);
            }
        }
        self.error = self.errors.estimate();
    }

    /// Whether m1 of follower j, which bounces, is in contact.
    fn died_away(&self, train: &Train, j: usize) -> bool {
        let bounces = matches!(train.followers[j].joint, Joint::Backlash(p) if p.e > 0.0);
        bounces && self.modes.contacts[j] != Mode::Free
    }
}
