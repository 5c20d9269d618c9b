//! `linewright order strongest`: finds the recalls and detours that rules can forbid.

use super::early_exit::{EarlyExit, Outcome};
use super::{Choice, print_result, rules, words};
use crate::cli::console::Failed;
use crate::cli::exit::ExitCode;
use crate::cli::options::GlobalOptions;
use crate::cli::schema::{Described, form};
use crate::cli::select::Selection;
use crate::order::Skills;
use crate::order::fsm::Fsm;
use crate::order::picture::call_names;
use crate::order::strongest::{Pattern, Request, Strongest, Verdict, strongest};
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;

/// The arguments of `order strongest`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright order strongest examples/pick-and-place/unit.lw
    linewright order strongest examples/pick-and-place/unit.lw --longest 3 --useful 'left & open' --drop detour_Left_Right

A recall is a call that changes nothing; a detour is a sequence of calls that a shorter one \
could replace. A situation is lost if no allowed program reaches it any more.

Recalls and detours that can be forbidden without losing a useful situation are printed as rules \
for the file. The others are printed as comments, with the situations that would be lost. Which \
rules are chosen depends on the order of the skills; --drop rejects a rule, and the others are computed \
again.")]
pub struct Arguments {
    /// The rules
    #[arg(value_name = "FILE[::NAME]")]
    pub rules: Selection,
    /// Maximum length of detours, in skills; 1 finds recalls only
    #[arg(long, default_value_t = 2, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=6))]
    pub longest: u8,
    /// Situation that must stay reachable, such as `left & down` (repeatable)
    /// [default: all situations]
    #[arg(long, value_name = "SITUATION")]
    pub useful: Vec<String>,
    /// Reject this proposed rule (repeatable)
    #[arg(long, value_name = "NAME")]
    pub drop: Vec<String>,
    /// Selection of rules.
    #[command(flatten)]
    pub choice: Choice,
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "order-strongest",
    "The recalls and detours that rules can forbid: `order strongest`",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document {
    #[serde(flatten)]
    head: rules::Head,
    /// The number of states of the automaton once the kept candidates are added as rules.
    states: usize,
    /// The number of transitions of this automaton.
    transitions: usize,
    /// The candidate rules.
    candidates: Vec<CandidateEntry>,
}

/// Verdict on a candidate rule.
#[derive(Clone, Copy, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum CandidateVerdict {
    /// The rule can be added without losing a useful situation.
    Kept,
    /// What the rule forbids is needed: a useful situation would be lost.
    Needed,
    /// The user rejected the rule with `--drop`.
    Dropped,
}

/// A candidate rule with its verdict.
#[derive(JsonSchema, Serialize)]
struct CandidateEntry {
    /// The name of the rule.
    rule: String,
    /// The rule as written.
    text: String,
    /// Verdict on the rule.
    verdict: CandidateVerdict,
    /// For `needed`: what would be lost.
    #[serde(skip_serializing_if = "Option::is_none")]
    lost: Option<LostEntry>,
}

