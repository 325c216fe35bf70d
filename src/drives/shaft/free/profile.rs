//! J(φ) and J′(φ) from a table of polynomials that are exact to rounding.
//!
//! J costs a step and an output the same for any number of followers and harmonics. An interval between borders of the motion laws
//! is divided into equal pieces, so the piece follows from the angle without a search. An interval in which J falls to a small part
//! of its size would need many more pieces than the waves of J imply; it has no table, and the laws themselves are evaluated there.

use super::inertia::{IN_A_ROW, Inertia};
use crate::numerics::powers::{EVALUATIONS, Fitting, Powers};
use crate::numerics::work::note;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The width of a piece in which the polynomial of degree 15 follows a wave to rounding [rad of the wave]: the first
/// neglected coefficient is 2 (width/4)¹⁶/16!.
const PIECE_OF_WAVE: f64 = 2.6;

/// The most pieces of an interval as a multiple of the number that the waves need.
const EXCESS: usize = 4;

/// Tolerance of the polynomial, relative to J: the rounding of the laws.
const ROUNDING: f64 = 4e-15;

/// How far beyond the ends of an interval its polynomials are valid, as part of a piece: steps end there except for rounding.
const BEYOND: f64 = 1e-6;

/// The pieces of an interval.
struct Stretch {
    /// φ at its start (rad).
    low: f64,
    /// Pieces per radian.
    rate: f64,
    /// Number of pieces.
    count: i32,
    /// The first of them.
    first: usize,
}

/// The table.
#[derive(Default)]
pub struct Profile {
    /// The tabulated inertia.
    pub inertia: Arc<Inertia>,
    /// By interval; None without a table.
    stretches: Vec<Option<Stretch>>,
    /// Polynomials over x ∈ [−1, 1] (kg·m²).
    pieces: Vec<Powers>,
    /// Whether the only interval is the whole turn.
    turn: bool,
}

impl Profile {
    /// The table of `inertia`.
    pub fn new(inertia: Arc<Inertia>) -> Self {
        let (fitting, cost) = (Fitting::default(), IN_A_ROW * EVALUATIONS as f64 * inertia.cost());
        let turn = inertia.borders().is_empty();
        let mut profile = Profile { turn, inertia: inertia.clone(), ..Profile::default() };
        for (interval, (low, high)) in inertia.pieces().enumerate() {
            let wanted = ((high - low) * inertia.resolution() / PIECE_OF_WAVE).ceil().max(1.0) as usize;
            // Between borders laws often are polynomials: a single piece may be enough.
            let mut count = if turn { wanted } else { 1 };
            let first = profile.pieces.len();
            let met = loop {
                let width = (high - low) / count as f64;
                note(cost * count as f64);
                let met = (0..count).all(|i| profile.add(&fitting, interval, low + i as f64 * width, width));
                if met || 2 * count > EXCESS * wanted {
                    break met;
                }
                profile.pieces.truncate(first);
                count *= 2;
            };
            if !met {
                profile.pieces.truncate(first);
            }
            profile.stretches.push(met.then(|| Stretch {
                low,
                rate: count as f64 / (high - low),
                count: count as i32,
                first,
            }));
        }
        profile
    }

    /// Whether it is the table of this inertia.
    pub fn is_of(&self, inertia: &Inertia) -> bool {
        !self.stretches.is_empty() && *self.inertia == *inertia
    }

    /// Adds the piece of this `width` from `low` on; returns whether it is accurate.
    fn add(&mut self, fitting: &Fitting, interval: usize, low: f64, width: f64) -> bool {
        let place = self.inertia.place(interval);
        let (powers, mut misses) = fitting.over(low, width, |phi| self.inertia.value(place, phi));
        self.pieces.push(powers);
        // Comparisons with NaN are false.
        misses.all(|[j, missed]| missed <= ROUNDING * j)
    }

    /// The piece that holds `phi` and the position x in it.
    #[inline]
    fn piece(&self, interval: usize, phi: f64) -> Option<(&Powers, f64)> {
        let stretch = self.stretches.get(interval)?.as_ref()?;
        let phi = if self.turn && phi < 0.0 { phi + TAU } else { phi };
        let along = (phi - stretch.low) * stretch.rate;
        if !(along >= -BEYOND && along <= f64::from(stretch.count) + BEYOND) {
            return None;
        }
        let number = (along as i32).min(stretch.count - 1);
        Some((&self.pieces[stretch.first + number as usize], 2.0 * (along - f64::from(number)) - 1.0))
    }

    /// Whether the table holds `phi`.
    #[cfg(test)]
    pub fn holds(&self, interval: usize, phi: f64) -> bool {
        self.piece(interval, phi).is_some()
    }

    /// J (kg·m²) at `phi` (rad), continued smoothly from the interval.
    #[inline]
    pub fn value(&self, interval: usize, phi: f64) -> f64 {
        match self.piece(interval, phi) {
            Some((powers, x)) => powers.value(x),
            None => self.inertia.value(self.inertia.place(interval), phi),
        }
    }

    /// J (kg·m²) and J′ (kg·m²/rad) at `phi` (rad), continued smoothly from the interval.
    #[inline]
    pub fn with_slope(&self, interval: usize, phi: f64) -> [f64; 2] {
        let Some((powers, x)) = self.piece(interval, phi) else {
            let [j, slope, ..] = self.inertia.at(self.inertia.place(interval), phi);
            return [j, slope];
        };
        let [j, slope] = powers.with_slope(x);
        // dx/dφ is twice the number of pieces per radian.
        let rate = self.stretches[interval].as_ref().map_or(0.0, |stretch| stretch.rate);
        [j, 2.0 * rate * slope]
    }
}
