//! Shaft and followers as one system with the states φ, φ̇, those of the motor and those of the followers.
//!
//! ```text
//! J φ̈ = M_an − M_L(φ) − b_L φ̇ − τ − ½ J′ φ̇² − Σ R_j
//!
//! follower         states      equation                                                   R_j
//! rigid            –           y = U                                                      −U′ F_L
//! elastic output   q, q̇        m ÿ = F + F_L,  F = −(c q + b q̇),  y = U + q               U′ (F − F_Lx)
//! elastic shaft    q, q̇        (J3 + m U′²) ψ̈ + m U′U″ ψ̇² = T + U′ F_L,  ψ = φ + q        T = −(c q + b q̇)
//! backlash         q, q̇        in contact: m2 ẍ2 = S + F_L2,  S = −(c q + b q̇)            U′ (S − F_L1)
//!                  z, ż        in flight: m1 ẍ1 = −S + F_L1,  x1 = U + z (+ s where z counts from flank B)    0
//! ```
//!
//! J collects J0, J_φ(φ), the rotor of a stiff transmission and m U′² of what follows the shaft without slip: rigid followers,
//! m_x of elastic outputs, m1 in contact. φ̈ follows explicitly, since springs and dampers depend on states only.
//!
//! Symbols: m mass (kg) or moment of inertia where the follower turns; U(φ) of the cam, U(ψ) behind an elastic shaft; F_L load on
//! the tool, F_Lx and F_L1 on the mass on the cam's side; τ an input, positive brakes. N, the force of the cam on the follower in
//! the sense of y, is F + m_x ẍ − F_Lx, or F_K = m1 ẍ1 + S − F_L1 with backlash. Without m2 all loads act on m1.
//!
//! What depends on φ alone (J, static loads of what follows without slip) is summed up as one function of the angle, so that
//! rigid followers cost next to nothing.
//!
//! Valid for rigid links, linear springs and dampers, impacts without duration. Source: Dresig, Holzweißig,
//! *Maschinendynamik*, chapter 2; the equations of the parts as in their own modules.

pub mod motor;
mod rest;
pub mod switching;

use super::cam_drive::DriveMode;
use super::free::coupled::{Loads, Named};
use super::free::inertia::InertiaFunction;
use super::free::signal::Signal;
use super::motor::Motor;
use crate::drives::follower::contact::Mode;
use crate::drives::follower::load::Load;
use crate::drives::follower::member::{Follower, Joint};
use crate::drives::follower::place::ends;
use crate::motion::MotionLaw;
use crate::motion::turn;
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use crate::numerics::taylor::{Arithmetic, Scalar, Series};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The most followers.
pub const MOST_FOLLOWERS: usize = 16;

/// The most states: shaft, motor, coupling, followers.
pub const MOST_STATES: usize = 6 + 4 * MOST_FOLLOWERS;

/// The shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(clippy::large_enum_variant)] // One of them lives in a train.
pub enum Shaft {
    /// Its motion is prescribed.
    Driven(DriveMode),
    /// It is free under its torques.
    Free(Machine),
}

/// A free shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// J0 and J_v.
    pub inertia: InertiaFunction,
    /// M_L(φ) (N·m) against the sense of φ.
    pub load: Option<MotionLaw>,
    /// b_L (N·m·s/rad).
    pub friction: Option<f64>,
    /// The loads that other units put on it.
    pub loads: Vec<Named>,
    /// The motor.
    pub motor: Motor,
    /// φ at the start (rad).
    pub phi_start: f64,
    /// φ̇ at the start (rad/s), except on a periodic motion.
    pub w_start: f64,
}

/// Shaft and followers, and where their states are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Train {
    /// The shaft.
    pub shaft: Shaft,
    /// The followers.
    pub followers: Vec<Follower>,
    /// Where the states of the motor, of its coupling and of each follower begin; how many there are in all.
    pub layout: Layout,
}

/// Where states begin.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Layout {
    /// M of a motor with a lag; I, and e of a servo.
    pub motor: usize,
    /// θ, θ̇.
    pub coupling: usize,
    /// q, q̇, and with backlash z, ż before them.
    pub followers: Vec<usize>,
    /// How many states there are.
    pub count: usize,
}

