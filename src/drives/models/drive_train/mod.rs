//! The drive train: a shaft with its motor, or a prescribed motion, and all that hangs on it, as one system.
//!
//! The equations are in [`crate::drives::shaft::train`], what integrates them in `solver::train`.

#[cfg(test)]
mod tests;

pub use crate::drives::follower::member::{Follower, Joint};
pub use crate::drives::shaft::train::{MOST_FOLLOWERS, Machine, Shaft};

use crate::drives::interface::EventLog;
use crate::drives::settings::{FINEST_TOLERANCE, Settings, Solver};
use crate::drives::shaft::cam_drive::{AngleMotion, CamDrive, DriveMode};
use crate::drives::shaft::train::{Inputs, MOST_STATES, Modes, Train};
use crate::drives::solver::train::{Outside, Run};
use crate::drives::{Fault, Rounded};
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The train as a scene describes it; coherent SI.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// What moves the shaft.
    pub shaft: Shaft,
    /// j counts from 1 in the variable names.
    pub followers: Vec<Follower>,
    /// How they begin.
    pub start: Start,
    /// `solver.tolerance`; the method is the adaptive one.
    pub solver: Settings,
}

/// How the followers begin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// q = q̇ = 0, contact.
    #[default]
    AtRest,
    /// Where the loads balance the springs.
    Equilibrium,
    /// On the periodic motion.
    SteadyState,
}

/// The train in operation.
#[derive(Clone, Serialize, Deserialize)]
pub struct DriveTrain {
    train: Train,
    start: Start,
    solver: Solver,
    inputs: Inputs,
    /// The course of a driven shaft.
    course: CamDrive<()>,
    motion: Option<AngleMotion>,
    run: Run,
    /// The communication point (s), and the length of the step before it.
    time: f64,
    step: f64,
    /// The inputs for which the present internal step holds.
    laid: Inputs,
    log: EventLog,
}

impl DriveTrain {
    /// The train of a scene.
    fn of(scene: Scene) -> Self {
        let Scene { shaft, followers, start, solver } = scene;
        let mode = if let Shaft::Driven(mode) = &shaft {
            mode.clone()
        } else {
            DriveMode::Constant { w: 0.0, phi_start: 0.0 }
        };
        DriveTrain {
            inputs: Inputs::of(followers.len()),
            laid: Inputs::of(followers.len()),
            train: Train::new(shaft, followers),
            start,
            solver: Solver::new(solver),
            course: CamDrive::new((), mode),
            motion: None,
            run: Run::default(),
            time: 0.0,
            step: 0.0,
            log: EventLog::default(),
        }
    }

    /// How long what comes from outside is known (s).
    fn horizon(&self, step: f64) -> f64 {
        let known = self.inputs.are_constant() && !(self.motion.is_some() && self.course.is_input());
        if known { f64::INFINITY } else { step }
    }

    /// φ and the states at the start.
    fn first_states(&self) -> ([f64; MOST_STATES], f64) {
        let mut y = [0.0; MOST_STATES];
        let Some(machine) = self.train.machine() else { return (y, 0.0) };
        (y[0], y[1]) = (angle::reduce(Double::from(machine.phi_start)), machine.w_start);
        machine.motor.begin(&mut y, &self.train.layout);
        (y, ((machine.phi_start - y[0]) / TAU).round())
    }

    /// Starts at `time` (s).
    fn begin(&mut self, time: f64) -> Result<(), Fault> {
        self.solver.start();
        self.log.clear();
        self.course.start(time);
        self.motion = self.train.machine().is_none().then(|| self.course.motion(time));
        (self.time, self.step) = (time, 0.0);
        let (y, turns) = self.first_states();
        let tolerance = self.solver.effective_tolerance().max(FINEST_TOLERANCE);
        let count = self.train.layout.count;
        let mut run = Run::begin(&self.train, Double::from(time), (&y[..count], turns), Modes::default(), tolerance);
        let outside = Outside { time, motion: self.motion.as_ref(), inputs: &self.inputs };
        run.choose_modes(&self.train, &outside, &mut self.log);
        run.first(&self.train, &outside, self.horizon(0.0))?;
        self.run = run;
        self.laid = self.inputs.clone();
        Ok(())
    }

    fn go_on(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        let horizon = self.horizon(step);
        let input = self.motion.is_some() && self.course.is_input();
        if input {
            self.motion = Some(self.course.motion(time));
        }
        self.run.begin_step(&self.train, time);
        if input || horizon.is_finite() || self.laid != self.inputs {
            self.run.restart(&self.train, time);
            self.laid.clone_from(&self.inputs);
        }
        let outside = Outside { time, motion: self.motion.as_ref(), inputs: &self.inputs };
        self.run.advance(&self.train, &outside, (time + step, horizon), &mut self.log)?;
        (self.time, self.step) = (time + step, step);
        Ok(())
    }
}
