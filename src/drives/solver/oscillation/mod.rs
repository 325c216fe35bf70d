//! One oscillator on a driven shaft, in operation: q̈ = f(φ, ω, α, q, q̇) with φ(t) given by a constant speed or by inputs.
//!
//! Drives differ by their [`Equation`]; a drive adds its names. Two ways lead from one communication point to the next:
//!
//! - *table*, for a linear equation at constant speed (module `turn`): all motions over a period as polynomials, so that a step
//!   costs the same however long it is;
//! - *steps* of Gauss collocation otherwise (module `steps`), each within one segment of the law, under the tolerance or of
//!   fixed cost.
//!
//! Where inputs jump, the mass keeps its place and its speed.

mod passage;
mod periodic;
pub(in crate::drives) mod steps;
mod turn;

use crate::drives::follower::equation::{Equation, Pace, Segments};
use crate::drives::follower::flow::Flow;
use crate::drives::follower::load::Load;
use crate::drives::limits::{NEUTRAL, no_state, periodic_motion_that, refused_start};
use crate::drives::settings::{HasSolver, Method, Settings, Solver};
use crate::drives::shaft::cam_drive::{
    AngleMotion, CamDrive, HasCamDrive, Start, StartMode, field, goes_on, half_a_place, push_of_rounding,
};
use crate::drives::shaft::free::signal::Signal;
use crate::drives::shaft::loads::{HasLoads, log_pull};
use crate::drives::solver::step_control::{FAR, ROUNDINGS, StepControl};
use crate::drives::{EventLog, Fault, Seed};
use crate::numerics::collocation::Collocation;
use crate::numerics::double_double::Double;
use crate::numerics::period_map::Trajectory;
use crate::numerics::taylor::Series;
pub use periodic::Found;
use periodic::{periodic, unstable};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
pub use steps::Moving;
use steps::unbounded;
pub use turn::Table;

/// The drive in operation.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Oscillation<E: Equation> {
    pub(in crate::drives) equation: E,
    pub(in crate::drives) cam: CamDrive<E::Law>,
    pub(in crate::drives) start: Start,
    pub(in crate::drives) solver: Solver,
    /// The parameters of the last internal step.
    used: E::Parameters,
    /// Whether they have changed since then.
    tuned: bool,
    /// φ(t) through the communication point.
    pub(in crate::drives) motion: AngleMotion,
    integrator: Collocation<2>,
    /// The default internal step of fixed cost at constant speed (s).
    usual_step: f64,
    /// The linear equation at constant speed over its period; follows from the parameters, and all instances with the same ones
    /// share it.
    #[serde(skip)]
    pub(in crate::drives) table: Option<Arc<Table<E>>>,
    /// The way through the table; None while the integrator works.
    pub(in crate::drives) trajectory: Option<Trajectory>,
    /// ln of the largest modulus of the Floquet multipliers over a turn; 0 if it is unknown.
    pub(in crate::drives) growth: f64,
    /// The segments at the end of the integrator's last step.
    segments: Segments,
    /// The input F; None if the equation has none.
    pub(in crate::drives) force: Option<Signal>,
    /// Whether a load has been changed since the last internal step.
    pub(in crate::drives) loaded_anew: bool,
    /// Whether the log has reported that the cam pulls.
    logged: bool,
    /// The effect of the roundings of the law's coefficients on q̈ at the speed 1 rad/s; see [`Equation::roundings`].
    roundings: f64,
    /// The largest errors of q and q̇ by the roundings of law and inputs, and the largest |q| and |q̇| so far.
    shaken: [f64; 2],
    largest: [f64; 2],
    /// The communication point (s).
    pub(in crate::drives) time: f64,
    /// q (rad or m) and q̇ there.
    pub(in crate::drives) state: [f64; 2],
    /// φ, ω, q, q̇ at the end of the previous communication step, from which jumps of the inputs count.
    pub(in crate::drives) before: [f64; 4],
    pub(in crate::drives) log: EventLog,
}

/// Methods of [`Drive`](crate::drives::Drive) that all oscillations on a driven shaft share.
macro_rules! as_every_oscillation {
    () => {
        const INPUT_DERIVATIVES: usize = $crate::drives::shaft::cam_drive::MAX_INPUT_DERIVATIVE;

        $crate::drives::shaft::cam_drive::as_every_cam_drive!();

        fn apply(&mut self, time: f64) -> Result<(), Fault> {
            self.check_loads()?;
            self.take_up(time);
            Ok(())
        }

        fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
            self.go_on(time, time + step)?;
            self.watch();
            Ok(())
        }

        fn is_finite(&self) -> bool {
            $crate::numerics::number::all_finite(self.state)
        }

        fn restored(&mut self, made: &Self) -> Result<(), Fault> {
            self.resume(made)
        }
    };
}
pub(in crate::drives) use as_every_oscillation;

