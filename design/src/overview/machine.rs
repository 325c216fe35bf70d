//! A rigid machine: its speeds, its inertia, its tools.

use super::Overview;
use crate::periodic_motions::{free_motion, periodic_motions, range};
use crate::search::{greatest, segments};
use camdrive::drives::rigid_machine::{Follower, Inertia, Kloss, Motor, Place, Scene};
use camdrive::numerics::angle;
use camdrive::numerics::double_double::Double;
use std::f64::consts::TAU;

pub fn tell(overview: &mut Overview, scene: &Scene) {
    let inertia = Inertia::new(scene.inertia.clone(), scene.followers.clone());
    if let Motor::Kloss(kloss) = &scene.motor {
        overview.kloss(kloss);
    }
    let running = running(scene, &inertia);
    if let Some((mean, [low, high])) = running {
        overview.speed("mean_speed", mean);
        overview.share("speed_fluctuation", (high - low) / mean.abs());
    }
    overview.inertia(&inertia);
    if let Some(law) = &scene.inertia.varying {
        overview.roughness("machine.J", law, "kg.m2");
    }
    for (j, follower) in scene.followers.iter().enumerate() {
        overview.follower(j, follower, running.map(|(mean, _)| mean));
    }
}

impl Overview {
    /// An asynchronous motor.
    pub(super) fn kloss(&mut self, kloss: &Kloss) {
        self.speed("synchronous_speed", kloss.synchronous_speed);
        self.figure("breakdown_torque", kloss.breakdown_torque, "N.m");
        self.figure("breakdown_slip", kloss.breakdown_slip, "1");
    }

    /// The range of the inertia.
    pub(super) fn inertia(&mut self, inertia: &Inertia) {
        let value = |i: usize, phi: f64| inertia.value(inertia.place(i), phi);
        let segments = segments(inertia.borders());
        self.figure("least_inertia", -greatest(&segments, |i, phi| -value(i, phi)).value, "kg.m2");
        self.figure("largest_inertia", greatest(&segments, value).value, "kg.m2");
    }

    /// Law and tool of follower j, counted from 0, at this speed of the shaft.
    pub(super) fn follower(&mut self, j: usize, follower: &Follower, speed: Option<f64>) {
        let prefix = format!("follower[{}].", j + 1);
        let lever = follower.turns || !follower.linkage.0.is_empty();
        self.law(&format!("{prefix}cam"), &follower.cam, if lever { "rad" } else { "m" });
        self.motion(j, &prefix, (&follower.cam, &|u| follower.tool(u)), speed, follower.turns);
    }
}

/// The speed about which the machine fluctuates (rad/s), if one follows from the scene, and its least and largest one.
pub fn running(scene: &Scene, inertia: &Inertia) -> Option<(f64, [f64; 2])> {
    match scene.motor {
        Motor::Kloss(Kloss { synchronous_speed, .. }) => {
            // Without load; None without a periodic motion.
            let motions = periodic_motions(scene, 0.0).unwrap_or_default();
            let stable = motions.iter().find(|motion| motion.is_stable());
            stable.map(|motion| (synchronous_speed.signum() * TAU / motion.period, range(&motion.course)))
        }
        Motor::None if scene.w_start != 0.0 => {
            let unit = free_motion(inertia, 1.0, scene.w_start.signum());
            // A machine without torques keeps the shape of its motion at any speed: ω √J is constant.
            let root = |phi: f64| inertia.value(Place::at(phi), phi).sqrt();
            let from = angle::reduce(Double::from(scene.phi_start));
            let factor = scene.w_start * root(from) / (unit[0][1] * root(unit[0][0]));
            Some((scene.w_start.signum() * TAU * factor, range(&unit).map(|w| factor * w)))
        }
        _ => None,
    }
}
