//! All functions of fmi2Functions.h: C types, pointers and nothing else. The only unsafe code of the crate.
//!
//! Every function passes `enter`, which checks the call sequence and catches panics. A panic also prints its place on stderr, as
//! Rust programs do: it is a fault of this library, and a hook to silence it would be process-wide where a Rust program links the
//! crate.
//!
//! # Safety
//! All functions rely on the standard's demands on an importer: an instance comes from [`fmi2Instantiate`], is not yet freed and is
//! used by one thread at a time; an array has the stated length; a string ends in NUL. The logger calls no function with the
//! instance that logs: the logging call uses it exclusively. NULL and misaligned pointers are refused.
#![allow(non_snake_case, clippy::missing_safety_doc)]

use super::abi::*;
use super::call_sequence::{self as table, Function};
use super::instance::{Instance, Refusal};
use super::log::{Category, Logger, Sink};
use super::saved_state::{ALIVE, SavedState};
use super::{plans, resource_location};
use crate::drives::variable::Type;
use crate::drives::{AnyDrive, Fault};
use std::ffi::{CStr, CString, c_char};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

type Outcome = Result<(), Refusal>;

// ---------------------------------------------------------------------------------------------------------------
// Pointers

/// Carries out `body` on the instance behind `component`.
fn enter(component: fmi2Component, function: &Function, body: impl FnOnce(&mut Instance) -> Outcome) -> fmi2Status {
    let instance = component.cast::<Instance>();
    if !instance.is_aligned() {
        return ERROR;
    }
    // SAFETY: not NULL and aligned; the importer passes a live instance and uses it from one thread at a time, so
    // the reference is unique for the time of the call.
    match unsafe { instance.as_mut() } {
        Some(instance) => instance.call(function, body),
        None => ERROR,
    }
}

/// Whether `count` elements can be behind `pointer`.
fn check_array<T>(pointer: *const T, count: usize, name: &str) -> Result<(), Fault> {
    if pointer.is_null() || !pointer.is_aligned() || (isize::MAX as usize) / size_of::<T>() < count {
        return Err(no_array(pointer.is_null(), count, name));
    }
    Ok(())
}

#[cold]
fn no_array(is_null: bool, count: usize, name: &str) -> Fault {
    Fault::new(if is_null { format!("`{name}` is NULL") } else { format!("`{name}` is not an array of {count} items") })
}

