//! The model description of an FMU, modelDescription.xml (FMI 2.0, section 2.2).

use crate::resource::Described;
use crate::xml::Element;
use camdrive::drives::unit::Quantity;
use camdrive::drives::variable::{Causality, Kind, Variability};
use camdrive::drives::{self, Fault};
use std::collections::{BTreeMap, HashMap};
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
    /// The variables in their order, without String variables, which nothing here needs.
    pub variables: Vec<Variable>,
    /// The default experiment.
    pub experiment: Experiment,
    /// Its capabilities.
    pub capabilities: Capabilities,
    /// The program that must be on this computer, because the library only communicates with it.
    pub needs_tool: Option<String>,
    /// The standard's log categories of warnings and errors that the FMU has.
    pub(super) categories: Vec<String>,
    /// Its units, also those that are only displayed.
    units: Vec<SiUnit>,
    /// The index of each name among the variables; the first one counts.
    places: HashMap<String, usize>,
}

/// A variable. A host passes values in its own unit; range and quantity of `about` are in the coherent SI unit.
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
    /// True if an output may depend on every input, because the FMU does not declare its dependencies.
    pub by_all: bool,
}

/// The unit of a variable: a value v in it is `factor` · v + `offset` in the coherent SI unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// As the FMU writes it; empty without a unit.
    pub name: String,
    /// Its size in SI units; 1 if not given.
    pub factor: f64,
    /// The SI value of zero.
    pub offset: f64,
}

impl Unit {
    /// True if values are the same in SI.
    pub fn is_si(&self) -> bool {
        (self.factor, self.offset) == (1.0, 0.0)
    }

    /// The SI value of `value`; bitwise equal if the unit is SI.
    pub fn to_si(&self, value: f64) -> f64 {
        if self.is_si() { value } else { self.factor * value + self.offset }
    }

    /// The value in this unit of the SI value `value`; bitwise equal if the unit is SI.
    pub fn of_si(&self, value: f64) -> f64 {
        if self.is_si() { value } else { (value - self.offset) / self.factor }
    }
}

/// The default experiment, as far as the FMU has one.
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

/// The capabilities of an FMU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capabilities {
    /// Steps may differ in length.
    pub variable_steps: bool,
    /// Input derivatives are used.
    pub interpolates_inputs: bool,
    /// The highest order of output derivatives; 0 without any.
    pub output_derivatives: usize,
    /// States can be saved and restored.
    pub saves_states: bool,
    /// There can be one instance only in a process.
    pub only_once: bool,
}

/// The order of output derivatives of the drives.
const OUTPUT_DERIVATIVES: usize = 2;

