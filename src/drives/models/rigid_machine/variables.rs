//! The variables of the rigid machine and its output equations.

use super::linkage::Parameter;
use super::{Follower, InertiaFunction, Kloss, LAG, MachineStart, Motor, RigidMachine, Shaft, State};
use crate::drives::limits::{FASTEST, LARGEST_ANGLE};
use crate::drives::parameter::{Has, parameters};
use crate::drives::settings::HasSolver;
use crate::drives::shaft::free::coupled::declare_loads;
use crate::drives::shaft::free::signal::Signal;
use crate::drives::shaft::laws::{HasLaws, INERTIA_LAW, declare_law, declare_mechanisms};
use crate::drives::unit::{self, Quantity};
use crate::drives::variable::{Enumeration, Kind, real, real_within};
use crate::drives::{List, Seed};
use crate::motion::MotionLaw;
use crate::numerics::angle::WHOLE_TURN;
use crate::numerics::double_double::{Double, two_product};
use crate::numerics::taylor::{Scalar, Series};
use std::sync::Arc;

/// The items of `start.mode`.
pub static START_MODE: Enumeration = Enumeration {
    name: "MachineStart",
    items: &[
        ("given", "From phi_start and w_start"),
        ("steady_state", "At phi_start on the periodic solution under the load at the start"),
    ],
};

/// Rate of a torque (N·m/s).
static TORQUE_RATE_QUANTITY: Quantity =
    Quantity { name: "TorqueRate", unit: "N.m/s", base: [1, 2, -3, 0], display: None };

/// Quantities of the equations of motion and the outputs, as numbers or as series.
#[derive(Clone, Copy)]
struct Point<S> {
    /// φ within the turn.
    phi: S,
    w: S,
    /// M_an if it is an input or a state.
    torque: S,
    tau: S,
    /// J of the machine itself with its derivatives by φ; for numbers only the first two.
    inertia: [f64; 4],
    /// J and J′ of loads.
    loads: [S; 2],
}

impl<S: Scalar> Point<S> {
    /// J(φ) and J′(φ).
    fn inertia(&self) -> [S; 2] {
        let [j, j1, j2, j3] = self.inertia;
        [self.phi.compose([j, j1, j2]), self.phi.compose([j1, j2, j3])]
    }
}

/// φ̈ = (M_an − τ − ½ J′ φ̇²) / J; loads with an inertia add to J and J′.
fn acceleration<S: Scalar>(machine: &RigidMachine, p: &Point<S>, [mut j, mut j1]: [S; 2]) -> S {
    if machine.shaft.loads.have_inertia() {
        (j, j1) = (j + p.loads[0], j1 + p.loads[1]);
    }
    (machine.shaft.motor.driving(p.w, p.torque) - p.tau - j1 * p.w * p.w * 0.5) / j
}

/// dM_an/dt = (M_Kloss(φ̇) − M_an) / T_el of a motor with a lag, else zero.
fn torque_rate<S: Scalar>(machine: &RigidMachine, p: &Point<S>) -> S {
    match machine.shaft.motor.lag() {
        Some(lag) => (machine.shaft.motor.torque(p.w) - p.torque) * (1.0 / lag),
        None => S::from(0.0),
    }
}

/// U, U′ and U″ from `u`, which holds them with two more derivatives at φ.
fn transfer<S: Scalar>(phi: S, u: [f64; 5]) -> [S; 3] {
    [0, 1, 2].map(|n| phi.compose([u[n], u[n + 1], u[n + 2]]))
}

/// The outputs; follower j has the indices FOLLOWER + 6j + n, n the order of the derivative, its lever FOLLOWER + 6j + 3 + n.
const PHI: usize = 0;
const W: usize = 1;
const A: usize = 2;
const TORQUE: usize = 3;
const INERTIA: usize = 4;
const ENERGY: usize = 5;
const TORQUE_RATE: usize = 6;
const FOLLOWER: usize = 7;

/// The places of the solver's statistics and of the period of the start, after the outputs of so many followers.
fn statistics(followers: usize) -> usize {
    FOLLOWER + 6 * followers
}

