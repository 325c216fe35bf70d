//! Systems of System Structure and Parameterization 1.0: an archive with FMUs and SystemStructure.ssd.

use super::{Connection, Content, End, Part, System, converted};
use camdrive::drives::Fault;
use camdrive::drives::variable::{Causality, Kind};
use camdrive_design::coupling::stability::Exchange;
use camdrive_design::host::{Fmu, unpacked};
use camdrive_design::xml::Element;
use std::path::Path;
use std::sync::Arc;

/// The file that describes the system.
const STRUCTURE: &str = "SystemStructure.ssd";

/// Communication steps over the time of the system, which tells none.
const STEPS: f64 = 1000.0;

/// Reads an archive whose parts are FMUs of Co-Simulation. Values interpolate.
///
/// # Errors
/// With the path: a file that is no such archive, systems inside of the system, tables and mappings as transformations, what names
/// no part or variable.
pub fn read(path: &Path) -> Result<System, Fault> {
    system(path).map_err(|fault| Fault::new(format!("{}: {fault}", path.display())))
}

fn system(path: &Path) -> Result<System, Fault> {
    let folder = Arc::new(unpacked(path, &[STRUCTURE, "resources/"])?);
    let file = |name: &str| {
        std::fs::read_to_string(folder.path().join(name)).map_err(|e| Fault::new(format!("{name} cannot be read: {e}")))
    };
    let root = Element::read(&file(STRUCTURE)?).map_err(|fault| Fault::new(format!("{STRUCTURE}, {fault}")))?;
    let version = root.needed("version")?;
    if version != "1.0" && version != "2.0" {
        return Err(Fault::new(format!("SSP {version} is not known; expected 1.0 or 2.0")));
    }
    let own = root.child("System").ok_or_else(|| Fault::new("there is no <System>"))?;
    let mut parts = Vec::new();
    for element in own.list("Elements") {
        let name = element.needed("name")?;
        let told = |fault: &dyn std::fmt::Display| Fault::new(format!("part {name}: {fault}"));
        if element.name != "Component" {
            return Err(told(&"a system or parameters inside of a system\n  = hint: one system of FMUs is read"));
        }
        let place = folder.path().join(element.needed("source")?);
        let fmu = Fmu::open(&place).map_err(|fault| told(&fault))?;
        let variables = fmu.description().variables.clone();
        let mut part =
            Part { name: name.to_owned(), content: Content::Fmu(place), start: Vec::new(), variables, seat: None };
        for (name, value) in parameters(element, &file)? {
            part.set_start(&name, value)?;
        }
        parts.push(part);
    }
    if parts.is_empty() {
        return Err(Fault::new("the system has no parts"));
    }
    for (name, value) in parameters(own, &file)? {
        let of_part = |part: &&mut Part| name.strip_prefix(&part.name).is_some_and(|rest| rest.starts_with('.'));
        let part = parts.iter_mut().find(of_part).ok_or_else(|| Fault::new(format!("`{name}` is of no part")))?;
        let own = name[part.name.len() + 1..].to_owned();
        part.set_start(&own, value)?;
    }
    let connections = own.list("Connections").iter().map(|element| connection(element, &parts));
    let connections: Vec<Connection> = connections.collect::<Result<_, Fault>>()?;
    for (i, Connection { to, .. }) in connections.iter().enumerate() {
        if connections[..i].iter().any(|other| other.to == *to) {
            return Err(Fault::new(format!("`{}.{}` is connected twice", parts[to.0].name, to.1)));
        }
    }
    let experiment = root.child("DefaultExperiment");
    let stop = experiment.map_or(Ok(None), |experiment| experiment.number("stopTime"))?.unwrap_or(1.0);
    Ok(System {
        name: own.get("name").or(root.get("name")).unwrap_or("system").to_owned(),
        stop,
        step: stop / STEPS,
        exchange: Exchange::Interpolated,
        repeats: 0,
        parts,
        connections,
        shafts: Vec::new(),
        notes: Vec::new(),
        files: vec![path.to_owned()],
        _folder: Some(folder),
    })
}

