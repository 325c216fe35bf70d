//! The drive under loads. The equation is linear: to the motion that the cam makes, under the spring and the damper of the load,
//! those that the process force, and constant loads and input make, add up.

use super::ElasticOutput;
use crate::drives::follower::elastic_output::Equation;
use crate::drives::follower::load::Load;
use crate::drives::shaft::cam_drive::{AngleMotion, DriveMode, ShaftState, StartMode};
use crate::drives::shaft::free::signal::Signal;
use crate::drives::shaft::instant::Instant;
use crate::drives::shaft::loads::HasLoads;
use crate::drives::solver::response::Response;
use crate::drives::solver::response::push::Push;
use crate::drives::{Event, Fault};
use crate::motion::MotionLaw;
use crate::numerics::number::all_finite;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The loads and what they make of q.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Loaded {
    /// On the mass, and on the mass on the cam's side.
    pub loads: Arc<[Load; 2]>,
    /// m_x (kg).
    pub m_roller: f64,
    /// What a process force on the mass makes.
    pub process: Option<Process>,
    /// What constant loads and the input make.
    pub push: Push,
    /// The input on the cam's side.
    pub roller: Signal,
    /// Whether a parameter of the loads has changed since the last step.
    tuned: bool,
    /// The largest |q| at a communication point (m).
    pub largest: f64,
    /// Whether the cam pulls, and whether that has been told.
    pulls: bool,
    told: bool,
}

/// The motion that a process force makes: P(φ) in the place of the cam's motion.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Process {
    law: Arc<MotionLaw>,
    response: Response,
    /// P and its derivatives stand for those of U; see [`ElasticOutput`].
    pub now: Instant,
    end: Instant,
}

impl Process {
    /// Tabulates the turn where that helps, unless it is `known`.
    fn tabulate(&mut self, mode: &DriveMode, known: Option<&Process>) {
        if let DriveMode::Constant { w, phi_start } = *mode {
            self.response.tabulate(known.and_then(|process| process.response.table.clone()), &self.law, w, phi_start);
        }
    }

    /// Lets the response go on from the communication point at constant speed.
    fn restart(&mut self) -> Result<(), Fault> {
        let motion = self.response.motion;
        self.response.restart(&self.law, &motion, self.now.time, f64::INFINITY, self.now.q.array())
    }
}

impl Loaded {
    pub(super) fn new(loads: [Load; 2], m_roller: f64) -> Result<Option<Box<Self>>, Fault> {
        if loads.iter().all(Load::is_none) && m_roller == 0.0 {
            return Ok(None);
        }
        let loaded = Loaded {
            loads: Arc::new(loads),
            m_roller,
            process: None,
            push: Push::default(),
            roller: Signal::default(),
            tuned: false,
            largest: 0.0,
            pulls: false,
            told: false,
        };
        loaded.validate()?;
        Ok(Some(Box::new(loaded)))
    }

    fn validate(&self) -> Result<(), Fault> {
        for (load, place) in self.loads.iter().zip(["load.process", "load.roller.process"]) {
            let process = load.process.as_ref().map_or(Ok(()), MotionLaw::validate);
            process.map_err(|message| Fault::new(message).of(place))?;
        }
        Ok(())
    }

    /// What the process force on the mass makes, in front of its start.
    pub(super) fn make_process(&mut self, equation: &Equation, tolerance: f64, mode: &DriveMode) {
        let known = self.process.take();
        self.process = self.loads[0].process.as_ref().map(|law| {
            let response = Response::new(equation.of_force(), law, tolerance);
            let (law, now) = (Arc::new(law.clone()), Instant::default());
            let mut process = Process { law, response, now, end: now };
            process.tabulate(mode, known.as_ref());
            process
        });
    }

    /// What constant loads make of the acceleration of the mass `m` (m/s²).
    fn still(&self, m: f64) -> f64 {
        self.loads[0].constant_part(m) / m
    }

    /// Whether there are constant loads or an input on the mass.
    fn is_pushed(&self) -> bool {
        let Load { gravity, constant, spring, input, .. } = &self.loads[0];
        *input || gravity.is_some() || constant.is_some() || spring.is_some()
    }