/// What changes at events only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Modes {
    /// The segment of each law: of J_φ and M_L, then of cam and process force of each follower.
    pub segments: [[usize; 2]; 1 + MOST_FOLLOWERS],
    /// Where m1 of each follower is.
    pub contacts: [Mode; MOST_FOLLOWERS],
    /// Whether z counts from flank B, the one that m1 has been at last.
    pub beyond: [bool; MOST_FOLLOWERS],
    /// The order of the zero with which the gap of each follower begins.
    pub zeros: [usize; MOST_FOLLOWERS],
    /// Whether the servo is at its limit, and which.
    pub saturation: i8,
    /// The piece of the torque table: 0 below its first speed.
    pub piece: usize,
}

impl Modes {
    /// The place of x1 − U at which z is zero, with the clearance `s` (m).
    pub fn home(&self, j: usize, s: f64) -> f64 {
        if self.beyond[j] { s } else { 0.0 }
    }
}

/// What goes with the shaft without slip, as power series about the present angle: Σ cₙ xⁿ.
pub struct Sums<const N: usize> {
    /// J.
    pub inertia: [f64; N],
    /// Static loads.
    pub torque: [f64; N],
    /// Damping.
    pub viscous: [f64; N],
}

/// Functions of the angle at an instant.
pub struct Functions<S> {
    /// J.
    pub inertia: S,
    /// ½ J′.
    pub half_slope: S,
    /// Static loads (N·m), positive drive.
    pub torque: S,
    /// Damping of shaft and followers (N·m·s).
    pub viscous: S,
    /// U, U′, U″ of each follower.
    pub cams: [[S; 3]; MOST_FOLLOWERS],
    /// P of each follower.
    pub process: [S; MOST_FOLLOWERS],
}

/// The inputs of a train beside those of a driven shaft.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    /// τ, or what other loads tell.
    pub loads: Loads,
    /// M.
    pub torque: Signal,
    /// ω_ref.
    pub reference: Signal,
    /// φ_ref.
    pub position: Signal,
    /// F on each tool.
    pub forces: Vec<Signal>,
}

impl Inputs {
    /// Those of so many followers under these loads.
    pub fn of(followers: usize, loads: &[Named]) -> Self {
        Inputs { loads: Loads::new(loads), forces: vec![Signal::default(); followers], ..Inputs::default() }
    }

    /// All of them.
    pub fn all(&mut self) -> impl Iterator<Item = &mut Signal> {
        let others = [&mut self.torque, &mut self.reference, &mut self.position];
        self.loads.all().chain(others).chain(&mut self.forces)
    }

    /// All but those of loads.
    pub fn beside_loads(&mut self) -> impl Iterator<Item = &mut Signal> {
        [&mut self.torque, &mut self.reference, &mut self.position].into_iter().chain(&mut self.forces)
    }

    fn each(&self) -> impl Iterator<Item = &Signal> {
        self.loads.each().chain([&self.torque, &self.reference, &self.position]).chain(&self.forces)
    }

    /// Takes over the courses of others of the same train, without taking memory.
    pub fn take(&mut self, other: &Self) {
        self.all().zip(other.each()).for_each(|(own, other)| own.clone_from(other));
    }

    /// Whether they are as many as those of the same train.
    pub fn fit(&self, made: &Self) -> bool {
        self.loads.fit(&made.loads) && self.forces.len() == made.forces.len()
    }

    /// Whether none depends on time.
    pub fn are_constant(&self) -> bool {
        self.each().all(Signal::is_constant)
    }

    /// Whether they are set to the same courses.
    pub fn are_like(&self, other: &Self) -> bool {
        self.each().zip(other.each()).all(|(one, other)| one.is_like(other))
    }
}

/// What comes from outside.
#[derive(Clone, Copy)]
pub struct Given<S> {
    /// φ̇, φ̈ of a driven shaft.
    pub course: [S; 2],
    /// τ.
    pub tau: S,
    /// M of a motor that is an input.
    pub torque: S,
    /// ω_ref of a servo.
    pub reference: S,
    /// e of a servo whose position is an input.
    pub lag: S,
    /// F on each tool.
    pub forces: [S; MOST_FOLLOWERS],
}

