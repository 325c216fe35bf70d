//! The drive train: a shaft with its motor, or a prescribed motion, and all its followers, as one system.
//!
//! The equations are in [`crate::drives::shaft::train`], the integration in `solver::train`.

mod alone;
mod dependencies;
mod names;
#[cfg(test)]
mod tests;
mod variables;

pub use crate::drives::follower::joint::{Follower, Joint, Stand};
pub use crate::drives::shaft::train::{MOST_FOLLOWERS, Machine, Shaft};
pub use names::Names;

use crate::drives::limits::{NO_SPEED, ON_INPUT, no_periodic_motion, no_state, refused_start};
use crate::drives::settings::{FINEST_TOLERANCE, HasSolver, Settings, Solver};
use crate::drives::shaft::cam_drive::{AngleMotion, CamDrive, DriveMode, MAX_INPUT_DERIVATIVE, field};
use crate::drives::shaft::free::coupled::NamedLoad;
use crate::drives::shaft::free::inertia::Inertia;
use crate::drives::shaft::free::signal::Signal;
use crate::drives::shaft::train::{Inputs, MOST_STATES, Modes, Train};
use crate::drives::solver::train::periodic::periodic;
pub use crate::drives::solver::train::periodic::{Periodic, STABLE};
use crate::drives::solver::train::{End, Excitation, Place, Run};
use crate::drives::{Curve, Drive, EventLog, Experiment, Fault, List, Number, Text};
use crate::motion::MotionLaw;
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The train as a scene describes it; coherent SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// The shaft.
    pub shaft: Shaft,
    /// The followers; j counts from 1 in the variable names.
    pub followers: Vec<Follower>,
    /// The start of the followers.
    pub start: Start,
    /// Whether outputs of a driven train show the inertia that follows its shaft without slip.
    #[serde(default)]
    pub coupling: bool,
    /// `solver.tolerance`; the method is the adaptive one.
    pub solver: Settings,
    /// The names of the variables.
    #[serde(default)]
    pub names: Names,
}

/// The start of the followers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// q = q̇ = 0, contact.
    #[default]
    AtRest,
    /// In the equilibrium of loads and springs.
    Equilibrium,
    /// On the periodic motion.
    SteadyState,
    /// From q and q̇ of a BacklashDrive.
    Given,
}

/// The train in operation.
#[derive(Clone, Serialize, Deserialize)]
pub struct DriveTrain {
    train: Train,
    start: Start,
    coupling: bool,
    names: Names,
    solver: Solver,
    inputs: Inputs,
    /// The motion of a driven shaft.
    shaft: CamDrive<()>,
    motion: Option<AngleMotion>,
    run: Run,
    /// The communication point (s), and the length of the step to it.
    time: f64,
    step: f64,
    /// The inputs of the present internal step.
    laid: Inputs,
    /// The end of the last step, before inputs jump, if they drive the shaft.
    end: Option<Box<End>>,
    /// Whether a parameter has changed since the last step.
    tuned: bool,
    /// The followers whose pulling cams have been logged.
    logged: Vec<bool>,
    log: EventLog,
    /// Whether a force holds a follower on its cam, which then may pull.
    #[serde(skip)]
    held: bool,
    /// What the outputs are made of.
    #[serde(skip)]
    forms: alone::FormCache,
}

impl DriveTrain {
    /// The train of a scene.
    fn of(scene: Scene) -> Self {
        let Scene { shaft, followers, start, coupling, solver, names } = scene;
        let mode = if let Shaft::Driven(mode) = &shaft {
            mode.clone()
        } else {
            DriveMode::Constant { w: 0.0, phi_start: 0.0 }
        };
        let loads: &[NamedLoad] = if let Shaft::Free(machine) = &shaft { &machine.loads } else { &[] };
        DriveTrain {
            inputs: Inputs::of(followers.len(), loads),
            laid: Inputs::of(followers.len(), loads),
            train: Train::new(shaft, followers),
            start,
            coupling,
            names,
            solver: Solver::new(solver),
            shaft: CamDrive::new((), mode),
            motion: None,
            run: Run::default(),
            time: 0.0,
            step: 0.0,
            end: None,
            tuned: false,
            logged: Vec::new(),
            log: EventLog::default(),
            held: false,
            forms: alone::FormCache::default(),
        }
    }

