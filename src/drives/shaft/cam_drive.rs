//! The driven cam that all cam drives share: the motion law U(φ), or another quantity over the angle, and the motion φ(t) of its
//! shaft.

use super::consistency::Consistency;
pub use super::consistency::roundings;
use crate::drives::limits::{FASTEST, INPUTS, LARGEST_ANGLE};
use crate::drives::variable::{Get, Set, SetInput};
use crate::drives::{EventLog, List, Rounded, Seed, Variable, unit, variable};
use crate::motion::parameter::ParameterKind;
use crate::motion::plan::MAX_LENGTH;
use crate::motion::plan::{INFLECTION, MOST_DERIVATIVE};
use crate::motion::{Kinematics, MotionLaw, StandardLaw, TransferFunctions};
use crate::numerics::angle;
use crate::numerics::count::at_most;
use crate::numerics::double_double::{Double, two_product};
use crate::numerics::taylor::Series;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

/// The highest order of input derivatives that enters the motion within a step. Importers extrapolate with one to three, and the
/// state needs a place for each.
pub const MAX_INPUT_DERIVATIVE: usize = 8;

/// Coefficients of the motion polynomial: φ, w, a and the derivatives of `a`.
const COEFFICIENTS: usize = 3 + MAX_INPUT_DERIVATIVE;

/// Initial dependencies of φ, φ̇, φ̈ and U(φ), by the names that [`HasCamDrive`] declares.
pub const PHI: &[&str] = &["phi", "drive.phi_start"];
/// See [`PHI`].
pub const W: &[&str] = &["w", "drive.w"];
/// See [`PHI`].
pub const A: &[&str] = &["a"];
/// See [`PHI`].
pub const CAM: &[&str] = &["cam"];

/// The greatest sizes of q (m or rad) and q̇ (m/s or rad/s) at the start.
pub const LARGEST_START: [f64; 2] = [1e6, 1e9];

/// The motion of the cam shaft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DriveMode {
    /// φ(t) = `phi_start` + `w` (t − t_start).
    Constant {
        /// Angular velocity (rad/s).
        w: f64,
        /// Angle at the start of the simulation (rad).
        phi_start: f64,
    },
    /// Inputs `phi`, `w`, `a`.
    Input,
    /// φ = `phi_start` + ∫ w dt of the input `w` alone.
    Speed {
        /// Angle at the start of the simulation (rad).
        phi_start: f64,
    },
}

impl DriveMode {
    /// The angular velocity (rad/s); 0 on inputs.
    pub fn speed(&self) -> f64 {
        match *self {
            DriveMode::Constant { w, .. } => w,
            DriveMode::Input | DriveMode::Speed { .. } => 0.0,
        }
    }

    /// Parameter 0, ω (rad/s), or 1, φ at the start (rad), to change it; None if an input gives it.
    pub fn parameter_mut(&mut self, which: usize) -> Option<&mut f64> {
        match (self, which) {
            (DriveMode::Constant { w, .. }, 0) => Some(w),
            (DriveMode::Constant { phi_start, .. } | DriveMode::Speed { phi_start }, 1) => Some(phi_start),
            _ => None,
        }
    }

    /// The same, to read it.
    pub fn parameter(&self, which: usize) -> Option<f64> {
        self.clone().parameter_mut(which).copied()
    }
}

/// The start of a cam drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub struct Start {
    /// The way to determine the initial state.
    pub mode: StartMode,
    /// q at the start for [`StartMode::Given`] (m or rad).
    pub q: f64,
    /// q̇ at the start for [`StartMode::Given`] (m/s or rad/s).
    pub q_dot: f64,
}

/// The way to determine the initial state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StartMode {
    /// At rest relative to the cam, q = q̇ = 0.
    AtRest,
    /// From the given values.
    Given,
    /// On the periodic solution.
    SteadyState,
    /// In the equilibrium of loads and springs at the start angle, q̇ = 0.
    Equilibrium,
}

/// The items of `start.mode`.
pub static START_MODE: variable::Enumeration = variable::Enumeration {
    name: "StartMode",
    items: &[
        ("at_rest", "At rest relative to the cam: q = 0, der(q) = 0"),
        ("given", "From start.q and start.q_dot"),
        ("steady_state", "On the periodic solution"),
        ("equilibrium", "In the equilibrium of loads and spring at the start angle; der(q) = 0"),
    ],
};

