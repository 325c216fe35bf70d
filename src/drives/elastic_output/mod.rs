//! A cam drive whose output member is elastic.
//!
//! The cam moves the base x = U(φ(t)) of a spring and a damper, which carry the mass m at y = x + q.
//!
//! m q̈ + b q̇ + c q = −m ẍ, with ẍ = U″ ω² + U′ α.
//!
//! Symbols: m mass of the output member (kg), c stiffness (N/m) and b damping (N·s/m) between cam and mass,
//! q deformation (m), φ drive angle (rad) with ω = φ̇ and α = φ̈.
//! Signs: force = −(c q + b q̇) acts on the mass, positive in the sense of y; tau = U′·force is the torque from the
//! drive into the cam unit and loads the drive where it is positive.
//!
//! Validity: the follower keeps contact with both sides of its groove, spring and damper are linear.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.2, equations (1) to (4). Limits that the tests
//! check: c → ∞ gives q = −ẍ/ω₀²; resonance of a harmonic with the amplitude 1/(2D) and, without damping, growing
//! with time.

mod on_inputs;
#[cfg(test)]
mod tests;
mod variables;

use super::cam_drive::{
    AngleMotion, CamDrive, DriveMode, HasCamDrive, MAX_INPUT_DERIVATIVE, Start, StartMode, as_every_cam_drive, field,
};
use super::limits::{no_state, refused_start};
use super::parameter::parameters;
use super::response::{Instant, Response, Table};
use super::settings::{FINEST_TOLERANCE, HasSolver, Settings, Solver};
use super::{Curve, Drive, EventLog, Experiment, Fault, List, Rounded, Text};
use crate::motion::{Kinematics, MotionLaw, TransferFunctions};
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use crate::numerics::number::all_finite;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::pair::Pair;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

parameters! {
    // Twelve decades to either side of 1 kg, and as far from 1 N/m and 1 N·s/m as this leaves natural frequencies that can be
    // squared.
    /// Mass and spring.
    Parameters of ElasticOutput.parameters, "elasticity" {
        /// Mass of the output member
        m = "m", "m", MASS in [1e-12, 1e12], Tunable;
        /// Stiffness between cam and mass
        c = "c", "c", STIFFNESS in [0.0, 1e24], Tunable;
        /// Damping between cam and mass
        b = "b", "b", DAMPING in [0.0, 1e24] or 0.0, Tunable;
    }
}

/// The drive as a scene describes it, coherent SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// m, c, b.
    pub parameters: Parameters,
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
pub struct ElasticOutput {
    parameters: Parameters,
    cam: CamDrive,
    start: Start,
    solver: Solver,
    response: Response,
    /// Those of the response: the parameters as they were last taken up.
    built_for: Parameters,
    /// The communication point, after inputs were taken up.
    now: Moment,
    /// Whether the inputs for the next step have been taken up.
    taken_up: bool,
    /// Cam and mass at the end of the previous communication step, once inputs were taken up.
    before: Moment,
    /// φ and its time derivatives there, from which jumps of the inputs are counted; kept only where there are inputs.
    phi: [f64; 5],
    log: EventLog,
}

/// Cam and mass at an instant: what nearly every output is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Moment {
    /// t (s).
    time: f64,
    /// φ (rad), ω (rad/s), α (rad/s²).
    shaft: [f64; 3],
    /// U (m), U′ (m/rad), U″ (m/rad²), q (m), q̇ (m/s).
    at: Instant,
}

/// The cam at an instant, with all derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Position {
    /// t (s).
    time: f64,
    /// φ and its time derivatives.
    phi: [f64; 5],
    /// U … U⁗ (m).
    u: [f64; 5],
}

impl Position {
    /// The cam at `time` on `motion`; on a breakpoint of the law the side to which the cam turns.
    fn of(law: &MotionLaw, motion: &AngleMotion, time: f64) -> Self {
        let shaft = motion.at(time);
        let forward = shaft.kinematics.0[1] >= 0.0;
        let u = law.at_in(law.segment(shaft.reduced, forward), shaft.reduced);
        Position { time, phi: shaft.kinematics.0, u: u.0 }
    }

