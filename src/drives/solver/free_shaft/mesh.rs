//! The turn as a mesh of cells, with J(φ) tabulated at the nodes of each.
//!
//! A machine passes the same angles in every turn. J there is computed once, so the cost of a turn depends neither on the number of
//! followers nor on the number of their harmonics. Cells are as wide as the tolerance of the angle permits for the polynomial
//! through the nodes (degree 9) for √J(φ), to which 1/φ̇ of a machine without torques is proportional. They end at the borders of
//! the motion laws. Cells are divided if the motor's torque varies more than √J at its synchronous speed.

use super::angle_step::{AngleStep, Part, Position, ReciprocalInertia};
use crate::drives::shaft::free::beside;
use crate::drives::shaft::free::motor::{Kloss, Motor};
use crate::drives::shaft::free::profile::Profile;
use crate::drives::shaft::free::torques::Torques;
use crate::drives::{Fault, Number, Rounded};
use crate::numerics::angle::WHOLE_TURN;
use crate::numerics::double_double::{Double, two_sum};
use crate::numerics::gauss::{ABSCISSAE, STAGES, WEIGHTS};
use crate::numerics::interpolant::{COEFFICIENTS, INTEGRATION, Interpolant, neglected};
use crate::numerics::work::Work;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The widest cell (rad). If J is constant only the torque changes the speed; a sixth of a turn lets the step control save work
/// without missing the change.
const WIDEST: f64 = TAU / 6.0;

/// The narrowest cell (rad): a wave of J that is shorter than this has more harmonics than a scene can hold.
const NARROWEST: f64 = 1e-9;

/// Edges are multiples of this (rad), so that the widths between them are exact and a million turns add up exactly.
const GRAIN: f64 = 1.0 / (1u64 << 45) as f64;

/// Tolerance of the table as part of the motion's: the motion adds the variation that the torques cause, and a slightly too wide
/// cell would have to be passed in two steps every turn.
const FINER: f64 = 0.1;

/// Into how many parts the motor's torque may divide a cell. A motor that is only briefly synchronous needs narrow cells just
/// there, which no table can know.
const MOST_PARTS: f64 = 4.0;

/// Cost of a cell without the evaluations of J for it (nominal µs).
const CELL: f64 = 0.5;

/// A part of the turn.
pub struct Cell {
    /// φ at the low end (rad).
    pub low: f64,
    /// φ at the high end (rad).
    pub high: f64,
    /// The exact width (rad); the width of the last cell accounts for a turn of 2π.
    pub width: f64,
    /// The interval between borders of the motion laws.
    pub interval: usize,
    /// 2/J.
    pub reciprocal: ReciprocalInertia,
}

/// The cells of a turn, ascending; empty before it is prepared.
#[derive(Clone, Default)]
pub struct Mesh {
    cells: Arc<Vec<Cell>>,
    /// J(φ).
    pub profile: Arc<Profile>,
    /// The greatest width of a cell (rad).
    pub widest: f64,
    /// The mean of √J over the turn.
    pub mean_root: f64,
    /// The motor and the tolerance that the cells were made for.
    pub motor: Motor,
    pub tolerance: f64,
}

impl Cell {
    /// φ at its entry (rad).
    pub fn entry(&self, forward: bool) -> Double {
        Double::from(if forward { self.low } else { self.high })
    }
}

/// 2/J over the `width` (rad) from `low` on, in interval `interval`.
pub fn tabulate(profile: &Profile, interval: usize, low: f64, width: f64) -> ReciprocalInertia {
    let at = |x: f64| 2.0 / profile.value(interval, low + 0.5 * (1.0 + x) * width);
    ReciprocalInertia { ends: [at(-1.0), at(1.0)], nodes: ABSCISSAE.map(at) }
}

/// The error of the angle at a given time (rad) that a machine without torques would have in a cell of this `width`
/// with the polynomial through the nodes for √J.
fn error(table: &ReciprocalInertia, width: f64) -> f64 {
    let root = |reciprocal: f64| reciprocal.recip().sqrt();
    let (nodes, ends) = (table.nodes.map(root), table.ends.map(root));
    let modes: [f64; COEFFICIENTS] = Interpolant::modes_through(&nodes, ends);
    let least = nodes.into_iter().chain(ends).fold(f64::INFINITY, f64::min);
    width * neglected(&modes) / (INTEGRATION * least)
}

