//! The smooth pieces of the motion laws of a machine.

use crate::motion::{MotionLaw, TransferFunctions};
use crate::numerics::angle::WHOLE_TURN;
use std::f64::consts::{PI, TAU};

/// A smooth piece of the laws: the one that contains `inside`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    inside: f64,
}

impl Place {
    /// The piece around the angle `inside` (rad), which is no border.
    pub fn at(inside: f64) -> Self {
        Place { inside: into_turn(inside) }
    }

    /// U … U⁗ of `law` at `phi` on this piece, also a little outside of it.
    pub fn evaluate(self, law: &MotionLaw, phi: f64) -> TransferFunctions {
        law.at_in(law.segment(self.inside, true), into_turn(phi))
    }
}

/// The angle reduced to [−π, π], for angles of a few turns.
pub fn into_turn(phi: f64) -> f64 {
    if phi.abs() <= PI {
        return phi;
    }
    let turns = (phi / TAU).round();
    phi - turns * WHOLE_TURN.hi - turns * WHOLE_TURN.lo
}

/// The ends of piece `i` between these borders in a turn (rad); the last piece reaches around the turn.
pub fn ends(borders: &[f64], i: usize) -> (f64, f64) {
    (borders[i], borders.get(i + 1).copied().unwrap_or(borders[0] + TAU))
}

/// The ends of all pieces (rad); without borders one piece, from 0 on.
pub fn pieces(borders: &[f64]) -> impl ExactSizeIterator<Item = (f64, f64)> {
    (0..borders.len().max(1)).map(|i| if borders.is_empty() { (0.0, TAU) } else { ends(borders, i) })
}
