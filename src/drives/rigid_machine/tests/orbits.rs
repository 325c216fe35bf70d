//! All periodic motions: the machine with one or three of them, the loom, the free motion.

use super::super::orbits::{free_motion, periodic_motions, range};
use super::super::*;
use crate::motion::{Fourier, MotionLaw};

/// J = 1 + 0.3 tanh(4 sin φ), whose harmonics fall like e^{−0.38 k}.
fn machine(s_k: f64, lag: Option<f64>) -> Scene {
    let n = 401;
    let angles = (0..n).map(|i| TAU * f64::from(i) / f64::from(n));
    let values: Vec<f64> = angles.clone().map(|phi| 0.3 * (4.0 * phi.sin()).tanh()).collect();
    let coefficient = |k: usize, f: fn(f64) -> f64| {
        let sum: f64 = angles.clone().zip(&values).map(|(phi, v)| v * f(k as f64 * phi)).sum();
        sum * if k == 0 { 1.0 } else { 2.0 } / f64::from(n)
    };
    let a = (0..=90).map(|k| coefficient(k, f64::cos)).collect();
    let b = (0..=90).map(|k| coefficient(k, f64::sin)).collect();
    Scene {
        inertia: InertiaFunction { constant: 1.0, varying: Some(MotionLaw::Fourier(Fourier::new(a, b))) },
        followers: Vec::new(),
        motor: Motor::Kloss { breakdown_torque: 15.0, breakdown_slip: s_k, synchronous_speed: 50.0, dynamics: lag },
        phi_start: 0.0,
        w_start: 0.0,
        start: MachineStart::Given,
        solver: Settings::default(),
    }
}

#[test]
fn a_machine_may_have_three_periodic_motions() {
    let motions = periodic_motions(&machine(0.08, None), 0.0).unwrap();
    let expected = [(1487.91, true), (1100.23, false), (973.06, true)];
    assert_eq!(motions.len(), 3, "{motions:?}");
    for (motion, (energy, stable)) in motions.iter().zip(expected) {
        assert!((motion.energy - energy).abs() < 6e-3, "{} {energy}", motion.energy);
        assert_eq!(motion.multiplier < 1.0, stable);
        assert!(motion.multiplier > 0.0);
        // ∮ dφ/ω by the trapezoidal rule over the course.
        let sum: f64 =
            motion.course.windows(2).map(|p| (p[1][0] - p[0][0]) * 0.5 * (1.0 / p[0][1] + 1.0 / p[1][1])).sum();
        assert!((sum / motion.period - 1.0).abs() < 1e-4, "{sum} {}", motion.period);
    }
    assert_eq!(periodic_motions(&machine(0.15, None), 0.0).unwrap().len(), 1);
    // A short lag changes them little.
    let lagging = periodic_motions(&machine(0.08, Some(1e-4)), 0.0).unwrap();
    assert_eq!(lagging.len(), 3);
    for (with, without) in lagging.iter().zip(&motions) {
        assert!((with.period / without.period - 1.0).abs() < 2e-3);
        assert!(with.course.len() > 700);
    }
}

#[test]
fn the_orbit_that_a_simulation_starts_with_is_one_of_them() {
    for load in [0.0, 9.0, -9.0] {
        let scene = Scene { start: MachineStart::SteadyState, ..machine(0.3, None) };
        let mut drive = RigidMachine::new(scene.clone()).unwrap();
        drive.load.set(load);
        drive.start_periodically(0.0).unwrap();
        let motions = periodic_motions(&scene, load).unwrap();
        // A load is also balanced by a motion beyond the breakdown slip, slower for one that brakes and faster for one
        // that drives, which is unstable.
        assert_eq!(motions.len(), if load == 0.0 { 1 } else { 2 }, "{load}");
        let stable: Vec<_> = motions.iter().filter(|motion| motion.multiplier < 1.0).collect();
        assert_eq!(stable.len(), 1);
        assert_eq!(motions[0] == *stable[0], load >= 0.0);
        assert!((stable[0].period / drive.period - 1.0).abs() < 1e-12, "{load}");
        let [low, high] = range(&stable[0].course);
        assert!(low <= drive.state.w && drive.state.w <= high);
    }
    // Beyond the breakdown torque there is none.
    assert!(periodic_motions(&machine(0.3, None), 16.0).unwrap().is_empty());
    let without = Scene { motor: Motor::None, ..machine(0.3, None) };
    assert!(periodic_motions(&without, 0.0).is_err());
}

#[test]
fn the_free_motion_keeps_its_energy_and_its_period() {
    let scene = machine(0.3, None);
    let inertia = Inertia::new(scene.inertia, scene.followers);
    let course = free_motion(&inertia, 0.125, -1.0);
    let energy = |[phi, w]: [f64; 2]| inertia.at(inertia::Place::at(phi), phi)[0] * w * w;
    let first = energy(course[0]);
    assert!(course.iter().all(|at| (energy(*at) / first - 1.0).abs() < 1e-13 && at[1] < 0.0));
    // The trapezoidal rule over a whole turn of a smooth periodic function is exact to rounding.
    let period: f64 = course[1..].iter().map(|[_, w]| TAU / 720.0 / w.abs()).sum();
    assert!((period / 0.125 - 1.0).abs() < 1e-12, "{period}");
}
