//! An FMU whose library misbehaves as its parameter `fault` says. `tests/cli.rs` compiles it by itself and packs it.
//!
//! Its output is y = t; most of what it does it does in the step that ends at 0.5 s or after it. With the guid "dead" it dies while it is
//! instantiated.
#![crate_type = "cdylib"]
#![allow(non_snake_case)]

#[macro_use]
mod fmi2;

use fmi2::{Callbacks, DISCARD, ERROR, OK, Slave};
use std::ffi::{CStr, c_int, c_uint};

/// How long a process that it starts sleeps (s), by which the test finds it.
const PAUSE: &str = "12345.678";

struct Faulty {
    fault: c_int,
    time: f64,
}

impl Faulty {
    fn dies_of(&self, fault: c_int) {
        if self.fault == fault {
            std::process::abort();
        }
    }
}

impl Slave for Faulty {
    unsafe fn instantiate(guid: &CStr, _: &CStr, _: *const Callbacks) -> *mut Faulty {
        if guid == c"dead" {
            std::process::abort();
        }
        Box::into_raw(Box::new(Faulty { fault: 0, time: 0.0 }))
    }

    unsafe fn free(faulty: *mut Faulty) {
        let faulty = unsafe { Box::from_raw(faulty) };
        faulty.dies_of(13);
        if faulty.fault == 14 {
            std::thread::sleep(std::time::Duration::from_secs(1000));
        }
    }

    fn set_up(&mut self, start: f64) {
        self.time = start;
    }

    fn enter_initialization(&mut self) -> c_uint {
        self.dies_of(11);
        OK
    }

    fn exit_initialization(&mut self) -> c_uint {
        self.dies_of(12);
        OK
    }

    fn terminate(&mut self) -> c_uint {
        self.dies_of(9);
        OK
    }

    fn real(&mut self, _: usize) -> f64 {
        if self.fault == 6 && self.time >= 0.5 { f64::NAN } else { self.time }
    }

    fn whole(&mut self, _: usize) -> c_int {
        self.fault
    }

    fn set_whole(&mut self, _: usize, value: c_int) -> c_uint {
        self.fault = value;
        self.dies_of(10);
        OK
    }

    fn step(&mut self, time: f64, step: f64) -> c_uint {
        self.time = time + step;
        if self.time < 0.499 {
            return OK;
        }
        match self.fault {
            1 => std::process::exit(0),
            2 => std::process::exit(3),
            3 => std::process::abort(),
            4 => unsafe { std::ptr::null_mut::<u8>().write_volatile(1) },
            5 => println!("\"y\": 7, 7, 7"),
            7 => std::thread::sleep(std::time::Duration::from_secs(1000)),
            8 => return DISCARD,
            15 => drop(std::process::Command::new("sleep").arg(PAUSE).spawn()),
            16 => return ERROR,
            _ => (),
        }
        OK
    }

    fn has_ended(&self) -> bool {
        true
    }
}

export!(Faulty);
