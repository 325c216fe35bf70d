//! The variables of a drive: each is declared once; model description, value references, documentation and access all follow from
//! that declaration.

use super::{Fault, Seed, unit::Quantity};
use crate::numerics::number::{Number, Range};
use crate::numerics::taylor::Series;

/// Causality after FMI 2.0, section 2.2.7.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Set by the user before (or, if tunable, between) the steps.
    Parameter,
    /// Set by the importer at communication points.
    Input,
    /// Computed, for other units.
    Output,
    /// Computed, for the eye.
    Local,
}

/// Variability after FMI 2.0, section 2.2.7.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Constant once initialised.
    Fixed,
    /// Constant between communication points.
    Tunable,
    /// Constant between events.
    Discrete,
    /// Continuous in time.
    Continuous,
}

/// The type of a variable with its admissible range.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A Real.
    Real {
        /// Quantity and unit.
        quantity: &'static Quantity,
        /// Admissible range, borders included; infinite if open.
        min: f64,
        /// See `min`.
        max: f64,
        /// Usual magnitude.
        nominal: Option<f64>,
    },
    /// An Integer.
    Integer {
        /// Admissible range, borders included.
        min: i32,
        /// See `min`.
        max: i32,
    },
    /// A Boolean.
    Boolean,
    /// An Enumeration.
    Enumeration(&'static Enumeration),
}

/// An enumeration type; the values count from 1.
#[derive(Debug, PartialEq)]
pub struct Enumeration {
    /// The name of the type.
    pub name: &'static str,
    /// Name and description of each item.
    pub items: &'static [(&'static str, &'static str)],
}

/// The types by which importers access variables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// fmi2Real.
    Real,
    /// fmi2Integer, also for Enumerations.
    Integer,
    /// fmi2Boolean.
    Boolean,
    /// fmi2String; no variable has this type.
    String,
}

impl Kind {
    /// The type by which a variable of this kind is accessed.
    pub fn r#type(&self) -> Type {
        match self {
            Kind::Real { .. } => Type::Real,
            Kind::Integer { .. } | Kind::Enumeration(_) => Type::Integer,
            Kind::Boolean => Type::Boolean,
        }
    }
}

/// Description of a variable for importers.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// Structured name.
    pub name: String,
    /// The place in the scene that sets it; the name by default.
    pub key: String,
    /// One sentence.
    pub text: String,
    /// Type and range.
    pub kind: Kind,
    /// Causality.
    pub causality: Causality,
    /// Variability.
    pub variability: Variability,
    /// Whether this is a continuous state.
    pub state: bool,
    /// The name of the variable whose time derivative this is.
    pub derivative_of: Option<String>,
    /// The inputs and states that the variable depends on directly at a communication point.
    pub dependencies: Vec<String>,
    /// The inputs and parameters that it depends on during initialisation, by name or, up to a dot or bracket, by the first part of
    /// their names: `cam` stands for `cam.a[1]` and all others. Variables that a scene lacks may be named.
    pub initial_dependencies: Vec<String>,
}

impl Description {
    /// A variable that is no state and depends on nothing.
    #[inline(never)]
    fn new(name: &str, text: &str, kind: Kind, causality: Causality, variability: Variability) -> Self {
        Description {
            name: name.to_owned(),
            key: name.to_owned(),
            text: text.to_owned(),
            kind,
            causality,
            variability,
            state: false,
            derivative_of: None,
            dependencies: Vec::new(),
            initial_dependencies: Vec::new(),
        }
    }