    /// Whether the shaft follows its inputs.
    fn motion_is_input(&self) -> bool {
        self.train.machine().is_none() && self.shaft.is_input()
    }

    /// The time for which the external influences are known (s).
    fn horizon(&self, step: f64) -> f64 {
        let known = self.inputs.are_constant() && !self.motion_is_input();
        if known { f64::INFINITY } else { step }
    }

    /// φ and the states at the start.
    fn first_states(&self) -> ([f64; MOST_STATES], f64) {
        let mut y = [0.0; MOST_STATES];
        let layout = &self.train.layout;
        if let (Names::Backlash(q), Start::Given) = (self.names, self.start) {
            // After z and ż.
            y[2..4].copy_from_slice(&q);
        }
        let Some(machine) = self.train.machine() else { return (y, 0.0) };
        (y[0], y[1]) = (angle::reduce(Double::from(machine.phi_start)), machine.w_start);
        machine.motor.begin(&mut y, layout);
        if let (Names::Machine(torque), true) = (self.names, self.lags()) {
            y[layout.motor] = torque;
        }
        (y, ((machine.phi_start - y[0]) / TAU).round())
    }

    /// Starts at `time` (s).
    fn begin(&mut self, time: f64) -> Result<(), Fault> {
        self.begin_within(time, STABLE).map(drop)
    }

    /// Starts at `time` (s); a periodic motion with a larger multiplier is refused.
    fn begin_within(&mut self, time: f64, most: f64) -> Result<Option<Box<Periodic>>, Fault> {
        self.solver.start();
        self.log.clear();
        self.logged = vec![false; self.train.followers.len()];
        self.held = self.is_held();
        self.shaft.start(time);
        self.motion = self.train.machine().is_none().then(|| self.shaft.motion(time));
        (self.time, self.step) = (time, 0.0);
        let (y, turns) = self.first_states();
        self.set_off(time, &y, Modes::default());
        self.run.turns = turns;
        let excitation = Excitation { time, motion: self.motion.as_ref(), inputs: &self.inputs };
        self.run.choose_modes(&self.train, &excitation, self.start == Start::Equilibrium, &mut self.log)?;
        let steady = self.start == Start::SteadyState;
        let found = if steady { Some(self.periodic(&self.run, &excitation)?) } else { None };
        if let Some(found) = &found {
            if found.multiplier > most {
                let largest = found.multiplier;
                let reason = format!("the periodic motion is not stable, its largest multiplier is {largest:.6}");
                return Err(no_periodic_motion(reason, "; choose more damping, another speed or at_rest"));
            }
            self.set_off(time, &found.y, found.modes);
            self.run.turns = turns;
            self.run.set_period(found);
        }
        // In the words of a BacklashDrive.
        let spring = || self.train.followers.iter().all(|follower| follower.joint.sprung().is_some());
        if matches!(self.names, Names::Backlash(_)) && spring() {
            self.run.tallies[0].damped = Some(0.0);
        }
        let horizon = self.horizon(0.0);
        let excitation = Excitation { time, motion: self.motion.as_ref(), inputs: &self.inputs };
        self.run.first(&self.train, &excitation, horizon)?;
        self.laid.take(&self.inputs);
        self.end = self.motion_is_input().then(Box::default);
        self.keep_end();
        Ok(found)
    }

    /// Begins a run at `time` (s) with these states. Not inlined: a run is large, and hosts give their threads small stacks.
    #[inline(never)]
    fn set_off(&mut self, time: f64, y: &[f64; MOST_STATES], modes: Modes) {
        let tolerance = self.solver.effective_tolerance().max(FINEST_TOLERANCE);
        self.run = Run::begin(&self.train, Double::from(time), &y[..self.train.layout.count], modes, tolerance);
    }

