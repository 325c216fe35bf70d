//! Drives of any model behind one object-safe interface.

mod access;

use super::limits::{INPUTS, LARGEST_ANGLE, check_angle, no_state};
use super::unit;
use super::variable::{Causality, Kind, Variability};
use super::{Board, Description, Drive, EventLog, Experiment, Fault, Seed, Variable};
use crate::numerics::difference;
pub use access::Set;
use access::{Access, Input, Pending};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// A drive as it is after instantiation.
pub fn unit<D: Drive>(drive: D) -> Box<Unit<D>> {
    let variables = drive.variables().0;
    let reals = variables.iter().map(Access::of).collect();
    let inputs = variables.iter().map_while(Input::of).collect();
    Arc::new(Design { initial: drive, variables, reals, inputs }).unit()
}

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
    /// Reads a Real where it stands. NaN where there is none to read: an unknown reference, another type, or something
    /// was set that the drive has to take up first; [`DynDrive::get`] does so, or tells what is wrong.
    fn peek(&self, reference: u32) -> f64;
    /// Reads a variable, up to date.
    fn get(&mut self, reference: usize) -> Result<f64, Fault>;
    /// Sets inputs of the type Real, all of them; false, and nothing is set, where one of them takes a closer look. No panic
    /// leaves it.
    extern "C" fn put(&mut self, set: &Set) -> bool;
    /// Refuses what [`DynDrive::set`] would refuse.
    fn check(&self, reference: usize, value: f64) -> Result<(), Fault>;
    /// Sets a parameter or an input; refuses a value outside the variable's range.
    fn set(&mut self, reference: usize, value: f64) -> Result<(), Fault>;
    /// Initialisation starts at `time` [s].
    fn set_up(&mut self, time: f64, tolerance: Option<f64>);
    /// Ends initialisation.
    fn start(&mut self) -> Result<(), Fault>;
    /// The place for the outputs that [`DynDrive::glide`] shows.
    fn board(&self) -> Board;
    /// [`Drive::glide`]. No panic leaves it, which the ABI tells the caller: it appears in [`DynDrive::advance`].
    extern "C" fn glide(&mut self, time: f64, end: f64, board: &mut Board) -> bool;
    /// [`Drive::show`].
    fn show(&self, board: &mut Board);
    /// Advances by a communication step; how many events the log has. (A boxed fault lets the outcome pass in registers.)
    fn advance(&mut self, time: f64, step: f64) -> Result<usize, Box<Fault>>;
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
    /// How each variable is read as a Real, by its reference.
    reals: Arc<[Access<D>]>,
    /// The inputs with which the list begins.
    inputs: Vec<Input<D>>,
}

