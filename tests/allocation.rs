//! No communication step allocates, whatever the drive, its mode and what happens inside the step.

use camdrive::drives::DynDrive;
use camdrive::drives::variable::Causality;
use camdrive::scene;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::alloc::System;
use std::path::{Path, PathBuf};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// The scenes of all models and modes, of the examples and of the tests with fmpy.
fn scenes() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = vec![root.join("modelDescription"), root.join("tests/fmpy/scenes")];
    folders.extend(std::fs::read_dir(root.join("examples")).unwrap().map(|entry| entry.unwrap().path()));
    let files = folders.iter().filter(|f| f.is_dir()).flat_map(|f| std::fs::read_dir(f).unwrap());
    let mut paths: Vec<PathBuf> = files.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    paths.sort();
    assert!(paths.len() > 8);
    paths
}

/// An accelerated motion that is no continuation of the step before, and a torque that changes its sign: inputs jump,
/// contacts open and close.
fn set_inputs(drive: &mut dyn DynDrive, inputs: &[(usize, String)], time: f64) {
    for (reference, name) in inputs {
        let value = match name.as_str() {
            "phi" => 20.0 * time + (300.0 * time).sin() * 1e-3,
            "w" => 20.0 + 3.0 * time,
            "a" => 3.0,
            _ => (40.0 * time).sin(),
        };
        drive.set(*reference, value).unwrap();
        if 0 < drive.input_derivative_order() {
            drive.set_input_derivative(*reference, 1, 0.1).unwrap();
        }
    }
}

/// One test only: the count is that of the whole process.
#[test]
fn a_step_does_not_allocate() {
    for path in scenes() {
        let scene = scene::read(&path).unwrap_or_else(|faults| panic!("{faults}"));
        let mut drive = scene.resource().build().unwrap();
        let list = drive.descriptions();
        let inputs = list.iter().enumerate().filter(|(_, d)| d.causality == Causality::Input);
        let inputs: Vec<(usize, String)> = inputs.map(|(i, d)| (i, d.name.clone())).collect();
        let step = drive.experiment().step;
        drive.set_up(0.0, None);
        set_inputs(&mut *drive, &inputs, 0.0);
        drive.start().unwrap();
        let mut time = 0.0;
        let mut events = 0;
        // Short, usual and long steps.
        for size in [1e-3, 1.0, 37.0].map(|factor| factor * step) {
            for _ in 0..40 {
                let region = Region::new(ALLOCATOR);
                set_inputs(&mut *drive, &inputs, time);
                let outcome = drive.advance(time, size);
                let change = region.change();
                outcome.unwrap();
                assert_eq!(
                    (change.allocations, change.reallocations, change.deallocations),
                    (0, 0, 0),
                    "{} at t = {time} s",
                    path.display()
                );
                events += drive.events().iter().count();
                drive.events().clear();
                time += size;
            }
        }
        // The drive with backlash is here for its events.
        assert!(events > 0 || !scene.model.starts_with("Backlash"), "{}: no event", path.display());
    }
}