impl<E: Equation> Oscillation<E> {
    /// A drive at time zero.
    pub fn of(mut equation: E, cam: CamDrive<E::Law>, start: Start, settings: Settings) -> Self {
        let is_law = equation.prepare(&cam.law).is_ok();
        let mut drive = Oscillation {
            used: equation.parameters(),
            motion: cam.motion(0.0),
            equation,
            cam,
            start,
            solver: Solver::new(settings),
            tuned: false,
            integrator: Collocation::new(Double::default(), [0.0; 2]),
            usual_step: 0.0,
            table: None,
            trajectory: None,
            growth: 0.0,
            segments: [0; 2],
            force: None,
            loaded_anew: false,
            logged: false,
            roundings: 0.0,
            shaken: [0.0; 2],
            largest: [0.0; 2],
            time: 0.0,
            state: [0.0; 2],
            before: [0.0; 4],
            log: EventLog::default(),
        };
        drive.force = drive.equation.has_input().then(Signal::default);
        if is_law {
            drive.tabulate(drive.used);
        }
        drive
    }

    /// Starts at time zero on the periodic motion, stable or not.
    ///
    /// # Errors
    /// There is no periodic motion.
    pub fn periodic_motion(&mut self) -> Result<Found, Fault> {
        self.start.mode = StartMode::SteadyState;
        let found = self.begin_within(0.0, f64::INFINITY)?;
        found.ok_or_else(|| refused_start("there is no periodic motion"))
    }

    /// Computes the initial state at `time` (s).
    pub(in crate::drives) fn begin(&mut self, time: f64) -> Result<(), Fault> {
        self.begin_within(time, NEUTRAL).map(drop)
    }

    /// The same; a periodic motion whose disturbances grow by more than `most` in a turn is refused.
    fn begin_within(&mut self, time: f64, most: f64) -> Result<Option<Found>, Fault> {
        self.equation.prepare(&self.cam.law)?;
        (self.time, self.logged) = (time, false);
        self.cam.start(time);
        self.force.iter_mut().for_each(Signal::step_begins);
        self.solver.start();
        self.motion = self.cam.motion(time);
        self.integrator = Collocation::new(Double::from(time), [0.0; 2]);
        self.roundings = self.equation.roundings(&self.cam.law);
        let table = self.tabulate(self.equation.parameters());
        self.growth = table.growth;
        let mut found = None;
        self.state = match self.start.mode {
            StartMode::AtRest => [0.0, 0.0],
            StartMode::Given => [self.start.q, self.start.q_dot],
            StartMode::Equilibrium => {
                let there = self.moving().0.flow(Double::from(time), &[0.0; 2]);
                self.equation.at_rest(&self.cam.law, &there)?
            }
            StartMode::SteadyState if self.cam.is_input() => {
                return Err(periodic_motion_that(
                    "needs a constant speed",
                    "; this drive follows its inputs: set start.mode = at_rest or given",
                ));
            }
            StartMode::SteadyState if self.force.as_ref().is_some_and(|force| !force.is_constant()) => {
                return Err(periodic_motion_that(
                    "needs loads that repeat themselves with the turns, but the input F changes with time",
                    ": set start.mode = equilibrium, at_rest or given",
                ));
            }
            StartMode::SteadyState => {
                let (tolerance, given) = (self.solver.effective_tolerance(), [self.start.q, self.start.q_dot]);
                let motion = found.insert(periodic(&mut self.moving().0, &table, time, given, tolerance)?);
                if motion.growth > most {
                    return Err(unstable(motion.growth, self.motion.coefficients[1]));
                }
                motion.state
            }
        };
        (self.shaken, self.largest) = ([0.0; 2], self.state.map(f64::abs));
        self.restart_integrator();
        self.trajectory = table.map.as_ref().map(|map| Trajectory::new(map, time, self.state));
        if let Some(map) = &table.map {
            self.solver.evaluations = map.evaluations() as f64;
            self.solver.error_estimate = table.error_after(0.0);
        }
        self.remember();
        Ok(found)
    }

    /// Refuses changed loads that make no law.
    pub(in crate::drives) fn check_loads(&self) -> Result<(), Fault> {
        let changed = self.equation.load().as_ref().filter(|_| self.loaded_anew);
        changed.map_or(Ok(()), |load| load.validate("load"))
    }

