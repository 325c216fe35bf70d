//! The drive under loads. The equation is linear: the motion that the cam causes, with the spring and the damper of the load, and
//! the motions that the process force, constant loads and input cause add up.

use super::ElasticOutput;
use crate::drives::Fault;
use crate::drives::follower::elastic_output::Equation;
use crate::drives::follower::load::Load;
use crate::drives::shaft::cam_drive::{AngleMotion, DriveMode, ShaftState, StartMode};
use crate::drives::shaft::free::signal::Signal;
use crate::drives::shaft::instant::Instant;
use crate::drives::shaft::loads::{HasLoads, log_pull};
use crate::drives::solver::response::Response;
use crate::drives::solver::response::push::Push;
use crate::motion::MotionLaw;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The loads and their effects on q.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct LoadEffects {
    /// The loads on the mass, and on the mass on the cam's side.
    pub loads: Arc<[Load; 2]>,
    /// m_x (kg).
    pub m_roller: f64,
    /// Whether outputs show the inertia of m_x on the shaft.
    pub coupling: bool,
    /// The motion caused by a process force on the mass.
    pub process: Option<Process>,
    /// The motion caused by constant loads and the input.
    pub push: Push,
    /// Whether a parameter of the loads has changed since the last step.
    tuned: bool,
    /// The largest |q| at a communication point (m).
    pub largest: f64,
    /// Whether the log has reported that the cam pulls.
    logged: bool,
}

/// The motion that a process force causes: P(φ) replaces the cam's motion.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Process {
    law: Arc<MotionLaw>,
    response: Response,
    /// P and its derivatives replace those of U; see [`ElasticOutput`].
    pub now: Instant,
    end: Instant,
}

impl LoadEffects {
    pub(super) fn new(loads: [Load; 2], m_roller: f64, coupling: bool) -> Result<Option<Box<Self>>, Fault> {
        if loads.iter().all(Load::is_none) && m_roller == 0.0 {
            return Ok(None);
        }
        let loaded = LoadEffects { loads: Arc::new(loads), m_roller, coupling, ..LoadEffects::default() };
        loaded.validate()?;
        Ok(Some(Box::new(loaded)))
    }

    fn validate(&self) -> Result<(), Fault> {
        let [load, roller] = &*self.loads;
        if roller.process.is_some() || roller.input {
            return Err(Fault::new("a process force or an input acts on the mass only").of("load.roller"));
        }
        load.validate("load")
    }

    /// The motion caused by the process force on the mass, before its start.
    pub(super) fn make_process(&mut self, equation: &Equation, tolerance: f64, mode: &DriveMode) {
        let known = self.process.take().and_then(|mut process| process.response.table.take());
        self.process = self.loads[0].process.as_ref().map(|law| {
            let (mut response, law) = (Response::new(equation.of_force(), law, tolerance), Arc::new(law.clone()));
            response.tabulate(known, &law, mode);
            Process { law, response, now: Instant::default(), end: Instant::default() }
        });
    }

    /// q, q̇ including the effects of the loads.
    #[inline(never)]
    fn added_to(&self, q: [f64; 2]) -> [f64; 2] {
        let process = self.process.as_ref().map_or([0.0; 2], |process| process.now.q.array());
        [0, 1].map(|i| q[i] + self.push.now[i] + process[i])
    }

    /// Steps, evaluations, and the estimated error of q relative to its largest size; the arguments are the cam motion's steps,
    /// evaluations and error of q (m).
    pub(super) fn tally(&self, [mut steps, mut evaluations, mut error]: [f64; 3]) -> [f64; 3] {
        if let Some(Process { response, now, .. }) = &self.process {
            (steps, evaluations) = (steps + response.steps, evaluations + response.evaluations as f64);
            error += response.error(now.time) * response.largest();
        }
        error += self.push.error();
        [steps, evaluations, if self.largest > 0.0 { (error / self.largest).min(1.0) } else { 0.0 }]
    }

    /// Conditions of the text.
    pub(super) fn conditions(loaded: Option<&Self>) -> Vec<(&'static str, bool)> {
        let none = [Load::default(), Load::default()];
        let [mass, roller] = loaded.map_or(&none, |loaded| &*loaded.loads);
        let held = |load: &Load| load.spring.is_some() || load.gravity.is_some() || load.constant.is_some();
        let mut all = vec![
            ("load", loaded.is_some()),
            ("coupling", loaded.is_some_and(|loaded| loaded.coupling)),
            ("m_roller", loaded.is_some_and(|loaded| loaded.m_roller > 0.0)),
            ("loads", !mass.is_none() || !roller.is_none()),
            ("held", held(mass) || held(roller)),
            ("mass load", !mass.is_none()),
            ("roller load", !roller.is_none()),
            ("roller gravity", roller.gravity.is_some()),
            ("roller constant", roller.constant.is_some()),
            ("roller spring", roller.spring.is_some()),
            ("roller damping", roller.damping.is_some()),
        ];
        all.extend(mass.conditions());
        all
    }
}

