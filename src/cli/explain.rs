//! `linewright explain`: the meaning of a finding.

use super::console::schema;
use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use crate::diagnostics::{Code, codes, explanations, sarif};
use clap::Args;
use serde::Serialize;
use std::fmt::Write as _;

/// The arguments of `explain`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright explain LW203
    linewright explain --list")]
pub struct Arguments {
    /// The code of a finding, such as LW203; without it, all codes are listed
    pub code: Option<String>,
    /// List all codes, by what they are about
    #[arg(long, conflicts_with = "code")]
    pub list: bool,
}

#[derive(Serialize)]
struct Document {
    schema: String,
    codes: Vec<Entry>,
}

#[derive(Serialize)]
struct Entry {
    code: &'static str,
    title: &'static str,
    group: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    page: Option<&'static str>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let one = match &arguments.code {
        None => None,
        Some(id) => Some(codes::find(id.trim()).ok_or_else(|| unknown(id))?),
    };
    let shown = one.as_ref().map_or(codes::ALL, std::slice::from_ref);
    match options.format {
        Format::Json => console.document(&Document {
            schema: schema("explain"),
            codes: shown.iter().map(|c| entry(*c, one.is_some())).collect(),
        })?,
        // No findings, but the rules that findings of other commands refer to.
        Format::Sarif => console.document(&sarif::catalogue(shown))?,
        Format::Human | Format::Short => {
            let text = match one {
                Some(code) => explanations::page(code).unwrap_or_default().to_owned(),
                None => list(),
            };
            console.result(&text)?;
        }
    }
    Ok(ExitCode::Success)
}

fn unknown(id: &str) -> anyhow::Error {
    anyhow::anyhow!(
        "`{id}` is no code of a finding: codes look like LW203; `linewright explain --list` shows them all"
    )
}

/// All codes with their titles, group by group.
fn list() -> String {
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
