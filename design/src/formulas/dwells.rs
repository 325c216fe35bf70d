//! The cubics that the source prints for the coefficients of two dwells opposite to each other.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.4.1, equations (2) to (6).

/// A₁, A₃ … of K = 3 or 5 by the cubics of the source, for dwells of half-width `half` (rad) and U = ±½.
pub fn cubics(order: usize, half: f64) -> Option<Vec<f64>> {
    let cubics: &[[f64; 4]] = match order {
        3 => &[[0.56253, -0.00060, 0.04302, -0.00499], [-0.06216, -0.00584, -0.01624, -0.03322]],
        5 => &[
            [0.58606, -0.00111, 0.03005, -0.00446],
            [-0.09753, -0.00131, -0.03482, -0.00879],
            [0.00939, 0.01807, -0.03207, 0.04126],
        ],
        _ => return None,
    };
    Some(cubics.iter().map(|c| c.iter().rev().fold(0.0, |sum, c| sum * half + c)).collect())
}
