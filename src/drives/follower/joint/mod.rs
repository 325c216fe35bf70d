//! A follower of a train: the joint between its cam, or its crank, and its tool, and the loads on it.
//!
//! Each kind of joint is a file with its equations, its outputs and its state of rest; [`Kind`] is its interface to all other code.

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
    /// Law and mechanisms; the tool's mass if the follower is rigid, else 0.
    pub rigid: super::rigid::Follower,
    /// The joint between cam and tool.
    pub joint: Joint,
    /// The loads on the tool.
    pub load: Load,
    /// The loads on the mass on the cam's side: m_x of an elastic output, m1 with backlash.
    pub roller: Load,
}

impl Follower {
    /// The masses of the tool and on the cam's side (kg).
    pub fn masses(&self) -> [f64; 2] {
        self.joint.masses(self)
    }

    /// The masses that follow the shaft without slip.
    pub fn carried(&self, stand: &Stand) -> impl Iterator<Item = CarriedMass<'_>> {
        self.joint.carried(self, stand).into_iter().flatten()
    }

    /// The force in the sense of y with which spring, gravity and constant force press, for a cam without clearance that moves the
    /// tool to y. It is 0 with mechanisms, and with clearance, whose equations include the flight.
    pub fn hold(&self, y: f64) -> f64 {
        let held = self.rigid.linkage.is_empty() && self.joint.clearance().is_none();
        let [m, m_x] = self.masses();
        if held { self.load.hold(m, y) + self.roller.hold(m_x, y) } else { 0.0 }
    }
}

/// The joint between cam and tool.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Joint {
    /// Nothing.
    Rigid,
    /// A spring, with the mass m_x (kg) on the cam's side of it.
    Output(elastic_output::Parameters, f64),
    /// An elastic shaft before the cam.
    Shaft(elastic_shaft::Parameters),
    /// Clearance; s is infinite without flank B.
    Backlash(#[serde(with = "contact::one_sided")] contact::Parameters),
}

/// A joint as its kind: the only place that distinguishes them.
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

