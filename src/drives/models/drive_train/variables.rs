//! The variables of the train and its output equations.

use super::{DriveTrain, Follower, Joint, MOST_FOLLOWERS, Names};
use crate::drives::follower::contact::Mode;
use crate::drives::follower::load::Load;
use crate::drives::follower::{contact, elastic_output, elastic_shaft, rigid};
use crate::drives::limits::{FASTEST, LARGEST_ANGLE};
use crate::drives::parameter::{Has, Parameters};
use crate::drives::settings::HasSolver;
use crate::drives::shaft::cam_drive::{declare_inputs, declare_parameters};
use crate::drives::shaft::free::coupled::{COUPLING, declare_loads};
use crate::drives::shaft::free::inertia::InertiaFunction;
use crate::drives::shaft::free::motor::{Kloss, LAG};
use crate::drives::shaft::free::signal::Signal;
use crate::drives::shaft::laws::{HasLaws, INERTIA_LAW, LOAD_LAW, declare_law, declare_mechanisms};
use crate::drives::shaft::loads::{HasLoads, declare_force, declare_load, tell_of_pull};
use crate::drives::shaft::motor::{Reference, Servo, Source, Transmission};
use crate::drives::shaft::train::{Dynamics, Functions, Given, MOST_STATES};
use crate::drives::unit::{self, Quantity};
use crate::drives::variable::{Kind, Variability, real, real_within};
use crate::drives::{List, Seed, Variable};
use crate::motion::MotionLaw;
use crate::numerics::double_double::Double;
use crate::numerics::taylor::{Scalar, Series};

/// Rate of a torque (N·m/s).
static TORQUE_RATE: Quantity = Quantity { name: "TorqueRate", unit: "N.m/s", base: [1, 2, -3, 0], display: None };

/// Places of the outputs: those of the shaft …
const PHI: usize = 0;
const W: usize = 1;
const A: usize = 2;
const TORQUE: usize = 3;
const INERTIA: usize = 4;
const ENERGY: usize = 5;
const ROTOR: usize = 6;
const ROTOR_SPEED: usize = 7;
pub(super) const DEMAND: usize = 8;
pub(super) const SATURATED: usize = 9;
const STATISTICS: usize = 10;
const PERIOD: usize = 13;
const MULTIPLIER: usize = 14;
const STATE: usize = 15;
const STATE_RATE: usize = 16;
/// … and of each follower.
const ROTOR_ACCELERATION: usize = 17;
const COUPLED: usize = 18;
const FOLLOWERS: usize = COUPLED + COUPLING.len();
const EACH: usize = 25;

/// How many places there are for so many followers.
pub(super) fn places(followers: usize) -> usize {
    FOLLOWERS + EACH * followers
}

/// What the start depends on beside its inputs.
const PARAMETERS: &[&str] = &["J0", "inertia", "load", "motor", "drive", "start", "phi_start", "w_start"];

/// The same of each follower, all but its input.
const PARAMETERS_OF_FOLLOWER: &[&str] =
    &["m", "J", "c", "b", "m1", "m2", "s", "e", "m_roller", "load", "cam", "crank", "linkage"];

/// An output of a follower.
#[derive(Clone, Copy)]
pub(super) enum Of {
    U,
    X1,
    X1Dot,
    Y,
    YDot,
    YDotDot,
    Q,
    QDot,
    Psi,
    Force,
    Contact,
    Tau,
    Gap,
    Mode,
    Impulse,
    Impacts,
    Loss,
    ForceMean,
    TauMean,
    X1DotDot,
    QDotDot,
    Lever,
    LeverDot,
    LeverDotDot,
    Damped,
}

pub(super) fn place(j: usize, of: Of) -> usize {
    FOLLOWERS + EACH * j + of as usize
}

/// The train at an instant, in numbers or series.
struct Point<S> {
    phi: S,
    w: S,
    y: [S; MOST_STATES],
    given: Given<S>,
    f: Functions<S>,
}

/// Motion and inputs as series, without the functions of the angle.
struct Seeded {
    phi: Series,
    w: Series,
    y: [Series; MOST_STATES],
    given: Given<Series>,
}

/// Gives the outputs, of numbers or of series, to `put`.
fn outputs<S: Scalar>(d: &DriveTrain, p: &Point<S>, mut put: impl FnMut(usize, S)) {
    let (train, modes) = (&d.train, &d.run.modes);
    let Point { phi, w, y, given, f } = p;
    let motion: Dynamics<S> = train.dynamics(modes, y, f, given);
    put(PHI, *phi);
    put(W, *w);
    put(A, motion.a);
    put(TORQUE, motion.torque);
    put(INERTIA, f.inertia);
    put(ENERGY, f.inertia * *w * *w * 0.5);
    if d.coupling {
        let rest = train.reactions(modes, f, given, *w, &motion.spring);
        [f.inertia, f.half_slope * 2.0, rest].into_iter().enumerate().for_each(|(i, value)| put(COUPLED + i, value));
    }
    if let Some(motor) = d.motor() {
        put(ROTOR, motor.angle(*phi, y, &train.layout));
        put(ROTOR_SPEED, motor.speed(y, &train.layout));
        put(DEMAND, motion.demand);
        put(ROTOR_ACCELERATION, motion.rotor);
        if motor.states() > 0 {
            put(STATE, y[train.layout.motor]);
            put(STATE_RATE, motion.rates[train.layout.motor]);
        }
    }
    for j in 0..train.followers.len() {
        Member { d, p, motion: &motion, j }.outputs(&mut |of, value| put(place(j, of), value));
    }
}

/// A follower of the train at an instant.
struct Member<'a, S> {
    d: &'a DriveTrain,
    p: &'a Point<S>,
    motion: &'a Dynamics<S>,
    j: usize,
}

