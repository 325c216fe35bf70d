//! `camdrive study STUDY`

mod store;

use super::output::counter;
use super::{Failure, Foreign, Format, ending, failure, files, print_message};
use crate::document::{Diagnostic, Diagnostics, Document, input};
use crate::export::hash;
use crate::study::{self, Cell, Quantity, Study, Subject};
use crate::system::coupled::Coupled;
use camdrive::drives::{AnyDrive, Description, Fault};
use camdrive_design::report;
use camdrive_design::study::coupled;
use camdrive_design::study::plan::rows_of_part;
use camdrive_design::study::report::{Column, Findings};
use camdrive_design::study::single::Runner;
use camdrive_design::text::{self, counted, number};
use indicatif::ProgressBar;
use serde::Serialize;
use serde_json::json;
use std::collections::BTreeMap;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;
use store::Store;

/// Run many variants of a scene, a system or an FMU and measure each.
///
/// A study file names the model, its variations (lists, series, random and Latin hypercube designs, rows of a CSV file), the
/// duration of a run and the measures: `max |q|`, `rms force`, `count impacts`, `y at 90 deg`, `harmonic 3 of q`. The result is a
/// folder with study.json and a folder `runs` of Parquet parts, each written completely or not at all. A run that a scene does not
/// admit, or that fails, is a row with a message. The numbers are the same for any number of threads and parts.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive study examples/guide_bar/study.toml --explain
  camdrive study examples/guide_bar/study.toml -o waves/
  camdrive study examples/guide_bar/study.toml -o waves/ --resume
  camdrive study examples/guide_bar/study.toml -o waves/ --part 3/20
  camdrive study examples/two_cams/study.toml")]
pub struct Args {
    /// Study file (TOML)
    study: PathBuf,
    /// Folder of the store [default: study-NAME]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Print the number of runs, seconds and bytes; run only a sample
    #[arg(long)]
    explain: bool,
    /// Continue a store of this study: keep its parts, compute missing ones
    #[arg(long)]
    resume: bool,
    /// Compute only share I of N of the parts, as a job of an array; all shares use the same store
    #[arg(long, value_name = "I/N", value_parser = share)]
    part: Option<(u64, u64)>,
    /// Threads [default: all cores]
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    #[command(flatten)]
    foreign: Foreign,
    #[command(flatten)]
    format: Format,
}

/// I and N of "I/N", both from 1.
fn share(text: &str) -> Result<(u64, u64), String> {
    let numbers = text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
    numbers.filter(|(i, n)| (1..=*n).contains(i)).ok_or_else(|| "it is I/N with I from 1 to N, such as 3/20".to_owned())
}

/// The end of a run.
#[derive(Clone, Copy, PartialEq)]
enum Status {
    Ok,
    /// The scene or the drive does not admit the values.
    Refused,
    /// The drive failed during the run.
    Failed,
}

impl Status {
    fn word(self) -> &'static str {
        match self {
            Status::Ok => "ok",
            Status::Refused => "refused",
            Status::Failed => "failed",
        }
    }
}

/// A run in the store.
struct Record {
    cells: Vec<Cell>,
    /// None unless the run is `Ok`.
    values: Vec<Option<f64>>,
    status: Status,
    message: String,
}

/// The tools of a thread for its runs.
struct Worker<'a> {
    study: &'a Study,
    /// For a study in which only variables vary.
    shared: Option<Shared<'a>>,
}

/// The common parts of all runs in which only variables vary.
enum Shared<'a> {
    Drive(AnyDrive, Runner<'a>),
    Coupled(&'a Coupled, coupled::Runner<'a>),
}

impl<'a> Worker<'a> {
    fn new(study: &'a Study) -> Result<Self, Fault> {
        let shared = match &study.subject {
            _ if study.is_keyed() => None,
            Subject::Scene(scene) => {
                let drive = scene.resource().build()?.plan().instance();
                let runner = Runner::new(&drive, &study.window, &study.measures)?;
                Some(Shared::Drive(drive, runner))
            }
            Subject::Coupled(coupled) => Some(Shared::Coupled(coupled, study.runner(coupled)?)),
        };
        Ok(Worker { study, shared })
    }