impl StartMode {
    /// The number of the item in [`START_MODE`].
    pub fn number(self) -> f64 {
        match self {
            StartMode::AtRest => 1.0,
            StartMode::Given => 2.0,
            StartMode::SteadyState => 3.0,
            StartMode::Equilibrium => 4.0,
        }
    }

    /// The item with this number.
    pub fn from_number(number: f64) -> Self {
        match number as i32 {
            1 => StartMode::AtRest,
            2 => StartMode::Given,
            3 => StartMode::SteadyState,
            _ => StartMode::Equilibrium,
        }
    }
}

/// φ(t) = Σ cⱼ (t − t₀)ʲ / j!, the motion of the shaft over a communication step or, at constant speed, without end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AngleMotion {
    /// t₀ (s).
    pub origin: f64,
    /// cⱼ (rad/sʲ).
    pub coefficients: [f64; COEFFICIENTS],
    /// The highest j with cⱼ ≠ 0, at least 1.
    #[serde(deserialize_with = "at_most::<_, { COEFFICIENTS - 1 }>")]
    pub degree: usize,
}

/// The shaft at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShaftState {
    /// φ reduced to [−π, π] without loss of digits (rad).
    pub reduced: f64,
    /// φ (rad) and its time derivatives.
    pub kinematics: Kinematics,
}

impl ShaftState {
    /// The shaft at φ, ω and α from inputs, φ as one number.
    pub fn at_angle([phi, w, a]: [f64; 3]) -> Self {
        ShaftState { reduced: angle::reduce(Double::from(phi)), kinematics: Kinematics([phi, w, a, 0.0, 0.0]) }
    }

    /// U … U⁗ of a cam on it; on a breakpoint of the law the values ahead.
    pub fn on(&self, law: &MotionLaw) -> TransferFunctions {
        law.at_in(law.segment(self.reduced, self.kinematics.0[1] >= 0.0), self.reduced)
    }
}

impl AngleMotion {
    /// Motion at constant speed `w` (rad/s) from `phi` (rad) at `origin` (s).
    pub fn uniform(origin: f64, phi: f64, w: f64) -> Self {
        let mut coefficients = [0.0; COEFFICIENTS];
        (coefficients[0], coefficients[1]) = (phi, w);
        AngleMotion { origin, coefficients, degree: 1 }
    }

    /// φ and its derivatives at `time` (s); the angle is summed in double-double, so its remainder modulo one turn stays accurate
    /// after any number of turns.
    pub fn at(&self, time: f64) -> ShaftState {
        self.at_instant(Double::from(time))
    }

    /// The state at an instant between two `f64`.
    pub fn at_instant(&self, time: Double) -> ShaftState {
        let c = &self.coefficients;
        let tau = time + Double::from(-self.origin);
        if self.is_uniform() {
            let [phi, w, ..] = *c;
            let phi = Double::from(phi) + two_product(w, tau.hi) + Double::from(w * tau.lo);
            return ShaftState { reduced: angle::reduce(phi), kinematics: Kinematics([phi.hi, w, 0.0, 0.0, 0.0]) };
        }
        let (mut d, phi) = (self.derivatives(tau.hi), self.angle_from(Double::from(c[0]), tau));
        d[0] = phi.hi;
        ShaftState { reduced: angle::reduce(phi), kinematics: Kinematics(d) }
    }

    /// φ(t₀ + τ) for φ(t₀) = `phi`.
    fn angle_from(&self, phi: Double, tau: Double) -> Double {
        let c = &self.coefficients;
        let mut above = 0.0;
        for j in (2..=self.degree).rev() {
            above = (c[j] + above) * tau.hi / j as f64;
        }
        // φ = c₀ + (c₁ + above) τ; only the first two terms grow large, so only they are summed with care.
        phi + two_product(c[1], tau.hi) + two_product(above, tau.hi) + Double::from(c[1] * tau.lo)
    }

    /// The derivatives of φ of the orders 1 to N − 1 at `tau` (s) after the origin, in their places, by Horner's rule.
    #[inline(always)]
    pub fn derivatives<const N: usize>(&self, tau: f64) -> [f64; N] {
        let (c, mut d) = (&self.coefficients, [0.0; N]);
        if self.is_uniform() {
            d[1] = c[1];
            return d;
        }
        for order in 1..N.min(self.degree + 1) {
            for j in (order..=self.degree).rev() {
                d[order] = c[j] + d[order] * tau / (j + 1 - order) as f64;
            }
        }
        d
    }

