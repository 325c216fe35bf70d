//! Whether angle and speed of a shaft, both inputs, belong together: where those of one step lead, those of the next begin.

use crate::drives::{About, Event, EventLog};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// By which part of the way of a step φ may be off without a word: angle and speed that are measured apart agree about as well.
const SHARE: f64 = 0.01;

/// A jump of φ (rad) that no master means and that shakes nothing: 0.1 µm at a radius of 100 mm. Solvers of masters err by as much.
const UNFELT: f64 = 1e-6;

/// What is told, once each.
const JUMPS: &str = "phi is not where phi, w and a of the step before led: the cam jumps there, which shakes the drive; w and a are \
                     the derivatives of phi";
const NO_SPEED: &str =
    "w stays 0 while phi moves: the cam jumps from one communication point to the next; connect w and a, too";
const NO_ANGLE: &str = "phi stays while w does not: the cam returns to it at every communication point; connect phi, too, or \
                        choose [drive] mode = \"speed\", which integrates w";

/// The rounding of inputs φ and ω at `time` (s), of which the time itself has its part.
pub fn roundings([phi, w, a]: [f64; 3], time: f64) -> [f64; 2] {
    [phi.abs() + (w * time).abs(), w.abs() + (a * time).abs()].map(|size| 4.0 * f64::EPSILON * size)
}

/// The step before: φ (rad) and ω (rad/s) as the inputs gave them at its start, and when that was (s).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Led {
    /// φ and ω.
    pub from: [f64; 2],
    /// The start.
    pub time: f64,
    /// Which causes have been told, as bits.
    told: u8,
}

impl Led {
    /// At the start nothing has led anywhere.
    pub fn begin(from: [f64; 2], time: f64) -> Self {
        Led { from, time, told: 0 }
    }

    /// Inputs `now` at `time` (s), where the step before led `to`, both φ and ω.
    pub fn compare(&mut self, now: [f64; 2], to: [f64; 2], time: f64, log: &mut EventLog) {
        let [phi, w] = now;
        // What `a` did not tell of the change of w explains as much of the way at most.
        let explained = (time - self.time) * ((w - to[1]).abs() + SHARE * (w.abs() + to[1].abs()));
        // An angle may begin anew each turn.
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
        if self.told & cause == 0 {
            self.told |= cause;
            let (quantity, value, unit) = ("jump of phi", jump, "rad");
            log.push(Event { time, kind, quantity, value, unit, follower: 0, about: About::Inputs });
        }
    }
}

#[cfg(test)]
mod tests;
