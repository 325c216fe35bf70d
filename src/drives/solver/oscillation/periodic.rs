//! The periodic solution at constant speed and its stability.

use super::steps::Moving;
use super::turn::{Table, Turn};
use crate::drives::follower::equation::{Equation, Words};
use crate::drives::limits::{NEUTRAL, RESONANCE, no_periodic_motion, open, periodic_motion_that, search_too_much};
use crate::drives::shaft::cam_turn::turns;
use crate::drives::solver::step_control::StepControl;
use crate::drives::{Fault, Rounded};
use crate::numerics::angle::WHOLE_TURN;
use crate::numerics::collocation::Collocation;
use crate::numerics::double_double::Double;
use crate::numerics::period_map::{Affine, Period, fixed_point, is_resonant, spectral_radius};

/// Newton iterations for the nonlinear equation; they double the digits, so more mean that there is no solution near.
const ITERATIONS: usize = 12;

/// Turns from the start before each attempt of Newton's method. Where a turn halves what is left of the start, ten turns lead to the
/// motion; where it leaves 97 % of it, all 310 leave a ten-thousandth.
const RUN_IN: [usize; 5] = [10, 20, 40, 80, 160];

/// A motion is like the linear one if its state at the start differs from that one's by this part.
const LIKE: f64 = 0.1;

/// The tolerance on the way to a motion. Newton's method ends with the requested one.
const COARSE: f64 = 1e-7;

/// Newton's method takes the requested tolerance once its corrections are this part of the motion.
const NEAR: f64 = 1e-5;

/// A multiplier counts as 1 if det(I − M) is this part of its terms.
const RESONANT: f64 = 1e-10;

/// A periodic motion.
pub struct Found {
    /// (q, q̇) at the start.
    pub state: [f64; 2],
    /// ln of the factor by which a small disturbance grows in a turn.
    pub growth: f64,
    /// The columns of the map of small disturbances over a turn, q̇ as a part of ω q.
    pub map: [[f64; 2]; 2],
}

/// (q, q̇) one turn after `start`.
fn one_turn<E: Equation>(moving: &mut Moving<E>, start: f64, y: [f64; 2], tolerance: f64) -> Result<[f64; 2], Fault> {
    let w = moving.motion.coefficients[1].abs();
    let end = Double::from(start) + WHOLE_TURN.divide(Double::from(w));
    let mut integrator = Collocation::new(Double::from(start), y);
    moving.locate(Double::from(start), &y);
    let reached = moving.integrate(&mut integrator, end, end, StepControl::Tolerance(tolerance));
    reached.map_err(|fault| {
        let Words { frequency, .. } = moving.equation.words();
        if moving.work.is_exhausted() {
            search_too_much(&format!(
                "check {frequency}, lower the speed, relax solver.tolerance, or choose at_rest or given"
            ))
        } else {
            no_periodic_motion(fault.to_string(), "")
        }
    })?;
    Ok(integrator.state())
}

/// The map of (q, q̇) over a turn near a `point`, y ↦ shift + M (y − point), M by central differences over `size`.
fn turn_map<E: Equation>(
    moving: &mut Moving<E>,
    start: f64,
    point: [f64; 2],
    size: [f64; 2],
    tolerance: f64,
) -> Result<Affine, Fault> {
    let shift = one_turn(moving, start, point, tolerance)?;
    let mut matrix = [[0.0; 2]; 2];
    for c in 0..2 {
        let mut at = |sign: f64| {
            let mut y = point;
            y[c] += sign * size[c];
            one_turn(moving, start, y, tolerance)
        };
        let (plus, minus) = (at(1.0)?, at(-1.0)?);
        for r in 0..2 {
            matrix[r][c] = (plus[r] - minus[r]) / (2.0 * size[c]);
        }
    }
    Ok(Affine { matrix, shift })
}

