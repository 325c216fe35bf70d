//! An FMU of another maker: a cart at the position x, x' = u, with habits that the drives have not. `tests/cli.rs` compiles it by
//! itself and packs it.
//!
//! It keeps the callbacks by their address, takes memory from its importer, logs with arguments, reads a resource, has units that
//! are not SI, and ends the simulation at x = 5 mm.
#![crate_type = "cdylib"]
#![allow(non_snake_case)]

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};

#[repr(C)]
struct Callbacks {
    logger: unsafe extern "C" fn(*mut c_void, *const c_char, c_uint, *const c_char, *const c_char, ...),
    allocate: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void),
    finished: *const c_void,
    environment: *mut c_void,
}

#[repr(C)]
struct Cart {
    callbacks: *const Callbacks,
    /// (mm).
    x: f64,
    /// (mm/s).
    u: f64,
    /// (°C).
    temperature: f64,
    time: f64,
    gear: c_int,
    open: c_int,
    ended: c_int,
}

impl Cart {
    unsafe fn log(&self, status: c_uint, format: &CStr, value: *const c_char) {
        let callbacks = unsafe { &*self.callbacks };
        let texts = [c"cart", c"logAll", format].map(CStr::as_ptr);
        unsafe { (callbacks.logger)(callbacks.environment, texts[0], status, texts[1], texts[2], value) };
    }
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
unsafe extern "C" fn fmi2Instantiate(
    _: *const c_char,
    _: c_int,
    guid: *const c_char,
    location: *const c_char,
    callbacks: *const Callbacks,
    _: c_int,
    _: c_int,
) -> *mut Cart {
    unsafe {
        let cart = ((*callbacks).allocate)(1, size_of::<Cart>()).cast::<Cart>();
        (*cart).callbacks = callbacks;
        // The folder of the test has a blank in it.
        let path = CStr::from_ptr(location).to_str().unwrap().strip_prefix("file://").unwrap().replace("%20", " ");
        let path = if cfg!(windows) { path[1..].to_owned() } else { path };
        let start = std::fs::read_to_string(std::path::Path::new(&path).join("start.txt"));
        if CStr::from_ptr(guid) != c"{cart}" || start.is_err() {
            (*cart).log(3, c"%s", c"wrong guid or no resource".as_ptr());
            ((*callbacks).free)(cart.cast());
            return std::ptr::null_mut();
        }
        (*cart).x = start.unwrap().trim().parse().unwrap();
        (*cart).temperature = 20.0;
        (*cart).log(0, c"%s", c"nobody wants to know".as_ptr());
        cart
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2FreeInstance(cart: *mut Cart) {
    unsafe { ((*(*cart).callbacks).free)(cart.cast()) }
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetupExperiment(_: *mut Cart, _: c_int, _: f64, _: f64, _: c_int, _: f64) -> c_uint {
    0
}

#[unsafe(no_mangle)]
extern "C" fn fmi2EnterInitializationMode(_: *mut Cart) -> c_uint {
    0
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2ExitInitializationMode(cart: *mut Cart) -> c_uint {
    unsafe { (*cart).log(1, c"%s", c"100 % of the oil is cold".as_ptr()) };
    0
}

#[unsafe(no_mangle)]
extern "C" fn fmi2Terminate(_: *mut Cart) -> c_uint {
    0
}

unsafe fn real(cart: *mut Cart, reference: c_uint) -> *mut f64 {
    unsafe { [&raw mut (*cart).x, &raw mut (*cart).u, &raw mut (*cart).temperature][reference as usize] }
}

unsafe fn whole(cart: *mut Cart, reference: c_uint) -> *mut c_int {
    unsafe { [&raw mut (*cart).gear, &raw mut (*cart).open][reference as usize] }
}

/// Getter and setter of a type.
macro_rules! access {
    ($($get:ident $set:ident $place:ident $type:ty;)*) => {
        $(
            #[unsafe(no_mangle)]
            unsafe extern "C" fn $get(cart: *mut Cart, r: *const c_uint, count: usize, values: *mut $type) -> c_uint {
                (0..count).for_each(|i| unsafe { *values.add(i) = *$place(cart, *r.add(i)) });
                0
            }

            #[unsafe(no_mangle)]
            unsafe extern "C" fn $set(cart: *mut Cart, r: *const c_uint, count: usize, values: *const $type) -> c_uint {
                (0..count).for_each(|i| unsafe { *$place(cart, *r.add(i)) = *values.add(i) });
                0
            }
        )*
    };
}

access! {
    fmi2GetReal fmi2SetReal real f64;
    fmi2GetInteger fmi2SetInteger whole c_int;
    fmi2GetBoolean fmi2SetBoolean whole c_int;
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2DoStep(cart: *mut Cart, time: f64, step: f64, _: c_int) -> c_uint {
    unsafe {
        let next = (*cart).x + (*cart).u * step;
        if next > 5.0 {
            (*cart).ended = 1;
            (*cart).log(2, c"the cart is at its end, x would be %s", c"too much".as_ptr());
            return 2;
        }
        (*cart).x = next;
        (*cart).time = time + step;
    }
    0
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetBooleanStatus(cart: *mut Cart, _: c_uint, value: *mut c_int) -> c_uint {
    unsafe { *value = (*cart).ended };
    0
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetRealStatus(cart: *mut Cart, _: c_uint, value: *mut f64) -> c_uint {
    unsafe { *value = (*cart).time };
    0
}
