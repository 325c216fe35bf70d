//! An instance of an FMU whose library is in this process, driven through the functions of FMI 2.0.

use super::Instance;
use super::callbacks::Log;
use super::description::ModelDescription;
use super::fmu::Content;
use super::functions::Functions;
use camdrive::drives::variable::Type;
use camdrive::drives::{Fault, Number};
use camdrive::fmi2::abi::*;
use std::ffi::CString;
use std::ptr::null_mut;
use std::rc::Rc;
use std::sync::Arc;

/// An instance whose library is in this process. The handle is a pointer, so that it stays in the thread that made it.
pub(super) struct LocalInstance {
    component: fmi2Component,
    saved: fmi2FMUstate,
    /// No function of a broken instance may be called.
    broken: bool,
    /// True if it has ended the simulation.
    ended: bool,
    log: Arc<Log>,
    /// Instances keep its address, and the addresses of the texts, longer than the standard allows.
    _callbacks: Rc<fmi2CallbackFunctions>,
    _texts: [CString; 3],
    functions: Arc<Functions>,
    /// The library is unloaded after the instance is freed.
    content: Arc<Content>,
}

impl LocalInstance {
    /// An instance of this name with these functions of the FMU.
    ///
    /// # Errors
    /// The library's message if it refuses; a second instance if the FMU allows only one.
    pub fn new(content: &Arc<Content>, functions: &Arc<Functions>, name: &str) -> Result<Self, Fault> {
        if content.description.capabilities.only_once && Arc::strong_count(functions) > 1 {
            let hint = "open the FMU once for each instance";
            let fault = "the FMU can have one instance only (canBeInstantiatedOnlyOncePerProcess)";
            return Err(Fault::new(fault).hint(hint));
        }
        let text = |text: &str| CString::new(text).map_err(|_| Fault::new(format!("{text:?} has a NUL in it")));
        let texts = [text(name)?, text(&content.description.guid)?, text(&content.location())?];
        let [instance_name, guid, location] = texts.each_ref().map(|text| text.as_ptr());
        let log = Arc::<Log>::default();
        let callbacks = Rc::new(log.callbacks());
        // SAFETY: strings that end in NUL, a log and callbacks that outlive the instance.
        let component = unsafe {
            (functions.fmi2Instantiate)(
                instance_name,
                CO_SIMULATION,
                guid,
                location,
                Rc::as_ptr(&callbacks),
                FALSE,
                TRUE,
            )
        };
        let mut instance = LocalInstance {
            component,
            saved: null_mut(),
            broken: false,
            ended: false,
            log,
            _callbacks: callbacks,
            _texts: texts,
            functions: Arc::clone(functions),
            content: Arc::clone(content),
        };
        if component.is_null() {
            return Err(instance.fault(|| "the FMU refuses to start and does not say why".to_owned()));
        }
        instance.choose_messages();
        Ok(instance)
    }

    fn description(&self) -> &ModelDescription {
        &self.content.description
    }

    /// Selects messages of warnings and errors, if the FMU has such categories; other messages would cost time.
    fn choose_messages(&mut self) {
        let names = self.description().categories.iter().filter_map(|name| CString::new(name.as_str()).ok());
        let names: Vec<CString> = names.collect();
        let pointers: Vec<fmi2String> = names.iter().map(|name| name.as_ptr()).collect();
        if let (Some(choose), false) = (self.functions.fmi2SetDebugLogging, pointers.is_empty()) {
            // SAFETY: the handle lives; an array of strings. A refusal leaves more messages.
            unsafe { choose(self.component, TRUE, pointers.len(), pointers.as_ptr()) };
        }
    }

    /// A fault with the log's messages, else with `text`.
    #[cold]
    fn fault(&mut self, text: impl Fn() -> String) -> Fault {
        let said = std::mem::take(&mut self.log.messages().errors);
        Fault::new(if said.is_empty() { text() } else { said.join("; ") })
    }

