//! Messages about inputs that contradict each other, and cases without a message.

use super::*;
use crate::drives::shaft::cam_drive::{CamDrive, DriveMode};

/// The messages of a drive whose inputs are these functions of time, at steps of this length over a second.
fn told(step: f64, inputs: impl Fn(f64) -> [f64; 3]) -> Vec<(f64, &'static str)> {
    let mut cam = CamDrive::new((), DriveMode::Input);
    let mut log = EventLog::default();
    let set = |cam: &mut CamDrive<()>, t: f64| (0..3).for_each(|i| cam.set_input(i, inputs(t)[i]));
    set(&mut cam, 0.0);
    cam.start(0.0);
    let mut motion = cam.motion(0.0);
    for n in 0..(1.0 / step).round() as u32 {
        let time = step * f64::from(n);
        let [phi, w, ..] = motion.kinematics(time);
        set(&mut cam, time);
        cam.jumps([phi, w], time, &mut log);
        motion = cam.motion(time);
        cam.step_done(&motion, time + step);
    }
    log.iter().inspect(|event| assert_eq!(event.about, About::Inputs)).map(|event| (event.time, event.kind)).collect()
}

#[test]
fn inputs_that_belong_together_are_no_matter() {
    for step in [1e-5, 1e-3, 0.02] {
        // A run-up, with and without a, with φ within a turn.
        let run_up = |t: f64| [0.3 + 10.0 * t * t, 20.0 * t, 20.0];
        assert_eq!(told(step, run_up), []);
        assert_eq!(told(step, |t| [run_up(t)[0], run_up(t)[1], 0.0]), []);
        assert_eq!(told(step, |t| [run_up(t)[0].rem_euclid(TAU), run_up(t)[1], 20.0]), []);
        // A speed that fluctuates and one that changes its sign, 8 points or more to a period.
        let f = 40.0;
        for (mean, part) in [(20.0, 8.0), (0.0, 8.0), (-300.0, 1.0)] {
            let swing =
                |t: f64| [mean * t - part / f * (f * t).cos(), mean + part * (f * t).sin(), part * f * (f * t).cos()];
            assert_eq!(told(step.min(0.01), swing), [], "{step} {mean}");
            assert_eq!(told(step.min(0.01), |t| [swing(t)[0], swing(t)[1], 0.0]), [], "{step} {mean}");
        }
        // Typical errors of a master's solver, at standstill and near it.
        assert_eq!(told(step, |t| [100.0 + 1e-9 * (1e3 * t).sin(), 0.0, 0.0]), []);
        assert_eq!(told(step, |t| [5e-10 * (700.0 * t).cos(), 1e-9 * (-8.0 * t).exp(), 0.0]), []);
        // Rounded like the numbers of a table, to four decimals; and a jump of the speed alone.
        assert_eq!(told(0.01, |t| run_up(t).map(|x| (1e4 * x).round() / 1e4)), []);
        assert_eq!(told(step, |t| if t < 0.5 { [0.0, 0.0, 0.0] } else { [30.0 * (t - 0.5), 30.0, 0.0] }), []);
    }
}

#[test]
fn each_cause_is_told_once() {
    let run_up = |t: f64| [10.0 * t * t, 20.0 * t, 20.0];
    let told = |inputs: &dyn Fn(f64) -> [f64; 3]| told(0.01, inputs);
    let starts = |told: &[(f64, &str)], at: f64, cause: &str| {
        assert!(told.len() == 1 && (told[0].0 - at).abs() < 1e-12 && told[0].1 == cause, "{told:?}");
    };
    starts(&told(&|t| [0.0, run_up(t)[1], 0.0]), 0.03, NO_ANGLE);
    starts(&told(&|t| [0.0, run_up(t)[1], 20.0]), 0.01, NO_ANGLE);
    starts(&told(&|_| [0.7, -3.0, 0.0]), 0.01, NO_ANGLE);
    starts(&told(&|t| [run_up(t)[0], 0.0, 0.0]), 0.01, NO_SPEED);
    starts(&told(&|t| [run_up(t)[0], 0.0, 20.0]), 0.03, NO_SPEED);
    // Degrees, rpm, the other sense, a jump.
    starts(&told(&|t| [5.0 * t * 57.3, 5.0, 0.0]), 0.01, JUMPS);
    starts(&told(&|t| [5.0 * t, 5.0 * 9.55, 0.0]), 0.01, JUMPS);
    starts(&told(&|t| [-5.0 * t, 5.0, 0.0]), 0.01, JUMPS);
    starts(&told(&|t| [5.0 * t + if t > 0.301 { 0.1 } else { 0.0 }, 5.0, 0.0]), 0.31, JUMPS);
    // One cause after another.
    let both = told(&|t| [if t < 0.5 { 5.0 * t } else { 2.5 }, if t < 0.2 { 0.0 } else { 5.0 }, 0.0]);
    assert_eq!(both.iter().map(|told| told.1).collect::<Vec<_>>(), [NO_SPEED, NO_ANGLE]);
}

#[test]
fn a_start_forgets_what_was_told() {
    let (mut consistency, mut log) = (Consistency::begin([0.0; 2], 0.0), EventLog::default());
    for phi in [1.0, 2.0] {
        consistency.compare([phi, 0.0], [0.0; 2], 0.1, &mut log);
        assert_eq!(log.count(), 1);
    }
    consistency = Consistency::begin([0.0; 2], 0.0);
    consistency.compare([1.0, 0.0], [0.0; 2], 0.1, &mut log);
    assert_eq!(log.count(), 2);
}
