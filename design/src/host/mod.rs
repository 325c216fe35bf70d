//! A host of FMUs: it drives an instance like an importer and is safe to use.
//!
//! An [`Fmu`] comes from a file or from a [`crate::resource::Resource`], whose library is the one in this tool. A library of
//! this tool's own sources is in this process; a foreign one is in a process of its own if the program calls [`serve`]. All
//! give instances of one kind, [`Host`]. The studies of [`crate`] use it to measure the result that an importer will get.

#[allow(unsafe_code)]
mod callbacks;
mod description;
mod fmu;
#[allow(unsafe_code)]
mod functions;
#[allow(unsafe_code)]
mod instance;
mod process;
mod serve;

use camdrive::drives::Fault;
pub use description::{Capabilities, Experiment, ModelDescription, Unit, Variable};
use fmu::Runtime;
pub use fmu::{DESCRIPTION, Fmu, MODEL, REFERENCES, TemporaryFolder, platforms, unpacked};
use instance::LocalInstance;
use process::Remote;
pub use process::{LIMIT, limit};
pub use serve::serve;
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

/// The functions of an instance. Values have the units of the variables, see [`Variable`].
///
/// # Errors
/// Of each: the instance's message if it refuses; the cause of death of one in another process.
pub trait Instance {
    /// Sets start and stop time (s), and the relative tolerance.
    fn set_up(&mut self, start: f64, stop: Option<f64>, tolerance: Option<f64>) -> Result<(), Fault>;
    /// Begins initialisation.
    fn enter_initialization(&mut self) -> Result<(), Fault>;
    /// Ends initialisation: the initial state is computed.
    fn exit_initialization(&mut self) -> Result<(), Fault>;
    /// Sets a variable of any type, by its index in the description. A value of another type is refused.
    fn set(&mut self, variable: usize, value: f64) -> Result<(), Fault>;
    /// Reads a variable of any type, by its index in the description.
    fn get(&mut self, variable: usize) -> Result<f64, Fault>;
    /// Sets Reals by their references; the lists are of one length.
    fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Result<(), Fault>;
    /// Reads Reals by their references; the lists are of one length.
    fn get_reals(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Fault>;
    /// Sets input derivatives by references and orders; the lists are of one length.
    fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Result<(), Fault>;
    /// Reads output derivatives by references and orders; the lists are of one length.
    fn get_output_derivatives(&mut self, references: &[u32], orders: &[i32], values: &mut [f64]) -> Result<(), Fault>;
    /// Advances from the communication point `time` by `step` (s). States of earlier points can no longer be restored. The
    /// fault of a discarded step says whether the FMU ends the simulation, and how far it went.
    fn do_step(&mut self, time: f64, step: f64) -> Result<(), Fault>;
    /// Saves the present state and drops the one before. An FMU that cannot save states refuses.
    fn save(&mut self) -> Result<(), Fault>;
    /// Goes back to the saved state; it may be restored any number of times.
    fn restore(&mut self) -> Result<(), Fault>;
    /// Ends the simulation; the values can still be read.
    fn terminate(&mut self) -> Result<(), Fault>;
    /// Frees the instance, which is unusable afterwards. Dropping it frees it, too, but does not report faults of its library.
    fn free(&mut self) -> Result<(), Fault> {
        Ok(())
    }
    /// True if the instance itself ended the simulation in the last step.
    fn has_ended(&self) -> bool;
    /// The warnings that nobody has read yet, a hundred at most of each call.
    fn warnings(&mut self) -> Vec<String>;
}

/// An instance of an FMU.
///
/// After an error it can only be dropped; only a discarded step may be tried again from a saved state.
pub struct Host {
    instance: Box<dyn Instance>,
    content: Arc<fmu::Content>,
}

impl Fmu {
    /// An instance of this name.
    ///
    /// # Errors
    /// The library's message if it refuses; a second instance in this process if the FMU allows only one.
    pub fn instantiate(&self, name: &str) -> Result<Host, Fault> {
        let content = Arc::clone(&self.0);
        let instance: Result<Box<dyn Instance>, Fault> = match &content.runtime {
            Runtime::Here { functions, .. } => {
                LocalInstance::new(&content, functions, name).map(|of| Box::new(of) as _)
            }
            Runtime::Apart(idle) => Remote::new(&content.folder, idle, name).map(|of| Box::new(of) as _),
        };
        let instance = instance.map_err(|fault| content.description.not_started(fault))?;
        Ok(Host { instance, content })
    }
}

impl Host {
    /// An instance of the FMU of this scene.
    ///
    /// # Errors
    /// The errors of [`Fmu::linked`] and [`Fmu::instantiate`].
    pub fn instantiate(resource: &crate::resource::Resource) -> Result<Self, Fault> {
        Fmu::linked(resource)?.instantiate(&resource.name)
    }

    /// True if its library is of this tool's own sources.
    pub fn is_own(&self) -> bool {
        self.content.is_own
    }

    /// The model description of its FMU.
    pub fn description(&self) -> &ModelDescription {
        &self.content.description
    }
}

impl Deref for Host {
    type Target = dyn Instance;
    fn deref(&self) -> &Self::Target {
        &*self.instance
    }
}

impl DerefMut for Host {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut *self.instance
    }
}