    /// Whether the speed is constant.
    pub fn is_uniform(&self) -> bool {
        self.degree == 1
    }

    /// φ and its derivatives at `time` (s), φ as one number (rad).
    #[inline]
    pub fn kinematics(&self, time: f64) -> [f64; 5] {
        let (c, tau) = (&self.coefficients, time - self.origin);
        if self.degree <= 2 {
            return [c[0] + (c[1] + 0.5 * c[2] * tau) * tau, c[1] + c[2] * tau, c[2], 0.0, 0.0];
        }
        let mut d = self.derivatives(tau);
        d[0] = self.angle(time);
        d
    }

    /// φ at `time` (s) as one number (rad).
    pub fn angle(&self, time: f64) -> f64 {
        let (c, tau) = (&self.coefficients, time - self.origin);
        c[0] + (1..=self.degree).rev().fold(0.0, |above, j| (c[j] + above) * tau / j as f64)
    }

    /// The motion from one time to another (s) in words for messages, with the speed as set.
    pub fn describe(&self, turning: &str, [from, to]: [f64; 2]) -> String {
        let [_, w, a, ..] = self.coefficients;
        let turns = Rounded((self.angle(to) - self.angle(from)).abs() / TAU);
        let acceleration = if a == 0.0 { String::new() } else { format!(" and a = {} rad/s²", Rounded(a)) };
        format!("{turning} makes {turns} turns with w = {} rad/s{acceleration}", Rounded(w))
    }
}

/// Whether inputs φ, ω set at `time` (s) move the shaft from its φ, ω, α by no more than their rounding. That is no jump: otherwise
/// it would shake the drive at every communication point.
pub fn goes_on(from: [f64; 3], [phi, w]: [f64; 2], time: f64) -> bool {
    let [of_phi, of_w] = roundings(from, time);
    (phi - from[0]).abs() <= of_phi && (w - from[1]).abs() <= of_w
}

/// Effect of the rounding of φ, an input, on a state that it accelerates by `slope` · φ within a communication step: the angle is
/// off by half a last place for the `time` (s) of the step, or as long as the acceleration keeps its sign.
pub fn push_of_rounding(inputs: [f64; 3], at: f64, slope: f64, time: f64) -> f64 {
    half_a_place(inputs, at) * slope.abs() * time
}

/// Half a last place of φ as an input at `time` (s), in (rad).
pub fn half_a_place(inputs: [f64; 3], time: f64) -> f64 {
    0.125 * roundings(inputs, time)[0]
}

/// Law and motion of the cam of a cam drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CamDrive<Law = MotionLaw> {
    /// U(φ); shared by all instances that have not changed it.
    pub law: Arc<Law>,
    /// Prescribed speed or inputs.
    pub mode: DriveMode,
    /// The time at which φ = `phi_start` (s).
    start_time: f64,
    /// φ, w, a as set by the importer; if only w is an input, the integrated φ, and the a from its derivative.
    input: [f64; 3],
    /// The excess of φ, integrated from w, over the nearest number.
    below: f64,
    /// Whether φ and w belong together.
    consistency: Consistency,
    /// The further coefficients of the motion, from derivatives of the inputs and valid for the next step; and the input of each,
    /// counted from 1, 0 for none.
    beyond: [f64; MAX_INPUT_DERIVATIVE],
    from: [u8; MAX_INPUT_DERIVATIVE],
}

impl<Law> CamDrive<Law> {
    /// A cam in its initial position.
    pub fn new(law: Law, mode: DriveMode) -> Self {
        CamDrive {
            law: Arc::new(law),
            mode,
            start_time: 0.0,
            input: [0.0; 3],
            below: 0.0,
            consistency: Consistency::default(),
            beyond: [0.0; MAX_INPUT_DERIVATIVE],
            from: [0; MAX_INPUT_DERIVATIVE],
        }
    }

    /// Takes law and mode of another cam with the same parameters: only the parameters count of a cam read from bytes.
    pub fn take(&mut self, made: &Self) {
        (self.law, self.mode) = (made.law.clone(), made.mode.clone());
    }

