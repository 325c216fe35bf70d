//! A host in this process: it drives an instance through the functions of the C interface, as an importer does, and
//! is safe to use. The studies of [`crate`] measure through it what an importer will get.

use crate::resource::Resource;
use camdrive::drives::Fault;
use camdrive::drives::resource::FILE_NAME;
use camdrive::drives::variable::Kind;
use camdrive::fmi2::abi::*;
use camdrive::fmi2::functions::*;
use std::cell::RefCell;
use std::ffi::{CStr, CString};
use std::rc::Rc;

/// An instance of an FMU.
///
/// The handle is a pointer, so that a host stays in the thread that made it, as the C interface demands.
pub struct Host {
    component: fmi2Component,
    /// The last error message. The instance holds its address; a box that is moved would claim its content for itself alone.
    message: Rc<Message>,
}

type Message = RefCell<String>;

/// Takes the log of an instance.
///
/// Stable Rust cannot define a variadic function. A plain one that ends with the last named argument is called like a
/// variadic one on all platforms that the FMUs are made for: named arguments are passed alike, and the caller removes
/// the rest.
unsafe extern "C" fn note(
    environment: fmi2ComponentEnvironment,
    _name: fmi2String,
    status: fmi2Status,
    _category: fmi2String,
    text: fmi2String,
) {
    if status == OK || status == WARNING {
        return;
    }
    // SAFETY: the environment is the message of the host, which outlives its instance and stays in one thread; the
    // library passes a string that ends in NUL.
    let (message, text) = unsafe { (&*environment.cast_const().cast::<Message>(), CStr::from_ptr(text)) };
    // The text is a format in which %% stands for %.
    *message.borrow_mut() = text.to_string_lossy().replace("%%", "%");
}

/// [`note`] as the type of the standard has it.
fn logger() -> fmi2CallbackLogger {
    type Plain = unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String);
    // SAFETY: both are pointers to functions of the C calling convention; see `note`.
    unsafe { std::mem::transmute::<Plain, fmi2CallbackLogger>(note) }
}

impl Host {
    /// An instance of the FMU of this scene.
    ///
    /// # Errors
    /// What the library says where it refuses the scene; a temporary folder that cannot be written.
    pub fn instantiate(resource: &Resource) -> Result<Self, Fault> {
        let fault = |e: &dyn std::fmt::Display| Fault::new(format!("the resources of the FMU cannot be written: {e}"));
        let folder = tempfile::tempdir().map_err(|e| fault(&e))?;
        std::fs::write(folder.path().join(FILE_NAME), resource.to_bytes()?).map_err(|e| fault(&e))?;
        let text = |text: &str| CString::new(text).map_err(|e| fault(&e));
        let (name, guid) = (text(&resource.name)?, text(&resource.guid)?);
        // What is no URI is taken for a path.
        let location = text(&folder.path().to_string_lossy())?;
        let message = Rc::<Message>::default();
        let callbacks = fmi2CallbackFunctions {
            logger: Some(logger()),
            allocateMemory: None,
            freeMemory: None,
            stepFinished: None,
            componentEnvironment: Rc::as_ptr(&message).cast_mut().cast(),
        };
        // SAFETY: strings that end in NUL and callbacks, all alive during the call; the message outlives the instance.
        let component = unsafe {
            fmi2Instantiate(
                name.as_ptr(),
                CO_SIMULATION,
                guid.as_ptr(),
                location.as_ptr(),
                &raw const callbacks,
                FALSE,
                FALSE,
            )
        };
        let host = Host { component, message };
        if component.is_null() { Err(Fault::new(host.message.take())) } else { Ok(host) }
    }

    /// The status of a call as a result.
    fn checked(&self, status: fmi2Status, function: &str) -> Result<(), Fault> {
        if status == OK || status == WARNING {
            return Ok(());
        }
        let message = self.message.take();
        Err(Fault::new(if message.is_empty() { format!("{function} returns the status {status}") } else { message }))
    }

    /// Tells the start time (s); neither a tolerance nor a stop time.
    pub fn set_up(&mut self, start: f64) -> Result<(), Fault> {
        // SAFETY: the handle lives as long as the host; so in all functions below.
        let status = unsafe { fmi2SetupExperiment(self.component, FALSE, 0.0, start, FALSE, 0.0) };
        self.checked(status, "fmi2SetupExperiment")
    }

    /// Begins initialisation.
    pub fn enter_initialization(&mut self) -> Result<(), Fault> {
        // SAFETY: see `set_up`.
        let status = unsafe { fmi2EnterInitializationMode(self.component) };
        self.checked(status, "fmi2EnterInitializationMode")
    }

    /// Ends initialisation: the initial state is computed.
    pub fn exit_initialization(&mut self) -> Result<(), Fault> {
        // SAFETY: see `set_up`.
        let status = unsafe { fmi2ExitInitializationMode(self.component) };
        self.checked(status, "fmi2ExitInitializationMode")
    }

