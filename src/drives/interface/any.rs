//! Drives of any model: an object-safe interface to a model, and everything that all models share.

use super::limits::{check_angle, no_state};
use super::unit;
use super::variable::{Access, Causality, Kind, Type, Variability};
use super::{Description, Drive, EventLog, Experiment, Fault, Number, Seed};
use crate::numerics::difference;
use crate::numerics::taylor::Series;
use crate::numerics::work::Since;
use std::mem::MaybeUninit;
use std::sync::Arc;

/// A place without a value.
const NO_PLACE: usize = usize::MAX;

/// So many Reals may be read without all others being computed.
const FEW: usize = 4;

/// A page keeps no states, and is smaller without the code that reads and writes them.
const IN_BROWSER: bool = cfg!(target_arch = "wasm32");

/// A drive whose type is known only at run time; values of every type travel as `f64`. See [`Drive`] for the rest.
trait DynDrive: Send + Sync {
    fn copy(&self) -> Box<dyn DynDrive>;
    fn experiment(&self) -> Experiment;
    fn input_derivatives(&self) -> usize;
    /// The value of a parameter or an input; None for computed values.
    fn get(&self, reference: usize) -> Option<f64>;
    /// Sets a parameter or an input; leaves computed values alone.
    fn set(&mut self, reference: usize, value: f64);
    /// The Taylor series of a continuous output.
    fn series(&self, reference: usize, seed: Seed) -> Option<Series>;
    fn start(&mut self, time: f64) -> Result<(), Fault>;
    fn apply(&mut self, time: f64) -> Result<(), Fault>;
    /// Advances by a communication step; false if a state is not finite at its end.
    fn advance(&mut self, time: f64, step: f64) -> Result<bool, Fault>;
    fn is_finite(&self) -> bool;
    fn held(&self) -> Option<(f64, bool)>;
    fn evaluate(&self, values: &mut [f64]);
    fn value(&mut self, place: usize) -> Option<f64>;
    fn set_input_derivative(&mut self, reference: usize, order: usize, value: f64);
    fn request_tolerance(&mut self, tolerance: f64);
    fn events(&mut self) -> &mut EventLog;
    fn serialize(&self) -> Option<Vec<u8>>;
    /// A drive of this type from its bytes, and the bytes after them.
    fn deserialize<'a>(&self, bytes: &'a [u8], all: &[Description]) -> Result<(Box<dyn DynDrive>, &'a [u8]), Fault>;
}

/// A drive with the access to its variables: for each the index for its functions, or its place, see [`super::Variable`].
struct Typed<D> {
    drive: D,
    access: Arc<[(usize, Access<D>)]>,
}

impl<D: Drive> DynDrive for Typed<D> {
    fn copy(&self) -> Box<dyn DynDrive> {
        Box::new(Typed { drive: self.drive.clone(), access: self.access.clone() })
    }

    fn experiment(&self) -> Experiment {
        self.drive.experiment()
    }

    fn input_derivatives(&self) -> usize {
        D::INPUT_DERIVATIVES
    }

    fn get(&self, reference: usize) -> Option<f64> {
        let (index, access) = &self.access[reference];
        access.get(&self.drive, *index)
    }

    fn set(&mut self, reference: usize, value: f64) {
        let (index, access) = &self.access[reference];
        access.set(&mut self.drive, *index, value);
    }

    fn series(&self, reference: usize, seed: Seed) -> Option<Series> {
        let (index, Access::Computed { series: Some(series) }) = self.access[reference] else { return None };
        Some(series(&self.drive, seed, index))
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        self.drive.start(time).map_err(Fault::in_one_sentence)
    }

