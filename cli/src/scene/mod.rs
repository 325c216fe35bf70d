//! Scene files: TOML → validated SI parameters. All faults of a file are collected in one run, see
//! [`diagnostics`](crate::document::diagnostics); values have the units of [`units`](crate::document::units).
//!
#![doc = include_str!("../../../docs/scene.md")]

pub mod common;
mod coupling;
mod follower;
pub mod forces;
pub mod geometry;
mod load;
mod models;
pub mod motion_law;
mod motor;
mod parametric;
pub mod plan;
mod standstill;
mod table;
#[cfg(test)]
mod tests;
pub mod train;
#[cfg(not(target_arch = "wasm32"))]
pub mod variable;

pub use table::{Courses, course, courses};

#[cfg(not(target_arch = "wasm32"))]
use crate::document::Diagnostic;
use crate::document::source;
#[cfg(not(target_arch = "wasm32"))]
use crate::document::source::{SCENE, is_fmu};
use crate::document::{Diagnostics, Document, Kind, Section, TableNote, input};
use camdrive_design::forces::{Loads, Machine};
#[cfg(not(target_arch = "wasm32"))]
use camdrive_design::host::{MODEL, REFERENCES, unpacked};
use camdrive_design::resource::{Resource, Scene, Tool};
use std::path::{Path, PathBuf};

/// A validated scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    /// A C identifier.
    pub name: String,
    /// The description by the user, with notes on smoothed tables and on loads that do not affect its motion.
    pub description: String,
    /// Model and values.
    pub scene: Scene,
    /// The tools behind mechanisms with a prescribed motion.
    pub tools: Vec<Tool>,
    /// Its smoothed tables.
    pub smoothed: Vec<TableNote>,
    /// The geometries of its cams.
    pub cams: Vec<geometry::CamPlan>,
    /// Loads on the follower of each cam in addition to its masses.
    pub loads: Vec<Loads>,
    /// Remarks for the user that are no faults.
    pub notes: Vec<String>,
    /// The files it comes from: scene and tables.
    pub files: Vec<PathBuf>,
    /// The files of its tables.
    pub tables: Vec<source::TableFile>,
    /// The document it comes from.
    pub document: Document,
    /// The folder of its tables.
    pub folder: PathBuf,
}

impl Resolved {
    /// The resource for an FMU, with an empty guid.
    pub fn resource(&self) -> Resource {
        let plan = |j: usize| self.cams.iter().find(|cam| cam.follower.unwrap_or(1) == j + 1).map(|cam| cam.plan);
        let contacts = self.loads.iter().enumerate().map(|(j, loads)| (plan(j), loads.clone())).collect();
        Resource { tools: self.tools.clone(), contacts, ..Resource::new(&self.name, self.scene.clone()) }
    }

    /// Names and contents of the files in an FMU from which the same scene can be read: `scene.toml` and its tables.
    pub fn sources(&self) -> Vec<(String, Vec<u8>)> {
        source::all(&Document::new(self.document.whole_text()), &self.tables)
    }
}

/// Reads and validates a scene file: every value, and whether the drive can be built and started with them.
pub fn read(path: &Path) -> Result<Resolved, Diagnostics> {
    let (file, document) = input::document(path, Kind::Scene)?;
    let mut scene = resolve_document(&file, &document, path.parent().unwrap_or(Path::new("")))?;
    scene.files.push(path.to_owned());
    Ok(scene)
}

/// Reads a scene, or the scene in an FMU.
///
/// # Errors
/// The faults of the scene; an FMU without a scene.
#[cfg(not(target_arch = "wasm32"))]
pub fn open(path: &Path) -> Result<Resolved, Diagnostics> {
    if !is_fmu(path) {
        return read(path);
    }
    let file = path.display().to_string();
    let fault = |message: &str, hint: &str| Diagnostics(vec![Diagnostic::new(&file, message).hint(hint)]);
    let folder = unpacked(path, &[&format!("{}/", REFERENCES)]).map_err(|unreadable| {
        fault(&unreadable.sentence(), unreadable.hint.as_deref().unwrap_or("name a scene, or an FMU of one"))
    })?;
    let place = folder.path().join(REFERENCES).join(MODEL).join(SCENE);
    if !place.is_file() {
        let hint = "older FMUs and FMUs of other tools have no scene inside: name the scene itself; `camdrive run` drives any FMU";
        return Err(fault("the FMU holds no scene", hint));
    }
    let (inside, within) = (place.with_file_name("").display().to_string(), format!("{file}/"));
    // Messages about the files name the FMU, not the temporary folder.
    let told = |text: String| text.replace(&inside.replace('\\', "/"), &within).replace(&inside, &within);
    let mut scene = read(&place).map_err(|Diagnostics(faults)| {
        let fault = |fault: Diagnostic| Diagnostic { file: told(fault.file), message: told(fault.message), ..fault };
        Diagnostics(faults.into_iter().map(fault).collect())
    })?;
    scene.notes = scene.notes.into_iter().map(told).collect();
    scene.files = vec![path.to_owned()];
    Ok(scene)
}