    /// The status of a call as a result.
    fn checked(&mut self, status: fmi2Status, function: &str) -> Result<(), Fault> {
        if status == OK || status == WARNING { Ok(()) } else { Err(self.refused(status, function)) }
    }

    #[cold]
    fn refused(&mut self, status: fmi2Status, function: &str) -> Fault {
        self.broken |= status == FATAL;
        let word = ["fmi2OK", "fmi2Warning", "fmi2Discard", "fmi2Error", "fmi2Fatal", "fmi2Pending"];
        let word = usize::try_from(status).ok().and_then(|status| word.get(status)).unwrap_or(&"an invalid status");
        self.fault(|| format!("{function}: the FMU returns {word} and does not say why"))
    }

    #[cold]
    fn discarded(&mut self) -> Fault {
        let (mut ended, mut last) = (FALSE, f64::NAN);
        let functions = &self.functions;
        // SAFETY: see `set_up`; places of one value each.
        let (knows_end, knows_last) = unsafe {
            let end = functions.fmi2GetBooleanStatus.map(|get| get(self.component, TERMINATED, &raw mut ended));
            let last = functions.fmi2GetRealStatus.map(|get| get(self.component, LAST_SUCCESSFUL_TIME, &raw mut last));
            (end == Some(OK), last == Some(OK))
        };
        let place = if knows_last { format!(" at t = {} s", Number(last)) } else { String::new() };
        // An unknown status is no news.
        let said = std::mem::take(&mut self.log.messages().errors).into_iter().next();
        let why = said.map(|said| format!(": {said}")).unwrap_or_default();
        self.ended = knows_end && ended != FALSE;
        if self.ended {
            Fault::new(format!("the FMU ends the simulation{place}{why}"))
        } else {
            Fault::new(format!("the FMU discards the rest of a step{place}{why}"))
                .hint("take a shorter communication step")
        }
    }
}

impl Instance for LocalInstance {
    fn set_up(&mut self, start: f64, stop: Option<f64>, tolerance: Option<f64>) -> Result<(), Fault> {
        let given = |value: Option<f64>| (fmi2Boolean::from(value.is_some()), value.unwrap_or(0.0));
        let ((has_stop, stop), (has_tolerance, tolerance)) = (given(stop), given(tolerance));
        // SAFETY: the handle lives as long as the host; so in all functions below.
        let status = unsafe {
            (self.functions.fmi2SetupExperiment)(self.component, has_tolerance, tolerance, start, has_stop, stop)
        };
        self.checked(status, "fmi2SetupExperiment")
    }

    fn enter_initialization(&mut self) -> Result<(), Fault> {
        // SAFETY: see `set_up`.
        let status = unsafe { (self.functions.fmi2EnterInitializationMode)(self.component) };
        self.checked(status, "fmi2EnterInitializationMode")
    }

    fn exit_initialization(&mut self) -> Result<(), Fault> {
        // SAFETY: see `set_up`.
        let status = unsafe { (self.functions.fmi2ExitInitializationMode)(self.component) };
        self.checked(status, "fmi2ExitInitializationMode")
    }

