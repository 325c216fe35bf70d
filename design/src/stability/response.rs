//! The motion under load: periodic motion, amplification of the load over the speed, start from rest, resonances.
//!
//! The load on the elastic member is M = c q + b q̇. Its kinetostatic value M₀ = f + Ω² f₂ remains if the member does not
//! oscillate; R = max |M|/max |M₀| over a turn.

use super::BORDER;
use super::system::System;
use super::tongue::spectral_radius;
use crate::oscillator::Terms;
use crate::search;
use camdrive::numerics::period_map::{PeriodMap, Trajectory, is_resonant};
use serde::Serialize;
use std::f64::consts::TAU;

/// Samples of a turn, and of a vibration, for maxima. A parabola between them leaves an error of at most 1e-5 of a maximum.
const SAMPLES_PER_TURN: f64 = 720.0;
const SAMPLES_PER_VIBRATION: f64 = 60.0;

/// A multiplier counts as 1 if det(I − M) is this part of its terms.
const RESONANT: f64 = 1e-10;

/// A start is followed until its free motion has decayed to this part, or for so many turns.
const DECAYED: f64 = 1e-3;
const MOST_TURNS: f64 = 200.0;
/// The turns of a start whose free motion does not decay.
const TURNS_WITHOUT_DECAY: f64 = 20.0;

/// The periodic motion at a speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PeriodicMotion {
    /// η.
    pub eta: f64,
    /// max |q| (unit of q).
    pub amplitude: f64,
    /// max |M| (unit of the load).
    pub load: f64,
    /// max |M₀|.
    pub kinetostatic: f64,
    /// R; None without load.
    pub amplification: Option<f64>,
    /// True if no free motion grows; nobody sees the periodic motion of an unstable drive.
    pub stable: bool,
}

/// A start from rest, q = q̇ = 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Transient {
    /// Ω (rad/s).
    pub speed: f64,
    /// The periodic motion that it ends in.
    pub steady: PeriodicMotion,
    /// The largest |q| from the start on.
    pub peak: f64,
    /// The largest |M| from the start on.
    pub peak_load: f64,
    /// The turns over which the peaks were searched.
    pub turns: f64,
    /// Turns until the free motion has decayed to a thousandth; None if it does not decay.
    pub settled_after: Option<f64>,
}

/// A speed at which the free motion makes as many vibrations in a turn as a harmonic of the load.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Resonance {
    /// k.
    pub k: usize,
    /// Ω of k Ω = ω₀ (rad/s): the resonance of a constant oscillator.
    pub nominal_speed: f64,
    /// Ω of the largest load nearby (rad/s); the middle of the instability if the drive is unstable.
    pub speed: f64,
    /// True if the drive is unstable there.
    pub unstable: bool,
    /// The amplitude of the harmonic of the load over c₀ at that speed: the deflection without oscillation.
    pub deflection: f64,
    /// The amplitude that a constant oscillator would reach, this deflection over 2 θ; None without damping.
    pub estimate: Option<f64>,
    /// max |q| of the periodic motion.
    pub amplitude: Option<f64>,
    /// R.
    pub amplification: Option<f64>,
}

/// The largest load is searched within this part of the expected speed: half of the way to the next resonance of most orders.
const NEARBY: f64 = 0.05;

/// The turn under load at the speed ratio η and the damping ratio θ, and its periodic motion at the start of the turn.
struct LoadedTurn<'a> {
    system: &'a System<'a>,
    map: PeriodMap,
    eta: f64,
    theta: f64,
}

impl<'a> LoadedTurn<'a> {
    fn new(system: &'a System<'a>, eta: f64, theta: f64) -> Option<Self> {
        let map = system.table(1.0 / (eta * eta), 2.0 * theta / eta)?;
        Some(LoadedTurn { system, map, eta, theta })
    }

