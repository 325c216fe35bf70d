//! HS profiles for an elastic output member: the inverse of one speed, the robust profile of a range of speeds, and
//! how fast a profile may turn.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.2, equations (4) to (7). The inverse is exact with
//! damping: with ν = kη, P = 1 − ν² + 4δ²ν², R = 2δν³, N = 1 + 4δ²ν²,
//! aₖ = (P Aₖ + R Bₖ)/N, bₖ = (P Bₖ − R Aₖ)/N.

use super::basis::{Basis, Response};
use super::{Infeasible, Profile, Task};
use crate::search::{local_maxima, zero};
use camdrive::motion::Fourier;

/// Speeds per distance between two resonances 1/k, 1/(k + 1) at which a deviation is looked at first.
const SPEEDS_PER_RESONANCE: f64 = 12.0;

/// The distance of two speeds, as part of that from a resonance.
const NEAR: f64 = 0.25;

/// A damping ratio below which resonances are taken for equally wide, so that speeds near them come to an end.
const NARROWEST: f64 = 1e-9;

/// The part of the level by which a robust profile may exceed it at speeds that its solver has not taken up.
pub const SOLVED: f64 = 1e-7;

/// Grids of 17 speeds η_opt, each of an eighth of the width of the one before: to a millionth of the range.
const REFINEMENTS: usize = 7;

/// A range of speeds over which the motion behind an elastic output member has to fulfil a task.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedRange {
    /// δ (1).
    pub damping: f64,
    /// Least η = Ω/ω₀ (1).
    pub slowest: f64,
    /// Largest η (1).
    pub fastest: f64,
}

/// The cam that makes the output follow `motion` exactly at one speed; None where that takes a harmonic that no cam
/// can force (an undamped resonance).
pub fn inverse(motion: &Fourier, response: Response) -> Option<Fourier> {
    let (mut a, mut b) = (motion.a.clone(), motion.b.clone());
    for k in 1..a.len() {
        let nu = k as f64 * response.eta;
        let damping = 2.0 * response.damping * nu;
        let p = (1.0 - nu) * (1.0 + nu) + damping * damping;
        let (r, n) = (damping * nu * nu, 1.0 + damping * damping);
        let [a_k, b_k] = [motion.a[k], motion.b[k]];
        if p == 0.0 && r == 0.0 && (a_k != 0.0 || b_k != 0.0) {
            return None;
        }
        a[k] = (p * a_k + r * b_k) / n;
        b[k] = (p * b_k - r * a_k) / n;
    }
    Some(Fourier::new(a, b))
}

/// The motion behind the elastic output member that a cam causes, once periodic; None at an undamped resonance
/// of one of its harmonics.
pub fn output(cam: &Fourier, response: Response) -> Option<Fourier> {
    let (mut a, mut b) = (cam.a.clone(), cam.b.clone());
    for k in 1..a.len() {
        if cam.a[k] == 0.0 && cam.b[k] == 0.0 {
            continue;
        }
        let [re, im] = response.gain(k);
        if !re.is_finite() || !im.is_finite() {
            return None;
        }
        // Y = G X with X = a − ib.
        a[k] = re * cam.a[k] + im * cam.b[k];
        b[k] = re * cam.b[k] - im * cam.a[k];
    }
    Some(Fourier::new(a, b))
}

/// A cam by the recipe of the source.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// The profile.
    pub cam: Fourier,
    /// η_opt.
    pub optimum: f64,
    /// The largest η with the deviation within the tolerance.
    pub reached: f64,
}

/// A resonance kη = 1 of a cam within a range of speeds.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Resonance {
    /// k.
    pub harmonic: usize,
    /// η = 1/k.
    pub eta: f64,
    /// max |q| = √(aₖ² + bₖ²)/(2δ) of this harmonic there, equation (7) (m); infinite without damping.
    pub amplitude: f64,
}

