//! The motion of the machine in time ([`super::equation`]): internal steps by the tolerance or, of the method `fixed_cost`, from
//! one point of a grid to the next.
//!
//! Method: Gauss collocation ([`crate::numerics::collocation`]) of the increments over each internal step, which are
//! added to angle and u in double-double. A communication point is read from the polynomial of the step that holds it. Steps
//! by the tolerance end at communication points; so do those of a grid where a torque changes there or depends on time, else
//! they go on beyond, and the answer does not depend on the communication step.
//!
//! Steps also end where the angle passes a border between smooth pieces of a motion law. The polynomial of the step finds that
//! instant to about the tolerance; that is more than enough, because the right-hand side is continuous there: stopping δ beside
//! the border changes the solution by the order of δ².
//!
//! Nothing is repeated for the sake of a tolerance at fixed cost: each step takes the same number of Newton iterations, and what
//! they leave counts as error.

use super::grid::Grid;
use super::{Kloss, Motor, RigidMachine, State};
use crate::drives::settings::Method;
use crate::drives::step_control::WORST;
use crate::drives::{Event, Fault, Rounded};
use crate::numerics::angle::WHOLE_TURN;
use crate::numerics::collocation::{Collocation, Failure};
use crate::numerics::double_double::{Double, two_product};
use crate::numerics::work::{EVALUATION, Work};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// How far beyond a border the angle may lie before the step is cut (rad): its square is below rounding.
const SLACK: f64 = 1e-8;

/// Changes of the interval without a step in between before a step is taken as it is. Two happen where the machine
/// turns back on a border; more could only be the work of rounding.
const IDLE_CHANGES: u32 = 4;

/// Newton iterations in a step of fixed cost. The motion differs from that at a constant speed by some part x over the angle of
/// the usual step, and four iterations leave x¹⁶ of that.
const ITERATIONS: usize = 4;

/// Factor of the estimate in time over the deviations: 99 of 100 random machines stay below it, and its median is at most 100
/// times the error.
const CAUTION: f64 = 0.4;
/// The factor where the torque follows the speed at once: it has poles beside the speeds passed (s = ± i s_K), so that its
/// coefficients decay less than those of the motion, from which the deviations are extrapolated.
const CAUTION_WITH_MOTOR: f64 = 2.4;

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

/// An expression of either integrator.
macro_rules! either {
    ($integrator:expr, $c:ident => $value:expr) => {
        match $integrator {
            Integrator::Mechanical($c) => $value,
            Integrator::WithLag($c) => $value,
        }
    };
}

/// φ, u and M_an, the latter zero where it is no unknown.
fn padded<const N: usize>(values: [f64; N]) -> [f64; 3] {
    std::array::from_fn(|k| values.get(k).copied().unwrap_or(0.0))
}

/// The standard deviations of φ, u and M_an, with `own` errors beside those carried along.
fn deviations<const N: usize>(c: &Collocation<N>, own: [f64; N]) -> [f64; 3] {
    let covariance = c.error_covariance();
    padded::<N>(std::array::from_fn(|k| (covariance[k][k] + own[k] * own[k]).sqrt()))
}

impl Integrator {
    /// A fresh integrator for this motor.
    fn new(motor: &Motor) -> Self {
        let zero = Double::from(0.0);
        match motor.lag() {
            None => Integrator::Mechanical(Collocation::new(zero, [0.0; 2])),
            Some(_) => Integrator::WithLag(Collocation::new(zero, [0.0; 3])),
        }
    }

    /// The increments of φ, u and M_an over the fraction θ of the last step.
    fn at(&self, theta: f64) -> [f64; 3] {
        either!(self, c => padded(if theta == 1.0 { c.state() } else { c.at_fraction(theta) }))
    }

    /// Adds what the last step errs by at the fraction θ, where it is left, to the covariance of the error.
    fn leave(&mut self, theta: f64) {
        either!(self, c => {
            let own = if theta == 1.0 { c.end_error() } else { c.polynomial_error() };
            c.disturb(own);
        });
    }

