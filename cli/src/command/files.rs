//! Files of several commands: reports into folders, scenes with another cam.

use super::{Failure, ending, failure, wrong_argument};
use crate::document::Document;
use camdrive::drives::Fault;
use camdrive::motion::Fourier;
use camdrive_design::report::html;
use camdrive_design::resource::is_device;
use camdrive_design::text;
use std::fs::File;
use std::io::{Error, ErrorKind, Read, Write as _};
#[cfg(unix)]
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;
use toml_edit::{Array, Table, Value, value};

/// The folder for the report of a command on this scene: from `-o`, or a new one.
pub fn folder(output: Option<&Path>, command: &str, scene: &str) -> Result<PathBuf, Failure> {
    let folder = output.map_or_else(|| PathBuf::from(format!("{command}-{scene}")), Path::to_owned);
    no_file(&folder, "-o").map(|()| folder)
}

/// Refuses a folder for a report, from this option, if a file has this name or the name looks like a file's.
pub fn no_file(folder: &Path, option: &str) -> Result<(), Failure> {
    no_stream(folder, option, "a folder")?;
    let refused = |message: &str| wrong_argument(format!("{}: {message}", folder.display()));
    if folder.is_file() {
        return Err(refused(&format!("this is a file; {option} takes a folder")));
    }
    match is_folder(folder) || folder.extension().is_none() {
        true => Ok(()),
        false => Err(refused(&format!("{option} takes a folder")).hint("the name of a new folder ends with /")),
    }
}

/// True if this is a folder or has a name like one.
pub fn is_folder(path: &Path) -> bool {
    path.is_dir() || path.as_os_str().to_string_lossy().ends_with(std::path::is_separator)
}

/// Why a file is not replaced.
fn not_ours(path: &Path) -> Failure {
    failure(format!("{}: no command wrote this file; it is kept", path.display())).hint(ANOTHER)
}

/// The hint for a file that is not replaced.
pub const ANOTHER: &str = "choose another -o, or replace it with --force";

/// A part of the first line of every scene and profile that a command writes.
const ORIGIN: &str = " by camdrive ";

/// A scene or a profile from this file, with a first line that names its origin.
pub fn signed(document: &Document, what: &str, of: &Path, command: &str) -> String {
    let file = text::in_one_line(of.file_name().unwrap_or_default().display());
    format!("# {what} of {file}{ORIGIN}{command}.\n{}", document.whole_text())
}

/// Refuses a target of `-o` without the name of a scene or profile, and, without `--force`, a target that no command wrote.
pub fn no_foreign(path: &Path, inputs: &[PathBuf], force: bool) -> Result<(), Failure> {
    no_stream(path, "-o", "a file")?;
    no_input(path, inputs)?;
    let place = path.display();
    if is_folder(path) {
        return Err(wrong_argument(format!("{place}: this is a folder; -o takes a file NAME.toml")));
    }
    if path.extension().is_some_and(|ending| !ending.eq_ignore_ascii_case("toml")) {
        return Err(wrong_argument(format!("{place}: a scene or a profile is TOML")).hint("-o takes a file NAME.toml"));
    }
    let is_signed = |text: String| text.lines().next().is_some_and(|line| line.contains(ORIGIN));
    if path.is_file() && !force && !std::fs::read_to_string(path).is_ok_and(is_signed) {
        return Err(not_ours(path));
    }
    Ok(())
}

/// Refuses to replace an input with a result.
fn no_input(path: &Path, inputs: &[PathBuf]) -> Result<(), Failure> {
    match inputs.iter().find(|input| real(input).is_some_and(|input| Some(input) == real(path))) {
        Some(input) => Err(failure(format!("{}: the result would overwrite an input", input.display()))),
        None => Ok(()),
    }
}

fn real(path: &Path) -> Option<PathBuf> {
    std::fs::canonicalize(path).ok()
}

