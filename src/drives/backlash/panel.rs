//! A panel: a span of time in one mode over which the motion is a power series of time, exact to rounding.
//!
//! The series of the flank u(t) gives that of q by the recurrence of the equation of motion,
//!
//! q̈ = −2δ q̇ − ω² q − ü (contact: δ, ω of m2 on its spring) or q̈ = −2δ₂ q̇ − ω₂² q (flight: of m1 against m2),
//!
//! and the gap in flight follows from m1 z̈ = c q + b q̇ − m1 ü. About the start of a flight the gap begins with exact
//! zeros, so that no term cancels while it is small. A panel lasts two radians of the fastest change: then the term of
//! order n is at most 2ⁿ/n! of the amplitude, and the first event in the panel is the first zero of a polynomial
//! ([`first_zero`]).
//!
//! Source: A. Griewank, A. Walther, *Evaluating Derivatives*, 2nd ed., SIAM 2008, section 13.2 (Taylor series of
//! solutions).

use super::contact::{Bodies, Flank, Mode, State};
use super::flank::FlankMotion;
use super::slow::stiff_rate;
use crate::numerics::double_double::Double;
use crate::numerics::first_zero::first_zero;
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

/// The shortest flight that begins without velocity, as a part of the shortest time in which anything changes. A mass
/// that is back earlier has moved by 1e-14 of a typical displacement, next to the rounding of x1.
const ARMING: f64 = 1e-7;