/// Declares [`Kind`] and its methods on a joint.
macro_rules! kind {
    ($($(#[$doc:meta])* fn $name:ident $(<$life:lifetime>)? $(<$scalar:ident: $bound:ident>)? (&$self:ident $(, $argument:ident: $type:ty)*)
        $(-> $result:ty)? $default:block)*) => {
        /// The interface of a kind of joint; the defaults are those of a rigid one. Places of states count from its first.
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
    /// The number of its states: a place and its rate for the gap and for the spring.
    fn states(&self) -> usize {
        2 * (usize::from(self.clearance().is_some()) + usize::from(self.elastic().is_some()))
    }

    /// Whether it has the number of this name.
    fn has(&self, number: &str) -> bool { true }

    /// Inertia and spring of an elastic shaft.
    fn shaft(&self) -> Option<elastic_shaft::Parameters> { None }

    /// Masses, spring and clearance, if the mass on the cam's side moves between flanks.
    fn clearance(&self) -> Option<contact::Parameters> { None }

    /// The place of q of its spring, with m, c, b of the mass on it, or J, c, b with the inertia of the cam.
    fn elastic(&self) -> Option<(usize, [f64; 3])> { None }

    /// A natural frequency (rad/s), the highest one within a small factor.
    fn frequency(&self) -> f64 { self.elastic().map_or(0.0, |(_, [m, c, _])| (c / m).sqrt()) }

    /// The masses of the tool and on the cam's side (kg).
    fn masses(&self, of: &Follower) -> [f64; 2] { [of.rigid.m, 0.0] }

    /// The masses that follow the shaft without slip.
    fn carried<'a>(&self, of: &'a Follower, stand: &Stand) -> [Option<CarriedMass<'a>>; 2] {
        [Some(CarriedMass { m: of.rigid.m, weight: of.rigid.m, load: &of.load, away: 0.0, is_tool: true }), None]
    }

    /// The force of the spring on the tool; the torque of an elastic shaft.
    fn spring<S: Arithmetic>(&self, y: &[S]) -> S {
        self.elastic().map_or(S::from(0.0), |(q, [_, c, b])| -(y[q] * c + y[q + 1] * b))
    }

    /// The brake of the shaft and of its follower, if the spring has this force.
    fn brake<S: Arithmetic>(&self, at: &At<'_, S>, spring: S, sum: S) -> S { sum - at.cam[1] * at.input }

    /// Rates, accelerations and contact force for this force of the spring and this acceleration a of the shaft.
    fn act<S: Arithmetic>(&self, at: &At<'_, S>, spring: S, a: S) -> Motion<S> { Motion::none() }

    /// Passes on the guards that end the present equations.
    fn guards(&self, stand: &Stand, watch: &mut dyn FnMut(Guard)) {}

    /// Passes on the outputs in the order of their declaration; the last one called force is the force of the cam on the follower.
    fn outputs<S: Scalar>(&self, now: &Now<'_, S>, put: &mut Put<'_, S>) {}

    /// The slopes of the states with respect to one input or state: `cam` are the slopes of U and U′ω, `of` returns those of an
    /// output and its rate.
    fn slopes(&self, at: &At<'_, f64>, cam: [f64; 2], of: &dyn Fn(&str) -> [f64; 2]) -> [f64; MOST] { [0.0; MOST] }

    /// Changes the velocities when the shaft's jumps by `turn`; of a mass at a flank `struck` holds the impulse and the velocity of
    /// the gap afterwards.
    fn jolt(&self, y: &mut [f64], turn: f64, slope: f64, struck: Option<[f64; 2]>) {}

    /// Puts the spring into balance with the loads.
    fn rest(&self, at: &At<'_, f64>, phi: f64, y: &mut [f64], stand: &mut Stand) -> Result<(), Fault> { Ok(()) }
}

impl Joint {
    /// Whether it carries the cam; its law then is taken at ψ = φ + q.
    pub fn carries_cam(&self) -> bool {
        self.shaft().is_some()
    }

    /// The place of q of a mass on a spring after the cam, and its m, c, b.
    pub fn sprung(&self) -> Option<(usize, [f64; 3])> {
        self.elastic().filter(|_| !self.carries_cam())
    }

    /// The declarations of its numbers.
    pub fn numbers(&self) -> Vec<Number> {
        each!(self, kind => Number::all(Some(kind)))
    }

    /// The value of one of its numbers.
    pub fn number(&self, i: usize) -> f64 {
        each!(self, kind => (table(kind)[i].get)(kind))
    }

    /// Changes one of its numbers.
    pub fn set_number(&mut self, i: usize, value: f64) {
        each!(self, kind => (table(kind)[i].set)(kind, value));
    }
}

/// The most states of a joint.
pub const MOST: usize = 4;

fn table<P: Parameters>(_: &P) -> &'static [Parameter<P>] {
    P::TABLE
}

/// The discrete state of a follower, which changes at events only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stand {
    /// The position of m1.
    pub contact: Mode,
    /// Whether z counts from flank B, the last flank that m1 touched.
    pub beyond: bool,
    /// The order of the zero with which the gap begins.
    pub zeros: usize,
}

impl Stand {
    /// The state on flank A.
    pub fn held() -> Self {
        Stand { contact: Mode::Contact(Flank::A), ..Stand::default() }
    }

    /// The value of x1 − U at z = 0, with the clearance `s` (m).
    pub fn home(&self, s: f64) -> f64 {
        if self.beyond { s } else { 0.0 }
    }

    /// Whether m1 is on a flank.
    pub fn is_held(&self) -> bool {
        self.contact != Mode::Free
    }
}

/// An event that changes the equations of a follower.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Change {
    /// m1 leaves its flank.
    Release,
    /// m1 hits a flank.
    Impact(Flank),
}

/// A function of time whose root changes the equations: σ (f + shift), positive at first; f is the state of this place, or N
/// without one.
pub struct Guard {
    /// The place of the state.
    pub state: Option<usize>,
    /// The shift.
    pub shift: f64,
    /// σ.
    pub sign: f64,
    /// The order of the zero with which it begins if its value is zero.
    pub zeros: usize,
    /// The event at the root.
    pub change: Change,
}

/// A mass that follows the shaft without slip.
pub struct CarriedMass<'a> {
    /// Its mass (kg).
    pub m: f64,
    /// The mass that gravity acts on (kg).
    pub weight: f64,
    /// Its loads.
    pub load: &'a Load,
    /// Its distance from U (m).
    pub away: f64,
    /// Whether these are the tool's loads, with the process force.
    pub is_tool: bool,
}

/// A follower at an instant.
#[derive(Clone, Copy)]
pub struct At<'a, S> {
    /// Its number, from 0.
    pub j: usize,
    /// The follower.
    pub follower: &'a Follower,
    /// Its discrete state.
    pub stand: &'a Stand,
    /// The segment of its law.
    pub segment: usize,
    /// U, U′, U″ of its cam, or of its tool with mechanisms.
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
    /// F_L on a tool of mass m at this place and velocity.
    fn on_tool(&self, m: f64, place: [S; 2]) -> S {
        self.follower.load.force(m, place, Some(self.process), Some(self.input))
    }

    /// ẍ of the cam.
    fn lift(&self, a: S) -> S {
        S::bend(self.cam, self.w, a)
    }

    /// The same with the roundings of the outputs.
    fn shown_lift(&self, a: S) -> S {
        self.cam[2] * self.w * self.w + self.cam[1] * a
    }
}

