//! A foreign library in a process of its own: this program, started again.
//!
//! ```text
//! this process                           child
//! Remote ── Call ──▶ socket ──▶ serve ── Instance ──▶ library
//!        ◀─ Answer ─        ◀──
//! ```
//!
//! A message is its length (u32, little-endian) and the call or answer in postcard's encoding. The child answers once when its
//! library is loaded, then each call in turn. The socket is the child's standard input, which no library writes to; text that a
//! library prints goes to the standard error. Windows passes no sockets on, so the child connects to this process by TCP there,
//! and its standard input is a pipe that closes when this process ends.
//!
//! A round trip costs some 15 µs, so values are read together: the first reading at a point also asks for all values read at
//! the last point. A thread for each child ends it when a call takes longer than [`limit`].

use super::Instance;
use super::functions::end_group;
use camdrive::drives::{Fault, Number};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::io::{self, BufReader, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::{JoinHandle, park_timeout, sleep, spawn};
use std::time::{Duration, Instant as Clock};

#[cfg(windows)]
pub(super) use std::net::TcpStream as Stream;
#[cfg(unix)]
pub(super) use std::os::unix::net::UnixStream as Stream;

/// The first argument of the child; the others are its folder, the process that started it and, on Windows, its address.
pub(super) const MARK: &str = "--serve-library";

/// The interval at which a thread checks that the other process still lives.
pub(super) const LOOK: Duration = Duration::from_millis(100);

/// The time that a child may take to unload its library.
const UNLOADING: Duration = Duration::from_secs(2);

/// The longest time of a call of a foreign library unless the user sets another one (s): tools of an FMU take half a minute to
/// start.
pub const LIMIT: f64 = 60.0;

/// This program, if it serves.
pub(super) static PROGRAM: OnceLock<PathBuf> = OnceLock::new();

/// [`LIMIT`], or the user's choice (ms).
static LONGEST: AtomicU64 = AtomicU64::new((LIMIT * 1e3) as u64);

/// Sets the longest time of a call of a foreign library (s).
pub fn limit(time: f64) {
    LONGEST.store((time * 1e3).ceil() as u64, Relaxed);
}

/// True if foreign libraries run in processes of their own.
pub(super) fn isolates() -> bool {
    PROGRAM.get().is_some()
}

/// A request to an instance. `Instantiate` makes the child's.
#[derive(Debug, Deserialize, Serialize)]
pub(super) enum Call {
    Instantiate(String),
    SetUp(f64, Option<f64>, Option<f64>),
    EnterInitialization,
    ExitInitialization,
    Set(usize, f64),
    SetReals(Vec<u32>, Vec<f64>),
    SetInputDerivatives(Vec<u32>, Vec<i32>, Vec<f64>),
    Read(Vec<Read>),
    DoStep(f64, f64),
    Save,
    Restore,
    Terminate,
    Free,
}

/// Values that can be read at any time.
#[derive(Clone, Debug, Deserialize, Eq, Hash, PartialEq, Serialize)]
pub(super) enum Read {
    Variable(usize),
    Reals(Vec<u32>),
    Derivatives(Vec<u32>, Vec<i32>),
}

/// The result of a call or a reading.
pub(super) type Outcome = Result<Vec<f64>, Fault>;

/// The answer of a call; an answer of readings has as many outcomes.
#[derive(Debug, Default, Deserialize, Serialize)]
pub(super) struct Answer {
    pub outcomes: Vec<Outcome>,
    pub warnings: Vec<String>,
    pub has_ended: bool,
}

impl Answer {
    /// The first fault of its outcomes, if any.
    fn all(self) -> Result<(), Fault> {
        self.outcomes.into_iter().try_for_each(|outcome| outcome.map(drop))
    }
}

impl Call {
    /// The called function of the standard.
    fn function(&self) -> &'static str {
        match self {
            Call::Instantiate(_) => "fmi2Instantiate",
            Call::SetUp(..) => "fmi2SetupExperiment",
            Call::EnterInitialization => "fmi2EnterInitializationMode",
            Call::ExitInitialization => "fmi2ExitInitializationMode",
            Call::Set(..) => "setting a variable",
            Call::SetReals(..) => "fmi2SetReal",
            Call::SetInputDerivatives(..) => "fmi2SetRealInputDerivatives",
            Call::Read(_) => "reading variables",
            Call::DoStep(..) => "fmi2DoStep",
            Call::Save => "fmi2GetFMUstate",
            Call::Restore => "fmi2SetFMUstate",
            Call::Terminate => "fmi2Terminate",
            Call::Free => "fmi2FreeInstance",
        }
    }
}

