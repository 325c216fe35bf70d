//! Kaltofen's closed formulas for one passage of the clearance: cubic U about the release, no damping, e = 0.
//!
//! The mass m1 leaves its flank at Ü = 0, while the spring follows the quasi-static deformation (9), flies freely, and meets
//! the other flank, on which it stays. With τ = ωt, ω² = c/m2, μ = m1/m2, a² = μ/(μ + 1), θ = τ₁/a and η = Ω/ω:
//!
//! ```text
//! K = |s|/(|U₀‴| η³)                                                            (16)
//! τ₁³ + 6/(μ+1) (τ₁ − a sin θ) = 6K                                             (15)
//! Z = ½τ₁² + (1 − cos θ)/(μ+1),   velocity jump |I| = |U₀‴| η²Ω Z = dK/dτ₁ ω s/K  (18)
//! q₂/s = (τ* + τ₁ + A sin τ* + B cos τ*)/K,   A = ½τ₁² − a² (1 − cos θ),   B = −τ₁ + a sin θ   (21)–(23)
//! F_K/(c s) = −f/K − (μ/K) Z δ(τ*),   f = (μ+1)(τ₁ + τ*) + A sin τ* + B cos τ*   (25), (26)
//! ```
//!
//! τ* counts from the impact; F_K and q₂ have the signs of a release from flank A (U₀‴ < 0), flank B mirrors them. Symbols: s
//! clearance (m), c stiffness between m1 and m2 (N/m), Ω speed of the drive (rad/s); the rest are numbers.
//!
//! Valid for k²η² ≪ 1 for the harmonics k of U near the release (the relative error of (9) for a harmonic is k²η²), for a
//! passage short against the angle over which U‴ changes, and without vibration from an earlier passage.
//!
//! The source prints U₀⁗ in (10) and (16) and Ü₀ in (13) and (18) but means the third derivative; in (19) ω² is a factor of
//! both terms.
//!
//! Source: K. Kaltofen, "Zur Dynamik spielbehafteter periodischer Antriebe", IFToMM congress, Liberec 1996.

use crate::search::root;

/// Below this argument the series of [`remainder`] loses no digits, and 17 of its terms are accurate to rounding.
const SERIES: f64 = 3.0;

/// xⁿ/n! − xⁿ⁺²/(n+2)! + …: x − sin x for n = 3, x²/2 − 1 + cos x for n = 4, for 0 ≤ x ≤ [`SERIES`].
fn remainder(x: f64, n: u32) -> f64 {
    let square = x * x;
    let sum = (0..17).rev().fold(1.0, |sum, k| {
        let m = f64::from(n + 2 * k);
        1.0 - square / ((m + 1.0) * (m + 2.0)) * sum
    });
    (1..=n).fold(sum, |term, k| term * x / f64::from(k))
}

/// x − sin x for x ≥ 0, to full relative accuracy.
fn sine_rest(x: f64) -> f64 {
    if x < SERIES { remainder(x, 3) } else { x - x.sin() }
}

/// x²/2 − (1 − cos x) for x ≥ 0, to full relative accuracy.
fn cosine_rest(x: f64) -> f64 {
    if x < SERIES { remainder(x, 4) } else { 0.5 * x * x - versine(x) }
}

/// 1 − cos x, to full relative accuracy.
fn versine(x: f64) -> f64 {
    let half = (0.5 * x).sin();
    2.0 * half * half
}

/// The masses in the formulas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Masses {
    /// μ = m1/m2; 0 and ∞ are limits in which only the time of passage exists.
    pub mu: f64,
    /// a = √(μ/(μ+1)) = ω/ω₂.
    pub a: f64,
    /// 1/(μ+1).
    pub share: f64,
}

impl Masses {
    /// The masses with this ratio μ ≥ 0.
    pub fn new(mu: f64) -> Self {
        if mu.is_infinite() {
            return Masses { mu, a: 1.0, share: 0.0 };
        }
        Masses { mu, a: (mu / (mu + 1.0)).sqrt(), share: 1.0 / (mu + 1.0) }
    }