    /// A run; a panic makes it a failed run, and the next one starts afresh.
    fn run(&mut self, row: u64) -> Record {
        let cells = self.study.cells(row);
        let outcome = catch_unwind(AssertUnwindSafe(|| self.measured(&cells)));
        let outcome = outcome.unwrap_or_else(|_| Err((Status::Failed, "the drive failed".to_owned())));
        let (values, status, message) = match outcome {
            Ok((values, ended)) => (values.into_iter().map(Some).collect(), Status::Ok, ended.unwrap_or_default()),
            Err((status, message)) => (vec![None; self.study.measures.len()], status, message),
        };
        Record { cells, values, status, message }
    }

    /// The measures, and the reason if the run ended before its window.
    fn measured(&mut self, cells: &[Cell]) -> Result<(Vec<f64>, Option<String>), (Status, String)> {
        let study = self.study;
        match &mut self.shared {
            Some(Shared::Drive(drive, runner)) => {
                drive.reset();
                set(study, drive, cells).map_err(refused)?;
                return runner.run(drive).map(|values| (values, None)).map_err(failed);
            }
            Some(Shared::Coupled(coupled, runner)) => return of_coupled(study, coupled, runner, cells),
            None => (),
        }
        let told = |Diagnostics(faults): Diagnostics| {
            // The scene of a part is another file.
            let message = |fault: &Diagnostic| match fault.file == study.place.display().to_string() {
                true => fault.message.clone(),
                false => format!("{}: {}", fault.file, fault.message),
            };
            (Status::Refused, faults.iter().map(message).collect::<Vec<_>>().join("; "))
        };
        match study.variant(cells).map_err(told)? {
            Subject::Scene(scene) => {
                let mut drive = scene.resource().build().map_err(refused)?;
                set(study, &mut drive, cells).map_err(refused)?;
                let runner = Runner::new(&drive, &study.window, &study.measures).map_err(refused)?;
                runner.run(&mut drive).map(|values| (values, None)).map_err(failed)
            }
            Subject::Coupled(coupled) => of_coupled(study, &coupled, &study.runner(&coupled).map_err(refused)?, cells),
        }
    }
}

/// The status of a run with refused values; a library that has crashed refuses no values.
fn refused(fault: Fault) -> (Status, String) {
    let status = if fault.is_loss { Status::Failed } else { Status::Refused };
    (status, fault.to_string())
}

fn failed(fault: Fault) -> (Status, String) {
    (Status::Failed, fault.to_string())
}

/// The indices of the varied variables in this list, and their values; a scene of a run may have other indices.
fn values(study: &Study, all: &[Description], cells: &[Cell]) -> Result<Vec<(usize, f64)>, Fault> {
    let numbers = study.quantities.iter().zip(cells).filter_map(|(quantity, cell)| match (quantity.variable, cell) {
        (Some(reference), Cell::Number(value)) => Some((&quantity.name, reference, *value)),
        _ => None,
    });
    let found = numbers.map(|(name, reference, value)| {
        let own = all.get(reference).is_some_and(|d| d.name == *name).then_some(reference);
        let place = own.or_else(|| all.iter().position(|d| d.name == *name));
        place.map(|place| (place, value)).ok_or_else(|| Fault::new(format!("this scene has no variable `{name}`")))
    });
    found.collect()
}

/// Sets the varied quantities of a drive, and starts it.
fn set(study: &Study, drive: &mut AnyDrive, cells: &[Cell]) -> Result<(), Fault> {
    drive.set_up(0.0, None);
    for (place, value) in values(study, drive.descriptions(), cells)? {
        drive.set(place, value)?;
    }
    drive.start()
}

/// The measures of a run of coupled FMUs, on new instances.
fn of_coupled(
    study: &Study,
    coupled: &Coupled,
    runner: &coupled::Runner<'_>,
    cells: &[Cell],
) -> Result<(Vec<f64>, Option<String>), (Status, String)> {
    let values = values(study, &coupled.variables, cells).map_err(refused)?;
    let step = study.step.unwrap_or(coupled.system.step);
    let mut coupling = coupled.started(&values, step).map_err(refused)?;
    let measured = runner.run(&mut coupling, coupled.begin, step).map_err(failed)?;
    // An error of a part after its results does not change them.
    coupling.end().map_err(failed)?;
    Ok(measured)
}

