//! Where laws change the sign of U″.

use crate::clearance::IGNORE;
use crate::clearance::law::{Signs, changes, signs};
use camdrive::motion::table::{Points, Table};
use camdrive::motion::{Cycle, CyclePlan, Fourier, MotionLaw, MotionPlan, PlanPoint, StandardLaw};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn cycle(law: StandardLaw) -> MotionLaw {
    MotionLaw::Cycle(Cycle::new(CyclePlan {
        stroke: 0.04,
        lower: -0.01,
        rise_start: 5.9,
        rise_angle: 1.5,
        upper_dwell: 0.7,
        return_angle: 2.0,
        rise_law: law,
        return_law: law,
        inflections: [None; 2],
    }))
}

#[test]
fn a_dwell_cycle_changes_sides_in_the_middle_of_rise_and_return() {
    for law in StandardLaw::ALL {
        let Signs { crossings, largest, .. } = signs(&cycle(law), true, IGNORE);
        assert_eq!(crossings.len(), 2, "{law:?}");
        let middles = [5.9 + 0.75 - TAU, 5.9 + 1.5 + 0.7 + 1.0 - TAU];
        let slopes = [0.04 / 1.5f64.powi(3), -0.04 / 8.0].map(|factor| factor * law.at(0.5)[3]);
        for ((crossing, phi), jerk) in crossings.iter().zip(middles).zip(slopes) {
            assert!((crossing.phi - phi).abs() < 1e-14, "{law:?}: {crossing:?}");
            assert!((crossing.jerk - jerk).abs() < 1e-13 * jerk.abs());
        }
        assert!((largest / (0.04 / 2.25 * law.peak(2)) - 1.0).abs() < 1e-13, "{law:?}: {largest}");
    }
}

#[test]
fn a_cosine_changes_sides_at_right_angles() {
    let law = MotionLaw::Fourier(Fourier::new(vec![0.0, 0.0, 0.0, -0.02], vec![]));
    let Signs { crossings, .. } = signs(&law, true, IGNORE);
    assert_eq!(crossings.len(), 6);
    for (i, crossing) in crossings.iter().enumerate() {
        assert!((crossing.phi - (FRAC_PI_2 + PI * i as f64) / 3.0).abs() < 1e-15 * TAU);
        assert!((crossing.jerk.abs() - 0.02 * 27.0).abs() < 1e-15 && crossing.fourth.abs() < 1e-12);
    }
}

#[test]
fn no_close_pair_of_zeros_is_missed_and_a_touch_is_none() {
    // U″ = cos 2φ + c cos φ, c a little below or above 2√2 … the double zero of 2x² + cx − 1 + d.
    for depth in [1e-3, 1e-6, -1e-3, -1e-6] {
        // 2 (cos φ − ½)² − depth = cos 2φ − 2 cos φ + 1.5 − depth has a mean; a third harmonic would too: take U″ = sin φ
        // times it, which has none: sin φ (2 (cos φ − ½)² − depth) = ½ sin 3φ − sin 2φ + (1 − depth) sin φ.
        let b = vec![0.0, -(1.0 - depth), 0.25, -0.5 / 9.0];
        let law = MotionLaw::Fourier(Fourier::new(vec![0.0], b));
        let Signs { crossings, .. } = signs(&law, true, 1e-12);
        // 0, π, and for depth > 0 the four angles ± arccos(½ ± √(depth/2)).
        assert_eq!(crossings.len(), if depth > 0.0 { 6 } else { 2 }, "{depth}: {crossings:?}");
        if depth > 0.0 {
            let half = (0.5 * depth).sqrt();
            let expected = [0.5 + half, 0.5 - half].map(f64::acos);
            for phi in expected {
                assert!(crossings.iter().any(|c| (c.phi - phi).abs() < 1e-13 / half), "{depth}: {crossings:?}");
            }
            // As rest they are none.
            assert_eq!(signs(&law, true, 0.01).crossings.len(), 2);
            assert_eq!(signs(&law, true, 0.01).ignored, 4);
        }
    }
}

