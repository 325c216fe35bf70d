//! The periodic motion of a machine under loads, or with a motor of any kind, whose tools move as prescribed in time.
//!
//! The angle follows from the balance of power with the tools at the phase ψ = Ωt,
//!
//! J(φ) ω̇ = M − M_L − b_L ω − τ − ½ J′ ω² + Σ R_k + (Ω/ω) [Σ U_j′ F_Lj(U_j, ΩU_j′, φ) − ½ Ω² S′(ψ)],
//!
//! φ̇ = ω, R_k the torques of followers with given cams, and the equation of the motor's state. It is integrated over a turn of
//! ψ, from one breakpoint of a law in ψ or φ to the next. Newton's method finds ω and the motor's state at ψ = 0, and Ω, such
//! that φ turns once and the others return. In machines with finished cams all followers have given cams.
//!
//! Symbols as in [`super::periodic_motion`]; F_Lj load on tool j (N or N·m), M_L, b_L load and friction of the shaft. Valid for
//! rigid followers and a motor whose rotor follows the shaft, with one state at most. Derived here.

use super::corners::{Instant, WantedTurn, merged};
use super::periodic_motion::PeriodicMotion;
use super::spectral::Mesh;
use crate::search::root;
use crate::work;
use camdrive::drives::Fault;
use camdrive::drives::drive_train::{Follower, MOST_FOLLOWERS, Machine, Shaft};
use camdrive::drives::rigid_machine::Motor;
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::shaft::motor::{Reference, Servo, Source};
use camdrive::drives::shaft::train::{Functions, InputValues, Modes, Point, Train};
use camdrive::motion::{Fourier, MotionLaw};
use camdrive::numerics::collocation::{Collocation, System};
use camdrive::numerics::double_double::Double;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// Relative error of the motion within a step; at the ends of steps it is far less.
const TOLERANCE: f64 = 1e-12;

/// Newton steps; from a far start Ω gets closer by a third at a time, and a failed step is tried by halves.
const ITERATIONS: usize = 40;
const FARTHEST: f64 = 0.3;
const HALVINGS: i32 = 10;

/// A step that changes the unknowns by this part is the last one: roundings of the turn. So is a larger one, below the other
/// limit, that gets no smaller: the knots of a table of torques leave errors of some 1e-9.
const CONVERGED: f64 = 1e-10;
const ROUGH: f64 = 1e-7;

/// The relative change of an unknown for differences, half of the digits.
const DIFFERENCE: f64 = 1e-7;

/// Work of an evaluation of the laws of a follower (nominal µs).
const COST: f64 = 2.0;

/// A machine and the loads on its followers.
#[derive(Clone, Debug)]
pub struct LoadedMachine {
    /// The shaft with its motor.
    pub machine: Machine,
    /// Followers with given cams.
    pub kept: Vec<Follower>,
    /// The tools.
    pub tools: Vec<Follower>,
}

/// Inertia and loads on both sides of the elastic shaft: those at φ and those at ψ.
#[derive(Clone, Debug)]
struct Sides {
    /// After the followers each tool as one that does not move, so that its process force is known over φ.
    own: Train,
    tools: Train,
    /// τ (N·m), and ω_ref (rad/s) of a servo.
    load: f64,
    reference: f64,
    /// Ω (rad/s).
    mean_speed: f64,
}

/// A step of the motion over |ψ|, within which no law has a breakpoint.
#[derive(Clone, Debug)]
struct Leg {
    start: f64,
    motion: Collocation<3>,
    modes: [Modes; 2],
}

/// The motion over a turn.
#[derive(Clone, Debug)]
pub struct LoadedMotion {
    /// The machine, with the synchronous speed that yields the period.
    pub machine: LoadedMachine,
    /// ω and the motor's state at ψ = 0, and Ω.
    pub start: [f64; 3],
    sides: Sides,
    legs: Vec<Leg>,
    /// ψ between the legs, from 0 to 2π.
    joints: Vec<f64>,
}

