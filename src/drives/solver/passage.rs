//! When a prescribed shaft passes the next breakpoint of a law.

use crate::drives::shaft::cam_turn::ON_BREAKPOINT;
use crate::motion::turn::near;
use crate::numerics::first_root::first_root;
use std::f64::consts::TAU;

/// The shaft leaves a segment of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// Where on its way, from 0 to 1.
    pub at: f64,
    /// The breakpoint (rad).
    pub border: f64,
    /// The segment behind it.
    pub segment: usize,
}

/// The first passage on the way φ + Σ wayⱼ xʲ, 1 ≤ j, x ∈ [0, 1], which begins in a `segment` between these `breakpoints` or
/// on an end of it; seen `overrun` (rad) behind the breakpoint. A shaft that rests on a breakpoint does not pass it.
pub fn first_passage<const N: usize>(
    breakpoints: &[f64],
    segment: usize,
    phi: f64,
    way: &[f64; N],
    overrun: f64,
) -> Option<Passage> {
    let (count, lower) = (breakpoints.len(), *breakpoints.get(segment)?);
    let upper = breakpoints.get(segment + 1).copied().unwrap_or(breakpoints[0] + TAU);
    // In the turn that has it nearest to the middle: what is a rounding before the start is not almost a turn behind it.
    let angle = near(phi, 0.5 * (lower + upper));
    let mut left = [angle - (lower - overrun), upper + overrun - angle];
    left = left.map(|left| if left < overrun + ON_BREAKPOINT { overrun } else { left });
    if count == 1 && left.contains(&overrun) {
        // The end of the only segment is its start: the motion is about to cross all of it.
        left = if way[1] < 0.0 { [TAU + overrun, overrun] } else { [overrun, TAU + overrun] };
    }
    let [down, up] = [(1.0, left[0]), (-1.0, left[1])].map(|(sign, left)| {
        let mut rest = way.map(|a| sign * a);
        rest[0] = left;
        if rest == [0.0; N] { None } else { first_root(&rest, 1.0) }
    });
    match (down, up) {
        (down, Some(at)) if down.is_none_or(|down| at < down) => {
            Some(Passage { at, border: breakpoints[(segment + 1) % count], segment: (segment + 1) % count })
        }
        (down, _) => down.map(|at| Passage { at, border: lower, segment: (segment + count - 1) % count }),
    }
}
