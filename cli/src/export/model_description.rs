//! modelDescription.xml (FMI 2.0, section 2.2), written from the declarations of a drive's variables.

use super::xml::{Attribute, Xml, number};
use camdrive::drives::unit::Quantity;
use camdrive::drives::variable::{Causality, Kind, Variability};
use camdrive::drives::{AnyDrive, Description, Fault};

/// The log categories of the runtime library, with their descriptions.
pub use camdrive::drives::event::LOG_CATEGORIES;

/// The highest order of output derivatives.
const OUTPUT_DERIVATIVES: usize = 2;

/// Content of the description beyond the drive itself.
#[derive(Clone, Copy, Debug)]
pub struct Identity<'a> {
    /// modelName and modelIdentifier.
    pub name: &'a str,
    /// One or two sentences.
    pub description: &'a str,
    /// The guid.
    pub guid: &'a str,
    /// generationDateAndTime, if there is one.
    pub date: Option<&'a str>,
}

/// The text of modelDescription.xml.
///
/// # Errors
/// A start value that cannot be read, or a dependency on a variable that does not exist.
pub fn xml(identity: &Identity, drive: &mut AnyDrive) -> Result<String, Fault> {
    let starts = start_values(drive)?;
    let descriptions = drive.descriptions();
    let structure = Structure::of(descriptions)?;
    let mut xml = Xml::document();
    xml.element("fmiModelDescription", &head(identity), |xml| {
        xml.empty("CoSimulation", &capabilities(identity.name, drive.input_derivative_order()));
        unit_definitions(xml, descriptions);
        type_definitions(xml, descriptions);
        xml.element("LogCategories", &[], |xml| {
            for (name, text) in LOG_CATEGORIES {
                xml.empty(
                    "Category",
                    &[("name", name.to_string_lossy().into_owned()), ("description", text.to_owned())],
                );
            }
        });
        let e = drive.experiment();
        let experiment = [("startTime", 0.0), ("stopTime", e.stop), ("tolerance", e.tolerance), ("stepSize", e.step)];
        xml.empty("DefaultExperiment", &experiment.map(|(key, value)| (key, number(value))));
        xml.element("ModelVariables", &[], |xml| {
            for (reference, d) in descriptions.iter().enumerate() {
                scalar_variable(xml, reference, d, starts[reference], structure.derivative_of[reference]);
            }
        });
        structure.write(xml);
    });
    Ok(xml.finish())
}

fn head(identity: &Identity) -> Vec<Attribute> {
    let mut attributes = vec![
        ("fmiVersion", "2.0".to_owned()),
        ("modelName", identity.name.to_owned()),
        ("guid", identity.guid.to_owned()),
        ("description", identity.description.to_owned()),
        ("license", env!("CARGO_PKG_LICENSE").to_owned()),
        ("generationTool", super::TOOL.to_owned()),
    ];
    attributes.extend(identity.date.map(|date| ("generationDateAndTime", date.to_owned())));
    attributes.push(("variableNamingConvention", "structured".to_owned()));
    attributes
}

fn capabilities(identifier: &str, input_derivatives: usize) -> Vec<Attribute> {
    vec![
        ("modelIdentifier", identifier.to_owned()),
        ("needsExecutionTool", "false".to_owned()),
        ("canHandleVariableCommunicationStepSize", "true".to_owned()),
        ("canInterpolateInputs", (input_derivatives > 0).to_string()),
        ("maxOutputDerivativeOrder", OUTPUT_DERIVATIVES.to_string()),
        ("canRunAsynchronuously", "false".to_owned()),
        ("canBeInstantiatedOnlyOncePerProcess", "false".to_owned()),
        ("canNotUseMemoryManagementFunctions", "true".to_owned()),
        ("canGetAndSetFMUstate", "true".to_owned()),
        ("canSerializeFMUstate", "true".to_owned()),
        ("providesDirectionalDerivative", "true".to_owned()),
    ]
}

/// The values of parameters and inputs after instantiation.
fn start_values(drive: &mut AnyDrive) -> Result<Vec<Option<f64>>, Fault> {
    let has_start: Vec<bool> =
        drive.descriptions().iter().map(|d| matches!(d.causality, Causality::Parameter | Causality::Input)).collect();
    has_start.iter().enumerate().map(|(reference, has)| has.then(|| drive.get(reference)).transpose()).collect()
}