/// Writes a message.
pub(super) fn send(stream: &mut BufReader<Stream>, message: &impl Serialize) -> io::Result<()> {
    // The length goes before it.
    let mut bytes = postcard::to_extend(message, vec![0; 4]).map_err(io::Error::other)?;
    let length = u32::try_from(bytes.len() - 4).map_err(io::Error::other)?;
    bytes[..4].copy_from_slice(&length.to_le_bytes());
    stream.get_mut().write_all(&bytes)
}

/// Waits for a message.
pub(super) fn receive<T: for<'a> Deserialize<'a>>(stream: &mut BufReader<Stream>) -> io::Result<T> {
    let mut length = [0; 4];
    stream.read_exact(&mut length)?;
    let length = u32::from_le_bytes(length);
    let mut bytes = Vec::new();
    // Memory grows as the bytes come.
    stream.take(length.into()).read_to_end(&mut bytes)?;
    postcard::from_bytes(&bytes).map_err(io::Error::other)
}

/// A child with the library of an FMU loaded.
pub(super) struct Process {
    stream: BufReader<Stream>,
    watched: Arc<Watched>,
    watch: Option<JoinHandle<()>>,
    /// True if all calls succeeded, so that its library may make another instance.
    is_sound: bool,
}

/// The process that a thread watches.
struct Watched {
    child: Mutex<Child>,
    /// When it was started.
    clock: Clock,
    /// The start of the present call, in ms from then on, plus 1; 0 without a call.
    begun: AtomicU64,
    is_late: AtomicBool,
    is_over: AtomicBool,
    /// True if the processes that the library started were ended with it.
    is_cleared: AtomicBool,
}

impl Watched {
    fn now(&self) -> u64 {
        self.clock.elapsed().as_millis() as u64 + 1
    }