/// The scene in `text`, the content of `file`; `folder` contains its tables.
///
/// ```
/// use camdrive_cli::scene;
///
/// let text = r#"
/// name = "bar"
/// model = "ElasticCamDrive"
/// cam = { law = "fourier", a = [0, "1 mm"] }
/// drive = { speed = "600 rpm" }
/// elasticity = { place = "output", m = "12 kg", natural_frequency = "270 Hz" }
/// "#;
/// let drive = scene::resolve("bar.toml", text, "".as_ref()).unwrap().resource().build().unwrap();
/// assert!(drive.descriptions().iter().any(|d| d.name == "der(y)" && d.text == "Velocity of the mass"));
///
/// let faults = scene::resolve("bar.toml", &text.replace("12 kg", "12 m"), "".as_ref()).unwrap_err().to_string();
/// assert!(faults.contains("bar.toml:6") && faults.contains("`elasticity.m`"), "{faults}");
/// ```
pub fn resolve(file: &str, text: &str, folder: &Path) -> Result<Resolved, Diagnostics> {
    resolve_document(file, &Document::new(text.to_owned()), folder)
}

/// The scene of a document, changed or not.
pub fn resolve_document(file: &str, document: &Document, folder: &Path) -> Result<Resolved, Diagnostics> {
    let mut resolved = variant(file, document, folder)?;
    let left_out = Machine::of(&resolved.resource()).ok().and_then(Machine::left_out);
    resolved.notes.extend(left_out.clone());
    for sentence in resolved.smoothed.iter().map(|table| &table.sentence).chain(&left_out) {
        let own = resolved.description.trim_end_matches('.');
        let stop = if own.is_empty() { "" } else { ". " };
        // Notes begin with a small letter, sentences do not.
        let (first, rest) = sentence.split_at(sentence.find(char::is_whitespace).unwrap_or(0));
        let first = if first.contains('.') { first.to_owned() } else { capitalised(first) };
        resolved.description = format!("{own}{stop}{first}{rest}.");
    }
    Ok(resolved)
}

/// The scene of a document with the user's own description, which spares the search for speeds of lift-off.
///
/// # Errors
/// The faults of its keys, and what its drive refuses.
pub fn variant(file: &str, document: &Document, folder: &Path) -> Result<Resolved, Diagnostics> {
    input::read(file, document, Kind::Scene, |root| {
        let mut resolved = whole_scene(root, folder)?;
        if root.faults.is_empty() {
            models::try_out(&resolved, root.faults);
        }
        if let Scene::DriveTrain(scene) = &resolved.scene
            && root.faults.is_empty()
        {
            resolved.notes.extend(standstill::check(root, scene));
        }
        Some(resolved)
    })
}

/// The scene of a document as it stands there: nothing of it is tried out, and its description is the user's own.
///
/// # Errors
/// The faults of its keys.
pub fn as_written(file: &str, document: &Document, folder: &Path) -> Result<Resolved, Diagnostics> {
    input::read(file, document, Kind::Scene, |root| whole_scene(root, folder))
}

/// The word with a capital letter.
fn capitalised(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The scene; None after a reported fault.
fn whole_scene(root: &Section<'_>, folder: &Path) -> Option<Resolved> {
    let name = root.name();
    let description = root.text("description").map(|text| text.unwrap_or_default().trim().to_owned());
    let drive = models::drive(root, folder);
    let smoothed = root.faults.smoothed.take();
    let cams = geometry::all(root, drive.as_ref());
    let loads = forces::all(root, drive.as_ref(), cams.as_deref().unwrap_or_default());
    let (scene, name, description, cams, loads) = (drive?, name?, description?, cams?, loads?);
    let tables = root.faults.tables.take();
    Some(Resolved {
        name,
        description,
        scene,
        tools: root.faults.tools.take(),
        smoothed,
        cams,
        loads,
        notes: root.faults.notes(),
        files: tables.iter().map(|table| table.path.clone()).collect(),
        tables,
        document: root.faults.document.clone(),
        folder: folder.to_owned(),
    })
}
