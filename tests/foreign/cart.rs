//! An FMU of another maker: a cart at the position x, x' = u, with habits that the drives have not. `tests/cli.rs` compiles it by
//! itself and packs it.
//!
//! It keeps the callbacks by their address, takes memory from its importer, logs with arguments, reads a resource, has units that
//! are not SI, and ends the simulation at x = 5 mm.
#![crate_type = "cdylib"]
#![allow(non_snake_case)]

#[macro_use]
mod fmi2;

use fmi2::{Callbacks, DISCARD, ERROR, OK, Slave};
use std::ffi::{CStr, c_char, c_int, c_uint};

const WARNING: c_uint = 1;

struct Cart {
    callbacks: *const Callbacks,
    /// x (mm), u (mm/s) and a temperature (°C).
    reals: [f64; 3],
    /// The gear and whether it is open.
    wholes: [c_int; 2],
    time: f64,
    ended: bool,
}

impl Cart {
    fn log(&self, status: c_uint, format: &CStr, value: *const c_char) {
        let texts = [c"cart", c"logAll", format].map(CStr::as_ptr);
        // SAFETY: the importer keeps its callbacks.
        unsafe {
            let callbacks = &*self.callbacks;
            (callbacks.logger)(callbacks.environment, texts[0], status, texts[1], texts[2], value);
        }
    }
}

impl Slave for Cart {
    unsafe fn instantiate(guid: &CStr, resources: &CStr, callbacks: *const Callbacks) -> *mut Cart {
        unsafe {
            let cart = ((*callbacks).allocate)(1, size_of::<Cart>()).cast::<Cart>();
            (*cart).callbacks = callbacks;
            // The folder of the test has a blank in it.
            let path = resources.to_str().unwrap().strip_prefix("file://").unwrap().replace("%20", " ");
            let path = if cfg!(windows) { path[1..].to_owned() } else { path };
            let start = std::fs::read_to_string(std::path::Path::new(&path).join("start.txt"));
            if guid != c"{cart}" || start.is_err() {
                (*cart).log(ERROR, c"%s", c"wrong guid or no resource".as_ptr());
                Cart::free(cart);
                return std::ptr::null_mut();
            }
            (*cart).reals = [start.unwrap().trim().parse().unwrap(), 0.0, 20.0];
            (*cart).log(OK, c"%s", c"nobody wants to know".as_ptr());
            cart
        }
    }

    unsafe fn free(cart: *mut Cart) {
        unsafe { ((*(*cart).callbacks).free)(cart.cast()) }
    }

    fn exit_initialization(&mut self) -> c_uint {
        self.log(WARNING, c"%s", c"100 % of the oil is cold".as_ptr());
        OK
    }

    fn real(&mut self, reference: usize) -> f64 {
        self.reals[reference]
    }

    fn set_real(&mut self, reference: usize, value: f64) -> c_uint {
        self.reals[reference] = value;
        OK
    }

    fn whole(&mut self, reference: usize) -> c_int {
        self.wholes[reference]
    }

    fn set_whole(&mut self, reference: usize, value: c_int) -> c_uint {
        self.wholes[reference] = value;
        OK
    }

    fn step(&mut self, time: f64, step: f64) -> c_uint {
        let [x, u, _] = self.reals;
        let next = x + u * step;
        if next > 5.0 {
            self.ended = true;
            self.log(DISCARD, c"the cart is at its end, x would be %s", c"too much".as_ptr());
            return DISCARD;
        }
        (self.reals[0], self.time) = (next, time + step);
        OK
    }

    fn has_ended(&self) -> bool {
        self.ended
    }

    fn last_time(&self) -> Option<f64> {
        Some(self.time)
    }
}

export!(Cart);
