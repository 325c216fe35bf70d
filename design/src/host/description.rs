//! What modelDescription.xml says of an FMU (FMI 2.0, section 2.2).

use crate::resource::Described;
use crate::xml::Element;
use camdrive::drives::unit::Quantity;
use camdrive::drives::variable::{Causality, Kind, Variability};
use camdrive::drives::{self, Fault};
use std::sync::{Mutex, PoisonError};

/// An FMU as its importer sees it.
#[derive(Clone, Debug)]
pub struct ModelDescription {
    /// modelName.
    pub name: String,
    /// The guid that the library compares with its own.
    pub guid: String,
    /// modelIdentifier: the name of the library.
    pub identifier: String,
    /// The variables in their order, without those of the type String, which nothing here takes.
    pub variables: Vec<Variable>,
    /// The default experiment.
    pub experiment: Experiment,
    /// What its importer may do.
    pub capabilities: Capabilities,
    /// Those of the standard's log categories of warnings and errors that the FMU has.
    pub(super) categories: Vec<String>,
}

/// A variable. A host passes values in its own unit; range and quantity of `about` are those of the coherent SI unit.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Name, text, range, causality and variability. An enumeration is an Integer here.
    pub about: drives::Description,
    /// The value reference.
    pub reference: u32,
    /// Its own unit.
    pub unit: Unit,
    /// The start value in its own unit.
    pub start: Option<f64>,
    /// Names and values of an enumeration.
    pub items: Vec<(String, i32)>,
}

/// The unit of a variable: a value v in it is `factor` · v + `offset` in the coherent SI unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// As the FMU writes it; empty where it has none.
    pub name: String,
    /// How many SI units one of it is; 1 where that is not told.
    pub factor: f64,
    /// The SI value of zero.
    pub offset: f64,
}

impl Unit {
    /// Whether values are the same in SI.
    pub fn is_si(&self) -> bool {
        (self.factor, self.offset) == (1.0, 0.0)
    }

    /// The SI value of `value`; the same bits where the unit is SI.
    pub fn to_si(&self, value: f64) -> f64 {
        if self.is_si() { value } else { self.factor * value + self.offset }
    }

    /// The value in this unit of the SI value `value`; the same bits where the unit is SI.
    pub fn of_si(&self, value: f64) -> f64 {
        if self.is_si() { value } else { (value - self.offset) / self.factor }
    }
}

/// The default experiment, as far as the FMU tells it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Experiment {
    /// Start time (s).
    pub start: Option<f64>,
    /// Stop time (s).
    pub stop: Option<f64>,
    /// Communication step (s).
    pub step: Option<f64>,
    /// Relative tolerance (1).
    pub tolerance: Option<f64>,
}

/// What the importer of an FMU may do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capabilities {
    /// Steps may differ in length.
    pub variable_steps: bool,
    /// Input derivatives are used.
    pub interpolates_inputs: bool,
    /// The highest order of output derivatives; 0 where there are none.
    pub output_derivatives: usize,
    /// States can be saved and restored.
    pub saves_states: bool,
    /// There can be one instance only in a process.
    pub only_once: bool,
}

/// The order of output derivatives of the drives.
const OUTPUT_DERIVATIVES: usize = 2;

