//! The motion from panel to panel and from one switching instant to the next.
//!
//! Panels follow each other without regard to the communication points; these only read the motion. So the
//! switching instants at constant speed do not depend on the communication step, not even by a rounding.

use super::contact::{Bodies, Flank, Mode, State};
use super::flank::FlankMotion;
use super::panel::{Found, Panel, Reading, Rules};
use super::spread::{Side, Spread};
use crate::drives::limits::too_much;
use crate::drives::{Event, EventLog, Fault, Rounded};
use crate::motion::Kinematics;
use crate::numerics::double_double::Double;
use crate::numerics::work::Work;
use serde::{Deserialize, Serialize};

/// Panels that together are within the rounding of the communication step: the rest would never be reached. Bounces that die
/// out are fewer, or last longer.
const STUCK: f64 = 1e4;

/// The highest order of a zero with which a gap begins: after a release.
const MOST_ZEROS: usize = 3;

/// By how much of a span a release is corrected at the most: the coarsest series neglects 2⁸/8! = 6e-3 of its amplitude.
const NEARBY: f64 = 1e-2;

/// What is counted since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// ΣP [N·s].
    pub impulse: f64,
    /// Number of impacts.
    pub impacts: f64,
    /// Energy lost in impacts [J].
    pub energy_loss: f64,
    /// ∫ b q̇² dt up to the current panel [J].
    pub damping_loss: f64,
    /// Panels.
    pub panels: f64,
}

/// ∫ F_K dt + ΣP and ∫ U′ F_K dt + Σ U′P over the communication step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sums {
    /// [N·s].
    pub force: f64,
    /// [N·m·s].
    pub torque: f64,
}

/// Where a panel begins; the panel follows from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    place: (Double, usize),
    from: (Mode, State, usize),
    /// Its longest length [s].
    longest: f64,
}

/// The motion up to the communication point and its continuation as far as the current panel.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Run {
    /// The current panel.
    pub panel: Panel,
    /// The order of the zero with which its gap begins, and its longest length [s].
    zeros: usize,
    longest: f64,
    /// Where the panel began in which the communication step started, and when the step did [s].
    begin: (Origin, f64),
    /// Whether that is the current panel.
    begin_is_current: bool,
    /// Counts since the start.
    pub tally: Tally,
    /// The errors made so far.
    pub spread: Spread,
    /// Impulses of jumping inputs at the start of the communication step.
    pushed: Sums,
    rules: Rules,
}

/// How far to go and what to note.
pub struct Stretch<'a> {
    /// The end of the communication step [s].
    pub end: f64,
    /// The longest panel [s]: what is left of the motion as prescribed.
    pub horizon: f64,
    /// The log.
    pub log: &'a mut EventLog,
}

impl Run {
    /// A run from `state` in `mode` at `time`.
    pub fn new(
        bodies: &Bodies,
        flank: &impl FlankMotion,
        time: Double,
        from: (Mode, State, usize),
        (longest, terms): (f64, usize),
    ) -> Self {
        let rules = Rules { terms, locked: bodies.s == 0.0 };
        let origin = Origin { place: (time, flank.segment(time)), from, longest };
        let mut run = Run {
            panel: origin.panel(bodies, flank, rules),
            zeros: from.2,
            longest,
            begin: (origin, 0.0),
            begin_is_current: true,
            tally: Tally::default(),
            spread: Spread::default(),
            pushed: Sums::default(),
            rules,
        };
        run.enter_panel();
        run
    }

    /// Continues in `mode` from `state` at `time`, counts kept.
    pub fn restart(
        &mut self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        place: (Double, usize),
        from: (Mode, State, usize),
        longest: f64,
    ) {
        if self.begin_is_current {
            (self.begin.0, self.begin_is_current) = (self.origin(), false);
        }
        (self.zeros, self.longest) = (from.2, longest);
        self.panel.lay(bodies, flank, place, from, longest, self.rules);
        self.enter_panel();
        self.tally.panels += 1.0;
    }

    /// Counts the errors that the current panel makes up to its end.
    fn enter_panel(&mut self) {
        self.spread.enter(self.panel.errors(self.panel.limit()));
    }

    /// Counts what has passed when the current panel is left `theta` [s] after its start.
    pub fn pass_panel(&mut self, bodies: &Bodies, theta: f64) {
        self.tally.damping_loss += self.panel.damping_loss(bodies, theta);
        self.spread.leave(theta);
    }

