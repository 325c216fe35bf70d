//! Loads on the follower of a cam beside its masses: `[forces]` beside `[cam]`, `[follower.forces]`. The motion of
//! the FMU is without them.

use super::geometry::{self, CamPlan};
use super::section::{ANY, NOT_NEGATIVE, Node, POSITIVE, Section, within};
use super::{Resolved, motion_law, units};
use camdrive::drives::Fault;
use camdrive::drives::rigid_machine::{self, Follower};
use camdrive::drives::unit::{self, Quantity};
use camdrive::motion::{Fourier, MotionLaw};
use camdrive_design::cam_geometry::{Carrier, Point};
use camdrive_design::forces::{Drive, Loads, Machine, Material, Spring, Teeth};
use serde_json::Value;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;
use toml::de::DeValue;

/// The key of the table.
pub const KEY: &str = "forces";

/// Young's modulus (Pa) and Poisson's ratio of steel.
const STEEL: [f64; 2] = [210e9, 0.3];

/// α of teeth (rad), DIN 867.
const TOOTH_ANGLE: f64 = PI / 9.0;

/// Synonyms of the keys.
const SYNONYMS: &[(&str, &str)] = &[
    ("g", "gravity"),
    ("width", "roller_width"),
    ("E", "E_cam"),
    ("nu", "nu_cam"),
    ("J", "lever_J"),
    ("load", "process"),
    ("force", "process"),
    ("F", "process"),
    ("F0", "preload"),
    ("stiffness", "c"),
];

/// Properties of a follower that its loads depend on.
struct Known {
    turns: bool,
    mechanisms: usize,
    geometry: bool,
    lever: bool,
}

/// The loads of all cams of a scene, in its order, with its drive where that is right already.
pub fn all(root: &Section<'_>, drive: Option<&Value>, cams: &[CamPlan], folder: &Path) -> Option<Vec<Loads>> {
    let known = |section: &Section<'_>, follower: Option<usize>, turns: bool, mechanisms: usize| {
        let geometry = section.has(geometry::KEY);
        // A geometry with faults is taken for one that fits.
        let plan = cams.iter().find(|cam| cam.follower == follower).map(|cam| cam.plan);
        let lever = plan.map_or(geometry || mechanisms > 0, |plan| matches!(plan.carrier, Carrier::Lever { .. }));
        Known { turns, mechanisms, geometry, lever }
    };
    let mut list = Vec::new();
    if root.has("cam") {
        list.push(of(root, &known(root, None, false, 0), folder));
    }
    for (j, section) in root.sections("follower")?.iter().enumerate() {
        let follower = drive.and_then(|drive| drive.get("followers")?.get(j));
        let follower: Option<Follower> = follower.and_then(|value| serde_json::from_value(value.clone()).ok());
        let turns = follower.as_ref().map_or(section.has("J"), |follower| follower.turns);
        let mechanisms = section.sections("linkage")?.len();
        list.push(of(section, &known(section, Some(j + 1), turns, mechanisms), folder));
    }
    list.into_iter().collect()
}

/// The cams of a scene with what they move, at rest.
///
/// # Errors
/// Where the model has no cam.
pub fn machine(scene: &Resolved) -> Result<Machine, Fault> {
    let (followers, inertia) = if scene.model == "RigidMachine" {
        let whole: rigid_machine::Scene = scene.resource().read()?;
        (whole.followers, whole.inertia.varying)
    } else {
        let cam = serde_json::from_value(scene.scene["cam"].clone());
        let cam = cam.map_err(|_| Fault::new(format!("a {} has no cam", scene.model)))?;
        let parameters = &scene.scene["parameters"];
        let mass = ["m", "m1", "m2"].iter().filter_map(|key| parameters.get(key)?.as_f64()).sum();
        (vec![Follower::new(mass, cam)], None)
    };
    let mut drives = Vec::new();
    for (j, (follower, loads)) in followers.into_iter().zip(&scene.loads).enumerate() {
        let number = (scene.model == "RigidMachine").then_some(j + 1);
        let name = number.map_or(scene.name.clone(), |j| format!("{}.follower{j}", scene.name));
        let plan = scene.cams.iter().find(|cam| cam.follower == number).map(|cam| cam.plan);
        drives.push(Drive::new(name, follower, plan, loads.clone())?);
    }
    Ok(Machine { name: scene.name.clone(), speed: 0.0, inertia, drives })
}

