//! Certified search for the first root of a polynomial on [0, 1].
//!
//! For x ∈ [0, H] the nested bound a₀ + min(0, H (a₁ + min(0, H (a₂ + …)))) lies below Σ aₙ xⁿ. Where it is positive there is no
//! root. Otherwise the search moves on to the largest H that passes. There it expands the polynomial again: five coefficients and a
//! bound of the rest. Once the polynomial certainly falls all the way to its root, Newton's iteration ends the search. No root can
//! be jumped over, however close to its neighbour it lies.

/// The most coefficients.
const MOST: usize = 32;

/// Coefficients of the local expansion; the rest is bounded.
const LOCAL: usize = 5;

/// C(n, 5).
const CHOOSE_FIVE: [f64; MOST] = {
    let mut table = [0.0; MOST];
    let mut n = LOCAL;
    while n < MOST {
        let m = n as f64;
        table[n] = m * (m - 1.0) * (m - 2.0) * (m - 3.0) * (m - 4.0) / 120.0;
        n += 1;
    }
    table
};

/// After this many steps the place reached counts as the root. Each step that does not end the search at least doubles the distance
/// from a near miss or halves the distance from a root, so some hundred steps exhaust the digits of a number.
const MOST_STEPS: usize = 200;

/// The first root in (0, `end`] of p = Σ cₙ xⁿ, at most 32 coefficients and `end` ≤ 1. p must be positive right of 0; leading zeros
/// of the list are a multiple root at the start, which is no event. Returns 0 if p is not positive right of 0.
pub fn first_root(c: &[f64], end: f64) -> Option<f64> {
    let c = &c[c.iter().position(|&c| c != 0.0).unwrap_or(c.len())..];
    if !c.first().is_some_and(|&c| c > 0.0) {
        return Some(0.0);
    }
    if lower_bound(c, end) > 0.0 {
        return None;
    }
    // |p⁽⁵⁾|/5! on [0, end].
    let fifth = (LOCAL..c.len()).rev().fold(0.0, |sum, n| sum * end + CHOOSE_FIVE[n] * c[n].abs());
    let mut x = 0.0;
    for _ in 0..MOST_STEPS {
        let local = expansion(c, x);
        if !(local[0] > 0.0) {
            return Some(x);
        }
        let rest = end - x;
        let [a0, a1, a2, a3, a4] = local;
        let bounded = [a0, a1, a2, a3, a4, -fifth];
        let mut step = rest;
        let mut bound = lower_bound(&bounded, step);
        if bound > 0.0 {
            return None;
        }
        if let Some(root) = falling(c, &bounded, [x, rest]) {
            return root;
        }
        while !(bound > 0.0) {
            // The root of the secant; the bound is a concave function of the step near a root.
            step *= (a0 / (a0 - bound)).clamp(0.1, 0.95);
            if !(step > f64::EPSILON * x) || step < f64::MIN_POSITIVE {
                return Some(x);
            }
            bound = lower_bound(&bounded, step);
        }
        x += step;
    }
    Some(x)
}

/// The first x ∈ [0, 1] at which Σ cₙ xⁿ leaves the range between `lower` and `upper`, None if it stays inside.
pub fn first_exit<const N: usize>(c: &[f64; N], lower: f64, upper: f64) -> Option<f64> {
    let [mut above, mut below] = [c.map(|c| -c), *c];
    above[0] += upper;
    below[0] -= lower;
    let up = first_root(&above, 1.0);
    first_root(&below, up.unwrap_or(1.0)).or(up)
}

/// A lower bound of Σ cₙ xⁿ on [0, `h`]: the nested bound is the least of the partial sums at `h`.
#[inline(always)]
fn lower_bound(c: &[f64], h: f64) -> f64 {
    range(c, h)[0]
}

