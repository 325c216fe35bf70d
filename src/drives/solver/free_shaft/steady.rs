//! The start on the periodic solution.
//!
//! Let M(w*) = τ on the falling characteristic. A motion that is faster than w* everywhere loses energy, hence every periodic
//! motion crosses w* or stays below it. A periodic motion that crosses w* keeps within ½ J_min w*² ≤ E ≤ ½ J_max w*², as long as
//! the torque exceeds the load between the slowest of these speeds and w*. If the characteristic falls at all these speeds, |s| <
//! s_K, there is one such periodic motion, it is stable, and it is the fastest. Otherwise there may be several. **Of the stable
//! periodic motions the fastest is taken**: a machine that slows down reaches this one. The map of the turn ([`super::turn_map`])
//! is then scanned for changes of the sign of E(2π) − E(0), so that two periodic motions closer together than the scan's mesh (half
//! a per cent of the speed) may be overlooked.
//!
//! Source: W. Walter, *Ordinary Differential Equations*, Springer 1998, § 9 (lower and upper solutions).

use super::lagging_turn::LaggingTurn;
use super::mesh::Mesh;
use super::turn_map::{PERIODIC_TOLERANCE, SCAN_TOLERANCE, TurnMap};
use crate::drives::limits::{no_periodic_motion, periodic_motion_that, search_too_much};
use crate::drives::shaft::free::motor::{Kloss, Motor};
use crate::drives::shaft::free::torques::Torques;
use crate::drives::shaft::free::{Shaft, State};
use crate::drives::{About, Event, Fault, Number};
use crate::numerics::double_double::Double;
use crate::numerics::work::Work;
use std::cell::Cell;

/// The number of speeds that the scan tries in the range of the periodic motions without load, and below it.
const SCAN: usize = 80;
const SCAN_BELOW: usize = 32;

/// A periodic motion.
pub struct PeriodicMotion {
    /// The state at the requested angle.
    pub state: State,
    /// T (s).
    pub period: f64,
    /// Whether there are other periodic motions.
    several: bool,
}

impl PeriodicMotion {
    /// The event for the log, at the `time` of the start (s).
    pub fn event(&self, time: f64) -> Event {
        let kind = if self.several {
            "several periodic motions exist; the fastest stable one is taken"
        } else {
            "periodic motion found"
        };
        Event { time, kind, quantity: "period", value: self.period, unit: "s", follower: 0, about: About::Solver }
    }
}

/// The periodic motion at the angle `phi` (rad) under the present load; `mesh` is the shaft's.
pub fn periodic_motion(shaft: &Shaft, mesh: &Mesh, phi: f64) -> Result<PeriodicMotion, Fault> {
    let work = Cell::new(Work::default());
    let outcome = search(shaft, mesh, phi, &work);
    if work.get().is_exhausted() {
        // A motion found with the work used up is no result.
        return Err(search_too_much(
            "choose a larger `motor.s_k`, a larger `J0` or smaller masses, a coarser solver.tolerance, or `given`",
        ));
    }
    outcome
}

fn search(shaft: &Shaft, mesh: &Mesh, phi: f64, work: &Cell<Work>) -> Result<PeriodicMotion, Fault> {
    let Shaft { inertia, motor, loads, .. } = shaft;
    let &Motor::Kloss(Kloss { breakdown_torque, breakdown_slip, synchronous_speed, .. }) = motor else {
        return Err(periodic_motion_that(
            "needs a motor with a characteristic: a torque that does not depend on the speed determines no periodic motion",
            "; use `given`",
        ));
    };
    if loads.have_inertia() {
        return Err(no_periodic_motion("the inertia of the loads is known at one angle only", "; use `given`"));
    }
    let tau = loads.torque_now();
    let torques = Torques::against(motor, tau, motor.sense());
    let none = || {
        let reason = format!("with `tau` = {} N.m there is no stable periodic motion", Number(tau));
        let torque = Number(breakdown_torque);
        let rest =
            format!("; the motor (breakdown torque {torque} N.m) stalls or runs away. Reduce the load or use `given`");
        no_periodic_motion(reason, &rest)
    };
    let (low, high) = inertia.range();
    let (bracket, motions) = match torques.only_motion(low, high) {
        Some(bracket) => (bracket, 1),
        None => {
            let speed = synchronous_speed.abs();
            // A stable periodic motion keeps the slip within ±s_K on average; a fifth more leaves room for its fluctuation.
            let top = high.sqrt() * speed * (1.0 + breakdown_slip.min(1.0)) * 1.2;
            let bottom = low.sqrt() * speed * (1.0 - breakdown_slip).max(0.1) * 0.8;
            let even = |i: usize| top + (bottom - top) * i as f64 / SCAN as f64;
            let below = |i: usize| bottom * 0.02_f64.powf((i + 1) as f64 / SCAN_BELOW as f64);
            let speeds = (0..=SCAN).map(even).chain((0..SCAN_BELOW).map(below));
            let scanning = TurnMap::new(mesh, tau, SCAN_TOLERANCE, Some(work))?;
            let (stable, motions) = scanning.scan(speeds.map(|v| 0.5 * v * v));
            (*stable.first().ok_or_else(none)?, motions)
        }
    };
    let map = TurnMap::new(mesh, tau, PERIODIC_TOLERANCE, Some(work))?;
    let (energy, mut period) = map.refine(bracket).ok_or_else(none)?;
    let mut state = shaft.state_at(phi, synchronous_speed, 0.0);
    let (on_mesh, _) = state.on_mesh(inertia);
    let mut energy = map.energy_at(energy, (state.interval, on_mesh.hi)).ok_or_else(none)?;
    if motor.lag().is_some() {
        let turn = LaggingTurn::new(inertia, motor, tau, &state, Some(work));
        let v = (2.0 * energy.hi).sqrt();
        let (motion, t) = turn.refine(v, breakdown_torque).ok_or_else(none)?;
        let (growth, _) = turn.growth_and_motion(motion).ok_or_else(none)?;
        if growth > 0.0 {
            let factor = growth.exp();
            let reason = format!("the periodic motion is unstable (a disturbance grows by {factor:.4} per turn)");
            return Err(no_periodic_motion(reason, "; change `motor.T_el` or use `given`"));
        }
        energy = Double::from(motion[0]) * Double::from(motion[0]) * Double::from(0.5);
        (state.torque, period) = (motion[1], t);
    }
    state.take_energy(energy, motor.sense());
    state.take_speed(shaft);
    Ok(PeriodicMotion { state, period, several: motions > 1 })
}
