//! Gives the command line its origin: the commit, the compiler and its standard library; and a hash of the sources of pages, so
//! that it packs only a module of its own sources.

use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let version = output(&rustc, &["--version"]);
    println!("cargo::rustc-env=CAMDRIVE_RUSTC={}", version.split(' ').nth(1).unwrap_or("unknown"));
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=CAMDRIVE_PAGE={:016x}", sources());
    // Builds for tests are not repeated for every commit.
    let mut commit = String::new();
    if std::env::var("PROFILE").as_deref() == Ok("release") && output("git", &["rev-parse", "--show-prefix"]) == "cli/"
    {
        commit = output("git", &["rev-parse", "--short=12", "HEAD"]);
        println!("cargo::rerun-if-changed={}", output("git", &["rev-parse", "--git-path", "logs/HEAD"]));
    }
    println!("cargo::rustc-env=CAMDRIVE_COMMIT={}", if commit.is_empty() { "unknown" } else { &commit });
}

/// The output of the program; empty if it fails or does not exist.
fn output(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output().ok().filter(|output| output.status.success());
    output.map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned()).unwrap_or_default()
}

/// A hash (FNV-1a) of all that a page computes with, without carriage returns, which depend on the checkout.
fn sources() -> u64 {
    let mut files = ["../Cargo.lock", "../Cargo.toml"].map(PathBuf::from).to_vec();
    for folder in ["../src", "../design/src", "src", "../page/src"] {
        list(Path::new(folder), &mut files);
    }
    files.sort();
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for file in &files {
        println!("cargo::rerun-if-changed={}", file.display());
        for byte in std::fs::read(file).unwrap_or_default().into_iter().filter(|byte| *byte != b'\r') {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
    hash
}

fn list(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() { list(&path, files) } else { files.push(path) }
    }
}
