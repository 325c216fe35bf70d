//! The store of a study: study.json, and in the folder `runs` parts in the format Parquet, which are its checkpoints.

use super::{Content, Record};
use crate::command::{Failure, ending, failure};
use crate::export::hash::{hexadecimal, sha256_of_parts};
use crate::study::Cell;
use camdrive_design::report::Value;
use camdrive_design::study::figures::Space;
use camdrive_design::study::report::{Column, Findings};
use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::SerializedFileReader;
use parquet::file::writer::SerializedFileWriter;
use parquet::record::Field;
use parquet::schema::types::Type;
use serde::Deserialize;
use std::fs::File;
use std::io::{ErrorKind, Write as _};
use std::ops::Range;
#[cfg(unix)]
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The file that identifies the study.
pub const SPECIFICATION: &str = "study.json";

/// The format of a store.
pub const FORMAT: u64 = 2;

/// The key of the checksum of a part among its metadata.
const CHECKSUM: &str = "camdrive.checksum";

/// The number of its digits.
const DIGITS: usize = 64;

/// The place of a part's checksum. It is in the metadata, at the end, after its key and two bytes: the type and the length of a
/// text (compact protocol of Thrift).
fn seal(bytes: &[u8]) -> Option<Range<usize>> {
    let key = bytes.windows(CHECKSUM.len()).rposition(|window| window == CHECKSUM.as_bytes())?;
    let first = key + CHECKSUM.len() + 2;
    bytes.get(first..first + DIGITS).map(|_| first..first + DIGITS)
}

/// A folder with the runs of one study.
pub struct Store {
    runs: PathBuf,
    /// Units and meanings of the columns, in every part.
    columns: String,
    /// Identifies the study, wherever its scene is.
    identity: String,
}

impl Store {
    /// Opens the store of the study with this specification, or creates it.
    ///
    /// # Errors
    /// A store of another study, or an existing store without `resume`; a folder that cannot be written.
    pub fn open(folder: &Path, specification: &str, resume: bool) -> Result<Self, Failure> {
        let (place, runs) = (folder.join(SPECIFICATION), folder.join("runs"));
        let unwritten = |e: std::io::Error| failure(format!("{} cannot be written: {e}", place.display()));
        std::fs::create_dir_all(&runs).map_err(unwritten)?;
        let is_part = |entry: std::io::Result<std::fs::DirEntry>| {
            let path = entry.map(|entry| entry.path()).unwrap_or_default();
            path.extension().is_some_and(|ending| ending == "parquet") && path.is_file()
        };
        if !place.exists() && std::fs::read_dir(&runs).map_err(unwritten)?.any(is_part) {
            let message = format!("{}: the folder has parts of a study, but no study.json", folder.display());
            return Err(failure(message).hint("choose another -o, or remove the folder"));
        }
        // One of several simultaneous jobs creates it.
        let made = match place.exists() {
            true => false,
            false => match whole(&place, specification.as_bytes(), false) {
                Err(e) if e.kind() == ErrorKind::AlreadyExists => false,
                result => result.map(|()| true).map_err(unwritten)?,
            },
        };
        if !made {
            let found = std::fs::read_to_string(&place).map_err(unwritten)?;
            let (message, hint) = if found != specification {
                let difference = difference(&found, specification);
                (format!("this store is of another study{difference}"), "use another folder, or remove this one")
            } else if !resume {
                ("a store of this study exists already".to_owned(), "--resume computes the missing runs")
            } else {
                (String::new(), "")
            };
            if !message.is_empty() {
                return Err(failure(format!("{}: {message}", folder.display())).hint(hint));
            }
        }
        let of: serde_json::Value = serde_json::from_str(specification).map_err(|e| failure(e.to_string()))?;
        let identity = of["identity"].as_str().unwrap_or_default().to_owned();
        Ok(Store { runs, columns: of["columns"].to_string(), identity })
    }

    fn place(&self, part: u64) -> PathBuf {
        self.runs.join(format!("part-{part:05}.parquet"))
    }

