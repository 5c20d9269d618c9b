//! The command line: one file per subcommand, and common parts.
//!
//! Results go to standard output, everything else to standard error; [`exit`] defines the exit
//! codes. A command that ran returns an [`exit::ExitCode`], with or without findings. A command
//! that could not run returns an `anyhow` error, which is printed; the exit code is then 2.

pub mod algebra;
pub mod build;
pub mod check;
pub mod completions;
pub mod console;
pub mod din;
pub mod doctor;
pub mod draw;
pub mod exit;
pub mod explain;
pub mod fmt;
pub mod import;
pub mod interrupt;
pub mod options;
pub mod order;
pub mod outline;
pub mod page;
pub mod picked;
pub mod pictures;
pub mod profiles;
pub mod proof;
pub mod recipe;
pub mod results;
pub mod run;
pub mod schema;
pub mod select;
pub mod step;
pub mod synth;
pub mod time;

use crate::deadline::{Deadline, StopReason};
use crate::diagnostics::{Diagnostic, codes};
use crate::engine::internal::{self, Fault};
use crate::engine::pipeline;
use crate::engine::worker::{self, Completion};
use crate::station::disk;
use clap::{CommandFactory as _, Parser, Subcommand};
use exit::ExitCode;
use options::GlobalOptions;
use std::ffi::OsString;

/// From assume-guarantee contracts to a running virtual production line.
#[derive(Debug, Parser)]
#[command(name = "linewright", version, arg_required_else_help = true)]
#[command(
    after_help = "Exit codes: 0 success; 1 findings; 2 the command could not run; 3 a limit was reached; 4 \
internal error (no verdict)."
)]
pub struct Arguments {
    /// Subcommand with its arguments.
    #[command(subcommand)]
    pub command: Command,
    /// Options common to all subcommands.
    #[command(flatten)]
    pub options: GlobalOptions,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Check contracts, machines, lines and recipes
    Check(check::Arguments),
    /// Synthesize a controller from a contract or a recipe
    Synth(synth::Arguments),
    /// Draw controllers, machines and lines as SVG
    Draw(draw::Arguments),
    /// Play a contract step by step, against its controller or its counterstrategy
    Step(step::Arguments),
    /// Build the station libraries of machines
    Build(build::Arguments),
    /// Simulate a production line
    Run(run::Arguments),
    /// Format files
    Fmt(fmt::Arguments),
    /// Prove which guarantees discharge which assumptions
    Compose(algebra::ComposeArguments),
    /// Check whether one contract, or a library, refines another
    Refine(algebra::RefineArguments),
    /// Check whether contracts are compatible
    Compat(algebra::CompatArguments),
    /// Compute the conjunction of contracts (views of one component)
    Conjoin(algebra::ConjoinArguments),
    /// Compute the quotient (missing component)
    Quotient(algebra::QuotientArguments),
    /// Merge contracts (requirements that hold at the same time)
    Merge(algebra::MergeArguments),
    /// Convert another tool's specification to a contract
    Import(import::Arguments),
    /// Explain a finding, a construct of the language or a command
    Explain(explain::Arguments),
    /// Check and monitor calls of skills against skill orders
    Order(order::Arguments),
    /// Plan, compare and repair recipes on layouts of resources
    Recipe(recipe::Arguments),
    /// Look up codes of DIN 8580 and VDI 2860
    Din(din::Arguments),
    /// Report available compilers and tools, or the UF_Value layout that a probe found
    Doctor(doctor::Arguments),
    /// Print the JSON Schema of a document
    Schema(schema::Arguments),
    /// Print a shell completion script
    Completions(completions::Arguments),
}

/// Runs the program with command-line arguments, the program's name first. Prints all output and
/// returns the exit code.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => {
            // Clap also returns help and version as errors. Printing can fail if the pipe is
            // closed, which is not a failure of the command.
            let _ = error.print();
            return if error.use_stderr() {
                ExitCode::CannotRun
            } else {
                ExitCode::Success
            };
        }
    };
    internal::install_panic_hook();
    let console = arguments.options.console();
    let command = arguments.command.name();
    let hard_deadline = arguments.hard_deadline();
    disk::keep_within(hard_deadline);
    let doing = move || format!("running `{command}`");
    // Fails only if the pool already exists, as in tests, where the stack size does not matter.
    let _ = rayon::ThreadPoolBuilder::new()
        .stack_size(worker::STACK_BYTES)
        .build_global();
    let work = move |_: &dyn Fn(())| internal::caught(doing, || dispatch(&arguments));
    let fault = match worker::run(hard_deadline, work, |_| ()) {
        Completion::Done(Ok(Ok(code))) if interrupt::interrupted() => {
            return code.and(ExitCode::GaveUp);
        }
        Completion::Done(Ok(Ok(code))) => return code,
        Completion::Done(Ok(Err(error))) if error.is::<pipeline::InternalError>() => {
            Fault::detected(doing(), error.to_string())
        }
        Completion::Done(Ok(Err(error))) => {
            let _ = console.remark(&format!("\u{1b}[1m\u{1b}[91merror\u{1b}[0m: {error:#}\n"));
            return ExitCode::CannotRun;
        }
        Completion::Done(Err(fault)) => fault,
        Completion::Abandoned(late, _) => {
            let _ = console.aborted(command, &overdue(command, late));
            return ExitCode::GaveUp;
        }
    };
    let _ = console.aborted(command, &fault.finding(None));
    ExitCode::Internal
}

