//! The estimated error of a motion.
//!
//! A vector e of errors, one for each state and with its sign, is carried along: over a step e⁺ = ∂y⁺/∂y e + the terms that the
//! step neglects. The product is the difference of two series of low order, one from y, one from y + s e. If the rates f or the
//! velocities jump, the event of the disturbed motion comes δt later, and
//!
//! e⁺ = e + f⁻ δt + (y⁺ − y⁻) v/ż⁻ − f⁺ δt,  δt = −(∇g e)/ġ,  v = e_ż + f⁻_ż δt,
//!
//! with the guard g, an angle or a gap; the jump of velocities at an impact is proportional to the closing velocity ż⁻.
//!
//! Source: P. C. Müller, Chaos, Solitons & Fractals 5 (1995) 1671–1681 (linearisation at discontinuities).

use super::{Event, Excitation, Place, Run};
use crate::drives::follower::joint::Change;
use crate::drives::shaft::train::switching::Instant;
use crate::drives::shaft::train::{MOST_STATES, Train};
use crate::drives::solver::step_control::RESERVE;
use crate::numerics::double_double::Double;
use crate::numerics::oscillator::Oscillator;
use serde::{Deserialize, Serialize};

/// The series whose difference carries errors neglect terms below this part of the first ones; an undamped vibration loses or gains
/// as little over a step.
const CARRIED: f64 = 1e-3;
/// They have at least this order; a stiff part at rest shows only in the difference, which is not taken before it converges.
const LEAST: usize = 4;
/// A difference whose last term is a larger part of the disturbance does not converge; the errors then stay as they are.
const CONVERGED: f64 = 0.1;
/// The disturbance of a state for it, as part of its size: a third of the digits.
const DISTURBED: f64 = 1e-5;

/// Errors of the states with their signs, and the largest size of each state so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    pub(super) values: Vec<f64>,
    pub sizes: Vec<f64>,
    /// The largest error and the largest size of each state at communication points. If a stiff member settles between them, its
    /// speed of settling is not visible, and the error of its small velocity counts relative to that velocity.
    seen: Vec<[f64; 2]>,
    /// The largest |U′| of each follower with backlash, whose gap counts relative to the motion of its cam, and the last time of m1
    /// at a flank (s).
    flanks: Vec<[f64; 2]>,
    /// The order that the last difference needs.
    order: usize,
}

impl Errors {
    /// No errors so far.
    pub fn none(train: &Train) -> Self {
        let count = train.layout.count;
        let (mut seen, mut flanks) = (vec![[0.0, f64::MIN_POSITIVE]; count], Vec::new());
        for (follower, at) in train.followers.iter().zip(&train.layout.followers) {
            let gap = follower.joint.clearance().is_some();
            let [place, slope] = [0, 1].map(|order| if gap { follower.rigid.cam.bound(order) } else { 0.0 });
            if gap {
                seen[*at][1] += place;
            }
            flanks.push([slope, f64::NEG_INFINITY]);
        }
        let (values, sizes) = (vec![0.0; count], vec![f64::MIN_POSITIVE; count]);
        Errors { values, sizes, seen, flanks, order: LEAST }
    }

    /// Whether they belong to this train.
    pub fn fit(&self, train: &Train) -> bool {
        let states = [self.values.len(), self.sizes.len(), self.seen.len()];
        states == [train.layout.count; 3] && self.flanks.len() == train.followers.len()
    }

    /// The size of a state for its disturbance. A gap that is all but closed counts by the motion of its cam: next to its own size
    /// the disturbance of everything else would drown in rounding.
    fn size(&self, k: usize) -> f64 {
        self.sizes[k].max(self.seen[k][1])
    }

    /// The largest present error, as part of the size of its state.
    fn largest(&self) -> f64 {
        self.values.iter().enumerate().fold(0.0_f64, |most, (k, e)| most.max(e.abs() / self.size(k)))
    }

