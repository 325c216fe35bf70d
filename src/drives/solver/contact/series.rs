//! The motion in one mode as power series of time.
//!
//! The series of the flank u(t) gives the series of q by the recurrence of the equation of motion,
//!
//! q̈ = −2δ q̇ − ω² q − ü (contact: δ, ω of m2 on its spring) or q̈ = −2δ₂ q̇ − ω₂² q (flight: of m1 against m2),
//!
//! and the gap in flight follows from m1 z̈ = c q + b q̇ − m1 ü. About the start of a flight the gap begins with exact
//! zeros, so that no term cancels while it is small. A series serves for two radians of the fastest change: then the term of
//! order n is at most 2ⁿ/n! of the amplitude.
//!
//! Source: A. Griewank, A. Walther, *Evaluating Derivatives*, 2nd ed., SIAM 2008, section 13.2 (Taylor series of
//! solutions).

use crate::drives::follower::contact::{Beginning, Bodies, Flank, Mode, Phase};
use crate::drives::follower::flank::FlankMotion;
use crate::numerics::count::at_most;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::pair::Pair;
use serde::{Deserialize, Serialize};

/// The fastest rate times the length of a series (rad).
pub const REACH: f64 = 2.0;

/// The most terms of a series: ü leaves out 2²²/22! = 4e-15, q and the gap 2²⁴/24! = 3e-17.
pub const MOST_TERMS: usize = 24;

/// The fewest terms of a series.
const LEAST_TERMS: usize = 8;

/// Halvings of a span; over 2⁻⁶⁰ of it the speed no longer changes.
const MOST_HALVINGS: usize = 60;

/// The series of u and q have two terms more than ü's.
const COEFFICIENTS: usize = MOST_TERMS + 2;

/// A series while it is computed.
pub type Terms = [f64; COEFFICIENTS];

/// u (contact) or ζ (flight), paired with q.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Series {
    /// The unit of time (s).
    pub span: f64,
    /// Terms of ü, even.
    #[serde(deserialize_with = "at_most::<_, MOST_TERMS>")]
    pub terms: usize,
    /// Spans per second.
    per_span: f64,
    pairs: [Pair; COEFFICIENTS],
    /// In contact the terms of F_K, paired with those of u̇.
    forces: [Pair; MOST_TERMS],
}

/// The series of the flank.
pub struct FlankSeries {
    /// The unit of time (s).
    pub span: f64,
    /// Terms of ü, even.
    pub terms: usize,
    /// The coefficients of u.
    pub u: Terms,
    /// Cost of the expansion (nominal µs).
    pub cost: f64,
}

impl FlankSeries {
    /// Expands u from `from` on with `span` (s) as the unit of time, or with a shorter one in which the series decays fast enough.
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
        let damping = -2.0 * oscillator.damping() * h;
        let stiffness = -oscillator.stiffness() * h * h;
        let driven = if phase.mode == Mode::Free { &[0.0; COEFFICIENTS] } else { &self.u };
        let mut series = [0.0; COEFFICIENTS];
        [series[0], series[1]] = [phase.state.q[0], phase.state.q[1] * h];
        // Four at a time: the compiler writes these out.
        for first in (0..MOST_TERMS).step_by(4) {
            for n in first..first + 4 {
                let force = damping * ORDER[n] * series[n + 1] + stiffness * series[n];
                series[n + 2] = RECIPROCAL[n] * force - driven[n + 2];
            }
        }
        series[self.terms.min(MOST_TERMS) + 2..].fill(0.0);
        series
    }
}

impl Series {
    /// Becomes the series of u or ζ, paired with `q`.
    pub fn take(&mut self, bodies: &Bodies, phase: &Phase, flank: &FlankSeries, q: &Terms) {
        let FlankSeries { span, terms, ref u, .. } = *flank;
        // Bounds known to the compiler need no check.
        (self.span, self.terms, self.per_span) = (span, terms.min(MOST_TERMS), 1.0 / span);
        if phase.mode == Mode::Free {
            let share = bodies.share;
            for n in 2..COEFFICIENTS {
                // The centre of mass moves uniformly: m1 z̈ = c q + b q̇ − m1 ü is this share of −q̈.
                self.pairs[n] = Pair([-share * q[n] - u[n], q[n]]);
            }
            self.pairs[0] = Pair([phase.state.zeta[0], q[0]]);
            self.pairs[1] = Pair([phase.state.zeta[1] * span, q[1]]);
            for pair in &mut self.pairs[..phase.zeros] {
                pair.0[0] = 0.0;
            }
        } else {
            for n in 0..COEFFICIENTS {
                self.pairs[n] = Pair([u[n], q[n]]);
            }
            let per_span = self.per_span;
            let (inertia, damping) = (bodies.m1 * per_span * per_span, bodies.b * per_span);
            for n in 0..MOST_TERMS {
                let link = bodies.c * q[n] + damping * (ORDER[n] * q[n + 1]);
                let force = inertia * (ORDER[n] * ORDER[n + 1]) * u[n + 2] - link;
                self.forces[n] = Pair([force, per_span * (ORDER[n] * u[n + 1])]);
            }
            self.forces[self.terms..].fill(Pair::default());
        }
    }

