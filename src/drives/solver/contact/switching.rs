//! The search for the first switching instant of a panel: the first root of a polynomial.

use super::series::{MOST_TERMS, Series};
use crate::drives::follower::contact::{Beginning, Bodies, Flank, Mode};
use crate::numerics::first_root::{first_root, range, value_and_slope};
use serde::{Deserialize, Serialize};

/// The shortest flight that begins without velocity, as a part of the shortest time of any change. A mass that returns earlier has
/// moved by 1e-14 of a typical displacement, about the rounding of x1.
const ARMING: f64 = 1e-7;

/// Event found in a panel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Switch {
    /// Release from the flank.
    Release,
    /// Impact on the flank.
    Impact(Flank),
}

/// The range of the search.
pub struct Search<'a> {
    pub from: &'a Beginning,
    pub series: &'a Series,
    /// The end of the range (s).
    pub length: f64,
    /// The fastest change (rad/s).
    pub rate: f64,
    /// The force that counts as zero (N).
    pub resolution: f64,
}

impl Search<'_> {
    /// The first event, and its time after the start (s).
    pub fn first_event(&self, bodies: &Bodies) -> Option<(Switch, f64)> {
        match self.from.phase.mode {
            Mode::Contact(contact) => self.release(contact),
            Mode::Free => self.impact(bodies),
        }
    }

    /// The first release: F_K has fallen to the resolution below zero.
    fn release(&self, contact: Flank) -> Option<(Switch, f64)> {
        let mut force = self.series.force(contact);
        // At rest nothing pulls.
        if force == [0.0; MOST_TERMS] {
            return None;
        }
        force[0] += self.resolution;
        let seen = first_root(&force[..self.series.terms], self.length / self.series.span)?;
        force[0] -= self.resolution;
        Some((Switch::Release, polish(&force[..self.series.terms], seen) * self.series.span))
    }

    /// The first impact.
    fn impact(&self, bodies: &Bodies) -> Option<(Switch, f64)> {
        let (span, phase) = (self.series.span, &self.from.phase);
        let mut end = self.length / span;
        let mut found = None;
        let zeta = self.series.zeta();
        let [least, greatest] = range(&zeta, end);
        for (flank, nearest) in [(Flank::A, least), (Flank::B, -greatest)] {
            let away = phase.state.home - bodies.place(flank);
            if nearest + flank.sign() * away > 0.0 {
                continue;
            }
            let mut gap = zeta.map(|zeta| flank.sign() * zeta);
            gap[0] += flank.sign() * away;
            let Some(mut root) = first_root(&gap[..self.series.terms], end) else { continue };
            if phase.zeros >= 2 && away == 0.0 {
                root = root.max(ARMING / (self.rate * span)).min(end);
            }
            (end, found) = (root, Some((Switch::Impact(flank), root * span)));
        }
        found
    }
}

/// The root of the force just before `seen`, at which it has fallen to the resolution below zero.
fn polish(force: &[f64], seen: f64) -> f64 {
    let mut root = seen;
    for _ in 0..3 {
        let [value, slope] = value_and_slope(force, root);
        let next = root - value / slope;
        // A force that only just reaches zero keeps the instant `seen`.
        if !(slope < 0.0 && next >= 0.0 && (next - seen).abs() <= 1e-4) {
            return seen;
        }
        root = next;
    }
    root.min(seen)
}
