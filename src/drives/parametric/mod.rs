//! A drive with one degree of freedom and periodic coefficients.
//!
//! m(φ) q̈ + b(φ) q̇ + c(φ) q = f(φ), φ(t) prescribed. The coefficients are finite Fourier series, or those of a
//! parallel-crank drive: J ψ̈ + b_T q̇ + c_T(φ) q = f(φ) with ψ = φ + q (modules [`crank`] and [`law`]).
//!
//! Symbols: m mass (kg·m² or kg), b damping (N·m·s/rad or N·s/m), c stiffness (N·m/rad or N/m), f torque or force
//! on the mass, positive in the sense of q, q angle (rad) or length (m); φ drive angle (rad). Signs: φ, ψ and torques are positive in the same
//! sense; tau = −(c q + b q̇) is the torque from the drive into the unit and loads the drive where it is positive.
//!
//! Energy: d/dt (½ m q̇² + ½ c q²) = f q̇ − b q̇² + ω ½ (m′ q̇² + c′ q²); the last term, `tau_parametric` times ω, is
//! what the drive feeds into the vibration because m and c vary. It is of second order in q.
//!
//! Stability: free motions grow or decay over a turn by the Floquet multipliers; `growth` is ln of the largest modulus.
//! Where it is positive the drive is parametrically unstable, and the motion grows until it is given up beyond 1e100.
//!
//! Validity: q small enough for a linear equation; m > 0 over the whole turn.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, sections 4.5.1–4.5.3.

pub mod coefficients;
pub mod crank;
mod equation;
pub mod law;
mod oscillator;
#[cfg(test)]
mod tests;
mod turn;
mod variables;

use super::cam_drive::{
    AngleMotion, CamDrive, DriveMode, HasCamDrive, MAX_INPUT_DERIVATIVE, Start, StartMode, as_every_cam_drive, field,
    goes_on, push_of_rounding,
};
use super::settings::{HasSolver, Settings, Solver};
use super::step_control::{FAR, StepControl, Stop};
use super::{Curve, Drive, Event, EventLog, Experiment, Fault, List, Rounded, Text};
use crate::numerics::collocation::{Collocation, Failure};
use crate::numerics::double_double::Double;
use crate::numerics::number::all_finite;
use crate::numerics::period_map::Trajectory;
use crate::numerics::work::{EVALUATION, Work};
use coefficients::Coefficients;
use crank::SecondCrank;
use equation::{Vibration, WORDS};
use law::{Coordinate, Law};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use turn::Table;

/// The drive as a scene describes it, coherent SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Where the coefficients come from.
    pub law: Law,
    /// φ.
    pub drive: DriveMode,
    /// Initial state.
    pub start: Start,
    /// `solver.tolerance` and, on inputs, `solver.method`, `solver.step_size`.
    pub solver: Settings,
}

/// The drive in operation.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ParametricDrive {
    cam: CamDrive<Law>,
    start: Start,
    solver: Solver,
    /// m, b, c and f after the law; shared by all instances with the same ones.
    coefficients: Arc<Coefficients>,
    /// φ(t) through the communication point.
    motion: AngleMotion,
    integrator: Collocation<2>,
    /// The highest frequency (rad/s) and the angle of a step of fixed cost (rad).
    usual: [f64; 2],
    /// The equation at constant speed over its period; follows from the parameters, and all instances with the same ones
    /// share it.
    #[serde(skip)]
    table: Option<Arc<Table>>,
    /// The way through the table; None while the integrator is at work.
    trajectory: Option<Trajectory>,
    /// ln of the largest modulus of the Floquet multipliers over a turn.
    growth: f64,
    /// The communication point (s).
    time: f64,
    /// q (rad or m) and q̇ there.
    state: [f64; 2],
    /// φ, ω, q, q̇ at the end of the previous communication step, from which jumps of the inputs are counted.
    before: [f64; 4],
    log: EventLog,
}

