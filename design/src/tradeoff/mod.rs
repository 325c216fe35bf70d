//! Speed against accuracy: the cost and the error of each setting of a drive's solver, and the change and the cost of each
//! feature of its scene, so that a model contains only what it needs.
//!
//! [`study`] drives the FMU through the C interface ([`mod@run`]) with every setting that it offers ([`sweep`]), compares
//! with a [`mod@reference`] of known uncertainty, and measures the same for the scene without each of its features
//! ([`fidelity`]). [`advice`] draws the conclusions; [`mod@report`] and [`figures`] show them.

pub mod advice;

pub mod fidelity;
pub mod figures;
pub mod reference;
pub mod report;
mod rigid;
pub mod run;
pub mod run_up;
mod simplification;
pub mod sweep;
#[cfg(test)]
mod tests;

#[cfg(test)]
pub(crate) use simplification::massless;

use crate::host::Fmu;
use crate::resource::Resource;
use crate::text::{number, time};
use crate::{Progress, work};
use camdrive::drives::Fault;

use run::{Grid, Inputs, Interface, Plan, Trace, run};
use run_up::RunUp;
use serde::Serialize;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::time::{Duration, Instant};
use sweep::Setting;

/// Options of a study.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// The number of turns of the cam; by default the default experiment's, or nine with a run-up.
    pub turns: Option<f64>,
    /// For drives with inputs: the speed that the run-up ends with (rad/s); [`DEFAULT_SPEED`].
    pub speed: Option<f64>,
    /// For drives with inputs: the duration of the run-up (s); six turns at the speed.
    pub ramp: Option<f64>,
    /// Fewer settings, fewer repetitions.
    pub quick: bool,
}

/// The default speed at the end of a run-up: 600 rpm (rad/s).
pub const DEFAULT_SPEED: f64 = 20.0 * std::f64::consts::PI;

/// The instants of a run-up lie this far apart: the communication steps of the sweep divide it.
const INSTANTS_PER_RAMP: f64 = 405.0;
/// A run has at most this many instants; more would take minutes without showing more.
const MOST_INSTANTS: f64 = 20_000.0;
/// Fewer than this many instants would leave nothing to compare at the longest communication step.
const FEWEST_INSTANTS: f64 = 100.0;

/// Repetitions go on until a setting has this many, or until the time is over.
const REPETITIONS: usize = 21;
/// The least number of repetitions for a median.
const LEAST_REPETITIONS: usize = 3;

/// The result of a study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Findings {
    /// The name of the scene.
    pub scene: String,
    /// The drive model.
    pub model: String,
    /// The experiment.
    pub experiment: Experiment,
    /// The compared outputs.
    pub outputs: Vec<Output>,
    /// The reference of the errors.
    pub reference: reference::Summary,
    /// One row per setting; the first is the drive with its defaults.
    pub settings: Vec<Row>,
    /// The values of dials that changed neither errors nor steps compared with the default; they have no row.
    pub without_effect: Vec<String>,
    /// One row per feature that can be left out.
    pub features: Vec<Feature>,
    /// One sentence per target accuracy.
    pub advice: Vec<advice::Advice>,
}

/// The experiment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Experiment {
    /// The end of each run (s).
    pub stop: f64,
    /// The communication step of the default experiment, at which runs are compared (s).
    pub step: f64,
    /// The duration of a turn (s); None if the shaft stands still.
    pub turn: Option<f64>,
    /// Speed (rad/s) and duration (s) of the run-up that the inputs follow.
    pub run_up: Option<[f64; 2]>,
}

/// A compared output.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Output {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Its largest absolute value, to which errors and changes refer.
    pub largest: f64,
}

/// Cost of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cost {
    /// Median CPU time of the steps, inputs and outputs included, per time of the machine (ns/ms).
    pub ns_per_ms: f64,
    /// Median CPU time of instantiation and initialisation (µs).
    pub start_us: f64,
    /// Internal steps over the run.
    pub steps: Option<f64>,
    /// Evaluations over the run.
    pub evaluations: Option<f64>,
}