impl ModelDescription {
    /// The index of the variable with this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.places.get(name).copied()
    }

    /// The variable with this name.
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.find(name).map(|place| &self.variables[place])
    }

    /// The unit of this name in the FMU, if it has the quantity of a variable.
    pub fn unit(&self, variable: usize, name: &str) -> Option<&Unit> {
        let find = |name: &str| self.units.iter().find(|other| other.unit.name == name);
        let own = find(&self.variables[variable].unit.name)?;
        find(name)
            .filter(|other| other.unit == own.unit || (other.base.is_some() && other.base == own.base))
            .map(|other| &other.unit)
    }

    /// The fault of an FMU that does not start, with its possible cause.
    pub(super) fn not_started(&self, fault: Fault) -> Fault {
        match &self.needs_tool {
            Some(tool) => fault.hint(format!("the FMU needs {tool} on this machine (needsExecutionTool)")),
            None => fault,
        }
    }

    /// The description of the FMU of a drive.
    ///
    /// # Errors
    /// Start values that the drive refuses.
    pub fn of(name: &str, guid: &str, drive: &mut Described) -> Result<Self, Fault> {
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
                by_all: false,
                about,
            });
        }
        Ok(ModelDescription {
            name: name.to_owned(),
            guid: guid.to_owned(),
            identifier: name.to_owned(),
            places: places(&variables),
            variables,
            experiment: Experiment { start: Some(0.0), stop: Some(stop), step: Some(step), tolerance: Some(tolerance) },
            capabilities: Capabilities {
                variable_steps: true,
                interpolates_inputs: drive.input_derivative_order() > 0,
                output_derivatives: OUTPUT_DERIVATIVES,
                saves_states: true,
                only_once: false,
            },
            needs_tool: None,
            categories: vec!["logStatusWarning".to_owned()],
            units: Vec::new(),
        })
    }

    /// Reads the text of modelDescription.xml.
    ///
    /// # Errors
    /// Text that is no such document; an FMU of another version, or for Model Exchange only.
    pub(super) fn read(text: &str) -> Result<Self, Fault> {
        let root = Element::read(text)?;
        let version = root.needed("fmiVersion")?;
        if version != "2.0" {
            let hint = "export it for FMI 2.0 Co-Simulation; most tools offer both";
            return Err(
                Fault::new(format!("the FMU uses FMI {version}; this tool runs FMI 2.0 Co-Simulation")).hint(hint)
            );
        }
        let Some(how) = root.child("CoSimulation") else {
            let hint = "export it for Co-Simulation: then it brings its own solver";
            let fault = "the FMU is for Model Exchange only; this tool runs FMI 2.0 Co-Simulation";
            return Err(Fault::new(fault).hint(hint));
        };
        let identifier = how.needed("modelIdentifier")?.to_owned();
        if identifier.is_empty() || !identifier.chars().all(|c| c.is_alphanumeric() || "_-.".contains(c)) {
            return Err(Fault::new(format!("modelIdentifier=\"{identifier}\" is no name of a library")));
        }
        let units = root.list("UnitDefinitions").iter().map(SiUnit::read).collect::<Result<Vec<_>, _>>()?.concat();
        let mut variables = Vec::new();
        let all: Vec<&Element> =
            root.list("ModelVariables").iter().filter(|child| child.name == "ScalarVariable").collect();
        let names: Vec<&str> = all.iter().map(|variable| variable.get("name").unwrap_or_default()).collect();
        let known = dependencies(&root, &names)?;
        // By their names, because an FMU may have as many types and units as variables; the first one of a name counts.
        let types = first_of(root.list("TypeDefinitions").iter().filter_map(|t| Some((t.get("name")?, t))));
        let si = first_of(units.iter().map(|si| (si.unit.name.as_str(), si)));
        for (variable, name) in all.iter().zip(&names) {
            let named = |fault: Fault| fault.within(format_args!("`{name}`"));
            let mut read = Variable::read(variable, &si, &types).map_err(named)?;
            if let (Some(variable), Some(known)) = (&mut read, known.get(name)) {
                variable.by_all = false;
                variable.about.dependencies = known.iter().map(|name| (*name).to_owned()).collect();
            }
            variables.extend(read);
        }
        let experiment = root.child("DefaultExperiment");
        let time = |name: &str| experiment.map_or(Ok(None), |experiment| experiment.number(name));
        let standard = ["logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal"];
        let categories = root.list("LogCategories").iter().filter_map(|category| category.get("name"));
        Ok(ModelDescription {
            name: root.needed("modelName")?.to_owned(),
            guid: root.needed("guid")?.to_owned(),
            identifier,
            places: places(&variables),
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
            needs_tool: how
                .is("needsExecutionTool")
                .then(|| root.get("generationTool").unwrap_or("the tool that made it").to_owned()),
            categories: categories.filter(|name| standard.contains(name)).map(str::to_owned).collect(),
            units,
        })
    }
}

