//! What a cam of a machine moves: `[[follower]]` and `[[follower.linkage]]`.

use super::models::{either, forbid};
use super::section::{ANY, Limits, NOT_NEGATIVE, POSITIVE, Section, within};
use super::{forces, geometry, motion_law};
use camdrive::drives::rigid_machine::Follower;
use camdrive::drives::rigid_machine::linkage::{
    Branch, FourBar, Gear, Kind, Link, Linkage, Mechanism, ParameterKind, SliderCrank,
};
use camdrive::drives::unit::{self, Quantity};
use camdrive::motion::MotionLaw;
use camdrive_design::lever_law::lever_law;
use std::path::Path;

/// The longest chain of mechanisms.
const MOST_MECHANISMS: usize = 16;

/// What people write for the keys.
const SYNONYMS: &[(&str, &str)] = &[
    ("mass", "m"),
    ("inertia", "J"),
    ("links", "linkage"),
    ("mechanism", "linkage"),
    ("mechanisms", "linkage"),
    ("type", "kind"),
    ("frame", "ground"),
    ("g", "ground"),
    ("a", "input"),
    ("b", "coupler"),
    ("c", "output"),
    ("rocker", "output"),
    ("connecting_rod", "rod"),
    ("r", "crank"),
    ("l", "rod"),
    ("e", "offset"),
    ("mode", "branch"),
];

/// Reads one of `[[follower]]`.
pub fn read(section: &Section<'_>, folder: &Path) -> Option<Follower> {
    let linkage = linkage(section);
    let linked = section.has("linkage");
    let turns = match linkage.as_ref().and_then(|linkage| linkage.0.last()) {
        Some(last) => last.output_turns(),
        None => section.has("J") && !section.has("m"),
    };
    let (own, other, quantity, because) = if turns {
        ("J", "m", &unit::INERTIA, "the tool turns, its coordinate is an angle")
    } else {
        ("m", "J", &unit::MASS, "the tool moves along a line")
    };
    // Which of them it is, is not known where the linkage is wrong.
    let m = if linkage.is_some() {
        forbid(section, &[other], because, &format!("`{own}`"));
        if linked {
            // The links may be all that moves.
            section.real_or(own, quantity, NOT_NEGATIVE, 0.0)
        } else {
            section.real(own, quantity, POSITIVE)
        }
    } else {
        section.has("m");
        section.has("J");
        None
    };
    // Read when the law is known.
    section.has(geometry::KEY);
    section.has(forces::KEY);
    let tool_quantity = if turns { &unit::ANGLE } else { &unit::LENGTH };
    let cam = if linked && section.has("tool") && either(section, "tool", "cam") {
        linkage.as_ref().and_then(|linkage| lever(section, linkage, tool_quantity, folder))
    } else {
        let because = "it is the motion that the cam gives to the tool behind mechanisms";
        if !linked {
            forbid(section, &["tool"], because, "`[follower.cam]`, or add `[[follower.linkage]]`");
        }
        forbid(section, &["lever_start"], "the law of the lever is given", "`[follower.tool]` instead of the cam");
        let quantity = if linked { &unit::ANGLE } else { tool_quantity };
        section.required_section("cam").and_then(|s| motion_law::read(&s, quantity, folder))
    };
    section.finish(SYNONYMS);
    Some(Follower { m: m?, turns, cam: cam?, linkage: linkage? })
}

/// The law of the lever with which the tool moves as `[follower.tool]` says.
fn lever(section: &Section<'_>, linkage: &Linkage, quantity: &'static Quantity, folder: &Path) -> Option<MotionLaw> {
    let start = section.real_or("lever_start", &unit::ANGLE, limits(ParameterKind::Angle), 0.0);
    let part = section.required_section("tool")?;
    let tool = motion_law::read(&part, quantity, folder)?;
    match lever_law(linkage, &tool, start?) {
        Ok(found) => {
            section.faults.note(format!(
                "{}: the lever's law has {}; with it the tool's acceleration is as prescribed to {:.1e} of its largest value",
                part.path,
                found.parts(),
                found.error
            ));
            Some(found.law)
        }
        Err(reason) => {
            let fault = part.fault(format!("`{}`: {reason}", part.path));
            let hint = "change the motion, the lengths, offsets or branch, or `lever_start`, the angle next to which it begins";
            section.faults.report(fault.hint(hint));
            None
        }
    }
}

/// Reads `[[follower.linkage]]`, from the lever to the tool.
fn linkage(section: &Section<'_>) -> Option<Linkage> {
    let list = section.sections("linkage")?;
    if list.len() > MOST_MECHANISMS {
        let message = format!("`{}` has {} mechanisms", section.path_of("linkage"), list.len());
        let fault = section.fault_of("linkage", message).admissible(format!("at most {MOST_MECHANISMS}"));
        section.faults.report(fault);
    }
    let mut mechanisms: Vec<Option<Mechanism>> = Vec::new();
    for (i, part) in list.iter().enumerate() {
        let read = mechanism(part);
        if i + 1 < list.len() && read.is_some_and(|read| !read.output_turns()) {
            let message = format!("`{}`: its output is a length, and the next mechanism needs an angle", part.path);
            let hint = "only the last mechanism may move along a line";
            section.faults.report(part.fault(message).hint(hint));
        }
        mechanisms.push(read);
    }
    mechanisms.into_iter().collect::<Option<Vec<_>>>().map(Linkage)
}

