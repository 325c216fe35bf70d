//! The rigid machine: one degree of freedom, an inertia that depends on the angle, a motor and a load.
//!
//! J(φ) φ̈ + ½ J′(φ) φ̇² = M_an − τ,  J(φ) = J0 + J_v(φ) + Σ m_j U_j′(φ)²
//!
//! Symbols: φ angle of the main shaft (rad); J reduced moment of inertia (kg·m²); J0 its constant part; J_v an
//! optional periodic part (Fourier series or table); m_j mass (kg) and U_j position function (m) of follower j (moment of
//! inertia (kg·m²) and (rad) where it turns); M_an torque of the motor on the shaft (N·m), positive in the sense of φ; τ
//! load (N·m), **positive brakes**. Between a cam and its tool there may be mechanisms, see [`linkage`]; U_j then is the
//! tool's position, the cam moves a lever, and the links' inertia adds to J.
//!
//! Valid for rigid links without backlash and J > 0 everywhere; standstill, reversal and a load that drives the motor
//! are ordinary states.
//!
//! Limit cases that the tests check: M_an = τ = 0 ⇒ Jφ̇² is constant and the turn takes ∮ √(J/2E) dφ; constant J ⇒
//! the run-up time of Kloss in closed form; ½Jφ̇² changes by ∫(M_an − τ)dφ.
//!
//! Source: K. Kaltofen, "HS-Bewegungen trotz veränderlicher Antriebsgeschwindigkeit", equation (2); Dresig, Holzweißig,
//! *Maschinendynamik*, chapter 2 (rigid machine).

mod advance;
mod angle_step;
mod cycle;
mod equation;
mod follower;
mod grid;
mod inertia;
pub mod lagging_turn;
pub mod linkage;
mod mesh;
mod motor;
mod place;
mod profile;
mod signal;
mod solver;
mod steady;
mod step_control;
mod torques;
pub mod turn_map;
mod variables;

#[cfg(test)]
mod tests;

pub use follower::Follower;
pub use inertia::{Inertia, InertiaFunction};
pub use motor::{Kloss, LAG, Motor};
pub use place::Place;

use self::linkage::{decimals, in_turn};
use super::cam_turn::{SLOWEST, turns};
use super::limits::no_state;
use super::settings::{HasSolver, Method, Settings, Solver};
use super::{Curve, Drive, EventLog, Experiment, Fault, List, Text};
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use crate::numerics::number::{Number, all_finite};
use angle_step::{AngleStep, Errors};
use cycle::Cycle;
use mesh::Mesh;
use serde::{Deserialize, Serialize};
use signal::Signal;
use solver::TimeSteps;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use torques::Torques;

/// The rigid machine as a scene describes it; coherent SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// J0 and J_v.
    pub inertia: InertiaFunction,
    /// The followers; j counts from 1 in the variable names.
    pub followers: Vec<Follower>,
    /// The source of M_an.
    pub motor: Motor,
    /// φ at the start (rad).
    pub phi_start: f64,
    /// φ̇ at the start (rad/s), for [`MachineStart::Given`].
    pub w_start: f64,
    /// How the initial speed is found.
    pub start: MachineStart,
    /// `solver.tolerance`, `solver.method`, `solver.step_size`.
    pub solver: Settings,
}

/// How the initial speed is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MachineStart {
    /// φ̇ = `w_start`; a motor with a lag starts at `motor.M_start`.
    Given,
    /// On the periodic solution under the load that acts at the start.
    SteadyState,
}

/// The state of the machine at a communication point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct State {
    /// φ − 2π `turns` (rad), within a turn; its second part takes up the rounding of many small steps.
    angle: Double,
    /// Whole turns. With the angle apart from them, a million turns cost no digit.
    turns: f64,
    /// φ̇ (rad/s).
    w: f64,
    /// u = √J φ̇ [√J]: E = ½u². See [`solver`] for why. Out of date while there is an angle step.
    u: Double,
    /// M_an (N·m) of a motor with a lag.
    torque: f64,
    /// The interval between the borders of the laws that holds the angle.
    interval: usize,
}