/// The fault of a turn that cannot be divided with the work of a call; it reached an angle where cells are this wide (rad).
fn too_many(profile: &Profile, [at, width]: [f64; 2]) -> Fault {
    let (low, high) = profile.inertia.range();
    Fault::new(format!(
        "J(phi), between {} and {} kg.m2, changes so fast that no table of it can be made: at phi = {} deg it would need one \
         entry in {} deg; choose a larger `J0` (now {} kg.m2), smaller masses, or motion laws and levers that move less",
        Rounded(low),
        Rounded(high),
        Rounded(at.to_degrees()),
        Rounded(width.to_degrees()),
        Number(profile.inertia.function.constant)
    ))
}

/// The mean of √J over the turn.
fn mean_root(cells: &[Cell]) -> f64 {
    let root = |cell: &Cell| -> f64 {
        let nodes = &cell.reciprocal.nodes;
        cell.width * nodes.iter().zip(&WEIGHTS).map(|(reciprocal, b)| b * (2.0 / reciprocal).sqrt()).sum::<f64>()
    };
    cells.iter().map(root).sum::<f64>() / TAU
}

impl Mesh {
    /// The mesh on which J is met to the relative `tolerance`, and the torque of the motor near its synchronous speed.
    ///
    /// # Errors
    /// The turn needs so many cells that the work of a call is not enough for them.
    pub fn new(profile: Arc<Profile>, motor: Motor, tolerance: f64) -> Result<Self, Fault> {
        let mut cells = Self::of_inertia(&profile, tolerance)?;
        if let Motor::Kloss(kloss @ Kloss { dynamics: None, .. }) = motor {
            cells = Self::divided(cells, &profile, kloss, tolerance);
        }
        let widest = cells.iter().map(|cell| cell.width).fold(0.0, f64::max);
        let mean_root = mean_root(&cells);
        Ok(Mesh { widest, mean_root, cells: Arc::new(cells), profile, motor, tolerance })
    }

    /// The cells that J(φ) alone needs.
    fn of_inertia(profile: &Profile, tolerance: f64) -> Result<Vec<Cell>, Fault> {
        let inertia = &profile.inertia;
        let (mut cells, mut work) = (Vec::new(), Work::default());
        let cost = CELL + (2 + STAGES) as f64 * inertia.cost();
        let mut width = WIDEST.min(4.0 / inertia.resolution());
        // The distance of the rounded end of the turn from 2π after its start.
        let missing = two_sum(inertia.borders().first().copied().unwrap_or(0.0), TAU).lo + WHOLE_TURN.lo;
        for (interval, (low, high)) in inertia.pieces().enumerate() {
            let mut at = low;
            while at < high {
                width = width.min(WIDEST);
                work.draw(cost).map_err(|_| too_many(profile, [at, width]))?;
                let end = edge(at, width, high);
                let missing = if end == high && interval + 1 == inertia.pieces().len() { missing } else { 0.0 };
                let own = end - at + missing;
                let reciprocal = tabulate(profile, interval, at, own);
                let error = error(&reciprocal, own);
                // The error goes with the tenth power of the width.
                let growth = (0.9 * (FINER * tolerance / error.max(1e-300)).powf(0.1)).clamp(0.3, 2.0);
                width = (end - at) * growth;
                if error <= FINER * tolerance || end - at <= NARROWEST {
                    debug_assert!(reciprocal.nodes.iter().all(|reciprocal| *reciprocal > 0.0));
                    cells.push(Cell { low: at, high: end, width: own, interval, reciprocal });
                    at = end;
                }
            }
        }
        Ok(cells)
    }

    /// These cells, divided if a machine with the mean energy of the synchronous speed would not pass them in one step: its torque
    /// has waves of its own.
    fn divided(cells: Vec<Cell>, profile: &Profile, motor: Kloss, tolerance: f64) -> Vec<Cell> {
        let speed = motor.synchronous_speed;
        let torques = Torques::against(&Motor::Kloss(motor), 0.0, speed.signum());
        let energy = Double::from(0.5 * (mean_root(&cells) * speed).powi(2));
        let position = Position { energy, ..Position::default() };
        let remainder = FINER * tolerance;
        let mut divided = Vec::with_capacity(2 * cells.len());
        for cell in cells {
            let part = Part { from: position, length: cell.width, to_edge: true, reciprocal: &cell.reciprocal };
            let step = AngleStep::new(&part, &torques, None, remainder, &mut 0.0);
            let error = step.map_or(f64::INFINITY, |step| step.estimate.error);
            // The error goes with the ninth power of the width.
            let parts = (error / tolerance).powf(1.0 / 9.0).ceil().clamp(1.0, MOST_PARTS) as usize;
            let missing = cell.width - (cell.high - cell.low);
            let mut low = cell.low;
            for left in (1..=parts).rev() {
                let high = edge(low, (cell.high - low) / left as f64, cell.high);
                let width = high - low + if high == cell.high { missing } else { 0.0 };
                let reciprocal =
                    if parts == 1 { cell.reciprocal } else { tabulate(profile, cell.interval, low, width) };
                divided.push(Cell { low, high, width, interval: cell.interval, reciprocal });
                low = high;
                if low == cell.high {
                    break;
                }
            }
        }
        divided
    }

