//! Cam and oscillator in closed form, for a Fourier law at constant speed and for a cam at rest: harmonic response plus free
//! motion, valid at any later time without growth of the error.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.2, equations (2) to (4).

use super::error_bound::{of_free_motion, of_harmonics};
use crate::drives::follower::elastic_output::Equation;
use crate::drives::shaft::cam_drive::AngleMotion;
use crate::drives::shaft::cam_turn::turns;
use crate::drives::shaft::instant::Instant;
use crate::motion::Fourier;
use crate::numerics::divisor::greatest_common_divisor;
use crate::numerics::double_double::{Double, two_product, two_sum};
use crate::numerics::forced::{apply, under_constant};
use crate::numerics::oscillator::{FreeMotion, Oscillator, Resonant};
use crate::numerics::pair::Pair;
use crate::numerics::phase::Phases;
use serde::{Deserialize, Serialize};

/// The free motion is left out once it is below this part of the harmonic response: a tenth of its rounding.
const UNFELT: f64 = 1e-17;

/// An oscillator whose natural frequency is below this part of the speed of the cam hardly moves while it is pushed. Its deflection
/// under a constant force is therefore built up from the start, as at a resonance, lest two large motions all but cancel.
const SOFT: f64 = 1.0 / 64.0;

/// The closed form from its start on; everything except the speed follows from law and oscillator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClosedForm {
    /// The speed of the harmonics; None if the equation has changed since.
    pub holds_for: Option<f64>,
    /// a₀ (m).
    #[serde(skip)]
    mean: f64,
    #[serde(skip)]
    harmonics: Vec<Harmonic>,
    /// k of the first of them and the distance to the next.
    #[serde(skip)]
    first: usize,
    #[serde(skip)]
    distance: usize,
    /// k and resonant part.
    #[serde(skip)]
    resonant: Vec<(usize, Resonant)>,
    /// Rounding error of the harmonics of q (m).
    #[serde(skip)]
    rounded: f64,
}

/// The motion from a start on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The time of the start (s).
    start: f64,
    /// φ (rad) at a time (s).
    known: (f64, f64),
    /// φ and, if the free motion oscillates, its phase since the start.
    phases: Phases,
    /// The mean of q (m) or, for a soft oscillator, the constant part of the right side (m/s²).
    mean: f64,
    push: f64,
    /// Free motion at the start, the state less the harmonic response: q (m), q̇ (m/s).
    offset: [f64; 2],
    free: FreeMotion,
    /// The time at which the free motion has died away (s).
    free_until: f64,
    /// The largest |q| returned so far (m).
    pub largest: f64,
}

/// Contribution of one harmonic to U, U′ and to q, q̇: of each pair, the first from cos kφ and the second from sin kφ
/// (`straight`), the first from sin kφ and the second from cos kφ (`crossed`).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Harmonic {
    straight: [Pair; 2],
    crossed: [Pair; 2],
    /// Contribution to U″: from cos kφ and from sin kφ.
    curvature: Pair,
}

impl Harmonic {
    /// The harmonic k of a law.
    fn of_law(a: f64, b: f64, k: f64) -> Self {
        let nothing = Pair::default();
        let (straight, crossed) = ([Pair::new(a, -k * a), nothing], [Pair::new(b, k * b), nothing]);
        Harmonic { straight, crossed, curvature: Pair::new(-k * k * a, -k * k * b) }
    }
}

impl ClosedForm {
    /// The closed form for the law `series`; for other laws (None) it serves a cam at rest only.
    pub fn new(series: Option<&Fourier>) -> Self {
        let order = series.map_or(0, Fourier::order);
        let (first, distance) = series.map_or((0, 1), progression);
        let harmonics = series.filter(|_| 0 < first).map_or(Vec::new(), |series| {
            (first..=order).step_by(distance).map(|k| Harmonic::of_law(series.a[k], series.b[k], k as f64)).collect()
        });
        ClosedForm {
            holds_for: None,
            mean: series.map_or(0.0, |series| series.a[0]),
            harmonics,
            first,
            distance,
            resonant: Vec::with_capacity(most_resonant(order)),
            rounded: 0.0,
        }
    }

    /// Rebuilds the parts that the serialisation leaves out.
    pub fn restored(&mut self, equation: &Equation, series: Option<&Fourier>) {
        *self = ClosedForm { holds_for: self.holds_for, ..ClosedForm::new(series) };
        if let Some(w) = self.holds_for {
            self.prepare_harmonics(equation, w);
        }
    }

