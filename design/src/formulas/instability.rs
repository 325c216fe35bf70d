//! Bounds of the critical damping and borders of parametric instability, by few harmonics.
//!
//! **Bounds.** With complex harmonics relative to the means, R_k = 2 ĉ_k and M_k = 2 m̂_k, so that ĉ = 1 + Σ Re(R_k e^(ikφ)),
//! at j η = 1 and for constant damping:
//!
//! - three terms, q = A₀ + A cos jφ + B sin jφ: θ > ¼ |M₂ⱼ − R₂ⱼ| for half-integer j, and for integer j
//!   θ > ¼ |M₂ⱼ − R₂ⱼ + ½ C|, C = (Rⱼ − ½ Mⱼ)² if the inertia turns with the drive, C = Rⱼ (Rⱼ − Mⱼ) if it
//!   does not;
//! - second order, all harmonics between: θ > ½ |H_{j,−j} − Σ H_{jn} H_{n,−j}/(1 − n²/j²)|, n ≠ ±j, H_{nl} the
//!   element of Hill's matrix in row n of e^(inφ), divided by c₀.
//!
//! The borders are the three terms' at any speed, with x = j²η² and the constant eliminated,
//! E = H_{jj} − H_{j0} H_{0j}, F = H_{j,−j} − H_{j0} H_{0,−j} (without the products for half-integer j):
//!
//! |E + 2iθ√x|² = |F|²,  unstable if the left side is less.
//!
//! For half-integer j that is (10)–(13), D₂ η⁴ − D₁ η² + D₀ = 0 with D₀ = 1 − ¼(r_c² + r_s²), D₁ = 2j² (1 − ¼ r_c μ − 2θ²),
//! D₂ = j⁴ (1 − ¼ μ²), for integer j the determinant (9). Valid for one harmonic that outweighs the others and constant damping; a
//! varying mass moves borders by per cents, because the mean of 1/m is not 1/m₀.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, sections 4.5.2 (9)–(16) and 4.5.3 (7), figure 4.23c: (9) with the entry
//! k_j that is missing in the print of its first row; (12) with r = (c₂ⱼ − jΩ b₂ⱼ)/c₀, whose Ω is not printed and cancels if
//! the inertia turns; (15) and (16) as printed and with the modulus of the complex sum, which alone does not depend on the zero
//! of the angle. The second order is H. Poincaré's determinant as in Yakubovich, Starzhinskii, *Linear Differential Equations
//! with Periodic Coefficients*, 1975.

use crate::harmonic_analysis::{Complex, coefficient};
use crate::search;
use serde::Serialize;

/// The approximations of θ*.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bounds {
    /// Three terms, at j η = 1.
    pub three_term: f64,
    /// Second order.
    pub second_order: f64,
    /// (14), (16) as printed, with a sum of moduli.
    pub printed: f64,
    /// The three terms at the speed that needs most damping: the top of the border (9), (10).
    pub determinant: f64,
    /// The three terms without the constant A₀: ¼ |M₂ⱼ − R₂ⱼ|.
    pub without_mean: f64,
}

/// The harmonics of m̂ and ĉ in the bounds.
pub struct Harmonics {
    /// m̂ₖ of e^(ikφ).
    pub m: Vec<Complex>,
    /// ĉₖ.
    pub c: Vec<Complex>,
    /// True if the inertia turns with the drive.
    pub turning: bool,
}

/// j²η² between which a border is searched: its instability lies around 1.
const NEAR: [f64; 2] = [0.25, 4.0];
/// Tolerance of the place of a top; the damping there has more digits.
const TOLERANCE: f64 = 1e-12;

impl Harmonics {
    /// The bounds of the order j = `twice`/2.
    pub fn bounds(&self, twice: usize) -> Bounds {
        let j = twice as i64;
        Bounds {
            three_term: 0.5 * self.reduced(twice, 1.0)[1].norm(),
            second_order: self.second_order(twice),
            printed: self.printed(twice),
            determinant: self.summit(twice)[1].max(0.0),
            without_mean: 0.5 * self.element(j, [j, -j], 1.0).norm(),
        }
    }