/// u, u̇, q, q̇ and, in contact, ü; in flight ζ, ζ̇.
pub(super) type Row = [f64; 6];

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
    pub(super) terms: usize,
    pub(super) rows: [Row; MOST_TERMS],
    /// Of a panel apart from the fast modes: their free vibration at the start, q [m] and q̇ [m/s].
    pub(super) vibration: [f64; 2],
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
    /// Whether all numbers are.
    pub fn is_finite(&self) -> bool {
        self.state.q.iter().chain(&self.state.zeta).chain(&self.u).all(|v| v.is_finite())
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

/// A series while it is computed; ü needs two terms more of u than there are rows.
pub(super) type Terms = [f64; MOST_TERMS + 2];

impl Panel {
    /// The panel that starts at `start` in this state, at most `longest` [s] long.
    pub fn new(
        bodies: &Bodies,
        flank: &impl FlankMotion,
        (start, segment): (Double, usize),
        (mode, state, zeros): (Mode, State, usize),
        longest: f64,
        rules: Rules,
    ) -> Self {
        let mut panel = Panel {
            start,
            length: 0.0,
            event: None,
            segment,
            next_segment: segment,
            mode,
            state,
            span: 0.0,
            terms: rules.terms,
            rows: [[0.0; 6]; MOST_TERMS],
            vibration: [0.0; 2],
        };
        let oscillator = panel.oscillator(bodies);
        let flank_rate = flank.rate(segment, start, 0.0);
        let stiff = stiff_rate(oscillator, flank_rate);
        if stiff.is_some_and(|slow| panel.lay_smoothly(bodies, flank, (slow, zeros), longest, rules)) {
            return panel;
        }
        (panel.vibration, panel.event) = ([0.0; 2], None);
        let rate = oscillator.rates().1.max(flank_rate);
        let u = panel.expand_flank(flank, REACH / rate);
        panel.expand(bodies, oscillator, &u, zeros);
        (panel.length, panel.next_segment) = flank.stay(segment, start, panel.span.min(longest));
        if !rules.locked && panel.length > 0.0 {
            panel.event = panel.find(bodies, flank, zeros, rate);
        }
        panel
    }

    /// The oscillator that moves q.
    pub(super) fn oscillator<'a>(&self, bodies: &'a Bodies) -> &'a Oscillator {
        match self.mode {
            Mode::Contact(_) => &bodies.bound,
            Mode::Free => &bodies.relative,
        }
    }

    /// The series of u with `span` [s] as the unit of time, or with one in which it decays fast enough.
    pub(super) fn expand_flank(&mut self, flank: &impl FlankMotion, span: f64) -> Terms {
        let mut u = [0.0; MOST_TERMS + 2];
        self.span = span;
        for _ in 0..MOST_HALVINGS {
            let h = self.span;
            flank.expand(self.segment, self.start, h, &mut u[..self.terms + 2]);
            if flank.is_uniform() || decayed(&u[..self.terms + 2], flank.acceleration(self.start) * h * h) {
                break;
            }
            self.span *= 0.5;
        }
        u
    }

    /// Fills the rows from the series of u.
    fn expand(&mut self, bodies: &Bodies, oscillator: &Oscillator, u: &Terms, zeros: usize) {
        let (h, terms) = (self.span, self.terms);
        let per_span = 1.0 / h;
        let damping = 2.0 * oscillator.damping() * h;
        let stiffness = oscillator.stiffness() * h * h;
        let contact = self.mode != Mode::Free;
        // h q̇ and h ζ̇ have the unit of q.
        let (mut q, mut v) = (self.state.q[0], self.state.q[1] * h);
        let [mut z, mut y] = [self.state.zeta[0], self.state.zeta[1] * h];
        let share = bodies.m2 / (bodies.m1 + bodies.m2);
        for n in 0..terms {
            let order = (n + 1) as f64;
            let inverse = INVERSE[n + 1];
            let speed = order * u[n + 1];
            let acceleration = order * (order + 1.0) * u[n + 2];
            let row = &mut self.rows[n];
            if contact {
                *row = [u[n], speed * per_span, q, v * per_span, acceleration * per_span * per_span, 0.0];
                let next = -(damping * v + stiffness * q) - acceleration;
                (q, v) = (v * inverse, next * inverse);
            } else {
                // The gap begins with exact zeros.
                if n < zeros {
                    z = 0.0;
                }
                if n + 1 < zeros {
                    y = 0.0;
                }
                *row = [u[n], speed * per_span, q, v * per_span, z, y * per_span];
                let next = -(damping * v + stiffness * q);
                // The centre of mass moves uniformly: m1 z̈ = c q + b q̇ − m1 ü is this share of −q̈.
                let pull = -(share * next + acceleration);
                (q, v) = (v * inverse, next * inverse);
                (z, y) = (y * inverse, pull * inverse);
            }
        }
    }

    /// u, u̇, q, q̇ and the rest at x spans after the start.
    fn row(&self, x: f64) -> Row {
        let square = x * x;
        let (mut even, mut odd) = ([0.0; 6], [0.0; 6]);
        for pair in self.rows[..self.terms].chunks_exact(2).rev() {
            for n in 0..6 {
                even[n] = even[n] * square + pair[0][n];
                odd[n] = odd[n] * square + pair[1][n];
            }
        }
        std::array::from_fn(|n| even[n] + x * odd[n])
    }

    /// The instant `theta` [s] after the start.
    pub fn instant(&self, theta: f64) -> Double {
        self.start + Double::from(theta)
    }

    /// The motion `theta` [s] after the start.
    pub fn at(&self, bodies: &Bodies, theta: f64) -> Point {
        let mut row = self.row(theta / self.span);
        self.add_vibration(bodies, theta, &mut row);
        let [u, u_dot, q, q_dot, z, y] = row;
        let mut state = State { q: [q, q_dot], ..self.state };
        match self.mode {
            Mode::Contact(_) => Point { state, u: [u, u_dot, z] },
            Mode::Free => {
                // Rounding may put m1 behind a flank that it has not reached.
                state.zeta = [z.clamp(-state.home, bodies.s - state.home), y];
                Point { state, u: [u, u_dot, 0.0] }
            }
        }
    }

    /// How far the panel goes before something happens [s].
    pub fn limit(&self) -> f64 {
        self.event.map_or(self.length, |(_, at)| at)
    }

    /// σ F_K as a series.
    pub(super) fn force_series(&self, bodies: &Bodies, contact: Flank) -> [f64; MOST_TERMS] {
        let sign = contact.sign();
        let mut force = [0.0; MOST_TERMS];
        for (f, [_, _, q, q_dot, u2, _]) in force.iter_mut().zip(&self.rows[..self.terms]) {
            *f = sign * (bodies.m1 * u2 - bodies.link(*q, *q_dot));
        }
        force
    }

    /// The distance from `flank` as a series.
    pub(super) fn gap_series(&self, bodies: &Bodies, flank: Flank) -> [f64; MOST_TERMS] {
        let sign = flank.sign();
        let mut gap = [0.0; MOST_TERMS];
        for (g, row) in gap.iter_mut().zip(&self.rows[..self.terms]) {
            *g = sign * row[4];
        }
        gap[0] += sign * (self.state.home - bodies.place(flank));
        gap
    }

    /// The first event in the panel; `rate` is the fastest change [rad/s].
    pub(super) fn find(
        &self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        zeros: usize,
        rate: f64,
    ) -> Option<(Found, f64)> {
        match self.mode {
            Mode::Contact(contact) => self.release(bodies, contact, bodies.resolution(flank, self.start)),
            Mode::Free => self.impact(bodies, zeros, rate),
        }
    }

    /// The first release in the panel: where F_K has fallen to the resolution below zero.
    fn release(&self, bodies: &Bodies, contact: Flank, resolution: f64) -> Option<(Found, f64)> {
        let mut force = self.force_series(bodies, contact);
        // At rest nothing pulls.
        if force == [0.0; MOST_TERMS] {
            return None;
        }
        force[0] += resolution;
        let seen = first_zero(&force[..self.terms], self.length / self.span)?;
        force[0] -= resolution;
        Some((Found::Release, polish(&force[..self.terms], seen) * self.span))
    }

    /// The first impact in the panel.
    fn impact(&self, bodies: &Bodies, zeros: usize, rate: f64) -> Option<(Found, f64)> {
        let mut end = self.length / self.span;
        let mut found = None;
        for flank in [Flank::A, Flank::B] {
            let gap = self.gap_series(bodies, flank);
            let Some(mut zero) = first_zero(&gap[..self.terms], end) else { continue };
            if zeros >= 2 && self.state.home == bodies.place(flank) {
                zero = zero.max(ARMING / (rate * self.span)).min(end);
            }
            (end, found) = (zero, Some((Found::Impact(flank), zero * self.span)));
        }
        found
    }

    /// ∫ F_K dt, ∫ U′ F_K dt between two times after the start.
    pub fn integrals(&self, bodies: &Bodies, flank: &impl FlankMotion, from: f64, to: f64) -> [f64; 2] {
        if to <= from || self.mode == Mode::Free {
            return [0.0; 2];
        }
        // The product changes by at most four radians in a panel: 4¹⁶/(16! 2¹⁶ 4¹⁶) in half of one.
        let parts = if to - from > 0.5 * self.span { 2 } else { 1 };
        let width = (to - from) / f64::from(parts);
        let mut sums = self.vibration_integrals(bodies, flank, [from, to]);
        for part in 0..parts {
            let left = from + f64::from(part) * width;
            let [force, torque] = Gauss::with(8).integrate(width, |s| {
                let [_, _, q, q_dot, u2, _] = self.row((left + s) / self.span);
                let force = bodies.m1 * u2 - bodies.link(q, q_dot);
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
        let speed = |x: f64| self.rows[..self.terms].iter().rev().fold(0.0, |sum, row| sum * x + row[3]);
        let [loss] = Gauss::with(8).integrate(theta, |s| {
            let v = speed(s / self.span);
            [bodies.b * v * v]
        });
        loss + self.vibration_loss(bodies, theta)
    }
}

/// 1/n.
const INVERSE: [f64; MOST_TERMS + 1] = {
    let mut table = [0.0; MOST_TERMS + 1];
    let mut n = 1;
    while n <= MOST_TERMS {
        table[n] = 1.0 / n as f64;
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

/// The zero of the force just before `seen`, where it has fallen to the resolution below zero.
fn polish(force: &[f64], seen: f64) -> f64 {
    let mut zero = seen;
    for _ in 0..3 {
        let (mut value, mut slope) = (0.0, 0.0);
        for &c in force.iter().rev() {
            slope = slope * zero + value;
            value = value * zero + c;
        }
        let next = zero - value / slope;
        // A force that only just reaches zero keeps the instant at which it is seen to pull.
        if !(slope < 0.0 && next >= 0.0 && (next - seen).abs() <= 1e-4) {
            return seen;
        }
        zero = next;
    }
    zero.min(seen)
}
