//! A scene that is resolved, and the drive of it with all that is said of it.

use crate::documentation::Documentation;
use crate::transmission;
use camdrive::all_drives;
use camdrive::drives::resource::{Content, unknown};
use camdrive::drives::rigid_machine::RigidMachine;
use camdrive::drives::{AnyDrive, Curve, Drive, Fault};
use camdrive::motion::MotionLaw;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::any::Any;
use std::ops::{Deref, DerefMut};

/// All drive models.
pub const TEMPLATES: &[Template] = all_drives!(Template);

/// The longest name of a scene: importers use it as a file name and as a prefix of C functions.
pub const LONGEST_NAME: usize = 24;

/// Whether Windows has a device of this name, which with any ending is no file there.
pub fn is_device(name: &str) -> bool {
    let upper = name.to_ascii_uppercase();
    match upper.strip_suffix(|c: char| c.is_ascii_digit()) {
        Some(port) => ["COM", "LPT"].contains(&port),
        None => ["CON", "PRN", "AUX", "NUL"].contains(&&*upper),
    }
}

/// Whether a name is a C identifier and, with any ending, a file on every system.
pub fn is_name(name: &str) -> bool {
    let is_letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    let is_identifier = name.starts_with(is_letter) && name.chars().all(|c| is_letter(c) || c.is_ascii_digit());
    is_identifier && !is_device(name) && name.len() <= LONGEST_NAME
}

/// A resolved scene: coherent SI, validated by the exporter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resource {
    /// The name of the scene, which is the FMU's modelName and modelIdentifier.
    pub name: String,
    /// One of [`TEMPLATES`].
    pub model: String,
    /// The guid of the model description.
    pub guid: String,
    /// The [`camdrive::drives::Drive::Scene`] of the model as JSON.
    pub scene: Value,
    /// The tools behind mechanisms whose motion is prescribed; the scene has the laws of their levers instead.
    pub tools: Vec<Tool>,
}

/// The prescribed motion of a tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Where the scene gives it, `follower[1].tool`.
    pub section: String,
    /// U(φ).
    pub law: MotionLaw,
    /// The unit of U, m or rad.
    pub unit: &'static str,
}

impl Resource {
    fn template(&self) -> Result<&'static Template, Fault> {
        let known = || TEMPLATES.iter().map(|m| m.name);
        TEMPLATES.iter().find(|m| m.name == self.model).ok_or_else(|| unknown(&self.model, known()))
    }

    /// Builds the drive.
    pub fn build(&self) -> Result<Described, Fault> {
        (self.template()?.build)(&self.scene)
    }

    /// The scene of a model.
    ///
    /// # Errors
    /// Where it is none of this model.
    pub fn read<S: DeserializeOwned>(&self) -> Result<S, Fault> {
        serde_json::from_value(self.scene.clone())
            .map_err(|e| Fault::new(format!("the resolved scene of {} cannot be read: {e}", self.model)))
    }

    /// The scene as the runtime library reads them.
    pub fn encoded_scene(&self) -> Result<Vec<u8>, Fault> {
        (self.template()?.encode)(&self.scene)
    }

    /// The bytes of `resources/drive.bin`.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Fault> {
        Content { model: &self.model, guid: &self.guid, scene: &self.encoded_scene()? }.to_bytes()
    }
}

/// A drive with all that is said of it.
pub struct Described {
    drive: AnyDrive,
    said: Box<dyn Said>,
}

/// Text and curves of a drive as its scene describes it.
trait Said {
    fn documentation(&self) -> Result<Documentation, Fault>;
    fn curves(&self) -> Vec<Curve>;
}

impl<D: Drive> Said for D {
    fn documentation(&self) -> Result<Documentation, Fault> {
        let mut documentation = Documentation::of(&self.text())?;
        if let Some(machine) = (self as &dyn Any).downcast_ref::<RigidMachine>() {
            documentation.limits.extend(transmission::limits(&machine.inertia().followers));
        }
        Ok(documentation)
    }

    fn curves(&self) -> Vec<Curve> {
        self.curves()
    }
}

impl Described {
    /// Documentation of the drive.
    ///
    /// # Errors
    /// Where the text of the drive is none.
    pub fn documentation(&self) -> Result<Documentation, Fault> {
        self.said.documentation()
    }

    /// Curves that picture the drive.
    pub fn curves(&self) -> Vec<Curve> {
        self.said.curves()
    }
}

impl Deref for Described {
    type Target = AnyDrive;
    fn deref(&self) -> &AnyDrive {
        &self.drive
    }
}

impl DerefMut for Described {
    fn deref_mut(&mut self) -> &mut AnyDrive {
        &mut self.drive
    }
}

/// A drive model as the command line knows it; resolved scenes are JSON.
pub struct Template {
    /// The name that scenes use.
    pub name: &'static str,
    /// Builds a drive from the resolved scene.
    pub build: fn(&Value) -> Result<Described, Fault>,
    /// The resolved scene as the runtime library reads them.
    pub encode: fn(&Value) -> Result<Vec<u8>, Fault>,
}

impl Template {
    /// The entry of the drive type `D`.
    pub const fn of<D: Drive>() -> Self {
        Template { name: D::MODEL, build: build::<D>, encode: encode::<D> }
    }
}

fn fault<D: Drive>(reason: &dyn std::fmt::Display) -> Fault {
    Fault::new(format!("the resolved scene of {} cannot be read: {reason}", D::MODEL))
}

fn scene<D: Drive>(scene: &Value) -> Result<D::Scene, Fault> {
    serde_json::from_value(scene.clone()).map_err(|e| fault::<D>(&e))
}

fn build<D: Drive>(json: &Value) -> Result<Described, Fault> {
    let drive = D::new(scene::<D>(json)?)?;
    Ok(Described { said: Box::new(drive.clone()), drive: AnyDrive::new(drive) })
}

fn encode<D: Drive>(json: &Value) -> Result<Vec<u8>, Fault> {
    postcard::to_stdvec(&scene::<D>(json)?).map_err(|e| fault::<D>(&e))
}