    /// Whether the start value depends on this variable (FMI 2.0, section 2.2.8: the knowns of the initialisation are
    /// inputs and variables with `initial="exact"`, which parameters are).
    pub fn depends_initially_on(&self, known: &Description) -> bool {
        let named = |name: &String| {
            known.name.strip_prefix(name.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        matches!(known.causality, Causality::Input | Causality::Parameter)
            && self.initial_dependencies.iter().any(named)
    }

    /// Refuses a value that a variable of this description cannot take.
    pub fn check(&self, value: f64) -> Result<(), Fault> {
        let whole_within = |min: f64, max: f64| min <= value && value <= max && value.fract() == 0.0;
        let admissible = match &self.kind {
            Kind::Real { min, max, .. } => *min <= value && value <= *max && value.is_finite(),
            Kind::Integer { min, max } => whole_within((*min).into(), (*max).into()),
            Kind::Enumeration(e) => whole_within(1.0, e.items.len() as f64),
            Kind::Boolean => value == 0.0 || value == 1.0,
        };
        if admissible { Ok(()) } else { Err(self.not_admissible(Number(value))) }
    }

    #[cold]
    fn not_admissible(&self, value: Number) -> Fault {
        let expected = match &self.kind {
            Kind::Real { min, max, .. } => Range(*min, *max).to_string(),
            Kind::Integer { min, max } => format!("{min} to {max}"),
            Kind::Enumeration(e) => {
                let items = e.items.iter().enumerate().map(|(i, (name, _))| format!("{} ({name})", i + 1));
                items.collect::<Vec<_>>().join(", ")
            }
            Kind::Boolean => "0 (false) or 1 (true)".to_owned(),
        };
        let unit = match &self.kind {
            // The unit of a pure number is 1, which would read like a digit.
            Kind::Real { quantity, .. } if quantity.unit != "1" => format!(" {}", quantity.unit),
            _ => String::new(),
        };
        Fault::named(&self.name, format!(": {value}{unit} is not admissible; expected {expected}{unit}"))
    }
}

/// An output as an equation gives it, before a model names it.
#[derive(Clone, Debug)]
pub struct Output {
    /// Its name; for a derivative the name of its place.
    pub name: &'static str,
    /// Its order as time derivative of that place.
    pub order: usize,
    /// One sentence; empty if the name says enough.
    pub text: &'static str,
    /// Quantity and unit.
    pub quantity: &'static Quantity,
    /// How it changes.
    pub role: Role,
}

/// How an output changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Continuously.
    Continuous,
    /// As a continuous state.
    State,
    /// At events.
    Discrete,
    /// At events, for the eye.
    Local,
    /// At events, an Integer from one number to the other.
    Count(i32, i32),
    /// At events, a Boolean.
    Flag,
}

impl Output {
    /// A continuous output.
    pub const fn new(name: &'static str, text: &'static str, quantity: &'static Quantity) -> Self {
        Output { name, order: 0, text, quantity, role: Role::Continuous }
    }

    /// Sets how it changes.
    pub const fn role(self, role: Role) -> Self {
        Output { role, ..self }
    }

    /// Marks it as a state if it is one.
    pub const fn state(self, is_state: bool) -> Self {
        if is_state { self.role(Role::State) } else { self }
    }
}

/// A variable with its access; all types are carried as `f64` (Booleans as 0 and 1), which holds them exactly.
pub struct Variable<D> {
    /// Description for importers.
    pub description: Description,
    /// The place of a computed value; else the element of an array, or whatever else the access functions need.
    pub index: usize,
    /// How the value is read and written.
    pub access: Access<D>,
}

/// Reads a parameter or an input.
pub type Get<D> = fn(&D, usize) -> f64;
/// Writes an input (order 0) or its time derivative of order n > 0 (unit of the input over sⁿ), which holds for the next step; the
/// value is finite, an input's within its range.
pub type Set<D> = fn(&mut D, usize, f64);
/// Writes an input, where the order is 0, or its time derivative of the order n > 0 (unit of the input over sⁿ), which holds for
/// the next step; the value is finite, that of the input within its range.
pub type SetInput<D> = fn(&mut D, usize, usize, f64);

/// How the value of a variable is read and written.
pub enum Access<D> {
    /// A parameter.
    Set {
        /// Reads the value.
        get: Get<D>,
        /// Writes the value.
        set: Set<D>,
    },
    /// An input.
    Input {
        /// Reads the value.
        get: Get<D>,
        /// Writes the value or a derivative.
        set: SetInput<D>,
    },
    /// [`super::Drive::evaluate`] puts the value in its place.
    Computed {
        /// The Taylor series of a continuous output.
        series: Option<fn(&D, Seed, usize) -> Series>,
    },
}

impl<D> Access<D> {
    /// The value of a parameter or an input; None for computed values.
    pub fn get(&self, drive: &D, index: usize) -> Option<f64> {
        match self {
            Access::Set { get, .. } | Access::Input { get, .. } => Some(get(drive, index)),
            Access::Computed { .. } => None,
        }
    }

    /// Sets a parameter or an input; leaves computed values alone.
    pub fn set(&self, drive: &mut D, index: usize, value: f64) {
        match self {
            Access::Set { set, .. } => set(drive, index, value),
            Access::Input { set, .. } => set(drive, index, 0, value),
            Access::Computed { .. } => {}
        }
    }