    /// Starts at `time` (s) from `state` = q, q̇ on `motion`, which has a constant speed; `rest` is U of a cam at rest, whose U and
    /// U′ are not computed if the law is no series.
    pub fn restart(
        &mut self,
        equation: &Equation,
        motion: &AngleMotion,
        time: f64,
        state: [f64; 2],
        rest: Option<f64>,
    ) -> Run {
        let w = motion.coefficients[1];
        if self.holds_for != Some(w) {
            self.holds_for = Some(w);
            self.prepare_harmonics(equation, w);
        }
        let oscillator = &equation.oscillator;
        let rates = [Double::from(w), oscillator.frequency().unwrap_or_default()];
        let known = (motion.coefficients[0], motion.origin);
        let phases = Phases::new(rates, [known, (0.0, time)]);
        let [s, c] = phases.first(time);
        let mut driven = Instant::default();
        self.drive(Pair::new(c, s), &mut driven);
        if !self.resonant.is_empty() {
            self.add_resonant(oscillator, motion, [time; 2], &mut driven);
        }
        let push = equation.weights.map_or(0.0, |_| equation.forcing([rest.unwrap_or(self.mean), 0.0, 0.0]));
        let soft = oscillator.stiffness() <= (SOFT * w).powi(2);
        let (mean, push) = if soft { (0.0, push) } else { (push / oscillator.stiffness(), 0.0) };
        let offset = (Pair::from(state) - driven.q - Pair::new(mean, 0.0)).array();
        let free_until = time + oscillator.settling(offset, self.size().map(|s| UNFELT * s));
        let free = oscillator.free_motion(offset);
        Run { start: time, known, phases, mean, push, offset, free, free_until, largest: state[0].abs() }
    }

    /// The largest coefficient of a harmonic of q and q̇: its amplitude, to a factor in [1/√2, 1].
    fn size(&self) -> [f64; 2] {
        let largest = |i: usize| {
            self.harmonics
                .iter()
                .map(|h| h.straight[1].array()[i].abs().max(h.crossed[1].array()[i].abs()))
                .fold(0.0, f64::max)
        };
        [largest(0), largest(1)]
    }

    /// Rounding error of q by `time` (s), relative to the largest |q| since the start: each part of q is rounded by itself, and
    /// near a resonance or soon after the start the parts all but cancel.
    pub fn rounding(&self, run: &Run, oscillator: &Oscillator, time: f64) -> f64 {
        let elapsed = time - run.start;
        let [q, v] = run.offset.map(f64::abs);
        let free =
            if run.free.oscillates { run.free.amplitude() } else { q + (v / oscillator.rates().1).min(v * elapsed) };
        let pushed = if run.push == 0.0 { 0.0 } else { run.largest };
        let mut rounded = self.rounded + of_free_motion() * (free + run.mean.abs() + pushed);
        if !self.resonant.is_empty() {
            rounded += self.resonant_rounding(oscillator, elapsed);
        }
        if run.largest > 0.0 { (rounded / run.largest).min(1.0) } else { 0.0 }
    }

    #[cold]
    fn resonant_rounding(&self, oscillator: &Oscillator, elapsed: f64) -> f64 {
        let of_part = |(k, part): &(usize, Resonant)| {
            let [[even, _], [odd, _]] = [[1.0, 0.0], [0.0, 1.0]]
                .map(|[cosine, sine]| oscillator.resonant(part, cosine, sine, Double::from(elapsed)));
            of_harmonics(*k as f64) * (even * even + odd * odd).sqrt()
        };
        self.resonant.iter().map(of_part).sum()
    }

    fn prepare_harmonics(&mut self, equation: &Equation, w: f64) {
        self.resonant.clear();
        self.rounded = 0.0;
        let sense = w.signum();
        for (i, harmonic) in self.harmonics.iter_mut().enumerate() {
            let k = self.first + i * self.distance;
            let ([a, _], [b, _]) = (harmonic.straight[0].array(), harmonic.crossed[0].array());
            let nu = two_product(k as f64, w.abs());
            // ψ = kφ sgn w grows, so a cam that turns backwards reverses the sign of the sine coefficients. At rest all harmonics
            // together are a constant.
            let moved = turns(w) || equation.weights.is_none();
            let force = if moved { equation.forcing_of_harmonic([a, -sense * b], nu.hi) } else { [0.0; 2] };
            let response = equation.oscillator.harmonic(force, nu);
            let [re, im] = response.steady;
            harmonic.straight[1] = Pair::new(re, -nu.hi * sense * re);
            harmonic.crossed[1] = Pair::new(-sense * im, -nu.hi * im);
            self.rounded += of_harmonics(k as f64) * (re * re + im * im).sqrt();
            self.resonant.extend(response.resonant.map(|part| (k, part)));
        }
    }

