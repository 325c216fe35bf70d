//! An exported FMU driven through rust-fmi, as an importer would.

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, InstanceCS};
use fmi::schema::fmi2::{Causality, Fmi2ModelDescription, ScalarVariable};
use fmi::traits::{FmiImport, FmiStatus};
use std::path::{Path, PathBuf};

/// The guide bar, as `tests/run` exports it.
fn import() -> Fmi2Import {
    let folder = std::env::var_os("CAMDRIVE_FMUS").map(PathBuf::from);
    let folder = folder.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/fmus"));
    let path = folder.join("guide_bar.fmu");
    let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}; tests/run exports it", path.display()));
    fmi::import::new(std::io::Cursor::new(bytes)).unwrap()
}

fn variable<'a>(description: &'a Fmi2ModelDescription, name: &str) -> &'a ScalarVariable {
    description.model_variables.variables.iter().find(|v| v.name == name).unwrap()
}

fn reference(fmu: &Fmi2Import, name: &str) -> u32 {
    variable(fmu.model_description(), name).value_reference
}

fn get(instance: &mut InstanceCS, reference: u32) -> f64 {
    let mut value = [f64::NAN];
    instance.get_real(&[reference], &mut value).unwrap();
    value[0]
}

fn start(instance: &mut InstanceCS) {
    instance.setup_experiment(None, 0.0, Some(10.0)).unwrap();
    instance.enter_initialization_mode().unwrap();
    instance.exit_initialization_mode().unwrap();
}

/// Steps of 5 ms from `from` to `to`; the bits of `reference` at their ends.
fn run(instance: &mut InstanceCS, reference: u32, from: usize, to: usize) -> Vec<u64> {
    (from..to)
        .map(|i| {
            instance.do_step(i as f64 * 5e-3, 5e-3, true).unwrap();
            get(instance, reference).to_bits()
        })
        .collect()
}

#[test]
fn the_standard_sequence_and_what_deviates_from_it() {
    let fmu = import();
    let (y, m) = (reference(&fmu, "y"), reference(&fmu, "m"));
    let mut instance = fmu.instantiate_cs("with a space", false, true).unwrap();
    assert_eq!((instance.get_version(), instance.get_types_platform()), ("2.0", "default"));
    assert!(instance.do_step(0.0, 0.1, true).is_err());
    assert!(instance.exit_initialization_mode().is_err());
    instance.set_real(&[m], &[3.0]).unwrap();
    start(&mut instance);
    assert_eq!(get(&mut instance, m), 3.0);
    assert!(instance.set_real(&[m], &[-1.0]).is_err());
    assert!(instance.set_real(&[y], &[1.0]).is_err());
    assert!(instance.set_integer(&[m], &[1]).is_err());
    assert!(instance.enter_initialization_mode().is_err());
    run(&mut instance, y, 0, 10);
    assert_eq!(instance.last_successful_time().unwrap(), 9.0 * 5e-3 + 5e-3);
    assert!(!instance.terminated().unwrap());
    assert!(instance.do_step_status().is_err());
    assert!(instance.cancel_step().is_err());
    instance.terminate().unwrap();
    assert!(instance.do_step(0.05, 0.1, true).is_err());
}

#[test]
fn reset_begins_anew_with_the_parameters_of_the_scene() {
    let fmu = import();
    let (y, m) = (reference(&fmu, "y"), reference(&fmu, "m"));
    let mut instance = fmu.instantiate_cs("reset", false, false).unwrap();
    start(&mut instance);
    let expected = run(&mut instance, y, 0, 40);
    instance.reset().unwrap();
    instance.set_real(&[m], &[5.0]).unwrap();
    start(&mut instance);
    assert_ne!(run(&mut instance, y, 0, 40), expected);
    instance.reset().unwrap();
    start(&mut instance);
    assert_eq!(run(&mut instance, y, 0, 40), expected);
}

#[test]
fn a_saved_state_continues_to_the_bit() {
    let fmu = import();
    let y = reference(&fmu, "y");
    let mut instance = fmu.instantiate_cs("saved", false, false).unwrap();
    start(&mut instance);
    run(&mut instance, y, 0, 20);
    let state = instance.get_fmu_state().unwrap();
    let expected = run(&mut instance, y, 20, 60);
    instance.set_fmu_state(&state).ok().unwrap();
    assert_eq!(run(&mut instance, y, 20, 60), expected);

    let bytes = instance.serialize_fmu_state(&state).unwrap();
    let mut other = fmu.instantiate_cs("restored", false, false).unwrap();
    let copy = other.deserialize_fmu_state(&bytes).unwrap();
    other.set_fmu_state(&copy).ok().unwrap();
    assert_eq!(run(&mut other, y, 20, 60), expected);
    assert!(other.deserialize_fmu_state(&bytes[1..]).is_err());
}

#[test]
fn two_instances_do_not_disturb_each_other() {
    let fmu = import();
    let y = reference(&fmu, "y");
    let mut alone = fmu.instantiate_cs("alone", false, false).unwrap();
    start(&mut alone);
    let expected = run(&mut alone, y, 0, 40);

    let mut a = fmu.instantiate_cs("a", false, false).unwrap();
    let mut b = fmu.instantiate_cs("b", false, false).unwrap();
    start(&mut a);
    let mut interleaved = run(&mut a, y, 0, 10);
    start(&mut b);
    for i in 0..30 {
        assert_eq!(run(&mut b, y, i, i + 1), expected[i..=i]);
        interleaved.extend(run(&mut a, y, i + 10, i + 11));
    }
    assert_eq!(interleaved, expected);
}

#[test]
fn the_stored_model_descriptions_are_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../modelDescription");
    let files = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let files: Vec<PathBuf> = files.filter(|path| path.extension().is_some_and(|ending| ending == "xml")).collect();
    assert!(files.len() > 10, "{}", folder.display());
    for path in files {
        let text = std::fs::read_to_string(&path).unwrap();
        let read: Fmi2ModelDescription = text.parse().unwrap();
        assert_eq!(read.fmi_version, "2.0");
        let variables = &read.model_variables.variables;
        // Each element of the file is one variable, in its place.
        assert_eq!(variables.len(), text.matches("<ScalarVariable ").count(), "{}", path.display());
        for (position, variable) in variables.iter().enumerate() {
            assert_eq!(variable.value_reference as usize, position);
        }
        let outputs: Vec<usize> =
            read.model_structure.outputs.unknowns.iter().map(|unknown| unknown.index as usize - 1).collect();
        let declared = (0..variables.len()).filter(|place| variables[*place].causality == Causality::Output);
        assert_eq!(outputs, declared.collect::<Vec<_>>(), "{}", path.display());
    }
}
