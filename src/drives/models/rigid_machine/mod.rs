//! The rigid machine: one degree of freedom, an inertia that depends on the angle, a motor and a load.
//!
//! J(φ) φ̈ + ½ J′(φ) φ̇² = M_an − τ,  J(φ) = J0 + J_v(φ) + Σ m_j U_j′(φ)²
//!
//! Symbols: φ angle of the main shaft (rad); J reduced moment of inertia (kg·m²); J0 its constant part; J_v an optional periodic
//! part (Fourier series or table); m_j mass (kg) and U_j position function (m) of follower j (moment of inertia (kg·m²) and (rad)
//! if it turns); M_an torque of the motor on the shaft (N·m), positive in the sense of φ; τ load (N·m), **positive brakes**.
//! Between a cam and its tool there may be mechanisms, see [`linkage`]; U_j then is the tool's position, the cam moves a lever, and
//! the links' inertia adds to J.
//!
//! Valid for rigid links without backlash and J > 0 everywhere; standstill, reversal and a load that drives the motor
//! are ordinary states.
//!
//! The shaft with its parts is in `shaft::free`, the integration in `solver::free_shaft`.
//!
//! Limit cases that the tests check: M_an = τ = 0 ⇒ Jφ̇² is constant and the turn takes ∮ √(J/2E) dφ; constant J ⇒
//! the run-up time of Kloss in closed form; ½Jφ̇² changes by ∫(M_an − τ)dφ.
//!
//! Source: K. Kaltofen, "HS-Bewegungen trotz veränderlicher Antriebsgeschwindigkeit", equation (2); Dresig, Holzweißig,
//! *Maschinendynamik*, chapter 2 (rigid machine).

#[cfg(test)]
mod tests;
mod variables;

pub use crate::drives::follower::linkage;
pub use crate::drives::follower::place::Place;
pub use crate::drives::follower::rigid::Follower;
pub use crate::drives::shaft::free::coupled::NamedLoad;
pub use crate::drives::shaft::free::inertia::{Inertia, InertiaFunction};
pub use crate::drives::shaft::free::motor::{Kloss, LAG, Motor};
pub use variables::START_MODE;

use crate::drives::limits::{no_state, step_too_much};
use crate::drives::settings::{HasSolver, Method, Settings, Solver};
use crate::drives::shaft::cam_drive::field;
use crate::drives::shaft::cam_turn::{SLOWEST, turns};
use crate::drives::shaft::free::coupled::Loads;
use crate::drives::shaft::free::profile::Profile;
use crate::drives::shaft::free::signal::Signal;
use crate::drives::shaft::free::{Shaft, State};
use crate::drives::solver::free_shaft::grid::Grid;
use crate::drives::solver::free_shaft::in_angle::InAngle;
use crate::drives::solver::free_shaft::in_time::{InTime, Room};
use crate::drives::solver::free_shaft::mesh::Mesh;
use crate::drives::solver::free_shaft::steady;
use crate::drives::solver::step_control::ROUNDINGS;
use crate::drives::{About, Curve, Drive, Event, EventLog, Experiment, Fault, List, Rounded, Text};
use crate::numerics::double_double::{Double, two_sum};
use crate::numerics::number::{Number, all_finite};
use crate::numerics::work::Work;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// The rigid machine as a scene describes it; coherent SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// J0 and J_v.
    pub inertia: InertiaFunction,
    /// The followers; j counts from 1 in the variable names.
    pub followers: Vec<Follower>,
    /// The source of M_an.
    pub motor: Motor,
    /// The loads of other units on it.
    pub loads: Vec<NamedLoad>,
    /// φ at the start (rad).
    pub phi_start: f64,
    /// φ̇ at the start (rad/s), for [`MachineStart::Given`].
    pub w_start: f64,
    /// The way to determine the initial speed.
    pub start: MachineStart,
    /// `solver.tolerance`, `solver.method`, `solver.step_size`.
    pub solver: Settings,
}

/// The way to determine the initial speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MachineStart {
    /// φ̇ = `w_start`; a motor with a lag starts at `motor.M_start`.
    Given,
    /// On the periodic solution under the load at the start.
    SteadyState,
}

