//! The licences of the runtime library and the packages linked into it, for the FMU.

use super::archive::File;
use camdrive::drives::Fault;
use serde::Deserialize;

const FOLDER: &str = "documentation/licenses";

/// The packages in the runtime library from packaging/linked.toml, all used under the Apache licence 2.0, and the linker's
/// additions.
#[derive(Deserialize)]
pub struct Linked {
    pub packages: Vec<String>,
    #[cfg(test)]
    pub by_linker: Vec<(String, String)>,
}

/// The list in packaging/linked.toml.
pub fn linked() -> Result<Linked, Fault> {
    let list = include_str!("../../../packaging/linked.toml");
    toml::from_str(list).map_err(|e| Fault::new(format!("packaging/linked.toml: {e}")))
}

/// The files of `documentation/licenses`; the standard requires the entry `license.txt` (section 2.3).
pub fn files(linked: &Linked) -> Vec<File> {
    vec![
        File::new(format!("{FOLDER}/license.txt"), overview(linked)),
        File::new(format!("{FOLDER}/THIRD-PARTY.txt"), include_str!("../../../packaging/third_party.txt")),
        File::new(format!("{FOLDER}/LICENSE-MIT.txt"), include_str!("../../../LICENSE-MIT")),
        File::new(format!("{FOLDER}/LICENSE-APACHE.txt"), include_str!("../../../LICENSE-APACHE")),
    ]
}

/// The licences of the page that computes.
pub fn of_page() -> File {
    File::new(format!("{FOLDER}/live.txt"), include_str!("../../../packaging/page_licenses.txt"))
}

fn overview(linked: &Linked) -> String {
    let mut text = String::from(
        "The runtime library of camdrive in this FMU is licensed under either of\n\n\
         \x20 - the MIT licence (LICENSE-MIT.txt),\n\
         \x20 - the Apache licence, version 2.0 (LICENSE-APACHE.txt),\n\n\
         at your option.\n\n\
         It contains the Rust standard library with its parts (THIRD-PARTY.txt) and these packages, each\n\
         used under the Apache licence, version 2.0 (LICENSE-APACHE.txt):\n\n",
    );
    for name in &linked.packages {
        text.push_str(&format!("  {name}\n"));
    }
    text.push_str("\nSource code: the registry of the Rust packages, under the names above.\n");
    text
}
