//! Panels of a stiff drive: the fast modes of the oscillator apart from the motion that follows the flank.
//!
//! Where the modes are much faster than the flank, the equation of motion has one solution without their vibration,
//! a power series found from its highest coefficient down (contact):
//!
//! - complex roots: ω² q = −ü − 2δ q̇ − q̈; the difference to the state vibrates freely, q_f = e^(At) q_f(0);
//! - real roots λ₂ ≪ λ₁: with w = q̇ − λ₁ q, λ₂ w = ẇ + ü; the difference decays like e^(λ₂t).
//!
//! So a panel spans two radians of the flank, at any stiffness, as long as the vibration, which is bounded by its energy,
//! cannot reach an event; what has decayed below rounding is left out. Near an event, panels follow the vibration.
//!
//! Source: E. Hairer, G. Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., Springer 1996, section VI.3
//! (the smooth solution of a singularly perturbed problem).

use super::contact::{Bodies, Flank, Mode};
use super::flank::FlankMotion;
use super::panel::{COEFFICIENTS, MOST_TERMS, Pair, Panel, REACH, Rules, Terms};
use crate::numerics::double_double::Double;
use crate::numerics::first_zero::first_zero;
use crate::numerics::forced::apply;
use crate::numerics::oscillator::Oscillator;

/// A mode this many times faster than the flank is treated apart: coefficients from the highest down then decrease,
/// since (n + 1)(n + 2) ≤ 650 is less than (2 · 32)²/6.
const STIFF: f64 = 32.0;

/// The flank may be slower than this part of the fastest mode; its panels then last that long.
const SLOWEST: f64 = 1e-9;

/// A vibration this small against the motion without it is a rounding error.
const ROUNDING: f64 = 1e-15;

/// A panel apart from the fast modes must be worth this many that follow them.
const WORTH: f64 = 4.0;

/// Terms of an integration by parts; each is smaller than the one before by 1/[`STIFF`], 32⁻¹² = 1e-18.
const PARTS: usize = 12;

/// The slow rate [rad/s] of a motion that is stiff: that of the flank or of the slow one of two real modes.
pub fn stiff_rate(oscillator: &Oscillator, flank_rate: f64) -> Option<f64> {
    let fast = oscillator.rates().1;
    let slow = oscillator.real_roots().map_or(0.0, |(slow, _)| -slow).max(flank_rate);
    (fast > STIFF * slow).then_some(slow.max(SLOWEST * fast))
}

/// The motion without vibration, and what is left of the state.
struct Smooth {
    /// Coefficients of q.
    q: Terms,
    /// The free vibration at the start: q [m] and q̇ [m/s].
    vibration: [f64; 2],
}

impl Panel {
    /// Makes this panel, which holds its start alone, one apart from the fast modes, for `longest` [s] at most; false where
    /// panels have to follow them.
    pub(super) fn lay_smoothly(
        &mut self,
        bodies: &Bodies,
        flank: &impl FlankMotion,
        (slow, zeros): (f64, usize),
        longest: f64,
        rules: Rules,
    ) -> bool {
        let oscillator = *self.oscillator(bodies);
        let fast = oscillator.rates().1;
        let u = self.expand_flank(flank, REACH / slow);
        let (h, terms) = (self.span, self.terms);
        let contact = self.mode != Mode::Free;
        let mut acceleration = [0.0; MOST_TERMS];
        for (n, a) in acceleration[..terms].iter_mut().enumerate() {
            *a = ((n + 1) * (n + 2)) as f64 * u[n + 2];
        }
        let (forcing, scale) =
            if contact { (acceleration, flank.acceleration(self.start)) } else { ([0.0; MOST_TERMS], 0.0) };
        let Some(Smooth { q, vibration }) = smooth(&oscillator, &forcing[..terms], h, self.state.q, scale) else {
            return false;
        };
        let vibrating = vibration != [0.0; 2];
        if vibrating && !flank.is_uniform() {
            return false;
        }
        self.vibration = vibration;
        let share = bodies.share;
        for n in 0..terms + 2 {
            self.pairs[n] = Pair([if contact { u[n] } else { -share * q[n] - u[n] }, q[n]]);
        }
        if !contact {
            self.set_centre(bodies, &u);
            self.pairs[0].0[0] = self.state.zeta[0] + share * vibration[0];
            self.pairs[1].0[0] = (self.state.zeta[1] + share * vibration[1]) * h;
            self.begin_with(zeros);
        }
        (self.length, self.next_segment) = flank.stay(self.segment, self.start, h.min(longest));
        if rules.locked || self.length == 0.0 {
            return true;
        }
        if !vibrating {
            self.event = self.find(bodies, flank, zeros, fast);
            return true;
        }
        let clear = self.clear(bodies, &oscillator) * h;
        if clear < self.length {
            (self.length, self.next_segment) = (clear, self.segment);
        }
        self.length >= (WORTH * REACH / fast).min(longest)
    }

    /// How far no event is possible, whatever the phase of the vibration [spans].
    fn clear(&self, bodies: &Bodies, oscillator: &Oscillator) -> f64 {
        let amplitude = energy_amplitude(oscillator, self.vibration);
        let end = self.length / self.span;
        match self.mode {
            Mode::Contact(contact) => {
                let reach = (bodies.c + bodies.b * oscillator.stiffness().sqrt()) * amplitude;
                let mut force = self.force_series(bodies, contact);
                force[0] -= reach;
                first_zero(&force[..self.terms], end).unwrap_or(end)
            }
            Mode::Free => {
                let reach = bodies.share * amplitude;
                [Flank::A, Flank::B].into_iter().fold(end, |end, flank| {
                    let mut gap = self.gap_series(bodies, flank);
                    gap[0] -= reach;
                    first_zero(&gap[..self.terms], end).unwrap_or(end)
                })
            }
        }
    }

