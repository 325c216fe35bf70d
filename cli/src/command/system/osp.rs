//! The system structure of the Open Simulation Platform (OSP-IS), next to the FMUs.

use super::{Started, factor_of};
use crate::export::xml::{Xml, number};
use crate::system::{End, System};

/// The file that libcosim looks for.
pub const FILE: &str = "OspSystemStructure.xml";

/// The system structure; `files` are the FMUs of its parts.
pub fn xml(system: &System, files: &[String]) -> String {
    let head = [
        ("xmlns", "http://opensimulationplatform.com/MSMI/OSPSystemStructure".to_owned()),
        ("version", "0.1".to_owned()),
    ];
    let mut xml = Xml::document();
    xml.element("OspSystemStructure", &head, |xml| {
        xml.text("StartTime", &[], "0.0");
        xml.text("EndTime", &[], &number(system.stop));
        xml.text("BaseStepSize", &[], &number(system.step));
        xml.text("Algorithm", &[], "fixedStep");
        xml.element("Simulators", &[], |xml| {
            for (part, file) in system.parts.iter().zip(files) {
                let attributes = [("name", part.name.clone()), ("source", file.clone())];
                let started = super::started(part);
                if started.is_empty() {
                    xml.empty("Simulator", &attributes);
                    continue;
                }
                xml.element("Simulator", &attributes, |xml| {
                    xml.element("InitialValues", &[], |xml| {
                        for Started { name, kind, value } in started {
                            xml.element("InitialValue", &[("variable", name)], |xml| {
                                xml.empty(kind, &[("value", value)])
                            });
                        }
                    });
                });
            }
        });
        // Factor and offset are a function between two signals.
        let functions = || system.connections.iter().enumerate().filter(|(_, c)| factor_of(c).is_some());
        if functions().next().is_some() {
            xml.element("Functions", &[], |xml| {
                for (i, c) in functions() {
                    let values = [("name", function(i)), ("factor", number(c.factor)), ("offset", number(c.offset))];
                    xml.empty("LinearTransformation", &values);
                }
            });
        }
        xml.element("Connections", &[], |xml| {
            for (i, c) in system.connections.iter().enumerate() {
                match factor_of(c) {
                    None => xml.element("VariableConnection", &[], |xml| {
                        variable(xml, system, &c.from);
                        variable(xml, system, &c.to);
                    }),
                    Some(()) => {
                        for (end, signal) in [(&c.from, "in"), (&c.to, "out")] {
                            xml.element("SignalConnection", &[], |xml| {
                                variable(xml, system, end);
                                xml.empty("Signal", &[("function", function(i)), ("name", signal.to_owned())]);
                            });
                        }
                    }
                }
            }
        });
    });
    xml.finish()
}

/// The name of the function of a connection.
fn function(connection: usize) -> String {
    format!("connection_{}", connection + 1)
}

fn variable(xml: &mut Xml, system: &System, (part, name): &End) {
    xml.empty("Variable", &[("simulator", system.parts[*part].name.clone()), ("name", name.clone())]);
}
