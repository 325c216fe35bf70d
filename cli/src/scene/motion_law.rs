//! The motion law of a cam: `[cam]` and `[follower.cam]`.

use super::plan::{self, STANDARD_LAWS};
use super::table;
use super::table::Part;
use crate::document::{Section, units};
use camdrive::drives::unit::{self, Quantity};
use camdrive::motion::fourier::HIGHEST_HARMONIC;
use camdrive::motion::plan::LEAST_MOTION;
use camdrive::motion::table::CLOSING;
use camdrive::motion::{Cycle, CyclePlan, Fourier, MotionLaw, StandardLaw};
use std::f64::consts::TAU;
use std::path::Path;

/// Reads a kind of law.
pub type Reader = fn(&Section<'_>, &'static Quantity, &Path) -> Option<Result<MotionLaw, Part>>;

/// The kinds of laws.
pub const LAWS: &[(&str, Reader)] = &[
    ("fourier", |section, of, _| Some(Ok(MotionLaw::Fourier(fourier(section, of)?)))),
    ("cycle", |section, _, _| Some(Ok(MotionLaw::Cycle(cycle(section)?)))),
    ("table", table::read),
    ("plan", |section, _, _| plan::read(section).map(Ok)),
    ("contour", |section, _, _| {
        let fault =
            section.fault_of("law", ": a contour is the law of `[cam]` next to the `[geometry]` of its follower");
        section.refuse(fault.admissible("fourier, cycle, table, plan"))
    }),
];

/// The law in the `[cam]` of this section; `[geometry]` may stand next to it.
pub fn of_cam(parent: &Section<'_>, quantity: &'static Quantity, folder: &Path) -> Option<MotionLaw> {
    let section = parent.required_section("cam")?;
    if section.text("law") != Some(Some("contour")) {
        return read(&section, quantity, folder);
    }
    let law = table::contour::read(&section, parent, quantity, folder);
    section.finish();
    law
}

/// The law of this section; `quantity` is U's, a length if a cam moves a follower.
pub fn read(section: &Section<'_>, quantity: &'static Quantity, folder: &Path) -> Option<MotionLaw> {
    read_part(section, quantity, folder)?.or_else(|part| section.refuse(part.fault).ok_or(())).ok()
}

/// The law of this section, or the part of a law in a table.
pub fn read_part(section: &Section<'_>, quantity: &'static Quantity, folder: &Path) -> Option<Result<MotionLaw, Part>> {
    section.of(quantity, 0);
    let table: Reader = table::read;
    let read =
        if table::is_load(quantity) { section.choice_or("law", LAWS, table) } else { section.choice("law", LAWS) };
    let law = read.map(|read| read(section, quantity, folder));
    // The kind of law determines which keys belong here.
    if law.is_some() && section.text("law") != Some(Some("contour")) {
        section.finish();
    }
    law?
}

/// U = a₀ + Σ aₖ cos kφ + bₖ sin kφ.
pub fn fourier(section: &Section<'_>, quantity: &'static Quantity) -> Option<Fourier> {
    section.of(quantity, 0);
    let scale = section.optional("scale");
    section.of(if section.has("scale") { &unit::NUMBER } else { quantity }, 0);
    let (a, b) = (section.reals("a"), section.reals("b"));
    if !section.has("a") {
        let fault = section.fault_of("a", " is missing");
        return section
            .refuse(fault.admissible("a list of numbers").hint("add the cosine coefficients a = [a0, a1, …]"));
    }
    if scale == Some(Some(0.0)) {
        let fault = section.fault_of("scale", ": all values would be 0");
        section.faults.report(fault.admissible("a value other than 0"));
    }
    let (a, b, scale) = (a?, b?, scale?.unwrap_or(1.0));
    for (key, count, most) in [("a", a.len(), HIGHEST_HARMONIC + 1), ("b", b.len(), HIGHEST_HARMONIC)] {
        if count > most {
            let fault = section.fault_of(key, format!(" has {count} coefficients"));
            section.faults.report(fault.admissible(format!("at most {most}")));
        }
    }
    let scaled = |list: Vec<f64>| list.into_iter().map(|x| x * scale);
    Some(Fourier::new(scaled(a).collect(), std::iter::once(0.0).chain(scaled(b)).collect()))
}

