//! What an instance takes: no memory in a step or when it is read, whatever the drive, its mode and what happens
//! inside the step; little memory beyond what the instances of one FMU share; and little of the stack.

use camdrive::drives::Description;
use camdrive::drives::variable::{Causality, Kind, Variability};
use camdrive::fmi2::abi::*;
use camdrive::fmi2::functions::*;
use camdrive_cli::scene::{self, Resolved};
use camdrive_design::host;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::ffi::{CStr, CString, c_void};
use std::path::{Path, PathBuf};
use std::ptr::null_mut;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The folder of the workspace.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// The system's allocator, which counts what each thread asks of it: other threads of the test program do not disturb.
struct Counting;

thread_local! {
    /// Calls that allocate, grow or free, and bytes in use.
    static COUNT: Cell<(usize, isize)> = const { Cell::new((0, 0)) };
}

fn count(change: isize) {
    // A thread that ends has no count any more.
    let _ = COUNT.try_with(|count| {
        let (calls, bytes) = count.get();
        count.set((calls + 1, bytes + change));
    });
}

// SAFETY: all is passed on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(size as isize - layout.size() as isize);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What `action` gives, how often it called the allocator and how many bytes more are in use after it.
fn counted<T>(action: impl FnOnce() -> T) -> (T, usize, isize) {
    let before = COUNT.get();
    let result = action();
    let after = COUNT.get();
    (result, after.0 - before.0, after.1 - before.1)
}

/// One test at a time: the library's list of FMUs in use belongs to all threads.
static ALONE: Mutex<()> = Mutex::new(());

fn alone() -> MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The scenes of all models and modes, of the examples, of the benchmark and of the tests with fmpy.
fn scenes() -> Vec<PathBuf> {
    let root = root();
    let mut folders = vec![root.join("modelDescription"), root.join("benches/works"), root.join("tests/fmpy/scenes")];
    folders.extend(std::fs::read_dir(root.join("examples")).unwrap().map(|entry| entry.unwrap().path()));
    let files = folders.iter().filter(|f| f.is_dir()).flat_map(|f| std::fs::read_dir(f).unwrap());
    let mut paths: Vec<PathBuf> = files.map(|entry| entry.unwrap().path()).collect();
    // A task.toml is a motion task, a study.toml a study, a system.toml a system: no scenes.
    let named = |path: &PathBuf| ["task.toml", "study.toml", "system.toml"].iter().any(|name| path.ends_with(name));
    paths.retain(|path| path.extension().is_some_and(|e| e == "toml") && !named(path));
    paths.sort();
    assert!(paths.len() > 8);
    paths
}

/// An FMU as an importer has unpacked it.
struct Fmu {
    scene: Resolved,
    folder: PathBuf,
    guid: CString,
    variables: Vec<Description>,
    /// The communication step of the default experiment (s).
    step: f64,
}

impl Fmu {
    fn of(path: &Path, test: &str) -> Self {
        let scene = scene::read(path).unwrap_or_else(|faults| panic!("{faults}"));
        let resource = scene.resource();
        let drive = resource.build().unwrap();
        let folder = std::env::temp_dir().join(format!("camdrive-{}-{test}-{}", std::process::id(), scene.name));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("drive.bin"), resource.to_bytes().unwrap()).unwrap();
        let guid = CString::new(resource.guid).unwrap();
        let variables = drive.descriptions().to_vec();
        Fmu { scene, folder, guid, variables, step: drive.experiment().step }
    }

    /// References of the variables that `choice` likes.
    fn references(&self, choice: impl Fn(&Description) -> bool) -> Vec<u32> {
        (0..).zip(&self.variables).filter(|(_, d)| choice(d)).map(|(i, _)| i).collect()
    }

    fn instance(&self, logging: bool) -> fmi2Component {
        let location = CString::new(self.folder.to_str().unwrap()).unwrap();
        let callbacks = fmi2CallbackFunctions {
            // SAFETY: see `log`.
            logger: Some(unsafe { std::mem::transmute::<*const (), fmi2CallbackLogger>(log as *const ()) }),
            allocateMemory: None,
            freeMemory: None,
            stepFinished: None,
            componentEnvironment: null_mut(),
        };
        let logging = if logging { TRUE } else { FALSE };
        let (name, guid) = (c"an instance".as_ptr(), self.guid.as_ptr());
        let c = unsafe { fmi2Instantiate(name, CO_SIMULATION, guid, location.as_ptr(), &callbacks, FALSE, logging) };
        assert!(!c.is_null());
        c
    }
}

