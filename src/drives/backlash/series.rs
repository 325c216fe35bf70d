//! The motion in one mode as power series of time.
//!
//! The series of the flank u(t) gives that of q by the recurrence of the equation of motion,
//!
//! q̈ = −2δ q̇ − ω² q − ü (contact: δ, ω of m2 on its spring) or q̈ = −2δ₂ q̇ − ω₂² q (flight: of m1 against m2),
//!
//! and the gap in flight follows from m1 z̈ = c q + b q̇ − m1 ü. About the start of a flight the gap begins with exact
//! zeros, so that no term cancels while it is small. A series serves for two radians of the fastest change: then the term of
//! order n is at most 2ⁿ/n! of the amplitude.
//!
//! Source: A. Griewank, A. Walther, *Evaluating Derivatives*, 2nd ed., SIAM 2008, section 13.2 (Taylor series of
//! solutions).

use super::contact::{Beginning, Bodies, Flank, Mode, Phase};
use super::flank::FlankMotion;
use crate::numerics::count::at_most;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::pair::Pair;
use serde::{Deserialize, Serialize};

/// The fastest rate times the length of a series (rad).
pub const REACH: f64 = 2.0;

/// The most terms of a series: of ü, 2²²/22! = 4e-15 is left out, of q and the gap 2²⁴/24! = 3e-17.
pub const MOST_TERMS: usize = 24;

/// The fewest terms of a series.
const LEAST_TERMS: usize = 8;

/// Halvings of a span; 2⁻⁶⁰ of it shows no change of the speed any more.
const MOST_HALVINGS: usize = 60;

/// The series of u and q have two terms more than that of ü.
const COEFFICIENTS: usize = MOST_TERMS + 2;

/// A series while it is computed.
pub type Terms = [f64; COEFFICIENTS];

/// u (contact) or ζ (flight) beside q.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Series {
    /// The unit of time (s).
    pub span: f64,
    /// Terms of ü, even.
    #[serde(deserialize_with = "at_most::<_, MOST_TERMS>")]
    pub terms: usize,
    /// Spans per second.
    per_span: f64,
    pairs: [Pair; COEFFICIENTS],
}

/// The series of the flank.
pub struct FlankSeries {
    /// The unit of time (s).
    pub span: f64,
    /// Terms of ü, even.
    pub terms: usize,
    /// The coefficients of u.
    pub u: Terms,
    /// What it took (nominal µs).
    pub cost: f64,
}

impl FlankSeries {
    /// From `from` on with `span` (s) as the unit of time, or with one in which it decays fast enough.
    pub fn new(flank: &impl FlankMotion, from: &Beginning, terms: usize, mut span: f64) -> Self {
        let (mut u, mut cost) = ([0.0; COEFFICIENTS], 0.0);
        for _ in 0..MOST_HALVINGS {
            flank.expand(from.segment, from.start, span, &mut u[..terms + 2]);
            cost += flank.cost();
            if flank.is_uniform()
                || decayed(&u[..terms + 2], flank.acceleration(from.segment, from.start) * span * span)
            {
                break;
            }
            span *= 0.5;
        }
        FlankSeries { span, terms, u, cost }
    }

    /// q from its first two coefficients on, by the equation of motion.
    pub fn elongation(&self, oscillator: &Oscillator, phase: &Phase) -> Terms {
        let h = self.span;
        let damping = 2.0 * oscillator.damping() * h;
        let stiffness = oscillator.stiffness() * h * h;
        let driven = if phase.mode == Mode::Free { 0.0 } else { 1.0 };
        let mut series = [0.0; COEFFICIENTS];
        let [mut q, mut v] = [phase.state.q[0], phase.state.q[1] * h];
        [series[0], series[1]] = [q, v];
        for n in 0..self.terms.min(MOST_TERMS) {
            let next = -(damping * ORDER[n] * v + stiffness * q) * RECIPROCAL[n] - driven * self.u[n + 2];
            series[n + 2] = next;
            (q, v) = (v, next);
        }
        series
    }
}

