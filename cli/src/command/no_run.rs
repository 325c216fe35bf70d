//! `camdrive run FMU` in a build without the feature `import`: says what is missing.

use super::{Failure, failure};

/// Drives an FMU 2.0 over its default experiment and writes its outputs as CSV; not in this build.
///
/// It needs libclang and the feature `import`: cargo build --release --features import
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  cargo run --release --features import -- run guide_bar.fmu -o result.csv")]
pub struct Args {
    /// The FMU and its options
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "FMU")]
    _words: Vec<String>,
}

pub fn run(_: &Args) -> Result<(), Failure> {
    let hint = "install libclang and build with `cargo build --release --features import`";
    Err(failure(format!("run is not in this build, which has no importer\n  = hint: {hint}")))
}
