//! Harmonic synthesis: the finite Fourier series that fulfils a motion task best (HS profile).
//!
//! A task prescribes the position U or its derivatives U′, U″ in ranges of the drive angle φ, exactly at points, and
//! bounds of any derivative up to U‴. The errors are eₙ = U⁽ⁿ⁾ − Ũ⁽ⁿ⁾, the objectives
//!
//! S1 = Σ ∫ (e₀² + w₁ e₁² + w₂ e₂²) dφ,  S2 = the same, a sum over points,
//! S3 = max max(|e₀|, w₁|e₁|, w₂|e₂|),  S4 = the same over points,  S5 = max (|e₀| + w₁|e₁| + w₂|e₂|),
//!
//! and the peak of |U″|. Symbols: φ (rad), U (m) (or rad), w₁, w₂ weights (radⁿ) (of S1, S2: squared).
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.2, equations (8) to (21), with the signs of the
//! terms in w₂ and the blocks of (12) corrected. The normal equations printed there are not used: their condition
//! grows with a high power of 1/Δφ; the singular values of the sampled functions themselves decide here.

mod banded;
mod basis;
pub mod clearance;
mod conditions;
mod convex_concave;
mod curve;
pub mod deviation;
pub mod elastic;
mod exact;
mod family;
mod feasibility;
pub mod figures;
pub mod laws;
mod levels;
mod nonlinear;
mod polyhedron;
mod remarks;
mod sampling;
mod semi_infinite;
pub mod shaft;
pub mod shaft_study;
pub mod study;
pub mod table;
#[cfg(test)]
mod tests;
pub mod together;
pub mod torque;

pub use basis::{Basis, Response, Symmetry};
pub use curve::Curve;
pub use feasibility::KEPT;
pub use nonlinear::{Norm, Search};
pub use remarks::UNITS;

use crate::search::local_maxima;
use crate::work;
use camdrive::motion::Fourier;
use camdrive::numerics::double_double::Double;
use clearance::Clearance;
use deviation::Window;
use elastic::SpeedRange;
use exact::{RANK, Solutions, dot};
use family::Family;
use nonlinear::Region;
use semi_infinite::{Goal, Program, Solution};
use shaft::ShaftGoal;

/// What the parts of a study say to it when its work is used up; it has words of its own.
const EXHAUSTED: &str = "the work of the study is used up";

/// Hears how many of how many parts of a search are done.
pub type Told<'a> = &'a (dyn Fn(usize, usize) + Sync + 'a);

/// Rounds in which the robust problem takes up speeds.
const SPEED_ROUNDS: usize = 20;

/// A range of the drive angle with what is prescribed there.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Which law, from 0.
    pub law: usize,
    /// First angle (rad).
    pub from: f64,
    /// Last angle (rad), ≥ `from`; where it is the same, the range is one point, which counts as a sum does.
    pub to: f64,
    /// Ũ, Ũ′, Ũ″; None where free.
    pub prescribed: [Option<Curve>; 3],
    /// Weight of the range in the sums and maxima.
    pub weight: f64,
}

/// U⁽ⁿ⁾(φ) = value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Which law, from 0.
    pub law: usize,
    /// φ (rad).
    pub phi: f64,
    /// n ≤ 3.
    pub order: usize,
    /// The value (m/radⁿ).
    pub value: f64,
}

/// min ≤ Σ αⱼ Uⱼ⁽ⁿ⁾ − Ũ⁽ⁿ⁾ ≤ max for `from` ≤ φ ≤ `to`: of one law, or a restriction of several.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Each law j with its αⱼ.
    pub of: Vec<(usize, f64)>,
    /// First angle (rad).
    pub from: f64,
    /// Last angle (rad).
    pub to: f64,
    /// n ≤ 3.
    pub order: usize,
    /// Ũ⁽ⁿ⁾.
    pub around: Curve,
    /// Least value (m/radⁿ); −∞ for none.
    pub min: f64,
    /// Largest value (m/radⁿ); ∞ for none.
    pub max: f64,
}

impl Bound {
    /// Whether it is of this law alone.
    pub fn is_of(&self, law: usize) -> bool {
        self.of.iter().all(|(j, _)| *j == law)
    }
}

