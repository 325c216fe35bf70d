//! A panel: a span of time in one mode over which the motion is known to rounding, as a power series of time.
//!
//! The series of the flank u(t) gives that of q by the recurrence of the equation of motion,
//!
//! q̈ = −2δ q̇ − ω² q − ü (contact: δ, ω of m2 on its spring) or q̈ = −2δ₂ q̇ − ω₂² q (flight: of m1 against m2),
//!
//! and the gap in flight follows from m1 z̈ = c q + b q̇ − m1 ü. About the start of a flight the gap begins with exact
//! zeros, so that no term cancels while it is small. A panel lasts two radians of the fastest change: then the term of
//! order n is at most 2ⁿ/n! of the amplitude, and the first event in the panel is the first zero of a polynomial
//! ([`super::switching`]).
//!
//! Source: A. Griewank, A. Walther, *Evaluating Derivatives*, 2nd ed., SIAM 2008, section 13.2 (Taylor series of
//! solutions).

use super::contact::{Bodies, Flank, Mode, State};
use super::flank::FlankMotion;
use super::slow::stiff_rate;
use crate::drives::number::all_finite;
use crate::motion::Kinematics;
use crate::numerics::count::at_most;
use crate::numerics::double_double::Double;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::quadrature::Gauss;
use serde::{Deserialize, Serialize};

/// The fastest rate times the length of a panel [rad].
pub(super) const REACH: f64 = 2.0;

/// The most terms of a series: of ü, 2²²/22! = 4e-15 is left out, of q and the gap 2²⁴/24! = 3e-17.
pub const MOST_TERMS: usize = 24;

/// The fewest terms of a series.
const LEAST_TERMS: usize = 8;

/// Halvings of a panel; a span of 2⁻⁶⁰ shows no change of the speed any more.
const MOST_HALVINGS: usize = 60;

/// A panel with the search for its event, beside the expansion of u [nominal µs].
const PANEL: f64 = 0.7;

/// The series of u and q have two terms more than that of ü.
pub(super) const COEFFICIENTS: usize = MOST_TERMS + 2;

/// Two coefficients, aligned for packed arithmetic.
#[repr(align(16))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pair(pub(super) [f64; 2]);

/// A panel; see the module.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Panel {
    /// When it starts [s].
    pub start: Double,
    /// How long it lasts [s].
    pub length: f64,
    /// The first event, after the start [s].
    pub event: Option<(Found, f64)>,
    /// The smooth segment of the flank.
    pub segment: usize,
    /// The segment at the end.
    pub next_segment: usize,
    /// Where m1 is.
    pub mode: Mode,
    /// The state at the start.
    pub state: State,
    /// The unit of time of the series [s].
    pub(super) span: f64,
    #[serde(deserialize_with = "at_most::<_, MOST_TERMS>")]
    pub(super) terms: usize,
    /// Spans per second.
    pub(super) per_span: f64,
    /// The coefficients of u (contact) or ζ (flight) and of q.
    pub(super) pairs: [Pair; COEFFICIENTS],
    /// In flight the centre of mass at the start [m] and its velocity [m/s].
    pub(super) centre: [f64; 2],
    /// The free vibration at the start, q [m] and q̇ [m/s], of a series apart from the fast modes.
    pub(super) vibration: [f64; 2],
    /// What it took to lay it [nominal µs].
    #[serde(skip)]
    pub cost: f64,
}

/// What the search in a panel finds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Found {
    /// Release from the flank.
    Release,
    /// Impact on the flank.
    Impact(Flank),
}

/// The motion at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The relative state.
    pub state: State,
    /// u [m], u̇ [m/s] and, in contact, ü [m/s²].
    pub u: [f64; 3],
}

impl Point {
    /// What is read of it.
    pub fn reading(&self) -> Reading {
        let State { q, home, zeta } = self.state;
        Reading { place: [self.u[0] + (home + zeta[0]), self.u[1] + zeta[1]], q }
    }
}

/// What is read at every communication point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// x1 [m] and ẋ1 [m/s].
    pub place: [f64; 2],
    /// q [m] and q̇ [m/s].
    pub q: [f64; 2],
}

