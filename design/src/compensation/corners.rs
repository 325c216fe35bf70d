//! The wanted motion between the points of the mesh, for tools whose laws are no series: cycles, plans, tables.
//!
//! A jump of a derivative of a law makes a corner of ω(ψ), whose series then converges slowly. The sum
//!
//! P(ψ) = ½ J(φ) ω² + ½ Ω² S(ψ) = E + (1/Ω) ∫ (M − τ) ω dψ
//!
//! is two orders smoother than S, and constant without motor. From its series, with the laws' S,
//!
//! ω = √((2P − Ω²S)/J),  φ = (1/Ω) ∫ ω dψ,  J ω̇ = M − τ − ½ J′ ω² − ½ Ω³ S′/ω,
//!
//! with φ by Gauss's rule from corner to corner, and ω̇ from either side of a corner. A cam with U_cam(φ) = U(ψ) has U_cam′ =
//! U′Ω/ω and U_cam″ = (U″Ω² − U_cam′ω̇)/ω² there; they make a table whose pieces end at the corners.
//!
//! Symbols as in [`super::periodic_motion`]; valid for continuous S: no law jumps in its slope. Derived here.

use super::periodic_motion::PeriodicMotion;
use super::spectral::Mesh;
use super::{Angle, Task, Tool};
use camdrive::drives::rigid_machine::{Motor, Place};
use camdrive::motion::Fourier;
use camdrive::motion::table::Bend;
use camdrive::numerics::gauss::Gauss;
use std::f64::consts::TAU;

/// Corners closer than this (rad) are merged: ten times the least distance of a table's points.
const SAME: f64 = 1e-5;

/// The widest panel of the quadrature (rad): eight nodes meet the waves of a law in it to rounding.
const PANEL: f64 = TAU / 512.0;

/// The state of a machine at a place of its turn.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// φ (rad), in [0, 2π].
    pub angle: f64,
    /// ω (rad/s).
    pub speed: f64,
    /// ω̇ (rad/s²).
    pub change: f64,
    /// 2πt/T (rad).
    pub phase: f64,
}

/// The knots with this many parts between each and the next; without the last knot.
pub fn divided(knots: &[f64], parts: impl Fn(usize) -> usize) -> Vec<f64> {
    let between = |(i, pair): (usize, &[f64])| {
        let (from, width, n) = (pair[0], pair[1] - pair[0], parts(i));
        (0..n).map(move |j| from + width * j as f64 / n as f64)
    };
    knots.windows(2).enumerate().flat_map(between).collect()
}

/// A turn of the wanted motion, from corner to corner.
pub trait WantedTurn: std::fmt::Debug + Send + Sync {
    /// Ω (rad/s).
    fn mean_speed(&self) -> f64;

    /// ψ of the corners, from 0 to 2π.
    fn angles(&self) -> &[f64];

    /// The state of the machine at ψ, 0 ≤ ψ ≤ 2π, with ω̇ after (`forward`) or before a corner.
    fn instant(&self, psi: f64, forward: bool) -> Instant;

    /// φ(ψ) (rad), 0 ≤ ψ ≤ 2π.
    fn angle(&self, psi: f64) -> f64 {
        self.instant(psi, true).angle
    }

    /// The turn in parts of at most `widest` (rad) that end at the corners; without 2π.
    fn parts(&self, widest: f64) -> Vec<f64> {
        let angles = self.angles();
        divided(angles, |i| ((angles[i + 1] - angles[i]) / widest).ceil() as usize)
    }

    /// U_cam′ and U_cam″ on either side of ψ.
    fn bend(&self, tool: &Tool, psi: f64) -> Bend {
        let side = |forward: bool| {
            // The end of the last turn comes before the beginning of this one.
            let psi = if !forward && psi == 0.0 { TAU } else { psi };
            let Instant { speed, change, .. } = self.instant(psi, forward);
            let [_, u1, u2, ..] = tool.driven_beside(psi, forward);
            let slope = u1 * self.mean_speed() / speed;
            [slope, (u2 * self.mean_speed() * self.mean_speed() - slope * change) / (speed * speed)]
        };
        let ([slope, behind], [_, before]) = (side(true), side(false));
        Bend { slope, before, behind }
    }
}

