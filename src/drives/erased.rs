//! Drives of any model behind one object-safe interface.

use super::limits::{check_angle, no_state};
use super::unit;
use super::variable::{Access, Causality, Kind, Type, Variability};
use super::{Description, Drive, EventLog, Experiment, Fault, Number, Seed, Variable};
use crate::numerics::difference;
use crate::numerics::work::Since;
use std::any::Any;
use std::mem::MaybeUninit;
use std::sync::Arc;

/// A drive as it is after instantiation.
pub fn unit<D: Drive>(drive: D) -> Box<Unit<D>> {
    let variables = drive.variables();
    let places = variables.places();
    let real_place = |v: &Variable<D>| match v.access {
        Access::Computed { .. } if v.description.kind.r#type() == Type::Real => v.index,
        _ => NO_PLACE,
    };
    let real_places = variables.0.iter().map(real_place).collect();
    Arc::new(Design { initial: drive, variables: variables.0, real_places, places }).unit()
}

/// A place that no value has.
const NO_PLACE: usize = usize::MAX;

/// A drive as its scene describes it: what all its instances have in common.
pub trait Plan: Send + Sync {
    /// A further instance, as it is after instantiation.
    fn instance(self: Arc<Self>) -> Box<dyn DynDrive>;
}

/// A drive whose model is known only at run time. Values of every type travel as `f64`.
pub trait DynDrive: Send {
    /// The plan of this drive.
    fn plan(&self) -> Arc<dyn Plan>;
    /// The variables, in the order of their value references.
    fn descriptions(&self) -> Vec<&Description>;
    /// The variable with this reference.
    fn description(&self, reference: usize) -> Option<&Description>;
    /// The default experiment.
    fn experiment(&self) -> Experiment;
    /// The place in the list of the variable with this reference, which has to be of this type.
    fn variable(&self, reference: u32, r#type: Type) -> Result<usize, Fault>;
    /// Reads Reals, up to date.
    fn read(&mut self, references: &[u32], values: &mut [MaybeUninit<f64>]) -> Result<(), Fault>;
    /// Reads a variable, up to date.
    fn get(&mut self, reference: usize) -> Result<f64, Fault>;
    /// Refuses what [`DynDrive::set`] would refuse.
    fn check(&self, reference: usize, value: f64) -> Result<(), Fault>;
    /// Sets a parameter or an input; refuses a value outside the variable's range.
    fn set(&mut self, reference: usize, value: f64) -> Result<(), Fault>;
    /// Sets variables of one type: all of them, or, where one is refused, none.
    fn write(&mut self, r#type: Type, references: &[u32], values: &[f64]) -> Result<(), Fault>;
    /// Initialisation starts at `time` (s).
    fn set_up(&mut self, time: f64, tolerance: Option<f64>);
    /// Ends initialisation.
    fn start(&mut self) -> Result<(), Fault>;
    /// Advances by a communication step.
    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault>;
    /// The highest order of input derivatives.
    fn input_derivative_order(&self) -> usize;
    /// Refuses what [`DynDrive::set_input_derivative`] would refuse.
    fn check_input_derivative(&self, reference: usize, order: usize, value: f64) -> Result<(), Fault>;
    /// Sets an input derivative for the next step.
    fn set_input_derivative(&mut self, reference: usize, order: usize, value: f64) -> Result<(), Fault>;
    /// The time derivative of an output; order 1 or 2.
    fn output_derivative(&mut self, reference: usize, order: usize) -> Result<f64, Fault>;
    /// ∂unknown/∂known at the communication point; during initialisation that of the start value.
    fn directional_derivative(&mut self, unknown: usize, known: usize) -> Result<f64, Fault>;
    /// Back to the state after instantiation, with the parameters of the scene.
    fn reset(&mut self);
    /// A copy of the whole state.
    fn save(&self) -> Box<dyn Any + Send>;
    /// Restores a copy that [`DynDrive::save`] made; false where it is of another model.
    fn restore(&mut self, state: &dyn Any) -> bool;
    /// The bytes of a saved state; None where it is of another model.
    fn serialize(&self, state: &dyn Any) -> Option<Vec<u8>>;
    /// A saved state from its bytes.
    fn deserialize(&self, bytes: &[u8]) -> Result<Box<dyn Any + Send>, Fault>;
    /// What happened since the log was last cleared.
    fn events(&mut self) -> &mut EventLog;
}

/// The plan of a drive of the type `D`.
struct Design<D> {
    initial: D,
    variables: Vec<Variable<D>>,
    /// For each variable its place among the computed values, [`NO_PLACE`] of what is no computed Real: close together, since
    /// importers read at every communication point.
    real_places: Box<[usize]>,
    /// As many zeros as an instance has computed values.
    places: Box<[f64]>,
}

impl<D: Drive> Design<D> {
    fn unit(self: Arc<Self>) -> Box<Unit<D>> {
        Box::new(Unit {
            drive: self.initial.clone(),
            values: self.places.clone(),
            design: self,
            initialising: true,
            pending: true,
            evaluated: false,
            time: 0.0,
            trials: Vec::new(),
        })
    }
}

impl<D: Drive> Plan for Design<D> {
    fn instance(self: Arc<Self>) -> Box<dyn DynDrive> {
        self.unit()
    }
}

/// An instance.
pub struct Unit<D> {
    drive: D,
    design: Arc<Design<D>>,
    /// The computed values of the communication point.
    values: Box<[f64]>,
    /// Whether they are those of the present state.
    evaluated: bool,
    /// Whether the start values still decide the state.
    initialising: bool,
    /// Whether something was set since the drive last took up its settings.
    pending: bool,
    time: f64,
    /// Starts of copies for derivatives before the start, which all unknowns share: a known, its value, and what was computed.
    trials: Vec<(usize, f64, Result<Box<[f64]>, Fault>)>,
}

/// A saved state.
#[derive(Clone, serde::Serialize, serde::Deserialize)]
struct Snapshot<D> {
    drive: D,
    initialising: bool,
    pending: bool,
    time: f64,
}

impl<D: Drive> Unit<D> {
    /// The drive.
    pub fn drive(&self) -> &D {
        &self.drive
    }

    /// Takes up what was set.
    #[inline(always)]
    fn refresh(&mut self) -> Result<(), Fault> {
        if self.pending { self.take_up() } else { Ok(()) }
    }

    #[inline(never)]
    fn take_up(&mut self) -> Result<(), Fault> {
        if self.initialising {
            // What the scene says may be out of range; what importers set has been looked at.
            self.design.variables.iter().try_for_each(|v| match v.access {
                Access::Set { get, .. } => v.description.check(get(&self.drive, v.index)),
                Access::Computed { .. } => Ok(()),
            })?;
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

    /// Sets what may be set to an admissible value.
    fn put(&mut self, reference: usize, value: f64) {
        let v = &self.design.variables[reference];
        if let Access::Set { set, .. } = v.access {
            set(&mut self.drive, v.index, value);
            self.changed();
        }
    }

    /// Something else was set.
    fn changed(&mut self) {
        (self.pending, self.evaluated) = (true, false);
        self.trials.clear();
    }

    /// Puts another drive in the place of this one. The log, which is no part of the state, stays.
    fn replace(&mut self, mut drive: D) {
        std::mem::swap(drive.events(), self.drive.events());
        (self.drive, self.evaluated) = (drive, false);
        self.trials.clear();
        self.drive.events().clear();
    }

    /// The derivative of an output; order 1 or 2.
    fn derivative(&mut self, reference: usize, seed: Seed, order: usize) -> Result<f64, Fault> {
        self.refresh()?;
        let v = &self.design.variables[reference];
        let Description { name, causality, variability, dependencies, .. } = &v.description;
        let value = match v.access {
            Access::Computed { series: Some(series) } => series(&self.drive, seed, v.index).derivative(order),
            // What changes at events only stands still between them, and hosts ask for the slope of every output.
            _ if *causality == Causality::Output
                && *variability == Variability::Discrete
                && (seed == Seed::Time || dependencies.is_empty()) =>
            {
                0.0
            }
            _ => return Err(Fault::new(format!("`{name}` is not a continuous output; it has no derivatives"))),
        };
        if value.is_finite() {
            Ok(value)
        } else {
            Err(Fault::new(format!("a derivative of `{name}` is not a finite number at t = {} s", Number(self.time))))
        }
    }

    /// ∂unknown/∂known of the start values, in which the states follow from inputs and parameters (y = U(phi) + start.q), by
    /// differences on copies, since a start may be the result of an iteration.
    fn initial_derivative(&mut self, unknown: usize, known: usize) -> Result<f64, Fault> {
        let design = self.design.clone();
        let (u, k) = (&design.variables[unknown], &design.variables[known]);
        let (Access::Set { set, .. }, Kind::Real { quantity, min, max, .. }) = (&k.access, &k.description.kind) else {
            return Err(Fault::new(format!(
                "`{}` follows from inputs and parameters before the start; derivatives exist for those",
                k.description.name
            )));
        };
        if matches!(u.access, Access::Set { .. }) {
            return Err(Fault::new(format!("`{}` is set, not computed; it has no derivatives", u.description.name)));
        }
        let centre = k.value(&self.drive);
        let (drive, time, trials) = (&self.drive, self.time, &mut self.trials);
        let begin = Since::now();
        let too_much = || {
            let (u, k) = (&u.description.name, &k.description.name);
            Fault::new(format!(
                "the derivative of `{u}` with respect to `{k}` before the start needs more than the work of one call, since \
                 each of its trial starts needs much of it; take differences of whole runs"
            ))
        };
        let values_at = |value: f64| -> Result<Box<[f64]>, Fault> {
            if begin.is_exhausted() {
                return Err(too_much());
            }
            let mut drive = drive.clone();
            set(&mut drive, k.index, value);
            drive.start(time)?;
            let mut values = design.places.clone();
            drive.evaluate(&mut values);
            Ok(values)
        };
        let value_at = |value: f64| {
            let done = trials.iter().position(|(of, at, _)| (*of, *at) == (known, value));
            let done = done.unwrap_or_else(|| {
                trials.push((known, value, values_at(value)));
                trials.len() - 1
            });
            trials[done].2.as_ref().map(|values| values[u.index]).map_err(Fault::clone)
        };
        // A law repeats itself every turn however large the angle; other quantities are scaled by themselves, unless they
        // are next to nothing.
        let usual = quantity.usual();
        let size = if **quantity == unit::ANGLE {
            1.0
        } else if centre.abs() > 1e-6 * usual {
            centre.abs()
        } else {
            usual
        };
        let slope = difference::derivative(value_at, centre, 0.02 * size, [*min, *max])?;
        if begin.is_exhausted() {
            return Err(too_much());
        }
        if slope.is_finite() {
            Ok(slope)
        } else {
            let (u, k) = (&u.description.name, &k.description.name);
            Err(Fault::new(format!(
                "the derivative of `{u}` with respect to `{k}` is not a finite number before the start"
            )))
        }
    }

    #[cold]
    fn no_variable(&self, reference: u32, r#type: Type) -> Fault {
        let variables = &self.design.variables;
        Fault::new(match variables.get(reference as usize) {
            Some(Variable { description: Description { name, kind, .. }, .. }) => {
                format!("`{name}` (value reference {reference}) has the type {:?}, not {type:?}", kind.r#type())
            }
            None => {
                let last = variables.len() as i64 - 1;
                format!("the value reference {reference} does not exist; they end at {last}")
            }
        })
    }

    /// Reads Reals of which one is set, not computed, or does not exist, or is no number.
    #[cold]
    fn read_others(&mut self, references: &[u32], values: &mut [MaybeUninit<f64>]) -> Result<(), Fault> {
        for (reference, place) in references.iter().zip(values) {
            place.write(self.get(self.variable(*reference, Type::Real)?)?);
        }
        Ok(())
    }

    /// Which state is no number.
    #[cold]
    fn not_finite(&self) -> Fault {
        let states = self.design.variables.iter().filter(|v| v.description.state);
        let lost = states.map(|v| (&v.description.name, v.value(&self.drive))).find(|(_, x)| !x.is_finite());
        let name = lost.map_or("the state", |(name, _)| name);
        Fault::new(format!("`{name}` is not a finite number at t = {} s", Number(self.time)))
    }
}

impl<D: Drive> DynDrive for Unit<D> {
    fn plan(&self) -> Arc<dyn Plan> {
        self.design.clone()
    }

    fn descriptions(&self) -> Vec<&Description> {
        self.design.variables.iter().map(|v| &v.description).collect()
    }

    fn description(&self, reference: usize) -> Option<&Description> {
        self.design.variables.get(reference).map(|v| &v.description)
    }

    fn experiment(&self) -> Experiment {
        self.drive.experiment()
    }

    fn variable(&self, reference: u32, r#type: Type) -> Result<usize, Fault> {
        match self.design.variables.get(reference as usize) {
            Some(v) if v.description.kind.r#type() == r#type => Ok(reference as usize),
            _ => Err(self.no_variable(reference, r#type)),
        }
    }

    fn read(&mut self, references: &[u32], values: &mut [MaybeUninit<f64>]) -> Result<(), Fault> {
        if !self.evaluated && !self.pending {
            self.evaluate()?;
        }
        let computed: &[f64] = if self.evaluated { &self.values } else { &[] };
        let mut finite = 0.0;
        for (reference, place) in references.iter().zip(&mut *values) {
            let known = self.design.real_places.get(*reference as usize).and_then(|place| computed.get(*place));
            let Some(value) = known else { return self.read_others(references, values) };
            // Zero, unless the value is no finite number.
            finite += 0.0 * value;
            place.write(*value);
        }
        if finite == 0.0 { Ok(()) } else { self.read_others(references, values) }
    }

    fn get(&mut self, reference: usize) -> Result<f64, Fault> {
        let &Variable { index, ref access, .. } = &self.design.variables[reference];
        let value = match *access {
            Access::Set { get, .. } => get(&self.drive, index),
            Access::Computed { .. } => {
                if !self.evaluated {
                    self.evaluate()?;
                }
                self.values[index]
            }
        };
        if value.is_finite() {
            Ok(value)
        } else {
            let name = &self.design.variables[reference].description.name;
            Err(Fault::new(format!("`{name}` is not a finite number at t = {} s", Number(self.time))))
        }
    }

    fn check(&self, reference: usize, value: f64) -> Result<(), Fault> {
        let v = &self.design.variables[reference];
        let d = &v.description;
        if matches!(v.access, Access::Computed { .. }) {
            return Err(Fault::new(format!("`{}` is computed and cannot be set", d.name)));
        }
        if d.causality == Causality::Parameter && d.variability == Variability::Fixed && !self.initialising {
            return Err(Fault::new(format!(
                "`{}` is a fixed parameter; it can be set only before initialisation ends",
                d.name
            )));
        }
        d.check(value)
    }

    fn set(&mut self, reference: usize, value: f64) -> Result<(), Fault> {
        self.check(reference, value)?;
        self.put(reference, value);
        Ok(())
    }

    fn write(&mut self, r#type: Type, references: &[u32], values: &[f64]) -> Result<(), Fault> {
        for (reference, value) in references.iter().zip(values) {
            self.check(self.variable(*reference, r#type)?, *value)?;
        }
        for (reference, value) in references.iter().zip(values) {
            self.put(*reference as usize, *value);
        }
        Ok(())
    }

    fn set_up(&mut self, time: f64, tolerance: Option<f64>) {
        self.time = time;
        self.drive.request_tolerance(tolerance.unwrap_or(0.0));
        self.changed();
    }

    fn start(&mut self) -> Result<(), Fault> {
        self.refresh()?;
        if !self.drive.is_finite() {
            return Err(self.not_finite());
        }
        self.initialising = false;
        self.trials = Vec::new();
        Ok(())
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        self.time = time;
        self.evaluated = false;
        self.refresh()?;
        check_angle(self.drive.angle(time, time + step), time + step)?;
        self.drive.advance(time, step)?;
        self.time = time + step;
        if self.drive.is_finite() { Ok(()) } else { Err(self.not_finite()) }
    }

    fn input_derivative_order(&self) -> usize {
        let has_inputs = self.design.variables.iter().any(|v| v.description.causality == Causality::Input);
        if has_inputs { D::INPUT_DERIVATIVES } else { 0 }
    }

    fn check_input_derivative(&self, reference: usize, order: usize, value: f64) -> Result<(), Fault> {
        let d = &self.design.variables[reference].description;
        if d.causality != Causality::Input {
            return Err(Fault::new(format!("`{}` is no input; only inputs have input derivatives", d.name)));
        }
        if !(1..=D::INPUT_DERIVATIVES).contains(&order) {
            return Err(Fault::new(format!(
                "`{}`: the order {order} of its derivative is outside 1 … {}",
                d.name,
                D::INPUT_DERIVATIVES
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

    fn set_input_derivative(&mut self, reference: usize, order: usize, value: f64) -> Result<(), Fault> {
        self.check_input_derivative(reference, order, value)?;
        self.drive.set_input_derivative(reference, order, value);
        // Derivatives of outputs depend on it.
        self.changed();
        Ok(())
    }

    fn output_derivative(&mut self, reference: usize, order: usize) -> Result<f64, Fault> {
        if !(1..=2).contains(&order) {
            return Err(Fault::new(format!("output derivatives of order {order} do not exist; the order is 1 or 2")));
        }
        self.derivative(reference, Seed::Time, order)
    }

    fn directional_derivative(&mut self, unknown: usize, known: usize) -> Result<f64, Fault> {
        if self.initialising {
            return self.initial_derivative(unknown, known);
        }
        let d = &self.design.variables[known].description;
        if d.causality != Causality::Input && !d.state {
            return Err(Fault::new(format!(
                "`{}` is neither an input nor a state; there is no derivative with respect to it",
                d.name
            )));
        }
        self.derivative(unknown, Seed::Known(known), 1)
    }

    fn reset(&mut self) {
        self.replace(self.design.initial.clone());
        (self.initialising, self.pending, self.time) = (true, true, 0.0);
    }

    fn save(&self) -> Box<dyn Any + Send> {
        Box::new(Snapshot {
            drive: self.drive.clone(),
            initialising: self.initialising,
            pending: self.pending,
            time: self.time,
        })
    }

    fn restore(&mut self, state: &dyn Any) -> bool {
        let Some(s) = state.downcast_ref::<Snapshot<D>>() else { return false };
        let s = s.clone();
        self.replace(s.drive);
        (self.initialising, self.pending, self.time) = (s.initialising, s.pending, s.time);
        true
    }

    fn serialize(&self, state: &dyn Any) -> Option<Vec<u8>> {
        postcard::to_stdvec(state.downcast_ref::<Snapshot<D>>()?).ok()
    }

    fn deserialize(&self, bytes: &[u8]) -> Result<Box<dyn Any + Send>, Fault> {
        let (mut state, rest): (Snapshot<D>, &[u8]) = postcard::take_from_bytes(bytes)
            .map_err(|e| Fault::new(format!("the serialised state cannot be read: {e}")))?;
        if !rest.is_empty() {
            return Err(Fault::new("the serialised state is longer than it should be"));
        }
        let mut made = self.design.initial.clone();
        for v in &self.design.variables {
            let Access::Set { get, set } = v.access else { continue };
            let value = get(&state.drive, v.index);
            // What the scene itself says is not looked at again, and what nobody changes stays shared.
            if value != get(&made, v.index) {
                v.description.check(value)?;
                set(&mut made, v.index, value);
            }
        }
        state.drive.restored(&made)?;
        if state.drive.is_finite() && state.time.is_finite() { Ok(Box::new(state)) } else { Err(no_state()) }
    }

    fn events(&mut self) -> &mut EventLog {
        self.drive.events()
    }
}