/// The rows of a part as they arrive.
struct Part {
    rows: Vec<Option<Record>>,
    left: usize,
}

/// The parts of a study for one call.
struct Parts<'a> {
    study: &'a Study,
    columns: &'a [(Column, Content)],
    store: &'a Store,
    /// Rows of a part; of the last part at most.
    size: u64,
    numbers: Vec<u64>,
    /// The end of the rows of each part.
    ends: Vec<u64>,
}

impl Parts<'_> {
    /// The rows of a part.
    fn of_part(&self, part: u64) -> Range<u64> {
        part * self.size..self.study.rows().min((part + 1) * self.size)
    }

    /// The number of rows of all parts.
    fn total(&self) -> u64 {
        self.ends.last().copied().unwrap_or(0)
    }

    /// Computes and stores the rows with these workers, each in its own thread.
    ///
    /// # Errors
    /// A part that cannot be written; a signal. Parts written before are kept.
    fn compute(&self, workers: Vec<Worker<'_>>, bar: &ProgressBar) -> Result<(), Failure> {
        let (next, stop) = (AtomicU64::new(0), Arc::new(AtomicBool::new(false)));
        // The first signal ends it after the current runs, a second one immediately.
        ending::stopping(&stop);
        let open: Mutex<BTreeMap<u64, Part>> = Mutex::default();
        let broken: Mutex<Option<Failure>> = Mutex::default();
        let work = |mut worker: Worker<'_>| {
            while !stop.load(Ordering::Relaxed) {
                let taken = next.fetch_add(1, Ordering::Relaxed);
                if taken >= self.total() {
                    break;
                }
                let place = self.ends.partition_point(|end| *end <= taken);
                let (part, range) = (self.numbers[place], self.of_part(self.numbers[place]));
                let row = range.end - (self.ends[place] - taken);
                let record = worker.run(row);
                bar.inc(1);
                let Some(rows) = gathered(&mut held(&open), part, row - range.start, record, &range) else { continue };
                if let Err(failure) = self.store.write(part, range.start, self.columns, &rows) {
                    stop.store(true, Ordering::Relaxed);
                    held(&broken).get_or_insert(failure);
                }
            }
        };
        let work = &work;
        std::thread::scope(|scope| {
            for worker in workers {
                scope.spawn(move || work(worker));
            }
        });
        bar.finish_and_clear();
        if let Some(failure) = held(&broken).take() {
            return Err(failure);
        }
        if stop.load(Ordering::Relaxed) {
            let there = self.numbers.iter().filter(|part| self.store.has(**part).is_ok_and(|there| there)).count();
            let whole = counted(self.numbers.len(), "part");
            return Err(failure(format!("ended by a signal; {there} of {whole} are there")).hint("--resume continues"));
        }
        Ok(())
    }
}

/// Takes a run; returns the rows of its part if it was the last one.
fn gathered(
    open: &mut BTreeMap<u64, Part>,
    part: u64,
    place: u64,
    record: Record,
    range: &Range<u64>,
) -> Option<Vec<Record>> {
    let count = (range.end - range.start) as usize;
    let of_part = open.entry(part).or_insert_with(|| Part { rows: (0..count).map(|_| None).collect(), left: count });
    of_part.rows[place as usize] = Some(record);
    of_part.left -= 1;
    if of_part.left > 0 {
        return None;
    }
    open.remove(&part).map(|whole| whole.rows.into_iter().flatten().collect())
}

/// Reads a study and its name.
pub fn read(path: &Path) -> Result<(Study, String), Failure> {
    let study = study::read(path).map_err(failure)?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = if stem == "study" { study.subject.name().to_owned() } else { stem };
    Ok((study, name))
}

/// The findings in a store, or in the store of a study.
pub fn findings(path: &Path) -> Result<Findings, Failure> {
    if path.is_dir() {
        return store::findings(path);
    }
    let (study, name) = read(path)?;
    let folder = files::folder(None, "study", &name)?;
    if !folder.join(store::SPECIFICATION).is_file() {
        let (file, store) = (path.display(), folder.display());
        let hint = format!("`camdrive study {file}` creates it; `camdrive report FOLDER` reads another store");
        return Err(failure(format!("{file}: its store {store} does not exist")).hint(hint));
    }
    Store::open(&folder, &specification(&study, &columns(&study), rows_of_part(study.rows()))?, true)?;
    store::findings(&folder)
}