/// The start of the machine.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Start {
    /// φ (rad).
    phi: f64,
    /// φ̇ (rad/s), for [`MachineStart::Given`].
    w: f64,
    /// M_an of a motor with a lag (N·m); 0 if it is switched on at the start.
    torque: f64,
    mode: MachineStart,
}

/// The rigid machine in operation.
#[derive(Clone, Serialize, Deserialize)]
pub struct RigidMachine {
    shaft: Shaft,
    start: Start,
    solver: Solver,
    state: State,
    in_angle: InAngle,
    in_time: InTime,
    /// The part of τ − M_an in the present internal step that does not depend on the speed (N·m).
    torque: f64,
    /// The period of the steady state found at the start (s); 0 without one.
    period: f64,
    events: EventLog,
}

impl HasSolver for RigidMachine {
    field!(solver, solver_mut: Solver = solver);

    /// The tolerance permits longer steps at slower speeds and steadier torques.
    fn has_method(&self) -> bool {
        true
    }
}

impl RigidMachine {
    /// The inertia of the shaft with its followers.
    pub fn inertia(&self) -> &Inertia {
        &self.shaft.inertia
    }

    /// The mesh of the turn.
    pub fn mesh(&self) -> &Mesh {
        &self.in_angle.mesh
    }

    /// Refuses parameters that describe no machine.
    fn check(&self) -> Result<(), Fault> {
        if let Motor::Kloss(Kloss { synchronous_speed, .. }) = self.shaft.motor
            && !turns(synchronous_speed)
        {
            let message = format!(
                " = {} rad/s: the slip is relative to the synchronous speed, whose magnitude must be at least {} rad/s; use a machine without a motor for a motor that is switched off",
                Number(synchronous_speed),
                Number(SLOWEST)
            );
            return Err(Fault::named("motor.w_s", message));
        }
        let inertia = &self.shaft.inertia;
        // A table exists only if J has passed this check.
        if self.shaft.profile.is_of(inertia) {
            return Ok(());
        }
        inertia.validate()?;
        let (low, _) = inertia.range();
        if low.is_finite() && low > 0.0 {
            return Ok(());
        }
        let message = format!(
            "the reduced moment of inertia J(phi) = J0 + sum m U'^2 must be positive at every angle, but its lower bound is {} kg.m2; choose a larger `J0` (now {} kg.m2)",
            Number(low),
            inertia.function.constant
        );
        Err(Fault::new(message).of("J0"))
    }

    /// Makes the tables that follow from the parameters, unless they are up to date.
    fn prepare(&mut self) -> Result<(), Fault> {
        if !self.shaft.profile.is_of(&self.shaft.inertia) {
            self.shaft.profile = Arc::new(Profile::new(self.shaft.inertia.clone()));
        }
        self.in_angle.prepare(&self.shaft, &self.solver)
    }

    /// From one communication point to the next, with the work of a call: reads the internal step that holds a point, and takes
    /// further steps until one holds the next point.
    fn reach(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        let RigidMachine { shaft, state, solver, in_angle, in_time, .. } = self;
        let (target, mut work) = (two_sum(time, step), Work::default());
        let by_tolerance = solver.settings.method == Method::Adaptive;
        // Steps that nobody can wait for are refused before the first.
        if !by_tolerance && !work.allows(InTime::cost(shaft) * (step / in_time.grid.size)) {
            return Err(self.too_long([time, target.hi], time));
        }
        let (constant, torque) = (shaft.torques_are_constant(), shaft.constant_torque());
        if !constant || torque != self.torque {
            if in_angle.leave(state) {
                in_time.begin(in_angle.deviations(state));
            }
            in_time.leave(shaft, state)?;
            self.torque = torque;
        }
        let may_turn = by_tolerance && constant && shaft.motor.lag().is_none();
        let goes_beyond = !by_tolerance && constant;
        let mut now = Double::from(time);
        loop {
            let cost = if let Some(step) = &in_angle.step {
                let [elapsed, left] = step.around(target);
                if left >= 0.0 {
                    in_angle.read(shaft, state, elapsed);
                    return Ok(());
                }
                now = step.end;
                let cost = in_angle.extend(shaft, state, solver)?;
                if in_angle.step.is_none() {
                    in_time.begin(in_angle.deviations(state));
                }
                cost
            } else if let Some(end) = in_time.end() {
                let holds = (target - end).hi <= 0.0;
                // The rest of a step that does not hold it is read, so that its end is treated like every end.
                now = if holds { target } else { end };
                if let Some(instant) = in_time.read(shaft, state, now) {
                    self.events.push(reversal(shaft, state, instant));
                }
                if !(holds && goes_beyond) {
                    in_time.leave(shaft, state)?;
                }
                if holds {
                    return Ok(());
                }
                continue;
            } else if may_turn && in_angle.begin(shaft, state, solver, now, in_time.deviations()) {
                continue;
            } else {
                let room = Room { time, from: now, limit: (!goes_beyond).then_some(target) };
                in_time.extend(shaft, state, solver, room)?
            };
            if work.draw(cost).is_err() {
                return Err(self.too_long([time, target.hi], now.hi));
            }
        }
    }