impl<S: Scalar> Member<'_, S> {
    fn outputs(&self, put: &mut impl FnMut(Of, S)) {
        let Member { d, p, motion, j } = *self;
        let (follower, w) = (&d.train.followers[j], p.w);
        let ([u, u1, u2], at, y) = (p.f.cams[j], d.train.layout.followers[j], &p.y);
        let (rate, spring) = (motion.rates.get(at..).unwrap_or_default(), motion.spring[j]);
        let [first, tool] = motion.accelerations[j];
        put(Of::U, u);
        match follower.joint {
            Joint::Rigid => self.rigid(put),
            Joint::Output(_, m_x) => {
                let (place, speed) = (u + y[at], u1 * w + y[at + 1]);
                let normal = spring + self.flank() * m_x - follower.roller.force(m_x, [u, u1 * w], None, None);
                put(Of::Y, place);
                put(Of::YDot, speed);
                put(Of::YDotDot, tool);
                put(Of::Q, y[at]);
                put(Of::QDot, y[at + 1]);
                put(Of::QDotDot, rate[1]);
                put(Of::Force, spring);
                put(Of::Contact, normal);
                put(Of::Tau, u1 * normal);
            }
            Joint::Shaft(own) => {
                let speed = w + y[at + 1];
                let velocity = u1 * speed;
                let acceleration = u2 * speed * speed + u1 * first;
                let normal = acceleration * own.m - self.on_tool(own.m, [u, velocity]);
                put(Of::Psi, p.phi + y[at]);
                put(Of::Y, u);
                put(Of::YDot, velocity);
                put(Of::YDotDot, acceleration);
                put(Of::Q, y[at]);
                put(Of::QDot, y[at + 1]);
                put(Of::QDotDot, rate[1]);
                put(Of::Force, normal);
                put(Of::Contact, normal);
                put(Of::Tau, spring);
            }
            Joint::Backlash(own) => self.backlash(&own, put),
        }
    }

    /// The acceleration of the cam's flank.
    fn flank(&self) -> S {
        let [_, u1, u2] = self.p.f.cams[self.j];
        u2 * self.p.w * self.p.w + u1 * self.motion.a
    }

    /// The load on a tool of mass m with this place and velocity.
    fn on_tool(&self, m: f64, place: [S; 2]) -> S {
        let Point { given, f, .. } = self.p;
        self.d.train.followers[self.j].load.force(m, place, Some(f.process[self.j]), Some(given.forces[self.j]))
    }

    fn rigid(&self, put: &mut impl FnMut(Of, S)) {
        let Member { d, p, motion, j } = *self;
        let (rigid, [u, u1, _], w, x2) = (&d.train.followers[j].rigid, p.f.cams[j], p.w, self.flank());
        let (speed, m) = (u1 * w, rigid.m);
        let load = self.on_tool(m, [u, speed]);
        let normal = x2 * m - load;
        // Of mechanisms the inertia and the weight of the links count, too.
        let tau = match d.train.links(&d.run.modes, j, p.phi) {
            None => u1 * normal,
            Some([inertia, half_slope, weight]) => inertia * motion.a + half_slope * w * w - weight - u1 * load,
        };
        put(Of::Y, u);
        put(Of::YDot, speed);
        put(Of::YDotDot, x2);
        put(Of::Force, normal);
        put(Of::Contact, normal);
        put(Of::Tau, tau);
        if rigid.has_lever() {
            let cam = rigid.cam.at_in(d.run.modes.segments[1 + j][0], p.phi.value()).0;
            let [u, u1, u2] = [0, 1, 2].map(|n| p.phi.compose([cam[n], cam[n + 1], cam[n + 2]]));
            put(Of::Lever, u);
            put(Of::LeverDot, u1 * w);
            put(Of::LeverDotDot, u2 * w * w + u1 * motion.a);
        }
    }

    fn backlash(&self, own: &contact::Parameters, put: &mut impl FnMut(Of, S)) {
        let Member { d, p, motion, j } = *self;
        let (modes, [u, u1, _], w) = (&d.run.modes, p.f.cams[j], p.w);
        let (at, y) = (d.train.layout.followers[j], &p.y);
        let (rate, [first, tool]) = (motion.rates.get(at..).unwrap_or_default(), motion.accelerations[j]);
        let home = S::from(modes.home(j, own.s));
        let (gap, speed) = (home + y[at], u1 * w + y[at + 1]);
        let place = u + gap;
        put(Of::X1, place);
        put(Of::X1Dot, speed);
        put(Of::Gap, gap);
        put(Of::Force, motion.normal[j]);
        put(Of::Contact, motion.normal[j]);
        put(Of::Tau, u1 * motion.normal[j]);
        put(Of::X1DotDot, first);
        // A jump of the inputs takes a mass in contact along.
        if modes.contacts[j] != Mode::Free && d.motion_is_input() {
            let flank = u1 * w;
            put(Of::Impulse, (flank - S::from(flank.value())) * own.m1 + S::from(d.run.tallies[j].impulse));
        }
        if own.m2 > 0.0 {
            put(Of::Y, place + y[at + 2]);
            put(Of::YDot, speed + y[at + 3]);
            put(Of::YDotDot, tool);
            put(Of::Q, y[at + 2]);
            put(Of::QDot, y[at + 3]);
            put(Of::QDotDot, rate[3]);
        } else {
            put(Of::Y, place);
            put(Of::YDot, speed);
            put(Of::YDotDot, first);
        }
    }
}

/// Declares a parameter that only some scenes have: how it is read and set behind the accessors of what has it.
macro_rules! number {
    ($list:expr, $name:expr, $text:literal, $kind:expr, $variability:ident, $of:ident, $of_mut:ident, $v:ident => $place:expr) => {
        $list
            .parameter(
                $name,
                $text,
                $kind,
                |d, _| d.$of().map_or(0.0, |$v| $place),
                |d, _, value| {
                    d.retune();
                    d.$of_mut().into_iter().for_each(|$v| $place = value)
                },
            )
            .description
            .variability = Variability::$variability
    };
}

