//! The twelve Gauss nodes on [−1, 1] and their matrices, computed at compile time.

use crate::numerics::gauss::{integral, legendre, legendre_powers, projection, rule};
use crate::numerics::interpolant::integrated;

/// The number of nodes.
pub const STAGES: usize = 12;

/// The nodes, ascending.
pub static ABSCISSAE: [f64; STAGES] = rule().0;

/// The weights; their sum is 2.
pub static WEIGHTS: [f64; STAGES] = rule().1;

/// S₁ᵢⱼ = ∫₋₁^xᵢ ℓⱼ dx: the integral of the polynomial through fⱼ up to the node xᵢ.
pub static INTEGRAL: [[f64; STAGES]; STAGES] = integral();

/// S₁²: the same integral of that integral, interpolated at the nodes.
pub static SECOND_INTEGRAL: [[f64; STAGES]; STAGES] = second_integral();

/// The coefficients mₖ = Σ `PROJECTION[k][j]` fⱼ of Σ mₖ Pₖ(x), the polynomial through the fⱼ.
pub static PROJECTION: [[f64; STAGES]; STAGES] = projection();

/// The derivative of the polynomial through fⱼ at the node xᵢ.
pub static DERIVATIVE: [[f64; STAGES]; STAGES] = derivative();

/// P₀ … P₁₂ in powers of x.
pub static LEGENDRE: [[f64; STAGES + 1]; STAGES + 1] = legendre_powers(0.0);

/// The Legendre polynomials in powers of 1 + x, which is small next to the start of a cell.
pub static LEGENDRE_FROM_START: [[f64; STAGES + 1]; STAGES + 1] = legendre_powers(1.0);

/// The Legendre coefficients of `start` + `half` ∫₋₁^x Σ mₖ Pₖ.
pub fn integrate(modes: &[f64; STAGES], start: f64, half: f64) -> [f64; STAGES + 1] {
    let mut integral = integrated(modes).map(|c| half * c);
    integral[0] += start;
    integral
}

const fn derivative() -> [[f64; STAGES]; STAGES] {
    let (x, m): ([f64; STAGES], [[f64; STAGES]; STAGES]) = (rule().0, projection());
    let mut d = [[0.0; STAGES]; STAGES];
    let mut i = 0;
    while i < STAGES {
        let p: [f64; STAGES] = legendre(x[i]);
        // P′ₖ₊₁ = P′ₖ₋₁ + (2 k + 1) Pₖ.
        let mut slope = [0.0; STAGES];
        slope[1] = 1.0;
        let mut k = 1;
        while k + 1 < STAGES {
            slope[k + 1] = slope[k - 1] + (2 * k + 1) as f64 * p[k];
            k += 1;
        }
        let mut j = 0;
        while j < STAGES {
            let mut k = 1;
            while k < STAGES {
                d[i][j] += slope[k] * m[k][j];
                k += 1;
            }
            j += 1;
        }
        i += 1;
    }
    d
}

const fn second_integral() -> [[f64; STAGES]; STAGES] {
    let s: [[f64; STAGES]; STAGES] = integral();
    let mut square = [[0.0; STAGES]; STAGES];
    let mut i = 0;
    while i < STAGES {
        let mut j = 0;
        while j < STAGES {
            let mut k = 0;
            while k < STAGES {
                square[i][j] += s[i][k] * s[k][j];
                k += 1;
            }
            j += 1;
        }
        i += 1;
    }
    square
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quadrature_is_exact_to_degree_23() {
        for n in 0..24 {
            let sum: f64 = (0..STAGES).map(|i| WEIGHTS[i] * ABSCISSAE[i].powi(n)).sum();
            let exact = if n % 2 == 0 { 2.0 / f64::from(n + 1) } else { 0.0 };
            assert!((sum - exact).abs() < 4e-16, "degree {n}: {sum}");
        }
    }

    #[test]
    fn integrals_and_powers_of_a_polynomial_are_exact() {
        for n in 0..STAGES as i32 {
            let f = ABSCISSAE.map(|x| (1.0 + x).powi(n));
            for i in 0..STAGES {
                let once: f64 = (0..STAGES).map(|j| INTEGRAL[i][j] * f[j]).sum();
                let x = 1.0 + ABSCISSAE[i];
                let scale = 2f64.powi(n + 1);
                assert!((once - x.powi(n + 1) / f64::from(n + 1)).abs() < 1e-15 * scale, "degree {n}, node {i}");
                if n + 1 < STAGES as i32 {
                    let twice: f64 = (0..STAGES).map(|j| SECOND_INTEGRAL[i][j] * f[j]).sum();
                    let exact = x.powi(n + 2) / f64::from((n + 1) * (n + 2));
                    assert!((twice - exact).abs() < 2e-15 * scale, "degree {n}, node {i}");
                }
            }
            // Through the Legendre coefficients back to powers: (1 + x)ⁿ has the binomial coefficients.
            let mut binomial = 1.0;
            for j in 0..=n {
                let power: f64 = (0..STAGES)
                    .map(|k| {
                        let m: f64 = (0..STAGES).map(|i| PROJECTION[k][i] * f[i]).sum();
                        m * LEGENDRE[k][j as usize]
                    })
                    .sum();
                assert!((power - binomial).abs() < 1e-12 * scale_of(n), "degree {n}, power {j}: {power}");
                binomial *= f64::from(n - j) / f64::from(j + 1);
            }
        }
    }

    /// Loss of the conversion to powers: the largest power of a Legendre polynomial of degree 11.
    fn scale_of(n: i32) -> f64 {
        2f64.powi(n)
    }
}