/// The rigid machine in operation.
#[derive(Clone, Serialize, Deserialize)]
pub struct RigidMachine {
    /// Shared by all instances of which none has changed it.
    inertia: Arc<Inertia>,
    motor: Motor,
    phi_start: f64,
    w_start: f64,
    /// M_an at the start of a motor with a lag (N·m); 0 where it is switched on.
    torque_start: f64,
    start: MachineStart,
    solver: Solver,
    /// Input `tau`.
    load: Signal,
    /// Input `M_an`, for [`Motor::Input`].
    driving: Signal,
    state: State,
    in_time: TimeSteps,
    /// The turn's cells with their J; follows from the parameters.
    #[serde(skip)]
    mesh: Mesh,
    /// The periodic motion against the load of the start, where there is one; follows from the parameters and that load.
    #[serde(skip)]
    cycle: Option<Arc<Cycle>>,
    /// τ when the simulation started (N·m).
    load_at_start: f64,
    /// The step in the angle that holds the communication point; None while the motion is integrated in time.
    step: Option<AngleStep>,
    /// The torques for which the step holds.
    torques: Torques,
    /// Where in the step the communication point lies, x ∈ [−1, 1].
    abscissa: f64,
    /// The length that the next step in the angle may have (rad).
    next_length: f64,
    /// Known errors at the beginning of the step.
    errors: Errors,
    /// The angle passed since the start, there and back (rad).
    travelled: f64,
    /// The greatest |φ̇| since the start (rad/s).
    top_speed: f64,
    /// The period of the steady state found at the start (s); 0 without one.
    period: f64,
    events: EventLog,
}

impl HasSolver for RigidMachine {
    fn solver(&self) -> &Solver {
        &self.solver
    }
    fn solver_mut(&mut self) -> &mut Solver {
        &mut self.solver
    }
    /// The steps of the tolerance are the longer the slower the shaft turns and the steadier its torques are.
    fn has_method(&self) -> bool {
        true
    }
}

impl RigidMachine {
    /// The machine before anything is checked or tabulated.
    fn of(scene: Scene) -> Self {
        RigidMachine {
            inertia: Arc::new(Inertia::new(scene.inertia, scene.followers)),
            motor: scene.motor,
            phi_start: scene.phi_start,
            w_start: scene.w_start,
            torque_start: 0.0,
            start: scene.start,
            solver: Solver::new(scene.solver),
            load: Signal::default(),
            driving: Signal::default(),
            state: State::default(),
            in_time: TimeSteps::new(&scene.motor),
            mesh: Mesh::default(),
            cycle: None,
            load_at_start: 0.0,
            step: None,
            torques: Torques::default(),
            abscissa: 0.0,
            next_length: f64::INFINITY,
            errors: Errors::default(),
            travelled: 0.0,
            top_speed: 0.0,
            period: 0.0,
            events: EventLog::default(),
        }
    }

    /// Refuses parameters that describe no machine.
    fn check(&self) -> Result<(), Fault> {
        if let Motor::Kloss(Kloss { synchronous_speed, .. }) = self.motor
            && !turns(synchronous_speed)
        {
            let message = format!(
                " = {} rad/s: the slip is relative to the synchronous speed, whose magnitude must be at least {} rad/s; use a machine without a motor for a motor that is switched off",
                Number(synchronous_speed),
                Number(SLOWEST)
            );
            return Err(Fault::named("motor.w_s", message));
        }
        // Where there is a mesh it has passed.
        if self.mesh.is_of(&self.inertia) {
            return Ok(());
        }
        self.inertia.validate()?;
        let (low, _) = self.inertia.range();
        if low.is_finite() && low > 0.0 {
            return Ok(());
        }
        let message = format!(
            "the reduced moment of inertia J(phi) = J0 + sum m U'^2 must be positive at every angle, but its lower bound is {} kg.m2; choose a larger `J0` (now {} kg.m2)",
            Number(low),
            self.inertia.function.constant
        );
        Err(Fault::new(message).of("J0"))
    }