    /// Computes how process, constant loads and input start in this mode.
    pub(super) fn start(
        &mut self,
        equation: &Equation,
        drive: (&DriveMode, &AngleMotion),
        (start, tolerance, time): (StartMode, f64, f64),
    ) -> Result<(), Fault> {
        self.validate()?;
        let (mode, motion) = drive;
        (self.tuned, self.largest, self.pulls, self.told) = (false, 0.0, false, false);
        let ([m, ..], oscillator) = (equation.parameters, &equation.oscillator);
        let settled = matches!(start, StartMode::SteadyState | StartMode::Equilibrium);
        let acceleration = self.still(m) + self.push.signal.set_value() / m;
        self.push.begin([if settled { acceleration / oscillator.stiffness() } else { 0.0 }, 0.0]);
        self.make_process(equation, tolerance, mode);
        let Some(process) = &mut self.process else { return Ok(()) };
        process.response.motion = *motion;
        let q = match start {
            StartMode::SteadyState => process.response.periodic(&process.law, motion, time)?,
            StartMode::Equilibrium => process.response.at_rest(&process.law, motion, time),
            _ => [0.0; 2],
        };
        process.now = Instant::on(motion, &process.law, time, q);
        process.end = process.now;
        if matches!(mode, DriveMode::Constant { .. }) {
            process.restart()?;
        }
        Ok(())
    }

    /// Steps, evaluations, and the estimated error of q relative to its largest size, where the cam's motion makes these
    /// steps, evaluations, and this error of q (m).
    pub(super) fn tally(&self, [mut steps, mut evaluations, mut error]: [f64; 3]) -> [f64; 3] {
        if let Some(Process { response, now, .. }) = &self.process {
            (steps, evaluations) = (steps + response.steps, evaluations + response.evaluations as f64);
            error += response.error(now.time) * response.largest();
        }
        error += self.push.error();
        [steps, evaluations, if self.largest > 0.0 { (error / self.largest).min(1.0) } else { 0.0 }]
    }

    /// Conditions of the text.
    pub(super) fn conditions(loaded: Option<&Self>) -> [(&'static str, bool); 7] {
        let any = |has: fn(&Load) -> bool| loaded.is_some_and(|loaded| loaded.loads.iter().any(has));
        [
            ("load", loaded.is_some()),
            ("load on mass", loaded.is_some_and(|loaded| !loaded.loads[0].is_none())),
            ("roller", loaded.is_some_and(|loaded| loaded.m_roller > 0.0 || !loaded.loads[1].is_none())),
            ("spring", any(|load| load.spring.is_some())),
            ("process", any(|load| load.process.is_some())),
            ("F", any(|load| load.input)),
            ("held", any(|load| load.spring.is_some() || load.gravity.is_some() || load.constant.is_some())),
        ]
    }
}

impl ElasticOutput {
    /// Computes how the loads start.
    pub(super) fn start_loads(&mut self, time: f64) -> Result<(), Fault> {
        let (equation, tolerance, motion) = (*self.response.equation(), self.tolerance(), self.response.motion);
        let Some(loaded) = &mut self.loaded else { return Ok(()) };
        loaded.start(&equation, (&self.cam.mode, &motion), (self.start.mode, tolerance, time))?;
        self.watch();
        Ok(())
    }

    /// The equation of what the cam makes of q.
    pub(super) fn equation(&self) -> Equation {
        let equation = self.parameters.equation();
        self.loaded.as_ref().map_or(equation, |loaded| equation.under(&loaded.loads[0]))
    }

    /// q and q̇.
    #[inline(always)]
    pub(super) fn deformation(&self) -> [f64; 2] {
        let q = self.now.q.array();
        let Some(loaded) = &self.loaded else { return q };
        let process = loaded.process.as_ref().map_or([0.0; 2], |process| process.now.q.array());
        [0, 1].map(|i| q[i] + loaded.push.now[i] + process[i])
    }

    /// Whether the parameters of the loads have changed since the last step; what they make of q then starts anew.
    pub(super) fn retune_loads(&mut self, tuned: bool) -> Result<bool, Fault> {
        let (equation, tolerance) = (self.equation(), self.tolerance());
        let Some(loaded) = &mut self.loaded else { return Ok(tuned) };
        if !(tuned || loaded.tuned) {
            return Ok(false);
        }
        loaded.validate()?;
        loaded.tuned = false;
        loaded.push.restart();
        if let (Some(process), Some(law)) = (&mut loaded.process, &loaded.loads[0].process) {
            if *law != *process.law {
                let motion = process.response.motion;
                process.law = Arc::new(law.clone());
                process.response = Response::new(equation.of_force(), law, tolerance);
                process.response.motion = motion;
            }
            process.response.set_equation(equation.of_force());
            if !self.cam.is_input() {
                process.restart()?;
            }
        }
        Ok(true)
    }

