//! Output of results, findings and progress: results to standard output, everything else to
//! standard error.

use super::options::{Color, Format};
use crate::diagnostics::{Diagnostic, json, render, sarif};
use crate::source::SourceMap;
use anstream::{AutoStream, ColorChoice};
use anyhow::Context as _;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use schemars::JsonSchema;
use serde::Serialize;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether anything was printed to standard output.
static PRINTED: AtomicBool = AtomicBool::new(false);

/// Writes to standard output and standard error in the requested format.
#[derive(Debug, Clone, Copy)]
pub struct Console {
    /// Format of results and findings.
    pub format: Format,
    color: ColorChoice,
}

/// The JSON document of a command that ended without a result.
#[derive(JsonSchema, Serialize)]
pub(super) struct Failed {
    schema: String,
    /// The findings that prevented a result.
    findings: Vec<json::Finding>,
}

impl Console {
    /// Creates a console. With `Color::Auto`, a stream is colored if it is a terminal and neither
    /// `NO_COLOR` nor `CLICOLOR` disables colors.
    pub fn new(format: Format, color: Color) -> Self {
        let color = match color {
            Color::Auto => ColorChoice::Auto,
            Color::Always => ColorChoice::Always,
            Color::Never => ColorChoice::Never,
        };
        Self { format, color }
    }

    /// Prints a result. A closed pipe is not an error, so that the exit code still shows the
    /// verdict.
    pub fn result(&self, text: &str) -> anyhow::Result<()> {
        self.part(text).map(|_| ())
    }

    /// Prints one part of a longer result. Returns false if the reader has closed the output.
    pub fn part(&self, text: &str) -> anyhow::Result<bool> {
        PRINTED.store(true, Ordering::Relaxed);
        let mut out = AutoStream::new(io::stdout(), self.color);
        still_open(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
            .context("standard output cannot be written")
    }

    /// Prints one of many JSON documents on a single line. Returns false if the reader has closed
    /// the output.
    pub fn line(&self, document: &impl Serialize) -> anyhow::Result<bool> {
        let mut text = serde_json::to_string(document)?;
        text.push('\n');
        self.part(&text)
    }

    /// Prints a result as indented JSON, ending with a line break.
    pub fn document(&self, document: &impl Serialize) -> anyhow::Result<()> {
        let mut text = serde_json::to_string_pretty(document)?;
        text.push('\n');
        self.result(&text)
    }

    /// Prints a remark to standard error.
    pub fn remark(&self, text: &str) -> anyhow::Result<()> {
        let mut err = AutoStream::new(io::stderr(), self.color);
        still_open(err.write_all(text.as_bytes())).context("standard error cannot be written")?;
        Ok(())
    }

    /// Formats the findings as text, `human` or `short`.
    pub fn render(&self, sources: &SourceMap, findings: &[Diagnostic]) -> String {
        if self.format == Format::Short {
            render::short(sources, findings)
        } else {
            render::human(sources, findings)
        }
    }

    /// Prints findings to standard error, in addition to a result.
    pub fn findings(&self, sources: &SourceMap, findings: &[Diagnostic]) -> anyhow::Result<()> {
        self.remark(&self.render(sources, findings))
    }

    /// Prints the findings of a command without a result: as text to standard error, or as the JSON
    /// or SARIF document on standard output.
    pub fn failed(
        &self,
        command: &str,
        sources: &SourceMap,
        findings: &[Diagnostic],
    ) -> anyhow::Result<()> {
        match self.format {
            Format::Human | Format::Short => self.findings(sources, findings),
            Format::Json => self.document(&Failed {
                schema: schema(command),
                findings: json::findings(sources, findings),
            }),
            Format::Sarif => self.document(&sarif::document(sources, findings)),
        }
    }

    /// Reports the finding with which a command was aborted: as [`Console::failed`] does, or to
    /// standard error if something was already printed to standard output.
    pub fn aborted(&self, command: &str, finding: &Diagnostic) -> anyhow::Result<()> {
        let sources = SourceMap::default();
        if PRINTED.load(Ordering::Relaxed) {
            return self.remark(&render::human(&sources, std::slice::from_ref(finding)));
        }
        self.failed(command, &sources, std::slice::from_ref(finding))
    }

    /// A progress bar over `count` items, shown only if standard error is a terminal.
    pub fn progress(&self, count: usize, verb: &'static str) -> ProgressBar {
        let bar = ProgressBar::with_draw_target(Some(count as u64), ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("{prefix} {wide_bar} {pos}/{len} {msg}") {
            bar.set_style(style);
        }
        bar.with_prefix(verb)
    }
}

/// The `schema` field of a command's document.
pub fn schema(command: &str) -> String {
    format!("linewright/{command}/1")
}

/// A count of something: `1 step`, or `21 steps`.
pub fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

/// Converts the result of a write: false if the reader has closed the output.
fn still_open(result: io::Result<()>) -> io::Result<bool> {
    match result {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(false),
        other => other.map(|()| true),
    }
}
