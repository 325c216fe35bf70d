//! The motion of a train from event to event, by power series in time.
//!
//! A step is the power series of all states about its start ([`record`]), as long as the neglected terms allow for the tolerance.
//! It yields the communication points. Events are certified first roots of polynomials, none of which is missed: breakpoints of a
//! law, release and impact, the limit of a servo's torque, a knot of a torque table. A step ends at the first of them.
//!
//! Source: À. Jorba, M. Zou, Experimental Mathematics 14 (2005) 99–117 (step size of Taylor's method).

pub mod estimate;
mod events;
pub mod periodic;
mod record;

use crate::drives::follower::joint::{Change, Guard};
use crate::drives::limits::step_too_much;
use crate::drives::shaft::cam_drive::AngleMotion;
use crate::drives::shaft::motor::Motor;
use crate::drives::shaft::train::{InputValues, Inputs, MOST_FOLLOWERS, MOST_STATES, Modes, Train};
use crate::drives::{EventLog, Fault, Rounded};
use crate::numerics::angle::WHOLE_TURN;
use crate::numerics::double_double::{Double, two_product, two_sum};
use crate::numerics::first_root::first_root;
use crate::numerics::gauss::Gauss;
use crate::numerics::taylor::Series;
use crate::numerics::work::Work;
use estimate::Errors;
pub use record::RECORDINGS;
use record::{About, Recording};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The external influences during a communication step that begins at `time` (s).
pub struct Excitation<'a> {
    pub time: f64,
    /// The motion of a driven shaft.
    pub motion: Option<&'a AngleMotion>,
    pub inputs: &'a Inputs,
}

impl Excitation<'_> {
    /// ω of a driven shaft at the start of the communication step (rad/s).
    fn speed(&self) -> f64 {
        self.motion.map_or(0.0, |motion| motion.coefficients[1])
    }
}

/// An event that ends a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Event {
    /// An angle reaches a breakpoint, ahead or back.
    Border(usize, bool),
    /// The equations of a follower change.
    Follower(usize, Change),
    /// The servo reaches its limit or leaves it.
    Limit(i8),
    /// The rotor reaches the next piece of the torque table.
    Knot(usize),
}

impl Event {
    /// The modes of the motor after it.
    fn changed(self, modes: Modes) -> Modes {
        match self {
            Event::Limit(saturation) => Modes { saturation, ..modes },
            Event::Knot(piece) => Modes { piece, ..modes },
            _ => modes,
        }
    }
}

/// Counts of a follower with backlash since the start, and over the communication step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// ΣP (N·s).
    pub impulse: f64,
    /// Impacts.
    pub impacts: f64,
    /// Energy lost (J).
    pub loss: f64,
    /// ∫ b q̇² dt up to the current step (J), if it is counted.
    pub damped: Option<f64>,
    /// ∫F_K dt + ΣP and ∫U′F_K dt + ΣU′P of the communication step up to the current step.
    pub sums: [f64; 2],
}

/// The motion: a step that holds the communication point.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Run {
    /// The start of the step (s).
    start: Double,
    /// The states there; φ within a turn.
    states: Vec<Double>,
    /// The whole turns of φ.
    pub turns: f64,
    /// The modes since that start.
    pub modes: Modes,
    /// The unit of time (s).
    unit: f64,
    /// The length of the step, and how far its series serves, in units.
    length: f64,
    reach: f64,
    /// The event at its end.
    event: Option<Event>,
    /// The event at its start.
    since: Option<Event>,
    /// The order of the series.
    order: usize,
    /// The place in the step from which the sums are still to be taken, in units.
    summed: f64,
    /// The counts of the followers.
    pub tallies: [Tally; MOST_FOLLOWERS],
    /// Steps since the start.
    pub steps: f64,
    /// Estimated relative error up to the present step, and the step's own part.
    pub error: f64,
    pub ahead: f64,
    /// Whether a communication point has been in the present step.
    arrived: bool,
    /// The errors behind it; without states during the search for a periodic motion.
    pub errors: Errors,
    /// The relative tolerance.
    tolerance: f64,
    /// The period at the start (s), and its largest multiplier; 0 for other starts.
    pub period: [f64; 2],
    #[serde(skip)]
    recording: Recording,
    /// Series of the laws and mechanisms since work was last drawn for them.
    #[serde(skip)]
    series: f64,
}

