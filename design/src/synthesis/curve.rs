//! Prescribed curve over a range: a polynomial and motion laws, as functions of the angle from its beginning.

use super::infeasible::degrees;
use crate::text::counted;
use camdrive::motion::MotionLaw;
use camdrive::motion::table::{CLOSING, Points, Table};
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

/// The points at an end of a table from which its derivatives there follow.
const AT_END: usize = 6;

/// They are this part of the table apart, or neighbours: noise of closer ones would grow in the fourth derivative with the fourth
/// power of their number. The polynomial of degree five errs there by some 1e-4 of the greatest U″ of a rise.
const APART: usize = 60;

/// The fewest points of a part of a turn: four pieces.
const LEAST: usize = 5;

/// A piece this many times as long as any other one is a hole, and the last one as steep is a jump.
const HOLE: f64 = 2.0;

/// The distances of neighbours, the last one over the end of the turn.
fn gaps(angles: &[f64], turn: f64) -> Vec<f64> {
    let over_end = angles.first().zip(angles.last()).map(|(first, last)| first + turn - last);
    angles.windows(2).map(|ends| ends[1] - ends[0]).chain(over_end).collect()
}

/// The hole of these distances, if there is one.
fn hole(gaps: &[f64]) -> Option<usize> {
    let longest = (0..gaps.len()).max_by(|i, j| gaps[*i].total_cmp(&gaps[*j]))?;
    (0..gaps.len()).all(|i| i == longest || gaps[longest] > HOLE * gaps[i]).then_some(longest)
}

/// Bₖ₊₁(t)/(k+1)!, k = 0 … 4, of the Bernoulli polynomials, from t⁰ on: their k-th derivatives rise by one from t = 0 to t = 1,
/// and no other one below the fifth differs at the ends.
const BERNOULLI: [[f64; 6]; 5] = [
    [-0.5, 1.0, 0.0, 0.0, 0.0, 0.0],
    [1.0 / 12.0, -0.5, 0.5, 0.0, 0.0, 0.0],
    [0.0, 1.0 / 12.0, -0.25, 1.0 / 6.0, 0.0, 0.0],
    [-1.0 / 720.0, 0.0, 1.0 / 24.0, -1.0 / 12.0, 1.0 / 24.0, 0.0],
    [0.0, -1.0 / 720.0, 0.0, 1.0 / 72.0, -1.0 / 48.0, 1.0 / 120.0],
];

/// The Taylor coefficients of the polynomial through these points about the first of them.
fn taylor(points: impl Iterator<Item = [f64; 2]>) -> [f64; AT_END] {
    let points: Vec<[f64; 2]> = points.take(AT_END).collect();
    let x: Vec<f64> = points.iter().map(|p| p[0] - points[0][0]).collect();
    let mut slopes: Vec<f64> = points.iter().map(|p| p[1]).collect();
    for order in 1..x.len() {
        for i in (order..x.len()).rev() {
            slopes[i] = (slopes[i] - slopes[i - 1]) / (x[i] - x[i - order]);
        }
    }
    // Horner's scheme of Newton's form, in powers of the distance from the first point.
    let mut c = [0.0; AT_END];
    for (slope, x) in slopes.iter().zip(&x).rev() {
        for j in (1..AT_END).rev() {
            c[j] = c[j - 1] - x * c[j];
        }
        c[0] = slope - x * c[0];
    }
    c
}

