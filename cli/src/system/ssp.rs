//! Systems of System Structure and Parameterization 1.0: an archive with FMUs and SystemStructure.ssd.

use super::judged::SystemAnalysis;
use super::{Connection, End, Part, System, converted};
use camdrive::drives::Fault;
use camdrive::drives::variable::{Causality, Kind};
use camdrive_design::coupling::stability::Exchange;
use camdrive_design::host::{TemporaryFolder, Variable, unpacked};
use camdrive_design::xml::Element;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// The file that describes the system.
const STRUCTURE: &str = "SystemStructure.ssd";

/// Default number of communication steps, since a system in SSP has no step.
const STEPS: f64 = 1000.0;

/// The end of a run if the system has none (s).
const STOP: f64 = 1.0;

const HINT: &str = "a system of FMUs for Co-Simulation with linear connections and parameter sets is read, by SSP 1.0";

/// The admissible children of elements. Geometry and annotations do not affect the motion, and connectors repeat the FMUs.
const CHILDREN: [(&str, &[&str]); 9] = [
    ("SystemStructureDescription", &["System", "Enumerations", "Units", "DefaultExperiment", "Annotations"]),
    (
        "System",
        &[
            "Connectors",
            "ElementGeometry",
            "ParameterBindings",
            "Elements",
            "Connections",
            "SystemGeometry",
            "GraphicalElements",
            "Annotations",
        ],
    ),
    ("Elements", &["Component"]),
    ("Component", &["Connectors", "ElementGeometry", "ParameterBindings", "Annotations"]),
    ("ParameterBindings", &["ParameterBinding"]),
    ("ParameterBinding", &["ParameterValues", "Annotations"]),
    ("ParameterSet", &["Parameters", "Enumerations", "Units", "Annotations"]),
    ("Connections", &["Connection"]),
    ("Connection", &["LinearTransformation", "ConnectionGeometry", "Annotations"]),
];

/// The values that attributes may have.
const VALUES: [(&str, &str, &[&str]); 6] = [
    ("SystemStructureDescription", "version", &["1.0"]),
    ("ParameterSet", "version", &["1.0"]),
    ("Component", "type", &["application/x-fmu-sharedlibrary"]),
    ("Component", "implementation", &["CoSimulation", "any"]),
    ("ParameterBinding", "type", &["application/x-ssp-parameter-set"]),
    ("ParameterBinding", "sourceBase", &["SSD"]),
];

/// Reads an archive whose parts are FMUs for Co-Simulation. The exchange is `interpolated`.
///
/// # Errors
/// A file that is no such archive; an unsupported element of SSP, by its name; unknown parts or variables; files outside.
pub fn read(path: &Path) -> Result<System, Fault> {
    let folder = Arc::new(unpacked(path, &[""])?);
    // Messages about files mean the files in the archive.
    let outside = format!("{}{}", folder.path().display(), std::path::MAIN_SEPARATOR);
    system(path, folder).map_err(|fault| {
        let message = fault.sentence().replace(&outside, "");
        fault.with_message(message)
    })
}

