//! From one communication point to the next: steps in the angle while the shaft turns, steps in time while it does not.
//!
//! While torques stay as they are, steps in the angle ([`super::angle_step`]) do not end at communication points: those
//! read the polynomial of the step that holds them, so that the internal steps and every digit of the answer are the
//! same whatever the communication step. A torque that changes with time, a motor with a lag, standstill and reversal
//! are integrated in time ([`super::solver`]), where steps end at communication points.

use super::angle_step::{AngleStep, Errors, Position};
use super::mesh::{Cell, Mesh};
use super::solver::FASTEST;
use super::step_control::AngleSteps;
use super::torques::Torques;
use super::turn_map::cost_of_step;
use super::{Motor, RigidMachine, State};
use crate::drives::limits::step_too_much;
use crate::drives::{Fault, Rounded};
use crate::numerics::angle::WHOLE_TURN;
use crate::numerics::collocation::Failure;
use crate::numerics::double_double::{Double, two_sum};
use crate::numerics::work::Work;

/// Steps in the angle are taken while E exceeds this part of the work of the torques over a cell. 1/φ̇ has a branch
/// point where E vanishes; the steps that the polynomial then needs are about a fourth of the angle to that point.
const SLOW: f64 = 1.0 / 16.0;

impl RigidMachine {
    /// Integrates over the communication step of length `step` from `time` (s).
    pub(super) fn advance_by_angle(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        let target = two_sum(time, step);
        self.prepare_mesh_once()?;
        let mut work = Work::default();
        let steady = self.motor.lag().is_none() && self.torques_are_constant();
        if !steady || self.constant_torque() != self.torques.against_what() {
            self.leave();
        }
        let mut now = Double::from(time);
        loop {
            let before = self.solver.evaluations;
            let Some(step) = &self.step else {
                if steady && self.turns_fast() {
                    self.enter(now);
                    if self.step.is_some() {
                        continue;
                    }
                }
                now = self.run_in_time(time, [now, target], steady, &mut work)?;
                if (target - now).hi <= 0.0 {
                    return Ok(());
                }
                continue;
            };
            let [elapsed, left] = step.around(target);
            if left >= 0.0 {
                self.read(elapsed);
                return Ok(());
            }
            if step.end_speed > FASTEST {
                let after = (step.end - Double::from(time)).hi;
                return Err(self.fault(Failure::Unbounded { time: after }, time));
            }
            now = step.end;
            self.go_on();
            let cost = cost_of_step(self.solver.evaluations - before);
            work.draw(cost).map_err(|_| self.too_long([time, target.hi], now.hi))?;
        }
    }

    /// Integrates over the communication step of length `step` from `time` (s) in steps of fixed cost.
    pub(super) fn advance_on_grid(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        let target = two_sum(time, step);
        self.prepare_mesh_once()?;
        let mut work = Work::default();
        // Steps that nobody can wait for are refused before the first.
        if !work.allows(self.cost_in_time() * (step / self.in_time.grid.size)) {
            return Err(self.too_long([time, target.hi], time));
        }
        let torques = [self.load.set_value(), self.driving.set_value()];
        if !self.torques_are_constant() || torques != self.in_time.grid.torques {
            self.leave_span()?;
            self.in_time.grid.torques = torques;
        }
        self.run_in_time(time, [Double::from(time), target], false, &mut work).map(|_| ())
    }

    /// Whether no input depends on time in this step.
    pub(super) fn torques_are_constant(&self) -> bool {
        self.load.is_constant() && self.driving.is_constant()
    }

    /// The fault of a step that takes more than the work of a call; it has come to the time `reached` (s).
    pub(super) fn too_long(&self, way: [f64; 2], reached: f64) -> Fault {
        // While there is an angle step, the speed of the state is that of the last communication point.
        let speed = self.step.as_ref().map_or(self.state.w, |step| step.end_speed);
        let hint =
            "relax solver.tolerance, lengthen solver.step_size of equal steps, or lower the speed or the range of J";
        step_too_much(way, reached, &format!("the shaft turns at {} rad/s", Rounded(speed)), hint)
    }

    /// Makes the mesh where there is none for these parameters.
    pub(super) fn prepare_mesh(&mut self) -> Result<(), Fault> {
        let tolerance = self.solver.effective_tolerance();
        if !self.mesh.is_for(&self.inertia, &self.motor, tolerance) {
            self.mesh = if self.mesh.is_of(&self.inertia) {
                self.mesh.with_tolerance(&self.inertia, &self.motor, tolerance)?
            } else {
                Mesh::new(&self.inertia, &self.motor, tolerance)?
            };
            self.cycle = None;
        }
        self.prepare_cycle();
        Ok(())
    }

    /// A machine from serialised bytes brings no mesh; the parameters yield the same one again.
    pub(super) fn prepare_mesh_once(&mut self) -> Result<(), Fault> {
        if self.mesh.cells().is_empty() { self.prepare_mesh() } else { Ok(()) }
    }

    /// τ − M_an as far as it does not depend on the speed (N·m).
    fn constant_torque(&self) -> f64 {
        self.load.set_value() - if matches!(self.motor, Motor::Input) { self.driving.set_value() } else { 0.0 }
    }

    /// Whether E, where the machine stands, is large against the work of the torques over a cell.
    pub(super) fn turns_fast(&self) -> bool {
        let energy = 0.5 * self.state.u.hi * self.state.u.hi;
        energy > SLOW * self.net_torque(self.state.w).abs() * self.mesh.widest
    }

