//! The stiff way: steps by collocation ([`crate::numerics::collocation::stages`]) while the fastest free vibration, or the shortest
//! lag, is not seen in the motion.
//!
//! A power series resolves the fastest part of a train whether it moves or not: its steps h end where roundings of that part, which
//! grow with (h λ)ⁿ/n!, reach the tolerance, at about h λ = 10 with the rate λ of that part (1/s). The motion itself does so at
//! h λ = 2.5. So a series whose steps are longer than [`UNSEEN`] λ⁻¹ leaves that part out; where steps may be longer by what one of
//! the collocation costs more, one is tried, at most once in [`TRIAL`] steps. It is left when its steps become shorter than half of that.
//!
//! The polynomial of a step takes the place of the series, so that events, sums and values are read from it alike. A step that ends
//! at an event, or where inputs change, is solved anew up to there, since the end of a step is more exact than the polynomial
//! before it. The step after an event is a series, whose first coefficients show what begins there.

use super::record::{About, Recorded};
use super::{LONGEST, Outside, Run};
use crate::drives::follower::elastic_shaft::REACH;
use crate::drives::shaft::course::Course;
use crate::drives::shaft::motor::Reference;
use crate::drives::shaft::train::{MOST_FOLLOWERS, Modes, Train};
use crate::motion::MotionLaw;
use crate::numerics::collocation::stages::{Equations, Stages, through};
use crate::numerics::collocation::{fit, growth};
use crate::numerics::double_double::{Double, two_product};
use crate::numerics::gauss::STAGES;
use crate::numerics::tape::NONE;

/// A series longer than this, times λ, does not show the fastest part.
const UNSEEN: f64 = 5.0;

/// The length of a series that roundings of that part bound, times λ.
const BOUNDED: f64 = 10.0;

/// Steps from one trial to the next.
const TRIAL: f64 = 64.0;

/// Attempts for a step.
const ATTEMPTS: usize = 30;

/// By how much a step goes beyond its event, as part of its length, so that the event is in it.
const BEYOND: f64 = 1e-3;

/// Nominal work of an evaluation beside the laws, for each follower (µs).
const EVALUATION: f64 = 0.12;

/// The equations of a train along a step that begins at `start` and takes `length` (s).
struct Along<'a> {
    recorded: &'a mut Recorded,
    train: &'a Train,
    modes: &'a Modes,
    outside: &'a Outside<'a>,
    start: Double,
    turns: f64,
    length: f64,
    /// How often the rates were taken.
    count: f64,
}

impl Equations for Along<'_> {
    fn rates(&mut self, theta: f64, y: &[f64], rates: &mut [f64]) {
        let Along { train, outside, turns, .. } = *self;
        let time = self.start + two_product(theta, self.length);
        y.iter().enumerate().for_each(|(k, y)| self.recorded.tape.set(k, *y));
        let angles = train.angles(outside.phi(time, y), y);
        self.recorded.fill(train, self.modes, outside, &About { time, angles: &angles, turns, order: 1, unit: 1.0 });
        self.recorded.tape.evaluate();
        rates.iter_mut().enumerate().for_each(|(k, rate)| *rate = self.recorded.tape.rate(k, 0));
        self.count += 1.0;
    }

    fn slopes(&mut self, k: usize, slopes: &mut [f64]) {
        self.recorded.tape.vary(k);
        slopes.iter_mut().enumerate().for_each(|(k, slope)| *slope = self.recorded.tape.rate(k, 1));
    }
}

impl Run {
    /// By how many times a step of the collocation costs more than a series: some for the evaluations, and what the linear equations
    /// take of many unknowns.
    fn gain(&self) -> f64 {
        let unknowns = self.recorded.stages.unknowns() as f64;
        3.0 + (unknowns / 5.0).powi(2)
    }

