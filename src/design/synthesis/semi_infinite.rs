//! Optimisation under conditions that hold at every angle of a range: semi-infinite programs.
//!
//! Exchange method: the conditions are imposed at finitely many angles, the finite program is solved (interior
//! point), the angles where the solution violates a condition most are added, until none is left. The finite program
//! is posed for the distance from a centre, in coordinates in which the sampled conditions are orthonormal and in
//! units of the largest violation at the centre: it is well conditioned however narrow the ranges are. At the end the
//! conditions that bind are solved as equations together with their extremal angles; for a Chebyshev problem that is
//! the method of Remez.
//!
//! Source: R. Hettich, K. O. Kortanek, "Semi-infinite programming: theory, methods, and applications", SIAM Review 35
//! (1993) 380–429, section 7; A. M. Gleixner, D. E. Steffy, K. Wolter, "Iterative refinement for linear programming",
//! INFORMS J. Comput. 28 (2016) 449–464; E. Ya. Remez (1934).

use super::Infeasible;
use super::basis::Basis;
use super::exact::{Factors, Solutions, dot};
use super::family::Family;
use crate::numerics::double_double::Double;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, SupportedConeT,
};
use nalgebra::DMatrix;

/// Violations below this part of the largest one at the centre end the exchange: what an interior point can resolve.
const EXCHANGED: f64 = 1e-8;

/// Rounds of the exchange; each adds all extremes, so that a handful is the rule.
const ROUNDS: usize = 40;

/// Slacks are cut here, in units of the largest violation: so far the solution does not move, and if it does, the
/// exchange takes the condition up anew.
const FAR: f64 = 1e6;

/// Conditions this close to equality, in units of the level, bind. The polishing then makes them equal; what binds
/// wrongly shows as a worse objective, and the unpolished solution is taken.
const BINDING: f64 = 1e-5;

/// Newton steps of the polishing; it converges quadratically.
const POLISHINGS: usize = 12;

/// Rows of binding conditions that differ by less than this part are the same condition at mirrored angles.
const SAME: f64 = 1e-9;

/// Levels below this part of the task are zero: rounding of the coefficients of a profile is larger.
const NOTHING: f64 = 1e-22;

/// What is made small.
pub enum Goal {
    /// The level t.
    Level,
    /// |A x − b|², rows of A and b.
    Squares(Vec<Vec<Double>>, Vec<Double>),
}

/// The least goal under equations and families of conditions.
pub struct Program<'a> {
    /// The functions of the profile.
    pub basis: &'a Basis,
    /// The x that fulfil the equations.
    pub solutions: &'a Solutions,
    /// The conditions.
    pub families: Vec<Family>,
    /// What is made small.
    pub goal: Goal,
}

/// A condition at one angle.
type Place = (usize, f64);

/// The coefficients and the level.
#[derive(Clone, Debug)]
pub struct Solution {
    /// x.
    pub x: Vec<Double>,
    /// t.
    pub level: f64,
}

/// Where a finite program is posed: x = centre + unit · T y.
struct Frame<'a> {
    center: &'a Solution,
    unit: f64,
    factors: &'a Factors,
}

