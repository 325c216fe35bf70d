//! Equal communication steps within a panel in closed form: e^(iφ) turns on and the free vibration goes on by the same maps
//! in each of them. Every few steps both are computed anew, so that roundings do not add up. Panels and switching instants
//! know nothing of it: only what is read between them comes this way.

use super::contact::{Bodies, Flank, Mode};
use super::waves::{Waves, product};
use crate::numerics::forced::apply;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::phase::sin_cos;
use serde::{Deserialize, Serialize};

/// After so many steps the closed form is evaluated anew; the roundings of the steps between stay at a few 1e-15.
const STEPS: f64 = 32.0;

/// The maps are worth making for this many steps.
const WORTH: f64 = 4.0;

/// The communication points lie where their rounding puts them; what a step is longer or shorter than the others is
/// taken into account to first order up to this angle [rad], whose square is below rounding.
const SLIGHT: f64 = 1e-8;

/// The last point and how to go on from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stride {
    /// e^(iφ) and the free vibration q, q̇.
    z: [f64; 2],
    free: [f64; 2],
    /// By what a step turns the first.
    turn: [f64; 2],
    /// In contact and in flight, the first row of the matrix that makes q, q̇ of the second.
    rows: [[f64; 2]; 2],
    /// The length of the steps [s], and how much longer or shorter one may be [s].
    length: f64,
    slack: f64,
    /// From here on everything is computed anew [s].
    until: f64,
}

/// A communication step that is read.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// When it begins and ends [s].
    pub from: f64,
    /// See `from`.
    pub to: f64,
    /// The length of the last one [s].
    pub last: f64,
}

impl Stride {
    /// Another panel begins.
    pub fn begin(&mut self) {
        self.until = f64::MIN;
    }

    /// By how much the step between these times [s] is longer than the one that the maps make [s]; None where they do not
    /// serve, as beyond the panel.
    #[inline(always)]
    pub fn rest(&self, from: f64, to: f64) -> Option<f64> {
        let rest = to - from - self.length;
        (rest.abs() < self.slack && to < self.until).then_some(rest)
    }

    /// e^(iφ) one step and `rest` [s] on; φ̇ = `speed` [rad/s].
    #[inline(always)]
    pub fn turned(&mut self, rest: f64, speed: f64) -> [f64; 2] {
        let [c, s] = product(self.turn, self.z);
        let turned = rest * speed;
        self.z = [c - turned * s, s + turned * c];
        self.z
    }

    /// q, q̇ of the free vibration in contact or in flight (`mode`) one step and `rest` [s] on.
    #[inline(always)]
    pub fn swing(&mut self, rest: f64, oscillator: &Oscillator, mode: Mode) -> [f64; 2] {
        let [a, b] = self.rows[row(mode)];
        let (stiffness, damping) = (oscillator.stiffness(), 2.0 * oscillator.damping());
        // d/dt of the first row, by the equation of motion.
        let [q, v] = apply(&[[a, b], [-stiffness * b, a - damping * b]], self.free);
        let acceleration = -(stiffness * q + damping * v);
        self.free = [q + rest * v, v + rest * acceleration];
        self.free
    }

    /// Goes on from what was computed anew at the end of a step; the panel goes on to `end` [s].
    pub fn start(&mut self, step: Step, (z, free): ([f64; 2], [f64; 2]), (bodies, waves): (&Bodies, &Waves), end: f64) {
        let length = step.to - step.from;
        let again = (length - step.last).abs() <= SLIGHT * length;
        (self.z, self.free) = (z, free);
        self.begin();
        if !again || end - step.to < WORTH * length {
            return;
        }
        if !((length - self.length).abs() < self.slack) {
            self.length = length;
            let fastest = waves.fastest().max(bodies.relative.rates().1);
            self.slack = SLIGHT * length.min(1.0 / fastest);
            let [s, c] = sin_cos(waves.speed * length);
            self.turn = [c, s];
            for mode in [Mode::Contact(Flank::A), Mode::Free] {
                let oscillator = bodies.oscillator(mode);
                let own = sin_cos(oscillator.frequency().unwrap_or_default().hi * length);
                self.rows[row(mode)] =
                    [[1.0, 0.0], [0.0, 1.0]].map(|start| oscillator.free_motion(start).at(length, own)[0]);
            }
        }
        self.until = (step.to + (STEPS + 0.5) * self.length).min(end);
    }
}

/// The place of what belongs to contact or to flight.
#[inline(always)]
fn row(mode: Mode) -> usize {
    usize::from(mode == Mode::Free)
}
