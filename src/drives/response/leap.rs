//! One communication step of a Fourier law on a moving input by one quadrature.
//!
//! q(h) = free motion + ∫ g(h − s) (−ẍ(s)) ds with the impulse response g. As long as neither cam nor oscillator turn
//! far within the step, what the law is at its ends ([`ends`]) or at a few Gauss nodes (here) meets the integral to the
//! tolerance, and a bound on what they leave is known before anything is computed. Weights are kept: importers repeat their
//! steps.
//!
//! Source: M. Abramowitz, I. A. Stegun, *Handbook of Mathematical Functions*, section 25.4.29 (error of the rule).

pub mod ends;

use super::stride::Map;
use super::{ClosedForm, DEGREE, Local, progression};
use crate::motion::Fourier;
use crate::numerics::count::at_most;
use crate::numerics::double_double::Double;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::pair::Pair;
use crate::numerics::phase::sin_cos;
use crate::numerics::quadrature::Gauss;
use ends::Limits;
use serde::{Deserialize, Serialize};

/// The number of nodes n of each rule and 4ⁿ n!⁴/((2n + 1) (2n)!³): times h θ²ⁿ and the largest integrand, the error for
/// an integrand whose derivatives grow like (2θ/h)ᵏ.
const RULES: [(usize, f64); 4] =
    [(4, 1.4397293e-7), (6, 7.7043444e-13), (8, 1.1123830e-18), (MOST_NODES, 1.3690177e-45)];

/// The nodes of the largest rule.
const MOST_NODES: usize = 16;

/// Relative to the step, lengths as near as this count as the same one; the difference, a rounding of the clock, is
/// taken into account to first order.
const SAME_LENGTH: f64 = 1e-9;

/// What a step of one length needs of oscillator and law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Leap {
    /// h [s]; 0 while unknown.
    length: f64,
    /// How many pairs of derivatives at the ends, or how many nodes; one of them is 0.
    #[serde(deserialize_with = "at_most::<_, { ends::MOST_PAIRS }>")]
    pairs: usize,
    #[serde(deserialize_with = "at_most::<_, MOST_NODES>")]
    nodes: usize,
    /// What they count as evaluations of the law: a pair costs what U′ and U″ at a node cost.
    pub evaluations: u64,
    /// At each node the weight times g and ġ at h less the place; or the weights of the derivatives.
    weights: [Pair; MOST_NODES],
    /// The free motion over the step.
    free: Map,
    /// The decay of the slower mode over the step.
    decay: f64,
    /// The first harmonic of the law and the distance to the next; they follow from the law.
    #[serde(skip)]
    first: usize,
    #[serde(skip)]
    stride: usize,
    /// U, U′ … where the cam was last, as far as they are in use; or the places of every second node [s], each of the others
    /// lying as far from the end as the one before from the start.
    u: [Pair; ends::MOST_PAIRS],
    /// Its angle there; infinite while unknown [rad].
    angle: f64,
    /// The steps for which the pairs of derivatives do; none where nodes are in use.
    limits: Limits,
}

/// The fewest nodes that leave no more than the part `share` of the largest integrand, and the part that they leave.
/// None where no rule does.
pub fn rule(oscillator: &Oscillator, series: &Fourier, local: &Local, length: f64, share: f64) -> Option<(usize, f64)> {
    let (_, fast) = oscillator.rates();
    let theta = 0.5 * length * (fast + local.harmonic_rate(series.order() as f64, length));
    let mut parts = RULES.into_iter().map(|(n, factor)| (n, factor * theta.powi(2 * n as i32)));
    parts.find(|(_, part)| *part <= share)
}

impl Leap {
    /// For the harmonics of this law.
    pub fn new(series: &Fourier) -> Self {
        let (first, stride) = progression(series);
        Leap { first, stride, angle: f64::INFINITY, ..Leap::default() }
    }

    /// Rebuilds what the serialisation leaves out.
    pub fn restored(&mut self, series: &Fourier) {
        (self.first, self.stride) = progression(series);
    }

    /// Forgets the oscillator.
    pub fn clear(&mut self) {
        self.length = 0.0;
    }

    /// By which factor the slower mode decays over the step.
    pub fn decay(&self) -> f64 {
        self.decay
    }

    /// How many pairs of derivatives are in use; 0 where nodes are.
    pub fn pairs(&self) -> usize {
        self.pairs
    }

    /// From `state` over `length` [s] on the motion `local` by a [`rule`] of so many nodes.
    pub fn over(
        &mut self,
        oscillator: &Oscillator,
        series: &Fourier,
        local: &Local,
        length: f64,
        state: [f64; 2],
        nodes: usize,
    ) -> [f64; 2] {
        // A rule that is a little better than needed is kept.
        let kept = nodes <= self.nodes && self.nodes <= 2 * nodes;
        if !kept || !self.is_for(length) {
            self.prepare(oscillator, length, nodes);
        }
        let (forced, last) = self.forced_at_nodes(series, local);
        let [q, v] = (self.free.at(state.into()) + forced).array();
        let rest = length - self.length;
        let rate = last - oscillator.stiffness() * q - 2.0 * oscillator.damping() * v;
        [q + rest * v, v + rest * rate]
    }