/// The end of a step before inputs jump.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct End {
    time: f64,
    states: Vec<f64>,
    modes: Modes,
    tallies: [Tally; MOST_FOLLOWERS],
    /// φ, φ̇ of the shaft.
    pub shaft: [f64; 2],
}

impl End {
    /// Whether its pieces exist in the train's laws.
    pub fn has_segments_of(&self, train: &Train) -> bool {
        train.has_segments(&self.modes.segments)
    }

    /// Whether it may belong to this train, whose laws may have other pieces.
    pub fn fits(&self, train: &Train) -> bool {
        self.states.len() == train.layout.count
            && train.takes(&self.modes)
            && self.shaft.iter().chain([&self.time]).all(|number| number.is_finite())
    }
}

/// The least order, and the order of the finest tolerance.
const ORDERS: [usize; 2] = [8, 24];

/// The neglected terms of each step are below this part of the tolerance, so that those of many steps stay below it.
const SHARE: f64 = 0.05;

/// The longest step (s).
const LONGEST: f64 = 1e6;

/// The speed on a torque table may be beyond the end of its piece by this part of the table: the pieces meet with equal slopes, so
/// the torque differs by the square of that, and no rounding brings the speed back.
const SLACK: f64 = 1e-8;

/// After the servo reaches its limit, its demand differs from the limit by at most this part of it, by tolerance.
const NEAR: f64 = 1e-3;

/// The shortest flight that begins without velocity, as a part of the unit of time: m1 has moved by 1e-14 of a typical way.
const ARMING: f64 = 1e-7;
/// It counts if the leading coefficient of the gap is no more than this part of the largest one, about rounding.
const NOISE: f64 = 1e-9;

/// The highest order of a zero with which a gap begins: after a release.
const MOST_ZEROS: usize = 3;

/// Nominal work of a step, and of a follower in it (µs).
const COST: [f64; 2] = [2.0, 1.0];

/// Cost of the series of a law over the cost of its value, U … U⁗: measured on trains of 2 and 16 laws of 256 harmonics.
const SERIES_OF_LAW: f64 = 1.3;

/// Nominal work of a step of this train with so many series of its laws and mechanisms (µs).
fn cost(train: &Train, series: f64) -> f64 {
    let laws: f64 = train.laws().map(|(_, law, _)| law.cost()).sum();
    let mechanisms: f64 = train.followers.iter().map(|follower| follower.rigid.linkage.cost()[1]).sum();
    let of_functions = SERIES_OF_LAW * laws + mechanisms;
    COST[0] + COST[1] * train.followers.len() as f64 + series * of_functions
}

/// The order of the series for a tolerance. Longer series make longer steps: for a motor with three elastic outputs 4 + 1.4 digits
/// takes 1.5 times as many steps in the same time.
fn order(tolerance: f64) -> usize {
    let digits = -tolerance.log10();
    (9.0 + 1.45 * digits).round().clamp(ORDERS[0] as f64, ORDERS[1] as f64) as usize
}

/// A place in a step, with its powers up to the highest order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Place {
    theta: f64,
    powers: [f64; ORDERS[1]],
}

impl Place {
    /// The place `theta` of a step.
    pub fn at(theta: f64) -> Self {
        let mut powers = [theta; ORDERS[1]];
        // Each from those of half the exponent, so that none waits for all others.
        for n in 1..ORDERS[1] {
            powers[n] = powers[(n - 1) / 2] * powers[n / 2];
        }
        Place { theta, powers }
    }

    /// Moves to another place.
    pub fn move_to(&mut self, theta: f64) {
        if self.theta != theta {
            *self = Place::at(theta);
        }
    }

    /// Σ cₙ θⁿ, n = 1 …, in four sums: an addition takes as long as four products.
    fn sum(&self, c: &[f64]) -> f64 {
        let ((c, c_rest), (powers, rest)) = (c.as_chunks::<4>(), self.powers[..c.len()].as_chunks::<4>());
        let mut sums = [0.0; 4];
        for (c, powers) in c.iter().zip(powers).rev() {
            (0..4).for_each(|k| sums[k] += c[k] * powers[k]);
        }
        let rest = c_rest.iter().zip(rest).fold(0.0, |sum, (c, power)| sum + c * power);
        (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
    }
}

impl Run {
    /// Begins at `time` in these states and modes, within the first turn.
    pub fn begin(train: &Train, time: Double, y: &[f64], modes: Modes, tolerance: f64) -> Self {
        let states = y.iter().map(|y| Double::from(*y)).collect();
        let order = order(tolerance);
        let mut run = Run { start: time, states, modes, order, tolerance, unit: LONGEST, ..Run::default() };
        run.unit = run.pace(train);
        run
    }

