//! Certified search for the first zero of a polynomial on [0, 1].
//!
//! For x ∈ [0, H] the nested bound a₀ + min(0, H (a₁ + min(0, H (a₂ + …)))) lies below Σ aₙ xⁿ. Where it is positive
//! there is no zero. Otherwise the search moves on to the largest H that passes, with the coefficients of the
//! polynomial about the new place: five of them, and a bound of the rest. Once the polynomial is sure to fall all the way
//! to its zero, Newton's iteration ends the search. No zero can be jumped over, however close to its neighbour it lies.

/// Coefficients of the local expansion; the rest is bounded.
const LOCAL: usize = 5;

/// C(n, 5) for n = 0 … 31.
const CHOOSE_FIVE: [f64; 32] = {
    let mut table = [0.0; 32];
    let mut n = 5;
    while n < 32 {
        let m = n as f64;
        table[n] = m * (m - 1.0) * (m - 2.0) * (m - 3.0) * (m - 4.0) / 120.0;
        n += 1;
    }
    table
};

/// The change of Newton's method, relative to the zero, after which a search for a near place ends.
const NEAR: f64 = 3e-4;

/// Steps after which the place reached counts as the zero: each step that does not end the search at least doubles the
/// distance from a near miss or halves that from a zero, so that some hundred exhaust the digits of a number.
const MOST_STEPS: usize = 200;

/// The first zero in (0, `end`] of p = Σ cₙ xⁿ, at most 32 coefficients and `end` ≤ 1, where p > 0 right of 0; leading
/// zeros of the list are a multiple zero at the start and no event. 0 where p is not positive right of 0.
pub fn first_zero(c: &[f64], end: f64) -> Option<f64> {
    let Some(first) = c.iter().position(|&c| c != 0.0) else { return Some(0.0) };
    search(&c[first..], end, Precision::Full)
}

/// How near to the zero the search ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Precision {
    /// To the last digit or two.
    Full,
    /// At a place before the zero from which some 1e-7 of the way are left.
    Near,
}

/// The same for a polynomial of known degree that is positive at 0 or has its zero there, where the least of its partial
/// sums ([`partial_sums`]) does not tell that there is none.
pub fn first_zero_of<const N: usize>(c: &[f64; N], end: f64, precision: Precision) -> Option<f64> {
    if !(c[0] > 0.0) {
        return Some(0.0);
    }
    approach(c, end, precision)
}

/// The least and the greatest of the sums c₀, c₀ + c₁, …: between them lies Σ cₙ xⁿ for x ∈ [0, 1].
#[inline(always)]
pub fn partial_sums(c: &[f64]) -> [f64; 2] {
    let (mut sum, mut least, mut greatest) = (0.0, f64::INFINITY, f64::NEG_INFINITY);
    for term in c {
        sum += term;
        least = if sum < least { sum } else { least };
        greatest = if sum > greatest { sum } else { greatest };
    }
    // The comparisons take no notice of what is no number.
    if sum.is_nan() { [f64::NAN; 2] } else { [least, greatest] }
}

fn search(c: &[f64], end: f64, precision: Precision) -> Option<f64> {
    if !(c[0] > 0.0) {
        return Some(0.0);
    }
    if lower_bound(c, end) > 0.0 {
        return None;
    }
    approach(c, end, precision)
}

/// Comes to the first zero place by place.
#[inline(always)]
fn approach<C: AsRef<[f64]> + ?Sized>(polynomial: &C, end: f64, precision: Precision) -> Option<f64> {
    let c = polynomial.as_ref();
    // |p⁽⁵⁾|/5! on [0, end].
    let mut power = 1.0;
    let mut fifth = 0.0;
    for (n, c) in c.iter().enumerate().skip(LOCAL) {
        fifth += CHOOSE_FIVE[n] * c.abs() * power;
        power *= end;
    }
    let mut x = 0.0;
    for _ in 0..MOST_STEPS {
        let local = if x == 0.0 { beginning(c) } else { expansion(c, x) };
        if !(local[0] > 0.0) {
            return Some(x);
        }
        let rest = end - x;
        let mut bounded = [0.0; LOCAL + 1];
        bounded[..LOCAL].copy_from_slice(&local);
        bounded[LOCAL] = -fifth;
        let mut step = rest;
        let mut bound = lower_bound(&bounded, step);
        if bound > 0.0 {
            return None;
        }
        if let Some(zero) = falling(polynomial, &local, fifth, [x, rest], precision) {
            return zero;
        }
        while !(bound > 0.0) {
            // The zero of the secant; the bound is a concave function of the step near a zero.
            step *= (local[0] / (local[0] - bound)).clamp(0.1, 0.95);
            if !(step > f64::EPSILON * x) || step < f64::MIN_POSITIVE {
                return Some(x);
            }
            bound = lower_bound(&bounded, step);
        }
        x += step;
    }
    Some(x)
}

