//! The follower of a cam of a machine: `[[follower]]` and `[[follower.linkage]]`.

use super::{forces, geometry, load, motion_law};
use crate::document::Section;
use camdrive::drives::rigid_machine::Follower;
use camdrive::drives::rigid_machine::linkage::{
    Branch, FourBar, Gear, Kind, Linkage, Mechanism, Parameter, SliderCrank,
};
use camdrive::drives::unit::{self, Quantity};
use camdrive::motion::{Crank, MotionLaw};
use camdrive_design::lever_law::lever_law;
use camdrive_design::resource::Tool;
use std::path::Path;

/// The longest chain of mechanisms.
const MOST_MECHANISMS: usize = 16;

/// The kinds of mechanisms.
pub const KINDS: &[(&str, fn() -> Kind)] = &[
    ("four_bar", || Kind::FourBar(FourBar::default())),
    ("slider_crank", || Kind::SliderCrank(SliderCrank::default())),
    ("gear", || Kind::Gear(Gear::default())),
];

/// Reads one of `[[follower]]`; the masses belong to the `joint` between cam and tool if there is one.
pub fn read(section: &Section<'_>, joint: Option<&str>, folder: &Path) -> Option<Follower> {
    let linkage = linkage(section);
    let linked = section.has("linkage");
    let turns = match linkage.as_ref().and_then(|linkage| linkage.0.last()) {
        Some(last) => last.output_turns(),
        None => joint.is_none() && section.has("J") && !section.has("m"),
    };
    let Parameter { key: own, kind: _, .. } = Parameter::mass(turns);
    let (other, because) = match turns {
        true => ("m", "the tool turns, its coordinate is an angle"),
        false => ("J", "the tool moves along a line"),
    };
    // With a wrong linkage the kind of the tool is unknown.
    let m = if let Some(joint) = joint {
        section.forbid(&["m", "J"], &format!("`{joint}` has the masses"), &format!("a follower without `{joint}`"));
        Some(0.0)
    } else if linkage.is_some() {
        section.forbid(&[other], because, &format!("`{own}`"));
        // With mechanisms the links alone may move.
        if linked { section.real_or(own, 0.0) } else { section.positive(own) }
    } else {
        section.has("m");
        section.has("J");
        None
    };
    // Read after the law.
    section.has(geometry::KEY);
    section.has(forces::KEY);
    section.has(load::KEY);
    let tool_quantity = if turns { &unit::ANGLE } else { &unit::LENGTH };
    let cam = if section.has("crank") {
        crank(section)
    } else if linked && section.has("tool") && section.either("tool", "cam") {
        linkage.as_ref().and_then(|linkage| lever(section, linkage, tool_quantity, folder))
    } else {
        let because = "it is the motion of a tool behind mechanisms";
        if !linked {
            section.forbid(&["tool"], because, "`[follower.cam]`, or add `[[follower.linkage]]`");
        }
        section.forbid(&["lever_start"], "the cam has the law of the lever", "`[follower.tool]` instead of the cam");
        let quantity = if linked { &unit::ANGLE } else { tool_quantity };
        motion_law::of_cam(section, quantity, folder)
    };
    section.finish();
    Some(Follower { m: m?, turns, cam: cam?, linkage: linkage? })
}

/// The shaft itself as the drive of the mechanisms.
fn crank(section: &Section<'_>) -> Option<MotionLaw> {
    if !section.has("linkage") {
        let fault = section.fault_of("crank", ": there is no mechanism to move");
        section.faults.report(fault.hint("add `[[follower.linkage]]`, for example kind = \"slider_crank\""));
    }
    let because = "the mechanism sits on the shaft without a cam (`[follower.crank]`)";
    section.forbid(&["cam", "tool", "lever_start", geometry::KEY], because, "a cam instead of `crank`");
    section.read("crank", |part| {
        let offset = part.real("offset");
        part.finish();
        Some(MotionLaw::Crank(Crank { offset: offset? }))
    })?
}

