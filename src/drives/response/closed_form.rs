//! Cam and oscillator in closed form, for a Fourier law at constant speed and for a cam at rest: harmonic response plus
//! free motion, valid at any later time without growth of the error.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.2, equations (2) to (4).

use super::stride::{Stride, Turned};
use crate::drives::cam_drive::AngleMotion;
use crate::motion::Fourier;
use crate::numerics::angle;
use crate::numerics::double_double::{Double, two_product, two_sum};
use crate::numerics::forced::apply;
use crate::numerics::oscillator::{FreeMotion, Oscillator, Resonant};
use crate::numerics::phase::Phases;
use serde::{Deserialize, Serialize};

/// Cam and mass at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Instant {
    /// U [m] and U′ [m/rad].
    pub u: [f64; 2],
    /// q [m] and q̇ [m/s].
    pub q: [f64; 2],
}

/// The free motion is left out once it is below this part of the harmonic response: a tenth of its rounding.
const UNFELT: f64 = 1e-17;

/// The closed form from its start on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClosedForm {
    /// When it started [s].
    start: f64,
    /// φ and, where the free motion oscillates, its phase since the start.
    phases: Phases,
    /// The speed for which the harmonics were computed.
    holds_for: Option<f64>,
    /// a₀ [m].
    mean: f64,
    harmonics: Vec<Harmonic>,
    /// k of the first of them and the distance to the next.
    first: usize,
    distance: usize,
    /// k and resonant part.
    resonant: Vec<(usize, Resonant)>,
    /// What the start has beyond the harmonic response: q [m], q̇ [m/s].
    offset: [f64; 2],
    free: FreeMotion,
    /// When the free motion has died away [s].
    settled: f64,
}

/// What one harmonic adds to U, U′, q and q̇: `cosine` cos kφ + `sine` sin kφ. Aligned for packed arithmetic.
#[repr(align(16))]
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Harmonic {
    cosine: [f64; 4],
    sine: [f64; 4],
}

impl ClosedForm {
    /// Room for a law of this order.
    pub fn new(order: usize) -> Self {
        ClosedForm {
            start: 0.0,
            phases: Phases::default(),
            holds_for: None,
            mean: 0.0,
            harmonics: Vec::with_capacity(order),
            first: 0,
            distance: 0,
            resonant: Vec::with_capacity(most_resonant(order)),
            offset: [0.0; 2],
            free: FreeMotion::default(),
            settled: f64::INFINITY,
        }
    }

    /// Forgets the oscillator.
    pub fn clear(&mut self) {
        self.holds_for = None;
    }

    /// Starts at `time` [s] from `state` = q, q̇ on `motion`, which has a constant speed; `series` is the law, or None
    /// for a law of another kind at rest, whose U and U′ are then not computed.
    pub fn restart(
        &mut self,
        oscillator: &Oscillator,
        series: Option<&Fourier>,
        motion: &AngleMotion,
        time: f64,
        state: [f64; 2],
    ) {
        let w = motion.coefficients[1];
        self.start = time;
        if self.holds_for != Some(w) {
            self.holds_for = Some(w);
            self.prepare_harmonics(oscillator, series, w);
        }
        let rates = [Double::from(w), oscillator.frequency().unwrap_or_default()];
        self.phases = Phases::new(rates, [(motion.coefficients[0], motion.origin), (0.0, time)]);
        let [s, c] = self.phases.first(time);
        let driven = self.driven(oscillator, motion, [c, s], time);
        self.offset = [state[0] - driven.q[0], state[1] - driven.q[1]];
        self.free = oscillator.free_motion(self.offset);
        let size = self.size();
        self.settled = time + oscillator.settling(self.offset, size.map(|s| UNFELT * s));
    }

    /// The largest coefficient of a harmonic of q and q̇: its amplitude, to a factor in [1/√2, 1].
    fn size(&self) -> [f64; 2] {
        let largest =
            |i: usize| self.harmonics.iter().map(|h| h.cosine[i].abs().max(h.sine[i].abs())).fold(0.0, f64::max);
        [largest(2), largest(3)]
    }

    fn prepare_harmonics(&mut self, oscillator: &Oscillator, series: Option<&Fourier>, w: f64) {
        self.harmonics.clear();
        self.resonant.clear();
        let Some(series) = series else { return };
        self.mean = series.a[0];
        (self.first, self.distance) = progression(series);
        if self.first == 0 {
            return;
        }
        let sense = w.signum();
        for k in (self.first..=series.order()).step_by(self.distance) {
            let (a, b, order) = (series.a[k], series.b[k], k as f64);
            let nu = two_product(order, w.abs());
            // F of −ẍ = Re[F e^(ikψ)]; ψ = φ sgn w grows, so that a cam that turns back sees the sine coefficients
            // with the other sign.
            let force = [nu.hi * nu.hi * a, -nu.hi * nu.hi * sense * b];
            let response = oscillator.harmonic(force, nu);
            let [re, im] = response.steady;
            self.harmonics.push(Harmonic {
                cosine: [a, order * b, re, -nu.hi * im],
                sine: [b, -order * a, -sense * im, -nu.hi * sense * re],
            });
            self.resonant.extend(response.resonant.map(|part| (k, part)));
        }
    }

