//! A run as a page.
//!
//! A script plays the run in the picture of the line, and draws the chart of the stations on a
//! canvas, since they show hundreds of thousands of events. What it needs is in the page as
//! compressed columns of numbers.

mod charts;
mod data;
mod moments;
mod packed;
mod picture;
mod recorder;
mod sections;
mod series;
#[cfg(test)]
mod tests;

use super::parts::Origin;
use super::{Document, document};
use crate::{Intervals, Variant};
use linewright_language::contract::line::Line;
use linewright_line::Trace;
use linewright_line::comparison::Comparison;
use linewright_line::log::Activity;
use moments::Moments;
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
    /// The variants that the line was compared with.
    pub comparisons: &'a [Compared<'a>],
    /// Numbers that were set for the run, by name.
    pub set: &'a BTreeMap<&'a str, &'a str>,
    /// Where the run comes from.
    pub origin: Origin<'a>,
}

impl Page<'_> {
    /// The axis of all charts over time.
    fn axis(&self) -> charts::TimeAxis {
        let stations = self.traces[0].stations.iter();
        let names = stations.map(|station| station.name.as_str());
        let moments = Moments::of(self.line);
        charts::TimeAxis::new(names, self.recorder.end, self.recorder.counting, moments)
    }
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
    document(&Document {
        title: &title,
        style: include_str!("run.css"),
        body: &sections::all(page, &picture),
        data: Some(&data::json(page, &picture)),
        script: include_str!("page.js"),
    })
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
