//! The modulation at which an order becomes unstable at a damping ratio.

use super::hill;
use super::system::System;
use super::tongue::Tongue;
use crate::search;

/// Steps between the modulation of the scene and 0, and between it and the highest one, within which θ* passes the
/// damping ratio at most once: a tongue that vanishes and appears again takes several of them.
const STEPS: usize = 6;

/// Relative error of a modulation.
const TOLERANCE: f64 = 1e-9;

pub(super) fn tongue(system: &System, n: usize) -> Option<Tongue> {
    let tongue = Tongue::numbered(system, n, &hill::boundaries(system, n));
    if tongue.is_none() {
        system.mark_unnumbered();
    }
    tongue
}

/// The least det E of the order n at a modulation: negative if speeds are unstable at the damping ratio `theta`, NaN if its
/// boundaries are not found.
pub fn margin(system: &System, n: usize, theta: f64, modulation: f64) -> f64 {
    let system = system.modulated(modulation);
    tongue(&system, n).map_or(f64::NAN, |tongue| tongue.margin(&system, theta))
}

/// η at which the order n is least stable at a modulation and a damping ratio; None without undamped boundaries.
pub fn least_stable(system: &System, n: usize, theta: f64, modulation: f64) -> Option<f64> {
    let system = system.modulated(modulation);
    tongue(&system, n)?.least_stable(&system, theta).map(|(inverse, _)| 1.0 / inverse)
}

/// The modulation in the bracket at which θ* of the order n passes `theta`: the zero of [`margin`], whose values at the
/// ends are `margins`.
/// None if its boundaries are not found on the way.
/// None where its boundaries are not found on the way.
pub fn crossing(system: &System, n: usize, theta: f64, ends: [f64; 2], margins: [f64; 2]) -> Option<f64> {
    let mut found = margins.iter().all(|margin| margin.is_finite());
    let mut f = |modulation: f64| {
        let margin = margin(system, n, theta, modulation);
        found &= margin.is_finite();
        margin
    };
    let crossing = search::zero(&mut f, ends, margins, TOLERANCE);
    found.then_some(crossing)
}

/// The modulation closest to the scene's, 1, at which θ* of the order n passes the damping ratio: the next one above if the
/// order is stable, None if it stays so up to `top`; the last one below if it is unstable.
pub fn next(system: &System, n: usize, theta: f64, top: f64) -> Option<f64> {
    let mut last = (1.0, margin(system, n, theta, 1.0));
    if last.1.is_nan() {
        return None;
    }
    let unstable = last.1 < 0.0;
    let end = if unstable { 0.0 } else { top.max(1.0) };
    for i in 1..=STEPS {
        let modulation = 1.0 + (end - 1.0) * i as f64 / STEPS as f64;
        let value = margin(system, n, theta, modulation);
        if value.is_nan() {
            return None;
        }
        if (value < 0.0) != unstable {
            return crossing(system, n, theta, [last.0, modulation], [last.1, value]);
        }
        last = (modulation, value);
    }
    None
}