    /// True if a part exists and its checksum is right.
    ///
    /// # Errors
    /// A part that is damaged, or has another number or study.
    pub fn has(&self, part: u64) -> Result<bool, Failure> {
        let place = self.place(part);
        let fault = |message: &str| failure(format!("{}: {message}", place.display()));
        let mut bytes = match std::fs::read(&place) {
            Ok(bytes) => bytes,
            Err(_) if !place.is_file() => return Ok(false),
            Err(e) => return Err(fault(&format!("it cannot be read: {e}"))),
        };
        let found = seal(&bytes).map(|place| bytes[place].to_owned());
        self.sign(part, &mut bytes);
        let right = seal(&bytes).map(|place| bytes[place].to_owned());
        if right.is_some() && found == right {
            return Ok(true);
        }
        let damaged = fault("this part is damaged, or belongs to another place or study");
        Err(damaged.hint("`camdrive study --resume` computes it again"))
    }

    /// Writes the checksum of a part into it: SHA-256 of the study, of the part's number, and of its bytes with zeros in the place
    /// of the checksum. It shows a changed bit and a misplaced part.
    fn sign(&self, part: u64, bytes: &mut [u8]) {
        let Some(place) = seal(bytes) else { return };
        bytes[place.clone()].fill(b'0');
        let digest = sha256_of_parts(&[self.identity.as_bytes(), &part.to_le_bytes(), bytes]);
        bytes[place].copy_from_slice(hexadecimal(&digest).as_bytes());
    }

    /// Adds the runs of a part to the findings.
    fn read(&self, part: u64, found: &mut Findings) -> Result<(), ParquetError> {
        let cell = |(_, field)| match field {
            Field::Long(number) => Value::Number(number as f64),
            Field::Double(number) => Value::Number(number),
            Field::Str(text) => text.into(),
            _ => Value::Empty,
        };
        for row in SerializedFileReader::new(File::open(self.place(part))?)?.into_iter() {
            found.add(&row?.into_columns().into_iter().map(cell).collect::<Vec<_>>());
        }
        Ok(())
    }

    /// Writes a part, completely or not at all.
    pub fn write(&self, part: u64, first: u64, columns: &[(Column, Content)], rows: &[Record]) -> Result<(), Failure> {
        let place = self.place(part);
        let hint = "earlier parts are kept; --resume continues with the rest";
        let unwritten =
            |e: &dyn std::fmt::Display| failure(format!("{} cannot be written: {e}", place.display())).hint(hint);
        let mut bytes = self.bytes(first, columns, rows).map_err(|e| unwritten(&e))?;
        self.sign(part, &mut bytes);
        whole(&place, &bytes, true).map_err(|e| unwritten(&e))
    }

    /// The rows as a Parquet file.
    fn bytes(&self, first: u64, columns: &[(Column, Content)], rows: &[Record]) -> Result<Vec<u8>, ParquetError> {
        let field = |(column, content): &(Column, Content)| {
            let (physical, converted) = match content {
                Content::Run => (Physical::INT64, ConvertedType::NONE),
                Content::Varied(_) | Content::Measured(_) => (Physical::DOUBLE, ConvertedType::NONE),
                Content::Text(_) | Content::Status | Content::Message => (Physical::BYTE_ARRAY, ConvertedType::UTF8),
            };
            let optional = matches!(content, Content::Measured(_));
            let field = Type::primitive_type_builder(&column.name, physical).with_converted_type(converted);
            field
                .with_repetition(if optional { Repetition::OPTIONAL } else { Repetition::REQUIRED })
                .build()
                .map(Arc::new)
        };
        let fields = columns.iter().map(field).collect::<Result<_, _>>()?;
        let schema = Arc::new(Type::group_type_builder("run").with_fields(fields).build()?);
        let said = [("camdrive.columns", self.columns.clone()), (CHECKSUM, "0".repeat(DIGITS))];
        let said = said.map(|(key, value)| KeyValue::new(key.to_owned(), value)).to_vec();
        let properties = WriterProperties::builder().set_key_value_metadata(Some(said)).build();
        let mut bytes = Vec::new();
        let mut file = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties))?;
        let mut group = file.next_row_group()?;
        for (_, content) in columns {
            let Some(mut writer) = group.next_column()? else { break };
            let texts = |of: &dyn Fn(&Record) -> &str| -> Vec<ByteArray> {
                rows.iter().map(|row| of(row).as_bytes().to_vec().into()).collect()
            };
            match *content {
                Content::Run => {
                    let numbers: Vec<i64> = (first..).zip(rows).map(|(row, _)| row as i64).collect();
                    writer.typed::<Int64Type>().write_batch(&numbers, None, None)?;
                }
                Content::Varied(i) => {
                    let number = |row: &Record| if let Cell::Number(number) = row.cells[i] { number } else { f64::NAN };
                    writer.typed::<DoubleType>().write_batch(
                        &rows.iter().map(number).collect::<Vec<_>>(),
                        None,
                        None,
                    )?;
                }
                Content::Measured(i) => {
                    let numbers: Vec<f64> = rows.iter().filter_map(|row| row.values[i]).collect();
                    let levels: Vec<i16> = rows.iter().map(|row| row.values[i].is_some().into()).collect();
                    writer.typed::<DoubleType>().write_batch(&numbers, Some(&levels), None)?;
                }
                Content::Text(i) => {
                    let text =
                        |row: &Record| if let Cell::Text(text) = &row.cells[i] { text.clone() } else { String::new() };
                    let all: Vec<ByteArray> = rows.iter().map(|row| text(row).into_bytes().into()).collect();
                    writer.typed::<ByteArrayType>().write_batch(&all, None, None)?;
                }
                Content::Status => {
                    writer.typed::<ByteArrayType>().write_batch(&texts(&|row| row.status.word()), None, None)?;
                }
                Content::Message => {
                    writer.typed::<ByteArrayType>().write_batch(&texts(&|row| &row.message), None, None)?;
                }
            }
            writer.close()?;
        }
        group.close()?;
        file.close()?;
        Ok(bytes)
    }
}

