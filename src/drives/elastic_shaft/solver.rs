//! Integration of the twist: Gauss collocation, with steps that end where the cam passes a breakpoint of its law.

use super::equation::{Cam, Equation, Flow};
use super::passage::Place;
use crate::drives::cam_drive::AngleMotion;
use crate::drives::cam_turn::OVERRUN;
use crate::drives::step_control::{FAR, StepControl, Stop, Words};
use crate::drives::{Fault, Rounded};
use crate::motion::MotionLaw;
use crate::numerics::angle;
use crate::numerics::collocation::{Collocation, Failure, System};
use crate::numerics::double_double::Double;
use crate::numerics::work::{EVALUATION, Work};

/// The angle over which a step of degree 8 may reach, times the resolution K of the law (rad): two radians of
/// the highest harmonic cannot hide between eight nodes.
pub const REACH: f64 = 2.0;

/// Breakpoints of the law that an internal step of fixed cost may pass. The default step passes one on the average; the
/// densest laws put five of them into the angle of two.
pub const MOST_PASSAGES: u64 = 8;

/// How often the end of a step at a breakpoint is corrected by Newton's method: from an error of 1e-4 of the way the
/// first correction leaves its square, the second that of this.
const CORRECTIONS: u64 = 2;

/// How often a step that passes a breakpoint is taken: to find it, to end there, and with the corrections.
pub const STEPS_OF_PASSAGE: u64 = 2 + CORRECTIONS;

/// Newton iterations in a step of fixed cost: the linear equation is solved by one; the nonlinear one differs from its
/// linearisation by some q, and four iterations leave q¹⁶ of that.
const ITERATIONS: [usize; 2] = [4, 1];

/// Names of this drive's quantities in messages.
const WORDS: Words =
    Words { quantity: "the twist q", turning: "the cam", parameters: "J, m, c, b", frequency: "c and J" };

/// The twist of the shaft as a system of first order, y = (q, q̇), while the cam is in one segment of its law.
pub struct Twist<'a> {
    /// The equation.
    pub equation: Equation,
    /// U.
    pub law: &'a MotionLaw,
    /// φ(t).
    pub motion: &'a AngleMotion,
    /// The segment of the law.
    pub segment: usize,
    /// Rounding error of φ (rad).
    pub rounding: f64,
    /// 1, or 0 for the homogeneous linear equation.
    pub forced: f64,
    /// Work that the call has left.
    pub work: Work,
}

