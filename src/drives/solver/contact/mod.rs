//! The motion from panel to panel and from one switching instant to the next.
//!
//! Panels follow each other independently of the communication points, which only read the motion. The switching instants at
//! constant speed therefore do not depend on the communication step, not even by a rounding.

use crate::drives::follower::contact::{Beginning, Bodies, Flank, Mode, Phase, State};
mod covariance;
pub mod jump;
mod overdamped;
pub(in crate::drives) mod panel;
pub(in crate::drives) mod series;
mod switching;

use crate::drives::follower::flank::FlankMotion;
use crate::drives::limits::step_too_much;
use crate::drives::{About, Event, EventLog, Fault, Rounded};
use crate::numerics::double_double::Double;
use crate::numerics::pair::Pair;
use crate::numerics::work::Work;
use covariance::{Covariance, Side};
use panel::{Panel, Point};
use serde::{Deserialize, Serialize};
use switching::Switch;

/// This many panels within the rounding of the communication step mean that they will never reach its end. Bounces that die out are
/// fewer, or last longer.
const STUCK: f64 = 1e4;

/// The highest order of a zero with which a gap begins: after a release.
const MOST_ZEROS: usize = 3;

/// Largest correction of a release, as part of a span: the coarsest series neglects 2⁸/8! = 6e-3 of its amplitude.
const NEARBY: f64 = 1e-2;

/// Counters since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// ΣP (N·s).
    pub impulse: f64,
    /// Number of impacts.
    pub impacts: f64,
    /// Energy lost in impacts (J).
    pub energy_loss: f64,
    /// ∫ b q̇² dt up to the current panel (J).
    pub damping_loss: f64,
    /// Panels.
    pub panels: f64,
}

/// The motion up to the communication point and its continuation as far as the current panel.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Run {
    /// The current panel.
    pub panel: Panel,
    /// Counts since the start.
    pub tally: Tally,
    /// The errors made so far.
    pub errors: Covariance,
    /// ∫ F_K dt + ΣP (N·s) and ∫ U′ F_K dt + ΣU′P (N·m·s) over the communication step so far, and the time in the current panel at
    /// which that ends (s).
    sums: Pair,
    summed: f64,
}

/// How far to go, and the log.
pub struct Stretch<'a> {
    /// The end of the communication step (s).
    pub end: f64,
    /// The longest panel (s): the rest of the prescribed motion.
    pub horizon: f64,
    /// The log.
    pub log: &'a mut EventLog,
    /// The remaining work of the call.
    pub work: &'a mut Work,
}

impl Run {
    /// Starts a run from there, with series of so many terms.
    pub fn new(bodies: &Bodies, flank: &impl FlankMotion, from: Beginning, terms: usize) -> Self {
        let mut run = Run { errors: Covariance::new(flank.roundings()), ..Run::default() };
        run.enter(bodies, flank, from, terms);
        run
    }

    /// Goes on from there; the counts stay.
    pub fn restart(&mut self, bodies: &Bodies, flank: &impl FlankMotion, from: Beginning) {
        self.enter(bodies, flank, from, self.terms());
        self.tally.panels += 1.0;
    }

    /// Begins a panel and counts the errors that it makes up to its end.
    fn enter(&mut self, bodies: &Bodies, flank: &impl FlankMotion, from: Beginning, terms: usize) {
        self.panel.lay(bodies, flank, from, terms);
        self.summed = 0.0;
        self.errors.enter(self.panel.series.errors(self.panel.mode(), self.panel.limit()));
    }

    /// Counts the motion up to `theta` (s) after the start of the current panel, which is left then.
    pub fn pass_panel(&mut self, bodies: &Bodies, theta: f64) {
        self.tally.damping_loss += self.panel.damping_loss(bodies, theta);
        self.errors.leave(theta);
    }

    /// Whether it belongs to a law with so many segments, with series of so many terms.
    pub fn is_of(&self, segments: usize, terms: usize) -> bool {
        let of_law = |from: &Beginning| from.segment < segments.max(1) && from.phase.zeros <= MOST_ZEROS;
        let Panel { from, next_segment, .. } = self.panel;
        of_law(&from) && next_segment < segments.max(1) && self.terms() == terms
    }

    /// Begins a communication step at `time` (s) in the current panel.
    pub fn begin_step(&mut self, time: f64) {
        (self.sums, self.summed) = (Pair::default(), self.theta(time));
    }

    /// The terms of a panel's series.
    pub fn terms(&self) -> usize {
        self.panel.series.terms
    }

    /// A bound of the errors of places and velocities up to the end of the current panel, relative to the cam's, `largest` (m),
    /// (m/s).
    pub fn error_estimate(&self, bodies: &Bodies, largest: [f64; 2]) -> f64 {
        self.errors.relative(bodies, self.panel.limit(), largest)
    }

