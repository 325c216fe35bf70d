//! One run of an instance through the C interface, and what it costs.

use super::run_up::{HIGHEST_DERIVATIVE, RunUp, Signal};
use crate::host::{Fmu, Host};
use crate::resource::Resource;
use crate::work;
use camdrive::drives::variable::{Causality, Kind, Variability};
use camdrive::drives::{Description, Fault};
use camdrive::numerics::work::Since;
use cpu_time::ThreadTime;

/// The drive as the host sees it.
#[derive(Clone, Debug)]
pub struct Interface {
    /// All variables, in the order of their references.
    pub variables: Vec<Description>,
    /// The references of the continuous outputs, which the host reads and compares.
    pub outputs: Vec<u32>,
    /// Input references with their signals.
    pub inputs: Vec<(u32, Signal)>,
    /// The highest order of input derivatives.
    pub derivatives: usize,
}

impl Interface {
    /// The interface of a drive.
    pub fn of(resource: &Resource) -> Result<Self, Fault> {
        let drive = resource.build()?;
        let variables = drive.descriptions().to_vec();
        let numbered = || variables.iter().enumerate().map(|(i, d)| (i as u32, d));
        let continuous = |d: &Description| {
            d.causality == Causality::Output
                && d.variability == Variability::Continuous
                && matches!(d.kind, Kind::Real { .. })
        };
        let outputs = numbered().filter(|(_, d)| continuous(d)).map(|(i, _)| i).collect();
        let inputs = numbered().filter(|(_, d)| d.causality == Causality::Input);
        let inputs = inputs.map(|(i, d)| (i, Signal::of(&d.name))).collect();
        let derivatives = drive.input_derivative_order().min(HIGHEST_DERIVATIVE);
        Ok(Interface { outputs, inputs, derivatives, variables })
    }

    /// The reference of a variable.
    pub fn find(&self, name: &str) -> Option<u32> {
        self.variables.iter().position(|d| d.name == name).map(|i| i as u32)
    }

    /// Name and unit of the compared outputs.
    pub fn names(&self) -> Vec<(String, String)> {
        let named = |reference: &u32| {
            let d = &self.variables[*reference as usize];
            let unit = if let Kind::Real { quantity, .. } = &d.kind { quantity.unit } else { "" };
            (d.name.clone(), unit.to_owned())
        };
        self.outputs.iter().map(named).collect()
    }

    /// True if a run-up moves an input.
    pub fn is_driven(&self) -> bool {
        self.inputs.iter().any(|(_, signal)| *signal != Signal::Constant)
    }
}

/// The communication points of a run: every `stride`-th of the instants k · `step`, at which runs are compared, or the instants
/// with `parts` − 1 points in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// (s).
    pub step: f64,
    /// The number of the last instant.
    pub count: usize,
    /// The number of instants in a communication step.
    pub stride: usize,
    /// The number of communication steps in an interval; 1 if `stride` > 1.
    pub parts: usize,
    /// The parts are of unequal length, so that other communication points determine the result.
    pub uneven: bool,
}

impl Grid {
    /// Every instant is a communication point.
    pub fn new(step: f64, count: usize) -> Self {
        Grid { step, count, stride: 1, parts: 1, uneven: false }
    }

    /// The length of a communication step (s).
    pub fn communication_step(&self) -> f64 {
        self.step * self.stride as f64 / self.parts as f64
    }

    /// The number of communication steps of a run.
    pub fn steps(&self) -> usize {
        self.count / self.stride * self.parts
    }

    /// Communication point i (s); the instants k · `step` are the same numbers in every grid.
    fn time(&self, i: usize) -> f64 {
        let (whole, part) = (i / self.parts * self.stride, i % self.parts);
        let mut share = part as f64 / self.parts as f64;
        if self.uneven {
            // From 0 to 1 with a slope from 0.62 to 1.38.
            share *= 0.62 + 0.38 * share;
        }
        if part == 0 { whole as f64 * self.step } else { (whole as f64 + share) * self.step }
    }
}

/// How the host passes the inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inputs {
    /// Values only.
    Values,
    /// Values and derivatives, as far as the drive takes them.
    Derivatives,
}

/// The plan of a run.
pub struct Plan<'a> {
    /// The FMU.
    pub fmu: &'a Fmu,
    /// Its interface.
    pub interface: &'a Interface,
    /// Values set before initialisation.
    pub starts: &'a [(u32, f64)],
    /// The communication points.
    pub grid: Grid,
    /// The motion of the inputs.
    pub run_up: &'a RunUp,
    /// How the host passes them.
    pub inputs: Inputs,
}

/// Result of a run.
#[derive(Clone, Debug)]
pub struct Trace {
    /// The outputs at the instants 0, `stride`, 2 `stride` …, one row after the other.
    pub values: Vec<f64>,
    /// The number of instants between two rows.
    pub stride: usize,
    /// CPU time of instantiation and initialisation (ns).
    pub start_ns: f64,
    /// CPU time of all steps, inputs and outputs included (ns).
    pub run_ns: f64,
    /// `solver.steps`, `solver.evaluations`, `solver.error_estimate` at the end; NaN without them.
    pub statistics: [f64; 3],
}

impl Trace {
    /// The outputs at instant `k`; None if the run has no communication point there.
    pub fn row(&self, k: usize, outputs: usize) -> Option<&[f64]> {
        if !k.is_multiple_of(self.stride) {
            return None;
        }
        let at = k / self.stride * outputs;
        self.values.get(at..at + outputs)
    }
}

