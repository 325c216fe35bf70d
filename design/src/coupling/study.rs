//! The cost of a communication step in accuracy: a system coupled in several ways and at several steps, compared with an
//! uncoupled one, or with a much shorter step.
//!
//! The error of an output is the largest difference at the communication points that all steps have in common, relative to the
//! largest magnitude of the output there. The order is log₂ of the ratio of the errors at a step and at its half.

use super::exchange::Coupling;
use crate::Progress;
use crate::parallel;
use crate::text::time;
use camdrive::drives::Fault;
use serde::Serialize;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The steps, as multiples of the system's.
const LADDER: [f64; 6] = [4.0, 2.0, 1.0, 0.5, 0.25, 0.125];

/// The accuracies of verdicts, the first one in the sentence.
pub const ACCURACIES: [f64; 2] = [1e-2, 1e-4];

/// Over the largest magnitude of an output: a run whose error is larger has nothing in common with the motion.
const DIVERGED: f64 = 10.0;

/// The least number of compared points.
const POINTS: f64 = 20.0;

/// The part of an accuracy that the reference must reach, so that a verdict does not rest on its error.
pub(super) const SURE: f64 = 0.1;

/// Makes the parts anew.
pub type Make<'a> = Box<dyn Fn() -> Result<Coupling, Fault> + Sync + 'a>;

/// A way to couple the system.
pub struct Candidate<'a> {
    /// The way to couple.
    pub way: Way,
    /// Makes the system; None if that is impossible.
    pub make: Option<Make<'a>>,
}

/// A way to couple the system, with its findings.
#[derive(Clone, Debug, Serialize)]
pub struct Way {
    /// The exchange.
    pub exchange: String,
    /// The number of repetitions of a step.
    pub repeats: u32,
    /// The master that does so, as "run.py"; empty if none usually does.
    pub master: String,
    /// The largest step (s) that is stable by theory; None if each is.
    pub stable: Option<f64>,
    /// The reason if it is impossible.
    pub fault: Option<String>,
    /// The largest step (s) up to which all steps reach each of [`ACCURACIES`].
    pub steps: [Option<f64>; 2],
}

/// An output: a variable of a part, as factor · variable + offset.
#[derive(Clone, Debug)]
pub struct Port {
    /// The part.
    pub part: usize,
    /// The variable.
    pub name: String,
    /// The factor.
    pub factor: f64,
    /// The offset.
    pub offset: f64,
}

/// A compared output.
#[derive(Clone, Debug, Serialize)]
pub struct Output {
    /// Part and variable.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The largest magnitude.
    pub largest: f64,
    /// The relative error of the reference.
    pub known_to: f64,
    /// The ports in the system and in the reference.
    #[serde(skip)]
    pub ports: [Port; 2],
}

/// The reference of the errors: two runs, the better one first, whose difference shows its accuracy.
pub struct Reference<'a> {
    /// Its description in a sentence.
    pub about: String,
    /// The name of the one FMU.
    pub fmu: Option<String>,
    /// The runs with their steps (s); infinite: from point to point.
    pub runs: [(Make<'a>, f64); 2],
}

/// The errors of a way at a step.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The index of the way.
    #[serde(skip)]
    pub way: usize,
    /// The exchange.
    pub exchange: String,
    /// The number of repetitions of a step.
    pub repeats: u32,
    /// The communication step (s).
    pub step: f64,
    /// The largest error of an output, and the output.
    pub error: Option<f64>,
    /// Its name.
    pub worst: Option<String>,
    /// The order of the error from here to the next step.
    pub order: Option<f64>,
    /// The largest part of the work between a shaft and a drive on which they disagree.
    pub residual: Option<f64>,
    /// The reason if there is no error.
    pub unstable: Option<String>,
    /// The error of each output.
    pub errors: Vec<Option<f64>>,
}

/// The findings.
#[derive(Clone, Debug, Serialize)]
pub struct Findings {
    /// The name.
    pub system: String,
    /// The step of the system (s).
    pub step: f64,
    /// The reference of the errors.
    pub reference: String,
    /// The one FMU.
    pub fmu: Option<String>,
    /// The accuracy of the reference: the largest relative error of an output.
    pub known_to: f64,
    /// Length of the runs (s).
    pub stop: f64,
    /// Distance of the compared points (s).
    pub spacing: f64,
    /// The compared outputs.
    pub outputs: Vec<Output>,
    /// The ways to couple.
    pub ways: Vec<Way>,
    /// Their errors, from long to short steps.
    pub rows: Vec<Row>,
}

