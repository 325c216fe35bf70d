//! `camdrive new TEMPLATE`

use super::{Failure, failure, files, schema, show};
use crate::document::Kind;
use clap::ValueEnum as _;
use clap::builder::{PossibleValue, PossibleValuesParser};
use std::path::{Path, PathBuf};

/// The files of a template: the file of `-o` first.
struct Template {
    name: &'static str,
    /// The model it is a template for.
    model: Option<&'static str>,
    about: &'static str,
    files: &'static [(&'static str, &'static str)],
}

macro_rules! template {
    ($name:literal, $model:expr, $about:literal, $($file:literal = $text:literal),+) => {
        Template {
            name: $name,
            model: $model,
            about: $about,
            files: &[$(($file, include_str!(concat!("new/", $text)))),+],
        }
    };
}

/// All templates check without a warning and run unchanged.
#[rustfmt::skip]
const TEMPLATES: &[Template] = &[
    template!("dwell-rise-dwell", Some("ElasticCamDrive"), "A cam lifts a tool, holds it and lowers it",
        "scene.toml" = "dwell_rise_dwell.toml"),
    template!("measured-lift", None, "A cam with a measured lift",
        "scene.toml" = "measured_lift.toml", "lift.csv" = "lift.csv"),
    template!("press", Some("DriveTrain"), "A crank press with servo and flywheel",
        "scene.toml" = "press.toml"),
    template!("valve-train", None, "A valve that may lift off its cam",
        "scene.toml" = "valve_train.toml"),
    template!("loom", Some("RigidMachine"), "Two tools on the shaft of a motor",
        "scene.toml" = "loom.toml"),
    template!("backlash", Some("BacklashDrive"), "A follower with clearance in its cam",
        "scene.toml" = "backlash.toml"),
    template!("parallel-crank", Some("ParametricDrive"), "Coupled cranks of varying stiffness",
        "scene.toml" = "parallel_crank.toml"),
    template!("study", None, "A study: variants of a scene",
        "study.toml" = "study.toml", "scene.toml" = "dwell_rise_dwell.toml"),
    template!("system", None, "A system: machine and drive, each an FMU",
        "system.toml" = "system.toml", "machine.toml" = "machine.toml", "pusher.toml" = "pusher.toml"),
    template!("task", None, "A motion task, and the scene of its cam",
        "task.toml" = "task.toml", "scene.toml" = "dwell_rise_dwell.toml"),
];

/// Create a scene, study, system or task from a template, with the JSON Schema for your editor.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive new    (lists the templates)
  camdrive new dwell-rise-dwell
  camdrive new press -o press/scene.toml
The name of a model selects its template.")]
pub struct Args {
    /// The template; without it, print a list
    #[arg(value_parser = PossibleValuesParser::new(TEMPLATES.iter().map(choice)), hide_possible_values = true)]
    template: Option<String>,
    /// The file; its schema and the files it refers to are written next to it [default: scene.toml, task.toml …]
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Replace files that exist
    #[arg(long)]
    force: bool,
}

fn choice(template: &Template) -> PossibleValue {
    PossibleValue::new(template.name).aliases(template.model).help(template.about)
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let Some(name) = &args.template else {
        let line = |template: &Template| format!("  {:<17} {}\n", template.name, template.about);
        let list: String = TEMPLATES.iter().map(line).collect();
        return show(&format!("{list}\n`camdrive new TEMPLATE` writes one\n"));
    };
    let template = TEMPLATES.iter().find(|template| template.name == name || template.model == Some(name));
    let template = template.ok_or_else(|| failure("there is no such template"))?;
    let output = args.output.clone().unwrap_or_else(|| template.files[0].0.into());
    files::no_foreign(&output, &[], args.force)?;
    let folder = output.parent().unwrap_or("".as_ref());
    let (mut parts, mut schemas): (Vec<(PathBuf, String)>, Vec<(PathBuf, String)>) = Default::default();
    for (i, &(file, text)) in template.files.iter().enumerate() {
        let path = if i == 0 { output.clone() } else { folder.join(file) };
        let Some(stem) = file.strip_suffix(".toml") else {
            parts.push((path, text.to_owned()));
            continue;
        };
        let kind = Kind::from_str(stem, false).unwrap_or(Kind::Scene);
        let (word, schema) = (kind.word(), format!("{}.schema.json", kind.word()));
        let origin = format!("# A {word} by camdrive new {}; `camdrive help {word}` explains its keys.", template.name);
        let head = format!("{origin}\n# Plain numbers are SI, a text carries its unit.\n#:schema ./{schema}\n\n");
        parts.push((path, head + text));
        schemas.push((folder.join(schema), schema::text(kind)));
    }
    schemas.dedup();
    let of_another =
        |path: &Path| std::fs::read_to_string(path).is_ok_and(|text| !text.contains("\"title\": \"camdrive"));
    let mut in_the_way = parts.iter().filter(|part| part.0.exists());
    let kept = in_the_way.next().or_else(|| schemas.iter().find(|schema| of_another(&schema.0)));
    if let Some((path, _)) = kept.filter(|_| !args.force) {
        return Err(failure(format!("{}: this file exists; it is kept", path.display())).hint(files::ANOTHER));
    }
    show(&files::write(&[parts, schemas].concat(), &[])?)
}
