//! Tools that keep clear of each other, by the convex–concave procedure.
//!
//! Whatever keeps the linear condition of a [`super::clearance`] about the last profiles keeps |d| ≥ r, and the last profiles
//! keep it too. So each step is admissible and no step is worse than the one before. Steps are short where the tools pass each
//! other closely: as long as that pays, v is taken ever farther ahead on the way that the profiles go. It ends at a local
//! optimum, which is looked for on both sides of the place where the tools would be nearest.
//!
//! Source: S. Boyd, L. Vandenberghe, *Convex Optimization*, 2004, section 4.1 (restriction of a condition by its
//! linearisation); T. Lipp, S. Boyd, "Variations and extension of the convex–concave procedure", Optim. Eng. 17 (2016)
//! 263–287.

use super::clearance::{Clearance, Tangent};
use super::conditions::Conditions;
use super::convex::{self, Optimum};
use super::family::Family;
use super::{Infeasible, Listener, Task};
use crate::text::number;
use camdrive::drives::Fault;
use camdrive::numerics::double_double::Double;
use std::f64::consts::TAU;

/// Linear programs on one side.
const STEPS: usize = 200;

/// The part of a distance that profiles may fall short of it by, between the angles of its conditions.
const KEPT: f64 = 1e-6;

/// A possible distance is looked for to a thirtieth of what is asked for.
const HALVINGS: usize = 5;

/// A step that gains less than this part of the objective is the last one.
const DONE: f64 = 1e-13;

/// Growth of the extrapolation from one accepted step to the next.
const GROWTH: f64 = 1.5;

/// A step that gains less than this part of the one before is near the end of the way.
const ENDING: f64 = 0.1;

/// The best profiles that keep clear.
pub fn clear(conditions: &Conditions, progress: Listener<'_>) -> Result<Optimum, Infeasible> {
    let task = conditions.task;
    let free = convex::optimum(conditions, Vec::new())?;
    if let Some(best) = beside(conditions, &free, f64::INFINITY, progress) {
        return Ok(best);
    }
    // All distances shrink alike; free profiles keep theirs.
    let mut between = [part_kept(conditions, &free.best.x), 1.0];
    for _ in 0..HALVINGS {
        let part = 0.5 * (between[0] + between[1]);
        let nearer = |clearance: &Clearance| Clearance { distance: part * clearance.distance, ..*clearance };
        let task = Task { clearances: task.clearances.iter().map(nearer).collect(), ..task.clone() };
        let nearer = Conditions { task: &task, ..*conditions };
        between[usize::from(beside(&nearer, &free, f64::NEG_INFINITY, &|_, _| {}).is_none())] = part;
    }
    let possible: Vec<String> =
        task.clearances.iter().map(|clearance| format!("{} m", number(between[0] * clearance.distance))).collect();
    let fault = Fault::new(format!(
        "the tools cannot keep clear of each other by the `clearance` together with the other conditions, on either side; \
         {} was found possible",
        possible.join(", ")
    ));
    Err(Infeasible::Numerical(fault.hint("take a smaller `distance`, more harmonics or wider bounds")))
}

/// The best of the profiles on both sides of where those without clearance would be nearest; any of them where `beaten` is
/// below all.
fn beside(conditions: &Conditions, free: &Optimum, beaten: f64, progress: Listener<'_>) -> Option<Optimum> {
    let mut best: Option<Optimum> = None;
    for side in 0..2 {
        let beaten = best.as_ref().map_or(beaten, |best| best.objective.min(beaten));
        if let Ok(found) = clear_on(conditions, side, &free.best.x, beaten)
            && part_kept(conditions, &found.best.x) >= 1.0 - KEPT
            && best.as_ref().is_none_or(|best| found.objective < best.objective)
        {
            best = Some(found);
        }
        progress(side + 1, 2);
    }
    best
}

/// The least part of its distance by which two tools are apart at every angle: its tangents decide only while
/// the sense of d stays.
fn part_kept(&Conditions { task, scale }: &Conditions, x: &[Double]) -> f64 {
    let part = |clearance: &Clearance| {
        let clearance = clearance.over(scale);
        let motions = clearance.laws.map(|law| task.basis.series(law, x, 1.0));
        clearance.least(&motions).value / clearance.distance
    };
    task.clearances.iter().map(part).fold(f64::INFINITY, f64::min)
}

/// The best profiles from those that do not keep clear, on their side (0) or past the other tool (1); ended where the steps
/// are too short to come below `beaten`.
fn clear_on(conditions: &Conditions, side: usize, start: &[Double], beaten: f64) -> Result<Optimum, Infeasible> {
    let &Conditions { task, scale } = conditions;
    let mut about = start.to_vec();
    let mut best: Option<Optimum> = None;
    // How many steps the place of the next tangents is ahead of the last profiles.
    let (mut ahead, mut factor, mut gained) = (0.0, 1.0, 0.0);
    for step in 0..STEPS {
        let tangent = |clearance: &Clearance| {
            let clearance = clearance.over(scale);
            let motions = clearance.laws.map(|law| task.basis.series(law, &about, 1.0));
            let [x, y] = clearance.at(&motions, clearance.least(&motions).phi);
            let shift = if side == 1 && step == 0 { [-2.0 * x, -2.0 * y] } else { [0.0; 2] };
            let mut family = Family::new(0.0, TAU);
            family.limit = -clearance.distance;
            family.tangent = Some(Tangent { clearance, motions, shift });
            family
        };
        let next = convex::optimum(conditions, task.clearances.iter().map(tangent).collect());
        let Some(last) = &best else {
            about.clone_from(&next.as_ref().map_err(Clone::clone)?.best.x);
            best = Some(next?);
            continue;
        };
        // A bend of the way means a step too far ahead.
        let Some(next) = next.ok().filter(|next| next.objective <= last.objective || ahead == 0.0) else {
            if ahead == 0.0 {
                break;
            }
            about.clone_from(&last.best.x);
            (ahead, factor, gained) = (0.0, f64::max(0.5 * ahead, 1.0), 0.0);
            continue;
        };
        let gain = last.objective - next.objective;
        let is_last = gain <= DONE * next.objective.abs();
        if is_last && ahead == 0.0 || gain * (STEPS - step) as f64 <= next.objective - beaten {
            best = Some(next);
            break;
        }
        // Near its end the way is short enough as it is.
        (ahead, factor) = if gain < ENDING * gained { (0.0, 1.0) } else { (factor, GROWTH * factor) };
        gained = gain;
        let way = next.best.x.iter().zip(&last.best.x).map(|(next, last)| (*next, *next - *last));
        about = way.map(|(x, way)| x + way * Double::from(ahead)).collect();
        best = Some(next);
    }
    best.ok_or_else(|| Infeasible::Numerical(Fault::new("no step was made")))
}
