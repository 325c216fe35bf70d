//! The motion of a prescribed shaft about an instant.

use super::cam_drive::AngleMotion;
use crate::numerics::double_double::Double;

/// The highest degree of the motion polynomial.
const DEGREE: usize = 10;

/// φ(t₀ + τ) = Σ angleⱼ τʲ.
pub struct AngleSeries {
    pub angle: [f64; DEGREE + 1],
    pub degree: usize,
}

impl AngleSeries {
    /// `motion` about `start` (s).
    pub fn of(motion: &AngleMotion, start: Double) -> Self {
        let mut angle = motion.derivatives((start - Double::from(motion.origin)).hi);
        angle[0] = motion.at_instant(start).reduced;
        let mut factorial = 1.0;
        for (j, d) in angle.iter_mut().enumerate().skip(1) {
            factorial *= j as f64;
            *d /= factorial;
        }
        AngleSeries { angle, degree: motion.degree }
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