    /// Whether it is one of a law with so many segments, with series of so many terms.
    pub fn is_of(&self, segments: usize, terms: usize) -> bool {
        let Origin { place: (_, segment), from: (_, _, zeros), .. } = self.begin.0;
        [self.panel.segment, self.panel.next_segment, segment].iter().all(|segment| *segment < segments.max(1))
            && self.zeros.max(zeros) <= MOST_ZEROS
            && [self.panel.terms, self.rules.terms] == [terms; 2]
    }

    /// Where the current panel began.
    fn origin(&self) -> Origin {
        let Panel { start, segment, mode, state, .. } = self.panel;
        Origin { place: (start, segment), from: (mode, state, self.zeros), longest: self.longest }
    }

    /// A communication step begins; nothing has been pushed yet.
    pub fn begin_step(&mut self) {
        self.pushed = Sums::default();
    }

    /// The motion of a communication step begins at `time` [s] in the current panel.
    pub fn begin_here(&mut self, time: f64) {
        (self.begin.1, self.begin_is_current) = (time, true);
    }

    /// The terms of a panel's series.
    pub fn terms(&self) -> usize {
        self.rules.terms
    }

    /// A bound of the errors of places and velocities up to the end of the current panel, relative to those of the cam,
    /// `largest` [m], [m/s].
    pub fn error_estimate(&self, bodies: &Bodies, largest: [f64; 2]) -> f64 {
        self.spread.relative(bodies, self.panel.limit(), largest)
    }

    /// How far `time` is from the start of the panel [s].
    pub fn theta(&self, time: f64) -> f64 {
        self.panel.until(time).min(self.panel.length).max(0.0)
    }

    /// What is read at `time` [s], where the current panel holds it and nothing happens before.
    pub fn within(&self, bodies: &Bodies, time: f64) -> Option<Reading> {
        (self.panel.until(time) < self.panel.limit()).then(|| self.panel.at(bodies, self.theta(time)).reading())
    }

    /// Goes on to the end of the communication step.
    pub fn advance(&mut self, bodies: &Bodies, flank: &impl FlankMotion, stretch: &mut Stretch) -> Result<(), Fault> {
        self.advance_on(bodies, flank, stretch, &mut Work::default())
    }

    /// The same with what is left of the `work`.
    pub fn advance_on(
        &mut self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        stretch: &mut Stretch,
        work: &mut Work,
    ) -> Result<(), Fault> {
        self.march(bodies, flank, stretch, work, None)?;
        Ok(())
    }

    /// ∫ F_K dt + ΣP and ∫ U′ F_K dt + Σ U′P over the last communication step, which ends at `end` [s]. They are
    /// computed when somebody asks: the step is taken once more, now with the integrals.
    pub fn sums(
        &self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        (end, horizon): (f64, f64),
        work: &mut Work,
    ) -> Result<Sums, Fault> {
        let mut again = self.again(bodies, flank);
        let mut log = EventLog::counting();
        let mut integral = Integral { from: again.theta(self.begin.1), sums: self.pushed };
        let mut stretch = Stretch { end, horizon, log: &mut log };
        again.march(bodies, flank, &mut stretch, work, Some(&mut integral))?;
        let theta = again.theta(end);
        integral.add(bodies, flank, &again.panel, theta);
        Ok(integral.sums)
    }

    /// The run as it was when the last communication step began.
    fn again(&self, bodies: &Bodies, flank: &impl FlankMotion) -> Run {
        let origin = if self.begin_is_current { self.origin() } else { self.begin.0 };
        Run { panel: origin.panel(bodies, flank, self.rules), zeros: origin.from.2, longest: origin.longest, ..*self }
    }

