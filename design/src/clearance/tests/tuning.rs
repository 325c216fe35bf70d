//! Tuning of a drive: intervals of frequencies, speeds, clearances and masses.

use crate::clearance::borders::Sequel;
use crate::clearance::borders::{admissible, sequel};
use crate::clearance::tuning::*;
use crate::formulas::passage::Passage;

fn holds(intervals: &Intervals, value: f64) -> bool {
    intervals.iter().any(|[low, high]| (*low..=*high).contains(&value))
}

#[test]
fn inside_of_the_intervals_no_passage_has_a_second_impact_and_outside_one_has() {
    let passages = Passages {
        jerks: vec![0.0132, 0.059, 0.02],
        curvatures: vec![20.0, 4.0, 1.0],
        s: 2e-4,
        omega: 400.0,
        speed: 25.0,
        m2: 8.0,
    };
    // K does not depend on m1, so that its intervals are the same whatever μ is.
    let tuning = Tuning::new(admissible(0.2), &passages).unwrap();
    // Two of these K are above K_el(0), so that there is a least m1.
    assert!(!tuning.mass_cut && tuning.mass.last().unwrap()[1].is_infinite());
    for i in -500..5000 {
        let mu = tuning.mass[0][0] / 8.0 * 1.002_f64.powi(i);
        let k = |jerk: &f64| 2e-4 / jerk * 16.0_f64.powi(3);
        let calm = passages.jerks.iter().all(|jerk| sequel(&Passage::new(mu, k(jerk))) == Sequel::None);
        // The first sample lies on a border.
        assert!(i == 0 || calm == holds(&tuning.mass, 8.0 * mu), "μ = {mu}");
    }
    for mu in [0.02, 0.07, 0.2, 0.25, 3.0] {
        let tuning = Tuning::new(admissible(mu), &passages).unwrap();
        let calm = |omega: f64, speed: f64, s: f64| {
            let k = |jerk: &f64| s / jerk * (omega / speed).powi(3);
            passages.jerks.iter().all(|jerk| sequel(&Passage::new(mu, k(jerk))) == Sequel::None)
        };
        for i in 1..4000 {
            let part = 0.002 * f64::from(i);
            let [omega, speed, s] = [400.0 * part, 25.0 * part, 2e-4 * part * part];
            assert_eq!(calm(omega, 25.0, 2e-4), holds(&tuning.frequency, omega), "μ = {mu}, ω = {omega}");
            assert_eq!(calm(400.0, speed, 2e-4), holds(&tuning.speed, speed), "μ = {mu}, Ω = {speed}");
            assert_eq!(calm(400.0, 25.0, s), holds(&tuning.clearance, s), "μ = {mu}, s = {s}");
        }
    }
}