impl Series {
    /// The series of u or ζ beside that of `q`.
    pub fn new(bodies: &Bodies, phase: &Phase, flank: &FlankSeries, q: &Terms) -> Self {
        let FlankSeries { span, terms, ref u, .. } = *flank;
        // What the compiler knows it need not check.
        let terms = terms.min(MOST_TERMS);
        let mut pairs = [Pair::default(); COEFFICIENTS];
        if phase.mode == Mode::Free {
            let share = bodies.share;
            for n in 2..terms + 2 {
                // The centre of mass moves uniformly: m1 z̈ = c q + b q̇ − m1 ü is this share of −q̈.
                pairs[n] = Pair([-share * q[n] - u[n], q[n]]);
            }
            (pairs[0], pairs[1]) = (Pair([phase.state.zeta[0], q[0]]), Pair([phase.state.zeta[1] * span, q[1]]));
            for pair in &mut pairs[..phase.zeros] {
                pair.0[0] = 0.0;
            }
        } else {
            for n in 0..terms + 2 {
                pairs[n] = Pair([u[n], q[n]]);
            }
        }
        Series { span, terms, per_span: 1.0 / span, pairs }
    }

    /// u or ζ, and q, `theta` (s) after the start; and their rates.
    pub fn at(&self, theta: f64) -> [[f64; 2]; 2] {
        let x = theta * self.per_span;
        // Even and odd terms apart: p = E(x²) + x O(x²), p′ = O + 2x E′ + 2x² O′.
        let [values, rates] = match self.terms_at(x) {
            ..=10 => sums(self.pairs.first_chunk::<12>(), x),
            11..=14 => sums(self.pairs.first_chunk::<16>(), x),
            15..=18 => sums(self.pairs.first_chunk::<20>(), x),
            _ => sums(Some(&self.pairs), x),
        };
        [values, rates.map(|rate| rate * self.per_span)]
    }

    /// How many terms do at the part `x` of the span: (2 x)ⁿ/n! is 4e-19 at half of it and n = 20, 7e-19 at a quarter and
    /// n = 16; of ü and the force, with two terms less, 2e-16 and 7e-16.
    fn terms_at(&self, x: f64) -> usize {
        self.terms.min(if x <= 0.25 {
            14
        } else if x <= 0.5 {
            18
        } else {
            MOST_TERMS
        })
    }

    /// ü in contact, `theta` (s) after the start.
    pub fn flank_acceleration(&self, theta: f64) -> f64 {
        let x = theta * self.per_span;
        let term = |n: usize| ORDER[n] * ORDER[n + 1] * self.pairs[n + 2].0[0];
        (0..self.terms_at(x)).rev().fold(0.0, |sum, n| sum * x + term(n)) * self.per_span * self.per_span
    }

    /// σ F_K.
    pub fn force(&self, bodies: &Bodies, contact: Flank) -> [f64; MOST_TERMS] {
        let sign = contact.sign();
        self.force_and_rate(bodies).map(|pair| sign * pair.0[0])
    }

    /// F_K beside u̇, for [`Series::sum`].
    pub fn force_and_rate(&self, bodies: &Bodies) -> [Pair; MOST_TERMS] {
        let inertia = bodies.m1 * self.per_span * self.per_span;
        let damping = bodies.b * self.per_span;
        let mut terms = [Pair::default(); MOST_TERMS];
        for n in 0..self.terms.min(MOST_TERMS) {
            let ([_, q], [u1, v], [u2, _]) = (self.pairs[n].0, self.pairs[n + 1].0, self.pairs[n + 2].0);
            let force = inertia * (ORDER[n] * ORDER[n + 1]) * u2 - bodies.c * q - damping * ORDER[n] * v;
            terms[n] = Pair([force, ORDER[n] * u1 * self.per_span]);
        }
        terms
    }

    /// The sums of two series of powers of the part of the span, `theta` (s) after the start.
    pub fn sum(&self, pairs: &[Pair; MOST_TERMS], theta: f64) -> [f64; 2] {
        let x = theta * self.per_span;
        pairs[..self.terms_at(x)].iter().rev().fold(Pair::default(), |sum, pair| sum * Pair::both(x) + *pair).0
    }

    /// ζ.
    pub fn zeta(&self) -> [f64; MOST_TERMS] {
        let mut zeta = [0.0; MOST_TERMS];
        for (zeta, pair) in zeta.iter_mut().zip(&self.pairs[..self.terms]) {
            *zeta = pair.0[0];
        }
        zeta
    }

