//! A follower of a train: what hangs between its cam, or its crank, and its tool, and what acts on it.
//!
//! Each kind of joint is a file with its equations, its outputs and its state of rest; [`Kind`] is what the rest of the house asks.

mod backlash;
mod output;
mod rigid;
mod shaft;

use super::contact::{self, Flank, Mode};
use super::load::Load;
use super::{elastic_output, elastic_shaft};
use crate::drives::Fault;
use crate::drives::limits::refused_start;
use crate::drives::parameter::{Number, Parameter, Parameters};
use crate::drives::unit::{self, Quantity};
use crate::drives::variable::Output;
use crate::numerics::taylor::{Arithmetic, Scalar};
use serde::{Deserialize, Serialize};

/// A follower with its loads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Follower {
    /// Law and mechanisms; the tool's mass where the follower is rigid, else 0.
    pub rigid: super::rigid::Follower,
    /// What is between cam and tool.
    pub joint: Joint,
    /// On the tool.
    pub load: Load,
    /// On the mass on the cam's side: m_x of an elastic output, m1 with backlash.
    pub roller: Load,
}

impl Follower {
    /// The masses of the tool and on the cam's side (kg).
    pub fn masses(&self) -> [f64; 2] {
        self.joint.masses(self)
    }

    /// What follows the shaft without slip.
    pub fn along(&self, stand: &Stand) -> impl Iterator<Item = Along<'_>> {
        self.joint.along(self, stand).into_iter().flatten()
    }

    /// What spring, gravity and constant force press with in the sense of y where a cam without clearance moves the tool to y; 0
    /// behind mechanisms, and with clearance, whose motion knows the flight.
    pub fn hold(&self, y: f64) -> f64 {
        let held = self.rigid.linkage.is_empty() && self.joint.clearance().is_none();
        let [m, m_x] = self.masses();
        if held { self.load.hold(m, y) + self.roller.hold(m_x, y) } else { 0.0 }
    }
}

/// What is between cam and tool.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Joint {
    /// Nothing.
    Rigid,
    /// A spring, with the mass m_x (kg) on the cam's side of it.
    Output(elastic_output::Parameters, f64),
    /// An elastic shaft before the cam.
    Shaft(elastic_shaft::Parameters),
    /// Clearance; s is infinite where there is no flank B.
    Backlash(#[serde(with = "contact::one_sided")] contact::Parameters),
}

/// A joint as its kind: the only place that tells one from another.
macro_rules! each {
    ($joint:expr, $kind:ident => $do:expr) => {
        match $joint {
            Joint::Rigid => {
                let $kind = &mut rigid::Rigid;
                $do
            }
            Joint::Output($kind, _) => $do,
            Joint::Shaft($kind) => $do,
            Joint::Backlash($kind) => $do,
        }
    };
}

