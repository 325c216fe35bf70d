//! A resolved scene, and its drive with all descriptions.

use crate::cam_geometry::Plan;
use crate::documentation::Documentation;
use crate::forces::Loads;
use crate::transmission;
use camdrive::drives::backlash::{self, BacklashDrive};
use camdrive::drives::drive_train::{self, DriveTrain, Names};
use camdrive::drives::elastic_output::{self, ElasticOutput};
use camdrive::drives::elastic_shaft::{self, ElasticShaft};
use camdrive::drives::follower::load::Load;
use camdrive::drives::parametric::{self, ParametricDrive};
use camdrive::drives::resource::Content;
use camdrive::drives::rigid_machine::{self, RigidMachine};
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::{AnyDrive, Curve, Drive, Fault};
use camdrive::motion::MotionLaw;
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::ops::{Deref, DerefMut};

/// The longest name of a scene: importers use it as a file name and as a prefix of C functions.
pub const LONGEST_NAME: usize = 24;

/// True if Windows has a device of this name, which with any ending is no file there.
pub fn is_device(name: &str) -> bool {
    let upper = name.to_ascii_uppercase();
    match upper.strip_suffix(|c: char| c.is_ascii_digit()) {
        Some(port) => ["COM", "LPT"].contains(&port),
        None => ["CON", "PRN", "AUX", "NUL"].contains(&&*upper),
    }
}

/// True if a name is a C identifier and, with any ending, a file on every system.
pub fn is_name(name: &str) -> bool {
    let is_letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    let is_identifier = name.starts_with(is_letter) && name.chars().all(|c| is_letter(c) || c.is_ascii_digit());
    is_identifier && !is_device(name) && name.len() <= LONGEST_NAME
}

/// Declares [`Scene`] and the functions that dispatch on its models.
macro_rules! scenes {
    ($($model:ident: $scene:ty,)*) => {
        /// The [`Drive::Scene`] of one of the models: coherent SI.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub enum Scene {
            $(#[doc = concat!("Of a `", stringify!($model), "`.")] $model($scene),)*
        }

        $(impl From<$scene> for Scene {
            fn from(scene: $scene) -> Self {
                Scene::$model(scene)
            }
        })*

        impl Scene {
            /// The name of the model, one of [`camdrive::drives::MODELS`].
            pub fn model(&self) -> &'static str {
                match self {
                    $(Scene::$model(_) => $model::MODEL,)*
                }
            }

            /// Builds the drive.
            pub fn build(&self) -> Result<Described, Fault> {
                match self {
                    $(Scene::$model(scene) => $model::new(scene.clone()).map(Described::of),)*
                }
            }

            /// The scene of a model from the bytes that the runtime library reads.
            pub fn decoded(model: &str, bytes: &[u8]) -> Result<Self, Fault> {
                let scene = match model {
                    $($model::MODEL => postcard::from_bytes(bytes).map(Scene::$model),)*
                    _ => return Err(Fault::new(format!("unknown model `{model}`"))),
                };
                scene.map_err(|e| Fault::new(format!("the scene of {model} cannot be decoded: {e}")))
            }

            /// The scene as the runtime library reads it.
            pub fn encoded(&self) -> Result<Vec<u8>, Fault> {
                let bytes = match self {
                    $(Scene::$model(scene) => postcard::to_stdvec(scene),)*
                };
                bytes.map_err(|e| Fault::new(format!("the scene of {} cannot be encoded: {e}", self.model())))
            }
        }
    };
}

scenes! {
    ElasticOutput: elastic_output::Scene,
    ElasticShaft: elastic_shaft::Scene,
    BacklashDrive: backlash::Scene,
    RigidMachine: rigid_machine::Scene,
    ParametricDrive: parametric::Scene,
    DriveTrain: drive_train::Scene,
}

