//! The same step from its two ends: −ẍ as the polynomial of degree 2M + 1 that has its value and first M derivatives there.
//!
//! With σ = (t − t₀)/h the cam turns from an end by p σ + β σ², p = ω h there and β = ½ α h², and x has the Taylor coefficients
//!
//! yₙ = Σⱼ Dₙ₋ⱼ pⁿ⁻²ʲ/(n − 2j)! βʲ/j!, Dₙ = U⁽ⁿ⁾ at that end;
//!
//! ∫ g(h − s) (−ẍ(s)) ds = Σ Wₙ yₙ over both ends and n = 2 … M + 2,
//!
//! where the Wₙ, integrals of g times Hermite's basis polynomials, are those of all steps of this length. The Dₙ at the start are
//! those at the end of the step before.
//!
//! What this leaves is known before anything is computed: |ẍ|⁽ⁿ⁾ ≤ νⁿ max |ẍ| for n ≤ 16 with ν = K|ω| + 3 √(K|α|), so that
//! ẍ errs by (νh)²ᴹ⁺²/(2M + 2)! (σ(1 − σ))ᴹ⁺¹ of its bound, and its integral by (νh)²ᴹ⁺² (M + 1)!²/((2M + 2)! (2M + 3)!).
//!
//! Source: J. Stoer, R. Bulirsch, *Introduction to Numerical Analysis*, section 2.1.5 (interpolation after Hermite and its
//! remainder).

use super::{ClosedForm, Leap, MOST_NODES, SAME_LENGTH};
use crate::motion::Fourier;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::pair::Pair;
use crate::numerics::quadrature::Gauss;

/// The derivatives of the law come in pairs of an even and an odd order: M + 3 = 2 · pairs. Three pairs hold U … U⁗, which the
/// output derivatives need; with five the weights take the memory of those of sixteen nodes.
const RULES: [(usize, f64); 3] =
    [(3, 1.0 / 25401600.0), (4, 1.0 / 5753767219200.0), (MOST_PAIRS, 1.0 / 4.57769719959552e18)];

/// See [`RULES`].
pub(super) const MOST_PAIRS: usize = 5;

/// Up to this |λ|h 16 nodes integrate the kernel times the basis polynomials to rounding: their Chebyshev coefficients of the
/// order 15 are 1e-5, those of the kernel of the order 17 below 1e-14, the product of lower orders is integrated exactly.
const SLOW: f64 = 4.0;

/// Shorter steps, whose squares are near the smallest numbers, are left to the nodes [s].
const SHORTEST: f64 = 1e-100;

/// A rule that is better than needed by less than this stays, so that it is not prepared again and again on the border.
const STAY: f64 = 16.0;

/// n!/((n − 2j)! j!) by j and n.
const BENDS: [[f64; 2 * MOST_PAIRS]; MOST_PAIRS] = {
    let mut table = [[0.0; 2 * MOST_PAIRS]; MOST_PAIRS];
    let mut n = 0;
    while n < 2 * MOST_PAIRS {
        table[0][n] = 1.0;
        let mut j = 1;
        while j < MOST_PAIRS && 2 * j <= n {
            table[j][n] = table[j - 1][n] * ((n - 2 * j + 2) * (n - 2 * j + 1)) as f64 / j as f64;
            j += 1;
        }
        n += 1;
    }
    table
};

/// A rule and what it leaves, as a part of the largest |ẍ|.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    pairs: usize,
    left: f64,
}

/// Speed and acceleration of the cam that a step does not exceed.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Limits {
    /// |ω| [rad/s].
    pub speed: f64,
    /// |α| [rad/s²].
    pub acceleration: f64,
}

/// The end of a step.
pub struct Landing {
    /// φ [rad], ω [rad/s].
    pub angle: f64,
    pub speed: f64,
    /// q, q̇.
    pub state: Pair,
}

impl Limits {
    /// No step is within.
    pub const NONE: Limits = Limits { speed: -1.0, acceleration: -1.0 };

    /// Those of a step over `length` [s] from this speed [rad/s] at this acceleration [rad/s²].
    #[inline(always)]
    pub fn of(speed: f64, acceleration: f64, length: f64) -> Self {
        let [before, after] = [speed, speed + acceleration * length].map(f64::abs);
        Limits { speed: if before > after { before } else { after }, acceleration: acceleration.abs() }
    }