    /// Passes panel after panel up to the one that holds the end of the stretch; how far into it that is [s].
    fn march(
        &mut self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        stretch: &mut Stretch,
        work: &mut Work,
        mut integral: Option<&mut Integral>,
    ) -> Result<f64, Fault> {
        let (mut events, mut panels) = (0.0, 0.0);
        let (begin, whole) = (self.panel.start, self.panel.until(stretch.end));
        loop {
            let left = self.panel.until(stretch.end);
            let limit = self.panel.limit();
            if limit > left || (limit == left && self.panel.event.is_none()) {
                return Ok(left);
            }
            if let Some(integral) = &mut integral {
                integral.add(bodies, flank, &self.panel, limit);
            }
            self.pass_panel(bodies, limit);
            events += if self.panel.event.is_some() { 1.0 } else { 0.0 };
            let sums = match self.panel.event {
                None => self.leave_panel(bodies, flank, stretch),
                Some((Found::Release, at)) => self.release(bodies, flank, at, stretch),
                Some((Found::Impact(hit), at)) => self.impact(bodies, flank, hit, at, stretch),
            };
            if let Some(integral) = &mut integral {
                integral.sums.force += sums.force;
                integral.sums.torque += sums.torque;
                integral.from = 0.0;
            }
            panels += 1.0;
            let is_stuck = panels > STUCK && (self.panel.start - begin).hi <= f64::EPSILON * whole;
            if work.draw(self.panel.cost).is_err() || is_stuck {
                let hint = format!(
                    "lower the speed, or choose a softer spring, heavier masses or a smaller `e` = {}: {events} switching \
                     instants have passed, the natural frequencies are {} rad/s in contact and {} rad/s in flight",
                    bodies.e,
                    Rounded(bodies.bound.stiffness().sqrt()),
                    Rounded(bodies.relative.stiffness().sqrt())
                );
                let speed = flank.turning(self.panel.start);
                return Err(too_much([begin.hi, stretch.end], self.panel.start.hi, ("the cam", speed), &hint));
            }
        }
    }

    fn leave_panel(&mut self, bodies: &Bodies, flank: &impl FlankMotion, stretch: &mut Stretch) -> Sums {
        let (start, length, from) = (self.panel.start, self.panel.length, self.panel.mode);
        let state = self.panel.at(bodies, length).state;
        let (mut mode, mut zeros) = (from, 0);
        let place = (start + Double::from(length), self.panel.next_segment);
        if let (Mode::Contact(contact), false) =
            (mode, self.panel.segment == self.panel.next_segment || self.rules.locked)
        {
            // At a breakpoint of the law ü may jump, and F_K with it.
            let u = flank.at(place.1, place.0);
            (mode, zeros) = bodies.settle(contact, state.q, &u, bodies.resolution(flank, place.0));
            if mode == Mode::Free {
                self.spread.carry(bodies, from);
                stretch.log.push(release(contact, place.0, ("force", bodies.force(state.q, &u)[0], "N")));
            }
        }
        self.restart(bodies, flank, place, (mode, in_place(bodies, from, state), zeros), stretch.horizon_from(place.0));
        Sums::default()
    }

    fn release(&mut self, bodies: &Bodies, flank: &impl FlankMotion, mut at: f64, stretch: &mut Stretch) -> Sums {
        let Mode::Contact(contact) = self.panel.mode else { return Sums::default() };
        self.spread.carry(bodies, self.panel.mode);
        let (state, u) = self.panel.event_at(bodies, flank, at);
        let mut state = in_place(bodies, self.panel.mode, state);
        let [force, rate, _] = bodies.force(state.q, &u);
        // The flight begins without any force, and the series of F_K has two terms less than that of q.
        let better = at - force / rate;
        if better > 0.0 && (better - at).abs() <= NEARBY * self.panel.span {
            at = better;
            state = in_place(bodies, self.panel.mode, self.panel.at(bodies, at).state);
        }
        let place = (self.panel.instant(at), self.panel.segment);
        stretch.log.push(release(contact, place.0, ("der(force)", rate, "N/s")));
        self.restart(bodies, flank, place, (Mode::Free, state, 3), stretch.horizon_from(place.0));
        Sums::default()
    }

    fn impact(
        &mut self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        hit: Flank,
        at: f64,
        stretch: &mut Stretch,
    ) -> Sums {
        let (mut state, u) = self.panel.event_at(bodies, flank, at);
        let place = (self.panel.instant(at), self.panel.segment);
        let ((mode, zeros), sums) = self.strike(bodies, flank, hit, &mut state, &u, place, stretch.log);
        self.restart(bodies, flank, place, (mode, state, zeros), stretch.horizon_from(place.0));
        sums
    }

    /// Counts the impulse with which m1 follows a flank whose motion jumps; `slope` = U′.
    pub fn push(&mut self, impulse: f64, slope: f64) {
        self.tally.impulse += impulse;
        self.pushed.force += impulse;
        self.pushed.torque += slope * impulse;
    }

