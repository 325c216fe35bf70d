//! Motion plans, `[[cam.point]]`, with the names of laws and keys that they share with the other motion laws.

use super::section::{ANY, Section, within};
use super::table::largest;
use camdrive::drives::unit::{self, Quantity};
use camdrive::motion::plan::{INFLECTION, SegmentLaw};
use camdrive::motion::table::CLOSING;
use camdrive::motion::{MotionLaw, MotionPlan, PlanPoint, StandardLaw};
use std::f64::consts::TAU;

/// The normalised laws with the names that are in use for them.
pub const STANDARD_LAWS: &[(&[&str], StandardLaw)] = &[
    (&["simple_sine", "harmonic", "simple_harmonic"], StandardLaw::SimpleSine),
    (&["inclined_sine", "bestehorn", "bestehorn_sine", "cycloidal"], StandardLaw::InclinedSine),
    (&["polynomial_345", "poly345", "3-4-5", "polynomial_5"], StandardLaw::Polynomial345),
    (&["polynomial_4567", "poly4567", "4-5-6-7", "polynomial_7"], StandardLaw::Polynomial4567),
    (&["modified_sine", "modsine"], StandardLaw::ModifiedSine),
    (&["modified_trapezoid", "modtrap", "modified_trapezoidal"], StandardLaw::ModifiedTrapezoid),
];

/// Synonyms of the keys.
pub const SYNONYMS: &[(&str, &str)] = &[
    ("cos", "a"),
    ("sin", "b"),
    ("type", "law"),
    ("kind", "law"),
    ("lift", "stroke"),
    ("dwell", "upper_dwell"),
    ("path", "file"),
    ("csv", "file"),
    ("points", "point"),
    ("angle", "phi"),
    ("u", "U"),
    ("velocity", "dU"),
    ("acceleration", "ddU"),
    ("jerk", "dddU"),
    ("lambda", "inflection"),
];

/// The value of `ddU` where the laws beside a turning point decide it.
const FREE: &str = "free";

/// The laws of a segment beside the standard ones.
const SEGMENT_LAWS: &[(&[&str], SegmentLaw)] = &[
    (&["polynomial_6"], SegmentLaw::Polynomial6),
    (&["sine"], SegmentLaw::Sine),
    (&["cosines"], SegmentLaw::Cosines),
    (&["straight"], SegmentLaw::Straight),
];

/// The law of a section with `law = "plan"`.
pub fn read(section: &Section<'_>, quantity: &'static Quantity) -> Option<MotionLaw> {
    let sections = section.sections("point")?;
    let mut points = section.each("point", |part| point(part, quantity))?;
    if let [first, .., last] = &mut points[..]
        && (last.phi - first.phi - TAU).abs() <= CLOSING
    {
        // The law that leads to the last point closes the turn.
        let closing = PlanPoint { law: last.law, inflection: last.inflection, ..*first };
        if (PlanPoint { phi: first.phi, ..*last }) != closing || first.law.is_some() || first.inflection.is_some() {
            let place = &sections[sections.len() - 1];
            let message = " is the first point, one turn later, and differs from it";
            let hint = "repeat the values of the first point and give `law` and `inflection` here only, or leave this point out";
            return section.refuse(place.fault(message).hint(hint));
        }
        *first = closing;
        points.pop();
    }
    let plan = MotionPlan::new(points);
    if let Err(fault) = plan.validate() {
        let place = sections.get(fault.point).unwrap_or(section);
        // What is left out has a value, too, which nobody finds in the file.
        let told = match place.has(fault.key) {
            true => place.fault_of(fault.key, format!(": {}", fault.text)),
            false => place.fault(format!(" ({}): {}", fault.key, fault.text)),
        };
        return section.refuse(told);
    }
    Some(MotionLaw::Plan(plan))
}

fn point(section: &Section<'_>, quantity: &'static Quantity) -> Option<PlanPoint> {
    let phi = section.real("phi", &unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU));
    let u = section.real("U", quantity, within(-largest(quantity), largest(quantity)));
    let word = section.word("ddU");
    let [velocity, jerk] = [("dU", 1), ("dddU", 3)].map(|(key, n)| section.derivative(key, quantity, n, ANY));
    let acceleration = match word {
        Some(FREE) => Some(None),
        Some(other) => {
            section.unknown_word("ddU", other, FREE);
            None
        }
        None => section.derivative("ddU", quantity, 2, ANY),
    };
    let standard = STANDARD_LAWS.iter().map(|(names, law)| (*names, SegmentLaw::Standard(*law)));
    let laws: Vec<_> = standard.chain(SEGMENT_LAWS.iter().copied()).collect();
    let law = if section.has("law") { section.choice("law", &laws).map(Some) } else { Some(None) };
    let [least, greatest] = INFLECTION;
    let inflection = section.optional("inflection", &unit::NUMBER, within(least, greatest));
    section.finish(SYNONYMS);
    Some(PlanPoint {
        phi: phi?,
        u: u?,
        velocity: velocity?,
        acceleration: acceleration?,
        free: word.is_some(),
        jerk: jerk?,
        law: law?,
        inflection: inflection?,
    })
}
