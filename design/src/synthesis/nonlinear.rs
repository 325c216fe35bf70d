//! Objectives that are not convex in the coefficients: the largest of many smooth functions |gᵢ(x)| under linear
//! conditions, by a sequence of linear programs within a trust region, from several starts.
//!
//! Each start leads to a local optimum; the best one is kept, and all are reported. Source: R.
//! Fletcher, E. Sainz de la Maza, "Nonlinear programming and nonsmooth optimization by successive linear programming",
//! Math. Programming 43 (1989) 235–256; K. Madsen, J. Inst. Math. Appl. 16 (1975) 321–328 (minimax).

use super::exact::{Coordinates, Factors, RANK, Solutions, dot};
use super::family::Family;
use super::polyhedron::Polyhedron;
use super::sampling::{FINE, angles};
use super::{Basis, EXHAUSTED, Infeasible, Listener};
use crate::{parallel, work};
use camdrive::drives::Fault;
use camdrive::numerics::double_double::Double;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Linear programs from one start.
const STEPS: usize = 80;

/// A step that promises less than this part of the objective ends the descent.
const DONE: f64 = 1e-9;

/// The smallest trust region, in units of the task.
const SMALLEST: f64 = 1e-10;

/// The largest |U″| of a start, over the least possible one: rougher starts are near no optimum.
const ROUGHEST: f64 = 3.0;

/// Conditions of a step that are exceeded by less than this are kept: the rounding of gradients in sixteen digits.
const KEPT: f64 = 1e-12;

/// A corner is never as low as this, in units of the task.
const LOWEST: f64 = -1e9;

/// Which number many values become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Norm {
    /// The largest |M|, (4.6.3/5).
    Peak,
    /// The root of the mean square, (4.6.3/6).
    Rms,
}

/// The objective over x; None where it has no value.
pub type Function<'a> = &'a (dyn Fn(&[f64]) -> Option<Values> + Sync + 'a);

/// Functions to be minimised.
pub struct Values {
    /// gᵢ(x).
    pub values: Vec<f64>,
    /// ∂gᵢ/∂xⱼ.
    pub gradients: Vec<Vec<f64>>,
    /// The largest |gᵢ| or √Σ gᵢ².
    pub norm: Norm,
}

impl Values {
    /// The objective.
    fn size(&self) -> f64 {
        match self.norm {
            Norm::Peak => self.values.iter().fold(0.0, |largest, g| g.abs().max(largest)),
            Norm::Rms => self.values.iter().map(|g| g * g).sum::<f64>().sqrt(),
        }
    }
}

/// The search of an optimum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Starts.
    pub starts: usize,
    /// Seed of the random starts.
    pub seed: u64,
}

impl Default for Search {
    fn default() -> Self {
        Search { starts: 8, seed: 1 }
    }
}

/// The linear conditions, in the coordinates y of the free directions: x = start + Σ yᵢ freeᵢ.
pub struct Region<'a> {
    /// The functions.
    pub basis: &'a Basis,
    /// The equations.
    pub solutions: &'a Solutions,
    /// The inequalities.
    pub families: &'a [Family],
    /// The point y = 0; fulfils everything.
    pub start: Vec<f64>,
    /// max |U″| of the start.
    pub peak: f64,
}

/// Conditions at angles: rows and limits.
#[derive(Clone, Default)]
struct Cuts {
    rows: Vec<Vec<f64>>,
    limits: Vec<f64>,
}

/// The best of all starts.
pub struct LocalOptimum {
    /// x.
    pub x: Vec<f64>,
    /// The largest |gᵢ| that each start led to.
    pub optima: Vec<f64>,
}

