//! Events at the end of a step.

use super::{End, Event, Excitation, Run};
use crate::drives::follower::contact::{Flank, Mode};
use crate::drives::follower::joint::Change;
use crate::drives::shaft::cam_drive::goes_on;
use crate::drives::shaft::train::switching::{Instant, Strike};
use crate::drives::shaft::train::{Dynamics, Functions, MOST_FOLLOWERS, MOST_STATES, Modes, Train};
use crate::drives::{About, Event as Entry, EventLog, Fault};
use crate::numerics::double_double::Double;

/// Bounces end in contact when the remaining ones take less than this part of the time in which the pressing force changes; their
/// impulse is summed. Bounces of one follower may open the contact of another: with 1e-7, enough for a single follower, the
/// impulses of two that chatter at once are off by 2e-10.
const CLOSURE: f64 = 1e-10;

/// Impacts whose bounces last less than this part of that time do not count: m1 stays.
const FAINT: f64 = 1e-14;

/// The quantity logged with an event.
struct Figure {
    quantity: &'static str,
    value: f64,
    unit: &'static str,
}

impl Figure {
    fn angle(value: f64) -> Self {
        Figure { quantity: "angle", value, unit: "rad" }
    }

    fn impulse(value: f64) -> Self {
        Figure { quantity: "impulse", value, unit: "N.s" }
    }

    fn force(value: f64) -> Self {
        Figure { quantity: "force", value, unit: "N" }
    }
}

/// m1 of follower j at a flank that it has hit: its bounces end when the remaining ones take less than this part of the time in
/// which the pressing force changes.
struct Bounce {
    j: usize,
    flank: Flank,
    part: f64,
}

/// A jump of cam and flank of a follower.
struct Jump {
    /// The jumps of place (m) and velocity (m/s).
    moved: [f64; 2],
    /// The roundings of these differences.
    rounding: [f64; 2],
    /// U′ after the jump.
    slope: f64,
    /// Whether inputs cause it.
    is_input: bool,
}

impl End {
    /// Finds the segments of all laws anew.
    pub fn locate(&mut self, train: &Train) {
        let [phi, w] = self.shaft;
        self.modes.segments = train.segments(&train.angles(Double::from(phi), &self.states), w >= 0.0);
    }
}

impl Run {
    /// Carries out the event at the end of the step.
    pub(super) fn happen(&mut self, train: &Train, excitation: &Excitation, event: Event, log: &mut EventLog) {
        let Instant { phi, y, .. } = self.here(train, excitation);
        let jumps = matches!(event, Event::Border(..) | Event::Follower(_, Change::Impact(_)))
            && !self.errors.values.is_empty();
        let flight = match event {
            Event::Follower(j, Change::Impact(_)) => self.errors.flight(j, self.start.hi),
            _ => f64::INFINITY,
        };
        let before = jumps.then(|| (self.rates(train, excitation), flight));
        match event {
            Event::Border(which, ahead) => {
                let angles = train.angles(phi, &y);
                train.cross(&mut self.modes, &angles, which, ahead);
                self.settle(train, excitation, None, log);
            }
            Event::Follower(j, Change::Release) => {
                self.open(j, 3);
                self.log(log, "release", j + 1, Figure::angle(phi.hi));
                self.settle(train, excitation, Some(j), log);
            }
            Event::Follower(j, Change::Impact(flank)) => self.hit(train, excitation, (j, flank), log),
            Event::Limit(sign) => {
                self.modes.saturation = sign;
                let kind =
                    if sign == 0 { "torque of the servo below its limit" } else { "torque of the servo at its limit" };
                self.log(log, kind, 0, Figure::angle(phi.hi));
            }
            Event::Knot(piece) => self.modes.piece = piece,
        }
        if let Some(before) = before {
            self.carry_over(train, excitation, event, before);
        }
    }

    /// The train at the start of the step.
    pub(super) fn here(&self, train: &Train, excitation: &Excitation) -> Instant {
        let mut y = [0.0; MOST_STATES];
        self.from(&mut y);
        Instant {
            phi: self.phi(excitation, self.start, &y),
            input_values: self.input_values(train, excitation, self.start, &y),
            y,
        }
    }

