//! The classical bounds of the critical damping, to be seen beside the exact ones.
//!
//! With complex harmonics relative to the means, R_k = 2 ĉ_k and M_k = 2 m̂_k, so that ĉ = 1 + Σ Re(R_k e^(ikφ)), at
//! j η = 1 and for damping proportional to nothing but itself:
//!
//! - three terms, q = A₀ + A cos jφ + B sin jφ: θ > ¼ |M₂ⱼ − R₂ⱼ| for half-integer j, and for integer j
//!   θ > ¼ |M₂ⱼ − R₂ⱼ + ½ C|, C = (Rⱼ − ½ Mⱼ)² where the inertia turns with the drive, C = Rⱼ (Rⱼ − Mⱼ) where it
//!   does not;
//! - second order, all harmonics between: θ > ½ |H_{j,−j} − Σ H_{jn} H_{n,−j}/(1 − n²/j²)|, n ≠ ±j, H_{nl} the
//!   element of Hill's matrix in row n of e^(inφ), divided by c₀.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.5.2 (14)–(16), the latter two with the modulus of the
//! complex sum, which alone does not depend on where the angle is counted from; the second order is that of H. Poincaré's
//! determinant as in Yakubovich, Starzhinskii, *Linear Differential Equations with Periodic Coefficients*, 1975.

use super::system::{Complex, System, coefficient};

/// The two approximations of θ*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Three terms.
    pub three_term: f64,
    /// Second order.
    pub second_order: f64,
}

/// The harmonics of m̂ and ĉ that the bounds are made of.
pub struct Harmonics {
    m: Vec<Complex>,
    c: Vec<Complex>,
    turning: bool,
}

impl Harmonics {
    /// Those of a system.
    pub fn new(system: &System) -> Self {
        Harmonics { m: system.inertia(), c: system.stiffness(), turning: system.inertia_turns() }
    }

    /// The bounds of the order j = `twice`/2.
    pub fn bounds(&self, twice: usize) -> Bounds {
        Bounds { three_term: self.three_term(twice), second_order: self.second_order(twice) }
    }

    fn three_term(&self, twice: usize) -> f64 {
        let relative = |list: &[Complex], k: usize| 2.0 * coefficient(list, k as i64);
        let mut sum = relative(&self.m, twice) - relative(&self.c, twice);
        if twice.is_multiple_of(2) {
            let (m, r) = (relative(&self.m, twice / 2), relative(&self.c, twice / 2));
            let constant = if self.turning { (r - 0.5 * m).powi(2) } else { r * (r - m) };
            sum += 0.5 * constant;
        }
        0.25 * sum.norm()
    }

    fn second_order(&self, twice: usize) -> f64 {
        // Orders are counted in halves, so that those of half-integer j are whole numbers.
        let j = twice as i64;
        let square = |n: i64| (n as f64 / j as f64).powi(2);
        let element = |n: i64, l: i64| {
            let k = (n - l) / 2;
            let waves = if self.turning { 0.5 * (square(n) + square(l)) } else { square(l) };
            coefficient(&self.c, k) - coefficient(&self.m, k) * waves
        };
        // H_{jn} vanishes beyond the highest harmonic.
        let reach = 2 * (self.m.len() as i64 - 1);
        let between = (j - reach..=j + reach).step_by(2).filter(|n| n.abs() != j);
        let through = |n: i64| element(j, n) * element(n, -j) / (1.0 - square(n));
        0.5 * (element(j, -j) - between.map(through).sum::<Complex>()).norm()
    }
}