    /// Brings cam and mass `now` to `time` (s), at or after the start, on the motion of the start.
    pub fn reach(&self, run: &mut Run, oscillator: &Oscillator, motion: &AngleMotion, time: f64, now: &mut Instant) {
        let ([s, c], free) = if time > run.free_until {
            (run.phases.first(time), [0.0; 2])
        } else {
            let [angle, phase] = run.phases.both(time);
            let free = if run.free.oscillates {
                run.free.at(time - run.start, phase)
            } else {
                apply(&oscillator.free(two_sum(time, -run.start)), run.offset)
            };
            (angle, free)
        };
        let [phi, w, a, ..] = motion.kinematics(time);
        (now.time, now.shaft, now.q) = (time, [phi, w, a], Pair::new(free[0] + run.mean, free[1]));
        self.drive(Pair::new(c, s), now);
        if run.push != 0.0 {
            add_push(run, oscillator, time, now);
        }
        if !self.resonant.is_empty() {
            self.add_resonant(oscillator, motion, [run.start, time], now);
        }
        let [q, _] = now.q.array();
        run.largest = run.largest.max(q.abs());
    }

    /// Sets the cam at cos φ and sin φ = `z`, and adds the harmonic response without resonant parts to the free motion q.
    #[inline(always)]
    fn drive(&self, z: Pair, now: &mut Instant) {
        let (mut z, turn) = (power(z, self.first), power(z, self.distance));
        let (mut u, mut curvature, mut q) = (Pair::new(self.mean, 0.0), Pair::default(), now.q);
        for harmonic in &self.harmonics {
            let crossed = z.swapped();
            u = u + (harmonic.straight[0] * z + harmonic.crossed[0] * crossed);
            q = q + (harmonic.straight[1] * z + harmonic.crossed[1] * crossed);
            curvature = curvature + harmonic.curvature * z;
            z = turned(z, turn);
        }
        let [of_cosines, of_sines] = curvature.array();
        (now.u, now.curvature, now.q) = (u, of_cosines + of_sines, q);
    }

    #[cold]
    #[inline(never)]
    fn add_resonant(&self, oscillator: &Oscillator, motion: &AngleMotion, [start, time]: [f64; 2], now: &mut Instant) {
        let psi = motion.at(time).reduced * motion.coefficients[1].signum();
        for (k, part) in &self.resonant {
            let (s, c) = (*k as f64 * psi).sin_cos();
            let [q, v] = oscillator.resonant(part, c, s, two_sum(time, -start));
            now.q = now.q + Pair::new(q, v);
        }
    }
}

#[cold]
fn add_push(run: &Run, oscillator: &Oscillator, time: f64, now: &mut Instant) {
    now.q = now.q + under_constant(oscillator, run.push, [0.0; 2], time - run.start).into();
}

/// The most harmonics of a law of this order that can be resonant at once: ν/ω₀ lies within [√(63/65), √(65/63)], so that k lies
/// within 3.2 % of the order.
fn most_resonant(order: usize) -> usize {
    1 + order / 31
}

/// The first k with a coefficient that is not zero, and the largest distance from it in which all others lie: only odd harmonics
/// cost half as much. k = 0 if all are zero.
pub fn progression(series: &Fourier) -> (usize, usize) {
    let mut present = (1..=series.order()).filter(|&k| series.a[k] != 0.0 || series.b[k] != 0.0);
    let Some(first) = present.next() else { return (0, 1) };
    let stride = present.fold(0, |stride, k| greatest_common_divisor(k - first, stride));
    (first, stride.max(1))
}

/// zⁿ for a complex number z and n ≥ 1 (n = 0: z).
fn power(z: Pair, n: usize) -> Pair {
    (1..n).fold(z, |power, _| turned(power, z))
}

/// x turned by the angle with this cosine and sine.
#[inline(always)]
fn turned(x: Pair, turn: Pair) -> Pair {
    turn.firsts() * x + turn.seconds() * Pair::new(-1.0, 1.0) * x.swapped()
}
