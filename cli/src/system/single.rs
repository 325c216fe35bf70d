//! A system as one DriveTrain: the machine with its drives as followers.
//!
//! A drive that turns by i φ + φ₀ on the shaft φ has the law U(i φ + φ₀) there, and an elastic shaft before its cam has i² times
//! the inertia, stiffness and damping. The train's scene is TOML again and read like any other, so the reader reports everything
//! that it cannot be.

use super::{Connection, Content, INERTIA, MOTION, Part, Seat, System};
use crate::document::Document;
use crate::scene::{Resolved, resolve_document};
use camdrive::drives::drive_train::{self, Joint, Names, Shaft, Start};
use camdrive::drives::elastic_shaft::Parameters;
use camdrive::drives::rigid_machine::{self, MachineStart, Motor};
use camdrive::drives::shaft::cam_drive::StartMode;
use camdrive::drives::shaft::motor::Source;
use camdrive::drives::variable::{Causality, Kind as Type};
use camdrive::motion::MotionLaw;
use camdrive::motion::fourier::{Fourier, HIGHEST_HARMONIC};
use camdrive_design::coupling::study::Port;
use camdrive_design::resource::{LONGEST_NAME, Scene};
use std::f64::consts::TAU;
use std::path::Path;
use toml::{Table, Value};

/// The suffix of the name of a system's train.
const ENDING: &str = "_train";

/// The train of a system.
pub struct Single {
    /// Its scene.
    pub scene: Resolved,
    /// The number of each drive's first follower, from 1; 0 for the machine.
    followers: Vec<usize>,
}

impl System {
    /// The system as one DriveTrain.
    ///
    /// # Errors
    /// The reason why a train cannot be this system, in one sentence.
    pub fn train(&self) -> Result<Single, String> {
        let of = |part: &Part, said: String| format!("part {}: {said}", part.name);
        let machines: Vec<&Part> = self.parts.iter().filter(|part| part.seat.is_none()).collect();
        let [machine] = machines[..] else {
            return Err(format!("a train has one shaft, but {} parts sit on none", machines.len()));
        };
        if let Some(extra) = self.connections.iter().find(|connection| !self.is_of_shaft(connection)) {
            let [from, to] = [&extra.from, &extra.to].map(|(part, name)| format!("{}.{name}", self.parts[*part].name));
            return Err(format!("the connection from {from} to {to} is not between a shaft and its drive"));
        }
        let (mut document, scene) = started(machine).map_err(|said| of(machine, said))?;
        let mut start = begins(&scene).map_err(|said| of(machine, said))?;
        for key in ["description", "torques", "coupling"] {
            document.remove(key);
        }
        if scene.model_name() == "RigidMachine" {
            document.remove("solver");
        }
        let named = Some(format!("{}{ENDING}", self.name)).filter(|name| name.len() <= LONGEST_NAME);
        document.insert("name".to_owned(), named.unwrap_or_else(|| self.name.clone()).into());
        document.insert("description".to_owned(), format!("The system {} as one drive", self.name).into());
        document.insert("model".to_owned(), "DriveTrain".into());
        let mut followers = array(&mut document, "follower");
        let mut first = vec![0; self.parts.len()];
        for (i, part) in self.parts.iter().enumerate() {
            let Some(seat) = part.seat else { continue };
            first[i] = followers.len() + 1;
            let (own, begins) = on_shaft(part, seat).map_err(|said| of(part, said))?;
            if *start.get_or_insert(begins) != begins {
                return Err(of(part, "it starts differently from the other parts on the shaft".to_owned()));
            }
            followers.extend(own.into_iter().map(Value::Table));
        }
        document.insert("follower".to_owned(), Value::Array(followers));
        let mode = match start {
            None | Some(Start::AtRest | Start::Given) => "at_rest",
            Some(Start::Equilibrium) => "equilibrium",
            Some(Start::SteadyState) => "steady_state",
        };
        let own = document.entry("start").or_insert_with(|| Value::Table(Table::new()));
        own.as_table_mut().map(|start| start.insert("mode".to_owned(), mode.into()));
        let document = Document::new(toml::to_string(&document).map_err(|fault| fault.to_string())?);
        let scene = read(&document).map_err(|said| format!("as a train: {said}"))?;
        Ok(Single { scene, followers: first })
    }

