//! The instance against a small drive: ẋ = g u, with faults on demand.

use super::abi;
use super::call_sequence::{self as table, Mode};
use super::instance::{Instance, Refusal};
use super::log::Logger;
use crate::drives::variable::{Kind, Type, Variability, real, real_within};
use crate::drives::{About, Curve, Drive, Event, EventLog, Experiment, Fault, List, Model, Seed, Text, unit};
use crate::numerics::taylor::Series;
use serde::{Deserialize, Serialize};
use std::ffi::CStr;
use std::sync::{Arc, Mutex};

/// ẋ = g u; within a step u is the polynomial u + u̇ τ.
#[derive(Clone, Serialize, Deserialize)]
struct Integrator {
    u: f64,
    u_dot: f64,
    g: f64,
    trouble: f64,
    on: f64,
    x: f64,
    tolerance: f64,
    events: EventLog,
}

const U: u32 = 0;
const G: u32 = 1;
const X0: u32 = 2;
const TROUBLE: u32 = 3;
const ON: u32 = 4;
const X: u32 = 5;
const TOLERANCE: u32 = 6;

/// The values of `trouble`.
const FAULT_AT_START: f64 = 1.0;
const FAULT: f64 = 2.0;
const PANIC: f64 = 3.0;
const NAN: f64 = 4.0;
const MANY_EVENTS: f64 = 5.0;

impl Drive for Integrator {
    type Scene = f64;
    const MODEL: &'static str = "Integrator";
    const INPUT_DERIVATIVES: usize = 1;

    fn new(g: f64) -> Result<Self, Fault> {
        let events = EventLog::default();
        Ok(Integrator { u: 0.0, u_dot: 0.0, g, trouble: 0.0, on: 1.0, x: 0.0, tolerance: 0.0, events })
    }

    fn variables(&self) -> List<Self> {
        let mut list = List::<Self>::default();
        list.input(
            "u",
            "Speed",
            real(&unit::LENGTH),
            |d, _| d.u,
            |d, _, order, v| match order {
                0 => (d.u, d.u_dot) = (v, 0.0),
                _ => d.u_dot = v,
            },
        );
        let g = real_within(&unit::NUMBER, 0.0, 10.0);
        list.parameter("g", "Gain", g, |d, _| d.g, |d, _, v| d.g = v).description.variability = Variability::Tunable;
        list.parameter("x0", "Start", real(&unit::LENGTH), |d, _| d.x, |d, _, v| d.x = v);
        let trouble = Kind::Integer { min: 0, max: 5 };
        list.parameter("trouble", "What goes wrong", trouble, |d, _| d.trouble, |d, _, v| d.trouble = v)
            .description
            .variability = Variability::Tunable;
        list.parameter("on", "Switch", Kind::Boolean, |d, _| d.on, |d, _, v| d.on = v).description.variability =
            Variability::Tunable;
        list.output("x", "Position", real(&unit::LENGTH), |d, seed, _| match seed {
            Seed::Time => Series::from_derivatives(d.x, d.g * d.u, d.g * d.u_dot),
            known => Series([d.x, known.of("x"), 0.0]),
        })
        .state();
        list.local("tolerance", "Requested", real(&unit::NUMBER)).at(1);
        list
    }

    fn text(&self) -> Text {
        Text::new("", &[])
    }

    fn curves(&self) -> Vec<Curve> {
        Vec::new()
    }

    fn experiment(&self) -> Experiment {
        Experiment { stop: 1.0, step: 0.1, tolerance: 1e-6 }
    }

    fn start(&mut self, _: f64) -> Result<(), Fault> {
        if self.trouble == FAULT_AT_START { Err(Fault::new("no steady state")) } else { Ok(()) }
    }

    fn apply(&mut self, _: f64) -> Result<(), Fault> {
        Ok(())
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        if self.trouble == FAULT {
            return Err(Fault::new("the machine has stalled"));
        }
        assert!(self.trouble != PANIC, "a bug");
        if self.trouble == NAN {
            self.x = f64::NAN;
        }
        let events = if self.trouble == MANY_EVENTS { 40 } else { 1 };
        for _ in 0..events {
            let kind = "50 % of #way";
            self.events.push(Event {
                time,
                kind,
                quantity: "u",
                value: self.u,
                unit: "m/s",
                follower: 0,
                about: About::Machine,
            });
        }
        self.x += self.g * (self.u + 0.5 * self.u_dot * step) * step;
        self.u_dot = 0.0;
        Ok(())
    }

