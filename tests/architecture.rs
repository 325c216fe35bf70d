//! The invariants of ARCHITECTURE.md, as far as a test can see them, and the limits of functions and folders.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The source folders of the packages, from the bottom up; cargo sees to it that none uses one above it.
const PACKAGES: [&str; 3] = ["src", "design/src", "cli/src"];

/// Which modules of its own package each module of the runtime library and of the command line may use.
const MAY_USE: [(&str, &[&str]); 13] = [
    ("src/numerics", &[]),
    ("src/motion", &["numerics"]),
    // What importers see of a drive knows no drive.
    ("src/drives/interface", &["motion", "numerics"]),
    ("src/drives", &["motion", "numerics"]),
    ("src/fmi2", &["drives"]),
    ("cli/src/document", &[]),
    ("cli/src/scene", &["document"]),
    ("cli/src/task", &["document", "scene"]),
    ("cli/src/system", &["document", "scene"]),
    ("cli/src/study", &["document", "scene", "system"]),
    ("cli/src/export", &[]),
    ("cli/src/live", &["document", "scene", "export"]),
    ("cli/src/command", &["document", "scene", "task", "system", "study", "export", "live"]),
];

/// The files with unsafe code: the functions of the C interface, and the host that calls them from Rust.
const UNSAFE: [&str; 4] = [
    "src/fmi2/functions.rs",
    "design/src/host/callbacks.rs",
    "design/src/host/functions.rs",
    "design/src/host/instance.rs",
];

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

/// A source file of a package.
struct Source {
    /// Relative to the folder of the workspace.
    path: PathBuf,
    text: String,
}

impl Source {
    /// The text outside of tests.
    fn untested(&self) -> &str {
        let in_folder = self.path.iter().any(|part| part == "tests");
        if in_folder || self.path.file_stem().is_some_and(|stem| stem == "tests" || stem == "test_drive") {
            return "";
        }
        // Tests are the last part of a file, unless they are one of their own, which is declared among the modules.
        let mut tests = self.text.match_indices("#[cfg(test)]\nmod ");
        let body =
            tests.find(|(at, start)| self.text[at + start.len()..].lines().next().is_some_and(|m| m.ends_with('{')));
        body.map_or(&self.text[..], |(end, _)| &self.text[..end])
    }

    /// The lines outside of comments, strings and tests, with their numbers.
    fn code(&self) -> Vec<(usize, String)> {
        without_text(self.untested()).lines().enumerate().map(|(i, line)| (i + 1, line.to_owned())).collect()
    }

    /// The same as one text.
    fn whole_code(&self) -> String {
        self.code().into_iter().map(|(_, line)| line + "\n").collect()
    }
}

/// The code without comments, strings and characters; its lines stay where they are.
fn without_text(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let comment = || rest.starts_with("//").then(|| rest.find('\n').unwrap_or(rest.len()));
        let Some(length) = comment().or_else(|| literal(rest, code.chars().last())) else {
            code.push(c);
            rest = &rest[c.len_utf8()..];
            continue;
        };
        code.extend(rest[..length].chars().filter(|c| *c == '\n'));
        rest = &rest[length..];
    }
    code
}

/// The length of the string or character with which a text begins, behind this character.
fn literal(text: &str, before: Option<char>) -> Option<usize> {
    if let Some(raw) = text.strip_prefix('r')
        && before.is_none_or(|c| !is_of_name(c) || c == 'b')
    {
        let hashes = raw.len() - raw.trim_start_matches('#').len();
        let content = raw[hashes..].strip_prefix('"')?;
        let end = format!("\"{}", &raw[..hashes]);
        return Some(2 + hashes + content.find(&end)? + end.len());
    }
    let quote = text.chars().next().filter(|c| matches!(c, '"' | '\''))?;
    let is_escape = text[1..].starts_with('\\');
    let mut escaped = false;
    for (i, (at, c)) in text.char_indices().enumerate().skip(1) {
        if c == quote && !escaped {
            return Some(at + 1);
        }
        // The name of a lifetime.
        if quote == '\'' && i > 1 && !is_escape {
            return None;
        }
        escaped = c == '\\' && !escaped;
    }
    None
}

