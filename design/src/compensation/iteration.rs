//! The source's iteration: cut the cams for the last motion, find the motion with these cams, and so on.
//!
//! In the angle: J_n(φ) = J_own + Σ m_j (U_j′(ψ_n) ψ_n′)² → periodic motion ω(φ), T → ψ_{n+1}′ = 2π/(T ω). Round 0 is the
//! machine with cams cut for a uniform speed, ψ_0 = φ.
//!
//! Source: K. Kaltofen, "HS-Bewegungen trotz veränderlicher Antriebsgeschwindigkeit", section 3, steps 1 to 8, and its
//! tables. (6) there holds with φ̇₀ = 2π/T, T the period that belongs to the motion.

use super::corners::{Instant, WantedTurn as _};
use super::laws::{miss, places};
use super::loaded::LoadedMotion;
use super::periodic_motion::{self, Driving, Inertia, PeriodicMotion};
use super::restrictions::RestrictionReserve;
use super::spectral::{Mesh, amplitude, largest, largest_between, mean};
use super::{Solution, Task, Tool, range};
use camdrive::drives::rigid_machine::{Motor, Place};
use camdrive::motion::{Fourier, MotionLaw};
use serde::Serialize;
use std::f64::consts::TAU;

/// A harmonic of a tool is an extra one above this part of the largest wanted one.
pub const EXTRA: f64 = 0.01;

/// The quality of a tool's motion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quality {
    /// max|a| / max|a_wanted| − 1.
    pub overshoot: f64,
    /// max|a − a_wanted| / max|a_wanted| at equal phases of time.
    pub deviation: f64,
    /// The number of harmonics above those of the wanted motion that exceed [`EXTRA`] of its largest acceleration harmonic.
    pub extra_harmonics: usize,
    /// The highest of them.
    pub highest_extra: Option<usize>,
}

/// A round of the iteration, or a given machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Round {
    /// T (s).
    pub period: f64,
    /// The least and the largest ω (rad/s).
    pub speed: [f64; 2],
    /// One for each tool.
    pub tools: Vec<Quality>,
    /// The restrictions of the tools with their reserves.
    pub restrictions: Vec<RestrictionReserve>,
    /// φ̇ over the phase of time, φ̇₀ = 2π/T, a_m, b_m (rad/s).
    #[serde(skip)]
    pub speeds: Fourier,
    /// The motions y(ψ) of the tools over the phase of time (m or rad).
    #[serde(skip)]
    pub motions: Vec<Fourier>,
}

impl Round {
    /// Ω = 2π/T (rad/s), negative if the machine turns backwards.
    pub fn mean_speed(&self) -> f64 {
        self.speeds.a[0]
    }

    /// m²Ω² √(a² + b²): the amplitude of a harmonic of the acceleration (m/s² or rad/s²); 0 beyond the series.
    pub(super) fn harmonic(&self, series: &Fourier, m: usize) -> f64 {
        let size = if m <= series.order() { amplitude(series, m) } else { 0.0 };
        (m as f64 * self.mean_speed()).powi(2) * size
    }
}

/// J at the points, with the given cams, and dφ/dχ there.
struct InAngle<'a> {
    inertia: Vec<f64>,
    rate: &'a [f64],
}

impl Inertia for InAngle<'_> {
    const IN_TIME: bool = false;

    fn at(&self, point: usize, _: f64) -> [f64; 2] {
        [self.inertia[point], 0.0]
    }

    fn tools(&self, _: usize) -> f64 {
        0.0
    }

    fn rate(&self, point: usize) -> f64 {
        self.rate[point]
    }
}

/// The machine with given cams, at angles φ(χ) that are equidistant in χ: φ = χ itself, or the phase of time of the design,
/// which slows down a small part of the turn in which the machine almost comes to rest.
pub struct Machine<'a> {
    mesh: Mesh,
    /// φ at the points (rad).
    angles: Vec<f64>,
    /// dφ/dχ there.
    rate: Vec<f64>,
    /// ω̇ there (rad/s²), if loads make it.
    changes: Option<Vec<f64>>,
    task: &'a Task,
}

