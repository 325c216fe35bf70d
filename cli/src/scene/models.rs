//! The drive that a scene describes: its sections → the `Scene` of one of the drive models.

use super::common::{Drive, SYNONYMS, by_ratio, drive_mode, resolved, solver, start};
use super::section::{Faults, POSITIVE, Section, within};
use super::{Resolved, diagnostics::Diagnostic, units};
use super::{follower, forces, geometry, motion_law, parametric};
use camdrive::drives::Fault;
use camdrive::drives::backlash::{self, BacklashDrive};
use camdrive::drives::elastic_output::{self, ElasticOutput};
use camdrive::drives::elastic_shaft::{self, ElasticShaft};
use camdrive::drives::follower::load::Load;
use camdrive::drives::parameter::Parameters as _;
use camdrive::drives::rigid_machine::{self, InertiaFunction, Kloss, LAG, MachineStart, Motor, RigidMachine};
use camdrive::drives::settings::Settings;
use camdrive::drives::shaft::cam_drive::{DriveMode, Start};
use camdrive::drives::unit;
use camdrive::drives::variable::{Causality, Kind};
use camdrive::motion::MotionLaw;
use std::path::Path;

/// Reads the sections of a model.
type Reader = fn(&Section<'_>, &Path) -> Option<Drive>;

const MODELS: &[(&[&str], Reader)] = &[
    (&["ElasticCamDrive"], elastic_cam_drive),
    (&["BacklashDrive"], backlash_drive),
    (&["RigidMachine"], rigid_machine),
    (&["ParametricDrive"], |root, _| parametric::read(root)),
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
            let (load, roller) = (Load::default(), (0.0, Load::default()));
            resolved::<ElasticOutput>(&elastic_output::Scene { parameters, load, roller, cam, drive, start, solver })
        }
        Elastic::Shaft(parameters, linear) => resolved::<ElasticShaft>(&elastic_shaft::Scene {
            parameters,
            linear,
            load: Default::default(),
            cam,
            drive,
            start,
            solver,
        }),
    }
}

enum Elastic {
    Output(elastic_output::Parameters),
    Shaft(elastic_shaft::Parameters, bool),
}

fn elastic_output(section: &Section<'_>) -> Option<Elastic> {
    let parameters = section.parameters(|parameter, read: Option<&elastic_output::Parameters>| {
        by_ratio(section, parameter.key, read.map(|read| (read.m, read.c)))
    });
    section.forbid(&["J", "linear"], "the elasticity is in the output member", "place = \"shaft\"");
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
                    let fault = section.fault_of("w_s", ": 0 is not a synchronous speed: the slip is not defined");
                    section.faults.report(fault.hint("choose kind = \"none\" for a motor that is off"));
                }
                Some(value)
            });
            let lag = section.optional("lag", &unit::TIME, within(LAG[0], LAG[1]));
            kloss.zip(lag).map(|(kloss, dynamics)| Motor::Kloss(Kloss { dynamics, ..kloss }))
        }
        kind => {
            let keys = ["M_k", "s_k", "w_s", "lag"];
            section.forbid(&keys, "the kind of motor has no such value", "kind = \"kloss\"");
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
    let report = |fault: &Fault, key: &str, admissible: Option<String>| {
        let model = || (fault.variable.clone(), faults.place("model").unwrap_or(0..0));
        let (path, span) = faults.origin(key).unwrap_or_else(model);
        let told = Diagnostic { admissible, ..faults.at(span, &fault.message) };
        faults.report(if fault.named { told.of(path) } else { told });
    };
    let mut drive = match resolved.resource().build() {
        Ok(drive) => drive,
        Err(fault) => return report(&fault, &fault.variable, None),
    };
    for (name, reason) in [
        ("solver.method", "every step of this drive costs the same"),
        ("solver.tolerance", "the result of this drive is at rounding level"),
    ] {
        if let Some(span) = faults.place(name)
            && drive.descriptions().iter().all(|d| d.name != name)
        {
            faults.report(faults.at(span, format!(" has no meaning here: {reason}")).of(name).hint("remove it"));
        }
    }
    let parameters = drive.descriptions().to_vec();
    for (reference, parameter) in parameters.iter().enumerate().filter(|(_, d)| d.causality == Causality::Parameter) {
        if let (Ok(value), Kind::Real { quantity, min, max, .. }) = (drive.get(reference), &parameter.kind)
            && parameter.check(value).is_err()
        {
            let unit = quantity.unit;
            let fault = Fault::named(&parameter.name, format!(": {} {unit} is out of range", units::short(value)));
            report(&fault, &parameter.key, Some(within(*min, *max).words(unit)));
        }
    }
    if faults.is_empty() {
        drive.set_up(0.0, None);
        if let Err(fault) = drive.start() {
            let key = parameters.iter().find(|d| d.name == fault.variable).map_or(&fault.variable, |d| &d.key);
            report(&fault, key, None);
        }
    }
}
