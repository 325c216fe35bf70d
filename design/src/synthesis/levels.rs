//! Tasks with an end in sight: how large an objective must be that an integral of errors keeps its limit, how long dwells
//! can be and how few harmonics suffice for a largest error.
//!
//! Each is one zero of a level that rises or falls with a number: the least integral under |U″| ≤ t falls with t, the
//! integral of the profile with the least ∫e² + λ ∫U″² rises with λ, the Chebyshev level with the width of the dwells
//! (which are nested), and it falls with the harmonics. All bounds and points hold on the way.
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.3, equations (3) and (4).

use super::conditions::Conditions;
use super::convex::{Optimum, capped, optimum, optimum_of, square};
use super::deviation::peak;
use super::semi_infinite::Goal;
use super::{Infeasible, Listener, Objective, Range, Task};
use crate::search::zero;
use crate::text::number;
use camdrive::drives::Fault;
use camdrive::numerics::double_double::Double;
use std::f64::consts::TAU;

/// A peak is raised by this part of the least one where nothing else is prescribed, so that the program has room.
const ROOM: f64 = 1e-9;

/// ln λ of a weight of the acceleration next to which the errors do not count; its negative if only they count.
const HEAVIEST: f64 = 60.0;

/// The dwells that are tried first are wider or narrower by this factor each.
const GROWTH: f64 = 1.25;

/// Dwells narrower than this part of what the task says are none.
const NARROWEST: f64 = 1e-3;

/// ln of a level that does not exist: far above any.
const NONE: f64 = 700.0;

/// The levels that were tried.
type Tried = Vec<[f64; 2]>;

/// ln of a level over its limit.
fn over(level: f64, limit: f64) -> f64 {
    (level.max(f64::MIN_POSITIVE) / limit).ln()
}

/// The least objective with the integral of the squared errors within `limit` (m²).
pub fn within_integral(conditions: &Conditions, limit: f64) -> Result<Optimum, Infeasible> {
    let scale = conditions.scale;
    let (limit, errors) = (limit / (scale * scale), conditions.errors());
    let missed = |found: &Optimum| square(&errors, &found.best.x);
    let of_peak = conditions.task.objective == Objective::PeakAcceleration;
    let at = |level: f64| if of_peak { below_peak(conditions, level) } else { weighed(conditions, level.exp()) };
    let nearest = at(if of_peak { f64::INFINITY } else { f64::NEG_INFINITY })?;
    if missed(&nearest) > limit {
        return Err(Infeasible::Integral { least: missed(&nearest) * scale * scale });
    }
    let ends = match of_peak {
        true => {
            [optimum(conditions, Vec::new())?.objective / scale * (1.0 + ROOM), sum_of_peaks(conditions.task, &nearest)]
        }
        false => [HEAVIEST, -HEAVIEST],
    };
    let mut excess = |level: f64| at(level).map_or(NONE, |found| over(missed(&found), limit));
    let values = ends.map(&mut excess);
    let level = match values {
        [first, _] if first <= 0.0 => ends[0],
        [_, last] if last >= 0.0 => ends[1],
        _ => zero(&mut excess, ends, values, 1e-15 * ends[1].abs()),
    };
    let found = at(level)?;
    let bend = || square(&conditions.accelerations(), &found.best.x) * scale * scale;
    let objective = if of_peak { level * scale } else { bend() };
    Ok(Optimum { objective, ..found })
}

/// The least integral of the squared errors with a sum of peaks of at most `level`.
fn below_peak(conditions: &Conditions, level: f64) -> Result<Optimum, Infeasible> {
    let mut families = conditions.families();
    families.retain(|family| family.level == 0.0 || level.is_finite());
    let (families, errors) = (capped(families, level), conditions.errors());
    optimum_of(conditions, &conditions.equalities()?, families, Goal::Squares(errors.0.clone()), errors)
}

/// The least integral of the squared errors and of `weight` times the squared acceleration.
fn weighed(conditions: &Conditions, weight: f64) -> Result<Optimum, Infeasible> {
    let (mut a, mut b) = conditions.errors();
    let (rows, values) = conditions.accelerations();
    let root = Double::from(weight.sqrt());
    a.extend(rows.iter().map(|row| row.iter().map(|v| *v * root).collect()));
    b.extend(values.iter().map(|v| *v * root));
    let goal = Goal::Squares(a.clone());
    optimum_of(conditions, &conditions.equalities()?, conditions.families(), goal, (a, b))
}