impl ModelDescription {
    /// The place of the variable with this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.variables.iter().position(|variable| variable.about.name == name)
    }

    /// Of the FMU of a drive.
    pub(super) fn of(name: &str, guid: &str, drive: &mut Described) -> Result<Self, Fault> {
        let drives::Experiment { stop, step, tolerance } = drive.experiment();
        let mut variables = Vec::new();
        for (reference, about) in drive.descriptions().to_vec().into_iter().enumerate() {
            let unit = if let Kind::Real { quantity, .. } = about.kind { quantity.unit } else { "" };
            let settable = matches!(about.causality, Causality::Parameter | Causality::Input);
            variables.push(Variable {
                reference: reference as u32,
                unit: Unit { name: unit.to_owned(), factor: 1.0, offset: 0.0 },
                start: settable.then(|| drive.get(reference)).transpose()?,
                items: match about.kind {
                    Kind::Enumeration(e) => e.items.iter().map(|(item, _)| (*item).to_owned()).zip(1..).collect(),
                    _ => Vec::new(),
                },
                about,
            });
        }
        Ok(ModelDescription {
            name: name.to_owned(),
            guid: guid.to_owned(),
            identifier: name.to_owned(),
            variables,
            experiment: Experiment { start: Some(0.0), stop: Some(stop), step: Some(step), tolerance: Some(tolerance) },
            capabilities: Capabilities {
                variable_steps: true,
                interpolates_inputs: drive.input_derivative_order() > 0,
                output_derivatives: OUTPUT_DERIVATIVES,
                saves_states: true,
                only_once: false,
            },
            categories: vec!["logStatusWarning".to_owned()],
        })
    }

    /// Reads the text of modelDescription.xml.
    ///
    /// # Errors
    /// Text that is no such document; an FMU of another version, of Model Exchange only, or one that needs its tool.
    pub(super) fn read(text: &str) -> Result<Self, Fault> {
        let root = Element::read(text)?;
        let version = root.needed("fmiVersion")?;
        if version != "2.0" {
            let hint = "export it for FMI 2.0 Co-Simulation; most tools offer both";
            return Err(Fault::new(format!(
                "the FMU is of FMI {version}; this tool runs FMI 2.0 Co-Simulation\n  = hint: {hint}"
            )));
        }
        let Some(how) = root.child("CoSimulation") else {
            let hint = "export it for Co-Simulation: then it brings its own solver";
            return Err(Fault::new(format!(
                "the FMU is one of Model Exchange only; this tool runs FMI 2.0 Co-Simulation\n  = hint: {hint}"
            )));
        };
        if how.is("needsExecutionTool") {
            let tool = root.get("generationTool").unwrap_or("the tool that made it");
            let hint = "export it as one that runs alone";
            return Err(Fault::new(format!(
                "the FMU needs {tool} to run (needsExecutionTool); this tool runs FMUs by their library alone\n  = hint: {hint}"
            )));
        }
        let identifier = how.needed("modelIdentifier")?.to_owned();
        if identifier.is_empty() || !identifier.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c)) {
            return Err(Fault::new(format!("modelIdentifier=\"{identifier}\" is no name of a library")));
        }
        let units = root.list("UnitDefinitions").iter().map(|unit| Ok((unit.needed("name")?, SiUnit::of(unit)?)));
        let units = units.collect::<Result<Vec<_>, Fault>>()?;
        let mut variables = Vec::new();
        for variable in root.list("ModelVariables").iter().filter(|child| child.name == "ScalarVariable") {
            let named = |fault: Fault| Fault::new(format!("`{}`: {fault}", variable.get("name").unwrap_or_default()));
            variables.extend(Variable::read(variable, &units, root.list("TypeDefinitions")).map_err(named)?);
        }
        let experiment = root.child("DefaultExperiment");
        let time = |name: &str| experiment.map_or(Ok(None), |experiment| experiment.number(name));
        let standard = ["logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal"];
        let categories = root.list("LogCategories").iter().filter_map(|category| category.get("name"));
        Ok(ModelDescription {
            name: root.needed("modelName")?.to_owned(),
            guid: root.needed("guid")?.to_owned(),
            identifier,
            variables,
            experiment: Experiment {
                start: time("startTime")?,
                stop: time("stopTime")?,
                step: time("stepSize")?,
                tolerance: time("tolerance")?,
            },
            capabilities: Capabilities {
                variable_steps: how.is("canHandleVariableCommunicationStepSize"),
                interpolates_inputs: how.is("canInterpolateInputs"),
                output_derivatives: how.number("maxOutputDerivativeOrder")?.unwrap_or(0),
                saves_states: how.is("canGetAndSetFMUstate"),
                only_once: how.is("canBeInstantiatedOnlyOncePerProcess"),
            },
            categories: categories.filter(|name| standard.contains(name)).map(str::to_owned).collect(),
        })
    }
}

