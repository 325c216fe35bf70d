//! The motion from panel to panel and from one switching instant to the next.
//!
//! Panels follow each other without regard to the communication points; these only read the motion. So the
//! switching instants at constant speed do not depend on the communication step, not even by a rounding.

use super::contact::{Bodies, Flank, Mode, State};
use super::flank::FlankMotion;
use super::panel::{Found, Panel};
use crate::drives::{Event, EventLog, Fault};
use crate::numerics::double_double::Double;
use serde::{Deserialize, Serialize};

/// Steps of the search, panels and quadratures in one communication step beyond which the drive gives up: some
/// seconds of computing.
pub const MOST_WORK: f64 = 1e6;

/// What is counted since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// ΣP [N·s].
    pub impulse: f64,
    /// Number of impacts.
    pub impacts: f64,
    /// Energy lost in impacts [J].
    pub energy_loss: f64,
    /// ∫ b q̇² dt [J].
    pub damping_loss: f64,
    /// Steps of the search.
    pub steps: f64,
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

/// The motion up to the communication point and its continuation as far as the search has come.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Run {
    /// The current panel.
    pub panel: Panel,
    found: Found,
    /// The integrals are taken up to here, after the start of the panel [s].
    integrated: f64,
    /// Counts since the start.
    pub tally: Tally,
    /// Integrals over the communication step.
    pub sums: Sums,
    /// Steps of the search, panels and quadratures in the current stretch.
    pub work: f64,
    /// Whether m1 cannot leave the flank: without clearance the other one holds it.
    locked: bool,
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
        (mode, state, zeros): (Mode, State, usize),
        horizon: f64,
    ) -> Self {
        let segment = flank.segment(time);
        let panel = Panel::new(bodies, flank, (time, segment), (mode, state, zeros), horizon);
        let (tally, sums) = (Tally::default(), Sums::default());
        Run { panel, found: Found::Nothing(0.0), integrated: 0.0, tally, sums, work: 0.0, locked: bodies.s == 0.0 }
    }

    /// Continues in `mode` from `state` at `time`, counts kept.
    pub fn restart(
        &mut self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        place: (Double, usize),
        from: (Mode, State, usize),
        horizon: f64,
    ) {
        self.panel = Panel::new(bodies, flank, place, from, horizon);
        (self.found, self.integrated) = (Found::Nothing(0.0), 0.0);
        self.tally.panels += 1.0;
        self.work += 1.0;
    }

    /// Goes on to the end of the communication step and returns the state there.
    pub fn advance(
        &mut self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        stretch: &mut Stretch,
    ) -> Result<State, Fault> {
        self.work = 0.0;
        let mut events = 0.0;
        loop {
            let left = (Double::from(stretch.end) - self.panel.start).hi;
            self.search(bodies, flank, left);
            match self.found {
                Found::Nothing(until) if until >= left => break,
                Found::Nothing(_) => self.leave_panel(bodies, flank, stretch),
                Found::Release(at) | Found::Impact(_, at) if at > left => break,
                Found::Release(at) => {
                    events += 1.0;
                    self.release(bodies, flank, at, stretch);
                }
                Found::Impact(hit, at) => {
                    events += 1.0;
                    self.impact(bodies, flank, hit, at, stretch);
                }
            }
            if self.work > MOST_WORK {
                return Err(Fault(format!(
                    "the step to t = {} s needs more than {MOST_WORK} internal steps; after {events} switching instants \
                     it has come to t = {} s. The natural frequencies are {} rad/s in contact and {} rad/s in flight; \
                     choose a shorter communication step, or a softer spring, heavier masses or a smaller `e` = {}",
                    stretch.end,
                    self.panel.start.hi,
                    bodies.bound.stiffness().sqrt(),
                    bodies.relative.stiffness().sqrt(),
                    bodies.e
                )));
            }
        }
        let theta = (Double::from(stretch.end) - self.panel.start).hi.clamp(0.0, self.panel.length);
        self.integrate(bodies, flank, theta);
        Ok(self.panel.at(bodies, flank, theta))
    }

    /// Searches the panel until an event is found or the search is past `left` or the end of the panel.
    fn search(&mut self, bodies: &Bodies, flank: &impl FlankMotion, left: f64) {
        while let Found::Nothing(until) = self.found {
            if self.locked {
                self.found = Found::Nothing(self.panel.length);
                return;
            }
            if until > left || until >= self.panel.length {
                return;
            }
            self.found = self.panel.search(bodies, flank, until);
            self.tally.steps += 1.0;
            self.work += 1.0;
        }
    }

    /// Takes the integrals up to `theta` after the start of the panel.
    fn integrate(&mut self, bodies: &Bodies, flank: &impl FlankMotion, theta: f64) {
        let ([force, torque, damping], work) = self.panel.integrals(bodies, flank, self.integrated, theta);
        self.work += work;
        self.sums.force += force;
        self.sums.torque += torque;
        self.tally.damping_loss += damping;
        self.integrated = self.integrated.max(theta);
    }

    fn leave_panel(&mut self, bodies: &Bodies, flank: &impl FlankMotion, stretch: &mut Stretch) {
        let panel = self.panel;
        self.integrate(bodies, flank, panel.length);
        let state = panel.at(bodies, flank, panel.length);
        let (mut mode, mut zeros) = (panel.mode, 0);
        let place = (panel.instant(panel.length), panel.next_segment);
        if let (Mode::Contact(contact), false) = (mode, panel.segment == panel.next_segment || self.locked) {
            // At a breakpoint of the law ü may jump, and F_K with it.
            let u = flank.at(place.1, place.0);
            (mode, zeros) = bodies.settle(contact, state.q, &u, bodies.resolution(flank, place.0));
            if mode == Mode::Free {
                stretch.log.push(release(contact, place.0, ("force", bodies.force(state.q, &u)[0], "N")));
            }
        }
        self.restart(
            bodies,
            flank,
            place,
            (mode, in_place(bodies, panel.mode, state), zeros),
            stretch.horizon_from(place.0),
        );
    }

    fn release(&mut self, bodies: &Bodies, flank: &impl FlankMotion, at: f64, stretch: &mut Stretch) {
        let Mode::Contact(contact) = self.panel.mode else { return };
        self.integrate(bodies, flank, at);
        let state = in_place(bodies, self.panel.mode, self.panel.at(bodies, flank, at));
        let place = (self.panel.instant(at), self.panel.segment);
        let rate = bodies.force(state.q, &flank.at(place.1, place.0))[1];
        stretch.log.push(release(contact, place.0, ("der(force)", rate, "N/s")));
        self.restart(bodies, flank, place, (Mode::Free, state, 3), stretch.horizon_from(place.0));
    }

    fn impact(&mut self, bodies: &Bodies, flank: &impl FlankMotion, hit: Flank, at: f64, stretch: &mut Stretch) {
        self.integrate(bodies, flank, at);
        let mut state = self.panel.at(bodies, flank, at);
        let place = (self.panel.instant(at), self.panel.segment);
        let (mode, zeros) = self.strike(bodies, flank, hit, &mut state, place, stretch.log);
        self.restart(bodies, flank, place, (mode, state, zeros), stretch.horizon_from(place.0));
    }

    /// Counts the impulse with which m1 follows a flank whose motion jumps; `slope` = U′.
    pub fn push(&mut self, impulse: f64, slope: f64) {
        self.tally.impulse += impulse;
        self.sums.force += impulse;
        self.sums.torque += slope * impulse;
    }

    /// The impact on `hit` of a mass in `state`: counts it and returns what follows.
    pub fn strike(
        &mut self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        hit: Flank,
        state: &mut State,
        (time, segment): (Double, usize),
        log: &mut EventLog,
    ) -> (Mode, usize) {
        let u = flank.at(segment, time);
        let rate = flank.rate(segment, time, 0.0) + bodies.relative.rates().1.max(bodies.bound.rates().1);
        let impact = bodies.impact(hit, state, &u, rate, bodies.resolution(flank, time));
        let slope = flank.slope(segment, time);
        self.tally.impulse += impact.impulse;
        self.tally.impacts += 1.0;
        self.tally.energy_loss += impact.loss;
        self.sums.force += impact.impulse - impact.counted_force;
        self.sums.torque += slope * (impact.impulse - impact.counted_force);
        let kind = match hit {
            Flank::A => "impact on flank A",
            Flank::B => "impact on flank B",
        };
        log.push(Event { time: time.hi, kind, quantity: "impulse", value: impact.impulse, unit: "N.s", solver: false });
        if impact.counted_force != 0.0 {
            log.push(Event {
                time: time.hi,
                kind: "bounces summed",
                quantity: "impulse",
                value: impact.counted_force,
                unit: "N.s",
                solver: true,
            });
        }
        if impact.after == Mode::Free && impact.zeros > 1 {
            // Without a rebound m1 rests on the flank for no time at all: the force there would pull.
            log.push(release(hit, time, ("force", bodies.force(state.q, &u)[0], "N")));
        }
        (impact.after, impact.zeros)
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