/// Passes the outputs, of numbers or of series, to `put`, including the followers' if they are wanted.
fn outputs<S: Scalar>(machine: &RigidMachine, p: &Point<S>, followers: bool, mut put: impl FnMut(usize, S)) {
    let inertia = p.inertia();
    let a = acceleration(machine, p, inertia);
    put(PHI, p.phi);
    put(W, p.w);
    put(A, a);
    put(TORQUE, machine.shaft.motor.driving(p.w, p.torque));
    put(INERTIA, inertia[0]);
    put(ENERGY, inertia[0] * p.w * p.w * 0.5);
    put(TORQUE_RATE, torque_rate(machine, p));
    let place = machine.shaft.inertia.place(machine.state.interval);
    for (j, follower) in machine.shaft.inertia.followers.iter().enumerate().filter(|_| followers) {
        let cam = place.evaluate(&follower.cam, machine.state.angle.hi).0;
        let mut members = |member: usize, u: [f64; 5]| {
            let [u, u1, u2] = transfer(p.phi, u);
            for (n, value) in [u, u1 * p.w, u2 * p.w * p.w + u1 * a].into_iter().enumerate() {
                put(FOLLOWER + 6 * j + 3 * member + n, value);
            }
        };
        // Numbers need no derivatives beyond U″.
        if S::ORDER == 0 {
            let [u, u1, u2] = follower.tool([cam[0], cam[1], cam[2]]);
            members(0, [u, u1, u2, 0.0, 0.0]);
        } else {
            members(0, follower.tool(cam));
        }
        if follower.has_lever() {
            members(1, cam);
        }
    }
}

/// φ (rad) with its whole turns.
fn whole_angle(machine: &RigidMachine) -> f64 {
    // The low part of 2π matters from a thousand turns on.
    let low = Double::from(machine.state.turns * WHOLE_TURN.lo);
    (two_product(machine.state.turns, WHOLE_TURN.hi) + low + machine.state.angle).hi
}

pub(super) fn evaluate(machine: &RigidMachine, values: &mut [f64]) {
    outputs(machine, &machine.point(), true, |place, value| values[place] = value);
    values[PHI] = whole_angle(machine);
    let rest = &mut values[statistics(machine.shaft.inertia.followers.len())..];
    rest[..3].copy_from_slice(&machine.statistics());
    rest[3] = machine.period;
}

fn series(machine: &RigidMachine, seed: Seed, which: usize) -> Series {
    let mut s = Series::from(0.0);
    let p = machine.point_series(seed);
    outputs(machine, &p, which >= FOLLOWER, |place, series| s = if place == which { series } else { s });
    if which == PHI {
        s.0[0] = whole_angle(machine);
    }
    s
}

impl RigidMachine {
    fn point(&self) -> Point<f64> {
        let Self { shaft, state, .. } = self;
        let ([j, j1], [of_loads, slope, _]) = (shaft.own_inertia(state), shaft.loads.now(state));
        let (torque, tau) = (shaft.known_torque(state), shaft.loads.torque_now());
        let (inertia, loads) = ([j, j1, 0.0, 0.0], [of_loads, slope]);
        Point { phi: state.angle.hi, w: state.w, torque, tau, inertia, loads }
    }

    /// The series of the point: in time, from the equation of motion; or with respect to one known.
    fn point_series(&self, seed: Seed) -> Point<Series> {
        let now = self.point();
        let (own, State { interval, angle, .. }) = (&self.shaft.inertia, self.state);
        let inertia = own.at(own.place(interval), angle.hi);
        match seed {
            Seed::Time => {
                let input = self.shaft.motor == Motor::Input;
                let torque = if input { self.shaft.driving.series() } else { Series::from(now.torque) };
                let (phi, w, loads) = (Series::from(now.phi), Series::from(now.w), &self.shaft.loads);
                let tau = loads.series();
                let mut p = Point { phi, w, torque, tau, inertia, loads: now.loads.map(Series::from) };
                let curvature = loads.now(&self.state)[2];
                // Each pass yields the next coefficient: the rates are right up to the order of their arguments.
                for order in 1..3 {
                    let (a, rate) = (acceleration(self, &p, p.inertia()), torque_rate(self, &p));
                    p.phi.0[order] = p.w.0[order - 1] / order as f64;
                    p.w.0[order] = a.0[order - 1] / order as f64;
                    let ([j, slope], phi) = (now.loads, p.phi);
                    p.loads = [phi.compose([j, slope, curvature]), phi.compose([slope, curvature, 0.0])];
                    if !input {
                        p.torque.0[order] = rate.0[order - 1] / order as f64;
                    }
                }
                p
            }
            known => {
                let [of_tau, of_loads @ ..] = self.shaft.loads.seeded(known);
                let along = |value, name| Series([value, known.of(name), 0.0]);
                Point {
                    phi: along(now.phi, "phi"),
                    w: along(now.w, "w"),
                    torque: along(now.torque, "M_an"),
                    tau: Series([now.tau, of_tau, 0.0]),
                    inertia,
                    loads: [0, 1].map(|n| Series([now.loads[n], of_loads[n], 0.0])),
                }
            }
        }
    }

