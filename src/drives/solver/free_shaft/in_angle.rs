//! The motion in the angle, from step to step, while torques do not change and the shaft turns fast enough.
//!
//! The steps ([`super::angle_step`]) do not end at communication points. Those read the polynomial of the step that holds them, so
//! the internal steps and every digit of the result are independent of the communication step. On the periodic motion against the
//! load of the start a table yields them ([`super::cycle`]).

use super::angle_step::{AngleStep, Errors, Position};
use super::angle_steps::AngleSteps;
use super::cycle::Cycle;
use super::in_time::{FASTEST, fault};
use super::mesh::{Cell, Mesh};
use super::turn_map::cost_of_step;
use crate::drives::Fault;
use crate::drives::settings::{Method, Solver};
use crate::drives::shaft::free::torques::Torques;
use crate::drives::shaft::free::{Shaft, State};
use crate::numerics::angle::WHOLE_TURN;
use crate::numerics::collocation::Failure;
use crate::numerics::double_double::Double;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Steps in the angle are taken while E exceeds this part of the work of the torques over a cell. 1/φ̇ has a branch point at E = 0;
/// the polynomial then needs steps of about a fourth of the angle to that point.
const SLOW: f64 = 1.0 / 16.0;

/// The motion in the angle.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct InAngle {
    /// The turn's cells with their J; follows from the parameters.
    #[serde(skip)]
    pub mesh: Mesh,
    /// The periodic motion against the load of the start, if any; follows from the parameters and that load.
    #[serde(skip)]
    pub cycle: Option<Arc<Cycle>>,
    /// τ at the start of the simulation (N·m).
    load_at_start: f64,
    /// The step that holds the communication point; None while the motion is integrated in time.
    pub step: Option<AngleStep>,
    /// The position x ∈ [−1, 1] of the communication point in the step.
    abscissa: f64,
    /// Known errors at the start of the step.
    errors: Errors,
    /// The torques of the step, and the admissible length of the next one.
    steps: AngleSteps,
}

impl InAngle {
    /// Starts a simulation under this load (N·m).
    pub fn start(&mut self, load_at_start: f64) {
        let InAngle { mesh, cycle, .. } = std::mem::take(self);
        let steps = AngleSteps::new(Torques::default(), 0.0);
        *self = InAngle { mesh, cycle, load_at_start, steps, ..InAngle::default() };
    }

    /// Makes the mesh of the shaft if it has changed, and tabulates the periodic motion if the steps follow the tolerance.
    pub fn prepare(&mut self, shaft: &Shaft, solver: &Solver) -> Result<(), Fault> {
        let (tolerance, tau) = (solver.effective_tolerance(), self.load_at_start);
        let same = self.mesh.is_for(&shaft.profile, &shaft.motor, tolerance);
        if !same {
            self.mesh = Mesh::new(shaft.profile.clone(), shaft.motor, tolerance)?;
        }
        if solver.settings.method == Method::FixedCost {
            self.cycle = None;
        } else if !(same && self.cycle.as_ref().is_some_and(|made| made.is_against(tau))) {
            self.cycle = Cycle::new(&self.mesh, tau).map(Arc::new);
        }
        Ok(())
    }

    /// Begins at the time `now` with these deviations of φ, u and M_an if E is large against the work of the torques over a cell;
    /// returns whether a step meets the tolerance.
    pub fn begin(
        &mut self,
        shaft: &Shaft,
        state: &State,
        solver: &mut Solver,
        now: Double,
        deviations: [f64; 3],
    ) -> bool {
        let [phi, of_u, _] = deviations;
        let State { interval, u, .. } = *state;
        if !(0.5 * u.hi * u.hi > SLOW * shaft.net_torque(state, state.w).abs() * self.mesh.widest) {
            return false;
        }
        let (angle, turns) = state.on_mesh(&shaft.inertia);
        let forward = u.hi > 0.0;
        self.steps.torques = Torques::against(&shaft.motor, shaft.constant_torque(), u.hi.signum());
        self.steps.tolerance = self.mesh.tolerance;
        let cell = self.mesh.find(interval, angle.hi, forward);
        let mut position = Position { time: now, angle, turns, cell, energy: u * u * Double::from(0.5) };
        // The integration in time may stop a little beyond a border.
        let Cell { low, high, .. } = self.mesh.cells()[cell];
        if if forward { angle.hi >= high } else { angle.hi <= low } {
            self.mesh.next(&mut position, forward);
            position.angle = angle - Double::from(position.turns - turns) * WHOLE_TURN;
        }
        self.errors = Errors { energy: 2.0 * of_u / u.hi.abs(), time: phi / state.w.abs() };
        self.pass(position, None, solver);
        self.count(state, solver);
        self.step.is_some()
    }