impl Program<'_> {
    /// The best solution, starting at `center`, which fulfils the equations.
    pub fn solve(&self, center: Vec<Double>) -> Result<Solution, Infeasible> {
        let mut places: Vec<Place> = Vec::new();
        for (i, family) in self.families.iter().enumerate() {
            places.extend(family.first_angles(self.basis).into_iter().map(|phi| (i, phi)));
        }
        let factors = self.solutions.factors(&self.sampled(&places));
        let mut best = Solution { x: center, level: 0.0 };
        let mut unit = 0.0;
        for _ in 0..ROUNDS {
            unit = self.largest_violation(&best);
            if unit < NOTHING {
                break;
            }
            let frame = Frame { center: &best, unit, factors: &factors };
            let next = self.finite(&frame, &places)?;
            let violated: Vec<Place> =
                self.maxima(&next).into_iter().filter(|p| self.violation(&next, *p) > EXCHANGED * unit).collect();
            let done = violated.is_empty();
            places.extend(violated);
            if done {
                best = self.polished(next, unit, &factors);
                // The level may have become small against the unit; then it is found anew in its own.
                if best.level.abs() > 1e-3 * unit || matches!(self.goal, Goal::Squares(..)) {
                    break;
                }
                best.level = 0.0;
            }
        }
        let worst = self.largest_violation(&best);
        // What is not polished is still as good as the exchange.
        let tolerable = (10.0 * EXCHANGED * unit).max(NOTHING);
        if worst > tolerable {
            return Err(Infeasible::Numerical(format!("a condition is still exceeded by {worst:e} of the task")));
        }
        Ok(best)
    }

    /// The rows that the coordinates are made for.
    fn sampled(&self, places: &[Place]) -> Vec<Vec<Double>> {
        let mut rows: Vec<Vec<Double>> =
            places.iter().map(|&(i, phi)| self.families[i].row(self.basis, phi, 0)).collect();
        if let Goal::Squares(a, _) = &self.goal {
            rows.extend(a.iter().cloned());
        }
        rows
    }

    fn maxima(&self, solution: &Solution) -> Vec<Place> {
        let of = |(i, family): (usize, &Family)| -> Vec<Place> {
            family.maxima(self.basis, &solution.x).into_iter().map(|phi| (i, phi)).collect()
        };
        self.families.iter().enumerate().flat_map(of).collect()
    }

    /// By how much a condition is violated (negative: reserve).
    fn violation(&self, solution: &Solution, (i, phi): Place) -> f64 {
        let family = &self.families[i];
        family.excess(self.basis, &solution.x, phi, 0) - family.limit - family.level * solution.level
    }

    fn largest_violation(&self, solution: &Solution) -> f64 {
        let of = |family: &Family| family.worst(self.basis, &solution.x) - family.limit - family.level * solution.level;
        self.families.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The solution with the conditions at these places only. Unknowns: y, τ with t = level of the centre + unit · τ.
    fn finite(&self, frame: &Frame, places: &[Place]) -> Result<Solution, Infeasible> {
        let n = frame.factors.rank();
        let projected =
            |row: &[Double]| -> Vec<f64> { self.projected(frame.factors, row).iter().map(|v| v.hi).collect() };
        let (mut p, mut q) = (DMatrix::zeros(n + 1, n + 1), vec![0.0; n + 1]);
        match &self.goal {
            Goal::Level => q[n] = 1.0,
            Goal::Squares(a, b) => {
                // Nothing depends on τ here; it is held at zero.
                p[(n, n)] = 1.0;
                for (row, b) in a.iter().zip(b) {
                    let miss = (dot(row, &frame.center.x) - *b).hi / frame.unit;
                    let row = projected(row);
                    for i in 0..n {
                        q[i] += row[i] * miss;
                        for j in 0..n {
                            p[(i, j)] += row[i] * row[j];
                        }
                    }
                }
            }
        }
        let mut a = DMatrix::zeros(places.len() + 1, n + 1);
        let mut b = Vec::with_capacity(places.len() + 1);
        for (line, &(i, phi)) in places.iter().enumerate() {
            let row = projected(&self.families[i].row(self.basis, phi, 0));
            a.row_mut(line).columns_mut(0, n).copy_from_slice(&row);
            a[(line, n)] = -self.families[i].level;
            b.push((-self.violation(frame.center, (i, phi)) / frame.unit).min(FAR));
        }
        // A level below zero would be none.
        a[(places.len(), n)] = -1.0;
        b.push(frame.center.level / frame.unit);
        let y = interior_point(&p, &q, &a, &b)?.ok_or_else(|| self.conflict(frame.center))?;
        let steps: Vec<Double> = y[..n].iter().map(|y| Double::from(frame.unit * y)).collect();
        let x = self.solutions.moved(&frame.center.x, &frame.factors.back(&steps));
        Ok(Solution { x, level: frame.center.level + frame.unit * y[n] })
    }

    /// Which bound cannot be kept, and by how much, when all bounds are widened alike.
    fn conflict(&self, center: &Solution) -> Infeasible {
        let hard = || self.families.iter().filter(|f| f.level == 0.0);
        // Without hard conditions every level is admissible, so that only rounding can lead here.
        if hard().next().is_none() {
            return Infeasible::Numerical("the optimisation finds no solution".to_owned());
        }
        let mut families: Vec<Family> = hard().cloned().collect();
        families.iter_mut().for_each(|f| f.level = 1.0);
        let program = Program { basis: self.basis, solutions: self.solutions, families, goal: Goal::Level };
        match program.solve(center.x.clone()) {
            Ok(solution) => {
                let violation = |p: &Place| program.violation(&solution, *p);
                let worst = program.maxima(&solution).into_iter().max_by(|a, b| violation(a).total_cmp(&violation(b)));
                let (i, phi) = worst.unwrap_or((0, 0.0));
                Infeasible::Bound { index: program.families[i].bound.unwrap_or(0), by: solution.level, phi }
            }
            Err(other) => other,
        }
    }

    /// A row in the coordinates of the program.
    fn projected(&self, factors: &Factors, row: &[Double]) -> Vec<Double> {
        factors.forward(&self.solutions.projected(row))
    }

    /// `start` with the binding conditions fulfilled to rounding, unless that makes anything worse.
    fn polished(&self, start: Solution, unit: f64, factors: &Factors) -> Solution {
        let n = factors.rank();
        let size = match self.goal {
            Goal::Level => start.level.abs().max(self.largest_violation(&start).abs()),
            Goal::Squares(..) => unit,
        };
        let with_level = |row: &[Double], level: f64| {
            let mut row = self.projected(factors, row);
            row.push(Double::from(level));
            row
        };
        let mut best = start.clone();
        for _ in 0..POLISHINGS {
            let near = |p: &Place| self.violation(&best, *p).abs() < BINDING * size;
            let binding: Vec<Place> = self.maxima(&best).into_iter().filter(near).collect();
            let row = |&(i, phi): &Place| {
                let family = &self.families[i];
                with_level(&family.row(self.basis, phi, 0), -family.level)
            };
            let rows: Vec<Vec<Double>> = binding.iter().map(row).collect();
            let rest: Vec<Double> = binding.iter().map(|p| Double::from(-self.violation(&best, *p))).collect();
            let binding = Solutions::new(&rows, &rest, n + 1, SAME);
            let step = match &self.goal {
                Goal::Level => binding.particular,
                Goal::Squares(a, b) => {
                    let misses: Vec<Double> = a.iter().zip(b).map(|(row, b)| *b - dot(row, &best.x)).collect();
                    let a: Vec<_> = a.iter().map(|row| with_level(row, 0.0)).collect();
                    binding.least_squares(&a, &misses)
                }
            };
            best.x = self.solutions.moved(&best.x, &factors.back(&step[..n]));
            best.level += step[n].hi;
            // The level is a number of sixteen digits, and the step is no better than it.
            if step.iter().all(|s| s.hi.abs() <= 1e-13 * size) {
                break;
            }
        }
        let excess = |s: &Solution| self.largest_violation(s).max(0.0);
        let cost = |s: &Solution| match &self.goal {
            Goal::Level => s.level,
            Goal::Squares(a, b) => a.iter().zip(b).map(|(row, b)| (dot(row, &s.x) - *b).hi.powi(2)).sum(),
        };
        let slack = 1e2 * EXCHANGED * size;
        let better = excess(&best) <= excess(&start).max(1e-12 * size) && cost(&best) <= cost(&start) + slack;
        if better { best } else { start }
    }
}