/// A setting with its error and cost.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The item of `solver.method`.
    pub method: Option<String>,
    /// `solver.tolerance`; 0 for the default.
    pub tolerance: Option<f64>,
    /// `solver.step_size` (s); 0 for the default.
    pub step_size: Option<f64>,
    /// "values" or "derivatives" if the drive has inputs that move.
    pub inputs: Option<&'static str>,
    /// (s).
    pub communication_step: f64,
    /// The largest error of an output, relative to its largest value.
    pub error: Option<f64>,
    /// The output with that error.
    pub worst: Option<String>,
    /// The uncertainty of the reference: an error of this size may be smaller.
    pub known_to: f64,
    /// The error that the drive itself estimates.
    pub error_estimate: Option<f64>,
    /// The cost.
    pub cost: Option<Cost>,
    /// The error of each output.
    pub errors: BTreeMap<String, f64>,
    /// The reason if there is no result.
    pub fault: Option<String>,
}

/// The drive without one of its features.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Feature {
    /// The feature left out.
    pub feature: String,
    /// Its replacement.
    pub instead: String,
    /// The largest change of an output that does not vanish with the feature, relative to its largest value.
    pub change: Option<f64>,
    /// The output with that change.
    pub worst: Option<String>,
    /// The uncertainty of the reference: a change of this size may be smaller.
    pub known_to: f64,
    /// The cost without the feature.
    pub cost: Option<Cost>,
    /// Its ratio to the cost of the whole drive.
    pub cost_ratio: Option<f64>,
    /// The change of each output.
    pub changes: BTreeMap<String, f64>,
    /// The reason if there is no result.
    pub fault: Option<String>,
}

/// CPU times of repeated runs (ns).
#[derive(Clone, Debug, Default)]
struct Samples {
    run: Vec<f64>,
    start: Vec<f64>,
    statistics: Option<[f64; 2]>,
}

impl Samples {
    /// Adds the run that also counts the work.
    fn first(&mut self, trace: &Trace) {
        self.statistics = Some([trace.statistics[0], trace.statistics[1]]);
        self.add(trace.run_ns, trace.start_ns);
    }

    fn add(&mut self, run_ns: f64, start_ns: f64) {
        self.run.push(run_ns);
        self.start.push(start_ns);
    }

    fn cost(&self, stop: f64) -> Option<Cost> {
        let (run, start) = (median(&self.run)?, median(&self.start)?);
        let known = |value: f64| value.is_finite().then_some(value);
        let [steps, evaluations] = self.statistics.map_or([None; 2], |s| s.map(known));
        Some(Cost { ns_per_ms: run / (1e3 * stop), start_us: 1e-3 * start, steps, evaluations })
    }
}

/// The median; for an even number of values the mean of the middle two.
fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    let upper = *sorted.get(middle)?;
    if sorted.len() % 2 == 1 { Some(upper) } else { Some(0.5 * (upper + sorted[middle - 1])) }
}

/// The experiment of all runs of a study.
pub struct Bench {
    fmu: Fmu,
    interface: Interface,
    grid: Grid,
    run_up: RunUp,
    turn: Option<f64>,
}

impl Bench {
    /// Sets up the experiment.
    ///
    /// # Errors
    /// A drive that cannot be built; options that give no experiment.
    fn new(resource: &Resource, options: &Options) -> Result<Self, Fault> {
        let interface = Interface::of(resource)?;
        let mut drive = resource.build()?;
        let experiment = drive.experiment();
        let run_up = run_up(options)?;
        let fmu = Fmu::linked(resource)?;
        if interface.is_driven() {
            let turn = TAU / run_up.speed.abs();
            let stop = options.turns.map_or(2.0 * run_up.ramp, |turns| turns * turn + 0.5 * run_up.ramp);
            let step = run_up.ramp / INSTANTS_PER_RAMP;
            let option = if options.turns.is_some() { "--turns" } else { "--ramp" };
            return Ok(Bench { fmu, interface, grid: grid(option, step, stop)?, run_up, turn: Some(turn) });
        }
        if options.speed.is_some() || options.ramp.is_some() {
            return Err(Fault::new(
                "--speed, --ramp: this scene has no inputs phi, w, a that a run-up could move; its own `drive` or motor sets \
                 the speed",
            )
            .of("--speed"));
        }
        let grid_of = |option, stop| grid(option, experiment.step, stop);
        let mut bench = Bench { fmu, interface, grid: grid_of("", experiment.stop)?, run_up, turn: None };
        bench.turn = match bench.interface.find("drive.w") {
            Some(speed) => Some(TAU / drive.get(speed as usize)?.abs()),
            None => bench.mean_speed()?.map(|w| TAU / w.abs()),
        }
        .filter(|turn| turn.is_finite());
        if let Some(turns) = options.turns {
            let turn =
                bench.turn.ok_or_else(|| Fault::new("--turns: the shaft of this scene stands still").of("--turns"))?;
            bench.grid = grid_of("--turns", turns * turn)?;
        }
        Ok(bench)
    }

