//! Angles at which a range is looked at.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The density of samples of a condition.
#[derive(Clone, Copy)]
pub struct Density {
    /// Samples per shortest wave.
    per_wave: f64,
    /// Samples per unknown function: in a range much shorter than a wave the error is like a polynomial that has as
    /// many extremes as there are functions.
    per_function: usize,
}

/// For the extremes: between two samples a wave deviates from its parabola by less than 1e-4 of its height.
pub const FINE: Density = Density { per_wave: 48.0, per_function: 8 };

/// For the extremes of series in plain numbers, which Newton's method refines: between two samples a wave is at most 2 %
/// higher, an error in a short range 6 %.
pub const MEDIUM: Density = Density { per_wave: 16.0, per_function: 5 };

/// For the first program and the change of coordinates.
pub const COARSE: Density = Density { per_wave: 12.0, per_function: 2 };

/// Accuracy of the angles of a task (rad): degrees of some turns, converted, to a few roundings of 4π.
pub const ANGLES: f64 = 32.0 * f64::EPSILON;

/// `phi` plus the turns that lead into a range, if any do; a rounding outside of it is its end.
pub fn within(from: f64, to: f64, phi: f64) -> Option<f64> {
    let inside = from + (phi - from + ANGLES).rem_euclid(TAU) - ANGLES;
    (inside <= to + ANGLES).then(|| inside.clamp(from, to))
}

/// Samples of a range for the waves up to harmonic `order`: denser towards the ends, as the extremes are.
pub fn angles(from: f64, to: f64, order: usize, density: Density) -> Vec<f64> {
    let waves = order.max(1) as f64 * (to - from) / TAU;
    // The samples cos jπ/n are up to π/2 times as far apart as equally spaced ones.
    let last = (FRAC_PI_2 * density.per_wave * waves).ceil() as usize + density.per_function * (2 * order + 1);
    let at = |j: usize| match j {
        0 => from,
        j if j == last => to,
        j => 0.5 * (from + to) - 0.5 * (to - from) * (PI * j as f64 / last as f64).cos(),
    };
    (0..=last).map(at).collect()
}
