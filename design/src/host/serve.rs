//! The child's side of [`super::process`]: it serves the library of one FMU.

use super::functions::leave;
#[cfg(unix)]
use super::process::LOOK;
use super::process::{Answer, Call, MARK, PROGRAM, Read, Stream, receive, send};
use super::{Fmu, Host};
use camdrive::drives::Fault;
use std::ffi::OsString;
use std::io::{self, BufReader};
#[cfg(windows)]
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::ExitCode;
#[cfg(unix)]
use std::thread::sleep;
use std::thread::spawn;

/// A program that drives foreign FMUs must call this first: their libraries then run in processes of their own.
///
/// A process that was started for a library serves it, and gets its exit code.
pub fn serve() -> Option<ExitCode> {
    let arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    if arguments.first().is_some_and(|first| first == MARK) {
        return Some(serve_library(&arguments[1..]).map_or(ExitCode::FAILURE, |()| ExitCode::SUCCESS));
    }
    if let Ok(program) = std::env::current_exe() {
        // It is set once, here.
        let _ = PROGRAM.set(program);
    }
    None
}

/// The socket of this child; the child ends when the process that started it does, also within a call.
#[cfg(unix)]
fn socket(parent: &OsString, _: Option<&OsString>) -> io::Result<Stream> {
    use std::os::fd::AsFd as _;
    let parent: Option<u32> = parent.to_str().and_then(|text| text.parse().ok());
    spawn(move || {
        while parent == Some(std::os::unix::process::parent_id()) {
            sleep(LOOK);
        }
        leave()
    });
    Ok(Stream::from(io::stdin().as_fd().try_clone_to_owned()?))
}

#[cfg(windows)]
fn socket(_: &OsString, address: Option<&OsString>) -> io::Result<Stream> {
    let address = address.and_then(|text| text.to_str()).ok_or(io::ErrorKind::InvalidInput)?;
    let mut word = [0; 32];
    io::stdin().read_exact(&mut word)?;
    let mut stream = Stream::connect(address)?;
    stream.set_nodelay(true)?;
    stream.write_all(&word)?;
    spawn(|| {
        // It ends with the process that started this one.
        let _ = io::stdin().read(&mut [0]);
        leave()
    });
    Ok(stream)
}

/// Serves the library of an FMU in an unpacked folder, until the socket is closed.
fn serve_library(arguments: &[OsString]) -> io::Result<()> {
    let [folder, parent, address @ ..] = arguments else { return Err(io::ErrorKind::InvalidInput.into()) };
    let mut stream = BufReader::new(socket(parent, address.first())?);
    let (fmu, loaded) = match Fmu::loaded(Path::new(folder)) {
        Ok(fmu) => (Some(fmu), Ok(Vec::new())),
        Err(fault) => (None, Err(fault)),
    };
    send(&mut stream, &Answer { outcomes: vec![loaded], ..Answer::default() })?;
    let Some(fmu) = fmu else { return Ok(()) };
    let mut host = None;
    // A closed socket ends it.
    while let Ok(call) = receive::<Call>(&mut stream) {
        let answer = answered(&fmu, &mut host, call);
        send(&mut stream, &answer)?;
    }
    Ok(())
}

fn answered(fmu: &Fmu, host: &mut Option<Host>, call: Call) -> Answer {
    let outcomes = match (call, host.as_mut()) {
        (Call::Instantiate(name), _) => vec![fmu.instantiate(&name).map(|new| {
            *host = Some(new);
            Vec::new()
        })],
        (Call::Free, _) => {
            *host = None;
            vec![Ok(Vec::new())]
        }
        (Call::Read(all), Some(host)) => all.iter().map(|read| host.read(read)).collect(),
        (call, Some(host)) => vec![host.called(&call).map(|()| Vec::new())],
        (_, None) => vec![Err(Fault::new("there is no instance"))],
    };
    let warnings = host.as_mut().map_or_else(Vec::new, |host| host.warnings());
    Answer { outcomes, warnings, has_ended: host.as_ref().is_some_and(|host| host.has_ended()) }
}

impl Host {
    fn read(&mut self, read: &Read) -> Result<Vec<f64>, Fault> {
        let mut values = Vec::new();
        match read {
            Read::Variable(variable) => values.push(self.get(*variable)?),
            Read::Reals(references) => {
                values.resize(references.len(), 0.0);
                self.get_reals(references, &mut values)?;
            }
            Read::Derivatives(references, orders) => {
                values.resize(references.len(), 0.0);
                self.get_output_derivatives(references, orders, &mut values)?;
            }
        }
        Ok(values)
    }

    fn called(&mut self, call: &Call) -> Result<(), Fault> {
        match call {
            Call::SetUp(start, stop, tolerance) => self.set_up(*start, *stop, *tolerance),
            Call::EnterInitialization => self.enter_initialization(),
            Call::ExitInitialization => self.exit_initialization(),
            Call::Set(variable, value) => self.set(*variable, *value),
            Call::SetReals(references, values) => self.set_reals(references, values),
            Call::SetInputDerivatives(references, orders, values) => {
                self.set_input_derivatives(references, orders, values)
            }
            Call::DoStep(time, step) => self.do_step(*time, *step),
            Call::Save => self.save(),
            Call::Restore => self.restore(),
            Call::Terminate => self.terminate(),
            Call::Instantiate(_) | Call::Read(_) | Call::Free => Ok(()),
        }
    }
}
