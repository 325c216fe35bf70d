//! What the drive can be spared.

use super::{CamDriveParts, RigidFollower, Simplification, of_cam_drive};
use camdrive::drives::elastic_output::Scene;

pub fn of(scene: &Scene) -> Vec<Simplification<Scene>> {
    let (m, law) = (scene.parameters.m, scene.cam.clone());
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
    list.extend(of_cam_drive(scene, |s| CamDriveParts {
        damping: &mut s.parameters.b,
        drive: &s.drive,
        start: &mut s.start.mode,
        law: &mut s.cam,
    }));
    list
}