    /// The list of variables.
    pub(super) fn declare(&self) -> List<Self> {
        let mut list = List::default();
        self.declare_inputs(&mut list);
        self.declare_outputs(&mut list);
        self.declare_parameters(&mut list);
        let place = statistics(self.shaft.inertia.followers.len());
        self.declare_solver(&mut list, place);
        list.local("start.period", "Period of the steady state found at the start; 0 without one", real(&unit::TIME))
            .at(place + 3);
        for j in 0..self.shaft.inertia.followers.len() {
            self.declare_follower(&mut list, j);
        }
        declare_law(&mut list, self, INERTIA_LAW, "inertia");
        list
    }

    fn declare_inputs(&self, list: &mut List<Self>) {
        let set = |d: &mut Self, at: usize, order: usize, value| {
            d.shaft.loads.signal_mut(at).into_iter().for_each(|signal| signal.set_derivative(order, value));
        };
        declare_loads(list, &self.shaft.loads, |d, at| d.shaft.loads.signal(at).map_or(0.0, Signal::set_value), set);
        if self.shaft.motor == Motor::Input {
            list.input(
                "M_an",
                "Driving torque on the shaft; positive accelerates",
                real(&unit::TORQUE),
                |d, _| d.shaft.driving.set_value(),
                |d, _, order, value| d.shaft.driving.set_derivative(order, value),
            );
        }
    }

    fn declare_outputs(&self, list: &mut List<Self>) {
        let Shaft { inertia, motor, .. } = &self.shaft;
        let (varies, lag) = (inertia.varies(), motor.lag().is_some());
        let (input, motor) = (*motor == Motor::Input, matches!(motor, Motor::Kloss(_)));
        let when = |holds: bool, name: &'static str| if holds { vec![name] } else { Vec::new() };
        let (of_phi, of_w) = (when(varies, "phi"), when(varies || (motor && !lag), "w"));
        // The speed enters the acceleration through J′ and through the motor without lag.
        let loads = self.shaft.loads.names();
        let loads: Vec<&str> = loads.iter().map(String::as_str).collect();
        let torques = [loads.clone(), when(input || lag, "M_an")].concat();
        let enters_a = [&torques[..], &of_phi, &of_w].concat();
        // The dependencies of the start values; only a motor allows the periodic start.
        let turning: &[&str] = if varies { &["phi_start"] } else { &[] };
        let inertia: &[&[&str]] = &[turning, &["J0", "inertia", "follower"]];
        let of_motor: &[&str] = &["motor.M_k", "motor.s_k", "motor.w_s"];
        let periodic: &[&[&str]] = &[&["start.mode", "motor.T_el"], &loads, of_motor, &inertia.concat()];
        let periodic = if motor && !self.shaft.loads.have_inertia() { periodic.concat() } else { Vec::new() };
        let w_start = [&periodic[..], &["w_start"]].concat();
        let torque_start = match (motor, lag) {
            (false, _) => vec!["M_an"],
            (true, false) => [&w_start[..], of_motor].concat(),
            (true, true) => [&periodic[..], &["motor.M_start"]].concat(),
        };
        let a_start = [&inertia.concat()[..], &w_start, &torque_start, &loads].concat();

        list.output("phi", "Angle of the shaft", real(&unit::ANGLE), series)
            .at(PHI)
            .state()
            .depends(&["phi"])
            .depends_initially(&[&["phi_start"]]);
        list.output("w", "Angular velocity of the shaft, der(phi)", real(&unit::ANGULAR_VELOCITY), series)
            .at(W)
            .state()
            .derivative_of("phi")
            .depends(&["w"])
            .depends_initially(&[&w_start]);
        list.output("a", "Angular acceleration of the shaft, der(w)", real(&unit::ANGULAR_ACCELERATION), series)
            .at(A)
            .derivative_of("w")
            .depends(&enters_a)
            .depends_initially(&[&a_start]);
        if motor {
            let text = "Torque of the motor on the shaft; positive accelerates";
            let torque = list.output("M_an", text, real(&unit::TORQUE), series).at(TORQUE);
            torque.depends(if lag { &["M_an"] } else { &["w"] }).depends_initially(&[&torque_start]);
            if lag {
                torque.state();
                list.output("der(M_an)", "Rate of the motor's torque", real(&TORQUE_RATE_QUANTITY), series)
                    .at(TORQUE_RATE)
                    .depends(&["w", "M_an"])
                    .depends_initially(&[&w_start, &torque_start, of_motor, &["motor.T_el"]]);
            }
        }
        list.output("J", "Reduced moment of inertia at phi", real(&unit::INERTIA), series)
            .at(INERTIA)
            .depends(&of_phi)
            .depends_initially(inertia);
        list.output("E", "Kinetic energy J w^2 / 2", real(&unit::ENERGY), series)
            .at(ENERGY)
            .depends(&[&["w"], &of_phi[..]].concat())
            .depends_initially(&[&inertia.concat(), &w_start]);
        self.declare_followers(list, &[&torques[..], &["phi", "w"]].concat(), [&w_start, &a_start]);
    }