/// A lower and an upper bound of Σ cₙ xⁿ on [0, `h`].
#[inline(always)]
pub fn range(c: &[f64], h: f64) -> [f64; 2] {
    let (mut sum, mut power, mut least, mut greatest) = (0.0, 1.0, f64::INFINITY, f64::NEG_INFINITY);
    for c in c {
        sum += c * power;
        power *= h;
        least = if sum < least { sum } else { least };
        greatest = if sum > greatest { sum } else { greatest };
    }
    // Comparisons ignore NaN.
    if sum.is_nan() { [sum; 2] } else { [least, greatest] }
}

/// p⁽ⁿ⁾(x)/n! for n < 5.
#[inline(always)]
fn expansion(c: &[f64], x: f64) -> [f64; LOCAL] {
    if x == 0.0 {
        return std::array::from_fn(|n| c.get(n).copied().unwrap_or(0.0));
    }
    let mut a = [0.0; LOCAL];
    for &c in c.iter().rev() {
        for n in (1..LOCAL).rev() {
            a[n] = a[n] * x + a[n - 1];
        }
        a[0] = a[0] * x + c;
    }
    a
}

/// The root if p certainly falls from x on until it reaches zero, or Some(None) if that root lies beyond `rest`. None if p may turn
/// before. `local`: the coefficients about x and the bound of the rest.
fn falling(c: &[f64], local: &[f64; LOCAL + 1], [x, rest]: [f64; 2]) -> Option<Option<f64>> {
    let [value, slope, second, third, fourth, fifth] = *local;
    if slope >= 0.0 {
        return None;
    }
    let reach = (-2.0 * value / slope).min(rest);
    let curving = [2.0 * second, 3.0 * third, 4.0 * fourth, -5.0 * fifth];
    let steepest = slope + curving.iter().rev().fold(0.0, |above: f64, c| reach * (c + above.max(0.0))).max(0.0);
    if steepest >= 0.0 {
        return None;
    }
    if value_and_slope(c, x + reach)[0] > 0.0 {
        return if reach == rest { Some(None) } else { None };
    }
    // Newton's iteration, kept between the ends that enclose the root.
    let (mut low, mut high) = (x, x + reach);
    let mut root = x - value / slope;
    for _ in 0..60 {
        if !(root > low && root < high) {
            root = 0.5 * (low + high);
        }
        let [value, slope] = value_and_slope(c, root);
        if value > 0.0 {
            low = root
        } else {
            high = root
        }
        let next = root - value / slope;
        if (next - root).abs() <= 2.0 * f64::EPSILON * root {
            break;
        }
        root = next;
    }
    Some(Some(root.clamp(low, high)))
}

