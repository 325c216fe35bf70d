//! The geometry of a cam: `[geometry]` next to `[cam]`, `[follower.geometry]`. It does not affect the FMU.

use crate::document::Section;
use camdrive::motion::MotionLaw;
use camdrive_design::cam_geometry::{Carrier, Cut, Limits, Plan, Second, Start};
use camdrive_design::resource::Scene;
use camdrive_design::transmission::{self, Transmission};
use std::f64::consts::PI;

/// The key of the table.
pub const KEY: &str = "geometry";

/// A cam of the scene with a geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct CamPlan {
    /// The follower of the cam, from 1; None if the drive has only one cam.
    pub follower: Option<usize>,
    /// U(φ) (m), or (rad) if the cam moves a lever by an angle.
    pub law: MotionLaw,
    /// The geometry.
    pub plan: Plan,
    /// The mechanisms after the cam.
    pub mechanisms: Vec<Transmission>,
}

/// Admissible pressure angles (rad): 45° for a lever and 30° for a translating follower, after VDI 2142.
const PRESSURE_ANGLES: [f64; 2] = [PI / 4.0, PI / 6.0];

/// All geometries of a scene, with the laws of its drive if that is valid already.
pub fn all(root: &Section<'_>, drive: Option<&Scene>) -> Option<Vec<CamPlan>> {
    let known = |j: usize| drive.and_then(|drive| drive.follower(j));
    // A machine has no [cam] for a [geometry].
    let own = drive.and_then(|drive| drive.cam().or(drive.follower(0).map(|follower| &follower.cam)));
    let mut list = if root.has("cam") { vec![of(root, None, own, false)] } else { Vec::new() };
    for (j, follower) in root.sections("follower").unwrap_or_default().iter().enumerate() {
        let angular = follower.has("linkage") || (follower.has("J") && !follower.has("m"));
        let plan = of(follower, Some(j + 1), known(j).map(|known| &known.cam), angular);
        let behind = || known(j).map(|known| transmission::of(j + 1, known)).unwrap_or_default();
        list.push(plan.map(|plan| plan.map(|plan| CamPlan { mechanisms: behind(), ..plan })));
    }
    let all: Option<Vec<Option<CamPlan>>> = list.into_iter().collect();
    Some(all?.into_iter().flatten().collect())
}

/// The geometry in this table, if there is one, for a law of a length or an angle.
fn of(
    parent: &Section<'_>,
    follower: Option<usize>,
    law: Option<&MotionLaw>,
    angular: bool,
) -> Option<Option<CamPlan>> {
    let Some(section) = parent.section(KEY)? else { return Some(None) };
    let plan = read(&section, angular)?;
    let law = law?;
    if let Err(fault) = plan.cams(law) {
        let fault = section.fault(format!(": {fault}"));
        return section.refuse(fault.hint("choose other lengths, or another base or prime circle"));
    }
    Some(Some(CamPlan { follower, law: law.clone(), plan, mechanisms: Vec::new() }))
}

/// The kind of a follower's motion.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    /// On a lever that swings.
    Lever,
    /// Along a line.
    Translating,
    /// Along a line, with a flat face.
    Flat,
}

/// The contours of a cam.
#[derive(Clone, Copy, PartialEq)]
pub enum Contour {
    /// A disc.
    Inner,
    /// A ring.
    Outer,
    /// Both.
    Groove,
    /// Two discs.
    Conjugate,
}

/// Kinds of followers.
pub const KINDS: &[(&str, Kind)] = &[("lever", Kind::Lever), ("translating", Kind::Translating), ("flat", Kind::Flat)];
/// Kinds of cams.
pub const CONTOURS: &[(&str, Contour)] = &[
    ("inner", Contour::Inner),
    ("outer", Contour::Outer),
    ("groove", Contour::Groove),
    ("conjugate", Contour::Conjugate),
];
/// Senses of rotation.
pub const ROTATIONS: &[(&str, f64)] = &[("counterclockwise", 1.0), ("clockwise", -1.0)];
/// Sides of a lever.
pub const SIDES: &[(&str, f64)] = &[("left", 1.0), ("right", -1.0)];

