//! Saved states with a right checksum over wrong bytes: nonsense may come of them, but no call is without end, no panic
//! passes, and what is read is a number.

use super::limits::drive;
use camdrive::drives::variable::{Causality, Kind, Type};
use camdrive::fmi2::abi;
use camdrive::fmi2::call_sequence::DO_STEP;
use camdrive::fmi2::instance::Instance;
use camdrive::fmi2::log::Logger;
use camdrive::numerics::work::drawn;
use std::cell::Cell;
use std::ffi::CStr;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local!(static PANICS: Cell<u32> = const { Cell::new(0) });

/// Scenes with what is set in them, and the communication step (s).
const STATES: &[(&str, &[(&str, f64)], f64)] = &[
    ("output", &[], 0.01),
    ("output_cycle", &[], 0.01),
    ("output_input", &[("w", 20.0), ("a", 3.0)], 0.01),
    ("output_wide_input", &[("w", 20.0), ("a", 3.0)], 0.3),
    ("shaft", &[], 0.01),
    ("shaft", &[("shaft.linear", 1.0)], 0.01),
    ("shaft", &[("solver.method", 2.0)], 0.01),
    ("shaft_cycle", &[], 0.01),
    ("shaft_input", &[("w", 20.0)], 0.01),
    ("backlash", &[], 0.01),
    ("backlash", &[("e", 0.5)], 0.01),
    ("backlash_cycle", &[], 0.01),
    ("backlash_input", &[("w", 20.0), ("a", 3.0)], 0.01),
    ("parametric", &[], 0.01),
    ("crank_input", &[("w", 20.0)], 0.01),
    ("machine", &[], 0.01),
    ("machine_motor", &[], 0.01),
    ("machine_lag", &[], 0.01),
    ("machine_cycle", &[("solver.method", 2.0)], 0.01),
];

/// What a word is replaced by.
const WORDS: [f64; 7] = [f64::NAN, f64::INFINITY, 1e300, -1e300, 0.0, 1e-300, -1.0];

/// What a byte is replaced by: small counts, and the ends of its range.
const BYTES: [u8; 5] = [0xff, 0x7f, 0x80, 0x00, 0x11];

/// Every so many bytes one is forged: no multiple of the eight of a number, so that each of its bytes has its turn, in seconds.
const STRIDE: usize = 11;

/// What header and checksum take.
const HEADER: usize = 28;
const CHECKSUM: usize = 4;

/// The instance after some steps, and its saved state.
fn saved(scene: &str, settings: &[(&str, f64)], step: f64) -> (Instance, Vec<u8>, Vec<u32>) {
    let drive = drive(scene);
    let names: Vec<String> = drive.descriptions().iter().map(|d| d.name.clone()).collect();
    let real_output =
        |d: &&camdrive::drives::Description| d.causality == Causality::Output && matches!(d.kind, Kind::Real { .. });
    let outputs = (0..).zip(drive.descriptions()).filter(|(_, d)| real_output(d)).map(|(i, _)| i).collect();
    let mut drive = drive.plan().instance();
    for (name, value) in settings {
        drive.set(names.iter().position(|own| own == name).unwrap(), *value).unwrap();
    }
    // A panic in a step is told as an internal error.
    let sink = |_, _: &CStr, text: &CStr| {
        PANICS.set(PANICS.get() + u32::from(text.to_string_lossy().contains("internal error")))
    };
    let mut instance = Instance::new(drive, "guid", Logger::new(Box::new(sink), false));
    instance.enter_initialization().unwrap();
    instance.exit_initialization().unwrap();
    for _ in 0..5 {
        assert_eq!(take_step(&mut instance, step), abi::OK, "{scene}");
    }
    let bytes = instance.serialize(&instance.save()).unwrap();
    (instance, bytes, outputs)
}

/// The status of a step, as an importer gets it.
fn take_step(instance: &mut Instance, step: f64) -> abi::fmi2Status {
    instance.call(&DO_STEP, |instance| instance.do_step(instance.last_successful_time(), step))
}

/// The bytes with another content and the checksum that belongs to it.
fn forged(bytes: &[u8], at: usize, with: &[u8]) -> Vec<u8> {
    let mut bytes = bytes[..bytes.len() - CHECKSUM].to_vec();
    let end = (at + with.len()).min(bytes.len());
    bytes[at..end].copy_from_slice(&with[..end - at]);
    let checksum = crc32fast::hash(&bytes);
    bytes.extend(checksum.to_le_bytes());
    bytes
}

/// Restores these bytes, takes steps and reads; whether all went well.
fn try_out(instance: &mut Instance, bytes: &[u8], step: f64, outputs: &[u32]) -> bool {
    let Ok(state) = instance.deserialize(bytes) else { return false };
    instance.restore(&state).unwrap();
    for _ in 0..2 {
        if take_step(instance, step) != abi::OK {
            return false;
        }
        for reference in outputs {
            let read = instance.get(Type::Real, *reference).ok();
            assert!(read.is_none_or(f64::is_finite));
        }
    }
    true
}