/// An array of the importer; NULL will do if it is empty.
///
/// # Safety
/// If `pointer` is not NULL, it points to `count` initialised elements for the time of the call.
unsafe fn array<'a, T>(pointer: *const T, count: usize, name: &str) -> Result<&'a [T], Fault> {
    if count == 0 {
        return Ok(&[]);
    }
    check_array(pointer, count, name)?;
    // SAFETY: not NULL, aligned, of admissible size; the caller vouches for the rest.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// An array of the importer to write to; NULL will do if it is empty.
///
/// # Safety
/// If `pointer` is not NULL, it points to memory of `count` elements for the time of the call, and no other argument overlaps it.
unsafe fn array_mut<'a, T>(pointer: *mut T, count: usize, name: &str) -> Result<&'a mut [MaybeUninit<T>], Fault> {
    if count == 0 {
        return Ok(&mut []);
    }
    check_array(pointer, count, name)?;
    // SAFETY: not NULL, aligned, of admissible size; the caller vouches for the rest.
    Ok(unsafe { std::slice::from_raw_parts_mut(pointer.cast::<MaybeUninit<T>>(), count) })
}

/// The place of a single result.
///
/// # Safety
/// As [`array_mut`] with one element.
unsafe fn place<'a, T>(pointer: *mut T, name: &str) -> Result<&'a mut MaybeUninit<T>, Fault> {
    // SAFETY: passed on to the caller.
    Ok(unsafe { &mut array_mut(pointer, 1, name)?[0] })
}

/// A string of the importer; None if it is NULL.
///
/// # Safety
/// If `pointer` is not NULL, it points to a NUL-terminated string for the time of the call.
unsafe fn string<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: not NULL; the caller vouches for the rest.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

/// The living state of this FMU that a handle points to.
///
/// # Safety
/// If `handle` is not NULL, it points to at least two words. If these are the words of a living state of this FMU, it is one, and
/// no other reference uses it during the call.
unsafe fn saved<'a>(handle: fmi2FMUstate, instance: &Instance) -> Result<&'a mut SavedState, Fault> {
    let state = handle.cast::<SavedState>();
    check_array(state, 1, "FMUstate")?;
    // SAFETY: not NULL and aligned; the two words are of fixed layout in every version of the library.
    let (mark, fingerprint) = unsafe { ((&raw const (*state).mark).read(), (&raw const (*state).fingerprint).read()) };
    if mark != ALIVE {
        return Err(Fault::new("`FMUstate` is not a saved state, or was freed"));
    }
    if fingerprint != instance.fingerprint() {
        return Err(Fault::new("`FMUstate` belongs to an FMU with another guid"));
    }
    // SAFETY: a living state of this very FMU, hence made by the same code.
    Ok(unsafe { &mut *state })
}

/// Passes a state to the importer: into the existing one if the importer passes its handle, else as a new one.
///
/// # Safety
/// `handle` as [`place`], initialised; its content as [`saved`].
unsafe fn hand_over(handle: *mut fmi2FMUstate, state: SavedState, instance: &Instance) -> Outcome {
    check_array(handle, 1, "FMUstate")?;
    // SAFETY: not NULL and aligned; the caller vouches for the rest.
    unsafe {
        if (*handle).is_null() {
            *handle = Box::into_raw(Box::new(state)).cast();
        } else {
            *saved(*handle, instance)? = state;
        }
    }
    Ok(())
}

// ---------------------------------------------------------------------------------------------------------------
// Inquiry, creation, log

/// The platform of the C types.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// The version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// Creates an instance; NULL, with the reason in the log, if that is impossible.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instanceName: fmi2String,
    fmuType: fmi2Type,
    fmuGUID: fmi2String,
    fmuResourceLocation: fmi2String,
    functions: *const fmi2CallbackFunctions,
    _visible: fmi2Boolean,
    loggingOn: fmi2Boolean,
) -> fmi2Component {
    if functions.is_null() || !functions.is_aligned() {
        return std::ptr::null_mut();
    }
    // SAFETY: not NULL and aligned; the importer passes its callbacks. They are copied, since the struct may be gone
    // after the call.
    let callbacks = unsafe { functions.read() };
    // SAFETY: NULL or strings of the importer, which are copied.
    let (name, guid, location) = unsafe { (string(instanceName), string(fmuGUID), string(fmuResourceLocation)) };
    // Without a logger there would be no messages; the standard demands one. The memory callbacks may be NULL.
    let Some(sink) = sink(&callbacks, name) else { return std::ptr::null_mut() };
    let logger = Logger::new(sink, loggingOn != FALSE);

    let refuse = |logger: &Logger, reason: &dyn std::fmt::Display| {
        logger.log(Category::Error, format_args!("fmi2Instantiate: {reason}"));
        std::ptr::null_mut()
    };
    match catch_unwind(AssertUnwindSafe(|| create(name, fmuType, guid, location))) {
        Ok(Ok((drive, guid))) => Box::into_raw(Box::new(Instance::new(drive, &guid, logger))).cast(),
        Ok(Err(fault)) => refuse(&logger, &fault),
        Err(_) => refuse(&logger, &"internal error"),
    }
}

/// The drive and its guid.
fn create(
    name: Option<&CStr>,
    fmu_type: fmi2Type,
    guid: Option<&CStr>,
    location: Option<&CStr>,
) -> Result<(AnyDrive, String), Fault> {
    if name.is_none_or(CStr::is_empty) {
        return Err(Fault::new("`instanceName` is NULL or empty"));
    }
    if fmu_type != CO_SIMULATION {
        return Err(Fault::new(format!(
            "`fmuType` is {fmu_type}; this FMU is for Co-Simulation ({CO_SIMULATION}) only"
        )));
    }
    let guid = guid.ok_or(Fault::new("`fmuGUID` is NULL"))?.to_string_lossy();
    let location = location.map(CStr::to_string_lossy);
    let resource = resource_location::read(location.as_deref(), own_library().as_deref())?;
    Ok((plans::of(&resource, &guid)?.instance(), guid.into_owned()))
}

/// Passes messages to the importer's logger; None if it has none.
fn sink(callbacks: &fmi2CallbackFunctions, name: Option<&CStr>) -> Option<Sink> {
    let (logger, environment) = (callbacks.logger?, callbacks.componentEnvironment);
    let name = CString::from(name.unwrap_or_default());
    Some(Box::new(move |status, category, text| {
        // Loggers that drop the variadic arguments show the format, so the text itself takes that place. It is passed as an
        // argument as well, for loggers that read one.
        unsafe { logger(environment, name.as_ptr(), status, category.as_ptr(), text.as_ptr(), text.as_ptr()) }
    }))
}