/// Criterion by which one profile is better than another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Objective {
    /// S1, integral least squares.
    LeastSquares,
    /// S2, least squares over `points` equally spaced points of each range.
    DiscreteLeastSquares {
        /// How many, ends included; 0 for the default.
        points: usize,
    },
    /// S3, the largest error.
    Chebyshev,
    /// S4, the largest error at equally spaced points.
    DiscreteChebyshev {
        /// How many in each range, ends included; 0 for the default.
        points: usize,
    },
    /// S5, the largest sum of errors.
    ChebyshevSum,
    /// The largest |U″| over the whole turn; of several laws Σ wⱼ max |Uⱼ″|.
    PeakAcceleration,
    /// ∫U″² dφ over the whole turn; of several laws Σ wⱼ ∫Uⱼ″² dφ.
    MeanSquareAcceleration,
    /// The widest dwells with a largest error of `tolerance`: some of the ranges, all wider by one factor.
    LongestDwell {
        /// δ (m), which weights refer to.
        tolerance: f64,
        /// The first of the dwells that grow, and the one after the last.
        dwells: [usize; 2],
    },
    /// The fewest harmonics with a largest error of `tolerance`.
    FewestHarmonics {
        /// δ (m), which weights refer to.
        tolerance: f64,
    },
    /// The largest |U′U″| over the whole turn: not convex, so that the result is the best local optimum of a search.
    PeakTorque,
    /// The torque in an elastic input shaft; not convex either.
    ShaftTorque(ShaftGoal),
}

/// A motion task.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// The functions that the profile is made of; of all laws.
    pub basis: Basis,
    /// How much each law counts in the objective; one for each law.
    pub laws: Vec<f64>,
    /// Ranges with prescribed motion.
    pub ranges: Vec<Range>,
    /// Exact conditions.
    pub points: Vec<Point>,
    /// Bounds that must not be exceeded.
    pub bounds: Vec<Bound>,
    /// Which tools keep clear of each other.
    pub clearances: Vec<Clearance>,
    /// Σ ∫ (e₀² + w₁ e₁² + w₂ e₂²) dφ over the ranges must not exceed it (m²); of the accelerations as objective only.
    pub integral: Option<f64>,
    /// The quantity to be minimised.
    pub objective: Objective,
    /// w₁, w₂.
    pub weights: [f64; 2],
    /// Where the profile is that of a cam with an elastic output member: the objective counts behind that member, at
    /// all these speeds (of the Chebyshev objectives only). Points and bounds hold for the cam.
    pub speeds: Option<SpeedRange>,
    /// How the objectives that are not convex look for their optimum.
    pub search: Search,
}

/// A profile that fulfils a task.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// The series.
    pub series: Fourier,
    /// The value of the objective.
    pub objective: f64,
    /// The largest |e₀|, |e₁|, |e₂| in each range of the law, NaN where nothing is prescribed.
    pub errors: Vec<[f64; 3]>,
    /// Optimum from each start of a search; empty where the optimum is the only one.
    pub optima: Vec<f64>,
    /// Errors below this cannot be told from rounding (m); the coefficients are rounded to sixteen digits afterwards.
    pub resolution: f64,
    /// The largest change of a coefficient that this rounding may hide (m).
    pub uncertainty: f64,
    /// How many coefficients neither the ranges nor the points determine; so many of them are free.
    pub undetermined: usize,
    /// Remaining excess of conditions (m/radⁿ): rounding, unless the report says otherwise.
    pub excess: f64,
}

/// Rows and right-hand sides of a sum of squares |A x − b|².
type Squares = (Vec<Vec<Double>>, Vec<Double>);

/// |A x − b|².
fn square(a: &[Vec<Double>], b: &[Double], x: &[Double]) -> f64 {
    a.iter().zip(b).map(|(row, b)| (dot(row, x) - *b).hi.powi(2)).sum()
}

/// The coefficients of all laws.
struct Optimum {
    best: Solution,
    /// In SI.
    objective: f64,
    undetermined: usize,
}

/// Why a task has no profile.
#[derive(Clone, Debug, PartialEq)]
pub enum Infeasible {
    /// The exact points contradict each other (or the symmetry): the nearest profile misses this one most.
    Point {
        /// Which, in the order of the task.
        index: usize,
        /// Its miss (m/radⁿ).
        by: f64,
    },
    /// The bounds cannot all be kept: at the least they are exceeded by this part of their width, this one among
    /// them.
    Bound {
        /// Which, in the order of the task.
        index: usize,
        /// Its excess (m/radⁿ).
        by: f64,
        /// Where (rad).
        phi: f64,
        /// The bounds that contradict it, and where (rad).
        others: Vec<(usize, f64)>,
        /// Whether they do so only because of the exact points.
        points: bool,
    },
    /// The integral of the squared errors cannot be as small as it has to be.
    Integral {
        /// The least one that the other conditions leave (m²).
        least: f64,
    },
    /// An exact point lies beyond a bound.
    Outside {
        /// Which point, in the order of the task.
        point: usize,
        /// Which bound.
        bound: usize,
        /// Its excess (m/radⁿ).
        by: f64,
    },
    /// The best profile rests all the turn: nothing that is prescribed asks for motion.
    Still {
        /// Where (m).
        at: f64,
    },
    /// The optimisation failed for a numerical reason.
    Numerical(String),
}