pub fn run(args: &Args) -> Result<(), Failure> {
    args.foreign.limit()?;
    let (study, name) = read(&args.study)?;
    let folder = files::folder(args.output.as_deref(), "study", &name)?;
    let rows = study.rows();
    let size = rows_of_part(rows);
    study.notes.iter().for_each(|note| print_message(&format!("note: {}: {note}\n", args.study.display())));
    let threads = args.threads.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    if let Subject::Coupled(coupled) = &study.subject {
        let place = study.place.display();
        coupled.system.remarks().iter().for_each(|remark| print_message(&format!("note: {place}: {remark}\n")));
    }
    let columns = columns(&study);
    if args.explain {
        return explain(args, &study, threads, &columns, size);
    }
    let wrong = |fault: Fault| failure(fault.within(args.study.display()));
    let store = Store::open(&folder, &specification(&study, &columns, size)?, args.resume || args.part.is_some())?;
    let (i, n) = args.part.unwrap_or((1, 1));
    let mut numbers = Vec::new();
    for part in (0..rows.div_ceil(size)).filter(|part| part % n == i - 1) {
        let there = store.has(part).unwrap_or_else(|Failure { fault, .. }| {
            let fault = fault.message.trim_start_matches("error: ");
            print_message(&format!("warning: {fault}; its runs are computed again\n"));
            false
        });
        if !there {
            numbers.push(part);
        }
    }
    let mut parts = Parts { study: &study, columns: &columns, store: &store, size, numbers, ends: Vec::new() };
    let mut end = 0;
    for part in &parts.numbers {
        let range = parts.of_part(*part);
        end += range.end - range.start;
        parts.ends.push(end);
    }
    let begin = Instant::now();
    let workers =
        (0..threads.min(end as usize)).map(|_| Worker::new(&study)).collect::<Result<Vec<_>, _>>().map_err(wrong)?;
    parts.compute(workers, &counter(&name, end))?;
    let seconds = begin.elapsed().as_secs_f64();
    let found = store::findings(&folder)?;
    let report = |width| {
        let (place, runs) = (text::in_one_line(folder.display()), counted(end, "run"));
        found.report().text(width, false) + &format!("\n{place}: {runs} in {}\n", text::time(seconds))
    };
    let data = || {
        let (store, scene, tables) = (&folder, &study.place, &study.tables);
        report::json(
            &found.verdict(),
            &Call { store, scene, tables, computed: end, seconds, threads, findings: &found },
        )
    };
    args.format.print(report, data)
}

/// The runs of a call, and the runs in the store so far.
#[derive(Serialize)]
struct Call<'a> {
    store: &'a Path,
    scene: &'a Path,
    tables: &'a [PathBuf],
    computed: u64,
    seconds: f64,
    threads: usize,
    #[serde(flatten)]
    findings: &'a Findings,
}

fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The content of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Content {
    Run,
    Varied(usize),
    Text(usize),
    Measured(usize),
    Status,
    Message,
}

/// The columns of the store of a study.
fn columns(study: &Study) -> Vec<(Column, Content)> {
    let column = |name: &str, unit: &str, meaning: &str, content: Content| {
        let role = match content {
            Content::Varied(_) | Content::Text(_) => "varied",
            Content::Measured(_) => "measured",
            _ => "run",
        };
        let [name, role, unit, meaning] = [name, role, unit, meaning].map(str::to_owned);
        (Column { name, role, unit, meaning }, content)
    };
    let mut columns = vec![column("run", "", "Number of the run, from 0", Content::Run)];
    for (i, Quantity { name, unit, meaning, is_text, .. }) in study.quantities.iter().enumerate() {
        columns.push(column(name, unit, meaning, if *is_text { Content::Text(i) } else { Content::Varied(i) }));
    }
    for (i, (measure, [unit, meaning])) in study.measures.iter().zip(&study.measured).enumerate() {
        columns.push(column(&measure.to_string(), unit, meaning, Content::Measured(i)));
    }
    columns.push(column("status", "", "ok, refused or failed", Content::Status));
    columns.push(column(
        "message",
        "",
        "Reason why the run was refused, failed or ended before its window",
        Content::Message,
    ));
    columns
}

