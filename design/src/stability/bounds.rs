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

use super::system::{Complex, System};

/// The two approximations of θ*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Three terms.
    pub three_term: f64,
    /// Second order.
    pub second_order: f64,
}

fn times(a: Complex, b: Complex) -> Complex {
    [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]]
}

fn plus(a: Complex, b: Complex, factor: f64) -> Complex {
    [a[0] + factor * b[0], a[1] + factor * b[1]]
}

fn modulus(a: Complex) -> f64 {
    (a[0] * a[0] + a[1] * a[1]).sqrt()
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

    /// The coefficient of e^(ikφ), k of either sign.
    fn at(list: &[Complex], k: i64) -> Complex {
        let [re, im] = list.get(k.unsigned_abs() as usize).copied().unwrap_or_default();
        if k < 0 { [re, -im] } else { [re, im] }
    }

    /// The bounds of the order j = `twice`/2.
    pub fn bounds(&self, twice: usize) -> Bounds {
        Bounds { three_term: self.three_term(twice), second_order: self.second_order(twice) }
    }

    fn three_term(&self, twice: usize) -> f64 {
        let relative = |list: &[Complex], k: usize| Self::at(list, k as i64).map(|x| 2.0 * x);
        let (m, r) = (relative(&self.m, twice), relative(&self.c, twice));
        let mut sum = plus(m, r, -1.0);
        if twice % 2 == 0 {
            let (m, r) = (relative(&self.m, twice / 2), relative(&self.c, twice / 2));
            let constant = if self.turning {
                let rho = plus(r, m, -0.5);
                times(rho, rho)
            } else {
                times(r, plus(r, m, -1.0))
            };
            sum = plus(sum, constant, 0.5);
        }
        0.25 * modulus(sum)
    }

    fn second_order(&self, twice: usize) -> f64 {
        // Orders are counted in halves, so that those of half-integer j are whole numbers.
        let j = twice as i64;
        let square = |n: i64| (n as f64 / j as f64).powi(2);
        let element = |n: i64, l: i64| {
            let k = (n - l) / 2;
            let waves = if self.turning { 0.5 * (square(n) + square(l)) } else { square(l) };
            plus(Self::at(&self.c, k), Self::at(&self.m, k), -waves)
        };
        // H_{jn} vanishes beyond the highest harmonic.
        let reach = 2 * (self.m.len() as i64 - 1);
        let between = (j - reach..=j + reach).step_by(2).filter(|n| n.abs() != j);
        let sum = between
            .fold(element(j, -j), |sum, n| plus(sum, times(element(j, n), element(n, -j)), -1.0 / (1.0 - square(n))));
        0.5 * modulus(sum)
    }
}
