//! The functions of FMI 2.0 that the host calls: of the library in this tool, or of a library from a file.

use camdrive::drives::Fault;
use camdrive::fmi2::abi::*;
use camdrive::fmi2::functions;
use libloading::Library;
use std::ffi::CStr;
use std::path::Path;

/// Declares [`Functions`].
macro_rules! functions {
    (
        needed { $($needed:ident($($argument:ty),*) -> $result:ty;)* }
        optional { $($optional:ident($($given:ty),*);)* }
    ) => {
        /// Pointers to the functions by their names; a library may lack those that only some hosts need.
        #[allow(non_snake_case)]
        pub struct Functions {
            $(pub $needed: unsafe extern "C" fn($($argument),*) -> $result,)*
            $(pub $optional: Option<unsafe extern "C" fn($($given),*) -> fmi2Status>,)*
        }

        impl Functions {
            /// The functions of the library in this tool.
            pub fn linked() -> Self {
                Functions {
                    $($needed: functions::$needed,)*
                    $($optional: Some(functions::$optional),)*
                }
            }

            /// The functions of a library.
            ///
            /// # Errors
            /// A function is missing.
            fn of(library: &Library) -> Result<Self, Fault> {
                // SAFETY: a symbol of this name is a function of this signature, by the standard; a library whose author broke
                // it cannot be detected. NULL counts as missing.
                Ok(unsafe {
                    Functions {
                        $($needed: library
                            .get::<Option<unsafe extern "C" fn($($argument),*) -> $result>>(stringify!($needed))
                            .ok()
                            .and_then(|symbol| *symbol)
                            .ok_or_else(|| missing(stringify!($needed)))?,)*
                        $($optional: library.get::<Option<_>>(stringify!($optional)).ok().and_then(|symbol| *symbol),)*
                    }
                })
            }
        }
    };
}

functions! {
    needed {
        fmi2GetVersion() -> fmi2String;
        fmi2GetTypesPlatform() -> fmi2String;
        fmi2Instantiate(
            fmi2String, fmi2Type, fmi2String, fmi2String, *const fmi2CallbackFunctions, fmi2Boolean, fmi2Boolean
        ) -> fmi2Component;
        fmi2FreeInstance(fmi2Component) -> ();
        fmi2SetupExperiment(fmi2Component, fmi2Boolean, fmi2Real, fmi2Real, fmi2Boolean, fmi2Real) -> fmi2Status;
        fmi2EnterInitializationMode(fmi2Component) -> fmi2Status;
        fmi2ExitInitializationMode(fmi2Component) -> fmi2Status;
        fmi2Terminate(fmi2Component) -> fmi2Status;
        fmi2GetReal(fmi2Component, *const fmi2ValueReference, usize, *mut fmi2Real) -> fmi2Status;
        fmi2GetInteger(fmi2Component, *const fmi2ValueReference, usize, *mut fmi2Integer) -> fmi2Status;
        fmi2GetBoolean(fmi2Component, *const fmi2ValueReference, usize, *mut fmi2Boolean) -> fmi2Status;
        fmi2SetReal(fmi2Component, *const fmi2ValueReference, usize, *const fmi2Real) -> fmi2Status;
        fmi2SetInteger(fmi2Component, *const fmi2ValueReference, usize, *const fmi2Integer) -> fmi2Status;
        fmi2SetBoolean(fmi2Component, *const fmi2ValueReference, usize, *const fmi2Boolean) -> fmi2Status;
        fmi2DoStep(fmi2Component, fmi2Real, fmi2Real, fmi2Boolean) -> fmi2Status;
    }
    optional {
        fmi2SetDebugLogging(fmi2Component, fmi2Boolean, usize, *const fmi2String);
        fmi2SetRealInputDerivatives(
            fmi2Component, *const fmi2ValueReference, usize, *const fmi2Integer, *const fmi2Real
        );
        fmi2GetRealOutputDerivatives(
            fmi2Component, *const fmi2ValueReference, usize, *const fmi2Integer, *mut fmi2Real
        );
        fmi2GetFMUstate(fmi2Component, *mut fmi2FMUstate);
        fmi2SetFMUstate(fmi2Component, fmi2FMUstate);
        fmi2FreeFMUstate(fmi2Component, *mut fmi2FMUstate);
        fmi2GetRealStatus(fmi2Component, fmi2StatusKind, *mut fmi2Real);
        fmi2GetBooleanStatus(fmi2Component, fmi2StatusKind, *mut fmi2Boolean);
    }
}

#[cold]
fn missing(name: &str) -> Fault {
    let hint = "the FMU may be for Model Exchange, of another version, or damaged";
    Fault::new(format!("its library has no function {name}")).hint(hint)
}

impl Functions {
    /// Loads a library; the functions are valid as long as the library.
    ///
    /// # Errors
    /// The fault of the system's loader; a library that is not for FMI 2.0.
    pub fn load(path: &Path) -> Result<(Self, Library), Fault> {
        let library = open(path).map_err(|e| {
            // The text of Windows repeats the cause.
            let cause = std::error::Error::source(&e).map(|cause| format!(": {cause}")).unwrap_or_default();
            let hint = "install the libraries that it needs; its maker knows them";
            Fault::new(format!("its library cannot be loaded: {e}{cause}")).hint(hint)
        })?;
        let functions = Functions::of(&library)?;
        // SAFETY: functions without arguments that return a string which lives as long as the library, or NULL.
        let [version, types] = unsafe {
            [(functions.fmi2GetVersion)(), (functions.fmi2GetTypesPlatform)()]
                .map(|text| if text.is_null() { c"NULL".to_owned() } else { CStr::from_ptr(text).to_owned() })
        };
        if version.as_c_str() != c"2.0" || types.as_c_str() != c"default" {
            return Err(Fault::new(format!(
                "its library reports FMI {version:?} with the types {types:?}; expected \"2.0\" and \"default\""
            )));
        }
        Ok((functions, library))
    }
}

unsafe extern "C" {
    /// Ends the process at once, without the exit functions of a library, which may hang.
    safe fn _exit(code: std::ffi::c_int) -> !;
}

#[cfg(unix)]
unsafe extern "C" {
    /// Sends a signal to a process; to a group by the negative number of its leader.
    safe fn kill(process: std::ffi::c_int, signal: std::ffi::c_int) -> std::ffi::c_int;
}

/// Ends the processes of the group that this one leads or led, including it. Windows has no such groups.
pub fn end_group(leader: u32) {
    #[cfg(unix)]
    if let Ok(leader @ 2..) = std::ffi::c_int::try_from(leader) {
        // SIGKILL has this number on all systems. An empty group is no fault.
        let _ = kill(-leader, 9);
    }
    #[cfg(not(unix))]
    let _ = leader;
}

/// Ends a process whose library may be in a call, and those that the library started.
pub fn leave() -> ! {
    end_group(std::process::id());
    _exit(1)
}

#[cfg(unix)]
fn open(path: &Path) -> Result<Library, libloading::Error> {
    use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
    // A missing function is to be reported now, instead of ending the process at its first call.
    // SAFETY: loading runs code of the FMU, for which the user asks by opening it.
    unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }.map(Into::into)
}

#[cfg(windows)]
fn open(path: &Path) -> Result<Library, libloading::Error> {
    use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library};
    // Libraries next to the FMU's are found, too.
    // SAFETY: loading runs code of the FMU, for which the user asks by opening it.
    unsafe { Library::load_with_flags(path, LOAD_WITH_ALTERED_SEARCH_PATH) }.map(Into::into)
}
