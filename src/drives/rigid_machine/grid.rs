//! The method `fixed_cost`: integration in time on a grid of equal steps, each of the same cost, for hosts with a deadline.
//!
//! The equations are those of [`super::solver`]. The grid starts with the simulation. As long as the torques do not depend
//! on time the steps go on beyond communication points, which read the polynomial of the step that holds them: the answer
//! does not depend on the communication step. A load that changes, or is a function of time, ends a step at the
//! communication point; the next one goes on to the next point of the grid. Nothing is repeated for the sake of a
//! tolerance: each step takes the same number of Newton iterations, and what they leave counts as error.

use super::RigidMachine;
use super::solver::{FASTEST, IDLE_CHANGES, Integrator, add_end_error, encounter};
use super::{Kloss, Motor, State};
use crate::drives::{Fault, Rounded};
use crate::numerics::collocation::{Collocation, Failure, System};
use crate::numerics::double_double::{Double, two_product, two_sum};
use crate::numerics::work::{EVALUATION, Work};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Newton iterations in a step. The motion differs from that at a constant speed by some part x over the angle of the
/// usual step, and four iterations leave x¹⁶ of that.
const ITERATIONS: usize = 4;

/// A step that misses the motion by more than this part of it is refused: the estimate is one no more, and what follows
/// would be no value of this machine.
pub(super) const WORST: f64 = 1e-2;

/// By how much a step may differ from its length, so that no sliver is left before a point of the grid.
const SLIVER: f64 = 1e-3;

/// How often an internal step may be cut at borders of the motion laws. The usual step passes one on the average; the
/// densest laws put five of them into the angle of two.
pub(super) const MOST_CUTS: u32 = 8;

/// The usual step, times the angular rate of the shortest wave of J and the square root of J's range: a wave where J
/// does not vary much is passed in three steps.
const ANGLE: f64 = 2.0;

/// The usual step, as part of the time that a motor needs to follow its load, w_s s_K J/M_K, and of the lag of its torque.
const FOLLOWING: f64 = 1.0;

/// By how much a stiff motor may shorten the usual step: what it does within a smaller part of a wave is a jump between
/// two motions in balance, which the method meets without resolving the way there.
const STIFFEST: f64 = 1.0 / 32.0;

/// The usual step of a machine of which neither the start nor the motor tells a speed (s): the communication step of
/// common real-time hosts.
const USUAL: f64 = 1e-3;

/// The grid and the internal step that holds the communication point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Where the grid begins (s).
    origin: f64,
    /// The length of its steps (s).
    pub size: f64,
    span: Option<Span>,
    /// τ and M_an for which the step holds (N·m).
    torques: [f64; 2],
    /// The point of the grid towards which the steps go (s), and how often borders have cut the way there.
    point: Double,
    cuts: u32,
    /// Changes of the interval without a step in between.
    idle: u32,
}

/// An internal step: where the integrator's polynomial begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
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

impl Grid {
    /// The interval between borders in which the internal step begins; 0 without one.
    pub fn interval(&self) -> usize {
        self.span.map_or(0, |span| span.base.interval)
    }
}

impl Span {
    fn length(&self) -> f64 {
        (self.end - self.from).hi
    }
}

/// Where a step leads, and by what φ, u and M_an err at its end and between the ends besides.
#[derive(Default)]
struct Prospect {
    increment: [f64; 2],
    end: [f64; 3],
    between: [f64; 3],
}

impl RigidMachine {
    /// The grid from `origin` (s) on.
    pub(super) fn grid_from(&self, origin: f64) -> Grid {
        let asked = self.solver.settings.step_size;
        let size = if asked > 0.0 { asked } else { self.usual_step() };
        Grid { origin, size, point: Double::from(origin), ..Grid::default() }
    }

    /// The internal step where none is asked for (s): see [`ANGLE`], [`FOLLOWING`], [`STIFFEST`] and [`USUAL`]; borders
    /// of the motion laws are passed one at a time on the average.
    ///
    /// √J(φ) is a sum of waves up to the order R of J with branch points √(J_min/J_max)/R beside the real angles, or
    /// farther away.
    fn usual_step(&self) -> f64 {
        let (low, high) = self.inertia.range();
        let free = self.state.u.hi.abs() / low.sqrt();
        let (synchronous, follows) = match self.motor {
            Motor::Kloss(Kloss { breakdown_torque, breakdown_slip, synchronous_speed, dynamics }) => {
                let speed = synchronous_speed.abs();
                let own = speed * breakdown_slip * low / breakdown_torque.abs();
                (speed, dynamics.map_or(own, |lag| lag.min((lag * own).sqrt())))
            }
            Motor::None | Motor::Input => (0.0, f64::INFINITY),
        };
        let smooth = ANGLE / (self.inertia.resolution() * (high / low).sqrt());
        let angle = smooth.min(TAU / self.inertia.borders().len().max(1) as f64);
        let speed = free.max(synchronous);
        if speed > 0.0 {
            let step = angle / speed;
            step.min((FOLLOWING * follows).max(STIFFEST * step))
        } else {
            USUAL
        }
    }

