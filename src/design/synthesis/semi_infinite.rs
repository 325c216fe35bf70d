//! Optimisation under conditions that hold at every angle of a range: semi-infinite programs.
//!
//! Exchange method: the conditions are imposed at finitely many angles, the finite program is solved, the angles where
//! the solution violates a condition most are added, until none is left. It is posed for the distance from a centre, in
//! coordinates in which the sampled rows of the objective are orthonormal and in units of the largest violation at the
//! centre: it is well conditioned however narrow the ranges are.
//!
//! The least level comes from linear programs to thirty digits. Each of them has fewer conditions than the task, so
//! that its level is a lower bound, and the largest violation tells how far from it the result is at most; for a
//! Chebyshev problem without bounds that is the method of Remez. Least squares come from an interior point, after which
//! the conditions that bind are solved as equations together with their extremal angles.
//!
//! Source: R. Hettich, K. O. Kortanek, "Semi-infinite programming: theory, methods, and applications", SIAM Review 35
//! (1993) 380–429, section 7; E. Ya. Remez (1934).

use super::Infeasible;
use super::basis::Basis;
use super::exact::{Coordinates, RANK, Solutions, dot};
use super::family::Family;
use super::simplex::Simplex;
use crate::numerics::double_double::Double;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, SupportedConeT,
};
use nalgebra::DMatrix;

/// Violations below this part of the largest one at the centre end the exchange of the interior point: what it resolves.
const EXCHANGED: f64 = 1e-8;

/// Rounds of the exchange; each adds all extremes, so that a handful is the rule.
const ROUNDS: usize = 60;

/// Violations below this part of the level end the exchange of the least level: the level has twelve digits then.
const RESOLVED: f64 = 1e-12;

/// Rounds may end with violations up to this part of the level: where extremes are flat the last digits come slowly.
const ENDED: f64 = 1e-8;

/// Violations below this part of the task are none: a hundredth of what coefficients of sixteen digits leave.
const BELOW: f64 = 1e-18;

/// What the objective sees less than this part of, conditions without a level decide: there the coordinates are not
/// stretched, so that neither loses more than a dozen of its thirty digits.
const SEEN: f64 = 1e-12;

/// The same for the interior point: half of its sixteen digits.
const SEEN_PLAINLY: f64 = 1e-6;

/// Slacks are cut here, in units of the largest violation: so far the solution does not move, and if it does, the
/// exchange takes the condition up anew.
const FAR: f64 = 1e6;

/// Conditions this close to equality, in units of their rows, bind. The polishing then makes them equal; what binds
/// wrongly shows as a worse objective, and the unpolished solution is taken.
const BINDING: f64 = 1e-5;

/// Newton steps of the polishing; it converges quadratically.
const POLISHINGS: usize = 12;

/// Rows of binding conditions that differ by less than this part are the same condition at mirrored angles.
const SAME: f64 = 1e-9;

/// The error of a sum of double-double terms, as part of them: sines to thirty digits.
const ROUNDING: f64 = 1e-30;

/// Bounds that need to be widened by no more than this part of the task are kept: the roundings of what a user writes.
const KEPT: f64 = 1e-13;

/// The room that is made between conditions before anything else, as part of the task: what descends from there does
/// not begin in a corner.
const ROOM: f64 = 1e-3;

/// What is made small.
pub enum Goal {
    /// The level t, which need not be below this.
    Level(f64),
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
    /// What the errors are known to: the rounding of the numbers of thirty digits.
    pub resolution: f64,
    /// The largest change of a coefficient that this rounding may hide.
    pub uncertainty: f64,
}

/// Where a finite program is posed: x = centre + unit · T y.
struct Frame<'a> {
    centre: &'a [Double],
    unit: f64,
    coordinates: &'a Coordinates,
}

