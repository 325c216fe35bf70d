//! The variables of the train and its output equations.

use super::{DriveTrain, Joint, MOST_FOLLOWERS, Machine};
use crate::drives::follower::joint::{Counts, Now, Put, Seat};
use crate::drives::follower::linkage::Parameter;
use crate::drives::follower::load::Load;
use crate::drives::follower::rigid;
use crate::drives::limits::{FASTEST, LARGEST_ANGLE};
use crate::drives::parameter::{self, Has, Number, parameters};
use crate::drives::settings::HasSolver;
use crate::drives::shaft::cam_drive::{declare_inputs, declare_parameters};
use crate::drives::shaft::free::coupled::{COUPLING, declare_loads};
use crate::drives::shaft::free::inertia::InertiaFunction;
use crate::drives::shaft::free::motor::{Kloss, LAG};
use crate::drives::shaft::free::signal::Signal;
use crate::drives::shaft::laws::{HasLaws, INERTIA_LAW, LOAD_LAW, declare_law, declare_mechanisms};
use crate::drives::shaft::loads::{HasLoads, declare_force, declare_load, log_pull};
use crate::drives::shaft::motor::{Motor, Reference, Servo, Source, Transmission};
use crate::drives::shaft::train::{self, Dynamics, Functions, InputValues, MOST_STATES};
use crate::drives::unit::{self, Quantity};
use crate::drives::variable::{Get, Output, Role, Set, Variability, real, real_within};
use crate::drives::{List, Seed, Variable};
use crate::motion::MotionLaw;
use crate::numerics::double_double::Double;
use crate::numerics::taylor::{Scalar, Series};
use std::f64::consts::TAU;
use std::ops::Range;

/// Rate of a torque (N·m/s).
static TORQUE_RATE: Quantity = Quantity { name: "TorqueRate", unit: "N.m/s", base: [1, 2, -3, 0], display: None };

/// Places of the solver's statistics, of the period and its multiplier, of the first output.
const STATISTICS: usize = 0;
const PERIOD: usize = 3;
const MULTIPLIER: usize = 4;
pub(super) const FIRST: usize = 5;

/// Whether the servo is at its limit; its demand comes before.
pub(super) const SATURATED: &str = "motor.saturated";

/// The parameters that the start depends on in addition to its inputs.
const PARAMETERS: &[&str] = &["J0", "inertia", "load", "motor", "drive", "start", "phi_start", "w_start"];

/// The same for each follower.
const PARAMETERS_OF_FOLLOWER: &[&str] =
    &["m", "J", "c", "b", "m1", "m2", "s", "e", "m_roller", "load", "cam", "crank", "linkage"];

/// The dependencies of the outputs, by place.
pub(super) struct Dependencies {
    /// The inputs by name, those of a driven shaft first.
    pub inputs: Vec<String>,
    /// The inputs and states at communication points.
    pub running: Vec<Vec<String>>,
    /// The inputs at the start.
    pub initial: Vec<Vec<String>>,
}

impl Dependencies {
    /// Declares the dependencies of the output in this place.
    fn declare(&self, d: &DriveTrain, variable: &mut Variable<DriveTrain>, place: usize) {
        let own = |j: usize| PARAMETERS_OF_FOLLOWER.iter().map(move |key| d.names.of(j, key));
        let followers: Vec<String> = (0..d.train.followers.len()).flat_map(own).collect();
        let [running, initial, followers] = [&self.running[place], &self.initial[place], &followers]
            .map(|list| list.iter().map(String::as_str).collect::<Vec<_>>());
        variable.depends(&running).depends_initially(&[&initial, PARAMETERS, &followers]);
    }
}

/// The train at an instant, in numbers or series.
pub(super) struct Point<S> {
    pub phi: S,
    pub w: S,
    pub y: [S; MOST_STATES],
    pub input_values: InputValues<S>,
    pub f: Functions<S>,
    /// φ with its turns, and the turns (rad).
    pub whole: S,
    pub turns: f64,
    /// Whether the followers' counts are wanted.
    pub counted: bool,
}

