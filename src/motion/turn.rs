//! Angles on the turn, for laws that consist of pieces.

use crate::numerics::angle::WHOLE_TURN;
use std::f64::consts::{PI, TAU};

/// An angle this near a breakpoint counts as on it (rad): some roundings of an angle within [−2π, 2π].
const ON_BREAKPOINT: f64 = 4e-15;

/// `phi` moved by whole turns to within half a turn of `middle`.
pub fn near(phi: f64, middle: f64) -> f64 {
    let distance = phi - middle;
    if distance.abs() <= PI {
        return phi;
    }
    // One turn is the usual case and needs no division.
    let turns = if distance.abs() <= 3.0 * PI { 1.0_f64.copysign(distance) } else { (distance / TAU).round() };
    back(phi, turns)
}

/// `phi` minus this whole number of turns.
pub fn back(phi: f64, turns: f64) -> f64 {
    phi - turns * WHOLE_TURN.hi - turns * WHOLE_TURN.lo
}

/// `phi` moved by whole turns into [0, 2π).
pub fn reduce(phi: f64) -> f64 {
    let reduced = near(phi, PI);
    if reduced < 0.0 {
        // Half a rounding below zero, which no sum with a turn would show.
        0.0
    } else if reduced >= TAU {
        reduced - TAU
    } else {
        reduced
    }
}

/// The segment between the ascending `breakpoints` in [0, 2π) that holds `phi`; on a breakpoint the segment after it (`forward`) or
/// before it. The last segment runs around the turn.
pub fn segment(breakpoints: &[f64], phi: f64, forward: bool) -> usize {
    let shifted = reduce(phi + if forward { ON_BREAKPOINT } else { -ON_BREAKPOINT });
    let after = breakpoints.partition_point(|&b| b <= shifted);
    if after == 0 { breakpoints.len().saturating_sub(1) } else { after - 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_breakpoint_is_found_from_either_side_and_in_any_turn() {
        let breakpoints = [0.0, 1.0, 5.0];
        for turns in [-1.0, 0.0, 1.0] {
            for (i, b) in breakpoints.into_iter().enumerate() {
                let phi = b - turns * TAU;
                assert_eq!(segment(&breakpoints, phi, true), i, "{phi}");
                assert_eq!(segment(&breakpoints, phi, false), (i + 2) % 3, "{phi}");
                assert_eq!(segment(&breakpoints, phi + 1e-9, false), i, "{phi}");
                assert_eq!(segment(&breakpoints, phi - 1e-9, true), (i + 2) % 3, "{phi}");
            }
        }
        assert_eq!(segment(&[2.0], 1.0, true), 0);
        assert_eq!(segment(&[], 1.0, true), 0);
        assert_eq!(segment(&breakpoints, f64::NAN, true), 2);
    }

    #[test]
    fn reduced_angles_lie_in_the_turn() {
        for phi in [-TAU, -1e-20, -1.0, 0.0, 3.0, TAU, 2.0 * TAU, -7.0] {
            let reduced = reduce(phi);
            assert!((0.0..TAU).contains(&reduced), "{phi}: {reduced}");
            assert!((reduced.sin() - phi.sin()).abs() < 1e-15, "{phi}");
        }
    }
}