    /// The fault of a step that takes more than the work of a call; it has reached the time `reached` (s).
    fn too_long(&self, way: [f64; 2], reached: f64) -> Fault {
        // During an angle step the speed of the state is the one at the last communication point.
        let speed = self.in_angle.step.as_ref().map_or(self.state.w, |step| step.end_speed);
        let hint =
            "relax solver.tolerance, lengthen solver.step_size of equal steps, or lower the speed or the range of J";
        step_too_much(way, reached, &format!("the shaft turns at {} rad/s", Rounded(speed)), hint)
    }
}

/// The event of a shaft that turns back in this state at the `time` (s).
fn reversal(shaft: &Shaft, state: &State, time: f64) -> Event {
    Event {
        time,
        kind: "reversal of the shaft",
        quantity: "acceleration",
        value: shaft.net_torque(state, 0.0) / shaft.inertia_at(state)[0],
        unit: "rad/s2",
        follower: 0,
        about: About::Machine,
    }
}

impl Drive for RigidMachine {
    type Scene = Scene;
    const MODEL: &'static str = "RigidMachine";
    const INPUT_DERIVATIVES: usize = crate::drives::shaft::cam_drive::MAX_INPUT_DERIVATIVE;

    fn new(scene: Scene) -> Result<Self, Fault> {
        let Scene { inertia, followers, motor, loads, phi_start: phi, w_start: w, start: mode, solver } = scene;
        let (loads, driving, profile) = (Loads::new(&loads), Signal::default(), Arc::default());
        let mut machine = RigidMachine {
            shaft: Shaft { inertia: Arc::new(Inertia::new(inertia, followers)), motor, loads, driving, profile },
            start: Start { phi, w, torque: 0.0, mode },
            solver: Solver::new(solver),
            state: State::default(),
            in_angle: InAngle::default(),
            in_time: InTime::new(&motor),
            torque: 0.0,
            period: 0.0,
            events: EventLog::default(),
        };
        machine.check()?;
        // Prepared here, so that the instances of a scene share it.
        machine.prepare()?;
        Ok(machine)
    }

    fn variables(&self) -> List<Self> {
        self.declare()
    }

    fn text(&self) -> Text {
        let Shaft { inertia, motor, loads, .. } = &self.shaft;
        let (lag, kloss) = (motor.lag().is_some(), matches!(motor, Motor::Kloss(_)));
        let crank = inertia.followers.iter().any(|follower| !follower.has_cam());
        let conditions = [
            ("varies", inertia.varies()),
            ("table", inertia.function.varying.is_some()),
            ("followers", !inertia.followers.is_empty()),
            ("linkages", inertia.is_linked()),
            ("crank", crank),
            ("motor", *motor != Motor::None),
            ("kloss", kloss),
            ("lag", lag),
        ];
        let conditions = [&conditions[..], &loads.conditions()].concat();
        Text::new(include_str!("text.toml"), &conditions)
    }

