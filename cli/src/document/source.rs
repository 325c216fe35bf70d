//! The files of a scene in an FMU: the scene as it was written and the tables next to it; and the way back.

use super::{Document, Span};
use camdrive_design::resource::is_device;
use std::path::{Path, PathBuf};

/// The file name of the scene.
pub const SCENE: &str = "scene.toml";

/// A table that a scene names.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFile {
    /// Its place.
    pub path: PathBuf,
    /// Its bytes.
    pub content: Vec<u8>,
    /// Its name in the scene.
    pub name: String,
    /// The path of its key in the scene.
    pub key: String,
}

/// Names and contents: first the scene, then its tables under the names in the scene. A table from elsewhere, or with a name that
/// some system does not admit, becomes `table_1.csv` and so on, and the scene refers to this name; the rest of the scene is
/// unchanged.
pub fn all<'a>(document: &Document, tables: &'a [TableFile]) -> Vec<(String, Vec<u8>)> {
    let (mut scene, mut files) = (document.text.clone(), vec![(SCENE.to_owned(), Vec::new())]);
    let placed = |table: &'a TableFile| Some((document.place(&table.key)??.span(), table));
    let mut tables: Vec<(Span, &TableFile)> = tables.iter().filter_map(placed).collect();
    tables.sort_by_key(|(span, _)| span.start);
    let mut known: Vec<(String, String)> = Vec::new();
    let mut renamed = Vec::new();
    for (span, TableFile { content, name, .. }) in tables {
        let taken = |name: &str| files.iter().any(|(other, _)| other.to_lowercase() == name.to_lowercase());
        let inside = match known.iter().find(|(other, _)| other == name) {
            Some((_, inside)) => inside.clone(),
            None => {
                let numbered = (1..).map(|i| format!("table_{i}.csv"));
                let own = Some(name.clone()).filter(|name| is_portable(name));
                let inside = own.into_iter().chain(numbered).find(|name| !taken(name)).unwrap_or_default();
                files.push((inside.clone(), content.clone()));
                known.push((name.clone(), inside.clone()));
                inside
            }
        };
        if inside != *name {
            renamed.push((span, inside));
        }
    }
    for (span, inside) in renamed.into_iter().rev() {
        scene.replace_range(span, &format!("\"{inside}\""));
    }
    files[0].1 = scene.into_bytes();
    files
}

/// True if a name leads into the folder of the scene or below, on every system.
fn is_portable(name: &str) -> bool {
    let is_legal = |c: char| !c.is_control() && !"\\:*?\"<>|".contains(c);
    name.split('/').all(|part| {
        let is_name = !part.is_empty() && !part.ends_with(['.', ' ']) && part.chars().all(is_legal);
        is_name && !is_device(part.split('.').next().unwrap_or_default())
    })
}

/// True if a file has the name of an FMU.
pub fn is_fmu(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("fmu"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_from_elsewhere_change_and_only_once() {
        let named =
            ["lift.csv", "../a/lift.csv", "/home/b/lift.csv", "../a/lift.csv", "LIFT.csv", "d\\e.csv", "m/table_2.csv"];
        let lines =
            |names: &[&str]| names.iter().zip(0..).map(|(name, i)| format!("t{i}.file = {name} # one\n")).collect();
        let table = |(name, i): (&&str, i32)| TableFile {
            path: PathBuf::new(),
            content: name.as_bytes().to_vec(),
            name: (*name).to_owned(),
            key: format!("t{i}.file"),
        };
        let files = |text: String, names: &[&str]| {
            all(&Document::new(text), &names.iter().zip(0..).map(table).collect::<Vec<_>>())
        };
        let text: String = lines(&named.map(|name| format!("'{name}'")).each_ref().map(String::as_str));
        let first = files(text, &named);
        let scene = String::from_utf8(first[0].1.clone()).unwrap();
        let expected = [
            "'lift.csv'",
            "\"table_1.csv\"",
            "\"table_2.csv\"",
            "\"table_1.csv\"",
            "\"table_3.csv\"",
            "\"table_4.csv\"",
            "'m/table_2.csv'",
        ];
        assert_eq!(scene, lines(&expected));
        let contents: Vec<_> = first[1..].iter().map(|(_, content)| str::from_utf8(content).unwrap()).collect();
        assert_eq!(
            contents,
            ["lift.csv", "../a/lift.csv", "/home/b/lift.csv", "LIFT.csv", "d\\e.csv", "m/table_2.csv"]
        );
        // After the first reading the names do not change any more.
        let names = expected.map(|name| name.trim_matches(['\'', '"']).to_owned());
        let again = files(scene, &names.each_ref().map(String::as_str));
        assert_eq!(again[0].1, first[0].1);
        for name in ["", "a//b", "./a", "..", "a/../b", "C:a", "a\\b", "nul.csv", "a/con", "a.", "a\n"] {
            assert!(!is_portable(name), "{name}");
        }
    }
}
