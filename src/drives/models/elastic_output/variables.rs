//! The variables of the drive.

use super::{ElasticOutput, Parameters};
use crate::drives::follower::flow::Flow;
use crate::drives::settings::HasSolver;
use crate::drives::shaft::cam_drive::{A, CAM, HasCamDrive, PHI, W};
use crate::drives::shaft::instant::Instant;
use crate::drives::unit;
use crate::drives::{List, Seed};
use crate::motion::derivatives::lift;
use crate::motion::{Kinematics, TransferFunctions};
use crate::numerics::taylor::{Scalar, Series};

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
}

/// How many there are.
const OUTPUTS: usize = Output::Tau as usize + 1;

pub(super) fn list(drive: &ElasticOutput) -> List<ElasticOutput> {
    let mut list = List::default();
    drive.declare_drive(&mut list);
    list.group::<Parameters>();
    drive.declare_start(&mut list, &unit::LENGTH, &unit::VELOCITY);
    drive.declare_solver(&mut list, OUTPUTS);
    declare_outputs(drive, &mut list);
    drive.declare_law(&mut list);
    list
}

fn declare_outputs(drive: &ElasticOutput, list: &mut List<ElasticOutput>) {
    let mut outputs = drive.outputs(list, &["y", "der(y)"], series);
    outputs.add_shaft([Output::Phi as usize, Output::W as usize]);
    let mut output = |which: Output, name, text, quantity, known: &[&str], initial: &[&[&str]]| {
        outputs.add(which as usize, name, text, quantity, known).depends_initially(initial);
    };
    let periodic = drive.periodic_start(&["m", "c", "b", "cam"]);
    let q = [&periodic[..], &["start.mode", "start.q"]].concat();
    let q_dot = [&periodic[..], &["start.mode", "start.q_dot"]].concat();
    let force: &[&[&str]] = &[&q, &q_dot, &["c", "b"]];
    let all: &[&str] = &["phi", "w", "y", "der(y)"];
    let text = "Position of the cam's side of the spring, U(phi)";
    output(Output::X, "x", text, &unit::LENGTH, &["phi"], &[PHI, CAM]);
    output(Output::Y, "y", "Position of the mass, x + q", &unit::LENGTH, &["y"], &[PHI, CAM, &q]);
    output(Output::YDot, "der(y)", "Velocity of the mass", &unit::VELOCITY, &["der(y)"], &[PHI, W, CAM, &q_dot]);
    let initial: &[&[&str]] = &[&["m"], &force.concat()];
    output(Output::YDotDot, "der(y,2)", "Acceleration of the mass", &unit::ACCELERATION, all, initial);
    output(Output::Q, "q", "Deformation of the output member, y - x", &unit::LENGTH, &["phi", "y"], &[&q]);
    let text = "Rate of the deformation";
    output(Output::QDot, "der(q)", text, &unit::VELOCITY, &["phi", "w", "der(y)"], &[&q_dot]);
    let (text, known) = ("Second time derivative of the deformation", [&["a"], all].concat());
    let initial: &[&[&str]] = &[PHI, W, A, CAM, &["m"], &force.concat()];
    output(Output::QDotDot, "der(q,2)", text, &unit::ACCELERATION, &known, initial);
    let text = "Force on the mass, -(c q + b der(q)), positive in the sense of y";
    output(Output::Force, "force", text, &unit::FORCE, all, force);
    let text = "Torque from the drive into the cam unit, U' force; a positive tau loads the drive";
    output(Output::Tau, "tau", text, &unit::TORQUE, all, &[PHI, CAM, &force.concat()]);
}

/// The outputs, of numbers or of series, in the order of [`Output`]; u holds U … U⁗ at the communication point.
fn outputs<S: Scalar>(drive: &ElasticOutput, u: &[f64; 5], f: &Flow<S>) -> [S; OUTPUTS] {
    let u = [[u[0], u[1], u[2]], [u[1], u[2], u[3]], [u[2], u[3], u[4]]].map(|u| f.phi.compose(u));
    let (equation, [x, x1, x2]) = (drive.response.equation(), lift(u, [f.w, f.a]));
    let force = equation.force([f.q, f.v]);
    let y2 = force * (1.0 / drive.parameters.m);
    let q2 = y2 + equation.forcing([x, x1, x2]);
    [f.phi, f.w, x, x + f.q, x1 + f.v, y2, f.q, f.v, q2, force, u[1] * force]
}

pub(super) fn evaluate(drive: &ElasticOutput, values: &mut [f64]) {
    let Instant { shaft: [phi, w, a], u, curvature, q, .. } = drive.now;
    let ([x, slope], [q, v]) = (u.array(), q.array());
    // phi is put out without reduction; U needs no angle any more, and numbers no derivative beyond U″.
    let u = [x, slope, curvature, 0.0, 0.0];
    values[..OUTPUTS].copy_from_slice(&outputs(drive, &u, &Flow { phi, w, a, q, v, force: 0.0 }));
    values[OUTPUTS..].copy_from_slice(&drive.statistics());
}

fn series(drive: &ElasticOutput, seed: Seed, which: usize) -> Series {
    let shaft = drive.shaft();
    let u = shaft.on(&drive.cam.law);
    let flow = match seed {
        Seed::Time => along_time(drive, &shaft.kinematics, &u),
        known => along_known(drive, &shaft.kinematics, &u, known),
    };
    outputs(drive, &u.0, &flow)[which]
}

/// Drive and mass as functions of time.
fn along_time(drive: &ElasticOutput, shaft: &Kinematics, u: &TransferFunctions) -> Flow<Series> {
    let ([phi, w, a, jerk, snap], [q, v]) = (shaft.0, drive.now.q.array());
    let (equation, x) = (drive.response.equation(), u.along(shaft).0);
    let q2 = equation.acceleration([q, v], [x[0], x[1], x[2]]);
    let x = [0, 1, 2].map(|order| Series::from_derivatives(x[order], x[order + 1], 0.0));
    let q3 = equation.acceleration([Series([q, v, 0.0]), Series([v, q2, 0.0])], x).derivative(1);
    Flow {
        phi: Series::from_derivatives(phi, w, a),
        w: Series::from_derivatives(w, a, jerk),
        a: Series::from_derivatives(a, jerk, snap),
        q: Series::from_derivatives(q, v, q2),
        v: Series::from_derivatives(v, q2, q3),
        force: 0.0.into(),
    }
}

/// Drive and mass as functions of one input or state, the others held: q = y − U(φ), q̇ = ẏ − U′(φ) ω.
fn along_known(drive: &ElasticOutput, shaft: &Kinematics, u: &TransferFunctions, known: Seed) -> Flow<Series> {
    let [phi_1, w_1, a_1, y_1, y_dot_1] = ["phi", "w", "a", "y", "der(y)"].map(|name| known.of(name));
    let ([phi, w, a, ..], [_, u1, u2, ..], [q, v]) = (shaft.0, u.0, drive.now.q.array());
    Flow {
        phi: Series([phi, phi_1, 0.0]),
        w: Series([w, w_1, 0.0]),
        a: Series([a, a_1, 0.0]),
        q: Series([q, y_1 - u1 * phi_1, 0.0]),
        v: Series([v, y_dot_1 - u2 * w * phi_1 - u1 * w_1, 0.0]),
        force: 0.0.into(),
    }
}
