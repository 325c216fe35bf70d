//! HS motions despite a fluctuating drive speed: the laws of the cams with which tools move as prescribed **in time**.
//!
//! A machine whose cams are cut for a uniform speed turns non-uniformly, because the tools' inertia fluctuates, and its tools
//! then have unwanted harmonics. Tool j is to move as x_j(t) = U_j(ψ), ψ = 2πt/T. With the angle φ(ψ) of the machine in this
//! motion, the cam must be
//!
//! U_cam,j(φ) = U_j(ψ(φ)).
//!
//! Because the tools' motion in time is known beforehand, φ(ψ) solves one regular periodic equation ([`periodic_motion`]). The
//! source's iteration ([`iteration`]) tends to the same limit with the factor ρ = max Ω²S/(J ω² + Ω²S), the largest share of
//! the tools in the kinetic energy. Without motor a solution exists only if J0 ≥ ⟨√(S_max − S)⟩², J0 the constant inertia and S
//! = Σ m_j U_j′²: otherwise the machine would come to rest while the tools move fastest.
//!
//! With mechanisms the same holds for the lever: if the tool moves as prescribed in time, so does the lever, and S contains the
//! tool and all links with their velocities in time.
//!
//! The cams' laws are Fourier series in φ, as long as the wanted accuracy demands, or tables if a series is too long (`laws`).
//! If the motions are no series (cycles, plans, tables), all cams are tables whose pieces end at the corners (`corners`). With
//! loads, and with other motors, shooting finds the motion over time ([`loaded`]).
//!
//! Source: K. Kaltofen, "HS-Bewegungen trotz veränderlicher Antriebsgeschwindigkeit", section 3; factor and bound are
//! derived here.

mod corners;
mod figures;
pub mod iteration;
mod laws;
pub mod loaded;
pub mod periodic_motion;
pub mod report;
pub mod restrictions;
mod spectral;
#[cfg(test)]
mod tests;
mod tool;

pub use laws::{Form, Law};
pub use restrictions::Restrictions;
pub use tool::Tool;

use crate::search::root;
use crate::text::digits_beyond;
use crate::{Progress, work};
use camdrive::drives::Fault;
use camdrive::drives::rigid_machine::{self, Kloss, Motor, Place};
use camdrive::motion::Fourier;
use corners::{Corners, WantedTurn};
use loaded::LoadedMachine;
use periodic_motion::{Driving, Inertia, PeriodicMotion};
use spectral::{Mesh, largest, mean, tail};
use std::f64::consts::TAU;
use std::sync::Arc;

/// The coarsest and the finest mesh, by its order. A machine near the bound of feasibility, which almost comes to rest, needs
/// more; its solution then reports its resolution.
const ORDERS: [usize; 2] = [48, 384];

/// The finest mesh of a machine whose motion has a closed form: within a hundredth of the least inertia.
const FINEST_CLOSED: usize = 1536;

/// The mesh that shows whether tools with corners are too heavy for the machine: least inertias on it are accurate to a
/// thousandth. It is some fifty times as fast as the finest, on which Newton's method would try for minutes.
const COARSE: usize = 96;

/// The motion is resolved when its last harmonics are below this part of the largest: roundings of a Newton step.
const RESOLVED: f64 = 1e-14;

/// A motion whose last harmonics are above this part of the largest has corners, for example from a table of torques or the
/// limit of a servo.
const SMOOTH: f64 = 1e-10;

/// Significant digits of the least inertia.
const LEAST: usize = 6;

/// The share of the tools' inertia grows by this much at first if Newton's method must be led to the solution, and by this much
/// at least.
const SHARES: [f64; 2] = [0.25, 1e-3];

/// The work allowed for the least inertia with a motor, which only a refusal names.
const LEAST_INERTIA: f64 = 0.25 * work::BUDGET;

/// The machine and its task.
#[derive(Clone, Debug)]
pub struct Task {
    /// The parts that turn with the angle of the machine: J0, J_v(φ) and given cams.
    pub own: rigid_machine::Inertia,
    /// The tools.
    pub tools: Vec<Tool>,
    /// Motor, load, period.
    pub driving: Driving,
    /// Restrictions of the tools.
    pub restrictions: Restrictions,
    /// The machine under its loads and with its motor, if they differ from those of `driving`, which then has the period and
    /// the constant load.
    pub loaded: Option<LoadedMachine>,
}

/// The solution.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The motion in the phase of time.
    pub periodic: PeriodicMotion,
    /// ω(ψ) (rad/s).
    pub speed: Fourier,
    /// The last harmonics of ω(ψ) relative to its mean: the resolution of the motion.
    pub resolution: f64,
    /// ρ, the factor by which an iteration of the source reduces the error.
    pub factor: f64,
    /// The motion from corner to corner, if laws have corners.
    corners: Option<Arc<dyn WantedTurn>>,
    /// A machine under loads, with ω and the motor's state at ψ = 0, and Ω.
    loaded: Option<(LoadedMachine, [f64; 3])>,
}

