//! The answer of a synthesis: the results, the restrictions they keep, what would improve them, the certainty.

use super::basis::{Basis, Symmetry};
use super::deviation::Extreme;
use super::elastic::SpeedRange;
use super::infeasible::degrees;
use super::laws::symmetric_dwells;
use super::report::{ORDERS, TORQUE};
use super::sampling::ANGLES;
use super::study::{HIGHEST, Method, Study};
use super::together::Together;
use super::{Objective, Task};
use crate::report::rounding::admissible;
use crate::report::terminal::shown;
use crate::report::unit::{DEG, MM, NM, PERCENT, RPM};
use crate::report::{Advice, Claim, Level, Setting, Verdict, WrittenValue};
use crate::text::{counted, number};
use std::f64::consts::FRAC_PI_2;

/// A larger part of the motion is no deviation any more.
const FAILED_TASK: f64 = 0.1;

/// Significant digits of a speed that is reached.
const DIGITS: usize = 3;

/// The rounding of a deviation that another number of harmonics yields, relative to it.
const RESERVE: f64 = 1e-6;

/// An exact point within this angle of an axis of the symmetry, but not on it, is implausible (rad).
const BESIDE: f64 = 1e-4;

impl Together {
    /// The answer.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict::default();
        let [first, ..] = &self.studies[..] else { return verdict };
        if let Some(goal) = self.goal(first) {
            verdict.result(Level::Good, goal);
        }
        let errors: Vec<String> = self.studies.iter().filter_map(Study::largest_error).collect();
        if !errors.is_empty() {
            let speeds = first.speeds().map_or(String::new(), |speeds| format!(" from {speeds}"));
            verdict.result(Level::Good, format!("The task is met to {}{speeds}.", errors.join(", ")));
        }
        first.at_speeds(&mut verdict);
        first.in_shaft(&mut verdict);
        let bounds = self.bounds().into_iter();
        let tightest = bounds.min_by(|(_, a, x), (_, b, y)| (x.value / a.size()).total_cmp(&(y.value / b.size())));
        if let Some((name, bound, Extreme { value, phi })) = tightest {
            let (level, are) = if value >= 0.0 { (Level::Good, "kept") } else { (Level::Bad, "not all kept") };
            let (reserve, at) = (shown(value, &ORDERS[bound.order.min(3)]), shown(phi, &DEG));
            verdict.result(level, format!("The bounds are {are}, the tightest by {reserve} (`{name}` at {at})."));
            if value <= 0.0 {
                verdict.advice("These bounds limit the result. Relax them for a better one.");
            }
        }
        for (clearance, least) in self.clearances() {
            let [a, b] = clearance.laws.map(|law| self.name_of(law));
            let [near, asked] = [least.value, clearance.distance].map(|d| shown(d, &MM));
            let at = shown(least.phi, &DEG);
            verdict.result(Level::Good, format!("{a} and {b} come as near as {near} at {at}; {asked} is asked for."));
        }
        self.studies.iter().for_each(|study| study.limits(&mut verdict));
        if let Some((harmonics, error)) = first.more_harmonics() {
            let within = shown(error, &MM);
            let text = format!("If that is too much, {harmonics} harmonics meet these dwells within {within}.");
            let claim = Claim::Deviation { at_most: error * (1.0 + RESERVE) };
            verdict.advice(Advice::new(text).set([Setting::new("harmonics", harmonics)], claim));
        }
        verdict.certainty(self.certainty(first));
        verdict.certainty.extend(first.nonlinear());
        verdict
    }

    /// The quantity that was optimised; errors have their own sentence.
    fn goal(&self, first: &Study) -> Option<String> {
        let task = &first.assignment.task;
        let width = |i: usize| format!("{}° (`{}`)", degrees(task.ranges[i].to - task.ranges[i].from), first.range(i));
        let peak = |study: &Study| format!("{}{}", shown(study.peaks[2].value.abs(), &ORDERS[2]), study.of_law());
        let join = |list: Vec<String>| list.join(", ");
        Some(match first.asked {
            Objective::LongestDwell { dwells: [from, end], .. } => {
                format!("The longest dwell is {}.", join((from..end).map(width).collect()))
            }
            Objective::FewestHarmonics { .. } => format!("{} harmonics are the fewest.", first.tried.last()?[0]),
            Objective::PeakAcceleration | Objective::MeanSquareAcceleration => {
                format!("The acceleration |U″| reaches {}.", join(self.studies.iter().map(peak).collect()))
            }
            Objective::PeakTorque => format!("|U′U″| reaches {}.", shown(first.motion.objective, &TORQUE)),
            _ => return None,
        })
    }

    fn certainty(&self, first: &Study) -> String {
        let (task, optima) = (&self.assignment.task, &first.motion.optima);
        let best = optima.iter().copied().fold(f64::INFINITY, f64::min);
        // Local optima of equal height to four digits are one.
        let same = optima.iter().filter(|o| **o < best * (1.0 + 1e-4)).count();
        let worst = number(optima.iter().copied().fold(0.0, f64::max) / best);
        if !optima.is_empty() {
            let (starts, seed) = (optima.len(), task.search.seed);
            format!(
                "Not convex: the best of {starts} starts (seed {seed}), to which {same} led, the worst to {worst} times its \
                 value; more `starts` may find a better one."
            )
        } else if !task.clearances.is_empty() {
            "Not convex: the best result of two searches, one on each side of where the tools are nearest.".to_owned()
        } else if self.assignment.elasticity.is_some_and(|given| given.method == Method::Recipe) {
            "The motion is optimal, but its inversion need not be. `robust` may reach further.".to_owned()
        } else {
            "This is the global optimum for these harmonics.".to_owned()
        }
    }
}

