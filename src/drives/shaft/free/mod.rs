//! The free shaft: the parts of its equation of motion J(φ) φ̈ + ½ J′(φ) φ̇² = M_an − τ, and the state that it moves.

pub(in crate::drives) mod coupled;
pub(in crate::drives) mod equation;
pub(in crate::drives) mod inertia;
pub(in crate::drives) mod motor;
pub(in crate::drives) mod profile;
pub(in crate::drives) mod signal;
pub(in crate::drives) mod torques;

use crate::drives::Fault;
use crate::drives::follower::rigid::Follower;
use crate::numerics::angle::{self, WHOLE_TURN};
use crate::numerics::double_double::{Double, two_product};
use coupled::{Loads, check_positive};
use inertia::Inertia;
use motor::{Kloss, Motor};
use profile::Profile;
use serde::{Deserialize, Serialize};
use signal::Signal;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The parts of the equation of motion.
#[derive(Clone, Serialize, Deserialize)]
pub struct Shaft {
    /// J(φ); shared by all instances that have not changed it.
    pub inertia: Arc<Inertia>,
    /// The source of M_an.
    pub motor: Motor,
    /// The loads of other units: one input `tau`, or the inputs of each.
    pub loads: Loads,
    /// Input `M_an`, for [`Motor::Input`].
    pub driving: Signal,
    /// J(φ) as a table; follows from the inertia.
    #[serde(skip)]
    pub profile: Arc<Profile>,
}

/// The state of the machine at a communication point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// φ − 2π `turns` (rad), within a turn; its low part takes up the rounding of many small steps.
    pub angle: Double,
    /// Whole turns. Since they are kept apart from the angle, a million turns cost no digit.
    pub turns: f64,
    /// φ̇ (rad/s).
    pub w: f64,
    /// u = √J φ̇ [√J]: E = ½u². See `equation` for the reason. Not up to date during an angle step.
    pub u: Double,
    /// M_an (N·m) of a motor with a lag.
    pub torque: f64,
    /// The interval between the borders of the laws that holds the angle.
    pub interval: usize,
    /// The angle passed since the start, there and back (rad), up to the internal step that holds the communication point.
    pub travelled: f64,
    /// The greatest |φ̇| since the start (rad/s) while the motion was integrated in time.
    pub top_speed: f64,
}

impl Shaft {
    /// Relative errors of φ, φ̇ and M_an by the roundings of anglesfrom `phi` (rad) on, and of laws. The torque of a motor with a
    /// lag changes by 2/s_K times as much as the speed, which it then disturbs.
    pub fn roundings(&self, phi: f64) -> f64 {
        let part = |follower: &Follower| follower.cam.roundings()[0] / follower.cam.bound(1);
        let of_laws = self.inertia.followers.iter().map(part).fold(0.0, f64::max);
        let of_torque = match self.motor {
            Motor::Kloss(Kloss { breakdown_slip, dynamics: Some(_), .. }) => 2.0 / breakdown_slip,
            _ => 0.0,
        };
        (f64::EPSILON * (1.0 + phi.abs()) + of_laws) * (1.0 + of_torque)
    }

    /// J, J′ of the shaft itself in this state.
    pub fn own_inertia(&self, state: &State) -> [f64; 2] {
        self.profile.with_slope(state.interval, state.angle.hi)
    }

    /// J, J′ of the shaft and its loads in this state of the present step.
    pub fn inertia_at(&self, state: &State) -> [f64; 2] {
        let own = self.own_inertia(state);
        self.loads.from(state).map_or(own, |loads| [0, 1].map(|n| own[n] + loads.at(0.0)[n]))
    }

    /// Begins a communication step; φ̇ is continuous even if the inertia of loads changes.
    ///
    /// # Errors
    /// The inertia is not positive.
    pub fn step_begins(&mut self, state: &mut State) -> Result<(), Fault> {
        self.loads.step_begins(state);
        self.driving.step_begins();
        if self.loads.have_inertia() {
            self.check_inertia(state)?;
            state.u = Double::from(self.inertia_at(state)[0]).sqrt() * Double::from(state.w);
        }
        Ok(())
    }