    /// The periodic motion near these states, stable or not.
    ///
    /// # Errors
    /// No speed is known, or no periodic motion is found.
    #[inline(never)]
    fn periodic(&self, run: &Run, excitation: &Excitation) -> Result<Box<Periodic>, Fault> {
        let motor = self.motor();
        // A servo whose speed is an input has no speed of its own.
        let given = self.machine().filter(|m| !m.motor.takes_speed()).map_or(0.0, |machine| machine.w_start);
        let usual = motor.map_or(self.shaft.mode.speed(), |motor| motor.usual_speed().unwrap_or(given));
        let steady = motor.is_none_or(|motor| motor.is_steady());
        let refused = |reason: &str| {
            let others = if let Names::Machine(_) = self.names { "given" } else { "at_rest or equilibrium" };
            Err(no_periodic_motion(reason, "").hint(format!("choose {others}")))
        };
        if !steady || self.motion_is_input() || usual == 0.0 && self.machine().is_some_and(|m| m.motor.takes_speed()) {
            return refused(ON_INPUT);
        }
        if usual == 0.0 {
            return refused(NO_SPEED);
        }
        if !self.inputs.are_constant() {
            return refused("an input changes with time");
        }
        let mut y = [0.0; MOST_STATES];
        run.from(&mut y);
        if let Some(motor) = motor {
            y[1] = usual;
            motor.begin(&mut y, &self.train.layout);
        }
        periodic(&self.train, excitation, (y, run.modes), usual.signum()).map(Box::new)
    }

    /// Starts on the periodic motion, stable or not.
    ///
    /// # Errors
    /// There is no periodic motion.
    pub fn periodic_motion(&mut self) -> Result<Periodic, Fault> {
        self.start = Start::SteadyState;
        let found = self.begin_within(0.0, f64::INFINITY)?;
        found.map(|found| *found).ok_or_else(|| refused_start("there is no periodic motion"))
    }

    fn go_on(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        self.inputs.all().for_each(Signal::step_begins);
        let horizon = self.horizon(step);
        let input = self.motion_is_input();
        if let (Some(end), Some(motion)) = (&self.end, self.motion.as_mut()) {
            *motion = self.shaft.motion(time);
            let excitation = Excitation { time, motion: Some(motion), inputs: &self.inputs };
            if self.run.jump(&self.train, &excitation, (end, true), &mut self.log) {
                self.shaft.jumps(end.shaft, time, &mut self.log);
            }
        } else {
            self.run.begin_step(&self.train, time);
        }
        if input || horizon.is_finite() || !self.inputs.are_like(&self.laid) {
            self.restart(time);
        }
        let excitation = Excitation { time, motion: self.motion.as_ref(), inputs: &self.inputs };
        self.run.advance(&self.train, &excitation, (time + step, horizon), &mut self.log)?;
        (self.time, self.step) = (time + step, step);
        self.inputs.all().for_each(|signal| signal.step_ends(step));
        self.keep_end();
        if self.held {
            self.watch();
        }
        if let Some(motion) = &self.motion {
            self.shaft.step_done(motion, time + step);
        }
        Ok(())
    }

    /// Whether a force holds a follower on its cam.
    fn is_held(&self) -> bool {
        let forces = self.train.followers.iter().flat_map(|follower| [0.0, 1.0].map(|y| follower.hold(y)));
        forces.into_iter().any(|force| force != 0.0)
    }

    /// Prepares the change of a parameter: the step up to the communication point belongs to the equations before.
    fn retune(&mut self) {
        if !self.tuned {
            self.tuned = true;
            self.end_step(self.time);
        }
    }

    /// Ends the present internal step at the communication point `time` (s).
    fn end_step(&mut self, time: f64) {
        let before = Excitation { time: self.time - self.step, motion: self.motion.as_ref(), inputs: &self.laid };
        self.run.restart(&self.train, &before, time);
    }

    /// Finds the pieces of all laws anew; a parameter may have changed their number and borders.
    fn locate(&mut self) {
        let excitation = Excitation { time: self.time, motion: self.motion.as_ref(), inputs: &self.inputs };
        self.run.locate(&self.train, &excitation);
        self.end.iter_mut().for_each(|end| end.locate(&self.train));
    }

    /// Restarts the equations from the communication point `time` (s).
    fn restart(&mut self, time: f64) {
        self.end_step(time);
        self.laid.take(&self.inputs);
        // If inputs drive the shaft, it has jumped or is about to.
        if self.end.is_none() {
            let excitation = Excitation { time, motion: self.motion.as_ref(), inputs: &self.inputs };
            self.run.decide(&self.train, &excitation, &mut self.log);
        }
    }

    /// Keeps the end of the step if inputs may jump.
    fn keep_end(&mut self) {
        if let (Some(end), Some(motion)) = (&mut self.end, &self.motion) {
            self.run.keep(&self.train, self.time, motion, end);
        }
    }
}

