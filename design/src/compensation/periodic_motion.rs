//! The periodic motion of a rigid machine, as the solution of one regular periodic equation, by Newton's method on the
//! values at equidistant points.
//!
//! **In the phase of time** ψ = Ωt, Ω = 2π/T, where the tools move as prescribed, x_j = U_j(ψ), and the angle follows,
//! φ′(ψ) = ω/Ω:
//!
//! ½ J(φ) ω² + ½ Ω² S(ψ) = E + (1/Ω) ∫ (M − τ) ω dψ,  ⟨ω⟩ = Ω,  ⟨(M − τ) ω⟩ = 0,  S = Σ m_j U_j′(ψ)².
//!
//! **In the angle** φ, where the cams are given, J(φ) with all followers:
//!
//! ½ J(φ) ω² = E + ∫ (M − τ) dφ,  ⟨M⟩ = τ,  T = 2π ⟨1/ω⟩.
//!
//! Without motor E belongs to the prescribed period; with a motor the period comes out, or, where it is prescribed, the
//! synchronous speed w_s. A motor with a lag adds M + T_el Ṁ = M_Kloss(ω).
//!
//! Symbols: φ angle of the main shaft (rad); ω = φ̇ (rad/s); T period (s); J moment of inertia (kg·m²); m_j mass (kg); U_j
//! motion of tool j (m); M torque of the motor (N·m); τ load (N·m), positive brakes; E energy (J); T_el electrical time
//! constant (s). ⟨·⟩ is the mean over the turn.
//!
//! Source: K. Kaltofen, "HS-Bewegungen trotz veränderlicher Antriebsgeschwindigkeit", equation (2) with conditions (3) and
//! (4); that the equation is regular in the phase of time is derived here.

use super::spectral::{Mesh, mean};
use camdrive::drives::rigid_machine::{Kloss, Motor};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Newton steps of one solution; from a near start it takes four or five.
const ITERATIONS: usize = 60;

/// The motion has converged when a step changes ω by this part of its mean: the roundings of some hundred points.
const CONVERGED: f64 = 3e-15;

/// The mean of the speeds is met far better by a motion.
const CLOSED: f64 = 1e-9;

/// A Newton step takes no speed farther than this part of its way to standstill.
const NOT_FARTHER: f64 = 0.7;

/// How many times softer a motor may be that leads to the motion of a steep one.
const SOFTER: [f64; 5] = [2.0, 4.0, 8.0, 16.0, 32.0];

/// A motor that shrinks by less at a time leads nowhere: the motion ends.
const LEAST_SHRINKING: f64 = 0.99;

/// Drive of the machine on its periodic motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driving {
    /// The motor; [`Motor::Input`] has no periodic motion of its own.
    pub motor: Motor,
    /// τ (N·m).
    pub load: f64,
    /// T (s) where it is prescribed; a machine without motor needs it.
    pub period: Option<f64>,
}

/// Moments of inertia at the points of the mesh.
pub trait Inertia {
    /// Whether the unknown speeds are those in the phase of time.
    const IN_TIME: bool;
    /// J and J′ at φ (kg·m²); `point` is the index.
    fn at(&self, point: usize, phi: f64) -> [f64; 2];
    /// S at the point (kg·m²); zero in the angle, where J holds it.
    fn tools(&self, point: usize) -> f64;
    /// dφ/dχ at the point, where the unknown speeds are those in the angle and the points are equidistant in χ.
    fn pace(&self, _point: usize) -> f64 {
        1.0
    }
}

/// A periodic motion.
#[derive(Clone, Debug)]
pub struct PeriodicMotion {
    /// ω (rad/s) at the points of the mesh.
    pub speed: Vec<f64>,
    /// M (N·m) at the points.
    pub torque: Vec<f64>,
    /// The energy without the work done since the beginning of the turn, about its mean (J).
    pub energy: f64,
    /// 2π/T (rad/s), negative where the machine turns backwards.
    pub mean_speed: f64,
    /// The motor with the synchronous speed that yields the period.
    pub motor: Motor,
}

impl PeriodicMotion {
    /// T (s).
    pub fn period(&self) -> f64 {
        TAU / self.mean_speed.abs()
    }
}

/// Which unknowns there are beside the speeds.
struct Layout {
    points: usize,
    lag: Option<f64>,
    /// The synchronous speed is unknown, since the period is prescribed.
    speed_unknown: bool,
    kloss: bool,
}

impl Layout {
    fn new(driving: &Driving, points: usize) -> Self {
        let kloss = matches!(driving.motor, Motor::Kloss(_));
        Layout { points, lag: driving.motor.lag(), speed_unknown: kloss && driving.period.is_some(), kloss }
    }

