//! Sections and keys that several drive models share.

use super::motion_law;
use super::section::{NOT_NEGATIVE, POSITIVE, Section, within};
use camdrive::drives::limits::{FASTEST, LARGEST_ANGLE};
use camdrive::drives::rigid_machine::InertiaFunction;
use camdrive::drives::settings::{COARSEST_TOLERANCE, LONGEST_STEP_SIZE, Method, Settings};
use camdrive::drives::shaft::cam_drive::{DriveMode, LARGEST_START, Start, StartMode};
use camdrive::drives::unit;
use camdrive::drives::{elastic_output, elastic_shaft};
use camdrive::motion::MotionLaw;
use serde_json::Value;
use std::path::Path;

/// The model and its resolved scene as JSON.
pub type Drive = (&'static str, Value);

/// Synonyms of the keys.
pub const SYNONYMS: &[(&str, &str)] = &[
    ("clearance", "s"),
    ("restitution", "e"),
    ("stiffness", "c"),
    ("k", "c"),
    ("damping", "b"),
    ("d", "b"),
    ("D", "damping_ratio"),
    ("mass", "m"),
    ("inertia", "J"),
    ("w", "speed"),
    ("rpm", "speed"),
    ("n", "speed"),
    ("followers", "follower"),
    ("title", "name"),
    ("type", "model"),
    ("tol", "tolerance"),
];

/// Reads `[drive]`.
pub fn drive_mode(section: &Section<'_>) -> Option<DriveMode> {
    let by_inputs: &[(&[&str], bool)] = &[(&["constant", "constant_speed"], false), (&["input", "inputs"], true)];
    let drive = if section.choice_or("mode", by_inputs, false)? {
        section.forbid(&["speed", "phi_start"], "the inputs phi, w and a drive the cam", "mode = \"constant\"");
        Some(DriveMode::Input)
    } else {
        let w = section.real("speed", &unit::ANGULAR_VELOCITY, within(-FASTEST, FASTEST));
        let phi_start = section.real_or("phi_start", &unit::ANGLE, within(-LARGEST_ANGLE, LARGEST_ANGLE), 0.0);
        w.zip(phi_start).map(|(w, phi_start)| DriveMode::Constant { w, phi_start })
    };
    section.finish(SYNONYMS);
    drive
}

const START_MODES: &[(&[&str], StartMode)] = &[
    (&["at_rest"], StartMode::AtRest),
    (&["given"], StartMode::Given),
    (&["steady_state", "periodic"], StartMode::SteadyState),
    (&["equilibrium"], StartMode::Equilibrium),
];

/// Reads `[start]`.
pub fn start(root: &Section<'_>, angular: bool) -> Option<Start> {
    let rest = Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 };
    let Some(section) = root.section("start")? else { return Some(rest) };
    let (q, q_dot) = if angular { (&unit::ANGLE, &unit::ANGULAR_VELOCITY) } else { (&unit::LENGTH, &unit::VELOCITY) };
    let mode = section.choice_or("mode", START_MODES, StartMode::AtRest);
    let start = match mode? {
        StartMode::Given => {
            let [range, range_dot] = LARGEST_START.map(|most| within(-most, most));
            let q = section.real_or("q", q, range, 0.0);
            let q_dot = section.real_or("q_dot", q_dot, range_dot, 0.0);
            q.zip(q_dot).map(|(q, q_dot)| Start { mode: StartMode::Given, q, q_dot })
        }
        mode => {
            section.forbid(&["q", "q_dot"], "the mode decides it", "mode = \"given\"");
            Some(Start { mode, ..rest })
        }
    };
    section.finish(SYNONYMS);
    start
}

/// Reads `[solver]`.
pub fn solver(root: &Section<'_>) -> Option<Settings> {
    let Some(section) = root.section("solver")? else { return Some(Settings::default()) };
    let tolerance = section.real_or("tolerance", &unit::NUMBER, within(0.0, COARSEST_TOLERANCE), 0.0);
    let methods: &[(&[&str], Method)] = &[(&["adaptive"], Method::Adaptive), (&["fixed_cost"], Method::FixedCost)];
    let method = section.choice_or("method", methods, Method::Adaptive);
    let step_size = match method {
        Some(Method::Adaptive) => {
            section.forbid(&["step_size"], "solver.tolerance decides the steps", "method = \"fixed_cost\"");
            Some(0.0)
        }
        _ => section.real_or("step_size", &unit::TIME, within(0.0, LONGEST_STEP_SIZE), 0.0),
    };
    section.finish(SYNONYMS);
    Some(Settings { tolerance: tolerance?, method: method?, step_size: step_size? })
}