/// The geometry of a cam with a law of a length or an angle.
pub fn read(section: &Section<'_>, angular: bool) -> Option<Plan> {
    let kind = section.choice("follower", KINDS);
    let flat = kind == Some(Kind::Flat);
    if angular && (flat || kind == Some(Kind::Translating)) {
        let message = ": the law of this cam is the angle of a lever";
        section.faults.report(section.fault_of("follower", message).admissible("lever"));
    }
    let contour = section.choice("contour", CONTOURS);
    let sense = section.choice("rotation", ROTATIONS);
    if flat && contour.is_some_and(|contour| contour != Contour::Inner) {
        let fault = section.fault_of("contour", ": a flat face runs on a disc");
        section.faults.report(fault.admissible("inner"));
    }
    let roller = if flat {
        section.forbid(&["roller_radius"], OF_A_FACE, "another follower");
        section.optional("cutter_radius").map(|radius| radius.unwrap_or(0.0))
    } else {
        section.real("roller_radius")
    };
    let carrier = kind.and_then(|kind| carrier(section, kind, angular));
    let start = kind.zip(contour).and_then(|(kind, contour)| start(section, kind, contour));
    let cut = kind.zip(contour).and_then(|(kind, contour)| cut(section, kind, contour, roller));
    let limits = limits(section, kind, contour, roller);
    // The kind of follower determines which keys belong here.
    if kind.is_some() && contour.is_some() {
        section.finish();
    }
    Some(Plan { carrier: carrier?, angular, start: start?, sense: sense?, roller: roller?, cut: cut?, limits: limits? })
}

const OF_A_LEVER: &str = "the follower is translating";
const OF_A_SLIDE: &str = "the follower is a lever";
const OF_A_FACE: &str = "the follower has a flat face";

fn carrier(section: &Section<'_>, kind: Kind, angular: bool) -> Option<Carrier> {
    match kind {
        Kind::Lever => {
            let pivot = section.real("pivot_distance");
            let length = section.real("arm_length");
            section.turning(angular);
            let words = if angular {
                "a number other than 0: angle of the law per angle of the arm"
            } else {
                "a length other than 0: travel of the tool per radian of the lever"
            };
            let transmission = section.optional("transmission");
            let side = section.choice("side", SIDES);
            if transmission == Some(Some(0.0)) {
                let fault = section.fault_of("transmission", ": 0 would turn the lever infinitely far");
                section.faults.report(fault.admissible(words));
            }
            section.forbid(&["offset"], OF_A_SLIDE, "follower = \"translating\"");
            let (pivot, length, transmission) = (pivot?, length?, transmission?);
            let usual = if angular { 1.0 } else { length };
            Some(Carrier::Lever { pivot, length, transmission: transmission.unwrap_or(usual), side: side? })
        }
        Kind::Translating => {
            let eccentricity = section.real("offset");
            let keys = ["pivot_distance", "arm_length", "transmission", "side"];
            section.forbid(&keys, OF_A_LEVER, "follower = \"lever\"");
            Some(Carrier::Translating { eccentricity: eccentricity? })
        }
        Kind::Flat => {
            let keys = ["pivot_distance", "arm_length", "transmission", "side", "offset", "max_pressure_angle"];
            section.forbid(&keys, OF_A_FACE, "another follower");
            Some(Carrier::Flat)
        }
    }
}