/// Accelerations and forces.
pub struct Dynamics<S> {
    /// φ̈.
    pub a: S,
    /// Torque on the shaft.
    pub torque: S,
    /// u of a servo, else ω_m.
    pub demand: S,
    /// The rates of the states.
    pub rates: [S; MOST_STATES],
    /// Spring forces F, S; of an elastic shaft its torque.
    pub spring: [S; MOST_FOLLOWERS],
    /// N of followers with backlash in contact.
    pub normal: [S; MOST_FOLLOWERS],
    /// φ̈_m.
    pub rotor: S,
    /// Of each follower ẍ1 or ψ̈, and ÿ of the mass behind a spring.
    pub accelerations: [[S; 2]; MOST_FOLLOWERS],
}

impl Train {
    /// Whether these may be modes of this train, whose laws may have other pieces.
    pub fn takes(&self, modes: &Modes) -> bool {
        let motor = self.machine().map(|machine| &machine.motor);
        let knots = motor.and_then(|motor| motor.table()).map_or(0, |table| table.speeds.len());
        let saturates = motor.is_some_and(|motor| motor.servo().is_some());
        let is_of = |j: usize, mode: &Mode| *mode == Mode::Free || self.has_clearance(j);
        modes.contacts.iter().enumerate().all(|(j, mode)| is_of(j, mode))
            && modes.piece <= knots
            && modes.saturation.abs() <= i8::from(saturates)
    }

    /// Whether there is a follower j with backlash.
    pub fn has_clearance(&self, j: usize) -> bool {
        self.followers.get(j).is_some_and(|follower| matches!(follower.joint, Joint::Backlash(_)))
    }

    /// Whether these segments are some of its laws.
    pub fn has_segments(&self, segments: &[[usize; 2]]) -> bool {
        self.laws().all(|(number, law, _)| segments[number / 2][number % 2] < law.breakpoints().len().max(1))
    }

    /// The train of these parts.
    pub fn new(shaft: Shaft, followers: Vec<Follower>) -> Self {
        let mut layout = Layout::default();
        let mut count = 0;
        if let Shaft::Free(machine) = &shaft {
            layout.motor = 2;
            layout.coupling = 2 + machine.motor.states();
            count = layout.coupling + if machine.motor.transmission.coupling.is_some() { 2 } else { 0 };
        }
        for follower in &followers {
            layout.followers.push(count);
            count += follower.joint.states();
        }
        layout.count = count;
        Train { shaft, followers, layout }
    }

    /// The free shaft.
    pub fn machine(&self) -> Option<&Machine> {
        if let Shaft::Free(machine) = &self.shaft { Some(machine) } else { None }
    }

    /// The same, to change it.
    pub fn machine_mut(&mut self) -> Option<&mut Machine> {
        if let Shaft::Free(machine) = &mut self.shaft { Some(machine) } else { None }
    }

    /// Whether other equations may hold after an event.
    pub fn switches(&self) -> bool {
        let motor = self.machine().map(|machine| &machine.motor);
        let clearance = self.followers.iter().any(|follower| matches!(follower.joint, Joint::Backlash(_)));
        clearance || motor.is_some_and(|motor| motor.servo().is_some() || motor.table().is_some())
    }

    /// Whether a follower that is not rigid, or one with an input, is taken at φ.
    pub fn needs_cams_at_phi(&self) -> bool {
        self.followers.iter().any(|f| match f.joint {
            Joint::Rigid => f.load.input,
            Joint::Shaft(_) => f.load.process.is_some(),
            Joint::Output(..) | Joint::Backlash(_) => true,
        })
    }

    /// J as far as it depends on no angle.
    pub fn constant_inertia(&self) -> f64 {
        self.machine().map_or(0.0, |machine| machine.inertia.constant + machine.motor.stiff_rotor())
    }

    /// b_L.
    pub fn constant_friction(&self) -> f64 {
        self.machine().and_then(|machine| machine.friction).unwrap_or(0.0)
    }

    /// The laws with their numbers in [`Modes::segments`] and the angles at which they are taken: 0 is φ, 1 + j is ψ of follower j.
    pub fn laws(&self) -> impl Iterator<Item = (usize, &MotionLaw, usize)> {
        let machine = self.machine();
        let of_machine = [machine.and_then(|m| m.inertia.varying.as_ref()), machine.and_then(|m| m.load.as_ref())];
        let of_followers = self.followers.iter().enumerate().flat_map(|(j, follower)| {
            let angle = if let Joint::Shaft(_) = follower.joint { 1 + j } else { 0 };
            [Some((2 + 2 * j, &follower.rigid.cam, angle)), follower.load.process.as_ref().map(|p| (3 + 2 * j, p, 0))]
        });
        of_machine.into_iter().enumerate().map(|(i, law)| law.map(|law| (i, law, 0))).chain(of_followers).flatten()
    }

