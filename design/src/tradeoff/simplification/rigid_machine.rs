//! What the machine can be spared.

use super::{Simplification, fewer_harmonics};
use camdrive::drives::rigid_machine::{Follower, Inertia, InertiaFunction, Kloss, Motor, Place, Scene};
use camdrive::numerics::angle;
use camdrive::numerics::double_double::Double;
use std::f64::consts::TAU;

pub fn of(scene: &Scene) -> Vec<Simplification<Scene>> {
    let mut list = Vec::new();
    if let Motor::Kloss(Kloss { dynamics: Some(_), .. }) = scene.motor {
        let mut motor = scene.motor;
        if let Motor::Kloss(Kloss { dynamics, .. }) = &mut motor {
            *dynamics = None;
        }
        let quasi_static = Scene { motor, ..scene.clone() };
        list.push(Simplification::scene("the lag of the motor", "quasi-static torque", quasi_static));
    }
    let inertia = Inertia::new(scene.inertia.clone(), scene.followers.clone());
    if inertia.varies() {
        let function = InertiaFunction { constant: mean(&inertia), varying: None };
        let constant = Scene { inertia: function, followers: Vec::new(), ..scene.clone() };
        list.push(Simplification::scene("the variation of the inertia", "constant mean J, no followers", constant));
    }
    if scene.motor != Motor::Input {
        list.push(constant_speed(scene, inertia));
    }
    if scene.followers.iter().any(|follower| follower.linkage.has_mass()) {
        let mut massless = scene.clone();
        for follower in &mut massless.followers {
            follower.linkage = follower.linkage.without_masses();
        }
        list.push(Simplification::scene("the inertia of the links", "massless links", massless));
    }
    for (j, follower) in scene.followers.iter().enumerate() {
        for fewer in fewer_harmonics(&follower.cam) {
            let mut rest = scene.clone();
            rest.followers[j] = Follower { cam: fewer.law, ..follower.clone() };
            let feature = format!("{} of follower {}", fewer.feature, j + 1);
            list.push(Simplification::scene(&feature, &fewer.instead, rest));
        }
    }
    list
}

/// The mean of J over a turn.
fn mean(inertia: &Inertia) -> f64 {
    // The trapezoidal rule is exact for the harmonics below the number of points.
    let points = (8.0 * inertia.resolution()).clamp(256.0, 65536.0) as usize;
    let at = |i: usize| {
        let phi = (i as f64 + 0.5) * TAU / points as f64;
        inertia.at(Place::at(phi), phi)[0]
    };
    (0..points).map(at).sum::<f64>() / points as f64
}

/// The machine at its mean speed: φ̈ = 0, and the torque that this takes, M_an = ½ J′ω².
fn constant_speed(scene: &Scene, inertia: Inertia) -> Simplification<Scene> {
    let followers = scene.followers.clone();
    let motor = matches!(scene.motor, Motor::Kloss(_));
    let mut outputs: Vec<String> = ["phi", "w", "a", "J", "E"].map(str::to_owned).into();
    if motor {
        outputs.push("M_an".to_owned());
    }
    for j in 1..=followers.len() {
        outputs.extend([format!("U[{j}]"), format!("der(U[{j}])"), format!("der(U[{j}],2)")]);
    }
    let names: Vec<&str> = outputs.iter().map(String::as_str).collect();
    let evaluate = move |shaft: &super::Shaft, out: &mut [f64]| {
        let phi = shaft.phi.rem_euclid(TAU);
        let [j, slope, ..] = inertia.at(Place::at(phi), phi);
        let torque = 0.5 * slope * shaft.w * shaft.w + j * shaft.a;
        let own = [shaft.phi, shaft.w, shaft.a, j, 0.5 * j * shaft.w * shaft.w];
        let tools = followers.iter().flat_map(|follower| {
            let [y, y1, y2, ..] = follower.tool(follower.cam.at(angle::reduce(Double::from(shaft.phi))).0);
            [y, y1 * shaft.w, y2 * shaft.w * shaft.w + y1 * shaft.a]
        });
        let values = own.into_iter().chain(motor.then_some(torque)).chain(tools);
        out.iter_mut().zip(values).for_each(|(place, value)| *place = value);
    };
    Simplification::formula("the speed fluctuation", "constant mean speed", &names, evaluate)
}
