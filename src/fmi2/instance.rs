//! An instance of the FMU: the drive, its place in the call sequence and its log.

use super::abi::{self, fmi2Status};
use super::call_sequence::{Function, Mode};
use super::log::{Category, Logger};
use super::saved_state::{self, Clock, SavedState};
use crate::drives::event::{self, About};
use crate::drives::variable::Type;
use crate::drives::{AnyDrive, Fault, Number};
use std::any::Any;
use std::ffi::CStr;
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The reason why a call did not return fmi2OK.
#[derive(Debug, PartialEq)]
pub enum Refusal {
    /// fmi2Error, with the reason for the log.
    Error(Fault),
    /// fmi2Discard: the requested status is not available.
    NotAvailable,
}

impl From<Fault> for Refusal {
    fn from(fault: Fault) -> Self {
        Refusal::Error(fault)
    }
}

/// Tolerance for a step's communication point from the end of the last step, and for its end beyond the stop time, relative to the
/// times: importers add up their steps in double precision.
const TIME_TOLERANCE: f64 = 1e-9;

/// An instance.
pub struct Instance {
    drive: AnyDrive,
    fingerprint: u64,
    clock: Clock,
    logger: Logger,
    /// Whether the log records events.
    listens: bool,
}

/// The clock after fmi2Instantiate and fmi2Reset.
const BEGINNING: Clock = Clock { mode: Mode::Instantiated, time: 0.0, stop: NO_STOP };

/// A stop time that no step exceeds.
const NO_STOP: f64 = f64::MAX;

impl Instance {
    /// An instance of the FMU with this guid.
    pub fn new(drive: AnyDrive, guid: &str, logger: Logger) -> Self {
        let mut instance =
            Instance { drive, fingerprint: saved_state::fingerprint(guid), clock: BEGINNING, logger, listens: false };
        instance.listen();
        instance
    }

    /// Keeps events as long as the log records them.
    fn listen(&mut self) {
        let recorded = [Category::Warning, Category::Events, Category::Solver];
        self.listens = recorded.iter().any(|category| self.logger.wants(*category));
        self.drive.events().keep(self.listens);
    }

    /// Carries out a call: looks it up in the call sequence, catches a panic, logs the reason of an error.
    pub fn call(&mut self, function: &Function, body: impl FnOnce(&mut Self) -> Result<(), Refusal>) -> fmi2Status {
        if !function.is_allowed_in(self.clock.mode) {
            return self.out_of_sequence(function);
        }
        let outcome = catch_unwind(AssertUnwindSafe(|| body(self)));
        match outcome.unwrap_or_else(|panic| Err(self.panicked(panic))) {
            Ok(()) => abi::OK,
            Err(refusal) => self.report(function, refusal),
        }
    }

    /// The drive may have stopped amid a change; fmi2Reset and fmi2SetFMUstate replace it as a whole.
    #[cold]
    fn panicked(&mut self, panic: Box<dyn Any + Send>) -> Refusal {
        self.clock.mode = Mode::Error;
        let reason = panic.downcast_ref::<String>().map(String::as_str);
        let reason = reason.or(panic.downcast_ref::<&str>().copied()).unwrap_or("unknown reason");
        Fault::new(format!("internal error: {reason}")).into()
    }

    /// Logs that a function is not allowed now.
    #[cold]
    fn out_of_sequence(&self, function: &Function) -> fmi2Status {
        let reason = Reason(function, self.clock.mode);
        self.logger.log(Category::Error, format_args!("{}: not allowed {reason}", function.name));
        abi::ERROR
    }

    /// Logs why a call failed and returns its status.
    #[cold]
    fn report(&self, function: &Function, refusal: Refusal) -> fmi2Status {
        match refusal {
            Refusal::NotAvailable => abi::DISCARD,
            Refusal::Error(fault) => {
                self.logger.log(Category::Error, format_args!("{}: {fault}", function.name));
                abi::ERROR
            }
        }
    }

