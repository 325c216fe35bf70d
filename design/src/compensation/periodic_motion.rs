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
//! Without motor E belongs to the prescribed period. With a motor the period is a result, or, if it is prescribed, the
//! synchronous speed w_s. A motor with a lag adds M + T_el Ṁ = M_Kloss(ω).
//!
//! Symbols: φ angle of the main shaft (rad); ω = φ̇ (rad/s); T period (s); J moment of inertia (kg·m²); m_j mass (kg); U_j
//! motion of tool j (m); M torque of the motor (N·m); τ load (N·m), positive brakes; E energy (J); T_el electrical time
//! constant (s). ⟨·⟩ is the mean over the turn.
//!
//! Source: K. Kaltofen, "HS-Bewegungen trotz veränderlicher Antriebsgeschwindigkeit", equation (2) with conditions (3) and
//! (4); that the equation is regular in the phase of time is derived here.

use super::spectral::{Mesh, mean};
use crate::work;
use camdrive::drives::rigid_machine::{Kloss, Motor};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Newton steps of one solution; from a near start it takes four or five.
const ITERATIONS: usize = 60;

/// The motion has converged when a step changes ω by this part of its mean: the roundings of some hundred points.
const CONVERGED: f64 = 3e-15;

/// A motion meets the mean of the speeds far better.
const CLOSED: f64 = 1e-9;

/// A Newton step takes no speed farther than this part of its distance from standstill.
const NOT_FARTHER: f64 = 0.7;

/// Factors by which motors are softened that lead to the motion of a steep one.
const SOFTER: [f64; 5] = [2.0, 4.0, 8.0, 16.0, 32.0];

/// The step that shrinks by less leads nowhere: the search ends.
const LEAST_SHRINKING: f64 = 0.99;

/// Drive of the machine on its periodic motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driving {
    /// The motor; [`Motor::Input`] has no periodic motion of its own.
    pub motor: Motor,
    /// τ (N·m).
    pub load: f64,
    /// T (s) if it is prescribed; a machine without a motor needs it.
    pub period: Option<f64>,
}

