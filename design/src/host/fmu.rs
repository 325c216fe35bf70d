//! An FMU from a file or of a scene: its description, its folder and its library.

use super::description::ModelDescription;
use super::functions::Functions;
use super::process::{Idle, Process, isolates};
use crate::resource::Resource;
use camdrive::drives::Fault;
use camdrive::drives::resource::{BUILD, FILE_NAME};
use libloading::Library;
use std::fmt::Display;
use std::fs::File;
use std::io::{Read, Seek, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use tempfile::TempDir;
use zip::ZipArchive;

/// The most bytes to unpack: an archive of a few bytes may hold any number of zeros.
const LARGEST: u64 = 4_000_000_000;

/// The largest modelDescription.xml (bytes).
const LARGEST_DESCRIPTION: u64 = 200_000_000;

/// The file that every FMU has in its archive.
pub const DESCRIPTION: &str = "modelDescription.xml";

/// The folder with the sources for tracing and checking an FMU, by the layered standard FMI-LS-REF.
pub const REFERENCES: &str = "extra/org.fmi-standard.fmi-ls-ref";

/// The folder of its model in it, which has the scene of our FMUs.
pub const MODEL: &str = "model";

/// An FMU 2.0 of Co-Simulation that is ready to be instantiated, also by several threads. Its folder is removed with its last
/// instance.
pub struct Fmu(pub(super) Arc<Content>);

/// The parts of an FMU that all instances share. The library is unloaded before its folder is removed.
pub(super) struct Content {
    pub description: ModelDescription,
    pub runtime: Runtime,
    /// True if the library is of this tool's own sources.
    pub is_own: bool,
    pub folder: PathBuf,
    /// None in a process that serves a library: the one that started it removes the folder.
    _removed: Option<TemporaryFolder>,
}

/// The place in which the library of an FMU runs.
pub(super) enum Runtime {
    /// In this process; the library in this tool if none is loaded.
    Here { functions: Arc<Functions>, _library: Option<Library> },
    /// Each instance in a process of its own.
    Apart(Arc<Idle>),
}

impl Runtime {
    fn here(functions: Functions, _library: Option<Library>) -> Self {
        Runtime::Here { functions: Arc::new(functions), _library }
    }
}

impl Fmu {
    /// Opens an FMU, and loads its library; a foreign one into a process of its own.
    ///
    /// # Errors
    /// With the path: a file that is no FMU 2.0 of Co-Simulation, that has no library for this platform, or one that cannot be
    /// loaded; a temporary folder that cannot be written.
    pub fn open(path: &Path) -> Result<Self, Fault> {
        let of_file = |fault: Fault| fault.within(crate::text::in_one_line(path.display()));
        opened(path, "FMU").and_then(Fmu::unpacked).map_err(of_file)
    }

    fn unpacked(file: File) -> Result<Self, Fault> {
        let mut archive = ZipArchive::new(file).map_err(|e| no_fmu(&e))?;
        let mut text = Vec::new();
        let entry = archive.by_name(DESCRIPTION).map_err(|_| no_fmu(&format!("{DESCRIPTION} is not in it")))?;
        entry.take(LARGEST_DESCRIPTION).read_to_end(&mut text).map_err(|e| no_fmu(&e))?;
        let description = described(text)?;
        let names: Vec<String> = archive.file_names().map(|name| name.replace('\\', "/")).collect();
        let library = library(&description, |path| names.iter().any(|name| name == path));
        let library = library.ok_or_else(|| without_platform(&names))?;
        let binaries = &library[..=library.rfind('/').unwrap_or(0)];
        let folder = unpack(&mut archive, &[binaries, "resources/", DESCRIPTION])?;
        let path = folder.path().join(&library);
        let read = std::fs::read(&path).map_err(|e| no_folder(&e))?;
        // A library names the sources that it is made of.
        let (build, first) = (BUILD.as_bytes(), BUILD.as_bytes()[0]);
        let is_own = read.windows(build.len()).any(|part| part[0] == first && part == build);
        let runtime = if is_own || !isolates() {
            Functions::load(&path).map(|(functions, library)| Runtime::here(functions, Some(library)))
        } else {
            Process::start(folder.path()).map(|process| {
                let idle = Arc::<Idle>::default();
                idle.keep(process);
                Runtime::Apart(idle)
            })
        };
        let runtime = runtime.map_err(|fault| description.not_started(fault))?;
        let (path, _removed) = (folder.path().to_owned(), Some(folder));
        Ok(Fmu(Arc::new(Content { description, runtime, is_own, folder: path, _removed })))
    }

    /// The FMU that was unpacked into this folder, its library loaded into this process.
    ///
    /// # Errors
    /// The errors of [`Fmu::open`].
    pub(super) fn loaded(folder: &Path) -> Result<Self, Fault> {
        let description = described(std::fs::read(folder.join(DESCRIPTION)).map_err(|e| no_folder(&e))?)?;
        let library = library(&description, |path| folder.join(path).is_file());
        let (functions, library) = Functions::load(&folder.join(library.ok_or_else(|| without_platform(&[]))?))?;
        let runtime = Runtime::here(functions, Some(library));
        let folder = folder.to_owned();
        Ok(Fmu(Arc::new(Content { description, runtime, is_own: false, folder, _removed: None })))
    }

    /// The FMU of a scene by the library in this tool.
    ///
    /// # Errors
    /// A scene that its drive refuses; a temporary folder that cannot be written.
    pub fn linked(resource: &Resource) -> Result<Self, Fault> {
        let description = ModelDescription::of(&resource.name, &resource.guid, &mut resource.build()?)?;
        let folder = TemporaryFolder::new()?;
        let resources = folder.path().join("resources");
        let written = || {
            std::fs::create_dir(&resources)?;
            std::fs::write(resources.join(FILE_NAME), resource.to_bytes().map_err(std::io::Error::other)?)
        };
        written().map_err(|e| no_folder(&e))?;
        let runtime = Runtime::here(Functions::linked(), None);
        let (path, _removed) = (folder.path().to_owned(), Some(folder));
        Ok(Fmu(Arc::new(Content { description, runtime, is_own: true, folder: path, _removed })))
    }

    /// Its model description.
    pub fn description(&self) -> &ModelDescription {
        &self.0.description
    }
}

impl Content {
    /// The URI of the resources.
    pub fn location(&self) -> String {
        let mut uri = "file://".to_owned();
        let path = self.folder.join("resources");
        let bytes = path.as_os_str().as_encoded_bytes();
        // Before the drive of Windows.
        if !bytes.starts_with(b"/") {
            uri.push('/');
        }
        for byte in bytes {
            match byte {
                b'\\' if cfg!(windows) => uri.push('/'),
                b'/' | b':' | b'-' | b'_' | b'.' | b'~' => uri.push(char::from(*byte)),
                _ if byte.is_ascii_alphanumeric() => uri.push(char::from(*byte)),
                _ => uri += &format!("%{byte:02X}"),
            }
        }
        uri
    }
}

/// The model description of this text.
fn described(text: Vec<u8>) -> Result<ModelDescription, Fault> {
    // Text that is not UTF-8 in spite of the standard is mostly Latin-1, and only in texts.
    let text = String::from_utf8(text).unwrap_or_else(|e| e.into_bytes().into_iter().map(char::from).collect());
    ModelDescription::read(&text).map_err(|fault| fault.within(DESCRIPTION))
}

/// The library for this platform among the files that an FMU has.
fn library(description: &ModelDescription, has: impl Fn(&str) -> bool) -> Option<String> {
    let file = format!("{}{}", description.identifier, std::env::consts::DLL_SUFFIX);
    platforms().iter().map(|platform| format!("binaries/{platform}/{file}")).find(|path| has(path))
}

fn no_fmu(why: &dyn Display) -> Fault {
    let hint = "an FMU is a zip archive with the description of its model; `camdrive export` makes one of a scene";
    Fault::new(format!("this is no FMU: {why}")).hint(hint)
}

fn no_folder(why: &dyn Display) -> Fault {
    let folder = std::env::temp_dir();
    Fault::new(format!("the archive cannot be unpacked into the temporary folder {}: {why}", folder.display()))
}

/// A folder that vanishes when it is dropped, or with the program.
#[derive(Debug)]
pub struct TemporaryFolder(TempDir);

/// The existing folders.
static FOLDERS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

impl TemporaryFolder {
    fn new() -> Result<Self, Fault> {
        let folder = tempfile::Builder::new().prefix("camdrive-").tempdir().map_err(|e| no_folder(&e))?;
        FOLDERS.lock().unwrap_or_else(PoisonError::into_inner).push(folder.path().to_owned());
        Ok(TemporaryFolder(folder))
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Removes all, because a signal ends the program without dropping anything.
    pub fn remove_all() {
        for folder in FOLDERS.lock().unwrap_or_else(PoisonError::into_inner).iter() {
            let _ = std::fs::remove_dir_all(folder);
        }
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        FOLDERS.lock().unwrap_or_else(PoisonError::into_inner).retain(|folder| folder != self.0.path());
    }
}

fn damaged(why: &dyn Display) -> Fault {
    Fault::new(format!("the archive is damaged: {why}"))
}

/// A file that can be read from its end, like an archive.
fn opened(path: &Path, what: &str) -> Result<File, Fault> {
    let unread = |e: &dyn Display| Fault::new(format!("the {what} cannot be read: {e}"));
    let about = std::fs::metadata(path).map_err(|e| unread(&e))?;
    match about.is_file() || about.is_dir() {
        true => File::open(path).map_err(|e| unread(&e)),
        // Opening a pipe would wait for its other end.
        false => Err(unread(&"it is a pipe or a device; an archive is a file")),
    }
}

/// The files below these folders of an FMU or another archive in a temporary folder, without its other files.
///
/// # Errors
/// A file that is no archive; a temporary folder that cannot be written.
pub fn unpacked(path: &Path, folders: &[&str]) -> Result<TemporaryFolder, Fault> {
    let archive =
        ZipArchive::new(opened(path, "archive")?).map_err(|e| Fault::new(format!("this is no zip archive: {e}")));
    unpack(&mut archive?, folders)
}

/// Writes the files below these folders of the archive to a temporary one.
fn unpack<R: Read + Seek>(archive: &mut ZipArchive<R>, folders: &[&str]) -> Result<TemporaryFolder, Fault> {
    let target = TemporaryFolder::new()?;
    let mut left = LARGEST;
    for i in 0..archive.len() {
        let entry = archive.by_index(i).map_err(|e| damaged(&e))?;
        let name = entry.name().replace('\\', "/");
        if name.ends_with('/') || !folders.iter().any(|folder| name.starts_with(folder)) {
            continue;
        }
        let path = entry.enclosed_name().ok_or_else(|| damaged(&format!("\"{name}\" leads out of its folder")))?;
        let path = target.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap_or(target.path())).map_err(|e| no_folder(&e))?;
        let mut file = File::create(path).map_err(|e| no_folder(&e))?;
        let count =
            std::io::copy(&mut entry.take(left), &mut file).map_err(|e| damaged(&format!("\"{name}\": {e}")))?;
        file.flush().map_err(|e| no_folder(&e))?;
        left -= count;
        if left == 0 {
            return Err(damaged(&format!("it holds more than {} GB", LARGEST / 1_000_000_000)));
        }
    }
    // Not every archive has an empty folder, but the instance gets its name.
    std::fs::create_dir_all(target.path().join("resources")).map_err(|e| no_folder(&e))?;
    Ok(target)
}

/// The folders of libraries for this platform, the one for its processor alone first. FMI 2.0 names operating system and word
/// length only.
pub fn platforms() -> &'static [&'static str] {
    let wide = cfg!(target_pointer_width = "64");
    match std::env::consts::OS {
        "linux" if cfg!(target_arch = "aarch64") => &["aarch64-linux", "linux64"],
        "linux" => {
            if wide {
                &["linux64"]
            } else {
                &["linux32"]
            }
        }
        "windows" => {
            if wide {
                &["win64"]
            } else {
                &["win32"]
            }
        }
        "macos" if cfg!(target_arch = "aarch64") => &["aarch64-darwin", "darwin64"],
        "macos" => {
            if wide {
                &["darwin64"]
            } else {
                &["darwin32"]
            }
        }
        _ => &[],
    }
}

fn without_platform(names: &[String]) -> Fault {
    let inside = names.iter().filter_map(|name| name.strip_prefix("binaries/")?.split_once('/'));
    let mut inside: Vec<&str> = inside.filter(|(_, file)| !file.is_empty()).map(|(platform, _)| platform).collect();
    inside.sort_unstable();
    inside.dedup();
    let inside = if inside.is_empty() { "none".to_owned() } else { inside.join(", ") };
    let here = platforms().first().copied().unwrap_or(std::env::consts::OS);
    let hint = "export it for this platform; for a scene use `camdrive export --platforms`";
    Fault::new(format!("the FMU has no library for {here}; it has libraries for {inside}")).hint(hint)
}