/// The file of this library.
#[cfg(unix)]
fn own_library() -> Option<PathBuf> {
    use std::ffi::c_void;
    use std::os::unix::ffi::OsStrExt;

    /// Dl_info of dlfcn.h.
    #[repr(C)]
    struct DlInfo {
        file: *const c_char,
        base: *mut c_void,
        symbol: *const c_char,
        address: *mut c_void,
    }
    unsafe extern "C" {
        fn dladdr(address: *const c_void, info: *mut DlInfo) -> std::ffi::c_int;
    }
    let mut info = MaybeUninit::<DlInfo>::uninit();
    let address = fmi2GetVersion as extern "C" fn() -> *const c_char as *const c_void;
    // SAFETY: `info` has the layout of Dl_info, and dladdr fills it if it returns anything but 0; then the name of
    // the file lives as long as the library is loaded.
    let file = unsafe {
        if dladdr(address, info.as_mut_ptr()) == 0 {
            return None;
        }
        string(info.assume_init().file)?
    };
    let path = PathBuf::from(std::ffi::OsStr::from_bytes(file.to_bytes()));
    Some(path.canonicalize().unwrap_or(path))
}

/// On other systems importers have to name the resources folder.
#[cfg(not(unix))]
fn own_library() -> Option<PathBuf> {
    None
}

/// Ends an instance; NULL is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: fmi2Component) {
    let instance = c.cast::<Instance>();
    if !instance.is_null() && instance.is_aligned() {
        // SAFETY: made by Box::into_raw in fmi2Instantiate; the importer uses it no more. A panic must not leave.
        let _ = catch_unwind(AssertUnwindSafe(|| {
            drop(unsafe { Box::from_raw(instance) });
            plans::clear();
        }));
    }
}

/// Chooses the messages of the log.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: fmi2Component,
    loggingOn: fmi2Boolean,
    nCategories: usize,
    categories: *const fmi2String,
) -> fmi2Status {
    enter(c, &table::SET_DEBUG_LOGGING, |instance| {
        // SAFETY: an array of the importer.
        let names = unsafe { array(categories, nCategories, "categories")? };
        if names.iter().any(|name| name.is_null()) {
            return Err(Fault::new("a log category is NULL").into());
        }
        // SAFETY: strings of the importer, not NULL.
        let names = names.iter().map(|name| unsafe { CStr::from_ptr(*name) });
        instance.set_debug_logging(loggingOn != FALSE, names)
    })
}

// ---------------------------------------------------------------------------------------------------------------
// Initialisation and end

/// Sets tolerance, start time and stop time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: fmi2Component,
    toleranceDefined: fmi2Boolean,
    tolerance: fmi2Real,
    startTime: fmi2Real,
    stopTimeDefined: fmi2Boolean,
    stopTime: fmi2Real,
) -> fmi2Status {
    enter(c, &table::SETUP_EXPERIMENT, |instance| {
        let given = |defined: fmi2Boolean, value| (defined != FALSE).then_some(value);
        instance.set_up(given(toleranceDefined, tolerance), startTime, given(stopTimeDefined, stopTime))
    })
}

/// Begins initialisation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: fmi2Component) -> fmi2Status {
    enter(c, &table::ENTER_INITIALIZATION_MODE, Instance::enter_initialization)
}

/// Computes the initial state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: fmi2Component) -> fmi2Status {
    enter(c, &table::EXIT_INITIALIZATION_MODE, Instance::exit_initialization)
}

/// Ends the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: fmi2Component) -> fmi2Status {
    enter(c, &table::TERMINATE, Instance::terminate)
}

/// Returns to the state after fmi2Instantiate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: fmi2Component) -> fmi2Status {
    enter(c, &table::RESET, Instance::reset)
}

// ---------------------------------------------------------------------------------------------------------------
// Values

/// An array of value references.
struct References {
    vr: *const fmi2ValueReference,
    count: usize,
}

