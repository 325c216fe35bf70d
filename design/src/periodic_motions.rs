//! All periodic motions of a machine, in addition to the one that `steady` starts with.
//!
//! They are the fixed points of [`TurnMap`], E(0) → E(2π). Its gain g(E) = E(2π) − E(0) is scanned over the speeds; if |g| has
//! a minimum between two samples without a change of sign, the extreme of g shows whether two motions lie there. With a lagging
//! torque each is continued to the map of two dimensions.

use crate::search::{Extreme, greatest, summit};
use camdrive::drives::rigid_machine::{Inertia, Kloss, MachineStart, Motor, Place, RigidMachine, Scene};
use camdrive::drives::shaft::free::State;
use camdrive::drives::solver::free_shaft::lagging_turn::LaggingTurn;
use camdrive::drives::solver::free_shaft::turn_map::{PERIODIC_TOLERANCE, SCAN_TOLERANCE, TurnMap};
use camdrive::drives::{Drive as _, Fault};
use camdrive::numerics::gauss::Gauss;
use std::f64::consts::TAU;

/// A periodic motion in which the shaft turns all around.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PeriodicMotion {
    /// T (s).
    pub period: f64,
    /// E = ½Jω² (J) at φ = 0.
    pub energy: f64,
    /// ln of the factor by which a small disturbance grows in a turn, the modulus of the largest Floquet multiplier.
    pub growth: f64,
    /// M_an (N·m) at φ = 0.
    pub torque: f64,
    /// φ (rad) and ω (rad/s) over the turn.
    pub course: Vec<[f64; 2]>,
}

impl PeriodicMotion {
    /// The factor by which a small disturbance grows in a turn; infinite for a steep motor.
    pub fn multiplier(&self) -> f64 {
        self.growth.exp()
    }

    /// True if small disturbances decay.
    pub fn is_stable(&self) -> bool {
        self.growth < 0.0
    }
}

/// The least and the largest ω (rad/s) of a course, which both are among its points.
pub fn range(course: &[[f64; 2]]) -> [f64; 2] {
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    course.iter().fold(ends, |[low, high], [_, w]| [low.min(*w), high.max(*w)])
}

/// φ and ω over a turn at about [`POINTS`] places and at the least and largest ω, in the order of the motion; ω(i, φ) is smooth
/// on each of the pieces.
fn course(pieces: &[[f64; 2]], w: impl Fn(usize, f64) -> f64) -> Vec<[f64; 2]> {
    let mut course = Vec::new();
    for (i, [from, to]) in pieces.iter().enumerate() {
        let parts = ((to - from) * POINTS as f64 / TAU).round().max(1.0);
        let places = (0..=parts as usize).map(|k| from + (to - from) * k as f64 / parts);
        course.extend(places.map(|phi| [phi, w(i, phi)]));
    }
    let extreme = |sign: f64| {
        let Extreme { phi, value } = greatest(pieces, |i, phi| sign * w(i, phi));
        [phi, sign * value]
    };
    course.extend([-1.0, 1.0].map(extreme));
    let sense = course[0][1].signum();
    course.sort_by(|a, b| (sense * a[0]).total_cmp(&(sense * b[0])));
    // Pieces meet but for the rounding of their ends.
    course.dedup_by(|b, a| (b[0] - a[0]).abs() < 1e-12);
    course
}

/// Speeds of the scan, from a little above the fastest possible motion down to two thousandths of the synchronous speed,
/// equally spaced in the logarithm: two per cent apart for a constant J.
const SCAN: usize = 320;
const SLOWEST: f64 = 2e-3;

/// Tolerance of the extreme of the gain, as part of E: fine enough to distinguish a double root from two.
const FINEST: f64 = 1e-12;

/// Points of the course of a motion.
const POINTS: usize = 720;

/// Two periods belong to one motion if they agree to this part, far above the tolerance of the periodic motions; different
/// motions differ by the slip of the motor.
const SAME: f64 = 1e-9;

/// All periodic motions of the machine against a constant load, the fastest first.
///
/// # Errors
/// A motor without characteristic, or a machine that cannot be built.
pub fn periodic_motions(scene: &Scene, load: f64) -> Result<Vec<PeriodicMotion>, Fault> {
    all_motions(scene, load).map(|motions| motions.found)
}

/// The periodic motions, and the periods of those that could not be found.
#[derive(Clone, Debug, PartialEq)]
pub struct Motions {
    /// The fastest first.
    pub found: Vec<PeriodicMotion>,
    /// T (s) of the motions with a motor that follows at once that could not be continued to the lagging torque: it has none
    /// there, or one that disturbances leave so fast that a turn forgets where it began.
    pub lost: Vec<f64>,
}

