//! Newton's method for the equations of all stages of a step.

use super::{CAPACITY, STAGES, System};
use crate::numerics::double_double::Double;
use crate::numerics::gauss::{MATRIX, WEIGHTS};
use crate::numerics::lu::Lu;

/// Smaller corrections, relative to the state, may be rounding alone; so may corrections below this many times the rounding error
/// that the state leaves in f, which is more for a component that has all but vanished.
const NEWTON_ROUNDING: f64 = 1e-13;
const ROUNDINGS_OF_F: f64 = 4.0;

/// Newton's matrix δᵢⱼ 1 − h aᵢⱼ Jᵢ for the Fᵢ, factorised, the Jacobians at the stages and the largest |∂fᵢ/∂yⱼ| among them.
pub struct Newton<const N: usize> {
    /// The factors.
    pub lu: Lu<CAPACITY>,
    jacobians: [[[f64; N]; N]; STAGES],
    rates: [[f64; N]; N],
    /// Rounding error of f beyond the rounding of the state.
    own: [f64; N],
    /// Whether a matrix exists.
    pub is_known: bool,
}

impl<const N: usize> Newton<N> {
    /// No matrix yet.
    pub fn unknown() -> Self {
        let jacobians = [[[0.0; N]; N]; STAGES];
        Newton { lu: Lu::empty(), jacobians, rates: [[0.0; N]; N], own: [0.0; N], is_known: false }
    }

    /// Changes of the Fᵢ by the rounding of y of this scale and of f: f changes by ε Σ |∂f/∂y| y and its own rounding, with a sign
    /// that differs from node to node, and Newton's equations pass that on to the Fᵢ.
    pub fn noise(&self, scale: &[f64; N]) -> [f64; N] {
        let mut change = [0.0; CAPACITY];
        for i in 0..STAGES {
            for r in 0..N {
                let rounding: f64 = (0..N).map(|c| self.rates[r][c] * scale[c]).sum();
                let size = f64::EPSILON * rounding + self.own[r];
                change[i * N + r] = if i % 2 == 0 { size } else { -size };
            }
        }
        self.lu.solve(&mut change);
        std::array::from_fn(|r| (0..STAGES).map(|i| change[i * N + r].abs()).fold(0.0, f64::max))
    }

    /// The corrections in a step of length `h`, relative to the `scale`, that may be rounding alone.
    pub fn rounding(&self, scale: &[f64; N], h: f64) -> f64 {
        let noise = self.noise(scale);
        (0..N).map(|c| ROUNDINGS_OF_F * h * noise[c] / scale[c]).fold(NEWTON_ROUNDING, f64::max)
    }

    /// A bound of the rates of the free motion (1/s), from the products ∂fᵢ/∂yⱼ ∂fⱼ/∂yᵢ, which do not depend on the units of the
    /// state.
    pub fn rate(&self) -> f64 {
        let square = |i: usize| (0..N).map(|j| self.rates[i][j] * self.rates[j][i]).sum::<f64>();
        (0..N).map(square).fold(0.0, f64::max).sqrt()
    }

    /// ∂y₁/∂y₀ over a step of length `h`, by Newton's equations.
    pub fn map(&self, h: f64) -> [[f64; N]; N] {
        let mut map = [[0.0; N]; N];
        for c in 0..N {
            let mut change = [0.0; CAPACITY];
            for i in 0..STAGES {
                for r in 0..N {
                    change[i * N + r] = self.jacobians[i][r][c];
                }
            }
            self.lu.solve(&mut change);
            for r in 0..N {
                let sum: f64 = (0..STAGES).map(|i| WEIGHTS[i] * change[i * N + r]).sum();
                map[r][c] = h * sum + if r == c { 1.0 } else { 0.0 };
            }
        }
        map
    }

    /// Makes the matrix of a step of length `h`; None if it is singular or not finite.
    pub fn factorise(
        &mut self,
        system: &impl System<N>,
        h: f64,
        time: impl Fn(usize) -> Double,
        stages: &[[f64; N]; STAGES],
    ) -> Option<()> {
        self.is_known = false;
        self.rates = [[0.0; N]; N];
        for i in 0..STAGES {
            let jacobian = system.jacobian(time(i), &stages[i]);
            self.jacobians[i] = jacobian;
            for r in 0..N {
                let row = &mut self.lu.matrix()[i * N + r];
                for j in 0..STAGES {
                    for c in 0..N {
                        row[j * N + c] = -h * MATRIX[i][j] * jacobian[r][c];
                    }
                }
                row[i * N + r] += 1.0;
                for c in 0..N {
                    self.rates[r][c] = f64::max(self.rates[r][c], jacobian[r][c].abs());
                }
            }
        }
        // It hardly changes within a step, which resolves the motion.
        self.own = system.rounding(time(STAGES / 2), &stages[STAGES / 2]);
        self.lu.factorise(STAGES * N)?;
        self.is_known = true;
        Some(())
    }
}
