//! What the formulas of the source tell of a passage, to be seen beside the model.

use super::borders;
use super::formulas::Passage;
use super::law::Crossing;
use super::passage::{Figures, POINTS, Point};
use crate::search::greatest;
use camdrive::drives::backlash::Scene;
use std::f64::consts::TAU;

/// By (10)–(26), of the passage at `crossing`.
pub fn figures(passage: &Passage, crossing: &Crossing, scene: &Scene, w: f64) -> Figures {
    let omega = (scene.parameters.c / scene.parameters.m2).sqrt();
    let eta = w.abs() / omega;
    // Ω²η|U‴| Z ω⁻¹: (18).
    let jump = crossing.jerk.abs() * eta * eta * w.abs() * passage.jump();
    let sequel = borders::sequel(passage);
    let release_after = borders::release(passage);
    let until = release_after.unwrap_or(TAU);
    let largest =
        |value: &dyn Fn(f64) -> f64| (until > 0.0).then(|| greatest(&[[0.0, until]], |_, tau| value(tau).abs()).value);
    Figures {
        release: crossing.phi,
        time: passage.tau / omega,
        tau: passage.tau,
        angle: eta * passage.tau,
        impulse: scene.parameters.m1 * jump,
        loss: 0.5 * scene.parameters.m1 * jump * jump,
        vibration: scene.parameters.s * passage.vibration(),
        elongation: largest(&|tau| scene.parameters.s * passage.elongation(tau)),
        force: largest(&|tau| scene.parameters.c * scene.parameters.s / passage.k * passage.pressing(tau)),
        sequel,
        release_after,
    }
}

/// The period after the impact by (21) and (25).
pub fn course(passage: &Passage) -> Vec<Point> {
    let point = |tau: f64| Point {
        tau,
        q: [Some(passage.elongation(tau)), None],
        force: [Some(passage.pressing(tau) / passage.k), None],
    };
    (0..=POINTS).map(|i| point(TAU * i as f64 / POINTS as f64)).collect()
}
