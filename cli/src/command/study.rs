//! `camdrive study STUDY`

mod store;

use super::output::counter;
use super::{Failure, Format, failure, files};
use crate::export::hash;
use crate::scene::Diagnostics;
use crate::scene::study::{self, Cell, Quantity, Study};
use camdrive::drives::{AnyDrive, Fault};
use camdrive_design::study::plan::rows_of_part;
use camdrive_design::study::run::Runner;
use camdrive_design::text::{self, Table, counted, number};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;
use store::Store;

/// Runs many variants of a scene on all cores and measures each.
///
/// A study names a scene, what varies (lists, series, random and Latin hypercube designs, rows of a CSV file), how long a run lasts
/// and what is measured of it: `max |q|`, `rms force`, `count impacts`, `y at 90 deg`, `harmonic 3 of q`. The result is a folder with
/// study.json and a folder `runs` of Parquet parts, each written whole or not at all. A run that a scene does not admit, or that
/// fails, is a row with a message. The numbers are the same for any number of threads and parts.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive study examples/guide_bar/study.toml --explain
  camdrive study examples/guide_bar/study.toml -o waves/
  camdrive study examples/guide_bar/study.toml -o waves/ --resume
  camdrive study examples/guide_bar/study.toml -o waves/ --part 3/20")]
pub struct Args {
    /// Study file (TOML)
    study: PathBuf,
    /// Folder of the store [default: study-NAME]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Say how many runs, seconds and bytes it takes, and run nothing but a sample
    #[arg(long)]
    explain: bool,
    /// Continue a store of this study: its parts are kept, missing ones computed
    #[arg(long)]
    resume: bool,
    /// Compute only share I of N of the parts, as a job of an array; the shares have one store
    #[arg(long, value_name = "I/N", value_parser = share)]
    part: Option<(u64, u64)>,
    /// Threads [default: all cores]
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    #[command(flatten)]
    format: Format,
}