    /// Sets the states that an event has changed; the others keep their low parts.
    fn take(&mut self, y: &[f64]) {
        let changed = self.states.iter_mut().zip(y).filter(|(state, y)| state.hi != **y);
        changed.for_each(|(state, y)| *state = Double::from(*y));
    }

    fn log(&self, log: &mut EventLog, kind: &'static str, follower: usize, figure: Figure) {
        let Figure { quantity, value, unit } = figure;
        log.push(Entry { time: self.start.hi, kind, quantity, value, unit, follower, about: About::Machine });
    }

    /// Opens the contact of m1 of follower j; the gap begins with a zero of this order.
    fn open(&mut self, j: usize, zeros: usize) {
        let stand = &mut self.modes.stands[j];
        (stand.contact, stand.zeros) = (Mode::Free, zeros);
        self.errors.open(j, self.start.hi);
    }

    /// The modes at the start: segments, pieces, flanks.
    ///
    /// # Errors
    /// The train is to start `at_rest` under loads that it cannot balance.
    pub fn choose_modes(
        &mut self,
        train: &Train,
        excitation: &Excitation,
        balanced: bool,
        log: &mut EventLog,
    ) -> Result<(), Fault> {
        let (mut now, d) = (self.here(train, excitation), self.locate(train, excitation));
        if let Some(motor) = train.machine().map(|machine| &machine.motor) {
            if let Some(table) = motor.table() {
                self.modes.piece = table.piece(d.demand);
            }
            self.modes.saturation = motor.saturation(d.demand);
        }
        if balanced {
            train.rest(&mut self.modes, &mut now)?;
            self.states.iter_mut().zip(now.y).for_each(|(state, y)| *state = Double::from(y));
            self.settle(train, excitation, None, log);
        } else {
            self.press(train, excitation, log);
        }
        Ok(())
    }

    /// The segments of all laws at the start of the step; returns the shaft's acceleration and the other dynamics there.
    pub fn locate(&mut self, train: &Train, excitation: &Excitation) -> Dynamics<f64> {
        let now = self.here(train, excitation);
        let angles = train.angles(now.phi, &now.y);
        // At rest the acceleration shows the sense in which the shaft will turn.
        self.modes.segments = train.segments(&angles, true);
        let (_, d) = train.instant(&self.modes, now.phi, &now.y, &now.input_values);
        let w = train.speed(&now);
        let forward = if w != 0.0 { w > 0.0 } else { d.a >= 0.0 };
        self.modes.segments = train.segments(&angles, forward);
        d
    }

    /// Decides by the present inputs and parameters about the limit of a servo and the contacts.
    pub fn decide(&mut self, train: &Train, excitation: &Excitation, log: &mut EventLog) {
        if let Some(motor) = train.machine().map(|machine| &machine.motor) {
            let now = self.here(train, excitation);
            let (_, d) = train.instant(&self.modes, now.phi, &now.y, &now.input_values);
            let sign = motor.saturation(d.demand);
            // At the limit itself roundings would decide.
            if sign != self.modes.saturation && !matches!(self.since, Some(Event::Limit(_))) {
                self.happen(train, excitation, Event::Limit(sign), log);
            }
        }
        self.settle(train, excitation, None, log);
    }

    /// Places followers with backlash on the flanks that press them; without a pressing force they fly.
    pub fn press(&mut self, train: &Train, excitation: &Excitation, log: &mut EventLog) {
        for (j, ..) in train.clearances() {
            self.modes.stands[j].contact = Mode::Contact(Flank::A);
        }
        // The flank of each depends on the others.
        for _ in 0..train.followers.len() {
            let at_flank = self.at_flanks(None);
            let (forces, _) = train.pressing(&self.modes, &at_flank, &self.here(train, excitation));
            let mut changed = false;
            for (j, flank, p) in train.touching(&at_flank) {
                if flank == Flank::A && forces[j] < 0.0 && p.s.is_finite() {
                    let stand = &mut self.modes.stands[j];
                    (stand.contact, stand.beyond) = (Mode::Contact(Flank::B), true);
                    changed = true;
                }
            }
            if !changed {
                break;
            }
        }
        self.settle(train, excitation, None, log);
    }

