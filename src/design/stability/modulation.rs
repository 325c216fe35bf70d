//! The modulation at which an order becomes unstable at a damping ratio.

use super::hill;
use super::search;
use super::system::System;
use super::tongue::{Apex, Tongue};

/// Steps between the modulation of the scene and 0, and between it and the highest one, within which θ* passes the
/// damping ratio at most once: a tongue that vanishes and appears again takes several of them.
const STEPS: usize = 6;

/// Relative error of a modulation.
const TOLERANCE: f64 = 1e-9;

/// θ* of the order n at a modulation and where; None where no damping ratio suffices.
pub fn apex(system: &System, n: usize, modulation: f64) -> Option<Apex> {
    let system = system.modulated(modulation);
    let start = hill::boundaries(&system, n);
    Tongue::new(&system, n, start.pairs[n - 1]).apex(&system)
}

/// The modulation in the bracket at which θ* of the order n passes `theta`; `values` are θ* at its ends.
pub fn crossing(system: &System, n: usize, theta: f64, ends: [f64; 2], values: [f64; 2]) -> f64 {
    // θ* is infinite where the tongue is open.
    let excess = |value: f64| value.min(2.0 * theta) - theta;
    let mut f = |modulation: f64| excess(critical(system, n, modulation));
    search::zero(&mut f, ends, values.map(excess), TOLERANCE)
}

fn critical(system: &System, n: usize, modulation: f64) -> f64 {
    apex(system, n, modulation).map_or(f64::INFINITY, |apex| apex.theta)
}

/// The modulation next to 1, that of the scene, at which the order n with the value `own` of θ* there passes the damping
/// ratio: the next one above where it is stable, None where it stays so up to `top`; the last one below where it is not.
pub fn next(system: &System, n: usize, theta: f64, own: Option<f64>, top: f64) -> Option<f64> {
    let mut last = (1.0, own.unwrap_or(f64::INFINITY));
    let unstable = last.1 > theta;
    let end = if unstable { 0.0 } else { top.max(1.0) };
    for i in 1..=STEPS {
        let modulation = 1.0 + (end - 1.0) * i as f64 / STEPS as f64;
        let value = if modulation > 0.0 { critical(system, n, modulation) } else { 0.0 };
        if (value > theta) != unstable {
            return Some(crossing(system, n, theta, [last.0, modulation], [last.1, value]));
        }
        last = (modulation, value);
    }
    None
}
