//! Sections and keys shared by several drive models.

use super::motion_law;
use crate::document::Section;
use camdrive::drives::rigid_machine::InertiaFunction;
use camdrive::drives::settings::{Method, Settings};
use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use camdrive::drives::unit;
use camdrive::drives::{elastic_output, elastic_shaft};
use camdrive::motion::MotionLaw;
use std::path::Path;

/// Whether the motion is an input, and whether the speed alone is.
pub const DRIVE_MODES: &[(&str, [bool; 2])] =
    &[("constant", [false; 2]), ("input", [true, false]), ("speed", [false, true])];

/// Reads `[drive]`.
pub fn drive_mode(section: &Section<'_>) -> Option<DriveMode> {
    let drive = match section.choice("mode", DRIVE_MODES)? {
        [true, _] => {
            section.forbid(&["speed", "phi_start"], "the inputs phi, w and a drive the cam", "mode = \"constant\"");
            Some(DriveMode::Input)
        }
        [_, true] => {
            section.forbid(&["speed"], "the input w is the speed", "mode = \"constant\"");
            section.real("phi_start").map(|phi_start| DriveMode::Speed { phi_start })
        }
        _ => section
            .real("speed")
            .zip(section.real("phi_start"))
            .map(|(w, phi_start)| DriveMode::Constant { w, phi_start }),
    };
    section.finish();
    drive
}

/// The start modes of a motion.
pub const START_MODES: &[(&str, StartMode)] = &[
    ("at_rest", StartMode::AtRest),
    ("given", StartMode::Given),
    ("steady_state", StartMode::SteadyState),
    ("equilibrium", StartMode::Equilibrium),
];

/// Reads `[start]`.
pub fn start(root: &Section<'_>, angular: bool) -> Option<Start> {
    let rest = Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 };
    let Some(section) = root.section("start")? else { return Some(rest) };
    section.turning(angular);
    let mode = section.choice_or("mode", START_MODES, StartMode::AtRest);
    let start = match mode? {
        StartMode::Given => {
            section.real("q").zip(section.real("q_dot")).map(|(q, q_dot)| Start { mode: StartMode::Given, q, q_dot })
        }
        mode => {
            section.forbid(&["q", "q_dot"], "the mode decides it", "mode = \"given\"");
            Some(Start { mode, ..rest })
        }
    };
    section.finish();
    start
}

/// The choices for internal steps.
pub const METHODS: &[(&str, Method)] = &[("adaptive", Method::Adaptive), ("fixed_cost", Method::FixedCost)];

/// Reads `[solver]`.
pub fn solver(root: &Section<'_>) -> Option<Settings> {
    let Some(section) = root.section("solver")? else { return Some(Settings::default()) };
    let tolerance = section.real("tolerance");
    let method = section.choice("method", METHODS);
    let step_size = match method {
        Some(Method::Adaptive) => {
            section.forbid(&["step_size"], "solver.tolerance decides the steps", "method = \"fixed_cost\"");
            Some(0.0)
        }
        _ => section.real("step_size"),
    };
    section.finish();
    Some(Settings { tolerance: tolerance?, method: method?, step_size: step_size? })
}

/// A stiffness `c` from `natural_frequency`, or a damping `b` from `damping_ratio`, for the mass (or inertia) `mass` on the
/// stiffness.
pub fn by_ratio(section: &Section<'_>, key: &str, on: Option<(f64, f64)>) -> Option<Option<f64>> {
    match key {
        "c" if !section.either("c", "natural_frequency") => Some(None),
        "c" if section.has("natural_frequency") => {
            let w0 = section.real("natural_frequency");
            Some(w0.zip(on).map(|(w0, (mass, _))| mass * w0 * w0))
        }
        "b" if !section.either("b", "damping_ratio") => Some(None),
        "b" if section.has("damping_ratio") => {
            let ratio = section.real("damping_ratio");
            Some(ratio.zip(on).map(|(ratio, (mass, c))| 2.0 * ratio * (c * mass).sqrt()))
        }
        _ => None,
    }
}

/// The places of an elasticity; true in the shaft.
pub const PLACES: &[(&str, bool)] = &[("output", false), ("shaft", true)];

/// An elastic member.
pub enum Elastic {
    /// Between cam and follower, and the mass on the cam's side (kg).
    Output(elastic_output::Parameters, f64),
    /// Before the cam, and whether the equation is linearised.
    Shaft(elastic_shaft::Parameters, bool),
}

/// Reads the values of an elastic output.
pub fn elastic_output(section: &Section<'_>) -> Option<Elastic> {
    let parameters = section.parameters(|parameter, read: Option<&elastic_output::Parameters>| {
        by_ratio(section, parameter.key, read.map(|read| (read.m, read.c)))
    });
    section.forbid(&["J", "linear"], "the elasticity is in the output member", "place = \"shaft\"");
    let m_roller = section.real("m_roller");
    parameters.zip(m_roller).map(|(parameters, m_roller)| Elastic::Output(parameters, m_roller))
}

/// Reads the values of an elastic shaft.
pub fn elastic_shaft(section: &Section<'_>, cam: Option<&MotionLaw>) -> Option<Elastic> {
    let square = cam.map(motion_law::mean_square_slope);
    let parameters = section.parameters(|parameter, read: Option<&elastic_shaft::Parameters>| {
        let on = read.zip(square).map(|(read, square)| (read.inertia + read.m * square, read.c));
        by_ratio(section, parameter.key, on)
    });
    let linear = section.flag("linear");
    section.forbid(&["m_roller"], "the elasticity is in the input shaft", "place = \"output\"");
    parameters.zip(linear).map(|(parameters, linear)| Elastic::Shaft(parameters, linear))
}

/// J0 and J_v of a machine.
pub fn inertia(section: &Section<'_>, folder: &Path) -> Option<InertiaFunction> {
    // An FMU may have J0 = 0 if J_v compensates for it.
    let own: Option<InertiaFunction> = section.parameters(|parameter, _| Some(section.real(parameter.key)));
    let varying = section.read("J", |section| motion_law::read(section, &unit::INERTIA, folder));
    own.zip(varying).map(|(own, varying)| InertiaFunction { varying, ..own })
}
