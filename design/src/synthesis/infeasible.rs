//! Why a task has no profile, in words.

use super::study::Names;
use super::{Bound, Infeasible, Task};
use crate::text::number;
use camdrive::drives::Fault;

/// An angle to a ten-thousandth of a degree.
pub(super) fn degrees(phi: f64) -> String {
    ((phi.to_degrees() * 1e4).round() / 1e4 + 0.0).to_string()
}

/// Units of the errors of U⁽ⁿ⁾.
pub const UNITS: [&str; 4] = ["m", "m/rad", "m/rad²", "m/rad³"];

impl Infeasible {
    /// Which condition of the task cannot be met, and by how much.
    pub fn fault(&self, task: &Task, names: &Names) -> Fault {
        let name = |list: &[String], index: usize| list.get(index).map_or(String::new(), |name| format!("`{name}`: "));
        let off = |order: usize, by: f64| format!("{} {}", number(by), UNITS[order.min(3)]);
        match self {
            Infeasible::Point { index, by } => {
                let point = &task.points[*index];
                Fault::new(format!(
                    "{}the exact points cannot all be met with these harmonics: at best {} misses {} by {}",
                    name(&names.points, *index),
                    place(DERIVATIVES[point.order.min(3)], point.phi),
                    number(point.value),
                    off(point.order, *by)
                ))
                .hint("take more harmonics or less symmetry, or remove points that contradict each other")
            }
            Infeasible::Bound { index, by, phi, others, points } => {
                let bound = &task.bounds[*index];
                let known = |i: usize| names.bounds.get(i).map_or(format!("bound {}", i + 1), |n| format!("`{n}`"));
                let others = others.iter().map(|(i, phi)| place(&known(*i), *phi));
                let against: Vec<String> = others.chain(points.then(|| "the exact points".to_owned())).collect();
                let against = match against.len() {
                    0 => String::new(),
                    _ => format!("\n  = it contradicts {}; the others can be kept", against.join(", ")),
                };
                Fault::new(format!(
                    "{}bounds and tolerances cannot all be kept with these harmonics: even if all are widened alike, {} \
                     must leave {} by {}{against}",
                    name(&names.bounds, *index),
                    DERIVATIVES[bound.order.min(3)].replace('U', if bound.of.len() > 1 { "Σ αⱼUⱼ" } else { "U" }),
                    limits(bound),
                    place(&(off(bound.order, *by) + ","), *phi)
                ))
                .hint("take more harmonics, widen the bounds or shorten the ranges")
            }
            Infeasible::Integral { least } => Fault::new(format!(
                "`integral_tolerance`: {} m²·rad cannot be kept: with these harmonics and the other conditions the integral is at \
                 least {} m²·rad",
                number(task.integral.unwrap_or(0.0)),
                number(*least)
            ))
            .hint("take more harmonics, shorter ranges or a larger `integral_tolerance`"),
            Infeasible::Outside { point, bound, by } => {
                let (point_of, bound_of) = (&task.points[*point], &task.bounds[*bound]);
                let known = names.bounds.get(*bound).map_or_else(String::new, |n| format!(" of `{n}`"));
                Fault::new(format!(
                    "{}{} lies beyond {}{known} by {}: no profile keeps both",
                    name(&names.points, *point),
                    place(
                        &format!("{} = {}", DERIVATIVES[point_of.order.min(3)], number(point_of.value)),
                        point_of.phi
                    ),
                    limits(bound_of),
                    off(point_of.order, *by)
                ))
                .hint("widen the bound by this, move the point or let the bound end before it")
            }
            Infeasible::Still { at } => {
                // "dwell[1].tolerance" belongs to "dwell[1]".
                let all = names.ranges.iter().chain(&names.points).chain(&names.bounds);
                let mut sections: Vec<&str> = Vec::new();
                for section in all.filter_map(|name| name.split('.').next()) {
                    if !sections.contains(&section) {
                        sections.push(section);
                    }
                }
                let sections = sections.join("`, `");
                Fault::new(format!("no motion: the best profile for `{sections}` rests at U = {} m all the turn", number(*at)))
                    .hint(
                        "prescribe different U; with `even` those at φ and −φ are equal, with `half_wave` equal ones half a turn \
                         apart are the mean a₀",
                    )
            }
            Infeasible::Numerical(fault) => fault.clone(),
        }
    }
}

fn place(what: &str, phi: f64) -> String {
    format!("{what} at {} deg", degrees(phi))
}

/// Limits of a bound, and where it holds.
fn limits(bound: &Bound) -> String {
    let limits = match (bound.min.is_finite(), bound.max.is_finite()) {
        (true, true) => format!("{} to {}", number(bound.min), number(bound.max)),
        (true, false) => format!("the minimum {}", number(bound.min)),
        _ => format!("the maximum {}", number(bound.max)),
    };
    let around = if bound.around.is_zero() { "" } else { " around its target" };
    format!("{limits}{around} (from {} deg to {} deg)", degrees(bound.from), degrees(bound.to))
}

/// U and its derivatives.
const DERIVATIVES: [&str; 4] = ["U", "U′", "U″", "U‴"];
