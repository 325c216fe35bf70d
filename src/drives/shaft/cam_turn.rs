//! A turn of the cam at constant speed as the period of a tabulated equation.

use crate::motion::turn;
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use std::f64::consts::TAU;

/// How far the smooth continuation is followed beyond a breakpoint (rad). It exceeds the rounding of an angle, so that the passage
/// is certain; the speed is corrected for it to first order only.
pub const OVERRUN: f64 = 1e-14;

/// A motion this near a breakpoint (rad), some roundings of an angle, has just come from it or begins there.
pub const ON_BREAKPOINT: f64 = 1e-14;

/// A breakpoint this near the start of the turn counts as lying there (rad): more than the rounding of an angle.
pub const SLACK: f64 = 1e-12;

/// Slower shafts count as at rest (rad/s): above this its square and the square of the time of a turn neither underflow nor
/// overflow, with any masses.
pub const SLOWEST: f64 = 1e-100;

/// Whether a cam at the constant speed `w` (rad/s) turns; otherwise it is at rest within any time that can be simulated.
pub fn turns(w: f64) -> bool {
    w.abs() >= SLOWEST
}

/// A turn of the cam from `phi_start` (rad) at the constant speed `w` (rad/s), at which it turns.
pub struct CamTurn<'a> {
    /// The breakpoints of the law, ascending.
    breakpoints: &'a [f64],
    w: f64,
    phi_start: f64,
    /// The segment of the law with which the turn starts.
    segment: usize,
}

impl<'a> CamTurn<'a> {
    /// None if the cam is at rest.
    pub fn new(breakpoints: &'a [f64], w: f64, phi_start: f64) -> Option<Self> {
        let start = angle::reduce(Double::from(phi_start));
        let segment = turn::segment(breakpoints, start + SLACK * w.signum(), 0.0 < w);
        turns(w).then_some(CamTurn { breakpoints, w, phi_start, segment })
    }

    /// The duration of one of `parts` equal parts of the turn (s).
    pub fn period(&self, parts: usize) -> Double {
        angle::WHOLE_TURN.divide(Double::from(parts as f64 * self.w.abs()))
    }

    /// The segment of the law in the interval of this number.
    pub fn segment(&self, interval: usize) -> usize {
        let count = self.breakpoints.len().max(1);
        if 0.0 < self.w { (self.segment + interval) % count } else { (self.segment + count - interval % count) % count }
    }

    /// The times at which the cam passes the breakpoints of the law within the turn (s), ascending, and the `end`.
    pub fn joints(&self, end: Double) -> Vec<Double> {
        let start = angle::reduce(Double::from(self.phi_start));
        let way = |breakpoint: &f64| ((breakpoint - start) * self.w.signum()).rem_euclid(TAU);
        let inside = |way: &f64| SLACK < *way && *way < TAU - SLACK;
        let mut ways: Vec<f64> = self.breakpoints.iter().map(way).filter(inside).collect();
        ways.sort_by(f64::total_cmp);
        ways.into_iter().map(|way| Double::from(way / self.w.abs())).chain([end]).collect()
    }

    /// φ (rad), reduced, at `tau` (s) from the start of the turn.
    pub fn angle(&self, tau: Double) -> f64 {
        angle::reduce(Double::from(self.phi_start) + Double::from(self.w) * tau)
    }
}