    /// fmi2SetDebugLogging.
    pub fn set_debug_logging<'a>(
        &mut self,
        on: bool,
        names: impl ExactSizeIterator<Item = &'a CStr>,
    ) -> Result<(), Refusal> {
        let outcome = self.logger.configure(on, names);
        self.listen();
        outcome.map_err(|unknown| {
            let known: Vec<_> = event::LOG_CATEGORIES.iter().map(|(name, _)| name.to_string_lossy()).collect();
            let unknown = unknown.to_string_lossy();
            Fault::new(format!("unknown log category `{unknown}`; the categories are {}", known.join(", "))).into()
        })
    }

    /// fmi2SetupExperiment.
    pub fn set_up(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Result<(), Refusal> {
        let refuse = |text: String| Err(Fault::new(text).into());
        if !start.is_finite() {
            return refuse(format!("the start time is {} s, not a finite number", Number(start)));
        }
        if let Some(stop) = stop.filter(|stop| !(start < *stop && stop.is_finite())) {
            let [stop, start] = [stop, start].map(Number);
            return refuse(format!("the stop time {stop} s is not a finite number after the start time {start} s"));
        }
        if let Some(tolerance) = tolerance.filter(|t| !(0.0 <= *t && t.is_finite())) {
            return refuse(format!("the tolerance {} is not a finite number ≥ 0", Number(tolerance)));
        }
        self.drive.set_up(start, tolerance);
        (self.clock.time, self.clock.stop) = (start, stop.unwrap_or(NO_STOP));
        Ok(())
    }

    /// fmi2EnterInitializationMode.
    pub fn enter_initialization(&mut self) -> Result<(), Refusal> {
        self.clock.mode = Mode::Initialization;
        Ok(())
    }

    /// fmi2ExitInitializationMode. If the parameters allow no start, they can be set anew.
    pub fn exit_initialization(&mut self) -> Result<(), Refusal> {
        self.drive.start()?;
        self.clock.mode = Mode::StepComplete;
        self.log_events();
        Ok(())
    }

    /// fmi2Terminate.
    pub fn terminate(&mut self) -> Result<(), Refusal> {
        self.clock.mode = Mode::Terminated;
        Ok(())
    }

    /// fmi2Reset.
    pub fn reset(&mut self) -> Result<(), Refusal> {
        self.drive.reset();
        self.clock = BEGINNING;
        Ok(())
    }

    /// fmi2DoStep.
    #[inline]
    pub fn do_step(&mut self, point: f64, step: f64) -> Result<(), Refusal> {
        self.check_step(point, step)?;
        let outcome = self.drive.advance(point, step);
        self.log_events();
        match outcome {
            Ok(()) => self.clock.time = point + step,
            Err(_) => self.clock.mode = Mode::Error,
        }
        Ok(outcome?)
    }

    #[inline(always)]
    fn check_step(&self, point: f64, step: f64) -> Result<(), Fault> {
        let Clock { time, stop, .. } = self.clock;
        let (end, tolerance) = (point + step, TIME_TOLERANCE * (point.abs() + step));
        // Comparisons with NaN are false. The tolerance is infinite if the point or the step is.
        let admissible = 0.0 < step && (point - time).abs() <= tolerance && end - stop <= tolerance;
        if admissible && tolerance < f64::INFINITY { Ok(()) } else { Err(self.inadmissible_step(point, step)) }
    }

    #[cold]
    fn inadmissible_step(&self, point: f64, step: f64) -> Fault {
        let Clock { time, stop, .. } = self.clock;
        let [here, end] = [Number(point), Number(point + step)];
        Fault::new(if !(0.0 < step && step.is_finite()) {
            format!("the communication step size {} s is not a finite number > 0", Number(step))
        } else if !((point - time).abs() <= TIME_TOLERANCE * (point.abs() + step) && point.is_finite()) {
            format!("the current communication point is {here} s, but the instance is at {} s", Number(time))
        } else {
            format!("the step from {here} s to {end} s goes beyond the stop time {} s", Number(stop))
        })
    }

    /// Passes the drive's events on to the log.
    fn log_events(&mut self) {
        if !self.listens {
            return;
        }
        let events = self.drive.events();
        for e in events.iter() {
            let category = match e.about {
                About::Machine | About::Loads => Category::Events,
                About::Solver => Category::Solver,
                About::Inputs => Category::Warning,
            };
            let (time, value) = (Number(e.time), Number(e.value));
            let separator = if e.unit.is_empty() { "" } else { " " };
            let event = format_args!("{}, {} = {value}{separator}{}", e.kind, e.quantity, e.unit);
            match e.follower {
                0 => self.logger.log(category, format_args!("t = {time} s: {event}")),
                j => self.logger.log(category, format_args!("t = {time} s: follower {j}: {event}")),
            }
        }
        if 0 < events.dropped() {
            let text = format_args!("{} further events of this step are not listed", events.dropped());
            self.logger.log(Category::Events, text);
        }
        events.clear();
    }

    /// Reads Reals.
    pub fn read(&mut self, references: &[u32], values: &mut [MaybeUninit<f64>]) -> Result<(), Fault> {
        self.drive.read(references, values)
    }

    /// Reads a variable.
    pub fn get(&mut self, r#type: Type, reference: u32) -> Result<f64, Fault> {
        let index = self.drive.variable(reference, r#type)?;
        self.drive.get(index)
    }

    /// Sets variables: all of them, or none if one is refused.
    pub fn set(&mut self, r#type: Type, references: &[u32], values: &[f64]) -> Result<(), Fault> {
        self.drive.write(r#type, references, values)
    }

    /// fmi2SetRealInputDerivatives: (reference, order, value); all of them or none.
    pub fn set_input_derivatives(
        &mut self,
        values: impl Iterator<Item = (u32, i32, f64)> + Clone,
    ) -> Result<(), Refusal> {
        for (reference, order, value) in values.clone() {
            let index = self.drive.variable(reference, Type::Real)?;
            self.drive.check_input_derivative(index, order_of(order)?, value)?;
        }
        for (reference, order, value) in values {
            self.drive.set_input_derivative(reference as usize, order_of(order)?, value)?;
        }
        Ok(())
    }

    /// One value of fmi2GetRealOutputDerivatives.
    pub fn output_derivative(&mut self, reference: u32, order: i32) -> Result<f64, Fault> {
        let index = self.drive.variable(reference, Type::Real)?;
        self.drive.output_derivative(index, order_of(order)?)
    }

    /// Σ ∂unknown/∂known · component over the knowns, for each unknown.
    pub fn directional_derivatives(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        components: &[f64],
    ) -> Result<Vec<f64>, Fault> {
        let place = |reference: &u32| self.drive.variable(*reference, Type::Real);
        let unknowns = unknowns.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        let knowns = knowns.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        let direction: Vec<_> = knowns.into_iter().zip(components.iter().copied()).collect();
        self.drive.directional_derivatives(&unknowns, &direction)
    }

    /// The communication point up to which the instance has computed (s).
    pub fn last_successful_time(&self) -> f64 {
        self.clock.time
    }

    /// The fingerprint of the guid.
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// fmi2GetFMUstate.
    pub fn save(&self) -> SavedState {
        SavedState::new(self.fingerprint, self.clock, self.drive.save())
    }

    /// fmi2SetFMUstate.
    pub fn restore(&mut self, state: &SavedState) -> Result<(), Refusal> {
        self.drive.restore(&state.drive);
        self.clock = state.clock;
        Ok(())
    }

    /// fmi2SerializeFMUstate.
    pub fn serialize(&self, state: &SavedState) -> Result<Vec<u8>, Fault> {
        saved_state::to_bytes(state)
    }

    /// fmi2DeSerializeFMUstate.
    pub fn deserialize(&self, bytes: &[u8]) -> Result<SavedState, Fault> {
        saved_state::from_bytes(bytes, self.fingerprint, &self.drive)
    }
}

fn order_of(order: i32) -> Result<usize, Fault> {
    usize::try_from(order).map_err(|_| Fault::new(format!("derivatives of order {order} do not exist")))
}

/// The reason why a function is not allowed.
struct Reason<'a>(&'a Function, Mode);

impl std::fmt::Display for Reason<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        use super::call_sequence::{CANCEL_STEP, FUNCTIONS};
        let modes = [Mode::Instantiated, Mode::Initialization, Mode::StepComplete, Mode::Terminated, Mode::Error];
        if *self.0 == CANCEL_STEP {
            f.write_str("since steps are synchronous: none is in progress")
        } else if modes.iter().all(|m| !self.0.is_allowed_in(*m)) {
            debug_assert!(FUNCTIONS.contains(self.0));
            f.write_str("since it belongs to Model Exchange; this FMU is for Co-Simulation")
        } else {
            write!(f, "in the state `{}`; it is allowed in", self.1.name())?;
            for (i, mode) in modes.iter().filter(|m| self.0.is_allowed_in(**m)).enumerate() {
                write!(f, "{}`{}`", if i == 0 { " " } else { ", " }, mode.name())?;
            }
            Ok(())
        }
    }
}