pub(super) fn evaluate(d: &DriveTrain, values: &mut [f64]) {
    outputs(d, &d.point(), |place, value| {
        if let Some(into) = values.get_mut(place) {
            *into = value;
        }
    });
    let turns = d.run.turns * std::f64::consts::TAU;
    values[PHI] = d.motion.map_or(values[PHI] + turns, |motion| motion.angle(d.time));
    if let Some(motor) = d.motor() {
        values[ROTOR] += motor.transmission.ratio * turns;
    }
    values[SATURATED] = f64::from(d.run.modes.saturation != 0);
    let mut statistics = d.statistics();
    statistics[0] = d.run.steps;
    statistics[1] = d.run.steps * d.run.terms();
    statistics[2] = (d.run.error + d.run.ahead).min(1.0);
    values[STATISTICS..][..3].copy_from_slice(&statistics);
    [values[PERIOD], values[MULTIPLIER]] = d.run.period;
    for (j, follower) in d.train.followers.iter().enumerate() {
        if let Joint::Shaft(_) = follower.joint {
            values[place(j, Of::Psi)] += values[PHI] - d.reduced();
        }
        if let Joint::Backlash(_) = follower.joint {
            let tally = &d.run.tallies[j];
            let mode = match d.run.modes.contacts[j] {
                Mode::Contact(flank) => flank.sign(),
                Mode::Free => 0.0,
            };
            let mean = if d.step > 0.0 { d.run.sums(&d.train, d.time, j).map(|sum| sum / d.step) } else { [0.0; 2] };
            let rest = [(Of::Mode, mode), (Of::Impulse, tally.impulse), (Of::Impacts, tally.impacts)];
            let rest =
                rest.into_iter().chain([(Of::Loss, tally.loss), (Of::ForceMean, mean[0]), (Of::TauMean, mean[1])]);
            rest.for_each(|(of, value)| values[place(j, of)] = value);
            if let Some(loss) = d.run.damping_loss(&d.train, d.time, j) {
                values[place(j, Of::Damped)] = loss;
            }
        }
    }
}

pub(super) fn series(d: &DriveTrain, seed: Seed, which: usize) -> Series {
    let mut s = Series::from(0.0);
    outputs(d, &d.point_series(seed), |place, series| s = if place == which { series } else { s });
    s
}

/// The partial derivatives of the outputs.
pub(super) fn slopes(d: &DriveTrain, seed: Seed, mut put: impl FnMut(usize, f64)) {
    outputs(d, &d.point_series(seed), |place, series| put(place, series.0[1]));
}

impl DriveTrain {
    /// Tells when the cam of a follower begins to pull.
    pub(super) fn watch(&mut self) {
        let followers = &self.train.followers;
        let holds = |j: usize| !self.told[j] && [0.0, 1.0].iter().any(|y| followers[j].hold(*y) != 0.0);
        if !(0..followers.len()).any(holds) {
            return;
        }
        let mut values = [0.0; FOLLOWERS + EACH * MOST_FOLLOWERS];
        outputs(self, &self.point(), |at, value| values[at] = value);
        for j in 0..self.train.followers.len() {
            let forces = [self.train.followers[j].hold(values[place(j, Of::U)]), values[place(j, Of::Contact)]];
            tell_of_pull(&mut self.told[j], forces, self.time, j + 1, &mut self.log);
        }
    }

    /// φ of the communication point within its turn.
    fn reduced(&self) -> f64 {
        match &self.motion {
            Some(motion) => motion.at(self.time).reduced,
            None => self.states()[0],
        }
    }

    fn states(&self) -> [f64; MOST_STATES] {
        let mut y = [0.0; MOST_STATES];
        self.run.at(self.time, &mut y);
        y
    }

    fn point(&self) -> Point<f64> {
        let y = self.states();
        let given = self.given_now(&y);
        let phi = self.reduced();
        let angles = self.train.angles(Double::from(phi), &y);
        let f = Functions::at(&self.train, &self.run.modes, &angles);
        let w = if self.motion.is_some() { given.course[0] } else { y[1] };
        Point { phi, w, y, given, f }
    }

    /// What comes from outside now, where the signals stand.
    fn given_now(&self, y: &[f64]) -> Given<f64> {
        let given = self.given_series(y).0;
        let at = |s: Series| s.0[0];
        let Given { course, tau, torque, reference, lag, forces } = given;
        Given {
            course: course.map(at),
            tau: at(tau),
            torque: at(torque),
            reference: at(reference),
            lag: at(lag),
            forces: forces.map(at),
        }
    }

    /// The same as series in time, the lag of a position that is an input without the rotor's part.
    fn given_series(&self, y: &[f64]) -> (Given<Series>, f64) {
        let inputs = &self.inputs;
        let mut given = Given {
            course: [Series::from(0.0); 2],
            tau: inputs.loads.series(),
            torque: inputs.torque.series(),
            reference: Series::from(0.0),
            lag: Series::from(0.0),
            forces: [Series::from(0.0); MOST_FOLLOWERS],
        };
        if let Some(motion) = &self.motion {
            let [_, w, a, jerk, snap] = motion.at(self.time).kinematics.0;
            given.course = [Series::from_derivatives(w, a, jerk), Series::from_derivatives(a, jerk, snap)];
        }
        let mut ratio = 0.0;
        if let Some(motor) = self.motor() {
            if let Some(servo) = motor.servo() {
                let mut row = [0.0; 32];
                servo.expand_reference(self.time, 1.0, (&inputs.reference, inputs.reference.elapsed()), &mut row);
                given.reference = Series([row[0], row[1], row[2]]);
            }
            if motor.takes_position() {
                ratio = motor.transmission.ratio;
                let turns = ratio * self.run.turns * std::f64::consts::TAU;
                given.lag = inputs.position.series() - Series::from(turns + motor.angle(y[0], y, &self.train.layout));
            }
        }
        inputs.forces.iter().zip(&mut given.forces).for_each(|(signal, force)| *force = signal.series());
        (given, ratio)
    }

    /// The point as series: in time, or with respect to one known.
    fn point_series(&self, seed: Seed) -> Point<Series> {
        let now = self.point();
        let (given, ratio) = self.given_series(&now.y);
        let (phi, w) = (Series::from(now.phi), Series::from(now.w));
        let mut seeded = Seeded { phi, w, y: now.y.map(Series::from), given };
        if seed == Seed::Time {
            let Seeded { phi, w, y, given } = &mut seeded;
            self.run.series_at(self.time, y);
            if self.motion.is_some() {
                let [first, second] = [given.course[0].0[0], given.course[0].0[1]];
                *phi = Series([now.phi, first, 0.5 * second]);
                *w = given.course[0];
            } else {
                (*phi, *w) = (y[0], y[1]);
                let Series([_, rate, bend]) = *phi;
                given.lag = given.lag - Series([0.0, ratio * rate, ratio * bend]);
            }
        } else {
            self.seed_known(seed, &now, &mut seeded);
        }
        let Seeded { phi, w, y, given } = seeded;
        // The same numbers as without series, so that what cancels is zero.
        let numbers = self.train.angles(Double::from(now.phi), &now.y);
        let mut angles = numbers.map(|number| Series([number, phi.0[1], phi.0[2]]));
        for (j, follower) in self.train.followers.iter().enumerate() {
            if let Joint::Shaft(_) = follower.joint {
                let Series([_, rate, bend]) = y[self.train.layout.followers[j]];
                angles[1 + j] = angles[1 + j] + Series([0.0, rate, bend]);
            }
        }
        let f = Functions::at(&self.train, &self.run.modes, &angles);
        Point { phi, w, y, given, f }
    }

