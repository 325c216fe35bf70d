//! One cell in which the free motion vibrates so often that the coefficients change little over a vibration.
//!
//! With t = t_mid + H x, primes for d/dx, D = H d, K = H² k and G = H² g, all motions of the cell are
//!
//! q = s + A (a cos Θ + b sin Θ),  A = exp(−E) √(Θ′(−1)/Θ′),  E = ½ ∫₋₁^x D,
//!
//! s″ + D s′ + K s = G,  Θ′² = Q − ½ p″ + ¼ p′²,  p = ln Θ′,  Q = K − ¼ D² − ½ D′.
//!
//! s is the forced motion that does not vibrate, Θ the phase of the free one (Kummer's equation, whose first approximation is
//! Liouville's and Green's, Θ′ = √Q). Both change as slowly as the coefficients do, so that polynomials through the Gauss nodes
//! hold them whatever the number of vibrations: a stiffer drive needs no more cells. The Wronskian of the free motions satisfies
//! the equation's exp(−∫D) to the last digit.
//!
//! Validity: Q is positive and large in the whole cell.
//!
//! Source: F. W. J. Olver, *Asymptotics and Special Functions*, Academic Press 1974, chapter 6, section 1.

use super::nodes::{ABSCISSAE, DERIVATIVE, LEGENDRE_FROM_START, PROJECTION, STAGES, integrate};
use super::{Affine, Coefficients, Periodic};
use crate::numerics::double_double::Double;
use crate::numerics::interpolant::neglected;
use crate::numerics::lu::Lu;

/// The fewest radians of the free motion in half a cell: below that a dozen cells of polynomials take less room.
pub const FEWEST: f64 = 50.0;

/// With fewer radians no cell is made: the corrections to √Q shrink from one iteration to the next by the square of this over the
/// square of the degree.
const LEAST: f64 = 20.0;

/// Iterations for Θ′; from the bound on Q each gains two digits or more.
const ITERATIONS: usize = 8;

/// Error that polynomials may leave in a radian of the phase, unless its roundings are more, and in the motion. Unlike in an
/// ordinary cell the ends have no better order, so this error carries over the periods as it is. Smooth coefficients reach it with
/// hardly more cells.
const TOLERANCE: f64 = 1e-13;

/// The slope of the first neglected polynomial of Legendre at the ends, n (n + 1)/2.
const STEEPEST: f64 = 0.5 * (STAGES * (STAGES + 1)) as f64;

/// Tolerance of s and its slope, in which eight roundings of s add up.
const SLOW_TOLERANCE: f64 = 8.0 * STEEPEST * f64::EPSILON;

/// Roundings at the nodes when extrapolated to the ends of the cell, in ε.
const EXTRAPOLATED: f64 = 4.0;

/// The motions of a cell, as coefficients of powers of u = 1 + x: the phase after a few vibrations is as exact as a few vibrations
/// permit, however many the cell has.
#[derive(Clone, Debug, PartialEq)]
pub struct Vibration {
    /// s.
    slow: [f64; STAGES + 1],
    /// E.
    decay: [f64; STAGES + 1],
    /// Θ.
    phase: [f64; STAGES + 1],
    /// The parts at the start of the cell.
    initial: Place,
}

/// Parts of the motions at a place of the cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Place {
    /// s and s′.
    slow: [f64; 2],
    /// E.
    decay: f64,
    /// Θ and Θ′.
    phase: [f64; 2],
    /// A′/A.
    growth: f64,
}

/// Errors of the polynomials of a cell.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// Error over the admissible error.
    pub excess: f64,
    /// Error by unresolved coefficients, relative to the motion.
    pub polynomials: f64,
    /// Error by the roundings of the phase (rad).
    pub rounding: f64,
}