/// Declares [`Kind`], and the same of a joint.
macro_rules! kind {
    ($($(#[$doc:meta])* fn $name:ident $(<$life:lifetime>)? $(<$scalar:ident: $bound:ident>)? (&$self:ident $(, $argument:ident: $type:ty)*)
        $(-> $result:ty)? $default:block)*) => {
        /// What a kind of joint says of itself; a kind without a word of its own is rigid. Places of states count from its first.
        #[allow(unused_variables)]
        pub trait Kind {
            $($(#[$doc])* fn $name$(<$life>)?$(<$scalar: $bound>)?(&$self $(, $argument: $type)*) $(-> $result)? $default)*
        }

        impl Joint {
            $($(#[$doc])* pub fn $name$(<$life>)?$(<$scalar: $bound>)?(&$self $(, $argument: $type)*) $(-> $result)? {
                each!($self, kind => kind.$name($($argument),*))
            })*
        }
    };
}

kind! {
    /// How many states it has: a place and its rate of the gap, and of the spring.
    fn states(&self) -> usize {
        2 * (usize::from(self.clearance().is_some()) + usize::from(self.elastic().is_some()))
    }

    /// Whether it has this one of its numbers.
    fn has(&self, number: &str) -> bool { true }

    /// Inertia and spring of an elastic shaft.
    fn shaft(&self) -> Option<elastic_shaft::Parameters> { None }

    /// Masses, spring and clearance of one whose mass on the cam's side moves between flanks.
    fn clearance(&self) -> Option<contact::Parameters> { None }

    /// The place of q of its spring, and the mass behind it, or the inertia of the cam, with its c, b.
    fn elastic(&self) -> Option<(usize, [f64; 3])> { None }

    /// A natural frequency (rad/s), the highest one within a small factor.
    fn frequency(&self) -> f64 { self.elastic().map_or(0.0, |(_, [m, c, _])| (c / m).sqrt()) }

    /// The masses of the tool and on the cam's side (kg).
    fn masses(&self, of: &Follower) -> [f64; 2] { [of.rigid.m, 0.0] }

    /// What follows the shaft without slip.
    fn along<'a>(&self, of: &'a Follower, stand: &Stand) -> [Option<Along<'a>>; 2] {
        [Some(Along { m: of.rigid.m, weight: of.rigid.m, load: &of.load, away: 0.0, is_tool: true }), None]
    }

    /// The force of the spring on the tool, of an elastic shaft its torque.
    fn spring<S: Arithmetic>(&self, y: &[S]) -> S {
        self.elastic().map_or(S::from(0.0), |(q, [_, c, b])| -(y[q] * c + y[q + 1] * b))
    }

    /// What brakes the shaft, and with it the follower, whose spring has this force.
    fn brake<S: Arithmetic>(&self, at: &At<'_, S>, spring: S, sum: S) -> S { sum - at.cam[1] * at.input }

    /// Rates, accelerations and contact force where the spring has this force and the shaft the acceleration a.
    fn act<S: Arithmetic>(&self, at: &At<'_, S>, spring: S, a: S) -> Motion<S> { Motion::none() }

    /// Gives what ends the present equations.
    fn guards(&self, stand: &Stand, watch: &mut dyn FnMut(Guard)) {}

    /// Gives the outputs in the order of their declaration; the force of the cam on the follower is the last one called force.
    fn outputs<S: Scalar>(&self, now: &Now<'_, S>, put: &mut Put<'_, S>) {}

    /// The slopes of the states where one input or state changes: `cam` those of U and U′ω, `of` those of an output and its rate.
    fn slopes(&self, at: &At<'_, f64>, cam: [f64; 2], of: &dyn Fn(&str) -> [f64; 2]) -> [f64; MOST] { [0.0; MOST] }

    /// Changes the velocities where that of the shaft jumps by `turn`, with the impulse and the velocity of the gap after it of one at
    /// a flank.
    fn jolt(&self, y: &mut [f64], turn: f64, slope: f64, struck: Option<[f64; 2]>) {}

    /// Puts the spring to where it balances the loads.
    fn rest(&self, at: &At<'_, f64>, phi: f64, y: &mut [f64], stand: &mut Stand) -> Result<(), Fault> { Ok(()) }
}

impl Joint {
    /// Whether it carries the cam, whose law is then taken at ψ = φ + q.
    pub fn carries_cam(&self) -> bool {
        self.shaft().is_some()
    }

    /// The place of q of a mass on a spring behind the cam, and its m, c, b.
    pub fn sprung(&self) -> Option<(usize, [f64; 3])> {
        self.elastic().filter(|_| !self.carries_cam())
    }

    /// How the numbers of its kind are declared.
    pub fn numbers(&self) -> Vec<Number> {
        each!(self, kind => Number::all(Some(kind)))
    }

    /// The value of one of them.
    pub fn number(&self, i: usize) -> f64 {
        each!(self, kind => (table(kind)[i].get)(kind))
    }

    /// Changes one of them.
    pub fn set_number(&mut self, i: usize, value: f64) {
        each!(self, kind => (table(kind)[i].set)(kind, value));
    }
}

/// The most states of a joint.
pub const MOST: usize = 4;

fn table<P: Parameters>(_: &P) -> &'static [Parameter<P>] {
    P::TABLE
}

/// How a follower stands: what changes at events only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stand {
    /// Where m1 is.
    pub contact: Mode,
    /// Whether z counts from flank B, the one that m1 has been at last.
    pub beyond: bool,
    /// The order of the zero with which the gap begins.
    pub zeros: usize,
}

impl Stand {
    /// On flank A.
    pub fn held() -> Self {
        Stand { contact: Mode::Contact(Flank::A), ..Stand::default() }
    }

    /// The place of x1 − U at which z is zero, with the clearance `s` (m).
    pub fn home(&self, s: f64) -> f64 {
        if self.beyond { s } else { 0.0 }
    }

    /// Whether m1 is on a flank.
    pub fn is_held(&self) -> bool {
        self.contact != Mode::Free
    }
}

/// What changes the equations of a follower.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Change {
    /// m1 leaves its flank.
    Release,
    /// m1 hits a flank.
    Impact(Flank),
}

/// A function of time whose root changes the equations: σ (f + shift), first above zero, where f is a state of this place, or N
/// without one.
pub struct Guard {
    /// The place of the state.
    pub state: Option<usize>,
    /// The shift.
    pub shift: f64,
    /// σ.
    pub sign: f64,
    /// The order of the zero with which it begins where its value is zero.
    pub zeros: usize,
    /// What happens there.
    pub change: Change,
}

/// What follows the shaft without slip.
pub struct Along<'a> {
    /// Its mass (kg).
    pub m: f64,
    /// The mass that gravity acts on (kg).
    pub weight: f64,
    /// Its loads.
    pub load: &'a Load,
    /// How far from U it is (m).
    pub away: f64,
    /// Whether these are the loads of the tool, with the process force.
    pub is_tool: bool,
}

/// A follower at an instant.
#[derive(Clone, Copy)]
pub struct At<'a, S> {
    /// Its number, from 0.
    pub j: usize,
    /// What it is made of.
    pub follower: &'a Follower,
    /// How it stands.
    pub stand: &'a Stand,
    /// The segment of its law.
    pub segment: usize,
    /// U, U′, U″ of its cam, or of its tool behind mechanisms.
    pub cam: [S; 3],
    /// P(φ).
    pub process: S,
    /// F.
    pub input: S,
    /// φ̇.
    pub w: S,
    /// Its states.
    pub y: &'a [S],
}

impl<S: Arithmetic> At<'_, S> {
    /// F_L on a tool of mass m with this place and velocity.
    fn on_tool(&self, m: f64, place: [S; 2]) -> S {
        self.follower.load.force(m, place, Some(self.process), Some(self.input))
    }

    /// ẍ of the cam.
    fn lift(&self, a: S) -> S {
        self.cam[2] * (self.w * self.w) + self.cam[1] * a
    }

    /// The same with other roundings, those of the outputs.
    fn shown_lift(&self, a: S) -> S {
        self.cam[2] * self.w * self.w + self.cam[1] * a
    }
}

