//! The linear oscillator q̈ + 2δ q̇ + ω₀² q = f(t): free motion and the response to a harmonic.
//!
//! Under-, critically and overdamped motion and the undamped resonance come out of the same few formulas, none
//! of which subtracts nearly equal numbers.

use super::angle;
use super::double_double::Double;
use num_complex::Complex;
use serde::{Deserialize, Serialize};

/// q̈ + 2δ q̇ + ω₀² q = f(t) with ω₀² ≥ 0 (1/s²) and δ ≥ 0 (1/s).
///
/// With D = ω₀² − δ² the roots of the characteristic equation are λ = −δ ± i√D or, for D ≤ 0, real.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Oscillator {
    /// ω₀² (1/s²).
    stiffness: Double,
    /// δ (1/s).
    damping: f64,
    modes: Modes,
}

/// The two free motions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
enum Modes {
    /// e^(−δt) times a harmonic of the frequency √D (rad/s).
    Oscillating { frequency: Double },
    /// e^(λ₁t) and e^(λ₂t) with λ₂ ≤ λ₁ ≤ 0 (1/s).
    Aperiodic { slow: f64, fast: f64 },
}

/// The response to Re[F e^(iψ)], where ψ grows at the constant rate ν: Re[A e^(iψ)] and, near a resonance, the part of the
/// transient that grows out of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Harmonic {
    /// Re and Im of A.
    pub steady: [f64; 2],
    /// The resonant part, near a resonance.
    pub resonant: Option<Resonant>,
}

/// B e^(iψ) (1 − e^(−zτ))/z, the motion that a harmonic near the natural frequency builds up from rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resonant {
    /// Re and Im of B = F/(2i ω_d).
    amplitude: [f64; 2],
    /// ω_d − ν (rad/s); z = δ − i (ω_d − ν).
    detuning: Double,
}

/// The free motion from a given start: q and q̇ are e^(−δτ) [`cosine` cos ω_d τ + `sine` sin ω_d τ] if it oscillates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FreeMotion {
    /// Whether the modes oscillate; if not, use [`Oscillator::free`].
    pub oscillates: bool,
    /// δ (1/s).
    damping: f64,
    cosine: [f64; 2],
    sine: [f64; 2],
}

/// Nearer than this (relative to ω₀² + ν²) the denominator ω₀² − ν² + 2iδν counts as resonant. Further away the
/// steady and the free part may cancel at the start to 1/64 of their size, less than two digits.
const NEAR: f64 = 1.0 / 64.0;

impl Oscillator {
    /// The oscillator of the mass `m` (kg) on the spring `c` (N/m) and the damper `b` (N·s/m).
    pub fn of_mass(m: f64, c: f64, b: f64) -> Self {
        Self::new(Double::from(c).divide(Double::from(m)), Double::from(b).divide(Double::from(2.0 * m)))
    }

    /// The oscillator with ω₀² = `stiffness` (1/s²) and δ = `damping` (1/s).
    pub fn new(stiffness: Double, damping: Double) -> Self {
        let discriminant = stiffness - damping * damping;
        let delta = damping.hi;
        let modes = if discriminant.hi > 0.0 {
            Modes::Oscillating { frequency: discriminant.sqrt() }
        } else {
            // The larger root by addition, the smaller one from the product λ₁ λ₂ = ω₀².
            let fast = -(delta + (-discriminant).sqrt().hi);
            let slow = if fast < 0.0 { stiffness.hi / fast } else { 0.0 };
            Modes::Aperiodic { slow, fast: fast.min(slow) }
        };
        Oscillator { stiffness, damping: delta, modes }
    }

    /// ω₀² (1/s²).
    pub fn stiffness(&self) -> f64 {
        self.stiffness.hi
    }

    /// δ (1/s).
    pub fn damping(&self) -> f64 {
        self.damping
    }

    /// |λ| of the slow and of the fast root (1/s).
    pub fn rates(&self) -> (f64, f64) {
        match self.modes {
            Modes::Oscillating { .. } => (self.stiffness.hi.sqrt(), self.stiffness.hi.sqrt()),
            Modes::Aperiodic { slow, fast } => (-slow, -fast),
        }
    }

    /// The rate at which the slower mode decays (1/s).
    pub fn decay(&self) -> f64 {
        match self.modes {
            Modes::Oscillating { .. } => self.damping,
            Modes::Aperiodic { slow, .. } => -slow,
        }
    }

