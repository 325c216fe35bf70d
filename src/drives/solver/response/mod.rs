//! The motion q of an oscillator that a cam moves, q̈ + 2δ q̇ + ω₀² q = f; the equation gives f from x = U(φ(t)).
//!
//! Four methods; the first is tried at each step on inputs, the others are chosen at each restart:
//!
//! - *Hermite step*, for a Fourier law: the impulse response times f, integrated over the whole step from its ends;
//! - *closed form*, for a Fourier law at constant speed (or any law at rest): harmonic response plus free motion,
//!   valid at any later time without growth of the error; on inputs, too, as long as they keep their speed;
//! - *table*, for any other law at constant speed from the start on: the motion over a turn as polynomials on cells, combined by
//!   the state at the start of each cell, and whole turns as powers of one map;
//! - *substeps* otherwise: f as a Chebyshev polynomial on pieces that follow the motion of the cam, the oscillator
//!   solved exactly on each. Pieces end at the breakpoints of the law; stiffness does not shorten them.
//!
//! Nothing here allocates except [`Response::new`].

mod closed_form;
mod error_bound;
mod hermite;
mod on_inputs;
pub mod push;
mod table;

use crate::drives::follower::elastic_output::Equation;
use crate::drives::limits::{no_periodic_motion, search_too_much, step_too_much};
use crate::drives::shaft::angle_series::AngleSeries;
use crate::drives::shaft::cam_drive::{AngleMotion, DriveMode};
use crate::drives::shaft::cam_turn::{OVERRUN, turns};
use crate::drives::shaft::instant::Instant;
use crate::drives::shaft::passage::first_passage;
use crate::drives::solver::step_control::RESERVE;
use crate::drives::{Fault, Rounded};
use crate::motion::MotionLaw;
use crate::motion::derivatives::lift;
use crate::motion::turn::near;
use crate::numerics::angle::WHOLE_TURN;
use crate::numerics::chebyshev;
use crate::numerics::double_double::{Double, two_sum};
use crate::numerics::forced::{ForcedStep, admissible_length};
use crate::numerics::period_map::{self, PeriodMap, fixed_point, is_resonant};
use crate::numerics::work::Work;
use closed_form::{ClosedForm, Run};
use error_bound::{ErrorBound, StepErrors, neglected};
use hermite::Hermite;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::Arc;
pub use table::Table;
use table::Turn;

/// The part of the tolerance that one step may take up: so little that the sum of a thousand steps, as a weakly damped oscillator
/// adds them, keeps it.
const SHARE: f64 = 1e-3;

/// The last two Chebyshev coefficients of the forcing on a piece need not fall below this part of the largest one: some roundings.
const LEAST_TAIL: f64 = 1e-14;

/// Rounding error of U″ and U′, relative to their bounds in the segment: coefficients of a forcing that passes through zero need
/// not fall below this.
const ROUNDING: f64 = 2e-15;

/// Breakpoints lie in [0, 2π): the angle between them has the rounding of an input of this size (rad) in addition to its own.
const OF_BREAKPOINTS: f64 = 2.0;

/// Cost of a piece, and of an evaluation of the forcing without the law (nominal µs).
const PIECE: f64 = 1.0;
const FORCING: f64 = 0.03;

/// Below this part of its terms the determinant of a turn's map minus one depends on the rounding of the parameters.
const SINGULAR: f64 = 1e-13;

/// A harmonic is resonant if its relative impedance is below this: some roundings of the parameters m and c.
const RESONANT: f64 = 1e-15;

/// The motion of the oscillator from a given state on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Response {
    equation: Equation,
    /// Relative tolerance of q.
    tolerance: f64,
    /// The motion of the cam from the next restart or Hermite step on.
    pub motion: AngleMotion,
    /// Bounds of |U| (m), |U′| (m/rad) and |U″| (m/rad²) over the turn, for a Hermite step: a Fourier law is one segment.
    bounds: [f64; 3],
    /// See [`MotionLaw::roundings`].
    roundings: [f64; 2],
    closed_form: ClosedForm,
    method: Method,
    /// The turn of the cam from its start, see [`Response::tabulate`]; all instances with the same parameters share it.
    #[serde(skip)]
    pub table: Option<Arc<Table>>,
    /// The time up to which `motion` is valid (s).
    until: f64,
    /// Restarts of the closed form and pieces since the response was made.
    pub steps: f64,
    /// Evaluations of the law (or of the closed form) since the response was made.
    pub evaluations: u64,
    /// The errors of the steps so far.
    bound: ErrorBound,
}