fn system(path: &Path, folder: Arc<TemporaryFolder>) -> Result<System, Fault> {
    let file = |uri: &str| {
        let place = folder.path().join(inside(uri)?);
        let missing = || Fault::new(format!("{uri} is not in the archive")).hint(HINT);
        place.is_file().then_some(place).ok_or_else(missing)
    };
    let document = |uri: &str| {
        let text = std::fs::read_to_string(file(uri)?).map_err(|e| Fault::new(format!("{uri} cannot be read: {e}")))?;
        let root = Element::read(&text).map_err(|fault| Fault::new(format!("{uri}, {fault}")))?;
        is_read(&root).map_err(|fault| fault.within(uri))?;
        Ok(root)
    };
    let root = document(STRUCTURE)?;
    root.needed("version")?;
    let own = root.child("System").ok_or_else(|| Fault::new(format!("{STRUCTURE}: there is no <System>")))?;
    let (stop, mut notes) = experiment(&root)?;
    let mut parts: Vec<Part> = Vec::new();
    for element in own.list("Elements") {
        let name = element.needed("name")?;
        let told = |fault: Fault| fault.within(format_args!("part {name}"));
        if parts.iter().any(|part| part.name == name) {
            return Err(Fault::new(format!("two parts are called {name}")));
        }
        let place = file(element.needed("source")?).map_err(told)?;
        let mut part = Part::foreign(name, place).map_err(told)?;
        for parameter in parameters(element, &document).map_err(told)? {
            part.set_start(&parameter.name, &parameter).map_err(told)?;
        }
        parts.push(part);
    }
    if parts.is_empty() {
        return Err(Fault::new(format!("{STRUCTURE}: the system has no parts")));
    }
    for parameter in parameters(own, &document)? {
        let name = &parameter.name;
        let of_part = |part: &&mut Part| name.strip_prefix(&part.name).is_some_and(|rest| rest.starts_with('.'));
        let part = parts.iter_mut().find(of_part).ok_or_else(|| Fault::new(format!("`{name}` belongs to no part")))?;
        let own = name[part.name.len() + 1..].to_owned();
        part.set_start(&own, &parameter).map_err(|fault| fault.within(format_args!("part {}", part.name)))?;
    }
    let connections = own.list("Connections").iter().map(|element| connection(element, &parts));
    let connections: Vec<Connection> = connections.collect::<Result<_, Fault>>()?;
    for (i, Connection { to, .. }) in connections.iter().enumerate() {
        if connections[..i].iter().any(|other| other.to == *to) {
            return Err(Fault::new(format!("`{}.{}` is connected twice", parts[to.0].name, to.1)));
        }
    }
    let (exchange, step) = (Exchange::Interpolated, stop / STEPS);
    let judged = SystemAnalysis::new(&parts.iter().collect::<Vec<_>>(), &connections, exchange);
    let (shafts, repeats) = judged.shafts(None, step);
    notes.extend(judged.notes);
    Ok(System {
        name: own.get("name").or(root.get("name")).unwrap_or("system").to_owned(),
        stop,
        step,
        exchange,
        repeats,
        asked: None,
        parts,
        connections,
        shafts,
        notes,
        files: vec![path.to_owned()],
        _folder: Some(folder.clone()),
    })
}

/// Refuses unsupported parts of an element.
fn is_read(element: &Element) -> Result<(), Fault> {
    let tag = match element.get("name") {
        Some(name) => format!("<{} name=\"{name}\">", element.name),
        None => format!("<{}>", element.name),
    };
    let values = VALUES.iter().filter(|(name, ..)| *name == element.name);
    for (_, attribute, known) in values {
        if let Some(value) = element.get(attribute).filter(|value| !known.contains(value)) {
            let known = known.join(" or ");
            return Err(Fault::new(format!("{tag}: {attribute}=\"{value}\" is not read; expected {known}")).hint(HINT));
        }
    }
    let children = CHILDREN.iter().find(|(name, _)| *name == element.name);
    for child in &element.children {
        if children.is_some_and(|(_, known)| !known.contains(&&*child.name)) {
            return Err(Fault::new(format!("{tag}: <{}> is not read", child.name)).hint(HINT));
        }
        // Other tools may write anything there.
        if child.name != "Annotations" {
            is_read(child)?;
        }
    }
    Ok(())
}

/// The path in the archive for a URI.
fn inside(uri: &str) -> Result<PathBuf, Fault> {
    let path = decoded(uri).ok_or_else(|| Fault::new(format!("{uri} is no URI")))?;
    let is_inside = Path::new(&path).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if is_inside && !path.contains(['\\', ':']) {
        return Ok(PathBuf::from(path));
    }
    let hint = "put it into the archive, usually below resources/";
    Err(Fault::new(format!("{uri} leads out of the archive")).hint(hint))
}

/// The text of a URI, in which %20 is a blank.
fn decoded(uri: &str) -> Option<String> {
    let mut parts = uri.split('%');
    let mut bytes = parts.next()?.as_bytes().to_vec();
    for part in parts {
        let (code, rest) = part.split_at_checked(2)?;
        bytes.push(u8::from_str_radix(code, 16).ok()?);
        bytes.extend(rest.bytes());
    }
    String::from_utf8(bytes).ok()
}

/// The end of a run (s), with a note if the structure has none.
fn experiment(root: &Element) -> Result<(f64, Vec<String>), Fault> {
    let told = |name| root.child("DefaultExperiment").map_or(Ok(None), |experiment| experiment.number::<f64>(name));
    let refused = |name: &str, value: f64, expected: &str| {
        Err(Fault::new(format!(
            "{STRUCTURE}, <DefaultExperiment>: {name}=\"{value}\" is not read; expected {expected}"
        )))
    };
    match (told("startTime")?, told("stopTime")?) {
        (Some(start), _) if start != 0.0 => refused("startTime", start, "0: a system starts at 0 s"),
        (_, Some(stop)) if !(stop > 0.0 && stop.is_finite()) => refused("stopTime", stop, "a time after 0 s"),
        (_, Some(stop)) => Ok((stop, Vec::new())),
        (_, None) => Ok((STOP, vec![format!("{STRUCTURE} has no stopTime, so the run ends at {STOP} s")])),
    }
}