/// The periodic motion at `start`, stable or not; the nonlinear one is searched from the linear one and from the state `given`.
pub fn periodic<E: Equation>(
    moving: &mut Moving<E>,
    table: &Table<E>,
    start: f64,
    given: [f64; 2],
    tolerance: f64,
) -> Result<Found, Fault> {
    let (equation, law, [phi, w, ..]) = (moving.equation, moving.law, moving.motion.coefficients);
    if !turns(w) {
        let state = equation.at_rest(law, &moving.flow(Double::from(start), &[0.0; 2]))?;
        return Ok(Found { state, growth: 0.0, map: [[0.0; 2]; 2] });
    }
    if equation.is_linear() {
        let map = match &table.whole {
            Some(whole) => whole.map,
            None => linear(moving, start, tolerance)?,
        };
        let state = fixed(&map, equation, w)?;
        let matrix = if table.whole.is_some() { power(&map, equation.symmetry(law)).matrix } else { map.matrix };
        // The growth over a table is known to more digits.
        let growth = if equation.has_input() { growth(&map.matrix, equation.is_undamped()) } else { table.growth };
        return Ok(Found { state, growth, map: columns(&matrix, equation, w) });
    }
    let linear = equation.linearised();
    let period = Turn::new(&linear, law, w, phi).and_then(|turn| Period::of(&turn, tolerance));
    let guess = period.and_then(|whole| fixed_point(&whole.map.matrix, [0.0; 2], whole.map.shift));
    let guess = guess.unwrap_or_default();
    // Far from the linear one there may be several stable motions.
    let is_like = |[q, v]: [f64; 2]| {
        let size = |[q, v]: [f64; 2]| q.powi(2) + (v / w).powi(2);
        size([q - guess[0], v - guess[1]]) <= LIKE * LIKE * size([q, v])
    };
    let found = match shoot(moving, start, guess, tolerance)? {
        Some(found) if found.growth < NEUTRAL && (equation.is_undamped() || is_like(found.state)) => return Ok(found),
        found => found,
    };
    if equation.is_undamped() {
        // Nothing leads to a motion.
        let near = if found.is_none() { shoot(moving, start, given, tolerance)? } else { found };
        let reason = "no motion that repeats every turn was found near the linear one or the start";
        let rest = "; set a damping above 0, change drive.w, or set start.mode = at_rest";
        return near.ok_or_else(|| no_periodic_motion(reason, rest));
    }
    run_in(moving, start, given, tolerance, found)
}

/// The fixed point of the map of a linear equation over its period.
fn fixed<E: Equation>(map: &Affine, equation: &E, w: f64) -> Result<[f64; 2], Fault> {
    // Without a load it stays at rest, whatever free motions do.
    if map.shift == [0.0; 2] {
        return Ok([0.0; 2]);
    }
    if is_resonant(&map.matrix, RESONANT) {
        let Words { damping, .. } = equation.words();
        let rest = format!("; set {damping} > 0, change drive.w, or set start.mode = at_rest");
        return Err(no_periodic_motion(RESONANCE, &rest));
    }
    let point = fixed_point(&map.matrix, [0.0; 2], map.shift);
    point.ok_or_else(|| refused(w, "no periodic solution of the period of one turn was found"))
}

/// The map of a turn of a linear equation whose period is too long to be tabulated: three turns show it.
fn linear<E: Equation>(moving: &mut Moving<E>, start: f64, tolerance: f64) -> Result<Affine, Fault> {
    let frequency = moving.equation.pace(moving.law, [0.0; 2]).frequency;
    let shift = one_turn(moving, start, [0.0; 2], tolerance)?;
    // As large as the motion, so that neither is lost in the roundings of the other; any size at rest.
    let q = shift[0].abs().max(shift[1].abs() / frequency).max(1e-9);
    let mut matrix = [[0.0; 2]; 2];
    for (c, size) in [q, q * frequency].into_iter().enumerate() {
        let mut y = [0.0; 2];
        y[c] = size;
        let end = one_turn(moving, start, y, tolerance)?;
        for r in 0..2 {
            matrix[r][c] = (end[r] - shift[r]) / size;
        }
    }
    Ok(Affine { matrix, shift })
}