/// Method by which the motion goes on at present, with its data. The methods share memory, unboxed, since a step does not allocate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Method {
    /// The closed form.
    Closed(Run),
    /// One quadrature for each communication step.
    Hermite(Hermite),
    /// The table of a turn.
    Table(period_map::Trajectory),
    /// Pieces that follow the motion of the cam.
    Pieces(Piece),
}

/// The current piece of the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Piece {
    /// Start and end (s), in double-double since a breakpoint may lie between two neighbouring `f64`.
    start: Double,
    end: Double,
    /// The segment of the law, the next piece's segment, and the breakpoint (rad) if the piece ends just after one.
    segment: usize,
    next: usize,
    border: Option<f64>,
    step: ForcedStep,
}

impl Response {
    /// A response at rest; [`Response::restart`] starts it. Allocates the memory that the law needs.
    pub fn new(equation: Equation, law: &MotionLaw, tolerance: f64) -> Self {
        Response {
            equation,
            tolerance,
            motion: AngleMotion::uniform(0.0, 0.0, 0.0),
            bounds: [0, 1, 2].map(|order| law.bound(order)),
            roundings: law.roundings(),
            closed_form: ClosedForm::new(law.series()),
            method: Method::Closed(Run::default()),
            table: None,
            until: f64::INFINITY,
            steps: 0.0,
            evaluations: 0,
            bound: ErrorBound::default(),
        }
    }

    /// Rebuilds, after reading from bytes, the parts that the serialisation leaves out, or takes them from `made`, the response as
    /// made from the scene. Returns whether it can be one of this law in the state `now`.
    pub fn restored(
        &mut self,
        made: Option<&Response>,
        (law, mode): (&Arc<MotionLaw>, &DriveMode),
        tolerance: f64,
        now: &Instant,
    ) -> bool {
        (self.tolerance, self.bounds, self.roundings) =
            (tolerance, [0, 1, 2].map(|order| law.bound(order)), law.roundings());
        self.closed_form.restored(&self.equation, law.series());
        match &self.method {
            Method::Hermite(_) => return law.series().is_some(),
            Method::Pieces(piece) => return piece.segment.max(piece.next) < law.breakpoints().len().max(1),
            Method::Closed(_) => return true,
            Method::Table(_) => self.tabulate(made.and_then(|made| made.table.clone()), law, mode),
        }
        if !self.has_its_table() {
            // As after any other change: from here on without a table.
            let _ = self.go_on(law, now);
        }
        true
    }

    /// Goes on from `now` without end, at constant speed.
    pub fn go_on(&mut self, law: &MotionLaw, now: &Instant) -> Result<(), Fault> {
        let motion = self.motion;
        self.restart(law, &motion, now.time, f64::INFINITY, now.q.array())
    }

    /// The equation of the motion.
    pub fn equation(&self) -> &Equation {
        &self.equation
    }

    /// Changes the equation; valid after the next restart.
    pub fn set_equation(&mut self, equation: Equation) {
        self.equation = equation;
        self.closed_form.holds_for = None;
        if let Method::Hermite(step) = &mut self.method {
            *step = Hermite::new();
        }
    }

    /// Takes up the table of a turn in this mode if it helps: `known` if it is that table, else a new one. Allocates.
    pub fn tabulate(&mut self, known: Option<Arc<Table>>, law: &Arc<MotionLaw>, mode: &DriveMode) {
        let DriveMode::Constant { w, phi_start } = *mode else { return };
        let (equation, law, tolerance) = (self.equation, law.clone(), self.tolerance);
        // The closed form needs no table.
        let wanted = law.series().is_none() && turns(w);
        let turn = Turn { equation, law, w, phi_start, tolerance };
        self.table = match known {
            Some(table) if table.turn == turn => Some(table),
            _ => wanted.then(|| Arc::new(Table::new(turn))),
        };
    }

    /// Whether the table is in use.
    #[cfg(test)]
    pub fn is_on_table(&self) -> bool {
        matches!(self.method, Method::Table(_))
    }

    /// Whether the present cell belongs to the table.
    fn has_its_table(&self) -> bool {
        match (&self.method, self.map()) {
            (Method::Table(trajectory), Some(map)) => trajectory.is_in(map),
            _ => false,
        }
    }

    fn map(&self) -> Option<&PeriodMap> {
        self.table.as_ref()?.map.as_ref()
    }

