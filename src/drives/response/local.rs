//! The motion of the cam about an instant.

use crate::drives::cam_drive::AngleMotion;
use crate::numerics::angle;
use crate::numerics::double_double::{Double, two_product};

/// The highest degree of the motion polynomial.
const DEGREE: usize = 10;

/// φ(t₀ + τ) = Σ angleⱼ τʲ.
pub struct Local {
    pub angle: [f64; DEGREE + 1],
    pub degree: usize,
}

impl Local {
    /// `motion` about `start` (s).
    pub fn of(motion: &AngleMotion, start: Double) -> Self {
        let c = &motion.coefficients;
        let tau = start - Double::from(motion.origin);
        let degree = motion.degree;
        let mut angle = [0.0; DEGREE + 1];
        if tau.hi == 0.0 {
            let mut factorial = 1.0;
            for (j, d) in angle.iter_mut().enumerate().take(degree + 1) {
                *d = c[j] / factorial;
                factorial *= (j + 1) as f64;
            }
            angle[0] = angle::reduce(Double::from(c[0]));
            return Local { angle, degree };
        }
        for (order, d) in angle.iter_mut().enumerate().take(degree + 1).skip(1) {
            for j in (order..=degree).rev() {
                *d = c[j] + *d * tau.hi / (j + 1 - order) as f64;
            }
        }
        let above = (2..=degree).rev().fold(0.0, |above, j| (c[j] + above) * tau.hi / j as f64);
        // φ = c₀ + (c₁ + above) τ, with the care that many turns need.
        let turns = Double::from(c[0]) + Double::from(c[1]) * tau + two_product(above, tau.hi);
        angle[0] = angle::reduce(turns);
        let mut factorial = 1.0;
        for (j, d) in angle.iter_mut().enumerate().skip(1) {
            factorial *= j as f64;
            *d /= factorial;
        }
        Local { angle, degree }
    }

    /// φ, w, a at τ.
    pub fn at(&self, tau: f64) -> [f64; 3] {
        let [mut phi, mut w, mut half] = [0.0; 3];
        for c in self.angle[..=self.degree].iter().rev() {
            half = half * tau + w;
            w = w * tau + phi;
            phi = phi * tau + c;
        }
        [phi, w, 2.0 * half]
    }

    /// Whether the angle first grows.
    pub fn forward(&self) -> bool {
        self.angle[1..].iter().find(|c| **c != 0.0).is_none_or(|c| *c > 0.0)
    }

    /// angleⱼ Lʲ: the coefficients on [0, 1].
    pub fn scaled(&self, length: f64) -> [f64; DEGREE + 1] {
        let mut power = 1.0;
        self.angle.map(|c| {
            let scaled = if c == 0.0 { 0.0 } else { c * power };
            power *= length;
            scaled
        })
    }

    /// A length over which φ changes by no more than `span`: each term contributes its share.
    pub fn length_for(&self, span: f64) -> f64 {
        let share = span / self.degree as f64;
        let mut length = f64::INFINITY;
        for (j, c) in self.angle.iter().enumerate().skip(1).filter(|(_, c)| **c != 0.0) {
            length = length.min((share / c.abs()).powf(1.0 / j as f64));
        }
        length
    }

    /// A bound of |w| on [0, `length`].
    pub fn speed(&self, length: f64) -> f64 {
        (1..=self.degree).rev().fold(0.0, |sum, j| sum * length + j as f64 * self.angle[j].abs())
    }

    /// A bound of |a| on [0, `length`].
    pub fn acceleration(&self, length: f64) -> f64 {
        (2..=self.degree).rev().fold(0.0, |sum, j| sum * length + (j * (j - 1)) as f64 * self.angle[j].abs())
    }
}