    /// (q, q′) that returns to itself.
    fn periodic(&self) -> Option<[f64; 2]> {
        let affine = self.map.period_map();
        let [[a, b], [c, d]] = affine.matrix;
        let [f, g] = affine.shift;
        if affine.shift != [0.0; 2] && is_resonant(&affine.matrix, RESONANT) {
            return None;
        }
        let determinant = (1.0 - a) * (1.0 - d) - b * c;
        let y = [((1.0 - d) * f + b * g) / determinant, (c * f + (1.0 - a) * g) / determinant];
        (y[0].is_finite() && y[1].is_finite()).then_some(y)
    }

    /// The largest |q| and |M|/c₀ over `turns` from the state `y` on; None if the motion leaves the range of numbers.
    fn largest(&self, y: [f64; 2], turns: f64) -> Option<[f64; 2]> {
        let per_turn = SAMPLES_PER_TURN.max(SAMPLES_PER_VIBRATION / self.eta).ceil();
        let step = TAU / per_turn;
        let mut trajectory = Trajectory::new(&self.map, 0.0, y);
        let (mut before, mut last) = ([0.0; 2], [0.0; 2]);
        let mut largest = [0.0_f64; 2];
        for i in 0..=(turns * per_turn).ceil() as usize {
            let tau = i as f64 * step;
            trajectory.reach(&self.map, tau).ok()?;
            let now = self.at(&trajectory, tau);
            for k in 0..2 {
                largest[k] = largest[k].max(now[k].abs());
                if i > 1 && (last[k] - before[k]) * (now[k] - last[k]) < 0.0 {
                    let (slope, curvature) = (0.5 * (now[k] - before[k]), now[k] - 2.0 * last[k] + before[k]);
                    largest[k] = largest[k].max((last[k] - 0.5 * slope * slope / curvature).abs());
                }
            }
            (before, last) = (last, now);
        }
        Some(largest)
    }

    /// q and M/c₀ at the angle `tau` after the start, on the trajectory followed so far.
    fn at(&self, trajectory: &Trajectory, tau: f64) -> [f64; 2] {
        let [q, slope] = trajectory.at(&self.map, tau);
        let phi = (self.system.start() + tau).rem_euclid(TAU);
        let t = self.system.at(phi);
        let ([b, c], inverse) = (self.system.own(phi).unwrap_or([t.b, t.c]), 1.0 / self.eta);
        let damping = self.system.damping(b, inverse, 2.0 * self.theta * inverse);
        [q, c * q + self.eta * self.eta * damping * slope]
    }

    /// The factor by which the slowest free motion changes in a turn.
    fn radius(&self) -> f64 {
        spectral_radius(&self.map.period_map().matrix)
    }

    /// True if no free motion grows; without damping roundings must not decide.
    fn is_stable(&self) -> bool {
        self.radius() < 1.0 + BORDER
    }
}

/// The periodic motion at the speed ratio η, if any.
pub fn periodic_motion(system: &System, eta: f64, theta: f64) -> Option<PeriodicMotion> {
    let turn = LoadedTurn::new(system, eta, theta)?;
    motion_of(&turn)
}

fn motion_of(turn: &LoadedTurn) -> Option<PeriodicMotion> {
    let [amplitude, load] = turn.largest(turn.periodic()?, 1.0)?;
    let c = turn.system.mean.c;
    let square = turn.eta * turn.eta;
    let damped = 2.0 * turn.theta * turn.eta;
    let kinetostatic = turn.system.greatest(&|t| t.f + damped * t.f1 + square * t.f2);
    Some(PeriodicMotion {
        eta: turn.eta,
        amplitude,
        load: c * load,
        kinetostatic: c * kinetostatic,
        amplification: (kinetostatic > 0.0).then(|| load / kinetostatic),
        stable: turn.is_stable(),
    })
}

