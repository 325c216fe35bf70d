//! Floquet's theory of two variables: multipliers, growth over a period, the periodic solution.
//!
//! Source: V. A. Yakubovich, V. M. Starzhinskii, *Linear Differential Equations with Periodic Coefficients*, Wiley 1975,
//! chapter II; the determinant after Liouville.

/// The monodromy matrix of a period, matrix · exp(scale): free motions may grow or decay by any factor. Its determinant is
/// exp(−∫d dτ), d the damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Monodromy {
    matrix: [[f64; 2]; 2],
    scale: f64,
    /// ∫d dτ.
    damping: f64,
}

/// The bounds within which the entries of the matrix are kept, so that their squares do not overflow.
const LARGE: f64 = 1e100;

/// The roundings of the entries of a monodromy matrix, relative to the largest product of two of them.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// A discriminant counts as positive if it exceeds its error, as far as that is known, this many times.
const CERTAIN: f64 = 4.0;

impl Monodromy {
    /// No motion.
    pub const IDENTITY: Monodromy = Monodromy { matrix: [[1.0, 0.0], [0.0, 1.0]], scale: 0.0, damping: 0.0 };

    /// Continues by a further piece of the period, with ∫d dτ over it.
    pub fn go_on(&mut self, piece: &[[f64; 2]; 2], damping: f64) {
        self.damping += damping;
        let m = self.matrix;
        self.matrix = std::array::from_fn(|r| std::array::from_fn(|c| piece[r][0] * m[0][c] + piece[r][1] * m[1][c]));
        let size = self.matrix.iter().flatten().fold(0.0_f64, |size, x| size.max(x.abs()));
        if !(1.0 / LARGE..LARGE).contains(&size) && size > 0.0 {
            self.matrix = self.matrix.map(|row| row.map(|x| x / size));
            self.scale += size.ln();
        }
    }

    /// ln ρ, ρ the largest modulus of the Floquet multipliers.
    ///
    /// Multipliers that are complex have the modulus √det M, so the growth is exact there. Real ones follow from the discriminant
    /// (tr/2)² − det. Two ways to compute it show its error; below that they count as equal. A growth of less than some 1e-7 beyond
    /// the damping's is therefore indistinguishable from zero.
    pub fn growth(&self) -> f64 {
        let [[a, b], [c, d]] = self.matrix;
        let (half_trace, half_difference) = (0.5 * (a + d), 0.5 * (a - d));
        let determinant = (-self.damping - 2.0 * self.scale).exp();
        let discriminant = half_difference * half_difference + b * c;
        let missed = (half_trace * half_trace - determinant - discriminant).abs();
        let rounding = ROUNDING * (half_trace * half_trace + half_difference * half_difference + (b * c).abs());
        if discriminant > CERTAIN * missed + rounding {
            self.scale + (half_trace.abs() + discriminant.sqrt()).ln()
        } else {
            // The sum turns the −0 of −∫0 into +0.
            -0.5 * self.damping + 0.0
        }
    }
}

/// The largest modulus of the eigenvalues of a matrix.
pub fn spectral_radius(matrix: &[[f64; 2]; 2]) -> f64 {
    let [[a, b], [c, d]] = matrix;
    let (half_trace, determinant) = (0.5 * (a + d), a * d - b * c);
    // ((a − d)/2)² + b c is the discriminant without the cancellation of trace²/4 − determinant.
    let discriminant = (0.5 * (a - d)).powi(2) + b * c;
    if discriminant < 0.0 { determinant.max(0.0).sqrt() } else { half_trace.abs() + discriminant.sqrt() }
}

/// True if a multiplier is 1 up to this `rounding` of the terms of det(I − M), or all of them are as small.
pub fn is_resonant(matrix: &[[f64; 2]; 2], rounding: f64) -> bool {
    let [[a, b], [c, d]] = matrix;
    let [one, other] = [(1.0 - a) * (1.0 - d), b * c];
    (one - other).abs() <= rounding * (one.abs() + other.abs()).max(rounding)
}

/// The fixed point of the map y ↦ image + M (y − point); None if it is NaN.
pub fn fixed_point(matrix: &[[f64; 2]; 2], point: [f64; 2], image: [f64; 2]) -> Option<[f64; 2]> {
    let [[a, b], [c, d]] = matrix;
    let rest = [image[0] - point[0], image[1] - point[1]];
    let determinant = (1.0 - a) * (1.0 - d) - b * c;
    let correction =
        [((1.0 - d) * rest[0] + b * rest[1]) / determinant, (c * rest[0] + (1.0 - a) * rest[1]) / determinant];
    let next = [point[0] + correction[0], point[1] + correction[1]];
    (next[0].is_finite() && next[1].is_finite()).then_some(next)
}
