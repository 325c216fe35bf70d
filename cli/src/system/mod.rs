//! System files: TOML → parts and connections, with the connections of shafts. The keys are described below.
//!
#![doc = include_str!("../../../docs/system.md")]

pub mod coupled;
mod judged;
pub mod single;
mod ssp;
mod wiring;

use crate::document::{Diagnostics, Document, Kind, Node, Section, Value, all, input, meant, source::is_fmu, values};
use crate::scene::{self, Resolved, open, variable};
use camdrive::drives::shaft::cam_drive::DriveMode;
use camdrive::drives::unit::Quantity;
use camdrive::drives::variable::{Causality, Kind as Type};
use camdrive::drives::{Fault, Number};
use camdrive_design::coupling::stability::{self, Exchange, Limit, least_inertia};
use camdrive_design::host::{Fmu, ModelDescription, TemporaryFolder, Variable};
use camdrive_design::resource::{Scene, is_name};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use wiring::Wiring;

/// A system of FMUs, wired.
#[derive(Clone, Debug)]
pub struct System {
    /// A C identifier.
    pub name: String,
    /// End of its runs (s).
    pub stop: f64,
    /// Communication step (s).
    pub step: f64,
    /// The exchange between the parts at a communication point.
    pub exchange: Exchange,
    /// The number of times that `camdrive run` repeats a step.
    pub repeats: u32,
    /// The number of repetitions in the file.
    pub asked: Option<u32>,
    /// In the order of the file.
    pub parts: Vec<Part>,
    /// All connections; shafts' connections come first.
    pub connections: Vec<Connection>,
    /// The shafts of machines that are scenes and have drives on them.
    pub shafts: Vec<Shaft>,
    /// Remarks for the user that are no faults.
    pub notes: Vec<String>,
    /// The files it was read from.
    pub files: Vec<PathBuf>,
    /// The folder with the FMUs of an archive.
    pub(super) _folder: Option<Arc<TemporaryFolder>>,
}

/// A part of a system.
#[derive(Clone, Debug)]
pub struct Part {
    /// A C identifier.
    pub name: String,
    /// Its scene or its FMU.
    pub content: Content,
    /// Variables set before the initialisation, in the coherent SI unit or, for FMUs, in their own unit.
    pub start: Vec<(String, f64)>,
    /// Its variables, and the capabilities of its FMU.
    pub description: ModelDescription,
    /// Model and values, also of an FMU with its scene inside; without the values of `start`.
    pub scene: Option<Scene>,
    /// The shaft it sits on.
    pub seat: Option<Seat>,
}

/// The scene or the FMU of a part.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// A scene; a machine has an input for each torque.
    Scene(Box<Resolved>),
    /// An FMU.
    Fmu(PathBuf),
}

/// A place on the shaft of a machine: φ = ratio φ_machine + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seat {
    /// The index of the machine among the parts.
    pub machine: usize,
    /// The ratio of the speeds, not 0.
    pub ratio: f64,
    /// rad.
    pub offset: f64,
}

/// A shaft with drives on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shaft {
    /// The index of its machine among the parts.
    pub machine: usize,
    /// The largest stable step.
    pub limit: Limit,
}

/// A part, by its index in the list, and one of its variables.
pub type End = (usize, String);

/// value of `to` = `factor` · value of `from` + `offset`.
#[derive(Clone, Debug, PartialEq)]
pub struct Connection {
    /// An output.
    pub from: End,
    /// An input.
    pub to: End,
    /// Not 0.
    pub factor: f64,
    /// In the unit of `to`.
    pub offset: f64,
}

/// Admissible ratios of the speeds of two shafts.
const RATIOS: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// The outputs of a machine for the drives on its shaft.
pub const MOTION: [&str; 3] = ["phi", "w", "a"];
/// The names of inertia, its slope and the rest of the torque.
pub const INERTIA: [&str; 3] = ["J_load", "dJ_load", "tau_rest"];
const TORQUE: &str = "tau";
const MEAN_TORQUE: &str = "tau_mean";

/// The exchanges between the parts. A file chooses among the ones declared for its key; the others serve for comparison.
pub const EXCHANGES: &[(&str, Exchange)] = &[
    ("interpolated", Exchange::Interpolated),
    ("held", Exchange::Held),
    ("extrapolated", Exchange::Extrapolated),
    ("gauss_seidel", Exchange::GaussSeidel),
    ("effective_inertia", Exchange::EffectiveInertia),
];

/// The name of an exchange.
pub fn name_of(exchange: Exchange) -> &'static str {
    EXCHANGES.iter().find(|(_, known)| *known == exchange).map_or("", |(name, _)| name)
}

