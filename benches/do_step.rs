//! What the FMUs of the example scenes cost an importer, measured through rust-fmi.
//!
//! `cargo bench --manifest-path tests/importer/Cargo.toml --target-dir target/importer -- FMU…` prints one row per FMU. Each
//! number is the median of repetitions that are interleaved, one FMU after the other, so that a change of the clock rate or a
//! busy machine touches all of them alike.
//!
//! - *open*: unzip and parse the model description (rust-fmi);
//! - *start*: load the library, instantiate, initialise;
//! - *step*: `fmi2DoStep` of 1 ms; *step+3*: the same and three `fmi2GetReal` of one variable each;
//! - *call*: `fmi2GetReal` of nothing, what rust-fmi and the checks of the C interface take.

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::traits::FmiImport;
use std::hint::black_box;
use std::path::PathBuf;
use std::time::Instant;

/// The communication step (s).
const STEP: f64 = 1e-3;

/// Communication steps of one repetition: some ten milliseconds for the dearest drive.
const STEPS: u32 = 1000;

/// Odd, so that the median is one of them.
const REPETITIONS: usize = 21;

/// What a master is likely to read; the first three that a drive has.
const READ: [&str; 5] = ["tau", "y", "der(y)", "phi", "w"];

/// The times of one repetition.
struct Sample {
    /// Milliseconds.
    open: f64,
    start: f64,
    /// Nanoseconds per communication step or call.
    step: f64,
    step_and_get: f64,
    call: f64,
}

fn main() {
    // Cargo calls a benchmark with `--bench` behind the arguments of the user.
    let fmus: Vec<PathBuf> = std::env::args_os().skip(1).filter(|text| text != "--bench").map(PathBuf::from).collect();
    let packed: Vec<Vec<u8>> =
        fmus.iter().map(|path| std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))).collect();
    let mut samples: Vec<Vec<Sample>> = fmus.iter().map(|_| Vec::new()).collect();
    for _ in 0..REPETITIONS {
        for (bytes, samples) in packed.iter().zip(&mut samples) {
            samples.push(sample(bytes));
        }
    }
    println!("medians of {REPETITIONS} repetitions");
    println!("{:<26}{:>9}{:>9}{:>10}{:>9}{:>10}{:>8}", "", "FMU", "open", "start", "step", "step+3", "call");
    println!("{:<26}{:>9}{:>9}{:>10}{:>9}{:>10}{:>8}", "", "bytes", "ms", "ms", "ns", "ns", "ns");
    for ((path, bytes), samples) in fmus.iter().zip(&packed).zip(&samples) {
        let median = |of: fn(&Sample) -> f64| median(samples.iter().map(of));
        println!(
            "{:<26}{:>9}{:>9.1}{:>10.2}{:>9.0}{:>10.0}{:>8.1}",
            path.file_stem().unwrap_or_default().to_string_lossy(),
            bytes.len(),
            median(|s| s.open),
            median(|s| s.start),
            median(|s| s.step),
            median(|s| s.step_and_get),
            median(|s| s.call)
        );
    }
}

fn sample(bytes: &[u8]) -> Sample {
    let (fmu, open): (Fmi2Import, f64) = timed(|| fmi::import::new(std::io::Cursor::new(bytes)).expect("an FMU"));
    let references = references(&fmu);
    let (mut instance, start) = timed(|| started(&fmu));

    let ((), step) = timed(|| steps(&mut instance, |_| ()));
    // From the start again: a drive may have dearer and cheaper stretches.
    let mut instance = started(&fmu);
    let ((), step_and_get) = timed(|| {
        steps(&mut instance, |instance| {
            for reference in &references {
                let mut value = [0.0];
                instance.get_real(&[*reference], &mut value).expect("a value");
                black_box(value);
            }
        });
    });
    let ((), call) = timed(|| {
        for _ in 0..STEPS {
            instance.get_real(&[], &mut []).expect("no value");
        }
    });
    let per_step = 1e6 / f64::from(STEPS);
    Sample { open, start, step: step * per_step, step_and_get: step_and_get * per_step, call: call * per_step }
}

/// What `action` gives, and how long it took (ms).
fn timed<T>(action: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = action();
    (result, start.elapsed().as_secs_f64() * 1e3)
}

fn started(fmu: &Fmi2Import) -> InstanceCS {
    let mut instance = fmu.instantiate_cs("bench", false, false).expect("an instance");
    instance.setup_experiment(None, 0.0, None).expect("an experiment");
    instance.enter_initialization_mode().expect("initialisation");
    instance.exit_initialization_mode().expect("the end of initialisation");
    instance
}

/// `STEPS` communication steps from the start, with `after` called after each.
fn steps(instance: &mut InstanceCS, mut after: impl FnMut(&mut InstanceCS)) {
    for i in 0..STEPS {
        instance.do_step(f64::from(i) * STEP, STEP, true).expect("a step");
        after(instance);
    }
}

fn references(fmu: &Fmi2Import) -> Vec<u32> {
    let variables = &fmu.model_description().model_variables.variables;
    let of = |name: &&str| variables.iter().find(|v| v.name == **name).map(|v| v.value_reference);
    let references: Vec<u32> = READ.iter().filter_map(of).take(3).collect();
    assert_eq!(references.len(), 3, "too few of {READ:?}");
    references
}

/// The median of an odd number of values.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