/// The motion of a follower.
#[derive(Clone, Copy)]
pub struct Motion<S> {
    /// The rates of its states.
    pub rates: [S; MOST],
    /// ẍ1 or ψ̈, and ÿ of the mass on a spring.
    pub accelerations: [S; 2],
    /// N of a mass in contact.
    pub normal: S,
}

impl<S: Arithmetic> Motion<S> {
    /// The motion of a follower without states.
    pub fn none() -> Self {
        let zero = S::from(0.0);
        Motion { rates: [zero; MOST], accelerations: [zero; 2], normal: zero }
    }
}

/// A follower at a communication point.
pub struct Now<'a, S> {
    /// The arguments of its motion.
    pub at: At<'a, S>,
    /// φ within its turn.
    pub phi: S,
    /// φ including its turns.
    pub whole: S,
    /// φ̈.
    pub a: S,
    /// The force of the spring.
    pub spring: S,
    /// Its motion.
    pub motion: &'a Motion<S>,
    /// Its counts since the start.
    pub counts: Counts,
    /// Whether inputs move the shaft; their jumps give momentum to a mass in contact.
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
    /// Energy dissipated by the damper (J).
    pub damped: f64,
    /// Means of F_K and U′ F_K over the last communication step.
    pub means: [f64; 2],
}

/// The place of an output and its follower.
#[derive(Clone, Copy)]
pub struct Seat {
    /// Its place.
    pub place: usize,
    /// The number of its follower, from 0; None of the shaft.
    pub follower: Option<usize>,
}

/// Receives outputs with their values.
pub struct Put<'a, S> {
    /// The seat of the next one.
    pub seat: Seat,
    /// Takes each of them.
    pub take: &'a mut dyn FnMut(Seat, &Output, S),
}

impl<S> Put<'_, S> {
    /// Passes on one output.
    pub fn give(&mut self, output: &Output, value: S) {
        (self.take)(self.seat, output, value);
        self.seat.place += 1;
    }

    /// Passes on several outputs.
    fn all<const N: usize>(&mut self, outputs: &[Output; N], values: [S; N]) {
        outputs.iter().zip(values).for_each(|(output, value)| self.give(output, value));
    }
}

/// A place, its velocity and its acceleration; the first two may be states. A place without a text has the text of its name.
const fn moving(name: &'static str, text: &'static str, of: [&'static Quantity; 3], state: bool) -> [Output; 3] {
    let velocity = Output { order: 1, ..Output::new(name, text, of[1]) };
    let acceleration = Output { order: 2, ..Output::new(name, text, of[2]) };
    [Output::new(name, text, of[0]).state(state), velocity.state(state), acceleration]
}

/// The outputs of a motion that is a translation, and of one that is a rotation.
const fn either(name: &'static str, text: &'static str, state: bool) -> [[Output; 3]; 2] {
    let moves = [&unit::LENGTH, &unit::VELOCITY, &unit::ACCELERATION];
    [moving(name, text, moves, state), moving(name, text, TURNS, state)]
}

const TURNS: [&Quantity; 3] = [&unit::ANGLE, &unit::ANGULAR_VELOCITY, &unit::ANGULAR_ACCELERATION];

/// The tool; its place and velocity follow from the shaft's, or are states.
static TOOL: [[Output; 3]; 2] = either("y", "Place of the tool", false);
static FREE_TOOL: [[Output; 3]; 2] = either("y", "Place of the tool", true);
/// q of a spring after the cam.
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

/// q at which a spring of stiffness c balances the loads on a tool of mass m, with the spring's other end at x.
fn balance(at: &At<'_, f64>, [c, m]: [f64; 2], x: f64) -> Result<f64, Fault> {
    let (load, push) = (&at.follower.load, at.process + at.input);
    let stiffness = c + load.stiffness();
    let q = (load.constant_part(m) + push - load.stiffness() * x) / stiffness;
    if stiffness > 0.0 { Ok(q) } else { Err(nothing_holds(at.j, ["the tool of ", ""])) }
}

fn nothing_holds(j: usize, [what, place]: [&str; 2]) -> Fault {
    refused_start(format!(
        "start.mode = equilibrium: neither spring nor load holds {what}follower {}{place}; choose at_rest, or give the follower \
         a spring or a force",
        j + 1
    ))
}
