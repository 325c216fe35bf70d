//! Measured lifts without their noise, which interpolation would enlarge in U″.
//!
//! Of all periodic s the one with the least Σ (sᵢ − yᵢ)² + λ ∫ s‴² dφ keeps the part tₖ = 1/(1 + μ k⁶) of harmonic k of
//! equidistant lifts y. With μ on which the mean square of s − y is σ² all of the noise is taken out, and some of the motion
//! (discrepancy principle); generalised cross-validation, the least mean (s − y)²/(1 − mean tₖ)², keeps more of it. The latter is
//! taken, and no more than the former.
//!
//! Source: G. Wahba, *Spline Models for Observational Data*, SIAM 1990, sections 4.4 and 4.7.

use crate::harmonic_analysis::{discrete_series, is_equidistant};
use crate::overview::scatter;
use crate::search::{maximum, zero};
use camdrive::motion::table::{Points, TableError};
use std::f64::consts::TAU;

/// Harmonics beyond are noise: waves of a third of a degree.
const MOST_HARMONICS: usize = 1000;

/// What the angles of equidistant points may be off by, as part of their distance: roundings of a third of a degree.
const EVEN: f64 = 0.01;

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
}

/// Why lifts cannot be smoothed.
#[derive(Clone, Debug, PartialEq)]
pub enum SmoothingError {
    /// The points are no table.
    Table(TableError),
    /// They are not equidistant.
    Distances,
    /// σ is no less than the root mean square of the motion, which is this.
    NothingLeft(f64),
    /// No noise is found: σ̂₁₀/σ̂₈ is that of a law.
    NoNoise,
}

/// The lifts without noise of the standard deviation `noise`, or of one that their own differences tell.
///
/// # Errors
/// Where the points are no table of equal distances, or have no such noise.
pub fn smooth(points: Points, noise: Option<f64>) -> Result<Smoothed, SmoothingError> {
    let mut points = points.open().map_err(SmoothingError::Table)?;
    let n = points.angles.len();
    if !is_equidistant(&points.angles, EVEN * TAU / n as f64) {
        return Err(SmoothingError::Distances);
    }
    let noise = noise.or_else(|| scatter(&points)).ok_or(SmoothingError::NoNoise)?;
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
    let log = maximum(&mut validation, [ends[0], discrepancy], 1e-3).0;
    let mut changes = [0.0_f64; 2];
    let mut smooth = series;
    for k in 1..=smooth.order() {
        smooth.a[k] *= kept(log, k);
        smooth.b[k] *= kept(log, k);
    }
    for (angle, lift) in points.angles.iter().zip(&mut points.lifts) {
        let change = smooth.at(*angle).0[0] - *lift;
        *lift += change;
        changes = [changes[0] + change * change / n as f64, changes[1].max(change.abs())];
    }
    let half = [log, discrepancy].map(|log| (-log / 6.0).exp());
    Ok(Smoothed { points, noise, changes: [changes[0].sqrt(), changes[1]], half })
}

#[cfg(test)]
mod tests {
    use super::*;
    use camdrive::motion::cycle::CyclePlan;
    use camdrive::motion::{Fourier, MotionLaw, StandardLaw, Table};

    fn law(kind: StandardLaw) -> MotionLaw {
        let [rise_angle, upper_dwell, return_angle] = [100_f64, 60.0, 90.0].map(f64::to_radians);
        let plan = CyclePlan {
            stroke: 0.02,
            lower: 0.0,
            rise_start: 0.0,
            rise_angle,
            upper_dwell,
            return_angle,
            rise_law: kind,
            return_law: kind,
            inflections: [None; 2],
        };
        MotionLaw::Cycle(plan.into())
    }

    /// The law at whole degrees with noise of this standard deviation; sums of twelve even numbers are nearly normal.
    fn measured(law: &MotionLaw, sigma: f64, mut seed: u64) -> Points {
        let mut even = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let angles: Vec<f64> = (0..360).map(|i| TAU * f64::from(i) / 360.0).collect();
        let lifts = angles.iter().map(|phi| law.at(*phi).0[0] + sigma * ((0..12).map(|_| even()).sum::<f64>() - 6.0));
        Points { lifts: lifts.collect(), angles }
    }

