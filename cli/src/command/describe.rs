//! `camdrive describe SCENE`

use super::output::Bar;
use super::{Failure, Format, failure, print, read, show, width};
use crate::document::units::short;
use crate::export::documentation::kind_of;
use crate::export::{self, model_description::unit};
use crate::scene::Resolved;
use camdrive::drives::variable::Kind;
use camdrive::drives::{AnyDrive, Description, Fault};
use camdrive_design::documentation::Equation;
use camdrive_design::forces::report::LiftOff;
use camdrive_design::law_motions::Motion;
use camdrive_design::overview::{self, Jump};
use camdrive_design::report::terminal::cells;
use camdrive_design::resource::Described;
use camdrive_design::text::{self, Page, TextTable};
use serde_json::{Value, json};
use std::path::PathBuf;

/// Show variables, units, equations and solver of the FMU.
///
/// Equations, variables with units, ranges and start values, accuracy of the solver, default experiment.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  camdrive describe examples/guide_bar/scene.toml
  camdrive describe examples/guide_bar/scene.toml --xml > modelDescription.xml")]
pub struct Args {
    /// Scene file (TOML), or an FMU with its scene inside
    scene: PathBuf,
    /// Print modelDescription.xml, with a placeholder for the guid, which is a hash of the packed FMU
    #[arg(long, conflicts_with = "json")]
    xml: bool,
    #[command(flatten)]
    format: Format,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let resolved = &read(&args.scene)?;
    let fault = |fault: Fault| failure(fault);
    if args.xml {
        return print(&export::describe(&resolved.resource(), &resolved.description).map_err(fault)?);
    }
    let mut drive = resolved.resource().build().map_err(fault)?;
    drive.set_up(0.0, None);
    if args.format.json {
        return print(&data(resolved, &mut drive).and_then(|data| text::json(&data)).map_err(fault)?);
    }
    show(&Bar::during(&resolved.name, |_| text(resolved, &mut drive)).map_err(fault)?)
}

/// The description as data.
fn data(resolved: &Resolved, drive: &mut Described) -> Result<Value, Fault> {
    let documentation = drive.documentation()?;
    let descriptions = drive.descriptions().to_vec();
    let variable = |(reference, d): (usize, &Description)| {
        let (causality, variability) = (format!("{:?}", d.causality), format!("{:?}", d.variability));
        let ([min, max], items): (_, &[_]) = match &d.kind {
            Kind::Real { min, max, .. } => ([min, max].map(|x| x.is_finite().then_some(*x)), &[]),
            Kind::Integer { min, max } => ([min, max].map(|x| Some(f64::from(*x))), &[]),
            Kind::Boolean => ([None; 2], &[]),
            Kind::Enumeration(e) => ([None; 2], e.items),
        };
        let items: Vec<&str> = items.iter().map(|(name, _)| *name).collect();
        Ok(json!({
            "reference": reference, "name": d.name, "description": d.text, "causality": causality.to_lowercase(),
            "variability": variability.to_lowercase(), "state": d.state, "start": drive.get(reference)?, "unit": unit(&d.kind),
            "min": min, "max": max, "items": items,
        }))
    };
    let variables = descriptions.iter().enumerate().map(variable).collect::<Result<Vec<Value>, Fault>>()?;
    let equations = documentation.equations.iter().map(|e| json!({ "title": e.title, "text": e.text }));
    let accuracy = documentation.accuracy.iter().map(|(quantity, text)| json!({ "quantity": quantity, "text": text }));
    let e = drive.experiment();
    let overview = overview::of(&resolved.resource());
    Ok(json!({
        "name": resolved.name, "model": resolved.scene.model_name(), "description": resolved.description, "summary": documentation.summary,
        "equations": equations.collect::<Vec<Value>>(), "variables": variables, "accuracy": accuracy.collect::<Vec<Value>>(),
        "left_out": documentation.left_out, "limits": documentation.limits, "motions": overview.motions, "jumps": overview.jumps,
        "lift_offs": overview.lift_offs,
        "experiment": { "stop": e.stop, "step": e.step, "tolerance": e.tolerance },
    }))
}

/// The description of a ready drive.
fn text(resolved: &Resolved, drive: &mut Described) -> Result<String, Fault> {
    let documentation = drive.documentation()?;
    let overview = overview::of(&resolved.resource());
    let e = drive.experiment();
    let [stop, step, tolerance] = [e.stop, e.step, e.tolerance].map(short);
    let text = Page::new(format!("{} ({})", resolved.name, resolved.scene.model_name()), width())
        .lines(Some(&resolved.description).filter(|text| !text.is_empty()))
        .lines(["", &documentation.summary])
        .section("Equations", documentation.equations.iter().map(Equation::line))
        .table("Variables", &variables(drive)?)
        .table("Motions", &cells(&Motion::table(&overview.motions)))
        .section("Jumps", overview.jumps.iter().map(Jump::text))
        .section("Contact", overview.lift_offs.iter().map(LiftOff::text))
        .section("Solver and accuracy", documentation.accuracy.iter().map(|(of, text)| format!("{of}: {text}")))
        .section("Left out", &documentation.left_out)
        .section("Limits", &documentation.limits)
        .section("Default experiment", [format!("stop time {stop} s, step {step} s, tolerance {tolerance}")])
        .text();
    Ok(text)
}

/// One line per variable, in columns.
fn variables(drive: &mut AnyDrive) -> Result<TextTable, Fault> {
    let descriptions = drive.descriptions().to_vec();
    let mut rows = Vec::new();
    for (reference, d) in descriptions.iter().enumerate() {
        let value = drive.get(reference)?;
        rows.push(vec![
            reference.to_string(),
            d.name.clone(),
            kind_of(d),
            start(d, value),
            unit(&d.kind).to_owned(),
            range(&d.kind),
            sentence(d),
        ]);
    }
    Ok(TextTable::new("ref  name  kind  start  unit  range  description", rows))
}

fn start(d: &Description, value: f64) -> String {
    match &d.kind {
        Kind::Boolean => (value != 0.0).to_string(),
        Kind::Enumeration(e) => e.items.get(value as usize - 1).map_or(String::new(), |(name, _)| (*name).to_owned()),
        _ => short(value),
    }
}

/// The description; for an enumeration with its items.
fn sentence(d: &Description) -> String {
    let Kind::Enumeration(e) = &d.kind else { return d.text.clone() };
    let items: Vec<&str> = e.items.iter().map(|(name, _)| *name).collect();
    format!("{} ({})", d.text, items.join(" | "))
}

fn range(kind: &Kind) -> String {
    match kind {
        Kind::Real { min, max, .. } if min.is_infinite() && max.is_infinite() => String::new(),
        Kind::Real { min, max, .. } => format!("{} to {}", short(*min), short(*max)),
        Kind::Integer { min: i32::MIN, max: i32::MAX } | Kind::Boolean => String::new(),
        Kind::Integer { min, max } => format!("{min} to {max}"),
        Kind::Enumeration(_) => String::new(),
    }
}