/// The quantity of a Real.
fn quantity(variable: &Variable) -> Option<&'static Quantity> {
    if let Type::Real { quantity, .. } = variable.about.kind { Some(quantity) } else { None }
}

/// Factor and offset from the unit of an output to the unit of an input; or the mismatch, and a hint. Radians are distinguished
/// from numbers unless the user gives a factor.
fn converted(from: &Variable, to: &Variable, has_factor: bool) -> Result<[f64; 2], (String, &'static str)> {
    let [name, target] = [from, to].map(|v| v.about.name.as_str());
    let (Some(a), Some(b)) = (quantity(from), quantity(to)) else {
        let alike = from.about.kind.r#type() == to.about.kind.r#type() && from.items == to.items;
        return match (alike, has_factor) {
            (true, false) => Ok([1.0, 0.0]),
            (true, true) => Err((format!(": `{target}` is no real number, so it has no factor"), "remove `factor`")),
            (false, _) => Err((format!(": `{name}` and `{target}` are of different types"), "connect one type")),
        };
    };
    // For an FMU without a unit, the user knows the unit.
    if from.unit.name.is_empty() || to.unit.name.is_empty() {
        return Ok([1.0, 0.0]);
    }
    let by = from.unit.factor / to.unit.factor;
    // A unit beyond mechanics has its name as its dimension.
    let known = a.base[0] != i8::MAX || a.unit == b.unit;
    match (known && a.base[..3] == b.base[..3], a.base[3] == b.base[3]) {
        (true, true) => Ok([by, (from.unit.offset - to.unit.offset) / to.unit.factor]),
        (true, false) if has_factor => Ok([by, 0.0]),
        (fits, _) => {
            let said = format!(": `{name}` is in {}, `{target}` in {}", from.unit.name, to.unit.name);
            let hint = match fits {
                true => "they differ by radians; set a `factor`",
                false => "connect variables of the same dimension",
            };
            Err((said, hint))
        }
    }
}

impl Part {
    /// A part that is an FMU.
    ///
    /// # Errors
    /// A file that is no FMU for this platform.
    pub fn foreign(name: &str, path: PathBuf) -> Result<Self, Fault> {
        Ok(Part {
            name: name.to_owned(),
            start: Vec::new(),
            description: Fmu::open(&path)?.description().clone(),
            scene: open(&path).ok().map(|resolved| resolved.scene),
            content: Content::Fmu(path),
            seat: None,
        })
    }

    /// The variable with this name and causality.
    pub fn find(&self, name: &str, causality: Causality) -> Option<&Variable> {
        self.description.variable(name).filter(|variable| variable.about.causality == causality)
    }

    fn has(&self, names: &[&str], causality: Causality) -> bool {
        names.iter().all(|name| self.find(name, causality).is_some())
    }

    /// The names of its inputs for torques.
    fn torque_inputs(&self) -> Vec<&str> {
        let inputs =
            self.description.variables.iter().map(|v| &v.about).filter(|about| about.causality == Causality::Input);
        inputs.map(|about| about.name.as_str()).filter(|name| name.rsplit('.').next() == Some(TORQUE)).collect()
    }

    /// True if it has a shaft with an input for a torque, or gets one.
    fn is_machine(&self) -> bool {
        let gets = || matches!(&self.content, Content::Scene(scene) if least_inertia(&scene.scene).is_some());
        self.has(&MOTION, Causality::Output) && (!self.torque_inputs().is_empty() || gets())
    }

    /// The outputs whose sum is the torque on the shaft; the mean ones for a drive with impacts.
    fn torques(&self) -> Vec<String> {
        let of = |prefix: &str| {
            let names = [MEAN_TORQUE, TORQUE].map(|name| format!("{prefix}{name}"));
            names.into_iter().find(|name| self.find(name, Causality::Output).is_some())
        };
        match of("") {
            Some(whole) => vec![whole],
            None => (1..).map_while(|j| of(&format!("follower[{j}]."))).collect(),
        }
    }

    /// A part that is a scene.
    fn of_scene(name: &str, resolved: Resolved) -> Result<Self, Fault> {
        let description = ModelDescription::of(name, "", &mut resolved.resource().build()?)?;
        let (scene, content) = (Some(resolved.scene.clone()), Content::Scene(Box::new(resolved)));
        Ok(Part { name: name.to_owned(), content, start: Vec::new(), description, scene, seat: None })
    }

    fn set(&mut self, resolved: Resolved) -> Result<(), Fault> {
        let new = Part::of_scene(&self.name, resolved)?;
        *self = Part { start: std::mem::take(&mut self.start), seat: self.seat, ..new };
        Ok(())
    }

