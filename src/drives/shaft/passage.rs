//! Passages of a shaft through breakpoints of a law.

use super::cam_turn::{ON_BREAKPOINT, OVERRUN};
use crate::motion::turn::near;
use crate::numerics::first_root::{first_exit, first_root};
use std::f64::consts::TAU;

/// The shaft leaves a segment of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// The place on its way, from 0 to 1.
    pub at: f64,
    /// The breakpoint (rad).
    pub border: f64,
    /// The segment after it.
    pub segment: usize,
}

/// The first passage on the way φ + Σ wayⱼ xʲ, 1 ≤ j, x ∈ [0, 1], which begins in a `segment` between these `breakpoints` or on its
/// end; it is detected `overrun` (rad) after the breakpoint. A shaft at rest on a breakpoint does not pass it.
pub fn first_passage<const N: usize>(
    breakpoints: &[f64],
    segment: usize,
    phi: f64,
    way: &[f64; N],
    overrun: f64,
) -> Option<Passage> {
    let (count, lower) = (breakpoints.len(), *breakpoints.get(segment)?);
    let upper = breakpoints.get(segment + 1).copied().unwrap_or(breakpoints[0] + TAU);
    // In the turn whose angle is nearest to the middle: a start within a rounding before the segment must not count as almost a
    // turn after it.
    let angle = near(phi, 0.5 * (lower + upper));
    let (at, up) = first_end([angle - (lower - overrun), upper + overrun - angle], count == 1, way, overrun)?;
    let segment = (segment + if up { 1 } else { count - 1 }) % count;
    Some(Passage { at, border: if up { breakpoints[segment] } else { lower }, segment })
}

/// The x ∈ [0, 1] at which the way Σ wayⱼ xʲ, 1 ≤ j, reaches an end of a segment, and whether that is the upper one. The `ends` are
/// the distances down and up (rad), `overrun` included; the `only` segment of a law ends where it starts.
pub fn first_end<const N: usize>(ends: [f64; 2], only: bool, way: &[f64; N], overrun: f64) -> Option<(f64, bool)> {
    let mut left = ends.map(|left| if left < overrun + ON_BREAKPOINT { overrun } else { left });
    if only && left.contains(&overrun) {
        // The motion is about to cross the whole segment.
        left = if way[1] < 0.0 { [TAU + overrun, overrun] } else { [overrun, TAU + overrun] };
    }
    let [down, up] = [(1.0, left[0]), (-1.0, left[1])].map(|(sign, left)| {
        let mut rest = way.map(|a| sign * a);
        rest[0] = left;
        if rest == [0.0; N] { None } else { first_root(&rest, 1.0) }
    });
    match (down, up) {
        (down, Some(at)) if down.is_none_or(|down| at < down) => Some((at, true)),
        (down, _) => down.map(|at| (at, false)),
    }
}

/// The x ∈ [0, 1] at which the integrated angle Σ wayⱼ xʲ leaves the segment from `low` to `high` (rad), and whether upwards.
pub fn exit<const N: usize>(way: &[f64; N], (low, high): (f64, f64)) -> Option<(f64, bool)> {
    // After a step that ended slightly before a breakpoint, or beyond it, the next one starts there.
    let at = first_exit(way, low.min(way[0]) - OVERRUN, high.max(way[0]) + OVERRUN)?;
    let there = way.iter().rev().fold(0.0, |sum, c| sum * at + c);
    Some((at, there > 0.5 * (low + high)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BREAKPOINTS: [f64; 3] = [0.5, 2.0, 4.0];

    /// `at`, border and segment of a passage that must happen.
    fn passed(found: Option<Passage>, at: f64, border: f64, segment: usize) {
        let found = found.expect("a passage");
        assert!((found.at - at).abs() < 1e-14, "{} instead of {at}", found.at);
        assert_eq!((found.border, found.segment), (border, segment));
    }

    #[test]
    fn each_border_is_passed_in_either_sense_and_in_any_turn() {
        for turns in [-2.0, 0.0, 1.0] {
            for (segment, lower, upper) in [(0, 0.5, 2.0), (1, 2.0, 4.0), (2, 4.0, 0.5 + TAU)] {
                for part in [0.001, 0.3, 0.999] {
                    let inside = lower + part * (upper - lower);
                    let from = |way| first_passage(&BREAKPOINTS, segment, inside + turns * TAU, &[0.0, way], 0.01);
                    let next = (segment + 1) % 3;
                    passed(from(8.0), (upper + 0.01 - inside) / 8.0, BREAKPOINTS[next], next);
                    passed(from(-8.0), (inside - lower + 0.01) / 8.0, BREAKPOINTS[segment], (segment + 2) % 3);
                    assert_eq!((from(upper - inside), from(lower - inside), from(0.0)), (None, None, None));
                }
            }
        }
        assert_eq!(first_passage(&[], 0, 1.0, &[0.0, 8.0], 0.01), None);
    }

    #[test]
    fn on_a_way_there_and_back_the_first_border_counts() {
        // 3 ± (10 x − 20 x²) reaches 1.01 beyond 3 at x₁ and comes back through 1.01 on the other side at x₂ > 1/2.
        let first = (10.0 - (100.0 - 80.0 * 1.01_f64).sqrt()) / 40.0;
        let back = (10.0 + (100.0 + 80.0 * 1.01_f64).sqrt()) / 40.0;
        assert!(first < back && back < 1.0);
        let from = |sign: f64| first_passage(&BREAKPOINTS, 1, 3.0, &[0.0, sign * 10.0, sign * -20.0], 0.01);
        passed(from(1.0), first, 4.0, 2);
        passed(from(-1.0), first, 2.0, 0);
    }

    #[test]
    fn what_starts_on_a_border_passes_it_at_once_or_rests_on_it() {
        // A few roundings before it count as on it; anything beyond counts from there.
        for phi in [4.0 - 5e-15, 4.0, 4.005] {
            passed(first_passage(&BREAKPOINTS, 1, phi, &[0.0, 2.0], 0.01), 0.005, 4.0, 2);
            let at_once = first_passage(&BREAKPOINTS, 1, phi, &[0.0, 2.0], 0.0).unwrap();
            assert_eq!((at_once.at, at_once.segment), (0.0, 2));
            assert_eq!(first_passage(&BREAKPOINTS, 1, phi, &[0.0, 0.0], 0.0), None);
        }
        let before = first_passage(&BREAKPOINTS, 1, 4.0 - 5e-14, &[0.0, 2.0], 0.0).unwrap();
        assert!((before.at / 2.5e-14 - 1.0).abs() < 0.05, "{}", before.at);
    }

    #[test]
    fn the_only_segment_is_crossed_from_its_end_to_its_start() {
        let of = |phi: f64, way: [f64; 3]| first_passage(&[1.0], 0, phi, &way, 0.01);
        for phi in [1.0, 1.0 + TAU] {
            passed(of(phi, [0.0, 8.0, 0.0]), (TAU + 0.01) / 8.0, 1.0, 0);
            passed(of(phi, [0.0, -8.0, 0.0]), (TAU + 0.01) / 8.0, 1.0, 0);
            // From rest.
            passed(of(phi, [0.0, 0.0, 8.0]), ((TAU + 0.01) / 8.0).sqrt(), 1.0, 0);
        }
        passed(of(3.0, [0.0, 8.0, 0.0]), (TAU - 2.0 + 0.01) / 8.0, 1.0, 0);
        passed(of(3.0, [0.0, -8.0, 0.0]), 2.01 / 8.0, 1.0, 0);
    }
}
