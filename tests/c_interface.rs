//! The C interface as a careless importer uses it: NULL, wrong handles, callbacks that go away, threads.

use camdrive::drives::elastic_shaft::{Parameters, Scene};
use camdrive::drives::settings::Settings;
use camdrive::drives::shaft::cam_drive::{DriveMode, Start, StartMode};
use camdrive::drives::variable::{Causality, Kind};
use camdrive::fmi2::abi::*;
use camdrive::fmi2::functions::*;
use camdrive::motion::{Fourier, MotionLaw};
use camdrive_design::resource::Resource;
use std::ffi::{CStr, CString, c_char, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

const GUID: &CStr = c"{0f5e}";

/// An elastic shaft with inputs φ, w, a; the references that the tests use are found by name.
fn resource() -> Resource {
    let scene = Scene {
        load: Default::default(),
        parameters: Parameters { m: 2.0, inertia: 0.01, c: 2e3, b: 6.0 },
        linear: false,
        cam: MotionLaw::Fourier(Fourier::new(vec![0.0, 0.01, 0.002], vec![0.0, 0.001])),
        drive: DriveMode::Input,
        start: Start { mode: StartMode::AtRest, q: 0.0, q_dot: 0.0 },
        solver: Settings::default(),
    };
    Resource { guid: GUID.to_str().unwrap().to_owned(), ..Resource::new("careless", scene) }
}

/// The value reference of a variable.
fn reference(name: &str) -> fmi2ValueReference {
    let drive = resource().build().unwrap();
    drive.descriptions().iter().position(|d| d.name == name).unwrap() as fmi2ValueReference
}

/// A resources folder whose name has to be encoded; gone when dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        Folder::of(test, &resource())
    }

    fn of(test: &str, resource: &Resource) -> Self {
        let folder = std::env::temp_dir().join(format!("camdrive {} {test} é", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("drive.bin"), resource.to_bytes().unwrap()).unwrap();
        Folder(folder)
    }

    fn uri(&self) -> CString {
        let path = self.0.to_str().unwrap().replace(' ', "%20").replace('é', "%C3%A9");
        CString::new(format!("file://{path}")).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

type Log = Mutex<Vec<(fmi2Status, String, String)>>;

/// Stable Rust cannot define a variadic function; with the one variadic argument that the library passes, a plain
/// one with six pointer-sized arguments is called alike on the platforms that the tests run on.
unsafe extern "C" fn log(
    environment: fmi2ComponentEnvironment,
    name: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    format: fmi2String,
    text: *const c_char,
) {
    let owned = |text| unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned();
    assert_eq!(owned(format), owned(text));
    assert_eq!(owned(name), "path/to the instance");
    let log = unsafe { &*environment.cast_const().cast::<Log>() };
    log.lock().unwrap().push((status, owned(category), owned(text)));
}

fn callbacks(log_to: &Log) -> fmi2CallbackFunctions {
    type Plain =
        unsafe extern "C" fn(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, fmi2String);
    fmi2CallbackFunctions {
        logger: Some(unsafe { std::mem::transmute::<Plain, fmi2CallbackLogger>(log) }),
        allocateMemory: None,
        freeMemory: None,
        stepFinished: None,
        componentEnvironment: (&raw const *log_to).cast_mut().cast(),
    }
}

/// Instantiates with strings and callbacks that are overwritten and freed after the call.
fn instantiate(location: Option<&CStr>, guid: &CStr, kind: fmi2Type, log: &Log) -> fmi2Component {
    let name = CString::new("path/to the instance").unwrap();
    let mut functions = Box::new(callbacks(log));
    let location = location.map_or(null(), CStr::as_ptr);
    let c = unsafe { fmi2Instantiate(name.as_ptr(), kind, guid.as_ptr(), location, &*functions, FALSE, FALSE) };
    functions.logger = None;
    functions.componentEnvironment = null_mut();
    c
}

/// An instance at the communication point 0.
fn started(folder: &Folder, log: &Log) -> fmi2Component {
    let c = instantiate(Some(&folder.uri()), GUID, CO_SIMULATION, log);
    assert!(!c.is_null(), "{:?}", log.lock().unwrap());
    unsafe {
        assert_eq!(fmi2SetupExperiment(c, FALSE, 0.0, 0.0, FALSE, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2ExitInitializationMode(c), OK, "{:?}", log.lock().unwrap());
    }
    c
}

/// Ten steps of 10 ms with accelerated shaft; the bits of y at their ends.
fn drive(c: fmi2Component, from: usize) -> Vec<u64> {
    let (inputs, y) = ([0, 1, 2], reference("y"));
    (from..from + 10)
        .map(|i| unsafe {
            let t = i as f64 * 0.01;
            assert_eq!(fmi2SetReal(c, inputs.as_ptr(), 3, [10.0 * t * t, 20.0 * t, 20.0].as_ptr()), OK);
            assert_eq!(fmi2DoStep(c, t, 0.01, TRUE), OK);
            let mut value = f64::NAN;
            assert_eq!(fmi2GetReal(c, &y, 1, &mut value), OK);
            value.to_bits()
        })
        .collect()
}

#[test]
fn instantiation_checks_what_it_gets() {
    let folder = Folder::new("instantiation");
    let log = Log::default();
    let refused = |location: Option<&CStr>, guid, kind, reason: &str| {
        assert!(instantiate(location, guid, kind, &log).is_null());
        let mut log = log.lock().unwrap();
        assert_eq!(log.len(), 1, "{log:?}");
        let (status, category, text) = log.remove(0);
        assert_eq!((status, category.as_str()), (ERROR, "logStatusError"));
        assert!(text.starts_with("fmi2Instantiate: ") && text.contains(reason), "{text}");
    };
    let uri = folder.uri();
    refused(Some(&uri), c"{other}", CO_SIMULATION, "`{other}`, but this FMU has the guid `{0f5e}`");
    refused(Some(&uri), GUID, 0, "for Co-Simulation");
    refused(Some(c"file:///no/where"), GUID, CO_SIMULATION, "drive.bin is missing");
    refused(Some(c""), GUID, CO_SIMULATION, "looked in");
    refused(None, GUID, CO_SIMULATION, "fmuResourceLocation is NULL");
    std::fs::write(folder.0.join("drive.bin"), "{").unwrap();
    refused(Some(&uri), GUID, CO_SIMULATION, "cannot be read");

    let name = c"path/to the instance".as_ptr();
    let functions = callbacks(&log);
    unsafe {
        assert!(fmi2Instantiate(name, 1, GUID.as_ptr(), uri.as_ptr(), null(), FALSE, FALSE).is_null());
        let silent = fmi2CallbackFunctions { logger: None, ..functions };
        assert!(fmi2Instantiate(name, 1, GUID.as_ptr(), uri.as_ptr(), &silent, FALSE, FALSE).is_null());
        assert!(fmi2Instantiate(name, 1, null(), uri.as_ptr(), &functions, FALSE, FALSE).is_null());
        assert_eq!(log.lock().unwrap().pop().unwrap().2, "fmi2Instantiate: `fmuGUID` is NULL");
        assert_eq!(CStr::from_ptr(fmi2GetTypesPlatform()), c"default");
        assert_eq!(CStr::from_ptr(fmi2GetVersion()), c"2.0");
        fmi2FreeInstance(null_mut());
    }
}

#[test]
fn null_pointers_are_refused() {
    let folder = Folder::new("null");
    let log = Log::default();
    let c = started(&folder, &log);
    let r: fmi2ValueReference = 0;
    let (mut real, mut state, mut size) = (0.0, null_mut(), 0_usize);
    let (real, state, size) = (&raw mut real, &raw mut state, &raw mut size);
    let one: fmi2Integer = 1;
    unsafe {
        type Call<'a> = &'a dyn Fn(fmi2Component) -> fmi2Status;
        let calls: &[(&str, Call)] = &[
            ("`vr`", &|c| fmi2GetReal(c, null(), 1, real)),
            ("`value`", &|c| fmi2GetReal(c, &r, 1, null_mut())),
            ("`value`", &|c| fmi2SetReal(c, &r, 1, null())),
            ("`vr`", &|c| fmi2GetInteger(c, null(), 1, null_mut())),
            ("`vr`", &|c| fmi2SetInteger(c, null(), 1, null())),
            ("`vr`", &|c| fmi2GetBoolean(c, null(), 1, null_mut())),
            ("`vr`", &|c| fmi2SetBoolean(c, null(), 1, null())),
            ("`vr`", &|c| fmi2GetString(c, null(), 1, null_mut())),
            ("`vr`", &|c| fmi2SetString(c, null(), 1, null())),
            ("`categories`", &|c| fmi2SetDebugLogging(c, TRUE, 1, null())),
            ("category is NULL", &|c| fmi2SetDebugLogging(c, TRUE, 1, &null())),
            ("`FMUstate`", &|c| fmi2GetFMUstate(c, null_mut())),
            ("`FMUstate`", &|c| fmi2SetFMUstate(c, null_mut())),
            ("`FMUstate`", &|c| fmi2SerializedFMUstateSize(c, null_mut(), size)),
            ("`FMUstate`", &|c| fmi2SerializeFMUstate(c, null_mut(), null_mut(), 0)),
            ("`serializedState`", &|c| fmi2DeSerializeFMUstate(c, null(), 9, state)),
            ("cut off", &|c| fmi2DeSerializeFMUstate(c, null(), 0, state)),
            ("`vKnown_ref`", &|c| fmi2GetDirectionalDerivative(c, &r, 1, null(), 1, &1.0, real)),
            ("`order`", &|c| fmi2SetRealInputDerivatives(c, &r, 1, null(), &1.0)),
            ("`value`", &|c| fmi2GetRealOutputDerivatives(c, &r, 1, &one, null_mut())),
            ("`value`", &|c| fmi2GetRealStatus(c, LAST_SUCCESSFUL_TIME, null_mut())),
            ("`vr` is not an array", &|c| fmi2GetReal(c, &r, usize::MAX, real)),
            ("`vr` is not an array", &|c| fmi2GetReal(c, (&raw const r).byte_add(1), 2, real)),
            ("status kind 9", &|c| fmi2GetRealStatus(c, 9, real)),
            ("Model Exchange", &|c| fmi2GetDerivatives(c, null_mut(), 3)),
            ("none is in progress", &|c| fmi2CancelStep(c)),
        ];
        for (reason, call) in calls {
            log.lock().unwrap().clear();
            assert_eq!(call(null_mut()), ERROR);
            assert_eq!(call(c.byte_add(1)), ERROR);
            assert!(log.lock().unwrap().is_empty());
            assert_eq!(call(c), ERROR, "{reason}");
            let log = log.lock().unwrap();
            assert!(log.len() == 1 && log[0].2.contains(*reason), "{log:?} {reason}");
        }
        assert_eq!(fmi2GetReal(c, null(), 0, null_mut()), OK);
        assert_eq!(fmi2SetString(c, null(), 0, null()), OK);
        assert_eq!(fmi2FreeFMUstate(c, null_mut()), OK);
        assert_eq!(fmi2FreeFMUstate(c, &mut null_mut()), OK);
        drive(c, 0);
        fmi2FreeInstance(c);
    }
}

/// One Real is read on a short way, several on a long one; both know the same rules.
#[test]
fn a_single_real_is_read_by_the_same_rules_as_several() {
    let folder = Folder::new("single");
    let log = Log::default();
    let c = instantiate(Some(&folder.uri()), GUID, CO_SIMULATION, &log);
    let (phi, m, y, mode) = (0, reference("m"), reference("y"), reference("start.mode"));
    let read = |vr: fmi2ValueReference| unsafe {
        let (mut one, mut two) = (f64::NAN, [f64::NAN; 2]);
        let status = fmi2GetReal(c, &vr, 1, &mut one);
        assert_eq!(fmi2GetReal(c, [vr, vr].as_ptr(), 2, two.as_mut_ptr()), status);
        assert_eq!([one.to_bits(); 2], two.map(f64::to_bits));
        (status, one)
    };
    unsafe {
        for _ in 0..2 {
            for vr in [phi, m, y] {
                assert_eq!(read(vr).0, ERROR, "before initialisation");
            }
            assert_eq!(fmi2SetReal(c, &phi, 1, &0.5), OK);
            assert_eq!(read(phi).0, ERROR);
            assert_eq!(fmi2SetupExperiment(c, FALSE, 0.0, 0.0, FALSE, 0.0), OK);
            assert_eq!(fmi2EnterInitializationMode(c), OK);
            assert_eq!((read(phi), read(m)), ((OK, 0.5), (OK, 2.0)));
            let lift = read(y).1;
            assert_eq!(fmi2SetReal(c, &phi, 1, &0.6), OK);
            assert!(read(y).0 == OK && read(y).1 != lift, "what was set is taken up");
            assert_eq!(fmi2ExitInitializationMode(c), OK);
            assert_eq!(fmi2DoStep(c, 0.0, 1e-3, TRUE), OK);
            assert_eq!(read(y).0, OK);
            for vr in [mode, 9999, fmi2ValueReference::MAX] {
                assert_eq!(read(vr).0, ERROR, "no Real");
            }
            assert_eq!(fmi2Terminate(c), OK);
            assert_eq!(read(y).0, OK);
            assert_eq!(fmi2DoStep(c, 1e-3, 1e-3, TRUE), ERROR);
            assert_eq!(fmi2Reset(c), OK);
        }
        fmi2FreeInstance(c);
    }
}

#[test]
fn statuses_that_do_not_exist_are_discarded() {
    let folder = Folder::new("status");
    let log = Log::default();
    let c = started(&folder, &log);
    let (mut status, mut real, mut integer, mut boolean, mut string) = (0, f64::NAN, 0, 7, null());
    unsafe {
        assert_eq!(fmi2DoStep(c, 0.0, 0.25, TRUE), OK);
        assert_eq!(fmi2GetStatus(c, DO_STEP_STATUS, &mut status), DISCARD);
        assert_eq!(fmi2GetStringStatus(c, PENDING_STATUS, &mut string), DISCARD);
        assert_eq!(fmi2GetIntegerStatus(c, LAST_SUCCESSFUL_TIME, &mut integer), DISCARD);
        assert_eq!(fmi2GetRealStatus(c, PENDING_STATUS, &mut real), DISCARD);
        assert_eq!(fmi2GetRealStatus(c, LAST_SUCCESSFUL_TIME, &mut real), OK);
        assert_eq!(fmi2GetBooleanStatus(c, TERMINATED, &mut boolean), OK);
        assert_eq!((real, boolean), (0.25, FALSE));
        fmi2FreeInstance(c);
    }
}

#[test]
fn states_are_restored_reused_freed_and_told_apart() {
    let folder = Folder::new("states");
    let log = Log::default();
    let (a, b) = (started(&folder, &log), started(&folder, &log));
    unsafe {
        drive(a, 0);
        let mut state = null_mut();
        assert_eq!(fmi2GetFMUstate(a, &mut state), OK);
        let expected = drive(a, 10);
        assert_eq!(fmi2SetFMUstate(a, state), OK);
        assert_eq!(drive(a, 10), expected);
        assert_eq!(fmi2SetFMUstate(b, state), OK, "another instance of the same FMU");
        assert_eq!(drive(b, 10), expected);

        let mut size = 0;
        assert_eq!(fmi2SerializedFMUstateSize(a, state, &mut size), OK);
        let mut bytes = vec![0 as c_char; size];
        assert_eq!(fmi2SerializeFMUstate(a, state, bytes.as_mut_ptr(), size - 1), ERROR);
        assert_eq!(fmi2SerializeFMUstate(a, state, bytes.as_mut_ptr(), size), OK);
        assert_eq!(fmi2Reset(b), OK);
        let mut copy = null_mut();
        assert_eq!(fmi2DeSerializeFMUstate(b, bytes.as_ptr(), size, &mut copy), OK);
        assert_eq!(fmi2SetFMUstate(b, copy), OK);
        assert_eq!(drive(b, 10), expected);
        bytes[size / 2] ^= 1;
        assert_eq!(fmi2DeSerializeFMUstate(b, bytes.as_ptr(), size, &mut copy), ERROR);

        let before = state;
        assert_eq!(fmi2GetFMUstate(a, &mut state), OK);
        assert_eq!(state, before, "the memory is used again");
        let after = drive(a, 20);
        assert_eq!(fmi2SetFMUstate(a, state), OK);
        assert_eq!(drive(a, 20), after);

        let mut no_state = [0_u64; 16];
        assert_eq!(fmi2SetFMUstate(a, no_state.as_mut_ptr().cast::<c_void>()), ERROR);
        assert_eq!(fmi2SetFMUstate(a, a), ERROR, "an instance is no state");
        assert_eq!(fmi2FreeFMUstate(a, &mut state), OK);
        assert!(state.is_null());
        assert_eq!(fmi2FreeFMUstate(a, &mut state), OK);
        assert_eq!(fmi2FreeFMUstate(a, &mut copy), OK);
        fmi2FreeInstance(a);
        fmi2FreeInstance(b);
    }
}

#[test]
fn instances_in_threads_do_not_know_of_each_other() {
    let folder = Folder::new("threads");
    let expected = {
        let log = Log::default();
        let c = started(&folder, &log);
        let expected = drive(c, 0);
        unsafe { fmi2FreeInstance(c) };
        expected
    };
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                let log = Log::default();
                let (a, b) = (started(&folder, &log), started(&folder, &log));
                for _ in 0..5 {
                    assert_eq!(drive(a, 0), expected);
                    assert_eq!(drive(b, 0), expected);
                    for c in [a, b] {
                        unsafe {
                            assert_eq!(fmi2Reset(c), OK);
                            assert_eq!(fmi2EnterInitializationMode(c), OK);
                            assert_eq!(fmi2ExitInitializationMode(c), OK);
                        }
                    }
                }
                unsafe {
                    fmi2FreeInstance(a);
                    fmi2FreeInstance(b);
                }
                assert!(log.lock().unwrap().is_empty());
            });
        }
    });
}

