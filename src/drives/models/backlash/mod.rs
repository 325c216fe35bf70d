//! Cam drive with backlash: a mass between the two flanks of the driven member, and an elastic mass on it.
//!
//! x1 is the place of m1, x2 = x1 + q the place of m2, U(φ) flank A, U + s flank B:
//!
//! ```text
//! m1 ẍ1 = F_K + c q + b q̇
//! m2 ẍ2 = −(c q + b q̇)
//! 0 ≤ x1 − U ≤ s;   on flank A F_K ≥ 0, on flank B F_K ≤ 0, between them F_K = 0
//! impact:  ż⁺ = −e ż⁻,  P = −m1 (1 + e) ż⁻,  z = x1 − U
//! ```
//!
//! * m1, m2 `[kg]`, c `[N/m]`, b `[N·s/m]`, clearance s `[m]`, restitution e `[1]`; F_K and the impulse P `[N]`, `[N·s]` act
//!   on m1, positive in +x; the torque U′F_K `[N·m]` loads the drive.
//! * Valid for a drive whose inertia is large against m1 U′², rigid flanks, an impact without duration.
//! * Limits that the tests check: s = 0 is the elastic output drive with m1 fixed to the cam; for a cubic U and e = 0
//!   the closed formulas of Kaltofen.
//!
//! Source: K. Kaltofen, "Zur Dynamik spielbehafteter periodischer Antriebe", 1996, extended to two flanks, restitution and damping;
//! U̇, Ü from consistent φ, φ̇, φ̈.

mod steady_state;
mod variables;

pub use crate::drives::follower::contact::Parameters;
use crate::drives::follower::contact::{Beginning, Bodies, Flank, Mode, Phase, State};
use crate::drives::follower::flank::FlankMotion;
use crate::drives::limits::{no_state, refused_start};
use crate::drives::parameter::parameters;
use crate::drives::settings::{FINEST_TOLERANCE, HasSolver, Settings, Solver};
use crate::drives::shaft::cam_drive::{
    AngleMotion, CamDrive, DriveMode, HasCamDrive, MAX_INPUT_DERIVATIVE, Start, StartMode, as_every_cam_drive, field,
    goes_on,
};
use crate::drives::shaft::flank::CamFlank;
use crate::drives::solver::contact::jump::MotionBefore;
use crate::drives::solver::contact::panel::Point;
use crate::drives::solver::contact::series::terms_for;
use crate::drives::solver::contact::{Run, Stretch, Tally};
use crate::drives::{Curve, Drive, EventLog, Experiment, Fault, List, Rounded, Text};
use crate::motion::MotionLaw;
use crate::numerics::double_double::Double;
use crate::numerics::work::Work;
use serde::{Deserialize, Serialize};

parameters!(Parameters of BacklashDrive.parameters);

/// A drive with backlash as a resolved scene describes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// m1, m2, c, b, s, e.
    pub parameters: Parameters,
    /// The motion law.
    pub cam: MotionLaw,
    /// Constant speed or inputs.
    pub drive: DriveMode,
    /// Whether outputs show the inertia that follows the shaft without slip.
    #[serde(default)]
    pub coupling: bool,
    /// The initial state.
    pub start: Start,
    /// `solver.tolerance`, `solver.method`, `solver.step_size`.
    pub solver: Settings,
}

/// The drive at a communication point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Now {
    /// The time (s).
    pub time: f64,
    /// The position of m1.
    pub mode: Mode,
    /// The relative state and the motion of the flank.
    pub point: Point,
    /// Counts since the start.
    pub tally: Tally,
}

/// The drive with backlash; see the module.
#[derive(Clone, Serialize, Deserialize)]
pub struct BacklashDrive {
    cam: CamDrive,
    start: Start,
    solver: Solver,
    parameters: Parameters,
    coupling: bool,
    /// The bodies with the parameters of the last start.
    bodies: Bodies,
    /// Bounds of |U|, |U′|, |U″|, with the parameters of the last start.
    bounds: [f64; 3],
    /// The motion of the shaft around the communication point.
    motion: AngleMotion,
    run: Option<Box<Run>>,
    /// The end of the last step, before inputs jump, and φ and ω there.
    end: Now,
    expected: [f64; 2],
    /// The communication point as the outputs show it.
    now: Now,
    /// The length of the last communication step (s); 0 before the first.
    step: f64,
    #[serde(skip)]
    log: EventLog,
}

