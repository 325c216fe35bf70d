//! Events inside a communication step, for the importer's log.

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
    /// When (s).
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

/// The first events of a communication step; not part of the FMU state. The room for them is there before a step, so
/// that nothing is allocated in one, and only where somebody reads them.
#[derive(Debug, Serialize, Deserialize)]
pub struct EventLog {
    #[serde(skip, default = "room")]
    events: Vec<Event>,
    #[serde(skip)]
    count: usize,
}

fn room() -> Vec<Event> {
    Vec::with_capacity(CAPACITY)
}

impl Default for EventLog {
    fn default() -> Self {
        EventLog { events: room(), count: 0 }
    }
}

/// A copy keeps events if the original does.
impl Clone for EventLog {
    fn clone(&self) -> Self {
        let mut events = Vec::with_capacity(self.events.capacity());
        events.extend_from_slice(&self.events);
        EventLog { events, count: self.count }
    }
}

impl EventLog {
    /// A log that only counts, for which no room is made.
    pub fn counting() -> Self {
        EventLog { events: Vec::new(), count: 0 }
    }

    /// Whether events are kept from now on, or only counted.
    pub fn keep(&mut self, wanted: bool) {
        if wanted != (0 < self.events.capacity()) {
            self.events = if wanted { room() } else { Vec::new() };
            self.count = 0;
        }
    }

    /// Notes an event.
    pub fn push(&mut self, event: Event) {
        // Never grows.
        if self.events.len() < self.events.capacity() {
            self.events.push(event);
        }
        self.count += 1;
    }

    /// How many events happened.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The kept events.
    pub fn iter(&self) -> impl Iterator<Item = &Event> {
        self.events.iter()
    }

    /// How many events happened that are not kept.
    pub fn dropped(&self) -> usize {
        self.count - self.events.len()
    }

    /// Forgets all events.
    pub fn clear(&mut self) {
        self.events.clear();
        self.count = 0;
    }
}
