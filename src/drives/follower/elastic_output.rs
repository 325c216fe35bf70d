//! A mass behind a spring and a damper whose other end a cam moves by x = U(φ(t)):
//!
//! m ÿ = −(c q + b q̇), y = x + q, hence q̈ + 2δ q̇ + ω₀² q = −ẍ with ω₀² = c/m, 2δ = b/m.
//!
//! Symbols: m mass (kg), c stiffness (N/m), b damping (N·s/m), q deformation (m). Signs: the force −(c q + b q̇) acts on the
//! mass, positive in the sense of y.
//!
//! What stands on the right is linear in x, so that the solvers take it from here for whatever they are made of: values,
//! series, amplitudes of harmonics, coefficients of polynomials.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.2, equations (1) to (4).

use crate::motion::Fourier;
use crate::numerics::double_double::two_product;
use crate::numerics::oscillator::Oscillator;
use crate::numerics::taylor::Scalar;
use serde::{Deserialize, Serialize};

/// The equation with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Equation {
    /// m, c, b.
    pub parameters: [f64; 3],
    /// The left side, divided by m.
    pub oscillator: Oscillator,
}

impl Equation {
    /// The equation with m, c, b.
    pub fn new([m, c, b]: [f64; 3]) -> Self {
        Equation { parameters: [m, c, b], oscillator: Oscillator::of_mass(m, c, b) }
    }

    /// The right side (m/s²) where the cam has x, ẋ, ẍ.
    #[inline(always)]
    pub fn forcing<S: Scalar>(&self, [_, _, x2]: [S; 3]) -> S {
        -x2
    }

    /// The same of a harmonic: F of Re[F e^(iψ)] where x = Re[X e^(iψ)], X = `x`, ψ̇ = `nu` (rad/s).
    pub fn forcing_of_harmonic(&self, [re, im]: [f64; 2], nu: f64) -> [f64; 2] {
        [[re, -nu * im, -nu * nu * re], [im, nu * re, -nu * nu * im]].map(|x| self.forcing(x))
    }

    /// q̈ at q, q̇ where the cam has x, ẋ, ẍ.
    #[inline(always)]
    pub fn acceleration<S: Scalar>(&self, [q, v]: [S; 2], x: [S; 3]) -> S {
        self.forcing(x) - q * self.oscillator.stiffness() - v * (2.0 * self.oscillator.damping())
    }

    /// The force on the mass (N).
    #[inline(always)]
    pub fn force<S: Scalar>(&self, [q, v]: [S; 2]) -> S {
        let [_, c, b] = self.parameters;
        -(q * c + v * b)
    }

    /// q, q̇ of the periodic motion where a cam with this law turns at `w` and stands at `phi` (rad): the sum of the responses to
    /// its harmonics. Else the first one whose relative impedance is below `least`: at a resonance.
    pub fn periodic(&self, law: &Fourier, w: f64, phi: f64, least: f64) -> Result<[f64; 2], usize> {
        let sense = w.signum();
        let mut sum = [0.0; 2];
        for k in (1..=law.order()).filter(|&k| law.a[k] != 0.0 || law.b[k] != 0.0) {
            let nu = two_product(k as f64, w.abs());
            // What is no number is no impedance either.
            if !(self.oscillator.relative_impedance(nu) >= least) {
                return Err(k);
            }
            // ψ = kφ sgn w grows: a cam that turns back sees the other sign of sines.
            let force = self.forcing_of_harmonic([law.a[k], -sense * law.b[k]], nu.hi);
            let [re, im] = self.oscillator.steady(force, nu);
            let (s, c) = (k as f64 * phi * sense).sin_cos();
            sum = [sum[0] + re * c - im * s, sum[1] - nu.hi * (re * s + im * c)];
        }
        Ok(sum)
    }
}