    /// Values, rates and, if wanted, accelerations of u or ζ (first) and of q (second) at `theta` (s). Never inlined, so that the
    /// pairs stay in registers.
    #[inline(never)]
    pub fn at<const ACCELERATIONS: bool>(&self, theta: f64) -> [Pair; 3] {
        let x = theta * self.per_span;
        let [values, rates, accelerations] = match self.terms_at(x) {
            ..=10 => sums::<12>(&self.pairs, x),
            11..=14 => sums::<16>(&self.pairs, x),
            15..=18 => sums::<20>(&self.pairs, x),
            _ => sums::<COEFFICIENTS>(&self.pairs, x),
        };
        let per_span = Pair::both(self.per_span);
        let accelerations = if ACCELERATIONS { accelerations * per_span * per_span } else { Pair::default() };
        [values, rates * per_span, accelerations]
    }

    /// The number of terms needed at the fraction `x` of the span: (2 x)ⁿ/n! is 4e-19 at half of it and n = 20, 7e-19 at a quarter
    /// and n = 16; for ü and the force, with two terms fewer, 2e-16 and 7e-16.
    pub fn terms_at(&self, x: f64) -> usize {
        self.terms.min(if x <= 0.25 {
            14
        } else if x <= 0.5 {
            18
        } else {
            MOST_TERMS
        })
    }

    /// σ F_K.
    pub fn force(&self, contact: Flank) -> [f64; MOST_TERMS] {
        let sign = contact.sign();
        self.forces.map(|pair| sign * pair.0[0])
    }

    /// F_K and u̇ in contact, `theta` (s) after the start, from so many terms; out of line like [`Series::at`].
    #[inline(never)]
    pub fn force_and_rate<const N: usize>(&self, theta: f64) -> Pair {
        let x = Pair::both(theta * self.per_span);
        (0..N - 1).rev().fold(self.forces[N - 1], |sum, n| sum * x + self.forces[n])
    }

    /// ζ.
    pub fn zeta(&self) -> [f64; MOST_TERMS] {
        let mut zeta = [0.0; MOST_TERMS];
        for (zeta, pair) in zeta.iter_mut().zip(&self.pairs[..self.terms]) {
            *zeta = pair.0[0];
        }
        zeta
    }

    /// Roundings up to `theta` (s), as the sizes of the first terms, and neglected terms: in ζ, ζ̇, q, q̇.
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
            // The neglected terms of the states are smaller by the ratio of such terms.
            let ratio = REACH * REACH * RECIPROCAL[self.terms];
            neglected[2 * i] = if i == 0 { omitted } else { ratio * omitted };
            neglected[2 * i + 1] = ratio * omitted * self.terms as f64 * self.per_span;
        }
        [sizes, neglected]
    }
}

/// The fewest terms with which a series neglects less than the part `tolerance` of ü.
pub fn terms_for(tolerance: f64) -> usize {
    (LEAST_TERMS..MOST_TERMS).step_by(2).find(|terms| part_of_term(terms - 2) <= tolerance).unwrap_or(MOST_TERMS)
}

/// p = Σ cₙ xⁿ, n < N, p′ and p″ of both series: even and odd terms apart, p = E(x²) + x O(x²),
/// p′ = O + 2x (E′ + x O′), p″ = 2E′ + 6x O′ + 4x² (E″ + x O″).
#[inline(always)]
fn sums<const N: usize>(pairs: &[Pair; COEFFICIENTS], x: f64) -> [Pair; 3] {
    let (x, square) = (Pair::both(x), Pair::both(x * x));
    let ([mut e, mut e1, mut e2], [mut o, mut o1, mut o2]) = <[[Pair; 3]; 2]>::default().into();
    for n in (0..N / 2).rev() {
        (e2, o2) = (e2 * square + e1, o2 * square + o1);
        (e1, o1) = (e1 * square + e, o1 * square + o);
        (e, o) = (e * square + pairs[2 * n], o * square + pairs[2 * n + 1]);
    }
    let [two, six, eight] = [2.0, 6.0, 8.0].map(Pair::both);
    [e + x * o, o + two * (x * e1 + square * o1), two * e1 + six * (x * o1) + eight * (square * (e2 + x * o2))]
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

/// 2ⁿ/n!, the largest part of the sum that the term of order n can have if the series spans two radians.
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