    /// The table of a turn that starts at `time` (s), if it exists and no parameter has changed since.
    fn map_from(&self, time: f64) -> Option<&PeriodMap> {
        let AngleMotion { origin, coefficients: [phi, w, ..], .. } = self.motion;
        let table = self.table.as_ref()?;
        let Turn { equation, w: speed, phi_start, .. } = table.turn;
        let same = (equation, speed, phi_start) == (self.equation, w, phi);
        table.map.as_ref().filter(|_| same && origin == time && self.motion.is_uniform())
    }

    /// Starts at `time` (s) from `state` = q, q̇ on `motion`, which is valid up to `until` (s).
    pub fn restart(
        &mut self,
        law: &MotionLaw,
        motion: &AngleMotion,
        time: f64,
        until: f64,
        state: [f64; 2],
    ) -> Result<(), Fault> {
        (self.motion, self.until) = (*motion, until);
        let w = motion.coefficients[1];
        if motion.is_uniform() && (law.series().is_some() || !turns(w)) {
            let rest = self.rest(law, motion, time);
            self.method = Method::Closed(self.closed_form.restart(&self.equation, motion, time, state, rest));
            (self.steps, self.evaluations) = (self.steps + 1.0, self.evaluations + 1);
            self.bound.add_closed_form(law.series().map_or(0.0, |series| series.order() as f64));
            Ok(())
        } else if until == f64::INFINITY
            && let Some(map) = self.map_from(time)
        {
            let (trajectory, evaluations) = (period_map::Trajectory::new(map, time, state), map.evaluations());
            self.method = Method::Table(trajectory);
            (self.steps, self.evaluations) = (self.steps + 1.0, evaluations as u64);
            Ok(())
        } else {
            let angles = AngleSeries::of(&self.motion, two_sum(time, 0.0));
            let segment = law.segment(angles.angle[0], angles.forward());
            self.next_piece(law, segment, Double::from(time), state)
        }
    }

    /// The largest |q| so far (m).
    pub fn largest(&self) -> f64 {
        if let Method::Closed(run) = &self.method { run.largest.max(self.bound.largest) } else { self.bound.largest }
    }

    /// U of a cam at rest.
    fn rest(&self, law: &MotionLaw, motion: &AngleMotion, time: f64) -> Option<f64> {
        (!turns(motion.coefficients[1])).then(|| motion.at(time).on(law).0[0])
    }

    /// The largest estimated error of q up to `time` (s), relative to the largest |q| so far.
    pub fn error(&self, time: f64) -> f64 {
        let error = self.bound.relative();
        match &self.method {
            Method::Closed(run) => error.max(self.closed_form.rounding(run, &self.equation.oscillator, time)),
            _ => error,
        }
    }

    /// The instant (s) up to which the closed form or the present piece holds, and whether the law has a breakpoint there.
    pub fn held(&self) -> Option<(f64, bool)> {
        match &self.method {
            Method::Closed(_) => Some((f64::INFINITY, false)),
            Method::Pieces(piece) => Some((piece.end.hi, piece.border.is_some())),
            Method::Hermite(_) | Method::Table(_) => None,
        }
    }

    /// Brings cam and mass `now` to `time` (s), which must not precede the piece that an earlier call has reached.
    #[inline]
    pub fn reach(&mut self, law: &MotionLaw, time: f64, now: &mut Instant) -> Result<(), Fault> {
        if let (Method::Closed(run), Some(_)) = (&mut self.method, law.series()) {
            self.evaluations += 1;
            self.closed_form.reach(run, &self.equation.oscillator, &self.motion, time, now);
            return Ok(());
        }
        let q = self.at(law, time, &mut Work::default())?;
        *now = Instant::on(&self.motion, law, time, q);
        Ok(())
    }

    /// q, q̇ at `time` (s) with the remaining `work`.
    fn at(&mut self, law: &MotionLaw, time: f64, work: &mut Work) -> Result<[f64; 2], Fault> {
        let state = match &mut self.method {
            Method::Closed(run) => {
                let mut now = Instant::default();
                self.evaluations += 1;
                self.closed_form.reach(run, &self.equation.oscillator, &self.motion, time, &mut now);
                return Ok(now.q.array());
            }
            Method::Hermite(_) => return Err(Fault::new("the response has not been restarted after a Hermite step")),
            Method::Table(_) => self.on_table(time)?,
            Method::Pieces(_) => self.by_pieces(law, time, work)?,
        };
        self.bound.reach(state[0]);
        Ok(state)
    }

