//! The laws of a task that are found together: their objective, and how they keep their restrictions and their distances.

use super::clearance::Clearance;
use super::deviation::Extreme;
use super::study::{Assignment, Method, Study};
use super::{Bound, Infeasible};
use crate::Progress;
use crate::plot::{Axis, Diagram, Rule, Series};
use crate::work;
use camdrive::motion::Fourier;
use std::f64::consts::TAU;

/// Solvers miss a bound that holds the optimum by less than this part of it.
const USED_UP: f64 = 1e-9;

/// Points of a curve over the turn.
const POINTS: usize = 721;

/// The result of a task.
#[derive(Clone, Debug, PartialEq)]
pub struct Together {
    /// The task of the user.
    pub assignment: Assignment,
    /// Each law.
    pub studies: Vec<Study>,
}

impl Together {
    /// The profiles of all laws of a task with all that is to be known of them.
    pub fn new(assignment: &Assignment, progress: &(dyn Fn(Progress) + Sync)) -> Result<Self, Infeasible> {
        let hint = "take fewer harmonics, laws or starts, say `fastest` instead of `tolerance` for an elastic member, or widen bounds";
        let studies = work::within(work::BUDGET, hint, progress, |tell| assignment.studies(tell));
        let studies = studies.map_err(Infeasible::Numerical)??;
        Ok(Together { assignment: assignment.clone(), studies })
    }

    /// Each bound and each restriction with its reserve; one that holds the optimum has none.
    pub(super) fn bounds(&self) -> Vec<(&str, &Bound, Extreme)> {
        let [first, others @ ..] = &self.studies[..] else { return Vec::new() };
        // The recipe keeps them by the motion behind the elastic member.
        let of_motion = self.assignment.elasticity.is_some_and(|given| given.method == Method::Recipe);
        let motion = |study: &Study| if of_motion { study.motion.series.clone() } else { study.cam.clone() };
        let motions: Vec<Fourier> = self.studies.iter().map(motion).collect();
        let task = if others.is_empty() { &first.assignment.task } else { &self.assignment.task };
        let named = self.assignment.names.bounds.iter().zip(&task.bounds);
        let kept = |bound: &Bound| {
            let reserve = bound.reserve(&motions);
            let used_up = reserve.value.abs() <= USED_UP * bound.size().max(task.scale());
            let value = if used_up { 0.0 } else { reserve.value };
            Extreme { value, ..reserve }
        };
        named.map(|(name, bound)| (name.as_str(), bound, kept(bound))).collect()
    }

    /// The motions of the two tools of a clearance.
    fn tools(&self, clearance: &Clearance) -> [Fourier; 2] {
        clearance.laws.map(|law| self.studies[law].cam.clone())
    }

    /// Each clearance with the least distance.
    pub(super) fn clearances(&self) -> impl Iterator<Item = (&Clearance, Extreme)> {
        self.assignment.task.clearances.iter().map(|clearance| (clearance, clearance.least(&self.tools(clearance))))
    }

    pub(super) fn name_of(&self, law: usize) -> &str {
        self.assignment.names.laws.get(law).map_or("", String::as_str)
    }

    /// The distances over the turn, where some are asked for.
    pub fn figure(&self) -> Option<Diagram> {
        let (mut series, mut rules) = (Vec::new(), Vec::new());
        for clearance in &self.assignment.task.clearances {
            let (tools, [a, b]) = (self.tools(clearance), clearance.laws.map(|law| self.name_of(law)));
            let points = (0..POINTS).map(|i| TAU * i as f64 / (POINTS - 1) as f64);
            let apart = |phi: f64| [phi.to_degrees(), clearance.apart(&tools, phi)];
            series.push(Series::line(format!("{a} and {b}"), points.map(apart)));
            rules.push(Rule::Horizontal(clearance.distance, "asked for".to_owned()));
        }
        let axes = [Axis::angular("Angle φ [°]"), Axis::linear("Distance [m]")];
        let title = format!("Distances of the tools of {} over the turn", self.assignment.name);
        (!series.is_empty()).then(|| Diagram::new(title, axes, series, rules))
    }
}
