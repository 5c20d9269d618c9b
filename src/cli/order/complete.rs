//! `linewright order complete`: lists the calls that are allowed next.

use super::early_exit::{EarlyExit, Outcome};
use super::{Choice, print_result, program, rules, words};
use crate::automata::bound::BoundExceeded;
use crate::cli::console::Failed;
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::cli::schema::{Described, form};
use crate::cli::select::Selection;
use crate::order::fsm::calls;
use crate::order::picture::call_names;
use crate::order::program::{MAX_SEARCHED_CALLS, detour};
use crate::order::supervisor::{Call, State, Supervisor};
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;

/// The arguments of `order complete`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright order complete examples/pick-and-place/unit.lw Right Down
    linewright order complete examples/pick-and-place/unit.lw 'Left & Grip' --at-once 2")]
pub struct Arguments {
    /// The rules
    #[arg(value_name = "FILE[::NAME]")]
    pub rules: Selection,
    /// Calls so far, in order: a skill, or `Left & Down`
    #[arg(value_name = "CALL")]
    pub calls: Vec<String>,
    /// Maximum number of skills called at once
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=64))]
    pub at_once: u8,
    /// Selection of rules.
    #[command(flatten)]
    pub choice: Choice,
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "order-complete",
    "The calls that are allowed next: `order complete`",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document {
    #[serde(flatten)]
    head: rules::Head,
    /// Pairs of a component and its situation.
    situation: Vec<(String, String)>,
    /// Whether a program can end here.
    complete: bool,
    /// The calls that are allowed next.
    allowed: Vec<Vec<String>>,
    /// The calls that are refused next.
    refused: Vec<RefusedEntry>,
}

/// A call that is refused next.
#[derive(JsonSchema, Serialize)]
struct RefusedEntry {
    /// The skills that are called at once.
    call: Vec<String>,
    /// The rule that refuses the call.
    #[serde(skip_serializing_if = "Option::is_none")]
    rule: Option<String>,
    /// Why the call is refused.
    why: String,
    /// The shortest sequence of calls after which this call is allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    after: Option<Vec<Vec<String>>>,
    /// Whether the search for such a sequence was abandoned.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    undecided: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> Outcome {
    let command = "order-complete";
    let chosen = rules::choose(command, &arguments.rules, &arguments.choice, options)?;
    let skills = &chosen.skills;
    let mut history = Vec::new();
    for text in &arguments.calls {
        let call = program::call(text, skills);
        history.push(call.map_err(|w| anyhow::anyhow!("{}: {}", w.message, w.help))?);
    }
    let too_large = EarlyExit::gave_up(rules::fewer_at_once(arguments.at_once));
    let mut supervisor = Supervisor::new(skills, chosen.options).map_err(&too_large)?;
    let mut state = supervisor.start();
    for call in &history {
        match supervisor.call(&state, *call).map_err(&too_large)? {
            Ok(after) => state = after,
            Err(refusal) => {
                let serialisation = chosen.options.serialisation;
                let finding = words::refused(*call, &refusal, skills, serialisation, None)
                    .with_help("give calls that the rules allow");
                return chosen.failed(command, finding, options);
            }
        }
    }
    let (allowed, refused) = next_calls(&mut supervisor, &state, arguments).map_err(&too_large)?;
    let situation = skills.components.iter().zip(&state.situation);
    let document = Document {
        head: rules::Head::of(command, skills, arguments.choice.level.level()),
        situation: situation
            .filter_map(|(c, s)| Some((c.name.clone(), c.situations.get(*s)?.clone())))
            .collect(),
        complete: supervisor.is_complete(&state),
        allowed: call_names(skills, &allowed),
        refused,
    };
    print_result(&document, || text(&document), options)?;
    Ok(ExitCode::Success)
}

/// The allowed and the refused calls in a state.
fn next_calls(
    supervisor: &mut Supervisor<'_>,
    state: &State,
    arguments: &Arguments,
) -> Result<(Vec<Call>, Vec<RefusedEntry>), BoundExceeded> {
    let skills = supervisor.skills();
    let serialisation = supervisor.options().serialisation;
    let (mut allowed, mut refused) = (Vec::new(), Vec::new());
    let calls = calls(skills, usize::from(arguments.at_once));
    // The searches for all calls together get four times the limit of a single one.
    let entries = 4 * MAX_SEARCHED_CALLS / calls.len().max(1);
    for call in calls {
        match supervisor.call(state, call)? {
            Ok(_) => allowed.push(call),
            Err(refusal) => {
                let after = match detour(supervisor, state, call, entries) {
                    Err(late @ BoundExceeded::Stopped(_)) => return Err(late),
                    sought => sought,
                };
                refused.push(RefusedEntry {
                    call: call_names(skills, &[call]).remove(0),
                    rule: words::rule(&refusal).map(|r| skills.rules[r].name.clone()),
                    why: words::why(call, &refusal, skills, serialisation),
                    undecided: after.is_err(),
                    after: after.ok().flatten().map(|d| call_names(skills, &d)),
                });
            }
        }
    }
    Ok((allowed, refused))
}

fn text(document: &Document) -> String {
    let mut text = String::new();
    let joined = |calls: &[Vec<String>]| {
        let calls: Vec<String> = calls.iter().map(|c| c.join(" & ")).collect();
        calls.join(", ")
    };
    let situation: Vec<&str> = document.situation.iter().map(|(_, s)| s.as_str()).collect();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "situation: {}", situation.join(", "));
    let allowed = match document.allowed.as_slice() {
        [] => "nothing".to_owned(),
        some => joined(some),
    };
    let _ = writeln!(text, "allowed:   {allowed}");
    let width = document
        .refused
        .iter()
        .map(|r| r.call.join(" & ").chars().count());
    let width = width.max().unwrap_or(0);
    for (i, refused) in document.refused.iter().enumerate() {
        let head = if i == 0 { "refused:" } else { "" };
        let after = match &refused.after {
            Some(calls) => format!("; allowed after {}", joined(calls)),
            None if refused.undecided => {
                "; could not decide whether it is allowed later".to_owned()
            }
            None => "; never after these calls".to_owned(),
        };
        let call = refused.call.join(" & ");
        let _ = writeln!(text, "{head:<10} {call:<width$}  {}{after}", refused.why);
    }
    if !document.complete {
        text += "the program must not end here: it is in the middle of a sequence\n";
    }
    text
}