    fn set(&mut self, variable: usize, value: f64) -> Result<(), Fault> {
        let about = &self.description().variables[variable];
        let (reference, kind) = (about.reference, about.about.kind.r#type());
        if kind == Type::Real {
            return self.set_reals(&[reference], &[value]);
        }
        let whole = value as fmi2Integer;
        if f64::from(whole) != value {
            let (name, value) = (&about.about.name, Number(value));
            return Err(Fault::named(name, format!(": {value} is not admissible; expected a whole number")));
        }
        let functions = &self.functions;
        // SAFETY: see `set_up`; arrays of one element each.
        let status = unsafe {
            match kind {
                Type::Boolean => (functions.fmi2SetBoolean)(self.component, &raw const reference, 1, &raw const whole),
                _ => (functions.fmi2SetInteger)(self.component, &raw const reference, 1, &raw const whole),
            }
        };
        self.checked(status, if kind == Type::Boolean { "fmi2SetBoolean" } else { "fmi2SetInteger" })
    }

    fn get(&mut self, variable: usize) -> Result<f64, Fault> {
        let about = &self.description().variables[variable];
        let (reference, kind) = (about.reference, about.about.kind.r#type());
        if kind == Type::Real {
            let mut value = [0.0];
            return self.get_reals(&[reference], &mut value).map(|()| value[0]);
        }
        let mut whole: fmi2Integer = 0;
        let functions = &self.functions;
        // SAFETY: see `set_up`; arrays of one element each.
        let status = unsafe {
            match kind {
                Type::Boolean => (functions.fmi2GetBoolean)(self.component, &raw const reference, 1, &raw mut whole),
                _ => (functions.fmi2GetInteger)(self.component, &raw const reference, 1, &raw mut whole),
            }
        };
        let function = if kind == Type::Boolean { "fmi2GetBoolean" } else { "fmi2GetInteger" };
        self.checked(status, function).map(|()| f64::from(whole))
    }

    fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Result<(), Fault> {
        let count = references.len().min(values.len());
        let set = self.functions.fmi2SetReal;
        // SAFETY: see `set_up`; `count` elements are in both arrays.
        let status = unsafe { set(self.component, references.as_ptr(), count, values.as_ptr()) };
        self.checked(status, "fmi2SetReal")
    }

    fn get_reals(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Fault> {
        let count = references.len().min(values.len());
        let get = self.functions.fmi2GetReal;
        // SAFETY: see `set_up`; `count` elements are in both arrays.
        let status = unsafe { get(self.component, references.as_ptr(), count, values.as_mut_ptr()) };
        self.checked(status, "fmi2GetReal")
    }

    fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Result<(), Fault> {
        let count = references.len().min(orders.len()).min(values.len());
        let set = needed(self.functions.fmi2SetRealInputDerivatives, "fmi2SetRealInputDerivatives")?;
        // SAFETY: see `set_up`; `count` elements are in all three arrays.
        let status = unsafe { set(self.component, references.as_ptr(), count, orders.as_ptr(), values.as_ptr()) };
        self.checked(status, "fmi2SetRealInputDerivatives")
    }

    fn get_output_derivatives(&mut self, references: &[u32], orders: &[i32], values: &mut [f64]) -> Result<(), Fault> {
        let count = references.len().min(orders.len()).min(values.len());
        let get = needed(self.functions.fmi2GetRealOutputDerivatives, "fmi2GetRealOutputDerivatives")?;
        // SAFETY: see `set_up`; `count` elements are in all three arrays.
        let status = unsafe { get(self.component, references.as_ptr(), count, orders.as_ptr(), values.as_mut_ptr()) };
        self.checked(status, "fmi2GetRealOutputDerivatives")
    }

    fn do_step(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        // SAFETY: see `set_up`.
        let status = unsafe { (self.functions.fmi2DoStep)(self.component, time, step, TRUE) };
        match status {
            OK | WARNING => Ok(()),
            DISCARD => Err(self.discarded()),
            _ => Err(self.refused(status, "fmi2DoStep")),
        }
    }

    fn save(&mut self) -> Result<(), Fault> {
        if !self.description().capabilities.saves_states {
            return Err(Fault::new("the FMU cannot save its state (canGetAndSetFMUstate)"));
        }
        let save = needed(self.functions.fmi2GetFMUstate, "fmi2GetFMUstate")?;
        // SAFETY: see `set_up`; the place holds NULL or a state of this instance.
        let status = unsafe { save(self.component, &raw mut self.saved) };
        self.checked(status, "fmi2GetFMUstate")
    }

    fn restore(&mut self) -> Result<(), Fault> {
        if self.saved.is_null() {
            return Err(Fault::new("no state is kept"));
        }
        let restore = needed(self.functions.fmi2SetFMUstate, "fmi2SetFMUstate")?;
        // SAFETY: see `set_up`; a state of this instance.
        let status = unsafe { restore(self.component, self.saved) };
        self.checked(status, "fmi2SetFMUstate")
    }

    fn terminate(&mut self) -> Result<(), Fault> {
        // SAFETY: see `set_up`.
        let status = unsafe { (self.functions.fmi2Terminate)(self.component) };
        self.checked(status, "fmi2Terminate")
    }

    fn has_ended(&self) -> bool {
        self.ended
    }

    fn warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.log.messages().warnings)
    }
}

/// A function that a library may lack.
fn needed<F>(function: Option<F>, name: &str) -> Result<F, Fault> {
    function.ok_or_else(|| Fault::new(format!("the library of the FMU has no function {name}")))
}

impl Drop for LocalInstance {
    fn drop(&mut self) {
        if self.component.is_null() || self.broken {
            return;
        }
        let functions = &self.functions;
        // SAFETY: handle and state are alive, and not used again; log, texts and library are dropped after them.
        unsafe {
            if let (Some(free), false) = (functions.fmi2FreeFMUstate, self.saved.is_null()) {
                free(self.component, &raw mut self.saved);
            }
            (functions.fmi2FreeInstance)(self.component);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::Host;
    use crate::resource::Resource;
    use camdrive::drives::follower::load::Load;
    use camdrive::drives::parametric;
    use camdrive::drives::parametric::law::{Coordinate, Law, SeriesLaw};
    use camdrive::drives::rigid_machine::{InertiaFunction, MachineStart, Motor, Scene};
    use camdrive::drives::settings::Settings;
    use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
    use camdrive::motion::Fourier;

    fn flywheel(speed: f64) -> Resource {
        let scene = Scene {
            loads: vec![Default::default()],
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
        host.set_up(0.0, None, None).unwrap();
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
        host.set_up(0.0, None, None).unwrap();
        let refusal = host.set_reals(&[9999], &[0.0]).unwrap_err();
        assert!(refusal.to_string().contains("9999"), "{refusal}");
    }

    #[test]
    fn a_state_is_kept_and_restored_to_the_bit() {
        let mut host = Host::instantiate(&flywheel(3.0)).unwrap();
        assert!(host.restore().unwrap_err().message.contains("no state is kept"));
        host.set_up(0.0, Some(2.0), Some(1e-6)).unwrap();
        host.enter_initialization().unwrap();
        host.exit_initialization().unwrap();
        let (phi, torque) = (host.description().find("phi").unwrap(), host.description().find("M_an").unwrap());
        host.set(torque, 5.0).unwrap();
        // w' = M/J = 2.5, and φ = 3 t + 1.25 t².
        let mut derivatives = [0.0; 2];
        host.get_output_derivatives(&[reference("phi"), reference("w")], &[1, 1], &mut derivatives).unwrap();
        assert_eq!(derivatives, [3.0, 2.5]);
        for step in [0.25, 0.5] {
            host.save().unwrap();
            let before = host.get(phi).unwrap();
            let ends = [0, 1].map(|_| {
                host.restore().unwrap();
                assert_eq!(host.get(phi).unwrap(), before);
                host.do_step(step - 0.25, 0.25).unwrap();
                host.get(phi).unwrap()
            });
            let exact = 3.0 * step + 1.25 * step * step;
            assert!(ends[0] == ends[1] && (ends[0] - exact).abs() < 1e-9, "{ends:?}");
        }
        host.terminate().unwrap();
        assert!(host.do_step(0.5, 0.25).is_err() && host.warnings().is_empty());
    }

    #[test]
    fn whole_numbers_are_set_and_read() {
        let mut host = Host::instantiate(&flywheel(3.0)).unwrap();
        host.set_up(0.0, None, None).unwrap();
        host.enter_initialization().unwrap();
        let variables = &host.description().variables;
        let method = variables.iter().position(|v| v.about.kind.r#type() == Type::Integer).unwrap();
        let value = host.get(method).unwrap();
        assert_eq!(value.fract(), 0.0);
        let refusal = host.set(method, 1.5).unwrap_err().to_string();
        assert!(refusal.contains("1.5 is not admissible; expected a whole number"), "{refusal}");
    }
}
