//! The periodic solution at constant speed and its stability.

use super::steps::Moving;
use super::turn::{Table, Turn};
use crate::drives::follower::equation::{Equation, Words};
use crate::drives::limits::{no_periodic_motion, periodic_motion_that, search_too_much};
use crate::drives::shaft::cam_turn::turns;
use crate::drives::solver::step_control::StepControl;
use crate::drives::{Fault, Rounded};
use crate::numerics::angle::WHOLE_TURN;
use crate::numerics::collocation::Collocation;
use crate::numerics::double_double::Double;
use crate::numerics::period_map::{Affine, Period, fixed_point, spectral_radius};

/// Newton iterations for the nonlinear equation; they double the digits, so more mean that there is no solution near.
const ITERATIONS: usize = 20;

/// Turns for which the nonlinear drive runs in if Newton's method fails from the linear solution.
const RUN_IN: usize = 300;

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

/// The periodic (q, q̇) at `start`; refused if it is not found or does not attract.
pub fn periodic<E: Equation>(
    moving: &mut Moving<E>,
    table: &Table<E>,
    start: f64,
    tolerance: f64,
) -> Result<[f64; 2], Fault> {
    let (equation, law, [phi, w, ..]) = (moving.equation, moving.law, moving.motion.coefficients);
    if !turns(w) {
        return equation.at_rest(law, &moving.flow(Double::from(start), &[0.0; 2]));
    }
    if equation.is_undamped() {
        let Words { damping, .. } = equation.words();
        return Err(periodic_motion_that(
            &format!("does not exist without damping: {damping} = 0 leaves Floquet multipliers of modulus 1"),
            &format!("; without damping free vibrations never die out; set {damping} > 0, or start.mode = at_rest"),
        ));
    }
    let fixed = |whole: &Period| fixed_point(&whole.map.matrix, [0.0; 2], whole.map.shift);
    if equation.is_linear() {
        refuse_unstable(table.growth, w)?;
        let point = match &table.whole {
            Some(whole) => fixed(whole),
            None => linear(moving, start, tolerance)?,
        };
        return point.ok_or_else(|| refused(w, "no periodic solution of the period of one turn was found"));
    }
    let linear = equation.linearised();
    let period = Turn::new(&linear, law, w, phi).and_then(|turn| Period::of(&turn, tolerance));
    let guess = period.as_ref().and_then(fixed).unwrap_or([0.0; 2]);
    match shoot(moving, start, guess, tolerance)? {
        Some((y, map)) if spectral_radius(&map.matrix) < 1.0 => Ok(y),
        _ => run_in(moving, start, tolerance),
    }
}

/// The fixed point of the turn map of a linear equation whose period is too long to be tabulated: three turns show the map.
fn linear<E: Equation>(moving: &mut Moving<E>, start: f64, tolerance: f64) -> Result<Option<[f64; 2]>, Fault> {
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
    Ok(fixed_point(&matrix, [0.0; 2], shift))
}

/// Lets the nonlinear drive approach its attractor, then finds the periodic solution there.
fn run_in<E: Equation>(moving: &mut Moving<E>, start: f64, tolerance: f64) -> Result<[f64; 2], Fault> {
    let (mut y, w) = ([0.0, 0.0], moving.motion.coefficients[1]);
    for _ in 0..RUN_IN {
        y = one_turn(moving, start, y, tolerance)?;
    }
    let found = shoot(moving, start, y, tolerance)?;
    let (y, map) = found.ok_or_else(|| refused(w, "no periodic solution of the period of one turn was found"))?;
    refuse_unstable(spectral_radius(&map.matrix).ln(), w)?;
    Ok(y)
}

/// Newton's method on the turn map of the nonlinear equation; None if it does not converge.
fn shoot<E: Equation>(
    moving: &mut Moving<E>,
    start: f64,
    guess: [f64; 2],
    tolerance: f64,
) -> Result<Option<([f64; 2], Affine)>, Fault> {
    let frequency = moving.equation.pace(moving.law, guess).frequency;
    let mut y = guess;
    for _ in 0..ITERATIONS {
        // Differences over 1e-4 of the motion: a truncation of 1e-8 and a rounding of 1e-10 of it.
        let q = y[0].abs().max(y[1].abs() / frequency).max(1e-9);
        let size = [1e-4 * q, 1e-4 * q * frequency];
        let map = turn_map(moving, start, y, size, tolerance)?;
        let Some(next) = fixed_point(&map.matrix, y, map.shift) else { return Ok(None) };
        let change = (next[0] - y[0]).abs().max((next[1] - y[1]).abs() / frequency);
        y = next;
        if change > 1.0 {
            // More than a radian in one correction: the guess was not near a solution.
            return Ok(None);
        }
        if change <= tolerance * q {
            return Ok(Some((y, map)));
        }
    }
    Ok(None)
}

fn refuse_unstable(growth: f64, w: f64) -> Result<(), Fault> {
    if growth < 0.0 {
        return Ok(());
    }
    let growth = Rounded(growth);
    Err(refused(w, &format!("the periodic solution is unstable, free vibrations grow by exp({growth}) in a turn")))
}

fn refused(w: f64, why: &str) -> Fault {
    let predicate = format!("is refused at drive.w = {} rad/s: {why}", Rounded(w));
    periodic_motion_that(&predicate, "; change drive.w, raise the damping, or set start.mode = at_rest")
}
