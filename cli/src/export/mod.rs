//! From a validated scene to an FMU.
//!
//! [`pack`] builds the drive once more, as the runtime library will, and writes the files for importers: [`model_description`],
//! [`documentation`], a [`picture`], [`terminals`], licences and a bill of materials, in one [`archive`] with the
//! [`runtime_library`].

pub mod archive;
pub mod date;
pub mod documentation;
pub mod hash;
mod licenses;
pub mod model_description;
pub mod picture;
pub mod png;
pub mod references;
pub mod results;
pub mod runtime_library;
pub mod sbom;
pub mod terminals;
#[cfg(test)]
mod test_drive;
pub use camdrive_design::xml::writer as xml;

pub use date::Date;
pub use runtime_library::RuntimeLibrary;

use archive::File;
use camdrive::drives::Fault;
use camdrive::drives::resource::{self, Content};
use camdrive_design::resource::{Described, LONGEST_NAME, Resource, is_name};
use model_description::Identity;
use results::Results;

/// The name and version of this tool.
pub const TOOL: &str = concat!("camdrive ", env!("CARGO_PKG_VERSION"));

/// The page that computes, next to the documentation.
pub const LIVE: &str = "live.html";

/// The page that FMI 2.0 requires for the documentation.
const DOCUMENTATION: &str = "documentation/index.html";

/// An FMU in memory.
#[derive(Clone, Debug)]
pub struct Packed {
    /// The zip archive.
    pub bytes: Vec<u8>,
    /// The guid: a hash of the content.
    pub guid: String,
    /// Path and size of each file inside.
    pub files: Vec<(String, usize)>,
    /// The number of its variables.
    pub variables: usize,
    /// The number of its continuous states.
    pub states: usize,
}

/// Optional content of an FMU.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extras<'a> {
    /// [`terminals`].
    pub terminals: bool,
    /// Names and contents of the scene and its tables, for `extra/`. Comments in a scene do not change the drive: the guid is the
    /// same without them.
    pub sources: &'a [(String, Vec<u8>)],
    /// The page that computes; the guid is the same without it.
    pub live: Option<&'a str>,
}

/// The text of modelDescription.xml without packing an FMU; the guid, a hash of the packed content, is empty.
pub fn describe(resource: &Resource, description: &str) -> Result<String, Fault> {
    check_name(&resource.name)?;
    let drive = &mut resource.build()?;
    let identity = Identity { name: &resource.name, description: &stated(description, drive)?, guid: "", date: None };
    model_description::xml(&identity, drive)
}

/// The description, or the first sentence about the model.
fn stated(description: &str, drive: &Described) -> Result<String, Fault> {
    let (own, summary) = (xml::legal(description), drive.documentation()?.summary);
    let first = || summary.split_inclusive(". ").next().unwrap_or_default();
    Ok(Some(own.trim()).filter(|own| !own.is_empty()).unwrap_or_else(first).trim_end().to_owned())
}

/// Packs the FMU of a scene; computes the guid from the content and ignores the guid of `resource`.
///
/// # Errors
/// A name that [`is_name`] refuses, a scene that the drive refuses, two libraries for one platform.
pub fn pack(
    resource: &Resource,
    description: &str,
    runtimes: &[RuntimeLibrary],
    date: Option<Date>,
    extras: Extras,
) -> Result<Packed, Fault> {
    let (drive, scene) = (&mut resource.build()?, &resource.scene.encoded()?);
    Contents { drive, scene, resource, description, date }.packed(runtimes, extras)
}

/// The parts of an FMU without the libraries.
struct Contents<'a> {
    drive: &'a mut Described,
    /// The scene for the library.
    scene: &'a [u8],
    resource: &'a Resource,
    description: &'a str,
    date: Option<Date>,
}

impl Contents<'_> {
    fn packed(mut self, runtimes: &[RuntimeLibrary], extras: Extras) -> Result<Packed, Fault> {
        let (resource, description, date) = (self.resource, self.description, self.date);
        check_name(&resource.name)?;
        check_platforms(runtimes)?;
        let libraries: Vec<File> = runtimes
            .iter()
            .map(|library| File::new(library.path_in_fmu(&resource.name), library.bytes.as_slice()))
            .collect();
        let platforms: Vec<&str> = runtimes.iter().map(|library| library.platform).collect();
        let mut page = documentation::Page { description, platforms: &platforms, results: None, live: false };
        let mut content = self.with_guid("")?;
        content.extend(for_people(self.drive, resource, &page)?);
        if extras.terminals {
            content.extend(terminals::files(self.drive)?);
        }
        content.extend(libraries);
        let parts: Vec<&[u8]> =
            content.iter().flat_map(|file| [file.path.as_bytes(), file.content.as_slice()]).collect();
        let guid = hash::guid(&hash::sha256_of_parts(&parts));
        let mut replace = |file: File| {
            if let Some(place) = content.iter_mut().find(|other| other.path == file.path) {
                *place = file;
            }
        };
        self.with_guid(&guid)?.into_iter().for_each(&mut replace);
        let results = Results::of(self.drive)?;
        page.results = Some(&results);
        page.live = extras.live.is_some();
        replace(File::new(DOCUMENTATION, documentation::html(resource, self.drive, &page)?));
        if let Some(text) = extras.live {
            content.push(File::new(format!("documentation/{LIVE}"), text));
            content.extend([licenses::of_page(), sbom::of_page()]);
        }
        content.extend(references::files(extras.sources, &results)?);
        let bytes =
            archive::archive(&content, date).map_err(|e| Fault::new(format!("the archive cannot be written: {e}")))?;
        let descriptions = self.drive.descriptions();
        Ok(Packed {
            bytes,
            guid,
            files: content.iter().map(|file| (file.path.clone(), file.content.len())).collect(),
            variables: descriptions.len(),
            states: descriptions.iter().filter(|d| d.state).count(),
        })
    }

    /// The files with the guid.
    fn with_guid(&mut self, guid: &str) -> Result<Vec<File>, Fault> {
        let date = self.date.map(Date::iso);
        let description = &stated(self.description, self.drive)?;
        let identity = Identity { name: &self.resource.name, description, guid, date: date.as_deref() };
        let xml = model_description::xml(&identity, self.drive)?;
        let content = Content { model: self.resource.model(), guid, scene: self.scene };
        Ok(vec![
            File::new("modelDescription.xml", xml),
            File::new(format!("resources/{}", resource::FILE_NAME), content.to_bytes()?),
        ])
    }
}

