//! The zip archive: the same files give the same bytes, on every machine and at any time.

use super::date::Date;
use std::io::{Cursor, Write};
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipWriter};

/// A file of the FMU: its path with forward slashes, its content.
#[derive(Clone, Debug, PartialEq)]
pub struct File {
    /// For example `resources/drive.bin`.
    pub path: String,
    /// Its bytes.
    pub content: Vec<u8>,
}

impl File {
    /// A file.
    pub fn new(path: impl Into<String>, content: impl Into<Vec<u8>>) -> Self {
        File { path: path.into(), content: content.into() }
    }
}

/// The archive of these files in this order; all get the time stamp `date`, or else the first instant that zip can express.
pub fn archive(files: &[File], date: Option<Date>) -> Result<Vec<u8>, ZipError> {
    let stamp = date.and_then(time_stamp).unwrap_or_default();
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        // The libraries of all platforms become 3 % smaller than with the usual level 6, and it takes a tenth of a second.
        .compression_level(Some(9))
        .last_modified_time(stamp)
        .system(System::Unix)
        .unix_permissions(0o644);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for file in files {
        zip.start_file(file.path.as_str(), options)?;
        zip.write_all(&file.content)?;
    }
    zip.finish().map(Cursor::into_inner)
}

fn time_stamp(date: Date) -> Option<DateTime> {
    let [month, day, hour, minute, second] =
        [date.month, date.day, date.hour, date.minute, date.second].map(|n| n as u8);
    DateTime::from_date_and_time(u16::try_from(date.year).ok()?, month, day, hour, minute, second).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn what_is_packed_comes_out_again() {
        let files = [File::new("modelDescription.xml", "<x/>"), File::new("binaries/linux64/a.so", vec![7; 5000])];
        let bytes = archive(&files, None).unwrap();
        assert!(bytes.len() < 1000, "not deflated: {} bytes", bytes.len());
        let mut zip = zip::ZipArchive::new(Cursor::new(&bytes)).unwrap();
        for (i, file) in files.iter().enumerate() {
            let mut entry = zip.by_index(i).unwrap();
            let mut content = Vec::new();
            entry.read_to_end(&mut content).unwrap();
            assert_eq!(File::new(entry.name().to_owned(), content), *file);
        }
        assert_eq!(bytes, archive(&files, None).unwrap());
    }
}
