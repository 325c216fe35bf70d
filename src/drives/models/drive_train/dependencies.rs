//! The dependencies of each output, found from its own equations: the partial derivatives in a few random states, and starts with
//! other inputs.

use super::variables::{Dependencies, Row};
use super::{DriveTrain, Start, variables};
use crate::drives::follower::contact::{Flank, Mode};
use crate::drives::shaft::cam_drive::DriveMode;
use crate::drives::shaft::train::MOST_STATES;
use crate::drives::variable::Role;
use crate::drives::{List, Seed};
use std::f64::consts::TAU;

/// States in which the derivatives are taken: each case of contact with each case of a servo.
const STATES: usize = 6;
/// Starts that are compared for each input and mode.
const STARTS: usize = 16;

/// Other values of each input.
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
    /// A copy on the heap. Not inlined, so that it takes no room in the stack frame of a deep call.
    #[inline(never)]
    fn copied(&self) -> Box<Self> {
        Box::new(self.clone())
    }

    /// The same with other inputs.
    fn shaken(&self, inputs: &List<Self>, random: &mut Random) -> Box<Self> {
        let mut probe = self.copied();
        inputs.0.iter().for_each(|input| input.set(&mut probe, 10.0 * random.next()));
        if let DriveMode::Speed { phi_start } = &mut probe.shaft.mode {
            *phi_start = 10.0 * random.next();
        }
        probe
    }

    /// The dependencies of the outputs.
    pub(super) fn dependencies(&self, table: &[Row]) -> Dependencies {
        let places = variables::FIRST + table.len();
        let (mut running, mut initial) = (vec![Vec::new(); places], vec![Vec::new(); places]);
        let (list, mut random) = (self.inputs(), Random(1));
        let inputs: Vec<String> = list.0.iter().map(|input| input.description.name.clone()).collect();
        let states = table.iter().filter(|row| row.output.role == Role::State).map(|row| self.name_of(row));
        let known: Vec<String> = inputs.iter().cloned().chain(states).collect();
        for sample in 0..STATES {
            let mut probe = self.shaken(&list, &mut random);
            probe.start = Start::AtRest;
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
        let starts = if list.0.is_empty() { 0 } else { 2 * STARTS };
        for sample in 0..starts {
            let mut probe = self.shaken(&list, &mut random);
            probe.start = if sample % 2 == 0 { Start::AtRest } else { Start::Equilibrium };
            let values = |probe: &mut DriveTrain| {
                let mut values = vec![0.0; places];
                probe.begin(0.0).ok()?;
                variables::evaluate(probe, &mut values);
                Some(values)
            };
            let Some(before) = values(&mut probe) else { continue };
            for (input, name) in list.0.iter().zip(&inputs) {
                for _ in 0..OTHERS {
                    let mut other = probe.copied();
                    input.set(&mut other, 10.0 * random.next());
                    let Some(after) = values(&mut other) else { continue };
                    for (place, (a, b)) in before.iter().zip(&after).enumerate() {
                        if (a - b).abs() > 1e-9 * (a.abs() + b.abs()) && !initial[place].contains(name) {
                            initial[place].push(name.clone());
                        }
                    }
                }
            }
        }
        // A periodic motion, except for its angle, depends on everything that acts on the shaft.
        if self.train.machine().is_some_and(|machine| !machine.motor.takes_speed()) {
            for (names, running) in initial.iter_mut().zip(&running) {
                if running.iter().any(|name| name != "phi" && !inputs.contains(name)) {
                    names.clone_from(&inputs);
                }
            }
        }
        // Whether the demand before it exceeds the limit.
        if let Some(at) = table.iter().position(|row| row.output.name == variables::SATURATED) {
            initial[variables::FIRST + at] = initial[variables::FIRST + at - 1].clone();
        }
        Dependencies { inputs, running, initial }
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
        for (j, at, _) in self.train.clearances() {
            let free = sample.is_multiple_of(2);
            modes.stands[j].contact = if free { Mode::Free } else { Mode::Contact(Flank::A) };
            modes.stands[j].beyond = false;
            if !free {
                (y[at], y[at + 1]) = (0.0, 0.0);
            }
        }
        self.run.put(&y[..count], modes);
    }
}