    /// Starts the simulation at `time` (s).
    pub fn start(&mut self, time: f64) {
        self.start_time = time;
        if let DriveMode::Speed { phi_start } = self.mode {
            (self.input[0], self.below) = (phi_start, 0.0);
        }
        let [phi, w, _] = self.input;
        self.consistency = Consistency::begin([phi, w], time);
    }

    /// The motion of the shaft over the communication step that starts at `time` (s).
    ///
    /// Inputs: φ, w and a are the first three coefficients. The higher ones come from the derivatives of `a`, else of `w`, else of
    /// `phi`, whichever the importer has set. If only w is an input, φ is integrated and a is the first derivative of w; w without
    /// derivatives is held over the step.
    pub fn motion(&self, time: f64) -> AngleMotion {
        match self.mode {
            DriveMode::Constant { w, phi_start } => AngleMotion::uniform(self.start_time, phi_start, w),
            DriveMode::Input | DriveMode::Speed { .. } => {
                let [phi, w, a] = self.input;
                let mut motion = AngleMotion::uniform(time, phi, w);
                (motion.coefficients[2], motion.degree) = (a, if a == 0.0 { 1 } else { 2 });
                if self.from == [0; MAX_INPUT_DERIVATIVE] { motion } else { self.with_derivatives(motion) }
            }
        }
    }

    #[cold]
    fn with_derivatives(&self, mut motion: AngleMotion) -> AngleMotion {
        motion.coefficients[3..].copy_from_slice(&self.beyond);
        motion.degree = (2..COEFFICIENTS).rev().find(|&j| motion.coefficients[j] != 0.0).unwrap_or(1);
        motion
    }

    /// φ at the `end` of the communication step that starts at `time` (s).
    #[inline(always)]
    pub fn angle(&self, time: f64, end: f64) -> f64 {
        if let DriveMode::Constant { w, phi_start } = self.mode {
            return phi_start + w * (end - self.start_time);
        }
        match self.plain_inputs() {
            Some([phi, w, a]) => phi + (w + 0.5 * a * (end - time)) * (end - time),
            None => self.motion(time).angle(end),
        }
    }

    /// φ, w, a as set by the importer, if nothing else is known of the motion.
    #[inline(always)]
    pub fn plain_inputs(&self) -> Option<[f64; 3]> {
        (self.is_input() && self.from == [0; MAX_INPUT_DERIVATIVE]).then_some(self.input)
    }

    /// Sets φ, w, a.
    #[cfg(test)]
    pub fn set_inputs(&mut self, inputs: [f64; 3]) {
        self.input = inputs;
    }

    /// The range of φ, w, a that are inputs; they come first among all inputs.
    pub fn inputs(&self) -> Range<usize> {
        match self.mode {
            DriveMode::Constant { .. } => 0..0,
            DriveMode::Input => 0..3,
            DriveMode::Speed { .. } => 1..2,
        }
    }