    /// The time from the start of the panel to `time` (s).
    pub fn theta(&self, time: f64) -> f64 {
        self.panel.until(time).min(self.panel.length).max(0.0)
    }

    /// The motion at `time` (s), if the current panel holds it and no event comes before.
    pub fn within(&self, bodies: &Bodies, time: f64) -> Option<Point> {
        let theta = self.panel.until(time);
        (theta < self.panel.limit()).then(|| self.panel.at(bodies, theta.max(0.0)))
    }

    /// The end of the current panel (s), and whether an event happens there.
    pub fn held(&self) -> (f64, bool) {
        let Panel { event, next_segment, from, .. } = &self.panel;
        (self.panel.instant(self.panel.limit()).hi, event.is_some() || *next_segment != from.segment)
    }

    /// ∫ F_K dt + ΣP and ∫ U′ F_K dt + Σ U′P over the communication step up to `time` (s) in the current panel.
    pub fn sums(&self, flank: &impl FlankMotion, time: f64) -> Pair {
        self.sums + Pair(self.panel.integrals(flank, [self.summed, self.theta(time)]))
    }

    /// Adds up the sums before the flank changes its motion.
    pub fn sum_up(&mut self, flank: &impl FlankMotion, time: f64) {
        (self.sums, self.summed) = (self.sums(flank, time), self.theta(time));
    }

    /// Passes panel after panel up to the one that holds the end of the communication step.
    pub fn advance(&mut self, bodies: &Bodies, flank: &impl FlankMotion, stretch: &mut Stretch) -> Result<(), Fault> {
        let (mut events, mut panels) = (0.0, 0.0);
        let (begin, whole) = (self.panel.from.start, self.panel.until(stretch.end));
        loop {
            let left = self.panel.until(stretch.end);
            let limit = self.panel.limit();
            if limit > left || (limit == left && self.panel.event.is_none()) {
                return Ok(());
            }
            self.sums = self.sums + Pair(self.panel.integrals(flank, [self.summed, limit]));
            self.pass_panel(bodies, limit);
            events += if self.panel.event.is_some() { 1.0 } else { 0.0 };
            match self.panel.event {
                None => self.leave_panel(bodies, flank, stretch),
                Some((Switch::Release, at)) => self.release(bodies, flank, at, stretch),
                Some((Switch::Impact(hit), at)) => self.impact(bodies, flank, (hit, at), stretch),
            }
            panels += 1.0;
            let is_stuck = panels > STUCK && (self.panel.from.start - begin).hi <= f64::EPSILON * whole;
            if stretch.work.draw(self.panel.cost).is_err() || is_stuck {
                let hint = format!(
                    "lower the speed, or choose a softer spring, heavier masses or a smaller `e` = {}: {events} switching \
                     instants have passed, the natural frequencies are {} rad/s in contact and {} rad/s in flight",
                    bodies.e,
                    Rounded(bodies.bound.stiffness().sqrt()),
                    Rounded(bodies.relative.stiffness().sqrt())
                );
                let way = [begin.hi, stretch.end];
                return Err(step_too_much(way, self.panel.from.start.hi, &flank.describe(way), &hint));
            }
        }
    }

    fn leave_panel(&mut self, bodies: &Bodies, flank: &impl FlankMotion, stretch: &mut Stretch) {
        let Panel { length, next_segment, from, .. } = self.panel;
        let state = in_place(bodies, from.phase.mode, self.panel.at(bodies, length).state);
        let mut phase = Phase { mode: from.phase.mode, state, zeros: 0 };
        let time = self.panel.instant(length);
        if let (Mode::Contact(contact), true) = (phase.mode, from.segment != next_segment && bodies.s > 0.0) {
            // At a breakpoint of the law ü may jump, and F_K with it.
            let u = flank.at(next_segment, time);
            (phase.mode, phase.zeros) =
                bodies.settle(contact, state.q, &u, bodies.resolution(flank, (time, next_segment)));
            if phase.mode == Mode::Free {
                self.errors.carry(bodies, from.phase.mode);
                stretch.log.push(release(contact, time, ("force", bodies.force(state.q, &u)[0], "N")));
            }
        }
        self.restart(bodies, flank, stretch.beginning(time, next_segment, phase));
    }

