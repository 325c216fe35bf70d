//! A drive of another maker, as most are: a rigid follower with the mass m behind x = h (1 − cos φ). `tests/cli.rs` compiles it by
//! itself and packs it.
//!
//! τ = m x′ (x′ φ̈ + x″ φ̇²) is computed where it is read. φ, φ̇ and φ̈ are three inputs like any others: within a step each is
//! the straight line of its derivative, where that is set; a higher order is refused. Units are those that its parameters say, each
//! as its SI value.
#![crate_type = "cdylib"]
#![allow(non_snake_case)]

#[macro_use]
mod fmi2;

use fmi2::{Callbacks, ERROR, OK, Slave};
use std::ffi::{CStr, c_int, c_uint};

struct Drive {
    /// φ, φ̇, φ̈, m, h and the SI values of the units of φ, φ̇, φ̈ and τ, by their value references; that of τ is the next one.
    reals: [f64; 9],
    /// Of the inputs.
    slopes: [f64; 3],
}

impl Slave for Drive {
    unsafe fn instantiate(_: &CStr, _: &CStr, _: *const Callbacks) -> *mut Drive {
        let reals = [0.0, 0.0, 0.0, 100.0, 0.03, 1.0, 1.0, 1.0, 1.0];
        Box::into_raw(Box::new(Drive { reals, slopes: [0.0; 3] }))
    }

    unsafe fn free(drive: *mut Drive) {
        drop(unsafe { Box::from_raw(drive) });
    }

    fn real(&mut self, reference: usize) -> f64 {
        let [phi, w, a, m, h, by_phi, by_w, by_a, by_tau] = self.reals;
        let (sin, cos) = (phi * by_phi).sin_cos();
        let torque = m * h * sin * (h * sin * a * by_a + h * cos * (w * by_w).powi(2)) / by_tau;
        self.reals.get(reference).copied().unwrap_or(torque)
    }

    fn set_real(&mut self, reference: usize, value: f64) -> c_uint {
        self.reals[reference] = value;
        if let Some(slope) = self.slopes.get_mut(reference) {
            *slope = 0.0;
        }
        OK
    }

    fn set_input_derivative(&mut self, reference: usize, order: c_int, value: f64) -> c_uint {
        if order != 1 {
            return ERROR;
        }
        self.slopes[reference] = value;
        OK
    }

    fn step(&mut self, _: f64, step: f64) -> c_uint {
        self.reals.iter_mut().zip(self.slopes).for_each(|(input, slope)| *input += step * slope);
        OK
    }
}

export!(Drive);