/// I of N, both from 1.
fn share(text: &str) -> Result<(u64, u64), String> {
    let numbers = text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
    numbers.filter(|(i, n)| (1..=*n).contains(i)).ok_or_else(|| "it is I/N with I from 1 to N, such as 3/20".to_owned())
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Status {
    Ok,
    /// The scene or the drive does not admit the values.
    Refused,
    /// The drive could not go on.
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

/// A run as the store has it.
struct Record {
    cells: Vec<Cell>,
    /// None where the run is not `Ok`.
    values: Vec<Option<f64>>,
    status: Status,
    message: String,
}

/// What a thread needs for its runs.
struct Worker<'a> {
    study: &'a Study,
    /// Of a study in which only variables vary.
    shared: Option<(AnyDrive, Runner<'a>)>,
}

impl<'a> Worker<'a> {
    fn new(study: &'a Study) -> Result<Self, Fault> {
        let shared = match study.is_keyed() {
            true => None,
            false => {
                let drive = study.scene.resource().build()?.plan().instance();
                let runner = Runner::new(&drive, &study.window, &study.measures)?;
                Some((drive, runner))
            }
        };
        Ok(Worker { study, shared })
    }

    /// A run; what panics is a run that failed, and the next one begins anew.
    fn run(&mut self, row: u64) -> Record {
        let cells = self.study.cells(row);
        let outcome = catch_unwind(AssertUnwindSafe(|| self.measured(&cells)));
        let outcome = outcome.unwrap_or_else(|_| Err((Status::Failed, "the drive broke down".to_owned())));
        let (values, status, message) = match outcome {
            Ok(values) => (values.into_iter().map(Some).collect(), Status::Ok, String::new()),
            Err((status, message)) => (vec![None; self.study.measures.len()], status, message),
        };
        Record { cells, values, status, message }
    }

    fn measured(&mut self, cells: &[Cell]) -> Result<Vec<f64>, (Status, String)> {
        let refused = |fault: Fault| (Status::Refused, fault.to_string());
        let study = self.study;
        let set = |drive: &mut AnyDrive| {
            drive.set_up(0.0, None);
            for (quantity, cell) in study.quantities.iter().zip(cells) {
                let (Some(reference), Cell::Number(value)) = (quantity.variable, cell) else { continue };
                // A scene of its own may have the variable in another place.
                let own = drive.descriptions().get(reference).is_some_and(|d| d.name == quantity.name);
                let place = if own {
                    Some(reference)
                } else {
                    drive.descriptions().iter().position(|d| d.name == quantity.name)
                };
                let place =
                    place.ok_or_else(|| Fault::new(format!("this scene has no variable `{}`", quantity.name)))?;
                drive.set(place, *value)?;
            }
            drive.start()
        };
        let failed = |fault: Fault| (Status::Failed, fault.to_string());
        if let Some((drive, runner)) = &mut self.shared {
            drive.reset();
            set(drive).map_err(refused)?;
            return runner.run(drive).map_err(failed);
        }
        let told = |Diagnostics(faults): Diagnostics| {
            let messages: Vec<&str> = faults.iter().map(|fault| fault.message.as_str()).collect();
            (Status::Refused, messages.join("; "))
        };
        let scene = study.variant(cells).map_err(told)?;
        let mut drive = scene.resource().build().map_err(refused)?;
        set(&mut drive).map_err(refused)?;
        let runner = Runner::new(&drive, &study.window, &study.measures).map_err(refused)?;
        runner.run(&mut drive).map_err(failed)
    }
}

/// The rows of a part while they come in.
struct Part {
    rows: Vec<Option<Record>>,
    left: usize,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let study = study::read(&args.study).map_err(|faults| Failure(faults.to_string()))?;
    let stem = args.study.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let named = if stem == "study" { study.scene.name.clone() } else { stem.clone() };
    let folder = files::folder(args.output.as_deref(), "study", &named)?;
    let rows = study.rows();
    let size = rows_of_part(rows);
    let threads = args.threads.map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    let columns = columns(&study);
    if args.explain {
        return explain(args, &study, threads, &columns, size);
    }
    let wrong = |fault: Fault| failure(format!("{}: {fault}", args.study.display()));
    let store = Store::open(&folder, &specification(&study, &columns, size)?, args.resume || args.part.is_some())?;
    let (i, n) = args.part.unwrap_or((1, 1));
    let parts: Vec<u64> = (0..rows.div_ceil(size)).filter(|part| part % n == i - 1 && !store.has(*part)).collect();
    let of_part = |part: u64| part * size..rows.min((part + 1) * size);
    let ends: Vec<u64> = parts
        .iter()
        .scan(0, |sum, part| {
            *sum += of_part(*part).count() as u64;
            Some(*sum)
        })
        .collect();
    let total = ends.last().copied().unwrap_or(0);
    let bar = counter(&stem, total);
    let begin = Instant::now();
    let (next, stop) = (AtomicU64::new(0), AtomicBool::new(false));
    let open: Mutex<BTreeMap<u64, Part>> = Mutex::default();
    let gathered: Mutex<Vec<[f64; 4]>> =
        Mutex::new(vec![[0.0, f64::INFINITY, f64::NEG_INFINITY, 0.0]; study.measures.len()]);
    let counts = [(); 3].map(|()| AtomicU64::new(0));
    let broken: Mutex<Option<Failure>> = Mutex::default();
    let first_message: Mutex<BTreeMap<Status, (u64, String)>> = Mutex::default();
    let work = |mut worker: Worker<'_>| {
        while !stop.load(Ordering::Relaxed) {
            let taken = next.fetch_add(1, Ordering::Relaxed);
            if taken >= total {
                break;
            }
            let place = ends.partition_point(|end| *end <= taken);
            let range = of_part(parts[place]);
            let row = range.end - (ends[place] - taken);
            let record = worker.run(row);
            counts[record.status as usize].fetch_add(1, Ordering::Relaxed);
            if record.status != Status::Ok {
                let mut first = held(&first_message);
                let known = first.entry(record.status).or_insert((row, record.message.clone()));
                if row < known.0 {
                    *known = (row, record.message.clone());
                }
            }
            for (sum, value) in held(&gathered).iter_mut().zip(&record.values) {
                if let Some(value) = *value {
                    *sum = [sum[0] + value, sum[1].min(value), sum[2].max(value), sum[3] + 1.0];
                }
            }
            let whole = {
                let mut open = held(&open);
                let count = (range.end - range.start) as usize;
                let part = open
                    .entry(parts[place])
                    .or_insert_with(|| Part { rows: (0..count).map(|_| None).collect(), left: count });
                part.rows[(row - range.start) as usize] = Some(record);
                part.left -= 1;
                if part.left == 0 { open.remove(&parts[place]) } else { None }
            };
            if let Some(whole) = whole {
                let rows: Vec<Record> = whole.rows.into_iter().flatten().collect();
                if let Err(failure) = store.write(parts[place], range.start, &columns, &rows) {
                    stop.store(true, Ordering::Relaxed);
                    held(&broken).get_or_insert(failure);
                }
            }
            bar.inc(1);
        }
    };
    let workers =
        (0..threads.min(total as usize)).map(|_| Worker::new(&study)).collect::<Result<Vec<_>, _>>().map_err(wrong)?;
    std::thread::scope(|scope| {
        for worker in workers {
            scope.spawn(|| work(worker));
        }
    });
    bar.finish_and_clear();
    if let Some(failure) = held(&broken).take() {
        return Err(failure);
    }
    let seconds = begin.elapsed().as_secs_f64();
    let [ok, refused, failed] = counts.map(AtomicU64::into_inner);
    let missing = (0..rows.div_ceil(size)).filter(|part| !store.has(*part)).count();
    let place = text::in_one_line(folder.display());
    let report = |_| {
        let there = (0..rows.div_ceil(size)).filter(|part| store.has(*part)).map(|part| of_part(part).count() as u64);
        let kept = there.sum::<u64>().saturating_sub(total);
        let mut out = format!("{place}: {} in {}", counted(total, "run"), text::time(seconds));
        if kept > 0 {
            out += &format!(", {} in other parts", counted(kept, "run"));
        }
        out += &format!("; {ok} ok, {refused} refused, {failed} failed\n");
        for (status, (row, message)) in held(&first_message).iter() {
            out += &format!("first {}: run {row}: {message}\n", status.word());
        }
        if missing > 0 {
            out += &format!("{} of the study are not there yet\n", counted(missing, "part"));
        }
        let digits = |value: f64| text::digits(value, 5, -4);
        let line = |(measure, [sum, least, largest, count]): (&_, &[f64; 4])| {
            let unit =
                &columns.iter().find(|column| column.name == format!("{measure}")).map_or("", |column| &column.unit);
            vec![format!("{measure}"), unit.to_string(), digits(*least), digits(sum / count), digits(*largest)]
        };
        let gathered = held(&gathered);
        let lines = study.measures.iter().zip(gathered.iter()).filter(|(_, sums)| sums[3] > 0.0).map(line);
        let table = Table::new("measure  unit  least  mean  largest", lines);
        if kept > 0 && !table.rows.is_empty() {
            out += "of the runs of this call:\n";
        }
        if table.rows.is_empty() { out } else { out + &table.text(usize::MAX) + "\n" }
    };
    let data = || {
        let gathered = held(&gathered);
        let measures = study.measures.iter().zip(gathered.iter());
        let measures = measures.map(|(measure, [sum, least, largest, count])| {
            json!({ "measure": measure.to_string(), "least": least, "mean": sum / count, "largest": largest })
        });
        text::json(&json!({
            "measures": measures.collect::<Vec<_>>(),
            "store": folder, "scene": study.place, "tables": study.tables,
            "rows": rows, "computed": total, "ok": ok, "refused": refused, "failed": failed,
            "missing_parts": missing, "seconds": seconds, "threads": threads,
            "columns": columns.iter().map(Column::data).collect::<Vec<_>>(),
        }))
    };
    args.format.print(report, data)
}

fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A column of the store.
pub struct Column {
    /// Its name.
    pub name: String,
    /// Empty where it has none.
    pub unit: String,
    /// What it is.
    pub meaning: String,
    /// Which part of a record it is.
    content: Content,
}

/// What a column has of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Content {
    Run,
    Varied(usize),
    Text(usize),
    Measured(usize),
    Status,
    Message,
}