    /// One input or state moves, the others are held: of what is elastic its place y, so that q = y − U(φ) moves with φ.
    fn seed_known(&self, seed: Seed, now: &Point<f64>, seeded: &mut Seeded) {
        let Seeded { phi, w, y, given } = seeded;
        let value = |value: f64, slope: f64| Series([value, slope, 0.0]);
        let (turn, speed) = (seed.of("phi"), seed.of("w"));
        (*phi, *w) = (value(now.phi, turn), value(now.w, speed));
        given.course = [*w, value(now.given.course[1], seed.of("a"))];
        given.tau = value(now.given.tau, self.inputs.loads.seeded(seed)[0]);
        given.torque = value(now.given.torque, seed.of("M_an"));
        given.reference = value(now.given.reference, seed.of("w_ref"));
        if self.motion.is_none() {
            (y[0], y[1]) = (*phi, *w);
            let layout = &self.train.layout;
            if let Some(motor) = self.motor() {
                let names = [format!("motor.{}", motor.state_name()), "motor.phi".to_owned(), "motor.w".to_owned()];
                if motor.states() > 0 {
                    y[layout.motor] = value(now.y[layout.motor], seed.of(&names[0]));
                }
                let mut rotor = turn * motor.transmission.ratio;
                if motor.transmission.coupling.is_some() {
                    let i = motor.transmission.ratio;
                    rotor = seed.of(&names[1]);
                    y[layout.coupling] = value(now.y[layout.coupling], seed.of(&names[1]) / i - turn);
                    y[layout.coupling + 1] = value(now.y[layout.coupling + 1], seed.of(&names[2]) / i - speed);
                }
                given.lag = value(now.given.lag, seed.of("phi_ref") - rotor);
            }
        }
        for (j, follower) in self.train.followers.iter().enumerate() {
            let at = self.train.layout.followers[j];
            let own = |name: &str| seed.of(&format!("follower[{}].{name}", j + 1));
            let dot = |name: &str| seed.of(&format!("der(follower[{}].{name})", j + 1));
            given.forces[j] = value(now.given.forces[j], own("F"));
            let [_, u1, u2] = now.f.cams[j];
            let cam = [u1 * turn, u2 * now.w * turn + u1 * speed];
            let mut set = |at: usize, slope: [f64; 2]| {
                (y[at], y[at + 1]) = (value(now.y[at], slope[0]), value(now.y[at + 1], slope[1]));
            };
            match follower.joint {
                Joint::Rigid => {}
                Joint::Output(..) => set(at, [own("y") - cam[0], dot("y") - cam[1]]),
                Joint::Shaft(_) => set(at, [own("q"), dot("q")]),
                Joint::Backlash(p) => {
                    let free = self.run.modes.contacts[j] == Mode::Free;
                    let x1 = if free { [own("x1"), dot("x1")] } else { cam };
                    set(at, [x1[0] - cam[0], x1[1] - cam[1]]);
                    if p.m2 > 0.0 {
                        set(at + 2, [own("y") - x1[0], dot("y") - x1[1]]);
                    }
                }
            }
        }
    }

    /// The input with this number, beside those of a driven shaft, in the order of the value references.
    pub(super) fn signal_at(&mut self, number: usize) -> Option<&mut Signal> {
        let (machine, followers) = (self.train.machine(), &self.train.followers);
        let loads = self.inputs.loads.inputs().count();
        if number < loads {
            let at = self.inputs.loads.inputs().nth(number)?;
            return self.inputs.loads.signal_mut(at);
        }
        let takes = [
            machine.is_some_and(|m| m.motor.takes_torque()),
            machine.is_some_and(|m| m.motor.takes_speed()),
            machine.is_some_and(|m| m.motor.takes_position()),
        ];
        let takes = takes.into_iter().chain(followers.iter().map(|follower| follower.load.input));
        let mut all = self.inputs.beside_loads().zip(takes).filter(|(_, takes)| *takes).map(|(signal, _)| signal);
        all.nth(number - loads)
    }

    /// The list of variables. The elements of an array follow one another (FMI 2.0, section 2.2.9): all of a follower, then the
    /// derivatives of all followers.
    pub(super) fn declare(&self, mut dependencies: Dependencies) -> List<Self> {
        let mut list = List::default();
        for j in 1..=self.train.followers.len() {
            let of_j = |key: &&str| format!("follower[{j}].{key}");
            dependencies.parameters.extend(PARAMETERS_OF_FOLLOWER.iter().map(of_j));
        }
        self.declare_inputs(&mut list);
        self.declare_shaft(&mut list, &dependencies);
        self.declare_parameters(&mut list);
        for (j, follower) in self.train.followers.iter().enumerate() {
            declare_force(&mut list, self, 2 * j, &format!("follower[{}].F", j + 1), follower.rigid.turns);
            self.declare_follower(&mut list, j, &dependencies);
            self.declare_parameters_of(&mut list, j, follower);
        }
        let names = ["x1", "y", "q"];
        for (order, places) in [(1, [Of::X1Dot, Of::YDot, Of::QDot]), (2, [Of::X1DotDot, Of::YDotDot, Of::QDotDot])] {
            for (j, follower) in self.train.followers.iter().enumerate() {
                for (name, of) in names.into_iter().zip(places) {
                    let Some((quantities, state)) = of_follower(follower, name) else { continue };
                    let of_j = format!("follower[{}].{name}", j + 1);
                    let (name, what) = match order {
                        1 => (format!("der({of_j})"), "Velocity"),
                        _ => (format!("der({of_j},2)"), "Acceleration"),
                    };
                    let variable = list.output(&name, &format!("{what} of {of_j}"), real(quantities[order]), series);
                    dependencies.declare(variable, place(j, of));
                    if order == 1 && state {
                        variable.state();
                    }
                }
            }
        }
        self.declare_levers(&mut list, &dependencies);
        self.declare_solver(&mut list, STATISTICS);
        for (name, text, quantity, at) in [
            ("start.period", "Period of the steady state found at the start; 0 without one", &unit::TIME, PERIOD),
            ("start.multiplier", "Largest magnitude of its multipliers, below 1: stable", &unit::NUMBER, MULTIPLIER),
        ] {
            list.local(name, text, real(quantity)).at(at);
        }
        self.rename(&mut list);
        list
    }

