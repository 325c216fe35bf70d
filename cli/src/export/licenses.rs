//! The licences of the runtime library and of the crates that are linked into it, as the FMU carries them.

use super::archive::File;

const FOLDER: &str = "documentation/licenses";

/// The crates of the runtime library; all may be used under the Apache licence 2.0.
const APACHE: [&str; 9] =
    ["cfg-if", "cobs", "crc32fast", "num-complex", "num-traits", "postcard", "serde", "serde_core", "thiserror"];

/// All crates of the list.
pub fn crates() -> impl Iterator<Item = &'static str> {
    APACHE.into_iter()
}

/// The files of `documentation/licenses`; `license.txt` is the entry that the standard names (section 2.3).
pub fn files() -> Vec<File> {
    vec![
        File::new(format!("{FOLDER}/license.txt"), overview()),
        File::new(format!("{FOLDER}/THIRD-PARTY.txt"), include_str!("third_party.txt")),
        File::new(format!("{FOLDER}/LICENSE-MIT.txt"), include_str!("../../../LICENSE-MIT")),
        File::new(format!("{FOLDER}/LICENSE-APACHE.txt"), include_str!("../../../LICENSE-APACHE")),
    ]
}

fn overview() -> String {
    let mut text = String::from(
        "The runtime library of camdrive in this FMU is licensed under either of\n\n\
         \x20 - the MIT licence (LICENSE-MIT.txt),\n\
         \x20 - the Apache licence, version 2.0 (LICENSE-APACHE.txt),\n\n\
         at your option.\n\n\
         Into it are linked the Rust standard library with what belongs to it (THIRD-PARTY.txt) and these packages, each\n\
         used under the Apache licence, version 2.0 (LICENSE-APACHE.txt):\n\n",
    );
    for name in APACHE {
        text.push_str(&format!("  {name}\n"));
    }
    text.push_str("\nSource code: the registry of the Rust packages, under the names above.\n");
    text
}