    /// The states at the start of the step.
    pub fn from(&self, y: &mut [f64]) {
        self.states.iter().zip(y).for_each(|(state, y)| *y = state.hi);
    }

    /// Sets other states and modes, as before the first step.
    pub fn put(&mut self, y: &[f64], modes: Modes) {
        self.states.iter_mut().zip(y).for_each(|(state, y)| *state = Double::from(*y));
        (self.modes, self.length) = (modes, 0.0);
    }

    /// Records that the run begins on this periodic motion.
    pub fn set_period(&mut self, found: &periodic::Periodic) {
        self.period = [found.period, found.multiplier];
    }

    /// Forgets the recorded equations after a change.
    pub fn forget(&mut self) {
        self.recording.forget();
    }

    /// Whether it may belong to this train, whose laws may have other pieces: a saved state with a right checksum may hold
    /// anything.
    pub fn fits(&self, train: &Train) -> bool {
        let lengths = [self.length, self.reach, self.unit, self.summed];
        let is_event = |event: &Event| match *event {
            Event::Border(0, _) => true,
            Event::Border(which, _) => train.followers.get(which - 1).is_some_and(|f| f.joint.carries_cam()),
            Event::Follower(j, _) => train.clearance(j).is_some(),
            Event::Limit(_) | Event::Knot(_) => train.takes(&event.changed(self.modes)),
        };
        self.states.len() == train.layout.count
            && self.errors.fit(train)
            && self.modes.stands.iter().all(|stand| stand.zeros <= MOST_ZEROS)
            && (ORDERS[0]..=ORDERS[1]).contains(&self.order)
            && lengths.iter().all(|length| (0.0..f64::INFINITY).contains(length))
            && self.unit > 0.0
            && train.takes(&self.modes)
            && self.event.iter().chain(&self.since).all(is_event)
    }

    /// Whether its pieces exist in the train's laws.
    pub fn has_segments_of(&self, train: &Train) -> bool {
        train.has_segments(&self.modes.segments)
    }

    /// Recomputes the series that saved states leave out.
    pub fn rebuild(&mut self, train: &Train, excitation: &Excitation) {
        self.expand(train, excitation);
    }

    /// Terms of a series.
    pub fn terms(&self) -> f64 {
        self.order as f64
    }

    /// Whether the states are finite.
    pub fn is_finite(&self) -> bool {
        self.states.iter().all(|state| state.hi.is_finite()) && self.length.is_finite() && self.unit.is_finite()
    }

    /// The states at `time` with their first two time derivatives, as series.
    pub fn series_at(&self, time: f64, y: &mut [Series]) {
        let theta = self.theta_at(time);
        for (k, y) in y.iter_mut().enumerate().take(self.states.len()) {
            let c = self.recording.series(k);
            let [mut value, mut rate, mut bend] = [0.0; 3];
            for c in c[..=self.order].iter().rev() {
                bend = bend * theta + rate;
                rate = rate * theta + value;
                value = value * theta + c;
            }
            *y = Series([value, rate / self.unit, bend / (self.unit * self.unit)]);
        }
    }

    /// A time in which the motion changes little (s), from frequencies alone.
    fn pace(&self, train: &Train) -> f64 {
        1.0 / train.followers.iter().map(|follower| follower.joint.frequency()).fold(1.0, f64::max)
    }

    /// φ (rad) within a turn; for a driven shaft from its motion.
    fn phi(&self, excitation: &Excitation, time: Double, y: &[f64]) -> Double {
        excitation.motion.map_or_else(|| Double::from(y[0]), |motion| Double::from(motion.at_instant(time).reduced))
    }

