//! Restrictions of the tools, evaluated on their motions in time.
//!
//! A task prescribes bounds, exact points and distances of dⁿyⱼ/dψⁿ, ψ = 2πt/T; the motions yⱼ(ψ) of a round are compared with
//! them. The cams of a round share one ψ(φ), so its tools take the prescribed positions relative to one another, at other
//! times: a distance over the whole turn is the same in all rounds, a condition on a range of ψ is not.
//!
//! Source: K. Kaltofen, "HS-Bewegungen trotz veränderlicher Antriebsgeschwindigkeit", section 2, step 8 and its remark.

use super::Tool;
use super::spectral::largest;
use crate::synthesis::clearance::Clearance;
use crate::synthesis::deviation::Extreme;
use crate::synthesis::study::Assignment;
use crate::synthesis::{Bound, ExactPoint};
use camdrive::motion::Fourier;
use serde::Serialize;

/// Conditions on the tools of a machine, each with its name; their laws are tools, from 0.
#[derive(Clone, Debug, Default)]
pub struct Restrictions {
    points: Vec<(String, ExactPoint)>,
    bounds: Vec<(String, Bound)>,
    clearances: Vec<(String, Clearance)>,
    /// The followers of tools without a law in the task.
    pub unasked: Vec<usize>,
    /// For each tool the number of its follower, and the tolerances of y and its first two derivatives, and of the third.
    tools: Vec<(usize, [f64; 2])>,
}

/// A restriction and its reserve.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RestrictionReserve {
    /// Its name in the task.
    pub name: String,
    /// n, the order of the derivative.
    pub order: usize,
    /// The followers, counted from 1, each with its factor in the bounded sum; with 1 in a distance.
    pub tools: Vec<(usize, f64)>,
    /// ψ (rad) of the least reserve.
    pub phase: f64,
    /// The restricted quantity there: the sum of derivatives (m/radⁿ or rad/radⁿ), or the distance (m).
    pub value: f64,
    /// The distance to its limit, negative beyond it; for an exact point the negative error.
    pub reserve: f64,
    /// True if the motion misses no more than the finite laws of the cams may.
    pub kept: bool,
}

impl Restrictions {
    /// The restrictions of a motion task, whose laws are the motions of the followers in their order, for tools whose
    /// acceleration may miss by the part `tolerance` of its largest value: an error of the k-th harmonic is k² times smaller in
    /// y, and k times larger in y‴.
    ///
    /// # Errors
    /// The number of a follower that has a law in the task and is no tool.
    pub fn of(assignment: &Assignment, tools: &[Tool], tolerance: f64) -> Result<Self, usize> {
        let (task, names) = (&assignment.task, &assignment.names);
        let tool = |law: usize| tools.iter().position(|tool| tool.number == law + 1).ok_or(law + 1);
        // Instead of law[1].point[1] and the like.
        let named = |name: &String, law: usize| match (names.laws.get(law), name.split_once('.')) {
            (Some(law), Some((_, rest))) => format!("{law}: {rest}"),
            _ => name.clone(),
        };
        let point = |(point, name): (&ExactPoint, &String)| {
            Ok::<_, usize>((named(name, point.law), ExactPoint { law: tool(point.law)?, ..*point }))
        };
        let bound = |(bound, name): (&Bound, &String)| {
            let of =
                bound.of.iter().map(|(law, factor)| Ok((tool(*law)?, *factor))).collect::<Result<Vec<_>, usize>>()?;
            let name = if let [(law, _)] = bound.of[..] { named(name, law) } else { name.clone() };
            Ok::<_, usize>((name, Bound { of, ..bound.clone() }))
        };
        let clearance = |clearance: &Clearance| {
            let [a, b] = clearance.laws;
            let name = [a, b].map(|law| names.laws.get(law).map_or("", String::as_str)).join(" and ");
            Ok::<_, usize>((format!("distance of {name}"), Clearance { laws: [tool(a)?, tool(b)?], ..*clearance }))
        };
        let allowed = |Tool { number, wanted, .. }: &Tool| {
            let order = wanted.order();
            let miss = tolerance * largest(order, |psi| wanted.at(psi).0[2])[1];
            (*number, [miss, order as f64 * miss])
        };
        let laws = task.laws.len();
        Ok(Restrictions {
            unasked: tools.iter().map(|tool| tool.number).filter(|number| *number > laws).collect(),
            points: task.points.iter().zip(&names.points).map(point).collect::<Result<_, _>>()?,
            bounds: task.bounds.iter().zip(&names.bounds).map(bound).collect::<Result<_, _>>()?,
            clearances: task.clearances.iter().map(clearance).collect::<Result<_, _>>()?,
            tools: tools.iter().map(allowed).collect(),
        })
    }

    /// The reserves of these motions of the tools.
    pub fn kept(&self, motions: &[Fourier]) -> Vec<RestrictionReserve> {
        let kept = |name: &str, of: &[(usize, f64)], order: usize, phase: f64, value: f64, reserve: f64| {
            let miss: f64 = of.iter().map(|(j, factor)| factor.abs() * self.tools[*j].1[order / 3]).sum();
            let tools = of.iter().map(|(j, factor)| (self.tools[*j].0, *factor)).collect();
            RestrictionReserve { name: name.to_owned(), order, tools, phase, value, reserve, kept: reserve >= -miss }
        };
        let point = |(name, point): &(String, ExactPoint)| {
            let value = motions[point.law].at(point.phi).0[point.order];
            kept(name, &[(point.law, 1.0)], point.order, point.phi, value, -(value - point.value).abs())
        };
        let bound = |(name, bound): &(String, Bound)| {
            let Extreme { value: reserve, phi } = bound.reserve(motions);
            let value = bound.of.iter().map(|(j, factor)| factor * motions[*j].at(phi).0[bound.order]).sum();
            kept(name, &bound.of, bound.order, phi, value, reserve)
        };
        let clearance = |(name, clearance): &(String, Clearance)| {
            let Extreme { value, phi } = clearance.least(&clearance.laws.map(|j| motions[j].clone()));
            kept(name, &clearance.laws.map(|j| (j, 1.0)), 0, phi, value, value - clearance.distance)
        };
        let linear = self.points.iter().map(point).chain(self.bounds.iter().map(bound));
        linear.chain(self.clearances.iter().map(clearance)).collect()
    }

    /// Each pair of tools that keeps clear, with its name.
    pub fn clearances(&self) -> &[(String, Clearance)] {
        &self.clearances
    }
}