impl Task {
    /// The best profile; of several laws the first one's.
    pub fn solve(&self) -> Result<Profile, Infeasible> {
        let profile = self.solve_with(&|_, _| {})?.into_iter().next();
        profile.ok_or_else(|| Infeasible::Numerical("there is no law".to_owned()))
    }

    /// The best profiles, one for each law; `progress` hears how many of how many starts are done.
    pub fn solve_with(&self, progress: Told<'_>) -> Result<Vec<Profile>, Infeasible> {
        let task = self.prepared();
        let scale = task.scale();
        match task.objective {
            Objective::PeakTorque | Objective::ShaftTorque(_) => Ok(vec![task.searched(progress)?]),
            Objective::LongestDwell { .. } | Objective::FewestHarmonics { .. } => {
                task.as_chebyshev(progress)?.0.solve_with(progress)
            }
            _ if task.integral.is_some() => Ok(task.profiles(&task.within_integral(scale)?, scale)),
            _ if !task.clearances.is_empty() => Ok(task.profiles(&task.clear(scale, progress)?, scale)),
            _ => Ok(task.profiles(&task.optimum(scale, Vec::new())?, scale)),
        }
    }

    /// The task that is solved: an undamped harmonic with its resonance in the range of speeds must not be there at all,
    /// and a sum of peaks has numbers of its own.
    fn prepared(&self) -> Task {
        let mut task = self.clone();
        if let Some(range) = self.speeds.filter(|range| range.damping == 0.0) {
            range.crossed(&self.basis).into_iter().for_each(|k| task.basis = task.basis.without(k));
        }
        if self.objective == Objective::PeakAcceleration && self.basis.of(self.laws.len()).size() == 0 {
            let numbers = self.laws.len()..2 * self.laws.len() - 1;
            task.basis = numbers.fold(task.basis, |basis, law| basis.with_number(law));
        }
        task
    }

    /// The optimum in units of `scale` under the conditions of the task and `further` ones.
    fn optimum(&self, scale: f64, further: Vec<Family>) -> Result<Optimum, Infeasible> {
        let (a, b) = self.samples(scale);
        let goal = if self.is_of_squares() { Goal::Squares(a.clone()) } else { Goal::Level };
        let (families, solutions) =
            (self.families(scale).into_iter().chain(further).collect(), self.equalities(scale)?);
        let found = self.optimum_of(scale, &solutions, families, goal, (a, b))?;
        let discrete =
            matches!(self.objective, Objective::DiscreteLeastSquares { .. } | Objective::DiscreteChebyshev { .. });
        // Between the points nothing is prescribed; over a range all is, and what is not seen is below rounding.
        match found.undetermined > 0 && (discrete || self.ranges.iter().all(|range| range.from == range.to)) {
            true => self.smoothest(scale, &solutions, found),
            false => Ok(found),
        }
    }

    /// Among all optima, where some coefficients are open, the one with the least ∫U″² dφ.
    fn smoothest(&self, scale: f64, solutions: &Solutions, found: Optimum) -> Result<Optimum, Infeasible> {
        let (mut open, families) = (solutions.free.clone(), levels::capped(self.families(scale), found.best.level));
        if self.is_of_squares() {
            // What the squares see stays.
            let seen: Vec<Vec<Double>> = self.samples(scale).0.iter().map(|row| solutions.projected(row)).collect();
            let unseen = Solutions::new(&seen, &vec![Double::default(); seen.len()], open.len(), RANK).free;
            let zero = vec![Double::default(); self.basis.size()];
            open = unseen.iter().map(|direction| solutions.moved(&zero, direction)).collect();
        }
        let solutions = Solutions { particular: found.best.x.clone(), free: open };
        let squares = self.accelerations(scale);
        let smooth = self.optimum_of(scale, &solutions, families, Goal::Squares(squares.0.clone()), squares)?;
        Ok(Optimum { best: Solution { x: smooth.best.x, ..found.best }, ..found })
    }