    fn torque(&self, i: usize) -> Option<usize> {
        self.lag.map(|_| self.points + i)
    }

    fn energy(&self) -> usize {
        if self.lag.is_some() { 2 * self.points } else { self.points }
    }

    /// The unknown Ω; it is known where the period is prescribed.
    fn mean_speed(&self) -> Option<usize> {
        (self.kloss && !self.speed_unknown).then(|| self.energy() + 1)
    }

    fn synchronous_speed(&self) -> Option<usize> {
        self.speed_unknown.then(|| self.energy() + 1)
    }

    fn len(&self) -> usize {
        self.energy() + 1 + usize::from(self.kloss)
    }
}

/// ∂M/∂ω and ∂M/∂w_s beside M of the characteristic at ω.
///
/// M depends on ω/w_s alone, apart from the sign of w_s: w_s ∂M/∂w_s = −ω ∂M/∂ω.
fn characteristic(motor: &Motor, speed: f64) -> [f64; 3] {
    let [torque, slope, _] = motor.characteristic(speed);
    let by_synchronous = match *motor {
        Motor::Kloss(Kloss { synchronous_speed, .. }) => -slope * speed / synchronous_speed,
        _ => 0.0,
    };
    [torque, slope, by_synchronous]
}

fn with_breakdown_slip(motor: Motor, slip: f64) -> Motor {
    match motor {
        Motor::Kloss(Kloss { breakdown_torque, synchronous_speed, dynamics, .. }) => {
            Motor::Kloss(Kloss { breakdown_torque, breakdown_slip: slip, synchronous_speed, dynamics })
        }
        other => other,
    }
}

fn with_synchronous_speed(motor: Motor, speed: f64) -> Motor {
    match motor {
        Motor::Kloss(Kloss { breakdown_torque, breakdown_slip, dynamics, .. }) => {
            Motor::Kloss(Kloss { breakdown_torque, breakdown_slip, synchronous_speed: speed, dynamics })
        }
        other => other,
    }
}

/// The equations and their derivatives at one iterate.
struct Linearised {
    residual: DVector<f64>,
    jacobian: DMatrix<f64>,
}

