//! Remarks of the report of a synthesis beside its tables: limits of the task and of the numbers, elasticity, and why a task
//! has no profile.

use super::elastic::{SpeedRange, deviation};
use super::sampling::ANGLES;
use super::study::{Method, Names, Study};
use super::{Bound, Infeasible, Objective, Response, Task};
use crate::text::number;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A deviation of more than this part of the motion is none any more.
const FAILED_TASK: f64 = 0.1;

/// An exact point within this angle of an axis of the symmetry, but not on it, is implausible (rad).
const BESIDE: f64 = 1e-4;

impl Study {
    /// Remarks on what the task or the numbers leave open.
    pub(super) fn limits(&self) -> Vec<String> {
        let (task, motion) = (&self.assignment.task, &self.motion);
        let mut lines = Vec::new();
        if motion.undetermined > 0 {
            let all = task.basis.size();
            lines.push(format!(
                "warning: what is prescribed determines {} of {all} coefficients; the other {} are free, and \
                 where only points count the least ∫U″² dφ determines them: take more `points`, fewer harmonics or more symmetry",
                all - motion.undetermined,
                motion.undetermined
            ));
        }
        let highest = task.basis.order().max(1) as f64;
        for (point, name) in task.points.iter().zip(&self.assignment.names.points) {
            let row = task.basis.row(point.law, point.phi, point.order, None);
            let size = row.iter().fold(0.0_f64, |size, value| size.max(value.hi.abs()));
            if (ANGLES..BESIDE).contains(&(size / highest.powi(point.order as i32 + 1))) {
                let axis = degrees((point.phi / FRAC_PI_2).round() * FRAC_PI_2);
                lines.push(format!(
                    "warning: the symmetry alone decides U{} at {axis}°; `{name}`, close to it, prescribes the next \
                     derivative there: if the axis is meant, write \"{axis} deg\"",
                    "′".repeat(point.order)
                ));
            }
        }
        let largest = motion.series.a.iter().chain(&motion.series.b).fold(0.0_f64, |largest, c| c.abs().max(largest));
        let rounding = f64::EPSILON * largest;
        let errors =
            !matches!(task.objective, Objective::PeakAcceleration | Objective::PeakTorque | Objective::ShaftTorque(_));
        let left = task.largest_error(&motion.series);
        if errors && !task.ranges.is_empty() && left < 4.0 * rounding {
            lines.push(format!(
                "The error is below rounding: coefficients of sixteen digits leave {}. Fewer harmonics are enough, or make \
                 the `peak_acceleration` small within a `tolerance`.",
                self.length(left)
            ));
        }
        // Each coefficient brings its rounding, enlarged by its order in U′ and once more in U″.
        if motion.excess > task.basis.size() as f64 * highest.powi(2) * rounding {
            lines.push(format!(
                "warning: conditions are kept to {}: their extremes are too flat or too close together for more digits.",
                self.length(motion.excess)
            ));
        }
        if errors && motion.uncertainty > rounding {
            let size = self.length(motion.uncertainty);
            lines.push(format!(
                "The coefficients are known to {size}: such changes alter the error by less than {}, the rounding of numbers \
                 of thirty digits.",
                self.length(motion.resolution)
            ));
        }
        lines
    }

    /// Remarks on the elastic output member.
    pub(super) fn of_elasticity(&self) -> Vec<String> {
        let (Some(behind), Some(given)) = (&self.elastic, &self.assignment.elasticity) else { return Vec::new() };
        let rpm = |eta: f64| format!("η = {eta:.4} ({} rpm)", number(eta * given.w0 * 60.0 / TAU));
        let mut lines = vec![String::new()];
        match given.method {
            Method::Robust => {
                lines.push("The cam is robust: its largest deviation over all speeds is minimal.".to_owned())
            }
            Method::Recipe => {
                let optimum = behind.optimum.map_or(String::new(), rpm);
                lines.push(format!("The cam is the motion inverted with damping at {optimum}."));
            }
            Method::None => lines.push("The cam is the motion itself.".to_owned()),
        }
        let damped = given.damping > 0.0;
        if given.method == Method::Robust && damped && self.assignment.task.basis.is_even() {
            lines.push(
                "hint: `symmetry` is that of the cam. Behind a damped member the motion of an even cam lags and is not even; \
                 `half_wave` instead of `even_half_wave` (`none` instead of `even`) lets the cam lead and may reach further."
                    .to_owned(),
            );
        }
        let fastest = given.fastest.map(|w| w / given.w0).or(behind.reached);
        let crossed =
            fastest.map(|fastest| SpeedRange { fastest, ..given.range() }.crossed(&self.assignment.task.basis));
        let crossed = crossed.unwrap_or_default();
        if !crossed.is_empty() && given.method == Method::Robust {
            let list: Vec<String> = crossed.iter().map(|k| format!("k = {k} at {}", rpm(1.0 / *k as f64))).collect();
            let so = match damped {
                true => "only damping limits them, and the cam does without most of these harmonics",
                false => "there is no damping, so that the cam does without these harmonics",
            };
            lines.push(format!("warning: the speeds cross resonances kη = 1, {}: {so}", list.join(", ")));
        }
        if let Some(worst) = behind.worst.filter(|worst| *worst > FAILED_TASK * self.way()) {
            let (worst, way) = (self.length(worst), self.length(self.way()));
            lines.push(format!(
                "warning: over these speeds the output deviates by up to {worst} from what is prescribed, which spans {way}: this is \
                 not the motion of the task; lower `fastest`"
            ));
        }
        if let (Some(worst), Some(fastest)) = (behind.worst, given.fastest) {
            let slowest = rpm(given.slowest / given.w0);
            let fastest = rpm(fastest / given.w0);
            lines.push(format!("From {slowest} to {fastest} the deviation is at most {}.", self.length(worst)));
        }
        if let Some(tolerance) = given.tolerance {
            let tolerance = self.length(tolerance);
            lines.push(match behind.reached {
                Some(eta) => format!("It stays within {tolerance} up to {}.", rpm(rounded_down(eta))),
                None => {
                    let slow = Response { damping: given.damping, eta: given.slowest / given.w0 };
                    let deviation = self.length(deviation(&self.assignment.task, &self.cam, slow));
                    format!(
                        "warning: `elasticity.tolerance` of {tolerance} cannot be kept: at the slowest speed the \
                         deviation is {deviation}; take more harmonics, shorter ranges or a wider tolerance"
                    )
                }
            });
        }
        lines
    }