/// Refuses `-`, the standard output of other commands, and new files and folders with names that Windows does not admit.
pub fn no_stream(path: &Path, option: &str, takes: &str) -> Result<(), Failure> {
    let mut new = path.ancestors().filter(|place| !place.is_dir()).filter_map(Path::file_name);
    if new.any(|name| is_device(name.to_string_lossy().split('.').next().unwrap_or_default())) {
        return Err(wrong_argument(format!("{}: Windows has a device of this name", path.display()))
            .hint(format!("choose another {option}")));
    }
    match path == Path::new("-") {
        true => {
            Err(wrong_argument(format!("{option} -: {option} takes {takes}; the report goes to the standard output")))
        }
        false => Ok(()),
    }
}

/// Writes all files or none: if one cannot be written, existing files stay. Earlier results are replaced, inputs never. Returns the
/// lines that name the files.
pub fn write<C: AsRef<[u8]>>(files: &[(PathBuf, C)], inputs: &[PathBuf]) -> Result<String, Failure> {
    let writing = ending::writing();
    let written = write_files(files, inputs);
    drop(writing);
    let (lines, streams) = written?;
    // A pipe may wait endlessly for its reader.
    for (path, content) in streams {
        std::fs::write(path, content).map_err(|e| unwritten(path, &e))?;
    }
    Ok(lines)
}

/// Refuses to replace inputs and, without `--force`, files that no command wrote.
pub fn keep<C: AsRef<[u8]>>(files: &[(PathBuf, C)], inputs: &[PathBuf], force: bool) -> Result<(), Failure> {
    files.iter().try_for_each(|(path, _)| no_input(path, inputs))?;
    let foreign = |(path, content): &&(PathBuf, C)| path.is_file() && !is_result(path, content.as_ref());
    match files.iter().find(foreign) {
        Some((path, _)) if !force => Err(not_ours(path)),
        _ => Ok(()),
    }
}

/// True if the file is a result of the same kind: a page has its mark, all other files begin alike except for numbers. A table next
/// to a page may differ in the columns after the first.
fn is_result(path: &Path, new: &[u8]) -> bool {
    let head = |file: &mut dyn Read| {
        let mut bytes = Vec::new();
        let read = file.take(HEAD).read_to_end(&mut bytes);
        read.map(|_| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default()
    };
    let of = |path: &Path| File::open(path).map_or(String::new(), |mut file| head(&mut file));
    let (old, new) = (of(path), head(&mut &new[..]));
    if new.contains(html::MARK) {
        return old.contains(html::MARK);
    }
    let is_digit = |c: char| c.is_ascii_digit() || ".-".contains(c);
    // The second line of JSON contains its first field.
    let lines = |text: &str| text.lines().take(if text.starts_with('{') { 2 } else { 1 }).collect::<String>();
    // The title of a picture may change.
    let untitled = |text: &str| text.split(" aria-label=").next().unwrap_or_default().replace(is_digit, "");
    let [old, new] = [old, new].map(|text| untitled(&lines(&text)));
    let first = |text: &str| text.split([',', ';']).next().unwrap_or_default().to_owned();
    let page = || of(&path.with_extension("").with_extension("html")).contains(html::MARK);
    old == new || (path.extension() == Some("csv".as_ref()) && first(&old) == first(&new) && page())
}

/// The length of the head of a file that shows its kind (bytes).
const HEAD: u64 = 2000;

/// The lines that name all files, and the devices and pipes, which are still to be written.
fn write_files<'a, C: AsRef<[u8]>>(
    files: &'a [(PathBuf, C)],
    inputs: &[PathBuf],
) -> Result<(String, Vec<&'a (PathBuf, C)>), Failure> {
    let (mut staged, mut streams, mut lines) = (Vec::new(), Vec::new(), String::new());
    for (i, file) in files.iter().enumerate() {
        let (path, content) = file;
        no_input(path, inputs)?;
        if files[..i].iter().any(|(other, _)| other == path) {
            return Err(failure(format!("{}: two results would be written here", path.display())));
        }
        match stage(path, content.as_ref()).map_err(|e| unwritten(path, &e))? {
            Some(hidden) => staged.push((path, hidden)),
            None => streams.push(file),
        }
        if ending::is_near() {
            return Err(failure("ended by a signal"));
        }
        lines += &format!("{}{}\n", text::in_one_line(path.display()), if path.is_file() { " (replaced)" } else { "" });
    }
    // Every obstacle has been met by now: a move within a folder needs no space.
    for (path, hidden) in staged {
        hidden.persist(real(path).as_deref().unwrap_or(path)).map_err(|e| unwritten(path, &e.error))?;
    }
    Ok((lines, streams))
}

