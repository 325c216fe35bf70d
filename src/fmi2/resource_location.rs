//! Finds the FMU's resources folder.

use crate::drives::Fault;
use crate::drives::resource::FILE_NAME;
use std::path::{Path, PathBuf};

/// Reads the file of the drive from the resources folder that the importer names. If it names none or a wrong one, from the folder
/// `../../resources` of the runtime library's own folder.
pub fn read(location: Option<&str>, library: Option<&Path>) -> Result<Vec<u8>, Fault> {
    let mut folders = location.map(folders_of).unwrap_or_default();
    folders.extend(library.and_then(Path::parent).map(|folder| folder.join("../../resources")));
    for folder in &folders {
        let file = folder.join(FILE_NAME);
        match std::fs::read(&file) {
            Ok(bytes) => return Ok(bytes),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => (),
            Err(e) => return Err(Fault::new(format!("{} cannot be read: {e}", file.display()))),
        }
    }
    let tried: Vec<String> = folders.iter().map(|f| format!("`{}`", f.display())).collect();
    Err(Fault::new(format!(
        "{FILE_NAME} is missing: fmuResourceLocation is {}; looked in {}",
        location.map_or("NULL".to_owned(), |l| format!("`{l}`")),
        if tried.is_empty() { "no folder".to_owned() } else { tried.join(", ") }
    )))
}

/// The folders that a resource location may mean: a `file:` URI after RFC 8089, decoded and, for importers that
/// forget to encode, as it stands; anything else is taken for a path.
fn folders_of(location: &str) -> Vec<PathBuf> {
    if location.is_empty() {
        return Vec::new();
    }
    let Some(rest) = strip_scheme(location) else { return vec![PathBuf::from(location)] };
    let path = match rest.strip_prefix("//") {
        Some(after) => match after.strip_prefix("localhost") {
            Some(path) if path.starts_with('/') => path,
            _ => after,
        },
        None => rest,
    };
    // `/C:/folder` means `C:/folder`.
    let path = match path.as_bytes() {
        [b'/', drive, b':', ..] if cfg!(windows) && drive.is_ascii_alphabetic() => &path[1..],
        _ => path,
    };
    let mut folders = vec![path_from_bytes(percent_decode(path))];
    if folders[0] != Path::new(path) {
        folders.push(PathBuf::from(path));
    }
    folders
}

fn strip_scheme(location: &str) -> Option<&str> {
    let (scheme, rest) = location.split_at_checked("file:".len())?;
    scheme.eq_ignore_ascii_case("file:").then_some(rest)
}

/// Replaces `%41` with the byte 0x41; anything else stays.
fn percent_decode(text: &str) -> Vec<u8> {
    let digit = |b: &u8| (*b as char).to_digit(16);
    let mut rest = text.as_bytes();
    let mut bytes = Vec::with_capacity(rest.len());
    while let [first, tail @ ..] = rest {
        rest = tail;
        match (first, tail) {
            (b'%', [high, low, after @ ..]) if digit(high).is_some() && digit(low).is_some() => {
                bytes.extend(digit(high).zip(digit(low)).map(|(h, l)| (16 * h + l) as u8));
                rest = after;
            }
            _ => bytes.push(*first),
        }
    }
    bytes
}

#[cfg(unix)]
fn path_from_bytes(bytes: Vec<u8>) -> PathBuf {
    use std::os::unix::ffi::OsStringExt;
    std::ffi::OsString::from_vec(bytes).into()
}

#[cfg(not(unix))]
fn path_from_bytes(bytes: Vec<u8>) -> PathBuf {
    String::from_utf8_lossy(&bytes).into_owned().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_of_a_location_is_understood() {
        for location in [
            "file:/tmp/a b/résumé",
            "file:///tmp/a%20b/r%C3%A9sum%c3%a9",
            "file://localhost/tmp/a%20b/résumé",
            "FILE:///tmp/a b/résumé",
            "/tmp/a b/résumé",
        ] {
            assert_eq!(folders_of(location)[0], Path::new("/tmp/a b/résumé"), "{location}");
        }
        assert_eq!(folders_of("file:///tmp/100%/x")[0], Path::new("/tmp/100%/x"));
        assert_eq!(folders_of("file:///tmp/100%25/x")[0], Path::new("/tmp/100%/x"));
        assert_eq!(folders_of("file:///tmp/%41/x")[1], Path::new("/tmp/%41/x"), "as it stands, for hosts that forget");
        assert!(folders_of("").is_empty());
        assert_eq!(folders_of("file:"), [Path::new("")]);
    }

    #[test]
    fn one_line_says_what_is_missing() {
        let library = Path::new("/nowhere/binaries/linux64/x.so");
        let message = read(Some("file:///no%20where"), Some(library)).unwrap_err().to_string();
        assert_eq!(
            message,
            "drive.bin is missing: fmuResourceLocation is `file:///no%20where`; looked in `/no where`, \
             `/no%20where`, `/nowhere/binaries/linux64/../../resources`"
        );
        assert!(read(None, None).unwrap_err().to_string().contains("is NULL; looked in no folder"));
    }
}
