//! What the FMUs of the example scenes cost an importer, measured through rust-fmi.
//!
//! `cargo bench --features import --bench do_step` packs every scene below `examples` with the runtime library of the same
//! build and prints one row per FMU. Each number is the median of repetitions that are interleaved, one FMU after the
//! other, so that a change of the clock rate or a busy machine touches all of them alike.
//!
//! - *export*: scene file to FMU in memory; *open*: unzip and parse the model description (rust-fmi);
//! - *start*: load the library, instantiate, initialise;
//! - *step*: `fmi2DoStep` of 1 ms; *step+3*: the same and three `fmi2GetReal` of one variable each;
//! - *call*: `fmi2GetReal` of nothing, what rust-fmi and the checks of the C interface take.

use camdrive_cli::export::{Packed, RuntimeLibrary, pack};
use camdrive_cli::scene;
use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::traits::FmiImport;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The folder of the workspace.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

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
    export: f64,
    open: f64,
    start: f64,
    /// Nanoseconds per communication step or call.
    step: f64,
    step_and_get: f64,
    call: f64,
}

fn main() {
    let library = library();
    let scenes = scenes();
    let mut samples: Vec<Vec<Sample>> = scenes.iter().map(|_| Vec::new()).collect();
    for _ in 0..REPETITIONS {
        for (path, samples) in scenes.iter().zip(&mut samples) {
            samples.push(sample(path, &library));
        }
    }
    println!("runtime library: {} bytes; medians of {REPETITIONS} repetitions", library.bytes.len());
    println!(
        "{:<26}{:>9}{:>10}{:>9}{:>10}{:>9}{:>10}{:>8}",
        "", "FMU", "export", "open", "start", "step", "step+3", "call"
    );
    println!("{:<26}{:>9}{:>10}{:>9}{:>10}{:>9}{:>10}{:>8}", "", "bytes", "ms", "ms", "ms", "ns", "ns", "ns");
    for (path, samples) in scenes.iter().zip(&samples) {
        let (name, fmu) = export(path, &library);
        let median = |of: fn(&Sample) -> f64| median(samples.iter().map(of));
        println!(
            "{name:<26}{:>9}{:>10.1}{:>9.1}{:>10.2}{:>9.0}{:>10.0}{:>8.1}",
            fmu.bytes.len(),
            median(|s| s.export),
            median(|s| s.open),
            median(|s| s.start),
            median(|s| s.step),
            median(|s| s.step_and_get),
            median(|s| s.call)
        );
    }
}

/// The runtime library that `cargo bench` has just built beside this executable.
fn library() -> RuntimeLibrary {
    let name = format!("{}camdrive{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let executable = std::env::current_exe().expect("the executable has a path");
    RuntimeLibrary::read("linux64", &executable.with_file_name(name)).unwrap_or_else(|fault| panic!("{fault}"))
}

/// The scene files of the examples.
fn scenes() -> Vec<PathBuf> {
    let files = |folder: &Path| {
        let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
        entries.map(|entry| entry.expect("an entry of the folder").path()).collect::<Vec<_>>()
    };
    let folders = files(&root().join("examples"));
    let mut scenes: Vec<PathBuf> = folders
        .iter()
        .filter(|folder| folder.is_dir())
        .flat_map(|folder| files(folder))
        // A task.toml is a motion task, a study.toml a study, a system.toml a system: no scenes.
        .filter(|file| file.extension().is_some_and(|e| e == "toml"))
        .filter(|file| !["task.toml", "study.toml", "system.toml"].iter().any(|name| file.ends_with(name)))
        .collect();
    scenes.sort();
    scenes
}

fn export(path: &Path, library: &RuntimeLibrary) -> (String, Packed) {
    let scene = scene::read(path).unwrap_or_else(|_| panic!("{} has faults; see camdrive check", path.display()));
    let packed = pack(&scene.resource(), &scene.description, std::slice::from_ref(library), None);
    (scene.name, packed.unwrap_or_else(|fault| panic!("{}: {fault}", path.display())))
}

fn sample(path: &Path, library: &RuntimeLibrary) -> Sample {
    let ((_, packed), export) = timed(|| export(path, library));
    let (fmu, open): (Fmi2Import, f64) =
        timed(|| fmi::import::new(std::io::Cursor::new(packed.bytes)).expect("an FMU"));
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
    Sample { export, open, start, step: step * per_step, step_and_get: step_and_get * per_step, call: call * per_step }
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
