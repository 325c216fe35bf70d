//! Which natural frequencies, and which speeds, let every passage of a motion law end without a second impact.
//!
//! K = (s/|U₀‴|)(ω/Ω)³ with the mass ratio held: each admissible interval of K, [`super::borders`], is an interval of ω at
//! given Ω and one of Ω at given ω. The machine admits the values that all passages admit. K does not depend on m1: the mass
//! ratio μ = m1/m2 tunes it at K, and with it the free natural frequency ω₂ = ω √((μ + 1)/μ). The formulas contain no damping.

use super::borders::{Admissible, MOST_BANDS, band_tip, elastic_border, elastic_limit};
use crate::formulas::passage::Masses;
use crate::search;
use serde::Serialize;
use std::f64::consts::PI;

/// Intervals of one quantity; an end of ∞ is open.
pub type Intervals = Vec<[f64; 2]>;

/// Admissible values for a mass ratio and its passages.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tuning {
    /// Natural frequencies ω at the speed of the scene (rad/s).
    pub frequency: Intervals,
    /// Speeds at the natural frequency of the scene (rad/s); the last one has no end.
    pub speed: Intervals,
    /// Clearances at both of the scene (m).
    pub clearance: Intervals,
    /// Masses m1 at the other values (kg); the last interval has no end.
    pub mass: Intervals,
    /// True if there are further intervals below them, too many to list.
    pub mass_cut: bool,
    /// The largest ω that the source's condition K ≤ 15 allows (rad/s).
    pub source_frequency: f64,
    /// From this ω on the quasi-static deformation (3) is accurate to 5 % at every passage (rad/s).
    pub quasi_static_frequency: f64,
    /// Up to this speed the deformation is, at the natural frequency of the scene (rad/s).
    pub quasi_static_speed: f64,
    /// The K that each passage may have.
    pub k: Admissible,
}

/// The error of (3) up to which its range is stated.
pub const FAIR: f64 = 0.05;

/// The bound of the source for K.
pub const SOURCE_BOUND: f64 = 15.0;

/// The passages of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Passages {
    /// |U‴| of each (m), all > 0.
    pub jerks: Vec<f64>,
    /// |U⁽⁵⁾/U‴| of each.
    pub curvatures: Vec<f64>,
    /// Clearance (m).
    pub s: f64,
    /// ω (rad/s).
    pub omega: f64,
    /// |Ω| (rad/s).
    pub speed: f64,
    /// Working mass (kg).
    pub m2: f64,
}

impl Tuning {
    /// The intervals for these passages; None without passages.
    pub fn new(k: Admissible, passages: &Passages) -> Option<Self> {
        let Passages { s, omega, speed, m2, .. } = *passages;
        let smallest = passages.jerks.iter().copied().reduce(f64::min)?;
        let common = |of: &dyn Fn(f64, f64) -> f64| {
            let each = passages.jerks.iter().map(|jerk| {
                let mut intervals: Intervals = k.intervals.iter().map(|ends| ends.map(|k| of(k, *jerk))).collect();
                intervals.iter_mut().for_each(|ends| ends.sort_by(f64::total_cmp));
                intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
                intervals
            });
            each.reduce(|a, b| intersection(&a, &b)).unwrap_or_default()
        };
        let ratios: Vec<AdmissibleRatios> =
            passages.jerks.iter().map(|jerk| admissible_ratios(s / jerk * (omega / speed).powi(3))).collect();
        // Below the list of one passage the others say nothing either; if they admit nothing there, nothing is missing.
        let first = |cut: bool| {
            let those = ratios.iter().filter(move |r| r.cut == cut);
            those.map(|r| r.intervals.first().map_or(f64::INFINITY, |ends| ends[0])).fold(0.0, f64::max)
        };
        let lowest = first(true);
        let each = ratios.iter().map(|ratios| ratios.intervals.clone()).reduce(|a, b| intersection(&a, &b));
        let mass = intersection(&each.unwrap_or_default(), &[[lowest, f64::INFINITY]]);
        let curvature = passages.curvatures.iter().copied().fold(0.0, f64::max);
        let quasi_static = (curvature / FAIR).sqrt();
        Some(Tuning {
            frequency: common(&|k, jerk| speed * (k * jerk / s).cbrt()),
            speed: common(&|k, jerk| omega * (s / (k * jerk)).cbrt()),
            clearance: common(&|k, jerk| k * jerk * (speed / omega).powi(3)),
            mass: mass.into_iter().map(|ends| ends.map(|mu| m2 * mu)).collect(),
            mass_cut: lowest > first(false),
            source_frequency: speed * (SOURCE_BOUND * smallest / s).cbrt(),
            quasi_static_frequency: speed * quasi_static,
            quasi_static_speed: omega / quasi_static,
            k,
        })
    }
}

/// Intersection of two lists of ascending, separate intervals.
fn intersection(a: &[[f64; 2]], b: &[[f64; 2]]) -> Intervals {
    let pairs = a.iter().flat_map(|a| b.iter().map(move |b| [a[0].max(b[0]), a[1].min(b[1])]));
    pairs.filter(|[low, high]| low < high).collect()
}

/// The mass ratios without a second impact at one K.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AdmissibleRatios {
    /// Ascending intervals of μ, the last one without end.
    pub intervals: Vec<[f64; 2]>,
    /// True if there are further intervals below the first one, too many to list.
    pub cut: bool,
}

/// The intervals of μ in which no second impact follows at `k` > 0.
///
/// K_el(μ) grows with μ, so K < K_el demands a least μ, or none up to K_el(0). In a band K(θ) = K(aθ, −sin θ/θ) rises from 0
/// and falls to 0, so it is crossed at two θ or not at all.
pub fn admissible_ratios(k: f64) -> AdmissibleRatios {
    let mut least = 0.0;
    if k > elastic_limit()[1] {
        let mut high = 1.0;
        while elastic_border(high).k < k {
            high *= 2.0;
        }
        least = search::root(|x| elastic_border(x.exp()).k - k, [f64::EPSILON.ln(), high.ln()]).exp();
    }
    let (mut intervals, mut below, mut cut) = (Vec::new(), f64::INFINITY, true);
    for n in 0..=MOST_BANDS {
        if band_tip(n)[1] <= least {
            cut = false;
            break;
        }
        let ratio = |theta: f64| (-theta.sin() / theta).max(0.0);
        let excess = |theta: f64| {
            let masses = Masses::new(ratio(theta));
            masses.clearance(masses.a * theta) - k
        };
        let ends = [f64::from(2 * n + 1) * PI, f64::from(2 * n + 2) * PI];
        let (top, highest) = search::maximum(&mut |theta| excess(theta), ends, 1e-9);
        if highest <= 0.0 {
            continue;
        }
        let (a, b) = (ratio(search::root(excess, [ends[0], top])), ratio(search::root(excess, [top, ends[1]])));
        let (low, high) = (a.min(b), a.max(b));
        if high.max(least) < below {
            intervals.push([high.max(least), below]);
        }
        // At a tiny K the ends of bands are roundings, which do not descend.
        below = low.min(below);
    }
    if !cut && least < below {
        intervals.push([least, below]);
    }
    intervals.reverse();
    AdmissibleRatios { intervals, cut }
}