/// Motion and inputs as series, without the functions of the angle.
struct Seeds {
    phi: Series,
    w: Series,
    y: [Series; MOST_STATES],
    input_values: InputValues<Series>,
}

/// An output of the shaft, or of follower j.
pub(super) struct Row {
    pub output: Output,
    pub follower: Option<usize>,
}

/// Passes on the outputs, of numbers or of series, to `take`, each with its place and its follower.
fn outputs<S: Scalar>(d: &DriveTrain, p: &Point<S>, take: &mut dyn FnMut(Seat, &Output, S)) {
    let Point { y, input_values, f, .. } = p;
    let motion = d.train.dynamics(&train::Point { modes: &d.run.modes, y, f, input_values });
    outputs_of(d, p, &motion, take);
}

/// The same for this motion.
pub(super) fn outputs_of<S: Scalar>(
    d: &DriveTrain,
    p: &Point<S>,
    motion: &Dynamics<S>,
    take: &mut dyn FnMut(Seat, &Output, S),
) {
    let Point { phi, w, y, input_values, f, whole, .. } = p;
    let point = train::Point { modes: &d.run.modes, y, f, input_values };
    let mut put = Put { seat: Seat { place: FIRST, follower: None }, take };
    shaft(d, p, motion, &mut put);
    let (phi, whole, a, driven) = (*phi, *whole, motion.a, d.motion_is_input());
    for (j, follower) in d.train.followers.iter().enumerate() {
        let counted = p.counted && follower.joint.clearance().is_some();
        let counts = if counted { d.counts(j) } else { Counts::default() };
        let (at, spring) = (d.train.follower(j, &point, *w), motion.spring[j]);
        let now = Now { at, phi, whole, a, spring, motion: &motion.followers[j], counts, driven };
        put.seat.follower = Some(j);
        follower.joint.outputs(&now, &mut put);
    }
}

/// The outputs of the shaft and its motor.
fn shaft<S: Scalar>(d: &DriveTrain, p: &Point<S>, motion: &Dynamics<S>, put: &mut Put<S>) {
    let (Point { phi, w, y, f, .. }, layout) = (p, &d.train.layout);
    let (free, integrates) = (d.machine().is_some(), d.shaft.integrates());
    if integrates || !d.motion_is_input() {
        put.give(&Output::new("phi", "Angle of the shaft", &unit::ANGLE).state(free || integrates), p.whole);
        let name = if integrates { "der(phi)" } else { "w" };
        put.give(&Output::new(name, "Angular velocity of the shaft", &unit::ANGULAR_VELOCITY).state(free), *w);
    }
    if let Some(motor) = d.motor() {
        put.give(&Output::new("a", "Angular acceleration of the shaft", &unit::ANGULAR_ACCELERATION), motion.a);
        let name = if motor.takes_torque() { "motor.tau" } else { "M_an" };
        let coupled = motor.transmission.coupling.is_some();
        if coupled || !motor.takes_torque() {
            let text = "Torque of the motor on the shaft; positive accelerates";
            put.give(&Output::new(name, text, &unit::TORQUE), motion.torque);
        }
        put.give(&Output::new("J", "Inertia that follows the shaft without slip", &unit::INERTIA), f.inertia);
        put.give(&Output::new("E", "Kinetic energy J w^2 / 2", &unit::ENERGY), f.inertia * *w * *w * 0.5);
        if coupled {
            let angle = motor.angle(*phi, y, layout) + S::from(motor.transmission.ratio * p.turns);
            put.give(&Output::new("motor.phi", "Angle of the rotor", &unit::ANGLE).state(true), angle);
            let speed = Output::new("motor.w", "Angular velocity of the rotor", &unit::ANGULAR_VELOCITY).state(true);
            put.give(&speed, motor.speed(y, layout));
            let a = Output::new("motor.a", "Angular acceleration of the rotor", &unit::ANGULAR_ACCELERATION);
            put.give(&a, motion.rotor);
        }
        let servo = motor.servo().is_some();
        if motor.states() > 0 {
            let [name, rate] = if servo { ["motor.I", "der(motor.I)"] } else { ["motor.M", "der(motor.M)"] };
            let text = if servo { "Integrator of the servo" } else { "Torque of the rotor" };
            put.give(&Output::new(name, text, &unit::TORQUE).state(true), y[layout.motor]);
            put.give(&Output::new(rate, "Its rate", &TORQUE_RATE), motion.rates[layout.motor]);
        }
        if servo {
            let text = "Torque that the servo demands, before its limit";
            put.give(&Output::new("motor.u", text, &unit::TORQUE), motion.demand);
            let text = "Whether the torque of the servo is at its limit";
            let saturated = f64::from(d.run.modes.saturation != 0);
            put.give(&Output::new(SATURATED, text, &unit::NUMBER).role(Role::Flag), S::from(saturated));
        }
    }
    if d.coupling {
        let point = train::Point { modes: &d.run.modes, y, f, input_values: &p.input_values };
        let rest = d.train.reactions(&point, *w, &motion.spring);
        let values = [f.inertia, f.half_slope * 2.0, rest];
        for ((name, text, quantity), value) in COUPLING.into_iter().zip(values) {
            put.give(&Output::new(name, text, quantity), value);
        }
    }
}

