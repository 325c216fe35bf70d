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
mod conditions;
pub mod deviation;
pub mod elastic;
mod exact;
mod family;
mod feasibility;
pub mod figures;
pub mod laws;
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
pub mod torque;

pub use basis::{Basis, Response, Symmetry};
pub use nonlinear::{Norm, Search};

use crate::search::local_maxima;
use camdrive::motion::Fourier;
use camdrive::numerics::double_double::Double;
use deviation::Window;
use elastic::SpeedRange;
use exact::{RANK, dot};
use nonlinear::Region;
use semi_infinite::{Goal, Program};
use shaft::ShaftGoal;

/// The order of the highest derivative that a task can speak of, plus one.
const ORDERS: usize = 4;

/// Rounds in which the robust problem takes up speeds.
const SPEED_ROUNDS: usize = 20;

/// A polynomial in the angle from the beginning of a range: Σ cⱼ (φ − φ_from)ʲ.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polynomial(pub Vec<f64>);

impl Polynomial {
    /// The value at `x`.
    pub fn at(&self, x: f64) -> f64 {
        self.0.iter().rev().fold(0.0, |sum, c| sum * x + c)
    }

    /// The value at `x` to 30 digits.
    fn exactly_at(&self, x: Double) -> Double {
        self.0.iter().rev().fold(Double::default(), |sum, c| sum * x + Double::from(*c))
    }

    /// The derivative.
    pub fn derivative(&self) -> Self {
        Polynomial(self.0.iter().enumerate().skip(1).map(|(j, c)| j as f64 * c).collect())
    }
}

/// A range of the drive angle with what is prescribed there.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// First angle (rad).
    pub from: f64,
    /// Last angle (rad), > `from`.
    pub to: f64,
    /// Ũ, Ũ′, Ũ″; None where free.
    pub prescribed: [Option<Polynomial>; 3],
    /// Weight of the range in the sums and maxima.
    pub weight: f64,
}

/// U⁽ⁿ⁾(φ) = value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// φ (rad).
    pub phi: f64,
    /// n ≤ 3.
    pub order: usize,
    /// The value (m/radⁿ).
    pub value: f64,
}

/// min ≤ U⁽ⁿ⁾ − Ũ⁽ⁿ⁾ ≤ max for `from` ≤ φ ≤ `to`.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// First angle (rad).
    pub from: f64,
    /// Last angle (rad).
    pub to: f64,
    /// n ≤ 3.
    pub order: usize,
    /// Ũ⁽ⁿ⁾.
    pub around: Polynomial,
    /// Least value (m/radⁿ); −∞ for none.
    pub min: f64,
    /// Largest value (m/radⁿ); ∞ for none.
    pub max: f64,
}

/// What makes one profile better than another.
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
    /// The largest |U″| over the whole turn.
    PeakAcceleration,
    /// The largest |U′U″| over the whole turn: not convex, so that the result is the best local optimum of a search.
    PeakTorque,
    /// The torque in an elastic input shaft; not convex either.
    ShaftTorque(ShaftGoal),
}

/// A motion task.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// The functions that the profile is made of.
    pub basis: Basis,
    /// What is prescribed.
    pub ranges: Vec<Range>,
    /// What holds exactly.
    pub points: Vec<Point>,
    /// What must not be exceeded.
    pub bounds: Vec<Bound>,
    /// What is made small.
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
    /// The largest |e₀|, |e₁|, |e₂| in each range, NaN where nothing is prescribed.
    pub errors: Vec<[f64; 3]>,
    /// What each start of a search has led to; empty where the optimum is the only one.
    pub optima: Vec<f64>,
    /// Errors below this cannot be told from rounding (m); the coefficients are rounded to sixteen digits afterwards.
    pub resolution: f64,
    /// The largest change of a coefficient that this rounding may hide (m).
    pub uncertainty: f64,
    /// How many coefficients neither the ranges nor the points determine; so many of them are free.
    pub undetermined: usize,
    /// By how much conditions may still be exceeded (m/radⁿ): rounding, but where it is said.
    pub excess: f64,
}