/// Lets the nonlinear drive approach its attractor from the state `y`, and finds the periodic motion there. If none is stable, the
/// `other` one, which was found elsewhere.
fn run_in<E: Equation>(
    moving: &mut Moving<E>,
    start: f64,
    mut y: [f64; 2],
    tolerance: f64,
    mut other: Option<Found>,
) -> Result<Found, Fault> {
    let mut turns = 0;
    for block in RUN_IN {
        for _ in 0..block {
            match one_turn(moving, start, y, tolerance.max(COARSE)) {
                Ok(next) => y = next,
                Err(fault) if moving.work.is_exhausted() => {
                    return other.ok_or_else(|| fault.motionless(open(turns)));
                }
                Err(fault) => return Err(fault),
            }
            turns += 1;
        }
        match shoot(moving, start, y, tolerance) {
            Ok(Some(found)) if found.growth < NEUTRAL => return Ok(found),
            Ok(found) => other = found.or(other),
            Err(fault) => return other.ok_or_else(|| fault.motionless(open(turns))),
        }
    }
    other.ok_or_else(|| {
        no_periodic_motion(open(turns), "; change drive.w, raise the damping, or set start.mode = at_rest")
    })
}

/// Newton's method on the turn map of the nonlinear equation; None if it does not converge.
fn shoot<E: Equation>(
    moving: &mut Moving<E>,
    start: f64,
    guess: [f64; 2],
    tolerance: f64,
) -> Result<Option<Found>, Fault> {
    let frequency = moving.equation.pace(moving.law, guess).frequency;
    let (mut y, mut within) = (guess, tolerance.max(COARSE));
    for _ in 0..ITERATIONS {
        // Differences over 1e-4 of the motion: a truncation of 1e-8 and a rounding of 1e-10 of it.
        let q = y[0].abs().max(y[1].abs() / frequency).max(1e-9);
        let size = [1e-4 * q, 1e-4 * q * frequency];
        let map = match turn_map(moving, start, y, size, within) {
            Ok(map) => map,
            Err(fault) if moving.work.is_exhausted() => return Err(fault),
            Err(_) => return Ok(None),
        };
        let Some(next) = fixed_point(&map.matrix, y, map.shift) else { return Ok(None) };
        let change = (next[0] - y[0]).abs().max((next[1] - y[1]).abs() / frequency);
        y = next;
        if change > 1.0 {
            // More than a radian in one correction: the guess was not near a solution.
            return Ok(None);
        }
        if change <= tolerance * q && within == tolerance {
            let Moving { equation, motion, .. } = moving;
            let growth = growth(&map.matrix, equation.is_undamped());
            let map = columns(&map.matrix, *equation, motion.coefficients[1]);
            return Ok(Some(Found { state: y, growth, map }));
        }
        if change <= NEAR * q {
            within = tolerance;
        }
    }
    Ok(None)
}

/// A turn without damping keeps areas: its determinant is 1, and deviates by the errors of the map.
fn error_of_area([[a, b], [c, d]]: &[[f64; 2]; 2], undamped: bool) -> f64 {
    if undamped { (a * d - b * c).sqrt() } else { 1.0 }
}

/// ln of the larger multiplier of a turn.
fn growth(matrix: &[[f64; 2]; 2], undamped: bool) -> f64 {
    (spectral_radius(matrix) / error_of_area(matrix, undamped)).ln()
}

/// The columns of a turn's matrix, q̇ as a part of ω q.
fn columns<E: Equation>([[a, b], [c, d]]: &[[f64; 2]; 2], equation: &E, w: f64) -> [[f64; 2]; 2] {
    let area = error_of_area(&[[*a, *b], [*c, *d]], equation.is_undamped());
    [[*a, c / w.abs()], [b * w.abs(), *d]].map(|column| column.map(|x| x / area))
}

/// The map of so many equal parts of a turn.
fn power(part: &Affine, parts: usize) -> Affine {
    (1..parts).fold(*part, |whole, _| part.after(&whole))
}

/// The fault of a motion whose disturbances grow at the speed `w` (rad/s).
pub fn unstable(growth: f64, w: f64) -> Fault {
    let growth = Rounded(growth);
    refused(w, &format!("the periodic solution is unstable, free vibrations grow by exp({growth}) in a turn"))
}

fn refused(w: f64, why: &str) -> Fault {
    let predicate = format!("is refused at drive.w = {} rad/s: {why}", Rounded(w));
    periodic_motion_that(&predicate, "; change drive.w, raise the damping, or set start.mode = at_rest")
}