    /// Whether it is the mesh on this profile, of this motor and this tolerance.
    pub fn is_for(&self, profile: &Arc<Profile>, motor: &Motor, tolerance: f64) -> bool {
        Arc::ptr_eq(&self.profile, profile) && self.motor == *motor && self.tolerance == tolerance
    }

    /// The cells.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The start of the step that follows a step in this sense.
    pub fn after(&self, step: &AngleStep, sense: f64) -> Position {
        let angle = step.from.angle + Double::from(sense * step.length);
        let mut position = Position { time: step.end, energy: step.energy, angle, ..step.from };
        if step.to_edge {
            self.next(&mut position, sense > 0.0);
        }
        position
    }

    /// Moves a position at the end of its cell to the entry of the next one.
    pub fn next(&self, position: &mut Position, forward: bool) {
        let (cell, turns) = beside(position.cell, self.cells.len(), forward);
        (position.cell, position.turns) = (cell, position.turns + turns);
        position.angle = self.cells[cell].entry(forward);
    }

    /// The cell that holds the angle `phi` of interval `interval`; on an edge the cell ahead.
    pub fn find(&self, interval: usize, phi: f64, forward: bool) -> usize {
        let first = self.cells.partition_point(|cell| cell.interval < interval);
        let beyond = self.cells.partition_point(|cell| cell.interval <= interval);
        let own = &self.cells[first..beyond];
        let behind = own.partition_point(|cell| if forward { cell.low <= phi } else { cell.low < phi });
        first + behind.max(1) - 1
    }
}

/// The end of a cell that is about `width` wide (rad) and leaves no sliver before `high`.
fn edge(low: f64, width: f64, high: f64) -> f64 {
    let remaining = high - low;
    if width >= 0.999 * remaining {
        return high;
    }
    let wanted = low + if width > 0.5 * remaining { 0.5 * remaining } else { width };
    let rounded = (wanted / GRAIN).round() * GRAIN;
    if rounded > low && rounded < high { rounded } else { high }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drives::follower::rigid::Follower;
    use crate::drives::shaft::free::inertia::{Inertia, InertiaFunction};
    use crate::motion::{Fourier, MotionLaw};

    fn profile(constant: f64, order: usize) -> Arc<Profile> {
        let mut a = vec![0.0; order + 1];
        (a[1], a[order]) = (0.1, 0.1 / order as f64);
        let cam = MotionLaw::Fourier(Fourier::new(a, vec![]));
        let inertia = Inertia::new(InertiaFunction { constant, varying: None }, vec![Follower::new(10.0, cam)]);
        Arc::new(Profile::new(Arc::new(inertia)))
    }

    #[test]
    fn the_cells_cover_the_turn_and_follow_the_waves() {
        let count = |constant, order, tolerance| {
            let mesh = Mesh::new(profile(constant, order), Motor::None, tolerance).unwrap();
            let total: f64 = mesh.cells().iter().map(|cell| cell.width).sum();
            assert!((total - TAU).abs() < 1e-14);
            assert!(mesh.cells().windows(2).all(|pair| pair[0].high == pair[1].low));
            mesh.cells().len()
        };
        let few = count(0.5, 5, 1e-6);
        assert!(few < 40 && few < count(0.5, 5, 1e-12) && few < count(0.5, 64, 1e-6));
        // J falls to a billionth in the follower's dwell: cells are narrow at its ends and wide between them.
        assert!(count(1e-8, 5, 1e-9) < 2000);
    }

    #[test]
    fn an_angle_finds_its_cell() {
        let mesh = Mesh::new(profile(0.5, 5), Motor::None, 1e-9).unwrap();
        for (i, cell) in mesh.cells().iter().enumerate() {
            assert_eq!(mesh.find(0, cell.low, true), i);
            assert_eq!(mesh.find(0, cell.high, false), i);
            assert_eq!(mesh.find(0, 0.5 * (cell.low + cell.high), true), i);
        }
    }
}
