//! The same step from one place of the cam: the Taylor series of the law about the end of the step.
//!
//! With σ = (t − t_end)/h in [−1, 0] the cam turns by δ = ω h σ + ½ α h² σ², and x = Σ Dₙ δⁿ/n! with Dₙ = U⁽ⁿ⁾ at the end.
//! Multiplied out in powers of σ,
//!
//! ∫ g(h − s) (−ẍ(s)) ds = Σᵢ (½ α h²)ⁱ/i! Σₙ Dₙ (ω h)ⁿ⁻ⁱ/(n − i)! Wₙ₊ᵢ, Wⱼ = −j (j − 1)/h² ∫ g(h − s) σʲ⁻² ds,
//!
//! where the Wⱼ are those of all steps of this length. What is left out is known before anything is computed: with θ a
//! bound of Kδ, what remains of the series of U″ in δ after the order n is below θⁿ⁻¹/(n − 1)! of its bound, and its
//! integral by another n smaller.

use super::{Landing, Leap, MOST_NODES, SAME_LENGTH};
use crate::motion::Fourier;
use crate::numerics::forced::apply;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::phase::sin_cos;
use crate::numerics::quadrature::Gauss;

/// The orders of the series come in pairs of an even and an odd one. Three of them hold U … U⁗ at the end; with seven the
/// weights take the memory of those of sixteen nodes.
const FEWEST_PAIRS: usize = 3;
const MOST_PAIRS: usize = 7;

/// The highest power of the acceleration.
const MOST_BENDS: usize = 4;

/// How many Wⱼ there are, from j = 2 on.
pub(super) const MOMENTS: usize = 2 * MOST_PAIRS - 1 + MOST_BENDS - 1;

/// The number of nodes that says that the weights are the Wⱼ.
const SERIES: usize = 0;

/// Up to this |λ|h 16 nodes integrate the kernel times σʲ⁻² to rounding for the low j, and to 1e-12 for the highest,
/// whose share is as small: the rule is exact for the first 31 − (j − 2) powers of the kernel's series about the middle.
const SLOW: f64 = 4.0;

/// Shorter steps, whose squares are near the smallest numbers, are left to the nodes [s].
const SHORTEST: f64 = 1e-100;

/// 1/m, up to the order beyond the last pair.
const RECIPROCALS: [f64; 2 * MOST_PAIRS + 2] = {
    let mut table = [1.0; 2 * MOST_PAIRS + 2];
    let mut m = 1;
    while m < table.len() {
        table[m] = 1.0 / m as f64;
        m += 1;
    }
    table
};

/// A step of the cam with its speed and acceleration, all in angles.
struct Turn {
    /// φ at the end [rad].
    end: f64,
    /// ω h at the end and ½ α h² [rad].
    way: f64,
    bend: f64,
    /// The highest power of `bend`.
    bends: usize,
}

/// How far the series go, and what is beyond, as a part of the largest |ẍ|.
#[derive(Clone, Copy, Debug)]
pub struct Orders {
    pairs: usize,
    bends: usize,
    left: f64,
}

/// The orders that leave no more than `share` of the largest |ẍ| from the angle, speed and (constant) acceleration `start`
/// over `length` [s]; one pair less than possible is asked for where nodes are in use. None where no order does.
pub fn orders(
    oscillator: &Oscillator,
    series: &Fourier,
    [_, w, a]: [f64; 3],
    length: f64,
    share: f64,
    by_nodes: bool,
) -> Option<Orders> {
    let (_, fast) = oscillator.rates();
    if !(fast * length <= SLOW && SHORTEST <= length) {
        return None;
    }
    let order = series.order() as f64;
    let theta = [order * (w + a * length).abs() * length, 0.5 * order * a.abs() * length * length];
    let most = if by_nodes { MOST_PAIRS - 1 } else { MOST_PAIRS };
    let (pairs, left) = pairs(theta[0] + theta[1], share, most)?;
    let (bends, bent) = bends(theta, share)?;
    Some(Orders { pairs, bends, left: left + bent })
}

impl Leap {
    /// Whether the step is prepared for nodes.
    pub fn has_nodes(&self) -> bool {
        self.nodes != SERIES
    }

    /// From `state` over `length` [s] from the angle, speed and (constant) acceleration at the start, by so many
    /// [`orders`]; also U … U⁗ at the end.
    pub fn expand(
        &mut self,
        oscillator: &Oscillator,
        series: &Fourier,
        bounds: [f64; 2],
        [phi, w, a]: [f64; 3],
        length: f64,
        state: [f64; 2],
        Orders { pairs, bends, left }: Orders,
    ) -> (Landing, [f64; 5]) {
        let (_, fast) = oscillator.rates();
        if self.nodes != SERIES || !((length - self.length).abs() <= SAME_LENGTH * length) {
            self.prepare_expansion(oscillator, length);
        }
        let h = self.length;
        let speed = w + a * h;
        let turn = Turn { end: phi + h * (w + 0.5 * a * h), way: speed * h, bend: 0.5 * a * h * h, bends };
        let (d, forced) = match pairs {
            3 => self.series::<3>(series, &turn),
            4 => self.series::<4>(series, &turn),
            5 => self.series::<5>(series, &turn),
            6 => self.series::<6>(series, &turn),
            _ => self.series::<MOST_PAIRS>(series, &turn),
        };
        let [q, v] = apply(&self.free, state);
        let (q, v) = (q + forced[0], v + forced[1]);
        // The clock's rounding of the step: to first order, as for the nodes.
        let rest = length - h;
        let turned = speed * rest;
        let rate = -(d[2] * speed * speed + d[1] * a) - oscillator.stiffness() * q - 2.0 * oscillator.damping() * v;
        let fastest = w.abs().max(speed.abs());
        let scale = bounds[1] * fastest * fastest + bounds[0] * a.abs();
        let error = left * length * scale;
        let landing = Landing {
            state: [q + rest * v, v + rest * rate],
            error: [error * length.min(1.0 / fast), error],
            forcing: scale,
            // A pair of orders costs what U′ and U″ at a node cost.
            evaluations: pairs,
        };
        (landing, std::array::from_fn(|n| d[n] + turned * d[n + 1]))
    }

