//! Data of the analysis of forces besides masses and loads: `[forces]` beside `[cam]`, `[follower.forces]`. The motion of the FMU
//! is without it.

use super::Resolved;
use super::geometry::{self, CamPlan};
use crate::document::Section;
use camdrive::drives::backlash::BacklashDrive;
use camdrive::drives::drive_train::{self, Shaft};
use camdrive::drives::rigid_machine::{self, Follower};
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::shaft::motor::{Reference, Source};
use camdrive::drives::{Drive as _, Fault};
use camdrive::motion::MotionLaw;
use camdrive_design::cam_geometry::Carrier;
use camdrive_design::forces::{Drive, Loads, Machine, Material, Teeth};
use camdrive_design::resource::Scene;

/// The key of the table.
pub const KEY: &str = "forces";

/// The keys that [`load`] has instead.
const MOVED: [&str; 4] = ["gravity", "gravity_angle", "spring", "process"];

/// Properties of a follower that its loads depend on.
struct FollowerTraits {
    mechanisms: usize,
    geometry: bool,
    lever: bool,
}

/// The loads of all cams of a scene, in its order, with its drive where that is right already.
pub fn all(root: &Section<'_>, drive: Option<&Scene>, cams: &[CamPlan]) -> Option<Vec<Loads>> {
    let known = |section: &Section<'_>, follower: Option<usize>, mechanisms: usize| {
        let geometry = section.has(geometry::KEY);
        // A geometry with faults is taken for one that fits.
        let plan = cams.iter().find(|cam| cam.follower == follower).map(|cam| cam.plan);
        let lever = plan.map_or(geometry || mechanisms > 0, |plan| matches!(plan.carrier, Carrier::Lever { .. }));
        FollowerTraits { mechanisms, geometry, lever }
    };
    let loads = |j: usize| {
        let [load, roller] = drive.map_or_else(Default::default, |drive| drive.loads(j));
        Loads { load, roller: (0.0, roller), ..Loads::default() }
    };
    let mut list = Vec::new();
    if root.has("cam") {
        list.push(of(root, &known(root, None, 0), loads(0)));
    }
    for (j, section) in root.sections("follower")?.iter().enumerate() {
        let mechanisms = section.sections("linkage")?.len();
        list.push(of(section, &known(section, Some(j + 1), mechanisms), loads(j)));
    }
    list.into_iter().collect()
}

/// Something with the sign of the speed to which a motor drives its rotor; 0 where an input decides it.
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

/// The cams of a scene with what they move, and a speed in the sense in which it turns.
///
/// # Errors
/// Where the model has no cam.
pub fn machine(scene: &Resolved) -> Result<Machine, Fault> {
    let motor_or = |w_start: f64, motor: f64| if w_start == 0.0 { motor } else { w_start };
    let prescribed = |drive: &DriveMode| if let DriveMode::Constant { w, .. } = *drive { w } else { 0.0 };
    // With the mass on the cam's side, and whether the follower may leave its cam.
    let beside_cam = |cam: &MotionLaw, [m, roller]: [f64; 2], leaves, drive| {
        (vec![(Follower::new(m + roller, cam.clone()), roller, leaves)], None, prescribed(drive))
    };
    let (followers, inertia, speed) = match &scene.scene {
        Scene::RigidMachine(machine) => {
            let motor =
                if let rigid_machine::Motor::Kloss(kloss) = machine.motor { kloss.synchronous_speed } else { 0.0 };
            let followers = machine.followers.iter().map(|follower| (follower.clone(), 0.0, false)).collect();
            (followers, machine.inertia.varying.clone(), motor_or(machine.w_start, motor))
        }
        Scene::DriveTrain(drive_train::Scene { followers, shaft, .. }) => {
            let follower = |train: &drive_train::Follower| {
                let [m, roller] = train.masses();
                (Follower { m: m + roller, ..train.rigid.clone() }, roller, train.joint.clearance().is_some())
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
        Scene::ElasticOutput(own) => beside_cam(&own.cam, [own.parameters.m, own.roller.0], false, &own.drive),
        Scene::ElasticShaft(own) => beside_cam(&own.cam, [own.parameters.m, 0.0], false, &own.drive),
        Scene::BacklashDrive(own) => beside_cam(&own.cam, [own.parameters.m2, own.parameters.m1], true, &own.drive),
        Scene::ParametricDrive(_) => return Err(Fault::new(format!("a {} has no cam", scene.scene.model()))),
    };
    let numbered = scene.scene.followers() > 0 && scene.scene.said() != BacklashDrive::MODEL;
    let mut drives = Vec::new();
    for (j, ((follower, roller, may_leave), loads)) in Vec::into_iter(followers).zip(&scene.loads).enumerate() {
        let number = numbered.then_some(j + 1);
        let name = number.map_or(scene.name.clone(), |j| format!("{}.follower{j}", scene.name));
        let plan = scene.cams.iter().find(|cam| cam.follower == number).map(|cam| cam.plan);
        let loads = Loads { roller: (roller, loads.roller.1.clone()), may_leave, ..loads.clone() };
        drives.push(Drive::new(name, follower, plan, loads)?);
    }
    Ok(Machine { name: scene.name.clone(), speed, inertia, drives })
}

fn of(parent: &Section<'_>, known: &FollowerTraits, loads: Loads) -> Option<Loads> {
    let Some(section) = parent.section(KEY)? else { return Some(loads) };
    for key in MOVED {
        if let Some(node) = section.node(key) {
            let place = if parent.path.is_empty() { "load" } else { "follower.load" };
            let text = section.faults.document.text[node.span].split_whitespace().collect::<Vec<_>>().join(" ");
            let fault = section.fault_of(key, format!(" is a load, which belongs to [{place}]"));
            section.faults.report(fault.hint(format!("write it in a section [{place}]: {key} = {text}")));
        }
    }
    if !known.lever {
        section.forbid(&["lever_J"], "no lever is known", "geometry with follower = \"lever\"");
    }
    let lever_inertia = section.real("lever_J");
    if known.mechanisms == 0 {
        section.forbid(&["tooth_radius", "tooth_angle"], "there is no gear", "[[follower.linkage]] with a gear");
    }
    let radius = section.optional("tooth_radius");
    let angle = section.real("tooth_angle");
    let material = material(&section, known);
    section.finish();
    Some(Loads {
        lever_inertia: lever_inertia?,
        teeth: Teeth { radius: radius?, angle: angle? },
        material: material?,
        ..loads
    })
}

fn material(section: &Section<'_>, known: &FollowerTraits) -> Option<Option<Material>> {
    if !known.geometry {
        section.forbid(&["roller_width"], "no roller is known", "a geometry of the cam");
    }
    if !section.has("roller_width") {
        let keys = ["E_cam", "E_roller", "nu_cam", "nu_roller"];
        section.forbid(&keys, "without its width the contact has no pressure", "roller_width");
        return Some(None);
    }
    let width = section.real("roller_width");
    let elasticity = ["E_cam", "E_roller"].map(|key| section.real(key));
    let poisson = ["nu_cam", "nu_roller"].map(|key| section.real(key));
    let ([e1, e2], [nu1, nu2]) = (elasticity, poisson);
    Some(Some(Material { width: width?, elasticity: [e1?, e2?], poisson: [nu1?, nu2?] }))
}
