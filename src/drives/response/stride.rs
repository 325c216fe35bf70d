//! Equal communication steps at constant speed: cos φ and sin φ turn on, and the free motion goes on, by the same
//! matrices in each of them. Every few steps both are computed anew, so that roundings do not add up.

use crate::numerics::oscillator::Oscillator;
use serde::{Deserialize, Serialize};

/// After so many steps the closed form is evaluated anew: this costs a few times as much as a step, and the roundings of
/// the steps between stay at some 1e-15.
const STEPS: u32 = 16;

/// The communication points lie where their rounding puts them; what a step is longer or shorter than the others is
/// taken into account to first order up to this angle [rad], whose square is below rounding.
const SLIGHT: f64 = 1e-8;

/// The last point and how to go on from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stride {
    /// The length of the steps [s]; 0 while unknown.
    length: f64,
    /// How much longer or shorter a step may be [s].
    slack: f64,
    /// How many steps may follow.
    left: u32,
    /// The last point [s] and the length of the last step [s].
    time: f64,
    last: f64,
    /// cos φ and q of the free motion; sin φ and q̇.
    upper: [f64; 2],
    lower: [f64; 2],
    /// Upper and lower part after a step, from those before.
    upper_from: [[f64; 2]; 2],
    lower_from: [[f64; 2]; 2],
    /// Time derivatives: that of the upper part from the lower one; that of the lower part from both.
    upper_rate: [f64; 2],
    lower_rate: [[f64; 2]; 2],
}

/// cos φ, sin φ and q, q̇ of the free motion.
pub type Turned = ([f64; 2], [f64; 2]);

impl Stride {
    /// Goes on to `time` [s], where that is one step more.
    #[inline(always)]
    pub fn to(&mut self, time: f64) -> Option<Turned> {
        let rest = time - self.time - self.length;
        if !(rest.abs() < self.slack) || self.left == 0 {
            return None;
        }
        self.left -= 1;
        self.time = time;
        let (mut upper, mut lower) = ([0.0; 2], [0.0; 2]);
        for i in 0..2 {
            upper[i] = self.upper_from[0][i] * self.upper[i] + self.upper_from[1][i] * self.lower[i];
            lower[i] = self.lower_from[0][i] * self.upper[i] + self.lower_from[1][i] * self.lower[i];
        }
        for i in 0..2 {
            self.upper[i] = upper[i] + rest * (self.upper_rate[i] * lower[i]);
            self.lower[i] = lower[i] + rest * (self.lower_rate[0][i] * upper[i] + self.lower_rate[1][i] * lower[i]);
        }
        Some(([self.upper[0], self.lower[0]], [self.upper[1], self.lower[1]]))
    }

    /// Starts from what was computed anew at `time` [s].
    pub fn start(&mut self, time: f64, (z, free): Turned) {
        self.last = time - self.time;
        (self.time, self.upper, self.lower) = (time, [z[0], free[0]], [z[1], free[1]]);
        self.left = if self.holds() { STEPS } else { 0 };
    }

    /// The length of the steps [s], where two in a row had one for which nothing is prepared yet.
    pub fn unprepared(&self, time: f64) -> Option<f64> {
        let length = time - self.time;
        let again = (length - self.last).abs() <= SLIGHT * length;
        (again && !((length - self.length).abs() < self.slack)).then_some(length)
    }

    fn holds(&self) -> bool {
        (self.last - self.length).abs() < self.slack
    }

    /// Prepares steps of this `length` [s], over which φ turns by the angle with this cosine and sine and the free motion
    /// goes by the matrix `free`; with the speed [rad/s] and the order of the law.
    pub fn prepare(
        &mut self,
        oscillator: &Oscillator,
        length: f64,
        [c, s]: [f64; 2],
        free: [[f64; 2]; 2],
        [speed, order]: [f64; 2],
    ) {
        let (_, fast) = oscillator.rates();
        self.length = length;
        self.slack = SLIGHT * length.min(1.0 / fast.max(order * speed.abs()));
        self.upper_from = [[c, free[0][0]], [-s, free[0][1]]];
        self.lower_from = [[s, free[1][0]], [c, free[1][1]]];
        self.upper_rate = [-speed, 1.0];
        self.lower_rate = [[speed, -oscillator.stiffness()], [0.0, -2.0 * oscillator.damping()]];
    }

    /// Before the first point.
    pub fn new() -> Self {
        Stride { time: f64::MIN, ..Stride::default() }
    }
}