impl Arguments {
    /// When the command is terminated even if it does not check its time limit; never for an
    /// interactive command.
    fn hard_deadline(&self) -> Deadline {
        let is_interactive = match &self.command {
            Command::Step(step) => step.script.is_none(),
            Command::Check(check) => check.watch,
            _ => false,
        };
        if is_interactive {
            Deadline::NONE
        } else {
            self.options.hard_deadline()
        }
    }
}

/// Finding for a command that was terminated during its work.
fn overdue(command: &str, late: StopReason) -> Diagnostic {
    let message = format!(
        "`{command}` has no result: {late} in work that cannot be interrupted, such as access to files"
    );
    Diagnostic::error(codes::GAVE_UP, None, message).with_help(late.remedy())
}

impl Command {
    /// Whether the command checks its deadline throughout. `step` does so only while it solves.
    fn has_deadline(&self) -> bool {
        match self {
            Self::Check(_)
            | Self::Synth(_)
            | Self::Draw(_)
            | Self::Build(_)
            | Self::Run(_)
            | Self::Compose(_)
            | Self::Refine(_)
            | Self::Compat(_)
            | Self::Conjoin(_)
            | Self::Quotient(_)
            | Self::Merge(_)
            | Self::Order(_) => true,
            Self::Step(_)
            | Self::Fmt(_)
            | Self::Import(_)
            | Self::Explain(_)
            | Self::Recipe(_)
            | Self::Din(_)
            | Self::Doctor(_)
            | Self::Schema(_)
            | Self::Completions(_) => false,
        }
    }

    /// Name of the command as typed.
    fn name(&self) -> &'static str {
        match self {
            Self::Check(_) => "check",
            Self::Synth(_) => "synth",
            Self::Draw(_) => "draw",
            Self::Step(_) => "step",
            Self::Build(_) => "build",
            Self::Run(_) => "run",
            Self::Fmt(_) => "fmt",
            Self::Compose(_) => "compose",
            Self::Refine(_) => "refine",
            Self::Compat(_) => "compat",
            Self::Conjoin(_) => "conjoin",
            Self::Quotient(_) => "quotient",
            Self::Merge(_) => "merge",
            Self::Import(_) => "import",
            Self::Explain(_) => "explain",
            Self::Order(_) => "order",
            Self::Recipe(_) => "recipe",
            Self::Din(_) => "din",
            Self::Doctor(_) => "doctor",
            Self::Schema(_) => "schema",
            Self::Completions(_) => "completions",
        }
    }
}

fn dispatch(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let options = &arguments.options;
    let _watch = arguments.command.has_deadline().then(interrupt::Watch::new);
    match &arguments.command {
        Command::Check(a) => check::run(a, options),
        Command::Synth(a) => synth::run(a, options),
        Command::Draw(a) => draw::run(a, options),
        Command::Step(a) => step::run(a, options),
        Command::Build(a) => build::run(a, options),
        Command::Run(a) => run::run(a, options),
        Command::Fmt(a) => fmt::run(a, options),
        Command::Compose(a) => algebra::compose(a, options),
        Command::Refine(a) => algebra::refine(a, options),
        Command::Compat(a) => algebra::compat(a, options),
        Command::Conjoin(a) => algebra::conjoin(a, options),
        Command::Quotient(a) => algebra::quotient(a, options),
        Command::Merge(a) => algebra::merge(a, options),
        Command::Import(a) => import::run(a, options),
        Command::Explain(a) => explain::run(a, options, &Arguments::command()),
        Command::Order(a) => order::run(a, options),
        Command::Recipe(a) => recipe::run(a, options),
        Command::Din(a) => din::run(a, options),
        Command::Doctor(a) => doctor::run(a, options),
        Command::Schema(a) => schema::run(a, options),
        Command::Completions(a) => completions::run(a, options, Arguments::command()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arguments_are_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn every_command_shows_an_example() {
        fn visit(command: &clap::Command) {
            if command.get_subcommands().next().is_none() {
                let help = command.get_after_help().map(ToString::to_string);
                let example = help.is_some_and(|h| h.contains("    linewright "));
                assert!(example, "{} has no example", command.get_name());
            }
            command.get_subcommands().for_each(visit);
        }
        visit(&Arguments::command());
    }
}
