//! The error estimate against the error, over random scenes.

use super::*;
use crate::drives::solver::contact::panel::Point;
use crate::motion::{Cycle, CyclePlan, StandardLaw};
use std::f64::consts::TAU;

/// Uniform numbers in [0, 1): a linear congruential generator, Knuth's MMIX.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.roll()
    }

    fn log_between(&mut self, low: f64, high: f64) -> f64 {
        (low.ln() + (high / low).ln() * self.roll()).exp()
    }
}

const TOLERANCES: [f64; 6] = [0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3];

/// A law of up to four harmonics, or one with dwells.
fn random_law(dice: &mut Dice) -> MotionLaw {
    if dice.roll() < 0.25 {
        let law = |dice: &mut Dice| StandardLaw::ALL[(dice.roll() * StandardLaw::ALL.len() as f64) as usize];
        let angles = [dice.between(0.3, 1.0), dice.between(0.0, 0.5), dice.between(0.3, 1.0), dice.between(0.0, 0.5)];
        let unit = TAU / angles.iter().sum::<f64>();
        return MotionLaw::Cycle(Cycle::new(CyclePlan {
            stroke: 0.01,
            lower: 0.0,
            rise_start: dice.between(0.0, TAU),
            rise_angle: angles[0] * unit,
            upper_dwell: angles[1] * unit,
            return_angle: angles[2] * unit,
            rise_law: law(dice),
            return_law: law(dice),
            inflections: [None; 2],
        }));
    }
    let order = 1 + (dice.roll() * 4.0) as usize;
    let (mut a, mut b) = (vec![0.0], vec![0.0]);
    for k in 1..=order {
        let size = 0.01 / (k * k) as f64;
        a.push(dice.between(-size, size));
        b.push(dice.between(-size, size));
    }
    MotionLaw::Fourier(Fourier::new(a, b))
}

/// A scene, and how long it runs (s): from a fiftieth of a turn to fifty turns.
fn random(dice: &mut Dice, tolerance: f64) -> (Scene, f64) {
    let cam = random_law(dice);
    let m2 = dice.log_between(0.5, 20.0);
    let m1 = m2 * dice.log_between(0.1, 3.0);
    let w = dice.between(10.0, 80.0);
    let omega = w * dice.log_between(3.0, 40.0);
    let c = m2 * omega * omega;
    let damping = if dice.roll() < 0.3 { 0.0 } else { dice.log_between(1e-3, 0.5) };
    let e = if dice.roll() < 0.5 { 0.0 } else { dice.between(0.0, 0.95) };
    let s = dice.log_between(1e-5, 1e-3);
    let start = if dice.roll() < 0.5 {
        Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 }
    } else {
        let q = dice.between(-1e-4, 1e-4);
        Start { mode: StartMode::Given, q, q_dot: omega * dice.between(-1e-4, 1e-4) }
    };
    let scene = Scene {
        coupling: false,
        parameters: Parameters { m1, m2, c, b: 2.0 * damping * m2 * omega, s, e },
        cam,
        drive: DriveMode::Constant { w, phi_start: dice.between(0.0, TAU) },
        start,
        solver: Settings { tolerance, ..Settings::default() },
    };
    (scene, dice.log_between(0.02, 50.0) * TAU / w)
}

/// x1, x2, ẋ1, ẋ2 at the end, with the estimate. `ramp` (1/s²): moved by inputs whose speed changes at this rate.
fn end(scene: Scene, span: f64, ramp: Option<f64>) -> ([f64; 4], f64) {
    let DriveMode::Constant { w, phi_start } = scene.drive else { unreachable!("random scenes have a speed") };
    let mut drive;
    if let Some(a) = ramp {
        drive = BacklashDrive::new(Scene { drive: DriveMode::Input, ..scene }).unwrap();
        let variables = drive.variables().0;
        let set = |drive: &mut BacklashDrive, t: f64| {
            for (reference, value) in [phi_start + w * t + 0.5 * a * t * t, w + a * t, a].into_iter().enumerate() {
                variables[reference].set(drive, value);
            }
        };
        set(&mut drive, 0.0);
        drive.start(0.0).unwrap();
        for step in 0..64 {
            let t = f64::from(step) * span / 64.0;
            set(&mut drive, t);
            drive.advance(t, span / 64.0).unwrap();
        }
    } else {
        drive = started(scene);
        drive.advance(0.0, span).unwrap();
    }
    let Point { state, u } = drive.now.point;
    let (x, v) = (u[0] + state.home + state.zeta[0], u[1] + state.zeta[1]);
    ([x, x + state.q[0], v, v + state.q[1]], drive.solver.error_estimate)
}