/// The tools' inertia in the phase of time, and the rest in the angle.
struct InTime<'a> {
    own: &'a rigid_machine::Inertia,
    /// S at the points.
    tools: Vec<f64>,
}

impl Inertia for InTime<'_> {
    const IN_TIME: bool = true;

    fn at(&self, _: usize, phi: f64) -> [f64; 2] {
        let [j, slope, ..] = self.own.at(Place::at(phi), phi);
        [j, slope]
    }

    fn tools(&self, point: usize) -> f64 {
        self.tools[point]
    }
}

impl Task {
    /// S(ψ) = Σ m_j U_j′(ψ)² (kg·m²), with the inertia of all links of mechanisms.
    pub fn tools_inertia(&self, psi: f64) -> f64 {
        self.tools.iter().map(|tool| tool.inertia(psi)).sum()
    }

    /// The highest harmonic of the tools' motions; for laws that are no series and have no highest one, the limit of the finest
    /// mesh.
    fn order(&self) -> usize {
        let carried = self.finest().min(ORDERS[1]) / 2;
        let of = |tool: &Tool| tool.motion.series().map_or(carried, |series| tool.wanted.order().max(series.order()));
        self.tools.iter().map(of).max().unwrap_or(1).max(1)
    }

    /// The order of the finest mesh: half of it with a motor that lags, whose torque adds as many unknowns, and with corners,
    /// which no mesh resolves.
    fn finest(&self) -> usize {
        match (self.has_corners(), self.driving.motor.lag().is_some()) {
            (true, true) => ORDERS[1] / 2,
            (false, _) if self.is_free() => FINEST_CLOSED,
            _ => ORDERS[1],
        }
    }

    /// True if a tool's law is no series, or a load's law has breakpoints.
    fn has_corners(&self) -> bool {
        self.loaded.as_ref().is_some_and(LoadedMachine::has_corners)
            || self.tools.iter().any(|tool| tool.motion.series().is_none())
    }

    /// The order of the coarsest mesh for the motion: six points for each harmonic of the tools; two for many harmonics, as for
    /// their inertia, because the work grows with the cube.
    fn coarsest(&self) -> usize {
        (6 * self.order()).min(self.finest().min(ORDERS[1])).max(2 * self.order()).max(ORDERS[0])
    }

    /// The mesh on which least inertias are found.
    fn rough_mesh(&self) -> Mesh {
        Mesh::new(if self.has_corners() { COARSE } else { self.coarsest() })
    }

    /// ⟨√(S_max − S)⟩² (kg·m²): the least constant inertia of a machine without motor.
    pub fn least_inertia_without_motor(&self) -> f64 {
        // The square root has a corner at the largest S, so the mean converges with 1/N² only, equally from either side of the
        // corner.
        let [top, most] = largest(2 * self.order(), |psi| self.tools_inertia(psi));
        let n = 20_000;
        let root = |i: usize| (most - self.tools_inertia(top + TAU * (i as f64 + 0.5) / n as f64)).max(0.0).sqrt();
        ((0..n).map(root).sum::<f64>() / n as f64).powi(2)
    }

    /// The motion on `mesh`; without one the share of the tools' inertia up to which there is one.
    fn solve_on(&self, mesh: &Mesh, progress: &dyn Fn(Progress)) -> Result<PeriodicMotion, f64> {
        let reached = |share: f64| {
            let stage = format!("motion of {} points, per cent of the tools", mesh.len());
            progress(Progress { done: (100.0 * share) as usize, total: 100, stage: &stage });
        };
        reached(0.0);
        let tools: Vec<f64> = (0..mesh.len()).map(|i| self.tools_inertia(mesh.point(i))).collect();
        if self.is_free() {
            return self.free_motion(&tools).ok_or(1.0);
        }
        let own: Vec<f64> = (0..mesh.len()).map(|i| self.own.at(Place::at(mesh.point(i)), mesh.point(i))[0]).collect();
        let with_share = |share: f64| InTime { own: &self.own, tools: tools.iter().map(|s| share * s).collect() };
        let from_uniform = |share: f64| {
            let inertia = mean(&own) + share * mean(&tools);
            periodic_motion::find(mesh, &with_share(share), &self.driving, |driving| {
                periodic_motion::uniform(mesh, driving, inertia)
            })
        };
        if let Some(periodic) = from_uniform(1.0) {
            return Ok(periodic);
        }
        let mut periodic = from_uniform(0.0).ok_or(0.0)?;
        let (mut share, mut step) = (0.0, SHARES[0]);
        while share < 1.0 {
            let next = f64::min(share + step, 1.0);
            match periodic_motion::solve(mesh, &with_share(next), &self.driving, periodic.clone()) {
                Some(found) => {
                    (periodic, share, step) = (found, next, 1.5 * step);
                    reached(share);
                }
                None => step *= 0.5,
            }
            if step < SHARES[1] {
                return Err(share);
            }
        }
        Ok(periodic)
    }