/// Load of a cam at the points: the moment of inertia J of tool and links with J′, and the tool's y, y′ and y″.
pub type Cam = Vec<[f64; 5]>;

impl<'a> Machine<'a> {
    /// The machine on a mesh of this order in the angle.
    pub fn new(task: &'a Task, order: usize) -> Self {
        let mesh = Mesh::new(order);
        let angles = (0..mesh.len()).map(|i| mesh.point(i)).collect();
        Machine { rate: vec![1.0; mesh.len()], angles, changes: None, mesh, task }
    }

    /// The machine on a mesh of this order in the phase of time of a design.
    pub fn along(task: &'a Task, order: usize, design: &Solution) -> Self {
        let (mesh, angle) = (Mesh::new(order), design.angle());
        let at = |i: usize| mesh.point(i);
        let angles = (0..mesh.len()).map(|i| angle.at(at(i)).clamp(0.0, TAU)).collect();
        let rate = (0..mesh.len()).map(|i| design.speed.at(at(i)).0[0] / design.mean_speed()).collect();
        Machine { angles, rate, changes: None, mesh, task }
    }

    /// The machine on a mesh of this order in the phase of time of its own motion, and that motion.
    pub fn on(task: &'a Task, order: usize, course: &LoadedMotion) -> (Self, PeriodicMotion) {
        let mesh = Mesh::new(order);
        let instants: Vec<Instant> = (0..mesh.len()).map(|i| course.instant(mesh.point(i), true)).collect();
        let angles = instants.iter().map(|at| at.angle).collect();
        let rate = instants.iter().map(|at| at.speed / course.mean_speed()).collect();
        let changes = Some(instants.iter().map(|at| at.change).collect());
        let periodic = course.periodic(&mesh, task.driving.motor);
        (Machine { angles, rate, changes, mesh, task }, periodic)
    }

    /// The cam with which a tool moves as U(ψ), for these phases ψ, ψ′ and ψ″.
    pub fn cam_of_phases(&self, tool: &Tool, phases: &[[f64; 3]]) -> Cam {
        let at = |[psi, slope, bend]: &[f64; 3]| {
            let [u, u1, u2, ..] = tool.driven(*psi);
            tool.carried([u, u1 * slope, u2 * slope * slope + u1 * bend])
        };
        phases.iter().map(at).collect()
    }

    /// The cam of a tool with this law.
    pub fn cam_of_law(&self, tool: &Tool, law: &MotionLaw) -> Cam {
        let at = |phi: &f64| {
            let [u, u1, u2, ..] = law.at(*phi).0;
            tool.carried([u, u1, u2])
        };
        self.angles.iter().map(at).collect()
    }

    /// The periodic motion with these cams.
    pub fn periodic_motion(&self, cams: &[Cam], driving: &Driving) -> Option<PeriodicMotion> {
        let inertia: Vec<f64> = (0..self.mesh.len()).map(|i| self.inertia(cams, i)[0]).collect();
        let over_turn =
            |f: fn(f64) -> f64| mean(&inertia.iter().zip(&self.rate).map(|(j, g)| f(*j) * g).collect::<Vec<_>>());
        let (level, uniform) = (over_turn(f64::sqrt), over_turn(|j| j));
        // The motion without motor, J ω² = const; with a motor it is closer than the uniform one.
        let start = |driving: &Driving| {
            let mut start = periodic_motion::uniform(&self.mesh, driving, uniform)?;
            start.speed.iter_mut().zip(&inertia).for_each(|(w, j)| *w *= level / j.sqrt());
            start.energy = 0.5 * level * level * start.mean_speed * start.mean_speed;
            Some(start)
        };
        if driving.motor == Motor::None {
            return start(driving);
        }
        periodic_motion::find(&self.mesh, &InAngle { inertia: inertia.clone(), rate: &self.rate }, driving, start)
    }

    /// J and J′ at a point.
    fn inertia(&self, cams: &[Cam], i: usize) -> [f64; 2] {
        let [j, slope, ..] = self.task.own.at(Place::at(self.angles[i]), self.angles[i]);
        cams.iter().fold([j, slope], |[j, slope], cam| [j + cam[i][0], slope + cam[i][1]])
    }

