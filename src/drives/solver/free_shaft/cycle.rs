//! The periodic motion under a constant load, tabulated: the motion of every turn once a machine has run up.
//!
//! A cell of the mesh that begins with E = E* + δ, E* on the periodic motion, follows that motion except for
//!
//! δ(ψ) = δ(0) g(ψ),  g(ψ) = exp ∫₀^ψ ∂N/∂E dψ,  δt = −δ(0) ½ ∫ g/(E φ̇) dψ,
//!
//! which is right to first order in δ. If the square of δ is below the tolerance nothing remains to be solved. The table follows
//! from the parameters and the load, so all instances with the same ones share it. A machine that reads it computes the same
//! whatever has happened before.

use super::angle_step::{AngleStep, Position, Shift};
use super::mesh::Mesh;
use super::turn_map::{ROUNDING, TurnMap};
use crate::drives::shaft::free::motor::{Kloss, Motor};
use crate::drives::shaft::free::torques::Torques;
use crate::numerics::double_double::Double;
use crate::numerics::gauss::{ABSCISSAE, MATRIX, STAGES, WEIGHTS};

/// The part of the tolerance that a tabulated step may add to the error of the solved one.
const PART: f64 = 0.1;

/// The most steps of a turn in a table: half a kilobyte each, and half a microsecond in each turn of the search.
const MOST_LAPS: usize = 400;

/// Turns in search of the periodic motion. The secant method needs five; without a periodic motion it goes astray soon.
const TURNS: usize = 10;

/// Part of the tolerance by which the end of the tabulated turn may miss its start; it acts like a δ.
const CLOSED: f64 = 1e-2;

/// The table.
pub struct Cycle {
    torques: Torques,
    /// The steps of the turn, in the order in which they are passed.
    laps: Vec<Lap>,
    /// The first step of each cell.
    first: Vec<usize>,
}

/// A step of the periodic motion and its response to a δ.
struct Lap {
    step: AngleStep,
    /// Growth of E over the step (J), and the duration of the step (s).
    gain: Double,
    duration: Double,
    /// g − 1 at the end.
    growth: f64,
    /// dt/dδ of the whole step (s/J), and the same relative to its duration (1/J).
    delay: f64,
    slower: f64,
    /// 1/E at the beginning (1/J).
    per_joule: f64,
    /// Nonlinear remainder of δ/E within the step: g and the integral for δt are approximated as proportional to x and t.
    bent: f64,
    /// The largest |δ| (J).
    reach: f64,
}

impl Lap {
    fn new(step: AngleStep, torques: &Torques, tolerance: f64) -> Self {
        let length = step.length;
        let e: [f64; STAGES] = ABSCISSAE.map(|x| step.energy_at(x).hi);
        let w: [f64; STAGES] = ABSCISSAE.map(|x| step.speed_at(x));
        let rates: [f64; STAGES] = std::array::from_fn(|i| length * torques.with_slope(w[i], e[i])[1]);
        let sum = |weights: &[f64; STAGES], values: &[f64; STAGES]| -> f64 {
            weights.iter().zip(values).map(|(b, value)| b * value).sum()
        };
        let exponent = sum(&WEIGHTS, &rates);
        let delays: [f64; STAGES] = std::array::from_fn(|i| sum(&MATRIX[i], &rates).exp() / (e[i] * w[i]));
        let largest = |values: &[f64; STAGES]| values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        // A function that varies by v differs from its chord by a part of v; E and the rate of g alike.
        let bent = 0.25 * largest(&rates) + 0.25 * (step.energy.hi / step.from.energy.hi).ln().abs();
        let room = PART * tolerance;
        let (duration, energy) = (step.end - step.from.time, step.from.energy);
        let delay = -0.5 * length * sum(&WEIGHTS, &delays);
        Lap {
            gain: step.energy - energy,
            duration,
            growth: exponent.exp_m1(),
            delay,
            slower: delay / duration.hi,
            per_joule: 1.0 / energy.hi,
            bent,
            reach: energy.hi * room.sqrt().min(room / bent.max(f64::MIN_POSITIVE)),
            step,
        }
    }

    /// Makes `step` the one from another energy at its start; false if that is too far away.
    fn lay(&self, position: Position, step: &mut AngleStep) -> bool {
        let own = &self.step;
        let delta = (position.energy - own.from.energy).hi;
        if !(delta.abs() <= self.reach) {
            return false;
        }
        let relative = delta * self.per_joule;
        *step = *own;
        step.shift(Shift {
            from: position,
            gain: self.gain,
            more: self.growth * delta,
            duration: self.duration,
            longer: self.delay * delta,
            slower: self.slower * delta,
            ends: relative * relative,
            between: relative.abs() * self.bent,
        });
        true
    }
}

impl Cycle {
    /// The periodic motion on this mesh against the load `tau` (N·m); None if no motion suits a table.
    pub fn new(mesh: &Mesh, tau: f64) -> Option<Self> {
        let Motor::Kloss(Kloss { dynamics: None, .. }) = mesh.motor else { return None };
        let tolerance = mesh.tolerance;
        let mut map = TurnMap::new(mesh, tau, tolerance, None).ok()?;
        map.most_steps = MOST_LAPS;
        let torques = map.torques;
        let mut energy = map.first_energy?;
        let mut turn: Vec<AngleStep> = Vec::with_capacity(2 * mesh.cells().len());
        let mut before = None;
        for _ in 0..TURNS {
            turn.clear();
            let shot = map.follow(energy, |step| turn.push(*step))?;
            if shot.gain.abs() <= (CLOSED * tolerance).max(ROUNDING) * energy {
                let mut first = vec![0; mesh.cells().len()];
                for (i, step) in turn.iter().enumerate().rev() {
                    first[step.from.cell] = i;
                }
                let laps = turn.into_iter().map(|step| Lap::new(step, &torques, tolerance)).collect();
                return Some(Cycle { torques, laps, first });
            }
            energy -= shot.gain / shot.rise(energy, &mut before);
            if !(energy > 0.0 && energy.is_finite()) {
                return None;
            }
        }
        None
    }

    /// Whether it is the motion against the load `tau` (N·m).
    pub fn is_against(&self, tau: f64) -> bool {
        self.torques.against_what() == tau
    }

    /// Makes `step` the step that begins at `position`, near the periodic motion; returns whether there is one.
    pub fn lay(&self, torques: &Torques, position: Position, step: &mut AngleStep) -> bool {
        if self.torques != *torques {
            return false;
        }
        let here = |lap: &&Lap| lap.step.from.angle == position.angle;
        let mut own =
            self.laps[self.first[position.cell]..].iter().take_while(|lap| lap.step.from.cell == position.cell);
        own.find(here).is_some_and(|lap| lap.lay(position, step))
    }
}
