//! A drive in operation, with access by name.

use camdrive::drives::Fault;
use camdrive::drives::unit::Quantity;
use camdrive::drives::variable::{Causality, Kind};
use camdrive_design::resource::{Described, Scene};
use serde_json::{Value, json};

pub struct Run {
    pub drive: Described,
    names: Vec<String>,
    outputs: Vec<usize>,
    pub time: f64,
}

impl Run {
    /// The drive at its start at t = 0, with these inputs and parameters.
    pub fn new(scene: (&str, Value), inputs: &[(&str, f64)]) -> Result<Self, Fault> {
        Run::moving(scene, inputs, &[])
    }

    /// The same, with these first derivatives of inputs.
    pub fn moving(
        (model, scene): (&str, Value),
        inputs: &[(&str, f64)],
        derivatives: &[(&str, f64)],
    ) -> Result<Self, Fault> {
        let variant = match model {
            "ElasticCamDrive.output" => "ElasticOutput",
            "ElasticCamDrive.shaft" => "ElasticShaft",
            other => other,
        };
        let scene: Scene = serde_json::from_value(json!({ variant: scene })).expect("a scene");
        Run::of(scene.build()?, inputs, derivatives)
    }

    /// A drive at its start.
    pub fn of(drive: Described, inputs: &[(&str, f64)], derivatives: &[(&str, f64)]) -> Result<Self, Fault> {
        let mut run = Run::before_start(drive);
        run.set(inputs)?;
        derivatives.iter().try_for_each(|(name, value)| run.set_derivative(name, *value))?;
        run.drive.start()?;
        Ok(run)
    }

    /// A drive before its start at t = 0.
    pub fn before_start(mut drive: Described) -> Self {
        let list = drive.descriptions();
        let names: Vec<String> = list.iter().map(|d| d.name.clone()).collect();
        let real = |i: &usize| matches!(list[*i].kind, Kind::Real { .. });
        let outputs = (0..list.len()).filter(|i| list[*i].causality == Causality::Output).filter(real).collect();
        drive.set_up(0.0, None);
        Run { drive, names, outputs, time: 0.0 }
    }

    pub fn set(&mut self, inputs: &[(&str, f64)]) -> Result<(), Fault> {
        for (name, value) in inputs {
            self.drive.set(self.names.iter().position(|n| n == name).expect("an input"), *value)?;
        }
        Ok(())
    }

    /// Sets the first derivative of an input for the step ahead.
    pub fn set_derivative(&mut self, name: &str, value: f64) -> Result<(), Fault> {
        self.drive.set_input_derivative(self.names.iter().position(|n| n == name).expect("an input"), 1, value)
    }

    pub fn get(&mut self, name: &str) -> f64 {
        let reference = self.names.iter().position(|n| n == name).unwrap_or_else(|| panic!("no `{name}`"));
        let value = self.drive.get(reference).expect("a value");
        assert!(value.is_finite(), "{name} = {value}");
        value
    }

    pub fn all<const N: usize>(&mut self, names: [&str; N]) -> [f64; N] {
        names.map(|name| self.get(name))
    }

    /// Name and quantity of all outputs.
    pub fn outputs(&self) -> Vec<(String, &'static Quantity)> {
        let quantity = |i: &usize| match &self.drive.descriptions()[*i].kind {
            Kind::Real { quantity, .. } => *quantity,
            _ => unreachable!("outputs are Real here"),
        };
        self.outputs.iter().map(|i| (self.names[*i].clone(), quantity(i))).collect()
    }

    /// The values of all outputs.
    pub fn values(&mut self) -> Vec<f64> {
        let outputs = self.outputs.clone();
        outputs.iter().map(|&i| self.drive.get(i).expect("a value")).collect()
    }

    /// The bits of all outputs.
    pub fn bits(&mut self) -> Vec<u64> {
        self.values().into_iter().map(f64::to_bits).collect()
    }

    pub fn to(&mut self, time: f64) -> Result<(), Fault> {
        if time > self.time {
            self.drive.advance(self.time, time - self.time)?;
            // The drive arrives at the rounded sum.
            self.time += time - self.time;
        }
        Ok(())
    }
}
