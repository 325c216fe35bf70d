//! Gauss–Legendre quadrature with 6, 8, 12 or 16 nodes, and collocation at them, computed at compile time.
//!
//! The abscissa x ∈ [−1, 1] belongs to the fraction θ = (1 + x)/2 of the step.
//! Source: E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., Springer 1996, sections
//! IV.5 and II.1; M. Abramowitz, I. A. Stegun, *Handbook of Mathematical Functions*, section 25.4.30; the nodes are the
//! roots of the Legendre polynomials, computed to 40 digits.

/// The number of nodes s of the collocation, which has order 2 s = 16.
pub const STAGES: usize = 8;

/// The nodes x > 0 with their weights; the rule is symmetric about 0.
type Half = &'static [(f64, f64)];

const GAUSS_6: Half = &[
    (0.2386191860831969, 0.467913934572691),
    (0.6612093864662645, 0.3607615730481386),
    (0.932469514203152, 0.17132449237917036),
];

const GAUSS_8: Half = &[
    (0.183_434_642_495_649_8, 0.362_683_783_378_361_98),
    (0.525_532_409_916_328_99, 0.313_706_645_877_887_29),
    (0.796_666_477_413_626_74, 0.222_381_034_453_374_47),
    (0.960_289_856_497_536_23, 0.101_228_536_290_376_26),
];

const GAUSS_12: Half = &[
    (0.125_233_408_511_468_92, 0.249_147_045_813_402_79),
    (0.367_831_498_998_180_19, 0.233_492_536_538_354_81),
    (0.587_317_954_286_617_45, 0.203_167_426_723_065_92),
    (0.769_902_674_194_304_69, 0.160_078_328_543_346_23),
    (0.904_117_256_370_474_86, 0.106_939_325_995_318_43),
    (0.981_560_634_246_719_25, 0.047_175_336_386_511_827),
];

const GAUSS_16: Half = &[
    (0.09501250983763744, 0.1894506104550685),
    (0.2816035507792589, 0.18260341504492358),
    (0.45801677765722737, 0.16915651939500254),
    (0.6178762444026438, 0.14959598881657674),
    (0.755404408355003, 0.12462897125553388),
    (0.8656312023878318, 0.09515851168249279),
    (0.9445750230732326, 0.062253523938647894),
    (0.9894009349916499, 0.027152459411754096),
];

/// The nodes xᵢ, ascending.
pub static ABSCISSAE: [f64; STAGES] = rule().0;

/// The weights bᵢ for a step of length one; their sum is 1.
pub static WEIGHTS: [f64; STAGES] = halves([rule().1])[0];

/// aᵢⱼ = ∫₀^θᵢ ℓⱼ dθ: the stages are yᵢ = y₀ + h Σ aᵢⱼ fⱼ.
pub static MATRIX: [[f64; STAGES]; STAGES] = halves(integral());

/// The coefficients mₖ = Σ `PROJECTION[k][j]` fⱼ of Σ mₖ Pₖ(x), the polynomial through the fⱼ.
pub static PROJECTION: [[f64; STAGES]; STAGES] = projection();

/// `Σ |PROJECTION[7][j]| < 4`: bound of the rounding errors of the fⱼ that can add up in a coefficient.
pub const NOISE_OF_MODES: f64 = 4.0;

/// A Gauss rule with 6, 8, 12 or 16 nodes; n nodes are exact for polynomials of degree 2n − 1.
#[derive(Clone, Copy, Debug)]
pub struct Gauss(Half);

impl Gauss {
    /// The smallest rule with at least `nodes` nodes, at most 16.
    pub const fn with(nodes: usize) -> Self {
        Gauss(match nodes {
            0..=6 => GAUSS_6,
            7..=8 => GAUSS_8,
            9..=12 => GAUSS_12,
            _ => GAUSS_16,
        })
    }

    /// The positions of the first N nodes and their weights for the interval from 0 to `length`.
    pub fn nodes<const N: usize>(self, length: f64) -> [[f64; 2]; N] {
        let half = 0.5 * length;
        let mut nodes = [[0.0; 2]; N];
        let both = self.0.iter().flat_map(|(x, weight)| [(1.0 - x, weight), (1.0 + x, weight)]);
        for (node, (place, weight)) in nodes.iter_mut().zip(both) {
            *node = [half * place, half * weight];
        }
        nodes
    }

    /// ∫ f(s) ds from 0 to `length`, for several integrands at once.
    pub fn integrate<const N: usize>(self, length: f64, mut f: impl FnMut(f64) -> [f64; N]) -> [f64; N] {
        let half = 0.5 * length;
        let mut sum = [0.0; N];
        for &(x, weight) in self.0 {
            let (left, right) = (f(half * (1.0 - x)), f(half * (1.0 + x)));
            for n in 0..N {
                sum[n] += weight * (left[n] + right[n]);
            }
        }
        sum.map(|s| half * s)
    }
}