    /// The external values at `time`.
    pub fn input_values(&self, train: &Train, excitation: &Excitation, time: Double, y: &[f64]) -> InputValues<f64> {
        let since = (time - Double::from(excitation.time)).hi;
        let mut input_values = InputValues {
            shaft: [0.0; 2],
            tau: excitation.inputs.loads.at(since),
            torque: excitation.inputs.torque.at(since),
            reference: 0.0,
            lag: 0.0,
            forces: [0.0; MOST_FOLLOWERS],
        };
        if let Some(motion) = excitation.motion {
            let [_, w, a, ..] = motion.at_instant(time).kinematics.0;
            input_values.shaft = [w, a];
        }
        if let Some(motor) = train.machine().map(|machine| &machine.motor) {
            if let Some(servo) = motor.servo() {
                let mut row = [0.0; 9];
                servo.expand_reference(time.hi, 1.0, (&excitation.inputs.reference, since), &mut row);
                input_values.reference = row[0];
            }
            if motor.takes_position() {
                let turns = motor.transmission.ratio * self.turns * TAU;
                input_values.lag = excitation.inputs.position.at(since) - turns - motor.angle(y[0], y, &train.layout);
            }
        }
        excitation
            .inputs
            .forces
            .iter()
            .zip(&mut input_values.forces)
            .for_each(|(signal, force)| *force = signal.at(since));
        input_values
    }

    /// The work done since the last call (nominal µs): a step, and the series of laws and mechanisms for it.
    fn done(&mut self, train: &Train) -> f64 {
        cost(train, std::mem::take(&mut self.series))
    }

    /// Computes the series about the start of the step.
    fn expand(&mut self, train: &Train, excitation: &Excitation) {
        self.series += 1.0;
        self.recording.prepare(train, &self.modes, self.order);
        let mut y = [0.0; MOST_STATES];
        self.from(&mut y);
        let angles = train.angles(self.phi(excitation, self.start, &y), &y);
        let about = About { time: self.start, angles: &angles, turns: self.turns, order: self.order, unit: self.unit };
        self.recording.fill(train, &self.modes, excitation, &about);
        self.recording.expand(self.states.iter().map(|state| state.hi), self.order, self.unit);
    }

    /// The reach of the series, in units: the last two terms of each state are below the tolerance of its first ones, or of its
    /// largest size so far.
    fn reach(&self) -> f64 {
        let (mut at, mut reach) = (1.0, self.reach_by(1.0));
        // Beyond half of the place the first terms are at most sixteen times as large, which [`SHARE`] outweighs.
        while 0.0 < reach && reach < 0.5 * at {
            (at, reach) = (reach, self.reach_by(reach));
        }
        reach
    }

    /// The same relative to the first terms at the place `at`.
    fn reach_by(&self, at: f64) -> f64 {
        let tolerance = SHARE * self.tolerance;
        let mut reach = 4.0_f64;
        let mut take = |c: &[f64], order: usize, so_far: f64| {
            let largest = |c: &[f64]| c.iter().rev().fold(0.0_f64, |most, c| (at * most).max(c.abs()));
            let size = largest(&c[..5]).max(so_far);
            for n in [order - 1, order] {
                let part = |size: f64| tolerance * size / c[n].abs();
                let below = |size: f64, powers: usize| part(size).powf(1.0 / powers as f64);
                if c[n].is_nan() {
                    reach = 0.0;
                } else if c[n] != 0.0 {
                    // A motion that begins flat is measured by the later size of its first terms.
                    let flat = || (5..n).fold(0.0_f64, |most, i| most.max(below(c[i].abs(), n - i)));
                    let flat_start = size <= f64::MIN_POSITIVE;
                    if flat_start || part(size) < reach.powi(n as i32) {
                        reach = reach.min(if flat_start { flat() } else { below(size, n) });
                    }
                }
            }
        };
        for k in 0..self.states.len() {
            take(self.recording.series(k), self.order, self.errors.sizes.get(k).copied().unwrap_or(0.0));
        }
        // The quantities that locate events are known to one order less.
        let held = |j: &usize| self.modes.stands[*j].is_held();
        let of = |j| self.recording.normal(j);
        (0..MOST_FOLLOWERS).filter(held).flat_map(of).for_each(|c| take(c, self.order - 1, 0.0));
        reach
    }

    /// Computes the next step from the end of the last one.
    fn lay(&mut self, train: &Train, excitation: &Excitation, horizon: f64) -> Result<(), Fault> {
        self.unit = self.unit.min(LONGEST);
        let mut reach = 0.0;
        for _ in 0..60 {
            self.expand(train, excitation);
            reach = self.reach();
            // Steps that are not finite or much shorter than their unit are tried in a smaller unit.
            if reach >= 0.1 {
                break;
            }
            self.unit *= if reach > 0.0 { 2.0 * reach } else { 1e-3 };
        }
        if !(reach > 0.0) {
            return Err(Fault::new(format!(
                "the motion leaves the range of numbers at t = {} s",
                Rounded(self.start.hi)
            )));
        }
        self.reach = reach;
        (self.length, self.event, self.summed) = (reach.min(1.0).min(horizon / self.unit), None, 0.0);
        self.find_event(train, excitation);
        self.steps += 1.0;
        Ok(())
    }