impl Sides {
    fn new(LoadedMachine { machine, kept, tools }: &LoadedMachine, load: f64, mean_speed: f64) -> Self {
        let (mut followers, mut tools) = (kept.clone(), tools.clone());
        for tool in &mut tools {
            let mut still = tool.clone();
            (still.rigid.m, still.rigid.linkage) = (0.0, Default::default());
            still.rigid.cam = MotionLaw::Fourier(Fourier::new(vec![0.0], Vec::new()));
            followers.push(still);
            tool.load.process = None;
        }
        let reference = match machine.motor.servo() {
            Some(Servo { reference: Reference::Constant(speed), .. }) => *speed,
            _ => 0.0,
        };
        let (own, at_rest) = (Shaft::Free(machine.clone()), DriveMode::Constant { w: 0.0, phi_start: 0.0 });
        let (own, tools) = (Train::new(own, followers), Train::new(Shaft::Driven(at_rest), tools));
        Sides { own, tools, load, reference, mean_speed }
    }

    /// The rates in time of φ, ω and the motor's state.
    fn rates(&self, [own, tools]: &[Modes; 2], phase: f64, y: &[f64; 3]) -> [f64; 3] {
        let (omega, mut modes) = (self.mean_speed, *own);
        let input_values = InputValues {
            shaft: [0.0; 2],
            tau: self.load,
            torque: 0.0,
            reference: self.reference,
            lag: 0.0,
            forces: [0.0; MOST_FOLLOWERS],
        };
        let motor = self.own.machine().map(|machine| &machine.motor);
        if let Some((motor, table)) = motor.and_then(|motor| Some((motor, motor.table()?))) {
            modes.piece = table.piece(motor.transmission.ratio * y[1]);
        }
        let (f, mut d) = self.own.instant(&modes, Double::from(y[0]), y, &input_values);
        if motor.and_then(|motor| motor.servo()).is_some_and(|servo| d.demand.abs() > servo.limit) {
            modes.saturation = d.demand.signum() as i8;
            d = self.own.dynamics(&Point { modes: &modes, y, f: &f, input_values: &input_values });
        }
        let t = Functions::at(&self.tools, tools, &[(phase * omega.signum()).rem_euclid(TAU); 1 + MOST_FOLLOWERS]);
        let first = self.own.followers.len() - self.tools.followers.len();
        let process: f64 = (0..self.tools.followers.len()).map(|j| t.cams[j][1] * f.process[first + j]).sum();
        let tools = t.torque + process - t.viscous * omega - t.half_slope * omega * omega;
        [y[1], d.a + omega * tools / (y[1] * f.inertia), d.rates[2]]
    }

    /// A turn from these values on; None if the machine comes to rest.
    fn turn(&self, mut y: [f64; 3]) -> Option<Vec<Leg>> {
        let ahead = self.mean_speed > 0.0;
        let there = |psi: f64| if ahead { psi } else { TAU - psi };
        let breakpoints = self.tools.laws().flat_map(|(_, law, _)| law.breakpoints());
        let mut stops: Vec<f64> = breakpoints.map(|psi| there(*psi)).chain([0.0, TAU]).collect();
        stops.sort_by(f64::total_cmp);
        let angles = |y: &[f64; 3]| self.own.angles(Double::from(y[0]), y);
        let mut modes = [Modes { segments: self.own.segments(&angles(&y), ahead), ..Modes::default() }; 2];
        let mut legs = Vec::new();
        for ends in stops.windows(2).filter(|ends| ends[0] < ends[1]) {
            let psi = there(ends[0]).rem_euclid(TAU);
            modes[1].segments = self.tools.segments(&[psi; 1 + MOST_FOLLOWERS], ahead);
            let mut motion = Collocation::new(Double::from(ends[0]), y);
            while motion.end().hi < ends[1] {
                let (start, before, evaluations) = (motion.end().hi, motion.state(), motion.statistics.evaluations);
                let way = self.own.ways(&modes[0], &angles(&before))[0][usize::from(!ahead)];
                motion.step(&OnLeg(self, &modes), Double::from(ends[1]), TOLERANCE).ok()?;
                legs.push(Leg { start, motion: motion.clone(), modes });
                let count = (motion.statistics.evaluations - evaluations) as f64;
                work::draw(COST * count * (1 + self.own.followers.len()) as f64).then_some(())?;
                let beyond = |phase: f64| (motion.at(Double::from(phase))[0] - before[0]).abs() - way;
                if beyond(motion.end().hi) >= 0.0 {
                    let at = Double::from(root(beyond, [start, motion.end().hi]));
                    y = motion.at(at);
                    self.own.cross(&mut modes[0], &angles(&y), 0, ahead);
                    motion = Collocation::new(at, y);
                }
                y = motion.state();
                if !(y[1] * self.mean_speed > 0.0) {
                    return None;
                }
            }
        }
        Some(legs)
    }
}