impl Part {
    fn set_start(&mut self, name: &str, value: f64) -> Result<(), Fault> {
        if !self.variables.iter().any(|v| v.about.name == name) {
            return Err(Fault::new(format!("part {}: `{name}`, which a parameter sets, is no variable", self.name)));
        }
        self.start.retain(|(other, _)| other != name);
        self.start.push((name.to_owned(), value));
        Ok(())
    }
}

/// Names and values of the parameters that are bound to an element.
fn parameters(element: &Element, file: &impl Fn(&str) -> Result<String, Fault>) -> Result<Vec<(String, f64)>, Fault> {
    let mut all = Vec::new();
    for binding in element.list("ParameterBindings") {
        if binding.child("ParameterMapping").is_some() {
            return Err(Fault::new("a <ParameterMapping> is not read\n  = hint: name the parameters as the FMUs do"));
        }
        let read = match binding.get("source") {
            Some(source) => Some(Element::read(&file(source)?)?),
            None => binding.child("ParameterValues").and_then(|values| values.child("ParameterSet")).cloned(),
        };
        let prefix = binding.get("prefix").unwrap_or_default();
        for parameter in read.iter().flat_map(|set| set.list("Parameters")) {
            let name = parameter.needed("name")?;
            let said = |what: &str| Fault::new(format!("the parameter `{name}` {what}"));
            let value = parameter.children.first().ok_or_else(|| said("has no value"))?;
            let number = match (value.name.as_str(), value.needed("value")?) {
                ("Boolean", _) => f64::from(u8::from(value.is("value"))),
                (_, text) => text.parse().map_err(|_| said(&format!("is \"{text}\", not a number")))?,
            };
            all.push((format!("{prefix}{name}"), number));
        }
    }
    Ok(all)
}

fn connection(element: &Element, parts: &[Part]) -> Result<Connection, Fault> {
    let end = |of: &str, connector: &str, causality: Causality| -> Result<End, Fault> {
        let (name, variable) = (element.get(of), element.needed(connector)?);
        let place = parts.iter().position(|part| Some(part.name.as_str()) == name);
        let place = place.ok_or_else(|| Fault::new(format!("a connection with `{variable}` of no part")))?;
        match parts[place].find(variable, causality) {
            Some(_) => Ok((place, variable.to_owned())),
            None => {
                let kind = if causality == Causality::Input { "input" } else { "output" };
                Err(Fault::new(format!("a connection: part {} has no {kind} `{variable}`", parts[place].name)))
            }
        }
    };
    let from = end("startElement", "startConnector", Causality::Output)?;
    let to = end("endElement", "endConnector", Causality::Input)?;
    let of = |(part, name): &End, causality| parts[*part].find(name, causality);
    let transformation = element.child("LinearTransformation");
    if let Some(other) = element.children.iter().find(|child| child.name.ends_with("MappingTransformation")) {
        return Err(Fault::new(format!("`{}.{}`: <{}> is not read", parts[to.0].name, to.1, other.name)));
    }
    let number = |name| transformation.map_or(Ok(None), |transformation| transformation.number::<f64>(name));
    let (factor, offset) = (number("factor")?.unwrap_or(1.0), number("offset")?.unwrap_or(0.0));
    let [by, beyond] = match (of(&from, Causality::Output), of(&to, Causality::Input)) {
        (Some(output), Some(input)) if !element.is("suppressUnitConversion") && is_real(output, input) => {
            converted(output, input, true).map_err(|(said, _)| Fault::new(format!("a connection{said}")))?
        }
        _ => [1.0, 0.0],
    };
    Ok(Connection { from, to, factor: factor * by, offset: factor * beyond + offset })
}

fn is_real(output: &camdrive_design::host::Variable, input: &camdrive_design::host::Variable) -> bool {
    [output, input].iter().all(|variable| matches!(variable.about.kind, Kind::Real { .. }))
}
