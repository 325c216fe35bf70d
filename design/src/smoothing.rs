//! Removes the noise of measured lifts, which interpolation would enlarge in U″, and the wrong rows of a table.
//!
//! Among all periodic s the one with the least Σ (s(φᵢ) − yᵢ)² + λ ∫ s‴² dφ keeps the part 1/(1 + (k/K)⁶) of harmonic k of rows
//! at equal distances (`penalised`). If σ is known, Mallows' criterion chooses λ, else robust cross-validation (`wrong_rows`).
//! The periodic quintic spline through its values at the rows is s itself.

mod corners;
mod jumps;
mod penalised;
#[cfg(test)]
mod tests;
mod wrong_rows;

pub use corners::{Corners, certain};
pub use jumps::Jump;
pub use wrong_rows::{TableFaults, WrongRow};

use camdrive::motion::table::{Points, TableError};
use camdrive::motion::{MotionLaw, Table};
use penalised::Rows;
use std::f64::consts::{PI, TAU};

/// Lobes of U″ up to this many times σ of its remaining noise are noise: among a hundred of them none is higher by chance.
const NOISE: f64 = 4.0;

/// Next to a jump of U″ the smoothed law, whose slope there is K/3 of the jump, swings by 6 % of it, by this part of |U‴|/K;
/// half of harmonic K is kept. Next to a jump of U‴ it swings by half as much.
const SWING: f64 = 0.2;

/// A curve with more than this many freedoms per row goes through the rows: they contain no noise.
const NO_NOISE: f64 = 0.9;

/// A pass about the level of a rest brings its order closer to the right level's; the third changes nothing that matters.
const PASSES: usize = 2;

/// Next to measured rows the curve leaves the level of a rest by up to the noise, and comes back to it like exp(−K φ/2): the
/// least poles of 1/(1 + (k/K)⁶) are ±i K/2 off the real axis. From this K φ on the rest is below 1e-4 of the noise.
const SETTLED: f64 = 20.0;

/// Lifts without their noise, and the changes.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothedTable {
    /// The points, with a closing one; rows at nearly one angle are one point.
    pub points: Points,
    /// The point of each row.
    pub point: Vec<usize>,
    /// σ of the noise.
    pub noise: f64,
    /// The root mean square of the changes, and the largest of them.
    pub changes: [f64; 2],
    /// The largest change as part of the stroke.
    pub part: f64,
    /// The order of which half is kept: the cut-off.
    pub half: f64,
    /// Lobes of U″ up to this height (per rad²) are remaining noise or swings of the smoothing.
    pub left: f64,
    /// The rows left out, the specks kept, and the jumps of the law, which smoothing removes.
    pub found: TableFaults,
    /// The points of rows at rest that are so far from measured ones that the curve has the level there.
    pub at_rest: Vec<usize>,
}

/// The treatment of wrong rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outliers {
    /// They are refused.
    Refuse,
    /// They are left out, and specks.
    Drop,
    /// They are left out of a curve that is no law; its jumps and specks are not searched.
    DropOfCurve,
}

/// The reason why lifts cannot be smoothed.
#[derive(Clone, Debug, PartialEq)]
pub enum SmoothingError {
    /// The points are no table.
    Table(TableError),
    /// Rows that are wrong.
    Wrong(Vec<WrongRow>),
    /// σ is at least the root mean square of the motion, which is this.
    NothingLeft(f64),
    /// No noise is found: the best curve goes through the points.
    NoNoise,
}