/// One of the keys for the size of the cam.
fn start(section: &Section<'_>, kind: Kind, contour: Contour) -> Option<Start> {
    let own = if kind == Kind::Lever { "start_angle" } else { "start_height" };
    match kind {
        Kind::Lever => section.forbid(&["start_height"], OF_A_SLIDE, "follower = \"translating\""),
        Kind::Translating => section.forbid(&["start_angle"], OF_A_LEVER, "follower = \"lever\""),
        Kind::Flat => section.forbid(&["start_angle", "prime_radius"], OF_A_FACE, "another follower"),
    }
    let coordinate = match kind {
        Kind::Lever => section.optional("start_angle"),
        Kind::Translating | Kind::Flat => section.optional("start_height"),
    };
    if kind == Kind::Flat && coordinate.flatten().is_some_and(|height| !(height > 0.0)) {
        let fault = section.fault_of("start_height", ": the face would run through the centre of the cam or below it");
        section.faults.report(fault.admissible("> 0 m"));
    }
    let prime = section.optional("prime_radius");
    let base = section.optional("base_radius");
    if contour == Contour::Outer {
        section.forbid(&["base_radius"], "a ring has no inner contour", "contour = \"inner\"");
    }
    let keys = [own, "prime_radius", "base_radius"];
    let given: Vec<&str> = keys.into_iter().filter(|key| section.has(key)).collect();
    let admissible = format!("one of `{}`", keys.join("`, `"));
    match given[..] {
        [] => {
            let fault = section.fault(": no key fixes the size of the cam");
            return section.refuse(fault.admissible(admissible).hint("add for example base_radius = \"60 mm\""));
        }
        [_] => {}
        [.., second] => {
            let message = format!(": `{}` fixes the size of the cam already", given[0]);
            let place = keys.into_iter().find(|key| *key == second).unwrap_or(own);
            return section.refuse(section.fault_of(place, message).admissible(admissible));
        }
    }
    let found = [coordinate?.map(Start::Coordinate), prime?.map(Start::Prime), base?.map(Start::Base)];
    found.into_iter().flatten().next()
}

fn cut(section: &Section<'_>, kind: Kind, contour: Contour, roller: Option<f64>) -> Option<Cut> {
    const KEYS: [&str; 4] = ["second_roller_radius", "second_arm_length", "second_arm_angle", "roller_distance"];
    match contour {
        Contour::Conjugate => {
            let second = section.optional("second_roller_radius");
            let (place, length) = match kind {
                Kind::Lever => {
                    section.forbid(&["roller_distance"], OF_A_SLIDE, "follower = \"translating\"");
                    let angle = section.real("second_arm_angle");
                    let length = section.optional("second_arm_length");
                    let own = section.optional("arm_length").flatten();
                    (angle, length.and_then(|length| length.or(own)))
                }
                Kind::Translating | Kind::Flat => {
                    let keys = ["second_arm_length", "second_arm_angle"];
                    section.forbid(&keys, OF_A_LEVER, "follower = \"lever\"");
                    (section.real("roller_distance"), Some(0.0))
                }
            };
            Some(Cut::Conjugate(Second { place: place?, length: length?, roller: second?.or(roller)? }))
        }
        other => {
            section.forbid(&KEYS, "there is no second roller", "contour = \"conjugate\"");
            Some(match other {
                Contour::Outer => Cut::Outer,
                Contour::Groove => Cut::Groove,
                _ => Cut::Inner,
            })
        }
    }
}

fn limits(section: &Section<'_>, kind: Option<Kind>, contour: Option<Contour>, roller: Option<f64>) -> Option<Limits> {
    let usual = if kind == Some(Kind::Lever) { PRESSURE_ANGLES[0] } else { PRESSURE_ANGLES[1] };
    let pressure = section.real_or("max_pressure_angle", usual);
    let cutter = section.optional("cutter_radius");
    let hub = match contour {
        Some(Contour::Outer) => {
            section.forbid(&["hub_radius"], "a ring has no inner contour", "contour = \"inner\"");
            Some(0.0)
        }
        _ => section.real("hub_radius"),
    };
    Some(Limits { pressure: pressure?, cutter: cutter?.or(roller)?, hub: hub? })
}