/// The content of study.json.
#[derive(Deserialize)]
struct Specification {
    format: u64,
    identity: String,
    name: String,
    /// None except for a scene.
    model: Option<String>,
    rows: u64,
    rows_of_part: u64,
    #[serde(flatten)]
    space: Space,
    columns: Vec<Column>,
}

/// The findings of the runs in a store.
///
/// # Errors
/// A folder that is no store; files that cannot be read.
pub fn findings(folder: &Path) -> Result<Findings, Failure> {
    let place = folder.join(SPECIFICATION);
    let unread = |e: &dyn std::fmt::Display| {
        let hint = "name a scene, a system, a study, or the folder that `camdrive study` wrote";
        failure(format!("{}: this is no store of a study: {SPECIFICATION}: {e}", folder.display())).hint(hint)
    };
    let text = std::fs::read_to_string(&place).map_err(|e| unread(&e))?;
    let of: Specification = serde_json::from_str(&text).map_err(|e| unread(&e))?;
    if of.format != FORMAT {
        return Err(unread(&format!("its format is {}, this tool reads {FORMAT}", of.format)));
    }
    let store = Store { runs: folder.join("runs"), columns: String::new(), identity: of.identity };
    let mut found = Findings::new(&of.name, of.model.is_some(), of.space, of.rows, of.columns);
    for part in 0..of.rows.div_ceil(of.rows_of_part.max(1)) {
        if store.has(part)? {
            store.read(part, &mut found).map_err(|e| failure(format!("{}: {e}", store.place(part).display())))?;
        } else {
            found.missing_parts += 1;
        }
    }
    Ok(found)
}

/// Writes a file completely or not at all; replaces another file only with `replace`.
fn whole(place: &Path, bytes: &[u8], replace: bool) -> std::io::Result<()> {
    let folder = place.parent().unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    // Others may read it as far as the system permits.
    #[cfg(unix)]
    builder.permissions(std::fs::Permissions::from_mode(0o666));
    let mut file = builder.prefix(".").tempfile_in(folder)?;
    let _writing = ending::writing();
    file.write_all(bytes)?;
    // Some file systems report only now that they are full.
    file.as_file().sync_all()?;
    let moved = if replace { file.persist(place) } else { file.persist_noclobber(place) };
    moved.map(drop).map_err(|e| e.error)
}

/// The first field in which two specifications differ.
fn difference(found: &str, wanted: &str) -> String {
    let parsed = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap_or_default();
    let (found, wanted) = (parsed(found), parsed(wanted));
    let fields = ["tool", "commit", "scene", "tables", "study"];
    let other = fields.into_iter().find(|field| found[*field] != wanted[*field]);
    other.map_or(String::new(), |field| format!("; they differ in `{field}`"))
}
