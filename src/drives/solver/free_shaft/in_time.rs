//! The motion of the machine in time ([`crate::drives::shaft::free::equation`]): internal steps by the tolerance or, with
//! `fixed_cost`, from one point of a grid to the next.
//!
//! Method: Gauss collocation ([`crate::numerics::collocation`]) of the increments over each internal step, which are added to angle
//! and u in double-double. The polynomial of a step yields the communication points that it holds. Steps by the tolerance end at
//! communication points, and so do steps of a grid if a torque changes there or depends on time. Otherwise they go on beyond, and
//! the result does not depend on the communication step.
//!
//! Steps also end when the angle passes a border between smooth pieces of a motion law. The polynomial of the step finds that
//! instant to about the tolerance. That is more than enough, because the right-hand side is continuous there: a stop δ away from
//! the border changes the solution by the order of δ². The certified first root misses no visit beyond a border, however short.
//!
//! At fixed cost nothing is repeated for the sake of a tolerance: each step takes the same number of Newton iterations, and their
//! remainder counts as error.

use super::grid::Grid;
use crate::drives::settings::{Method, Solver};
use crate::drives::shaft::free::equation::Piece;
use crate::drives::shaft::free::inertia::Inertia;
use crate::drives::shaft::free::motor::{Kloss, Motor};
use crate::drives::shaft::free::{Shaft, State};
use crate::drives::shaft::passage::exit;
use crate::drives::solver::step_control::{SLIVER, WORST};
use crate::drives::{Fault, Rounded};
use crate::numerics::collocation::{Collocation, Failure, System};
use crate::numerics::double_double::Double;
use crate::numerics::first_root::first_root;
use crate::numerics::work::EVALUATION;
use serde::{Deserialize, Serialize};

/// Newton iterations in a step of fixed cost. The motion differs from a constant speed by some part x over the angle of the usual
/// step, and four iterations leave x¹⁶ of that.
const ITERATIONS: usize = 4;

/// Factor of the estimate in time over the deviations: 99 of 100 random machines stay below it, and its median is at most 100
/// times the error.
const CAUTION: f64 = 0.4;
/// The factor if the torque follows the speed at once: its poles lie close to the passed speeds (s = ± i s_K), so its coefficients
/// decay less than the motion's, from which the deviations are extrapolated.
const CAUTION_WITH_MOTOR: f64 = 2.4;

/// The speed beyond which the machine counts as run away (rad/s): ten times the highest admissible setting.
pub const FASTEST: f64 = 1e7;

/// The integrator, with or without the motor's torque as third unknown.
#[derive(Clone, Serialize, Deserialize)]
enum Integrator {
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

/// φ, u and M_an, the latter zero if it is no unknown.
fn padded<const N: usize>(values: [f64; N]) -> [f64; 3] {
    std::array::from_fn(|k| values.get(k).copied().unwrap_or(0.0))
}

/// The standard deviations of φ, u and M_an: `own` errors and those carried along.
fn deviations<const N: usize>(c: &Collocation<N>, own: [f64; N]) -> [f64; 3] {
    let covariance = c.error_covariance();
    padded::<N>(std::array::from_fn(|k| (covariance[k][k] + own[k] * own[k]).sqrt()))
}

impl Integrator {
    /// The increments of φ, u and M_an over the fraction θ of the last step.
    fn at(&self, theta: f64) -> [f64; 3] {
        either!(self, c => padded(if theta == 1.0 { c.state() } else { c.at_fraction(theta) }))
    }

    /// Adds the error of the last step at the fraction θ, at which it ends, to the covariance of the error.
    fn leave(&mut self, theta: f64) {
        either!(self, c => c.disturb(if theta == 1.0 { c.end_error() } else { c.polynomial_error() }));
    }
}

/// The integration in time: an integrator and its last internal step.
#[derive(Clone, Serialize, Deserialize)]
pub struct InTime {
    integrator: Integrator,
    /// The internal step that holds the communication point, if steps go on beyond it.
    span: Option<Span>,
    /// The steps of the method `fixed_cost`.
    pub grid: Grid,
}

/// An internal step: the start of the integrator's polynomial.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
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
    fn length(&self) -> f64 {
        (self.end - self.from).hi
    }
}

/// The fractions of the last step at which the shaft turned back and at which the angle left the interval, and whether upwards.
fn encounter<const N: usize>(
    c: &Collocation<N>,
    state: &State,
    inertia: &Inertia,
) -> (Option<f64>, Option<(f64, bool)>) {
    let (mut way, sense) = (c.growth(0), state.u.hi.signum());
    let mut speed = c.growth(1).map(|coefficient| sense * coefficient);
    (way[0], speed[0]) = (state.angle.hi, state.u.hi.abs());
    // A shaft at rest does not turn back.
    let reversal = first_root(&speed, 1.0).filter(|at| *at > 0.0);
    (reversal, exit(&way, inertia.ends(state.interval)))
}

