//! The interface of a drive model.

use super::{Curve, EventLog, Experiment, Fault, List, Text};
use serde::{Serialize, de::DeserializeOwned};

/// The variable with respect to which the series of an output is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seed<'a> {
    /// Time: the coefficients follow the output along the motion.
    Time,
    /// The input or state with this name: c₁ is the partial derivative, the other knowns held.
    Known(&'a str),
}

impl Seed<'_> {
    /// ∂variable/∂known for an input or state with this `name`.
    pub fn of(self, name: &str) -> f64 {
        if self == Seed::Known(name) { 1.0 } else { 0.0 }
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

    /// A drive at time zero. Refuses scenes that no parameter value could mend.
    fn new(scene: Self::Scene) -> Result<Self, Fault>;

    /// All variables, in the order of their value references.
    fn variables(&self) -> List<Self>;

    /// Documentation of the drive.
    fn text(&self) -> Text;

    /// Curves that picture the drive, the most informative first: for a cam drive [`Curve::of_law`].
    fn curves(&self) -> Vec<Curve>;

    /// The default experiment.
    fn experiment(&self) -> Experiment;

    /// Computes the initial state at `time` (s) from parameters, start values and inputs. Called when
    /// initialisation ends and, before that, whenever a value is read after one was set.
    fn start(&mut self, time: f64) -> Result<(), Fault>;

    /// Takes up tunable parameters and inputs that were set at the communication point `time` (s).
    fn apply(&mut self, time: f64) -> Result<(), Fault>;

    /// The angle of the drive shaft at the `end` of a step from `time` (s), as far as it is known before the step (rad); 0 for a
    /// drive without a shaft.
    fn angle(&self, _time: f64, _end: f64) -> f64 {
        0.0
    }

    /// Advances from the communication point `time` to `time + step` (s), step > 0. Does not allocate. After a fault the drive is
    /// not used until it is reset or an earlier state is restored.
    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault>;

    /// The instant (s) up to which the present internal step holds the motion, and whether an event happens there. Up to this
    /// instant [`Drive::advance`] only reads the step, and can also go back as far as the communication point of this call. By
    /// default nothing is held.
    fn held(&self) -> Option<(f64, bool)> {
        None
    }

    /// Computes the values of the variables at the communication point, each in the place that its declaration names
    /// ([`super::Variable::at`]).
    fn evaluate(&self, values: &mut [f64]);

    /// What [`Drive::evaluate`] would put in this place, if that costs much less than all of it.
    fn value(&mut self, _place: usize) -> Option<f64> {
        None
    }

    /// The relative tolerance that the importer requested at set-up, 0 for none; never makes the result worse than the documented
    /// default.
    fn request_tolerance(&mut self, tolerance: f64);

    /// Whether the states are finite; checked after each step, so that no other result is returned.
    fn is_finite(&self) -> bool;

    /// Events since the log was last cleared.
    fn events(&mut self) -> &mut EventLog;

    /// Called on a drive that was just read from bytes: rebuilds the parts that the serialisation leaves out, to the same bits, or
    /// takes them from `made`, the drive as made from the scene with the parameters of this one. Refuses states that this drive
    /// cannot have.
    fn restored(&mut self, _made: &Self) -> Result<(), Fault> {
        Ok(())
    }
}
