//! A train: its motor and shaft, and each of its followers.

use super::{Overview, vibration};
use crate::oscillator::of_shaft;
use camdrive::drives::drive_train::{Scene, Shaft, Stand};
use camdrive::drives::elastic_output::Parameters;
use camdrive::drives::elastic_shaft;
use camdrive::drives::rigid_machine::{Follower, Inertia, InertiaFunction};
use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use camdrive::drives::shaft::motor::{Servo, Source};

/// The start of an elastic shaft alone.
const REST: Start = Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 };

pub fn tell(overview: &mut Overview, scene: &Scene) {
    let speed = match &scene.shaft {
        Shaft::Driven(mode) => overview.driven(mode),
        Shaft::Free(_) => free(overview, scene),
    };
    for (j, follower) in scene.followers.iter().enumerate() {
        let (prefix, cam, load) = (format!("follower[{}].", j + 1), &follower.rigid.cam, &follower.load);
        let mut own = Overview::default();
        if let Some((_, [m, c, b])) = follower.joint.sprung() {
            own.elastic(&vibration::behind_cam(cam, Parameters { m, c, b }, load, speed), Some((cam, false)));
        }
        if let Some(parameters) = follower.joint.shaft() {
            let drive = speed.map_or(DriveMode::Input, |w| DriveMode::Constant { w, phi_start: 0.0 });
            let (cam, load, start, solver) = (cam.clone(), load.clone(), REST, scene.solver);
            let alone = elastic_shaft::Scene { parameters, linear: false, load, cam, drive, start, solver };
            own.elastic(&of_shaft(&alone), Some((&follower.rigid.cam, true)));
        }
        if let Some(p) = follower.joint.clearance() {
            if p.m2 > 0.0 {
                own.speed("natural_frequency_in_flight", (p.c * (p.m1 + p.m2) / (p.m1 * p.m2)).sqrt());
            }
            own.clearance(cam, p.s);
        }
        overview.swings.push(own.swings.first().copied().unwrap_or(f64::NAN));
        for mut figure in own.figures {
            figure.name = prefix.clone() + &figure.name;
            overview.figures.push(figure);
        }
        // The figures of several followers would not name their follower.
        if scene.followers.len() == 1 {
            (overview.resonances, overview.every) = (own.resonances, own.every);
        }
        overview.follower(j, &follower.rigid, speed);
    }
}

/// The inertia of all parts that follow the shaft without slip, including m1 of a clearance, which does so in contact.
pub fn without_slip(scene: &Scene) -> Inertia {
    let followers = scene.followers.iter().filter_map(|follower| {
        let m = follower.carried(&Stand::held()).next()?.m;
        Some(Follower { m, ..follower.rigid.clone() })
    });
    let function = match &scene.shaft {
        Shaft::Driven(_) => InertiaFunction::default(),
        Shaft::Free(machine) => InertiaFunction {
            constant: machine.inertia.constant + machine.motor.stiff_rotor(),
            ..machine.inertia.clone()
        },
    };
    Inertia::new(function, followers.collect())
}

/// Motor, speed and inertia of a free shaft; returns its mean speed if it has a periodic motion.
fn free(overview: &mut Overview, scene: &Scene) -> Option<f64> {
    let Shaft::Free(machine) = &scene.shaft else { return None };
    let transmission = machine.motor.transmission;
    let inertia = without_slip(scene);
    let mean = 0.5 * (inertia.range().0 + inertia.range().1);
    let square = transmission.ratio * transmission.ratio;
    match &machine.motor.source {
        Source::Kloss(kloss) => overview.kloss(kloss),
        Source::Servo(Servo { proportional, integral, limit, .. }) => {
            overview.figure("torque_limit", *limit, "N.m");
            if transmission.ratio.abs() != 1.0 {
                overview.figure("torque_limit_on_the_shaft", limit * transmission.ratio.abs(), "N.m");
            }
            if *integral > 0.0 {
                let all = if transmission.coupling.is_some() { mean + square * transmission.rotor } else { mean };
                overview.speed("control_frequency", (integral * square / all).sqrt());
                overview.figure("control_damping_ratio", proportional * (square / (4.0 * integral * all)).sqrt(), "1");
            }
        }
        Source::Constant(torque) => overview.figure("motor_torque", *torque, "N.m"),
        _ => {}
    }
    if let Some([c, _]) = transmission.coupling {
        overview.speed("coupling_frequency", (c * (1.0 / mean + 1.0 / (square * transmission.rotor))).sqrt());
    }
    let turn = overview.turn.clone().filter(|turn| turn.growth.is_some_and(|growth| growth < 0.0));
    if let Some(turn) = &turn {
        overview.speed("mean_speed", turn.mean_speed);
        overview.share("speed_fluctuation", turn.fluctuation());
        overview.figure("mean_torque", turn.mean_torque, "N.m");
        overview.figure("mean_power", turn.mean_power, "W");
    }
    overview.inertia(&inertia);
    turn.map(|turn| turn.mean_speed)
}