    /// A jump of the shaft from its state at the `end` of the last step to the values of its inputs. Masses keep place and
    /// velocity. A mass in contact follows its flank, and the momentum that it takes up counts as impulse; a cam without flank B,
    /// which cannot pull, leaves the mass its velocity. A free mass beyond a flank after the jump is set on it, and hits it if it
    /// moves towards it. The jump `begins` a step and its sums, or only serves the outputs. False if the shaft goes on without a
    /// jump.
    pub fn jump(
        &mut self,
        train: &Train,
        excitation: &Excitation,
        (end, begins): (&End, bool),
        log: &mut EventLog,
    ) -> bool {
        let Some(motion) = excitation.motion else { return false };
        let [phi, w, a, ..] = motion.at(excitation.time).kinematics.0;
        let jumps = !goes_on([end.shaft[0], end.shaft[1], a], [phi, w], excitation.time);
        (self.start, self.length, self.event, self.since) = (Double::from(end.time), 0.0, None, None);
        self.summed = 0.0;
        (self.modes, self.tallies) = (end.modes, end.tallies);
        if begins {
            self.tallies.iter_mut().for_each(|tally| tally.sums = [0.0; 2]);
        }
        let before = train.angles(Double::from(end.shaft[0]), &end.states);
        let cams = |modes: &Modes, angles: &[f64]| Functions::at(train, modes, angles).cams;
        let old = cams(&self.modes, &before);
        let mut y = [0.0; MOST_STATES];
        y[..end.states.len()].copy_from_slice(&end.states);
        let [turn, speed] = [phi - end.shaft[0], w - end.shaft[1]];
        for (j, follower) in train.followers.iter().enumerate() {
            if follower.joint.carries_cam() {
                let at = train.layout.followers[j];
                (y[at], y[at + 1]) = (y[at] - turn, y[at + 1] - speed);
            }
        }
        let angles = train.angles(Double::from(phi), &y);
        self.modes.segments = train.segments(&angles, w >= 0.0);
        let new = cams(&self.modes, &angles);
        let mut struck = [None; MOST_FOLLOWERS];
        for j in 0..train.followers.len() {
            let [from, to] = [[old[j][0], old[j][1] * end.shaft[1]], [new[j][0], new[j][1] * w]];
            let jump = Jump {
                moved: [to[0] - from[0], to[1] - from[1]],
                rounding: [0, 1].map(|n| 8.0 * f64::EPSILON * (from[n].abs() + to[n].abs())),
                slope: new[j][1],
                is_input: jumps,
            };
            struck[j] = self.displace(train, j, &jump, &mut y, log);
        }
        self.states.iter_mut().zip(y).for_each(|(state, y)| *state = Double::from(y));
        for (j, flank) in struck.into_iter().enumerate().filter_map(|(j, flank)| Some((j, flank?))) {
            self.hit(train, excitation, (j, flank), log);
        }
        self.settle(train, excitation, None, log);
        if !begins {
            self.tallies.iter_mut().zip(&end.tallies).for_each(|(tally, end)| tally.sums = end.sums);
            self.rebuild(train, excitation);
        }
        jumps
    }

