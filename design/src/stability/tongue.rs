//! The instabilities of the orders j: exact boundaries and critical damping.
//!
//! At a boundary a Floquet multiplier is s = ±1, so E = M − s, M(λ, d) the monodromy matrix, is singular. With det E = 1 − s tr
//! M + det M the two sides of the infinite Hill determinant are the same: this is Hill's eigenproblem without any truncation.
//! Hill's truncated matrices ([`super::hill`]) number the boundaries and give the start.
//!
//! Inside an instability one multiplier is beyond s and det E < 0; outside det E > 0, since det M ≤ 1 keeps both
//! multipliers from being there. Along any line through an instability the boundary is the zero of det E.

use super::LOST;
use super::hill::{Boundaries, Pair};
use super::system::{Matrix, System};
use crate::search;
use serde::Serialize;

/// An instability without damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tongue {
    /// The number of zeros of its motions in a period.
    pub n: usize,
    /// The order j = n p/2: the number of vibrations in a turn, with p periods in a turn.
    pub j: f64,
    /// The exact boundaries in λ.
    pub lambda: Pair,
    /// The largest residual |det E| at the boundaries, relative to the entries of M.
    pub residual: f64,
}

/// The speeds of an instability without damping.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Extent {
    /// The speeds between two boundaries.
    Bounded,
    /// None: its boundaries coincide; two motions of this period coexist there.
    Closed,
    /// All speeds above a boundary.
    Open,
    /// None: at infinite speed the free motion still vibrates faster.
    Absent,
}

/// The damping at which an instability vanishes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Apex {
    /// θ*.
    pub theta: f64,
    /// η there.
    pub eta: f64,
    /// |det E| there.
    pub residual: f64,
}

/// A tongue narrower than this part of λ is closed: its width is rounding.
const CLOSED: f64 = 2e-13;

/// The boundaries come from the linear pencil E + δ dE/dλ, whose derivative is a difference over this part of λ; the
/// iteration squares the remaining error until rounding is reached.
const DIFFERENCE: f64 = 1e-4;
const POLISHING: usize = 8;

/// The parabolas whose vertices lead to θ* are as wide as the last change of the place, between these parts of the tongue:
/// narrow ones are more accurate, wide ones stay above rounding.
const COARSE: f64 = 0.05;
const FINE: f64 = 1e-3;

impl Tongue {
    /// The instability of order n if the truncation of Hill's matrices separates it from its neighbours, and the exact
    /// boundaries are found next to theirs.
    pub fn numbered(system: &System, n: usize, all: &Boundaries) -> Option<Self> {
        let start = all.of(n)?;
        let tongue = Tongue::new(system, n, start);
        // Half of the way to the next order.
        let room = start.high.abs() / n as f64;
        let Pair { low, high } = tongue.lambda;
        let near = (low - start.low).abs() < room && (high - start.high).abs() < room;
        (near && tongue.residual < LOST).then_some(tongue)
    }

    /// The instability of order n from a start for its boundaries.
    pub fn new(system: &System, n: usize, start: Pair) -> Self {
        let s = sign(n);
        let j = 0.5 * (n * system.parts.max(1)) as f64;
        let scale = j * j;
        let low = polish(system, s, scale, start, false);
        let high = polish(system, s, scale, start, true);
        let mut lambda = Pair { low: low.min(high), high: low.max(high) };
        if lambda.high - lambda.low <= CLOSED * scale {
            let middle = 0.5 * (lambda.low + lambda.high);
            lambda = Pair { low: middle, high: middle };
        }
        let residual = |lambda: f64| {
            if lambda <= 0.0 {
                // No speed belongs to it.
                return 0.0;
            }
            let m = system.monodromy(lambda, 0.0);
            determinant(&less(&m, s)).abs() / size(&m).max(1.0)
        };
        Tongue { n, j, lambda, residual: residual(lambda.low).max(residual(lambda.high)) }
    }

    /// The speeds of the instability without damping.
    pub fn extent(&self) -> Extent {
        match self.lambda {
            Pair { high, .. } if high <= 0.0 => Extent::Absent,
            Pair { low, high } if low == high => Extent::Closed,
            Pair { low, .. } if low <= 0.0 => Extent::Open,
            _ => Extent::Bounded,
        }
    }

