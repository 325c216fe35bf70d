//! Shaft and followers as one system; its states are φ, φ̇, the motor's and the followers'.
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
//! J collects J0, J_φ(φ), the rotor of a stiff transmission and m U′² of the masses that follow the shaft without slip: rigid
//! followers, m_x of elastic outputs, m1 in contact. φ̈ follows explicitly, since springs and dampers depend on states only.
//!
//! Symbols: m mass (kg) or moment of inertia if the follower turns; U(φ) of the cam, U(ψ) with an elastic shaft; F_L load on the
//! tool, F_Lx and F_L1 on the mass on the cam's side; τ an input, positive brakes. N, the force of the cam on the follower in the
//! sense of y, is F + m_x ẍ − F_Lx, or F_K = m1 ẍ1 + S − F_L1 with backlash. Without m2 all loads act on m1.
//!
//! Functions of φ alone (J, static loads of masses that follow without slip) are summed up as one function of the angle, so that
//! rigid followers cost next to nothing.
//!
//! Valid for rigid links, linear springs and dampers, impacts without duration. Source: Dresig, Holzweißig, *Maschinendynamik*,
//! chapter 2; the equations of the parts are in their own modules.

pub mod motor;
pub mod switching;

use super::cam_drive::DriveMode;
use super::free::coupled::{Loads, NamedLoad};
use super::free::inertia::InertiaFunction;
use super::free::signal::Signal;
use super::motor::Motor;
use crate::drives::Fault;
use crate::drives::follower::contact;
use crate::drives::follower::joint::{At, CarriedMass, Follower, Motion, Stand};
use crate::drives::follower::place::ends;
use crate::motion::MotionLaw;
use crate::motion::turn;
use crate::numerics::angle;
use crate::numerics::double_double::Double;
use crate::numerics::taylor::{Arithmetic, Scalar, Series};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use switching::Instant;

/// The most followers.
pub const MOST_FOLLOWERS: usize = 16;

/// The most states: shaft, motor, coupling, followers.
pub const MOST_STATES: usize = 6 + 4 * MOST_FOLLOWERS;

/// The shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(clippy::large_enum_variant)] // A train has only one shaft.
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
    pub loads: Vec<NamedLoad>,
    /// The motor.
    pub motor: Motor,
    /// φ at the start (rad).
    pub phi_start: f64,
    /// φ̇ at the start (rad/s), except on a periodic motion.
    pub w_start: f64,
}

/// Shaft and followers, and the places of their states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Train {
    /// The shaft.
    pub shaft: Shaft,
    /// The followers.
    pub followers: Vec<Follower>,
    /// The places of the states of motor, coupling and followers, and the number of all states.
    pub layout: Layout,
}

/// The first places of states.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Layout {
    /// M of a motor with a lag; I, and e of a servo.
    pub motor: usize,
    /// θ, θ̇.
    pub coupling: usize,
    /// q, q̇, and with backlash z, ż before them.
    pub followers: Vec<usize>,
    /// The number of states.
    pub count: usize,
}

/// The discrete state, which changes at events only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Modes {
    /// The segment of each law: of J_φ and M_L, then of cam and process force of each follower.
    pub segments: [[usize; 2]; 1 + MOST_FOLLOWERS],
    /// The discrete state of each follower.
    pub stands: [Stand; MOST_FOLLOWERS],
    /// The limit at which the servo is: 1, −1, or 0 for none.
    pub saturation: i8,
    /// The piece of the torque table: 0 below its first speed.
    pub piece: usize,
}

impl Modes {
    /// The contacts of these followers, as one number.
    pub fn contacts(&self, followers: impl Iterator<Item = usize>) -> u64 {
        followers.fold(0, |contacts, j| {
            let Stand { contact, beyond, .. } = self.stands[j];
            let contact = match contact {
                contact::Mode::Free => 0,
                contact::Mode::Contact(flank) => flank.pick(1, 2),
            };
            contacts << 3 | contact << 1 | u64::from(beyond)
        })
    }
}

/// Sums over the masses that follow the shaft without slip, as power series about the present angle: Σ cₙ xⁿ.
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

