//! What the drive can be spared.

use super::{CamDriveParts, RigidFollower, Simplification, of_cam_drive};
use camdrive::drives::elastic_shaft::Scene;

pub fn of(scene: &Scene) -> Vec<Simplification<Scene>> {
    let (m, inertia, law) = (scene.parameters.m, scene.parameters.inertia, scene.cam.clone());
    // q → 0 while tau = −(c q + b q̇) = (J + m U′²) α + m U′U″ ω² stays, as for c → ∞ in the equation of motion; the
    // mass takes U′ times its force m ÿ of it.
    let mut list = vec![Simplification::formula(
        "the elasticity of the shaft",
        "rigid: ψ = φ, y = U(φ), tau = J φ̈ + U′ m ÿ",
        &["phi", "w", "psi", "der(psi)", "der(psi,2)", "q", "der(q)", "y", "der(y)", "tau"],
        move |shaft, out| {
            let RigidFollower { y, y_dot, y_dot_dot, slope } = RigidFollower::of(&law, shaft);
            let tau = inertia * shaft.a + slope * m * y_dot_dot;
            out.copy_from_slice(&[shaft.phi, shaft.w, shaft.phi, shaft.w, shaft.a, 0.0, 0.0, y, y_dot, tau]);
        },
    )];
    if !scene.linear {
        let linear = Scene { linear: true, ..scene.clone() };
        list.push(Simplification::scene("the nonlinearity of the shaft", "linear in the twist", linear));
    }
    list.extend(of_cam_drive(scene, |s| CamDriveParts {
        damping: &mut s.parameters.b,
        drive: &s.drive,
        start: &mut s.start.mode,
        law: &mut s.cam,
    }));
    list
}