fn is_of_name(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

fn sources() -> Vec<Source> {
    sources_in(&PACKAGES)
}

fn sources_in(folders: &[&str]) -> Vec<Source> {
    let mut folders: Vec<PathBuf> = folders.iter().map(|folder| root().join(folder)).collect();
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                files.push(Source { path: path.strip_prefix(root()).unwrap().to_owned(), text });
            }
        }
    }
    assert!(files.len() > 20, "the sources were not found");
    files
}

/// The modules right below the root of its package that a line of code names.
fn used_modules(line: &str) -> BTreeSet<String> {
    let mut used = BTreeSet::new();
    for (at, start) in line.match_indices("crate::") {
        let rest = &line[at + start.len()..];
        let names = match rest.strip_prefix('{') {
            Some(list) => list.split('}').next().unwrap_or_default().split(',').collect(),
            None => vec![rest],
        };
        for name in names {
            let name: String = name.trim().chars().take_while(|c| is_of_name(*c)).collect();
            used.insert(name);
        }
    }
    used
}

#[test]
fn modules_use_only_what_lies_below_them() {
    let mut faults = String::new();
    for file in sources() {
        let Some((module, allowed)) = MAY_USE.iter().find(|(module, _)| file.path.starts_with(module)) else {
            continue;
        };
        for (number, line) in file.code() {
            // A macro names its own folder from the root.
            for used in used_modules(&line.replace("crate::drives::interface::", "")) {
                if !module.ends_with(&used) && !allowed.contains(&used.as_str()) {
                    let _ = writeln!(faults, "{}:{number}: {module} must not use {used}", file.path.display());
                }
            }
        }
    }
    assert!(faults.is_empty(), "\n{faults}");
}

/// What the code names right behind this start of a path: `start name` and `start {name::…, name}`.
fn names_behind(code: &str, start: &str) -> BTreeSet<String> {
    let name = |text: &str| text.trim().chars().take_while(|c| is_of_name(*c)).collect::<String>();
    let named = |(at, start): (usize, &str)| -> Vec<String> {
        let rest = &code[at + start.len()..];
        let Some(list) = rest.strip_prefix('{') else { return vec![name(rest)] };
        let mut depth = 1;
        let mut nesting = |c: char| {
            depth += i32::from(c == '{') - i32::from(c == '}');
            depth
        };
        let depths: Vec<(char, i32)> =
            list.chars().map(|c| (c, nesting(c))).take_while(|(_, depth)| *depth > 0).collect();
        depths.split(|at| *at == (',', 1)).map(|part| name(&part.iter().map(|(c, _)| *c).collect::<String>())).collect()
    };
    code.match_indices(start).flat_map(named).collect()
}

/// What a file names beside it.
fn used_siblings(file: &Source) -> BTreeSet<String> {
    names_behind(&file.whole_code(), "super::")
}

/// The folders of the drives from the bottom up: each may use those before it. So an equation (of a follower or of the shaft) knows
/// no solver, a solver no model, and nobody a model but the list of them.
const HOUSE: [&str; 5] = ["interface", "follower", "shaft", "solver", "models"];

#[test]
fn equations_know_no_solver_and_solvers_no_drive() {
    let drives = Path::new("src/drives");
    let folders = |path: &Path| -> BTreeSet<String> {
        let entries = std::fs::read_dir(root().join(path)).unwrap().map(Result::unwrap);
        let folders =
            entries.filter(|entry| entry.path().is_dir()).map(|entry| entry.file_name().into_string().unwrap());
        folders.filter(|name| name != "tests").collect()
    };
    assert_eq!(folders(drives), HOUSE.map(str::to_owned).into());
    // They are also known without `models` before them.
    let models = folders(&drives.join("models"));
    let (mut faults, mut seen) = (String::new(), 0);
    for file in sources() {
        let Ok(path) = file.path.strip_prefix(drives) else { continue };
        let Some(place) = HOUSE.iter().position(|folder| path.starts_with(folder)) else { continue };
        let path = path.with_extension("");
        let modules = path.iter().map(|part| part.to_str().unwrap()).filter(|part| *part != "mod");
        let mut code = file.whole_code();
        // `super::super::…` as far as it leads up to the drives.
        code = code.replace(&"super::".repeat(modules.count()), "crate::drives::");
        for used in names_behind(&code, "crate::drives::") {
            seen += 1;
            let above = HOUSE[place + 1..].contains(&used.as_str());
            if above || (HOUSE[place] != "models" && models.contains(&used)) {
                let _ = writeln!(faults, "{}: uses {used}", file.path.display());
            }
        }
    }
    assert!(faults.is_empty() && seen > 100, "{seen} uses\n{faults}");
}