    /// ω̇ (rad/s²) at the points, J ω̇ = M − τ − ½ J′ ω².
    fn changes(&self, periodic: &PeriodicMotion, cams: &[Cam]) -> Vec<f64> {
        if let Some(changes) = &self.changes {
            return changes.clone();
        }
        let at = |(i, (w, torque)): (usize, (&f64, &f64))| {
            let [j, slope] = self.inertia(cams, i);
            (torque - self.task.driving.load - 0.5 * slope * w * w) / j
        };
        periodic.speed.iter().zip(&periodic.torque).enumerate().map(at).collect()
    }

    /// ψ(φ), ψ′ = Ω/ω and ψ″ = −Ωω̇/ω³ of a motion.
    fn phases(&self, periodic: &PeriodicMotion, changes: &[f64]) -> Vec<[f64; 3]> {
        let slopes: Vec<f64> = periodic.speed.iter().map(|w| periodic.mean_speed / w).collect();
        let ahead = self.mesh.integrate(&slopes.iter().zip(&self.rate).map(|(s, g)| s * g).collect::<Vec<_>>());
        let at = |i: usize| {
            let bend = -slopes[i] * changes[i] / periodic.speed[i].powi(2);
            [self.mesh.point(i) + ahead[i] - ahead[0], slopes[i], bend]
        };
        (0..self.mesh.len()).map(at).collect()
    }

    /// The largest error of a tool's acceleration in a motion with this law of its cam, relative to the largest wanted one, at
    /// equal phases of time; `design` as in [`Machine::along`].
    pub fn miss(&self, periodic: &PeriodicMotion, tool: &Tool, law: &MotionLaw, design: &Solution) -> f64 {
        let angle = design.angle();
        let fastest = self.rate.iter().copied().fold(1.0, f64::max);
        let phases = self.phases(periodic, &vec![0.0; self.mesh.len()]);
        let ahead: Vec<f64> = (0..self.mesh.len()).map(|i| phases[i][0] - self.mesh.point(i)).collect();
        let (speed, ahead) = (self.mesh.series(&periodic.speed), self.mesh.series(&ahead));
        let instant = |chi: f64| {
            let [w, slope, ..] = speed.at(chi).0;
            Instant {
                angle: angle.at(chi).rem_euclid(TAU),
                speed: w,
                change: w * slope * design.mean_speed() / design.speed.at(chi).0[0],
                phase: chi + ahead.at(chi).0[0],
            }
        };
        let miss = |chi: f64| miss(tool, law, periodic.mean_speed, instant(chi));
        largest_between(&places(law, &angle, fastest), miss)[1] / tool.acceleration(periodic.mean_speed)[1]
    }

    /// Period, speeds, and quality of the tools' motions.
    pub fn judge(&self, periodic: &PeriodicMotion, cams: &[Cam]) -> Round {
        let changes = self.changes(periodic, cams);
        let phases = self.phases(periodic, &changes);
        // dt = ψ′T/2π dφ, φ̇ψ′ = 2π/T.
        let speeds = self.over_time(&phases, |_| periodic.mean_speed);
        let motions: Vec<Fourier> = cams.iter().map(|cam| self.motion(cam, &phases)).collect();
        let tools = self.task.tools.iter().zip(cams).zip(&motions);
        let quality = |((tool, cam), motion): ((&Tool, &Cam), &Fourier)| {
            let accelerations = periodic.speed.iter().zip(&changes).zip(cam);
            let accelerations = accelerations.map(|((w, change), [.., y1, y2])| y2 * w * w + y1 * change).collect();
            self.quality(periodic.mean_speed, tool, accelerations, &phases, motion)
        };
        Round {
            period: periodic.period(),
            speed: range(&self.mesh.series(&periodic.speed)),
            tools: tools.map(quality).collect(),
            restrictions: self.task.restrictions.kept(&motions),
            speeds,
            motions,
        }
    }

