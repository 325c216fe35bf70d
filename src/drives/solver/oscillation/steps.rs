//! Integration of the oscillator: Gauss collocation, with steps that end at the breakpoints of the law.

use super::passage::{Exit, Place};
use crate::drives::follower::equation::{Equation, Segments, Words};
use crate::drives::follower::flow::Flow;
use crate::drives::limits::step_too_much;
use crate::drives::shaft::cam_drive::AngleMotion;
use crate::drives::shaft::cam_turn::OVERRUN;
use crate::drives::shaft::free::signal::Signal;
use crate::drives::solver::step_control::{StepControl, WORST};
use crate::drives::{Fault, Rounded};
use crate::numerics::collocation::{Collocation, Failure, System};
use crate::numerics::double_double::Double;
use crate::numerics::work::{EVALUATION, Work};

/// How often Newton's method corrects the end of a step at a breakpoint: from an error of 1e-4 of the way the first correction
/// leaves its square, the second the square of this.
const CORRECTIONS: u64 = 2;

/// Breakpoints of the law that an internal step of fixed cost may pass. The default step passes one on the average; the
/// densest laws put five of them into the angle of two.
const MOST_PASSAGES: u64 = 8;

/// Attempts of an internal step of fixed cost: at each passage one to find it, one to end there, and the corrections.
pub const ATTEMPTS: u64 = MOST_PASSAGES * (2 + CORRECTIONS);

/// Newton iterations in a step of fixed cost: one solves a linear equation; a nonlinear one differs from its linearisation by some
/// q, and four iterations leave q¹⁶ of that.
const ITERATIONS: [usize; 2] = [4, 1];

/// The oscillator as a system of first order, y = (q, q̇), while its law is in one segment.
pub struct Moving<'a, E: Equation> {
    /// The equation.
    pub equation: &'a E,
    /// The law over the angle.
    pub law: &'a E::Law,
    /// φ(t).
    pub motion: &'a AngleMotion,
    /// The segments of the law and of the process force.
    pub segments: &'a mut Segments,
    /// The input F, and the start of its step (s).
    pub force: Option<(&'a Signal, f64)>,
    /// Rounding error of φ (rad).
    pub rounding: f64,
    /// ln of the largest modulus of the Floquet multipliers over a turn; 0 if it is unknown.
    pub growth: f64,
    /// The remaining work of the call.
    pub work: Work,
}

impl<'a, E: Equation> Moving<'a, E> {
    /// The oscillator on a motion of the shaft without rounding.
    pub fn new(equation: &'a E, law: &'a E::Law, motion: &'a AngleMotion, segments: &'a mut Segments) -> Self {
        Moving { equation, law, motion, segments, force: None, rounding: 0.0, growth: 0.0, work: Work::default() }
    }

    /// Drive and oscillator at `t`.
    pub fn flow(&self, t: Double, y: &[f64; 2]) -> Flow<f64> {
        let shaft = self.motion.at_instant(t);
        let [_, w, a, ..] = shaft.kinematics.0;
        let force = self.force.map_or(0.0, |(signal, begun)| signal.at((t - Double::from(begun)).hi));
        Flow { phi: shaft.reduced, w, a, q: y[0], v: y[1], force }
    }

    fn local(&self, f: &Flow<f64>) -> E::Local {
        self.equation.at(self.law, *self.segments, f)
    }

    /// Finds the segments of the law at `t`.
    pub fn locate(&mut self, t: Double, y: &[f64; 2]) {
        *self.segments = self.equation.segments(self.law, &self.flow(t, y));
    }

    /// Steps until the last one ends at or beyond `target`, nowhere beyond `limit`. If `limit` is far the steps do not depend on
    /// the target.
    pub fn integrate(
        &mut self,
        integrator: &mut Collocation<2>,
        target: Double,
        limit: Double,
        control: StepControl,
    ) -> Result<(), Fault> {
        let (first, cost) = (integrator.statistics.steps, EVALUATION + self.equation.cost(self.law));
        let way = [integrator.end().hi, target.hi];
        let mut most = f64::INFINITY;
        if let StepControl::Grid { step, .. } = control {
            let steps = ((target - integrator.end()).hi / step).ceil() + 1.0;
            // Steps that nobody can wait for are refused before the first.
            if !self.work.allows(cost * steps) {
                return Err(self.too_much(control, way, way[0]));
            }
            most = ATTEMPTS as f64 * steps;
        }
        while (target - integrator.end()).hi > 0.0 {
            let (time, before) = (integrator.end().hi, integrator.statistics.evaluations);
            self.step(integrator, limit, control).map_err(|failure| self.failed(failure, control))?;
            // A step without evaluations would repeat for ever.
            let evaluations = (integrator.statistics.evaluations - before).max(1);
            self.work.draw(cost * evaluations as f64).map_err(|_| self.too_much(control, way, time))?;
            if let StepControl::Grid { step, .. } = control
                && (integrator.statistics.steps - first) as f64 > most
            {
                return Err(Fault::new(format!(
                    "{} passes more than {MOST_PASSAGES} breakpoints of its law within an internal step of {} s, at t = {} s; \
                     shorten solver.step_size, or set solver.method = adaptive",
                    self.equation.words().turning,
                    Rounded(step),
                    Rounded(time)
                )));
            }
        }
        Ok(())
    }