fn unit_definitions(xml: &mut Xml, descriptions: &[Description]) {
    let mut units: Vec<&str> = Vec::new();
    let quantities = || {
        descriptions.iter().filter_map(|d| match d.kind {
            Kind::Real { quantity, .. } => Some(quantity),
            _ => None,
        })
    };
    for q in quantities() {
        if !units.contains(&q.unit) {
            units.push(q.unit);
        }
    }
    xml.element("UnitDefinitions", &[], |xml| {
        for unit in units {
            xml.element("Unit", &[("name", unit.to_owned())], |xml| {
                let mut display: Vec<(&str, f64)> = Vec::new();
                let mut base = [0; 4];
                for q in quantities().filter(|q| q.unit == unit) {
                    base = q.base;
                    display.extend(q.display.filter(|d| !display.contains(d)));
                }
                let exponents: Vec<Attribute> = ["kg", "m", "s", "rad"]
                    .into_iter()
                    .zip(base)
                    .filter(|(_, exponent)| *exponent != 0)
                    .map(|(name, exponent)| (name, exponent.to_string()))
                    .collect();
                xml.empty("BaseUnit", &exponents);
                for (name, factor) in display {
                    xml.empty("DisplayUnit", &[("name", name.to_owned()), ("factor", number(factor))]);
                }
            });
        }
    });
}

fn type_definitions(xml: &mut Xml, descriptions: &[Description]) {
    let mut types = Vec::new();
    for d in descriptions {
        if let Kind::Enumeration(e) = d.kind
            && !types.contains(&e)
        {
            types.push(e);
        }
    }
    if types.is_empty() {
        return;
    }
    xml.element("TypeDefinitions", &[], |xml| {
        for e in types {
            xml.element("SimpleType", &[("name", e.name.to_owned())], |xml| {
                xml.element("Enumeration", &[], |xml| {
                    for (i, (name, text)) in e.items.iter().enumerate() {
                        let number = (i + 1).to_string();
                        xml.empty(
                            "Item",
                            &[("name", (*name).to_owned()), ("value", number), ("description", (*text).to_owned())],
                        );
                    }
                });
            });
        }
    });
}

fn scalar_variable(xml: &mut Xml, reference: usize, d: &Description, start: Option<f64>, derivative_of: Option<usize>) {
    let mut attributes = vec![
        ("name", d.name.clone()),
        ("valueReference", reference.to_string()),
        ("description", d.text.clone()),
        ("causality", causality(d.causality).to_owned()),
        ("variability", variability(d.variability).to_owned()),
    ];
    attributes.extend(initial(d.causality).map(|initial| ("initial", initial.to_owned())));
    xml.element("ScalarVariable", &attributes, |xml| match &d.kind {
        Kind::Real { quantity, min, max, nominal } => {
            let mut real = Vec::new();
            if !quantity.name.is_empty() {
                real.push(("quantity", quantity.name.to_owned()));
            }
            real.push(("unit", quantity.unit.to_owned()));
            real.extend(quantity.display.map(|(name, _)| ("displayUnit", name.to_owned())));
            for (key, border) in [("min", *min), ("max", *max)] {
                if border.is_finite() {
                    real.push((key, number(border)));
                }
            }
            let parameter = d.causality == Causality::Parameter;
            let nominal = nominal.or_else(|| parameter.then(|| usual_magnitude(quantity, start)));
            real.extend(nominal.map(|value| ("nominal", number(value))));
            real.extend(start.map(|value| ("start", number(value))));
            real.extend(derivative_of.map(|index| ("derivative", (index + 1).to_string())));
            xml.empty("Real", &real);
        }
        Kind::Integer { min, max } => {
            let mut integer = Vec::new();
            for (key, border, open) in [("min", *min, i32::MIN), ("max", *max, i32::MAX)] {
                if border != open {
                    integer.push((key, border.to_string()));
                }
            }
            integer.extend(start.map(|value| ("start", (value as i32).to_string())));
            xml.empty("Integer", &integer);
        }
        Kind::Boolean => {
            let start = start.map(|value| ("start", (value != 0.0).to_string()));
            xml.empty("Boolean", &start.into_iter().collect::<Vec<_>>());
        }
        Kind::Enumeration(e) => {
            let mut enumeration = vec![("declaredType", e.name.to_owned())];
            enumeration.push(("min", "1".to_owned()));
            enumeration.push(("max", e.items.len().to_string()));
            enumeration.extend(start.map(|value| ("start", (value as i32).to_string())));
            xml.empty("Enumeration", &enumeration);
        }
    });
}

/// The magnitude of a parameter: its start value's, or a usual one of its unit.
fn usual_magnitude(quantity: &Quantity, start: Option<f64>) -> f64 {
    match start {
        Some(start) if start != 0.0 => start.abs(),
        _ => quantity.usual(),
    }
}