impl Column {
    fn data(&self) -> Value {
        let role = match self.content {
            Content::Varied(_) | Content::Text(_) => "varied",
            Content::Measured(_) => "measured",
            _ => "run",
        };
        json!({ "name": self.name, "role": role, "unit": self.unit, "meaning": self.meaning })
    }
}

/// The columns of the store of a study.
fn columns(study: &Study) -> Vec<Column> {
    let column = |name: &str, unit: &str, meaning: &str, content: Content| Column {
        name: name.to_owned(),
        unit: unit.to_owned(),
        meaning: meaning.to_owned(),
        content,
    };
    let mut columns = vec![column("run", "", "Number of the run, from 0", Content::Run)];
    for (i, Quantity { name, unit, meaning, is_text, .. }) in study.quantities.iter().enumerate() {
        columns.push(column(name, unit, meaning, if *is_text { Content::Text(i) } else { Content::Varied(i) }));
    }
    for (i, (measure, [unit, meaning])) in study.measures.iter().zip(&study.measured).enumerate() {
        columns.push(column(&measure.to_string(), unit, meaning, Content::Measured(i)));
    }
    columns.push(column("status", "", "ok, refused or failed", Content::Status));
    columns.push(column("message", "", "Why the run was refused or failed", Content::Message));
    columns
}