#[test]
fn no_files_of_a_folder_use_each_other_in_a_circle() {
    let mut folders: BTreeMap<PathBuf, Vec<(String, BTreeSet<String>)>> = BTreeMap::new();
    for file in sources() {
        // The head of a folder stands beside it.
        let head = file.path.file_stem().is_some_and(|stem| stem == "mod");
        let path = if head { file.path.parent().unwrap() } else { &file.path };
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        folders.entry(path.parent().unwrap().to_owned()).or_default().push((name, used_siblings(&file)));
    }
    assert!(folders.len() > 20, "the folders were not found");
    for (folder, mut rest) in folders {
        loop {
            let names: BTreeSet<String> = rest.iter().map(|(name, _)| name.clone()).collect();
            let before = rest.len();
            rest.retain(|(name, used)| used.iter().any(|used| used != name && names.contains(used)));
            if rest.len() == before {
                break;
            }
        }
        let names: Vec<String> = rest.into_iter().map(|(name, _)| name).collect();
        assert!(names.is_empty(), "{}: in a circle, or above one: {names:?}", folder.display());
    }
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
            assert!(!words.into_iter().any(|word| word == "unsafe"), "{}:{number}", file.path.display());
        }
    }
    for package in ["src", "design/src"] {
        let library = std::fs::read_to_string(root().join(package).join("lib.rs")).unwrap();
        assert!(library.contains("#![deny(unsafe_code)]"), "{package}");
    }
    let command_line = std::fs::read_to_string(root().join("cli/src/lib.rs")).unwrap();
    assert!(command_line.contains("#![forbid(unsafe_code)]"));
}

