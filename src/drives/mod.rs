//! The drive models: equation, parameters, variables, solver.
//!
//! A model is one folder and two lines here, `pub mod` and its entry in `all_drives!`; everything that an importer sees of
//! it (variables, units, dependencies, equations, documentation) comes from there.

pub mod backlash;
pub mod cam_drive;
pub mod cam_turn;
pub mod curve;
pub mod elastic_output;
pub mod elastic_shaft;
pub mod erased;
pub mod event;
mod experiment;
pub mod flow;
pub mod limits;
pub mod model;
pub mod oscillator;
pub mod parameter;
pub mod parametric;
pub mod resource;
pub mod response;
pub mod rigid_machine;
pub mod solver;
mod step_control;
pub mod unit;
pub mod variable;

pub use crate::numerics::number::{Number, Rounded};
pub use curve::Curve;
pub use erased::AnyDrive;
pub use event::{Event, EventLog};
pub use experiment::Experiment;
pub use model::Model;
pub use oscillator::PeriodicOscillator;
pub use variable::{Description, List, Variable};

use serde::{Serialize, de::DeserializeOwned};

/// The one list of the drive models: an array of `$entry::of::<D>()` for every model D.
#[macro_export]
macro_rules! all_drives {
    ($entry:ty) => {
        &[
            <$entry>::of::<$crate::drives::elastic_output::ElasticOutput>(),
            <$entry>::of::<$crate::drives::elastic_shaft::ElasticShaft>(),
            <$entry>::of::<$crate::drives::backlash::BacklashDrive>(),
            <$entry>::of::<$crate::drives::rigid_machine::RigidMachine>(),
            <$entry>::of::<$crate::drives::parametric::ParametricDrive>(),
        ]
    };
}

/// All drive models.
pub const MODELS: &[Model] = all_drives!(Model);

/// Why a drive cannot go on. In a box, since every step returns one or none.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault(pub Box<Reason>);

/// Variable and message of a [`Fault`].
#[derive(Clone, Debug, PartialEq)]
pub struct Reason {
    /// The variable at fault, by its name in the FMU; empty where it is none in particular.
    pub variable: String,
    /// One sentence that names the quantity, its value and what would be admissible.
    pub message: String,
    /// Whether the name of the variable stands before the message, which then goes on from there.
    pub named: bool,
}

impl Fault {
    /// A fault of no variable in particular.
    pub fn new(message: impl Into<String>) -> Self {
        Fault(Box::new(Reason { variable: String::new(), message: message.into(), named: false }))
    }

    /// That of a variable.
    pub fn of(mut self, variable: impl Into<String>) -> Self {
        self.0.variable = variable.into();
        self
    }

    /// A fault of a variable, with whose name the message begins.
    pub fn named(variable: impl Into<String>, message: impl Into<String>) -> Self {
        Fault(Box::new(Reason { variable: variable.into(), message: message.into(), named: true }))
    }
}

