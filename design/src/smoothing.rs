//! Measured lifts without their noise, which interpolation would enlarge in U″.
//!
//! Of all periodic s the one with the least Σ (sᵢ − yᵢ)² + λ ∫ s‴² dφ keeps the part tₖ = 1/(1 + μ k⁶) of harmonic k of
//! equidistant lifts y. With μ on which the mean square of s − y is σ² all of the noise is taken out, and some of the motion
//! (discrepancy principle); generalised cross-validation, the least mean (s − y)²/(1 − mean tₖ)², keeps more of it. The latter is
//! taken, and no more than the former; of points at unequal distances, which are resampled, the former.
//!
//! Source: G. Wahba, *Spline Models for Observational Data*, SIAM 1990, sections 4.4 and 4.7.

#[cfg(test)]
mod tests;

use crate::harmonic_analysis::{discrete_series, is_equidistant};
use crate::overview::scatter;
use crate::search::{maximum, zero};
use camdrive::motion::table::{Points, TableError};
use camdrive::motion::{MotionLaw, Table};
use std::f64::consts::TAU;

/// Harmonics beyond are noise: waves of a third of a degree.
const MOST_HARMONICS: usize = 1000;

/// Tolerance of the angles of equidistant points, as part of their distance: roundings of a third of a degree.
const EVEN: f64 = 0.01;

/// Lobes of U″ up to so many times σ of the noise left in it are noise: of a hundred of them none is higher by chance.
const NOISE: f64 = 4.0;

/// Beside a jump of U″ the smoothed law swings by 6 % of it, where its slope is K/3 of it, K the order of which half is kept:
/// by this part of |U‴|/K. Beside a jump of U‴ it swings by half as much.
const SWING: f64 = 0.2;

/// Lifts without their noise, and what that changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// The points.
    pub points: Points,
    /// σ of the noise.
    pub noise: f64,
    /// The root of the mean square of the changes, and the largest of them.
    pub changes: [f64; 2],
    /// The order of which half is kept, and what it would be if all of the noise were taken out.
    pub half: [f64; 2],
    /// Lobes of U″ up to this height (per rad²) are noise that is left or swings of the smoothing.
    pub left: f64,
}

/// Why lifts cannot be smoothed.
#[derive(Clone, Debug, PartialEq)]
pub enum SmoothingError {
    /// The points are no table.
    Table(TableError),
    /// σ is no less than the root mean square of the motion, which is this.
    NothingLeft(f64),
    /// No noise is found: every second lift has the differences of a law.
    NoNoise,
}

/// The lifts without noise of the standard deviation `noise`, or of one that their own differences tell. Points at other
/// distances are replaced by as many equidistant ones of the spline through them.
///
/// # Errors
/// Where the points are no table, or have no such noise.
pub fn smooth(points: Points, noise: Option<f64>) -> Result<Smoothed, SmoothingError> {
    let mut points = points.open().map_err(SmoothingError::Table)?;
    let n = points.angles.len();
    let noise = noise.or_else(|| scatter(&points)).ok_or(SmoothingError::NoNoise)?;
    let even = is_equidistant(&points.angles, EVEN * TAU / n as f64);
    if !even {
        let (first, law) = (points.angles[0], MotionLaw::Table(Table::new(points).map_err(SmoothingError::Table)?));
        let angles: Vec<f64> = (0..n).map(|i| first + TAU * i as f64 / n as f64).collect();
        points = Points { lifts: angles.iter().map(|phi| law.at(*phi).0[0]).collect(), angles };
    }
    let order = (n / 2).min(MOST_HARMONICS);
    let mut series = discrete_series(points.angles[0], &points.lifts, order);
    // The last harmonic of an even number of points has one phase only, and its sums count twice.
    let freedom = |k: usize| if 2 * k == n { 1.0 } else { 2.0 };
    series.a[order] *= 0.5 * freedom(order);
    series.b[order] *= 0.5 * freedom(order);
    let power: Vec<f64> = (1..=order).map(|k| (series.a[k].powi(2) + series.b[k].powi(2)) / freedom(k)).collect();
    let whole = points.lifts.iter().map(|lift| (lift - series.a[0]).powi(2)).sum::<f64>() / n as f64;
    if noise * noise >= whole {
        return Err(SmoothingError::NothingLeft(whole.sqrt()));
    }
    let kept = |log: f64, k: usize| 1.0 / (1.0 + log.exp() * (k as f64).powi(6));
    // The mean square of s − y, with what lies beyond the harmonics.
    let beyond = (whole - power.iter().sum::<f64>()).max(0.0);
    let missed =
        |log: f64| beyond + (1..).zip(&power).map(|(k, power)| power * (1.0 - kept(log, k)).powi(2)).sum::<f64>();
    let mean_kept = |log: f64| (1.0 + (1..=order).map(|k| freedom(k) * kept(log, k)).sum::<f64>()) / n as f64;
    // From a thousandth off the highest harmonic to a thousandth left of the first.
    let ends = [1e-3 / (order as f64).powi(6), 1e3].map(f64::ln);
    let mut too_much = |log: f64| missed(log) / (noise * noise) - 1.0;
    let values = ends.map(&mut too_much);
    let discrepancy = match values {
        [low, _] if low >= 0.0 => ends[0],
        [_, high] if high <= 0.0 => ends[1],
        // To a thousandth of μ: noise is not known better.
        _ => zero(&mut too_much, ends, values, 1e-3),
    };
    let mut validation = |log: f64| -missed(log) / (1.0 - mean_kept(log)).powi(2);
    // Between points farther apart than others the noise of a spline is not white, as the latter takes it to be.
    let log = if even { maximum(&mut validation, [ends[0], discrepancy], 1e-3).0 } else { discrepancy };
    let (mut changes, mut third) = ([0.0_f64; 2], 0.0_f64);
    let mut smooth = series;
    for k in 1..=smooth.order() {
        smooth.a[k] *= kept(log, k);
        smooth.b[k] *= kept(log, k);
    }
    for (angle, lift) in points.angles.iter().zip(&mut points.lifts) {
        let [u, .., u3, _] = smooth.at(*angle).0;
        let change = u - *lift;
        third = third.max(u3.abs());
        *lift += change;
        changes = [changes[0] + change * change / n as f64, changes[1].max(change.abs())];
    }
    let half = [log, discrepancy].map(|log| (-log / 6.0).exp());
    // White noise has the same share σ²/n in every harmonic of either phase, of which U″ has k² times the kept part.
    let left = (1..=order).map(|k| freedom(k) * ((k * k) as f64 * kept(log, k)).powi(2)).sum::<f64>();
    let left = NOISE * noise * (left / n as f64).sqrt() + SWING * third / half[0].min(order as f64);
    Ok(Smoothed { points, noise, changes: [changes[0].sqrt(), changes[1]], half, left })
}
