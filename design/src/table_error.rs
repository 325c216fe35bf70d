//! The reason why points are no table, for people.

use crate::text::counted;
use camdrive::drives::{Number, Rounded};
use camdrive::motion::plan::{LARGEST, MAX_LENGTH};
use camdrive::motion::table::{LEAST_DISTANCE, LEAST_POINTS, TableError};

/// The fault in words.
pub fn told(error: &TableError) -> String {
    match error {
        TableError::Lengths { angles, lifts } => {
            let (angles, lifts) = (counted(angles, "angle"), counted(lifts, "lift"));
            format!("{angles} and {lifts}; a table needs as many lifts as angles")
        }
        TableError::TooFew { points } => {
            format!("{} within the turn; a table needs at least {LEAST_POINTS}", counted(points, "point"))
        }
        TableError::OutOfRange { index, value } => {
            format!(
                "point {}: {} is not a finite angle of at most {MAX_LENGTH} rad or value of at most {LARGEST:e}",
                index + 1,
                Number(*value)
            )
        }
        TableError::NotAscending { index, previous, angle } => format!(
            "point {}: the angle {} rad = {} deg does not exceed the previous one, {} rad = {} deg, by \
             at least {LEAST_DISTANCE:e} rad",
            index + 1,
            Number(*angle),
            Rounded(angle.to_degrees()),
            Number(*previous),
            Rounded(previous.to_degrees())
        ),
        TableError::TooLong { index, span } => format!(
            "point {}: {} rad = {} deg after the first point; a table spans one turn, 2π rad = 360 deg",
            index + 1,
            Number(*span),
            Rounded(span.to_degrees())
        ),
        TableError::NotPeriodic { index, first, last } => format!(
            "point {}: the lift {} m one turn after the first point differs from its lift {} m",
            index + 1,
            Number(*last),
            Number(*first)
        ),
        TableError::NotClosed { index, gap, distance } => format!(
            "point {}: {} rad = {} deg are left of the turn after this last point, while neighbours are at \
             most {} rad apart; a table covers the whole turn",
            index + 1,
            Rounded(*gap),
            Rounded(gap.to_degrees()),
            Rounded(*distance)
        ),
        TableError::TooManyHarmonics { harmonics, most, gap: None } => {
            format!("{}; the points determine at most {most}", counted(harmonics, "harmonic"))
        }
        TableError::TooManyHarmonics { harmonics, most, gap: Some(gap) } => format!(
            "{harmonics} harmonics; the widest gap between neighbouring points, {} deg, carries at most {most}",
            Rounded(gap.to_degrees())
        ),
    }
}