/// The bounds of a step in time.
#[derive(Clone, Copy)]
pub struct Room {
    /// The start of the communication step (s).
    pub time: f64,
    /// The start of the step.
    pub from: Double,
    /// The latest end of the step.
    pub limit: Option<Double>,
}

/// The settings of the search for a step.
struct Search<'a> {
    shaft: &'a Shaft,
    state: &'a State,
    grid: &'a mut Grid,
    /// The communication point (s).
    time: f64,
    /// Relative; None at fixed cost.
    tolerance: Option<f64>,
    /// Whether communication points may lie within the step: only there the error of its polynomial matters.
    within: bool,
}

impl Search<'_> {
    /// The step to `end`, or to an earlier border, and its estimated error.
    fn span<const N: usize>(&mut self, c: &mut Collocation<N>, [from, end]: [Double; 2]) -> Result<(Span, f64), Fault> {
        let (inertia, covariance) = (&self.shaft.inertia, c.error_covariance());
        let mut span = Span { base: *self.state, from, end, ..Span::default() };
        self.solve(c, &mut span)?;
        let (mut reversal, exit) = encounter(c, self.state, inertia);
        if let Some((fraction, upward)) = exit {
            self.grid.cut(from)?;
            c.set_error_covariance(covariance);
            let crossing = from + Double::from(fraction * span.length());
            span.end = crossing;
            self.solve(c, &mut span)?;
            span.exit = (span.end == crossing).then_some(upward);
            (reversal, _) = encounter(c, self.state, inertia);
        }
        span.reversal = reversal;
        let (end, between) = (deviations(c, c.end_error()), padded(c.polynomial_error()));
        let deviations = std::array::from_fn(|k| end[k] + if self.within { between[k] } else { 0.0 });
        Ok((span, error_of(self.shaft, self.state, padded(c.state()), deviations)))
    }

    /// Solves the equations over `span`, or over the part of it that the tolerance and the reach of the nodes allow.
    fn solve<const N: usize>(&mut self, c: &mut Collocation<N>, span: &mut Span) -> Result<(), Fault> {
        let piece = Piece::new(self.shaft, self.state, (span.from - Double::from(self.time)).hi);
        if self.tolerance.is_none() {
            let longest = System::<N>::longest_step(&piece, Double::from(0.0), &[0.0; N]);
            if (span.end - span.from).hi > (1.0 + SLIVER) * longest {
                // Outside of a narrow interval its laws are not valid.
                if self.shaft.inertia.borders().is_empty() {
                    return Err(self.grid.refused(self.state, span.from));
                }
                span.end = span.from + Double::from(longest);
                self.grid.cut(span.from)?;
            }
        }
        let covariance = c.error_covariance();
        let length = span.end - span.from;
        let mut limit = length;
        loop {
            c.restart(Double::from(0.0), [0.0; N]);
            let solved = match self.tolerance {
                Some(tolerance) => c.step(&piece, limit, tolerance),
                None => c.step_of_fixed_cost(&piece, limit, ITERATIONS, WORST),
            };
            match solved {
                Ok(()) if c.state()[0].abs() <= 2.0 * piece.reach => break,
                Ok(()) | Err(Failure::Stalled { .. }) if self.tolerance.is_none() => {
                    return Err(self.grid.refused(self.state, span.from));
                }
                // A load that grows during the step moves the shaft further than its first acceleration implies.
                Ok(()) => limit = c.end() * Double::from(0.5),
                Err(failure) => return Err(fault(failure, self.state, span.from.hi)),
            }
            c.set_error_covariance(covariance);
        }
        if c.end() != length {
            span.end = span.from + c.end();
        }
        Ok(())
    }
}

impl InTime {
    /// The start of a machine with this motor.
    pub fn new(motor: &Motor) -> Self {
        let zero = Double::from(0.0);
        let integrator = match motor.lag() {
            None => Integrator::Mechanical(Collocation::new(zero, [0.0; 2])),
            Some(_) => Integrator::WithLag(Collocation::new(zero, [0.0; 3])),
        };
        InTime { integrator, span: None, grid: Grid::default() }
    }

    /// Whether this may be the state of a machine with this shaft.
    pub fn fits(&self, shaft: &Shaft) -> bool {
        let lags = matches!(self.integrator, Integrator::WithLag(_));
        lags == shaft.motor.lag().is_some()
            && self.span.is_none_or(|span| span.base.interval < shaft.inertia.pieces().len())
    }

    /// An evaluation of the equations in a step (nominal µs): the linear equations grow with the square of the unknowns.
    pub fn cost(shaft: &Shaft) -> f64 {
        let unknowns = if shaft.motor.lag().is_some() { 3.0 } else { 2.0 };
        EVALUATION * unknowns * unknowns / 4.0 + shaft.inertia.cost()
    }

    /// The standard deviations of φ, u and M_an.
    pub fn deviations(&self) -> [f64; 3] {
        either!(&self.integrator, c => deviations(c, Default::default()))
    }

