//! The turn as a map: E at its beginning → E at its end, under torques that do not depend on time.
//!
//! The map is monotone, and the motion in the angle (`angle_steps`) computes it. Its fixed points are the rotating
//! periodic solutions; the time of the turn is the period. The multiplier of a periodic solution is the slope of the map,
//!
//! exp ∮ ∂N/∂E dψ,  N = σ(M_an − τ),  ∂N/∂E = M_an′(ω)/(Jω):
//!
//! positive, however steep the characteristic. Unstable solutions are found backwards in time, which makes them stable.
//!
//! With a lagging torque the map has two dimensions ([`super::lagging_turn`]).

use super::angle_step::{AngleStep, Position};
use super::angle_steps::AngleSteps;
use super::mesh::Mesh;
use crate::drives::Fault;
use crate::drives::shaft::free::torques::Torques;
use crate::numerics::double_double::Double;
use crate::numerics::gauss::STAGES;
use crate::numerics::work::{self, Work};
use std::cell::Cell;

/// Tolerance of the scan; the signs are all that matters.
pub const SCAN_TOLERANCE: f64 = 1e-7;

/// Tolerance of the periodic motion itself: the ends of the steps are then exact to rounding.
pub const PERIODIC_TOLERANCE: f64 = 1e-12;

/// Rounding error of E from the integration over a turn, relative.
pub(super) const ROUNDING: f64 = 4e-15;

/// Iterations of the shooting; the secant method needs a handful, bisection fifty.
const ITERATIONS: usize = 80;

/// Below this part of the first energy, a billionth of the speed, a machine has come to rest.
const REST: f64 = 1e-18;

/// Steps of a turn; a motor that is synchronous for a hundred-thousandth of the turn only takes some hundred.
const MOST_STEPS: usize = 200_000;

/// Cost of a table of 2/J without the evaluations of J for it (nominal µs).
const TABLE: f64 = 0.5;

/// Cost of a step with so many evaluations of N (nominal µs).
pub(super) fn cost_of_step(evaluations: f64) -> f64 {
    0.15 + 0.03 * evaluations
}

/// Result of a turn from the start of the mesh.
pub struct Shot {
    /// E(2π) − E(0) (J).
    pub gain: f64,
    /// The approximate slope of the map.
    pub slope: f64,
    /// The time of the turn (s).
    pub period: f64,
}

impl Shot {
    /// d gain/dE at the `energy` of this turn: by a secant, since the slope of the map is known to some digits only. It uses energy
    /// and gain of the turn `before` and replaces it by this one.
    pub(super) fn rise(&self, energy: f64, before: &mut Option<(f64, f64)>) -> f64 {
        match before.replace((energy, self.gain)) {
            Some((other, its_gain)) if other != energy => (self.gain - its_gain) / (energy - other),
            _ => self.slope - 1.0,
        }
    }
}

/// The map at one tolerance.
#[derive(Clone)]
pub struct TurnMap<'a> {
    /// The mesh of this tolerance.
    pub mesh: Mesh,
    /// N over the speed.
    pub torques: Torques,
    tolerance: f64,
    /// E at the start of the turn on the periodic motion, approximately: the energy with the mean √J at the speed that balances the
    /// load.
    pub(super) first_energy: Option<f64>,
    /// The most steps in a turn; beyond that the machine is given up.
    pub(super) most_steps: usize,
    /// The remaining work of the call; a study takes as much as it needs.
    work: Option<&'a Cell<Work>>,
}

impl<'a> TurnMap<'a> {
    /// The map of a machine with this mesh against the load `tau` (N·m), in the motor's sense of rotation, with the remaining
    /// `work`; a study takes as much as it needs.
    ///
    /// # Errors
    /// The mesh of this tolerance takes too much work.
    pub fn new(own: &Mesh, tau: f64, tolerance: f64, work: Option<&'a Cell<Work>>) -> Result<Self, Fault> {
        let torques = Torques::against(&own.motor, tau, own.motor.sense());
        let root = |speed: f64| own.mean_root * speed;
        let first_energy = torques.balance().map(root).map(|root| 0.5 * root * root);
        // The machine's own mesh serves if it is fine enough.
        let mesh = if own.tolerance <= tolerance {
            own.clone()
        } else {
            Mesh::new(own.profile.clone(), own.motor, tolerance)?
        };
        Ok(TurnMap { mesh, torques, tolerance, first_energy, most_steps: MOST_STEPS, work })
    }

    /// The map backwards in time.
    pub fn backwards(&self) -> Self {
        TurnMap { torques: self.torques.backwards(), ..self.clone() }
    }

    fn forward(&self) -> bool {
        self.torques.sense > 0.0
    }

    /// The start of the turn with this energy.
    fn beginning(&self, energy: f64) -> Position {
        let cells = self.mesh.cells();
        let cell = if self.forward() { 0 } else { cells.len() - 1 };
        Position { energy: Double::from(energy), angle: cells[cell].entry(self.forward()), cell, ..Position::default() }
    }