#[test]
fn a_path_will_do_as_resource_location() {
    let folder = Folder::new("path");
    let log = Log::default();
    let path: &Path = &folder.0;
    let path = CString::new(path.to_str().unwrap()).unwrap();
    let c = instantiate(Some(&path), GUID, CO_SIMULATION, &log);
    assert!(!c.is_null());
    unsafe { fmi2FreeInstance(c) };
}

/// The resource of a scene.
fn resource_of(scene: &str) -> Resource {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(scene);
    let scene = camdrive_cli::scene::read(&scene).unwrap_or_else(|faults| panic!("{faults}"));
    Resource { guid: GUID.to_str().unwrap().to_owned(), ..scene.resource() }
}

/// An instance in Initialization Mode.
fn initialising(folder: &Folder, log: &Log) -> fmi2Component {
    let c = instantiate(Some(&folder.uri()), GUID, CO_SIMULATION, log);
    unsafe {
        assert_eq!(fmi2SetupExperiment(c, FALSE, 0.0, 0.0, FALSE, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
    }
    c
}

fn derivatives(c: fmi2Component, unknowns: &[u32], knowns: &[u32], direction: &[f64]) -> (fmi2Status, Vec<f64>) {
    let mut values = vec![f64::NAN; unknowns.len()];
    let (unknown, known) = (unknowns.as_ptr(), knowns.as_ptr());
    let (dv, result) = (direction.as_ptr(), values.as_mut_ptr());
    let status = unsafe { fmi2GetDirectionalDerivative(c, unknown, unknowns.len(), known, knowns.len(), dv, result) };
    (status, values)
}

fn ask(c: fmi2Component, unknowns: &[u32], knowns: &[u32], direction: &[f64]) -> Vec<f64> {
    let (status, values) = derivatives(c, unknowns, knowns, direction);
    assert_eq!(status, OK);
    values
}

/// A start of this machine takes a sixtieth of the work of a call, and there are 179 knowns.
#[test]
fn a_derivative_before_the_start_is_the_same_whenever_it_is_asked_for() {
    let resource = resource_of("examples/sealing_machine/scene.toml");
    let folder = Folder::of("derivative", &resource);
    let log = Log::default();
    let drive = resource.build().unwrap();
    let reference = |name: &str| drive.descriptions().iter().position(|d| d.name == name).unwrap() as u32;
    let unknowns = ["E", "w", "a", "der(U[1],2)", "phi", "lever[2]"].map(reference);
    // Each column takes its own starts, a fifth of the work of a call; of this machine those of some fit into one.
    let knowns = ["J0", "follower[2].cam.a[2]", "follower[1].linkage[1].ground"].map(reference);
    let (first, second) = (initialising(&folder, &log), initialising(&folder, &log));
    let direction = [0.7, 1e-3, 1e-2];
    let together = ask(first, &unknowns, &knowns, &direction);
    assert_eq!(together, ask(first, &unknowns, &knowns, &direction), "asked again");
    // Another instance answers other questions before.
    let mut sums = vec![0.0; unknowns.len()];
    for (known, component) in knowns.iter().zip(direction) {
        let column = ask(second, &unknowns, &[*known], &[component]);
        sums.iter_mut().zip(column).for_each(|(sum, slope)| *sum += slope);
    }
    assert_eq!(together, sums, "no column depends on the others");
    assert_eq!(together, ask(second, &unknowns, &knowns, &direction), "asked after others");
    assert_eq!(together[1..2], ask(first, &unknowns[1..2], &knowns, &direction), "one of them");
    let all: Vec<u32> = (0..drive.descriptions().len() as u32)
        .filter(|i| {
            let d = &drive.descriptions()[*i as usize];
            matches!(d.causality, Causality::Input | Causality::Parameter) && matches!(d.kind, Kind::Real { .. })
        })
        .filter(|i| !drive.descriptions()[*i as usize].name.starts_with("solver."))
        .collect();
    assert!(all.len() > 170);
    let (status, _) = derivatives(first, &unknowns, &all, &vec![1e-3; all.len()]);
    assert_eq!(status, ERROR);
    assert!(log.lock().unwrap().last().unwrap().2.contains("ask for one known at a time"));
    unsafe {
        fmi2FreeInstance(first);
        fmi2FreeInstance(second);
    }
}

/// Two parameters at opposite ends of their ranges, seen along the direction, have no step in common.
#[test]
fn a_derivative_along_several_knowns_is_the_sum_of_its_parts() {
    let resource = resource_of("tests/fmpy/scenes/backlash_input.toml");
    let folder = Folder::of("bounds", &resource);
    let log = Log::default();
    let drive = resource.build().unwrap();
    let reference = |name: &str| drive.descriptions().iter().position(|d| d.name == name).unwrap() as u32;
    let (unknowns, knowns) = (["q", "force", "der(q)"].map(reference), ["b", "e", "c"].map(reference));
    let third = initialising(&folder, &log);
    for direction in [[-2.0, 0.5, 3.0], [2.0, -0.5, 3.0]] {
        let together = ask(third, &unknowns, &knowns, &direction);
        for (i, unknown) in unknowns.iter().enumerate() {
            let single = |(known, component): (&u32, f64)| ask(third, &[*unknown], &[*known], &[component])[0];
            let parts: Vec<f64> = knowns.iter().zip(direction).map(single).collect();
            let size: f64 = parts.iter().map(|part| part.abs()).sum();
            assert!((together[i] - parts.iter().sum::<f64>()).abs() <= 1e-7 * size, "{i}: {together:?} {parts:?}");
        }
    }
    // A known that is named twice counts twice.
    let twice = ask(third, &unknowns[..1], &[knowns[0], knowns[1], knowns[0]], &[0.25, 0.0, 0.5]);
    let once = ask(third, &unknowns[..1], &knowns[..1], &[0.75]);
    assert!((twice[0] - once[0]).abs() <= 1e-9 * once[0].abs(), "{twice:?} {once:?}");
    unsafe { fmi2FreeInstance(third) };
}