/// Newton iterations in a step of fixed cost: one solves a linear equation.
const ITERATIONS: usize = 1;

impl ParametricDrive {
    /// Runs `work` with the equation and the integrator.
    fn with_vibration<R>(&mut self, work: impl FnOnce(&Vibration, &mut Collocation<2>) -> R) -> R {
        let relative = self.cam.law.is_relative();
        let vibration = Vibration { coefficients: &self.coefficients, relative, motion: &self.motion };
        work(&vibration, &mut self.integrator)
    }

    /// Lets the integrator go on from the state at the communication point.
    fn restart_integrator(&mut self) {
        self.integrator.restart(Double::from(self.time), self.state);
    }

    /// Tabulates the equation over a period, unless it is tabulated already.
    fn tabulate(&mut self) -> Arc<Table> {
        let tolerance = self.solver.effective_tolerance();
        match &self.table {
            Some(table) if table.is_for(&self.cam, tolerance) => table.clone(),
            _ => {
                let table = Arc::new(Table::new(&self.coefficients, &self.cam, tolerance));
                self.table = Some(table.clone());
                table
            }
        }
    }

    /// A step that leaves the present cell of the table, or goes without one.
    #[cold]
    #[inline(never)]
    fn advance_further(&mut self, target: f64) -> Result<(), Fault> {
        let table = self.table.as_deref();
        let map = table.and_then(|table| table.map.as_ref());
        let (Some(trajectory), Some(map), Some(table)) = (&mut self.trajectory, map, table) else {
            return self.integrate(target);
        };
        trajectory.reach(map, target).map_err(|fault| unbounded(fault.time, self.growth))?;
        (self.state, self.time) = (trajectory.at(map, target), target);
        self.solver.steps = trajectory.steps as f64;
        self.solver.error_estimate = table.error_after(trajectory.periods(map, target));
        Ok(())
    }

    /// A step with the integrator.
    fn integrate(&mut self, target: f64) -> Result<(), Fault> {
        let on_inputs = self.cam.is_input();
        let (control, limit) = if on_inputs {
            // The motion is known up to the end of the communication step only.
            self.apply(self.time)?;
            self.restart_integrator();
            let (time, lasting) = (self.time, (target - self.time).min(self.usual_step(target)));
            self.with_vibration(|vibration, integrator| {
                let [phi, w, a, ..] = vibration.motion.coefficients;
                let slope = vibration.slope(integrator);
                integrator.disturb([0.0, push_of_rounding([phi, w, a], time, slope, lasting)]);
            });
            (StepControl::within(&self.solver, self.time, target, || self.usual_step(target)), Double::from(target))
        } else {
            (StepControl::Tolerance(self.solver.effective_tolerance()), FAR)
        };
        let integrated = self.with_vibration(|vibration, integrator| {
            let step = |integrator: &mut Collocation<2>| control.step(integrator, vibration, limit, ITERATIONS);
            let cost = EVALUATION + vibration.coefficients.cost();
            control.integrate(integrator, Double::from(target), 1, (&mut Work::default(), cost), step)
        });
        integrated.map_err(|stop| match stop {
            Stop::Failed(Failure::Unbounded { time }) => unbounded(time, self.growth),
            _ => control.fault(stop, &WORDS, [self.time, target], &self.motion),
        })?;
        self.time = target;
        self.state = self.integrator.at(Double::from(target));
        self.remember();
        self.cam.step_done();
        let statistics = self.integrator.statistics;
        self.solver.steps = statistics.steps as f64;
        self.solver.evaluations = statistics.evaluations as f64;
        let error = control.error_estimate(&statistics, on_inputs);
        self.solver.error_estimate = self.solver.error_estimate.max(error);
        Ok(())
    }

