//! The variables of the drive.

use super::ParametricDrive;
use crate::drives::follower::equation::Equation;
use crate::drives::follower::flow::Flow;
use crate::drives::follower::parametric::Vibration;
use crate::drives::follower::parametric::coefficients::{Coefficients, Values};
use crate::drives::follower::parametric::crank::SecondCrank;
use crate::drives::follower::parametric::law::{Coordinate, CrankLaw, Law, SeriesLaw};
use crate::drives::parameter::Has;
use crate::drives::settings::HasSolver;
use crate::drives::shaft::cam_drive::{HasCamDrive, PHI, W};
use crate::drives::shaft::loads::{declare_force, declare_load};
use crate::drives::unit::{self, Quantity};
use crate::drives::variable::{real, real_within};
use crate::drives::{List, Seed};
use crate::motion::Fourier;
use crate::numerics::taylor::{Scalar, Series};
use std::f64::consts::TAU;
use std::sync::Arc;

/// The continuous quantities. The two states are ψ and ψ̇ if q counts from the drive, else q and q̇.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Output {
    Phi,
    W,
    Psi,
    PsiDot,
    PsiDotDot,
    Q,
    QDot,
    QDotDot,
    Transmitted,
    ParametricTorque,
    Stiffness,
}

/// The number of continuous quantities; `growth` follows them, then the statistics of the solver.
const OUTPUTS: usize = Output::Stiffness as usize + 1;

pub(super) fn list(drive: &ParametricDrive) -> List<ParametricDrive> {
    let mut list = List::default();
    let law = &drive.cam.law;
    drive.declare_drive(&mut list);
    let turns = law.coordinate() == Coordinate::Rotation;
    declare_force(&mut list, drive, 0, "F", turns);
    if let Law::Crank(crank) = &**law {
        declare_crank(crank, &mut list);
    }
    let [q, q_dot, _] = quantities(law.coordinate());
    drive.declare_start(&mut list, q, q_dot);
    declare_load(&mut list, drive, 0, "load", turns);
    drive.declare_solver(&mut list, OUTPUTS + 1);
    declare_outputs(drive, &mut list);
    if !drive.cam.is_input() {
        let text = "Logarithmic growth of free vibrations per turn, ln of the largest modulus of the Floquet multipliers; \
                    positive where the drive is parametrically unstable";
        let [m, b, c, _] = names(law);
        list.discrete_output("growth", text, real(&unit::NUMBER)).at(OUTPUTS).depends_initially(&[
            &["drive.w", "load", "solver.tolerance"],
            m,
            b,
            c,
        ]);
    }
    declare_series(law, &mut list);
    list
}

/// Quantities of q, q̇ and q̈.
pub fn quantities(coordinate: Coordinate) -> [&'static Quantity; 3] {
    match coordinate {
        Coordinate::Rotation => [&unit::ANGLE, &unit::ANGULAR_VELOCITY, &unit::ANGULAR_ACCELERATION],
        Coordinate::Translation => [&unit::LENGTH, &unit::VELOCITY, &unit::ACCELERATION],
    }
}

/// Quantities of m, b, c and f.
pub fn of_coefficients(coordinate: Coordinate) -> [&'static Quantity; 4] {
    match coordinate {
        Coordinate::Rotation => [&unit::INERTIA, &unit::ROTATIONAL_DAMPING, &unit::ROTATIONAL_STIFFNESS, &unit::TORQUE],
        Coordinate::Translation => [&unit::MASS, &unit::DAMPING, &unit::STIFFNESS, &unit::FORCE],
    }
}

impl Has<CrankLaw> for ParametricDrive {
    fn group(&self) -> Option<&CrankLaw> {
        if let Law::Crank(crank) = &*self.cam.law { Some(crank) } else { None }
    }
    fn group_mut(&mut self) -> Option<&mut CrankLaw> {
        if let Law::Crank(crank) = Arc::make_mut(&mut self.cam.law) { Some(crank) } else { None }
    }
}

fn declare_crank(law: &CrankLaw, list: &mut List<ParametricDrive>) {
    list.group::<CrankLaw>();
    if law.crank.second != SecondCrank::None {
        list.parameter(
            "second.angle",
            "Angle by which the second crank runs ahead",
            real_within(&unit::ANGLE, -TAU, TAU),
            |d, _| match d.group().map(|law| law.crank.second) {
                Some(SecondCrank::OwnShafts(angle) | SecondCrank::SharedShafts(angle)) => angle,
                _ => 0.0,
            },
            |d, _, value| {
                let second = d.group_mut().map(|law| &mut law.crank.second);
                if let Some(SecondCrank::OwnShafts(angle) | SecondCrank::SharedShafts(angle)) = second {
                    *angle = value;
                }
            },
        )
        .key("crank.angle");
    }
}

/// The numbers of the coefficients of each series begin at a multiple of this.
const SERIES: usize = 1 << 16;