    /// Takes up parameters and inputs at the communication point `time` (s); returns whether the shaft jumps there.
    pub(in crate::drives) fn take_up(&mut self, time: f64) -> bool {
        self.time = time;
        self.tuned = self.loaded_anew || self.used != self.equation.parameters();
        if self.cam.is_input() {
            self.motion = self.cam.motion(time);
            let ([phi, w, a, ..], [before, speed, q, v]) = (self.motion.coefficients, self.before);
            self.state = [q, v];
            if !goes_on([before, speed, a], [phi, w], time) {
                // Place and speed of the mass do not jump, so q and q̇ take up the jumps of the motion that they count from.
                let [now, before] = [[phi, w], [before, speed]].map(|[phi, w]| {
                    let f = Flow { phi, w, a, q, v, force: 0.0 };
                    self.equation.base(&self.local(E::at, &f), &f)
                });
                self.state = [q - (now[0] - before[0]), v - (now[1] - before[1])];
                return true;
            }
        }
        false
    }

    /// From the communication point `time` to `target` (s).
    #[inline]
    pub(in crate::drives) fn go_on(&mut self, time: f64, target: f64) -> Result<(), Fault> {
        // Most steps end in the cell of the table where they start.
        if let Some(trajectory) = &self.trajectory
            && let Some(state) = trajectory.within(target).filter(|_| !self.tuned)
        {
            (self.state, self.time) = (state, target);
            return Ok(());
        }
        self.go_further(time, target)
    }

    /// Logs when the cam begins to pull.
    pub(in crate::drives) fn watch(&mut self) {
        let forces = self.equation.contact(|| self.now(E::at));
        log_pull(&mut self.logged, forces, self.time, 0, &mut self.log);
    }

    /// A step that leaves the present cell of the table, or goes without one.
    #[cold]
    #[inline(never)]
    fn go_further(&mut self, time: f64, target: f64) -> Result<(), Fault> {
        if self.tuned {
            // A new table would allocate within a step, and a user who tunes once may tune again.
            self.trajectory = None;
        }
        if let (Some(trajectory), Some(table)) = (&mut self.trajectory, &self.table)
            && let Some(map) = &table.map
        {
            trajectory.reach(map, target).map_err(|fault| unbounded(&self.equation, fault.time, self.growth))?;
            (self.state, self.time) = (trajectory.at(map, target), target);
            self.solver.steps = trajectory.steps as f64;
            self.solver.error_estimate = table.error_after(trajectory.periods(map, target));
            return Ok(());
        }
        self.integrate(time, target)
    }

    /// A step with the integrator.
    fn integrate(&mut self, time: f64, target: f64) -> Result<(), Fault> {
        if self.take_up(time) {
            let [phi, w, ..] = self.before;
            self.cam.jumps([phi, w], time, &mut self.log);
        }
        self.force.iter_mut().for_each(Signal::step_begins);
        let (on_inputs, on_shaft) = (self.is_on_inputs(), self.cam.is_input());
        let usual = if on_inputs { self.usual_step(target) } else { self.usual_step };
        let control = self.control(target, usual);
        if on_inputs || self.tuned {
            self.restart_integrator();
        }
        let roundings = self.roundings;
        let (mut moving, integrator) = self.moving();
        let mut limit = FAR;
        if on_inputs {
            // The motion is only known up to the end of the communication step.
            limit = Double::from(target);
        }
        if on_shaft {
            let [phi, w, a, ..] = moving.motion.coefficients;
            let slope = moving.slope(integrator);
            let alike = usual.min(target - time);
            let push = push_of_rounding([phi, w, a], time, slope, alike);
            integrator.disturb([0.0, push]);
            // If the rounding of the inputs, a quarter of the last place in the mean, counts as no jump, the mass keeps neither
            // place nor speed.
            let [place, speed] = moving.base([phi, w]).map(|base| 0.25 * f64::EPSILON * base);
            integrator.shake([place, speed.abs() + roundings * w * w * alike]);
        }
        moving.integrate(integrator, Double::from(target), limit, control)?;
        self.time = target;
        self.state = self.integrator.at(Double::from(target));
        self.remember();
        self.cam.step_done(&self.motion, target);
        self.force.iter_mut().for_each(|force| force.step_ends(target - time));
        let statistics = self.integrator.statistics;
        let shaken = self.integrator.shaken();
        for c in 0..2 {
            self.shaken[c] = self.shaken[c].max(shaken[c]);
            self.largest[c] = self.largest[c].max(self.state[c].abs());
        }
        let error = control.error_estimate(&statistics, on_inputs);
        self.solver.steps = statistics.steps as f64;
        self.solver.evaluations = statistics.evaluations as f64;
        // The disturbances of q and q̇, which may begin small, count against the motion as it has become.
        let shaken = |c: usize| ROUNDINGS * self.shaken[c] / self.largest[c];
        let before = if on_inputs { shaken(0).max(shaken(1)) } else { self.solver.error_estimate };
        self.solver.error_estimate = error.max(before);
        Ok(())
    }