/// Why a task has no profile.
#[derive(Clone, Debug, PartialEq)]
pub enum Infeasible {
    /// The exact points contradict each other (or the symmetry): the nearest profile misses this one most.
    Point {
        /// Which, in the order of the task.
        index: usize,
        /// By how much (m/radⁿ).
        by: f64,
    },
    /// The bounds cannot all be kept: at the least they are exceeded by this part of their width, this one among
    /// them.
    Bound {
        /// Which, in the order of the task.
        index: usize,
        /// By how much (m/radⁿ).
        by: f64,
        /// Where (rad).
        phi: f64,
        /// The bounds that contradict it, and where (rad).
        others: Vec<(usize, f64)>,
        /// Whether they do so only because of the exact points.
        points: bool,
    },
    /// An exact point lies beyond a bound.
    Outside {
        /// Which point, in the order of the task.
        point: usize,
        /// Which bound.
        bound: usize,
        /// By how much (m/radⁿ).
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
    /// The best profile.
    pub fn solve(&self) -> Result<Profile, Infeasible> {
        self.solve_with(&|_, _| {})
    }

    /// The same; `progress` hears how many of how many starts are done.
    pub fn solve_with(&self, progress: &dyn Fn(usize, usize)) -> Result<Profile, Infeasible> {
        if matches!(self.objective, Objective::PeakTorque | Objective::ShaftTorque(_)) {
            return self.searched(progress);
        }
        if let Some(range) = self.speeds
            && range.damping == 0.0
            && let Some(k) =
                self.basis.harmonics().find(|k| (range.slowest..=range.fastest).contains(&(1.0 / *k as f64)))
        {
            // Without damping a harmonic with its resonance in the range must not be there at all.
            return Task { basis: self.basis.without(k), ..self.clone() }.solve();
        }
        let scale = self.scale();
        let solutions = self.equalities(scale)?;
        let (a, b) = self.samples(scale);
        let nearest = solutions.least_squares(&a, &b);
        let squares = matches!(self.objective, Objective::LeastSquares | Objective::DiscreteLeastSquares { .. });
        let goal = if squares { Goal::Squares(a.clone()) } else { Goal::Level };
        let families = self.families(scale);
        let exact: Vec<f64> = self.points.iter().map(|point| point.phi).collect();
        let mut program = Program { basis: &self.basis, solutions: &solutions, exact: &exact, families, goal };
        let best = match self.speeds {
            None => program.solve(nearest),
            Some(range) => self.at_all_speeds(range, &mut program, nearest),
        };
        let best = best.map_err(|e| e.scaled(scale))?;
        let objective = match squares {
            true => a.iter().zip(&b).map(|(row, b)| (dot(row, &best.x) - *b).hi.powi(2)).sum::<f64>() * scale * scale,
            false => best.level * scale,
        };
        let series = self.basis.series(&best.x, scale);
        let judged = !matches!(self.objective, Objective::PeakAcceleration);
        let seen = if judged { solutions.factors(&a, RANK).rank() } else { solutions.free.len() };
        Ok(Profile {
            objective,
            errors: self.errors(&series),
            series,
            optima: Vec::new(),
            resolution: best.resolution * scale,
            uncertainty: best.uncertainty * scale,
            undetermined: solutions.free.len() - seen,
            excess: best.excess * scale,
        })
    }

    /// The best local optimum of an objective that is not convex.
    fn searched(&self, progress: &dyn Fn(usize, usize)) -> Result<Profile, Infeasible> {
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
        progress: &dyn Fn(usize, usize),
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
            let cam = self.basis.series(&best.x, 1.0);
            let excess = |eta: f64| match elastic::output(&cam, response(eta)) {
                Some(motion) => of_output.iter().map(|f| f.magnitude(&motion)).fold(0.0, f64::max) - best.level,
                None => f64::INFINITY,
            };
            let least = 1e-7 * best.level.abs() + 1e-14;
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
    /// The same in SI.
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
    let last = points.max(2) - 1;
    (0..=last).map(move |i| if i == last { to } else { from + (to - from) * i as f64 / last as f64 })
}