    /// Integrates over the communication step of length `step` from `time` (s).
    pub(super) fn advance_on_grid(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        let target = two_sum(time, step);
        self.prepare_mesh_once()?;
        let mut work = Work::default();
        let lag = if self.motor.lag().is_some() { 2.0 } else { 1.0 };
        let cost = lag * EVALUATION + self.inertia.cost();
        // Steps that nobody can wait for are refused before the first.
        if !work.allows(cost * (step / self.grid.size)) {
            return Err(self.too_long([time, target.hi], time));
        }
        let steady = self.load.is_constant() && self.driving.is_constant();
        let torques = [self.load.set_value(), self.driving.set_value()];
        let mut now = Double::from(time);
        if !steady || torques != self.grid.torques {
            self.leave_span()?;
            self.grid.torques = torques;
        }
        loop {
            let Some(span) = self.grid.span else {
                let limit = if steady { None } else { Some(target) };
                let before = self.solver.evaluations;
                self.begin_span(time, now, limit)?;
                let evaluations = (self.solver.evaluations - before).max(1.0);
                work.draw(cost * evaluations).map_err(|_| self.too_long([time, target.hi], now.hi))?;
                continue;
            };
            if (target - span.end).hi <= 0.0 {
                self.read_span(span, target);
                // Torques that are not constant are forgotten when the step is over.
                return if steady { Ok(()) } else { self.leave_span() };
            }
            // What is left of the step is read, so that its end is left as every end.
            self.read_span(span, span.end);
            now = span.end;
            self.leave_span()?;
        }
    }

    /// The next point of the grid beyond `from`.
    fn next_point(&self, from: Double) -> Double {
        let Grid { origin, size, .. } = self.grid;
        let origin = Double::from(origin);
        let number = ((from - origin).hi / size + SLIVER).floor() + 1.0;
        origin + two_product(number, size)
    }

    /// Solves the step from `from` to the next point of the grid, or to `limit`, or to a border.
    fn begin_span(&mut self, time: f64, from: Double, limit: Option<Double>) -> Result<(), Fault> {
        let point = self.next_point(from);
        if (point - self.grid.point).hi > 0.0 {
            (self.grid.point, self.grid.cuts) = (point, 0);
        }
        // No sliver is left over behind the point either.
        let end = limit.filter(|limit| (*limit - point).hi <= SLIVER * self.grid.size).unwrap_or(point);
        let prospect = match self.integrator.clone() {
            Integrator::Mechanical(mut c) => {
                let prospect = self.solve_span(&mut c, time, [from, end])?;
                self.integrator = Integrator::Mechanical(c);
                prospect
            }
            Integrator::WithLag(mut c) => {
                let prospect = self.solve_span(&mut c, time, [from, end])?;
                self.integrator = Integrator::WithLag(c);
                prospect
            }
        };
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
        let spent = c.statistics;
        let covariance = c.error_covariance();
        let mut span = Span { base: self.state, from, end, ..Span::default() };
        loop {
            let since = (from - Double::from(time)).hi;
            let longest = self.piece(since).longest_step(Double::from(0.0), &[0.0; N]);
            if span.length() > (1.0 + SLIVER) * longest {
                if self.inertia.borders().is_empty() {
                    return Err(self.refused(from.hi));
                }
                // Beyond a narrow interval its laws hold no more.
                self.cut(from)?;
                span.end = from + Double::from(longest);
            }
            self.solve(c, &span, since)?;
            let met = encounter(c, &self.state, self.inertia.ends(self.state.interval));
            span.reversal = met.reversal;
            let Some((fraction, upward)) = met.exit.filter(|_| self.grid.idle < IDLE_CHANGES) else { break };
            self.cut(from)?;
            c.set_error_covariance(covariance);
            let crossing = from + Double::from(fraction * span.length());
            if (crossing - from).hi <= 0.0 {
                self.change_interval(upward);
                self.grid.idle += 1;
                span = Span { base: self.state, from, end, ..Span::default() };
                continue;
            }
            span.end = crossing;
            span.exit = Some(upward);
            span.reversal = met.reversal.filter(|at| *at < fraction).map(|at| at / fraction);
            self.solve(c, &span, since)?;
            break;
        }
        self.grid.idle = 0;
        self.grid.span = Some(span);
        self.solver.steps += 1.0;
        self.solver.evaluations += (c.statistics.evaluations - spent.evaluations) as f64;
        let covariance = c.error_covariance();
        let own = c.end_error();
        let mut prospect = Prospect::default();
        for k in 0..N {
            prospect.between[k] = c.polynomial_error()[k];
            prospect.end[k] = (covariance[k][k] + own[k] * own[k]).sqrt();
        }
        prospect.increment = [c.state()[0], c.state()[1]];
        Ok(prospect)
    }

