//! The C types of fmi2TypesPlatform.h and fmi2FunctionTypes.h.
//!
//! Written by hand, so that the runtime library needs no generated bindings; `tests/abi.rs` compares the signatures of all
//! functions with the standard's headers.
#![allow(non_camel_case_types, non_snake_case)]

use std::ffi::{c_char, c_double, c_int, c_uint, c_void};

/// An instance, as the importer holds it.
pub type fmi2Component = *mut c_void;
/// Environment that callbacks return to the importer.
pub type fmi2ComponentEnvironment = *mut c_void;
/// A saved state, as the importer holds it.
pub type fmi2FMUstate = *mut c_void;
/// The identification of a variable.
pub type fmi2ValueReference = c_uint;
/// A Real.
pub type fmi2Real = c_double;
/// An Integer or an Enumeration.
pub type fmi2Integer = c_int;
/// A Boolean: [`FALSE`] or [`TRUE`].
pub type fmi2Boolean = c_int;
/// A character.
pub type fmi2Char = c_char;
/// A NUL-terminated string in UTF-8.
pub type fmi2String = *const fmi2Char;
/// A byte of a serialised state.
pub type fmi2Byte = c_char;

/// A C enumeration; compilers for Windows take a signed integer.
#[cfg(windows)]
pub type Enumeration = c_int;
/// A C enumeration; compilers for Windows take a signed integer.
#[cfg(not(windows))]
pub type Enumeration = c_uint;

/// Result of a call.
pub type fmi2Status = Enumeration;
/// Model Exchange or Co-Simulation.
pub type fmi2Type = Enumeration;
/// Kind of the requested status.
pub type fmi2StatusKind = Enumeration;

/// fmi2False.
pub const FALSE: fmi2Boolean = 0;
/// fmi2True.
pub const TRUE: fmi2Boolean = 1;

/// fmi2OK.
pub const OK: fmi2Status = 0;
/// fmi2Warning.
pub const WARNING: fmi2Status = 1;
/// fmi2Discard.
pub const DISCARD: fmi2Status = 2;
/// fmi2Error.
pub const ERROR: fmi2Status = 3;
/// fmi2Fatal.
pub const FATAL: fmi2Status = 4;

/// fmi2CoSimulation.
pub const CO_SIMULATION: fmi2Type = 1;

/// fmi2DoStepStatus.
pub const DO_STEP_STATUS: fmi2StatusKind = 0;
/// fmi2PendingStatus.
pub const PENDING_STATUS: fmi2StatusKind = 1;
/// fmi2LastSuccessfulTime.
pub const LAST_SUCCESSFUL_TIME: fmi2StatusKind = 2;
/// fmi2Terminated.
pub const TERMINATED: fmi2StatusKind = 3;

/// fmi2CallbackLogger: environment, instance name, status, category, format and its arguments.
pub type fmi2CallbackLogger =
    unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
/// fmi2CallbackAllocateMemory.
pub type fmi2CallbackAllocateMemory = unsafe extern "C" fn(usize, usize) -> *mut c_void;
/// fmi2CallbackFreeMemory.
pub type fmi2CallbackFreeMemory = unsafe extern "C" fn(*mut c_void);
/// fmi2StepFinished.
pub type fmi2StepFinished = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2Status);

/// Callbacks that the importer offers.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fmi2CallbackFunctions {
    /// Takes log messages.
    pub logger: Option<fmi2CallbackLogger>,
    /// Not used: `canNotUseMemoryManagementFunctions`.
    pub allocateMemory: Option<fmi2CallbackAllocateMemory>,
    /// Not used.
    pub freeMemory: Option<fmi2CallbackFreeMemory>,
    /// Not used: steps are synchronous.
    pub stepFinished: Option<fmi2StepFinished>,
    /// Handed to the callbacks.
    pub componentEnvironment: fmi2ComponentEnvironment,
}

/// Event information of Model Exchange; only its address passes through the interface.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct fmi2EventInfo {
    /// More discrete states to compute.
    pub newDiscreteStatesNeeded: fmi2Boolean,
    /// The simulation is to end.
    pub terminateSimulation: fmi2Boolean,
    /// Nominal values have changed.
    pub nominalsOfContinuousStatesChanged: fmi2Boolean,
    /// States have changed.
    pub valuesOfContinuousStatesChanged: fmi2Boolean,
    /// Whether the next event is known.
    pub nextEventTimeDefined: fmi2Boolean,
    /// The time of the next event (s).
    pub nextEventTime: fmi2Real,
}