    /// q, q̇ at `time` (s) by the cells of the table.
    fn on_table(&mut self, time: f64) -> Result<[f64; 2], Fault> {
        let table = self.table.as_ref().and_then(|table| Some((table.map.as_ref()?, table.roundings)));
        let (Method::Table(trajectory), Some((map, of_law))) = (&mut self.method, table) else {
            return Err(Fault::new("the response has lost its table"));
        };
        let before = trajectory.steps;
        trajectory.reach(map, time).map_err(|fault| {
            Fault::new(format!("the motion exceeds the range of numbers at t = {} s", Rounded(fault.time)))
        })?;
        self.steps += (trajectory.steps - before) as f64;
        let turns = (time - self.motion.origin) / map.period().hi;
        let cells = (map.cells() as f64).sqrt();
        // As many turns as the free motion lasts.
        let decay = self.equation.oscillator.decay();
        let alike = (turns + 1.0).min(-1.0 / (-decay * map.period().hi).exp_m1());
        self.bound.add_table(RESERVE * map.error(), cells * alike, of_law * alike);
        Ok(trajectory.at(map, time))
    }

    /// q, q̇ at `time` (s), piece after piece.
    fn by_pieces(&mut self, law: &MotionLaw, time: f64, work: &mut Work) -> Result<[f64; 2], Fault> {
        let mut from = None;
        while let Method::Pieces(piece) = &self.method {
            let (start, end) = (piece.start, piece.end);
            if (Double::from(time) - end).hi <= 0.0 {
                return Ok(piece.step.at(&self.equation.oscillator, (Double::from(time) - start).hi));
            }
            let (piece, before) = (*piece, self.evaluations);
            let (segment, state) = self.leave_piece(law, piece);
            self.next_piece(law, segment, end, state)?;
            let (evaluations, from) = ((self.evaluations - before) as f64, *from.get_or_insert(start.hi));
            work.draw(PIECE + evaluations * (FORCING + law.cost())).map_err(|_| {
                let hint = "relax solver.tolerance if the drive has it, or lower the speed or the natural frequency";
                let way = [from, time];
                step_too_much(way, end.hi, &self.motion.describe("the cam", way), hint)
            })?;
        }
        Err(Fault::new("the response has lost its pieces"))
    }

    /// The segment of the motion after a piece, and its state there.
    fn leave_piece(&mut self, law: &MotionLaw, piece: Piece) -> (usize, [f64; 2]) {
        let Piece { start, end, segment, next, border, step } = piece;
        let mut state = step.at(&self.equation.oscillator, (end - start).hi);
        if let Some(border) = border {
            let shaft = self.motion.at_instant(end);
            let beyond = near(shaft.reduced, border) - border;
            let [phi, w, ..] = shaft.kinematics.0;
            // The jump of the right side over the speed.
            let [before, after] = [segment, next].map(|segment| law.at_in(segment, shaft.reduced).0);
            let jump = match self.equation.weights {
                Some([k, _, k2]) if k * w != 0.0 => k2 * (after[2] - before[2]) * w + k * (after[0] - before[0]) / w,
                _ => self.equation.of_acceleration() * (after[2] - before[2]) * w,
            };
            // The gain beyond the border.
            state[1] += jump * beyond;
            let angle = if self.until.is_finite() { phi } else { 0.0 };
            self.bound.pass(&self.equation.oscillator, jump, angle);
            self.bound.disturb([0.0, self.equation.of_acceleration() * self.roundings[0] * w]);
        }
        (next, state)
    }

    /// q, q̇ of a mass at rest on a cam that rests in its position at `time` (s).
    pub fn at_rest(&self, law: &MotionLaw, motion: &AngleMotion, time: f64) -> [f64; 2] {
        [self.equation.at_rest(motion.at(time).on(law).0[0]), 0.0]
    }

    /// q, q̇ at `time` (s) of the motion that repeats every turn at constant speed.
    pub fn periodic(&mut self, law: &MotionLaw, motion: &AngleMotion, time: f64) -> Result<[f64; 2], Fault> {
        let w = motion.coefficients[1];
        let oscillator = self.equation.oscillator;
        if !turns(w) {
            return Ok(self.at_rest(law, motion, time));
        }
        if oscillator.stiffness() == 0.0 {
            return Err(no_motion("without a spring (c = 0) the mean of q is arbitrary"));
        }
        if let Some(series) = law.series() {
            return self.equation.periodic(series, w, motion.at(time).reduced, RESONANT).map_err(|k| {
                let frequency = Rounded(oscillator.stiffness().sqrt() / TAU);
                let what = if self.equation.of_acceleration() == 0.0 { "process force" } else { "cam" };
                no_motion(&format!("harmonic {k} of the {what} meets the undamped natural frequency {frequency} Hz"))
            });
        }
        // One turn is an affine map of the state: s ↦ M s + r; its fixed point is the periodic motion.
        let turn = WHOLE_TURN.divide(Double::from(w.abs()));
        let m = oscillator.free(turn);
        self.restart(law, motion, time, f64::INFINITY, [0.0; 2])?;
        let mut work = Work::default();
        let reached = self.at(law, time + turn.hi, &mut work);
        let r = reached.map_err(|fault| {
            let hint = "lower the natural frequency, or choose at_rest or given";
            if work.is_exhausted() { search_too_much(hint) } else { fault }
        })?;
        fixed_point(&m, [0.0; 2], r).filter(|_| !is_resonant(&m, SINGULAR)).ok_or_else(|| {
            no_motion("the oscillator returns to its state after one turn of the cam (undamped resonance or c = 0)")
        })
    }