    /// Follows the machine from the start of a turn with this energy. `most` sees every step and bounds the next one, or ends the
    /// journey. None if the machine comes to rest.
    fn travel(
        &self,
        energy: f64,
        mut most: impl FnMut(&Position, Option<&AngleStep>) -> Option<f64>,
    ) -> Option<AngleStep> {
        let mut steps = AngleSteps::new(self.torques, self.tolerance);
        let cost_of_table = TABLE + STAGES as f64 * self.mesh.profile.inertia.cost();
        let mut position = self.beginning(energy);
        let mut last: Option<AngleStep> = None;
        for _ in 0..self.most_steps {
            let Some(most) = most(&position, last.as_ref()) else { return last };
            let step = steps.pass(&self.mesh, position, last.as_ref(), most);
            let tables = steps.tables as f64 * cost_of_table;
            work::draw(self.work, cost_of_step(steps.evaluations) + tables)?;
            let step = step?;
            position = self.mesh.after(&step, self.torques.sense);
            if !(step.energy.hi > REST * energy) {
                return None;
            }
            last = Some(step);
        }
        None
    }

    /// A turn that begins with this energy; None if the machine comes to rest.
    pub fn shoot(&self, energy: f64) -> Option<Shot> {
        self.follow(energy, |_| ())
    }

    /// [`TurnMap::shoot`] with a `visit` to each step.
    pub fn follow(&self, energy: f64, mut visit: impl FnMut(&AngleStep)) -> Option<Shot> {
        let mut slope = 1.0;
        let end = self.travel(energy, |position, last| {
            if let Some(last) = last {
                slope *= last.slope();
                visit(last);
            }
            (position.turns == 0.0).then_some(f64::INFINITY)
        })?;
        let gain = (end.energy - Double::from(energy)).hi;
        Some(Shot { gain, slope, period: end.end.hi })
    }

    /// E at an angle (rad) of this interval on the motion that begins the turn with `energy`.
    pub fn energy_at(&self, energy: f64, (interval, angle): (usize, f64)) -> Option<Double> {
        let cell = self.mesh.find(interval, angle, self.forward());
        let ahead = |position: &Position| self.torques.sense * (angle - position.angle.hi);
        let end = self.travel(energy, |position, _| {
            let there = position.cell == cell && ahead(position) <= 0.0;
            (!there && position.turns == 0.0)
                .then(|| if position.cell == cell { ahead(position) } else { f64::INFINITY })
        });
        // At the very start there is no step to take.
        let beginning = self.beginning(energy);
        if beginning.cell == cell && ahead(&beginning) <= 0.0 { Some(beginning.energy) } else { Some(end?.energy) }
    }

    /// The brackets of the stable periodic motions, the fastest first, and the number of all periodic motions found.
    pub(super) fn scan(&self, energies: impl Iterator<Item = f64>) -> (Vec<(f64, f64)>, usize) {
        let mut stable = Vec::new();
        let mut motions = 0;
        let mut above: Option<(f64, f64)> = None;
        for energy in energies {
            // A machine that comes to rest has lost speed.
            let gain = self.shoot(energy).map_or(f64::NEG_INFINITY, |shot| shot.gain);
            if let Some((faster, gain_above)) = above {
                if gain >= 0.0 && gain_above < 0.0 {
                    stable.push((energy, faster));
                    motions += 1;
                } else if gain < 0.0 && gain_above >= 0.0 {
                    motions += 1;
                }
            }
            above = Some((energy, gain));
        }
        (stable, motions)
    }

    /// The fixed point between `low`, from which the machine speeds up, and `high`, from which it slows down, and the period.
    pub fn refine(&self, (mut low, mut high): (f64, f64)) -> Option<(f64, f64)> {
        let mut energy = self.first_energy.filter(|e| *e > low && *e < high).unwrap_or(0.5 * (low + high));
        let mut best = None;
        let mut before = None;
        for _ in 0..ITERATIONS {
            let Some(shot) = self.shoot(energy) else {
                low = energy;
                energy = 0.5 * (low + high);
                continue;
            };
            let Shot { gain, period, .. } = shot;
            best = Some((energy, period));
            if gain > 0.0 {
                low = energy;
            } else {
                high = energy;
            }
            let rise = shot.rise(energy, &mut before);
            let wanted = energy - gain / rise;
            // The rest is rounding, from which a secant would make a slope.
            if gain.abs() <= ROUNDING * energy {
                best = Some((if rise == 0.0 { energy } else { wanted }, period));
                break;
            }
            let next = if wanted > low && wanted < high { wanted } else { 0.5 * (low + high) };
            if (next - energy).abs() <= 4e-16 * energy {
                break;
            }
            energy = next;
        }
        best
    }
}