    /// Cam and mass at `time` [s], not before the start, on the motion of the start; `stride` helps where steps repeat
    /// themselves.
    #[inline(always)]
    pub fn at(&self, stride: &mut Stride, oscillator: &Oscillator, motion: &AngleMotion, time: f64) -> Instant {
        let (z, free) = match stride.to(time) {
            Some(turned) => turned,
            None => self.anew(stride, oscillator, motion.coefficients[1], time),
        };
        let mut now = self.driven(oscillator, motion, z, time);
        now.q = [now.q[0] + free[0], now.q[1] + free[1]];
        now
    }

    /// cos φ, sin φ and the free motion at any `time` [s], and the steps from there prepared.
    #[inline(never)]
    fn anew(&self, stride: &mut Stride, oscillator: &Oscillator, speed: f64, time: f64) -> Turned {
        let (angle, free) = if time > self.settled {
            (self.phases.first(time), [0.0; 2])
        } else {
            let [angle, phase] = self.phases.both(time);
            let free = if self.free.oscillates {
                self.free.at(time - self.start, phase)
            } else {
                apply(&oscillator.free(two_sum(time, -self.start)), self.offset)
            };
            (angle, free)
        };
        if let Some(length) = stride.unprepared(time) {
            let (s, c) = angle::reduce(two_product(speed, length)).sin_cos();
            let free = oscillator.free(Double::from(length));
            let order = (self.first + self.distance * self.harmonics.len()) as f64;
            stride.prepare(oscillator, length, [c, s], free, [speed, order]);
        }
        let turned = ([angle[1], angle[0]], free);
        stride.start(time, turned);
        turned
    }

    /// The harmonic response and the cam.
    #[inline(always)]
    fn driven(&self, oscillator: &Oscillator, motion: &AngleMotion, z: [f64; 2], time: f64) -> Instant {
        let mut sum = [self.mean, 0.0, 0.0, 0.0];
        if let Some((last, others)) = self.harmonics.split_last() {
            let (turn, mut z) = (power(z, self.distance), power(z, self.first));
            for harmonic in others {
                harmonic.add(&mut sum, z);
                z = product(z, turn);
            }
            last.add(&mut sum, z);
        }
        let mut now = Instant { u: [sum[0], sum[1]], q: [sum[2], sum[3]] };
        if !self.resonant.is_empty() {
            self.add_resonant(oscillator, motion, time, &mut now);
        }
        now
    }

    #[cold]
    #[inline(never)]
    fn add_resonant(&self, oscillator: &Oscillator, motion: &AngleMotion, time: f64, now: &mut Instant) {
        let psi = motion.at(time).reduced * motion.coefficients[1].signum();
        for (k, part) in &self.resonant {
            let (s, c) = (*k as f64 * psi).sin_cos();
            let [q, v] = oscillator.resonant(part, c, s, two_sum(time, -self.start));
            now.q = [now.q[0] + q, now.q[1] + v];
        }
    }
}

impl Harmonic {
    #[inline(always)]
    fn add(&self, sum: &mut [f64; 4], [c, s]: [f64; 2]) {
        for i in 0..4 {
            sum[i] += self.cosine[i] * c + self.sine[i] * s;
        }
    }
}

/// How many harmonics of a law of this order can be resonant at once: ν/ω₀ lies within [√(63/65), √(65/63)], so that k
/// lies within 3.2 % of the order.
fn most_resonant(order: usize) -> usize {
    1 + order / 31
}

/// The first k with a coefficient that is not zero, and the largest distance from it in which all others lie: only
/// odd harmonics cost half as much. k = 0 where all are zero.
pub fn progression(series: &Fourier) -> (usize, usize) {
    let mut present = (1..=series.order()).filter(|&k| series.a[k] != 0.0 || series.b[k] != 0.0);
    let Some(first) = present.next() else { return (0, 1) };
    let stride = present.fold(0, |stride, k| greatest_common_divisor(k - first, stride));
    (first, stride.max(1))
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// The product of two complex numbers.
#[inline(always)]
fn product([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a * c - b * d, a * d + b * c]
}

/// zⁿ for n ≥ 1.
#[inline(always)]
fn power(z: [f64; 2], n: usize) -> [f64; 2] {
    match n {
        1 => z,
        2 => product(z, z),
        _ => long_power(z, n),
    }
}

#[cold]
#[inline(never)]
fn long_power(z: [f64; 2], n: usize) -> [f64; 2] {
    (1..n).fold(z, |power, _| product(power, z))
}
