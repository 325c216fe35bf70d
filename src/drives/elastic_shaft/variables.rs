//! The variables of the drive.

use super::equation::{Cam, Flow};
use super::{ElasticShaft, Parameters};
use crate::drives::cam_drive::{A, CAM, HasCamDrive, PHI, W};
use crate::drives::settings::HasSolver;
use crate::drives::unit;
use crate::drives::variable::Kind;
use crate::drives::{List, Seed};
use crate::numerics::angle;
use crate::numerics::double_double::Double;
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
}

/// How many there are.
const OUTPUTS: usize = Output::Tau as usize + 1;

pub(super) fn list(drive: &ElasticShaft) -> List<ElasticShaft> {
    let mut list = List::default();
    drive.declare_drive(&mut list);
    list.group::<Parameters>();
    declare_linear(&mut list);
    drive.declare_start(&mut list, &unit::ANGLE, &unit::ANGULAR_VELOCITY);
    drive.declare_solver(&mut list, OUTPUTS);
    declare_outputs(drive, &mut list);
    drive.declare_law(&mut list);
    list
}

fn declare_linear(list: &mut List<ElasticShaft>) {
    list.parameter(
        "shaft.linear",
        "Whether the equation is linearised in the twist",
        Kind::Boolean,
        |d, _| f64::from(u8::from(d.linear)),
        |d, _, value| d.linear = value != 0.0,
    )
    .key("elasticity.linear");
}

fn declare_outputs(drive: &ElasticShaft, list: &mut List<ElasticShaft>) {
    let mut outputs = drive.outputs(list, &["psi", "der(psi)"], series);
    outputs.add_shaft([Output::Phi as usize, Output::W as usize]);
    let mut output = |which: Output, name, text, quantity, known: &[&str], initial: &[&[&str]]| {
        outputs.add(which as usize, name, text, quantity, known).depends_initially(initial);
    };
    let periodic = drive.periodic_start(&["m", "J", "c", "b", "shaft.linear", "cam", "solver.tolerance"]);
    let q = [&periodic[..], &["start.mode", "start.q"]].concat();
    let q_dot = [&periodic[..], &["start.mode", "start.q_dot"]].concat();
    // Whether the equation is linearised is a parameter: then U is taken at phi, and a acts on q.
    let lift = [PHI, CAM, &q, &["shaft.linear"]].concat();
    let all: &[&str] = &["phi", "w", "psi", "der(psi)"];
    output(Output::Psi, "psi", "Angle of the cam, phi + q", &unit::ANGLE, &["psi"], &[PHI, &q]);
    let text = "Angular velocity of the cam";
    output(Output::PsiDot, "der(psi)", text, &unit::ANGULAR_VELOCITY, &["der(psi)"], &[W, &q_dot]);
    let (text, known) = ("Angular acceleration of the cam", [&["a"], all].concat());
    let initial: &[&[&str]] = &[&lift, W, A, &q_dot, &["m", "J", "c", "b"]];
    output(Output::PsiDotDot, "der(psi,2)", text, &unit::ANGULAR_ACCELERATION, &known, initial);
    output(Output::Q, "q", "Twist of the shaft, psi - phi", &unit::ANGLE, &["phi", "psi"], &[&q]);
    output(Output::QDot, "der(q)", "Rate of the twist", &unit::ANGULAR_VELOCITY, &["w", "der(psi)"], &[&q_dot]);
    let text = "Position of the follower, U(psi) or U + U' q";
    output(Output::Y, "y", text, &unit::LENGTH, &["phi", "psi"], &[&lift]);
    output(Output::YDot, "der(y)", "Velocity of the follower", &unit::VELOCITY, all, &[&lift, W, &q_dot]);
    let text = "Torque from the drive into the cam unit, -(c q + b der(q)); a positive tau loads the drive";
    output(Output::Tau, "tau", text, &unit::TORQUE, all, &[&q, &q_dot, &["c", "b"]]);
}