    /// Sets a variable of any type.
    pub fn set(&mut self, reference: u32, kind: &Kind, value: f64) -> Result<(), Fault> {
        if matches!(kind, Kind::Real { .. }) {
            return self.set_reals(&[reference], &[value]);
        }
        let whole = value as fmi2Integer;
        // SAFETY: see `set_up`; arrays of one element each.
        let status = unsafe {
            match kind {
                Kind::Boolean => fmi2SetBoolean(self.component, &raw const reference, 1, &raw const whole),
                _ => fmi2SetInteger(self.component, &raw const reference, 1, &raw const whole),
            }
        };
        self.checked(status, "fmi2SetInteger")
    }

    /// Sets Reals; the lists are of one length.
    pub fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Result<(), Fault> {
        let count = references.len().min(values.len());
        // SAFETY: see `set_up`; `count` elements are in both arrays.
        let status = unsafe { fmi2SetReal(self.component, references.as_ptr(), count, values.as_ptr()) };
        self.checked(status, "fmi2SetReal")
    }

    /// Sets input derivatives; the lists are of one length.
    pub fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Result<(), Fault> {
        let count = references.len().min(orders.len()).min(values.len());
        // SAFETY: see `set_up`; `count` elements are in all three arrays.
        let status = unsafe {
            fmi2SetRealInputDerivatives(self.component, references.as_ptr(), count, orders.as_ptr(), values.as_ptr())
        };
        self.checked(status, "fmi2SetRealInputDerivatives")
    }

    /// Reads Reals; the lists are of one length.
    pub fn get_reals(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Fault> {
        let count = references.len().min(values.len());
        // SAFETY: see `set_up`; `count` elements are in both arrays.
        let status = unsafe { fmi2GetReal(self.component, references.as_ptr(), count, values.as_mut_ptr()) };
        self.checked(status, "fmi2GetReal")
    }

    /// Advances from the communication point `time` by `step` (s).
    pub fn do_step(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        // SAFETY: see `set_up`.
        let status = unsafe { fmi2DoStep(self.component, time, step, TRUE) };
        self.checked(status, "fmi2DoStep")
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: the handle is NULL or alive, and used no more; the message is dropped after it.
        unsafe { fmi2FreeInstance(self.component) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use camdrive::drives::follower::load::Load;
    use camdrive::drives::parametric;
    use camdrive::drives::parametric::law::{Coordinate, Law, SeriesLaw};
    use camdrive::drives::rigid_machine::{InertiaFunction, MachineStart, Motor, Scene};
    use camdrive::drives::settings::Settings;
    use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
    use camdrive::motion::Fourier;

    fn flywheel(speed: f64) -> Resource {
        let scene = Scene {
            inertia: InertiaFunction { constant: 2.0, varying: None },
            followers: Vec::new(),
            motor: Motor::Input,
            phi_start: 0.0,
            w_start: speed,
            start: MachineStart::Given,
            solver: Settings::default(),
        };
        Resource { guid: "{1}".into(), ..Resource::new("flywheel", scene) }
    }

    fn reference(name: &str) -> u32 {
        let drive = flywheel(0.0).build().unwrap();
        drive.descriptions().iter().position(|d| d.name == name).unwrap() as u32
    }

    #[test]
    fn a_flywheel_under_torque_is_driven_through_the_c_interface() {
        let mut host = Host::instantiate(&flywheel(3.0)).unwrap();
        host.set_up(0.0).unwrap();
        host.enter_initialization().unwrap();
        host.set_reals(&[reference("M_an")], &[4.0]).unwrap();
        host.exit_initialization().unwrap();
        host.do_step(0.0, 0.5).unwrap();
        let mut w = [0.0];
        host.get_reals(&[reference("w")], &mut w).unwrap();
        // w = 3 + M t / J.
        assert!((w[0] - 4.0).abs() < 1e-12, "{w:?}");
        // The torque rises by 2 N·m/s from here: w = 4 + (4 t + t²)/2.
        host.set_input_derivatives(&[reference("M_an")], &[1], &[2.0]).unwrap();
        host.do_step(0.5, 1.0).unwrap();
        host.get_reals(&[reference("w")], &mut w).unwrap();
        assert!((w[0] - 6.5).abs() < 1e-12, "{w:?}");
    }

    #[test]
    fn refusals_come_with_the_words_of_the_library() {
        let constant = |value: f64| Fourier::new(vec![value], Vec::new());
        let (coordinate, m, b, c) = (Coordinate::Rotation, constant(-1.0), constant(0.0), constant(1.0));
        let massless = parametric::Scene {
            law: Law::Series(SeriesLaw { coordinate, m, b, c, f: None }),
            load: Load::default(),
            drive: DriveMode::Input,
            start: Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 },
            solver: Settings::default(),
        };
        let refusal = Host::instantiate(&Resource::new("massless", massless)).err().unwrap();
        assert!(refusal.to_string().contains("the equation has no acceleration"), "{refusal}");
        let mut host = Host::instantiate(&flywheel(0.0)).unwrap();
        let refusal = host.do_step(0.0, 0.1).unwrap_err();
        assert!(refusal.to_string().contains("fmi2DoStep"), "{refusal}");
        host.set_up(0.0).unwrap();
        let refusal = host.set_reals(&[9999], &[0.0]).unwrap_err();
        assert!(refusal.to_string().contains("9999"), "{refusal}");
    }
}
