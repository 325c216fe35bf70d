//! Wrong scenes and what is said of them: `tests/scenes/x.toml` ↔ `tests/scenes/x.txt`.
//!
//! `BLESS=1 cargo test --test scenes` writes the messages anew; look at the difference before keeping it.
#![cfg(feature = "cli")]

use std::path::{Path, PathBuf};

/// The files of `tests/scenes` with this extension, by name.
fn files(extension: &str) -> Vec<PathBuf> {
    let folder = Path::new("tests/scenes");
    let entries = std::fs::read_dir(folder).expect("tests/scenes is there");
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("a directory entry").path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == extension));
    files.sort();
    files
}

#[test]
fn wrong_scenes_get_the_stored_messages() {
    let bless = std::env::var_os("BLESS").is_some_and(|v| v == "1");
    let mut different = Vec::new();
    for scene in files("toml") {
        // The same path on every platform, since it is part of the message.
        let name = scene.to_string_lossy().replace('\\', "/");
        let faults = match camdrive::scene::read(Path::new(&name)) {
            Ok(_) => panic!("{name} should have faults"),
            Err(faults) => faults.to_string(),
        };
        let expected = scene.with_extension("txt");
        if bless {
            std::fs::write(&expected, &faults).expect("the message can be written");
        } else if std::fs::read_to_string(&expected).unwrap_or_default().replace("\r\n", "\n") != faults {
            different.push(format!("{name} says now:\n{faults}"));
        }
    }
    assert!(different.is_empty(), "{}\nrenew with BLESS=1 cargo test --test scenes", different.join("\n"));
}

#[test]
fn every_stored_message_has_its_scene() {
    for message in files("txt") {
        assert!(message.with_extension("toml").exists(), "{} is left over", message.display());
    }
}
