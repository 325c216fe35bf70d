//! From the tool back to the lever.

use super::{Kind, Linkage, Mechanism};
use crate::numerics::taylor::Series;

/// A transmission below this part of the mechanism's usual one is a dead centre of the input: the inverse has no
/// derivatives there.
const DEAD: f64 = 1e-3;

/// Why no position of the lever yields a position of the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstacle {
    /// No input of this mechanism, counted from 0, yields this output (rad or m).
    OutOfReach {
        /// The mechanism.
        mechanism: usize,
        /// Its output, from its offset on.
        output: f64,
    },
    /// The input of this mechanism is at a dead centre, from which it cannot drive on.
    DeadCentre {
        /// The mechanism.
        mechanism: usize,
        /// Its output, from its offset on.
        output: f64,
    },
}

impl Mechanism {
    /// The input that yields an output, the one nearest to `near`; None where there is none.
    fn input_at(&self, output: f64, near: f64) -> Option<f64> {
        let (output, near) = (output + self.output_offset, near + self.input_offset);
        let theta = match &self.kind {
            Kind::FourBar(linkage) => linkage.input_at(output, near),
            Kind::SliderCrank(linkage) => linkage.input_at(output, near),
            Kind::Gear(gear) => Some(output / gear.ratio),
        };
        theta.map(|theta| theta - self.input_offset)
    }

    /// The transmission that is usual for these lengths.
    fn usual_slope(&self) -> f64 {
        match &self.kind {
            Kind::FourBar(linkage) => linkage.input.length / linkage.output.length,
            Kind::SliderCrank(linkage) => linkage.crank.length,
            Kind::Gear(gear) => gear.ratio.abs(),
        }
    }
}

impl Linkage {
    /// The inputs of all mechanisms where the lever is at this angle (rad); no numbers beyond one that cannot be assembled.
    pub fn inputs(&self, lever: f64) -> Vec<f64> {
        let mut input = Series([lever]);
        let mut inputs = Vec::with_capacity(self.0.len());
        for mechanism in &self.0 {
            inputs.push(input.value());
            input = mechanism.moved(input).0;
        }
        inputs
    }

    /// The lever's angle that yields the tool's coordinate, in the position next to that with these `inputs`, which become
    /// those of the position found.
    ///
    /// # Errors
    /// Where there is none, or a mechanism is at a dead centre.
    pub fn lever_at(&self, tool: f64, inputs: &mut [f64]) -> Result<f64, Obstacle> {
        let mut output = tool;
        for (i, (mechanism, near)) in self.0.iter().zip(inputs).enumerate().rev() {
            let out_of_reach = Obstacle::OutOfReach { mechanism: i, output };
            let input = mechanism.input_at(output, *near).ok_or(out_of_reach)?;
            let [found, slope] = mechanism.moved(Series([input, 1.0])).0.derivatives();
            // A slope that is no number is none either.
            if !(slope.abs() >= DEAD * mechanism.usual_slope()) {
                return Err(Obstacle::DeadCentre { mechanism: i, output });
            }
            // The same angle, but whole turns away from what the mechanism does on this branch.
            let correction = (output - found) / slope;
            if !(correction.abs() <= 1.0) {
                return Err(out_of_reach);
            }
            // What the closed form loses where its arccos is steep.
            output = input + correction;
            *near = output;
        }
        Ok(output)
    }
}
