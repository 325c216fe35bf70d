//! Conditions that hold at every angle of a range.

use super::Curve;
use super::basis::{Basis, Response};
use super::clearance::Tangent;
use super::deviation::Window;
use super::elastic::output;
use super::exact::{add_multiple, dot};
use super::sampling::{COARSE, Density, FINE, angles, within};
use crate::search::crests;
use camdrive::motion::Fourier;
use camdrive::numerics::double_double::Double;

/// The error of a sum of double-double terms, as part of them: sines to thirty digits.
pub const ROUNDING: f64 = 1e-30;

/// An excess of this part of its terms has seven digits left in plain numbers.
const PLAIN: f64 = 1e-9;

/// The step of differences (rad), by which extremes are found to half of the digits, their values to all.
const STEP: f64 = 1e-4;

/// f U⁽ⁿ⁾ of a law.
#[derive(Clone, Copy, Debug)]
pub struct Term {
    /// Which law.
    pub law: usize,
    /// n.
    pub order: usize,
    /// f.
    pub factor: f64,
}

/// Σ f Y⁽ⁿ⁾ − Ũ ≤ level · t + limit at all angles of a range, over derivatives of one law or of
/// several; Y is U or what an elastic output member makes of it.
#[derive(Clone, Debug)]
pub struct Family {
    from: f64,
    to: f64,
    /// Σ f U⁽ⁿ⁾.
    pub terms: Vec<Term>,
    /// Ũ.
    pub target: Curve,
    /// Tools that keep clear instead of the terms and the target.
    pub tangent: Option<Tangent>,
    /// The elastic output member, if the condition looks behind it.
    pub response: Option<Response>,
    /// The factor of the unknown level t that is made small.
    pub level: f64,
    /// The right-hand side.
    pub limit: f64,
    /// The bound of the task that this is.
    pub bound: Option<usize>,
}

impl Family {
    /// Without any term.
    pub fn new(from: f64, to: f64) -> Self {
        Family {
            from,
            to,
            terms: Vec::new(),
            target: Curve::default(),
            tangent: None,
            response: None,
            level: 0.0,
            limit: 0.0,
            bound: None,
        }
    }

    /// The condition behind an elastic output member.
    pub fn behind(self, response: Option<Response>) -> Self {
        Family { response, ..self }
    }

    /// The condition as one that a bound of the task sets.
    pub fn of_bound(self, index: usize) -> Self {
        Family { bound: Some(index), ..self }
    }

    /// Adds `term` of U − `target`; the target is in SI and goes over to units of `scale`.
    pub fn add(&mut self, term: Term, target: &Curve, scale: f64) {
        self.terms.push(term);
        self.target.add(term.factor, &target.over(scale));
    }

    /// The coefficients of the unknowns at `phi`, for the n-th derivative of the condition.
    pub fn row(&self, basis: &Basis, phi: f64, n: usize) -> Vec<Double> {
        let mut row = vec![Double::default(); basis.size()];
        let linear = |tangent: &Tangent| tangent.terms(phi).map(|(law, factor)| Term { law, order: 0, factor });
        let linear = self.tangent.as_ref().map(linear);
        for term in linear.as_ref().map_or(&self.terms[..], |terms| terms) {
            let part = basis.row(term.law, phi, term.order + n, self.response);
            add_multiple(&mut row, Double::from(term.factor), &part);
        }
        row
    }

    /// Contribution of the target to the right-hand side.
    fn target(&self, phi: f64, n: usize) -> Double {
        if let Some(tangent) = &self.tangent {
            return Double::from(tangent.target(phi));
        }
        let x = Double::from(phi) - Double::from(self.from);
        match n {
            0 => self.target.exactly_at(x),
            _ => (0..n).fold(self.target.clone(), |target, _| target.derivative()).exactly_at(x),
        }
    }

    /// Excess of `x` over the target at `phi`, without limit and level, or the n-th derivative of that.
    pub fn excess(&self, basis: &Basis, x: &[Double], phi: f64, n: usize) -> f64 {
        self.excess_exactly(basis, x, phi, n).hi
    }

    /// The excess to thirty digits of its terms.
    pub fn excess_exactly(&self, basis: &Basis, x: &[Double], phi: f64, n: usize) -> Double {
        dot(&self.row(basis, phi, n), x) - self.target(phi, n)
    }

