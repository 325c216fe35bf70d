//! Which profiles keep all bounds: a profile with room between them, or which of them contradict each other.
//!
//! The least t under which all conditions without level hold when each is widened by t, among the profiles within a
//! reach of the smallest one. Without a reach, bounds on one side in a short range would let profiles grow without limit.
//! Where the least t is above zero, the conditions whose multipliers are not zero contradict each other: by Farkas'
//! lemma no profile keeps these alone.
//!
//! Source: J. W. Chinneck, *Feasibility and Infeasibility in Optimization*, 2008, sections 2.1 and 6.2.

use super::Infeasible;
use super::exact::{Coordinates, RANK, dot};
use super::family::Family;
use super::polyhedron::Polyhedron;
use super::semi_infinite::{Frame, Goal, Place, Program, ROUNDS, thinned, unsolved};
use camdrive::numerics::double_double::Double;

/// Bounds that need to be widened by no more than this part of the task are kept: the roundings of what a user writes.
pub const KEPT: f64 = 1e-13;

/// The room that is made between conditions before anything else, as part of the task.
const ROOM: f64 = 1e-3;

/// The largest distances of a profile from the smallest one with the exact points, in units of the task: near by if possible.
/// Coefficients of a million times the task lose six of their sixteen digits; no cam keeps a condition that needs them.
const REACHES: [f64; 3] = [1.0, 1e3, 1e6];

/// The least t is known when what the conditions miss of it is this part of it, or a tenth of what counts as kept.
const KNOWN: f64 = 1e-9;

/// Multipliers below this part of their sum are rounding.
const COUNTS: f64 = 1e-9;

/// Rows of conditions that cancel to this part need no exact point to contradict each other; the reach may hold a millionth.
const CANCELS: f64 = 1e-4;

/// The least t and what holds it.
struct Widened {
    x: Vec<Double>,
    /// The least t of the conditions looked at.
    level: f64,
    /// The largest excess of a condition at x; negative: the room.
    excess: f64,
    /// The conditions that hold t, with their multipliers.
    holding: Vec<(Place, f64)>,
    /// True if the reach holds it too, so that a longer one may change it.
    reached: bool,
}

impl Program<'_> {
    /// A solution that fulfils all conditions without level, with some room where they leave it; else which of them
    /// cannot be kept, and by how much, when all are widened alike.
    pub fn inside(&self, centre: Vec<Double>) -> Result<Vec<Double>, Infeasible> {
        let mut families: Vec<Family> = self.families.iter().filter(|f| f.level == 0.0).cloned().collect();
        if families.is_empty() {
            return Ok(centre);
        }
        families.iter_mut().for_each(|f| f.level = 1.0);
        let program = Program { families, goal: Goal::Level, ..*self };
        if program.largest_violation(&centre, 0.0) <= -0.5 * ROOM {
            return Ok(centre);
        }
        let mut best: Option<Widened> = None;
        for reach in REACHES {
            if let Some(widened) = program.widened(&self.solutions.particular, reach) {
                let enough = widened.excess <= -0.5 * ROOM || !widened.reached;
                best = Some(widened);
                if enough {
                    break;
                }
            }
        }
        match best {
            None => Err(unsolved()),
            Some(widened) if widened.level <= KEPT => Ok(widened.x),
            Some(widened) => Err(self.contradiction(&program, &widened)),
        }
    }

    /// The least widening within a reach of the centre, as far as it is found.
    fn widened(&self, centre: &[Double], reach: f64) -> Option<Widened> {
        let mut best = None;
        let coordinates = Coordinates::new(self.solutions.factors(&self.solutions.free, RANK), false);
        let n = coordinates.len();
        let frame = Frame { centre, unit: 1.0, coordinates: &coordinates };
        let mut program = Polyhedron::new(n + 1);
        let mut add = |i: usize, sign: f64, limit: f64| {
            let mut row = vec![Double::default(); n + 1];
            row[i] = Double::from(sign);
            program.add(row, Double::from(limit));
        };
        (0..n).flat_map(|i| [(i, 1.0), (i, -1.0)]).for_each(|(i, sign)| add(i, sign, reach));
        add(n, -1.0, ROOM);
        let (first, mut looked_at, mut places) = (2 * n + 1, Vec::new(), thinned(self.first_places()));
        for _ in 0..ROUNDS {
            for place in &places {
                let (row, limit) = self.condition(&frame, *place);
                program.add(row, limit);
            }
            looked_at.append(&mut places);
            let known = |level: f64| (KNOWN * level.abs()).max(0.1 * KEPT);
            if !program.lowest(0.1 * known(program.point()[n].hi)) {
                break;
            }
            let (y, level) = program.point().split_at(n);
            let (x, level) = (self.moved(&frame, y), level[0].hi);
            let maxima = self.maxima(&x);
            let excess = maxima.iter().map(|place| self.violation(&x, 0.0, *place)).fold(f64::NEG_INFINITY, f64::max);
            let reached = program.multipliers().any(|(row, multiplier)| row < 2 * n && multiplier > 0.0);
            let holding = program.multipliers().filter(|(row, _)| *row >= first);
            let holding = holding.map(|(row, multiplier)| (looked_at[row - first], multiplier)).collect();
            best = Some(Widened { x: x.clone(), level, excess, holding, reached });
            let missed = known(level);
            if excess <= 0.5 * level || excess - level <= missed {
                break;
            }
            places = maxima;
            places.retain(|place| self.violation(&x, level, *place) > missed);
        }
        best
    }

    /// Why nothing keeps the conditions.
    fn contradiction(&self, program: &Program, widened: &Widened) -> Infeasible {
        let bound = |place: &Place| program.families[place.0].bound.unwrap_or(0);
        let mut holding = widened.holding.clone();
        // Besides the bounds, the peaks of several laws are conditions; they give way.
        holding.retain(|(place, _)| program.families[place.0].bound.is_some());
        holding.sort_by(|a, b| b.1.total_cmp(&a.1));
        let all: f64 = holding.iter().map(|(_, multiplier)| multiplier).sum();
        holding.retain(|(_, multiplier)| *multiplier > COUNTS * all);
        // The sum of the rows leaves the part that the exact points take up.
        let mut sum = vec![Double::default(); self.basis.size()];
        let mut size = 0.0_f64;
        let mut parts: Vec<(usize, f64)> = Vec::new();
        for (place, multiplier) in &holding {
            let row = program.families[place.0].row(self.basis, place.1, 0);
            size = size.max(multiplier * dot(&row, &row).hi.sqrt());
            super::exact::add_multiple(&mut sum, Double::from(*multiplier), &row);
            if parts.iter().all(|(index, _)| *index != bound(place)) {
                parts.push((bound(place), place.1));
            }
        }
        let points = !self.exact.is_empty() && dot(&sum, &sum).hi.sqrt() > CANCELS * size;
        let (index, phi) = parts.first().copied().unwrap_or((0, 0.0));
        let others = parts.split_off(1.min(parts.len()));
        Infeasible::Bound { index, by: widened.excess, phi, others, points }
    }
}
