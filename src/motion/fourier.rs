//! Harmonic profiles: finite Fourier series.

use super::TransferFunctions;
use serde::{Deserialize, Serialize};

/// U(φ) = a₀ + Σ aₖ cos kφ + bₖ sin kφ, k = 1 … K.
///
/// Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.2 (HS profiles).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fourier {
    /// a₀ … a_K [m].
    pub a: Vec<f64>,
    /// b₀ … b_K [m]; b₀ has no meaning and is zero. As long as `a`.
    pub b: Vec<f64>,
}

impl Fourier {
    /// The series with these cosine and sine coefficients, the shorter list filled up with zeros.
    pub fn new(mut a: Vec<f64>, mut b: Vec<f64>) -> Self {
        let n = a.len().max(b.len()).max(1);
        a.resize(n, 0.0);
        b.resize(n, 0.0);
        b[0] = 0.0;
        Fourier { a, b }
    }

    /// The highest harmonic K.
    pub fn order(&self) -> usize {
        self.a.len() - 1
    }

    /// U … U⁗ at `phi`, error a few ulp of Σ kⁿ |cₖ|.
    pub fn at(&self, phi: f64) -> TransferFunctions {
        let (s1, c1) = phi.sin_cos();
        let (mut s, mut c) = (0.0, 1.0);
        let mut u = [self.a[0], 0.0, 0.0, 0.0, 0.0];
        for k in 1..self.a.len() {
            (s, c) = (s * c1 + c * s1, c * c1 - s * s1);
            let (a, b, k) = (self.a[k], self.b[k], k as f64);
            let even = a * c + b * s;
            let odd = k * (b * c - a * s);
            let k2 = k * k;
            u[0] += even;
            u[1] += odd;
            u[2] -= k2 * even;
            u[3] -= k2 * odd;
            u[4] += k2 * k2 * even;
        }
        TransferFunctions(u)
    }

    /// Σ kⁿ √(aₖ² + bₖ²) ≥ |U⁽ⁿ⁾|, with |a₀| for n = 0.
    pub fn bound(&self, order: usize) -> f64 {
        let constant = if order == 0 { self.a[0].abs() } else { 0.0 };
        constant + (1..self.a.len()).map(|k| (k as f64).powi(order as i32) * self.a[k].hypot(self.b[k])).sum::<f64>()
    }
}
