//! The resolved scene as an FMU carries it in `resources/drive.bin`.
//!
//! Bytes: magic (8) · model, guid and scene in postcard's encoding · CRC-32 of everything before it (4, little-endian).

use super::{AnyDrive, Fault, Model};
use serde::{Deserialize, Serialize};

/// The name of the file in the resources folder of an FMU.
pub const FILE_NAME: &str = "drive.bin";

/// Change this when the encoding of the file changes; changes of the scenes' encoding show in the guid.
const MAGIC: &[u8; 8] = b"camscen3";
const CHECKSUM: usize = 4;

/// Version and sources. Every library contains this text. The command line checks it before it packs a library, since a scene is
/// encoded for the library of the same sources.
pub const BUILD: &str = concat!("camdrive ", env!("CARGO_PKG_VERSION"), ", sources ", env!("CAMDRIVE_SOURCES"));

/// Content of the file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Content<'a> {
    /// The name of a model.
    pub model: &'a str,
    /// The guid of the model description.
    pub guid: &'a str,
    /// The [`super::Drive::Scene`] of the model in postcard's encoding: coherent SI, validated by the exporter.
    pub scene: &'a [u8],
}

fn refused(reason: impl std::fmt::Display) -> Fault {
    Fault::new(format!("resources/{FILE_NAME} cannot be read: {reason}"))
}

impl<'a> Content<'a> {
    /// Reads the bytes of `resources/drive.bin`; refuses foreign and damaged ones.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, Fault> {
        let Some((body, checksum)) = bytes.split_last_chunk::<CHECKSUM>() else { return Err(refused("it is cut off")) };
        let Some(content) = body.strip_prefix(MAGIC) else {
            return Err(refused(format_args!("it was not made for this library, {}", BUILD)));
        };
        if u32::from_le_bytes(*checksum) != crc32fast::hash(body) {
            return Err(refused("it is damaged, its checksum is wrong"));
        }
        postcard::from_bytes(content).map_err(refused)
    }

    /// The bytes of `resources/drive.bin`.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Fault> {
        let content = postcard::to_stdvec(self)
            .map_err(|e| Fault::new(format!("resources/{FILE_NAME} cannot be written: {e}")))?;
        let mut bytes = [MAGIC.as_slice(), &content].concat();
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        Ok(bytes)
    }

    /// Builds the drive of one of the `models`.
    pub fn build(&self, models: &[Model]) -> Result<AnyDrive, Fault> {
        let known = || models.iter().map(|m| m.name);
        let model = models.iter().find(|m| m.name == self.model).ok_or_else(|| unknown(self.model, known()))?;
        (model.build)(self.scene)
    }
}

/// The fault of a `model` that is not among the `known`.
pub fn unknown<'a>(model: &str, known: impl Iterator<Item = &'a str>) -> Fault {
    Fault::new(format!("unknown model `{model}`; expected one of {}", known.collect::<Vec<&str>>().join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_bytes_are_refused() {
        let content = Content { model: "Unknown", guid: "{1}", scene: &[1, 2, 3] };
        let bytes = content.to_bytes().unwrap();
        assert_eq!(Content::from_bytes(&bytes), Ok(content));
        assert!(
            content
                .build(crate::drives::MODELS)
                .err()
                .unwrap()
                .to_string()
                .contains("unknown model `Unknown`; expected one of Elastic")
        );
        for length in 0..bytes.len() {
            assert!(Content::from_bytes(&bytes[..length]).is_err(), "{length} bytes");
        }
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1;
            assert!(Content::from_bytes(&damaged).is_err(), "byte {at}");
        }
    }
}