    #[cold]
    fn prepare(&mut self, oscillator: &Oscillator, length: f64, nodes: usize) {
        self.keep(oscillator, length);
        self.angle = f64::INFINITY;
        (self.nodes, self.pairs, self.limits) = (nodes, 0, Limits::NONE);
        self.evaluations = nodes as u64;
        let rule: [[f64; 2]; MOST_NODES] = Gauss::with(nodes).nodes(length);
        for (i, [place, weight]) in rule.into_iter().enumerate() {
            if i % 2 == 0 {
                self.u[i / 4].0[i / 2 % 2] = place;
            }
            self.weights[i] = Pair::both(weight) * oscillator.kernel(length - place).into();
        }
    }

    /// What all steps of this length have in common.
    fn keep(&mut self, oscillator: &Oscillator, length: f64) {
        self.length = length;
        self.free = Map::of(oscillator.free(Double::from(length)));
        self.decay = (-oscillator.decay() * length).exp();
    }

    /// The forced motion, and −ẍ at the last node.
    fn forced_at_nodes(&self, series: &Fourier, local: &Local) -> (Pair, f64) {
        let mut sum = Pair::default();
        let mut forcing = [0.0; 2];
        for i in (0..self.nodes).step_by(2) {
            let place = self.u[i / 4].array()[i / 2 % 2];
            forcing = self.forcing(series, [place, self.length - place].map(|tau| local.at(tau)));
            for j in 0..2 {
                sum = sum + self.weights[i + j] * Pair::both(forcing[j]);
            }
        }
        (sum, forcing[1])
    }

    /// −ẍ at two nodes with these φ, w, a: side by side they fill the packed registers, more of them would not fit in.
    #[inline(always)]
    fn forcing(&self, series: &Fourier, motion: [[f64; 3]; 2]) -> [f64; 2] {
        let z = motion.map(|[phi, ..]| sin_cos(phi));
        let (s, c) = (z.map(|[s, _]| s), z.map(|[_, c]| c));
        let (mut kc, mut ks) = (c, s);
        rotate(&mut kc, &mut ks, &c, &s, self.first.saturating_sub(1));
        let (mut turn_c, mut turn_s) = (c, s);
        rotate(&mut turn_c, &mut turn_s, &c, &s, self.stride - 1);
        let (mut first, mut second) = ([0.0; 2], [0.0; 2]);
        let mut k = self.first;
        while 0 < k && k <= series.order() {
            let (a, b, order) = (series.a[k], series.b[k], k as f64);
            let square = order * order;
            for i in 0..2 {
                first[i] += order * (b * kc[i] - a * ks[i]);
                second[i] -= square * (a * kc[i] + b * ks[i]);
            }
            rotate(&mut kc, &mut ks, &turn_c, &turn_s, 1);
            k += self.stride;
        }
        [0, 1].map(|i| {
            let [_, w, a] = motion[i];
            -(second[i] * w * w + first[i] * a)
        })
    }
}

/// Turns the pointers (c, s) `times` times by (by_c, by_s).
#[inline(always)]
fn rotate(c: &mut [f64; 2], s: &mut [f64; 2], by_c: &[f64; 2], by_s: &[f64; 2], times: usize) {
    for _ in 0..times {
        for i in 0..2 {
            (c[i], s[i]) = (c[i] * by_c[i] - s[i] * by_s[i], c[i] * by_s[i] + s[i] * by_c[i]);
        }
    }
}

impl Local {
    /// ν such that the derivatives of order m ≤ 32 of the harmonics up to `order` stay below νᵐ over [0, `length`]: by
    /// Cauchy's bound m! (e ν/m)ᵐ on a circle of the radius m/ν, on which K|φⱼ| rʲ ≤ m pⱼ/ν, less the factor √(2πm)
    /// by which that bound is above the derivative of e^(νt) itself.
    fn harmonic_rate(&self, order: f64, length: f64) -> f64 {
        /// The highest derivative that a rule leaves.
        const MOST: f64 = 2.0 * MOST_NODES as f64;
        let mut rate = order * self.speed(length);
        for j in 2..=self.degree {
            // The coefficient about any instant of the step.
            let (mut coefficient, mut binomial, mut power) = (0.0, 1.0, 1.0);
            for i in j..=self.degree.min(DEGREE) {
                coefficient += binomial * self.angle[i].abs() * power;
                binomial *= (i + 1) as f64 / (i + 1 - j) as f64;
                power *= length;
            }
            let part = order * coefficient * MOST.powi(j as i32 - 1);
            rate += if j == 2 { part.sqrt() } else { part.powf(1.0 / j as f64) };
        }
        rate
    }
}