    /// True if no speed is unstable.
    pub fn is_empty(&self) -> bool {
        matches!(self.extent(), Extent::Closed | Extent::Absent)
    }

    /// True if it reaches to infinite speed.
    pub fn is_open(&self) -> bool {
        self.extent() == Extent::Open
    }

    /// det E at the speed ratio 1/`inverse` with the damping ratio θ.
    fn excess(&self, system: &System, inverse: f64, theta: f64) -> f64 {
        determinant(&less(&system.monodromy(inverse * inverse, 2.0 * theta * inverse), sign(self.n)))
    }

    /// The damping ratio at which the instability vanishes at the speed ratio 1/`inverse`: the eigenvalue θ of Hill's
    /// problem at this speed. 0 outside of the undamped boundaries.
    pub fn critical_at(&self, system: &System, inverse: f64) -> f64 {
        let lambda = inverse * inverse;
        if self.is_empty() || !(self.lambda.low < lambda && lambda < self.lambda.high) {
            return 0.0;
        }
        let m = system.monodromy(lambda, 0.0);
        let start = determinant(&less(&m, sign(self.n)));
        if start >= 0.0 || start.is_nan() {
            return 0.0;
        }
        left(&mut |theta| self.excess(system, inverse, theta), (0.0, start), 1.05 * growth(system, inverse, &m))
    }

    /// The damping ratio at which the instability vanishes at this speed, searched above `theta` if the speed is unstable at
    /// it.
    pub fn critical_above(&self, system: &System, inverse: f64, theta: f64) -> f64 {
        let mut f = |theta: f64| self.excess(system, inverse, theta);
        let value = f(theta);
        if theta == 0.0 || value >= 0.0 || value.is_nan() {
            return self.critical_at(system, inverse);
        }
        left(&mut f, (theta, value), 1.2 * theta)
    }

    /// The damping ratio θ* at which the instability vanishes at every speed; None if no damping ratio suffices because it
    /// reaches to infinite speed.
    pub fn apex(&self, system: &System) -> Option<Apex> {
        if self.is_empty() {
            return Some(Apex { theta: 0.0, eta: 1.0 / self.lambda.high.max(0.0).sqrt(), residual: 0.0 });
        }
        if self.is_open() {
            return None;
        }
        let ends = [self.lambda.low.sqrt(), self.lambda.high.sqrt()];
        let width = ends[1] - ends[0];
        let mut undamped = |inverse: f64| growth(system, inverse, &system.monodromy(inverse * inverse, 0.0));
        let (mut inverse, _) = search::maximum(&mut undamped, ends, 1e-2 * width);
        let mut theta = self.critical_at(system, inverse);
        let mut step = COARSE * width;
        // det E is 0 at (1/η, θ). Next to it there is a speed with a smaller one; the error of θ there is the square of the
        // error of 1/η.
        for _ in 0..2 * POLISHING {
            let [before, after] = [-step, step].map(|step| self.excess(system, inverse + step, theta));
            let change = (0.5 * step * (before - after) / (before + after)).clamp(-2.0 * step, 2.0 * step);
            let next = inverse + change;
            let value = self.excess(system, next, theta);
            if before + after > 0.0 && value < 0.0 {
                let rise = 1.0 + 8.0 * (change / width).powi(2);
                theta = left(&mut |theta| self.excess(system, next, theta), (theta, value), rise * theta);
                inverse = next;
                step = change.abs().clamp(FINE * width, step);
            } else if step > FINE * width {
                step = (0.1 * step).max(FINE * width);
            } else {
                break;
            }
        }
        Some(Apex { theta, eta: 1.0 / inverse, residual: self.excess(system, inverse, theta).abs() })
    }

    /// The speed ratios between which the drive without damping is unstable.
    pub fn undamped(&self) -> Option<[f64; 2]> {
        let eta = |lambda: f64| if lambda > 0.0 { 1.0 / lambda.sqrt() } else { f64::INFINITY };
        (!self.is_empty()).then(|| [eta(self.lambda.high), eta(self.lambda.low)])
    }

