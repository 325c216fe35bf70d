//! Optimisation under conditions that hold at every angle of a range: semi-infinite programs.
//!
//! Exchange method: the conditions are imposed at finitely many angles, the finite program is solved, the angles where
//! the solution violates a condition most are added, until none is left. It is posed for the distance from a centre, in
//! coordinates in which the sampled rows of the objective are orthonormal and in units of the largest violation at the
//! centre: it is well conditioned however narrow the ranges are.
//!
//! Each finite program has fewer conditions than the task, so that its level is a lower bound, and the largest violation
//! bounds the distance of the result from it; for a Chebyshev problem without bounds that is the method of Remez. Least
//! squares are the nearest point to the best one without conditions.
//!
//! With fewer maxima on the level than unknowns, linear programs only close in on the optimum round by round.
//! There Newton's method solves the equations of Karush, Kuhn and Tucker with the maxima as functions of x (the locally
//! reduced problem), whose curvature is Σ λᵢ aᵢ′ aᵢ′ᵀ/|gᵢ″|; with λ ≥ 0 they are sufficient, since the program is convex.
//!
//! Source: R. Hettich, K. O. Kortanek, "Semi-infinite programming: theory, methods, and applications", SIAM Review 35
//! (1993) 380–429, section 7; E. Ya. Remez (1934).

use super::Infeasible;
use super::basis::Basis;
use super::exact::{Coordinates, Factors, RANK, Solutions, add_multiple, dot};
use super::family::{Family, ROUNDING};
use super::polyhedron::Polyhedron;
use crate::work;
use camdrive::drives::Fault;
use camdrive::numerics::double_double::Double;

/// Rounds of the exchange; each adds all extremes, so that a handful is the rule.
pub const ROUNDS: usize = 60;

/// Violations below this part of the level end the exchange of the least level: the level has twelve digits then.
const RESOLVED: f64 = 1e-12;

/// Violations up to this part of the task are delivered, with a word of the report where they are more than rounding: a
/// thousandth of what a cam is made to.
const DELIVERED: f64 = 1e-9;

/// Unit of the coordinates in the null space of the squares, so large that it is as good as free: its square counts 1e-12.
const UNSEEN: f64 = 1e6;

/// Violations below this part of the task are none for least squares: a hundredth of what coefficients of sixteen digits
/// leave.
const RESOLVED_SQUARES: f64 = 1e-18;

/// The exchange goes on below that as long as each round leaves a tenth: an angle that is off by δ misses δ² of the level
/// but δ of the coefficients.
const FINEST: f64 = 1e-24;

/// The fault where the numbers do not suffice.
pub fn unsolved() -> Infeasible {
    let message = "the optimisation does not converge: with these harmonics the conditions differ by less than the rounding of \
                   thirty digits";
    Infeasible::Numerical(Fault::new(message).hint("take fewer harmonics, or longer ranges for the bounds"))
}

/// Newton's method begins where the linear programs miss this part of the level.
const NEAR: f64 = 1e-2;

/// Its steps, which square the error, and the length of the last one.
const NEWTON: usize = 12;
const SETTLED: f64 = 1e-12;

/// A maximum that Newton's method would move by less than this (rad) is one within its range, not at an end.
const STATIONARY: f64 = 1e-6;

/// If the objective sees less than this part, conditions without a level decide: there the coordinates are not
/// stretched, so that neither loses more than a dozen of its thirty digits.
const SEEN: f64 = 1e-12;

/// The quantity to be minimised.
pub enum Goal {
    /// The level t.
    Level,
    /// |A x − b|², rows of A.
    Squares(Vec<Vec<Double>>),
}

/// The least goal under equations and families of conditions.
pub struct Program<'a> {
    /// The functions of the profile.
    pub basis: &'a Basis,
    /// The x that fulfil the equations.
    pub solutions: &'a Solutions,
    /// The angles of the equations (rad): conditions look at them from the beginning, so that nothing dodges there.
    pub exact: &'a [f64],
    /// The conditions.
    pub families: Vec<Family>,
    /// The quantity to be minimised.
    pub goal: Goal,
}

/// A condition at one angle.
pub type Place = (usize, f64);

