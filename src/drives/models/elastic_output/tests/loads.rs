//! Under loads, against numbers of two independent programs and against an integration of the equation itself.

use super::*;
use crate::drives::follower::load::Spring;

fn spring() -> Spring {
    Spring { preload: 40.0, c: 3000.0, at: 0.01 }
}

/// The load Q of the reference.
fn load_q() -> Load {
    let process = Fourier::new(vec![0.0, 20.0, -12.0], vec![0.0, 7.0, 0.0, 3.0]);
    Load {
        gravity: Some(-9.81),
        spring: Some(spring()),
        damping: Some(15.0),
        process: Some(MotionLaw::Fourier(process)),
        ..Load::default()
    }
}

/// HS profile of the reference with the stroke `h` (m).
fn hs(h: f64) -> MotionLaw {
    MotionLaw::Fourier(Fourier::new(vec![0.0, 0.5867 * h, 0.0, -0.0984 * h, 0.0, 0.0115 * h], vec![]))
}

fn get(drive: &ElasticOutput, name: &str) -> f64 {
    let list = drive.variables();
    list.0[list.reference(name).unwrap()].value(drive)
}

fn reference() -> Scene {
    let mode = DriveMode::Constant { w: 14.0, phi_start: 0.0 };
    Scene { load: load_q(), ..scene([2.0, 20000.0, 16.0], hs(0.06), mode, at_rest()) }
}

#[test]
fn the_case_of_the_reference() {
    for steps in [1, 9, 1000] {
        let drive = &mut drive(reference());
        run(drive, 0.9, 0.9 / f64::from(steps));
        for (name, expected, scale) in [
            ("y", 0.025163614349626, 0.03),
            ("der(y)", 0.0122018586467936, 0.5),
            ("contact_force", 96.3053413825294, 100.0),
            ("tau", 0.00220785268877654, 3.0),
        ] {
            let found = get(drive, name);
            assert!((found - expected).abs() < 1e-12 * scale, "{name} in {steps} steps: {found} not {expected}");
        }
    }
}
