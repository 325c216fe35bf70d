//! Length of the next step.

use super::STAGES;

/// The step to take of the `remaining` interval if `h` is wished for: no sliver is left over.
pub fn fit(h: f64, remaining: f64) -> f64 {
    if h >= 0.999 * remaining {
        remaining
    } else if h > 0.5 * remaining {
        0.5 * remaining
    } else {
        h
    }
}

/// The factor for the length of a step after this error: the estimate goes with h⁹ or faster. Aiming at a seventh of the tolerance
/// (0.8⁹) makes rejections rare.
pub fn growth(error: f64, tolerance: f64) -> f64 {
    (0.8 * (tolerance / error.max(1e-300)).powf(1.0 / (STAGES + 1) as f64)).clamp(0.2, 5.0)
}

/// A first step from the Jacobian J: the diagonal of J² has the unit of a squared rate whatever the units of the state. Without any
/// rate the step has no limit.
pub fn first_step<const N: usize>(jacobian: &[[f64; N]; N]) -> f64 {
    let square = |i: usize| (0..N).map(|j| jacobian[i][j] * jacobian[j][i]).sum::<f64>().abs();
    // The bound keeps an infinite rate from making the step zero.
    (0..N).map(square).fold(0.0, f64::max).sqrt().min(1e150).recip()
}
