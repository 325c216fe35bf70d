//! The invariants of ARCHITECTURE.md, as far as a test can see them.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Which modules each module of the library may use; everything else is refused.
const MAY_USE: [(&str, &[&str]); 9] = [
    ("numerics", &[]),
    ("motion", &["numerics"]),
    ("drives", &["motion", "numerics"]),
    ("design", &["drives", "motion", "numerics", "fmi2"]),
    ("fmi2", &["drives"]),
    ("scene", &["design", "drives", "motion", "numerics"]),
    ("export", &["drives", "design"]),
    ("cli", &["scene", "export", "design", "drives", "motion", "numerics", "fmi2"]),
    ("main", &["cli"]),
];

/// The files with unsafe code: the functions of the C interface, and the host that calls them from Rust.
const UNSAFE: [&str; 2] = ["fmi2/functions.rs", "fmi2/host.rs"];

/// The modules that the runtime library consists of.
const RUNTIME: [&str; 4] = ["motion", "numerics", "drives", "fmi2"];

/// What the runtime library must not do: write to the host's terminal, end or change its process, read files other
/// than its own resource, panic on purpose.
const FORBIDDEN_IN_RUNTIME: [&str; 14] = [
    "println!",
    "print!(",
    "eprint",
    "dbg!",
    "process::exit",
    "process::abort",
    "set_current_dir",
    "set_var",
    "std::fs",
    "panic!",
    "todo!",
    "unimplemented!",
    ".unwrap()",
    "Instant::now",
];

/// A source file of `src/`.
struct Source {
    /// Relative to `src/`.
    path: PathBuf,
    text: String,
}

impl Source {
    /// The module right below the root that the file belongs to.
    fn module(&self) -> String {
        let first = self.path.iter().next().unwrap_or_default();
        Path::new(first).with_extension("").display().to_string()
    }

    /// The lines outside of comments, strings and tests, with their numbers.
    fn code(&self) -> Vec<(usize, String)> {
        let in_folder = self.path.iter().any(|part| part == "tests");
        if in_folder || self.path.file_stem().is_some_and(|stem| stem == "tests" || stem == "test_drive") {
            return Vec::new();
        }
        // Tests are the last part of a file.
        let end = self.text.find("#[cfg(test)]\nmod ").unwrap_or(self.text.len());
        self.text[..end].lines().enumerate().map(|(i, line)| (i + 1, without_text(line))).collect()
    }
}

/// The line without comment and without the content of its string literals.
fn without_text(line: &str) -> String {
    let mut code = String::new();
    let mut in_string = false;
    let mut characters = line.chars().peekable();
    while let Some(c) = characters.next() {
        match c {
            '\\' if in_string => drop(characters.next()),
            '"' => in_string = !in_string,
            '/' if !in_string && characters.peek() == Some(&'/') => break,
            c if !in_string => code.push(c),
            _ => {}
        }
    }
    code
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn sources() -> Vec<Source> {
    let source = root().join("src");
    let (mut folders, mut files) = (vec![source.clone()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                files.push(Source { path: path.strip_prefix(&source).unwrap().to_owned(), text });
            }
        }
    }
    assert!(files.len() > 20, "the sources were not found");
    files
}

/// The modules right below the root that a line of code names.
fn used_modules(line: &str) -> BTreeSet<String> {
    let mut used = BTreeSet::new();
    for start in ["crate::", "camdrive::"] {
        for (at, _) in line.match_indices(start) {
            let rest = &line[at + start.len()..];
            let names = match rest.strip_prefix('{') {
                Some(list) => list.split('}').next().unwrap_or_default().split(',').collect(),
                None => vec![rest],
            };
            for name in names {
                let name: String = name.trim().chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
                used.insert(name);
            }
        }
    }
    used
}

