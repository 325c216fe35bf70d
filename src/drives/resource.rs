//! The resolved scene as an FMU carries it in `resources/drive.json`.

use super::{DynDrive, Fault, MODELS};
use serde::{Deserialize, Serialize};

/// The name of the file in the resources folder of an FMU.
pub const FILE_NAME: &str = "drive.json";

/// A resolved scene: coherent SI, validated by the exporter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resource {
    /// The name of the scene, which is the FMU's modelName and modelIdentifier.
    pub name: String,
    /// One of [`MODELS`].
    pub model: String,
    /// The guid of the model description.
    pub guid: String,
    /// The [`super::Drive::Scene`] of the model.
    pub scene: serde_json::Value,
}

impl Resource {
    /// Reads the text of `resources/drive.json`.
    pub fn from_json(text: &str) -> Result<Self, Fault> {
        serde_json::from_str(text).map_err(|e| Fault(format!("resources/{FILE_NAME} cannot be read: {e}")))
    }

    /// Builds the drive.
    pub fn build(&self) -> Result<Box<dyn DynDrive>, Fault> {
        let model = MODELS.iter().find(|m| m.name == self.model).ok_or_else(|| {
            let known: Vec<&str> = MODELS.iter().map(|m| m.name).collect();
            Fault(format!("resources/{FILE_NAME}: unknown model `{}`; known are {}", self.model, known.join(", ")))
        })?;
        (model.build)(&self.scene.to_string())
    }
}
