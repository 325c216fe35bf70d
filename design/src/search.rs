//! Zeros and maxima of functions of one variable that cost some time to evaluate.
//!
//! Source: R. P. Brent, *Algorithms for Minimization without Derivatives*, Prentice-Hall 1973, chapters 4 and 5.

use std::f64::consts::TAU;

/// A value and its angle.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Extreme {
    /// φ (rad).
    pub phi: f64,
    /// In SI units, with its sign.
    pub value: f64,
}

impl Extreme {
    /// The one with the greatest measure; of those that differ by roundings alone the one at the smallest angle of the turn.
    pub fn greatest(all: impl IntoIterator<Item = Extreme>, measure: impl Fn(f64) -> f64) -> Option<Extreme> {
        let in_turn = |of: Extreme| Extreme { phi: of.phi.rem_euclid(TAU) % (TAU - 1e-9), ..of };
        let all: Vec<Extreme> = all.into_iter().map(in_turn).collect();
        let most = all.iter().map(|of| measure(of.value)).max_by(f64::total_cmp)?;
        let tied = all.into_iter().filter(|of| measure(of.value) >= most - 1e-9 * most.abs());
        tied.min_by(|a, b| a.phi.total_cmp(&b.phi))
    }
}

/// Evaluations after which a search ends: bisection alone takes 60 from one end of a `f64` to the last digit.
const MOST_EVALUATIONS: usize = 120;

/// A zero of `f` between the ends of an interval with these values of different signs, to the rounding of x or to `tolerance`.
/// Brent's method.
pub fn zero(f: &mut dyn FnMut(f64) -> f64, ends: [f64; 2], values: [f64; 2], tolerance: f64) -> f64 {
    let ([mut a, mut b], [mut fa, mut fb]) = (ends, values);
    let (mut c, mut fc) = (a, fa);
    let mut step = b - a;
    let mut last = step;
    for _ in 0..MOST_EVALUATIONS {
        if (fb > 0.0) == (fc > 0.0) {
            (c, fc) = (a, fa);
            step = b - a;
            last = step;
        }
        if fc.abs() < fb.abs() {
            (a, b, c) = (b, c, b);
            (fa, fb, fc) = (fb, fc, fb);
        }
        let least = 2.0 * f64::EPSILON * b.abs() + 0.5 * tolerance;
        let half = 0.5 * (c - b);
        if half.abs() <= least || fb == 0.0 || !fb.is_finite() {
            return b;
        }
        if last.abs() < least || fa.abs() <= fb.abs() {
            (step, last) = (half, half);
        } else {
            let s = fb / fa;
            let (mut p, mut q) = if a == c {
                (2.0 * half * s, 1.0 - s)
            } else {
                let (q, r) = (fa / fc, fb / fc);
                (s * (2.0 * half * q * (q - r) - (b - a) * (r - 1.0)), (q - 1.0) * (r - 1.0) * (s - 1.0))
            };
            if p > 0.0 {
                q = -q
            } else {
                p = -p
            }
            if 2.0 * p < (3.0 * half * q - (least * q).abs()).min((last * q).abs()) {
                (last, step) = (step, p / q);
            } else {
                (step, last) = (half, half);
            }
        }
        (a, fa) = (b, fb);
        b += if step.abs() > least { step } else { least.copysign(half) };
        fb = f(b);
    }
    b
}

/// The zero of `f` between `a` and `b`, where it has different signs, to the rounding of x.
pub fn root(mut f: impl FnMut(f64) -> f64, ends: [f64; 2]) -> f64 {
    let values = ends.map(&mut f);
    zero(&mut f, ends, values, 0.0)
}

/// Place and value of the maximum of `f` between `a` and `b`, the place to `tolerance`, so the value to its square. Nine
/// samples find the highest part, Brent's method the place in it.
pub fn maximum(f: &mut dyn FnMut(f64) -> f64, [a, b]: [f64; 2], tolerance: f64) -> (f64, f64) {
    const SAMPLES: usize = 9;
    // Denser towards the ends, where a narrow peak may lie.
    let place = |i: usize| {
        let turn = std::f64::consts::PI * i as f64 / (SAMPLES + 1) as f64;
        a + (b - a) * 0.5 * (1.0 - turn.cos())
    };
    let values: Vec<f64> = (1..=SAMPLES).map(|i| f(place(i))).collect();
    let best = (0..SAMPLES).max_by(|i, j| values[*i].total_cmp(&values[*j])).unwrap_or(0);
    summit(f, [place(best), place(best + 2)], (place(best + 1), values[best]), tolerance)
}