    /// Declares the motions of the tools and levers. The arguments are the variables that enter the acceleration of the shaft, and
    /// the dependencies of its speed and its acceleration at the start.
    fn declare_followers(&self, list: &mut List<Self>, enters_a: &[&str], [w_start, a_start]: [&[&str]; 2]) {
        // The elements of an array follow one another (FMI 2.0, section 2.2.9), so the followers come innermost.
        for i in 0..6 {
            let (is_lever, order) = (i >= 3, i % 3);
            for (j, follower) in self.shaft.inertia.followers.iter().enumerate() {
                if is_lever && !follower.has_lever() {
                    continue;
                }
                let n = j + 1;
                let (name, of) = if is_lever { ("lever", "the lever of ") } else { ("U", "") };
                let quantities = if is_lever || follower.turns {
                    [&unit::ANGLE, &unit::ANGULAR_VELOCITY, &unit::ANGULAR_ACCELERATION]
                } else {
                    [&unit::LENGTH, &unit::VELOCITY, &unit::ACCELERATION]
                };
                let (name, what, known, moved): (_, _, &[&str], &[&str]) = match order {
                    0 => (format!("{name}[{n}]"), "Position", &["phi"], &[]),
                    1 => (format!("der({name}[{n}])"), "Velocity", &["phi", "w"], w_start),
                    _ => (format!("der({name}[{n}],2)"), "Acceleration", enters_a, a_start),
                };
                let [cam, linkage] = [follower.mover(), "linkage"].map(|part| format!("follower[{n}].{part}"));
                let placed: &[&str] = if is_lever { &["phi_start", &cam] } else { &["phi_start", &cam, &linkage] };
                list.output(&name, &format!("{what} of {of}follower {n}"), real(quantities[order]), series)
                    .at(FOLLOWER + 6 * j + i)
                    .depends(known)
                    .depends_initially(&[placed, moved]);
            }
        }
    }

