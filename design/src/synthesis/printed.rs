//! The printed cubics of two dwells ([`dwells`]) next to the exact coefficients.

use super::laws::{symmetric_dwells, two_dwells};
use super::{Objective, Task};
use crate::formulas::dwells;
use crate::report::terminal::shown;
use crate::report::unit::MM;
use crate::text::number;
use camdrive::motion::Fourier;

/// The cubics fail where their dwell error is this many times the possible one.
const FAILED: f64 = 1.05;

/// Dwell errors max |U − Ũ|.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubics {
    /// With the coefficients of the cubics (m).
    pub error: f64,
    /// With the exact ones (m).
    pub exact: f64,
}

impl Cubics {
    /// The errors against the exact series of a task; None for other tasks.
    pub fn beside(exact: &Fourier, task: &Task) -> Option<Self> {
        Some(Cubics { error: task.largest_error(&cubics(task)?), exact: task.largest_error(exact) })
    }

    /// A line of the report.
    pub fn line(&self) -> String {
        let (error, exact) = (shown(self.error, &MM), shown(self.exact, &MM));
        if self.error > FAILED * self.exact {
            let times = number(self.error / self.exact);
            format!(
                "The cubics (4.6.4.1 (2) to (6)) of the source fail here: dwell error {error}, {times} times the {exact} of \
                 the exact coefficients."
            )
        } else {
            format!("The cubics (4.6.4.1 (2) to (6)) of the source give {error}, the exact coefficients {exact}.")
        }
    }
}

/// Solution of the task by the cubics (4.6.4.1 (2) to (6)) of the source: three or five harmonics in the sense of
/// least squares; None where they are not for this task.
pub fn cubics(task: &Task) -> Option<Fourier> {
    let (half, middle) = symmetric_dwells(task)?;
    let [(_, low), (_, high)] = two_dwells(task)?;
    let coefficients =
        dwells::cubics(task.basis.order(), half).filter(|_| task.objective == Objective::LeastSquares)?;
    let mut a = vec![0.0; 2 * coefficients.len()];
    a[0] = 0.5 * (low + high);
    for (i, c) in coefficients.iter().enumerate() {
        a[2 * i + 1] = (high - low) * c;
    }
    Some(Fourier::new(a, Vec::new()).delayed(middle))
}
