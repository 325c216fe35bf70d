//! What several commands write: reports into folders, scenes with another cam.

use super::Failure;
use crate::drives::Fault;
use crate::motion::Fourier;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::fmt::Write as _;
use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};
use toml_edit::{Array, DocumentMut, Table, Value, value};

/// A progress bar on the standard error, hidden where that is no terminal.
pub fn bar(name: &str) -> ProgressBar {
    let target =
        if std::io::stderr().is_terminal() { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let style = ProgressStyle::with_template("{prefix} {msg:>20} {wide_bar} {pos}/{len} {elapsed}");
    ProgressBar::with_draw_target(None, target)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_prefix(name.to_owned())
}

/// Refuses a folder for a report, given by this option, that is a file.
pub fn no_file(folder: &Path, option: &str) -> Result<(), Failure> {
    match folder.is_file() {
        true => Err(Failure(format!("error: {}: this is a file; {option} takes a folder", folder.display()))),
        false => Ok(()),
    }
}

/// Refuses to overwrite an input by what the option -o names.
pub fn no_input<'a>(target: &Path, inputs: impl IntoIterator<Item = &'a PathBuf>) -> Result<(), Failure> {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    let same = |input: &&PathBuf| real(input).is_some_and(|input| Some(input) == real(target));
    match inputs.into_iter().find(same) {
        Some(input) => Err(Failure(format!("error: {}: -o would overwrite an input", input.display()))),
        None => Ok(()),
    }
}

/// Writes a file, and its folder where there is none.
pub fn write(path: &Path, content: &str) -> Result<(), Failure> {
    let failure = |e: std::io::Error| Failure(format!("error: {} cannot be written: {e}", path.display()));
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(failure)?;
    }
    std::fs::write(path, content).map_err(failure)
}

/// A table or a diagram, by the ending of its file.
pub type Part<S> = (S, Result<String, Fault>);

/// Writes the parts of a report into a folder as NAME.ending; the lines that say so.
pub fn report<S: std::fmt::Display>(
    folder: &Path,
    name: &str,
    parts: impl IntoIterator<Item = Part<S>>,
) -> Result<String, Failure> {
    let mut lines = String::from("\n");
    for (ending, content) in parts {
        let path = folder.join(format!("{name}.{ending}"));
        write(&path, &content.map_err(|fault| Failure(format!("error: {fault}")))?)?;
        let _ = writeln!(lines, "{}", path.display());
    }
    Ok(lines)
}

/// The TOML of a scene, with its comments, to be changed.
pub fn document(path: &Path) -> Result<DocumentMut, Failure> {
    let failure = |e: &dyn std::fmt::Display| Failure(format!("error: {}: {e}", path.display()));
    let text = std::fs::read_to_string(path).map_err(|e| failure(&e))?;
    text.trim_start_matches('\u{feff}').parse().map_err(|e| failure(&e))
}

/// The table `[cam]` of a law, its coefficients as multiples of `scale` [m].
pub fn cam(law: &Fourier, scale: f64) -> Table {
    // Small coefficients with an exponent; either way the number is read back to the same bits.
    let number = |x: f64| if x.abs() < 1e-3 && x != 0.0 { format!("{x:e}") } else { format!("{x:?}") };
    let parsed = |x: &f64| {
        // A zero has no sign.
        let x = x / scale + 0.0;
        number(x).parse::<Value>().unwrap_or_else(|_| x.into())
    };
    let list = |list: &[f64]| value(list.iter().map(parsed).collect::<Array>());
    let mut table = Table::new();
    table["law"] = value("fourier");
    if scale != 1.0 {
        table["scale"] = value(format!("{scale:?} m"));
    }
    table["a"] = list(&law.a);
    table["b"] = list(&law.b[1..]);
    table
}
