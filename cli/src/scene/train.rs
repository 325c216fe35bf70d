//! The scene of a `DriveTrain`: a shaft with its motor or a prescribed motion, and all followers on it.

use super::common::{self, Elastic, by_ratio};
use super::load::{self, Carrier};
use super::{coupling, follower};
use super::{motion_law, motor};
use crate::document::Section;
use camdrive::drives::backlash;
use camdrive::drives::drive_train::{Follower, Joint, MOST_FOLLOWERS, Machine, Names, Scene, Shaft, Stand, Start};
use camdrive::drives::follower::load::Load;
use camdrive::drives::rigid_machine::NamedLoad;
use camdrive::drives::settings::{Method, Settings};
use camdrive::motion::MotionLaw;
use std::path::Path;

/// The scene.
pub fn read(root: &Section<'_>, folder: &Path) -> Option<Scene> {
    let [driven, free] = ["drive", "machine"].map(|key| root.has(key));
    if driven == free && !root.faults.broken() {
        let (key, said) = if driven {
            ("machine", ": the drive prescribes the motion already")
        } else {
            ("model", " or `drive` is missing")
        };
        let fault = root.fault_at(key, said).of("machine");
        root.faults.report(
            fault.hint(
                "give [machine] for a shaft with inertia and motor, or [drive] for a prescribed motion, not both",
            ),
        );
    }
    let start = start(root, driven);
    let shaft = if driven {
        root.forbid(&["motor"], "the drive prescribes the motion", "[machine] instead of [drive]");
        root.section("drive").and_then(|part| common::drive_mode(&part?)).map(Shaft::Driven)
    } else if free {
        let machine = machine(root, start.map(|(_, phi, w)| [phi, w]), folder);
        let plain = machine.as_ref().is_some_and(|machine| !machine.loads.is_empty());
        if plain && root.has(coupling::TORQUES) {
            let fault =
                root.fault_of(coupling::TORQUES, ": machine.load.input gives the shaft its only load tau already");
            root.faults.report(fault.hint("remove one of them"));
        }
        let loads = coupling::of_machine(root, plain).filter(|loads| coupling::refuse_inertia(root, loads).is_some());
        machine.zip(loads).map(|(machine, loads)| Shaft::Free(Machine { loads, ..machine }))
    } else {
        None
    };
    let followers = followers(root, |section| one(section, folder));
    let coupling = if driven {
        root.forbid(&[coupling::TORQUES], "the drive prescribes the motion", "[machine] instead of [drive]");
        let rigid = |follower: &Follower| {
            let heavy = follower.carried(&Stand::held()).any(|mass| mass.m > 0.0);
            heavy || !follower.rigid.linkage.is_empty()
        };
        let none = followers.as_ref().is_some_and(|followers| !followers.iter().any(rigid));
        let hint = "remove it and connect the torques of the followers, or give an elasticity its `m_roller`";
        coupling::of_drive(root, if none { Err(hint) } else { Ok(()) })
    } else {
        Some(false)
    };
    let solver = solver(root);
    let (shaft, coupling) = (shaft?, coupling?);
    Some(Scene { shaft, followers: followers?, start: start?.0, coupling, solver: solver?, names: Names::Train })
}

/// `[[follower]]`.
pub fn followers(root: &Section<'_>, one: impl FnMut(&Section<'_>) -> Option<Follower>) -> Option<Vec<Follower>> {
    let list = root.sections("follower");
    if list.as_ref().is_some_and(|list| list.len() > MOST_FOLLOWERS) {
        let fault = root.fault_of("follower", format!(": there are {} of them", list.map_or(0, |list| list.len())));
        root.faults.report(
            fault.admissible(format!("at most {MOST_FOLLOWERS}")).hint("divide the machine into several scenes"),
        );
    }
    root.each("follower", one)
}

/// `[solver]`.
pub fn solver(root: &Section<'_>) -> Option<Settings> {
    let solver = common::solver(root);
    if let Some(method) =
        root.faults.place("solver.method").filter(|_| solver.is_none_or(|s| s.method != Method::Adaptive))
    {
        let fault = root
            .faults
            .at(method, ": a train locates its events, which steps of equal cost do not allow")
            .of("solver.method");
        root.faults.report(fault.admissible("adaptive").hint("remove it"));
    }
    solver
}

/// `[machine]` and `[motor]`, with φ and φ̇ at the start.
pub fn machine(root: &Section<'_>, start: Option<[f64; 2]>, folder: &Path) -> Option<Machine> {
    let machine = root.required_section("machine").map(|section| {
        let inertia = common::inertia(&section, folder);
        let load = section.read(load::KEY, |part| {
            let torque = load::torque(part, "torque", folder);
            let friction = part.optional("friction");
            let input = part.flag("input");
            part.finish();
            Some((torque?, friction?, input?))
        });
        section.finish();
        inertia.zip(load)
    });
    let motor = root.section("motor").and_then(|section| match &section {
        Some(section) => motor::read(section, folder),
        None => Some(Default::default()),
    });
    let (inertia, load) = machine??;
    let (load, friction, input) = load.unwrap_or_default();
    let [phi_start, w_start] = start?;
    let loads = if input { vec![NamedLoad::default()] } else { Vec::new() };
    Some(Machine { inertia, load, friction, loads, motor: motor?, phi_start, w_start })
}