    /// Puts the machine at φ = `phi_start` with the speed `w`.
    fn place_at_start(&mut self, w: f64) {
        let reduced = angle::reduce(Double::from(self.phi_start));
        let (interval, phi) = self.inertia.interval(reduced, true);
        let turns = ((self.phi_start - phi) / TAU).round();
        self.state = State { angle: Double::from(phi), turns, torque: self.torque_start, interval, ..State::default() };
        let pulled = if w == 0.0 { self.net_torque(0.0) } else { w };
        if pulled < 0.0 {
            let (interval, phi) = self.inertia.interval(reduced, false);
            let turns = ((self.phi_start - phi) / TAU).round();
            self.state = State { angle: Double::from(phi), turns, interval, ..self.state };
        }
        self.set_speed(w);
    }

    /// φ̇ = `w` at the angle of the state.
    fn set_speed(&mut self, w: f64) {
        self.state.w = w;
        self.state.u = Double::from(self.inertia_now()[0]).sqrt() * Double::from(w);
    }

    /// J, J′ at the angle of the state.
    fn inertia_now(&self) -> [f64; 2] {
        self.mesh.profile.with_slope(&self.inertia, self.state.interval, self.state.angle.hi)
    }

    /// J, J′, J″, J‴ at the angle of the state.
    fn inertia_here(&self) -> [f64; 4] {
        self.inertia.at(self.inertia.place(self.state.interval), self.state.angle.hi)
    }

    /// M_an − τ at the speed `w` and now.
    fn net_torque(&self, w: f64) -> f64 {
        let driving = match self.motor {
            Motor::Input => self.driving.now(),
            _ if self.motor.lag().is_some() => self.state.torque,
            _ => self.motor.characteristic(w)[0],
        };
        driving - self.load.now()
    }
}

impl Drive for RigidMachine {
    type Scene = Scene;
    const MODEL: &'static str = "RigidMachine";
    const INPUT_DERIVATIVES: usize = super::cam_drive::MAX_INPUT_DERIVATIVE;

    fn new(scene: Scene) -> Result<Self, Fault> {
        let mut machine = RigidMachine::of(scene);
        machine.check()?;
        // Here, so that the instances of a scene share it.
        machine.prepare_mesh()?;
        Ok(machine)
    }

    fn variables(&self) -> List<Self> {
        self.declare()
    }

    fn text(&self) -> Text {
        let (lag, kloss) = (self.motor.lag().is_some(), matches!(self.motor, Motor::Kloss(_)));
        let conditions = [("linkages", self.inertia.is_linked()), ("kloss", kloss), ("lag", lag)];
        let mut text = Text::new(include_str!("text.toml"), &conditions);
        for (j, follower) in self.inertia.followers.iter().enumerate() {
            for (i, (mechanism, extreme)) in follower.linkage.0.iter().zip(follower.transmission()).enumerate() {
                if mechanism.has_transmission_angle() {
                    text.limits.push(format!(
                        "follower[{}].linkage[{}] ({}): with the values of the scene the transmission angle is least at φ = \
                         {}°, {}°; at least 40° is usual.",
                        j + 1,
                        i + 1,
                        mechanism.name(),
                        in_turn(extreme.phi, 1),
                        decimals(extreme.transmission_angle().to_degrees(), 2)
                    ));
                }
            }
        }
        text
    }