#[test]
fn the_runtime_library_leaves_its_host_alone() {
    let mut faults = String::new();
    for file in sources().iter().filter(|file| file.path.starts_with(PACKAGES[0])) {
        // The one place that reads a file: the resource of the FMU.
        let reads_resource = file.path.starts_with("src/fmi2");
        for (number, line) in file.code() {
            for word in FORBIDDEN_IN_RUNTIME {
                if line.contains(word) && !(reads_resource && word == "std::fs") {
                    let _ = writeln!(faults, "{}:{number}: {word}", file.path.display());
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
        if file.path != Path::new("cli/src/main.rs") && !file.text.starts_with("//! ") {
            let _ = writeln!(faults, "{}: does not start with its purpose", file.path.display());
        }
    }
    assert!(faults.is_empty(), "\n{faults}");
}

/// A fault has its remedy in a field; one place writes it, one finds the word to colour it.
#[test]
fn no_message_has_a_hint_in_its_text() {
    let writes = |file: &Source| {
        let lines = file.untested().lines().map(str::trim).filter(|line| !line.starts_with("//"));
        // A string goes on in the next line.
        lines.map(|line| line.trim_end_matches('\\')).collect::<String>().contains("= hint:")
    };
    let files: BTreeSet<PathBuf> = sources().into_iter().filter(writes).map(|file| file.path).collect();
    assert_eq!(files, ["src/drives/interface/fault.rs", "cli/src/command/output.rs"].map(PathBuf::from).into());
}

/// The square of ż before an impact is (ż⁻)²; ż⁻² would be 1/ż².
#[test]
fn no_sign_of_a_symbol_reads_as_that_of_its_power() {
    let folders = std::fs::read_dir(root().join("src/drives/models")).unwrap();
    let texts = folders.map(|folder| folder.unwrap().path().join("text.toml")).filter(|path| path.exists());
    let texts = texts.map(|path| Source { text: std::fs::read_to_string(&path).unwrap(), path });
    let (mut faults, mut count) = (String::new(), 0);
    for file in sources().into_iter().chain(texts) {
        count += usize::from(file.path.ends_with("text.toml"));
        for (number, line) in file.text.lines().enumerate() {
            let symbols: Vec<char> = line.chars().collect();
            if symbols
                .windows(3)
                .any(|c| "ẋẏżẇẍÿÜ\u{307}\u{308}".contains(c[0]) && "⁺⁻".contains(c[1]) && "²³".contains(c[2]))
            {
                let _ = writeln!(faults, "{}:{}: {line}", file.path.display(), number + 1);
            }
        }
    }
    assert!(faults.is_empty() && count >= 5, "{count} texts\n{faults}");
}

#[test]
fn the_runtime_library_needs_four_packages() {
    let output = Command::new(env!("CARGO"))
        .current_dir(root())
        .args(["tree", "--package", "camdrive", "--edges", "normal,no-proc-macro", "--prefix", "none"])
        .args(["--format", "{p}", "--depth", "1"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    let names: BTreeSet<&str> = text.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(names, ["camdrive", "crc32fast", "num-complex", "postcard", "serde"].into());
}

/// The rooms of ARCHITECTURE.md and the lines of code that each may have, tests not counted; a file belongs to the innermost room. The
/// limits are the counts when they were set and 2 % more, so that growth is decided: whoever needs more lines raises the limit in the
/// commit that brings them, whose body says what they are worth.
const ROOMS: [(&str, usize); 40] = [
    ("src", 16),
    ("src/motion", 2014),
    ("src/numerics", 3778),
    ("src/drives/interface", 1569),
    ("src/drives/follower", 2627),
    ("src/drives/shaft", 2825),
    ("src/drives/solver", 6440),
    ("src/drives/models", 4206),
    ("src/fmi2", 1211),
    ("design/src", 1560),
    ("design/src/cam_geometry", 2255),
    ("design/src/clearance", 2142),
    ("design/src/compensation", 2193),
    ("design/src/coupling", 1493),
    ("design/src/forces", 1510),
    ("design/src/formulas", 195),
    ("design/src/host", 1661),
    ("design/src/lever_law", 320),
    ("design/src/overview", 1188),
    ("design/src/periodic_motions", 207),
    ("design/src/periodic_turn", 715),
    ("design/src/plot", 785),
    ("design/src/recording", 167),
    ("design/src/report", 1218),
    ("design/src/smoothing", 894),
    ("design/src/stability", 2590),
    ("design/src/steady", 620),
    ("design/src/study", 1320),
    ("design/src/synthesis", 4654),
    ("design/src/tradeoff", 1910),
    ("design/src/xml", 164),
    ("cli/src", 18),
    ("cli/src/document", 2487),
    ("cli/src/scene", 4025),
    ("cli/src/task", 647),
    ("cli/src/system", 1726),
    ("cli/src/study", 818),
    ("cli/src/export", 1631),
    ("cli/src/live", 446),
    ("cli/src/command", 4770),
];

#[test]
fn no_room_outgrows_its_limit() {
    let mut lines = [0; ROOMS.len()];
    for file in sources() {
        let path = file.path.with_extension("");
        let holds = |room: &&(usize, &str)| path.starts_with(room.1);
        let rooms = ROOMS.iter().enumerate().map(|(i, (room, _))| (i, *room));
        let (room, _) = rooms.filter(|room| holds(&room)).max_by_key(|(_, room)| room.len()).expect("a room");
        lines[room] += file.code().iter().filter(|(_, line)| !line.trim().is_empty()).count();
    }
    let map = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let mut faults = String::new();
    for ((room, most), lines) in ROOMS.into_iter().zip(lines) {
        let name = room.rsplit('/').next().unwrap_or(room);
        if lines == 0
            || ![format!("`{name}`"), format!("/{name}`"), format!("`{name}/")].iter().any(|n| map.contains(n))
        {
            let _ = writeln!(faults, "{room} holds nothing, or ARCHITECTURE.md does not name it");
        }
        if lines > most {
            let _ = writeln!(faults, "{room} has {lines} lines of code, at most {most} are admissible");
        }
    }
    let hint = "take lines away, or raise the limit in tests/architecture.rs in the same commit and say in its body what they are for";
    assert!(faults.is_empty(), "\n{faults}{hint}");
}

/// A function has at most so many lines, from `fn` to its closing bracket …
const MOST_LINES: usize = 80;

/// … and at most so many arguments, `self` not counted: a tuple, or an array that the signature takes apart, counts as its members,
/// while an array or a pair of one type under one name is one quantity, such as an interval or a vector.
const MOST_ARGUMENTS: usize = 5;

/// Functions whose arguments are those of a trait of another crate. Those of C functions are prescribed, too.
const PRESCRIBED: [&str; 1] = ["solout"];

/// Longer functions, or with more arguments: the readers of tables hand section, file, reading and quantity to one another.
const EXCEPTIONS: [(&str, &str); 7] = [
    ("cli/src/scene/table.rs", "points"),
    ("cli/src/scene/table.rs", "read"),
    ("cli/src/scene/table.rs", "smoothed"),
    ("cli/src/scene/table.rs", "warn_of_jumps"),
    ("cli/src/scene/table.rs", "report_wrong"),
    ("cli/src/scene/table.rs", "unit_of"),
    ("cli/src/scene/table/dialect.rs", "rows"),
];

/// A function as it is written.
struct Function<'a> {
    name: &'a str,
    /// Its first line.
    line: usize,
    lines: usize,
    arguments: usize,
    is_of_c: bool,
}

/// The functions in code without text.
fn functions(code: &str) -> Vec<Function<'_>> {
    let function = |(at, start): (usize, &str)| {
        let behind = code[at + start.len()..].trim_start_matches("r#");
        let name = &behind[..behind.find(|c| !is_of_name(c))?];
        if name.is_empty() || code[..at].ends_with(is_of_name) {
            return None;
        }
        let mut signature = &behind[name.len()..];
        if signature.starts_with('<') {
            signature = &signature[closing(signature)? + 1..];
        }
        let end = closing(signature)?;
        let arguments = parts(&signature[1..end]).into_iter().map(count).sum();
        // A declaration ends with a semicolon, which an array may hold as well.
        let (mut depth, mut body) = (0, &signature[end + 1..]);
        let first = body.find(|c| {
            depth += i32::from("([".contains(c)) - i32::from(")]".contains(c));
            depth == 0 && "{;".contains(c)
        })?;
        body = &body[first..];
        let last = if body.starts_with('{') { closing(body)? } else { 0 };
        let whole = &code[at..code.len() - body.len() + last];
        Some(Function {
            name,
            line: code[..at].matches('\n').count() + 1,
            lines: whole.matches('\n').count() + 1,
            arguments,
            is_of_c: code[..at].trim_end().ends_with("extern"),
        })
    };
    code.match_indices("fn ").filter_map(function).collect()
}

/// Where the bracket with which the code begins is closed.
fn closing(code: &str) -> Option<usize> {
    let (mut depth, mut before, is_generic) = (0, ' ', !code.starts_with('{'));
    code.char_indices().find_map(|(at, c)| {
        // `>` also compares, and ends an arrow.
        let opens = "([{".contains(c) || (c == '<' && is_generic);
        let closes = ")]}".contains(c) || (c == '>' && is_generic && !"-=".contains(before));
        depth += i32::from(opens) - i32::from(closes);
        before = c;
        (depth == 0).then_some(at)
    })
}

/// The parts of a list between its commas.
fn parts(list: &str) -> Vec<&str> {
    let (mut depth, mut before) = (0, ' ');
    let parts = list.split(|c: char| {
        depth += i32::from("([{<".contains(c)) - i32::from(")]}".contains(c) || (c == '>' && !"-=".contains(before)));
        before = c;
        depth == 0 && c == ','
    });
    parts.map(str::trim).filter(|part| !part.is_empty()).collect()
}

/// What lies between these brackets.
fn between(code: &str, brackets: [char; 2]) -> Option<&str> {
    code.trim().strip_prefix(brackets[0])?.strip_suffix(brackets[1])
}

/// How many arguments this one counts as.
fn count(argument: &str) -> usize {
    match argument.split_once(':') {
        Some((pattern, kind)) => members(pattern, kind),
        // A receiver, or the argument of a property.
        None => usize::from(!argument.ends_with("self")),
    }
}

/// The members of an argument.
fn members(pattern: &str, kind: &str) -> usize {
    let pattern = pattern.trim().trim_start_matches("mut ");
    let mut kind = kind.trim().trim_start_matches('&');
    if let Some((_, rest)) = kind.split_once(' ').filter(|_| kind.starts_with('\'')) {
        kind = rest;
    }
    let kind = kind.trim_start_matches("mut ");
    match (between(kind, ['(', ')']).map(parts), between(pattern, ['(', ')']).map(parts)) {
        (Some(kinds), Some(patterns)) => {
            patterns.into_iter().zip(kinds).map(|(pattern, kind)| members(pattern, kind)).sum()
        }
        (Some(kinds), None) if kinds.len() == 2 && kinds[0] == kinds[1] => 1,
        (Some(kinds), None) => kinds.into_iter().map(|kind| members("", kind)).sum(),
        (None, _) if kind.starts_with('[') => between(pattern, ['[', ']']).map_or(1, |names| parts(names).len()),
        (None, _) => 1,
    }
}

#[test]
fn functions_are_short_and_take_few_arguments() {
    let (mut faults, mut seen) = (String::new(), 0);
    for file in sources_in(&["src", "design", "cli", "tests", "benches"]) {
        let code = without_text(&file.text);
        for Function { name, line, lines, arguments, is_of_c } in functions(&code) {
            seen += 1;
            if EXCEPTIONS.iter().any(|(path, other)| file.path == Path::new(path) && name == *other) {
                continue;
            }
            let place = format!("{}:{line}: {name}", file.path.display());
            if lines > MOST_LINES {
                let _ = writeln!(faults, "{place} has {lines} lines, at most {MOST_LINES} are admissible; split it");
            }
            if arguments > MOST_ARGUMENTS && !is_of_c && !PRESCRIBED.contains(&name) {
                let hint = "give what belongs together a struct with names, or split it";
                let _ = writeln!(faults, "{place} takes {arguments} arguments, at most {MOST_ARGUMENTS}; {hint}");
            }
        }
    }
    assert!(faults.is_empty() && seen > 1000, "{seen} functions\n{faults}");
}

#[test]
fn arguments_are_counted_by_their_members() {
    for (signature, arguments) in [
        ("fn f()", 0),
        ("fn f(&mut self, a: f64)", 1),
        ("fn f<const N: usize, T: Fn(f64) -> f64>(a: [T; N], b: &dyn Fn(f64, f64) -> f64)", 2),
        ("fn f(interval: (f64, f64), vector: [f64; 3])", 2),
        ("fn f((low, high): (f64, f64), [a, b, c]: [f64; 3])", 5),
        ("fn f(both: (f64, usize), three: (f64, f64, f64))", 5),
        ("fn f(((a, b), c): &'a ((f64, f64), &[u8]), Point { x, y }: Point, mut d: Vec<(f64, u8)>)", 5),
    ] {
        let code = format!("{signature} -> [u8; 2] {{ if a > b {{}} }}");
        let found: Vec<usize> = functions(&code).iter().map(|function| function.arguments).collect();
        assert_eq!(found, [arguments], "{signature}");
    }
    let code =
        without_text("fn f(a: char, b: &'static str) {\n    let [c, d] = ['\"', '\\''];\n    r#\"}\"#\n}\nfn g();\n");
    let lines: Vec<usize> = functions(&code).iter().map(|function| function.lines).collect();
    assert_eq!(lines, [4, 1], "{code}");
}
