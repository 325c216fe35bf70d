//! The motion added by forces that depend on time alone: constant loads and an input, a polynomial of time over a communication
//! step. The equation is linear, so this motion adds to the motion that cam and process cause.

use crate::drives::shaft::free::signal::Signal;
use crate::numerics::chebyshev::fit;
use crate::numerics::forced::{ForcedStep, admissible_length, under_constant};
use crate::numerics::oscillator::Oscillator;
use serde::{Deserialize, Serialize};

/// Roundings of a step, relative to the sizes of motion and deflection.
const ROUNDINGS: f64 = 8.0 * f64::EPSILON;

/// The motion from a start on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Push {
    /// F (N).
    pub signal: Signal,
    /// q (m), q̇ (m/s) at the communication point.
    pub now: [f64; 2],
    /// The acceleration (m/s²) that has been constant since the `start` (s), and the state there.
    constant: Option<f64>,
    start: f64,
    from: [f64; 2],
    /// Estimated errors of q (m) at the communication point and at the start.
    rounded: [f64; 2],
}

impl Push {
    /// Starts from q, q̇.
    pub fn begin(&mut self, now: [f64; 2]) {
        *self = Push { signal: self.signal, now, ..Push::default() };
    }

    /// Restarts after a change of the oscillator.
    pub fn restart(&mut self) {
        self.constant = None;
    }

    /// Goes on from one time to another (s) under the acceleration `still` (m/s²) and the input on the mass `m` (kg).
    pub fn advance(&mut self, oscillator: &Oscillator, m: f64, still: f64, [time, end]: [f64; 2]) {
        self.signal.step_begins();
        let acceleration = |t: f64| still + self.signal.at(t) / m;
        let constant = self.signal.is_constant().then(|| acceleration(0.0));
        if constant == Some(0.0) && self.now == [0.0; 2] {
            self.restart();
            return self.signal.step_ends(end - time);
        }
        if constant.is_none() || constant != self.constant {
            (self.start, self.from, self.constant) = (time, self.now, constant);
            self.rounded[1] = self.rounded[0];
        }
        let (length, elapsed) = (end - time, end - self.start);
        let mut largest = acceleration(0.0).abs();
        match constant {
            Some(a) => self.now = under_constant(oscillator, a, self.from, elapsed),
            None => {
                let mut done = 0.0;
                while done < length {
                    let part = admissible_length(oscillator, length - done);
                    // Degree 8 at most, so the interpolant is the polynomial itself.
                    let forcing = fit(|x| acceleration(done + 0.5 * part * (1.0 + x)), f64::EPSILON, 0.0).polynomial;
                    self.now = ForcedStep::new(oscillator, part, forcing, self.now).at(oscillator, part);
                    largest = forcing.coefficients.iter().map(|c| c.abs()).sum::<f64>().max(largest);
                    done = if part < length - done { done + part } else { length };
                }
            }
        }
        self.signal.step_ends(length);
        // The time since a start that is not zero is rounded, and so is the phase.
        let rate = oscillator.stiffness().sqrt();
        let reach = elapsed.min(1.0 / rate);
        let size = self.now[0].abs() + self.from[0].abs() + reach * (self.from[1].abs() + reach * largest);
        let decay = (-oscillator.decay() * elapsed).exp();
        let phase = if self.start == 0.0 { 0.0 } else { f64::EPSILON * rate * elapsed * decay };
        self.rounded[0] = decay * self.rounded[1] + (ROUNDINGS + phase) * size;
    }

    /// Estimated error of q (m).
    pub fn error(&self) -> f64 {
        self.rounded[0]
    }
}