    /// The standard deviations of φ, u and M_an.
    pub fn deviations(&self) -> [f64; 3] {
        either!(self, c => deviations(c, Default::default()))
    }

    /// Goes on with these deviations of φ and u.
    pub fn set_deviations(&mut self, phi: f64, u: f64) {
        if let Integrator::Mechanical(c) = self {
            c.set_error_covariance([[phi * phi, 0.0], [0.0, u * u]]);
        }
    }
}

/// The integration in time.
#[derive(Clone, Serialize, Deserialize)]
pub struct TimeSteps {
    pub integrator: Integrator,
    /// The internal step that holds the communication point, where steps go on beyond it.
    span: Option<Span>,
    /// Changes of the interval without a step in between.
    idle: u32,
    /// The steps of the method `fixed_cost`.
    pub grid: Grid,
}

/// An internal step: where the integrator's polynomial begins.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct Span {
    base: State,
    from: Double,
    end: Double,
    /// The fraction at which the shaft turns back.
    reversal: Option<f64>,
    /// Whether a border is reached at the end, upwards or downwards.
    exit: Option<bool>,
    /// The fraction up to which it has been read.
    read: f64,
}

impl Span {
    fn new(base: State, from: Double, end: Double) -> Self {
        Span { base, from, end, reversal: None, exit: None, read: 0.0 }
    }

    fn length(&self) -> f64 {
        (self.end - self.from).hi
    }
}

impl TimeSteps {
    /// At the start of a machine with this motor.
    pub fn new(motor: &Motor) -> Self {
        TimeSteps { integrator: Integrator::new(motor), span: None, idle: 0, grid: Grid::default() }
    }

