//! J(φ) from its table.

use super::*;

/// On the rise J is a polynomial of degree 12 in φ, next to which a harmonic of eight waves per turn is small.
fn short_wave() -> Scene {
    let cycle = Cycle::new(CyclePlan {
        stroke: 0.1,
        lower: 0.0,
        rise_start: 2.97,
        rise_angle: 1.72,
        upper_dwell: 2.12,
        return_angle: 0.94,
        rise_law: StandardLaw::Polynomial4567,
        return_law: StandardLaw::ModifiedSine,
        inflections: [None; 2],
    });
    let mut a = vec![0.0; 9];
    (a[1], a[8]) = (-1.6e-3, 1e-6);
    let wave = Fourier::new(a, vec![0.0, 3e-4]);
    let motor = Motor::Kloss(Kloss {
        breakdown_torque: 11.2,
        breakdown_slip: 1.09,
        synchronous_speed: 9.9,
        dynamics: Some(1.6e-3),
    });
    Scene {
        inertia: InertiaFunction { constant: 0.055, varying: None },
        followers: vec![Follower::new(9.8, MotionLaw::Cycle(cycle)), Follower::new(1.56, MotionLaw::Fourier(wave))],
        ..loom(motor, -2.5, 9.9)
    }
}

#[test]
fn a_small_wave_beside_a_polynomial_is_tabulated_to_rounding() {
    let scene = short_wave();
    let machine = started(scene.clone());
    for i in 0..2000 {
        let phi = TAU * (f64::from(i) + 0.5) / 2000.0;
        let exact = 0.055 + scene.followers.iter().map(|f| f.m * f.cam.at(phi).0[1].powi(2)).sum::<f64>();
        let (interval, phi) = machine.shaft.inertia.interval(angle::reduce(Double::from(phi)), true);
        assert!(machine.shaft.profile.holds(interval, phi), "an interval has no table");
        let [tabulated, _] = machine.shaft.profile.with_slope(interval, phi);
        assert_near(tabulated, exact, 3e-14, &format!("J at {phi}"));
    }
}

/// Energy, time and torque over the angle, integrated in 80-bit arithmetic by extrapolation of order 16 from breakpoint to
/// breakpoint; halving the step changes them below 1e-15.
#[test]
fn the_motion_obeys_the_tolerance_beside_a_small_wave() {
    let expected = [("phi", 3.78115593642756448), ("w", 6.84416895913909339), ("M_an", 5.90404574563361195)];
    for tolerance in [1e-9, 1e-12, 1e-13] {
        let settings = Settings { tolerance, ..Settings::default() };
        let mut machine = started(Scene { solver: settings, ..short_wave() });
        machine.shaft.loads.signal_mut(0).unwrap().set(-0.09);
        run(&mut machine, 0.64, 32);
        for (name, value) in expected {
            assert_near(get(&machine, name), value, tolerance.max(3e-13), &format!("{name} at {tolerance}"));
        }
        let inertia = get(&machine, "J");
        assert_near(inertia, 0.2104720761414330523, 3.0 * tolerance.max(3e-13), &format!("J at {tolerance}"));
    }
}