/// The inputs of a train, apart from those of a driven shaft.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    /// τ, or the inputs of several loads.
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
    /// The inputs of so many followers under these loads.
    pub fn of(followers: usize, loads: &[NamedLoad]) -> Self {
        Inputs { loads: Loads::new(loads), forces: vec![Signal::default(); followers], ..Inputs::default() }
    }

    /// All of them.
    pub fn all(&mut self) -> impl Iterator<Item = &mut Signal> {
        let others = [&mut self.torque, &mut self.reference, &mut self.position];
        self.loads.all().chain(others).chain(&mut self.forces)
    }

    fn each(&self) -> impl Iterator<Item = &Signal> {
        self.loads.each().chain([&self.torque, &self.reference, &self.position]).chain(&self.forces)
    }

    /// Takes over the signals of another train of the same kind, without allocating.
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

    /// Whether they are set to the same signals.
    pub fn are_like(&self, other: &Self) -> bool {
        self.each().zip(other.each()).all(|(one, other)| one.is_like(other))
    }
}

/// The external values.
#[derive(Clone, Copy)]
pub struct InputValues<S> {
    /// φ̇, φ̈ of a driven shaft.
    pub shaft: [S; 2],
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
    /// The motion of each follower.
    pub followers: [Motion<S>; MOST_FOLLOWERS],
    /// φ̈_m.
    pub rotor: S,
}

/// The train at an instant: all arguments of its accelerations.
pub struct Point<'a, S> {
    /// The discrete state.
    pub modes: &'a Modes,
    /// The states.
    pub y: &'a [S],
    /// Functions of the angle.
    pub f: &'a Functions<S>,
    /// The external values.
    pub input_values: &'a InputValues<S>,
}

impl Train {
    /// Whether these may be modes of this train, whose laws may have other pieces.
    pub fn takes(&self, modes: &Modes) -> bool {
        let motor = self.machine().map(|machine| &machine.motor);
        let knots = motor.and_then(|motor| motor.table()).map_or(0, |table| table.speeds.len());
        let saturates = motor.is_some_and(|motor| motor.servo().is_some());
        modes.stands.iter().enumerate().all(|(j, stand)| !stand.is_held() || self.clearance(j).is_some())
            && modes.piece <= knots
            && modes.saturation.abs() <= i8::from(saturates)
    }

    /// The parameters of follower j with backlash; None without backlash.
    pub fn clearance(&self, j: usize) -> Option<contact::Parameters> {
        self.followers.get(j).and_then(|follower| follower.joint.clearance())
    }

    /// The followers with backlash, and the places of their states.
    pub fn clearances(&self) -> impl Iterator<Item = (usize, usize, contact::Parameters)> {
        (0..self.followers.len()).filter_map(|j| Some((j, self.layout.followers[j], self.clearance(j)?)))
    }

    /// Whether its laws have these segments.
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

    /// Whether an event may change the equations.
    pub fn switches(&self) -> bool {
        let motor = self.machine().map(|machine| &machine.motor);
        self.clearances().next().is_some()
            || motor.is_some_and(|motor| motor.servo().is_some() || motor.table().is_some())
    }

    /// Whether a follower that is not rigid, or one with an input, uses its law at φ.
    pub fn needs_cams_at_phi(&self) -> bool {
        self.followers.iter().any(|Follower { joint, load, .. }| {
            if joint.carries_cam() { load.process.is_some() } else { joint.states() > 0 || load.input }
        })
    }

    /// The part of J that depends on no angle.
    pub fn constant_inertia(&self) -> f64 {
        self.machine().map_or(0.0, |machine| machine.inertia.constant + machine.motor.stiff_rotor())
    }

    /// b_L.
    pub fn constant_friction(&self) -> f64 {
        self.machine().and_then(|machine| machine.friction).unwrap_or(0.0)
    }