impl Reading {
    /// Whether all numbers are.
    pub fn is_finite(&self) -> bool {
        all_finite([self.place[0], self.place[1], self.q[0], self.q[1]])
    }
}

/// How a run builds its panels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rules {
    /// Terms of a series, even.
    pub terms: usize,
    /// Whether m1 cannot leave the flank: without clearance the other one holds it.
    pub locked: bool,
}

impl Rules {
    /// The fewest terms with which a panel leaves out less than the part `tolerance` of ü.
    pub fn terms_for(tolerance: f64) -> usize {
        (LEAST_TERMS..MOST_TERMS).step_by(2).find(|terms| part_of_term(terms - 2) <= tolerance).unwrap_or(MOST_TERMS)
    }
}

/// A series while it is computed.
pub(super) type Terms = [f64; COEFFICIENTS];

impl Panel {
    /// The panel that starts at `start` in this state, at most `longest` [s] long.
    pub fn new(
        bodies: &Bodies,
        flank: &impl FlankMotion,
        place: (Double, usize),
        from: (Mode, State, usize),
        longest: f64,
        rules: Rules,
    ) -> Self {
        let mut panel = Panel {
            start: place.0,
            length: 0.0,
            event: None,
            segment: place.1,
            next_segment: place.1,
            mode: from.0,
            state: from.1,
            span: 0.0,
            terms: rules.terms,
            per_span: 0.0,
            pairs: [Pair::default(); COEFFICIENTS],
            centre: [0.0; 2],
            vibration: [0.0; 2],
            cost: 0.0,
        };
        panel.lay(bodies, flank, place, from, longest, rules);
        panel
    }

    /// Becomes the panel that starts at `start` in this state, at most `longest` [s] long.
    pub fn lay(
        &mut self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        (start, segment): (Double, usize),
        (mode, state, zeros): (Mode, State, usize),
        longest: f64,
        rules: Rules,
    ) {
        (self.start, self.segment, self.next_segment) = (start, segment, segment);
        (self.mode, self.state, self.terms) = (mode, state, rules.terms);
        (self.length, self.event, self.vibration, self.cost) = (0.0, None, [0.0; 2], PANEL);
        let oscillator = self.oscillator(bodies);
        let flank_rate = flank.rate(segment, start, 0.0);
        let stiff = stiff_rate(oscillator, flank_rate);
        if stiff.is_some_and(|slow| self.lay_smoothly(bodies, flank, (slow, zeros), longest, rules)) {
            return;
        }
        (self.vibration, self.event) = ([0.0; 2], None);
        let rate = oscillator.rates().1.max(flank_rate);
        let u = self.expand_flank(flank, REACH / rate);
        self.expand(bodies, oscillator, &u, zeros);
        (self.length, self.next_segment) = flank.stay(segment, start, self.span.min(longest));
        if !rules.locked && self.length > 0.0 {
            self.event = self.find(bodies, flank, zeros, rate);
        }
    }

