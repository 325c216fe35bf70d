//! The event-driven model as the study uses it: the drive with backlash of `drives`, started at the beginning of a passage.

use super::MOST_STEPS;
use camdrive::drives::backlash::{BacklashDrive, Scene};
use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use camdrive::drives::{AnyDrive, Drive, Event, Fault};
use std::f64::consts::TAU;

/// The outputs that the study reads.
#[derive(Clone, Copy, Debug)]
struct References {
    force: usize,
    q: usize,
    rate: usize,
    place_rate: usize,
    contact: usize,
    impacts: usize,
    loss: usize,
    clearance: usize,
    phi_start: usize,
    start: [usize; 3],
    steps: usize,
}

/// A drive with backlash at constant speed.
pub struct Machine {
    drive: AnyDrive,
    at: References,
    /// Angular velocity (rad/s), not 0.
    pub w: f64,
    clearance: f64,
    /// φ at t = 0 (rad).
    phi_start: f64,
    time: f64,
    /// Internal steps of all runs so far, and how many there may be.
    work: f64,
    limit: f64,
}

/// The motion at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// Time since the start (s).
    pub time: f64,
    /// F_K (N) and its rate (N/s).
    pub force: [f64; 2],
    /// q (m) and q̇ (m/s).
    pub q: [f64; 2],
    /// ẋ2 (m/s).
    pub far_speed: f64,
    /// 1 on flank A, 0 in flight, −1 on flank B.
    pub contact: i32,
    /// Impacts since the start.
    pub impacts: f64,
    /// Energy lost in impacts since the start (J).
    pub loss: f64,
}

impl Machine {
    /// The machine of this scene at the constant speed `w` (rad/s).
    pub fn new(scene: &Scene, w: f64) -> Result<Self, Fault> {
        let start = Start { mode: StartMode::Given, q: 0.0, q_dot: 0.0 };
        let scene = Scene { drive: DriveMode::Constant { w, phi_start: 0.0 }, start, ..scene.clone() };
        let clearance = scene.parameters.s;
        let drive = AnyDrive::from(BacklashDrive::new(scene)?);
        let find = |name: &str| {
            let list = drive.descriptions();
            list.iter().position(|d| d.name == name).ok_or_else(|| Fault::new(format!("the drive has no `{name}`")))
        };
        let at = References {
            force: find("force")?,
            q: find("q")?,
            rate: find("der(q)")?,
            place_rate: find("der(y)")?,
            contact: find("contact")?,
            impacts: find("impacts")?,
            loss: find("energy_loss")?,
            clearance: find("s")?,
            phi_start: find("drive.phi_start")?,
            start: [find("start.mode")?, find("start.q")?, find("start.q_dot")?],
            steps: find("solver.steps")?,
        };
        Ok(Machine { drive, at, w, clearance, phi_start: 0.0, time: 0.0, work: 0.0, limit: 0.0 })
    }

    /// Starts at the angle `phi` (rad) with q (m), q̇ (m/s) on the flank that presses; on the periodic motion without a state.
    /// `locked`: without clearance.
    pub fn begin(&mut self, phi: f64, state: Option<[f64; 2]>, locked: bool) -> Result<Moment, Fault> {
        self.drive.reset();
        self.drive.set_up(0.0, None);
        let mode = if state.is_some() { StartMode::Given } else { StartMode::SteadyState };
        let [q, q_dot] = state.unwrap_or_default();
        self.drive.set(self.at.clearance, if locked { 0.0 } else { self.clearance })?;
        self.drive.set(self.at.phi_start, phi)?;
        for (reference, value) in self.at.start.into_iter().zip([mode.number(), q, q_dot]) {
            self.drive.set(reference, value)?;
        }
        self.drive.start()?;
        (self.phi_start, self.time) = (phi, 0.0);
        self.drive.events().clear();
        self.moment()
    }

    /// Allows this many internal steps from now on.
    pub fn allow(&mut self, steps: f64) {
        self.limit = self.work + steps;
    }

    /// True if all allowed steps are used up.
    pub fn is_exhausted(&self) -> bool {
        self.work > self.limit
    }

    /// Goes on to `time` (s) since the start and returns the events on the way.
    pub fn go(&mut self, time: f64) -> Result<Vec<Event>, Fault> {
        if time > self.time {
            if self.is_exhausted() {
                return Err(Fault::new("m1 strikes or vibrates too often to be followed in reasonable time"));
            }
            let before = self.drive.get(self.at.steps)?;
            let advanced = self.drive.advance(self.time, time - self.time);
            // A failed step has used up the work of a call.
            self.work += if advanced.is_err() { MOST_STEPS } else { self.drive.get(self.at.steps)? - before };
            advanced?;
            self.time = time;
        }
        let events = self.drive.events().iter().copied().collect();
        self.drive.events().clear();
        Ok(events)
    }

    /// The motion now.
    pub fn moment(&mut self) -> Result<Moment, Fault> {
        let at = self.at;
        let mut get = |reference: usize| self.drive.get(reference);
        let (force, q, rate, far_speed) = (get(at.force)?, get(at.q)?, get(at.rate)?, get(at.place_rate)?);
        let (contact, impacts, loss) = (get(at.contact)? as i32, get(at.impacts)?, get(at.loss)?);
        let force = [force, self.drive.output_derivative(at.force, 1)?];
        Ok(Moment { time: self.time, force, q: [q, rate], far_speed, contact, impacts, loss })
    }

    /// φ `time` after the start, in [0, 2π) (rad).
    pub fn angle(&self, time: f64) -> f64 {
        (self.phi_start + self.w * time).rem_euclid(TAU)
    }

    /// The duration of a turn (s).
    pub fn turn(&self) -> f64 {
        TAU / self.w.abs()
    }
}