    fn release(&mut self, bodies: &Bodies, flank: &impl FlankMotion, mut at: f64, stretch: &mut Stretch) {
        let mode = self.panel.mode();
        let Mode::Contact(contact) = mode else { return };
        self.errors.carry(bodies, mode);
        let (state, u) = self.panel.event_at(bodies, flank, at);
        let mut state = in_place(bodies, mode, state);
        let [force, rate, _] = bodies.force(state.q, &u);
        // The flight begins without any force, and the series of F_K has two terms fewer than q's.
        let better = at - force / rate;
        if better > 0.0 && (better - at).abs() <= NEARBY * self.panel.series.span {
            at = better;
            state = in_place(bodies, mode, self.panel.at(bodies, at).state);
        }
        let (time, segment) = (self.panel.instant(at), self.panel.from.segment);
        stretch.log.push(release(contact, time, ("der(force)", rate, "N/s")));
        let phase = Phase { mode: Mode::Free, state, zeros: 3 };
        self.restart(bodies, flank, stretch.beginning(time, segment, phase));
    }

    fn impact(&mut self, bodies: &Bodies, flank: &impl FlankMotion, (hit, at): (Flank, f64), stretch: &mut Stretch) {
        let (time, segment) = (self.panel.instant(at), self.panel.from.segment);
        let state = self.panel.at(bodies, at).state;
        let phase = self.strike(bodies, flank, Arrival { hit, state, time, segment }, stretch.log);
        self.restart(bodies, flank, stretch.beginning(time, segment, phase));
    }

    /// Counts the impulse with which m1 follows a flank whose motion jumps; `slope` = U′.
    pub fn push(&mut self, impulse: f64, slope: f64) {
        self.tally.impulse += impulse;
        self.sums = self.sums + Pair::new(impulse, slope * impulse);
    }

    /// Counts an impact and returns what follows.
    pub fn strike(&mut self, bodies: &Bodies, flank: &impl FlankMotion, arrival: Arrival, log: &mut EventLog) -> Phase {
        let Arrival { hit, mut state, time, segment } = arrival;
        let u = flank.at(segment, time);
        let before = Side::of(bodies, Mode::Free, &state, &u);
        self.errors.carry(bodies, Mode::Free);
        let impact =
            bodies.impact(hit, &mut state, &u, flank.rate(segment, time), bodies.resolution(flank, (time, segment)));
        let after = Side::of(bodies, impact.after, &state, &u);
        self.errors.strike(bodies.e, &before, &after, impact.after != Mode::Free);
        self.tally.impulse += impact.impulse;
        self.tally.impacts += 1.0;
        self.tally.energy_loss += impact.loss;
        self.tally.damping_loss += impact.damped;
        let kind = hit.pick("impact on flank A", "impact on flank B");
        let (quantity, unit) = ("impulse", "N.s");
        log.push(Event {
            time: time.hi,
            kind,
            quantity,
            value: impact.impulse,
            unit,
            follower: 0,
            about: About::Machine,
        });
        if impact.bounces != 0.0 {
            let kind = "bounces summed";
            log.push(Event {
                time: time.hi,
                kind,
                quantity,
                value: impact.bounces,
                unit,
                follower: 0,
                about: About::Solver,
            });
        }
        if impact.after == Mode::Free && impact.zeros > 1 {
            // Without a rebound m1 stays on the flank for no time at all: the force there would pull.
            log.push(release(hit, time, ("force", bodies.force(state.q, &u)[0], "N")));
        }
        // The summed bounces are still to come: the integral of F_K includes what they add on the way.
        let impulse = bodies.m1 * (state.zeta[1] - before.speed);
        let slope = if flank.is_uniform() && flank.speed() != 0.0 {
            u.0[1] / flank.speed()
        } else {
            flank.slope(segment, time)
        };
        self.sums = self.sums + Pair::new(impulse, slope * impulse);
        Phase { mode: impact.after, state, zeros: impact.zeros }
    }
}

/// m1 at a flank, just before an impact.
pub struct Arrival {
    /// The flank.
    pub hit: Flank,
    /// The motion.
    pub state: State,
    /// The time.
    pub time: Double,
    /// The segment of the law there.
    pub segment: usize,
}

impl Stretch<'_> {
    /// A panel that begins there, at most as long as the motion is prescribed.
    fn beginning(&self, start: Double, segment: usize, phase: Phase) -> Beginning {
        let finite = self.horizon.is_finite();
        let longest = if finite { (Double::from(self.end) - start).hi.max(0.0) } else { self.horizon };
        Beginning { start, segment, phase, longest }
    }
}

/// The release from `flank` at `time`, with the name, value and unit of the quantity that shows that the flank would pull.
pub fn release(flank: Flank, time: Double, (quantity, value, unit): (&'static str, f64, &'static str)) -> Event {
    let kind = flank.pick("release from flank A", "release from flank B");
    Event { time: time.hi, kind, quantity, value, unit, follower: 0, about: About::Machine }
}

/// The state with ζ exactly on the flank that m1 was on.
fn in_place(bodies: &Bodies, mode: Mode, state: State) -> State {
    match mode {
        Mode::Contact(flank) => State { home: bodies.place(flank), zeta: [0.0; 2], ..state },
        Mode::Free => state,
    }
}
