//! `linewright order check`: checks a program of calls before it is loaded.

use super::early_exit::{EarlyExit, Outcome};
use super::rules::{self, Chosen};
use super::{Choice, program, words};
use crate::cli::exit::ExitCode;
use crate::cli::options::{Format, GlobalOptions};
use crate::cli::select::Selection;
use crate::diagnostics::{Diagnostic, codes, json, sarif};
use crate::engine::files;
use crate::order::picture::names;
use crate::order::program::{Checked, Violation, check};
use crate::order::supervisor::Supervisor;
use crate::source::SourceMap;
use clap::Args;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::Path;

/// The arguments of `order check`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright order check examples/pick-and-place/intended.txt
    linewright order check examples/pick-and-place/intended.txt --rules examples/pick-and-place/unit.lw --level reasonable

    $ linewright order check examples/pick-and-place/crash.csv

A program is a text file with a call a line: a skill, or `Left & Down` for skills that are called at once. What follows # or // \
is a comment.

In a .csv file the skills of a row stand in its cells and are called at once. Where other columns stand beside them, the first row is \
a header with a column `skill`, and a column `step` where rows with the same step, one behind the other, are one call. Steps do not \
come again, and their numbers do not go back.

Exit code 1 where a program is refused, 2 where one cannot be read.")]
pub struct Arguments {
    /// Programs to check
    #[arg(required = true, value_name = "PROGRAM")]
    pub programs: Vec<String>,
    /// The rules [default: the one file beside the program that declares skills]
    #[arg(long, value_name = "FILE[::NAME]")]
    pub rules: Option<Selection>,
    /// Refuse a program that ends in the middle of a sequence
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
    programs: Vec<Entry>,
}

/// Verdict on a program.
#[derive(Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum ProgramVerdict {
    /// The program keeps the orders.
    Accepted,
    /// A call violates an order, or the program ends too early.
    Refused,
    /// The program could not be read.
    Invalid,
}

#[derive(Serialize)]
struct Entry {
    file: String,
    verdict: ProgramVerdict,
    calls: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    violation: Option<ViolationEntry>,
    #[serde(skip_serializing_if = "Option::is_none")]
    completion: Option<Vec<Vec<String>>>,
    findings: Vec<json::Finding>,
}

#[derive(Serialize)]
struct ViolationEntry {
    step: usize,
    call: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rule: Option<String>,
    why: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    detour: Option<Vec<Vec<String>>>,
    instead: Vec<Vec<String>>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> Outcome {
    // Each is read once, since it may be a pipe.
    let programs: Vec<(&str, Read)> = arguments
        .programs
        .iter()
        .map(|name| (name.as_str(), read(name)))
        .collect();
    let selection = match &arguments.rules {
        Some(rules) => rules.clone(),
        None => beside(&programs, options)?,
    };
    let mut chosen = rules::choose("order-check", &selection, &arguments.choice, options)?;
    let too_large = EarlyExit::gave_up(Some("fewer skills in one call"));
    let mut entries = Vec::new();
    let mut text = String::new();
    let mut all = Vec::new();
    let mut code = ExitCode::Success;
    for (name, read) in programs {
        let (entry, told, findings) =
            one(name, read, &mut chosen, arguments).map_err(&too_large)?;
        if entry.verdict == ProgramVerdict::Invalid {
            code = code.and(ExitCode::CannotRun);
        }
        code = code.and(options.exit_code(&findings));
        text += &told;
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

/// The text of a program, or why it cannot be read.
type Read = Result<String, Box<Diagnostic>>;

fn read(name: &str) -> Read {
    files::read(Path::new(name)).map_err(|why| {
        let message = format!("{name} cannot be read: {why}");
        let finding = Diagnostic::error(codes::FILE_UNREADABLE, None, message);
        Box::new(finding.with_help("give a file of calls in UTF-8: a skill a line"))
    })
}

/// The rules beside the first readable program. Without one, or without rules, unreadable programs
/// are reported here, since they may be the cause.
fn beside(programs: &[(&str, Read)], options: &GlobalOptions) -> Result<Selection, EarlyExit> {
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
    let found = rules::beside(first);
    if found.is_err() {
        options.console().findings(&sources, &unreadable)?;
    }
    Ok(found?)
}

type CheckedProgram = (Entry, String, Vec<Diagnostic>);

fn one(
    name: &str,
    read: Read,
    chosen: &mut Chosen,
    arguments: &Arguments,
) -> Result<CheckedProgram, crate::automata::bound::TooLarge> {
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
    let level = options.level.word();
    let calls = counted(program.calls.len());
    let mut findings = Vec::new();
    let mut told = String::new();
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
        findings.push(refused.with_help(way_out(violation, chosen)));
        entry.violation = Some(violation_entry(violation, chosen));
        let _ = writeln!(
            told,
            "{name}: refused at call {} of {} ({level})",
            violation.step + 1,
            program.calls.len()
        );
    } else {
        entry.verdict = ProgramVerdict::Accepted;
        let _ = writeln!(told, "{name}: accepted, {calls} ({level})");
        let completion = checked.completion.as_ref().ok().and_then(Option::as_ref);
        entry.completion = completion.map(|c| names(skills, c));
        let last = program.spans.last().copied();
        if let Some(open) = unfinished(&checked, chosen, arguments.whole, last) {
            if arguments.whole {
                entry.verdict = ProgramVerdict::Refused;
                told = format!("{name}: refused at its end ({level})\n");
            }
            findings.push(open);
        }
    }
    Ok((entry, told, findings))
}

fn counted(calls: usize) -> String {
    match calls {
        1 => "1 call".to_owned(),
        n => format!("{n} calls"),
    }
}

fn way_out(violation: &Violation, chosen: &Chosen) -> String {
    let skills = &chosen.skills;
    let call = violation.call.text(skills);
    let first = match &violation.detour {
        Ok(Some(detour)) if detour.is_empty() => String::new(),
        Ok(Some(detour)) => format!("call {} before it", words::calls(detour, skills)),
        Ok(None) => format!("`{call}` is never allowed after these calls"),
        Err(error) => format!("whether `{call}` is allowed later was not found out: {error}"),
    };
    match violation.instead.as_slice() {
        [] => format!("{first}; nothing may be called here"),
        instead => format!(
            "{first}; what may be called here is {}",
            words::calls(instead, skills)
        ),
    }
}

fn violation_entry(v: &Violation, chosen: &Chosen) -> ViolationEntry {
    let skills = &chosen.skills;
    let options = chosen.options;
    ViolationEntry {
        step: v.step + 1,
        call: names(skills, &[v.call]).remove(0),
        rule: words::rule(&v.refusal).map(|r| skills.rules[r].name.clone()),
        why: words::why(v.call, &v.refusal, skills, options.serialisation),
        detour: v
            .detour
            .as_ref()
            .ok()
            .and_then(Option::as_ref)
            .map(|d| names(skills, d)),
        instead: names(skills, &v.instead),
    }
}

/// Finding for a program that ends in the middle of a sequence.
fn unfinished(
    checked: &Checked,
    chosen: &Chosen,
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
        Err(error) => format!("what would complete it was not found out: {error}"),
        Ok(None) => "no calls complete it, since other rules are in the way".to_owned(),
    };
    Some(finding.with_label(rule.span, "this rule").with_help(help))
}