/// Documentation, pictures and licences.
fn for_people(drive: &mut Described, resource: &Resource, page: &documentation::Page<'_>) -> Result<Vec<File>, Fault> {
    let curves = drive.curves();
    let mut files = Vec::new();
    if !curves.is_empty() {
        files.push(File::new("model.png", png::png(&picture::icon(&curves), picture::ICON)?));
    }
    files.push(File::new(DOCUMENTATION, documentation::html(resource, drive, page)?));
    files.extend(licenses::files(&licenses::linked()?));
    files.push(sbom::file());
    Ok(files)
}

fn check_name(name: &str) -> Result<(), Fault> {
    let fault = || {
        Fault::new(format!(
            "the name `{name}` is not a C identifier of 1 to {LONGEST_NAME} letters, digits and underscores, or is a device of \
             Windows; it names the library inside the FMU"
        ))
    };
    is_name(name).then_some(()).ok_or_else(fault)
}

fn check_platforms(runtimes: &[RuntimeLibrary]) -> Result<(), Fault> {
    for (i, library) in runtimes.iter().enumerate() {
        if let Some(other) = runtimes[..i].iter().find(|other| other.platform == library.platform) {
            return Err(Fault::new(format!(
                "two runtime libraries for {}: {} and {}",
                library.platform,
                other.path.display(),
                library.path.display()
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use test_drive::{lag, resource};

    fn library(content: &[u8]) -> RuntimeLibrary {
        RuntimeLibrary { platform: "linux64", path: "lib.so".into(), bytes: content.to_vec() }
    }

    fn packed(name: &str, description: &str, runtimes: &[RuntimeLibrary]) -> Result<Packed, Fault> {
        let (drive, resource) = (&mut lag(), &resource(name));
        Contents { drive, scene: &[], resource, description, date: None }.packed(runtimes, Extras::default())
    }

    #[test]
    fn the_same_scene_gives_the_same_bytes_and_any_difference_another_guid() {
        let pack = |name: &str, text: &str, content: &[u8]| packed(name, text, &[library(content)]).unwrap();
        let fmu = pack("Lag", "A lag", b"1");
        assert_eq!(fmu.bytes, pack("Lag", "A lag", b"1").bytes);
        for other in [pack("Lag2", "A lag", b"1"), pack("Lag", "Another lag", b"1"), pack("Lag", "A lag", b"2")] {
            assert_ne!(other.guid, fmu.guid);
        }
        assert_eq!((fmu.variables, fmu.states), (8, 1));
        assert_eq!(fmu.files[0].0, "modelDescription.xml");
    }

    #[test]
    fn an_fmu_has_a_description_even_where_the_scene_gives_none() {
        let described = |own: &str| {
            let (drive, resource) = (&mut lag(), &resource("Lag"));
            let mut contents = Contents { drive, scene: &[], resource, description: own, date: None };
            let files = contents.with_guid("").unwrap();
            let xml = String::from_utf8(files[0].content.clone()).unwrap();
            xml.split(" description=\"").nth(1).unwrap().split('"').next().unwrap().to_owned()
        };
        assert_eq!(described("A lag"), "A lag");
        for none in ["", " \u{1} "] {
            assert_eq!(described(none), "A lag &amp; nothing &lt;else&gt;.");
        }
    }

    #[test]
    fn names_and_platforms_are_checked() {
        for name in ["", "2fast", "a b", "größe", "a_name_of_twenty_five_char", "con", "Lpt1"] {
            assert!(packed(name, "", &[]).is_err(), "{name}");
        }
        assert!(["comb", "COM", "con1", "nul_", "com12", "_"].into_iter().all(is_name));
        let twice = [library(b"1"), library(b"2")];
        let fault = packed("Lag", "", &twice).unwrap_err();
        assert!(fault.message.contains("two runtime libraries for linux64"));
    }
}