    /// The speed ratios η of the border of the order j = `twice`/2 at the damping ratio θ, (9) or (13); the upper one is
    /// infinite in an open tongue. None if it has no roots around j η = 1.
    pub fn borders(&self, twice: usize, theta: f64) -> Option<[f64; 2]> {
        let [summit, highest] = self.summit(twice);
        let excess = highest - theta;
        if excess.is_nan() || excess <= 0.0 {
            return None;
        }
        let mut f = |x: f64| self.damping(twice, x) - theta;
        let mut end = |factor: f64| {
            let outside = (1..=40).map(|i| summit * f64::powi(factor, i)).find(|x| f(*x) < 0.0)?;
            let value = f(outside);
            Some(search::zero(&mut f, [summit, outside], [excess, value], 0.0).sqrt() * 2.0 / twice as f64)
        };
        Some([end(0.5)?, end(2.0).unwrap_or(f64::INFINITY)])
    }

    /// x and θ at the top of the border: η = √x/j.
    pub fn summit(&self, twice: usize) -> [f64; 2] {
        search::maximum(&mut |x| self.damping(twice, x), NEAR, TOLERANCE).into()
    }

    /// θ on the border at x = j²η²; negative if no damping is needed.
    fn damping(&self, twice: usize, x: f64) -> f64 {
        let [e, f] = self.reduced(twice, x);
        let square = f.norm_sqr() - e.re * e.re;
        (square.abs().sqrt().copysign(square) - e.im) / (2.0 * x.sqrt())
    }

    /// E and F at x = j²η².
    fn reduced(&self, twice: usize, x: f64) -> [Complex; 2] {
        let j = twice as i64;
        let element = |n: i64, l: i64| self.element(j, [n, l], x);
        let through = |l: i64| if twice.is_multiple_of(2) { element(j, 0) * element(0, l) } else { Complex::default() };
        [j, -j].map(|l| element(j, l) - through(l))
    }

    /// H_{nl} over c₀ at x = j²η². Orders are counted in halves, so those of half-integer j are whole numbers.
    fn element(&self, j: i64, [n, l]: [i64; 2], x: f64) -> Complex {
        let square = |n: i64| (n as f64 / j as f64).powi(2);
        let waves = if self.turning { 0.5 * (square(n) + square(l)) } else { square(l) };
        let k = (n - l) / 2;
        coefficient(&self.c, k) - coefficient(&self.m, k) * (x * waves)
    }

    fn printed(&self, twice: usize) -> f64 {
        let [m, c] = [&self.m, &self.c].map(|list| move |k: usize| 2.0 * coefficient(list, k as i64));
        // A harmonic is r − i s of r cos and s sin.
        let (mut cosine, mut sine) = ((m(twice) - c(twice)).re.abs(), -c(twice).im);
        if twice.is_multiple_of(2) {
            let (m, r) = (m(twice / 2), c(twice / 2));
            cosine += 0.5 * (0.5 * m.re - r.re).powi(2);
            sine += 0.5 * r.im * r.im;
        }
        0.25 * (cosine * cosine + sine * sine).sqrt()
    }

    fn second_order(&self, twice: usize) -> f64 {
        let j = twice as i64;
        let element = |n: i64, l: i64| self.element(j, [n, l], 1.0);
        // H_{jn} vanishes beyond the highest harmonic.
        let reach = 2 * (self.m.len() as i64 - 1);
        let between = (j - reach..=j + reach).step_by(2).filter(|n| n.abs() != j);
        let through = |n: i64| element(j, n) * element(n, -j) / (1.0 - (n as f64 / j as f64).powi(2));
        0.5 * (element(j, -j) - between.map(through).sum::<Complex>()).norm()
    }
}