impl Variable {
    /// The variable of its element; None for a String.
    fn read(
        element: &Element,
        units: &HashMap<&str, &SiUnit>,
        types: &HashMap<&str, &Element>,
    ) -> Result<Option<Self>, Fault> {
        const TYPES: [&str; 4] = ["Real", "Integer", "Boolean", "Enumeration"];
        let kind_of = |element: &'_ Element| element.children.iter().position(|child| TYPES.contains(&&*child.name));
        let Some(own) = kind_of(element).map(|place| &element.children[place]) else { return Ok(None) };
        let declared = own.get("declaredType").and_then(|name| types.get(name));
        let declared = declared.and_then(|t| kind_of(t).map(|place| &t.children[place]));
        let empty = Element::default();
        let declared = declared.unwrap_or(&empty);
        let number = |name: &str| own.number::<f64>(name).and_then(|own| Ok(own.or(declared.number(name)?)));
        let unit_name = own.get("unit").or(declared.get("unit")).unwrap_or_default();
        let unknown = SiUnit { base: None, unit: Unit { name: unit_name.to_owned(), factor: 1.0, offset: 0.0 } };
        let si = units.get(unit_name).copied().unwrap_or(&unknown);
        let unit = si.unit.clone();
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
                    quantity: quantity(si),
                    // A negative factor swaps them.
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
        let reference =
            reference.parse().map_err(|_| Fault::new(format!("valueReference=\"{reference}\" is not a number")))?;
        Ok(Some(Variable { about, reference, unit, start, items, by_all: true }))
    }
}

/// The index of each name; from the end, because the first one of a name counts.
fn places(variables: &[Variable]) -> HashMap<String, usize> {
    variables.iter().enumerate().rev().map(|(place, variable)| (variable.about.name.clone(), place)).collect()
}

/// The first value of each name.
fn first_of<'a, T>(all: impl Iterator<Item = (&'a str, T)>) -> HashMap<&'a str, T> {
    let mut first = HashMap::new();
    for (name, value) in all {
        first.entry(name).or_insert(value);
    }
    first
}

/// The dependencies of the outputs, by their names, if ModelStructure has them; indices count all variables from 1.
fn dependencies<'a>(root: &Element, names: &[&'a str]) -> Result<HashMap<&'a str, Vec<&'a str>>, Fault> {
    let name = |index: &str| {
        let place = index.parse::<usize>().ok().and_then(|index| names.get(index.checked_sub(1)?));
        place.copied().ok_or_else(|| Fault::new(format!("ModelStructure: index {index} is of no variable")))
    };
    let outputs = root.child("ModelStructure").map_or(&[][..], |structure| structure.list("Outputs"));
    let told = outputs.iter().filter_map(|unknown| Some((unknown, unknown.get("dependencies")?)));
    told.map(|(unknown, list)| {
        let of = list.split_whitespace().map(name).collect::<Result<_, Fault>>()?;
        Ok((name(unknown.needed("index")?)?, of))
    })
    .collect()
}

/// The exponents of the SI units in the order of the standard.
const BASE: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

/// A unit of the FMU with its dimension.
#[derive(Clone, Debug)]
struct SiUnit {
    unit: Unit,
    /// The exponents of [`BASE`]; None if the FMU does not declare them.
    base: Option<[i8; 8]>,
}

impl SiUnit {
    /// A unit, and the units in which its values are displayed.
    fn read(element: &Element) -> Result<Vec<Self>, Fault> {
        let name = element.needed("name")?;
        let named = |fault: Fault| fault.within(format_args!("unit \"{name}\""));
        let linear = |element: &Element| {
            let factor = element.number("factor").map_err(named)?.unwrap_or(1.0);
            let offset = element.number("offset").map_err(named)?.unwrap_or(0.0);
            if factor == 0.0 || !f64::is_finite(factor) || !f64::is_finite(offset) {
                return Err(named(Fault::new(format!("factor {factor} and offset {offset} make no unit"))));
            }
            Ok((factor, offset))
        };
        let (mut base, mut own) = (None, (1.0, 0.0));
        if let Some(element) = element.child("BaseUnit") {
            own = linear(element)?;
            let mut exponents = [0; 8];
            for (exponent, name) in exponents.iter_mut().zip(BASE) {
                *exponent = element.number(name).map_err(named)?.unwrap_or(0);
            }
            base = Some(exponents);
        }
        let unit = |name: &str, (factor, offset)| SiUnit { unit: Unit { name: name.to_owned(), factor, offset }, base };
        let mut units = vec![unit(name, own)];
        for display in element.all("DisplayUnit") {
            // A displayed value is factor · v + offset.
            let (factor, offset) = linear(display)?;
            let shown = (own.0 / factor, own.1 - own.0 * offset / factor);
            units.push(unit(display.needed("name").map_err(named)?, shown));
        }
        Ok(units)
    }
}

