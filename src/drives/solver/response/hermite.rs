//! One communication step of a Fourier law on inputs φ, ω, α by one quadrature: the right side f, a sum of x, ẋ and ẍ with constant
//! factors, interpolated by the polynomial of degree 2M + 1 = 11 with its value and first M derivatives at both ends.
//!
//! With σ = (t − t₀)/h the cam turns from an end by p σ + β σ², p = ω h there and β = ½ α h², and x has the Taylor
//! coefficients
//!
//! yₙ = Σⱼ Dₙ₋ⱼ pⁿ⁻²ʲ/(n − 2j)! βʲ/j!, Dₙ = U⁽ⁿ⁾ at that end;
//!
//! q(h) = free motion + ∫ g(h − s) f(s) ds = free motion + Σ Wₙ yₙ over both ends and n = 2 … M + 2, from 0 on with x and ẋ,
//!
//! where the Wₙ, integrals of the impulse response g times Hermite's basis polynomials, are the same for all steps of this length,
//! and the Dₙ at the start are those at the end of the previous step: a step evaluates the law once.
//!
//! The error is known in advance: |f|⁽ⁿ⁾ ≤ νⁿ max |f| for n ≤ 16 with ν = K|ω| + 3 √(K|α|), so that f errs by (νh)²ᴹ⁺²/(2M + 2)!
//! (σ(1 − σ))ᴹ⁺¹ of its bound, and its integral by (νh)²ᴹ⁺² (M + 1)!²/((2M + 2)! (2M + 3)!).
//!
//! Source: J. Stoer, R. Bulirsch, *Introduction to Numerical Analysis*, section 2.1.5 (interpolation after Hermite and its
//! remainder).

use crate::drives::follower::elastic_output::Equation;
use crate::drives::shaft::cam_drive::AngleMotion;
use crate::drives::shaft::instant::Instant;
use crate::motion::Fourier;
use crate::motion::derivatives::lift;
use crate::numerics::double_double::Double;
use crate::numerics::forced::apply;
use crate::numerics::gauss::Gauss;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::pair::Pair;
use serde::{Deserialize, Serialize};

/// The derivatives of the law come in pairs of an even and an odd order: M + 3 = 2 · pairs.
const PAIRS: usize = 4;
const ORDERS: usize = 2 * PAIRS;
const M: usize = ORDERS - 3;

/// (M + 1)!²/((2M + 2)! (2M + 3)!).
const FACTOR: f64 = 1.0 / 5753767219200.0;

/// Up to this |λ|h 16 nodes integrate the kernel times the basis polynomials to rounding: their Chebyshev coefficients of order 11
/// are 1e-4, the kernel's of order 21 below 1e-16, and products of lower orders are exact.
const SLOW: f64 = 4.0;

/// Shorter steps (s) do not count: their squares are near the smallest numbers.
const SHORTEST: f64 = 1e-100;

/// Lengths with a smaller relative difference count as the same one; the difference, a rounding of the clock, is taken into account
/// to first order.
const SAME_LENGTH: f64 = 1e-9;

/// n!/((n − 2j)! j!) by j and n.
const BENDS: [[f64; ORDERS]; PAIRS] = {
    let mut table = [[1.0; ORDERS]; PAIRS];
    let mut j = 1;
    while j < PAIRS {
        let mut n = 2 * j;
        while n < ORDERS {
            table[j][n] = table[j - 1][n] * ((n - 2 * j + 2) * (n - 2 * j + 1)) as f64 / j as f64;
            n += 1;
        }
        j += 1;
    }
    table
};

/// Properties of the oscillator for steps of one length, and the end of the last step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hermite {
    /// h (s); 0 while unknown.
    length: f64,
    /// Wₙ/n!: for q at the start beside q̇ at the end, then the other two.
    weights: [[Pair; 2]; ORDERS],
    /// The free motion over the step.
    free: [[f64; 2]; 2],
    /// The decay of the slower mode over the step.
    pub decay: f64,
    /// U, U′ … at the last position of the cam, and its angle there (rad); infinite while unknown.
    u: [Pair; PAIRS],
    angle: f64,
}

/// Error of a step over `length` (s) relative to the largest |f|, for a law of this order and a cam below this speed (rad/s) and
/// acceleration (rad/s²); infinite if the quadrature is not accurate enough.
pub fn left(oscillator: &Oscillator, order: f64, [speed, acceleration]: [f64; 2], length: f64) -> f64 {
    let (_, fast) = oscillator.rates();
    if !(fast * length <= SLOW && SHORTEST <= length) {
        return f64::INFINITY;
    }
    let theta = length * (order * speed + 3.0 * (order * acceleration).sqrt());
    FACTOR * theta.powi(2 * M as i32 + 2)
}

impl Hermite {
    /// Starts without any known step.
    pub fn new() -> Self {
        let (weights, u) = Default::default();
        Hermite { length: 0.0, weights, free: [[0.0; 2]; 2], decay: 1.0, u, angle: f64::INFINITY }
    }