impl Drop for Fmu {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

thread_local! {
    /// How many events were logged.
    static EVENTS: Cell<usize> = const { Cell::new(0) };
}

/// As in `c_interface.rs`: a variadic function cannot be defined, one with six arguments is called alike.
unsafe extern "C" fn log(
    _: fmi2ComponentEnvironment,
    _: fmi2String,
    status: fmi2Status,
    category: fmi2String,
    _: fmi2String,
    text: fmi2String,
) {
    let (category, text) = unsafe { (CStr::from_ptr(category), CStr::from_ptr(text)) };
    assert_ne!(status, ERROR, "{text:?}");
    if category == c"logEvents" {
        EVENTS.set(EVENTS.get() + 1);
    }
}

/// Ends initialisation at t = 0, with this choice of the solver's method where there is one.
fn start(fmu: &Fmu, c: fmi2Component, method: i32) {
    unsafe {
        for vr in fmu.references(|d| d.name == "solver.method") {
            assert_eq!(fmi2SetInteger(c, &vr, 1, &method), OK);
        }
        assert_eq!(fmi2SetupExperiment(c, FALSE, 0.0, 0.0, FALSE, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
    }
}

/// The methods of a drive's solver.
fn methods(fmu: &Fmu) -> i32 {
    fmu.variables.iter().find(|d| d.name == "solver.method").map_or(1, |d| match &d.kind {
        Kind::Enumeration(e) => e.items.len() as i32,
        _ => 1,
    })
}

/// What a host does between two communication points: set all inputs with a derivative, step, read all Reals one by
/// one and together.
struct Host {
    c: fmi2Component,
    inputs: Vec<(u32, String)>,
    reals: Vec<u32>,
    values: Vec<f64>,
    time: f64,
}

impl Host {
    fn new(fmu: &Fmu, c: fmi2Component) -> Self {
        let inputs = fmu.references(|d| d.causality == Causality::Input);
        let inputs = inputs.into_iter().map(|vr| (vr, fmu.variables[vr as usize].name.clone())).collect();
        let reals = fmu.references(|d| matches!(d.kind, Kind::Real { .. }));
        Host { c, inputs, values: vec![0.0; reals.len()], reals, time: 0.0 }
    }

    /// The motion accelerates and is no continuation of the step before, the torque changes its sign: inputs jump,
    /// contacts open and close. True where all went well.
    fn step(&mut self, size: f64) -> bool {
        let (c, t) = (self.c, self.time);
        let mut good = true;
        unsafe {
            for (vr, name) in &self.inputs {
                let value = match name.as_str() {
                    "phi" => 20.0 * t + (300.0 * t).sin() * 1e-3,
                    "w" => 20.0 + 3.0 * t,
                    "a" => 3.0,
                    _ => (40.0 * t).sin(),
                };
                good &= fmi2SetReal(c, vr, 1, &value) == OK;
                good &= fmi2SetRealInputDerivatives(c, vr, 1, &1, &0.1) == OK;
            }
            good &= fmi2DoStep(c, t, size, TRUE) == OK;
            self.time += size;
            for (vr, value) in self.reals.iter().zip(&mut self.values) {
                good &= fmi2GetReal(c, vr, 1, value) == OK;
            }
            good &= fmi2GetReal(c, self.reals.as_ptr(), self.reals.len(), self.values.as_mut_ptr()) == OK;
        }
        good
    }
}

/// Short, usual and long steps, in units of that of the default experiment.
const STEPS: [f64; 3] = [1e-3, 1.0, 37.0];

#[test]
fn a_step_does_not_allocate() {
    let _alone = alone();
    for path in scenes() {
        let fmu = Fmu::of(&path, "step");
        for (method, logging) in (1..=methods(&fmu)).flat_map(|method| [(method, true), (method, false)]) {
            let c = fmu.instance(logging);
            start(&fmu, c, method);
            let mut host = Host::new(&fmu, c);
            let events = EVENTS.get();
            for size in STEPS.map(|factor| factor * fmu.step) {
                for _ in 0..40 {
                    let (good, calls, _) = counted(|| host.step(size));
                    assert!(good, "{}: a call fails before t = {} s", path.display(), host.time);
                    assert_eq!(calls, 0, "{} before t = {} s", path.display(), host.time);
                }
            }
            // The drive with backlash is here for its events.
            let told = EVENTS.get() - events;
            assert!(if logging { 0 < told || !fmu.scene.scene.model().starts_with("Backlash") } else { told == 0 });
            unsafe { fmi2FreeInstance(c) };
        }
    }
}

/// What an instance takes beyond what all of its FMU share, the values of its communication point among it: less than a page
/// of memory (bytes).
const LARGEST_INSTANCE: isize = 4096;

/// The same of a train: each operation of its equations has a power series of up to 25 terms, some of them twice (bytes).
const LARGEST_TRAIN: isize = 64 << 10;

#[test]
fn a_further_instance_takes_little_memory() {
    let _alone = alone();
    let mut excess = String::new();
    for path in scenes() {
        let fmu = Fmu::of(&path, "memory");
        let ready = || {
            let c = fmu.instance(false);
            start(&fmu, c, 1);
            assert!(Host::new(&fmu, c).step(fmu.step));
            c
        };
        let (first, _, alone) = counted(ready);
        let (second, _, further) = counted(ready);
        println!("{}: the first instance {alone} bytes, a further one {further} bytes", fmu.scene.name);
        let (_, _, freed) = counted(|| unsafe {
            fmi2FreeInstance(first);
            fmi2FreeInstance(second);
        });
        assert_eq!(alone + further + freed, 0, "{}: a leak", path.display());
        let most = if fmu.scene.scene.model() == "DriveTrain" { LARGEST_TRAIN } else { LARGEST_INSTANCE };
        if most < further {
            excess += &format!("{}: {further} bytes\n", path.display());
        }
    }
    assert!(excess.is_empty(), "{excess}");
}

/// A process under strict seccomp is killed at the first system call other than read, write and the end of its thread.
/// One that forks has a single thread, and nothing but the steps is done in it.
#[cfg(target_os = "linux")]
#[test]
fn no_step_calls_the_system() {
    use std::io::Read;
    use std::os::fd::AsRawFd;
    unsafe extern "C" {
        fn fork() -> i32;
        fn waitpid(process: i32, status: *mut i32, options: i32) -> i32;
        fn prctl(option: i32, ...) -> i32;
        fn write(file: i32, text: *const c_void, length: usize) -> isize;
        fn getppid() -> i32;
        fn _exit(code: i32) -> !;
    }
    let _alone = alone();
    const PR_SET_SECCOMP: i32 = 22;
    const SECCOMP_MODE_STRICT: std::ffi::c_ulong = 1;
    const WITHOUT_SECCOMP: i32 = 77;
    const SIGKILL: i32 = 9;

    for path in scenes() {
        let fmu = Fmu::of(&path, "cell");
        for method in 1..=methods(&fmu) {
            let c = fmu.instance(false);
            start(&fmu, c, method);
            let mut host = Host::new(&fmu, c);
            let (mut answers, answer) = std::io::pipe().unwrap();
            // SAFETY: the child neither allocates nor takes a lock; see `a_step_does_not_allocate`.
            let child = unsafe { fork() };
            if child == 0 {
                unsafe {
                    if prctl(PR_SET_SECCOMP, SECCOMP_MODE_STRICT) != 0 {
                        _exit(WITHOUT_SECCOMP);
                    }
                    let sizes = STEPS.iter().map(|factor| factor * fmu.step);
                    let good = sizes.flat_map(|size| [size; 40]).all(|size| host.step(size));
                    write(answer.as_raw_fd(), if good { c"good" } else { c"poor" }.as_ptr().cast(), 4);
                    // The end that shows that the cell was locked.
                    getppid();
                    _exit(0);
                }
            }
            drop(answer);
            let (mut told, mut status) = (String::new(), 0);
            answers.read_to_string(&mut told).unwrap();
            unsafe {
                assert_eq!(waitpid(child, &mut status, 0), child);
                fmi2FreeInstance(c);
            }
            if status >> 8 == WITHOUT_SECCOMP {
                eprintln!("not tested: this kernel has no strict seccomp");
                return;
            }
            let which = format!("{}, method {method}", path.display());
            assert_eq!(told, "good", "{which}: a system call in a step, status {status}");
            assert_eq!(status & 0x7f, SIGKILL, "{which}: the system call after the steps went through");
        }
    }
}

/// What a call of the FMU takes of the stack of the thread that makes it (bytes): hosts give their threads little.
const DEEPEST_CALL: usize = 32 << 10;

/// The same of a train, whose sixteen followers have places on it: half of what threads of musl have (bytes).
#[cfg(target_os = "linux")]
const DEEPEST_OF_TRAIN: usize = 64 << 10;

/// How deep the stack gets below `action` (bytes).
#[cfg(target_os = "linux")]
fn depth(action: impl FnOnce()) -> usize {
    unsafe extern "C" {
        fn pthread_attr_init(attributes: *mut Attributes) -> i32;
        fn pthread_attr_setstack(attributes: *mut Attributes, lowest: *mut c_void, size: usize) -> i32;
        fn pthread_attr_destroy(attributes: *mut Attributes) -> i32;
        fn pthread_create(
            thread: *mut std::ffi::c_ulong,
            attributes: *const Attributes,
            start: unsafe extern "C" fn(*mut c_void) -> *mut c_void,
            argument: *mut c_void,
        ) -> i32;
        fn pthread_join(thread: std::ffi::c_ulong, result: *mut *mut c_void) -> i32;
    }
    /// As large as that of any architecture of glibc and musl.
    #[repr(C, align(16))]
    struct Attributes([u8; 64]);
    unsafe extern "C" fn run<F: FnOnce()>(action: *mut c_void) -> *mut c_void {
        // SAFETY: `used` passes the address of an option that lives until the thread has ended.
        let action = unsafe { (*action.cast::<Option<F>>()).take() };
        let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| action.unwrap()()));
        if outcome.is_ok() { null_mut() } else { std::ptr::dangling_mut() }
    }
    /// Bytes of a painted stack that are touched.
    fn used<F: FnOnce()>(action: F) -> usize {
        const PAINT: u64 = 0xc0ff_ee00_c0ff_ee00;
        const WORDS: usize = 1 << 17;
        let mut stack = vec![PAINT; WORDS];
        let lowest = stack.as_mut_ptr();
        let (mut action, mut thread, mut outcome) = (Some(action), 0, null_mut());
        let mut attributes = Attributes([0; 64]);
        // SAFETY: memory for the stack and the argument live until the thread has been joined.
        unsafe {
            assert_eq!(pthread_attr_init(&mut attributes), 0);
            assert_eq!(pthread_attr_setstack(&mut attributes, lowest.cast(), 8 * WORDS), 0);
            assert_eq!(pthread_create(&mut thread, &attributes, run::<F>, (&raw mut action).cast()), 0);
            assert_eq!(pthread_join(thread, &mut outcome), 0);
            pthread_attr_destroy(&mut attributes);
        }
        assert!(outcome.is_null(), "the thread panicked");
        // SAFETY: within the memory of the stack, which nobody else uses any more.
        let untouched = (0..WORDS).take_while(|i| unsafe { lowest.add(*i).read_volatile() } == PAINT).count();
        8 * (WORDS - untouched)
    }
    // What a thread itself takes, its variables among it, is no matter of the call.
    used(action) - used(|| {})
}

/// Whether the scene has such a start.
#[cfg(target_os = "linux")]
fn starts(fmu: &Fmu, mode: i32) -> bool {
    let mut drive = fmu.scene.resource().build().unwrap();
    let of_mode = fmu.references(|d| d.name == "start.mode");
    of_mode.iter().all(|vr| drive.set(*vr as usize, f64::from(mode)).is_ok()) && drive.start().is_ok()
}

/// The call of an instance's life that takes most of the stack, and how much (bytes).
#[cfg(target_os = "linux")]
fn deepest_call(fmu: &Fmu, method: i32) -> (&'static str, usize) {
    let mut deepest = ("", 0);
    let mut call = |name, action: &mut dyn FnMut()| {
        let depth = depth(action);
        if deepest.1 < depth {
            deepest = (name, depth);
        }
    };
    let (mut c, mut state, mut copy) = (null_mut(), null_mut(), null_mut());
    let reals = fmu.references(|d| matches!(d.kind, Kind::Real { .. }));
    // The derivatives by these make the tables anew.
    let parameters = fmu.references(|d| {
        let is_real = matches!(d.kind, Kind::Real { .. });
        d.causality == Causality::Parameter && is_real && !d.name.starts_with("solver.")
    });
    let knowns = [parameters[0], parameters[parameters.len() - 1]];
    let unknowns = fmu.references(|d| d.causality == Causality::Output && d.variability == Variability::Continuous);
    let states = fmu.references(|d| d.state);
    let (mut values, mut bytes) = (vec![0.0; reals.len()], Vec::new());
    unsafe {
        call("fmi2Instantiate", &mut || c = fmu.instance(false));
        let mut host = Host::new(fmu, c);
        for vr in fmu.references(|d| d.name == "solver.method") {
            assert_eq!(fmi2SetInteger(c, &vr, 1, &method), OK);
        }
        for mode in (1..=3).rev().filter(|mode| starts(fmu, *mode)) {
            call("fmi2Reset", &mut || assert_eq!(fmi2Reset(c), OK));
            for vr in fmu.references(|d| d.name == "start.mode") {
                assert_eq!(fmi2SetInteger(c, &vr, 1, &mode), OK);
            }
            assert_eq!(fmi2SetupExperiment(c, FALSE, 0.0, 0.0, FALSE, 0.0), OK);
            assert_eq!(fmi2EnterInitializationMode(c), OK);
            call("fmi2GetReal before the start", &mut || {
                assert_eq!(fmi2GetReal(c, reals.as_ptr(), reals.len(), values.as_mut_ptr()), OK);
            });
        }
        call("fmi2GetDirectionalDerivative before the start", &mut || {
            let (unknown, known, dv) = (unknowns.as_ptr(), knowns.as_ptr(), [1.0; 2].as_ptr());
            assert_eq!(fmi2GetDirectionalDerivative(c, unknown, 1, known, 2, dv, values.as_mut_ptr()), OK);
        });
        call("fmi2ExitInitializationMode", &mut || assert_eq!(fmi2ExitInitializationMode(c), OK));
        call("fmi2GetFMUstate", &mut || assert_eq!(fmi2GetFMUstate(c, &mut state), OK));
        for size in STEPS.map(|factor| factor * fmu.step) {
            call("fmi2DoStep", &mut || assert!((0..40).all(|_| host.step(size))));
        }
        call("fmi2GetRealOutputDerivatives", &mut || {
            fmi2GetRealOutputDerivatives(c, unknowns.as_ptr(), 1, &2, values.as_mut_ptr());
        });
        call("fmi2GetDirectionalDerivative", &mut || {
            let (unknown, known) = (unknowns.as_ptr(), states.as_ptr());
            assert_eq!(fmi2GetDirectionalDerivative(c, unknown, 1, known, 1, &1.0, values.as_mut_ptr()), OK);
        });
        call("fmi2SerializeFMUstate", &mut || {
            let mut size = 0;
            assert_eq!(fmi2SerializedFMUstateSize(c, state, &mut size), OK);
            bytes.resize(size, 0);
            assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr().cast(), size), OK);
        });
        call("fmi2DeSerializeFMUstate", &mut || {
            assert_eq!(fmi2DeSerializeFMUstate(c, bytes.as_ptr().cast(), bytes.len(), &mut copy), OK);
        });
        call("fmi2SetFMUstate", &mut || assert_eq!(fmi2SetFMUstate(c, copy), OK));
        call("fmi2FreeFMUstate", &mut || {
            assert_eq!(fmi2FreeFMUstate(c, &mut state), OK);
            assert_eq!(fmi2FreeFMUstate(c, &mut copy), OK);
        });
        call("fmi2FreeInstance", &mut || fmi2FreeInstance(c));
    }
    deepest
}

