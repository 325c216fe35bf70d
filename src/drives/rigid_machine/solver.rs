//! The motion of the machine in time, for where the angle does not serve as the variable ([`super::advance`]).
//!
//! With u = √J φ̇ the equation of motion becomes
//!
//! φ̇ = u / √J(φ),  u̇ = (M_an − τ) / √J(φ),  [T_el Ṁ_an = M_Kloss(φ̇) − M_an]
//!
//! since d(½u²)/dt = (M_an − τ) φ̇. J′ has gone, so the equations are one order smoother than the original, and
//! without torques u, hence the energy, is constant to the last digit.
//!
//! Method: Gauss collocation ([`crate::numerics::collocation`]) of the increments over each internal step, which are
//! added to angle and u in double-double. Internal steps end at communication points. They also end where the angle
//! passes a border between smooth pieces of a motion law. The polynomial of the step finds that instant to about
//! the tolerance; that is more than enough, because the right-hand side is continuous there: stopping δ beside the
//! border changes the solution by the order of δ².

use super::profile::Profile;
use super::{Inertia, Kloss, Motor, RigidMachine, Signal, State};
use crate::drives::{Event, Fault, Rounded};
use crate::numerics::collocation::{Collocation, Failure, System};
use crate::numerics::double_double::{Double, two_product};
use crate::numerics::work::{EVALUATION, Work};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// How far beyond a border the angle may lie before the step is cut (rad): its square is below rounding.
const SLACK: f64 = 1e-8;

/// Changes of the interval without a step in between before a step is taken as it is. Two happen where the machine
/// turns back on a border; more could only be the work of rounding.
pub(super) const IDLE_CHANGES: u32 = 4;

/// By what the estimate in time is larger than the deviations, from random machines of which 99 of 100 stay below it. The
/// deviations suppose that coefficients go on to decay as they do in the step; a torque that follows the speed at once
/// has poles beside the speeds passed (s = ± i s_K), so that those of the torque decay less than those of the motion.
const CAUTION: f64 = 0.5;
const CAUTION_WITH_MOTOR: f64 = 3.0;

/// The speed beyond which the machine counts as run away (rad/s): ten times what may be set.
pub(super) const FASTEST: f64 = 1e7;

/// The integrator, with or without the motor's torque as third unknown.
#[derive(Clone, Serialize, Deserialize)]
pub enum Integrator {
    /// φ, u.
    Mechanical(Collocation<2>),
    /// φ, u, M_an.
    WithLag(Collocation<3>),
}

impl Integrator {
    /// A fresh integrator for this motor.
    pub fn new(motor: &Motor) -> Self {
        let zero = Double::from(0.0);
        match motor.lag() {
            None => Integrator::Mechanical(Collocation::new(zero, [0.0; 2])),
            Some(_) => Integrator::WithLag(Collocation::new(zero, [0.0; 3])),
        }
    }
}

impl Integrator {
    /// The standard deviations of φ, u and M_an.
    pub fn deviations(&self) -> [f64; 3] {
        match self {
            Integrator::Mechanical(c) => {
                let p = c.error_covariance();
                [p[0][0].sqrt(), p[1][1].sqrt(), 0.0]
            }
            Integrator::WithLag(c) => {
                let p = c.error_covariance();
                [p[0][0].sqrt(), p[1][1].sqrt(), p[2][2].sqrt()]
            }
        }
    }

    /// Goes on with these deviations of φ and u.
    pub fn set_deviations(&mut self, phi: f64, u: f64) {
        if let Integrator::Mechanical(c) = self {
            c.set_error_covariance([[phi * phi, 0.0], [0.0, u * u]]);
        }
    }
}

/// The equations of motion on one smooth piece, for the increments of φ, u and M_an over a step.
pub(super) struct Piece<'a> {
    inertia: &'a Inertia,
    motor: &'a Motor,
    load: &'a Signal,
    driving: &'a Signal,
    profile: &'a Profile,
    base: &'a State,
    /// How long after the communication point the time of the integrator begins (s).
    since: f64,
    /// The most that φ may change in a step (rad).
    pub reach: f64,
}

impl Piece<'_> {
    /// φ after this increment (rad).
    fn angle(&self, increment: f64) -> f64 {
        self.base.angle.hi + (self.base.angle.lo + increment)
    }

    /// √J after this increment.
    fn root(&self, increment: f64) -> f64 {
        self.profile.value(self.inertia, self.base.interval, self.angle(increment)).sqrt()
    }

    fn u(&self, increment: f64) -> f64 {
        self.base.u.hi + (self.base.u.lo + increment)
    }

    /// M_an and its derivative with respect to the speed.
    fn torque(&self, t: Double, w: f64, lagging: Option<&f64>) -> [f64; 2] {
        if let Some(increment) = lagging {
            return [self.base.torque + increment, 0.0];
        }
        if *self.motor == Motor::Input {
            return [self.driving.at(self.since + t.hi), 0.0];
        }
        let [torque, slope, _] = self.motor.characteristic(w);
        [torque, slope]
    }
}