/// The unit of a value, or empty.
pub fn unit(kind: &Kind) -> &'static str {
    match kind {
        Kind::Real { quantity, .. } => quantity.unit,
        _ => "",
    }
}

/// The word of the standard.
pub fn causality(causality: Causality) -> &'static str {
    match causality {
        Causality::Parameter => "parameter",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Local => "local",
    }
}

/// The word of the standard.
pub fn variability(variability: Variability) -> &'static str {
    match variability {
        Variability::Fixed => "fixed",
        Variability::Tunable => "tunable",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
    }
}

/// Section 2.2.7: parameters are exact, and everything else is calculated from them; inputs have no `initial`.
fn initial(causality: Causality) -> Option<&'static str> {
    match causality {
        Causality::Parameter => Some("exact"),
        Causality::Input => None,
        Causality::Output | Causality::Local => Some("calculated"),
    }
}

/// ModelStructure: positions in the list of variables.
struct Structure {
    outputs: Vec<Unknown>,
    derivatives: Vec<Unknown>,
    initial_unknowns: Vec<Unknown>,
    derivative_of: Vec<Option<usize>>,
}

/// An unknown and the variables it depends on, ascending.
struct Unknown {
    position: usize,
    dependencies: Vec<usize>,
}

impl Structure {
    fn of(descriptions: &[Description]) -> Result<Self, Fault> {
        let position = |d: &Description, name: &String| {
            let found = descriptions.iter().position(|other| other.name == *name);
            found.ok_or_else(|| Fault::new(format!("`{}` refers to `{name}`, which is not a variable", d.name)))
        };
        let derivative_of: Vec<Option<usize>> = descriptions
            .iter()
            .map(|d| d.derivative_of.as_ref().map(|name| position(d, name)).transpose())
            .collect::<Result<_, _>>()?;
        // Derivatives are in the order of their states.
        let mut derivatives: Vec<usize> = (0..descriptions.len())
            .filter(|&p| derivative_of[p].is_some_and(|state| descriptions[state].state))
            .collect();
        derivatives.sort_by_key(|&p| derivative_of[p]);
        let outputs: Vec<usize> =
            (0..descriptions.len()).filter(|&p| descriptions[p].causality == Causality::Output).collect();
        // Section 2.2.8: outputs, states and their derivatives, if they are calculated; each once.
        let initial_unknowns: Vec<usize> = (0..descriptions.len())
            .filter(|p| {
                initial(descriptions[*p].causality) == Some("calculated")
                    && (outputs.contains(p) || derivatives.contains(p) || descriptions[*p].state)
            })
            .collect();
        let list = |positions: Vec<usize>, depends: fn(&Description, &Description) -> bool| -> Vec<Unknown> {
            let dependencies =
                |u: &usize| (0..descriptions.len()).filter(|&k| depends(&descriptions[*u], &descriptions[k])).collect();
            positions.into_iter().map(|position| Unknown { dependencies: dependencies(&position), position }).collect()
        };
        for d in descriptions {
            d.dependencies.iter().try_for_each(|name| position(d, name).map(|_| ()))?;
        }
        let directly = |unknown: &Description, known: &Description| unknown.dependencies.contains(&known.name);
        Ok(Structure {
            outputs: list(outputs, directly),
            derivatives: list(derivatives, directly),
            initial_unknowns: list(initial_unknowns, Description::depends_initially_on),
            derivative_of,
        })
    }

    fn write(&self, xml: &mut Xml) {
        xml.element("ModelStructure", &[], |xml| {
            let lists = [
                ("Outputs", &self.outputs),
                ("Derivatives", &self.derivatives),
                ("InitialUnknowns", &self.initial_unknowns),
            ];
            for (name, unknowns) in lists.into_iter().filter(|(_, unknowns)| !unknowns.is_empty()) {
                xml.element(name, &[], |xml| {
                    for unknown in unknowns {
                        xml.empty("Unknown", &unknown.attributes());
                    }
                });
            }
        });
    }
}

impl Unknown {
    /// The standard counts from 1; "dependent" only says that the relation may be nonlinear.
    fn attributes(&self) -> [Attribute; 3] {
        let indices: Vec<String> = self.dependencies.iter().map(|p| (p + 1).to_string()).collect();
        let kinds = vec!["dependent"; self.dependencies.len()];
        [
            ("index", (self.position + 1).to_string()),
            ("dependencies", indices.join(" ")),
            ("dependenciesKind", kinds.join(" ")),
        ]
    }
}