/// The coefficients and the level.
#[derive(Clone, Debug)]
pub struct Solution {
    /// x.
    pub x: Vec<Double>,
    /// t.
    pub level: f64,
    /// Uncertainty of the errors: the rounding of the numbers of thirty digits.
    pub resolution: f64,
    /// The largest change of a coefficient that this rounding may hide.
    pub uncertainty: f64,
    /// Remaining excess of the conditions.
    pub excess: f64,
}

/// The coordinates of a finite program: x = centre + unit · T y.
pub struct Frame<'a> {
    /// Fulfils the equations.
    pub centre: &'a [Double],
    /// Unit of y.
    pub unit: f64,
    /// T.
    pub coordinates: &'a Coordinates,
}

/// Every fourth place: enough for a first program, since the exchange adds what it misses.
pub fn thinned(places: Vec<Place>) -> Vec<Place> {
    places.into_iter().step_by(4).collect()
}

impl Program<'_> {
    /// The best solution, starting at `centre`, which fulfils the equations; of least squares it is the best one without
    /// conditions.
    pub fn solve(&self, centre: Vec<Double>) -> Result<Solution, Infeasible> {
        let squares = matches!(self.goal, Goal::Squares(_));
        // Contradicting conditions are reported first.
        let inside = self.inside(if squares { self.solutions.particular.clone() } else { centre.clone() })?;
        let centre = if squares { centre } else { inside };
        let mut places = self.first_places();
        let coordinates = self.coordinates(&places);
        let rounding = self.rounding(&places, &centre);
        let uncertainty = self.uncertainty(&coordinates, rounding);
        let highest = self.largest_violation(&centre, 0.0);
        if highest <= rounding {
            let level = highest.max(0.0);
            return Ok(Solution { x: centre, level, resolution: rounding, uncertainty, excess: 0.0 });
        }
        places = thinned(places);
        let frame = Frame { centre: &centre, unit: highest, coordinates: &coordinates };
        let resolved = |level: f64| if squares { RESOLVED_SQUARES } else { RESOLVED * level.abs() };
        let origin = vec![Double::default(); coordinates.len() + 1];
        let mut program = Polyhedron::new(origin.len());
        let mut proven: Option<Solution> = None;
        let (mut last, mut asked) = (f64::INFINITY, Vec::new());
        for _ in 0..ROUNDS {
            for place in &places {
                let (row, limit) = self.condition(&frame, *place);
                program.add(row, limit);
            }
            asked.append(&mut places);
            let tolerance = |level: f64| (FINEST * level.abs()).max(0.5 * rounding);
            let before = highest * program.point()[coordinates.len()].hi;
            let admitted = 0.01 * tolerance(before) / highest;
            let optimal = if squares { program.nearest(&origin, admitted) } else { program.lowest(admitted) };
            let (y, level) = program.point().split_at(coordinates.len());
            let (x, exact) = (self.moved(&frame, y), Double::from(highest) * level[0]);
            let (level, violation) = (exact.hi, |place: &Place| self.violation(&x, exact, *place));
            places = self.maxima(&x);
            let excess = places.iter().map(violation).fold(0.0, f64::max);
            let mut newton = Vec::new();
            let near = optimal && excess > tolerance(level) && excess <= NEAR * level.abs();
            if near && !squares && self.families.iter().all(|family| family.tangent.is_none()) {
                let holding = program.multipliers().map(|(row, multiplier)| (asked[row], multiplier)).collect();
                if let Some((x, exact)) = self.reduced(&frame, (x.clone(), exact), holding) {
                    let (level, mut maxima) = (exact.hi, self.maxima(&x));
                    let violation = |place: &Place| self.violation(&x, exact, *place);
                    let excess = maxima.iter().map(violation).fold(0.0, f64::max);
                    if excess <= resolved(level) {
                        proven = Some(Solution { x, level, resolution: rounding, uncertainty, excess });
                        break;
                    }
                    // Conditions that are exceeded near the optimum come next.
                    maxima.retain(|place| violation(place) > tolerance(level));
                    newton = maxima;
                }
            }
            places.retain(|place| violation(place) > tolerance(level));
            let resolution = rounding.max(excess - resolved(level));
            let found = Solution { x, level, resolution, uncertainty, excess };
            proven = match proven {
                _ if optimal => Some(found),
                // An uncertain optimum is one if it comes down to the level of fewer conditions.
                Some(last) if excess < last.excess && level + excess <= last.level + DELIVERED => Some(found),
                last => last,
            };
            let slow = excess <= resolved(level) && excess > 0.7 * last;
            if places.is_empty() || !optimal || slow {
                break;
            }
            last = excess;
            places.append(&mut newton);
        }
        // Conditions are kept to rounding, or nearly: the report shows the rest.
        proven.filter(|solution| solution.excess <= DELIVERED * solution.level.abs().max(1.0)).ok_or_else(unsolved)
    }

    /// The optimum next to (x, t) by Newton's method on the maxima that hold it; None where they are as many as the unknowns,
    /// so that the linear programs square the error themselves, and where it does not lead to an optimum.
    fn reduced(
        &self,
        frame: &Frame,
        (mut x, mut level): (Vec<Double>, Double),
        mut holding: Vec<(Place, f64)>,
    ) -> Option<(Vec<Double>, Double)> {
        let n = frame.coordinates.len();
        let mut last = f64::INFINITY;
        for _ in 0..NEWTON {
            holding = self.held(&x, &holding).filter(|held| held.len() <= n)?;
            let (mut rows, mut values, mut curved) = (Vec::new(), Vec::new(), Vec::new());
            for &(place, multiplier) in &holding {
                let family = &self.families[place.0];
                rows.push(self.condition(frame, place).0);
                values.push(Double::from(-self.violation(&x, level, place) / frame.unit));
                let [slope, bend] = [1, 2].map(|n| family.excess(self.basis, &x, place.1, n));
                if bend < 0.0 && slope.abs() <= STATIONARY * -bend {
                    let size = Double::from((multiplier * frame.unit / -bend).sqrt());
                    let turned = self.projected(frame.coordinates, &family.row(self.basis, place.1, 1));
                    curved.push(turned.into_iter().map(|a| a * size).chain([Double::default()]).collect::<Vec<_>>());
                }
            }
            // τ + ½ |C d|² is least among all d that keep the maxima at the level.
            let bent = |d: &[Double]| {
                let mut sum = vec![Double::default(); n + 1];
                curved.iter().for_each(|row| add_multiple(&mut sum, dot(row, d), row));
                sum
            };
            let kept = Solutions::new(&rows, &values, n + 1, RANK);
            let downhill = |d: &[Double]| {
                let mut slope = bent(d);
                slope[n] = slope[n] + Double::from(1.0);
                slope.iter().map(|s| -*s).collect::<Vec<Double>>()
            };
            let columns: Vec<_> = kept.free.iter().map(|free| kept.projected(&bent(free))).collect();
            let size = columns.len();
            let way = Factors::new(columns, size, RANK).solve(&kept.projected(&downhill(&kept.particular)));
            let step = kept.moved(&kept.particular, &way);
            let multipliers = Factors::new(rows, n + 1, RANK).solve(&downhill(&step));
            holding.iter_mut().zip(multipliers).for_each(|(held, multiplier)| held.1 = multiplier.hi);
            x = self.moved(&Frame { centre: &x, ..*frame }, &step[..n]);
            level = level + step[n] * Double::from(frame.unit);
            let length = dot(&step, &step).hi.sqrt();
            if holding.iter().any(|held| !(held.1 >= 0.0)) || !(length < last) {
                return None;
            }
            if length <= SETTLED {
                return Some((x, level));
            }
            last = length;
        }
        None
    }

    /// The maxima at x that these places have become, with the sum of their multipliers; None where one is lost.
    fn held(&self, x: &[Double], holding: &[(Place, f64)]) -> Option<Vec<(Place, f64)>> {
        let maxima = self.maxima(x);
        let mut held: Vec<(Place, f64)> = Vec::new();
        for ((family, phi), multiplier) in holding.iter().filter(|held| held.1 > 0.0) {
            let away = |place: &&Place| (place.1 - phi).abs();
            let own = maxima.iter().filter(|place| place.0 == *family);
            let place = *own.min_by(|a, b| away(a).total_cmp(&away(b)))?;
            match held.iter_mut().find(|held| held.0 == place) {
                Some(held) => held.1 += multiplier,
                None => held.push((place, *multiplier)),
            }
        }
        Some(held)
    }

    /// The angles that the first program looks at.
    pub fn first_places(&self) -> Vec<Place> {
        let of = |(i, family): (usize, &Family)| -> Vec<Place> {
            let exact = self.exact.iter().flat_map(|phi| family.within(*phi));
            family.first_angles(self.basis).into_iter().chain(exact).map(|phi| (i, phi)).collect()
        };
        self.families.iter().enumerate().flat_map(of).collect()
    }

    /// Coordinates in which the rows of the objective are orthonormal.
    fn coordinates(&self, places: &[Place]) -> Coordinates {
        let of_goal = places.iter().filter(|(i, _)| self.families[*i].level != 0.0);
        let mut rows: Vec<Vec<Double>> = of_goal.map(|&(i, phi)| self.families[i].row(self.basis, phi, 0)).collect();
        if let Goal::Squares(a) = &self.goal {
            rows.extend(a.iter().cloned());
        }
        let conditions = self.families.iter().any(|family| family.level == 0.0);
        let (rank, unseen) = match &self.goal {
            Goal::Squares(_) => (RANK, UNSEEN),
            Goal::Level => (if conditions { SEEN } else { RANK }, 1.0),
        };
        Coordinates::new(self.solutions.factors(&rows, rank), conditions).with_unseen(unseen)
    }

    /// Uncertainty of the sums of the conditions.
    fn rounding(&self, places: &[Place], x: &[Double]) -> f64 {
        let rounding = |&(i, phi): &Place| self.families[i].rounding(self.basis, x, phi);
        let of_conditions = places.iter().map(rounding).fold(0.0, f64::max);
        let of_goal = match &self.goal {
            Goal::Level => 0.0,
            Goal::Squares(a) => {
                let terms = |row: &Vec<Double>| row.iter().zip(x).map(|(row, x)| (row.hi * x.hi).abs()).sum::<f64>();
                a.iter().map(terms).fold(0.0, f64::max)
            }
        };
        of_conditions.max(ROUNDING * of_goal)
    }

    /// The largest change of a coefficient while the objective changes by rounding.
    fn uncertainty(&self, coordinates: &Coordinates, rounding: f64) -> f64 {
        let mut squares = vec![0.0; self.basis.size()];
        for i in 0..coordinates.len() {
            let mut y = vec![Double::default(); coordinates.len()];
            y[i] = Double::from(rounding);
            let step = self.solutions.moved(&vec![Double::default(); squares.len()], &coordinates.vector(&y));
            squares.iter_mut().zip(step).for_each(|(sum, s)| *sum += s.hi * s.hi);
        }
        squares.into_iter().fold(0.0, f64::max).sqrt()
    }

    pub fn maxima(&self, x: &[Double]) -> Vec<Place> {
        let of = |(i, family): (usize, &Family)| -> Vec<Place> {
            family.maxima(self.basis, x).into_iter().map(|phi| (i, phi)).collect()
        };
        self.families.iter().enumerate().flat_map(of).collect()
    }

    /// Violation of a condition (negative: reserve).
    pub fn violation(&self, x: &[Double], level: impl Into<Double>, (i, phi): Place) -> f64 {
        let family = &self.families[i];
        let excess = family.excess_exactly(self.basis, x, phi, 0) - Double::from(family.limit);
        (excess - Double::from(family.level) * level.into()).hi
    }

    pub fn largest_violation(&self, x: &[Double], level: f64) -> f64 {
        self.maxima(x).into_iter().map(|p| self.violation(x, level, p)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// centre + unit · T y.
    pub fn moved(&self, frame: &Frame, y: &[Double]) -> Vec<Double> {
        let unit = Double::from(frame.unit);
        let y: Vec<Double> = y.iter().map(|y| *y * unit).collect();
        self.solutions.moved(frame.centre, &frame.coordinates.vector(&y))
    }

    /// A condition as a row over y and τ, the level over the unit, and its limit.
    pub fn condition(&self, frame: &Frame, (i, phi): Place) -> (Vec<Double>, Double) {
        let family = &self.families[i];
        work::draw(1.5 * work::PRECISE * (self.basis.size() as f64).powi(2));
        let mut row = self.projected(frame.coordinates, &family.row(self.basis, phi, 0));
        row.push(Double::from(-family.level));
        let excess = family.excess_exactly(self.basis, frame.centre, phi, 0);
        (row, (Double::from(family.limit) - excess).divide(Double::from(frame.unit)))
    }

    /// A row in the coordinates of the program.
    fn projected(&self, coordinates: &Coordinates, row: &[Double]) -> Vec<Double> {
        coordinates.row(&self.solutions.projected(row))
    }
}