pub(super) fn evaluate(d: &DriveTrain, values: &mut [f64]) {
    let mut point = d.point();
    point.counted = true;
    outputs(d, &point, &mut |seat, _, value| {
        if let Some(into) = values.get_mut(seat.place) {
            *into = value;
        }
    });
    let mut statistics = d.statistics();
    statistics[0] = d.run.steps;
    statistics[1] = d.run.steps * d.run.terms();
    statistics[2] = (d.run.error + d.run.ahead).min(1.0);
    values[STATISTICS..][..3].copy_from_slice(&statistics);
    [values[PERIOD], values[MULTIPLIER]] = d.run.period;
}

pub(super) fn series(d: &DriveTrain, seed: Seed, which: usize) -> Series {
    let mut s = Series::from(0.0);
    outputs(d, &d.point_series(seed), &mut |seat, _, series| s = if seat.place == which { series } else { s });
    s
}

/// The partial derivatives of the outputs.
pub(super) fn slopes(d: &DriveTrain, seed: Seed, mut put: impl FnMut(usize, f64)) {
    outputs(d, &d.point_series(seed), &mut |seat, _, series| put(seat.place, series.0[1]));
}

impl DriveTrain {
    /// The outputs in the order of their places.
    pub(super) fn table(&self) -> Vec<Row> {
        let mut table = Vec::new();
        outputs(self, &self.point(), &mut |Seat { follower, .. }, output, _| {
            table.push(Row { output: output.clone(), follower });
        });
        table
    }

    /// Logs when the cam of a follower begins to pull.
    pub(super) fn watch(&mut self) {
        let followers = &self.train.followers;
        let holds = |j: usize| !self.logged[j] && [0.0, 1.0].iter().any(|y| followers[j].hold(*y) != 0.0);
        if !(0..followers.len()).any(holds) {
            return;
        }
        let mut forces = [[0.0; 2]; MOST_FOLLOWERS];
        outputs(self, &self.point(), &mut |seat, output, value| match (seat.follower, output.name) {
            (Some(j), "U") => forces[j][0] = followers[j].hold(value),
            (Some(j), "force" | "contact_force") => forces[j][1] = value,
            _ => {}
        });
        for (j, logged) in self.logged.iter_mut().enumerate() {
            log_pull(logged, forces[j], self.time, j + 1, &mut self.log);
        }
    }

    /// The counts of follower j with clearance.
    fn counts(&self, j: usize) -> Counts {
        let (run, tally) = (&self.run, &self.run.tallies[j]);
        let sums = if self.step > 0.0 { run.sums(&self.train, self.time, j) } else { [0.0; 2] };
        let damped = run.damping_loss(&self.train, self.time, j).unwrap_or(0.0);
        let means = if self.step > 0.0 { sums.map(|sum| sum / self.step) } else { sums };
        Counts { impulse: tally.impulse, impacts: tally.impacts, loss: tally.loss, damped, means }
    }