    fn apply(&mut self, time: f64) -> Result<(), Fault> {
        self.drive.apply(time)
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<bool, Fault> {
        check_angle(self.drive.angle(time, time + step), time + step)?;
        self.drive.advance(time, step)?;
        Ok(self.drive.is_finite())
    }

    fn is_finite(&self) -> bool {
        self.drive.is_finite()
    }

    fn held(&self) -> Option<(f64, bool)> {
        self.drive.held()
    }

    fn evaluate(&self, values: &mut [f64]) {
        self.drive.evaluate(values);
    }

    fn value(&mut self, place: usize) -> Option<f64> {
        self.drive.value(place)
    }

    fn set_input_derivative(&mut self, reference: usize, order: usize, value: f64) {
        let (index, access) = &self.access[reference];
        access.set_derivative(&mut self.drive, *index, order, value);
    }

    fn request_tolerance(&mut self, tolerance: f64) {
        self.drive.request_tolerance(tolerance);
    }

    fn events(&mut self) -> &mut EventLog {
        self.drive.events()
    }

    fn serialize(&self) -> Option<Vec<u8>> {
        if IN_BROWSER { None } else { postcard::to_stdvec(&self.drive).ok() }
    }

    fn deserialize<'a>(&self, bytes: &'a [u8], all: &[Description]) -> Result<(Box<dyn DynDrive>, &'a [u8]), Fault> {
        if IN_BROWSER {
            return Err(no_state());
        }
        let (mut drive, rest): (D, _) = postcard::take_from_bytes(bytes).map_err(unreadable)?;
        let mut made = self.drive.clone();
        for ((index, access), description) in self.access.iter().zip(all) {
            let Some(value) = access.get(&drive, *index) else { continue };
            // Values of the scene are not checked again, and values that nobody changes stay shared.
            if access.get(&made, *index) != Some(value) {
                description.check(value)?;
                access.set(&mut made, *index, value);
            }
        }
        drive.restored(&made)?;
        Ok((Box::new(Typed { drive, access: self.access.clone() }), rest))
    }
}

#[cold]
fn unreadable(reason: postcard::Error) -> Fault {
    Fault::new(format!("the serialised state cannot be read: {reason}"))
}

#[cold]
fn not_settable(d: &Description) -> Fault {
    let name = &d.name;
    Fault::new(match d.causality {
        Causality::Parameter => {
            format!("`{name}` is a fixed parameter; it can be set only before initialisation ends")
        }
        _ => format!("`{name}` is computed and cannot be set"),
    })
}

/// A drive as its scene describes it: the part that all its instances share.
pub struct Plan {
    initial: Box<dyn DynDrive>,
    descriptions: Vec<Description>,
    /// For each variable its place among the computed values, [`NO_PLACE`] for parameters and inputs.
    places: Box<[usize]>,
    /// Like `places`, but only for Reals; packed, since importers read at every communication point.
    real_places: Box<[usize]>,
}

impl Plan {
    /// Makes an instance in the state after instantiation.
    pub fn instance(self: Arc<Self>) -> AnyDrive {
        AnyDrive {
            drive: self.initial.copy(),
            values: self.no_values(),
            plan: self,
            initialising: true,
            pending: true,
            evaluated: false,
            time: 0.0,
        }
    }

    /// As many zeros as an instance has computed values.
    fn no_values(&self) -> Box<[f64]> {
        let places = self.places.iter().filter(|place| **place != NO_PLACE);
        vec![0.0; places.max().map_or(0, |last| last + 1)].into()
    }
}

