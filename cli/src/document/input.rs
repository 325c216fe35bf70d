//! The files of users: reads them up to a limit, and distinguishes them from files of another kind.

use super::diagnostics::{Diagnostic, Diagnostics, nearest};
use super::keys::{self, KeyTable};
use super::section::{Faults, Section};
use super::source::is_fmu;
use super::{Document, TomlTable as Values};
use camdrive_design::text::reason;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Error, ErrorKind, Read as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Some editors start a UTF-8 file with this mark; they do not count it as a column.
pub const BYTE_ORDER_MARK: char = '\u{feff}';

/// The largest file (bytes), so that an endless device does not fill the memory: the most points of a table in lines of 800
/// characters.
const LARGEST: u64 = 16_000_000;

/// Kind of a TOML file.
#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
pub enum Kind {
    /// A drive.
    Scene,
    /// For `camdrive synthesize`.
    Task,
    /// For `camdrive study`.
    Study,
    /// For `camdrive system`.
    System,
}

impl Kind {
    /// The name of the kind for files and commands.
    pub fn word(self) -> &'static str {
        match self {
            Kind::Scene => "scene",
            Kind::Task => "task",
            Kind::Study => "study",
            Kind::System => "system",
        }
    }

    /// Its keys.
    pub fn keys(self) -> &'static KeyTable {
        match self {
            Kind::Scene => &keys::SCENE,
            Kind::Task => &keys::TASK,
            Kind::Study => &keys::STUDY,
            Kind::System => &keys::SYSTEM,
        }
    }

    /// The kind of file in messages about unknown keys.
    pub fn of_keys(self) -> &'static str {
        match self {
            Kind::Scene => "a scene of this kind",
            Kind::Task => "a task",
            Kind::Study => "a study",
            Kind::System => "a system",
        }
    }

    /// The fault of the whole file if its keys show that it holds something else.
    pub fn mistaken(self, file: &str, document: &Values) -> Result<(), Diagnostics> {
        let has = |key: &str| document.get(key).is_some();
        let study = has("vary") || has("measures");
        let system = has("part") && !has("model");
        let task = !has("model") && (has("objective") || has("harmonics"));
        let found = match self {
            Kind::System if !has("part") && has("model") => {
                Some(("a scene", "a system names it: [part.machine] scene = \"machine.toml\"".to_owned()))
            }
            Kind::System if !has("part") && study => Some(("a study", format!("`camdrive study {file}` runs it"))),
            Kind::Scene | Kind::Task if system => {
                Some(("a system", format!("`camdrive system {file}` writes its FMUs, `check` and `run` take it")))
            }
            Kind::Scene | Kind::Task if study && !has("model") && !has("objective") => {
                Some(("a study", format!("`camdrive study {file}` runs it")))
            }
            Kind::Study if !study && has("model") => {
                Some(("a scene", "a study names it: scene = \"scene.toml\"".to_owned()))
            }
            Kind::Study if system => Some((
                "a system",
                format!("`camdrive run {file}` and `check` take it; a study of it names it: scene = \"system.toml\""),
            )),
            Kind::Scene | Kind::Study | Kind::System if task => {
                Some(("a motion task", format!("`camdrive synthesize {file}` makes a cam profile from it")))
            }
            Kind::Scene if document.len() == 1 && has("cam") => Some((
                "a cam profile",
                format!("add `name`, `model` and the sections of the drive, or append {file} to a scene without [cam]"),
            )),
            Kind::Task if has("model") && !has("objective") => Some((
                "a scene",
                format!(
                    "`camdrive check {file}`, `describe` and `export` take it; with --scene {file} a motion task gives it a cam"
                ),
            )),
            _ => None,
        };
        found.map_or(Ok(()), |(what, hint)| Err(self.other(file, what, hint)))
    }

    /// The fault of a file with other content.
    fn other(self, file: &str, what: &str, hint: impl Into<String>) -> Diagnostics {
        Diagnostics(vec![Diagnostic::new(file, format!("this is {what}, not a {}", self.word())).hint(hint)])
    }
}

/// True if a file has the name of a system archive.
pub fn is_archive(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("ssp"))
}

/// True if a file is a system: an archive, or a readable file with parts.
pub fn is_system(path: &Path) -> bool {
    if is_archive(path) {
        return true;
    }
    has(path, Kind::System, &["part"])
}