/// The maximum of `f` from a point (x, f(x)) that is at least as high as the ends, on or between them.
pub fn summit(f: &mut dyn FnMut(f64) -> f64, ends: [f64; 2], from: (f64, f64), tolerance: f64) -> (f64, f64) {
    const GOLDEN: f64 = 0.381_966_011_250_105_2;
    let ([mut low, mut high], (mut x, mut fx)) = (ends, from);
    let (mut w, mut fw, mut v, mut fv) = (x, fx, x, fx);
    let (mut step, mut last) = (0.0_f64, 0.0_f64);
    for _ in 0..MOST_EVALUATIONS {
        let middle = 0.5 * (low + high);
        let least = f64::EPSILON * x.abs() + tolerance;
        if (x - middle).abs() <= 2.0 * least - 0.5 * (high - low) {
            break;
        }
        let mut parabolic = false;
        if last.abs() > least {
            let r = (x - w) * (fv - fx);
            let q = (x - v) * (fw - fx);
            let p = (x - v) * q - (x - w) * r;
            let q = 2.0 * (q - r);
            let (p, q) = if q > 0.0 { (-p, q) } else { (p, -q) };
            if p.abs() < (0.5 * q * last).abs() && p > q * (low - x) && p < q * (high - x) {
                (last, step) = (step, p / q);
                let u = x + step;
                if u - low < 2.0 * least || high - u < 2.0 * least {
                    step = least.copysign(middle - x);
                }
                parabolic = true;
            }
        }
        if !parabolic {
            last = if x < middle { high - x } else { low - x };
            step = GOLDEN * last;
        }
        let u = x + if step.abs() >= least { step } else { least.copysign(step) };
        let fu = f(u);
        if fu >= fx {
            if u < x {
                high = x
            } else {
                low = x
            }
            (v, fv, w, fw, x, fx) = (w, fw, x, fx, u, fu);
        } else {
            if u < x {
                low = u
            } else {
                high = u
            }
            if fu >= fw || w == x {
                (v, fv, w, fw) = (w, fw, u, fu);
            } else if fu >= fv || v == x || v == w {
                (v, fv) = (u, fu);
            }
        }
    }
    (x, fx)
}

/// The local maxima of `f` that may reach `least`, searched at `candidates` and then between their neighbours.
pub fn local_maxima(candidates: &[f64], least: f64, f: &dyn Fn(f64) -> f64) -> Vec<f64> {
    let values: Vec<f64> = candidates.iter().map(|x| f(*x)).collect();
    let last = candidates.len() - 1;
    let beside = |i: usize| [i.saturating_sub(1), (i + 1).min(last)];
    let highest = |i: &usize| beside(*i).iter().all(|j| values[*i] >= values[*j]);
    // Between samples a maximum rises by less than these differ, but for kinks and poles; poles are candidates.
    let reaches = |i: &usize| {
        let lowest = beside(*i).iter().fold(f64::INFINITY, |lowest, j| lowest.min(values[*j]));
        let highest = 2.0 * values[*i] - lowest;
        highest >= least || highest.is_nan()
    };
    let place = |i: usize| {
        let ends = beside(i).map(|j| candidates[j]);
        // At 1e-8 of the distance a maximum is flat to rounding.
        summit(&mut |x| f(x), ends, (candidates[i], values[i]), 1e-8 * (ends[1] - ends[0])).0
    };
    (0..=last).filter(highest).filter(reaches).map(place).collect()
}

