//! The parts of a system as instances that exchange values.

use super::system::{Content, System};
use camdrive::drives::Fault;
use camdrive_design::coupling::exchange::{Connection, Coupling};
use camdrive_design::coupling::stability::Exchange;
use camdrive_design::host::{Fmu, Host};

impl System {
    /// Tries whether its parts can be coupled and started, as a run does.
    ///
    /// # Errors
    /// Those of [`System::coupled`]; what a part says of its start; start values that do not settle.
    pub fn try_out(&self) -> Result<(), Fault> {
        let mut coupling = self.coupled(self.exchange, self.repeats)?;
        coupling.begin(0.0, Some(self.stop))?;
        coupling.start()
    }

    /// An instance of each part with its start values, and the connections between them. Scenes are driven by the library in
    /// this tool, FMUs by their own.
    ///
    /// # Errors
    /// An FMU that cannot be loaded, a start value that it refuses, both with the name of the part.
    pub fn coupled(&self, exchange: Exchange, repeats: u32) -> Result<Coupling, Fault> {
        let instance = |place: usize| -> Result<(String, Host), Fault> {
            let part = &self.parts[place];
            let said = |fault: Fault| Fault::new(format!("part {}: {fault}", part.name));
            let fmu = match &part.content {
                Content::Scene(scene) => Fmu::linked(&scene.resource()),
                Content::Fmu(path) => Fmu::open(path),
            };
            let mut host = fmu.and_then(|fmu| fmu.instantiate(&part.name)).map_err(said)?;
            for (name, value) in &part.start {
                let variable = find(&host, name).map_err(said)?;
                host.set(variable, *value).map_err(said)?;
            }
            Ok((part.name.clone(), host))
        };
        let parts = (0..self.parts.len()).map(instance).collect::<Result<Vec<_>, _>>()?;
        let end = |(part, name): &(usize, String)| find(&parts[*part].1, name).map(|place| (*part, place));
        let connected = self
            .connections
            .iter()
            .map(|c| Ok(Connection { from: end(&c.from)?, to: end(&c.to)?, factor: c.factor, offset: c.offset }));
        let connections = connected.collect::<Result<Vec<_>, Fault>>()?;
        Coupling::new(parts, &connections, exchange, repeats)
    }
}

fn find(host: &Host, name: &str) -> Result<usize, Fault> {
    host.description().find(name).ok_or_else(|| Fault::new(format!("`{name}` is no variable")))
}