/// The same motion three times as large, with a cam turned on its shaft: all roundings differ.
fn rounded_otherwise(scene: &Scene) -> Scene {
    let DriveMode::Constant { w, phi_start } = &scene.drive else { unreachable!("random scenes have a speed") };
    let cam = match &scene.cam {
        MotionLaw::Fourier(law) => {
            let turned = |k: usize| {
                let (sin, cos) = (k as f64).sin_cos();
                [3.0 * (law.a[k] * cos - law.b[k] * sin), 3.0 * (law.a[k] * sin + law.b[k] * cos)]
            };
            let terms: Vec<[f64; 2]> = (0..law.a.len()).map(turned).collect();
            let [cosines, sines] = [0, 1].map(|i| terms.iter().map(|t| t[i]).collect());
            MotionLaw::Fourier(Fourier::new(cosines, sines))
        }
        MotionLaw::Cycle(cycle) => {
            let plan = *cycle.plan();
            let (stroke, rise_start) = (3.0 * plan.stroke, (plan.rise_start + 1.0).rem_euclid(TAU));
            MotionLaw::Cycle(Cycle::new(CyclePlan { stroke, rise_start, ..plan }))
        }
        _ => unreachable!("the random laws are series and cycles"),
    };
    Scene {
        coupling: false,
        cam,
        parameters: Parameters { s: 3.0 * scene.parameters.s, ..scene.parameters },
        start: Start { q: 3.0 * scene.start.q, q_dot: 3.0 * scene.start.q_dot, ..scene.start },
        drive: DriveMode::Constant { w: *w, phi_start: phi_start + 1.0 },
        solver: Settings::default(),
    }
}

#[test]
fn the_error_estimate_is_honest() {
    let mut dice = Dice(20_261_121);
    let mut ratios: Vec<f64> = Vec::new();
    for number in 0..300 {
        let (scene, span) = random(&mut dice, TOLERANCES[number % TOLERANCES.len()]);
        let DriveMode::Constant { w, .. } = scene.drive else { unreachable!("random scenes have a speed") };
        let ramp = (dice.roll() < 0.5).then(|| dice.between(-0.5, 0.5) * w / span);
        let (found, estimate) = end(scene.clone(), span, ramp);
        let (true_end, _) = end(rounded_otherwise(&scene), span, ramp);
        let law = &scene.cam;
        let w = w + ramp.unwrap_or(0.0) * span;
        let sizes = [law.bound(0), law.bound(0), law.bound(1) * w, law.bound(1) * w];
        let error = (0..4).map(|i| (found[i] - true_end[i] / 3.0).abs() / sizes[i]).fold(0.0, f64::max);
        ratios.push(estimate / error.max(f64::MIN_POSITIVE));
    }
    ratios.sort_by(f64::total_cmp);
    let too_small = ratios.iter().filter(|r| **r < 1.0).count();
    let median = ratios[ratios.len() / 2];
    assert!(too_small * 100 <= ratios.len() && median <= 100.0, "{too_small} of {}, median {median}", ratios.len());
}

#[test]
fn the_tolerance_trades_terms_for_accuracy() {
    let scene = |tolerance| random(&mut Dice(1), tolerance).0;
    let (truth, _) = end(scene(0.0), 0.2, Some(0.0));
    let mut coarser = f64::INFINITY;
    for tolerance in [1e-3, 1e-6, 1e-9, 1e-12] {
        let (found, _) = end(scene(tolerance), 0.2, Some(0.0));
        let error = (found[1] - truth[1]).abs() / scene(tolerance).cam.bound(0);
        assert!(error < tolerance && error < 0.1 * coarser, "{tolerance}: {error:e}");
        // The inputs themselves are rounded.
        coarser = error.max(5e-12);
    }
}
