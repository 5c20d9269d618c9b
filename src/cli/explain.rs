//! `linewright explain`: what a finding means.

use super::console::schema;
use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use crate::diagnostics::{codes, explanations};
use clap::Args;
use serde::Serialize;
use std::fmt::Write as _;

/// The arguments of `explain`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n    linewright explain LW203")]
pub struct Arguments {
    /// The code of a finding, such as LW203; without it, all codes are listed
    pub code: Option<String>,
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
    #[serde(skip_serializing_if = "Option::is_none")]
    page: Option<&'static str>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let entries: Vec<Entry> = match &arguments.code {
        None => codes::ALL.iter().map(|c| entry(*c, false)).collect(),
        Some(id) => match codes::find(id.trim()) {
            Some(code) => vec![entry(code, true)],
            None => anyhow::bail!(
                "`{id}` is no code of a finding: codes look like LW203; `linewright explain` lists them all"
            ),
        },
    };
    if options.format == Format::Json {
        console.document(&Document {
            schema: schema("explain"),
            codes: entries,
        })?;
        return Ok(ExitCode::Success);
    }
    let mut text = String::new();
    for entry in &entries {
        match entry.page {
            Some(page) => text.push_str(page),
            None => {
                let _ = writeln!(text, "{}  {}", entry.code, entry.title);
            }
        }
    }
    console.result(&text)?;
    Ok(ExitCode::Success)
}

fn entry(code: codes::Code, with_page: bool) -> Entry {
    Entry {
        code: code.id,
        title: code.title,
        page: explanations::page(code).filter(|_| with_page),
    }
}
