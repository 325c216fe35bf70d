//! Motors with their transmission: `[motor]`.

use super::{motion_law, table};
use crate::document::{Node, Section, Value, units};
use camdrive::drives::limits::FASTEST;
use camdrive::drives::rigid_machine::Kloss;
use camdrive::drives::shaft::motor::{Motor, Reference, Servo, Source, TorqueTable, Transmission};
use camdrive::drives::unit;
use camdrive_design::text::counted;
use std::path::Path;

/// Reads the keys of a kind of motor.
pub type Reader = fn(&Section<'_>, &Path) -> Option<Source>;

/// The kinds, each with the keys of this kind alone.
pub const KINDS: &[(&str, (Reader, &[&str]))] = &[
    ("none", (|_, _| Some(Source::None), &[])),
    ("kloss", (|section, _| asynchronous(section).map(Source::Kloss), &["M_k", "s_k", "w_s", "lag"])),
    ("input", (|_, _| Some(Source::Input), &[])),
    ("constant", (constant, &["torque"])),
    ("table", (characteristic, &["points", "file", "speed_unit", "torque_unit", "speed_column", "torque_column"])),
    ("servo", (servo, &["K_p", "K_i", "K_aw", "K_v", "M_max", "w_ref"])),
];

/// The source of the torque.
fn source(section: &Section<'_>, folder: &Path) -> Option<Source> {
    let (read, own) = section.choice("kind", KINDS)?;
    let source = read(section, folder);
    for (name, (_, keys)) in KINDS {
        let others: Vec<_> = keys.iter().copied().filter(|key| !own.contains(key)).collect();
        section.forbid(&others, "this kind of motor has no such value", &format!("kind = \"{name}\""));
    }
    source
}

/// A motor with its transmission.
pub fn read(section: &Section<'_>, folder: &Path) -> Option<Motor> {
    let source = source(section, folder);
    let ratio = section.real("ratio");
    if ratio == Some(0.0) {
        let fault = section.fault_of("ratio", ": the motor would not turn");
        section.faults.report(fault.admissible("a value other than 0, negative if the rotor turns the other way"));
    }
    let rotor = section.real("J");
    let coupling = if section.either("coupling", "belt") { coupling(section) } else { None };
    if rotor == Some(0.0) && matches!(coupling, Some(Some(_))) {
        let fault = section.fault_of("J", ": a rotor with a coupling or belt needs its own inertia");
        section.faults.report(fault.admissible("greater than 0 kg.m2").hint("add for example J = \"0.02 kg.m2\""));
    }
    section.finish();
    Some(Motor { source: source?, transmission: Transmission { ratio: ratio?, rotor: rotor?, coupling: coupling? } })
}

/// c and b at the shaft.
fn coupling(section: &Section<'_>) -> Option<Option<[f64; 2]>> {
    let given = section.read("coupling", |part| {
        let (c, b) = (part.real("c"), part.real("b"));
        part.finish();
        Some([c?, b?])
    })?;
    let belt = section.read("belt", |part| {
        let [stiffness, preload, length, radius, b] =
            ["EA", "preload", "length", "radius", "b"].map(|key| part.real(key));
        part.finish();
        let (radius, slack) = (radius?, 2.0 * preload? * radius?);
        part.faults.note(format!(
            "`{}`: both strands stay taut up to {} N.m at the shaft",
            part.path,
            units::short(slack)
        ));
        Some([2.0 * stiffness? / length? * radius * radius, b?])
    })?;
    Some(given.or(belt))
}

fn asynchronous(section: &Section<'_>) -> Option<Kloss> {
    let kloss: Option<Kloss> = section.parameters(|parameter, _| {
        let value = section.real(parameter.key);
        if parameter.key == "w_s" && value == Some(0.0) {
            let fault = section.fault_of("w_s", ": 0 is not a synchronous speed: the slip is not defined");
            section.faults.report(fault.hint("choose kind = \"none\" for a motor that is off"));
        }
        Some(value)
    });
    let lag = section.optional("lag");
    kloss.zip(lag).map(|(kloss, dynamics)| Kloss { dynamics, ..kloss })
}

fn constant(section: &Section<'_>, _: &Path) -> Option<Source> {
    section.real("torque").map(Source::Constant)
}

/// The most points of a torque table: motors are measured at some ten points.
const MOST_POINTS: usize = 200;

fn characteristic(section: &Section<'_>, folder: &Path) -> Option<Source> {
    let axes =
        [(&unit::ANGULAR_VELOCITY, "speed_unit", "speed_column"), (&unit::TORQUE, "torque_unit", "torque_column")];
    let points = table::pairs(section, axes, folder)?;
    let key = if section.has("points") { "points" } else { "file" };
    if !(2..=MOST_POINTS).contains(&points.len()) {
        let fault = section.fault_of(key, format!(" has {}", counted(points.len(), "point")));
        return section.refuse(fault.admissible(format!("2 to {MOST_POINTS}, by ascending speed")));
    }
    if let Some([w, torque]) = points.iter().find(|[w, torque]| !(w.abs() <= FASTEST && torque.abs() <= 1e12)) {
        let fault = section.fault_of(
            key,
            format!(": the point {} rad/s, {} N.m is out of range", units::short(*w), units::short(*torque)),
        );
        return section.refuse(fault.admissible(format!("at most {FASTEST:e} rad/s and 1e12 N.m in magnitude")));
    }
    let (speeds, torques) = points.into_iter().map(|[w, torque]| (w, torque)).unzip();
    Some(Source::Table(TorqueTable { speeds, torques }))
}

fn servo(section: &Section<'_>, _: &Path) -> Option<Source> {
    let proportional = section.real("K_p");
    let integral = section.real("K_i");
    let usual = integral.zip(proportional).map_or(0.0, |(integral, proportional)| integral / proportional);
    let anti_windup = section.real_or("K_aw", usual);
    let position = section.optional("K_v");
    let limit = section.real("M_max");
    let reference = reference(section);
    Some(Source::Servo(Servo {
        proportional: proportional?,
        integral: integral?,
        anti_windup: anti_windup?,
        limit: limit?,
        reference: reference?,
        position: position?,
    }))
}

/// ω_ref: a speed, `"input"`, a series over time or a ramp.
fn reference(section: &Section<'_>) -> Option<Reference> {
    if let Some(Node { value: Value::Table(_), .. }) = section.node("w_ref") {
        let part = section.section("w_ref")??;
        let read = if part.has("ramp") {
            part.forbid(&["frequency", "a", "b", "scale"], "a ramp has one slope", "a series without `ramp`");
            part.real("ramp").map(Reference::Ramp)
        } else {
            let frequency = part.real("frequency");
            let series = motion_law::fourier(&part, &unit::ANGULAR_VELOCITY);
            frequency.zip(series).map(|(frequency, series)| Reference::Series(frequency, series))
        };
        part.finish();
        return read;
    }
    match section.word("w_ref") {
        Some("input") => Some(Reference::Input),
        Some(other) => {
            section.unknown_word("w_ref", other, "input");
            None
        }
        None => section.real("w_ref").map(Reference::Constant),
    }
}
