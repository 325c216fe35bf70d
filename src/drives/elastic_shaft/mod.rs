//! A cam drive whose input shaft is elastic.
//!
//! The drive turns the near end of the shaft by φ(t); its far end carries the cam, at ψ = φ + q, which moves the
//! follower to y = U(ψ).
//!
//! Nonlinear: (J + m U′²) ψ̈ + m U′U″ ψ̇² + b q̇ + c q = 0, U at ψ.
//! Linear in q, U at φ, ω = φ̇, α = φ̈: (J + m U′²) q̈ + (b + 2 m ω U′U″) q̇
//! + \[c + m ω² (U″² + U′U‴) + 2 m α U′U″\] q = −m ω² U′U″ − (J + m U′²) α.
//!
//! Symbols: m mass of the follower (kg), J moment of inertia of the cam (kg·m²), c stiffness (N·m/rad) and
//! b damping (N·m·s/rad) of the shaft, q twist (rad). Signs: φ, ψ, tau positive in the same sense;
//! tau = −(c q + b q̇) is the torque from the drive into the cam unit and loads the drive where it is positive.
//!
//! Validity: the follower never leaves the cam; the linear equation where |q| is small against the angle over which
//! U′U″ changes. J > 0: without it the frequency at U′ = 0 is infinite.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.3; the right-hand side of its equation (1) reads
//! U′U″ here, as the derivation and its own rigid limit demand.

mod equation;
mod oscillator;
mod passage;
mod solver;
mod steady;
#[cfg(test)]
pub(super) mod tests;
mod turn;
mod variables;

use super::cam_drive::{
    AngleMotion, CamDrive, DriveMode, HasCamDrive, MAX_INPUT_DERIVATIVE, Start, StartMode, as_every_cam_drive, field,
    goes_on, half_a_place, push_of_rounding,
};
use super::limits::{no_state, refused_start};
use super::parameter::parameters;
use super::settings::{HasSolver, Method, Settings, Solver};
use super::step_control::StepControl;
use super::{Curve, Drive, EventLog, Experiment, Fault, List, Text};
use crate::motion::MotionLaw;
use crate::numerics::collocation::Collocation;
use crate::numerics::double_double::Double;
use crate::numerics::number::all_finite;
use crate::numerics::period_map::{PeriodMap, Trajectory};
use crate::numerics::work::Work;
use equation::Equation;
use serde::{Deserialize, Serialize};
use solver::Twist;
use std::f64::consts::TAU;
use std::sync::Arc;
use turn::Table;

parameters! {
    /// Mass, inertia and shaft.
    Parameters of ElasticShaft.parameters, "elasticity" {
        /// Mass of the follower
        m = "m", "m", MASS in [0.0, 1e9], Tunable;
        /// Moment of inertia of the cam, at the far end of the shaft; above zero
        inertia = "J", "J", INERTIA in [1e-12, 1e9], Fixed;
        /// Torsional stiffness of the input shaft; above zero
        c = "c", "c", ROTATIONAL_STIFFNESS in [1e-12, 1e15], Tunable;
        /// Torsional damping of the input shaft
        b = "b", "b", ROTATIONAL_DAMPING in [0.0, 1e12] or 0.0, Tunable;
    }
}

/// The drive as a scene describes it, coherent SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// m, J, c, b.
    pub parameters: Parameters,
    /// Whether the equation is linearised in the twist.
    pub linear: bool,
    /// U.
    pub cam: MotionLaw,
    /// φ.
    pub drive: DriveMode,
    /// Initial state.
    pub start: Start,
    /// `solver.tolerance`, `solver.method`, `solver.step_size`.
    pub solver: Settings,
}