impl std::ops::Deref for Fault {
    type Target = Reason;
    fn deref(&self) -> &Reason {
        &self.0
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.named {
            write!(f, "`{}`", self.variable)?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for Fault {}

/// The variable with respect to which the series of an output is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seed {
    /// Time: the coefficients are those of the output along the motion.
    Time,
    /// The input or state with this value reference: c₁ is the partial derivative, the other knowns held.
    Known(usize),
}

/// Documentation of a drive for people.
#[derive(Clone, Debug)]
pub struct Text {
    /// The file beside the drive's code: TOML with `sources` and passages `summary`, `equation`, `accuracy` and `limit`, each
    /// with the conditions `when` it holds.
    pub file: &'static str,
    /// All conditions that the file may name, and whether they hold.
    pub conditions: Vec<(&'static str, bool)>,
    /// Limits that depend on the values of the scene.
    pub limits: Vec<String>,
}

impl Text {
    /// A text without limits of its own.
    pub fn new(file: &'static str, conditions: &[(&'static str, bool)]) -> Self {
        Text { file, conditions: conditions.to_vec(), limits: Vec::new() }
    }

    /// Whether a condition holds, "inputs" or "not inputs".
    ///
    /// # Errors
    /// Where the drive knows no such condition.
    pub fn holds(&self, condition: &str) -> Result<bool, Fault> {
        let (name, wanted) = condition.strip_prefix("not ").map_or((condition, true), |name| (name, false));
        let known = self.conditions.iter().find(|(known, _)| *known == name);
        known
            .map(|(_, holds)| *holds == wanted)
            .ok_or_else(|| Fault::new(format!("`{name}` is not a condition of this drive")))
    }
}

/// A drive model in operation: parameters, inputs and the state at the communication point.
///
/// The value is the whole FMU state: a clone is a snapshot, its serialisation restores it bit by bit.
/// Caches that follow from the rest may be skipped in the serialisation when [`Drive::apply`] or
/// [`Drive::restored`] rebuilds them to the same bits.
pub trait Drive: Clone + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// The model as the scene describes it, validated, coherent SI.
    type Scene: Serialize + DeserializeOwned;

    /// The name of the model, as scenes write it.
    const MODEL: &'static str;

    /// The highest order of input derivatives that [`Drive::advance`] takes into account.
    const INPUT_DERIVATIVES: usize = 0;

    /// A drive at time zero. Refuses what no parameter value could mend.
    fn new(scene: Self::Scene) -> Result<Self, Fault>;

    /// All variables, in the order of their value references.
    fn variables(&self) -> List<Self>;

    /// Documentation of the drive.
    fn text(&self) -> Text;

    /// Curves that picture the drive, the most telling first: for a cam drive [`Curve::of_law`]. Without any,
    /// the documentation has no drawing.
    fn curves(&self) -> Vec<Curve> {
        Vec::new()
    }

    /// The drive as an oscillator with periodic coefficients, linearised where it is not linear; None where it is none.
    fn oscillator(_scene: &Self::Scene) -> Option<PeriodicOscillator> {
        None
    }

    /// The default experiment.
    fn experiment(&self) -> Experiment;

    /// Computes the initial state at `time` (s) from parameters, start values and inputs. Called when
    /// initialisation ends and, before that, whenever a value is read after one was set.
    fn start(&mut self, time: f64) -> Result<(), Fault>;

    /// Takes up tunable parameters and inputs that were set at the communication point `time` (s).
    fn apply(&mut self, time: f64) -> Result<(), Fault>;

    /// The angle of the drive shaft at the `end` of a step from `time` (s), as far as it is known before the step (rad);
    /// 0 of a drive without one.
    fn angle(&self, _time: f64, _end: f64) -> f64 {
        0.0
    }

    /// Advances from the communication point `time` to `time + step` (s), step > 0. Does not allocate.
    /// After a fault the drive is used no more until it is reset or an earlier state is restored.
    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault>;

    /// Computes what the variables tell of the communication point, each value in the place that its declaration names
    /// ([`Variable::at`]).
    fn evaluate(&self, values: &mut [f64]);

    /// Sets the time derivative of order ≥ 1 of the input `reference`, valid for the next step.
    fn set_input_derivative(&mut self, reference: usize, order: usize, value: f64);

    /// The relative tolerance that the importer asked for at set-up, 0 for none; never makes the result worse than
    /// the documented default.
    fn request_tolerance(&mut self, tolerance: f64);

    /// Whether the states are finite numbers; asked after each step, so that none that is not leaves as a result.
    fn is_finite(&self) -> bool;

    /// Events since the log was last cleared.
    fn events(&mut self) -> &mut EventLog;

    /// Called on a drive that was just read from bytes: rebuilds what the serialisation leaves out, to the same bits, or takes
    /// it from `made`, the drive as it was made of the scene with the parameters of this one. Refuses what can be no state of this drive.
    fn restored(&mut self, _made: &Self) -> Result<(), Fault> {
        Ok(())
    }
}