impl Twist<'_> {
    /// Drive and twist at `t`.
    pub fn flow(&self, t: Double, y: &[f64; 2]) -> Flow<f64> {
        let shaft = self.motion.at_instant(t);
        let [_, w, a, ..] = shaft.kinematics.0;
        Flow { phi: shaft.reduced, w, a, q: y[0], v: y[1] }
    }

    pub fn cam(&self, f: &Flow<f64>) -> Cam {
        Cam::at(self.law, self.segment, self.reduced_argument(f))
    }

    fn reduced_argument(&self, f: &Flow<f64>) -> f64 {
        angle::reduce(Double::from(f.argument(self.equation.linear)))
    }

    /// The segment in which the cam is at `t`, seen in the direction of its motion.
    pub fn locate(&mut self, t: Double, y: &[f64; 2]) {
        let f = self.flow(t, y);
        let forward = f.turning(self.equation.linear) >= 0.0;
        self.segment = self.law.segment(self.reduced_argument(&f), forward);
    }

    /// Steps until the last step ends at or beyond `target`, nowhere beyond `limit`.
    fn integrate(
        &mut self,
        integrator: &mut Collocation<2>,
        target: Double,
        limit: Double,
        control: StepControl,
    ) -> Result<(), Fault> {
        let way = [integrator.end().hi, target.hi];
        let (mut work, cost) = (self.work, EVALUATION + self.law.cost());
        let integrated =
            control.integrate(integrator, target, STEPS_OF_PASSAGE * MOST_PASSAGES, (&mut work, cost), |integrator| {
                self.step(integrator, limit, control)
            });
        self.work = work;
        integrated.map_err(|stop| self.fault(stop, control, way))
    }

    /// Steps beyond `target`, so that the steps do not depend on where the target lies.
    pub fn pass(&mut self, integrator: &mut Collocation<2>, target: f64, control: StepControl) -> Result<(), Fault> {
        self.integrate(integrator, Double::from(target), FAR, control)
    }

    /// Steps up to `target` exactly.
    pub fn reach(
        &mut self,
        integrator: &mut Collocation<2>,
        target: Double,
        control: StepControl,
    ) -> Result<(), Fault> {
        self.integrate(integrator, target, target, control)
    }

    /// One step, shortened to where the cam leaves its segment.
    fn step(&mut self, integrator: &mut Collocation<2>, limit: Double, control: StepControl) -> Result<(), Failure> {
        if self.law.breakpoints().is_empty() {
            return self.step_smoothly(integrator, limit, control);
        }
        if let Some(segment) = self.step_to_breakpoint(integrator, limit, control)? {
            self.segment = segment;
            if matches!(control, StepControl::Tolerance(_)) {
                // Behind a dwell, in which the twist dies out or swings fast, another motion begins.
                integrator.forget();
            }
        }
        Ok(())
    }

    /// One step to `limit` at most or the first breakpoint; the segment beyond it where the step ends there.
    fn step_to_breakpoint(
        &self,
        integrator: &mut Collocation<2>,
        limit: Double,
        control: StepControl,
    ) -> Result<Option<usize>, Failure> {
        let before = integrator.clone();
        let (start, mut f, mut delay) = (before.end(), self.flow(before.end(), &before.state()), 0.0);
        let place = Place::new((self.law, self.segment), start, &f, self.equation.linear);
        self.step_smoothly(integrator, limit, control)?;
        let Some(mut exit) = place.exit(self.motion, integrator) else { return Ok(None) };
        let (latest, count) = (integrator.end(), self.law.breakpoints().len());
        let beyond = if exit.forward { (self.segment + 1) % count } else { (self.segment + count - 1) % count };
        for correction in 0..=CORRECTIONS {
            integrator.return_to(&before);
            self.step_smoothly(integrator, exit.time, control)?;
            if (exit.time - integrator.end()).hi > 0.0 {
                // The tolerance asks for a shorter step, so the way to the breakpoint is left to the next one.
                return Ok(None);
            }
            f = self.flow(integrator.end(), &integrator.state());
            delay = place.delay(&f, exit.forward);
            let better = exit.time - Double::from(delay);
            let possible = (better - before.end()).hi > 0.0 && (latest - better).hi >= 0.0;
            let far = (delay * f.turning(self.equation.linear)).abs() > 2.0 * OVERRUN;
            if correction == CORRECTIONS || !far || !possible || !self.matters(integrator, beyond, delay) {
                break;
            }
            exit.time = better;
        }
        let (jump, passed) = (self.jump(integrator, beyond), (integrator.end() - before.end()).hi);
        // What q̇ would have gained beyond the breakpoint, at the speed that the cam has now.
        integrator.push(1, jump * delay.abs().min(passed).copysign(delay));
        // Unknown are some roundings of angles near 2π, and what the speed changes meanwhile.
        let late = (4.0 * f64::EPSILON + self.rounding + 0.5 * f.a.abs() * delay * delay)
            / f.turning(self.equation.linear).abs();
        integrator.disturb([0.0, jump * late.min(passed)]);
        Ok(Some(beyond))
    }

    /// Difference of q̈ between the segment `beyond` and the present one where the last step ended (rad/s²).
    fn jump(&self, integrator: &Collocation<2>, beyond: usize) -> f64 {
        let f = self.flow(integrator.end(), &integrator.state());
        let acceleration = |segment| {
            let cam = Cam::at(self.law, segment, self.reduced_argument(&f));
            self.equation.acceleration(&cam, &f, self.forced)
        };
        acceleration(beyond) - acceleration(self.segment)
    }

    /// Whether the speed errs by more than the last step itself where the cam enters the segment `beyond` late by
    /// `delay`. Where U″ is continuous the accelerations on both sides differ by the delay, too, and it seldom does.
    fn matters(&self, integrator: &Collocation<2>, beyond: usize, delay: f64) -> bool {
        let error = self.jump(integrator, beyond) * delay;
        error.abs() > integrator.end_error()[1].max(f64::EPSILON * integrator.state()[1].abs())
    }

    /// One step in which the cam stays in its segment, or on the continuation of it.
    fn step_smoothly(
        &self,
        integrator: &mut Collocation<2>,
        limit: Double,
        control: StepControl,
    ) -> Result<(), Failure> {
        control.step(integrator, self, limit, ITERATIONS[usize::from(self.equation.linear)])
    }

    /// ∂q̈/∂φ at the end of the last step (1/s²).
    pub fn slope(&self, integrator: &Collocation<2>) -> f64 {
        let f = self.flow(integrator.end(), &integrator.state());
        self.equation.slope(&self.cam(&f), &f)
    }

    fn fault(&self, stop: Stop, control: StepControl, way: [f64; 2]) -> Fault {
        match (stop, control) {
            (Stop::Failed(Failure::Unbounded { time }), _) => unbounded(time, self.equation.linear),
            (Stop::TooManyAttempts { time }, StepControl::Grid { step, .. }) => Fault::new(format!(
                "the cam passes more than {MOST_PASSAGES} breakpoints of its law within an internal step of {} s, at \
                 t = {} s; shorten solver.step_size, or set solver.method = adaptive",
                Rounded(step),
                Rounded(time)
            )),
            _ => control.fault(stop, &WORDS, way, self.motion),
        }
    }
}

/// The twist has left the range of numbers that can be gone on with.
pub fn unbounded(time: f64, linear: bool) -> Fault {
    Fault::new(format!(
        "the twist q grows without bound, at t = {} s beyond 1e100 rad: the drive is parametrically unstable, or \
         an input jumped far; change the speed, raise b{}",
        Rounded(time),
        if linear { ", or set shaft.linear = false" } else { "" }
    ))
}

impl System<2> for Twist<'_> {
    fn rhs(&self, t: Double, y: &[f64; 2]) -> [f64; 2] {
        let f = self.flow(t, y);
        [y[1], self.equation.acceleration(&self.cam(&f), &f, self.forced)]
    }

    fn jacobian(&self, t: Double, y: &[f64; 2]) -> [[f64; 2]; 2] {
        let f = self.flow(t, y);
        [[0.0, 1.0], self.equation.jacobian(&self.cam(&f), &f)]
    }

    fn rounding(&self, t: Double, y: &[f64; 2]) -> [f64; 2] {
        let f = self.flow(t, y);
        // Those of the segment: beside a steep rise a gentle return would count all it errs by as rounding.
        let curvatures = [2, 3].map(|order| self.law.bound_in(self.segment, order));
        [0.0, f64::EPSILON * self.equation.rounding(&self.cam(&f), &f, curvatures)]
    }

    fn longest_step(&self, t: Double, y: &[f64; 2]) -> f64 {
        let f = self.flow(t, y);
        let reach = REACH / self.law.resolution_in(self.segment).max(1.0);
        let speed = if self.equation.linear { f.w.abs() } else { f.w.abs().max(f.cam_speed().abs()) };
        (reach / speed).min((2.0 * reach / f.a.abs()).sqrt())
    }
}
