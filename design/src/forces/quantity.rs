//! Quantities over the turn of a drive, with their names in files and for people.

use super::{Contact, Drive, Forces};
use crate::cam_geometry::{Cut, Follower as Carrier, Side};
use crate::report::unit::{self, DEG, Unit};

/// A coherent SI unit, and the unit that people read.
pub type Units = (&'static str, Unit);

/// A force.
pub const NEWTON: Units = ("N", unit::N);
/// A torque.
pub const TORQUE: Units = ("N·m", unit::NM);
const PRESSURE: Units = ("Pa", unit::PRESSURE);
const ANGLE: Units = ("rad", DEG);

/// A quantity that varies over the turn.
pub struct Quantity<'a> {
    /// Its name in files.
    pub key: String,
    /// Its name for people.
    pub name: String,
    /// The unit.
    pub unit: Units,
    /// True if it is a component, whose largest value says little.
    pub part: bool,
    /// Its value.
    pub of: Box<dyn Fn(&Forces) -> f64 + 'a>,
}

impl Drive {
    /// All varying quantities, in the order of the flow of force from the cam to the tool.
    pub fn quantities(&self) -> Vec<Quantity<'_>> {
        let mut list: Vec<Quantity<'_>> = Vec::new();
        let mut add = |key: &str, name: &str, unit: Units, part: bool, of: Box<dyn Fn(&Forces) -> f64>| {
            let (key, name) = (key.replace(['–', ' '], "_"), name.to_owned());
            list.push(Quantity { key, name, unit, part, of });
        };
        let flat = self.is_flat();
        for (i, bearing) in self.contacts.iter().enumerate() {
            let (key, name) = match (self.plan.map(|plan| plan.cut), bearing.side) {
                (Some(Cut::Conjugate(_)), _) => (format!("_{}", bearing.name), format!(", cam {}", bearing.name)),
                (Some(Cut::Groove), Side::Inner) => ("_inner".to_owned(), ", inner contour".to_owned()),
                (Some(Cut::Groove), _) => ("_outer".to_owned(), ", outer contour".to_owned()),
                _ => (String::new(), String::new()),
            };
            let mut of = |what: &str, words: &str, unit: Units, of: fn(&Contact) -> f64| {
                let value = Box::new(move |forces: &Forces| of(&forces.contacts[i]));
                add(&format!("{what}{key}"), &format!("{words}{name}"), unit, false, value);
            };
            if flat {
                of("contact_force", "force on the face", NEWTON, |contact| contact.force);
            } else if self.is_force_closed() {
                of("roller_force", "roller force", NEWTON, |contact| contact.force);
            } else {
                of("roller_force", "roller force", NEWTON, |contact| contact.force.max(0.0));
            }
            // Both flanks of a groove have the same one.
            if !flat && (i == 0 || !bearing.name.is_empty()) {
                of("pressure_angle", "pressure angle", ANGLE, |contact| contact.pressure_angle);
            }
            if self.loads.material.is_some() {
                of("hertzian_pressure", "Hertzian pressure", PRESSURE, |contact| contact.hertzian);
            }
        }
        if flat {
            let moment = |forces: &Forces| forces.contacts[0].side;
            add("tilting_moment", "tilting moment on the follower", TORQUE, false, Box::new(moment));
        }
        if self.contacts.iter().any(|bearing| matches!(bearing.cam.follower, Carrier::Translating { .. })) {
            let bearing = |forces: &Forces| {
                let bears = forces.contacts.iter().max_by(|a, b| a.force.total_cmp(&b.force));
                bears.map_or(0.0, |contact| contact.side)
            };
            add("side_force", "side force of the follower", NEWTON, false, Box::new(bearing));
        }
        let (key, name, unit) = match self.follower.cam_turns() {
            true => ("lever_torque", self.turned(), TORQUE),
            false => ("follower_force", "force on the follower", NEWTON),
        };
        add(key, name, unit, false, Box::new(|forces| forces.load));
        for (i, mechanism) in self.follower.linkage.0.iter().enumerate() {
            let (key, name) = (format!("linkage{}", i + 1), format!("linkage[{}] ({})", i + 1, mechanism.name()));
            let input = Box::new(move |forces: &Forces| forces.mechanisms[i].input);
            // Without inertia of the lever the torque of the first mechanism is the torque on the lever.
            let same = i == 0 && self.loads.lever_inertia == 0.0;
            add(&format!("{key}_input"), &format!("{name}: torque on its input"), TORQUE, same, input);
            for (k, joint) in super::mechanism::joints(mechanism, self.loads.teeth).iter().enumerate() {
                let at = move |forces: &Forces| forces.mechanisms[i].joints[k];
                let key = format!("{key}_{joint}");
                add(&key, &format!("{name}: {joint}"), NEWTON, false, Box::new(move |forces| at(forces).norm()));
                add(&format!("{key}_x"), "", NEWTON, true, Box::new(move |forces| at(forces).re));
                add(&format!("{key}_y"), "", NEWTON, true, Box::new(move |forces| at(forces).im));
            }
        }
        if let Some(last) = self.follower.linkage.0.len().checked_sub(1) {
            let (name, unit) =
                if self.follower.turns { ("torque on the tool", TORQUE) } else { ("force on the tool", NEWTON) };
            add("tool_load", name, unit, false, Box::new(move |forces| forces.mechanisms[last].output));
        }
        add("torque", "torque on the shaft", TORQUE, false, Box::new(|forces| forces.torque));
        list
    }
}
