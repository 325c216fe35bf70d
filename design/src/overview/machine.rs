//! A rigid machine: its speeds, its inertia, its tools.

use super::{Overview, angles};
use crate::periodic_motions::{free_motion, periodic_motions, range};
use camdrive::drives::rigid_machine::{Inertia, Kloss, Motor, Place, Scene};
use camdrive::numerics::angle;
use camdrive::numerics::double_double::Double;
use std::f64::consts::TAU;

pub fn tell(overview: &mut Overview, scene: &Scene) {
    let inertia = Inertia::new(scene.inertia.clone(), scene.followers.clone());
    if let Motor::Kloss(Kloss { breakdown_torque, breakdown_slip, synchronous_speed, .. }) = scene.motor {
        overview.speed("synchronous_speed", synchronous_speed);
        overview.figure("breakdown_torque", breakdown_torque, "N.m");
        overview.figure("breakdown_slip", breakdown_slip, "1");
    }
    let running = running(scene, &inertia);
    if let Some((mean, [low, high])) = running {
        overview.speed("mean_speed", mean);
        overview.share("speed_fluctuation", (high - low) / mean.abs());
    }
    let values = || angles().map(|phi| inertia.at(Place::at(phi), phi)[0]);
    overview.figure("least_inertia", values().fold(f64::INFINITY, f64::min), "kg.m2");
    overview.figure("largest_inertia", values().fold(0.0, f64::max), "kg.m2");
    if let Some(law) = &scene.inertia.varying {
        overview.roughness("machine.J", law, "kg.m2");
    }
    for (j, follower) in scene.followers.iter().enumerate() {
        let prefix = format!("follower[{}].", j + 1);
        let lever = follower.turns || !follower.linkage.0.is_empty();
        overview.law(&format!("{prefix}cam"), &follower.cam, if lever { "rad" } else { "m" });
        let tools: Vec<[f64; 5]> = angles().map(|phi| follower.tool(follower.cam.at(phi).0)).collect();
        let motion = [0, 1, 2].map(|n| tools.iter().map(|tool| tool[n]).collect());
        overview.motion(&prefix, motion, follower.m, running.map(|(mean, _)| mean), follower.turns);
    }
}

/// The speed about which the machine fluctuates (rad/s), if one follows from the scene, and its least and largest one.
pub fn running(scene: &Scene, inertia: &Inertia) -> Option<(f64, [f64; 2])> {
    match scene.motor {
        Motor::Kloss(Kloss { synchronous_speed, .. }) => {
            // Without load; where none is found, there is no mean speed.
            let motions = periodic_motions(scene, 0.0).unwrap_or_default();
            let stable = motions.iter().find(|motion| motion.is_stable());
            stable.map(|motion| (synchronous_speed.signum() * TAU / motion.period, range(&motion.course)))
        }
        Motor::None if scene.w_start != 0.0 => {
            let unit = free_motion(inertia, 1.0, scene.w_start.signum());
            // A machine without torques keeps the shape of its motion at any speed, and √J ω.
            let momentum = |phi: f64, w: f64| inertia.value(Place::at(phi), phi).sqrt() * w;
            let from = angle::reduce(Double::from(scene.phi_start));
            let factor = momentum(from, scene.w_start) / unit.first().map(|[phi, w]| momentum(*phi, *w))?;
            let [low, high] = range(&unit);
            Some((scene.w_start.signum() * TAU * factor, [factor * low, factor * high]))
        }
        _ => None,
    }
}
