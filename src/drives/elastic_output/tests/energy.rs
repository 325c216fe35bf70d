//! The balance of energy at constant speed.

use super::*;

fn residual(drive: &ElasticOutput) -> f64 {
    let list = drive.variables();
    let v = &list.0[list.reference("solver.energy_residual").unwrap()];
    (v.get)(drive, v.index)
}

#[test]
fn the_balance_closes_in_closed_form_and_on_the_table() {
    let cycle = |law| {
        MotionLaw::Cycle(Cycle::new(CyclePlan {
            stroke: 0.1,
            lower: 0.0,
            rise_start: 0.4,
            rise_angle: 2.0,
            upper_dwell: 1.0,
            return_angle: 1.7,
            rise_law: law,
            return_law: law,
        }))
    };
    for cam in [MotionLaw::Fourier(series()), cycle(ModifiedSine), cycle(Polynomial345)] {
        for (mcb, w) in
            [([2.0, 1.3e5, 20.0], 50.0), ([2.0, 1.3e5, 0.0], -50.0), ([0.1, 1e3, 1e3], 30.0), ([2.0, 1.3e9, 1.0], 5.0)]
        {
            let drive = &mut drive(scene(mcb, cam.clone(), DriveMode::Constant { w, phi_start: 0.3 }, given()));
            let mut largest = 0.0_f64;
            for n in 1..40 {
                run(drive, f64::from(n) * 0.0437, 0.0437);
                largest = largest.max(residual(drive));
            }
            assert!(0.0 < largest && largest < 1e-11, "{mcb:?} {w}: {largest:e}");
            // After many turns the instants themselves are rounded; a stiff drive on a cycle goes there in pieces.
            drive.advance(drive.now.time, if w == 5.0 { 10.0 } else { 1e5 }).unwrap();
            assert!(residual(drive) < 1e-11, "{mcb:?} {w}: {:e}", residual(drive));
        }
    }
}

#[test]
fn a_motion_that_is_not_the_drives_misses_the_balance() {
    // A spring that is stiffer than the one that the motion knows by a thousandth.
    let mut drive = harmonic_drive([2.0, 1.3e5, 20.0], 50.0, given());
    run(&mut drive, 0.3, 0.01);
    assert!(residual(&drive) < 1e-13);
    drive.c *= 1.001;
    assert!(residual(&drive) > 1e-7, "{:e}", residual(&drive));
}

#[test]
fn only_a_motion_that_is_known_between_the_steps_has_a_balance() {
    let drive = ElasticOutput::new(scene([1.0, 1e4, 1.0], MotionLaw::Fourier(series()), DriveMode::Input, at_rest()));
    assert!(drive.unwrap().variables().reference("solver.energy_residual").is_none());
}
