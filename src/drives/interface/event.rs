//! Events inside a communication step, for the importer's log.

use serde::{Deserialize, Serialize};
use std::ffi::CStr;

/// The log categories of every FMU: name and meaning.
pub const LOG_CATEGORIES: [(&CStr, &str); 6] = [
    (c"logStatusWarning", "Warnings"),
    (c"logStatusError", "Errors: why a call was refused or a step failed"),
    (c"logStatusFatal", "Failures of the library itself"),
    (c"logEvents", "Events of the motion, each with its time; with clearance contact, release and impact"),
    (c"logSolver", "Notes of the solver"),
    (c"logAll", "All of the above"),
];

/// A switching instant or a note of the solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// The time (s).
    pub time: f64,
    /// The kind, for example "impact on flank A".
    pub kind: &'static str,
    /// The quantity that measures it, for example "impulse".
    pub quantity: &'static str,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// The follower, counted from 1; 0 if there is only one or none.
    pub follower: usize,
    /// The subject of the entry.
    pub about: About,
}

/// The subject of an entry of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// The machine (`logEvents`).
    Machine,
    /// Loads that do not hold the follower on its cam: no switching instant (`logEvents`).
    Loads,
    /// The solver (`logSolver`).
    Solver,
    /// Inputs that contradict each other (`logStatusWarning`).
    Inputs,
}

/// How many events of one step are kept; a chattering contact has more, and the log states their number.
const CAPACITY: usize = 32;

/// The first events of a communication step; not part of the FMU state. The memory is reserved before a step, so that the step
/// allocates nothing, and only if somebody reads them.
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
    /// A log that only counts and reserves no memory.
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

    /// The number of events that were not kept.
    pub fn dropped(&self) -> usize {
        self.count - self.events.len()
    }

    /// Forgets all events.
    pub fn clear(&mut self) {
        self.events.clear();
        self.count = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pushed(mut log: EventLog, count: usize) -> EventLog {
        for n in 0..count {
            log.push(Event {
                time: n as f64,
                kind: "impact",
                quantity: "impulse",
                value: 1.0,
                unit: "N.s",
                follower: 0,
                about: About::Machine,
            });
        }
        log
    }

    /// Events counted, kept and not kept.
    fn told(log: &EventLog) -> [usize; 3] {
        [log.count(), log.iter().count(), log.dropped()]
    }

    #[test]
    fn the_first_events_are_kept_in_the_room_that_there_is() {
        let mut log = pushed(EventLog::default(), CAPACITY + 3);
        assert_eq!(told(&log), [CAPACITY + 3, CAPACITY, 3]);
        assert!(log.iter().enumerate().all(|(n, event)| event.time == n as f64));
        assert_eq!(log.events.capacity(), CAPACITY);
        log.clear();
        assert_eq!(told(&log), [0, 0, 0]);
        assert_eq!(told(&pushed(log, 2)), [2, 2, 0]);
        assert_eq!(told(&pushed(EventLog::counting(), 2)), [2, 0, 2]);
    }

    #[test]
    fn copies_and_restored_logs_keep_events_if_they_should() {
        let copy = pushed(EventLog::default(), 2).clone();
        assert_eq!(told(&pushed(copy, 3)), [5, 5, 0]);
        let copy = pushed(EventLog::counting(), 2).clone();
        assert_eq!(told(&pushed(copy, 3)), [5, 0, 5]);
        let bytes = postcard::to_stdvec(&pushed(EventLog::default(), 2)).unwrap();
        assert_eq!(told(&pushed(postcard::from_bytes(&bytes).unwrap(), 3)), [3, 3, 0]);
    }

    #[test]
    fn keeping_begins_and_ends_with_an_empty_log() {
        for (mut log, kept) in [(EventLog::default(), true), (EventLog::counting(), false)] {
            log = pushed(log, 2);
            let before = told(&log);
            log.keep(kept);
            assert_eq!(told(&log), before);
            log.keep(!kept);
            assert_eq!(told(&pushed(log, 1)), if kept { [1, 0, 1] } else { [1, 1, 0] });
        }
    }
}