/// What study.json says: all on which the numbers depend.
fn specification(study: &Study, columns: &[Column], rows_of_part: u64) -> Result<String, Failure> {
    let [text, scene] = &study.texts;
    let digest = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        [name, hash::hexadecimal(&hash::sha256(&std::fs::read(path).unwrap_or_default()))]
    };
    text::json(&json!({
        "format": 1,
        "tool": crate::export::TOOL,
        "commit": env!("CAMDRIVE_COMMIT"),
        "name": study.scene.name,
        "model": study.scene.scene.said(),
        "study": text,
        "scene": scene,
        "tables": study.tables.iter().map(digest).collect::<Vec<_>>(),
        "rows": study.rows(),
        "rows_of_part": rows_of_part,
        "axes": study.dimensions(),
        "lengths": study.lengths(),
        "sampled": study.is_sampled(),
        "columns": columns.iter().map(Column::data).collect::<Vec<_>>(),
    }))
    .map_err(failure)
}

/// Fewer rows than this are sampled in their order.
const FEW: u64 = 100;

/// How long a sample of the runs is measured (s).
const SAMPLE: f64 = 0.5;

/// Says what the study would take.
fn explain(args: &Args, study: &Study, threads: usize, columns: &[Column], size: u64) -> Result<(), Failure> {
    let wrong = |fault: Fault| failure(format!("{}: {fault}", args.study.display()));
    let mut worker = Worker::new(study).map_err(wrong)?;
    let (rows, begin) = (study.rows(), Instant::now());
    let (mut count, mut bytes, mut ok) = (0u64, 0, 0u64);
    // Multiples of the golden ratio spread evenly over the rows, however many are taken.
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
            "sample": { "runs": count, "ok": ok }, "columns": columns.iter().map(Column::data).collect::<Vec<_>>(),
        }))
    };
    args.format.print(report, data)
}
