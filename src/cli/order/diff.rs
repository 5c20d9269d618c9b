//! `linewright order diff`: finds the shortest sequence of calls that distinguishes two sets of
//! rules.

use super::early_exit::{EarlyExit, Outcome};
use super::rules::{self, RuleSelection};
use super::{Choice, LevelName, print_result, words};
use crate::cli::console::Failed;
use crate::cli::console::schema;
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::cli::schema::{Described, form};
use crate::cli::select::Selection;
use crate::order::Skills;
use crate::order::fsm::calls;
use crate::order::picture::call_names;
use crate::order::program::{Difference, DifferenceOptions, difference};
use crate::order::supervisor::{Call, Refusal, Supervisor};
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;

/// The arguments of `order diff`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright order diff examples/pick-and-place/unit.lw examples/pick-and-place/printed/grammars.lw::ValidFirst --rule trays

    $ linewright order diff examples/pick-and-place/unit.lw \\
        examples/pick-and-place/printed/grammars.lw::ValidBoth
    $ linewright order diff examples/pick-and-place/unit.lw examples/pick-and-place/unit.lw \\
        --level valid --other-level reasonable
    $ linewright order diff examples/pick-and-place/unit.lw examples/pick-and-place/unit.lw \\
        --paper --at-once 2

Both sets need the same skills; components and situations can differ. --rule and --no-rule \
select rules of A. B has all its rules unless --other-rule is given, and the level of A unless \
--other-level is given. The exit code is 0 if both allow the same calls, 1 otherwise.")]
pub struct Arguments {
    /// One set of rules
    #[arg(value_name = "A")]
    pub first: Selection,
    /// The other set of rules
    #[arg(value_name = "B")]
    pub second: Selection,
    /// Level of B [default: that of A]
    #[arg(long, value_enum, value_name = "LEVEL")]
    pub other_level: Option<LevelName>,
    /// Also compare where programs are allowed to end
    #[arg(long)]
    pub whole: bool,
    /// Only find calls that A allows and B refuses
    #[arg(long)]
    pub one_way: bool,
    /// Maximum number of skills called at once
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=64))]
    pub at_once: u8,
    /// Keep only this rule of B (repeatable)
    #[arg(long = "other-rule", value_name = "NAME")]
    pub other_rules: Vec<String>,
    /// Selection of the rules of A.
    #[command(flatten)]
    pub choice: Choice,
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "order-diff",
    "The shortest sequence of calls that distinguishes two sets of rules: `order diff`",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document {
    schema: String,
    /// The name of the first set, with the level if the names are equal.
    first: String,
    /// The name of the second set, with the level if the names are equal.
    second: String,
    /// Whether both allow the same programs.
    equal: bool,
    /// The shortest sequence of calls that distinguishes the sets.
    #[serde(skip_serializing_if = "Option::is_none")]
    calls: Option<Vec<Vec<String>>>,
    /// Which set allows these calls.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = ["first", "second"]))]
    allowed_by: Option<&'static str>,
    /// Why the other set refuses these calls.
    #[serde(skip_serializing_if = "Option::is_none")]
    why: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> Outcome {
    let first = rules::choose("order-diff", &arguments.first, &arguments.choice, options)?;
    let other = Choice {
        level: arguments.other_level.unwrap_or(arguments.choice.level),
        rules: arguments.other_rules.clone(),
        no_rules: Vec::new(),
        paper: false,
        ..arguments.choice
    };
    let second = rules::choose("order-diff", &arguments.second, &other, options)?;
    let renumbered = renumber_like(&first.skills, &second.skills)?;
    let found = Supervisor::new(&first.skills, first.options).and_then(|a| {
        let b = Supervisor::new(&renumbered, second.options)?;
        let calls = common_calls(&first, &renumbered, usize::from(arguments.at_once));
        let options = DifferenceOptions {
            whole: arguments.whole,
            one_way: arguments.one_way,
            ..DifferenceOptions::default()
        };
        difference(&a, &b, &calls, options)
    });
    let also_helps = rules::fewer_at_once(arguments.at_once);
    let found = found.map_err(EarlyExit::gave_up(also_helps))?;
    let titles = titles(&first, &second, arguments);
    let why = found.as_ref().map(|d| {
        let (skills, options) = if d.first_allows {
            (&renumbered, second.options)
        } else {
            (&first.skills, first.options)
        };
        match &d.refusal {
            Some(refusal) => refused_call(d, refusal, skills, options.serialisation),
            None => "a program must not end there, in the middle of a sequence".to_owned(),
        }
    });
    let document = Document {
        schema: schema("order-diff"),
        equal: found.is_none(),
        calls: found.as_ref().map(|d| call_names(&first.skills, &d.calls)),
        allowed_by: found
            .as_ref()
            .map(|d| if d.first_allows { "first" } else { "second" }),
        why: why.clone(),
        first: titles[0].clone(),
        second: titles[1].clone(),
    };
    let text = || {
        text(
            found.as_ref(),
            why.as_deref(),
            &titles,
            &first.skills,
            arguments.one_way,
        )
    };
    print_result(&document, text, options)?;
    Ok(match found {
        None => ExitCode::Success,
        Some(_) => ExitCode::Findings,
    })
}

fn refused_call(
    difference: &Difference,
    refusal: &Refusal,
    skills: &Skills,
    serialisation: crate::order::Serialisation,
) -> String {
    let last = difference.calls.last().copied().unwrap_or(Call(0));
    let why = words::why(last, refusal, skills, serialisation);
    format!("`{}`: {why}", last.text(skills))
}

fn text(
    found: Option<&Difference>,
    why: Option<&str>,
    [first, second]: &[String; 2],
    skills: &Skills,
    one_way: bool,
) -> String {
    let Some(difference) = found else {
        return if one_way {
            format!("{second} allows all calls that {first} allows\n")
        } else {
            format!("{first} and {second} allow the same calls\n")
        };
    };
    let (allows, refuses) = if difference.first_allows {
        (first, second)
    } else {
        (second, first)
    };
    let calls = match difference.calls.as_slice() {
        [] => "the empty program".to_owned(),
        some => words::calls(some, skills),
    };
    format!(
        "{calls}\n  {allows} allows it\n  {refuses} refuses it: {}\n",
        why.unwrap_or_default()
    )
}

/// The names of both sets, with the levels if the names are equal.
fn titles(first: &RuleSelection, second: &RuleSelection, arguments: &Arguments) -> [String; 2] {
    let (a, b) = (&first.skills.name, &second.skills.name);
    let level = arguments.choice.level.level().keyword();
    match arguments.other_level {
        _ if a != b => [a.clone(), b.clone()],
        Some(other) => [
            format!("{a} ({level})"),
            format!("{b} ({})", other.level().keyword()),
        ],
        None if arguments.choice.paper => [format!("{a} (deleted transitions)"), b.clone()],
        None => [format!("{a} (first)"), format!("{b} (second)")],
    }
}

/// The calls that are possible in both sets: two skills that belong to one component in either set
/// are never called at once.
fn common_calls(first: &RuleSelection, second: &Skills, max: usize) -> Vec<Call> {
    let own = calls(&first.skills, max);
    let other = calls(second, max);
    own.into_iter().filter(|c| other.contains(c)).collect()
}

/// The second set, with its skills numbered as in the first.
///
/// # Errors
/// The sets have different skills.
fn renumber_like(first: &Skills, second: &Skills) -> anyhow::Result<Skills> {
    let missing = |a: &Skills, b: &Skills| -> Vec<String> {
        let is_in = |name: &str| b.skills.iter().any(|s| s.name == name);
        let names = a.skills.iter().map(|s| &s.name);
        names.filter(|n| !is_in(n)).cloned().collect()
    };
    for (a, b) in [(first, second), (second, first)] {
        let missing = missing(a, b);
        anyhow::ensure!(
            missing.is_empty(),
            "`{}` has skills that `{}` lacks: {}; only rules over the same skills can be compared",
            a.name,
            b.name,
            missing.join(", ")
        );
    }
    let place = |name: &str| first.skills.iter().position(|s| s.name == name);
    let places: Vec<usize> = second
        .skills
        .iter()
        .filter_map(|s| place(&s.name))
        .collect();
    Ok(second.renumbered(&places))
}