impl Part {
    fn at(&self, x: f64) -> f64 {
        // A law has four derivatives; a higher one would only help to find an extreme.
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

    /// True if points cover a turn: they leave no hole, and do not jump at its end.
    pub fn closes(points: &Points) -> bool {
        let (lifts, gaps) = (&points.lifts, gaps(&points.angles, TAU));
        let n = lifts.len();
        let steep = |i: usize| ((lifts[(i + 1) % n] - lifts[i]) / gaps[i]).abs();
        hole(&gaps).is_none() && steep(n - 1) <= HOLE * (0..n - 1).map(steep).fold(0.0, f64::max)
    }

    /// The spline through the points of a part of a turn that reaches over this range; without noise its error in U⁽ⁿ⁾ is O(h⁵⁻ⁿ).
    ///
    /// A polynomial takes the differences of U … U⁗ between the ends of the table; the rest is periodic over the table.
    ///
    /// # Errors
    /// In words, where the points are too few or do not reach so far.
    pub fn table(angles: &[f64], lifts: &[f64], turn: f64, [from, to]: [f64; 2]) -> Result<Self, String> {
        let n = angles.len();
        if n < LEAST {
            return Err(format!("{}; a part of a turn has at least {LEAST}", counted(n, "point")));
        }
        // The part begins behind the hole.
        let hole = hole(&gaps(angles, turn)).unwrap_or(n - 1);
        let lifts: Vec<f64> = (0..n).map(|i| lifts[(hole + 1 + i) % n]).collect();
        let angle = |i: usize| angles[i % n] + if i < n { 0.0 } else { turn };
        let start = angle(hole + 1);
        let turns = ((from + CLOSING - start) / turn).floor() * turn;
        let angles: Vec<f64> = (0..n).map(|i| angle(hole + 1 + i) + turns).collect();
        let (first, length) = (angles[0] - from, angles[n - 1] - angles[0]);
        if first + length < to - from - CLOSING {
            let near = ((from - angles[0]) / turn).round() * turn;
            let [a, b, from, to] = [angles[0] + near, angles[n - 1] + near, from, to].map(degrees);
            return Err(format!("it reaches from {a} deg to {b} deg, not from {from} deg to {to} deg"));
        }
        let (points, apart) = (|| angles.iter().zip(&lifts).map(|(x, u)| [*x, *u]), (n / APART).max(1));
        let ends = [taylor(points().step_by(apart)), taylor(points().rev().step_by(apart))];
        let mut rise = [0.0; AT_END];
        let mut factorial = 1.0;
        for (k, terms) in BERNOULLI.iter().enumerate() {
            factorial *= (k as f64).max(1.0);
            let jump = factorial * (ends[1][k] - ends[0][k]) * length.powi(k as i32);
            rise.iter_mut().zip(terms).for_each(|(sum, term)| *sum += jump * term);
        }
        let polynomial = |t: f64| rise.iter().rev().fold(0.0, |sum, c| sum * t + c);
        let place = |x: &f64| (x - angles[0]) / length;
        let mut left: Vec<f64> = points().map(|[x, u]| u - polynomial(place(&x))).collect();
        // Both ends are the same but for roundings.
        left[n - 1] = left[0];
        let left = Points { angles: angles.iter().map(|x| TAU * place(x)).collect(), lifts: left };
        let law = MotionLaw::Table(Table::new(left).map_err(|error| error.to_string())?);
        // The polynomial in x = first + length t.
        let mut curve = Curve::law(law, length, -TAU * first / length);
        let mut coefficients = vec![0.0; AT_END];
        for c in rise.iter().rev() {
            for j in (0..AT_END).rev() {
                let below = if j > 0 { coefficients[j - 1] } else { 0.0 };
                coefficients[j] = (below - first * coefficients[j]) / length;
            }
            coefficients[0] += c;
        }
        curve.coefficients = coefficients;
        Ok(curve)
    }

    /// The value at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c) + self.of_laws(x)
    }

    fn of_laws(&self, x: f64) -> f64 {
        self.parts.iter().map(|part| part.at(x)).sum()
    }

    /// The value at `x`, of a polynomial to 30 digits.
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

    /// True if nothing is added to zero.
    pub fn is_zero(&self) -> bool {
        self.constant() == Some(0.0)
    }

    /// The harmonic order that resolves the laws; 0 of a polynomial.
    pub fn order(&self) -> usize {
        self.parts.iter().map(|part| (part.rate.abs() * part.law.resolution()).ceil() as usize).max().unwrap_or(0)
    }
}
