//! The periodic curve that is close to rows of angles and lifts and has little jerk.
//!
//! Among all periodic s the one with the least Σ wᵢ (s(φᵢ) − yᵢ)² + λ ∫ s‴² dφ is the quintic spline with a knot at every
//! angle. Its unknowns are s, s′ and s″ at the knots: ∫ s‴² over a piece is a quadratic form of the unknowns at both ends, so
//! the equations are blocks of three in a cycle. In the order 0, −1, 1, −2, 2 … of the knots the cycle is a band.
//!
//! Angles that are nearly equal share a knot; each row enters with its own angle, s(φ) = s + δ s′ + δ² s″/2 from the knot. With
//! λ = (2π/n)⁻⁶ K⁻⁶ in units of the mean distance of n rows, half of harmonic K is kept.
//!
//! Source: G. Wahba, *Spline Models for Observational Data*, SIAM 1990, chapters 1 and 4.

use camdrive::motion::table::{LEAST_DISTANCE, Points, TableError};
use std::f64::consts::TAU;

/// Rows within this angle share a knot (rad): with U‴ = 10 m/rad³ the knot's error there is 5 nm.
const ONE_KNOT: f64 = TAU / 2000.0;

/// Width of the band: the blocks of neighbouring knots are at most two apart.
const BAND: usize = 9;

/// ∫ s‴² over a piece of length h for the values (s, h s′, h² s″) at both ends, times h⁵.
const PIECE: [[f64; 6]; 6] = [
    [720.0, 360.0, 60.0, -720.0, 360.0, -60.0],
    [360.0, 192.0, 36.0, -360.0, 168.0, -24.0],
    [60.0, 36.0, 9.0, -60.0, 24.0, -3.0],
    [-720.0, -360.0, -60.0, 720.0, -360.0, 60.0],
    [360.0, 168.0, 24.0, -360.0, 192.0, -36.0],
    [-60.0, -24.0, -3.0, 60.0, -36.0, 9.0],
];

/// Rows of a table, and the knots of its curve.
pub struct Rows {
    /// Angles (rad), ascending, without a closing one.
    pub angles: Vec<f64>,
    pub lifts: Vec<f64>,
    /// 1, or 0 for a row that is left out.
    pub weights: Vec<f64>,
    /// Angles of the knots (rad).
    pub knots: Vec<f64>,
    /// The knot of each row.
    pub knot: Vec<usize>,
    /// The mean distance of the rows (rad).
    pub unit: f64,
}

/// A curve for one λ; its derivatives use the angle in units of the mean distance.
pub struct Fit {
    /// s, s′, s″ at the knots.
    pub states: Vec<[f64; 3]>,
    /// y − s of the rows.
    pub residuals: Vec<f64>,
    /// The growth of s at a row with weight when its y grows by one; without weight, the variance of s there by σ².
    pub leverages: Vec<f64>,
    /// The minimum.
    pub least: f64,
    /// ln det₊ λE/det(A) of the energy E and the equations A.
    pub log: f64,
}

impl Rows {
    /// The rows of a table, some of which may have one angle.
    pub fn new(points: Points) -> Result<Self, TableError> {
        let Points { mut angles, mut lifts } = points.clone();
        // A repeated angle is checked as if it were the next one.
        let mut apart = points;
        for i in 1..angles.len() {
            if angles[i] >= angles[i - 1] {
                apart.angles[i] = angles[i].max(apart.angles[i - 1] + 1.01 * LEAST_DISTANCE);
            }
        }
        let n = apart.open()?.angles.len();
        angles.truncate(n);
        lifts.truncate(n);
        let (mut knots, mut knot): (Vec<f64>, _) = (Vec::new(), vec![0; n]);
        let mut first = 0;
        while first < n {
            let end = first + angles[first..].partition_point(|angle| angle - angles[first] <= ONE_KNOT);
            if first > 0 && angles[first] - TAU >= knots[0] - ONE_KNOT {
                // The first knot once more, one turn later.
                angles[first..].iter_mut().for_each(|angle| *angle -= TAU);
                break;
            }
            knot[first..end].fill(knots.len());
            knots.push(0.5 * (angles[first] + angles[end - 1]));
            first = end;
        }
        Ok(Rows { angles, lifts, weights: vec![1.0; n], knots, knot, unit: TAU / n as f64 })
    }