/// Reads variables of another type than Real.
///
/// # Safety
/// As [`array()`] and [`array_mut`].
unsafe fn get<T>(
    instance: &mut Instance,
    r#type: Type,
    References { vr, count }: References,
    value: *mut T,
    from: impl Fn(f64) -> T,
) -> Outcome {
    // SAFETY: passed on to the caller.
    let (references, values) = unsafe { (array(vr, count, "vr")?, array_mut(value, count, "value")?) };
    for (reference, value) in references.iter().zip(values) {
        value.write(from(instance.get(r#type, *reference)?));
    }
    Ok(())
}

/// Sets variables of another type than Real.
///
/// # Safety
/// As [`array()`].
unsafe fn set<T: Copy>(
    instance: &mut Instance,
    r#type: Type,
    References { vr, count }: References,
    value: *const T,
    from: impl Fn(T) -> f64,
) -> Outcome {
    // SAFETY: passed on to the caller.
    let (references, values) = unsafe { (array(vr, count, "vr")?, array(value, count, "value")?) };
    let values: Vec<f64> = values.iter().map(|value| from(*value)).collect();
    Ok(instance.set(r#type, references, &values)?)
}

/// Reads Reals.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *mut fmi2Real,
) -> fmi2Status {
    enter(c, &table::GET_REAL, |instance| {
        // SAFETY: arrays of the importer.
        let (references, values) = unsafe { (array(vr, nvr, "vr")?, array_mut(value, nvr, "value")?) };
        Ok(instance.read(references, values)?)
    })
}

/// Sets Reals.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    value: *const fmi2Real,
) -> fmi2Status {
    enter(c, &table::SET_REAL, |instance| {
        // SAFETY: arrays of the importer.
        let (references, values) = unsafe { (array(vr, nvr, "vr")?, array(value, nvr, "value")?) };
        Ok(instance.set(Type::Real, references, values)?)
    })
}

/// Functions for variables of another type than Real: by `get` or `set` with this conversion.
macro_rules! values {
    ($($(#[$doc:meta])* $name:ident, $row:ident, $access:ident $kind:ident, $value:ty, $convert:expr;)*) => {
        $(
            $(#[$doc])*
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name(
                c: fmi2Component,
                vr: *const fmi2ValueReference,
                nvr: usize,
                value: $value,
            ) -> fmi2Status {
                // SAFETY: arrays of the importer.
                enter(c, &table::$row, |i| unsafe { $access(i, Type::$kind, References { vr, count: nvr }, value, $convert) })
            }
        )*
    };
}

values! {
    /// Reads Integers and Enumerations.
    fmi2GetInteger, GET_INTEGER, get Integer, *mut fmi2Integer, |v| v as fmi2Integer;
    /// Reads Booleans.
    fmi2GetBoolean, GET_BOOLEAN, get Boolean, *mut fmi2Boolean, |v| v as fmi2Boolean;
    /// Reads Strings; no variable is one.
    fmi2GetString, GET_STRING, get String, *mut fmi2String, |_| c"".as_ptr();
    /// Sets Integers and Enumerations.
    fmi2SetInteger, SET_INTEGER, set Integer, *const fmi2Integer, f64::from;
    /// Sets Booleans.
    fmi2SetBoolean, SET_BOOLEAN, set Boolean, *const fmi2Boolean, f64::from;
    /// Sets Strings; no variable is one.
    fmi2SetString, SET_STRING, set String, *const fmi2String, |_| 0.0;
}

// ---------------------------------------------------------------------------------------------------------------
// The FMU state

/// Saves the state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status {
    // SAFETY: the importer passes a place that holds NULL or a saved state.
    enter(c, &table::GET_FMU_STATE, |instance| unsafe { hand_over(FMUstate, instance.save(), instance) })
}

/// Restores a state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: fmi2Component, FMUstate: fmi2FMUstate) -> fmi2Status {
    enter(c, &table::SET_FMU_STATE, |instance| {
        // SAFETY: the importer passes a saved state.
        let state = unsafe { saved(FMUstate, instance)? };
        instance.restore(state)
    })
}

/// Frees a state and sets the handle to NULL; NULL is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: fmi2Component, FMUstate: *mut fmi2FMUstate) -> fmi2Status {
    enter(c, &table::FREE_FMU_STATE, |instance| {
        if FMUstate.is_null() {
            return Ok(());
        }
        check_array(FMUstate, 1, "FMUstate")?;
        // SAFETY: not NULL and aligned; the importer passes a place that holds NULL or a saved state, which it no longer uses. A
        // write that the compiler must not drop clears the mark, so that a second handle to the same state is recognised as freed
        // as long as the memory is not used again.
        unsafe {
            if !(*FMUstate).is_null() {
                let state: *mut SavedState = saved(*FMUstate, instance)?;
                (&raw mut (*state).mark).write_volatile(0);
                drop(Box::from_raw(state));
                *FMUstate = std::ptr::null_mut();
            }
        }
        Ok(())
    })
}

/// How many bytes a saved state takes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    size: *mut usize,
) -> fmi2Status {
    enter(c, &table::SERIALIZED_FMU_STATE_SIZE, |instance| {
        // SAFETY: the importer passes a saved state and the place of the result.
        let (state, size) = unsafe { (saved(FMUstate, instance)?, place(size, "size")?) };
        size.write(instance.serialize(state)?.len());
        Ok(())
    })
}

/// Writes a saved state as bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: fmi2Component,
    FMUstate: fmi2FMUstate,
    serializedState: *mut fmi2Byte,
    size: usize,
) -> fmi2Status {
    enter(c, &table::SERIALIZE_FMU_STATE, |instance| {
        // SAFETY: the importer passes a saved state and memory of this size.
        let (state, memory) =
            unsafe { (saved(FMUstate, instance)?, array_mut(serializedState, size, "serializedState")?) };
        let bytes = instance.serialize(state)?;
        if memory.len() != bytes.len() {
            return Err(Fault::new(format!("`size` is {size}, but the state takes {} bytes", bytes.len())).into());
        }
        for (place, byte) in memory.iter_mut().zip(bytes) {
            place.write(byte as fmi2Byte);
        }
        Ok(())
    })
}

/// Makes a saved state from its bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: fmi2Component,
    serializedState: *const fmi2Byte,
    size: usize,
    FMUstate: *mut fmi2FMUstate,
) -> fmi2Status {
    enter(c, &table::DE_SERIALIZE_FMU_STATE, |instance| {
        // SAFETY: the importer passes an array of this size and a place that holds NULL or a saved state.
        unsafe {
            let bytes = array(serializedState.cast::<u8>(), size, "serializedState")?;
            hand_over(FMUstate, instance.deserialize(bytes)?, instance)
        }
    })
}

