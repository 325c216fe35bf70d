//! A follower of a train: what hangs between its cam, or its crank, and its tool, and what acts on it.

use super::load::Load;
use super::{contact, elastic_output, elastic_shaft, rigid};
use serde::{Deserialize, Serialize};

/// A follower with its loads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Follower {
    /// Law and mechanisms; the tool's mass where the follower is rigid, else 0.
    pub rigid: rigid::Follower,
    /// What is between cam and tool.
    pub joint: Joint,
    /// On the tool.
    pub load: Load,
    /// On the mass on the cam's side: m_x of an elastic output, m1 with backlash.
    pub roller: Load,
}

impl Follower {
    /// What spring, gravity and constant force press with in the sense of y where a cam without clearance moves the tool to y; 0
    /// behind mechanisms, and with clearance, whose motion knows the flight.
    pub fn hold(&self, y: f64) -> f64 {
        let [m, m_x] = match self.joint {
            Joint::Rigid => [self.rigid.m, 0.0],
            Joint::Output(p, m_x) => [p.m, m_x],
            Joint::Shaft(p) => [p.m, 0.0],
            Joint::Backlash(_) => return 0.0,
        };
        if self.rigid.linkage.is_empty() { self.load.hold(m, y) + self.roller.hold(m_x, y) } else { 0.0 }
    }
}

/// What is between cam and tool.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Joint {
    /// Nothing.
    Rigid,
    /// A spring, with the mass m_x (kg) on the cam's side of it.
    Output(elastic_output::Parameters, f64),
    /// An elastic shaft before the cam.
    Shaft(elastic_shaft::Parameters),
    /// Clearance; s is infinite where there is no flank B.
    Backlash(#[serde(with = "contact::one_sided")] contact::Parameters),
}