    /// The process goes on from `time` (s) as the inputs say.
    pub(super) fn take_up_process(&mut self, motion: &AngleMotion, time: f64, goes_on: bool) {
        if let Some(process) = self.loaded.as_mut().and_then(|loaded| loaded.process.as_mut()) {
            let ([phi, w, a, ..], end) = (motion.coefficients, process.end);
            process.now = Instant { time, shaft: [phi, w, a], ..end };
            if !goes_on {
                let force = ShaftState::at_angle([phi, w, a]).on(&process.law);
                process.now = Instant::new(time, [phi, w, a], &force, end.q);
            }
            process.response.motion = *motion;
        }
    }

    /// Brings what the loads make of q from one time to another (s); `goes_on` where the inputs did.
    pub(super) fn advance_loads(&mut self, [time, end]: [f64; 2], goes_on: bool) -> Result<(), Fault> {
        let (is_input, equation) = (self.cam.is_input(), *self.response.equation());
        let Some(loaded) = &mut self.loaded else { return Ok(()) };
        let m = equation.parameters[0];
        if loaded.is_pushed() {
            let still = loaded.still(m);
            loaded.push.advance(&equation.oscillator, m, still, [time, end]);
        }
        loaded.roller.step_begins();
        loaded.roller.step_ends(end - time);
        if let Some(Process { law, response, now, end: last }) = &mut loaded.process {
            if is_input {
                response.step(law, end, goes_on, now)?;
                *last = *now;
            } else {
                response.reach(law, end, now)?;
            }
        }
        self.watch();
        Ok(())
    }

    /// Tells when the cam begins to pull where a spring, gravity or a constant force holds the follower on it.
    pub(super) fn watch(&mut self) {
        let (m, x, q) = (self.parameters.m, self.now.u.array()[0], self.deformation()[0]);
        let Some(loaded) = &self.loaded else { return };
        let [load, roller] = &*loaded.loads;
        let held =
            load.constant_part(m) + roller.constant_part(loaded.m_roller) - x * (load.stiffness() + roller.stiffness());
        let force = if held == 0.0 { 0.0 } else { super::variables::contact_force(self) };
        let Some(loaded) = &mut self.loaded else { return };
        loaded.largest = loaded.largest.max(q.abs());
        let pulls = force * held > 0.0;
        if pulls && !loaded.pulls && !loaded.told {
            loaded.told = true;
            let kind = "the contact force changes its sign: a follower that nothing but its loads holds on the cam leaves it; \
                        BacklashDrive with s = inf takes that over";
            let (time, quantity, unit) = (self.now.time, "contact_force", "N");
            self.log.push(Event { time, kind, quantity, value: force, unit, solver: false });
        }
        loaded.pulls = pulls;
    }

    /// Called when the drive was read from bytes.
    pub(super) fn restore_loads(&mut self, made: &Self) -> bool {
        let (tolerance, is_input, mode) = (self.tolerance(), self.cam.is_input(), self.cam.mode.clone());
        let (loaded, made) = match (&mut self.loaded, &made.loaded) {
            (Some(loaded), Some(made)) => (loaded, made),
            (None, None) => return true,
            _ => return false,
        };
        loaded.loads = made.loads.clone();
        let Some(process) = &mut loaded.process else { return true };
        let Some(law) = &loaded.loads[0].process else { return false };
        if (*law != *process.law && !loaded.tuned) || !process.response.restored(&process.law, tolerance) {
            return false;
        }
        if process.response.is_on_table() {
            process.tabulate(&mode, made.process.as_ref());
            if !process.response.has_its_table() && !is_input {
                let _ = process.restart();
            }
        }
        true
    }

    /// Whether the motion that the loads make is one.
    pub(super) fn loads_are_finite(&self) -> bool {
        self.loaded.is_none() || all_finite(self.deformation())
    }
}

impl HasLoads for ElasticOutput {
    fn load(&self, which: usize) -> Option<&Load> {
        self.loaded.as_ref()?.loads.get(which)
    }
    fn load_mut(&mut self, which: usize) -> Option<&mut Load> {
        let loaded = self.loaded.as_mut()?;
        loaded.tuned = true;
        Arc::make_mut(&mut loaded.loads).get_mut(which)
    }
    fn signal(&self, which: usize) -> Option<&Signal> {
        let loaded = self.loaded.as_ref()?;
        [&loaded.push.signal, &loaded.roller].get(which).copied()
    }
    fn signal_mut(&mut self, which: usize) -> Option<&mut Signal> {
        let loaded = self.loaded.as_mut()?;
        Some(if which == 0 { &mut loaded.push.signal } else { &mut loaded.roller })
    }
}
