//! The parts of a system as instances that exchange values.

use super::{Content, Part, System};
use crate::scene::variable::{self, connected};
use camdrive::drives::variable::Causality;
use camdrive::drives::{Description, Fault};
use camdrive_design::coupling::exchange::{Connection, Coupling};
use camdrive_design::coupling::stability::Exchange;
use camdrive_design::coupling::variables::variables;
use camdrive_design::host::{Fmu, ModelDescription};
use std::path::Path;
use std::sync::Arc;

impl System {
    /// Checks that its parts can be coupled and started, as in a run.
    ///
    /// # Errors
    /// Errors of [`System::coupled`]; errors of a part at its start; start values that do not settle.
    pub fn try_out(&self) -> Result<(), Fault> {
        let mut coupling = self.coupled(self.exchange, self.repeats)?;
        coupling.begin(0.0, Some(self.stop))?;
        coupling.start()
    }

    /// An instance of each part with its start values, and the connections between them. The library in this tool drives scenes,
    /// FMUs have their own library.
    ///
    /// # Errors
    /// An FMU that cannot be loaded, a start value that it refuses, both with the name of the part.
    pub fn coupled(&self, exchange: Exchange, repeats: u32) -> Result<Coupling, Fault> {
        self.instance(&self.fmus(&[])?, exchange, repeats)
    }

    /// The FMU of each part; FMUs in `opened` are used again.
    fn fmus(&self, opened: &[Arc<Fmu>]) -> Result<Vec<Arc<Fmu>>, Fault> {
        let fmu = |(place, part): (usize, &Part)| match (&part.content, opened.get(place)) {
            (Content::Scene(scene), _) => Fmu::linked(&scene.resource()).map(Arc::new),
            (Content::Fmu(_), Some(fmu)) => Ok(Arc::clone(fmu)),
            (Content::Fmu(path), None) => Fmu::open(path).map(Arc::new),
        };
        self.parts.iter().enumerate().map(|at| fmu(at).map_err(|fault| at.1.of_part(fault))).collect()
    }

    fn instance(&self, fmus: &[Arc<Fmu>], exchange: Exchange, repeats: u32) -> Result<Coupling, Fault> {
        let instance = |(part, fmu): (&Part, &Arc<Fmu>)| {
            let name = if part.name.is_empty() { &fmu.description().name } else { &part.name };
            let mut host = fmu.instantiate(name)?;
            for (name, value) in &part.start {
                host.set(find(fmu, name)?, *value)?;
            }
            Ok((part.name.clone(), host))
        };
        let parts = self.parts.iter().zip(fmus).map(|of| instance(of).map_err(|fault| of.0.of_part(fault)));
        Coupling::new(parts.collect::<Result<_, _>>()?, &self.connections(fmus)?, exchange, repeats)
    }

    /// The connections by the indices of variables.
    fn connections(&self, fmus: &[Arc<Fmu>]) -> Result<Vec<Connection>, Fault> {
        let end = |(part, name): &(usize, String)| find(&fmus[*part], name).map(|place| (*part, place));
        let connected = self
            .connections
            .iter()
            .map(|c| Ok(Connection { from: end(&c.from)?, to: end(&c.to)?, factor: c.factor, offset: c.offset }));
        connected.collect()
    }
}

impl Part {
    fn of_part(&self, fault: Fault) -> Fault {
        if self.name.is_empty() { fault } else { fault.within(format_args!("part {}", self.name)) }
    }
}

fn find(fmu: &Fmu, name: &str) -> Result<usize, Fault> {
    fmu.description().find(name).ok_or_else(|| Fault::new(format!("`{name}` is no variable")))
}

/// A system with its FMUs, for any number of instances.
pub struct Coupled {
    /// Its system.
    pub system: System,
    fmus: Vec<Arc<Fmu>>,
    /// The start of its runs (s).
    pub begin: f64,
    /// The part of each variable and the index there.
    pub places: Vec<(usize, usize)>,
    /// Its variables, each after the name of its part.
    pub variables: Vec<Description>,
}