#[cfg(target_os = "linux")]
#[test]
fn no_call_takes_more_of_the_stack_than_small_threads_have() {
    let _alone = alone();
    let mut excess = String::new();
    for path in scenes() {
        let fmu = Fmu::of(&path, "stack");
        for method in 1..=methods(&fmu) {
            let (name, depth) = deepest_call(&fmu, method);
            println!("{}, method {method}: {depth} bytes in {name}", fmu.scene.name);
            let most = if fmu.scene.scene.model() == "DriveTrain" { DEEPEST_OF_TRAIN } else { DEEPEST_CALL };
            if most < depth {
                excess += &format!("{}, method {method}: {depth} bytes in {name}\n", path.display());
            }
        }
    }
    assert!(excess.is_empty(), "{excess}");
}

#[test]
fn a_host_takes_no_memory_in_a_step() {
    let _alone = alone();
    let path = root().join("examples/guide_bar/run_up.toml");
    let resource = scene::read(&path).unwrap_or_else(|faults| panic!("{faults}")).resource();
    let mut host = host::Host::instantiate(&resource).unwrap();
    let reference = |name: &str| host.description().find(name).unwrap() as u32;
    let (inputs, outputs) = (["phi", "w", "a"].map(reference), ["y", "tau"].map(reference));
    host.set_up(0.0, None, None).unwrap();
    host.enter_initialization().unwrap();
    host.set_reals(&inputs, &[0.0, 30.0, 0.0]).unwrap();
    host.exit_initialization().unwrap();
    let mut values = [0.0; 2];
    let ((), calls, _) = counted(|| {
        for i in 0..100 {
            let time = f64::from(i) * 1e-3;
            host.set_reals(&inputs, &[30.0 * time, 30.0, 0.0]).unwrap();
            host.set_input_derivatives(&inputs[2..], &[1], &[0.0]).unwrap();
            host.do_step(time, 1e-3).unwrap();
            host.get_reals(&outputs, &mut values).unwrap();
            host.get_output_derivatives(&outputs, &[1, 1], &mut values).unwrap();
        }
    });
    assert_eq!(calls, 0);
}
