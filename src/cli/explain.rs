//! `linewright explain`: explains findings, constructs of the language and commands.

mod topics;

use super::console::schema;
use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use crate::cli::console::Failed;
use crate::cli::schema::{Described, form};
use crate::diagnostics::{Code, codes, explanations, nearest, sarif};
use clap::{Args, Command};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;
use topics::Topic;

/// The arguments of `explain`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright explain LW203
    linewright explain buffer
    linewright explain 'order check'
    linewright explain --list")]
pub struct Arguments {
    /// The code of a finding (LW203), a construct of the language (buffer) or a command (check); if
    /// omitted, all topics are listed
    pub topic: Option<String>,
    /// List all findings, constructs and commands
    #[arg(long, conflicts_with = "topic")]
    pub list: bool,
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "explain",
    "Explanations of findings, constructs of the language and commands",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document {
    schema: String,
    /// The codes.
    codes: Vec<Entry>,
    /// Constructs of the language and commands; absent if only codes are explained.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    topics: Vec<Topic>,
}

/// A code with its explanation.
#[derive(JsonSchema, Serialize)]
struct Entry {
    /// The code, such as `LW203`.
    code: &'static str,
    /// The title of the explanation.
    title: &'static str,
    /// The title of the group to which the code belongs.
    group: &'static str,
    /// The explanation, in Markdown; absent in a list of all codes.
    #[serde(skip_serializing_if = "Option::is_none")]
    page: Option<&'static str>,
}

/// Runs the command. `program` is the definition of the command line, from which the pages of
/// commands are generated.
pub fn run(
    arguments: &Arguments,
    options: &GlobalOptions,
    program: &Command,
) -> anyhow::Result<ExitCode> {
    let topics = topics::all(program);
    match &arguments.topic {
        None => {
            let topics = topics.into_iter().map(Topic::without_page).collect();
            show(options, codes::ALL, topics, true)
        }
        Some(name) => {
            if let Some(code) = codes::find(name.trim()) {
                return show(options, &[code], Vec::new(), false);
            }
            let name = name.split_whitespace().collect::<Vec<_>>().join(" ");
            let unknown = unknown(&name, &topics);
            let found = topics::find(topics, &name);
            anyhow::ensure!(!found.is_empty(), unknown);
            show(options, &[], found, false)
        }
    }
}

/// Prints codes and topics: only their names with `as_list`, their pages otherwise.
fn show(
    options: &GlobalOptions,
    codes: &[Code],
    topics: Vec<Topic>,
    as_list: bool,
) -> anyhow::Result<ExitCode> {
    let console = options.console();
    match options.format {
        Format::Json => console.document(&Document {
            schema: schema("explain"),
            codes: codes.iter().map(|c| entry(*c, !as_list)).collect(),
            topics,
        })?,
        // The document has no findings, only the rules to which findings of other commands refer.
        Format::Sarif => console.document(&sarif::catalogue(codes))?,
        Format::Human | Format::Short if as_list => console.result(&list(&topics))?,
        Format::Human | Format::Short => {
            let findings = codes.iter().filter_map(|c| explanations::page(*c));
            let others = topics.iter().map(|topic| topic.page.as_str());
            let pages: Vec<&str> = findings.chain(others).collect();
            console.result(&pages.join("\n"))?;
        }
    }
    Ok(ExitCode::Success)
}

fn unknown(name: &str, topics: &[Topic]) -> String {
    let codes = codes::ALL.iter().map(|code| code.id);
    let near = nearest(name, topics::names(topics).chain(codes));
    let near = near.map_or(String::new(), |near| format!("did you mean `{near}`? "));
    format!(
        "there is no topic `{name}`: {near}`linewright explain --list` lists all findings, constructs and commands"
    )
}

/// All codes with their titles, group by group, and all topics.
fn list(topics: &[Topic]) -> String {
    let mut text = String::new();
    for group in codes::GROUPS {
        if !text.is_empty() {
            text.push('\n');
        }
        let _ = writeln!(text, "{}  {}", group.pattern, group.title);
        for code in group.codes() {
            let _ = writeln!(text, "  {}  {}", code.id, code.title);
        }
    }
    text.push('\n');
    for topic in topics {
        let _ = writeln!(text, "{}", topic.line());
    }
    text
}

fn entry(code: Code, with_page: bool) -> Entry {
    Entry {
        code: code.id,
        title: code.title,
        group: code.group().title,
        page: explanations::page(code).filter(|_| with_page),
    }
}