/// True if a file is readable and a study.
pub fn is_study(path: &Path) -> bool {
    has(path, Kind::Study, &["vary", "measures"])
}

/// True if a file is readable, is no scene and has one of these keys.
fn has(path: &Path, kind: Kind, keys: &[&str]) -> bool {
    let Ok((_, document)) = document(path, kind) else { return false };
    let has = |key: &str| document.table.contains_key(key);
    keys.iter().any(|key| has(key)) && !has("model")
}

/// The contents of pipes and devices, which can be read only once, and of the files of a page, which has no others.
static STREAMS: Mutex<BTreeMap<PathBuf, Vec<u8>>> = Mutex::new(BTreeMap::new());

/// Holds the content of a file for [`bytes`].
pub fn hold(path: &Path, content: Vec<u8>) {
    STREAMS.lock().unwrap_or_else(PoisonError::into_inner).insert(path.to_owned(), content);
}

/// The bytes of a file, a pipe or the start of a device, or of the standard input `-`.
///
/// # Errors
/// A file that cannot be read or is too large.
pub fn bytes(path: &Path) -> Result<Vec<u8>, Error> {
    let mut streams = STREAMS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(bytes) = streams.get(path) {
        return Ok(bytes.clone());
    }
    let standard = path == Path::new("-");
    if !standard && std::fs::metadata(path)?.is_file() {
        return content(File::open(path)?);
    }
    let bytes = if standard { content(std::io::stdin()) } else { content(File::open(path)?) }?;
    streams.insert(path.to_owned(), bytes.clone());
    Ok(bytes)
}

fn content(file: impl std::io::Read) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    file.take(LARGEST + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > LARGEST {
        true => Err(Error::new(ErrorKind::FileTooLarge, format!("it has more than {} MB", LARGEST / 1_000_000))),
        false => Ok(bytes),
    }
}

/// The text of bytes in UTF-16: with a mark, or without one if the first two characters are ASCII. The outer None means another
/// encoding, the inner None damage.
pub fn utf16(bytes: &[u8]) -> Option<Option<String>> {
    let (rest, unit): (&[u8], fn([u8; 2]) -> u16) = match bytes {
        [0xff, 0xfe, rest @ ..] => (rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => (rest, u16::from_be_bytes),
        [1..=127, 0, 1..=127, 0, ..] => (bytes, u16::from_le_bytes),
        [0, 1..=127, 0, 1..=127, ..] => (bytes, u16::from_be_bytes),
        _ => return None,
    };
    let units: Vec<u16> = rest.chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
    Some(String::from_utf16(&units).ok().filter(|text| !text.contains('\0')))
}

/// The hint about FMUs.
pub const NAMED: &str = "an FMU is read from a file with a name that ends in .fmu, not from a pipe; \
                         `camdrive run NAME.fmu` simulates it";

/// The kind of a file from another program, by its bytes.
pub fn foreign(bytes: &[u8]) -> Option<&'static str> {
    let has = |name: &[u8]| bytes.windows(name.len()).any(|part| part == name);
    match bytes {
        [b'P', b'K', 3, 4, ..] if has(b"xl/workbook") => Some("a workbook (.xlsx)"),
        [b'P', b'K', 3, 4, ..] if has(b"opendocument.spreadsheet") => Some("a workbook (.ods)"),
        [b'P', b'K', 3, 4, ..] => Some("an FMU or another zip archive"),
        [0xd0, 0xcf, 0x11, 0xe0, ..] => Some("a workbook (.xls) or another document of an office program"),
        [b'%', b'P', b'D', b'F', ..] => Some("a PDF document"),
        _ => None,
    }
}

/// The file with the most similar name in the folder of a missing one.
fn similar(path: &Path) -> Option<String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let files = std::fs::read_dir(folder).ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let ending = format!(".{}", path.extension()?.to_str()?);
    let mut stems: Vec<String> = files.filter_map(|name| Some(name.strip_suffix(&ending)?.to_owned())).collect();
    stems.sort();
    let known: Vec<&str> = stems.iter().map(String::as_str).collect();
    let near = nearest(path.file_stem()?.to_str()?, &known)?;
    Some(path.with_file_name(near.to_owned() + &ending).display().to_string())
}

