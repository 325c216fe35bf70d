//! Whether angle and speed of a shaft, both inputs, belong together: each step should begin at the φ and ω to which the previous
//! one led.

use crate::drives::{About, Event, EventLog};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The part of a step's way by which φ may be off without a message: separately measured angles and speeds agree about as well.
const SHARE: f64 = 0.01;

/// An unintended jump of φ (rad) below this shakes nothing: 0.1 µm at a radius of 100 mm. Solvers of masters err by as much.
const UNFELT: f64 = 1e-6;

/// The messages, each logged once.
const JUMPS: &str = "phi differs from the angle to which phi, w and a of the previous step lead: the cam jumps, which shakes the \
                     drive; w and a must be the derivatives of phi";
const NO_SPEED: &str = "w stays 0 while phi changes: the cam jumps at each communication point; connect w and a, too";
const NO_ANGLE: &str = "phi stays constant while w is not 0: the cam returns to phi at each communication point; connect phi, \
                        too, or choose [drive] mode = \"speed\", which integrates w";

/// The rounding of inputs φ and ω at `time` (s), including the rounding of the time.
pub fn roundings([phi, w, a]: [f64; 3], time: f64) -> [f64; 2] {
    [phi.abs() + (w * time).abs(), w.abs() + (a * time).abs()].map(|size| 4.0 * f64::EPSILON * size)
}

/// The previous step: φ (rad) and ω (rad/s) of the inputs at its start, and the time of its start (s).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Consistency {
    /// φ and ω.
    pub from: [f64; 2],
    /// The start.
    pub time: f64,
    /// The causes already logged, as bits.
    logged: u8,
}

impl Consistency {
    /// At the start there is no previous step.
    pub fn begin(from: [f64; 2], time: f64) -> Self {
        Consistency { from, time, logged: 0 }
    }

    /// Compares inputs `now` at `time` (s) with the φ and ω to which the previous step led, `to`.
    pub fn compare(&mut self, now: [f64; 2], to: [f64; 2], time: f64, log: &mut EventLog) {
        let [phi, w] = now;
        // A change of w that `a` does not explain accounts for at most this part of the way.
        let explained = (time - self.time) * ((w - to[1]).abs() + SHARE * (w.abs() + to[1].abs()));
        // An angle may start again at each turn.
        let off = phi - to[0];
        let jump = off - TAU * (off / TAU).round();
        if jump.abs() <= explained + UNFELT + roundings([phi, w, 0.0], time)[0] {
            return;
        }
        let (cause, kind) = if w == 0.0 && self.from[1] == 0.0 {
            (1, NO_SPEED)
        } else if phi == self.from[0] {
            (2, NO_ANGLE)
        } else {
            (4, JUMPS)
        };
        if self.logged & cause == 0 {
            self.logged |= cause;
            let (quantity, value, unit) = ("jump of phi", jump, "rad");
            log.push(Event { time, kind, quantity, value, unit, follower: 0, about: About::Inputs });
        }
    }
}

#[cfg(test)]
mod tests;