    /// The fault of a failed step.
    fn failed(&self, failure: Failure, control: StepControl) -> Fault {
        let Words { quantity, turning, parameters, .. } = self.equation.words();
        let (Failure::Stalled { time } | Failure::Unbounded { time }) = failure;
        let why = match (failure, control) {
            (Failure::Unbounded { .. }, _) => return unbounded(self.equation, time, self.growth),
            (_, StepControl::Grid { step, .. }) => format!(
                " with internal steps of {} s: they turn {turning} too far, or miss more than {WORST} of the motion; shorten \
                 solver.step_size, or set solver.method = adaptive",
                Rounded(step)
            ),
            (_, StepControl::Tolerance(_)) => format!(
                ": no internal step keeps the tolerance; check {parameters} and the speed, or relax solver.tolerance"
            ),
        };
        Fault::new(format!("{quantity} cannot be computed beyond t = {} s{why}", Rounded(time)))
    }

    /// The fault of work used up at `time` (s) on the way from one time to another.
    fn too_much(&self, control: StepControl, way: [f64; 2], time: f64) -> Fault {
        let Words { turning, frequency, .. } = self.equation.words();
        let grid = matches!(control, StepControl::Grid { .. });
        let setting = if grid { "lengthen solver.step_size" } else { "relax solver.tolerance" };
        let hint = format!("{setting}, or check the speed, {frequency}");
        step_too_much(way, time, &self.motion.describe(turning, way), &hint)
    }

    /// One step, shortened to the end of the law's segment.
    fn step(&mut self, integrator: &mut Collocation<2>, limit: Double, control: StepControl) -> Result<(), Failure> {
        if self.equation.breakpoints(self.law).iter().all(|list| list.is_empty()) {
            return self.step_smoothly(integrator, limit, control);
        }
        if let Some(segments) = self.step_to_breakpoint(integrator, limit, control)? {
            *self.segments = segments;
            if matches!(control, StepControl::Tolerance(_)) {
                // After a dwell, in which the oscillator dies out or swings fast, another motion begins.
                integrator.forget();
            }
        }
        Ok(())
    }

    /// One step to `limit` at most or the first breakpoint; returns the segments beyond it if the step ends there.
    fn step_to_breakpoint(
        &self,
        integrator: &mut Collocation<2>,
        limit: Double,
        control: StepControl,
    ) -> Result<Option<Segments>, Failure> {
        let (before, breakpoints, carries) =
            (integrator.clone(), self.equation.breakpoints(self.law), self.equation.carried());
        let (start, mut f, mut delay) = (before.end(), self.flow(before.end(), &before.state()), 0.0);
        let places = [0, 1].map(|i| {
            let of = (breakpoints[i], self.segments[i]);
            (!of.0.is_empty()).then(|| Place::new(of, start, &f, carries[i]))
        });
        self.step_smoothly(integrator, limit, control)?;
        let exits = [0, 1].map(|i| places[i].as_ref()?.exit(self.motion, integrator));
        let first = match exits {
            [Some(own), Some(other)] => usize::from((other.time - own.time).hi < 0.0),
            [own, _] => usize::from(own.is_none()),
        };
        let (Some(place), Some(mut exit)) = (&places[first], exits[first]) else { return Ok(None) };
        let (latest, carried) = (integrator.end(), carries[first]);
        let behind = |i: usize, exit: &Exit| {
            let (segment, count) = (self.segments[i], breakpoints[i].len());
            if exit.forward { (segment + 1) % count } else { (segment + count - 1) % count }
        };
        let mut beyond = *self.segments;
        beyond[first] = behind(first, &exit);
        for correction in 0..=CORRECTIONS {
            integrator.return_to(&before);
            self.step_smoothly(integrator, exit.time, control)?;
            if (exit.time - integrator.end()).hi > 0.0 {
                // The tolerance needs a shorter step, so the way to the breakpoint is left to the next one.
                return Ok(None);
            }
            f = self.flow(integrator.end(), &integrator.state());
            delay = place.delay(&f, exit.forward);
            let better = exit.time - Double::from(delay);
            let possible = (better - before.end()).hi > 0.0 && (latest - better).hi >= 0.0;
            let far = (delay * f.turning(carried)).abs() > 2.0 * OVERRUN;
            if correction == CORRECTIONS || !far || !possible || !self.matters(integrator, beyond, delay) {
                break;
            }
            exit.time = better;
        }
        // A breakpoint within roundings is passed at once.
        if let (Some(place), Some(exit)) = (&places[1 - first], &exits[1 - first])
            && place.beyond(&f, exit.forward).abs() <= 4.0 * OVERRUN
        {
            beyond[1 - first] = behind(1 - first, exit);
        }
        let (jump, passed) = (self.jump(integrator, beyond), (integrator.end() - before.end()).hi);
        // The gain of q̇ beyond the breakpoint, at the present speed of passage.
        integrator.push(1, jump * delay.abs().min(passed).copysign(delay));
        // Unknown are some roundings of angles near 2π, and the change of the speed meanwhile.
        let late = (4.0 * f64::EPSILON + self.rounding + 0.5 * f.a.abs() * delay * delay) / f.turning(carried).abs();
        integrator.disturb([0.0, jump * late.min(passed)]);
        Ok(Some(beyond))
    }