impl Coupled {
    /// The FMUs of a system; FMUs that were `opened` before are used again.
    ///
    /// # Errors
    /// An FMU that cannot be loaded, with the name of the part.
    pub fn new(system: System, opened: Option<&Coupled>) -> Result<Self, Fault> {
        let fmus = system.fmus(opened.map_or(&[], |opened| &opened.fmus))?;
        let connections = system.connections(&fmus)?;
        let parts = system.parts.iter().zip(&fmus).map(|(part, fmu)| (part.name.as_str(), fmu.description()));
        let is_connected = |part, place| connections.iter().any(|connection| connection.to == (part, place));
        let (places, variables) = variables(parts, is_connected);
        Ok(Coupled { system, fmus, begin: 0.0, places, variables })
    }

    /// One FMU as a system; its variables keep their names.
    ///
    /// # Errors
    /// An FMU that cannot be loaded.
    pub fn of_fmu(path: &Path) -> Result<Self, Fault> {
        let fmu = Fmu::open(path)?;
        let description = fmu.description().clone();
        let ModelDescription { name, experiment, .. } = description.clone();
        let content = Content::Fmu(path.to_owned());
        let part = Part { name: String::new(), content, start: Vec::new(), description, scene: None, seat: None };
        let system = System {
            name,
            // The study must set what the FMU does not.
            stop: experiment.stop.unwrap_or(f64::NAN),
            step: experiment.step.unwrap_or(f64::NAN),
            exchange: Exchange::Held,
            repeats: 0,
            asked: None,
            parts: vec![part],
            connections: Vec::new(),
            shafts: Vec::new(),
            notes: Vec::new(),
            files: vec![path.to_owned()],
            _folder: None,
        };
        let (places, variables) = variables([("", fmu.description())], |_, _| false);
        let begin = experiment.start.unwrap_or(0.0);
        Ok(Coupled { system, fmus: vec![Arc::new(fmu)], begin, places, variables })
    }

    /// The model description of a part.
    pub fn description(&self, part: usize) -> &ModelDescription {
        self.fmus[part].description()
    }

    /// The reason why a variable cannot be set; None if it can.
    pub fn fixed(&self, variable: usize) -> Option<Fault> {
        let (part, place) = self.places[variable];
        match [self.variables[variable].causality, self.description(part).variables[place].about.causality] {
            [Causality::Parameter | Causality::Input, _] => None,
            [_, Causality::Input] => Some(connected()),
            _ => Some(Fault::new("it is computed")),
        }
    }

    /// The value of a variable from a text (SI), without its range.
    ///
    /// # Errors
    /// Errors of [`variable::imported`].
    pub fn value(&self, variable: usize, text: &str) -> Result<f64, Fault> {
        let (part, place) = self.places[variable];
        variable::imported(self.description(part), place, text)
    }

    /// The start value of a variable (SI), if it is known.
    pub fn start(&self, variable: usize) -> Option<f64> {
        let (part, place) = self.places[variable];
        let of = &self.description(part).variables[place];
        let given = self.system.parts[part].start.iter().find(|(name, _)| *name == of.about.name);
        given.map(|(_, value)| *value).or(of.start).map(|value| of.unit.to_si(value))
    }

    /// New instances with these values of variables (SI), initialised for steps of this length (s).
    ///
    /// # Errors
    /// Errors of a part; steps that are unstable with these values.
    pub fn started(&self, values: &[(usize, f64)], step: f64) -> Result<Coupling, Fault> {
        let set = |(variable, value): &(usize, f64)| {
            let (part, place) = self.places[*variable];
            let of = &self.description(part).variables[place];
            let admitted =
                self.variables[*variable].check(*value).map_err(|fault| self.system.parts[part].of_part(fault));
            admitted.map(|()| (part, of.about.name.as_str(), of.unit.of_si(*value)))
        };
        let set = values.iter().map(set).collect::<Result<Vec<_>, Fault>>()?;
        let repeats = self.system.repeats(&set, step).map_err(Fault::new)?;
        let mut coupling = self.system.instance(&self.fmus, self.system.exchange, repeats)?;
        for ((part, _, value), (variable, _)) in set.into_iter().zip(values) {
            let set = coupling.parts()[part].set(self.places[*variable].1, value);
            set.map_err(|fault| self.system.parts[part].of_part(fault))?;
        }
        coupling.begin(self.begin, None)?;
        coupling.start()?;
        Ok(coupling)
    }
}