    /// J(φ) and the position functions of the followers.
    fn curves(&self) -> Vec<Curve> {
        let inertia = |phi: f64| {
            let reduced = if phi > PI { phi - TAU } else { phi };
            let (interval, phi) = self.inertia.interval(reduced, true);
            self.inertia.at(self.inertia.place(interval), phi)[0]
        };
        let mut curves = vec![Curve::over_turn("Reduced moment of inertia J(φ)", "J [kg·m²]", inertia)];
        for (j, follower) in self.inertia.followers.iter().enumerate() {
            let title = format!("Position function of follower {}", j + 1);
            let (unit, factor) = if follower.turns { ("°", 1f64.to_degrees()) } else { ("mm", 1e3) };
            let label = format!("U{} [{unit}]", j + 1);
            curves.push(Curve::over_turn(&title, &label, |phi| factor * follower.tool(follower.cam.at(phi).0)[0]));
        }
        curves
    }

    /// Twenty turns at the synchronous speed (or at `w_start`); a second of a machine that starts at rest with a torque as input.
    fn experiment(&self) -> Experiment {
        let speed = match self.motor {
            Motor::Kloss(Kloss { synchronous_speed, .. }) => synchronous_speed.abs(),
            Motor::None | Motor::Input => self.w_start.abs(),
        };
        Experiment::of_turns(20.0, speed)
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        self.check()?;
        self.solver.start();
        (self.in_time, self.period) = (TimeSteps::new(&self.motor), 0.0);
        (self.step, self.next_length, self.errors) = (None, f64::INFINITY, Errors::default());
        self.travelled = 0.0;
        self.top_speed = 0.0;
        self.load_at_start = self.load.now();
        self.prepare_mesh()?;
        self.place_at_start(self.w_start);
        if self.start == MachineStart::SteadyState {
            self.start_periodically(time)?;
        }
        if self.solver.settings.method == Method::FixedCost {
            self.in_time.grid = self.grid_from(time);
        }
        Ok(())
    }

    /// The inputs are torques; they change the acceleration at once and the state not at all.
    fn apply(&mut self, _time: f64) -> Result<(), Fault> {
        self.prepare_mesh_once()
    }

    /// At the speed that the shaft has now.
    #[inline(always)]
    fn angle(&self, time: f64, end: f64) -> f64 {
        self.state.angle.hi + TAU * self.state.turns + self.state.w * (end - time)
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        self.load.step_begins();
        self.driving.step_begins();
        match self.solver.settings.method {
            Method::Adaptive => self.advance_by_angle(time, step)?,
            Method::FixedCost => self.advance_on_grid(time, step)?,
        }
        self.load.step_ends(step);
        self.driving.step_ends(step);
        Ok(())
    }

    fn evaluate(&self, values: &mut [f64]) {
        variables::evaluate(self, values);
    }

    fn set_input_derivative(&mut self, reference: usize, order: usize, value: f64) {
        let signal = if reference == variables::LOAD { &mut self.load } else { &mut self.driving };
        signal.set_derivative(order, value);
    }

    fn request_tolerance(&mut self, tolerance: f64) {
        self.solver.requested = tolerance;
    }

    fn is_finite(&self) -> bool {
        let State { angle, turns, u, torque, .. } = self.state;
        all_finite([angle.hi, turns, u.hi, torque])
    }

    fn events(&mut self) -> &mut EventLog {
        &mut self.events
    }

    /// The mesh, of which already the outputs before the next step take J.
    fn restored(&mut self, made: &Self) -> Result<(), Fault> {
        (self.inertia, self.motor) = (made.inertia.clone(), made.motor);
        (self.mesh, self.cycle) = (made.mesh.clone(), made.cycle.clone());
        // Parameters that are yet to be changed need make no machine; the next start tells.
        if self.check().is_ok() {
            self.prepare_mesh()?;
        }
        let intervals = self.inertia.borders().len().max(1);
        let cell = self.step.as_ref().map_or(0, |step| step.from.cell);
        let fits = self.state.interval < intervals
            && cell < self.mesh.cells().len().max(1)
            && self.in_time.fits(&self.motor, intervals);
        if fits { Ok(()) } else { Err(no_state()) }
    }
}
