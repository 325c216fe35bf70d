//! The variables of the drive.

use super::loaded::Process;
use super::{ElasticOutput, Parameters};
use crate::drives::follower::flow::Flow;
use crate::drives::settings::HasSolver;
use crate::drives::shaft::cam_drive::{A, CAM, HasCamDrive, PHI, W};
use crate::drives::shaft::free::signal::Signal;
use crate::drives::shaft::instant::Instant;
use crate::drives::shaft::loads::{HasLoads, declare_force, declare_load};
use crate::drives::unit;
use crate::drives::variable::{Variability, real_within};
use crate::drives::{List, Seed};
use crate::motion::derivatives::lift;
use crate::motion::{Kinematics, TransferFunctions};
use crate::numerics::taylor::{Scalar, Series};

/// The names of the inputs on the mass and on the cam's side.
const F: &str = "F";
const ROLLER_F: &str = "roller.F";

/// The continuous quantities, in the order of their declaration.
#[derive(Clone, Copy)]
enum Output {
    Phi,
    W,
    X,
    Y,
    YDot,
    YDotDot,
    Q,
    QDot,
    QDotDot,
    Force,
    Tau,
    /// Under loads only.
    Contact,
}

/// How many there are without loads.
const OUTPUTS: usize = Output::Tau as usize + 1;

/// What the loads on the mass and on the cam's side depend on beside place and speed: process forces and inputs.
struct Forces<S>([[Option<S>; 2]; 2]);