#[derive(Clone, Copy, PartialEq)]
enum Name {
    FourBar,
    SliderCrank,
    Gear,
}

const KINDS: &[(&[&str], Name)] = &[
    (&["four_bar", "four-bar", "fourbar"], Name::FourBar),
    (&["slider_crank", "slider-crank", "crank_slider"], Name::SliderCrank),
    (&["gear", "belt", "rack"], Name::Gear),
];

const BRANCHES: &[(&[&str], Branch)] = &[(&["plus", "+"], Branch::Plus), (&["minus", "-"], Branch::Minus)];

/// The range of a parameter in the FMU.
fn limits(kind: ParameterKind) -> Limits {
    let [least, greatest] = kind.range();
    within(least, greatest)
}

fn mechanism(section: &Section<'_>) -> Option<Mechanism> {
    let name = section.choice("kind", KINDS);
    let mechanism = name.map(|name| {
        let input_offset = section.real_or("input_offset", &unit::ANGLE, limits(ParameterKind::Angle), 0.0);
        let kind = match name {
            Name::FourBar => four_bar(section).map(Kind::FourBar),
            Name::SliderCrank => slider_crank(section).map(Kind::SliderCrank),
            Name::Gear => gear(section).map(Kind::Gear),
        };
        let turns = name == Name::FourBar || (name == Name::Gear && !section.has("radius"));
        let (output, range): (&'static Quantity, _) = if turns {
            (&unit::ANGLE, limits(ParameterKind::Angle))
        } else {
            (&unit::LENGTH, limits(ParameterKind::Coordinate))
        };
        let output_offset = section.real_or("output_offset", output, range, 0.0);
        section.finish(SYNONYMS);
        Some(Mechanism { kind: kind?, input_offset: input_offset?, output_offset: output_offset? })
    });
    mechanism?
}

/// A link, given by a table; without `x` its centre of mass is in the middle, without `J` it is a slender bar.
fn link(section: &Section<'_>, key: &'static str) -> Option<Link> {
    let part = section.required_section(key)?;
    let length = part.real("length", &unit::LENGTH, limits(ParameterKind::Length));
    let mass = part.real_or("m", &unit::MASS, limits(ParameterKind::Mass), 0.0);
    let inertia = part.optional("J", &unit::INERTIA, limits(ParameterKind::Inertia));
    let x = part.optional("x", &unit::LENGTH, limits(ParameterKind::Coordinate));
    let y = part.real_or("y", &unit::LENGTH, limits(ParameterKind::Coordinate), 0.0);
    part.finish(SYNONYMS);
    let (length, mass) = (length?, mass?);
    Some(Link {
        length,
        mass,
        inertia: inertia?.unwrap_or(mass * length * length / 12.0),
        centre: [x?.unwrap_or(0.5 * length), y?],
    })
}

fn four_bar(section: &Section<'_>) -> Option<FourBar> {
    let ground = section.real("ground", &unit::LENGTH, limits(ParameterKind::Length));
    let [input, coupler, output] = ["input", "coupler", "output"].map(|key| link(section, key));
    let branch = section.choice_or("branch", BRANCHES, Branch::Plus);
    Some(FourBar { ground: ground?, input: input?, coupler: coupler?, output: output?, branch: branch? })
}

fn slider_crank(section: &Section<'_>) -> Option<SliderCrank> {
    let [crank, rod] = ["crank", "rod"].map(|key| link(section, key));
    let offset = section.real_or("offset", &unit::LENGTH, limits(ParameterKind::Coordinate), 0.0);
    let slider_mass = section.real_or("slider_m", &unit::MASS, limits(ParameterKind::Mass), 0.0);
    let branch = section.choice_or("branch", BRANCHES, Branch::Plus);
    Some(SliderCrank { crank: crank?, rod: rod?, offset: offset?, slider_mass: slider_mass?, branch: branch? })
}

fn gear(section: &Section<'_>) -> Option<Gear> {
    let turns = !section.has("radius");
    let ratio = if turns {
        section.real("ratio", &unit::NUMBER, ANY)
    } else {
        forbid(section, &["ratio"], "the radius says how far the output moves", "a gear pair without `radius`");
        section.real("radius", &unit::LENGTH, ANY)
    };
    let inertia = section.real_or("J", &unit::INERTIA, limits(ParameterKind::Inertia), 0.0);
    let key = if turns { "ratio" } else { "radius" };
    if ratio == Some(0.0) {
        let fault = section.fault_of(key, format!("`{}`: the output would not move", section.path_of(key)));
        section.faults.report(fault.admissible("a value other than 0"));
    }
    Some(Gear { ratio: ratio?, inertia: inertia?, output_turns: turns })
}