    fn declare_inputs(&self, list: &mut List<Self>) {
        let set = |d: &mut Self, i: usize, order: usize, value| d.course.set_input_derivative(i, order, value);
        declare_inputs(list, self.course.inputs(), |d, i| d.course.input(i), set);
        macro_rules! input {
            ($if:expr, $name:literal, $text:literal, $quantity:expr, $signal:ident) => {
                if $if {
                    let set = |d: &mut Self, _: usize, order, value| d.inputs.$signal.set_derivative(order, value);
                    list.input($name, $text, real($quantity), |d, _| d.inputs.$signal.set_value(), set);
                }
            };
        }
        if let Some(machine) = self.train.machine() {
            let set = |d: &mut Self, at: usize, order: usize, value| {
                d.inputs.loads.signal_mut(at).into_iter().for_each(|signal| signal.set_derivative(order, value));
            };
            let get = |d: &Self, at: usize| d.inputs.loads.signal(at).map_or(0.0, Signal::set_value);
            declare_loads(list, &self.inputs.loads, get, set);
            input!(
                machine.motor.takes_torque(),
                "M_an",
                "Torque of the rotor; positive accelerates",
                &unit::TORQUE,
                torque
            );
            input!(
                machine.motor.takes_speed(),
                "w_ref",
                "Speed that the rotor is to keep",
                &unit::ANGULAR_VELOCITY,
                reference
            );
            input!(
                machine.motor.takes_position(),
                "phi_ref",
                "Angle that the rotor is to keep",
                &unit::ANGLE,
                position
            );
        }
    }

    fn declare_shaft(&self, list: &mut List<Self>, dependencies: &Dependencies) {
        let free = self.train.machine().is_some();
        let mut output = |name: &str, text: &str, quantity, at: usize, state: bool| {
            let variable = list.output(name, text, real(quantity), series);
            dependencies.declare(variable, at);
            if state {
                variable.state();
            }
        };
        let integrates = self.course.integrates();
        if integrates || !self.motion_is_input() {
            let name = if integrates { "der(phi)" } else { "w" };
            output("phi", "Angle of the shaft", &unit::ANGLE, PHI, free || integrates);
            output(name, "Angular velocity of the shaft", &unit::ANGULAR_VELOCITY, W, free);
        }
        if let Some(machine) = self.train.machine() {
            output("a", "Angular acceleration of the shaft", &unit::ANGULAR_ACCELERATION, A, false);
            let motor = &machine.motor;
            let text = "Torque of the motor on the shaft; positive accelerates";
            match (motor.takes_torque(), motor.transmission.coupling) {
                (true, None) => {}
                (true, Some(_)) => output("motor.tau", text, &unit::TORQUE, TORQUE, false),
                (false, _) => output("M_an", text, &unit::TORQUE, TORQUE, false),
            }
            output("J", "Inertia that follows the shaft without slip", &unit::INERTIA, INERTIA, false);
            output("E", "Kinetic energy J w^2 / 2", &unit::ENERGY, ENERGY, false);
            if motor.transmission.coupling.is_some() {
                let quantities = [&unit::ANGLE, &unit::ANGULAR_VELOCITY, &unit::ANGULAR_ACCELERATION];
                output("motor.phi", "Angle of the rotor", quantities[0], ROTOR, true);
                output("motor.w", "Angular velocity of the rotor", quantities[1], ROTOR_SPEED, true);
                output("motor.a", "Angular acceleration of the rotor", quantities[2], ROTOR_ACCELERATION, false);
            }
            if motor.states() > 0 {
                let name = format!("motor.{}", motor.state_name());
                let text = if motor.servo().is_some() { "Integrator of the servo" } else { "Torque of the rotor" };
                output(&name, text, &unit::TORQUE, STATE, true);
                output(&format!("der({name})"), "Its rate", &TORQUE_RATE, STATE_RATE, false);
            }
            if motor.servo().is_some() {
                let text = "Torque that the servo demands, before its limit";
                output("motor.u", text, &unit::TORQUE, DEMAND, false);
                let text = "Whether the torque of the servo is at its limit";
                let variable = list.discrete_output("motor.saturated", text, Kind::Boolean);
                dependencies.declare(variable, SATURATED);
                let names = self.input_names();
                let of_motor: Vec<&str> =
                    names.iter().map(String::as_str).filter(|name| name.ends_with("_ref")).collect();
                if !of_motor.is_empty() {
                    variable.depends(&of_motor).slopes(series);
                }
            }
        }
        for (i, (name, text, quantity)) in COUPLING.into_iter().enumerate().filter(|_| self.coupling) {
            let variable = list.output(name, text, real(quantity), series);
            dependencies.declare(variable, COUPLED + i);
        }
        for description in list.0.iter_mut().map(|variable| &mut variable.description) {
            let of = match description.name.as_str() {
                "w" if free => "phi",
                "a" if free => "w",
                "motor.w" => "motor.phi",
                "motor.a" => "motor.w",
                _ => continue,
            };
            description.derivative_of = Some(of.to_owned());
        }
    }

