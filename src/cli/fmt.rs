//! `linewright fmt`: formats `.lw` files in the standard layout.
//!
//! A file is written only if its text changes, and only after [`format::format_checked`] has parsed
//! the new text and confirmed that it has the same meaning. A different meaning is reported as a
//! fault of linewright, and the file is left unchanged.

use super::console;
use super::console::Console;
use super::exit::ExitCode;
use super::options::{Format, GlobalOptions};
use crate::cli::console::Failed;
use crate::cli::schema::{Described, form};
use crate::deadline::{Deadline, StopReason};
use crate::diagnostics::{Diagnostic, json};
use crate::engine::files;
use crate::engine::output;
use crate::source::SourceMap;
use crate::syntax::{format, parse};
use anyhow::Context as _;
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Read as _;
use std::path::Path;

/// Name shown for standard input.
const STANDARD_INPUT: &str = "<stdin>";

/// The arguments of `fmt`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
    linewright fmt contracts
    linewright fmt --check examples
    linewright fmt - < contracts/handling/turn.lw

A file is rewritten only if that changes it. Comments, line breaks at operators, single empty \
lines, line endings and a byte-order mark are kept; operators become words (`&&` becomes `and`). \
A file that does not parse is left unchanged (exit code 2). With --check, no file is written, and the exit \
code is 1 if formatting would change any file.")]
pub struct Arguments {
    /// Files, folders (all .lw files in them), or `-` for standard input
    #[arg(value_name = "PATH", default_value = ".")]
    pub paths: Vec<String>,
    /// Show what would change, and write nothing
    #[arg(long)]
    pub check: bool,
}

/// Describes the JSON document that the command prints.
pub const DOCUMENT: Described = Described::new(
    "fmt",
    "Which files were formatted",
    &[form::<Document>, form::<Failed>],
);

/// The JSON document of the command.
#[derive(JsonSchema, Serialize)]
struct Document {
    schema: String,
    /// The files that could be parsed.
    files: Vec<Entry>,
    /// All findings.
    findings: Vec<json::Finding>,
}

/// Result for one file.
#[derive(JsonSchema, Serialize)]
struct Entry {
    /// The name of the file.
    file: String,
    /// Whether formatting changes the file; with `--check`, whether it would change the file.
    changed: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments, options: &GlobalOptions) -> anyhow::Result<ExitCode> {
    let console = options.console();
    let standard_input = arguments.paths == ["-"];
    if !standard_input && arguments.paths.iter().any(|p| p == "-") {
        anyhow::bail!(
            "`-` is standard input and must be the only path; write `./-` for a file of that name"
        );
    }
    let read = if standard_input {
        let mut text = String::new();
        std::io::stdin()
            .read_to_string(&mut text)
            .context("standard input cannot be read")?;
        vec![Ok((STANDARD_INPUT.to_owned(), text))]
    } else {
        files::read_all(&arguments.paths)
    };
    let mut work = Work {
        sources: SourceMap::default(),
        findings: Vec::new(),
        code: ExitCode::Success,
        deadline: options.limits().deadline,
    };
    let mut entries = Vec::new();
    let mut result = String::new();
    for file in read {
        let (name, text) = match file {
            Ok(file) => file,
            Err(finding) => {
                work.finding(finding);
                continue;
            }
        };
        let formatted = match work.format(&name, &text) {
            Ok(Some(formatted)) => formatted,
            Ok(None) => continue,
            Err(late) => {
                work.give_up(&name, late);
                break;
            }
        };
        let changed = formatted != text;
        if arguments.check {
            if changed {
                let _ = writeln!(result, "{name} is not formatted");
                result.push_str(&difference(&text, &formatted));
                work.code = work.code.and(ExitCode::Findings);
            }
        } else if standard_input {
            result.push_str(&formatted);
        } else if changed {
            match output::rewrite(Path::new(&name), &formatted) {
                Ok(()) => {
                    let _ = writeln!(result, "formatted {name}");
                }
                Err(finding) => {
                    work.finding(*finding);
                    continue;
                }
            }
        }
        entries.push(Entry {
            file: name,
            changed,
        });
    }
    work.print(
        console,
        entries,
        &result,
        standard_input && !arguments.check,
    )?;
    Ok(work.code)
}