    /// Whether this may be the state of a machine with this motor and so many intervals between borders.
    pub fn fits(&self, motor: &Motor, intervals: usize) -> bool {
        let lags = matches!(self.integrator, Integrator::WithLag(_));
        lags == motor.lag().is_some() && self.span.is_none_or(|span| span.base.interval < intervals)
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

/// Reversal and border met by the step that was just taken.
#[derive(Clone, Copy)]
struct Encounter {
    /// The fraction of the step at which the shaft turned back.
    reversal: Option<f64>,
    /// The fraction at which the angle left the interval, and whether upwards.
    exit: Option<(f64, bool)>,
}

fn encounter<const N: usize>(c: &Collocation<N>, state: &State, (low, high): (f64, f64)) -> Encounter {
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

/// Where a step leads, and by what φ, u and M_an err at its end and between the ends besides.
struct Prospect {
    increment: [f64; 3],
    end: [f64; 3],
    between: [f64; 3],
}

impl RigidMachine {
    /// An evaluation of the equations in a step (nominal µs): the linear equations grow with the square of the unknowns.
    pub(super) fn cost_in_time(&self) -> f64 {
        let unknowns = if self.motor.lag().is_some() { 3.0 } else { 2.0 };
        EVALUATION * unknowns * unknowns / 4.0 + self.inertia.cost()
    }

    /// Integrates from one time to another, both within the communication step from `time` on (s), or, where the machine `may_pass`
    /// to steps in the angle, until the shaft turns fast enough for them; returns where it stopped.
    pub(super) fn run_in_time(
        &mut self,
        time: f64,
        [mut now, target]: [Double; 2],
        may_pass: bool,
        work: &mut Work,
    ) -> Result<Double, Fault> {
        let goes_beyond = self.solver.settings.method == Method::FixedCost && self.torques_are_constant();
        let limit = (!goes_beyond).then_some(target);
        loop {
            match self.in_time.span {
                None => {
                    let before = self.solver.evaluations;
                    self.begin_span(time, now, limit)?;
                    // A step that evaluated nothing would be taken for ever.
                    let evaluations = (self.solver.evaluations - before).max(1.0);
                    work.draw(self.cost_in_time() * evaluations)
                        .map_err(|_| self.too_long([time, target.hi], now.hi))?;
                }
                Some(span) if (target - span.end).hi <= 0.0 => {
                    self.read_span(span, target);
                    if !goes_beyond {
                        self.leave_span()?;
                    }
                    return Ok(target);
                }
                Some(span) => {
                    // What is left of the step is read, so that its end is left as every end.
                    self.read_span(span, span.end);
                    now = span.end;
                    self.leave_span()?;
                    if may_pass && self.turns_fast() {
                        return Ok(now);
                    }
                }
            }
        }
    }

    /// The step from `from` on: to a border, to `limit`, to the next point of the grid, or as far as the tolerance allows.
    fn begin_span(&mut self, time: f64, from: Double, limit: Option<Double>) -> Result<(), Fault> {
        let end = match (self.solver.settings.method, limit) {
            (Method::Adaptive, Some(limit)) => limit,
            _ => self.in_time.grid.end_of_step(from, limit),
        };
        // The integrator stays where it is if the step fails; after a fault the machine is used no more.
        let mut integrator = self.in_time.integrator.clone();
        let prospect = either!(&mut integrator, c => self.solve_span(c, time, [from, end]))?;
        self.in_time.integrator = integrator;
        // What the polynomial errs by between the ends is seen only where communication points lie there.
        self.foresee(prospect, limit.is_none());
        Ok(())
    }

    fn solve_span<const N: usize>(
        &mut self,
        c: &mut Collocation<N>,
        time: f64,
        [from, end]: [Double; 2],
    ) -> Result<Prospect, Fault> {
        let spent = c.statistics.evaluations;
        let covariance = c.error_covariance();
        let mut span = Span::new(self.state, from, end);
        loop {
            self.solve(c, &mut span, time)?;
            let met = encounter(c, &self.state, self.inertia.ends(self.state.interval));
            span.reversal = met.reversal;
            let Some((fraction, upward)) = met.exit.filter(|_| self.in_time.idle < IDLE_CHANGES) else { break };
            self.cut(from)?;
            c.set_error_covariance(covariance);
            let crossing = from + Double::from(fraction * span.length());
            if (crossing - from).hi <= 0.0 {
                self.change_interval(upward);
                self.in_time.idle += 1;
                span = Span::new(self.state, from, end);
                continue;
            }
            span.end = crossing;
            self.solve(c, &mut span, time)?;
            span.exit = (span.end == crossing).then_some(upward);
            span.reversal = encounter(c, &self.state, self.inertia.ends(self.state.interval)).reversal;
            break;
        }
        self.in_time.idle = 0;
        self.in_time.span = Some(span);
        self.solver.steps += 1.0;
        self.solver.evaluations += (c.statistics.evaluations - spent) as f64;
        Ok(Prospect {
            increment: padded(c.state()),
            end: deviations(c, c.end_error()),
            between: padded(c.polynomial_error()),
        })
    }

    /// Solves the equations over `span`, or over as much of it as the tolerance and the reach of the nodes allow.
    fn solve<const N: usize>(&mut self, c: &mut Collocation<N>, span: &mut Span, time: f64) -> Result<(), Fault> {
        let since = (span.from - Double::from(time)).hi;
        let fixed_cost = self.solver.settings.method == Method::FixedCost;
        if fixed_cost {
            self.fit_to_reach(self.longest_step::<N>(since), span.from, &mut span.end)?;
        }
        let (piece, covariance) = (self.piece(since), c.error_covariance());
        let length = span.end - span.from;
        let mut limit = length;
        loop {
            c.restart(Double::from(0.0), [0.0; N]);
            let solved = if fixed_cost {
                c.step_of_fixed_cost(&piece, limit, ITERATIONS, WORST)
            } else {
                c.step(&piece, limit, self.solver.effective_tolerance())
            };
            match solved {
                Ok(()) if c.state()[0].abs() <= 2.0 * piece.reach => break,
                Ok(()) | Err(Failure::Stalled { .. }) if fixed_cost => return Err(self.refused(span.from.hi)),
                // A load that grows during the step takes the shaft further than its first acceleration told.
                Ok(()) => limit = c.end() * Double::from(0.5),
                Err(failure) => return Err(self.fault(failure, span.from.hi)),
            }
            c.set_error_covariance(covariance);
        }
        if c.end() != length {
            span.end = span.from + c.end();
        }
        Ok(())
    }

    /// Takes the errors of the step that begins at the state into the estimate.
    fn foresee(&mut self, Prospect { increment, end, between }: Prospect, within: bool) {
        let deviations = std::array::from_fn(|k| end[k] + if within { between[k] } else { 0.0 });
        let here = self.state;
        let inertia = self.inertia_now();
        self.add(increment);
        let (w, there) = (self.state.w, self.inertia_now());
        self.state = here;
        let scales = [self.travelled + increment[0].abs(), self.top_speed.max(here.w.abs()).max(w.abs())];
        self.estimate(deviations, inertia, here.w, scales);
        self.estimate(deviations, there, w, scales);
    }

    /// Takes the values at `target` from the step, which holds it.
    fn read_span(&mut self, mut span: Span, target: Double) {
        let theta = if target == span.end { 1.0 } else { ((target - span.from).hi / span.length()).clamp(0.0, 1.0) };
        self.state = span.base;
        self.add(self.in_time.integrator.at(theta));
        if let Some(at) = span.reversal.filter(|at| (span.read..=theta).contains(at) && *at > 0.0) {
            span.reversal = None;
            self.record_reversal((span.from + Double::from(at * span.length())).hi);
        }
        span.read = theta;
        self.in_time.span = Some(span);
    }

    /// Ends the step where it was read last; the machine goes on from there.
    pub(super) fn leave_span(&mut self) -> Result<(), Fault> {
        let Some(span) = self.in_time.span.take() else { return Ok(()) };
        self.travelled += self.in_time.integrator.at(span.read)[0].abs();
        self.top_speed = self.top_speed.max(self.state.w.abs());
        self.in_time.integrator.leave(span.read);
        if !(self.state.w.abs() <= FASTEST) {
            return Err(self.fault(Failure::Unbounded { time: span.length() }, span.from.hi));
        }
        if let Some(upward) = span.exit.filter(|_| span.read == 1.0) {
            self.change_interval(upward);
        }
        Ok(())
    }

    /// Takes deviations of φ, u and M_an into the estimate where J, J′ and φ̇ are these: of φ relative to the angle passed,
    /// of φ̇ to the greatest speed and of a lagging torque to the breakdown torque.
    fn estimate(&mut self, [phi, u, torque]: [f64; 3], [j, slope]: [f64; 2], w: f64, scales: [f64; 2]) {
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

    /// Adds increments of φ, u and M_an to the state.
    fn add(&mut self, [phi, u, torque]: [f64; 3]) {
        self.state.angle = self.state.angle + Double::from(phi);
        self.state.u = self.state.u + Double::from(u);
        self.state.torque += torque;
        if self.inertia.borders().is_empty() {
            self.take_turns((self.state.angle.hi / TAU).round());
        }
        self.state.w = self.state.u.hi / self.inertia_now()[0].sqrt();
    }

    /// Tells of the shaft's reversal at `time` (s).
    fn record_reversal(&mut self, time: f64) {
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
    fn take_turns(&mut self, turns: f64) {
        if turns != 0.0 {
            let angle = two_product(turns, WHOLE_TURN.hi) + two_product(turns, WHOLE_TURN.lo);
            self.state.angle = self.state.angle - angle;
            self.state.turns += turns;
        }
    }

    /// The shaft passed a border of its interval.
    fn change_interval(&mut self, upward: bool) {
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
        Fault::new(match failure {
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
