//! What each output depends on, found by its own equations: the partial derivatives in a few random states, and what the start
//! makes of other inputs.

use super::variables::Dependencies;
use super::{DriveTrain, Joint, Start, variables};
use crate::drives::Seed;
use crate::drives::follower::contact::{Flank, Mode};
use crate::drives::shaft::cam_drive::DriveMode;
use crate::drives::shaft::train::MOST_STATES;
use std::f64::consts::TAU;

/// States in which the derivatives are taken: each way of contact with each of a servo.
const STATES: usize = 6;
/// Starts that are compared for each input and mode.
const STARTS: usize = 16;

/// Other values of each.
const OTHERS: usize = 4;

/// Numbers in [−1, 1), the same for every train (the generator of Knuth's MMIX).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

impl DriveTrain {
    /// The inputs by name, those of a driven shaft first.
    pub(super) fn input_names(&self) -> Vec<String> {
        let driven = self.course.inputs().map(|i| ["phi", "w", "a"][i]);
        let mut names: Vec<String> = driven.map(str::to_owned).collect();
        if let Some(machine) = self.train.machine() {
            let motor = &machine.motor;
            names.extend(self.inputs.loads.names());
            let named =
                [(motor.takes_torque(), "M_an"), (motor.takes_speed(), "w_ref"), (motor.takes_position(), "phi_ref")];
            names.extend(named.into_iter().filter(|(is, _)| *is).map(|(_, name)| name.to_owned()));
        }
        let forces = self.train.followers.iter().enumerate().filter(|(_, follower)| follower.load.input);
        names.extend(forces.map(|(j, _)| format!("follower[{}].F", j + 1)));
        names
    }

    /// The states by name.
    pub(super) fn state_names(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        if self.course.integrates() {
            names.push("phi".to_owned());
        }
        if let Some(machine) = self.train.machine() {
            names.extend(["phi", "w"].map(str::to_owned));
            if machine.motor.transmission.coupling.is_some() {
                names.extend(["motor.phi", "motor.w"].map(str::to_owned));
            }
            if machine.motor.states() > 0 {
                names.push(format!("motor.{}", machine.motor.state_name()));
            }
        }
        for (j, follower) in self.train.followers.iter().enumerate() {
            let own: &[&str] = match follower.joint {
                Joint::Rigid => &[],
                Joint::Output(..) => &["y"],
                Joint::Shaft(_) => &["q"],
                Joint::Backlash(p) if p.m2 > 0.0 => &["x1", "y"],
                Joint::Backlash(_) => &["x1"],
            };
            let both =
                |name: &&str| [format!("follower[{}].{name}", j + 1), format!("der(follower[{}].{name})", j + 1)];
            names.extend(own.iter().flat_map(both));
        }
        names
    }

    /// Sets the inputs to random numbers.
    fn shake(&mut self, random: &mut Random) {
        for i in 0..self.input_names().len() {
            self.set_input(i, 10.0 * random.next());
        }
        if let DriveMode::Speed { phi_start } = &mut self.course.mode {
            *phi_start = 10.0 * random.next();
        }
    }

    fn set_input(&mut self, number: usize, value: f64) {
        let driven = self.course.inputs();
        if number < driven.len() {
            self.course.set_input(driven.start + number, value);
        } else if let Some(signal) = self.signal_at(number - driven.len()) {
            signal.set(value);
        }
    }

    /// What the outputs depend on.
    pub(super) fn dependencies(&self) -> Dependencies {
        let places = variables::places(self.train.followers.len());
        let (mut running, mut initial) = (vec![Vec::new(); places], vec![Vec::new(); places]);
        let (inputs, mut random) = (self.input_names(), Random(1));
        let known: Vec<String> = inputs.iter().cloned().chain(self.state_names()).collect();
        for sample in 0..STATES {
            let mut probe = Box::new(self.clone());
            probe.start = Start::AtRest;
            probe.shake(&mut random);
            if probe.begin(0.0).is_err() {
                continue;
            }
            probe.disturb(sample, &mut random);
            for name in &known {
                variables::slopes(&probe, Seed::Known(name), |place, slope| {
                    if slope != 0.0 && !running[place].contains(name) {
                        running[place].push(name.clone());
                    }
                });
            }
        }
        for sample in 0..2 * STARTS {
            let mut probe = Box::new(self.clone());
            probe.start = if sample % 2 == 0 { Start::AtRest } else { Start::Equilibrium };
            probe.shake(&mut random);
            let values = |probe: &mut DriveTrain| {
                let mut values = vec![0.0; places];
                probe.begin(0.0).ok()?;
                variables::evaluate(probe, &mut values);
                Some(values)
            };
            let Some(before) = values(&mut probe) else { continue };
            for (i, name) in inputs.iter().enumerate() {
                for _ in 0..OTHERS {
                    let mut other = Box::new((*probe).clone());
                    other.set_input(i, 10.0 * random.next());
                    let Some(after) = values(&mut other) else { continue };
                    for (place, (a, b)) in before.iter().zip(&after).enumerate() {
                        if (a - b).abs() > 1e-9 * (a.abs() + b.abs()) && !initial[place].contains(name) {
                            initial[place].push(name.clone());
                        }
                    }
                }
            }
        }
        // A periodic motion, but for its angle, is that of all that acts on the shaft.
        if self.train.machine().is_some_and(|machine| !machine.motor.takes_speed()) {
            for (names, running) in initial.iter_mut().zip(&running) {
                if running.iter().any(|name| name != "phi" && !inputs.contains(name)) {
                    names.clone_from(&inputs);
                }
            }
        }
        // Whether the demand is beyond the limit.
        initial[variables::SATURATED] = initial[variables::DEMAND].clone();
        Dependencies { running, initial, parameters: Vec::new() }
    }

    /// Moves the states at random; followers with backlash are on a flank and in flight by turns.
    fn disturb(&mut self, sample: usize, random: &mut Random) {
        let mut y = [0.0; MOST_STATES];
        self.run.from(&mut y);
        let count = self.train.layout.count;
        y[..count].iter_mut().for_each(|y| *y += 0.1 * random.next());
        if self.train.machine().is_some() {
            (y[0], y[1]) = (0.5 * TAU * random.next(), 10.0 * random.next());
        }
        let mut modes = self.run.modes;
        modes.saturation = [0, 1, -1][sample % 3];
        for (j, follower) in self.train.followers.iter().enumerate() {
            if let Joint::Backlash(_) = follower.joint {
                let at = self.train.layout.followers[j];
                let free = sample.is_multiple_of(2);
                modes.contacts[j] = if free { Mode::Free } else { Mode::Contact(Flank::A) };
                modes.beyond[j] = false;
                if !free {
                    (y[at], y[at + 1]) = (0.0, 0.0);
                }
            }
        }
        self.run.put(&y[..count], modes);
    }
}