    /// The cam at `time` where φ and its derivatives are these.
    fn at(law: &MotionLaw, time: f64, phi: [f64; 5]) -> Self {
        let reduced = angle::reduce(Double::from(phi[0]));
        let u = law.at_in(law.segment(reduced, phi[1] >= 0.0), reduced);
        Position { time, phi, u: u.0 }
    }

    /// x and its time derivatives.
    fn lift(&self) -> Kinematics {
        TransferFunctions(self.u).along(&Kinematics(self.phi))
    }

    /// With the mass at `q`.
    fn moment(&self, q: [f64; 2]) -> Moment {
        let ([phi, w, a, ..], [u, slope, curvature, ..]) = (self.phi, self.u);
        Moment { time: self.time, shaft: [phi, w, a], at: Instant { u: Pair::new(u, slope), curvature, q: q.into() } }
    }
}

impl Parameters {
    fn oscillator(&self) -> Oscillator {
        Oscillator::of_mass(self.m, self.c, self.b)
    }
}

impl ElasticOutput {
    /// The tolerance of the response.
    fn tolerance(&self) -> f64 {
        if self.has_tolerance() { self.solver.effective_tolerance() } else { FINEST_TOLERANCE }
    }

    /// q, q̇ at the start.
    fn initial_state(&mut self, time: f64) -> Result<[f64; 2], Fault> {
        match self.start.mode {
            StartMode::AtRest => Ok([0.0; 2]),
            StartMode::Given => Ok([self.start.q, self.start.q_dot]),
            StartMode::SteadyState if self.cam.is_input() => Err(refused_start(
                "start.mode = steady_state needs a constant speed, but this drive follows its inputs; choose at_rest \
                 or given",
            )),
            StartMode::SteadyState => self.response.periodic(&self.cam.law, &self.cam.motion(time), time),
        }
    }

    /// Tabulates the turn of the cam where that helps, unless `known` is the table.
    fn tabulate(&mut self, known: Option<Arc<Table>>) {
        if let DriveMode::Constant { w, phi_start } = self.cam.mode {
            self.response.tabulate(known, &self.cam.law, w, phi_start);
        }
    }

    /// The cam at the communication point.
    fn position(&self) -> Position {
        if self.cam.is_input() && !self.taken_up {
            return Position::at(&self.cam.law, self.now.time, self.phi);
        }
        Position::of(&self.cam.law, self.response.motion(), self.now.time)
    }

    /// Lets the response go on from `now`, on a motion that is valid up to `until` (s).
    fn restart(&mut self, until: f64) -> Result<(), Fault> {
        let motion = *self.response.motion();
        self.response.restart(&self.cam.law, &motion, self.now.time, until, self.now.at.q.array())
    }
}

impl Drive for ElasticOutput {
    type Scene = Scene;

    const MODEL: &'static str = "ElasticCamDrive.output";
    const INPUT_DERIVATIVES: usize = MAX_INPUT_DERIVATIVE;

    fn new(scene: Scene) -> Result<Self, Fault> {
        let Scene { parameters, cam, drive, start, solver } = scene;
        cam.validate().map_err(|message| Fault::new(message).of("cam"))?;
        let response = Response::new(parameters.oscillator(), &cam, FINEST_TOLERANCE);
        let mut drive = ElasticOutput {
            parameters,
            cam: CamDrive::new(cam, drive),
            start,
            solver: Solver::new(solver),
            response,
            built_for: parameters,
            now: Moment::default(),
            taken_up: false,
            before: Moment::default(),
            phi: [0.0; 5],
            log: EventLog::default(),
        };
        drive.tabulate(None);
        Ok(drive)
    }

    fn variables(&self) -> List<Self> {
        variables::list(self)
    }

    fn text(&self) -> Text {
        let (inputs, series) = (self.cam.is_input(), self.cam.law.series().is_some());
        let conditions = [("inputs", inputs), ("series", series), ("closed form", series && !inputs)];
        Text::new(include_str!("text.toml"), &conditions)
    }

    fn curves(&self) -> Vec<Curve> {
        Curve::of_law(&self.cam.law)
    }

