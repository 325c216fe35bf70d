//! Series of an overdamped drive: its slow mode apart from the fast one, which has died out.
//!
//! With real roots λ₂ ≪ λ₁ of the oscillator, w = q̇ − λ₁ q obeys λ₂ w = ẇ + ü. One solution has no part that decays like e^(λ₂t),
//! a power series found from its highest coefficient down. A panel therefore spans two radians of the flank or of the slow mode,
//! however strong the damper is; until the fast mode has decayed below rounding, panels follow it.
//!
//! Source: E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., Springer 1996, section VI.3
//! (the smooth solution of a singularly perturbed problem).

use super::series::{FlankSeries, Terms};
use crate::drives::follower::contact::{Mode, Phase};
use crate::numerics::oscillator::Oscillator;

/// A mode this many times faster than the flank is treated apart: coefficients from the highest down then decrease,
/// since n + 1 ≤ 25 is less than 32.
const STIFF: f64 = 32.0;

/// The least rate of a flank as part of the fastest mode; panels of slower flanks are not longer.
const SLOWEST: f64 = 1e-9;

/// A part of the motion this small against the rest is a rounding error.
const ROUNDING: f64 = 1e-14;

/// The rate (rad/s) of the slow motion if the fast mode can be treated apart: the flank's or the slow mode's.
pub fn slow_rate(oscillator: &Oscillator, flank_rate: f64) -> Option<f64> {
    let (slow, fast) = oscillator.real_roots()?;
    let slow = flank_rate.max(-slow);
    (-fast > STIFF * slow).then_some(slow.max(SLOWEST * -fast))
}

/// q without the fast mode; None as long as that still has to decay. `scale`: a bound of |ü| (m/s²).
pub fn elongation(oscillator: &Oscillator, phase: &Phase, flank: &FlankSeries, scale: f64) -> Option<Terms> {
    let (slow, fast) = oscillator.real_roots()?;
    let (h, terms) = (flank.span, flank.terms);
    let contact = phase.mode != Mode::Free;
    let (mut w, mut q) = (Terms::default(), Terms::default());
    for n in (0..terms).rev() {
        let next = (n + 1) as f64;
        let acceleration = if contact { next * (next + 1.0) * flank.u[n + 2] / h } else { 0.0 };
        w[n] = (next * w[n + 1] + acceleration) / (fast * h);
    }
    let [place, speed] = phase.state.q;
    let rest = speed - slow * place - w[0];
    let scale = if contact { scale / -fast } else { 0.0 };
    if !(rest.abs() <= ROUNDING * (speed.abs() + (slow * place).abs() + w[0].abs() + scale)) {
        return None;
    }
    q[0] = place;
    for n in 0..terms {
        q[n + 1] = h * (slow * q[n] + w[n]) / (n + 1) as f64;
    }
    Some(q)
}
