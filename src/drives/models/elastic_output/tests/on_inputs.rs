//! Steps on inputs that go on unchanged.

use super::*;

/// φ, ω, α of a speed that rises within 0.5 s, stays and falls from 2 s on.
fn motion(t: f64) -> [f64; 3] {
    match t {
        t if t < 0.5 => [0.3 + 30.0 * t * t, 60.0 * t, 60.0],
        t if t < 2.0 => [7.8 + 30.0 * (t - 0.5), 30.0, 0.0],
        t => [52.8 + (t - 2.0) * (30.0 - 20.0 * (t - 2.0)), 30.0 - 40.0 * (t - 2.0), -40.0],
    }
}

/// From 0 to 3 s in so many steps, as importers make them; at every `look`th step outputs are read after setting the inputs, and c
/// changes at 1.6 s. Returns q, q̇ and the steps of the solver between 1 s and 1.5 s.
fn run_on_inputs(per_second: u32, look: u32) -> ([f64; 2], f64) {
    let mut scene = scene([1.0, 1e4, 5.0], MotionLaw::Fourier(series()), DriveMode::Input, at_rest());
    scene.solver.tolerance = 1e-13;
    let mut drive = ElasticOutput::new(scene).unwrap();
    drive.cam.set_inputs(motion(0.0));
    drive.start(0.0).unwrap();
    let mut steps = [0.0; 2];
    for n in 0..3 * per_second {
        let [time, end] = [n, n + 1].map(|n| f64::from(n) / f64::from(per_second));
        for (steps, mark) in steps.iter_mut().zip([1.0, 1.5]) {
            *steps = if time == mark { drive.statistics()[0] } else { *steps };
        }
        drive.cam.set_inputs(motion(time));
        if time == 1.6 {
            drive.parameters.c = 1.3e4;
        }
        if n % look == 0 || time == 1.6 {
            drive.apply(time).unwrap();
        }
        drive.advance(time, end - time).unwrap();
    }
    (drive.now.q.array(), steps[1] - steps[0])
}

#[test]
fn steps_that_go_on_lead_where_long_ones_lead() {
    let (expected, _) = run_on_inputs(20, 1);
    for (per_second, look) in [(100, 3), (1000, 1_000_000), (1000, 7), (10_000, 500)] {
        let (found, steps) = run_on_inputs(per_second, look);
        let scale = expected[0].abs() + expected[1].abs() / 100.0;
        assert_near(off(found, expected, scale, 100.0), 2e-12, &format!("{per_second} steps per second"));
        // The closed form takes no steps; with long ones a stretch of quadratures is not yet over.
        assert!(per_second == 100 || steps == 0.0, "{per_second}: {steps}");
    }
}
