//! A synthesis with all that is to be known of its result.

use super::deviation::{self, Extreme};
use super::elastic::{self, Resonance, SpeedRange};
use super::laws::{self, Rival, as_rival, symmetric_dwells};
use super::printed::Cubics;
use super::shaft::ShaftGoal;
use super::shaft_study::{self, Shafted};
use super::{Basis, Curve, Infeasible, Listener, Objective, Profile, Range, Response, Solved, Symmetry, Task};
use crate::Progress;
use crate::harmonic_analysis::without_rounding;
use crate::text::number;
use camdrive::drives::Fault;
use camdrive::motion::Fourier;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;

/// Content of a task file.
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment {
    /// A C identifier, as the name of a scene.
    pub name: String,
    /// One sentence of the user, or nothing.
    pub description: String,
    /// The length in which the task counts (m); 1 where it gives lengths.
    pub unit: f64,
    /// The task.
    pub task: Task,
    /// User's names of its parts.
    pub names: Names,
    /// An elastic output member.
    pub elasticity: Option<Elasticity>,
    /// An elastic input shaft.
    pub shaft: Option<ShaftGoal>,
    /// A scene whose cam is to be replaced.
    pub scene: Option<PathBuf>,
    /// The files of tables that the task names.
    pub files: Vec<PathBuf>,
}

/// Names of ranges, points and bounds of a task in its file, such as `dwell[2]` and `dwell[2].tolerance`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Names {
    /// One for each law; empty where there is one law only.
    pub laws: Vec<String>,
    /// One for each range.
    pub ranges: Vec<String>,
    /// One for each point.
    pub points: Vec<String>,
    /// One for each bound.
    pub bounds: Vec<String>,
}

/// The treatment of an elastic output member.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The least largest error over angles and speeds.
    Robust,
    /// The motion is synthesised and inverted at one speed, 4.6.2 (5) with damping.
    Recipe,
    /// Not at all: it is only looked at.
    None,
}

/// An elastic output member and what is asked of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elasticity {
    /// ω₀ (rad/s).
    pub w0: f64,
    /// δ (1).
    pub damping: f64,
    /// Least speed (rad/s).
    pub slowest: f64,
    /// Largest speed (rad/s); None: as far as the tolerance goes.
    pub fastest: Option<f64>,
    /// Largest deviation (m).
    pub tolerance: Option<f64>,
    /// The treatment of an elastic output member.
    pub method: Method,
    /// Admissible amplitude of a resonance (m).
    pub amplitude: Option<f64>,
}

/// The result.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// The task of the user.
    pub assignment: Assignment,
    /// The best motion without regard to elasticity.
    pub motion: Profile,
    /// On the way to the longest dwell or the fewest harmonics: factor of the widths or harmonics, and the least largest
    /// error with them (m), infinite for none.
    pub tried: Vec<[f64; 2]>,
    /// The objective as it was asked for.
    pub asked: Objective,
    /// The profile of the cam.
    pub cam: Fourier,
    /// max |U⁽ⁿ⁾| of the cam, n = 0 … 3 (m/radⁿ).
    pub peaks: [Extreme; 4],
    /// The cam with its figures, then the standard laws where they apply.
    pub rivals: Vec<Rival>,
    /// The cubics of the source, where they are for this task.
    pub cubics: Option<Cubics>,
    /// Behind the elastic output member.
    pub elastic: Option<Behind>,
    /// In front of the cam an elastic shaft.
    pub shaft: Option<Shafted>,
    /// Dwell error over dwell width, where the dwells are symmetric.
    pub widths: Vec<Widths>,
}

impl Study {
    /// The errors of what is delivered: of the output at all speeds behind an elastic member, else of the motion.
    pub(super) fn delivered(&self) -> &[[f64; 3]] {
        self.elastic.as_ref().map_or(&self.motion.errors, |behind| &behind.over_speeds)
    }
}

