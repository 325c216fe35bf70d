//! Sequels of the impact with which a passage ends, over K and μ: the map of multiple impacts.
//!
//! * At once: right after the impact the contact force pulls, f(0) = a (μθ + sin θ) < 0 of [`crate::formulas::passage`]. That needs
//!   (2n+1)π < θ < (2n+2)π and μ < −sin θ/θ, so μ < 0.2172336282; in (K, μ) each n makes a band, whose border is the curve
//!   μ = −sin θ/θ, K = K(aθ, μ).
//! * Elastically: the force changes its sign within the first natural period. With R² = A² + B², tan δ = −B/A and
//!   cos α = (μ+1)/R the smallest f is (μ+1)(τ₁ + π + δ + α − tan α), so that it happens where
//!   tan α − α > π + τ₁ + δ. For given μ that holds for all K above one value K_el(μ), which is
//!   15.1790607982 for μ → 0 and larger for every μ > 0. f(τ* + 2π) > f(τ*): if it does not happen in the first period, it
//!   does not happen later.
//!
//! The condition K ≤ 15 of the source excludes the second kind only.
//!
//! Source: K. Kaltofen, "Zur Dynamik spielbehafteter periodischer Antriebe", 1996, (25), (26) and the map that follows.

use crate::formulas::passage::{Masses, Passage};
use crate::search::root;
use serde::Serialize;
use std::f64::consts::PI;

/// Sequel of an impact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sequel {
    /// The contact lasts.
    None,
    /// m1 leaves the flank at once.
    Immediate,
    /// m1 leaves the flank within the first natural period.
    Elastic,
    /// m1 rebounds, since e > 0; the formulas leave that out.
    Rebound,
    /// m1 falls back to the flank that it has left; the formulas leave that out, too.
    Return,
}

impl Sequel {
    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Sequel::None => "none",
            Sequel::Immediate => "immediate",
            Sequel::Elastic => "elastic",
            Sequel::Rebound => "rebound",
            Sequel::Return => "return",
        }
    }
}

/// tan α − α.
fn involute(tan: f64) -> f64 {
    tan - tan.atan()
}

/// δ and tan α of the contact force after the impact; None if it never falls, R ≤ μ + 1.
fn wave(passage: &Passage) -> Option<[f64; 2]> {
    let [a, b] = passage.amplitudes();
    let size = (a * a + b * b).sqrt() * passage.masses.share;
    // R ≥ μ + 1 in a form that keeps its digits if both are close.
    (size > 1.0).then(|| [(-b).atan2(a), ((size - 1.0) * (size + 1.0)).sqrt()])
}

/// Excess of tan α − α over π + τ₁ + δ: positive where the contact is interrupted elastically.
fn elastic_excess(passage: &Passage) -> f64 {
    wave(passage).map_or(f64::MIN, |[delta, tan]| involute(tan) - (PI + passage.tau + delta))
}

/// Sequel of the impact of this passage.
pub fn sequel(passage: &Passage) -> Sequel {
    if passage.pressing_at_once() < 0.0 {
        Sequel::Immediate
    } else if elastic_excess(passage) > 0.0 {
        Sequel::Elastic
    } else {
        Sequel::None
    }
}

/// When the contact ends again, τ* after the impact: 0 at once, else the first zero of f; None if it lasts.
pub fn release(passage: &Passage) -> Option<f64> {
    match sequel(passage) {
        Sequel::None | Sequel::Rebound | Sequel::Return => None,
        Sequel::Immediate => Some(0.0),
        Sequel::Elastic => {
            // f falls from its largest value at δ + π − α to the smallest one at δ + π + α.
            let [delta, tan] = wave(passage)?;
            let (middle, alpha) = (delta + PI, tan.atan());
            Some(root(|tau| passage.pressing(tau), [middle - alpha, middle + alpha]))
        }
    }
}

/// The passage above whose K contact is interrupted elastically: f has a double zero after it.
pub fn elastic_border(mu: f64) -> Passage {
    // No border below τ₁ = 4; above the other end A ≥ ½τ₁² − 2 makes the excess positive.
    let tau = root(|tau| elastic_excess(&Passage::lasting(mu, tau)), [4.0, 2.0 * mu + 2.0 * PI + 6.0]);
    Passage::lasting(mu, tau)
}

/// The border of the elastic sequel for μ → 0, as τ₁ and K: there A = ½τ₁², B = −τ₁, K = τ₁³/6 + τ₁.
pub fn elastic_limit() -> [f64; 2] {
    let excess = |tau: f64| {
        let size = tau * (0.25 * tau * tau + 1.0).sqrt();
        involute((size * size - 1.0).sqrt()) - (PI + tau + f64::atan2(2.0, tau))
    };
    let tau = root(excess, [4.0, 5.0]);
    [tau, tau * tau * tau / 6.0 + tau]
}

/// The highest point of band n, as θ and μ: tan θ = θ, μ = −cos θ. Above the point of n = 0 no impact is followed by an
/// immediate release.
pub(super) fn band_tip(n: u32) -> [f64; 2] {
    // θ = (2n+1)π + β with tan β = θ: the zero of tan β − β − (2n+1)π, by its arctangent.
    let odd = f64::from(2 * n + 1) * PI;
    let beta = root(|beta| beta - (odd + beta).atan(), [0.0, 0.5 * PI]);
    [odd + beta, beta.cos()]
}