    /// Its scene with the parameters of `start`, and the ones that the scene cannot take.
    fn started(&self) -> Option<(Scene, Vec<&str>)> {
        let mut scene = self.scene.clone()?;
        let parameters = self.start.iter().filter_map(|(name, value)| {
            let variable = self.find(name, Causality::Parameter)?;
            Some((name.as_str(), variable.unit.to_si(*value)))
        });
        let unknown = parameters.filter(|(name, value)| !stability::set(&mut scene, name, *value));
        let unknown = unknown.map(|(name, _)| name).collect();
        Some((scene, unknown))
    }
}

/// Reads and validates a system file with its scenes, or an archive of one.
pub fn read(path: &Path) -> Result<System, Diagnostics> {
    if input::is_archive(path) {
        return ssp::read(path).map_err(|fault| Diagnostics::of_file(path, fault));
    }
    let (_, document) = input::document(path, Kind::System)?;
    resolve(path, &document, &[])
}

/// The system of this file, changed or not; parts with these names have these scenes, other parts the scenes of their files.
pub fn resolve(path: &Path, document: &Document, scenes: &[(String, Document)]) -> Result<System, Diagnostics> {
    resolve_as(path, document, scenes, None)
}

/// The same with this exchange instead of the file's.
fn resolve_as(
    path: &Path,
    document: &Document,
    scenes: &[(String, Document)],
    exchange: Option<Exchange>,
) -> Result<System, Diagnostics> {
    let (file, folder) = (path.display().to_string(), path.parent().unwrap_or(Path::new("")));
    let mut system = input::read(&file, document, Kind::System, |root| system(root, folder, scenes, exchange))?;
    system.files.push(path.to_owned());
    Ok(system)
}

/// The same with another exchange, at steps that are short enough for everything except algebraic loops.
pub fn read_as(path: &Path, exchange: Exchange) -> Result<System, Diagnostics> {
    let (_, mut document) = input::document(path, Kind::System)?;
    document.set("step", f64::MIN_POSITIVE);
    if !matches!(exchange, Exchange::Interpolated | Exchange::EffectiveInertia) {
        document.remove("repeat");
    }
    resolve_as(path, &document, &[], Some(exchange))
}

/// A part with its section of the file.
struct PartSection<'a> {
    section: Section<'a>,
    part: Part,
    shaft: Option<&'a str>,
    seat: [f64; 2],
}

fn system(
    root: &Section<'_>,
    folder: &Path,
    scenes: &[(String, Document)],
    exchange: Option<Exchange>,
) -> Option<System> {
    let name = root.name();
    let [stop, step] = ["stop", "step"].map(|key| root.real(key));
    let own = root.choice("exchange", EXCHANGES);
    let exchange = exchange.or(own);
    let repeats = if root.has("repeat") { root.count("repeat").map(|count| Some(count as u32)) } else { Some(None) };
    if let Some((stop, step)) = stop.zip(step).filter(|(stop, step)| step > stop) {
        let fault = root.fault_of("step", format!(": {step} s is longer than the run of {stop} s"));
        root.faults.report(fault.hint("a communication step is a small part of `stop`"));
    }
    let parts = root.named("part");
    if parts.as_ref().is_some_and(Vec::is_empty) {
        let fault = root.fault_of("part", " is missing: a system has no parts");
        root.faults.report(fault.hint("add [part.machine] with scene = \"machine.toml\""));
    }
    let parts = parts?;
    for (i, (name, section)) in parts.iter().enumerate() {
        if let Some((other, _)) = parts[..i].iter().find(|(other, _)| other.eq_ignore_ascii_case(name)) {
            let fault =
                section.fault(format!(": its FMU would replace the FMU of `{other}` on systems that ignore capitals"));
            root.faults.report(fault.hint("choose another name"));
        }
    }
    let scene = |name: &str| scenes.iter().find(|(part, _)| part == name).map(|(_, document)| document);
    let raw = all(parts.into_iter().map(|(name, section)| part(name, section, folder, scene(name))));
    let connections = root.sections("connection");
    root.finish();
    let mut raw = raw?;
    let wired = seats(&mut raw);
    let mut wiring = Wiring { raw, connections: Vec::new(), torques: Vec::new() };
    all(connections?.iter().map(|section| wiring.connection(section))).and(wired)?;
    wiring.drives(exchange? == Exchange::EffectiveInertia)?;
    wiring.machines()?;
    wiring.loose_ends(root);
    let (name, stop, step, exchange) = (name?, stop?, step?, exchange?);
    judged::lengths(root, &wiring, stop, step)?;
    let asked = repeats?;
    let (shafts, repeats) = judged::shafts(root, &wiring, exchange, step, asked)?;
    wiring.starts()?;
    let files = wiring.raw.iter().flat_map(|raw| match &raw.part.content {
        Content::Scene(scene) => scene.files.clone(),
        Content::Fmu(path) => vec![path.clone()],
    });
    Some(System {
        name,
        stop,
        step,
        exchange,
        repeats,
        asked,
        shafts,
        files: files.collect(),
        parts: wiring.raw.into_iter().map(|raw| raw.part).collect(),
        connections: wiring.connections,
        notes: root.faults.notes(),
        _folder: None,
    })
}

