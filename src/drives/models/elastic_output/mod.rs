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

pub use crate::drives::follower::elastic_output::Parameters;
use crate::drives::limits::{no_state, refused_start};
use crate::drives::parameter::parameters;
use crate::drives::settings::{FINEST_TOLERANCE, HasSolver, Settings, Solver};
use crate::drives::shaft::cam_drive::{
    CamDrive, DriveMode, HasCamDrive, MAX_INPUT_DERIVATIVE, ShaftState, Start, StartMode, as_every_cam_drive, field,
};
use crate::drives::shaft::instant::Instant;
use crate::drives::solver::response::{Response, Table};
use crate::drives::{Curve, Drive, EventLog, Experiment, Fault, List, Rounded, Text};
use crate::motion::MotionLaw;
use crate::numerics::number::all_finite;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

parameters!(Parameters of ElasticOutput.parameters);

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
    /// The communication point, behind the jump of the inputs where they have been set.
    now: Instant,
    /// The end of the last step, in front of that jump; kept only where there are inputs.
    end: Instant,
    log: EventLog,
}

impl ElasticOutput {
    /// The tolerance of the response.
    fn tolerance(&self) -> f64 {
        if self.has_tolerance() { self.solver.effective_tolerance() } else { FINEST_TOLERANCE }
    }

    /// q, q̇ at the start.
    fn initial_state(&mut self, time: f64) -> Result<[f64; 2], Fault> {
        match self.start.mode {
            StartMode::AtRest | StartMode::Equilibrium => Ok([0.0; 2]),
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

    /// The shaft at the communication point, with all derivatives.
    fn shaft(&self) -> ShaftState {
        self.response.motion.at(self.now.time)
    }

    /// Lets the response go on from the communication point at constant speed.
    fn restart(&mut self) -> Result<(), Fault> {
        let motion = self.response.motion;
        self.response.restart(&self.cam.law, &motion, self.now.time, f64::INFINITY, self.now.q.array())
    }

    /// Whether there is a communication point.
    fn arrived(&self) -> Result<(), Fault> {
        if self.now.is_finite() { Ok(()) } else { Err(self.beyond_all_numbers()) }
    }

    #[cold]
    fn beyond_all_numbers(&self) -> Fault {
        let Instant { time, shaft: [phi, w, _], q, .. } = self.now;
        let [time, phi, w, q] = [time, phi, w, q.array()[0]].map(Rounded);
        Fault::new(format!(
            "the motion exceeds the range of numbers at t = {time} s: phi = {phi} rad, w = {w} rad/s, q = {q} m"
        ))
    }
}

impl Drive for ElasticOutput {
    type Scene = Scene;

    const MODEL: &'static str = "ElasticCamDrive.output";
    const INPUT_DERIVATIVES: usize = MAX_INPUT_DERIVATIVE;

    fn new(scene: Scene) -> Result<Self, Fault> {
        let Scene { parameters, cam, drive, start, solver } = scene;
        cam.validate().map_err(|message| Fault::new(message).of("cam"))?;
        let response = Response::new(parameters.equation(), &cam, FINEST_TOLERANCE);
        let mut drive = ElasticOutput {
            parameters,
            cam: CamDrive::new(cam, drive),
            start,
            solver: Solver::new(solver),
            response,
            now: Instant::default(),
            end: Instant::default(),
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
        let table = self.response.table.take();
        self.response = Response::new(self.parameters.equation(), &self.cam.law, self.tolerance());
        self.tabulate(table);
        self.response.motion = self.cam.motion(time);
        let q = self.initial_state(time)?;
        self.now = Instant::on(&self.response.motion, &self.cam.law, time, q);
        self.end = self.now;
        self.arrived()?;
        if self.cam.is_input() { Ok(()) } else { self.restart() }
    }

    fn apply(&mut self, time: f64) -> Result<(), Fault> {
        let Parameters { m, c, b } = self.parameters;
        let tuned = self.response.equation().parameters != [m, c, b];
        if tuned {
            self.response.set_equation(self.parameters.equation());
        }
        if self.cam.is_input() {
            self.take_up_inputs(time);
        } else if tuned {
            self.restart()?;
        }
        Ok(())
    }

    as_every_cam_drive!();

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        if self.cam.is_input() {
            return self.advance_on_inputs([time, time + step]);
        }
        self.response.reach(&self.cam.law, time + step, &mut self.now)?;
        self.arrived()
    }

    fn is_finite(&self) -> bool {
        all_finite(self.now.q.array())
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
        self.tabulate(made.response.table.clone());
        if !self.response.has_its_table() {
            // As after any other change: on from here without a table.
            let _ = self.restart();
        }
        Ok(())
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

    fn statistics(&self) -> [f64; 3] {
        let Response { steps, evaluations, .. } = self.response;
        [steps, evaluations as f64, self.response.error(self.now.time).min(1.0)]
    }
}
