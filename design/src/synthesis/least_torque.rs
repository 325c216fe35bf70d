//! The profile with the least torque, kinetostatic or in an elastic shaft: the best local optimum of several starts.

use super::conditions::Conditions;
use super::nonlinear::{Norm, Region};
use super::shaft::{self, ShaftGoal};
use super::{Infeasible, Listener, Objective, Profile, SPEED_ROUNDS, Task, torque};
use crate::search::local_maxima;

/// x, the optimum from each start and the objective.
type Least = (Vec<f64>, Vec<f64>, f64);

/// The best profile for the torque in the shaft of a goal, else for the kinetostatic one.
pub fn profile(
    conditions: &Conditions,
    goal: Option<ShaftGoal>,
    progress: Listener<'_>,
) -> Result<Profile, Infeasible> {
    let &Conditions { task, scale } = conditions;
    let smooth = Task { objective: Objective::PeakAcceleration, ..task.clone() }.solve()?;
    let solutions = conditions.equalities()?;
    let start = task.basis.coefficients(&smooth.series, scale).iter().map(|x| x.hi).collect();
    let families = conditions.families();
    let peak = smooth.objective / scale;
    let region = Region { basis: &task.basis, solutions: &solutions, families: &families, start, peak };
    let (x, optima, objective) = match goal {
        Some(goal) => in_shaft(task, goal.scaled(scale), &region, progress)?,
        None => {
            let found = region.minimise(task.search, &|x| Some(torque::values(&task.basis, x)), progress)?;
            let objective = torque::peak(&task.basis.series_of(&found.x));
            (found.x, found.optima, objective)
        }
    };
    let unit = if goal.is_some_and(|goal| !goal.relative) { 1.0 } else { scale * scale };
    let series = task.basis.series_of(&x).scaled(scale);
    Ok(Profile {
        objective: objective * unit,
        errors: task.errors(&series),
        series,
        optima: optima.iter().map(|value| value * unit).collect(),
        resolution: smooth.resolution,
        uncertainty: 0.0,
        undetermined: 0,
        excess: smooth.excess,
    })
}

/// The least torque of an elastic shaft: from several starts at some speeds, then from the best of them at all
/// speeds that count.
fn in_shaft(task: &Task, goal: ShaftGoal, region: &Region, progress: Listener<'_>) -> Result<Least, Infeasible> {
    let mut speeds = goal.speeds(shaft::SPEEDS);
    let candidates = goal.speeds(8 * shaft::SPEEDS);
    let values = |x: &[f64], speeds: &[f64]| goal.values(&task.basis, x, speeds);
    let found = region.minimise(task.search, &|x| values(x, &speeds), progress)?;
    let mut x = found.x;
    if goal.norm == Norm::Peak {
        for _ in 0..SPEED_ROUNDS {
            let series = task.basis.series_of(&x);
            let level = goal.over(&series, &speeds);
            let peak = |w: f64| goal.peak(&series, w);
            let least = level * (1.0 + 1e-4);
            let exceeded: Vec<f64> =
                local_maxima(&candidates, least, &peak).into_iter().filter(|w| peak(*w) > least).collect();
            if exceeded.is_empty() {
                break;
            }
            speeds.extend(exceeded);
            x = region.improved(&x, &|x| values(x, &speeds))?;
        }
    }
    let objective = goal.over(&task.basis.series_of(&x), &[candidates, speeds].concat());
    Ok((x, found.optima, objective))
}
