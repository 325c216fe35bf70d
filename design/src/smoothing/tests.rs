//! Noisy laws whose motion is known, against the spline of their exact lifts and a penalised Fourier series.

mod bars;
mod jumps;
mod wrong;

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

/// Random numbers.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Sums of twelve even numbers are nearly normal.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.between(0.0, 1.0)).sum::<f64>() - 6.0
    }
}

/// The law at whole degrees with noise of this standard deviation.
fn measured(law: &MotionLaw, sigma: f64, seed: u64) -> Points {
    let mut random = Random(seed);
    let angles: Vec<f64> = (0..360).map(|i| TAU * f64::from(i) / 360.0).collect();
    let lifts = angles.iter().map(|phi| law.at(*phi).0[0] + sigma * random.normal());
    Points { lifts: lifts.collect(), angles }
}

/// Largest and root mean square error of U, and the latter of U″.
fn errors(law: &MotionLaw, at: impl Fn(f64) -> [f64; 2]) -> [f64; 3] {
    const PLACES: usize = 2880;
    let mut errors = [0.0_f64; 3];
    for i in 0..PLACES {
        let phi = TAU * (i as f64 + 0.37) / PLACES as f64;
        let ([u, bend], exact) = (at(phi), law.at(phi).0);
        errors[0] = errors[0].max((u - exact[0]).abs());
        errors[1] += (u - exact[0]).powi(2) / PLACES as f64;
        errors[2] += (bend - exact[2]).powi(2) / PLACES as f64;
    }
    [errors[0], errors[1].sqrt(), errors[2].sqrt()]
}

/// Those of the spline through the points.
fn of_spline(law: &MotionLaw, points: Points) -> [f64; 3] {
    let table = MotionLaw::Table(Table::new(points).unwrap());
    errors(law, |phi| [table.at(phi).0[0], table.at(phi).0[2]])
}

/// The root mean square error of U″ of a spline through the points, over the largest U″.
fn error(law: &MotionLaw, points: Points) -> f64 {
    of_spline(law, points)[2] / law.bound(2)
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
            let smoothed = smooth(points.clone(), None, Outliers::Refuse, &[]).unwrap();
            assert!((smoothed.noise / sigma - 1.0).abs() < 0.2, "{kind:?} {:e}", smoothed.noise);
            assert!(smoothed.changes[0] <= smoothed.noise);
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
            let smoothed = smooth(points, None, Outliers::Refuse, &[]).unwrap();
            let left = error(&law, smoothed.points);
            assert!(smoothed.half < 120.0 && left < limit, "{kind:?} {unit:e}: {left:e} {:?}", smoothed.half);
        }
    }
}

#[test]
fn a_harmonic_loses_what_its_order_says() {
    let series = Fourier::new(vec![0.0, 0.01, 0.0, 0.0, 0.002], vec![0.0; 5]);
    let points = measured(&MotionLaw::Fourier(series), 1e-6, 7);
    let smoothed = smooth(points.clone(), Some(1e-6), Outliers::Refuse, &[]).unwrap();
    let coefficient = |lifts: &[f64], k: usize| {
        let part = |(angle, lift): (&f64, &f64)| lift * (k as f64 * angle).cos();
        points.angles.iter().zip(lifts).map(part).sum::<f64>()
    };
    for k in [1, 4] {
        let kept = 1.0 / (1.0 + (k as f64 / smoothed.half).powi(6));
        let ratio = coefficient(&smoothed.points.lifts, k) / coefficient(&points.lifts, k);
        assert!((ratio - kept).abs() < 1e-9, "{k}: {ratio} {kept}");
    }
}

#[test]
fn the_points_are_their_own_smoothing_spline() {
    // The equations of the curve by finite differences of what it makes least, at nearly coincident angles and large gaps.
    let law = law(StandardLaw::Polynomial345);
    let mut random = Random(3);
    let mut angles: Vec<f64> = (0..60).map(|i| 0.102 * f64::from(i) + random.between(0.0, 0.09)).collect();
    angles.push(angles[59] + 2e-5);
    let lifts: Vec<f64> = angles.iter().map(|phi| law.at(*phi).0[0] + 1e-5 * random.normal()).collect();
    let rows = Rows::new(Points { angles: angles.clone(), lifts: lifts.clone() }).unwrap();
    let order = 9.0;
    let fit = rows.fit(&lifts, order);
    // ∫ s‴² of the spline through the values at the knots, by Gauss's rule of three points on each piece, which is exact.
    let least = |values: &[f64]| {
        let mut points = Points { angles: rows.knots.clone(), lifts: values.to_vec() };
        points.angles.push(rows.knots[0] + TAU);
        points.lifts.push(values[0]);
        let table = MotionLaw::Table(Table::new(points.clone()).unwrap());
        let node = 0.6_f64.sqrt();
        let piece = |pair: &[f64]| {
            let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
            let part = |(x, weight): (f64, f64)| weight * table.at(middle + half * x).0[3].powi(2);
            half * [(-node, 5.0), (0.0, 8.0), (node, 5.0)].into_iter().map(part).sum::<f64>() / 9.0
        };
        let energy: f64 = points.angles.windows(2).map(piece).sum();
        let distance: f64 = angles.iter().zip(&lifts).map(|(phi, lift)| (table.at(*phi).0[0] - lift).powi(2)).sum();
        distance + order.powi(-6) * energy / rows.unit
    };
    let values: Vec<f64> = fit.states.iter().map(|state| state[0]).collect();
    let own = least(&values);
    assert!((fit.least / own - 1.0).abs() < 1e-6, "{:e} {own:e}", fit.least);
    for _ in 0..20 {
        let other: Vec<f64> = values.iter().map(|value| value + 1e-6 * random.normal()).collect();
        let [more, less] = [1.0, -1.0].map(|sign| {
            let mixed: Vec<f64> = values.iter().zip(&other).map(|(a, b)| a + sign * (b - a)).collect();
            least(&mixed)
        });
        // Its differences of the first order are rounding beside those of the second.
        assert!(
            more > own && less > own && (more - less).abs() < 1e-4 * (more + less - 2.0 * own),
            "{more:e} {less:e} {own:e}"
        );
    }
}

#[test]
fn what_cannot_be_smoothed_is_named() {
    let law = law(StandardLaw::ModifiedSine);
    let exact = measured(&law, 0.0, 1);
    let smoothed = smooth(exact.clone(), None, Outliers::Refuse, &[]);
    assert!(matches!(smoothed, Err(SmoothingError::NoNoise)), "{:?}", smoothed.map(|s| (s.noise, s.half, s.changes)));
    assert!(matches!(smooth(exact, Some(0.02), Outliers::Refuse, &[]), Err(SmoothingError::NothingLeft(_))));
    let none = Points { angles: vec![0.0, 1.0], lifts: vec![0.0] };
    assert!(matches!(smooth(none, None, Outliers::Refuse, &[]), Err(SmoothingError::Table(_))));
}