impl BacklashDrive {
    fn flank(&self) -> CamFlank<'_> {
        CamFlank { law: &self.cam.law, motion: &self.motion, bounds: self.bounds }
    }

    /// The bodies and the bounds of the law for the present parameters.
    fn prepare_bodies(&mut self) {
        self.bounds = [0, 1, 2].map(|order| self.cam.law.bound(order));
        self.bodies = Bodies::new(&self.parameters);
    }

    /// The longest panel in a step of this length: inputs prescribe the motion to the end of the step only.
    fn horizon(&self, step: f64) -> f64 {
        if self.cam.is_input() { step } else { f64::INFINITY }
    }

    /// Places m1 on the flank that presses it and starts the run from q, q̇.
    fn begin(&mut self, time: f64, q: [f64; 2]) {
        let place = (Double::from(time), self.flank().segment(Double::from(time)));
        let u = self.flank().at(place.1, place.0);
        let [force, rate, _] = self.bodies.force(q, &u);
        let resolution = self.bodies.resolution(&self.flank(), place);
        let pressed = if force.abs() > resolution { force } else { rate };
        let contact = if pressed < 0.0 { Flank::B } else { Flank::A };
        let state = State { q, home: self.bodies.place(contact), zeta: [0.0; 2] };
        self.lay(time, Phase { mode: Mode::Contact(contact), state, zeros: 0 });
    }

    /// Starts the run.
    fn lay(&mut self, time: f64, phase: Phase) {
        let (flank, start) = (self.flank(), Double::from(time));
        let from = Beginning { start, segment: flank.segment(start), phase, longest: self.horizon(0.0) };
        let run = Run::new(&self.bodies, &flank, from, terms_for(self.tolerance()));
        self.show(&run, time);
        self.solver.error_estimate = run.error_estimate(&self.bodies, self.flank().sizes(time));
        self.end = self.now;
        self.run = Some(Box::new(run));
    }

    /// The tolerance in use: by default only rounding errors count, since impacts may multiply any error.
    fn tolerance(&self) -> f64 {
        let own = if self.has_tolerance() { self.solver.settings.tolerance } else { 0.0 };
        let own = if own > 0.0 { own } else { FINEST_TOLERANCE };
        if self.solver.requested > 0.0 { own.min(self.solver.requested) } else { own }
    }

    /// Shows the motion at `time` (s), which lies in the current panel.
    fn show(&mut self, run: &Run, time: f64) {
        let point = run.panel.at(&self.bodies, run.theta(time));
        self.now = Now { time, mode: run.panel.mode(), point, tally: run.tally };
    }

    /// (∫ F_K dt + ΣP)/h and (∫ U′F_K dt + ΣU′P)/h over the last communication step (N), (N·m).
    fn mean(&self) -> [f64; 2] {
        let Some(run) = self.run.as_ref().filter(|_| self.step > 0.0) else { return [0.0; 2] };
        run.sums(&self.flank(), self.now.time).array().map(|sum| sum / self.step)
    }

    /// ∫ b q̇² dt since the start (J).
    fn damping_loss(&self) -> f64 {
        let Some(run) = self.run.as_ref().filter(|_| self.bodies.b > 0.0) else { return 0.0 };
        self.now.tally.damping_loss + run.panel.damping_loss(&self.bodies, run.theta(self.now.time))
    }

    /// Goes on at constant speed from `time` to `end` within the current panel if it has no event and no count; returns whether it
    /// does.
    fn within_panel(&mut self, time: f64, end: f64, step: f64) -> bool {
        let Some(run) = self.run.as_deref_mut().filter(|_| !self.cam.is_input()) else { return false };
        let Some(point) = run.within(&self.bodies, end) else { return false };
        run.begin_step(time);
        (self.now.time, self.now.point, self.step) = (end, point, step);
        true
    }

    /// Advances over the ends of panels, or on inputs.
    #[inline(never)]
    fn go_on(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        let horizon = self.horizon(step);
        let input = self.cam.is_input();
        if input {
            self.motion = self.cam.motion(time);
            let ([phi, w, a, ..], [expected, speed]) = (self.motion.coefficients, self.expected);
            if !goes_on([expected, speed, a], [phi, w], time) {
                self.cam.jumps(self.expected, time, &mut self.log);
            }
        }
        let flank = CamFlank { law: &self.cam.law, motion: &self.motion, bounds: self.bounds };
        let Some(run) = self.run.as_deref_mut() else { return Err(Fault::new("the drive has not been started")) };
        run.begin_step(time);
        if input {
            run.pass_panel(&self.bodies, run.theta(time));
            // The inputs themselves are rounded, so place and velocity of the flank jump.
            let phi = self.motion.at(time).kinematics.0[0].abs();
            let [_, slope, curvature] = self.bounds;
            let w = flank.speed().abs();
            // The mean rounding is an eighth of the last place.
            let sizes = [slope * phi, (slope + curvature * phi) * w].map(|size| 0.125 * size);
            run.errors.round([sizes[0], sizes[1], sizes[0], sizes[1]]);
            let before = MotionBefore { mode: self.end.mode, point: &self.end.point };
            let phase = run.take_up(&self.bodies, &flank, before, time, &mut self.log);
            let start = Double::from(time);
            let from = Beginning { start, segment: flank.segment(start), phase, longest: horizon };
            run.restart(&self.bodies, &flank, from);
        }
        let end = time + step;
        let mut work = Work::default();
        run.advance(&self.bodies, &flank, &mut Stretch { end, horizon, log: &mut self.log, work: &mut work })?;
        let point = run.panel.at(&self.bodies, run.theta(end));
        if !point.is_finite() {
            return Err(Fault::new(format!("the motion leaves the range of numbers before t = {} s", Rounded(end))));
        }
        self.now = Now { time: end, mode: run.panel.mode(), point, tally: run.tally };
        self.step = step;
        if input {
            run.sum_up(&flank, end);
            self.end = self.now;
            let [phi, w, ..] = self.motion.kinematics(end);
            self.expected = [phi, w];
        }
        if self.solver.steps != run.tally.panels {
            self.solver.steps = run.tally.panels;
            self.solver.evaluations = run.tally.panels * run.terms() as f64;
            self.solver.error_estimate = run.error_estimate(&self.bodies, flank.sizes(end));
        }
        self.cam.step_done(&self.motion, end);
        Ok(())
    }
}