    fn point(&self) -> Point<f64> {
        let mut y = [0.0; MOST_STATES];
        self.run.at(self.time, &mut y);
        let input_values = self.input_values_now(&y);
        let phi = self.motion.map_or(y[0], |motion| motion.at(self.time).reduced);
        let angles = self.train.angles(Double::from(phi), &y);
        let f = Functions::at(&self.train, &self.run.modes, &angles);
        let w = if self.motion.is_some() { input_values.shaft[0] } else { y[1] };
        let turns = self.run.turns * TAU;
        let whole = self.motion.map_or(phi + turns, |motion| motion.angle(self.time));
        Point { phi, w, y, input_values, f, whole, turns, counted: false }
    }

    /// The present external values.
    fn input_values_now(&self, y: &[f64]) -> InputValues<f64> {
        let input_values = self.input_series(y).0;
        let at = |s: Series| s.0[0];
        let InputValues { shaft, tau, torque, reference, lag, forces } = input_values;
        InputValues {
            shaft: shaft.map(at),
            tau: at(tau),
            torque: at(torque),
            reference: at(reference),
            lag: at(lag),
            forces: forces.map(at),
        }
    }

    /// The same as series in time; the lag of a position input lacks the rotor's part.
    fn input_series(&self, y: &[f64]) -> (InputValues<Series>, f64) {
        let inputs = &self.inputs;
        let mut input_values = InputValues {
            shaft: [Series::from(0.0); 2],
            tau: inputs.loads.series(),
            torque: inputs.torque.series(),
            reference: Series::from(0.0),
            lag: Series::from(0.0),
            forces: [Series::from(0.0); MOST_FOLLOWERS],
        };
        if let Some(motion) = &self.motion {
            let [_, w, a, jerk, snap] = motion.at(self.time).kinematics.0;
            input_values.shaft = [Series::from_derivatives(w, a, jerk), Series::from_derivatives(a, jerk, snap)];
        }
        let mut ratio = 0.0;
        if let Some(motor) = self.motor() {
            if let Some(servo) = motor.servo() {
                let mut row = [0.0; 32];
                servo.expand_reference(self.time, 1.0, (&inputs.reference, inputs.reference.elapsed()), &mut row);
                input_values.reference = Series([row[0], row[1], row[2]]);
            }
            if motor.takes_position() {
                ratio = motor.transmission.ratio;
                let turns = ratio * self.run.turns * std::f64::consts::TAU;
                input_values.lag =
                    inputs.position.series() - Series::from(turns + motor.angle(y[0], y, &self.train.layout));
            }
        }
        inputs.forces.iter().zip(&mut input_values.forces).for_each(|(signal, force)| *force = signal.series());
        (input_values, ratio)
    }

    /// The point as series in time, or with respect to one known.
    fn point_series(&self, seed: Seed) -> Point<Series> {
        let now = self.point();
        let (input_values, ratio) = self.input_series(&now.y);
        let (phi, w) = (Series::from(now.phi), Series::from(now.w));
        let mut seeds = Seeds { phi, w, y: now.y.map(Series::from), input_values };
        if seed == Seed::Time {
            let Seeds { phi, w, y, input_values } = &mut seeds;
            self.run.series_at(self.time, y);
            if self.motion.is_some() {
                let [first, second] = [input_values.shaft[0].0[0], input_values.shaft[0].0[1]];
                *phi = Series([now.phi, first, 0.5 * second]);
                *w = input_values.shaft[0];
            } else {
                (*phi, *w) = (y[0], y[1]);
                let Series([_, rate, bend]) = *phi;
                input_values.lag = input_values.lag - Series([0.0, ratio * rate, ratio * bend]);
            }
        } else {
            self.seed_known(seed, &now, &mut seeds);
        }
        let Seeds { phi, w, y, input_values } = seeds;
        // The same numbers as without series, so that terms that cancel give zero.
        let numbers = self.train.angles(Double::from(now.phi), &now.y);
        let mut angles = numbers.map(|number| Series([number, phi.0[1], phi.0[2]]));
        for (j, follower) in self.train.followers.iter().enumerate() {
            if follower.joint.carries_cam() {
                let Series([_, rate, bend]) = y[self.train.layout.followers[j]];
                angles[1 + j] = angles[1 + j] + Series([0.0, rate, bend]);
            }
        }
        let f = Functions::at(&self.train, &self.run.modes, &angles);
        Point { phi, w, y, input_values, f, whole: phi, turns: 0.0, counted: false }
    }