/// The machine while no law has a breakpoint; the independent variable is |ψ|.
struct OnLeg<'a>(&'a Sides, &'a [Modes; 2]);

impl System<3> for OnLeg<'_> {
    fn rhs(&self, t: Double, y: &[f64; 3]) -> [f64; 3] {
        self.0.rates(self.1, t.hi, y).map(|rate| rate / self.0.mean_speed.abs())
    }

    fn jacobian(&self, t: Double, y: &[f64; 3]) -> [[f64; 3]; 3] {
        let (at, scale) = (self.rhs(t, y), self.magnitude(y));
        let columns = [0, 1, 2].map(|k| {
            let mut moved = *y;
            moved[k] += DIFFERENCE * scale[k];
            let there = self.rhs(t, &moved);
            [0, 1, 2].map(|i| (there[i] - at[i]) / (moved[k] - y[k]))
        });
        [0, 1, 2].map(|i| columns.map(|column| column[i]))
    }

    fn magnitude(&self, y: &[f64; 3]) -> [f64; 3] {
        [1.0, y[1].abs(), self.0.own.constant_inertia() * y[1] * y[1]]
    }
}

impl LoadedMachine {
    /// True if a law of a load has breakpoints.
    pub fn has_corners(&self) -> bool {
        let processes = self.kept.iter().chain(&self.tools).filter_map(|follower| follower.load.process.as_ref());
        processes.chain(&self.machine.load).any(|law| !law.breakpoints().is_empty())
    }

    /// The periodic motion against the constant `load` near these values of ω and the motor's state at ψ = 0, and of Ω, else
    /// near the speed at which such a motor usually turns; with a prescribed `period` (s), it finds the synchronous speed that
    /// yields it.
    ///
    /// # Errors
    /// Without such a motion.
    pub fn motion(&self, load: f64, period: Option<f64>, near: Option<[f64; 3]>) -> Result<LoadedMotion, Fault> {
        let Machine { motor, w_start, .. } = &self.machine;
        let speed = Some(motor.usual_speed().unwrap_or(*w_start)).filter(|speed| *speed != 0.0);
        let near = near
            .or(speed.map(|speed| [speed, 0.0, speed]))
            .ok_or_else(|| Fault::new("no speed is known near which the shaft turns steadily: give start.w_start"))?;
        self.search(load, period, near).ok_or_else(|| {
            Fault::new(
                "under its loads and with its motor no periodic motion of the machine with such tools was found; a larger J0, a \
                 stronger motor, smaller loads or lighter tools help",
            )
        })
    }