/// A lower bound of Σ cₙ xⁿ on [0, `h`]: the nested bound is the least of the partial sums at `h`.
#[inline(always)]
fn lower_bound(c: &[f64], h: f64) -> f64 {
    let (mut sum, mut power, mut least) = (0.0, 1.0, f64::INFINITY);
    for c in c {
        sum += c * power;
        power *= h;
        least = if sum < least { sum } else { least };
    }
    // The comparison takes no notice of what is no number.
    if sum.is_nan() { sum } else { least }
}

/// The first five coefficients.
#[inline(always)]
fn beginning(c: &[f64]) -> [f64; LOCAL] {
    std::array::from_fn(|n| c.get(n).copied().unwrap_or(0.0))
}

/// p⁽ⁿ⁾(x)/n! for n < 5.
#[inline(always)]
fn expansion(c: &[f64], x: f64) -> [f64; LOCAL] {
    let mut a = [0.0; LOCAL];
    for &c in c.iter().rev() {
        for n in (1..LOCAL).rev() {
            a[n] = a[n] * x + a[n - 1];
        }
        a[0] = a[0] * x + c;
    }
    a
}

/// Where p is sure to fall from x on, until it must have reached zero if it goes on like this: the zero there, or that
/// there is none in `rest`. None where p may turn before.
fn falling<C: AsRef<[f64]> + ?Sized>(
    polynomial: &C,
    local: &[f64; LOCAL],
    fifth: f64,
    [x, rest]: [f64; 2],
    precision: Precision,
) -> Option<Option<f64>> {
    let c = polynomial.as_ref();
    let [value, slope, second, third, fourth] = *local;
    if slope >= 0.0 {
        return None;
    }
    let reach = (-2.0 * value / slope).min(rest);
    let curving = [2.0 * second, 3.0 * third, 4.0 * fourth, 5.0 * fifth];
    let steepest = slope + curving.iter().rev().fold(0.0, |above: f64, c| reach * (c + above.max(0.0))).max(0.0);
    if steepest >= 0.0 {
        return None;
    }
    if value_at(c, x + reach) > 0.0 {
        return if reach == rest { Some(None) } else { None };
    }
    // Newton's iteration, kept between the ends by which the zero is known to lie.
    let (mut low, mut high) = (x, x + reach);
    let mut zero = x - value / slope;
    for _ in 0..60 {
        if !(zero > low && zero < high) {
            zero = 0.5 * (low + high);
        }
        let [value, slope] = value_and_slope(c, zero);
        if value > 0.0 {
            low = zero
        } else {
            high = zero
        }
        let next = zero - value / slope;
        let change = (next - zero).abs();
        if change <= 2.0 * f64::EPSILON * zero {
            break;
        }
        if precision == Precision::Near && change <= NEAR * zero {
            // Newton's method leaves about the square of its change; what remains positive lies before the zero.
            let before = next - (NEAR * change).max(NEAR * NEAR * zero);
            if before > low && value_at(c, before) > 0.0 {
                return Some(Some(before));
            }
        }
        zero = next;
    }
    Some(Some(zero.clamp(low, high)))
}

/// p at x, its even and odd terms side by side.
#[inline(always)]
fn value_at(c: &[f64], x: f64) -> f64 {
    let square = x * x;
    let (pairs, last) = c.as_chunks::<2>();
    let mut sum = [last.first().copied().unwrap_or(0.0), 0.0];
    for pair in pairs.iter().rev() {
        sum = [sum[0] * square + pair[0], sum[1] * square + pair[1]];
    }
    sum[0] + x * sum[1]
}