    /// Begins with these deviations of φ and u, as after a part of the motion that another method computed.
    pub fn begin(&mut self, [phi, u]: [f64; 2]) {
        if let Integrator::Mechanical(c) = &mut self.integrator {
            c.set_error_covariance([[phi * phi, 0.0], [0.0, u * u]]);
        }
    }

    /// The end of the step that holds the communication point.
    pub fn end(&self) -> Option<Double> {
        self.span.map(|span| span.end)
    }

    /// The next step: to a border, to a limit, to the next point of the grid, or as far as the tolerance allows. Returns the cost
    /// (nominal µs).
    pub fn extend(&mut self, shaft: &Shaft, state: &State, solver: &mut Solver, room: Room) -> Result<f64, Fault> {
        let Room { time, from, limit } = room;
        let InTime { integrator, span, grid } = self;
        let tolerance = (solver.settings.method == Method::Adaptive).then(|| solver.effective_tolerance());
        let end = match limit {
            Some(limit) if tolerance.is_some() => limit,
            _ => grid.end_of_step(from, limit),
        };
        let mut search = Search { shaft, state, grid, time, tolerance, within: limit.is_none() };
        let (found, error, evaluations) = either!(integrator, c => {
            let spent = c.statistics.evaluations;
            let (found, error) = search.span(c, [from, end])?;
            (found, error, (c.statistics.evaluations - spent) as f64)
        });
        *span = Some(found);
        solver.steps += 1.0;
        solver.evaluations += evaluations;
        solver.error_estimate = solver.error_estimate.max(error);
        // A step without evaluations would repeat for ever.
        Ok(InTime::cost(shaft) * evaluations.max(1.0))
    }

    /// Takes the values at `target` from the step, which holds it; returns the instant (s) of a reversal on the way there.
    pub fn read(&mut self, shaft: &Shaft, state: &mut State, target: Double) -> Option<f64> {
        let span = self.span.as_mut()?;
        let theta = if target == span.end { 1.0 } else { ((target - span.from).hi / span.length()).clamp(0.0, 1.0) };
        *state = span.base;
        state.add(shaft, self.integrator.at(theta));
        let reversal = span.reversal.take_if(|at| (span.read..=theta).contains(at) && *at > 0.0);
        span.read = theta;
        reversal.map(|at| (span.from + Double::from(at * span.length())).hi)
    }

    /// Ends the step where it was read last; the machine goes on from there.
    pub fn leave(&mut self, shaft: &Shaft, state: &mut State) -> Result<(), Fault> {
        let Some(span) = self.span.take() else { return Ok(()) };
        state.travelled += self.integrator.at(span.read)[0].abs();
        state.top_speed = state.top_speed.max(state.w.abs());
        self.integrator.leave(span.read);
        if !(state.w.abs() <= FASTEST) {
            return Err(fault(Failure::Unbounded { time: span.length() }, state, span.from.hi));
        }
        if let Some(upward) = span.exit.filter(|_| span.read == 1.0) {
            state.change_interval(&shaft.inertia, upward);
        }
        Ok(())
    }
}

/// The larger error at the ends of a step that begins `here`, by these deviations: φ relative to the passed angle, φ̇ = u/√J to the
/// greatest speed and a lagging torque to the breakdown torque.
fn error_of(shaft: &Shaft, here: &State, increment: [f64; 3], deviations: [f64; 3]) -> f64 {
    let [phi, u, torque] = deviations;
    let mut there = *here;
    there.add(shaft, increment);
    let travelled = here.travelled + increment[0].abs();
    let top_speed = here.top_speed.max(here.w.abs()).max(there.w.abs());
    let (breakdown, caution) = match shaft.motor {
        Motor::Kloss(Kloss { breakdown_torque, dynamics: None, .. }) => (breakdown_torque, CAUTION_WITH_MOTOR),
        Motor::Kloss(Kloss { breakdown_torque, .. }) => (breakdown_torque, CAUTION),
        Motor::None | Motor::Input => (1.0, CAUTION),
    };
    let at = |state: &State| {
        let [j, slope] = shaft.inertia_at(state);
        let of_w = u / j.sqrt() + (0.5 * slope / j * state.w).abs() * phi;
        let of_speed = of_w / top_speed.max(f64::MIN_POSITIVE);
        caution * (phi / travelled.max(1.0)).max(of_speed).max(torque / breakdown.max(f64::MIN_POSITIVE))
    };
    at(here).max(at(&there))
}

/// The fault of a failure this long after the instant `since` (s) of this state.
pub fn fault(failure: Failure, state: &State, since: f64) -> Fault {
    Fault::new(match failure {
        Failure::Stalled { time: after } => format!(
            "the motion cannot be continued at t = {} s (phi = {} rad, w = {} rad/s): no internal step keeps the tolerance; the torques change too fast",
            Rounded(since + after),
            Rounded(state.angle.hi),
            Rounded(state.w)
        ),
        Failure::Unbounded { time: after } => format!(
            "the machine runs away: at t = {} s its speed exceeds {FASTEST:e} rad/s; check `tau` and `J0`",
            Rounded(since + after)
        ),
    })
}
