//! The closed form of the motion against its power series.

use super::*;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The drive without the closed form.
fn by_series(scene: Scene) -> BacklashDrive {
    let mut drive = started(scene);
    drive.bodies = Arc::new(Bodies { waves: None, ..*drive.bodies });
    drive.begin(0.0, [0.0; 2]);
    drive
}

#[test]
fn the_closed_form_is_the_power_series() {
    let mut impacts = 0.0;
    for w in [-60.0, 20.0, 45.0] {
        for s in [0.0, 2e-5, 4e-4] {
            for (b, e) in [(0.0, 0.0), (200.0, 0.0), (20.0, 0.6), (0.0, 0.95)] {
                let scene = scene(w, s, b, e);
                let (mut closed, mut series) = (started(scene.clone()), by_series(scene));
                assert!(closed.bodies.waves.is_some() && series.bodies.waves.is_none());
                let (size, fastest) = (closed.bounds[0], closed.bounds[1] * w.abs());
                for step in 0..60 {
                    let h = TAU / w.abs() / 40.0;
                    let t = f64::from(step) * h;
                    closed.advance(t, h).unwrap();
                    series.advance(t, h).unwrap();
                    let [one, other] = [&closed, &series].map(|d| d.point().state);
                    let bound = closed.solver.error_estimate + series.solver.error_estimate + 1e-13;
                    // What bounces on is chaotic.
                    if bound > 1e-7 {
                        break;
                    }
                    let place = |s: State| s.home + s.zeta[0];
                    let case = format!("w {w} s {s} b {b} e {e} t {t}: {one:?} {other:?} {bound:e}");
                    assert!((one.q[0] - other.q[0]).abs() <= bound * size, "{case}");
                    assert!((one.q[1] - other.q[1]).abs() <= bound * fastest * 30.0, "{case}");
                    assert!((place(one) - place(other)).abs() <= bound * size, "{case}");
                    assert_eq!(closed.now.tally.impacts, series.now.tally.impacts, "{case}");
                    let [bent, expected] = [&closed, &series].map(|d| {
                        let run = d.run.as_ref().unwrap();
                        run.panel.flank_acceleration(&d.bodies, run.theta(d.now.time))
                    });
                    let contact = closed.now.mode != Mode::Free;
                    assert!(!contact || (bent - expected).abs() <= 1e-11 * fastest * w.abs(), "{case}");
                    let [force, torque] = closed.mean();
                    let [expected, load] = series.mean();
                    let scale = 1e-9 + 1e3 * bound;
                    let largest = (closed.m1 + closed.m2) * fastest * w.abs() * 100.0;
                    assert!((force - expected).abs() <= scale * largest, "{case} {force} {expected}");
                    assert!((torque - load).abs() <= scale * largest * size, "{case} {torque} {load}");
                    let [lost, other] = [&closed, &series].map(|d| d.damping_loss());
                    assert!((lost - other).abs() <= 1e-9 * lost.max(1e-9), "{case} {lost} {other}");
                }
                impacts += closed.now.tally.impacts;
                // The closed form passes as much in one panel as the series in several.
                assert!(s == 0.0 || closed.now.tally.panels <= series.now.tally.panels);
            }
        }
    }
    assert!(impacts > 100.0, "{impacts}");
}