/// The N nodes on [−1, 1], ascending, and their weights of sum 2.
pub(super) const fn rule<const N: usize>() -> ([f64; N], [f64; N]) {
    let (half, mut x, mut b) = (Gauss::with(N).0, [0.0; N], [0.0; N]);
    let mut i = 0;
    while i < N / 2 {
        let (upper, lower) = (N / 2 + i, N / 2 - 1 - i);
        (x[upper], b[upper]) = half[i];
        (x[lower], b[lower]) = (-half[i].0, half[i].1);
        i += 1;
    }
    (x, b)
}

const fn halves<const N: usize, const M: usize>(mut rows: [[f64; N]; M]) -> [[f64; N]; M] {
    let mut i = 0;
    while i < N * M {
        rows[i / N][i % N] *= 0.5;
        i += 1;
    }
    rows
}

/// P₀ … P_(M−1) at x.
pub(super) const fn legendre<const M: usize>(x: f64) -> [f64; M] {
    let mut p = [1.0; M];
    p[1] = x;
    let mut k = 1;
    while k + 1 < M {
        let n = k as f64;
        p[k + 1] = ((2.0 * n + 1.0) * x * p[k] - n * p[k - 1]) / (n + 1.0);
        k += 1;
    }
    p
}

/// The coefficients of (x + `shift`)ʲ in Pₖ, row by row; without shift up to the degree 9 each is a sum of few exact
/// quotients.
pub(super) const fn legendre_powers<const M: usize>(shift: f64) -> [[f64; M]; M] {
    let mut p = [[0.0; M]; M];
    (p[0][0], p[1][0], p[1][1]) = (1.0, -shift, 1.0);
    let mut k = 1;
    while k + 1 < M {
        let n = k as f64;
        let mut j = 0;
        while j < M {
            let raised = if j > 0 { p[k][j - 1] } else { 0.0 } - shift * p[k][j];
            p[k + 1][j] = ((2.0 * n + 1.0) * raised - n * p[k - 1][j]) / (n + 1.0);
            j += 1;
        }
        k += 1;
    }
    p
}

/// ∫₀^θ Pₖ dθ for k = 0 … s − 1 at x = 2 θ − 1; 1 for k = 0 and 0 else at the end of the step.
pub const fn legendre_integrals(x: f64) -> [f64; STAGES] {
    let p: [f64; STAGES + 1] = legendre(x);
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

/// The coefficients mₖ = Σ `projection[k][j]` fⱼ of Σ mₖ Pₖ(x), the polynomial through the fⱼ.
pub(super) const fn projection<const N: usize>() -> [[f64; N]; N] {
    let (x, b) = rule::<N>();
    let mut m = [[0.0; N]; N];
    let mut j = 0;
    while j < N {
        let p: [f64; N] = legendre(x[j]);
        let mut k = 0;
        while k < N {
            m[k][j] = 0.5 * (2 * k + 1) as f64 * b[j] * p[k];
            k += 1;
        }
        j += 1;
    }
    m
}

/// ∫₋₁^xᵢ ℓⱼ dx: the integral of the polynomial through the fⱼ up to the node xᵢ.
pub(super) const fn integral<const N: usize>() -> [[f64; N]; N] {
    let (x, m) = (rule::<N>().0, projection::<N>());
    let mut s = [[0.0; N]; N];
    let mut i = 0;
    while i < N {
        // One more than the nodes of the largest rule.
        let p: [f64; 17] = legendre(x[i]);
        let mut j = 0;
        while j < N {
            // ∫₋₁^x P₀ = x + 1, ∫₋₁^x Pₖ = (Pₖ₊₁ − Pₖ₋₁)/(2 k + 1).
            s[i][j] = (1.0 + x[i]) * m[0][j];
            let mut k = 1;
            while k < N {
                s[i][j] += (p[k + 1] - p[k - 1]) / (2 * k + 1) as f64 * m[k][j];
                k += 1;
            }
            j += 1;
        }
        i += 1;
    }
    s
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

    #[test]
    fn n_nodes_integrate_degree_two_n_minus_one() {
        for (nodes, degree) in [(6, 11), (8, 15), (12, 23), (16, 31)] {
            let [even, odd] =
                Gauss::with(nodes).integrate(2.0, |s| [(s - 1.0).powi(degree - 1), (s / 2.0).powi(degree)]);
            assert!((even - 2.0 / f64::from(degree)).abs() < 1e-15, "{nodes}: {even}");
            assert!((odd - 2.0 / f64::from(degree + 1)).abs() < 1e-15, "{nodes}: {odd}");
            let [beyond, _] = Gauss::with(nodes).integrate(2.0, |s| [(s - 1.0).powi(degree + 1), 0.0]);
            assert!((beyond - 2.0 / f64::from(degree + 2)).abs() > 1e-11, "{nodes} nodes are exact for too much");
        }
    }
}