    /// The motion of the machine whose tools move as prescribed.
    ///
    /// # Errors
    /// Without such a motion: the torque cannot carry the load, or the inertia is too small.
    pub fn solve(&self) -> Result<Solution, Fault> {
        self.solve_with(&|_| ())
    }

    /// See [`Task::solve`]; `progress` gets the current mesh.
    ///
    /// # Errors
    /// The errors of [`Task::solve`].
    pub fn solve_with(&self, progress: &dyn Fn(Progress)) -> Result<Solution, Fault> {
        // Newton's method may find a motion on a mesh that does not resolve the place at which the machine comes to rest.
        if self.is_free() && self.own.function.constant <= self.least_inertia_without_motor() {
            return Err(self.refusal(1.0));
        }
        let Driving { load, period, motor } = self.driving;
        let course = self.loaded.as_ref().map(|loaded| loaded.motion(load, period, None)).transpose()?;
        if self.has_corners() && course.is_none() {
            self.solve_on(&self.rough_mesh(), progress).map_err(|share| self.refusal(share))?;
        }
        let mut order = self.coarsest();
        loop {
            let mesh = Mesh::new(order);
            let periodic = match &course {
                Some(course) => course.periodic(&mesh, motor),
                None => self.solve_on(&mesh, progress).map_err(|share| self.refusal(share))?,
            };
            let speed = mesh.series(&periodic.speed);
            let resolution = tail(&speed);
            if resolution <= RESOLVED || 2 * order > self.finest() {
                let factor = self.factor(&periodic, &speed);
                let loaded = course.as_ref().map(|course| (course.machine.clone(), course.start));
                let corners: Option<Arc<dyn WantedTurn>> = match course {
                    Some(course) if self.has_corners() || resolution > SMOOTH => Some(Arc::new(course)),
                    None if self.has_corners() => Some(Arc::new(Corners::new(self, &mesh, &periodic, &speed))),
                    _ => None,
                };
                return Ok(Solution { periodic, speed, resolution, factor, corners, loaded });
            }
            order *= 2;
        }
    }

    /// True if only the constant inertia turns with the shaft, and no motor drives it.
    fn is_free(&self) -> bool {
        self.driving.motor == Motor::None && !self.own.varies()
    }

    /// ω = √((2E − Ω²S)/J0), E from ⟨ω⟩ = Ω, with S at the points in `tools`; None if S is too large.
    fn free_motion(&self, tools: &[f64]) -> Option<PeriodicMotion> {
        let omega = TAU / self.driving.period?;
        let constant = self.own.function.constant;
        let most = tools.iter().copied().fold(0.0, f64::max);
        // With the square of the slowest speed instead of E, because the digits of the square matter near the bound.
        let speed = |square: f64, s: f64| (square + omega * omega * (most - s) / constant).sqrt();
        let mean_speed = |square: f64| tools.iter().map(|s| speed(square, *s)).sum::<f64>() / tools.len() as f64;
        if mean_speed(0.0) >= omega {
            return None;
        }
        let square = root(|square| mean_speed(square) - omega, [0.0, omega * omega]);
        Some(PeriodicMotion {
            speed: tools.iter().map(|s| speed(square, *s)).collect(),
            torque: vec![0.0; tools.len()],
            energy: 0.5 * (constant * square + omega * omega * most),
            mean_speed: omega,
            motor: Motor::None,
        })
    }

    /// max Ω²S / (J ω² + Ω²S).
    fn factor(&self, periodic: &PeriodicMotion, speed: &Fourier) -> f64 {
        let omega = periodic.mean_speed;
        let angle = Angle::new(speed, omega);
        let part = |psi: f64| {
            let (phi, w) = (angle.at(psi), speed.at(psi).0[0]);
            let tools = omega * omega * self.tools_inertia(psi);
            tools / (self.own.at(Place::at(phi), phi)[0] * w * w + tools)
        };
        largest(speed.order().min(96), part)[1]
    }