    /// True if a connection is between a shaft and a drive on it.
    fn is_of_shaft(&self, Connection { from, to, .. }: &Connection) -> bool {
        let sits = |drive: usize, machine: usize| self.parts[drive].seat.is_some_and(|seat| seat.machine == machine);
        let down = sits(to.0, from.0) && MOTION.contains(&&*to.1);
        let torque = |name: &String| self.parts[from.0].torques().contains(name) || INERTIA.contains(&&**name);
        down || sits(from.0, to.0) && torque(&from.1)
    }
}

impl Single {
    /// The output of the train for an output of a part of the system; None if the train has no such output.
    pub fn counterpart(&self, system: &System, part: usize, name: &str) -> Option<Port> {
        let Part { content: Content::Scene(scene), seat, .. } = &system.parts[part] else { return None };
        let same = |name: String| Port { part: 0, name, factor: 1.0, offset: 0.0 };
        let Some(Seat { ratio, offset, .. }) = seat else {
            // A machine's own outputs exclude its drives.
            let shared = !["J", "E"].contains(&name);
            let tool = |name: &str| name.replace("U[", "follower[").replace(']', "].y");
            return shared.then(|| same(if name.contains("U[") { tool(name) } else { name.to_owned() }));
        };
        let first = self.followers[part];
        let (before, own) = name.strip_prefix("der(").map_or(("", name), |own| ("der(", own));
        let (j, own) = match own.strip_prefix("follower[").and_then(|rest| rest.split_once("].")) {
            Some((j, own)) => (j.parse::<usize>().ok()? - 1, own),
            None => (0, own),
        };
        let end = own.find([',', ')']).unwrap_or(own.len());
        let symbol = if &own[..end] == "x" { "U" } else { &own[..end] };
        let found = same(format!("{before}follower[{}].{symbol}{}", first + j, &own[end..]));
        let twist = ["q", "psi"].contains(&symbol) && shaft(&scene.scene, j).is_some();
        Some(match symbol {
            "tau" => Port { factor: ratio.recip(), ..found },
            "psi" if twist && before.is_empty() => Port { factor: *ratio, offset: *offset, ..found },
            _ if twist => Port { factor: *ratio, ..found },
            _ => found,
        })
    }
}

/// The scene of a document, whose tables are found from here.
fn read(document: &Document) -> Result<Resolved, String> {
    resolve_document("", document, Path::new("")).map_err(|faults| {
        let first = faults.0.into_iter().next();
        first.map_or_else(String::new, |fault| fault.message)
    })
}

/// The document of a part with its start values in the places of its scene, and its scene.
fn started(part: &Part) -> Result<(Table, Scene), String> {
    let Content::Scene(scene) = &part.content else { return Err("the content of an FMU is unknown".to_owned()) };
    let mut document = scene.document.clone();
    document.name_files(&|file| scene.folder.join(file).to_string_lossy().into_owned());
    let data = |document: &Document| toml::from_str(&document.whole_text()).map_err(|fault| fault.to_string());
    let before = read(&document)?.scene;
    if part.start.is_empty() {
        return Ok((data(&document)?, before));
    }
    let mut expected = parameters(&before)?;
    for (name, value) in &part.start {
        let about = part.description.variable(name).map(|v| &v.about);
        let set = about.filter(|about| !about.key.contains('[')).and_then(|about| {
            let value = match about.kind {
                Type::Enumeration(e) => toml_edit::Value::from(e.items.get((*value as usize).checked_sub(1)?)?.0),
                _ => toml_edit::Value::from(*value),
            };
            document.set(&about.key, value)?;
            expected.iter_mut().find(|(known, _)| known == name)
        });
        let (_, own) = set.ok_or_else(|| format!("`start` sets `{name}`, which a train does not have"))?;
        *own = *value;
    }
    let scene = read(&document).map_err(|said| format!("with its `start`: {said}"))?.scene;
    let found = parameters(&scene)?;
    let differs =
        |((name, a), (other, b)): &(&(String, f64), &(String, f64))| name != other || (a - b).abs() > 1e-12 * a.abs();
    match expected.iter().zip(&found).find(differs) {
        None => Ok((data(&document)?, scene)),
        Some(((name, _), _)) => Err(format!("no scene can have its `start`: `{name}` would differ")),
    }
}