    /// The angles, reduced to one turn, where the shaft is at `phi` and the states are `y`.
    pub fn angles(&self, phi: Double, y: &[f64]) -> [f64; 1 + MOST_FOLLOWERS] {
        let mut angles = [0.0; 1 + MOST_FOLLOWERS];
        angles[0] = angle::reduce(phi);
        for (j, follower) in self.followers.iter().enumerate() {
            if let Joint::Shaft(_) = follower.joint {
                angles[1 + j] = angle::reduce(phi + Double::from(y[self.layout.followers[j]]));
            }
        }
        angles
    }

    /// The functions of the angle to `count` coefficients of U, of J′ and U″ to three less; U and P of each follower go to `take`.
    pub fn functions<const N: usize>(
        &self,
        modes: &Modes,
        angles: &[f64],
        count: usize,
        mut take: impl FnMut(usize, &[f64; N], &[f64; N]),
    ) -> Sums<N> {
        let zero = [0.0; N];
        let about = |number: usize, law: &MotionLaw, angle: usize| {
            let (segment, phi, mut row) = (modes.segments[number / 2][number % 2], angles[angle], zero);
            if N <= 5 {
                row.copy_from_slice(&Series::of_derivatives(law.at_in(segment, phi).0).0[..N]);
            } else {
                law.expand(segment, phi, 1.0, &mut row[..count.max(6)]);
            }
            row
        };
        let machine = self.machine();
        let own = |number: usize, law: Option<&MotionLaw>| law.map_or(zero, |law| about(number, law, 0));
        let mut sums = Sums {
            inertia: own(0, machine.and_then(|m| m.inertia.varying.as_ref())),
            torque: own(1, machine.and_then(|m| m.load.as_ref())).map(|c| -c),
            viscous: zero,
        };
        sums.inertia[0] += self.constant_inertia();
        sums.viscous[0] += self.constant_friction();
        for (j, follower) in self.followers.iter().enumerate() {
            let angle = if let Joint::Shaft(_) = follower.joint { 1 + j } else { 0 };
            let mut cam = about(2 + 2 * j, &follower.rigid.cam, angle);
            let process = own(3 + 2 * j, follower.load.process.as_ref());
            self.add_follower(&mut sums, follower, modes.contacts[j], Rows { cam: &mut cam, process: &process, count });
            take(j, &cam, &process);
        }
        sums
    }

    /// Adds what of a follower goes with the shaft without slip.
    fn add_follower<const N: usize>(&self, sums: &mut Sums<N>, follower: &Follower, contact: Mode, rows: Rows<N>) {
        let Rows { cam, process, count } = rows;
        // Inertia and weight of what moves by `path`, with its loads at `path` + `away`.
        let mut add = |[m, weight]: [f64; 2], load: &Load, away: f64, path: &[f64; N], process: &[f64; N]| {
            let mut slope = [0.0; N];
            (1..count).for_each(|n| slope[n - 1] = n as f64 * path[n]);
            if m != 0.0 {
                accumulate(&mut sums.inertia, m, &slope, &slope, count);
            }
            if !load.is_none() {
                let mut force = *process;
                (0..count).for_each(|n| force[n] -= load.stiffness() * path[n]);
                force[0] += load.constant_part(weight) - load.stiffness() * away;
                accumulate(&mut sums.torque, 1.0, &force, &slope, count);
                if let Some(b) = load.damping {
                    accumulate(&mut sums.viscous, b, &slope, &slope, count);
                }
            }
        };
        let (own, none) = (follower.rigid.m, [0.0; N]);
        match follower.joint {
            Joint::Rigid if follower.rigid.linkage.is_empty() => add([own; 2], &follower.load, 0.0, cam, process),
            Joint::Rigid => {
                let moved = follower.rigid.linkage.moved(0.0, Series(*cam), &follower.load.frames);
                add([own; 2], &follower.load, 0.0, &moved.tool.0, process);
                sums.inertia.iter_mut().zip(moved.inertia.0).for_each(|(sum, own)| *sum += own);
                (1..count).for_each(|n| sums.torque[n - 1] += n as f64 * moved.weight.0[n]);
                *cam = moved.tool.0;
            }
            Joint::Output(_, m_x) => add([m_x; 2], &follower.roller, 0.0, cam, &none),
            Joint::Shaft(_) => {}
            Joint::Backlash(p) => {
                if let Mode::Contact(flank) = contact {
                    let away = flank.pick(0.0, p.s);
                    add([p.m1; 2], &follower.roller, away, cam, &none);
                    if p.m2 == 0.0 {
                        add([0.0, p.m1], &follower.load, away, cam, process);
                    }
                }
            }
        }
    }