    /// Sets the derivative of this order of an input; leaves others alone.
    pub fn set_derivative(&self, drive: &mut D, index: usize, order: usize, value: f64) {
        if let Access::Input { set, .. } = self {
            set(drive, index, order, value);
        }
    }
}

/// The variables of a drive, built in the order of their value references.
pub struct List<D>(pub Vec<Variable<D>>);

impl<D> Default for List<D> {
    fn default() -> Self {
        List(Vec::new())
    }
}

/// A Real of any value.
pub fn real(quantity: &'static Quantity) -> Kind {
    Kind::Real { quantity, min: f64::NEG_INFINITY, max: f64::INFINITY, nominal: None }
}

/// A Real within [min, max].
pub fn real_within(quantity: &'static Quantity, min: f64, max: f64) -> Kind {
    Kind::Real { quantity, min, max, nominal: None }
}

/// A page reads no derivatives of outputs, and is smaller without the code of their series.
fn of_importers<T>(series: T) -> Option<T> {
    if cfg!(target_arch = "wasm32") { None } else { Some(series) }
}

// Out of line: inlined into every declaration these makers take 37 kB of the library.
impl<D> List<D> {
    #[inline(never)]
    fn push(&mut self, description: Description, access: Access<D>) -> &mut Variable<D> {
        self.0.push(Variable { description, index: 0, access });
        self.0.last_mut().expect("just pushed")
    }

    /// A fixed parameter.
    #[inline(never)]
    pub fn parameter(&mut self, name: &str, text: &str, kind: Kind, get: Get<D>, set: Set<D>) -> &mut Variable<D> {
        self.push(
            Description::new(name, text, kind, Causality::Parameter, Variability::Fixed),
            Access::Set { get, set },
        )
    }

    /// A continuous input.
    #[inline(never)]
    pub fn input(&mut self, name: &str, text: &str, kind: Kind, get: Get<D>, set: SetInput<D>) -> &mut Variable<D> {
        self.push(
            Description::new(name, text, kind, Causality::Input, Variability::Continuous),
            Access::Input { get, set },
        )
    }

    /// A continuous output with its Taylor series; [`Variable::at`] sets its place. `der(x)` is the derivative of `x`, `der(x,2)`
    /// the derivative of `der(x)`.
    #[inline(never)]
    pub fn output(
        &mut self,
        name: &str,
        text: &str,
        kind: Kind,
        series: fn(&D, Seed, usize) -> Series,
    ) -> &mut Variable<D> {
        let access = Access::Computed { series: of_importers(series) };
        let v = self.push(Description::new(name, text, kind, Causality::Output, Variability::Continuous), access);
        let of = name.strip_prefix("der(").and_then(|rest| rest.strip_suffix(')'));
        v.description.derivative_of =
            of.map(|of| of.strip_suffix(",2").map_or(of.to_owned(), |of| format!("der({of})")));
        v
    }

    /// A discrete output: a count, a mode, a sum over events or a mean over the last step.
    #[inline(never)]
    pub fn discrete_output(&mut self, name: &str, text: &str, kind: Kind) -> &mut Variable<D> {
        self.push(
            Description::new(name, text, kind, Causality::Output, Variability::Discrete),
            Access::Computed { series: None },
        )
    }

    /// An output under the name that a model gives it.
    #[inline(never)]
    pub fn named(
        &mut self,
        output: &Output,
        name: &str,
        text: &str,
        series: fn(&D, Seed, usize) -> Series,
    ) -> &mut Variable<D> {
        let kind = match output.role {
            Role::Count(min, max) => Kind::Integer { min, max },
            Role::Flag => Kind::Boolean,
            _ => real(output.quantity),
        };
        let variable = match output.role {
            Role::Continuous | Role::State => self.output(name, text, kind, series),
            Role::Local => self.local(name, text, kind),
            _ => self.discrete_output(name, text, kind),
        };
        variable.description.state = output.role == Role::State;
        variable
    }

    /// A discrete local variable, such as a solver statistic.
    #[inline(never)]
    pub fn local(&mut self, name: &str, text: &str, kind: Kind) -> &mut Variable<D> {
        self.push(
            Description::new(name, text, kind, Causality::Local, Variability::Discrete),
            Access::Computed { series: None },
        )
    }
}

impl<D> Variable<D> {
    /// Sets the index for the access functions, or the place of the computed value.
    pub fn at(&mut self, index: usize) -> &mut Self {
        self.index = index;
        self
    }