/// See [`periodic_motions`], which yields the found ones.
///
/// # Errors
/// The errors of [`periodic_motions`].
pub fn all_motions(scene: &Scene, load: f64) -> Result<Motions, Fault> {
    let Motor::Kloss(Kloss { breakdown_slip, breakdown_torque, synchronous_speed, .. }) = scene.motor else {
        return Err(Fault::new("a torque that does not depend on the speed determines no periodic motion"));
    };
    let mut machine = RigidMachine::new(Scene {
        start: MachineStart::Given,
        phi_start: 0.0,
        w_start: synchronous_speed,
        ..scene.clone()
    })?;
    machine.start(0.0)?;
    let inertia = Inertia::new(scene.inertia.clone(), scene.followers.clone());
    let samples =
        scan(&TurnMap::new(machine.mesh(), load, SCAN_TOLERANCE, None)?, &inertia, breakdown_slip, synchronous_speed)?;
    // The interval that is passed from φ = 0 on, and the angle in it.
    let zero = inertia.interval(0.0, synchronous_speed > 0.0);
    let ahead = TurnMap::new(machine.mesh(), load, PERIODIC_TOLERANCE, None)?;
    let back = ahead.backwards();
    let (mut motions, mut lost, mut continued) = (Vec::new(), Vec::new(), Vec::new());
    for pair in samples.windows(2) {
        let [(above, gain_above), (below, gain_below)] = pair else { continue };
        let stable = *gain_above < 0.0 && *gain_below >= 0.0;
        let unstable = *gain_above >= 0.0 && *gain_below < 0.0;
        if !(stable || unstable) {
            continue;
        }
        // A machine that comes to rest ahead says nothing about the interval in between; the way back to it does.
        let map = if stable { &ahead } else { &back };
        let Some((start, period)) = map.refine((*below, *above)) else { continue };
        let Some(energy) = map.energy_at(start, zero).map(|energy| energy.hi) else { continue };
        if scene.motor.lag().is_none() {
            let Some(growth) = growth(map, start) else { continue };
            let (pieces, speed) = motion(map, start);
            let course = course(&pieces, speed);
            let j = inertia.value(inertia.place(zero.0), zero.1);
            let speed = synchronous_speed.signum() * (2.0 * energy / j).sqrt();
            let torque = scene.motor.characteristic(speed)[0];
            motions.push(PeriodicMotion {
                period,
                energy,
                growth: if stable { growth } else { -growth },
                torque,
                course,
            });
            continue;
        }
        let at_zero = State { interval: zero.0, angle: zero.1.into(), ..State::default() };
        match with_lag(&LaggingTurn::new(&inertia, &scene.motor, load, &at_zero, None), energy, breakdown_torque) {
            Some(motion) => continued.push((period, motion)),
            None => lost.push(period),
        }
    }
    // Newton's method may slide from a motion that disturbances leave fast to another one, which is then found twice.
    for (period, motion) in &continued {
        let nearer = |(other, same): &(f64, PeriodicMotion)| {
            (same.period / motion.period - 1.0).abs() < SAME
                && (other - motion.period).abs() < (period - motion.period).abs()
        };
        if continued.iter().any(nearer) {
            lost.push(*period);
        } else {
            motions.push(motion.clone());
        }
    }
    Ok(Motions { found: motions, lost })
}

/// ln of the factor by which the turn that begins with this energy changes a small disturbance of it.
fn growth(map: &TurnMap<'_>, energy: f64) -> Option<f64> {
    let mut growth = 0.0;
    map.follow(energy, |step| growth += step.log_growth(&map.torques))?;
    Some(growth)
}

/// A turn that begins with `energy`: ω as a function of piece and φ, and the ends of the pieces in φ.
fn motion(map: &TurnMap<'_>, energy: f64) -> (Vec<[f64; 2]>, impl Fn(usize, f64) -> f64) {
    let (mesh, sense) = (&map.mesh, map.torques.sense);
    let mut steps = Vec::new();
    map.follow(energy, |step| steps.push(*step));
    let end = |from: f64, length: f64| [from.min(from + sense * length), from.max(from + sense * length)];
    let pieces = steps.iter().map(|step| end(step.from.angle.hi, step.length)).collect();
    let speed = move |piece: usize, phi: f64| {
        let step = &steps[piece];
        let x = 2.0 * sense * (phi - step.from.angle.hi) / step.length - 1.0;
        let inertia = &mesh.profile.inertia;
        let place = inertia.place(mesh.cells()[step.from.cell].interval);
        mesh.motor.sense() * (2.0 * step.energy_at(x).hi / inertia.value(place, phi)).sqrt()
    };
    (pieces, speed)
}