/// The series of the law that are parameters: letter, meaning, number of the quantity.
fn series(law: &Law) -> Vec<(&'static str, &'static str, usize)> {
    let load = ("f", "force", 3);
    match law {
        Law::Series(SeriesLaw { f, .. }) => {
            let own = [("m", "mass", 0), ("b", "damping", 1), ("c", "stiffness", 2)];
            own.into_iter().chain(f.as_ref().map(|_| load)).collect()
        }
        Law::Crank(CrankLaw { load: f, .. }) => f.iter().map(|_| load).collect(),
    }
}

/// The series of this number, to read and to change.
macro_rules! series {
    ($name:ident$(, $mut:tt)?) => {
        fn $name(law: &$($mut)? Law, which: usize) -> Option<&$($mut)? Fourier> {
            match (law, which) {
                (Law::Series(SeriesLaw { m, .. }), 0) => Some(m),
                (Law::Series(SeriesLaw { b, .. }), 1) => Some(b),
                (Law::Series(SeriesLaw { c, .. }), 2) => Some(c),
                (Law::Series(SeriesLaw { f, .. }), _) | (Law::Crank(CrankLaw { load: f, .. }), _) => f.into(),
            }
        }
    };
}
series!(series_of);
series!(series_mut, mut);

/// The first parts of the names of the parameters and of the input that determine m, b, c, and f with the loads.
fn names(law: &Law) -> [&'static [&'static str]; 4] {
    match law {
        Law::Series(_) => [&["m"], &["b"], &["c"], &["f", "load", "F"]],
        Law::Crank(_) => [&["J"], &["b_T"], &["c_T1", "c_T2", "c_AB", "R", "second"], &["f", "load", "F"]],
    }
}

/// Declares the coefficients of the series; last in the list, since their number depends on the scene.
fn declare_series(law: &Law, list: &mut List<ParametricDrive>) {
    for (letter, meaning, which) in series(law) {
        let meaning = match (which, law.coordinate()) {
            (0, Coordinate::Rotation) => "moment of inertia",
            (3, Coordinate::Rotation) => "torque",
            _ => meaning,
        };
        let quantity = of_coefficients(law.coordinate())[which];
        let section = match law {
            Law::Series(_) => format!("coefficients.{letter}"),
            Law::Crank(_) => "load".to_owned(),
        };
        let order = series_of(law, which).map_or(0, Fourier::order);
        let cosines = (0..=order).map(|k| ('a', "Cosine", k, k));
        for (part, kind, k, index) in cosines.chain((1..=order).map(|k| ('b', "Sine", k, order + k))) {
            let text = format!("{kind} coefficient of harmonic {k} of the {meaning}");
            list.parameter(
                &format!("{letter}.{part}[{k}]"),
                &text,
                real_within(quantity, -1e15, 1e15),
                |d, i| series_of(&d.cam.law, i / SERIES).and_then(|s| s.coefficient(i % SERIES)).unwrap_or(0.0),
                |d, i, value| {
                    let series = series_mut(Arc::make_mut(&mut d.cam.law), i / SERIES);
                    if let Some(coefficient) = series.and_then(|series| series.coefficient_mut(i % SERIES)) {
                        *coefficient = value;
                    }
                },
            )
            .at(which * SERIES + index)
            .key(&format!("{section}.{part}[{k}]"));
        }
    }
}