    /// J, ½ J′ and T of tool and links of follower j at `phi`, T the torque of the links' weight; None without mechanisms.
    pub fn links<S: Scalar>(&self, modes: &Modes, j: usize, phi: S) -> Option<[S; 3]> {
        let follower = &self.followers[j];
        if follower.rigid.linkage.is_empty() {
            return None;
        }
        let lever = follower.rigid.cam.at_in(modes.segments[1 + j][0], phi.value()).0;
        let lever = Series::of_derivatives(lever);
        let moved = follower.rigid.linkage.moved(follower.rigid.m, lever, &follower.load.frames);
        let [inertia, weight] = [moved.inertia, moved.weight.slope()].map(Series::derivatives);
        let of = |d: [f64; 5], n: usize| phi.compose([d[n], d[n + 1], d[n + 2]]);
        Some([of(inertia, 0), of(inertia, 1) * 0.5, of(weight, 0)])
    }

    /// F_L on m1 of follower j, which has the place x1, ẋ1.
    pub fn load_of_m1<S: Arithmetic>(&self, j: usize, x1: [S; 2], process: S, input: S) -> S {
        let Follower { joint, load, roller, .. } = &self.followers[j];
        let Joint::Backlash(p) = *joint else { return S::from(0.0) };
        let own = roller.force(p.m1, x1, None, None);
        if p.m2 > 0.0 { own } else { own + load.force(p.m1, x1, Some(process), Some(input)) }
    }

    /// Accelerations and forces in the states `y`.
    pub fn dynamics<S: Arithmetic>(&self, modes: &Modes, y: &[S], f: &Functions<S>, given: &Given<S>) -> Dynamics<S> {
        let zero = S::from(0.0);
        let mut d = Dynamics {
            a: given.course[1],
            torque: zero,
            demand: zero,
            rates: [zero; MOST_STATES],
            spring: [zero; MOST_FOLLOWERS],
            normal: [zero; MOST_FOLLOWERS],
            rotor: zero,
            accelerations: [[zero; 2]; MOST_FOLLOWERS],
        };
        let machine = self.machine();
        let w = if machine.is_some() { y[1] } else { given.course[0] };
        let mut resistance = given.tau - f.torque + f.viscous * w + f.half_slope * (w * w);
        for (j, follower) in self.followers.iter().enumerate() {
            let [_, u1, _] = f.cams[j];
            let spring = |[c, b]: [f64; 2], at: usize| -(y[at] * c + y[at + 1] * b);
            let at = self.layout.followers[j];
            match follower.joint {
                Joint::Rigid => resistance = resistance - u1 * given.forces[j],
                Joint::Output(p, _) => {
                    d.spring[j] = spring([p.c, p.b], at);
                    resistance = resistance + u1 * d.spring[j];
                }
                Joint::Shaft(p) => {
                    d.spring[j] = spring([p.c, p.b], at);
                    resistance = resistance + d.spring[j];
                }
                Joint::Backlash(p) => {
                    if p.m2 > 0.0 {
                        d.spring[j] = spring([p.c, p.b], at + 2);
                    }
                    if modes.contacts[j] != Mode::Free {
                        let held = if p.m2 > 0.0 { d.spring[j] } else { -given.forces[j] };
                        resistance = resistance + u1 * held;
                    }
                }
            }
        }
        if let Some(machine) = machine {
            machine.motor.drive(modes, y, &self.layout, given, &mut d);
            d.a = (d.torque - resistance) / f.inertia;
            (d.rates[0], d.rates[1]) = (w, d.a);
            machine.motor.follow(&self.layout, &mut d);
        }
        for j in 0..self.followers.len() {
            self.move_follower(j, &Motion { modes, y, f, given, w }, &mut d);
        }
        d
    }