    /// Between which U the ranges prescribe.
    fn way(&self) -> f64 {
        let values = self.assignment.task.ranges.iter().flat_map(|range| {
            let target = range.prescribed[0].as_ref();
            target.into_iter().flat_map(|target| [0.0, range.to - range.from].map(|x| target.at(x)))
        });
        let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], u| [a.min(u), b.max(u)]);
        (high - low).max(0.0)
    }
}

/// A speed ratio that is reached, to four places: rounded up, it would be beyond.
pub(super) fn rounded_down(eta: f64) -> f64 {
    (eta * 1e4).floor() / 1e4
}

/// An angle to a ten-thousandth of a degree.
pub(super) fn degrees(phi: f64) -> String {
    ((phi.to_degrees() * 1e4).round() / 1e4 + 0.0).to_string()
}

/// Units of the errors of U⁽ⁿ⁾.
pub const UNITS: [&str; 4] = ["m", "m/rad", "m/rad²", "m/rad³"];

impl Infeasible {
    /// Which condition of the task cannot be met, and by how much.
    pub fn words(&self, task: &Task, names: &Names) -> String {
        let name = |list: &[String], index: usize| list.get(index).map_or(String::new(), |name| format!("`{name}`: "));
        let off = |order: usize, by: f64| format!("{} {}", number(by), UNITS[order.min(3)]);
        match self {
            Infeasible::Point { index, by } => {
                let point = &task.points[*index];
                format!(
                    "{}the exact points cannot all be met with these harmonics: at best {} misses {} by {}\n  \
                     = hint: take more harmonics or less symmetry, or remove points that contradict each other",
                    name(&names.points, *index),
                    place(DERIVATIVES[point.order.min(3)], point.phi),
                    number(point.value),
                    off(point.order, *by)
                )
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
                format!(
                    "{}bounds and tolerances cannot all be kept with these harmonics: even if all are widened alike, {} \
                     must leave {} by {}\
                     {against}\n  = hint: take more harmonics, widen the bounds or shorten the ranges",
                    name(&names.bounds, *index),
                    DERIVATIVES[bound.order.min(3)].replace('U', if bound.of.len() > 1 { "Σ αⱼUⱼ" } else { "U" }),
                    limits(bound),
                    place(&(off(bound.order, *by) + ","), *phi)
                )
            }
            Infeasible::Integral { least } => format!(
                "`integral_tolerance`: {} m²·rad cannot be kept: with these harmonics and the other conditions the integral is at \
                 least {} m²·rad\n  = hint: take more harmonics, shorter ranges or a larger `integral_tolerance`",
                number(task.integral.unwrap_or(0.0)),
                number(*least)
            ),
            Infeasible::Outside { point, bound, by } => {
                let (point_of, bound_of) = (&task.points[*point], &task.bounds[*bound]);
                let known = names.bounds.get(*bound).map_or_else(String::new, |n| format!(" of `{n}`"));
                format!(
                    "{}{} lies beyond {}{known} by {}: no profile keeps both\n  = hint: widen the \
                     bound by this, move the point or let the bound end before it",
                    name(&names.points, *point),
                    place(
                        &format!("{} = {}", DERIVATIVES[point_of.order.min(3)], number(point_of.value)),
                        point_of.phi
                    ),
                    limits(bound_of),
                    off(point_of.order, *by)
                )
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
                format!(
                    "no motion: the best profile for `{}` rests at U = {} m all the turn\n  = hint: prescribe different U; with \
                     `even` those at φ and −φ are equal, with `half_wave` equal ones half a turn apart are the mean a₀",
                    sections.join("`, `"),
                    number(*at)
                )
            }
            Infeasible::Numerical(text) => text.clone(),
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