    fn declare_parameters(&self, list: &mut List<Self>) {
        list.group::<InertiaFunction>();
        if let Motor::Kloss(Kloss { dynamics, .. }) = self.shaft.motor {
            list.group::<Kloss>();
            if dynamics.is_some() {
                list.parameter(
                    "motor.T_el",
                    "Electrical time constant",
                    real_within(&unit::TIME, LAG[0], LAG[1]),
                    |d, _| d.shaft.motor.lag().unwrap_or(0.0),
                    |d, _, value| d.group_mut().into_iter().for_each(|kloss: &mut Kloss| kloss.dynamics = Some(value)),
                )
                .key("motor.lag");
                let text = "M_an at the start for start.mode = given; 0 if the motor is switched on";
                list.parameter(
                    "motor.M_start",
                    text,
                    real_within(&unit::TORQUE, -1e12, 1e12),
                    |d, _| d.start.torque,
                    |d, _, value| d.start.torque = value,
                );
            }
        }
        list.group::<RigidMachine>();
        list.parameter(
            "start.mode",
            "How the initial speed is found",
            Kind::Enumeration(&START_MODE),
            |d, _| if d.start.mode == MachineStart::Given { 1.0 } else { 2.0 },
            |d, _, value| d.start.mode = if value < 1.5 { MachineStart::Given } else { MachineStart::SteadyState },
        );
    }

    fn declare_follower(&self, list: &mut List<Self>, j: usize) {
        let n = j + 1;
        let follower = &self.shaft.inertia.followers[j];
        let mass = Parameter::mass(follower.turns);
        let [least, greatest] = mass.kind.range();
        list.parameter(
            &format!("follower[{n}].{}", mass.key),
            &format!("{} of follower {n}", mass.text()),
            real_within(mass.kind.quantity(), least, greatest),
            |d, j| d.shaft.inertia.followers[j].m,
            |d, j, value| Arc::make_mut(&mut d.shaft.inertia).change(|_, followers| followers[j].m = value),
        )
        .at(j);
        declare_law(list, self, j, &format!("follower[{n}].{}", follower.mover()));
        declare_mechanisms(list, self, j);
    }
}

parameters! {
    for RigidMachine, "start" {
        /// Angle at the start
        start.phi = "phi_start", "phi_start", ANGLE in [-LARGEST_ANGLE, LARGEST_ANGLE] or 0.0, Fixed;
        /// Angular velocity at the start, for start.mode = given
        start.w = "w_start", "w_start", ANGULAR_VELOCITY in [-FASTEST, FASTEST] or 0.0, Fixed;
    }
}

impl HasLaws for RigidMachine {
    fn law(&self, number: usize) -> Option<&MotionLaw> {
        match number {
            INERTIA_LAW => self.shaft.inertia.function.varying.as_ref(),
            j => self.follower(j).map(|f| &f.cam),
        }
    }
    fn change_law(&mut self, number: usize, change: impl FnMut(&mut MotionLaw)) {
        Arc::make_mut(&mut self.shaft.inertia).change(|function, followers| {
            let law = match number {
                INERTIA_LAW => function.varying.as_mut(),
                j => followers.get_mut(j).map(|f| &mut f.cam),
            };
            law.into_iter().for_each(change);
        });
    }
    fn follower(&self, number: usize) -> Option<&Follower> {
        self.shaft.inertia.followers.get(number)
    }
    fn change_follower(&mut self, number: usize, change: impl FnMut(&mut Follower)) {
        Arc::make_mut(&mut self.shaft.inertia)
            .change(|_, followers| followers.get_mut(number).into_iter().for_each(change));
    }
}

impl Has<RigidMachine> for RigidMachine {
    fn group(&self) -> Option<&RigidMachine> {
        Some(self)
    }
    fn group_mut(&mut self) -> Option<&mut RigidMachine> {
        Some(self)
    }
}

impl Has<InertiaFunction> for RigidMachine {
    fn group(&self) -> Option<&InertiaFunction> {
        Some(&self.shaft.inertia.function)
    }
    fn group_mut(&mut self) -> Option<&mut InertiaFunction> {
        Some(Arc::make_mut(&mut self.shaft.inertia).function_mut())
    }
}

impl Has<Kloss> for RigidMachine {
    fn group(&self) -> Option<&Kloss> {
        if let Motor::Kloss(kloss) = &self.shaft.motor { Some(kloss) } else { None }
    }
    fn group_mut(&mut self) -> Option<&mut Kloss> {
        if let Motor::Kloss(kloss) = &mut self.shaft.motor { Some(kloss) } else { None }
    }
}
