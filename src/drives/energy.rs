//! The balance of energy: what the steps of a solver add to the energy of a drive beyond the work done on it.
//!
//! r = |Σ (ΔE − W)| / max E
//!
//! Symbols: ΔE growth of the energy and W work, losses taken off, of a step \[J\]; max E the largest energy so far \[J\]. W is
//! integrated apart from the motion, so that r tells of the errors of the motion. A drive that has no energy has no
//! residual either: r = 0.

use super::variable::real;
use super::{List, unit};
use crate::numerics::quadrature::Gauss;
use serde::{Deserialize, Serialize};

/// The balance so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Balance {
    /// Σ (ΔE − W) [J].
    missing: f64,
    /// max E [J].
    largest: f64,
}

impl Balance {
    /// Adds steps that miss the balance by `missing`, between states of these energies [J].
    #[inline]
    pub fn add(&mut self, missing: f64, energies: [f64; 2]) {
        self.missing += missing;
        self.largest = energies.into_iter().fold(self.largest, f64::max);
    }

    /// r.
    pub fn residual(&self) -> f64 {
        if self.largest > 0.0 { self.missing.abs() / self.largest } else { 0.0 }
    }
}

/// Energy [J], power of what it comes from and goes to [W], and the rate of that power [W/s] at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balanced {
    /// E.
    pub energy: f64,
    /// dE/dt by the forces.
    pub power: f64,
    /// d²E/dt².
    pub power_rate: f64,
}

/// The angle of the fastest wave over which a motion that is known at any instant is looked at, five of its periods, and
/// the part of it for each of the quadratures: the power has waves of twice the rate, and a rule with 16 nodes
/// integrates 16 rad of a wave to (16/4)³²/32! = 1e-16.
const STRETCH: f64 = 32.0;
const PANEL: f64 = 8.0;

/// r over the end of a motion that is known `from` an instant `to` the present one [s], whose fastest wave has this `rate`
/// [rad/s]. Just after a start from rest the energy itself is of the size of roundings; what the power moves within a
/// radian of that wave, |dE/dt|/rate, then takes its place.
pub fn residual_at_last([from, to]: [f64; 2], rate: f64, at: impl Fn(f64) -> Balanced) -> f64 {
    let from = from.max(to - STRETCH / rate);
    let panels = ((to - from) * rate / PANEL).ceil().max(1.0);
    let length = (to - from) / panels;
    let (before, after) = (at(from).energy, at(to).energy);
    let mut largest = before.max(after);
    let mut work = 0.0;
    for panel in 0..panels as usize {
        let [part] = Gauss::with(16).integrate(length, |within| {
            let elapsed = panel as f64 * length + within;
            let time = from + elapsed;
            let now = at(time);
            largest = largest.max(now.energy).max(now.power.abs() / rate);
            // What the rounding of the instant, which is large after many turns, makes of the power.
            [now.power + now.power_rate * (elapsed - (time - from))]
        });
        work += part;
    }
    Balance { missing: after - before - work, largest }.residual()
}

/// Declares r as `solver.energy_residual`, for the steps that `which` names.
pub fn declare<D>(list: &mut List<D>, which: &str, residual: fn(&D, usize) -> f64) {
    let text = format!("Part of the largest energy by which {which} misses the balance of energy");
    list.local("solver.energy_residual", &text, real(&unit::NUMBER), residual);
}