    /// Rebuilds, after reading from bytes, the parts that the serialisation leaves out.
    pub(in crate::drives) fn resume(&mut self, made: &Self) -> Result<(), Fault> {
        self.cam.take(&made.cam);
        // Only the parameters of a load count, too.
        self.equation = made.equation.clone();
        // A law that is none is refused at the start.
        let _ = self.equation.prepare(&self.cam.law);
        if self.loaded_anew {
            // They belong to a process force that has changed since; the next step finds them anew.
            self.segments = [0; 2];
        }
        let breakpoints = self.equation.breakpoints(&self.cam.law);
        if [0, 1].iter().any(|i| self.segments[*i] >= breakpoints[*i].len().max(1)) {
            return Err(no_state());
        }
        let Some(trajectory) = self.trajectory.take() else { return Ok(()) };
        if self.loaded_anew {
            self.restart_integrator();
            return Ok(());
        }
        self.table = made.table.clone();
        // A state on the table was reached with the parameters of the last step.
        if self.tabulate(self.used).map.as_ref().is_some_and(|map| trajectory.is_in(map)) {
            self.trajectory = Some(trajectory);
        } else {
            self.restart_integrator();
        }
        Ok(())
    }

    /// The oscillator on its way to the next communication point, and the integrator; the only one of a call that takes work.
    pub(in crate::drives) fn moving(&mut self) -> (Moving<'_, E>, &mut Collocation<2>) {
        let [phi, w, a, ..] = self.motion.coefficients;
        let rounding = if self.cam.is_input() { half_a_place([phi, w, a], self.time) } else { 0.0 };
        let moving = Moving::new(&self.equation, &self.cam.law, &self.motion, &mut self.segments);
        let force = self.force.as_ref().map(|force| (force, self.time));
        (Moving { rounding, growth: self.growth, force, ..moving }, &mut self.integrator)
    }

    /// Lets the integrator go on from the state at the communication point.
    fn restart_integrator(&mut self) {
        let (time, y) = (Double::from(self.time), self.state);
        (self.used, self.tuned, self.loaded_anew) = (self.equation.parameters(), false, false);
        if !self.cam.is_input() {
            self.usual_step = self.usual_step(self.time);
        }
        let (mut moving, integrator) = self.moving();
        integrator.restart(time, y);
        moving.locate(time, &y);
    }

    /// The equation with these parameters over a period, tabulated unless it already is.
    fn tabulate(&mut self, parameters: E::Parameters) -> Arc<Table<E>> {
        let (equation, tolerance) = (self.equation.with(parameters), self.solver.effective_tolerance());
        let known = self.table.take().filter(|table| table.is_for(&equation, &self.cam, tolerance));
        let table = known.unwrap_or_else(|| Arc::new(Table::new(equation, &self.cam, tolerance)));
        self.table.insert(table).clone()
    }

    /// Whether the motion is only known up to the end of the communication step.
    fn is_on_inputs(&self) -> bool {
        self.cam.is_input() || self.force.is_some()
    }

    /// The rule for the internal steps on the way to `target`. At constant speed the grid of fixed cost starts with the simulation;
    /// on inputs, whose motion has its corners at the communication points, it divides the communication step equally, by the
    /// longest steps that do not exceed the requested ones, by default `usual` (s).
    fn control(&self, target: f64, usual: f64) -> StepControl {
        let Settings { method, step_size, .. } = self.solver.settings;
        if method == Method::Adaptive {
            return StepControl::Tolerance(self.solver.effective_tolerance());
        }
        let step = if step_size > 0.0 { step_size } else { usual };
        if !self.is_on_inputs() {
            return StepControl::Grid { origin: self.motion.origin, step };
        }
        let length = target - self.time;
        StepControl::Grid { origin: self.time, step: length / (length / step).ceil().max(1.0) }
    }

