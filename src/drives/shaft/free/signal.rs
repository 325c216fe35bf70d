//! An input as a polynomial of time over a communication step.

use crate::drives::shaft::cam_drive::MAX_INPUT_DERIVATIVE;
use crate::numerics::taylor::Series;
use serde::{Deserialize, Serialize};

/// v(t) = Σ vⱼ (t − t₀)ʲ / j! over the step that starts at t₀. After the step its end value stands until a new value is set or the
/// next step begins; then the set value holds again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Signal {
    value: f64,
    derivatives: [f64; MAX_INPUT_DERIVATIVE],
    /// Whether one of v₁ … is not zero.
    varies: bool,
    /// The time since t₀ (s); positive after the step.
    elapsed: f64,
}

impl Signal {
    /// v₀ as set.
    pub fn set_value(&self) -> f64 {
        self.value
    }

    /// v₁ as set.
    pub fn set_rate(&self) -> f64 {
        self.derivatives[0]
    }

    /// Sets v₀ and forgets its derivatives, which belong to the previous value.
    pub fn set(&mut self, value: f64) {
        *self = Signal { value, ..Signal::default() };
    }

    /// Sets vⱼ, j = `order` ∈ 1 … [`MAX_INPUT_DERIVATIVE`], for the next step; j = 0 as [`Signal::set`].
    pub fn set_derivative(&mut self, order: usize, value: f64) {
        let Some(j) = order.checked_sub(1) else { return self.set(value) };
        self.step_begins();
        self.derivatives[j] = value;
        self.varies = self.derivatives.iter().any(|d| *d != 0.0);
    }

    /// Whether v does not depend on time.
    pub fn is_constant(&self) -> bool {
        !self.varies
    }

    /// Forgets the derivatives of the previous step.
    pub fn step_begins(&mut self) {
        if self.elapsed > 0.0 && self.varies {
            self.set(self.value);
        }
        self.elapsed = 0.0;
    }

    /// Ends a step of `step` (s).
    pub fn step_ends(&mut self, step: f64) {
        self.elapsed = step;
    }

    /// v at t₀ + `t`.
    pub fn at(&self, t: f64) -> f64 {
        if !self.varies {
            return self.value;
        }
        let above = (1..=MAX_INPUT_DERIVATIVE).rev().fold(0.0, |sum, j| (self.derivatives[j - 1] + sum) * t / j as f64);
        self.value + above
    }

    /// The coefficients of v about t₀ + `t` in this `unit` of time.
    pub fn expand(&self, t: f64, unit: f64, row: &mut [f64]) {
        row.fill(0.0);
        self.add_expanded(t, unit, row);
    }

    /// Adds these coefficients.
    pub fn add_expanded(&self, t: f64, unit: f64, row: &mut [f64]) {
        row[0] += self.at(t);
        let mut factor = 1.0;
        for order in 1..=if self.varies { MAX_INPUT_DERIVATIVE.min(row.len() - 1) } else { 0 } {
            factor *= unit / order as f64;
            let sum = |sum, j: usize| self.derivatives[j - 1] + sum * t / (j + 1 - order) as f64;
            row[order] += factor * (order..=MAX_INPUT_DERIVATIVE).rev().fold(0.0, sum);
        }
    }

    /// Whether both are set to the same polynomial.
    pub fn is_like(&self, other: &Self) -> bool {
        let varies = self.varies || other.varies;
        self.value == other.value && !(varies && self.derivatives != other.derivatives)
    }

    /// The time since t₀ (s).
    pub fn elapsed(&self) -> f64 {
        self.elapsed
    }

    /// The present value of v.
    pub fn now(&self) -> f64 {
        self.at(self.elapsed)
    }

    /// The series of v in time, now.
    pub fn series(&self) -> Series {
        let derivative = |order: usize| {
            (order..=MAX_INPUT_DERIVATIVE)
                .rev()
                .fold(0.0, |sum, j| self.derivatives[j - 1] + sum * self.elapsed / (j + 1 - order) as f64)
        };
        Series::from_derivatives(self.now(), derivative(1), derivative(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_signal_is_the_polynomial_of_its_derivatives() {
        // v = 1 + 2t + 3t²: v₁ = 2, v₂ = 6.
        let mut v = Signal::default();
        v.set(1.0);
        v.set_derivative(1, 2.0);
        v.set_derivative(2, 6.0);
        assert_eq!(v.at(2.0), 17.0);
        v.step_ends(2.0);
        assert_eq!([0, 1, 2].map(|n| v.series().derivative(n)), [17.0, 14.0, 6.0]);
        v.step_begins();
        assert_eq!(v.at(2.0), 1.0);
    }
}
