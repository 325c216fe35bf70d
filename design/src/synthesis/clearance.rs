//! Two tools on straight lines, and what of their distance is linear about two motions.
//!
//! d = d₀ + Uₐ eₐ − U_b e_b leads from tool b to tool a, |d| ≥ r at all angles. With v = d/|d| of other motions the condition
//! vᵀd ≥ r is linear and stricter.

use super::deviation::Extreme;
use super::sampling::{FINE, angles};
use crate::search::local_maxima;
use camdrive::motion::Fourier;
use std::f64::consts::TAU;

/// Two tools and their distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// a and b, from 0.
    pub laws: [usize; 2],
    /// d₀, from tool b to tool a where both U are zero (m).
    pub offset: [f64; 2],
    /// The angles of eₐ and e_b (rad).
    pub directions: [f64; 2],
    /// r (m).
    pub distance: f64,
}

/// The linear condition that is made of a clearance about two motions.
#[derive(Clone, Debug)]
pub struct Tangent {
    /// The tools.
    pub clearance: Clearance,
    /// Uₐ and U_b.
    pub motions: [Fourier; 2],
    /// Added to d before its direction is taken.
    pub shift: [f64; 2],
}

impl Clearance {
    /// In units of `scale`.
    pub fn over(&self, scale: f64) -> Self {
        let (offset, distance) = (self.offset.map(|d| d / scale), self.distance / scale);
        Clearance { offset, distance, ..*self }
    }

    /// d.
    fn between(&self, u: [f64; 2]) -> [f64; 2] {
        let [a, b] = self.directions.map(|angle| <[f64; 2]>::from(angle.sin_cos()));
        [self.offset[0] + u[0] * a[1] - u[1] * b[1], self.offset[1] + u[0] * a[0] - u[1] * b[0]]
    }

    /// d of two motions.
    pub fn at(&self, motions: &[Fourier; 2], phi: f64) -> [f64; 2] {
        self.between([0, 1].map(|i| motions[i].at(phi).0[0]))
    }

    /// |d| of two motions (m).
    pub fn apart(&self, motions: &[Fourier; 2], phi: f64) -> f64 {
        let [x, y] = self.at(motions, phi);
        x.hypot(y)
    }

    /// The least distance over the turn, and its angle; the motions belong to tools a and b.
    pub fn least(&self, motions: &[Fourier; 2]) -> Extreme {
        let order = motions.iter().map(Fourier::order).max().unwrap_or(0);
        let near = |phi: f64| -self.apart(motions, phi);
        let places = local_maxima(&angles(0.0, TAU, 2 * order, FINE), f64::NEG_INFINITY, &near);
        let extremes = places.into_iter().map(|phi| Extreme { value: -near(phi), phi });
        extremes.min_by(|a, b| a.value.total_cmp(&b.value)).unwrap_or(Extreme { value: 0.0, phi: 0.0 })
    }
}

impl Tangent {
    /// v; anything where d vanishes.
    fn normal(&self, phi: f64) -> [f64; 2] {
        let [x, y] = self.clearance.at(&self.motions, phi);
        let [x, y] = [x + self.shift[0], y + self.shift[1]];
        let size = x.hypot(y);
        if size > 0.0 { [x / size, y / size] } else { [1.0, 0.0] }
    }

    /// −vᵀ(Uₐ eₐ − U_b e_b): laws and factors.
    pub fn terms(&self, phi: f64) -> [(usize, f64); 2] {
        let [x, y] = self.normal(phi);
        let along = |angle: f64| x * angle.cos() + y * angle.sin();
        let [a, b] = self.clearance.directions.map(along);
        let [law_a, law_b] = self.clearance.laws;
        [(law_a, -a), (law_b, b)]
    }

    /// vᵀd₀.
    pub fn target(&self, phi: f64) -> f64 {
        let ([x, y], [p, q]) = (self.normal(phi), self.clearance.offset);
        x * p + y * q
    }
}