    /// Whether a vibration is to be added to the series.
    pub(super) fn vibrates(&self) -> bool {
        self.vibration != [0.0; 2]
    }

    /// The vibration `theta` [s] after the start: q [m] and q̇ [m/s].
    pub(super) fn vibration_at(&self, bodies: &Bodies, theta: f64) -> [f64; 2] {
        apply(&self.oscillator(bodies).free(Double::from(theta)), self.vibration)
    }

    /// ∫ F_K dt and ∫ U′ F_K dt of the vibration in contact.
    pub(super) fn vibration_integrals(&self, bodies: &Bodies, flank: &impl FlankMotion, span: [f64; 2]) -> [f64; 2] {
        if !self.vibrates() {
            return [0.0; 2];
        }
        let link = [-bodies.c, -bodies.b];
        let force = self.by_parts(bodies, &[1.0], link, span);
        let w = flank.speed();
        if w == 0.0 {
            return [force, force * flank.slope(self.segment, self.start)];
        }
        let mut slope = [0.0; MOST_TERMS];
        for n in 0..self.terms {
            slope[n] = (n + 1) as f64 * self.pairs[n + 1].0[0] / (self.span * w);
        }
        [force, self.by_parts(bodies, &slope[..self.terms], link, span)]
    }

    /// What the damper takes beyond the smooth motion.
    pub(super) fn vibration_loss(&self, bodies: &Bodies, theta: f64) -> f64 {
        if !self.vibrates() {
            return 0.0;
        }
        let oscillator = self.oscillator(bodies);
        let mass = if self.mode == Mode::Free { bodies.m1 * bodies.share } else { bodies.m2 };
        let energy = |[q, q_dot]: [f64; 2]| 0.5 * (q_dot * q_dot + oscillator.stiffness() * q * q);
        let own = mass * (energy(self.vibration) - energy(self.vibration_at(bodies, theta)));
        let mut speed = [0.0; MOST_TERMS];
        for n in 0..self.terms {
            speed[n] = (n + 1) as f64 * self.pairs[n + 1].0[1] / self.span;
        }
        own + 2.0 * bodies.b * self.by_parts(bodies, &speed[..self.terms], [0.0, 1.0], [0.0, theta])
    }

    /// ∫ p ℓ·f dt over the `span` [s] of a polynomial p and the vibration f = (q_f, q̇_f), ḟ = A f:
    /// Σ (−1)ᵏ p⁽ᵏ⁾ ℓ·A⁻⁽ᵏ⁺¹⁾ f between its ends.
    fn by_parts(&self, bodies: &Bodies, p: &[f64], functional: [f64; 2], span: [f64; 2]) -> f64 {
        let oscillator = self.oscillator(bodies);
        let primitive = |theta: f64| {
            let mut coefficients = [0.0; MOST_TERMS];
            coefficients[..p.len()].copy_from_slice(p);
            let mut f = self.vibration_at(bodies, theta);
            let (mut sum, mut sign) = (0.0, 1.0);
            for _ in 0..PARTS.min(p.len()) {
                f = [-(f[1] + 2.0 * oscillator.damping() * f[0]) / oscillator.stiffness(), f[0]];
                let value = coefficients.iter().rev().fold(0.0, |value, c| value * (theta / self.span) + c);
                sum += sign * value * (functional[0] * f[0] + functional[1] * f[1]);
                sign = -sign;
                for n in 1..MOST_TERMS {
                    coefficients[n - 1] = n as f64 * coefficients[n] / self.span;
                }
                coefficients[MOST_TERMS - 1] = 0.0;
            }
            sum
        };
        primitive(span[1]) - primitive(span[0])
    }
}

/// The smooth solution with the series of h² ü (zero in flight), `h` the unit of time [s], for the `state`. None where
/// a vibration must decay first.
fn smooth(oscillator: &Oscillator, acceleration: &[f64], h: f64, state: [f64; 2], scale: f64) -> Option<Smooth> {
    let terms = acceleration.len();
    let mut q = [0.0; COEFFICIENTS];
    let [place, speed] = state;
    if let Some((slow, fast)) = oscillator.real_roots() {
        let mut w = [0.0; COEFFICIENTS];
        for n in (0..terms).rev() {
            w[n] = ((n + 1) as f64 * w[n + 1] + acceleration[n] / h) / (fast * h);
        }
        let rest = speed - slow * place - w[0];
        let size = speed.abs() + (slow * place).abs() + w[0].abs() + scale / -fast;
        if !(rest.abs() <= 10.0 * ROUNDING * size) {
            return None;
        }
        q[0] = place;
        for n in 0..terms {
            q[n + 1] = h * (slow * q[n] + w[n]) / (n + 1) as f64;
        }
        return Some(Smooth { q, vibration: [0.0; 2] });
    }
    let (stiffness, damping) = (oscillator.stiffness() * h * h, 2.0 * oscillator.damping() * h);
    for n in (0..terms).rev() {
        let next = (n + 1) as f64;
        let curvature = if n + 2 < q.len() { next * (next + 1.0) * q[n + 2] } else { 0.0 };
        q[n] = -(acceleration[n] + damping * next * q[n + 1] + curvature) / stiffness;
    }
    let mut vibration = [place - q[0], speed - q[1] / h];
    if energy_amplitude(oscillator, vibration) * oscillator.stiffness() <= ROUNDING * scale {
        vibration = [0.0; 2];
    }
    Some(Smooth { q, vibration })
}

/// The largest |q| that a free vibration can reach: its energy does not grow.
fn energy_amplitude(oscillator: &Oscillator, [q, q_dot]: [f64; 2]) -> f64 {
    (q * q + q_dot * q_dot / oscillator.stiffness()).sqrt()
}