#[test]
fn modules_use_only_what_lies_below_them() {
    let mut faults = String::new();
    for file in sources() {
        let module = file.module();
        if module == "lib" {
            continue;
        }
        let Some((_, allowed)) = MAY_USE.iter().find(|(name, _)| *name == module) else {
            let _ = writeln!(faults, "src/{}: the module `{module}` has no place in the order", file.path.display());
            continue;
        };
        for (number, line) in file.code() {
            for used in used_modules(&line) {
                if used != module && !allowed.contains(&used.as_str()) {
                    let _ = writeln!(faults, "src/{}:{number}: {module} must not use {used}", file.path.display());
                }
            }
        }
    }
    assert!(faults.is_empty(), "\n{faults}");
}

#[test]
fn only_the_c_interface_and_its_host_are_unsafe() {
    for file in sources() {
        if UNSAFE.iter().any(|path| file.path == Path::new(path)) {
            continue;
        }
        for (number, line) in file.code() {
            // The type of a C function is no unsafe code; calling it would be. (The quotes around C are gone.)
            let line = line.replace("unsafe extern  fn(", "fn(");
            let words = line.split(|c: char| !c.is_alphanumeric() && c != '_');
            assert!(!words.into_iter().any(|word| word == "unsafe"), "src/{}:{number}", file.path.display());
        }
    }
    let library = std::fs::read_to_string(root().join("src/lib.rs")).unwrap();
    assert!(library.contains("#![deny(unsafe_code)]"));
    // The host is for the command line; importers get the functions alone.
    let interface = std::fs::read_to_string(root().join("src/fmi2/mod.rs")).unwrap();
    assert!(interface.contains("#[cfg(feature = \"cli\")]\n#[allow(unsafe_code)]\npub mod host;"));
    assert_eq!(interface.matches("allow(unsafe_code)").count(), UNSAFE.len());
}

#[test]
fn the_runtime_library_leaves_its_host_alone() {
    let mut faults = String::new();
    for file in sources().iter().filter(|file| RUNTIME.contains(&file.module().as_str())) {
        // The one place that reads a file: the resource of the FMU.
        let reads_resource = file.path.starts_with("fmi2");
        for (number, line) in file.code() {
            for word in FORBIDDEN_IN_RUNTIME {
                if line.contains(word) && !(reads_resource && word == "std::fs") {
                    let _ = writeln!(faults, "src/{}:{number}: {word}", file.path.display());
                }
            }
        }
    }
    assert!(faults.is_empty(), "\n{faults}");
}

#[test]
fn files_say_what_they_are() {
    let mut faults = String::new();
    for file in sources() {
        if file.path != Path::new("main.rs") && !file.text.starts_with("//! ") {
            let _ = writeln!(faults, "src/{}: does not start with its purpose", file.path.display());
        }
    }
    assert!(faults.is_empty(), "\n{faults}");
}

/// The names of the packages in the dependency tree of the runtime library.
fn runtime_packages(depth: &[&str]) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .current_dir(root())
        .args(["tree", "--no-default-features", "--edges", "normal,no-proc-macro", "--prefix", "none"])
        .args(["--format", "{p}"])
        .args(depth)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let names = text.lines().filter_map(|line| line.split_whitespace().next());
    names.filter(|name| *name != "camdrive").map(str::to_owned).collect()
}

#[test]
fn the_runtime_library_needs_four_packages() {
    let expected = ["crc32fast", "nalgebra", "postcard", "serde"];
    assert_eq!(runtime_packages(&["--depth", "1"]), expected.map(str::to_owned).into());
}

#[test]
fn every_linked_package_has_its_licence_in_the_fmu() {
    let listed: BTreeSet<String> = camdrive::export::licenses::crates().map(str::to_owned).collect();
    let linked = runtime_packages(&[]);
    let missing: Vec<&String> = linked.difference(&listed).collect();
    assert!(missing.is_empty(), "not in src/export/licenses.rs: {missing:?}");
    let idle: Vec<&String> = listed.difference(&linked).collect();
    assert!(idle.is_empty(), "no longer linked: {idle:?}");
}
