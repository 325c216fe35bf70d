//! The source's iteration: cut the cams for the motion found last, find the motion with these cams, and so on.
//!
//! In the angle: J_n(φ) = J_own + Σ m_j (U_j′(ψ_n) ψ_n′)² → periodic motion ω(φ), T → ψ_{n+1}′ = 2π/(T ω). Round 0 is the
//! machine with cams cut for a uniform speed, ψ_0 = φ.
//!
//! Source: K. Kaltofen, "HS-Bewegungen trotz veränderlicher Antriebsgeschwindigkeit", section 3, steps 1 to 8, and its
//! tables. (6) there holds with φ̇₀ = 2π/T, T the period that belongs to the motion.

use super::orbit::{self, Driving, Inertia, Orbit};
use super::spectral::{Mesh, amplitude, largest, mean};
use super::{Task, Tool, range};
use crate::drives::rigid_machine::Place;
use crate::motion::Fourier;
use serde::Serialize;
use std::f64::consts::TAU;

/// A harmonic of a tool counts as an extra one above this part of the largest that is wanted.
pub const EXTRA: f64 = 0.01;

/// How well a tool moves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quality {
    /// max|a| / max|a_wanted| − 1.
    pub overshoot: f64,
    /// max|a − a_wanted| / max|a_wanted| at equal phases of time.
    pub deviation: f64,
    /// How many harmonics above those of the wanted motion exceed [`EXTRA`] of its largest acceleration harmonic.
    pub extra_harmonics: usize,
    /// The highest of them.
    pub highest_extra: Option<usize>,
}

/// A round of the iteration, or a machine as it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Round {
    /// T [s].
    pub period: f64,
    /// The least and the largest ω [rad/s].
    pub speed: [f64; 2],
    /// One for each tool.
    pub tools: Vec<Quality>,
}

/// J at the points, with the cams as they are.
struct InAngle(Vec<f64>);

impl Inertia for InAngle {
    const IN_TIME: bool = false;

    fn at(&self, point: usize, _: f64) -> [f64; 2] {
        [self.0[point], 0.0]
    }

    fn tools(&self, _: usize) -> f64 {
        0.0
    }
}

/// The machine with cams as they are, on a mesh of the angle.
pub struct Machine<'a> {
    mesh: Mesh,
    task: &'a Task,
}

/// What a cam carries at the points: the moment of inertia of tool and links, and the tool's y′.
pub type Cam = Vec<[f64; 2]>;

impl<'a> Machine<'a> {
    /// The machine on a mesh of this order.
    pub fn new(task: &'a Task, order: usize) -> Self {
        Machine { mesh: Mesh::new(order), task }
    }

    /// The cam with which a tool moves as U(ψ) at the phases ψ(φ).
    pub fn cam_of_phases(&self, tool: &Tool, phases: &[f64], slopes: &[f64]) -> Cam {
        let at = |(psi, slope): (&f64, &f64)| {
            let [u, u1, ..] = tool.motion.at(*psi).0;
            tool.carried([u, u1 * slope])
        };
        phases.iter().zip(slopes).map(at).collect()
    }

    /// The cam of a tool with this law.
    pub fn cam_of_law(&self, tool: &Tool, law: &Fourier) -> Cam {
        (0..self.mesh.len())
            .map(|i| {
                let [u, u1, ..] = law.at(self.mesh.point(i)).0;
                tool.carried([u, u1])
            })
            .collect()
    }

    /// The periodic motion with these cams.
    pub fn orbit(&self, cams: &[Cam], driving: &Driving) -> Option<Orbit> {
        let inertia: Vec<f64> = (0..self.mesh.len())
            .map(|i| {
                let phi = self.mesh.point(i);
                self.task.own.at(Place::at(phi), phi)[0] + cams.iter().map(|cam| cam[i][0]).sum::<f64>()
            })
            .collect();
        let level = mean(&inertia.iter().map(|j| j.sqrt()).collect::<Vec<_>>());
        let uniform = mean(&inertia);
        let inertia = InAngle(inertia);
        // The motion without motor, of the same energy, is nearer than the uniform one.
        let start = |driving: &Driving| {
            let mut start = orbit::uniform(&self.mesh, driving, uniform)?;
            start.speed.iter_mut().zip(&inertia.0).for_each(|(w, j)| *w *= level / j.sqrt());
            start.energy = 0.5 * level * level * start.mean_speed * start.mean_speed;
            Some(start)
        };
        orbit::find(&self.mesh, &inertia, driving, start)
    }

    /// ψ(φ) and ψ′(φ) of a motion.
    fn phases(&self, orbit: &Orbit) -> (Vec<f64>, Vec<f64>) {
        let slopes: Vec<f64> = orbit.speed.iter().map(|w| orbit.mean_speed / w).collect();
        let ahead = self.mesh.integrate(&slopes);
        ((0..self.mesh.len()).map(|i| self.mesh.point(i) + ahead[i] - ahead[0]).collect(), slopes)
    }