/// p = E(x²) + x O(x²) and p′ = O + 2x (E′ + x O′) at x, even and odd terms side by side.
#[inline(always)]
pub fn value_and_slope(c: &[f64], x: f64) -> [f64; 2] {
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
    fn a_simple_root() {
        for offset in [-0.9, -0.5, 0.0, 0.3, 0.4] {
            let zero = first_root(&cosine(offset), 1.0).unwrap();
            assert!((zero - 0.5 * f64::acos(-offset)).abs() < 3e-16, "{offset}: {zero}");
        }
        assert_eq!(first_root(&cosine(0.42), 1.0), None);
        assert_eq!(first_root(&cosine(0.0), 0.785), None);
        // At the very end.
        assert!((first_root(&[1.0, -1.0], 1.0).unwrap() - 1.0).abs() < 1e-15);
        assert!(first_root(&cosine(0.0), 0.786).is_some());
    }

    #[test]
    fn a_pair_of_roots_close_together_is_not_jumped_over() {
        // (x − ½)² (2 − x) ± depth.
        for depth in [1e-3, 1e-6, 1e-9, 1e-12] {
            let c = |depth: f64| [0.5 + depth, -2.25, 3.0, -1.0];
            assert_eq!(first_root(&c(depth), 1.0), None, "{depth}");
            let zero = first_root(&c(-depth), 1.0).unwrap();
            let half_width = (depth / 1.5).sqrt();
            assert!(
                (zero - (0.5 - half_width)).abs() < half_width * half_width + 1e-16 / half_width,
                "{depth}: {zero}"
            );
        }
    }

    #[test]
    fn bounds_and_values_of_a_polynomial() {
        // The partial sums of 1 + 3x − 8x² + x³ at ½ are 1, 2.5, 0.5 and 0.625.
        let c = [1.0, 3.0, -8.0, 1.0];
        assert_eq!((range(&c, 0.5), range(&c[..1], 0.5)), ([0.5, 2.5], [1.0; 2]));
        assert!(range(&[f64::NAN, 1.0], 0.5)[1].is_nan());
        for n in 0..=6 {
            let c: Vec<f64> = (0..n).map(|k| f64::from(k * k + 1)).collect();
            let value: f64 = c.iter().zip(0..).map(|(c, k)| c * 3f64.powi(k)).sum();
            let slope: f64 = c.iter().zip(0..).skip(1).map(|(c, k)| c * f64::from(k) * 3f64.powi(k - 1)).sum();
            assert_eq!(value_and_slope(&c, 3.0), [value, slope], "{n}");
        }
    }

    #[test]
    fn a_polynomial_falls_for_sure_until_its_slope_may_vanish() {
        // v − s x + a xⁿ within 2 v/s: the slope vanishes there if n a (2 v/s)ⁿ⁻¹ = s.
        let (v, s) = (0.7, 3.0);
        let sure = |rise: [f64; 4], rest: f64| {
            let c = [v, -s, rise[0], rise[1], rise[2], rise[3]];
            falling(&c, &[v, -s, rise[0], rise[1], rise[2], -rise[3].abs()], [0.0, rest])
        };
        let limit = |n: usize| s / (n as f64 * (2.0 * v / s).powi(n as i32 - 1));
        for n in 2..6 {
            for (part, falls) in [(-1.01, n < 5), (0.99, true), (1.01, false)] {
                let mut rise = [0.0; 4];
                rise[n - 2] = part * limit(n);
                assert_eq!(sure(rise, 1.0).is_some(), falls, "{part} {n}");
                // A neighbour takes its share; one that makes p fall faster does not count.
                rise[n - 2] *= 0.5;
                let other = if n < 5 { n + 1 } else { 2 };
                rise[other - 2] = 0.5 * part.abs() * limit(other);
                assert_eq!(sure(rise, 1.0).is_some(), falls, "{part} {n} {other}");
            }
        }
        let root = sure([0.0; 4], 1.0).unwrap().unwrap();
        assert!((root - v / s).abs() < 1e-16);
        // The root lies beyond the rest, or the polynomial may still turn beyond it.
        assert_eq!(sure([0.0; 4], 0.9 * v / s), Some(None));
        assert_eq!(falling(&[v, s], &[v, s, 0.0, 0.0, 0.0, 0.0], [0.0, 1.0]), None);
        assert_eq!(falling(&[v, -s, 0.0, 0.0, 0.0, 0.0, 1e3], &[v, -s, 0.0, 0.0, 0.0, 0.0], [0.0, 1.0]), None);
    }

    #[test]
    fn products_of_known_factors() {
        let mut seed = 1u64;
        let mut random = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        for case in 0..20_000 {
            // Real roots, some close to each other, times a factor without real roots: (x − a)² + b², b not too small.
            let (mut c, mut first) = (vec![1.0], f64::INFINITY);
            let mut by = |factor: &[f64]| {
                let mut product = vec![0.0; c.len() + factor.len() - 1];
                for (i, a) in c.iter().enumerate() {
                    for (j, b) in factor.iter().enumerate() {
                        product[i + j] += a * b;
                    }
                }
                c = product;
            };
            let near = random();
            for _ in 0..case % 4 {
                let root = if random() < 0.5 { near + 0.05 * random() } else { 1.5 * random() } + 1e-3;
                first = first.min(root);
                by(&[1.0, -1.0 / root]);
            }
            for _ in 0..(case / 4) % 3 {
                let (a, b) = (random(), 0.02 + 0.2 * random());
                by(&[1.0 + (b / a).powi(2), -2.0 / a, 1.0 / (a * a)]);
            }
            let rounding =
                1e-15 * c.iter().map(|c| c.abs()).sum::<f64>() / value_and_slope(&c, first.min(1.0))[1].abs();
            match first_root(&c, 1.0) {
                Some(root) => assert!((root - first).abs() <= 1e-15 + 10.0 * rounding, "{case}: {root} {first}"),
                None => assert!(first > 1.0, "{case}: {first}"),
            }
        }
    }

    #[test]
    fn high_powers_are_not_overlooked() {
        let mut binomial = 1;
        for n in LOCAL..MOST {
            assert_eq!(CHOOSE_FIVE[n], f64::from(binomial));
            binomial = binomial * (n + 1) as i32 / (n + 1 - LOCAL) as i32;
            // 1 − 1.5 (s x)ⁿ, and ((s x)ⁿ − ½)² ± 10⁻⁶ if it fits in.
            for s in [1.0, 1e3] {
                let mut c = [0.0; MOST];
                let power = |n: usize| f64::powi(s, n as i32);
                (c[0], c[n]) = (1.0, -1.5 * power(n));
                let root = (2.0f64 / 3.0).powf(1.0 / n as f64);
                assert!((s * first_root(&c, 1.0 / s).unwrap() - root).abs() < 1e-15, "{n}");
                if 2 * n < MOST {
                    (c[0], c[n], c[2 * n]) = (0.25 - 1e-6, -power(n), power(2 * n));
                    let root = (0.5f64 - 1e-3).powf(1.0 / n as f64);
                    assert!((s * first_root(&c, 1.0 / s).unwrap() - root).abs() < 1e-13, "{n}");
                    c[0] = 0.25 + 1e-6;
                    assert_eq!(first_root(&c, 1.0 / s), None, "{n}");
                }
            }
        }
    }

    #[test]
    fn the_first_of_many_roots() {
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
        assert!((first_root(&c, 1.0).unwrap() - 0.2).abs() < 1e-11);
    }

    #[test]
    fn a_multiple_root_at_the_start_is_no_event() {
        assert!((first_root(&[0.0, 0.0, 1.0, -1.5], 1.0).unwrap() - 2.0 / 3.0).abs() < 1e-15);
        assert_eq!(first_root(&[0.0, 0.0, 0.0, 1.0, -0.5], 1.0), None);
        // A flight too short to be distinguished from its start still has its length.
        assert!((first_root(&[0.0, 1e-20, -1.0], 1.0).unwrap() / 1e-20 - 1.0).abs() < 1e-15);
    }

    #[test]
    fn what_is_not_positive_is_at_its_root() {
        assert_eq!(first_root(&[-1.0, 2.0], 1.0), Some(0.0));
        assert_eq!(first_root(&[0.0, 0.0], 1.0), Some(0.0));
        assert_eq!(first_root(&[f64::NAN, 1.0], 1.0), Some(0.0));
    }

    #[test]
    fn the_first_of_several_exits() {
        // 4x(1 − x) leaves [0, 0.75] at x = ¼ and comes back at ¾.
        let c = [0.0, 4.0, -4.0];
        assert!((first_exit(&c, -0.1, 0.75).unwrap() - 0.25).abs() < 1e-15);
        assert_eq!(first_exit(&c, -0.1, 1.0 + 1e-15), None);
        assert_eq!(first_exit(&c, 0.1, 1.0), Some(0.0));
        assert!((first_exit(&[1.0, -3.0], 0.0, 2.0).unwrap() - 1.0 / 3.0).abs() < 1e-15);
    }

    #[test]
    fn a_narrow_excursion_between_two_roots_is_found() {
        // −(x − ½)² ((x − ½)² + 1) + 1e-12 rises above zero on 2e-6 of the interval.
        let y = |x: f64| 1e-12 - (x - 0.5f64).powi(2) * ((x - 0.5f64).powi(2) + 1.0);
        let x = first_exit(&[1e-12 - 0.3125, 1.5, -2.5, 2.0, -1.0], -1.0, 0.0).unwrap();
        assert!((x - (0.5 - 1e-6)).abs() < 1e-9 && y(x) > -1e-15, "{x}");
    }
}