impl<const N: usize> System<N> for Piece<'_> {
    fn rhs(&self, t: Double, y: &[f64; N]) -> [f64; N] {
        let root = self.root(y[0]);
        let w = self.u(y[1]) / root;
        let [torque, _] = self.torque(t, w, y.get(2));
        let mut rate = [0.0; N];
        rate[0] = w;
        rate[1] = (torque - self.load.at(self.since + t.hi)) / root;
        if let (Some(rate), Some(lag)) = (rate.get_mut(2), self.motor.lag()) {
            *rate = (self.motor.characteristic(w)[0] - torque) / lag;
        }
        rate
    }

    fn jacobian(&self, t: Double, y: &[f64; N]) -> [[f64; N]; N] {
        let [j, slope] = self.profile.with_slope(self.inertia, self.base.interval, self.angle(y[0]));
        let root = j.sqrt();
        let w = self.u(y[1]) / root;
        let [torque, torque_slope] = self.torque(t, w, y.get(2));
        // The derivative of ln(1/√J).
        let bend = -0.5 * slope / j;
        let mut m = [[0.0; N]; N];
        (m[0][0], m[0][1]) = (w * bend, 1.0 / root);
        m[1][0] = ((torque - self.load.at(self.since + t.hi)) + torque_slope * w) * bend / root;
        m[1][1] = torque_slope / j;
        if let (true, Some(lag)) = (N > 2, self.motor.lag()) {
            let slope = self.motor.characteristic(w)[1];
            m[1][N - 1] = 1.0 / root;
            (m[N - 1][0], m[N - 1][1]) = (slope * w * bend / lag, slope / (root * lag));
            m[N - 1][N - 1] = -1.0 / lag;
        }
        m
    }

    /// Angles are judged by the radian, u by itself, a lagging torque by the breakdown torque.
    fn magnitude(&self, y: &[f64; N]) -> [f64; N] {
        let mut magnitude = [1.0; N];
        magnitude[1] = self.u(y[1]).abs();
        if let (Some(magnitude), Motor::Kloss(Kloss { breakdown_torque, .. })) = (magnitude.get_mut(2), self.motor) {
            *magnitude = breakdown_torque.max(self.base.torque.abs());
        }
        magnitude
    }

    /// The time in which φ changes by `reach` under the present acceleration.
    fn longest_step(&self, t: Double, y: &[f64; N]) -> f64 {
        if self.reach.is_infinite() {
            return f64::INFINITY;
        }
        let rate = self.rhs(t, y);
        let (w, a) = (rate[0].abs(), (rate[1] / self.root(y[0])).abs());
        2.0 * self.reach / (w + (w * w + 2.0 * a * self.reach).sqrt())
    }
}

/// The fraction θ ∈ [0, `upto`] of the last step at which `g`, of different signs at the ends, changes its sign.
fn bisect(upto: f64, g: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, upto);
    let negative = g(upto) < 0.0;
    // Halving sixty times leaves neighbouring numbers.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (g(middle) < 0.0) == negative {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// Adds what the last step has erred by to the covariance of the error.
pub(super) fn add_end_error<const N: usize>(c: &mut Collocation<N>) {
    let mut covariance = c.error_covariance();
    for (k, own) in c.end_error().into_iter().enumerate() {
        covariance[k][k] += own * own;
    }
    c.set_error_covariance(covariance);
}

/// What a step that was just taken met.
#[derive(Clone, Copy)]
pub(super) struct Encounter {
    /// The fraction of the step at which the shaft turned back.
    pub reversal: Option<f64>,
    /// The fraction at which the angle left the interval, and whether upwards.
    pub exit: Option<(f64, bool)>,
}

pub(super) fn encounter<const N: usize>(c: &Collocation<N>, state: &State, (low, high): (f64, f64)) -> Encounter {
    let angle = |fraction: f64| state.angle.hi + c.at_fraction(fraction)[0];
    let u = |fraction: f64| state.u.hi + c.at_fraction(fraction)[1];
    let reversal = (u(1.0) * state.u.hi < 0.0).then(|| bisect(1.0, u));
    let exit = reversal.into_iter().chain([1.0]).find_map(|fraction| {
        let reached = angle(fraction);
        let (border, upward) = if reached > high + SLACK {
            (high, true)
        } else if reached < low - SLACK {
            (low, false)
        } else {
            return None;
        };
        let out = |fraction: f64| if upward { angle(fraction) - border } else { border - angle(fraction) };
        Some((if out(0.0) >= 0.0 { 0.0 } else { bisect(fraction, out) }, upward))
    });
    Encounter { reversal, exit }
}

