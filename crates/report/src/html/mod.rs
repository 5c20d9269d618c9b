//! A run as a page of HTML: one file, which asks no network for anything.
//!
//! Text, tables and small charts are written here, as HTML and SVG. A script that is part of the
//! page plays the run in the picture of the line, and draws the chart of the stations on a canvas,
//! since they show hundreds of thousands of events. What it needs is in the page as compressed
//! columns of numbers.

mod charts;
mod data;
mod numbers;
mod packed;
mod picture;
mod recorder;
mod sections;
mod series;
#[cfg(test)]
mod tests;

use super::{Intervals, Variant};
use linewright_core::diagnostics::Diagnostic;
use linewright_core::source::SourceMap;
use linewright_language::contract::line::Line;
use linewright_line::Trace;
use linewright_line::comparison::Comparison;
use linewright_line::log::Activity;
use maud::{DOCTYPE, PreEscaped, html};
use picture::Picture;
pub use recorder::Recorder;
use std::collections::BTreeMap;

/// What a page shows.
#[derive(Debug)]
pub struct Page<'a> {
    /// The line that was run.
    pub line: &'a Line,
    /// All runs, at least one. The page shows the first.
    pub traces: &'a [Trace],
    /// What the confidence intervals come from, if there are some.
    pub intervals: Option<Intervals<'a>>,
    /// The recorder that watched the first run.
    pub recorder: &'a Recorder,
    /// The variant that the line was compared with.
    pub comparison: Option<Compared<'a>>,
    /// The files of the line.
    pub sources: &'a SourceMap,
    /// Numbers that were set for the run, by name.
    pub set: &'a BTreeMap<&'a str, &'a str>,
    /// Command that makes the run again.
    pub command: &'a str,
    /// Version of the program.
    pub version: &'a str,
    /// The findings of the run.
    pub findings: &'a [Diagnostic],
}

/// A variant, and how it differs from the line as it is.
#[derive(Debug, Clone, Copy)]
pub struct Compared<'a> {
    /// What differs.
    pub variant: &'a Variant,
    /// Its runs, with the seeds of those of the line.
    pub traces: &'a [Trace],
    /// The measures of both.
    pub comparisons: &'a [Comparison],
}

/// Returns the page. It is the same for the same run.
pub fn page(page: &Page<'_>) -> String {
    let picture = Picture::new(page.line);
    let title = format!("{}, a simulated line", page.line.name);
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(include_str!("page.css"))) }
            }
            body {
                (sections::all(page, &picture))
                script #data type="application/json" { (PreEscaped(data::json(page, &picture))) }
                script { (PreEscaped(include_str!("page.js"))) }
            }
        }
    };
    markup.into_string()
}

/// The class of the style sheet for a state of a station.
fn state_class(state: Activity) -> &'static str {
    match state {
        Activity::Busy => "busy",
        Activity::Starved => "starved",
        Activity::Blocked => "blocked",
        Activity::Failed | Activity::FailedOffShift => "failed",
        Activity::Idle => "idle",
        Activity::Setup => "setup",
    }
}