impl ElasticOutput {
    /// Starts the motions of process, constant loads and input.
    pub(super) fn start_loads(&mut self, time: f64) -> Result<(), Fault> {
        let (equation, tolerance, motion) = (*self.response.equation(), self.tolerance(), self.response.motion);
        let Some(loaded) = &mut self.loaded else { return Ok(()) };
        loaded.validate()?;
        (loaded.tuned, loaded.largest, loaded.logged) = (false, 0.0, false);
        let settled = matches!(self.start.mode, StartMode::SteadyState | StartMode::Equilibrium);
        let force = loaded.loads[0].constant_part(self.parameters.m) + loaded.push.signal.set_value();
        let deflection = force / self.parameters.m / equation.oscillator.stiffness();
        loaded.push.begin([if settled { deflection } else { 0.0 }, 0.0]);
        loaded.make_process(&equation, tolerance, &self.cam.mode);
        if let Some(Process { law, response, now, end }) = &mut loaded.process {
            response.motion = motion;
            let q = match self.start.mode {
                StartMode::SteadyState => response.periodic(law, &motion, time)?,
                StartMode::Equilibrium => response.at_rest(law, &motion, time),
                _ => [0.0; 2],
            };
            *now = Instant::on(&motion, law, time, q);
            *end = *now;
            if !self.cam.is_input() {
                response.go_on(law, now)?;
            }
        }
        self.watch();
        Ok(())
    }

    /// The equation of the motion that the cam causes.
    pub(super) fn equation(&self) -> Equation {
        let equation = self.parameters.equation();
        self.loaded.as_ref().map_or(equation, |loaded| equation.under(&loaded.loads[0]))
    }

    /// q and q̇.
    #[inline(always)]
    pub(super) fn deformation(&self) -> [f64; 2] {
        let q = self.now.q.array();
        if let Some(loaded) = &self.loaded { loaded.added_to(q) } else { q }
    }

    /// Whether the parameters of the loads have changed since the last step; the effects on q then start anew.
    #[inline(never)]
    pub(super) fn retune_loads(&mut self, tuned: bool) -> Result<bool, Fault> {
        let (equation, tolerance) = (self.equation(), self.tolerance());
        let Some(loaded) = &mut self.loaded else { return Ok(tuned) };
        if !(tuned || loaded.tuned) {
            return Ok(false);
        }
        loaded.validate()?;
        loaded.tuned = false;
        loaded.push.restart();
        let Some(Process { law, response, now, end }) = &mut loaded.process else { return Ok(true) };
        if let Some(changed) = loaded.loads[0].process.as_ref().filter(|changed| **changed != **law) {
            let motion = response.motion;
            (*law, *response) = (Arc::new(changed.clone()), Response::new(equation, changed, tolerance));
            response.motion = motion;
            if self.cam.is_input() {
                *end = Instant::new(end.time, end.shaft, &ShaftState::at_angle(end.shaft).on(law), end.q);
            } else {
                *now = Instant::on(&motion, law, now.time, now.q.array());
            }
        }
        response.set_equation(equation.of_force());
        if !self.cam.is_input() {
            response.go_on(law, now)?;
        }
        Ok(true)
    }

    /// Takes up the inputs for the process at `time` (s).
    #[inline(never)]
    pub(super) fn take_up_process(&mut self, motion: &AngleMotion, time: f64, goes_on: bool) {
        let Some(loaded) = &mut self.loaded else { return };
        let Some(Process { law, response, now, end }) = &mut loaded.process else { return };
        let [phi, w, a, ..] = motion.coefficients;
        let shaft = [phi, w, a];
        *now = Instant { time, shaft, ..*end };
        if !goes_on {
            *now = Instant::new(time, shaft, &ShaftState::at_angle(shaft).on(law), end.q);
        }
        response.motion = *motion;
    }

    /// Brings the effects of the loads on q from one time to another (s); `goes_on` if the inputs do.
    #[inline(never)]
    pub(super) fn advance_loads(&mut self, [time, end]: [f64; 2], goes_on: bool) -> Result<(), Fault> {
        let (m, is_input) = (self.parameters.m, self.cam.is_input());
        let Some(loaded) = &mut self.loaded else { return Ok(()) };
        let still = loaded.loads[0].constant_part(m) / m;
        loaded.push.advance(&self.response.equation().oscillator, m, still, [time, end]);
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

    /// Logs when the cam begins to pull a follower that a spring, gravity or a constant force holds on it.
    pub(super) fn watch(&mut self) {
        let (m, x, q) = (self.parameters.m, self.now.u.array()[0], self.deformation()[0]);
        let Some(loaded) = &self.loaded else { return };
        let [load, roller] = &*loaded.loads;
        let held = load.hold(m, x) + roller.hold(loaded.m_roller, x);
        let force = if held == 0.0 { 0.0 } else { self.contact_force() };
        let Some(loaded) = &mut self.loaded else { return };
        loaded.largest = loaded.largest.max(q.abs());
        log_pull(&mut loaded.logged, [held, force], self.now.time, 0, &mut self.log);
    }

    /// Rebuilds, after reading from bytes, the parts that the serialisation leaves out.
    pub(super) fn restore_loads(&mut self, made: &Self) -> bool {
        let tolerance = self.tolerance();
        let (loaded, made) = match (&mut self.loaded, &made.loaded) {
            (Some(loaded), Some(made)) => (loaded, made),
            (None, None) => return true,
            _ => return false,
        };
        (loaded.loads, loaded.coupling) = (made.loads.clone(), made.coupling);
        let Some(Process { law, response, now, .. }) = &mut loaded.process else { return true };
        let made = made.process.as_ref().map(|process| &process.response);
        let same = loaded.tuned || loaded.loads[0].process.as_ref() == Some(&**law);
        same && response.restored(made, (law, &self.cam.mode), tolerance, now)
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
        Some(&self.loaded.as_ref().filter(|_| which == 0)?.push.signal)
    }
    fn signal_mut(&mut self, which: usize) -> Option<&mut Signal> {
        Some(&mut self.loaded.as_mut().filter(|_| which == 0)?.push.signal)
    }
}