    /// Notes the root of a guard if it is the first.
    fn watch(&mut self, guard: &[f64], event: Event) {
        if guard.iter().all(|c| *c == 0.0) {
            return;
        }
        if let Some(root) = first_root(guard, self.length.min(1.0)) {
            (self.length, self.event) = (root, Some(event));
        }
    }

    /// Shortens the step to the first event.
    fn find_event(&mut self, train: &Train, excitation: &Excitation) {
        let mut y = [0.0; MOST_STATES];
        self.from(&mut y);
        self.watch_borders(train, &train.angles(self.phi(excitation, self.start, &y), &y));
        let w = excitation.motion.map_or(y[1], |motion| motion.at_instant(self.start).kinematics.0[1]);
        for j in 0..train.followers.len() {
            self.watch_follower(train, j, w);
        }
        if let Some(machine) = train.machine() {
            self.watch_motor(&machine.motor);
        }
    }

    /// A guard: its present value, and the motion of a series in one sense or the other.
    fn guard(&self, value: f64, sign: f64, c: &[f64]) -> [f64; ORDERS[1]] {
        let mut guard = [0.0; ORDERS[1]];
        guard[0] = value;
        guard[1..self.order].iter_mut().zip(&c[1..]).for_each(|(g, c)| *g = sign * c);
        guard
    }

    /// The ends of the segments at these angles.
    fn watch_borders(&mut self, train: &Train, angles: &[f64]) {
        let count = self.order;
        let ways = train.ways(&self.modes, angles);
        for (which, [ahead, back]) in ways.into_iter().enumerate().filter(|(_, way)| way[0].is_finite()) {
            let mut way = self.guard(back, 1.0, self.recording.phi());
            if which > 0 {
                let twist = self.recording.series(train.layout.followers[which - 1]);
                way[1..count].iter_mut().zip(&twist[1..]).for_each(|(way, twist)| *way += twist);
            }
            self.watch(&way[..count], Event::Border(which, false));
            let way = self.guard(ahead, -1.0, &way);
            self.watch(&way[..count], Event::Border(which, true));
        }
    }

    /// The guards of a follower while the shaft turns at the speed w.
    fn watch_follower(&mut self, train: &Train, j: usize, w: f64) {
        let (count, stand, own) = (self.order, self.modes.stands[j], train.layout.followers[j]);
        train.followers[j].joint.guards(&stand, &mut |Guard { state, shift, sign, zeros, change }| {
            let of_state = state.map(|place| self.recording.series(own + place));
            let series = of_state.unwrap_or_else(|| self.recording.normal(j)[0]);
            let mut guard = self.guard(sign * (series[0] + shift), sign, series);
            let zeros = if guard[0] == 0.0 { zeros } else { 0 };
            guard[..zeros].fill(0.0);
            if state.is_none() {
                // Without a pressing force, roundings are no release.
                let resolution = self.recording.resolution(j, w);
                guard.iter_mut().take_while(|c| c.abs() <= resolution).for_each(|c| *c = 0.0);
            }
            let before = self.length;
            self.watch(&guard[..count], Event::Follower(j, change));
            let most = guard.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
            if zeros >= 2 && self.length < ARMING && guard[zeros] <= NOISE * most {
                self.length = ARMING.min(before);
            }
        });
    }

    /// The guards of the motor: the limit of a servo, the ends of a piece of a torque table.
    fn watch_motor(&mut self, motor: &Motor) {
        let count = self.order;
        let side = |run: &Self, sign: f64, shift: f64| {
            let demand = run.recording.demand();
            run.guard(sign * demand[0] + shift, sign, demand)
        };
        if let Some(servo) = motor.servo() {
            // After reaching a limit the guard begins with a zero.
            let (fresh, saturation) = (matches!(self.since, Some(Event::Limit(_))), self.modes.saturation);
            let mut limit = |sign: f64, shift: f64, event: Event| {
                let mut guard = side(self, sign, shift);
                guard[0] = if fresh && guard[0].abs() <= NEAR * servo.limit { 0.0 } else { guard[0] };
                self.watch(&guard[..count], event);
            };
            match saturation {
                0 => {
                    limit(-1.0, servo.limit, Event::Limit(1));
                    limit(1.0, servo.limit, Event::Limit(-1));
                }
                sign => limit(f64::from(sign), -servo.limit, Event::Limit(0)),
            }
        } else if let Some(table) = motor.table() {
            let ([low, high], piece) = (table.ends(self.modes.piece), self.modes.piece);
            let slack = SLACK * table.span();
            if low.is_finite() {
                self.watch(&side(self, 1.0, slack - low)[..count], Event::Knot(piece - 1));
            }
            if high.is_finite() {
                self.watch(&side(self, -1.0, high + slack)[..count], Event::Knot(piece + 1));
            }
        }
    }