/// Σ wⱼ max |Uⱼ″|.
fn sum_of_peaks(task: &Task, found: &Optimum) -> f64 {
    let of = |law: usize| peak(&task.basis.series(law, &found.best.x, 1.0), 2).value.abs();
    task.laws.iter().enumerate().map(|(law, weight)| weight * of(law)).sum()
}

/// Words of a hint on bounds, where there are some.
fn or_bounds(task: &Task) -> &'static str {
    if task.bounds.is_empty() { "" } else { ", or widen the bounds" }
}

/// The Chebyshev task with the longest dwells, and what was tried: the factor of the widths, and the least largest error with
/// them (m), infinite for none.
pub fn longest(
    task: &Task,
    tolerance: f64,
    [first, end]: [usize; 2],
    progress: Listener<'_>,
) -> Result<(Task, Tried), Infeasible> {
    let stretched = |(i, range): (usize, &Range), factor: f64| {
        let part = if (first..end).contains(&i) { 0.5 * factor } else { 0.5 };
        let (middle, width) = (0.5 * (range.from + range.to), range.to - range.from);
        Range { from: middle - part * width, to: middle + part * width, ..range.clone() }
    };
    let at = |factor: f64| Task {
        ranges: task.ranges.iter().enumerate().map(|range| stretched(range, factor)).collect(),
        objective: Objective::Chebyshev,
        ..task.clone()
    };
    let mut tried = Vec::new();
    let mut level = |factor: f64| {
        let level = at(factor).solve().map_or(f64::INFINITY, |profile| profile.objective);
        tried.push([factor, level]);
        progress(tried.len(), tried.len() + 1);
        over(level, tolerance).min(NONE)
    };
    let widest = TAU / task.ranges[first..end].iter().map(|r| r.to - r.from).fold(0.0, f64::max);
    let (mut here, mut value) = (1.0_f64.min(widest), level(1.0_f64.min(widest)));
    let growth = if value > 0.0 { 1.0 / GROWTH } else { GROWTH };
    let (other, there) = loop {
        let next = (here * growth).min(widest);
        if next == here || next < NARROWEST {
            let which = if next == here { "a whole turn" } else { "a thousandth of these widths" };
            let least = Some(tolerance * value.exp()).filter(|least| *least > f64::EPSILON * task.scale());
            let [least, tolerance] = [least.unwrap_or(0.0), tolerance].map(number);
            let bounds = if value > 0.0 { or_bounds(task) } else { "" };
            let fault = Fault::new(format!(
                "longest dwell: dwells of {which} deviate by {least} m, the tolerance is {tolerance} m: there is no longest one"
            ));
            let hint = format!("take another tolerance, number of harmonics or start `width`{bounds}");
            return Err(Infeasible::Numerical(fault.hint(hint)));
        }
        let there = level(next);
        if (there > 0.0) != (value > 0.0) {
            break (next, there);
        }
        (here, value) = (next, there);
    };
    let mut of_logarithm = |x: f64| level(x.exp());
    let factor = zero(&mut of_logarithm, [here.ln(), other.ln()], [value, there], 1e-15).exp();
    Ok((at(factor), tried))
}

/// The Chebyshev task with the fewest harmonics, and what was tried: so many, and the least largest error with them.
pub fn fewest(task: &Task, tolerance: f64, progress: Listener<'_>) -> Result<(Task, Tried), Infeasible> {
    let (most, mut tried, mut last) = (task.basis.order(), Vec::new(), None);
    for order in task.basis.harmonics() {
        let next = Task { basis: task.basis.up_to(order), objective: Objective::Chebyshev, ..task.clone() };
        let solved = next.solve();
        let level = solved.as_ref().map_or(f64::INFINITY, |profile| profile.objective);
        tried.push([order as f64, level]);
        progress(order, most);
        if level <= tolerance {
            return Ok((next, tried));
        }
        last = Some(solved);
    }
    match last {
        Some(Err(fault)) => Err(fault),
        _ => {
            let fault = Fault::new(format!(
                "fewest harmonics: with all {most} the largest error is {} m, the tolerance is {} m",
                number(tried.last().map_or(f64::INFINITY, |[_, level]| *level)),
                number(tolerance)
            ));
            let hint = format!("raise `harmonics`, or take a wider tolerance or shorter ranges{}", or_bounds(task));
            Err(Infeasible::Numerical(fault.hint(hint)))
        }
    }
}