    /// Takes up the states at a communication point, at which the shaft turns at `w` (rad/s); returns the estimated relative error
    /// of the motion so far. The angle of a free shaft counts in radians.
    fn see(&mut self, train: &Train, y: &[f64], w: f64) -> f64 {
        for ([slope, _], at) in self.flanks.iter().zip(&train.layout.followers).filter(|([slope, _], _)| *slope > 0.0) {
            let size = &mut self.seen[at + 1][1];
            *size = size.max(slope * w.abs());
        }
        let (mut largest, free) = (0.0_f64, train.machine().is_some());
        for (k, ([most, size], (e, y))) in self.seen.iter_mut().zip(self.values.iter().zip(y)).enumerate() {
            *most = most.max(e.abs());
            *size = if k == 0 && free { 1.0 } else { size.max(y.abs()) };
            largest = largest.max(*most / *size);
        }
        RESERVE * largest
    }

    /// Records that m1 of a follower leaves its flank at `time` (s).
    pub(super) fn open(&mut self, j: usize, time: f64) {
        self.flanks.iter_mut().skip(j).take(1).for_each(|[_, opened]| *opened = time);
    }

    /// The time that m1 of a follower has been in flight at `time` (s).
    pub(super) fn flight(&self, j: usize, time: f64) -> f64 {
        self.flanks.get(j).map_or(f64::INFINITY, |[_, opened]| time - opened)
    }
}

impl Run {
    /// The neglected terms of the step up to `theta` for each state and their roundings, with the sign of the former and of the
    /// error so far; takes up the largest sizes.
    fn left_out(&mut self, theta: f64, changes: &[f64; MOST_STATES], free: bool) -> [f64; MOST_STATES] {
        let (mut left_out, last) = ([0.0; MOST_STATES], theta.powi(self.order as i32 - 1));
        for k in 0..self.states.len() {
            let [left, rounded, size] = self.term(k, [last, last * theta], changes[k], free);
            self.errors.sizes[k] = size;
            left_out[k] = left + rounded.copysign(self.errors.values[k]);
        }
        left_out
    }

    /// The neglected term of the step up to a place with these last two powers for a state with this change, its rounding, and the
    /// largest size of the state.
    fn term(&self, k: usize, powers: [f64; 2], change: f64, free: bool) -> [f64; 3] {
        let c = self.recording.series(k);
        let size = if k == 0 && free { 1.0 } else { c[0].abs().max((c[0] + change).abs()) };
        let last = [c[self.order - 1] * powers[0], c[self.order] * powers[1]];
        // Terms fall at least by half from one to the next.
        let left = 0.5 * last[1].abs().max(0.5 * last[0].abs());
        let rounded = 0.5 * f64::EPSILON * c[0].abs().max(change.abs());
        [left.copysign(last[1]), rounded, self.errors.sizes[k].max(size)]
    }

    /// Takes up a communication point at the place `theta` of the present step, which up to its end may be the whole run: the
    /// step's own part of the estimate up to there counts, too.
    pub(super) fn arrive(&mut self, train: &Train, theta: f64, w: f64) {
        if self.errors.values.is_empty() {
            return;
        }
        let mut y = [0.0; MOST_STATES];
        self.read(theta, &mut y);
        self.error = self.errors.see(train, &y, if train.machine().is_some() { y[1] } else { w });
        let last = self.length.powi(self.order as i32 - 1);
        let mut end = [0.0; MOST_STATES];
        self.read(self.length, &mut end);
        let part = |(k, seen): (usize, &[f64; 2])| {
            let [left, ..] = self.term(k, [last, last * self.length], 0.0, false);
            left.abs() / seen[1].max(end[k].abs())
        };
        self.ahead = RESERVE * self.errors.seen.iter().enumerate().map(part).fold(0.0, f64::max);
    }

    /// The end of a step counts as a communication point if the step contained one.
    pub(super) fn depart(&mut self, train: &Train, w: f64) {
        if std::mem::take(&mut self.arrived) && !self.errors.values.is_empty() {
            let mut y = [0.0; MOST_STATES];
            self.from(&mut y);
            self.error = self.errors.see(train, &y, if train.machine().is_some() { y[1] } else { w });
        }
    }