    /// The mean speed over the run with the defaults (rad/s).
    fn mean_speed(&self) -> Result<Option<f64>, Fault> {
        let Some(column) = self.interface.names().iter().position(|(name, _)| name == "phi") else { return Ok(None) };
        let trace = self.run(&[], self.grid, Inputs::Values)?;
        let outputs = self.interface.outputs.len();
        let angle = |k: usize| trace.row(k, outputs).map_or(0.0, |row| row[column]);
        Ok(Some((angle(self.grid.count) - angle(0)) / (self.grid.count as f64 * self.grid.step)))
    }

    fn run(&self, starts: &[(u32, f64)], grid: Grid, inputs: Inputs) -> Result<Trace, Fault> {
        run(&Plan { fmu: &self.fmu, interface: &self.interface, starts, grid, run_up: &self.run_up, inputs })
    }

    fn setting(&self, setting: &Setting) -> Result<Trace, Fault> {
        self.run(&setting.starts, setting.grid, setting.inputs.unwrap_or(Inputs::Values))
    }

    fn stop(&self) -> f64 {
        self.grid.count as f64 * self.grid.step
    }
}

/// Instants `step` apart up to `stop`, which an option sets.
fn grid(option: &str, step: f64, stop: f64) -> Result<Grid, Fault> {
    let count = (stop / step).round();
    if !(FEWEST_INSTANTS..=MOST_INSTANTS).contains(&count) {
        let before = if option.is_empty() { String::new() } else { format!("{option}: ") };
        return Err(Fault::new(format!(
            "{before}a run of {} at steps of {} has {} communication points; {FEWEST_INSTANTS} to {MOST_INSTANTS} are compared: choose \
             another number of turns (--turns), or with inputs another --ramp",
            time(stop),
            time(step),
            number(count)
        ))
        .of(option));
    }
    Ok(Grid::new(step, count as usize))
}

/// The run-up of these options.
fn run_up(options: &Options) -> Result<RunUp, Fault> {
    let speed = options.speed.unwrap_or(DEFAULT_SPEED);
    if speed == 0.0 || !speed.is_finite() {
        return Err(Fault::new("--speed: a run-up ends with a finite speed other than 0")
            .of("--speed")
            .hint("write for example \"600 rpm\""));
    }
    let turns = options.turns.unwrap_or(9.0);
    if !(turns > 0.0 && turns.is_finite()) {
        return Err(Fault::new(format!("--turns: {turns} is not greater than 0"))
            .of("--turns")
            .hint("write for example 9"));
    }
    // Half of the run is the ramp, which covers a third of the angle.
    let ramp = options.ramp.unwrap_or(turns * TAU / (1.5 * speed.abs()));
    if !(ramp > 0.0 && ramp.is_finite()) {
        return Err(Fault::new(format!("--ramp: {ramp} s is not greater than 0 s"))
            .of("--ramp")
            .hint("write for example \"0.2 s\""));
    }
    Ok(RunUp { speed, ramp })
}

/// Runs the study of a scene; `progress` is called after each run.
///
/// # Errors
/// A scene that the drive refuses, options that give no experiment, a reference that cannot be computed, and a study that takes
/// more than the admissible work.
pub fn study(resource: &Resource, options: &Options, progress: &(dyn Fn(Progress) + Sync)) -> Result<Findings, Fault> {
    let hint = "take fewer --turns, or fewer settings with --quick";
    work::within(work::BUDGET, hint, progress, |tell| studied(resource, options, tell))?
}

