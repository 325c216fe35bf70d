//! Collocation at the eight Radau nodes of the right end, computed at compile time: of order 15, and what is stiff is right at the end of
//! a step, which is a node.
//!
//! Source: E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., Springer 1996, section IV.5 (Radau IIA); the nodes
//! are the roots of P₈ − P₇, computed to 60 digits, their weights (1 + x)/(8 P₇(x))².

use super::gauss::{STAGES, halves, integral_of, projection_of};

/// The nodes on [−1, 1] and their weights.
const RULE: ([f64; STAGES], [f64; STAGES]) = (
    [
        -0.9550412271225750037823,
        -0.7706418936781915361807,
        -0.4684203544308210630464,
        -0.0943072526611107660029,
        0.2947505657736607252522,
        0.6395186165262152700248,
        0.8874748789261557070687,
        1.0,
    ],
    [
        0.1145088147442571993424,
        0.2496479013298649632579,
        0.3470147956345012802287,
        0.3915721674524935930825,
        0.3765175453891185565721,
        0.3041306206467851289757,
        0.1853581548029792785407,
        0.03125,
    ],
);

/// The fractions θᵢ of a step.
pub static NODES: [f64; STAGES] = {
    let mut nodes = halves([RULE.0])[0];
    let mut i = 0;
    while i < STAGES {
        nodes[i] += 0.5;
        i += 1;
    }
    nodes
};

/// aᵢⱼ = ∫₀^θᵢ ℓⱼ dθ.
pub static MATRIX: [[f64; STAGES]; STAGES] = halves(integral_of(RULE));

/// Σₖ aᵢₖ aₖⱼ.
pub static SQUARE: [[f64; STAGES]; STAGES] = {
    let (a, mut square) = (halves(integral_of(RULE)), [[0.0; STAGES]; STAGES]);
    let mut n = 0;
    while n < STAGES * STAGES * STAGES {
        let (i, j, k) = (n / (STAGES * STAGES), n / STAGES % STAGES, n % STAGES);
        square[i][j] += a[i][k] * a[k][j];
        n += 1;
    }
    square
};

/// The coefficients mₖ = Σ `PROJECTION[k][j]` fⱼ of Σ mₖ Pₖ(x), the polynomial through the fⱼ.
pub static PROJECTION: [[f64; STAGES]; STAGES] = projection_of(RULE);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rule_is_exact_to_degree_14() {
        for n in 0..15 {
            let sum: f64 = (0..STAGES).map(|i| 0.5 * RULE.1[i] * NODES[i].powi(n)).sum();
            assert!((sum - 1.0 / f64::from(n + 1)).abs() < 3e-16, "degree {n}: {sum}");
        }
        let sum: f64 = (0..STAGES).map(|i| 0.5 * RULE.1[i] * NODES[i].powi(15)).sum();
        assert!((sum - 1.0 / 16.0).abs() > 1e-11);
    }

    #[test]
    fn the_stages_integrate_polynomials_to_degree_7() {
        for n in 0..8 {
            for i in 0..STAGES {
                let sum: f64 = (0..STAGES).map(|j| MATRIX[i][j] * NODES[j].powi(n)).sum();
                assert!((sum - NODES[i].powi(n + 1) / f64::from(n + 1)).abs() < 3e-16, "degree {n}, stage {i}");
            }
        }
    }

    #[test]
    fn the_coefficients_are_those_of_the_polynomial_through_the_values() {
        for k in 0..STAGES {
            // P₃ = (5 x³ − 3 x)/2 has the third alone.
            let sum: f64 = (0..STAGES)
                .map(|j| {
                    let x = 2.0 * NODES[j] - 1.0;
                    PROJECTION[k][j] * (2.5 * x * x * x - 1.5 * x)
                })
                .sum();
            assert!((sum - if k == 3 { 1.0 } else { 0.0 }).abs() < 1e-14, "{k}: {sum}");
        }
    }
}