// ---------------------------------------------------------------------------------------------------------------
// Derivatives

/// Derivatives of unknowns in a direction of the knowns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: fmi2Component,
    vUnknown_ref: *const fmi2ValueReference,
    nUnknown: usize,
    vKnown_ref: *const fmi2ValueReference,
    nKnown: usize,
    dvKnown: *const fmi2Real,
    dvUnknown: *mut fmi2Real,
) -> fmi2Status {
    enter(c, &table::GET_DIRECTIONAL_DERIVATIVE, |instance| {
        // SAFETY: arrays of the importer.
        let (unknowns, knowns) =
            unsafe { (array(vUnknown_ref, nUnknown, "vUnknown_ref")?, array(vKnown_ref, nKnown, "vKnown_ref")?) };
        // SAFETY: arrays of the importer.
        let (direction, results) =
            unsafe { (array(dvKnown, nKnown, "dvKnown")?, array_mut(dvUnknown, nUnknown, "dvUnknown")?) };
        for (result, value) in results.iter_mut().zip(instance.directional_derivatives(unknowns, knowns, direction)?) {
            result.write(value);
        }
        Ok(())
    })
}

/// Sets time derivatives of inputs for the next step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *const fmi2Real,
) -> fmi2Status {
    enter(c, &table::SET_REAL_INPUT_DERIVATIVES, |instance| {
        // SAFETY: arrays of the importer.
        let (references, orders, values) =
            unsafe { (array(vr, nvr, "vr")?, array(order, nvr, "order")?, array(value, nvr, "value")?) };
        let values = references.iter().zip(orders).zip(values).map(|((r, order), value)| (*r, *order, *value));
        instance.set_input_derivatives(values)
    })
}

/// Reads time derivatives of outputs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: fmi2Component,
    vr: *const fmi2ValueReference,
    nvr: usize,
    order: *const fmi2Integer,
    value: *mut fmi2Real,
) -> fmi2Status {
    enter(c, &table::GET_REAL_OUTPUT_DERIVATIVES, |instance| {
        // SAFETY: arrays of the importer.
        let (references, orders, values) =
            unsafe { (array(vr, nvr, "vr")?, array(order, nvr, "order")?, array_mut(value, nvr, "value")?) };
        for ((reference, order), value) in references.iter().zip(orders).zip(values) {
            value.write(instance.output_derivative(*reference, *order)?);
        }
        Ok(())
    })
}

