//! A cam drive whose output member is elastic.
//!
//! The cam moves the base x = U(φ(t)) of a spring and a damper, which carry the mass m at y = x + q.
//!
//! m q̈ + b q̇ + c q = −m ẍ, with ẍ = U″ ω² + U′ α.
//!
//! Symbols: m mass of the output member \[kg\], c stiffness \[N/m\] and b damping \[N·s/m\] between cam and mass,
//! q deformation \[m\], φ drive angle \[rad\] with ω = φ̇ and α = φ̈.
//! Signs: force = −(c q + b q̇) acts on the mass, positive in the sense of y; tau = U′·force is the torque from the
//! drive into the cam unit and loads the drive where it is positive.
//!
//! Validity: the follower keeps contact with both sides of its groove, spring and damper are linear.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.2, equations (1) to (4). Limits that the tests
//! check: c → ∞ gives q = −ẍ/ω₀²; resonance of a harmonic with the amplitude 1/(2D) and, without damping, growing
//! with time.

mod portrait;
#[cfg(test)]
mod tests;
mod variables;

use super::cam_drive::{AngleMotion, CamDrive, DriveMode, HasCamDrive, Start, StartMode};
use super::response::Response;
use super::solver::{HasSolver, Settings, Solver};
use super::{Curve, Drive, EventLog, Experiment, Fault, List, Portrait};
use crate::motion::{Kinematics, MotionLaw, TransferFunctions};
use crate::numerics::oscillator::Oscillator;
use serde::{Deserialize, Serialize};

/// The drive as a scene describes it, coherent SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Mass of the output member m [kg].
    pub m: f64,
    /// Stiffness between cam and mass c [N/m].
    pub c: f64,
    /// Damping between cam and mass b [N·s/m].
    pub b: f64,
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
    m: f64,
    c: f64,
    b: f64,
    cam: CamDrive,
    start: Start,
    solver: Solver,
    response: Response,
    /// The communication point, after inputs were taken up.
    now: Moment,
    /// The end of the previous communication step, from which jumps of the inputs are counted.
    before: Moment,
    log: EventLog,
}

/// Cam and mass at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Moment {
    /// t [s].
    time: f64,
    /// φ modulo 2π [rad].
    reduced: f64,
    /// φ and its time derivatives.
    phi: [f64; 5],
    /// U … U⁗ [m].
    u: [f64; 5],
    /// q [m], q̇ [m/s].
    q: [f64; 2],
}

impl Moment {
    /// The cam at `time` on `motion`; on a breakpoint of the law the side to which the cam turns.
    fn of_cam(law: &MotionLaw, motion: &AngleMotion, time: f64) -> Self {
        let shaft = motion.at(time);
        let forward = shaft.kinematics.0[1] >= 0.0;
        let u = law.at_in(law.segment(shaft.reduced, forward), shaft.reduced);
        Moment { time, reduced: shaft.reduced, phi: shaft.kinematics.0, u: u.0, q: [0.0; 2] }
    }

    /// x and its time derivatives.
    fn lift(&self) -> Kinematics {
        TransferFunctions(self.u).along(&Kinematics(self.phi))
    }
}

impl ElasticOutput {
    fn oscillator(&self) -> Oscillator {
        Oscillator::of_mass(self.m, self.c, self.b)
    }

    /// Refuses parameters for which the equation has no meaning.
    fn validate(&self) -> Result<(), Fault> {
        let &ElasticOutput { m, c, b, .. } = self;
        let check = |good: bool, name: &str, value: f64, unit: &str, range: &str| {
            if good && value.is_finite() {
                Ok(())
            } else {
                Err(Fault(format!("`{name}` = {value} {unit} is outside {range} {unit}")))
            }
        };
        check(m > 0.0, "m", m, "kg", "(0, ∞)")?;
        check(c >= 0.0, "c", c, "N/m", "[0, ∞)")?;
        check(b >= 0.0, "b", b, "N·s/m", "[0, ∞)")?;
        self.cam.law.validate().map_err(Fault)
    }

    /// q, q̇ at the start.
    fn initial_state(&mut self, time: f64) -> Result<[f64; 2], Fault> {
        match self.start.mode {
            StartMode::AtRest => Ok([0.0; 2]),
            StartMode::Given => Ok([self.start.q, self.start.q_dot]),
            StartMode::SteadyState if self.cam.is_input() => Err(Fault::new(
                "start.mode = steady_state needs a constant speed, but this drive follows its inputs; choose at_rest \
                 or given",
            )),
            StartMode::SteadyState => self.response.periodic(&self.cam.law, &self.cam.motion(time), time),
        }
    }

    /// Cam and mass at `time` [s] on the motion that the inputs now give. The mass keeps position and velocity where
    /// they jump: q⁺ = q⁻ − Δx, q̇⁺ = q̇⁻ − Δẋ.
    fn taken_up(&self, motion: &AngleMotion, time: f64) -> Moment {
        let mut now = Moment::of_cam(&self.cam.law, motion, time);
        let [dx, dx_dot] = jump(&self.cam.law, &self.before, &now);
        now.q = [self.before.q[0] - dx, self.before.q[1] - dx_dot];
        now
    }

    /// Lets the response go on from `now`, on a motion that is valid up to `until` [s].
    fn restart(&mut self, motion: &AngleMotion, until: f64) -> Result<(), Fault> {
        self.response.set_oscillator(self.oscillator());
        self.response.restart(&self.cam.law, motion, self.now.time, until, self.now.q)
    }
}