    /// Sets the key in the scene.
    #[inline(never)]
    pub fn key(&mut self, key: &str) -> &mut Self {
        self.description.key = key.to_owned();
        self
    }

    /// Sets the usual magnitude.
    pub fn nominal(&mut self, value: f64) -> &mut Self {
        if let Kind::Real { nominal, .. } = &mut self.description.kind {
            *nominal = Some(value);
        }
        self
    }

    /// Marks the variable as a continuous state.
    pub fn state(&mut self) -> &mut Self {
        self.description.state = true;
        self
    }

    /// Marks the variable as the time derivative of `name`.
    pub fn derivative_of(&mut self, name: &str) -> &mut Self {
        self.description.derivative_of = Some(name.to_owned());
        self
    }

    /// Sets the partial derivatives of a discrete variable, which jumps of the inputs change.
    #[inline(never)]
    pub fn slopes(&mut self, series: fn(&D, Seed, usize) -> Series) -> &mut Self {
        self.access = Access::Computed { series: of_importers(series) };
        self
    }

    /// Names the inputs and states that the variable depends on directly at communication points.
    #[inline(never)]
    pub fn depends(&mut self, names: &[&str]) -> &mut Self {
        self.description.dependencies = names.iter().map(|n| (*n).to_owned()).collect();
        self
    }

    /// Names its dependencies during initialisation, see [`Description::initial_dependencies`].
    #[inline(never)]
    pub fn depends_initially(&mut self, names: &[&[&str]]) -> &mut Self {
        self.description.initial_dependencies = names.concat().into_iter().map(str::to_owned).collect();
        self
    }
}

impl<D> List<D> {
    /// As many places as the computed values of the drive need.
    pub fn places(&self) -> Box<[f64]> {
        let computed = self.0.iter().filter(|v| matches!(v.access, Access::Computed { .. }));
        vec![0.0; computed.map(|v| v.index + 1).max().unwrap_or(0)].into()
    }

    /// The value reference of the variable with this name.
    pub fn reference(&self, name: &str) -> Option<usize> {
        self.0.iter().position(|v| v.description.name == name)
    }
}

impl<D: super::Drive> Variable<D> {
    /// Sets a parameter or an input.
    pub fn set(&self, drive: &mut D, value: f64) {
        self.access.set(drive, self.index, value);
    }

    /// The value in `drive`, computed on its own.
    pub fn value(&self, drive: &D) -> f64 {
        self.access.get(drive, self.index).unwrap_or_else(|| {
            let mut values = drive.variables().places();
            drive.evaluate(&mut values);
            values[self.index]
        })
    }
}

#[cfg(test)]
impl<D: super::Drive> Variable<D> {
    /// The Taylor series of a continuous output.
    pub fn series(&self) -> Option<fn(&D, Seed, usize) -> Series> {
        match self.access {
            Access::Computed { series } => series,
            _ => None,
        }
    }

