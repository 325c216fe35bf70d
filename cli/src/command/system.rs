//! `camdrive system SYSTEM`

mod osp;
mod ssp;
pub mod study;

use super::deliver::ReportFormat;
use super::output::{print, show, width};
use super::{Failure, Foreign, failure, files, print_message};
use crate::document::input::is_archive;
use crate::export::archive::{File, archive};
use crate::export::xml::number;
use crate::export::{Date, Extras, RuntimeLibrary, pack};
use crate::scene::Resolved;
use crate::system::{self, Connection, Content, End, Part, Seat, Shaft, System};
use camdrive::drives::Fault;
use camdrive::drives::variable::Kind;
use camdrive_design::coupling::report::name as named;
use camdrive_design::coupling::stability::Exchange;
use camdrive_design::report::rounding::Rounding;
use camdrive_design::report::terminal::shown;
use camdrive_design::report::unit::{DEG, HZ, KGM2, MS, ONE};
use camdrive_design::report::{Level, Report, Table, Value as Cell};
use camdrive_design::text::{self, counted};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Connect machine and drives, and export them for other masters.
///
/// The folder gets an FMU for each part, NAME.ssp (System Structure and Parameterization 1.0), OspSystemStructure.xml (Open
/// Simulation Platform) and run.py, a master for fmpy with the system's exchange. `camdrive check` prints algebraic loops and the
/// largest stable communication step of a system without writing files.
///
/// With --study the folder gets NAME.csv, NAME.json and NAME.svg instead: the error of each output for each exchange, at steps from
/// four times to an eighth of the file's step, against the same machine and drives as one DriveTrain, which is written as
/// NAME_train.fmu. A system that cannot be one DriveTrain is compared with itself at much shorter steps, repeated twice.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive system examples/two_cams/system.toml -o two_cams/
  camdrive check examples/two_cams/system.toml
  camdrive system examples/two_cams/system.toml --study
  python two_cams/run.py 0.5e-3")]
pub struct Args {
    /// System file (TOML)
    system: PathBuf,
    /// Folder of the result [default: system-NAME]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Instead of the files for masters, write a report: errors over the communication step of each exchange, and the system as one
    /// FMU
    #[arg(long)]
    study: bool,
    #[command(flatten)]
    foreign: Foreign,
    #[command(flatten)]
    format: ReportFormat,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    args.foreign.limit()?;
    if is_archive(&args.system) {
        let hint = "`camdrive run` and `check` take it; a system file names FMUs: [part.motor] fmu = \"motor.fmu\"";
        return Err(failure(format!("{}: this is an archive already", args.system.display())).hint(hint));
    }
    let system = read(&args.system)?;
    let folder = files::folder(args.output.as_deref(), "system", &system.name)?;
    if args.study {
        return study::run(args, &system, &folder);
    }
    let (fmus, names) = fmus(&system)?;
    let date = Date::from_environment().map_err(failure)?;
    let mut inside = vec![File::new(ssp::FILE, ssp::xml(&system, &names))];
    inside.extend(fmus.iter().map(|fmu| File::new(format!("resources/{}", fmu.path), fmu.content.as_slice())));
    let archive = archive(&inside, date).map_err(|e| failure(format!("the archive cannot be written: {e}")))?;
    let mut written: Vec<(PathBuf, Vec<u8>)> = vec![
        (folder.join(format!("{}.ssp", system.name)), archive),
        (folder.join(osp::FILE), osp::xml(&system, &names).into_bytes()),
        (folder.join("run.py"), master(&system, &names).into_bytes()),
    ];
    written.extend(fmus.into_iter().map(|fmu| (folder.join(fmu.path), fmu.content)));
    let lines = files::write(&written, &system.files)?;
    if args.format.json {
        let mut data = data(&args.system, &system);
        data["files"] = written.iter().map(|(path, _)| path.display().to_string()).collect();
        return print(&text::json(&data).map_err(failure)?);
    }
    let report = glance(&system.name, &system);
    show(&format!("{}\n{lines}", report.text(width(), args.format.explain)))
}

/// Reads a system and prints its notes.
pub fn read(path: &Path) -> Result<System, Failure> {
    let system = system::read(path).map_err(failure)?;
    for note in system.remarks() {
        print_message(&format!("note: {}: {note}\n", text::in_one_line(path.display())));
    }
    Ok(system)
}