    fn refusal(&self, share: f64) -> Fault {
        let tau = self.driving.load;
        if share == 0.0 {
            return match self.driving.motor {
                Motor::Input => Fault::new(
                    "the motor's torque is an input, which determines no periodic motion; choose `motor.kind` = \"kloss\" or \"none\"",
                ),
                Motor::None => Fault::new("a machine without a motor keeps any speed: prescribe the period"),
                Motor::Kloss(Kloss { breakdown_torque, .. }) if tau.abs() < breakdown_torque => Fault::new(format!(
                    "no periodic motion of the machine without its tools was found with the load of {tau} N.m; list the motions of the whole machine with `camdrive steady`"
                )),
                Motor::Kloss(Kloss { breakdown_torque, breakdown_slip, .. }) => Fault::new(format!(
                    "the motor stalls: the load of {tau} N.m exceeds the stable part of its characteristic (breakdown torque {breakdown_torque} N.m at the slip {breakdown_slip})"
                )),
            };
        }
        let least = digits_beyond(self.least_inertia_without_motor(), LEAST, true);
        let constant = self.own.function.constant;
        let with_motor = || {
            let least = work::within(LEAST_INERTIA, "", &|_| (), |_| self.least_inertia()).ok().flatten();
            least.map(|j| format!(", with this motor about {j:.3} kg.m2"))
        };
        let needed = if self.driving.motor == Motor::None { None } else { with_motor() }.unwrap_or_default();
        Fault::new(format!(
            "no cam laws give the tools this motion: with J0 = {constant} kg.m2 the machine would come to rest where the tools are fastest (it needs at least {least} kg.m2 without a motor{needed}). Increase J0, or make the tools lighter or slower"
        ))
    }

    /// The least J0 (kg·m²) with a solution, to three digits; None if none is found below a thousand times the given one.
    pub fn least_inertia(&self) -> Option<f64> {
        let mesh = self.rough_mesh();
        let solvable = |constant: f64| {
            let mut task = self.clone();
            task.own.function.constant = constant;
            task.solve_on(&mesh, &|_| ()).is_ok()
        };
        let given = self.own.function.constant;
        let (mut low, mut high) = if solvable(given) {
            (0.0, given)
        } else {
            let high = (1..=10).map(|i| given * 2f64.powi(i)).find(|j| solvable(*j))?;
            (0.5 * high, high)
        };
        while high - low > 5e-4 * high {
            let middle = 0.5 * (low + high);
            if solvable(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        Some(high)
    }
}

/// φ(ψ) = ψ + ∫₀ (ω/Ω − 1) dψ.
#[derive(Clone, Debug)]
pub struct Angle {
    /// The periodic part.
    fluctuation: Fourier,
    start: f64,
}

impl Angle {
    /// The angle that belongs to the speed ω(ψ) with this mean.
    pub fn new(speed: &Fourier, mean: f64) -> Self {
        let part = |list: &[f64], sign: f64| -> Vec<f64> {
            list.iter().enumerate().map(|(k, c)| if k == 0 { 0.0 } else { sign * c / (k as f64 * mean) }).collect()
        };
        // ∫ cos kψ = sin kψ/k, ∫ sin kψ = −cos kψ/k.
        let fluctuation = Fourier::new(part(&speed.b, -1.0), part(&speed.a, 1.0));
        let start = fluctuation.at(0.0).0[0];
        Angle { fluctuation, start }
    }

    /// φ(ψ) (rad).
    pub fn at(&self, psi: f64) -> f64 {
        psi + self.fluctuation.at(psi).0[0] - self.start
    }

    /// ψ(φ) (rad), φ in one turn.
    pub fn inverse(&self, phi: f64) -> f64 {
        // φ rises all along, and φ − ψ is less than a turn. A step of Newton's method yields the last digit.
        let psi = root(|psi| self.at(psi) - phi, [phi - TAU, phi + TAU]);
        psi - (self.at(psi) - phi) / (1.0 + self.fluctuation.at(psi).0[1])
    }
}

impl Solution {
    /// 2π/T (rad/s).
    pub fn mean_speed(&self) -> f64 {
        self.periodic.mean_speed
    }

    /// φ(ψ).
    pub fn angle(&self) -> Angle {
        Angle::new(&self.speed, self.periodic.mean_speed)
    }

    /// ω (rad/s) at the angle φ (rad).
    pub fn speed_at(&self, phi: f64) -> f64 {
        let psi = self.angle().inverse(phi.rem_euclid(TAU));
        match &self.corners {
            Some(corners) => corners.instant(psi.clamp(0.0, TAU), true).speed,
            None => self.speed.at(psi).0[0],
        }
    }

    /// The least and the largest ω over the turn (rad/s).
    pub fn range(&self) -> [f64; 2] {
        range(&self.speed)
    }
}

/// The least and the largest value of a speed over the turn.
pub fn range(speed: &Fourier) -> [f64; 2] {
    let mean = speed.a[0];
    // The extremes of a value far outside plus the speed are the speed's own.
    let far = 1e3 * mean.abs();
    let order = speed.order().min(96);
    let up = largest(order, |x| far + speed.at(x).0[0])[0];
    let down = largest(order, |x| far - speed.at(x).0[0])[0];
    [speed.at(down).0[0], speed.at(up).0[0]]
}