/// What would be lost if a rule were added.
#[derive(JsonSchema, Serialize)]
struct LostEntry {
    /// The calls after which the situation would be lost.
    after: Vec<Vec<String>>,
    /// The situation that would be lost; absent if no program could be completed.
    #[serde(skip_serializing_if = "Option::is_none")]
    situation: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> Outcome {
    let command = "order-strongest";
    let chosen = rules::choose(command, &arguments.rules, &arguments.choice, options)?;
    let skills = &chosen.skills;
    let useful = arguments.useful.iter().map(|u| pattern(u, skills));
    let request = Request {
        options: chosen.options,
        longest: usize::from(arguments.longest),
        useful: useful.collect::<anyhow::Result<_>>()?,
        dropped: arguments.drop.iter().cloned().collect(),
    };
    let found = strongest(skills, &request).and_then(|found| {
        let fsm = Fsm::of(&found.skills, request.options, 1)?;
        Ok((found, fsm))
    });
    let also_helps = Some("shorter detours (--longest N)");
    let (found, fsm) = found.map_err(EarlyExit::gave_up(also_helps))?;
    ensure_candidates(&arguments.drop, &found)?;
    let document = Document {
        head: rules::Head::of(command, skills, arguments.choice.level.level()),
        states: fsm.states.len(),
        transitions: fsm.transitions().len(),
        candidates: entries(&found, skills),
    };
    print_result(&document, || text(&found, &fsm, skills), options)?;
    Ok(ExitCode::Success)
}

/// Fails if a rule to be dropped is not a candidate.
fn ensure_candidates(dropped: &[String], found: &Strongest) -> anyhow::Result<()> {
    for name in dropped {
        let known = found.candidates.iter().any(|c| c.rule.name == *name);
        anyhow::ensure!(
            known,
            "there is no candidate `{name}` to drop: run without --drop to list them"
        );
    }
    Ok(())
}

/// Parses situations by their labels: `left & down`.
fn pattern(text: &str, skills: &Skills) -> anyhow::Result<Pattern> {
    let mut pattern = Vec::new();
    for label in text.split('&').map(str::trim) {
        let written = label;
        let (of, label) = match label.split_once('.') {
            Some((component, label)) => (Some(component.trim()), label.trim()),
            None => (None, label),
        };
        let components = skills.components.iter().enumerate();
        let fits = components.filter(|(_, c)| of.is_none_or(|of| c.name == of));
        let places: Vec<(usize, usize)> = fits
            .filter_map(|(i, c)| Some((i, c.situations.iter().position(|s| s == label)?)))
            .collect();
        match places.as_slice() {
            [place] => {
                let other = pattern.iter().find(|(c, s)| *c == place.0 && *s != place.1);
                anyhow::ensure!(
                    other.is_none(),
                    "`{}` is in one situation at a time: give --useful twice if both situations are useful",
                    skills.components[place.0].name
                );
                pattern.push(*place);
            }
            [] => {
                let all = skills
                    .components
                    .iter()
                    .flat_map(|c| c.situations.iter().map(|s| format!("{}.{s}", c.name)));
                anyhow::bail!(
                    "there is no situation `{written}`: choose one of {}",
                    all.collect::<Vec<_>>().join(", ")
                );
            }
            _ => anyhow::bail!(
                "several components have a situation `{label}`: write `component.{label}`"
            ),
        }
    }
    Ok(pattern)
}

fn entries(found: &Strongest, skills: &Skills) -> Vec<CandidateEntry> {
    let entry = |c: &crate::order::strongest::Candidate| CandidateEntry {
        rule: c.rule.name.clone(),
        text: c.rule.text.clone(),
        verdict: match c.verdict {
            Verdict::Kept => CandidateVerdict::Kept,
            Verdict::Needed { .. } => CandidateVerdict::Needed,
            Verdict::Dropped => CandidateVerdict::Dropped,
        },
        lost: match &c.verdict {
            Verdict::Needed { after, lost } => Some(LostEntry {
                after: call_names(skills, after),
                situation: lost.as_ref().map(|s| skills.situation_text(s)),
            }),
            _ => None,
        },
    };
    found.candidates.iter().map(entry).collect()
}

fn text(found: &Strongest, fsm: &Fsm, skills: &Skills) -> String {
    let mut text = String::new();
    for candidate in &found.candidates {
        let rule = &candidate.rule.text;
        // Writing to a string cannot fail.
        let _ = match &candidate.verdict {
            Verdict::Kept => writeln!(text, "{rule}"),
            Verdict::Dropped => writeln!(text, "// dropped: {rule}"),
            Verdict::Needed { after, lost } => {
                let lost = match lost {
                    Some(situation) => format!("`{}` is lost", skills.situation_text(situation)),
                    None => "no program can be completed".to_owned(),
                };
                let after = match after.as_slice() {
                    [] => "at the start".to_owned(),
                    some => format!("after {}", words::calls(some, skills)),
                };
                writeln!(text, "// needed: {rule}\n//     else {lost} {after}")
            }
        };
    }
    let _ = writeln!(
        text,
        "// {} states, {} transitions of single skills",
        fsm.states.len(),
        fsm.transitions().len()
    );
    text
}
