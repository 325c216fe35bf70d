//! `camdrive check SCENE…`

use super::{Failure, read_all, show, tell_notes};
use std::path::PathBuf;

/// Validates scenes without writing anything.
///
/// Every value is checked, and the drive is built and started with them. All faults of all scenes are reported.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  camdrive check examples/*/scene.toml")]
pub struct Args {
    /// Scene files (TOML)
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let scenes = read_all(&args.scenes)?;
    tell_notes(&args.scenes, &scenes);
    let lines = args.scenes.iter().zip(&scenes).map(|(path, s)| format!("{}: {} ok\n", path.display(), s.model));
    show(&lines.collect::<String>())
}