    /// b = τ₁ − a sin(τ₁/a), which is −B.
    fn lag(&self, tau: f64) -> f64 {
        if self.a == 0.0 { tau } else { self.a * sine_rest(tau / self.a) }
    }

    /// The K of this time of passage, (15). It grows with τ₁: dK/dτ₁ = Z.
    pub fn clearance(&self, tau: f64) -> f64 {
        tau * tau * tau / 6.0 + self.share * self.lag(tau)
    }

    /// Z of (18); for μ = 0 the mean over θ, because cos θ then turns infinitely fast.
    pub fn jump(&self, tau: f64) -> f64 {
        let turning = if self.a == 0.0 { 1.0 } else { versine(tau / self.a) };
        0.5 * tau * tau + self.share * turning
    }

    /// τ₁, the only root of (15), for K > 0.
    pub fn passage_time(&self, k: f64) -> f64 {
        // θ − sin θ lies between 0 and θ³/6, and above (1 − 0.2173) θ for θ ≥ 4.49, the minimum of sin θ/θ.
        let widest = (6.0 * k).cbrt();
        let (low, mut high) = (widest * self.a.powf(2.0 / 3.0) * (1.0 - 1e-12), widest * (1.0 + 1e-12));
        if self.a == 0.0 {
            high = high.min(k * (1.0 + 1e-12));
        }
        root(|tau| self.clearance(tau) / k - 1.0, [low, high])
    }
}

/// One passage, 0 < μ < ∞.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// The masses.
    pub masses: Masses,
    /// K.
    pub k: f64,
    /// τ₁ = ω times the time of passage.
    pub tau: f64,
    /// θ = τ₁/a = ω₂ times the time of passage.
    pub theta: f64,
}

impl Passage {
    /// The passage with this mass ratio and K > 0.
    pub fn new(mu: f64, k: f64) -> Self {
        let masses = Masses::new(mu);
        let tau = masses.passage_time(k);
        Passage { masses, k, tau, theta: tau / masses.a }
    }

    /// The passage of the duration τ₁ > 0.
    pub fn lasting(mu: f64, tau: f64) -> Self {
        let masses = Masses::new(mu);
        Passage { masses, k: masses.clearance(tau), tau, theta: tau / masses.a }
    }

    /// Z of (18).
    pub fn jump(&self) -> f64 {
        self.masses.jump(self.tau)
    }

    /// A and B of (22), (23).
    pub fn amplitudes(&self) -> [f64; 2] {
        let Masses { a, .. } = self.masses;
        [a * a * cosine_rest(self.theta), -self.masses.lag(self.tau)]
    }

    /// √(A² + B²)/K, the amplitude of the vibration after the impact relative to s; at most 1 (24).
    pub fn vibration(&self) -> f64 {
        let [a, b] = self.amplitudes();
        (a * a + b * b).sqrt() / self.k
    }

    /// q₂/s at τ* ≥ 0, (21).
    pub fn elongation(&self, tau: f64) -> f64 {
        (tau + self.masses.a * self.theta.sin() + self.vibrating(tau)) / self.k
    }

    /// f at τ* ≥ 0, (25), (26); positive if the flank presses.
    pub fn pressing(&self, tau: f64) -> f64 {
        (self.masses.mu + 1.0) * tau + self.pressing_at_once() + self.vibrating(tau)
    }

    /// f(0) = μτ₁ + a sin θ.
    pub fn pressing_at_once(&self) -> f64 {
        self.masses.a * (self.masses.mu * self.theta + self.theta.sin())
    }

    /// A sin τ* + B (cos τ* − 1).
    fn vibrating(&self, tau: f64) -> f64 {
        let [a, b] = self.amplitudes();
        a * tau.sin() - b * versine(tau)
    }
}