/// A parameter from a set.
struct Parameter {
    name: String,
    value: String,
    unit: Option<String>,
}

impl Part {
    /// Sets the variable `name`.
    fn set_start(&mut self, name: &str, Parameter { value, unit, .. }: &Parameter) -> Result<(), Fault> {
        let Some(variable) = self.description.variable(name) else {
            return Err(Fault::new(format!("`{name}`, which a parameter sets, is no variable")));
        };
        if let Some(unit) = unit.as_ref().filter(|unit| **unit != variable.unit.name) {
            let own = if variable.unit.name.is_empty() { "no unit" } else { &variable.unit.name };
            let hint = "write the value in the unit of the FMU";
            return Err(Fault::new(format!("the parameter `{name}` is in {unit}, in the FMU in {own}")).hint(hint));
        }
        let item = variable.items.iter().find(|(item, _)| item == value);
        let number = match (&variable.about.kind, value.as_str()) {
            (Kind::Boolean, "true" | "1") => Some(1.0),
            (Kind::Boolean, "false" | "0") => Some(0.0),
            (Kind::Boolean, _) => None,
            _ => item
                .map(|(_, number)| f64::from(*number))
                .or(value.parse().ok())
                .filter(|number: &f64| number.is_finite()),
        };
        let number =
            number.ok_or_else(|| Fault::new(format!("the parameter `{name}` is \"{value}\", no value of its type")))?;
        variable.about.check(variable.unit.to_si(number))?;
        self.start.retain(|(other, _)| other != name);
        self.start.push((name.to_owned(), number));
        Ok(())
    }
}

/// The parameters bound to an element.
fn parameters(element: &Element, document: &impl Fn(&str) -> Result<Element, Fault>) -> Result<Vec<Parameter>, Fault> {
    let mut all = Vec::new();
    for binding in element.list("ParameterBindings") {
        let given = || binding.child("ParameterValues").and_then(|values| values.child("ParameterSet")).cloned();
        let set = binding.get("source").map(document).transpose()?.or_else(given);
        let set = set.filter(|set| set.name == "ParameterSet");
        let set = set.ok_or_else(|| Fault::new("a <ParameterBinding> without a <ParameterSet>"))?;
        let prefix = binding.get("prefix").unwrap_or_default();
        for parameter in set.list("Parameters") {
            let name = format!("{prefix}{}", parameter.needed("name")?);
            let value = parameter.children.iter().find(|child| child.name != "Annotations");
            let value = value.ok_or_else(|| Fault::new(format!("the parameter `{name}` has no value")))?;
            let unit = value.get("unit").map(str::to_owned);
            all.push(Parameter { value: value.needed("value")?.to_owned(), unit, name });
        }
    }
    Ok(all)
}

fn connection(element: &Element, parts: &[Part]) -> Result<Connection, Fault> {
    let end = |of: &str, connector: &str, causality: Causality| -> Result<End, Fault> {
        let variable = element.needed(connector)?;
        let Some(name) = element.get(of) else {
            let hint = "a system runs by itself: set unconnected inputs with start values of its parts";
            return Err(
                Fault::new(format!("a connection with `{variable}` of the system itself is not read")).hint(hint)
            );
        };
        let place = parts.iter().position(|part| part.name == name);
        let place = place.ok_or_else(|| Fault::new(format!("a connection with `{variable}` of no part, `{name}`")))?;
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
    let number = |name| transformation.map_or(Ok(None), |transformation| transformation.number::<f64>(name));
    let (factor, offset) = (number("factor")?.unwrap_or(1.0), number("offset")?.unwrap_or(0.0));
    if !factor.is_finite() || !offset.is_finite() {
        return Err(Fault::new(format!("`{}.{}`: factor and offset are not finite", parts[to.0].name, to.1)));
    }
    let [by, beyond] = match (of(&from, Causality::Output), of(&to, Causality::Input)) {
        (Some(output), Some(input)) if !element.is("suppressUnitConversion") && is_real(output, input) => {
            converted(output, input, true).map_err(|(said, _)| Fault::new(format!("a connection{said}")))?
        }
        _ => [1.0, 0.0],
    };
    Ok(Connection { from, to, factor: factor * by, offset: factor * beyond + offset })
}

fn is_real(output: &Variable, input: &Variable) -> bool {
    [output, input].iter().all(|variable| matches!(variable.about.kind, Kind::Real { .. }))
}
