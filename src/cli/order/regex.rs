//! `linewright order regex`: prints the allowed calls as a regular expression.

use super::early_exit::{EarlyExit, Outcome};
use super::{Choice, print_result, rules};
use crate::automata::eliminate;
use crate::automata::regex::Regex;
use crate::cli::console::Failed;
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::cli::schema::{Described, form};
use crate::cli::select::Selection;
use crate::contract;
use crate::diagnostics::Severity;
use crate::order::Skills;
use crate::order::fsm::Fsm;
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;

/// The arguments of `order regex`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright order regex examples/pick-and-place/unit.lw
    linewright order regex examples/pick-and-place/printed/grammars.lw::Reasonable --whole

The expression describes single skills in sequence, in the notation of `sequence (...)`. If it is too long or too deeply nested for a file, a remark says so.

The expression also matches every prefix of a program that it matches, so a monitor can use it. \
With --whole it matches only complete programs. If there are none, because every program ends \
in the middle of a sequence, `not (...)` with all skills is printed, which matches no call; a \
remark says so, and the exit code is 1.")]
pub struct Arguments {
    /// The rules
    #[arg(value_name = "FILE[::NAME]")]
    pub rules: Selection,
    /// Match only programs that do not end in the middle of a sequence
    #[arg(long)]
    pub whole: bool,
    /// Selection of rules.
    #[command(flatten)]
    pub choice: Choice,
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "order-regex",
    "The allowed calls as a regular expression: `order regex`",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document {
    #[serde(flatten)]
    head: rules::Head,
    /// Whether the expression matches only complete programs.
    whole: bool,
    /// The regular expression.
    regex: String,
    /// The number of states of the minimal automaton.
    states: usize,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> Outcome {
    let chosen = rules::choose("order-regex", &arguments.rules, &arguments.choice, options)?;
    let skills = &chosen.skills;
    let found = Fsm::of_language(skills, chosen.options, 1).and_then(|fsm| {
        let dfa = fsm.one_by_one();
        let dfa = if arguments.whole {
            dfa
        } else {
            dfa.prefix_closed()
        };
        let regex = eliminate::regex(&dfa, chosen.options.until)?;
        Ok((regex, dfa.minimal().state_count()))
    });
    let (found, states) = found.map_err(EarlyExit::gave_up(None))?;
    let console = options.console();
    let regex = skills.expression(&found);
    let rejection = rejection(&regex, skills);
    let document = Document {
        head: rules::Head::of("order-regex", skills, arguments.choice.level.level()),
        whole: arguments.whole,
        regex,
        states,
    };
    print_result(&document, || format!("{}\n", document.regex), options)?;
    if let Some(why) = rejection {
        console.remark(&format!(
            "this expression cannot be used as a `sequence` in a file: {why}; fewer rules (--rule NAME, --no-rule NAME) give a shorter one\n"
        ))?;
    }
    if found == Regex::Nothing {
        console.remark(
            "no program is complete: every program ends in the middle of a sequence; the expression matches nothing\n",
        )?;
        return Ok(ExitCode::Findings);
    }
    Ok(ExitCode::Success)
}

/// Why an expression would be rejected in a file; `None` if it would be accepted.
fn rejection(regex: &str, skills: &Skills) -> Option<String> {
    let names: Vec<&str> = skills.skills.iter().map(|s| s.name.as_str()).collect();
    let set = format!(
        "skills Again {{ component all {{ {} }} order: sequence ({regex}) }}",
        names.join(", ")
    );
    let no_imports = |_: &str, _: &str| Err(String::new());
    let (_, findings) = contract::load(&[(String::new(), set)], &no_imports);
    let refused = findings.into_iter().find(|f| f.severity == Severity::Error);
    refused.map(|f| format!("{} ({})", f.message, f.code.id))
}