#[test]
fn a_forged_state_ends_in_an_error_or_in_numbers() {
    let mut panics = String::new();
    for (scene, settings, step) in STATES {
        let (mut instance, bytes, outputs) = saved(scene, settings, *step);
        assert!(try_out(&mut instance, &bytes, *step, &outputs), "{scene} itself");
        // A call that needs more than this belongs to no such step.
        let limited = drawn::limit(3e3);
        let mut went_well = 0;
        for (n, at) in (HEADER..bytes.len() - CHECKSUM).step_by(STRIDE).enumerate() {
            let word = WORDS[n % WORDS.len()].to_le_bytes();
            let byte = [BYTES[n % BYTES.len()]];
            for with in [&word[..], &byte[..]] {
                let forged = forged(&bytes, at, with);
                let outcome = catch_unwind(AssertUnwindSafe(|| try_out(&mut instance, &forged, *step, &outputs)));
                match outcome {
                    Ok(good) if PANICS.take() == 0 => went_well += usize::from(good),
                    _ => panics += &format!("{scene} {settings:?}: {} of {} is {with:?}\n", at - HEADER, bytes.len()),
                }
            }
        }
        drop(limited);
        // Most bytes are digits of numbers.
        assert!(went_well > bytes.len() / STRIDE / 4, "{scene}: {went_well} of {}", bytes.len() / STRIDE);
    }
    assert!(panics.is_empty(), "\n{panics}");
}

/// Uniform numbers in [0, 1) from a seed (Steele, Lea, Flood: SplitMix64).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn next(&mut self) -> f64 {
        self.bits() as f64 / 2f64.powi(64)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }

    /// A number of any size, or one that is special.
    fn number(&mut self) -> f64 {
        const SPECIAL: [f64; 6] = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 0.0, 1e300, 1e-300];
        match self.below(3) {
            0 => SPECIAL[self.below(SPECIAL.len())],
            1 => f64::from_bits(self.bits()),
            _ => (self.next() - 0.5).signum() * 10f64.powf(40.0 * self.next() - 20.0),
        }
    }
}

/// Where in these bytes a number of common size, or an infinite one, seems to stand.
fn numbers(content: &[u8]) -> Vec<usize> {
    let is_number = |at: &usize| {
        let number = f64::from_le_bytes(content[*at..*at + 8].try_into().unwrap()).abs();
        number == f64::INFINITY || (1e-9..1e9).contains(&number)
    };
    (0..content.len() - 7).filter(is_number).collect()
}

/// Replaces some numbers and bytes of a state.
fn forge(r: &mut Random, bytes: &[u8], numbers: &[usize]) -> Vec<u8> {
    let mut forged_bytes = bytes.to_vec();
    for _ in 0..1 + r.below(4) {
        let at = HEADER + numbers[r.below(numbers.len())];
        let old = f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        let anywhere = HEADER + r.below(bytes.len() - HEADER - CHECKSUM);
        let from = HEADER + numbers[r.below(numbers.len())];
        forged_bytes = match r.below(5) {
            0 => forged(&forged_bytes, anywhere, &[r.bits() as u8]),
            1 => forged(&forged_bytes, at, &bytes[from..from + 8]),
            2 => forged(&forged_bytes, at, &(old * 10f64.powf(8.0 * r.next() - 4.0)).to_le_bytes()),
            3 => forged(&forged_bytes, at, &(-old).to_le_bytes()),
            _ => forged(&forged_bytes, at, &r.number().to_le_bytes()),
        };
    }
    forged_bytes
}

/// States with several forged numbers at once; FORGED in the environment is how many of each scene instead.
#[test]
fn calls_on_a_state_forged_at_random_end_within_their_work() {
    let count = std::env::var("FORGED").map_or(100, |count| count.parse().unwrap());
    for (n, (scene, settings, step)) in STATES.iter().enumerate() {
        let (mut instance, bytes, outputs) = saved(scene, settings, *step);
        let numbers = numbers(&bytes[HEADER..bytes.len() - CHECKSUM]);
        let r = &mut Random(n as u64);
        let _limited = drawn::limit(3e3);
        for case in 0..count {
            let forged = forge(r, &bytes, &numbers);
            drawn::since_last();
            try_out(&mut instance, &forged, *step, &outputs);
            let spent = drawn::since_last();
            // Reading the state, two steps and what they put out are calls of their own.
            assert!(spent < 4.0 * 3e3, "{scene} {settings:?}, state {case}: {spent:e}");
            assert!(PANICS.take() == 0, "{scene} {settings:?}, state {case}: a panic");
        }
    }
}