    /// Wider ones, which the steps that follow will keep for a while.
    pub fn widened(&self, order: f64, length: f64) -> Self {
        // Some tens of steps of this acceleration, or a quarter more of either.
        let speed = 1.25 * self.speed + 32.0 * self.acceleration * length;
        // 3 √(K α) may reach a tenth of K ω.
        let slight = order * speed * speed / 900.0;
        Limits { speed, acceleration: 1.25 * self.acceleration + slight }
    }

    /// Whether the others are within.
    #[inline(always)]
    pub fn hold(&self, other: &Limits) -> bool {
        other.speed <= self.speed && other.acceleration <= self.acceleration
    }
}

/// The lowest rule that leaves no more than `share` of the largest |ẍ| within the `limits` over `length` [s]; None where none
/// does. To change to a lower one takes more than to keep the pairs `in_use` (0: nodes).
pub fn rule(
    oscillator: &Oscillator,
    series: &Fourier,
    limits: &Limits,
    length: f64,
    share: f64,
    in_use: Option<usize>,
) -> Option<Rule> {
    let (_, fast) = oscillator.rates();
    if !(fast * length <= SLOW && SHORTEST <= length) {
        return None;
    }
    let order = series.order() as f64;
    let theta = length * (order * limits.speed + 3.0 * (order * limits.acceleration).sqrt());
    RULES.into_iter().map(|(n, factor)| Rule { pairs: n, left: factor * theta.powi(4 * n as i32 - 4) }).find(|rule| {
        let changes = in_use.is_some_and(|pairs| pairs == 0 || rule.pairs < pairs);
        rule.left <= if changes { share / STAY } else { share }
    })
}

impl Rule {
    /// What is beyond it, as a part of the largest |ẍ|.
    pub fn left(&self) -> f64 {
        self.left
    }
}

impl Leap {
    /// The weights are made for steps of this `length` [s].
    #[inline(always)]
    pub(super) fn is_for(&self, length: f64) -> bool {
        (length - self.length).abs() <= SAME_LENGTH * length
    }

    /// Whether a step over `length` [s] with this speed and acceleration is one of those that [`Leap::start`] has prepared.
    #[inline(always)]
    pub fn goes_on(&self, [w, a]: [f64; 2], length: f64) -> bool {
        self.is_for(length) && self.limits.hold(&Limits::of(w, a, length))
    }

    /// Prepares steps of this `length` [s] within the `limits` by this rule from the angle `phi` [rad] on.
    pub fn start(
        &mut self,
        oscillator: &Oscillator,
        law: &ClosedForm,
        length: f64,
        (rule, limits): (Rule, Limits),
        phi: f64,
    ) {
        self.limits = limits;
        if self.pairs != rule.pairs || !self.is_for(length) {
            self.prepare_ends(oscillator, length, rule.pairs);
            self.angle = f64::INFINITY;
        }
        // Inputs that go on from there differ by a rounding.
        if !((phi - self.angle).abs() <= 4.0 * f64::EPSILON * phi.abs()) {
            self.u = law.derivatives(phi);
            self.angle = phi;
        }
    }

    /// From `state` over `length` [s] on from the angle, speed and acceleration `motion`; what was prepared holds for it.
    #[inline(always)]
    pub fn cross(
        &mut self,
        oscillator: &Oscillator,
        law: &ClosedForm,
        motion: [f64; 3],
        length: f64,
        state: Pair,
    ) -> Landing {
        match self.pairs {
            3 => self.cross_by::<3>(oscillator, law, motion, length, state),
            4 => self.cross_by::<4>(oscillator, law, motion, length, state),
            _ => self.cross_by::<MOST_PAIRS>(oscillator, law, motion, length, state),
        }
    }

    /// U, U′ where the last step ended.
    #[inline(always)]
    pub fn u(&self) -> Pair {
        self.u[0]
    }

