//! The variables of the drive.

use super::{ElasticShaft, Parameters};
use crate::drives::follower::elastic_shaft::{Cam, Twist};
use crate::drives::follower::equation::Equation;
use crate::drives::follower::flow::Flow;
use crate::drives::settings::HasSolver;
use crate::drives::shaft::cam_drive::{A, CAM, HasCamDrive, PHI, W};
use crate::drives::shaft::loads::{declare_force, declare_load};
use crate::drives::unit;
use crate::drives::variable::Kind;
use crate::drives::{List, Seed};
use crate::numerics::taylor::{Scalar, Series};

/// The continuous quantities, in the order of their declaration.
#[derive(Clone, Copy)]
enum Output {
    Phi,
    W,
    Psi,
    PsiDot,
    PsiDotDot,
    Q,
    QDot,
    Y,
    YDot,
    Tau,
    /// Only under a load.
    Contact,
}

/// The number of outputs without a load.
const OUTPUTS: usize = Output::Tau as usize + 1;

/// The number of outputs.
fn count(drive: &ElasticShaft) -> usize {
    OUTPUTS + usize::from(drive.equation.load.is_some())
}

const STATES: [&str; 2] = ["psi", "der(psi)"];

pub(super) fn list(drive: &ElasticShaft) -> List<ElasticShaft> {
    let mut list = List::default();
    drive.declare_drive(&mut list);
    declare_force(&mut list, drive, 0, "F", false);
    list.group::<Parameters>();
    declare_linear(&mut list);
    drive.declare_start(&mut list, &unit::ANGLE, &unit::ANGULAR_VELOCITY);
    declare_load(&mut list, drive, 0, "load", false);
    drive.declare_solver(&mut list, count(drive));
    declare_outputs(drive, &mut list);
    drive.declare_law(&mut list);
    list
}

fn declare_linear(list: &mut List<ElasticShaft>) {
    list.parameter(
        "shaft.linear",
        "Whether the equation is linearised in the twist",
        Kind::Boolean,
        |d, _| f64::from(u8::from(d.equation.linear)),
        |d, _, value| d.equation.linear = value != 0.0,
    )
    .key("elasticity.linear");
}

fn declare_outputs(drive: &ElasticShaft, list: &mut List<ElasticShaft>) {
    let mut outputs = drive.outputs(list, &STATES, series);
    outputs.add_shaft([Output::Phi as usize, Output::W as usize]);
    let mut output = |which: Output, name, text, quantity, known: &[&str], initial: &[&[&str]]| {
        outputs.add(which as usize, name, text, quantity, known).depends_initially(initial);
    };
    let of = ["m", "J", "c", "b", "shaft.linear", "cam", "load", "solver.tolerance"];
    let periodic = drive.periodic_start(&of);
    // A load has an equilibrium, even on inputs.
    let loaded: &[&str] = if drive.equation.load.is_some() { &["F", "load", "m"] } else { &[] };
    let balanced = if loaded.is_empty() { Vec::new() } else { [loaded, PHI, W, CAM, &["c", "shaft.linear"]].concat() };
    let q = [&periodic[..], &balanced, &["start.mode", "start.q"]].concat();
    let q_dot = [&periodic[..], &["start.mode", "start.q_dot"]].concat();
    // A parameter decides whether the equation is linearised: then U is taken at phi, and a acts on q.
    let lift = [PHI, CAM, &q, &["shaft.linear"]].concat();
    let all: &[&str] = &["phi", "w", "psi", "der(psi)"];
    output(Output::Psi, "psi", "Angle of the cam, phi + q", &unit::ANGLE, &["psi"], &[PHI, &q]);
    let text = "Angular velocity of the cam";
    output(Output::PsiDot, "der(psi)", text, &unit::ANGULAR_VELOCITY, &["der(psi)"], &[W, &q_dot]);
    let (text, known) = ("Angular acceleration of the cam", [&["a"], all].concat());
    let known = if drive.force.is_some() { [&known[..], &["F"]].concat() } else { known };
    let initial: &[&[&str]] = &[&lift, W, A, &q_dot, loaded, &["m", "J", "c", "b"]];
    output(Output::PsiDotDot, "der(psi,2)", text, &unit::ANGULAR_ACCELERATION, &known, initial);
    output(Output::Q, "q", "Twist of the shaft, psi - phi", &unit::ANGLE, &["phi", "psi"], &[&q]);
    output(Output::QDot, "der(q)", "Rate of the twist", &unit::ANGULAR_VELOCITY, &["w", "der(psi)"], &[&q_dot]);
    let text = "Position of the follower, U(psi) or U + U' q";
    output(Output::Y, "y", text, &unit::LENGTH, &["phi", "psi"], &[&lift]);
    output(Output::YDot, "der(y)", "Velocity of the follower", &unit::VELOCITY, all, &[&lift, W, &q_dot]);
    let text = "Torque from the drive into the cam unit, -(c q + b der(q)); a positive tau loads the drive";
    output(Output::Tau, "tau", text, &unit::TORQUE, all, &[&q, &q_dot, &["c", "b"]]);
    if drive.equation.load.is_some() {
        let text = "Force of the cam on the follower, positive in the sense of y: its inertia less its loads";
        output(Output::Contact, "contact_force", text, &unit::FORCE, &known, initial);
    }
}

/// The outputs, of numbers or of series, in the order of [`Output`].
fn outputs<S: Scalar>(drive: &ElasticShaft, cam: &Cam, f: &Flow<S>) -> [S; OUTPUTS] {
    let equation = &drive.equation;
    let acceleration = equation.acceleration(cam, f) + f.a;
    let (lift, lift_speed) = (equation.lift(cam, f), equation.lift_speed(cam, f));
    let tau = equation.torque(f.q, f.v);
    [f.phi, f.w, f.phi + f.q, f.cam_speed(), acceleration, f.q, f.v, lift, lift_speed, tau]
}

pub(super) fn evaluate(drive: &ElasticShaft, places: &mut [f64]) {
    let (cam, f) = drive.now(Twist::at);
    places[..OUTPUTS].copy_from_slice(&outputs(drive, &cam, &f));
    if drive.equation.load.is_some() {
        places[OUTPUTS] = drive.equation.contact_force(&cam, &f);
    }
    places[count(drive)..].copy_from_slice(&drive.statistics());
}

fn series(drive: &ElasticShaft, seed: Seed, which: usize) -> Series {
    let (cam, f) = drive.now(Twist::with_fifth);
    let along = drive.along(seed, STATES, &cam, &f);
    if which == Output::Contact as usize {
        return drive.equation.contact_force(&cam, &along);
    }
    outputs(drive, &cam, &along)[which]
}