/// The motion of a follower.
#[derive(Clone, Copy)]
pub struct Motion<S> {
    /// The rates of its states.
    pub rates: [S; MOST],
    /// ẍ1 or ψ̈, and ÿ of the mass behind a spring.
    pub accelerations: [S; 2],
    /// N of a mass in contact.
    pub normal: S,
}

impl<S: Arithmetic> Motion<S> {
    /// Of what has no states.
    pub fn none() -> Self {
        let zero = S::from(0.0);
        Motion { rates: [zero; MOST], accelerations: [zero; 2], normal: zero }
    }
}

/// A follower at a communication point.
pub struct Now<'a, S> {
    /// What its motion depends on.
    pub at: At<'a, S>,
    /// φ within its turn.
    pub phi: S,
    /// φ with its turns.
    pub whole: S,
    /// φ̈.
    pub a: S,
    /// The force of the spring.
    pub spring: S,
    /// Its motion.
    pub motion: &'a Motion<S>,
    /// What has happened since the start.
    pub counts: Counts,
    /// Whether inputs move the shaft, by whose jumps a mass in contact takes up momentum.
    pub driven: bool,
}

/// Counts of a follower with clearance.
#[derive(Clone, Copy, Default)]
pub struct Counts {
    /// ΣP (N·s).
    pub impulse: f64,
    /// Impacts.
    pub impacts: f64,
    /// Energy lost in impacts (J).
    pub loss: f64,
    /// The same in the damper (J).
    pub damped: f64,
    /// Means of F_K and U′ F_K over the last communication step.
    pub means: [f64; 2],
}

/// Where an output belongs.
#[derive(Clone, Copy)]
pub struct Seat {
    /// Its place.
    pub place: usize,
    /// The number of its follower, from 0; None of the shaft.
    pub follower: Option<usize>,
}

