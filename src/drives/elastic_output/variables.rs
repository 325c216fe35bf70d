//! The variables of the drive.

use super::{ElasticOutput, Position};
use crate::drives::cam_drive::{A, CAM, HasCamDrive, PHI, W};
use crate::drives::solver::HasSolver;
use crate::drives::unit::{self, Quantity};
use crate::drives::variable::{real, real_within};
use crate::drives::{Board, List, Seed};
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

const OUTPUTS: [Output; 11] = [
    Output::Phi,
    Output::W,
    Output::X,
    Output::Y,
    Output::YDot,
    Output::YDotDot,
    Output::Q,
    Output::QDot,
    Output::QDotDot,
    Output::Force,
    Output::Tau,
];

pub(super) fn list(drive: &ElasticOutput) -> List<ElasticOutput> {
    let mut list = List::default();
    drive.declare_drive(&mut list);
    declare_parameters(&mut list);
    drive.declare_start(&mut list, &unit::LENGTH, &unit::VELOCITY);
    drive.declare_solver(&mut list);
    declare_outputs(drive, &mut list);
    drive.declare_law(&mut list);
    list
}

fn declare_parameters(list: &mut List<ElasticOutput>) {
    // Twelve decades to either side of 1 kg, and as far from 1 N/m and 1 N·s/m as this leaves natural frequencies
    // that can be squared.
    list.parameter(
        "m",
        "Mass of the output member",
        real_within(&unit::MASS, 1e-12, 1e12),
        |d, _| d.m,
        |d, _, value| d.m = value,
    )
    .tunable();
    list.parameter(
        "c",
        "Stiffness between cam and mass",
        real_within(&unit::STIFFNESS, 0.0, 1e24),
        |d, _| d.c,
        |d, _, value| d.c = value,
    )
    .tunable();
    list.parameter(
        "b",
        "Damping between cam and mass",
        real_within(&unit::DAMPING, 0.0, 1e24),
        |d, _| d.b,
        |d, _, value| d.b = value,
    )
    .tunable();
}

/// Declares the outputs with what they depend on: inputs (where there are any) and states.
fn declare_outputs(drive: &ElasticOutput, list: &mut List<ElasticOutput>) {
    let input = drive.cam.is_input();
    let mut output = |which: Output,
                      name: &str,
                      text: &str,
                      quantity: &'static Quantity,
                      [inputs, states]: [&[&str]; 2],
                      initial: &[&[&str]]| {
        let inputs = if input { inputs } else { &[] };
        let known: Vec<&str> = inputs.iter().chain(states).copied().collect();
        let v = list.output(name, text, real(quantity), VALUES[which as usize], series);
        v.at(which as usize).depends(&known).depends_initially(initial);
        match which {
            Output::Y => v.state(),
            Output::YDot => v.state().derivative_of("y"),
            Output::YDotDot => v.derivative_of("der(y)"),
            Output::QDot => v.derivative_of("q"),
            Output::QDotDot => v.derivative_of("der(q)"),
            _ => v,
        };
    };
    if !input {
        output(Output::Phi, "phi", "Drive angle", &unit::ANGLE, [&[], &[]], &[PHI]);
        output(Output::W, "w", "Angular velocity of the drive", &unit::ANGULAR_VELOCITY, [&[], &[]], &[W]);
    }
    let both: &[&str] = &["y", "der(y)"];
    let periodic = drive.periodic_start(&["m", "c", "b", "cam"]);
    let q = [&periodic[..], &["start.mode", "start.q"]].concat();
    let q_dot = [&periodic[..], &["start.mode", "start.q_dot"]].concat();
    let force: &[&[&str]] = &[&q, &q_dot, &["c", "b"]];
    output(
        Output::X,
        "x",
        "Position of the cam's side of the spring, U(phi)",
        &unit::LENGTH,
        [&["phi"], &[]],
        &[PHI, CAM],
    );
    output(Output::Y, "y", "Position of the mass, x + q", &unit::LENGTH, [&[], &["y"]], &[PHI, CAM, &q]);
    output(Output::YDot, "der(y)", "Velocity of the mass", &unit::VELOCITY, [&[], &["der(y)"]], &[PHI, W, CAM, &q_dot]);
    output(
        Output::YDotDot,
        "der(y,2)",
        "Acceleration of the mass",
        &unit::ACCELERATION,
        [&["phi", "w"], both],
        &[&["m"], &force.concat()],
    );
    output(Output::Q, "q", "Deformation of the output member, y - x", &unit::LENGTH, [&["phi"], &["y"]], &[&q]);
    output(Output::QDot, "der(q)", "Rate of the deformation", &unit::VELOCITY, [&["phi", "w"], &["der(y)"]], &[&q_dot]);
    output(
        Output::QDotDot,
        "der(q,2)",
        "Second time derivative of the deformation",
        &unit::ACCELERATION,
        [&["phi", "w", "a"], both],
        &[PHI, W, A, CAM, &["m"], &force.concat()],
    );
    output(
        Output::Force,
        "force",
        "Force on the mass, -(c q + b der(q)), positive in the sense of y",
        &unit::FORCE,
        [&["phi", "w"], both],
        force,
    );
    output(
        Output::Tau,
        "tau",
        "Torque from the drive into the cam unit, U' force; a positive tau loads the drive",
        &unit::TORQUE,
        [&["phi", "w"], both],
        &[PHI, CAM, &force.concat()],
    );
}