impl Study {
    /// The speeds at which the output is looked at.
    pub(super) fn speeds(&self) -> Option<String> {
        let (behind, given) = (self.elastic.as_ref()?, self.assignment.elasticity.as_ref()?);
        Some(admissible(&[behind.looked_at.map(|eta| eta * given.w0)], &RPM))
    }

    /// "0.01 mm (`dwell[1]`)", of the lowest derivative that is prescribed.
    fn largest_error(&self) -> Option<String> {
        let of = |order: usize| {
            let errors = self.delivered().iter().map(|e| e[order]).enumerate().filter(|(_, e)| e.is_finite());
            errors.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, error)| (order, i, error))
        };
        let (order, i, error) = (0..3).find_map(of)?;
        let least = if order == 0 { self.motion.resolution } else { 0.0 };
        Some(format!("{} (`{}`)", shown(error.max(least), &ORDERS[order]), self.range(i)))
    }

    /// Speeds of an elastic output member.
    fn at_speeds(&self, verdict: &mut Verdict) {
        let (Some(behind), Some(given)) = (&self.elastic, &self.assignment.elasticity) else { return };
        let rpm = |eta: f64| shown(eta * given.w0, &RPM);
        let fastest = given.fastest.map(|w| w / given.w0);
        // A speed that is reached.
        let up_to = |eta: f64| WrittenValue::rounded(eta * given.w0, &RPM, DIGITS, false);
        let within = shown(given.tolerance.unwrap_or(f64::NAN), &MM);
        match behind.reached {
            None if given.tolerance.is_some() => {
                let slowest = shown(given.slowest, &RPM);
                let text = format!("`elasticity.tolerance` of {within} cannot be kept, not even at {slowest}.");
                verdict.result(Level::Bad, text).advice("Take more harmonics, shorter ranges or a wider tolerance.");
            }
            Some(eta) if fastest.is_some_and(|fastest| eta < fastest) => {
                verdict.result(Level::Mind, format!("It stays within {within} up to {}.", up_to(eta)));
            }
            _ => (),
        }
        if behind.worst.is_some_and(|worst| worst > FAILED_TASK * self.way()) {
            let way = shown(self.way(), &MM);
            let text = format!("The errors are as large as the task, which spans {way}: this is not its motion.");
            verdict.result(Level::Bad, text).advice("Lower `fastest`.");
        }
        let last = fastest.or(behind.reached).unwrap_or(0.0);
        let crossed = SpeedRange { fastest: last, ..given.range() }.crossed(&self.assignment.task.basis);
        if !crossed.is_empty() && given.method == Method::Robust {
            let named = |k: &usize| format!("{} (harmonic {k})", rpm(1.0 / *k as f64));
            let list = crossed.iter().map(named).collect::<Vec<_>>().join(", ");
            let text = format!("The speeds cross resonances at {list}. The cam omits these harmonics.");
            verdict.result(Level::Mind, text);
        }
        let admissible = given.amplitude.unwrap_or(f64::INFINITY);
        let refused = behind.resonances.iter().find(|r| r.amplitude > admissible).map(|r| {
            let (k, size, limit) = (r.harmonic, shown(r.amplitude, &MM), shown(admissible, &MM));
            (r.eta, format!("harmonic {k} resonates with {size}; {limit} is admissible"))
        });
        let left = behind
            .reached
            .filter(|eta| *eta < HIGHEST)
            .map(|eta| (eta, format!("the output deviates by more than {within}")));
        // The slower one governs.
        if let Some((eta, why)) = refused.into_iter().chain(left).min_by(|a, b| a.0.total_cmp(&b.0)) {
            verdict.result(Level::Good, format!("The speeds end at {}: above, {why}.", up_to(eta)));
        }
        if given.method == Method::Robust && given.damping > 0.0 && self.assignment.task.basis.is_even() {
            verdict.advice(
                "Let the cam lead its damped output, to reach further: `half_wave` instead of `even_half_wave`, `none` \
                 instead of `even`.",
            );
        }
    }

    /// The torque in an elastic shaft.
    fn in_shaft(&self, verdict: &mut Verdict) {
        let Some(shaft) = &self.shaft else { return };
        let torque = shown(shaft.laws[0].points.iter().map(|p| p[1]).fold(0.0, f64::max), &NM);
        let twice = shaft.laws[0].exceeded[1];
        let twice = twice
            .map_or("at no speed".to_owned(), |w| format!("from {} on", WrittenValue::rounded(w, &RPM, DIGITS, false)));
        let text = format!("The shaft torque reaches {torque}; {twice} it is more than twice the kinetostatic one.");
        verdict.result(Level::Good, text);
        if let [(w, _), ..] = &shaft.faults[..] {
            let (count, first) = (counted(shaft.faults.len(), "speed"), shown(*w, &RPM));
            verdict.result(Level::Bad, format!("There is no stable periodic motion at {count}, the first {first}."));
        }
    }

    /// The difference of the torques of the nonlinear and of the linear drive.
    fn nonlinear(&self) -> Option<String> {
        let nonlinear = self.shaft.iter().flat_map(|shaft| &shaft.nonlinear);
        let differences = nonlinear.filter_map(|at| Some((at, at.difference()?)));
        let (at, difference) = differences.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let (percent, w) = (shown(difference, &PERCENT), shown(at.w, &RPM));
        let [torque, linear] = [(1.0 + difference) * at.linear, at.linear].map(|torque| shown(torque, &NM));
        Some(format!(
            "The largest torque of the nonlinear drive differs by at most {percent}: at {w} it is {torque} instead of {linear}."
        ))
    }

    /// Adds what the task or the numbers leave open.
    fn limits(&self, verdict: &mut Verdict) {
        let (task, motion) = (&self.assignment.task, &self.motion);
        if motion.undetermined > 0 {
            let (all, free) = (task.basis.size(), motion.undetermined);
            verdict.result(Level::Mind, format!("The task leaves {free} of {all} coefficients free."));
            verdict.advice("Add `[[point]]`, or take fewer `harmonics` or more `symmetry`.");
        }
        let highest = task.basis.order().max(1) as f64;
        for (point, name) in task.points.iter().zip(&self.assignment.names.points) {
            let row = task.basis.row(point.law, point.phi, point.order, None);
            let size = row.iter().fold(0.0_f64, |size, value| size.max(value.hi.abs()));
            if (ANGLES..BESIDE).contains(&(size / highest.powi(point.order as i32 + 1))) {
                let axis = degrees((point.phi / FRAC_PI_2).round() * FRAC_PI_2);
                let u = "U".to_owned() + &"′".repeat(point.order);
                let text = format!(
                    "The symmetry alone decides {u} at {axis}°; `{name}`, close to it, prescribes the next derivative there."
                );
                verdict.result(Level::Mind, text).advice(format!("If the axis is meant, write \"{axis} deg\"."));
            }
        }
        let largest = motion.series.a.iter().chain(&motion.series.b).fold(0.0_f64, |largest, c| c.abs().max(largest));
        let rounding = f64::EPSILON * largest;
        let errors =
            !matches!(task.objective, Objective::PeakAcceleration | Objective::PeakTorque | Objective::ShaftTorque(_));
        if errors && !task.ranges.is_empty() && task.largest_error(&motion.series) < 4.0 * rounding {
            verdict.advice(
                "The error is below rounding: take fewer harmonics, or make the `peak_acceleration` small within a `tolerance`.",
            );
        }
        // Each coefficient brings its rounding, enlarged by its order in U′ and once more in U″.
        if motion.excess > task.basis.size() as f64 * highest.powi(2) * rounding {
            let excess = shown(motion.excess, &MM);
            verdict.certainty(format!(
                "Conditions are kept to {excess}: their extremes are too flat or too close together."
            ));
        }
    }

    /// The next number of harmonics of two dwells opposite to each other, and the error (m) that they leave.
    fn more_harmonics(&self) -> Option<(usize, f64)> {
        let task = &self.assignment.task;
        let errors = matches!(self.asked, Objective::LeastSquares | Objective::Chebyshev) && self.elastic.is_none();
        let of_u_alone = task.ranges.iter().all(|range| range.prescribed[1].is_none() && range.prescribed[2].is_none());
        let alone = errors && of_u_alone && task.points.is_empty() && task.bounds.is_empty();
        symmetric_dwells(task).filter(|_| alone)?;
        let curve = self.widths.iter().find(|curve| curve.order > task.basis.order())?;
        let symmetry = Symmetry { even: task.basis.is_even(), half_wave: task.basis.harmonics().all(|k| k % 2 == 1) };
        let more = Task { basis: Basis::new(curve.order, symmetry), ..task.clone() };
        let error = more.largest_error(&more.solve().ok()?.series);
        (error < 0.5 * task.largest_error(&self.motion.series)).then_some((curve.order, error))
    }

    /// Between which U the ranges prescribe.
    fn way(&self) -> f64 {
        let values = self.assignment.task.ranges.iter().flat_map(|range| {
            let target = range.prescribed[0].as_ref();
            target.into_iter().flat_map(|target| [0.0, range.to - range.from].map(|x| target.at(x)))
        });
        let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], u| [a.min(u), b.max(u)]);
        (high - low).max(0.0)
    }
}