/// The θ between which band n, counted from 0, interrupts contact at once; None if μ is above its tip.
pub fn band(mu: f64, n: u32) -> Option<[f64; 2]> {
    let (odd, even) = (f64::from(2 * n + 1) * PI, f64::from(2 * n + 2) * PI);
    if mu >= 1.0 || mu.is_nan() {
        return None;
    }
    // With θ = odd + x the band is the x with sin x > μθ; the distance is largest at cos x = μ.
    let top = mu.acos();
    if top.sin() <= mu * (odd + top) {
        return None;
    }
    // Each end by the angle to the nearer multiple of π, which keeps its digits for small μ.
    let low = odd + root(|x| x.sin() - mu * (odd + x), [0.0, top]);
    let high = even - root(|y| y.sin() - mu * (even - y), [0.0, PI - top]);
    Some([low, high])
}

/// Bands listed at most; for μ ≥ 5e-5 these are all below K_el.
pub(super) const MOST_BANDS: u32 = 100;

/// The K without a second impact at one mass ratio.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Admissible {
    /// Ascending intervals, the first from 0 on.
    pub intervals: Vec<[f64; 2]>,
    /// K_el, above which contact is interrupted elastically.
    pub elastic: f64,
    /// True if there are further intervals between the last one and `elastic`, too many to list.
    pub cut: bool,
}

/// The intervals of K in which no second impact follows.
pub fn admissible(mu: f64) -> Admissible {
    let (masses, elastic) = (Masses::new(mu), elastic_border(mu));
    let (mut intervals, mut from) = (Vec::new(), 0.0);
    for n in 0..=MOST_BANDS {
        let Some(theta) = band(mu, n) else { break };
        let [low, high] = theta.map(|theta| masses.clearance(masses.a * theta));
        if low >= elastic.k {
            break;
        }
        intervals.push([from, low]);
        if n == MOST_BANDS {
            return Admissible { intervals, elastic: elastic.k, cut: true };
        }
        from = high;
    }
    if from < elastic.k {
        intervals.push([from, elastic.k]);
    }
    Admissible { intervals, elastic: elastic.k, cut: false }
}

/// A border of the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Border {
    /// The number of the band, from 0, of an immediate release; None for the elastic border.
    pub band: Option<u32>,
    /// Its points.
    pub points: Vec<BorderPoint>,
}

/// A point of a border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BorderPoint {
    /// m1/m2.
    pub mu: f64,
    /// K.
    pub k: f64,
    /// τ₁.
    pub tau: f64,
}

impl BorderPoint {
    fn of(passage: &Passage) -> Self {
        BorderPoint { mu: passage.masses.mu, k: passage.k, tau: passage.tau }
    }

    fn logarithms(&self) -> [f64; 2] {
        [self.k.ln(), self.mu.ln()]
    }
}

/// A straight line between two points of a border, both axes logarithmic, misses it by less: a fiftieth of the width of a line
/// in a diagram of three decades.
const CHORD: f64 = 3e-4;

/// Points on the border, `point(x)` for x from 0 to 1, as many as [`CHORD`] needs.
fn trace(point: &impl Fn(f64) -> BorderPoint) -> Vec<BorderPoint> {
    fn refine(
        point: &impl Fn(f64) -> BorderPoint,
        [from, to]: [(f64, BorderPoint); 2],
        depth: u32,
        points: &mut Vec<BorderPoint>,
    ) {
        let at = 0.5 * (from.0 + to.0);
        let middle = (at, point(at));
        let [a, b, m] = [from.1.logarithms(), to.1.logarithms(), middle.1.logarithms()];
        let chord = [b[0] - a[0], b[1] - a[1]];
        let length = (chord[0] * chord[0] + chord[1] * chord[1]).sqrt();
        let off = (chord[0] * (m[1] - a[1]) - chord[1] * (m[0] - a[0])).abs() / length.max(f64::MIN_POSITIVE);
        // Three bisections first, so that no bend between two points on one line is missed.
        if depth < 3 || (off > CHORD && depth < 14) {
            refine(point, [from, middle], depth + 1, points);
            refine(point, [middle, to], depth + 1, points);
        } else {
            points.extend([middle.1, to.1]);
        }
    }
    let ends = [(0.0, point(0.0)), (1.0, point(1.0))];
    let mut points = vec![ends[0].1];
    refine(point, ends, 0, &mut points);
    points
}

/// The borders of the map for mass ratios from `low` to `high`, as far as their K is at most `most`.
pub fn borders([low, high]: [f64; 2], most: f64) -> Vec<Border> {
    let mu = |x: f64| low * (high / low).powf(x);
    let elastic = trace(&|x| BorderPoint::of(&elastic_border(mu(x))));
    let mut list = vec![Border { band: None, points: elastic }];
    for n in 0..MOST_BANDS {
        let ([tip, top], Some([left, right])) = (band_tip(n), band(low, n)) else { break };
        let of = |theta: f64| {
            let masses = Masses::new((-theta.sin() / theta).max(low));
            BorderPoint { mu: masses.mu, k: masses.clearance(masses.a * theta), tau: masses.a * theta }
        };
        if of(left).k > most || top < low {
            break;
        }
        // From the left end up to the tip and down to the right end.
        let side = |end: f64| trace(&|x: f64| of(end + (tip - end) * x));
        let mut points = side(left);
        points.extend(side(right).into_iter().rev().skip(1));
        list.push(Border { band: Some(n), points });
    }
    list
}