    fn evaluate(&self, values: &mut [f64]) {
        values.copy_from_slice(&[self.x, self.tolerance]);
    }

    fn request_tolerance(&mut self, tolerance: f64) {
        self.tolerance = tolerance;
    }

    fn is_finite(&self) -> bool {
        self.x.is_finite()
    }

    fn events(&mut self) -> &mut EventLog {
        &mut self.events
    }
}

/// An instance and its log: status, category, text.
struct Bench {
    instance: Instance,
    log: Arc<Mutex<Vec<(u32, String, String)>>>,
}

impl Bench {
    fn new(logging_on: bool) -> Self {
        let log = Arc::new(Mutex::new(Vec::new()));
        let entries = log.clone();
        let sink = Box::new(move |status, category: &CStr, text: &CStr| {
            let owned = |s: &CStr| s.to_str().unwrap().to_owned();
            entries.lock().unwrap().push((status, owned(category), owned(text)));
        });
        let drive =
            (Model::of::<Integrator>().build)(&postcard::to_stdvec(&(2.0, [0_u8; 0].as_slice())).unwrap()).unwrap();
        Bench { instance: Instance::new(drive, "{guid}", Logger::new(sink, logging_on)), log }
    }

    /// An instance at the communication point 0.
    fn started(logging_on: bool) -> Self {
        let mut bench = Bench::new(logging_on);
        bench.ok(&table::SETUP_EXPERIMENT, |i| i.set_up(None, 0.0, None));
        bench.start();
        bench
    }

    fn start(&mut self) {
        self.ok(&table::ENTER_INITIALIZATION_MODE, Instance::enter_initialization);
        self.ok(&table::EXIT_INITIALIZATION_MODE, Instance::exit_initialization);
    }

    fn ok(&mut self, function: &table::Function, body: impl FnOnce(&mut Instance) -> Result<(), Refusal>) {
        let status = self.instance.call(function, body);
        assert_eq!(status, abi::OK, "{:?}", self.log.lock().unwrap());
    }

    /// Expects fmi2Error with exactly one log line, and returns it.
    fn refused(
        &mut self,
        function: &table::Function,
        body: impl FnOnce(&mut Instance) -> Result<(), Refusal>,
    ) -> String {
        self.log.lock().unwrap().clear();
        assert_eq!(self.instance.call(function, body), abi::ERROR);
        let mut log = self.log.lock().unwrap();
        assert_eq!(log.len(), 1, "{log:?}");
        let (status, category, text) = log.remove(0);
        assert_eq!((status, category.as_str()), (abi::ERROR, "logStatusError"));
        text
    }

    fn set(&mut self, reference: u32, value: f64) {
        self.ok(&table::SET_REAL, |i| Ok(i.set(Type::Real, &[reference], &[value])?));
    }

    fn trouble(&mut self, trouble: f64) {
        self.ok(&table::SET_INTEGER, |i| Ok(i.set(Type::Integer, &[TROUBLE], &[trouble])?));
    }

    fn get(&mut self, reference: u32) -> f64 {
        let mut value = f64::NAN;
        self.ok(&table::GET_REAL, |i| {
            value = i.get(Type::Real, reference)?;
            Ok(())
        });
        value
    }

    fn step(&mut self, point: f64, step: f64) {
        self.ok(&table::DO_STEP, |i| i.do_step(point, step));
    }

    fn step_refused(&mut self, point: f64, step: f64) -> String {
        self.refused(&table::DO_STEP, |i| i.do_step(point, step))
    }
}