    /// λ₁, λ₂ (1/s) if they are real.
    pub fn real_roots(&self) -> Option<(f64, f64)> {
        match self.modes {
            Modes::Oscillating { .. } => None,
            Modes::Aperiodic { slow, fast } => Some((slow, fast)),
        }
    }

    /// ω_d = √(ω₀² − δ²) (rad/s) if the modes oscillate.
    pub fn frequency(&self) -> Option<Double> {
        match self.modes {
            Modes::Oscillating { frequency } => Some(frequency),
            Modes::Aperiodic { .. } => None,
        }
    }

    /// The free motion from q, q̇ = `start`.
    pub fn free_motion(&self, start: [f64; 2]) -> FreeMotion {
        let ([q, v], delta) = (start, self.damping);
        match self.modes {
            Modes::Oscillating { frequency } => FreeMotion {
                oscillates: true,
                damping: delta,
                cosine: start,
                sine: [(v + delta * q) / frequency.hi, -(self.stiffness.hi * q + delta * v) / frequency.hi],
            },
            Modes::Aperiodic { .. } => FreeMotion::default(),
        }
    }

    /// The time (s) after which the free motion from q, q̇ = `start` stays below these magnitudes of q and q̇; infinite if it need
    /// not die away.
    pub fn settling(&self, [q, v]: [f64; 2], below: [f64; 2]) -> f64 {
        if q == 0.0 && v == 0.0 {
            return 0.0;
        }
        // |q| ≤ (|q₀| + |v₀ + δq₀| g) e^(−rτ) and |q̇| ≤ (|v₀| + |ω₀²q₀ + δv₀| g) e^(−rτ), where g bounds
        // sin(ω_d τ)/ω_d or, at half the rate of decay, what stands for it where there is no oscillation.
        let (rate, g) = match self.modes {
            Modes::Oscillating { frequency } => (self.damping, 1.0 / frequency.hi),
            Modes::Aperiodic { slow, .. } => (-0.5 * slow, -1.0 / slow),
        };
        let (q, v) = (q.abs(), v.abs());
        let q_bound = q + (v + 2.0 * self.damping * q) * g;
        let v_bound = 2.0 * v + (self.stiffness.hi * q + 2.0 * self.damping * v) * g;
        let decades = (q_bound / below[0]).max(v_bound / below[1]).ln().max(0.0);
        // NaN means that the motion does not die away.
        let time = decades / rate;
        if time < f64::INFINITY { time } else { f64::INFINITY }
    }

    /// The free motion after the time `tau` (s) from q = 1, q̇ = 0 (first column) and q = 0, q̇ = 1 (second
    /// column); rows q, q̇. The phase √D·τ is formed in double-double, so that it stays right after any number
    /// of periods.
    pub fn free(&self, tau: Double) -> [[f64; 2]; 2] {
        let (omega2, delta, t) = (self.stiffness.hi, self.damping, tau.hi);
        match self.modes {
            Modes::Oscillating { frequency } => {
                let decay = (-delta * t).exp();
                if decay == 0.0 {
                    // The free motion has died away; its phase need not be computed.
                    return [[0.0; 2]; 2];
                }
                let (sin, cos) = angle::reduce(frequency * tau).sin_cos();
                let (g, c) = (decay * (sin / frequency.hi), decay * cos);
                [[c + delta * g, g], [-omega2 * g, c - delta * g]]
            }
            Modes::Aperiodic { slow, fast } => {
                let (e1, e2) = ((slow * t).exp(), (fast * t).exp());
                let g = impulse_response(slow, fast, t);
                [[e1 - slow * g, g], [-omega2 * g, e2 + slow * g]]
            }
        }
    }

    /// The response to a unit impulse and its time derivative, `t` (s) later; for phases of a few revolutions.
    pub fn kernel(&self, t: f64) -> [f64; 2] {
        match self.modes {
            Modes::Oscillating { frequency } => {
                let (sin, cos) = (frequency.hi * t).sin_cos();
                let decay = (-self.damping * t).exp();
                let g = decay * (sin / frequency.hi);
                [g, decay * cos - self.damping * g]
            }
            Modes::Aperiodic { slow, fast } => {
                let g = impulse_response(slow, fast, t);
                [g, (fast * t).exp() + slow * g]
            }
        }
    }

    /// |ω₀² − ν² + 2iδν|/(ω₀² + ν²) for ν = `nu` (rad/s): zero at an undamped resonance.
    pub fn relative_impedance(&self, nu: Double) -> f64 {
        let (re, im, scale) = self.impedance(nu);
        (re * re + im * im).sqrt() / scale
    }