/// A stiffness `c` that is given by `natural_frequency`, and a damping `b` by `damping_ratio`, of the mass (or inertia) `mass` on
/// the stiffness.
pub fn by_ratio(section: &Section<'_>, key: &str, on: Option<(f64, f64)>) -> Option<Option<f64>> {
    match key {
        "c" if !section.either("c", "natural_frequency") => Some(None),
        "c" if section.has("natural_frequency") => {
            let w0 = section.real("natural_frequency", &unit::ANGULAR_VELOCITY, POSITIVE);
            Some(w0.zip(on).map(|(w0, (mass, _))| mass * w0 * w0))
        }
        "b" if !section.either("b", "damping_ratio") => Some(None),
        "b" if section.has("damping_ratio") => {
            let ratio = section.real("damping_ratio", &unit::NUMBER, NOT_NEGATIVE);
            Some(ratio.zip(on).map(|(ratio, (mass, c))| 2.0 * ratio * (c * mass).sqrt()))
        }
        _ => None,
    }
}

/// Where an elasticity is; whether it is in the shaft.
pub const PLACES: &[(&[&str], bool)] = &[(&["output", "output_member"], false), (&["shaft", "input_shaft"], true)];

/// An elastic member.
pub enum Elastic {
    /// Between cam and follower, and the mass on the cam's side (kg).
    Output(elastic_output::Parameters, f64),
    /// Before the cam, and whether its equation is linearised.
    Shaft(elastic_shaft::Parameters, bool),
}

/// Reads the values of an elastic output.
pub fn elastic_output(section: &Section<'_>) -> Option<Elastic> {
    let parameters = section.parameters(|parameter, read: Option<&elastic_output::Parameters>| {
        by_ratio(section, parameter.key, read.map(|read| (read.m, read.c)))
    });
    section.forbid(&["J", "linear"], "the elasticity is in the output member", "place = \"shaft\"");
    let m_roller = section.real_or("m_roller", &unit::MASS, within(0.0, 1e12), 0.0);
    parameters.zip(m_roller).map(|(parameters, m_roller)| Elastic::Output(parameters, m_roller))
}

/// Reads the values of an elastic shaft.
pub fn elastic_shaft(section: &Section<'_>, cam: Option<&MotionLaw>) -> Option<Elastic> {
    let square = cam.map(motion_law::mean_square_slope);
    let parameters = section.parameters(|parameter, read: Option<&elastic_shaft::Parameters>| {
        let on = read.zip(square).map(|(read, square)| (read.inertia + read.m * square, read.c));
        by_ratio(section, parameter.key, on)
    });
    let linear = section.boolean_or("linear", false);
    section.forbid(&["m_roller"], "the elasticity is in the input shaft", "place = \"output\"");
    parameters.zip(linear).map(|(parameters, linear)| Elastic::Shaft(parameters, linear))
}

/// J0 and J_v of a machine.
pub fn inertia(section: &Section<'_>, folder: &Path) -> Option<InertiaFunction> {
    // An FMU may have J0 = 0 where J_v makes up for it.
    let own: Option<InertiaFunction> =
        section.parameters(|parameter, _| Some(section.real(parameter.key, parameter.quantity, POSITIVE)));
    let varying = section.read("J", |section| motion_law::read(section, &unit::INERTIA, folder));
    own.zip(varying).map(|(own, varying)| InertiaFunction { varying, ..own })
}

/// The model's name and its scene as JSON; numbers are written such that they are read back to the same bits.
pub fn resolved<D: camdrive::drives::Drive>(scene: &D::Scene) -> Option<Drive> {
    Some((D::MODEL, serde_json::to_value(scene).ok()?))
}