fn of(parent: &Section<'_>, known: &Known, folder: &Path) -> Option<Loads> {
    let Some(section) = parent.section(KEY)? else { return Some(Loads::default()) };
    let (force, stiffness, position): (&'static Quantity, &'static Quantity, &'static Quantity) = match known.turns {
        true => (&unit::TORQUE, &unit::ROTATIONAL_STIFFNESS, &unit::ANGLE),
        false => (&unit::FORCE, &unit::STIFFNESS, &unit::LENGTH),
    };
    let gravity = gravity(&section, known);
    let spring = section.read("spring", |section| {
        let preload = section.real_or("preload", force, NOT_NEGATIVE, 0.0);
        let stiffness = section.real_or("c", stiffness, NOT_NEGATIVE, 0.0);
        let at = section.optional("at", position, ANY);
        section.finish(SYNONYMS);
        Some(Spring { preload: preload?, stiffness: stiffness?, at: at? })
    });
    let process = process(&section, force, folder);
    if !known.lever {
        section.forbid(&["lever_J"], "no lever is known", "geometry with follower = \"lever\"");
    }
    let lever_inertia = section.real_or("lever_J", &unit::INERTIA, NOT_NEGATIVE, 0.0);
    if known.mechanisms == 0 {
        section.forbid(&["tooth_radius", "tooth_angle"], "there is no gear", "[[follower.linkage]] with a gear");
    }
    let radius = section.optional("tooth_radius", &unit::LENGTH, POSITIVE);
    let angle = section.real_or("tooth_angle", &unit::ANGLE, within(0.0, 0.25 * TAU - 0.01), TOOTH_ANGLE);
    let material = material(&section, known);
    section.finish(SYNONYMS);
    Some(Loads {
        lever_inertia: lever_inertia?,
        gravity: gravity?,
        spring: spring?,
        process: process?,
        teeth: Teeth { radius: radius?, angle: angle? },
        material: material?,
    })
}

/// g in the frame of each mechanism, or along the motion of the tool.
fn gravity(section: &Section<'_>, known: &Known) -> Option<Vec<Point>> {
    let size = section.real_or("gravity", &unit::ACCELERATION, NOT_NEGATIVE, 0.0);
    let places = known.mechanisms.max(1);
    if !section.has("gravity_angle") {
        let usual = if known.mechanisms > 0 { -FRAC_PI_2 } else { PI };
        return Some(vec![Point::from_polar(size?, usual); places]);
    }
    if !section.has("gravity") {
        section.forbid(&["gravity_angle"], "there is no gravity", "gravity = \"9.81 m/s2\"");
    }
    let angles = match section.node("gravity_angle")?.value {
        DeValue::Array(_) => section.reals("gravity_angle", &unit::ANGLE),
        _ => section.real("gravity_angle", &unit::ANGLE, within(-TAU, TAU)).map(|angle| vec![angle]),
    };
    let angles = angles?;
    if angles.len() != places {
        let fault = section.fault_of("gravity_angle", format!(" has {} angles", angles.len()));
        return section.refuse(
            fault.admissible(format!("{places}, one for each mechanism; without mechanisms, one for the tool")),
        );
    }
    let size = size?;
    Some(angles.into_iter().map(|angle| Point::from_polar(size, angle)).collect())
}

/// P(φ): a value, or a law as in `[cam]`.
fn process(section: &Section<'_>, force: &'static Quantity, folder: &Path) -> Option<Option<MotionLaw>> {
    if let Some(Node { value: DeValue::Table(_), .. }) = section.node("process") {
        return section.read("process", |section| motion_law::read(section, force, folder));
    }
    let value = section.optional("process", force, ANY)?;
    Some(value.map(|value| MotionLaw::Fourier(Fourier::new(vec![value], Vec::new()))))
}

fn material(section: &Section<'_>, known: &Known) -> Option<Option<Material>> {
    if !known.geometry {
        section.forbid(&["roller_width"], "no roller is known", "a geometry of the cam");
    }
    if !section.has("roller_width") {
        let keys = ["E_cam", "E_roller", "nu_cam", "nu_roller"];
        section.forbid(&keys, "without its width the contact has no pressure", "roller_width");
        return Some(None);
    }
    let width = section.real("roller_width", &unit::LENGTH, POSITIVE);
    let elasticity = ["E_cam", "E_roller"].map(|key| section.real_or(key, &units::PRESSURE, POSITIVE, STEEL[0]));
    let poisson = ["nu_cam", "nu_roller"].map(|key| section.real_or(key, &unit::NUMBER, within(0.0, 0.5), STEEL[1]));
    let ([e1, e2], [nu1, nu2]) = (elasticity, poisson);
    Some(Some(Material { width: width?, elasticity: [e1?, e2?], poisson: [nu1?, nu2?] }))
}
