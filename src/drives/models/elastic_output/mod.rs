//! A cam drive whose output member is elastic.
//!
//! The cam moves the base x = U(φ(t)) of a spring and a damper, which carry the mass m at y = x + q.
//!
//! m q̈ + b q̇ + c q = −m ẍ, with ẍ = U″ ω² + U′ α.
//!
//! Symbols: m mass of the output member (kg), c stiffness (N/m) and b damping (N·s/m) between cam and mass, q deformation (m), φ
//! drive angle (rad) with ω = φ̇ and α = φ̈. A load F_L on the mass adds F_L to the right side (see
//! [`crate::drives::follower::load`]); a mass m_x on the cam's side and its load act on the cam only. Signs: force = −(c q + b q̇)
//! acts on the mass, positive in the sense of y; tau = U′·force is the torque from the drive into the cam unit and loads the drive
//! if it is positive. Under loads the cam acts on the follower with contact_force = force + m_x ẍ − F_Lx, and tau =
//! U′·contact_force = m_x U′² α + m_x U′U″ ω² + U′·(force − F_Lx).
//!
//! Validity: the follower keeps contact with both sides of its groove, spring and damper are linear.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.2, equations (1) to (4). Limits that the tests
//! check: c → ∞ gives q = −ẍ/ω₀²; resonance of a harmonic with the amplitude 1/(2D) and, without damping, growing
//! with time.

mod loaded;
mod on_inputs;
#[cfg(test)]
mod tests;
mod variables;

pub use crate::drives::follower::elastic_output::Parameters;
use crate::drives::follower::load::Load;
use crate::drives::limits::{no_state, periodic_motion_that, refused_start};
use crate::drives::parameter::parameters;
use crate::drives::settings::{FINEST_TOLERANCE, HasSolver, Settings, Solver};
use crate::drives::shaft::cam_drive::{
    CamDrive, DriveMode, HasCamDrive, MAX_INPUT_DERIVATIVE, ShaftState, Start, StartMode, as_every_cam_drive, field,
};
use crate::drives::shaft::instant::Instant;
use crate::drives::solver::response::Response;
use crate::drives::{Curve, Drive, EventLog, Experiment, Fault, List, Rounded, Text};
use crate::motion::MotionLaw;
use crate::numerics::number::all_finite;
use loaded::LoadEffects;
use serde::{Deserialize, Serialize};

parameters!(Parameters of ElasticOutput.parameters);

/// The drive as a scene describes it, coherent SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// m, c, b.
    pub parameters: Parameters,
    /// The load on the mass.
    #[serde(default)]
    pub load: Load,
    /// m_x (kg) on the cam's side, and its load.
    #[serde(default)]
    pub roller: (f64, Load),
    /// Whether outputs show the inertia that follows the shaft without slip.
    #[serde(default)]
    pub coupling: bool,
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
    /// None without loads.
    loaded: Option<Box<LoadEffects>>,
    /// The communication point, after the jump of the inputs if they have been set.
    now: Instant,
    /// The end of the last step, before that jump; kept only if there are inputs.
    end: Instant,
    /// Whether the inputs, once taken up at the communication point, go on from the end of the last step.
    taken_up: Option<bool>,
    log: EventLog,
}

impl ElasticOutput {
    /// The tolerance of the response.
    fn tolerance(&self) -> f64 {
        if self.has_tolerance() { self.solver.effective_tolerance() } else { FINEST_TOLERANCE }
    }

    /// q, q̇ at the start, without the effects of the loads.
    fn initial_state(&mut self, time: f64) -> Result<[f64; 2], Fault> {
        let free = self.response.equation().oscillator.stiffness() == 0.0;
        match self.start.mode {
            StartMode::AtRest => Ok([0.0; 2]),
            StartMode::SteadyState | StartMode::Equilibrium if free && self.loaded.is_some() => Err(refused_start(
                "start.mode = equilibrium and steady_state need a spring that balances the loads, but c = 0 and no return spring \
                 holds the mass; choose at_rest or given, or c > 0",
            )),
            StartMode::Equilibrium => Ok(self.response.at_rest(&self.cam.law, &self.cam.motion(time), time)),
            StartMode::Given => Ok([self.start.q, self.start.q_dot]),
            StartMode::SteadyState if self.cam.is_input() => Err(periodic_motion_that(
                "needs a constant speed, but this drive follows its inputs",
                "; choose at_rest or given",
            )),
            StartMode::SteadyState => self.response.periodic(&self.cam.law, &self.cam.motion(time), time),
        }
    }

