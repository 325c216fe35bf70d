//! `camdrive schema scene|task|study|system`

use super::{Failure, print};
use crate::document::{Kind, schema::schema};

/// Print the JSON Schema of scenes, tasks, studies or systems, for editors.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  camdrive schema scene > scene.schema.json
The first line `#:schema ./scene.schema.json` of a scene lets editors complete and explain its keys.")]
pub struct Args {
    /// Kind of file
    kind: Kind,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    print(&text(args.kind))
}

/// The schema as the text of a file.
pub fn text(kind: Kind) -> String {
    format!("{:#}\n", schema(kind))
}
