//! The laws of a task that are found together: what they cost, and how they keep their restrictions and their distances.

use super::clearance::Clearance;
use super::deviation::Extreme;
use super::feasibility::KEPT;
use super::remarks::{UNITS, degrees};
use super::study::{Assignment, Study};
use super::table::{LEVELS, words};
use super::{Bound, Infeasible};
use crate::Progress;
use crate::plot::{Axis, Diagram, Rule, Series};
use crate::text::{self, Page, Table, number};
use crate::work;
use camdrive::drives::Fault;
use camdrive::motion::Fourier;
use serde_json::{Value, json};
use std::f64::consts::TAU;

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

    fn motions(&self) -> Vec<Fourier> {
        self.studies.iter().map(|study| study.cam.clone()).collect()
    }

    /// Each restriction of several laws with its reserve.
    fn restrictions(&self) -> Vec<(&str, &Bound, Extreme)> {
        let (motions, given) = (self.motions(), &self.assignment);
        let named = given.task.bounds.iter().zip(&given.names.bounds).filter(|(bound, _)| bound.of.len() > 1);
        named.map(|(bound, name)| (name.as_str(), bound, bound.reserve(&motions))).collect()
    }

    /// The motions of the two tools of a clearance.
    fn tools(&self, clearance: &Clearance) -> [Fourier; 2] {
        clearance.laws.map(|law| self.studies[law].cam.clone())
    }

    /// Each clearance with the least distance.
    fn clearances(&self) -> impl Iterator<Item = (&Clearance, Extreme)> {
        self.assignment.task.clearances.iter().map(|clearance| (clearance, clearance.least(&self.tools(clearance))))
    }

    fn name_of(&self, law: usize) -> &str {
        self.assignment.names.laws.get(law).map_or("", String::as_str)
    }

    /// The report; its tables for lines of `width` characters.
    pub fn text(&self, width: usize) -> String {
        let [first, others @ ..] = &self.studies[..] else { return String::new() };
        if others.is_empty() {
            return first.text(width);
        }
        let mut page = Page::new(&self.assignment.name, width);
        let kind = words(&self.assignment.task);
        page.lines(first.answer()).lines([format!(
            "Objective {kind} of {} laws: {}.",
            self.studies.len(),
            first.objective_value()
        )]);
        page.table(LEVELS, &first.levels());
        let restrictions = self.restrictions().into_iter().map(|(name, bound, reserve)| {
            let angles = [bound.from, bound.to].map(degrees);
            // A bound that holds the optimum is reached but for roundings.
            let size =
                [bound.min, bound.max].into_iter().filter(|end| end.is_finite()).fold(0.0, |a: f64, b| a.max(b.abs()));
            let room = if reserve.value.abs() <= KEPT * size { 0.0 } else { reserve.value };
            let room = match bound.order {
                0 => first.length(room),
                order => format!("{} {}", number(room), UNITS[order]),
            };
            [&[name.to_owned()], &angles[..], &[room, degrees(reserve.phi)]].concat()
        });
        page.table("Restrictions", &Table::new("restriction  from [deg]  to [deg]  reserve  at [deg]", restrictions));
        let clearances = self.clearances().map(|(clearance, least)| {
            let [a, b] = clearance.laws.map(|law| self.name_of(law).to_owned());
            let lengths = [clearance.distance, least.value].map(|d| first.length(d));
            [&[a, b], &lengths[..], &[degrees(least.phi)]].concat()
        });
        let head = "tool  and tool  distance asked for  least distance  at [deg]";
        page.table("Distances over the turn", &Table::new(head, clearances));
        let laws = self.studies.iter().map(|study| study.text(width));
        std::iter::once(page.text()).chain(laws).collect::<Vec<_>>().join("\n")
    }

    /// The result as JSON, in SI.
    ///
    /// # Errors
    /// None in practice: all keys are texts.
    pub fn json(&self) -> Result<String, Fault> {
        let [first, others @ ..] = &self.studies[..] else { return text::json(&Value::Null) };
        if others.is_empty() {
            return text::json(&first.value());
        }
        let kept = |(name, _, reserve): (&str, &Bound, Extreme)| json!({ "name": name, "reserve": reserve.value, "phi": reserve.phi });
        let clear = |(clearance, least): (&Clearance, Extreme)| {
            let laws = clearance.laws.map(|law| self.name_of(law));
            json!({ "laws": laws, "distance": clearance.distance, "least_distance": least.value, "phi": least.phi })
        };
        text::json(&json!({
            "name": self.assignment.name,
            "objective": { "kind": words(&self.assignment.task), "value": first.motion.objective },
            "restrictions": self.restrictions().into_iter().map(kept).collect::<Vec<_>>(),
            "clearances": self.clearances().map(clear).collect::<Vec<_>>(),
            "laws": self.studies.iter().map(Study::value).collect::<Vec<_>>(),
        }))
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
