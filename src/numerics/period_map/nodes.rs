//! The twelve Gauss nodes on [−1, 1] and what follows from them, computed at compile time.

/// The number of nodes.
pub const STAGES: usize = 12;

/// The positive zeros of the Legendre polynomial P₁₂ and their weights.
const HALF: [(f64, f64); STAGES / 2] = [
    (0.125_233_408_511_468_92, 0.249_147_045_813_402_79),
    (0.367_831_498_998_180_19, 0.233_492_536_538_354_81),
    (0.587_317_954_286_617_45, 0.203_167_426_723_065_92),
    (0.769_902_674_194_304_69, 0.160_078_328_543_346_23),
    (0.904_117_256_370_474_86, 0.106_939_325_995_318_43),
    (0.981_560_634_246_719_25, 0.047_175_336_386_511_827),
];

/// The nodes, ascending.
pub static ABSCISSAE: [f64; STAGES] = abscissae().0;

/// The weights; their sum is 2.
pub static WEIGHTS: [f64; STAGES] = abscissae().1;

/// S₁ᵢⱼ = ∫₋₁^xᵢ ℓⱼ dx: the integral of the polynomial through fⱼ up to the node xᵢ.
pub static INTEGRAL: [[f64; STAGES]; STAGES] = integral();

/// S₁²: the same integral of that integral, interpolated at the nodes.
pub static SECOND_INTEGRAL: [[f64; STAGES]; STAGES] = second_integral();

/// The coefficients mₖ = Σ PROJECTION[k][j] fⱼ of Σ mₖ Pₖ(x), the polynomial through the fⱼ.
pub static PROJECTION: [[f64; STAGES]; STAGES] = projection();

/// The derivative of the polynomial through fⱼ at the node xᵢ.
pub static DERIVATIVE: [[f64; STAGES]; STAGES] = derivative();

/// P₀ … P₁₂ in powers of x.
pub static LEGENDRE: [[f64; STAGES + 1]; STAGES + 1] = legendre_powers(0.0);

/// The same in powers of 1 + x, which is small next to the start of a cell.
pub static LEGENDRE_FROM_START: [[f64; STAGES + 1]; STAGES + 1] = legendre_powers(1.0);

const fn abscissae() -> ([f64; STAGES], [f64; STAGES]) {
    let (mut x, mut b) = ([0.0; STAGES], [0.0; STAGES]);
    let mut i = 0;
    while i < STAGES / 2 {
        let (upper, lower) = (STAGES / 2 + i, STAGES / 2 - 1 - i);
        (x[upper], b[upper]) = HALF[i];
        (x[lower], b[lower]) = (-HALF[i].0, HALF[i].1);
        i += 1;
    }
    (x, b)
}

/// P₀ … P₁₂ at x.
const fn legendre(x: f64) -> [f64; STAGES + 1] {
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

/// P₀ … P₁₂ in powers of x + `shift`.
const fn legendre_powers(shift: f64) -> [[f64; STAGES + 1]; STAGES + 1] {
    let mut p = [[0.0; STAGES + 1]; STAGES + 1];
    (p[0][0], p[1][0], p[1][1]) = (1.0, -shift, 1.0);
    let mut k = 1;
    while k < STAGES {
        let n = k as f64;
        let mut j = 0;
        while j <= STAGES {
            let raised = if j > 0 { p[k][j - 1] } else { 0.0 } - shift * p[k][j];
            p[k + 1][j] = ((2.0 * n + 1.0) * raised - n * p[k - 1][j]) / (n + 1.0);
            j += 1;
        }
        k += 1;
    }
    p
}

const fn projection() -> [[f64; STAGES]; STAGES] {
    let (x, b) = abscissae();
    let mut m = [[0.0; STAGES]; STAGES];
    let mut j = 0;
    while j < STAGES {
        let p = legendre(x[j]);
        let mut k = 0;
        while k < STAGES {
            m[k][j] = 0.5 * (2 * k + 1) as f64 * b[j] * p[k];
            k += 1;
        }
        j += 1;
    }
    m
}

const fn derivative() -> [[f64; STAGES]; STAGES] {
    let (x, m) = (abscissae().0, projection());
    let mut d = [[0.0; STAGES]; STAGES];
    let mut i = 0;
    while i < STAGES {
        let p = legendre(x[i]);
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

const fn integral() -> [[f64; STAGES]; STAGES] {
    let (x, m) = (abscissae().0, projection());
    let mut s = [[0.0; STAGES]; STAGES];
    let mut i = 0;
    while i < STAGES {
        let p = legendre(x[i]);
        let mut j = 0;
        while j < STAGES {
            // ∫₋₁^x P₀ = x + 1, ∫₋₁^x Pₖ = (Pₖ₊₁ − Pₖ₋₁)/(2 k + 1).
            s[i][j] = (1.0 + x[i]) * m[0][j];
            let mut k = 1;
            while k < STAGES {
                s[i][j] += (p[k + 1] - p[k - 1]) / (2 * k + 1) as f64 * m[k][j];
                k += 1;
            }
            j += 1;
        }
        i += 1;
    }
    s
}

const fn second_integral() -> [[f64; STAGES]; STAGES] {
    let s = integral();
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

    /// What the conversion to powers may lose: the largest power of a Legendre polynomial of degree 11.
    fn scale_of(n: i32) -> f64 {
        2f64.powi(n)
    }
}