    /// Solves the equations over `span`.
    fn solve<const N: usize>(&self, c: &mut Collocation<N>, span: &Span, since: f64) -> Result<(), Fault> {
        c.restart(Double::from(0.0), [0.0; N]);
        let piece = self.piece(since);
        let solved = c.step_of_fixed_cost(&piece, Double::from(span.length()), ITERATIONS, WORST);
        match solved {
            Ok(()) if c.state()[0].abs() <= 2.0 * piece.reach => Ok(()),
            Ok(()) | Err(Failure::Stalled { .. }) => Err(self.refused(span.from.hi)),
            Err(failure) => Err(self.fault(failure, span.from.hi)),
        }
    }

    /// Counts a step that does not reach the next point of the grid.
    fn cut(&mut self, at: Double) -> Result<(), Fault> {
        self.grid.cuts += 1;
        if self.grid.cuts <= MOST_CUTS {
            return Ok(());
        }
        Err(Fault(format!(
            "the shaft passes more than {MOST_CUTS} breakpoints of its motion laws within an internal step of {} s, at t = {} s; shorten solver.step_size, or set solver.method = adaptive",
            Rounded(self.grid.size),
            Rounded(at.hi)
        )))
    }

    fn refused(&self, time: f64) -> Fault {
        Fault(format!(
            "the motion cannot be computed beyond t = {} s (w = {} rad/s) with internal steps of {} s: they turn the shaft too far, or miss more than {WORST} of the motion; shorten solver.step_size, or set solver.method = adaptive",
            Rounded(time),
            Rounded(self.state.w),
            Rounded(self.grid.size)
        ))
    }

    /// Takes the errors of the step that begins at the state into the estimate.
    fn foresee(&mut self, Prospect { increment, end, between }: Prospect, within: bool) {
        let deviations = std::array::from_fn(|k| end[k] + if within { between[k] } else { 0.0 });
        let here = self.state;
        let inertia = self.inertia_now();
        self.add(&increment);
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
        let at_end = theta == 1.0;
        match &self.integrator {
            Integrator::Mechanical(c) => {
                let increment = if at_end { c.state() } else { c.at_fraction(theta) };
                self.add(&increment);
            }
            Integrator::WithLag(c) => {
                let increment = if at_end { c.state() } else { c.at_fraction(theta) };
                self.add(&increment);
            }
        }
        if let Some(at) = span.reversal.filter(|at| (span.read..=theta).contains(at) && *at > 0.0) {
            span.reversal = None;
            self.record_reversal((span.from + Double::from(at * span.length())).hi);
        }
        span.read = theta;
        self.grid.span = Some(span);
    }

    /// Ends the step where it was read last; the machine goes on from there.
    fn leave_span(&mut self) -> Result<(), Fault> {
        let Some(span) = self.grid.span.take() else { return Ok(()) };
        let passed = match &mut self.integrator {
            Integrator::Mechanical(c) => leave(c, span.read),
            Integrator::WithLag(c) => leave(c, span.read),
        };
        self.travelled += passed.abs();
        self.top_speed = self.top_speed.max(self.state.w.abs());
        if !(self.state.w.abs() <= FASTEST) {
            return Err(self.fault(Failure::Unbounded { time: span.length() }, span.from.hi));
        }
        if let Some(upward) = span.exit.filter(|_| span.read == 1.0) {
            self.change_interval(upward);
        }
        Ok(())
    }
}

/// Adds what the last step errs by at the fraction `theta`, where it is left, to the covariance of the error; φ there.
fn leave<const N: usize>(c: &mut Collocation<N>, theta: f64) -> f64 {
    if theta == 1.0 {
        add_end_error(c);
        return c.state()[0];
    }
    let mut covariance = c.error_covariance();
    for (k, own) in c.polynomial_error().into_iter().enumerate() {
        covariance[k][k] += own * own;
    }
    c.set_error_covariance(covariance);
    c.at_fraction(theta)[0]
}