    /// The impact with which a jump of the inputs ends, counted as its impulse.
    pub fn strike_at_jump(
        &mut self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        hit: Flank,
        state: &mut State,
        place: (Double, usize),
        log: &mut EventLog,
    ) -> (Mode, usize) {
        let u = flank.at(place.1, place.0);
        let (after, sums) = self.strike(bodies, flank, hit, state, &u, place, log);
        self.pushed.force += sums.force;
        self.pushed.torque += sums.torque;
        after
    }

    /// The impact of a mass in `state` on `hit`, which moves with `u`: counts it and returns what follows, with the impulses.
    #[allow(clippy::too_many_arguments)]
    fn strike(
        &mut self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        hit: Flank,
        state: &mut State,
        u: &Kinematics,
        (time, segment): (Double, usize),
        log: &mut EventLog,
    ) -> ((Mode, usize), Sums) {
        let rate = flank.rate(segment, time, 0.0);
        let before = Side::of(bodies, Mode::Free, state, u);
        self.spread.carry(bodies, Mode::Free);
        let impact = bodies.impact(hit, state, u, rate, bodies.resolution(flank, time));
        let after = Side::of(bodies, impact.after, state, u);
        self.spread.strike(bodies.e, &before, &after, impact.after != Mode::Free);
        self.tally.impulse += impact.impulse;
        self.tally.impacts += 1.0;
        self.tally.energy_loss += impact.loss;
        self.tally.damping_loss += impact.damped;
        let kind = match hit {
            Flank::A => "impact on flank A",
            Flank::B => "impact on flank B",
        };
        log.push(Event { time: time.hi, kind, quantity: "impulse", value: impact.impulse, unit: "N.s", solver: false });
        if impact.bounces != 0.0 {
            log.push(Event {
                time: time.hi,
                kind: "bounces summed",
                quantity: "impulse",
                value: impact.bounces,
                unit: "N.s",
                solver: true,
            });
        }
        if impact.after == Mode::Free && impact.zeros > 1 {
            // Without a rebound m1 rests on the flank for no time at all: the force there would pull.
            log.push(release(hit, time, ("force", bodies.force(state.q, u)[0], "N")));
        }
        // Bounces summed are still to come: what they add on the way is the integral of F_K.
        let impulse = bodies.m1 * (state.zeta[1] - before.speed);
        let slope = if flank.is_uniform() && flank.speed() != 0.0 {
            u.0[1] / flank.speed()
        } else {
            flank.slope(segment, time)
        };
        ((impact.after, impact.zeros), Sums { force: impulse, torque: slope * impulse })
    }
}

/// The integrals over a communication step, taken panel by panel.
struct Integral {
    /// Where they begin in the current panel [s].
    from: f64,
    sums: Sums,
}

impl Integral {
    fn add(&mut self, bodies: &Bodies, flank: &impl FlankMotion, panel: &Panel, to: f64) {
        let [force, torque] = panel.integrals(bodies, flank, self.from, to);
        self.sums.force += force;
        self.sums.torque += torque;
    }
}

impl Origin {
    fn panel(&self, bodies: &Bodies, flank: &impl FlankMotion, rules: Rules) -> Panel {
        Panel::new(bodies, flank, self.place, self.from, self.longest, rules)
    }
}

impl Stretch<'_> {
    /// The longest panel from `time` on [s].
    fn horizon_from(&self, time: Double) -> f64 {
        if self.horizon.is_finite() { (Double::from(self.end) - time).hi.max(0.0) } else { self.horizon }
    }
}

/// The release from `flank` at `time`, with the name, value and unit of what tells that the flank would pull.
pub fn release(flank: Flank, time: Double, (quantity, value, unit): (&'static str, f64, &'static str)) -> Event {
    let kind = match flank {
        Flank::A => "release from flank A",
        Flank::B => "release from flank B",
    };
    Event { time: time.hi, kind, quantity, value, unit, solver: false }
}

/// The state with ζ exactly on the flank that m1 was on.
fn in_place(bodies: &Bodies, mode: Mode, state: State) -> State {
    match mode {
        Mode::Contact(flank) => State { home: bodies.place(flank), zeta: [0.0; 2], ..state },
        Mode::Free => state,
    }
}
