//! `linewright order check`: checks a program of calls before it is loaded.

use super::early_exit::{EarlyExit, Outcome};
use super::rules::{self, RuleSelection};
use super::{Choice, program, words};
use crate::cli::console::Failed;
use crate::cli::exit::ExitCode;
use crate::cli::options::{Format, GlobalOptions};
use crate::cli::schema::{Described, form};
use crate::cli::select::Selection;
use crate::diagnostics::{Diagnostic, codes, json, sarif};
use crate::engine::files;
use crate::order::picture::call_names;
use crate::order::program::{ProgramCheck, Violation, check};
use crate::order::supervisor::Supervisor;
use crate::source::SourceMap;
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;

/// The arguments of `order check`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright order check examples/pick-and-place/intended.txt
    linewright order check examples/pick-and-place/intended.txt --rules examples/pick-and-place/unit.lw --level reasonable

    $ linewright order check examples/pick-and-place/crash.csv

A program is a text file with one call per line: a skill, or `Left & Down` for skills called \
simultaneously. Comments begin with `#` or `//`.

In a .csv file, each row is one call, and its cells are skills called simultaneously. If there are \
other columns, the first row must be a header with a column `skill`. With a column `step`, \
consecutive rows with the same step are one call; steps must be in ascending order.

The exit code is 1 if a program is refused, 2 if one cannot be read.")]
pub struct Arguments {
    /// Programs to check
    #[arg(required = true, value_name = "PROGRAM")]
    pub programs: Vec<String>,
    /// Rules [default: the .lw file next to the program, if exactly one such file declares skills]
    #[arg(long, value_name = "FILE[::NAME]")]
    pub rules: Option<Selection>,
    /// Also refuse programs that end in the middle of a sequence
    #[arg(long)]
    pub whole: bool,
    /// Selection of rules.
    #[command(flatten)]
    pub choice: Choice,
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "order-check",
    "Verdicts on programs: `order check`",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document {
    #[serde(flatten)]
    head: rules::Head,
    /// The programs.
    programs: Vec<Entry>,
}

/// Verdict on a program.
#[derive(Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
enum ProgramVerdict {
    /// The program breaks no rule.
    Accepted,
    /// A call breaks a rule, or the program ends too early.
    Refused,
    /// The program could not be read.
    Invalid,
}

/// Result for a program.
#[derive(JsonSchema, Serialize)]
struct Entry {
    /// The file of the program.
    file: String,
    /// Whether the rules allow the program.
    verdict: ProgramVerdict,
    /// The number of calls in the program.
    calls: usize,
    /// The first call that is refused.
    #[serde(skip_serializing_if = "Option::is_none")]
    violation: Option<ViolationEntry>,
    /// For a program that ends too early: the shortest sequence of calls that completes it.
    #[serde(skip_serializing_if = "Option::is_none")]
    completion: Option<Vec<Vec<String>>>,
    /// Findings about the program.
    findings: Vec<json::Finding>,
}

/// A call that is refused.
#[derive(JsonSchema, Serialize)]
struct ViolationEntry {
    /// The number of the call, from 1.
    #[schemars(range(min = 1))]
    step: usize,
    /// The skills that are called at once.
    call: Vec<String>,
    /// The rule that the call breaks.
    #[serde(skip_serializing_if = "Option::is_none")]
    rule: Option<String>,
    /// Why the call is refused.
    why: String,
    /// The shortest sequence of calls after which the refused call is allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    detour: Option<Vec<Vec<String>>>,
    /// The calls that are allowed instead.
    instead: Vec<Vec<String>>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> Outcome {
    // Each program is read only once, since it can be a pipe.
    let programs: Vec<(&str, Read)> = arguments
        .programs
        .iter()
        .map(|name| (name.as_str(), read(name)))
        .collect();
    let selection = match &arguments.rules {
        Some(rules) => rules.clone(),
        None => find_rules(&programs, options)?,
    };
    let mut chosen = rules::choose("order-check", &selection, &arguments.choice, options)?;
    let too_large = EarlyExit::gave_up(Some("fewer skills in one call"));
    let mut entries = Vec::new();
    let mut text = String::new();
    let mut all = Vec::new();
    let mut code = ExitCode::Success;
    for (name, read) in programs {
        let (entry, shown, findings) =
            check_program(name, read, &mut chosen, arguments).map_err(&too_large)?;
        if entry.verdict == ProgramVerdict::Invalid {
            code = code.and(ExitCode::CannotRun);
        }
        code = code.and(options.exit_code(&findings));
        text += &shown;
        entries.push(Entry {
            findings: json::findings(&chosen.loaded.library.sources, &findings),
            ..entry
        });
        all.extend(findings);
    }
    let console = options.console();
    let sources = &chosen.loaded.library.sources;
    match options.format {
        Format::Json => console.document(&Document {
            head: rules::Head::of(
                "order-check",
                &chosen.skills,
                arguments.choice.level.level(),
            ),
            programs: entries,
        })?,
        Format::Sarif => console.document(&sarif::document(sources, &all))?,
        Format::Human | Format::Short => {
            console.result(&text)?;
            console.findings(sources, &all)?;
        }
    }
    Ok(code)
}

/// The text of a program, or the finding that it cannot be read.
type Read = Result<String, Box<Diagnostic>>;

fn read(name: &str) -> Read {
    files::read(Path::new(name)).map_err(|why| {
        let message = format!("{name} cannot be read: {why}");
        let finding = Diagnostic::error(codes::FILE_UNREADABLE, None, message);
        Box::new(finding.with_help("give a UTF-8 file with one skill call per line"))
    })
}

/// Finds the rules next to the first readable program. If there is no such program, or no rules
/// are found, unreadable programs are reported here, since they can be the cause.
fn find_rules(programs: &[(&str, Read)], options: &GlobalOptions) -> Result<Selection, EarlyExit> {
    let unreadable: Vec<Diagnostic> = programs
        .iter()
        .filter_map(|(_, read)| read.as_ref().err())
        .map(|finding| (**finding).clone())
        .collect();
    let sources = SourceMap::default();
    let Some((first, _)) = programs.iter().find(|(_, read)| read.is_ok()) else {
        options
            .console()
            .failed("order-check", &sources, &unreadable)?;
        return Err(EarlyExit::Reported(options.exit_code(&unreadable)));
    };
    let found = rules::find_next_to(first);
    if found.is_err() {
        options.console().findings(&sources, &unreadable)?;
    }
    Ok(found?)
}

type CheckedProgram = (Entry, String, Vec<Diagnostic>);

/// Checks one program. Returns its entry, its line in the text output, and its findings.
fn check_program(
    name: &str,
    read: Read,
    chosen: &mut RuleSelection,
    arguments: &Arguments,
) -> Result<CheckedProgram, crate::automata::bound::BoundExceeded> {
    let mut entry = Entry {
        file: name.to_owned(),
        verdict: ProgramVerdict::Invalid,
        calls: 0,
        violation: None,
        completion: None,
        findings: Vec::new(),
    };
    let text = match read {
        Ok(text) => text,
        Err(finding) => {
            return Ok((entry, format!("{name}: cannot be read\n"), vec![*finding]));
        }
    };
    let file = chosen.loaded.library.sources.add(name, text);
    let skills = &chosen.skills;
    let program = program::read(&chosen.loaded.library.sources, file, skills);
    entry.calls = program.calls.len();
    if !program.findings.is_empty() {
        return Ok((entry, format!("{name}: invalid\n"), program.findings));
    }
    let options = chosen.options;
    let mut supervisor = Supervisor::new(skills, options)?;
    let checked = check(&mut supervisor, &program.calls)?;
    let level = options.level.keyword();
    let calls = call_count(program.calls.len());
    let mut findings = Vec::new();
    let mut shown = String::new();
    // Writing to a string cannot fail.
    if let Some(violation) = &checked.violation {
        entry.verdict = ProgramVerdict::Refused;
        let span = program.spans[violation.step];
        let refused = words::refused(
            violation.call,
            &violation.refusal,
            skills,
            options.serialisation,
            Some(span),
        );
        findings.push(refused.with_help(suggestion(violation, chosen)));
        entry.violation = Some(violation_entry(violation, chosen));
        let _ = writeln!(
            shown,
            "{name}: refused at call {} of {} ({level})",
            violation.step + 1,
            program.calls.len()
        );
    } else {
        entry.verdict = ProgramVerdict::Accepted;
        let _ = writeln!(shown, "{name}: accepted, {calls} ({level})");
        let completion = checked.completion.as_ref().ok().and_then(Option::as_ref);
        entry.completion = completion.map(|c| call_names(skills, c));
        let last = program.spans.last().copied();
        if let Some(open) = unfinished(&checked, chosen, arguments.whole, last) {
            if arguments.whole {
                entry.verdict = ProgramVerdict::Refused;
                shown = format!("{name}: refused because it ends too early ({level})\n");
            }
            findings.push(open);
        }
    }
    Ok((entry, shown, findings))
}

fn call_count(calls: usize) -> String {
    match calls {
        1 => "1 call".to_owned(),
        n => format!("{n} calls"),
    }
}

/// Help text for a refused call: the calls that it needs before it, and the calls allowed instead.
fn suggestion(violation: &Violation, chosen: &RuleSelection) -> String {
    let skills = &chosen.skills;
    let call = violation.call.text(skills);
    let first = match &violation.detour {
        Ok(Some(detour)) if detour.is_empty() => String::new(),
        Ok(Some(detour)) => format!("call {} before it", words::calls(detour, skills)),
        Ok(None) => format!("`{call}` is never allowed after these calls"),
        Err(error) => format!("could not decide whether `{call}` is allowed later: {error}"),
    };
    match violation.instead.as_slice() {
        [] => format!("{first}; no call is allowed here"),
        instead => format!("{first}; allowed here: {}", words::calls(instead, skills)),
    }
}

fn violation_entry(v: &Violation, chosen: &RuleSelection) -> ViolationEntry {
    let skills = &chosen.skills;
    let options = chosen.options;
    ViolationEntry {
        step: v.step + 1,
        call: call_names(skills, &[v.call]).remove(0),
        rule: words::rule(&v.refusal).map(|r| skills.rules[r].name.clone()),
        why: words::why(v.call, &v.refusal, skills, options.serialisation),
        detour: v
            .detour
            .as_ref()
            .ok()
            .and_then(Option::as_ref)
            .map(|d| call_names(skills, d)),
        instead: call_names(skills, &v.instead),
    }
}

/// Finding for a program that ends in the middle of a sequence.
fn unfinished(
    checked: &ProgramCheck,
    chosen: &RuleSelection,
    whole: bool,
    last: Option<crate::source::Span>,
) -> Option<Diagnostic> {
    let skills = &chosen.skills;
    let rule = &skills.rules[*checked.unfinished.first()?];
    let message = format!(
        "the program ends in the middle of the sequence `{}`",
        rule.name
    );
    let finding = if whole {
        Diagnostic::error(codes::ORDER_BROKEN, last, message)
    } else {
        Diagnostic::note(codes::ORDER_BROKEN, last, message)
    };
    let help = match &checked.completion {
        Ok(Some(calls)) => format!("{} would complete it", words::calls(calls, skills)),
        Err(error) => format!("could not find the calls that complete it: {error}"),
        Ok(None) => "no calls complete it, since other rules forbid them".to_owned(),
    };
    Some(finding.with_label(rule.span, "this rule").with_help(help))
}
