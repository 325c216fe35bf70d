//! Motion plans: `[[cam.point]]`.

use super::motion_law::{STANDARD_LAWS, SYNONYMS};
use super::section::{ANY, Section, within};
use camdrive::drives::unit::{self, Quantity};
use camdrive::motion::cycle::CyclePlan;
use camdrive::motion::plan::{INFLECTION, SegmentLaw};
use camdrive::motion::{MotionLaw, MotionPlan, PlanPoint};
use std::f64::consts::TAU;
use toml::de::DeValue;

/// A last point this near one turn after the first (rad) closes the plan: angles are written with some five digits.
const CLOSING: f64 = 1e-4;

/// The value of `ddU` where the laws beside a turning point decide it.
const FREE: &str = "free";

/// The laws of a segment beside the standard ones.
const SEGMENT_LAWS: &[(&[&str], SegmentLaw)] = &[
    (&["polynomial_6"], SegmentLaw::Polynomial6),
    (&["sine"], SegmentLaw::Sine),
    (&["straight"], SegmentLaw::Straight),
];

/// The law of a section with `law = "plan"`.
pub fn read(section: &Section<'_>, quantity: &'static Quantity) -> Option<MotionLaw> {
    let sections = section.sections("point")?;
    let mut points = sections
        .iter()
        .map(|part| point(part, quantity))
        .collect::<Vec<_>>()
        .into_iter()
        .collect::<Option<Vec<_>>>()?;
    if let [first, .., last] = &mut points[..]
        && (last.phi - first.phi - TAU).abs() <= CLOSING
    {
        if last.u != first.u {
            let fault = sections[sections.len() - 1]
                .fault_of("U", "the last point is the first one, one turn later, with another U");
            section
                .faults
                .report(fault.admissible(format!("{}", first.u)).hint("leave the last point out, or repeat the first"));
            return None;
        }
        // The law that leads to it closes the turn.
        (first.law, first.inflection) = (last.law, last.inflection);
        points.pop();
    }
    let plan = MotionPlan::new(points);
    if let Err(fault) = plan.validate() {
        let place = sections.get(fault.point).unwrap_or(section);
        section
            .faults
            .report(place.fault_of(fault.key, format!("`{}.{fault}`", section.path).replacen(": ", "`: ", 1)));
        return None;
    }
    Some(MotionLaw::Plan(plan))
}

fn point(section: &Section<'_>, quantity: &'static Quantity) -> Option<PlanPoint> {
    let phi = section.real("phi", &unit::ANGLE, within(-2.0 * TAU, 2.0 * TAU));
    let u = section.real("U", quantity, within(-CyclePlan::MAX_LENGTH, CyclePlan::MAX_LENGTH));
    let free = section.node("ddU").is_some_and(|node| matches!(node.value, DeValue::String(text) if text == FREE));
    let [velocity, jerk] = [("dU", 1), ("dddU", 3)].map(|(key, n)| section.derivative(key, quantity, n, ANY));
    let acceleration = if free { Some(None) } else { section.derivative("ddU", quantity, 2, ANY) };
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
        free,
        jerk: jerk?,
        law: law?,
        inflection: inflection?,
    })
}