    #[inline(always)]
    fn cross_by<const PAIRS: usize>(
        &mut self,
        oscillator: &Oscillator,
        law: &ClosedForm,
        [phi, w, a]: [f64; 3],
        length: f64,
        state: Pair,
    ) -> Landing {
        let h = self.length;
        let speed = w + a * h;
        let end = phi + h * (w + 0.5 * a * h);
        let after: [Pair; PAIRS] = law.derivatives(end);
        let forced = self.forced(&after, Pair::new(w * h, speed * h), 0.5 * a * h * h);
        let state = self.free.at(state) + forced;
        // The clock's rounding of the step: to first order.
        let rest = length - h;
        let turned = rest * speed;
        let [q, v] = state.array();
        let [d1, d2] = [after[0].array()[1], after[1].array()[0]];
        let rate = -(d2 * speed * speed + d1 * a) - oscillator.stiffness() * q - 2.0 * oscillator.damping() * v;
        // The highest one, which has no higher one, stays.
        for i in 0..PAIRS {
            let next = if i + 1 < PAIRS { after[i + 1].array()[0] } else { 0.0 };
            self.u[i] = after[i] + Pair::both(turned) * Pair::new(after[i].array()[1], next);
        }
        self.angle = end + turned;
        Landing { angle: self.angle, speed: speed + a * rest, state: state + Pair::both(rest) * Pair::new(v, rate) }
    }

    /// Σ Wₙ yₙ with the derivatives `after` the step and those before it; `p` at the start and at the end side by side.
    #[inline(always)]
    fn forced<const PAIRS: usize>(&self, after: &[Pair; PAIRS], p: Pair, bend: f64) -> Pair {
        let mut d = [Pair::default(); 2 * MOST_PAIRS];
        for i in 0..PAIRS {
            let ([even, odd], [even_after, odd_after]) = (self.u[i].array(), after[i].array());
            (d[2 * i], d[2 * i + 1]) = (Pair::new(even, even_after), Pair::new(odd, odd_after));
        }
        let mut powers = [Pair::both(1.0); 2 * MOST_PAIRS];
        for m in 1..2 * PAIRS {
            powers[m] = powers[m - 1] * p;
        }
        // n! yₙ.
        let mut y = [Pair::default(); 2 * MOST_PAIRS];
        for n in 2..2 * PAIRS {
            y[n] = d[n] * powers[n];
        }
        if bend != 0.0 {
            let mut factor = 1.0;
            for j in 1..PAIRS {
                factor *= bend;
                for n in 2 * j..2 * PAIRS {
                    y[n] = y[n] + Pair::both(factor * BENDS[j][n]) * (d[n - j] * powers[n - 2 * j]);
                }
            }
        }
        // As the weights lie: what the start adds to q beside what the end adds to q̇, and the other two.
        let (mut straight, mut crossed) = (Pair::default(), Pair::default());
        for n in 2..2 * PAIRS {
            straight = straight + self.weights[2 * n - 4] * y[n];
            crossed = crossed + self.weights[2 * n - 3] * y[n].swapped();
        }
        straight + crossed
    }

    /// The weights Wₙ/n!: that of q at the start beside that of q̇ at the end, then the other two.
    #[cold]
    fn prepare_ends(&mut self, oscillator: &Oscillator, length: f64, pairs: usize) {
        self.keep(oscillator, length);
        (self.pairs, self.nodes, self.evaluations) = (pairs, 0, pairs as u64);
        self.weights = Default::default();
        let m = 2 * pairs - 3;
        let rule: [[f64; 2]; MOST_NODES] = Gauss::with(MOST_NODES).nodes(length);
        for [place, weight] in rule {
            let sigma = place / length;
            let mut factorial = 1.0;
            let kernel: Pair = oscillator.kernel(length - place).map(|g| -(weight / length) * (g / length)).into();
            for j in 0..=m {
                let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
                let ends = Pair::new(basis(j, m, sigma), sign * basis(j, m, 1.0 - sigma));
                // (j + 2) (j + 1)/(j + 2)! = 1/j!.
                let ends = ends * Pair::both(1.0 / factorial);
                factorial *= (j + 1) as f64;
                self.weights[2 * j] = self.weights[2 * j] + kernel * ends;
                self.weights[2 * j + 1] = self.weights[2 * j + 1] + kernel * ends.swapped();
            }
        }
    }
}

/// Hermite's basis polynomial of degree 2m + 1 at `sigma`: its Taylor coefficients up to σᵐ are 0 at 1, and at 0 as well, that of
/// σʲ excepted, which is 1: σʲ (1 − σ)ᵐ⁺¹ Σᵢ (m + i over i) σⁱ, i ≤ m − j.
fn basis(j: usize, m: usize, sigma: f64) -> f64 {
    let (mut sum, mut term) = (0.0, 1.0);
    for i in 0..=m - j {
        sum += term;
        term *= sigma * (m + i + 1) as f64 / (i + 1) as f64;
    }
    sigma.powi(j as i32) * (1.0 - sigma).powi(m as i32 + 1) * sum
}