/// The parameters of a scene.
fn parameters(scene: &Scene) -> Result<Vec<(String, f64)>, String> {
    let mut drive = scene.build().map_err(|fault| fault.to_string())?;
    let names: Vec<(usize, String)> = drive
        .descriptions()
        .iter()
        .enumerate()
        .filter(|(_, about)| about.causality == Causality::Parameter)
        .map(|(i, about)| (i, about.name.clone()))
        .collect();
    names.into_iter().map(|(i, name)| Ok((name, drive.get(i).map_err(|fault| fault.to_string())?))).collect()
}

/// Takes a list out of a document.
fn array(document: &mut Table, key: &str) -> Vec<Value> {
    if let Some(Value::Array(list)) = document.remove(key) { list } else { Vec::new() }
}

/// The start of a part in the shaft's scene; None without a part that could start differently.
fn begins(scene: &Scene) -> Result<Option<Start>, String> {
    let steady = "alone it starts in another periodic motion than with the parts on its shaft".to_owned();
    let of_drive = |mode: StartMode| match mode {
        StartMode::AtRest => Ok(Some(Start::AtRest)),
        StartMode::Equilibrium => Ok(Some(Start::Equilibrium)),
        StartMode::Given | StartMode::SteadyState => Err("a train has no such `start`".to_owned()),
    };
    match scene {
        Scene::ElasticOutput(scene) => of_drive(scene.start.mode),
        Scene::ElasticShaft(scene) => of_drive(scene.start.mode),
        Scene::BacklashDrive(scene) => of_drive(scene.start.mode),
        Scene::ParametricDrive(_) => Err("a ParametricDrive is no follower of a train".to_owned()),
        Scene::RigidMachine(scene) => match (scene.start, &scene.motor) {
            (MachineStart::SteadyState, _) => Err(steady),
            (MachineStart::Given, Motor::Kloss(kloss)) if kloss.dynamics.is_some() => Err(lags()),
            (MachineStart::Given, _) => Ok(None),
        },
        Scene::DriveTrain(drive_train::Scene { start: Start::SteadyState, .. }) => Err(steady),
        Scene::DriveTrain(drive_train::Scene { start: Start::Given, .. }) => of_drive(StartMode::Given),
        Scene::DriveTrain(train @ drive_train::Scene { shaft: Shaft::Free(machine), .. }) => {
            let kloss = if let Source::Kloss(kloss) = &machine.motor.source { kloss.dynamics.is_some() } else { false };
            let lag = kloss && train.names != Names::Train;
            let moves = train.followers.iter().any(|follower| follower.joint != Joint::Rigid);
            if lag { Err(lags()) } else { Ok(moves.then_some(train.start)) }
        }
        Scene::DriveTrain(train) => Ok(Some(train.start)),
    }
}

fn lags() -> String {
    "the torque of its motor, which lags, starts at another value than in a train".to_owned()
}

/// The parameters of the elastic shaft before the cam of follower j, counted from 0.
fn shaft(scene: &Scene, j: usize) -> Option<Parameters> {
    match scene {
        Scene::ElasticShaft(scene) => Some(scene.parameters),
        Scene::DriveTrain(scene) => scene.followers.get(j)?.joint.shaft(),
        _ => None,
    }
}

/// A drive as followers, and its start.
fn on_shaft(part: &Part, seat: Seat) -> Result<(Vec<Table>, Start), String> {
    let (mut document, scene) = started(part)?;
    let start = begins(&scene)?.unwrap_or_default();
    let mut followers: Vec<Table> = match document.contains_key("follower") {
        true => array(&mut document, "follower").into_iter().filter_map(|v| v.try_into().ok()).collect(),
        false => {
            let keys = ["cam", "elasticity", "backlash", "load"];
            vec![keys.iter().filter_map(|key| document.remove_entry(*key)).collect()]
        }
    };
    for (j, follower) in followers.iter_mut().enumerate() {
        turn(follower, &scene, j, seat)?;
    }
    Ok((followers, start))
}