    fn search(&self, load: f64, period: Option<f64>, near: [f64; 3]) -> Option<LoadedMotion> {
        let motor = &self.machine.motor;
        // Nothing moves the integrator of a proportional control.
        let moves = motor.states() > 0 && motor.servo().is_none_or(|servo| servo.integral > 0.0);
        let prescribed = period.map(|period| (TAU / period).copysign(near[2]));
        let last = prescribed.map_or(near[2], |speed| speed * motor.transmission.ratio);
        let torque = self.machine.inertia.constant * near[2] * near[2];
        let (mut x, sizes) = (Vector3::new(near[0], near[1], last), Vector3::new(near[2].abs(), torque, last.abs()));
        let at = |x: &Vector3<f64>| {
            let mut machine = self.clone();
            if let (Some(_), Source::Kloss(kloss)) = (prescribed, &mut machine.machine.motor.source) {
                kloss.synchronous_speed = x[2];
            }
            let sides = Sides::new(&machine, load, prescribed.unwrap_or(x[2]));
            let legs = sides.turn([0.0, x[0], x[1]])?;
            let end = legs.last()?.motion.at(Double::from(TAU));
            let state = if moves { end[2] - x[1] } else { x[1] };
            let missed = Vector3::new((end[1] - x[0]) / sizes[0], state / torque, end[0].abs() / TAU - 1.0);
            let start = [x[0], x[1], sides.mean_speed];
            let mut joints =
                legs.iter().map(|leg| if sides.mean_speed > 0.0 { leg.start } else { TAU - leg.start }).collect();
            merged(&mut joints);
            Some((LoadedMotion { machine, start, sides, legs, joints }, missed))
        };
        let (mut before, (_, mut missed)) = (f64::INFINITY, at(&x)?);
        for _ in 0..ITERATIONS {
            let mut jacobian = Matrix3::zeros();
            for k in 0..3 {
                let mut moved = x;
                moved[k] += DIFFERENCE * sizes[k];
                jacobian.set_column(k, &((at(&moved)?.1 - missed) / DIFFERENCE));
            }
            let step = jacobian.lu().solve(&missed)?;
            let first = (FARTHEST / step.amax()).min(1.0);
            let shaft;
            (x, (shaft, missed)) = (0..HALVINGS).find_map(|n| {
                let next = x - first * 0.5f64.powi(n) * step.component_mul(&sizes);
                Some((next, at(&next)?))
            })?;
            if step.amax() < CONVERGED || step.amax() < ROUGH && step.amax() > 0.5 * before {
                return Some(shaft);
            }
            before = step.amax();
        }
        None
    }
}

impl LoadedMotion {
    /// The motion at the points of a mesh, with the motor of this kind.
    pub fn periodic(&self, mesh: &Mesh, motor: Motor) -> PeriodicMotion {
        let motor = match self.machine.machine.motor.source {
            Source::Kloss(kloss) => Motor::Kloss(kloss),
            _ => motor,
        };
        let speed = (0..mesh.len()).map(|i| self.instant(mesh.point(i), true).speed).collect();
        PeriodicMotion { speed, torque: Vec::new(), energy: 0.0, mean_speed: self.sides.mean_speed, motor }
    }
}

impl WantedTurn for LoadedMotion {
    fn mean_speed(&self) -> f64 {
        self.sides.mean_speed
    }

    fn angles(&self) -> &[f64] {
        &self.joints
    }

    fn instant(&self, psi: f64, forward: bool) -> Instant {
        let ahead = self.sides.mean_speed > 0.0;
        let phase = if ahead { psi } else { TAU - psi };
        let begun = |leg: &Leg| if ahead == forward { leg.start <= phase } else { leg.start < phase };
        let leg = &self.legs[self.legs.partition_point(begun).max(1) - 1];
        let y = leg.motion.at(Double::from(phase));
        let [speed, change, _] = self.sides.rates(&leg.modes, phase, &y);
        let angle = if ahead { y[0] } else { TAU + y[0] };
        Instant { angle: angle.clamp(0.0, TAU), speed, change, phase: psi }
    }
}
