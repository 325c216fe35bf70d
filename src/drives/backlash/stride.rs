//! Equal communication steps within a panel in closed form: e^(iφ) turns on and the free vibration goes on by the same maps
//! in each of them. Every few steps both are computed anew, so that roundings do not add up. Panels and switching instants
//! know nothing of it: only what is read between them comes this way.

use super::waves::product;
use crate::numerics::forced::apply;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::phase::sin_cos_of_both;
use serde::{Deserialize, Serialize};

/// After so many steps the closed form is evaluated anew; the roundings of the steps between stay at some 1e-15.
const STEPS: f64 = 16.0;

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
    /// By what a step turns the first, and the first row of the matrix that makes q, q̇ of the second.
    turn: [f64; 2],
    row: [f64; 2],
    /// The length of the steps [s], and how much longer or shorter one may be [s].
    length: f64,
    slack: f64,
    /// From here on everything is computed anew [s].
    until: f64,
}

impl Stride {
    /// Another panel begins.
    pub fn begin(&mut self) {
        (self.until, self.length) = (f64::MIN, 0.0);
    }

    /// e^(iφ) and q, q̇ of the free vibration at the time `to` [s], where that is one step more than `from`; φ̇ = `speed`
    /// [rad/s].
    #[inline(always)]
    pub fn go(&mut self, [from, to]: [f64; 2], oscillator: &Oscillator, speed: f64) -> Option<([f64; 2], [f64; 2])> {
        let rest = to - from - self.length;
        if !(rest.abs() < self.slack && to < self.until) {
            return None;
        }
        let [c, s] = product(self.turn, self.z);
        let [a, b] = self.row;
        // d/dt of the first row, by the equation of motion.
        let map = [[a, b], [-oscillator.stiffness() * b, a - 2.0 * oscillator.damping() * b]];
        let [q, v] = apply(&map, self.free);
        let turned = rest * speed;
        let a = -(oscillator.stiffness() * q + 2.0 * oscillator.damping() * v);
        (self.z, self.free) = ([c - turned * s, s + turned * c], [q + rest * v, v + rest * a]);
        Some((self.z, self.free))
    }

    /// Goes on from what was computed anew at the time `to` [s], after a step from `from` and one of the length `last` [s];
    /// the panel goes on for `ahead` [s], and its harmonics change at the rate `fastest` [rad/s] at most.
    pub fn start(
        &mut self,
        ([from, to], last): ([f64; 2], f64),
        (z, free): ([f64; 2], [f64; 2]),
        oscillator: &Oscillator,
        (speed, fastest): (f64, f64),
        ahead: f64,
    ) {
        let length = to - from;
        let again = (length - last).abs() <= SLIGHT * length;
        (self.z, self.free, self.until) = (z, free, f64::MIN);
        if !again || ahead < WORTH * length {
            return;
        }
        if !((length - self.length).abs() < self.slack) {
            self.length = length;
            self.slack = SLIGHT * length.min(1.0 / oscillator.rates().1.max(fastest));
            let frequency = oscillator.frequency().unwrap_or_default().hi;
            let [[s, c], own] = sin_cos_of_both([speed * length, frequency * length]);
            self.turn = [c, s];
            self.row = [[1.0, 0.0], [0.0, 1.0]].map(|start| oscillator.free_motion(start).at(length, own)[0]);
        }
        self.until = to + (STEPS + 0.5) * self.length;
    }
}
