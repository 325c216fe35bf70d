//! Gauss–Legendre quadrature and collocation on one step, computed at compile time from nodes and weights.
//!
//! The abscissa x ∈ [−1, 1] belongs to the fraction θ = (1 + x)/2 of the step.
//! Source: E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., Springer 1996, sections
//! IV.5 and II.1.

/// The number of nodes s; the collocation method has order 2 s = 16.
pub const STAGES: usize = 8;

/// The positive zeros of the Legendre polynomial P₈ and their weights.
pub(super) const HALF: [(f64, f64); STAGES / 2] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_361_98),
    (0.525_532_409_916_328_99, 0.313_706_645_877_887_29),
    (0.796_666_477_413_626_74, 0.222_381_034_453_374_47),
    (0.960_289_856_497_536_23, 0.101_228_536_290_376_26),
];

/// The nodes xᵢ, ascending.
pub static ABSCISSAE: [f64; STAGES] = abscissae();

/// The weights bᵢ for a step of length one; their sum is 1.
pub static WEIGHTS: [f64; STAGES] = weights();

/// aᵢⱼ = ∫₀^θᵢ ℓⱼ dθ: the stages are yᵢ = y₀ + h Σ aᵢⱼ fⱼ.
pub static MATRIX: [[f64; STAGES]; STAGES] = matrix();

/// The coefficients mₖ = Σ PROJECTION[k][j] fⱼ of Σ mₖ Pₖ(x), the polynomial through the fⱼ.
pub static PROJECTION: [[f64; STAGES]; STAGES] = projection();

const fn abscissae() -> [f64; STAGES] {
    let mut x = [0.0; STAGES];
    let mut i = 0;
    while i < STAGES / 2 {
        x[STAGES / 2 + i] = HALF[i].0;
        x[STAGES / 2 - 1 - i] = -HALF[i].0;
        i += 1;
    }
    x
}

const fn weights() -> [f64; STAGES] {
    let mut b = [0.0; STAGES];
    let mut i = 0;
    while i < STAGES / 2 {
        b[STAGES / 2 + i] = HALF[i].1 / 2.0;
        b[STAGES / 2 - 1 - i] = HALF[i].1 / 2.0;
        i += 1;
    }
    b
}

/// P₀ … P_s at x.
pub const fn legendre(x: f64) -> [f64; STAGES + 1] {
    let mut p = [1.0; STAGES + 1];
    p[1] = x;
    let mut k = 1;
    while k < STAGES {
        let n = k as f64;
        p[k + 1] = ((2.0 * n + 1.0) * x * p[k] - n * p[k - 1]) / (n + 1.0);
        k += 1;
    }
    p
}

/// The coefficients of xʲ in Pₖ, row by row; up to the degree 9 each is a sum of few exact quotients.
pub(super) const fn legendre_coefficients() -> [[f64; STAGES + 2]; STAGES + 2] {
    let mut p = [[0.0; STAGES + 2]; STAGES + 2];
    p[0][0] = 1.0;
    p[1][1] = 1.0;
    let mut k = 1;
    while k <= STAGES {
        let n = k as f64;
        let mut j = 0;
        while j <= k + 1 {
            let raised = if j > 0 { (2.0 * n + 1.0) * p[k][j - 1] } else { 0.0 };
            p[k + 1][j] = (raised - n * p[k - 1][j]) / (n + 1.0);
            j += 1;
        }
        k += 1;
    }
    p
}

/// ∫₀^θ Pₖ dθ for k = 0 … s − 1 at x = 2 θ − 1; 1 for k = 0 and 0 else at the end of the step.
pub const fn legendre_integrals(x: f64) -> [f64; STAGES] {
    let p = legendre(x);
    let mut integrals = [0.5 * (1.0 + x); STAGES];
    let mut k = 1;
    while k < STAGES {
        integrals[k] = (p[k + 1] - p[k - 1]) / (2.0 * (2 * k + 1) as f64);
        k += 1;
    }
    integrals
}