/// Moments of inertia at the points of the mesh.
pub trait Inertia {
    /// True if the unknown speeds are those in the phase of time.
    const IN_TIME: bool;
    /// J and J′ at φ (kg·m²); `point` is the index.
    fn at(&self, point: usize, phi: f64) -> [f64; 2];
    /// S at the point (kg·m²); zero in the angle, where J contains it.
    fn tools(&self, point: usize) -> f64;
    /// dφ/dχ at the point, if the unknown speeds are in the angle and the points are equidistant in χ.
    fn rate(&self, _point: usize) -> f64 {
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
    /// 2π/T (rad/s), negative if the machine turns backwards.
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

/// The unknowns in addition to the speeds.
struct Layout {
    points: usize,
    lag: Option<f64>,
    /// The synchronous speed is unknown, because the period is prescribed.
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

    /// The unknown Ω; known if the period is prescribed.
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

/// M of the characteristic at ω, ∂M/∂ω and ∂M/∂w_s.
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

/// Newton's equations at one iterate.
struct Equations<'a, I> {
    mesh: &'a Mesh,
    inertia: &'a I,
    at: &'a PeriodicMotion,
    layout: Layout,
    /// M, ∂M/∂ω and ∂M/∂w_s of the characteristic at the points.
    kloss: Vec<[f64; 3]>,
    torque: Vec<f64>,
    /// dφ/dχ if the points are equidistant in χ; ω/Ω in the phase of time.
    rate: Vec<f64>,
    /// P = (M − τ) dφ/dχ.
    power: Vec<f64>,
    /// Unknown, point, and the derivative of P there by the unknown.
    slopes: Vec<(usize, usize, f64)>,
    residual: DVector<f64>,
    jacobian: DMatrix<f64>,
}

impl<'a, I: Inertia> Equations<'a, I> {
    /// Residuals and Jacobian at the iterate `at`.
    fn new(mesh: &'a Mesh, inertia: &'a I, driving: &Driving, at: &'a PeriodicMotion) -> Self {
        let (n, omega, layout) = (mesh.len(), at.mean_speed, Layout::new(driving, mesh.len()));
        let kloss: Vec<[f64; 3]> = at.speed.iter().map(|w| characteristic(&at.motor, *w)).collect();
        let torque = if layout.lag.is_some() { at.torque.clone() } else { kloss.iter().map(|k| k[0]).collect() };
        let rate: Vec<f64> = (0..n).map(|j| if I::IN_TIME { at.speed[j] / omega } else { inertia.rate(j) }).collect();
        let power: Vec<f64> = (0..n).map(|j| (torque[j] - driving.load) * rate[j]).collect();
        let mut slopes = Vec::new();
        for j in 0..n {
            let by_rate = if I::IN_TIME { (torque[j] - driving.load) / omega } else { 0.0 };
            match layout.torque(j) {
                Some(m) => slopes.extend([(j, j, by_rate), (m, j, rate[j])]),
                None => {
                    slopes.push((j, j, kloss[j][1] * rate[j] + by_rate));
                    slopes.extend(layout.synchronous_speed().map(|column| (column, j, kloss[j][2] * rate[j])));
                }
            }
            let mean_speed = layout.mean_speed().filter(|_| I::IN_TIME);
            slopes.extend(mean_speed.map(|column| (column, j, -power[j] / omega)));
        }
        let (residual, jacobian) = (DVector::zeros(layout.len()), DMatrix::zeros(layout.len(), layout.len()));
        let mut all = Equations { mesh, inertia, at, layout, kloss, torque, rate, power, slopes, residual, jacobian };
        all.energy();
        all.lag();
        all.closing();
        all.balance();
        all
    }

    fn scale(&mut self, row: usize, size: f64) {
        self.residual[row] /= size;
        self.jacobian.row_mut(row).unscale_mut(size);
    }

    /// ½ J ω² + ½ Ω² S − E − ∫ P dχ at each point.
    fn energy(&mut self) {
        let (mesh, w, omega) = (self.mesh, &self.at.speed, self.at.mean_speed);
        let (work, ahead) = (mesh.integrate(&self.power), mesh.integrate(w));
        for i in 0..mesh.len() {
            let lead = if I::IN_TIME { (ahead[i] - ahead[0]) / omega } else { 0.0 };
            let [j, slope] = self.inertia.at(i, mesh.point(i) + lead);
            let s = self.inertia.tools(i);
            self.residual[i] = 0.5 * (j * w[i] * w[i] + omega * omega * s) - self.at.energy - work[i];
            for (column, point, by) in &self.slopes {
                self.jacobian[(i, *column)] -= mesh.integral(i, *point) * by;
            }
            self.jacobian[(i, i)] += j * w[i];
            self.jacobian[(i, self.layout.energy())] = -1.0;
            if I::IN_TIME {
                let by_angle = 0.5 * slope * w[i] * w[i];
                for column in 0..mesh.len() {
                    let by_speed = (mesh.integral(i, column) - mesh.integral(0, column)) / omega;
                    self.jacobian[(i, column)] += by_angle * by_speed;
                }
                if let Some(column) = self.layout.mean_speed() {
                    self.jacobian[(i, column)] += omega * s - by_angle * lead / omega;
                }
            }
            self.scale(i, self.at.energy.abs().max(f64::MIN_POSITIVE));
        }
    }

    /// M + T_el Ṁ − M_Kloss at each point; Ṁ = Ω dM/dψ = ω dM/dφ, dM/dφ = (dM/dχ)/(dφ/dχ).
    fn lag(&mut self) {
        let (Some(lag), mesh) = (self.layout.lag, self.mesh) else { return };
        for i in 0..mesh.len() {
            let row = mesh.len() + i;
            let change: f64 = (0..mesh.len()).map(|j| mesh.slope(i, j) * self.torque[j]).sum();
            let (speed, unknown, by) = match I::IN_TIME {
                true => (self.at.mean_speed, self.layout.mean_speed(), 1.0),
                false => (self.at.speed[i] / self.rate[i], Some(i), 1.0 / self.rate[i]),
            };
            let [torque, slope, by_synchronous] = self.kloss[i];
            self.residual[row] = self.torque[i] + lag * speed * change - torque;
            for j in 0..mesh.len() {
                self.jacobian[(row, mesh.len() + j)] = lag * speed * mesh.slope(i, j);
            }
            self.jacobian[(row, row)] += 1.0;
            self.jacobian[(row, i)] = -slope;
            if let Some(column) = unknown {
                self.jacobian[(row, column)] += lag * change * by;
            }
            if let Some(column) = self.layout.synchronous_speed() {
                self.jacobian[(row, column)] = -by_synchronous;
            }
            self.scale(row, breakdown(&self.at.motor));
        }
    }

    /// ⟨ω⟩/Ω − 1 in the phase of time, Ω ⟨1/ω⟩ − 1 in the angle.
    fn closing(&mut self) {
        let (row, n, omega) = (self.layout.energy(), self.mesh.len() as f64, self.at.mean_speed);
        let mut turn = 0.0;
        for (j, w) in self.at.speed.iter().enumerate() {
            let part = if I::IN_TIME { self.rate[j] } else { self.rate[j] * omega / w };
            turn += part / n;
            self.jacobian[(row, j)] = if I::IN_TIME { part } else { -part } / (w * n);
        }
        self.residual[row] = turn - 1.0;
        if let Some(column) = self.layout.mean_speed() {
            self.jacobian[(row, column)] = if I::IN_TIME { -turn } else { turn } / omega;
        }
    }

    /// ⟨P⟩ of a motor.
    fn balance(&mut self) {
        if !self.layout.kloss {
            return;
        }
        let row = self.layout.energy() + 1;
        self.residual[row] = mean(&self.power);
        for (column, _, by) in &self.slopes {
            self.jacobian[(row, *column)] += by / self.mesh.len() as f64;
        }
        self.scale(row, breakdown(&self.at.motor));
    }
}

/// Scale of torques.
fn breakdown(motor: &Motor) -> f64 {
    match *motor {
        Motor::Kloss(Kloss { breakdown_torque, .. }) => breakdown_torque,
        _ => 1.0,
    }
}

/// The periodic motion near `start`; None if Newton's method finds none in which the machine keeps turning.
pub fn solve<I: Inertia>(mesh: &Mesh, inertia: &I, driving: &Driving, start: PeriodicMotion) -> Option<PeriodicMotion> {
    let layout = Layout::new(driving, mesh.len());
    let mut periodic = start;
    let mut before = f64::INFINITY;
    for _ in 0..ITERATIONS {
        // The factors of the Jacobian take most of it: n³/3 products, some three at a time.
        if !work::draw(0.1 * (layout.len() as f64).powi(3)) {
            return None;
        }
        let Equations { residual, jacobian, .. } = Equations::new(mesh, inertia, driving, &periodic);
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
            // Far from any motion a step is small compared with a mean speed that has run away.
            if !(residual[layout.energy()].abs() <= CLOSED) {
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

/// The periodic motion near `start`. If Newton's method does not get there because a steep motor answers a wrong guess with
/// large torques, ever stiffer motors lead the way.
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

/// A first guess: uniform speed, at the point where the steep side of the characteristic meets the load.
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
