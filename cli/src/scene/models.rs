//! The drive that a scene describes: its sections → the `Scene` of one of the drive models.

use super::section::{Faults, NOT_NEGATIVE, POSITIVE, Section, within};
use super::{Resolved, diagnostics::Diagnostic, units};
use super::{follower, forces, geometry, motion_law, parametric};
use camdrive::drives::backlash::{self, BacklashDrive};
use camdrive::drives::cam_drive::{DriveMode, Start, StartMode};
use camdrive::drives::elastic_output::{self, ElasticOutput};
use camdrive::drives::elastic_shaft::{self, ElasticShaft};
use camdrive::drives::limits::{FASTEST, LARGEST_ANGLE};
use camdrive::drives::parameter::Parameters as _;
use camdrive::drives::rigid_machine::{self, InertiaFunction, Kloss, MachineStart, Motor, RigidMachine};
use camdrive::drives::solver::{LONGEST_STEP_SIZE, Method, Settings};
use camdrive::drives::unit;
use camdrive::drives::variable::{Causality, Kind};
use camdrive::drives::{Fault, Reason};
use camdrive::motion::MotionLaw;
use serde_json::Value;
use std::path::Path;

/// The model and its resolved scene as JSON.
pub type Drive = (&'static str, Value);

/// Reads the sections of a model.
type Reader = fn(&Section<'_>, &Path) -> Option<Drive>;

const MODELS: &[(&[&str], Reader)] = &[
    (&["ElasticCamDrive"], elastic_cam_drive),
    (&["BacklashDrive"], backlash_drive),
    (&["RigidMachine"], rigid_machine),
    (&["ParametricDrive"], |root, _| parametric::read(root)),
];

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

/// Reads the drive of a scene.
pub fn drive(root: &Section<'_>, folder: &Path) -> Option<Drive> {
    let drive = root.choice("model", MODELS).map(|read| read(root, folder));
    // Which sections belong here is not known before the model is.
    if drive.is_some() {
        root.finish(SYNONYMS);
    }
    drive?
}

/// Parts of every cam drive.
struct CamDrive {
    cam: MotionLaw,
    drive: DriveMode,
    start: Start,
    solver: Settings,
}

/// Reads `[cam]`, `[drive]`, `[start]` and `[solver]`; q is a length or an angle. The law comes apart, since the
/// natural frequency of a shaft needs it.
fn cam(root: &Section<'_>, folder: &Path) -> Option<MotionLaw> {
    // Beside a cam there may be its geometry and its loads, which are read when the law is known.
    root.has(geometry::KEY);
    root.has(forces::KEY);
    root.required_section("cam").and_then(|s| motion_law::read(&s, &unit::LENGTH, folder))
}

fn cam_drive(root: &Section<'_>, cam: Option<MotionLaw>, angular: bool) -> Option<CamDrive> {
    let drive = root.required_section("drive").and_then(|s| drive_mode(&s));
    let start = start(root, angular);
    let solver = solver(root);
    Some(CamDrive { cam: cam?, drive: drive?, start: start?, solver: solver? })
}

/// Reads `[drive]`.
pub fn drive_mode(section: &Section<'_>) -> Option<DriveMode> {
    let by_inputs: &[(&[&str], bool)] = &[(&["constant", "constant_speed"], false), (&["input", "inputs"], true)];
    let drive = if section.choice_or("mode", by_inputs, false)? {
        forbid(section, &["speed", "phi_start"], "the inputs phi, w and a drive the cam", "mode = \"constant\"");
        Some(DriveMode::Input)
    } else {
        let w = section.real("speed", &unit::ANGULAR_VELOCITY, within(-FASTEST, FASTEST));
        let phi_start = section.real_or("phi_start", &unit::ANGLE, within(-LARGEST_ANGLE, LARGEST_ANGLE), 0.0);
        w.zip(phi_start).map(|(w, phi_start)| DriveMode::Constant { w, phi_start })
    };
    section.finish(SYNONYMS);
    drive
}

/// Reports keys that have no meaning because of another choice.
pub fn forbid(section: &Section<'_>, keys: &[&'static str], because: &str, needed: &str) {
    for &key in keys {
        if section.has(key) {
            let fault = section.fault_of(key, format!("`{}` has no meaning here: {because}", section.path_of(key)));
            section.faults.report(fault.hint(format!("remove it, or choose {needed}")));
        }
    }
}

/// Refuses two keys for one thing; false where both are there.
pub fn either(section: &Section<'_>, first: &'static str, second: &'static str) -> bool {
    let both = section.has(first) && section.has(second);
    if both {
        let message = format!("`{}`: `{first}` says the same already", section.path_of(second));
        section
            .faults
            .report(section.fault_of(second, message).hint(format!("give `{first}` or `{second}`, not both")));
    }
    !both
}

const START_MODES: &[(&[&str], StartMode)] = &[
    (&["at_rest"], StartMode::AtRest),
    (&["given"], StartMode::Given),
    (&["steady_state", "periodic"], StartMode::SteadyState),
];

/// Reads `[start]`.
pub fn start(root: &Section<'_>, angular: bool) -> Option<Start> {
    let rest = Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 };
    let Some(section) = root.section("start")? else { return Some(rest) };
    let (q, q_dot) = if angular { (&unit::ANGLE, &unit::ANGULAR_VELOCITY) } else { (&unit::LENGTH, &unit::VELOCITY) };
    let mode = section.choice_or("mode", START_MODES, StartMode::AtRest);
    let start = match mode? {
        StartMode::Given => {
            let q = section.real_or("q", q, within(-1e6, 1e6), 0.0);
            let q_dot = section.real_or("q_dot", q_dot, within(-1e9, 1e9), 0.0);
            q.zip(q_dot).map(|(q, q_dot)| Start { mode: StartMode::Given, q, q_dot })
        }
        mode => {
            forbid(&section, &["q", "q_dot"], "the mode decides it", "mode = \"given\"");
            Some(Start { mode, ..rest })
        }
    };
    section.finish(SYNONYMS);
    start
}