    /// The time from the start of the step to `time`, in units.
    fn theta(&self, time: Double) -> f64 {
        (time - self.start).hi / self.unit
    }

    /// The end of the step (s).
    fn end(&self) -> Double {
        self.start + two_product(self.length, self.unit)
    }

    /// The end of the step (s), and whether an event happens there.
    pub fn held(&self) -> (f64, bool) {
        (self.end().hi, self.event.is_some())
    }

    /// The place of the instant `time` in the step.
    pub fn theta_at(&self, time: f64) -> f64 {
        self.theta(Double::from(time)).clamp(0.0, self.length)
    }

    /// A state at a place of the step.
    pub fn state(&self, k: usize, place: &Place) -> f64 {
        self.states[k].hi + (self.states[k].lo + self.change(k, place))
    }

    /// How much a state changes up to a place of the step.
    fn change(&self, k: usize, place: &Place) -> f64 {
        place.sum(&self.recording.series(k)[1..=self.order])
    }

    /// The states at the place `theta` of the step.
    pub fn read(&self, theta: f64, y: &mut [f64]) {
        let place = Place::at(theta);
        y.iter_mut().take(self.states.len()).enumerate().for_each(|(k, y)| *y = self.state(k, &place));
    }

    /// ∫ b q̇² dt of a follower with backlash since the start (J), up to the place `theta` of the step, if it is counted.
    fn damped(&self, train: &Train, j: usize, theta: f64) -> Option<f64> {
        let (before, p) = (self.tallies[j].damped?, train.clearance(j)?);
        let rate = &self.recording.series(train.layout.followers[j] + 3)[..=self.order];
        let [square] = Gauss::with(16).integrate(theta - self.summed, |x| {
            let v = rate.iter().rev().fold(0.0, |sum, c| sum * (self.summed + x) + c);
            [v * v]
        });
        Some(before + p.b * self.unit * square)
    }

    /// The same up to `time`.
    pub fn damping_loss(&self, train: &Train, time: f64, j: usize) -> Option<f64> {
        self.damped(train, j, self.theta_at(time))
    }

    /// Takes up ∫F_K and ∫U′F_K of the step up to `theta`.
    fn sum_up(&mut self, train: &Train, theta: f64) {
        for j in 0..train.followers.len() {
            let (damped, sums) = (self.damped(train, j, theta), self.sums_to(train, theta, j));
            (self.tallies[j].damped, self.tallies[j].sums) = (damped, sums);
        }
        self.summed = theta;
    }

    /// Ends the step at `theta`; the next one begins there.
    fn leave(&mut self, train: &Train, excitation: &Excitation, theta: f64) {
        self.sum_up(train, theta);
        let (mut changes, place) = ([0.0; MOST_STATES], Place::at(theta));
        changes.iter_mut().enumerate().take(self.states.len()).for_each(|(k, change)| *change = self.change(k, &place));
        self.carry(train, (theta, &changes));
        for (state, change) in self.states.iter_mut().zip(changes) {
            *state = two_sum(state.hi, change) + Double::from(state.lo);
        }
        (self.start, self.summed) = (self.start + two_product(theta, self.unit), 0.0);
        if train.machine().is_some() {
            let turns = (self.states[0].hi / TAU).round();
            if turns != 0.0 {
                let angle = two_product(turns, WHOLE_TURN.hi) + two_product(turns, WHOLE_TURN.lo);
                self.states[0] = self.states[0] - angle;
                self.turns += turns;
            }
        }
        self.depart(train, excitation.speed());
        // The next step is expected to be as long as this one might have been.
        self.unit *= self.reach.clamp(0.1, 2.0);
    }

