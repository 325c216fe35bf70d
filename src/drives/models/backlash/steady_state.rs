//! The periodic motion at constant speed.

use super::{BacklashDrive, CamFlank, Parameters};
use crate::drives::follower::contact::{Beginning, Bodies, Mode, Phase, State};
use crate::drives::follower::elastic_output::Equation;
use crate::drives::follower::flank::FlankMotion;
use crate::drives::limits::{no_periodic_motion, search_too_much};
use crate::drives::shaft::cam_drive::DriveMode;
use crate::drives::shaft::cam_turn::turns;
use crate::drives::solver::contact::panel::Point;
use crate::drives::solver::contact::series::MOST_TERMS;
use crate::drives::solver::contact::{Run, Stretch};
use crate::drives::{EventLog, Fault, Rounded};
use crate::numerics::double_double::Double;
use crate::numerics::period_map::fixed_point;
use crate::numerics::work::Work;
use std::f64::consts::TAU;

/// The most turns until the motion repeats.
const MOST_TURNS: usize = 2000;

/// The state repeats when it changes by less than this part of its size from turn to turn; the rounding errors of a turn are below
/// a tenth of it.
const REPEATS: f64 = 1e-12;

/// A response to a harmonic that exceeds the response at rest by the inverse of this cannot be reached: rounding of the speed
/// decides it.
const RESONANT: f64 = 1e-6;

impl BacklashDrive {
    /// Starts on the periodic motion: without clearance the motion in permanent contact, else the motion that the drive settles to
    /// from there.
    pub(super) fn begin_steady(&mut self, time: f64) -> Result<(), Fault> {
        let DriveMode::Constant { w, .. } = self.cam.mode else {
            return Err(Fault::named(
                "start.mode",
                " = steady_state needs a drive at constant speed; with inputs choose at_rest or given",
            ));
        };
        if !turns(w) {
            self.begin(time, [0.0; 2]);
            return Ok(());
        }
        let mut work = Work::default();
        self.settle_on_orbit(time, TAU / w.abs(), &mut work).map_err(|fault| {
            let hint = "choose a softer spring, heavier masses or a smaller `e`, or start at_rest or given";
            if work.is_exhausted() { search_too_much(hint) } else { fault }
        })
    }

    fn settle_on_orbit(&mut self, time: f64, period: f64, work: &mut Work) -> Result<(), Fault> {
        let contact = self.contact_orbit(time, period, work);
        if self.bodies.s == 0.0 {
            self.begin(time, contact?);
            return Ok(());
        }
        // With clearance the periodic motion does not depend on this first guess.
        self.begin(time, contact.unwrap_or_default());
        let (mode, state) = self.periodic(time, period, work)?;
        self.lay(time, Phase { mode, state, zeros: 0 });
        Ok(())
    }

    /// q, q̇ of the periodic response in permanent contact: for a Fourier series the sum of the responses to its harmonics, else x
    /// = M x + r, with M the free motion over a period and r the response from rest.
    fn contact_orbit(&self, time: f64, period: f64, work: &mut Work) -> Result<[f64; 2], Fault> {
        if let Some(series) = self.cam.law.series() {
            let Parameters { m2, c, b, .. } = self.parameters;
            let (phi, w) = (self.motion.at(time).reduced, self.motion.coefficients[1]);
            // m2 is coupled to m1, which follows the flank; near a resonance ω² + ν² is twice ω².
            let orbit = Equation::new([m2, c, b]).periodic(series, w, phi, 0.5 * RESONANT);
            return orbit.map_err(|_| self.resonance());
        }
        let locked = Bodies { s: 0.0, ..self.bodies };
        let flank = CamFlank { law: &self.cam.law, motion: &self.motion, bounds: self.bounds };
        let place = Double::from(time);
        let phase = Phase { mode: Mode::Contact(super::Flank::A), state: State::default(), zeros: 0 };
        let from = Beginning { start: place, segment: flank.segment(place), phase, longest: f64::INFINITY };
        let mut run = Run::new(&locked, &flank, from, MOST_TERMS);
        let mut log = EventLog::counting();
        let mut stretch = Stretch { end: time + period, horizon: f64::INFINITY, log: &mut log, work };
        run.advance(&locked, &flank, &mut stretch)?;
        let response = run.panel.at(&locked, run.theta(time + period)).state.q;
        let m = locked.bound.free(Double::from(time + period) + Double::from(-time));
        // det(I − M) = |1 − e^(λT)|² vanishes only at a resonance without damping.
        let determinant = (1.0 - m[0][0]) * (1.0 - m[1][1]) - m[0][1] * m[1][0];
        let regular = determinant.abs() >= RESONANT * RESONANT;
        fixed_point(&m, [0.0; 2], response).filter(|_| regular).ok_or_else(|| self.resonance())
    }

    fn resonance(&self) -> Fault {
        let reason = format!(
            "there is no periodic motion because a harmonic of the motion law has the natural frequency ({} Hz) and `b` = {} \
             N.s/m does not damp it",
            Rounded(self.bodies.bound.stiffness().sqrt() / TAU),
            self.parameters.b
        );
        no_periodic_motion(reason, "; change the speed, add damping or choose at_rest")
    }

    /// The mode and state that repeat after one period.
    fn periodic(&mut self, time: f64, period: f64, work: &mut Work) -> Result<(Mode, State), Fault> {
        let mut last = (self.now.mode, self.now.point.state);
        let Some(mut run) = self.run.take() else { return Err(Fault::new("the drive has not been started")) };
        for turns in 1..=MOST_TURNS {
            let end = time + turns as f64 * period;
            let flank = CamFlank { law: &self.cam.law, motion: &self.motion, bounds: self.bounds };
            let mut stretch = Stretch { end, horizon: f64::INFINITY, log: &mut self.log, work };
            run.advance(&self.bodies, &flank, &mut stretch)
                .map_err(|fault| no_periodic_motion(fault.to_string(), ""))?;
            let Point { state, .. } = run.panel.at(&self.bodies, run.theta(end));
            let next = (run.panel.mode(), state);
            if next.0 == last.0 && self.distance(&next.1, &last.1) <= REPEATS {
                self.log.clear();
                return Ok(next);
            }
            last = next;
        }
        Err(no_periodic_motion(
            format!("the motion does not repeat from turn to turn within {MOST_TURNS} turns"),
            "; with clearance the periodic motion may be unstable or longer than a turn; start at_rest and let the drive run, or \
             add damping",
        ))
    }

    /// The largest difference of two states, relative to the sizes of q and z.
    fn distance(&self, one: &State, other: &State) -> f64 {
        let acceleration = self.bounds[2] * self.motion.coefficients[1].powi(2);
        let omega = self.bodies.bound.stiffness().sqrt();
        let q = one.q[0].abs().max(acceleration / (omega * omega));
        let z = (one.home + one.zeta[0]) - (other.home + other.zeta[0]);
        let clearance = self.parameters.s;
        let sizes = [q, omega * q, q + clearance, omega * (q + clearance)];
        let changes = [one.q[0] - other.q[0], one.q[1] - other.q[1], z, one.zeta[1] - other.zeta[1]];
        let relative = |(change, size): (f64, f64)| if change == 0.0 { 0.0 } else { (change / size).abs() };
        changes.into_iter().zip(sizes).map(relative).fold(0.0, f64::max)
    }
}