    /// The oscillator that moves q.
    pub(super) fn oscillator<'a>(&self, bodies: &'a Bodies) -> &'a Oscillator {
        bodies.oscillator(self.mode)
    }

    /// The series of u with `span` [s] as the unit of time, or with one in which it decays fast enough.
    pub(super) fn expand_flank(&mut self, flank: &impl FlankMotion, span: f64) -> Terms {
        let mut u = [0.0; COEFFICIENTS];
        self.span = span;
        for _ in 0..MOST_HALVINGS {
            let h = self.span;
            flank.expand(self.segment, self.start, h, &mut u[..self.terms + 2]);
            self.cost += flank.cost();
            if flank.is_uniform() || decayed(&u[..self.terms + 2], flank.acceleration(self.start) * h * h) {
                break;
            }
            self.span *= 0.5;
        }
        self.per_span = 1.0 / self.span;
        u
    }

    /// Fills the series from that of u.
    fn expand(&mut self, bodies: &Bodies, oscillator: &Oscillator, u: &Terms, zeros: usize) {
        let (h, terms) = (self.span, self.terms);
        let damping = 2.0 * oscillator.damping() * h;
        let stiffness = oscillator.stiffness() * h * h;
        let (mut q, mut v) = (self.state.q[0], self.state.q[1] * h);
        if self.mode != Mode::Free {
            (self.pairs[0], self.pairs[1]) = (Pair([u[0], q]), Pair([u[1], v]));
            for n in 0..terms {
                let next = -(damping * ORDER[n] * v + stiffness * q) * RECIPROCAL[n] - u[n + 2];
                self.pairs[n + 2] = Pair([u[n + 2], next]);
                (q, v) = (v, next);
            }
            return;
        }
        let share = bodies.share;
        self.set_centre(bodies, u);
        (self.pairs[0], self.pairs[1]) = (Pair([self.state.zeta[0], q]), Pair([self.state.zeta[1] * h, v]));
        for n in 0..terms {
            let next = -(damping * ORDER[n] * v + stiffness * q) * RECIPROCAL[n];
            // The centre of mass moves uniformly: m1 z̈ = c q + b q̇ − m1 ü is this share of −q̈.
            self.pairs[n + 2] = Pair([-share * next - u[n + 2], next]);
            (q, v) = (v, next);
        }
        self.begin_with(zeros);
    }

    /// The centre of mass at the start of a flight, with the series of u.
    pub(super) fn set_centre(&mut self, bodies: &Bodies, u: &Terms) {
        let State { q, home, zeta } = self.state;
        let share = bodies.share;
        self.centre = [u[0] + home + zeta[0] + share * q[0], u[1] / self.span + zeta[1] + share * q[1]];
    }

    /// The gap begins with this many exact zeros.
    pub(super) fn begin_with(&mut self, zeros: usize) {
        for pair in &mut self.pairs[..zeros] {
            pair.0[0] = 0.0;
        }
    }

    /// q and q̇ `theta` [s] after the start, without a vibration.
    fn elongation_at(&self, theta: f64) -> [f64; 2] {
        let [[_, q], [_, v]] = self.series_at(theta * self.per_span);
        [q, v * self.per_span]
    }

    /// The series x spans after the start, and its derivatives per span.
    fn series_at(&self, x: f64) -> [[f64; 2]; 2] {
        // Even and odd terms apart: p = E(x²) + x O(x²), p′ = O + 2x E′ + 2x² O′.
        match self.terms {
            ..=10 => sums(self.pairs.first_chunk::<12>(), x),
            11..=14 => sums(self.pairs.first_chunk::<16>(), x),
            15..=18 => sums(self.pairs.first_chunk::<20>(), x),
            _ => sums(Some(&self.pairs), x),
        }
    }

    /// What the series up to `theta` [s] round, as the sizes of their first terms, and what they neglect: in ζ, ζ̇, q, q̇.
    pub fn errors(&self, theta: f64) -> [[f64; 4]; 2] {
        let x = (theta * self.per_span).min(1.0);
        // The impact is located with these terms only; a state has two terms more.
        let last = x.powi(self.terms as i32);
        let [mut sizes, mut neglected] = [[0.0; 4]; 2];
        let first = if self.mode == Mode::Free { 0 } else { 1 };
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

    /// The state `theta` [s] after the start, with u, u̇ … u⁗.
    pub fn event_at(&self, bodies: &Bodies, flank: &impl FlankMotion, theta: f64) -> (State, Kinematics) {
        (self.at(bodies, theta).state, flank.at(self.segment, self.instant(theta)))
    }

    /// ü in contact, `theta` [s] after the start.
    pub fn flank_acceleration(&self, theta: f64) -> f64 {
        let x = theta * self.per_span;
        let sum = (0..self.terms).rev().fold(0.0, |sum, n| sum * x + ORDER[n] * ORDER[n + 1] * self.pairs[n + 2].0[0]);
        sum * self.per_span * self.per_span
    }

    /// How long after the start `time` is [s], to the last digit or two: the first difference is exact where it is small.
    #[inline(always)]
    pub fn until(&self, time: f64) -> f64 {
        (time - self.start.hi) - self.start.lo
    }

    /// The instant `theta` [s] after the start.
    pub fn instant(&self, theta: f64) -> Double {
        self.start + Double::from(theta)
    }

    /// The motion `theta` [s] after the start, without ü.
    pub fn at(&self, bodies: &Bodies, theta: f64) -> Point {
        let [place, rate] = self.series_at(theta * self.per_span);
        let [mut first, mut q] = [0, 1].map(|i| [place[i], rate[i] * self.per_span]);
        let mut state = self.state;
        if self.vibrates() {
            let vibration = self.vibration_at(bodies, theta);
            for i in 0..2 {
                q[i] += vibration[i];
                if self.mode == Mode::Free {
                    first[i] -= bodies.share * vibration[i];
                }
            }
        }
        state.q = q;
        if self.mode != Mode::Free {
            return Point { state, u: [first[0], first[1], 0.0] };
        }
        let share = bodies.share;
        let place = self.centre[0] + theta * self.centre[1] - share * q[0];
        let speed = self.centre[1] - share * q[1];
        // Rounding may put m1 behind a flank that it has not reached.
        state.zeta = [first[0].clamp(-state.home, bodies.s - state.home), first[1]];
        Point { state, u: [place - state.home - state.zeta[0], speed - state.zeta[1], 0.0] }
    }

    /// The motion `theta` [s] after the start with ü.
    pub fn whole_at(&self, bodies: &Bodies, theta: f64) -> Point {
        let mut point = self.at(bodies, theta);
        if self.mode != Mode::Free {
            point.u[2] = self.flank_acceleration(theta);
        }
        point
    }

    /// How far the panel goes before something happens [s].
    pub fn limit(&self) -> f64 {
        self.event.map_or(self.length, |(_, at)| at)
    }

    /// ∫ F_K dt, ∫ U′ F_K dt between two times after the start.
    pub fn integrals(&self, bodies: &Bodies, flank: &impl FlankMotion, from: f64, to: f64) -> [f64; 2] {
        if to <= from || self.mode == Mode::Free {
            return [0.0; 2];
        }
        // The product changes by at most four radians in a panel: 4¹⁶/(16! 2¹⁶ 4¹⁶) in half of one.
        let parts = ((to - from) / (0.5 * self.span)).ceil().clamp(1.0, 2.0) as usize;
        let width = (to - from) / parts as f64;
        let mut sums = self.vibration_integrals(bodies, flank, [from, to]);
        for part in 0..parts {
            let left = from + part as f64 * width;
            let [force, torque] = Gauss::with(8).integrate(width, |s| {
                let [q, q_dot] = self.elongation_at(left + s);
                let force = bodies.m1 * self.flank_acceleration(left + s) - bodies.link(q, q_dot);
                [force, force * flank.slope(self.segment, self.instant(left + s))]
            });
            sums = [sums[0] + force, sums[1] + torque];
        }
        sums
    }

    /// ∫ b q̇² dt from the start to `theta` [s].
    pub fn damping_loss(&self, bodies: &Bodies, theta: f64) -> f64 {
        if bodies.b == 0.0 || theta <= 0.0 {
            return 0.0;
        }
        let [smooth] = Gauss::with(8).integrate(theta, |s| {
            let [_, v] = self.elongation_at(s);
            [bodies.b * v * v]
        });
        smooth + self.vibration_loss(bodies, theta)
    }
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
pub(super) const ORDER: [f64; COEFFICIENTS] = {
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

/// 2ⁿ/n!, the part of its sum that the term of order n can have where the panel lasts two radians.
pub fn part_of_term(n: usize) -> f64 {
    (1..=n).map(|n| REACH / n as f64).product()
}

/// Whether the last two terms of ü are as small as at constant speed; `scale` [m] is the size of ü in units of the
/// span.
fn decayed(u: &[f64], scale: f64) -> bool {
    let term = |n: usize| (n * (n - 1)) as f64 * u[n].abs();
    let sum = (2..u.len()).map(term).sum::<f64>().max(scale);
    let last = u.len() - 1;
    term(last) + term(last - 1) <= 2.0 * part_of_term(last - 3) * sum
}