    fn child<T>(&self, of: impl FnOnce(&mut Child) -> T) -> T {
        of(&mut self.child.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The exit status of the child, if it ended. The processes that its library started end with it.
    fn status(&self) -> io::Result<Option<ExitStatus>> {
        self.child(|child| {
            let status = child.try_wait()?;
            // At once, before another process can get its number.
            if status.is_some() && !self.is_cleared.swap(true, Relaxed) {
                end_group(child.id());
            }
            Ok(status)
        })
    }

    /// Ends the child when a call takes too long, and the waiting for a dead one.
    fn watch(&self, stream: &Stream) {
        while !self.is_over.load(Relaxed) {
            park_timeout(LOOK);
            let begun = self.begun.load(Relaxed);
            if begun != 0 && self.now() > begun + LONGEST.load(Relaxed) {
                self.is_late.store(true, Relaxed);
                // One that has just ended cannot be killed.
                let _ = self.child(Child::kill);
            }
            // A process that the library started may hold the socket open.
            if !matches!(self.status(), Ok(None)) {
                let _ = stream.shutdown(std::net::Shutdown::Both);
                return;
            }
        }
    }
}

impl Process {
    /// Starts a child that loads the library of the FMU in this folder.
    ///
    /// # Errors
    /// The child's message; a child that dies or is late.
    pub fn start(folder: &Path) -> Result<Self, Fault> {
        let not_started = |e: io::Error| Fault::new(format!("the process for its library cannot be started: {e}"));
        let program = PROGRAM.get().ok_or_else(|| not_started(io::ErrorKind::NotFound.into()))?;
        let mut command = Command::new(program);
        command.arg(MARK).arg(folder).arg(std::process::id().to_string()).stdout(io::stderr());
        let (stream, child) = connected(command).map_err(not_started)?;
        let other = stream.try_clone().map_err(not_started)?;
        let watched = Arc::new(Watched {
            child: Mutex::new(child),
            clock: Clock::now(),
            begun: AtomicU64::new(1),
            is_late: AtomicBool::new(false),
            is_over: AtomicBool::new(false),
            is_cleared: AtomicBool::new(false),
        });
        let watch = {
            let watched = Arc::clone(&watched);
            Some(spawn(move || watched.watch(&other)))
        };
        let mut process = Process { stream: BufReader::new(stream), watched, watch, is_sound: true };
        process.answer("loading its library").and_then(Answer::all).map(|_| process)
    }

    /// Makes a call, and waits for its answer.
    fn call(&mut self, call: &Call) -> Result<Answer, Fault> {
        self.watched.begun.store(self.watched.now(), Relaxed);
        // A dead child does not answer.
        let _ = send(&mut self.stream, call);
        self.answer(call.function())
    }

    fn answer(&mut self, function: &str) -> Result<Answer, Fault> {
        let received = receive::<Answer>(&mut self.stream);
        self.watched.begun.store(0, Relaxed);
        let answer = received.map_err(|e| self.lost(function, &e))?;
        self.is_sound &= answer.outcomes.iter().all(Result::is_ok);
        Ok(answer)
    }

    /// The fault of a child that no longer answers.
    #[cold]
    fn lost(&mut self, function: &str, error: &io::Error) -> Fault {
        self.is_sound = false;
        let mut fault = self.cause_of(function, error);
        fault.0.is_loss = true;
        fault
    }

    fn cause_of(&self, function: &str, error: &io::Error) -> Fault {
        if self.watched.is_late.load(Relaxed) {
            let longest = Number(LONGEST.load(Relaxed) as f64 * 1e-3);
            let hint = "--timeout admits longer calls (Python: timeout)";
            return Fault::new(format!("{function}: the library of the FMU does not return within {longest} s"))
                .hint(hint);
        }
        let how = ended(&self.watched, UNLOADING).map_or_else(|| format!("does not answer: {error}"), cause);
        let hint = "the fault is in the FMU; its maker can mend it";
        Fault::new(format!("{function}: the library of the FMU {how}")).hint(hint)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.watched.is_over.store(true, Relaxed);
        // The child ends when its socket is closed.
        let _ = self.stream.get_mut().shutdown(std::net::Shutdown::Both);
        if ended(&self.watched, if self.is_sound { UNLOADING } else { Duration::ZERO }).is_none() {
            let _ = self.watched.child(Child::kill);
            let _ = self.watched.child(Child::wait);
            let _ = self.watched.status();
        }
        if let Some(watch) = self.watch.take() {
            watch.thread().unpark();
            // A thread that only watches does not panic.
            let _ = watch.join();
        }
    }
}

/// The exit status of a child that ends within this time.
fn ended(watched: &Watched, within: Duration) -> Option<ExitStatus> {
    let (begin, mut pause) = (Clock::now(), Duration::from_micros(100));
    loop {
        if let Ok(Some(status)) = watched.status() {
            return Some(status);
        }
        if begin.elapsed() >= within {
            return None;
        }
        sleep(pause);
        pause = (2 * pause).min(LOOK);
    }
}

/// The cause of a child's end.
fn cause(status: ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        // Signals with one number on all systems, and the one of an address that does not exist.
        let name = match signal {
            4 => ": SIGILL, an instruction that the processor lacks",
            6 => ": SIGABRT, it gave up",
            8 => ": SIGFPE, a division by zero",
            9 => ": SIGKILL, ended from outside or for lack of memory",
            11 => ": SIGSEGV, an invalid address",
            15 => ": SIGTERM, ended from outside",
            _ if signal == BUS => ": SIGBUS, an invalid address",
            _ => "",
        };
        return format!("crashes (signal {signal}{name})");
    }
    match status.code() {
        // Windows ends with the number of an exception, from 0xC0000000 on.
        Some(code) if code < 0 => format!("crashes (exception {code:#010X})"),
        Some(code) => format!("ends its process (exit code {code})"),
        None => "ends its process".to_owned(),
    }
}

#[cfg(unix)]
const BUS: i32 = if cfg!(target_os = "linux") { 7 } else { 10 };

/// Starts a child, and connects with it. Signals of the terminal go to this process only.
#[cfg(unix)]
fn connected(mut command: Command) -> io::Result<(Stream, Child)> {
    use std::os::fd::OwnedFd;
    use std::os::unix::process::CommandExt as _;
    let (stream, other) = Stream::pair()?;
    let child = command.stdin(Stdio::from(OwnedFd::from(other))).process_group(0).spawn()?;
    // With the command the child's end is closed here.
    Ok((stream, child))
}

#[cfg(windows)]
fn connected(mut command: Command) -> io::Result<(Stream, Child)> {
    use std::os::windows::process::CommandExt as _;
    const CREATE_NEW_PROCESS_GROUP: u32 = 0x200;
    let listener = std::net::TcpListener::bind((std::net::Ipv4Addr::LOCALHOST, 0))?;
    let address = listener.local_addr()?;
    // Nobody else may connect in between.
    let word = format!("{:032x}", std::hash::BuildHasher::hash_one(&std::hash::RandomState::new(), address));
    command.arg(address.to_string()).stdin(Stdio::piped()).creation_flags(CREATE_NEW_PROCESS_GROUP);
    let mut child = command.spawn()?;
    // The pipe stays open as long as the child is kept.
    child.stdin.as_mut().map_or(Ok(()), |pipe| pipe.write_all(word.as_bytes()))?;
    listener.set_nonblocking(true)?;
    loop {
        match listener.accept() {
            Ok((mut stream, _)) => {
                stream.set_nonblocking(false)?;
                stream.set_nodelay(true)?;
                let mut said = vec![0; word.len()];
                if stream.read_exact(&mut said).is_ok() && said == word.as_bytes() {
                    return Ok((stream, child));
                }
            }
            Err(e) if e.kind() != io::ErrorKind::WouldBlock => return Err(e),
            Err(_) if child.try_wait()?.is_some() => return Err(io::ErrorKind::BrokenPipe.into()),
            Err(_) => sleep(Duration::from_millis(1)),
        }
    }
}

/// The children of an FMU without an instance.
#[derive(Default)]
pub(super) struct Idle(Mutex<Vec<Process>>);

impl Idle {
    fn of<T>(&self, of: impl FnOnce(&mut Vec<Process>) -> T) -> T {
        of(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    pub fn keep(&self, process: Process) {
        self.of(|idle| idle.push(process));
    }
}

/// An instance in a process of its own.
pub(super) struct Remote {
    /// None while it is returned.
    process: Option<Process>,
    idle: Arc<Idle>,
    /// The readings since the last change and at the point before, with their results.
    readings: Vec<Reading>,
    /// The index of each of them.
    places: HashMap<Read, usize>,
    /// Readings without a result since the last change.
    open: Vec<usize>,
    warnings: Vec<String>,
    has_ended: bool,
}

struct Reading {
    read: Read,
    outcome: Option<Outcome>,
    is_used: bool,
}

impl Remote {
    /// An instance of this name of the FMU in this folder.
    ///
    /// # Errors
    /// The library's message if it refuses; a process that dies or is late.
    pub fn new(folder: &Path, idle: &Arc<Idle>, name: &str) -> Result<Self, Fault> {
        let process = idle.of(Vec::pop).map_or_else(|| Process::start(folder), Ok)?;
        let mut remote = Remote {
            process: Some(process),
            idle: Arc::clone(idle),
            readings: Vec::new(),
            places: HashMap::new(),
            open: Vec::new(),
            warnings: Vec::new(),
            has_ended: false,
        };
        remote.change(Call::Instantiate(name.to_owned())).map(|()| remote)
    }

    fn call(&mut self, call: &Call) -> Result<Answer, Fault> {
        let process = self.process.as_mut().ok_or_else(|| Fault::new("there is no process"))?;
        let mut answer = process.call(call)?;
        self.warnings.append(&mut answer.warnings);
        self.has_ended = answer.has_ended;
        Ok(answer)
    }

    /// A call after which values may differ.
    fn change(&mut self, call: Call) -> Result<(), Fault> {
        let used = self.readings.iter().filter(|reading| reading.is_used).count();
        if (1..self.readings.len()).contains(&used) {
            self.readings.retain(|reading| reading.is_used);
            self.places = self.readings.iter().map(|reading| reading.read.clone()).zip(0..).collect();
        }
        for reading in &mut self.readings {
            (reading.outcome, reading.is_used) = (None, false);
        }
        self.open = (0..self.readings.len()).collect();
        self.call(&call)?.all()
    }

    fn read(&mut self, read: Read) -> Result<Vec<f64>, Fault> {
        let place = self.places.get(&read).copied().unwrap_or_else(|| {
            let place = self.readings.len();
            self.places.insert(read.clone(), place);
            self.readings.push(Reading { read, outcome: None, is_used: false });
            self.open.push(place);
            place
        });
        if self.readings[place].outcome.is_none() {
            let open = std::mem::take(&mut self.open);
            let asked = open.iter().map(|place| self.readings[*place].read.clone()).collect();
            for (place, outcome) in open.iter().zip(self.call(&Call::Read(asked))?.outcomes) {
                self.readings[*place].outcome = Some(outcome);
            }
        }
        let reading = &mut self.readings[place];
        reading.is_used = true;
        reading.outcome.clone().unwrap_or_else(|| Err(Fault::new("the value is missing")))
    }

    fn read_into(&mut self, read: Read, values: &mut [f64]) -> Result<(), Fault> {
        let read = self.read(read)?;
        values.iter_mut().zip(read).for_each(|(value, read)| *value = read);
        Ok(())
    }
}

impl Instance for Remote {
    fn set_up(&mut self, start: f64, stop: Option<f64>, tolerance: Option<f64>) -> Result<(), Fault> {
        self.change(Call::SetUp(start, stop, tolerance))
    }

    fn enter_initialization(&mut self) -> Result<(), Fault> {
        self.change(Call::EnterInitialization)
    }

    fn exit_initialization(&mut self) -> Result<(), Fault> {
        self.change(Call::ExitInitialization)
    }

    fn set(&mut self, variable: usize, value: f64) -> Result<(), Fault> {
        self.change(Call::Set(variable, value))
    }

    fn get(&mut self, variable: usize) -> Result<f64, Fault> {
        self.read(Read::Variable(variable)).map(|values| values.first().copied().unwrap_or(f64::NAN))
    }

    fn set_reals(&mut self, references: &[u32], values: &[f64]) -> Result<(), Fault> {
        self.change(Call::SetReals(references.to_vec(), values.to_vec()))
    }

    fn get_reals(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Fault> {
        self.read_into(Read::Reals(references.to_vec()), values)
    }

    fn set_input_derivatives(&mut self, references: &[u32], orders: &[i32], values: &[f64]) -> Result<(), Fault> {
        self.change(Call::SetInputDerivatives(references.to_vec(), orders.to_vec(), values.to_vec()))
    }

    fn get_output_derivatives(&mut self, references: &[u32], orders: &[i32], values: &mut [f64]) -> Result<(), Fault> {
        self.read_into(Read::Derivatives(references.to_vec(), orders.to_vec()), values)
    }

    fn do_step(&mut self, time: f64, step: f64) -> Result<(), Fault> {
        self.change(Call::DoStep(time, step))
    }

    fn save(&mut self) -> Result<(), Fault> {
        // It changes no value.
        self.call(&Call::Save)?.all()
    }

    fn restore(&mut self) -> Result<(), Fault> {
        self.change(Call::Restore)
    }

    fn terminate(&mut self) -> Result<(), Fault> {
        self.change(Call::Terminate)
    }

    fn free(&mut self) -> Result<(), Fault> {
        // The process of a library that failed ends instead.
        let Some(mut process) = self.process.take_if(|process| process.is_sound) else { return Ok(()) };
        process.call(&Call::Free)?;
        self.idle.keep(process);
        Ok(())
    }

    fn has_ended(&self) -> bool {
        self.has_ended
    }

    fn warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }
}

impl Drop for Remote {
    fn drop(&mut self) {
        // Call it before to learn how a library fails here.
        let _ = self.free();
    }
}