/// p = E(x²) + x O(x²) and p′ = O + 2x (E′ + x O′) at x.
#[inline(always)]
fn value_and_slope(c: &[f64], x: f64) -> [f64; 2] {
    let square = x * x;
    let (pairs, last) = c.as_chunks::<2>();
    let (mut sum, mut change) = ([last.first().copied().unwrap_or(0.0), 0.0], [0.0; 2]);
    for pair in pairs.iter().rev() {
        change = [change[0] * square + sum[0], change[1] * square + sum[1]];
        sum = [sum[0] * square + pair[0], sum[1] * square + pair[1]];
    }
    [sum[0] + x * sum[1], sum[1] + 2.0 * x * (change[0] + x * change[1])]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The Taylor coefficients of cos 2x + `offset`.
    fn cosine(offset: f64) -> [f64; 26] {
        let mut c = [0.0; 26];
        let mut term = 1.0;
        for n in 0..26 {
            if n % 2 == 0 {
                c[n] = if n % 4 == 0 { term } else { -term };
            }
            term *= 2.0 / (n + 1) as f64;
        }
        c[0] += offset;
        c
    }

    #[test]
    fn a_simple_zero() {
        for offset in [-0.9, -0.5, 0.0, 0.3, 0.4] {
            let zero = first_zero(&cosine(offset), 1.0).unwrap();
            assert!((zero - 0.5 * f64::acos(-offset)).abs() < 3e-16, "{offset}: {zero}");
        }
        assert_eq!(first_zero(&cosine(0.42), 1.0), None);
        assert_eq!(first_zero(&cosine(0.0), 0.785), None);
        assert!(first_zero(&cosine(0.0), 0.786).is_some());
    }

    #[test]
    fn a_near_place_lies_just_before_the_zero() {
        for offset in [-0.9, -0.5, 0.0, 0.3, 0.4] {
            let c = cosine(offset);
            let zero = first_zero_of(&c, 1.0, Precision::Full).unwrap();
            let near = first_zero_of(&c, 1.0, Precision::Near).unwrap();
            assert!(0.0 <= zero - near && zero - near < 1e-6 * zero, "{offset}: {near} {zero}");
            let value = |x: f64| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
            assert!((0..=1000).all(|i| value(near * f64::from(i) / 1000.0) >= 0.0));
        }
        assert_eq!(first_zero_of(&cosine(0.42), 1.0, Precision::Near), None);
    }

    #[test]
    fn a_pair_of_zeros_close_together_is_not_jumped_over() {
        // (x − ½)² (2 − x) ± depth.
        for depth in [1e-3, 1e-6, 1e-9, 1e-12] {
            let c = |depth: f64| [0.5 + depth, -2.25, 3.0, -1.0];
            assert_eq!(first_zero(&c(depth), 1.0), None, "{depth}");
            let zero = first_zero(&c(-depth), 1.0).unwrap();
            let half_width = (depth / 1.5).sqrt();
            assert!(
                (zero - (0.5 - half_width)).abs() < half_width * half_width + 1e-16 / half_width,
                "{depth}: {zero}"
            );
        }
    }

    #[test]
    fn the_first_of_many_zeros() {
        // (x − 0.2)(x − 0.2001)(x − 0.5)(x − 0.9)(x + 1)
        let mut c = vec![1.0f64];
        for zero in [0.2, 0.2001, 0.5, 0.9, -1.0] {
            let mut next = vec![0.0; c.len() + 1];
            for (n, c) in c.iter().enumerate() {
                next[n + 1] += c;
                next[n] -= zero * c;
            }
            c = next;
        }
        let sign = c[0].signum();
        let c: Vec<f64> = c.iter().map(|c| sign * c).collect();
        assert!((first_zero(&c, 1.0).unwrap() - 0.2).abs() < 1e-11);
    }

    #[test]
    fn a_multiple_zero_at_the_start_is_no_event() {
        assert!((first_zero(&[0.0, 0.0, 1.0, -1.5], 1.0).unwrap() - 2.0 / 3.0).abs() < 1e-15);
        assert_eq!(first_zero(&[0.0, 0.0, 0.0, 1.0, -0.5], 1.0), None);
        // A flight too short to be told from its start still has its length.
        assert!((first_zero(&[0.0, 1e-20, -1.0], 1.0).unwrap() / 1e-20 - 1.0).abs() < 1e-15);
    }

    #[test]
    fn what_is_not_positive_is_at_its_zero() {
        assert_eq!(first_zero(&[-1.0, 2.0], 1.0), Some(0.0));
        assert_eq!(first_zero(&[0.0, 0.0], 1.0), Some(0.0));
        assert_eq!(first_zero(&[f64::NAN, 1.0], 1.0), Some(0.0));
    }
}