impl Drive for DriveTrain {
    type Scene = Scene;
    const MODEL: &'static str = "DriveTrain";
    const INPUT_DERIVATIVES: usize = MAX_INPUT_DERIVATIVE;

    fn new(scene: Scene) -> Result<Self, Fault> {
        let train = DriveTrain::of(scene);
        train.check()?;
        Ok(train)
    }

    fn variables(&self) -> List<Self> {
        let table = self.table();
        self.declare(&table, &self.dependencies(&table))
    }

    fn text(&self) -> Text {
        let joints = |is: fn(&Joint) -> bool| self.train.followers.iter().any(|follower| is(&follower.joint));
        let motor = self.machine().map(|machine| &machine.motor);
        let followers = &self.train.followers;
        let held = |f: &Follower| f.rigid.has_cam() && f.joint.clearance().is_none();
        let conditions = [
            ("free", self.machine().is_some()),
            ("followers", !followers.is_empty()),
            ("held", followers.iter().any(|f| held(f) && (!f.load.is_none() || !f.roller.is_none()))),
            ("loaded", self.machine().is_some_and(|machine| !machine.loads.is_empty())),
            ("process", self.machine().is_some_and(|machine| machine.load.is_some())),
            ("friction", self.machine().is_some_and(|machine| machine.friction.is_some())),
            ("position", motor.is_some_and(|motor| motor.takes_position())),
            ("of backlash", matches!(self.names, Names::Backlash(_))),
            ("of machine", matches!(self.names, Names::Machine(_))),
            ("output", joints(|joint| joint.sprung().is_some() && joint.clearance().is_none())),
            ("shaft", joints(Joint::carries_cam)),
            ("backlash", joints(|joint| joint.clearance().is_some())),
            ("loads", followers.iter().any(|f| !f.load.is_none() || !f.roller.is_none())),
            ("motor", motor.is_some_and(|motor| motor.source != crate::drives::shaft::motor::Source::None)),
            ("servo", motor.is_some_and(|motor| motor.servo().is_some())),
            ("coupling", motor.is_some_and(|motor| motor.transmission.coupling.is_some())),
            ("matching", self.coupling),
        ];
        let conditions = [&conditions[..], &self.inputs.loads.conditions()].concat();
        Text::new(include_str!("text.toml"), &conditions)
    }

    fn curves(&self) -> Vec<Curve> {
        let mut curves = Vec::new();
        for (j, follower) in self.train.followers.iter().enumerate() {
            let rigid = &follower.rigid;
            let (unit, factor) = if rigid.turns { ("°", 1f64.to_degrees()) } else { ("mm", 1e3) };
            let (title, label) =
                (format!("Position function of follower {}", j + 1), format!("follower[{}].U [{unit}]", j + 1));
            curves.push(Curve::over_turn(&title, &label, |phi| factor * rigid.tool(rigid.cam.at(phi).0)[0]));
        }
        if curves.is_empty() {
            let inertia = self.machine().map_or(0.0, |machine| machine.inertia.constant);
            curves.push(Curve::over_turn("Moment of inertia J(φ)", "J [kg·m²]", |_| inertia));
        }
        curves
    }

    /// Twenty turns at the speed of the motor or the start, one second at rest.
    fn experiment(&self) -> Experiment {
        let speed = match self.machine() {
            None => self.shaft.mode.speed(),
            Some(machine) => machine.motor.usual_speed().unwrap_or(machine.w_start),
        };
        Experiment::of_turns(20.0, speed.abs())
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        self.check()?;
        self.tuned = false;
        self.begin(time)?;
        self.find_all_forms();
        Ok(())
    }

    fn apply(&mut self, time: f64) -> Result<(), Fault> {
        if self.tuned {
            self.check()?;
            self.run.forget();
            self.held = self.is_held();
            self.find_all_forms();
            self.locate();
        }
        if self.tuned || !self.inputs.are_like(&self.laid) {
            self.tuned = false;
            self.restart(time);
            let excitation = Excitation { time, motion: self.motion.as_ref(), inputs: &self.inputs };
            self.run.rebuild(&self.train, &excitation);
        }
        if let (Some(end), Some(motion)) = (&self.end, self.motion.as_mut()) {
            *motion = self.shaft.motion(time);
            let excitation = Excitation { time, motion: Some(motion), inputs: &self.inputs };
            // Events are logged when the step is taken.
            self.run.jump(&self.train, &excitation, (end, false), &mut EventLog::counting());
        }
        Ok(())
    }