/// The ends (rad) of the segments between these angles of a turn, the last one around it.
pub fn segments(breakpoints: &[f64]) -> Vec<[f64; 2]> {
    let Some(first) = breakpoints.first() else { return vec![[0.0, TAU]] };
    let next = breakpoints.iter().skip(1).copied().chain([first + TAU]);
    breakpoints.iter().zip(next).map(|(from, to)| [*from, to]).collect()
}

/// The greatest value of a function of segment and angle (rad) that is smooth on each of the segments, ends included.
pub fn greatest(segments: &[[f64; 2]], f: impl Fn(usize, f64) -> f64) -> Extreme {
    highest(segments, &f)
}

/// [`greatest`], compiled once for all functions.
fn highest(segments: &[[f64; 2]], f: &dyn Fn(usize, f64) -> f64) -> Extreme {
    // Eight to a wave of the order 512.
    const SAMPLES: f64 = 4096.0 / TAU;
    let higher = |a: Extreme, b: Extreme| if b.value > a.value { b } else { a };
    let mut greatest = Extreme { phi: 0.0, value: f64::NEG_INFINITY };
    for (i, [from, to]) in segments.iter().enumerate() {
        let parts = ((to - from) * SAMPLES).ceil().max(8.0);
        let places: Vec<f64> = (0..=parts as usize).map(|k| from + (to - from) * k as f64 / parts).collect();
        let at = |phi: f64| Extreme { phi, value: f(i, phi) };
        greatest = places.iter().map(|phi| at(*phi)).fold(greatest, higher);
        // A constant has no peak to search.
        let summits = local_maxima(&places, greatest.value.next_up(), &|phi| f(i, phi));
        greatest = summits.into_iter().map(at).fold(greatest, higher);
    }
    greatest
}

/// The local maxima of a function with these values at ascending places, by its slope and bend; each with the index of the
/// closest place.
pub fn crests(places: &[f64], values: &[f64], slopes: &dyn Fn(f64) -> [f64; 2]) -> Vec<(usize, f64)> {
    let last = places.len() - 1;
    let beside = |i: usize| [i.saturating_sub(1), (i + 1).min(last)];
    let highest = |i: &usize| beside(*i).iter().all(|j| values[*i] >= values[*j]);
    let crest = |i: usize| (i, stationary(places[i], beside(i).map(|j| places[j]), slopes));
    let mut crests: Vec<(usize, f64)> = (0..=last).filter(highest).map(crest).collect();
    // Two places of equal height lead to one maximum.
    crests.dedup_by(|a, b| (a.1 - b.1).abs() < 1e-9);
    crests
}

/// The maximum near `x` between two ends of a function with this slope and bend, by Newton's method on the slope.
pub fn stationary(mut x: f64, [low, high]: [f64; 2], f: &dyn Fn(f64) -> [f64; 2]) -> f64 {
    for _ in 0..12 {
        let [slope, bend] = f(x);
        let next = if bend < 0.0 { x - slope / bend } else { x + slope.signum() * (high - low) };
        let next = next.clamp(low, high);
        if (next - x).abs() <= 4.0 * f64::EPSILON * (1.0 + x.abs()) {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_and_maxima_are_found_to_their_last_digits() {
        let mut count = 0;
        let mut f = |x: f64| {
            count += 1;
            x.cos() - x
        };
        let (a, b) = (f(0.0), f(1.0));
        assert!((zero(&mut f, [0.0, 1.0], [a, b], 0.0) - 0.739_085_133_215_160_6).abs() < 1e-15);
        assert!(count < 12, "{count} evaluations");
        let (x, y) = maximum(&mut |x: f64| x.sin() * (-x).exp(), [0.0, 3.0], 1e-9);
        assert!((x - std::f64::consts::FRAC_PI_4).abs() < 1e-7 && (y - 0.322_396_941_945_1).abs() < 1e-12, "{x} {y}");
        // A maximum at the end.
        let (x, _) = maximum(&mut |x: f64| x, [0.0, 1.0], 1e-9);
        assert!(x > 0.97);
        // A step, on which only bisection makes progress.
        assert!((zero(&mut |x| if x < 0.3 { -1.0 } else { 1.0 }, [0.0, 1.0], [-1.0, 1.0], 0.0) - 0.3).abs() < 1e-15);
    }
}
