//! `linewright order`: what may follow what under the rules of a skill order.

mod check;
mod complete;
mod diff;
mod early_exit;
mod fsm;
mod monitor;
pub mod program;
mod regex;
mod rules;
mod strongest;
mod words;

use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use crate::order::supervisor::Options;
use crate::order::{Level, Serialisation};
use clap::{Args, Subcommand, ValueEnum};
use serde::Serialize;

/// The arguments of `order`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// What to do with the rules.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Check a program before it is loaded: a skill, or several called at once, a line
    Check(check::Arguments),
    /// Watch calls as they come on standard input, or emit a monitor as C or Structured Text
    Monitor(monitor::Arguments),
    /// Print the automaton: all situations, and what may be called in them
    Fsm(fsm::Arguments),
    /// Print a regular expression of what may be called
    Regex(regex::Arguments),
    /// Find the shortest calls that tell two sets of rules apart
    Diff(diff::Arguments),
    /// Say what may come next
    Complete(complete::Arguments),
    /// Find the recalls and detours that can be left out, each as a rule to keep or to drop
    Strongest(strongest::Arguments),
}

/// A level, as an argument.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LevelName {
    /// Every call is allowed.
    Arbitrary,
    /// The rules are kept.
    Valid,
    /// No recall, and the rules that are `at reasonable` are kept as well.
    Reasonable,
}

impl LevelName {
    /// The level as a core type.
    pub fn level(self) -> Level {
        match self {
            Self::Arbitrary => Level::Arbitrary,
            Self::Valid => Level::Valid,
            Self::Reasonable => Level::Reasonable,
        }
    }
}

/// Which rules are kept, and how.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Which rules")]
pub struct Choice {
    /// How much is forbidden
    #[arg(long, value_enum, default_value = "valid", value_name = "LEVEL")]
    pub level: LevelName,
    /// Keep only this rule (may be given several times)
    #[arg(id = "rule", long = "rule", value_name = "NAME")]
    pub rules: Vec<String>,
    /// Leave this rule out (may be given several times)
    #[arg(id = "no_rule", long = "no-rule", value_name = "NAME")]
    pub no_rules: Vec<String>,
    /// Allow several skills at once where some order of them is allowed, and not only where every
    /// order is
    #[arg(long)]
    pub some_order: bool,
    /// Where a rule lists the transitions that a published model deletes, delete just these
    #[arg(long)]
    pub paper: bool,
}

impl Choice {
    /// The options for the core, with the time limit counted from now.
    pub fn options(&self, global: &GlobalOptions) -> Options {
        Options {
            level: self.level.level(),
            serialisation: if self.some_order {
                Serialisation::Some
            } else {
                Serialisation::Every
            },
            paper: self.paper,
            until: global.limits().deadline,
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    if !matches!(arguments.command, Command::Check(_)) {
        options.refuse_sarif("the result")?;
    }
    let outcome = match &arguments.command {
        Command::Check(a) => check::run(a, options),
        Command::Monitor(a) => monitor::run(a, options),
        Command::Fsm(a) => fsm::run(a, options),
        Command::Regex(a) => regex::run(a, options),
        Command::Diff(a) => diff::run(a, options),
        Command::Complete(a) => complete::run(a, options),
        Command::Strongest(a) => strongest::run(a, options),
    };
    outcome.or_else(|early| early.report(options))
}

/// Prints an answer: its document with `--format json`, otherwise its text.
fn answer(
    document: &impl Serialize,
    text: impl FnOnce() -> String,
    options: &GlobalOptions,
) -> anyhow::Result<()> {
    let console = options.console();
    if options.format == Format::Json {
        console.document(document)
    } else {
        console.result(&text())
    }
}