/// Newton's equations at `periodic`.
fn linearise<I: Inertia>(mesh: &Mesh, inertia: &I, driving: &Driving, periodic: &PeriodicMotion) -> Linearised {
    let n = mesh.len();
    let layout = Layout::new(driving, n);
    let mut residual = DVector::zeros(layout.len());
    let mut jacobian = DMatrix::zeros(layout.len(), layout.len());
    let w = &periodic.speed;
    let omega = periodic.mean_speed;
    let kloss: Vec<[f64; 3]> = w.iter().map(|w| characteristic(&periodic.motor, *w)).collect();
    let torque: Vec<f64> = match layout.lag {
        Some(_) => periodic.torque.clone(),
        None => kloss.iter().map(|k| k[0]).collect(),
    };
    // In the phase of time the work is that of the power; in the angle, that of the torque.
    let power: Vec<f64> =
        (0..n).map(|i| (torque[i] - driving.load) * if I::IN_TIME { w[i] / omega } else { inertia.pace(i) }).collect();
    let work = mesh.integrate(&power);
    let ahead = mesh.integrate(w);
    let column_of_speed = |j: usize| {
        // d(power)/dω at point j, by the characteristic where the torque is no unknown of its own.
        let slope = if layout.lag.is_none() { kloss[j][1] } else { 0.0 };
        if I::IN_TIME { (slope * w[j] + torque[j] - driving.load) / omega } else { slope * inertia.pace(j) }
    };
    let factor = |j: usize| if I::IN_TIME { w[j] / omega } else { inertia.pace(j) };
    let scale = periodic.energy.abs().max(f64::MIN_POSITIVE);
    for i in 0..n {
        let phi = if I::IN_TIME { mesh.point(i) + (ahead[i] - ahead[0]) / omega } else { mesh.point(i) };
        let [j, slope] = inertia.at(i, phi);
        let s = inertia.tools(i);
        let turning = 0.5 * slope * w[i] * w[i];
        residual[i] = (0.5 * (j * w[i] * w[i] + omega * omega * s) - periodic.energy - work[i]) / scale;
        for column in 0..n {
            let mut d = -mesh.integral(i, column) * column_of_speed(column);
            if I::IN_TIME && slope != 0.0 {
                d += turning * (mesh.integral(i, column) - mesh.integral(0, column)) / omega;
            }
            if column == i {
                d += j * w[i];
            }
            jacobian[(i, column)] = d / scale;
            if let Some(m) = layout.torque(column) {
                jacobian[(i, m)] = -mesh.integral(i, column) * factor(column) / scale;
            }
        }
        jacobian[(i, layout.energy())] = -1.0 / scale;
        if let Some(column) = layout.mean_speed()
            && I::IN_TIME
        {
            jacobian[(i, column)] = (omega * s - turning * (phi - mesh.point(i)) / omega + work[i] / omega) / scale;
        }
        if let Some(column) = layout.synchronous_speed()
            && layout.lag.is_none()
        {
            let by: f64 = (0..n).map(|j| mesh.integral(i, j) * kloss[j][2] * factor(j)).sum();
            jacobian[(i, column)] = -by / scale;
        }
        if let (Some(lag), Some(row)) = (layout.lag, layout.torque(i)) {
            // Ṁ = Ω dM/dψ = ω dM/dφ, dM/dφ = (dM/dχ)/(dφ/dχ).
            let rate: f64 = (0..n).map(|j| mesh.slope(i, j) * torque[j]).sum();
            let speed = if I::IN_TIME { omega } else { w[i] / inertia.pace(i) };
            let size = breakdown(&periodic.motor);
            residual[row] = (torque[i] + lag * speed * rate - kloss[i][0]) / size;
            for column in 0..n {
                jacobian[(row, n + column)] = lag * speed * mesh.slope(i, column) / size;
            }
            jacobian[(row, row)] += 1.0 / size;
            jacobian[(row, i)] = (if I::IN_TIME { 0.0 } else { lag * rate / inertia.pace(i) } - kloss[i][1]) / size;
            if let Some(column) = layout.mean_speed()
                && I::IN_TIME
            {
                jacobian[(row, column)] = lag * rate / size;
            }
            if let Some(column) = layout.synchronous_speed() {
                jacobian[(row, column)] = -kloss[i][2] / size;
            }
        }
    }
    // ⟨ω⟩ = Ω in the phase of time, ⟨1/ω⟩ = 1/Ω in the angle.
    let row = layout.energy();
    for (j, w) in w.iter().enumerate() {
        let (value, slope) = if I::IN_TIME {
            (w / omega, 1.0 / omega)
        } else {
            let part = inertia.pace(j) * omega / w;
            (part, -part / w)
        };
        residual[row] += value / n as f64;
        jacobian[(row, j)] = slope / n as f64;
    }
    if let Some(column) = layout.mean_speed() {
        jacobian[(row, column)] = if I::IN_TIME { -residual[row] / omega } else { residual[row] / omega };
    }
    residual[row] -= 1.0;
    if layout.kloss {
        let row = row + 1;
        let size = breakdown(&periodic.motor);
        residual[row] = mean(&power) / size;
        for j in 0..n {
            jacobian[(row, j)] = column_of_speed(j) / (size * n as f64);
            if let Some(m) = layout.torque(j) {
                jacobian[(row, m)] = factor(j) / (size * n as f64);
            }
        }
        if let Some(column) = layout.mean_speed()
            && I::IN_TIME
        {
            jacobian[(row, column)] = -mean(&power) / (omega * size);
        }
        if let Some(column) = layout.synchronous_speed()
            && layout.lag.is_none()
        {
            let by: f64 = (0..n).map(|j| kloss[j][2] * factor(j)).sum();
            jacobian[(row, column)] = by / (size * n as f64);
        }
    }
    Linearised { residual, jacobian }
}

/// Scale of torques.
fn breakdown(motor: &Motor) -> f64 {
    match *motor {
        Motor::Kloss(Kloss { breakdown_torque, .. }) => breakdown_torque,
        _ => 1.0,
    }
}