impl Scene {
    /// The model that the file names; a scene solved as a train may have the names of a single model.
    pub fn model_name(&self) -> &'static str {
        match self {
            Scene::DriveTrain(drive_train::Scene { names: Names::Backlash(_), .. }) => BacklashDrive::MODEL,
            Scene::DriveTrain(drive_train::Scene { names: Names::Machine(_), .. }) => RigidMachine::MODEL,
            _ => self.model(),
        }
    }

    /// The law of the only cam of a cam drive.
    pub fn cam(&self) -> Option<&MotionLaw> {
        match self {
            Scene::ElasticOutput(scene) => Some(&scene.cam),
            Scene::ElasticShaft(scene) => Some(&scene.cam),
            Scene::BacklashDrive(scene) => Some(&scene.cam),
            _ => None,
        }
    }

    /// Law, mechanisms and masses of follower j, counted from 0, of a machine or train.
    pub fn follower(&self, j: usize) -> Option<&rigid_machine::Follower> {
        match self {
            Scene::RigidMachine(scene) => scene.followers.get(j),
            Scene::DriveTrain(scene) => scene.followers.get(j).map(|follower| &follower.rigid),
            _ => None,
        }
    }

    /// The number of followers of a machine or train.
    pub fn followers(&self) -> usize {
        match self {
            Scene::RigidMachine(scene) => scene.followers.len(),
            Scene::DriveTrain(scene) => scene.followers.len(),
            _ => 0,
        }
    }

    /// The loads on tool and roller of follower j, counted from 0; for a cam drive the loads in addition to its cam.
    pub fn loads(&self, j: usize) -> [Load; 2] {
        match self {
            Scene::ElasticOutput(scene) => [scene.load.clone(), scene.roller.1.clone()],
            Scene::ElasticShaft(scene) => [scene.load.clone(), Load::default()],
            Scene::DriveTrain(drive_train::Scene { followers, .. }) => {
                followers.get(j).map(|follower| [follower.load.clone(), follower.roller.clone()]).unwrap_or_default()
            }
            _ => Default::default(),
        }
    }

    /// True if follower j, counted from 0, can leave its cam and has no second flank.
    pub fn is_one_sided(&self, j: usize) -> bool {
        match self {
            Scene::BacklashDrive(scene) => j == 0 && scene.parameters.s.is_infinite(),
            Scene::DriveTrain(scene) => {
                let joint = scene.followers.get(j).map(|follower| follower.joint);
                matches!(joint, Some(drive_train::Joint::Backlash(p)) if p.s.is_infinite())
            }
            _ => false,
        }
    }

    /// The prescribed motion of the shaft.
    pub fn drive(&self) -> Option<&DriveMode> {
        match self {
            Scene::ElasticOutput(scene) => Some(&scene.drive),
            Scene::ElasticShaft(scene) => Some(&scene.drive),
            Scene::BacklashDrive(scene) => Some(&scene.drive),
            Scene::ParametricDrive(scene) => Some(&scene.drive),
            Scene::DriveTrain(drive_train::Scene { shaft: drive_train::Shaft::Driven(drive), .. }) => Some(drive),
            Scene::RigidMachine(_) | Scene::DriveTrain(_) => None,
        }
    }

    /// The prescribed motion of the shaft, to change it.
    pub fn drive_mut(&mut self) -> Option<&mut DriveMode> {
        match self {
            Scene::ElasticOutput(scene) => Some(&mut scene.drive),
            Scene::ElasticShaft(scene) => Some(&mut scene.drive),
            Scene::BacklashDrive(scene) => Some(&mut scene.drive),
            Scene::ParametricDrive(scene) => Some(&mut scene.drive),
            Scene::DriveTrain(drive_train::Scene { shaft: drive_train::Shaft::Driven(drive), .. }) => Some(drive),
            Scene::RigidMachine(_) | Scene::DriveTrain(_) => None,
        }
    }
}

/// A resolved scene: coherent SI, validated by the exporter.
#[derive(Clone, Debug, PartialEq)]
pub struct Resource {
    /// The name of the scene, which is the FMU's modelName and modelIdentifier.
    pub name: String,
    /// The guid of the model description.
    pub guid: String,
    /// Model and values.
    pub scene: Scene,
    /// The tools after mechanisms whose motion is prescribed; the scene has the laws of their levers instead.
    pub tools: Vec<Tool>,
    /// For the analysis of forces: the geometry of each follower's cam, and the loads in addition to the scene's.
    pub contacts: Vec<(Option<Plan>, Loads)>,
}

/// The prescribed motion of a tool.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Its section in the scene, `follower[1].tool`.
    pub section: String,
    /// U(φ).
    pub law: MotionLaw,
    /// The unit of U, m or rad.
    pub unit: &'static str,
}

impl Resource {
    /// A resource of a scene without tools after mechanisms and geometry, with an empty guid.
    pub fn new(name: &str, scene: impl Into<Scene>) -> Self {
        let (name, guid) = (name.to_owned(), String::new());
        Resource { name, guid, scene: scene.into(), tools: Vec::new(), contacts: Vec::new() }
    }

    /// The name of the model.
    pub fn model(&self) -> &'static str {
        self.scene.model()
    }

    /// Builds the drive.
    pub fn build(&self) -> Result<Described, Fault> {
        self.scene.build()
    }

    /// The bytes of `resources/drive.bin`.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Fault> {
        Content { model: self.model(), guid: &self.guid, scene: &self.scene.encoded()? }.to_bytes()
    }
}

/// A drive with its descriptions.
pub struct Described {
    drive: AnyDrive,
    portrait: Box<dyn Portrait>,
}

/// Text and curves of a drive from its scene.
trait Portrait {
    fn documentation(&self) -> Result<Documentation, Fault>;
    fn curves(&self) -> Vec<Curve>;
}

impl<D: Drive> Portrait for D {
    fn documentation(&self) -> Result<Documentation, Fault> {
        // A page has the text already.
        if cfg!(target_arch = "wasm32") {
            return Err(Fault::new("the module of a page has no documentation"));
        }
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
    /// The description of this drive.
    pub fn of<D: Drive + Into<AnyDrive>>(drive: D) -> Self {
        Described { portrait: Box::new(drive.clone()), drive: drive.into() }
    }

    /// Documentation of the drive.
    ///
    /// # Errors
    /// An invalid text of the drive.
    pub fn documentation(&self) -> Result<Documentation, Fault> {
        self.portrait.documentation()
    }

    /// Curves that picture the drive.
    pub fn curves(&self) -> Vec<Curve> {
        self.portrait.curves()
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