    /// The root mean square error of U″ of a spline through the points, over the largest U″.
    fn error(law: &MotionLaw, points: Points) -> f64 {
        let table = MotionLaw::Table(Table::new(points).unwrap());
        let places = (0..3600).map(|i| TAU * (f64::from(i) + 0.5) / 3600.0);
        let square = |phi: f64| (table.at(phi).0[2] - law.at(phi).0[2]).powi(2);
        (places.map(square).sum::<f64>() / 3600.0).sqrt() / law.bound(2)
    }

    #[test]
    fn noise_of_some_micrometres_no_longer_hides_the_acceleration() {
        for (kind, sigma, [raw, left]) in [
            (StandardLaw::ModifiedSine, 5e-6, [1.0, 0.035]),
            (StandardLaw::ModifiedSine, 1e-6, [0.2, 0.016]),
            (StandardLaw::Polynomial345, 5e-6, [1.0, 0.03]),
            (StandardLaw::ModifiedTrapezoid, 5e-6, [1.0, 0.04]),
        ] {
            let law = law(kind);
            for seed in 1..4 {
                let points = measured(&law, sigma, seed);
                let smoothed = smooth(points.clone(), None).unwrap();
                assert!((smoothed.noise / sigma - 1.0).abs() < 0.2, "{kind:?} {:e}", smoothed.noise);
                assert!(smoothed.changes[0] <= smoothed.noise && smoothed.half[0] >= smoothed.half[1]);
                let errors = [error(&law, points), error(&law, smoothed.points)];
                assert!(errors[0] > raw && errors[1] < left, "{kind:?} {sigma:e}: {errors:?}");
            }
        }
    }

    #[test]
    fn rounding_is_noise_too() {
        // Where U″ jumps, no smoothing recovers it.
        for (kind, limits) in [
            (StandardLaw::ModifiedSine, [0.008, 0.016]),
            (StandardLaw::Polynomial345, [0.008, 0.016]),
            (StandardLaw::SimpleSine, [0.06, 0.08]),
        ] {
            let law = law(kind);
            for (unit, limit) in [1e-6, 1e-5].into_iter().zip(limits) {
                let mut points = measured(&law, 0.0, 1);
                points.lifts.iter_mut().for_each(|lift| *lift = (*lift / unit).round() * unit);
                // Angles of four digits, as well.
                points.angles.iter_mut().for_each(|phi| *phi = (*phi * 1e4).round() * 1e-4);
                let smoothed = smooth(points, None).unwrap();
                let left = error(&law, smoothed.points);
                assert!(smoothed.half[0] < 120.0 && left < limit, "{kind:?} {unit:e}: {left:e} {:?}", smoothed.half);
            }
        }
    }

    #[test]
    fn a_harmonic_loses_what_its_order_says() {
        let series = Fourier::new(vec![0.0, 0.01, 0.0, 0.0, 0.002], vec![0.0; 5]);
        let points = measured(&MotionLaw::Fourier(series), 1e-6, 7);
        let smoothed = smooth(points.clone(), Some(1e-6)).unwrap();
        let [before, after] = [points.lifts, smoothed.points.lifts].map(|lifts| discrete_series(0.0, &lifts, 4).a);
        for k in [1, 4] {
            let kept = 1.0 / (1.0 + (k as f64 / smoothed.half[0]).powi(6));
            assert!((after[k] / before[k] - kept).abs() < 1e-12, "{k}");
        }
    }

    #[test]
    fn what_cannot_be_smoothed_is_named() {
        let law = law(StandardLaw::ModifiedSine);
        let exact = measured(&law, 0.0, 1);
        assert_eq!(smooth(exact.clone(), None), Err(SmoothingError::NoNoise));
        assert!(matches!(smooth(exact.clone(), Some(0.02)), Err(SmoothingError::NothingLeft(_))));
        let mut uneven = exact;
        uneven.angles[5] += 1e-3;
        assert_eq!(smooth(uneven, None), Err(SmoothingError::Distances));
        let none = Points { angles: vec![0.0, 1.0], lifts: vec![0.0] };
        assert!(matches!(smooth(none, None), Err(SmoothingError::Table(_))));
    }
}