    /// J(φ) and the position functions of the followers.
    fn curves(&self) -> Vec<Curve> {
        let inertia = &self.shaft.inertia;
        let value = |phi: f64| {
            let reduced = if phi > PI { phi - TAU } else { phi };
            let (interval, phi) = inertia.interval(reduced, true);
            inertia.at(inertia.place(interval), phi)[0]
        };
        let mut curves = vec![Curve::over_turn("Reduced moment of inertia J(φ)", "J [kg·m²]", value)];
        for (j, follower) in inertia.followers.iter().enumerate() {
            let title = format!("Position function of follower {}", j + 1);
            let (unit, factor) = if follower.turns { ("°", 1f64.to_degrees()) } else { ("mm", 1e3) };
            let label = format!("U[{}] [{unit}]", j + 1);
            curves.push(Curve::over_turn(&title, &label, |phi| factor * follower.tool(follower.cam.at(phi).0)[0]));
        }
        curves
    }

    /// Twenty turns at the synchronous speed (or at `w_start`); one second for a machine that starts at rest with a torque as
    /// input.
    fn experiment(&self) -> Experiment {
        let speed = match self.shaft.motor {
            Motor::Kloss(Kloss { synchronous_speed, .. }) => synchronous_speed.abs(),
            Motor::None | Motor::Input => self.start.w.abs(),
        };
        Experiment::of_turns(20.0, speed)
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        self.check()?;
        self.solver.start();
        self.shaft.loads.start();
        self.in_angle.start(self.shaft.loads.torque_now());
        self.prepare()?;
        let Start { phi, w, torque, mode } = self.start;
        (self.state, self.period) = (self.shaft.state_at(phi, w, torque), 0.0);
        if mode == MachineStart::SteadyState {
            let found = steady::periodic_motion(&self.shaft, &self.in_angle.mesh, phi)?;
            (self.state, self.period) = (found.state, found.period);
            self.events.push(found.event(time));
        }
        self.solver.error_estimate = ROUNDINGS * self.shaft.roundings(phi);
        (self.in_time, self.torque) = (InTime::new(&self.shaft.motor), 0.0);
        if self.solver.settings.method == Method::FixedCost {
            self.in_time.grid = Grid::new(time, self.solver.settings.step_size, &self.shaft, &self.state);
        }
        Ok(())
    }

    /// The inputs change the acceleration at once and leave the state alone.
    fn apply(&mut self, _time: f64) -> Result<(), Fault> {
        if self.shaft.loads.have_inertia() { self.shaft.check_inertia(&self.state) } else { Ok(()) }
    }

    /// At the present speed of the shaft.
    #[inline(always)]
    fn angle(&self, time: f64, end: f64) -> f64 {
        self.state.angle.hi + TAU * self.state.turns + self.state.w * (end - time)
    }

    fn held(&self) -> Option<(f64, bool)> {
        let step = self.in_angle.step.as_ref().filter(|_| self.shaft.torques_are_constant());
        step.map(|step| (step.end.hi, false))
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        self.shaft.step_begins(&mut self.state)?;
        if let Err(fault) = self.reach(time, step) {
            let Self { shaft, state, .. } = self;
            // Twice the way at the speed reached.
            let own = |phi| shaft.profile.value(state.interval, phi);
            return Err(shaft.loads.why(fault, state, 2.0 * state.w * step, own));
        }
        self.shaft.loads.step_ends(step);
        self.shaft.driving.step_ends(step);
        Ok(())
    }

    fn evaluate(&self, values: &mut [f64]) {
        variables::evaluate(self, values);
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

    /// The tables, from which outputs before the next step already take J.
    fn restored(&mut self, made: &Self) -> Result<(), Fault> {
        let Shaft { loads, driving, .. } = &mut self.shaft;
        if !loads.fit(&made.shaft.loads) {
            return Err(no_state());
        }
        self.shaft = Shaft { loads: std::mem::take(loads), driving: *driving, ..made.shaft.clone() };
        (self.in_angle.mesh, self.in_angle.cycle) = (made.in_angle.mesh.clone(), made.in_angle.cycle.clone());
        // Parameters that are yet to be changed need not make a machine; the next start checks them.
        if self.check().is_ok() {
            self.prepare()?;
        }
        let cell = self.in_angle.step.as_ref().map_or(0, |step| step.from.cell);
        let fits = self.state.interval < self.shaft.inertia.pieces().len()
            && cell < self.mesh().cells().len().max(1)
            && self.in_time.fits(&self.shaft);
        if fits { Ok(()) } else { Err(no_state()) }
    }
}