/// An instance of a drive of any model.
///
/// ```
/// use camdrive::drives::elastic_output::{ElasticOutput, Parameters, Scene};
/// use camdrive::drives::follower::load::Load;
/// use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
/// use camdrive::drives::settings::Settings;
/// use camdrive::drives::{AnyDrive, Drive, Fault};
/// use camdrive::motion::{Fourier, MotionLaw};
///
/// # fn main() -> Result<(), Fault> {
/// // 1 kg on 10 kN/m behind a cam with U = 10 mm · sin φ, at 10 rad/s.
/// let scene = Scene {
///     parameters: Parameters { m: 1.0, c: 1e4, b: 0.0 },
///     load: Load::default(),
///     roller: (0.0, Load::default()),
///     coupling: false,
///     cam: MotionLaw::Fourier(Fourier::new(vec![], vec![0.0, 0.01])),
///     drive: DriveMode::Constant { w: 10.0, phi_start: 0.0 },
///     start: Start { mode: StartMode::SteadyState, q: 0.0, q_dot: 0.0 },
///     solver: Settings::default(),
/// };
/// let mut drive = AnyDrive::new(ElasticOutput::new(scene)?);
/// drive.set_up(0.0, None);
/// drive.start()?;
/// drive.advance(0.0, 0.3)?;
/// // Below resonance y = U/(1 - (w/w0)²).
/// let y = drive.descriptions().iter().position(|d| d.name == "y").unwrap();
/// assert!((drive.get(y)? - 0.01 * 3.0_f64.sin() / (1.0 - 0.01)).abs() < 1e-15);
/// # Ok(())
/// # }
/// ```
pub struct AnyDrive {
    drive: Box<dyn DynDrive>,
    plan: Arc<Plan>,
    /// The computed values of the communication point.
    values: Box<[f64]>,
    /// Whether `values` belong to the present state.
    evaluated: bool,
    /// Whether the start values still determine the state.
    initialising: bool,
    /// Whether something was set since the drive last took up its settings.
    pending: bool,
    time: f64,
}

/// A saved state.
pub struct Snapshot {
    drive: Box<dyn DynDrive>,
    initialising: bool,
    pending: bool,
    time: f64,
}

impl AnyDrive {
    /// A drive in the state after instantiation.
    pub fn new<D: Drive>(drive: D) -> Self {
        let (mut descriptions, mut access) = (Vec::new(), Vec::new());
        for v in drive.variables().0 {
            descriptions.push(v.description);
            access.push((v.index, v.access));
        }
        let place = |(index, access): &(usize, Access<D>)| match access {
            Access::Computed { .. } => *index,
            Access::Set { .. } | Access::Input { .. } => NO_PLACE,
        };
        let places: Box<[usize]> = access.iter().map(place).collect();
        let real = |(d, place): (&Description, &usize)| if d.kind.r#type() == Type::Real { *place } else { NO_PLACE };
        let real_places = descriptions.iter().zip(&places).map(real).collect();
        let initial = Box::new(Typed { drive, access: access.into() });
        Arc::new(Plan { initial, descriptions, places, real_places }).instance()
    }

    /// The same for a drive that has already started: further calls continue from there.
    pub fn under_way(mut self) -> Self {
        (self.initialising, self.pending) = (false, false);
        self
    }

    /// The plan shared by all instances of the scene.
    pub fn plan(&self) -> Arc<Plan> {
        self.plan.clone()
    }

    /// The variables, in the order of their value references.
    pub fn descriptions(&self) -> &[Description] {
        &self.plan.descriptions
    }

    /// The default experiment. Importers ask for its tolerance, and the stricter one counts, so a coarser one of the scene is also
    /// the experiment's.
    pub fn experiment(&self) -> Experiment {
        let own = self.plan.descriptions.iter().position(|description| description.name == "solver.tolerance");
        let coarsest = own.and_then(|reference| self.drive.get(reference)).unwrap_or(0.0);
        let experiment = self.drive.experiment();
        Experiment { tolerance: experiment.tolerance.max(coarsest), ..experiment }
    }

    /// Events since the log was last cleared.
    pub fn events(&mut self) -> &mut EventLog {
        self.drive.events()
    }

    /// Takes up the values set since the last call.
    #[inline]
    fn refresh(&mut self) -> Result<(), Fault> {
        if self.pending { self.take_up() } else { Ok(()) }
    }

    #[inline(never)]
    fn take_up(&mut self) -> Result<(), Fault> {
        if self.initialising {
            // The scene's values may be out of range; the importer's have been checked.
            for (reference, description) in self.plan.descriptions.iter().enumerate() {
                self.drive.get(reference).map_or(Ok(()), |value| description.check(value))?;
            }
            self.drive.start(self.time)?;
        } else {
            self.drive.apply(self.time)?;
        }
        self.pending = false;
        Ok(())
    }

    /// Computes the values of the communication point.
    fn evaluate(&mut self) -> Result<(), Fault> {
        self.refresh()?;
        self.drive.evaluate(&mut self.values);
        self.evaluated = true;
        Ok(())
    }