impl<D: Drive> Design<D> {
    fn unit(self: Arc<Self>) -> Box<Unit<D>> {
        Box::new(Unit {
            drive: self.initial.clone(),
            reals: self.reals.clone(),
            design: self,
            initialising: true,
            pending: Pending::Settings,
            time: 0.0,
            broken: false,
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
    /// Of the design, where reading finds it sooner.
    reals: Arc<[Access<D>]>,
    /// Whether the start values still decide the state.
    initialising: bool,
    /// What was set since the drive last took up its settings.
    pending: Pending,
    time: f64,
    /// Whether a panic left [`DynDrive::glide`] half-way; resetting and restoring mend it.
    broken: bool,
}

/// A saved state.
#[derive(Clone, serde::Serialize, serde::Deserialize)]
struct Snapshot<D> {
    drive: D,
    initialising: bool,
    pending: Pending,
    time: f64,
}

impl<D: Drive> Unit<D> {
    /// The drive.
    pub fn drive(&self) -> &D {
        &self.drive
    }

    /// Takes up what was set.
    fn refresh(&mut self) -> Result<(), Fault> {
        if self.pending != Pending::Nothing {
            if self.initialising {
                self.drive.start(self.time)?;
            } else {
                self.drive.apply(self.time)?;
            }
            self.pending = Pending::Nothing;
        }
        Ok(())
    }

    /// [`DynDrive::put`].
    #[inline(always)]
    fn put_inputs(&mut self, set: &Set) -> bool {
        let Some(inputs) = self.drive.inputs() else { return self.put_one_by_one(set) };
        if let Some(all) = set.first_three() {
            *inputs = all;
            self.pending = self.pending.max(Pending::Inputs);
            return true;
        }
        let before = *inputs;
        for (place, value) in set.iter() {
            match inputs.get_mut(place) {
                Some(input) if value.abs() <= INPUTS[place] => *input = value,
                _ => {
                    *inputs = before;
                    return false;
                }
            }
        }
        self.pending = self.pending.max(Pending::Inputs);
        true
    }

    /// The same of inputs that the drive has elsewhere, or within ranges.
    #[inline(never)]
    fn put_one_by_one(&mut self, set: &Set) -> bool {
        let inputs = &self.design.inputs;
        let admissible = |(place, value): (usize, f64)| {
            inputs.get(place).is_some_and(|input| input.min <= value && value <= input.max)
        };
        if !set.iter().all(admissible) {
            return false;
        }
        for (place, value) in set.iter() {
            if let Some(input) = self.design.inputs.get(place) {
                (input.set)(&mut self.drive, input.index, value);
            }
        }
        self.pending = Pending::Settings;
        true
    }

    /// Puts another drive in the place of this one. The log, which is no part of the state, stays.
    fn replace(&mut self, mut drive: D) {
        std::mem::swap(drive.events(), self.drive.events());
        self.drive = drive;
        self.broken = false;
        self.drive.events().clear();
    }

    /// The derivative of an output; order 1 or 2.
    fn derivative(&mut self, reference: usize, seed: Seed, order: usize) -> Result<f64, Fault> {
        self.refresh()?;
        let v = &self.design.variables[reference];
        let Description { name, causality, variability, dependencies, .. } = &v.description;
        let value = match v.series {
            Some(series) => series(&self.drive, seed, v.index).derivative(order),
            // What changes at events only stands still between them, and hosts ask for the slope of every output.
            None if *causality == Causality::Output
                && *variability == Variability::Discrete
                && (seed == Seed::Time || dependencies.is_empty()) =>
            {
                0.0
            }
            None => return Err(Fault(format!("`{name}` is not a continuous output; it has no derivatives"))),
        };
        if value.is_finite() {
            Ok(value)
        } else {
            Err(Fault(format!("a derivative of `{name}` is not a finite number at t = {} s", self.time)))
        }
    }

    /// ∂unknown/∂known of the start values, in which the states follow from inputs and parameters (y = U(phi) + start.q), by
    /// differences on copies, since a start may be the result of an iteration.
    fn initial_derivative(&self, unknown: usize, known: usize) -> Result<f64, Fault> {
        let (u, k) = (&self.design.variables[unknown], &self.design.variables[known]);
        let (Some(set), Kind::Real { quantity, min, max, .. }) = (k.set, &k.description.kind) else {
            return Err(Fault(format!(
                "`{}` follows from inputs and parameters before the start; derivatives exist for those",
                k.description.name
            )));
        };
        if u.set.is_some() {
            return Err(Fault(format!("`{}` is set, not computed; it has no derivatives", u.description.name)));
        }
        let centre = (k.get)(&self.drive, k.index);
        let value_at = |known: f64| -> Result<f64, Fault> {
            let mut drive = self.drive.clone();
            set(&mut drive, k.index, known);
            drive.start(self.time)?;
            Ok((u.get)(&drive, u.index))
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
        if slope.is_finite() {
            Ok(slope)
        } else {
            let (u, k) = (&u.description.name, &k.description.name);
            Err(Fault(format!("the derivative of `{u}` with respect to `{k}` is not a finite number before the start")))
        }
    }

    /// Which state is no number.
    #[cold]
    fn not_finite(&self) -> Fault {
        let states = self.design.variables.iter().filter(|v| v.description.state);
        let lost = states.map(|v| (&v.description.name, (v.get)(&self.drive, v.index))).find(|(_, x)| !x.is_finite());
        let name = lost.map_or("the state", |(name, _)| name);
        Fault(format!("`{name}` is not a finite number at t = {} s", self.time))
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

    fn peek(&self, reference: u32) -> f64 {
        match self.reals.get(reference as usize) {
            Some(real) if self.pending == Pending::Nothing => (real.get)(&self.drive, real.index),
            _ => f64::NAN,
        }
    }

    fn get(&mut self, reference: usize) -> Result<f64, Fault> {
        let v = &self.design.variables[reference];
        if v.set.is_none() {
            self.refresh()?;
        }
        let v = &self.design.variables[reference];
        let value = (v.get)(&self.drive, v.index);
        if value.is_finite() {
            Ok(value)
        } else {
            Err(Fault(format!("`{}` is not a finite number at t = {} s", v.description.name, self.time)))
        }
    }

    extern "C" fn put(&mut self, set: &Set) -> bool {
        catch_unwind(AssertUnwindSafe(|| self.put_inputs(set))).unwrap_or(false)
    }

    fn check(&self, reference: usize, value: f64) -> Result<(), Fault> {
        let v = &self.design.variables[reference];
        let d = &v.description;
        if v.set.is_none() {
            return Err(Fault(format!("`{}` is computed and cannot be set", d.name)));
        }
        if d.causality == Causality::Parameter && d.variability == Variability::Fixed && !self.initialising {
            return Err(Fault(format!(
                "`{}` is a fixed parameter; it can be set only before initialisation ends",
                d.name
            )));
        }
        d.check(value)
    }

    fn set(&mut self, reference: usize, value: f64) -> Result<(), Fault> {
        self.check(reference, value)?;
        let v = &self.design.variables[reference];
        if let Some(set) = v.set {
            set(&mut self.drive, v.index, value);
            self.pending = Pending::Settings;
        }
        Ok(())
    }

    fn set_up(&mut self, time: f64, tolerance: Option<f64>) {
        self.time = time;
        self.drive.request_tolerance(tolerance.unwrap_or(0.0));
        self.pending = Pending::Settings;
    }

    fn start(&mut self) -> Result<(), Fault> {
        self.refresh()?;
        if !self.drive.is_finite() {
            return Err(self.not_finite());
        }
        self.initialising = false;
        Ok(())
    }

    fn board(&self) -> Board {
        let mut outputs = (0..).zip(&self.design.variables);
        let first = outputs.find(|(_, v)| v.description.causality == Causality::Output);
        Board::new(first.map_or(0, |(reference, v): (u32, _)| reference.wrapping_sub(v.index as u32)))
    }

    extern "C" fn glide(&mut self, time: f64, end: f64, board: &mut Board) -> bool {
        if self.pending == Pending::Settings || !(self.drive.angle(time, end).abs() <= LARGEST_ANGLE) {
            return false;
        }
        self.time = end;
        let glided = catch_unwind(AssertUnwindSafe(|| self.drive.glide(time, end, board))).unwrap_or_else(|_| {
            self.broken = true;
            false
        });
        if glided {
            self.pending = Pending::Nothing;
        }
        glided
    }

    fn show(&self, board: &mut Board) {
        self.drive.show(board);
    }

    fn advance(&mut self, time: f64, step: f64) -> Result<usize, Box<Fault>> {
        assert!(!self.broken, "a short step failed");
        self.time = time;
        self.refresh()?;
        check_angle(self.drive.angle(time, time + step), time + step)?;
        self.drive.advance(time, step)?;
        self.time = time + step;
        if self.drive.is_finite() { Ok(self.drive.events().count()) } else { Err(self.not_finite().into()) }
    }

    fn input_derivative_order(&self) -> usize {
        self.drive.input_derivative_order()
    }

    fn check_input_derivative(&self, reference: usize, order: usize, value: f64) -> Result<(), Fault> {
        let d = &self.design.variables[reference].description;
        if d.causality != Causality::Input {
            return Err(Fault(format!("`{}` is no input; only inputs have input derivatives", d.name)));
        }
        if !(1..=self.drive.input_derivative_order()).contains(&order) {
            return Err(Fault(format!(
                "`{}`: the order {order} of its derivative is outside 1 … {}",
                d.name,
                self.drive.input_derivative_order()
            )));
        }
        if !value.is_finite() {
            return Err(Fault(format!(
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
        self.pending = Pending::Settings;
        Ok(())
    }

    fn output_derivative(&mut self, reference: usize, order: usize) -> Result<f64, Fault> {
        if !(1..=2).contains(&order) {
            return Err(Fault(format!("output derivatives of order {order} do not exist; the order is 1 or 2")));
        }
        self.derivative(reference, Seed::Time, order)
    }

    fn directional_derivative(&mut self, unknown: usize, known: usize) -> Result<f64, Fault> {
        if self.initialising {
            return self.initial_derivative(unknown, known);
        }
        let d = &self.design.variables[known].description;
        if d.causality != Causality::Input && !d.state {
            return Err(Fault(format!(
                "`{}` is neither an input nor a state; there is no derivative with respect to it",
                d.name
            )));
        }
        self.derivative(unknown, Seed::Known(known), 1)
    }

    fn reset(&mut self) {
        self.replace(self.design.initial.clone());
        (self.initialising, self.pending, self.time) = (true, Pending::Settings, 0.0);
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
        let (mut state, rest): (Snapshot<D>, &[u8]) =
            postcard::take_from_bytes(bytes).map_err(|e| Fault(format!("the serialised state cannot be read: {e}")))?;
        if !rest.is_empty() {
            return Err(Fault::new("the serialised state is longer than it should be"));
        }
        let mut made = self.design.initial.clone();
        for v in &self.design.variables {
            let Some(set) = v.set else { continue };
            let value = (v.get)(&state.drive, v.index);
            // What the scene itself says is not looked at again, and what nobody changes stays shared.
            if value != (v.get)(&made, v.index) {
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