    fn experiment(&self) -> Experiment {
        Experiment::of_turns(5.0, self.cam.mode.speed())
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        self.cam.law.validate().map_err(|message| Fault::new(message).of("cam"))?;
        self.cam.start(time);
        self.solver.start();
        // The law's parameters may have changed, and with them what the response keeps of it.
        let table = self.response.table();
        self.response = Response::new(self.parameters.oscillator(), &self.cam.law, self.tolerance());
        self.tabulate(table);
        self.built_for = self.parameters;
        self.taken_up = false;
        self.response.follow(self.cam.motion(time));
        let q = self.initial_state(time)?;
        self.arrive(time, q)?;
        if !self.cam.is_input() {
            self.restart(f64::INFINITY)?;
        }
        Ok(())
    }

    fn apply(&mut self, time: f64) -> Result<(), Fault> {
        let tuned = self.built_for != self.parameters;
        if tuned {
            self.built_for = self.parameters;
            self.response.set_oscillator(self.parameters.oscillator());
        }
        if self.cam.is_input() {
            self.take_up_inputs(time);
        } else if tuned {
            self.restart(f64::INFINITY)?;
        }
        Ok(())
    }

    as_every_cam_drive!();

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        let end = time + step;
        if self.cam.is_input() {
            return self.advance_on_inputs([time, end]);
        }
        if let Some(at) = self.response.closed(&self.cam.law, end) {
            let [_, w, a] = self.now.shaft;
            self.now = Moment { time: end, shaft: [self.cam.angle(time, end), w, a], at };
            // U and ω are bounded; a sum that is finite has finite terms.
            let [q, v] = at.q.array();
            return if (q + v).is_finite() { Ok(()) } else { Err(self.beyond_all_numbers()) };
        }
        let q = self.response.at(&self.cam.law, end)?;
        self.arrive(end, q)
    }

    fn is_finite(&self) -> bool {
        all_finite(self.now.at.q.array())
    }

    fn restored(&mut self, made: &Self) -> Result<(), Fault> {
        self.cam.take(&made.cam);
        let tolerance = self.tolerance();
        if !self.response.restored(&self.cam.law, tolerance) {
            return Err(no_state());
        }
        if !self.response.is_on_table() {
            return Ok(());
        }
        self.tabulate(made.response.table());
        if !self.response.has_its_table() {
            // As after any other change: on from here without a table.
            let _ = self.restart(f64::INFINITY);
        }
        Ok(())
    }
}

impl ElasticOutput {
    /// The mass is at `q` at `time` (s).
    fn arrive(&mut self, time: f64, q: [f64; 2]) -> Result<(), Fault> {
        self.arrive_at(Position::of(&self.cam.law, self.response.motion(), time), q)
    }

    /// The mass is at `q` where the cam is at `position`.
    fn arrive_at(&mut self, position: Position, q: [f64; 2]) -> Result<(), Fault> {
        self.now = position.moment(q);
        self.phi = position.phi;
        let finite = q.iter().chain(&position.lift().0[..3]).all(|x| x.is_finite());
        if finite { Ok(()) } else { Err(self.beyond_all_numbers()) }
    }

    #[cold]
    fn beyond_all_numbers(&self) -> Fault {
        Fault::new(format!(
            "the motion exceeds the range of numbers at t = {} s: phi = {} rad, w = {} rad/s, q = {} m",
            Rounded(self.now.time),
            Rounded(self.now.shaft[0]),
            Rounded(self.now.shaft[1]),
            Rounded(self.now.at.q.array()[0])
        ))
    }
}

impl HasCamDrive for ElasticOutput {
    type Law = MotionLaw;

    field!(cam, cam_mut: CamDrive = cam);
    field!(start_values, start_values_mut: Start = start);
}

impl HasSolver for ElasticOutput {
    /// At constant speed there is nothing to trade: the result is at rounding level.
    fn has_tolerance(&self) -> bool {
        self.cam.is_input()
    }
    field!(solver, solver_mut: Solver = solver);
    fn steps(&self) -> f64 {
        self.response.steps
    }
    fn error_estimate(&self) -> f64 {
        self.response.error(self.now.time)
    }
    fn evaluations(&self) -> f64 {
        self.response.evaluations as f64
    }
}