    /// Uncertainty of the excess: the rounding of the terms that it is the sum of.
    pub fn rounding(&self, basis: &Basis, x: &[Double], phi: f64) -> f64 {
        let row = self.row(basis, phi, 0);
        let terms = row.iter().zip(x).map(|(row, x)| (row.hi * x.hi).abs()).sum::<f64>() + self.target(phi, 0).hi.abs();
        ROUNDING * terms + self.target.noise(phi - self.from)
    }

    /// The angles that the first program looks at.
    pub fn first_angles(&self, basis: &Basis) -> Vec<f64> {
        self.angles(basis, COARSE)
    }

    /// The angle `phi` as one of the range, wherever whole turns lead into it; a rounding outside is its end.
    pub fn within(&self, phi: f64) -> Option<f64> {
        within(self.from, self.to, phi)
    }

    fn angles(&self, basis: &Basis, density: Density) -> Vec<f64> {
        angles(self.from, self.to, basis.order().max(self.target.order()), density)
    }

    /// The angles at which the excess is at a local maximum.
    pub fn maxima(&self, basis: &Basis, x: &[Double]) -> Vec<f64> {
        let angles = self.angles(basis, FINE);
        // Plain numbers find the angles if they have the excess to many digits.
        if let Some(sum) = self.sum(basis, x).filter(|_| self.tangent.is_none()) {
            let window = Window { from: self.from, to: self.to, order: 0, target: &self.target };
            let size = self.target.at(0.0).abs();
            let size = (0..sum.a.len()).map(|k| sum.a[k].abs() + sum.b[k].abs()).fold(size, f64::max);
            let maxima = window.maxima(&sum);
            let highest = maxima.iter().map(|e| e.value.abs()).fold(0.0, f64::max);
            if highest > PLAIN * size {
                return maxima.into_iter().map(|extreme| extreme.phi).collect();
            }
        }
        let values: Vec<f64> = angles.iter().map(|phi| self.excess(basis, x, *phi, 0)).collect();
        crests(&angles, &values, &|phi| self.slopes(basis, x, phi)).into_iter().map(|(_, phi)| phi).collect()
    }

    /// Slope and bend of the excess; of a tangent, whose direction turns with the angle, by differences.
    fn slopes(&self, basis: &Basis, x: &[Double], phi: f64) -> [f64; 2] {
        if self.tangent.is_none() {
            return [1, 2].map(|n| self.excess(basis, x, phi, n));
        }
        let [before, here, after] = [-STEP, 0.0, STEP].map(|step| self.excess(basis, x, phi + step, 0));
        [(after - before) / (2.0 * STEP), (after - 2.0 * here + before) / (STEP * STEP)]
    }

    /// Σ f Y⁽ⁿ⁾ as a series; None at an undamped resonance.
    fn sum(&self, basis: &Basis, x: &[Double]) -> Option<Fourier> {
        let motion = |law: usize| match self.response {
            Some(response) => output(&basis.series(law, x, 1.0), response),
            None => Some(basis.series(law, x, 1.0)),
        };
        self.combined(motion)
    }

    /// Σ f Y⁽ⁿ⁾ for these motions of the laws.
    pub(super) fn combined(&self, motion: impl Fn(usize) -> Option<Fourier>) -> Option<Fourier> {
        let mut sum = Fourier::new(vec![0.0], Vec::new());
        for term in &self.terms {
            let part = motion(term.law)?;
            let longest = sum.a.len().max(part.a.len());
            sum.a.resize(longest, 0.0);
            sum.b.resize(longest, 0.0);
            for k in 0..part.a.len() {
                // The derivative of a cos kφ + b sin kφ is k b cos kφ − k a sin kφ.
                let derived = |[a, b]: [f64; 2], _| [k as f64 * b, -(k as f64) * a];
                let [a, b] = (0..term.order).fold([part.a[k], part.b[k]], derived);
                sum.a[k] += term.factor * a;
                sum.b[k] += term.factor * b;
            }
        }
        Some(sum)
    }

    /// The largest |Σ f U⁽ⁿ⁾ − Ũ| of a series, in plain numbers and without the response.
    pub fn magnitude(&self, series: &Fourier) -> f64 {
        let Some(sum) = self.combined(|_| Some(series.clone())) else { return f64::INFINITY };
        let window = Window { from: self.from, to: self.to, order: 0, target: &self.target };
        window.largest(&sum).value.abs()
    }
}