    /// Moves follower j as a jump does; returns the flank that a free mass then hits.
    fn displace(
        &mut self,
        train: &Train,
        j: usize,
        jump: &Jump,
        y: &mut [f64; MOST_STATES],
        log: &mut EventLog,
    ) -> Option<Flank> {
        let (at, &Jump { moved, rounding, slope, is_input }) = (train.layout.followers[j], jump);
        let mut follow = |at: usize| (y[at], y[at + 1]) = (y[at] - moved[0], y[at + 1] - moved[1]);
        let mut struck = None;
        let joint = &train.followers[j].joint;
        match (joint.clearance(), self.modes.stands[j].contact) {
            (None, _) if joint.sprung().is_some() => follow(at),
            (Some(p), Mode::Contact(_)) => {
                let pulls = is_input && p.s.is_infinite() && moved[1] < 0.0;
                if p.m2 > 0.0 {
                    y[at + 2] -= moved[0];
                    y[at + 3] -= if pulls { 0.0 } else { moved[1] };
                }
                if pulls {
                    y[at + 1] = -moved[1];
                    self.open(j, 1);
                    self.log(log, "release", j + 1, Figure::impulse(p.m1 * moved[1]));
                } else {
                    self.count(j, p.m1 * moved[1], slope);
                }
            }
            (Some(p), Mode::Free) => {
                follow(at);
                for flank in [Flank::A, Flank::B] {
                    let sign = flank.sign();
                    let beyond = flank.pick(0.0, p.s) - self.modes.stands[j].home(p.s) - y[at];
                    let rests = beyond.abs() <= rounding[0] && y[at + 1].abs() <= rounding[1];
                    if rests || sign * beyond > 0.0 {
                        (y[at], self.modes.stands[j].beyond) = (0.0, flank == Flank::B);
                        y[at + 1] *= if rests { 0.0 } else { 1.0 };
                        if p.m2 > 0.0 {
                            y[at + 2] -= beyond;
                        }
                        struck = (sign * y[at + 1] < 0.0).then_some(flank);
                        break;
                    }
                }
                if y[at + 1] != 0.0 {
                    self.modes.stands[j].zeros = 0;
                }
            }
            _ => {}
        }
        struck
    }

    /// The followers at their flanks.
    fn at_flanks(&self, but: Option<usize>) -> [Option<Flank>; MOST_FOLLOWERS] {
        std::array::from_fn(|j| match self.modes.stands[j].contact {
            Mode::Contact(flank) if but != Some(j) => Some(flank),
            _ => None,
        })
    }

    /// Decides which of the followers that touch a flank without velocity stay there.
    fn settle(&mut self, train: &Train, excitation: &Excitation, but: Option<usize>, log: &mut EventLog) {
        let mut at_flank = self.at_flanks(but);
        for (j, at, _) in train.clearances().filter(|(j, ..)| but != Some(*j)) {
            let stand = self.modes.stands[j];
            if !stand.is_held() && self.states[at..at + 2].iter().all(|state| state.hi == 0.0) {
                at_flank[j] = Some(if stand.beyond { Flank::B } else { Flank::A });
            }
        }
        if at_flank.iter().all(Option::is_none) {
            return;
        }
        let now = self.here(train, excitation);
        let ((forces, _), w) = (train.pressing(&self.modes, &at_flank, &now), train.speed(&now));
        for (j, flank, p) in train.touching(&at_flank) {
            let (pressed, resolution) = (flank.sign() * forces[j], self.recording.resolution(j, w));
            let touched = self.modes.stands[j].contact == Mode::Free;
            if pressed < -resolution && p.s > 0.0 {
                self.open(j, 2);
                if !touched {
                    self.log(log, "release", j + 1, Figure::force(forces[j]));
                }
            } else if pressed > resolution && touched {
                self.modes.stands[j].contact = Mode::Contact(flank);
            }
        }
    }