/// The name of a file, and its content.
///
/// # Errors
/// A file that cannot be read or is no such text.
pub fn document(path: &Path, kind: Kind) -> Result<(String, Document), Diagnostics> {
    let (file, word) = (path.display().to_string(), kind.word());
    let name_one = format!("name a {word} file, for example {word}.toml");
    if path.is_dir() {
        return Err(kind.other(&file, "a folder", name_one));
    }
    let whole = |message: String| Diagnostics(vec![Diagnostic::new(&file, message).hint(name_one.clone())]);
    let bytes = bytes(path).map_err(|e| {
        let message = format!("the {word} cannot be read: {}", reason(&e));
        let near = similar(path).filter(|_| e.kind() == ErrorKind::NotFound);
        let hint = near.map_or(name_one.clone(), |name| format!("did you mean `{name}`?"));
        Diagnostics(vec![Diagnostic::new(&file, message).hint(hint)])
    })?;
    if let Some(what) = foreign(&bytes) {
        let of_fmu = match is_fmu(path) {
            true => "an FMU is made from a scene; `camdrive run NAME.fmu` drives it".to_owned(),
            false => NAMED.to_owned(),
        };
        return Err(kind.other(&file, what, if what.contains("FMU") { of_fmu } else { name_one }));
    }
    let wide = utf16(&bytes);
    if wide.as_ref().map_or(bytes.contains(&0), Option::is_none) {
        return Err(whole(format!("the {word} is not a text file")));
    }
    let text = wide.flatten().map_or_else(|| String::from_utf8(bytes), Ok).map_err(|e| {
        let good = e.utf8_error().valid_up_to();
        let text = String::from_utf8_lossy(e.as_bytes());
        let fault = Diagnostic::new(&file, format!("the {word} is not UTF-8 text")).at(&text, good..good + 1);
        Diagnostics(vec![fault.hint("save it with the encoding UTF-8")])
    })?;
    let text = text.trim_start_matches(BYTE_ORDER_MARK).to_owned();
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')).peekable();
    match lines.peek().and_then(|line| line.chars().next()) {
        Some('<') => Err(kind.other(&file, "XML", name_one)),
        Some('{') => Err(kind.other(&file, "JSON", name_one)),
        None if kind == Kind::System => {
            Err(kind.other(&file, "an empty file", "a system has parts: [part.machine] scene = \"machine.toml\""))
        }
        Some(_) if lines.all(|line| !line.contains('=') && !line.starts_with('[')) => {
            let hint =
                format!("{name_one}; a scene names a table of a motion law: law = \"table\", file = \"lift.csv\"");
            Err(kind.other(&file, "a table or another text without `key = value`", hint))
        }
        _ => Ok((file, Document::new(text))),
    }
}

/// The result of `read` on a document, if it reports no fault.
pub fn read<T>(
    file: &str,
    document: &Document,
    kind: Kind,
    read: impl FnOnce(&Section<'_>) -> Option<T>,
) -> Result<T, Diagnostics> {
    let mut faults = Faults::new(file, document);
    faults.kind = kind.of_keys();
    let text = document.file();
    for error in &document.errors {
        let span = error.span().unwrap_or(text.len()..text.len());
        let mut message = format!("no valid TOML: {}", error.message());
        if error.message() == "duplicate key" {
            message += &format!(" `{}`", text.get(span.clone()).unwrap_or_default().trim());
        }
        let unclosed = error.message().contains("array");
        let hint = match error.message() {
            _ if unclosed => Some("close the list with `]`"),
            said if said.contains("must be quoted") => {
                Some("put texts and numbers with a unit into quotes: \"1800 rpm\"")
            }
            _ => None,
        };
        faults.report(faults.at(span, message).remedy(hint.map(str::to_owned)));
        if unclosed {
            // An unclosed list takes the rest of the file for its elements, so further faults would be wrong.
            return Err(faults.into_diagnostics());
        }
    }
    kind.mistaken(file, &document.table)?;
    match read(&Section::root(&faults, &document.table, kind.keys())) {
        Some(value) if faults.is_empty() => Ok(value),
        None if faults.is_empty() => Err(Diagnostics(vec![Diagnostic::new(file, "it cannot be read")])),
        _ => Err(faults.into_diagnostics()),
    }
}