/// The law of the lever that moves the tool as in `[follower.tool]`.
fn lever(section: &Section<'_>, linkage: &Linkage, quantity: &'static Quantity, folder: &Path) -> Option<MotionLaw> {
    let start = section.real("lever_start");
    let part = section.required_section("tool")?;
    let tool = motion_law::read(&part, quantity, folder)?;
    match lever_law(linkage, &tool, start?) {
        Ok(found) => {
            section.faults.note(format!(
                "{}: the lever's law has {}; it gives the prescribed acceleration of the tool to {:.1e} of its largest value",
                part.path,
                found.parts(),
                found.error
            ));
            let prescribed = Tool { section: part.path.clone(), law: tool, unit: quantity.unit };
            section.faults.tools.borrow_mut().push(prescribed);
            Some(found.law)
        }
        Err(reason) => {
            let fault = part.fault(format!(": {reason}"));
            let hint = "change motion, lengths, offsets or branch, or `lever_start`, the angle near which it starts";
            section.refuse(fault.hint(hint))
        }
    }
}

/// Reads `[[follower.linkage]]`, from the lever to the tool.
fn linkage(section: &Section<'_>) -> Option<Linkage> {
    let list = section.sections("linkage")?;
    if list.len() > MOST_MECHANISMS {
        let message = format!(" has {} mechanisms", list.len());
        let fault = section.fault_of("linkage", message).admissible(format!("at most {MOST_MECHANISMS}"));
        section.faults.report(fault);
    }
    let mut mechanisms: Vec<Option<Mechanism>> = Vec::new();
    for (i, part) in list.iter().enumerate() {
        let read = mechanism(part);
        if i + 1 < list.len() && read.is_some_and(|read| !read.output_turns()) {
            let message = ": its output is a length, and the next mechanism needs an angle";
            let hint = "only the last mechanism may move along a line";
            section.faults.report(part.fault(message).hint(hint));
        }
        mechanisms.push(read);
    }
    mechanisms.into_iter().collect::<Option<Vec<_>>>().map(Linkage)
}

/// The signs of a root.
pub const BRANCHES: &[(&str, Branch)] = &[("plus", Branch::Plus), ("minus", Branch::Minus)];

fn mechanism(section: &Section<'_>) -> Option<Mechanism> {
    let mut kind = section.choice("kind", KINDS)?();
    let mut right = true;
    match &mut kind {
        Kind::FourBar(FourBar { branch, .. }) | Kind::SliderCrank(SliderCrank { branch, .. }) => {
            match section.choice("branch", BRANCHES) {
                Some(read) => *branch = read,
                None => right = false,
            }
        }
        Kind::Gear(gear) => gear.output_turns = !section.has("radius"),
    }
    let mut mechanism = Mechanism { kind, input_offset: 0.0, output_offset: 0.0 };
    section.turning(mechanism.output_turns());
    if matches!(kind, Kind::Gear(Gear { output_turns: false, .. })) {
        section.forbid(&["ratio"], "the radius determines the travel of the output", "a gear pair without `radius`");
    }
    let parameters = mechanism.parameters();
    let mut first = 0;
    for group in parameters.chunk_by(|a, b| a.link == b.link) {
        let link = group[0].link.map(|link| section.required_section(link));
        match &link {
            None => right &= values(section, &mut mechanism, group, first),
            Some(Some(part)) => {
                right &= values(part, &mut mechanism, group, first);
                part.finish();
            }
            Some(None) => right = false,
        }
        first += group.len();
    }
    section.finish();
    right.then_some(mechanism)
}

/// Reads these parameters; the first one has the index `first`. False if one of them is wrong. A link without `x` has its centre of
/// mass in the middle, and without `J` it is a slender bar.
fn values(section: &Section<'_>, mechanism: &mut Mechanism, parameters: &[Parameter], first: usize) -> bool {
    let mut right = true;
    for (i, &Parameter { link, key, kind, .. }) in parameters.iter().enumerate() {
        let mut before = |i: usize| mechanism.parameter_mut(first + i).map_or(0.0, |value| *value);
        let default = match (link, key) {
            (Some(_), "J") => before(1) * before(0) * before(0) / 12.0,
            (Some(_), "x") => 0.5 * before(0),
            _ => 0.0,
        };
        let value = if kind.is_required() { section.real(key) } else { section.real_or(key, default) };
        if kind.is_ratio() && value == Some(0.0) {
            let fault = section.fault_of(key, ": the output would not move");
            section.faults.report(fault.admissible("a value other than 0"));
        }
        match (value, mechanism.parameter_mut(first + i)) {
            (Some(value), Some(place)) => *place = value,
            _ => right = false,
        }
    }
    right
}