/// Energies at the beginning of a turn, falling, with the part of each by which the turn raises it.
fn scan(map: &TurnMap<'_>, inertia: &Inertia, slip: f64, synchronous: f64) -> Result<Vec<(f64, f64)>, Fault> {
    let (low, high) = inertia.range();
    if !(low > 0.0) {
        return Err(Fault::new(format!(
            "the moment of inertia must be positive over the whole turn; its least value is {low} kg.m2"
        )));
    }
    // A load that drives the motor is held with at most the breakdown slip above the synchronous speed, or never.
    let fastest = synchronous.abs() * (1.0 + 4.0 * slip.max(0.25)) * (high / low).sqrt();
    let energy = |i: usize| 0.5 * high * (fastest * SLOWEST.powf(i as f64 / SCAN as f64)).powi(2);
    let gain = |energy: f64| map.shoot(energy).map_or(f64::NEG_INFINITY, |shot| shot.gain / energy);
    // The fastest speed assumes a turn that begins at the largest J, the slowest one at the least J.
    let last = SCAN + (SCAN as f64 * (high / low).ln() / -SLOWEST.ln()).ceil() as usize;
    let mut samples: Vec<(f64, f64)> = (0..=last).map(energy).map(|e| (e, gain(e))).collect();
    let mut extra = Vec::new();
    for three in samples.windows(3) {
        let [(e0, g0), (e1, g1), (e2, g2)] = three else { continue };
        let same = g0.signum() == g1.signum() && g1.signum() == g2.signum();
        if same && g1.is_finite() && g1.abs() <= g0.abs() && g1.abs() <= g2.abs() {
            let mut beyond = |energy: f64| -g1.signum() * gain(energy);
            extra.push(summit(&mut beyond, [*e2, *e0], (*e1, -g1.abs()), FINEST * e1).0);
        }
    }
    samples.extend(extra.into_iter().map(|e| (e, gain(e))));
    samples.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(samples)
}

/// The motion with a lagging torque, continued from the `energy` (J) at φ = 0.
fn with_lag(turn: &LaggingTurn<'_>, energy: f64, breakdown_torque: f64) -> Option<PeriodicMotion> {
    let (motion, period) = turn.refine((2.0 * energy).sqrt(), breakdown_torque)?;
    let (growth, on_turn) = turn.growth_and_motion(motion)?;
    let course = course(&on_turn.pieces(), |i, phi| on_turn.speed(i, phi));
    let [v, torque] = motion;
    Some(PeriodicMotion { period, energy: 0.5 * v * v, growth, torque, course })
}

/// The motion of the machine without torques with the period T (s): J ω² = 2E = const,
/// √(2E) = ∮√J dφ / T; φ and ω over the turn.
pub fn free_motion(inertia: &Inertia, period: f64, sense: f64) -> Vec<[f64; 2]> {
    let rule = Gauss::with(16);
    let inner = inertia.borders().iter().copied().filter(|border| *border > 0.0);
    let ends: Vec<f64> = std::iter::once(0.0).chain(inner).chain([TAU]).collect();
    let pieces: Vec<[f64; 2]> = ends.windows(2).map(|ends| [ends[0], ends[1]]).collect();
    let root = |i: usize, phi: f64| inertia.value(Place::at(0.5 * (pieces[i][0] + pieces[i][1])), phi).sqrt();
    let integral = |finer: usize| -> f64 {
        let of = |piece: usize| {
            let [from, to] = pieces[piece];
            // Sixteen nodes resolve half a wave of the finest harmonic of J to rounding.
            let n = ((to - from) * inertia.resolution() / 3.0).ceil().max(1.0) as usize * finer;
            let width = (to - from) / n as f64;
            let part = |i: usize| {
                let [sum] = rule.integrate(width, |s| [root(piece, from + i as f64 * width + s)]);
                sum
            };
            (0..n).map(part).sum::<f64>()
        };
        (0..pieces.len()).map(of).sum()
    };
    // √J has branch points at about √(J0/m)/|U″| next to the turning points of a follower, arbitrarily close for a light J0; at
    // the last halving they may be 1e-4 rad away.
    let mut sum = integral(1);
    for halving in 1..=12 {
        let finer = integral(1 << halving);
        let change = (finer - sum).abs();
        sum = finer;
        if change <= 1e-14 * sum {
            break;
        }
    }
    course(&pieces, |i, phi| sense * sum / period / root(i, phi))
}

#[cfg(test)]
mod tests;