/// Takes outputs with their values.
pub struct Put<'a, S> {
    /// Where the next one belongs.
    pub seat: Seat,
    /// What becomes of them.
    pub take: &'a mut dyn FnMut(Seat, &Output, S),
}

impl<S> Put<'_, S> {
    /// Gives one.
    pub fn give(&mut self, output: &Output, value: S) {
        (self.take)(self.seat, output, value);
        self.seat.place += 1;
    }

    /// Gives some.
    fn all<const N: usize>(&mut self, outputs: &[Output; N], values: [S; N]) {
        outputs.iter().zip(values).for_each(|(output, value)| self.give(output, value));
    }
}

/// A place, its velocity and its acceleration, the first two states or not; a place without a text is that of its name.
const fn moving(name: &'static str, text: &'static str, of: [&'static Quantity; 3], state: bool) -> [Output; 3] {
    let velocity = Output { order: 1, ..Output::new(name, text, of[1]) };
    let acceleration = Output { order: 2, ..Output::new(name, text, of[2]) };
    [Output::new(name, text, of[0]).state(state), velocity.state(state), acceleration]
}

/// Where it moves, and where it turns.
const fn either(name: &'static str, text: &'static str, state: bool) -> [[Output; 3]; 2] {
    let moves = [&unit::LENGTH, &unit::VELOCITY, &unit::ACCELERATION];
    [moving(name, text, moves, state), moving(name, text, TURNS, state)]
}

const TURNS: [&Quantity; 3] = [&unit::ANGLE, &unit::ANGULAR_VELOCITY, &unit::ANGULAR_ACCELERATION];

/// The tool, whose place and velocity follow from those of the shaft, or are states.
static TOOL: [[Output; 3]; 2] = either("y", "Place of the tool", false);
static FREE_TOOL: [[Output; 3]; 2] = either("y", "Place of the tool", true);
/// q of a spring behind the cam.
static DEFORMATION: [[Output; 3]; 2] = either("q", "Deformation of the spring", false);

impl<S: Scalar> Now<'_, S> {
    /// The quantity of its places.
    fn place(&self) -> &'static Quantity {
        if self.at.follower.rigid.turns { &unit::ANGLE } else { &unit::LENGTH }
    }

    /// The quantity of its forces.
    fn force(&self) -> &'static Quantity {
        if self.at.follower.rigid.turns { &unit::TORQUE } else { &unit::FORCE }
    }

    /// U.
    fn law(&self, put: &mut Put<'_, S>) {
        let text = "Position function of the cam, or of the tool behind mechanisms";
        put.give(&Output::new("U", text, self.place()), self.at.cam[0]);
    }

    /// A place, its velocity and its acceleration.
    fn moved(&self, outputs: &[[Output; 3]; 2], values: [S; 3], put: &mut Put<'_, S>) {
        put.all(&outputs[usize::from(self.at.follower.rigid.turns)], values);
    }

    /// The force of the cam on the follower, and the torque of the follower on the shaft.
    fn reaction(&self, name: &'static str, [force, torque]: [S; 2], put: &mut Put<'_, S>) {
        let text = "Force of the cam on the follower, positive in the sense of y";
        put.give(&Output::new(name, text, self.force()), force);
        let text = "Torque from the shaft into the follower; positive loads the drive";
        put.give(&Output::new("tau", text, &unit::TORQUE), torque);
    }
}

/// q where a spring of stiffness c balances the loads on a tool of mass m, the other end of the spring at x.
fn balance(at: &At<'_, f64>, [c, m]: [f64; 2], x: f64) -> Result<f64, Fault> {
    let (load, push) = (&at.follower.load, at.process + at.input);
    let stiffness = c + load.stiffness();
    let q = (load.constant_part(m) + push - load.stiffness() * x) / stiffness;
    if stiffness > 0.0 { Ok(q) } else { Err(nothing_holds(at.j, "its tool")) }
}

fn nothing_holds(j: usize, what: &str) -> Fault {
    refused_start(format!(
        "start.mode = equilibrium: nothing holds follower {} where it is: neither spring nor load holds {what}; choose at_rest, \
         or give the follower a spring or a force",
        j + 1
    ))
}
