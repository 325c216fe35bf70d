//! What the drive can be spared.

use super::{RigidFollower, Simplification, fewer_harmonics};
use camdrive::drives::backlash::{Parameters, Scene};

pub fn of(scene: &Scene) -> Vec<Simplification<Scene>> {
    let (m, law) = (scene.parameters.m1 + scene.parameters.m2, scene.cam.clone());
    let mut list = Vec::new();
    let without = |parameter: fn(&mut Parameters) -> &mut f64| {
        let mut scene = scene.clone();
        *parameter(&mut scene.parameters) = 0.0;
        scene
    };
    if scene.parameters.s > 0.0 {
        list.push(Simplification::scene("the clearance", "s = 0", without(|p| &mut p.s)));
    }
    // Both masses ride on flank A as one: F_K = (m1 + m2) Ü.
    list.push(Simplification::formula(
        "clearance and elasticity",
        "rigid: x1 = y = U(φ), force = (m1 + m2) ÿ",
        &["phi", "w", "x1", "der(x1)", "der(x1,2)", "y", "der(y)", "der(y,2)", "q", "der(q)", "gap", "force", "tau"],
        move |shaft, out| {
            let RigidFollower { y, y_dot, y_dot_dot, slope } = RigidFollower::of(&law, shaft);
            let (place, rest, force) = ([y, y_dot, y_dot_dot], [0.0; 3], m * y_dot_dot);
            out[..2].copy_from_slice(&[shaft.phi, shaft.w]);
            out[2..5].copy_from_slice(&place);
            out[5..8].copy_from_slice(&place);
            out[8..11].copy_from_slice(&rest);
            out[11..].copy_from_slice(&[force, slope * force]);
        },
    ));
    if scene.parameters.e > 0.0 {
        list.push(Simplification::scene("restitution", "e = 0", without(|p| &mut p.e)));
    }
    if scene.parameters.b > 0.0 {
        list.push(Simplification::scene("damping", "b = 0", without(|p| &mut p.b)));
    }
    for fewer in fewer_harmonics(&scene.cam) {
        let rest = Scene { cam: fewer.law, ..scene.clone() };
        list.push(Simplification::scene(&fewer.feature, &fewer.instead, rest));
    }
    list
}
