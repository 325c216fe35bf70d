//! The polynomial of degree 9 through the values of a function at the eight Gauss nodes and at both ends of a step.
//!
//! With the abscissa x ∈ [−1, 1] and the Legendre coefficients mₖ of the polynomial p₇ through the nodes,
//!
//! p(x) = p₇(x) + P₈(x) (α + β x),  α ± β = y(±1) − p₇(±1),
//!
//! since P₈ vanishes at the nodes. Its integral over the step is the Gauss rule's, exact to degree 15: the ends sharpen the
//! polynomial between the ends and leave the sum over many steps as it is.
//!
//! Source: E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., Springer 1996, section IV.5.

use super::gauss::{PROJECTION, STAGES, legendre_powers};
use serde::{Deserialize, Serialize};

/// The number of coefficients.
pub const COEFFICIENTS: usize = STAGES + 2;

/// The factor by which integration over the step diminishes the first neglected coefficient:
/// ∫P₁₀ = (P₁₁ − P₉)/21 over half the step.
pub const INTEGRATION: f64 = 21.0;

/// Half of them: the even or the odd powers.
const HALF: usize = COEFFICIENTS / 2;

/// Σ evenⱼ x²ʲ + x Σ oddⱼ x²ʲ; two sums side by side take half as long as one.
#[inline]
pub fn power_sum<const N: usize>(even: &[f64; N], odd: &[f64; N], x: f64) -> f64 {
    let square = x * x;
    let (mut even_sum, mut odd_sum) = (0.0, 0.0);
    for j in (0..N).rev() {
        even_sum = even_sum * square + even[j];
        odd_sum = odd_sum * square + odd[j];
    }
    even_sum + x * odd_sum
}

/// The columns of the projection, for sums of whole columns.
static PROJECTION_COLUMNS: [[f64; STAGES]; STAGES] = columns(&PROJECTION);

/// The coefficients of xʲ in P₀ … P₉.
static LEGENDRE: [[f64; COEFFICIENTS]; COEFFICIENTS] = legendre_powers(0.0);

/// The transposed matrix.
pub const fn columns(rows: &[[f64; STAGES]; STAGES]) -> [[f64; STAGES]; STAGES] {
    let mut columns = [[0.0; STAGES]; STAGES];
    let mut i = 0;
    while i < STAGES {
        let mut j = 0;
        while j < STAGES {
            columns[j][i] = rows[i][j];
            j += 1;
        }
        i += 1;
    }
    columns
}

/// Σⱼ `columns[j]` `f[j]`.
pub fn combine(columns: &[[f64; STAGES]; STAGES], f: &[f64; STAGES]) -> [f64; STAGES] {
    let mut sum = [0.0; STAGES];
    for j in 0..STAGES {
        for i in 0..STAGES {
            sum[i] += columns[j][i] * f[j];
        }
    }
    sum
}

/// The Legendre coefficients of the polynomial of degree 7 through the values at the nodes.
pub fn modes(nodes: &[f64; STAGES]) -> [f64; STAGES] {
    combine(&PROJECTION_COLUMNS, nodes)
}

/// Estimate of the first neglected coefficient: the larger of the last two, diminished once more by the decay over the two before.
/// It looks at pairs, since a function may be even or odd.
pub fn neglected(modes: &[f64]) -> f64 {
    let last = modes.len() - 1;
    decay(modes) * modes[last].abs().max(modes[last - 1].abs())
}

/// The ratio of the last two coefficients to the two before, at most 1.
pub fn decay(modes: &[f64]) -> f64 {
    let pair = |k: usize| modes[k].abs().max(modes[k - 1].abs());
    let (tail, before) = (pair(modes.len() - 1), pair(modes.len() - 3));
    if tail < before { tail / before } else { 1.0 }
}

/// The M > N Legendre coefficients of ∫₋₁ˣ p for a p with the coefficients `modes`: ∫ Pₖ = (Pₖ₊₁ − Pₖ₋₁)/(2 k + 1).
pub fn integrated<const N: usize, const M: usize>(modes: &[f64; N]) -> [f64; M] {
    let mut c = [0.0; M];
    (c[0], c[1]) = (modes[0], modes[0]);
    for k in 1..N {
        let part = modes[k] / (2 * k + 1) as f64;
        c[k + 1] += part;
        c[k - 1] -= part;
    }
    c
}

/// p(x) = Σ cⱼ xʲ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Interpolant {
    even: [f64; HALF],
    odd: [f64; HALF],
}

/// 1/(j + 1) for even and odd powers j.
static EVEN_QUOTIENTS: [f64; HALF] = [1.0, 1.0 / 3.0, 1.0 / 5.0, 1.0 / 7.0, 1.0 / 9.0];
static ODD_QUOTIENTS: [f64; HALF] = [1.0 / 2.0, 1.0 / 4.0, 1.0 / 6.0, 1.0 / 8.0, 1.0 / 10.0];

