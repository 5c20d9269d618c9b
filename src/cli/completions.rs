//! `linewright completions`: prints a completion script for a shell, generated from the definitions
//! of the commands.

use super::exit::ExitCode;
use super::options::GlobalOptions;
use clap::Args;

/// The arguments of `completions`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n    linewright completions bash > ~/.linewright-completions")]
pub struct Arguments {
    /// The shell
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

/// Runs the command.
pub fn run(
    arguments: &Arguments,
    options: &GlobalOptions,
    mut command: clap::Command,
) -> anyhow::Result<ExitCode> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "linewright", &mut script);
    options.console().result(&String::from_utf8(script)?)?;
    Ok(ExitCode::Success)
}
