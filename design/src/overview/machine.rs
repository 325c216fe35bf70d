//! A rigid machine: its speeds, its inertia, its tools.

use super::Overview;
use crate::periodic_motions::{free_motion, periodic_motions, range};
use crate::search::{greatest, segments};
use camdrive::drives::rigid_machine::{Inertia, Kloss, Motor, Place, Scene};
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
    let value = |i: usize, phi: f64| inertia.value(inertia.place(i), phi);
    let segments = segments(inertia.borders());
    overview.figure("least_inertia", -greatest(&segments, |i, phi| -value(i, phi)).value, "kg.m2");
    overview.figure("largest_inertia", greatest(&segments, value).value, "kg.m2");
    if let Some(law) = &scene.inertia.varying {
        overview.roughness("machine.J", law, "kg.m2");
    }
    for (j, follower) in scene.followers.iter().enumerate() {
        let prefix = format!("follower[{}].", j + 1);
        let lever = follower.turns || !follower.linkage.0.is_empty();
        overview.law(&format!("{prefix}cam"), &follower.cam, if lever { "rad" } else { "m" });
        let tool = |u| follower.tool(u);
        overview.motion(&prefix, (&follower.cam, &tool), follower.m, running.map(|(mean, _)| mean), follower.turns);
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
            // A machine without torques keeps the shape of its motion at any speed: ω √J is constant.
            let root = |phi: f64| inertia.value(Place::at(phi), phi).sqrt();
            let factor = scene.w_start * root(scene.phi_start) / (unit[0][1] * root(unit[0][0]));
            Some((scene.w_start.signum() * TAU * factor, range(&unit).map(|w| factor * w)))
        }
        _ => None,
    }
}