impl Region<'_> {
    fn unknowns(&self) -> usize {
        self.solutions.free.len()
    }

    fn x(&self, y: &[f64]) -> Vec<f64> {
        let mut x = self.start.clone();
        for (y, direction) in y.iter().zip(&self.solutions.free) {
            x.iter_mut().zip(direction).for_each(|(x, d)| *x += y * d.hi);
        }
        x
    }

    /// A row over x in the free directions.
    fn projected(&self, row: &[f64]) -> Vec<f64> {
        self.solutions.free.iter().map(|d| d.iter().zip(row).map(|(d, r)| d.hi * r).sum()).collect()
    }

    fn cut(&self, cuts: &mut Cuts, family: &Family, phi: f64) {
        let start: Vec<Double> = self.start.iter().map(|x| Double::from(*x)).collect();
        let row: Vec<f64> = family.row(self.basis, phi, 0).iter().map(|v| v.hi).collect();
        cuts.rows.push(self.projected(&row));
        cuts.limits.push(family.limit - family.excess(self.basis, &start, phi, 0));
    }

    /// The conditions at samples.
    fn cuts(&self) -> Cuts {
        let mut cuts = Cuts::default();
        for family in self.families {
            for phi in family.first_angles(self.basis) {
                self.cut(&mut cuts, family, phi);
            }
        }
        cuts
    }

    /// Adds what `y` violates between the samples; whether that was much.
    fn exchange(&self, cuts: &mut Cuts, y: &[f64]) -> bool {
        let x: Vec<Double> = self.x(y).into_iter().map(Double::from).collect();
        let mut violated = false;
        for family in self.families {
            for phi in family.maxima(self.basis, &x) {
                let excess = family.excess(self.basis, &x, phi, 0) - family.limit;
                if excess > 1e-9 {
                    self.cut(cuts, family, phi);
                    violated |= excess > 1e-8;
                }
            }
        }
        violated
    }

    /// A point of the region: this part of the way from the start to the corner with the least `cost`.
    fn drawn(&self, (cost, part): &(Vec<f64>, f64)) -> Result<Vec<f64>, Infeasible> {
        let n = self.unknowns();
        let mut cuts = self.cuts();
        for phi in angles(0.0, std::f64::consts::TAU, self.basis.order(), FINE) {
            let row: Vec<f64> = self.basis.row(0, phi, 2, None).iter().map(|v| v.hi).collect();
            let here: f64 = row.iter().zip(&self.start).map(|(r, x)| r * x).sum();
            for sign in [1.0, -1.0] {
                cuts.rows.push(self.projected(&row.iter().map(|r| sign * r).collect::<Vec<_>>()));
                cuts.limits.push(ROUGHEST * self.peak - sign * here);
            }
        }
        // The level of the program is cost · y.
        let mut program = Polyhedron::new(n + 1);
        program.add(numbers(&vec![0.0; n], -1.0), Double::from(-LOWEST));
        program.add(numbers(cost, -1.0), Double::default());
        let corner = solved(program, &cuts, n)?;
        Ok(corner.into_iter().map(|y| part * y).collect())
    }

    /// The best local optimum; `progress` hears of each start that is done. The first start is the point of the region.
    pub fn minimise(
        &self,
        search: Search,
        objective: Function<'_>,
        progress: Listener<'_>,
    ) -> Result<LocalOptimum, Infeasible> {
        let mut random = Random(search.seed);
        let mut draw = || ((0..self.unknowns()).map(|_| random.normal()).collect(), random.uniform());
        let starts: Vec<Option<(Vec<f64>, f64)>> =
            (0..search.starts.max(1)).map(|start| (start > 0).then(&mut draw)).collect();
        let from = |start: &Option<(Vec<f64>, f64)>| {
            let y = start.as_ref().map_or_else(|| Ok(vec![0.0; self.unknowns()]), |start| self.drawn(start))?;
            self.descend(y, objective)
        };
        let count = AtomicUsize::new(0);
        let done = || progress(1 + count.fetch_add(1, Ordering::Relaxed), search.starts);
        let found = parallel::map(&starts, from, &done).into_iter().collect::<Result<Vec<_>, _>>()?;
        let found: Vec<(f64, Vec<f64>)> = found.into_iter().flatten().collect();
        let optima: Vec<f64> = found.iter().map(|(value, _)| *value).collect();
        let best = found.into_iter().reduce(|best, other| if other.0 < best.0 { other } else { best });
        let (_, y) = best.ok_or_else(|| Infeasible::Numerical(Fault::new("no start leads anywhere")))?;
        Ok(LocalOptimum { x: self.x(&y), optima })
    }

    /// Down from `x`, which is in the region.
    pub fn improved(&self, x: &[f64], objective: Function<'_>) -> Result<Vec<f64>, Infeasible> {
        let away: Vec<f64> = x.iter().zip(&self.start).map(|(x, start)| x - start).collect();
        let found = self.descend(self.projected(&away), objective)?;
        Ok(found.map_or(x.to_vec(), |(_, y)| self.x(&y)))
    }

    /// Down from `y` to a local optimum; None where the objective has no value there.
    fn descend(&self, mut y: Vec<f64>, objective: Function<'_>) -> Result<Option<(f64, Vec<f64>)>, Infeasible> {
        let mut cuts = self.cuts();
        let Some(mut here) = objective(&self.x(&y)) else { return Ok(None) };
        let mut radius = 0.1;
        for _ in 0..STEPS {
            let (step, promised) = self.step(&here, &cuts, &y, radius)?;
            let gain = here.size() - promised;
            if gain <= DONE * here.size() || radius < SMALLEST {
                break;
            }
            let next: Vec<f64> = y.iter().zip(&step).map(|(y, s)| y + s).collect();
            if self.exchange(&mut cuts, &next) {
                continue;
            }
            match objective(&self.x(&next)).filter(|there| here.size() - there.size() > 0.05 * gain) {
                Some(there) => {
                    if here.size() - there.size() > 0.5 * gain {
                        radius *= 2.0;
                    }
                    (y, here) = (next, there);
                }
                None => radius *= 0.3,
            }
        }
        Ok(Some((here.size(), y)))
    }

    /// The step that makes the objective of gᵢ + ∇gᵢ·d least among |d| ≤ radius, and that value.
    fn step(&self, here: &Values, cuts: &Cuts, y: &[f64], radius: f64) -> Result<(Vec<f64>, f64), Infeasible> {
        let n = self.unknowns();
        if !work::draw((here.values.len() * n) as f64) {
            return Err(Infeasible::Numerical(Fault::new(EXHAUSTED)));
        }
        let unit = here.size().max(f64::MIN_POSITIVE);
        // In units of the radius and of the objective, so that all unknowns are of size one.
        let scaled = |row: Vec<f64>, factor: f64| row.into_iter().map(|v| v * factor).collect::<Vec<f64>>();
        let model: Vec<Vec<f64>> = here.gradients.iter().map(|g| scaled(self.projected(g), radius / unit)).collect();
        let values: Vec<f64> = here.values.iter().map(|g| g / unit).collect();
        let mut all = Cuts::default();
        for (row, limit) in cuts.rows.iter().zip(&cuts.limits) {
            let at: f64 = row.iter().zip(y).map(|(r, y)| r * y).sum();
            let size = radius * row.iter().fold(f64::MIN_POSITIVE, |s, r| r.abs().max(s));
            all.rows.push(scaled(row.clone(), radius / size));
            // A rounding outside must not make the program insoluble; distant restrictions do not bind.
            all.limits.push(((limit - at).max(0.0) / size).min(2.0 * n as f64));
        }
        for i in 0..n {
            for sign in [1.0, -1.0] {
                let mut row = vec![0.0; n];
                row[i] = sign;
                all.rows.push(row);
                all.limits.push(1.0);
            }
        }
        let step = match here.norm {
            Norm::Peak => {
                let mut program = Polyhedron::new(n + 1);
                for (row, g) in model.iter().zip(&values) {
                    for sign in [1.0, -1.0] {
                        program.add(numbers(&scaled(row.clone(), sign), -1.0), Double::from(-sign * g));
                    }
                }
                solved(program, &all, n)?
            }
            Norm::Rms => least_squares(&model, &values, &all, n),
        };
        let value = |(row, g): (&Vec<f64>, &f64)| g + row.iter().zip(&step).map(|(r, s)| r * s).sum::<f64>();
        let promised =
            Values { values: model.iter().zip(&values).map(value).collect(), gradients: vec![], norm: here.norm };
        Ok((scaled(step, radius), promised.size() * unit))
    }
}

