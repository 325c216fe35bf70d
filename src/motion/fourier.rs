//! Harmonic profiles: finite Fourier series.

use super::TransferFunctions;
use crate::numerics::pair::Pair;
use crate::numerics::phase::sin_cos;
use serde::{Deserialize, Serialize};

/// The highest harmonic of a scene: beyond it the FMU would have more than 500 variables for the cam alone.
pub const HIGHEST_HARMONIC: usize = 256;

/// U(φ) = a₀ + Σ aₖ cos kφ + bₖ sin kφ, k = 1 … K.
///
/// Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.2 (HS profiles).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Coefficients")]
pub struct Fourier {
    /// a₀ … a_K (m).
    pub a: Vec<f64>,
    /// b₀ … b_K (m); b₀ has no meaning and is zero. As long as `a`.
    pub b: Vec<f64>,
}

/// Coefficients as in a file, of any lengths.
#[derive(Deserialize)]
struct Coefficients {
    a: Vec<f64>,
    b: Vec<f64>,
}

/// 1/((n + 1)(n + 2)) for n = 2i and 2i + 1.
const RECIPROCALS: [[f64; 2]; 16] = {
    let mut table = [[0.0; 2]; 16];
    let mut i = 0;
    while i < 16 {
        let n = 2.0 * i as f64;
        table[i] = [1.0 / ((n + 1.0) * (n + 2.0)), 1.0 / ((n + 2.0) * (n + 3.0))];
        i += 1;
    }
    table
};

impl From<Coefficients> for Fourier {
    fn from(Coefficients { a, b }: Coefficients) -> Self {
        Fourier::new(a, b)
    }
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

    /// The coefficient with this index in the list a₀ … a_K, b₁ … b_K, to change it; None beyond the list.
    pub fn coefficient_mut(&mut self, index: usize) -> Option<&mut f64> {
        let n = self.a.len();
        if index < n { self.a.get_mut(index) } else { self.b.get_mut(index + 1 - n) }
    }

    /// Reads the coefficient.
    pub fn coefficient(&self, index: usize) -> Option<f64> {
        let n = self.a.len();
        let coefficient = if index < n { self.a.get(index) } else { self.b.get(index + 1 - n) };
        coefficient.copied()
    }

    /// `factor` · U.
    pub fn scaled(&self, factor: f64) -> Self {
        let scaled = |list: &[f64]| list.iter().map(|c| factor * c).collect();
        Fourier { a: scaled(&self.a), b: scaled(&self.b) }
    }

    /// U(φ − `angle`), the law delayed by `angle` (rad).
    pub fn delayed(&self, angle: f64) -> Self {
        let mut delayed = self.clone();
        for k in 1..self.a.len() {
            let (sin, cos) = (k as f64 * angle).sin_cos();
            delayed.a[k] = self.a[k] * cos - self.b[k] * sin;
            delayed.b[k] = self.a[k] * sin + self.b[k] * cos;
        }
        delayed
    }

    /// U … U⁗ at `phi`, error a few ulp of Σ kⁿ |cₖ|.
    pub fn at(&self, phi: f64) -> TransferFunctions {
        let [[u0, u1], [u2, u3], [u4, _]] = self.derivatives(phi).map(Pair::array);
        TransferFunctions([u0, u1, u2, u3, u4])
    }

    /// U, U′, U″ … at `phi`, an even and an odd order side by side.
    #[inline]
    pub fn derivatives<const PAIRS: usize>(&self, phi: f64) -> [Pair; PAIRS] {
        let [s1, c1] = sin_cos(phi);
        let (mut s, mut c, mut k) = (s1, c1, 1.0);
        let mut u = [Pair::default(); PAIRS];
        u[0] = Pair::new(self.a[0], 0.0);
        // Cheaper than skipping the first of the pairs.
        let (of_cosines, of_sines) = (&self.a[1..], &self.b[1..]);
        for (a, b) in of_cosines.iter().zip(of_sines) {
            // Half-wave symmetric laws have only every other harmonic.
            if *a != 0.0 || *b != 0.0 {
                let mut pair = Pair::new(a * c + b * s, k * (b * c - a * s));
                for u in &mut u {
                    *u = *u + pair;
                    pair = pair * Pair::both(-(k * k));
                }
            }
            (s, c, k) = (s * c1 + c * s1, c * c1 - s * s1, k + 1.0);
        }
        u
    }