    fn impedance(&self, nu: Double) -> (f64, f64, f64) {
        let nu2 = nu * nu;
        ((self.stiffness - nu2).hi, 2.0 * self.damping * nu.hi, self.stiffness.hi + nu2.hi)
    }

    /// The response to Re[F e^(iψ)], F = `force` (m/s²), dψ/dt = `nu` ≥ 0 (rad/s).
    pub fn harmonic(&self, force: [f64; 2], nu: Double) -> Harmonic {
        let f = Complex::new(force[0], force[1]);
        if f.re == 0.0 && f.im == 0.0 {
            return Harmonic { steady: [0.0; 2], resonant: None };
        }
        let (re, im, scale) = self.impedance(nu);
        match self.modes {
            Modes::Oscillating { frequency } if (re * re + im * im).sqrt() < NEAR * scale => {
                // 1/((μ−λ)(μ−λ̄)) = [1/(μ−λ) − 1/(μ−λ̄)]/(2i ω_d) with μ = iν, λ = −δ + iω_d: only the first
                // fraction is large.
                let b = f / Complex::new(0.0, 2.0 * frequency.hi);
                let steady = -b / Complex::new(self.damping, (frequency + nu).hi);
                Harmonic {
                    steady: [steady.re, steady.im],
                    resonant: Some(Resonant { amplitude: [b.re, b.im], detuning: frequency - nu }),
                }
            }
            _ => Harmonic { steady: self.steady(force, nu), resonant: None },
        }
    }

    /// A of the steady response Re[A e^(iψ)] to Re[F e^(iψ)]; infinite at an undamped resonance.
    pub fn steady(&self, force: [f64; 2], nu: Double) -> [f64; 2] {
        let (re, im, _) = self.impedance(nu);
        let a = Complex::new(force[0], force[1]) / Complex::new(re, im);
        [a.re, a.im]
    }

    /// The resonant part of q and q̇ at the phase ψ (`cosine`, `sine`), `tau` (s) after its start from rest.
    pub fn resonant(&self, part: &Resonant, cosine: f64, sine: f64, tau: Double) -> [f64; 2] {
        let Modes::Oscillating { frequency } = self.modes else { return [0.0; 2] };
        let z = Complex::new(self.damping, -part.detuning.hi);
        let decayed = minus_one(-self.damping * tau.hi, angle::reduce(part.detuning * tau));
        let growth = if z.norm_sqr() > 0.0 { -decayed / z } else { Complex::new(tau.hi, 0.0) };
        let drive = Complex::new(part.amplitude[0], part.amplitude[1]) * Complex::new(cosine, sine);
        // u = B e^(iψ) (1 − e^(−zτ))/z solves u̇ = λ u + B e^(iψ).
        let u = drive * growth;
        let rate = Complex::new(-self.damping, frequency.hi) * u + drive;
        [u.re, rate.re]
    }
}

impl FreeMotion {
    /// The largest |q| if it oscillates.
    pub fn amplitude(&self) -> f64 {
        (self.cosine[0] * self.cosine[0] + self.sine[0] * self.sine[0]).sqrt()
    }

    /// q, q̇ after the time `tau` (s) at the phase ω_d τ (`sine`, `cosine`).
    #[inline(always)]
    pub fn at(&self, tau: f64, [sine, cosine]: [f64; 2]) -> [f64; 2] {
        let decay = if self.damping == 0.0 { 1.0 } else { (-self.damping * tau).exp() };
        let (c, s) = (decay * cosine, decay * sine);
        std::array::from_fn(|i| self.cosine[i] * c + self.sine[i] * s)
    }
}

/// (e^(λ₁t) − e^(λ₂t))/(λ₁ − λ₂) for λ₂ ≤ λ₁.
fn impulse_response(slow: f64, fast: f64, t: f64) -> f64 {
    let split = slow - fast;
    let x = split * t;
    let mean = if x == 0.0 { t } else { -(-x).exp_m1() / split };
    (slow * t).exp() * mean
}

/// e^(x + iy) − 1.
fn minus_one(x: f64, y: f64) -> Complex<f64> {
    let (sin, cos) = y.sin_cos();
    let half = (0.5 * y).sin();
    Complex::new(x.exp_m1() * cos - 2.0 * half * half, x.exp() * sin)
}

#[cfg(test)]
mod tests;