/// A row of a program whose last part belongs to the level.
fn numbers(row: &[f64], level: f64) -> Vec<Double> {
    row.iter().chain([&level]).map(|v| Double::from(*v)).collect()
}

/// The unknowns with the least level under further conditions, which zero fulfils.
fn solved(mut program: Polyhedron, conditions: &Cuts, n: usize) -> Result<Vec<f64>, Infeasible> {
    for (row, limit) in conditions.rows.iter().zip(&conditions.limits) {
        program.add(numbers(row, 0.0), Double::from(*limit));
    }
    if program.lowest(KEPT) {
        Ok(program.point()[..n].iter().map(|y| y.hi).collect())
    } else {
        Err(Infeasible::Numerical(Fault::new("a program of the descent has no solution")))
    }
}

/// The d with the least |g + M d|² under the conditions, in coordinates in which that is the distance from the best d
/// without them.
fn least_squares(model: &[Vec<f64>], values: &[f64], conditions: &Cuts, n: usize) -> Vec<f64> {
    let columns = (0..n).map(|i| model.iter().map(|row| Double::from(row[i])).collect()).collect();
    let factors = Factors::new(columns, model.len(), RANK);
    let best = factors.solve(&values.iter().map(|g| Double::from(-g)).collect::<Vec<_>>());
    let coordinates = Coordinates::new(factors, true);
    let mut program = Polyhedron::new(coordinates.len());
    for (row, limit) in conditions.rows.iter().zip(&conditions.limits) {
        let row: Vec<Double> = row.iter().map(|v| Double::from(*v)).collect();
        program.add(coordinates.row(&row), Double::from(*limit) - dot(&row, &best));
    }
    // Rows that contradict others by a rounding are left out.
    program.nearest(&vec![Double::default(); coordinates.len()], KEPT);
    let step = coordinates.vector(program.point());
    step.iter().zip(&best).map(|(step, best)| (*step + *best).hi).collect()
}

/// Random numbers that are the same everywhere: SplitMix64 (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014).
struct Random(u64);

impl Random {
    /// In [0, 1).
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A random number of mean 0 and variance 1, by the sum of twelve: the tails do not matter here.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}