    /// The longest step of the collocation (s): between its nodes no law may hide.
    fn longest(&self, train: &Train, outside: &Outside) -> f64 {
        let w = outside
            .motion
            .map_or(self.states.get(1).map_or(0.0, |w| w.hi), |m| m.at_instant(self.start).kinematics.0[1]);
        let rate = |(number, law, angle): (usize, &MotionLaw, usize)| {
            let twist = angle.checked_sub(1).map_or(0.0, |j| self.states[train.layout.followers[j] + 1].hi);
            law.resolution_in(self.modes.segments[number / 2][number % 2]) * (w + twist).abs()
        };
        let servo = train.machine().and_then(|machine| machine.motor.servo()).map(|servo| &servo.reference);
        let of_servo =
            if let Some(Reference::Series(w, series)) = servo { w.abs() * series.order() as f64 } else { 0.0 };
        REACH / train.laws().map(rate).fold(of_servo, f64::max)
    }

    /// Solves a step of `length` (s); its error where Newton's method converges. Of no length only λ is found.
    #[inline(never)]
    fn solve(&mut self, train: &Train, outside: &Outside, length: f64) -> Option<f64> {
        self.recorded.prepare(train, &self.modes, self.order);
        let mut stages = std::mem::take(&mut self.recorded.stages);
        let (modes, turns, start) = (&self.modes, self.turns, self.start);
        let recorded = &mut self.recorded;
        let mut along = Along { recorded, train, modes, outside, start, turns, length, count: 0.0 };
        let mut error = None;
        if length > 0.0 {
            error = stages.solve(&mut along, (&self.states, &self.errors.sizes), length, self.tolerance);
            if error.is_some_and(|error| error <= self.tolerance) {
                write(&mut stages, &mut along, &self.states);
            }
        } else {
            stages.find_rate(&mut along, &self.states);
        }
        let each = EVALUATION * train.followers.len().max(1) as f64;
        self.series += along.count;
        self.algebra += each * along.count + std::mem::take(&mut stages.work);
        self.fastest = stages.rate;
        self.recorded.stages = stages;
        error
    }

    /// Finds λ before a series that may be worth a trial; whether it may.
    pub(super) fn may_try(&mut self, train: &Train, outside: &Outside, horizon: f64) -> bool {
        let may = !self.stiff && self.steps % TRIAL == 1.0 && !self.begins_anew(train);
        if !may || self.unit * self.gain() > horizon.min(self.longest(train, outside)) {
            return false;
        }
        self.solve(train, outside, 0.0);
        true
    }

    /// Whether a step of the collocation serves better than the series on the tape, up to the horizon (s); else the series stays.
    pub(super) fn try_collocation(&mut self, train: &Train, outside: &Outside, horizon: f64) -> bool {
        let (unit, reach) = (self.unit, self.length * self.unit);
        let length = self.gain() * reach;
        if reach * self.fastest > UNSEEN && length <= horizon.min(self.longest(train, outside)) {
            self.next = length;
            self.stiff = self.collocate(train, outside, length).is_ok();
            if !self.stiff {
                self.unit = unit;
                self.expand(train, outside);
            }
        }
        self.stiff
    }

    /// Lays a step of the collocation up to `horizon` (s) at most; false where it is to be a series.
    pub(super) fn lay_stiffly(&mut self, train: &Train, outside: &Outside, horizon: f64) -> bool {
        let longest = self.longest(train, outside);
        if !self.stiff || self.begins_anew(train) || self.is_short(horizon.min(longest)) {
            return self.leave_stiffly();
        }
        self.stiff = (0..ATTEMPTS).any(|_| {
            let length = fit(self.next.min(longest), horizon);
            let solved = if self.is_short(self.next) { Err(self.next) } else { self.collocate(train, outside, length) };
            // A step that was cut short says nothing against the length it was to have.
            let least = if solved.is_ok() && length < self.next { self.next } else { 0.0 };
            self.next = solved.unwrap_or_else(|next| next).max(least);
            solved.is_ok()
        });
        if !self.stiff {
            return self.leave_stiffly();
        }
        self.find_first(train, outside);
        // So much of the step is left out by its end.
        let length = (1.0 + BEYOND) * self.length;
        if self.event.is_none() || (1.0 + BEYOND) * length > 1.0 {
            return true;
        }
        let length = length * self.unit;
        if self.is_short(length) || self.collocate(train, outside, length).is_err() {
            return self.leave_stiffly();
        }
        self.find_first(train, outside);
        true
    }

