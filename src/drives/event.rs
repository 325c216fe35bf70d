//! What happens inside a communication step, for the importer's log.

use serde::{Deserialize, Serialize};
use std::ffi::CStr;

/// The log categories of every FMU: name, and what it means.
pub const LOG_CATEGORIES: [(&CStr, &str); 6] = [
    (c"logStatusWarning", "Warnings"),
    (c"logStatusError", "Errors: why a call was refused or a step failed"),
    (c"logStatusFatal", "Failures of the library itself"),
    (c"logEvents", "Switching instants of the machine: contact, release, impact, each with its time"),
    (c"logSolver", "Notes of the solver"),
    (c"logAll", "All of the above"),
];

/// A switching instant or a note of the solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// When [s].
    pub time: f64,
    /// What, for example "impact on flank A".
    pub kind: &'static str,
    /// The quantity that measures it, for example "impulse".
    pub quantity: &'static str,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// Whether the entry speaks of the solver (`logSolver`) rather than of the machine (`logEvents`).
    pub solver: bool,
}

/// How many events of one step are kept; a chattering contact yields more, and their number is told.
const CAPACITY: usize = 32;

/// The first events of a communication step, without allocation; not part of the FMU state.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct EventLog {
    #[serde(skip)]
    events: [Option<Event>; CAPACITY],
    #[serde(skip)]
    count: usize,
}

impl EventLog {
    /// Notes an event.
    pub fn push(&mut self, event: Event) {
        if let Some(place) = self.events.get_mut(self.count) {
            *place = Some(event);
        }
        self.count += 1;
    }

    /// How many events happened.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The kept events.
    pub fn iter(&self) -> impl Iterator<Item = &Event> {
        self.events.iter().take(self.count).flatten()
    }

    /// How many events happened that are not kept.
    pub fn dropped(&self) -> usize {
        self.count.saturating_sub(CAPACITY)
    }

    /// Forgets all events.
    pub fn clear(&mut self) {
        self.count = 0;
    }
}
