//! The grid of the method `fixed_cost`: equal steps in time, each of the same cost, for hosts with a deadline.
//!
//! The grid starts with the simulation. After a step to a communication point or a border the next step goes to the next point of
//! the grid.

use crate::drives::shaft::free::motor::{Kloss, Motor};
use crate::drives::shaft::free::{Shaft, State};
use crate::drives::solver::step_control::{SLIVER, WORST, point_of_grid};
use crate::drives::{Fault, Rounded};
use crate::numerics::double_double::Double;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// How often borders of the motion laws may cut an internal step. The usual step passes one on the average; the densest laws put
/// five of them into the angle of two.
pub const MOST_CUTS: u32 = 8;

/// The usual step, times the angular rate of the shortest wave of J and the square root of J's range: it passes a wave of a J of
/// little variation in three steps.
const ANGLE: f64 = 2.0;

/// The usual step, as part of the time that a motor needs to follow its load, w_s s_K J/M_K, and of the lag of its torque.
const FOLLOWING: f64 = 1.0;

/// Limit to how far a stiff motor may shorten the usual step: within a smaller part of a wave the motion jumps between two motions
/// in balance, which the method meets without resolving the transition.
const STIFFEST: f64 = 1.0 / 32.0;

/// The usual step (s) of a machine whose start and motor determine no speed: the communication step of common real-time hosts.
const USUAL: f64 = 1e-3;

/// The grid and the way to its next point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// The start of the grid (s).
    origin: f64,
    /// The length of its steps (s).
    pub size: f64,
    /// The point of the grid at which the steps aim (s), and how often borders have cut the way there.
    point: Double,
    cuts: u32,
}

impl Grid {
    /// The grid from `origin` (s) on with steps of the size that is `asked` for (s), else of the usual one.
    pub fn new(origin: f64, asked: f64, shaft: &Shaft, start: &State) -> Self {
        let size = if asked > 0.0 { asked } else { usual_step(shaft, start) };
        Grid { origin, size, point: Double::from(origin), cuts: 0 }
    }

    /// The end of the step from `from` on: the next point of the grid, or `limit`.
    pub fn end_of_step(&mut self, from: Double, limit: Option<Double>) -> Double {
        let point = point_of_grid(self.origin, self.size, from);
        if (point - self.point).hi > 0.0 {
            (self.point, self.cuts) = (point, 0);
        }
        // No sliver is left over after the point either.
        limit.filter(|limit| (*limit - point).hi <= SLIVER * self.size).unwrap_or(point)
    }

    /// Counts a step that a border ended before the next point of the grid.
    pub fn cut(&mut self, at: Double) -> Result<(), Fault> {
        self.cuts += 1;
        if self.size == 0.0 || self.cuts <= MOST_CUTS {
            return Ok(());
        }
        Err(Fault::new(format!(
            "the shaft passes more than {MOST_CUTS} breakpoints of its motion laws within an internal step of {} s, at t = {} s; shorten solver.step_size, or set solver.method = adaptive",
            Rounded(self.size),
            Rounded(at.hi)
        )))
    }

    /// The fault of a step from this state on that is too long.
    pub fn refused(&self, state: &State, from: Double) -> Fault {
        Fault::new(format!(
            "the motion cannot be computed beyond t = {} s (w = {} rad/s) with internal steps of {} s: they turn the shaft too far, or miss more than {WORST} of the motion; shorten solver.step_size, or set solver.method = adaptive",
            Rounded(from.hi),
            Rounded(state.w),
            Rounded(self.size)
        ))
    }
}

/// The default internal step (s): see [`ANGLE`], [`FOLLOWING`], [`STIFFEST`] and [`USUAL`]; borders of the motion laws are passed
/// one at a time on the average.
///
/// √J(φ) is a sum of waves up to the order R of J with branch points √(J_min/J_max)/R next to the real angles, or farther away.
fn usual_step(Shaft { inertia, motor, .. }: &Shaft, start: &State) -> f64 {
    let (low, high) = inertia.range();
    let free = start.u.hi.abs() / low.sqrt();
    let (synchronous, follows) = match *motor {
        Motor::Kloss(Kloss { breakdown_torque, breakdown_slip, synchronous_speed, dynamics }) => {
            let speed = synchronous_speed.abs();
            let own = speed * breakdown_slip * low / breakdown_torque.abs();
            (speed, dynamics.map_or(own, |lag| lag.min((lag * own).sqrt())))
        }
        Motor::None | Motor::Input => (0.0, f64::INFINITY),
    };
    let smooth = ANGLE / (inertia.resolution() * (high / low).sqrt());
    let angle = smooth.min(TAU / inertia.pieces().len() as f64);
    let speed = free.max(synchronous);
    if speed > 0.0 {
        let step = angle / speed;
        step.min((FOLLOWING * follows).max(STIFFEST * step))
    } else {
        USUAL
    }
}