/// The drive in operation.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ElasticShaft {
    parameters: Parameters,
    linear: bool,
    cam: CamDrive,
    start: Start,
    solver: Solver,
    /// The parameters with which the last internal step was made.
    used: Parameters,
    /// Whether they have been changed since.
    tuned: bool,
    /// φ(t) through the communication point.
    motion: AngleMotion,
    integrator: Collocation<2>,
    /// The internal step of fixed cost at constant speed where none is asked for (s).
    usual_step: f64,
    /// The linear equation at constant speed over its period; follows from the parameters, and all instances with the
    /// same ones share it.
    #[serde(skip)]
    table: Option<Arc<Table>>,
    /// The way through the table; None while the integrator is at work.
    trajectory: Option<Trajectory>,
    /// The segment of the law at the end of the integrator's last step.
    segment: usize,
    /// The communication point (s).
    time: f64,
    /// q (rad) and q̇ (rad/s) there.
    twist: [f64; 2],
    /// φ, ω, q, q̇ at the end of the previous communication step, from which jumps of the inputs are counted.
    before: [f64; 4],
    log: EventLog,
}

impl ElasticShaft {
    fn equation(&self) -> Equation {
        Equation::new(&self.parameters, self.linear)
    }

    /// Runs `task`, of a call the only one that takes work, with the twist's system of equations and the integrator.
    fn with_twist<R>(&mut self, task: impl FnOnce(&mut Twist, &mut Collocation<2>) -> R) -> R {
        let equation = self.equation();
        let (law, motion, segment) = (&self.cam.law, &self.motion, self.segment);
        let [phi, w, a, ..] = motion.coefficients;
        let rounding = if self.cam.is_input() { half_a_place([phi, w, a], self.time) } else { 0.0 };
        let work = Work::default();
        let mut twist = Twist { equation, law, motion, segment, rounding, forced: 1.0, work };
        let result = task(&mut twist, &mut self.integrator);
        self.segment = twist.segment;
        result
    }

    /// Lets the integrator go on from the twist at the communication point.
    fn restart_integrator(&mut self) {
        let (time, y) = (Double::from(self.time), self.twist);
        (self.used, self.tuned) = (self.parameters, false);
        self.usual_step = self.usual_step(self.time);
        self.with_twist(|twist, integrator| {
            integrator.restart(time, y);
            twist.locate(time, &y);
        });
    }

    /// Tabulates the equation over a period, unless it is tabulated already.
    fn tabulate(&mut self, equation: Equation) {
        let tolerance = self.solver.effective_tolerance();
        if !self.table.as_ref().is_some_and(|table| table.is_for(equation, &self.cam, tolerance)) {
            self.table = Some(Arc::new(Table::new(equation, &self.cam, tolerance)));
        }
    }

    /// The table, where there is one.
    fn map(&self) -> Option<&PeriodMap> {
        self.table.as_ref()?.map.as_ref()
    }

    /// A step that leaves the present cell of the table, or goes without one.
    #[cold]
    #[inline(never)]
    fn advance_further(&mut self, time: f64, target: f64) -> Result<(), Fault> {
        if self.tuned {
            // Tabulating anew would allocate within a step, and who tunes once may tune again.
            self.trajectory = None;
        }
        let (Some(trajectory), Some(table)) = (&mut self.trajectory, &self.table) else {
            return self.integrate(time, target);
        };
        let Some(map) = &table.map else { return self.integrate(time, target) };
        trajectory.reach(map, target).map_err(|fault| solver::unbounded(fault.time, self.linear))?;
        (self.twist, self.time) = (trajectory.at(map, target), target);
        self.solver.steps = trajectory.steps as f64;
        self.solver.error_estimate = table.error_after(trajectory.periods(map, target));
        Ok(())
    }

    /// A step with the integrator.
    fn integrate(&mut self, time: f64, target: f64) -> Result<(), Fault> {
        self.apply(time)?;
        let control = self.control(target);
        if self.cam.is_input() {
            // The motion is known up to the end of the communication step only.
            self.restart_integrator();
            let lasting = (target - time).min(self.usual_step(target));
            self.with_twist(|twist, integrator| {
                let [phi, w, a, ..] = twist.motion.coefficients;
                let slope = twist.slope(integrator);
                integrator.disturb([0.0, push_of_rounding([phi, w, a], time, slope, lasting)]);
            });
            self.with_twist(|twist, integrator| twist.reach(integrator, Double::from(target), control))?;
        } else {
            if self.tuned {
                self.restart_integrator();
            }
            self.with_twist(|twist, integrator| twist.pass(integrator, target, control))?;
        }
        self.time = target;
        self.twist = self.integrator.at(Double::from(target));
        self.remember();
        self.cam.step_done();
        let statistics = self.integrator.statistics;
        let error = control.error_estimate(&statistics, self.cam.is_input());
        self.solver.steps = statistics.steps as f64;
        self.solver.evaluations = statistics.evaluations as f64;
        self.solver.error_estimate = self.solver.error_estimate.max(error);
        Ok(())
    }