impl Vibration {
    /// The motions of the cell from `start` over `length` (s); None if the free motion does not vibrate fast enough all along, or
    /// if a coefficient is not finite.
    pub fn solve(equation: &dyn Periodic, interval: usize, start: Double, length: f64) -> Option<(Vibration, Errors)> {
        let half = 0.5 * length;
        let (mut damping, mut stiffness, mut forcing) = ([0.0; STAGES], [0.0; STAGES], [0.0; STAGES]);
        for i in 0..STAGES {
            let c = equation.at(start + Double::from(half * (1.0 + ABSCISSAE[i])), interval);
            let Coefficients { damping: d, stiffness: k, forcing: g } = c;
            (damping[i], stiffness[i], forcing[i]) = (half * d, half * half * k, half * half * g);
        }
        let ends = [0.0, 2.0].map(|u| equation.at(start + Double::from(half * u), interval));
        let (slope, left) = phase_velocity(&damping, &stiffness)?;
        let slow = unvibrating(&damping, &stiffness, forcing)?;
        let damping_modes = project(&damping.map(|d| 0.5 * d));
        let (slope_modes, slow_modes) = (project(&slope), project(&slow));
        let mut vibration = Vibration {
            slow: powers(&pad(&slow_modes)),
            decay: powers(&integrate(&damping_modes, 0.0, 1.0)),
            phase: powers(&integrate(&slope_modes, 0.0, 1.0)),
            initial: Place::default(),
        };
        // The integrals begin with 0 except for rounding.
        (vibration.decay[0], vibration.phase[0]) = (0.0, 0.0);
        vibration.initial = vibration.place(0.0);
        let size = slow.iter().fold(0.0, |largest: f64, s| largest.max(s.abs()));
        let n = STAGES as f64;
        let of_slow = if size > 0.0 { STEEPEST * neglected(&slow_modes) / size } else { 0.0 };
        // The integral of the polynomial of Legendre is 2 n + 1 times smaller.
        let of_phase = 2.0 * left + missed_at_ends(&ends, half, &damping, &slope) / (2.0 * n + 1.0);
        let phase = vibration.place(2.0).phase[0];
        let rounding = f64::EPSILON * phase;
        let excess = f64::max(of_slow / SLOW_TOLERANCE, of_phase / rounding.max(TOLERANCE));
        let polynomials = of_slow + of_phase;
        let errors = Errors { excess, polynomials, rounding };
        (polynomials.is_finite() && phase.is_finite()).then_some((vibration, errors))
    }

    /// ∫d over the cell.
    pub fn damping(&self) -> f64 {
        2.0 * self.place(2.0).decay
    }

    /// From the start of a cell of this half length (s) to its end.
    pub fn map(&self, half: f64) -> Affine {
        let to = self.place(2.0);
        let [[a, c], [b, d]] = [[1.0, 0.0], [0.0, half]].map(|y| self.free(&to, y));
        let matrix = [[a, b], [c / half, d / half]];
        Affine { matrix, shift: self.at(half, 2.0, [0.0, 0.0]) }
    }

    /// (q, q̇) at the place u of a cell of this half length (s), for the motion from `y` at its start.
    pub fn at(&self, half: f64, u: f64, y: [f64; 2]) -> [f64; 2] {
        let (from, to) = (&self.initial, self.place(u));
        let [q, slope] = self.free(&to, [y[0] - from.slow[0], half * y[1] - from.slow[1]]);
        [to.slow[0] + q, (to.slow[1] + slope) / half]
    }

    /// The free motion and its slope at a place, from its values at the start.
    fn free(&self, to: &Place, [q, slope]: [f64; 2]) -> [f64; 2] {
        let from = &self.initial;
        let (a, b) = (q, (slope - from.growth * q) / from.phase[1]);
        let (sine, cosine) = to.phase[0].sin_cos();
        let amplitude = (from.decay - to.decay).exp() * (from.phase[1] / to.phase[1]).sqrt();
        let (q, turned) = (amplitude * (a * cosine + b * sine), amplitude * (b * cosine - a * sine));
        [q, to.growth * q + to.phase[1] * turned]
    }

    fn place(&self, u: f64) -> Place {
        let [phase, velocity, acceleration] = with_slopes(&self.phase, u);
        let [decay, damping, _] = with_slopes(&self.decay, u);
        let [slow, slope, _] = with_slopes(&self.slow, u);
        let growth = -damping - 0.5 * acceleration / velocity;
        Place { slow: [slow, slope], decay, phase: [phase, velocity], growth }
    }
}