    fn angle(&self, time: f64, end: f64) -> f64 {
        if self.machine().is_none() {
            return self.shaft.angle(time, end);
        }
        let place = Place::at(self.run.theta_at(self.time));
        let [phi, w] = [0, 1].map(|k| self.run.state(k, &place));
        self.run.turns * TAU + phi + w * (end - time)
    }

    fn held(&self) -> Option<(f64, bool)> {
        self.horizon(0.0).is_infinite().then(|| self.run.held())
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        self.go_on(time, step)
    }

    fn evaluate(&self, values: &mut [f64]) {
        variables::evaluate(self, values);
    }

    fn value(&mut self, place: usize) -> Option<f64> {
        self.alone(place)
    }

    fn request_tolerance(&mut self, tolerance: f64) {
        self.solver.requested = tolerance;
    }

    fn is_finite(&self) -> bool {
        self.run.is_finite()
    }

    fn events(&mut self) -> &mut EventLog {
        &mut self.log
    }

    /// Only the parameters of the train count, and they are those of `made`.
    fn restored(&mut self, made: &Self) -> Result<(), Fault> {
        self.train = made.train.clone();
        (self.names, self.start, self.coupling) = (made.names, made.start, made.coupling);
        self.shaft.take(&made.shaft);
        let alike = [&self.inputs, &self.laid].iter().all(|inputs| inputs.fit(&made.inputs));
        let driven = self.train.machine().is_none();
        let fits = alike
            && self.motion.is_some() == driven
            && self.end.is_some() == self.motion_is_input()
            && self.logged.len() == self.train.followers.len()
            && self.end.as_ref().is_none_or(|end| end.fits(&self.train))
            && self.run.fits(&self.train);
        if !fits {
            return Err(no_state());
        }
        if self.tuned {
            // The pieces belong to laws that have changed since.
            self.locate();
        }
        let of_end = self.end.as_ref().is_none_or(|end| end.has_segments_of(&self.train));
        if !(of_end && self.run.has_segments_of(&self.train)) {
            return Err(no_state());
        }
        let excitation = Excitation { time: self.time - self.step, motion: self.motion.as_ref(), inputs: &self.laid };
        self.run.rebuild(&self.train, &excitation);
        self.held = self.is_held();
        self.find_all_forms();
        Ok(())
    }
}

impl HasSolver for DriveTrain {
    field!(solver, solver_mut: Solver = solver);
}

impl DriveTrain {
    /// Refuses parameters that describe no train.
    fn check(&self) -> Result<(), Fault> {
        for (j, follower) in self.train.followers.iter().enumerate() {
            let [cam, linkage, load, s] = ["cam", "linkage", "load", "s"].map(|part| self.names.of(j, part));
            follower.rigid.cam.validate().map_err(|message| Fault::new(message).of(cam))?;
            follower.rigid.check_linkage(&linkage)?;
            follower.load.validate(&load)?;
            if follower.joint.clearance().is_some_and(|p| p.s == 0.0) {
                let message = " = 0: without clearance it is an elastic output with the mass m1 on the cam's side; use `elasticity` with `m_roller`";
                return Err(Fault::named(s, message));
            }
        }
        let Some(machine) = self.machine() else { return Ok(()) };
        let load = machine.load.as_ref().map_or(Ok(()), MotionLaw::validate);
        load.map_err(|message| Fault::new(format!("load.M: {message}")).of("load.M"))?;
        let rigid = self.train.followers.iter().filter(|follower| follower.joint == Joint::Rigid);
        let inertia = Inertia::new(machine.inertia.clone(), rigid.map(|follower| follower.rigid.clone()).collect());
        inertia.validate()?;
        let (low, _) = inertia.range();
        if !(low + machine.motor.stiff_rotor() > 0.0) {
            let message = format!(
                "the moment of inertia that follows the shaft must be positive at every angle, but its lower bound is {} kg.m2; \
                 choose a larger `J0` (now {} kg.m2)",
                Number(low),
                machine.inertia.constant
            );
            return Err(Fault::new(message).of("J0"));
        }
        Ok(())
    }
}
