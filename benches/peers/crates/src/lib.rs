//! The peers that are Rust crates, behind the C interface of `peer.hpp`.

mod differential_equations_peer;
mod diffsol_peer;
mod ode_solvers_peer;
mod works;

use std::ffi::{c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What a method makes of a work: outputs, two per millisecond, or None where it does not do this work.
type Solve = fn(work: usize, tolerance: f64, out: &mut [[f64; 2]]) -> Option<()>;

const METHODS: [Solve; 7] = [
    ode_solvers_peer::dopri5,
    ode_solvers_peer::dop853,
    differential_equations_peer::dopri5,
    differential_equations_peer::dop853,
    differential_equations_peer::rkv98,
    diffsol_peer::tsit45,
    diffsol_peer::bdf,
];

#[unsafe(no_mangle)]
pub extern "C" fn peer_methods() -> *const c_char {
    c"ode_solvers dopri5;ode_solvers dop853;differential-equations dopri5;differential-equations dop853;\
differential-equations rkv98;diffsol tsit45;diffsol bdf"
        .as_ptr()
}

/// # Safety
/// `out` takes two numbers per millisecond of the work, `cpu_seconds` one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn peer_solve(
    method: c_int,
    work: c_int,
    setting: f64,
    out: *mut [f64; 2],
    cpu_seconds: *mut f64,
) -> c_int {
    let (method, work) = (method as usize, work as usize);
    // SAFETY: as the caller promises.
    let out = unsafe { std::slice::from_raw_parts_mut(out, works::STEPS[work]) };
    // A method that fails says so by its result; its message would only disturb the table.
    std::panic::set_hook(Box::new(|_| ()));
    let start = cpu_now();
    let result = catch_unwind(AssertUnwindSafe(|| METHODS[method](work, setting, out)));
    // SAFETY: as the caller promises.
    unsafe { *cpu_seconds = cpu_now() - start };
    match result {
        Ok(Some(())) => 0,
        Ok(None) => 1,
        Err(_) => -1,
    }
}

/// CPU time of the process (s).
fn cpu_now() -> f64 {
    let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: `now` is a valid place for the answer.
    unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &mut now) };
    now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64
}