/// Θ′ at the nodes, and by how much the last iteration changed the phase (rad); None if the vibration is not fast.
fn phase_velocity(damping: &[f64; STAGES], stiffness: &[f64; STAGES]) -> Option<([f64; STAGES], f64)> {
    let jerk = differentiate(damping);
    let square: [f64; STAGES] = std::array::from_fn(|i| stiffness[i] - 0.25 * damping[i] * damping[i] - 0.5 * jerk[i]);
    let fast = |square: &[f64; STAGES]| square.iter().all(|q| *q >= LEAST * LEAST && q.is_finite());
    if !fast(&square) {
        return None;
    }
    let mut velocity = square.map(f64::sqrt);
    let mut change = f64::INFINITY;
    for _ in 0..ITERATIONS {
        let slope = differentiate(&velocity.map(f64::ln));
        let curvature = differentiate(&slope);
        let next: [f64; STAGES] = std::array::from_fn(|i| square[i] - 0.5 * curvature[i] + 0.25 * slope[i] * slope[i]);
        if !fast(&next) {
            return None;
        }
        let next = next.map(f64::sqrt);
        let before = change;
        change = (0..STAGES).map(|i| (next[i] - velocity[i]).abs()).fold(0.0, f64::max);
        velocity = next;
        // Beyond this only roundings change it.
        if !(change < 0.5 * before) {
            break;
        }
    }
    let largest = velocity.iter().fold(0.0, |largest: f64, v| largest.max(*v));
    Some((velocity, (change - 4.0 * f64::EPSILON * largest).max(0.0)))
}

/// Errors of the polynomials of Θ′ and ½ D at the ends of the cell, where the first neglected Legendre polynomials are ±1.
fn missed_at_ends(ends: &[Coefficients; 2], half: f64, damping: &[f64; STAGES], velocity: &[f64; STAGES]) -> f64 {
    let jerk = differentiate(damping);
    let slope = differentiate(&velocity.map(f64::ln));
    let curvature = differentiate(&slope);
    let missed = |(side, c): (f64, &Coefficients)| {
        // The sum of Legendre coefficients has a dozen roundings of its own, so it is taken of the differences to the nearest node.
        let end = |values: &[f64; STAGES]| {
            let nearest = values[if side < 0.0 { 0 } else { STAGES - 1 }];
            let differences = project(&values.map(|value| value - nearest));
            nearest + differences.iter().rev().fold(0.0, |sum, mode| sum * side + mode)
        };
        let (d, k) = (half * c.damping, half * half * c.stiffness);
        let square = k - 0.25 * d * d - 0.5 * (end(&jerk) + end(&curvature)) + 0.25 * end(&slope).powi(2);
        let [found, wanted] = [end(velocity), square.max(0.0).sqrt()];
        let missed = (wanted - found).abs() + 0.5 * (d - end(damping)).abs();
        (missed - EXTRAPOLATED * f64::EPSILON * (wanted + d.abs())).max(0.0)
    };
    [-1.0, 1.0].into_iter().zip(ends).map(missed).sum()
}

/// s at the nodes.
fn unvibrating(damping: &[f64; STAGES], stiffness: &[f64; STAGES], forcing: [f64; STAGES]) -> Option<[f64; STAGES]> {
    // Divided by K each row has the size 1 on its diagonal.
    let matrix: [[f64; STAGES]; STAGES] = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let second: f64 = (0..STAGES).map(|k| DERIVATIVE[i][k] * DERIVATIVE[k][j]).sum();
            let unit = if i == j { 1.0 } else { 0.0 };
            unit + (second + damping[i] * DERIVATIVE[i][j]) / stiffness[i]
        })
    });
    let mut s: [f64; STAGES] = std::array::from_fn(|i| forcing[i] / stiffness[i]);
    Lu::new(matrix, STAGES)?.solve(&mut s);
    Some(s)
}

fn differentiate(values: &[f64; STAGES]) -> [f64; STAGES] {
    std::array::from_fn(|i| (0..STAGES).map(|j| DERIVATIVE[i][j] * values[j]).sum())
}

/// The Legendre coefficients of the polynomial through the values at the nodes.
// Out of line: a dozen sums of a dozen products each, nine times.
#[inline(never)]
fn project(values: &[f64; STAGES]) -> [f64; STAGES] {
    std::array::from_fn(|k| (0..STAGES).map(|j| PROJECTION[k][j] * values[j]).sum())
}

fn pad(modes: &[f64; STAGES]) -> [f64; STAGES + 1] {
    std::array::from_fn(|k| if k < STAGES { modes[k] } else { 0.0 })
}

/// The coefficients in powers of u of a polynomial with these Legendre coefficients.
fn powers(modes: &[f64; STAGES + 1]) -> [f64; STAGES + 1] {
    std::array::from_fn(|j| (j..=STAGES).map(|k| modes[k] * LEGENDRE_FROM_START[k][j]).sum())
}

/// The value and the first two derivatives of a polynomial.
fn with_slopes(c: &[f64; STAGES + 1], u: f64) -> [f64; 3] {
    let [mut value, mut first, mut second] = [0.0; 3];
    for c in c.iter().rev() {
        second = second * u + 2.0 * first;
        first = first * u + value;
        value = value * u + c;
    }
    [value, first, second]
}