    /// The shaft at the communication point, with all derivatives.
    fn shaft(&self) -> ShaftState {
        self.response.motion.at(self.now.time)
    }

    /// The force of the cam on the follower under loads (N).
    fn contact_force(&self) -> f64 {
        variables::contact_force(self)
    }

    /// Whether there is a communication point.
    fn arrived(&self) -> Result<(), Fault> {
        if self.now.is_finite() && (self.loaded.is_none() || self.is_finite()) {
            Ok(())
        } else {
            Err(self.beyond_all_numbers())
        }
    }

    #[cold]
    fn beyond_all_numbers(&self) -> Fault {
        let Instant { time, shaft: [phi, w, _], .. } = self.now;
        let [time, phi, w, q] = [time, phi, w, self.deformation()[0]].map(Rounded);
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
        let Scene { parameters, load, roller: (m_roller, on_roller), coupling, cam, drive, start, solver } = scene;
        cam.validate().map_err(|message| Fault::new(message).of("cam"))?;
        let response = Response::new(parameters.equation().under(&load), &cam, FINEST_TOLERANCE);
        let mut loaded = LoadEffects::new([load, on_roller], m_roller, coupling)?;
        if let Some(loaded) = &mut loaded {
            loaded.make_process(response.equation(), FINEST_TOLERANCE, &drive);
        }
        let mut drive = ElasticOutput {
            parameters,
            cam: CamDrive::new(cam, drive),
            start,
            solver: Solver::new(solver),
            response,
            loaded,
            now: Instant::default(),
            end: Instant::default(),
            taken_up: None,
            log: EventLog::default(),
        };
        drive.response.tabulate(None, &drive.cam.law, &drive.cam.mode);
        Ok(drive)
    }

    fn variables(&self) -> List<Self> {
        variables::list(self)
    }

    fn text(&self) -> Text {
        let (inputs, series) = (self.cam.is_input(), self.cam.law.series().is_some());
        let mut conditions = vec![("inputs", inputs), ("series", series), ("closed form", series && !inputs)];
        conditions.extend(LoadEffects::conditions(self.loaded.as_deref()));
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
        self.taken_up = None;
        self.solver.start();
        // The law's parameters may have changed, and with them the data that the response keeps.
        let table = self.response.table.take();
        self.response = Response::new(self.equation(), &self.cam.law, self.tolerance());
        self.response.tabulate(table, &self.cam.law, &self.cam.mode);
        self.response.motion = self.cam.motion(time);
        let q = self.initial_state(time)?;
        self.now = Instant::on(&self.response.motion, &self.cam.law, time, q);
        self.end = self.now;
        self.start_loads(time)?;
        self.arrived()?;
        if self.cam.is_input() { Ok(()) } else { self.response.go_on(&self.cam.law, &self.now) }
    }

    fn apply(&mut self, time: f64) -> Result<(), Fault> {
        let Parameters { m, c, b } = self.parameters;
        let mut tuned = self.response.equation().parameters != [m, c, b];
        if self.loaded.is_some() {
            tuned = self.retune_loads(tuned)?;
        }
        if tuned {
            self.response.set_equation(self.equation());
        }
        if self.cam.is_input() {
            self.taken_up = Some(self.take_up_inputs(time));
        } else if tuned {
            self.response.go_on(&self.cam.law, &self.now)?;
        }
        Ok(())
    }

    as_every_cam_drive!();

    fn held(&self) -> Option<(f64, bool)> {
        if self.cam.is_input() || self.loaded.is_some() { None } else { self.response.held() }
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        if self.cam.is_input() {
            return self.advance_on_inputs([time, time + step]);
        }
        self.response.reach(&self.cam.law, time + step, &mut self.now)?;
        if self.loaded.is_some() {
            self.advance_loads([time, time + step], true)?;
        }
        self.arrived()
    }

    fn is_finite(&self) -> bool {
        all_finite(self.deformation())
    }

    fn restored(&mut self, made: &Self) -> Result<(), Fault> {
        self.cam.take(&made.cam);
        let (tolerance, cam) = (self.tolerance(), (&self.cam.law, &self.cam.mode));
        let is_one =
            self.response.restored(Some(&made.response), cam, tolerance, &self.now) && self.restore_loads(made);
        if is_one { Ok(()) } else { Err(no_state()) }
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
        let error = self.response.error(self.now.time);
        match &self.loaded {
            None => [steps, evaluations as f64, error.min(1.0)],
            Some(loaded) => loaded.tally([steps, evaluations as f64, error * self.response.largest()]),
        }
    }
}