    /// The names of φ, w, a that are inputs or states.
    pub fn known(&self) -> &'static [&'static str] {
        match self.mode {
            DriveMode::Constant { .. } => &[],
            DriveMode::Input => &["phi", "w", "a"],
            DriveMode::Speed { .. } => &["phi", "w"],
        }
    }

    /// Whether φ is integrated from w.
    pub fn integrates(&self) -> bool {
        matches!(self.mode, DriveMode::Speed { .. })
    }

    /// Whether the shaft follows inputs.
    #[inline(always)]
    pub fn is_input(&self) -> bool {
        !matches!(self.mode, DriveMode::Constant { .. })
    }

    /// Input `which` (0: phi, 1: w, 2: a) as set.
    pub fn input(&self, which: usize) -> f64 {
        self.input[which]
    }

    /// Sets input `which`; its derivatives are forgotten, since they belong to the previous value.
    pub fn set_input(&mut self, which: usize, value: f64) {
        self.input[which] = value;
        if self.integrates() {
            self.input[2] = 0.0;
        }
        if self.from != [0; MAX_INPUT_DERIVATIVE] {
            self.forget(which);
        }
    }

    /// Sets the derivative of this order of input `which` (0: phi, 1: w, 2: a); order 0 is the input itself.
    pub fn set_input_derivative(&mut self, which: usize, order: usize, value: f64) {
        if order == 0 {
            return self.set_input(which, value);
        }
        if self.integrates() && order == 1 {
            self.input[2] = value;
        }
        // A derivative of `a` is more precise than one of w, and that more than one of phi.
        let rank = which as u8 + 1;
        if let Some(j) = (which + order).checked_sub(3)
            && self.from.get(j).is_some_and(|from| *from <= rank)
        {
            (self.beyond[j], self.from[j]) = (value, rank);
        }
    }

    /// Forgets the coefficients from derivatives of input `which`.
    #[cold]
    fn forget(&mut self, which: usize) {
        for (value, from) in self.beyond.iter_mut().zip(&mut self.from).filter(|(_, from)| **from == which as u8 + 1) {
            (*value, *from) = (0.0, 0);
        }
    }

    /// Ends the step on `motion` at `end` (s). The input derivatives hold for one communication step only.
    #[inline]
    pub fn step_done(&mut self, motion: &AngleMotion, end: f64) {
        if !self.is_input() {
            return;
        }
        if self.from != [0; MAX_INPUT_DERIVATIVE] {
            (self.beyond, self.from) = ([0.0; MAX_INPUT_DERIVATIVE], [0; MAX_INPUT_DERIVATIVE]);
        }
        let [phi, w, _] = self.input;
        if self.integrates() {
            let from = Double { hi: phi, lo: self.below };
            let phi = motion.angle_from(from, Double::from(end) + Double::from(-motion.origin));
            (self.input, self.below) = ([phi.hi, w, 0.0], phi.lo);
        } else {
            (self.consistency.from, self.consistency.time) = ([phi, w], motion.origin);
        }
    }

    /// Whether the inputs at `time` (s) differ from the φ and ω to which the previous step led, `expected`; logs it if they contradict each
    /// other.
    #[cold]
    pub fn jumps(&mut self, expected: [f64; 2], time: f64, log: &mut EventLog) {
        if !self.integrates() {
            let [phi, w, _] = self.input;
            self.consistency.compare([phi, w], expected, time, log);
        }
    }
}

impl CamDrive {
    /// The shaft and the transfer functions of the cam at `time` (s) on `motion`.
    pub fn at(&self, motion: &AngleMotion, time: f64) -> (ShaftState, TransferFunctions) {
        let shaft = motion.at(time);
        (shaft, self.law.at(shaft.reduced))
    }
}

/// A field, to read and to change: `field!(start_values, start_values_mut: Start = start)`.
macro_rules! field {
    ($get:ident, $get_mut:ident: $type:ty = $field:ident) => {
        fn $get(&self) -> &$type {
            &self.$field
        }
        fn $get_mut(&mut self) -> &mut $type {
            &mut self.$field
        }
    };
}
pub(in crate::drives) use field;

/// Methods of [`Drive`](crate::drives::Drive) that all drives with a `cam`, a `solver`, a `log` and a module `variables` share.
macro_rules! as_every_cam_drive {
    () => {
        #[inline(always)]
        fn angle(&self, time: f64, end: f64) -> f64 {
            self.cam.angle(time, end)
        }

        fn evaluate(&self, values: &mut [f64]) {
            variables::evaluate(self, values);
        }

        fn request_tolerance(&mut self, tolerance: f64) {
            self.solver.requested = tolerance;
        }

        fn events(&mut self) -> &mut EventLog {
            &mut self.log
        }
    };
}
pub(in crate::drives) use as_every_cam_drive;

/// Declares the outputs of a cam drive.
pub struct Outputs<'a, D> {
    list: &'a mut List<D>,
    /// Those of φ, w, a that are inputs or states.
    shaft: &'static [&'static str],
    states: &'static [&'static str],
    series: fn(&D, Seed, usize) -> Series,
}