// ---------------------------------------------------------------------------------------------------------------
// Steps

/// Advances by a communication step. The hint `noSetFMUStatePriorToCurrentPoint` changes nothing here.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    c: fmi2Component,
    currentCommunicationPoint: fmi2Real,
    communicationStepSize: fmi2Real,
    _noSetFMUStatePriorToCurrentPoint: fmi2Boolean,
) -> fmi2Status {
    enter(c, &table::DO_STEP, |i| i.do_step(currentCommunicationPoint, communicationStepSize))
}

/// Steps are synchronous, so no step is ever in progress.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: fmi2Component) -> fmi2Status {
    enter(c, &table::CANCEL_STEP, |_| Ok(()))
}

/// Answers an inquiry about the last step; `answer` is None if there is no answer.
///
/// # Safety
/// As [`place`].
unsafe fn status<T>(kind: fmi2StatusKind, value: *mut T, answer: Option<T>) -> Outcome {
    if TERMINATED < kind {
        return Err(Fault::new(format!("the status kind {kind} does not exist")).into());
    }
    // SAFETY: passed on to the caller.
    let place = unsafe { place(value, "value")? };
    place.write(answer.ok_or(Refusal::NotAvailable)?);
    Ok(())
}

/// Asynchronous steps are not available.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Status) -> fmi2Status {
    // SAFETY: the importer passes the place of the result.
    enter(c, &table::GET_STATUS, |_| unsafe { status(s, value, None) })
}

/// The end of the last successful step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: fmi2Component, s: fmi2StatusKind, value: *mut fmi2Real) -> fmi2Status {
    enter(c, &table::GET_REAL_STATUS, |instance| {
        let answer = (s == LAST_SUCCESSFUL_TIME).then(|| instance.last_successful_time());
        // SAFETY: the importer passes the place of the result.
        unsafe { status(s, value, answer) }
    })
}

/// No status is an Integer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2Integer,
) -> fmi2Status {
    // SAFETY: the importer passes the place of the result.
    enter(c, &table::GET_INTEGER_STATUS, |_| unsafe { status(s, value, None) })
}

/// Whether the drive wants to end the simulation: it never does.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2Boolean,
) -> fmi2Status {
    // SAFETY: the importer passes the place of the result.
    enter(c, &table::GET_BOOLEAN_STATUS, |_| unsafe {
        status(s, value, (s == super::abi::TERMINATED).then_some(FALSE))
    })
}

/// Asynchronous steps are not available.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(
    c: fmi2Component,
    s: fmi2StatusKind,
    value: *mut fmi2String,
) -> fmi2Status {
    // SAFETY: the importer passes the place of the result.
    enter(c, &table::GET_STRING_STATUS, |_| unsafe { status(s, value, None) })
}

// ---------------------------------------------------------------------------------------------------------------
// Model Exchange: exported since importers look all functions up, refused by the call sequence

macro_rules! model_exchange {
    ($($name:ident, $row:ident, ($($type:ty),*);)*) => {
        $(
            /// Function of Model Exchange: refused.
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name(c: fmi2Component, $(_: $type),*) -> fmi2Status {
                enter(c, &table::$row, |_| Ok(()))
            }
        )*
    };
}

model_exchange! {
    fmi2EnterEventMode, ENTER_EVENT_MODE, ();
    fmi2NewDiscreteStates, NEW_DISCRETE_STATES, (*mut fmi2EventInfo);
    fmi2EnterContinuousTimeMode, ENTER_CONTINUOUS_TIME_MODE, ();
    fmi2CompletedIntegratorStep, COMPLETED_INTEGRATOR_STEP, (fmi2Boolean, *mut fmi2Boolean, *mut fmi2Boolean);
    fmi2SetTime, SET_TIME, (fmi2Real);
    fmi2SetContinuousStates, SET_CONTINUOUS_STATES, (*const fmi2Real, usize);
    fmi2GetDerivatives, GET_DERIVATIVES, (*mut fmi2Real, usize);
    fmi2GetEventIndicators, GET_EVENT_INDICATORS, (*mut fmi2Real, usize);
    fmi2GetContinuousStates, GET_CONTINUOUS_STATES, (*mut fmi2Real, usize);
    fmi2GetNominalsOfContinuousStates, GET_NOMINALS, (*mut fmi2Real, usize);
}
