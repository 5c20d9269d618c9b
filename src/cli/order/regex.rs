//! `linewright order regex`: what may be called, as a regular expression.

use super::{Choice, rules};
use crate::cli::exit::ExitCode;
use crate::cli::options::{Format, GlobalOptions};
use crate::cli::select::Selection;
use crate::order::eliminate;
use crate::order::fsm::Fsm;
use clap::Args;
use serde::Serialize;

/// The arguments of `order regex`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright order regex examples/pick-and-place/unit.lw
    linewright order regex examples/pick-and-place/printed/grammars.lw::Reasonable --whole

The expression is over single skills, one after the other, as `sequence` takes it in a file. Every beginning of one of its \
words is one of its words too, so that a monitor can use it, but for --whole.")]
pub struct Arguments {
    /// The rules
    #[arg(value_name = "FILE[::NAME]")]
    pub rules: Selection,
    /// Only programs that may end where they do: no sequence is in the middle of a word
    #[arg(long)]
    pub whole: bool,
    /// Which rules are kept.
    #[command(flatten)]
    pub choice: Choice,
}

#[derive(Serialize)]
struct Document {
    #[serde(flatten)]
    head: rules::Head,
    whole: bool,
    regex: String,
    states: usize,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let chosen = match rules::choose(&arguments.rules, &arguments.choice, options)? {
        Ok(chosen) => chosen,
        Err(code) => return Ok(code),
    };
    let skills = &chosen.skills;
    let found = Fsm::of(skills, arguments.choice.options(), 1).and_then(|fsm| {
        let dfa = fsm.one_by_one();
        let dfa = if arguments.whole {
            dfa
        } else {
            dfa.prefix_closed()
        };
        let regex = eliminate::regex(&dfa)?;
        Ok((regex.text(skills), dfa.minimal().states()))
    });
    let (regex, states) = match found {
        Ok(found) => found,
        Err(error) => return rules::gave_up(&error, options),
    };
    let console = options.console();
    if options.format == Format::Json {
        console.document(&Document {
            head: rules::Head::of("order-regex", skills, arguments.choice.level.level()),
            whole: arguments.whole,
            regex,
            states,
        })?;
    } else {
        console.result(&format!("{regex}\n"))?;
    }
    Ok(ExitCode::Success)
}
