//! What is done with a model whose type is known only at run time: the runtime library builds its drive, the command
//! line does more with it.

use super::erased::{self, DynDrive};
use super::{Drive, Fault};

/// A drive model as the runtime library knows it.
pub struct Model {
    /// The name that scenes use.
    pub name: &'static str,
    /// Builds a drive from the resolved scene and its tables in postcard's encoding.
    pub build: fn(&[u8]) -> Result<Box<dyn DynDrive>, Fault>,
}

impl Model {
    /// The entry of the drive type `D`.
    pub const fn of<D: Drive>() -> Self {
        Model { name: D::MODEL, build: build::<D> }
    }
}

fn build<D: Drive>(bytes: &[u8]) -> Result<Box<dyn DynDrive>, Fault> {
    let (scene, tables): (D::Scene, &[u8]) = postcard::from_bytes(bytes)
        .map_err(|e| Fault(format!("the resolved scene of {} cannot be read: {e}", D::MODEL)))?;
    Ok(erased::unit(D::with_tables(scene, tables)?))
}

#[cfg(feature = "cli")]
pub use described::{Described, Template};

/// Apart from [`Model`], so that the linker drops from the runtime library what only the command line calls.
#[cfg(feature = "cli")]
mod described {
    use super::super::erased::{self, DynDrive};
    use super::super::simplification::{Simplification, Simplified};
    use super::super::{Curve, Drive, Fault, PeriodicOscillator, Portrait};
    use serde_json::Value;

    /// A drive with all that is said of it.
    pub trait Described: DynDrive {
        /// What the documentation says of the drive.
        fn portrait(&self) -> Portrait;
        /// Curves that picture the drive.
        fn curves(&self) -> Vec<Curve>;
    }

    /// A drive model as the command line knows it; resolved scenes are JSON.
    pub struct Template {
        /// The name that scenes use.
        pub name: &'static str,
        /// Builds a drive from the resolved scene.
        pub build: fn(&Value) -> Result<Box<dyn Described>, Fault>,
        /// The resolved scene and its tables as the runtime library reads them.
        pub encode: fn(&Value) -> Result<Vec<u8>, Fault>,
        /// [`Drive::simplifications`] of a resolved scene.
        pub simplifications: fn(&Value) -> Result<Vec<Simplification<Value>>, Fault>,
        /// [`Drive::oscillator`] of a resolved scene.
        pub oscillator: fn(&Value) -> Result<Option<PeriodicOscillator>, Fault>,
    }

    impl Template {
        /// The entry of the drive type `D`.
        pub const fn of<D: Drive>() -> Self {
            Template {
                name: D::MODEL,
                build: build::<D>,
                encode: encode::<D>,
                simplifications: simplifications::<D>,
                oscillator: oscillator::<D>,
            }
        }
    }

    fn fault<D: Drive>(reason: &dyn std::fmt::Display) -> Fault {
        Fault(format!("the resolved scene of {} cannot be read: {reason}", D::MODEL))
    }

    fn scene<D: Drive>(scene: &Value) -> Result<D::Scene, Fault> {
        serde_json::from_value(scene.clone()).map_err(|e| fault::<D>(&e))
    }

    fn build<D: Drive>(json: &Value) -> Result<Box<dyn Described>, Fault> {
        Ok(erased::unit(D::new(scene::<D>(json)?)?))
    }

    fn encode<D: Drive>(json: &Value) -> Result<Vec<u8>, Fault> {
        let tables = D::new(scene::<D>(json)?)?.tables()?;
        postcard::to_stdvec(&(scene::<D>(json)?, tables.as_slice())).map_err(|e| fault::<D>(&e))
    }

    fn oscillator<D: Drive>(json: &Value) -> Result<Option<PeriodicOscillator>, Fault> {
        Ok(D::oscillator(&scene::<D>(json)?))
    }

    fn simplifications<D: Drive>(json: &Value) -> Result<Vec<Simplification<Value>>, Fault> {
        let erased = |Simplification { feature, instead, model }: Simplification<D::Scene>| {
            let model = match model {
                Simplified::Scene(scene) => Simplified::Scene(serde_json::to_value(scene).map_err(|e| fault::<D>(&e))?),
                Simplified::Formula(formula) => Simplified::Formula(formula),
            };
            Ok(Simplification { feature, instead, model })
        };
        D::simplifications(&scene::<D>(json)?).into_iter().map(erased).collect()
    }
}