    /// Sets the derivative of this order of an input.
    pub fn set_derivative(&self, drive: &mut D, order: usize, value: f64) {
        self.access.set_derivative(drive, self.index, order, value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drives::elastic_output::{ElasticOutput, Parameters, Scene};
    use crate::drives::follower::load::Load;
    use crate::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
    use crate::drives::{Drive, settings::Settings, unit};
    use crate::motion::{Fourier, MotionLaw};

    static COLOURS: Enumeration = Enumeration { name: "Colour", items: &[("red", ""), ("green", "")] };

    fn description(kind: Kind) -> Description {
        let mut list: List<()> = List::default();
        let access = Access::Computed { series: None };
        let description = Description::new("x", "", kind, Causality::Parameter, Variability::Fixed);
        list.push(description, access).description.clone()
    }

    #[test]
    fn values_are_refused_outside_of_the_range_of_their_kind() {
        let refused = |kind: &Kind, value: f64| description(kind.clone()).check(value).err().map(|e| e.to_string());
        for (kind, admitted, others, said) in [
            (
                real_within(&unit::MASS, -1.0, 2.5),
                vec![-1.0, 0.1, 2.5],
                vec![-1.1, 2.6, f64::NAN],
                "-1.1 kg is not admissible; expected -1 to 2.5 kg",
            ),
            (
                real(&unit::NUMBER),
                vec![f64::MIN, f64::MAX],
                vec![f64::INFINITY, f64::NEG_INFINITY, f64::NAN],
                "inf is not admissible; expected any finite number",
            ),
            (
                Kind::Integer { min: -1, max: 3 },
                vec![-1.0, 0.0, 3.0],
                vec![-2.0, 4.0, 0.5, f64::NAN],
                "-2 is not admissible; expected -1 to 3",
            ),
            (
                Kind::Enumeration(&COLOURS),
                vec![1.0, 2.0],
                vec![0.0, 3.0, 1.5],
                "0 is not admissible; expected 1 (red), 2 (green)",
            ),
            (
                Kind::Boolean,
                vec![0.0, 1.0],
                vec![2.0, 0.5, f64::NAN],
                "2 is not admissible; expected 0 (false) or 1 (true)",
            ),
        ] {
            assert!(admitted.iter().all(|&value| refused(&kind, value).is_none()), "{kind:?}");
            assert!(others.iter().all(|&value| refused(&kind, value).is_some()), "{kind:?}");
            assert_eq!(refused(&kind, others[0]), Some(format!("`x`: {said}")));
        }
        assert_eq!(Kind::Enumeration(&COLOURS).r#type(), Type::Integer);
    }

    #[test]
    fn an_initial_dependency_names_a_parameter_or_input_or_the_first_part_of_its_name() {
        let mut start = description(Kind::Boolean);
        start.initial_dependencies = vec!["cam".to_owned(), "start.q".to_owned()];
        let depends = |name: &str, causality: Causality| {
            start.depends_initially_on(&Description { name: name.to_owned(), causality, ..description(Kind::Boolean) })
        };
        for known in [Causality::Parameter, Causality::Input] {
            assert!(["cam", "cam.a[1]", "cam[2]", "start.q"].into_iter().all(|name| depends(name, known)));
            assert!(!["came", "ca", "start.q_dot", "m"].into_iter().any(|name| depends(name, known)));
        }
        assert!(!depends("cam", Causality::Output) && !depends("m", Causality::Local));
    }

    #[test]
    fn the_list_knows_names_places_and_derivatives() {
        let mut list: List<()> = List::default();
        let series = |_: &(), _: Seed, _: usize| Series([0.0; 3]);
        assert_eq!((list.places().len(), list.reference("y")), (0, None));
        for (place, name) in ["y", "der(y)", "der(y,2)"].into_iter().enumerate() {
            list.output(name, "", Kind::Boolean, series).at(place);
        }
        // Inputs have no place among the computed values.
        list.input("u", "", Kind::Boolean, |_, _| 0.0, |_, _, _, _| {}).at(7);
        assert_eq!((list.places().len(), list.reference("der(y,2)"), list.reference("z")), (3, Some(2), None));
        let of: Vec<_> = list.0.iter().map(|v| v.description.derivative_of.as_deref()).collect();
        assert_eq!(of, [None, Some("y"), Some("der(y)"), None]);
    }

    #[test]
    fn one_variable_is_read_and_set_apart_from_all_others() {
        let scene = Scene {
            coupling: false,
            parameters: Parameters { m: 2.0, c: 800.0, b: 3.0 },
            load: Load::default(),
            roller: (0.0, Load::default()),
            cam: MotionLaw::Fourier(Fourier::new(vec![0.0, 0.01], vec![])),
            drive: DriveMode::Constant { w: 20.0, phi_start: 0.0 },
            start: Start { mode: StartMode::Given, q: 0.25, q_dot: 0.5 },
            solver: Settings::default(),
        };
        let mut drive = ElasticOutput::new(scene).unwrap();
        drive.start(0.0).unwrap();
        let list = drive.variables();
        let variable = |name: &str| &list.0[list.reference(name).unwrap()];
        // force = −(c q + b q̇), q̇ = 0.5 is the first coefficient of q.
        assert_eq!((variable("m").value(&drive), variable("force").value(&drive)), (2.0, -201.5));
        assert_eq!(variable("q").series().unwrap()(&drive, Seed::Time, variable("q").index).0[..2], [0.25, 0.5]);
        assert!(variable("m").series().is_none());
        variable("m").set(&mut drive, 4.0);
        assert_eq!(variable("m").value(&drive), 4.0);
    }
}
