//! Loads on the mass that a cam moves: `[load]` next to `[cam]`, `[follower.load]`, with `roller` for a mass on the cam's side.

use super::motion_law;
use crate::document::{Node, Section, Value};
use camdrive::drives::follower::load::{Load, Spring};
use camdrive::drives::follower::rigid::Follower;
use camdrive::motion::{Fourier, MotionLaw};
use camdrive_design::forces::least_place;
use camdrive_design::text::counted;
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

/// The key of the table.
pub const KEY: &str = "load";

/// A mass with loads, and its motion.
#[derive(Clone, Copy)]
pub struct Carrier<'a> {
    /// True if the tool's coordinate is an angle.
    pub turns: bool,
    /// The number of mechanisms between it and the cam.
    pub mechanisms: usize,
    /// Law and mechanisms, if these are valid.
    pub follower: Option<&'a Follower>,
    /// True if there is a mass on the cam's side.
    pub roller: bool,
}

/// The loads on the tool and on the mass on the cam's side.
pub fn read(parent: &Section<'_>, carrier: Carrier<'_>, folder: &Path) -> Option<[Load; 2]> {
    let Some(section) = parent.section(KEY)? else { return Some([Load::default(), Load::default()]) };
    of(&section, carrier, folder)
}

/// The loads in the table.
pub fn of(section: &Section<'_>, carrier: Carrier<'_>, folder: &Path) -> Option<[Load; 2]> {
    if !carrier.roller {
        section.forbid(
            &["roller"],
            "there is no mass on the cam's side",
            "`elasticity.m_roller` or a drive with backlash",
        );
    }
    let roller = section.section("roller").and_then(|part| match part {
        Some(part) => one(&part, carrier),
        None => Some(Load::default()),
    });
    section.turning(carrier.turns);
    let process = torque(section, "process", folder);
    let input = section.flag("input");
    let tool = one(section, carrier);
    Some([Load { process: process?, input: input?, ..tool? }, roller?])
}

/// The loads of a drive with one cam.
pub fn beside_cam(root: &Section<'_>, cam: Option<&MotionLaw>, roller: bool, folder: &Path) -> Option<[Load; 2]> {
    let follower = cam.map(|cam| Follower::new(0.0, cam.clone()));
    read(root, Carrier { turns: false, mechanisms: 0, follower: follower.as_ref(), roller }, folder)
}

/// The load on one mass.
fn one(section: &Section<'_>, carrier: Carrier<'_>) -> Option<Load> {
    section.turning(carrier.turns);
    let gravity = gravity(section, carrier);
    let constant = section.optional("force");
    let spring = section.read("spring", |part| {
        let preload = part.real("preload");
        let c = part.real("c");
        let at = part.optional("at");
        part.finish();
        let at = match (at?, carrier.follower) {
            (Some(at), _) => at,
            (None, Some(follower)) => least_place(follower)
                .map_err(|fault| part.faults.report(part.fault(format!(" has no `at`: {fault}"))))
                .ok()?,
            (None, None) => 0.0,
        };
        Some(Spring { preload: preload?, c: c?, at })
    });
    let damping = section.optional("damping");
    section.finish();
    let (gravity, frames) = gravity?;
    let (constant, spring, damping) = (constant?, spring?, damping?);
    Some(Load { gravity, frames, constant, spring, damping, process: None, input: false })
}

/// g along y, and in the frame of each mechanism.
fn gravity(section: &Section<'_>, carrier: Carrier<'_>) -> Option<(Option<f64>, Vec<[f64; 2]>)> {
    let places = carrier.mechanisms.max(1);
    if carrier.turns && carrier.mechanisms == 0 {
        let because = "a tool that turns counts as balanced";
        section.forbid(&["gravity", "gravity_angle"], because, "`process` for the torque of its weight");
        return Some((None, Vec::new()));
    }
    let size = section.optional("gravity");
    if !section.has("gravity") {
        section.forbid(&["gravity_angle"], "there is no gravity", "gravity = \"9.81 m/s2\"");
    }
    let angles = match section.node("gravity_angle").map(|node| node.value) {
        None => Some(vec![if carrier.mechanisms > 0 { -FRAC_PI_2 } else { PI }; places]),
        Some(Value::Array(_)) => section.reals("gravity_angle"),
        Some(_) => section.real("gravity_angle").map(|angle| vec![angle]),
    };
    let angles = angles?;
    if angles.len() != places {
        let fault = section.fault_of("gravity_angle", format!(" has {}", counted(angles.len(), "angle")));
        return section.refuse(
            fault.admissible(format!("{places}, one for each mechanism; without mechanisms, one for the tool")),
        );
    }
    let Some(size) = size? else { return Some((None, Vec::new())) };
    let frames: Vec<[f64; 2]> = angles.iter().map(|angle| [size * angle.cos(), size * angle.sin()]).collect();
    // A tool after mechanisms moves along the x axis of the last frame, or turns.
    let along = (!carrier.turns).then(|| frames[places - 1][0]);
    Some((along, if carrier.mechanisms > 0 { frames } else { Vec::new() }))
}

/// A force or a torque over the turn: a value, or a law.
pub fn torque(section: &Section<'_>, key: &'static str, folder: &Path) -> Option<Option<MotionLaw>> {
    if let Some(Node { value: Value::Table(_), .. }) = section.node(key) {
        return section.read(key, |part| motion_law::read(part, section.quantity_of(key), folder));
    }
    let value = section.optional(key)?;
    Some(value.map(|value| MotionLaw::Fourier(Fourier::new(vec![value], Vec::new()))))
}
