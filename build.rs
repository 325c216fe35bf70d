//! Hashes the sources of the runtime library, so that the command line packs only libraries of its own sources.

use std::path::{Path, PathBuf};

fn main() {
    let mut files = vec![PathBuf::from("Cargo.lock"), PathBuf::from("Cargo.toml")];
    list(Path::new("src"), &mut files);
    files.sort();
    // FNV-1a, without carriage returns, which depend on the checkout.
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for file in &files {
        for byte in std::fs::read(file).unwrap_or_default().into_iter().filter(|byte| *byte != b'\r') {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    println!("cargo::rustc-env=CAMDRIVE_SOURCES={hash:016x}");
    for watched in ["Cargo.lock", "Cargo.toml", "src"] {
        println!("cargo::rerun-if-changed={watched}");
    }
}

fn list(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("the sources can be listed") {
        let path = entry.expect("the sources can be listed").path();
        if path.is_dir() { list(&path, files) } else { files.push(path) }
    }
}
