//! The reference solution of all runs, and its uncertainty.
//!
//! It is the drive's own solver at its finest tolerance, a setting that is not among the compared ones. Its uncertainty comes
//! from repetitions: with other communication points, with another tolerance, and with every parameter changed in its last
//! binary digit, which no computation in this arithmetic can distinguish. The largest difference is the floor below which no
//! error can be resolved.

use super::run::{Grid, Inputs, Interface, Trace};
use super::{Bench, sweep};
use crate::host::Variable;
use camdrive::drives::Fault;
use camdrive::drives::variable::{Causality, Kind, Variability};
use serde::Serialize;

/// The finest tolerance, and a coarser one to compare with.
const TOLERANCES: [f64; 2] = [1e-14, 1e-13];

/// Up to this uncertainty the whole run is compared; beyond it, as in chaotic motion, only the first part with an uncertainty
/// up to [`KNOWN`].
const USEFUL: f64 = 1e-7;
/// See [`USEFUL`].
const KNOWN: f64 = 1e-9;
/// Motions that differ by this share of their largest value have separated.
const SEPARATED: f64 = 1e-3;

/// The reference with its uncertainty.
#[derive(Clone, Debug)]
pub struct Reference {
    /// The outputs at every instant.
    pub trace: Trace,
    /// The largest absolute value of each output over the run.
    pub largest: Vec<f64>,
    /// The last instant at which runs are compared.
    pub until: usize,
    /// The uncertainty up to there.
    pub summary: Summary,
}

/// The reference in words and numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// How it was computed.
    pub settings: String,
    /// The changes, each with the largest relative difference that this made within the time of comparison.
    pub checks: Vec<Check>,
    /// The largest of these differences, at least the unit roundoff: smaller errors cannot be resolved.
    pub floor: f64,
    /// The end of the time of comparison (s).
    pub compared_until: f64,
    /// The time at which two motions whose parameters differ in the last digit have separated (s).
    pub separation: Option<f64>,
}

/// One change that does not affect a trustworthy reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// The change.
    pub change: String,
    /// The largest difference of an output, relative to its largest value.
    pub difference: f64,
}

/// Computes the reference on the instants of the experiment.
pub fn compute(bench: &Bench) -> Result<Reference, Fault> {
    let Bench { interface, grid, .. } = bench;
    // Divisions that no compared setting has. Within a tenth of the interval the polynomial of the input derivatives meets
    // the run-up to rounding.
    let parts = if interface.is_driven() { 10 } else { 2 };
    let grid = Grid { parts, ..*grid };
    let carry_out = |starts: &[(u32, f64)], grid: Grid| bench.run(starts, grid, Inputs::Derivatives);
    let finest = settings(interface, TOLERANCES[0]);
    let trace = carry_out(&finest, grid)?;
    let mut others = vec![(
        "other communication points".to_owned(),
        carry_out(&finest, Grid { parts: 3 * parts, uneven: true, ..grid })?,
    )];
    if interface.find("solver.tolerance").is_some() {
        let text = format!("solver.tolerance = {:e}", TOLERANCES[1]);
        others.push((text, carry_out(&settings(interface, TOLERANCES[1]), grid)?));
    }
    others.push(perturbed(bench, &finest, |starts| carry_out(starts, grid))?);
    let text = match interface.find("solver.tolerance") {
        Some(_) => format!("solver.tolerance = {:e}", TOLERANCES[0]),
        None => "the drive's only setting".to_owned(),
    };
    let step = crate::text::time(grid.communication_step());
    Ok(judge(trace, others, format!("{text}, communication step {step}"), &grid, interface.outputs.len()))
}

/// The settings of the reference: this tolerance, and the method that works to a tolerance.
fn settings(interface: &Interface, tolerance: f64) -> Vec<(u32, f64)> {
    let tolerance = interface.find("solver.tolerance").map(|reference| (reference, tolerance));
    let method = interface.find("solver.method").zip(sweep::methods(interface).first().cloned());
    tolerance.into_iter().chain(method.map(|(reference, (_, number))| (reference, number))).collect()
}

/// The run with every physical parameter changed to the next number; with only the tunable ones changed if that makes the scene
/// impossible (angles of a cycle that no longer fill the turn).
fn perturbed(
    bench: &Bench,
    finest: &[(u32, f64)],
    carry_out: impl Fn(&[(u32, f64)]) -> Result<Trace, Fault>,
) -> Result<(String, Trace), Fault> {
    let changed = |tunable_only: bool| {
        let mut starts = finest.to_vec();
        for Variable { about, reference, start, .. } in &bench.fmu.description().variables {
            let physical = about.causality == Causality::Parameter && !about.name.starts_with("solver.");
            let (Kind::Real { max, .. }, Some(value)) = (&about.kind, start) else { continue };
            let is_changed = physical && (!tunable_only || about.variability == Variability::Tunable);
            if is_changed && *value != 0.0 && value.next_up() <= *max {
                starts.push((*reference, value.next_up()));
            }
        }
        starts
    };
    let text = "every parameter in its last binary digit".to_owned();
    carry_out(&changed(false)).or_else(|_| carry_out(&changed(true))).map(|trace| (text, trace))
}

