//! An FMU whose library misbehaves as its parameter `fault` says. `tests/cli.rs` compiles it by itself and packs it.
//!
//! Its output is y = t; what it does it does in the step that ends at 0.5 s or behind it.
#![crate_type = "cdylib"]
#![allow(non_snake_case)]

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::sync::atomic::{AtomicI32, AtomicU64, Ordering::Relaxed};

/// The one instance of a process.
static FAULT: AtomicI32 = AtomicI32::new(0);
static TIME: AtomicU64 = AtomicU64::new(0);

#[unsafe(no_mangle)]
extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2Instantiate(
    _: *const c_char,
    _: c_int,
    _: *const c_char,
    _: *const c_char,
    _: *const c_void,
    _: c_int,
    _: c_int,
) -> *mut c_void {
    FAULT.store(0, Relaxed);
    (&raw const FAULT).cast_mut().cast()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2FreeInstance(_: *mut c_void) {}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetupExperiment(_: *mut c_void, _: c_int, _: f64, start: f64, _: c_int, _: f64) -> c_int {
    TIME.store(start.to_bits(), Relaxed);
    0
}

#[unsafe(no_mangle)]
extern "C" fn fmi2EnterInitializationMode(_: *mut c_void) -> c_int {
    0
}

#[unsafe(no_mangle)]
extern "C" fn fmi2ExitInitializationMode(_: *mut c_void) -> c_int {
    0
}

#[unsafe(no_mangle)]
extern "C" fn fmi2Terminate(_: *mut c_void) -> c_int {
    if FAULT.load(Relaxed) == 9 {
        std::process::abort();
    }
    0
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetReal(_: *mut c_void, _: *const c_uint, count: usize, values: *mut f64) -> c_int {
    let time = f64::from_bits(TIME.load(Relaxed));
    let is_none = FAULT.load(Relaxed) == 6 && time >= 0.5;
    for i in 0..count {
        unsafe { *values.add(i) = if is_none { f64::NAN } else { time } };
    }
    0
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetReal(_: *mut c_void, _: *const c_uint, _: usize, _: *const f64) -> c_int {
    0
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetInteger(_: *mut c_void, _: *const c_uint, _: usize, value: *mut c_int) -> c_int {
    unsafe { *value = FAULT.load(Relaxed) };
    0
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetInteger(_: *mut c_void, _: *const c_uint, _: usize, value: *const c_int) -> c_int {
    FAULT.store(unsafe { *value }, Relaxed);
    0
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetBoolean(_: *mut c_void, _: *const c_uint, _: usize, _: *mut c_int) -> c_int {
    3
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetBoolean(_: *mut c_void, _: *const c_uint, _: usize, _: *const c_int) -> c_int {
    3
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    _: *mut c_void,
    _: *const c_uint,
    count: usize,
    _: *const c_int,
    values: *mut f64,
) -> c_int {
    for i in 0..count {
        unsafe { *values.add(i) = f64::NAN };
    }
    0
}

/// That it ended the simulation.
#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetBooleanStatus(_: *mut c_void, _: c_int, ended: *mut c_int) -> c_int {
    unsafe { *ended = 1 };
    0
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2DoStep(_: *mut c_void, time: f64, step: f64, _: c_int) -> c_int {
    TIME.store((time + step).to_bits(), Relaxed);
    if time + step < 0.499 {
        return 0;
    }
    match FAULT.load(Relaxed) {
        1 => std::process::exit(0),
        2 => std::process::exit(3),
        3 => std::process::abort(),
        4 => unsafe { std::ptr::null_mut::<u8>().write_volatile(1) },
        5 => println!("\"y\": 7, 7, 7"),
        7 => std::thread::sleep(std::time::Duration::from_secs(1000)),
        8 => return 2,
        _ => (),
    }
    0
}