    /// The speed ratios between which the drive with the damping ratio `theta` is unstable; the upper one is infinite in an
    /// open tongue. None if it is stable at all of them.
    pub fn interval(&self, system: &System, theta: f64) -> Option<[f64; 2]> {
        if theta == 0.0 || self.is_empty() {
            return self.undamped();
        }
        let inside = if self.is_open() {
            self.fast_and_unstable(system, theta)?
        } else {
            // Most tongues are unstable in their middle, if anywhere.
            let middle = 0.5 * (self.lambda.low.sqrt() + self.lambda.high.sqrt());
            let most = || self.least_stable(system, theta);
            if self.excess(system, middle, theta) < 0.0 { middle } else { most().filter(|(_, e)| *e < 0.0)?.0 }
        };
        Some(self.about(system, inside, theta))
    }

    /// The least det E at the damping ratio `theta` > 0: negative if speeds are unstable, 0 at θ = θ*. It is a smooth function
    /// of all that the tongue depends on, and takes a tenth of the work of θ* itself.
    pub fn margin(&self, system: &System, theta: f64) -> f64 {
        match self.extent() {
            // det E of the most stable, or most unstable, turn.
            Extent::Absent => 1.0,
            Extent::Open => -1.0,
            Extent::Closed => self.excess(system, self.lambda.high.sqrt(), theta),
            Extent::Bounded => self.least_stable(system, theta).map_or(1.0, |(_, excess)| excess),
        }
    }

    /// The place 1/η between two boundaries at which det E is least, and det E there.
    pub fn least_stable(&self, system: &System, theta: f64) -> Option<(f64, f64)> {
        if self.extent() != Extent::Bounded {
            return None;
        }
        let ends = [self.lambda.low.sqrt(), self.lambda.high.sqrt()];
        // The value is stationary: half of the digits of the place give all of the value.
        let tolerance = 1e-6 * (ends[1] - ends[0]);
        let (inverse, value) = search::maximum(&mut |inverse| -self.excess(system, inverse, theta), ends, tolerance);
        value.is_finite().then_some((inverse, -value))
    }

    /// In an open tongue a place 1/η that is unstable at the damping ratio `theta`, from its boundary to higher speeds.
    fn fast_and_unstable(&self, system: &System, theta: f64) -> Option<f64> {
        let slow = self.lambda.high.sqrt();
        (1..60).map(|i| slow * 0.8_f64.powi(i)).find(|x| self.excess(system, *x, theta) < 0.0)
    }

    /// The speed ratios of the interval about the unstable place `inside`, 1/η.
    fn about(&self, system: &System, inside: f64, theta: f64) -> [f64; 2] {
        let [fast, slow] = [self.lambda.low.max(0.0).sqrt(), self.lambda.high.sqrt()];
        let width = slow - fast;
        let upper = if self.is_open() { f64::INFINITY } else { 1.0 / self.end(system, theta, inside, fast, -width) };
        [1.0 / self.end(system, theta, inside, slow, width), upper]
    }

    /// The boundary at the damping ratio `theta` between `inside` and about the undamped one; both are 1/η. Damping may
    /// shift it a little beyond the undamped one, towards `beyond`.
    fn end(&self, system: &System, theta: f64, inside: f64, undamped: f64, beyond: f64) -> f64 {
        let mut f = |inverse: f64| self.excess(system, inverse, theta);
        let mut from = (inside, f(inside));
        let mut to = (undamped, f(undamped));
        for _ in 0..40 {
            if to.1 > 0.0 || from.1 >= 0.0 {
                break;
            }
            from = to;
            to.0 = (to.0 + 0.5 * beyond).max(0.5 * to.0);
            to.1 = f(to.0);
        }
        search::zero(&mut f, [from.0, to.0], [from.1, to.1], 0.0)
    }
}

/// The damping ratio at which an instability ends, from θ and det E in it; `next` is a guess.
fn left(f: &mut dyn FnMut(f64) -> f64, from: (f64, f64), next: f64) -> f64 {
    let (low, high) = climb(f, from, next);
    search::zero(f, [low.0, high.0], [low.1, high.1], 0.0)
}

/// The growth of the undamped motion, as the damping ratio that would balance it exactly if the damping were proportional to
/// the inertia.
fn growth(system: &System, inverse: f64, m: &Matrix) -> f64 {
    (spectral_radius(m).ln() / (system.period() * inverse)).max(f64::MIN_POSITIVE)
}