    /// What brakes the shaft at constant speed but for the change of the inertia, where these are the forces of the springs.
    pub fn reactions<S: Arithmetic>(
        &self,
        modes: &Modes,
        f: &Functions<S>,
        given: &Given<S>,
        w: S,
        spring: &[S; MOST_FOLLOWERS],
    ) -> S {
        let still = f.viscous * w - f.torque;
        self.followers.iter().enumerate().fold(still, |sum, (j, follower)| match follower.joint {
            Joint::Rigid => sum - f.cams[j][1] * given.forces[j],
            Joint::Output(..) => sum + f.cams[j][1] * spring[j],
            Joint::Shaft(_) => sum + spring[j],
            Joint::Backlash(_) if modes.contacts[j] == Mode::Free => sum,
            Joint::Backlash(p) if p.m2 > 0.0 => sum + f.cams[j][1] * spring[j],
            Joint::Backlash(_) => sum - f.cams[j][1] * given.forces[j],
        })
    }

    /// The rates of the states of follower j, and N in contact.
    fn move_follower<S: Arithmetic>(&self, j: usize, motion: &Motion<S>, d: &mut Dynamics<S>) {
        let Motion { modes, y, f, given, w } = *motion;
        let (follower, at) = (&self.followers[j], self.layout.followers[j]);
        let ([u, u1, u2], process, input) = (f.cams[j], f.process[j], given.forces[j]);
        let on_tool = |m: f64, y: [S; 2]| follower.load.force(m, y, Some(process), Some(input));
        match follower.joint {
            Joint::Rigid => {}
            Joint::Output(p, _) => {
                let (q, v) = (y[at], y[at + 1]);
                let x2 = u2 * (w * w) + u1 * d.a;
                let force = d.spring[j] + on_tool(p.m, [u + q, u1 * w + v]);
                let tool = force * (1.0 / p.m);
                d.accelerations[j][1] = tool;
                (d.rates[at], d.rates[at + 1]) = (v, tool - x2);
            }
            Joint::Shaft(p) => {
                let speed = w + y[at + 1];
                let force = on_tool(p.m, [u, u1 * speed]) - u2 * (speed * speed) * p.m;
                let inertia = u1 * u1 * p.m + S::from(p.inertia);
                let cam = (d.spring[j] + u1 * force) / inertia;
                d.accelerations[j][0] = cam;
                (d.rates[at], d.rates[at + 1]) = (y[at + 1], cam - d.a);
            }
            Joint::Backlash(p) => {
                let x2 = u2 * (w * w) + u1 * d.a;
                let place = match modes.contacts[j] {
                    Mode::Contact(flank) => [u + S::from(flank.pick(0.0, p.s)), u1 * w],
                    Mode::Free => [u + y[at] + S::from(modes.home(j, p.s)), u1 * w + y[at + 1]],
                };
                let own = self.load_of_m1(j, place, process, input);
                let a1 = if modes.contacts[j] == Mode::Free {
                    let a1 = (own - d.spring[j]) * (1.0 / p.m1);
                    (d.rates[at], d.rates[at + 1]) = (y[at + 1], a1 - x2);
                    a1
                } else {
                    d.normal[j] = x2 * p.m1 + d.spring[j] - own;
                    x2
                };
                d.accelerations[j][0] = a1;
                if p.m2 > 0.0 {
                    let (q, v) = (y[at + 2], y[at + 3]);
                    let force = d.spring[j] + on_tool(p.m2, [place[0] + q, place[1] + v]);
                    let tool = force * (1.0 / p.m2);
                    d.accelerations[j][1] = tool;
                    (d.rates[at + 2], d.rates[at + 3]) = (v, tool - a1);
                }
            }
        }
    }

    /// The segments of all laws at these angles, each on the side to which its angle moves, φ̇ at the speed `w`.
    pub fn segments(&self, angles: &[f64], forward: bool) -> [[usize; 2]; 1 + MOST_FOLLOWERS] {
        let mut segments = [[0; 2]; 1 + MOST_FOLLOWERS];
        for (number, law, angle) in self.laws() {
            segments[number / 2][number % 2] = law.segment(angles[angle], forward);
        }
        segments
    }

    /// The ways (rad) ahead and back to the ends of the segments at each angle; infinite without breakpoints.
    pub fn ways(&self, modes: &Modes, angles: &[f64]) -> [[f64; 2]; 1 + MOST_FOLLOWERS] {
        let mut ways = [[f64::INFINITY; 2]; 1 + MOST_FOLLOWERS];
        for (number, law, angle) in self.laws() {
            for (way, own) in
                ways[angle].iter_mut().zip(way_out(law, modes.segments[number / 2][number % 2], angles[angle]))
            {
                *way = way.min(own);
            }
        }
        ways
    }