/// `[start]`.
fn start(root: &Section<'_>, driven: bool) -> Option<(Start, f64, f64)> {
    let Some(section) = root.section("start")? else { return Some((Start::AtRest, 0.0, 0.0)) };
    let modes: &[(&str, Start)] =
        &[("at_rest", Start::AtRest), ("equilibrium", Start::Equilibrium), ("steady_state", Start::SteadyState)];
    let mode = section.choice_or("mode", modes, Start::AtRest);
    if driven {
        section.forbid(&["phi_start", "w_start"], "[drive] prescribes the motion", "[machine] instead of [drive]");
    }
    let [phi, w] = ["phi_start", "w_start"].map(|key| section.real(key));
    section.finish();
    Some((mode?, phi?, w?))
}

/// One of `[[follower]]`.
pub fn one(section: &Section<'_>, folder: &Path) -> Option<Follower> {
    let (elastic, backlash) = (section.section("elasticity"), section.section("backlash"));
    let joint = if section.has("elasticity") { "elasticity" } else { "backlash" };
    let joined = section.has(joint);
    if section.has("elasticity") && section.has("backlash") {
        let fault = section.fault_of("backlash", ": the follower has an elasticity already");
        section
            .faults
            .report(fault.hint("the spring after the clearance is `backlash.c`; remove one of the two tables"));
    }
    if joined && section.has("linkage") {
        let fault = section.fault_of("linkage", format!(": mechanisms behind `{joint}` are not modelled"));
        section.faults.report(fault.hint(format!("remove `{joint}` or the mechanisms")));
    }
    let rigid = follower::read(section, joined.then_some(joint), folder);
    let (elastic, backlash) = (elastic?, backlash?);
    let roller = matches!(&elastic, Some(part) if part.has("m_roller")) || backlash.is_some();
    let mechanisms = section.sections("linkage").map_or(0, |list| list.len());
    let turns = rigid.as_ref().map_or(section.has("J"), |rigid| rigid.turns);
    let loads = load::read(section, Carrier { turns, mechanisms, follower: rigid.as_ref(), roller }, folder);
    let joint = match (&elastic, &backlash) {
        (Some(part), _) => elasticity(part, rigid.as_ref().map(|rigid| &rigid.cam)),
        (None, Some(part)) => clearance(part, loads.as_ref()).map(Joint::Backlash),
        (None, None) => Some(Joint::Rigid),
    };
    let [load, roller] = loads?;
    Some(Follower { rigid: rigid?, joint: joint?, load, roller })
}

fn elasticity(section: &Section<'_>, cam: Option<&MotionLaw>) -> Option<Joint> {
    let shaft = section.choice("place", common::PLACES)?;
    let elastic = if shaft { common::elastic_shaft(section, cam) } else { common::elastic_output(section) };
    section.finish();
    match elastic? {
        Elastic::Output(parameters, m_roller) => Some(Joint::Output(parameters, m_roller)),
        Elastic::Shaft(_, true) => {
            let fault = section.fault_of("linear", ": a train takes the whole equation of its shafts");
            section.refuse(fault.hint("remove it"))
        }
        Elastic::Shaft(parameters, false) => Some(Joint::Shaft(parameters)),
    }
}

/// `[backlash]`; with s = "inf" the follower may lift off its cam.
pub fn clearance(section: &Section<'_>, loads: Option<&[Load; 2]>) -> Option<backlash::Parameters> {
    let word = section.word("s");
    if let Some(other) = word.filter(|word| *word != "inf") {
        section.unknown_word("s", other, "inf");
    }
    let one_sided = word == Some("inf");
    let stiff = one_sided && section.real_or("m2", 0.0) == Some(0.0);
    if stiff {
        let because = "without `m2` there is no mass after the spring";
        section.forbid(&["c", "b", "natural_frequency", "damping_ratio"], because, "an `m2` above 0");
    }
    let parameters = section.parameters(|parameter, read: Option<&backlash::Parameters>| match parameter.key {
        "s" if word.is_some() => Some(one_sided.then_some(f64::INFINITY)),
        "m2" | "c" | "b" if stiff => Some(Some(0.0)),
        key => by_ratio(section, key, read.map(|read| (read.m2, read.c))),
    });
    section.finish();
    let parameters = parameters?;
    if parameters.s == 0.0 {
        let fault =
            section.fault_of("s", ": without clearance it is an elastic output with the mass m1 on the cam's side");
        return section
            .refuse(fault.admissible("greater than 0 m, or \"inf\"").hint("use `elasticity` with `m_roller`"));
    }
    if let Some([load, roller]) = loads.filter(|_| one_sided) {
        let springs = [load, roller].iter().any(|load| load.stiffness() > 0.0 || load.input);
        // Without a mass after the spring all loads act on m1.
        let tool = if stiff { parameters.m1 } else { parameters.m2 };
        let still = load.constant_part(tool) + roller.constant_part(parameters.m1);
        let process = load.process.as_ref().map_or(0.0, motion_law::least);
        if !springs && still + process >= 0.0 {
            let fault = section.fault_of("s", ": nothing brings the follower back to its cam");
            let place = section.path.replace("backlash", "load");
            let hint = format!(
                "add a spring, gravity or a force towards the cam in `{place}`, for example spring = {{ preload = \"90 N\" }}"
            );
            return section.refuse(fault.hint(hint));
        }
    }
    Some(parameters)
}

#[cfg(test)]
mod tests;
