//! The drive that a scene describes: its sections → the `Scene` of one of the drive models.

use super::section::{Faults, NOT_NEGATIVE, POSITIVE, Section, within};
use super::{Resolved, diagnostics::Diagnostic, units};
use super::{follower, geometry, motion_law, parametric};
use camdrive::drives::cam_drive::{DriveMode, Start, StartMode};
use camdrive::drives::rigid_machine::{self, Follower, InertiaFunction, MachineStart, Motor};
use camdrive::drives::solver::{LONGEST_STEP_SIZE, Method, Settings};
use camdrive::drives::unit::{self, Quantity};
use camdrive::drives::variable::{Causality, Kind};
use camdrive::drives::{self, backlash, elastic_output, elastic_shaft};
use camdrive::motion::MotionLaw;
use serde_json::Value;
use std::path::Path;

/// What the FMU calls a value → where the scene has it.
pub type Names = &'static [(&'static str, &'static str)];

/// The model, its resolved scene as JSON, and the names of its values.
pub type Drive = (&'static str, Value, Names);

/// Reads the sections of a model.
type Reader = fn(&Section<'_>, &Path) -> Option<Drive>;

const MODELS: &[(&[&str], Reader)] = &[
    (&["ElasticCamDrive"], elastic_cam_drive),
    (&["BacklashDrive"], backlash_drive),
    (&["RigidMachine"], rigid_machine),
    (&["ParametricDrive"], |root, _| parametric::read(root)),
];

/// What people write for the keys.
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

/// What all cam drives have.
struct CamDrive {
    cam: MotionLaw,
    drive: DriveMode,
    start: Start,
    solver: Settings,
}

/// Reads `[cam]`, `[drive]`, `[start]` and `[solver]`; q is a length or an angle. The law comes apart, since the
/// natural frequency of a shaft needs it.
fn cam(root: &Section<'_>, folder: &Path) -> Option<MotionLaw> {
    // Beside a cam there may be its geometry, which is read when the law is known.
    root.has(geometry::KEY);
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
        let w = section.real("speed", &unit::ANGULAR_VELOCITY, within(-1e6, 1e6));
        let phi_start = section.real_or("phi_start", &unit::ANGLE, within(-1e15, 1e15), 0.0);
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

/// Stiffness and damping, given themselves or by natural frequency and damping ratio of the mass (or inertia) `mass`.
pub fn spring(
    section: &Section<'_>,
    mass: Option<f64>,
    stiffness: &'static Quantity,
    damping: &'static Quantity,
) -> (Option<f64>, Option<f64>) {
    let c = match either(section, "c", "natural_frequency") {
        false => None,
        true if section.has("natural_frequency") => {
            let w0 = section.real("natural_frequency", &unit::ANGULAR_VELOCITY, POSITIVE);
            w0.zip(mass).map(|(w0, mass)| mass * w0 * w0)
        }
        true => section.real("c", stiffness, POSITIVE),
    };
    let b = match either(section, "b", "damping_ratio") {
        false => None,
        true if section.has("damping_ratio") => {
            let ratio = section.real("damping_ratio", &unit::NUMBER, NOT_NEGATIVE);
            ratio.zip(c).zip(mass).map(|((ratio, c), mass)| 2.0 * ratio * (c * mass).sqrt())
        }
        true => section.real_or("b", damping, NOT_NEGATIVE, 0.0),
    };
    (c, b)
}

fn elastic_cam_drive(root: &Section<'_>, folder: &Path) -> Option<Drive> {
    let in_shaft: &[(&[&str], bool)] = &[(&["output", "output_member"], false), (&["shaft", "input_shaft"], true)];
    let section = root.required_section("elasticity");
    let place = section.as_ref().and_then(|s| s.choice("place", in_shaft));
    let cam = cam(root, folder);
    let elastic = section.as_ref().zip(place).and_then(|(section, place)| {
        let values = if place { elastic_shaft(section, cam.as_ref()) } else { elastic_output(section) };
        section.finish(SYNONYMS);
        values
    });
    let common = cam_drive(root, cam, place == Some(true));
    let (CamDrive { cam, drive, start, solver }, elastic) = (common?, elastic?);
    match elastic {
        Elastic::Output { m, c, b } => {
            let scene = elastic_output::Scene { m, c, b, cam, drive, start, solver };
            resolved::<elastic_output::ElasticOutput>(&scene, ELASTICITY)
        }
        Elastic::Shaft { m, inertia, c, b, linear } => {
            let scene = elastic_shaft::Scene { m, inertia, c, b, linear, cam, drive, start, solver };
            resolved::<elastic_shaft::ElasticShaft>(&scene, ELASTICITY)
        }
    }
}

/// The model's name and its scene as JSON; numbers are written such that they are read back to the same bits.
pub fn resolved<D: drives::Drive>(scene: &D::Scene, names: Names) -> Option<Drive> {
    Some((D::MODEL, serde_json::to_value(scene).ok()?, names))
}

enum Elastic {
    Output { m: f64, c: f64, b: f64 },
    Shaft { m: f64, inertia: f64, c: f64, b: f64, linear: bool },
}

fn elastic_output(section: &Section<'_>) -> Option<Elastic> {
    let m = section.real("m", &unit::MASS, POSITIVE);
    let (c, b) = spring(section, m, &unit::STIFFNESS, &unit::DAMPING);
    let shaft = "the elasticity is in the output member";
    forbid(section, &["J", "linear"], shaft, "place = \"shaft\"");
    Some(Elastic::Output { m: m?, c: c?, b: b? })
}

fn elastic_shaft(section: &Section<'_>, cam: Option<&MotionLaw>) -> Option<Elastic> {
    let m = section.real("m", &unit::MASS, POSITIVE);
    let inertia = section.real("J", &unit::INERTIA, POSITIVE);
    let mean = m.zip(inertia).zip(cam).map(|((m, j), cam)| j + m * motion_law::mean_square_slope(cam));
    let (c, b) = spring(section, mean, &unit::ROTATIONAL_STIFFNESS, &unit::ROTATIONAL_DAMPING);
    let linear = section.boolean_or("linear", false);
    Some(Elastic::Shaft { m: m?, inertia: inertia?, c: c?, b: b?, linear: linear? })
}

fn backlash_drive(root: &Section<'_>, folder: &Path) -> Option<Drive> {
    let cam = cam(root, folder);
    let values = root.required_section("backlash").and_then(|section| {
        let m1 = section.real("m1", &unit::MASS, POSITIVE);
        let m2 = section.real("m2", &unit::MASS, POSITIVE);
        let (c, b) = spring(&section, m2, &unit::STIFFNESS, &unit::DAMPING);
        let s = section.real("s", &unit::LENGTH, NOT_NEGATIVE);
        let e = section.real_or("e", &unit::NUMBER, within(0.0, 1.0), 0.0);
        section.finish(SYNONYMS);
        Some([m1?, m2?, c?, b?, s?, e?])
    });
    let (CamDrive { cam, drive, start, solver }, [m1, m2, c, b, s, e]) = cam_drive(root, cam, false).zip(values)?;
    let scene = backlash::Scene { m1, m2, c, b, s, e, cam, drive, start, solver };
    resolved::<backlash::BacklashDrive>(&scene, BACKLASH)
}

fn rigid_machine(root: &Section<'_>, folder: &Path) -> Option<Drive> {
    let inertia = root.required_section("machine").and_then(|section| {
        let constant = section.real("J0", &unit::INERTIA, POSITIVE);
        let varying = section.read("J", |section| motion_law::read(section, &unit::INERTIA, folder));
        section.finish(SYNONYMS);
        constant.zip(varying)
    });
    let followers = root.sections("follower").and_then(|list| {
        let followers: Vec<Option<Follower>> = list.iter().map(|section| follower::read(section, folder)).collect();
        followers.into_iter().collect::<Option<Vec<Follower>>>()
    });
    let motor = root.read("motor", motor).map(|motor| motor.unwrap_or(Motor::None));
    let start = machine_start(root);
    let solver = solver(root);
    let (constant, varying) = inertia?;
    let (mode, phi_start, w_start) = start?;
    let scene = rigid_machine::Scene {
        inertia: InertiaFunction { constant, varying },
        followers: followers?,
        motor: motor?,
        phi_start,
        w_start,
        start: mode,
        solver: solver?,
    };
    resolved::<rigid_machine::RigidMachine>(&scene, MACHINE)
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
            let torque = section.real("M_k", &unit::TORQUE, POSITIVE);
            let slip = section.real("s_k", &unit::NUMBER, POSITIVE);
            let speed = section.real("w_s", &unit::ANGULAR_VELOCITY, within(-1e6, 1e6));
            let lag = section.optional("lag", &unit::TIME, POSITIVE);
            if speed == Some(0.0) {
                let fault = section.fault_of("w_s", "`motor.w_s`: 0 is no synchronous speed: the slip is not defined");
                section.faults.report(fault.hint("choose kind = \"none\" for a motor that is off"));
            }
            torque.zip(slip).zip(speed).zip(lag).map(|(((torque, slip), speed), lag)| Motor::Kloss {
                breakdown_torque: torque,
                breakdown_slip: slip,
                synchronous_speed: speed,
                dynamics: lag,
            })
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
    let phi = section.real_or("phi_start", &unit::ANGLE, within(-1e15, 1e15), 0.0);
    let w = section.real_or("w_start", &unit::ANGULAR_VELOCITY, within(-1e6, 1e6), 0.0);
    section.finish(&[("phi", "phi_start"), ("w", "w_start"), ("speed", "w_start")]);
    Some((mode?, phi?, w?))
}

const ELASTICITY: Names = &[
    ("m", "elasticity.m"),
    ("J", "elasticity.J"),
    ("c", "elasticity.c"),
    ("c", "elasticity.natural_frequency"),
    ("b", "elasticity.b"),
    ("b", "elasticity.damping_ratio"),
    ("shaft.linear", "elasticity.linear"),
    ("drive.w", "drive.speed"),
];
const BACKLASH: Names = &[
    ("m1", "backlash.m1"),
    ("m2", "backlash.m2"),
    ("c", "backlash.c"),
    ("c", "backlash.natural_frequency"),
    ("b", "backlash.b"),
    ("b", "backlash.damping_ratio"),
    ("s", "backlash.s"),
    ("e", "backlash.e"),
    ("drive.w", "drive.speed"),
];
const MACHINE: Names = &[
    ("J0", "machine.J0"),
    ("motor.T_el", "motor.lag"),
    ("phi_start", "start.phi_start"),
    ("w_start", "start.w_start"),
];

/// Builds and starts the drive, and checks its parameters against the ranges that the FMU declares, so that no FMU
/// is written that refuses its own start values.
pub fn try_out(resolved: &Resolved, names: Names, faults: &Faults<'_>) {
    let place = |variable: &str| {
        let paths = names.iter().filter(|(name, _)| *name == variable).map(|(_, path)| *path);
        paths.chain([variable]).find_map(|path| faults.place(path).map(|span| (path.to_owned(), span)))
    };
    let report = |message: String, admissible: Option<String>| {
        let mut fault: Diagnostic = match place(subject(&message)) {
            Some((path, span)) if path != subject(&message) => {
                let own = format!("`{}`: ", subject(&message));
                faults.at(span, format!("`{path}`: {}", message.strip_prefix(&own).unwrap_or(&message)))
            }
            Some((_, span)) => faults.at(span, message),
            None => faults.at(faults.place("model").unwrap_or(0..0), message),
        };
        fault.admissible = admissible;
        faults.report(fault);
    };
    let mut drive = match resolved.resource().build() {
        Ok(drive) => drive,
        Err(fault) => return report(fault.0, None),
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
    let parameters: Vec<(usize, String, Kind)> = drive
        .descriptions()
        .iter()
        .enumerate()
        .filter(|(_, d)| d.causality == Causality::Parameter)
        .map(|(reference, d)| (reference, d.name.clone(), d.kind.clone()))
        .collect();
    for (reference, name, kind) in parameters {
        match (drive.get(reference), kind) {
            (Err(fault), _) => report(fault.0, None),
            (Ok(value), Kind::Real { quantity, min, max, .. }) if !(value >= min && value <= max) => {
                let unit = quantity.unit;
                let message = format!("`{name}`: {} {unit} is out of range", units::short(value));
                report(message, Some(within(min, max).words(unit)));
            }
            _ => {}
        }
    }
    if faults.is_empty() {
        drive.set_up(0.0, None);
        if let Err(fault) = drive.start() {
            report(fault.0, None);
        }
    }
}

/// The variable that a drive's fault is about: the first name in backticks, else the word that the message starts
/// with.
fn subject(message: &str) -> &str {
    let word = message.split([' ', ':', ',']).next().unwrap_or_default();
    message.split('`').nth(1).unwrap_or(word)
}