/// The FMUs, each once, and for each part the name of its FMU.
fn fmus(system: &System) -> Result<(Vec<File>, Vec<String>), Failure> {
    let libraries = libraries()?;
    let date = Date::from_environment().map_err(failure)?;
    let (mut fmus, mut names): (Vec<File>, Vec<String>) = (Vec::new(), Vec::new());
    for (i, part) in system.parts.iter().enumerate() {
        if let Some(same) = system.parts[..i].iter().position(|other| other.content == part.content) {
            names.push(names[same].clone());
            continue;
        }
        let place = format!("part {}", part.name);
        let content = match &part.content {
            Content::Scene(scene) => packed(scene, &libraries, date).map_err(|fault| fault.within(&place))?,
            Content::Fmu(path) => std::fs::read(path).map_err(|e| failure(format!("{place}: {e}")))?,
        };
        let name = format!("{}.fmu", part.name);
        fmus.push(File::new(name.clone(), content));
        names.push(name);
    }
    Ok((fmus, names))
}

/// The FMU of a scene.
fn packed(scene: &Resolved, libraries: &[RuntimeLibrary], date: Option<Date>) -> Result<Vec<u8>, Fault> {
    let extras = Extras { sources: &scene.sources(), ..Extras::default() };
    Ok(pack(&scene.resource(), &scene.description, libraries, date, extras)?.bytes)
}

/// The libraries for the FMUs; prints which are missing.
fn libraries() -> Result<Vec<RuntimeLibrary>, Failure> {
    let (libraries, left_out) = RuntimeLibrary::at_hand(&[]).map_err(failure)?;
    left_out.iter().for_each(|fault| print_message(&format!("warning: left out: {fault}\n")));
    Ok(libraries)
}

/// A start value of a variable.
struct Started {
    name: String,
    /// Its type in FMI: Real, Integer or Boolean.
    kind: &'static str,
    value: String,
}

fn started(part: &Part) -> Vec<Started> {
    let of = |(name, value): &(String, f64)| {
        let kind = part.description.variable(name).map(|v| &v.about.kind);
        let (kind, value) = match kind {
            Some(Kind::Integer { .. } | Kind::Enumeration(_)) => ("Integer", (*value as i32).to_string()),
            Some(Kind::Boolean) => ("Boolean", (*value != 0.0).to_string()),
            _ => ("Real", number(*value)),
        };
        Started { name: name.clone(), kind, value }
    };
    part.start.iter().map(of).collect()
}

/// Some if a connection changes its value.
fn factor_of(connection: &Connection) -> Option<()> {
    (connection.factor != 1.0 || connection.offset != 0.0).then_some(())
}

/// A master for fmpy.
fn master(system: &System, files: &[String]) -> String {
    let step = match system.exchange {
        Exchange::Held => include_str!("system/held.py"),
        // Only these exchanges can be in a file.
        _ => include_str!("system/interpolated.py"),
    };
    let name = |part: usize| &system.parts[part].name;
    let dictionary = |entries: Vec<String>| format!("{{{}}}", entries.join(", "));
    let fmus = system.parts.iter().zip(files).map(|(part, file)| format!("{:?}: {file:?}", part.name)).collect();
    let start = system.parts.iter().filter(|part| !part.start.is_empty()).map(|part| {
        let value = |Started { name, kind, value }| match (kind, &*value) {
            ("Boolean", "true") => format!("{name:?}: True"),
            ("Boolean", _) => format!("{name:?}: False"),
            _ => format!("{name:?}: {value}"),
        };
        format!("{:?}: {}", part.name, dictionary(started(part).into_iter().map(value).collect()))
    });
    let mut connections = String::new();
    for Connection { from: (a, output), to: (b, input), factor, offset } in &system.connections {
        let (a, b) = (name(*a), name(*b));
        let _ = writeln!(connections, "    ({a:?}, {output:?}, {b:?}, {input:?}, {factor:?}, {offset:?}),");
    }
    let seat = |part: &Part| {
        let Seat { machine, ratio, offset } = part.seat?;
        Some(format!("{:?}: ({:?}, {ratio:?}, {offset:?})", part.name, name(machine)))
    };
    [
        ("@name@", system.name.clone()),
        ("@stop@", number(system.stop)),
        ("@step@", number(system.step)),
        ("@fmus@", dictionary(fmus)),
        ("@start@", dictionary(start.collect())),
        ("@connections@", connections),
        ("@shafts@", dictionary(system.parts.iter().filter_map(seat).collect())),
        ("@step_function@", step.to_owned()),
    ]
    .into_iter()
    .fold(include_str!("system/master.py").to_owned(), |text, (mark, value)| text.replace(mark, &value))
}