    /// Brings cam and mass from `now` to `time` (s) on the `motion` from there, which has a constant acceleration.
    pub fn over(&mut self, equation: &Equation, series: &Fourier, motion: &AngleMotion, time: f64, now: &mut Instant) {
        let ([phi, w, a, ..], length) = (motion.coefficients, time - motion.origin);
        if !((length - self.length).abs() <= SAME_LENGTH * length) {
            self.prepare(equation, length);
        }
        // Inputs that go on from there differ by a rounding.
        if !((phi - self.angle).abs() <= 4.0 * f64::EPSILON * phi.abs()) {
            self.u = series.derivatives(phi);
        }
        let h = self.length;
        let (speed, end) = (w + a * h, phi + h * (w + 0.5 * a * h));
        let after: [Pair; PAIRS] = series.derivatives(end);
        let (p, bend) = (Pair::new(w * h, speed * h), 0.5 * a * h * h);
        let forced = if equation.weights.is_none() {
            self.forced::<2>(&after, p, bend)
        } else {
            self.forced_under(&after, p, bend)
        };
        let state = Pair(apply(&self.free, now.q.array())) + forced;
        // The clock's rounding of the step: to first order.
        let rest = length - h;
        let turned = rest * speed;
        let ([q, v], [d0, d1], [d2, _]) = (state.array(), after[0].array(), after[1].array());
        let rate = equation.acceleration([q, v], lift([d0, d1, d2], [speed, a]));
        // The highest one, which has no successor, stays.
        for i in 0..PAIRS {
            let next = after.get(i + 1).map_or(0.0, |pair| pair.array()[0]);
            self.u[i] = after[i] + Pair::both(turned) * Pair::new(after[i].array()[1], next);
        }
        self.angle = end + turned;
        let [phi, w, a, ..] = motion.kinematics(time);
        (now.time, now.shaft, now.u, now.curvature) = (time, [phi, w, a], self.u[0], self.u[1].array()[0]);
        now.q = state + Pair::both(rest) * Pair::new(v, rate);
    }

    /// Σ Wₙ yₙ from n = `FIRST` on with the derivatives `after` the step and those before it; `p` is paired, at the start and at
    /// the end.
    #[inline(always)]
    fn forced<const FIRST: usize>(&self, after: &[Pair; PAIRS], p: Pair, bend: f64) -> Pair {
        let mut d = [Pair::default(); ORDERS];
        for i in 0..PAIRS {
            let ([even, odd], [even_after, odd_after]) = (self.u[i].array(), after[i].array());
            (d[2 * i], d[2 * i + 1]) = (Pair::new(even, even_after), Pair::new(odd, odd_after));
        }
        let (mut powers, mut bends) = ([Pair::both(1.0); ORDERS], [1.0; PAIRS]);
        for m in 1..ORDERS {
            powers[m] = powers[m - 1] * p;
        }
        for j in 1..PAIRS {
            bends[j] = bends[j - 1] * bend;
        }
        // The effect of the start on q paired with the effect of the end on q̇, and the other two.
        let (mut straight, mut crossed) = (Pair::default(), Pair::default());
        for n in FIRST..ORDERS {
            // n! yₙ.
            let mut y = d[n] * powers[n];
            for j in 1..n / 2 + 1 {
                y = y + Pair::both(bends[j] * BENDS[j][n]) * (d[n - j] * powers[n - 2 * j]);
            }
            straight = straight + self.weights[n][0] * y;
            crossed = crossed + self.weights[n][1] * y.swapped();
        }
        straight + crossed
    }

    #[inline(never)]
    fn forced_under(&self, after: &[Pair; PAIRS], p: Pair, bend: f64) -> Pair {
        self.forced::<0>(after, p, bend)
    }

    #[cold]
    fn prepare(&mut self, equation: &Equation, length: f64) {
        let oscillator = &equation.oscillator;
        self.length = length;
        self.free = oscillator.free(Double::from(length));
        self.decay = (-oscillator.decay() * length).exp();
        self.weights = Default::default();
        for [place, weight] in Gauss::with(16).nodes::<16>(length) {
            let sigma = place / length;
            let mut factorial = 1.0;
            // For x, ẋ and ẍ: a derivative by time is one by σ over h.
            let (kernel, part) = (oscillator.kernel(length - place), weight / length);
            let kernels = [
                |g: f64, part: f64, length: f64| [part * length * g, 0.0, 0.0],
                |g: f64, part: f64, _: f64| [0.0, part * g, 0.0],
                |g: f64, part: f64, length: f64| [0.0, 0.0, part * (g / length)],
            ]
            .map(|of| Pair::from(kernel.map(|g| equation.forcing(of(g, part, length)))));
            for j in 0..=M {
                let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
                // (j + n) … (j + 1)/(j + n)! = 1/j!.
                let ends = Pair::new(basis(j, sigma), sign * basis(j, 1.0 - sigma)) * Pair::both(1.0 / factorial);
                factorial *= (j + 1) as f64;
                for (weights, kernel) in self.weights[j..].iter_mut().zip(kernels) {
                    weights[0] = weights[0] + kernel * ends;
                    weights[1] = weights[1] + kernel * ends.swapped();
                }
            }
        }
    }
}

/// Hermite's basis polynomial of degree 2M + 1 at `sigma`. Its Taylor coefficients up to σᴹ are 0 at 1 and at 0, except that of σʲ
/// at 0, which is 1: σʲ (1 − σ)ᴹ⁺¹ Σᵢ (M + i over i) σⁱ, i ≤ M − j.
fn basis(j: usize, sigma: f64) -> f64 {
    let (mut sum, mut term) = (0.0, 1.0);
    for i in 0..=M - j {
        sum += term;
        term *= sigma * (M + i + 1) as f64 / (i + 1) as f64;
    }
    sigma.powi(j as i32) * (1.0 - sigma).powi(M as i32 + 1) * sum
}
