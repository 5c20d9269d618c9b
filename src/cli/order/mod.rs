//! `linewright order`: checks, monitors and shows the calls that the rules of a skill order allow.

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

use super::console::Failed;
use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use super::schema::{Described, form};
use crate::order::supervisor::Options;
use crate::order::{Level, Serialisation};
use clap::{Args, Subcommand, ValueEnum};
use serde::Serialize;

/// The arguments of `order`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Subcommand with its arguments.
    #[command(subcommand)]
    pub command: Command,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Check programs of skill calls, one call per line
    Check(check::Arguments),
    /// Monitor calls on standard input, or write a monitor as C or Structured Text
    Monitor(monitor::Arguments),
    /// Print the automaton of allowed calls
    Fsm(fsm::Arguments),
    /// Print the allowed calls as a regular expression
    Regex(regex::Arguments),
    /// Find the shortest sequence of calls that distinguishes two sets of rules
    Diff(diff::Arguments),
    /// List the calls that are allowed next
    Complete(complete::Arguments),
    /// Find superfluous calls (recalls, detours) that rules can forbid without losing a situation
    Strongest(strongest::Arguments),
}

/// Level of refusal, as an argument.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LevelName {
    /// Refuse no calls.
    Arbitrary,
    /// Refuse calls that break a rule.
    Valid,
    /// Also refuse recalls (calls that change nothing), and calls that break a rule marked `at
    /// reasonable`.
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

/// Selection of rules, and how they are applied.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Which rules")]
pub struct Choice {
    /// Which calls are refused
    #[arg(long, value_enum, default_value = "valid", value_name = "LEVEL")]
    pub level: LevelName,
    /// Keep only this rule (repeatable)
    #[arg(id = "rule", long = "rule", value_name = "NAME")]
    pub rules: Vec<String>,
    /// Ignore this rule (repeatable)
    #[arg(id = "no_rule", long = "no-rule", value_name = "NAME")]
    pub no_rules: Vec<String>,
    /// Allow simultaneous skills if at least one order of calling them is allowed; by default,
    /// every order must be allowed
    #[arg(long)]
    pub some_order: bool,
    /// Follow the model published by Brandenbourger, Vathoopan and Zoitl: delete exactly the
    /// transitions that a rule lists under `deletes`, and ignore its formula
    #[arg(long)]
    pub paper: bool,
}

impl Choice {
    /// The options for a supervisor, with the time limit of the command.
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
    let (document, outcome) = match &arguments.command {
        Command::Check(a) => (check::DOCUMENT, check::run(a, options)),
        Command::Monitor(a) => (monitor::DOCUMENT, monitor::run(a, options)),
        Command::Fsm(a) => (fsm::DOCUMENT, fsm::run(a, options)),
        Command::Regex(a) => (regex::DOCUMENT, regex::run(a, options)),
        Command::Diff(a) => (diff::DOCUMENT, diff::run(a, options)),
        Command::Complete(a) => (complete::DOCUMENT, complete::run(a, options)),
        Command::Strongest(a) => (strongest::DOCUMENT, strongest::run(a, options)),
    };
    outcome.or_else(|early| early.report(document.name, options))
}

/// The documents of the subcommands, and the one that reports why `order` itself has no result.
pub const DOCUMENTS: [Described; 8] = [
    check::DOCUMENT,
    complete::DOCUMENT,
    diff::DOCUMENT,
    fsm::DOCUMENT,
    monitor::DOCUMENT,
    regex::DOCUMENT,
    strongest::DOCUMENT,
    Described::new("order", "Why `order` has no result", &[form::<Failed>]),
];

/// Prints a result: the document with `--format json`, the text otherwise.
fn print_result(
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
