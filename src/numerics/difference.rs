//! Derivatives of functions without a formula for them.

/// Step sizes of a table; the last is 2⁻¹³ of the first.
const LEVELS: usize = 14;

/// Rounding leaves at least this accuracy of a smooth f; a bend or a jump leaves less.
const SMOOTH: f64 = 1e-6;

/// After this many steps without a better slope rounding has spoilt them; it at least doubles from one to the next.
const SPOILT: usize = 3;

/// f′(x) by differences over ever smaller steps from `reach` on, extrapolated to zero (Ridders); f is evaluated within `range`
/// only. Steps that f refuses are skipped; NaN if no step is left.
///
/// The table T of the slopes over hᵢ = `reach`/2ⁱ is extrapolated by T(i,k) = T(i,k−1) + (T(i,k−1) − T(i−1,k−1))/(2^(pk) − 1) with
/// p = 2 for central differences. The result is the entry that differs least from the two entries it was made of: rounding spoils
/// small steps, curvature large ones. Differences are one-sided, p = 1, on a border of the range and where central differences do
/// not converge because f bends or jumps at x.
///
/// # Errors
/// The error of f if it refuses all steps.
///
/// Source: C. J. F. Ridders, "Accurate computation of F′(x) and F′(x)F″(x)", Advances in Engineering Software 4 (1982)
/// 75–76.
pub fn derivative<E>(
    mut f: impl FnMut(f64) -> Result<f64, E>,
    x: f64,
    reach: f64,
    [min, max]: [f64; 2],
) -> Result<f64, E> {
    let reach = reach.min(0.5 * (max - min));
    let fits = |h: f64| min <= x + h && x + h <= max;
    let (mut best, mut least, mut fault) = (f64::NAN, f64::INFINITY, None);
    for (sides, power) in [([1.0, -1.0], 4.0), ([1.0, 0.0], 2.0), ([-1.0, 0.0], 2.0)] {
        if !sides.into_iter().all(|side| fits(side * reach)) {
            continue;
        }
        let mut above: Vec<f64> = Vec::new();
        let mut since = 0;
        for level in 0..LEVELS {
            let h = reach * 0.5_f64.powi(level as i32);
            let [a, b] = sides.map(|side| x + side * h);
            let slope = f(a).and_then(|at_a| Ok((at_a - f(b)?) / (a - b)));
            // Entries from a slope that is not finite never have the least error.
            let mut row = vec![slope.unwrap_or_else(|e| {
                fault = Some(e);
                f64::NAN
            })];
            let (mut weight, least_before) = (1.0, least);
            for (k, before) in above.iter().enumerate() {
                weight *= power;
                let entry = row[k] + (row[k] - before) / (weight - 1.0);
                let error = (entry - row[k]).abs().max((entry - before).abs());
                if error < least {
                    (best, least) = (entry, error);
                }
                row.push(entry);
            }
            above = row;
            since = if least < least_before { 0 } else { since + 1 };
            // Rounding permits no better, or spoils ever smaller steps of a smooth f.
            if least <= 1e-13 * best.abs() || (since == SPOILT && least <= SMOOTH * best.abs()) {
                break;
            }
        }
        if least <= SMOOTH * best.abs() {
            break;
        }
    }
    match fault {
        Some(fault) if best.is_nan() => Err(fault),
        _ => Ok(best),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    const ALL: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    fn of(f: impl Fn(f64) -> f64, x: f64, range: [f64; 2]) -> f64 {
        let Ok(slope) = derivative(|x| Ok::<_, Infallible>(f(x)), x, 0.02, range);
        slope
    }

    #[test]
    fn smooth_functions_have_their_derivative_to_ten_digits() {
        for size in [1e-12, 1.0, 1e12] {
            let waves = |x: f64| size * (50.0 * x).sin();
            assert!((of(waves, 0.3, ALL) / (50.0 * size * 15f64.cos()) - 1.0).abs() < 1e-10, "{size:e}");
        }
        let resonance = |x: f64| 1.0 / ((x - 1.0).powi(2) + 1e-6);
        let exact = |x: f64| -2.0 * (x - 1.0) * resonance(x).powi(2);
        assert!((of(resonance, 1.002, ALL) / exact(1.002) - 1.0).abs() < 1e-10);
        assert_eq!(of(|_| 3.0, 0.3, ALL), 0.0);
    }

    #[test]
    fn a_cubic_takes_three_central_differences() {
        let mut evaluations = 0;
        let cubic = |x: f64| {
            evaluations += 1;
            Ok::<_, Infallible>(x.powi(3))
        };
        let Ok(slope) = derivative(cubic, 0.5, 0.25, ALL);
        assert_eq!((slope, evaluations), (0.75, 6));
    }

    #[test]
    fn what_rounding_spoils_is_not_tried_to_the_end() {
        for noise in [1e-12, 1e-10] {
            let mut evaluations = 0;
            let waves = |x: f64| {
                evaluations += 1;
                Ok::<_, Infallible>((3.0 * x).sin() + noise * (1e7 * x).sin())
            };
            let Ok(slope) = derivative(waves, 0.3, 0.02, ALL);
            assert!((slope / (3.0 * 0.9f64.cos()) - 1.0).abs() < 1e3 * noise, "{slope}");
            assert!(evaluations <= 16, "{evaluations}");
        }
    }

    #[test]
    fn no_evaluation_leaves_the_range() {
        for (x, range) in [(0.0, [0.0, 1.0]), (1.0, [0.0, 1.0]), (1.0, [1.0 - 1e-3, 1.0 + 1e-5])] {
            let inside = |x: f64| {
                assert!(range[0] <= x && x <= range[1], "{x}");
                (3.0 * x).exp()
            };
            assert!((of(inside, x, range) / (3.0 * (3.0 * x).exp()) - 1.0).abs() < 1e-8, "{x}");
        }
    }

    #[test]
    fn at_a_jump_it_is_the_slope_of_the_side_that_the_value_belongs_to() {
        for size in [1e-12, 1.0, 1e12] {
            let jump = |x: f64| size * if x >= 0.3 { x.exp() } else { 7.0 };
            assert!((of(jump, 0.3, ALL) / (size * 0.3f64.exp()) - 1.0).abs() < 1e-8, "{size:e}");
        }
    }

    #[test]
    fn refused_steps_are_passed_over_and_told_where_nothing_else_is_left() {
        let near = |x: f64| if (x - 1.0).abs() < 1e-3 { Ok(x * x) } else { Err("too far") };
        assert!((derivative(near, 1.0, 0.02, ALL).unwrap() - 2.0).abs() < 1e-9);
        assert_eq!(derivative(|_| Err("never"), 1.0, 0.02, ALL), Err("never"));
        // Near a pole at an end of the first step.
        assert!((of(|x| 1.0 / (0.02 - x), 0.0, ALL) / 2500.0 - 1.0).abs() < 1e-9);
        assert!(of(|_| f64::INFINITY, 0.3, ALL).is_nan());
    }
}