    /// Begins a communication step and its sums.
    pub fn begin_step(&mut self, train: &Train, time: f64) {
        self.sum_up(train, self.theta_at(time));
        self.tallies.iter_mut().for_each(|tally| tally.sums = [0.0; 2]);
    }

    /// Restarts from the states at `time`, since external influences have changed.
    pub fn restart(&mut self, train: &Train, excitation: &Excitation, time: f64) {
        let theta = self.theta_at(time);
        if self.length > 0.0 {
            self.leave(train, excitation, theta);
        }
        // The event at the start of the step that is left holds only there.
        (self.length, self.event, self.since) = (0.0, None, self.since.filter(|_| theta == 0.0));
    }

    /// The first step.
    pub fn first(&mut self, train: &Train, excitation: &Excitation, horizon: f64) -> Result<(), Fault> {
        self.errors = Errors::none(train);
        if horizon > 0.0 {
            self.lay(train, excitation, horizon)?;
        } else {
            self.expand(train, excitation);
        }
        self.arrive(train, 0.0, excitation.speed());
        Ok(())
    }

    /// Goes on up to the step that holds `end`; the external influences hold up to the `horizon` (s).
    pub fn advance(
        &mut self,
        train: &Train,
        excitation: &Excitation,
        (end, horizon): (f64, f64),
        log: &mut EventLog,
    ) -> Result<(), Fault> {
        let (mut work, target) = (Work::default(), Double::from(end));
        loop {
            let left = (target - self.end()).hi;
            if self.length > 0.0 && (left < 0.0 || (left == 0.0 && self.event.is_none())) {
                if !std::mem::replace(&mut self.arrived, true) {
                    self.arrive(train, self.theta(target), excitation.speed());
                }
                return Ok(());
            }
            if self.length > 0.0 || self.event.is_some() {
                let event = self.event;
                self.leave(train, excitation, self.length);
                self.since = event;
                if let Some(event) = event {
                    self.happen(train, excitation, event, log);
                }
            }
            let left = (Double::from(excitation.time + horizon) - self.start).hi;
            if work.draw(self.done(train)).is_err() {
                let way = [excitation.time, end];
                let hint = "lower the speed, or choose softer springs, heavier masses or a smaller `e`";
                let told = format!("the step has come to t = {} s", Rounded(self.start.hi));
                return Err(step_too_much(way, self.start.hi, &told, hint));
            }
            if left <= 0.0 {
                self.length = 0.0;
                self.event = None;
                self.expand(train, excitation);
                self.arrive(train, 0.0, excitation.speed());
                return Ok(());
            }
            self.lay(train, excitation, if horizon.is_finite() { left } else { f64::INFINITY })?;
        }
    }

    /// Keeps the motion at `time` on this motion of the shaft, at which the step ends.
    pub fn keep(&mut self, train: &Train, time: f64, motion: &AngleMotion, end: &mut End) {
        let [phi, w, ..] = motion.at(time).kinematics.0;
        self.end_on_inputs(train, self.theta_at(time), [phi, w]);
        end.states.resize(self.states.len(), 0.0);
        self.at(time, &mut end.states);
        (end.time, end.modes, end.tallies, end.shaft) = (time, self.modes, self.tallies, [phi, w]);
        for j in 0..train.followers.len() {
            (end.tallies[j].sums, end.tallies[j].damped) =
                (self.sums(train, time, j), self.damping_loss(train, time, j));
        }
    }

    /// The states at `time`.
    pub fn at(&self, time: f64, y: &mut [f64]) {
        self.read(self.theta_at(time), y);
    }

    /// The sums of the communication step up to `time`.
    pub fn sums(&self, train: &Train, time: f64, j: usize) -> [f64; 2] {
        self.sums_to(train, self.theta_at(time), j)
    }

    /// The same up to the place `theta` of the step.
    fn sums_to(&self, train: &Train, theta: f64, j: usize) -> [f64; 2] {
        let mut sums = self.tallies[j].sums;
        if self.modes.stands[j].is_held() && j < train.followers.len() {
            let integral = |c: &[f64], x: f64| {
                c.iter().enumerate().rev().fold(0.0, |sum, (n, c)| sum * x + c / (n + 1) as f64) * x
            };
            for (sum, c) in sums.iter_mut().zip(self.recording.normal(j)) {
                let c = &c[..self.order];
                *sum += self.unit * (integral(c, theta) - integral(c, self.summed));
            }
        }
        sums
    }
}