    /// U′ at sin φ = `s1` and cos φ = `c1`, for several series at one angle.
    pub fn slope(&self, s1: f64, c1: f64) -> f64 {
        let (mut s, mut c, mut slope) = (0.0, 1.0, 0.0);
        for (k, (a, b)) in self.a.iter().zip(&self.b).enumerate().skip(1) {
            (s, c) = (s * c1 + c * s1, c * c1 - s * s1);
            slope += k as f64 * (b * c - a * s);
        }
        slope
    }

    /// The Taylor coefficients about `phi`; see [`super::MotionLaw::expand`].
    pub fn expand(&self, phi: f64, step: f64, coefficients: &mut [f64]) {
        let mut sums = [[0.0; 2]; RECIPROCALS.len()];
        sums[0][0] = self.a[0];
        let (s1, c1) = phi.sin_cos();
        let (mut s, mut c, mut k) = (s1, c1, 1.0);
        for (a, b) in self.a[1..].iter().zip(&self.b[1..]) {
            if *a != 0.0 || *b != 0.0 {
                let rate = k * step;
                // The terms of even and of odd order, each from the previous one. All terms are computed, since the compiler then
                // knows their number.
                let mut term = [a * c + b * s, rate * (b * c - a * s)];
                let square = -rate * rate;
                for (sum, reciprocals) in sums.iter_mut().zip(&RECIPROCALS) {
                    for i in 0..2 {
                        sum[i] += term[i];
                        term[i] *= square * reciprocals[i];
                    }
                }
            }
            (s, c, k) = (s * c1 + c * s1, c * c1 - s * s1, k + 1.0);
        }
        coefficients.copy_from_slice(&sums.as_flattened()[..coefficients.len()]);
    }

    /// Σ kⁿ √(aₖ² + bₖ²) ≥ |U⁽ⁿ⁾|, with |a₀| for n = 0.
    pub fn bound(&self, order: usize) -> f64 {
        let constant = if order == 0 { self.a[0].abs() } else { 0.0 };
        let amplitude = |k: usize| (self.a[k] * self.a[k] + self.b[k] * self.b[k]).sqrt();
        constant + (1..self.a.len()).map(|k| (k as f64).powi(order as i32) * amplitude(k)).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series() -> Fourier {
        let a = (0..=12).map(|k| 1.0 / f64::from(1 + k * k)).collect();
        let b = (0..=12).map(|k| f64::from(k - 5) / f64::from(1 + k * k * k)).collect();
        Fourier::new(a, b)
    }

    #[test]
    fn the_recurrence_gives_the_direct_sums() {
        let series = series();
        for i in 0..200 {
            let phi = -6.3 + 12.6 * f64::from(i) / 199.0;
            let u = series.at(phi).0;
            for n in 0..5 {
                // cos⁽ⁿ⁾ x = cos(x + nπ/2): (cos, −sin, −cos, sin) in turn.
                let direct: f64 = (0..13)
                    .map(|k| {
                        let (s, c) = (k as f64 * phi).sin_cos();
                        let (c, s) = [(c, s), (-s, c), (-c, -s), (s, -c)][n % 4];
                        (k as f64).powi(n as i32) * (series.a[k] * c + series.b[k] * s)
                    })
                    .sum();
                assert!((u[n] - direct).abs() < 4e-15 * series.bound(n), "{phi} order {n}");
                assert!(u[n].abs() <= series.bound(n));
                let [s1, c1] = sin_cos(phi);
                assert!(n != 1 || u[n] == series.slope(s1, c1));
            }
        }
    }

    #[test]
    fn scaling_and_delay_act_on_the_law() {
        let series = series();
        for phi in [-3.0, 0.2, 2.5] {
            for n in 0..5 {
                let u = |series: &Fourier, phi: f64| series.at(phi).0[n];
                assert!((u(&series.scaled(-0.3), phi) + 0.3 * u(&series, phi)).abs() < 1e-15 * series.bound(n));
                assert!((u(&series.delayed(0.7), phi) - u(&series, phi - 0.7)).abs() < 4e-15 * series.bound(n));
            }
        }
    }

    #[test]
    fn lists_of_unequal_lengths_are_filled_up() {
        let series: Fourier = serde_json::from_str(r#"{"a": [], "b": [7.0, 1.0]}"#).unwrap();
        assert_eq!(series, Fourier { a: vec![0.0, 0.0], b: vec![0.0, 1.0] });
    }
}