/// The corners in their order from 0 to 2π, each once.
pub fn merged(angles: &mut Vec<f64>) {
    angles.extend([0.0, TAU]);
    angles.sort_by(f64::total_cmp);
    angles.dedup_by(|next, before| *next - *before < SAME);
    if let Some(last) = angles.last_mut() {
        *last = TAU;
    }
}

/// The motion of a machine whose tools have such laws.
#[derive(Clone, Debug)]
pub struct Corners {
    task: Task,
    motor: Motor,
    /// Ω (rad/s).
    mean_speed: f64,
    /// P(ψ) (J).
    sum: Fourier,
    /// M(ψ) (N·m) of a motor that lags.
    torque: Fourier,
    /// φ(ψ) from the mesh, on which J depends.
    near: Angle,
    /// ψ of the corners, from 0 to 2π.
    angles: Vec<f64>,
    /// ψ and φ at the ends of the panels.
    panels: Vec<[f64; 2]>,
}

impl Corners {
    /// The motion that was found on this mesh.
    pub fn new(task: &Task, mesh: &Mesh, periodic: &PeriodicMotion, speed: &Fourier) -> Self {
        let near = Angle::new(speed, periodic.mean_speed);
        let sum = |(i, w): (usize, &f64)| {
            let (psi, phi) = (mesh.point(i), near.at(mesh.point(i)));
            let turning = task.own.at(Place::at(phi), phi)[0] * w * w;
            0.5 * (turning + periodic.mean_speed * periodic.mean_speed * task.tools_inertia(psi))
        };
        let sums: Vec<f64> = periodic.speed.iter().enumerate().map(sum).collect();
        let mut angles: Vec<f64> = task.tools.iter().flat_map(|tool| tool.motion.breakpoints()).copied().collect();
        merged(&mut angles);
        let mut corners = Corners {
            task: task.clone(),
            motor: periodic.motor,
            mean_speed: periodic.mean_speed,
            sum: mesh.series(&sums),
            torque: mesh.series(&periodic.torque),
            near,
            angles,
            panels: vec![[0.0; 2]],
        };
        let ends: Vec<f64> = corners.parts(PANEL).into_iter().skip(1).chain([TAU]).collect();
        for end in ends {
            let phi = corners.angle(end);
            corners.panels.push([end, phi]);
        }
        // The error of the mesh in the mean of ω.
        let turn = corners.panels[corners.panels.len() - 1][1] / TAU;
        corners.panels.iter_mut().for_each(|[_, phi]| *phi /= turn);
        corners
    }

    /// ω(ψ) (rad/s).
    fn speed(&self, psi: f64) -> f64 {
        let (phi, omega) = (self.near.at(psi), self.mean_speed);
        let tools: f64 = self.task.tools.iter().map(|tool| tool.inertia(psi)).sum();
        let square = (2.0 * self.sum.at(psi).0[0] - omega * omega * tools) / self.task.own.at(Place::at(phi), phi)[0];
        square.max(0.0).sqrt().copysign(omega)
    }
}

impl WantedTurn for Corners {
    fn mean_speed(&self) -> f64 {
        self.mean_speed
    }

    fn angles(&self) -> &[f64] {
        &self.angles
    }

    fn angle(&self, psi: f64) -> f64 {
        let last = self.panels.partition_point(|[start, _]| *start <= psi).max(1) - 1;
        let [start, phi] = self.panels[last];
        let [more] = Gauss::with(8).integrate(psi - start, |s| [self.speed(start + s) / self.mean_speed]);
        phi + more
    }

    fn instant(&self, psi: f64, forward: bool) -> Instant {
        let (angle, w, omega) = (self.angle(psi), self.speed(psi), self.mean_speed);
        let [j, slope, ..] = self.task.own.at(Place::at(angle), angle);
        let torque =
            if self.motor.lag().is_some() { self.torque.at(psi).0[0] } else { self.motor.characteristic(w)[0] };
        let tools: f64 = self.task.tools.iter().map(|tool| tool.inertia_beside(psi, forward)[1]).sum();
        let change = (torque - self.task.driving.load - 0.5 * slope * w * w - 0.5 * omega.powi(3) * tools / w) / j;
        Instant { angle, speed: w, change, phase: psi }
    }
}
