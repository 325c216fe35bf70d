//! The functions of FMI 2.0 Co-Simulation for the libraries of this folder, each of which has one kind of instance.

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};

pub const OK: c_uint = 0;
pub const DISCARD: c_uint = 2;
pub const ERROR: c_uint = 3;

/// What an importer passes.
#[repr(C)]
pub struct Callbacks {
    pub logger: unsafe extern "C" fn(*mut c_void, *const c_char, c_uint, *const c_char, *const c_char, ...),
    pub allocate: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    pub free: unsafe extern "C" fn(*mut c_void),
    pub finished: *const c_void,
    pub environment: *mut c_void,
}

/// An instance; variables are known by their value references. Functions return a status.
pub trait Slave: Sized {
    /// A new instance by its guid and the URI of its resources; NULL where it refuses.
    unsafe fn instantiate(guid: &CStr, resources: &CStr, callbacks: *const Callbacks) -> *mut Self;

    unsafe fn free(slave: *mut Self);

    fn set_up(&mut self, _start: f64) {}

    fn enter_initialization(&mut self) -> c_uint {
        OK
    }

    fn exit_initialization(&mut self) -> c_uint {
        OK
    }

    fn terminate(&mut self) -> c_uint {
        OK
    }

    fn real(&mut self, reference: usize) -> f64;

    fn set_real(&mut self, _reference: usize, _value: f64) -> c_uint {
        ERROR
    }

    /// An Integer or a Boolean.
    fn whole(&mut self, _reference: usize) -> c_int {
        0
    }

    fn set_whole(&mut self, _reference: usize, _value: c_int) -> c_uint {
        ERROR
    }

    fn set_input_derivative(&mut self, _reference: usize, _order: c_int, _value: f64) -> c_uint {
        ERROR
    }

    fn output_derivative(&mut self, _reference: usize, _order: c_int) -> f64 {
        f64::NAN
    }

    fn step(&mut self, time: f64, step: f64) -> c_uint;

    /// Whether it ended the simulation.
    fn has_ended(&self) -> bool {
        false
    }

    /// The end of the last step that succeeded, where it tells that.
    fn last_time(&self) -> Option<f64> {
        None
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

/// The worst status of these.
pub fn worst(all: impl Iterator<Item = c_uint>) -> c_uint {
    all.max().unwrap_or(OK)
}

/// The other functions of the standard, for one kind of [`Slave`].
#[macro_export]
macro_rules! export {
    ($slave:ty) => {
        use std::ffi::{c_char as Char, c_int as Int, c_uint as Status};

        #[unsafe(no_mangle)]
        unsafe extern "C" fn fmi2Instantiate(
            _: *const Char,
            _: Int,
            guid: *const Char,
            resources: *const Char,
            callbacks: *const fmi2::Callbacks,
            _: Int,
            _: Int,
        ) -> *mut $slave {
            unsafe { <$slave>::instantiate(CStr::from_ptr(guid), CStr::from_ptr(resources), callbacks) }
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn fmi2FreeInstance(slave: *mut $slave) {
            unsafe { <$slave>::free(slave) }
        }

        #[unsafe(no_mangle)]
        extern "C" fn fmi2SetupExperiment(slave: &mut $slave, _: Int, _: f64, start: f64, _: Int, _: f64) -> Status {
            slave.set_up(start);
            fmi2::OK
        }

        #[unsafe(no_mangle)]
        extern "C" fn fmi2EnterInitializationMode(slave: &mut $slave) -> Status {
            slave.enter_initialization()
        }

        #[unsafe(no_mangle)]
        extern "C" fn fmi2ExitInitializationMode(slave: &mut $slave) -> Status {
            slave.exit_initialization()
        }

        #[unsafe(no_mangle)]
        extern "C" fn fmi2Terminate(slave: &mut $slave) -> Status {
            slave.terminate()
        }

        #[unsafe(no_mangle)]
        extern "C" fn fmi2DoStep(slave: &mut $slave, time: f64, step: f64, _: Int) -> Status {
            slave.step(time, step)
        }

        export! { $slave;
            fmi2GetReal fmi2SetReal real set_real f64;
            fmi2GetInteger fmi2SetInteger whole set_whole Int;
            fmi2GetBoolean fmi2SetBoolean whole set_whole Int;
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn fmi2SetRealInputDerivatives(
            slave: &mut $slave,
            r: *const Status,
            count: usize,
            orders: *const Int,
            values: *const f64,
        ) -> Status {
            fmi2::worst((0..count).map(|i| unsafe {
                slave.set_input_derivative(*r.add(i) as usize, *orders.add(i), *values.add(i))
            }))
        }

        #[unsafe(no_mangle)]
        unsafe extern "C" fn fmi2GetRealOutputDerivatives(
            slave: &mut $slave,
            r: *const Status,
            count: usize,
            orders: *const Int,
            values: *mut f64,
        ) -> Status {
            (0..count).for_each(|i| unsafe {
                *values.add(i) = slave.output_derivative(*r.add(i) as usize, *orders.add(i))
            });
            fmi2::OK
        }

        #[unsafe(no_mangle)]
        extern "C" fn fmi2GetBooleanStatus(slave: &mut $slave, _: Int, value: &mut Int) -> Status {
            *value = slave.has_ended().into();
            fmi2::OK
        }

        #[unsafe(no_mangle)]
        extern "C" fn fmi2GetRealStatus(slave: &mut $slave, _: Int, value: &mut f64) -> Status {
            slave.last_time().map_or(fmi2::DISCARD, |time| {
                *value = time;
                fmi2::OK
            })
        }
    };
    // Getter and setter of a type.
    ($slave:ty; $($get:ident $set:ident $value:ident $set_value:ident $type:ty;)*) => {
        $(
            #[unsafe(no_mangle)]
            unsafe extern "C" fn $get(slave: &mut $slave, r: *const Status, count: usize, values: *mut $type) -> Status {
                (0..count).for_each(|i| unsafe { *values.add(i) = slave.$value(*r.add(i) as usize) });
                fmi2::OK
            }

            #[unsafe(no_mangle)]
            unsafe extern "C" fn $set(
                slave: &mut $slave,
                r: *const Status,
                count: usize,
                values: *const $type,
            ) -> Status {
                fmi2::worst((0..count).map(|i| unsafe { slave.$set_value(*r.add(i) as usize, *values.add(i)) }))
            }
        )*
    };
}