/// Motion behind an elastic output member that the cam drives.
#[derive(Clone, Debug, PartialEq)]
pub struct Behind {
    /// η_opt of the recipe.
    pub optimum: Option<f64>,
    /// The largest η with the deviation within the tolerance from the slowest speed on; None if not even there.
    pub reached: Option<f64>,
    /// The largest deviation over the range of speeds that was asked for (m).
    pub worst: Option<f64>,
    /// The objective of the robust problem: behind the member, at all its speeds.
    pub objective: Option<f64>,
    /// The speeds η that `over_speeds` looks at: the given ones, else the reached ones.
    pub looked_at: [f64; 2],
    /// The largest |y⁽ⁿ⁾ − Ũ⁽ⁿ⁾| in each range over these speeds, NaN where nothing is prescribed.
    pub over_speeds: Vec<[f64; 3]>,
    /// `over_speeds` at rest, where y is the cam's U.
    pub at_rest: Vec<[f64; 3]>,
    /// The output at these speeds, for its envelope.
    pub outputs: Vec<Fourier>,
    /// (η, max |y − Ũ| (m)) of each rival.
    pub curves: Vec<Vec<[f64; 2]>>,
    /// `reached` of each rival.
    pub reaches: Vec<Option<f64>>,
    /// The resonances up to η = 1.
    pub resonances: Vec<Resonance>,
}

/// Dwell error over dwell width for one number of harmonics (Bild 4.24).
#[derive(Clone, Debug, PartialEq)]
pub struct Widths {
    /// K.
    pub order: usize,
    /// Full width of a dwell (rad), its error by Chebyshev's and by Gauss's objective, relative to the stroke.
    pub points: Vec<[f64; 3]>,
}

/// A cam, η_opt and the objective of the robust problem.
type Cam = (Fourier, Option<f64>, Option<f64>);

/// η up to which speeds are looked at: the resonance of the first harmonic.
pub(super) const HIGHEST: f64 = 1.0;

/// The highest harmonic whose resonance a curve over the speed shows.
const CURVE: usize = 24;

/// A profile whose |U′| is below this part of its height rests: angles that are off by a rounding leave no more. At the
/// height 0 the numbers of the task count, a few roundings of them.
const STILL: f64 = 1e-9;

/// Widths of Bild 4.24: 5° to 170° in steps of 5°.
const WIDTHS: usize = 34;

impl Assignment {
    /// The profiles of all laws with their reports.
    pub(super) fn studies(&self, progress: &(dyn Fn(Progress) + Sync)) -> Result<Vec<Study>, Infeasible> {
        let profile = |done, total| progress(Progress { done, total, stage: "profile" });
        profile(0, 1);
        let Solved { task, profiles, tried } = self.task.solve_with(&profile)?;
        let solved = Assignment { task, ..self.clone() };
        let of = |(law, motion)| solved.of_law(law).study_of(motion, (self.task.objective, tried.clone()), progress);
        profiles.into_iter().enumerate().map(of).collect()
    }

    /// The part that concerns one law alone.
    fn of_law(&self, law: usize) -> Self {
        let Some(name) = self.names.laws.get(law) else { return self.clone() };
        let (task, names) = (&self.task, &self.names);
        let kept = |list: &[String], is_kept: &dyn Fn(usize) -> bool| {
            list.iter().enumerate().filter(|(i, _)| is_kept(*i)).map(|(_, name)| name.clone()).collect()
        };
        let names = Names {
            laws: vec![name.clone()],
            ranges: kept(&names.ranges, &|i| task.ranges[i].law == law),
            points: kept(&names.points, &|i| task.points[i].law == law),
            bounds: kept(&names.bounds, &|i| task.bounds[i].is_of(law)),
        };
        Assignment { name: format!("{}_{name}", self.name), task: task.only(law), names, ..self.clone() }
    }

