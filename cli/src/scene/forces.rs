//! Data for the analysis of forces in addition to masses and loads: `[forces]` next to `[cam]`, `[follower.forces]`. They do not
//! affect the motion of the FMU.

use super::geometry::{self, CamPlan};
use crate::document::Section;
use camdrive_design::cam_geometry::Carrier;
use camdrive_design::forces::{Loads, Material, Teeth};
use camdrive_design::resource::Scene;

/// The key of the table.
pub const KEY: &str = "forces";

/// The keys that are part of [`load`] instead.
const MOVED: [&str; 4] = ["gravity", "gravity_angle", "spring", "process"];

/// Properties of a follower that determine its loads.
struct FollowerTraits {
    mechanisms: usize,
    geometry: bool,
    lever: bool,
}

/// The loads of all cams of a scene, in its order, with its drive if that is valid already.
pub fn all(root: &Section<'_>, drive: Option<&Scene>, cams: &[CamPlan]) -> Option<Vec<Loads>> {
    let known = |section: &Section<'_>, follower: Option<usize>, mechanisms: usize| {
        let geometry = section.has(geometry::KEY);
        // A geometry with faults counts as suitable.
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
        section.forbid(&["lever_J"], "there is no lever", "geometry with follower = \"lever\"");
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
        section.forbid(&["roller_width"], "there is no roller", "a geometry of the cam");
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
