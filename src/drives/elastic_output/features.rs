//! What the drive can be spared.

use super::Scene;
use crate::drives::cam_drive::{DriveMode, StartMode};
use crate::drives::simplification::{RigidFollower, Simplification, fewer_harmonics};

pub(super) fn of(scene: &Scene) -> Vec<Simplification<Scene>> {
    let (m, law) = (scene.m, scene.cam.clone());
    // q → 0 while force = −(c q + b q̇) = m ÿ stays, as for c → ∞ in the equation of motion.
    let mut list = vec![Simplification::formula(
        "the elasticity of the output member",
        "rigid: y = U(φ), force = m ÿ",
        &["phi", "w", "x", "y", "der(y)", "der(y,2)", "q", "der(q)", "der(q,2)", "force", "tau"],
        move |shaft, out| {
            let RigidFollower { y, y_dot, y_dot_dot, slope } = RigidFollower::of(&law, shaft);
            let force = m * y_dot_dot;
            let values = [shaft.phi, shaft.w, y, y, y_dot, y_dot_dot, 0.0, 0.0, 0.0, force, slope * force];
            out.copy_from_slice(&values);
        },
    )];
    if scene.b > 0.0 {
        list.push(Simplification::scene("damping", "b = 0", Scene { b: 0.0, ..scene.clone() }));
    }
    if matches!(scene.drive, DriveMode::Constant { w, .. } if w != 0.0) && scene.start.mode != StartMode::SteadyState {
        let mut steady = scene.clone();
        steady.start.mode = StartMode::SteadyState;
        list.push(Simplification::scene("the transient", "start on the periodic motion", steady));
    }
    for fewer in fewer_harmonics(&scene.cam) {
        let rest = Scene { cam: fewer.law, ..scene.clone() };
        list.push(Simplification::scene(&fewer.feature, &fewer.instead, rest));
    }
    list
}