    /// The series in ψ with the coefficients (1/π) ∫ f cos mψ dφ and (1/π) ∫ f sin mψ dφ and the constant (1/2π) ∫ f dφ, `f` at
    /// the points. On equal steps of χ it is exact to rounding, up to the harmonics whose waves in χ the mesh resolves.
    fn over_time(&self, phases: &[[f64; 3]], f: impl Fn(usize) -> f64) -> Fourier {
        let n = self.mesh.len();
        let fastest = (0..n).map(|i| phases[i][1] * self.rate[i]).fold(1.0, f64::max);
        let order = (self.mesh.order() as f64 / fastest) as usize;
        let (mut a, mut b) = (vec![0.0; order + 1], vec![0.0; order + 1]);
        for (i, [psi, ..]) in phases.iter().enumerate() {
            let weight = 2.0 * f(i) * self.rate[i] / n as f64;
            for m in 0..=order {
                let (sin, cos) = (m as f64 * psi).sin_cos();
                a[m] += weight * cos;
                b[m] += weight * sin;
            }
        }
        a[0] *= 0.5;
        Fourier::new(a, b)
    }

    /// y(ψ) of a tool: by parts, (1/π) ∫ y cos mψ dψ = −(1/πm) ∫ y′ sin mψ dφ, and with sine in the same way.
    fn motion(&self, cam: &Cam, phases: &[[f64; 3]]) -> Fourier {
        let velocity = self.over_time(phases, |i| cam[i][3]);
        let part =
            |list: &[f64], sign: f64| list.iter().zip(0..).map(|(c, m)| sign * c / f64::max(m.into(), 1.0)).collect();
        let (mut a, b): (Vec<f64>, Vec<f64>) = (part(&velocity.b, -1.0), part(&velocity.a, 1.0));
        a[0] = mean(&(0..cam.len()).map(|i| cam[i][2] * phases[i][1] * self.rate[i]).collect::<Vec<_>>());
        Fourier::new(a, b)
    }

    /// The quality of a tool's motion with these accelerations (m/s² or rad/s²) at the points; if laws have corners, the
    /// largest ones are searched at the points alone.
    fn quality(&self, omega: f64, tool: &Tool, actual: Vec<f64>, phases: &[[f64; 3]], motion: &Fourier) -> Quality {
        let mesh = &self.mesh;
        let prescribed: Vec<f64> = phases.iter().map(|[psi, ..]| omega * omega * tool.at(*psi)[2]).collect();
        let miss: Vec<f64> = actual.iter().zip(&prescribed).map(|(a, wanted)| a - wanted).collect();
        let most = |values: &[f64]| {
            if self.task.has_corners() {
                return values.iter().fold(0.0, |most: f64, a| most.max(a.abs()));
            }
            let series = mesh.series(values);
            largest(mesh.order() / 2, |phi| series.at(phi).0[0])[1]
        };
        // At the same points, so that values between them do not count as an overshoot.
        let peak = if self.task.has_corners() { most(&prescribed) } else { tool.acceleration(omega)[1] };
        let order = tool.wanted.order();
        let harmonic = |series: &Fourier, k: usize| amplitude(series, k) * (k * k) as f64;
        let largest_wanted = (1..=order).map(|k| harmonic(&tool.wanted, k)).fold(0.0_f64, f64::max);
        let extra: Vec<usize> =
            (order + 1..=motion.order()).filter(|k| harmonic(motion, *k) > EXTRA * largest_wanted).collect();
        Quality {
            overshoot: most(&actual) / peak - 1.0,
            deviation: most(&miss) / peak,
            extra_harmonics: extra.len(),
            highest_extra: extra.last().copied(),
        }
    }
}

/// The rounds of the iteration, from round 0 on; fewer if a round finds no motion.
pub fn rounds(task: &Task, order: usize, count: usize) -> Vec<Round> {
    let machine = Machine::new(task, order);
    let mut phases: Vec<[f64; 3]> = machine.angles.iter().map(|phi| [*phi, 1.0, 0.0]).collect();
    let mut rounds = Vec::new();
    while rounds.len() <= count {
        let cams: Vec<Cam> = task.tools.iter().map(|tool| machine.cam_of_phases(tool, &phases)).collect();
        let Some(periodic) = machine.periodic_motion(&cams, &task.driving) else { break };
        rounds.push(machine.judge(&periodic, &cams));
        phases = machine.phases(&periodic, &machine.changes(&periodic, &cams));
    }
    rounds
}