/// The coefficients of θʲ in ∫₀^θ Pₖ dθ, row by row: (−1)^(k+i) C(k, i) C(k+i, i)/(i + 1) for j = i + 1.
pub static INTEGRALS_IN_POWERS: [[f64; STAGES + 1]; STAGES] = integrals_in_powers();

const fn integrals_in_powers() -> [[f64; STAGES + 1]; STAGES] {
    let mut powers = [[0.0; STAGES + 1]; STAGES];
    let mut k = 0;
    while k < STAGES {
        let mut coefficient = if k % 2 == 0 { 1.0 } else { -1.0 };
        let mut i = 0;
        while i <= k {
            powers[k][i + 1] = coefficient / (i + 1) as f64;
            // The products are whole numbers, and so are the quotients.
            coefficient = -coefficient * ((k - i) * (k + i + 1)) as f64 / ((i + 1) * (i + 1)) as f64;
            i += 1;
        }
        k += 1;
    }
    powers
}

const fn projection() -> [[f64; STAGES]; STAGES] {
    let (x, b) = (abscissae(), weights());
    let mut m = [[0.0; STAGES]; STAGES];
    let mut j = 0;
    while j < STAGES {
        let p = legendre(x[j]);
        let mut k = 0;
        while k < STAGES {
            m[k][j] = (2 * k + 1) as f64 * b[j] * p[k];
            k += 1;
        }
        j += 1;
    }
    m
}

const fn matrix() -> [[f64; STAGES]; STAGES] {
    let (x, m) = (abscissae(), projection());
    let mut a = [[0.0; STAGES]; STAGES];
    let mut i = 0;
    while i < STAGES {
        let integrals = legendre_integrals(x[i]);
        let mut j = 0;
        while j < STAGES {
            let mut k = 0;
            while k < STAGES {
                a[i][j] += integrals[k] * m[k][j];
                k += 1;
            }
            j += 1;
        }
        i += 1;
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quadrature_is_exact_to_degree_15() {
        for n in 0..16 {
            let sum: f64 = (0..STAGES).map(|i| WEIGHTS[i] * (0.5 * (1.0 + ABSCISSAE[i])).powi(n)).sum();
            assert!((sum - 1.0 / f64::from(n + 1)).abs() < 3e-16, "degree {n}: {sum}");
        }
    }

    #[test]
    fn the_stages_integrate_polynomials_to_degree_7() {
        for n in 0..8 {
            for i in 0..STAGES {
                let theta = |i: usize| 0.5 * (1.0 + ABSCISSAE[i]);
                let sum: f64 = (0..STAGES).map(|j| MATRIX[i][j] * theta(j).powi(n)).sum();
                assert!((sum - theta(i).powi(n + 1) / f64::from(n + 1)).abs() < 3e-16, "degree {n}, stage {i}");
            }
        }
    }

    #[test]
    fn the_integrals_in_powers_are_those_of_the_recurrence() {
        for n in 0..=20 {
            let theta = f64::from(n) / 20.0;
            let expected = legendre_integrals(2.0 * theta - 1.0);
            for k in 0..STAGES {
                let sum = INTEGRALS_IN_POWERS[k].iter().rev().fold(0.0, |sum, c| sum * theta + c);
                // The coefficients reach 2e3.
                assert!((sum - expected[k]).abs() < 3e-12, "{k} at {theta}: {sum}");
            }
        }
    }

    #[test]
    fn the_method_is_symplectic() {
        for i in 0..STAGES {
            for j in 0..STAGES {
                let defect = WEIGHTS[i] * MATRIX[i][j] + WEIGHTS[j] * MATRIX[j][i] - WEIGHTS[i] * WEIGHTS[j];
                assert!(defect.abs() < 1e-17, "{i}, {j}: {defect}");
            }
        }
    }
}