fn unwritten(path: &Path, reason: &Error) -> Failure {
    failure(format!("{} cannot be written: {reason}", path.display())).hint("existing files are unchanged")
}

/// The content in a file next to its place; it vanishes unless it is moved there. None for a device or a pipe, which has no content
/// to keep.
fn stage(path: &Path, content: &[u8]) -> Result<Option<NamedTempFile<File>>, Error> {
    let former = std::fs::metadata(path).ok();
    match &former {
        Some(former) if former.is_dir() => return Err(Error::new(ErrorKind::IsADirectory, "it is a folder")),
        Some(former) if !former.is_file() => return Ok(None),
        Some(former) if former.permissions().readonly() => {
            return Err(Error::new(ErrorKind::PermissionDenied, "it is write-protected"));
        }
        _ => (),
    }
    // A link keeps its target.
    let place = real(path).unwrap_or(path.to_owned());
    let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if let Some(file) = folder.ancestors().find(|place| place.exists()).filter(|place| !place.is_dir()) {
        let message = format!("{} is a file, not a folder; choose another place", file.display());
        return Err(Error::new(ErrorKind::NotADirectory, message));
    }
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::Builder::new().prefix(".").make_in(folder, |path| File::create_new(path))?;
    file.as_file_mut().write_all(content)?;
    // Some file systems report only now that they are full.
    file.as_file().sync_all()?;
    if let Some(former) = former {
        let permissions = former.permissions();
        // The permission to run with the rights of the owner was given to other content.
        #[cfg(unix)]
        let permissions = std::fs::Permissions::from_mode(permissions.mode() & 0o777);
        file.as_file().set_permissions(permissions)?;
    }
    Ok(Some(file))
}

/// A table or a diagram, with the ending of its file.
pub type Part<S> = (S, Result<String, Fault>);

/// The parts of a report as files NAME.ending in a folder.
pub fn report<S: std::fmt::Display>(
    folder: &Path,
    name: &str,
    parts: impl IntoIterator<Item = Part<S>>,
) -> Result<Vec<(PathBuf, Vec<u8>)>, Failure> {
    let place = |ending: S| folder.join(format!("{name}.{ending}"));
    let file = |(ending, content): Part<S>| Ok((place(ending), content.map_err(failure)?.into_bytes()));
    parts.into_iter().map(file).collect()
}

/// The table `[cam]` of a law, its coefficients as multiples of `scale` (m).
pub fn cam(law: &Fourier, scale: f64) -> Table {
    // Small coefficients have an exponent; either form is read back to the same bits.
    let number = |x: f64| if x.abs() < 1e-3 && x != 0.0 { format!("{x:e}") } else { format!("{x:?}") };
    let parsed = |x: &f64| {
        // A zero has no sign.
        let x = x / scale + 0.0;
        number(x).parse::<Value>().unwrap_or_else(|_| x.into())
    };
    let list = |list: &[f64]| value(list.iter().map(parsed).collect::<Array>());
    let mut table = Table::new();
    table["law"] = value("fourier");
    if scale != 1.0 {
        table["scale"] = value(format!("{scale:?} m"));
    }
    table["a"] = list(&law.a);
    table["b"] = list(&law.b[1..]);
    table
}
