//! `camdrive export SCENE…`

use super::{Failure, Format, failure, files, of_option, print_message, print_notes, read_all, wrong_argument};
use crate::export::runtime_library::MADE;
use crate::export::runtime_library::PLATFORMS;
use crate::export::{Date, Extras, Packed, RuntimeLibrary, pack};
use crate::live::page::Module;
use crate::scene::Resolved;
use camdrive::drives::Fault;
use camdrive_design::text;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Export scenes as FMUs.
///
/// Each scene becomes NAME.fmu, with the name from the scene. Writes all FMUs or none. An FMU holds its scene unchanged, with
/// comments, and its tables; a table from outside the folder of the scene is renamed to table_1.csv.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive export examples/guide_bar/scene.toml
  camdrive export examples/*/scene.toml -o fmus/
  camdrive export scene.toml --runtime linux64=libcamdrive_fmu.so \\
      --runtime win64=camdrive_fmu.dll
  camdrive export scene.toml --platforms linux64,win64
  camdrive export old/guide_bar.fmu -o new/

The runtime libraries are next to the executable unless --runtime names others. To build them:
  cargo build --release --package camdrive-fmu    for the platform at hand
  packaging/build                                 for all others, in the folder target/runtimes")]
pub struct Args {
    /// Scene files (TOML), or FMUs with their scenes inside
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Where to write: a file NAME.fmu for a single scene, else a folder [default: the current folder]
    #[arg(short, long, value_name = "FILE|FOLDER")]
    output: Option<PathBuf>,
    /// Platforms whose runtime libraries are packed [default: all available]
    #[arg(long, value_name = "PLATFORM", value_delimiter = ',', value_parser = PLATFORMS.map(|(name, _)| name))]
    platforms: Vec<String>,
    /// Runtime library for a platform, instead of the available one; once per platform
    #[arg(long, value_name = "PLATFORM=FILE", conflicts_with = "platforms")]
    runtime: Vec<String>,
    /// Describe the shaft as one terminal (terminalsAndIcons/ of FMI 3.0) in each FMU whose motion or load is an input; FMI Library
    /// 3 refuses such FMUs of FMI 2.0
    #[arg(long)]
    terminals: bool,
    /// Leave out documentation/live.html, the page of each FMU that computes
    #[arg(long)]
    no_live: bool,
    #[command(flatten)]
    format: Format,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let scenes = read_all(&args.scenes)?;
    print_notes(&args.scenes, &scenes);
    let targets = targets(args, &scenes)?;
    let runtimes = runtimes(args)?;
    let date = Date::from_environment().map_err(failure)?;
    let module = if args.no_live { Ok(None) } else { Module::at_hand() };
    let module = module.unwrap_or_else(|fault| {
        print_message(&format!("warning: left out: {fault}\n"));
        None
    });
    let mut packed = Vec::new();
    for (scene, path) in scenes.iter().zip(&args.scenes) {
        let live = module.as_ref().map(|module| module.small_page(scene));
        let extras = Extras { terminals: args.terminals, sources: &scene.sources(), live: live.as_deref() };
        let fmu = pack(&scene.resource(), &scene.description, &runtimes, date, extras);
        packed.push(fmu.map_err(|fault| failure(fault.within(path.display())))?);
    }
    for runtime in &runtimes {
        if let Some(warning) = runtime.warning() {
            print_message(&format!("warning: {warning}\n"));
        }
    }
    let inputs: Vec<PathBuf> = scenes.iter().flat_map(|scene| scene.files.clone()).collect();
    let files: Vec<(PathBuf, &[u8])> = targets.into_iter().zip(packed.iter().map(|fmu| fmu.bytes.as_slice())).collect();
    let written = files::write(&files, &inputs)?;
    let fmus = || scenes.iter().zip(&packed);
    args.format.print(
        |_| {
            let summaries = fmus().zip(written.lines());
            let text: String = summaries.map(|((scene, fmu), line)| summary(scene, fmu, line, &runtimes)).collect();
            text + &absent(args, &runtimes) + if args.no_live || module.is_some() { "" } else { NO_PAGE }
        },
        || text::json(&fmus().zip(&files).map(|(fmu, (path, _))| entry(fmu, path, &runtimes)).collect::<Vec<_>>()),
    )
}

/// The line on an FMU without its page.
const NO_PAGE: &str = "no documentation/live.html: the wheel or `packaging/build wasm` adds this page\n";

/// The path of each FMU.
fn targets(args: &Args, scenes: &[Resolved]) -> Result<Vec<PathBuf>, Failure> {
    let output = args.output.as_deref().unwrap_or(Path::new(""));
    files::no_stream(output, "-o", "a folder or a file NAME.fmu")?;
    let is_folder = files::is_folder(output);
    let is_file = !is_folder && output.extension().is_some_and(|e| e.eq_ignore_ascii_case("fmu"));
    let around = output.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.exists());
    if let Some(folder) = around {
        return Err(wrong_argument(format!("{}: the folder does not exist", folder.display()))
            .hint("create it, or give -o an existing folder"));
    }
    if is_file && scenes.len() > 1 {
        let message = "several scenes do not fit into one file; give a folder with -o";
        return Err(wrong_argument(format!("{}: {message}", output.display())));
    }
    if is_file {
        return Ok(vec![output.to_owned()]);
    }
    if output.is_file() {
        let message = "this is a file; -o takes a folder or a file NAME.fmu";
        return Err(wrong_argument(format!("{}: {message}", output.display())));
    }
    if !is_file && !is_folder && output.extension().is_some() {
        return Err(wrong_argument(format!("{}: the file of an FMU is called NAME.fmu", output.display()))
            .hint("the name of a new folder ends with /"));
    }
    let mut of_scene: BTreeMap<PathBuf, &Path> = BTreeMap::new();
    let targets: Vec<PathBuf> = scenes.iter().map(|scene| output.join(format!("{}.fmu", scene.name))).collect();
    for (target, scene) in targets.iter().zip(&args.scenes) {
        if let Some(other) = of_scene.insert(target.clone(), scene) {
            let (a, b, target) = (other.display(), scene.display(), target.display());
            return Err(failure(format!("{a} and {b} would both be written to {target}; give one another name")));
        }
    }
    Ok(targets)
}

/// The libraries of the command line, or the available ones.
fn runtimes(args: &Args) -> Result<Vec<RuntimeLibrary>, Failure> {
    if !args.runtime.is_empty() {
        let of_argument = |fault: Fault| of_option(&fault).unwrap_or_else(|| failure(fault));
        let libraries = args.runtime.iter().map(|argument| RuntimeLibrary::from_argument(argument));
        return libraries.map(|library| library.map_err(of_argument)).collect();
    }
    let (libraries, left_out) = RuntimeLibrary::at_hand(&args.platforms).map_err(failure)?;
    for fault in left_out {
        print_message(&format!("warning: left out: {fault}\n"));
    }
    Ok(libraries)
}

/// The platforms without a library, and where to get it; empty if the user chose libraries.
fn absent(args: &Args, runtimes: &[RuntimeLibrary]) -> String {
    let packed = |platform: &&str| runtimes.iter().any(|runtime| runtime.platform == *platform);
    let absent: Vec<&str> = MADE.into_iter().filter(|platform| !packed(platform)).collect();
    if absent.is_empty() || !args.platforms.is_empty() || !args.runtime.is_empty() {
        return String::new();
    }
    format!("not for {}: the wheel or packaging/build adds these platforms\n", absent.join(", "))
}

/// The summary as JSON.
fn entry((scene, fmu): (&Resolved, &Packed), path: &Path, runtimes: &[RuntimeLibrary]) -> Value {
    let platforms = runtimes.iter().map(|runtime| {
        json!({ "platform": runtime.platform, "library": runtime.path, "size": runtime.bytes.len(), "sha256": runtime.sha256() })
    });
    json!({
        "fmu": path, "name": scene.name, "model": scene.scene.model_name(), "guid": fmu.guid, "size": fmu.bytes.len(),
        "states": fmu.states, "variables": fmu.variables, "platforms": platforms.collect::<Vec<_>>(),
    })
}

/// Content of the file in the line.
fn summary(scene: &Resolved, fmu: &Packed, line: &str, runtimes: &[RuntimeLibrary]) -> String {
    let mut out = format!("{line}\n");
    let mut line = |label: &str, text: String| {
        let _ = writeln!(out, "  {label:<10} {text}");
    };
    line("model", scene.scene.model_name().to_owned());
    for runtime in runtimes {
        let (platform, path, size) = (runtime.platform, runtime.path.display(), runtime.bytes.len());
        // The first digits identify a library; all 64 would not fit into a line.
        let digest = &runtime.sha256()[..16];
        line("platform", format!("{platform}: {path}, {size} bytes, sha256 {digest}…"));
    }
    line("states", fmu.states.to_string());
    line("variables", fmu.variables.to_string());
    line("guid", fmu.guid.clone());
    line("size", format!("{} bytes", fmu.bytes.len()));
    out
}
