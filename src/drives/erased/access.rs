//! What reading and setting a variable takes, and nothing else of it.

use crate::drives::Variable;
use crate::drives::limits::INPUTS;
use crate::drives::variable::{Causality, Kind};

/// How a variable is read, and nothing else of it: what importers read after each step shall lie close together.
pub struct Access<D> {
    /// Reads the value.
    pub get: fn(&D, usize) -> f64,
    /// What `get` needs to know.
    pub index: usize,
}

impl<D> Access<D> {
    /// Variables of other types read as NaN, which is no value of a Real.
    pub fn of(v: &Variable<D>) -> Self {
        match v.description.kind {
            Kind::Real { .. } => Access { get: v.get, index: v.index },
            _ => Access { get: |_, _| f64::NAN, index: 0 },
        }
    }
}

/// How an input is set, and nothing else of it: importers set inputs before each step.
pub struct Input<D> {
    /// Writes the value.
    pub set: fn(&mut D, usize, f64),
    /// What `set` needs to know.
    pub index: usize,
    /// Admissible range, borders included; finite.
    pub min: f64,
    /// See `min`.
    pub max: f64,
}

impl<D> Input<D> {
    /// None for other variables.
    pub fn of(v: &Variable<D>) -> Option<Self> {
        match v.description.kind {
            Kind::Real { min, max, .. } if v.description.causality == Causality::Input => {
                let (min, max) = (min.max(f64::MIN), max.min(f64::MAX));
                v.set.map(|set| Input { set, index: v.index, min, max })
            }
            _ => None,
        }
    }
}

/// Values by their references.
pub struct Set<'a> {
    /// The references.
    pub references: &'a [u32],
    /// The values, as many.
    pub values: &'a [f64],
}

impl Set<'_> {
    /// Places and values.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = (usize, f64)> {
        self.references.iter().zip(self.values).map(|(reference, value)| (*reference as usize, *value))
    }

    /// The values of the places 0, 1 and 2 where they are all and stand in this order, as most importers set them; within the
    /// limits of the inputs.
    #[inline(always)]
    pub fn first_three(&self) -> Option<[f64; 3]> {
        match (self.references, self.values) {
            ([0, 1, 2], &[x, y, z]) if x.abs() <= INPUTS[0] && y.abs() <= INPUTS[1] && z.abs() <= INPUTS[2] => {
                Some([x, y, z])
            }
            _ => None,
        }
    }
}

/// What was set and not yet taken up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub enum Pending {
    /// Nothing.
    Nothing,
    /// Inputs, of those that [`crate::drives::Drive::inputs`] holds.
    Inputs,
    /// Anything.
    Settings,
}