/// The quantity of variables in this unit: without name, in coherent SI.
///
/// Quantities live as long as the program; each one is kept once, however many variables and FMUs have it.
fn quantity(SiUnit { unit: own, base: exponents }: &SiUnit) -> &'static Quantity {
    type Key<'a> = (&'a str, [i8; 4], Option<(&'a str, u64)>);
    static KEPT: Mutex<BTreeMap<Key<'static>, &'static Quantity>> = Mutex::new(BTreeMap::new());
    // No unit that a person writes has an undeclared dimension, or one of electricity, heat, light or matter.
    let base = match exponents {
        Some([kg, m, s, 0, 0, 0, 0, rad]) => [*kg, *m, *s, *rad],
        None if own.name.is_empty() => [0; 4],
        _ => [i8::MAX; 4],
    };
    let powers = exponents.unwrap_or_default().into_iter().zip(BASE).filter(|(power, _)| *power != 0);
    let product = powers.map(|(power, unit)| if power == 1 { unit.to_owned() } else { format!("{unit}{power}") });
    let unit = if own.is_si() { own.name.clone() } else { product.collect::<Vec<_>>().join(".") };
    let display = (!own.is_si() && own.offset == 0.0).then_some((own.name.as_str(), 1.0 / own.factor));
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    let bits = |(name, factor): (_, f64)| (name, factor.to_bits());
    let key: Key<'_> = (&unit, base, display.map(bits));
    // With the lifetime of a key that is only looked up.
    let sought: &BTreeMap<Key<'_>, &'static Quantity> = &kept;
    if let Some(found) = sought.get(&key) {
        return found;
    }
    let display = display.map(|(name, factor)| (&*name.to_owned().leak(), factor));
    let new: &'static Quantity = Box::leak(Box::new(Quantity { name: "", unit: unit.leak(), base, display }));
    kept.insert((new.unit, base, display.map(|(name, factor)| (name, factor.to_bits()))), new);
    new
}

#[cfg(test)]
mod tests {
    use super::*;

    fn described(units: &str, variable: &str) -> Result<ModelDescription, Fault> {
        ModelDescription::read(&format!(
            "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"t\" guid=\"g\"><CoSimulation modelIdentifier=\"t\"/>\
             <UnitDefinitions>{units}</UnitDefinitions><ModelVariables><ScalarVariable name=\"x\" valueReference=\"7\">\
             {variable}</ScalarVariable></ModelVariables></fmiModelDescription>"
        ))
    }

    #[test]
    fn units_are_linear_in_those_of_si() {
        let units = "<Unit name=\"degF\"><BaseUnit K=\"1\" factor=\"0.5555555555555556\" offset=\"255.3722222222222\"/>\
             <DisplayUnit name=\"degC\" factor=\"0.5555555555555556\" offset=\"-17.77777777777778\"/></Unit>\
             <Unit name=\"kPa\"><BaseUnit kg=\"1\" m=\"-1\" s=\"-2\" factor=\"1000\"/></Unit><Unit name=\"bit\"/>";
        let of = |unit: &str| described(units, &format!("<Real unit=\"{unit}\" min=\"-5\"/>")).unwrap();
        let quantity = |description: &ModelDescription| match description.variables[0].about.kind {
            Kind::Real { quantity, min, .. } => (quantity, min),
            _ => panic!("a Real is expected"),
        };
        let fahrenheit = of("degF");
        let own = &fahrenheit.variables[0].unit;
        assert!((own.to_si(212.0) - 373.15).abs() < 1e-12 && (own.of_si(273.15) - 32.0).abs() < 1e-12);
        // 100 °C are 373.15 K.
        assert!((fahrenheit.unit(0, "degC").unwrap().to_si(100.0) - 373.15).abs() < 1e-11);
        assert_eq!((fahrenheit.unit(0, "kPa"), quantity(&fahrenheit).0.unit), (None, "K"));
        let pressure = of("kPa");
        let (pascal, least) = quantity(&pressure);
        assert_eq!((pascal.unit, pascal.base, pascal.display), ("kg.m-1.s-2", [1, -1, -2, 0], Some(("kPa", 1e-3))));
        assert_eq!(least, -5e3);
        // Each is kept once.
        assert!(std::ptr::eq(pascal, quantity(&of("kPa")).0));
        // Values without a unit in SI are taken unchanged, and no text has their unit by chance.
        for (name, base) in [("bit", [i8::MAX; 4]), ("baud", [i8::MAX; 4]), ("", [0; 4])] {
            let description = of(name);
            let (quantity, least) = quantity(&description);
            assert_eq!((quantity.unit, quantity.base, least), (name, base, -5.0));
        }
    }

