//! Files in an FMU to trace and check it, in the layout of the layered standard FMI-LS-REF (1.0.0-alpha.1): the scene and its
//! tables for another export, inputs and outputs of its default experiment.

use super::archive::File;
use super::results::Results;
use super::xml::Xml;
use camdrive::drives::Fault;
pub use camdrive_design::host::{MODEL, REFERENCES as FOLDER};
use std::fmt::Write as _;

/// The table of the results in it.
pub const RESULT: &str = "result.csv";

/// The table of the inputs in it.
pub const INPUT: &str = "input.csv";

/// The rule for values between two rows.
pub const CONVENTION: &str = "Continuous inputs are linear between the rows, with fmi2SetRealInputDerivatives if \
canInterpolateInputs is true; with an input a, phi and w follow from it instead. Outputs are read after the inputs of their row have been set.";

/// The files in `extra/`: the manifest, the sources by name, the scene first, and inputs and results of the experiment.
///
/// # Errors
/// Errors of the tables of results.
pub fn files(sources: &[(String, Vec<u8>)], results: &Results) -> Result<Vec<File>, Fault> {
    let (inputs, outputs) = (results.inputs()?, results.csv()?);
    let mut files = Vec::new();
    let mut manifest = Xml::document();
    let attributes = [
        ("xmlns:fmi-ls", "http://fmi-standard.org/fmi-ls-manifest"),
        ("fmi-ls:fmi-ls-name", "org.fmi-standard.fmi-ls-ref"),
        ("fmi-ls:fmi-ls-version", "1.0.0-alpha.1"),
        ("fmi-ls:fmi-ls-description", "Layered Standard providing information on related files included in an FMU."),
    ];
    manifest.element("fmiReferences", &attributes.map(|(key, value)| (key, value.to_owned())), |xml| {
        let mut related = |name: String, content: &[u8], role: &str, description: &str| {
            let media = match name.rsplit('.').next().unwrap_or_default() {
                "toml" => "application/toml",
                "csv" => "text/csv",
                _ => "text/plain",
            };
            let attributes = [("type", media), ("source", &uri(&name)), ("role", role), ("description", description)];
            xml.empty("Related", &attributes.map(|(key, value)| (key, value.to_owned())));
            files.push(File::new(format!("{FOLDER}/{name}"), content));
        };
        for (i, (name, content)) in sources.iter().enumerate() {
            let description = if i == 0 { "Scene of the FMU" } else { "Table of the scene" };
            related(format!("{MODEL}/{name}"), content, "model", description);
        }
        if let Some(inputs) = inputs {
            related(
                INPUT.to_owned(),
                inputs.as_bytes(),
                "testcase",
                &format!("Inputs over the default experiment. {CONVENTION}"),
            );
        }
        let until = if results.whole { String::new() } else { format!(" up to t = {} s", results.end()) };
        let description = format!("Outputs over the default experiment{until}");
        related(RESULT.to_owned(), outputs.as_bytes(), "result", &description);
    });
    files.insert(0, File::new(format!("{FOLDER}/fmi-ls-manifest.xml"), manifest.finish()));
    Ok(files)
}

/// A relative URI of a path.
fn uri(path: &str) -> String {
    path.bytes().fold(String::new(), |mut uri, byte| {
        match byte {
            b'/' | b'-' | b'.' | b'_' | b'~' => uri.push(byte.into()),
            _ if byte.is_ascii_alphanumeric() => uri.push(byte.into()),
            _ => write!(uri, "%{byte:02X}").unwrap_or_default(),
        }
        uri
    })
}