#[test]
fn a_refused_value_changes_nothing_and_is_named() {
    let mut bench = Bench::new(false);
    let mut refuse = |r#type, values: &[(u32, f64)]| {
        let (references, values): (Vec<u32>, Vec<f64>) = values.iter().copied().unzip();
        bench.refused(&table::SET_REAL, |i| Ok(i.set(r#type, &references, &values)?))
    };
    assert_eq!(refuse(Type::Real, &[(U, 1.0), (G, 11.0)]), "fmi2SetReal: `g`: 11 is not admissible; expected 0 to 10");
    assert!(refuse(Type::Real, &[(U, f64::NAN)]).contains("`u`: NaN m is not admissible; expected any finite number"));
    assert!(refuse(Type::Real, &[(U, f64::INFINITY)]).contains("`u`"));
    assert!(refuse(Type::Real, &[(X, 1.0)]).contains("`x` is computed and cannot be set"));
    assert!(refuse(Type::Real, &[(99, 1.0)]).contains("value reference 99 does not exist; they end at 6"));
    assert!(refuse(Type::Integer, &[(G, 1.0)]).contains("`g` (value reference 1) has the type Real, not Integer"));
    assert!(refuse(Type::String, &[(G, 1.0)]).contains("not String"));
    assert!(refuse(Type::Integer, &[(TROUBLE, 6.0)]).contains("`trouble`: 6 is not admissible; expected 0 to 5"));
    assert!(refuse(Type::Boolean, &[(ON, 2.0)]).contains("`on`: 2 is not admissible; expected 0 (false) or 1 (true)"));
    bench.start();
    assert_eq!((bench.get(U), bench.get(G)), (0.0, 2.0));
    let fixed = bench.refused(&table::SET_REAL, |i| Ok(i.set(Type::Real, &[U, X0], &[3.0, 1.0])?));
    assert!(fixed.contains("`x0` is a fixed parameter"));
    assert_eq!(bench.get(U), 0.0);
}

#[test]
fn wrong_steps_are_refused_and_the_instance_goes_on() {
    let mut bench = Bench::new(false);
    bench.ok(&table::SETUP_EXPERIMENT, |i| i.set_up(Some(1e-4), 1.0, Some(2.0)));
    bench.start();
    for (point, step) in [(1.0, 0.0), (1.0, -0.1), (1.0, f64::NAN), (1.0, f64::INFINITY)] {
        assert!(bench.step_refused(point, step).contains("step size"), "{step}");
    }
    for point in [0.0, 1.0 + 1e-8, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(bench.step_refused(point, 0.1).contains("current communication point"), "{point}");
    }
    assert!(bench.step_refused(1.0, 1.1).contains("beyond the stop time 2 s"));
    bench.set(U, 1.0);
    bench.step(1.0 + 1e-10, 0.5);
    bench.step(1.5, 0.5 + 1e-10);
    assert!((bench.get(X) - 2.0).abs() < 1e-9);
    assert_eq!(bench.instance.last_successful_time(), 1.5 + (0.5 + 1e-10));
    assert!(bench.step_refused(2.0, 0.1).contains("stop time"));
}

#[test]
fn the_experiment_is_checked() {
    let mut bench = Bench::new(false);
    let mut refuse =
        |tolerance, start, stop| bench.refused(&table::SETUP_EXPERIMENT, |i| i.set_up(tolerance, start, stop));
    assert!(refuse(None, f64::NAN, None).contains("start time"));
    assert!(refuse(None, 1.0, Some(1.0)).contains("stop time"));
    assert!(refuse(None, 1.0, Some(f64::INFINITY)).contains("stop time"));
    assert!(refuse(Some(-1e-6), 0.0, None).contains("tolerance"));
    assert!(refuse(Some(f64::NAN), 0.0, None).contains("tolerance"));
    bench.ok(&table::SETUP_EXPERIMENT, |i| i.set_up(Some(1e-12), 0.0, None));
    bench.ok(&table::ENTER_INITIALIZATION_MODE, Instance::enter_initialization);
    assert_eq!(bench.get(TOLERANCE), 1e-12);
}

#[test]
fn a_start_that_is_impossible_can_be_mended() {
    let mut bench = Bench::new(false);
    bench.trouble(FAULT_AT_START);
    bench.ok(&table::ENTER_INITIALIZATION_MODE, Instance::enter_initialization);
    let text = bench.refused(&table::EXIT_INITIALIZATION_MODE, Instance::exit_initialization);
    assert_eq!(text, "fmi2ExitInitializationMode: no steady state");
    bench.trouble(0.0);
    bench.ok(&table::EXIT_INITIALIZATION_MODE, Instance::exit_initialization);
    bench.step(0.0, 0.1);
}

#[test]
fn a_step_that_fails_leaves_reset_and_restoring() {
    for (trouble, text) in [
        (FAULT, "fmi2DoStep: the machine has stalled"),
        (PANIC, "fmi2DoStep: internal error: a bug"),
        (NAN, "fmi2DoStep: `x` is not a finite number at t = 0.1 s"),
    ] {
        let mut bench = Bench::started(false);
        bench.set(U, 1.0);
        let saved = bench.instance.save();
        bench.trouble(trouble);
        assert_eq!(bench.step_refused(0.0, 0.1), text);
        let again = bench.step_refused(0.0, 0.1);
        assert_eq!(again, "fmi2DoStep: not allowed in the state `error`; it is allowed in `step complete`");
        bench.refused(&table::SET_REAL, |i| Ok(i.set(Type::Real, &[U], &[0.0])?));
        assert_eq!(bench.get(U), 1.0);

        bench.ok(&table::SET_FMU_STATE, |i| i.restore(&saved));
        bench.step(0.0, 0.5);
        assert_eq!(bench.get(X), 1.0);

        bench.trouble(trouble);
        bench.step_refused(0.5, 0.1);
        bench.ok(&table::RESET, Instance::reset);
        bench.start();
        assert_eq!((bench.get(U), bench.get(X), bench.get(TOLERANCE)), (0.0, 0.0, 0.0));
        bench.step(0.0, 0.1);
    }
}

#[test]
fn a_state_survives_its_bytes_and_no_others() {
    let mut bench = Bench::started(false);
    bench.set(U, 0.3);
    bench.step(0.0, 0.1);
    let state = bench.instance.save();
    let bytes = bench.instance.serialize(&state).unwrap();
    bench.step(0.1, 0.7);
    let end = bench.get(X);

    let mut other = Bench::new(false);
    let copy = other.instance.deserialize(&bytes).unwrap();
    assert_eq!(other.instance.serialize(&copy).unwrap(), bytes);
    other.ok(&table::SET_FMU_STATE, |i| i.restore(&copy));
    other.step(0.1, 0.7);
    assert_eq!(other.get(X).to_bits(), end.to_bits());

    let refuse = |bytes: &[u8]| other.instance.deserialize(bytes).err().expect("damaged bytes are refused").to_string();
    for place in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x10;
        refuse(&damaged);
        refuse(&bytes[..place]);
    }
    let mut longer = bytes.clone();
    longer.push(0);
    refuse(&longer);
    let drive = (Model::of::<Integrator>().build)(&postcard::to_stdvec(&(2.0, [0_u8; 0].as_slice())).unwrap()).unwrap();
    let foreign = Instance::new(drive, "{another}", Logger::new(Box::new(|_, _, _| ()), false));
    assert!(foreign.deserialize(&bytes).err().unwrap().to_string().contains("another guid"));
}

#[test]
fn derivatives_of_inputs_hold_for_one_step() {
    let mut bench = Bench::started(false);
    bench.set(U, 1.0);
    bench.ok(&table::SET_REAL_INPUT_DERIVATIVES, |i| i.set_input_derivatives([(U, 1, 4.0)].into_iter()));
    let derivatives =
        [bench.instance.output_derivative(X, 1).unwrap(), bench.instance.output_derivative(X, 2).unwrap()];
    assert_eq!(derivatives, [2.0, 8.0]);
    bench.step(0.0, 0.5);
    assert_eq!(bench.get(X), 2.0 * (0.5 + 2.0 * 0.25));
    bench.step(0.5, 0.5);
    assert_eq!(bench.get(X), 2.0 + 1.0);

    for (values, text) in [
        ([(U, 0, 1.0), (U, 1, 1.0)], "order 0"),
        ([(U, 2, 1.0), (U, 1, 1.0)], "not from 1 to 1"),
        ([(U, -1, 1.0), (U, 1, 1.0)], "order -1"),
        ([(U, 1, 1.0), (G, 1, 1.0)], "`g` is not an input"),
        ([(U, 1, 1.0), (U, 1, f64::NAN)], "NaN"),
        ([(U, 1, 1.0), (TROUBLE, 1, 1.0)], "Integer"),
        ([(U, 1, 1.0), (77, 1, 1.0)], "77"),
    ] {
        let refusal =
            bench.refused(&table::SET_REAL_INPUT_DERIVATIVES, |i| i.set_input_derivatives(values.into_iter()));
        assert!(refusal.contains(text), "{refusal}");
    }
    assert_eq!(bench.instance.output_derivative(X, 2).unwrap(), 0.0, "none of the refused values was set");
    assert!(bench.instance.output_derivative(X, 3).is_err());
    assert!(bench.instance.output_derivative(X, 0).is_err());
    assert!(bench.instance.output_derivative(G, 1).is_err());
    let mut derivative =
        |unknown, known, component| bench.instance.directional_derivatives(&[unknown], &[known], &[component]);
    assert_eq!(derivative(X, X, 1.0).unwrap(), [1.0]);
    assert_eq!(derivative(X, U, 1.0).unwrap(), [0.0]);
    assert_eq!(derivative(G, U, 0.0).unwrap(), [0.0]);
    for (unknown, known, component) in [(X, G, 1.0), (G, U, 1.0), (X, X, f64::NAN), (X, X, f64::INFINITY)] {
        assert!(derivative(unknown, known, component).is_err(), "{unknown} {known} {component}");
    }
}

#[test]
fn before_the_start_directional_derivatives_are_those_of_the_start_values() {
    let mut bench = Bench::new(false);
    bench.ok(&table::ENTER_INITIALIZATION_MODE, Instance::enter_initialization);
    for known in [U, G] {
        assert_eq!(bench.instance.directional_derivatives(&[X], &[known], &[1.0]).unwrap(), [0.0]);
    }
    assert!(bench.instance.directional_derivatives(&[X], &[U], &[f64::NAN]).is_err());
    for (unknown, known) in [(X, X), (G, U), (U, U)] {
        assert!(bench.instance.directional_derivatives(&[unknown], &[known], &[1.0]).is_err(), "{unknown} {known}");
    }
}

#[test]
fn events_reach_the_log_when_it_wants_them() {
    let mut bench = Bench::started(true);
    bench.set(U, 1e-9);
    bench.step(0.0, 0.1);
    bench.trouble(MANY_EVENTS);
    bench.step(0.1, 0.1);
    let log = std::mem::take(&mut *bench.log.lock().unwrap());
    let event = |text: &str| (abi::OK, "logEvents".to_owned(), text.to_owned());
    assert_eq!(log[0], event("t = 0 s: 50 %% of ##way, u = 1e-9 m/s"));
    assert_eq!(log.len(), 1 + 32 + 1);
    assert_eq!(log[33], event("8 further events of this step are not listed"));

    bench.ok(&table::SET_DEBUG_LOGGING, |i| i.set_debug_logging(true, [c"logSolver"].into_iter()));
    bench.step(0.2, 0.1);
    assert!(bench.log.lock().unwrap().is_empty());
    let text = bench.refused(&table::SET_DEBUG_LOGGING, |i| i.set_debug_logging(true, [c"logFoo"].into_iter()));
    assert!(text.contains("unknown log category `logFoo`; the categories are logStatusWarning, "), "{text}");
}

#[test]
fn the_call_sequence_is_enforced() {
    const MODES: [Mode; 5] =
        [Mode::Instantiated, Mode::Initialization, Mode::StepComplete, Mode::Terminated, Mode::Error];
    for function in table::FUNCTIONS {
        for mode in MODES {
            let mut bench = Bench::new(false);
            let mut state = bench.instance.save();
            state.clock.mode = mode;
            bench.instance.restore(&state).unwrap();
            if function.is_allowed_in(mode) {
                bench.ok(function, |_| Ok(()));
            } else {
                assert!(bench.refused(function, |_| Ok(())).starts_with(&format!("{}: not allowed ", function.name)));
            }
        }
    }
    let text = Bench::new(false).refused(&table::SET_TIME, |_| Ok(()));
    assert_eq!(text, "fmi2SetTime: not allowed since it belongs to Model Exchange; this FMU is for Co-Simulation");
}