impl<D> Outputs<'_, D> {
    /// An output in its place, with the inputs and states that it depends on directly.
    pub fn add(
        &mut self,
        place: usize,
        name: &str,
        text: &str,
        quantity: &'static unit::Quantity,
        known: &[&str],
    ) -> &mut Variable<D> {
        let known = self.of_known(known);
        let output = self.list.output(name, text, variable::real(quantity), self.series);
        output.at(place).depends(&known);
        if self.states.contains(&name) { output.state() } else { output }
    }

    /// A discrete output in its place.
    pub fn add_discrete(
        &mut self,
        place: usize,
        name: &str,
        text: &str,
        kind: variable::Kind,
        known: &[&str],
    ) -> &mut Variable<D> {
        let known = self.of_known(known);
        self.list.discrete_output(name, text, kind).at(place).depends(&known)
    }

    /// φ and ω, which are outputs unless they are inputs.
    pub fn add_shaft(&mut self, [phi, w]: [usize; 2]) {
        if self.shaft.contains(&"a") {
            return;
        }
        let integrates = !self.shaft.is_empty();
        let angle = self.add(phi, "phi", "Drive angle", &unit::ANGLE, &["phi"]).depends_initially(&[PHI]);
        angle.description.state = integrates;
        let (name, text) =
            if integrates { ("der(phi)", "Its rate, the input w") } else { ("w", "Angular velocity of the drive") };
        self.add(w, name, text, &unit::ANGULAR_VELOCITY, &["w"]).depends_initially(&[W]);
    }

    fn of_known<'b>(&self, names: &[&'b str]) -> Vec<&'b str> {
        let shaft = ["phi", "w", "a"];
        names.iter().copied().filter(|name| self.shaft.contains(name) || !shaft.contains(name)).collect()
    }
}

/// Declares the inputs of the motion: those of φ, w, a in the range `inputs`.
pub fn declare_inputs<D>(list: &mut List<D>, inputs: Range<usize>, get: Get<D>, set: SetInput<D>) {
    let speed = match inputs.len() {
        1 => "Angular velocity of the drive; without derivatives held over the communication step",
        _ => "Angular velocity of the drive, der(phi)",
    };
    let all = [
        ("phi", "Drive angle", &unit::ANGLE),
        ("w", speed, &unit::ANGULAR_VELOCITY),
        ("a", "Angular acceleration of the drive, der(phi,2)", &unit::ANGULAR_ACCELERATION),
    ];
    for i in inputs {
        let (name, text, quantity) = all[i];
        list.input(name, text, variable::real_within(quantity, -INPUTS[i], INPUTS[i]), get, set).at(i);
    }
}

/// Declares the parameters of the motion; their access takes the numbers of [`DriveMode::parameter`].
pub fn declare_parameters<D>(list: &mut List<D>, mode: &DriveMode, get: Get<D>, set: Set<D>) {
    let all = [
        ("drive.w", "Angular velocity of the drive", &unit::ANGULAR_VELOCITY, FASTEST, "drive.speed"),
        (
            "drive.phi_start",
            "Drive angle at the start of the simulation",
            &unit::ANGLE,
            LARGEST_ANGLE,
            "drive.phi_start",
        ),
    ];
    for (i, (name, text, quantity, most, key)) in all.into_iter().enumerate() {
        if mode.parameter(i).is_some() {
            list.parameter(name, text, variable::real_within(quantity, -most, most), get, set).key(key).at(i);
        }
    }
}

/// A drive with a driven cam.
pub trait HasCamDrive: Sized {
    /// Quantities that depend on the angle of the cam.
    type Law;

    /// The cam.
    fn cam(&self) -> &CamDrive<Self::Law>;
    /// The cam, to change it.
    fn cam_mut(&mut self) -> &mut CamDrive<Self::Law>;

    /// Declares those of `phi`, `w`, `a` that are inputs, and the drive parameters.
    fn declare_drive(&self, list: &mut List<Self>) {
        let set = |d: &mut Self, i: usize, order: usize, value| d.cam_mut().set_input_derivative(i, order, value);
        declare_inputs(list, self.cam().inputs(), |d, i| d.cam().input(i), set);
        let set =
            |d: &mut Self, i: usize, value| d.cam_mut().mode.parameter_mut(i).into_iter().for_each(|p| *p = value);
        declare_parameters(list, &self.cam().mode, |d, i| d.cam().mode.parameter(i).unwrap_or(0.0), set);
    }