    /// Computes the next piece, in `segment` of the law from `start` (s) and `state`.
    fn next_piece(&mut self, law: &MotionLaw, segment: usize, start: Double, state: [f64; 2]) -> Result<(), Fault> {
        let angles = AngleSeries::of(&self.motion, start);
        // Infinity has no double-double.
        let horizon = if self.until.is_finite() { (Double::from(self.until) - start).hi } else { f64::INFINITY };
        let mut length = angles.length_for(2.0 / law.resolution_in(segment)).min(horizon.max(f64::MIN_POSITIVE));
        let passage = first_passage(law.breakpoints(), segment, angles.angle[0], &angles.scaled(length), OVERRUN);
        length *= passage.map_or(1.0, |passage| passage.at);
        let whole = length;
        // The bounds of the segment: next to a steep rise a gentle return would otherwise count all its errors as rounding.
        let [lift_bound, slope, curvature, jerk] = [0, 1, 2, 3].map(|order| law.bound_in(segment, order));
        let fit = loop {
            length = admissible_length(&self.equation.oscillator, length);
            let forcing = |x: f64| {
                let [phi, w, a] = angles.at(0.5 * length * (1.0 + x));
                let [u, slope, curvature, ..] = law.at_in(segment, phi).0;
                self.equation.forcing(lift([u, slope, curvature], [w, a]))
            };
            let speed = angles.speed(length);
            let scale = self.equation.bound([lift_bound, slope, curvature], [speed, angles.acceleration(length)]);
            // On a steep law the rounding of the angle exceeds the rounding of U″.
            let of_angle = f64::EPSILON * self.equation.bound([slope, curvature, jerk], [speed, 0.0]);
            let rounding = (ROUNDING * scale).max(of_angle);
            let fit = chebyshev::fit(forcing, (SHARE * self.tolerance).max(LEAST_TAIL), rounding);
            self.evaluations += fit.evaluations as u64;
            // Twenty halvings suffice for any motion that is smooth on the piece; otherwise the estimate shows the error. An
            // infinite length, which a damaged state may have, is not halved.
            if fit.converged || !(length > whole * 1e-6) {
                let (oscillator, order) = (&self.equation.oscillator, law.resolution_in(segment));
                let [error, between] = neglected(oscillator, &fit.polynomial, length);
                // On inputs a piece that ends with the step is read only at its end.
                let within = if length == horizon { [0.0; 2] } else { between };
                let angle = if self.until.is_finite() { self.motion.coefficients[0] } else { 0.0 };
                let turned = order * speed * length;
                let angle = angle.abs() + if law.breakpoints().is_empty() { 0.0 } else { OF_BREAKPOINTS };
                let step_errors = StepErrors { length, error, forcing: scale, order, turned, angle, state };
                let of_law = self.roundings[1] * speed * speed + self.roundings[0] * angles.acceleration(length);
                let of_law = self.equation.of_acceleration() * of_law;
                self.bound.disturb([0.0, of_law * length.min(1.0 / oscillator.stiffness().sqrt())]);
                self.bound.add(oscillator, (-length * oscillator.decay()).exp(), &step_errors, within);
                break fit;
            }
            length *= 0.5;
        };
        self.steps += 1.0;
        let passage = passage.filter(|_| length == whole);
        let step = ForcedStep::new(&self.equation.oscillator, length, fit.polynomial, state);
        let (next, border) = passage.map_or((segment, None), |passage| (passage.segment, Some(passage.border)));
        self.method = Method::Pieces(Piece { start, end: start + Double::from(length), segment, next, border, step });
        Ok(())
    }
}

fn no_motion(reason: &str) -> Fault {
    let reason = format!("there is no periodic motion because {reason}");
    no_periodic_motion(reason, "; choose at_rest or given, another speed, or b > 0")
}

#[cfg(test)]
mod tests;