    /// The profile and its report.
    fn study_of(
        &self,
        mut motion: Profile,
        (asked, tried): (Objective, Vec<[f64; 2]>),
        progress: &(dyn Fn(Progress) + Sync),
    ) -> Result<Study, Infeasible> {
        let stage = |stage| progress(Progress { done: 0, total: 1, stage });
        motion.series = without_rounding(motion.series);
        let rest = motion.series.a[0];
        if deviation::peak(&motion.series, 1).value.abs() <= STILL * rest.abs().max(1e-6 * self.task.scale()) {
            return Err(Infeasible::Still { at: rest });
        }
        let (cam, optimum, robust) = match &self.elasticity {
            Some(elasticity) => {
                stage("elasticity");
                self.elastic_cam(elasticity, &motion)?
            }
            None => (motion.series.clone(), None, None),
        };
        let cam = without_rounding(cam);
        stage("laws");
        let mut rivals = vec![as_rival("harmonic synthesis", &cam)];
        rivals.extend(laws::rivals(&self.task));
        stage("speeds");
        let elastic = self.elasticity.as_ref().map(|elasticity| self.behind(elasticity, &rivals, optimum, robust));
        let shaft = self.shaft.map(|goal| shaft_study::study(goal, &rivals));
        let widths = match symmetric_dwells(&self.task) {
            Some(_) => widths(&|done, total| progress(Progress { done, total, stage: "widths" }))?,
            None => Vec::new(),
        };
        Ok(Study {
            cubics: Cubics::beside(&motion.series, &self.task),
            peaks: std::array::from_fn(|order| deviation::peak(&cam, order)),
            assignment: self.clone(),
            motion,
            tried,
            asked,
            cam,
            rivals,
            elastic,
            shaft,
            widths,
        })
    }

    /// The cam for an elastic output member, η_opt where one was chosen, and the objective of the robust problem.
    fn elastic_cam(&self, given: &Elasticity, motion: &Profile) -> Result<Cam, Infeasible> {
        let range = given.range();
        match given.method {
            Method::None => Ok((motion.series.clone(), None, None)),
            Method::Recipe => {
                let recipe = match given.tolerance {
                    Some(tolerance) => elastic::recipe(&self.task, &motion.series, range, tolerance, given.damping),
                    None => elastic::recipe_for(&self.task, &motion.series, range),
                };
                let fault = "`elasticity.tolerance`: even at the slowest speed the deviation of the profile exceeds it; \
                             take more harmonics or a wider tolerance";
                let recipe = recipe.ok_or_else(|| Infeasible::Numerical(Fault::new(fault)))?;
                Ok((recipe.cam, Some(recipe.optimum), None))
            }
            Method::Robust => match (given.fastest, given.tolerance) {
                (None, Some(tolerance)) => {
                    let profile = elastic::fastest_robust(&self.task, range, tolerance)?.0;
                    Ok((profile.series, None, Some(profile.objective)))
                }
                _ => {
                    if given.damping == 0.0
                        && range.crossed(&self.task.basis).len() == self.task.basis.harmonics().count()
                    {
                        return Err(Infeasible::Numerical(self.standing(given)));
                    }
                    let task = Task { speeds: Some(range), ..self.task.clone() };
                    let profile = task.solve()?;
                    Ok((profile.series, None, Some(profile.objective)))
                }
            },
        }
    }

    /// Why no cam that moves keeps a task at all speeds of a range.
    fn standing(&self, given: &Elasticity) -> Fault {
        let rpm = |eta: f64| number(eta * given.w0 * 60.0 / TAU);
        let first = self.task.basis.harmonics().next().unwrap_or(1);
        let last = self.task.basis.order();
        Fault::new(format!(
            "`elasticity.fastest`: between {} and {} rpm every harmonic of the cam has its resonance kη = 1 (k = {first} \
             at {} rpm), and there is no damping: only a cam that stands still would be admissible",
            rpm(given.range().slowest),
            rpm(given.range().fastest),
            rpm(1.0 / first as f64)
        ))
        .hint(format!(
            "stay below the resonances, from {} rpm of k = {last} on, or give the `damping_ratio`",
            rpm(1.0 / last.max(1) as f64)
        ))
    }