impl Program<'_> {
    /// The best solution, starting at `centre`, which fulfils the equations.
    pub fn solve(&self, centre: Vec<Double>) -> Result<Solution, Infeasible> {
        match &self.goal {
            Goal::Level(least) => self.least_level(centre, *least),
            Goal::Squares(a, b) => self.least_squares(centre, a, b),
        }
    }

    fn least_level(&self, centre: Vec<Double>, least: f64) -> Result<Solution, Infeasible> {
        let centre = self.inside(centre)?;
        let mut places = self.first_places();
        let coordinates = self.coordinates(&places);
        let rounding = self.rounding(&places, &centre);
        let uncertainty = self.uncertainty(&coordinates, rounding);
        let highest = self.largest_violation(&centre, 0.0);
        if highest <= least + rounding {
            return Ok(Solution { x: centre, level: highest.max(least), resolution: rounding, uncertainty });
        }
        let unit = highest.abs().max(least.abs());
        let frame = Frame { centre: &centre, unit, coordinates: &coordinates };
        let inside = vec![Double::default(); coordinates.len()];
        let mut program = Simplex::new(coordinates.len(), least / unit);
        let (mut x, mut level, mut worst) = (centre.clone(), 0.0, unit);
        for round in 0..ROUNDS {
            for place in &places {
                let (row, limit) = self.condition(&frame, *place);
                program.add(row, limit);
            }
            let tolerance = |level: f64| (RESOLVED * level.abs()).max(rounding);
            let known = (round == 0 && program.descend(&inside)) || round > 0;
            let reach = |program: &mut Simplex| {
                let admitted = 0.5 * tolerance(unit * program.level().hi) / unit;
                program.ascend(admitted)
            };
            let optimal = known && (reach(&mut program) || (program.descend(&inside) && reach(&mut program)));
            x = self.moved(&frame, program.unknowns());
            level = unit * program.level().hi;
            let violation = |place: &Place| self.violation(&x, level, *place);
            places = self.maxima(&x);
            worst = places.iter().map(violation).fold(0.0, f64::max);
            places.retain(|place| violation(place) > tolerance(level));
            if places.is_empty() || !optimal {
                break;
            }
        }
        if worst > (ENDED * level.abs()).max(BELOW) {
            let text = format!("a condition is still exceeded by {worst:.1e} of the task, whose level is {level:.1e}");
            return Err(Infeasible::Numerical(text));
        }
        Ok(Solution { x, level, resolution: rounding.max(worst - RESOLVED * level.abs()), uncertainty })
    }

    fn least_squares(&self, centre: Vec<Double>, a: &[Vec<Double>], b: &[Double]) -> Result<Solution, Infeasible> {
        let mut places = self.first_places();
        let rounding = self.rounding(&places, &centre);
        let coordinates = self.coordinates(&places);
        let uncertainty = self.uncertainty(&coordinates, rounding);
        let unit = self.largest_violation(&centre, 0.0);
        if unit <= rounding {
            return Ok(Solution { x: centre, level: 0.0, resolution: rounding, uncertainty });
        }
        // From where nothing is exceeded: the conditions alone, as a level that has to be zero.
        let mut x = self.inside(centre)?;
        let start = x.clone();
        let frame = Frame { centre: &start, unit, coordinates: &coordinates };
        for _ in 0..ROUNDS {
            x = self.finite(&frame, &places, a, b)?;
            let violated: Vec<Place> =
                self.maxima(&x).into_iter().filter(|p| self.violation(&x, 0.0, *p) > EXCHANGED * unit).collect();
            if violated.is_empty() {
                break;
            }
            places.extend(violated);
        }
        let x = self.polished(x, &frame, a, b);
        let worst = self.largest_violation(&x, 0.0);
        // What is not polished is still as good as the exchange.
        if worst > (10.0 * EXCHANGED * unit).max(rounding) {
            return Err(Infeasible::Numerical(format!("a condition is still exceeded by {worst:.1e} of the task")));
        }
        Ok(Solution { x, level: 0.0, resolution: rounding, uncertainty })
    }

    /// The angles that the first program looks at.
    fn first_places(&self) -> Vec<Place> {
        let of = |(i, family): (usize, &Family)| -> Vec<Place> {
            family.first_angles(self.basis).into_iter().map(|phi| (i, phi)).collect()
        };
        self.families.iter().enumerate().flat_map(of).collect()
    }

    /// Coordinates in which the rows of the objective are orthonormal.
    fn coordinates(&self, places: &[Place]) -> Coordinates {
        let of_goal = places.iter().filter(|(i, _)| self.families[*i].level != 0.0);
        let mut rows: Vec<Vec<Double>> = of_goal.map(|&(i, phi)| self.families[i].row(self.basis, phi, 0)).collect();
        if let Goal::Squares(a, _) = &self.goal {
            rows.extend(a.iter().cloned());
        }
        let conditions = self.families.iter().any(|family| family.level == 0.0);
        let rank = match &self.goal {
            _ if !conditions => RANK,
            Goal::Level(_) => SEEN,
            Goal::Squares(..) => SEEN_PLAINLY,
        };
        Coordinates::new(self.solutions.factors(&rows, rank), conditions)
    }

    /// What the sums of the conditions are not known to.
    fn rounding(&self, places: &[Place], x: &[Double]) -> f64 {
        let terms = |&(i, phi): &Place| self.families[i].terms(self.basis, x, phi);
        let of_conditions = places.iter().map(terms).fold(0.0, f64::max);
        let of_goal = match &self.goal {
            Goal::Level(_) => 0.0,
            Goal::Squares(a, _) => {
                let terms = |row: &Vec<Double>| row.iter().zip(x).map(|(row, x)| (row.hi * x.hi).abs()).sum::<f64>();
                a.iter().map(terms).fold(0.0, f64::max)
            }
        };
        ROUNDING * of_conditions.max(of_goal)
    }

    /// By how much a coefficient may change while the objective changes by rounding.
    fn uncertainty(&self, coordinates: &Coordinates, rounding: f64) -> f64 {
        let mut squares = vec![0.0; self.basis.len()];
        for i in 0..coordinates.len() {
            let mut y = vec![Double::default(); coordinates.len()];
            y[i] = Double::from(rounding);
            let step = self.solutions.moved(&vec![Double::default(); squares.len()], &coordinates.vector(&y));
            squares.iter_mut().zip(step).for_each(|(sum, s)| *sum += s.hi * s.hi);
        }
        squares.into_iter().fold(0.0, f64::max).sqrt()
    }

    fn maxima(&self, x: &[Double]) -> Vec<Place> {
        let of = |(i, family): (usize, &Family)| -> Vec<Place> {
            family.maxima(self.basis, x).into_iter().map(|phi| (i, phi)).collect()
        };
        self.families.iter().enumerate().flat_map(of).collect()
    }

    /// By how much a condition is violated (negative: reserve).
    fn violation(&self, x: &[Double], level: f64, (i, phi): Place) -> f64 {
        let family = &self.families[i];
        let excess = family.excess_exactly(self.basis, x, phi, 0) - Double::from(family.limit);
        (excess - Double::from(family.level * level)).hi
    }

    fn largest_violation(&self, x: &[Double], level: f64) -> f64 {
        self.maxima(x).into_iter().map(|p| self.violation(x, level, p)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// centre + unit · T y.
    fn moved(&self, frame: &Frame, y: &[Double]) -> Vec<Double> {
        let unit = Double::from(frame.unit);
        let y: Vec<Double> = y.iter().map(|y| *y * unit).collect();
        self.solutions.moved(frame.centre, &frame.coordinates.vector(&y))
    }

    /// A condition as a row over y and τ, the level over the unit, and its limit.
    fn condition(&self, frame: &Frame, (i, phi): Place) -> (Vec<Double>, Double) {
        let family = &self.families[i];
        let mut row = self.projected(frame.coordinates, &family.row(self.basis, phi, 0));
        row.push(Double::from(-family.level));
        let excess = family.excess_exactly(self.basis, frame.centre, phi, 0);
        (row, (Double::from(family.limit) - excess).divide(Double::from(frame.unit)))
    }

    /// The least sum of squares with the conditions at these places only.
    fn finite(
        &self,
        frame: &Frame,
        places: &[Place],
        goal: &[Vec<Double>],
        values: &[Double],
    ) -> Result<Vec<Double>, Infeasible> {
        let n = frame.coordinates.len();
        let (mut p, mut q) = (DMatrix::zeros(n, n), vec![0.0; n]);
        for (row, b) in goal.iter().zip(values) {
            let miss = (dot(row, frame.centre) - *b).hi / frame.unit;
            let row: Vec<f64> = self.projected(frame.coordinates, row).iter().map(|v| v.hi).collect();
            for i in 0..n {
                q[i] += row[i] * miss;
                for j in 0..n {
                    p[(i, j)] += row[i] * row[j];
                }
            }
        }
        let mut a = DMatrix::zeros(places.len(), n);
        let mut b = Vec::with_capacity(places.len());
        for (line, place) in places.iter().enumerate() {
            let (row, limit) = self.condition(frame, *place);
            let size = size(&row);
            (0..n).for_each(|j| a[(line, j)] = row[j].hi / size);
            b.push((limit.hi / size).clamp(0.0, FAR));
        }
        let y = interior_point(&p, &q, &a, &b)?;
        let y = y.ok_or_else(|| Infeasible::Numerical("the optimisation finds no solution".to_owned()))?;
        let y: Vec<Double> = y.into_iter().map(Double::from).collect();
        Ok(self.moved(frame, &y))
    }

    /// A solution that fulfils all conditions without level, with some room where they leave it; else which of them
    /// cannot be kept, and by how much, when all are widened alike.
    fn inside(&self, centre: Vec<Double>) -> Result<Vec<Double>, Infeasible> {
        let mut families: Vec<Family> = self.families.iter().filter(|f| f.level == 0.0).cloned().collect();
        if families.is_empty() {
            return Ok(centre);
        }
        families.iter_mut().for_each(|f| f.level = 1.0);
        let program = Program { basis: self.basis, solutions: self.solutions, families, goal: Goal::Level(-ROOM) };
        let Solution { x, level, .. } = program.solve(centre)?;
        if level <= KEPT {
            return Ok(x);
        }
        let violation = |p: &Place| program.violation(&x, level, *p);
        let worst = program.maxima(&x).into_iter().max_by(|a, b| violation(a).total_cmp(&violation(b)));
        let (i, phi) = worst.unwrap_or((0, 0.0));
        Err(Infeasible::Bound { index: program.families[i].bound.unwrap_or(0), by: level, phi })
    }

    /// A row in the coordinates of the program.
    fn projected(&self, coordinates: &Coordinates, row: &[Double]) -> Vec<Double> {
        coordinates.row(&self.solutions.projected(row))
    }

    /// `start` with the binding conditions fulfilled to rounding, unless that makes anything worse.
    fn polished(&self, start: Vec<Double>, frame: &Frame, a: &[Vec<Double>], b: &[Double]) -> Vec<Double> {
        let goal: Vec<_> = a.iter().map(|row| self.projected(frame.coordinates, row)).collect();
        let mut best = start.clone();
        for _ in 0..POLISHINGS {
            let here = Frame { centre: &best, ..*frame };
            let conditions = self.maxima(&best).into_iter().map(|place| self.condition(&here, place));
            let binding =
                conditions.filter(|(row, limit)| limit.hi.abs() < BINDING * size(row)).map(|(mut row, limit)| {
                    row.pop();
                    (row, limit)
                });
            let (rows, rest): (Vec<_>, Vec<_>) = binding.unzip();
            let binding = Solutions::new(&rows, &rest, frame.coordinates.len(), SAME);
            let unit = Double::from(frame.unit);
            let misses: Vec<Double> = a.iter().zip(b).map(|(row, b)| (*b - dot(row, &best)).divide(unit)).collect();
            let step = binding.least_squares(&goal, &misses);
            best = self.moved(&here, &step);
            if step.iter().all(|s| s.hi.abs() <= 1e-14) {
                break;
            }
        }
        let excess = |x: &[Double]| self.largest_violation(x, 0.0).max(0.0);
        let cost = |x: &[Double]| -> f64 { a.iter().zip(b).map(|(row, b)| (dot(row, x) - *b).hi.powi(2)).sum() };
        let better = excess(&best) <= excess(&start).max(1e-12 * frame.unit)
            && cost(&best) <= cost(&start) + 1e2 * EXCHANGED * frame.unit * frame.unit;
        if better { best } else { start }
    }
}

/// The largest part of a row.
fn size(row: &[Double]) -> f64 {
    row.iter().map(|v| v.hi.abs()).fold(f64::MIN_POSITIVE, f64::max)
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