    /// The row of the equation of row `i`: 1, δ, δ²/2.
    fn row(&self, i: usize) -> [f64; 3] {
        let delta = (self.angles[i] - self.knots[self.knot[i]]) / self.unit;
        [1.0, delta, 0.5 * delta * delta]
    }

    /// The first unknown of a knot, counted around the turn.
    fn place(&self, knot: usize) -> usize {
        let (m, knot) = (self.knots.len(), knot % self.knots.len());
        3 * if knot < m.div_ceil(2) { 2 * knot } else { 2 * (m - 1 - knot) + 1 }
    }

    /// The curve of the `lifts` with harmonic `order` halved.
    pub fn fit(&self, lifts: &[f64], order: f64) -> Fit {
        let (m, lambda) = (self.knots.len(), (self.unit * order).powi(-6));
        let size = 3 * m;
        // The lower triangle by rows, from the diagonal leftwards, and the right-hand sides.
        let (mut a, mut x) = (vec![[0.0; BAND]; size], vec![0.0; size]);
        let mut add = |i: usize, j: usize, value: f64| {
            if j <= i {
                a[i][i - j] += value;
            }
        };
        for k in 0..m {
            let next = if k + 1 < m { self.knots[k + 1] } else { self.knots[0] + TAU };
            let length = (next - self.knots[k]) / self.unit;
            let powers: [f64; 5] = std::array::from_fn(|power| lambda * length.powi(power as i32 - 5));
            let places = [self.place(k), self.place(k + 1)];
            for p in 0..6 {
                for q in 0..6 {
                    let value = PIECE[p][q] * powers[p % 3 + q % 3];
                    add(places[p / 3] + p % 3, places[q / 3] + q % 3, value);
                }
            }
        }
        for i in 0..lifts.len() {
            let (row, place) = (self.row(i), self.place(self.knot[i]));
            for p in 0..3 {
                x[place + p] += self.weights[i] * row[p] * lifts[i];
                for q in 0..=p {
                    add(place + p, place + q, self.weights[i] * row[p] * row[q]);
                }
            }
        }
        // A = L Lᵀ in the place of A, and the solution.
        for i in 0..size {
            let left = i.saturating_sub(BAND - 1);
            for j in left..=i {
                let sum = (left.max(j.saturating_sub(BAND - 1))..j)
                    .fold(a[i][i - j], |sum, k| sum - a[i][i - k] * a[j][j - k]);
                a[i][i - j] = if i == j { sum.sqrt() } else { sum / a[j][0] };
            }
            x[i] = (left..i).fold(x[i], |sum, k| sum - a[i][i - k] * x[k]) / a[i][0];
        }
        // The band of the inverse, from its end.
        let mut inverse = vec![[0.0; BAND]; size];
        for j in (0..size).rev() {
            let end = (j + BAND).min(size);
            x[j] = (j + 1..end).fold(x[j], |sum, k| sum - a[k][k - j] * x[k]) / a[j][0];
            for i in (j..end).rev() {
                let own = if i == j { 1.0 / a[j][0] } else { 0.0 };
                let sum = (j + 1..end).fold(own, |sum, k| sum - a[k][k - j] * inverse[k.max(i)][k.abs_diff(i)]);
                inverse[i][i - j] = sum / a[j][0];
            }
        }
        let states: Vec<[f64; 3]> = (0..m).map(|k| std::array::from_fn(|p| x[self.place(k) + p])).collect();
        let product = |row: [f64; 3], state: [f64; 3]| row[0] * state[0] + row[1] * state[1] + row[2] * state[2];
        let rows = || (0..lifts.len()).map(|i| (i, self.row(i)));
        let residuals: Vec<f64> = rows().map(|(i, row)| lifts[i] - product(row, states[self.knot[i]])).collect();
        let leverage = |(i, row): (usize, [f64; 3])| {
            let place = self.place(self.knot[i]);
            let column = |p: usize| std::array::from_fn(|q| inverse[place + p.max(q)][p.abs_diff(q)]);
            product(row, std::array::from_fn(|p| product(row, column(p))))
        };
        let least = (0..lifts.len()).map(|i| self.weights[i] * lifts[i] * residuals[i]).sum();
        let log = (size - 1) as f64 * lambda.ln() - 2.0 * a.iter().map(|row| row[0].ln()).sum::<f64>();
        Fit { states, leverages: rows().map(leverage).collect(), residuals, least, log }
    }
}