/// The periodic motion near `start`; None where Newton's method finds none in which the machine keeps turning.
pub fn solve<I: Inertia>(mesh: &Mesh, inertia: &I, driving: &Driving, start: PeriodicMotion) -> Option<PeriodicMotion> {
    let layout = Layout::new(driving, mesh.len());
    let mut periodic = start;
    let mut before = f64::INFINITY;
    for _ in 0..ITERATIONS {
        let Linearised { residual, jacobian } = linearise(mesh, inertia, driving, &periodic);
        let step = jacobian.lu().solve(&residual)?;
        let change = (0..mesh.len()).map(|i| (step[i] / periodic.mean_speed).abs()).fold(0.0, f64::max);
        if !change.is_finite() {
            return None;
        }
        // No speed changes its sign: the machine keeps turning.
        let towards_rest = (0..mesh.len()).map(|i| step[i] / periodic.speed[i]).fold(0.0, f64::max);
        let towards_rest =
            layout.mean_speed().map_or(towards_rest, |c| towards_rest.max(step[c] / periodic.mean_speed));
        let part = (NOT_FARTHER / towards_rest).min(1.0);
        for i in 0..mesh.len() {
            periodic.speed[i] -= part * step[i];
            if let Some(m) = layout.torque(i) {
                periodic.torque[i] -= part * step[m];
            }
        }
        periodic.energy -= part * step[layout.energy()];
        if let Some(column) = layout.mean_speed() {
            periodic.mean_speed -= part * step[column];
        }
        if let (Some(column), Motor::Kloss(Kloss { synchronous_speed, .. })) =
            (layout.synchronous_speed(), periodic.motor)
        {
            periodic.motor = with_synchronous_speed(periodic.motor, synchronous_speed - part * step[column]);
        }
        // Near the roundings a step no longer gets smaller.
        if change < CONVERGED || (change < 1e-11 && change >= 0.5 * before) {
            // Far from any motion a step is small beside a mean speed that has run away.
            let part = |(i, w): (usize, &f64)| {
                if I::IN_TIME { w / periodic.mean_speed } else { inertia.pace(i) * periodic.mean_speed / w }
            };
            let parts = periodic.speed.iter().enumerate().map(part);
            let miss = (parts.sum::<f64>() / mesh.len() as f64 - 1.0).abs();
            if miss > CLOSED || miss.is_nan() {
                return None;
            }
            if layout.lag.is_none() {
                periodic.torque = periodic.speed.iter().map(|w| periodic.motor.characteristic(*w)[0]).collect();
            }
            return Some(periodic);
        }
        before = change;
    }
    None
}

/// The periodic motion near `start`. Where Newton's method does not get there from it, because a steep motor answers a wrong
/// guess with large torques, motors that are less and less soft lead the way.
pub fn find<I: Inertia>(
    mesh: &Mesh,
    inertia: &I,
    driving: &Driving,
    start: impl Fn(&Driving) -> Option<PeriodicMotion>,
) -> Option<PeriodicMotion> {
    if let Some(periodic) = solve(mesh, inertia, driving, start(driving)?) {
        return Some(periodic);
    }
    let Motor::Kloss(Kloss { breakdown_slip, .. }) = driving.motor else { return None };
    let softer = |motor: Motor, times: f64| with_breakdown_slip(motor, times * breakdown_slip);
    let softened = |times: f64| Driving { motor: softer(driving.motor, times), ..*driving };
    let first = |times: f64| Some((times, solve(mesh, inertia, &softened(times), start(&softened(times))?)?));
    let (mut times, mut periodic) = SOFTER.into_iter().find_map(first)?;
    let mut shrink = 0.5;
    while times > 1.0 {
        let next = f64::max(shrink * times, 1.0);
        let near = PeriodicMotion { motor: softer(periodic.motor, next), ..periodic.clone() };
        match solve(mesh, inertia, &softened(next), near) {
            Some(found) => (periodic, times, shrink) = (found, next, f64::max(0.5, shrink * shrink)),
            None => shrink = shrink.sqrt(),
        }
        if shrink > LEAST_SHRINKING {
            return None;
        }
    }
    Some(periodic)
}

/// A first guess: uniform speed, where the characteristic meets the load on its steep side.
pub fn uniform(mesh: &Mesh, driving: &Driving, inertia: f64) -> Option<PeriodicMotion> {
    let (speed, motor) = match (driving.motor, driving.period) {
        (Motor::Kloss(Kloss { breakdown_torque, breakdown_slip, synchronous_speed, .. }), period) => {
            // 2 σ/(1 + σ²) = load/M_K with |σ| ≤ 1.
            let ratio = driving.load * synchronous_speed.signum() / breakdown_torque;
            if ratio.abs() >= 1.0 {
                return None;
            }
            let sigma = ratio / (1.0 + (1.0 - ratio * ratio).sqrt());
            let part = 1.0 - sigma * breakdown_slip;
            if part <= 0.0 {
                return None;
            }
            match period {
                Some(period) => {
                    let speed = synchronous_speed.signum() * TAU / period;
                    (speed, with_synchronous_speed(driving.motor, speed / part))
                }
                None => (synchronous_speed * part, driving.motor),
            }
        }
        (motor, period) => (TAU / period?, motor),
    };
    Some(PeriodicMotion {
        speed: vec![speed; mesh.len()],
        torque: vec![driving.load; mesh.len()],
        energy: 0.5 * inertia * speed * speed,
        mean_speed: speed,
        motor,
    })
}