    /// The default internal step of fixed cost on the way to `target` (s): half a radian of the fastest vibration, or what the law
    /// allows at the highest speed, whichever is shorter.
    fn usual_step(&self, target: f64) -> f64 {
        let Pace { frequency, angle, speed } = self.equation.pace(&self.cam.law, self.state);
        let speed_at = |time: f64| self.motion.at(time).kinematics.0[1].abs();
        (0.5 / frequency).min(angle / (speed_at(self.time).max(speed_at(target)) + speed))
    }

    /// φ, ω, q, q̇ at the communication point on the present motion.
    fn remember(&mut self) {
        let [phi, w, ..] = self.motion.at(self.time).kinematics.0;
        self.before = [phi, w, self.state[0], self.state[1]];
    }

    /// The law in the present state of drive and oscillator.
    #[inline]
    fn local(&self, at: impl Fn(&E, &E::Law, Segments, &Flow<f64>) -> E::Local, f: &Flow<f64>) -> E::Local {
        at(&self.equation, &self.cam.law, self.equation.segments(&self.cam.law, f), f)
    }

    /// The law, and drive and oscillator at the communication point; φ is not reduced.
    #[inline]
    pub(in crate::drives) fn now(
        &self,
        at: impl Fn(&E, &E::Law, Segments, &Flow<f64>) -> E::Local,
    ) -> (E::Local, Flow<f64>) {
        let (shaft, [q, v]) = (self.motion.at(self.time), self.state);
        let [phi, w, a, ..] = shaft.kinematics.0;
        let force = self.force.as_ref().map_or(0.0, Signal::now);
        let f = Flow { phi, w, a, q, v, force };
        (self.local(at, &Flow { phi: shaft.reduced, ..f }), f)
    }

    /// Drive and oscillator as functions of time; each pass of the equation yields one more derivative of q̇. Or as functions of
    /// one input or one of the two `states`, place and speed of the mass, with the others constant.
    pub(in crate::drives) fn along(
        &self,
        seed: Seed,
        states: [&str; 2],
        local: &E::Local,
        f: &Flow<f64>,
    ) -> Flow<Series> {
        if seed != Seed::Time {
            let known = |name: &str, value: f64| Series([value, seed.of(name), 0.0]);
            let (phi, w, a) = (known("phi", f.phi), known("w", f.w), known("a", f.a));
            let shaft = Flow { phi, w, a, q: f.q.into(), v: f.v.into(), force: known("F", f.force) };
            let [base, speed] = self.equation.base(local, &shaft);
            let by = |state: usize, base: Series| seed.of(states[state]) - base.derivative(1);
            return Flow { q: Series([f.q, by(0, base), 0.0]), v: Series([f.v, by(1, speed), 0.0]), ..shaft };
        }
        let [_, w, a, jerk, snap] = self.motion.at(self.time).kinematics.0;
        let acceleration = self.equation.acceleration(local, f);
        let mut along = Flow {
            phi: Series::from_derivatives(f.phi, w, a),
            w: Series::from_derivatives(w, a, jerk),
            a: Series::from_derivatives(a, jerk, snap),
            q: Series::from_derivatives(f.q, f.v, acceleration),
            v: Series::from_derivatives(f.v, acceleration, 0.0),
            force: self.force.as_ref().map_or(f.force.into(), Signal::series),
        };
        let third = self.equation.acceleration(local, &along).derivative(1);
        along.v = Series::from_derivatives(f.v, acceleration, third);
        along
    }
}

impl<E: Equation> HasCamDrive for Oscillation<E> {
    type Law = E::Law;

    field!(cam, cam_mut: CamDrive<E::Law> = cam);
    field!(start_values, start_values_mut: Start = start);
}

impl<E: Equation> HasLoads for Oscillation<E> {
    fn load(&self, which: usize) -> Option<&Load> {
        self.equation.load().as_deref().filter(|_| which == 0)
    }

    fn load_mut(&mut self, which: usize) -> Option<&mut Load> {
        self.loaded_anew = true;
        self.equation.load_mut().as_mut().filter(|_| which == 0).map(Arc::make_mut)
    }

    fn signal(&self, _: usize) -> Option<&Signal> {
        self.force.as_ref()
    }

    fn signal_mut(&mut self, _: usize) -> Option<&mut Signal> {
        self.force.as_mut()
    }
}

impl<E: Equation> HasSolver for Oscillation<E> {
    field!(solver, solver_mut: Solver = solver);
    fn has_method(&self) -> bool {
        // The table of a linear equation at constant speed costs the same at every step.
        !self.equation.is_linear() || self.is_on_inputs()
    }
}