/// See [`study`].
fn studied(resource: &Resource, options: &Options, progress: &dyn Fn(Progress)) -> Result<Findings, Fault> {
    progress(Progress { done: 0, total: 1, stage: "reference" });
    let bench = Bench::new(resource, options)?;
    let reference = reference::compute(&bench)?;
    let turn = bench.turn.unwrap_or(bench.stop());
    let mut settings = sweep::settings(&bench.interface, bench.grid, turn, options.quick);
    let (simpler, shaft) = (simplification::of(resource), fidelity::shaft(&bench, &reference));
    let names: Vec<String> = bench.interface.names().into_iter().map(|(name, _)| name).collect();

    // Once for the errors, then repeatedly for the times, one setting after the other, so that all of them meet the same ups
    // and downs of the computer.
    let jobs = settings.len() + simpler.len();
    let mut samples = vec![Samples::default(); jobs];
    let mut rows = Vec::new();
    let mut features = Vec::new();
    let mut done = 0;
    let begin = Instant::now();
    for (setting, samples) in settings.iter().zip(&mut samples) {
        rows.push(first_run(&bench, setting, &reference, &names, samples));
        done += 1;
        progress(Progress { done, total: jobs * (1 + LEAST_REPETITIONS), stage: "errors" });
    }
    let without_effect = drop_repetitions(&mut settings, &mut rows, &mut samples);
    let jobs = settings.len() + simpler.len();
    let whole = sweep::whole(&settings);
    let full = bench.setting(&settings[whole])?;
    for (simpler, samples) in simpler.iter().zip(samples.iter_mut().skip(settings.len())) {
        let (feature, trace) = fidelity::first_run(simpler, &bench, &shaft, &full, &reference);
        features.push(feature);
        trace.iter().for_each(|trace| samples.first(trace));
        done += 1;
        progress(Progress { done, total: jobs * (1 + LEAST_REPETITIONS), stage: "features" });
    }
    let pass = begin.elapsed();
    let time = Duration::from_secs(if options.quick { 2 } else { 8 });
    let rounds = (time.as_secs_f64() / pass.as_secs_f64().max(1e-6)) as usize;
    let rounds = rounds.clamp(LEAST_REPETITIONS, REPETITIONS);
    done = 0;
    for _ in 0..rounds {
        for (job, samples) in samples.iter_mut().enumerate() {
            let trace = match settings.get(job) {
                Some(setting) => bench.setting(setting),
                None => fidelity::run(&simpler[job - settings.len()], &bench, &shaft),
            };
            if let Ok(trace) = trace {
                samples.add(trace.run_ns, trace.start_ns);
            }
            done += 1;
            progress(Progress { done, total: jobs * rounds, stage: "times" });
        }
    }
    let costs: Vec<Option<Cost>> = samples.iter().map(|s| s.cost(bench.stop())).collect();
    for (row, cost) in rows.iter_mut().zip(&costs) {
        row.cost = *cost;
    }
    for (feature, cost) in features.iter_mut().zip(&costs[settings.len()..]) {
        feature.cost = *cost;
        feature.cost_ratio = cost.zip(costs[whole]).map(|(without, with)| without.ns_per_ms / with.ns_per_ms);
    }
    let outputs = bench.interface.names().into_iter().zip(&reference.largest);
    let mut report = Findings {
        scene: resource.name.clone(),
        model: resource.model().to_owned(),
        experiment: Experiment {
            stop: bench.stop(),
            step: bench.grid.step,
            turn: bench.turn,
            run_up: bench.interface.is_driven().then_some([bench.run_up.speed, bench.run_up.ramp]),
        },
        outputs: outputs.map(|((name, unit), largest)| Output { name, unit, largest: *largest }).collect(),
        reference: reference.summary,
        settings: rows,
        without_effect,
        features,
        advice: Vec::new(),
    };
    report.settings.sort_by(Row::order);
    report.advice = advice::of(&report);
    Ok(report)
}

