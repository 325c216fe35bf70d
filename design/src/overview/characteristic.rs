//! The angles at which a plan jumps or overshoots.

use super::{Overview, Warning};
use crate::law_motions::{motions, shown};
use camdrive::motion::{MotionLaw, MotionPlan};
use serde::Serialize;
use std::f64::consts::TAU;

/// Changes below this part of the largest |U″| are rounding, no jumps.
const NO_JUMP: f64 = 1e-9;

/// A jump of a derivative between two segments of a plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Jump {
    /// The section of its law.
    pub law: String,
    /// Angle (rad).
    pub phi: f64,
    /// 2 for U″, 3 for U‴.
    pub derivative: usize,
    /// Size of the jump.
    pub size: f64,
    /// Its unit.
    pub unit: &'static str,
}

impl Jump {
    /// The text for a terminal.
    pub fn text(&self) -> String {
        let name = ["U″", "U‴"][self.derivative - 2];
        format!("{name} jumps by {} at {}", shown(self.size, self.unit), shown(self.phi, "rad"))
    }
}

impl Overview {
    /// Adds the motions of the law, and the implausible parts of a plan.
    pub(super) fn motions(&mut self, section: &str, law: &MotionLaw, unit: &'static str) {
        self.motions.extend(motions(section, law, unit));
        if let MotionLaw::Plan(plan) = law {
            self.jumps(section, plan, law, unit);
            self.overshoots(section, plan, law, unit);
        }
    }

    /// Lists the jumps of U″ and U‴ between segments, and warns of U″'s.
    fn jumps(&mut self, section: &str, plan: &MotionPlan, law: &MotionLaw, unit: &'static str) {
        let units = if unit == "rad" { ["1/rad", "1/rad2"] } else { ["m/rad2", "m/rad3"] };
        for phi in plan.points().iter().map(|point| point.phi.rem_euclid(TAU)) {
            let [before, behind] = [false, true].map(|forward| law.at_in(law.segment(phi, forward), phi).0);
            for (derivative, unit) in (2..).zip(units) {
                let size = behind[derivative] - before[derivative];
                if size.abs() <= NO_JUMP * law.bound(derivative) {
                    continue;
                }
                let jump = Jump { law: section.to_owned(), phi, derivative, size, unit };
                if derivative == 2 {
                    self.warnings.push(Warning {
                        message: format!("{section}: {}", jump.text()),
                        hint: "leave out an inflection next to the point".to_owned(),
                    });
                }
                self.jumps.push(jump);
            }
        }
    }

    /// Warns if U leaves the range of the points at both ends of a segment.
    fn overshoots(&mut self, section: &str, plan: &MotionPlan, law: &MotionLaw, unit: &str) {
        const PARTS: usize = 500;
        let points = plan.points();
        for (i, to) in points.iter().enumerate() {
            let from = points[(i + points.len() - 1) % points.len()];
            let start = if i == 0 { from.phi - TAU } else { from.phi };
            let at = |k: usize| law.at((start + (to.phi - start) * k as f64 / PARTS as f64).rem_euclid(TAU)).0[0];
            let (low, high) = (from.u.min(to.u), from.u.max(to.u));
            let beyond = (1..PARTS).map(|k| (at(k) - high).max(low - at(k))).fold(0.0, f64::max);
            if beyond > NO_JUMP * law.bound(0) {
                self.warnings.push(Warning {
                    message: format!(
                        "{section}: the motion overshoots on the way to point[{}], by {}",
                        i + 1,
                        shown(beyond, unit)
                    ),
                    hint: "give the segment another law, inflection or angle, or lower dU or ddU at its ends"
                        .to_owned(),
                });
            }
        }
    }
}