impl Interpolant {
    /// The Legendre coefficients of the polynomial through the values at the nodes and at x = −1 and x = 1.
    pub fn modes_through(nodes: &[f64; STAGES], ends: [f64; 2]) -> [f64; COEFFICIENTS] {
        let m = modes(nodes);
        let even: f64 = m.iter().step_by(2).sum();
        let odd: f64 = m.iter().skip(1).step_by(2).sum();
        let (low, high) = (ends[0] - (even - odd), ends[1] - (even + odd));
        let (alpha, beta) = (0.5 * (high + low), 0.5 * (high - low));
        let mut c = [0.0; COEFFICIENTS];
        c[..STAGES].copy_from_slice(&m);
        // x P₈ = (9 P₉ + 8 P₇) / 17.
        c[STAGES - 1] += beta * (8.0 / 17.0);
        c[STAGES] = alpha;
        c[STAGES + 1] = beta * (9.0 / 17.0);
        c
    }

    /// The polynomial with these Legendre coefficients.
    pub fn new(modes: &[f64; COEFFICIENTS]) -> Self {
        let mut p = Interpolant::default();
        for k in 0..HALF {
            for j in 0..=k {
                p.even[j] += LEGENDRE[2 * k][2 * j] * modes[2 * k];
                p.odd[j] += LEGENDRE[2 * k + 1][2 * j + 1] * modes[2 * k + 1];
            }
        }
        p
    }

    /// p(x).
    #[inline]
    pub fn value(&self, x: f64) -> f64 {
        power_sum(&self.even, &self.odd, x)
    }

    /// p(x) and ∫₀ˣ p.
    #[inline]
    pub fn with_integral(&self, x: f64) -> [f64; 2] {
        let square = x * x;
        let (mut even, mut odd, mut even_sum, mut odd_sum) = (0.0, 0.0, 0.0, 0.0);
        for j in (0..HALF).rev() {
            even = even * square + self.even[j];
            odd = odd * square + self.odd[j];
            even_sum = even_sum * square + self.even[j] * EVEN_QUOTIENTS[j];
            odd_sum = odd_sum * square + self.odd[j] * ODD_QUOTIENTS[j];
        }
        [even + x * odd, x * (even_sum + x * odd_sum)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::gauss::ABSCISSAE;

    #[test]
    fn the_polynomial_and_its_integral_are_exact_to_degree_nine() {
        for n in 0..10 {
            let nodes = ABSCISSAE.map(|x| x.powi(n));
            let p = Interpolant::new(&Interpolant::modes_through(&nodes, [(-1.0f64).powi(n), 1.0]));
            for x in [-1.0, -0.7, 0.0, 0.3, 1.0f64] {
                let [value, integral] = p.with_integral(x);
                assert!((value - x.powi(n)).abs() < 1e-14, "x^{n} at {x}: {value}");
                assert_eq!(value, p.value(x));
                if n < STAGES as i32 {
                    let from_end = Interpolant::new(&integrated(&modes(&nodes))).value(x);
                    let exact = (x.powi(n + 1) - (-1.0f64).powi(n + 1)) / f64::from(n + 1);
                    assert!((from_end - exact).abs() < 1e-14, "∫ x^{n} from -1 to {x}: {from_end}");
                }
                assert!((integral - x.powi(n + 1) / f64::from(n + 1)).abs() < 1e-15, "∫ x^{n} to {x}: {integral}");
            }
        }
    }

    #[test]
    fn the_neglected_coefficient_goes_on_like_those_before() {
        for parity in [None, Some(0), Some(1)] {
            let c = |k: usize| if parity.is_none_or(|parity| k % 2 == parity) { -0.1_f64.powi(k as i32) } else { 0.0 };
            let modes: [f64; 8] = std::array::from_fn(c);
            assert!((decay(&modes) / 0.01 - 1.0).abs() < 1e-12, "{parity:?}");
            let last = if parity == Some(1) { c(7) } else { c(6) };
            assert!((neglected(&modes) / (0.01 * last.abs()) - 1.0).abs() < 1e-12, "{parity:?}");
        }
        // A growing sequence is not extrapolated as growing.
        assert_eq!((decay(&[1.0, 2.0, 4.0, 8.0]), neglected(&[1.0, 2.0, 4.0, -8.0])), (1.0, 8.0));
    }

    #[test]
    fn the_neglected_part_of_a_smooth_function_is_told() {
        // 1/(2 − x) has the Legendre coefficients (2k + 1) Q_k(2); its error shrinks by 2 + √3 per degree.
        let f = |x: f64| 1.0 / (2.0 - x);
        let c = Interpolant::modes_through(&ABSCISSAE.map(f), [f(-1.0), f(1.0)]);
        let p = Interpolant::new(&c);
        let error = (0..=100).map(|i| 0.02 * f64::from(i) - 1.0).map(|x| (p.with_integral(x)[0] - f(x)).abs());
        let (error, told) = (error.fold(0.0, f64::max), neglected(&c));
        assert!(error <= 3.0 * told && told <= 30.0 * error, "{error:e} {told:e}");
    }
}