impl RigidMachine {
    /// The equations from the state on, in a time that begins `since` (s) after the communication point.
    pub(super) fn piece(&self, since: f64) -> Piece<'_> {
        // A wave of J within a step leaves eight nodes per wave, and what lies beyond the interval is not to be
        // followed far: there a law goes on that no longer holds.
        let (low, high) = self.inertia.ends(self.state.interval);
        let wave = if self.inertia.varies() { TAU / self.inertia.resolution() } else { f64::INFINITY };
        let reach = wave.min(high - low);
        Piece {
            inertia: &self.inertia,
            motor: &self.motor,
            load: &self.load,
            driving: &self.driving,
            profile: &self.mesh.profile,
            base: &self.state,
            since,
            reach,
        }
    }

    /// Integrates in time along the `way` from one time to another [s after the communication point `time`], or, where `may_pass`, until
    /// the shaft turns fast enough for steps in the angle; returns where it stopped.
    pub(super) fn run_in_time(
        &mut self,
        time: f64,
        way: [Double; 2],
        may_pass: bool,
        work: &mut Work,
    ) -> Result<Double, Fault> {
        // The integrator stays where it is if the step fails; after a fault the machine is used no more.
        match self.integrator.clone() {
            Integrator::Mechanical(mut c) => {
                let reached = self.run(&mut c, time, way, may_pass, work)?;
                self.integrator = Integrator::Mechanical(c);
                self.estimate_in_time();
                Ok(reached)
            }
            Integrator::WithLag(mut c) => {
                let reached = self.run(&mut c, time, way, may_pass, work)?;
                self.integrator = Integrator::WithLag(c);
                self.estimate_in_time();
                Ok(reached)
            }
        }
    }

    /// Takes the deviations at the end of a step in time into the estimate.
    fn estimate_in_time(&mut self) {
        let scales = [self.travelled, self.top_speed];
        self.estimate(self.integrator.deviations(), self.inertia_now(), self.state.w, scales);
    }

    /// Takes deviations of φ, u and M_an into the estimate where J, J′ and φ̇ are these: of φ relative to the angle passed,
    /// of φ̇ to the greatest speed and of a lagging torque to the breakdown torque.
    pub(super) fn estimate(&mut self, [phi, u, torque]: [f64; 3], [j, slope]: [f64; 2], w: f64, scales: [f64; 2]) {
        let [travelled, top_speed] = scales;
        let of_w = u / j.sqrt() + (0.5 * slope / j * w).abs() * phi;
        let (breakdown, caution) = match self.motor {
            Motor::Kloss(Kloss { breakdown_torque, dynamics: None, .. }) => (breakdown_torque, CAUTION_WITH_MOTOR),
            Motor::Kloss(Kloss { breakdown_torque, .. }) => (breakdown_torque, CAUTION),
            Motor::None | Motor::Input => (1.0, CAUTION),
        };
        let of_speed = of_w / top_speed.max(f64::MIN_POSITIVE);
        let estimate = (phi / travelled.max(1.0)).max(of_speed).max(torque / breakdown.max(f64::MIN_POSITIVE));
        self.solver.error_estimate = self.solver.error_estimate.max(caution * estimate);
    }

    fn run<const N: usize>(
        &mut self,
        c: &mut Collocation<N>,
        time: f64,
        [from, target]: [Double; 2],
        may_pass: bool,
        work: &mut Work,
    ) -> Result<Double, Fault> {
        let spent = c.statistics;
        c.restart(from, [0.0; N]);
        let mut idle = 0;
        // The linear equations of a step grow with the square of the unknowns.
        let cost = EVALUATION * (N * N) as f64 / 4.0 + self.inertia.cost();
        while (target - c.end()).hi > 0.0 {
            let evaluations = c.statistics.evaluations;
            c.restart(c.end(), [0.0; N]);
            let before = c.end();
            let covariance = c.error_covariance();
            self.step(c, time, target)?;
            let met = encounter(c, &self.state, self.inertia.ends(self.state.interval));
            let length = (c.end() - before).hi;
            match met.exit {
                Some((fraction, upward)) if idle < IDLE_CHANGES => {
                    let crossing = before + Double::from(fraction * length);
                    c.retract();
                    c.set_error_covariance(covariance);
                    self.step(c, time, crossing)?;
                    self.absorb(c, time, None)?;
                    // A table has so many borders that every step may end on one; only those that take no time count.
                    idle = if (c.end() - before).hi > 0.0 { 0 } else { idle + 1 };
                    if c.end() == crossing {
                        self.change_interval(upward);
                    }
                }
                _ => {
                    self.absorb(c, time, met.reversal.map(|f| (before + Double::from(f * length)).hi))?;
                    idle = 0;
                }
            }
            // A step that evaluated nothing would be taken for ever.
            let evaluations = (c.statistics.evaluations - evaluations).max(1);
            work.draw(cost * evaluations as f64)
                .map_err(|_| self.too_long([time, time + target.hi], time + c.end().hi))?;
            if may_pass && self.turns_fast() {
                break;
            }
        }
        let s = &c.statistics;
        self.solver.steps += (s.steps - spent.steps) as f64;
        self.solver.evaluations += (s.evaluations - spent.evaluations) as f64;
        Ok(c.end())
    }

    /// One step of the integrator towards `limit` that the shaft makes within the reach of the nodes.
    fn step<const N: usize>(&self, c: &mut Collocation<N>, time: f64, mut limit: Double) -> Result<(), Fault> {
        let piece = self.piece(0.0);
        let tolerance = self.solver.effective_tolerance();
        let covariance = c.error_covariance();
        loop {
            c.step(&piece, limit, tolerance).map_err(|failure| self.fault(failure, time))?;
            // A load that grows during the step takes the shaft further than its first acceleration told.
            if c.state()[0].abs() <= 2.0 * piece.reach {
                return Ok(());
            }
            let length = (c.end() - c.start()).hi;
            limit = c.start() + Double::from(0.5 * length);
            c.retract();
            c.set_error_covariance(covariance);
        }
    }

    /// Adds the increments of the last step to the state.
    fn absorb<const N: usize>(
        &mut self,
        c: &mut Collocation<N>,
        time: f64,
        reversal: Option<f64>,
    ) -> Result<(), Fault> {
        add_end_error(c);
        let increment = c.state();
        self.add(&increment);
        self.travelled += increment[0].abs();
        self.top_speed = self.top_speed.max(self.state.w.abs());
        if !(self.state.w.abs() <= FASTEST) {
            return Err(self.fault(Failure::Unbounded { time: c.end().hi }, time));
        }
        if let Some(at) = reversal {
            self.record_reversal(time + at);
        }
        Ok(())
    }

    /// Adds increments of φ, u and M_an to the state.
    pub(super) fn add<const N: usize>(&mut self, increment: &[f64; N]) {
        self.state.angle = self.state.angle + Double::from(increment[0]);
        self.state.u = self.state.u + Double::from(increment[1]);
        self.state.torque += increment.get(2).copied().unwrap_or(0.0);
        if self.inertia.borders().is_empty() {
            self.take_turns((self.state.angle.hi / TAU).round());
        }
        self.state.w = self.state.u.hi / self.inertia_now()[0].sqrt();
    }

    /// Tells of the shaft's reversal at `time` (s).
    pub(super) fn record_reversal(&mut self, time: f64) {
        self.events.push(Event {
            time,
            kind: "reversal of the shaft",
            quantity: "acceleration",
            value: self.net_torque(0.0) / self.inertia_now()[0],
            unit: "rad/s2",
            solver: false,
        });
    }

    /// Moves whole turns from the angle to their counter.
    pub(super) fn take_turns(&mut self, turns: f64) {
        if turns != 0.0 {
            // 2π in two parts.
            let angle = two_product(turns, TAU) + two_product(turns, 2.4492935982947064e-16);
            self.state.angle = self.state.angle - angle;
            self.state.turns += turns;
        }
    }

    /// The shaft passed a border of its interval.
    pub(super) fn change_interval(&mut self, upward: bool) {
        let last = self.inertia.borders().len() - 1;
        self.state.interval = match (self.state.interval, upward) {
            (i, true) if i == last => {
                self.take_turns(1.0);
                0
            }
            (i, true) => i + 1,
            (0, false) => {
                self.take_turns(-1.0);
                last
            }
            (i, false) => i - 1,
        };
    }

    pub(super) fn fault(&self, failure: Failure, time: f64) -> Fault {
        Fault(match failure {
            Failure::Stalled { time: after } => format!(
                "the motion cannot be continued at t = {} s (phi = {} rad, w = {} rad/s): no internal step keeps the tolerance; the torques change too fast",
                Rounded(time + after),
                Rounded(self.state.angle.hi),
                Rounded(self.state.w)
            ),
            Failure::Unbounded { time: after } => format!(
                "the machine runs away: at t = {} s its speed exceeds {FASTEST:e} rad/s; check `tau` and `J0`",
                Rounded(time + after)
            ),
        })
    }
}