/// Inputs or their derivatives, as the host sets them at once.
#[derive(Default)]
struct InputValues {
    signals: Vec<Signal>,
    references: Vec<u32>,
    orders: Vec<i32>,
    values: Vec<f64>,
}

/// Passes the signals of a run-up to an instance without allocating between steps.
struct Feed<'a> {
    run_up: &'a RunUp,
    inertia: f64,
    inputs: InputValues,
    derivatives: InputValues,
}

impl<'a> Feed<'a> {
    fn new(plan: &Plan<'a>) -> Self {
        let (interface, run_up) = (plan.interface, plan.run_up);
        let mut feed =
            Feed { run_up, inertia: 1.0, inputs: InputValues::default(), derivatives: InputValues::default() };
        let highest = if plan.inputs == Inputs::Derivatives { interface.derivatives } else { 0 };
        let leads = |signal| interface.inputs.iter().any(|(_, other)| *other == signal);
        for (reference, signal) in &interface.inputs {
            // The derivatives of w are a's.
            let highest = if *signal == Signal::Speed && leads(Signal::Acceleration) { 0 } else { highest };
            for order in (0..=highest).filter(|order| signal.derivative(run_up, 1.0, 0.0, *order).is_some()) {
                let given = if order == 0 { &mut feed.inputs } else { &mut feed.derivatives };
                given.signals.push(*signal);
                given.references.push(*reference);
                given.orders.push(order as i32);
                given.values.push(0.0);
            }
        }
        feed
    }

    fn set(&mut self, host: &mut Host, t: f64) -> Result<(), Fault> {
        for InputValues { signals, orders, values, .. } in [&mut self.inputs, &mut self.derivatives] {
            for ((value, signal), order) in values.iter_mut().zip(signals).zip(orders) {
                *value = signal.derivative(self.run_up, self.inertia, t, *order as usize).unwrap_or(0.0);
            }
        }
        let Feed { inputs, derivatives, .. } = self;
        if !inputs.values.is_empty() {
            host.set_reals(&inputs.references, &inputs.values)?;
        }
        if !derivatives.values.is_empty() {
            host.set_input_derivatives(&derivatives.references, &derivatives.orders, &derivatives.values)?;
        }
        Ok(())
    }
}

/// A run draws upon the budget of the study once in this many steps, so that this does not affect the cost.
const DRAWING: usize = 16;

/// CPU time of this thread since `start` (ns).
fn elapsed_ns(start: ThreadTime) -> f64 {
    start.elapsed().as_secs_f64() * 1e9
}

/// Runs a plan.
pub fn run(plan: &Plan<'_>) -> Result<Trace, Fault> {
    let Plan { interface, grid, .. } = plan;
    let mut since = Since::now();
    let mut draw = || {
        // A thousand plain operations in a nominal microsecond.
        let cost = 1e3 * std::mem::replace(&mut since, Since::now()).drawn();
        if work::draw(cost) { Ok(()) } else { Err(Fault::new("the work of the study is used up")) }
    };
    draw()?;
    let clock = ThreadTime::now();
    let mut host = plan.fmu.instantiate(&plan.fmu.description().name)?;
    for (reference, value) in plan.starts {
        host.set(*reference as usize, *value)?;
    }
    let mut feed = Feed::new(plan);
    host.set_up(0.0, None, None)?;
    host.enter_initialization()?;
    if feed.inputs.signals.contains(&Signal::Torque) {
        let mut inertia = [1.0];
        if let Some(reference) = interface.find("J") {
            host.get_reals(&[reference], &mut inertia)?;
        }
        feed.inertia = inertia[0];
    }
    feed.set(&mut host, 0.0)?;
    host.exit_initialization()?;
    let start_ns = elapsed_ns(clock);
    let outputs = interface.outputs.len();
    let rows = grid.count / grid.stride + 1;
    let mut values = vec![0.0; rows * outputs];
    let mut between = vec![0.0; outputs];
    host.get_reals(&interface.outputs, &mut values[..outputs])?;
    let clock = ThreadTime::now();
    for i in 0..grid.steps() {
        let (time, next) = (grid.time(i), grid.time(i + 1));
        feed.set(&mut host, time)?;
        host.do_step(time, next - time)?;
        if i.is_multiple_of(DRAWING) {
            draw()?;
        }
        let row = match (i + 1) % grid.parts {
            0 => {
                let at = (i + 1) / grid.parts * outputs;
                &mut values[at..at + outputs]
            }
            _ => &mut between[..],
        };
        host.get_reals(&interface.outputs, row)?;
    }
    let run_ns = elapsed_ns(clock);
    let mut statistics = [f64::NAN; 3];
    for (place, name) in statistics.iter_mut().zip(["solver.steps", "solver.evaluations", "solver.error_estimate"]) {
        if let Some(reference) = interface.find(name) {
            let mut value = [0.0];
            host.get_reals(&[reference], &mut value)?;
            *place = value[0];
        }
    }
    Ok(Trace { values, stride: grid.stride, start_ns, run_ns, statistics })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_are_the_same_numbers_in_every_grid() {
        let base = Grid::new(0.1 / 3.0, 81);
        for grid in
            [base, Grid { stride: 9, ..base }, Grid { parts: 27, ..base }, Grid { parts: 3, uneven: true, ..base }]
        {
            assert_eq!(grid.steps() * grid.stride, 81 * grid.parts);
            for k in (0..=81).step_by(grid.stride) {
                assert_eq!(grid.time(k / grid.stride * grid.parts), base.time(k));
            }
            assert!((0..grid.steps()).all(|i| grid.time(i) < grid.time(i + 1)));
        }
        assert_eq!(Grid { stride: 9, ..base }.communication_step(), 9.0 * base.step);
    }
}