    fn declare_follower(&self, list: &mut List<Self>, j: usize, dependencies: &Dependencies) {
        let follower = &self.train.followers[j];
        let (n, turns) = (j + 1, follower.rigid.turns);
        let force = if turns { &unit::TORQUE } else { &unit::FORCE };
        let clearance = if let Joint::Backlash(p) = follower.joint { Some(p) } else { None };
        let length = if turns { &unit::ANGLE } else { &unit::LENGTH };
        let mut output = |name: &str, text: &str, quantity, of: Of| {
            let variable = list.output(&format!("follower[{n}].{name}"), text, real(quantity), series);
            dependencies.declare(variable, place(j, of));
            if of_follower(follower, name).is_some_and(|(_, state)| state) {
                variable.state();
            }
        };
        output("U", "Position function of the cam, or of the tool behind mechanisms", length, Of::U);
        if clearance.is_some() {
            output("x1", "Place of the mass at the cam", length, Of::X1);
            output("gap", "Distance of the mass at the cam from flank A", length, Of::Gap);
        }
        output("y", "Place of the tool", length, Of::Y);
        if let Some((quantities, _)) = of_follower(follower, "q") {
            output("q", "Deformation of the spring", quantities[0], Of::Q);
        }
        if let Joint::Shaft(_) = follower.joint {
            output("psi", "Angle of the cam behind the elastic shaft", &unit::ANGLE, Of::Psi);
        }
        let of_cam = "Force of the cam on the follower, positive in the sense of y";
        if let Joint::Output(..) = follower.joint {
            let text = "Force of the spring on the tool, -(c q + b der(q)), positive in the sense of y";
            output("force", text, force, Of::Force);
            output("contact_force", of_cam, force, Of::Contact);
        } else {
            output("force", of_cam, force, Of::Force);
        }
        output("tau", "Torque from the shaft into the follower; positive loads the drive", &unit::TORQUE, Of::Tau);
        let Some(p) = clearance else { return };
        let two = p.s.is_finite();
        let kind = Kind::Integer { min: if two { -1 } else { 0 }, max: 1 };
        let text = if two { "1 on flank A, 0 in flight, -1 on flank B" } else { "1 on the cam, 0 in flight" };
        let inputs = self.course.known();
        let names = self.input_names();
        let all: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut discrete = |name: &str, text: &str, kind: Kind, of: Of| {
            let variable = list.discrete_output(&format!("follower[{n}].{name}"), text, kind);
            dependencies.declare(variable, place(j, of));
            // A jump of the inputs may open a contact, or close one.
            if !inputs.is_empty() && !matches!(of, Of::ForceMean | Of::TauMean) {
                variable.depends(if matches!(of, Of::Impulse) { &inputs[..2] } else { inputs }).slopes(series);
            }
            // So may one of a force or a torque.
            if matches!(of, Of::Mode) && !all.is_empty() {
                variable.depends(&all).slopes(series);
            }
        };
        let count = Kind::Integer { min: 0, max: i32::MAX };
        discrete("contact", text, kind, Of::Mode);
        discrete("impulse", "Sum of the impulses of the cam since the start", real(&unit::IMPULSE), Of::Impulse);
        discrete("impacts", "Impacts since the start", count, Of::Impacts);
        discrete("energy_loss", "Energy lost in impacts since the start", real(&unit::ENERGY), Of::Loss);
        if let Names::Backlash(_) = self.names {
            let text = "Mean force of the drive on m1 over the last communication step, impulses included";
            discrete("force_mean", text, real(force), Of::ForceMean);
        }
        let text = "Mean torque of the follower on the drive over the last communication step, impulses included";
        discrete("tau_mean", text, real(&unit::TORQUE), Of::TauMean);
        if let (Names::Backlash(_), true) = (self.names, p.m2 > 0.0) {
            let name = format!("follower[{n}].damping_loss");
            list.local(&name, "Energy dissipated by the damper", real(&unit::ENERGY)).at(place(j, Of::Damped));
        }
    }

    fn declare_parameters(&self, list: &mut List<Self>) {
        if let Some(machine) = self.train.machine() {
            list.group::<InertiaFunction>();
            if machine.friction.is_some() {
                let kind = real_within(&unit::ROTATIONAL_DAMPING, 0.0, 1e12);
                number!(list, "load.b", "Viscous friction of the shaft", kind, Tunable, friction, friction_mut, b => *b);
            }
            self.declare_source(list, &machine.motor.source);
            self.declare_transmission(list, &machine.motor.transmission);
            let angle = real_within(&unit::ANGLE, -LARGEST_ANGLE, LARGEST_ANGLE);
            number!(list, "phi_start", "Angle at the start", angle, Fixed, machine, machine_mut, m => m.phi_start);
            let speed = real_within(&unit::ANGULAR_VELOCITY, -FASTEST, FASTEST);
            number!(list, "w_start", "Angular velocity at the start", speed, Fixed, machine, machine_mut, m => m.w_start);
            declare_law(list, self, INERTIA_LAW, "inertia");
            declare_law(list, self, LOAD_LAW, "load.M");
        } else {
            let set =
                |d: &mut Self, i: usize, value| d.course.mode.parameter_mut(i).into_iter().for_each(|p| *p = value);
            declare_parameters(list, &self.course.mode, |d, i| d.course.mode.parameter(i).unwrap_or(0.0), set);
        }
        self.declare_start(list);
    }

    fn declare_source(&self, list: &mut List<Self>, source: &Source) {
        match source {
            Source::Kloss(kloss) => {
                list.group::<Kloss>();
                if kloss.dynamics.is_some() {
                    let kind = real_within(&unit::TIME, LAG[0], LAG[1]);
                    number!(list, "motor.T_el", "Electrical time constant", kind, Fixed, lag, lag_mut, lag => *lag);
                }
            }
            Source::Constant(_) => {
                let kind = real_within(&unit::TORQUE, -1e12, 1e12);
                number!(list, "motor.torque", "Torque of the rotor", kind, Tunable, constant, constant_mut, torque => *torque);
            }
            Source::Servo(servo) => {
                let gain = |quantity| real_within(quantity, 0.0, 1e12);
                let torque = real_within(&unit::TORQUE, 0.0, 1e12);
                number!(list, "motor.K_p", "Gain of the speed control", gain(&unit::ROTATIONAL_DAMPING), Tunable, servo, servo_mut, s => s.proportional);
                number!(list, "motor.K_i", "Integral gain", gain(&unit::ROTATIONAL_STIFFNESS), Tunable, servo, servo_mut, s => s.integral);
                number!(list, "motor.K_aw", "Gain of the back-calculation", gain(&unit::RATE), Tunable, servo, servo_mut, s => s.anti_windup);
                number!(list, "motor.M_max", "Limit of the torque", torque, Tunable, servo, servo_mut, s => s.limit);
                match servo.reference {
                    Reference::Constant(_) => {
                        let kind = real_within(&unit::ANGULAR_VELOCITY, -FASTEST, FASTEST);
                        number!(list, "motor.w_ref", "Speed that the rotor is to keep", kind, Tunable, reference, reference_mut, w => *w);
                    }
                    Reference::Ramp(_) => {
                        let kind = real_within(&unit::ANGULAR_ACCELERATION, -1e12, 1e12);
                        number!(list, "motor.ramp", "Rise from rest of the speed that the rotor is to keep", kind, Fixed, reference, reference_mut, w => *w);
                    }
                    Reference::Series(..) | Reference::Input => {}
                }
                if servo.position.is_some() {
                    number!(list, "motor.K_v", "Gain of the position loop", gain(&unit::RATE), Tunable, position, position_mut, k => *k);
                }
            }
            _ => {}
        }
    }