impl Drive for BacklashDrive {
    type Scene = Scene;

    const MODEL: &'static str = "BacklashDrive";
    const INPUT_DERIVATIVES: usize = MAX_INPUT_DERIVATIVE;

    fn new(scene: Scene) -> Result<Self, Fault> {
        let Scene { parameters, cam, drive, coupling, start, solver } = scene;
        let now = Now { time: 0.0, mode: Mode::Free, point: Point::default(), tally: Tally::default() };
        let bodies = Bodies::new(&parameters);
        Ok(BacklashDrive {
            motion: AngleMotion::uniform(0.0, 0.0, 0.0),
            cam: CamDrive::new(cam, drive),
            start,
            solver: Solver::new(solver),
            parameters,
            coupling,
            bodies,
            bounds: [0.0; 3],
            run: None,
            end: now,
            expected: [0.0; 2],
            now,
            step: 0.0,
            log: EventLog::default(),
        })
    }

    fn variables(&self) -> List<Self> {
        variables::list(self)
    }

    fn text(&self) -> Text {
        Text::new(
            include_str!("text.toml"),
            &[("inputs", self.cam.is_input()), ("tolerance", self.has_tolerance()), ("coupling", self.coupling)],
        )
    }

    fn curves(&self) -> Vec<Curve> {
        Curve::of_law(&self.cam.law)
    }

    fn experiment(&self) -> Experiment {
        Experiment::of_turns(4.0, self.cam.mode.speed())
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        self.solver.start();
        self.log.clear();
        self.step = 0.0;
        self.cam.start(time);
        self.motion = self.cam.motion(time);
        self.expected = [self.motion.coefficients[0], self.motion.coefficients[1]];
        self.prepare_bodies();
        match self.start.mode {
            StartMode::Equilibrium if self.parameters.s > 0.0 => {
                let message =
                    "start.mode = equilibrium: without loads m1 may be anywhere in its clearance; choose at_rest";
                return Err(refused_start(message));
            }
            StartMode::AtRest | StartMode::Equilibrium => self.begin(time, [0.0; 2]),
            StartMode::Given => self.begin(time, [self.start.q, self.start.q_dot]),
            StartMode::SteadyState => self.begin_steady(time)?,
        }
        Ok(())
    }

    fn apply(&mut self, time: f64) -> Result<(), Fault> {
        if !self.cam.is_input() {
            return Ok(());
        }
        let Some(mut run) = self.run.as_deref().copied() else { return Ok(()) };
        self.motion = self.cam.motion(time);
        let flank = CamFlank { law: &self.cam.law, motion: &self.motion, bounds: self.bounds };
        // Events are logged when the step is taken.
        let mut unheard = EventLog::counting();
        let before = MotionBefore { mode: self.end.mode, point: &self.end.point };
        let Phase { mode, state, .. } = run.take_up(&self.bodies, &flank, before, time, &mut unheard);
        let u = flank.at(flank.segment(Double::from(time)), Double::from(time)).0;
        let point = Point { state, u: [u[0], u[1], u[2]] };
        self.now = Now { time, mode, point, tally: run.tally };
        Ok(())
    }

    as_every_cam_drive!();

    fn held(&self) -> Option<(f64, bool)> {
        self.run.as_deref().filter(|_| !self.cam.is_input()).map(Run::held)
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        if self.within_panel(time, time + step, step) { Ok(()) } else { self.go_on(time, step) }
    }

    fn is_finite(&self) -> bool {
        self.now.point.is_finite()
    }

    fn restored(&mut self, made: &Self) -> Result<(), Fault> {
        self.cam.take(&made.cam);
        self.prepare_bodies();
        let (segments, terms) = (self.cam.law.breakpoints().len(), terms_for(self.tolerance()));
        if self.run.as_ref().is_some_and(|run| !run.is_of(segments, terms)) {
            return Err(no_state());
        }
        Ok(())
    }
}

impl HasCamDrive for BacklashDrive {
    type Law = MotionLaw;

    field!(cam, cam_mut: CamDrive = cam);
    field!(start_values, start_values_mut: Start = start);
}

impl HasSolver for BacklashDrive {
    /// At constant speed all terms of a series cost little more than a few; on inputs it pays to use fewer.
    fn has_tolerance(&self) -> bool {
        self.cam.is_input()
    }

    field!(solver, solver_mut: Solver = solver);
}

#[cfg(test)]
mod tests;
