//! Result of a solved step: its polynomial and its errors.

use super::ROUNDING;
use super::newton::Newton;
use crate::numerics::gauss::{NOISE_OF_MODES, PROJECTION, STAGES};

/// A solved step.
pub struct Solution<const N: usize> {
    /// Legendre coefficients of ẏ.
    pub modes: [[f64; N]; STAGES],
    /// Magnitudes to which errors are relative.
    pub scale: [f64; N],
    /// Estimated error of the polynomial relative to the scale.
    pub error: f64,
    /// See [`super::Collocation::end_error`].
    pub ends: [f64; N],
    /// Error that the end adds to each component.
    pub own: [f64; N],
    /// ∂y₁/∂y₀.
    pub map: [[f64; N]; N],
}

/// The Legendre coefficients of ẏ and the error that follows from their decay.
///
/// The first neglected coefficient m₈ would add about h m₈/17 to the polynomial. The larger of the last two coefficients is m₆ if
/// all or only the even ones are present, so m₈ is estimated as that, diminished once more by the decay over the two orders before.
/// Rounding of f in a coefficient is no error of the polynomial, and no shorter step would remove it.
pub fn solution<const N: usize>(
    f: [[f64; N]; STAGES],
    scale: [f64; N],
    newton: &Newton<N>,
    h: f64,
    remainder: [f64; N],
) -> Solution<N> {
    let noise = newton.noise(&scale);
    let modes: [[f64; N]; STAGES] =
        std::array::from_fn(|k| std::array::from_fn(|c| (0..STAGES).map(|j| PROJECTION[k][j] * f[j][c]).sum()));
    let pair = |k: usize, c: usize| modes[k][c].abs().max(modes[k - 1][c].abs());
    let (mut ends, mut own) = ([0.0; N], [0.0; N]);
    let response = response(0.5 * h * newton.rate());
    let error = (0..N)
        .map(|c| {
            let tail = (pair(STAGES - 1, c) - NOISE_OF_MODES * noise[c]).max(0.0);
            let before = pair(STAGES - 3, c);
            let decay = if tail < before { tail / before } else { 1.0 };
            // A pair is two orders: the error of the end is four pairs further.
            ends[c] = h * tail * decay.powi(STAGES as i32 / 2) + remainder[c] * scale[c];
            // The end errs by m₈ times the coefficient of order 8 of the response to an impulse within the step. This response
            // decays like the motion or, if it is faster, like the free motion.
            own[c] = h * tail * decay * response + remainder[c].max(ROUNDING) * scale[c];
            h * tail * decay / (2 * STAGES + 1) as f64 / scale[c]
        })
        .fold(0.0, f64::max);
    // The polynomial has order 9 and the end order 16.
    let power = error.powf((2 * STAGES) as f64 / (STAGES + 1) as f64);
    for c in 0..N {
        own[c] += power * scale[c];
    }
    Solution { modes, scale, error, ends, own, map: newton.map(h) }
}

/// About the Legendre coefficient of order 8 of e^(xξ), ξ ∈ [−1, 1], less its growth: x⁸/17!! for small x.
fn response(x: f64) -> f64 {
    const ODD_FACTORIAL: f64 = 34_459_425.0;
    let power = x.powi(STAGES as i32) / ODD_FACTORIAL;
    power / (1.0 + power)
}

/// The largest part of all components.
pub fn largest(parts: &[f64]) -> f64 {
    parts.iter().copied().fold(0.0, f64::max)
}

/// The sum of the remaining corrections if the last one was `size` and `rate` times the previous one. Corrections that `rounding`
/// alone may have made do not contract: two of almost the same size do not announce a long series.
pub fn remainder(size: f64, rate: f64, rounding: impl FnOnce() -> f64) -> f64 {
    let rest = if rate < 1.0 { size * rate / (1.0 - rate) } else { size };
    if rest > size && size <= rounding() { size } else { rest }
}

/// The remainder if each correction has its own matrix: Newton's method converges quadratically, sⱼ₊₁ = K sⱼ², so that the ratios
/// of the corrections are squared from one to the next.
pub fn remainder_of_newton(size: f64, rate: f64) -> f64 {
    // After this many squarings any number below 1 is negligible.
    const TERMS: usize = 60;
    if !(rate < 1.0) {
        return size;
    }
    let (mut sum, mut correction, mut ratio) = (0.0, size, rate);
    for _ in 0..TERMS {
        ratio *= ratio;
        correction *= ratio;
        sum += correction;
        if correction <= f64::EPSILON * sum {
            break;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_of_a_contraction() {
        // 1/2 + 1/4 + …, and twice the same by chance at the size of roundings.
        assert_eq!(remainder(1.0, 0.5, || 0.0), 1.0);
        assert_eq!((remainder(1e-9, 0.999999, || 1e-8), remainder(1e-9, 2.0, || 0.0)), (1e-9, 1e-9));
        assert!(remainder(1e-9, 0.999999, || 1e-10) > 1e-4);
        // s = 1/4, 1/16, 1/256 … after 1/2: K = 1, the ratio of the first two is 1/2.
        let expected = 1.0 / 16.0 + 1.0 / 256.0 + 1.0 / 65536.0;
        assert!((remainder_of_newton(0.25, 0.5) - expected).abs() < 1e-9);
        assert!(remainder_of_newton(1.0, 1.0 - 1e-9) < 40.0 && remainder_of_newton(0.1, f64::NAN) == 0.1);
    }
}