    /// Difference of q̈ at the end of the last step between the segments `beyond` and the present ones (rad/s²).
    fn jump(&self, integrator: &Collocation<2>, beyond: Segments) -> f64 {
        let f = self.flow(integrator.end(), &integrator.state());
        let acceleration = |segments| self.equation.acceleration(&self.equation.at(self.law, segments, &f), &f);
        acceleration(beyond) - acceleration(*self.segments)
    }

    /// Whether a delay in entering the segments `beyond` adds more error of the speed than the last step itself. If q̈ is
    /// continuous, the accelerations on both sides also differ by the delay, and the error seldom matters.
    fn matters(&self, integrator: &Collocation<2>, beyond: Segments, delay: f64) -> bool {
        let error = self.jump(integrator, beyond) * delay;
        error.abs() > integrator.end_error()[1].max(f64::EPSILON * integrator.state()[1].abs())
    }

    /// One step in which the law stays in its segment, or on its continuation.
    fn step_smoothly(
        &self,
        integrator: &mut Collocation<2>,
        limit: Double,
        control: StepControl,
    ) -> Result<(), Failure> {
        control.step(integrator, self, limit, ITERATIONS[usize::from(self.equation.is_linear())])
    }

    /// Place and speed of the origin of q for the shaft at the angle `phi` (rad) with the speed `w` (rad/s).
    pub fn base(&self, [phi, w]: [f64; 2]) -> [f64; 2] {
        let f = Flow { phi, w, a: 0.0, q: 0.0, v: 0.0, force: 0.0 };
        self.equation.base(&self.local(&f), &f)
    }

    /// ∂q̈/∂φ at the end of the last step (1/s²).
    pub fn slope(&self, integrator: &Collocation<2>) -> f64 {
        let f = self.flow(integrator.end(), &integrator.state());
        self.equation.acceleration(&self.local(&f), &f.over_angle()).derivative(1)
    }
}

/// The motion has left the range of numbers in which it can continue.
pub fn unbounded(equation: &impl Equation, time: f64, growth: f64) -> Fault {
    let words = equation.words();
    let why = if growth > 0.0 {
        format!(", free vibrations grow by exp({}) in a turn; change drive.w", Rounded(growth))
    } else {
        ", or an input jumped far; change the speed".to_owned()
    };
    Fault::new(format!(
        "{} grows without bound, at t = {} s beyond 1e100: the drive is parametrically unstable{why}{} or raise the damping",
        words.quantity,
        Rounded(time),
        words.instead
    ))
}

impl<E: Equation> System<2> for Moving<'_, E> {
    fn rhs(&self, t: Double, y: &[f64; 2]) -> [f64; 2] {
        let f = self.flow(t, y);
        [y[1], self.equation.acceleration(&self.local(&f), &f)]
    }

    fn jacobian(&self, t: Double, y: &[f64; 2]) -> [[f64; 2]; 2] {
        let f = self.flow(t, y);
        [[0.0, 1.0], self.equation.jacobian(&self.local(&f), &f)]
    }

    fn rounding(&self, t: Double, y: &[f64; 2]) -> [f64; 2] {
        [0.0, f64::EPSILON * self.equation.rounding(self.law, *self.segments, &self.flow(t, y))]
    }

    fn longest_step(&self, t: Double, y: &[f64; 2]) -> f64 {
        let f = self.flow(t, y);
        let reach = self.equation.reach(self.law, *self.segments, f.phi);
        let speed = f.w.abs().max(f.turning(self.equation.carries_law()).abs());
        (reach / speed).min((2.0 * reach / f.a.abs()).sqrt())
    }
}
