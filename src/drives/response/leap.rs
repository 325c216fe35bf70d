//! One communication step of a Fourier law on a moving input by one Gauss rule.
//!
//! q(h) = free motion + ∫ g(h − s) (−ẍ(s)) ds with the impulse response g. As long as neither cam nor oscillator turn
//! far within the step, a few Gauss nodes meet the integral to the tolerance, and a bound on what they leave is known
//! before anything is computed. Nodes and impulse response are kept: importers repeat their steps.
//!
//! Source: M. Abramowitz, I. A. Stegun, *Handbook of Mathematical Functions*, section 25.4.29 (error of the rule).

pub mod expansion;

use super::{DEGREE, Local, progression};
use crate::motion::Fourier;
use crate::numerics::double_double::Double;
use crate::numerics::forced::apply;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::phase::sin_cos;
use crate::numerics::quadrature::Gauss;
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

/// What a step of one length needs of the oscillator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Leap {
    /// h [s]; 0 while unknown.
    length: f64,
    /// How many nodes.
    nodes: usize,
    /// The places of every second node [s]; each of the others lies as far from the end as the one before from the start.
    places: [f64; MOST_NODES / 2],
    /// Weight times g and ġ at h less the place; the Wⱼ where there are no nodes.
    weights: [[f64; 2]; expansion::MOMENTS],
    /// The free motion over the step.
    free: [[f64; 2]; 2],
    /// The decay of the slower mode over the step.
    decay: f64,
    /// The first harmonic of the law and the distance to the next.
    first: usize,
    stride: usize,
}

/// The end of a leap.
pub struct Landing {
    /// q, q̇.
    pub state: [f64; 2],
    /// Bound of the error of the rule, of q [m] and of q̇ [m/s].
    pub error: [f64; 2],
    /// A bound of |ẍ| over the step [m/s²].
    pub forcing: f64,
    /// How many nodes.
    pub evaluations: usize,
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
        Leap { first, stride, ..Leap::default() }
    }

    /// Forgets the oscillator.
    pub fn clear(&mut self) {
        self.length = 0.0;
    }

    /// By which factor the slower mode decays over the step.
    pub fn decay(&self) -> f64 {
        self.decay
    }

    /// From `state` over `length` [s] on the motion `local` by a [`rule`]; `bounds` are those of |U′| and |U″|.
    pub fn over(
        &mut self,
        oscillator: &Oscillator,
        series: &Fourier,
        bounds: [f64; 2],
        local: &Local,
        length: f64,
        state: [f64; 2],
        (nodes, part): (usize, f64),
    ) -> Landing {
        let (_, fast) = oscillator.rates();
        // A rule that is a little better than needed is kept.
        let kept = nodes <= self.nodes && self.nodes <= 2 * nodes;
        if !kept || !((length - self.length).abs() <= SAME_LENGTH * length) {
            self.prepare(oscillator, length, nodes);
        }
        let (forced, last) = self.forced(series, local);
        let [q, v] = apply(&self.free, state);
        let (q, v) = (q + forced[0], v + forced[1]);
        let rest = length - self.length;
        let rate = last - oscillator.stiffness() * q - 2.0 * oscillator.damping() * v;
        let scale = bounds[1] * local.speed(length).powi(2) + bounds[0] * local.acceleration(length);
        // |g| ≤ min(h, 1/|λ|) and |ġ| ≤ 1.
        let error = part * length * scale;
        Landing {
            state: [q + rest * v, v + rest * rate],
            error: [error * length.min(1.0 / fast), error],
            forcing: scale,
            evaluations: self.nodes,
        }
    }

    #[cold]
    fn prepare(&mut self, oscillator: &Oscillator, length: f64, nodes: usize) {
        self.keep(oscillator, length, nodes);
        let rule: [[f64; 2]; MOST_NODES] = Gauss::with(nodes).nodes(length);
        for (i, [place, weight]) in rule.into_iter().enumerate() {
            if i % 2 == 0 {
                self.places[i / 2] = place;
            }
            self.weights[i] = oscillator.kernel(length - place).map(|g| weight * g);
        }
    }

    /// What all steps of this length have in common.
    fn keep(&mut self, oscillator: &Oscillator, length: f64, nodes: usize) {
        (self.length, self.nodes) = (length, nodes);
        self.free = oscillator.free(Double::from(length));
        self.decay = (-oscillator.decay() * length).exp();
    }

    /// The forced motion, and −ẍ at the last node.
    fn forced(&self, series: &Fourier, local: &Local) -> ([f64; 2], f64) {
        let mut sum = [0.0; 2];
        let mut forcing = [0.0; 2];
        for i in (0..self.nodes).step_by(2) {
            let place = self.places[i / 2];
            forcing = self.forcing(series, [place, self.length - place].map(|tau| local.at(tau)));
            for j in 0..2 {
                let [g, rate] = self.weights[i + j];
                sum = [sum[0] + g * forcing[j], sum[1] + rate * forcing[j]];
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