/// How far x and ẋ jump from one moment to another at the same time. What lies within the rounding of the inputs is
/// no jump: else it would shake the mass at every communication point.
fn jump(law: &MotionLaw, before: &Moment, now: &Moment) -> [f64; 2] {
    let rounding = 4.0 * f64::EPSILON;
    let [phi, w, a, ..] = before.phi;
    let d_phi = now.phi[0] - phi;
    let d_w = now.phi[1] - w;
    let smooth = d_phi.abs() <= rounding * (phi.abs() + (w * now.time).abs());
    if smooth && d_w.abs() <= rounding * (w.abs() + (a * now.time).abs()) {
        return [0.0; 2];
    }
    let [u, u1, u2, u3, u4] = before.u;
    // Within this angle the series of U up to U⁗ is right to (1e-3)⁵/5! = 1e-17 of the finest harmonic.
    let (du, du1) = if d_phi.abs() * law.resolution() < 1e-3 && law.breakpoints().is_empty() {
        let d = d_phi;
        (d * (u1 + d / 2.0 * (u2 + d / 3.0 * (u3 + d / 4.0 * u4))), d * (u2 + d / 2.0 * (u3 + d / 3.0 * u4)))
    } else {
        (now.u[0] - u, now.u[1] - u1)
    };
    [du, now.u[1] * d_w + w * du1]
}

impl Drive for ElasticOutput {
    type Scene = Scene;

    const MODEL: &'static str = "ElasticCamDrive.output";

    fn new(scene: Scene) -> Result<Self, Fault> {
        let Scene { m, c, b, cam, drive, start, solver } = scene;
        let response = Response::new(Oscillator::of_mass(m, c, b), &cam);
        let drive = ElasticOutput {
            m,
            c,
            b,
            cam: CamDrive::new(cam, drive),
            start,
            solver: Solver::new(solver),
            response,
            now: Moment::default(),
            before: Moment::default(),
            log: EventLog::default(),
        };
        drive.validate()?;
        Ok(drive)
    }

    fn variables(&self) -> List<Self> {
        variables::list(self)
    }

    fn portrait(&self) -> Portrait {
        portrait::of(self)
    }

    fn curves(&self) -> Vec<Curve> {
        Curve::of_law(&self.cam.law)
    }

    fn experiment(&self) -> Experiment {
        portrait::experiment(self)
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        self.validate()?;
        self.cam.start(time);
        self.solver.start();
        // The law's parameters may have changed, and with them what the response keeps of it.
        self.response = Response::new(self.oscillator(), &self.cam.law);
        let q = self.initial_state(time)?;
        let motion = self.cam.motion(time);
        self.now = Moment { q, ..Moment::of_cam(&self.cam.law, &motion, time) };
        self.before = self.now;
        self.refuse_infinite()?;
        if !self.cam.is_input() {
            self.restart(&motion, f64::INFINITY)?;
        }
        Ok(())
    }

    fn apply(&mut self, time: f64) -> Result<(), Fault> {
        self.validate()?;
        if self.cam.is_input() {
            self.now = self.taken_up(&self.cam.motion(time), time);
        } else if self.oscillator() != *self.response.oscillator() {
            let motion = *self.response.motion();
            self.restart(&motion, f64::INFINITY)?;
        }
        Ok(())
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        let end = time + step;
        if self.cam.is_input() {
            let motion = self.cam.motion(time);
            self.now = self.taken_up(&motion, time);
            self.restart(&motion, end)?;
            self.cam.step_done();
        }
        let q = self.response.at(&self.cam.law, end)?;
        self.now = Moment { q, ..Moment::of_cam(&self.cam.law, self.response.motion(), end) };
        self.before = self.now;
        self.solver.steps = self.response.steps;
        self.solver.evaluations = self.response.evaluations;
        self.solver.error_estimate = self.response.error;
        self.refuse_infinite()
    }

    fn set_input_derivative(&mut self, reference: usize, order: usize, value: f64) {
        self.cam.set_input_derivative(reference, order, value);
    }

    fn input_derivative_order(&self) -> usize {
        if self.cam.is_input() { super::cam_drive::MAX_INPUT_DERIVATIVE } else { 0 }
    }

    fn request_tolerance(&mut self, tolerance: f64) {
        self.solver.requested = tolerance;
    }

    fn events(&mut self) -> &mut EventLog {
        &mut self.log
    }
}

impl ElasticOutput {
    fn refuse_infinite(&self) -> Result<(), Fault> {
        let [q, v] = self.now.q;
        if q.is_finite() && v.is_finite() && self.now.lift().0[..3].iter().all(|x| x.is_finite()) {
            Ok(())
        } else {
            Err(Fault(format!(
                "the motion is beyond all numbers at t = {} s: phi = {} rad, w = {} rad/s, q = {q} m",
                self.now.time, self.now.phi[0], self.now.phi[1]
            )))
        }
    }
}

impl HasCamDrive for ElasticOutput {
    fn cam(&self) -> &CamDrive {
        &self.cam
    }
    fn cam_mut(&mut self) -> &mut CamDrive {
        &mut self.cam
    }
    fn start_values(&self) -> &Start {
        &self.start
    }
    fn start_values_mut(&mut self) -> &mut Start {
        &mut self.start
    }
}

impl HasSolver for ElasticOutput {
    fn solver(&self) -> &Solver {
        &self.solver
    }
    fn solver_mut(&mut self) -> &mut Solver {
        &mut self.solver
    }
}