/// The resonances of a cam up to a speed, the slowest first.
pub fn resonances(cam: &Fourier, damping: f64, fastest: f64) -> Vec<Resonance> {
    let size = |k: usize| (cam.a[k].powi(2) + cam.b[k].powi(2)).sqrt();
    let of = |k: usize| Resonance { harmonic: k, eta: 1.0 / k as f64, amplitude: size(k) / (2.0 * damping) };
    (1..cam.a.len()).rev().filter(|&k| size(k) > 0.0).map(of).filter(|r| r.eta <= fastest).collect()
}

impl SpeedRange {
    /// The harmonics of a profile whose resonance kη = 1 lies within the range.
    pub fn crossed(&self, basis: &Basis) -> Vec<usize> {
        basis.harmonics().filter(|k| (self.slowest..=self.fastest).contains(&(1.0 / *k as f64))).collect()
    }
}

/// The largest |y − Ũ| over all ranges behind an elastic output member; infinite at an undamped resonance.
pub fn deviation(task: &Task, cam: &Fourier, response: Response) -> f64 {
    output(cam, response).map_or(f64::INFINITY, |motion| task.largest_error(&motion))
}

/// The largest η up to which (from `slowest` on) a cam keeps the deviation within `tolerance`, at most `fastest`;
/// None if it exceeds it at `slowest` already.
pub fn reachable(task: &Task, cam: &Fourier, range: SpeedRange, tolerance: f64) -> Option<f64> {
    // Finite at an undamped resonance too. A robust profile deviates by the tolerance at several speeds, to what its solver
    // leaves; that must not decide which of them counts.
    let mut excess = |eta: f64| {
        let deviation = deviation(task, cam, Response { damping: range.damping, eta });
        (deviation / (tolerance * (1.0 + 2.0 * SOLVED))).min(f64::MAX) - 1.0
    };
    let mut good = (range.slowest, excess(range.slowest));
    if good.1 > 0.0 {
        return None;
    }
    for eta in speeds(cam.order(), range) {
        let next = (eta, excess(eta));
        if next.1 > 0.0 {
            return Some(zero(&mut excess, [good.0, eta], [good.1, next.1], 0.0));
        }
        good = next;
    }
    Some(range.fastest)
}

/// The best cam by the recipe of the source: `motion` inverted at the η_opt from which the largest speed is reached
/// with the deviation within `tolerance` at all speeds from `range.slowest` on. The source inverts without damping,
/// equation (5); `damping` belongs to the inversion.
pub fn recipe(task: &Task, motion: &Fourier, range: SpeedRange, tolerance: f64, damping: f64) -> Option<Recipe> {
    let reached = |eta: f64| {
        let cam = inverse(motion, Response { damping, eta })?;
        let reached = reachable(task, &cam, range, tolerance)?;
        Some(Recipe { cam, optimum: eta, reached })
    };
    // Below the resonance of the highest harmonic the reach over η_opt has one summit with a kink.
    let highest = (1.0 / motion.order().max(1) as f64).min(range.fastest);
    refined(highest, reached, |next, best| next.reached > best.reached)
}

/// The cam by the same recipe with the least largest deviation over the whole range.
pub fn recipe_for(task: &Task, motion: &Fourier, range: SpeedRange) -> Option<Recipe> {
    let at = |eta: f64| {
        let cam = inverse(motion, Response { damping: range.damping, eta })?;
        let worst = worst_over(task, &cam, range);
        // The deviation takes the place of the speed until the best is found.
        Some(Recipe { cam, optimum: eta, reached: worst })
    };
    let best = refined(range.fastest, at, |next, best| next.reached < best.reached)?;
    Some(Recipe { reached: range.fastest, ..best })
}

/// The largest deviation over a range of speeds.
pub fn worst_over(task: &Task, cam: &Fourier, range: SpeedRange) -> f64 {
    let at = |eta: f64| deviation(task, cam, Response { damping: range.damping, eta });
    let candidates = speeds(cam.order(), range);
    let least = candidates.iter().map(|eta| at(*eta)).fold(0.0, f64::max);
    local_maxima(&candidates, least, &at).into_iter().map(at).fold(least, f64::max)
}

