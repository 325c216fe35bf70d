//! Gives the command line its origin: the commit, the compiler and its standard library.

use std::process::Command;

fn main() {
    let rustc = std::env::var("RUSTC").unwrap_or_else(|_| "rustc".to_owned());
    let version = output(&rustc, &["--version"]);
    println!("cargo::rustc-env=CAMDRIVE_RUSTC={}", version.split(' ').nth(1).unwrap_or("unknown"));
    println!("cargo::rerun-if-changed=build.rs");
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