    #[test]
    fn outputs_depend_on_what_the_structure_tells_else_on_everything() {
        let variable = |name: &str, causality: &str, kind: &str| {
            format!(
                "<ScalarVariable name=\"{name}\" valueReference=\"0\" causality=\"{causality}\">{kind}</ScalarVariable>"
            )
        };
        let read = |outputs: &str| {
            ModelDescription::read(&format!(
                "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"t\" guid=\"g\"><CoSimulation modelIdentifier=\"t\"/>\
                 <ModelVariables>{}{}{}{}</ModelVariables><ModelStructure>{outputs}</ModelStructure></fmiModelDescription>",
                variable("text", "parameter", "<String start=\"a\"/>"),
                variable("u", "input", "<Real start=\"0\"/>"),
                variable("v", "input", "<Real start=\"0\"/>"),
                variable("y", "output", "<Real/>"),
            ))
        };
        let of = |told: &str| {
            let y = read(&format!("<Outputs><Unknown index=\"4\"{told}/></Outputs>")).unwrap().variables.remove(2);
            (y.by_all, y.about.dependencies)
        };
        // Variables of the type String count.
        assert_eq!(of(" dependencies=\"3\""), (false, vec!["v".to_owned()]));
        assert_eq!(of(" dependencies=\"\""), (false, Vec::new()));
        assert_eq!(of(""), (true, Vec::new()));
        assert!(read("").unwrap().variables[2].by_all);
        let fault = read("<Outputs><Unknown index=\"4\" dependencies=\"0\"/></Outputs>").unwrap_err();
        assert!(fault.message.contains("index 0 is of no variable"), "{fault}");
    }

    #[test]
    fn of_a_name_the_first_variable_is_found() {
        let variables: String = ["a", "b", "a"]
            .iter()
            .zip(5..)
            .map(|(name, i)| format!("<ScalarVariable name=\"{name}\" valueReference=\"{i}\"><Real/></ScalarVariable>"))
            .collect();
        let description = ModelDescription::read(&format!(
            "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"t\" guid=\"g\"><CoSimulation modelIdentifier=\"t\"/>\
             <ModelVariables>{variables}</ModelVariables></fmiModelDescription>"
        ))
        .unwrap();
        assert_eq!(["a", "b", "c"].map(|name| description.find(name)), [Some(0), Some(1), None]);
        assert_eq!(["a", "b"].map(|name| description.variable(name).unwrap().reference), [5, 6]);
    }

    #[test]
    fn what_a_variable_has_may_stand_in_its_type() {
        let description = described("", "<Boolean start=\"1\"/>").unwrap();
        let Variable { about, reference, start, .. } = &description.variables[0];
        assert_eq!((&about.kind, *reference, *start), (&Kind::Boolean, 7, Some(1.0)));
        assert_eq!(described("", "<String start=\"a\"/>").unwrap().variables.len(), 0);
        let range = described("", "<Integer min=\"-2\" start=\"3\"/>").unwrap().variables[0].about.kind.clone();
        assert_eq!(range, Kind::Integer { min: -2, max: i32::MAX });
        let fault = described("", "<Real start=\"much\"/>").unwrap_err();
        assert!(fault.message.contains("`x`: <Real>: start=\"much\""), "{fault}");
    }
}
