//! The drive that a scene describes: its sections → the `Scene` of one of the drive models.

use super::Resolved;
use super::common::{self, Elastic, PLACES, drive_mode, elastic_output, solver, start};
use super::{coupling, forces, geometry, load, motion_law, parametric, train};
use crate::document::{Diagnostic, Faults, Section, limits::within, units};
use camdrive::drives::Fault;
use camdrive::drives::backlash;
use camdrive::drives::drive_train::{self, Follower, Joint, Machine, Names, Shaft};
use camdrive::drives::elastic_output as output;
use camdrive::drives::elastic_shaft;
use camdrive::drives::follower::rigid;
use camdrive::drives::rigid_machine::{self, MachineStart, Motor};
use camdrive::drives::settings::Settings;
use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use camdrive::drives::shaft::motor::{self, Source};
use camdrive::drives::unit;
use camdrive::drives::variable::{Causality, Kind};
use camdrive::motion::MotionLaw;
use camdrive_design::resource::Scene;
use std::path::Path;

/// Reads the sections of a model.
pub type Reader = fn(&Section<'_>, &Path) -> Option<Scene>;

/// The models with their readers.
pub const MODELS: &[(&str, Reader)] = &[
    ("ElasticCamDrive", elastic_cam_drive),
    ("BacklashDrive", backlash_drive),
    ("RigidMachine", rigid_machine),
    ("ParametricDrive", |root, folder| parametric::read(root, folder).map(Scene::from)),
    ("DriveTrain", |root, folder| train::read(root, folder).map(Scene::from)),
];

/// Reads the drive of a scene.
pub fn drive(root: &Section<'_>, folder: &Path) -> Option<Scene> {
    let drive = root.choice("model", MODELS).map(|read| read(root, folder));
    // The model determines which sections belong here.
    if drive.is_some() {
        root.finish();
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

/// Reads `[cam]`, `[drive]`, `[start]` and `[solver]`; q is a length or an angle. The law is separate, since the natural frequency
/// of a shaft needs it.
fn cam(root: &Section<'_>, folder: &Path) -> Option<MotionLaw> {
    // A cam may have a geometry and loads, which are read after the law.
    root.has(geometry::KEY);
    root.has(forces::KEY);
    root.has(load::KEY);
    motion_law::of_cam(root, &unit::LENGTH, folder)
}

fn cam_drive(root: &Section<'_>, cam: Option<MotionLaw>, angular: bool) -> Option<CamDrive> {
    let drive = root.required_section("drive").and_then(|s| drive_mode(&s));
    let start = start(root, angular);
    let solver = solver(root);
    Some(CamDrive { cam: cam?, drive: drive?, start: start?, solver: solver? })
}

fn elastic_cam_drive(root: &Section<'_>, folder: &Path) -> Option<Scene> {
    let section = root.required_section("elasticity");
    let place = section.as_ref().and_then(|s| s.choice("place", PLACES));
    let cam = cam(root, folder);
    let elastic = section.as_ref().zip(place).and_then(|(section, in_shaft)| {
        let values = if in_shaft { common::elastic_shaft(section, cam.as_ref()) } else { elastic_output(section) };
        section.finish();
        values
    });
    let coupling = coupling::of_drive(
        root,
        match &elastic {
            Some(Elastic::Output(_, 0.0)) => {
                Err("set the mass on the cam's side, `elasticity.m_roller`; the elastic mass must not count")
            }
            Some(Elastic::Shaft(..)) => Err("remove it and connect tau: the cam turns after an elastic shaft"),
            _ => Ok(()),
        },
    );
    let roller = section.is_some_and(|section| section.has("m_roller"));
    let loads = load::beside_cam(root, cam.as_ref(), roller, folder);
    let common = cam_drive(root, cam, place == Some(true));
    let (CamDrive { cam, drive, start, solver }, elastic, [load, roller]) = (common?, elastic?, loads?);
    let coupling = coupling?;
    match elastic {
        Elastic::Output(parameters, m_roller) => {
            let roller = (m_roller, roller);
            Some(output::Scene { parameters, load, roller, coupling, cam, drive, start, solver }.into())
        }
        Elastic::Shaft(parameters, linear) => {
            Some(elastic_shaft::Scene { parameters, linear, load, cam, drive, start, solver }.into())
        }
    }
}

fn backlash_drive(root: &Section<'_>, folder: &Path) -> Option<Scene> {
    let cam = cam(root, folder);
    let loads = load::beside_cam(root, cam.as_ref(), true, folder);
    let parameters = root.required_section("backlash").and_then(|section| train::clearance(&section, loads.as_ref()));
    let common = cam_drive(root, cam, false);
    let coupling = coupling::of_drive(root, Ok(()));
    let (CamDrive { cam, drive, start, solver }, parameters, [load, roller]) = (common?, parameters?, loads?);
    let coupling = coupling?;
    if load.is_none() && roller.is_none() && parameters.s.is_finite() {
        return Some(backlash::Scene { parameters, cam, drive, coupling, start, solver }.into());
    }
    let mode = match start.mode {
        StartMode::Given if parameters.m2 == 0.0 => {
            let fault = root.fault_at("start.mode", ": without `m2` there is no spring for q");
            return root.refuse(fault.of("start.mode").admissible("at_rest, steady_state, equilibrium"));
        }
        StartMode::Given => drive_train::Start::Given,
        StartMode::AtRest => drive_train::Start::AtRest,
        StartMode::SteadyState => drive_train::Start::SteadyState,
        StartMode::Equilibrium => drive_train::Start::Equilibrium,
    };
    let follower = Follower { rigid: rigid::Follower::new(0.0, cam), joint: Joint::Backlash(parameters), load, roller };
    let scene = drive_train::Scene {
        shaft: Shaft::Driven(drive),
        followers: vec![follower],
        start: mode,
        coupling,
        solver: train::solver(root)?,
        names: Names::Backlash([start.q, start.q_dot]),
    };
    Some(scene.into())
}

fn rigid_machine(root: &Section<'_>, folder: &Path) -> Option<Scene> {
    let start = machine_start(root);
    let machine = train::machine(root, start.map(|(_, phi, w)| [phi, w]), folder);
    let followers = train::followers(root, |section| {
        let because = "the followers of a RigidMachine are rigid";
        section.forbid(&["elasticity", "backlash"], because, "model = \"DriveTrain\"");
        train::one(section, folder)
    });
    for (key, said, hint) in [
        ("motor.coupling", ": the rotor would not follow the shaft", "choose model = \"DriveTrain\""),
        ("motor.belt", ": the rotor would not follow the shaft", "choose model = \"DriveTrain\""),
        ("machine.load.input", ": a RigidMachine always has the input tau", "remove it"),
    ] {
        if let Some(place) = root.faults.place(key) {
            root.faults.report(root.faults.at(place, said).of(key).hint(hint));
        }
    }
    let loads = coupling::of_machine(root, true);
    let solver = solver(root);
    let loads = loads?;
    let (machine, followers, (mode, phi_start, w_start)) = (machine?, followers?, start?);
    let plain = match &machine.motor {
        motor::Motor { transmission, .. } if *transmission != Default::default() => None,
        _ if machine.load.is_some() || machine.friction.is_some() => None,
        _ if followers.iter().any(|follower| !follower.load.is_none()) => None,
        motor => match motor.source {
            Source::None => Some(Motor::None),
            Source::Input => Some(Motor::Input),
            Source::Kloss(kloss) => Some(Motor::Kloss(kloss)),
            _ => None,
        },
    };
    if let Some(motor) = plain {
        let followers = followers.into_iter().map(|follower| follower.rigid).collect();
        let inertia = machine.inertia;
        let scene =
            rigid_machine::Scene { inertia, followers, motor, loads, phi_start, w_start, start: mode, solver: solver? };
        return Some(scene.into());
    }
    coupling::refuse_inertia(root, &loads)?;
    let steady = mode == MachineStart::SteadyState;
    let scene = drive_train::Scene {
        shaft: Shaft::Free(Machine { loads, ..machine }),
        followers,
        start: if steady { drive_train::Start::SteadyState } else { drive_train::Start::AtRest },
        coupling: false,
        solver: train::solver(root)?,
        names: Names::Machine(0.0),
    };
    Some(scene.into())
}

fn machine_start(root: &Section<'_>) -> Option<(MachineStart, f64, f64)> {
    let Some(section) = root.section("start")? else { return Some((MachineStart::Given, 0.0, 0.0)) };
    let modes: &[(&str, MachineStart)] = &[("given", MachineStart::Given), ("steady_state", MachineStart::SteadyState)];
    let mode = section.choice_or("mode", modes, MachineStart::Given);
    let [phi, w] = ["phi_start", "w_start"].map(|key| section.real(key));
    section.finish();
    Some((mode?, phi?, w?))
}

/// Builds and starts the drive, and checks its parameters against the ranges in the FMU, so that no FMU refuses its own start
/// values.
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
    coupling::check_names(&resolved.scene, &parameters, faults);
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

#[cfg(test)]
mod tests;