    /// From the end of a step to the next one or, if the machine has become slow, to the integration in time. Returns the cost
    /// (nominal µs).
    pub fn extend(&mut self, shaft: &Shaft, state: &mut State, solver: &mut Solver) -> Result<f64, Fault> {
        let Some(step) = &mut self.step else { return Ok(0.0) };
        if step.end_speed > FASTEST {
            return Err(fault(Failure::Unbounded { time: 0.0 }, state, step.end.hi));
        }
        let spent = solver.evaluations;
        let AngleSteps { torques, next_length, .. } = &mut self.steps;
        let position = self.mesh.after(step, torques.sense);
        self.errors = step.pass_on(self.errors);
        state.travelled += step.length;
        let slow = step.energy.hi <= SLOW * step.end_net.abs() * self.mesh.widest;
        if !slow && self.cycle.as_ref().is_some_and(|cycle| cycle.lay(torques, position, step)) {
            // As after a solved step.
            *next_length = if step.to_edge { f64::INFINITY } else { step.length };
        } else {
            let before = self.step.take();
            if !slow {
                self.pass(position, before.as_ref(), solver);
            }
            if self.step.is_none() {
                (state.angle, state.turns) = (position.angle, position.turns);
                state.interval = self.mesh.cells()[position.cell].interval;
                state.take_energy(position.energy, self.steps.torques.sense);
                state.take_speed(shaft);
            }
        }
        self.count(state, solver);
        Ok(cost_of_step(solver.evaluations - spent))
    }

    /// Counts the step that begins, if one does.
    fn count(&self, state: &State, solver: &mut Solver) {
        let Some(step) = &self.step else { return };
        let [speed, angle] = step.error_within(self.errors);
        let estimate = speed.max(angle / state.travelled.max(1.0));
        solver.error_estimate = solver.error_estimate.max(estimate);
        solver.steps += 1.0;
    }

    /// Takes the values `elapsed` (s) after the start of the step, which holds them.
    pub fn read(&mut self, shaft: &Shaft, state: &mut State, elapsed: f64) {
        let Some(step) = &self.step else { return };
        let sense = self.steps.torques.sense;
        self.abscissa = step.place_at(elapsed);
        state.angle = step.from.angle + Double::from(sense * step.advance(self.abscissa));
        state.turns = step.from.turns;
        state.interval = self.mesh.cells()[step.from.cell].interval;
        // J is the exact function, so that ½ J φ̇² is E to the last digit.
        let inertia = shaft.profile.value(state.interval, state.angle.hi);
        let energy = step.from.energy.hi + (step.from.energy.lo + step.work_to(self.abscissa));
        state.w = sense * (2.0 * energy / inertia).sqrt();
    }

    /// Ends the step where it was read last; the machine goes on from there. Returns whether there was one.
    pub fn leave(&mut self, state: &mut State) -> bool {
        let Some(step) = self.step.take() else { return false };
        self.errors = step.errors_at(self.errors, self.abscissa);
        state.travelled += step.advance(self.abscissa);
        state.take_energy(step.energy_at(self.abscissa), self.steps.torques.sense);
        true
    }

    /// The deviations of φ and u after the last step.
    pub fn deviations(&self, state: &State) -> [f64; 2] {
        [state.w.abs() * self.errors.time, 0.5 * state.u.hi.abs() * self.errors.energy]
    }

    /// The step from `position` on, at most to the end of the cell; None if no step meets the tolerance.
    fn pass(&mut self, position: Position, before: Option<&AngleStep>, solver: &mut Solver) {
        self.step = self.steps.pass(&self.mesh, position, before, f64::INFINITY);
        solver.evaluations += self.steps.evaluations;
    }
}