/// The y with the least ½ yᵀP y + qᵀy under A y ≤ b; None if no y fulfils the conditions.
pub fn interior_point(
    p: &DMatrix<f64>,
    q: &[f64],
    a: &DMatrix<f64>,
    b: &[f64],
) -> Result<Option<Vec<f64>>, Infeasible> {
    let fault = |text: String| Infeasible::Numerical(text);
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        .tol_gap_abs(1e-11)
        .tol_gap_rel(1e-11)
        .tol_feas(1e-11)
        .max_iter(300)
        .build()
        .map_err(|e| fault(e.to_string()))?;
    let cones: [SupportedConeT<f64>; 1] = [NonnegativeConeT(b.len())];
    let mut solver = DefaultSolver::new(&sparse(&p.upper_triangle()), q, &sparse(a), b, &cones, settings)
        .map_err(|e| fault(e.to_string()))?;
    solver.solve();
    match solver.solution.status {
        // What the last two have not reached, exchange and polishing either reach or report.
        SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress => {
            Ok(Some(solver.solution.x.clone()))
        }
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Ok(None),
        status => Err(fault(format!("the optimisation ended with {status:?}"))),
    }
}

/// The matrix with its zeros left out, as the optimiser takes it.
fn sparse(m: &DMatrix<f64>) -> CscMatrix<f64> {
    let (mut columns, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
    for j in 0..m.ncols() {
        for i in 0..m.nrows() {
            if m[(i, j)] != 0.0 {
                rows.push(i);
                values.push(m[(i, j)]);
            }
        }
        columns.push(rows.len());
    }
    CscMatrix::new(m.nrows(), m.ncols(), columns, rows, values)
}
