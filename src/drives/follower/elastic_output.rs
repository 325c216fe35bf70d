//! A mass on a spring and a damper whose other end a cam moves by x = U(φ(t)):
//!
//! m ÿ = −(c q + b q̇), y = x + q, hence q̈ + 2δ q̇ + ω₀² q = −ẍ with ω₀² = c/m, 2δ = b/m.
//!
//! A spring c_r and a damper b_r between mass and ground add to both sides, ω₀² = (c + c_r)/m, 2δ = (b + b_r)/m:
//!
//! q̈ + 2δ q̇ + ω₀² q = −ẍ − (b_r/m) ẋ − (c_r/m) x.
//!
//! A force P(φ) adds the motion of the same left side with P/m on the right. The constant loads and the input force do the same.
//!
//! Symbols: m mass (kg), c stiffness (N/m), b damping (N·s/m), q deformation (m). Signs: the force −(c q + b q̇) acts on the
//! mass, positive in the sense of y.
//!
//! The right side is linear in x, so the solvers use it for values, series, amplitudes of harmonics and coefficients of polynomials
//! alike.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.2, equations (1) to (4).

use super::load::Load;
use crate::drives::parameter::parameters;
use crate::motion::Fourier;
use crate::numerics::double_double::{Double, two_product, two_sum};
use crate::numerics::oscillator::Oscillator;
use crate::numerics::taylor::Scalar;
use serde::{Deserialize, Serialize};

parameters! {
    // Twelve decades to either side of 1 kg; stiffness and damping reach as far from 1 N/m and 1 N·s/m as natural frequencies can
    // still be squared.
    /// Mass and spring.
    Parameters, "elasticity" {
        /// Mass of the output member
        m = "m", "m", MASS in [1e-12, 1e12], Tunable;
        /// Stiffness between cam and mass
        c = "c", "c", STIFFNESS in [0.0, 1e24], Tunable;
        /// Damping between cam and mass
        b = "b", "b", DAMPING in [0.0, 1e24] or 0.0, Tunable;
    }
}

/// The equation with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Equation {
    /// m, c, b.
    pub parameters: [f64; 3],
    /// The left side, divided by m.
    pub oscillator: Oscillator,
    /// The factors of x, ẋ, ẍ on the right, unless they are 0, 0, −1.
    pub weights: Option<[f64; 3]>,
}

impl Parameters {
    /// The equation with these numbers.
    pub fn equation(&self) -> Equation {
        Equation::new([self.m, self.c, self.b])
    }
}

impl Equation {
    /// The equation with m, c, b.
    pub fn new([m, c, b]: [f64; 3]) -> Self {
        Equation { parameters: [m, c, b], oscillator: Oscillator::of_mass(m, c, b), weights: None }
    }

    /// The equation with the spring and the damper of a load on the mass.
    pub fn under(self, load: &Load) -> Self {
        if load.spring.is_none() && load.damping.is_none() {
            return self;
        }
        let ([m, c, b], c_r, b_r) = (self.parameters, load.stiffness(), load.damping.unwrap_or(0.0));
        let [stiffness, damping] =
            [(two_sum(c, c_r), m), (two_sum(b, b_r), 2.0 * m)].map(|(x, m)| x.divide(Double::from(m)));
        let oscillator = Oscillator::new(stiffness, damping);
        Equation { oscillator, weights: Some([-c_r / m, -b_r / m, -1.0]), ..self }
    }

    /// The equation of the motion that a force adds; the force replaces x.
    pub fn of_force(self) -> Self {
        Equation { weights: Some([1.0 / self.parameters[0], 0.0, 0.0]), ..self }
    }

    /// The right side (m/s²) for the cam's x, ẋ, ẍ.
    #[inline(always)]
    pub fn forcing<S: Scalar>(&self, [x, x1, x2]: [S; 3]) -> S {
        match self.weights {
            None => -x2,
            Some([k, k1, k2]) => x2 * k2 + x1 * k1 + x * k,
        }
    }

    /// A bound of the right side for bounds of U, U′, U″, ω and α.
    pub fn bound(&self, [u, slope, curvature]: [f64; 3], [speed, acceleration]: [f64; 2]) -> f64 {
        let x2 = curvature * speed * speed + slope * acceleration;
        let weighed = |[k, k1, k2]: [f64; 3]| k2.abs() * x2 + k1.abs() * (slope * speed) + k.abs() * u;
        self.weights.map_or(x2, weighed)
    }

    /// The factor of ẍ on the right.
    pub fn of_acceleration(&self) -> f64 {
        self.weights.map_or(-1.0, |[_, _, k2]| k2)
    }

    /// q for a resting cam at this x; the equation must have a stiffness.
    pub fn at_rest(&self, x: f64) -> f64 {
        self.weights.map_or(0.0, |_| self.forcing([x, 0.0, 0.0]) / self.oscillator.stiffness())
    }