    /// Whether the first coefficients of a series have to show what begins: after an event, and in a flight that begins.
    fn begins_anew(&self, train: &Train) -> bool {
        let touches = |(j, at, _): (usize, usize, _)| !self.modes.stands[j].is_held() && self.states[at].hi == 0.0;
        self.since.is_some() || train.clearances().any(touches)
    }

    /// The step is a series, of this length where the present one is none.
    pub(super) fn leave_stiffly(&mut self) -> bool {
        if std::mem::take(&mut self.collocated) {
            self.unit = BOUNDED / self.fastest;
        }
        false
    }

    /// Finds the first event of a step of the collocation.
    fn find_first(&mut self, train: &Train, outside: &Outside) {
        (self.length, self.event, self.summed) = (1.0, None, 0.0);
        self.find_event(train, outside);
    }

    /// Whether a step of this length (s) serves no better than a series.
    fn is_short(&self, length: f64) -> bool {
        !(length * self.fastest > 0.5 * UNSEEN * self.gain())
    }

    /// Makes the present step one of the collocation, of this length (s), where that keeps the tolerance; the length to be tried next.
    pub(super) fn collocate(&mut self, train: &Train, outside: &Outside, length: f64) -> Result<f64, f64> {
        let error = self.solve(train, outside, length);
        self.collocated = error.is_some_and(|error| error <= self.tolerance);
        let next = length * error.map_or(0.25, |error| growth(error, self.tolerance));
        if !self.collocated {
            return Err(next);
        }
        (self.unit, self.summed) = (length, self.summed * self.unit / length);
        Ok(next.min(LONGEST))
    }

    /// What a step of the collocation up to `theta` leaves out of a state, with its sign.
    pub(super) fn missed(&self, k: usize, theta: f64) -> f64 {
        let [between, end] = self.recorded.stages.errors[k];
        // Towards the end the error of the polynomial falls to that of the end.
        if theta < 1.0 - 2.0 * BEYOND { between.max(end.abs()).copysign(end) } else { end }
    }
}

/// Writes the polynomial of a step in the place of the series.
#[inline(never)]
fn write(stages: &mut Stages, along: &mut Along, states: &[Double]) {
    let mut values = [[0.0; STAGES]; 2 + 2 * MOST_FOLLOWERS];
    // φ of a driven shaft is known.
    let count = along.recorded.kept.len();
    let is_read = |along: &Along, n: usize| n != 1 && along.recorded.kept[n] != NONE;
    if (0..count).any(|n| is_read(along, n)) {
        for i in 0..STAGES {
            stages.rates_at(along, i);
            for n in 0..count {
                if is_read(along, n) {
                    values[n][i] = along.recorded.tape.series(along.recorded.kept[n])[0];
                }
            }
        }
    }
    for n in 0..count {
        let place = along.recorded.kept[n];
        if is_read(along, n) {
            put(along, place, &through(&values[n]));
        } else if let (Some(motion), true) = (along.outside.motion, place != NONE) {
            put(along, place, &Course::of(motion, along.start).scaled(along.length));
        }
    }
    for (k, state) in states.iter().enumerate() {
        let mut growth = stages.growth(k);
        growth[0] = state.hi;
        put(along, k, &growth);
    }
}

/// Writes the coefficients of a result.
#[inline(never)]
fn put(along: &mut Along, place: usize, coefficients: &[f64]) {
    let series = along.recorded.tape.series_mut(place);
    series.fill(0.0);
    series.iter_mut().zip(coefficients).for_each(|(c, own)| *c = *own);
}