    /// Moves one input or state with the others constant. For an elastic follower the place y is constant, so that q = y − U(φ)
    /// moves with φ.
    fn seed_known(&self, seed: Seed, now: &Point<f64>, seeds: &mut Seeds) {
        let Seeds { phi, w, y, input_values } = seeds;
        let value = |value: f64, slope: f64| Series([value, slope, 0.0]);
        let (turn, speed) = (seed.of("phi"), seed.of("w"));
        (*phi, *w) = (value(now.phi, turn), value(now.w, speed));
        input_values.shaft = [*w, value(now.input_values.shaft[1], seed.of("a"))];
        input_values.tau = value(now.input_values.tau, self.inputs.loads.seeded(seed)[0]);
        input_values.torque = value(now.input_values.torque, seed.of("M_an"));
        input_values.reference = value(now.input_values.reference, seed.of("w_ref"));
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
                input_values.lag = value(now.input_values.lag, seed.of("phi_ref") - rotor);
            }
        }
        let point = train::Point { modes: &self.run.modes, y: &now.y, f: &now.f, input_values: &now.input_values };
        for (j, follower) in self.train.followers.iter().enumerate() {
            let of = |name: &str| [0, 1].map(|order| seed.of(&self.names.derivative(j, name, order)));
            input_values.forces[j] = value(now.input_values.forces[j], of("F")[0]);
            let [_, u1, u2] = now.f.cams[j];
            let cam = [u1 * turn, u2 * now.w * turn + u1 * speed];
            let (at, joint) = (self.train.layout.followers[j], &follower.joint);
            let slopes = joint.slopes(&self.train.follower(j, &point, now.w), cam, &of);
            for (k, slope) in slopes.into_iter().enumerate().take(joint.states()) {
                y[at + k] = value(now.y[at + k], slope);
            }
        }
    }

    /// The name of an output.
    pub(super) fn name_of(&self, Row { output, follower }: &Row) -> String {
        follower.map_or_else(|| output.name.to_owned(), |j| self.names.derivative(j, output.name, output.order))
    }

    /// The list of variables. The elements of an array follow one another (FMI 2.0, section 2.2.9): all of a follower, then the
    /// derivatives of all followers; the tools of a machine and their derivatives come at the end.
    pub(super) fn declare(&self, table: &[Row], dependencies: &Dependencies) -> List<Self> {
        let mut list = List::default();
        let outputs = |list: &mut List<Self>, wanted: &dyn Fn(&Row) -> bool| {
            let shown = |row: &Row| row.follower.is_none() || self.names.show(row.output.name);
            for (i, row) in table.iter().enumerate().filter(|(_, row)| shown(row) && wanted(row)) {
                self.declare_output(list, FIRST + i, row, dependencies);
            }
        };
        let is_array = |row: &Row| self.names.array(row.output.name);
        self.declare_inputs(&mut list);
        outputs(&mut list, &|row| row.follower.is_none());
        self.declare_parameters(&mut list);
        for j in 0..self.train.followers.len() {
            self.declare_force(&mut list, j);
            outputs(&mut list, &|row| row.follower == Some(j) && row.output.order == 0 && !is_array(row));
            self.declare_parameters_of(&mut list, j);
        }
        for order in 1..3 {
            outputs(&mut list, &|row| row.follower.is_some() && row.output.order == order && !is_array(row));
        }
        let array = |list: &mut List<Self>, name: &str| {
            (0..3).for_each(|order| {
                outputs(list, &|row| is_array(row) && row.output.name == name && row.output.order == order)
            });
        };
        array(&mut list, "lever");
        self.declare_solver(&mut list, STATISTICS);
        for (name, text, quantity, at) in [
            ("start.period", "Period of the steady state found at the start; 0 without one", &unit::TIME, PERIOD),
            ("start.multiplier", "Largest magnitude of its multipliers, below 1: stable", &unit::NUMBER, MULTIPLIER),
        ] {
            list.local(name, text, real(quantity)).at(at);
        }
        array(&mut list, "y");
        list
    }

    fn declare_output(&self, list: &mut List<Self>, place: usize, row: &Row, dependencies: &Dependencies) {
        let Row { output, follower } = row;
        let place_of = |j: usize| match output.name {
            "lever" => format!("the lever of follower {}", j + 1),
            name => self.names.of(j, name),
        };
        let text = match (output.order, output.text, follower) {
            (0, "", Some(j)) => format!("Position of {}", place_of(*j)),
            (1, _, Some(j)) => format!("Velocity of {}", place_of(*j)),
            (2, _, Some(j)) => format!("Acceleration of {}", place_of(*j)),
            _ => output.text.to_owned(),
        };
        let variable = list.named(output, &self.name_of(row), &text, series).at(place);
        let rate_of = match (output.name, follower) {
            ("w", None) if self.machine().is_some() => Some("phi"),
            ("a", None) => Some("w"),
            ("motor.w", None) => Some("motor.phi"),
            ("motor.a", None) => Some("motor.w"),
            _ => None,
        };
        if let Some(of) = rate_of {
            variable.derivative_of(of);
        }
        if output.role == Role::Local {
            return;
        }
        dependencies.declare(self, variable, place);
        let all: Vec<&str> = dependencies.inputs.iter().map(String::as_str).collect();
        let reference: Vec<&str> = all.iter().copied().filter(|name| name.ends_with("_ref")).collect();
        let shaft = self.shaft.known();
        let jumping = match output.name {
            _ if matches!(output.role, Role::Continuous | Role::State) => &[],
            SATURATED => &reference[..],
            "force_mean" | "tau_mean" => &[],
            // A jump of the inputs, of a force or a torque may open or close a contact.
            "contact" => &all,
            "impulse" if !shaft.is_empty() => &shaft[..2],
            _ => shaft,
        };
        if !jumping.is_empty() {
            variable.depends(jumping).slopes(series);
        }
    }

    /// The inputs alone.
    pub(super) fn inputs(&self) -> List<Self> {
        let mut list = List::default();
        self.declare_inputs(&mut list);
        (0..self.train.followers.len()).for_each(|j| self.declare_force(&mut list, j));
        list
    }

    fn declare_force(&self, list: &mut List<Self>, j: usize) {
        declare_force(list, self, 2 * j, &self.names.of(j, "F"), self.train.followers[j].rigid.turns);
    }

    fn declare_inputs(&self, list: &mut List<Self>) {
        let set = |d: &mut Self, i: usize, order: usize, value| d.shaft.set_input_derivative(i, order, value);
        declare_inputs(list, self.shaft.inputs(), |d, i| d.shaft.input(i), set);
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

    fn declare_parameters(&self, list: &mut List<Self>) {
        if let Some(machine) = self.train.machine() {
            list.group::<InertiaFunction>();
            declare_numbers(list, machine, 0..1);
            if let Source::Kloss(_) = machine.motor.source {
                list.group::<Kloss>();
            }
            declare_numbers(list, machine, 1..NUMBERS.len());
            declare_law(list, self, INERTIA_LAW, "inertia");
            declare_law(list, self, LOAD_LAW, "load.M");
        } else {
            let set =
                |d: &mut Self, i: usize, value| d.shaft.mode.parameter_mut(i).into_iter().for_each(|p| *p = value);
            declare_parameters(list, &self.shaft.mode, |d, i| d.shaft.mode.parameter(i).unwrap_or(0.0), set);
        }
        self.declare_start(list);
    }

    fn declare_parameters_of(&self, list: &mut List<Self>, j: usize) {
        let (follower, of) = (&self.train.followers[j], |name: &str| self.names.of(j, name));
        let (joint, turns) = (&follower.joint, follower.rigid.turns);
        if *joint == Joint::Rigid {
            let mass = Parameter::mass(turns);
            let [least, greatest] = mass.kind.range();
            list.parameter(
                &of(mass.key),
                &mass.text(),
                real_within(mass.kind.quantity(), least, greatest),
                |d, j| d.train.followers[j].rigid.m,
                |d, j, value| d.train.followers[j].rigid.m = value,
            )
            .at(j);
        }
        for (i, number) in joint.numbers().iter().enumerate().filter(|(_, number)| joint.has(number.name)) {
            let access = (
                (|d: &Self, index: usize| d.train.followers[index & 0xff].joint.number(index >> 8)) as Get<Self>,
                (|d: &mut Self, index: usize, value| {
                    d.retune();
                    d.train.followers[index & 0xff].joint.set_number(index >> 8, value);
                }) as Set<Self>,
            );
            list.number(number, [&of(number.name), &of(&number.key)], access).at(i << 8 | j);
        }
        if joint.roller().is_some_and(|m| m > 0.0) {
            list.parameter(
                &of("m_roller"),
                "Mass on the cam's side of the spring",
                real_within(&unit::MASS, 0.0, 1e12),
                |d, j| d.train.followers[j].joint.roller().unwrap_or(0.0),
                |d, j, value| d.train.followers[j].joint.set_roller(value),
            )
            .at(j);
        }
        for (which, part) in ["load", "load.roller"].into_iter().enumerate() {
            declare_load(list, self, 2 * j + which, &of(part), turns);
        }
        declare_law(list, self, j, &of(follower.rigid.mover()));
        declare_mechanisms(list, self, j);
    }
}