    /// The right side of a harmonic: F of Re[F e^(iψ)] for x = Re[X e^(iψ)], X = `x`, ψ̇ = `nu` (rad/s).
    pub fn forcing_of_harmonic(&self, [re, im]: [f64; 2], nu: f64) -> [f64; 2] {
        [[re, -nu * im, -nu * nu * re], [im, nu * re, -nu * nu * im]].map(|x| self.forcing(x))
    }

    /// q̈ at q, q̇ for the cam's x, ẋ, ẍ.
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

    /// q, q̇ of the periodic motion under a cam with this law that turns at `w` and stands at `phi` (rad): the sum of the responses
    /// to its harmonics. At a resonance it returns the first harmonic whose relative impedance is below `least`.
    pub fn periodic(&self, law: &Fourier, w: f64, phi: f64, least: f64) -> Result<[f64; 2], usize> {
        let sense = w.signum();
        let mut sum = [self.at_rest(law.a[0]), 0.0];
        for k in (1..=law.order()).filter(|&k| law.a[k] != 0.0 || law.b[k] != 0.0) {
            let nu = two_product(k as f64, w.abs());
            // NaN is no impedance.
            if !(self.oscillator.relative_impedance(nu) >= least) {
                return Err(k);
            }
            // ψ = kφ sgn w grows: a cam that turns backwards reverses the sign of the sines.
            let force = self.forcing_of_harmonic([law.a[k], -sense * law.b[k]], nu.hi);
            let [re, im] = self.oscillator.steady(force, nu);
            let (s, c) = (k as f64 * phi * sense).sin_cos();
            sum = [sum[0] + re * c - im * s, sum[1] - nu.hi * (re * s + im * c)];
        }
        Ok(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::difference::derivative;
    use std::convert::Infallible;

    #[test]
    fn force_and_acceleration_are_those_of_the_equation() {
        // m = 2, c = 8, b = 4: ω₀² = 4, 2δ = 2.
        let equation = Equation::new([2.0, 8.0, 4.0]);
        assert_eq!(equation.force([3.0, 5.0]), -44.0);
        assert_eq!(equation.forcing([11.0, 13.0, 7.0]), -7.0);
        assert_eq!(equation.acceleration([3.0, 5.0], [11.0, 13.0, 7.0]), -29.0);
        assert_eq!(equation.forcing_of_harmonic([2.0, -3.0], 5.0), [50.0, -75.0]);
    }

    #[test]
    fn the_periodic_motion_satisfies_the_equation() {
        let law = Fourier::new(vec![0.1, 0.01, 0.0, 2e-3], vec![0.0, 0.0, 3e-3, -4e-3]);
        let equation = Equation::new([0.5, 800.0, 2.0]);
        for w in [17.0, -17.0] {
            for phi in [0.0, 1.3, 4.0] {
                let at = |phi: f64| equation.periodic(&law, w, phi, 1e-9).unwrap();
                let rate = |i: usize| {
                    let of = |phi: f64| Ok::<_, Infallible>(at(phi)[i]);
                    let Ok(slope) = derivative(of, phi, 0.1, [f64::NEG_INFINITY, f64::INFINITY]);
                    w * slope
                };
                // x = Σ aₖ cos kφ + bₖ sin kφ.
                let x2: f64 = (1..=3)
                    .map(|k| {
                        let (s, c) = (k as f64 * phi).sin_cos();
                        -(k as f64 * w).powi(2) * (law.a[k] * c + law.b[k] * s)
                    })
                    .sum();
                let [q, v] = at(phi);
                let acceleration = equation.acceleration([q, v], [0.0, 0.0, x2]);
                assert!((rate(0) - v).abs() < 1e-10, "{w} {phi}: {} {v}", rate(0));
                assert!((rate(1) - acceleration).abs() < 1e-8, "{w} {phi}: {} {acceleration}", rate(1));
            }
        }
    }

    #[test]
    fn a_harmonic_on_the_resonance_is_told() {
        // ω₀ = 40 1/s: the second harmonic at w = 20 rad/s.
        let equation = Equation::new([0.5, 800.0, 0.0]);
        let told = |a2: f64, b2: f64, w: f64| {
            let law = Fourier::new(vec![0.0, 0.01, a2], vec![0.0, 0.0, b2]);
            equation.periodic(&law, w, 1.0, 1e-9).err()
        };
        assert_eq!([told(1e-3, 0.0, 20.0), told(0.0, 1e-3, -20.0), told(1e-3, 1e-3, 20.0)], [Some(2); 3]);
        assert_eq!([told(0.0, 0.0, 20.0), told(1e-3, 1e-3, 20.1), told(1e-3, 1e-3, f64::NAN)], [None, None, Some(1)]);
    }
}