/// Makes a follower turn by i φ + φ₀ of its shaft.
fn turn(follower: &mut Table, scene: &Scene, j: usize, Seat { ratio, offset, .. }: Seat) -> Result<(), String> {
    if ratio == 1.0 && offset == 0.0 {
        return Ok(());
    }
    let rigid: Option<&rigid_machine::Follower> = scene.follower(j);
    let cam = scene.cam().or(rigid.map(|follower| &follower.cam));
    let of = |follower: &mut Table, key: &str, law: Option<&MotionLaw>| {
        follower
            .get_mut(key)
            .and_then(Value::as_table_mut)
            .zip(law)
            .map_or(Ok(()), |(table, law)| turned(table, law, ratio, offset))
    };
    if follower.contains_key("tool") {
        return Err(format!("the law of its tool cannot turn by {ratio} φ + {offset}"));
    }
    of(follower, "cam", cam)?;
    of(follower, "crank", cam)?;
    let [load, _] = scene.loads(j);
    if let Some(own) = follower.get_mut("load").and_then(Value::as_table_mut) {
        of(own, "process", load.process.as_ref())?;
    }
    for key in ["geometry", "forces"] {
        follower.remove(key);
    }
    if let Some(Parameters { m, inertia, c, b }) = shaft(scene, j) {
        let square = ratio * ratio;
        let numbers = [("m", m), ("J", square * inertia), ("c", square * c), ("b", square * b)];
        let mut elastic: Table =
            numbers.map(|(key, number)| (key.to_owned(), Value::Float(number))).into_iter().collect();
        elastic.insert("place".to_owned(), "shaft".into());
        follower.insert("elasticity".to_owned(), Value::Table(elastic));
    }
    Ok(())
}

/// The table of a law that turns by i φ + φ₀.
fn turned(table: &mut Table, law: &MotionLaw, ratio: f64, offset: f64) -> Result<(), String> {
    let within = |angle: f64| angle.rem_euclid(TAU);
    let mut set = |key: &str, value: Value| drop(table.insert(key.to_owned(), value));
    match law {
        MotionLaw::Fourier(series)
            if ratio.fract() == 0.0 && ratio.abs() * series.order() as f64 <= HIGHEST_HARMONIC as f64 =>
        {
            let Fourier { a, b } = geared(series, ratio, offset);
            let list = |of: Vec<f64>| Value::Array(of.into_iter().map(Value::Float).collect());
            table.clear();
            table.insert("law".to_owned(), "fourier".into());
            table.insert("a".to_owned(), list(a));
            // A file starts with b₁.
            table.insert("b".to_owned(), list(b[1..].to_vec()));
        }
        MotionLaw::Cycle(cycle) if ratio == 1.0 => set("rise_start", within(cycle.plan().rise_start - offset).into()),
        MotionLaw::Crank(crank) if ratio == 1.0 => set("offset", (crank.offset + offset).into()),
        MotionLaw::Fourier(_) => {
            let most = format!("at most {HIGHEST_HARMONIC} harmonics");
            return Err(format!("with the ratio {ratio} its law is no series of {most} over a turn of the shaft"));
        }
        _ => {
            return Err(format!(
                "only harmonic laws, and cycles at the ratio 1, turn by {ratio} φ + {offset} in a train"
            ));
        }
    }
    Ok(())
}

/// U(i φ + φ₀) for an integer i, not 0.
fn geared(series: &Fourier, ratio: f64, offset: f64) -> Fourier {
    let (by, sign) = (ratio.abs() as usize, ratio.signum());
    let count = by * series.a.len().saturating_sub(1) + 1;
    let (mut a, mut b) = (vec![0.0; count], vec![0.0; count]);
    for (k, (own_a, own_b)) in series.a.iter().zip(&series.b).enumerate() {
        let (sin, cos) = (sign * k as f64 * offset).sin_cos();
        a[k * by] = own_a * cos + sign * own_b * sin;
        b[k * by] = sign * own_b * cos - own_a * sin;
    }
    Fourier::new(a, b)
}
