//! A model whose type is known only at run time.

use super::{AnyDrive, Drive, Fault};

/// A drive model as the runtime library knows it.
pub struct Model {
    /// The name that scenes use.
    pub name: &'static str,
    /// Builds a drive from the resolved scene in postcard's encoding.
    pub build: fn(&[u8]) -> Result<AnyDrive, Fault>,
}

impl Model {
    /// The entry of the drive type `D`.
    pub const fn of<D: Drive>() -> Self {
        Model { name: D::MODEL, build: build::<D> }
    }
}

fn build<D: Drive>(bytes: &[u8]) -> Result<AnyDrive, Fault> {
    let scene: D::Scene = postcard::from_bytes(bytes)
        .map_err(|e| Fault::new(format!("the resolved scene of {} cannot be read: {e}", D::MODEL)))?;
    Ok(AnyDrive::new(D::new(scene)?))
}