/// Numbers of a machine and their places `x` in it; numbers that it lacks are NaN.
macro_rules! numbers {
    ($($x:ident in $place:pat => $name:literal, $text:literal, $quantity:ident in [$min:expr, $max:expr]
        $(or $none:literal)?, $variability:ident;)*) => {
        &[$(parameter::Parameter {
            name: $name,
            key: $name,
            text: $text,
            quantity: &unit::$quantity,
            range: [$min, $max],
            default: parameters!(@optional $($none)?),
            nominal: None,
            variability: Variability::$variability,
            get: |machine| if let $place = machine { *$x } else { f64::NAN },
            set: |machine, value| if let $place = machine { *$x = value },
        }),*]
    };
}

/// Places in a machine.
macro_rules! source {
    ($($source:tt)*) => { Machine { motor: Motor { source: Source::$($source)*, .. }, .. } };
}
macro_rules! servo {
    ($($servo:tt)*) => { source!(Servo(Servo { $($servo)*, .. })) };
}
macro_rules! transmission {
    ($($part:tt)*) => { Machine { motor: Motor { transmission: Transmission { $($part)*, .. }, .. }, .. } };
}

#[allow(irrefutable_let_patterns)] // Some patterns match every machine.
const NUMBERS: &[parameter::Parameter<Machine>] = numbers! {
    x in Machine { friction: Some(x), .. } => "load.b", "Viscous friction of the shaft", ROTATIONAL_DAMPING in [0.0, 1e12], Tunable;
    x in source!(Kloss(Kloss { dynamics: Some(x), .. })) => "motor.T_el", "Electrical time constant", TIME in [LAG[0], LAG[1]], Fixed;
    x in source!(Constant(x)) => "motor.torque", "Torque of the rotor", TORQUE in [-1e12, 1e12], Tunable;
    x in servo!(proportional: x) => "motor.K_p", "Gain of the speed control", ROTATIONAL_DAMPING in [0.0, 1e12], Tunable;
    x in servo!(integral: x) => "motor.K_i", "Integral gain", ROTATIONAL_STIFFNESS in [0.0, 1e12], Tunable;
    x in servo!(anti_windup: x) => "motor.K_aw", "Gain of the back-calculation", RATE in [0.0, 1e12], Tunable;
    x in servo!(limit: x) => "motor.M_max", "Limit of the torque", TORQUE in [0.0, 1e12], Tunable;
    x in servo!(reference: Reference::Constant(x)) => "motor.w_ref", "Speed that the rotor is to keep", ANGULAR_VELOCITY in [-FASTEST, FASTEST], Tunable;
    x in servo!(reference: Reference::Ramp(x)) => "motor.ramp", "Rise from rest of the speed that the rotor is to keep", ANGULAR_ACCELERATION in [-1e12, 1e12], Fixed;
    x in servo!(position: Some(x)) => "motor.K_v", "Gain of the position loop", RATE in [0.0, 1e12], Tunable;
    x in transmission!(ratio: x) => "motor.i", "Speed of the rotor over the speed of the shaft, not 0", NUMBER in [-1e6, 1e6] or 1.0, Fixed;
    x in transmission!(rotor: x) => "motor.J", "Moment of inertia of the rotor", INERTIA in [0.0, 1e12] or 0.0, Fixed;
    x in transmission!(coupling: Some([x, _])) => "motor.c", "Stiffness of the coupling at the shaft", ROTATIONAL_STIFFNESS in [1e-12, 1e15], Tunable;
    x in transmission!(coupling: Some([_, x])) => "motor.b", "Damping of the coupling at the shaft", ROTATIONAL_DAMPING in [0.0, 1e12], Tunable;
    x in Machine { phi_start: x, .. } => "phi_start", "Angle at the start", ANGLE in [-LARGEST_ANGLE, LARGEST_ANGLE], Fixed;
    x in Machine { w_start: x, .. } => "w_start", "Angular velocity at the start", ANGULAR_VELOCITY in [-FASTEST, FASTEST], Fixed;
};