    /// Period, speeds, and how well the tools move.
    pub fn judge(&self, orbit: &Orbit, cams: &[Cam]) -> Round {
        let (phases, slopes) = self.phases(orbit);
        let tools = self.task.tools.iter().zip(cams);
        Round {
            period: orbit.period(),
            speed: range(&self.mesh.series(&orbit.speed)),
            tools: tools.map(|(tool, cam)| self.quality(orbit, tool, cam, &phases, &slopes)).collect(),
        }
    }

    /// The accelerations of a tool [m/s² or rad/s²] at the points: ÿ = ω d(y′ω)/dφ.
    fn accelerations(&self, orbit: &Orbit, cam: &Cam) -> Vec<f64> {
        let velocity: Vec<f64> = cam.iter().zip(&orbit.speed).map(|([_, slope], w)| slope * w).collect();
        let slope = self.mesh.differentiate(&velocity);
        slope.iter().zip(&orbit.speed).map(|(s, w)| s * w).collect()
    }

    /// The phase of time ψ and the acceleration of a tool, at so many points of the turn.
    pub fn course(&self, orbit: &Orbit, cam: &Cam, points: usize) -> Vec<[f64; 2]> {
        let acceleration = self.mesh.series(&self.accelerations(orbit, cam));
        let (phases, _) = self.phases(orbit);
        let ahead: Vec<f64> = (0..self.mesh.len()).map(|i| phases[i] - self.mesh.point(i)).collect();
        let ahead = self.mesh.series(&ahead);
        (0..=points)
            .map(|i| {
                let phi = TAU * i as f64 / points as f64;
                [phi + ahead.at(phi).0[0], acceleration.at(phi).0[0]]
            })
            .collect()
    }

    /// The angle φ and the speed ω, at so many points of the turn.
    pub fn speeds(&self, orbit: &Orbit, points: usize) -> Vec<[f64; 2]> {
        let speed = self.mesh.series(&orbit.speed);
        (0..=points)
            .map(|i| {
                let phi = TAU * i as f64 / points as f64;
                [phi, speed.at(phi).0[0]]
            })
            .collect()
    }

    fn quality(&self, orbit: &Orbit, tool: &Tool, cam: &Cam, phases: &[f64], slopes: &[f64]) -> Quality {
        let mesh = &self.mesh;
        let actual = self.accelerations(orbit, cam);
        let omega = orbit.mean_speed;
        let wanted = |psi: f64| omega * omega * tool.at(psi)[2];
        let miss: Vec<f64> = actual.iter().zip(phases).map(|(a, psi)| a - wanted(*psi)).collect();
        let peak = tool.acceleration(omega)[1];
        let most = |values: &[f64]| {
            let series = mesh.series(values);
            largest(mesh.order() / 2, |phi| series.at(phi).0[0])[1]
        };
        // The harmonics of the acceleration in time; those that the mesh carries.
        let harmonic = |k: usize| {
            let (mut a, mut b) = (0.0, 0.0);
            for i in 0..mesh.len() {
                let (sin, cos) = (k as f64 * phases[i]).sin_cos();
                a += 2.0 * actual[i] * slopes[i] * cos;
                b += 2.0 * actual[i] * slopes[i] * sin;
            }
            a.hypot(b) / mesh.len() as f64
        };
        let order = tool.wanted.order();
        let largest_wanted =
            (1..=order).map(|k| amplitude(&tool.wanted, k) * (k * k) as f64 * omega * omega).fold(0.0_f64, f64::max);
        let extra: Vec<usize> =
            (order + 1..mesh.order() / 2).filter(|k| harmonic(*k) > EXTRA * largest_wanted).collect();
        Quality {
            overshoot: most(&actual) / peak - 1.0,
            deviation: most(&miss) / peak,
            extra_harmonics: extra.len(),
            highest_extra: extra.last().copied(),
        }
    }
}

/// The rounds of the iteration, from round 0 on; fewer where a round finds no motion.
pub fn rounds(task: &Task, order: usize, count: usize) -> Vec<Round> {
    let machine = Machine::new(task, order);
    let mut phases: Vec<f64> = (0..machine.mesh.len()).map(|i| machine.mesh.point(i)).collect();
    let mut slopes = vec![1.0; phases.len()];
    let mut rounds = Vec::new();
    while rounds.len() <= count {
        let cams: Vec<Cam> = task.tools.iter().map(|tool| machine.cam_of_phases(tool, &phases, &slopes)).collect();
        let Some(orbit) = machine.orbit(&cams, &task.driving) else { break };
        rounds.push(machine.judge(&orbit, &cams));
        (phases, slopes) = machine.phases(&orbit);
    }
    rounds
}
