//! The boundaries of an order where the truncation of Hill's matrices does not tell them.
//!
//! Where an inertia nearly vanishes, free motions change within the part √(1 − μ/μ₀) of a radian, μ₀ the modulation at
//! which it vanishes, and Hill's matrices would need as many harmonics as its inverse and more. The boundaries however
//! are smooth functions of ln (μ₀ − μ), and those of different orders never meet. So they are followed from a smaller
//! modulation, at which Hill's matrices number them, each step predicted by the two before it and made exact by Newton's
//! method.
//!
//! Source: E. L. Allgower, K. Georg, *Introduction to Numerical Continuation Methods*, SIAM 2003, chapter 2.

use super::LOST;
use super::hill::{self, Boundaries, Pair};
use super::system::System;
use super::tongue::Tongue;

/// A step may miss its prediction by this part of the way to the next order.
const NEAR: f64 = 0.1;

/// Steps back to where Hill's matrices number the order, each of them to the fourfold distance from μ₀.
const MOST_STEPS_BACK: i32 = 12;

/// Steps forward, and the first and the shortest of them in ln (μ₀ − μ).
const MOST_STEPS: usize = 200;
const FIRST_STEP: f64 = 0.3;
const LEAST_STEP: f64 = 1e-3;

/// The tongue of the order n from Hill's matrices or, where these are too small, by continuation; None where neither
/// finds it.
pub fn tongue(system: &System, n: usize, start: &Boundaries) -> Option<Tongue> {
    let direct = start.of(n).and_then(|start| exact(system, n, start));
    direct.or_else(|| followed(system, n))
}

/// The same without continuation, for the many modulations of a map; where it is None, [`System::has_unnumbered`] tells.
pub fn numbered(system: &System, n: usize, start: &Boundaries) -> Option<Tongue> {
    let tongue = start.of(n).and_then(|start| exact(system, n, start));
    if tongue.is_none() {
        system.mark_unnumbered();
    }
    tongue
}

fn exact(system: &System, n: usize, start: Pair) -> Option<Tongue> {
    let tongue = Tongue::new(system, n, start);
    // Half of the way to the next order.
    let room = start.high.abs() / n as f64;
    let Pair { low, high } = tongue.lambda;
    let near = (low - start.low).abs() < room && (high - start.high).abs() < room;
    (near && tongue.residual < LOST).then_some(tongue)
}

fn followed(system: &System, n: usize) -> Option<Tongue> {
    let own = system.modulation;
    // Without an inertia that vanishes any scale that is about that of the modulation will do.
    let pole = system.greatest_modulation().min(2.0 * own);
    let at = |x: f64| system.modulated(pole - x.exp());
    let end = (pole - own).ln();
    let mut from = None;
    for back in 1..=MOST_STEPS_BACK {
        let x = end + 2.0 * f64::from(back) * std::f64::consts::LN_2;
        if x.exp() >= pole {
            break;
        }
        let system = at(x);
        if let Some(tongue) = hill::boundaries(&system, n).of(n).and_then(|start| exact(&system, n, start)) {
            from = Some((x, tongue));
            break;
        }
    }
    let (mut x, mut tongue) = from?;
    let mut slope = [0.0; 2];
    let mut step = FIRST_STEP;
    for _ in 0..MOST_STEPS {
        let next = (x - step).max(end);
        let system = at(next);
        let Pair { low, high } = tongue.lambda;
        let predicted = Pair { low: low + slope[0] * (next - x), high: high + slope[1] * (next - x) };
        let room = NEAR * 2.0 / n as f64 * high;
        let near =
            |t: &Tongue| (t.lambda.low - predicted.low).abs() < room && (t.lambda.high - predicted.high).abs() < room;
        match exact(&system, n, predicted).filter(near) {
            Some(found) => {
                if next == end {
                    return Some(found);
                }
                slope = [found.lambda.low - low, found.lambda.high - high].map(|change| change / (next - x));
                (x, tongue) = (next, found);
                step *= 1.5;
            }
            None => step *= 0.5,
        }
        if step < LEAST_STEP {
            return None;
        }
    }
    None
}