    /// The internal step of fixed cost on the way to `target` where none is asked for (s): half a radian of the fastest
    /// vibration √(max c/min m), or half a radian of the highest harmonic of the coefficients (near a dip of the crank's
    /// stiffness an eighth of its width) at the highest speed, whichever is shorter.
    fn usual_step(&self, target: f64) -> f64 {
        let [frequency, angle] = self.usual;
        let speed_at = |time: f64| self.motion.at(time).kinematics.0[1].abs();
        (0.5 / frequency).min(angle / speed_at(self.time).max(speed_at(target)))
    }

    /// φ, ω, q, q̇ at the communication point on the present motion.
    fn remember(&mut self) {
        let [phi, w, ..] = self.motion.at(self.time).kinematics.0;
        self.before = [phi, w, self.state[0], self.state[1]];
    }
}

/// The motion has left the range of numbers that can be gone on with.
fn unbounded(time: f64, growth: f64) -> Fault {
    let why = if growth > 0.0 {
        format!(
            "the drive is parametrically unstable, free vibrations grow by exp({}) in a turn; change drive.w or raise the damping",
            Rounded(growth)
        )
    } else {
        "the drive is parametrically unstable, or an input jumped far; change the speed or raise the damping".to_owned()
    };
    Fault::new(format!("q grows without bound, at t = {} s beyond 1e100: {why}", Rounded(time)))
}

impl Drive for ParametricDrive {
    type Scene = Scene;

    const MODEL: &'static str = "ParametricDrive";
    const INPUT_DERIVATIVES: usize = MAX_INPUT_DERIVATIVE;

    fn new(scene: Scene) -> Result<Self, Fault> {
        let Scene { law, drive, start, solver } = scene;
        law.validate()?;
        let coefficients = Arc::new(law.coefficients());
        let cam = CamDrive::new(law, drive);
        let motion = cam.motion(0.0);
        let mut drive = ParametricDrive {
            cam,
            start,
            solver: Solver::new(solver),
            coefficients,
            motion,
            integrator: Collocation::new(Double::default(), [0.0; 2]),
            usual: [0.0; 2],
            table: None,
            trajectory: None,
            growth: 0.0,
            time: 0.0,
            state: [0.0; 2],
            before: [0.0; 4],
            log: EventLog::default(),
        };
        drive.tabulate();
        Ok(drive)
    }

    fn variables(&self) -> List<Self> {
        variables::list(self)
    }

    fn text(&self) -> Text {
        let (series, crank) = match &*self.cam.law {
            Law::Series(law) => (Some(law), None),
            Law::Crank(crank) => (None, Some(crank)),
        };
        let second = |wanted: fn(&SecondCrank) -> bool| crank.is_some_and(|crank| wanted(&crank.crank.second));
        let conditions = [
            ("series", series.is_some()),
            ("rotation", self.cam.law.coordinate() == Coordinate::Rotation),
            ("crank", crank.is_some()),
            ("own shafts", second(|second| matches!(second, SecondCrank::OwnShafts(_)))),
            ("shared shafts", second(|second| matches!(second, SecondCrank::SharedShafts(_)))),
            ("harmonics", crank.is_some_and(|crank| crank.harmonics.is_some())),
            ("inputs", self.cam.is_input()),
            ("method", self.has_method()),
        ];
        Text::new(include_str!("text.toml"), &conditions)
    }

    fn curves(&self) -> Vec<Curve> {
        let Coefficients { m, b, c, f } = &*self.coefficients;
        let [mass, damping, stiffness, force] = match self.cam.law.coordinate() {
            Coordinate::Rotation => ["m [kg·m²]", "b [N·m·s/rad]", "c [N·m/rad]", "f [N·m]"],
            Coordinate::Translation => ["m [kg]", "b [N·s/m]", "c [N/m]", "f [N]"],
        };
        let mut curves = vec![Curve::over_turn("Stiffness c(φ)", stiffness, |phi| c.at(phi)[0])];
        let titles = [("Mass m(φ)", mass), ("Damping b(φ)", damping), ("Load f(φ)", force)];
        for (series, (title, label)) in [m, b, f].into_iter().zip(titles) {
            if series.bound(1) > 0.0 {
                curves.push(Curve::over_turn(title, label, |phi| series.at(phi).0[0]));
            }
        }
        curves
    }