/// Declares those of these numbers that the machine has.
fn declare_numbers(list: &mut List<DriveTrain>, machine: &Machine, numbers: Range<usize>) {
    let there =
        |i: &usize| !(NUMBERS[*i].get)(machine).is_nan() && NUMBERS[*i].default != Some((NUMBERS[*i].get)(machine));
    for i in numbers.filter(there) {
        let get = |d: &DriveTrain, i: usize| d.machine().map_or(0.0, NUMBERS[i].get);
        let set = |d: &mut DriveTrain, i: usize, value| {
            d.retune();
            d.train.machine_mut().into_iter().for_each(|machine| (NUMBERS[i].set)(machine, value));
        };
        list.number(&Number::of("", &NUMBERS[i]), [NUMBERS[i].name; 2], (get, set)).at(i);
    }
}

impl DriveTrain {
    pub(super) fn machine(&self) -> Option<&Machine> {
        self.train.machine()
    }

    pub(super) fn motor(&self) -> Option<&Motor> {
        self.machine().map(|machine| &machine.motor)
    }
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
            INERTIA_LAW => self.train.machine_mut().and_then(|machine| machine.inertia.varying.as_mut()),
            LOAD_LAW => self.train.machine_mut().and_then(|machine| machine.load.as_mut()),
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
        self.train.machine_mut().map(|machine| &mut machine.inertia)
    }
}

impl Has<Kloss> for DriveTrain {
    fn group(&self) -> Option<&Kloss> {
        if let Source::Kloss(kloss) = &self.motor()?.source { Some(kloss) } else { None }
    }
    fn group_mut(&mut self) -> Option<&mut Kloss> {
        self.retune();
        let machine = self.train.machine_mut()?;
        if let Source::Kloss(kloss) = &mut machine.motor.source { Some(kloss) } else { None }
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
