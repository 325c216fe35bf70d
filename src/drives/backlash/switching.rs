//! The search for the first switching instant of a panel that is a power series: the first zero of a polynomial.

use super::contact::{Bodies, Flank, Mode};
use super::flank::FlankMotion;
use super::panel::{Found, MOST_TERMS, ORDER, Pair, Panel};
use crate::numerics::first_zero::first_zero;

/// The shortest flight that begins without velocity, as a part of the shortest time in which anything changes. A mass
/// that is back earlier has moved by 1e-14 of a typical displacement, next to the rounding of x1.
const ARMING: f64 = 1e-7;

impl Panel {
    /// σ F_K as a series.
    pub(super) fn force_series(&self, bodies: &Bodies, contact: Flank) -> [f64; MOST_TERMS] {
        let sign = contact.sign();
        let (inertia, stiffness) = (sign * bodies.m1 / (self.span * self.span), sign * bodies.c);
        let damping = sign * bodies.b / self.span;
        let mut force = [0.0; MOST_TERMS];
        for n in 0..self.terms {
            let ([_, q], [_, v], [u, _]) = (self.pairs[n].0, self.pairs[n + 1].0, self.pairs[n + 2].0);
            force[n] = inertia * (ORDER[n] * ORDER[n + 1]) * u - stiffness * q - damping * ORDER[n] * v;
        }
        force
    }

    /// The distance from `flank` as a series.
    pub(super) fn gap_series(&self, bodies: &Bodies, flank: Flank) -> [f64; MOST_TERMS] {
        let sign = flank.sign();
        let mut gap = [0.0; MOST_TERMS];
        for (g, Pair([zeta, _])) in gap.iter_mut().zip(&self.pairs[..self.terms]) {
            *g = sign * zeta;
        }
        gap[0] += sign * (self.state.home - bodies.place(flank));
        gap
    }

    /// The first event in the panel; `rate` is the fastest change [rad/s].
    pub(super) fn find(
        &self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        zeros: usize,
        rate: f64,
    ) -> Option<(Found, f64)> {
        match self.mode {
            Mode::Contact(contact) => self.release(bodies, contact, bodies.resolution(flank, self.start)),
            Mode::Free => self.impact(bodies, zeros, rate),
        }
    }

    /// The first release in the panel: where F_K has fallen to the resolution below zero.
    fn release(&self, bodies: &Bodies, contact: Flank, resolution: f64) -> Option<(Found, f64)> {
        let mut force = self.force_series(bodies, contact);
        // At rest nothing pulls.
        if force == [0.0; MOST_TERMS] {
            return None;
        }
        force[0] += resolution;
        let seen = first_zero(&force[..self.terms], self.length / self.span)?;
        force[0] -= resolution;
        Some((Found::Release, polish(&force[..self.terms], seen) * self.span))
    }

    /// The first impact in the panel.
    fn impact(&self, bodies: &Bodies, zeros: usize, rate: f64) -> Option<(Found, f64)> {
        let mut end = self.length / self.span;
        let mut found = None;
        for flank in [Flank::A, Flank::B] {
            let gap = self.gap_series(bodies, flank);
            let Some(mut zero) = first_zero(&gap[..self.terms], end) else { continue };
            if zeros >= 2 && self.state.home == bodies.place(flank) {
                zero = zero.max(ARMING / (rate * self.span)).min(end);
            }
            (end, found) = (zero, Some((Found::Impact(flank), zero * self.span)));
        }
        found
    }
}

/// The zero of the force just before `seen`, where it has fallen to the resolution below zero.
fn polish(force: &[f64], seen: f64) -> f64 {
    let mut zero = seen;
    for _ in 0..3 {
        let (mut value, mut slope) = (0.0, 0.0);
        for &c in force.iter().rev() {
            slope = slope * zero + value;
            value = value * zero + c;
        }
        let next = zero - value / slope;
        // A force that only just reaches zero keeps the instant at which it is seen to pull.
        if !(slope < 0.0 && next >= 0.0 && (next - seen).abs() <= 1e-4) {
            return seen;
        }
        zero = next;
    }
    zero.min(seen)
}