    /// The least goal under these conditions; without them the squares of (a, b) are least.
    fn optimum_of(
        &self,
        scale: f64,
        solutions: &Solutions,
        families: Vec<Family>,
        goal: Goal,
        (a, b): Squares,
    ) -> Result<Optimum, Infeasible> {
        if work::is_exhausted() {
            return Err(Infeasible::Numerical(EXHAUSTED.to_owned()));
        }
        let nearest = solutions.least_squares(&a, &b);
        let exact: Vec<f64> = self.points.iter().map(|point| point.phi).collect();
        let mut program = Program { basis: &self.basis, solutions, exact: &exact, families, goal };
        let best = match self.speeds {
            None => program.solve(nearest),
            Some(range) => self.at_all_speeds(range, &mut program, nearest),
        };
        let best = best.map_err(|e| e.scaled(scale))?;
        let objective = match &program.goal {
            Goal::Squares(_) => square(&a, &b, &best.x) * scale * scale,
            Goal::Level => best.level * scale,
        };
        let seen = match self.objective {
            Objective::PeakAcceleration | Objective::MeanSquareAcceleration => solutions.free.len(),
            _ => solutions.factors(&a, RANK).rank(),
        };
        Ok(Optimum { undetermined: solutions.free.len() - seen, best, objective })
    }

    /// The profiles of the laws.
    fn profiles(&self, optimum: &Optimum, scale: f64) -> Vec<Profile> {
        let best = &optimum.best;
        let of = |law: usize| {
            let series = self.basis.series(law, &best.x, scale);
            Profile {
                objective: optimum.objective,
                errors: self.only(law).errors(&series),
                series,
                optima: Vec::new(),
                resolution: best.resolution * scale,
                uncertainty: best.uncertainty * scale,
                undetermined: optimum.undetermined,
                excess: best.excess * scale,
            }
        };
        (0..self.laws.len()).map(of).collect()
    }

    /// The part of the task that concerns one law alone.
    pub fn only(&self, law: usize) -> Task {
        Task {
            basis: self.basis.of(law),
            laws: vec![self.laws[law]],
            ranges: self.ranges.iter().filter(|r| r.law == law).map(|r| Range { law: 0, ..r.clone() }).collect(),
            points: self.points.iter().filter(|p| p.law == law).map(|p| Point { law: 0, ..*p }).collect(),
            bounds: self
                .bounds
                .iter()
                .filter(|b| b.is_of(law))
                .map(|b| Bound { of: vec![(0, b.of[0].1)], ..b.clone() })
                .collect(),
            clearances: Vec::new(),
            ..self.clone()
        }
    }

    /// Whether the objective is a sum of squares.
    fn is_of_squares(&self) -> bool {
        use Objective::{DiscreteLeastSquares, LeastSquares, MeanSquareAcceleration};
        matches!(self.objective, LeastSquares | DiscreteLeastSquares { .. } | MeanSquareAcceleration)
    }

    /// The best local optimum of an objective that is not convex.
    fn searched(&self, progress: Told<'_>) -> Result<Profile, Infeasible> {
        let scale = self.scale();
        let smooth = Task { objective: Objective::PeakAcceleration, ..self.clone() }.solve()?;
        let solutions = self.equalities(scale)?;
        let start = self.basis.coefficients(&smooth.series, scale).iter().map(|x| x.hi).collect();
        let families = self.families(scale);
        let peak = smooth.objective / scale;
        let region = Region { basis: &self.basis, solutions: &solutions, families: &families, start, peak };
        let (x, optima, objective) = match self.objective {
            Objective::ShaftTorque(goal) => self.least_shaft_torque(goal.scaled(scale), &region, progress)?,
            _ => {
                let found = region.minimise(self.search, &|x| Some(torque::values(&self.basis, x)), progress)?;
                let objective = torque::peak(&self.basis.series_of(&found.x));
                (found.x, found.optima, objective)
            }
        };
        let absolute = matches!(self.objective, Objective::ShaftTorque(ShaftGoal { relative: false, .. }));
        let unit = if absolute { 1.0 } else { scale * scale };
        let series = self.basis.series_of(&x).scaled(scale);
        let optima = optima.iter().map(|value| value * unit).collect();
        Ok(Profile {
            objective: objective * unit,
            errors: self.errors(&series),
            series,
            optima,
            resolution: smooth.resolution,
            uncertainty: 0.0,
            undetermined: 0,
            excess: smooth.excess,
        })
    }