fn declare_outputs(drive: &ParametricDrive, list: &mut List<ParametricDrive>) {
    let (relative, coordinate) = (drive.cam.law.is_relative(), drive.cam.law.coordinate());
    let states = states(drive);
    let mut outputs = drive.outputs(list, states, series_along);
    outputs.add_shaft([Output::Phi as usize, Output::W as usize]);
    let mut output = |which: Output, name, text, quantity, known: &[&str], initial: &[&[&str]]| {
        outputs.add(which as usize, name, text, quantity, known).depends_initially(initial);
    };
    let [q, q_dot, q_dot_dot] = quantities(coordinate);
    let force = of_coefficients(coordinate)[3];
    let Coefficients { m, b, c, f } = &*drive.equation.coefficients;
    let [m, b, f] = [m, b, f].map(|series| 0 < series.order());
    let c = c.varies();
    let process = drive.equation.process();
    let f = f || process.is_some_and(|process| process.series().is_none_or(|series| 0 < series.order()));
    let input: &[&str] = if drive.force.is_some() { &["F"] } else { &[] };
    let with_states = |varies: bool| [&states[..], if varies { &["phi"] } else { &[] }].concat();
    let starts = |varies: bool| if varies { PHI } else { &[] };
    let [of_m, of_b, of_c, of_f] = names(&drive.cam.law);
    let periodic = drive.periodic_start(&[of_m, of_b, of_c, of_f, &["solver.tolerance"]].concat());
    // f and the loads have an equilibrium, even on inputs.
    let acts = drive.equation.load.is_some() || series_of(&drive.cam.law, 3).is_some();
    let balanced = if acts { [PHI, of_m, of_c, of_f].concat() } else { Vec::new() };
    let q_start = [&periodic[..], &balanced, &["start.mode", "start.q"]].concat();
    let v_start = [&periodic[..], &["start.mode", "start.q_dot"]].concat();
    if relative {
        let all_known: &[&str] = &["phi", "w", "psi", "der(psi)"];
        output(Output::Psi, "psi", "Angle of the driven side, phi + q", q, &["psi"], &[PHI, &q_start]);
        let text = "Angular velocity of the driven side";
        output(Output::PsiDot, "der(psi)", text, q_dot, &["der(psi)"], &[W, &v_start]);
        let text = "Angular acceleration of the driven side";
        let all: &[&[&str]] = &[PHI, &q_start, &v_start, of_m, of_b, of_c, of_f];
        output(Output::PsiDotDot, "der(psi,2)", text, q_dot_dot, &[all_known, input].concat(), all);
        output(Output::Q, "q", "Twist between both sides, psi - phi", q, &["phi", "psi"], &[&q_start]);
        output(Output::QDot, "der(q)", "Rate of the twist", q_dot, &["w", "der(psi)"], &[&v_start]);
        let text = "Torque from the drive into the driven side, -(c_T q + b_T der(q)); a positive tau loads the drive";
        let spring: &[&[&str]] = &[PHI, &q_start, &v_start, of_b, of_c];
        output(Output::Transmitted, "tau", text, force, all_known, spring);
        let text = "Torque of second order by which the drive feeds the vibration, c_T'(phi) q^2/2; tau + tau_parametric \
                    times w is the power from the drive";
        let psi: &[&str] = if c { &["phi", "psi"] } else { &[] };
        let varying: &[&[&str]] = if c { &[PHI, &q_start, of_c] } else { &[] };
        output(Output::ParametricTorque, "tau_parametric", text, &unit::TORQUE, psi, varying);
    } else {
        output(Output::Q, "q", "Coordinate of the vibration", q, &["q"], &[&q_start]);
        output(Output::QDot, "der(q)", "Rate of q", q_dot, &["der(q)"], &[&v_start]);
        let any = m || b || c || f;
        let all: &[&[&str]] = &[starts(any), &q_start, &v_start, of_m, of_b, of_c, of_f];
        let known = [&with_states(any)[..], input].concat();
        output(Output::QDotDot, "der(q,2)", "Second derivative of q", q_dot_dot, &known, all);
        let spring: &[&[&str]] = &[starts(b || c), &q_start, &v_start, of_b, of_c];
        let (name, text) = match coordinate {
            Coordinate::Rotation => ("tau", "Torque of spring and damper on the mass, -(c q + b der(q))"),
            Coordinate::Translation => ("force", "Force of spring and damper on the mass, -(c q + b der(q))"),
        };
        output(Output::Transmitted, name, text, force, &with_states(b || c), spring);
        let text = "Torque by which the drive feeds the vibration as m and c vary, (m'(phi) der(q)^2 + c'(phi) q^2)/2";
        let known: Vec<&str> =
            [(m || c, "phi"), (c, "q"), (m, "der(q)")].into_iter().filter(|s| s.0).map(|s| s.1).collect();
        let of_start = [(c, &q_start[..]), (c, of_c), (m, &v_start), (m, of_m), (m || c, PHI)];
        let of_start: Vec<&[&str]> = of_start.into_iter().filter(|s| s.0).map(|s| s.1).collect();
        output(Output::ParametricTorque, "tau_parametric", text, &unit::TORQUE, &known, &of_start);
    }
    let (text, stiffness) = ("Momentary stiffness c(phi)", of_coefficients(coordinate)[2]);
    output(Output::Stiffness, "stiffness", text, stiffness, if c { &["phi"] } else { &[] }, &[starts(c), of_c]);
}

/// The outputs, of numbers or of series, in the order of [`Output`].
fn outputs<S: Scalar>(drive: &ParametricDrive, values: &Values, f: &Flow<S>) -> [S; OUTPUTS] {
    let acceleration = drive.equation.acceleration(values, f);
    let (transmitted, parametric) = (values.transmitted(f), values.parametric_torque(f));
    let (psi, psi_dot, psi_dot_dot) = (f.phi + f.q, f.cam_speed(), acceleration + f.a);
    let stiffness = values.stiffness(f);
    [f.phi, f.w, psi, psi_dot, psi_dot_dot, f.q, f.v, acceleration, transmitted, parametric, stiffness]
}

pub(super) fn evaluate(drive: &ParametricDrive, places: &mut [f64]) {
    let (values, f) = drive.now(Vibration::at);
    places[..OUTPUTS].copy_from_slice(&outputs(drive, &values, &f));
    places[OUTPUTS] = drive.growth;
    places[OUTPUTS + 1..].copy_from_slice(&drive.statistics());
}

fn series_along(drive: &ParametricDrive, seed: Seed, which: usize) -> Series {
    let (values, f) = drive.now(Vibration::at);
    outputs(drive, &values, &drive.along(seed, *states(drive), &values, &f))[which]
}

/// Place and speed of the mass.
fn states(drive: &ParametricDrive) -> &'static [&'static str; 2] {
    if drive.equation.relative { &["psi", "der(psi)"] } else { &["q", "der(q)"] }
}