/// Rise, upper dwell, return, lower dwell.
fn cycle(section: &Section<'_>) -> Option<Cycle> {
    let [stroke, lower, rise_start] = ["stroke", "lower", "rise_start"].map(|key| section.real(key));
    let angles = angles(section);
    // Marked as known first, so that it is not taken for a misspelt `rise_law`.
    section.has("return_law");
    let rise_law = section.choice("rise_law", STANDARD_LAWS);
    let return_law = section.choice_or("return_law", STANDARD_LAWS, rise_law.unwrap_or(StandardLaw::SimpleSine));
    let inflections = ["rise_inflection", "return_inflection"].map(|key| section.optional(key));
    let [rise_angle, upper_dwell, return_angle, _] = angles?;
    let plan = CyclePlan {
        stroke: stroke?,
        lower: lower?,
        rise_start: rise_start?,
        rise_angle,
        upper_dwell,
        return_angle,
        rise_law: rise_law?,
        return_law: return_law?,
        inflections: [inflections[0]?, inflections[1]?],
    };
    if let Err(error) = plan.validate() {
        return section.refuse(section.fault(format!(": {error}")));
    }
    Some(Cycle::new(plan))
}

/// The angles of rise, upper dwell, return and lower dwell (rad); a missing one is the rest of the turn.
fn angles(section: &Section<'_>) -> Option<[f64; 4]> {
    const KEYS: [(&str, f64); 4] =
        [("rise", LEAST_MOTION), ("upper_dwell", 0.0), ("return", LEAST_MOTION), ("lower_dwell", 0.0)];
    let given = KEYS.map(|(key, _)| section.optional(key));
    let missing: Vec<usize> = (0..4).filter(|&i| given[i] == Some(None)).collect();
    if let [_, second, ..] = missing[..] {
        let names: Vec<String> = missing.iter().map(|&i| format!("`{}`", KEYS[i].0)).collect();
        let fault = section.fault(format!(": {} are missing", names.join(", ")));
        let fault =
            fault.admissible("one of rise, upper_dwell, return, lower_dwell may be left out: the rest of the turn");
        let fault = fault.hint(format!("add for example {} = \"60 deg\"", KEYS[second].0));
        if !section.faults.broken() {
            section.faults.report(fault);
        }
        return None;
    }
    let [rise, upper, back, lower] = given;
    let mut angles = [rise?, upper?, back?, lower?].map(|angle| angle.unwrap_or(0.0));
    let rest = TAU - angles.iter().sum::<f64>();
    let deg = |angle: f64| units::short(angle.to_degrees());
    let fault = match missing[..] {
        // Three angles of a full turn, converted from degrees, may exceed it by some rounding errors.
        [i] if rest >= KEYS[i].1 - 1e-12 => {
            angles[i] = rest.max(KEYS[i].1);
            return Some(angles);
        }
        // Angles have some five digits; the lower dwell takes up the difference.
        [] if rest.abs() <= CLOSING => return Some(angles),
        [i] => {
            let others: Vec<&str> = (0..4).filter(|j| *j != i).map(|j| KEYS[j].0).collect();
            let last = if i == 3 { "return" } else { "lower_dwell" };
            let message = format!(": {} make {} deg", others.join(", "), deg(TAU - rest));
            let least = format!("at most {} deg, so that `{}` has room", deg(TAU - KEYS[i].1), KEYS[i].0);
            section.fault_at(last, message).of(&section.path).admissible(least)
        }
        _ => {
            let message = format!(": the four angles make {} deg", deg(TAU - rest));
            section.fault_at("lower_dwell", message).of(&section.path).admissible("360 deg")
        }
    };
    section.refuse(fault.hint("leave one of the four angles out: it is the rest of the turn"))
}

/// Values in the middle of equal steps around the turn. Their mean is exact for a series of up to 2048 harmonics; the mean of their
/// squares has an error of 1e-7 for a law with corners in U″.
fn samples(law: &MotionLaw, order: usize) -> impl Iterator<Item = f64> + '_ {
    (0..SAMPLES).map(move |i| law.at((i as f64 + 0.5) * TAU / SAMPLES as f64).0[order])
}

const SAMPLES: usize = 4096;

/// The mean of U′² over the turn (m²/rad²).
pub fn mean_square_slope(law: &MotionLaw) -> f64 {
    samples(law, 1).map(|slope| slope.powi(2)).sum::<f64>() / SAMPLES as f64
}

/// The least value of a law; the ends of its pieces include the ends of straight lines.
pub fn least(law: &MotionLaw) -> f64 {
    let ends = law
        .breakpoints()
        .iter()
        .flat_map(|&phi| [true, false].map(|forward| law.at_in(law.segment(phi, forward), phi).0[0]));
    samples(law, 0).chain(ends).fold(f64::INFINITY, f64::min)
}