    /// Carries the errors over the step up to `theta`. Afterwards the series belong to another motion.
    pub(super) fn carry(&mut self, train: &Train, step: (f64, &[f64; MOST_STATES])) {
        let (theta, changes) = step;
        if self.errors.values.is_empty() {
            return;
        }
        let left_out = self.left_out(theta, changes, train.machine().is_some());
        let largest = self.errors.largest();
        if largest > 0.0 && largest.is_finite() && self.recording.holds(&self.modes) {
            self.vary(train, theta, DISTURBED / largest);
        }
        self.errors.values.iter_mut().zip(left_out).for_each(|(e, left_out)| *e += left_out);
    }

    /// ∂y⁺/∂y e, from a motion disturbed by `scale` e.
    fn vary(&mut self, train: &Train, theta: f64, scale: f64) {
        let (count, order) = (self.states.len(), self.order);
        let place = Place::at(theta);
        let partial = |c: &[f64], low: usize| place.sum(&c[1..=low]);
        let mut low = self.errors.order.clamp(LEAST, order - 1);
        for c in (0..count).map(|k| self.recording.series(k)) {
            // The size of a state from its first coefficients.
            let limit = CARRIED * c[..5].iter().fold(0.0_f64, |most, c| most.max(c.abs()));
            low = (low + 1..order).rev().find(|n| c[*n].abs() * place.powers[*n - 1] > limit).unwrap_or(low);
        }
        let [mut y, mut sums, mut tops] = [[0.0; MOST_STATES]; 3];
        self.from(&mut y);
        for k in 0..count {
            let c = self.recording.series(k);
            (sums[k], tops[k]) = (partial(c, low), c[low]);
            y[k] += scale * self.errors.values[k];
        }
        self.recording.expand_close_by(y[..count].iter().copied(), low, self.unit);
        let mut rest = 0.0_f64;
        for k in 0..count {
            let c = self.recording.series(k);
            rest = rest.max((c[low] - tops[k]).abs() * place.powers[low - 1] / self.errors.size(k));
            sums[k] = (partial(c, low) - sums[k]) / scale;
        }
        if rest < CONVERGED * DISTURBED {
            self.errors.values.iter_mut().zip(sums).for_each(|(e, change)| *e += change);
        } else {
            self.settle_errors(train, theta * self.unit);
        }
        self.errors.order = if rest < CARRIED * DISTURBED { low - 1 } else { low + 2 };
    }

    /// For a stiff member, whose difference does not converge: its errors follow its free vibration, all others stay.
    fn settle_errors(&mut self, train: &Train, time: f64) {
        for (follower, at) in train.followers.iter().zip(&train.layout.followers) {
            let Some((place, [m, c, b])) = follower.joint.sprung() else { continue };
            let at = at + place;
            let vibration = Oscillator::new(Double::from(c / m), Double::from(0.5 * b / m)).free(Double::from(time));
            let e = &mut self.errors.values[at..at + 2];
            let [q, v] = vibration.map(|[by_q, by_v]| by_q * e[0] + by_v * e[1]);
            (e[0], e[1]) = (q, v);
        }
    }

    /// Takes up the end of a step on inputs of the shaft. Inputs are rounded, so place and velocity of the cams jump. Vibrations
    /// carry the errors of such a short step on unchanged.
    pub(super) fn end_on_inputs(&mut self, train: &Train, theta: f64, [phi, w]: [f64; 2]) {
        if self.errors.values.is_empty() || theta == 0.0 {
            return;
        }
        let place = Place::at(theta);
        let changes = std::array::from_fn(|k| if k < self.states.len() { self.change(k, &place) } else { 0.0 });
        let left_out = self.left_out(theta, &changes, false);
        for (e, left_out) in self.errors.values.iter_mut().zip(left_out) {
            *e += left_out;
        }
        for (j, follower) in train.followers.iter().enumerate() {
            let slope = if follower.joint.carries_cam() { 1.0 } else { follower.rigid.cam.bound(1) };
            // The mean rounding is an eighth of the last place.
            let place = 0.125 * f64::EPSILON * phi.abs() * slope;
            let held = if self.modes.stands[j].is_held() { 2 } else { 0 };
            let own = &mut self.errors.values[train.layout.followers[j]..][..follower.joint.states()];
            for (i, e) in own.iter_mut().enumerate().skip(held) {
                *e += (place * if i % 2 == 0 { 1.0 } else { w.abs() }).copysign(*e);
            }
        }
        self.arrive(train, theta, w);
    }