/// φ (rad), M and M₀ of the periodic motion over the turn; M is NaN if the drive is unstable and nobody sees this motion.
pub fn course(system: &System, eta: f64, theta: f64) -> Option<Vec<[f64; 3]>> {
    let turn = LoadedTurn::new(system, eta, theta)?;
    let stable = turn.is_stable();
    let count = SAMPLES_PER_TURN.max(SAMPLES_PER_VIBRATION / eta).ceil();
    let mut trajectory = Trajectory::new(&turn.map, 0.0, turn.periodic()?);
    let mut points = Vec::new();
    for i in 0..count as usize {
        let tau = TAU * i as f64 / count;
        trajectory.reach(&turn.map, tau).ok()?;
        let phi = (system.start() + tau).rem_euclid(TAU);
        let t = system.at(phi);
        let load = if stable { turn.at(&trajectory, tau)[1] } else { f64::NAN };
        let kinetostatic = t.f + 2.0 * theta * eta * t.f1 + eta * eta * t.f2;
        points.push([phi, system.mean.c * load, system.mean.c * kinetostatic]);
    }
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    // The turn ends as it begins.
    let [phi, load, kinetostatic] = *points.first()?;
    points.push([phi + TAU, load, kinetostatic]);
    Some(points)
}

/// A start from rest at the speed ratio η.
pub fn transient(system: &System, eta: f64, theta: f64) -> Option<Transient> {
    let turn = LoadedTurn::new(system, eta, theta)?;
    let steady = motion_of(&turn)?;
    let radius = turn.radius();
    let settled = DECAYED.ln() / radius.ln();
    let settled_after = (radius < 1.0 - BORDER).then_some(settled);
    let turns = settled_after.map_or(TURNS_WITHOUT_DECAY, |turns| turns.clamp(2.0, MOST_TURNS).ceil());
    let [peak, load] = turn.largest([0.0, 0.0], turns)?;
    let speed = eta * system.natural_frequency();
    Some(Transient { speed, steady, peak, peak_load: system.mean.c * load, turns, settled_after })
}

/// The resonances of the harmonics of the load up to `most`, without those that deflect less than a ten-thousandth of the
/// strongest. `expected` is the η at which the free motion makes k vibrations in a turn, if known.
pub fn resonances(system: &System, theta: f64, most: usize, expected: &dyn Fn(usize) -> Option<f64>) -> Vec<Resonance> {
    let most = most.min(system.highest_harmonic());
    let terms: [fn(&Terms) -> f64; 3] = [|t| t.f, |t| t.f1, |t| t.f2];
    let [f, f1, f2] = terms.map(|term| system.coefficients(most, &term));
    let deflection = |k: usize, eta: f64| 2.0 * (f[k] + f1[k] * (2.0 * theta * eta) + f2[k] * eta * eta).norm();
    let at = |k: usize| expected(k).unwrap_or(1.0 / k as f64);
    let largest = (1..=most).map(|k| deflection(k, at(k))).fold(0.0, f64::max);
    let told = |k: &usize| deflection(*k, at(*k)) > 1e-4 * largest;
    let resonance = |k: usize| {
        let load = |eta: f64| periodic_motion(system, eta, theta).filter(|s| s.stable).map_or(0.0, |s| s.load);
        let middle = at(k);
        let unstable = periodic_motion(system, middle, theta).is_some_and(|s| !s.stable);
        let ends = [middle * (1.0 - NEARBY), middle * (1.0 + NEARBY)];
        // Without damping the load of a resonance has no bound.
        let unbounded = theta <= 0.0 && !unstable;
        let eta =
            if unstable || unbounded { middle } else { search::maximum(&mut |eta| load(eta), ends, 1e-5 * middle).0 };
        let motion = periodic_motion(system, eta, theta).filter(|_| !unstable);
        let greatest = |value: Option<f64>| if unbounded { Some(f64::INFINITY) } else { value };
        Resonance {
            k,
            nominal_speed: system.natural_frequency() / k as f64,
            speed: eta * system.natural_frequency(),
            unstable,
            deflection: deflection(k, eta),
            estimate: (theta > 0.0).then(|| deflection(k, eta) / (2.0 * theta)),
            amplitude: greatest(motion.map(|s| s.amplitude)),
            amplification: greatest(motion.and_then(|s| s.amplification)),
        }
    };
    (1..=most).filter(told).map(resonance).collect()
}
