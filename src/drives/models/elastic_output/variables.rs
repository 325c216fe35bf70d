//! The variables of the drive.

use super::loaded::{LoadEffects, Process};
use super::{ElasticOutput, Parameters};
use crate::drives::follower::flow::Flow;
use crate::drives::settings::HasSolver;
use crate::drives::shaft::cam_drive::{A, CAM, HasCamDrive, PHI, W};
use crate::drives::shaft::free::coupled::COUPLING;
use crate::drives::shaft::free::signal::Signal;
use crate::drives::shaft::instant::Instant;
use crate::drives::shaft::loads::{HasLoads, declare_force, declare_load};
use crate::drives::unit;
use crate::drives::variable::{Variability, real_within};
use crate::drives::{List, Seed};
use crate::motion::derivatives::lift;
use crate::motion::{Kinematics, TransferFunctions};
use crate::numerics::pair::Pair;
use crate::numerics::taylor::{Scalar, Series};

/// The name of the input force.
const F: &str = "F";

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
    /// Only under loads.
    Contact,
}

/// The places of the outputs for the inertia on the shaft follow the contact force's.
const COUPLED: usize = Output::Contact as usize + 1;

/// The number of outputs without loads.
const OUTPUTS: usize = Output::Tau as usize + 1;

/// The loads, and the arguments of the mass's load other than place and speed: process force and input.
struct Forces<'a, S> {
    loaded: &'a LoadEffects,
    given: [Option<S>; 2],
}

impl<'a, S: Scalar> Forces<'a, S> {
    /// The forces at the angle `phi`; `input` reads the input's signal. None without loads.
    fn new(drive: &'a ElasticOutput, phi: S, input: impl Fn(&Signal) -> S) -> Option<Self> {
        let loaded = drive.loaded.as_deref()?;
        let process = loaded.process.as_ref().map(|Process { now, .. }| {
            let [p, slope] = now.u.array();
            phi.compose([p, slope, now.curvature])
        });
        Some(Forces { loaded, given: [process, loaded.loads[0].input.then(|| input(&loaded.push.signal))] })
    }
}