/// Judges a reference by the runs that should yield the same result.
fn judge(trace: Trace, others: Vec<(String, Trace)>, settings: String, grid: &Grid, outputs: usize) -> Reference {
    let largest: Vec<f64> = (0..outputs)
        .map(|j| trace.values.iter().skip(j).step_by(outputs).fold(0.0, |max: f64, value| max.max(value.abs())))
        .collect();
    let at_instant = |other: &Trace, k: usize| {
        let rows = trace.row(k, outputs).zip(other.row(k, outputs));
        rows.map_or(0.0, |(a, b)| differences(a, b, &largest).fold(0.0, f64::max))
    };
    let over_time: Vec<Vec<f64>> =
        others.iter().map(|(_, other)| (0..=grid.count).map(|k| at_instant(other, k)).collect()).collect();
    let worst = |k: usize| over_time.iter().map(|list| list[k]).fold(0.0, f64::max);
    let first_above = |limit: f64| (0..=grid.count).find(|k| worst(*k) > limit);
    let until = match first_above(USEFUL) {
        None => grid.count,
        // Ten instants at least, so that there is something to compare.
        Some(_) => first_above(KNOWN).unwrap_or(grid.count).saturating_sub(1).max(10.min(grid.count)),
    };
    let separation = first_above(SEPARATED).map(|k| k as f64 * grid.step);
    let checks: Vec<Check> = others
        .into_iter()
        .zip(&over_time)
        .map(|((change, _), list)| Check { change, difference: list[..=until].iter().copied().fold(0.0, f64::max) })
        .collect();
    let floor = checks.iter().map(|check| check.difference).fold(f64::EPSILON, f64::max);
    let compared_until = until as f64 * grid.step;
    Reference { trace, largest, until, summary: Summary { settings, checks, floor, compared_until, separation } }
}

/// |a − b| relative to the largest value of each output; an output that is zero all the time has no relative error.
pub fn differences<'a>(a: &'a [f64], b: &'a [f64], largest: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    a.iter().zip(b).zip(largest).map(|((a, b), largest)| if *largest > 0.0 { (a - b).abs() / largest } else { 0.0 })
}

impl Reference {
    /// The largest relative error of each output of a run, up to instant `until`.
    pub fn errors(&self, trace: &Trace, until: usize) -> Vec<f64> {
        let outputs = self.largest.len();
        let mut errors = vec![0.0_f64; outputs];
        for k in (0..=until).step_by(trace.stride) {
            if let Some((mine, its)) = self.trace.row(k, outputs).zip(trace.row(k, outputs)) {
                for (error, difference) in errors.iter_mut().zip(differences(mine, its, &self.largest)) {
                    *error = error.max(difference);
                }
            }
        }
        errors
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(values: Vec<f64>) -> Trace {
        Trace { values, stride: 1, start_ns: 0.0, run_ns: 0.0, statistics: [0.0; 3] }
    }

    #[test]
    fn a_regular_reference_serves_to_the_end() {
        // Two outputs with the largest values 4 and 2.
        let own = trace(vec![1.0, 0.0, 4.0, -2.0, 3.0, 1.0]);
        let other = trace(vec![1.0, 0.0, 4.0, -2.0 + 2e-12, 3.0 + 2e-12, 1.0]);
        let grid = Grid::new(0.5, 2);
        let reference = judge(own, vec![("a".to_owned(), other.clone())], String::new(), &grid, 2);
        assert_eq!((reference.until, reference.largest.as_slice()), (2, &[4.0, 2.0][..]));
        assert!((reference.summary.floor - 1e-12).abs() < 1e-15, "{:?}", reference.summary);
        assert_eq!((reference.summary.compared_until, reference.summary.separation), (1.0, None));
        let errors = reference.errors(&other, 2);
        assert!((errors[0] - 5e-13).abs() < 1e-15 && (errors[1] - 1e-12).abs() < 1e-15);
        assert_eq!(reference.errors(&other, 0), [0.0, 0.0]);
    }

    #[test]
    fn motions_that_separate_are_compared_before() {
        // The difference grows tenfold per instant: 1e-16, 1e-15 …
        let own = trace(vec![1.0; 40]);
        let other = trace((0..40).map(|k| 1.0 + 10f64.powi((k - 36).min(0))).collect());
        let grid = Grid::new(1.0, 39);
        let reference = judge(own, vec![("a".to_owned(), other)], String::new(), &grid, 1);
        // The first beyond 1e-9 is k = 28 (1e-8; k = 27 is 1e-9 up to rounding), beyond 1e-3 it is k = 34.
        assert!((26..=27).contains(&reference.until), "{}", reference.until);
        assert!(reference.summary.floor <= 1e-9);
        assert!(reference.summary.separation.is_some_and(|t| (33.0..=34.0).contains(&t)));
    }
}
