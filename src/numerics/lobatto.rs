//! Lobatto quadrature with ten points on a step, computed at compile time: the ends and eight points between those of the
//! collocation ([`super::gauss`]). It is exact up to the degree 17, and so sees what the collocation misses.
//!
//! Source: M. Abramowitz, I. A. Stegun, *Handbook of Mathematical Functions*, section 25.4.32.

use super::gauss::{STAGES, integrals_up_to};

/// The points between the ends.
pub const INNER: usize = 8;

/// The positive zeros of P₉′ and their weights.
const HALF: [(f64, f64); INNER / 2] = [
    (0.165_278_957_666_387_02, 0.327_539_761_183_897_46),
    (0.477_924_949_810_444_5, 0.292_042_683_679_683_76),
    (0.738_773_865_105_505_1, 0.224_889_342_063_126_45),
    (0.919_533_908_166_458_8, 0.133_305_990_851_070_11),
];

/// The weight of each end for a step of length one.
pub const END_WEIGHT: f64 = 1.0 / 90.0;

/// The inner points xᵢ, ascending.
pub static ABSCISSAE: [f64; INNER] = abscissae();

/// Their weights for a step of length one.
pub static WEIGHTS: [f64; INNER] = weights();

/// bᵢⱼ = ∫₀^θᵢ ℓⱼ dθ up to the inner points, as [`super::gauss::MATRIX`] up to those of the collocation.
pub static MATRIX: [[f64; STAGES]; INNER] = integrals_up_to(abscissae());

const fn abscissae() -> [f64; INNER] {
    let mut x = [0.0; INNER];
    let mut i = 0;
    while i < INNER / 2 {
        x[INNER / 2 + i] = HALF[i].0;
        x[INNER / 2 - 1 - i] = -HALF[i].0;
        i += 1;
    }
    x
}

const fn weights() -> [f64; INNER] {
    let mut b = [0.0; INNER];
    let mut i = 0;
    while i < INNER / 2 {
        b[INNER / 2 + i] = HALF[i].1 / 2.0;
        b[INNER / 2 - 1 - i] = HALF[i].1 / 2.0;
        i += 1;
    }
    b
}

#[cfg(test)]
mod tests {
    use super::super::gauss;
    use super::*;

    #[test]
    fn the_quadrature_is_exact_to_degree_17() {
        let theta = |i: usize| 0.5 * (1.0 + ABSCISSAE[i]);
        let rule = |n: i32| {
            let ends = END_WEIGHT * (1.0 + 0.0f64.powi(n));
            ends + (0..INNER).map(|i| WEIGHTS[i] * theta(i).powi(n)).sum::<f64>()
        };
        for n in 0..18 {
            assert!((rule(n) - 1.0 / f64::from(n + 1)).abs() < 3e-16, "degree {n}: {}", rule(n));
        }
        assert!((rule(18) - 1.0 / 19.0).abs() > 1e-12);
        // The Gauss rule misses the degree 16.
        let gauss: f64 = (0..STAGES).map(|i| gauss::WEIGHTS[i] * (0.5 * (1.0 + gauss::ABSCISSAE[i])).powi(16)).sum();
        assert!((gauss - 1.0 / 17.0).abs() > 1e-11);
    }

    #[test]
    fn the_integrals_are_exact_to_degree_7() {
        let theta = |x: f64| 0.5 * (1.0 + x);
        for n in 0..8 {
            for i in 0..INNER {
                let sum: f64 = (0..STAGES).map(|j| MATRIX[i][j] * theta(gauss::ABSCISSAE[j]).powi(n)).sum();
                let exact = theta(ABSCISSAE[i]).powi(n + 1) / f64::from(n + 1);
                assert!((sum - exact).abs() < 3e-16, "degree {n}, point {i}");
            }
        }
    }
}
