//! The periodic motion of a train by shooting over a turn.
//!
//! The section is φ = φ(0) modulo 2π, the unknowns s are all states except φ; for a driven shaft all states. Some turns from a
//! guess come near the motion; Newton's method then solves s = P(s), with the derivatives of the map P of a turn by differences.
//! Its multipliers, the eigenvalues of ∂P/∂s, decide about stability. The gap of a mass in contact at the section is no unknown.
//!
//! Source: A. H. Nayfeh, B. Balachandran, *Applied Nonlinear Dynamics*, Wiley 1995, sections 6.1, 7.3.

use super::{Excitation, Run};
use crate::drives::limits::{NOT_REPEATED, no_periodic_motion, open, search_too_much};
use crate::drives::shaft::train::{MOST_FOLLOWERS, MOST_STATES, Modes, Train};
use crate::drives::{EventLog, Fault};
use crate::numerics::double_double::Double;
use crate::numerics::lu;
use crate::numerics::work::Work;
use std::f64::consts::TAU;

/// Turns from the guess on before each attempt of Newton's method: in the first ones vibrations with D = 0.02 in six periods a turn
/// decay to 1e-5, in all of them those that decay by a tenth a turn.
const TURNS: [usize; 3] = [16, 32, 64];
/// Newton's method doubles the digits; from a good start a few iterations are enough.
const ITERATIONS: usize = 12;
/// The change of a state for differences, as part of its largest value: half of the digits for Newton's method. For the multipliers
/// a third of them on both sides, where neglected terms and roundings are about equal.
const STEPS: [f64; 2] = [1e-7, 1e-4];
/// Above this multiplier a motion counts as unstable, far above the roundings of the differences.
pub const STABLE: f64 = 1.0 + 1e-6;
/// A turn repeats itself if the states change by less than this part.
const CLOSED: f64 = 1e-11;
/// The tolerance of the motion is as fine as numbers allow, so that differences are accurate.
const TOLERANCE: f64 = 1e-13;

/// A periodic motion.
pub struct Periodic {
    /// The states at the section; φ first if the shaft is free.
    pub y: [f64; MOST_STATES],
    /// The modes at the section.
    pub modes: Modes,
    /// T (s).
    pub period: f64,
    /// The largest magnitude of a multiplier.
    pub multiplier: f64,
    /// The columns of ∂P/∂s, each state as part of its size.
    pub map: Vec<[f64; MOST_STATES]>,
}

/// The states after a turn.
struct Turn {
    y: [f64; MOST_STATES],
    /// The largest size of each state during the turn.
    sizes: [f64; MOST_STATES],
    modes: Modes,
    /// The segments of the laws at its start.
    begun: [[usize; 2]; 1 + MOST_FOLLOWERS],
    time: f64,
}

/// The periodic motion near these states; the shaft turns in the sense `sense`.
///
/// # Errors
/// There is no periodic motion, or it takes too much work.
pub fn periodic(
    train: &Train,
    excitation: &Excitation,
    (guess, modes): ([f64; MOST_STATES], Modes),
    sense: f64,
) -> Result<Periodic, Fault> {
    let mut work = Work::default();
    let (mut y, mut at) = (guess, modes);
    let section = Section { train, excitation, sense };
    let mut turns = 0;
    for block in TURNS {
        for _ in 0..block {
            let turned = section.turn(&y, at, &mut work).map_err(|fault| since(fault, turns))?;
            (y, at, turns) = (turned.y, turned.modes, turns + 1);
        }
        match section.newton(y, at, &mut work) {
            Ok(Some(found)) => return Ok(found),
            Err(fault) if work.is_exhausted() => return Err(since(fault, turns)),
            _ => {}
        }
    }
    Err(no_periodic_motion(open(turns), "")
        .hint("choose more damping, a motor whose torque falls with the speed, or at_rest"))
}

/// A fault of the turn after so many: one that takes too much work says how many repeat nothing.
fn since(fault: Fault, turns: usize) -> Fault {
    if fault.motionless.as_deref().is_some_and(|reason| reason.starts_with(NOT_REPEATED)) {
        fault.motionless(open(turns))
    } else {
        fault
    }
}

impl Section<'_> {
    /// Newton's method from these states; None if it does not converge.
    fn newton(&self, mut y: [f64; MOST_STATES], mut at: Modes, work: &mut Work) -> Result<Option<Periodic>, Fault> {
        let (section, train) = (self, self.train);
        let first = if train.machine().is_some() { 1 } else { 0 };
        for _ in 0..ITERATIONS {
            let base = section.turn(&y, at, work)?;
            // Of this turn alone: after a step of Newton's method that went astray any motion would look closed.
            let sizes = base.sizes;
            let held = |k: usize| {
                train.clearances().any(|(j, place, _)| at.stands[j].is_held() && (place..place + 2).contains(&k))
            };
            let unknowns: Vec<usize> = (first..train.layout.count).filter(|k| !held(*k)).collect();
            let count = unknowns.len();
            // A state that happens to be small is measured by the largest of its kind.
            let least = 1e-6 * unknowns.iter().fold(0.0_f64, |most, k| most.max(sizes[*k]));
            let size = |k: usize| sizes[unknowns[k]].max(least).max(f64::MIN_POSITIVE);
            let change = |from: &[f64; MOST_STATES], to: &[f64; MOST_STATES], k: usize| {
                (to[unknowns[k]] - from[unknowns[k]]) / size(k)
            };
            let closed = base.modes.stands.iter().map(|s| s.contact).eq(at.stands.iter().map(|s| s.contact))
                && (0..count).all(|k| change(&y, &base.y, k).abs() <= CLOSED);
            let mut after = |k: usize, step: f64| {
                let mut moved = y;
                moved[unknowns[k]] += step * size(k);
                section.turn(&moved, at, work).map(|turned| turned.y)
            };
            let mut map = vec![[0.0; MOST_STATES]; count];
            for (k, column) in map.iter_mut().enumerate() {
                let step = STEPS[usize::from(closed)];
                let (ahead, back) = (after(k, step)?, if closed { after(k, -step)? } else { base.y });
                let width = if closed { 2.0 * step } else { step };
                (0..count).for_each(|i| column[i] = change(&back, &ahead, i) / width);
            }
            if closed {
                let modes = Modes { segments: base.begun, ..at };
                return Ok(Some(Periodic { y, modes, period: base.time, multiplier: radius(&map), map }));
            }
            let (mut matrix, mut pivots) = (vec![[0.0; MOST_STATES]; count], vec![0; count]);
            for (i, row) in matrix.iter_mut().enumerate() {
                (0..count).for_each(|k| row[k] = if i == k { 1.0 } else { 0.0 } - map[k][i]);
            }
            let mut x = [0.0; MOST_STATES];
            (0..count).for_each(|k| x[k] = change(&y, &base.y, k));
            if lu::factorise(&mut matrix, &mut pivots).is_none() {
                return Ok(None);
            }
            lu::solve(&matrix, &pivots, &mut x);
            // The contacts at the section are those of the previous turn.
            at = Modes { segments: at.segments, ..base.modes };
            (0..count).for_each(|k| y[unknowns[k]] += x[k] * size(k));
        }
        Ok(None)
    }
}