    /// The laws with their numbers in [`Modes::segments`] and the numbers of their angles: 0 is φ, 1 + j is ψ of follower j.
    pub fn laws(&self) -> impl Iterator<Item = (usize, &MotionLaw, usize)> {
        let machine = self.machine();
        let of_machine = [machine.and_then(|m| m.inertia.varying.as_ref()), machine.and_then(|m| m.load.as_ref())];
        let of_followers = self.followers.iter().enumerate().flat_map(|(j, follower)| {
            let angle = self.angle_of(j);
            [Some((2 + 2 * j, &follower.rigid.cam, angle)), follower.load.process.as_ref().map(|p| (3 + 2 * j, p, 0))]
        });
        of_machine.into_iter().enumerate().map(|(i, law)| law.map(|law| (i, law, 0))).chain(of_followers).flatten()
    }

    /// The number of the angle of the cam of follower j.
    fn angle_of(&self, j: usize) -> usize {
        if self.followers[j].joint.carries_cam() { 1 + j } else { 0 }
    }

    /// Follower j while the shaft turns at the speed w.
    #[inline]
    pub fn follower<'a, S: Arithmetic>(&'a self, j: usize, p: &Point<'a, S>, w: S) -> At<'a, S> {
        let ([segment, _], cam) = (p.modes.segments[1 + j], p.f.cams[j]);
        let (process, input) = (p.f.process[j], p.input_values.forces[j]);
        let (follower, stand, y) = (&self.followers[j], &p.modes.stands[j], &p.y[self.layout.followers[j]..]);
        At { j, follower, stand, segment, cam, process, input, w, y }
    }

    /// The angles, reduced to one turn, for the shaft at `phi` and the states `y`.
    pub fn angles(&self, phi: Double, y: &[f64]) -> [f64; 1 + MOST_FOLLOWERS] {
        let mut angles = [0.0; 1 + MOST_FOLLOWERS];
        angles[0] = angle::reduce(phi);
        for (j, follower) in self.followers.iter().enumerate() {
            if follower.joint.carries_cam() {
                angles[1 + j] = angle::reduce(phi + Double::from(y[self.layout.followers[j]]));
            }
        }
        angles
    }

    /// U and U′ of the cam of follower j at this angle of the shaft; the state in a place is the deformation of its shaft.
    pub fn cam(&self, modes: &Modes, j: usize, phi: f64, state: impl Fn(usize) -> f64) -> [f64; 2] {
        let Follower { joint, rigid, .. } = &self.followers[j];
        let phi = Double::from(phi);
        let psi = if joint.carries_cam() { phi + Double::from(state(self.layout.followers[j])) } else { phi };
        let [u, slope, ..] = rigid.cam.at_in(modes.segments[1 + j][0], angle::reduce(psi)).0;
        [u, slope]
    }

