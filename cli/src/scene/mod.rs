//! Scene files: TOML → validated SI parameters. All faults of a file are collected in one run, see [`diagnostics`];
//! the units of a value are those of [`units`].
//!
#![doc = include_str!("../../../docs/scene.md")]

mod common;
pub mod coupled;
mod coupling;
pub mod diagnostics;
pub mod document;
mod follower;
pub mod forces;
pub mod geometry;
pub mod input;
pub mod keys;
mod limits;
mod load;
mod models;
pub mod motion_law;
mod motor;
mod parametric;
pub mod plan;
pub mod reference;
pub mod schema;
mod section;
pub mod source;
mod standstill;
pub mod study;
pub mod synthesis;
pub mod system;
mod table;
#[cfg(test)]
mod tests;
pub mod train;
pub mod units;
pub mod variable;

pub use table::{Courses, Smoothed, course, courses};

pub use diagnostics::{Diagnostic, Diagnostics};
pub use source::SCENE;

use camdrive_design::forces::{Loads, Machine};
pub use camdrive_design::resource::LONGEST_NAME;
use camdrive_design::resource::{Resource, Scene, Tool, is_name};
use document::Document;
use input::Kind;
use section::{Faults, Section};
use std::path::{Path, PathBuf};

/// A validated scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    /// A C identifier.
    pub name: String,
    /// What the user says of it, that tables are smoothed, and which loads its motion leaves out.
    pub description: String,
    /// Model and values.
    pub scene: Scene,
    /// The tools behind mechanisms whose motion it prescribes.
    pub tools: Vec<Tool>,
    /// Its smoothed tables.
    pub smoothed: Vec<Smoothed>,
    /// The geometry of its cams, as far as the scene tells it.
    pub cams: Vec<geometry::CamPlan>,
    /// Loads on the follower of each cam beside its masses.
    pub loads: Vec<Loads>,
    /// Notes for the user that are no faults.
    pub notes: Vec<String>,
    /// The files that it was read from: scene and tables.
    pub files: Vec<PathBuf>,
    /// The tables that it names.
    tables: Vec<source::Table>,
    /// What it was read from.
    pub document: Document,
    /// Where it names its tables.
    pub folder: PathBuf,
}

impl Resolved {
    /// As an FMU carries it, with an empty guid.
    pub fn resource(&self) -> Resource {
        Resource { name: self.name.clone(), guid: String::new(), scene: self.scene.clone(), tools: self.tools.clone() }
    }

    /// Names and contents of the files that an FMU carries, from which the same scene is read: `scene.toml` and its tables.
    pub fn sources(&self) -> Vec<(String, Vec<u8>)> {
        source::all(&Document::new(self.document.whole_text()), &self.tables)
    }
}

/// Reads and validates a scene file: every value, and that the drive can be built and started with them.
pub fn read(path: &Path) -> Result<Resolved, Diagnostics> {
    let (file, document) = input::document(path, Kind::Scene)?;
    let mut scene = resolve_document(&file, &document, path.parent().unwrap_or(Path::new("")))?;
    scene.files.push(path.to_owned());
    Ok(scene)
}

/// The scene `text` of the file `file`; tables are looked for in `folder`.
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

/// The scene of a document, as it was read or changed.
pub fn resolve_document(file: &str, document: &Document, folder: &Path) -> Result<Resolved, Diagnostics> {
    with_document(file, document, Kind::Scene, |root| {
        let mut resolved = whole_scene(root, folder)?;
        if root.faults.is_empty() {
            models::try_out(&resolved, root.faults);
            if let Scene::DriveTrain(scene) = &resolved.scene
                && root.faults.is_empty()
            {
                resolved.notes.extend(standstill::check(root, scene));
            }
            let left_out = forces::machine(&resolved).ok().and_then(Machine::left_out);
            resolved.notes.extend(left_out.clone());
            for sentence in resolved.smoothed.iter().map(|table| &table.sentence).chain(&left_out) {
                let own = resolved.description.trim_end_matches('.');
                let stop = if own.is_empty() { "" } else { ". " };
                // What notes say in small letters begins a sentence here.
                let (first, rest) = sentence.split_at(sentence.find(char::is_whitespace).unwrap_or(0));
                let first = if first.contains('.') { first.to_owned() } else { capitalised(first) };
                resolved.description = format!("{own}{stop}{first}{rest}.");
            }
        }
        Some(resolved)
    })
}

/// The word with a capital letter.
fn capitalised(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// What `read` makes of a document, if it reports no fault.
fn with_document<T>(
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
            // It takes the rest of the file for its elements: what follows would be wrong.
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

/// The scene; None where a fault was reported.
fn whole_scene(root: &Section<'_>, folder: &Path) -> Option<Resolved> {
    let name = name(root);
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

/// The name of the scene or task.
fn name(root: &Section<'_>) -> Option<String> {
    let admissible = format!(
        "letters, digits and _, no digit first, at most {LONGEST_NAME} characters; no device of Windows such as CON"
    );
    let name = root.required_text("name", &admissible, "guide_bar")?;
    if is_name(name) {
        return Some(name.to_owned());
    }
    let mut better: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !better.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
        better.insert(0, '_');
    }
    better.truncate(LONGEST_NAME);
    if !better.contains(|c: char| c.is_ascii_alphanumeric()) {
        better = "guide_bar".to_owned();
    }
    if !is_name(&better) {
        better.push('_');
    }
    let fault = root.fault_at("name", format!(": \"{name}\" cannot name an FMU")).of("name");
    root.refuse(fault.admissible(admissible).hint(format!("write for example \"{better}\"")))
}
