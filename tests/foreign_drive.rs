//! A drive of another maker, as most are: a rigid follower with the mass m behind x = h (1 − cos φ) that takes no derivatives of its inputs.
//! `tests/cli.rs` compiles it by itself and packs it.
//!
//! τ = m x′ (x′ φ̈ + x″ φ̇²) is computed where it is read. Its units are those that its parameters say, each as its SI value.
#![crate_type = "cdylib"]
#![allow(non_snake_case)]

use std::ffi::{c_char, c_int, c_uint, c_void};

/// φ, φ̇, φ̈, m, h and the SI values of the units of φ, φ̇, φ̈ and τ, by their value references; that of τ is the next one.
type Drive = [f64; 9];

fn torque([phi, w, a, m, h, by_phi, by_w, by_a, by_tau]: Drive) -> f64 {
    let (sin, cos) = (phi * by_phi).sin_cos();
    m * h * sin * (h * sin * a * by_a + h * cos * (w * by_w).powi(2)) / by_tau
}

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
) -> *mut Drive {
    Box::into_raw(Box::new([0.0, 0.0, 0.0, 100.0, 0.03, 1.0, 1.0, 1.0, 1.0]))
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2FreeInstance(drive: *mut Drive) {
    drop(unsafe { Box::from_raw(drive) });
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetupExperiment(_: *mut Drive, _: c_int, _: f64, _: f64, _: c_int, _: f64) -> c_uint {
    0
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetReal(drive: *mut Drive, r: *const c_uint, count: usize, values: *mut f64) -> c_uint {
    for i in 0..count {
        let reference = unsafe { *r.add(i) } as usize;
        let value = unsafe { (*drive).get(reference).copied().unwrap_or_else(|| torque(*drive)) };
        unsafe { *values.add(i) = value };
    }
    0
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetReal(drive: *mut Drive, r: *const c_uint, count: usize, values: *const f64) -> c_uint {
    (0..count).for_each(|i| unsafe { (*drive)[*r.add(i) as usize] = *values.add(i) });
    0
}

#[unsafe(no_mangle)]
extern "C" fn fmi2DoStep(_: *mut Drive, _: f64, _: f64, _: c_int) -> c_uint {
    0
}

/// Functions that have nothing to do; of their arguments the instance is enough.
macro_rules! idle {
    ($($name:ident)*) => {
        $(
            #[unsafe(no_mangle)]
            extern "C" fn $name(_: *mut Drive) -> c_uint {
                0
            }
        )*
    };
}

idle! {
    fmi2EnterInitializationMode fmi2ExitInitializationMode fmi2Terminate fmi2Reset
    fmi2GetInteger fmi2SetInteger fmi2GetBoolean fmi2SetBoolean
}