    /// φ and the whole turns beside it as the mesh has them, whose turn begins at 0 where there are no borders.
    pub(super) fn angle_on_mesh(&self) -> (Double, f64) {
        let State { angle, turns, .. } = self.state;
        let before = self.inertia.borders().is_empty() && angle.hi < 0.0;
        if before { (angle + WHOLE_TURN, turns - 1.0) } else { (angle, turns) }
    }

    /// Begins with steps in the angle at the time `now`.
    fn enter(&mut self, now: Double) {
        let (State { interval, u, .. }, (angle, turns)) = (self.state, self.angle_on_mesh());
        self.torques = Torques::against(&self.motor, self.constant_torque(), u.hi.signum());
        let forward = u.hi > 0.0;
        let cell = self.mesh.find(interval, angle.hi, forward);
        let mut position = Position { time: now, angle, turns, cell, energy: u * u * Double::from(0.5) };
        // The integration in time may stop a little beyond a border.
        let Cell { low, high, .. } = self.mesh.cells()[cell];
        if if forward { angle.hi >= high } else { angle.hi <= low } {
            self.mesh.next(&mut position, forward);
            position.angle = angle - Double::from(position.turns - turns) * WHOLE_TURN;
        }
        let [phi, of_u, _] = self.in_time.integrator.deviations();
        self.errors = Errors { energy: 2.0 * of_u / u.hi.abs(), time: phi / self.state.w.abs() };
        self.step = self.pass(position, None);
        self.count();
    }

    /// From the end of a step to the next one, or, where the machine has become slow, to the integration in time.
    fn go_on(&mut self) {
        let Some(step) = &mut self.step else { return };
        let position = self.mesh.after(step, self.torques.sense);
        self.errors = step.pass_on(self.errors);
        self.travelled += step.length;
        let slow = step.energy.hi <= SLOW * step.end_net.abs() * self.mesh.widest;
        if !slow && self.cycle.as_ref().is_some_and(|cycle| cycle.lay(&self.torques, position, step)) {
            // As after a step that was solved.
            self.next_length = if step.to_edge { f64::INFINITY } else { step.length };
            self.count();
            return;
        }
        let before = self.step.take();
        self.step = if slow { None } else { self.pass(position, before.as_ref()) };
        self.count();
        if self.step.is_none() {
            self.state.angle = position.angle;
            self.state.turns = position.turns;
            self.state.interval = self.mesh.cells()[position.cell].interval;
            self.take_energy(position.energy);
            self.state.w = self.state.u.hi / self.inertia_now()[0].sqrt();
            self.hand_over();
        }
    }

    /// Counts the step that begins, if one does.
    fn count(&mut self) {
        let Some(step) = &self.step else { return };
        let [speed, angle] = step.error_within(self.errors);
        let estimate = speed.max(angle / self.travelled.max(1.0));
        self.solver.error_estimate = self.solver.error_estimate.max(estimate);
        self.solver.steps += 1.0;
    }

    /// Ends the step at the last communication point; the machine goes on from there.
    fn leave(&mut self) {
        if let Some(step) = self.step.take() {
            self.errors = step.errors_at(self.errors, self.abscissa);
            self.travelled += step.advance(self.abscissa);
            self.take_energy(step.energy_at(self.abscissa));
            self.hand_over();
        }
    }

    /// The integration in time goes on from here with the errors of the steps in the angle.
    fn hand_over(&mut self) {
        let (w, u) = (self.state.w.abs(), self.state.u.hi.abs());
        self.in_time.integrator.set_deviations(w * self.errors.time, 0.5 * u * self.errors.energy);
    }

    /// u from E.
    fn take_energy(&mut self, energy: Double) {
        let root = (energy + energy).sqrt();
        self.state.u = if self.torques.sense > 0.0 { root } else { -root };
    }

    /// Takes the values `elapsed` (s) after the beginning of the step, which holds them.
    fn read(&mut self, elapsed: f64) {
        let Some(step) = &self.step else { return };
        let sense = self.torques.sense;
        self.abscissa = step.place_at(elapsed);
        self.state.angle = step.from.angle + Double::from(sense * step.advance(self.abscissa));
        self.state.turns = step.from.turns;
        self.state.interval = self.mesh.cells()[step.from.cell].interval;
        // J is the function itself, so that ½ J φ̇² is E to the last digit.
        let inertia = self.mesh.profile.value(&self.inertia, self.state.interval, self.state.angle.hi);
        let energy = step.from.energy.hi + (step.from.energy.lo + step.work_to(self.abscissa));
        self.state.w = sense * (2.0 * energy / inertia).sqrt();
    }

    /// The step from `position` on, at most to the end of the cell; None where no step meets the tolerance.
    fn pass(&mut self, position: Position, before: Option<&AngleStep>) -> Option<AngleStep> {
        let mut steps = AngleSteps {
            inertia: &self.inertia,
            mesh: &self.mesh,
            torques: self.torques,
            tolerance: self.solver.effective_tolerance(),
            next_length: self.next_length,
            evaluations: self.solver.evaluations,
            tables: 0,
        };
        let step = steps.pass(position, before, f64::INFINITY);
        (self.next_length, self.solver.evaluations) = (steps.next_length, steps.evaluations);
        step
    }
}