/// A system under study.
#[derive(Clone, Copy, Debug)]
pub struct System<'a> {
    /// Its name.
    pub name: &'a str,
    /// The communication step (s).
    pub step: f64,
    /// The end of the runs (s).
    pub stop: f64,
}

/// The common points of all runs, after the start.
#[derive(Clone, Copy)]
struct Points {
    /// Their distance (s).
    spacing: f64,
    count: usize,
}

/// Values of the outputs at the points, and the part of the work that differs.
struct Trajectory {
    values: Vec<Vec<f64>>,
    residual: f64,
}

/// A system coupled in these ways.
///
/// # Errors
/// The faults of the reference.
pub fn study(
    system: System<'_>,
    candidates: Vec<Candidate<'_>>,
    mut outputs: Vec<Output>,
    reference: Reference<'_>,
    tell: &(dyn Fn(Progress<'_>) + Sync),
) -> Result<Findings, Fault> {
    let System { name, step, stop } = system;
    let ladder: Vec<f64> =
        LADDER.into_iter().filter(|by| *by <= 1.0 || by * step * POINTS <= stop).map(|by| by * step).collect();
    let spacing = ladder[0];
    let points = Points { spacing, count: (stop / spacing * (1.0 + 1e-9)) as usize };
    let ports = |which: usize| outputs.iter().map(|output| output.ports[which].clone()).collect::<Vec<Port>>();
    let (of_system, of_reference) = (ports(0), ports(1));
    let runs =
        parallel::map(&reference.runs, |(make, step)| course(make, *step, points, &of_reference, |_, _| true), &|| ());
    let runs: Vec<Trajectory> = runs.into_iter().collect::<Result<_, _>>()?;
    let [exact, check] = &runs[..] else { return Err(Fault::new("a reference is missing")) };
    for (o, output) in outputs.iter_mut().enumerate() {
        output.largest = exact.values.iter().fold(0.0, |most: f64, values| most.max(values[o].abs()));
        output.known_to = difference(exact, check, o, output.largest);
    }
    let mut jobs: Vec<(usize, f64)> = Vec::new();
    for (i, candidate) in candidates.iter().enumerate() {
        if candidate.make.is_some() {
            jobs.extend(ladder.iter().map(|step| (i, *step)));
        }
    }
    // The longest steps first.
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    order.sort_by(|a, b| jobs[*a].1.total_cmp(&jobs[*b].1));
    let (done, total) = (AtomicUsize::new(0), jobs.len());
    let comparison = Comparison { outputs: &outputs, ports: &of_system, points, exact };
    let one = |job: &usize| {
        let (i, step) = jobs[*job];
        comparison.row(i, &candidates[i], step)
    };
    let found = parallel::map(&order, one, &|| {
        tell(Progress { done: done.fetch_add(1, Ordering::Relaxed) + 1, total, stage: "steps" });
    });
    let mut rows: Vec<(usize, Row)> = order.into_iter().zip(found).collect();
    rows.sort_by_key(|(job, _)| *job);
    let mut rows: Vec<Row> = rows.into_iter().map(|(_, row)| row).collect();
    for i in 1..rows.len() {
        if let (true, Some(coarse), Some(fine)) = (rows[i].way == rows[i - 1].way, rows[i - 1].error, rows[i].error) {
            rows[i - 1].order = (fine > 0.0 && coarse > 0.0).then(|| (coarse / fine).log2());
        }
    }
    let known_to = outputs.iter().fold(0.0, |most: f64, output| most.max(output.known_to));
    let mut ways: Vec<Way> = candidates.into_iter().map(|candidate| candidate.way).collect();
    for (i, way) in ways.iter_mut().enumerate() {
        way.steps = ACCURACIES.map(|accuracy| {
            let own = rows.iter().rev().filter(|row| row.way == i);
            let good = own.take_while(|row| row.error.is_some_and(|error| error <= accuracy));
            good.last().map(|row| row.step).filter(|_| known_to <= SURE * accuracy)
        });
    }
    Ok(Findings {
        system: name.to_owned(),
        step,
        reference: reference.about,
        fmu: reference.fmu,
        known_to,
        stop,
        spacing,
        outputs,
        ways,
        rows,
    })
}

/// The run of a system until `goes_on` is false for a point and its values.
fn course(
    make: &Make<'_>,
    step: f64,
    points: Points,
    ports: &[Port],
    goes_on: impl Fn(usize, &[f64]) -> bool,
) -> Result<Trajectory, Fault> {
    let Points { spacing, count } = points;
    let mut coupling = make()?;
    coupling.begin(0.0, None)?;
    coupling.start()?;
    let parts = (spacing / step).round().max(1.0);
    let mut values = Vec::with_capacity(count + 1);
    let find = |Port { part, name, factor, offset }: &Port| {
        let place = coupling.parts()[*part].description().find(name);
        let place = place.ok_or_else(|| Fault::new(format!("`{name}` is no variable")))?;
        Ok((*part, place, *factor, *offset))
    };
    let places = ports.iter().map(find).collect::<Result<Vec<_>, Fault>>()?;
    for point in 0..=count {
        let hosts = coupling.parts();
        let read =
            |(part, place, factor, offset): &(usize, usize, f64, f64)| Ok(factor * hosts[*part].get(*place)? + offset);
        let now = places.iter().map(read).collect::<Result<Vec<f64>, Fault>>()?;
        let more = goes_on(point, &now);
        values.push(now);
        if !more || point == count {
            break;
        }
        for k in 0..parts as usize {
            let time = (point as f64 + k as f64 / parts) * spacing;
            coupling.advance(time, spacing / parts)?;
        }
    }
    let residual = coupling.residuals().iter().map(|residual| residual.gross / residual.exchanged);
    Ok(Trajectory { values, residual: residual.filter(|part| part.is_finite()).fold(0.0, f64::max) })
}

/// The largest relative difference of an output.
fn difference(a: &Trajectory, b: &Trajectory, output: usize, largest: f64) -> f64 {
    let of = a.values.iter().zip(&b.values).map(|(a, b)| (a[output] - b[output]).abs());
    let most = of.fold(0.0, |most: f64, x| if x <= most || most.is_nan() { most } else { x });
    // An output that never moves in the reference has no size.
    if largest == 0.0 { 0.0 } else { most / largest }
}

/// The common reference of all runs.
struct Comparison<'a> {
    outputs: &'a [Output],
    /// The ports of the outputs in the system.
    ports: &'a [Port],
    points: Points,
    exact: &'a Trajectory,
}

impl Comparison<'_> {
    /// The errors of a way at a step.
    fn row(&self, place: usize, candidate: &Candidate<'_>, step: f64) -> Row {
        let Comparison { outputs, ports, points, exact } = *self;
        let way = &candidate.way;
        let mut row = Row {
            way: place,
            exchange: way.exchange.clone(),
            repeats: way.repeats,
            step,
            error: None,
            worst: None,
            order: None,
            residual: None,
            unstable: None,
            errors: vec![None; outputs.len()],
        };
        let Some(make) = &candidate.make else { return row };
        if let Some(stable) = way.stable.filter(|stable| step > *stable) {
            row.unstable = Some(format!("errors grow beyond {}", time(stable)));
            return row;
        }
        let near = |point: usize, values: &[f64]| {
            let is_near = |o: usize| {
                let largest = outputs[o].largest;
                (values[o] - exact.values[point][o]).abs() <= DIVERGED * largest || largest == 0.0
            };
            (0..values.len()).all(is_near)
        };
        match course(make, step, points, ports, near) {
            Ok(course) if course.values.len() == exact.values.len() => {
                let errors: Vec<f64> =
                    (0..outputs.len()).map(|o| difference(exact, &course, o, outputs[o].largest)).collect();
                let worst = (0..errors.len()).max_by(|a, b| errors[*a].total_cmp(&errors[*b]));
                row.error = worst.map(|o| errors[o]);
                row.worst = worst.map(|o| outputs[o].name.clone());
                row.errors = errors.into_iter().map(Some).collect();
                row.residual = Some(course.residual);
            }
            Ok(course) => {
                let end = time((course.values.len() - 1) as f64 * points.spacing);
                row.unstable = Some(format!("diverged until {end}"));
            }
            Err(fault) => row.unstable = Some(fault.to_string()),
        }
        row
    }
}