    /// The impact of follower j, and of those that hit in the same instant.
    fn hit(&mut self, train: &Train, excitation: &Excitation, (j, flank): (usize, Flank), log: &mut EventLog) {
        let mut at_flank = self.at_flanks(None);
        at_flank[j] = Some(flank);
        let mut now = self.here(train, excitation);
        let y = &mut now.y;
        for (i, at, p) in train.clearances() {
            if self.modes.stands[i].is_held() {
                continue;
            }
            for other in [Flank::A, Flank::B] {
                let away = self.modes.stands[i].home(p.s) - other.pick(0.0, p.s);
                let (gap, speed) = (other.sign() * (y[at] + away), other.sign() * y[at + 1]);
                // Another follower that arrives within the rounding of time.
                let together =
                    i != j && speed < 0.0 && gap <= -speed * f64::EPSILON * self.start.hi.abs().max(self.unit);
                if together {
                    at_flank[i] = Some(other);
                }
            }
            if let Some(hit) = at_flank[i] {
                (y[at], self.modes.stands[i].beyond) = (0.0, hit == Flank::B);
                // Rounding may show a grazing mass as receding.
                if i == j && hit.sign() * y[at + 1] > 0.0 {
                    y[at + 1] = 0.0;
                }
            }
        }
        let (f, _) = train.instant(&self.modes, now.phi, &now.y, &now.input_values);
        let slopes: [f64; MOST_FOLLOWERS] = std::array::from_fn(|i| f.cams[i][1]);
        // Two that chatter at once open each other at every bounce, to the last digit.
        if self.close(train, Bounce { j, flank, part: FAINT }, &slopes, &mut now) {
            self.take(&now.y);
            return self.settle(train, excitation, None, log);
        }
        let strike = train.strike(&self.modes, &at_flank, &now);
        train.take_up(&strike, &at_flank, &slopes, &mut now.y);
        for i in 0..train.followers.len() {
            let impulse = strike.impulses[i];
            self.count(i, impulse, slopes[i]);
            self.tallies[i].loss += strike.losses[i];
            let Some(touched) = at_flank[i] else { continue };
            let was_free = self.modes.stands[i].contact == Mode::Free;
            if was_free {
                self.tallies[i].impacts += 1.0;
                let kind = touched.pick("impact on flank A", "impact on flank B");
                self.log(log, kind, i + 1, Figure::impulse(impulse));
            }
            if strike.after[i] == 0.0 {
                self.modes.stands[i].contact = Mode::Contact(touched);
            } else {
                self.open(i, 1);
                if was_free {
                    self.close(train, Bounce { j: i, flank: touched, part: CLOSURE }, &slopes, &mut now);
                }
            }
        }
        self.take(&now.y);
        self.settle(train, excitation, None, log);
    }

    fn count(&mut self, j: usize, impulse: f64, slope: f64) {
        let tally = &mut self.tallies[j];
        tally.impulse += impulse;
        tally.sums[0] += impulse;
        tally.sums[1] += slope * impulse;
    }

    /// Ends bounces that are all but over: m1 stays, and the impulse of the remaining ones is summed.
    fn close(&mut self, train: &Train, bounce: Bounce, slopes: &[f64; MOST_FOLLOWERS], now: &mut Instant) -> bool {
        let Bounce { j, flank, part } = bounce;
        let Some(p) = train.clearance(j) else { return false };
        let mut at_flank = self.at_flanks(None);
        at_flank[j] = Some(flank);
        let rebound = now.y[train.layout.followers[j] + 1];
        let (forces, _) = train.pressing(&self.modes, &at_flank, now);
        let force = flank.sign() * forces[j];
        let (f, _) = train.instant(&self.modes, now.phi, &now.y, &now.input_values);
        let inverse = 1.0 / p.m1 + if train.machine().is_some() { slopes[j] * slopes[j] / f.inertia } else { 0.0 };
        let mass = 1.0 / inverse;
        let (last, w) = (1.0 - p.e, train.speed(now));
        // If nothing changes, the unit of time grows without limit.
        let time = part * self.unit.min(self.pace(train)).min(1.0 / w.abs());
        if !(force > 0.0 && last > 0.0 && 2.0 * rebound.abs() * mass <= time * force * last) {
            return false;
        }
        // The velocity that the remaining bounces take from m1 and the shaft.
        let impulse = -mass * rebound;
        let turn = if train.machine().is_some() { -slopes[j] * impulse / f.inertia } else { 0.0 };
        let mut impulses = [0.0; MOST_FOLLOWERS];
        train.touching(&at_flank).for_each(|(i, _, p)| impulses[i] = p.m1 * slopes[i] * turn);
        impulses[j] = impulse;
        train.take_up(&Strike { turn, impulses, ..Strike::default() }, &at_flank, slopes, &mut now.y);
        let tally = &mut self.tallies[j];
        tally.impulse += mass * rebound * (1.0 + p.e) / last;
        tally.sums[0] += impulse;
        tally.sums[1] += slopes[j] * impulse;
        tally.loss += 0.5 * mass * rebound * rebound;
        self.modes.stands[j].contact = Mode::Contact(flank);
        true
    }
}