    /// The weights Wⱼ of q and of q̇.
    #[cold]
    fn prepare_expansion(&mut self, oscillator: &Oscillator, length: f64) {
        self.keep(oscillator, length, SERIES);
        self.weights = [[0.0; 2]; MOMENTS];
        let rule: [[f64; 2]; MOST_NODES] = Gauss::with(MOST_NODES).nodes(length);
        for [place, weight] in rule {
            let sigma = place / length - 1.0;
            let mut kernel = oscillator.kernel(length - place).map(|g| -(weight / length) * (g / length));
            for (j, moments) in (2..).zip(&mut self.weights) {
                for i in 0..2 {
                    moments[i] += (j * (j - 1)) as f64 * kernel[i];
                    kernel[i] *= sigma;
                }
            }
        }
    }

    /// U … U⁽²ᴾ⁻¹⁾ at the end, and the forced motion.
    fn series<const PAIRS: usize>(&self, series: &Fourier, turn: &Turn) -> ([f64; 6], [f64; 2]) {
        let derivatives = self.derivatives::<PAIRS>(series, turn.end);
        let d = derivatives.as_flattened();
        // (ω h)ᵐ/m!.
        let mut powers = [1.0; 2 * MOST_PAIRS];
        for m in 1..2 * PAIRS {
            powers[m] = powers[m - 1] * (turn.way * RECIPROCALS[m]);
        }
        let mut sum = forced_by(&d[2..], &powers[2..], &self.weights);
        let mut factor = 1.0;
        for i in 1..=turn.bends {
            factor *= turn.bend * RECIPROCALS[i];
            let part = forced_by(&d[i..], &powers, &self.weights[2 * i - 2..]);
            sum = [sum[0] + factor * part[0], sum[1] + factor * part[1]];
        }
        (std::array::from_fn(|n| d[n]), sum)
    }

    /// U … U⁽²ᴾ⁻¹⁾ at the angle `phi`.
    #[inline(always)]
    fn derivatives<const PAIRS: usize>(&self, series: &Fourier, phi: f64) -> [[f64; 2]; PAIRS] {
        let mut d = [[0.0; 2]; PAIRS];
        d[0][0] = series.a[0];
        if self.first == 0 {
            return d;
        }
        let [s, c] = sin_cos(phi);
        let (mut z, mut turn) = ([c, s], [c, s]);
        for _ in 1..self.first {
            z = product(z, [c, s]);
        }
        for _ in 1..self.stride {
            turn = product(turn, [c, s]);
        }
        let coefficients = series.a.iter().zip(&series.b).enumerate();
        for (k, (a, b)) in coefficients.skip(self.first).step_by(self.stride) {
            let k = k as f64;
            let mut term = [a * z[0] + b * z[1], k * (b * z[0] - a * z[1])];
            let square = -k * k;
            for pair in &mut d {
                for i in 0..2 {
                    pair[i] += term[i];
                    term[i] *= square;
                }
            }
            z = product(z, turn);
        }
        d
    }
}

/// Σ Dₙ pₙ Wₙ.
#[inline(always)]
fn forced_by(d: &[f64], powers: &[f64], weights: &[[f64; 2]]) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for ((d, power), weight) in d.iter().zip(powers).zip(weights) {
        let x = d * power;
        for i in 0..2 {
            sum[i] += x * weight[i];
        }
    }
    sum
}

/// How many pairs of orders leave no more than `share`, and what they leave; None if more than `most`.
#[inline(always)]
fn pairs(theta: f64, share: f64, most: usize) -> Option<(usize, f64)> {
    let square = theta * theta;
    // θⁿ⁻¹/n! for n = 2 · pairs − 1.
    let mut left = square * square / 120.0;
    for pairs in FEWEST_PAIRS..=most {
        if left <= share {
            return Some((pairs, left));
        }
        left *= square * (RECIPROCALS[2 * pairs] * RECIPROCALS[2 * pairs + 1]);
    }
    None
}

/// The highest power of the acceleration that is needed, and a bound on what the others do.
///
/// Kⁿ⁻² |U″| bounds Dₙ, so that the terms with θ₂ⁱ are below 4i²/i! eᶿ¹ θ₂ⁱ (|U″|/K²)/h², where the bound of |ẍ| to which they
/// compare is above (θ₁² + 2θ₂) (|U″|/K²)/h²; 4i² e/i! ≤ 23.
#[inline(always)]
fn bends([turn, bend]: [f64; 2], share: f64) -> Option<(usize, f64)> {
    if bend == 0.0 {
        return Some((0, 0.0));
    }
    let mut beyond = 23.0 * bend / (turn * turn + 2.0 * bend);
    for bends in 0..=MOST_BENDS {
        if beyond <= share {
            return Some((bends, beyond));
        }
        beyond *= bend;
    }
    None
}

/// The product of two complex numbers.
#[inline(always)]
fn product([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}