#[test]
fn a_law_of_few_harmonics_swings_through_its_dwells() {
    let Signs { crossings: exact, .. } = signs(&cycle(StandardLaw::InclinedSine), true, IGNORE);
    let own = cycle(StandardLaw::InclinedSine);
    let angles: Vec<f64> = (0..1024).map(|i| TAU * f64::from(i) / 1024.0).collect();
    let lifts: Vec<f64> = angles.iter().map(|phi| own.at(*phi).0[0]).collect();
    let points = Points { angles, lifts };
    let series = crate::harmonic_analysis::analyse(points.clone(), 5).unwrap().series;
    let Signs { crossings, .. } = signs(&MotionLaw::Fourier(series), true, IGNORE);
    assert!(exact.len() == 2 && crossings.len() > 4, "{}", crossings.len());
    // A spline through exact points ripples in the dwells, by little.
    let table = MotionLaw::Table(Table::new(points).unwrap());
    assert!(signs(&table, true, 0.0).crossings.len() >= 2);
    let coarse = signs(&table, true, 1e-2);
    assert_eq!(coarse.crossings.len(), 2, "{coarse:?}");
    assert!((coarse.crossings[0].phi - exact[0].phi).abs() < 1e-3);
}

#[test]
fn what_stands_still_passes_nothing() {
    let still = MotionLaw::Fourier(Fourier::new(vec![0.3], vec![]));
    let Signs { crossings, largest, ignored } = signs(&still, false, IGNORE);
    assert_eq!((crossings.len(), largest, ignored), (0, 0.0, 0));
}

#[test]
fn between_accelerations_of_opposite_sign_a_rest_ends_with_a_passage() {
    // Two rises with a rest of 40° between them, wherever the angle begins, in both senses.
    let plan = [(10, 0.0), (60, 0.01), (100, 0.01), (160, 0.02), (200, 0.02), (300, 0.0)];
    for shift in [0, 280, 250, 300, 321, -160] {
        let angle = |phi: i32| f64::from((phi + shift).rem_euclid(360)).to_radians();
        let point = |(phi, u)| PlanPoint {
            phi: angle(phi),
            u,
            velocity: None,
            acceleration: None,
            free: false,
            jerk: None,
            law: None,
            inflection: None,
        };
        let mut points = plan.map(point);
        points.sort_by(|a, b| a.phi.total_cmp(&b.phi));
        let law = MotionLaw::Plan(MotionPlan::new(points.to_vec()));
        let (rest, middles) = ([60, 100].map(angle), [35, 130, 250].map(angle));
        for (forward, end) in [(true, rest[1]), (false, rest[0])] {
            let Signs { crossings, ignored, .. } = signs(&law, forward, IGNORE);
            assert_eq!((crossings.len(), ignored), (4, 0), "{shift}: {crossings:?}");
            for phi in middles.into_iter().chain([end]) {
                let off = |a: f64| (a - phi - TAU * ((a - phi) / TAU).round()).abs();
                let crossing = crossings.iter().find(|c| off(c.phi) < 1e-12);
                assert!(crossing.is_some_and(|c| c.jerk != 0.0), "{shift} {forward} {phi}: {crossings:?}");
            }
        }
    }
}

#[test]
fn signs_change_with_high_lobes() {
    assert_eq!(changes(&[9.0, -1.0, 8.0, -7.0], 2.0), [0, 3]);
    assert_eq!(changes(&[9.0, -8.0, 7.0, -1.0], 2.0), [1, 2]);
    // Behind the ripple of a rest.
    assert_eq!(changes(&[1.0, -9.0, 1.0, -1.0, 8.0, -1.0], 2.0), [1, 4]);
    assert_eq!(changes(&[9.0, -1.0], 2.0), [0; 0]);
    assert_eq!(changes(&[9.0, -8.0], 2.0), [0, 1]);
    assert_eq!(changes(&[], 2.0), [0; 0]);
}