    /// Refuses an inertia of the loads that makes the whole inertia not positive at the communication point.
    pub fn check_inertia(&self, state: &State) -> Result<(), Fault> {
        let [own, loads] = [self.own_inertia(state)[0], self.loads.now(state)[0]];
        check_positive([own, loads], state.angle.hi)
    }

    /// M_an − τ at the speed `w` and now.
    pub fn net_torque(&self, state: &State, w: f64) -> f64 {
        self.motor.driving(w, self.known_torque(state)) - self.loads.torque_now()
    }

    /// M_an (N·m) as an input or a state; 0 otherwise.
    pub fn known_torque(&self, state: &State) -> f64 {
        if self.motor == Motor::Input { self.driving.now() } else { state.torque }
    }

    /// Whether no input depends on time in this step.
    pub fn torques_are_constant(&self) -> bool {
        self.loads.are_constant() && self.driving.is_constant()
    }

    /// The part of τ − M_an that does not depend on the speed (N·m).
    pub fn constant_torque(&self) -> f64 {
        self.loads.set_value() - if self.motor == Motor::Input { self.driving.set_value() } else { 0.0 }
    }

    /// The state at the angle `phi` (rad) with the speed `w` (rad/s) and M_an of a motor with a lag (N·m); at a border of the laws
    /// in the interval ahead.
    pub fn state_at(&self, phi: f64, w: f64, torque: f64) -> State {
        let mut state = State { w, torque, ..State::default() };
        let backwards = if w == 0.0 { self.net_torque(&state, 0.0) } else { w } < 0.0;
        let (interval, within) = self.inertia.interval(angle::reduce(Double::from(phi)), !backwards);
        (state.interval, state.angle) = (interval, Double::from(within));
        state.turns = ((phi - within) / TAU).round();
        state.u = Double::from(self.inertia_at(&state)[0]).sqrt() * Double::from(w);
        state
    }
}

impl State {
    /// φ and the whole turns on a mesh, whose turn begins at 0 if there are no borders.
    pub fn on_mesh(&self, inertia: &Inertia) -> (Double, f64) {
        let before = inertia.borders().is_empty() && self.angle.hi < 0.0;
        if before { (self.angle + WHOLE_TURN, self.turns - 1.0) } else { (self.angle, self.turns) }
    }

    /// u from E in this sense of rotation.
    pub fn take_energy(&mut self, energy: Double, sense: f64) {
        let root = (energy + energy).sqrt();
        self.u = if sense > 0.0 { root } else { -root };
    }

    /// φ̇ from u.
    pub fn take_speed(&mut self, shaft: &Shaft) {
        self.w = self.u.hi / shaft.inertia_at(self)[0].sqrt();
    }

    /// Adds increments of φ, u and M_an.
    pub fn add(&mut self, shaft: &Shaft, [phi, u, torque]: [f64; 3]) {
        self.angle = self.angle + Double::from(phi);
        self.u = self.u + Double::from(u);
        self.torque += torque;
        if shaft.inertia.borders().is_empty() {
            self.take_turns((self.angle.hi / TAU).round());
        }
        self.take_speed(shaft);
    }

    /// Changes the interval after the shaft has passed its border.
    pub fn change_interval(&mut self, inertia: &Inertia, upward: bool) {
        let turns;
        (self.interval, turns) = beside(self.interval, inertia.borders().len(), upward);
        self.take_turns(turns);
    }

    /// Moves whole turns from the angle to their counter.
    fn take_turns(&mut self, turns: f64) {
        if turns != 0.0 {
            let angle = two_product(turns, WHOLE_TURN.hi) + two_product(turns, WHOLE_TURN.lo);
            self.angle = self.angle - angle;
            self.turns += turns;
        }
    }
}

/// The part of the turn after part `i` of `count`, and the whole turns that it completes.
pub fn beside(i: usize, count: usize, forward: bool) -> (usize, f64) {
    match (i, forward) {
        (i, true) if i + 1 == count => (0, 1.0),
        (i, true) => (i + 1, 0.0),
        (0, false) => (count - 1, -1.0),
        (i, false) => (i - 1, 0.0),
    }
}