/// State of the command while it formats files.
struct Work {
    sources: SourceMap,
    findings: Vec<Diagnostic>,
    code: ExitCode,
    deadline: Deadline,
}

impl Work {
    fn finding(&mut self, finding: Diagnostic) {
        self.findings.push(finding);
        self.code = self.code.and(ExitCode::CannotRun);
    }

    fn give_up(&mut self, name: &str, late: StopReason) {
        let finding = Diagnostic::error(
            crate::diagnostics::codes::GAVE_UP,
            None,
            format!("{name} and the files after it were not formatted: {late}"),
        );
        self.findings.push(finding.with_help(late.remedy()));
        self.code = self.code.and(ExitCode::GaveUp);
    }

    /// Formats a file; `None` if it does not parse.
    ///
    /// # Errors
    /// The deadline has passed. Parsing is not interrupted, so this can be noticed late.
    fn format(&mut self, name: &str, text: &str) -> Result<Option<String>, StopReason> {
        self.deadline.check()?;
        let file = self.sources.add(name, text);
        let (tree, findings) = parse(file, text);
        if !findings.is_empty() {
            for finding in findings {
                self.finding(finding);
            }
            return Ok(None);
        }
        self.deadline.check()?;
        Ok(match format::format_checked(&tree, text) {
            Ok(formatted) => Some(formatted),
            Err(fault) => {
                let finding = Diagnostic::error(
                    crate::diagnostics::codes::SYNTAX,
                    None,
                    format!("{name} was left unchanged: {fault}"),
                );
                self.finding(finding.with_help(format!(
                    "this is a fault of linewright {}: please report it, with the file",
                    env!("CARGO_PKG_VERSION")
                )));
                None
            }
        })
    }

    fn print(
        &self,
        console: Console,
        files: Vec<Entry>,
        result: &str,
        text: bool,
    ) -> anyhow::Result<()> {
        match console.format {
            Format::Json if !text => console.document(&Document {
                schema: console::schema("fmt"),
                files,
                findings: json::findings(&self.sources, &self.findings),
            }),
            Format::Sarif if !text => console.failed("fmt", &self.sources, &self.findings),
            _ => {
                console.result(result)?;
                console.findings(&self.sources, &self.findings)
            }
        }
    }
}

/// Lists the differing lines with their numbers, at most 20 lines.
fn difference(before: &str, after: &str) -> String {
    const MAX_LINES: usize = 20;
    let (old, new): (Vec<&str>, Vec<&str>) = (before.lines().collect(), after.lines().collect());
    let mut text = String::new();
    let (mut i, mut j, mut shown) = (0, 0, 0);
    while i < old.len() || j < new.len() {
        if old.get(i) == new.get(j) {
            (i, j) = (i + 1, j + 1);
            continue;
        }
        // Skips to the nearest position from which both continue alike.
        let (a, b) = rejoin(&old[i..], &new[j..]);
        for (sign, lines, first) in [('-', &old[i..i + a], i), ('+', &new[j..j + b], j)] {
            for (n, line) in lines.iter().enumerate() {
                if shown == MAX_LINES {
                    text.push_str("  ...\n");
                    return text;
                }
                let _ = writeln!(text, "{:>5} {sign} {line}", first + n + 1);
                shown += 1;
            }
        }
        (i, j) = (i + a, j + b);
    }
    if text.is_empty() {
        text.push_str("  only line endings differ\n");
    }
    text
}

/// Numbers of lines to skip in both texts until they continue with the same line.
fn rejoin(old: &[&str], new: &[&str]) -> (usize, usize) {
    const MAX_SKIPPED: usize = 200;
    for sum in 1..=MAX_SKIPPED.min(old.len() + new.len()) {
        for a in 0..=sum.min(old.len()) {
            let b = sum - a;
            if b <= new.len() && old.get(a) == new.get(b) {
                return (a, b);
            }
        }
    }
    (old.len(), new.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_shown_line_by_line() {
        assert_eq!(
            difference("a\nb\nc\n", "a\nx\ny\nc\n"),
            "    2 - b\n    2 + x\n    3 + y\n"
        );
        assert_eq!(difference("a\n\n\nb\n", "a\n\nb\n"), "    3 - \n");
        assert_eq!(difference("a", "a\n"), "  only line endings differ\n");
    }
}
