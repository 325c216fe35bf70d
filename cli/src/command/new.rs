//! `camdrive new MODEL`

use super::{Failure, failure, files, schema};
use crate::scene::input::Kind;
use crate::scene::keys::{LAW, SCENE, Table, Usual, Value};
use camdrive_design::text;
use std::path::PathBuf;

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

/// Writes a commented scene of a model, and the schema by which editors complete and explain its keys.
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
    /// Replace a file that camdrive did not write
    #[arg(long)]
    force: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    files::no_foreign(&args.output, &[], args.force)?;
    let folder = args.output.parent().unwrap_or("".as_ref());
    let scene = SCENES.iter().find(|(model, _)| *model == args.model);
    let (_, scene) = scene.ok_or_else(|| failure("there is no such model"))?;
    let parts = [(args.output.clone(), commented(scene)), (folder.join(SCHEMA), schema::text(Kind::Scene))];
    super::show(&files::write(&parts, &[])?)
}

/// The scene with what its keys mean, and those that it leaves out.
fn commented(scene: &str) -> String {
    let mut text =
        format!("# Scene by camdrive new. Plain numbers are SI, a text carries its unit.\n#:schema ./{SCHEMA}\n");
    let mut table: &'static Table = &SCENE;
    let mut used: Vec<&str> = Vec::new();
    for line in scene.lines() {
        if let Some(header) = line.strip_prefix('[') {
            text += &left_out(table, &used);
            used.clear();
            table = header.trim_matches(['[', ']']).split('.').fold(&SCENE, inner);
            text += &format!("\n{line}\n");
        } else if let Some((key, _)) = line.split_once(" = ") {
            used.push(key);
            text += &format!("{}{line}\n", comment(&table.key(key).described()));
        }
    }
    text + &left_out(table, &used)
}

/// A comment of several lines.
fn comment(said: &str) -> String {
    text::wrapped(said, 100).lines().map(|line| format!("# {}\n", line.trim_start())).collect()
}

/// The table under a key.
fn inner(table: &'static Table, key: &str) -> &'static Table {
    let of = |value: &Value| if let Value::Table(table) | Value::Tables(table) = *value { Some(table) } else { None };
    table.key(key).values.iter().find_map(of).unwrap_or(table)
}

/// Keys of a table that may be added, with their defaults; laws have too many of them.
fn left_out(table: &'static Table, used: &[&str]) -> String {
    // What belongs to another kind of motor says so first.
    let free = table.all().filter(|key| !used.contains(&key.key) && !key.meaning.trim_start().starts_with("of `"));
    let more = free.filter_map(|key| {
        let usual = match key.usual {
            Usual::Number(number) => number.to_string(),
            Usual::Name(name) => format!("\"{name}\""),
            _ => return None,
        };
        Some(format!("{}#{} = {usual}\n", comment(&key.described()), key.key))
    });
    if table.title == LAW.title { "# other laws: camdrive help scene cam\n".to_owned() } else { more.collect() }
}