/// The lifts without noise of the standard deviation `noise`, or of an estimated one; two rows may have one angle. Wrong rows
/// are left out or refused. The rows `at_rest` were not measured: they have one level, the least minimum's.
///
/// # Errors
/// Points that are no table, that have wrong rows, or no such noise.
pub fn smooth(
    points: Points,
    noise: Option<f64>,
    outliers: Outliers,
    at_rest: &[usize],
) -> Result<SmoothedTable, SmoothingError> {
    let mut rows = Rows::new(points).map_err(SmoothingError::Table)?;
    let found = rows.leave_out_wrong(noise, outliers);
    if outliers == Outliers::Refuse && !found.wrong.is_empty() {
        return Err(SmoothingError::Wrong(found.wrong));
    }
    if !at_rest.is_empty() {
        (0..PASSES).for_each(|_| rows.settle(noise, at_rest));
    }
    let n = rows.weights.iter().sum::<f64>();
    let sum = |f: &dyn Fn(usize) -> f64| (0..rows.lifts.len()).map(|i| rows.weights[i] * f(i)).sum::<f64>() / n;
    let mean = sum(&|i| rows.lifts[i]);
    let whole = sum(&|i| (rows.lifts[i] - mean).powi(2)).sqrt();
    if noise.is_some_and(|noise| noise >= whole) {
        return Err(SmoothingError::NothingLeft(whole));
    }
    let look = rows.look(noise);
    // Rows that share a knot show the noise between them.
    let apart = rows.knots.len() == rows.lifts.len();
    let fit = rows.fit(&rows.lifts, look.order);
    let range = fit.states.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], s| [a.min(s[0]), b.max(s[0])]);
    let change = |i: usize| rows.weights[i] * fit.residuals[i].abs();
    let largest = (0..rows.lifts.len()).map(change).fold(0.0, f64::max);
    let part = largest / (range[1] - range[0]);
    let noise = match noise {
        None if !(look.noise > 0.0) || apart && look.freedom > NO_NOISE * n => return Err(SmoothingError::NoNoise),
        noise => noise.unwrap_or(look.noise),
    };
    let close = |mut values: Vec<f64>, turn: f64| {
        values.push(values[0] + turn);
        values
    };
    let mut lifts = close(fit.states.iter().map(|state| state[0]).collect(), 0.0);
    let angle = |row: usize| rows.angles[row];
    let ends = at_rest.first().zip(at_rest.last()).map(|(first, last)| [*first, *last].map(angle));
    let rests =
        |row: &&usize| ends.is_some_and(|[a, b]| (angle(**row) - a).min(b - angle(**row)) * look.order > SETTLED);
    let resting: Vec<usize> = at_rest.iter().filter(rests).copied().collect();
    resting.iter().for_each(|row| lifts[rows.knot[*row]] = rows.lifts[*row]);
    let at_rest = resting.iter().map(|row| rows.knot[*row]).collect();
    let points = Points { angles: close(rows.knots.clone(), TAU), lifts };
    let law = MotionLaw::Table(Table::new(points.clone()).map_err(SmoothingError::Table)?);
    let third = rows.knots.iter().map(|angle| law.at(*angle).0[3].abs()).fold(0.0, f64::max);
    // White noise has the share σ²/n in every harmonic of either phase, of which U″ has k² times the kept part; the sum over k of
    // 2 k⁴/(1 + (k/K)⁶)² is π K⁵/9.
    let left = noise * (PI * look.order.powi(5) / (9.0 * n)).sqrt();
    let left = NOISE * left + SWING * third / look.order;
    let changes = [sum(&|i| change(i).powi(2)).sqrt(), largest];
    Ok(SmoothedTable { points, point: rows.knot, noise, changes, part, half: look.order, left, found, at_rest })
}

/// The estimated σ of the noise of the lifts; None without noise and if they are no table.
pub fn noise(points: Points) -> Option<f64> {
    let rows = Rows::new(points).ok()?;
    let look = rows.look(None);
    (look.noise > 0.0 && look.freedom <= NO_NOISE * rows.lifts.len() as f64).then_some(look.noise)
}

/// Wrong rows, specks and jumps of the law; empty if the points are no table.
pub fn found(points: Points, outliers: Outliers) -> TableFaults {
    Rows::new(points).map(|mut rows| rows.leave_out_wrong(None, outliers)).unwrap_or_default()
}