    fn declare_transmission(&self, list: &mut List<Self>, t: &Transmission) {
        if t.ratio != 1.0 {
            number!(list, "motor.i", "Speed of the rotor over that of the shaft, not 0", real_within(&unit::NUMBER, -1e6, 1e6), Fixed, motor, motor_mut, m => m.transmission.ratio);
        }
        if t.rotor > 0.0 {
            number!(list, "motor.J", "Moment of inertia of the rotor", real_within(&unit::INERTIA, 0.0, 1e12), Fixed, motor, motor_mut, m => m.transmission.rotor);
        }
        if t.coupling.is_some() {
            let kind = real_within(&unit::ROTATIONAL_STIFFNESS, 1e-12, 1e15);
            number!(list, "motor.c", "Stiffness of the coupling at the shaft", kind, Tunable, coupling, coupling_mut, c => c[0]);
            let kind = real_within(&unit::ROTATIONAL_DAMPING, 0.0, 1e12);
            number!(list, "motor.b", "Damping of the coupling at the shaft", kind, Tunable, coupling, coupling_mut, c => c[1]);
        }
    }

    fn declare_parameters_of(&self, list: &mut List<Self>, j: usize, follower: &Follower) {
        {
            let name = format!("follower[{}]", j + 1);
            match follower.joint {
                Joint::Rigid => {
                    let mass = crate::drives::follower::linkage::Parameter::mass(follower.rigid.turns);
                    let [least, greatest] = mass.kind.range();
                    list.parameter(
                        &format!("{name}.{}", mass.key),
                        &mass.text(),
                        real_within(mass.kind.quantity(), least, greatest),
                        |d, j| d.train.followers[j].rigid.m,
                        |d, j, value| d.train.followers[j].rigid.m = value,
                    )
                    .at(j);
                }
                Joint::Output(_, m_x) => {
                    declare_joint::<elastic_output::Parameters>(list, j, |_| true);
                    if m_x > 0.0 {
                        list.parameter(
                            &format!("{name}.m_roller"),
                            "Mass on the cam's side of the spring",
                            real_within(&unit::MASS, 0.0, 1e12),
                            |d, j| if let Joint::Output(_, m_x) = d.train.followers[j].joint { m_x } else { 0.0 },
                            |d, j, value| {
                                if let Joint::Output(_, m_x) = &mut d.train.followers[j].joint {
                                    *m_x = value;
                                }
                            },
                        )
                        .at(j);
                    }
                }
                Joint::Shaft(_) => declare_joint::<elastic_shaft::Parameters>(list, j, |_| true),
                Joint::Backlash(p) => declare_joint::<contact::Parameters>(list, j, |key| match key {
                    "s" => p.s.is_finite(),
                    "m2" | "c" | "b" => p.m2 > 0.0,
                    _ => true,
                }),
            }
            for (which, part) in ["load", "load.roller"].into_iter().enumerate() {
                declare_load(list, self, 2 * j + which, &format!("{name}.{part}"), follower.rigid.turns);
            }
            declare_law(list, self, j, &format!("{name}.{}", follower.rigid.mover()));
            declare_mechanisms(list, self, j);
        }
    }
}