/// The content of study.json: everything that determines the numbers.
fn specification(study: &Study, columns: &[(Column, Content)], rows_of_part: u64) -> Result<String, Failure> {
    let [text, scene] = &study.texts;
    let digest = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        [
            name,
            hash::hexadecimal(&hash::sha256(
                &if path.is_file() { std::fs::read(path) } else { input::bytes(path) }.unwrap_or_default(),
            )),
        ]
    };
    let tables: Vec<[String; 2]> = study.tables.iter().map(digest).collect();
    // The path of the scene differs elsewhere.
    let mut anywhere = Document::new(text.clone());
    anywhere.remove("scene");
    let of_tables = tables.iter().map(|[_, digest]| digest.as_str()).collect::<String>();
    let identity = hash::sha256_of_parts(&[&anywhere.whole_text(), scene, &of_tables].map(|text| text.as_bytes()));
    text::json(&json!({
        "format": store::FORMAT,
        "identity": hash::hexadecimal(&identity),
        "tool": crate::export::TOOL,
        "commit": env!("CAMDRIVE_COMMIT"),
        "name": study.subject.name(),
        "model": if let Subject::Scene(scene) = &study.subject { Some(scene.scene.model_name()) } else { None },
        "study": text,
        "scene": scene,
        "tables": tables,
        "rows": study.rows(),
        "rows_of_part": rows_of_part,
        "axes": study.dimensions(),
        "lengths": study.lengths(),
        "sampled": study.is_sampled(),
        "columns": columns.iter().map(|(column, _)| column).collect::<Vec<_>>(),
    }))
    .map_err(failure)
}

/// Fewer rows than this are sampled in order.
const FEW: u64 = 100;

/// The time for which a sample of the runs is measured (s).
const SAMPLE: f64 = 0.5;

/// Prints what the study would take.
fn explain(
    args: &Args,
    study: &Study,
    threads: usize,
    columns: &[(Column, Content)],
    size: u64,
) -> Result<(), Failure> {
    let wrong = |fault: Fault| failure(fault.within(args.study.display()));
    let mut worker = Worker::new(study).map_err(wrong)?;
    let (rows, begin) = (study.rows(), Instant::now());
    let (mut count, mut bytes, mut ok) = (0u64, 0, 0u64);
    // Multiples of the golden ratio spread evenly over the rows, for any number of samples.
    let mut first = None;
    while count < rows && (count == 0 || begin.elapsed().as_secs_f64() < SAMPLE) {
        let place = ((count as f64 * 0.618_033_988_749_894_9).fract() * rows as f64) as u64;
        let row = if rows < FEW { count } else { place.min(rows - 1) };
        let record = worker.run(row);
        if record.status != Status::Ok {
            first.get_or_insert(format!("{}: run {row}: {}\n", record.status.word(), record.message));
        }
        ok += u64::from(record.status == Status::Ok);
        bytes += record.message.len();
        count += 1;
    }
    let each = begin.elapsed().as_secs_f64() / count as f64;
    let seconds = each * rows as f64 / threads as f64;
    let bytes = rows as f64 * (8.0 * (columns.len() - 2) as f64 + 1.0 + bytes as f64 / count as f64);
    let parts = rows.div_ceil(size);
    let report = |_| {
        format!(
            "{}: {} in {} of {size}, about {} on {} ({} each), {} MB\nof a sample of {count} runs {ok} are ok\n{}",
            text::in_one_line(args.study.display()),
            counted(rows, "run"),
            counted(parts, "part"),
            text::time(seconds),
            counted(threads, "thread"),
            text::time(each),
            number(bytes / 1e6),
            first.clone().unwrap_or_default(),
        )
    };
    let data = || {
        text::json(&json!({
            "rows": rows, "parts": parts, "rows_of_part": size, "threads": threads, "seconds": seconds, "bytes": bytes,
            "sample": { "runs": count, "ok": ok }, "columns": columns.iter().map(|(column, _)| column).collect::<Vec<_>>(),
        }))
    };
    args.format.print(report, data)
}