    fn behind(&self, given: &Elasticity, rivals: &[Rival], optimum: Option<f64>, objective: Option<f64>) -> Behind {
        let whole = SpeedRange { fastest: HIGHEST, ..given.range() };
        let response = |eta: f64| Response { damping: given.damping, eta };
        let deviation = |cam: &Fourier, eta: f64| elastic::deviation(&self.task, cam, response(eta));
        let cam = &rivals[0].series;
        // The speeds that are of interest: a little further than what is asked for or reached.
        // The harmonics of a law with dwells do not end: without damping they resonate at speeds as low as one likes.
        let resonates = |i: usize| i > 0 && given.damping == 0.0;
        let reach = |(i, rival): (usize, &Rival)| {
            let tolerance = given.tolerance?;
            match resonates(i) {
                true => (whole.slowest == 0.0).then_some(0.0),
                false => elastic::reachable(&self.task, &rival.series, whole, tolerance),
            }
        };
        let reaches: Vec<Option<f64>> = rivals.iter().enumerate().map(reach).collect();
        let last = given.fastest.map(|w| w / given.w0).into_iter().chain(reaches[0]).fold(0.02, f64::max);
        let shown = SpeedRange { fastest: (1.5 * last).min(HIGHEST.max(last)), ..given.range() };
        let curve = |(i, rival): (usize, &Rival)| {
            if resonates(i) {
                return Vec::new();
            }
            let speeds = elastic::speeds(rival.series.order().min(CURVE), shown);
            speeds.into_iter().map(|eta| [eta, deviation(&rival.series, eta)]).collect()
        };
        let fastest = given.fastest.map(|w| w / given.w0).or(reaches[0]).unwrap_or(given.range().slowest);
        let looked_at = SpeedRange { fastest, ..given.range() };
        let at = |eta: f64| elastic::output(cam, response(eta));
        let outputs: Vec<Fourier> = elastic::speeds(cam.order(), looked_at).into_iter().filter_map(at).collect();
        let larger = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|n| if b[n] > a[n] { b[n] } else { a[n] });
        let at_rest = self.task.errors(cam);
        let worst_of = |worst: Vec<[f64; 3]>, output: &Fourier| {
            worst.into_iter().zip(self.task.errors(output)).map(|(a, b)| larger(a, b)).collect()
        };
        let none = at_rest.iter().map(|errors| errors.map(|e| 0.0 * e)).collect();
        Behind {
            objective,
            looked_at: [looked_at.slowest, looked_at.fastest],
            over_speeds: outputs.iter().fold(none, worst_of),
            at_rest,
            outputs,
            optimum,
            reached: reaches[0],
            worst: given.fastest.map(|_| elastic::worst_over(&self.task, cam, given.range())),
            curves: rivals.iter().enumerate().map(curve).collect(),
            reaches,
            resonances: elastic::resonances(cam, given.damping, HIGHEST),
        }
    }
}

impl Behind {
    /// The least and the largest y at an angle over the speeds looked at.
    pub fn envelope(&self, phi: f64) -> [f64; 2] {
        let values = self.outputs.iter().map(|output| output.at(phi).0[0]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], y| [low.min(y), high.max(y)])
    }
}

impl Elasticity {
    /// η from the slowest to the fastest speed, or to the resonance of the first harmonic.
    pub fn range(&self) -> SpeedRange {
        SpeedRange {
            damping: self.damping,
            slowest: self.slowest / self.w0,
            fastest: self.fastest.map_or(HIGHEST, |w| w / self.w0),
        }
    }
}

/// The symmetric dwell task of section 4.6.4.1: stroke 1, dwells of half-width `half` at 0 and π.
pub fn symmetric_task(order: usize, half: f64, objective: Objective) -> Task {
    let dwell = |centre: f64, u: f64| Range {
        law: 0,
        from: centre - half,
        to: centre + half,
        prescribed: [Some(Curve::polynomial(vec![u])), None, None],
        weight: 1.0,
    };
    Task {
        basis: Basis::new(order, Symmetry { even: true, half_wave: true }),
        ranges: vec![dwell(0.0, 0.5), dwell(PI, -0.5)],
        laws: vec![1.0],
        points: Vec::new(),
        bounds: Vec::new(),
        clearances: Vec::new(),
        integral: None,
        objective,
        weights: [0.0; 2],
        speeds: None,
        search: super::Search::default(),
    }
}

/// Bild 4.24: dwell error over dwell width for K = 3, 5, 7, 9.
pub fn widths(progress: Listener<'_>) -> Result<Vec<Widths>, Infeasible> {
    let orders = [3, 5, 7, 9];
    let mut curves = Vec::new();
    for (i, order) in orders.into_iter().enumerate() {
        let mut points = Vec::new();
        for j in 1..=WIDTHS {
            let width = PI / 36.0 * j as f64;
            let error = |objective| {
                let task = symmetric_task(order, 0.5 * width, objective);
                task.solve().map(|profile| task.largest_error(&profile.series))
            };
            points.push([width, error(Objective::Chebyshev)?, error(Objective::LeastSquares)?]);
            progress(i * WIDTHS + j, orders.len() * WIDTHS);
        }
        curves.push(Widths { order, points });
    }
    Ok(curves)
}
