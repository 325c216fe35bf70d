//! The profiles of a convex task by one linear or quadratic program: its optimum is the only one.

use super::conditions::{Conditions, Squares};
use super::elastic::{self, SpeedRange};
use super::exact::{RANK, Solutions, dot};
use super::family::Family;
use super::semi_infinite::{Goal, Program, Solution};
use super::{EXHAUSTED, Infeasible, Objective, Profile, Response, SPEED_ROUNDS};
use crate::search::local_maxima;
use crate::work;
use camdrive::drives::Fault;
use camdrive::numerics::double_double::Double;

/// The coefficients of all laws.
pub struct Optimum {
    /// In units of the task.
    pub best: Solution,
    /// In SI.
    pub objective: f64,
    /// The number of coefficients that neither ranges nor points determine.
    pub undetermined: usize,
}

impl Optimum {
    /// The profiles of the laws.
    pub fn profiles(&self, &Conditions { task, scale }: &Conditions) -> Vec<Profile> {
        let best = &self.best;
        let of = |law: usize| {
            let series = task.basis.series(law, &best.x, scale);
            Profile {
                objective: self.objective,
                errors: task.only(law).errors(&series),
                series,
                optima: Vec::new(),
                resolution: best.resolution * scale,
                uncertainty: best.uncertainty * scale,
                undetermined: self.undetermined,
                excess: best.excess * scale,
            }
        };
        (0..task.laws.len()).map(of).collect()
    }
}

/// |A x − b|².
pub fn square((a, b): &Squares, x: &[Double]) -> f64 {
    a.iter().zip(b).map(|(row, b)| (dot(row, x) - *b).hi.powi(2)).sum()
}

/// The conditions with a level that is known.
pub fn capped(mut families: Vec<Family>, level: f64) -> Vec<Family> {
    for family in families.iter_mut().filter(|family| family.level != 0.0) {
        (family.limit, family.level) = (family.limit + family.level * level, 0.0);
    }
    families
}

/// The optimum under the conditions of the task and `further` ones.
pub fn optimum(conditions: &Conditions, further: Vec<Family>) -> Result<Optimum, Infeasible> {
    let (task, squares) = (conditions.task, conditions.samples());
    let goal = if is_of_squares(task.objective) { Goal::Squares(squares.0.clone()) } else { Goal::Level };
    let families = conditions.families().into_iter().chain(further).collect();
    let solutions = conditions.equalities()?;
    let found = optimum_of(conditions, &solutions, families, goal, squares)?;
    // Between points nothing is prescribed; over a range all is, and what is not seen is below rounding.
    match found.undetermined > 0 && task.ranges.iter().all(|range| range.from == range.to) {
        true => smoothest(conditions, &solutions, found),
        false => Ok(found),
    }
}

/// Among all optima, where some coefficients are open, the one with the least ∫U″² dφ.
fn smoothest(conditions: &Conditions, solutions: &Solutions, found: Optimum) -> Result<Optimum, Infeasible> {
    let (mut open, families) = (solutions.free.clone(), capped(conditions.families(), found.best.level));
    if is_of_squares(conditions.task.objective) {
        // The part that the squares see stays.
        let seen: Vec<Vec<Double>> = conditions.samples().0.iter().map(|row| solutions.projected(row)).collect();
        let unseen = Solutions::new(&seen, &vec![Double::default(); seen.len()], open.len(), RANK).free;
        let zero = vec![Double::default(); conditions.task.basis.size()];
        open = unseen.iter().map(|direction| solutions.moved(&zero, direction)).collect();
    }
    let solutions = Solutions { particular: found.best.x.clone(), free: open };
    let squares = conditions.accelerations();
    let smooth = optimum_of(conditions, &solutions, families, Goal::Squares(squares.0.clone()), squares)?;
    Ok(Optimum { best: Solution { x: smooth.best.x, ..found.best }, ..found })
}

/// The least goal under these conditions; without them the `squares` are least.
pub fn optimum_of(
    &Conditions { task, scale }: &Conditions,
    solutions: &Solutions,
    families: Vec<Family>,
    goal: Goal,
    squares: Squares,
) -> Result<Optimum, Infeasible> {
    if work::is_exhausted() {
        return Err(Infeasible::Numerical(Fault::new(EXHAUSTED)));
    }
    let nearest = solutions.least_squares(&squares.0, &squares.1);
    let exact: Vec<f64> = task.points.iter().map(|point| point.phi).collect();
    let mut program = Program { basis: &task.basis, solutions, exact: &exact, families, goal };
    let best = match task.speeds {
        None => program.solve(nearest),
        Some(range) => at_all_speeds(range, &mut program, nearest),
    };
    let best = best.map_err(|e| e.scaled(scale))?;
    let objective = match &program.goal {
        Goal::Squares(_) => square(&squares, &best.x) * scale * scale,
        Goal::Level => best.level * scale,
    };
    let seen = match task.objective {
        Objective::PeakAcceleration | Objective::MeanSquareAcceleration => solutions.free.len(),
        _ => solutions.factors(&squares.0, RANK).rank(),
    };
    Ok(Optimum { undetermined: solutions.free.len() - seen, best, objective })
}

/// The best solution at all speeds of a range: first at some, then also at those where it was worst.
fn at_all_speeds(range: SpeedRange, program: &mut Program, mut centre: Vec<Double>) -> Result<Solution, Infeasible> {
    let (of_output, of_cam): (Vec<_>, Vec<_>) = program.families.iter().cloned().partition(|f| f.level != 0.0);
    let response = |eta: f64| Response { damping: range.damping, eta };
    let at = |eta: f64| of_output.iter().cloned().map(move |family| family.behind(Some(response(eta))));
    let candidates = elastic::speeds(program.basis.order(), range);
    // Ends and middle are a start; the exchange adds the speeds that count.
    let mut speeds = vec![range.slowest, 0.5 * (range.slowest + range.fastest), range.fastest];
    for _ in 0..SPEED_ROUNDS {
        program.families = of_cam.iter().cloned().chain(speeds.iter().flat_map(|eta| at(*eta))).collect();
        let best = program.solve(centre)?;
        let cam = program.basis.series(0, &best.x, 1.0);
        let excess = |eta: f64| match elastic::output(&cam, response(eta)) {
            Some(motion) => of_output.iter().map(|f| f.magnitude(&motion)).fold(0.0, f64::max) - best.level,
            None => f64::INFINITY,
        };
        let least = elastic::SOLVED * best.level.abs() + 1e-14;
        let exceeded: Vec<f64> =
            local_maxima(&candidates, least, &excess).into_iter().filter(|eta| excess(*eta) > least).collect();
        if exceeded.is_empty() {
            return Ok(best);
        }
        speeds.extend(exceeded);
        centre = best.x;
    }
    Err(Infeasible::Numerical(Fault::new("the speeds that count were not found")))
}

/// True if the objective is a sum of squares.
fn is_of_squares(objective: Objective) -> bool {
    matches!(objective, Objective::LeastSquares | Objective::MeanSquareAcceleration)
}
