//! Equal communication steps at constant speed: cos φ and sin φ turn on, and the free motion goes on, by the same
//! matrices in each of them. Every few steps both are computed anew, so that roundings do not add up.

use crate::numerics::oscillator::Oscillator;
use crate::numerics::pair::Pair;
use serde::{Deserialize, Serialize};

/// After so many steps the closed form is evaluated anew: this costs twice as much as a step, and the roundings of
/// the steps between stay at some 1e-15.
pub const STEPS: f64 = 32.0;

/// The communication points lie where their rounding puts them; what a step is longer or shorter than the others is
/// taken into account to first order up to this angle [rad], whose square is below rounding.
const SLIGHT: f64 = 1e-8;

/// The last point and how to go on from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stride {
    /// By what e^(iφ) changes in a step, as a map of what it was: its rounding is smaller than that of the map to what it is.
    turn: Map,
    /// q, q̇ of the free motion after a step, from those before.
    free: Map,
    /// How the latter map changes with the length of the step.
    free_rate: Map,
    /// φ̇ [rad/s] as that of sin φ from cos φ and that of cos φ from sin φ.
    spin: Pair,
    z: Pair,
    state: Pair,
    /// Whether there still is a free motion.
    free_moves: bool,
    /// The length of the steps [s]; 0 while unknown.
    length: f64,
    /// How much longer or shorter a step may be [s].
    slack: f64,
    /// The last point [s] and the length of the last step [s].
    time: f64,
    last: f64,
    /// From here on everything is computed anew [s].
    until: f64,
}

/// A matrix of two rows: what lies on its diagonal, and beside it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Map {
    straight: Pair,
    crossed: Pair,
}

impl Map {
    /// The matrix with these rows.
    pub fn of([[a, b], [c, d]]: [[f64; 2]; 2]) -> Self {
        Map { straight: Pair::new(a, d), crossed: Pair::new(b, c) }
    }

    /// The turn by the angle with this cosine and sine.
    #[inline(always)]
    pub fn turn(z: Pair) -> Self {
        Map { straight: z.firsts(), crossed: z.seconds() * Pair::new(-1.0, 1.0) }
    }

    /// The turn by twice that angle.
    #[inline(always)]
    pub fn turn_twice(z: Pair) -> Self {
        // sin 2φ = 2 sin φ cos φ, cos 2φ = 1 − 2 sin² φ.
        let products = z.seconds() * z;
        Map {
            straight: Pair::both(1.0) + products.seconds() * Pair::both(-2.0),
            crossed: products.firsts() * Pair::new(-2.0, 2.0),
        }
    }

    /// The image of `x`.
    #[inline(always)]
    pub fn at(&self, x: Pair) -> Pair {
        self.straight * x + self.crossed * x.swapped()
    }

    /// This map plus `part` of another.
    #[inline(always)]
    fn and(&self, part: Pair, other: &Map) -> Map {
        Map { straight: self.straight + part * other.straight, crossed: self.crossed + part * other.crossed }
    }
}

impl Stride {
    /// Goes on to `time` [s], where that is one step more.
    #[inline(always)]
    pub fn to(&mut self, time: f64) -> bool {
        let rest = time - self.time - self.length;
        // Neither a step of another length nor one too many, in one comparison.
        let excess = time - self.until;
        let excess = if rest.abs() < excess { excess } else { rest.abs() };
        if !(excess < self.slack) {
            return false;
        }
        self.time = time;
        let rest = Pair::both(rest);
        let z = self.z + self.turn.at(self.z);
        self.z = z + rest * (self.spin * z.swapped());
        if self.free_moves {
            self.state = self.free.and(rest, &self.free_rate).at(self.state);
        }
        true
    }

    /// cos φ, sin φ at the last point.
    #[inline(always)]
    pub fn pointer(&self) -> Pair {
        self.z
    }

    /// q, q̇ of the free motion there.
    #[inline(always)]
    pub fn free_state(&self) -> Pair {
        self.state
    }

    /// Goes on from what was computed anew at `time` [s].
    pub fn start(&mut self, time: f64, z: [f64; 2], state: [f64; 2]) {
        self.last = time - self.time;
        (self.time, self.z, self.state) = (time, z.into(), state.into());
        self.free_moves = state != [0.0; 2];
        self.until = if self.holds() { time + (STEPS + 0.5) * self.length } else { f64::MIN };
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

    /// Prepares steps of this `length` [s], over which φ turns by the angle with this cosine less 1 and this sine and the free
    /// motion goes by the matrix `free`; with the speed [rad/s] and the order of the law.
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
        self.turn = Map::turn(Pair::new(c, s));
        self.spin = Pair::new(-speed, speed);
        self.free = Map::of(free);
        let [q, v] = free;
        let rate = |i: usize| -oscillator.stiffness() * q[i] - 2.0 * oscillator.damping() * v[i];
        self.free_rate = Map::of([v, [rate(0), rate(1)]]);
    }

    /// Before the first point.
    pub fn new() -> Self {
        Stride { time: f64::MIN, until: f64::MIN, ..Stride::default() }
    }
}
