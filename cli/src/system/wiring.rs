//! The connections of a system: from shafts, and from the file.

use super::{Connection, Content, End, INERTIA, MEAN_TORQUE, MOTION, PartSection, Seat, TORQUE, converted, quantity};
use crate::document::{Diagnostic, Diagnostics, Document, Node, Section, Value, nearest};
use crate::scene::{Resolved, resolve_document, variable};
use camdrive::drives::unit::{self, Quantity};
use camdrive::drives::variable::Causality;
use camdrive_design::coupling::stability;
use camdrive_design::resource::Scene;
use toml_edit::{Array, Item, Table};

/// The key of a scene for loads with inertia.
const INERTIA_KEY: &str = "coupling.inertia";

/// A torque on a machine.
pub(super) struct Torque {
    from: End,
    factor: f64,
    /// N·m.
    offset: f64,
    /// The ratio of a drive with outputs of its inertia; None for another drive.
    inertia: Option<f64>,
}

/// The parts with their connections so far.
pub(super) struct Wiring<'a> {
    pub raw: Vec<PartSection<'a>>,
    pub connections: Vec<Connection>,
    /// Torques on the free shaft of scenes, by the part.
    pub torques: Vec<(usize, Torque)>,
}

impl Wiring<'_> {
    /// Changes the document of a part's scene.
    fn change(&mut self, i: usize, change: impl FnOnce(&mut Document)) -> Option<()> {
        let PartSection { part, section, .. } = &mut self.raw[i];
        let Content::Scene(scene) = &part.content else { return Some(()) };
        let mut document = scene.document.clone();
        change(&mut document);
        let changed = resolve_document(&part.name, &document, &scene.folder)
            .map(|changed| Resolved { files: scene.files.clone(), ..changed });
        match changed {
            Ok(scene) => {
                section.taken(part.set(scene).map_err(|fault| section.fault_of("scene", format!(": {fault}"))))
            }
            Err(Diagnostics(faults)) => {
                let told = |fault: Diagnostic| {
                    let said = format!(" as part of a system: {}", fault.message);
                    Diagnostic { hint: fault.hint, admissible: fault.admissible, ..section.fault_of("scene", said) }
                };
                faults.into_iter().fold(None, |_, fault| section.refuse(told(fault)))
            }
        }
    }

    /// Reads `[[connection]]`.
    pub fn connection(&mut self, section: &Section<'_>) -> Option<()> {
        let [from, to] = [("from", Causality::Output), ("to", Causality::Input)].map(|(key, causality)| {
            let text = section.required_text(key, "PART.VARIABLE", "controller.y")?;
            self.end(section, key, text, causality)
        });
        let target = to.as_ref().and_then(|(part, name)| self.raw[*part].part.find(name, Causality::Input));
        let of = target.and_then(quantity);
        section.of(of.unwrap_or(&unit::NUMBER), 0);
        let [factor, offset] = ["factor", "offset"].map(|key| section.real(key));
        section.finish();
        let (from, to, factor, offset) = (from?, to?, factor?, offset?);
        if factor == 0.0 {
            return section.refuse(section.fault_of("factor", ": the factor 0 transmits nothing").admissible("not 0"));
        }
        let find = |(part, name): &End, causality| self.raw[*part].part.find(name, causality).cloned();
        let (output, input) = (find(&from, Causality::Output)?, find(&to, Causality::Input)?);
        if of.is_none() && section.has("offset") {
            let fault = section.fault_of("offset", format!(": `{}` is no real number, so it has no offset", to.1));
            return section.refuse(fault.hint("remove it"));
        }
        if let Err((said, hint)) = converted(&output, &input, section.has("factor")) {
            return section.refuse(section.fault_of("to", said).hint(hint));
        }
        let is_number = |node: &Node<'_>| !matches!(node.value, Value::Text(_));
        if !input.unit.is_si() && section.node("offset").as_ref().is_some_and(is_number) && offset != 0.0 {
            let said = variable::ambiguous(offset, &input.unit);
            return section.refuse(section.fault_of("offset", format!(": {}", said.sentence())).remedy(said.0.hint));
        }
        self.acts_once(section, &from, to.0, of)?;
        let machine = &self.raw[to.0].part;
        if matches!(machine.content, Content::Scene(_)) && to.1 == TORQUE && machine.is_machine() {
            self.impulses(section, &from);
            self.torques.push((to.0, Torque { from, factor, offset, inertia: None }));
            return Some(());
        }
        let own = &self.raw[to.0];
        let seated = own.part.seat.is_some() && MOTION.contains(&&*to.1);
        if seated || self.connections.iter().any(|other| other.to == to) {
            let fault = section.fault_of("to", format!(": `{}.{}` is connected already", own.part.name, to.1));
            return section.refuse(fault.hint(match seated {
                true => "the machine of its shaft moves it already; remove the connection",
                false => "an input takes one output; add them up in a separate part",
            }));
        }
        if to.1 == TORQUE || to.1.ends_with(&format!(".{TORQUE}")) {
            self.impulses(section, &from);
        }
        self.connections.push(self.wired(from, to, factor, offset));
        Some(())
    }

    /// Refuses a torque of a part on a machine on which it acts already, by its shaft or by another connection; with or without
    /// impulses it is the same torque.
    fn acts_once(&self, section: &Section<'_>, from: &End, machine: usize, of: Option<&Quantity>) -> Option<()> {
        let is_torque = of.is_some_and(|of| of.base == unit::TORQUE.base) && torque_of(&from.1).is_some();
        let same = |other: &End| other.0 == from.0 && torque_of(&other.1) == torque_of(&from.1);
        let on_machine = |part: usize| part == machine;
        let wired = self.connections.iter().filter(|c| on_machine(c.to.0)).map(|c| &c.from);
        let summed = self.torques.iter().filter(|(part, _)| on_machine(*part)).map(|(_, torque)| &torque.from);
        let by_shaft = self.raw[from.0].part.seat.is_some_and(|seat| on_machine(seat.machine));
        let twice = by_shaft || wired.chain(summed).any(same);
        if !is_torque || !twice {
            return Some(());
        }
        let by = if by_shaft { "its `shaft`" } else { "another connection" };
        let said = format!(": `{}` acts on `{}` already, by {by}", self.name(from), self.raw[machine].part.name);
        section.refuse(section.fault_of("from", said).hint("remove the connection"))
    }

    /// Notes a torque without impulses if the part has one with them.
    fn impulses(&self, section: &Section<'_>, from: &End) {
        let (part, mean) = (&self.raw[from.0].part, format!("{}_mean", from.1));
        if from.1.ends_with(TORQUE) && part.find(&mean, Causality::Output).is_some() {
            let name = &part.name;
            section.faults.note(format!("`{}` is without impulses: connect `{name}.{mean}`", self.name(from)));
        }
    }

    /// The name of a variable with that of its part.
    fn name(&self, (part, name): &End) -> String {
        format!("{}.{name}", self.raw[*part].part.name)
    }

    /// An input = factor · output + offset in SI values, converted to the units of both.
    fn wired(&self, from: End, to: End, factor: f64, offset: f64) -> Connection {
        let find = |(part, name): &End, causality| self.raw[*part].part.find(name, causality);
        let [by, beyond] = match (find(&from, Causality::Output), find(&to, Causality::Input)) {
            (Some(output), Some(input)) => {
                let [by, beyond] = converted(output, input, true).unwrap_or([1.0, 0.0]);
                [by, factor * beyond + offset / input.unit.factor]
            }
            _ => [1.0, offset],
        };
        Connection { from, to, factor: factor * by, offset: beyond }
    }

    /// The part and the variable of a name.
    fn end(&self, section: &Section<'_>, key: &'static str, text: &str, causality: Causality) -> Option<End> {
        let names: Vec<&str> = self.raw.iter().map(|raw| raw.part.name.as_str()).collect();
        let Some((part, name)) = text.split_once('.') else {
            let fault = section.fault_of(key, format!(": \"{text}\" names no variable of a part"));
            return section.refuse(fault.admissible("PART.VARIABLE").hint("write for example \"machine.w\""));
        };
        let suggested = |said: String, wrong: &str, known: &[&str]| {
            let fault = section.fault_of(key, said);
            match nearest(wrong, known) {
                Some(guess) => fault.hint(format!("did you mean `{guess}`?")),
                None => fault.admissible(known.join(", ")),
            }
        };
        let Some(place) = names.iter().position(|known| *known == part) else {
            return section.refuse(suggested(format!(": there is no part `{part}`"), part, &names));
        };
        let description = &self.raw[place].part.description;
        let word = if causality == Causality::Input { "input" } else { "output" };
        match description.variable(name).map(|v| &v.about) {
            Some(found) if found.causality == causality => Some((place, name.to_owned())),
            Some(found) => {
                let fault = section.fault_of(key, format!(": `{name}` of `{part}` is no {word}"));
                section.refuse(match found.causality {
                    Causality::Parameter => fault.hint(format!("a parameter is set by `start` of [part.{part}]")),
                    _ => fault.hint("`from` names an output, `to` an input"),
                })
            }
            None => {
                let of_kind = description.variables.iter().filter(|v| v.about.causality == causality);
                let known = of_kind.map(|v| v.about.name.as_str());
                let said = format!(": `{part}` has no {word} `{name}`");
                section.refuse(suggested(said, name, &known.collect::<Vec<_>>()))
            }
        }
    }

    /// Connects the drives to their shafts.
    pub fn drives(&mut self, by_inertia: bool) -> Option<()> {
        for i in 0..self.raw.len() {
            let Some(Seat { machine, ratio, offset }) = self.raw[i].part.seat else { continue };
            let mut torques: Vec<Torque> = Vec::new();
            for from in self.raw[i].part.torques() {
                torques.push(Torque { from: (i, from), factor: ratio, offset: 0.0, inertia: None });
            }
            if by_inertia && self.has_rigid_load(i) {
                self.change(i, |document| set_inertia(document, true.into()))?;
                // A train reports the torques of its followers together.
                torques.truncate(1);
                torques[0].inertia = Some(ratio);
            }
            let motion = MOTION.map(|name| {
                let (from, to) = ((machine, name.to_owned()), (i, name.to_owned()));
                self.wired(from, to, ratio, if name == MOTION[0] { offset } else { 0.0 })
            });
            self.connections.extend(motion);
            self.torques.extend(torques.into_iter().map(|torque| (machine, torque)));
        }
        Some(())
    }

    /// True if a part follows the shaft of the drive without slip, and without impacts; an FMU must provide it as outputs.
    fn has_rigid_load(&self, i: usize) -> bool {
        let part = &self.raw[i].part;
        let is_rigid = part.scene.as_ref().is_some_and(|scene| stability::loads(scene)[0].inertia > 0.0);
        let tells = matches!(part.content, Content::Scene(_)) || part.has(&INERTIA, Causality::Output);
        is_rigid && tells && !part.torques().iter().any(|name| name.ends_with(MEAN_TORQUE))
    }

    /// Refuses start values of connected inputs.
    pub fn starts(&self) -> Option<()> {
        let mut all = Some(());
        for (i, PartSection { part, section, .. }) in self.raw.iter().enumerate() {
            let is_fed = |name: &str| self.connections.iter().any(|c| c.to.0 == i && c.to.1 == name);
            if let Some((name, _)) = part.start.iter().find(|(name, _)| is_fed(name)) {
                let fault = section.fault_of("start", format!(": `{name}` is connected; a value would have no effect"));
                all = section.refuse(fault.hint("remove it"));
            }
        }
        all
    }

    /// Gives each machine an input for each of its torques.
    pub fn machines(&mut self) -> Option<()> {
        let all: Vec<(usize, Torque)> = std::mem::take(&mut self.torques);
        for i in 0..self.raw.len() {
            let own: Vec<&Torque> = all.iter().filter(|(machine, _)| *machine == i).map(|(_, torque)| torque).collect();
            if own.is_empty() {
                continue;
            }
            let names = self.names(&own);
            let is_scene = matches!(self.raw[i].part.content, Content::Scene(_));
            let single =
                own.len() == 1 && own[0].inertia.is_none() && self.raw[i].part.has(&[TORQUE], Causality::Input);
            if is_scene && !single {
                self.declare(i, &names, &own)?;
            }
            for (name, torque) in names.iter().zip(own) {
                let input = |of: &str| if single { of.to_owned() } else { format!("{name}.{of}") };
                let wires = match torque.inertia {
                    Some(ratio) => INERTIA
                        .map(|of| (of, input(of)))
                        .into_iter()
                        .zip([ratio * ratio, ratio.powi(3), ratio])
                        .map(|((of, to), factor)| ((torque.from.0, of.to_owned()), to, factor))
                        .collect(),
                    None => vec![(torque.from.clone(), input(TORQUE), torque.factor)],
                };
                for (from, to, factor) in wires {
                    if self.raw[i].part.find(&to, Causality::Input).is_none() {
                        return self.refuse_torque(i, &to, torque, &names);
                    }
                    let to = (i, to);
                    if self.connections.iter().any(|other| other.to == to) {
                        let PartSection { section, .. } = &self.raw[from.0];
                        let said = format!(": `{}.{}` is connected already", self.raw[i].part.name, to.1);
                        return section.refuse(section.fault_of("shaft", said).hint("remove the [[connection]] to it"));
                    }
                    self.connections.push(self.wired(from, to, factor, torque.offset));
                }
            }
        }
        Some(())
    }

    /// Gives the scene of a machine inputs for these torques.
    fn declare(&mut self, i: usize, names: &[String], own: &[&Torque]) -> Option<()> {
        let with_inertia = names.iter().zip(own).filter(|(_, torque)| torque.inertia.is_some());
        let with_inertia: Vec<&str> = with_inertia.map(|(name, _)| name.as_str()).collect();
        let PartSection { part, section, .. } = &self.raw[i];
        if !with_inertia.is_empty() && !matches!(part.scene, Some(Scene::RigidMachine(_))) {
            let said = ": it takes no inertia of loads; only a RigidMachine does, with the motor none, kloss or input, without \
                                transmission and without loads of its own";
            let hint = "take exchange = \"interpolated\", or write one DriveTrain";
            return section.refuse(section.fault_of("scene", said).hint(hint));
        }
        self.change(i, |document| {
            document.set("torques", with_names(document, "torques", names.iter().map(String::as_str)));
            if !with_inertia.is_empty() {
                let all = with_names(document, INERTIA_KEY, with_inertia.into_iter());
                set_inertia(document, all.into());
            }
        })
    }

    /// Refuses a torque on a machine without the input `to`.
    fn refuse_torque(&self, i: usize, to: &str, torque: &Torque, names: &[String]) -> Option<()> {
        let PartSection { section, part, .. } = &self.raw[torque.from.0];
        let said = format!(": `{}` has no input `{to}` for the torque of `{}`", self.raw[i].part.name, part.name);
        let hint = match &self.raw[i].part.content {
            Content::Scene(_) => {
                "its scene takes inertias, `coupling.inertia`: remove it, or take exchange = \"effective_inertia\""
                    .to_owned()
            }
            Content::Fmu(_) => {
                let names: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
                let coupling = if torque.inertia.is_some() { ", coupling.inertia = the same list" } else { "" };
                format!("write torques = [{}]{coupling} in its scene and export it again", names.join(", "))
            }
        };
        let fault = section.fault_of("shaft", said).hint(hint);
        let known = self.raw[i].part.torque_inputs().join(", ");
        section.refuse(if known.is_empty() { fault } else { fault.admissible(known) })
    }

    /// The name of each torque of a machine: the name of its part, with a number if the part has several.
    fn names(&self, torques: &[&Torque]) -> Vec<String> {
        let of = |i: usize| &self.raw[torques[i].from.0].part.name;
        let same =
            |i: usize, range: std::ops::Range<usize>| range.filter(|k| torques[*k].from.0 == torques[i].from.0).count();
        let name = |i: usize| match same(i, 0..torques.len()) {
            1 => of(i).clone(),
            _ => format!("{}_{}", of(i), same(i, 0..i) + 1),
        };
        (0..torques.len()).map(name).collect()
    }

    /// Notes unconnected inputs.
    pub fn loose_ends(&self, root: &Section<'_>) {
        for (i, PartSection { part, .. }) in self.raw.iter().enumerate() {
            let loose = part.description.variables.iter().filter(|v| {
                let set = part.start.iter().any(|(name, _)| *name == v.about.name);
                v.about.causality == Causality::Input
                    && !set
                    && !self.connections.iter().any(|c| c.to == (i, v.about.name.clone()))
            });
            let names: Vec<String> = loose.map(|v| format!("`{}`", v.about.name)).collect();
            if !names.is_empty() {
                let rest = match names.len() {
                    1 => "is not connected and keeps its start value",
                    _ => "are not connected and keep their start values",
                };
                root.faults.note(format!("part {}: {} {rest}", part.name, names.join(", ")));
            }
        }
    }
}

/// The load of a torque: the name before tau, tau_mean or tau_rest; None for another name.
fn torque_of(name: &str) -> Option<&str> {
    let prefix = |torque: &&str| name.strip_suffix(*torque).filter(|rest| rest.is_empty() || rest.ends_with('.'));
    [MEAN_TORQUE, TORQUE, INERTIA[2]].iter().find_map(prefix)
}

/// The list of names under a key, extended by these.
fn with_names<'a>(document: &Document, path: &str, names: impl Iterator<Item = &'a str>) -> Array {
    let written = document.place(path).flatten().and_then(|list| document.text.get(list.span())?.parse().ok());
    let known = written.and_then(|list: toml_edit::Value| list.as_array().cloned()).unwrap_or_default();
    let mut all = known.clone();
    all.extend(names.filter(|name| !known.iter().any(|known| known.as_str() == Some(name))));
    all
}

/// Sets `coupling.inertia`; a new table gets its own header.
fn set_inertia(document: &mut Document, value: toml_edit::Value) {
    let table = |value| [("inertia", Item::Value(value))].into_iter().collect::<Table>();
    match document.table.contains_key("coupling") {
        true => document.set(INERTIA_KEY, value),
        false => document.set("coupling", table(value)),
    };
}
