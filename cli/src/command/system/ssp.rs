//! System Structure and Parameterization 1.0: an archive with the FMUs, how they are connected, and what is set at the start.

use super::{Started, factor_of};
use crate::export::xml::{Attribute, Xml, number};
use crate::system::{Connection, Part, System};
use camdrive::drives::variable::{Causality, Kind};
use camdrive_design::host::Variable;

/// The file that makes an archive a system.
pub const FILE: &str = "SystemStructure.ssd";
/// Names of exponents, in the order of a quantity's exponents.
const BASE: [&str; 4] = ["kg", "m", "s", "rad"];

/// The description of the system; `files` are the FMUs of its parts.
pub fn xml(system: &System, files: &[String]) -> String {
    let name = || ("name", system.name.clone());
    let space =
        |short: &'static str, long: &str| (short, format!("http://ssp-standard.org/SSP1/SystemStructure{long}"));
    let head = [
        space("xmlns:ssd", "Description"),
        space("xmlns:ssc", "Common"),
        space("xmlns:ssv", "ParameterValues"),
        ("version", "1.0".to_owned()),
        name(),
        ("generationTool", crate::export::TOOL.to_owned()),
    ];
    let mut xml = Xml::document();
    xml.element("ssd:SystemStructureDescription", &head, |xml| {
        xml.element("ssd:System", &[name()], |xml| {
            xml.element("ssd:Elements", &[], |xml| {
                for (i, (part, file)) in system.parts.iter().zip(files).enumerate() {
                    component(xml, system, (i, part), file);
                }
            });
            xml.element("ssd:Connections", &[], |xml| {
                system.connections.iter().for_each(|c| connection(xml, system, c))
            });
        });
        units(xml, system);
        let times = [("startTime", 0.0), ("stopTime", system.stop)];
        xml.empty("ssd:DefaultExperiment", &times.map(|(key, time)| (key, number(time))));
    });
    xml.finish()
}

/// The start values of a part, in the parameter set of the system; masters find the set by its name and look for it in the
/// components.
fn parameters(xml: &mut Xml, system: &System, part: &Part) {
    xml.element("ssd:ParameterBindings", &[], |xml| {
        xml.element("ssd:ParameterBinding", &[], |xml| {
            xml.element("ssd:ParameterValues", &[], |xml| {
                let head = [("version", "1.0".to_owned()), ("name", system.name.clone())];
                xml.element("ssv:ParameterSet", &head, |xml| {
                    xml.element("ssv:Parameters", &[], |xml| {
                        for Started { name, kind, value } in super::started(part) {
                            xml.element("ssv:Parameter", &[("name", name)], |xml| {
                                xml.empty(&format!("ssv:{kind}"), &[("value", value)]);
                            });
                        }
                    });
                });
            });
        });
    });
}

/// True if a variable is a connector: an output, or a connected input. Some masters start other inputs at 0.
fn is_connector(system: &System, part: usize, variable: &Variable) -> bool {
    let name = &variable.about.name;
    match variable.about.causality {
        Causality::Output => true,
        Causality::Input => system.connections.iter().any(|c| c.to.0 == part && c.to.1 == *name),
        _ => false,
    }
}

fn component(xml: &mut Xml, system: &System, (i, part): (usize, &Part), file: &str) {
    let attributes = [
        ("name", part.name.clone()),
        ("source", format!("resources/{file}")),
        ("type", "application/x-fmu-sharedlibrary".to_owned()),
        ("implementation", "CoSimulation".to_owned()),
    ];
    xml.element("ssd:Component", &attributes, |xml| {
        xml.element("ssd:Connectors", &[], |xml| {
            for variable in part.description.variables.iter().filter(|variable| is_connector(system, i, variable)) {
                let kind = if variable.about.causality == Causality::Input { "input" } else { "output" };
                let attributes = [("name", variable.about.name.clone()), ("kind", kind.to_owned())];
                xml.element("ssd:Connector", &attributes, |xml| match &variable.about.kind {
                    Kind::Real { .. } => {
                        let unit: Vec<Attribute> = unit(variable).map(|(name, _)| ("unit", name)).into_iter().collect();
                        xml.empty("ssc:Real", &unit);
                    }
                    Kind::Boolean => xml.empty("ssc:Boolean", &[]),
                    Kind::Integer { .. } | Kind::Enumeration(_) => xml.empty("ssc:Integer", &[]),
                });
            }
        });
        parameters(xml, system, part);
    });
}

fn connection(xml: &mut Xml, system: &System, connection: &Connection) {
    let Connection { from, to, factor, offset } = connection;
    let mut attributes = vec![
        ("startElement", system.parts[from.0].name.clone()),
        ("startConnector", from.1.clone()),
        ("endElement", system.parts[to.0].name.clone()),
        ("endConnector", to.1.clone()),
    ];
    let unit_of =
        |(part, name): &(usize, String)| system.parts[*part].description.variable(name).map(|v| v.unit.name.clone());
    // Factor and offset alone change the value.
    if unit_of(from) != unit_of(to) {
        attributes.push(("suppressUnitConversion", "true".to_owned()));
    }
    match factor_of(connection) {
        None => xml.empty("ssd:Connection", &attributes),
        Some(()) => xml.element("ssd:Connection", &attributes, |xml| {
            let transformation = [("factor", number(*factor)), ("offset", number(*offset))];
            xml.empty("ssc:LinearTransformation", &transformation);
        }),
    }
}

/// The unit of a Real in its FMU, with base, factor and offset; None if it is beyond mechanics or unknown.
fn unit(variable: &Variable) -> Option<(String, Vec<Attribute>)> {
    let Kind::Real { quantity, .. } = variable.about.kind else { return None };
    if variable.unit.name.is_empty() || quantity.base[0] == i8::MAX {
        return None;
    }
    let exponents = BASE.into_iter().zip(quantity.base).filter(|(_, exponent)| *exponent != 0);
    let mut base: Vec<Attribute> = exponents.map(|(name, exponent)| (name, exponent.to_string())).collect();
    let scale = [("factor", variable.unit.factor, 1.0), ("offset", variable.unit.offset, 0.0)];
    base.extend(
        scale.into_iter().filter(|(_, value, usual)| value != usual).map(|(key, value, _)| (key, number(value))),
    );
    Some((variable.unit.name.clone(), base))
}

fn units(xml: &mut Xml, system: &System) {
    let mut all: Vec<(String, Vec<Attribute>)> = Vec::new();
    for (i, part) in system.parts.iter().enumerate() {
        for variable in part.description.variables.iter().filter(|variable| is_connector(system, i, variable)) {
            if let Some(unit) = unit(variable).filter(|(name, _)| all.iter().all(|(known, _)| known != name)) {
                all.push(unit);
            }
        }
    }
    if !all.is_empty() {
        xml.element("ssd:Units", &[], |xml| {
            for (name, base) in all {
                xml.element("ssc:Unit", &[("name", name)], |xml| xml.empty("ssc:BaseUnit", &base));
            }
        });
    }
}
