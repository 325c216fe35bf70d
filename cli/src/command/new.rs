//! `camdrive new MODEL`

use super::{Failure, failure, files, schema};
use crate::document::Kind;
use crate::document::keys::{KeyTable, LAW, SCENE, Usual, Value};
use crate::scene::resolve;
use camdrive_design::text;
use std::path::{Path, PathBuf};

/// A scene of each model that exports as it is.
const SCENES: &[(&str, &str)] = &[
    ("ElasticCamDrive", include_str!("new/elastic_cam_drive.toml")),
    ("BacklashDrive", include_str!("new/backlash_drive.toml")),
    ("RigidMachine", include_str!("new/rigid_machine.toml")),
    ("DriveTrain", include_str!("new/drive_train.toml")),
    ("ParametricDrive", include_str!("new/parametric_drive.toml")),
];

/// The file of the schema beside the scene.
const SCHEMA: &str = "scene.schema.json";

/// Create a commented scene, and a JSON Schema for your editor.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  camdrive new ElasticCamDrive -o press/scene.toml")]
pub struct Args {
    /// The model
    #[arg(value_parser = clap::builder::PossibleValuesParser::new(SCENES.iter().map(|(model, _)| *model)))]
    model: String,
    /// The scene; scene.schema.json is written beside it
    #[arg(short, long, default_value = "scene.toml")]
    output: PathBuf,
    /// Replace files that exist
    #[arg(long)]
    force: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    files::no_foreign(&args.output, &[], args.force)?;
    let folder = args.output.parent().unwrap_or("".as_ref());
    let of_another =
        |path: &Path| std::fs::read_to_string(path).is_ok_and(|text| !text.contains("\"title\": \"camdrive"));
    for (path, kept) in
        [(args.output.clone(), args.output.exists()), (folder.join(SCHEMA), of_another(&folder.join(SCHEMA)))]
    {
        if kept && !args.force {
            return Err(failure(format!("{}: this file exists; it is kept", path.display())).hint(files::ANOTHER));
        }
    }
    let scene = SCENES.iter().find(|(model, _)| *model == args.model);
    let (_, scene) = scene.ok_or_else(|| failure("there is no such model"))?;
    let parts = [(args.output.clone(), commented(scene)), (folder.join(SCHEMA), schema::text(Kind::Scene))];
    super::show(&files::write(&parts, &[])?)
}

/// The scene with what its keys mean, and those that it leaves out.
fn commented(scene: &str) -> String {
    let mut text =
        format!("# Scene by camdrive new. Plain numbers are SI, a text carries its unit.\n#:schema ./{SCHEMA}\n");
    let mut table: &'static KeyTable = &SCENE;
    let mut used: Vec<&str> = Vec::new();
    let mut header_of = "";
    for line in scene.lines() {
        if let Some(header) = line.strip_prefix('[') {
            text += &left_out(table, &used, &|key| admits(scene, header_of, key));
            used.clear();
            header_of = line;
            table = header.trim_matches(['[', ']']).split('.').fold(&SCENE, inner);
            text += &format!("\n{line}\n");
        } else if let Some((key, _)) = line.split_once(" = ") {
            used.push(key);
            text += &format!("{}{line}\n", comment(&table.key(key).described()));
        }
    }
    text + &left_out(table, &used, &|key| admits(scene, header_of, key))
}

/// True if the scene is right with this line in the table under this header.
fn admits(scene: &str, header: &str, line: &str) -> bool {
    let with = match header {
        "" => format!("{line}\n{scene}"),
        header => scene.replacen(&format!("{header}\n"), &format!("{header}\n{line}\n"), 1),
    };
    resolve("scene.toml", &with, "".as_ref()).is_ok()
}

/// A comment of several lines.
fn comment(said: &str) -> String {
    text::wrapped(said, 100).lines().map(|line| format!("# {}\n", line.trim_start())).collect()
}

/// The table under a key.
fn inner(table: &'static KeyTable, key: &str) -> &'static KeyTable {
    let of = |value: &Value| if let Value::Table(table) | Value::Tables(table) = *value { Some(table) } else { None };
    table.key(key).values.iter().find_map(of).unwrap_or(table)
}

/// Keys of a table that may be added, with their defaults; laws have too many of them.
fn left_out(table: &'static KeyTable, used: &[&str], admits: &dyn Fn(&str) -> bool) -> String {
    let free = table.all().filter(|key| !used.contains(&key.key));
    let more = free.filter_map(|key| {
        let usual = match key.usual {
            Usual::Number(number) => number.to_string(),
            Usual::Name(name) => format!("\"{name}\""),
            _ => return None,
        };
        let line = format!("{} = {usual}", key.key);
        admits(&line).then(|| format!("{}#{line}\n", comment(&key.described())))
    });
    if table.title == LAW.title { "# other laws: camdrive help scene cam\n".to_owned() } else { more.collect() }
}