/// Place, velocity and acceleration by name, `x1`, `y` or `q`, where the follower has it, and whether it is a state.
fn of_follower(follower: &Follower, name: &str) -> Option<([&'static Quantity; 3], bool)> {
    let angles = [&unit::ANGLE, &unit::ANGULAR_VELOCITY, &unit::ANGULAR_ACCELERATION];
    let lengths = [&unit::LENGTH, &unit::VELOCITY, &unit::ACCELERATION];
    let shaft = matches!(follower.joint, Joint::Shaft(_));
    let quantities = if follower.rigid.turns || shaft && name == "q" { angles } else { lengths };
    let (clearance, behind) = match follower.joint {
        Joint::Backlash(p) => (true, p.m2 > 0.0),
        joint => (false, matches!(joint, Joint::Output(..))),
    };
    match name {
        "x1" => clearance.then_some((quantities, true)),
        "y" => Some((quantities, behind)),
        "q" => (behind || shaft).then_some((quantities, shaft)),
        _ => None,
    }
}

/// The names of the inputs and states that the outputs, by place, depend on at communication points, and of the inputs at the
/// start.
#[derive(Default)]
pub struct Dependencies {
    /// At communication points.
    pub running: Vec<Vec<String>>,
    /// At the start.
    pub initial: Vec<Vec<String>>,
    /// The parameters of the followers.
    pub parameters: Vec<String>,
}

impl Dependencies {
    /// Takes the place of an output and what it depends on.
    pub fn declare(&self, variable: &mut Variable<DriveTrain>, place: usize) {
        let [running, initial, followers] = [&self.running[place], &self.initial[place], &self.parameters]
            .map(|list| list.iter().map(String::as_str).collect::<Vec<_>>());
        variable.at(place).depends(&running).depends_initially(&[&initial, PARAMETERS, &followers]);
    }
}

/// The parameters of a joint.
trait OfJoint: Parameters {
    fn of(joint: &Joint) -> Option<&Self>;
    fn of_mut(joint: &mut Joint) -> Option<&mut Self>;
}

macro_rules! of_joint {
    ($parameters:ty, $pattern:pat => $found:ident) => {
        impl OfJoint for $parameters {
            fn of(joint: &Joint) -> Option<&Self> {
                if let $pattern = joint { Some($found) } else { None }
            }
            fn of_mut(joint: &mut Joint) -> Option<&mut Self> {
                if let $pattern = joint { Some($found) } else { None }
            }
        }
    };
}

of_joint!(elastic_output::Parameters, Joint::Output(p, _) => p);
of_joint!(elastic_shaft::Parameters, Joint::Shaft(p) => p);
of_joint!(contact::Parameters, Joint::Backlash(p) => p);

/// Declares the parameters of the joint of follower j, as the single model has them.
fn declare_joint<P: OfJoint>(list: &mut List<DriveTrain>, j: usize, wanted: impl Fn(&str) -> bool) {
    for (i, p) in P::TABLE.iter().enumerate().filter(|(_, p)| wanted(p.key)) {
        let declared = list.parameter(
            &format!("follower[{}].{}", j + 1, p.name),
            p.text.trim_start(),
            real_within(p.quantity, p.range[0], p.range[1]),
            |d, index| P::of(&d.train.followers[index & 0xff].joint).map_or(0.0, P::TABLE[index >> 8].get),
            |d, index, value| {
                d.retune();
                P::of_mut(&mut d.train.followers[index & 0xff].joint)
                    .into_iter()
                    .for_each(|group| (P::TABLE[index >> 8].set)(group, value));
            },
        );
        declared.key(&format!("follower[{}].{}.{}", j + 1, P::SECTION, p.key));
        declared.at(i << 8 | j).description.variability = p.variability;
        if let Some(nominal) = p.nominal {
            declared.nominal(nominal);
        }
    }
}

/// Accessors of parts that a train may have.
macro_rules! part {
    ($name:ident, $name_mut:ident: $type:ty, $machine:ident => $found:expr, $found_mut:expr) => {
        pub(super) fn $name(&self) -> Option<&$type> {
            let $machine = self.train.machine()?;
            $found
        }
        fn $name_mut(&mut self) -> Option<&mut $type> {
            let $machine = self.train.machine_mut()?;
            $found_mut
        }
    };
}

impl DriveTrain {
    part!(machine, machine_mut: super::Machine, m => Some(m), Some(m));
    part!(motor, motor_mut: crate::drives::shaft::motor::Motor, m => Some(&m.motor), Some(&mut m.motor));
    part!(friction, friction_mut: f64, m => m.friction.as_ref(), m.friction.as_mut());
    part!(coupling, coupling_mut: [f64; 2], m => m.motor.transmission.coupling.as_ref(), m.motor.transmission.coupling.as_mut());
    part!(servo, servo_mut: Servo, m => m.motor.servo(), if let Source::Servo(servo) = &mut m.motor.source { Some(servo) } else { None });
    part!(position, position_mut: f64, m => m.motor.servo()?.position.as_ref(), if let Source::Servo(servo) = &mut m.motor.source { servo.position.as_mut() } else { None });
    part!(reference, reference_mut: f64, m => if let Reference::Constant(w) | Reference::Ramp(w) = &m.motor.servo()?.reference { Some(w) } else { None }, if let Source::Servo(servo) = &mut m.motor.source { if let Reference::Constant(w) | Reference::Ramp(w) = &mut servo.reference { Some(w) } else { None } } else { None });
    part!(lag, lag_mut: f64, m => if let Source::Kloss(k) = &m.motor.source { k.dynamics.as_ref() } else { None }, if let Source::Kloss(k) = &mut m.motor.source { k.dynamics.as_mut() } else { None });
    part!(constant, constant_mut: f64, m => if let Source::Constant(t) = &m.motor.source { Some(t) } else { None }, if let Source::Constant(t) = &mut m.motor.source { Some(t) } else { None });
    part!(kloss, kloss_mut: Kloss, m => if let Source::Kloss(k) = &m.motor.source { Some(k) } else { None }, if let Source::Kloss(k) = &mut m.motor.source { Some(k) } else { None });
}

impl HasLaws for DriveTrain {
    fn law(&self, number: usize) -> Option<&MotionLaw> {
        match number {
            INERTIA_LAW => self.machine()?.inertia.varying.as_ref(),
            LOAD_LAW => self.machine()?.load.as_ref(),
            j => self.follower(j).map(|follower| &follower.cam),
        }
    }
    fn change_law(&mut self, number: usize, change: impl FnMut(&mut MotionLaw)) {
        self.retune();
        let law = match number {
            INERTIA_LAW => self.machine_mut().and_then(|machine| machine.inertia.varying.as_mut()),
            LOAD_LAW => self.machine_mut().and_then(|machine| machine.load.as_mut()),
            j => self.train.followers.get_mut(j).map(|follower| &mut follower.rigid.cam),
        };
        law.into_iter().for_each(change);
    }
    fn follower(&self, number: usize) -> Option<&rigid::Follower> {
        self.train.followers.get(number).map(|follower| &follower.rigid)
    }
    fn change_follower(&mut self, number: usize, mut change: impl FnMut(&mut rigid::Follower)) {
        self.train.followers.get_mut(number).into_iter().for_each(|follower| change(&mut follower.rigid));
    }
}

impl Has<InertiaFunction> for DriveTrain {
    fn group(&self) -> Option<&InertiaFunction> {
        self.machine().map(|machine| &machine.inertia)
    }
    fn group_mut(&mut self) -> Option<&mut InertiaFunction> {
        self.retune();
        self.machine_mut().map(|machine| &mut machine.inertia)
    }
}

impl Has<Kloss> for DriveTrain {
    fn group(&self) -> Option<&Kloss> {
        self.kloss()
    }
    fn group_mut(&mut self) -> Option<&mut Kloss> {
        self.retune();
        self.kloss_mut()
    }
}

impl HasLoads for DriveTrain {
    fn load(&self, which: usize) -> Option<&Load> {
        let follower = self.train.followers.get(which / 2)?;
        Some(if which.is_multiple_of(2) { &follower.load } else { &follower.roller })
    }
    fn load_mut(&mut self, which: usize) -> Option<&mut Load> {
        self.retune();
        let follower = self.train.followers.get_mut(which / 2)?;
        Some(if which.is_multiple_of(2) { &mut follower.load } else { &mut follower.roller })
    }
    fn signal(&self, which: usize) -> Option<&Signal> {
        self.inputs.forces.get(which / 2)
    }
    fn signal_mut(&mut self, which: usize) -> Option<&mut Signal> {
        self.inputs.forces.get_mut(which / 2)
    }
}