    /// Another value was set.
    fn changed(&mut self) {
        (self.pending, self.evaluated) = (true, false);
    }

    /// Replaces this state by another one. The log, which is not part of the state, stays.
    fn replace(&mut self, mut state: Snapshot) {
        std::mem::swap(state.drive.events(), self.drive.events());
        Snapshot { drive: self.drive, initialising: self.initialising, pending: self.pending, time: self.time } = state;
        self.drive.events().clear();
        self.evaluated = false;
    }

    /// The place in the list of the variable with this reference, which must have this type.
    pub fn variable(&self, reference: u32, r#type: Type) -> Result<usize, Fault> {
        match self.plan.descriptions.get(reference as usize) {
            Some(d) if d.kind.r#type() == r#type => Ok(reference as usize),
            _ => Err(self.no_variable(reference, r#type)),
        }
    }

    #[cold]
    fn no_variable(&self, reference: u32, r#type: Type) -> Fault {
        let all = &self.plan.descriptions;
        Fault::new(match all.get(reference as usize) {
            Some(Description { name, kind, .. }) => {
                format!("`{name}` (value reference {reference}) has the type {:?}, not {type:?}", kind.r#type())
            }
            None => {
                let last = all.len() as i64 - 1;
                format!("the value reference {reference} does not exist; they end at {last}")
            }
        })
    }

    /// Reads Reals, up to date.
    #[inline]
    pub fn read(&mut self, references: &[u32], values: &mut [MaybeUninit<f64>]) -> Result<(), Fault> {
        if self.evaluated {
            let mut finite = 0.0;
            for (reference, place) in references.iter().zip(&mut *values) {
                let known = self.plan.real_places.get(*reference as usize).and_then(|place| self.values.get(*place));
                let Some(value) = known else { return self.read_otherwise(references, values) };
                // Zero unless the value is infinite or NaN.
                finite += 0.0 * value;
                place.write(*value);
            }
            if finite == 0.0 {
                return Ok(());
            }
        }
        self.read_otherwise(references, values)
    }

    /// Handles the first reading at a communication point, and Reals of which one is set instead of computed, unknown, or not
    /// finite.
    #[inline(never)]
    fn read_otherwise(&mut self, references: &[u32], values: &mut [MaybeUninit<f64>]) -> Result<(), Fault> {
        if !(self.evaluated || self.pending) {
            if references.len() <= FEW && self.read_alone(references, values) {
                return Ok(());
            }
            self.evaluate()?;
            return self.read(references, values);
        }
        for (reference, place) in references.iter().zip(values) {
            place.write(self.get(self.variable(*reference, Type::Real)?)?);
        }
        Ok(())
    }

    /// Reads a few computed Reals without the others; false if one cannot be, or is no number.
    fn read_alone(&mut self, references: &[u32], values: &mut [MaybeUninit<f64>]) -> bool {
        references.iter().zip(values).all(|(reference, into)| {
            let place = self.plan.real_places.get(*reference as usize).copied();
            place.and_then(|place| self.drive.value(place)).is_some_and(|value| into.write(value).is_finite())
        })
    }

    /// Reads a variable, up to date.
    pub fn get(&mut self, reference: usize) -> Result<f64, Fault> {
        let value = match self.drive.get(reference) {
            Some(value) => value,
            None => {
                if !self.evaluated {
                    self.evaluate()?;
                }
                self.values[self.plan.places[reference]]
            }
        };
        if value.is_finite() {
            Ok(value)
        } else {
            let name = &self.plan.descriptions[reference].name;
            Err(Fault::new(format!("`{name}` is not a finite number at t = {} s", Number(self.time))))
        }
    }

    /// Refuses what [`AnyDrive::set`] would refuse.
    pub fn check(&self, reference: usize, value: f64) -> Result<(), Fault> {
        let d = &self.plan.descriptions[reference];
        let fixed = d.causality == Causality::Parameter && d.variability == Variability::Fixed && !self.initialising;
        if fixed || self.plan.places[reference] != NO_PLACE { Err(not_settable(d)) } else { d.check(value) }
    }

    /// Sets a parameter or an input; refuses a value outside the variable's range.
    pub fn set(&mut self, reference: usize, value: f64) -> Result<(), Fault> {
        self.check(reference, value)?;
        self.drive.set(reference, value);
        self.changed();
        Ok(())
    }

    /// Sets variables of one type: all of them, or none if one is refused.
    pub fn write(&mut self, r#type: Type, references: &[u32], values: &[f64]) -> Result<(), Fault> {
        for (reference, value) in references.iter().zip(values) {
            self.check(self.variable(*reference, r#type)?, *value)?;
        }
        for (reference, value) in references.iter().zip(values) {
            self.drive.set(*reference as usize, *value);
        }
        self.changed();
        Ok(())
    }

    /// Starts initialisation at `time` (s).
    pub fn set_up(&mut self, time: f64, tolerance: Option<f64>) {
        self.time = time;
        self.drive.request_tolerance(tolerance.unwrap_or(0.0));
        self.changed();
    }

    /// Ends initialisation.
    pub fn start(&mut self) -> Result<(), Fault> {
        self.refresh()?;
        if !self.drive.is_finite() {
            return Err(self.not_finite());
        }
        self.initialising = false;
        Ok(())
    }

    /// Advances by a communication step.
    #[inline]
    pub fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        self.time = time;
        self.evaluated = false;
        self.refresh()?;
        let finite = self.drive.advance(time, step)?;
        self.time = time + step;
        if finite { Ok(()) } else { Err(self.not_finite()) }
    }

    /// The instant (s) up to which the motion is held, see [`Drive::held`].
    pub fn held(&self) -> Option<(f64, bool)> {
        self.drive.held()
    }

    /// Names the state that is not finite.
    #[cold]
    fn not_finite(&mut self) -> Fault {
        self.drive.evaluate(&mut self.values);
        let all = self.plan.descriptions.iter().zip(&self.plan.places);
        let lost = all.filter(|(d, _)| d.state).find(|(_, place)| !self.values[**place].is_finite());
        let name = lost.map_or("the state", |(d, _)| &d.name);
        Fault::new(format!("`{name}` is not a finite number at t = {} s", Number(self.time)))
    }

    /// The highest order of input derivatives.
    pub fn input_derivative_order(&self) -> usize {
        let has_inputs = self.plan.descriptions.iter().any(|d| d.causality == Causality::Input);
        if has_inputs { self.drive.input_derivatives() } else { 0 }
    }

    /// Refuses what [`AnyDrive::set_input_derivative`] would refuse.
    pub fn check_input_derivative(&self, reference: usize, order: usize, value: f64) -> Result<(), Fault> {
        let (d, highest) = (&self.plan.descriptions[reference], self.drive.input_derivatives());
        if d.causality != Causality::Input {
            return Err(Fault::new(format!("`{}` is not an input; only inputs have input derivatives", d.name)));
        }
        if !(1..=highest).contains(&order) {
            return Err(Fault::new(format!(
                "`{}`: the order {order} of its derivative is not from 1 to {highest}",
                d.name
            )));
        }
        if !value.is_finite() {
            return Err(Fault::new(format!(
                "`{}`: its derivative of order {order} is {value}, not a finite number",
                d.name
            )));
        }
        Ok(())
    }

    /// Sets an input derivative for the next step.
    pub fn set_input_derivative(&mut self, reference: usize, order: usize, value: f64) -> Result<(), Fault> {
        self.check_input_derivative(reference, order, value)?;
        self.drive.set_input_derivative(reference, order, value);
        // Derivatives of outputs depend on it.
        self.changed();
        Ok(())
    }

    /// The time derivative of an output; order 1 or 2.
    pub fn output_derivative(&mut self, reference: usize, order: usize) -> Result<f64, Fault> {
        if !(1..=2).contains(&order) {
            return Err(Fault::new(format!("output derivatives of order {order} do not exist; the order is 1 or 2")));
        }
        self.refresh()?;
        self.derivative(reference, Seed::Time, order)
    }

    /// The value of a continuous output with its first and second time derivative.
    pub fn jet(&mut self, reference: usize) -> Result<[f64; 3], Fault> {
        self.refresh()?;
        let Some(series) = self.drive.series(reference, Seed::Time) else {
            return self.derivative(reference, Seed::Time, 1).map(|_| [0.0; 3]);
        };
        let jet = series.derivatives();
        if jet.iter().all(|value| value.is_finite()) { Ok(jet) } else { Err(self.no_derivative(reference)) }
    }

    /// Σ ∂unknown/∂known · component over a direction at the communication point, for each unknown; during initialisation the
    /// derivatives of the start values.
    pub fn directional_derivatives(
        &mut self,
        unknowns: &[usize],
        direction: &[(usize, f64)],
    ) -> Result<Vec<f64>, Fault> {
        self.refresh()?;
        let all = &self.plan.descriptions;
        if let Some((known, component)) = direction.iter().find(|(_, component)| !component.is_finite()) {
            let name = &all[*known].name;
            return Err(Fault::new(format!(
                "the component {component} of the direction for `{name}` is not a finite number"
            )));
        }
        // Hosts request a column of the Jacobian by a direction of all knowns.
        let direction: Vec<(usize, f64)> =
            direction.iter().copied().filter(|(_, component)| *component != 0.0).collect();
        let values = if self.initialising {
            self.initial_derivatives(unknowns, &direction)?
        } else {
            let along = |unknown: &usize| {
                direction.iter().try_fold(0.0, |sum, (known, component)| {
                    Ok(sum + self.derivative(*unknown, Seed::Known(&all[*known].name), 1)? * component)
                })
            };
            unknowns.iter().map(along).collect::<Result<_, _>>()?
        };
        match unknowns.iter().zip(&values).find(|(_, value)| !value.is_finite()) {
            Some((unknown, _)) => Err(self.no_derivative(*unknown)),
            None => Ok(values),
        }
    }

    /// The derivative of an output; order 1 or 2.
    fn derivative(&self, reference: usize, seed: Seed, order: usize) -> Result<f64, Fault> {
        let is_known = |d: &&Description| d.state || d.causality == Causality::Input;
        if let Seed::Known(name) = seed
            && !self.plan.descriptions.iter().filter(is_known).any(|d| d.name == name)
        {
            return Err(Fault::new(format!(
                "`{name}` is neither an input nor a state; there is no derivative with respect to it"
            )));
        }
        let Description { name, causality, variability, dependencies, .. } = &self.plan.descriptions[reference];
        let value = match self.drive.series(reference, seed) {
            Some(series) => series.derivative(order),
            // Discrete values stand still between events, and hosts request the slope of every output.
            None if *causality == Causality::Output
                && *variability == Variability::Discrete
                && (seed == Seed::Time || dependencies.is_empty()) =>
            {
                0.0
            }
            None => return Err(Fault::new(format!("`{name}` is not a continuous output; it has no derivatives"))),
        };
        if value.is_finite() { Ok(value) } else { Err(self.no_derivative(reference)) }
    }

    #[cold]
    fn no_derivative(&self, reference: usize) -> Fault {
        let name = &self.plan.descriptions[reference].name;
        Fault::new(format!("a derivative of `{name}` is not a finite number at t = {} s", Number(self.time)))
    }

    /// [`AnyDrive::directional_derivatives`] of the start values: the sum of the columns, each computed by itself, so that none
    /// depends on the rest of the request.
    fn initial_derivatives(&self, unknowns: &[usize], direction: &[(usize, f64)]) -> Result<Vec<f64>, Fault> {
        let (begin, mut sums) = (Since::now(), vec![0.0; unknowns.len()]);
        for &(known, component) in direction {
            let column = self.initial_column(unknowns, known, &begin)?;
            sums.iter_mut().zip(column).for_each(|(sum, slope)| *sum += slope * component);
        }
        Ok(sums)
    }

    /// ∂unknown/∂known of the start values, in which the states follow from inputs and parameters (y = U(phi) + start.q). They are
    /// found from differences on copies, since a start may be the result of an iteration. The unknowns share the starts, but calls
    /// do not: the work of a call must not depend on earlier calls.
    fn initial_column(&self, unknowns: &[usize], known: usize, begin: &Since) -> Result<Vec<f64>, Fault> {
        let (plan, drive, d) = (&self.plan, &self.drive, &self.plan.descriptions[known]);
        let (Some(centre), Kind::Real { quantity, min, max, .. }) = (drive.get(known), &d.kind) else {
            return Err(Fault::new(format!(
                "`{}` follows from inputs and parameters before the start; derivatives exist for those",
                d.name
            )));
        };
        // A law repeats itself every turn however large the angle; other quantities are scaled by themselves unless they are almost
        // zero.
        let usual = quantity.usual();
        let size = if **quantity == unit::ANGLE {
            1.0
        } else if centre.abs() > 1e-6 * usual {
            centre.abs()
        } else {
            usual
        };
        let values_at = |place: f64| -> Result<Box<[f64]>, Fault> {
            let mut drive = drive.copy();
            drive.set(known, place);
            drive.start(self.time)?;
            let mut values = plan.no_values();
            drive.evaluate(&mut values);
            Ok(values)
        };
        let mut trials: Vec<(f64, Result<Box<[f64]>, Fault>)> = Vec::new();
        let mut derivative = |unknown: &usize| {
            let (name, place) = (&plan.descriptions[*unknown].name, plan.places[*unknown]);
            if place == NO_PLACE {
                return Err(Fault::new(format!("`{name}` is set, not computed; it has no derivatives")));
            }
            let too_much = || {
                Fault::new(format!(
                    "the derivative of `{name}` before the start needs more work than one call may take, since each of its trial \
                     starts needs much; ask for one known at a time, or take differences of whole runs"
                ))
            };
            let value_at = |value: f64| {
                let done = trials.iter().position(|(at, _)| *at == value).unwrap_or_else(|| {
                    trials.push((value, if begin.is_exhausted() { Err(too_much()) } else { values_at(value) }));
                    trials.len() - 1
                });
                trials[done].1.as_ref().map(|values| values[place]).map_err(Fault::clone)
            };
            let slope = difference::derivative(value_at, centre, 0.02 * size, [*min, *max])?;
            if begin.is_exhausted() { Err(too_much()) } else { Ok(slope) }
        };
        unknowns.iter().map(&mut derivative).collect()
    }

    /// Returns to the state after instantiation, with the scene's parameters.
    pub fn reset(&mut self) {
        self.replace(Snapshot { drive: self.plan.initial.copy(), initialising: true, pending: true, time: 0.0 });
    }

    /// A copy of the whole state.
    pub fn save(&self) -> Snapshot {
        let &AnyDrive { ref drive, initialising, pending, time, .. } = self;
        Snapshot { drive: drive.copy(), initialising, pending, time }
    }

    /// Restores a copy that a drive of the same scene made.
    pub fn restore(&mut self, state: &Snapshot) {
        let &Snapshot { ref drive, initialising, pending, time } = state;
        self.replace(Snapshot { drive: drive.copy(), initialising, pending, time });
    }

    /// A saved state from its bytes.
    pub fn deserialize(&self, bytes: &[u8]) -> Result<Snapshot, Fault> {
        let Plan { initial, descriptions, .. } = &*self.plan;
        let (drive, rest) = initial.deserialize(bytes, descriptions)?;
        let ((initialising, pending, time), rest): ((bool, bool, f64), &[u8]) =
            postcard::take_from_bytes(rest).map_err(unreadable)?;
        if !rest.is_empty() {
            return Err(Fault::new("the serialised state is longer than it should be"));
        }
        if !drive.is_finite() || !time.is_finite() {
            return Err(no_state());
        }
        Ok(Snapshot { drive, initialising, pending, time })
    }
}

impl Snapshot {
    /// The bytes of the state; None if they cannot be written.
    pub fn serialize(&self) -> Option<Vec<u8>> {
        let mut bytes = self.drive.serialize()?;
        bytes.extend(postcard::to_stdvec(&(self.initialising, self.pending, self.time)).ok()?);
        Some(bytes)
    }
}
