//! What is prescribed over a range: a polynomial and motion laws, as functions of the angle from its beginning.

use camdrive::motion::MotionLaw;
use camdrive::numerics::double_double::Double;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Σ cⱼ xʲ + Σ f L⁽ⁿ⁾(νx + β), x = φ − φ_from (rad).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    coefficients: Vec<f64>,
    parts: Vec<Part>,
}

/// A derivative of a motion law.
#[derive(Clone, Debug, PartialEq)]
struct Part {
    law: Arc<MotionLaw>,
    /// n.
    order: usize,
    /// f.
    factor: f64,
    /// ν.
    rate: f64,
    /// β (rad).
    phase: f64,
}

impl Part {
    fn at(&self, x: f64) -> f64 {
        // A law tells four derivatives; a higher one would only help to find an extreme.
        let values = self.law.at((self.rate * x + self.phase) % TAU).0;
        self.factor * values.get(self.order).copied().unwrap_or(0.0)
    }
}

impl Curve {
    /// Σ cⱼ xʲ.
    pub fn polynomial(coefficients: Vec<f64>) -> Self {
        Curve { coefficients, parts: Vec::new() }
    }

    /// A motion law whose turn is `period` of the angle (rad), at `phase` (rad of its turn) where the range begins.
    pub fn law(law: MotionLaw, period: f64, phase: f64) -> Self {
        let part = Part { law: Arc::new(law), order: 0, factor: 1.0, rate: TAU / period, phase };
        Curve { coefficients: Vec::new(), parts: vec![part] }
    }

    /// The value at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c) + self.of_laws(x)
    }

    fn of_laws(&self, x: f64) -> f64 {
        self.parts.iter().map(|part| part.at(x)).sum()
    }

    /// The value at `x`, that of a polynomial to 30 digits.
    pub fn exactly_at(&self, x: Double) -> Double {
        let zero = Double::default();
        let polynomial = self.coefficients.iter().rev().fold(zero, |sum, c| sum * x + Double::from(*c));
        polynomial + Double::from(self.of_laws(x.hi))
    }

    /// The rounding of the laws' values at `x`.
    pub fn noise(&self, x: f64) -> f64 {
        self.parts.iter().map(|part| f64::EPSILON * part.at(x).abs()).sum()
    }

    /// The derivative.
    pub fn derivative(&self) -> Self {
        let risen = |part: &Part| Part { order: part.order + 1, factor: part.factor * part.rate, ..part.clone() };
        Curve {
            coefficients: self.coefficients.iter().enumerate().skip(1).map(|(j, c)| j as f64 * c).collect(),
            parts: self.parts.iter().map(risen).collect(),
        }
    }

    /// Adds a multiple of another curve.
    pub fn add(&mut self, factor: f64, other: &Curve) {
        let longest = self.coefficients.len().max(other.coefficients.len());
        self.coefficients.resize(longest, 0.0);
        self.coefficients.iter_mut().zip(&other.coefficients).for_each(|(sum, c)| *sum += factor * c);
        self.parts.extend(other.parts.iter().map(|part| Part { factor: factor * part.factor, ..part.clone() }));
    }

    /// The curve in units of `scale`.
    pub fn over(&self, scale: f64) -> Self {
        let mut curve = self.clone();
        curve.coefficients.iter_mut().for_each(|c| *c /= scale);
        curve.parts.iter_mut().for_each(|part| part.factor /= scale);
        curve
    }

    /// The value of a curve that is a constant.
    pub fn constant(&self) -> Option<f64> {
        match (&self.coefficients[..], &self.parts[..]) {
            ([], []) => Some(0.0),
            ([c], []) => Some(*c),
            _ => None,
        }
    }

    /// Whether nothing is added to zero.
    pub fn is_zero(&self) -> bool {
        self.constant() == Some(0.0)
    }

    /// The harmonic order that resolves the laws; 0 of a polynomial.
    pub fn order(&self) -> usize {
        self.parts.iter().map(|part| (part.rate.abs() * part.law.resolution()).ceil() as usize).max().unwrap_or(0)
    }
}