fn none() -> Fault {
    no_periodic_motion("the shaft stops or turns back", "")
        .hint("choose more damping, a motor whose torque falls with the speed, or at_rest")
}

/// The section at which each turn of the shaft in the sense `sense` begins and ends.
struct Section<'a> {
    train: &'a Train,
    excitation: &'a Excitation<'a>,
    sense: f64,
}

impl Section<'_> {
    /// One turn from these states on.
    fn turn(&self, y: &[f64; MOST_STATES], modes: Modes, work: &mut Work) -> Result<Turn, Fault> {
        let Section { train, excitation, sense } = *self;
        let start = Double::from(excitation.time);
        let mut run = Run::begin(train, start, &y[..train.layout.count], modes, TOLERANCE);
        // With an elastic shaft the cam is elsewhere than at the start of the search.
        run.modes.segments = train.segments(&train.angles(run.phi(excitation, start, y), y), sense > 0.0);
        let (begun, mut log, mut sizes) = (run.modes.segments, EventLog::counting(), [0.0_f64; MOST_STATES]);
        let free = train.machine().is_some();
        let period = excitation.motion.map_or(f64::INFINITY, |motion| TAU / motion.coefficients[1].abs());
        run.lay(train, excitation, f64::INFINITY)?;
        loop {
            sizes.iter_mut().zip(&run.states).for_each(|(size, state)| *size = size.max(state.hi.abs()));
            let passed = |run: &Run, theta: f64| {
                let mut y = [0.0; MOST_STATES];
                run.read(theta, &mut y);
                sense * (y[0] - run.states[0].hi)
            };
            let theta = if free {
                let so_far = sense * (run.turns * TAU + (run.states[0].hi - y[0]));
                let (left, length) = (TAU - so_far, run.length);
                (passed(&run, length) >= left).then(|| bisect(length, |theta| passed(&run, theta) - left))
            } else {
                let theta = run.theta(start + Double::from(period));
                (theta <= run.length).then_some(theta)
            };
            if let Some(theta) = theta {
                let mut end = [0.0; MOST_STATES];
                run.read(theta, &mut end);
                end[0] = if free { y[0] } else { end[0] };
                let time = (run.start - start).hi + theta * run.unit;
                return Ok(Turn { begun, y: end, sizes, modes: run.modes, time });
            }
            if work.draw(run.done(train)).is_err() {
                return Err(search_too_much(
                    "choose at_rest or equilibrium, stiffer contacts or a smaller restitution",
                ));
            }
            let event = run.event;
            run.leave(train, excitation, run.length);
            run.since = event;
            if let Some(event) = event {
                run.happen(train, excitation, event, &mut log);
            }
            // A shaft that stands still or turns back never completes the turn.
            if free && sense * run.states[1].hi <= 0.0 {
                return Err(none());
            }
            run.lay(train, excitation, f64::INFINITY)?;
        }
    }
}

/// The zero of `g`, which is below zero at 0.
fn bisect(end: f64, g: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, end);
    // Sixty halvings leave neighbouring numbers.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if g(middle) < 0.0 { low = middle } else { high = middle }
    }
    high
}

/// The largest magnitude of an eigenvalue, as the growth of the 2⁴⁰th power of the matrix.
fn radius(columns: &[[f64; MOST_STATES]]) -> f64 {
    let n = columns.len();
    let (mut power, mut logarithm, mut weight) = (columns.to_vec(), 0.0, 1.0);
    for _ in 0..40 {
        let size = power.iter().flat_map(|c| &c[..n]).fold(0.0_f64, |most, a| most.max(a.abs()));
        if size == 0.0 {
            return 0.0;
        }
        logarithm += weight * size.ln();
        power.iter_mut().for_each(|c| c.iter_mut().for_each(|a| *a /= size));
        let mut square = vec![[0.0; MOST_STATES]; n];
        for (k, column) in square.iter_mut().enumerate() {
            for j in 0..n {
                (0..n).for_each(|i| column[i] += power[j][i] * power[k][j]);
            }
        }
        (power, weight) = (square, 0.5 * weight);
    }
    let size = power.iter().flat_map(|c| &c[..n]).fold(0.0_f64, |most, a| most.max(a.abs()));
    (logarithm + weight * size.max(f64::MIN_POSITIVE).ln()).exp()
}