    fn oscillator(scene: &Scene) -> Option<super::PeriodicOscillator> {
        Some(oscillator::of(scene))
    }

    fn experiment(&self) -> Experiment {
        // Growth and decay take some turns.
        Experiment::of_turns(20.0, self.cam.mode.speed())
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        self.cam.law.validate()?;
        let coefficients = self.cam.law.coefficients();
        if *self.coefficients != coefficients {
            self.coefficients = Arc::new(coefficients);
        }
        self.time = time;
        self.cam.start(time);
        self.solver.start();
        self.motion = self.cam.motion(time);
        self.integrator = Collocation::new(Double::from(time), [0.0; 2]);
        self.usual = [self.coefficients.highest_frequency(), 0.25 * self.coefficients.least_reach()];
        let table = self.tabulate();
        self.growth = table.growth;
        self.state = match self.start.mode {
            StartMode::AtRest => [0.0, 0.0],
            StartMode::Given => [self.start.q, self.start.q_dot],
            StartMode::SteadyState => table.periodic(&self.coefficients)?,
        };
        self.restart_integrator();
        self.trajectory = table.map.as_ref().map(|map| Trajectory::new(map, time, self.state));
        if let Some(map) = &table.map {
            self.solver.evaluations = map.evaluations() as f64;
            self.solver.error_estimate = table.error_after(0.0);
        }
        self.log.clear();
        if self.growth > 0.0 {
            let (kind, quantity) = ("parametrically unstable", "growth per turn");
            self.log.push(Event { time, kind, quantity, value: self.growth, unit: "1", solver: true });
        }
        self.remember();
        Ok(())
    }

    fn apply(&mut self, time: f64) -> Result<(), Fault> {
        self.time = time;
        if !self.cam.is_input() {
            return Ok(());
        }
        self.motion = self.cam.motion(time);
        let [phi, w, a, ..] = self.motion.coefficients;
        let [before, speed, q, v] = self.before;
        self.state = [q, v];
        if self.cam.law.is_relative() && !goes_on([before, speed, a], [phi, w], time) {
            // ψ = φ + q and ψ̇ = ω + q̇ do not jump, so q and q̇ take up the jumps of φ and ω.
            self.state = [q - (phi - before), v - (w - speed)];
        }
        Ok(())
    }

    as_every_cam_drive!();

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        let target = time + step;
        // Most steps end in the cell of the table where they start.
        if let Some(trajectory) = &self.trajectory
            && let Some(state) = trajectory.within(target)
        {
            (self.state, self.time) = (state, target);
            return Ok(());
        }
        self.time = time;
        self.advance_further(target)
    }

    fn is_finite(&self) -> bool {
        all_finite(self.state)
    }

    fn restored(&mut self, made: &Self) -> Result<(), Fault> {
        self.cam.take(&made.cam);
        let coefficients = self.cam.law.coefficients();
        self.coefficients =
            if *made.coefficients == coefficients { made.coefficients.clone() } else { Arc::new(coefficients) };
        let Some(trajectory) = &self.trajectory else { return Ok(()) };
        let trajectory = trajectory.clone();
        self.table = made.table.clone();
        let table = self.tabulate();
        if !table.map.as_ref().is_some_and(|map| trajectory.is_in(map)) {
            self.trajectory = None;
            self.restart_integrator();
        }
        Ok(())
    }
}

impl HasCamDrive for ParametricDrive {
    type Law = Law;

    field!(cam, cam_mut: CamDrive<Law> = cam);
    field!(start_values, start_values_mut: Start = start);
}

impl HasSolver for ParametricDrive {
    field!(solver, solver_mut: Solver = solver);
    fn has_method(&self) -> bool {
        // The table at constant speed costs the same at every step.
        self.cam.is_input()
    }
}