    /// States and rates.
    pub(super) fn rates(&self, train: &Train, excitation: &Excitation) -> [[f64; MOST_STATES]; 2] {
        let Instant { phi, y, input_values } = self.here(train, excitation);
        [y, train.instant(&self.modes, phi, &y, &input_values).1.rates]
    }

    /// The effect of an event on the errors. States and rates before it were these; m1 of a follower that hits has been in flight
    /// for this long (s).
    pub(super) fn carry_over(
        &mut self,
        train: &Train,
        excitation: &Excitation,
        event: Event,
        (before, flight): ([[f64; MOST_STATES]; 2], f64),
    ) {
        let ([y0, f0], [y1, f1]) = (before, self.rates(train, excitation));
        let e = &self.errors.values;
        let (delay, struck) = match event {
            Event::Border(which, _) => {
                let (mut guard, mut rate) =
                    if train.machine().is_some() { (e[0], y0[1]) } else { (0.0, f64::INFINITY) };
                if which > 0 {
                    let at = train.layout.followers[which - 1];
                    (guard, rate) = (guard + e[at], rate + y0[at + 1]);
                }
                (if rate == 0.0 { 0.0 } else { -guard / rate }, 0.0)
            }
            Event::Follower(j, Change::Impact(_)) => {
                let at = train.layout.followers[j];
                let of = |y: &[f64]| [y[at], y[at + 1]];
                let [[_, closing], [_, before], [_, behind]] = [&y0, &f0, &f1].map(|y| of(y));
                later(of(e), closing, before).unwrap_or_else(|| {
                    // Bounces that have died away have pressed as much as the contact after them.
                    if self.died_away(train, j) { (0.0, 0.0) } else { apart(of(e), closing, [before, behind], flight) }
                })
            }
            _ => return,
        };
        let e = &mut self.errors.values;
        for (k, e) in e.iter_mut().enumerate() {
            *e += (f0[k] - f1[k]) * delay + (y1[k] - y0[k]) * struck;
        }
        for (_, at, _) in train.clearances().filter(|(j, ..)| self.modes.stands[*j].is_held()) {
            e[at..at + 2].fill(0.0);
        }
    }

    /// Whether m1 of follower j has bounced and is now in contact.
    fn died_away(&self, train: &Train, j: usize) -> bool {
        train.clearance(j).is_some_and(|p| p.e > 0.0) && self.modes.stands[j].is_held()
    }
}

/// Delay of an impact and the part v/ż⁻ of its jump, with these errors of gap and velocity, closing velocity and acceleration
/// before it, for a motion that mostly comes later, by δt = −e_z/ż⁻: the rest of the error of its velocity is less than ż⁻ or half
/// of the whole.
///
/// All impacts of a follower that chatters, and all flights and contacts of others that it opens, then have the same δt, however
/// short they are. Their terms f⁻ δt and f⁺ δt cancel except for the first and the last.
fn later([gap, speed]: [f64; 2], closing: f64, acceleration: f64) -> Option<(f64, f64)> {
    let delay = -gap / closing;
    let rest = speed + acceleration * delay;
    (closing != 0.0 && rest.abs() <= closing.abs().max(0.5 * speed.abs())).then_some((delay, rest / closing))
}

/// The same if the disturbed motion has other impacts, with the accelerations before and after and the time of flight (s).
fn apart(errors: [f64; 2], closing: f64, accelerations: [f64; 2], flight: f64) -> (f64, f64) {
    let ([gap, speed], [before, behind]) = (errors, accelerations);
    // If the gap closes slowly, its curvature bounds the delay.
    let rate = (closing * closing + (2.0 * (behind - before) * gap).abs()).sqrt().copysign(closing);
    if rate == 0.0 {
        return (0.0, 0.0);
    }
    // A bounce lower than the error disappears, or one more occurs, in the disturbed motion: that affects everything else only for
    // its duration.
    let delay = (-gap / rate).min(flight).max(-flight);
    (delay, (speed + before * delay) / rate)
}