/// Reads `[part.NAME]`.
fn part<'a>(
    name: &'a str,
    section: Section<'a>,
    folder: &Path,
    document: Option<&Document>,
) -> Option<PartSection<'a>> {
    if !is_name(name) {
        let fault = section.fault(": this cannot name a part");
        section.faults.report(fault.admissible("letters, digits and _, no digit first, at most 24 characters"));
    }
    let one = section.either("scene", "fmu");
    let [scene, fmu, shaft] = ["scene", "fmu", "shaft"].map(|key| section.text(key));
    let [ratio, offset] = ["ratio", "offset"].map(|key| section.real(key));
    if let Some(ratio) = ratio.filter(|ratio| !RATIOS.contains(&ratio.abs())) {
        let fault = section.fault_of("ratio", format!(": {} is no ratio of two shafts", Number(ratio)));
        section.faults.report(fault.admissible("magnitude 1e-6 to 1e6, negative if they turn against each other"));
    }
    if shaft == Some(None) {
        section.forbid(&["ratio", "offset"], "the part sits on no shaft", "shaft = \"machine\"");
    }
    let other = |key, path: &str, needed: &str| {
        let what = if key == "scene" { "an FMU" } else { "no FMU" };
        section.fault_of(key, format!(": \"{path}\" is {what}")).hint(format!("write {needed} = \"{path}\""))
    };
    let read = match (scene?, fmu?) {
        (Some(scene), None) if is_fmu(Path::new(scene)) => Err(other("scene", scene, "fmu")),
        (None, Some(fmu)) if Path::new(fmu).extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) => {
            Err(other("fmu", fmu, "scene"))
        }
        (Some(scene), None) => match scene_of(&folder.join(scene), document) {
            Ok(scene) => {
                scene.notes.iter().for_each(|note| section.faults.note(format!("part {name}: {note}")));
                Part::of_scene(name, scene).map_err(|fault| section.fault_of("scene", format!(": {fault}")))
            }
            // The reader of the scene reports its faults.
            Err(Diagnostics(faults)) => return faults.into_iter().fold(None, |_, fault| section.refuse(fault)),
        },
        (None, Some(fmu)) => Part::foreign(name, folder.join(fmu))
            .map_err(|fault| section.fault_of("fmu", format!(": {}", fault.sentence())).remedy(fault.0.hint)),
        (None, None) => Err(section.fault(" has neither `scene` nor `fmu`").hint("give `scene` or `fmu`")),
        _ => return None,
    };
    let mut part = section.taken(read)?;
    let start = start(&section, &part);
    section.finish();
    part.start = start?;
    let seat = [ratio?, offset?];
    one.then_some(PartSection { shaft: shaft?, seat, part, section })
}

/// The scene of this file, or of a document instead.
fn scene_of(path: &Path, document: Option<&Document>) -> Result<Resolved, Diagnostics> {
    let Some(document) = document else { return scene::read(path) };
    scene::resolve_document(&path.display().to_string(), document, path.parent().unwrap_or(Path::new("")))
}

/// Reads `start`.
fn start(section: &Section<'_>, part: &Part) -> Option<Vec<(String, f64)>> {
    let Some(node) = section.node("start") else { return Some(Vec::new()) };
    let Value::Table(table) = node.value else {
        let fault = section.fault_of("start", ": a table of variables and values is expected");
        return section.refuse(fault.hint("write for example start = { w_start = \"300 rpm\" }"));
    };
    // Nested tables are names with dots.
    let read = values(table).into_iter().map(|(name, value)| {
        let node = Node::new(format!("{}.{name}", node.path), value);
        let text = match node.value {
            Value::Text(text) => text.trim().to_owned(),
            Value::Integer(_) | Value::Float(_) | Value::Boolean(_) => {
                section.faults.document.text.get(node.span.clone()).unwrap_or_default().replace('_', "")
            }
            _ => String::new(),
        };
        let value = part.value(&name, &text);
        let told = |fault: Fault| section.of_node(&node, format!(": {}", fault.sentence())).remedy(fault.0.hint);
        section.taken(value.map_err(told)).map(|value| (name, value))
    });
    all(read)
}

