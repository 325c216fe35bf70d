//! Points of a table.

use super::plan::{LARGEST, MAX_LENGTH};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The fewest points of a table.
pub const LEAST_POINTS: usize = 4;

/// The most points of a scene: a tenth of a degree makes 3600 of them, and the FMU carries each one.
pub const MOST_POINTS: usize = 20_000;

/// The least distance of neighbouring angles (rad); a finer one is a fault of the table, not a measurement.
pub const LEAST_DISTANCE: f64 = 1e-6;

/// A last point this near one turn after the first (rad) closes the table: angles are printed with five digits.
pub const CLOSING: f64 = 1e-4;

/// The lifts of first and closing point may differ by this part of the stroke: roundings of a conversion.
const EQUAL_LIFT: f64 = 1e-9;

/// Without a closing point the gap may be this many times the largest distance of neighbours.
const LARGEST_GAP: f64 = 2.0;

/// Angles (rad) and lifts (m).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Points {
    /// Strictly ascending over at most one turn; the last may repeat the first one turn later.
    pub angles: Vec<f64>,
    /// As long as `angles`; a repeated point repeats its lift.
    pub lifts: Vec<f64>,
}

/// The derivatives at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bend {
    /// U′ (m/rad).
    pub slope: f64,
    /// U″ (m/rad²) on the piece that ends at the point.
    pub before: f64,
    /// U″ (m/rad²) on the piece that begins there.
    pub behind: f64,
}

/// The reason why points make no table; indices count from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TableError {
    /// The numbers of lifts and angles differ.
    Lengths {
        /// Number of angles.
        angles: usize,
        /// Number of lifts.
        lifts: usize,
    },
    /// Fewer than [`LEAST_POINTS`] points, a closing one not counted.
    TooFew {
        /// Number of points.
        points: usize,
    },
    /// An angle or a lift is NaN, infinite or too large.
    OutOfRange {
        /// Index of the point.
        index: usize,
        /// The value (rad or m).
        value: f64,
    },
    /// An angle does not exceed the previous one by [`LEAST_DISTANCE`].
    NotAscending {
        /// Index of the point.
        index: usize,
        /// The previous angle (rad).
        previous: f64,
        /// Its angle (rad).
        angle: f64,
    },
    /// The angles span more than one turn.
    TooLong {
        /// Index of the first point too many.
        index: usize,
        /// Its distance from the first angle (rad).
        span: f64,
    },
    /// The closing point, one turn after the first, has another lift.
    NotPeriodic {
        /// Index of the closing point.
        index: usize,
        /// Lift of the first point (m).
        first: f64,
        /// Lift of the closing point (m).
        last: f64,
    },
    /// The table stops too far before the end of its turn.
    NotClosed {
        /// Index of the last point.
        index: usize,
        /// Angle from the last point to the first one of the next turn (rad).
        gap: f64,
        /// The largest distance of neighbours (rad).
        distance: f64,
    },
    /// More harmonics than the points determine.
    TooManyHarmonics {
        /// The requested number of harmonics.
        harmonics: usize,
        /// The most that the points determine.
        most: usize,
        /// The angle between two neighbours (rad) that limits the harmonics; None if the number of points does.
        gap: Option<f64>,
    },
}

impl TableError {
    /// The index of the point at fault, from 0.
    pub fn index(&self) -> Option<usize> {
        match *self {
            TableError::OutOfRange { index, .. }
            | TableError::NotAscending { index, .. }
            | TableError::TooLong { index, .. }
            | TableError::NotPeriodic { index, .. }
            | TableError::NotClosed { index, .. } => Some(index),
            _ => None,
        }
    }
}

impl std::fmt::Display for TableError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the points make no table: {self:?}")
    }
}

impl std::error::Error for TableError {}

impl Points {
    /// Checks the points and removes a closing one.
    pub fn open(mut self) -> Result<Self, TableError> {
        if self.check(false)? {
            self.angles.pop();
            self.lifts.pop();
        }
        if self.angles.len() < LEAST_POINTS {
            return Err(TableError::TooFew { points: self.angles.len() });
        }
        Ok(self)
    }

    /// Checks the points; two of them may have one angle if the lift may `step`. Returns whether the last one closes the turn.
    pub fn check(&self, step: bool) -> Result<bool, TableError> {
        let (angles, lifts) = (&self.angles, &self.lifts);
        if angles.len() != lifts.len() {
            return Err(TableError::Lengths { angles: angles.len(), lifts: lifts.len() });
        }
        for (index, &value) in angles.iter().enumerate() {
            // Cams have angles up to 10⁴ rad; the comparison also refuses NaN.
            let beyond =
                [(value, MAX_LENGTH), (lifts[index], LARGEST)].into_iter().find(|(v, most)| !(v.abs() <= *most));
            if let Some((value, _)) = beyond {
                return Err(TableError::OutOfRange { index, value });
            }
            let steps = step && index > 0 && value == angles[index - 1] && !(index > 1 && value == angles[index - 2]);
            if index > 0 && value - angles[index - 1] < LEAST_DISTANCE && !steps {
                return Err(TableError::NotAscending { index, previous: angles[index - 1], angle: value });
            }
            if value - angles[0] > TAU + CLOSING {
                return Err(TableError::TooLong { index, span: value - angles[0] });
            }
        }
        let end = angles.last().copied().unwrap_or(f64::NAN);
        if end.is_nan() || step && end == angles[0] {
            return Err(TableError::TooFew { points: angles.len().min(1) });
        }
        let index = angles.len() - 1;
        let closes = end - angles[0] >= TAU - CLOSING;
        if closes {
            let range = lifts.iter().fold(0.0_f64, |range, lift| range.max((lift - lifts[0]).abs()));
            // A single closing point may be the beginning of a step.
            let steps = [0, index - 1].into_iter().any(|i| angles[i] == angles[i + 1]);
            if (lifts[index] - lifts[0]).abs() > EQUAL_LIFT * range && (steps || !step) {
                return Err(TableError::NotPeriodic { index, first: lifts[0], last: lifts[index] });
            }
        } else {
            let gap = angles[0] + TAU - end;
            let distance = angles.windows(2).fold(0.0_f64, |d, w| d.max(w[1] - w[0]));
            if index > 0 && gap > LARGEST_GAP * distance {
                return Err(TableError::NotClosed { index, gap, distance });
            }
        }
        Ok(closes)
    }
}