/// The largest value, and its name if it is above the reference's uncertainty.
fn worst_of<'a>(values: impl Iterator<Item = (&'a String, &'a f64)>, known_to: f64) -> (Option<String>, Option<f64>) {
    let (name, value) = values.max_by(|a, b| a.1.total_cmp(b.1)).unzip();
    (name.filter(|_| value.is_some_and(|value| *value > known_to)).cloned(), value.copied())
}

/// An error or a change for people; values below the uncertainty `known_to` are shown as "<".
pub fn bounded(value: f64, known_to: f64) -> String {
    if value > known_to { number(value) } else { format!("< {}", number(known_to)) }
}

impl Row {
    /// True if the solver uses its defaults.
    pub fn is_default(&self) -> bool {
        self.tolerance.unwrap_or(0.0) == 0.0 && self.step_size.unwrap_or(0.0) == 0.0
    }

    /// The order for readers: by method, inputs, tolerance from coarse to fine, internal and communication step.
    fn order(&self, other: &Row) -> Ordering {
        // The default stands before chosen values.
        let tolerance = |row: &Row| -row.tolerance.filter(|value| *value != 0.0).unwrap_or(f64::INFINITY);
        let numbers = |row: &Row| [tolerance(row), row.step_size.unwrap_or(0.0), row.communication_step];
        let names = (&self.method, self.inputs).cmp(&(&other.method, other.inputs));
        let pairs = numbers(self).into_iter().zip(numbers(other));
        pairs.fold(names, |order, (a, b)| order.then(a.total_cmp(&b)))
    }

    /// True if the other row is the same run under another name: a dial that changed nothing.
    fn repeats(&self, other: &Row) -> bool {
        (&self.method, self.inputs, self.communication_step) == (&other.method, other.inputs, other.communication_step)
            && self.errors == other.errors
            && self.error_estimate == other.error_estimate
            && self.fault == other.fault
    }
}

/// Drops the settings that only repeat a default one; returns these values of dials.
fn drop_repetitions(settings: &mut Vec<Setting>, rows: &mut Vec<Row>, samples: &mut Vec<Samples>) -> Vec<String> {
    let all = rows.iter().zip(samples.iter());
    let defaults: Vec<(Row, Option<[f64; 2]>)> =
        all.filter(|(row, _)| row.is_default()).map(|(row, samples)| (row.clone(), samples.statistics)).collect();
    let mut names = Vec::new();
    for i in (0..rows.len()).rev() {
        let row = &rows[i];
        if !row.is_default()
            && defaults.iter().any(|(default, count)| row.repeats(default) && samples[i].statistics == *count)
        {
            let name = advice::dials(row);
            if !names.contains(&name) {
                names.push(name);
            }
            settings.remove(i);
            rows.remove(i);
            samples.remove(i);
        }
    }
    names.reverse();
    // A dial that repeats the default at some communication steps only is kept.
    names.retain(|name| rows.iter().all(|row| advice::dials(row) != *name));
    names
}

/// The row of a setting without its cost.
fn first_run(
    bench: &Bench,
    setting: &Setting,
    reference: &reference::Reference,
    names: &[String],
    samples: &mut Samples,
) -> Row {
    let mut row = Row {
        method: setting.method.clone(),
        tolerance: setting.tolerance,
        step_size: setting.step_size,
        inputs: setting.inputs.map(|inputs| if inputs == Inputs::Values { "values" } else { "derivatives" }),
        communication_step: setting.grid.communication_step(),
        error: None,
        worst: None,
        known_to: reference.summary.floor,
        error_estimate: None,
        cost: None,
        errors: BTreeMap::new(),
        fault: None,
    };
    match bench.setting(setting) {
        Err(fault) => row.fault = Some(fault.to_string()),
        Ok(trace) => {
            let errors = reference.errors(&trace, reference.until).into_iter().map(|e| e.max(row.known_to));
            row.errors = names.iter().cloned().zip(errors).collect();
            (row.worst, row.error) = worst_of(row.errors.iter(), row.known_to);
            let estimate = trace.statistics[2];
            row.error_estimate = estimate.is_finite().then_some(estimate);
            samples.first(&trace);
        }
    }
    row
}
