//! Motion plans, `[[cam.point]]`, with the names of laws and keys that other motion laws use as well.

use crate::document::{Section, keys::FREE};
use camdrive::motion::plan::SegmentLaw;
use camdrive::motion::table::CLOSING;
use camdrive::motion::{MotionLaw, MotionPlan, PlanPoint, StandardLaw};
use std::f64::consts::TAU;

/// The normalised laws with their usual names.
pub const STANDARD_LAWS: &[(&str, StandardLaw)] = &[
    ("simple_sine", StandardLaw::SimpleSine),
    ("inclined_sine", StandardLaw::InclinedSine),
    ("polynomial_345", StandardLaw::Polynomial345),
    ("polynomial_4567", StandardLaw::Polynomial4567),
    ("modified_sine", StandardLaw::ModifiedSine),
    ("modified_trapezoid", StandardLaw::ModifiedTrapezoid),
];

/// The laws of a segment in addition to the standard ones.
const SEGMENT_LAWS: &[(&str, SegmentLaw)] = &[
    ("polynomial_6", SegmentLaw::Polynomial6),
    ("sine", SegmentLaw::Sine),
    ("cosines", SegmentLaw::Cosines),
    ("straight", SegmentLaw::Straight),
];

/// The laws of a segment with their names.
pub fn laws() -> Vec<(&'static str, SegmentLaw)> {
    let standard = STANDARD_LAWS.iter().map(|(names, law)| (*names, SegmentLaw::Standard(*law)));
    standard.chain(SEGMENT_LAWS.iter().copied()).collect()
}

/// The law of a section with `law = "plan"`.
pub fn read(section: &Section<'_>) -> Option<MotionLaw> {
    let sections = section.sections("point")?;
    let mut points = section.each("point", point)?;
    if let [first, .., last] = &mut points[..]
        && (last.phi - first.phi - TAU).abs() <= CLOSING
    {
        // The law of the last point closes the turn.
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
        // A missing key has a default, which is not in the file.
        let told = match place.has(fault.key) {
            true => place.fault_of(fault.key, format!(": {}", fault.text)),
            false => place.fault(format!(" ({}): {}", fault.key, fault.text)),
        };
        return section.refuse(told);
    }
    Some(MotionLaw::Plan(plan))
}

fn point(section: &Section<'_>) -> Option<PlanPoint> {
    let [phi, u] = ["phi", "U"].map(|key| section.real(key));
    let word = section.word("ddU");
    let [velocity, jerk, inflection] = ["dU", "dddU", "inflection"].map(|key| section.optional(key));
    let acceleration = match word {
        Some(FREE) => Some(None),
        Some(other) => {
            section.unknown_word("ddU", other, FREE);
            None
        }
        None => section.optional("ddU"),
    };
    let law = if section.has("law") { section.choice("law", &laws()).map(Some) } else { Some(None) };
    section.finish();
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