    /// Begins to declare the outputs, all with this `series`; `states` names those that are states.
    fn outputs<'a>(
        &self,
        list: &'a mut List<Self>,
        states: &'static [&'static str],
        series: fn(&Self, Seed, usize) -> Series,
    ) -> Outputs<'a, Self> {
        Outputs { list, shaft: self.cam().known(), states, series }
    }

    /// The start of the drive.
    fn start_values(&self) -> &Start;
    /// The start of the drive, to change it.
    fn start_values_mut(&mut self) -> &mut Start;

    /// Dependencies of a start on the periodic solution, which inputs do not allow; `of` are the parameters of the vibration.
    fn periodic_start(&self, of: &[&'static str]) -> Vec<&'static str> {
        if self.cam().is_input() { Vec::new() } else { [of, PHI, W, &["start.mode"]].concat() }
    }

    /// Declares `start.mode`, `start.q` and `start.q_dot`; q is a length or an angle.
    fn declare_start(&self, list: &mut List<Self>, q: &'static unit::Quantity, q_dot: &'static unit::Quantity) {
        list.parameter(
            "start.mode",
            "How the initial state is found",
            variable::Kind::Enumeration(&START_MODE),
            |d, _| d.start_values().mode.number(),
            |d, _, value| d.start_values_mut().mode = StartMode::from_number(value),
        );
        list.parameter(
            "start.q",
            "q at the start, for start.mode = given",
            variable::real_within(q, -LARGEST_START[0], LARGEST_START[0]),
            |d, _| d.start_values().q,
            |d, _, value| d.start_values_mut().q = value,
        );
        list.parameter(
            "start.q_dot",
            "der(q) at the start, for start.mode = given",
            variable::real_within(q_dot, -LARGEST_START[1], LARGEST_START[1]),
            |d, _| d.start_values().q_dot,
            |d, _, value| d.start_values_mut().q_dot = value,
        );
    }

    /// Declares the parameters of the motion law; last in the list, since their number depends on the scene.
    fn declare_law(&self, list: &mut List<Self>)
    where
        Self: HasCamDrive<Law = MotionLaw>,
    {
        for (k, parameter) in self.cam().law.parameters().into_iter().enumerate() {
            list.parameter(
                &format!("cam.{}", parameter.name),
                &parameter.text,
                law_parameter_kind(parameter.kind),
                |d, k| d.cam().law.parameter(k),
                |d, k, value| Arc::make_mut(&mut d.cam_mut().law).set_parameter(k, value),
            )
            .at(k);
        }
    }
}

/// The items of `cam.rise_law` and `cam.return_law`, in the order of [`crate::motion::StandardLaw::ALL`].
pub static STANDARD_LAW: variable::Enumeration = variable::Enumeration {
    name: "StandardLaw",
    items: &[
        (StandardLaw::SimpleSine.name(), "(1 - cos(pi z))/2; the acceleration jumps at both ends"),
        (StandardLaw::InclinedSine.name(), "z - sin(2 pi z)/(2 pi), after Bestehorn"),
        (StandardLaw::Polynomial345.name(), "10 z^3 - 15 z^4 + 6 z^5"),
        (StandardLaw::Polynomial4567.name(), "35 z^4 - 84 z^5 + 70 z^6 - 20 z^7"),
        (StandardLaw::ModifiedSine.name(), "Acceleration from sines of two frequencies"),
        (StandardLaw::ModifiedTrapezoid.name(), "Trapezoidal acceleration with sinusoidal slopes"),
    ],
};

/// The type of the variable that holds a parameter of a motion law.
pub fn law_parameter_kind(kind: ParameterKind) -> variable::Kind {
    match kind {
        ParameterKind::Length => variable::real_within(&unit::LENGTH, -MAX_LENGTH, MAX_LENGTH),
        ParameterKind::Angle { min, max } => variable::real_within(&unit::ANGLE, min, max),
        ParameterKind::Derivative(order) => {
            let quantities = [&unit::LENGTH_PER_ANGLE, &unit::LENGTH_PER_ANGLE2, &unit::LENGTH_PER_ANGLE3];
            variable::real_within(quantities[order.clamp(1, 3) - 1], -MOST_DERIVATIVE, MOST_DERIVATIVE)
        }
        ParameterKind::Inflection => variable::real_within(&unit::NUMBER, INFLECTION[0], INFLECTION[1]),
        ParameterKind::Factor => variable::real_within(&unit::NUMBER, -1e6, 1e6),
        ParameterKind::Law => variable::Kind::Enumeration(&STANDARD_LAW),
    }
}

#[cfg(test)]
mod tests;
