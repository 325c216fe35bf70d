//! The cams of a scene with what they move, at the speed of the scene.

use super::{Compliance, Drive, Loads, Machine};
use crate::resource::{Resource, Scene};
use camdrive::drives::backlash::BacklashDrive;
use camdrive::drives::drive_train::{self, Shaft};
use camdrive::drives::rigid_machine::{self, Follower};
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::shaft::motor::{Reference, Source};
use camdrive::drives::{Drive as _, Fault};
use camdrive::motion::MotionLaw;

/// A value with the sign of the speed to which a motor drives its rotor; 0 if an input decides it.
fn sense(motor: &Source) -> f64 {
    match motor {
        Source::None | Source::Input => 0.0,
        Source::Constant(torque) => *torque,
        Source::Table(table) => table.torque(table.piece(0.0), 0.0),
        Source::Kloss(kloss) => kloss.synchronous_speed,
        Source::Servo(servo) => match servo.reference {
            Reference::Constant(speed) | Reference::Ramp(speed) => speed,
            Reference::Series(..) | Reference::Input => 0.0,
        },
    }
}

impl Machine {
    /// The cams of a scene with what they move, and a speed in the sense in which it turns.
    ///
    /// # Errors
    /// A model without cam.
    pub fn of(resource: &Resource) -> Result<Machine, Fault> {
        let (name, scene) = (&resource.name, &resource.scene);
        let motor_or = |w_start: f64, motor: f64| if w_start == 0.0 { motor } else { w_start };
        let prescribed = |drive: &DriveMode| if let DriveMode::Constant { w, .. } = *drive { w } else { 0.0 };
        // With the mass on the cam's side, what gives, and whether the follower may leave its cam.
        let beside_cam = |cam: &MotionLaw, [m, roller]: [f64; 2], (compliance, leaves), drive| {
            (vec![(Follower::new(m + roller, cam.clone()), roller, compliance, leaves)], None, prescribed(drive))
        };
        let sprung = |c: f64, b: f64| Compliance::Output([c, b]);
        let (followers, inertia, speed) = match scene {
            Scene::RigidMachine(machine) => {
                let motor =
                    if let rigid_machine::Motor::Kloss(kloss) = machine.motor { kloss.synchronous_speed } else { 0.0 };
                let rigid = |follower: &Follower| (follower.clone(), 0.0, Compliance::Rigid, false);
                let followers = machine.followers.iter().map(rigid).collect();
                (followers, machine.inertia.varying.clone(), motor_or(machine.w_start, motor))
            }
            Scene::DriveTrain(drive_train::Scene { followers, shaft, .. }) => {
                let follower = |train: &drive_train::Follower| {
                    let [m, roller] = train.masses();
                    let compliance = match (train.joint.sprung(), train.joint.shaft()) {
                        (Some((_, [_, c, b])), _) => sprung(c, b),
                        (None, Some(shaft)) => Compliance::Shaft(shaft, false),
                        (None, None) => Compliance::Rigid,
                    };
                    let leaves = train.joint.clearance().is_some();
                    (Follower { m: m + roller, ..train.rigid.clone() }, roller, compliance, leaves)
                };
                let (inertia, speed) = match shaft {
                    Shaft::Free(machine) => {
                        let motor = sense(&machine.motor.source) * machine.motor.transmission.ratio;
                        (machine.inertia.varying.clone(), motor_or(machine.w_start, motor))
                    }
                    Shaft::Driven(drive) => (None, prescribed(drive)),
                };
                (followers.iter().map(follower).collect(), inertia, speed)
            }
            Scene::ElasticOutput(own) => {
                let spring = sprung(own.parameters.c, own.parameters.b);
                beside_cam(&own.cam, [own.parameters.m, own.roller.0], (spring, false), &own.drive)
            }
            Scene::ElasticShaft(own) => {
                let shaft = Compliance::Shaft(own.parameters, own.linear);
                beside_cam(&own.cam, [own.parameters.m, 0.0], (shaft, false), &own.drive)
            }
            Scene::BacklashDrive(own) => {
                let spring = sprung(own.parameters.c, own.parameters.b);
                beside_cam(&own.cam, [own.parameters.m2, own.parameters.m1], (spring, true), &own.drive)
            }
            Scene::ParametricDrive(_) => {
                return Err(
                    Fault::new(format!("a {} has no cam", scene.model())).hint("`camdrive steady` shows its loads")
                );
            }
        };
        let numbered = scene.followers() > 0 && scene.model_name() != BacklashDrive::MODEL;
        let mut drives = Vec::new();
        for (j, (follower, roller, compliance, may_leave)) in Vec::into_iter(followers).enumerate() {
            let name = if numbered { format!("{name}.follower{}", j + 1) } else { name.clone() };
            let (plan, own) = resource.contacts.get(j).cloned().unwrap_or_default();
            let [load, on_roller] = scene.loads(j);
            let loads = Loads { load, roller: (roller, on_roller), may_leave, compliance, ..own };
            drives.push(Drive::new(name, follower, plan, loads)?);
        }
        Ok(Machine { name: name.clone(), speed, inertia, drives })
    }
}