    /// Changes the segments that end where this angle is, ahead or back.
    pub fn cross(&self, modes: &mut Modes, angles: &[f64], which: usize, ahead: bool) {
        for (number, law, angle) in self.laws() {
            let segment = &mut modes.segments[number / 2][number % 2];
            let [up, down] = way_out(law, *segment, angles[angle]);
            if angle == which && if ahead { up } else { down } <= ON_BREAKPOINT {
                let count = law.breakpoints().len();
                *segment = if ahead { *segment + 1 } else { *segment + count - 1 } % count;
            }
        }
    }
}

/// Series of a follower's law and process to `count` coefficients; of mechanisms the law becomes the motion of the tool.
struct Rows<'a, const N: usize> {
    cam: &'a mut [f64; N],
    process: &'a [f64; N],
    count: usize,
}

/// What the accelerations of the followers depend on beside that of the shaft, which turns at the speed w.
struct Motion<'a, S> {
    modes: &'a Modes,
    y: &'a [S],
    f: &'a Functions<S>,
    given: &'a Given<S>,
    w: S,
}

/// Angles that lie closer to a breakpoint are on it (rad): some roundings of a turn.
const ON_BREAKPOINT: f64 = 1e-12;

/// The ways from `phi` to the ends of a segment, ahead and back.
fn way_out(law: &MotionLaw, segment: usize, phi: f64) -> [f64; 2] {
    let breakpoints = law.breakpoints();
    if breakpoints.is_empty() {
        return [f64::INFINITY; 2];
    }
    let (low, high) = ends(breakpoints, segment);
    let phi = turn::near(phi, 0.5 * (low + high));
    // The end of the only segment is its start.
    let on = if breakpoints.len() == 1 { TAU } else { 0.0 };
    [high - phi, phi - low].map(|way| if way <= ON_BREAKPOINT { on } else { way })
}

/// sum += f a b to `count` coefficients.
fn accumulate<const N: usize>(sum: &mut [f64; N], f: f64, a: &[f64; N], b: &[f64; N], count: usize) {
    for (i, a) in a.iter().enumerate().take(count).filter(|(_, a)| **a != 0.0) {
        let a = f * a;
        for (sum, b) in sum[i..count].iter_mut().zip(b) {
            *sum += a * b;
        }
    }
}

impl<S: Scalar> Functions<S> {
    /// At these angles.
    pub fn at(train: &Train, modes: &Modes, angles: &[S]) -> Self {
        const FACTORIALS: [f64; 5] = [1.0, 1.0, 2.0, 6.0, 24.0];
        let of = |row: &[f64; 5], order: usize, angle: S| {
            angle.compose([0, 1, 2].map(|n| row.get(order + n).map_or(0.0, |c| FACTORIALS[order + n] * c)))
        };
        let mut cams = [[S::from(0.0); 3]; MOST_FOLLOWERS];
        let mut forces = [S::from(0.0); MOST_FOLLOWERS];
        let mut numbers = [0.0; 1 + MOST_FOLLOWERS];
        numbers.iter_mut().zip(angles).for_each(|(number, angle)| *number = angle.value());
        let sums = train.functions(modes, &numbers, 5, |j, cam, process| {
            let angle = angles[if let Joint::Shaft(_) = train.followers[j].joint { 1 + j } else { 0 }];
            cams[j] = [0, 1, 2].map(|order| of(cam, order, angle));
            forces[j] = of(process, 0, angles[0]);
        });
        Functions {
            inertia: of(&sums.inertia, 0, angles[0]),
            half_slope: of(&sums.inertia, 1, angles[0]) * 0.5,
            torque: of(&sums.torque, 0, angles[0]),
            viscous: of(&sums.viscous, 0, angles[0]),
            cams,
            process: forces,
        }
    }
}

impl Joint {
    /// How many states it has.
    pub fn states(&self) -> usize {
        match self {
            Joint::Rigid => 0,
            Joint::Output(..) | Joint::Shaft(_) => 2,
            Joint::Backlash(p) if p.m2 > 0.0 => 4,
            Joint::Backlash(_) => 2,
        }
    }
}
