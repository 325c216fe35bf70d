//! Cams so light that the inertia changes a hundredfold and more over the turn, on inputs: in a dwell the twist dies out or swings
//! fast; while the cam lifts the follower, the remaining twist moves differently.

use super::extremes::{AT_REST, Random, assert_honest, random_scene};
use super::*;

/// q, q̇ at the end of each communication step between such inputs (time, φ, w, a), and the error estimate.
fn states(scene: &Scene, inputs: &[[f64; 4]]) -> Option<(Vec<[f64; 2]>, f64)> {
    let mut drive = ElasticShaft::new(scene.clone()).unwrap();
    let mut all = Vec::new();
    for (n, step) in inputs.windows(2).enumerate() {
        let [time, phi, w, a] = step[0];
        drive.cam.set_inputs([phi, w, a]);
        if n == 0 {
            drive.start(time).unwrap();
        }
        drive.advance(time, step[1][0] - time).ok()?;
        all.push(drive.state);
    }
    Some((all, drive.solver.error_estimate))
}

/// The largest difference of two runs, of q and q̇ relative to the largest value read.
fn difference(got: &[[f64; 2]], truth: &[[f64; 2]]) -> f64 {
    let of = |c: usize| {
        let largest = truth.iter().map(|y| y[c].abs()).fold(f64::MIN_POSITIVE, f64::max);
        got.iter().zip(truth).map(|(got, truth)| (got[c] - truth[c]).abs() / largest).fold(0.0, f64::max)
    };
    of(0).max(of(1))
}

fn scene(cam: MotionLaw, parameters: Parameters, tolerance: f64) -> Scene {
    Scene {
        load: Load::default(),
        parameters,
        linear: false,
        cam,
        drive: DriveMode::Input,
        start: AT_REST,
        solver: Settings { tolerance, ..Settings::default() },
    }
}

#[test]
fn a_motion_after_a_dwell_is_measured_by_itself() {
    // Backwards from the rise, where the cam swings at thousands of rad/s, through a dwell in which that dies out, to the return,
    // in which q̇ is 0.08 rad/s at most. An independent integration gives the right values at the end.
    let cycle = Cycle::new(CyclePlan {
        stroke: -0.10035463290888946,
        lower: 0.027081135906944786,
        rise_start: -1.499086450374797,
        rise_angle: 1.3177306967307865,
        upper_dwell: 0.0,
        return_angle: 2.8040414197169645,
        rise_law: StandardLaw::Polynomial4567,
        return_law: StandardLaw::InclinedSine,
        inflections: [Some(0.6853189643673181), Some(0.2830718473825555)],
    });
    let (m, inertia) = (14.580686613417404, 0.0006654035102239604);
    let parameters = Parameters { m, inertia, c: 7284760.514029818, b: 66.37507582131845 };
    let inputs = [
        [0.0, 81.35738294851035, -528.4833984375, 25600.0],
        [0.0028362274169921875, 79.9614494247362, -455.8759765625, 25600.0],
        [0.008758544921875, 77.71055235993117, -304.2646484375, 25600.0],
        [0.011889457702636719, 0.0, 0.0, 0.0],
    ];
    let right = [0.00014061690913314923, -0.057527572621964423];
    for (tolerance, bound) in [(0.0, 1e-9), (1e-6, 1e-5)] {
        let (got, estimate) = states(&scene(MotionLaw::Cycle(cycle.clone()), parameters, tolerance), &inputs).unwrap();
        let error = [0, 1].map(|c| (got[2][c] / right[c] - 1.0).abs());
        assert!(error[0].max(error[1]) < estimate.min(bound), "{tolerance:e}: {error:?}, {estimate:e}");
    }
}

/// A random drive with J/(m U′²max) between 1e-4 and 0.03, and inputs of piecewise constant acceleration.
fn light_cam(r: &mut Random) -> (Scene, Vec<[f64; 4]>) {
    let (mut scene, _) = random_scene(r);
    let Parameters { m, c, .. } = scene.parameters;
    let heavy = m * scene.cam.bound(1).max(1e-3).powi(2);
    let inertia = heavy * r.scale(1e-4, 0.03);
    let b = if r.next() < 0.3 { 0.0 } else { 2.0 * r.scale(1e-3, 2.0) * (c * inertia).sqrt() };
    scene.parameters = Parameters { m, inertia, c, b };
    (scene.linear, scene.drive) = (false, DriveMode::Input);
    scene.start = if r.next() < 0.7 { AT_REST } else { scene.start };
    scene.solver.tolerance = if r.next() < 0.5 { 0.0 } else { r.scale(1e-12, 1e-3) };
    let mut w = (c / heavy).sqrt() / r.scale(1.0, 30.0) * if r.next() < 0.5 { -1.0 } else { 1.0 };
    let (speed, mut time, mut phi) = (w.abs(), 0.0, r.between(-10.0, 10.0));
    let count = r.scale(3.0, 100.0) as usize;
    let mut inputs = Vec::new();
    for _ in 0..count {
        let step = 10.0 / count as f64 / speed * r.scale(0.3, 3.0);
        let a = if r.next() < 0.3 { 0.0 } else { speed * speed * r.between(-0.1, 0.1) };
        inputs.push([time, phi, w, a]);
        phi += (w + 0.5 * a * step) * step;
        w += a * step;
        time += step;
    }
    inputs.push([time, phi, w, 0.0]);
    (scene, inputs)
}

#[test]
fn the_error_estimate_of_light_cams_is_honest() {
    let r = &mut Random(31);
    let mut ratios = Vec::new();
    for _ in 0..130 {
        let (scene, inputs) = light_cam(r);
        if scene.cam.bound(1) == 0.0 {
            continue;
        }
        let finest = Scene { solver: Settings { tolerance: 1e-14, ..Settings::default() }, ..scene.clone() };
        let [Some((got, estimate)), Some((truth, known))] = [&scene, &finest].map(|scene| states(scene, &inputs))
        else {
            continue;
        };
        let error = difference(&got, &truth);
        let ratio = estimate / error.max(1e-15);
        // A difference that the truth's own error may cause does not count.
        ratios.push(if error <= estimate + known { ratio.max(1.0) } else { ratio });
    }
    assert_honest("light cams", ratios, 2000.0);
}
