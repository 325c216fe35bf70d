//! Certified search for the first zero of a function g(t) > 0.
//!
//! At an instant with known g, ġ, g̈, … and |g⁽ᴺ⁾| ≤ M over the horizon, Taylor's theorem gives the lower bound
//!
//! p(h) = Σ g⁽ⁿ⁾ hⁿ/n! − M hᴺ/N!  (n < N),   g(t + h) ≥ p(h).
//!
//! As long as p > 0 there is no zero: [`safe_step`] returns a step up to (just before) the first zero of p. Repeated
//! from the new instant, the steps converge to the first zero of g from the left, with order N at a simple zero; no
//! zero can be jumped over, however close to its neighbour it lies.
//!
//! Where g starts as a multiple zero (a mass that has just left its support), the leading derivatives are passed as
//! exact zeros: they are factored out of p, so that the start is not mistaken for an event.

/// How often the bound is sharpened within one call; each pass is some dozen multiplications, less than what
/// evaluating g again costs.
const PASSES: usize = 12;

/// A step within which p is positive, at most `horizon`; 0 where p is not positive right of the instant.
///
/// `derivatives` = g, ġ, g̈, … at the instant, with exact zeros where g starts as a multiple zero; `bound` ≥ the
/// absolute value of the next derivative over the horizon. Derivatives that are not finite give 0.
///
/// Method: split p/hᵏ (k leading zeros) into its positive terms P and the negative ones −N. Both P and N increase, so
/// p > 0 on [a, b) wherever N(b) ≤ P(a). The sequence of such b increases towards the first zero of p.
pub fn safe_step<const ORDER: usize>(derivatives: [f64; ORDER], bound: f64, horizon: f64) -> f64 {
    let Some(first) = derivatives.iter().position(|&g| g != 0.0) else {
        return if bound == 0.0 { horizon } else { 0.0 };
    };
    if !(derivatives[first] > 0.0 && derivatives.iter().all(|g| g.is_finite()) && bound.is_finite()) {
        return 0.0;
    }
    let (mut positive, mut negative) = ([0.0; 8], [0.0; 8]);
    let mut factorial = (1..=first).product::<usize>() as f64;
    let degree = ORDER - first;
    for n in 0..degree {
        let coefficient = derivatives[first + n] / factorial;
        (positive[n], negative[n]) = (coefficient.max(0.0), (-coefficient).max(0.0));
        factorial *= (first + n + 1) as f64;
    }
    negative[degree] = bound / factorial;
    let mut safe = 0.0;
    for _ in 0..PASSES {
        let next = level(&negative[..=degree], polynomial(&positive[..=degree], safe));
        if next >= horizon {
            return horizon;
        }
        if next <= safe * (1.0 + 1e-6) {
            // What is left to gain is less than what the next evaluation of g brings.
            break;
        }
        safe = next;
    }
    // The margin covers the rounding of the polynomials.
    safe * (1.0 - 4.0 * f64::EPSILON)
}

fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// The x > 0 at which the polynomial with the coefficients nᵢ ≥ 0, n₀ = 0, reaches `height` > 0.
fn level(n: &[f64], height: f64) -> f64 {
    // Each term alone reaches the height at or after x; from there Newton's method on the convex polynomial comes
    // down monotonically.
    let mut x = f64::INFINITY;
    for (i, &coefficient) in n.iter().enumerate().skip(1) {
        if coefficient > 0.0 {
            let ratio = height / coefficient;
            x = x.min(match i {
                1 => ratio,
                2 => ratio.sqrt(),
                3 => ratio.cbrt(),
                _ => ratio.powf(1.0 / i as f64),
            });
        }
    }
    if !x.is_finite() {
        return x;
    }
    for _ in 0..8 {
        let (mut value, mut slope) = (0.0, 0.0);
        for &coefficient in n.iter().rev() {
            slope = slope * x + value;
            value = value * x + coefficient;
        }
        let next = x - (value - height) / slope;
        if !(next < x) {
            break;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps along g until the steps vanish; the number of evaluations and the zero.
    fn first_zero<const N: usize>(g: impl Fn(f64) -> [f64; N], bound: f64, mut t: f64) -> (f64, usize) {
        for count in 1.. {
            let step = safe_step(g(t), bound, 100.0 - t);
            t += step;
            if step <= 1e-15 * t.max(1e-3) || t >= 100.0 {
                return (t, count);
            }
        }
        unreachable!()
    }

    fn shifted_cosine(offset: f64) -> impl Fn(f64) -> [f64; 4] {
        move |t: f64| [t.cos() + offset, -t.sin(), -t.cos(), t.sin()]
    }

    #[test]
    fn a_simple_zero_is_found_to_rounding_with_few_evaluations() {
        let (t, count) = first_zero(shifted_cosine(0.0), 1.0, 0.0);
        assert!((t - std::f64::consts::FRAC_PI_2).abs() < 4e-16, "{t}");
        assert!(count <= 8, "{count} evaluations");
    }

    #[test]
    fn a_pair_of_zeros_close_together_is_not_jumped_over() {
        // cos t + 1 − ε dips below zero around π for 2√(2ε).
        for depth in [1e-3, 1e-6, 1e-9, 1e-12] {
            let (t, count) = first_zero(shifted_cosine(1.0 - depth), 1.0, 0.0);
            let exact = std::f64::consts::PI - (2.0 * f64::asin((depth / 2.0).sqrt()));
            assert!((t - exact).abs() < 1e-15 / depth.sqrt(), "{depth}: {t} instead of {exact}");
            assert!(count <= 60, "{depth}: {count} evaluations");
        }
    }

    #[test]
    fn a_near_miss_is_no_zero() {
        for distance in [1e-3, 1e-6, 1e-9, 1e-12] {
            let (t, _) = first_zero(shifted_cosine(1.0 + distance), 1.0, 0.0);
            assert_eq!(t, 100.0, "{distance}");
        }
    }

    #[test]
    fn a_multiple_zero_at_the_start_is_no_event() {
        // (t² − t³)/2 starts as a double zero, t − sin t as a triple one.
        let dip = |t: f64| [(t * t - t.powi(3)) / 2.0, t - 1.5 * t * t, 1.0 - 3.0 * t, -3.0];
        let (t, _) = first_zero(dip, 1.0, 0.0);
        assert!((t - 1.0).abs() < 1e-15, "{t}");
        let rise =
            |t: f64| if t == 0.0 { [0.0, 0.0, 0.0, 1.0] } else { [t - t.sin(), 1.0 - t.cos(), t.sin(), t.cos()] };
        assert_eq!(first_zero(rise, 1.0, 0.0).0, 100.0);
    }

    #[test]
    fn lower_orders_find_the_same_zero() {
        let (t, _) = first_zero(|t: f64| [t.cos(), -t.sin()], 1.0, 0.0);
        assert!((t - std::f64::consts::FRAC_PI_2).abs() < 4e-16, "{t}");
    }

    #[test]
    fn nothing_is_promised_where_nothing_is_known() {
        assert_eq!(safe_step([-1.0, 0.0], 1.0, 1.0), 0.0);
        assert_eq!(safe_step([0.0, -1.0], 1.0, 1.0), 0.0);
        assert_eq!(safe_step([f64::NAN, 0.0], 1.0, 1.0), 0.0);
        assert_eq!(safe_step([1.0, f64::INFINITY], 1.0, 1.0), 0.0);
        assert_eq!(safe_step([0.0, 0.0], 0.0, 3.0), 3.0);
        assert_eq!(safe_step([1.0, 2.0], 0.0, 3.0), 3.0);
    }
}