pub(super) fn list(drive: &ElasticOutput) -> List<ElasticOutput> {
    let mut list = List::default();
    drive.declare_drive(&mut list);
    declare_force(&mut list, drive, 0, F, false);
    list.group::<Parameters>();
    if drive.loaded.as_ref().is_some_and(|loaded| loaded.m_roller > 0.0) {
        // It stays one, as large as the output member's.
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

/// The number of outputs.
fn count(drive: &ElasticOutput) -> usize {
    OUTPUTS + drive.loaded.as_ref().map_or(0, |loaded| if loaded.coupling { 4 } else { 1 })
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
    // The effect of the input force.
    let accelerated: &[&str] =
        if drive.load(0).is_some_and(|load| load.input) { &["phi", "w", "y", "der(y)", F] } else { all };
    let mut contact = all.to_vec();
    contact.extend(drive.loaded.as_ref().filter(|loaded| loaded.m_roller > 0.0).map(|_| "a"));
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
    let initial: &[&[&str]] = &[PHI, W, A, CAM, &["m_roller", "load"], &force.concat()];
    let text = "Torque from the drive into the cam unit, U' contact_force; a positive tau loads the drive";
    output(Output::Tau, "tau", text, &unit::TORQUE, &contact, initial);
    let text = "Force of the cam on the follower, positive in the sense of y: force and the inertia of the cam's side less its loads";
    output(Output::Contact, "contact_force", text, &unit::FORCE, &contact, initial);
    if let Some(loaded) = drive.loaded.as_ref().filter(|loaded| loaded.coupling) {
        let roller = &loaded.loads[1];
        let weight: &[&str] = if roller.gravity.is_some() { &["m_roller"] } else { &[] };
        let speed = if roller.damping.is_some() { W } else { &[] };
        let of_mass: &[&[&str]] = &[PHI, CAM, &["m_roller"]];
        let of_rest: &[&[&str]] = &[PHI, speed, CAM, weight, &["load.roller"], &force.concat()];
        for (i, (name, text, quantity)) in COUPLING.into_iter().enumerate() {
            let (known, initial) = if i < 2 { (&["phi"][..], of_mass) } else { (all, of_rest) };
            outputs.add(COUPLED + i, name, text, quantity, known).depends_initially(initial);
        }
    }
}

/// The outputs, of numbers or of series, in the order of [`Output`], and those under loads; u holds U … U⁗ at the communication
/// point.
#[inline(always)]
fn outputs<S: Scalar>(
    drive: &ElasticOutput,
    u: &[f64; 5],
    f: &Flow<S>,
    forces: Option<&Forces<'_, S>>,
) -> ([S; OUTPUTS], [S; 4]) {
    let u = [[u[0], u[1], u[2]], [u[1], u[2], u[3]], [u[2], u[3], u[4]]].map(|u| f.phi.compose(u));
    let (equation, [x, x1, x2]) = (drive.response.equation(), lift(u, [f.w, f.a]));
    let force = equation.force([f.q, f.v]);
    let (mut accelerating, mut contact, mut coupled) = (force, force, [S::from(0.0); 3]);
    if let Some(forces) = forces {
        let m_roller = forces.loaded.m_roller;
        let ([load, roller], [process, input]) = (&*forces.loaded.loads, forces.given);
        accelerating = force + load.force(drive.parameters.m, [x + f.q, x1 + f.v], process, input);
        let load = roller.force(m_roller, [x, x1], None, None);
        contact = force + x2 * m_roller - load;
        if forces.loaded.coupling {
            coupled = [u[1] * u[1] * m_roller, u[1] * u[2] * (2.0 * m_roller), u[1] * (force - load)];
        }
    }
    let y2 = accelerating * (1.0 / drive.parameters.m);
    ([f.phi, f.w, x, x + f.q, x1 + f.v, y2, f.q, f.v, y2 - x2, force, u[1] * contact], {
        let [inertia, slope, rest] = coupled;
        [contact, inertia, slope, rest]
    })
}

/// The outputs as numbers.
#[inline(always)]
fn numbers(drive: &ElasticOutput, q: Pair, forces: Option<&Forces<'_, f64>>) -> ([f64; OUTPUTS], [f64; 4]) {
    let Instant { shaft: [phi, w, a], u, curvature, .. } = drive.now;
    let ([x, slope], [q, v]) = (u.array(), q.array());
    // The output phi is not reduced; U no longer needs the angle, and numbers need no derivative beyond U″.
    let u = [x, slope, curvature, 0.0, 0.0];
    outputs(drive, &u, &Flow { phi, w, a, q, v, force: 0.0 }, forces)
}

/// The same under loads.
#[inline(never)]
fn numbers_under(drive: &ElasticOutput) -> ([f64; OUTPUTS], [f64; 4]) {
    let forces = Forces::new(drive, drive.now.shaft[0], |signal| signal.now());
    numbers(drive, drive.deformation().into(), forces.as_ref())
}

/// The force of the cam on the follower (N).
pub(super) fn contact_force(drive: &ElasticOutput) -> f64 {
    numbers_under(drive).1[0]
}

pub(super) fn evaluate(drive: &ElasticOutput, values: &mut [f64]) {
    if drive.loaded.is_some() {
        return evaluate_under(drive, values);
    }
    values[..OUTPUTS].copy_from_slice(&numbers(drive, drive.now.q, None).0);
    values[OUTPUTS..].copy_from_slice(&drive.statistics());
}

#[inline(never)]
fn evaluate_under(drive: &ElasticOutput, values: &mut [f64]) {
    let ((outputs, under), count) = (numbers_under(drive), count(drive));
    values[..OUTPUTS].copy_from_slice(&outputs);
    values[OUTPUTS..count].copy_from_slice(&under[..count - OUTPUTS]);
    values[count..].copy_from_slice(&drive.statistics());
}

fn series(drive: &ElasticOutput, seed: Seed, which: usize) -> Series {
    let shaft = drive.shaft();
    let u = shaft.on(&drive.cam.law);
    let (flow, forces) = match seed {
        Seed::Time => along_time(drive, &shaft.kinematics, &u),
        known => {
            let flow = along_known(drive, &shaft.kinematics, &u, known);
            let input = |signal: &Signal| Series([signal.now(), known.of(F), 0.0]);
            (flow, Forces::new(drive, flow.phi, input))
        }
    };
    let (outputs, under) = outputs(drive, &u.0, &flow, forces.as_ref());
    outputs.into_iter().chain(under).nth(which).unwrap_or(under[0])
}

/// Drive and mass as functions of time.
fn along_time<'a>(
    drive: &'a ElasticOutput,
    shaft: &Kinematics,
    u: &TransferFunctions,
) -> (Flow<Series>, Option<Forces<'a, Series>>) {
    let ([phi, w, a, jerk, snap], [q, v]) = (shaft.0, drive.deformation());
    let [phi, w, a] =
        [[phi, w, a], [w, a, jerk], [a, jerk, snap]].map(|[d0, d1, d2]| Series::from_derivatives(d0, d1, d2));
    let forces = Forces::new(drive, phi, |signal| signal.series());
    let x = u.along(shaft).0;
    let x = [0, 1, 2].map(|order| Series::from_derivatives(x[order], x[order + 1], 0.0));
    let acceleration = |[q, v]: [Series; 2]| match &forces {
        None => drive.response.equation().acceleration([q, v], x),
        forces => {
            outputs(drive, &u.0, &Flow { phi, w, a, q, v, force: 0.0.into() }, forces.as_ref()).0
                [Output::QDotDot as usize]
        }
    };
    let q2 = acceleration([q, v].map(Series::from)).value();
    let q3 = acceleration([Series([q, v, 0.0]), Series([v, q2, 0.0])]).derivative(1);
    let [q, v] = [[q, v, q2], [v, q2, q3]].map(|[d0, d1, d2]| Series::from_derivatives(d0, d1, d2));
    (Flow { phi, w, a, q, v, force: 0.0.into() }, forces)
}

/// Drive and mass as functions of one input or state with the others constant: q = y − U(φ), q̇ = ẏ − U′(φ) ω.
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