/// A port in a form for people.
fn end(system: &System, (part, name): &End) -> String {
    format!("{}.{name}", system.parts[*part].name)
}

/// The connections of each loop in their order.
fn loops(system: &System) -> Vec<Vec<String>> {
    let arrow = |c: &Connection| format!("{} → {}", end(system, &c.from), end(system, &c.to));
    system.loops().iter().map(|whole| whole.iter().map(|i| arrow(&system.connections[*i])).collect()).collect()
}

/// A system at a glance, before it runs.
pub fn glance(name: impl Into<String>, system: &System) -> Report {
    let mut report = Report::new(name, format!("system of {}", counted(system.parts.len(), "part")));
    let unbalanced = system.unbalanced();
    if unbalanced.is_empty() {
        report.verdict.result(Level::Good, "No fault.");
    }
    for said in unbalanced {
        report.verdict.result(Level::Mind, said);
    }
    for whole in loops(system) {
        report.verdict.result(Level::Mind, format!("Algebraic loop: {}.", whole.join(", ")));
    }
    let exchange = named(system::name_of(system.exchange), system.repeats);
    let [step, stop] = [system.step, system.stop].map(|time| shown(time, &MS));
    report.lines("", [format!("The exchange is {exchange}, in steps of {step} up to {stop}.")]);
    let machine = |place: usize| &system.parts[place].name;
    let content = |part: &Part| match &part.content {
        Content::Scene(scene) => scene.scene.model_name().to_owned(),
        Content::Fmu(path) => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
    };
    let parts = Table::of("Parts", &system.parts)
        .column("part", "part", ONE, |part| &part.name)
        .column("content", "is a", ONE, content)
        .column("shaft", "on the shaft of", ONE, |part| part.seat.map(|seat| machine(seat.machine)))
        .column("ratio", "ratio", ONE, |part| part.seat.map(|seat| seat.ratio))
        .column("offset", "offset", DEG, |part| part.seat.map(|seat| seat.offset));
    let elastic = |shaft: &Shaft| Some(shaft.limit.frequency).filter(|frequency| 0.0 < *frequency);
    let stable = |shaft: &Shaft| elastic(shaft).map(|_| shaft.limit.stable.map_or("any".into(), Cell::Number));
    let shafts = Table::of("Shafts", &system.shafts)
        .column("machine", "machine", ONE, |shaft| machine(shaft.machine))
        .column("inertia", "least inertia", KGM2, |shaft| shaft.limit.inertia)
        .column("kappa", "J_load/J", ONE, |shaft| shaft.limit.kappa)
        .column("frequency", "√(k/J) of elastic loads", HZ, elastic)
        .column("stable", "largest stable step", MS, stable)
        .rounded(Rounding::Inward)
        .below(["A step can be stable only if J_load/J is below 1.".to_owned()]);
    let connections = Table::of("Connections", &system.connections)
        .column("from", "from", ONE, |c| end(system, &c.from))
        .column("to", "to", ONE, |c| end(system, &c.to))
        .column("factor", "factor", ONE, |c| factor_of(c).map(|()| c.factor))
        .column("offset", "offset", ONE, |c| factor_of(c).map(|()| c.offset));
    report.table(parts).table(shafts).explain_table(connections);
    report
}

/// The same as data.
pub fn data(path: &Path, system: &System) -> Value {
    let shaft = |shaft: &system::Shaft| json!({ "machine": system.parts[shaft.machine].name, "limit": shaft.limit });
    let connection = |c: &Connection| json!({ "from": end(system, &c.from), "to": end(system, &c.to), "factor": c.factor, "offset": c.offset });
    let verdict = glance("", system).verdict;
    json!({
        "file": path.display().to_string(), "ok": true, "verdict": verdict, "name": system.name, "model": "system", "notes": system.notes,
        "exchange": system::name_of(system.exchange), "repeats": system.repeats, "step": system.step, "stop": system.stop,
        "parts": system.parts.iter().map(|part| &part.name).collect::<Vec<_>>(),
        "connections": system.connections.iter().map(connection).collect::<Vec<_>>(),
        "shafts": system.shafts.iter().map(shaft).collect::<Vec<_>>(),
        "loops": loops(system),
    })
}