impl Variable {
    /// Of its element; None of a String.
    fn read(element: &Element, units: &[(&str, SiUnit)], types: &[Element]) -> Result<Option<Self>, Fault> {
        const TYPES: [&str; 4] = ["Real", "Integer", "Boolean", "Enumeration"];
        let kind_of = |element: &'_ Element| element.children.iter().position(|child| TYPES.contains(&&*child.name));
        let Some(own) = kind_of(element).map(|place| &element.children[place]) else { return Ok(None) };
        let declared = own.get("declaredType").and_then(|name| types.iter().find(|t| t.get("name") == Some(name)));
        let declared = declared.and_then(|t| kind_of(t).map(|place| &t.children[place]));
        let empty = Element::default();
        let declared = declared.unwrap_or(&empty);
        let number = |name: &str| own.number::<f64>(name).and_then(|own| Ok(own.or(declared.number(name)?)));
        let unit_name = own.get("unit").or(declared.get("unit")).unwrap_or_default();
        let si = units.iter().find(|(name, _)| *name == unit_name).map(|(_, si)| si);
        let (factor, offset) = si.map_or((1.0, 0.0), |si| (si.factor, si.offset));
        let unit = Unit { name: unit_name.to_owned(), factor, offset };
        let items = declared.all("Item").map(|item| {
            let value = item.number("value")?.ok_or_else(|| Fault::new("an item of its type has no value"))?;
            Ok((item.needed("name")?.to_owned(), value))
        });
        let items = items.collect::<Result<Vec<(String, i32)>, Fault>>()?;
        let kind = match own.name.as_str() {
            "Real" => {
                let limit = |value: Option<f64>, open: f64| value.map_or(open, |value| unit.to_si(value));
                let bounds = [limit(number("min")?, f64::NEG_INFINITY), limit(number("max")?, f64::INFINITY)];
                Kind::Real {
                    quantity: quantity(unit_name, si),
                    // A negative factor turns them over.
                    min: bounds[0].min(bounds[1]),
                    max: bounds[0].max(bounds[1]),
                    nominal: number("nominal")?,
                }
            }
            "Boolean" => Kind::Boolean,
            _ => Kind::Integer {
                min: number("min")?.map_or(i32::MIN, |value| value as i32),
                max: number("max")?.map_or(i32::MAX, |value| value as i32),
            },
        };
        let start = match own.get("start") {
            Some(_) if kind == Kind::Boolean => Some(f64::from(u8::from(own.is("start")))),
            _ => own.number("start")?,
        };
        let name = element.needed("name")?.to_owned();
        let about = drives::Description {
            key: name.clone(),
            name,
            text: element.get("description").unwrap_or_default().to_owned(),
            kind,
            causality: match element.get("causality") {
                Some("parameter") => Causality::Parameter,
                Some("input") => Causality::Input,
                Some("output") => Causality::Output,
                _ => Causality::Local,
            },
            variability: match element.get("variability") {
                Some("constant" | "fixed") => Variability::Fixed,
                Some("tunable") => Variability::Tunable,
                Some("discrete") => Variability::Discrete,
                _ => Variability::Continuous,
            },
            state: false,
            derivative_of: None,
            dependencies: Vec::new(),
            initial_dependencies: Vec::new(),
        };
        let reference = element.needed("valueReference")?;
        let reference = reference.parse().map_err(|_| Fault::new(format!("valueReference=\"{reference}\" is none")))?;
        Ok(Some(Variable { about, reference, unit, start, items }))
    }
}

/// The exponents of the SI units in the order of the standard.
const BASE: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

/// A unit of the FMU in SI.
struct SiUnit {
    /// The exponents of [`BASE`]; None where the FMU does not tell them.
    base: Option<[i8; 8]>,
    factor: f64,
    offset: f64,
}

impl SiUnit {
    fn of(unit: &Element) -> Result<Self, Fault> {
        let named = |fault: Fault| Fault::new(format!("unit \"{}\": {fault}", unit.get("name").unwrap_or_default()));
        let Some(base) = unit.child("BaseUnit") else { return Ok(SiUnit { base: None, factor: 1.0, offset: 0.0 }) };
        let mut exponents = [0; 8];
        for (exponent, name) in exponents.iter_mut().zip(BASE) {
            *exponent = base.number(name).map_err(named)?.unwrap_or(0);
        }
        let factor = base.number("factor").map_err(named)?.unwrap_or(1.0);
        let offset = base.number("offset").map_err(named)?.unwrap_or(0.0);
        if factor == 0.0 || !f64::is_finite(factor) || !f64::is_finite(offset) {
            return Err(named(Fault::new(format!("factor {factor} and offset {offset} make no unit"))));
        }
        Ok(SiUnit { base: Some(exponents), factor, offset })
    }
}

/// The quantity of a variable with this unit: without name, in coherent SI.
///
/// Quantities live as long as the program; each one is kept once, however many variables and FMUs have it.
fn quantity(name: &str, si: Option<&SiUnit>) -> &'static Quantity {
    static KEPT: Mutex<Vec<&'static Quantity>> = Mutex::new(Vec::new());
    let is_si = si.is_none_or(|si| (si.factor, si.offset) == (1.0, 0.0));
    let exponents = si.and_then(|si| si.base);
    // No unit that a person writes has the dimension of one that is not told, or of electricity, heat, light or matter.
    let base = match exponents {
        Some([kg, m, s, 0, 0, 0, 0, rad]) => [kg, m, s, rad],
        None if name.is_empty() => [0; 4],
        _ => [i8::MAX; 4],
    };
    let powers = exponents.unwrap_or_default().into_iter().zip(BASE).filter(|(power, _)| *power != 0);
    let product = powers.map(|(power, unit)| if power == 1 { unit.to_owned() } else { format!("{unit}{power}") });
    let unit = if is_si { name.to_owned() } else { product.collect::<Vec<_>>().join(".") };
    let display = si.filter(|si| !is_si && si.offset == 0.0).map(|si| (name, 1.0 / si.factor));
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    let same = |other: &&&'static Quantity| (other.unit, other.base, other.display) == (&*unit, base, display);
    if let Some(found) = kept.iter().find(same) {
        return found;
    }
    let display = display.map(|(name, factor)| (&*name.to_owned().leak(), factor));
    let new: &'static Quantity = Box::leak(Box::new(Quantity { name: "", unit: unit.leak(), base, display }));
    kept.push(new);
    new
}
