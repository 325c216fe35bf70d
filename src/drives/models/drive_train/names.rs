//! The names of the single models. A BacklashDrive or a RigidMachine that its loads, its motor or a missing flank make a train keeps
//! the variables that it has without them.

use super::variables::{self, Dependencies, Of, place};
use super::{DriveTrain, Joint, Start};
use crate::drives::models::rigid_machine;
use crate::drives::shaft::cam_drive::{self, LARGEST_START};
use crate::drives::shaft::free::motor::Kloss;
use crate::drives::shaft::motor::Source;
use crate::drives::unit;
use crate::drives::variable::{Access, Enumeration, Kind, real, real_within};
use crate::drives::{Fault, List, Seed};
use crate::numerics::taylor::Series;
use serde::{Deserialize, Serialize};

/// Whose names the variables have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Names {
    /// Those of a train.
    #[default]
    Train,
    /// Those of a BacklashDrive, with q (m) and q̇ (m/s) of its start.
    Backlash([f64; 2]),
    /// Those of a RigidMachine, with the torque (N·m) with which a motor with a lag starts.
    Machine(f64),
}

/// The items of `start.mode` of a train.
static START_MODE: Enumeration = Enumeration {
    name: "TrainStart",
    items: &[
        ("at_rest", "At rest relative to the cams: q = 0, der(q) = 0, contact"),
        ("equilibrium", "Where the loads balance the springs at phi_start; der(q) = 0"),
        ("steady_state", "On the periodic motion"),
    ],
};

impl DriveTrain {
    /// What the variable with this name of a train is called.
    pub(super) fn name_of(&self, name: &str) -> String {
        match self.names {
            Names::Backlash(_) => name.replace("follower[1].", ""),
            // The place of a tool.
            Names::Machine(_) if name.contains("].y") => name.replace("].y", "]").replace("follower[", "U["),
            _ => name.to_owned(),
        }
    }

    /// The same in a fault.
    pub(super) fn told(&self, mut fault: Fault) -> Fault {
        fault.0.variable = self.name_of(&fault.variable);
        fault
    }

    /// Gives the variables their names.
    pub(super) fn rename(&self, list: &mut List<Self>) {
        if self.names == Names::Train {
            return;
        }
        // `y` is all that the single models know of it.
        list.0.retain(|variable| !variable.description.name.ends_with("].U"));
        for variable in &mut list.0 {
            let of = &mut variable.description;
            let names = [&mut of.name, &mut of.key, &mut of.text].into_iter().chain(&mut of.derivative_of);
            let names = names.chain(&mut of.dependencies).chain(&mut of.initial_dependencies);
            names.for_each(|name| *name = self.name_of(name));
            if let Access::Computed { series: Some(series) } = &mut variable.access {
                *series = series_of_renamed;
            }
        }
        // The elements of an array follow one another.
        list.0.sort_by_key(|variable| {
            let name = &variable.description.name;
            if name.contains("U[") { 1 + name.matches("der(").count() + name.matches(",2)").count() } else { 0 }
        });
    }

    /// Declares the motions of the levers, as a RigidMachine has them.
    pub(super) fn declare_levers(&self, list: &mut List<Self>, dependencies: &Dependencies) {
        let Names::Machine(_) = self.names else { return };
        for (of, before, after, what) in [
            (Of::Lever, "lever", "", "Position"),
            (Of::LeverDot, "der(lever", ")", "Velocity"),
            (Of::LeverDotDot, "der(lever", ",2)", "Acceleration"),
        ] {
            let quantity = match of {
                Of::Lever => &unit::ANGLE,
                Of::LeverDot => &unit::ANGULAR_VELOCITY,
                _ => &unit::ANGULAR_ACCELERATION,
            };
            for j in (0..self.train.followers.len()).filter(|j| self.train.followers[*j].rigid.has_lever()) {
                let (name, text) =
                    (format!("{before}[{}]{after}", j + 1), format!("{what} of the lever of follower {}", j + 1));
                let variable = list.output(&name, &text, real(quantity), variables::series);
                dependencies.declare(variable, place(j, of));
            }
        }
    }

    /// How such a drive may start: the items of `start.mode`, and what they mean.
    fn starts(&self) -> (&'static Enumeration, &'static [Start]) {
        let spring = matches!(self.train.followers.first().map(|f| f.joint), Some(Joint::Backlash(p)) if p.m2 > 0.0);
        match self.names {
            Names::Backlash(_) if spring => {
                (&cam_drive::START_MODE, &[Start::AtRest, Start::Given, Start::SteadyState, Start::Equilibrium])
            }
            Names::Machine(_) => (&rigid_machine::START_MODE, &[Start::AtRest, Start::SteadyState]),
            _ => (&START_MODE, &[Start::AtRest, Start::Equilibrium, Start::SteadyState]),
        }
    }

    /// The motor has a lag, whose torque is a state.
    pub(super) fn lags(&self) -> bool {
        matches!(self.motor().map(|motor| &motor.source), Some(Source::Kloss(Kloss { dynamics: Some(_), .. })))
    }

    /// Declares `start.mode` and what belongs to it.
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

/// The series of an output with respect to an input or state with a name of its own.
fn series_of_renamed(d: &DriveTrain, seed: Seed, which: usize) -> Series {
    let Seed::Known(name) = seed else { return variables::series(d, seed, which) };
    let own = d.input_names().into_iter().chain(d.state_names()).find(|own| d.name_of(own) == name);
    variables::series(d, Seed::Known(own.as_deref().unwrap_or(name)), which)
}
