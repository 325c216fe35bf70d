//! The standard laws at the same task.

use super::deviation;
use super::{Range, Task, torque};
use crate::harmonic_analysis::analyse;
use camdrive::motion::StandardLaw::{
    InclinedSine, ModifiedSine, ModifiedTrapezoid, Polynomial345, Polynomial4567, SimpleSine,
};
use camdrive::motion::standard_laws::{MODIFIED_SINE, MODIFIED_TRAPEZOID};
use camdrive::motion::table::Points;
use camdrive::motion::{Cycle, CyclePlan, Fourier, MotionLaw, StandardLaw};
use std::f64::consts::{PI, TAU};

/// Harmonics that stand for a standard law. Its harmonics fall as k⁻⁴ (U‴ jumps): beyond the 64th they add 3e-6 of
/// the stroke, times the magnification of resonances that lie below 1/64 of the natural frequency.
const HARMONICS: usize = 64;

/// Samples of a turn for them; the harmonics of the samples above 4096 fall on those below and are 1e-9 of the stroke.
const SAMPLES: usize = 8192;

/// A motion law that keeps the dwells of a task.
#[derive(Clone, Debug, PartialEq)]
pub struct Rival {
    /// Its name.
    pub name: String,
    /// Its first harmonics.
    pub series: Fourier,
    /// max |U′|, |U″| (m/radⁿ) of the law itself.
    pub peaks: [f64; 2],
    /// max |U′U″| of the law itself (m²/rad³).
    pub torque: f64,
    /// The highest harmonic of more than a thousandth of the first.
    pub harmonics: usize,
}

/// The series without the harmonics above `order`.
pub fn truncated(series: &Fourier, order: usize) -> Fourier {
    let kept = |list: &[f64]| list.iter().take(order + 1).copied().collect();
    Fourier::new(kept(&series.a), kept(&series.b))
}

/// The highest harmonic with an amplitude of more than a thousandth of the largest one.
pub fn notable_harmonics(series: &Fourier) -> usize {
    let size = |k: usize| (series.a[k].powi(2) + series.b[k].powi(2)).sqrt();
    let largest = (1..series.a.len()).map(size).fold(0.0, f64::max);
    (1..series.a.len()).rev().find(|k| size(*k) > 1e-3 * largest).unwrap_or(0)
}

/// The two dwells of the task with their U, the lower one first, if it is one of two dwells and a rise and a return of some
/// angle.
pub(super) fn two_dwells(task: &Task) -> Option<[(&Range, f64); 2]> {
    let [first, second] = &task.ranges[..] else { return None };
    let level = |range: &Range| range.prescribed[0].as_ref()?.constant().filter(|_| range.from < range.to);
    let (u, v) = (level(first)?, level(second)?);
    (u != v).then_some(if u < v { [(first, u), (second, v)] } else { [(second, v), (first, u)] })
}

/// The cycle of a standard law with the dwells of the task; None where it has not two of them.
pub fn cycle(task: &Task, law: StandardLaw) -> Option<Cycle> {
    let [(lower, low), (upper, high)] = two_dwells(task)?;
    let way = |from: f64, to: f64| (to - from).rem_euclid(TAU);
    let plan = CyclePlan {
        stroke: high - low,
        lower: low,
        rise_start: way(0.0, lower.to),
        rise_angle: way(lower.to, upper.from),
        upper_dwell: upper.to - upper.from,
        return_angle: way(upper.to, lower.from),
        rise_law: law,
        return_law: law,
        inflections: [None; 2],
    };
    plan.validate().ok()?;
    // Dwells that overlap leave no room for a motion.
    let rest = plan.lower_dwell() - (lower.to - lower.from);
    (rest.abs() < 1e-9).then(|| Cycle::new(plan))
}

/// The standard laws at this task.
pub fn rivals(task: &Task) -> Vec<Rival> {
    StandardLaw::ALL.into_iter().filter_map(|law| rival(task, law)).collect()
}

