//! `camdrive completions SHELL`

use super::{Cli, Failure, print};
use clap::CommandFactory;
use clap_complete::Shell;

/// Print the completions for a shell.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Example:
  camdrive completions bash > ~/.local/share/bash-completion/completions/camdrive")]
pub struct Args {
    /// The shell
    shell: Shell,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "camdrive", &mut text);
    print(&String::from_utf8_lossy(&text))
}
