//! Harmonic synthesis: the finite Fourier series that fulfils a motion task best (HS profile).
//!
//! A task prescribes the position U or its derivatives U′, U″ in ranges of the drive angle φ, exactly at points, and
//! bounds of any derivative up to U‴. The errors are eₙ = U⁽ⁿ⁾ − Ũ⁽ⁿ⁾, the objectives
//!
//! S1 = Σ ∫ (e₀² + w₁ e₁² + w₂ e₂²) dφ,  S3 = max max(|e₀|, w₁|e₁|, w₂|e₂|),  S5 = max (|e₀| + w₁|e₁| + w₂|e₂|),
//!
//! and the peak of |U″|. Where all ranges are points, S1 is the sum S2 of the source and S3 its S4. Symbols: φ (rad), U (m)
//! (or rad), w₁, w₂ weights (radⁿ) (of S1: squared).
//!
//! Source: Dresig, Vulfson, *Dynamik der Mechanismen*, section 4.6.2, equations (8) to (21), with the signs of the
//! terms in w₂ and the blocks of (12) corrected. The normal equations printed there are not used: their condition
//! grows with a high power of 1/Δφ; the singular values of the sampled functions themselves decide here.

mod advice;
mod banded;
mod basis;
pub mod clearance;
mod conditions;
mod convex;
mod convex_concave;
mod curve;
pub mod deviation;
pub mod elastic;
mod exact;
mod family;
mod feasibility;
pub mod figures;
mod infeasible;
pub mod laws;
mod least_torque;
mod levels;
mod nonlinear;
mod plan;
mod polyhedron;
pub mod printed;
mod report;
mod sampling;
mod semi_infinite;
pub mod shaft;
pub mod shaft_study;
pub mod study;
#[cfg(test)]
mod tests;
pub mod together;
pub mod torque;

pub use basis::{Basis, Response, Symmetry};
pub use curve::Curve;
pub use feasibility::KEPT;
pub use infeasible::UNITS;
pub use nonlinear::{Norm, Search};

use camdrive::drives::Fault;
use camdrive::motion::Fourier;
use clearance::Clearance;
use conditions::Conditions;
use deviation::{Extreme, Window};
use elastic::SpeedRange;
use family::{Family, Term};
use plan::Plan;
use shaft::ShaftGoal;

/// The fault within a study whose work is used up; the study has words of its own.
const EXHAUSTED: &str = "the work of the study is used up";

/// Hears how many of how many parts of a search are done.
pub type Listener<'a> = &'a (dyn Fn(usize, usize) + Sync + 'a);

/// Rounds in which the robust problem takes up speeds.
const SPEED_ROUNDS: usize = 20;

/// A range of the drive angle with what is prescribed there.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Which law, from 0.
    pub law: usize,
    /// First angle (rad).
    pub from: f64,
    /// Last angle (rad), ≥ `from`; if equal, the range is one point, which counts as a sum does.
    pub to: f64,
    /// Ũ, Ũ′, Ũ″; None where free.
    pub prescribed: [Option<Curve>; 3],
    /// Weight of the range in the sums and maxima.
    pub weight: f64,
}

/// U⁽ⁿ⁾(φ) = value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExactPoint {
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
    /// True if it is of this law alone.
    pub fn is_of(&self, law: usize) -> bool {
        self.of.iter().all(|(j, _)| *j == law)
    }

    /// The largest of its limits.
    fn size(&self) -> f64 {
        [self.min, self.max].into_iter().filter(|end| end.is_finite()).fold(0.0, |size, end| size.max(end.abs()))
    }

    /// The conditions of its sides, in units of `scale`.
    fn sides(&self, scale: f64) -> impl Iterator<Item = Family> {
        let sides = [(1.0, self.max), (-1.0, -self.min)].into_iter().filter(|(_, limit)| limit.is_finite());
        sides.map(move |(sign, limit)| {
            let mut family = Family::new(self.from, self.to);
            family.target.add(sign, &self.around.over(scale));
            let term = |&(law, factor): &(usize, f64)| Term { law, order: self.order, factor: sign * factor };
            family.terms = self.of.iter().map(term).collect();
            family.limit = limit / scale;
            family
        })
    }

    /// The least way to a bound, where it is; negative beyond it.
    pub fn reserve(&self, laws: &[Fourier]) -> Extreme {
        let side = |family: Family| {
            let sum = family.combined(|law| Some(laws[law].clone()))?;
            let window = Window { from: self.from, to: self.to, order: 0, target: &family.target };
            let largest = window.maxima(&sum).into_iter().max_by(|a, b| a.value.total_cmp(&b.value));
            largest.map(|extreme| Extreme { value: family.limit - extreme.value, phi: extreme.phi })
        };
        let reserves = self.sides(1.0).filter_map(side);
        let none = Extreme { value: f64::INFINITY, phi: self.from };
        reserves.min_by(|a, b| a.value.total_cmp(&b.value)).unwrap_or(none)
    }
}