/// The outputs, of numbers or of series, in the order of [`Output`].
fn outputs<S: Scalar>(drive: &ElasticShaft, cam: &Cam, f: &Flow<S>) -> [S; OUTPUTS] {
    let equation = drive.equation();
    let acceleration = equation.acceleration(cam, f, 1.0) + f.a;
    let (lift, lift_speed) = (equation.lift(cam, f), equation.lift_speed(cam, f));
    let tau = equation.torque(f.q, f.v);
    [f.phi, f.w, f.phi + f.q, f.cam_speed(), acceleration, f.q, f.v, lift, lift_speed, tau]
}

/// Angle and segment at which the cam acts at the communication point; on a breakpoint of the law the side to which
/// the cam turns.
fn place(drive: &ElasticShaft, f: &Flow<f64>) -> (usize, f64) {
    let angle = angle::reduce(Double::from(f.argument(drive.linear)));
    (drive.cam.law.segment(angle, f.turning(drive.linear) >= 0.0), angle)
}

/// The drive at the communication point, and φ without reduction.
fn flow(drive: &ElasticShaft) -> (Flow<f64>, f64) {
    let shaft = drive.motion.at(drive.time);
    let [phi, w, a, ..] = shaft.kinematics.0;
    (Flow { phi: shaft.reduced, w, a, q: drive.twist[0], v: drive.twist[1] }, phi)
}

/// The values of the outputs; angles are put out without reduction.
fn values(drive: &ElasticShaft) -> [f64; OUTPUTS] {
    let (f, phi) = flow(drive);
    let (segment, angle) = place(drive, &f);
    let mut values = outputs(drive, &Cam::at(&drive.cam.law, segment, angle), &f);
    (values[Output::Phi as usize], values[Output::Psi as usize]) = (phi, phi + f.q);
    values
}

pub(super) fn evaluate(drive: &ElasticShaft, places: &mut [f64]) {
    places[..OUTPUTS].copy_from_slice(&values(drive));
    places[OUTPUTS..].copy_from_slice(&drive.statistics());
}

fn series(drive: &ElasticShaft, seed: Seed, which: usize) -> Series {
    let (f, _) = flow(drive);
    let (segment, angle) = place(drive, &f);
    let cam = Cam::with_fifth(&drive.cam.law, segment, angle);
    let along = match seed {
        Seed::Time => along_time(drive, &cam, &f),
        known => along_known(&f, known),
    };
    let mut series = outputs(drive, &cam, &along)[which];
    series.0[0] = values(drive)[which];
    series
}

/// Drive and twist as functions of time: each pass of the equation yields one more derivative of q̇.
fn along_time(drive: &ElasticShaft, cam: &Cam, f: &Flow<f64>) -> Flow<Series> {
    let [_, w, a, jerk, snap] = drive.motion.at(drive.time).kinematics.0;
    let mut along = Flow {
        phi: Series::from_derivatives(f.phi, w, a),
        w: Series::from_derivatives(w, a, jerk),
        a: Series::from_derivatives(a, jerk, snap),
        q: Series::from(f.q),
        v: Series::from(f.v),
    };
    let equation = drive.equation();
    let acceleration = equation.acceleration(cam, f, 1.0);
    along.q = Series::from_derivatives(f.q, f.v, acceleration);
    along.v = Series::from_derivatives(f.v, acceleration, 0.0);
    let third = equation.acceleration(cam, &along, 1.0).derivative(1);
    along.v = Series::from_derivatives(f.v, acceleration, third);
    along
}

/// Drive and twist as functions of one input or state, the others held: q = ψ − φ, q̇ = ψ̇ − ω.
fn along_known(f: &Flow<f64>, known: Seed) -> Flow<Series> {
    let [phi, w, a, psi, psi_dot] = ["phi", "w", "a", "psi", "der(psi)"].map(|name| known.of(name));
    Flow {
        phi: Series([f.phi, phi, 0.0]),
        w: Series([f.w, w, 0.0]),
        a: Series([f.a, a, 0.0]),
        q: Series([f.q, psi - phi, 0.0]),
        v: Series([f.v, psi_dot - w, 0.0]),
    }
}