    /// The rule for the internal steps on the way to `target`. At constant speed the grid of fixed cost starts with the
    /// simulation; on inputs, whose motion has its corners at the communication points, it divides the communication
    /// step equally.
    fn control(&self, target: f64) -> StepControl {
        if self.cam.is_input() {
            return StepControl::within(&self.solver, self.time, target, || self.usual_step(target));
        }
        let Settings { method, step_size, .. } = self.solver.settings;
        if method == Method::Adaptive {
            return StepControl::Tolerance(self.solver.effective_tolerance());
        }
        let step = if step_size > 0.0 { step_size } else { self.usual_step };
        StepControl::Grid { origin: self.motion.origin, step }
    }

    /// The internal step of fixed cost on the way to `target` where none is asked for (s): half a radian of the fastest
    /// vibration √(c/J), the way from one breakpoint of the law to the next on the average, or 1/(2 K √(1 + m U′²max/J))
    /// of the cam's turning, K the highest harmonic, whichever is the shortest: J + m U′² has its complex zeros 1/K
    /// √(J/m)/U′max beside those of U′. The cam turns at |ω| and the speed that the vibration has now.
    fn usual_step(&self, target: f64) -> f64 {
        let law = &self.cam.law;
        let ratio = self.parameters.m * law.bound(1).powi(2) / self.parameters.inertia;
        let smooth = 0.5 / (law.resolution() * (1.0 + ratio).sqrt());
        let angle = smooth.min(TAU / law.breakpoints().len().max(1) as f64);
        let frequency = (self.parameters.c / self.parameters.inertia).sqrt();
        let speed_at = |time: f64| self.motion.at(time).kinematics.0[1].abs();
        let vibration = if self.linear { 0.0 } else { self.twist[1].abs() + frequency * self.twist[0].abs() };
        let speed = speed_at(self.time).max(speed_at(target)) + vibration;
        (0.5 / frequency).min(angle / speed)
    }

    /// φ, ω, q, q̇ at the communication point on the present motion.
    fn remember(&mut self) {
        let [phi, w, ..] = self.motion.at(self.time).kinematics.0;
        self.before = [phi, w, self.twist[0], self.twist[1]];
    }

    fn initial_twist(&mut self, tolerance: f64) -> Result<[f64; 2], Fault> {
        match self.start.mode {
            StartMode::AtRest => Ok([0.0, 0.0]),
            StartMode::Given => Ok([self.start.q, self.start.q_dot]),
            StartMode::SteadyState if self.cam.is_input() => Err(refused_start(
                "start.mode = steady_state needs a constant speed; this drive follows its inputs: set start.mode = \
                 at_rest or given",
            )),
            StartMode::SteadyState => {
                let (time, table) = (self.time, self.table.clone());
                let map = table.as_ref().and_then(|table| table.map.as_ref());
                self.with_twist(|twist, _| steady::periodic(twist, time, tolerance, map))
            }
        }
    }
}

impl Drive for ElasticShaft {
    type Scene = Scene;

    const MODEL: &'static str = "ElasticCamDrive.shaft";
    const INPUT_DERIVATIVES: usize = MAX_INPUT_DERIVATIVE;

