//! The periodic solution at constant speed and its stability.

use super::solver::Twist;
use crate::drives::cam_turn::turns;
use crate::drives::limits::{refused_start, search_too_much};
use crate::drives::step_control::StepControl;
use crate::drives::{Fault, Number};
use crate::numerics::angle::WHOLE_TURN;
use crate::numerics::collocation::Collocation;
use crate::numerics::double_double::Double;
use crate::numerics::period_map::{PeriodMap, fixed_point, spectral_radius};

/// Newton iterations for the nonlinear equation; it doubles the digits, so more mean that there is no solution near.
const ITERATIONS: usize = 20;

/// Turns for which the nonlinear drive runs in where Newton's method fails from the linear solution.
const RUN_IN: usize = 300;

/// The map of (q, q̇) over a turn near a point: y ↦ image + M (y − point).
pub struct TurnMap {
    /// M, the monodromy matrix.
    pub monodromy: [[f64; 2]; 2],
    /// Where the point goes.
    pub image: [f64; 2],
}

impl TurnMap {
    /// The largest modulus of the eigenvalues of M, the Floquet multipliers.
    pub fn spectral_radius(&self) -> f64 {
        spectral_radius(&self.monodromy)
    }

    /// The fixed point of the map near `point`.
    fn fixed_point(&self, point: [f64; 2]) -> Option<[f64; 2]> {
        fixed_point(&self.monodromy, point, self.image)
    }
}

/// (q, q̇) one turn after `start`.
fn one_turn(twist: &mut Twist, start: f64, y: [f64; 2], tolerance: f64) -> Result<[f64; 2], Fault> {
    let w = twist.motion.coefficients[1].abs();
    let end = Double::from(start) + WHOLE_TURN.divide(Double::from(w));
    let mut integrator = Collocation::new(Double::from(start), y);
    twist.locate(Double::from(start), &y);
    let reached = twist.reach(&mut integrator, end, StepControl::Tolerance(tolerance));
    reached.map_err(|fault| {
        let hint = "check c and J, lower the speed, relax solver.tolerance, or choose at_rest or given";
        if twist.work.is_exhausted() {
            search_too_much(hint)
        } else {
            refused_start(format!("start.mode = steady_state: {fault}"))
        }
    })?;
    Ok(integrator.state())
}

/// The turn map of the linear equation: two free motions and the forced one from rest.
pub fn linear_map(twist: &mut Twist, start: f64, tolerance: f64) -> Result<TurnMap, Fault> {
    let linear = twist.equation.linear;
    (twist.equation.linear, twist.forced) = (true, 0.0);
    let first = one_turn(twist, start, [1.0, 0.0], tolerance);
    let second = one_turn(twist, start, [0.0, 1.0], tolerance);
    twist.forced = 1.0;
    let image = one_turn(twist, start, [0.0, 0.0], tolerance);
    twist.equation.linear = linear;
    let (first, second) = (first?, second?);
    Ok(TurnMap { monodromy: [[first[0], second[0]], [first[1], second[1]]], image: image? })
}

/// The turn map of the nonlinear equation near `point`, M by central differences over `size`.
fn nonlinear_map(
    twist: &mut Twist,
    start: f64,
    point: [f64; 2],
    size: [f64; 2],
    tolerance: f64,
) -> Result<TurnMap, Fault> {
    let image = one_turn(twist, start, point, tolerance)?;
    let mut monodromy = [[0.0; 2]; 2];
    for c in 0..2 {
        let mut at = |sign: f64| {
            let mut y = point;
            y[c] += sign * size[c];
            one_turn(twist, start, y, tolerance)
        };
        let (plus, minus) = (at(1.0)?, at(-1.0)?);
        for r in 0..2 {
            monodromy[r][c] = (plus[r] - minus[r]) / (2.0 * size[c]);
        }
    }
    Ok(TurnMap { monodromy, image })
}

/// The periodic (q, q̇) at `start`; refused where it is not found or does not attract.
pub fn periodic(twist: &mut Twist, start: f64, tolerance: f64, table: Option<&PeriodMap>) -> Result<[f64; 2], Fault> {
    if !turns(twist.motion.coefficients[1]) {
        // A drive at rest: the spring is relaxed.
        return Ok([0.0, 0.0]);
    }
    if twist.equation.b == 0.0 {
        return Err(refused_start(
            "start.mode = steady_state does not exist without damping: b = 0 N·m·s/rad leaves Floquet multipliers of \
             modulus 1, free vibrations never die out; set b > 0, or start.mode = at_rest",
        ));
    }
    let map = match table {
        Some(table) => TurnMap { monodromy: table.period_map().matrix, image: table.period_map().shift },
        None => linear_map(twist, start, tolerance)?,
    };
    if twist.equation.linear {
        refuse_unstable(&map, twist)?;
        return map.fixed_point([0.0, 0.0]).ok_or_else(|| not_found(twist));
    }
    let guess = map.fixed_point([0.0, 0.0]).unwrap_or([0.0, 0.0]);
    match shoot(twist, start, guess, tolerance)? {
        Some((y, map)) if map.spectral_radius() < 1.0 => Ok(y),
        _ => run_in(twist, start, tolerance),
    }
}

/// Lets the nonlinear drive approach its attractor, then finds the periodic solution there.
fn run_in(twist: &mut Twist, start: f64, tolerance: f64) -> Result<[f64; 2], Fault> {
    let mut y = [0.0, 0.0];
    for _ in 0..RUN_IN {
        y = one_turn(twist, start, y, tolerance)?;
    }
    let (y, map) = shoot(twist, start, y, tolerance)?.ok_or_else(|| not_found(twist))?;
    refuse_unstable(&map, twist)?;
    Ok(y)
}

/// Newton's method on the turn map of the nonlinear equation; None where it does not converge.
fn shoot(twist: &mut Twist, start: f64, guess: [f64; 2], tolerance: f64) -> Result<Option<([f64; 2], TurnMap)>, Fault> {
    let frequency = (twist.equation.c / twist.equation.inertia).sqrt();
    let mut y = guess;
    for _ in 0..ITERATIONS {
        // Differences over 1e-4 of the motion: a truncation of 1e-8 of it, a rounding of 1e-10.
        let q = y[0].abs().max(y[1].abs() / frequency).max(1e-9);
        let size = [1e-4 * q, 1e-4 * q * frequency];
        let map = nonlinear_map(twist, start, y, size, tolerance)?;
        let Some(next) = map.fixed_point(y) else { return Ok(None) };
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

fn refuse_unstable(map: &TurnMap, twist: &Twist) -> Result<(), Fault> {
    let radius = map.spectral_radius();
    if radius < 1.0 {
        return Ok(());
    }
    Err(refused_start(format!(
        "start.mode = steady_state is refused: the periodic solution at drive.w = {} rad/s is unstable, its largest \
         Floquet multiplier over a turn is {radius:.6} (it must be below 1); change drive.w, raise b, or set \
         start.mode = at_rest",
        Number(twist.motion.coefficients[1])
    )))
}

fn not_found(twist: &Twist) -> Fault {
    refused_start(format!(
        "start.mode = steady_state: no periodic solution of the period of one turn was found at drive.w = {} rad/s; \
         change drive.w, or set start.mode = at_rest",
        Number(twist.motion.coefficients[1])
    ))
}