/// Raises θ from an instability, with det E there, until it ends, `next` first; returns the last two pairs.
fn climb(f: &mut dyn FnMut(f64) -> f64, from: (f64, f64), next: f64) -> ((f64, f64), (f64, f64)) {
    let (mut low, mut high) = (from, (next, f(next)));
    for _ in 0..60 {
        if high.1 >= 0.0 || high.1.is_nan() {
            break;
        }
        let theta = 1.4 * high.0 + f64::EPSILON;
        (low, high) = (high, (theta, f(theta)));
    }
    (low, high)
}

/// s of the instabilities with n zeros in a period.
fn sign(n: usize) -> f64 {
    if n.is_multiple_of(2) { 1.0 } else { -1.0 }
}

fn less(m: &Matrix, s: f64) -> Matrix {
    [[m[0][0] - s, m[0][1]], [m[1][0], m[1][1] - s]]
}

fn determinant(e: &Matrix) -> f64 {
    e[0][0] * e[1][1] - e[0][1] * e[1][0]
}

/// The part of det(A + δ B) that is linear in δ.
fn mixed(a: &Matrix, b: &Matrix) -> f64 {
    a[0][0] * b[1][1] + a[1][1] * b[0][0] - a[0][1] * b[1][0] - a[1][0] * b[0][1]
}

fn size(m: &Matrix) -> f64 {
    m.iter().flatten().fold(0.0, |size: f64, entry| size.max(entry.abs()))
}

/// The largest modulus of the eigenvalues.
pub fn spectral_radius(m: &Matrix) -> f64 {
    let [[re, im], other] = multipliers(m);
    (re * re + im * im).sqrt().max((other[0] * other[0] + other[1] * other[1]).sqrt())
}

/// The eigenvalues, the larger one first.
pub fn multipliers(m: &Matrix) -> [[f64; 2]; 2] {
    let [[a, b], [c, d]] = *m;
    let half = 0.5 * (a + d);
    // Without the cancellation of trace²/4 − determinant.
    let discriminant = (0.5 * (a - d)).powi(2) + b * c;
    if discriminant < 0.0 {
        let im = (-discriminant).sqrt();
        return [[half, im], [half, -im]];
    }
    let large = half + discriminant.sqrt().copysign(half);
    let small = if large == 0.0 { 0.0 } else { determinant(m) / large };
    [[large, 0.0], [small, 0.0]]
}

/// A boundary: the zeros of det(E + δ dE/dλ) around the present λ are both boundaries of a narrow tongue, so they stay separate
/// however close they are.
fn polish(system: &System, s: f64, scale: f64, start: Pair, high: bool) -> f64 {
    let mut lambda = if high { start.high } else { start.low };
    let h = DIFFERENCE * scale;
    let (mut last, mut slope) = (f64::INFINITY, Matrix::default());
    for _ in 0..POLISHING {
        let at = |lambda: f64| system.monodromy(lambda, 0.0);
        let e = less(&at(lambda), s);
        // Within the step of the difference the slope stays.
        if last > h {
            let [plus, minus] = [h, -h].map(|h| at(lambda + h));
            slope = std::array::from_fn(|i| std::array::from_fn(|k| (plus[i][k] - minus[i][k]) / (2.0 * h)));
        }
        let (a, b, c) = (determinant(&slope), mixed(&e, &slope), determinant(&e));
        let Some([near, far]) = quadratic(a, b, c) else { break };
        let (lower, upper) = (near.min(far), near.max(far));
        // If the other boundary is far, the nearer zero is this one; if both are near, their order decides.
        let change = if near.abs() < 0.05 * far.abs() {
            near
        } else if high {
            upper
        } else {
            lower
        };
        if !change.is_finite() || change.abs() >= last {
            break;
        }
        lambda += change;
        last = change.abs();
        if last <= 4.0 * f64::EPSILON * scale {
            break;
        }
    }
    lambda
}

/// The real zeros of a x² + b x + c, the smaller one in modulus first; a double one if rounding has made them complex.
fn quadratic(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let discriminant = b * b - 4.0 * a * c;
    if !(discriminant.is_finite() && a != 0.0) {
        return None;
    }
    if discriminant <= 0.0 {
        return Some([-0.5 * b / a; 2]);
    }
    let t = -0.5 * (b + discriminant.sqrt().copysign(b));
    let (x, y) = (t / a, if t == 0.0 { 0.0 } else { c / t });
    Some(if x.abs() < y.abs() { [x, y] } else { [y, x] })
}
