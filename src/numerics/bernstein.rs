//! Polynomials in Bernstein form, whose coefficients enclose their values.
//!
//! Source: R. T. Farouki, "The Bernstein polynomial basis: a centennial retrospective", Comput. Aided Geom. Des. 29
//! (2012) 379–419, sections 4 and 5.

/// The highest degree.
pub const MAX_DEGREE: usize = 10;

type Coefficients = [f64; MAX_DEGREE + 1];

/// Bisections until an exit counts as located: beyond 2⁻⁵² of the interval there is no `f64`.
const DEPTH: u32 = 53;

/// The first x ∈ [0, 1] at which Σ cⱼ xʲ is outside of [`lower`, `upper`], None if it stays inside. No exit is
/// missed: a part of the interval is passed over only where the Bernstein coefficients lie inside.
pub fn first_exit(power_coefficients: &Coefficients, degree: usize, lower: f64, upper: f64) -> Option<f64> {
    search(&from_powers(power_coefficients, degree), degree, lower, upper, DEPTH)
}

/// bᵢ = Σⱼ C(i, j)/C(n, j) cⱼ.
fn from_powers(c: &Coefficients, degree: usize) -> Coefficients {
    let mut b = [0.0; MAX_DEGREE + 1];
    for (i, b) in b.iter_mut().enumerate().take(degree + 1) {
        let mut ratio = 1.0;
        for j in 0..=i {
            *b += ratio * c[j];
            ratio *= (i - j) as f64 / (degree - j).max(1) as f64;
        }
    }
    b
}

fn search(b: &Coefficients, degree: usize, lower: f64, upper: f64, depth: u32) -> Option<f64> {
    let outside = |value: f64| !(value >= lower && value <= upper);
    if !b[..=degree].iter().any(|b| outside(*b)) {
        return None;
    }
    if outside(b[0]) {
        return Some(0.0);
    }
    if depth == 0 {
        return Some(1.0);
    }
    let (left, right) = halves(b, degree);
    search(&left, degree, lower, upper, depth - 1)
        .map(|x| 0.5 * x)
        .or_else(|| search(&right, degree, lower, upper, depth - 1).map(|x| 0.5 + 0.5 * x))
}

/// The coefficients on [0, ½] and on [½, 1], by de Casteljau's algorithm.
fn halves(b: &Coefficients, degree: usize) -> (Coefficients, Coefficients) {
    let (mut left, mut right) = ([0.0; MAX_DEGREE + 1], *b);
    for i in 0..=degree {
        left[i] = right[0];
        for j in 0..degree - i {
            right[j] = 0.5 * (right[j] + right[j + 1]);
        }
    }
    (left, right)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polynomial(c: &[f64]) -> (Coefficients, usize) {
        let mut all = [0.0; MAX_DEGREE + 1];
        all[..c.len()].copy_from_slice(c);
        (all, c.len() - 1)
    }

    #[test]
    fn the_first_of_several_exits() {
        // 4x(1 − x) leaves [0, 0.75] at x = ¼ and comes back at ¾.
        let (c, n) = polynomial(&[0.0, 4.0, -4.0]);
        assert!((first_exit(&c, n, -0.1, 0.75).unwrap() - 0.25).abs() < 1e-15);
        assert_eq!(first_exit(&c, n, -0.1, 1.0), None);
        assert_eq!(first_exit(&c, n, 0.1, 1.0), Some(0.0));
    }

    #[test]
    fn a_narrow_excursion_between_two_zeros_is_found() {
        // −(x − ½)² ((x − ½)² + 1) + 1e-12 rises above zero on 2e-6 of the interval.
        let y = |x: f64| 1e-12 - (x - 0.5f64).powi(2) * ((x - 0.5f64).powi(2) + 1.0);
        let (c, n) = polynomial(&[1e-12 - 0.3125, 1.5, -2.5, 2.0, -1.0]);
        let x = first_exit(&c, n, -1.0, 0.0).unwrap();
        assert!((x - (0.5 - 1e-6)).abs() < 1e-9 && y(x) > -1e-15, "{x}");
    }

    #[test]
    fn a_line_leaves_downwards() {
        let (c, n) = polynomial(&[1.0, -3.0]);
        assert!((first_exit(&c, n, 0.0, 2.0).unwrap() - 1.0 / 3.0).abs() < 1e-15);
    }
}