fn rival(task: &Task, law: StandardLaw) -> Option<Rival> {
    let cycle = cycle(task, law)?;
    let CyclePlan { stroke, rise_angle, return_angle, .. } = *cycle.plan();
    let (shortest, law_of_motion) = (rise_angle.min(return_angle), MotionLaw::Cycle(cycle));
    let angles: Vec<f64> = (0..SAMPLES).map(|i| TAU * i as f64 / SAMPLES as f64).collect();
    let lifts = angles.iter().map(|phi| law_of_motion.at(*phi).0[0]).collect();
    let series = analyse(Points { angles, lifts }, HARMONICS).ok()?.series;
    Some(Rival {
        name: law.name().to_owned(),
        peaks: [stroke * law.peak(1) / shortest, stroke * law.peak(2) / shortest.powi(2)],
        torque: stroke * stroke * torque_peak(law) / shortest.powi(3),
        harmonics: notable_harmonics(&series),
        series,
    })
}

/// The half-width of two equal dwells opposite to each other, and the middle of the upper one: the symmetric task of
/// section 4.6.4.1.
pub fn symmetric_dwells(task: &Task) -> Option<(f64, f64)> {
    let [(lower, _), (upper, _)] = two_dwells(task)?;
    let middle = |r: &Range| 0.5 * (r.from + r.to);
    let half = 0.5 * (upper.to - upper.from);
    let opposite = (middle(upper) - middle(lower)).rem_euclid(TAU) - PI;
    (opposite.abs() < 1e-9 && (half - 0.5 * (lower.to - lower.from)).abs() < 1e-9).then_some((half, middle(upper)))
}

/// The figures of a series as a rival of the standard laws.
pub fn as_rival(name: &str, series: &Fourier) -> Rival {
    Rival {
        name: name.to_owned(),
        peaks: [1, 2].map(|order| deviation::peak(series, order).value.abs()),
        torque: torque::peak(series),
        harmonics: notable_harmonics(series),
        series: series.clone(),
    }
}

/// C_M = max |f′ f″|, the peak of the inertial torque.
pub fn torque_peak(law: StandardLaw) -> f64 {
    match law {
        SimpleSine => PI.powi(3) / 8.0,
        // 2π (1 − cos θ) sin θ at θ = 2π/3.
        InclinedSine => 1.5 * PI * f64::sqrt(3.0),
        // With u = z (1 − z) and s = 1 − 2z: 1800 u³ s at s² = 1/7, 58800 u⁵ s at s² = 1/11.
        Polynomial345 => 1800.0 * f64::powi(3.0 / 14.0, 3) / f64::sqrt(7.0),
        Polynomial4567 => 58800.0 * f64::powi(5.0 / 22.0, 5) / f64::sqrt(11.0),
        // 4πV² (1 + 3s) √(1 − s²) at 6s² + s − 3 = 0.
        ModifiedSine => {
            let s = (f64::sqrt(73.0) - 1.0) / 12.0;
            2.0 * TAU * MODIFIED_SINE.powi(2) * (1.0 + 3.0 * s) * (1.0 - s * s).sqrt()
        }
        // 4πV² (1 + π + c) √(1 − c²) at 2c² + (1 + π) c − 1 = 0.
        ModifiedTrapezoid => {
            let b = 1.0 + PI;
            let c = ((b * b + 8.0).sqrt() - b) / 4.0;
            2.0 * TAU * MODIFIED_TRAPEZOID.powi(2) * (b + c) * (1.0 - c * c).sqrt()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peaks_of_the_torque_are_the_published_ones_and_those_of_the_curves() {
        let published = ["3.876", "8.162", "6.694", "10.750", "5.458", "8.090"];
        for (law, published) in StandardLaw::ALL.into_iter().zip(published) {
            let peak = torque_peak(law);
            assert_eq!(format!("{peak:.3}"), published, "{law:?}");
            let at = |i: usize| law.at(i as f64 / 100_000.0);
            let found = (0..=100_000).map(|i| (at(i)[1] * at(i)[2]).abs()).fold(0.0, f64::max);
            assert!(found > peak * (1.0 - 1e-7) && found < peak * (1.0 + 1e-14), "{law:?}: {found} {peak}");
        }
    }
}