    fn new(scene: Scene) -> Result<Self, Fault> {
        let Scene { parameters, linear, cam, drive, start, solver } = scene;
        let cam = CamDrive::new(cam, drive);
        let motion = cam.motion(0.0);
        let mut drive = ElasticShaft {
            parameters,
            linear,
            cam,
            start,
            solver: Solver::new(solver),
            used: parameters,
            tuned: false,
            motion,
            integrator: Collocation::new(Double::default(), [0.0; 2]),
            usual_step: 0.0,
            table: None,
            trajectory: None,
            segment: 0,
            time: 0.0,
            twist: [0.0; 2],
            before: [0.0; 4],
            log: EventLog::default(),
        };
        if drive.cam.law.validate().is_ok() {
            drive.tabulate(drive.equation());
        }
        Ok(drive)
    }

    fn variables(&self) -> List<Self> {
        variables::list(self)
    }

    fn text(&self) -> Text {
        let periodic = self.linear && !self.cam.is_input();
        let conditions = [("linear", self.linear), ("periodic", periodic), ("method", self.has_method())];
        Text::new(include_str!("text.toml"), &conditions)
    }

    fn curves(&self) -> Vec<Curve> {
        Curve::of_law(&self.cam.law)
    }

    fn oscillator(scene: &Scene) -> Option<super::PeriodicOscillator> {
        Some(oscillator::of(scene))
    }

    fn experiment(&self) -> Experiment {
        Experiment::of_turns(5.0, self.cam.mode.speed())
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        self.cam.law.validate().map_err(|message| Fault::new(message).of("cam"))?;
        self.time = time;
        self.cam.start(time);
        self.solver.start();
        self.motion = self.cam.motion(time);
        self.integrator = Collocation::new(Double::from(time), [0.0; 2]);
        self.tabulate(self.equation());
        self.twist = self.initial_twist(self.solver.effective_tolerance())?;
        self.restart_integrator();
        self.trajectory = self.map().map(|map| Trajectory::new(map, time, self.twist));
        if let Some(table) = self.table.as_ref().filter(|table| table.map.is_some()) {
            self.solver.evaluations = table.map.as_ref().map_or(0, PeriodMap::evaluations) as f64;
            self.solver.error_estimate = table.error_after(0.0);
        }
        self.remember();
        Ok(())
    }

    fn apply(&mut self, time: f64) -> Result<(), Fault> {
        self.time = time;
        self.tuned = self.used != self.parameters;
        if self.cam.is_input() {
            self.motion = self.cam.motion(time);
            let [phi, w, a, ..] = self.motion.coefficients;
            let [before, speed, q, v] = self.before;
            self.twist = if goes_on([before, speed, a], [phi, w], time) {
                [q, v]
            } else {
                // ψ = φ + q and ψ̇ = ω + q̇ do not jump, so q and q̇ take up the jumps of φ and ω.
                [q - (phi - before), v - (w - speed)]
            };
        }
        Ok(())
    }

    as_every_cam_drive!();

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        let target = time + step;
        // Most steps end in the cell of the table where they start.
        if let Some(trajectory) = &self.trajectory
            && let Some(twist) = trajectory.within(target).filter(|_| !self.tuned)
        {
            (self.twist, self.time) = (twist, target);
            return Ok(());
        }
        self.advance_further(time, target)
    }

    fn is_finite(&self) -> bool {
        all_finite(self.twist)
    }

    fn restored(&mut self, made: &Self) -> Result<(), Fault> {
        self.cam.take(&made.cam);
        if self.segment >= self.cam.law.breakpoints().len().max(1) {
            return Err(no_state());
        }
        let Some(trajectory) = self.trajectory.clone() else { return Ok(()) };
        self.table = made.table.clone();
        // A state on the table was reached with the parameters of the last step.
        self.tabulate(Equation::new(&self.used, self.linear));
        if !self.map().is_some_and(|map| trajectory.is_in(map)) {
            self.trajectory = None;
            self.restart_integrator();
        }
        Ok(())
    }
}

impl HasCamDrive for ElasticShaft {
    type Law = MotionLaw;

    field!(cam, cam_mut: CamDrive = cam);
    field!(start_values, start_values_mut: Start = start);
}

impl HasSolver for ElasticShaft {
    field!(solver, solver_mut: Solver = solver);
    fn has_method(&self) -> bool {
        // The tables of the linear equation at constant speed cost the same at every step.
        !self.linear || self.cam.is_input()
    }
}
