//! The names of the variables: a train's, or a single model's if loads, motor or a missing flank make the train one.

use super::{DriveTrain, Start};
use crate::drives::List;
use crate::drives::models::rigid_machine;
use crate::drives::shaft::cam_drive::{self, LARGEST_START};
use crate::drives::shaft::free::motor::Kloss;
use crate::drives::shaft::motor::Source;
use crate::drives::unit;
use crate::drives::variable::{Enumeration, Kind, real_within};
use serde::{Deserialize, Serialize};

/// The model that names the variables.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Names {
    /// A train.
    #[default]
    Train,
    /// A BacklashDrive, with q (m) and q̇ (m/s) of its start.
    Backlash([f64; 2]),
    /// A RigidMachine, with the torque (N·m) at the start of a motor with a lag.
    Machine(f64),
}

/// The items of `start.mode` of a train.
static START_MODE: Enumeration = Enumeration {
    name: "TrainStart",
    items: &[
        ("at_rest", "At rest relative to the cams: q = 0, der(q) = 0, contact"),
        ("equilibrium", "In the equilibrium of loads and springs at phi_start; der(q) = 0"),
        ("steady_state", "On the periodic motion"),
    ],
};

impl Names {
    /// The name in the model of `name` in the equations of follower j.
    pub(super) fn of(&self, j: usize, name: &str) -> String {
        match (self, name) {
            (Names::Backlash(_), _) => name.to_owned(),
            // The place of a tool.
            (Names::Machine(_), "y") => format!("U[{}]", j + 1),
            (Names::Machine(_), "lever") => format!("lever[{}]", j + 1),
            _ => format!("follower[{}].{name}", j + 1),
        }
    }

    /// Its time derivative of this order.
    pub(super) fn derivative(&self, j: usize, name: &str, order: usize) -> String {
        match (order, self.of(j, name)) {
            (0, name) => name,
            (1, name) => format!("der({name})"),
            (_, name) => format!("der({name},{order})"),
        }
    }

    /// Whether the model has this output of a follower.
    pub(super) fn show(&self, name: &str) -> bool {
        match name {
            // The single models only have `y` of it.
            "U" => *self == Names::Train,
            "force_mean" | "damping_loss" => matches!(self, Names::Backlash(_)),
            "lever" => matches!(self, Names::Machine(_)),
            _ => true,
        }
    }

    /// Whether an output of a follower is an element of an array over all followers.
    pub(super) fn array(&self, name: &str) -> bool {
        matches!(self, Names::Machine(_)) && ["y", "lever"].contains(&name)
    }
}

impl DriveTrain {
    /// The admissible starts of such a drive: the items of `start.mode`, and their meanings.
    fn starts(&self) -> (&'static Enumeration, &'static [Start]) {
        let spring = self.train.followers.first().is_some_and(|follower| follower.joint.sprung().is_some());
        match self.names {
            Names::Backlash(_) if spring => {
                (&cam_drive::START_MODE, &[Start::AtRest, Start::Given, Start::SteadyState, Start::Equilibrium])
            }
            Names::Machine(_) => (&rigid_machine::START_MODE, &[Start::AtRest, Start::SteadyState]),
            _ => (&START_MODE, &[Start::AtRest, Start::Equilibrium, Start::SteadyState]),
        }
    }

    /// Whether the motor has a lag, so that its torque is a state.
    pub(super) fn lags(&self) -> bool {
        matches!(self.motor().map(|motor| &motor.source), Some(Source::Kloss(Kloss { dynamics: Some(_), .. })))
    }

    /// Declares `start.mode` and the start values.
    pub(super) fn declare_start(&self, list: &mut List<Self>) {
        let (items, modes) = self.starts();
        list.parameter(
            "start.mode",
            "How the initial state is found",
            Kind::Enumeration(items),
            |d, _| d.starts().1.iter().position(|mode| *mode == d.start).map_or(1.0, |place| 1.0 + place as f64),
            |d, _, value| d.start = d.starts().1.get(value as usize - 1).copied().unwrap_or_default(),
        );
        let given = modes.contains(&Start::Given);
        let machine = matches!(self.names, Names::Machine(_)) && self.lags();
        for (i, (_, name, text, quantity, most)) in [
            (given, "start.q", "q at the start, for start.mode = given", &unit::LENGTH, LARGEST_START[0]),
            (given, "start.q_dot", "der(q) at the start, for start.mode = given", &unit::VELOCITY, LARGEST_START[1]),
            (machine, "motor.M_start", "Torque of the rotor at the start, for start.mode = given", &unit::TORQUE, 1e12),
        ]
        .into_iter()
        .enumerate()
        .filter(|(_, (wanted, ..))| *wanted)
        {
            let kind = real_within(quantity, -most, most);
            let get = |d: &Self, i: usize| match d.names {
                Names::Backlash(start) => start[i],
                Names::Machine(torque) => torque,
                Names::Train => 0.0,
            };
            let set = |d: &mut Self, i: usize, value| match &mut d.names {
                Names::Backlash(start) => start[i] = value,
                Names::Machine(torque) => *torque = value,
                Names::Train => {}
            };
            list.parameter(name, text, kind, get, set).at(i);
        }
    }
}
