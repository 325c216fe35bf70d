//! Noisy laws whose motion is known.

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
fn points_at_unequal_distances() {
    // An encoder read at equal times of a turn whose speed fluctuates, and one that is read irregularly as well.
    let law = law(StandardLaw::ModifiedSine);
    for (fluctuation, irregular) in [(0.0, 0.0), (0.3, 0.0), (0.0, 0.3), (0.3, 0.2)] {
        for seed in 1..4 {
            let mut points = measured(&law, 0.0, seed);
            let noise = measured(&law, 5e-6, seed);
            let scattered = measured(&law, 1.0, seed + 10);
            for i in 0..360 {
                let even = points.angles[i];
                let part = (scattered.lifts[i] - points.lifts[i]).clamp(-1.0, 1.0);
                points.angles[i] = even + fluctuation * even.sin() + irregular * part * TAU / 720.0;
                let error = noise.lifts[i] - points.lifts[i];
                points.lifts[i] = law.at(points.angles[i]).0[0] + error;
            }
            let smoothed = smooth(points.clone(), None).unwrap();
            assert!((smoothed.noise / 5e-6 - 1.0).abs() < 0.2, "{:e}", smoothed.noise);
            let errors = [error(&law, points), error(&law, smoothed.points)];
            assert!(errors[0] > 1.0 && errors[1] < 0.05, "{fluctuation} {irregular}: {errors:?}");
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
    assert!(matches!(smooth(exact, Some(0.02)), Err(SmoothingError::NothingLeft(_))));
    let none = Points { angles: vec![0.0, 1.0], lifts: vec![0.0] };
    assert!(matches!(smooth(none, None), Err(SmoothingError::Table(_))));
}