/// The motion of drive and mass that the output equations start from.
#[derive(Clone, Copy)]
struct Flow<S> {
    phi: S,
    w: S,
    a: S,
    q: S,
    v: S,
}

/// An output, of numbers or of series; u holds U … U⁗ at the communication point.
fn evaluate<S: Scalar>(drive: &ElasticOutput, u: &[f64; 5], which: Output, f: &Flow<S>) -> S {
    let transfer = |n: usize| f.phi.compose([u[n], u[n + 1], u.get(n + 2).copied().unwrap_or(0.0)]);
    let force = || -(f.q * drive.c + f.v * drive.b);
    match which {
        Output::Phi => f.phi,
        Output::W => f.w,
        Output::X => transfer(0),
        Output::Y => transfer(0) + f.q,
        Output::YDot => transfer(1) * f.w + f.v,
        Output::YDotDot => force() * (1.0 / drive.m),
        Output::Q => f.q,
        Output::QDot => f.v,
        Output::QDotDot => force() * (1.0 / drive.m) - transfer(2) * f.w * f.w - transfer(1) * f.a,
        Output::Force => force(),
        Output::Tau => transfer(1) * force(),
    }
}

/// The value of each output, as a function of its own, so that none pays for what only others need.
const VALUES: [fn(&ElasticOutput, usize) -> f64; OUTPUTS.len()] = [
    value::<0>,
    value::<1>,
    value::<2>,
    value::<3>,
    value::<4>,
    value::<5>,
    value::<6>,
    value::<7>,
    value::<8>,
    value::<9>,
    value::<10>,
];

fn value<const WHICH: usize>(drive: &ElasticOutput, _: usize) -> f64 {
    let (which, now) = (OUTPUTS[WHICH], &drive.now);
    // phi is put out without reduction; U needs no angle any more.
    if matches!(which, Output::Phi | Output::QDotDot) {
        let Position { phi: [phi, w, a, ..], u, .. } = drive.position();
        let [q, v] = now.q.array();
        return evaluate(drive, &u, which, &Flow { phi, w, a, q, v });
    }
    at_hand(drive, which)
}

/// An output that is made of the moment alone.
#[inline(always)]
fn at_hand(drive: &ElasticOutput, which: Output) -> f64 {
    let ([u, u1], [q, v]) = (drive.now.u.array(), drive.now.q.array());
    evaluate(drive, &[u, u1, 0.0, 0.0, 0.0], which, &Flow { phi: 0.0, w: drive.now.w, a: 0.0, q, v })
}

/// Shows the outputs that are made of the moment by a few operations, without a division; whether they are finite.
#[inline(always)]
pub(super) fn show(drive: &ElasticOutput, board: &mut Board) -> bool {
    let mut show = |which: Output| {
        let value = at_hand(drive, which);
        board.show(which as usize, value);
        value
    };
    show(Output::X);
    show(Output::Y);
    show(Output::Q);
    show(Output::QDot);
    show(Output::Force);
    // U and U′ are bounded, w is finite: where these two are finite, all are.
    (show(Output::YDot) + show(Output::Tau)).abs() <= f64::MAX
}

fn series(drive: &ElasticOutput, seed: Seed, which: usize) -> Series {
    let position = drive.position();
    let flow = match seed {
        Seed::Time => along_time(drive, &position),
        Seed::Known(reference) => along_known(drive, &position, reference),
    };
    evaluate(drive, &position.u, OUTPUTS[which], &flow)
}

/// Drive and mass as functions of time.
fn along_time(drive: &ElasticOutput, position: &Position) -> Flow<Series> {
    let [phi, w, a, jerk, snap] = position.phi;
    let [q, v] = drive.now.q.array();
    let [.., x2, x3, _] = position.lift().0;
    let (omega2, damping) = (drive.c / drive.m, drive.b / drive.m);
    // The equation of motion and its time derivative.
    let q2 = -(omega2 * q + damping * v) - x2;
    let q3 = -(omega2 * v + damping * q2) - x3;
    Flow {
        phi: Series::from_derivatives(phi, w, a),
        w: Series::from_derivatives(w, a, jerk),
        a: Series::from_derivatives(a, jerk, snap),
        q: Series::from_derivatives(q, v, q2),
        v: Series::from_derivatives(v, q2, q3),
    }
}

/// Drive and mass as functions of one input or state, the others held: q = y − U(φ), q̇ = ẏ − U′(φ) ω.
fn along_known(drive: &ElasticOutput, position: &Position, reference: usize) -> Flow<Series> {
    let first_state = list(drive).reference("y").unwrap_or(usize::MAX - 1);
    let input = |n: usize| if drive.cam.is_input() && reference == n { 1.0 } else { 0.0 };
    let state = |n: usize| if reference == first_state + n { 1.0 } else { 0.0 };
    let [phi, w, a, ..] = position.phi;
    let [_, u1, u2, ..] = position.u;
    let [q, v] = drive.now.q.array();
    Flow {
        phi: Series([phi, input(0), 0.0]),
        w: Series([w, input(1), 0.0]),
        a: Series([a, input(2), 0.0]),
        q: Series([q, state(0) - u1 * input(0), 0.0]),
        v: Series([v, state(1) - u2 * w * input(0) - u1 * input(1), 0.0]),
    }
}