impl<S: Scalar> Forces<S> {
    /// At the angle `phi`, where `input` makes an input of its number and its place among the loads.
    fn new(drive: &ElasticOutput, phi: S, input: impl Fn(&Signal, &'static str) -> S) -> Self {
        let Some(loaded) = &drive.loaded else { return Forces([[None; 2]; 2]) };
        let on_mass = loaded.process.as_ref().map(|Process { now, .. }| {
            let [p, slope] = now.u.array();
            phi.compose([p, slope, now.curvature])
        });
        let of_roller = |law| {
            let [p, slope, curvature, ..] = drive.shaft().on(law).0;
            phi.compose([p, slope, curvature])
        };
        let [load, roller] = &*loaded.loads;
        let inputs = [(load, &loaded.push.signal, F), (roller, &loaded.roller, ROLLER_F)];
        let [f, roller_f] = inputs.map(|(load, signal, name)| load.input.then(|| input(signal, name)));
        Forces([[on_mass, f], [roller.process.as_ref().map(of_roller), roller_f]])
    }

    /// The load of this number at x, ẋ of its mass `m`; None without loads.
    fn load(&self, drive: &ElasticOutput, which: usize, m: f64, place: [S; 2]) -> Option<S> {
        let [process, input] = self.0[which];
        drive.loaded.as_ref().map(|loaded| loaded.loads[which].force(m, place, process, input))
    }

    /// ÿ at q, q̇ where the cam has x, ẋ.
    fn acceleration(&self, drive: &ElasticOutput, [q, v]: [S; 2], [x, x1]: [S; 2]) -> S {
        let (force, m) = (drive.response.equation().force([q, v]), drive.parameters.m);
        self.load(drive, 0, m, [x + q, x1 + v]).map_or(force, |load| force + load) * (1.0 / m)
    }
}

pub(super) fn list(drive: &ElasticOutput) -> List<ElasticOutput> {
    let mut list = List::default();
    drive.declare_drive(&mut list);
    for (which, name) in [F, ROLLER_F].into_iter().enumerate() {
        declare_force(&mut list, drive, which, name, false);
    }
    list.group::<Parameters>();
    if drive.loaded.as_ref().is_some_and(|loaded| loaded.m_roller > 0.0) {
        // It stays one, as large as that of the output member.
        let kind = real_within(&unit::MASS, 1e-12, 1e12);
        let roller = list.parameter(
            "m_roller",
            "Mass on the cam's side of the spring",
            kind,
            |d, _| d.loaded.as_ref().map_or(0.0, |loaded| loaded.m_roller),
            |d, _, value| d.loaded.iter_mut().for_each(|loaded| loaded.m_roller = value),
        );
        roller.description.variability = Variability::Tunable;
    }
    for (which, name) in ["load", "load.roller"].into_iter().enumerate() {
        declare_load(&mut list, drive, which, name, false);
    }
    drive.declare_start(&mut list, &unit::LENGTH, &unit::VELOCITY);
    drive.declare_solver(&mut list, count(drive));
    declare_outputs(drive, &mut list);
    drive.declare_law(&mut list);
    list
}

/// How many outputs there are.
fn count(drive: &ElasticOutput) -> usize {
    OUTPUTS + usize::from(drive.loaded.is_some())
}

fn declare_outputs(drive: &ElasticOutput, list: &mut List<ElasticOutput>) {
    let mut outputs = drive.outputs(list, &["y", "der(y)"], series);
    outputs.add_shaft([Output::Phi as usize, Output::W as usize]);
    let mut output = |which: Output, name, text, quantity, known: &[&str], initial: &[&[&str]]| {
        outputs.add(which as usize, name, text, quantity, known).depends_initially(initial);
    };
    let loaded = drive.loaded.is_some();
    let periodic = drive.periodic_start(&["m", "c", "b", "cam", "load", F]);
    // Inputs may start on an equilibrium, too.
    let balance: &[&str] = if loaded { &["m", "c", "cam", "load", F, "phi"] } else { &[] };
    let q = [&periodic[..], balance, &["start.mode", "start.q"]].concat();
    let q_dot = [&periodic[..], &["start.mode", "start.q_dot"]].concat();
    let force: &[&[&str]] = &[&q, &q_dot, &["c", "b"]];
    let all: &[&str] = &["phi", "w", "y", "der(y)"];
    // What the inputs of the loads change.
    let has = |which: usize| drive.load(which).is_some_and(|load| load.input);
    let accelerated: &[&str] = if has(0) { &["phi", "w", "y", "der(y)", F] } else { all };
    let mut contact = all.to_vec();
    contact.extend(drive.loaded.as_ref().filter(|loaded| loaded.m_roller > 0.0).map(|_| "a"));
    contact.extend(has(1).then_some(ROLLER_F));
    let text = "Position of the cam's side of the spring, U(phi)";
    output(Output::X, "x", text, &unit::LENGTH, &["phi"], &[PHI, CAM]);
    output(Output::Y, "y", "Position of the mass, x + q", &unit::LENGTH, &["y"], &[PHI, CAM, &q]);
    output(Output::YDot, "der(y)", "Velocity of the mass", &unit::VELOCITY, &["der(y)"], &[PHI, W, CAM, &q_dot]);
    let place: &[&str] = if loaded { &[PHI, W, CAM, &["load", F]].concat() } else { &[] };
    let initial: &[&[&str]] = &[&["m"], &force.concat(), place];
    output(Output::YDotDot, "der(y,2)", "Acceleration of the mass", &unit::ACCELERATION, accelerated, initial);
    output(Output::Q, "q", "Deformation of the output member, y - x", &unit::LENGTH, &["phi", "y"], &[&q]);
    let text = "Rate of the deformation";
    output(Output::QDot, "der(q)", text, &unit::VELOCITY, &["phi", "w", "der(y)"], &[&q_dot]);
    let (text, known) = ("Second time derivative of the deformation", [&["a"], accelerated].concat());
    let initial: &[&[&str]] = &[PHI, W, A, CAM, &["m"], &force.concat(), place];
    output(Output::QDotDot, "der(q,2)", text, &unit::ACCELERATION, &known, initial);
    let text = "Force on the mass, -(c q + b der(q)), positive in the sense of y";
    output(Output::Force, "force", text, &unit::FORCE, all, force);
    if !loaded {
        let text = "Torque from the drive into the cam unit, U' force; a positive tau loads the drive";
        return output(Output::Tau, "tau", text, &unit::TORQUE, all, &[PHI, CAM, &force.concat()]);
    }
    let initial: &[&[&str]] = &[PHI, W, A, CAM, &["m_roller", "load", ROLLER_F], &force.concat()];
    let text = "Torque from the drive into the cam unit, U' contact_force; a positive tau loads the drive";
    output(Output::Tau, "tau", text, &unit::TORQUE, &contact, initial);
    let text = "Force of the cam on the follower, positive in the sense of y: force and the inertia of the cam's side less its loads";
    output(Output::Contact, "contact_force", text, &unit::FORCE, &contact, initial);
}

/// The outputs, of numbers or of series, in the order of [`Output`]; u holds U … U⁗ at the communication point.
fn outputs<S: Scalar>(drive: &ElasticOutput, u: &[f64; 5], f: &Flow<S>, forces: &Forces<S>) -> [S; OUTPUTS + 1] {
    let u = [[u[0], u[1], u[2]], [u[1], u[2], u[3]], [u[2], u[3], u[4]]].map(|u| f.phi.compose(u));
    let (equation, [x, x1, x2]) = (drive.response.equation(), lift(u, [f.w, f.a]));
    let force = equation.force([f.q, f.v]);
    let y2 = forces.acceleration(drive, [f.q, f.v], [x, x1]);
    let mut contact = force;
    if let Some(m) = drive.loaded.as_ref().map(|loaded| loaded.m_roller)
        && let Some(load) = forces.load(drive, 1, m, [x, x1])
    {
        contact = force + x2 * m - load;
    }
    [f.phi, f.w, x, x + f.q, x1 + f.v, y2, f.q, f.v, y2 - x2, force, u[1] * contact, contact]
}

/// The outputs as numbers.
fn numbers(drive: &ElasticOutput) -> [f64; OUTPUTS + 1] {
    let Instant { shaft: [phi, w, a], u, curvature, .. } = drive.now;
    let ([x, slope], [q, v]) = (u.array(), drive.deformation());
    // phi is put out without reduction; U needs no angle any more, and numbers no derivative beyond U″.
    let u = [x, slope, curvature, 0.0, 0.0];
    outputs(drive, &u, &Flow { phi, w, a, q, v, force: 0.0 }, &Forces::new(drive, phi, |signal, _| signal.now()))
}

/// The force of the cam on the follower (N).
pub(super) fn contact_force(drive: &ElasticOutput) -> f64 {
    numbers(drive)[Output::Contact as usize]
}

pub(super) fn evaluate(drive: &ElasticOutput, values: &mut [f64]) {
    let (values, statistics) = values.split_at_mut(count(drive));
    values.copy_from_slice(&numbers(drive)[..values.len()]);
    statistics.copy_from_slice(&drive.statistics());
}

fn series(drive: &ElasticOutput, seed: Seed, which: usize) -> Series {
    let shaft = drive.shaft();
    let u = shaft.on(&drive.cam.law);
    let (flow, forces) = match seed {
        Seed::Time => along_time(drive, &shaft.kinematics, &u),
        known => {
            let flow = along_known(drive, &shaft.kinematics, &u, known);
            let input = |signal: &Signal, name| Series([signal.now(), known.of(name), 0.0]);
            (flow, Forces::new(drive, flow.phi, input))
        }
    };
    outputs(drive, &u.0, &flow, &forces)[which]
}

/// Drive and mass as functions of time.
fn along_time(drive: &ElasticOutput, shaft: &Kinematics, u: &TransferFunctions) -> (Flow<Series>, Forces<Series>) {
    let ([phi, w, a, jerk, snap], [q, v]) = (shaft.0, drive.deformation());
    let x = u.along(shaft).0;
    let angle = Series::from_derivatives(phi, w, a);
    let forces = Forces::new(drive, angle, |signal, _| signal.series());
    let x = [0, 1, 2].map(|order| Series::from_derivatives(x[order], x[order + 1], 0.0));
    let acceleration = |state: [Series; 2]| match drive.loaded {
        None => drive.response.equation().acceleration(state, x),
        Some(_) => forces.acceleration(drive, state, [x[0], x[1]]) - x[2],
    };
    let q2 = acceleration([q, v].map(Series::from));
    let q2 = acceleration([Series([q, v, 0.0]), Series([v, q2.value(), 0.0])]);
    let (q2, q3) = (q2.derivative(0), q2.derivative(1));
    let flow = Flow {
        phi: angle,
        w: Series::from_derivatives(w, a, jerk),
        a: Series::from_derivatives(a, jerk, snap),
        q: Series::from_derivatives(q, v, q2),
        v: Series::from_derivatives(v, q2, q3),
        force: 0.0.into(),
    };
    (flow, forces)
}

/// Drive and mass as functions of one input or state, the others held: q = y − U(φ), q̇ = ẏ − U′(φ) ω.
fn along_known(drive: &ElasticOutput, shaft: &Kinematics, u: &TransferFunctions, known: Seed) -> Flow<Series> {
    let [phi_1, w_1, a_1, y_1, y_dot_1] = ["phi", "w", "a", "y", "der(y)"].map(|name| known.of(name));
    let ([phi, w, a, ..], [_, u1, u2, ..], [q, v]) = (shaft.0, u.0, drive.deformation());
    Flow {
        phi: Series([phi, phi_1, 0.0]),
        w: Series([w, w_1, 0.0]),
        a: Series([a, a_1, 0.0]),
        q: Series([q, y_1 - u1 * phi_1, 0.0]),
        v: Series([v, y_dot_1 - u2 * w * phi_1 - u1 * w_1, 0.0]),
        force: 0.0.into(),
    }
}