    /// The functions of the angle to `count` coefficients of U, and three fewer for J′ and U″; U and P of each follower go to
    /// `take`.
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
            let mut cam = about(2 + 2 * j, &follower.rigid.cam, self.angle_of(j));
            let process = own(3 + 2 * j, follower.load.process.as_ref());
            sums.add(follower, &modes.stands[j], Rows { cam: &mut cam, process: &process, count });
            take(j, &cam, &process);
        }
        sums
    }

    /// Puts the springs of the train into balance with the loads, with the shaft held.
    ///
    /// # Errors
    /// Nothing holds a tool, or m1 at a flank, or an elastic shaft snaps through.
    pub fn rest(&self, modes: &mut Modes, now: &mut Instant) -> Result<(), Fault> {
        let (angles, before, y) = (self.angles(now.phi, &now.y), *modes, now.y);
        let f = Functions::at(self, modes, &angles);
        let point = Point { modes: &before, y: &y, f: &f, input_values: &now.input_values };
        for (j, follower) in self.followers.iter().enumerate() {
            let own = &mut now.y[self.layout.followers[j]..];
            follower.joint.rest(&self.follower(j, &point, 0.0), angles[0], own, &mut modes.stands[j])?;
        }
        Ok(())
    }

    /// Accelerations and forces.
    pub fn dynamics<S: Arithmetic>(&self, p: &Point<S>) -> Dynamics<S> {
        let Point { y, f, input_values, .. } = *p;
        let zero = S::from(0.0);
        let mut d = Dynamics {
            a: input_values.shaft[1],
            torque: zero,
            demand: zero,
            rates: [zero; MOST_STATES],
            spring: [zero; MOST_FOLLOWERS],
            followers: [Motion::none(); MOST_FOLLOWERS],
            rotor: zero,
        };
        let machine = self.machine();
        let w = if machine.is_some() { y[1] } else { input_values.shaft[0] };
        let mut resistance = input_values.tau - f.torque + f.viscous * w + f.half_slope * (w * w);
        for (j, Follower { joint, .. }) in self.followers.iter().enumerate() {
            let at = self.follower(j, p, w);
            d.spring[j] = joint.spring(at.y);
            resistance = joint.brake(&at, d.spring[j], resistance);
        }
        if let Some(machine) = machine {
            machine.motor.drive(p, &self.layout, &mut d);
            d.a = (d.torque - resistance) / f.inertia;
            (d.rates[0], d.rates[1]) = (w, d.a);
            machine.motor.follow(&self.layout, &mut d);
        }
        for (j, Follower { joint, .. }) in self.followers.iter().enumerate() {
            d.followers[j] = joint.act(&self.follower(j, p, w), d.spring[j], d.a);
            let count = joint.states();
            d.rates[self.layout.followers[j]..][..count].copy_from_slice(&d.followers[j].rates[..count]);
        }
        d
    }

    /// The brakes on the shaft at constant speed, without the change of the inertia, for these forces of the springs.
    pub fn reactions<S: Arithmetic>(&self, p: &Point<S>, w: S, spring: &[S; MOST_FOLLOWERS]) -> S {
        let still = p.f.viscous * w - p.f.torque;
        let brake =
            |sum, (j, follower): (usize, &Follower)| follower.joint.brake(&self.follower(j, p, w), spring[j], sum);
        self.followers.iter().enumerate().fold(still, brake)
    }

    /// The segments of all laws at these angles, each on the side to which its angle moves at this speed of the shaft.
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

    /// Changes the segments that end at this angle, ahead or back.
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

/// Series of a follower's law and process to `count` coefficients; with mechanisms the law is replaced by the motion of the tool.
struct Rows<'a, const N: usize> {
    cam: &'a mut [f64; N],
    process: &'a [f64; N],
    count: usize,
}

impl<const N: usize> Sums<N> {
    /// Adds the masses of a follower that follow the shaft without slip.
    fn add(&mut self, follower: &Follower, stand: &Stand, rows: Rows<N>) {
        let Rows { cam, process, count } = rows;
        let linkage = Some(&follower.rigid.linkage).filter(|linkage| !linkage.is_empty());
        let moved = linkage.map(|linkage| linkage.moved(0.0, Series(*cam), &follower.load.frames));
        moved.iter().for_each(|moved| *cam = moved.tool.0);
        if moved.is_none() && follower.carried(stand).all(|carried| carried.m == 0.0 && carried.load.is_none()) {
            return;
        }
        let mut slope = [0.0; N];
        (1..count).for_each(|n| slope[n - 1] = n as f64 * cam[n]);
        for CarriedMass { m, weight, load, away, is_tool } in follower.carried(stand) {
            if m != 0.0 {
                accumulate(&mut self.inertia, m, &slope, &slope, count);
            }
            if !load.is_none() {
                let mut force = if is_tool { *process } else { [0.0; N] };
                (0..count).for_each(|n| force[n] -= load.stiffness() * cam[n]);
                force[0] += load.constant_part(weight) - load.stiffness() * away;
                accumulate(&mut self.torque, 1.0, &force, &slope, count);
                if let Some(b) = load.damping {
                    accumulate(&mut self.viscous, b, &slope, &slope, count);
                }
            }
        }
        if let Some(moved) = moved {
            self.inertia.iter_mut().zip(moved.inertia.0).for_each(|(sum, own)| *sum += own);
            (1..count).for_each(|n| self.torque[n - 1] += n as f64 * moved.weight.0[n]);
        }
    }
}

/// Angles closer to a breakpoint are on it (rad): some roundings of a turn.
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
    /// The functions at these angles.
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
            let angle = angles[train.angle_of(j)];
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