    /// The least torque of an elastic shaft: from several starts at some speeds, then from the best of them at all
    /// speeds that count.
    fn least_shaft_torque(
        &self,
        goal: ShaftGoal,
        region: &Region,
        progress: Told<'_>,
    ) -> Result<(Vec<f64>, Vec<f64>, f64), Infeasible> {
        let mut speeds = goal.speeds(shaft::SPEEDS);
        let candidates = goal.speeds(8 * shaft::SPEEDS);
        let found = region.minimise(self.search, &|x| goal.values(&self.basis, x, &speeds), progress)?;
        let mut x = found.x;
        if goal.norm == Norm::Peak {
            for _ in 0..SPEED_ROUNDS {
                let series = self.basis.series_of(&x);
                let level = goal.over(&series, &speeds);
                let peak = |w: f64| goal.peak(&series, w);
                let least = level * (1.0 + 1e-4);
                let exceeded: Vec<f64> =
                    local_maxima(&candidates, least, peak).into_iter().filter(|w| peak(*w) > least).collect();
                if exceeded.is_empty() {
                    break;
                }
                speeds.extend(exceeded);
                x = region.improved(&x, &|x| goal.values(&self.basis, x, &speeds))?;
            }
        }
        let objective = goal.over(&self.basis.series_of(&x), &[candidates, speeds].concat());
        Ok((x, found.optima, objective))
    }

    /// The best solution at all speeds of a range: first at some, then also at those where it was worst.
    fn at_all_speeds(
        &self,
        range: SpeedRange,
        program: &mut Program,
        mut centre: Vec<Double>,
    ) -> Result<semi_infinite::Solution, Infeasible> {
        let (of_output, of_cam): (Vec<_>, Vec<_>) = program.families.iter().cloned().partition(|f| f.level != 0.0);
        let response = |eta: f64| Response { damping: range.damping, eta };
        let at = |eta: f64| of_output.iter().cloned().map(move |family| family.behind(Some(response(eta))));
        let candidates = elastic::speeds(self.basis.order(), range);
        // Ends and middle are a start; the exchange adds the speeds that count.
        let mut speeds = vec![range.slowest, 0.5 * (range.slowest + range.fastest), range.fastest];
        for _ in 0..SPEED_ROUNDS {
            program.families = of_cam.iter().cloned().chain(speeds.iter().flat_map(|eta| at(*eta))).collect();
            let best = program.solve(centre)?;
            let cam = self.basis.series(0, &best.x, 1.0);
            let excess = |eta: f64| match elastic::output(&cam, response(eta)) {
                Some(motion) => of_output.iter().map(|f| f.magnitude(&motion)).fold(0.0, f64::max) - best.level,
                None => f64::INFINITY,
            };
            let least = elastic::SOLVED * best.level.abs() + 1e-14;
            let exceeded: Vec<f64> =
                local_maxima(&candidates, least, excess).into_iter().filter(|eta| excess(*eta) > least).collect();
            if exceeded.is_empty() {
                return Ok(best);
            }
            speeds.extend(exceeded);
            centre = best.x;
        }
        Err(Infeasible::Numerical("the speeds that count were not found".to_owned()))
    }

    /// The largest |e₀|, |e₁|, |e₂| of a series in each range, NaN where nothing is prescribed.
    pub fn errors(&self, series: &Fourier) -> Vec<[f64; 3]> {
        let of_range = |range: &Range| {
            std::array::from_fn(|order| match &range.prescribed[order] {
                Some(target) => Window { from: range.from, to: range.to, order, target }.largest(series).value.abs(),
                None => f64::NAN,
            })
        };
        self.ranges.iter().map(of_range).collect()
    }
}

impl Infeasible {
    /// The fault in SI.
    fn scaled(self, scale: f64) -> Self {
        match self {
            Infeasible::Bound { index, by, phi, others, points } => {
                Infeasible::Bound { index, by: by * scale, phi, others, points }
            }
            other => other,
        }
    }
}

/// `points` equally spaced angles from `from` to `to`.
fn grid(from: f64, to: f64, points: usize) -> impl Iterator<Item = f64> {
    let last = if from < to { points.max(2) - 1 } else { 0 };
    (0..=last).map(move |i| if i == last { to } else { from + (to - from) * i as f64 / last as f64 })
}