    /// What is rounded up to `theta` (s), as the sizes of the first terms, and what is neglected: in ζ, ζ̇, q, q̇.
    pub fn errors(&self, mode: Mode, theta: f64) -> [[f64; 4]; 2] {
        let x = (theta * self.per_span).min(1.0);
        // The impact is located with these terms only; a state has two terms more.
        let last = x.powi(self.terms as i32);
        let [mut sizes, mut neglected] = [[0.0; 4]; 2];
        let first = if mode == Mode::Free { 0 } else { 1 };
        for i in first..2 {
            let [c0, c1, c2, c3, c4, c5] = [0, 1, 2, 3, self.terms, self.terms + 1].map(|n| self.pairs[n].0[i].abs());
            let start = if i == 0 { 0.0 } else { c0 };
            sizes[2 * i] = start + x * (c1 + x * (c2 + x * c3));
            sizes[2 * i + 1] = (c1 + x * (2.0 * c2 + 3.0 * x * c3)) * self.per_span;
            let omitted = (c4 + c5) * last;
            // What the states leave out is smaller by the ratio of such terms.
            let ratio = REACH * REACH * RECIPROCAL[self.terms];
            neglected[2 * i] = if i == 0 { omitted } else { ratio * omitted };
            neglected[2 * i + 1] = ratio * omitted * self.terms as f64 * self.per_span;
        }
        [sizes, neglected]
    }
}

/// The fewest terms with which a series leaves out less than the part `tolerance` of ü.
pub fn terms_for(tolerance: f64) -> usize {
    (LEAST_TERMS..MOST_TERMS).step_by(2).find(|terms| part_of_term(terms - 2) <= tolerance).unwrap_or(MOST_TERMS)
}

/// Σ cₙ xⁿ and Σ n cₙ xⁿ⁻¹ of both series.
#[inline(always)]
fn sums<const N: usize>(pairs: Option<&[Pair; N]>, x: f64) -> [[f64; 2]; 2] {
    let Some(pairs) = pairs else { return [[f64::NAN; 2]; 2] };
    let square = x * x;
    let ([mut e, mut e1], [mut o, mut o1]) = ([[0.0; 2]; 2], [[0.0; 2]; 2]);
    for n in (0..N / 2).rev() {
        let (even, odd) = (&pairs[2 * n].0, &pairs[2 * n + 1].0);
        e1 = [e1[0] * square + e[0], e1[1] * square + e[1]];
        o1 = [o1[0] * square + o[0], o1[1] * square + o[1]];
        e = [e[0] * square + even[0], e[1] * square + even[1]];
        o = [o[0] * square + odd[0], o[1] * square + odd[1]];
    }
    [std::array::from_fn(|i| e[i] + x * o[i]), std::array::from_fn(|i| o[i] + 2.0 * (x * e1[i] + square * o1[i]))]
}

/// n + 1.
const ORDER: [f64; COEFFICIENTS] = {
    let mut table = [0.0; COEFFICIENTS];
    let mut n = 0;
    while n < COEFFICIENTS {
        table[n] = (n + 1) as f64;
        n += 1;
    }
    table
};

/// 1/((n + 1)(n + 2)).
const RECIPROCAL: [f64; COEFFICIENTS] = {
    let mut table = [0.0; COEFFICIENTS];
    let mut n = 0;
    while n < COEFFICIENTS {
        table[n] = 1.0 / ((n + 1) * (n + 2)) as f64;
        n += 1;
    }
    table
};

/// 2ⁿ/n!, the part of its sum that the term of order n can have where the series lasts two radians.
fn part_of_term(n: usize) -> f64 {
    (1..=n).map(|n| REACH / n as f64).product()
}

/// Whether the last two terms of ü are as small as at constant speed; `scale` (m) is the size of ü in units of the
/// span.
fn decayed(u: &[f64], scale: f64) -> bool {
    let term = |n: usize| (n * (n - 1)) as f64 * u[n].abs();
    let sum = (2..u.len()).map(term).sum::<f64>().max(scale);
    let last = u.len() - 1;
    term(last) + term(last - 1) <= 2.0 * part_of_term(last - 3) * sum
}