/// The profile whose task is fulfilled up to the largest speed: the robust problem, its range widened until the
/// objective meets `tolerance`. Yields the profile and the speed.
pub fn fastest_robust(task: &Task, range: SpeedRange, tolerance: f64) -> Result<(Profile, f64), Infeasible> {
    let solve = |fastest: f64| Task { speeds: Some(SpeedRange { fastest, ..range }), ..task.clone() }.solve();
    let slow = solve(range.slowest)?;
    if slow.objective > tolerance {
        return Ok((slow, f64::NAN));
    }
    let slowest = slow.objective / tolerance - 1.0;
    let mut best = (slow, range.slowest);
    let mut excess = |fastest: f64| {
        // The objective grows with the range; without a number it is as good as twice the tolerance.
        let Ok(profile) = solve(fastest) else { return 1.0 };
        let excess = (profile.objective / tolerance - 1.0).min(1.0);
        if excess <= 0.0 && fastest > best.1 {
            best = (profile, fastest);
        }
        excess
    };
    let ends = [range.slowest, range.fastest];
    let values = [slowest, excess(range.fastest)];
    if values[1] > 0.0 {
        let reached = zero(&mut excess, ends, values, 1e-9 * range.fastest);
        // On the side that keeps the tolerance.
        excess(reached * (1.0 - 1e-9));
    }
    Ok(best)
}

/// The best recipe for an η_opt between 0 and `high`, by a grid and its refinements.
fn refined(
    mut high: f64,
    at: impl Fn(f64) -> Option<Recipe>,
    better: impl Fn(&Recipe, &Recipe) -> bool,
) -> Option<Recipe> {
    let (mut low, mut best) = (0.0, None::<Recipe>);
    for _ in 0..REFINEMENTS {
        let step = (high - low) / 16.0;
        for next in (0..=16).filter_map(|i| at(low + step * f64::from(i))) {
            if best.as_ref().is_none_or(|best| better(&next, best)) {
                best = Some(next);
            }
        }
        let centre = best.as_ref()?.optimum;
        (low, high) = ((centre - step).max(0.0), centre + step);
    }
    best
}

/// Speeds of a range, dense enough for the resonances up to harmonic `order`, each resonance among them.
pub fn speeds(order: usize, range: SpeedRange) -> Vec<f64> {
    let lowest = 1.0 / order.max(1) as f64;
    // Towards a resonance the motion changes as 1/|η − 1/k| does, down to its width δ/k. Without damping those inside the
    // range are none, since no cam has their harmonics.
    let counts = |k: f64| range.damping > 0.0 || !(range.slowest..=range.fastest).contains(&(1.0 / k));
    let near = |eta: f64| {
        let k = (1.0 / eta).clamp(1.0, order.max(1) as f64);
        let width = |k: f64| NEAR * (eta - 1.0 / k).abs().max(range.damping.max(NARROWEST) / k);
        [k.floor(), k.ceil()].into_iter().filter(|k| counts(*k)).map(width).fold(f64::INFINITY, f64::min)
    };
    let mut list = Vec::new();
    let mut eta = range.slowest;
    while eta < range.fastest {
        list.push(eta);
        // Neighbouring resonances 1/k, 1/(k + 1) are η²/(1 + η) apart; below the lowest one the deviation of a robust
        // profile is level with some turns, of others without.
        let distance = if eta < lowest { 0.25 * lowest } else { eta * eta / (1.0 + eta) };
        eta += (distance / SPEEDS_PER_RESONANCE).min(near(eta));
    }
    list.extend((1..=order.max(1)).map(|k| 1.0 / k as f64).filter(|e| (range.slowest..range.fastest).contains(e)));
    list.push(range.fastest);
    list.sort_by(f64::total_cmp);
    list.dedup();
    list
}