/// Criterion by which one profile is better than another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Objective {
    /// S1, integral least squares.
    LeastSquares,
    /// S3, the largest error.
    Chebyshev,
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
    /// The weight of each law in the objective.
    pub laws: Vec<f64>,
    /// Ranges with prescribed motion.
    pub ranges: Vec<Range>,
    /// Exact conditions.
    pub points: Vec<ExactPoint>,
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
    /// Of a cam with an elastic output member: the objective counts behind that member, at
    /// all these speeds (of the Chebyshev objectives only). Points and bounds hold for the cam.
    pub speeds: Option<SpeedRange>,
    /// The search of objectives that are not convex.
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
    /// Errors below this cannot be distinguished from rounding (m); the coefficients are rounded to sixteen digits afterwards.
    pub resolution: f64,
    /// The largest change of a coefficient that this rounding may hide (m).
    pub uncertainty: f64,
    /// The number of free coefficients, which neither the ranges nor the points determine.
    pub undetermined: usize,
    /// Remaining excess of conditions (m/radⁿ): rounding, unless the report says otherwise.
    pub excess: f64,
}

/// The result of the solver of a task.
#[derive(Clone, Debug, PartialEq)]
pub struct Solved {
    /// The task whose optimum it found: the user's, with the longest dwells or the fewest harmonics where its
    /// objective asks for them.
    pub task: Task,
    /// The best profiles, one for each law.
    pub profiles: Vec<Profile>,
    /// On the way to the longest dwell or the fewest harmonics: factor of the widths or harmonics, and the least largest
    /// error with them (m), infinite for none.
    pub tried: Vec<[f64; 2]>,
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
        /// Its angle (rad).
        phi: f64,
        /// The bounds that contradict it, and where (rad).
        others: Vec<(usize, f64)>,
        /// True if they do so only because of the exact points.
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
        /// Its place (m).
        at: f64,
    },
    /// The optimisation failed for a numerical reason.
    Numerical(Fault),
}

impl Task {
    /// The best profile; of several laws the first one's.
    pub fn solve(&self) -> Result<Profile, Infeasible> {
        let profile = self.solve_with(&|_, _| {})?.profiles.into_iter().next();
        profile.ok_or_else(|| Infeasible::Numerical(Fault::new("there is no law")))
    }

    /// The best profiles, one for each law; `progress` hears how many of how many starts are done.
    pub fn solve_with(&self, progress: Listener<'_>) -> Result<Solved, Infeasible> {
        let task = self.prepared();
        let conditions = &Conditions::new(&task);
        let profiles = match Plan::of(&task) {
            Plan::Convex => convex::optimum(conditions, Vec::new())?.profiles(conditions),
            Plan::WithinIntegral(limit) => levels::within_integral(conditions, limit)?.profiles(conditions),
            Plan::Clear => convex_concave::clear(conditions, progress)?.profiles(conditions),
            Plan::LeastTorque(goal) => vec![least_torque::profile(conditions, goal, progress)?],
            Plan::LongestDwell { tolerance, dwells } => {
                let (task, tried) = levels::longest(&task, tolerance, dwells, progress)?;
                return Ok(Solved { tried, ..task.solve_with(progress)? });
            }
            Plan::FewestHarmonics { tolerance } => {
                let (task, tried) = levels::fewest(&task, tolerance, progress)?;
                return Ok(Solved { tried, ..task.solve_with(progress)? });
            }
        };
        Ok(Solved { task: self.clone(), profiles, tried: Vec::new() })
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

    /// The magnitude of U in the task, in units of which the equations are solved.
    fn scale(&self) -> f64 {
        let of_range = |r: &Range| {
            let size = |order: usize| {
                let p = r.prescribed[order].as_ref()?;
                Some(grid(r.from, r.to, 16).map(|phi| p.at(phi - r.from).abs()).fold(0.0, f64::max))
            };
            (0..3).filter_map(size).fold(0.0, f64::max)
        };
        let ranges = self.ranges.iter().map(of_range);
        let points = self.points.iter().map(|p| p.value.abs());
        let bounds = self.bounds.iter().flat_map(|b| [b.min.abs(), b.max.abs()]).filter(|v| v.is_finite());
        let scale = ranges.chain(points).chain(bounds).fold(0.0, f64::max);
        if scale > 0.0 { scale } else { 1.0 }
    }

    /// The part of the task that concerns one law alone.
    pub fn only(&self, law: usize) -> Task {
        Task {
            basis: self.basis.of(law),
            laws: vec![self.laws[law]],
            ranges: self.ranges.iter().filter(|r| r.law == law).map(|r| Range { law: 0, ..r.clone() }).collect(),
            points: self.points.iter().filter(|p| p.law == law).map(|p| ExactPoint { law: 0, ..*p }).collect(),
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

    /// max |U − Ũ| over all ranges.
    pub fn largest_error(&self, series: &Fourier) -> f64 {
        self.errors(series).iter().map(|e| e[0]).filter(|e| !e.is_nan()).fold(0.0, f64::max)
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