impl Part {
    /// The start value of a variable from a text, in the unit of the variable.
    fn value(&self, name: &str, text: &str) -> Result<f64, Fault> {
        let Some(place) = self.description.find(name) else {
            let names = self.description.variables.iter().map(|v| v.about.name.as_str());
            return Err(variable::unknown(name, names));
        };
        let Variable { about, unit, .. } = &self.description.variables[place];
        if !matches!(about.causality, Causality::Parameter | Causality::Input) {
            return Err(Fault::new(format!("`{name}` is computed and cannot be set")));
        }
        let value = variable::imported(&self.description, place, text)?;
        about.check(value)?;
        Ok(unit.of_si(value))
    }
}

impl System {
    /// The part, the name and the value in its unit from "PART.NAME=VALUE"; None for another text.
    pub fn started<'a>(&self, text: &'a str) -> Option<(usize, &'a str, f64)> {
        let (name, value) = text.split_once('=')?;
        let (part, name) = name.trim().split_once('.')?;
        let place = self.parts.iter().position(|known| known.name == part)?;
        Some((place, name, self.parts[place].value(name, value.trim()).ok()?))
    }
}

/// Finds the machine of each part on a shaft.
fn seats(raw: &mut [PartSection<'_>]) -> Option<()> {
    let names: Vec<String> = raw.iter().map(|raw| raw.part.name.clone()).collect();
    let known: Vec<&str> = names.iter().map(String::as_str).collect();
    let place = |name: &str| known.iter().position(|known| *known == name);
    let shafts: Vec<Option<usize>> = raw.iter().map(|raw| raw.shaft.and_then(place)).collect();
    let seat = |i: usize| -> Option<Option<Seat>> {
        let PartSection { section, shaft, seat: [ratio, offset], part } = &raw[i];
        let Some(shaft) = *shaft else { return Some(None) };
        let refused = |said: String| section.fault_of("shaft", said);
        let Some(machine) = shafts[i] else {
            let fault = refused(format!(": there is no part `{shaft}`")).admissible(known.join(", "));
            return section.refuse(fault.remedy(meant(shaft, &known)));
        };
        let chain: Vec<usize> =
            std::iter::successors(Some(machine), |next| shafts[*next].filter(|_| *next != i)).take(raw.len()).collect();
        if chain.contains(&i) {
            let way: Vec<&str> = [i].iter().chain(&chain).map(|place| known[*place]).collect();
            let fault = refused(format!(": these shafts go round in a circle: {}", way.join(" → ")));
            return section.refuse(fault.hint("a machine sits on no shaft; name it"));
        }
        let other = &raw[machine].part;
        if !other.is_machine() {
            let fault = refused(format!(": `{shaft}` is no machine: it needs outputs phi, w, a and an input tau"));
            let is_free = other.scene.as_ref().is_some_and(|scene| least_inertia(scene).is_some());
            return section.refuse(match raw[machine].shaft {
                Some(its) => fault.hint(format!("write shaft = \"{its}\", on which `{shaft}` sits, too")),
                None if is_free => {
                    fault.hint(format!("write torques = [\"{}\"] in its scene and export it again", part.name))
                }
                None => fault.hint("name the part with the free shaft, a RigidMachine for example"),
            });
        }
        if !part.has(&MOTION, Causality::Input) {
            let prescribed = part.scene.as_ref().and_then(Scene::drive);
            let prescribed = prescribed.map(|drive| matches!(drive, DriveMode::Speed { .. }));
            return section.refuse(match prescribed {
                Some(by_speed) => {
                    let own = if by_speed { "integrates its own angle" } else { "turns at constant speed" };
                    refused(format!(": its scene {own}")).hint("write `[drive]` with mode = \"input\" in its scene")
                }
                None => refused(": the part has no inputs phi, w, a".to_owned()).hint("remove `shaft`"),
            });
        }
        if part.torques().is_empty() {
            return section
                .refuse(refused(": the part has no output tau or tau_mean".to_owned()).hint("remove `shaft`"));
        }
        Some(Some(Seat { machine, ratio: *ratio, offset: *offset }))
    };
    let found = all((0..raw.len()).map(seat))?;
    raw.iter_mut().zip(found).for_each(|(raw, seat)| raw.part.seat = seat);
    Some(())
}