/// Reads `[solver]`.
pub fn solver(root: &Section<'_>) -> Option<Settings> {
    let Some(section) = root.section("solver")? else { return Some(Settings::default()) };
    let tolerance = section.real_or("tolerance", &unit::NUMBER, within(0.0, 1.0), 0.0);
    let methods: &[(&[&str], Method)] = &[(&["adaptive"], Method::Adaptive), (&["fixed_cost"], Method::FixedCost)];
    let method = section.choice_or("method", methods, Method::Adaptive);
    let step_size = match method {
        Some(Method::Adaptive) => {
            forbid(&section, &["step_size"], "solver.tolerance decides the steps", "method = \"fixed_cost\"");
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
        "c" if !either(section, "c", "natural_frequency") => Some(None),
        "c" if section.has("natural_frequency") => {
            let w0 = section.real("natural_frequency", &unit::ANGULAR_VELOCITY, POSITIVE);
            Some(w0.zip(on).map(|(w0, (mass, _))| mass * w0 * w0))
        }
        "b" if !either(section, "b", "damping_ratio") => Some(None),
        "b" if section.has("damping_ratio") => {
            let ratio = section.real("damping_ratio", &unit::NUMBER, NOT_NEGATIVE);
            Some(ratio.zip(on).map(|(ratio, (mass, c))| 2.0 * ratio * (c * mass).sqrt()))
        }
        _ => None,
    }
}

fn elastic_cam_drive(root: &Section<'_>, folder: &Path) -> Option<Drive> {
    let in_shaft: &[(&[&str], bool)] = &[(&["output", "output_member"], false), (&["shaft", "input_shaft"], true)];
    let section = root.required_section("elasticity");
    let place = section.as_ref().and_then(|s| s.choice("place", in_shaft));
    let cam = cam(root, folder);
    let elastic = section.as_ref().zip(place).and_then(|(section, in_shaft)| {
        let values = if in_shaft { elastic_shaft(section, cam.as_ref()) } else { elastic_output(section) };
        section.finish(SYNONYMS);
        values
    });
    let common = cam_drive(root, cam, place == Some(true));
    let (CamDrive { cam, drive, start, solver }, elastic) = (common?, elastic?);
    match elastic {
        Elastic::Output(parameters) => {
            resolved::<ElasticOutput>(&elastic_output::Scene { parameters, cam, drive, start, solver })
        }
        Elastic::Shaft(parameters, linear) => {
            resolved::<ElasticShaft>(&elastic_shaft::Scene { parameters, linear, cam, drive, start, solver })
        }
    }
}

/// The model's name and its scene as JSON; numbers are written such that they are read back to the same bits.
pub fn resolved<D: camdrive::drives::Drive>(scene: &D::Scene) -> Option<Drive> {
    Some((D::MODEL, serde_json::to_value(scene).ok()?))
}

enum Elastic {
    Output(elastic_output::Parameters),
    Shaft(elastic_shaft::Parameters, bool),
}

fn elastic_output(section: &Section<'_>) -> Option<Elastic> {
    let parameters = section.parameters(|parameter, read: Option<&elastic_output::Parameters>| {
        by_ratio(section, parameter.key, read.map(|read| (read.m, read.c)))
    });
    forbid(section, &["J", "linear"], "the elasticity is in the output member", "place = \"shaft\"");
    parameters.map(Elastic::Output)
}

fn elastic_shaft(section: &Section<'_>, cam: Option<&MotionLaw>) -> Option<Elastic> {
    let square = cam.map(motion_law::mean_square_slope);
    let parameters = section.parameters(|parameter, read: Option<&elastic_shaft::Parameters>| {
        let on = read.zip(square).map(|(read, square)| (read.inertia + read.m * square, read.c));
        by_ratio(section, parameter.key, on)
    });
    let linear = section.boolean_or("linear", false);
    parameters.zip(linear).map(|(parameters, linear)| Elastic::Shaft(parameters, linear))
}

fn backlash_drive(root: &Section<'_>, folder: &Path) -> Option<Drive> {
    let cam = cam(root, folder);
    let parameters = root.required_section("backlash").and_then(|section| {
        let parameters = section.parameters(|parameter, read: Option<&backlash::Parameters>| {
            by_ratio(&section, parameter.key, read.map(|read| (read.m2, read.c)))
        });
        section.finish(SYNONYMS);
        parameters
    });
    let (CamDrive { cam, drive, start, solver }, parameters) = cam_drive(root, cam, false).zip(parameters)?;
    resolved::<BacklashDrive>(&backlash::Scene { parameters, cam, drive, start, solver })
}

fn rigid_machine(root: &Section<'_>, folder: &Path) -> Option<Drive> {
    let inertia = root.required_section("machine").and_then(|section| {
        // An FMU may have J0 = 0 where J_v makes up for it.
        let own: Option<InertiaFunction> =
            section.parameters(|parameter, _| Some(section.real(parameter.key, parameter.quantity, POSITIVE)));
        let varying = section.read("J", |section| motion_law::read(section, &unit::INERTIA, folder));
        section.finish(SYNONYMS);
        own.zip(varying).map(|(own, varying)| InertiaFunction { varying, ..own })
    });
    let followers = root.each("follower", |section| follower::read(section, folder));
    let motor = root.read("motor", motor).map(|motor| motor.unwrap_or(Motor::None));
    let start = machine_start(root);
    let solver = solver(root);
    let (mode, phi_start, w_start) = start?;
    let scene = rigid_machine::Scene {
        inertia: inertia?,
        followers: followers?,
        motor: motor?,
        phi_start,
        w_start,
        start: mode,
        solver: solver?,
    };
    resolved::<rigid_machine::RigidMachine>(&scene)
}

fn motor(section: &Section<'_>) -> Option<Motor> {
    // That of Kloss has values of its own.
    let kinds: &[(&[&str], Option<Motor>)] = &[
        (&["none"], Some(Motor::None)),
        (&["kloss", "asynchronous", "induction"], None),
        (&["input", "torque"], Some(Motor::Input)),
    ];
    let motor = match section.choice("kind", kinds)? {
        None => {
            let kloss: Option<Kloss> = section.parameters(|parameter, _| {
                let value = section.parameter(parameter);
                if parameter.key == "w_s" && value == Some(0.0) {
                    let message = "`motor.w_s`: 0 is no synchronous speed: the slip is not defined";
                    let fault = section.fault_of("w_s", message);
                    section.faults.report(fault.hint("choose kind = \"none\" for a motor that is off"));
                }
                Some(value)
            });
            let lag = section.optional("lag", &unit::TIME, POSITIVE);
            kloss.zip(lag).map(|(kloss, dynamics)| Motor::Kloss(Kloss { dynamics, ..kloss }))
        }
        kind => {
            let keys = ["M_k", "s_k", "w_s", "lag"];
            forbid(section, &keys, "the kind of motor has no such value", "kind = \"kloss\"");
            kind
        }
    };
    section.finish(&[("type", "kind"), ("speed", "w_s"), ("time_constant", "lag"), ("dynamics", "lag")]);
    motor
}

fn machine_start(root: &Section<'_>) -> Option<(MachineStart, f64, f64)> {
    let Some(section) = root.section("start")? else { return Some((MachineStart::Given, 0.0, 0.0)) };
    let modes: &[(&[&str], MachineStart)] =
        &[(&["given"], MachineStart::Given), (&["steady_state", "periodic"], MachineStart::SteadyState)];
    let mode = section.choice_or("mode", modes, MachineStart::Given);
    let [phi, w] = [0, 1].map(|i| section.parameter(&RigidMachine::TABLE[i]));
    section.finish(&[("phi", "phi_start"), ("w", "w_start"), ("speed", "w_start")]);
    Some((mode?, phi?, w?))
}

/// Builds and starts the drive, and checks its parameters against the ranges that the FMU declares, so that no FMU
/// is written that refuses its own start values.
pub fn try_out(resolved: &Resolved, faults: &Faults<'_>) {
    let report = |fault: Fault, key: &str, admissible: Option<String>| {
        let Reason { variable, message } = *fault.0;
        let mut fault: Diagnostic = match faults.origin(key) {
            Some((path, span)) => {
                let said = message.strip_prefix(&format!("`{variable}`: "));
                faults.at(span, said.map_or(message.clone(), |said| format!("`{path}`: {said}")))
            }
            None => faults.at(faults.place("model").unwrap_or(0..0), message),
        };
        fault.admissible = admissible;
        faults.report(fault);
    };
    let mut drive = match resolved.resource().build() {
        Ok(drive) => drive,
        Err(fault) => return report(fault.clone(), &fault.variable, None),
    };
    for (name, reason) in [
        ("solver.method", "every step of this drive costs the same"),
        ("solver.tolerance", "the result of this drive is at rounding level anyway"),
    ] {
        if let Some(span) = faults.place(name)
            && drive.descriptions().iter().all(|d| d.name != name)
        {
            let message = format!("`{name}` has no meaning here: {reason}");
            faults.report(faults.at(span, message).hint("remove it"));
        }
    }
    let parameters = drive.descriptions().to_vec();
    for (reference, parameter) in parameters.iter().enumerate().filter(|(_, d)| d.causality == Causality::Parameter) {
        match (drive.get(reference), &parameter.kind) {
            (Ok(value), Kind::Real { quantity, min, max, .. }) if !(value >= *min && value <= *max) => {
                let unit = quantity.unit;
                let message = format!("`{}`: {} {unit} is out of range", parameter.name, units::short(value));
                let fault = Fault::new(message).of(&parameter.name);
                report(fault, &parameter.key, Some(within(*min, *max).words(unit)));
            }
            _ => {}
        }
    }
    if faults.is_empty() {
        drive.set_up(0.0, None);
        if let Err(fault) = drive.start() {
            let key = parameters.iter().find(|d| d.name == fault.variable).map_or(&fault.variable, |d| &d.key);
            report(fault.clone(), key, None);
        }
    }
}
